//! Fits the skin to the silhouettes of all frames.
//!
//! Method: in every frame the skin is posed and drawn; a vertex on its outline looks along its normal for the outline of
//! the frame's mask, and each place on that outline for the nearest vertex, so that tips come out. What the frames want of a vertex is a displacement along its rest normal; the displacements of all
//! vertices are the smooth ones that explain these wishes best (a membrane over the mesh with robust weights, one sparse
//! system by conjugate gradients). Vertices that are never on an outline follow those that are.

use glam::{Mat4, Vec2, Vec3, vec2};
use rayon::prelude::*;

use super::super::bones::Bones;
use super::super::limb::LimbShape;
use super::ring::{Neighbours, normals};
use super::weights::Binding;
use crate::error::Result;
use crate::geometry::TriMesh;
use crate::job::Stage;
use crate::raster::{Mask, Rasterizer, Surface, clip_view};

/// Rounds of drawing and fitting.
const ROUNDS: usize = 8;
/// What the rest frame and the other key frames count against all frames together: they must be met.
const REST_SHARE: f32 = 15.0;
const KEY_SHARE: f32 = 1.0;
/// What a place on the mask's outline counts against a vertex on the skin's: there are about four of them for each.
const BORDER: f32 = 0.5;
/// An outline is the one looked for when its normal is less far off than this cosine.
const ALIKE: f32 = 0.3;
/// A vertex that moves the outline by less for a unit of its own says little.
const LEAST_GAIN: f32 = 0.3;
/// Beyond this share of the reach a distance is doubted.
const DOUBT: f32 = 0.4;
/// Weight of the membrane against one certain vertex, and of staying where it is against the membrane.
const MEMBRANE: f32 = 0.15;
const STAY: f32 = 1e-3;
/// Displacements keep to the image plane: outlines say nothing of depth, which the limbs' cross-sections give. Growing it
/// with the outline lost seven points of the horse's 3D IoU.
const FLAT: Vec3 = Vec3::new(1.0, 1.0, 0.0);
/// Steps of conjugate gradients a round.
const STEPS: usize = 120;

/// What is fitted.
pub(super) struct Fit<'a> {
    pub triangles: &'a [[u32; 3]],
    pub ring: &'a Neighbours,
    pub binding: &'a Binding,
    pub masks: &'a [Mask],
    pub rest: usize,
    pub keys: &'a [usize],
    /// How far an outline is looked for, in clip pixels.
    pub reach: f32,
}

/// What a vertex on the outline wants in one frame.
pub(super) struct Wish {
    pub vertex: u32,
    /// Where it is in the image.
    pub at: Vec2,
    /// The outline's normal in the image.
    pub normal: Vec2,
    /// How far the outline moves along it for a unit of displacement of the vertex.
    pub gain: f32,
    /// How far it should move.
    pub distance: f32,
    /// What it counts.
    pub weight: f32,
}

/// A place on a mask's outline and the normal there, outward.
type Border = (Vec2, Vec2);

