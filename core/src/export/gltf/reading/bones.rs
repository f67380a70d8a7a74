//! The hierarchy of a glTF file as bones: which nodes move a surface, their rest and their animation in whole frames.
//!
//! The rest of a joint is where its inverse bind matrix says that the surface was bound to it, which is what skinning
//! goes by; the transform of its node may be any pose. Nodes above the joints are bones as well where they move or
//! stand somewhere.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use glam::{DMat4, DQuat, DVec3};
use gltf_json::animation::{Animation, Interpolation, Property};
use gltf_json::validation::Checked;

use super::container::{Container, Found};
use crate::shape::{Bone, Transform};

/// How far a matrix may be from a turn and a move.
const RIGID: f64 = 2e-3;
/// Frames that an animation may have, and transforms in all of them, so that a few bytes cannot ask for all memory.
const MAX_FRAMES: usize = 100_000;
const MAX_TRANSFORMS: usize = 1 << 24;

/// The bones of a file.
pub(super) struct Bones {
    pub(super) bones: Vec<Bone>,
    pub(super) rest: Vec<Transform>,
    pub(super) animation: Vec<Vec<Transform>>,
    pub(super) fps: f64,
    /// For every node the bone that it is.
    pub(super) of_node: Vec<Option<usize>>,
    /// For every node where it stands at rest.
    pub(super) world: Vec<DMat4>,
}

/// A turn and a move.
type Rigid = (DQuat, DVec3);

/// The rate and the length that the file says its animation has.
#[derive(Clone, Copy, Default)]
pub(super) struct Timing {
    pub(super) fps: Option<f64>,
    pub(super) frames: Option<usize>,
}

impl Bones {
    /// The bones that move the surfaces at `surfaces` (nodes), with lengths in the file's units.
    pub(super) fn new(file: &Container<'_>, surfaces: &[usize], timing: Timing) -> Found<Self> {
        let nodes = &file.root.nodes;
        let parent = parents(file)?;
        let mut local = Vec::with_capacity(nodes.len());
        for node in 0..nodes.len() {
            local.push(node_transform(file, node)?);
        }
        let joints = joints(file, surfaces)?;
        let tracks = match file.root.animations.first() {
            Some(animation) => tracks(file, animation)?,
            None => Vec::new(),
        };
        let moves: BTreeSet<usize> = tracks.iter().map(|t| t.node).collect();
        let mut wanted: BTreeSet<usize> = joints.iter().map(|(node, _)| *node).collect();
        wanted.extend(surfaces.iter().filter(|s| nodes[**s].skin.is_none()));
        let above: Vec<usize> = wanted.iter().flat_map(|n| std::iter::successors(parent[*n], |p| parent[*p])).collect();
        wanted.extend(above.into_iter().filter(|n| moves.contains(n) || !still(&local[*n])));

        let order = sequence(file, &joints, &wanted, &parent);
        let mut of_node = vec![None; nodes.len()];
        order.iter().enumerate().for_each(|(bone, node)| of_node[*node] = Some(bone));
        let bone_above = |node: usize| std::iter::successors(parent[node], |p| parent[*p]).find_map(|p| of_node[p]);

        let mut world: Vec<Option<DMat4>> = vec![None; nodes.len()];
        for (node, bound) in &joints {
            world[*node] = Some(*bound);
        }
        let world = stand(&parent, &local, world);
        let mut bones = Vec::with_capacity(order.len());
        let mut places: Vec<Rigid> = Vec::with_capacity(order.len());
        let mut rest = Vec::with_capacity(order.len());
        for &node in &order {
            let name = nodes[node].name.clone().unwrap_or_else(|| format!("node {node}"));
            let place = rigid(world[node]).ok_or_else(|| scaled(&name))?;
            let above = bone_above(node);
            // Where its node stands is more exact than an inverse of an inverse.
            let (bound, own) = (relative(place, above.map(|b| places[b])), relative(local[node], None));
            let same = bound.translation.distance(own.translation) <= 1e-5 * (1.0 + place.1.length() as f32)
                && bound.rotation.dot(own.rotation).abs() > 1.0 - 1e-6;
            rest.push(if same { own } else { bound });
            places.push(place);
            bones.push(Bone { name, parent: above });
        }
        let fps = timing.fps.unwrap_or_else(|| rate(&tracks));
        let animation = play(&tracks, &order, &local, nodes.len(), fps, timing.frames)?;
        Ok(Self { bones, rest, animation, fps, of_node, world })
    }
}

fn scaled(name: &str) -> String {
    format!("`{name}` is scaled or sheared; apply the scale in the program that wrote it")
}

