//! Tracks against known limb axes or joints.
//!
//! Rendered clips know every limb's axis: both curves are resampled to 21 points by arc length in every frame that is
//! no key frame; PCK05 is the share of points within 5 % of the limb's longest length. Filmed clips know joints on some
//! frames: a joint is right within 0.2 (PCK20) or 0.05 (PCK05) of the square root of the mask's area, the protocol of
//! BADJA (Biggs et al. 2018); its place on a stroke is its arc-length share where it was drawn.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context as _, Result};
use glam::Vec2;
use marey::geometry::polyline;
use marey::motion::Motion;
use serde::Deserialize;

/// What is known of a clip.
#[derive(Deserialize)]
#[serde(untagged)]
pub enum Truth {
    /// Every limb's axis in every frame.
    Axes {
        /// How many frames.
        frames: usize,
        /// By label.
        limbs: BTreeMap<String, Axis>,
    },
    /// Named joints on some frames.
    Joints {
        /// By frame, then by name.
        frames: BTreeMap<String, BTreeMap<String, Vec2>>,
    },
}

/// A limb's axis over time.
#[derive(Deserialize)]
pub struct Axis {
    /// For each frame the points: x, y and, where known, z.
    pub axis: Vec<Vec<Vec<f32>>>,
}

impl Axis {
    /// The axis in `frame`, in the image plane.
    pub fn plane(&self, frame: usize) -> Vec<Vec2> {
        self.axis[frame].iter().map(|p| Vec2::new(p[0], p[1])).collect()
    }
}

/// How well limbs were tracked.
#[derive(Clone, Debug)]
pub struct TrackScore {
    /// As [`Self::pck05`], within a fiftieth.
    pub pck02: f64,
    /// Per cent of points within a twentieth of the limb's length, or of the creature's size.
    pub pck05: f64,
    /// Per cent of joints within a fifth of the creature's size; only on filmed clips.
    pub pck20: Option<f64>,
    /// Mean distance in pixels.
    pub mean_px: f64,
    /// How well low confidence finds large errors: the area under the ROC curve of "outside PCK05" against
    /// 1 - confidence; 0.5 says nothing, 1 is perfect. Only on rendered clips.
    pub confidence_auc: Option<f64>,
}

#[derive(Deserialize)]
struct Strokes {
    keyframes: Vec<Key>,
}

#[derive(Deserialize)]
struct Key {
    frame: usize,
    strokes: Vec<Drawn>,
}

#[derive(Deserialize)]
struct Drawn {
    limb: String,
    points: Vec<Vec2>,
    #[serde(default)]
    joints: Vec<String>,
}

/// Scores `motion`, tracked from `strokes`. `mask_dir` holds the true masks; filmed clips need them.
pub fn tracks(motion: &Motion, truth: &Truth, strokes: &Path, mask_dir: &Path) -> Result<TrackScore> {
    let text = std::fs::read_to_string(strokes).with_context(|| strokes.display().to_string())?;
    let strokes: Strokes = serde_json::from_str(&text)?;
    let keys: BTreeSet<usize> = strokes.keyframes.iter().map(|k| k.frame).collect();
    match truth {
        Truth::Axes { frames, limbs } => Ok(against_axes(motion, *frames, limbs, &keys)),
        Truth::Joints { frames } => against_joints(motion, frames, &strokes, &keys, mask_dir),
    }
}

