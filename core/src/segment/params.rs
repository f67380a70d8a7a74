//! All parameters of the built-in segmenter in one struct: the paper's values and ours.

/// How the creature is told from what is around it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// Learned limb shapes, local colours, the background seen in other frames, and exact cuts.
    #[default]
    Layered,
    /// Reinert 2016, section 3.6: two global colour histograms and a blurred, thresholded volume.
    Paper,
}

/// Parameters of [`super::CostVolumeSegmenter`].
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentParams {
    /// Which method.
    pub method: Method,
    /// Longest side of the working image in pixels; the masks' edges are found at the clip's own size.
    pub working_side: u32,
    /// How often masks and models are refined in turn, at least 1.
    pub passes: usize,
    /// Nothing farther from every stroke than this share of the creature's extent is creature.
    pub reach: f32,
    /// Weight of colours in the cut.
    pub colour_weight: f32,
    /// Weight of the distance to the stroke, and of masks carried from other frames.
    pub shape_weight: f32,
    /// Cost of cutting between two pixels of equal colour.
    pub edge_weight: f32,
    /// For how many frames a mask is remembered, before and after.
    pub memory: f32,
    /// The paper's method.
    pub paper: PaperParams,
}

/// Parameters of the paper's method.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperParams {
    /// How often the bilateral filter is applied (paper: 5).
    pub filter_rounds: usize,
    /// Its standard deviation in space, in pixels of a 512 x 512 image (paper: 10).
    pub filter_space: f32,
    /// Its standard deviation in brightness, on a 0..1 scale (paper: 0.02).
    pub filter_range: f32,
    /// Histogram bins for each channel (paper: 50).
    pub bins: usize,
    /// Blur of the histograms, in bins (paper: 2).
    pub softness: f32,
    /// Blur of the volume, in pixels of a 512 x 512 image (paper: about 2).
    pub blur: f32,
    /// Creature is where its share of a colour's likelihood, blurred, is above this (paper: 0.75).
    pub threshold: f32,
    /// Distance of the background box from the strokes' bounding box, as a share of that box's longer side (the paper
    /// says "slightly offset"; it must clear the thickness of the body around its stroke).
    pub offset: f32,
}

impl Default for SegmentParams {
    fn default() -> Self {
        Self {
            method: Method::default(),
            working_side: 384,
            passes: 3,
            reach: 0.6,
            colour_weight: 1.0,
            shape_weight: 1.0,
            edge_weight: 3.0,
            memory: 4.0,
            paper: PaperParams::default(),
        }
    }
}

impl Default for PaperParams {
    fn default() -> Self {
        Self {
            filter_rounds: 5,
            filter_space: 10.0,
            filter_range: 0.02,
            bins: 50,
            softness: 2.0,
            blur: 2.0,
            threshold: 0.75,
            offset: 0.25,
        }
    }
}
