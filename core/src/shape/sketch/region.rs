//! The region of a layer: where its strokes are, somewhat wider, and what they enclose.
//!
//! Live Sketch (Su et al. 2018) meshes "an expanded region of the sketch". Here the strokes are painted into a grid of
//! cells, widened by a share of the drawing's diagonal, and what they enclose is filled, so that an eye goes with its
//! head; gaps in an outline count as closed while they are narrower than twice [`CLOSED`], though legs with such a gap
//! between them, open at one end, stay two. Pieces that lie near one another are joined by bridges along their shortest
//! gaps, a minimum spanning tree of them.
//!
//! Known limits: pieces farther apart than [`BRIDGED`] stay pieces; cells are square and so many, however fine the
//! drawing is.

use std::collections::BTreeMap;

use glam::{Vec2, vec2};
use kurbo::Rect;

use crate::error::Result;
use crate::job::Stage;
use crate::raster::distance::{NO_SITE, distance_to, nearest_site};
use crate::raster::gaussian::gaussian;
use crate::raster::{Grid, Mask, marching_squares, morphology};

use super::{Drawing, Stroke};

/// Cells along the longer side of the strokes.
const CELLS: f32 = 320.0;
/// How far the region goes beyond the ink, as a share of the diagonal: about a mesh's edge from rim to rim.
const EXPANDED: f32 = 0.012;
/// Outlines whose gaps are narrower than twice this share of the diagonal enclose what lies in them.
const CLOSED: f32 = 0.02;
/// Pieces with a gap of at most this share of the diagonal between them are joined.
const BRIDGED: f32 = 0.25;
/// Lines are painted so many cells wide at least, so that no sampling misses them.
const HAIR: f32 = 1.5;

/// The grid that all layers of a drawing share.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RegionGrid {
    pub(super) origin: Vec2,
    /// The side of a cell, in pixels.
    pub(super) cell: f32,
    width: usize,
    height: usize,
    diagonal: f32,
}

impl RegionGrid {
    /// Over these strokes of a drawing, as far as they are not more than a page away from it; `None` without any.
    pub(super) fn over(drawing: &Drawing, strokes: &[usize]) -> Option<Self> {
        let (w, h) = drawing.size;
        let near = Rect::new(-w, -h, 2.0 * w, 2.0 * h);
        let boxes = strokes.iter().filter_map(|&s| drawing.strokes[s].bounds());
        let within = |b: Rect| {
            let clamped = |p: kurbo::Point| (p.x.clamp(near.x0, near.x1), p.y.clamp(near.y0, near.y1));
            Rect::from_points(clamped(b.origin()), clamped(kurbo::Point::new(b.x1, b.y1)))
        };
        let all = boxes.map(within).reduce(|a, b| a.union(b))?;
        // Around a dot there is room for a mesh.
        let least = 0.01 * w.hypot(h);
        let all = all.inflate((least - all.width()).max(0.0) / 2.0, (least - all.height()).max(0.0) / 2.0);
        let (low, size) = (vec2(all.x0 as f32, all.y0 as f32), vec2(all.width() as f32, all.height() as f32));
        let cell = size.max_element() / CELLS;
        let diagonal = size.length();
        let margin = CLOSED * diagonal + 3.0 * cell;
        let count = ((size + 2.0 * margin) / cell).ceil();
        Some(Self { origin: low - margin, cell, width: count.x as usize, height: count.y as usize, diagonal })
    }

    /// How far the region goes beyond the ink, in cells.
    pub(super) fn expanded(&self) -> f32 {
        EXPANDED * self.diagonal / self.cell
    }

    /// The strokes' diagonal, in pixels.
    pub(super) fn diagonal(&self) -> f32 {
        self.diagonal
    }

    pub(super) fn place(&self, cells: Vec2) -> Vec2 {
        self.origin + cells * self.cell
    }

