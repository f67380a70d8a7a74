//! A path over time as numbers: what its elements are, and the coordinates of their points in every frame.

use kurbo::{Affine, BezPath, PathEl, Point};

/// Where places are cut off, in pixels: far outside of every picture.
const FAR: f64 = 1e6;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Move,
    Line,
    Quad,
    Cubic,
    Close,
}

impl Kind {
    fn of(element: &PathEl) -> Self {
        match element {
            PathEl::MoveTo(_) => Self::Move,
            PathEl::LineTo(_) => Self::Line,
            PathEl::QuadTo(..) => Self::Quad,
            PathEl::CurveTo(..) => Self::Cubic,
            PathEl::ClosePath => Self::Close,
        }
    }

    /// How many points the element has.
    pub(super) fn points(self) -> usize {
        match self {
            Self::Close => 0,
            Self::Move | Self::Line => 1,
            Self::Quad => 2,
            Self::Cubic => 3,
        }
    }
}

/// A path over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Curve {
    pub(super) kinds: Vec<Kind>,
    /// x and y of every point, in order, for each frame.
    pub(super) frames: Vec<Vec<f64>>,
}

impl Curve {
    /// Of the paths of all frames, which have the same elements.
    pub(super) fn new(paths: impl IntoIterator<Item = BezPath>, view: Affine) -> Self {
        let mut curve = Self::default();
        for path in paths {
            if curve.frames.is_empty() {
                curve.kinds = path.elements().iter().map(Kind::of).collect();
            }
            let at = |p: Point| {
                let p = view * p;
                [p.x, p.y].map(|v| v.clamp(-FAR, FAR))
            };
            let points = path.elements().iter().flat_map(|element| match *element {
                PathEl::MoveTo(p) | PathEl::LineTo(p) => vec![p],
                PathEl::QuadTo(a, p) => vec![a, p],
                PathEl::CurveTo(a, b, p) => vec![a, b, p],
                PathEl::ClosePath => vec![],
            });
            curve.frames.push(points.flat_map(at).collect());
        }
        curve
    }
}

/// Whether two paths have the same elements, but for their places.
pub(in crate::export) fn alike(a: &BezPath, b: &BezPath) -> bool {
    let (a, b) = (a.elements(), b.elements());
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| Kind::of(a) == Kind::of(b))
}
