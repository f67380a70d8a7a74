//! What moves at another time: creatures, characters and drawings whose frames come sooner, later, eased or held.
//!
//! What was solved for its frames is not solved again. Between two frames bones turn along the shorter arc, and places go
//! straight, as players of glTF and Lottie files show what lies between key frames.

use glam::{Quat, Vec2};
use kurbo::{Affine, BezPath, PathEl, Point};

use super::Transform;
use super::character::{Take, TakeFrame};
use super::creature::Creature;
use super::sketch::{SketchFrame, SketchTake};
use crate::error::{Error, Result};
use crate::motion::{Course, Retime};

/// The most places of vertices, points of paths or bones in all frames of a result.
const MOST_PLACES: u64 = 1 << 28;

/// What there is in each frame of the course, of its two neighbours and the share of the way between them; `a_frame` is how much
/// a frame holds.
fn at_course<F: Clone>(
    frames: &[F],
    a_frame: usize,
    course: &Course,
    between: impl Fn(&F, &F, f64) -> F,
) -> Result<Vec<F>> {
    let value = course.places.len() as u64 * a_frame as u64;
    if value > MOST_PLACES {
        let what = "the number of places in all frames".to_owned();
        return Err(Error::Limit { what, value, max: MOST_PLACES, remedy: "ask for fewer frames".into() });
    }
    let at = |(a, b, share): (usize, usize, f64)| match share {
        0.0 => frames[a].clone(),
        share => between(&frames[a], &frames[b], share),
    };
    Ok(course.between(frames.len()).map(at).collect())
}

impl Creature {
    /// The creature at another time.
    ///
    /// # Errors
    /// What [`Retime::course`] refuses; more than can be held.
    pub fn retimed(&self, how: &Retime) -> Result<Self> {
        let model = &self.model;
        let course = how.course(model.animation.len(), model.fps)?;
        let turn = |a: &Transform, b: &Transform, share: f64| {
            let rotation: Quat = a.rotation.slerp(b.rotation, share as f32).normalize();
            Transform { translation: a.translation.lerp(b.translation, share as f32), rotation }
        };
        let between = |a: &Vec<Transform>, b: &Vec<Transform>, share: f64| {
            a.iter().zip(b).map(|(a, b)| turn(a, b, share)).collect()
        };
        let mut made = self.clone();
        made.model.animation = at_course(&model.animation, model.bones.len(), &course, between)?;
        made.model.fps = course.fps;
        // Its rest pose and colours are of the frame that is nearest to the one that gave them.
        let far = |place: &f64| (place - self.rest_frame as f64).abs();
        let nearest = course.places.iter().enumerate().min_by(|a, b| far(a.1).total_cmp(&far(b.1)));
        made.rest_frame = nearest.map_or(0, |(frame, _)| frame);
        Ok(made)
    }
}

impl Take {
    /// The take at another time. What is drawn over what is as in the frame before.
    ///
    /// # Errors
    /// What [`Retime::course`] refuses; more than can be held.
    pub fn retimed(&self, how: &Retime) -> Result<Self> {
        let course = how.course(self.frames.len(), self.fps)?;
        let places = |a: &[Vec2], b: &[Vec2], share: f64| -> Vec<Vec2> {
            a.iter().zip(b).map(|(a, b)| a.lerp(*b, share as f32)).collect()
        };
        let between = |a: &TakeFrame, b: &TakeFrame, share: f64| TakeFrame {
            points: places(&a.points, &b.points, share),
            joints: places(&a.joints, &b.joints, share),
            depths: a.depths.clone(),
        };
        let vertices = self.frames.first().map_or(0, |f| f.points.len());
        Ok(Self { fps: course.fps, frames: at_course(&self.frames, vertices, &course, between)? })
    }
}

impl SketchTake {
    /// The take at another time.
    ///
    /// # Errors
    /// What [`Retime::course`] refuses; more than can be held.
    pub fn retimed(&self, how: &Retime) -> Result<Self> {
        let course = how.course(self.frames.len(), self.fps)?;
        let paths = |a: &[BezPath], b: &[BezPath], share: f64| -> Vec<BezPath> {
            a.iter().zip(b).map(|(a, b)| path_between(a, b, share)).collect()
        };
        let between = |a: &SketchFrame, b: &SketchFrame, share: f64| SketchFrame {
            paths: paths(&a.paths, &b.paths, share),
            clips: paths(&a.clips, &b.clips, share),
            affines: a.affines.iter().zip(&b.affines).map(|(a, b)| affine_between(*a, *b, share)).collect(),
        };
        let elements = |f: &SketchFrame| f.paths.iter().chain(&f.clips).map(|p| p.elements().len()).sum();
        let a_frame = self.frames.first().map_or(0, elements);
        let frames = at_course(&self.frames, a_frame, &course, between)?;
        Ok(Self { fps: course.fps, frames, order: self.order.clone(), widths: self.widths.clone() })
    }
}

/// Elements are of the same kinds in all frames of a take.
fn path_between(a: &BezPath, b: &BezPath, share: f64) -> BezPath {
    let at = |p: Point, q: Point| p.lerp(q, share);
    let element = |(a, b): (&PathEl, &PathEl)| match (*a, *b) {
        (PathEl::MoveTo(p), PathEl::MoveTo(q)) => PathEl::MoveTo(at(p, q)),
        (PathEl::LineTo(p), PathEl::LineTo(q)) => PathEl::LineTo(at(p, q)),
        (PathEl::QuadTo(p1, p2), PathEl::QuadTo(q1, q2)) => PathEl::QuadTo(at(p1, q1), at(p2, q2)),
        (PathEl::CurveTo(p1, p2, p3), PathEl::CurveTo(q1, q2, q3)) => {
            PathEl::CurveTo(at(p1, q1), at(p2, q2), at(p3, q3))
        }
        (a, _) => a,
    };
    a.elements().iter().zip(b.elements()).map(element).collect()
}

