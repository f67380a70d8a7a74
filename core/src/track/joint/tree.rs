//! The skeleton as it is solved: from the part that says most, outward, in chains that do not branch.

use super::parts::Part;
use crate::rig::JointMarks;

/// A bone between two joints.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bone {
    pub(super) joints: [usize; 2],
    /// It leads to a place beyond a free end, which nobody marked.
    pub(super) tip: bool,
}

impl Bone {
    pub(super) fn joins(&self, joint: usize) -> bool {
        self.joints.contains(&joint)
    }

    pub(super) fn other(&self, joint: usize) -> usize {
        if self.joints[0] == joint { self.joints[1] } else { self.joints[0] }
    }
}

/// All bones; joints by their place in [`JointMarks::names`], then those nobody marked.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    pub(super) bones: Vec<Bone>,
}

/// Bones one after the other, from a joint that is solved before.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    /// One more than bones.
    pub(super) joints: Vec<usize>,
    pub(super) bones: Vec<usize>,
    /// Nothing holds its first joint.
    pub(super) free: bool,
    /// The bone beside which the first one is attached, where it is at a branching joint.
    pub(super) beside: Option<usize>,
}

impl Tree {
    pub(super) fn new(marks: &JointMarks) -> Self {
        let names = marks.names();
        let index = |name: &str| names.iter().position(|n| *n == name);
        let bone = |(a, b): &(String, String)| Some(Bone { joints: [index(a)?, index(b)?], tip: false });
        Self { bones: marks.bones.iter().filter_map(bone).collect() }
    }

    /// The chains in the order they are solved.
    pub(super) fn chains(&self, parts: &[Part]) -> Vec<Chain> {
        let says = |b: usize| parts[b].area * parts[b].weight;
        let mut left: Vec<bool> = vec![true; self.bones.len()];
        let mut chains: Vec<Chain> = Vec::new();
        while let Some(anchor) =
            (0..left.len()).filter(|&b| left[b]).max_by(|&a, &b| says(a).total_cmp(&says(b)).then(b.cmp(&a)))
        {
            left[anchor] = false;
            let joints = self.bones[anchor].joints.to_vec();
            let mut reached = joints.clone();
            chains.push(Chain { joints, bones: vec![anchor], free: true, beside: None });
            // Chains that lead on come before limbs that end, and of those the larger ones first.
            loop {
                let open = reached.iter().flat_map(|&j| (0..left.len()).map(move |b| (j, b)));
                let open = open.filter(|&(j, b)| left[b] && self.bones[b].joins(j));
                let grown: Vec<(bool, f32, Chain)> = open.map(|(j, b)| self.chain(j, b, &left, parts)).collect();
                let better = |a: &(bool, f32, Chain), b: &(bool, f32, Chain)| {
                    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(b.2.bones.cmp(&a.2.bones))
                };
                let Some((_, _, chain)) = grown.into_iter().max_by(better) else { break };
                chain.bones.iter().for_each(|&b| left[b] = false);
                reached.extend(&chain.joints[1..]);
                chains.push(chain);
            }
        }
        chains
    }

    /// The chain that starts with a bone at a joint; whether it ends where others begin, and how large it is.
    fn chain(&self, joint: usize, bone: usize, left: &[bool], parts: &[Part]) -> (bool, f32, Chain) {
        let at = |j: usize| (0..self.bones.len()).filter(move |&b| self.bones[b].joins(j));
        let branching = at(joint).filter(|&b| !self.bones[b].tip).count() > 2;
        let beside = at(joint)
            .filter(|&b| !left[b])
            .max_by(|&a, &b| parts[a].rest.length().total_cmp(&parts[b].rest.length()).then(b.cmp(&a)));
        let (mut joints, mut bones) = (vec![joint, self.bones[bone].other(joint)], vec![bone]);
        let leads_on = loop {
            let (end, last) = (joints[joints.len() - 1], bones[bones.len() - 1]);
            let mut next = at(end).filter(|&b| b != last);
            match (next.next(), next.next()) {
                (Some(only), None) => {
                    bones.push(only);
                    joints.push(self.bones[only].other(end));
                }
                (None, _) => break false,
                _ => break true,
            }
        };
        let area = bones.iter().map(|&b| parts[b].area).sum();
        (leads_on, area, Chain { joints, bones, free: false, beside: beside.filter(|_| branching) })
    }
}
