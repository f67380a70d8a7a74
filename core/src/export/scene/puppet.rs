//! A take as engines hold it: bones over time, weights, and what the bones cannot do.
//!
//! Every bone of the skeleton turns and moves in its parent; a tree begins with its root joint, which only moves. A bone
//! that changes its length has an end bone of its own that carries the stretch along and the squash across, so that no
//! other bone inherits them: three of our four formats would shear what hangs from it. Turns and lengths are the
//! joints' own; squash is fitted to the bone's region.
//!
//! Weights: inside its region a vertex follows its bone alone. Where that is off by more than a quarter of the tolerance,
//! neighbouring bones are mixed in by Frank-Wolfe steps on the simplex of weights (Frank and Wolfe 1956), which minimise
//! the squared error over up to 64 frames. What is left is kept as a corrective in the rest pose, before the bones move
//! it: `p = M (rest + corrective)` with `M` the weighted sum of the bones' maps, which glTF, Spine and DragonBones
//! agree on.
//!
//! The correctives are those of the keys as they are rounded and reduced, so errors do not add up along a limb.

use glam::{DAffine2, DMat2, DVec2, Vec2, dvec2};
use rayon::prelude::*;

use super::keys::Channel;
use crate::deform::VertexClass;
use crate::error::Result;
use crate::export::take::TakeSubject;
use crate::job::Stage;

/// How far a vertex may be from its place in the take, in pixels of the picture, all causes together.
pub(super) const TOLERANCE: f64 = 0.25;
/// What a bone's keys may add to it, at the vertex that it moves most.
const BONE_TOLERANCE: f64 = 0.02;
/// Keys are multiples of these: a place in pixels, a turn in degrees (at 1000 pixels a hundredth), a scale.
const PLACE_STEP: f64 = 1e-3;
const TURN_STEP: f64 = 1e-3;
const SCALE_STEP: f64 = 1e-4;
/// A span between two keys turns no farther, in degrees: from half a turn on readers go the other way.
const MOST_TURN: f64 = 120.0;
/// Bones stretch and shrink by this at most; needles do by 4.
const MOST_SCALE: f64 = 5.0;
/// Frames that weights are fitted to, and steps of the fit; each brings in one bone at most.
const FITTED: usize = 64;
const STEPS: usize = 6;
/// The share of the squared error that another bone must take away: Spine tells a corrective to every bone.
const LEAST_GAIN: f64 = 0.15;
/// Weights are multiples of this, and smaller ones are left out.
const WEIGHT_STEP: f64 = 1e-3;
const LEAST_WEIGHT: f64 = 0.02;
/// A mix of bones that squeezes areas to less than this cannot be undone well enough for a corrective.
const LEAST_AREA: f64 = 0.1;

/// A bone, in the coordinates of its parent.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bone {
    pub(super) name: String,
    /// An earlier bone.
    pub(super) parent: Option<usize>,
    /// How long it is at rest; it lies along x.
    pub(super) length: f64,
    pub(super) place: Channel,
    /// Degrees, in x.
    pub(super) turn: Channel,
    pub(super) scale: Channel,
}

impl Bone {
    fn local(place: DVec2, turn: DVec2, scale: DVec2) -> DAffine2 {
        DAffine2::from_scale_angle_translation(scale, turn.x.to_radians(), place)
    }

    pub(super) fn at_rest(&self) -> DAffine2 {
        Self::local(self.place.rest, self.turn.rest, self.scale.rest)
    }

    fn at(&self, frame: usize, holds: bool) -> DAffine2 {
        let value = |c: &Channel| c.at(frame, holds);
        Self::local(value(&self.place), value(&self.turn), value(&self.scale))
    }
}

/// A take as bones, weights and correctives, in the format's own coordinates.
#[derive(Clone, Debug)]
pub(super) struct Puppet {
    pub(super) bones: Vec<Bone>,
    /// The bone that moves the region of each bone of the skeleton.
    pub(super) mover: Vec<usize>,
    /// Where the vertices are at rest.
    pub(super) rest: Vec<DVec2>,
    /// For each vertex bones and their weights, the heaviest first; they sum to 1.
    pub(super) weights: Vec<Vec<(usize, f64)>>,
    /// For each frame and vertex what is added to the rest.
    pub(super) correctives: Vec<Vec<Vec2>>,
    /// By how much a vertex's corrective grows at most when the bones have moved it.
    pub(super) growth: Vec<f64>,
    /// Whether frames are held until the next key: animation "on twos".
    pub(super) holds: bool,
    /// Units a pixel of the picture.
    pub(super) scale: f64,
}

