//! What can be made of a motion: loops, smoother and steadier ones, other creatures' limbs.

use crate::{Motion, Result, sys};

/// The cycle of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// After so many frames all is the same again.
    pub period: f64,
    /// The frame at which a period begins whose surroundings are most like those where it ends.
    pub start: f64,
    /// How surely this is a cycle, 0..=1.
    pub confidence: f64,
    /// For each track when in the cycle its end is farthest along its swing, 0..1, and how far it swings, in pixels.
    pub phases: Vec<(f64, f64)>,
}

/// How a loop is closed.
#[derive(Clone, Copy, Debug, Default)]
pub struct LoopOptions {
    /// The frame it begins at and the frames until it begins again; `None` for the cycle that is found.
    pub range: Option<(f64, f64)>,
    /// Cycles in the loop; 0 for 1.
    pub cycles: u32,
    /// Whether the way of the whole is kept.
    pub keep_travel: bool,
    /// Frames of the loop; 0 for as many as keep the pace best.
    pub frames: u64,
    /// Frames a second; 0 for the motion's own.
    pub fps: f64,
    /// The share of the loop over which its ends are faded; `None` for the default.
    pub fade: Option<f64>,
}

/// How a loop was closed; shares are of the figure's extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// The frame that the loop begins at.
    pub start: f64,
    /// How many frames it takes.
    pub period: f64,
    /// The way of the whole in a loop, in pixels.
    pub travel: (f64, f64),
    /// How far a step at the seam is from the motion's, the mean over points and the most.
    pub pose: (f64, f64),
    /// How far the change of a step there is from the motion's, the mean over points and the most.
    pub speed: (f64, f64),
    /// How far a point usually goes from frame to frame, and how much that changes.
    pub usual: (f64, f64),
}

/// How feet are planted.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlantOptions<'a> {
    /// The tracks that end in feet; none for those that are found.
    pub feet: &'a [String],
    /// Where the ground is, in pixels from the top; `None` for where feet come down.
    pub ground: Option<f64>,
    /// Whether the ground stands still in the picture.
    pub still: bool,
    /// Frames over which a foot is let go; 0 for the default.
    pub ease: f64,
    /// Whether the motion is a loop.
    pub closed: bool,
}

/// How a motion is carried over to limbs.
#[derive(Clone, Copy, Debug, Default)]
pub struct LimbMapOptions<'a> {
    /// Limbs point where the motion's do, rather than turn as they do.
    pub absolute: bool,
    /// Whether the creature faces the other way than what moves; `None` for what fits.
    pub mirror: Option<bool>,
    /// The frame of the motion that the limbs at rest correspond to; `None` for its mean pose.
    pub reference: Option<u64>,
    /// The frame of the creature's motion in which its limbs are at rest; `None` for its mean pose.
    pub rest: Option<u64>,
    /// Limbs change their length up to this factor; 0 for not at all.
    pub stretch: f64,
    /// What the way of the whole is scaled by; `None` for the ratio of the figures' sizes.
    pub travel: Option<f64>,
    /// The text of a limb map; empty to propose one.
    pub map: &'a str,
}

impl Motion {
    fn made(&self, id: marey_ffi::mry_motion) -> Self {
        Self { id, context: self.context.clone() }
    }

    /// Its cycle.
    pub fn cycle(&self) -> Result<Cycle> {
        let cycle = sys::motion_cycle(&self.context.0, self.id)?;
        let phases = sys::motion_phases(&self.context.0, self.id)?;
        Ok(Cycle { period: cycle.period, start: cycle.start, confidence: cycle.confidence, phases })
    }

    /// A range of it closed into a loop.
    pub fn closed(&self, options: &LoopOptions) -> Result<(Self, Seam)> {
        let (id, seam) = sys::motion_loop(&self.context.0, self.id, options)?;
        let seam = Seam {
            start: seam.start,
            period: seam.period,
            travel: (seam.travel_x, seam.travel_y),
            pose: (seam.pose, seam.pose_most),
            speed: (seam.speed, seam.speed_most),
            usual: (seam.usual_step, seam.usual_change),
        };
        Ok((self.made(id), seam))
    }

    /// Without jitter. `period` is that of the swing that is halved, 0 for the default; `held` frames are gone through
    /// exactly, key frames where it is `None`.
    pub fn smooth(&self, period: f64, held: Option<&[u64]>) -> Result<Self> {
        Ok(self.made(sys::motion_smooth(&self.context.0, self.id, period, held)?))
    }

    /// With feet that stay where they come down.
    pub fn planted(&self, options: &PlantOptions<'_>) -> Result<Self> {
        Ok(self.made(sys::motion_plant(&self.context.0, self.id, options)?))
    }

    /// When feet are down and how they slide, as JSON.
    pub fn contacts(&self, options: &PlantOptions<'_>) -> Result<String> {
        sys::motion_contacts(&self.context.0, self.id, options)
    }

    /// On the limbs of the creature whose own motion is given.
    pub fn on_limbs(&self, creature: &Motion, options: &LimbMapOptions<'_>) -> Result<Self> {
        Ok(self.made(sys::motion_map_limbs(&self.context.0, (self.id, creature.id), options)?))
    }

    /// Which limb follows what, as the text of a limb map.
    pub fn limb_map(&self, creature: &Motion, options: &LimbMapOptions<'_>) -> Result<String> {
        sys::motion_match_limbs(&self.context.0, (self.id, creature.id), options)
    }
}