/// Every node's parent, in a forest.
fn parents(file: &Container<'_>) -> Found<Vec<Option<usize>>> {
    let nodes = &file.root.nodes;
    let mut parent = vec![None; nodes.len()];
    for (p, node) in nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            let slot = parent.get_mut(child.value()).ok_or("is damaged: a node's child is not there")?;
            if slot.replace(p).is_some() {
                return Err("is damaged: a node has two parents".into());
            }
        }
    }
    // With one parent each, whoever is not reached from a root hangs in a circle.
    let mut reached = 0;
    let mut waiting: Vec<usize> = (0..nodes.len()).filter(|n| parent[*n].is_none()).collect();
    while let Some(node) = waiting.pop() {
        reached += 1;
        waiting.extend(nodes[node].children.iter().flatten().map(|c| c.value()));
    }
    if reached < nodes.len() {
        return Err("is damaged: its nodes hang in a circle".into());
    }
    Ok(parent)
}

fn node_transform(file: &Container<'_>, node: usize) -> Found<Rigid> {
    let node = &file.root.nodes[node];
    let name = node.name.as_deref().unwrap_or("a node");
    if let Some(matrix) = &node.matrix {
        return rigid(DMat4::from_cols_array(&matrix.map(f64::from))).ok_or_else(|| scaled(name));
    }
    if node.scale.is_some_and(|s| s.iter().any(|s| (f64::from(*s) - 1.0).abs() > RIGID)) {
        return Err(scaled(name));
    }
    let turn = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)));
    let moved = node.translation.map_or(DVec3::ZERO, |t| DVec3::from_array(t.map(f64::from)));
    if !moved.is_finite() || !turn.is_finite() || turn.length() < 0.5 {
        return Err(format!("is damaged: `{name}` is nowhere"));
    }
    Ok((turn.normalize(), moved))
}

/// A matrix as a turn and a move, where it is nothing else.
fn rigid(matrix: DMat4) -> Option<Rigid> {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|a| a.truncate());
    let unit = axes.iter().all(|a| (a.length() - 1.0).abs() <= RIGID);
    let square = [(0, 1), (1, 2), (2, 0)].iter().all(|(a, b)| axes[*a].dot(axes[*b]).abs() <= RIGID);
    let place = matrix.w_axis.truncate();
    (unit && square && axes[0].cross(axes[1]).dot(axes[2]) > 0.0 && place.is_finite())
        .then(|| (DQuat::from_mat3(&glam::DMat3::from_cols(axes[0], axes[1], axes[2])).normalize(), place))
}

fn still((turn, moved): &Rigid) -> bool {
    turn.w.abs() > 1.0 - 1e-9 && moved.length() < 1e-9
}

/// A place relative to another, in single precision.
fn relative((turn, place): Rigid, above: Option<Rigid>) -> Transform {
    let (turn, place) = match above {
        None => (turn, place),
        Some((base, from)) => (base.conjugate() * turn, base.conjugate() * (place - from)),
    };
    Transform { translation: place.as_vec3(), rotation: turn.normalize().as_quat().normalize() }
}

/// The joints of the surfaces' skins and where the surfaces were bound to them; each once.
fn joints(file: &Container<'_>, surfaces: &[usize]) -> Found<Vec<(usize, DMat4)>> {
    let mut out: Vec<(usize, DMat4)> = Vec::new();
    let mut seen = BTreeSet::new();
    let skins: BTreeSet<usize> = surfaces.iter().filter_map(|s| file.root.nodes[*s].skin).map(|s| s.value()).collect();
    for skin in skins {
        let skin = file.root.skins.get(skin).ok_or("is damaged: a skin is not there")?;
        let backs = match skin.inverse_bind_matrices {
            Some(accessor) => file.numbers::<16>(accessor)?,
            None => vec![DMat4::IDENTITY.to_cols_array(); skin.joints.len()],
        };
        for (joint, back) in skin.joints.iter().zip(backs) {
            if joint.value() >= file.root.nodes.len() {
                return Err("is damaged: a joint is not there".into());
            }
            let back = DMat4::from_cols_array(&back);
            if !back.is_finite() || back.determinant().abs() < 1e-12 {
                return Err("is damaged: a joint is bound nowhere".into());
            }
            if seen.insert(joint.value()) {
                out.push((joint.value(), back.inverse()));
            }
        }
    }
    Ok(out)
}

