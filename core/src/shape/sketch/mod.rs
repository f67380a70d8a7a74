//! Sketches: a still vector drawing that takes the motion of a video (Live Sketch, Su et al. 2018).

mod active_contour;
mod animate;
#[cfg(test)]
mod animate_tests;
mod bending;
mod binding;
mod binding_edit;
mod brush;
mod canvas;
mod draw;
mod drawing;
mod freehand;
mod layer_mesh;
mod layering;
mod laying;
mod motion_use;
mod outline;
mod placing;
mod pressed;
mod proposing;
mod region;
pub(crate) mod runs;
mod skia;
mod svg_expansion;
mod svg_in;
mod svg_out;
#[cfg(test)]
mod svg_tests;
mod take;

pub use animate::{Sketch, SketchParams};
pub use binding::{BindPoint, Binding, LayerJoint, MotionUse, Pin, SketchLayer, StrokeSetting};
pub use canvas::SketchCanvas;
pub use draw::draw_sketch;
pub use drawing::{Cap, Clip, Drawing, Fill, Gradient, GradientShape, Group, Join, Paint, Pen, Spread, Stop, Stroke};
pub use freehand::PenSample;
pub use laying::{Laid, Laying};
pub use outline::{Outline, OutlineKind};
pub use placing::{
    ControlPoint, ObjectShape, Placing, bind_automatically, control_points, most_telling_frame, place_points,
};
pub use pressed::outline as pressed_outline;
pub use proposing::propose_points;
pub use svg_in::SvgIn;
pub use take::{SketchFrame, SketchTake};