/// Where units of a format lie on the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Units {
    pub(super) scale: f64,
    /// The picture's height where y points up, from its bottom left.
    pub(super) up_from: Option<f64>,
}

impl Units {
    pub(super) fn place(self, p: Vec2) -> DVec2 {
        let p = p.as_dvec2();
        self.scale * self.up_from.map_or(p, |height| dvec2(p.x, height - p.y))
    }
}

impl Puppet {
    /// Makes it of a take that is checked.
    pub(super) fn new(subject: TakeSubject<'_>, units: Units, stage: Stage<'_>) -> Result<Self> {
        let (character, take) = (subject.character, subject.take);
        stage.name("bones")?;
        let skeleton = Track::new(subject, units);
        let holds = holds(subject);
        let (bones, mover) = bones(subject, units, &skeleton, holds);
        stage.at(0.1)?;
        let rest: Vec<DVec2> = character.mesh.points.iter().map(|p| units.place(*p)).collect();
        let mut own = Self {
            bones,
            mover,
            rest,
            weights: Vec::new(),
            correctives: Vec::new(),
            growth: Vec::new(),
            holds,
            scale: units.scale,
        };
        let maps: Vec<Vec<DAffine2>> = (0..take.frames.len()).map(|f| own.maps(f)).collect();
        stage.at(0.2)?;
        let place = |f: usize, v: usize| units.place(take.frames[f].points[v]);
        stage.name("weights")?;
        own.weights = own.fit(subject, &maps, &place, stage.part(0.2, 0.6))?;
        stage.name("correctives")?;
        own.growth = own.growth(&maps);
        own.correctives = (0..take.frames.len())
            .into_par_iter()
            .map(|f| {
                stage.at(0.6)?;
                let corrective = |v: usize| {
                    let map = mixed(&own.weights[v], &maps[f]);
                    (map.matrix2.inverse() * (place(f, v) - map.transform_point2(own.rest[v]))).as_vec2()
                };
                Ok((0..own.rest.len()).map(corrective).collect())
            })
            .collect::<Result<_>>()?;
        stage.at(1.0)?;
        Ok(own)
    }

    /// Where each bone is, from its own coordinates to the world.
    fn placed(&self, local: impl Fn(&Bone) -> DAffine2) -> Vec<DAffine2> {
        let mut world: Vec<DAffine2> = Vec::with_capacity(self.bones.len());
        for bone in &self.bones {
            let own = local(bone);
            world.push(bone.parent.map_or(own, |p| world[p] * own));
        }
        world
    }

    /// Where each bone is at rest.
    pub(super) fn bind(&self) -> Vec<DAffine2> {
        self.placed(Bone::at_rest)
    }

    /// How each bone maps what it moves, from rest to a frame.
    fn maps(&self, frame: usize) -> Vec<DAffine2> {
        let posed = self.placed(|b| b.at(frame, self.holds));
        posed.iter().zip(self.bind()).map(|(now, rest)| *now * rest.inverse()).collect()
    }

