//! A character's frames as pictures.
//!
//! The mesh is painted from the farthest to the nearest with the cut-out as its texture, whose opacity makes edges smooth.
//! The mesh ends where the drawing is half opaque, and cuts corners, so it is given a hem: a strip outward along its rim
//! that shows the rest of the drawing. Every pixel of the cut-out near the rim belongs to the stretch of rim nearest to
//! it, and the hem of another stretch does not show it: an arm that is raised takes nothing of the body along. Where a
//! nearer region borders on a farther one it is faded out over a pixel, so that where it lies over another part, the end of
//! it is smooth as well.
//!
//! Limits: shapes that are turned over, or cross others of the same depth, end in pixels there.

use std::collections::HashMap;

use glam::{IVec2, Vec2, ivec2, vec2};
use image::RgbaImage;

use super::{Character, Take, TakeFrame};
use crate::error::{Error, Result};
use crate::geometry::polygon;
use crate::raster::{Grid, Piece, Texture, paint};

/// The hem is at least so wide, in pixels: the half clear rim, and the sampling between its pixels.
const HEM: f32 = 1.5;
/// Corners that the rim cuts are at most this share of its longest edge away from it.
const CUT: f32 = 0.5;
/// The widest hem, in pixels.
const WIDEST: f32 = 48.0;
/// Stretches of rim are so many hems long: those beside a pixel's own may show it too.
const STRETCH: f32 = 4.0;
/// Where the rim turns into the drawing by more than this cosine says, a stretch ends.
const NOTCH: f32 = 0.5;
/// The hem's corners reach out at most by `sqrt(2 / this)` times its width.
const MITRE: f32 = 0.3;
/// A pixel that no stretch owns.
const NOBODY: u32 = u32::MAX - 1;
/// The largest canvas in pixels; larger frames could not be read back by the default [`crate::clip::ClipOptions`].
const MOST_PIXELS: u64 = 64 << 20;
/// The widest and tallest canvas: what PNG readers, browsers and the clip reader can hold.
const LONGEST: f64 = 65_535.0;

/// What pictures of a take show: a rectangle of the character's picture, the same in every frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Canvas {
    /// Width and height of the pictures.
    pub size: (u32, u32),
    /// Pixels a pixel of the character's picture.
    pub scale: f32,
    /// Where pixel (0, 0) of the pictures is, in pixels of the scaled picture.
    pub origin: IVec2,
}

impl Canvas {
    /// For a take: the character's picture, and with `grow` all that leaves it in any frame.
    ///
    /// # Errors
    /// A scale that is not above 0, and a canvas that is too large.
    pub fn new(character: &Character, take: &Take, scale: f32, grow: bool) -> Result<Self> {
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Error::invalid("scale", format!("is {scale}"), "give a number above 0"));
        }
        let picture = vec2(character.size.0 as f32, character.size.1 as f32);
        let (mut low, mut high) = (Vec2::ZERO, picture);
        if let Some((least, most)) = take.bounds().filter(|_| grow) {
            low = Vec2::select(least.cmplt(low), least - HEM, low);
            high = Vec2::select(most.cmpgt(high), most + HEM, high);
        }
        let scaled = |p: Vec2| p.as_dvec2() * f64::from(scale);
        let (low, high) = (scaled(low).floor(), scaled(high).ceil());
        let extent = (high - low).max(glam::DVec2::ONE);
        let pixels = extent.x * extent.y;
        if !(extent.max_element() <= LONGEST && pixels <= MOST_PIXELS as f64) {
            let remedy = "scale the pictures down, or show only the character's own picture".into();
            let what = format!("the pixel count of pictures that show every frame ({}x{})", extent.x, extent.y);
            return Err(Error::Limit { what, value: pixels as u64, max: MOST_PIXELS, remedy });
        }
        Ok(Self { size: (extent.x as u32, extent.y as u32), scale, origin: ivec2(low.x as i32, low.y as i32) })
    }

    /// Left, top, width and height of what is shown, in pixels of the character's picture.
    pub fn shown(&self) -> [i32; 4] {
        let part = |v: f64| v / f64::from(self.scale);
        let corner = |o: i32| part(f64::from(o)).floor();
        let far = |o: i32, n: u32| part(f64::from(o) + f64::from(n)).ceil();
        let (x, y) = (corner(self.origin.x), corner(self.origin.y));
        [x, y, far(self.origin.x, self.size.0) - x, far(self.origin.y, self.size.1) - y].map(|v| v as i32)
    }

    /// The place on the pictures of a place on the character's picture.
    pub fn place(&self, p: Vec2) -> Vec2 {
        p * self.scale - self.origin.as_vec2()
    }
}

