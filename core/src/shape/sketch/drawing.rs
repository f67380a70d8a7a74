//! A vector drawing: strokes in the order in which they are painted, in groups.
//!
//! All places are in the drawing's pixels: x right, y down, the page's top left corner (0, 0). Transforms are applied:
//! what a stroke says holds on the page.

use std::collections::HashSet;

use glam::Vec2;
use kurbo::{Affine, BezPath, PathEl, Point, Rect, Shape};

use crate::error::{Error, Result};

/// Bounds that keep a hostile drawing from eating the machine; ten times what a busy illustration has.
pub(crate) const MAX_STROKES: usize = 100_000;
const MAX_ELEMENTS: usize = 4_000_000;
const MAX_GROUPS: usize = 100_000;
/// Pixels, of places and of the page: single precision still tells an eighth of a pixel there.
pub(crate) const MAX_PIXELS: f64 = 1e6;
/// The shortest row of dashes, in pixels: finer ones are grey to the eye, and a line of a million takes seconds.
pub(crate) const MIN_DASHES: f64 = 0.1;

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

impl Drawing {
    /// The box around everything painted, pens with half their width, within the clips; `None` when nothing is.
    pub fn bounds(&self) -> Option<Rect> {
        self.strokes.iter().filter_map(|s| self.bounds_of(s)).reduce(|a, b| a.union(b))
    }

    /// The box around what is seen of a stroke.
    pub(crate) fn bounds_of(&self, stroke: &Stroke) -> Option<Rect> {
        let clips = self.ancestors(stroke).into_iter().filter_map(|g| self.groups[g].clip.as_ref());
        clips.map(|c| c.path.bounding_box()).try_fold(stroke.bounds()?, |a, b| a.overlaps(b).then(|| a.intersect(b)))
    }

    /// The groups that a stroke is in, the outermost first.
    pub(crate) fn ancestors(&self, stroke: &Stroke) -> Vec<usize> {
        let mut chain: Vec<usize> =
            std::iter::successors(stroke.group, |&g| self.groups.get(g)?.parent.filter(|&p| p < g)).collect();
        chain.retain(|&g| g < self.groups.len());
        chain.reverse();
        chain
    }

    /// The index of the stroke called `name`.
    pub fn stroke(&self, name: &str) -> Option<usize> {
        self.strokes.iter().position(|s| s.name == name)
    }

    /// Checks everything that whoever works with a drawing relies on.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate(&self) -> Result<()> {
        check_page(self.size)?;
        limit("strokes of a drawing", self.strokes.len(), MAX_STROKES)?;
        limit("groups of a drawing", self.groups.len(), MAX_GROUPS)?;
        limit("path elements of a drawing", self.strokes.iter().map(|s| s.path.elements().len()).sum(), MAX_ELEMENTS)?;
        if self.strokes.is_empty() {
            return Err(Error::invalid("drawing", "it has no strokes", "draw something"));
        }
        for (i, group) in self.groups.iter().enumerate() {
            let what = || format!("group {i} `{}`", group.name);
            if group.parent.is_some_and(|p| p >= i) {
                return Err(Error::invalid(what(), "it comes before its parent", "list parents first"));
            }
            share(&what, group.opacity)?;
            if let Some(clip) = &group.clip {
                check_path(&what, &clip.path)?;
            }
        }
        let mut names = HashSet::new();
        for (i, stroke) in self.strokes.iter().enumerate() {
            let what =
                || if stroke.name.is_empty() { format!("stroke {i}") } else { format!("stroke `{}`", stroke.name) };
            if stroke.name.is_empty() || !names.insert(stroke.name.as_str()) {
                return Err(Error::invalid(
                    what(),
                    "its name is empty or another's",
                    "give each stroke a name of its own",
                ));
            }
            if stroke.group.is_some_and(|g| g >= self.groups.len()) {
                return Err(Error::invalid(
                    what(),
                    "it is in a group that is not there",
                    "name a group by its place in the list",
                ));
            }
            stroke.validate(&what)?;
        }
        Ok(())
    }
}

impl Stroke {
    /// The path as polylines, one for each subpath, none farther than `tolerance` pixels from it. A closed one ends with
    /// its first point; a dot is one point.
    pub fn flatten(&self, tolerance: f64) -> Vec<Vec<Vec2>> {
        let mut lines: Vec<Vec<Vec2>> = Vec::new();
        let put = |lines: &mut Vec<Vec<Vec2>>, p: Point| {
            let p = Vec2::new(p.x as f32, p.y as f32);
            if let Some(line) = lines.last_mut()
                && line.last() != Some(&p)
            {
                line.push(p);
            }
        };
        let mut closed = None;
        kurbo::flatten(self.path.elements().iter().copied(), tolerance, |el| match el {
            PathEl::MoveTo(p) => {
                closed = None;
                lines.push(Vec::new());
                put(&mut lines, p);
            }
            PathEl::ClosePath => {
                if let Some(&first) = lines.last().and_then(|l| l.first()) {
                    put(&mut lines, Point::new(first.x.into(), first.y.into()));
                    closed = Some(first);
                }
            }
            PathEl::LineTo(p) | PathEl::QuadTo(_, p) | PathEl::CurveTo(_, _, p) => {
                // What goes on after a close goes on where it closed, as a subpath of its own.
                if let Some(first) = closed.take() {
                    lines.push(vec![first]);
                }
                put(&mut lines, p);
            }
        });
        lines.retain(|l| !l.is_empty());
        lines
    }

