//! Where marked points go over a whole clip, kept with the session so that opening it again follows nothing again.
//!
//! The motion is a part of the session, and a stamp in its notes says of which marks and which clip it is. It is taken only
//! where the stamp is that of the marks and the clip that are there, the clip is the file that it was (the session knows
//! its content again, and warns otherwise), and the motion goes through every mark.

use std::sync::Arc;

use marey_binding::{ClipInfo, Context, Motion, Part, Result};
use serde::{Deserialize, Serialize};

use crate::document::Document;

/// A motion of marked points, and the bytes of the marks that it is of.
pub(crate) struct Solved {
    pub(crate) of: Arc<Vec<u8>>,
    pub(crate) motion: Motion,
}

/// What tells marks on a clip from others.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Stamp {
    points: u64,
    size: (u32, u32),
    frames: u64,
    fps: f64,
}

/// What tells bytes from others: FNV-1a, 64 bits, the same on every machine and in every version.
pub(crate) fn fingerprint(bytes: &[u8]) -> u64 {
    let next = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, next)
}

impl Stamp {
    pub(crate) fn new(points: &[u8], clip: &ClipInfo) -> Self {
        Self { points: fingerprint(points), size: (clip.width, clip.height), frames: clip.frames, fps: clip.fps }
    }
}

impl Solved {
    /// What the session keeps, where it is of the marks and the clip that are there.
    fn known(context: &Context, document: &Document) -> Option<Self> {
        let (points, (_, clip)) = (document.part(Part::Points)?, document.clip.as_ref()?);
        if document.stamp() != Some(Stamp::new(points, clip)) || !document.warnings().is_ok_and(|w| w.is_empty()) {
            return None;
        }
        let motion = context.motion_from_json(document.text(Part::Motion)?).ok()?;
        passes_marks(&motion, document).is_ok_and(|passes| passes).then(|| Self { of: points.clone(), motion })
    }

    /// Shows where the marks that are there go, as far as it is known: as it was followed last, as the session keeps it, or
    /// else as it was followed for other marks.
    pub(crate) fn refresh(followed: &mut Option<Self>, context: &Context, document: &mut Document) -> Result<()> {
        let points = document.part(Part::Points).cloned();
        if points.is_none() {
            *followed = None;
            return document.take_points(None, &[]);
        }
        if followed.as_ref().is_none_or(|followed| Some(&followed.of) != points.as_ref()) {
            match (Self::known(context, document), &followed) {
                (Some(known), _) => *followed = Some(known),
                // Names and places may have changed since.
                (None, Some(others)) => return document.take_points(Some(&others.motion), &[]),
                (None, None) => return Ok(()),
            }
        } else if document.tracked.as_ref().is_some_and(|t| t.limbs.len() == document.marks.points.len()) {
            return Ok(());
        }
        followed.as_ref().map_or(Ok(()), |followed| followed.show(context, document))
    }

    /// Shows where they go, and what is worth correcting.
    pub(crate) fn show(&self, context: &Context, document: &mut Document) -> Result<()> {
        document.take_points(Some(&self.motion), &self.corrections(context))
    }

    /// What is worth correcting next, the most helpful first: the point, the frame, and how far it is trusted there.
    fn corrections(&self, context: &Context) -> Vec<(String, u64, f32)> {
        let points = std::str::from_utf8(&self.of).ok().and_then(|json| context.control_points_from_json(json).ok());
        let report = points.and_then(|points| self.motion.point_report(&points).ok()).unwrap_or_default();
        let report: serde_json::Value = serde_json::from_str(&report).unwrap_or_default();
        let one = |c: &serde_json::Value| {
            Some((c["point"].as_str()?.to_owned(), c["frame"].as_u64()?, c["confidence"].as_f64()? as f32))
        };
        report["correct_next"].as_array().into_iter().flatten().filter_map(one).collect()
    }
}

/// Whether a motion is that of the marks: its tracks are theirs, and go through all of them.
fn passes_marks(motion: &Motion, document: &Document) -> Result<bool> {
    let info = motion.info()?;
    if !info.tracks.iter().eq(document.marks.points.iter().map(|p| &p.name)) {
        return Ok(false);
    }
    for (track, mark) in (0..).zip(&document.marks.points) {
        for key in &mark.keys {
            if key.frame >= info.frames {
                return Ok(false);
            }
            let at = motion.frame(track, key.frame)?.points;
            if at.first().is_none_or(|at| (at.0 - key.at.0).abs() + (at.1 - key.at.1).abs() > 0.01) {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stamp_tells_marks_and_clips_apart() {
        let clip = ClipInfo { width: 9, height: 5, frames: 7, fps: 24.0, source: "mp4".into(), warnings: Vec::new() };
        let stamp = Stamp::new(b"marks", &clip);
        assert_eq!(stamp.points, 0x9077_d4a4_e172_6e29, "the same in every version: {:x}", stamp.points);
        assert_ne!(stamp, Stamp::new(b"mark", &clip));
        assert_ne!(stamp, Stamp::new(b"marks", &ClipInfo { frames: 8, ..clip.clone() }));
        let read: Option<Stamp> = serde_json::to_vec(&stamp).ok().and_then(|json| serde_json::from_slice(&json).ok());
        assert_eq!(read, Some(stamp));
    }
}