    fn fit(
        &self,
        subject: TakeSubject<'_>,
        maps: &[Vec<DAffine2>],
        place: &(impl Fn(usize, usize) -> DVec2 + Sync),
        stage: Stage<'_>,
    ) -> Result<Vec<Vec<(usize, f64)>>> {
        let character = subject.character;
        let sampled = maps.len().min(FITTED);
        let frames: Vec<usize> = (0..sampled).map(|i| i * (maps.len() - 1) / (sampled - 1).max(1)).collect();
        let bones = &character.skeleton.bones;
        let beside: Vec<Vec<usize>> = bones
            .iter()
            .map(|b| (0..bones.len()).filter(|o| bones[*o].iter().any(|j| b.contains(j))).collect())
            .collect();
        (0..self.rest.len())
            .into_par_iter()
            .map(|v| {
                stage.at(0.5)?;
                let own = character.regions.bone[v] as usize;
                let wished: Vec<DVec2> = frames.iter().map(|&f| place(f, v)).collect();
                let moved = |bone: usize| -> Vec<DVec2> {
                    frames.iter().map(|&f| maps[f][self.mover[bone]].transform_point2(self.rest[v])).collect()
                };
                let weights = fit(own, &beside[own], &moved, &wished, TOLERANCE * self.scale / 4.0);
                let weights: Vec<(usize, f64)> = weights.into_iter().map(|(b, w)| (self.mover[b], w)).collect();
                let invertible = |f: &Vec<DAffine2>| mixed(&weights, f).matrix2.determinant() >= LEAST_AREA;
                Ok(if maps.iter().all(invertible) { weights } else { vec![(self.mover[own], 1.0)] })
            })
            .collect()
    }

    fn growth(&self, maps: &[Vec<DAffine2>]) -> Vec<f64> {
        let largest = |m: DMat2| {
            // The larger singular value.
            let (sum, det) = (m.x_axis.length_squared() + m.y_axis.length_squared(), m.determinant());
            (0.5 * (sum + (sum * sum - 4.0 * det * det).max(0.0).sqrt())).sqrt()
        };
        let of = |w: &Vec<(usize, f64)>| maps.iter().map(|m| largest(mixed(w, m).matrix2)).fold(0.0, f64::max);
        self.weights.par_iter().map(of).collect()
    }
}

/// The weighted sum of maps.
fn mixed(weights: &[(usize, f64)], maps: &[DAffine2]) -> DAffine2 {
    let sum = weights.iter().fold([0.0; 6], |sum, &(bone, w)| {
        let map = maps[bone].to_cols_array();
        std::array::from_fn(|i| sum[i] + w * map[i])
    });
    DAffine2::from_cols_array(&sum)
}

/// Weights over `beside` that bring what the bones do to a vertex nearest to `wished`.
fn fit(
    own: usize,
    beside: &[usize],
    moved: &impl Fn(usize) -> Vec<DVec2>,
    wished: &[DVec2],
    enough: f64,
) -> Vec<(usize, f64)> {
    let mut at = moved(own);
    if at.iter().zip(wished).all(|(a, b)| a.distance(*b) <= enough) {
        return vec![(own, 1.0)];
    }
    let ways: Vec<Vec<DVec2>> = beside.iter().map(|&b| moved(b)).collect();
    let mut weights: Vec<f64> = beside.iter().map(|&b| f64::from(u8::from(b == own))).collect();
    for _ in 0..STEPS {
        let step = |way: &Vec<DVec2>| {
            let (mut along, mut square) = (0.0, 0.0);
            for ((to, from), goal) in way.iter().zip(&at).zip(wished) {
                along += (*to - *from).dot(*goal - *from);
                square += to.distance_squared(*from);
            }
            let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
            (share, share * (2.0 * along - share * square))
        };
        let steps = ways.iter().map(step).enumerate();
        let Some((best, (share, gain))) = steps.max_by(|a, b| a.1.1.total_cmp(&b.1.1)) else { break };
        let error: f64 = at.iter().zip(wished).map(|(a, b)| a.distance_squared(*b)).sum();
        if gain <= LEAST_GAIN * error {
            break;
        }
        weights.iter_mut().for_each(|w| *w *= 1.0 - share);
        weights[best] += share;
        at.iter_mut().zip(&ways[best]).for_each(|(at, to)| *at = at.lerp(*to, share));
    }
    rounded(beside.iter().copied().zip(weights).collect())
}

/// At most four weights, the heaviest first, without crumbs, in whole steps that sum to 1.
fn rounded(mut weights: Vec<(usize, f64)>) -> Vec<(usize, f64)> {
    weights.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    weights.truncate(4);
    weights.retain(|w| w.1 >= LEAST_WEIGHT);
    let sum: f64 = weights.iter().map(|w| w.1).sum();
    weights.iter_mut().for_each(|w| w.1 = (w.1 / sum / WEIGHT_STEP).round() * WEIGHT_STEP);
    let rest: f64 = weights[1..].iter().map(|w| w.1).sum();
    weights[0].1 = ((1.0 - rest) / WEIGHT_STEP).round() * WEIGHT_STEP;
    weights
}