/// Where every node stands at rest: as known, else by its own transform in its parent.
fn stand(parent: &[Option<usize>], local: &[Rigid], known: Vec<Option<DMat4>>) -> Vec<DMat4> {
    let mut world = known;
    for node in 0..world.len() {
        let mut chain: Vec<usize> = Vec::new();
        let mut at = Some(node);
        while let Some(n) = at.filter(|n| world[*n].is_none()) {
            chain.push(n);
            at = parent[n];
        }
        for n in chain.into_iter().rev() {
            let above = parent[n].and_then(|p| world[p]).unwrap_or(DMat4::IDENTITY);
            world[n] = Some(above * DMat4::from_rotation_translation(local[n].0, local[n].1));
        }
    }
    world.into_iter().map(Option::unwrap_or_default).collect()
}

/// The nodes that are bones, parents before children. Chains that are named `limb.0`, `limb.1`, ... stay together,
/// whatever order the file lists them in; else as listed.
fn sequence(
    file: &Container<'_>,
    joints: &[(usize, DMat4)],
    wanted: &BTreeSet<usize>,
    parent: &[Option<usize>],
) -> Vec<usize> {
    let place: BTreeMap<usize, usize> = joints.iter().enumerate().map(|(i, (j, _))| (*j, i)).collect();
    let listed = |node: usize| place.get(&node).copied().unwrap_or(joints.len() + node);
    let limb_of = |node: usize| {
        let name = file.root.nodes[node].name.as_deref()?;
        let (limb, number) = name.rsplit_once('.')?;
        Some((limb.to_owned(), number.parse::<u32>().ok()?))
    };
    let mut first_of = BTreeMap::new();
    for &node in wanted {
        if let Some((limb, _)) = limb_of(node) {
            let first = first_of.entry(limb).or_insert(usize::MAX);
            *first = listed(node).min(*first);
        }
    }
    let key = |node: usize| match limb_of(node) {
        Some((limb, number)) => (first_of[&limb], number, listed(node)),
        None => (listed(node), 0, listed(node)),
    };
    let above = |node: usize| std::iter::successors(parent[node], |p| parent[*p]).find(|p| wanted.contains(p));
    let mut below: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut ready = BinaryHeap::new();
    for &node in wanted {
        match above(node) {
            Some(p) => below.entry(p).or_default().push(node),
            None => ready.push(Reverse((key(node), node))),
        }
    }
    let mut order = Vec::with_capacity(wanted.len());
    while let Some(Reverse((_, first))) = ready.pop() {
        let mut chain = Some(first);
        while let Some(node) = chain.take() {
            order.push(node);
            let next = limb_of(node).map(|(limb, number)| (limb, number.wrapping_add(1)));
            for child in below.remove(&node).into_iter().flatten() {
                if chain.is_none() && next.is_some() && limb_of(child) == next {
                    chain = Some(child);
                } else {
                    ready.push(Reverse((key(child), child)));
                }
            }
        }
    }
    order
}

/// One channel of an animation.
struct Track {
    node: usize,
    times: Vec<f64>,
    values: Values,
    interpolation: Interpolation,
}

enum Values {
    Turns(Vec<[f64; 4]>),
    Moves(Vec<[f64; 3]>),
}

fn tracks(file: &Container<'_>, animation: &Animation) -> Found<Vec<Track>> {
    let mut out = Vec::new();
    for channel in &animation.channels {
        let node = channel.target.node.value();
        let name = file.root.nodes.get(node).ok_or("is damaged: what an animation moves is not there")?;
        let sampler = animation.samplers.get(channel.sampler.value()).ok_or("is damaged: a sampler is not there")?;
        let Checked::Valid(interpolation) = sampler.interpolation else {
            return Err("is damaged: it blends in no known way".into());
        };
        let times: Vec<f64> = file.numbers::<1>(sampler.input)?.into_iter().map(|[t]| t).collect();
        let rising = times.windows(2).all(|w| w[0] < w[1]) && times.iter().all(|t| t.is_finite() && *t >= 0.0);
        if times.is_empty() || !rising {
            return Err("is damaged: its animation's times do not rise".into());
        }
        let values = match channel.target.path {
            Checked::Valid(Property::Rotation) => Values::Turns(file.numbers(sampler.output)?),
            Checked::Valid(Property::Translation) => Values::Moves(file.numbers(sampler.output)?),
            Checked::Valid(Property::Scale) => {
                let scales = file.numbers::<3>(sampler.output)?;
                if scales.iter().flatten().any(|s| (s - 1.0).abs() > RIGID) {
                    return Err(scaled(name.name.as_deref().unwrap_or("a node")));
                }
                continue;
            }
            Checked::Valid(Property::MorphTargetWeights) | Checked::Invalid => continue,
        };
        let (held, real) = match &values {
            Values::Turns(v) => (v.len(), v.iter().flatten().all(|v| v.is_finite())),
            Values::Moves(v) => (v.len(), v.iter().flatten().all(|v| v.is_finite())),
        };
        let each = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if held != each * times.len() || !real {
            return Err("is damaged: its animation has not one value a time".into());
        }
        out.push(Track { node, times, values, interpolation });
    }
    Ok(out)
}

