//! What can be chosen about a reconstruction, with the paper's values where it gives them.

use crate::error::{Error, Result};

/// How thick a limb is toward the viewer, where a single view shows only its width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CrossSection {
    /// Depth over width.
    Ratio {
        /// Of body, neck, head, tail.
        middle: f32,
        /// Of legs and other limbs of a pair.
        paired: f32,
    },
    /// The paper's ellipse: the mean of the mean radius and of the mean radius shrunk by the ratio of the two sides'
    /// radii (Reinert 2016, figure 8 d). It flattens limbs whose stroke runs along their border.
    Paper,
}

/// How far the two legs of a pair stand from the middle plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LegSpread {
    /// As far as the body they hang from is wide: the larger of `body` times its half depth and of `leg` times the
    /// leg's own radius.
    BodyWidth {
        /// Share of the body's half depth.
        body: f32,
        /// Share of the leg's mean radius in its lower half.
        leg: f32,
    },
    /// The paper's rule: this many times the leg's mean radius in its lower half (4 in Reinert 2016, section 3.7.2).
    Radii(f32),
}

/// What covers the limbs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Surface {
    /// One connected, closed skin that follows the silhouettes.
    #[default]
    Skin,
    /// A closed tube around each limb, with a texture each (Reinert 2016).
    Tubes,
}

/// Parameters of [`super::reconstruct`]. Lengths are in pixels of a 512-pixel clip (the paper's working size) and
/// scale with the clip.
#[derive(Clone, Debug, PartialEq)]
pub struct CreatureParams {
    /// Strokes are lengthened at both ends by this share, for limbs drawn too short. Paper: 0.1.
    pub extension: f32,
    /// Radius votes below this are noise. Paper: 3 px.
    pub min_vote: f32,
    /// Share of the radius votes that lie below the radius taken. Paper: 0.25.
    pub percentile: f32,
    /// Neighbours on each side whose votes count as well. Paper: 2.
    pub neighbours: usize,
    /// Where more than this share of the votes was rejected, there is no measured radius. Paper: 0.9.
    pub max_rejected: f32,
    /// Standard deviation of the radius smoothing as a share of the limb's length. Paper: 0.1.
    pub smoothing: f32,
    /// Depth of limbs that have no entry in `depths`.
    pub cross_section: CrossSection,
    /// Depth over width of single limbs, by label.
    pub depths: Vec<(String, f32)>,
    /// Distance of pairs.
    pub leg_spread: LegSpread,
    /// What that distance is multiplied by.
    pub spread: f32,
    /// A limb shorter than this share of its longest projection points out of the image plane. Paper: 0.5.
    pub foreshortened: f32,
    /// How often the tracked axes are moved into the middle of their limbs' pixels. Paper: 0.
    pub settling_rounds: u32,
    /// How stiffly a limb bends while it settles, for a limb of a hundred samples 2 px apart: the weight of a pixel of
    /// shift between neighbours against a pixel off the middle.
    pub settling_stiffness: f32,
    /// What covers the limbs.
    pub surface: Surface,
    /// Whether to cover what tubes miss of the rest frame's mask (ears, hooves, a rump) by inflated patches.
    pub fill_silhouette: bool,
    /// Size of the patches' triangles, in pixels of a 512-pixel clip.
    pub patch_step: f32,
    /// About how many triangles a skin has; a creature of few pixels gets fewer.
    pub skin_triangles: usize,
    /// Vertices around a limb's tube.
    pub around: usize,
    /// Largest number of bones of a limb.
    pub max_bones: usize,
    /// Longest side of a part's texture in pixels.
    pub max_texture: u32,
    /// Most frames that give colours ([`super::texturing`]). 1: those of the first key frame alone. Paper: 1.
    pub texture_views: usize,
}

impl Default for CreatureParams {
    fn default() -> Self {
        Self {
            extension: 0.1,
            min_vote: 3.0,
            percentile: 0.5,
            neighbours: 2,
            max_rejected: 0.9,
            smoothing: 0.04,
            cross_section: CrossSection::Ratio { middle: 0.9, paired: 1.0 },
            depths: Vec::new(),
            leg_spread: LegSpread::BodyWidth { body: 0.6, leg: 1.3 },
            spread: 1.0,
            foreshortened: 0.5,
            settling_rounds: 3,
            settling_stiffness: 25.0,
            surface: Surface::Skin,
            fill_silhouette: true,
            patch_step: 1.5,
            skin_triangles: 24_000,
            around: 20,
            max_bones: 8,
            max_texture: 1024,
            texture_views: 64,
        }
    }
}

impl CreatureParams {
    /// Depths of single limbs from text: `body=0.8,tail=1.2`.
    ///
    /// # Errors
    /// Something between commas that is no label, equals sign and ratio between 0.05 and 20.
    pub fn depths_from(text: &str) -> Result<Vec<(String, f32)>> {
        let depth = |entry: &str| {
            let (label, ratio) = entry.rsplit_once('=')?;
            let ratio = ratio.trim().parse().ok().filter(|r| (0.05..=20.0).contains(r))?;
            (!label.trim().is_empty()).then(|| (label.trim().to_owned(), ratio))
        };
        let entries = text.split(',').filter(|entry| !entry.trim().is_empty());
        let read = |entry: &str| {
            depth(entry).ok_or_else(|| {
                let remedy = "give LABEL=RATIO, a ratio of depth to width from 0.05 to 20";
                Error::invalid("depths", format!("`{entry}` is none"), remedy)
            })
        };
        entries.map(read).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_are_read_from_text() {
        let depths = CreatureParams::depths_from(" body = 0.8,left=leg=2,").expect("depths");
        assert_eq!(depths, [("body".to_owned(), 0.8), ("left=leg".to_owned(), 2.0)]);
        assert!(CreatureParams::depths_from("").expect("none").is_empty());
        for bad in ["body", "body=", "=1", "body=nan", "body=0", "body=99"] {
            assert!(CreatureParams::depths_from(bad).is_err(), "{bad}");
        }
    }
}
