//! A creature in the pose of strokes (Reinert 2016, section 4): limbs drawn anew, and its bones laid along them the way
//! reconstructing lays them (sections 3.7.1 and 3.7.2).
//!
//! A limb starts at the joint that holds it in the rest pose, wherever its stroke starts. It may slide on what holds it
//! by a quarter of the thicker radius, as tracked limbs do, and comes no farther off. A limb without a stroke keeps its rest
//! pose against what it hangs from; a root without one stays where it rests.
//!
//! Known limits: a stroke says nothing of roll, so that a body drawn from right to left instead of left to right lies
//! on its back; limbs may pass through each other.

use std::collections::BTreeMap;

use glam::{Quat, Vec2, Vec3, vec2};

use super::axis::samples_over;
use super::chain::{self, Placed};
use super::{Creature, CreatureLimb, path};
use crate::error::{Error, Result};
use crate::geometry::polyline;
use crate::job::{Progress, Stage};
use crate::motion::listed;
use crate::rig::Facing;
use crate::shape::Transform;
use crate::shape::character::Easing;

/// A limb as drawn for a pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LimbPose {
    /// The limb's label.
    pub limb: String,
    /// At least two points, from the limb's start to its end, in clip pixels, y down.
    pub points: Vec<Vec2>,
    /// Where to it leaves the image plane. With it, the limb keeps its length in space: the shorter the stroke, the
    /// farther its end stands from the plane. Without, only a stroke much shorter than the limb does that, and toward
    /// the viewer, as in [`super::reconstruct`].
    pub facing: Option<Facing>,
    /// How far its free end stands from where it is held, in clip pixels toward the viewer, whatever its length says.
    pub bend: Option<f32>,
    /// How far its free part stands from where it would, in clip pixels toward the viewer.
    pub depth: f32,
}

/// Limits within which limbs follow strokes.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseParams {
    /// Whether bones keep their lengths and take only their directions from the stroke. Else a limb is as long as its
    /// stroke, within `stretch`.
    pub keep_lengths: bool,
    /// A limb gets at most this many times its length in space; it follows a longer stroke as far as it reaches.
    pub stretch: f32,
    /// A limb without a facing that is drawn shorter than this share of its length leaves the image plane. Paper: 0.5.
    pub foreshortened: f32,
    /// The most that a bone turns against the one before it in its limb, in radians.
    pub sharpest: f32,
}

impl Default for PoseParams {
    /// A quarter of stretch, and 109 degrees from bone to bone at a fox's hock, are what tracked limbs show; much beyond it,
    /// skin folds into itself.
    fn default() -> Self {
        Self { keep_lengths: false, stretch: 1.25, foreshortened: 0.5, sharpest: 2.0 }
    }
}

/// Share of a radius by which a joint may slide: no more than joints of tracked creatures do.
const SLACK: f32 = 0.25;
/// A limb that keeps its length keeps at least this share of its greatest one.
const SHORT_AT_REST: f32 = 0.85;
/// Strokes that are shorter show no direction.
const SHORTEST: f32 = 1.0;
/// Strokes with more points, and places more image sizes outside the image, are mistakes.
const MAX_POINTS: usize = 10_000;
const MAX_OUTSIDE: f32 = 4.0;
/// More bones over all frames are more than a machine should be asked for: half a gigabyte.
const MAX_PLACED: usize = 10_000_000;

impl Creature {
    /// The local bone transforms of the pose that `strokes` draw.
    ///
    /// # Errors
    /// A creature whose limbs are not known, a limb that it has not or that is drawn twice, a stroke that is none, a
    /// parameter out of range.
    pub fn posed(&self, strokes: &[LimbPose], params: &PoseParams) -> Result<Vec<Transform>> {
        let poser = Poser::new(self, params, false)?;
        let drawn = poser.by_limb(strokes, "the pose")?;
        let key = |pose| Key { frame: 0, pose, easing: Easing::Hold };
        let keys: Vec<Vec<Key<'_>>> = drawn.into_iter().map(|pose| pose.map(key).into_iter().collect()).collect();
        let progress = Progress::new();
        Ok(poser.animate(&keys, 1, 1, progress.whole())?.swap_remove(0))
    }
}

/// A limb's stroke on a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Key<'a> {
    pub frame: usize,
    pub pose: &'a LimbPose,
    /// How the way to the limb's next key is spread.
    pub easing: Easing,
}

/// Poses a creature.
pub(super) struct Poser<'a> {
    creature: &'a Creature,
    params: &'a PoseParams,
    /// Whether strokes only show directions, and are moved onto their joints as they are. Else they are where limbs are
    /// to be, and only their first parts are bent to the joints.
    whole: bool,
    /// The rest pose in world coordinates.
    rest: Vec<Placed>,
}