fn against_axes(motion: &Motion, frames: usize, limbs: &BTreeMap<String, Axis>, keys: &BTreeSet<usize>) -> TrackScore {
    const SAMPLES: usize = 21;
    let (mut errors, mut exact, mut right, mut doubt) = (Vec::new(), 0usize, 0usize, Vec::new());
    for (label, axis) in limbs {
        let longest = (0..frames).map(|f| polyline::length(&axis.plane(f))).fold(0.0, f32::max);
        for f in (0..frames).filter(|f| !keys.contains(f)) {
            let Some(track) = motion.track(label) else {
                errors.extend([1000.0; SAMPLES]);
                continue;
            };
            let found = &track.frames[f];
            let pairs =
                polyline::resample(&found.points, SAMPLES).into_iter().zip(polyline::resample(&axis.plane(f), SAMPLES));
            for (i, (p, q)) in pairs.enumerate() {
                let error = p.distance(q);
                let wrong = error >= 0.05 * longest;
                let nearest = i * (found.points.len() - 1) / (SAMPLES - 1);
                doubt.push((1.0 - found.confidence[nearest], wrong));
                right += usize::from(!wrong);
                exact += usize::from(error < 0.02 * longest);
                errors.push(f64::from(error));
            }
        }
    }
    TrackScore {
        pck02: 100.0 * exact as f64 / errors.len() as f64,
        pck05: 100.0 * right as f64 / errors.len() as f64,
        pck20: None,
        mean_px: errors.iter().sum::<f64>() / errors.len() as f64,
        confidence_auc: auc(doubt),
    }
}

/// The chance that a wrong point is doubted more than a right one; ties count half.
fn auc(mut doubt: Vec<(f32, bool)>) -> Option<f64> {
    doubt.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wrong = doubt.iter().filter(|d| d.1).count() as f64;
    let right = doubt.len() as f64 - wrong;
    let (mut below, mut won) = (0.0, 0.0);
    for tied in doubt.chunk_by(|a, b| a.0 == b.0) {
        let bad = tied.iter().filter(|d| d.1).count() as f64;
        let good = tied.len() as f64 - bad;
        won += bad * (below + good / 2.0);
        below += good;
    }
    (wrong > 0.0 && right > 0.0).then(|| won / (wrong * right))
}

fn against_joints(
    motion: &Motion,
    truth: &BTreeMap<String, BTreeMap<String, Vec2>>,
    strokes: &Strokes,
    keys: &BTreeSet<usize>,
    mask_dir: &Path,
) -> Result<TrackScore> {
    let mut place: BTreeMap<&str, (&str, f32)> = BTreeMap::new();
    for drawn in strokes.keyframes.iter().flat_map(|k| &k.strokes) {
        let total = polyline::length(&drawn.points).max(1e-9);
        for (i, joint) in drawn.joints.iter().enumerate() {
            let share = polyline::length(&drawn.points[..=i]) / total;
            place.entry(joint).or_insert((&drawn.limb, share));
        }
    }
    let frames: BTreeMap<usize, _> = truth.iter().filter_map(|(f, j)| Some((f.parse().ok()?, j))).collect();
    let (mut errors, mut near, mut close, mut exact) = (Vec::new(), 0usize, 0usize, 0usize);
    for (&f, joints) in frames.iter().skip(1).filter(|(f, _)| !keys.contains(f)) {
        let mask = mask_dir.join(format!("{f:05}.png"));
        let mask = image::open(&mask).with_context(|| mask.display().to_string())?.to_luma8();
        let size = (mask.pixels().filter(|p| p.0[0] > 127).count() as f64).sqrt();
        for (joint, at) in *joints {
            let Some(&(limb, share)) = place.get(joint.as_str()) else { continue };
            let error = motion.track(limb).map_or(1000.0, |t| {
                let fine = polyline::resample(&t.frames[f].points, 401);
                f64::from(fine[(share * 400.0).round() as usize].distance(*at))
            });
            near += usize::from(error < 0.2 * size);
            close += usize::from(error < 0.05 * size);
            exact += usize::from(error < 0.02 * size);
            errors.push(error);
        }
    }
    let per_cent = |n: usize| 100.0 * n as f64 / errors.len() as f64;
    Ok(TrackScore {
        pck02: per_cent(exact),
        pck05: per_cent(close),
        pck20: Some(per_cent(near)),
        mean_px: errors.iter().sum::<f64>() / errors.len() as f64,
        confidence_auc: None,
    })
}
