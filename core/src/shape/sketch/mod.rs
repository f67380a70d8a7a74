//! Sketches: a still vector drawing that takes the motion of a video (Live Sketch, Su et al. 2018).

mod binding;
mod drawing;
mod take;

pub use binding::{BindPoint, Binding, LayerJoint, MotionUse, Pin, SketchLayer, StrokeSetting};
pub use drawing::{Cap, Clip, Drawing, Fill, Gradient, GradientShape, Group, Join, Paint, Pen, Spread, Stop, Stroke};
pub use take::{SketchFrame, SketchTake};
