//! Texture coordinates for the skin: one atlas of few charts.
//!
//! Each limb has a chart of what faces the clip's camera in the rest frame and one of what faces away, flattened along the
//! view: a texel is a pixel of the clip, so nothing that the clip shows is lost, and what a chart's neighbour shows lies
//! in the same place. Seams run along the outline and between limbs; there both sides hold the same colours. Vertices on a
//! seam are doubled: same place, same bones and weights, so the surface stays closed in every pose.
//!
//! Limit: what folds over itself within one limb and one side (a curled tail) shares texels; surfaces seen edge on have few.

use glam::{Vec2, Vec3, vec2};
use image::{Rgb, RgbImage};

use crate::clip::FrameImage;
use crate::raster::{Grid, Mask, Wrap, push_pull};

/// Texels between charts, so that readers between texels and smaller sizes of the texture see no other chart.
const GUTTER: f32 = 8.0;
/// Longest side of an atlas in texels, about.
const LARGEST: f32 = 4096.0;
/// Rounds in which a triangle takes the side and limb of most of its neighbours.
const ROUNDS: usize = 12;
/// A chart of fewer triangles joins its neighbour.
const SMALLEST: usize = 24;

/// Texture coordinates, and which vertices they need.
pub(in super::super) struct Atlas {
    /// For each vertex of the textured mesh, the vertex of the surface.
    pub vertex: Vec<u32>,
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
    /// The chart of each triangle.
    pub chart: Vec<u32>,
    charts: Vec<Chart>,
    /// Texels a pixel of the clip: 1, or less for a creature that is larger than a texture may be.
    scale: f32,
    /// Width and height in texels.
    pub size: (u32, u32),
}

struct Chart {
    /// Its top left corner in the atlas and in the clip, and its size.
    corner: Vec2,
    low: Vec2,
    extent: Vec2,
    limb: u16,
    /// Whether it faces the camera.
    front: bool,
}

impl Atlas {
    /// The atlas of a closed surface in the rest pose; `limb` is the limb of each vertex.
    pub(in super::super) fn new(places: &[Vec3], triangles: &[[u32; 3]], limb: &[u16], clip_height: f32) -> Self {
        let (chart, labels) = charts(places, triangles, limb);
        let flat = |p: Vec3| vec2(p.x, clip_height - p.y);
        let mut bounds = vec![(Vec2::INFINITY, Vec2::NEG_INFINITY); labels.len()];
        for (t, chart) in triangles.iter().zip(&chart) {
            let [a, b, c] = t.map(|v| flat(places[v as usize]));
            let bound = &mut bounds[*chart as usize];
            bound.0 = bound.0.min(a).min(b).min(c);
            bound.1 = bound.1.max(a).max(b).max(c);
        }
        let widest = bounds.iter().map(|(low, high)| (*high - *low).max_element()).fold(1.0, f32::max);
        let area: f32 =
            bounds.iter().map(|(low, high)| ((*high - *low).x + GUTTER) * ((*high - *low).y + GUTTER)).sum();
        let scale = (LARGEST / widest).min(LARGEST / (1.5 * area).sqrt()).min(1.0);
        let mut charts: Vec<Chart> = bounds
            .into_iter()
            .zip(labels)
            .map(|((low, high), (limb, front))| {
                let low = low.floor();
                let extent = ((high - low) * scale).ceil().max(Vec2::ONE);
                Chart { corner: Vec2::ZERO, low, extent, limb, front }
            })
            .collect();
        let size = pack(&mut charts);
        let whole = vec2(size.0 as f32, size.1 as f32);
        let mut out = Self { vertex: Vec::new(), uvs: Vec::new(), triangles: Vec::new(), chart, charts, scale, size };
        let mut corners: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
        for (i, t) in triangles.iter().enumerate() {
            corners.extend(t.iter().enumerate().map(|(k, v)| (*v, out.chart[i], (3 * i + k) as u32)));
        }
        corners.sort_unstable();
        let mut flat_triangles = vec![0u32; 3 * triangles.len()];
        let mut last = None;
        for (v, c, at) in corners {
            if last != Some((v, c)) {
                last = Some((v, c));
                let chart = &out.charts[c as usize];
                out.vertex.push(v);
                out.uvs.push((chart.corner + (flat(places[v as usize]) - chart.low) * scale) / whole);
            }
            flat_triangles[at as usize] = out.vertex.len() as u32 - 1;
        }
        out.triangles = flat_triangles.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        out
    }

