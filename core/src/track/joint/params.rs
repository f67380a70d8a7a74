//! All parameters of the joint tracker.

/// Parameters of [`super::JointTracker`]. Costs are of one part of the character; looks cost about 1 at worst.
#[derive(Clone, Debug, PartialEq)]
pub struct JointParams {
    /// Longest side of the working pictures in pixels; larger clips are reduced to it.
    pub working_side: u32,
    /// Lab distance (byte units) that counts as half different.
    pub colour: f32,
    /// Cost of a place of a part where another part is seen, at least and at most.
    pub claimed: f32,
    /// See [`Self::claimed`].
    pub hidden: f32,
    /// Cost of character just outside a part where there was none when it was marked.
    pub outside: f32,
    /// Cost of a bone that changes its length, and the change (as a natural logarithm) that counts half of it.
    pub length: f32,
    /// See [`Self::length`].
    pub length_reach: f32,
    /// Cost of a bone at a branching joint that turns apart from the others there, and the distance, as a share of its
    /// length, that counts half of it.
    pub attached: f32,
    /// See [`Self::attached`].
    pub attached_reach: f32,
    /// Cost of a change of motion, and the change that counts half of it, as a share of the bone's length.
    pub inertia: f32,
    /// See [`Self::inertia`].
    pub inertia_reach: f32,
    /// Cost of moving at all, and the motion that counts half of it.
    pub still: f32,
    /// See [`Self::still`].
    pub still_reach: f32,
    /// Poses of a limb kept from the search of one frame.
    pub found: usize,
    /// Partial poses kept while a frame is searched.
    pub beam: usize,
    /// Pairs of poses kept of two neighbouring frames while the best path is looked for.
    pub states: usize,
    /// How often all limbs are solved, each knowing where the others are.
    pub rounds: usize,
}

impl Default for JointParams {
    fn default() -> Self {
        Self {
            working_side: 400,
            colour: 30.0,
            claimed: 0.25,
            hidden: 0.45,
            outside: 0.4,
            length: 0.4,
            length_reach: 0.12,
            attached: 0.4,
            attached_reach: 0.12,
            inertia: 0.3,
            inertia_reach: 0.12,
            still: 0.1,
            still_reach: 0.5,
            found: 32,
            beam: 48,
            states: 400,
            rounds: 3,
        }
    }
}
