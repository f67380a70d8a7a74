//! The outline of a drawing: one closed polygon around what is drawn.
//!
//! Fills and pens are rasterised and gaps are closed: what a disc cannot reach from outside without touching ink is inside,
//! and the outer boundary of that, shrunk back by the disc's radius, is the outline, between the pixels by marching
//! squares. The disc is the smallest of a few that encloses nearly what the largest, 3 % of the diagonal, does: gaps
//! between legs stay open where nothing leaks. Separate figures are bridged when they are near, else the largest is taken.
//! An open sketch leaks, though a person sees its inside: places from which most ways end at ink. Where there is much of
//! that, an active contour shrinks from the hull onto the ink, and what of it is nearly surrounded is inside.
//! The outline follows the working resolution, about a five-hundredth of the drawing; lines thinner than that count as so
//! thick, and dashed lines as whole.

use glam::{Vec2, vec2};
use kurbo::{Affine, BezPath, Rect};

use super::active_contour::shrink_wrap;
use super::drawing::{Drawing, Pen, Stroke};
use super::pressed;
use super::skia::{nib, skia_path};
use crate::error::{Error, Result};
use crate::geometry::polygon;
use crate::job::Stage;
use crate::raster::distance::{NO_SITE, nearest_site};
use crate::raster::gaussian::gaussian;
use crate::raster::marching_squares;
use crate::raster::morphology::parts;
use crate::raster::{Grid, Mask};

/// Pixels of the longer side of what is drawn.
const WORKING: f64 = 512.0;
/// Radii of discs that close gaps, in parts of the diagonal.
const RADII: [f32; 6] = [0.003, 0.0075, 0.0125, 0.0175, 0.023, 0.03];
/// What a smaller disc must enclose of what the largest does: it fills bays, and that much is bays.
const ENOUGH: f64 = 0.95;
/// An open sketch: less than this of its hull is enclosed, and so much more is surrounded without being so.
const OPEN: f64 = 0.4;
const LEAKED: f64 = 0.33;
/// Ways that end at ink, of those looked along, for a place that is surrounded; and for one that a contour which shrinks
/// around it holds. Between two legs it is about half.
const SURROUNDED: f32 = 0.8;
const HELD: f32 = 0.6;
const WAYS: usize = 32;
/// Looked along from every third pixel: an inside has no finer detail.
const LOOK: usize = 3;
/// Coverage that counts as ink: what is filled thinner than a pixel is there too.
const INKED: u8 = 40;
/// Parts of less than this of the largest are specks; they join when bridges are short, but decide nothing.
const SPECK: f64 = 0.002;
/// The longest bridge, in parts of the diagonal.
const BRIDGE: f32 = 0.15;
/// The pen of a hairline, in working pixels: thinner ones would leak between pixels.
const HAIRLINE: f64 = 1.5;
/// Corners of an outline that is given by hand; more than any drawing needs.
const MAX_CORNERS: usize = 2000;

/// How an outline was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutlineKind {
    /// The boundary of what the ink encloses.
    Enclosed,
    /// A contour that was shrunk onto open lines.
    ShrinkWrapped,
    /// Drawn by hand.
    Given,
}

/// The outline of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Its corners, in the drawing's pixels, without the first again; it turns from x to y (clockwise as seen) and does
    /// not cross itself.
    pub polygon: Vec<Vec2>,
    /// How it was found.
    pub kind: OutlineKind,
    /// How many separate figures are not within it.
    pub apart: usize,
}

impl Drawing {
    /// The outline of the strokes for which `used` holds, of all without it.
    ///
    /// # Errors
    /// Nothing that would be seen is drawn by them, the drawing is not valid, or cancelled.
    pub fn outline(&self, used: Option<&[bool]>, stage: &Stage<'_>) -> Result<Outline> {
        self.validate()?;
        stage.name("outlining the drawing")?;
        let nothing =
            || Error::invalid("drawing", "no stroke that counts draws anything", "use strokes that paint something");
        let seen = |i: usize, s: &Stroke| {
            used.is_none_or(|u| u.get(i).copied().unwrap_or(false))
                && (s.fill.as_ref().is_some_and(|f| f.opacity > 0.0) || s.pen.as_ref().is_some_and(|p| p.opacity > 0.0))
        };
        let strokes: Vec<&Stroke> =
            self.strokes.iter().enumerate().filter(|(i, s)| seen(*i, s)).map(|(_, s)| s).collect();
        let bounds = strokes.iter().filter_map(|s| self.bounds_of(s)).reduce(|a, b| a.union(b)).ok_or_else(nothing)?;
        let work = Work::around(bounds);
        let ink = work.ink(self, &strokes, &stage.part(0.0, 0.5))?;
        if ink.count() == 0 {
            return Err(nothing());
        }
        let found = work.outline(&ink, &stage.part(0.5, 1.0))?;
        stage.at(1.0)?;
        Ok(found)
    }
}

