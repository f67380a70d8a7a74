//! Limbs in every frame, as a segmenter is given them.

use crate::point::Point;

/// A limb in every frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<'a> {
    /// The limb's label.
    pub label: &'a str,
    /// How many points it has in every frame.
    pub points: usize,
    pub(crate) places: &'a [Point],
    pub(crate) visible: &'a [u8],
    pub(crate) confidence: &'a [f32],
}

fn of<T>(all: &[T], frame: usize, each: usize) -> &[T] {
    frame.checked_mul(each).and_then(|start| all.get(start..start.checked_add(each)?)).unwrap_or(&[])
}

impl<'a> Track<'a> {
    /// Where the points are in `frame`; empty for a frame that there is not.
    pub fn places(&self, frame: usize) -> &'a [Point] {
        of(self.places, frame, self.points)
    }

    /// For each point whether it is seen (not 0) in `frame`.
    pub fn visible(&self, frame: usize) -> &'a [u8] {
        of(self.visible, frame, self.points)
    }

    /// How far each place in `frame` is to be trusted, 0 to 1.
    pub fn confidence(&self, frame: usize) -> &'a [f32] {
        of(self.confidence, frame, self.points)
    }
}

/// The rig's limbs, tracked: one track a limb, in the rig's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion<'a> {
    /// The tracks.
    pub tracks: Vec<Track<'a>>,
}
