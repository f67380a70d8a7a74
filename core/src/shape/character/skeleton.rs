//! The skeleton of a character: named joints, and straight bones between them that hang together as trees.

use glam::Vec2;

use crate::error::{Error, Result};

/// A joint.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Joint {
    /// Unique among the joints.
    pub name: String,
    /// Where it is on the picture at rest, in pixels.
    pub at: Vec2,
}

/// Joints and the bones between them. The first joint of a tree is its root.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Skeleton {
    /// The joints.
    pub joints: Vec<Joint>,
    /// Pairs of joints, from the one nearer to the root outward.
    pub bones: Vec<[usize; 2]>,
}

impl Skeleton {
    /// Checks it, and turns and orders the bones so that each comes after the one that it hangs from. Trees are rooted
    /// at the joint that the first of their bones begins with, unless another bone ends there.
    ///
    /// # Errors
    /// No bone, a joint that is not there, a joint twice in one bone, bones that close a circle, a name twice, a place
    /// that is not a number.
    pub fn checked(mut self) -> Result<Self> {
        let bad = |what: String, problem: &str, remedy: &str| Err(Error::invalid(what, problem, remedy));
        if self.bones.is_empty() {
            return bad("skeleton".into(), "has no bones", "connect at least two joints");
        }
        for (i, joint) in self.joints.iter().enumerate() {
            if !joint.at.is_finite() {
                return bad(format!("joint `{}`", joint.name), "is not at a number", "give finite places");
            }
            if self.joints[..i].iter().any(|j| j.name == joint.name) {
                return bad(format!("joint `{}`", joint.name), "appears twice", "give each joint its own name");
            }
        }
        let mut tree: Vec<usize> = (0..self.joints.len()).collect();
        for (b, &[from, to]) in self.bones.iter().enumerate() {
            if from >= self.joints.len() || to >= self.joints.len() {
                return bad(format!("bone {b}"), "names a joint that is not there", "check the joints");
            }
            if from == to {
                return bad(format!("bone {b}"), "begins and ends at one joint", "connect two joints");
            }
            let (a, c) = (tree[from], tree[to]);
            if a == c {
                return bad(format!("bone {b}"), "closes a circle", "leave one bone of the circle out");
            }
            tree.iter_mut().filter(|t| **t == c).for_each(|t| *t = a);
        }
        let ends: Vec<bool> = (0..self.joints.len()).map(|j| self.bones.iter().any(|b| b[1] == j)).collect();
        let mut ordered: Vec<[usize; 2]> = Vec::with_capacity(self.bones.len());
        let mut placed = vec![false; self.bones.len()];
        while ordered.len() < self.bones.len() {
            let open = |b: &usize| !placed[*b];
            let first = (0..self.bones.len()).filter(open).find(|&b| !ends[self.bones[b][0]]);
            let Some(first) = first.or_else(|| (0..self.bones.len()).find(open)) else { break };
            let mut waiting = std::collections::VecDeque::from([self.bones[first][0]]);
            while let Some(joint) = waiting.pop_front() {
                for b in 0..self.bones.len() {
                    let bone = self.bones[b];
                    if placed[b] || !bone.contains(&joint) {
                        continue;
                    }
                    placed[b] = true;
                    let outward = if bone[0] == joint { bone } else { [bone[1], bone[0]] };
                    waiting.push_back(outward[1]);
                    ordered.push(outward);
                }
            }
        }
        self.bones = ordered;
        Ok(self)
    }

    /// The bone that each bone hangs from.
    pub fn parents(&self) -> Vec<Option<usize>> {
        self.bones.iter().map(|bone| self.bones.iter().position(|b| b[1] == bone[0])).collect()
    }

    /// Where every bone begins and ends, with the joints at `joints`.
    pub fn segments(&self, joints: &[Vec2]) -> Vec<(Vec2, Vec2)> {
        self.bones.iter().map(|&[from, to]| (joints[from], joints[to])).collect()
    }

    /// Where the joints are at rest.
    pub fn rest(&self) -> Vec<Vec2> {
        self.joints.iter().map(|j| j.at).collect()
    }

    /// The joint called `name`.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name == name)
    }

    /// Joints that no bone ends at: the roots of the trees.
    pub fn roots(&self) -> Vec<usize> {
        let ends = |j: &usize| self.bones.iter().any(|b| b[1] == *j);
        (0..self.joints.len()).filter(|j| !ends(j)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    fn skeleton(bones: &[[usize; 2]]) -> Skeleton {
        let joints = (0..5).map(|i| Joint { name: i.to_string(), at: vec2(i as f32, 0.0) }).collect();
        Skeleton { joints, bones: bones.to_vec() }
    }

    #[test]
    fn bones_turn_outward_and_follow_their_parents() {
        let own = skeleton(&[[2, 1], [2, 3], [1, 0], [4, 3]]).checked().expect("a tree");
        assert_eq!(own.bones, vec![[2, 1], [2, 3], [1, 0], [3, 4]]);
        assert_eq!(own.parents(), vec![None, None, Some(0), Some(1)]);
        assert_eq!(own.roots(), vec![2]);
    }

    #[test]
    fn what_is_no_forest_is_refused() {
        for (bones, problem) in [
            (&[][..], "no bones"),
            (&[[0, 9]][..], "not there"),
            (&[[1, 1]][..], "one joint"),
            (&[[0, 1], [1, 2], [2, 0]][..], "circle"),
        ] {
            let error = skeleton(bones).checked().expect_err("refused").to_string();
            assert!(error.contains(problem), "{error}");
        }
    }
}
