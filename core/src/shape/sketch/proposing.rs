//! Control points proposed on a frame of a clip: nobody needs to mark what can be seen.
//!
//! The object is what is opaque, what stands before an even background, or what moves, cut out by its colours. Its
//! points are ends of its curve skeleton, those far apart first, where branches meet, where they bend, and places of the body
//! that are far from all others. They are numbered from "1" in that order.
//!
//! Known limits: as of what finds the object (`track::moving`, `segment::grab_cut`); limbs that lie over the body or
//! side by side have no end of their own in the silhouette, and get no point.

use glam::{Vec2, vec2};

use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::geometry::polygon;
use crate::job::Stage;
use crate::raster::Mask;
use crate::raster::distance::distance_to;
use crate::raster::morphology::{largest_part, without_holes};
use crate::rig::{PointKey, PointMark, PointMarks};
use crate::segment::grab_cut::{moving_object, plain_mask};
use crate::shape::character::Skeleton;
use crate::shape::character::curve_skeleton::CurveSkeleton;
use crate::track::moving::moving;

/// People mark 4 to 10 (Su et al. 2018); ends that nobody would mark, such as a second ear, are among these.
const DEFAULT_POINTS: usize = 12;
/// The share of them that are ends at most: a body without points does not move along.
const ENDS: f32 = 0.7;
/// Points lie no closer than this share of the diagonal of the object's box, ends than the first (feet are side by side), places
/// of the body than the last; and of a figure of few points than half of the middle one.
const ENDS_APART: f32 = 0.05;
const APART: f32 = 0.1;
const BODY_APART: f32 = 0.2;
/// Fewer say too little of a figure's motion.
const LEAST: usize = 6;
/// Frames that are looked at for the one that shows most, and how far its object may be from the usual size: what is much larger
/// or smaller was not cut out well.
const LOOKED_AT: usize = 8;
const USUAL: f64 = 0.2;

/// Points for tracking what moves in `frame`, or in the frame that shows most ends of it, `most` of them or fewer (0 for 12).
///
/// # Errors
/// There is no such frame, or it cannot be read; more than 256 points are asked for; nothing moves in it that can be told from
/// its surroundings; or the caller cancelled.
pub fn propose_points(clip: &Clip, frame: Option<usize>, most: usize, stage: Stage<'_>) -> Result<PointMarks> {
    if most > PointMarks::MOST {
        let (value, max) = (most as u64, PointMarks::MOST as u64);
        return Err(Error::Limit { what: "the point count".into(), value, max, remedy: "ask for fewer".into() });
    }
    let info = clip.info();
    let frames = match frame {
        Some(frame) => vec![frame],
        None => {
            let mut frames: Vec<usize> = (0..LOOKED_AT).map(|i| i * info.frames / LOOKED_AT).collect();
            frames.dedup();
            frames
        }
    };
    let mut seen = Vec::new();
    for (i, &frame) in frames.iter().enumerate() {
        let share = |i: usize| i as f64 / frames.len() as f64;
        seen.extend(Figure::seen(clip, frame, stage.part(share(i), share(i + 1)))?);
    }
    let mut sizes: Vec<usize> = seen.iter().map(|figure| figure.object.count()).collect();
    sizes.sort_unstable();
    let usual = sizes.get(sizes.len() / 2).copied().unwrap_or(0) as f64;
    // Of those that show as many, the first.
    let best = seen
        .into_iter()
        .filter(|figure| (figure.object.count() as f64 - usual).abs() <= USUAL * usual)
        .rev()
        .max_by_key(Figure::ends);
    let best = best.ok_or_else(|| {
        let remedy = "mark points on it yourself, or choose another frame";
        let place = frame.map_or("it".to_owned(), |frame| format!("frame {frame}"));
        Error::invalid("the clip", format!("nothing is seen to move in {place}"), remedy)
    })?;
    let most = if most == 0 { DEFAULT_POINTS } else { most };
    let mark = |(i, at): (usize, Vec2)| PointMark {
        name: format!("{}", i + 1),
        keys: vec![PointKey { frame: best.frame, at }],
    };
    let points = best.points(most).into_iter().enumerate().map(mark).collect();
    Ok(PointMarks { size: (info.width, info.height), points })
}

/// The object of a frame.
struct Figure {
    frame: usize,
    object: Mask,
    skeleton: Skeleton,
}

impl Figure {
    /// The object that is seen in a frame, if any.
    fn seen(clip: &Clip, frame: usize, stage: Stage<'_>) -> Result<Option<Self>> {
        let picture = clip.frame(frame)?;
        let object = match plain_mask(&picture) {
            Some(mask) => Some(mask),
            None => match moving(clip, frame, stage.part(0.0, 0.5))? {
                Some(moving) => Some(moving_object(&picture, &moving, stage.part(0.5, 0.9))?),
                None => None,
            },
        };
        let Some(object) = object.and_then(|mask| largest_part(&mask)) else { return Ok(None) };
        let object = without_holes(&object, usize::MAX);
        let skeleton = CurveSkeleton::of(&object, stage.part(0.9, 1.0))?.joints()?;
        Ok(Some(Self { frame, object, skeleton }))
    }

    fn degree(&self, joint: usize) -> usize {
        self.skeleton.bones.iter().flatten().filter(|j| **j == joint).count()
    }

    fn ends(&self) -> usize {
        (0..self.skeleton.joints.len()).filter(|joint| self.degree(*joint) == 1).count()
    }