/// Whether no two frames in a row change anything, and some frame does.
fn holds(subject: TakeSubject<'_>) -> bool {
    let changes: Vec<bool> = subject.take.frames.windows(2).map(|f| f[0].points != f[1].points).collect();
    changes.iter().any(|c| *c) && changes.windows(2).all(|c| !(c[0] && c[1])) && changes.len() > 2
}

/// Joints over time in a format's units, and how the bones turn.
struct Track {
    /// At rest, and in every frame.
    rest: Vec<DVec2>,
    joints: Vec<Vec<DVec2>>,
    /// For each bone, in radians, at rest and in every frame, without jumps against its parent's.
    rest_angle: Vec<f64>,
    angle: Vec<Vec<f64>>,
}

impl Track {
    fn new(subject: TakeSubject<'_>, units: Units) -> Self {
        let skeleton = &subject.character.skeleton;
        let parents = skeleton.parents();
        let rest: Vec<DVec2> = skeleton.joints.iter().map(|j| units.place(j.at)).collect();
        let joints: Vec<Vec<DVec2>> =
            subject.take.frames.iter().map(|f| f.joints.iter().map(|j| units.place(*j)).collect()).collect();
        let direction = |joints: &[DVec2], bone: usize| {
            let [from, to] = skeleton.bones[bone];
            (joints[to] - joints[from]).try_normalize()
        };
        let angles = |joints: &[DVec2], last: &[f64]| -> Vec<f64> {
            let mut angles: Vec<f64> = Vec::with_capacity(skeleton.bones.len());
            for bone in 0..skeleton.bones.len() {
                let base = |a: &[f64]| parents[bone].map_or(0.0, |p| a[p]);
                // A bone without length keeps its angle to its parent.
                let before = last[bone] - base(last);
                let angle = direction(joints, bone).map_or(before, |d| d.y.atan2(d.x) - base(&angles));
                let whole = std::f64::consts::TAU;
                angles.push(base(&angles) + angle - ((angle - before) / whole).round() * whole);
            }
            angles
        };
        let rest_angle = angles(&rest, &vec![0.0; skeleton.bones.len()]);
        let mut angle: Vec<Vec<f64>> = Vec::with_capacity(joints.len());
        for frame in &joints {
            angle.push(angles(frame, angle.last().unwrap_or(&rest_angle)));
        }
        Self { rest, joints, rest_angle, angle }
    }
}

