//! Stage one: needles, and around joints a blend of the maps of the bones that meet there.
//!
//! The needle from a bone to a vertex turns with the bone, its foot moves with the bone's length, and its length
//! changes by the reciprocal, so that the area stays.

use glam::{DMat2, DVec2, Vec2};

use super::AreaRule;
use crate::deform::{Handle, Regions};
use crate::error::{Error, Result};
use crate::geometry::{PlaneMesh, polygon};

/// A needle's length never changes by more than this: of a bone that shrinks to nothing, something stays to see.
const MOST: f64 = 4.0;
/// Bones are blended within this many times the mesh's half width at their joint: with 1 the outline bends too sharply to
/// keep its area within half a hundredth.
const BLEND: f64 = 1.6;
/// Along a bone the blend fades out over this share of its length, and ends so many edges before its middle, so that the
/// areas at its ends do not touch and each is solved for alone. Bones of fewer half widths or edges have no such middle.
const FADE: f64 = 0.16;
const EDGES: f64 = 2.0;
const SHORT: f64 = 3.0;
const LEAST_END: f64 = 0.38;
/// A bone whose share is less is left out.
const LEAST: f64 = 0.02;

/// A mesh whose vertices hang on bones.
#[derive(Debug)]
pub(super) struct Blend {
    area: AreaRule,
    rest: Vec<DVec2>,
    bones: Vec<Bone>,
    /// For each vertex the bones it follows, with weights that sum to 1, and the joint they share when there are several.
    follows: Vec<Follow>,
}

#[derive(Clone, Debug)]
struct Bone {
    root: DVec2,
    tip: DVec2,
    axis: DVec2,
    /// Whether another bone meets it at its root, and at its tip.
    met: [bool; 2],
    parent: Option<usize>,
}

#[derive(Clone, Debug)]
struct Follow {
    bones: Vec<(usize, f64)>,
    /// The shared joint as one end of the first bone.
    at_tip: bool,
}

/// Where a bone went.
#[derive(Clone, Copy, Debug)]
pub(super) struct Posed {
    pub(super) root: DVec2,
    pub(super) tip: DVec2,
    /// How far it turned since rest, the shorter way round from its parent's turn.
    pub(super) turn: f64,
    spin: DVec2,
    /// Its length over that at rest, and what needles change by.
    pub(super) along: f64,
    across: f64,
    stretch: DMat2,
}

/// Where a vertex goes, and how it is turned and stretched there, as seen at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) at: DVec2,
    pub(super) turn: f64,
    pub(super) stretch: DMat2,
}

impl Blend {
    /// Hangs `mesh` on bones, of which there is at least one; with the vertices that stage two may move.
    pub(super) fn new(area: AreaRule, mesh: &PlaneMesh, segments: &[(Vec2, Vec2)]) -> (Self, Vec<bool>) {
        let regions = Regions::grow(mesh, segments);
        let edges = mesh.edges();
        let spacing =
            edges.iter().map(|([a, b], _)| f64::from(mesh.points[*a as usize].distance(mesh.points[*b as usize])));
        let spacing = spacing.sum::<f64>() / edges.len().max(1) as f64;
        let meets = |p: Vec2, q: Vec2| f64::from(p.distance(q)) < 0.1 * spacing;
        let bones: Vec<Bone> = segments
            .iter()
            .enumerate()
            .map(|(b, &(root, tip))| {
                let others = || segments.iter().enumerate().filter(move |(o, _)| *o != b).map(|(_, s)| *s);
                Bone {
                    root: root.as_dvec2(),
                    tip: tip.as_dvec2(),
                    axis: (tip - root).as_dvec2().try_normalize().unwrap_or(DVec2::X),
                    met: [root, tip].map(|p| others().any(|(r, t)| meets(p, r) || meets(p, t))),
                    parent: segments[..b].iter().position(|(_, t)| meets(*t, root)),
                }
            })
            .collect();
        let rim: Vec<Vec2> = edges
            .iter()
            .filter(|(_, count)| *count == 1)
            .flat_map(|([a, b], _)| [mesh.points[*a as usize], mesh.points[*b as usize]])
            .collect();
        let half_at =
            |p: Vec2| f64::from(rim.iter().map(|q| p.distance_squared(*q)).fold(f32::INFINITY, f32::min).sqrt());
        let halves: Vec<[f64; 2]> = segments.iter().map(|&(a, b)| [half_at(a), half_at(b)]).collect();
        let follow = |v: usize| {
            let (p, own) = (mesh.points[v], regions.bone[v] as usize);
            let (root, tip) = segments[own];
            let gap = |b: usize| f64::from(polygon::nearest_on_segment(segments[b].0, segments[b].1, p).1.distance(p));
            let at_tip = p.distance_squared(tip) < p.distance_squared(root);
            let (joint, half) = if at_tip { (tip, halves[own][1]) } else { (root, halves[own][0]) };
            let reach = (BLEND * half).max(2.0 * spacing);
            let length = bones[own].root.distance(bones[own].tip);
            let foot = (p - joint).as_dvec2().dot(bones[own].axis) * if at_tip { -1.0 } else { 1.0 };
            let end = 0.5 - EDGES * spacing / length;
            let fade = if length > SHORT * half && end > LEAST_END {
                1.0 - ((foot / length - (end - FADE)) / FADE).clamp(0.0, 1.0)
            } else {
                1.0
            };
            let mut near: Vec<(usize, f64)> = vec![(own, 1.0)];
            for b in (0..segments.len())
                .filter(|&b| b != own && (meets(segments[b].0, joint) || meets(segments[b].1, joint)))
            {
                let share = fade * (1.0 - (gap(b) - gap(own)).max(0.0) / reach).max(0.0).powi(2);
                if share > LEAST {
                    near.push((b, share));
                }
            }
            let total: f64 = near.iter().map(|n| n.1).sum();
            near.iter_mut().for_each(|n| n.1 /= total);
            Follow { bones: near, at_tip }
        };
        let follows: Vec<Follow> = (0..mesh.points.len()).map(follow).collect();
        let mut free = vec![false; mesh.points.len()];
        for (t, joins) in mesh.triangles.iter().zip(&regions.joins) {
            if *joins || t.iter().any(|&v| follows[v as usize].bones.len() > 1) {
                t.iter().for_each(|&v| free[v as usize] = true);
            }
        }
        let rest = mesh.points.iter().map(|p| p.as_dvec2()).collect();
        (Self { area, rest, bones, follows }, free)
    }

