//! Needles: every vertex keeps its angle and its place along its bone; where bones meet, the shape is solved for.
//!
//! Pan and Zhang 2011, section 3.3. Stage one: the needle from a bone to a vertex turns with the bone, its foot moves with
//! the bone's length, and its length changes by the reciprocal, so that the area stays. Around joints the maps of the
//! bones that meet there are blended by their angles, which starts stage two (see `joint_areas`) without a fold.
//!
//! Known limits: bones only, no points; vertices that belong to bones without a common joint and lie side by side in one
//! mesh part only as far as stage two can bridge.

mod joint_areas;
#[cfg(test)]
mod tests;

use glam::{DMat2, DVec2, Vec2};

use super::{Deformation, Deformer, Handle, Regions, RestMesh};
use crate::error::{Error, Result};
use crate::geometry::{PlaneMesh, polygon};
use crate::job::Stage;
use joint_areas::JointAreas;
pub use joint_areas::{Settled, SettledArea};

/// What keeps the area when a bone changes its length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AreaRule {
    /// Nothing: needles keep their length.
    Off,
    /// The paper's: needles change by the reciprocal of the bone. What lies beyond a bone's end shrinks both ways.
    Reciprocal,
    /// The same across, and what lies beyond a bone's end stretches along with it: every triangle keeps its area.
    #[default]
    Exact,
}

/// The built-in needle deformer. Its handles are bones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeedleDeformer {
    /// What keeps the area.
    pub area: AreaRule,
    /// How much joint areas mind the shape of their outline, `w1`; their edges' lengths weigh `1 - w1`.
    pub outline_weight: f64,
    /// Whether joint areas are solved for. Without, the blend of the bones' maps stays.
    pub joint_areas: bool,
}

impl Default for NeedleDeformer {
    /// The paper's equal weights.
    fn default() -> Self {
        Self { area: AreaRule::Exact, outline_weight: 0.5, joint_areas: true }
    }
}

impl Deformer for NeedleDeformer {
    fn bind(&self, mesh: RestMesh<'_>, handles: &[Handle], stage: Stage<'_>) -> Result<Box<dyn Deformation>> {
        Ok(Box::new(Needles::new(self, mesh, handles, stage)?))
    }
}

/// A needle's length never changes by more than this: of a bone that shrinks to nothing, something stays to see.
const MOST: f64 = 4.0;
/// Bones are blended within this many times the mesh's half width at their joint: with 1 the outline bends too sharply to
/// keep its area within half a hundredth.
const BLEND: f64 = 1.6;

/// A mesh whose vertices hang on bones.
#[derive(Debug)]
pub struct Needles {
    deformer: NeedleDeformer,
    rest: Vec<DVec2>,
    bones: Vec<Bone>,
    /// For each vertex the bones it follows, with weights that sum to 1, and the joint they share when there are several.
    follows: Vec<Follow>,
    areas: JointAreas,
    settled: Settled,
}