    /// How many charts there are.
    pub(super) fn charts(&self) -> usize {
        self.charts.len()
    }

    /// The triangles of a chart.
    pub(super) fn of_chart(&self, chart: usize) -> Vec<[u32; 3]> {
        let own = self.triangles.iter().zip(&self.chart).filter(|(_, c)| **c as usize == chart);
        own.map(|(t, _)| *t).collect()
    }

    /// The texels of a chart and half its gutter, with the clip's pixel that each shows.
    fn texels(&self, chart: &Chart) -> impl Iterator<Item = (usize, Vec2)> + use<> {
        let margin = (GUTTER / 2.0) as i32;
        let (width, scale, corner, low) = (self.size.0 as usize, self.scale, chart.corner, chart.low);
        let (columns, rows) = (chart.extent.x as i32 + margin, chart.extent.y as i32 + margin);
        (-margin..rows).flat_map(move |y| {
            (-margin..columns).map(move |x| {
                let at = corner + vec2(x as f32, y as f32);
                let p = low + vec2(x as f32 + 0.5, y as f32 + 0.5) / scale;
                (at.y as usize * width + at.x as usize, p)
            })
        })
    }

    /// The colours of the rest frame: what faces the camera as it is seen, what faces away as its mirror image.
    /// `seen` tells which chart the camera sees at a pixel.
    pub(super) fn paint(&self, image: &FrameImage, mask: &Mask, seen: &Grid<u16>, default: [f32; 3]) -> RgbImage {
        let (w, h) = (self.size.0 as usize, self.size.1 as usize);
        let mut color = vec![[0.0f32; 3]; w * h];
        let mut known = Grid::new(w, h, false);
        for (c, chart) in self.charts.iter().enumerate().filter(|(_, c)| c.front) {
            for (at, p) in self.texels(chart) {
                let (x, y) = (p.x.floor() as isize, p.y.floor() as isize);
                let inside = [(0, 0), (2, 0), (-2, 0), (0, 2), (0, -2)].iter().all(|(i, j)| mask.at(x + i, y + j));
                if inside && usize::from(seen.get(x as usize, y as usize)) == c {
                    color[at] = image.get_pixel(x as u32, y as u32).0.map(f32::from);
                    known.data_mut()[at] = true;
                }
            }
        }
        push_pull(&mut color, &known, Wrap::default(), default);
        // What faces away takes what lies before it on the same limb, completed: along the outline both sides agree.
        for chart in self.charts.iter().filter(|c| !c.front) {
            let before: Vec<&Chart> = self.charts.iter().filter(|f| f.front && f.limb == chart.limb).collect();
            for (at, p) in self.texels(chart) {
                let place = before.iter().find_map(|f| {
                    let q = (p - f.low) * self.scale;
                    (q.min_element() >= 0.0 && (f.extent - q).min_element() > 0.0).then_some(f.corner + q)
                });
                if let Some(from) = place {
                    color[at] = color[from.y as usize * w + from.x as usize];
                }
            }
        }
        RgbImage::from_fn(w as u32, h as u32, |x, y| {
            Rgb(color[y as usize * w + x as usize].map(|v| v.round().clamp(0.0, 255.0) as u8))
        })
    }
}