impl<'a> Poser<'a> {
    pub(super) fn new(creature: &'a Creature, params: &'a PoseParams, whole: bool) -> Result<Self> {
        creature.validate()?;
        if creature.limbs.is_empty() {
            let remedy = "pose a creature that was reconstructed, or its creature.glb";
            return Err(Error::invalid("the creature", "does not say which bones are which limb", remedy));
        }
        let within = [
            ("stretch", params.stretch, 1.0, 10.0),
            ("foreshortened", params.foreshortened, 0.0, 1.0),
            ("sharpest", params.sharpest, 0.1, std::f32::consts::PI),
        ];
        if let Some((name, value, low, high)) = within.into_iter().find(|(_, v, low, high)| !(v >= low && v <= high)) {
            return Err(Error::invalid(name, format!("is {value}"), format!("give {low} to {high}")));
        }
        let rest = chain::all_world(&creature.model.bones, &creature.model.rest);
        Ok(Self { creature, params, whole, rest })
    }

    /// The strokes in the order of the creature's limbs, checked. `place` names where they are from.
    pub(super) fn by_limb<'s>(&self, strokes: &'s [LimbPose], place: &str) -> Result<Vec<Option<&'s LimbPose>>> {
        let limbs = &self.creature.limbs;
        let mut out = vec![None; limbs.len()];
        for pose in strokes {
            let what = format!("limb `{}` in {place}", pose.limb);
            let Some(l) = limbs.iter().position(|l| l.label == pose.limb) else {
                return Err(Error::invalid(what, "is none of the creature's", format!("it has {}", labels(limbs))));
            };
            if out[l].is_some() {
                return Err(Error::invalid(what, "is drawn twice", "keep one stroke"));
            }
            self.check(&what, pose)?;
            out[l] = Some(pose);
        }
        Ok(out)
    }

    fn check(&self, what: &str, pose: &LimbPose) -> Result<()> {
        let bad = |problem: String, remedy: &str| Err(Error::invalid(what, problem, remedy));
        if pose.points.len() < 2 || pose.points.len() > MAX_POINTS {
            return bad(format!("has {} points", pose.points.len()), "give 2 to 10000");
        }
        let (width, height) = self.creature.model.size;
        let most = MAX_OUTSIDE * width.max(height) as f32;
        if let Some(i) = pose.points.iter().position(|p| !p.is_finite() || p.abs().max_element() > most) {
            return bad(format!("has its point {i} far outside the image"), "give pixels of the clip");
        }
        if polyline::length(&pose.points) < SHORTEST {
            return bad("is shorter than a pixel".into(), "draw along the limb, or leave it out to let it hang");
        }
        if ![pose.depth, pose.bend.unwrap_or(0.0)].iter().all(|v| v.abs() <= most) {
            return bad("has a depth or a bend that no limb can have".into(), "give pixels of the clip");
        }
        Ok(())
    }

    /// The local transforms of all bones in `frames` frames, from the keys of each limb by rising frames: on its keys a
    /// limb is as drawn, between them its bones turn against what they hang from, before and after them it holds still.
    /// Every pose stays for `step` frames.
    pub(super) fn animate(
        &self,
        keys: &[Vec<Key<'_>>],
        frames: usize,
        step: usize,
        stage: Stage<'_>,
    ) -> Result<Vec<Vec<Transform>>> {
        let Creature { model, limbs, .. } = self.creature;
        let needed = keys.iter().flatten().map(|k| k.frame.saturating_add(1)).max().unwrap_or(0).max(frames);
        if needed.saturating_mul(model.bones.len()) > MAX_PLACED {
            return Err(Error::Limit {
                what: "the number of bones in all frames".into(),
                value: needed.saturating_mul(model.bones.len()) as u64,
                max: MAX_PLACED as u64,
                remedy: "give fewer frames".into(),
            });
        }
        let starts: BTreeMap<usize, usize> = limbs.iter().enumerate().map(|(l, limb)| (limb.first_bone, l)).collect();
        let mut local = vec![model.rest.clone(); needed];
        let mut world: Vec<Vec<Placed>> = vec![Vec::with_capacity(model.bones.len()); needed];
        let mut bone = 0;
        while bone < model.bones.len() {
            let part = |b: usize| b as f64 / model.bones.len() as f64;
            let limb = starts.get(&bone).copied();
            let range = limb.map_or(bone..bone + 1, |l| limbs[l].bone_range());
            if let Some(l) = limb.filter(|l| !keys[*l].is_empty()) {
                let part = stage.part(part(bone), part(range.end));
                self.follow(&limbs[l], &keys[l], step, &world, &mut local, part)?;
            }
            for (world, local) in world.iter_mut().zip(&local) {
                for b in range.clone() {
                    let placed = chain::world(&local[b], model.bones[b].parent.map(|p| world[p]));
                    world.push(placed);
                }
            }
            bone = range.end;
        }
        if !world.iter().flatten().all(|(place, turn)| place.is_finite() && turn.is_finite()) {
            return Err(Error::invalid("the pose", "leads limbs out of all bounds", "give places near the image"));
        }
        local.truncate(frames);
        chain::keep_signs(&mut local);
        stage.at(1.0)?;
        Ok(local)
    }

    /// Lets a limb follow its keys, of which there is at least one. `world` holds all bones before its own.
    fn follow(
        &self,
        limb: &CreatureLimb,
        keys: &[Key<'_>],
        step: usize,
        world: &[Vec<Placed>],
        local: &mut [Vec<Transform>],
        stage: Stage<'_>,
    ) -> Result<()> {
        let model = &self.creature.model;
        let first = limb.first_bone;
        let held = model.bones[first].parent;
        let mut poses: Vec<Vec<Transform>> = Vec::with_capacity(keys.len());
        for (i, key) in keys.iter().enumerate() {
            stage.at(i as f64 / keys.len() as f64)?;
            let joint = held.map(|p| chain::world(&model.rest[first], Some(world[key.frame][p])).0);
            let placed = self.lay(limb, key.pose, joint);
            let place_of = |b: usize| if b >= first { placed[b - first] } else { world[key.frame][b] };
            let bones = limb.bone_range();
            let mut pose: Vec<Transform> =
                bones.map(|b| chain::local(placed[b - first], model.bones[b].parent.map(place_of))).collect();
            if held.is_some() && self.whole {
                pose[0].translation = model.rest[first].translation;
            }
            poses.push(pose);
        }
        for (f, local) in local.iter_mut().enumerate() {
            let (from, to, share) = between(keys, f, step);
            for (k, out) in local[limb.bone_range()].iter_mut().enumerate() {
                let (a, b) = (poses[from][k], poses[to][k]);
                *out = if share <= 0.0 {
                    a
                } else if share >= 1.0 {
                    b
                } else {
                    blend(a, b, share, k > 0)
                };
            }
        }
        Ok(())
    }

    /// The bones of a limb in the pose of a stroke, with its start at `joint`, where something holds it.
    fn lay(&self, limb: &CreatureLimb, pose: &LimbPose, joint: Option<Vec3>) -> Vec<Placed> {
        let height = self.creature.model.size.1 as f32;
        let mut points = pose.points.clone();
        if limb.reversed {
            points.reverse();
        }
        let count = samples_over(polyline::length(&points));
        let share = |i: usize| i as f32 / (count - 1) as f32;
        let mut flat = polyline::resample(&points, count);
        if !self.whole {
            limb.settle(&mut flat, false);
        }
        if let Some(joint) = joint {
            let shift = vec2(joint.x, height - joint.y) - flat[0];
            let slack = if self.whole { 0.0 } else { self.slack(limb) };
            let shift = shift * (1.0 - slack / shift.length().max(slack).max(f32::MIN_POSITIVE));
            // The farther it is moved, the more of it: a bend that is spread shows least.
            let spread = (3.0 * shift.length() / polyline::length(&flat).max(1.0)).clamp(0.3, 1.0);
            let part = |i: usize| if self.whole { 1.0 } else { 1.0 - path::smooth(share(i) / spread) };
            flat.iter_mut().enumerate().for_each(|(i, p)| *p += shift * part(i));
        }
        let length = polyline::length(&flat);
        let rise = match (pose.bend, pose.facing) {
            (Some(bend), _) => bend,
            (None, Some(facing)) => {
                let toward = (facing == Facing::Toward) != limb.reversed;
                path::exact_rise(length, limb.length) * if toward { 1.0 } else { -1.0 }
            }
            (None, None) => path::rise(length, limb.length, self.params.foreshortened),
        };
        let in_space = |(i, p): (usize, &Vec2)| Vec3::new(p.x, height - p.y, path::bent(share(i), rise));
        let mut curve: Vec<Vec3> = flat.iter().enumerate().map(in_space).collect();
        let (now, most) = (chain::length(&curve), self.params.stretch * limb.length);
        if now > most {
            let reached: Vec<f32> = (0..count).map(|i| most * share(i)).collect();
            curve = chain::at_distances(&curve, &reached);
        }
        let aside = |share: f32| {
            let free = pose.depth * path::free_part(share, joint.is_some());
            Vec3::Z * (limb.offset * path::hip_ramp(share) + free + joint.map_or(0.0, |j| j.z))
        };
        let bones = limb.bones;
        let bone_share = |k: usize| k as f32 / (bones - 1) as f32;
        let mut places: Vec<Vec3>;
        let mut placed = Vec::new();
        if self.params.keep_lengths {
            let (bare, whole) = self.lengths(limb);
            let total = bare.iter().sum::<f32>().max(f32::MIN_POSITIVE);
            let stretched = chain::length(&curve) / total;
            let mut passed = 0.0;
            let distances: Vec<f32> = std::iter::once(0.0)
                .chain(bare.iter().map(|step| {
                    passed += step * stretched;
                    passed
                }))
                .collect();
            places = self.with_lengths(limb, &chain::at_distances(&curve, &distances), &bare);
            places.iter_mut().enumerate().for_each(|(k, p)| *p += aside(bone_share(k)));
            places = self.with_lengths(limb, &places, &whole);
        } else {
            curve.iter_mut().enumerate().for_each(|(i, p)| *p += aside(share(i)));
            placed = chain::along(&curve, bones);
            places = placed.iter().map(|p| p.0).collect();
        }
        let turned = chain::limit_turns(&mut places, self.params.sharpest);
        if turned || placed.is_empty() { chain::along(&places, bones) } else { placed }
    }

    /// How far a limb may slide on what holds it: a joint lies inside the thicker of the two.
    fn slack(&self, limb: &CreatureLimb) -> f32 {
        let holder = limb.parent.map_or(0.0, |p| self.creature.limbs[p.limb].radius);
        SLACK * limb.radius.max(holder)
    }

    /// How long the limb's bones are, without and with its way out from the hip: as at rest, unless it is much shorter
    /// there than it can be, since a limb may rest half turned away.
    fn lengths(&self, limb: &CreatureLimb) -> (Vec<f32>, Vec<f32>) {
        let rest = &self.rest[limb.bone_range()];
        let out = |k: usize| Vec3::Z * limb.offset * path::hip_ramp(k as f32 / (rest.len() - 1) as f32);
        let bare: Vec<Vec3> = rest.iter().enumerate().map(|(k, (p, _))| *p - out(k)).collect();
        let total = chain::length(&bare);
        let scale = if total > 0.0 { (SHORT_AT_REST * limb.length / total).max(1.0) } else { 0.0 };
        (0..rest.len() - 1)
            .map(|k| {
                let way = (bare[k + 1] - bare[k]) * scale;
                let aside = out(k + 1) - out(k);
                (way.length(), way.length().hypot(aside.length()))
            })
            .unzip()
    }

    /// The places with the ways between them made these lengths; a way without a direction takes that of the rest pose.
    fn with_lengths(&self, limb: &CreatureLimb, places: &[Vec3], lengths: &[f32]) -> Vec<Vec3> {
        let rest = &self.rest[limb.bone_range()];
        let mut out = vec![places[0]];
        for (k, length) in lengths.iter().enumerate() {
            let at_rest = || (rest[k + 1].0 - rest[k].0).normalize_or(Vec3::NEG_Y);
            let way = (places[k + 1] - places[k]).try_normalize().unwrap_or_else(at_rest);
            out.push(out[k] + way * *length);
        }
        out
    }
}

/// The labels of limbs, for an error.
pub(super) fn labels(limbs: &[CreatureLimb]) -> String {
    listed(limbs.iter().map(|l| l.label.as_str()))
}

/// The keys around a frame and the share of the way between them.
fn between(keys: &[Key<'_>], frame: usize, step: usize) -> (usize, usize, f32) {
    let after = keys.partition_point(|k| k.frame <= frame);
    if after == 0 || after == keys.len() {
        return (after.saturating_sub(1), after.saturating_sub(1), 0.0);
    }
    let (from, to) = (&keys[after - 1], &keys[after]);
    let passed = (frame - from.frame) / step * step;
    (after - 1, after, from.easing.share(passed as f64 / (to.frame - from.frame) as f64) as f32)
}

/// A bone between two poses: it turns the shorter way round, and so does the way to it from its parent where that is
/// `turning`, whose length changes evenly.
fn blend(a: Transform, b: Transform, share: f32, turning: bool) -> Transform {
    let rotation = a.rotation.slerp(b.rotation, share).normalize();
    let ends = (a.translation.try_normalize(), b.translation.try_normalize());
    let translation = match ends {
        (Some(from), Some(to)) if turning => {
            let length = a.translation.length() + (b.translation.length() - a.translation.length()) * share;
            Quat::IDENTITY.slerp(Quat::from_rotation_arc(from, to), share) * from * length
        }
        _ => a.translation.lerp(b.translation, share),
    };
    Transform { translation, rotation }
}
