//! Where a picture is taken from, and through which lens.
//!
//! The camera goes around a target: `yaw` degrees to the right, `pitch` degrees up. Without either it looks along -z, as the
//! clip's own camera does.

use glam::camera::rh::proj::directx;
use glam::{Mat4, Vec2, Vec3, vec2, vec3};
use marey::{Error, Result};

use crate::Extent;

/// How much larger a picture is than what is fitted into it; [`Extent`] may need 3.9 %.
const MARGIN: f32 = 1.08;
/// Views of a turn that a lens is fitted to: between 5 degrees nothing grows by more than the margin.
const TURN_STEPS: u32 = 72;
/// What nearest and farthest are at least apart, in shares of the farthest: what 24 bits of depth tell apart well.
const NEAREST: f32 = 1e-3;

/// How places become a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// In parallel; so many world units are as high as the picture.
    Parallel {
        /// World units.
        height: f32,
    },
    /// In perspective.
    Perspective {
        /// The angle between bottom and top, in degrees.
        fov: f32,
        /// From the eye to the target, in world units.
        distance: f32,
    },
}

/// Where a picture is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Degrees around the target, to the right.
    pub yaw: f32,
    /// Degrees above the target; 90 looks straight down.
    pub pitch: f32,
    /// What is in the middle of the picture.
    pub target: Vec3,
    /// The lens.
    pub lens: Lens,
}

impl Camera {
    /// The clip's own: a picture with the clip's aspect shows exactly the clip's pixels, another one all of them and more.
    pub fn of_clip(clip: (u32, u32), picture: (u32, u32)) -> Self {
        let (w, h) = (clip.0 as f32, clip.1 as f32);
        let height = h.max(w / aspect(picture));
        Self { yaw: 0.0, pitch: 0.0, target: vec3(w / 2.0, h / 2.0, 0.0), lens: Lens::Parallel { height } }
    }

    /// One from this side that shows all of `extent`, as large as it can be. With `fov` in perspective.
    pub fn around(extent: &Extent, yaw: f32, pitch: f32, fov: Option<f32>, picture: (u32, u32)) -> Self {
        let mut camera = Self { yaw, pitch, target: extent.center(), lens: Lens::Parallel { height: 1.0 } };
        camera.lens = camera.fitted(extent, fov, picture);
        // In perspective what is near is larger, so that the middle of what is seen moves with the distance.
        for _ in 0..4 {
            let (low, high) = camera.seen(extent);
            let back = camera.turn().inverse();
            camera.target += back.transform_vector3(((low + high) / 2.0).extend(0.0));
            camera.lens = camera.fitted(extent, fov, picture);
        }
        camera
    }

    /// One that shows all of `extent` from wherever a whole turn leads it.
    pub fn turning(extent: &Extent, yaw: f32, pitch: f32, fov: Option<f32>, picture: (u32, u32)) -> Self {
        let target = extent.center();
        let lens = |step: u32| {
            let yaw = yaw + 360.0 * step as f32 / TURN_STEPS as f32;
            Self { yaw, pitch, target, lens: Lens::Parallel { height: 1.0 } }.fitted(extent, fov, picture)
        };
        let wider = |a: Lens, b: Lens| match (a, b) {
            (Lens::Parallel { height: x }, Lens::Parallel { height: y }) => Lens::Parallel { height: x.max(y) },
            (Lens::Perspective { fov, distance: x }, Lens::Perspective { distance: y, .. }) => {
                Lens::Perspective { fov, distance: x.max(y) }
            }
            (a, _) => a,
        };
        Self { yaw, pitch, target, lens: (1..TURN_STEPS).map(lens).fold(lens(0), wider) }
    }

    /// # Errors
    /// What is no number, a lens that shows nothing.
    pub fn validate(&self) -> Result<()> {
        let bad = |what: &str, problem: String, remedy: &str| Err(Error::invalid(what, problem, remedy));
        if !(self.yaw.is_finite() && self.pitch.is_finite() && self.target.is_finite()) {
            return bad("camera", format!("is nowhere: {self:?}"), "give numbers");
        }
        match self.lens {
            Lens::Parallel { height } if !(height.is_finite() && height > 0.0) => {
                bad("the camera's height", format!("is {height}"), "give a number above 0")
            }
            Lens::Perspective { distance, .. } if !(distance.is_finite() && distance > 0.0) => {
                bad("the camera's distance", format!("is {distance}"), "give a number above 0")
            }
            Lens::Perspective { fov, .. } if !(1.0..=170.0).contains(&fov) => {
                bad("the camera's field of view", format!("is {fov} degrees"), "give 1 to 170")
            }
            _ => Ok(()),
        }
    }