impl Outline {
    /// An outline drawn by hand, in the drawing's pixels: turned the right way, without places that repeat, and where it
    /// crosses itself the boundary of what it encloses.
    ///
    /// # Errors
    /// It has fewer than three corners or a corner that is no number, or encloses nothing.
    pub fn given(corners: &[Vec2]) -> Result<Self> {
        let bad = |problem: &str| Err(Error::invalid("outline", problem, "draw a closed line around the figure"));
        if !corners.iter().all(|p| p.is_finite() && p.abs().max_element() <= super::drawing::MAX_PIXELS as f32) {
            return bad("a corner is no place near the page");
        }
        let mut polygon = corners.to_vec();
        polygon.dedup();
        while polygon.len() > 1 && polygon.first() == polygon.last() {
            polygon.pop();
        }
        if polygon.len() < 3 {
            return bad("it has fewer than three corners");
        }
        let (low, high) = polygon.iter().fold((Vec2::MAX, Vec2::MIN), |(a, b), p| (a.min(*p), b.max(*p)));
        let size = (high - low).max_element();
        if polygon.len() > MAX_CORNERS {
            let length = polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).sum::<f32>();
            polygon = polygon::resample(&polygon, |_| length / MAX_CORNERS as f32);
        }
        if !is_simple(&polygon) {
            let work = Work::around(Rect::new(low.x.into(), low.y.into(), high.x.into(), high.y.into()));
            let mut path = BezPath::new();
            polygon.iter().enumerate().for_each(|(i, p)| {
                let p = (f64::from(p.x), f64::from(p.y));
                if i == 0 { path.move_to(p) } else { path.line_to(p) }
            });
            path.close_path();
            let mut canvas = work.canvas()?;
            work.fill(&mut canvas, &path, false);
            let field =
                Grid::from_vec(work.width, work.height, canvas.data().iter().map(|v| f32::from(*v) / 255.0).collect());
            polygon = work.boundary(&field, 0.5).unwrap_or_default();
        }
        let area = polygon::signed_area(&polygon);
        // A line to and fro encloses nothing.
        if area.abs() < 1e-4 * f64::from(size).powi(2) || polygon.len() < 3 {
            return bad("it encloses nothing");
        }
        if area < 0.0 {
            polygon.reverse();
        }
        Ok(Self { polygon, kind: OutlineKind::Given, apart: 0 })
    }
}

/// Whether no two sides of the closed polygon meet but neighbours at their corner.
pub(crate) fn is_simple(polygon: &[Vec2]) -> bool {
    let n = polygon.len();
    let side = |i: usize| (polygon[i].as_dvec2(), polygon[(i + 1) % n].as_dvec2());
    let turn = |a: glam::DVec2, b: glam::DVec2, c: glam::DVec2| (b - a).perp_dot(c - a);
    // Sides by their leftmost end, so that only those that overlap along x are compared.
    let mut order: Vec<usize> = (0..n).collect();
    let left = |i: usize| polygon[i].x.min(polygon[(i + 1) % n].x);
    order.sort_by(|a, b| left(*a).total_cmp(&left(*b)));
    for (k, &i) in order.iter().enumerate() {
        let (a, b) = side(i);
        for &j in order[k + 1..].iter().take_while(|&&j| f64::from(left(j)) <= a.x.max(b.x)) {
            let (c, d) = side(j);
            if (i + 1) % n == j || (j + 1) % n == i {
                // Neighbours meet anywhere else only by turning back on themselves.
                let (p, q, r) = if (i + 1) % n == j { (a, b, d) } else { (c, d, b) };
                if n > 2 && turn(p, q, r) == 0.0 && (q - p).dot(r - q) < 0.0 {
                    return false;
                }
                continue;
            }
            if a.y.max(b.y) < c.y.min(d.y) || c.y.max(d.y) < a.y.min(b.y) {
                continue;
            }
            let (s, t) = (turn(a, b, c) * turn(a, b, d), turn(c, d, a) * turn(c, d, b));
            if s <= 0.0 && t <= 0.0 {
                return false;
            }
        }
    }
    true
}

