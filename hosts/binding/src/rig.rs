//! Rigs: what a person draws on a clip.

use marey_ffi::{
    MRY_FACING_AWAY, MRY_FACING_TOWARD, MRY_FACING_UNKNOWN, MRY_SAID_BEND, MRY_SAID_DEPTH, MRY_SIDE_FAR, MRY_SIDE_MID,
    MRY_SIDE_NEAR, MRY_SIDE_UNKNOWN, mry_clip, mry_point, mry_rig,
};

use crate::session::found;
use crate::{Clip, Context, Result, sys};

/// Limbs, strokes and key frames.
#[derive(Debug)]
pub struct Rig {
    pub(crate) id: mry_rig,
    pub(crate) context: Context,
}

/// Which of a pair a limb is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Not said.
    Unknown,
    /// Toward the viewer.
    Near,
    /// Away from the viewer.
    Far,
    /// Not of a pair.
    Mid,
}

/// Whether a stroke leaves the image plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// Not said.
    Unknown,
    /// Its end is nearer to the viewer than its start.
    Toward,
    /// Its end is farther from the viewer than its start.
    Away,
}

/// A limb as it is named.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limb {
    /// The user's name for it.
    pub label: String,
    /// Which of a pair it is.
    pub side: Side,
}

/// A limb as it is drawn on a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Places in clip pixels, from the limb's start to its end.
    pub points: Vec<(f32, f32)>,
    /// Whether it leaves the image plane.
    pub facing: Facing,
}

/// Where a limb is in depth on a frame, as far as it is said. It holds there and fades toward the limb's key frames around.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LimbDepth {
    /// How far its free part stands from where it would, in clip pixels toward the viewer.
    pub depth: Option<f32>,
    /// How far its free end stands from where it is held, in clip pixels toward the viewer.
    pub bend: Option<f32>,
}

impl LimbDepth {
    pub(crate) fn of((said, depth, bend): (u32, f32, f32)) -> Self {
        let of = |bit: u32, value: f32| (said & bit != 0).then_some(value);
        Self { depth: of(MRY_SAID_DEPTH, depth), bend: of(MRY_SAID_BEND, bend) }
    }

    /// What is said, the depth and the bend.
    pub(crate) fn code(self) -> (u32, f32, f32) {
        let bit = |value: Option<f32>, bit: u32| value.map_or(0, |_| bit);
        let said = bit(self.depth, MRY_SAID_DEPTH) | bit(self.bend, MRY_SAID_BEND);
        (said, self.depth.unwrap_or(0.0), self.bend.unwrap_or(0.0))
    }
}

impl Side {
    pub(crate) fn of(code: i32) -> Self {
        match code {
            MRY_SIDE_NEAR => Self::Near,
            MRY_SIDE_FAR => Self::Far,
            MRY_SIDE_MID => Self::Mid,
            _ => Self::Unknown,
        }
    }

    pub(crate) fn code(self) -> i32 {
        match self {
            Self::Unknown => MRY_SIDE_UNKNOWN,
            Self::Near => MRY_SIDE_NEAR,
            Self::Far => MRY_SIDE_FAR,
            Self::Mid => MRY_SIDE_MID,
        }
    }
}

impl Facing {
    pub(crate) fn of(code: i32) -> Self {
        match code {
            MRY_FACING_TOWARD => Self::Toward,
            MRY_FACING_AWAY => Self::Away,
            _ => Self::Unknown,
        }
    }

    pub(crate) fn code(self) -> i32 {
        match self {
            Self::Unknown => MRY_FACING_UNKNOWN,
            Self::Toward => MRY_FACING_TOWARD,
            Self::Away => MRY_FACING_AWAY,
        }
    }
}

impl Rig {
    /// The text of a strokes.json.
    pub fn to_json(&self) -> Result<String> {
        sys::rig_to_json(&self.context.0, self.id)
    }

    /// Writes strokes.json, whole or not at all.
    pub fn write(&self, path: &str) -> Result<()> {
        sys::rig_write(&self.context.0, self.id, path)
    }

    /// Whether jobs can work with it, on `clip` where one is given.
    pub fn validate(&self, clip: Option<&Clip>) -> Result<()> {
        sys::rig_validate(&self.context.0, self.id, clip.map_or(mry_clip::default(), |c| c.id))
    }

    /// Adds a limb; gives its index.
    pub fn add_limb(&self, label: &str, side: Side) -> Result<u32> {
        sys::rig_add_limb(&self.context.0, self.id, label, side.code())
    }

    /// Draws a limb on a frame, in clip pixels, instead of what was drawn of it there before.
    pub fn set_stroke(&self, limb: u32, frame: u64, points: &[(f32, f32)], facing: Facing) -> Result<()> {
        let points: Vec<mry_point> = points.iter().map(|&(x, y)| mry_point { x, y }).collect();
        sys::rig_set_stroke(&self.context.0, self.id, limb, frame, &points, facing.code())
    }

    /// Takes a limb's stroke off a frame.
    pub fn remove_stroke(&self, limb: u32, frame: u64) -> Result<()> {
        sys::rig_remove_stroke(&self.context.0, self.id, limb, frame)
    }

    /// Says where a limb is in depth on a frame; with nothing said, takes back what was. It need not be drawn there.
    pub fn set_depth(&self, limb: u32, frame: u64, depth: LimbDepth) -> Result<()> {
        sys::rig_set_depth(&self.context.0, self.id, (limb, frame), depth.code())
    }

    /// What is said of a limb's depth on a frame.
    pub fn depth(&self, limb: u32, frame: u64) -> Result<LimbDepth> {
        sys::rig_depth(&self.context.0, self.id, limb, frame).map(LimbDepth::of)
    }

    /// Its limbs, by index.
    pub fn limbs(&self) -> Result<Vec<Limb>> {
        let limb = |limb| {
            let (label, side) = sys::rig_limb(&self.context.0, self.id, limb)?;
            Ok(Limb { label, side: Side::of(side) })
        };
        (0..sys::rig_limb_count(&self.context.0, self.id)?).map(limb).collect()
    }

    /// The frames that something is drawn on, rising.
    pub fn key_frames(&self) -> Result<Vec<u64>> {
        sys::rig_key_frames(&self.context.0, self.id)
    }

    /// A limb's stroke on a frame; [`None`] where it is not drawn there.
    pub fn stroke(&self, limb: u32, frame: u64) -> Result<Option<Stroke>> {
        let drawn = found(sys::rig_stroke(&self.context.0, self.id, limb, frame))?;
        Ok(drawn.map(|(points, facing)| Stroke {
            points: points.iter().map(|p| (p.x, p.y)).collect(),
            facing: Facing::of(facing),
        }))
    }

    /// The longest drawn length of a limb, in clip pixels.
    pub fn length_hint(&self, limb: u32) -> Result<f32> {
        sys::rig_length_hint(&self.context.0, self.id, limb)
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        sys::rig_destroy(&self.context.0, self.id);
    }
}