impl Fit<'_> {
    /// Fits the vertices (rest pose) and the limbs' axes, with the bones on them.
    pub(super) fn run(
        &self,
        places: &mut [Vec3],
        limbs: &mut [LimbShape],
        order: &[usize],
        bones: &mut Bones,
        max_bones: usize,
        stage: Stage<'_>,
    ) -> Result<()> {
        let borders: Vec<Vec<Border>> = self.masks.par_iter().map(border).collect();
        for round in 0..ROUNDS {
            let rest_normals = normals(places, self.triangles);
            let skins = super::skin_matrices(bones, self.rest);
            let mut wishes: Vec<Vec<Wish>> = (0..self.masks.len())
                .into_par_iter()
                .map(|f| {
                    stage.at(round as f64 / ROUNDS as f64)?;
                    Ok(self.wishes(places, &rest_normals, &skins[f], &self.masks[f], &borders[f]))
                })
                .collect::<Result<_>>()?;
            if round + 1 < ROUNDS {
                let moves = super::posing::moves(&mut wishes, self, bones);
                super::posing::apply(&moves, limbs, bones);
                *bones = super::super::bones::lay(limbs, order, self.masks.len(), max_bones);
            }
            let moved = self.displacements(&wishes);
            for (v, p) in places.iter_mut().enumerate() {
                *p += rest_normals[v] * FLAT * moved[v];
            }
        }
        Ok(())
    }

    /// How much a wish counts among those of its frame: far ones are doubted.
    pub(super) fn trust(&self, wish: &Wish) -> f32 {
        wish.weight / (1.0 + (wish.distance / (DOUBT * self.reach)).powi(2)).powi(2)
    }

    /// The displacement of each vertex along its rest normal.
    fn displacements(&self, wishes: &[Vec<Wish>]) -> Vec<f32> {
        let mut sums = vec![[0.0f32; 3]; self.ring.len()];
        let frames = wishes.len() as f32;
        for (f, wishes) in wishes.iter().enumerate() {
            let weight = if f == self.rest {
                (REST_SHARE * frames).max(1.0)
            } else if self.keys.contains(&f) {
                (KEY_SHARE * frames).max(1.0)
            } else {
                1.0
            };
            for wish in wishes {
                let (w, c) = (weight * self.trust(wish), wish.gain);
                let s = &mut sums[wish.vertex as usize];
                *s = [s[0] + w * c * c, s[1] + w * c * wish.distance, s[2] + w];
            }
        }
        let data: Vec<(f32, f32)> = sums
            .iter()
            .map(|s| {
                let scale = if s[2] > 0.0 { s[2].min(1.0) / s[2] } else { 0.0 };
                (s[0] * scale, s[1] * scale)
            })
            .collect();
        membrane(&data, self.ring)
    }

    /// What the vertices on the outline want in a frame.
    fn wishes(
        &self,
        places: &[Vec3],
        rest_normals: &[Vec3],
        skin: &[Mat4],
        mask: &Mask,
        border: &[Border],
    ) -> Vec<Wish> {
        let (w, h) = (mask.width(), mask.height());
        let now = posed(places, self.binding, skin);
        let mesh = TriMesh {
            positions: now.iter().map(|p| p.0).collect(),
            triangles: self.triangles.to_vec(),
            ..TriMesh::default()
        };
        let mut picture = Rasterizer::new(w as u32, h as u32);
        picture.draw(&mesh, &clip_view(h as u32), Surface::Bare, 0);
        let drawn = |p: Vec2| {
            p.x >= 0.0
                && p.y >= 0.0
                && p.x < w as f32
                && p.y < h as f32
                && picture.id.get(p.x as usize, p.y as usize) == 0
        };
        let normal = normals(&mesh.positions, self.triangles);
        let mut outline = Vec::new();
        for (v, n) in normal.iter().enumerate() {
            if n.z.abs() > 0.6 {
                continue;
            }
            let flat = vec2(n.x, -n.y).normalize_or_zero();
            let p = mesh.positions[v];
            let at = vec2(p.x, h as f32 - p.y);
            if drawn(at + flat * 1.5) || !drawn(at - flat * 1.5) {
                continue;
            }
            let m = now[v].1.transform_vector3(rest_normals[v]);
            outline.push(Edge { vertex: v as u32, at, normal: flat, moved: vec2(m.x, -m.y) });
        }
        let mut out = Vec::new();
        let mut push = |edge: &Edge, normal: Vec2, distance: f32, weight: f32| {
            let gain = edge.moved.dot(normal);
            if gain > LEAST_GAIN {
                out.push(Wish { vertex: edge.vertex, at: edge.at, normal, gain, distance, weight });
            }
        };
        for edge in &outline {
            if let Some(d) = to_outline(mask, edge.at, edge.normal, self.reach) {
                push(edge, edge.normal, d, 1.0);
            }
        }
        // The other way round: what the mask shows and the skin does not reach.
        outline.sort_by(|a, b| a.at.x.total_cmp(&b.at.x).then(a.vertex.cmp(&b.vertex)));
        for (at, normal) in border {
            let first = outline.partition_point(|e| e.at.x < at.x - self.reach);
            let near = outline[first..].iter().take_while(|e| e.at.x <= at.x + self.reach);
            let alike = near.filter(|e| e.normal.dot(*normal) > ALIKE);
            let nearest = alike.min_by(|a, b| a.at.distance_squared(*at).total_cmp(&b.at.distance_squared(*at)));
            if let Some(edge) = nearest.filter(|e| e.at.distance(*at) < self.reach) {
                push(edge, *normal, (*at - edge.at).dot(*normal), BORDER);
            }
        }
        out
    }
}

/// A vertex on the outline of what is drawn.
struct Edge {
    vertex: u32,
    at: Vec2,
    normal: Vec2,
    /// Where it goes in the image for a unit along its rest normal.
    moved: Vec2,
}