/// The working picture: where it lies on the page, and how large it is.
struct Work {
    /// The drawing's place of the picture's corner, and pixels of the picture for one of the drawing.
    origin: (f64, f64),
    scale: f64,
    width: usize,
    height: usize,
    /// Of what is drawn, in working pixels.
    diagonal: f32,
}

impl Work {
    fn around(bounds: Rect) -> Self {
        let longer = bounds.width().max(bounds.height()).max(1e-3);
        let scale = WORKING / longer;
        let diagonal = bounds.width().hypot(bounds.height()).max(1e-3) * scale;
        // Room for the largest disc on all sides, and a way around.
        let rim = (diagonal * f64::from(RADII[RADII.len() - 1])).ceil() + 4.0;
        Self {
            origin: (bounds.x0 - rim / scale, bounds.y0 - rim / scale),
            scale,
            width: (bounds.width() * scale + 2.0 * rim).ceil() as usize,
            height: (bounds.height() * scale + 2.0 * rim).ceil() as usize,
            diagonal: diagonal as f32,
        }
    }

    fn canvas(&self) -> Result<tiny_skia::Mask> {
        tiny_skia::Mask::new(self.width as u32, self.height as u32)
            .ok_or_else(|| Error::invalid("drawing", "it has no size", "draw something"))
    }

    /// Fills a path, given in the drawing's pixels.
    fn fill(&self, canvas: &mut tiny_skia::Mask, path: &BezPath, even_odd: bool) {
        if let Some(path) = self.skia_path(path) {
            canvas.fill_path(&path, rule(even_odd), true, tiny_skia::Transform::identity());
        }
    }

    fn line(&self, canvas: &mut tiny_skia::Mask, path: &BezPath, pen: &Pen) {
        let thinnest = HAIRLINE / self.scale;
        if !pen.widths.is_empty() {
            let widths: Vec<f32> = pen.widths.iter().map(|w| w.max(thinnest as f32)).collect();
            self.fill(canvas, &pressed::outline(path, &widths, pen), false);
            return;
        }
        let style = nib(pen, (pen.width.max(thinnest) * self.scale) as f32);
        if let Some(outline) = self.skia_path(path).and_then(|p| p.stroke(&style, 1.0)) {
            canvas.fill_path(&outline, tiny_skia::FillRule::Winding, true, tiny_skia::Transform::identity());
        }
    }

    fn skia_path(&self, path: &BezPath) -> Option<tiny_skia::Path> {
        let view = Affine::scale(self.scale) * Affine::translate((-self.origin.0, -self.origin.1));
        skia_path(path, view)
    }

    /// Where fills and pens are, clips applied.
    fn ink(&self, drawing: &Drawing, strokes: &[&Stroke], stage: &Stage<'_>) -> Result<Mask> {
        let mut ink = self.canvas()?;
        for (i, stroke) in strokes.iter().enumerate() {
            stage.at(i as f64 / strokes.len() as f64)?;
            let clips: Vec<_> =
                drawing.ancestors(stroke).into_iter().filter_map(|g| drawing.groups[g].clip.as_ref()).collect();
            let paint = |canvas: &mut tiny_skia::Mask, draw: &dyn Fn(&mut tiny_skia::Mask)| -> Result<()> {
                if clips.is_empty() {
                    draw(canvas);
                    return Ok(());
                }
                let mut own = self.canvas()?;
                draw(&mut own);
                for clip in &clips {
                    let path = self.skia_path(&clip.path);
                    match path {
                        Some(p) => own.intersect_path(&p, rule(clip.even_odd), true, tiny_skia::Transform::identity()),
                        None => own.clear(),
                    }
                }
                canvas.data_mut().iter_mut().zip(own.data()).for_each(|(a, b)| *a = (*a).max(*b));
                Ok(())
            };
            if let Some(fill) = stroke.fill.as_ref().filter(|f| f.opacity > 0.0) {
                paint(&mut ink, &|c| self.fill(c, &stroke.path, fill.even_odd))?;
            }
            if let Some(pen) = stroke.pen.as_ref().filter(|p| p.opacity > 0.0) {
                paint(&mut ink, &|c| self.line(c, &stroke.path, pen))?;
            }
        }
        Ok(Mask::from_fn(self.width, self.height, |x, y| ink.data()[y * self.width + x] > INKED))
    }

