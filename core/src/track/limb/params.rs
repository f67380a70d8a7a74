//! All parameters of the limb tracker in one struct: the paper's values as they scale, and ours.
//!
//! Reinert 2016 (section 3.5) gives pixel constants for clips squeezed to 512 x 512. Marey keeps the aspect ratio, so
//! every constant in pixels is multiplied by [`LimbParams::scale`]: the geometric mean of the working image's sides
//! over 512.

/// How limbs are followed between key frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// One optimum over all frames of a range: dense flow, key-frame appearance, limb rigidity, gait of hidden limbs.
    #[default]
    SpaceTime,
    /// Reinert 2016, section 3.5: SSD templates, tree dynamic programming frame by frame, both directions blended.
    Paper,
}

/// Parameters of [`super::LimbTracker`]. Lengths are in pixels of a 512 x 512 image unless said otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbParams {
    /// Which tracker.
    pub method: Method,
    /// Longest side of the working image in pixels; larger clips are reduced to it.
    pub working_side: u32,
    /// Distance between skeleton vertices (paper: about 10).
    pub spacing: f32,
    /// The space-time tracker.
    pub space_time: SpaceTimeParams,
    /// The paper's tracker.
    pub paper: PaperParams,
}

/// Parameters of the space-time tracker. Costs are of one vertex; looks cost about 1 at worst. Lengths are shares of
/// the limb's own.
#[derive(Clone, Debug, PartialEq)]
pub struct SpaceTimeParams {
    /// Cost of leaving the flow, where it is trusted.
    pub flow: f32,
    /// Distance from the flow's target that counts in full.
    pub flow_reach: f32,
    /// Cost of moving with respect to the joint a limb hangs by.
    pub still: f32,
    /// Movement in a frame that counts in full.
    pub still_reach: f32,
    /// Cost of changing its motion with respect to that joint.
    pub inertia: f32,
    /// Change of motion between frames that counts in full.
    pub inertia_reach: f32,
    /// States kept of a frame where inertia is weighed; a state is one pose of every limb that is solved at once.
    pub states: usize,
    /// Poses as near as this to each other, in the mean, are one state.
    pub same: f32,
    /// Partial poses kept while a frame is searched for a limb.
    pub beam: usize,
    /// Whole poses that such a search hands on.
    pub found: usize,
    /// How often poses near the path are added and the path is found again.
    pub rounds: usize,
}

impl Default for SpaceTimeParams {
    fn default() -> Self {
        Self {
            flow: 0.25,
            flow_reach: 0.08,
            still: 0.15,
            still_reach: 0.5,
            inertia: 0.3,
            inertia_reach: 0.6,
            states: 100,
            same: 0.02,
            beam: 64,
            found: 16,
            rounds: 2,
        }
    }
}

/// Parameters of key-frame templates, see [`super::KeyTemplates`]. Lengths are in pixels of a 512 x 512 image.
#[derive(Clone, Debug, PartialEq)]
pub struct TemplateParams {
    /// Side of the square patches compared.
    pub side: f32,
    /// Standard deviation, as a share of the side, of the Gaussian by which pixels far from the vertex weigh less.
    pub sigma: f32,
    /// Weight of pixels that do not look like the limb, against 1 for those that do.
    pub background: f32,
    /// Largest squared Lab difference (of Lab / 100) that one pixel counts for.
    pub truncation: f32,
    /// Places returned by one search.
    pub candidates: usize,
    /// Least distance between two of them.
    pub separation: f32,
}

