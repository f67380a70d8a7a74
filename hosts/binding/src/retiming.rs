//! Another time for what moves: faster, longer, eased, backwards or held.

use marey_ffi::mry_time_key;

use crate::{Context, Creature, Motion, Result, SketchTake, Take, sys};

/// How something that moves is given another time; zeros are for its own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RetimeOptions<'a> {
    /// 0 forward, 1 backward, 2 there and back.
    pub direction: i32,
    /// How many times as fast.
    pub speed: f64,
    /// Seconds in all.
    pub seconds: f64,
    /// Frames a second.
    pub fps: f64,
    /// How time passes: 0 evenly, 1 slowly first, 2 slowly at last, 3 both, 4 not at all.
    pub easing: i32,
    /// Frames that each picture stands.
    pub hold: u32,
    /// Whether the motion is a loop.
    pub closed: bool,
    /// Whether speed changes without jumps from key to key.
    pub smooth: bool,
    /// A frame of the result, the frame that comes then, and the easing from there.
    pub keys: &'a [(f64, f64, i32)],
}

impl RetimeOptions<'_> {
    pub(crate) fn time_keys(&self) -> Vec<mry_time_key> {
        let key = |&(at, frame, easing): &(f64, f64, i32)| mry_time_key { at, frame, easing, reserved0: 0 };
        self.keys.iter().map(key).collect()
    }
}

impl Motion {
    /// At another time.
    pub fn retimed(&self, options: &RetimeOptions<'_>) -> Result<Self> {
        Ok(Self { id: sys::motion_retime(&self.context.0, self.id, options)?, context: self.context.clone() })
    }
}

impl Creature {
    /// At another time.
    pub fn retimed(&self, options: &RetimeOptions<'_>) -> Result<Self> {
        Ok(Self { id: sys::creature_retime(&self.context.0, self.id, options)?, context: self.context.clone() })
    }
}

impl Take {
    /// At another time.
    pub fn retimed(&self, options: &RetimeOptions<'_>) -> Result<Self> {
        Ok(Self { id: sys::take_retime(&self.context.0, self.id, options)?, context: self.context.clone() })
    }
}

impl SketchTake {
    /// At another time.
    pub fn retimed(&self, options: &RetimeOptions<'_>) -> Result<Self> {
        Ok(Self { id: sys::sketch_take_retime(&self.context.0, self.id, options)?, context: self.context.clone() })
    }
}

impl Context {
    /// Which frame of something that takes `frames` at `fps` comes when: for each frame of the result a place in it.
    pub fn retimed_places(&self, frames: u64, fps: f64, options: &RetimeOptions<'_>) -> Result<Vec<f64>> {
        sys::retime_places(&self.0, (frames, fps), options)
    }
}
