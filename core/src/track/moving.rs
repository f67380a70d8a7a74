//! What moves in a frame of a clip beside the camera: where something alive may be, when nobody has said so.
//!
//! Dense flow leads from the frame to some before and after it; a place has moved in one of them when it is not where the
//! camera's motion takes the ground, and moves in the frame when it has in at least half of those in which flow and
//! its way back agree. Frames farther off are looked at too, for slow things, and for clips that hold each picture for
//! several frames.
//!
//! Known limits: as the camera's (no parallax, and what fills most of the picture is taken for ground); what rests for a dozen
//! frames does not move; of several things the largest is meant.

use glam::{Affine2, Vec2};
use rayon::prelude::*;

use super::flow::{FlowField, Pyramid};
use super::limb::camera::camera_motion;
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::raster::morphology::{largest_part, without_holes};
use crate::raster::{Mask, Planes, pyramid};

/// The longer side of what is looked at.
const WORKING: u32 = 320;
/// How far from the frame others are looked at.
const AWAY: [usize; 5] = [1, 2, 4, 7, 12];
/// What is this far, in working pixels, from where the ground would be has moved.
const MOVED: f32 = 1.0;
/// Flow and its way back agree up to this, and up to this share of its length.
const AGREE: (f32, f32) = (1.0, 0.1);
/// The share of the picture below which what moves is noise.
const LEAST: f64 = 0.002;

/// What moves most in a frame, one piece without holes, at the clip's size; `None` where nothing does.
///
/// # Errors
/// A frame cannot be read, or the caller cancelled.
pub(crate) fn moving(clip: &Clip, frame: usize, stage: Stage<'_>) -> Result<Option<Mask>> {
    stage.name("looking for what moves")?;
    let info = clip.info();
    let (columns, rows) = pyramid::fitted(info.width, info.height, WORKING);
    let others: Vec<usize> = AWAY
        .iter()
        .flat_map(|&by| [frame.checked_sub(by), frame.checked_add(by).filter(|f| *f < info.frames)])
        .flatten()
        .collect();
    let seen = |frame: usize| -> Result<Pyramid> {
        Ok(Pyramid::of(&Planes::lab(&pyramid::shrunk(&clip.frame(frame)?.rgb, columns, rows))))
    };
    let here = seen(frame)?;
    let flows = others
        .par_iter()
        .map(|&other| {
            stage.at(0.5)?;
            let there = seen(other)?;
            let (to, back) = (FlowField::between(&here, &there), FlowField::between(&there, &here));
            let camera = camera_motion(&to, &back);
            Ok((to, back, camera))
        })
        .collect::<Result<Vec<_>>>()?;
    stage.at(0.9)?;
    let places = (0..rows as usize).flat_map(|y| (0..columns as usize).map(move |x| (x, y)));
    let centre = |(x, y): (usize, usize)| Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
    let mut moves = Mask::new(columns as usize, rows as usize);
    places.filter(|at| has_moved(centre(*at), &flows)).for_each(|(x, y)| moves.set(x, y, true));
    let least = LEAST * f64::from(columns * rows);
    let Some(piece) = largest_part(&moves).filter(|piece| piece.count() as f64 >= least) else { return Ok(None) };
    let piece = without_holes(&piece, usize::MAX);
    let [across, down] =
        [(columns, info.width), (rows, info.height)].map(|(few, many)| few as usize as f32 / many as f32);
    let at = |v: usize, scale: f32| ((v as f32 + 0.5) * scale) as usize;
    Ok(Some(Mask::from_fn(info.width as usize, info.height as usize, |x, y| piece.get(at(x, across), at(y, down)))))
}

/// Whether the place has moved in half of the frames in which it is still seen.
fn has_moved(place: Vec2, flows: &[(FlowField, FlowField, Affine2)]) -> bool {
    let (mut seen, mut moved) = (0, 0);
    for (to, back, camera) in flows {
        let motion = to.at(place);
        if to.disagreement(back, place) <= AGREE.0 + AGREE.1 * motion.length() {
            seen += 1;
            moved += usize::from((camera.transform_point2(place) - place).distance(motion) > MOVED);
        }
    }
    moved > 0 && 2 * moved >= seen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Category;
    use crate::job::Progress;
    use image::{Rgb, RgbImage};

    /// Rough ground that passes by two pixels a frame, and a disc at (60, 40) that stays in the picture.
    fn panned(disc: bool) -> Clip {
        let grain = |x: i32, y: i32| (x.wrapping_mul(7919) ^ y.wrapping_mul(104_729)).rem_euclid(97) as u8;
        let rough = |x: i32, y: i32| {
            let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            (around.map(|(dx, dy)| u32::from(grain(x + dx, y + dy))).sum::<u32>() / 9) as u8
        };
        let frame = |f: i32| {
            RgbImage::from_fn(160, 100, |x, y| {
                let (x, y) = (x as i32, y as i32);
                let on = disc && (x - 60).pow(2) + (y - 40).pow(2) < 20 * 20;
                let level = if on { 120 + rough(x, y) } else { 40 + rough(x + 2 * f, y) };
                Rgb([level, level, if on { 60 } else { level }])
            })
        };
        Clip::from_frames((0..12).map(frame).collect(), 12.0).expect("frames")
    }

    #[test]
    fn what_does_not_move_with_the_ground_is_found_under_a_camera_that_pans() {
        let found = moving(&panned(true), 5, Progress::new().whole()).expect("read").expect("a disc");
        // All of it, and a rim of the ground that it hides next.
        let disc = |radius: i32| {
            Mask::from_fn(160, 100, |x, y| (x as i32 - 60).pow(2) + (y as i32 - 40).pow(2) < radius * radius)
        };
        let share = |of: &Mask, within: &Mask| {
            let mut both = of.clone();
            both.intersect(within);
            both.count() as f64 / of.count() as f64
        };
        assert!(share(&disc(20), &found) > 0.95 && share(&found, &disc(29)) > 0.99, "{}", found.iou(&disc(20)));
        assert_eq!(moving(&panned(false), 5, Progress::new().whole()).expect("read"), None);
    }

    #[test]
    fn a_cancel_and_a_frame_that_is_not_there_are_errors() {
        let progress = Progress::new();
        progress.cancel();
        assert!(moving(&panned(true), 5, progress.whole()).is_err_and(|e| e.category() == Category::Cancelled));
        assert!(moving(&panned(true), 12, Progress::new().whole()).is_err());
    }
}