    /// The box around it, its pen with half its width; `None` for an empty path.
    pub fn bounds(&self) -> Option<Rect> {
        if self.path.elements().is_empty() {
            return None;
        }
        let half = self.pen.as_ref().map_or(0.0, Pen::widest) / 2.0;
        // A path's own box leaves out dots.
        let starts = self.path.elements().iter().filter_map(|el| match el {
            PathEl::MoveTo(p) => Some(Rect::from_origin_size(*p, (0.0, 0.0))),
            _ => None,
        });
        let lines = self.path.segments().next().map(|_| self.path.bounding_box());
        Some(lines.into_iter().chain(starts).reduce(|a, b| a.union(b))?.inflate(half, half))
    }

    fn validate(&self, what: &dyn Fn() -> String) -> Result<()> {
        check_path(what, &self.path)?;
        if let Some(fill) = &self.fill {
            share(what, fill.opacity)?;
            fill.paint.validate(what)?;
        }
        let Some(pen) = &self.pen else { return Ok(()) };
        share(what, pen.opacity)?;
        pen.paint.validate(what)?;
        let bad = |problem: String, remedy: &str| Err(Error::invalid(what(), problem, remedy));
        if !(pen.width > 0.0 && pen.width <= MAX_PIXELS && pen.miter_limit >= 1.0) {
            return bad(
                format!("a pen of width {}, miter limit {}", pen.width, pen.miter_limit),
                "use a width above 0 and a limit from 1",
            );
        }
        let points = self.path.elements().iter().filter(|e| !matches!(e, PathEl::ClosePath)).count();
        if !pen.widths.is_empty() && pen.widths.len() != points {
            return bad(
                format!("{} widths for {points} points", pen.widths.len()),
                "give one for each point that the path passes",
            );
        }
        if !pen.widths.iter().all(|w| (0.0..=MAX_PIXELS as f32).contains(w)) {
            return bad("a width that is no number from 0".into(), "give widths in pixels");
        }
        let whole = pen.dashes.is_empty() || pen.dashes.iter().sum::<f64>() >= MIN_DASHES;
        if !whole || !pen.dashes.iter().chain([&pen.dash_offset.abs()]).all(|d| (0.0..=MAX_PIXELS).contains(d)) {
            return bad(
                "dashes that cannot be drawn".into(),
                "give lengths from 0, together at least a tenth of a pixel",
            );
        }
        Ok(())
    }
}

impl Pen {
    /// A black, round, whole line.
    pub fn plain(width: f64) -> Self {
        Self {
            paint: Paint::Color([0; 3]),
            opacity: 1.0,
            width,
            widths: Vec::new(),
            cap: Cap::Round,
            join: Join::Round,
            // The default of SVG.
            miter_limit: 4.0,
            dashes: Vec::new(),
            dash_offset: 0.0,
        }
    }

    /// Its width where it is widest.
    pub fn widest(&self) -> f64 {
        self.widths.iter().copied().reduce(f32::max).map_or(self.width, f64::from)
    }
}

impl Paint {
    fn validate(&self, what: &dyn Fn() -> String) -> Result<()> {
        let Self::Gradient(gradient) = self else { return Ok(()) };
        let shape = match gradient.shape {
            GradientShape::Linear { from, to } => [from.x, from.y, to.x, to.y, 0.0],
            GradientShape::Radial { center, radius, focus } => [center.x, center.y, focus.x, focus.y, radius],
        };
        let finite = gradient.transform.is_finite() && shape.iter().all(|v| v.is_finite()) && shape[4] >= 0.0;
        let rising = gradient.stops.len() > 1 && gradient.stops.windows(2).all(|s| s[0].offset <= s[1].offset);
        if !finite || !rising || !gradient.stops.iter().all(|s| (0.0..=1.0).contains(&s.offset)) {
            return Err(Error::invalid(
                what(),
                "a gradient that cannot be drawn",
                "give it two stops at least, with rising offsets in 0..=1, and finite places",
            ));
        }
        gradient.stops.iter().try_for_each(|s| share(what, s.opacity))
    }
}

/// A page has a width and a height.
pub(crate) fn check_page((w, h): (f64, f64)) -> Result<()> {
    if ![w, h].iter().all(|v| *v > 0.0 && *v <= MAX_PIXELS) {
        return Err(Error::invalid(
            "drawing",
            format!("a page of {w} x {h}"),
            format!("give it a size of up to {MAX_PIXELS}"),
        ));
    }
    Ok(())
}

fn limit(what: &str, value: usize, max: usize) -> Result<()> {
    if value <= max {
        return Ok(());
    }
    Err(Error::Limit { what: what.into(), value: value as u64, max: max as u64, remedy: "simplify the drawing".into() })
}

fn share(what: &dyn Fn() -> String, opacity: f32) -> Result<()> {
    if (0.0..=1.0).contains(&opacity) {
        return Ok(());
    }
    Err(Error::invalid(what(), format!("an opacity of {opacity}"), "use 0 to 1"))
}

/// A path begins with a move, and all its places are numbers near the page.
fn check_path(what: &dyn Fn() -> String, path: &BezPath) -> Result<()> {
    if !matches!(path.elements().first(), None | Some(PathEl::MoveTo(_))) {
        return Err(Error::invalid(what(), "its path does not begin with a move", "move to its first point"));
    }
    let near = |p: &Point| p.x.abs() <= MAX_PIXELS && p.y.abs() <= MAX_PIXELS;
    let all_near = path.elements().iter().all(|el| match el {
        PathEl::MoveTo(p) | PathEl::LineTo(p) => near(p),
        PathEl::QuadTo(a, p) => near(a) && near(p),
        PathEl::CurveTo(a, b, p) => near(a) && near(b) && near(p),
        PathEl::ClosePath => true,
    });
    if all_near {
        return Ok(());
    }
    Err(Error::invalid(
        what(),
        format!("a place that is no number or beyond {MAX_PIXELS} pixels"),
        "move it to the page or delete it",
    ))
}
