//! A take: a drawing over time, as exporters and renderers use it.

use kurbo::{Affine, BezPath};

/// A drawing in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SketchFrame {
    /// The path of each stroke, in the drawing's order. The elements of a stroke's path are of the same kinds in all
    /// frames of a take, though they may be more than the drawing's own: long curves are cut so that they can bend.
    pub paths: Vec<BezPath>,
    /// The path of each group's clip, in the groups' order; empty where a group has none.
    pub clips: Vec<BezPath>,
    /// What each stroke's surroundings do on the whole: gradients follow it.
    pub affines: Vec<Affine>,
}

/// A drawing over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SketchTake {
    /// Frames a second.
    pub fps: f64,
    /// The frames.
    pub frames: Vec<SketchFrame>,
    /// The order in which strokes are painted, the farthest first: each stroke of the drawing once.
    pub order: Vec<usize>,
    /// For each stroke with a pen that was pressed, its width at each point of its path in this take; empty for others.
    pub widths: Vec<Vec<f32>>,
}