    /// World to view: x right, y up, z toward the viewer, the target at the origin.
    pub fn turn(&self) -> Mat4 {
        // Whole turns are taken off first, so that a turntable closes to the bit.
        let angle = |degrees: f32| (degrees % 360.0).to_radians();
        Mat4::from_rotation_x(angle(self.pitch))
            * Mat4::from_rotation_y(-angle(self.yaw))
            * Mat4::from_translation(-self.target)
    }

    /// View z of what is nearest and farthest of `extent`, with some room.
    pub(crate) fn depths(&self, extent: &Extent) -> (f32, f32) {
        let turn = self.turn();
        let z = extent.points().iter().map(|p| turn.transform_point3(*p).z);
        let (low, high) = z.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
        if low > high {
            return (1.0, -1.0);
        }
        let room = 0.02 * extent.size() + 1e-3;
        (high + room, low - room)
    }

    /// World to clip coordinates of a picture: after division by w -1..=1 to the right and up, and 0 at `nearest`, 1 at
    /// `farthest`, both view z.
    pub(crate) fn projection(&self, picture: (u32, u32), (nearest, farthest): (f32, f32)) -> Mat4 {
        let aspect = aspect(picture);
        let view = self.turn();
        match self.lens {
            Lens::Parallel { height } => {
                let (w, h) = (height * aspect / 2.0, height / 2.0);
                directx::orthographic(-w, w, -h, h, -nearest, -farthest) * view
            }
            Lens::Perspective { fov, distance } => {
                let far = (distance - farthest).max(distance * NEAREST * 2.0);
                let near = (distance - nearest).max(far * NEAREST);
                directx::perspective(fov.to_radians(), aspect, near, far)
                    * Mat4::from_translation(vec3(0.0, 0.0, -distance))
                    * view
            }
        }
    }

    /// Whether it sees a floor at this height from above.
    pub(crate) fn is_above(&self, floor: f32) -> bool {
        let back = self.turn().inverse();
        match self.lens {
            Lens::Parallel { .. } => back.transform_vector3(Vec3::Z).y > 1e-3,
            Lens::Perspective { distance, .. } => back.transform_point3(vec3(0.0, 0.0, distance)).y > floor,
        }
    }

    /// The lens that shows all of `extent`.
    fn fitted(&self, extent: &Extent, fov: Option<f32>, picture: (u32, u32)) -> Lens {
        let (turn, aspect) = (self.turn(), aspect(picture));
        let places = extent.points().iter().map(|p| turn.transform_point3(*p));
        let most = |values: &mut dyn Iterator<Item = f32>| MARGIN * values.fold(1e-3, f32::max);
        match fov {
            None => Lens::Parallel { height: most(&mut places.map(|p| 2.0 * p.y.abs().max(p.x.abs() / aspect))) },
            Some(fov) => {
                // A bad angle is refused when the picture is drawn.
                let slope = (fov.clamp(1.0, 170.0).to_radians() / 2.0).tan();
                let needed = |p: Vec3| p.z / MARGIN + p.y.abs().max(p.x.abs() / aspect) / slope;
                Lens::Perspective { fov, distance: most(&mut places.map(needed)) }
            }
        }
    }

    /// What is seen of `extent`, in world units at the target.
    fn seen(&self, extent: &Extent) -> (Vec2, Vec2) {
        let turn = self.turn();
        let nothing = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let seen = extent.points().iter().fold(nothing, |(low, high), p| {
            let p = turn.transform_point3(*p);
            let at = match self.lens {
                Lens::Parallel { .. } => p.truncate(),
                Lens::Perspective { distance, .. } => p.truncate() * (distance / (distance - p.z).max(1e-3)),
            };
            (low.min(at), high.max(at))
        });
        if seen.0.x <= seen.1.x { seen } else { (vec2(0.0, 0.0), vec2(0.0, 0.0)) }
    }
}

fn aspect((width, height): (u32, u32)) -> f32 {
    width.max(1) as f32 / height.max(1) as f32
}
