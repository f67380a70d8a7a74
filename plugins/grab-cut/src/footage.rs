//! What is cut: frames, where the limbs are in each, and what a person painted.

use std::collections::BTreeMap;

use glam::Vec2;

/// A limb in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limb {
    /// From its start to its end, in pixels of the frame; the centre of the top-left pixel is (0.5, 0.5).
    pub points: Vec<Vec2>,
    /// How far each point is to be trusted to lie on the creature where it can be seen, in 0..=1. One a point.
    pub trust: Vec<f32>,
}

/// What a person said of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Known {
    /// Nothing.
    #[default]
    Nothing,
    /// That it is background.
    Background,
    /// That it is the creature.
    Creature,
}

/// The frames of a clip, of one size.
pub trait Frames: Sync {
    /// The pixels of a frame, row by row, 8-bit red, green, blue.
    ///
    /// # Errors
    /// A sentence for a person, when the frame cannot be had.
    fn frame(&self, index: usize) -> Result<Vec<u8>, String>;
}

impl<F: Fn(usize) -> Result<Vec<u8>, String> + Sync> Frames for F {
    fn frame(&self, index: usize) -> Result<Vec<u8>, String> {
        self(index)
    }
}

/// The input of [`crate::GrabCut::segment`].
pub struct Footage<'a> {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// The pictures.
    pub frames: &'a dyn Frames,
    /// The limbs of every frame: the same ones in the same order.
    pub poses: &'a [Vec<Limb>],
    /// Frames with painted pixels: one entry a pixel, row by row.
    pub known: &'a BTreeMap<usize, Vec<Known>>,
}
