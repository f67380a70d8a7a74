//! A mesh bound to its handles, and its shape for any place of theirs.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use crate::Error;
use crate::bone::moments;
use crate::inside::Paths;

/// How fast a handle's weight falls with distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Falloff {
    /// By its square (the paper's a = 1): motion spreads wide.
    Gentle,
    /// By its fourth power (a = 2): parts near a handle follow that handle.
    #[default]
    Steep,
}

/// What a person may choose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How weights fall.
    pub falloff: Falloff,
    /// Whether distance inside the mesh counts, and not only that through empty space.
    pub inside: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { falloff: Falloff::Steep, inside: true }
    }
}

/// What a person moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Handle {
    /// A place on the mesh.
    Point(Vec2),
    /// A straight bone from its root to its tip. Without length it is a point.
    Bone(Vec2, Vec2),
}

/// A path inside the mesh is taken to be a detour only beyond this ratio to the straight line.
const DETOUR: f64 = 1.25;
/// No way at all inside the mesh: the handle of another part counts this much longer a way.
const NO_WAY: f64 = 30.0;
/// Vertices this near to a handle, as a share of the mesh's size, lie on it.
const ON_HANDLE: f64 = 1e-7;
/// Vertices a task moves before it looks whether to go on.
const BATCH: usize = 2048;

/// What one end of a handle does to one vertex.
#[derive(Clone, Copy, Debug, Default)]
struct Pull {
    /// Its share in the vertex' centre.
    share: f32,
    /// Its part in the vertex' direction, a complex factor.
    turn: Vec2,
}

/// A mesh bound to its handles.
#[derive(Clone, Debug)]
pub struct Deformation {
    handles: Vec<Handle>,
    /// For each vertex, one for each control: a point, or an end of a bone.
    pulls: Vec<Pull>,
    controls: usize,
    /// For each vertex its distance from its centre; negative on a handle, where the shares say all.
    arms: Vec<f32>,
    /// For each vertex where it lies from its centre at rest, for handles that do not say how to turn.
    offsets: Vec<Vec2>,
}