#[derive(Clone, Debug)]
struct Bone {
    root: DVec2,
    tip: DVec2,
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
struct Posed {
    root: DVec2,
    tip: DVec2,
    /// How far it turned since rest, the shorter way round from its parent's turn.
    turn: f64,
    /// Its length over that at rest, and what needles change by.
    along: f64,
    across: f64,
}

impl Needles {
    /// Binds `mesh` to `handles`.
    ///
    /// # Errors
    /// A handle that is not a bone or not a number, no handle; a mesh without triangles, with an index without its
    /// vertex, or with what is not a number.
    pub fn new(deformer: &NeedleDeformer, mesh: RestMesh<'_>, handles: &[Handle], stage: Stage<'_>) -> Result<Self> {
        stage.at(0.0)?;
        if !(0.0..=1.0).contains(&deformer.outline_weight) {
            return Err(Error::invalid("outline_weight", "is not in 0..=1", "give the share of the outline"));
        }
        if mesh.triangles.is_empty() || mesh.points.iter().any(|p| !p.is_finite()) {
            return Err(Error::invalid(
                "mesh",
                "has no triangles or a vertex that is not at a number",
                "check the mesh",
            ));
        }
        if mesh.triangles.iter().flatten().any(|&v| v as usize >= mesh.points.len()) {
            return Err(Error::invalid("mesh", "names a vertex that is not there", "check its triangles"));
        }
        let segments = bones_of(handles)?;
        let plane = PlaneMesh { points: mesh.points.to_vec(), triangles: mesh.triangles.to_vec() };
        let regions = Regions::grow(&plane, &segments);
        stage.at(0.4)?;
        let edges = plane.edges();
        let spacing =
            edges.iter().map(|([a, b], _)| f64::from(plane.points[*a as usize].distance(plane.points[*b as usize])));
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
                    met: [root, tip].map(|p| others().any(|(r, t)| meets(p, r) || meets(p, t))),
                    parent: segments[..b].iter().position(|(_, t)| meets(*t, root)),
                }
            })
            .collect();
        let rim: Vec<Vec2> = edges
            .iter()
            .filter(|(_, count)| *count == 1)
            .flat_map(|([a, b], _)| [plane.points[*a as usize], plane.points[*b as usize]])
            .collect();
        let reach_at = |p: Vec2| {
            let half = rim.iter().map(|q| p.distance_squared(*q)).fold(f32::INFINITY, f32::min).sqrt();
            (BLEND * f64::from(half)).max(2.0 * spacing)
        };
        let reaches: Vec<[f64; 2]> = segments.iter().map(|&(a, b)| [reach_at(a), reach_at(b)]).collect();
        let follows: Vec<Follow> = (0..plane.points.len())
            .map(|v| {
                let (p, own) = (plane.points[v], regions.bone[v] as usize);
                let gap =
                    |b: usize| f64::from(polygon::nearest_on_segment(segments[b].0, segments[b].1, p).1.distance(p));
                let at_tip = p.distance_squared(segments[own].1) < p.distance_squared(segments[own].0);
                let (joint, reach) =
                    if at_tip { (segments[own].1, reaches[own][1]) } else { (segments[own].0, reaches[own][0]) };
                let mut near: Vec<(usize, f64)> = vec![(own, 1.0)];
                for b in (0..segments.len())
                    .filter(|&b| b != own && (meets(segments[b].0, joint) || meets(segments[b].1, joint)))
                {
                    let share = (1.0 - (gap(b) - gap(own)).max(0.0) / reach).max(0.0).powi(2);
                    if share > 0.02 {
                        near.push((b, share));
                    }
                }
                let total: f64 = near.iter().map(|n| n.1).sum();
                near.iter_mut().for_each(|n| n.1 /= total);
                Follow { bones: near, at_tip }
            })
            .collect();
        stage.at(0.7)?;
        let mut free = vec![false; plane.points.len()];
        for (t, joins) in plane.triangles.iter().zip(&regions.joins) {
            if *joins || t.iter().any(|&v| follows[v as usize].bones.len() > 1) {
                t.iter().for_each(|&v| free[v as usize] = true);
            }
        }
        let areas = JointAreas::new(&plane, &free);
        stage.at(1.0)?;
        let rest = plane.points.iter().map(|p| p.as_dvec2()).collect();
        Ok(Self { deformer: *deformer, rest, bones, follows, areas, settled: Settled::default() })
    }

    /// How the joint areas of the last solve were settled.
    pub fn settled(&self) -> &Settled {
        &self.settled
    }

    /// The mesh after stage one, with the bones at `targets`: the blend of their maps.
    ///
    /// # Errors
    /// Others than were bound, or what is not a number.
    pub fn stage_one(&self, targets: &[Handle]) -> Result<Vec<Vec2>> {
        let posed = self.pose(targets)?;
        Ok((0..self.rest.len()).map(|v| self.place(v, &posed).0.as_vec2()).collect())
    }

    fn pose(&self, targets: &[Handle]) -> Result<Vec<Posed>> {
        let segments = bones_of(targets)?;
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
            let across = match self.deformer.area {
                AreaRule::Off => 1.0,
                AreaRule::Reciprocal | AreaRule::Exact => (1.0 / along).clamp(1.0 / MOST, MOST),
            };
            posed.push(Posed { root, tip, turn, along, across });
        }
        Ok(posed)
    }

    /// Where vertex `v` goes, and how it is stretched there, as seen at rest.
    fn place(&self, v: usize, posed: &[Posed]) -> (DVec2, DMat2) {
        let (p, follow) = (self.rest[v], &self.follows[v]);
        let own = follow.bones[0].0;
        let (bone, to) = (&self.bones[own], &posed[own]);
        if follow.bones.len() == 1 {
            let axis = (bone.tip - bone.root).try_normalize().unwrap_or(DVec2::X);
            let length = bone.root.distance(bone.tip);
            let (x, y) = ((p - bone.root).dot(axis), axis.perp_dot(p - bone.root));
            // Beyond an end where another bone goes on, the bone's own stretch does.
            let foot = x.clamp(if bone.met[0] { f64::MIN } else { 0.0 }, if bone.met[1] { f64::MAX } else { length });
            let beyond = match self.deformer.area {
                AreaRule::Off => 1.0,
                AreaRule::Reciprocal => to.across,
                AreaRule::Exact => 1.0 / to.across,
            };
            let at = DVec2::new(to.along * foot + beyond * (x - foot), to.across * y);
            let direction = DVec2::from_angle(to.turn).rotate(axis);
            let along = if x == foot { to.along } else { beyond };
            return (to.root + direction.rotate(at), stretch(axis, along, to.across));
        }
        let (joint, image) = if follow.at_tip { (bone.tip, to.tip) } else { (bone.root, to.root) };
        let (mut turn, mut stretched, mut area) = (0.0, DMat2::ZERO, 0.0);
        for &(b, w) in &follow.bones {
            let axis = (self.bones[b].tip - self.bones[b].root).try_normalize().unwrap_or(DVec2::X);
            turn += w * posed[b].turn;
            stretched += stretch(axis, posed[b].along, posed[b].across) * w;
            area += w * posed[b].along * posed[b].across;
        }
        // The mean of two maps that keep the area does not; scaled, it does.
        let determinant = stretched.determinant();
        if determinant > 1e-9 {
            stretched *= (area / determinant).sqrt();
        }
        (image + DVec2::from_angle(turn).rotate(stretched * (p - joint)), stretched)
    }
}

impl Deformation for Needles {
    fn solve(&mut self, targets: &[Handle], points: &mut [Vec2], stage: Stage<'_>) -> Result<()> {
        let posed = self.pose(targets)?;
        if points.len() != self.rest.len() {
            let problem = format!("{} were given and {} bound", points.len(), self.rest.len());
            return Err(Error::invalid("points of the mesh", problem, "pass the shape of the mesh that was bound"));
        }
        stage.at(0.0)?;
        let (mut places, stretches): (Vec<DVec2>, Vec<DMat2>) =
            (0..self.rest.len()).map(|v| self.place(v, &posed)).unzip();
        self.settled = if self.deformer.joint_areas {
            self.areas.settle(&self.rest, &stretches, self.deformer.outline_weight, &mut places, stage)?
        } else {
            Settled::default()
        };
        points.iter_mut().zip(places).for_each(|(p, place)| *p = place.as_vec2());
        Ok(())
    }
}

fn bones_of(handles: &[Handle]) -> Result<Vec<(Vec2, Vec2)>> {
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
