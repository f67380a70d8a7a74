//! Making a motion by hand: from another program's tracks, or to correct a place or two.

use super::{Motion, Track, TrackFrame, TrackKind};
use crate::error::{Error, Result};

/// Points of all tracks in all frames together, at most: what a file of a gigabyte would hold.
const MOST_POINTS: u64 = 1 << 26;

/// Checks that a motion may have the tracks of `motion` in `frames` frames.
pub(super) fn check_points(motion: &Motion, frames: usize) -> Result<()> {
    let a_frame: u64 = motion.tracks.iter().map(|t| t.frames.first().map_or(0, |f| f.points.len() as u64)).sum();
    let value = a_frame.saturating_mul(frames as u64);
    if value <= MOST_POINTS {
        return Ok(());
    }
    let (what, remedy) = ("the number of points of all frames".to_owned(), "ask for fewer frames".to_owned());
    Err(Error::Limit { what, value, max: MOST_POINTS, remedy })
}

impl Motion {
    /// A motion without tracks, over a clip of `size` pixels.
    ///
    /// # Errors
    /// No frames, no pixels, or a rate that is not above 0.
    pub fn new(size: (u32, u32), fps: f64, frames: usize) -> Result<Self> {
        if size.0 == 0 || size.1 == 0 || frames == 0 {
            let problem = format!("is of {frames} frames of {}x{} pixels", size.0, size.1);
            return Err(Error::invalid("motion", problem, "give it a frame and a pixel at least"));
        }
        let motion = Self { size, fps, frames, tracks: Vec::new(), bones: Vec::new() };
        motion.validate()?;
        Ok(motion)
    }

    /// Adds a track behind the others and gives its index. Until they are set its points lie at (0, 0), hidden and not
    /// to be trusted.
    ///
    /// # Errors
    /// The name is empty or taken, there are no points, or too many in all.
    pub fn add_track(&mut self, name: &str, kind: TrackKind, points: usize) -> Result<usize> {
        let what = || format!("track `{name}`");
        if name.is_empty() || self.track(name).is_some() {
            let problem = if name.is_empty() { "has no name" } else { "is there already" };
            return Err(Error::invalid(what(), problem, "give it a name of its own"));
        }
        if points == 0 {
            return Err(Error::invalid(what(), "has no points", "give it one at least"));
        }
        let all = |points: usize| (points as u64).saturating_mul(self.frames as u64);
        let there: u64 = self.tracks.iter().map(|t| all(t.frames.first().map_or(0, |f| f.points.len()))).sum();
        let value = there.saturating_add(all(points));
        if value > MOST_POINTS {
            let (what, remedy) = ("the number of points of all frames".to_owned(), "use fewer".to_owned());
            return Err(Error::Limit { what, value, max: MOST_POINTS, remedy });
        }
        let frame = TrackFrame {
            points: vec![glam::Vec2::ZERO; points],
            visible: vec![false; points],
            confidence: vec![0.0; points],
        };
        self.tracks.push(Track { name: name.to_owned(), kind, frames: vec![frame; self.frames] });
        Ok(self.tracks.len() - 1)
    }

    /// Removes a track and its bones; those behind it move down.
    ///
    /// # Errors
    /// There is no such track.
    pub fn remove_track(&mut self, track: usize) -> Result<()> {
        self.check_track(track)?;
        let gone = self.tracks.remove(track).name;
        self.bones.retain(|(parent, child)| *parent != gone && *child != gone);
        Ok(())
    }

    /// Sets where a track is in one frame.
    ///
    /// # Errors
    /// There is no such track or frame, the number of points is another than the track's, or one is no number.
    pub fn set_frame(&mut self, track: usize, frame: usize, to: TrackFrame) -> Result<()> {
        self.check_track(track)?;
        let what = format!("track `{}`, frame {frame}", self.tracks[track].name);
        let frames = self.frames;
        let Some(at) = self.tracks[track].frames.get_mut(frame) else {
            return Err(Error::invalid(what, format!("the motion has {frames} frames"), "frames count from 0"));
        };
        let count = at.points.len();
        if [to.points.len(), to.visible.len(), to.confidence.len()] != [count; 3] {
            let problem = format!("{} points were given", to.points.len());
            return Err(Error::invalid(what, problem, format!("the track has {count} in every frame")));
        }
        if !to.points.iter().all(|p| p.is_finite()) || !to.confidence.iter().all(|c| (0.0..=1.0).contains(c)) {
            return Err(Error::invalid(
                what,
                "a place is no number, or a confidence is outside 0..1",
                "give numbers a track can hold",
            ));
        }
        *at = to;
        Ok(())
    }