impl Deformation {
    /// Prepares all that does not change while the handles move. `go_on` is asked at least every 100 ms; `false`
    /// cancels.
    ///
    /// # Errors
    /// No vertices, triangles or handles, a number that is not finite, an index without its vertex, or a cancel.
    pub fn bind(
        points: &[Vec2],
        triangles: &[[u32; 3]],
        handles: &[Handle],
        settings: Settings,
        go_on: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Self, Error> {
        check(points, triangles, handles)?;
        let exact: Vec<DVec2> = points.iter().map(|p| p.as_dvec2()).collect();
        let (low, high) = exact.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let size = (high - low).length().max(1e-6);
        let bones: Vec<Bone> = handles.iter().map(|h| Bone::new(*h, ON_HANDLE * size)).collect();
        let detours = if settings.inside && !triangles.is_empty() {
            detours(&exact, triangles, &bones, go_on)?
        } else {
            Vec::new()
        };
        // A point weighs like a bone of this length, so that both may be used together.
        let unit = size / (10.0 * handles.len() as f64);
        let controls: usize = bones.iter().map(Bone::controls).sum();
        let mut pulls = vec![Pull::default(); controls * points.len()];
        let mut arms = vec![0.0; points.len()];
        let mut offsets = vec![Vec2::ZERO; points.len()];
        let bind_one = |vertex: usize, pulls: &mut [Pull]| -> (f32, Vec2) {
            let detour = |handle: usize| detours.get(handle).map_or(1.0, |d: &Vec<f64>| d[vertex]);
            pull(exact[vertex], &bones, &detour, unit, settings.falloff, ON_HANDLE * size, pulls)
        };
        let batches = pulls.par_chunks_mut(controls * BATCH).zip(arms.par_chunks_mut(BATCH));
        batches.zip(offsets.par_chunks_mut(BATCH)).enumerate().try_for_each(|(batch, ((pulls, arms), offsets))| {
            let done = (batch * BATCH) as f64 / points.len() as f64;
            if !go_on(0.5 + 0.5 * done) {
                return Err(Error::Cancelled);
            }
            for (i, pulls) in pulls.chunks_mut(controls).enumerate() {
                (arms[i], offsets[i]) = bind_one(batch * BATCH + i, pulls);
            }
            Ok(())
        })?;
        Ok(Self { handles: handles.to_vec(), pulls, controls, arms, offsets })
    }

    /// Puts every vertex where the handles at `targets` carry it; `points` are given the new places.
    ///
    /// # Errors
    /// Other handles or vertices than were bound, a number that is not finite, or a cancel; `points` are then as they
    /// were.
    pub fn solve(
        &self,
        targets: &[Handle],
        points: &mut [Vec2],
        go_on: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<(), Error> {
        if points.len() != self.arms.len() {
            let problem = format!("{} vertices, and {} were bound", points.len(), self.arms.len());
            return Err(Error::Handles(problem));
        }
        if targets.len() != self.handles.len() {
            let problem = format!("{} handles, and {} were bound", targets.len(), self.handles.len());
            return Err(Error::Handles(problem));
        }
        let mut controls = Vec::with_capacity(self.controls);
        for (index, (target, bound)) in targets.iter().zip(&self.handles).enumerate() {
            match (target, bound) {
                (Handle::Point(p), Handle::Point(_)) => controls.push(*p),
                (Handle::Bone(root, tip), Handle::Bone(..)) => controls.extend([*root, *tip]),
                _ => return Err(Error::Handles(format!("handle {index} is of another kind"))),
            }
        }
        if let Some(index) = controls.iter().position(|p| !sound(*p)) {
            return Err(Error::NotFinite { what: "target", index });
        }
        let moved = |i: usize| self.place(i, &controls);
        if points.len() <= BATCH {
            if !go_on(0.0) {
                return Err(Error::Cancelled);
            }
            points.iter_mut().enumerate().for_each(|(i, p)| *p = moved(i));
            return Ok(());
        }
        // Aside first: a cancel must leave the old shape.
        let mut new = vec![Vec2::ZERO; points.len()];
        new.par_chunks_mut(BATCH).enumerate().try_for_each(|(batch, new)| {
            if !go_on((batch * BATCH) as f64 / points.len() as f64) {
                return Err(Error::Cancelled);
            }
            new.iter_mut().enumerate().for_each(|(i, p)| *p = moved(batch * BATCH + i));
            Ok(())
        })?;
        points.copy_from_slice(&new);
        Ok(())
    }

    #[inline]
    fn place(&self, vertex: usize, controls: &[Vec2]) -> Vec2 {
        let pulls = &self.pulls[vertex * self.controls..(vertex + 1) * self.controls];
        let (mut centre, mut direction) = (Vec2::ZERO, Vec2::ZERO);
        // The turns add up to nothing, so a common shift does not matter; a small one loses fewer digits.
        let origin = controls.first().copied().unwrap_or_default();
        for (pull, q) in pulls.iter().zip(controls) {
            centre += pull.share * *q;
            let q = *q - origin;
            direction += Vec2::new(pull.turn.x * q.x - pull.turn.y * q.y, pull.turn.x * q.y + pull.turn.y * q.x);
        }
        let arm = self.arms[vertex];
        if arm < 0.0 {
            return centre;
        }
        match direction.try_normalize() {
            Some(direction) => centre + arm * direction,
            None => centre + self.offsets[vertex],
        }
    }
}

fn sound(p: Vec2) -> bool {
    p.is_finite() && p.abs().max_element() < 1e9
}

fn check(points: &[Vec2], triangles: &[[u32; 3]], handles: &[Handle]) -> Result<(), Error> {
    if points.is_empty() {
        return Err(Error::Empty("vertices"));
    }
    if triangles.is_empty() {
        return Err(Error::Empty("triangles"));
    }
    if handles.is_empty() {
        return Err(Error::Empty("handles"));
    }
    if let Some(index) = points.iter().position(|p| !sound(*p)) {
        return Err(Error::NotFinite { what: "vertex", index });
    }
    let ends = |h: &Handle| match *h {
        Handle::Point(p) => [p, p],
        Handle::Bone(root, tip) => [root, tip],
    };
    if let Some(index) = handles.iter().position(|h| !ends(h).into_iter().all(sound)) {
        return Err(Error::NotFinite { what: "handle", index });
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= points.len()) {
            return Err(Error::Triangle { triangle, vertex, vertices: points.len() });
        }
    }
    Ok(())
}

/// A handle at rest.
struct Bone {
    root: DVec2,
    tip: DVec2,
    is_bone: bool,
    /// Too short to have a direction.
    short: bool,
}

impl Bone {
    fn new(handle: Handle, shortest: f64) -> Self {
        let (root, tip, is_bone) = match handle {
            Handle::Point(p) => (p, p, false),
            Handle::Bone(root, tip) => (root, tip, true),
        };
        let (root, tip) = (root.as_dvec2(), tip.as_dvec2());
        Self { root, tip, is_bone, short: root.distance(tip) <= shortest }
    }

    fn controls(&self) -> usize {
        if self.is_bone { 2 } else { 1 }
    }

