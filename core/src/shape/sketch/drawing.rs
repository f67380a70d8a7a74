//! A vector drawing: strokes in the order in which they are painted, in groups.
//!
//! All places are in the drawing's pixels: x right, y down, the page's top left corner (0, 0). Transforms are applied:
//! what a stroke says holds on the page.

use kurbo::{Affine, BezPath, Point};

/// A vector drawing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Width and height of the page.
    pub size: (f64, f64),
    /// All strokes, the farthest first.
    pub strokes: Vec<Stroke>,
    /// Groups, parents before their children.
    pub groups: Vec<Group>,
}

/// A path with its fill and its pen: a pen's line, a filled shape, or both.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stroke {
    /// Unique in the drawing.
    pub name: String,
    /// Its path; several subpaths where a shape has holes.
    pub path: BezPath,
    /// What fills it.
    pub fill: Option<Fill>,
    /// What draws its line.
    pub pen: Option<Pen>,
    /// Whether the line lies below the fill.
    pub pen_below: bool,
    /// The innermost group it is in.
    pub group: Option<usize>,
}

/// Strokes that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Its name; empty for none.
    pub name: String,
    /// The group that it is in, earlier in the list.
    pub parent: Option<usize>,
    /// How opaque it is as a whole, 0..=1.
    pub opacity: f32,
    /// What of it is shown; all without one.
    pub clip: Option<Clip>,
}

/// The area in which a group is shown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clip {
    /// Its path.
    pub path: BezPath,
    /// Whether what is enclosed twice is outside.
    pub even_odd: bool,
}

/// What fills a stroke.
#[derive(Clone, Debug, PartialEq)]
pub struct Fill {
    /// Its colour.
    pub paint: Paint,
    /// How opaque it is, 0..=1.
    pub opacity: f32,
    /// Whether what is enclosed twice is outside.
    pub even_odd: bool,
}

/// What draws a stroke's line.
#[derive(Clone, Debug, PartialEq)]
pub struct Pen {
    /// Its colour.
    pub paint: Paint,
    /// How opaque it is, 0..=1.
    pub opacity: f32,
    /// Its width, in pixels.
    pub width: f64,
    /// Its width at each point that the path passes, from first to last, as it was pressed: one for each element that is
    /// not a close. Empty for `width` everywhere.
    pub widths: Vec<f32>,
    /// How it begins and ends.
    pub cap: Cap,
    /// How it goes round corners.
    pub join: Join,
    /// The longest miter, in half widths.
    pub miter_limit: f64,
    /// Lengths of dashes and gaps by turns, in pixels; empty for a whole line.
    pub dashes: Vec<f64>,
    /// Where in the dashes the line begins, in pixels.
    pub dash_offset: f64,
}

/// How a line ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cap {
    /// Cut off at its end.
    #[default]
    Butt,
    /// By half a disc.
    Round,
    /// By half a square.
    Square,
}

/// How a line goes round a corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Join {
    /// Pointed, up to the miter limit.
    #[default]
    Miter,
    /// By a piece of a disc.
    Round,
    /// Cut off.
    Bevel,
}

/// A colour, or colours that change over the stroke.
#[derive(Clone, Debug, PartialEq)]
pub enum Paint {
    /// Red, green and blue of sRGB.
    Color([u8; 3]),
    /// Colours between stops.
    Gradient(Gradient),
}

/// Colours between stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Gradient {
    /// Along what.
    pub shape: GradientShape,
    /// From the shape's coordinates to the page.
    pub transform: Affine,
    /// Beyond the first and last stop.
    pub spread: Spread,
    /// At least two, offsets rising.
    pub stops: Vec<Stop>,
}

/// Along what a gradient changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GradientShape {
    /// From one place to another.
    Linear {
        /// Where it is 0.
        from: Point,
        /// Where it is 1.
        to: Point,
    },
    /// From a focus to a circle.
    Radial {
        /// The circle's centre.
        center: Point,
        /// The circle's radius, where it is 1.
        radius: f64,
        /// Where it is 0.
        focus: Point,
    },
}

/// What a gradient shows beyond its ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spread {
    /// The last colour.
    #[default]
    Pad,
    /// It goes back and forth.
    Reflect,
    /// It starts again.
    Repeat,
}

/// One colour of a gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Where, in 0..=1.
    pub offset: f32,
    /// Red, green and blue of sRGB.
    pub color: [u8; 3],
    /// How opaque, 0..=1.
    pub opacity: f32,
}
