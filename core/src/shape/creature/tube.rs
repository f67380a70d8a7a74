//! The surface of a limb: a closed tube of elliptical rings with rounded ends.

use glam::{Vec2, Vec3, vec2, vec3};

use super::limb::LimbShape;
use crate::geometry::TriMesh;

/// Rings stand at least this far apart, in clip pixels, and there are at most so many.
const RING_SPACING: f32 = 3.0;
const MAX_RINGS: usize = 96;
/// Radii below this end a limb.
const VANISHING: f32 = 0.75;

/// A tube and where its vertices lie along the limb.
pub(super) struct Tube {
    /// The surface in one frame. Texture coordinates: x around (0 at the left border as seen along the limb, 0.5 at the
    /// right one; 0..0.5 faces the viewer), y along, both in 0..=1 of the whole cylinder.
    pub mesh: TriMesh,
    /// The sample (fractional) of every vertex.
    pub samples: Vec<f32>,
}

/// The place on the limb's surface at a sample and an angle (0 along the normal, a quarter turn toward the viewer).
pub(super) struct Section {
    /// Middle of the cross-section, world coordinates.
    pub center: Vec3,
    /// Half axis in the image plane.
    pub across: Vec3,
    /// Half axis toward the viewer.
    pub toward: Vec3,
}

impl Section {
    /// The surface point at an angle.
    pub(super) fn at(&self, angle: f32) -> Vec3 {
        self.center + self.across * angle.cos() + self.toward * angle.sin()
    }
}

/// The range of samples that a limb's surface covers: from the first to the last sample that has a radius.
pub(super) fn covered(limb: &LimbShape) -> (usize, usize) {
    let solid = |i: &usize| limb.half_width(*i) > VANISHING;
    let first = (0..=limb.axis.first).rev().take_while(solid).last().unwrap_or(limb.axis.first);
    let last = (limb.axis.last..limb.axis.samples()).take_while(solid).last().unwrap_or(limb.axis.last);
    (first, last)
}

/// The cross-section at a fractional sample of a frame.
pub(super) fn section(limb: &LimbShape, frame: usize, normals: &[Vec2], sample: f32, scale: f32) -> Section {
    let i = (sample as usize).min(normals.len() - 1);
    let j = (i + 1).min(normals.len() - 1);
    let share = sample - i as f32;
    let mix = |a: f32, b: f32| a + (b - a) * share;
    let n = normals[i].lerp(normals[j], share).try_normalize().unwrap_or(normals[i]);
    let across = vec3(n.x, -n.y, 0.0);
    let ahead = limb.place(frame, sample + 1.0) - limb.place(frame, sample - 1.0);
    let along = ahead.try_normalize().unwrap_or(Vec3::X);
    let toward = across.cross(along).try_normalize().unwrap_or(Vec3::Z);
    let toward = if toward.z < 0.0 { -toward } else { toward };
    let half = mix(limb.half_width(i), limb.half_width(j)).max(VANISHING);
    Section {
        center: limb.place(frame, sample) + across * mix(limb.shift(i), limb.shift(j)),
        across: across * half * scale,
        toward: toward * (half * mix(limb.depth_ratio[i], limb.depth_ratio[j]) * scale),
    }
}

/// How much the ends narrow at a sample: 1 inside, down to 0 at the very end, as a round cap does. A free end is a half
/// ellipsoid as long as the limb is thick; a joined one keeps its thickness up to the joint, so that limbs overlap.
pub(super) fn rounding(limb: &LimbShape, sample: f32, (first, last): (usize, usize)) -> f32 {
    let cap = |end: usize, joint: usize, joined: bool, distance: f32| {
        let thick = limb.half_width(end) / limb.axis.spacing().max(1e-3);
        let beyond = joint.abs_diff(end) as f32;
        let inside = if joined { beyond.max(2.0) } else { thick.min((last - first) as f32 * 0.25).max(1.0) };
        let t = (1.0 - distance / inside).clamp(0.0, 1.0);
        (1.0 - t * t).max(0.0).sqrt()
    };
    cap(first, limb.axis.first, limb.joined.0, sample - first as f32).min(cap(
        last,
        limb.axis.last,
        limb.joined.1,
        last as f32 - sample,
    ))
}

/// The tube of a limb in one frame, with `around` vertices a ring.
pub(super) fn tube(limb: &LimbShape, frame: usize, around: usize) -> Tube {
    let around = around.clamp(6, 256) / 2 * 2;
    let (first, last) = covered(limb);
    let length = (last - first) as f32 * limb.axis.spacing();
    let rings = ((length / RING_SPACING) as usize).clamp(6, MAX_RINGS);
    let normals = limb.normals(frame);
    let mut out = Tube { mesh: TriMesh::default(), samples: Vec::new() };
    let columns = around + 1;
    // Rings crowd toward the ends, where the caps are round.
    let sample_of = |r: usize| {
        let t = r as f32 / (rings + 1) as f32;
        let crowded = 0.5 - 0.5 * (std::f32::consts::PI * t).cos();
        first as f32 + (last - first) as f32 * (t + crowded) / 2.0
    };
    let mut push = |place: Vec3, uv: Vec2, sample: f32| {
        out.mesh.positions.push(place);
        out.mesh.uvs.push(uv);
        out.samples.push(sample);
    };
    for r in 1..=rings {
        let sample = sample_of(r);
        let ring = section(limb, frame, &normals, sample, rounding(limb, sample, (first, last)).max(0.02));
        let v = (sample - first as f32) / (last - first).max(1) as f32;
        for c in 0..columns {
            // The last column repeats the first place exactly: the texture's seam.
            let angle = std::f32::consts::TAU * (c % around) as f32 / around as f32;
            push(ring.at(angle), vec2(c as f32 / around as f32, v), sample);
        }
    }
    for c in 0..around {
        push(
            section(limb, frame, &normals, first as f32, 0.0).center,
            vec2((c as f32 + 0.5) / around as f32, 0.0),
            first as f32,
        );
    }
    for c in 0..around {
        push(
            section(limb, frame, &normals, last as f32, 0.0).center,
            vec2((c as f32 + 0.5) / around as f32, 1.0),
            last as f32,
        );
    }
    let ring = |r: usize, c: usize| (r * columns + c) as u32;
    let (start, end) = ((rings * columns) as u32, (rings * columns + around) as u32);
    let triangles = &mut out.mesh.triangles;
    for c in 0..around {
        triangles.push([start + c as u32, ring(0, c), ring(0, c + 1)]);
        triangles.push([ring(rings - 1, c), end + c as u32, ring(rings - 1, c + 1)]);
        for r in 0..rings - 1 {
            triangles.push([ring(r, c), ring(r + 1, c), ring(r, c + 1)]);
            triangles.push([ring(r, c + 1), ring(r + 1, c), ring(r + 1, c + 1)]);
        }
    }
    orient_outward(&mut out.mesh);
    out.mesh.normals = out.mesh.smooth_normals();
    out
}

/// The signed volume of a closed mesh: positive when its triangles are counter-clockwise seen from outside.
pub(super) fn volume(mesh: &TriMesh) -> f32 {
    let origin = mesh.positions.first().copied().unwrap_or(Vec3::ZERO);
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize] - origin);
        f64::from(a.dot(b.cross(c))) / 6.0
    };
    mesh.triangles.iter().map(of).sum::<f64>() as f32
}

/// Turns all triangles around when the mesh is inside out.
pub(super) fn orient_outward(mesh: &mut TriMesh) {
    if volume(mesh) < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}
