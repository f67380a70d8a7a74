//! The texels of a model: which place on the surface each one shows, and which ones lie side by side on it.
//!
//! Every triangle is drawn into its part's texture; a texel belongs to the triangle that its centre lies in (the first,
//! where triangles overlap). Texels are neighbours when they touch in the texture and lie close together on the
//! surface, or when they face each other over a seam: an edge of two triangles that has one place in space and two in
//! the texture.
//!
//! Limits: a chart thinner than a texel may cover no centre, and is then coloured by its surroundings.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use crate::error::{Error, Result};
use crate::geometry::TriMesh;
use crate::job::Stage;
use crate::raster::Grid;
use crate::shape::{RiggedModel, SkinnedPart};

/// More texels than this take more memory than a bake may (about 100 bytes each).
const MAX_TEXELS: usize = 1 << 24;
/// Texels that touch in the texture are apart on the surface when they are this many times farther than usual.
const APART: f32 = 6.0;

/// A texel whose centre lies on the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texel {
    pub part: u16,
    /// Row-major in the part's texture.
    pub at: u32,
    pub triangle: u32,
    /// The shares of the triangle's second and third corner.
    pub share: [f32; 2],
}

impl Texel {
    /// A vertex attribute of the texel's part at the texel.
    #[inline]
    pub(super) fn mix(&self, mesh: &TriMesh, of: &[Vec3]) -> Vec3 {
        let [a, b, c] = mesh.triangles[self.triangle as usize].map(|i| of[i as usize]);
        a + (b - a) * self.share[0] + (c - a) * self.share[1]
    }
}