impl Track {
    /// Between which keys a time lies, how far along, and how long that stretch is.
    fn around(&self, time: f64) -> (usize, usize, f64, f64) {
        let after = self.times.partition_point(|t| *t <= time);
        let (a, b) = (after.saturating_sub(1), after.min(self.times.len() - 1));
        let long = self.times[b] - self.times[a];
        let share = if long > 0.0 { ((time - self.times[a]) / long).clamp(0.0, 1.0) } else { 0.0 };
        (a, b, if self.interpolation == Interpolation::Step { 0.0 } else { share }, long)
    }

    /// The value at a time, as glTF 2.0 appendix C blends.
    fn at<const N: usize>(&self, values: &[[f64; N]], time: f64) -> [f64; N] {
        let (a, b, t, long) = self.around(time);
        if self.interpolation != Interpolation::CubicSpline {
            return std::array::from_fn(|i| values[a][i] + (values[b][i] - values[a][i]) * t);
        }
        let (t2, t3) = (t * t, t * t * t);
        std::array::from_fn(|i| {
            let (from, out) = (values[3 * a + 1][i], values[3 * a + 2][i]);
            let (into, to) = (values[3 * b][i], values[3 * b + 1][i]);
            (2.0 * t3 - 3.0 * t2 + 1.0) * from
                + long * (t3 - 2.0 * t2 + t) * out
                + (3.0 * t2 - 2.0 * t3) * to
                + long * (t3 - t2) * into
        })
    }

    fn turn(&self, values: &[[f64; 4]], time: f64) -> Option<DQuat> {
        let quat = if self.interpolation == Interpolation::CubicSpline {
            DQuat::from_array(self.at(values, time))
        } else {
            let (a, b, t, _) = self.around(time);
            DQuat::from_array(values[a]).slerp(DQuat::from_array(values[b]), t)
        };
        (quat.is_finite() && quat.length() > 1e-6).then(|| quat.normalize())
    }
}

/// The rate of keys that stand a frame apart: the shortest stretch between two.
fn rate(tracks: &[Track]) -> f64 {
    let stretches = tracks.iter().flat_map(|t| t.times.windows(2).map(|w| w[1] - w[0]));
    let shortest = stretches.fold(f64::INFINITY, f64::min);
    // A file without keys says nothing of time; films run at 24.
    if shortest.is_finite() { (1.0 / shortest).clamp(1.0, 240.0) } else { 24.0 }
}

/// The bones' transforms in whole frames from the first key on.
fn play(
    tracks: &[Track],
    order: &[usize],
    local: &[Rigid],
    nodes: usize,
    fps: f64,
    frames: Option<usize>,
) -> Found<Vec<Vec<Transform>>> {
    let ends = |pick: fn(&Track) -> Option<&f64>| tracks.iter().filter_map(pick).copied();
    let start = ends(|t| t.times.first()).fold(f64::INFINITY, f64::min);
    let start = if start.is_finite() { start } else { 0.0 };
    let end = ends(|t| t.times.last()).fold(start, f64::max);
    let keyed = ((end - start) * fps).round();
    let count = frames.unwrap_or(0).max(if keyed < MAX_FRAMES as f64 { keyed as usize + 1 } else { usize::MAX });
    if count > MAX_FRAMES.min(MAX_TRANSFORMS / order.len().max(1)) {
        return Err(format!("has an animation of {count} frames of {} bones, which is too long", order.len()));
    }
    let mut channels: Vec<[Option<&Track>; 2]> = vec![[None; 2]; nodes];
    for track in tracks {
        channels[track.node][usize::from(matches!(track.values, Values::Moves(_)))].get_or_insert(track);
    }
    let mut out = Vec::with_capacity(count);
    for frame in 0..count {
        let time = start + frame as f64 / fps;
        let mut pose = Vec::with_capacity(order.len());
        for &node in order {
            let (mut turn, mut moved) = local[node];
            if let Some(track) = channels[node][0]
                && let Values::Turns(values) = &track.values
            {
                turn = track.turn(values, time).ok_or("is damaged: its animation turns something nowhere")?;
            }
            if let Some(track) = channels[node][1]
                && let Values::Moves(values) = &track.values
            {
                moved = DVec3::from_array(track.at(values, time));
            }
            pose.push(Transform { translation: moved.as_vec3(), rotation: turn.as_quat().normalize() });
        }
        out.push(pose);
    }
    Ok(out)
}