    fn outline(&self, ink: &Mask, stage: &Stage<'_>) -> Result<Outline> {
        let to_ink = distance_to(ink);
        let radii = RADII.map(|r| (r * self.diagonal).ceil().max(1.0));
        let mut largest = None;
        let mut best = None;
        for (i, &radius) in radii.iter().rev().enumerate() {
            stage.at(i as f64 / 8.0)?;
            let field = closed(&to_ink, radius);
            let area = field.data().iter().filter(|v| **v > 0.0).count();
            let most = *largest.get_or_insert(area);
            if area as f64 >= ENOUGH * most as f64 {
                best = Some((field, radius, area));
            }
        }
        let (mut field, radius, area) = best.unwrap_or_else(|| (closed(&to_ink, radii[0]), radii[0], 0));
        let hull = hull(ink);
        let mut kind = OutlineKind::Enclosed;
        let few = (area as f64) < OPEN * polygon::signed_area(&hull);
        let around = if few { Some(self.surrounded(&to_ink, stage)?) } else { None };
        let leaked = |around: &Grid<f32>| {
            around.data().iter().zip(field.data()).filter(|(a, f)| **a > SURROUNDED && **f <= 0.0).count()
        };
        if let Some(around) = around.filter(|a| leaked(a) as f64 > LEAKED * area as f64) {
            kind = OutlineKind::ShrinkWrapped;
            let curve = shrink_wrap(&hull, &gaussian(&to_ink, 1.5), &stage.part(0.75, 0.95))?;
            let mut canvas = self.canvas()?;
            let mut path = tiny_skia::PathBuilder::new();
            curve
                .iter()
                .enumerate()
                .for_each(|(i, p)| if i == 0 { path.move_to(p.x, p.y) } else { path.line_to(p.x, p.y) });
            path.close();
            if let Some(path) = path.finish() {
                canvas.fill_path(&path, tiny_skia::FillRule::Winding, true, tiny_skia::Transform::identity());
            }
            // The ink itself stays within, whatever the curve cut off.
            let wrapped = Mask::from_fn(self.width, self.height, |x, y| {
                ink.get(x, y) || canvas.data()[y * self.width + x] > 127 && around.get(x, y) > HELD
            });
            field = closed(&distance_to(&wrapped), radius);
        }
        stage.at(0.95)?;
        let (field, apart) = self.bridged(field);
        // Marching squares on distances between pixels is jagged by a fraction of a pixel; lines of one pixel stay.
        let mut smooth = gaussian(&field, 1.0);
        smooth.data_mut().iter_mut().zip(field.data()).for_each(|(s, f)| *s = s.max(f - 0.25));
        let polygon = self.boundary(&smooth, 0.0);
        match polygon {
            Some(polygon) => Ok(Outline { polygon, kind, apart }),
            None => Err(Error::invalid("drawing", "what is drawn has no area", "draw something larger than a speck")),
        }
    }

    /// How much of what one sees from each pixel is ink, 0..=1.
    fn surrounded(&self, to_ink: &Grid<f32>, stage: &Stage<'_>) -> Result<Grid<f32>> {
        let ways: Vec<Vec2> =
            (0..WAYS).map(|k| Vec2::from_angle(k as f32 * std::f32::consts::TAU / WAYS as f32)).collect();
        let ends_at_ink = |mut p: Vec2, way: Vec2| {
            while p.x >= 0.0 && p.y >= 0.0 && p.x < self.width as f32 && p.y < self.height as f32 {
                let free = to_ink.get(p.x as usize, p.y as usize);
                if free < 1.0 {
                    return true;
                }
                // No ink lies nearer than that, but for the pixels' own extent.
                p += way * (free - 0.8).max(0.7);
            }
            false
        };
        let (columns, rows) = (self.width.div_ceil(LOOK), self.height.div_ceil(LOOK));
        let mut seen = Grid::new(columns, rows, 0.0f32);
        for y in 0..rows {
            stage.at(0.65 + 0.1 * y as f64 / rows as f64)?;
            for x in 0..columns {
                let p = vec2((x * LOOK + LOOK / 2) as f32 + 0.5, (y * LOOK + LOOK / 2) as f32 + 0.5);
                seen.set(x, y, ways.iter().filter(|w| ends_at_ink(p, **w)).count() as f32 / WAYS as f32);
            }
        }
        let mut full = Grid::new(self.width, self.height, 0.0f32);
        for y in 0..self.height {
            for x in 0..self.width {
                let p = vec2(x as f32 + 0.5, y as f32 + 0.5) / LOOK as f32;
                full.set(x, y, crate::raster::sample::bilinear(&seen, p));
            }
        }
        // Ways are few, so what they see jumps.
        Ok(gaussian(&full, 3.0))
    }