    /// The share of the bone's length at its point nearest to `v`, and how far that is.
    fn nearest(&self, v: DVec2) -> (f64, f64) {
        if self.short {
            return (0.5, v.distance(self.root.lerp(self.tip, 0.5)));
        }
        let along = (self.tip - self.root).dot(v - self.root) / self.root.distance_squared(self.tip);
        let t = along.clamp(0.0, 1.0);
        (t, v.distance(self.root.lerp(self.tip, t)))
    }
}

/// What the handles do to one vertex; its distance and offset from its centre at rest.
fn pull(
    v: DVec2,
    bones: &[Bone],
    detour: &dyn Fn(usize) -> f64,
    unit: f64,
    falloff: Falloff,
    touching: f64,
    pulls: &mut [Pull],
) -> (f32, Vec2) {
    let mut control = 0;
    for bone in bones {
        let (t, distance) = bone.nearest(v);
        if distance <= touching {
            pulls.fill(Pull::default());
            if bone.is_bone {
                pulls[control].share = (1.0 - t) as f32;
                pulls[control + 1].share = t as f32;
            } else {
                pulls[control].share = 1.0;
            }
            return (-1.0, Vec2::ZERO);
        }
        control += bone.controls();
    }
    let power = if falloff == Falloff::Steep { 2 } else { 1 };
    // Moments of every handle; a point's are all its weight on its only end.
    let all: Vec<[f64; 3]> = bones
        .iter()
        .enumerate()
        .map(|(i, bone)| {
            let less = detour(i).powi(-2 * power);
            if bone.short {
                let weight = less * unit / bone.nearest(v).1.powi(2 * power);
                return if bone.is_bone { [0.25 * weight; 3] } else { [weight, 0.0, 0.0] };
            }
            let m = moments(bone.root, bone.tip, v, falloff);
            [less * m.root, less * m.mixed, less * m.tip]
        })
        .collect();
    let weight = |&[root, mixed, tip]: &[f64; 3]| root + 2.0 * mixed + tip;
    let total: f64 = all.iter().map(weight).sum();
    // Measured from the heaviest handle: beside it the centre is so near that its place itself has too few digits.
    let heaviest = (0..all.len()).max_by(|&i, &j| weight(&all[i]).total_cmp(&weight(&all[j]))).unwrap_or(0);
    let origin = bones[heaviest].root;
    let from_origin = bones
        .iter()
        .zip(&all)
        .map(|(bone, [root, mixed, tip])| (bone.root - origin) * (root + mixed) + (bone.tip - origin) * (mixed + tip));
    let centre = from_origin.sum::<DVec2>() / total;
    let arm = v - origin - centre;
    // Handles in one place do not say how to turn; what is left of their difference is rounding.
    let turns = bones.iter().flat_map(|b| [b.root, b.tip]).any(|p| p.distance(origin) > 100.0 * touching);
    let direction = if turns { arm.normalize_or_zero() } else { DVec2::ZERO };
    // Complex products: turn = arm * conj(handle's end from the centre), summed by moments.
    let product = |from: DVec2| DVec2::new(direction.dot(from), from.perp_dot(direction));
    let ends = bones.iter().zip(&all).flat_map(|(bone, [root, mixed, tip])| {
        let (a, b) = (bone.root - origin - centre, bone.tip - origin - centre);
        let at_root = (root + mixed, product(a * *root + b * *mixed));
        let at_tip = (mixed + tip, product(a * *mixed + b * *tip));
        [Some(at_root), bone.is_bone.then_some(at_tip)].into_iter().flatten()
    });
    let ends: Vec<(f64, DVec2)> = ends.collect();
    // Only the direction of their sum counts, and beside a handle they are too small for single precision.
    let largest = ends.iter().map(|(_, turn)| turn.abs().max_element()).fold(f64::MIN_POSITIVE, f64::max);
    for (pull, (share, turn)) in pulls.iter_mut().zip(ends) {
        *pull = Pull { share: (share / total) as f32, turn: (turn / largest).as_vec2() };
    }
    (arm.length() as f32, arm.as_vec2())
}

/// For every handle and vertex, how much longer the way inside the mesh is than the straight one.
fn detours(
    points: &[DVec2],
    triangles: &[[u32; 3]],
    bones: &[Bone],
    go_on: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Vec<Vec<f64>>, Error> {
    let paths = Paths::new(points, triangles);
    let mean = triangles.iter().map(|t| points[t[0] as usize].distance(points[t[1] as usize])).sum::<f64>()
        / triangles.len() as f64;
    bones
        .par_iter()
        .enumerate()
        .map(|(i, bone)| {
            if !go_on(0.5 * i as f64 / bones.len() as f64) {
                return Err(Error::Cancelled);
            }
            let straight: Vec<f64> = points.iter().map(|&p| bone.nearest(p).1).collect();
            let nearest = straight.iter().copied().fold(f64::INFINITY, f64::min);
            // All vertices beside the bone are sources; a bone outside the mesh pulls from the vertices next to it.
            let sources: Vec<(usize, f64)> = straight
                .iter()
                .enumerate()
                .filter(|(_, d)| **d <= nearest + 1.5 * mean)
                .map(|(vertex, d)| (vertex, *d))
                .collect();
            let done = 0.5 * i as f64 / bones.len() as f64;
            let inside = paths.distances(&sources, &|| go_on(done)).ok_or(Error::Cancelled)?;
            let ratio = |(there, straight): (&f64, &f64)| {
                if there.is_infinite() {
                    return NO_WAY;
                }
                // Within a few edges of a handle paths are too coarse to tell.
                (there / (DETOUR * straight + mean)).clamp(1.0, NO_WAY)
            };
            Ok(inside.iter().zip(&straight).map(ratio).collect())
        })
        .collect()
}
