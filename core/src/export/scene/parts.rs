//! A character's mesh in parts that are drawn one after the other, so that formats that order whole parts can tell depths.

use std::collections::HashMap;

use crate::geometry::PlaneMesh;
use crate::shape::character::{Character, TakeFrame};

/// The triangles of one region or of several that stay together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    /// The bones of the skeleton, in drawing order.
    pub(super) bones: Vec<usize>,
    /// Its vertices among the mesh's: those of its outline first, in order.
    pub(super) vertices: Vec<u32>,
    /// How many of them its outline has.
    pub(super) hull: usize,
    /// By the part's own vertices.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A part for each region that has triangles, in the order of the first frame.
pub(super) fn regions(character: &Character, frames: &[TakeFrame]) -> Vec<Part> {
    parts(character, drawn(character, &frames[0]).into_iter().map(|bone| vec![bone]))
}

/// As few parts as can be: regions that follow each other in every frame are one.
pub(super) fn together(character: &Character, frames: &[TakeFrame]) -> Vec<Part> {
    let orders: Vec<Vec<usize>> = depth_changes(frames).map(|f| drawn(character, &frames[f])).collect();
    let after = |bone: usize, next: usize| {
        orders.iter().all(|o| o.iter().position(|b| *b == bone).is_some_and(|at| o.get(at + 1) == Some(&next)))
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &bone in &orders[0] {
        match groups.last_mut() {
            Some(group) if group.last().is_some_and(|last| after(*last, bone)) => group.push(bone),
            _ => groups.push(vec![bone]),
        }
    }
    parts(character, groups.into_iter())
}

/// The frames whose depths are others than those of the frame before, the first among them.
fn depth_changes(frames: &[TakeFrame]) -> impl Iterator<Item = usize> {
    (0..frames.len()).filter(|&f| f == 0 || frames[f].depths != frames[f - 1].depths)
}

/// The bones whose regions have triangles, from the farthest to the nearest.
fn drawn(character: &Character, frame: &TakeFrame) -> Vec<usize> {
    let mut bones: Vec<usize> = character.triangle_bones().into_iter().map(|b| b as usize).collect();
    bones.sort_unstable_by_key(|&b| (frame.depths[b], b));
    bones.dedup();
    bones
}

fn parts(character: &Character, groups: impl Iterator<Item = Vec<usize>>) -> Vec<Part> {
    let owners = character.triangle_bones();
    let mut triangles: Vec<Vec<[u32; 3]>> = vec![Vec::new(); character.skeleton.bones.len()];
    for (t, owner) in character.mesh.triangles.iter().zip(owners) {
        triangles[owner as usize].push(*t);
    }
    groups
        .map(|bones| {
            let own: Vec<[u32; 3]> = bones.iter().flat_map(|&b| triangles[b].iter().copied()).collect();
            part(bones, own)
        })
        .collect()
}

fn part(bones: Vec<usize>, triangles: Vec<[u32; 3]>) -> Part {
    let mesh = PlaneMesh { points: Vec::new(), triangles };
    // Regions of several pieces or with holes: formats know one outline only, the longest.
    let rim = mesh.rims().into_iter().max_by_key(Vec::len).unwrap_or_default();
    let mut local: HashMap<u32, u32> = HashMap::new();
    let mut vertices: Vec<u32> = Vec::new();
    let mut add = |v: u32| {
        *local.entry(v).or_insert_with(|| {
            vertices.push(v);
            vertices.len() as u32 - 1
        })
    };
    // A rim that touches itself passes a vertex twice.
    let hull = rim.iter().map(|&v| add(v) + 1).max().unwrap_or(0) as usize;
    let triangles = mesh.triangles.iter().map(|t| t.map(&mut add)).collect();
    Part { bones, vertices, hull, triangles }
}

/// The frames in which the order of the parts changes, the first among them, and what it is then.
pub(super) fn orders(parts: &[Part], frames: &[TakeFrame]) -> Vec<(usize, Vec<usize>)> {
    let mut all: Vec<(usize, Vec<usize>)> = Vec::new();
    for f in depth_changes(frames) {
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by_key(|&p| (frames[f].depths[parts[p].bones[0]], parts[p].bones[0]));
        if all.last().is_none_or(|(_, last)| *last != order) {
            all.push((f, order));
        }
    }
    all
}

/// An order as the moves that Spine and DragonBones write: for each part that is not at its own place, in the order of
/// the parts, how many places it goes up.
pub(super) fn moves(order: &[usize]) -> Vec<(usize, i64)> {
    let mut moves: Vec<(usize, i64)> =
        order.iter().enumerate().map(|(place, &part)| (part, place as i64 - part as i64)).collect();
    moves.retain(|m| m.1 != 0);
    moves.sort_unstable();
    moves
}