/// A character with its cut-out, ready to be drawn in any frame. Threads may share it.
#[derive(Debug)]
pub struct Drawing<'a> {
    character: &'a Character,
    scale: f32,
    texture: Texture,
    /// Corners of the triangles in the texture.
    uv: Vec<Vec2>,
    hem: Hem,
    seams: Vec<Seam>,
}

impl<'a> Drawing<'a> {
    /// Of a character with its picture cut out ([`super::cut_out`]), to be drawn at this scale.
    ///
    /// # Errors
    /// A picture of another size.
    pub fn new(character: &'a Character, cut_out: &RgbaImage, scale: f32) -> Result<Self> {
        if cut_out.dimensions() != character.size {
            let ((w, h), (cw, ch)) = (cut_out.dimensions(), character.size);
            let problem = format!("is {w}x{h} pixels and the character's was {cw}x{ch}");
            return Err(Error::invalid("picture", problem, "give the picture that the character was made from"));
        }
        let (edges, seams) = edges(character);
        let (hem, zones) = Hem::new(character, &edges, cut_out, 1.0 / scale.min(1.0));
        let shrink = scale.min(1.0);
        let uv = character.mesh.points.iter().map(|p| *p * shrink).collect();
        Ok(Self { character, scale, texture: Texture::new(cut_out, &zones, shrink), uv, hem, seams })
    }

    /// The picture of a frame over a background, straight alpha. The frame must be of this character.
    pub fn draw(&self, frame: &TakeFrame, canvas: &Canvas, background: [u8; 4]) -> RgbaImage {
        let points: Vec<Vec2> = frame.points.iter().map(|p| canvas.place(*p)).collect();
        if points.len() != self.uv.len() {
            return RgbaImage::from_pixel(canvas.size.0, canvas.size.1, image::Rgba(background));
        }
        let mut fringe: Vec<(u32, [Piece; 2])> = self.hem.pieces(&points, &self.uv, self.scale);
        self.add_seams(&mut fringe, &points, &frame.depths);
        fringe.sort_by_key(|f| f.0);
        let mut pieces = Vec::with_capacity(self.character.mesh.triangles.len() + 2 * fringe.len());
        for t in self.character.draw_order(&frame.depths) {
            let corners = self.character.mesh.triangles[t as usize].map(|v| v as usize);
            pieces.push(Piece {
                at: corners.map(|v| points[v]),
                uv: corners.map(|v| self.uv[v]),
                opacity: [1.0; 3],
                zones: Piece::ALL,
            });
            let first = fringe.partition_point(|f| f.0 < t);
            pieces.extend(fringe[first..].iter().take_while(|f| f.0 == t).flat_map(|f| f.1));
        }
        paint(&pieces, &self.texture, canvas.size, background)
    }

    /// What fades a nearer region out over a farther one.
    fn add_seams(&self, fringe: &mut Vec<(u32, [Piece; 2])>, points: &[Vec2], depths: &[i32]) {
        for &(sides, ends) in &self.seams {
            let [one, other] = sides.map(|t| self.character.nearness(t, depths));
            let (near, [a, b]) = match one.cmp(&other) {
                std::cmp::Ordering::Equal => continue,
                std::cmp::Ordering::Greater => (sides[0], ends),
                std::cmp::Ordering::Less => (sides[1], [ends[1], ends[0]]),
            };
            let triangle = self.character.mesh.triangles[near as usize].map(|v| v as usize);
            let (at, uv) = (triangle.map(|v| points[v]), triangle.map(|v| self.uv[v]));
            let [a, b] = [a, b].map(|v| v as usize);
            let out = outward(points[a], points[b]);
            let onto = |p: Vec2| {
                let area = (at[1] - at[0]).perp_dot(at[2] - at[0]);
                let share = |i: usize| (at[(i + 1) % 3] - p).perp_dot(at[(i + 2) % 3] - p) / area;
                uv[0] * share(0) + uv[1] * share(1) + uv[2] * share(2)
            };
            let outer = [points[a] + out, points[b] + out];
            let piece = |at: [Vec2; 3], opacity| Piece { at, uv: at.map(onto), opacity, zones: Piece::ALL };
            let pieces = [
                piece([points[a], points[b], outer[1]], [1.0, 1.0, 0.0]),
                piece([points[a], outer[1], outer[0]], [1.0, 0.0, 0.0]),
            ];
            fringe.push((near, pieces));
        }
    }
}

