//! Paths and pens as tiny-skia, which draws them, has them.

use kurbo::{Affine, BezPath, PathEl, Point};
use tiny_skia::{LineCap, LineJoin, Path, PathBuilder};

use super::drawing::{Cap, Join, Pen};

/// Where places are cut off, in pixels: far outside of every picture, and well within what f32 tells apart.
pub(super) const FAR: f64 = 1e6;

/// A path as tiny-skia has it. `None` where a place is not a number, and where there is nothing to draw.
pub(super) fn skia_path(path: &BezPath, view: Affine) -> Option<Path> {
    // The library's own check lets some through, and its stroker then never ends.
    if !path.is_finite() {
        return None;
    }
    let mut builder = PathBuilder::with_capacity(path.elements().len(), 3 * path.elements().len());
    let at = |p: Point| {
        let p = view * p;
        (p.x.clamp(-FAR, FAR) as f32, p.y.clamp(-FAR, FAR) as f32)
    };
    for element in path.elements() {
        match *element {
            PathEl::MoveTo(p) => {
                let (x, y) = at(p);
                builder.move_to(x, y);
            }
            PathEl::LineTo(p) => {
                let (x, y) = at(p);
                builder.line_to(x, y);
            }
            PathEl::QuadTo(a, p) => {
                let ((ax, ay), (x, y)) = (at(a), at(p));
                builder.quad_to(ax, ay, x, y);
            }
            PathEl::CurveTo(a, b, p) => {
                let ((ax, ay), (bx, by), (x, y)) = (at(a), at(b), at(p));
                builder.cubic_to(ax, ay, bx, by, x, y);
            }
            PathEl::ClosePath => builder.close(),
        }
    }
    builder.finish()
}

/// A pen that draws lines `width` pixels of the picture wide, without its dashes.
pub(super) fn nib(pen: &Pen, width: f32) -> tiny_skia::Stroke {
    tiny_skia::Stroke {
        width,
        miter_limit: (pen.miter_limit as f32).max(1.0),
        line_cap: match pen.cap {
            Cap::Butt => LineCap::Butt,
            Cap::Round => LineCap::Round,
            Cap::Square => LineCap::Square,
        },
        line_join: match pen.join {
            Join::Miter => LineJoin::Miter,
            Join::Round => LineJoin::Round,
            Join::Bevel => LineJoin::Bevel,
        },
        dash: None,
    }
}
