//! Vector drawings: what a motion brings to life.

use marey_ffi::{mry_drawing, mry_pen_sample};

use crate::character::places;
use crate::{Context, Result, sys};

/// A vector drawing.
#[derive(Debug)]
pub struct Drawing {
    pub(crate) id: mry_drawing,
    pub(crate) context: Context,
}

/// What a drawing is.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawingInfo {
    /// Width and height of its page, in pixels.
    pub size: (f64, f64),
    /// How many strokes there are.
    pub strokes: u32,
    /// How many groups there are.
    pub groups: u32,
    /// What its file had that it does not hold, a sentence each.
    pub left_out: Vec<String>,
}

/// A stroke of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawingStroke {
    /// Its name.
    pub name: String,
    /// Whether something fills it.
    pub filled: bool,
    /// How wide its line is, where a pen draws one.
    pub pen: Option<f32>,
    /// Left upper and right lower corner of what its path encloses.
    pub bounds: ((f32, f32), (f32, f32)),
}

/// A place of a pen that draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PenSample {
    /// In pixels of the page.
    pub at: (f32, f32),
    /// 0..=1; 1 for a pen that does not tell.
    pub pressure: f32,
}

impl Context {
    /// Reads an SVG file. Nothing that it refers to is opened, and no script runs.
    pub fn read_svg(&self, path: &str) -> Result<Drawing> {
        Ok(Drawing { id: sys::drawing_read_svg(&self.0, path)?, context: self.clone() })
    }

    /// Reads the text of an SVG file.
    pub fn drawing_from_svg(&self, svg: &str) -> Result<Drawing> {
        Ok(Drawing { id: sys::drawing_from_svg(&self.0, svg)?, context: self.clone() })
    }

    /// A drawing without strokes, on a page of this size.
    pub fn new_drawing(&self, size: (f64, f64)) -> Result<Drawing> {
        Ok(Drawing { id: sys::drawing_create(&self.0, size)?, context: self.clone() })
    }
}

impl Drawing {
    /// Size and counts.
    pub fn info(&self) -> Result<DrawingInfo> {
        let info = sys::drawing_info(&self.context.0, self.id)?;
        let left_out = (0..info.left_out_count).map(|i| sys::drawing_left_out(&self.context.0, self.id, i));
        Ok(DrawingInfo {
            size: (info.width, info.height),
            strokes: info.stroke_count,
            groups: info.group_count,
            left_out: left_out.collect::<Result<_>>()?,
        })
    }

    /// A stroke; the farthest is 0.
    pub fn stroke(&self, index: u32) -> Result<DrawingStroke> {
        let (name, stroke) = sys::drawing_stroke(&self.context.0, self.id, index)?;
        let pen = (stroke.has_pen != 0).then_some(stroke.pen_width);
        let bounds = ((stroke.low.x, stroke.low.y), (stroke.high.x, stroke.high.y));
        Ok(DrawingStroke { name, filled: stroke.has_fill != 0, pen, bounds })
    }

    /// Adds a stroke over the others, as a pen drew it.
    pub fn add_stroke(&self, name: &str, samples: &[PenSample], width: f32, rgba: [u8; 4]) -> Result<()> {
        let sample = |s: &PenSample| mry_pen_sample { x: s.at.0, y: s.at.1, pressure: s.pressure };
        let samples: Vec<mry_pen_sample> = samples.iter().map(sample).collect();
        sys::drawing_add_stroke(&self.context.0, self.id, name, &samples, width, rgba)
    }

    /// Takes a stroke away.
    pub fn remove_stroke(&self, name: &str) -> Result<()> {
        sys::drawing_remove_stroke(&self.context.0, self.id, name)
    }

    /// The outline around it, a closed polygon.
    pub fn outline(&self) -> Result<Vec<(f32, f32)>> {
        Ok(places(&sys::drawing_outline(&self.context.0, self.id)?))
    }

    /// The text of an SVG file.
    pub fn to_svg(&self) -> Result<String> {
        sys::drawing_to_svg(&self.context.0, self.id)
    }

    /// Writes an SVG file, whole or not at all.
    pub fn write_svg(&self, path: &str) -> Result<()> {
        sys::drawing_write_svg(&self.context.0, self.id, path)
    }
}

impl Drop for Drawing {
    fn drop(&mut self) {
        sys::drawing_destroy(&self.context.0, self.id);
    }
}