    /// The field with near parts joined to the largest, and how many are not.
    fn bridged(&self, mut field: Grid<f32>) -> (Grid<f32>, usize) {
        // Thin, but a way for a mesh.
        let half = (RADII[1] * self.diagonal).max(2.0);
        loop {
            let mask = Mask::from_fn(self.width, self.height, |x, y| field.get(x, y) > 0.0);
            let parts = parts(&mask);
            let Some(main) = (0..parts.areas.len()).max_by_key(|&i| (parts.areas[i], std::cmp::Reverse(i))) else {
                return (field, 0);
            };
            let sites = Grid::from_vec(
                self.width,
                self.height,
                (0..self.width * self.height)
                    .map(|i| if parts.labels.data()[i] == main as u32 + 1 { i as u32 } else { NO_SITE })
                    .collect(),
            );
            let nearest = nearest_site(&sites);
            let place = |i: usize| vec2((i % self.width) as f32, (i / self.width) as f32);
            // The nearest pixel of each other part.
            let mut gaps = vec![(f32::INFINITY, 0); parts.areas.len()];
            for (i, &label) in parts.labels.data().iter().enumerate() {
                if label != 0 && label as usize != main + 1 {
                    let gap = place(i).distance(place(nearest.data()[i] as usize));
                    let known = &mut gaps[label as usize - 1];
                    if gap < known.0 {
                        *known = (gap, i);
                    }
                }
            }
            let bridges: Vec<usize> = gaps.iter().filter(|g| g.0 <= BRIDGE * self.diagonal).map(|g| g.1).collect();
            if bridges.is_empty() {
                let speck = (SPECK * parts.areas[main] as f64).max(8.0);
                let apart =
                    gaps.iter().zip(&parts.areas).filter(|(g, a)| g.0.is_finite() && **a as f64 > speck).count();
                return (field, apart);
            }
            for i in bridges {
                let (a, b) = (place(i), place(nearest.data()[i] as usize));
                let (low, high) = ((a.min(b) - half).max(Vec2::ZERO), a.max(b) + half);
                for y in low.y as usize..=(high.y as usize).min(self.height - 1) {
                    for x in low.x as usize..=(high.x as usize).min(self.width - 1) {
                        let p = vec2(x as f32, y as f32);
                        let inside = half - polygon::nearest_on_segment(a, b, p).1.distance(p);
                        field.set(x, y, field.get(x, y).max(inside));
                    }
                }
            }
        }
    }

    /// The largest outer outline of where the field is above the level, on the page, without needless corners.
    fn boundary(&self, field: &Grid<f32>, level: f32) -> Option<Vec<Vec2>> {
        let outlines = marching_squares::outlines(field, level);
        let area = |p: &Vec<Vec2>| polygon::signed_area(p);
        let outer = outlines.into_iter().filter(|p| area(p) > 0.0).max_by(|a, b| area(a).total_cmp(&area(b)))?;
        let to_page = |p: &Vec2| {
            vec2(
                (f64::from(p.x) / self.scale + self.origin.0) as f32,
                (f64::from(p.y) / self.scale + self.origin.1) as f32,
            )
        };
        // A corner every second pixel; where that lets it cross itself, in a bay as narrow, all of them.
        [polygon::resample(&outer, |_| 2.0), outer]
            .into_iter()
            .map(|p| {
                let mut page: Vec<Vec2> = p.iter().map(to_page).collect();
                page.dedup();
                page
            })
            .find(|p| p.len() >= 3 && is_simple(p))
    }
}

fn rule(even_odd: bool) -> tiny_skia::FillRule {
    if even_odd { tiny_skia::FillRule::EvenOdd } else { tiny_skia::FillRule::Winding }
}

