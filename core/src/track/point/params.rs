//! All parameters of the point tracker in one struct.

/// Parameters of [`super::PointTracker`]. Lengths are in pixels of a 512 x 512 picture, costs of one frame; looks cost 1
/// at worst.
#[derive(Clone, Debug, PartialEq)]
pub struct PointParams {
    /// Longest side of the working pictures; larger clips are reduced to it, those below 400 enlarged, twice at most.
    pub working_side: u32,
    /// Places looked at in a frame, chosen by their colours.
    pub looked_at: usize,
    /// Candidates kept of a frame.
    pub candidates: usize,
    /// Least distance between two candidates.
    pub apart: f32,
    /// Weight of looking unlike the marked places.
    pub looks: f32,
    /// How unlike counts half.
    pub looks_reach: f32,
    /// Weight of changing looks from frame to frame.
    pub update: f32,
    /// Weight of leaving the dense flow, where it is trusted.
    pub flow: f32,
    /// Distance from the flow's target that counts half.
    pub flow_reach: f32,
    /// Share of its weight that the flow costs where it is not trusted.
    pub lost: f32,
    /// Weight of moving at all.
    pub velocity: f32,
    /// Motion that counts half.
    pub velocity_reach: f32,
    /// Weight of changing motion.
    pub inertia: f32,
    /// Change of motion that counts half.
    pub inertia_reach: f32,
    /// Weight of turning, a radian.
    pub turn: f32,
    /// Frames that may be skipped in a row.
    pub skip: usize,
    /// Cost of skipping at all, and of every skipped frame.
    pub hide: f32,
    /// See [`Self::hide`].
    pub hidden: f32,
    /// Steps from frame to frame that are kept for weighing inertia.
    pub steps: usize,
    /// Points of which one looks no more unlike the other than this, at some turn, are told apart together.
    pub alike: f32,
    /// Places nearer to each other than this are one.
    pub together: f32,
    /// Cost of each frame in which two points that look alike are in one place.
    pub shared: f32,
    /// Weight of leaving where all points, tracked together as limbs, would have it; 0 tracks each alone, in less time.
    pub guide: f32,
    /// Distance from there that counts half.
    pub guide_reach: f32,
    /// A guide errs where following it costs so much more, all frames together, than a smooth way without it.
    pub dear: f32,
    /// A way is smooth that costs less a frame,
    pub smooth: f32,
    /// and in no frame so much.
    pub leap: f32,
    /// How often candidates near the path are added and the path is found again.
    pub rounds: usize,
}

impl Default for PointParams {
    fn default() -> Self {
        Self {
            working_side: 640,
            looked_at: 64,
            candidates: 8,
            apart: 4.0,
            looks: 0.15,
            looks_reach: 0.3,
            update: 0.02,
            flow: 3.0,
            lost: 0.0,
            flow_reach: 2.5,
            velocity: 0.1,
            velocity_reach: 20.0,
            inertia: 0.3,
            inertia_reach: 6.0,
            turn: 0.1,
            skip: 10,
            hide: 2.0,
            hidden: 0.8,
            steps: 200,
            alike: 0.3,
            together: 5.0,
            shared: 0.5,
            guide: 2.0,
            guide_reach: 35.0,
            dear: 8.0,
            smooth: 0.15,
            leap: 1.0,
            rounds: 2,
        }
    }
}
