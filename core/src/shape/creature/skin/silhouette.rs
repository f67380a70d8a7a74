//! Fits the skin to the silhouettes of all frames.
//!
//! Method: in every frame the skin is posed and drawn; a vertex on its outline looks along its normal for the outline of
//! the frame's mask. What the frames want of a vertex is a displacement along its rest normal; the displacements of all
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
const ROUNDS: usize = 5;
/// What the rest frame and the other key frames count against all frames together: they must be met.
const REST_SHARE: f32 = 1.5;
const KEY_SHARE: f32 = 0.5;
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
    /// The outline's normal in the image.
    pub normal: Vec2,
    /// How far the outline moves along it for a unit of displacement of the vertex.
    pub gain: f32,
    /// How far it should move.
    pub distance: f32,
}

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
        for round in 0..ROUNDS {
            let rest_normals = normals(places, self.triangles);
            let skins = super::skin_matrices(bones, self.rest);
            let mut wishes: Vec<Vec<Wish>> = (0..self.masks.len())
                .into_par_iter()
                .map(|f| {
                    stage.at(round as f64 / ROUNDS as f64)?;
                    Ok(self.wishes(places, &rest_normals, &skins[f], &self.masks[f]))
                })
                .collect::<Result<_>>()?;
            if round + 1 < ROUNDS {
                let moves = super::posing::moves(&wishes, self, bones);
                super::posing::apply(&moves, limbs, bones);
                *bones = super::super::bones::lay(limbs, order, self.masks.len(), max_bones);
                for (wishes, moves) in wishes.iter_mut().zip(&moves) {
                    for wish in wishes {
                        wish.distance -= wish.normal.dot(super::posing::of_vertex(moves, self.binding, wish.vertex));
                    }
                }
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
        1.0 / (1.0 + (wish.distance / (0.4 * self.reach)).powi(2)).powi(2)
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
    fn wishes(&self, places: &[Vec3], rest_normals: &[Vec3], skin: &[Mat4], mask: &Mask) -> Vec<Wish> {
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
        let mut out = Vec::new();
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
            let Some(d) = to_outline(mask, at, flat, self.reach) else { continue };
            let m = now[v].1.transform_vector3(rest_normals[v]);
            let c = vec2(m.x, -m.y).dot(flat);
            if c > 0.3 {
                out.push(Wish { vertex: v as u32, normal: flat, gain: c, distance: d });
            }
        }
        out
    }
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