fn affine_between(a: Affine, b: Affine, share: f64) -> Affine {
    let (a, b) = (a.as_coeffs(), b.as_coeffs());
    Affine::new(std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;
    use crate::motion::{Direction, Easing};

    fn sketched(frames: usize) -> SketchTake {
        let path = |f: usize| BezPath::from_svg(&format!("M{f},0 C{f},1 2,{f} 3,3 Q0,{f} 5,5 L{f},{f} Z")).unwrap();
        let frame = |f: usize| SketchFrame {
            paths: vec![path(f)],
            clips: vec![BezPath::new()],
            affines: vec![Affine::translate((f as f64, 0.0))],
        };
        SketchTake { fps: 24.0, frames: (0..frames).map(frame).collect(), order: vec![0], widths: vec![vec![1.0, 2.0]] }
    }

    fn start(frame: &SketchFrame) -> f64 {
        match frame.paths[0].elements()[0] {
            PathEl::MoveTo(p) => p.x,
            _ => f64::NAN,
        }
    }

    #[test]
    fn a_drawing_is_held_eased_and_slowed() {
        let take = sketched(13);
        let starts = |how: Retime| take.retimed(&how).unwrap().frames.iter().map(start).collect::<Vec<_>>();
        assert_eq!(take.retimed(&Retime::default()).unwrap(), take);
        let twos = starts(Retime { hold: 2, ..Retime::default() });
        assert_eq!(twos, [0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 10, 10, 12].map(f64::from));
        let slow = starts(Retime { speed: 0.5, ..Retime::default() });
        assert_eq!((slow.len(), slow[1], slow[24]), (25, 0.5, 12.0));
        let eased = starts(Retime { easing: Easing::InOut, ..Retime::default() });
        assert_eq!((eased[0], eased[6], eased[12]), (0.0, 6.0, 12.0));
        assert!(eased[1] < 0.5 && eased[11] > 11.5, "it starts and ends slowly: {eased:?}");
        let slow = take.retimed(&Retime { speed: 0.5, ..Retime::default() }).unwrap();
        assert_eq!(slow.frames[1].affines[0], Affine::translate((0.5, 0.0)));
        assert_eq!(slow.widths, take.widths);
        let loops = starts(Retime { speed: 0.5, closed: true, ..Retime::default() });
        assert_eq!((loops.len(), loops[25]), (26, 6.0), "the last goes on to the first");
    }

    #[test]
    fn a_character_goes_back_as_it_came() {
        let frame = |f: usize| TakeFrame {
            points: vec![Vec2::new(f as f32, 1.0); 3],
            joints: vec![Vec2::splat(f as f32)],
            depths: vec![f as i32],
        };
        let take = Take { fps: 10.0, frames: (0..5).map(frame).collect() };
        let both = take.retimed(&Retime { direction: Direction::ThereAndBack, ..Retime::default() }).unwrap();
        assert_eq!(both.frames.iter().map(|f| f.depths[0]).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 3, 2, 1]);
        let slow = take.retimed(&Retime { seconds: Some(0.9), ..Retime::default() }).unwrap();
        assert_eq!((slow.frames.len(), slow.fps, slow.frames[1].points[2]), (9, 10.0, Vec2::new(0.5, 1.0)));
        assert!(Take::default().retimed(&Retime::default()).is_err(), "nothing has no time");
        let endless = Retime { speed: 1e-5, ..Retime::default() };
        assert!(matches!(take.retimed(&endless), Ok(made) if made.frames.len() == 400_001));
        let many = Take { fps: 10.0, frames: vec![TakeFrame { points: vec![Vec2::ZERO; 2000], ..frame(0) }; 5] };
        assert!(matches!(many.retimed(&endless), Err(Error::Limit { .. })));
    }

    #[test]
    fn a_creature_turns_evenly_between_its_frames() {
        let turned = |f: usize| Transform {
            translation: glam::Vec3::X * f as f32,
            rotation: Quat::from_rotation_z(0.5 * f as f32),
        };
        let model = crate::shape::RiggedModel {
            size: (10, 10),
            fps: 24.0,
            bones: vec![crate::shape::Bone { name: "a".into(), parent: None }],
            rest: vec![turned(0)],
            animation: (0..4).map(|f| vec![turned(f)]).collect(),
            parts: Vec::new(),
        };
        let creature = Creature { rest_frame: 2, ..Creature::from(model) };
        let slow = creature.retimed(&Retime { speed: 0.5, ..Retime::default() }).unwrap();
        assert_eq!((slow.model.animation.len(), slow.rest_frame), (7, 4));
        for (k, pose) in slow.model.animation.iter().enumerate() {
            assert!((pose[0].translation.x - 0.5 * k as f32).abs() < 1e-6);
            assert!(pose[0].rotation.angle_between(Quat::from_rotation_z(0.25 * k as f32)) < 1e-3);
        }
        let back = creature.retimed(&Retime { direction: Direction::Backward, ..Retime::default() }).unwrap();
        assert_eq!((back.rest_frame, &back.model.animation[0]), (1, &creature.model.animation[3]));
    }
}
