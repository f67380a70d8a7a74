//! What is followed, and where it was drawn.

use glam::Vec2;

/// A limb as drawn on one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// The frame.
    pub frame: usize,
    /// As many points as the limb has, in pixels; the centre of the top-left pixel is (0.5, 0.5).
    pub points: Vec<Vec2>,
}

/// A limb to be followed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limb {
    /// Where it was drawn, by rising frame; at least once, with two points or more.
    pub strokes: Vec<Stroke>,
    /// The limb it hangs from; never itself, nor one that hangs from it.
    pub parent: Option<usize>,
    /// Whether its first point is the end that hangs, else its last.
    pub rooted_at_start: bool,
}

/// A limb in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// Where its points are.
    pub points: Vec<Vec2>,
    /// How far each is to be trusted, 0 to 1; 1 where it was drawn.
    pub confidence: Vec<f32>,
    /// Whether each is seen.
    pub visible: Vec<bool>,
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

/// The input of [`crate::FlowTracker::track`].
pub struct Footage<'a> {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// How many frames there are.
    pub count: usize,
    /// The pictures.
    pub frames: &'a dyn Frames,
    /// What is followed.
    pub limbs: &'a [Limb],
}