/// The outline of a mask, a place a pixel. Where the image ends, the outline is not the creature's.
fn border(mask: &Mask) -> Vec<Border> {
    let (w, h) = (mask.width() as isize, mask.height() as isize);
    let mut out = Vec::new();
    for y in 2..h - 2 {
        for x in 2..w - 2 {
            if !mask.at(x, y) || [(1, 0), (-1, 0), (0, 1), (0, -1)].iter().all(|(i, j)| mask.at(x + i, y + j)) {
                continue;
            }
            let mut slope = Vec2::ZERO;
            let mut share = 0.0;
            for j in -2..=2isize {
                for i in -2..=2isize {
                    if mask.at(x + i, y + j) {
                        slope -= vec2(i as f32, j as f32);
                        share += 1.0 / 25.0;
                    }
                }
            }
            if let Some(normal) = slope.try_normalize() {
                // A straight outline leaves half of the window, and what is more or less says how far off it is.
                let off = 5.0 * (share - 0.5);
                out.push((vec2(x as f32 + 0.5, y as f32 + 0.5) + normal * off, normal));
            }
        }
    }
    out
}

/// Poses the vertices; what moves each.
fn posed(places: &[Vec3], binding: &Binding, skin: &[Mat4]) -> Vec<(Vec3, Mat4)> {
    (0..places.len())
        .map(|v| {
            let mut blend = Mat4::ZERO;
            for (bone, weight) in binding.bones[v].iter().zip(binding.weights[v]) {
                if weight > 0.0 {
                    blend += skin[usize::from(*bone)] * weight;
                }
            }
            (blend.transform_point3(places[v]), blend)
        })
        .collect()
}

/// How far along `normal` the mask's outline is: outward from a place inside, inward from one outside.
fn to_outline(mask: &Mask, at: Vec2, normal: Vec2, reach: f32) -> Option<f32> {
    const STEP: f32 = 0.5;
    let inside = |t: f32| soft(mask, at + normal * t);
    let start = inside(0.0)? - 0.5;
    let sign = if start > 0.0 { 1.0 } else { -1.0 };
    let (mut before, mut t) = (start, 0.0);
    while t < reach {
        t += STEP;
        let value = inside(sign * t)? - 0.5;
        if (value > 0.0) != (start > 0.0) {
            return Some(sign * (t - STEP + STEP * before / (before - value)));
        }
        before = value;
    }
    None
}

/// The mask between pixels, over two by two of them; `None` at the image's border, where the outline is not the creature's.
fn soft(mask: &Mask, p: Vec2) -> Option<f32> {
    let q = p - 1.0;
    let (x, y) = (q.x.floor(), q.y.floor());
    if !(x >= 0.0 && y >= 0.0 && x + 2.0 < mask.width() as f32 && y + 2.0 < mask.height() as f32) {
        return None;
    }
    // A box of two pixels over pixels: three columns and rows with weights 1 - f, 1, f.
    let (fx, fy) = (q.x - x, q.y - y);
    let mut sum = 0.0;
    for (j, wy) in [1.0 - fy, 1.0, fy].into_iter().enumerate() {
        for (i, wx) in [1.0 - fx, 1.0, fx].into_iter().enumerate() {
            if mask.get(x as usize + i, y as usize + j) {
                sum += wx * wy;
            }
        }
    }
    Some(sum / 4.0)
}

/// The displacements s that minimise sum a s^2 - 2 b s + MEMBRANE sum over edges (s_i - s_j)^2 + a little s^2.
fn membrane(data: &[(f32, f32)], ring: &Neighbours) -> Vec<f32> {
    let n = ring.len();
    let diagonal: Vec<f32> = (0..n).map(|v| data[v].0 + MEMBRANE * (ring.of(v).len() as f32 + STAY)).collect();
    let apply = |x: &[f32]| -> Vec<f32> {
        (0..n)
            .into_par_iter()
            .map(|v| diagonal[v] * x[v] - MEMBRANE * ring.of(v).iter().map(|&o| x[o as usize]).sum::<f32>())
            .collect()
    };
    let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>();
    let mut x = vec![0.0f32; n];
    let mut r: Vec<f32> = data.iter().map(|d| d.1).collect();
    let mut z: Vec<f32> = r.iter().zip(&diagonal).map(|(r, d)| r / d).collect();
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    for _ in 0..STEPS {
        if rz < 1e-9 {
            break;
        }
        let ap = apply(&p);
        let along = dot(&p, &ap);
        if along <= 0.0 {
            break;
        }
        let alpha = (rz / along) as f32;
        for i in 0..n {
            x[i] += alpha * p[i];
            r[i] -= alpha * ap[i];
            z[i] = r[i] / diagonal[i];
        }
        let next = dot(&r, &z);
        let beta = (next / rz) as f32;
        rz = next;
        for i in 0..n {
            p[i] = z[i] + beta * p[i];
        }
    }
    x
}
