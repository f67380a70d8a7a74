//! Joints added to a skeleton and taken away. What comes out is checked, so that bones are in their order again.

use glam::Vec2;

use super::skeleton::{Joint, Skeleton};
use crate::error::{Error, Result};

impl Skeleton {
    /// With another joint behind the others, on a bone from `parent`.
    ///
    /// # Errors
    /// A parent that is not there, a name twice, a place that is not a number.
    pub fn with_joint(&self, name: &str, at: Vec2, parent: usize) -> Result<Self> {
        let mut own = self.clone();
        own.joints.push(Joint { name: name.into(), at });
        own.bones.push([self.has(parent)?, self.joints.len()]);
        own.checked()
    }

    /// With another joint behind the others, in the middle of `bone`.
    ///
    /// # Errors
    /// A bone that is not there, a name twice, a place that is not a number.
    pub fn with_split(&self, name: &str, at: Vec2, bone: usize) -> Result<Self> {
        let Some(&[_, to]) = self.bones.get(bone) else {
            let problem = format!("is not there: there are {}", self.bones.len());
            return Err(Error::invalid(format!("bone {bone}"), problem, "name one of the bones"));
        };
        let mut own = self.clone();
        own.joints.push(Joint { name: name.into(), at });
        own.bones[bone][1] = self.joints.len();
        own.bones.push([self.joints.len(), to]);
        own.checked()
    }

    /// Without a joint: what hung from it hangs from the joint before it, or, at a root, from the first of what hung.
    ///
    /// # Errors
    /// A joint that is not there, or one without which no bone is left.
    pub fn without_joint(&self, joint: usize) -> Result<Self> {
        self.has(joint)?;
        let before = self.bones.iter().find(|b| b[1] == joint).map(|b| b[0]);
        let first = self.bones.iter().find(|b| b[0] == joint).map(|b| b[1]);
        let Some(heir) = before.or(first) else {
            return Err(Error::invalid(format!("joint {joint}"), "has no bones", "leave it"));
        };
        let down = |j: usize| if j > joint { j - 1 } else { j };
        let inherited = |j: usize| down(if j == joint { heir } else { j });
        let bones = self.bones.iter().map(|b| b.map(inherited)).filter(|b| b[0] != b[1]).collect();
        let mut joints = self.joints.clone();
        joints.remove(joint);
        Self { joints, bones }.checked()
    }

    fn has(&self, joint: usize) -> Result<usize> {
        if joint < self.joints.len() {
            return Ok(joint);
        }
        let problem = format!("is not there: there are {}", self.joints.len());
        Err(Error::invalid(format!("joint {joint}"), problem, "name one of the joints"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn joints_come_and_go_and_bones_stay_in_order() {
        let joints = ["a", "b", "c"].map(|n| Joint { name: n.into(), at: vec2(1.0, 1.0) }).to_vec();
        let own = Skeleton { joints, bones: vec![[0, 1], [1, 2]] }.checked().expect("a line");
        let more = own.with_joint("d", vec2(2.0, 2.0), 1).expect("a place for it");
        assert_eq!(more.bones, vec![[0, 1], [1, 2], [1, 3]]);
        let split = own.with_split("d", vec2(2.0, 2.0), 0).expect("a bone to split");
        assert_eq!(split.bones, vec![[0, 3], [3, 1], [1, 2]]);
        assert_eq!(split.without_joint(3).expect("a joint").bones, own.bones);
        assert_eq!(more.without_joint(1).expect("a joint").bones, vec![[0, 1], [0, 2]]);
        let rooted = more.without_joint(0).expect("a root");
        assert_eq!((rooted.bones, rooted.joints[0].name.as_str()), (vec![[0, 1], [0, 2]], "b"));
        for refused in [
            own.with_joint("a", vec2(0.0, 0.0), 0),
            own.with_joint("e", vec2(f32::NAN, 0.0), 0),
            own.with_joint("e", vec2(0.0, 0.0), 9),
            own.with_split("e", vec2(0.0, 0.0), 2),
            own.without_joint(3),
            own.without_joint(1).and_then(|s| s.without_joint(1)),
        ] {
            assert!(refused.is_err(), "{refused:?}");
        }
    }
}