/// The distance of each pixel to the nearest of a mask that has one, between their centres.
fn distance_to(mask: &Mask) -> Grid<f32> {
    let (width, height) = (mask.width(), mask.height());
    let at = |i: usize| (i % width, i / width);
    let sites = (0..width * height).map(|i| if mask.get(at(i).0, at(i).1) { i as u32 } else { NO_SITE }).collect();
    let nearest = nearest_site(&Grid::from_vec(width, height, sites));
    let distance = |(i, &site): (usize, &u32)| {
        if site == NO_SITE {
            return (width + height) as f32;
        }
        let ((x, y), (sx, sy)) = (at(i), at(site as usize));
        vec2(x as f32 - sx as f32, y as f32 - sy as f32).length()
    };
    Grid::from_vec(width, height, nearest.data().iter().enumerate().map(distance).collect())
}

/// How far within the closed figure each pixel is (above 0 inside), when a disc of `radius`, a whole number, rolls around
/// the ink.
fn closed(to_ink: &Grid<f32>, radius: f32) -> Grid<f32> {
    let (width, height) = (to_ink.width(), to_ink.height());
    let grown = Mask::from_fn(width, height, |x, y| to_ink.get(x, y) <= radius);
    let filled = crate::raster::morphology::without_holes(&grown, usize::MAX);
    let outside = Mask::from_fn(width, height, |x, y| !filled.get(x, y));
    let mut field = distance_to(&outside);
    // The rim lies half a pixel before the first centre beyond it.
    field.data_mut().iter_mut().for_each(|d| *d -= radius + 0.5);
    field
}