/// The bones, and which of them moves the region of each bone of the skeleton.
fn bones(subject: TakeSubject<'_>, units: Units, track: &Track, holds: bool) -> (Vec<Bone>, Vec<usize>) {
    let character = subject.character;
    let skeleton = &character.skeleton;
    let frames = subject.take.frames.len();
    let parents = skeleton.parents();
    let name = |joint: usize| skeleton.joints[joint].name.clone();
    let one = || Channel { rest: DVec2::ONE, keys: Vec::new() };
    let place = |rest: DVec2, values: &[DVec2]| {
        let step = PLACE_STEP * units.scale;
        Channel::through(rest, values, step, BONE_TOLERANCE * units.scale, f64::INFINITY, holds)
    };
    let mut bones: Vec<Bone> = Vec::new();
    let roots: Vec<usize> =
        skeleton.roots().into_iter().filter(|j| skeleton.bones.iter().any(|b| b[0] == *j)).collect();
    for &root in &roots {
        let way: Vec<DVec2> = track.joints.iter().map(|j| j[root]).collect();
        let place = place(track.rest[root], &way);
        bones.push(Bone { name: name(root), parent: None, length: 0.0, place, turn: Channel::default(), scale: one() });
    }
    let mut mover = Vec::with_capacity(skeleton.bones.len());
    let mut ends = Vec::new();
    for (b, &[from, to]) in skeleton.bones.iter().enumerate() {
        let parent = match parents[b] {
            Some(p) => p + roots.len(),
            None => roots.iter().position(|r| *r == from).unwrap_or(0),
        };
        // Where it begins, as its parent sees it.
        let start = |joints: &[DVec2], angles: &[f64]| match parents[b] {
            Some(p) => DVec2::from_angle(-angles[p]).rotate(joints[from] - joints[skeleton.bones[p][0]]),
            None => DVec2::ZERO,
        };
        let starts: Vec<DVec2> = (0..frames).map(|f| start(&track.joints[f], &track.angle[f])).collect();
        let turn = |angles: &[f64]| dvec2((angles[b] - parents[b].map_or(0.0, |p| angles[p])).to_degrees(), 0.0);
        let turns: Vec<DVec2> = track.angle.iter().map(|a| turn(a)).collect();
        let lever =
            character.mesh.points.iter().map(|p| units.place(*p).distance(track.rest[from])).fold(1.0, f64::max);
        let tolerance = (BONE_TOLERANCE * units.scale / lever).to_degrees();
        let length = track.rest[to].distance(track.rest[from]);
        bones.push(Bone {
            name: format!("{}-{}", name(from), name(to)),
            parent: Some(parent),
            length,
            place: place(start(&track.rest, &track.rest_angle), &starts),
            turn: Channel::through(turn(&track.rest_angle), &turns, TURN_STEP, tolerance, MOST_TURN, holds),
            scale: one(),
        });
        mover.push(roots.len() + b);
        if let Some(values) = stretches(subject, units, track, b) {
            let tolerance = BONE_TOLERANCE * units.scale / lever;
            let scale = Channel::through(DVec2::ONE, &values, SCALE_STEP, tolerance, f64::INFINITY, holds);
            ends.push((b, scale));
        }
    }
    for (b, scale) in ends {
        let bone = &bones[roots.len() + b];
        let (name, length) = (format!("{}-stretch", bone.name), bone.length);
        let (place, turn) = (Channel::default(), Channel::default());
        bones.push(Bone { name, parent: Some(roots.len() + b), length, place, turn, scale });
        mover[b] = bones.len() - 1;
    }
    let mut taken = std::collections::HashSet::new();
    for bone in &mut bones {
        let plain = bone.name.clone();
        let mut count = 1;
        while !taken.insert(bone.name.clone()) {
            count += 1;
            bone.name = format!("{plain} {count}");
        }
    }
    (bones, mover)
}

/// How much a bone stretches along and across in every frame; `None` when it keeps its length.
fn stretches(subject: TakeSubject<'_>, units: Units, track: &Track, b: usize) -> Option<Vec<DVec2>> {
    let character = subject.character;
    let [from, to] = character.skeleton.bones[b];
    let length = track.rest[to].distance(track.rest[from]);
    let along: Vec<f64> = track
        .joints
        .iter()
        .map(|j| if length > 0.0 { j[to].distance(j[from]) / length } else { 1.0 })
        .map(|s| s.clamp(1.0 / MOST_SCALE, MOST_SCALE))
        .collect();
    // Less than what its keys may be off by.
    if along.iter().all(|s| (s - 1.0).abs() * length <= BONE_TOLERANCE * units.scale) {
        return None;
    }
    let own: Vec<(usize, f64)> = (0..character.mesh.points.len())
        .filter(|&v| character.regions.bone[v] as usize == b && character.regions.class[v] != VertexClass::Joint)
        .map(|v| (v, units.place(character.mesh.points[v]) - track.rest[from]))
        .map(|(v, p)| (v, DVec2::from_angle(-track.rest_angle[b]).rotate(p)))
        // Away from the joints, whose areas are blended.
        .filter(|(_, p)| p.x > 0.25 * length && p.x < 0.75 * length)
        .map(|(v, p)| (v, p.y))
        .collect();
    let square: f64 = own.iter().map(|(_, y)| y * y).sum();
    let across = |f: usize| {
        let now = |v: usize| units.place(subject.take.frames[f].points[v]) - track.joints[f][from];
        let sum: f64 = own.iter().map(|&(v, y)| y * DVec2::from_angle(-track.angle[f][b]).rotate(now(v)).y).sum();
        if square > 0.0 { (sum / square).clamp(1.0 / MOST_SCALE, MOST_SCALE) } else { 1.0 }
    };
    Some(along.into_iter().enumerate().map(|(f, s)| dvec2(s, across(f))).collect())
}
