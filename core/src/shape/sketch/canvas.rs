//! What of a drawing's page pictures show, and how large.

use kurbo::{Affine, Point, Rect, Shape, Vec2};

use super::draw::pen_outline;
use super::runs::enclosing;
use super::skia::skia_path;
use super::{Cap, Drawing, Join, Pen, SketchFrame, SketchTake};
use crate::error::{Error, Result};

/// What tiny-skia and all formats can hold along a side (WebP has the least).
const LONGEST: f64 = 16383.0;
/// Pixels a picture: 256 MiB.
const MOST_PIXELS: u64 = 1 << 26;
/// Space around what has left the page, in its pixels, so that smooth edges end inside.
const HEM: f64 = 1.0;

/// What of the page pictures show, and how large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SketchCanvas {
    size: (u32, u32),
    scale: f64,
    origin: Point,
    /// What lies behind, straight alpha.
    pub background: [u8; 4],
}

impl SketchCanvas {
    /// The page as it is.
    ///
    /// # Errors
    /// A page or a scale that is not above 0, and pictures that are too large.
    pub fn page(drawing: &Drawing, scale: f64) -> Result<Self> {
        Self::new(page(drawing), scale)
    }

    /// The page, and all that leaves it in any frame of a take.
    ///
    /// # Errors
    /// As for [`Self::page`].
    pub fn around(drawing: &Drawing, take: &SketchTake, scale: f64) -> Result<Self> {
        let page = page(drawing);
        let shown = take.frames.iter().fold(page, |shown, frame| grown(shown, drawing, take, frame));
        let hem = |outside: bool| if outside { HEM } else { 0.0 };
        let shown = Rect::new(
            shown.x0 - hem(shown.x0 < page.x0),
            shown.y0 - hem(shown.y0 < page.y0),
            shown.x1 + hem(shown.x1 > page.x1),
            shown.y1 + hem(shown.y1 > page.y1),
        );
        Self::new(shown, scale)
    }

    /// A part of the page, in its pixels; with a clear background.
    ///
    /// # Errors
    /// As for [`Self::page`].
    pub fn new(shown: Rect, scale: f64) -> Result<Self> {
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Error::invalid("scale", format!("is {scale}"), "give a number above 0"));
        }
        if !(shown.is_finite() && shown.width() > 0.0 && shown.height() > 0.0) {
            let problem = format!("is {} by {}", shown.width(), shown.height());
            return Err(Error::invalid("the drawing's page", problem, "give it a width and a height above 0"));
        }
        // Whole pixels of the picture, so that a page that only grew is drawn as it was. What sums of fractions leave
        // over a whole number is no pixel.
        let (low, high) = (shown.origin().to_vec2() * scale, Vec2::new(shown.x1, shown.y1) * scale);
        let low = Vec2::new((low.x + 1e-6).floor(), (low.y + 1e-6).floor());
        let extent = Vec2::new((high.x - 1e-6).ceil(), (high.y - 1e-6).ceil()) - low;
        let (width, height) = (extent.x.max(1.0), extent.y.max(1.0));
        let pixels = width * height;
        if !(width.max(height) <= LONGEST && pixels <= MOST_PIXELS as f64) {
            return Err(Error::Limit {
                what: format!("the pixel count of pictures of {width} by {height}"),
                value: pixels as u64,
                max: MOST_PIXELS,
                remedy: "give a smaller scale, or show only the drawing's own page".into(),
            });
        }
        let origin = (low / scale).to_point();
        Ok(Self { size: (width as u32, height as u32), scale, origin, background: [0; 4] })
    }

    /// Width and height of the pictures.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Pixels of the pictures a pixel of the page.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// What is shown, in the page's pixels.
    pub fn shown(&self) -> Rect {
        let extent = Vec2::new(f64::from(self.size.0), f64::from(self.size.1)) / self.scale;
        Rect::from_points(self.origin, self.origin + extent)
    }

    /// From the page to the pictures.
    pub fn transform(&self) -> Affine {
        Affine::scale(self.scale) * Affine::translate(-self.origin.to_vec2())
    }
}

fn page(drawing: &Drawing) -> Rect {
    Rect::new(0.0, 0.0, drawing.size.0, drawing.size.1)
}

/// `shown` with all that a frame shows beyond it.
fn grown(mut shown: Rect, drawing: &Drawing, take: &SketchTake, frame: &SketchFrame) -> Rect {
    for (s, (stroke, path)) in drawing.strokes.iter().zip(&frame.paths).enumerate() {
        if path.elements().is_empty() || !path.is_finite() {
            continue;
        }
        let within = |area: Rect| area.union(shown) == shown;
        // The box of the control points holds the curve; curves are asked only where that leaves what is shown.
        let widths = take.widths.get(s).map_or(&[][..], |w| w);
        let reach = stroke.pen.as_ref().map_or(0.0, |pen| reach(pen, widths));
        if within(path.control_box().inflate(reach, reach)) {
            continue;
        }
        let mut area = path.bounding_box();
        if let Some(pen) = &stroke.pen
            && let Some(outline) =
                skia_path(path, Affine::IDENTITY).and_then(|p| pen_outline(path, &p, pen, widths, 1.0))
        {
            let b = outline.bounds();
            area = area.union(Rect::new(b.left().into(), b.top().into(), b.right().into(), b.bottom().into()));
        }
        for group in enclosing(drawing, stroke.group) {
            if drawing.groups[group].clip.is_some() {
                area = area.intersect(frame.clips.get(group).map_or(Rect::ZERO, Shape::bounding_box));
            }
        }
        if area.is_finite() && area.width() >= 0.0 && area.height() >= 0.0 && area.area() + reach > 0.0 {
            shown = shown.union(area);
        }
    }
    shown
}

/// How far a pen's line can reach beyond its path.
fn reach(pen: &Pen, widths: &[f32]) -> f64 {
    let widest = widths.iter().fold(pen.width, |most, w| most.max(f64::from(*w)));
    let corners = if pen.join == Join::Miter { pen.miter_limit.max(1.0) } else { 1.0 };
    let ends = if pen.cap == Cap::Square { std::f64::consts::SQRT_2 } else { 1.0 };
    0.5 * widest.max(0.0) * corners.max(ends)
}