    /// The cells under the strokes.
    pub(super) fn ink<'a>(&self, strokes: impl Iterator<Item = &'a Stroke>, stage: Stage<'_>) -> Result<Mask> {
        let empty = Mask::new(self.width, self.height);
        let Some(mut painted) = tiny_skia::Mask::new(self.width as u32, self.height as u32) else { return Ok(empty) };
        for stroke in strokes {
            stage.at(0.0)?;
            let mut path = tiny_skia::PathBuilder::new();
            for line in stroke.flatten(f64::from(0.5 * self.cell)) {
                let mut cells = line.iter().map(|p| (*p - self.origin) / self.cell);
                if let Some(p) = cells.next() {
                    path.move_to(p.x, p.y);
                    // A dot is a line to itself.
                    if line.len() == 1 {
                        path.line_to(p.x, p.y);
                    }
                }
                cells.for_each(|p| path.line_to(p.x, p.y));
            }
            let Some(path) = path.finish() else { continue };
            let transform = tiny_skia::Transform::identity();
            if let Some(fill) = &stroke.fill {
                let rule = if fill.even_odd { tiny_skia::FillRule::EvenOdd } else { tiny_skia::FillRule::Winding };
                painted.fill_path(&path, rule, true, transform);
            }
            let width = stroke.pen.as_ref().map_or(0.0, |p| p.widest() as f32 / self.cell).max(HAIR);
            let pen = tiny_skia::Stroke {
                width,
                line_cap: tiny_skia::LineCap::Round,
                line_join: tiny_skia::LineJoin::Round,
                ..tiny_skia::Stroke::default()
            };
            if let Some(line) = path.stroke(&pen, 1.0) {
                painted.fill_path(&line, tiny_skia::FillRule::Winding, true, transform);
            }
        }
        let data = painted.data();
        Ok(Mask::from_fn(self.width, self.height, |x, y| data[y * self.width + x] > 84))
    }

    /// The region of a layer with this ink.
    pub(super) fn region(&self, ink: &Mask) -> Mask {
        let (expanded, closed) = (self.expanded(), CLOSED * self.diagonal / self.cell);
        let away = distance_to(ink, true);
        let within =
            |away: &Grid<f32>, most: f32| Mask::from_fn(self.width, self.height, |x, y| away.get(x, y) <= most);
        let wide = within(&away, closed);
        let filled = morphology::without_holes(&wide, usize::MAX);
        let enclosed = Mask::from_fn(self.width, self.height, |x, y| filled.get(x, y) && !wide.get(x, y));
        let inside = distance_to(&enclosed, true);
        let region =
            Mask::from_fn(self.width, self.height, |x, y| away.get(x, y) <= expanded || inside.get(x, y) <= closed);
        let mut bridged = region.clone();
        for (from, to) in self.bridges(&region) {
            let reach = expanded.ceil() as isize;
            let steps = from.distance(to).ceil().max(1.0);
            for k in 0..=steps as usize {
                let at = from.lerp(to, k as f32 / steps);
                for y in (at.y as isize - reach)..=(at.y as isize + reach) {
                    for x in (at.x as isize - reach)..=(at.x as isize + reach) {
                        let inside = x >= 0 && y >= 0 && (x as usize) < self.width && (y as usize) < self.height;
                        if inside && vec2(x as f32, y as f32).distance(at) <= expanded {
                            bridged.set(x as usize, y as usize, true);
                        }
                    }
                }
            }
        }
        morphology::without_holes(&bridged, usize::MAX)
    }

    /// The shortest gaps that join the parts of a region, in cells.
    fn bridges(&self, region: &Mask) -> Vec<(Vec2, Vec2)> {
        let parts = morphology::parts(region);
        if parts.areas.len() < 2 {
            return Vec::new();
        }
        let (width, height) = (self.width, self.height);
        let near = nearest_site(&sites(region));
        let place = |site: u32| vec2((site as usize % width) as f32, (site as usize / width) as f32);
        let part = |site: u32| parts.labels.get(site as usize % width, site as usize / width);
        // Where the cells nearest to one part meet those nearest to another.
        let mut gaps: BTreeMap<(u32, u32), (f32, u32, u32)> = BTreeMap::new();
        for y in 0..height {
            for x in 0..width {
                let own = near.get(x, y);
                for (nx, ny) in [(x + 1, y), (x, y + 1)] {
                    if nx >= width || ny >= height {
                        continue;
                    }
                    let other = near.get(nx, ny);
                    let (a, b) = (part(own), part(other));
                    if a == b {
                        continue;
                    }
                    let gap = place(own).distance(place(other));
                    let (pair, found) = if a < b { ((a, b), (gap, own, other)) } else { ((b, a), (gap, other, own)) };
                    let shortest = gaps.entry(pair).or_insert(found);
                    if gap < shortest.0 {
                        *shortest = found;
                    }
                }
            }
        }
        let mut gaps: Vec<_> = gaps.into_iter().collect();
        gaps.sort_by(|a, b| a.1.0.total_cmp(&b.1.0).then(a.0.cmp(&b.0)));
        let mut joined: Vec<usize> = (0..=parts.areas.len()).collect();
        let mut bridges = Vec::new();
        for ((a, b), (gap, from, to)) in gaps {
            let (a, b) = (joined[a as usize], joined[b as usize]);
            if gap > BRIDGED * self.diagonal / self.cell || a == b {
                continue;
            }
            joined.iter_mut().filter(|j| **j == b).for_each(|j| *j = a);
            bridges.push((place(from), place(to)));
        }
        bridges
    }

    /// The smooth outlines of a region, in cells.
    pub(super) fn outlines(&self, region: &Mask) -> Vec<Vec<Vec2>> {
        let solid: Vec<f32> = (0..self.width * self.height)
            .map(|i| f32::from(u8::from(region.get(i % self.width, i / self.width))))
            .collect();
        marching_squares::outlines(&gaussian(&Grid::from_vec(self.width, self.height, solid), 1.0), 0.5)
    }
}