/// Out of the mesh, which lies on the right of the way from `a` to `b`; of length 1, or 0.
fn outward(a: Vec2, b: Vec2) -> Vec2 {
    -(b - a).perp().normalize_or_zero()
}

/// The triangle of each rim edge, by the edge's ends in the triangle's order.
type RimEdges = HashMap<[u32; 2], u32>;
/// An inner edge: its two triangles, and its ends in the first one's order.
type Seam = ([u32; 2], [u32; 2]);

fn edges(character: &Character) -> (RimEdges, Vec<Seam>) {
    let mut open: HashMap<[u32; 2], (u32, [u32; 2])> = HashMap::new();
    let mut seams = Vec::new();
    for (t, &[a, b, c]) in character.mesh.triangles.iter().enumerate() {
        for ends @ [a, b] in [[a, b], [b, c], [c, a]] {
            let key = [a.min(b), a.max(b)];
            match open.remove(&key) {
                Some((first, ends)) => seams.push(([first, t as u32], ends)),
                None => drop(open.insert(key, (t as u32, ends))),
            }
        }
    }
    (open.into_values().map(|(t, ends)| (ends, t)).collect(), seams)
}

/// The strip around the mesh.
#[derive(Debug)]
struct Hem {
    edges: Vec<HemEdge>,
    /// At rest, in the texture's pixels: the outer end at both ends of each edge.
    outer: Vec<[Vec2; 2]>,
}

#[derive(Debug)]
struct HemEdge {
    ends: [u32; 2],
    triangle: u32,
    /// The edges before and after it on the rim.
    beside: [Option<usize>; 2],
    width: f32,
    zones: [u32; 3],
}

impl Hem {
    /// And the zone of every pixel of the cut-out. What is sampled is `texel` pixels wide.
    fn new(character: &Character, rim_edges: &RimEdges, cut_out: &RgbaImage, texel: f32) -> (Self, Grid<u32>) {
        let points = &character.mesh.points;
        let mut edges: Vec<HemEdge> = Vec::new();
        let length = |[a, b]: &[u32; 2]| points[*a as usize].distance(points[*b as usize]);
        let longest = rim_edges.keys().map(length).fold(0.0, f32::max);
        let reach = (CUT * longest).clamp(2.0 * HEM, WIDEST).max(2.0 * HEM * texel);
        let mut zones = 0;
        for rim in character.mesh.rims() {
            let begin = edges.len();
            for (i, &a) in rim.iter().enumerate() {
                let ends = [a, rim[(i + 1) % rim.len()]];
                let Some(&triangle) = rim_edges.get(&ends) else { continue };
                edges.push(HemEdge { ends, triangle, beside: [None; 2], width: HEM * texel, zones: [0; 3] });
            }
            join(&mut edges[begin..], begin, points, STRETCH * reach, &mut zones);
        }
        let zones = own(&mut edges, points, cut_out, reach, texel);
        let mut own = Self { edges, outer: Vec::new() };
        own.outer = own.outer_ends(points, 1.0);
        (own, zones)
    }

    /// The outer ends of all edges with the vertices at `points`.
    fn outer_ends(&self, points: &[Vec2], scale: f32) -> Vec<[Vec2; 2]> {
        let out = |e: &HemEdge| outward(points[e.ends[0] as usize], points[e.ends[1] as usize]);
        self.edges
            .iter()
            .map(|e| {
                let own = out(e);
                [0, 1].map(|end| {
                    let beside = e.beside[end].map(|i| &self.edges[i]);
                    let other = beside.map_or(own, out);
                    let width = beside.map_or(e.width, |b| e.width.max(b.width));
                    // The same sum, whichever of the two edges asks.
                    let way = (own + other) / (1.0 + own.dot(other)).max(MITRE);
                    points[e.ends[end] as usize] + way * (width * scale)
                })
            })
            .collect()
    }