    /// How many vertices there are.
    pub(super) fn len(&self) -> usize {
        self.rest.len()
    }

    /// The bones that a vertex follows.
    pub(super) fn bones_of(&self, v: u32) -> impl Iterator<Item = u32> {
        self.follows[v as usize].bones.iter().map(|b| b.0 as u32)
    }

    /// Where the bones go.
    ///
    /// # Errors
    /// Others than were bound, or what is not a number.
    pub(super) fn pose(&self, targets: &[Handle]) -> Result<Vec<Posed>> {
        let segments = segments(targets)?;
        if segments.len() != self.bones.len() {
            let problem = format!("{} were given and {} bound", segments.len(), self.bones.len());
            return Err(Error::invalid("handles", problem, "pass a target for each bone"));
        }
        let mut posed: Vec<Posed> = Vec::with_capacity(segments.len());
        for (bone, (root, tip)) in self.bones.iter().zip(segments) {
            let (root, tip) = (root.as_dvec2(), tip.as_dvec2());
            let (before, after) = (bone.tip - bone.root, tip - root);
            let parent = bone.parent.map_or(0.0, |p| posed[p].turn);
            let long = before.length() > 1e-6;
            let angle =
                if long && after.length() > 1e-6 { before.perp_dot(after).atan2(before.dot(after)) } else { parent };
            let turn = parent + wrap(angle - parent);
            // A bone without length at rest is a point: what hangs on it only moves and turns.
            let along = if long { after.length() / before.length() } else { 1.0 };
            let across = match self.area {
                AreaRule::Off => 1.0,
                AreaRule::Reciprocal | AreaRule::Exact => (1.0 / along).clamp(1.0 / MOST, MOST),
            };
            let (spin, stretch) = (DVec2::from_angle(turn), stretch(bone.axis, along, across));
            posed.push(Posed { root, tip, turn, spin, along, across, stretch });
        }
        Ok(posed)
    }

    /// Places vertex `v`.
    pub(super) fn place(&self, v: usize, posed: &[Posed]) -> Placed {
        let (p, follow) = (self.rest[v], &self.follows[v]);
        let own = follow.bones[0].0;
        let (bone, to) = (&self.bones[own], &posed[own]);
        if follow.bones.len() == 1 {
            let out = p - bone.root;
            let (x, length) = (out.dot(bone.axis), bone.root.distance(bone.tip));
            // Beyond an end where another bone goes on, the bone's own stretch does.
            let foot = x.clamp(if bone.met[0] { f64::MIN } else { 0.0 }, if bone.met[1] { f64::MAX } else { length });
            let beyond = match self.area {
                AreaRule::Off => 1.0,
                AreaRule::Reciprocal => to.across,
                AreaRule::Exact => 1.0 / to.across,
            };
            let stretch = if x == foot { to.stretch } else { stretch(bone.axis, beyond, to.across) };
            let at = to.stretch * out + bone.axis * ((beyond - to.along) * (x - foot));
            return Placed { at: to.root + to.spin.rotate(at), turn: to.turn, stretch };
        }
        let (joint, image) = if follow.at_tip { (bone.tip, to.tip) } else { (bone.root, to.root) };
        let (mut turn, mut stretch, mut area) = (0.0, DMat2::ZERO, 0.0);
        for &(b, w) in &follow.bones {
            let to = &posed[b];
            turn += w * to.turn;
            stretch += to.stretch * w;
            area += w * to.along * to.across;
        }
        // The mean of two maps that keep the area does not; scaled, it does.
        let determinant = stretch.determinant();
        if determinant > 1e-9 {
            stretch *= (area / determinant).sqrt();
        }
        Placed { at: image + DVec2::from_angle(turn).rotate(stretch * (p - joint)), turn, stretch }
    }
}

/// The handles as bones.
pub(super) fn segments(handles: &[Handle]) -> Result<Vec<(Vec2, Vec2)>> {
    if handles.is_empty() {
        return Err(Error::invalid("handles", "are none", "give at least one bone"));
    }
    let bone = |(i, h): (usize, &Handle)| match *h {
        Handle::Bone(root, tip) if h.is_finite() => Ok((root, tip)),
        Handle::Bone(..) => Err(Error::invalid(format!("handle {i}"), "is not a number", "give finite places")),
        Handle::Point(_) => {
            Err(Error::invalid(format!("handle {i}"), "is a point", "needles hang on bones: give a bone"))
        }
    };
    handles.iter().enumerate().map(bone).collect()
}

/// A stretch along an axis and across it.
fn stretch(axis: DVec2, along: f64, across: f64) -> DMat2 {
    let side = axis.perp();
    DMat2::from_cols(axis * axis.x, axis * axis.y) * along + DMat2::from_cols(side * side.x, side * side.y) * across
}

/// The angle within half a turn of zero.
fn wrap(angle: f64) -> f64 {
    angle - (angle / std::f64::consts::TAU).round() * std::f64::consts::TAU
}
