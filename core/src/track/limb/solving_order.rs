//! The order in which limbs are solved: from the body outward, each hanging from one already solved.
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