fn sites(mask: &Mask) -> Grid<u32> {
    let (width, height) = (mask.width(), mask.height());
    let site = |i: usize| if mask.get(i % width, i / width) { i as u32 } else { NO_SITE };
    Grid::from_vec(width, height, (0..width * height).map(site).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Progress;
    use crate::shape::sketch::Pen;
    use kurbo::BezPath;

    fn region_of(paths: &[&str]) -> (RegionGrid, Mask) {
        let stroke = |path: &&str| Stroke {
            path: BezPath::from_svg(path).expect("a path"),
            pen: Some(Pen::plain(1.0)),
            ..Stroke::default()
        };
        let drawing = Drawing { size: (200.0, 200.0), strokes: paths.iter().map(stroke).collect(), groups: Vec::new() };
        let grid = RegionGrid::over(&drawing, &(0..paths.len()).collect::<Vec<_>>()).expect("strokes");
        let ink = grid.ink(drawing.strokes.iter(), Progress::new().whole()).expect("not cancelled");
        let region = grid.region(&ink);
        (grid, region)
    }

    fn has(grid: &RegionGrid, region: &Mask, x: f32, y: f32) -> bool {
        let c = (vec2(x, y) - grid.origin) / grid.cell;
        region.at(c.x as isize, c.y as isize)
    }

    #[test]
    fn a_head_with_a_gap_is_filled_and_legs_stay_two() {
        // A ring with a gap of 4, an eye inside, and two legs 10 apart.
        let ring = "M 104 20 A 40 40 0 1 1 100 20";
        let (grid, region) = region_of(&[ring, "M 110 50 l 1 0", "M 95 100 V 190", "M 105 100 V 190"]);
        assert!(has(&grid, &region, 100.0, 60.0) && has(&grid, &region, 80.0, 70.0));
        assert!(!has(&grid, &region, 100.0, 160.0) && has(&grid, &region, 95.0, 160.0));
        assert_eq!(morphology::parts(&region).areas.len(), 1);
        assert_eq!(grid.outlines(&region).len(), 1, "no holes");
    }

    #[test]
    fn what_is_near_is_bridged_and_what_is_far_stays_apart() {
        let (_, near) = region_of(&["M 20 100 H 90", "M 120 100 H 190", "M 100 130 L 101 130"]);
        assert_eq!(morphology::parts(&near).areas.len(), 1);
        let (_, far) = region_of(&["M 20 20 H 40", "M 180 180 H 190"]);
        assert_eq!(morphology::parts(&far).areas.len(), 2);
    }

    #[test]
    fn a_dot_has_a_region_and_what_is_far_off_the_page_has_none() {
        let (grid, region) = region_of(&["M 50 50"]);
        assert!(has(&grid, &region, 50.0, 50.0) && !grid.outlines(&region).is_empty());
        let (grid, region) = region_of(&["M 50 50 h 20", "M 900000 900000 h 20"]);
        assert!(has(&grid, &region, 60.0, 50.0) && region.width() < 500);
    }
}