    /// Joins two tracks: `child` hangs from `parent`, and from no other.
    ///
    /// # Errors
    /// There is no such track, or the bones would close a circle.
    pub fn join(&mut self, parent: usize, child: usize) -> Result<()> {
        self.check_track(parent)?;
        self.check_track(child)?;
        let [parent, child] = [parent, child].map(|t| self.tracks[t].name.clone());
        let mut above = Some(&parent);
        for _ in 0..=self.bones.len() {
            if above == Some(&child) {
                let problem = format!("`{child}` is, or carries, `{parent}`");
                return Err(Error::invalid("bone", problem, "bones make trees, no circles"));
            }
            above = above.and_then(|track| self.bones.iter().find(|(_, c)| c == track)).map(|(p, _)| p);
        }
        self.bones.retain(|(_, c)| *c != child);
        self.bones.push((parent, child));
        Ok(())
    }

    /// Takes a bone away; the tracks stay, and bones behind it move down.
    ///
    /// # Errors
    /// There is no such bone.
    pub fn remove_bone(&mut self, bone: usize) -> Result<()> {
        if bone >= self.bones.len() {
            let problem = format!("there are {}", self.bones.len());
            return Err(Error::invalid(format!("bone {bone}"), problem, "bones count from 0"));
        }
        self.bones.remove(bone);
        Ok(())
    }

    fn check_track(&self, track: usize) -> Result<()> {
        if track < self.tracks.len() {
            return Ok(());
        }
        let problem = format!("there are {}", self.tracks.len());
        Err(Error::invalid(format!("track {track}"), problem, "tracks count from 0"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn a_motion_made_by_hand_is_one_that_a_file_can_hold() {
        let mut motion = Motion::new((64, 48), 24.0, 3).expect("a motion");
        let body = motion.add_track("body", TrackKind::Stroke, 2).expect("a track");
        let nose = motion.add_track("nose", TrackKind::Point, 1).expect("a track");
        motion.set_frame(nose, 2, TrackFrame::certain(vec![vec2(7.5, -3.0)])).expect("set");
        motion.join(body, nose).expect("joined");
        motion.validate().expect("valid");
        assert_eq!(Motion::from_json(&motion.to_json()).expect("read"), motion);
        assert_eq!(motion.tracks[nose].frames[2].points[0], vec2(7.5, -3.0));
        assert!(!motion.tracks[body].frames[0].visible[1]);
        motion.remove_track(body).expect("gone");
        assert_eq!((motion.tracks.len(), motion.bones.len()), (1, 0));
    }

    #[test]
    fn what_no_motion_can_be_is_refused_and_changes_nothing() {
        for (size, fps, frames) in
            [((0, 4), 24.0, 1), ((4, 4), 0.0, 1), ((4, 4), f64::NAN, 1), ((4, 4), f64::INFINITY, 1), ((4, 4), 24.0, 0)]
        {
            assert!(Motion::new(size, fps, frames).is_err());
        }
        let mut motion = Motion::new((64, 48), 24.0, 1000).expect("a motion");
        for name in ["a", "b", "c"] {
            motion.add_track(name, TrackKind::Joint, 1).expect("a track");
        }
        motion.join(0, 1).expect("joined");
        motion.join(1, 2).expect("joined");
        let before = motion.clone();
        assert!(
            motion.add_track("a", TrackKind::Joint, 1).is_err() && motion.add_track("", TrackKind::Joint, 1).is_err()
        );
        assert!(motion.add_track("d", TrackKind::Joint, 0).is_err());
        for huge in [1 << 20, usize::MAX] {
            assert!(matches!(motion.add_track("d", TrackKind::Joint, huge), Err(Error::Limit { .. })));
        }
        assert!(motion.remove_track(3).is_err() && motion.remove_bone(2).is_err());
        for (parent, child) in [(2, 0), (0, 0), (3, 0), (0, 3)] {
            assert!(motion.join(parent, child).is_err(), "{parent} {child}");
        }
        let odd = [
            TrackFrame::certain(vec![]),
            TrackFrame::certain(vec![vec2(f32::NAN, 0.0)]),
            TrackFrame { confidence: vec![1.5], ..TrackFrame::certain(vec![vec2(0.0, 0.0)]) },
            TrackFrame { visible: vec![], ..TrackFrame::certain(vec![vec2(0.0, 0.0)]) },
        ];
        for frame in odd {
            assert!(motion.set_frame(0, 0, frame).is_err());
        }
        assert!(motion.set_frame(0, 1000, TrackFrame::certain(vec![vec2(0.0, 0.0)])).is_err());
        assert_eq!(motion, before);
        // A bone moves to the parent named last.
        motion.join(0, 2).expect("joined");
        assert_eq!(motion.bones.len(), 2);
    }
}
