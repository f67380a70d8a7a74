//! The order in which limbs are solved, from the body outward, each hanging from one already solved; and which of them are
//! solved together.
//!
//! The skeleton's own roots follow drawing lengths; tracking wants the limb that holds the others first, because its
//! texture is the largest and nothing of its kind hides it.

use std::collections::VecDeque;

use crate::rig::{Rig, Side, Skeleton};

/// One limb's turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Turn {
    pub(super) limb: usize,
    /// Whether its vertices are taken from its end to its start, so that the first is the one it hangs from.
    pub(super) reversed: bool,
    /// The limb it hangs from and whether from that limb's drawn end (rather than its start).
    pub(super) from: Option<(usize, bool)>,
}

/// Every limb once, those that others hang from first; far limbs after near ones.
pub(super) fn solving_order(rig: &Rig, skeleton: &Skeleton) -> Vec<Turn> {
    let ends = |l: usize| {
        let v = &skeleton.limbs[l].vertices;
        [v[0], v[v.len() - 1]]
    };
    let limbs = rig.limbs.len();
    let joints = |l: usize| (0..limbs).filter(|&o| o != l && ends(o).iter().any(|e| ends(l).contains(e))).count();
    let far = |l: usize| rig.limbs[l].side == Some(Side::Far);
    let mut by_joints: Vec<usize> = (0..limbs).collect();
    by_joints.sort_by(|&a, &b| {
        let sided = |l: usize| matches!(rig.limbs[l].side, Some(Side::Near | Side::Far));
        (sided(a).cmp(&sided(b)))
            .then(both_ends_joined(b, limbs, &ends).cmp(&both_ends_joined(a, limbs, &ends)))
            .then(joints(b).cmp(&joints(a)))
            .then(rig.length_hint(b).total_cmp(&rig.length_hint(a)))
            .then(a.cmp(&b))
    });
    let mut placed = vec![false; limbs];
    let mut turns = Vec::with_capacity(limbs);
    for &first in &by_joints {
        if placed[first] {
            continue;
        }
        placed[first] = true;
        let mut waiting = VecDeque::from([Turn { limb: first, reversed: false, from: None }]);
        while let Some(turn) = waiting.pop_front() {
            turns.push(turn);
            for (is_end, vertex) in ends(turn.limb).into_iter().enumerate() {
                for &next in &by_joints {
                    if placed[next] {
                        continue;
                    }
                    let Some(side) = ends(next).iter().position(|&e| e == vertex) else { continue };
                    placed[next] = true;
                    waiting.push_back(Turn { limb: next, reversed: side == 1, from: Some((turn.limb, is_end == 1)) });
                }
            }
        }
    }
    // Stable: a far limb never carries a near or middle one in practice, and if one does it keeps its place.
    let carries = |l: usize| turns.iter().any(|t| t.from.is_some_and(|(p, _)| p == l));
    let (late, mut early): (Vec<Turn>, Vec<Turn>) = turns.iter().partition(|t| far(t.limb) && !carries(t.limb));
    early.extend(late);
    early
}

fn both_ends_joined(limb: usize, limbs: usize, ends: &dyn Fn(usize) -> [usize; 2]) -> bool {
    ends(limb).iter().all(|e| (0..limbs).any(|o| o != limb && ends(o).contains(e)))
}

/// Limbs that are solved together: pairs that may be mistaken for each other, near one first; the rest alone.
pub(super) fn groups(rig: &Rig, turns: &[Turn]) -> Vec<Vec<Turn>> {
    let carries = |l: usize| turns.iter().any(|t| t.from.is_some_and(|(p, _)| p == l));
    let mut placed = vec![false; rig.limbs.len()];
    let mut groups = Vec::new();
    for turn in turns {
        if placed[turn.limb] {
            continue;
        }
        placed[turn.limb] = true;
        let mut group = vec![*turn];
        if !carries(turn.limb)
            && let Some(other) = twin(rig, turns, *turn).filter(|t| !placed[t.limb] && !carries(t.limb))
        {
            placed[other.limb] = true;
            group.push(other);
            group.sort_by_key(|t| rig.limbs[t.limb].side == Some(Side::Far));
        }
        groups.push(group);
    }
    groups
}

/// The other of a pair: as the rig says; or, where it says nothing of sides, the limb on the same joint that is most
/// alike in length.
fn twin(rig: &Rig, turns: &[Turn], turn: Turn) -> Option<Turn> {
    let of = |l: usize| turns.iter().find(|t| t.limb == l).copied();
    if let Some(limb) = rig.twin(turn.limb) {
        return of(limb);
    }
    let unsided = |l: usize| rig.limbs[l].side.is_none();
    let ratio = |l: usize| {
        let (a, b) = (rig.length_hint(l), rig.length_hint(turn.limb));
        a.min(b) / a.max(b)
    };
    turn.from?;
    turns
        .iter()
        .filter(|t| t.limb != turn.limb && t.from == turn.from && unsided(t.limb) && unsided(turn.limb))
        .filter(|t| ratio(t.limb) > 0.8)
        .max_by(|a, b| ratio(a.limb).total_cmp(&ratio(b.limb)))
        .copied()
}