/// All texels of a model that show its surface.
pub(super) struct Texels {
    /// Size of every part's texture.
    pub sizes: Vec<(u32, u32)>,
    /// Part by part, row by row.
    pub list: Vec<Texel>,
    /// For every part, the number in `list` of each texel of its texture, [`Texels::NONE`] where it shows nothing.
    pub number: Vec<Grid<u32>>,
    /// Place and normal in the rest pose.
    pub rest: Vec<Vec3>,
    pub normal: Vec<Vec3>,
    /// `neighbours[first[i]..first[i + 1]]` are the texels beside texel `i`.
    first: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Texels {
    pub(super) const NONE: u32 = u32::MAX;

    pub(super) fn new(model: &RiggedModel, sizes: Vec<(u32, u32)>, stage: Stage<'_>) -> Result<Self> {
        let wanted: usize = sizes.iter().map(|(w, h)| *w as usize * *h as usize).sum();
        if wanted > MAX_TEXELS {
            return Err(Error::invalid(
                "the textures",
                format!("have {wanted} texels together"),
                format!("at most {MAX_TEXELS} are handled; choose a lower density or largest side"),
            ));
        }
        let mut out = Self {
            sizes,
            list: Vec::new(),
            number: Vec::new(),
            rest: Vec::new(),
            normal: Vec::new(),
            first: vec![0],
            neighbours: Vec::new(),
        };
        for (p, part) in model.parts.iter().enumerate() {
            stage.at(p as f64 / model.parts.len() as f64)?;
            out.add(p as u16, part);
        }
        let mut seams = Vec::new();
        for (p, part) in model.parts.iter().enumerate() {
            out.seams(p, part, &mut seams);
        }
        out.join(seams);
        stage.at(1.0)?;
        Ok(out)
    }

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// The texels beside texel `i`.
    #[inline]
    pub(super) fn beside(&self, i: usize) -> &[u32] {
        &self.neighbours[self.first[i] as usize..self.first[i + 1] as usize]
    }

    fn add(&mut self, part: u16, skinned: &SkinnedPart) {
        let (w, h) = self.sizes[usize::from(part)];
        let (mesh, scale) = (&skinned.mesh, Vec2::new(w as f32, h as f32));
        let mut number = Grid::new(w as usize, h as usize, Self::NONE);
        let mut found: Vec<Texel> = Vec::new();
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|i| mesh.uvs[i as usize] * scale);
            let area = (b - a).perp_dot(c - a);
            if area == 0.0 || !area.is_finite() {
                continue;
            }
            let low = a.min(b).min(c).max(Vec2::ZERO);
            let high = a.max(b).max(c).min(scale);
            for y in (low.y - 0.5).ceil().max(0.0) as usize..(high.y + 0.5).floor().max(0.0) as usize {
                for x in (low.x - 0.5).ceil().max(0.0) as usize..(high.x + 0.5).floor().max(0.0) as usize {
                    if x >= w as usize || y >= h as usize || number.get(x, y) != Self::NONE {
                        continue;
                    }
                    let d = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - a;
                    let share = [d.perp_dot(c - a) / area, (b - a).perp_dot(d) / area];
                    if share[0] >= 0.0 && share[1] >= 0.0 && share[0] + share[1] <= 1.0 {
                        number.set(x, y, found.len() as u32);
                        let at = (y * w as usize + x) as u32;
                        found.push(Texel { part, at, triangle: t as u32, share });
                    }
                }
            }
        }
        // Row by row, so that what follows walks memory forward.
        found.sort_unstable_by_key(|t| t.at);
        let base = self.list.len() as u32;
        for (i, texel) in found.iter().enumerate() {
            number.data_mut()[texel.at as usize] = base + i as u32;
            self.rest.push(texel.mix(mesh, &mesh.positions));
            self.normal.push(texel.mix(mesh, &mesh.normals).normalize_or(Vec3::Z));
        }
        self.list.extend(found);
        self.number.push(number);
    }

    /// Pairs of texels that face each other over the seams of a part.
    fn seams(&self, p: usize, part: &SkinnedPart, out: &mut Vec<(u32, u32)>) {
        let mesh = &part.mesh;
        let key = |v: u32| mesh.positions[v as usize].to_array().map(f32::to_bits);
        // An edge by its places; the triangle's corners in the order of the places.
        let mut open: HashMap<[[u32; 3]; 2], [u32; 3]> = HashMap::new();
        for t in &mesh.triangles {
            for k in 0..3 {
                let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                let (a, b) = if key(a) <= key(b) { (a, b) } else { (b, a) };
                match open.remove(&[key(a), key(b)]) {
                    None => {
                        open.insert([key(a), key(b)], [a, b, c]);
                    }
                    Some(other) if other[..2] == [a, b] => {}
                    Some(other) => self.face(p, mesh, [a, b, c], other, out),
                }
            }
        }
    }

    /// Pairs the texels along one edge of a seam.
    fn face(&self, p: usize, mesh: &TriMesh, one: [u32; 3], other: [u32; 3], out: &mut Vec<(u32, u32)>) {
        let (w, h) = self.sizes[p];
        let scale = Vec2::new(w as f32, h as f32);
        let uv = |v: u32| mesh.uvs[v as usize] * scale;
        let length = uv(one[0]).distance(uv(one[1])).max(uv(other[0]).distance(uv(other[1])));
        let steps = (length.ceil() as usize).clamp(1, 4096);
        let inside = |[a, b, c]: [u32; 3], share: f32| {
            let on = uv(a).lerp(uv(b), share);
            let inward = (uv(c) - on).normalize_or_zero();
            // The texel whose centre is next to the edge may be up to a diagonal away.
            [0.3, 0.7, 1.2].iter().find_map(|reach| {
                let at = on + inward * *reach;
                let (x, y) = (at.x.floor(), at.y.floor());
                let there = x >= 0.0 && y >= 0.0 && x < scale.x && y < scale.y;
                there.then(|| self.number[p].get(x as usize, y as usize)).filter(|n| *n != Self::NONE)
            })
        };
        for s in 0..steps {
            let share = (s as f32 + 0.5) / steps as f32;
            if let (Some(i), Some(j)) = (inside(one, share), inside(other, share))
                && i != j
            {
                out.push((i.min(j), i.max(j)));
            }
        }
    }

    /// Lists the neighbours of all texels: those in the texture and those over seams.
    fn join(&mut self, seams: Vec<(u32, u32)>) {
        let mut pairs = seams;
        for (p, number) in self.number.iter().enumerate() {
            let pitch = pitch(&self.rest, number);
            let (w, h) = (number.width(), number.height());
            debug_assert_eq!((w as u32, h as u32), self.sizes[p]);
            for y in 0..h {
                for x in 0..w {
                    let i = number.get(x, y);
                    for (x, y) in [(x + 1, y), (x, y + 1)] {
                        if i == Self::NONE || x >= w || y >= h || number.get(x, y) == Self::NONE {
                            continue;
                        }
                        let j = number.get(x, y);
                        if self.rest[i as usize].distance(self.rest[j as usize]) <= APART * pitch {
                            pairs.push((i.min(j), i.max(j)));
                        }
                    }
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut count = vec![0u32; self.list.len() + 1];
        for &(i, j) in &pairs {
            count[i as usize + 1] += 1;
            count[j as usize + 1] += 1;
        }
        for i in 1..count.len() {
            count[i] += count[i - 1];
        }
        self.first = count.clone();
        self.neighbours = vec![0; 2 * pairs.len()];
        for &(i, j) in &pairs {
            for (a, b) in [(i, j), (j, i)] {
                self.neighbours[count[a as usize] as usize] = b;
                count[a as usize] += 1;
            }
        }
    }
}

/// The median distance on the surface of texels that touch in a row.
fn pitch(rest: &[Vec3], number: &Grid<u32>) -> f32 {
    let mut steps: Vec<f32> = number
        .data()
        .windows(2)
        .step_by(7)
        .filter(|w| w[0] != Texels::NONE && w[1] != Texels::NONE)
        .map(|w| rest[w[0] as usize].distance(rest[w[1] as usize]))
        .collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 1.0 } else { *steps.select_nth_unstable_by(middle, f32::total_cmp).1 }
}

/// The size of every part's texture that gives a pixel of the clip `density` texels along each side on average, within
/// `max_side`. The shape of the texture stays.
pub(super) fn sizes(model: &RiggedModel, density: f32, max_side: u32) -> Vec<(u32, u32)> {
    model
        .parts
        .iter()
        .map(|part| {
            let mesh = &part.mesh;
            let (w, h) = (part.texture.width() as f32, part.texture.height() as f32);
            let (mut surface, mut texels) = (0.0f64, 0.0f64);
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                surface += f64::from((b - a).cross(c - a).length());
                let [a, b, c] = t.map(|i| mesh.uvs[i as usize] * Vec2::new(w, h));
                texels += f64::from((b - a).perp_dot(c - a).abs());
            }
            let wanted = if texels > 0.0 { (surface / texels).sqrt() as f32 * density } else { 1.0 };
            let scale = wanted.min(max_side as f32 / w.max(h));
            let side = |n: f32| ((n * scale).round() as u32).clamp(4, max_side.max(4));
            (side(w), side(h))
        })
        .collect()
}