    /// Places of the object: its skeleton's ends, hubs and bends, then what is farthest from those.
    fn points(&self, most: usize) -> Vec<Vec2> {
        let (object, joints) = (&self.object, &self.skeleton.joints);
        let (width, height) = (object.width(), object.height());
        let inside: Vec<(usize, usize)> =
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).filter(|&(x, y)| object.get(x, y)).collect();
        let centre = |&(x, y): &(usize, usize)| vec2(x as f32 + 0.5, y as f32 + 0.5);
        let Some((low, high)) = polygon::extent(&inside.iter().map(centre).collect::<Vec<_>>()) else {
            return Vec::new();
        };
        let diagonal = low.distance(high);
        let mut chosen: Vec<Vec2> = Vec::new();
        let nearest = |chosen: &[Vec2], p: Vec2| chosen.iter().map(|q| q.distance(p)).fold(f32::INFINITY, f32::min);
        let mut ends: Vec<Vec2> = (0..joints.len()).filter(|j| self.degree(*j) < 2).map(|j| joints[j].at).collect();
        let most_ends = (ENDS * most as f32).ceil() as usize;
        while chosen.len() < most_ends && !ends.is_empty() {
            // The first is the farthest from the middle.
            let far = |p: &Vec2| if chosen.is_empty() { p.distance((low + high) / 2.0) } else { nearest(&chosen, *p) };
            let farthest = (0..ends.len()).rev().max_by(|a, b| far(&ends[*a]).total_cmp(&far(&ends[*b])));
            let end = ends.remove(farthest.unwrap_or(0));
            if chosen.is_empty() || nearest(&chosen, end) >= ENDS_APART * diagonal {
                chosen.push(end);
            }
        }
        let mut inner: Vec<usize> = (0..joints.len()).filter(|joint| self.degree(*joint) > 1).collect();
        inner.sort_by_key(|joint| self.degree(*joint) == 2);
        for at in inner.into_iter().map(|joint| joints[joint].at) {
            // A smoothed line may cut the corner between two limbs.
            let on = object.at(at.x as isize, at.y as isize);
            if on && chosen.len() < most && nearest(&chosen, at) >= APART * diagonal {
                chosen.push(at);
            }
        }
        let depth = distance_to(object, false);
        while chosen.len() < most {
            // Not on the rim, where the background is tracked as well.
            let score = |at: &(usize, usize)| nearest(&chosen, centre(at)).min(4.0 * depth.get(at.0, at.1));
            let Some(farthest) = inside.iter().max_by(|a, b| score(a).total_cmp(&score(b))) else { break };
            let apart = if chosen.len() < LEAST { 0.5 * APART } else { BODY_APART };
            if score(farthest) < apart * diagonal {
                break;
            }
            chosen.push(centre(farthest));
        }
        chosen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Category;
    use crate::geometry::polygon::nearest_on_segment;
    use crate::job::Progress;
    use image::{Rgb, RgbImage};

    /// A cross of four bars on white paper, or the paper alone.
    fn paper(cross: bool) -> Clip {
        let ends = [vec2(20.0, 50.0), vec2(140.0, 50.0), vec2(80.0, 10.0), vec2(80.0, 110.0)];
        let on = |p: Vec2| ends.iter().any(|end| nearest_on_segment(vec2(80.0, 50.0), *end, p).1.distance(p) < 6.0);
        let pixel = |x: u32, y: u32| {
            let on = cross && on(vec2(x as f32 + 0.5, y as f32 + 0.5));
            Rgb([if on { 40 } else { 250 }; 3])
        };
        Clip::from_frames(vec![RgbImage::from_fn(160, 120, pixel); 3], 12.0).expect("frames")
    }

    #[test]
    fn ends_come_first_then_where_they_meet() {
        let marks = propose_points(&paper(true), Some(1), 0, Progress::new().whole()).expect("points");
        marks.validate(Some(((160, 120), 3))).expect("valid");
        let at: Vec<Vec2> = marks.points.iter().map(|p| p.key(1).expect("on that frame")).collect();
        for end in [vec2(20.0, 50.0), vec2(140.0, 50.0), vec2(80.0, 10.0), vec2(80.0, 110.0)] {
            assert!(at[..4].iter().any(|p| p.distance(end) < 8.0), "{end} {at:?}");
        }
        assert!(at[4].distance(vec2(80.0, 50.0)) < 6.0, "{at:?}");
        assert!(at.len() >= LEAST && marks.points[0].name == "1");
        let few = propose_points(&paper(true), Some(1), 3, Progress::new().whole()).expect("points");
        assert_eq!(few.points[..], marks.points[..3]);
        // A frame of one's own is not needed.
        assert_eq!(
            propose_points(&paper(true), None, 0, Progress::new().whole()).expect("points").points.len(),
            at.len()
        );
    }

    #[test]
    fn where_nothing_is_to_be_seen_it_says_so() {
        let refused = propose_points(&paper(false), Some(0), 0, Progress::new().whole()).expect_err("nothing");
        assert!(refused.to_string().contains("nothing is seen to move in frame 0"), "{refused}");
        assert!(propose_points(&paper(true), Some(3), 0, Progress::new().whole()).is_err());
        assert!(propose_points(&paper(true), None, 257, Progress::new().whole()).is_err());
        let progress = Progress::new();
        progress.cancel();
        assert!(
            propose_points(&paper(true), None, 0, progress.whole()).is_err_and(|e| e.category() == Category::Cancelled)
        );
    }
}