/// Parameters of the 2016 paper's tracker, with the paper's values as defaults where it gives any. Lengths are in
/// pixels of a 512 x 512 image.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperParams {
    /// Side of the square window that is searched around the previous place (paper: 64).
    pub window: f32,
    /// Side of the square patches compared (paper: 32).
    pub patch: f32,
    /// How many of the last unoccluded frames give templates (paper: 3).
    pub templates: usize,
    /// How many rotations of each template are tried (paper: 7).
    pub rotations: usize,
    /// Largest rotation in degrees, either way (paper: 10).
    pub max_rotation: f32,
    /// Unoccluded candidates kept for a vertex: the best local minima (paper: 5).
    pub candidates: usize,
    /// Occluded candidates for a vertex, on a regular grid over the window (paper: 100).
    pub occluded_candidates: usize,
    /// Cost of being occluded, over the best unoccluded cost of the previous frame (paper: 1.5).
    pub occlusion_cost: f32,
    /// Weight of the distance and direction terms (paper: 10).
    pub smoothness: f32,
    /// Points of cost for one mean squared colour difference on a 0..1 scale. The paper leaves the unit open; with much
    /// less, hiding everything and keeping still is cheapest, with much more the limbs fall apart.
    pub colour_unit: f32,
    /// Least distance between two unoccluded candidates; keeps one blob from filling the list.
    pub separation: f32,
    /// A far limb's vertices nearer than this to another stroke must be occluded (paper: 20).
    pub crowding: f32,
    /// Whether windows are searched at a quarter of the size first, and only around the best places at full size (paper:
    /// no; it is some fifty times less work for nearly the same places).
    pub coarse_to_fine: bool,
    /// Whether patches are compared in Lab, pixels near the vertex weighing more, and placed between pixels (paper:
    /// no: sRGB, all alike, whole pixels).
    pub lab: bool,
    /// Largest squared colour difference, on a 0..1 scale, that one pixel counts for (paper: no bound).
    pub colour_truncation: f32,
    /// Largest distance or direction cost of one edge (paper: no bound).
    pub edge_truncation: f32,
    /// Share of the matching cost that templates of the key frames give, turned with the limb (paper: 0).
    pub anchored: f32,
    /// Side of the window around the place where dense flow sees the vertex go, used in place of `window` around the
    /// place where it was (paper: none).
    pub flow_window: Option<f32>,
}

impl Default for LimbParams {
    fn default() -> Self {
        Self {
            method: Method::default(),
            working_side: 768,
            spacing: 10.0,
            space_time: SpaceTimeParams::default(),
            paper: PaperParams::default(),
        }
    }
}

impl Default for TemplateParams {
    fn default() -> Self {
        Self { side: 32.0, sigma: 0.3, background: 0.35, truncation: 0.09, candidates: 5, separation: 4.0 }
    }
}

impl TemplateParams {
    /// The same with lengths for an image in which `scale` pixels are one of the 512 x 512 image's.
    pub fn scaled(&self, scale: f32) -> Self {
        Self { side: self.side * scale, separation: self.separation * scale, ..self.clone() }
    }
}

impl Default for PaperParams {
    fn default() -> Self {
        Self {
            window: 64.0,
            patch: 32.0,
            templates: 3,
            rotations: 7,
            max_rotation: 10.0,
            candidates: 5,
            occluded_candidates: 100,
            occlusion_cost: 1.5,
            smoothness: 10.0,
            colour_unit: 500_000.0,
            separation: 3.0,
            crowding: 20.0,
            coarse_to_fine: true,
            lab: false,
            colour_truncation: f32::INFINITY,
            edge_truncation: f32::INFINITY,
            anchored: 0.0,
            flow_window: None,
        }
    }
}

impl PaperParams {
    /// The paper's frame by frame method with all that measured better than its own choices.
    pub fn improved() -> Self {
        Self {
            occlusion_cost: 3.0,
            smoothness: 2.0,
            colour_unit: 200_000.0,
            lab: true,
            colour_truncation: 0.09,
            edge_truncation: 8.0,
            anchored: 0.5,
            flow_window: Some(24.0),
            ..Self::default()
        }
    }
}

impl LimbParams {
    /// Working pixels for one pixel of the paper's 512 x 512 image, for a working image of this size.
    pub fn scale(width: usize, height: usize) -> f32 {
        ((width * height) as f32).sqrt() / 512.0
    }
}