/// The chart of each triangle, connected, on one limb, on one side; and each chart's limb and whether it faces the camera.
fn charts(places: &[Vec3], triangles: &[[u32; 3]], limb: &[u16]) -> (Vec<u32>, Vec<(u16, bool)>) {
    let across = beside(triangles);
    let mut label: Vec<(u16, bool)> = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| places[v as usize]);
            let limbs = t.map(|v| limb[v as usize]);
            let main = if limbs[1] == limbs[2] { limbs[1] } else { limbs[0] };
            (main, (b - a).cross(c - a).z >= 0.0)
        })
        .collect();
    for _ in 0..ROUNDS {
        let before = label.clone();
        for (t, own) in label.iter_mut().enumerate() {
            let [a, b, c] = across[t].map(|o| before[o as usize]);
            if a == b || a == c {
                *own = a;
            } else if b == c {
                *own = b;
            }
        }
    }
    let mut number = vec![u32::MAX; triangles.len()];
    loop {
        let mut charts: Vec<Vec<usize>> = Vec::new();
        number.fill(u32::MAX);
        for start in 0..triangles.len() {
            if number[start] != u32::MAX {
                continue;
            }
            let (mut members, mut at, next) = (vec![start], 0, charts.len() as u32);
            number[start] = next;
            while at < members.len() {
                for &o in &across[members[at]] {
                    let o = o as usize;
                    if number[o] == u32::MAX && label[o] == label[start] {
                        number[o] = next;
                        members.push(o);
                    }
                }
                at += 1;
            }
            charts.push(members);
        }
        // Who joins, and who is joined, waits for the next pass: every pass that changes something leaves fewer charts.
        let mut done = vec![false; charts.len()];
        for (c, members) in charts.iter().enumerate().filter(|(_, members)| members.len() < SMALLEST) {
            let mut outside = members.iter().flat_map(|&t| across[t]).map(|o| o as usize);
            let other = outside.find(|&o| number[o] as usize != c && !done[number[o] as usize]);
            if let Some(other) = other.filter(|_| !done[c]) {
                (done[c], done[number[other] as usize]) = (true, true);
                let joined = label[other];
                members.iter().for_each(|&t| label[t] = joined);
            }
        }
        if !done.contains(&true) {
            return (number, charts.iter().map(|members| label[members[0]]).collect());
        }
    }
}

/// The three triangles beside each; itself where there is none.
pub(super) fn beside(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<(u32, u32, u32, u8)> = Vec::with_capacity(3 * triangles.len());
    for (t, tri) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (tri[k], tri[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), t as u32, k as u8));
        }
    }
    edges.sort_unstable();
    let mut out: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|t| [t; 3]).collect();
    for pair in edges.windows(2) {
        let (p, q) = (pair[0], pair[1]);
        if (p.0, p.1) == (q.0, q.1) {
            out[p.2 as usize][usize::from(p.3)] = q.2;
            out[q.2 as usize][usize::from(q.3)] = p.2;
        }
    }
    out
}

/// Lays the charts in rows, tallest first; the atlas' size.
fn pack(charts: &mut [Chart]) -> (u32, u32) {
    let area: f32 = charts.iter().map(|c| (c.extent.x + GUTTER) * (c.extent.y + GUTTER)).sum();
    let widest = charts.iter().map(|c| c.extent.x).fold(0.0, f32::max) + 2.0 * GUTTER;
    let width = (1.15 * area).sqrt().max(widest).ceil().max(16.0);
    let mut order: Vec<usize> = (0..charts.len()).collect();
    order.sort_by(|&a, &b| charts[b].extent.y.total_cmp(&charts[a].extent.y).then(a.cmp(&b)));
    let (mut at, mut row) = (Vec2::splat(GUTTER), 0.0f32);
    for i in order {
        let chart = &mut charts[i];
        if at.x + chart.extent.x + GUTTER > width {
            at = vec2(GUTTER, at.y + row + GUTTER);
            row = 0.0;
        }
        chart.corner = at;
        at.x += chart.extent.x + GUTTER;
        row = row.max(chart.extent.y);
    }
    (width as u32, (at.y + row + GUTTER).ceil().max(16.0) as u32)
}