    fn pieces(&self, points: &[Vec2], uv: &[Vec2], scale: f32) -> Vec<(u32, [Piece; 2])> {
        let outer = self.outer_ends(points, scale);
        let shrink = scale.min(1.0);
        let quad = |(i, e): (usize, &HemEdge)| {
            let [a, b] = e.ends.map(|v| v as usize);
            let (inner_uv, outer_uv) = ([uv[a], uv[b]], self.outer[i].map(|p| p * shrink));
            let piece = |at, uv| Piece { at, uv, opacity: [1.0; 3], zones: e.zones };
            let pieces = [
                piece([points[a], points[b], outer[i][1]], [inner_uv[0], inner_uv[1], outer_uv[1]]),
                piece([points[a], outer[i][1], outer[i][0]], [inner_uv[0], outer_uv[1], outer_uv[0]]),
            ];
            (e.triangle, pieces)
        };
        self.edges.iter().enumerate().map(quad).collect()
    }
}

/// Links the edges of one rim, the first of which has the index `begin`, and divides it into stretches.
fn join(rim: &mut [HemEdge], begin: usize, points: &[Vec2], stretch: f32, zones: &mut u32) {
    let count = rim.len();
    let way = |e: &HemEdge| points[e.ends[1] as usize] - points[e.ends[0] as usize];
    let mut of_edge = vec![0u32; count];
    // For each stretch, whether it goes on in the next one.
    let mut goes_on: Vec<bool> = Vec::new();
    let mut passed = f32::INFINITY;
    let notch: Vec<bool> = (0..count)
        .map(|i| {
            let (before, own) = (way(&rim[(i + count - 1) % count]), way(&rim[i]));
            let (before, own) = (before.normalize_or_zero(), own.normalize_or_zero());
            before.perp_dot(own) < 0.0 && before.dot(own) < NOTCH
        })
        .collect();
    for i in 0..count {
        let follows = rim[(i + count - 1) % count].ends[1] == rim[i].ends[0];
        if follows && count > 1 {
            rim[i].beside[0] = Some(begin + (i + count - 1) % count);
            rim[(i + count - 1) % count].beside[1] = Some(begin + i);
        }
        if !follows || notch[i] || passed >= stretch {
            if let Some(last) = goes_on.last_mut() {
                *last = follows && !notch[i];
            }
            goes_on.push(true);
            passed = 0.0;
        }
        of_edge[i] = goes_on.len() as u32 - 1;
        passed += way(&rim[i]).length();
    }
    let stretches = goes_on.len() as u32;
    if let Some(last) = goes_on.last_mut() {
        *last = rim[0].beside[0].is_some() && !notch[0];
    }
    for (edge, own) in rim.iter_mut().zip(of_edge) {
        let next = (own + 1) % stretches;
        let before = (own + stretches - 1) % stretches;
        let near = |to: u32, joined: bool| *zones + if joined { to } else { own };
        edge.zones = [*zones + own, near(before, goes_on[before as usize]), near(next, goes_on[own as usize])];
    }
    *zones += stretches;
}

/// The zone of every pixel within `reach` of the rim: that of the nearest edge. Widens the hem to what its edges own.
fn own(edges: &mut [HemEdge], points: &[Vec2], cut_out: &RgbaImage, reach: f32, texel: f32) -> Grid<u32> {
    let (width, height) = (cut_out.width() as usize, cut_out.height() as usize);
    let mut owner = Grid::new(width, height, (reach * reach, u32::MAX));
    for (i, edge) in edges.iter().enumerate() {
        let [a, b] = edge.ends.map(|v| points[v as usize]);
        let (low, high) = ((a.min(b) - reach).max(Vec2::ZERO), a.max(b) + reach + 1.0);
        for y in low.y as usize..(high.y.max(0.0) as usize).min(height) {
            for x in low.x as usize..(high.x.max(0.0) as usize).min(width) {
                let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
                let gap = polygon::nearest_on_segment(a, b, p).1.distance_squared(p);
                if gap < owner.get(x, y).0 {
                    owner.set(x, y, (gap, i as u32));
                }
            }
        }
    }
    for (i, (gap, edge)) in owner.data().iter().enumerate() {
        let Some(edge) = edges.get_mut(*edge as usize) else { continue };
        let (x, y) = (i % width, i / width);
        let [a, b] = edge.ends.map(|v| points[v as usize]);
        let outside = (b - a).perp_dot(vec2(x as f32 + 0.5, y as f32 + 0.5) - a) < 0.0;
        if outside && cut_out.get_pixel(x as u32, y as u32).0[3] > 0 {
            edge.width = edge.width.max(gap.sqrt() + texel);
        }
    }
    let zone = |(_, edge): &(f32, u32)| edges.get(*edge as usize).map_or(NOBODY, |e| e.zones[0]);
    Grid::from_vec(width, height, owner.data().iter().map(zone).collect())
}