/// The convex hull of a mask's pixels, turning from x to y (Andrew's monotone chain).
fn hull(mask: &Mask) -> Vec<Vec2> {
    let mut points = Vec::new();
    for x in 0..mask.width() {
        let mut column = (0..mask.height()).filter(|&y| mask.get(x, y));
        if let Some(top) = column.next() {
            let bottom = column.next_back().unwrap_or(top);
            for (dx, y) in [(0, top), (0, bottom + 1), (1, top), (1, bottom + 1)] {
                points.push(vec2((x + dx) as f32, y as f32));
            }
        }
    }
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let chain = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut out: Vec<Vec2> = Vec::new();
        for p in points {
            while out.len() > 1 && (out[out.len() - 1] - out[out.len() - 2]).perp_dot(p - out[out.len() - 1]) <= 0.0 {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
        out
    };
    let mut out = chain(&mut points.iter().copied());
    out.extend(chain(&mut points.iter().rev().copied()));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Progress;
    use crate::shape::sketch::{Fill, Paint};

    fn filled(path: &str) -> Stroke {
        let fill = Fill { paint: Paint::Color([0; 3]), opacity: 1.0, even_odd: false };
        Stroke { path: BezPath::from_svg(path).expect("a path"), fill: Some(fill), ..Stroke::default() }
    }

    fn lined(path: &str, width: f64) -> Stroke {
        Stroke { path: BezPath::from_svg(path).expect("a path"), pen: Some(Pen::plain(width)), ..Stroke::default() }
    }

    fn drawing(strokes: Vec<Stroke>) -> Drawing {
        let named = |(i, s): (usize, Stroke)| Stroke { name: i.to_string(), ..s };
        Drawing { size: (400.0, 300.0), strokes: strokes.into_iter().enumerate().map(named).collect(), groups: vec![] }
    }

    fn outline(strokes: Vec<Stroke>) -> Outline {
        let found = drawing(strokes).outline(None, &Progress::new().whole()).expect("an outline");
        assert!(is_simple(&found.polygon), "it crosses itself");
        assert!(polygon::signed_area(&found.polygon) > 0.0, "it turns the wrong way");
        found
    }

    #[test]
    fn a_filled_figure_is_outlined_where_it_ends() {
        let found = outline(vec![filled("M100 50H300V250H100Z")]);
        assert_eq!((found.kind, found.apart), (OutlineKind::Enclosed, 0));
        assert!((polygon::signed_area(&found.polygon) / 40_000.0 - 1.0).abs() < 0.01);
        for p in &found.polygon {
            let off = (p.x - 100.0).abs().min((p.x - 300.0).abs()).min((p.y - 50.0).abs()).min((p.y - 250.0).abs());
            assert!(off < 0.8, "{p} is {off} from the side");
        }
    }

    #[test]
    fn a_gap_in_a_line_is_closed_and_a_bay_is_not() {
        // An open U of lines, its legs 60 apart, and a gap of 5 in its rim.
        let found = outline(vec![lined("M195 20H100V220H160V120H220V220H280V20H200", 4.0)]);
        let inside = |x: f32, y: f32| polygon::contain(std::slice::from_ref(&found.polygon), vec2(x, y));
        assert_eq!(found.kind, OutlineKind::Enclosed);
        assert!(inside(190.0, 60.0) && inside(130.0, 200.0) && !inside(190.0, 180.0));
    }

    #[test]
    fn an_open_sketch_is_wrapped() {
        // Three quarters of a circle, open to the right.
        let found = outline(vec![lined("M271 221A100 100 0 1 1 271 79", 3.0)]);
        assert_eq!(found.kind, OutlineKind::ShrinkWrapped);
        let whole = std::f64::consts::PI * 1e4;
        let share = polygon::signed_area(&found.polygon) / whole;
        assert!((0.8..1.05).contains(&share), "{share} of the disc");
    }

    #[test]
    fn near_figures_are_bridged_and_far_ones_counted() {
        let near = outline(vec![filled("M50 50H150V150H50Z"), filled("M170 50H270V150H170Z")]);
        assert_eq!(near.apart, 0);
        let inside = |o: &Outline, x: f32, y: f32| polygon::contain(std::slice::from_ref(&o.polygon), vec2(x, y));
        assert!(inside(&near, 100.0, 100.0) && inside(&near, 220.0, 100.0));
        let far = outline(vec![filled("M10 50H150V150H10Z"), filled("M300 50H390V150H300Z")]);
        assert_eq!(far.apart, 1);
        assert!(inside(&far, 100.0, 100.0) && !inside(&far, 350.0, 100.0));
    }

    #[test]
    fn strokes_that_do_not_count_are_not_in_it() {
        let figure = drawing(vec![filled("M50 50H150V150H50Z"), filled("M0 0H400V300H0Z")]);
        let found = figure.outline(Some(&[true, false]), &Progress::new().whole()).expect("an outline");
        assert!((polygon::signed_area(&found.polygon) / 10_000.0 - 1.0).abs() < 0.02);
        assert!(figure.outline(Some(&[false, false]), &Progress::new().whole()).is_err());
    }

    #[test]
    fn degenerate_strokes_neither_panic_nor_hang() {
        for path in ["M5 5L5 5", "M0 0L300 0", "M10 10L90 90L10 90L90 10Z", "M10 10C300 10 10 300 10 10"] {
            let line = drawing(vec![lined(path, 3.0)]).outline(None, &Progress::new().whole());
            assert!(line.is_ok_and(|o| is_simple(&o.polygon)), "{path}");
        }
        assert!(drawing(vec![filled("M0 0L300 0")]).outline(None, &Progress::new().whole()).is_err());
        assert!(drawing(vec![filled("M5 5")]).outline(None, &Progress::new().whole()).is_err());
        let stopped = Progress::new();
        stopped.cancel();
        assert!(matches!(drawing(vec![filled("M0 0H9V9Z")]).outline(None, &stopped.whole()), Err(Error::Cancelled)));
    }

    #[test]
    fn an_outline_by_hand_is_made_simple() {
        let square = [vec2(0.0, 0.0), vec2(0.0, 80.0), vec2(80.0, 80.0), vec2(80.0, 0.0), vec2(0.0, 0.0)];
        let given = Outline::given(&square).expect("a square");
        assert_eq!(given.polygon.len(), 4);
        assert_eq!(polygon::signed_area(&given.polygon), 6400.0);
        let crossed = [vec2(0.0, 0.0), vec2(80.0, 0.0), vec2(80.0, 80.0), vec2(40.0, -20.0), vec2(0.0, 80.0)];
        let given = Outline::given(&crossed).expect("something enclosed");
        assert!(is_simple(&given.polygon) && polygon::signed_area(&given.polygon) > 500.0);
        for bad in [
            vec![],
            vec![vec2(1.0, 1.0), vec2(2.0, 2.0)],
            vec![vec2(0.0, 0.0), vec2(50.0, 0.0), vec2(20.0, 0.0)],
            vec![vec2(0.0, 0.0), vec2(f32::NAN, 0.0), vec2(20.0, 9.0)],
        ] {
            assert!(Outline::given(&bad).is_err(), "{bad:?}");
        }
    }
}
