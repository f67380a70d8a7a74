//! The clip as the tracker sees it: reduced pictures in Lab and the flow between neighbours, for all frames that are
//! looked at, at once.

use glam::{Affine2, Vec2};
use rayon::prelude::*;

use super::camera::camera_motion;
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::raster::{Grid, Planes, pyramid};
use crate::track::flow::{FlowField, Pyramid};

/// Pixels of all frames together that are kept; longer clips are tracked on smaller pictures. A pixel takes 5 bytes.
const PIXEL_BUDGET: usize = 100_000_000;
/// Working pictures never get smaller than this on their long side, whatever the budget says.
const LEAST_SIDE: u32 = 320;

/// CIE Lab in a byte a channel: lightness over 0..=255, chroma doubled around 128 (it saturates beyond +-63, where
/// only the purest paints lie).
#[derive(Clone, Debug)]
pub(in crate::track) struct LabImage {
    pixels: Grid<[u8; 3]>,
}

impl LabImage {
    pub(in crate::track) fn new(planes: &Planes) -> Self {
        // Rounded; the cast keeps within the range.
        let byte = |v: f32| (v + 0.5) as u8;
        let [l, a, b] = [0, 1, 2].map(|c| planes.channel(c).data());
        let pixels = l
            .iter()
            .zip(a)
            .zip(b)
            .map(|((l, a), b)| [byte(l * 255.0), byte(a * 200.0 + 128.0), byte(b * 200.0 + 128.0)])
            .collect();
        Self { pixels: Grid::from_vec(planes.width(), planes.height(), pixels) }
    }

    /// The colour at `p`, or nothing outside the picture.
    #[inline]
    pub(super) fn at(&self, p: Vec2) -> Option<[u8; 3]> {
        let (w, h) = (self.pixels.width(), self.pixels.height());
        if p.x >= 0.0 && p.y >= 0.0 && p.x < w as f32 && p.y < h as f32 {
            Some(self.pixels.get(p.x as usize, p.y as usize))
        } else {
            None
        }
    }

    /// All of them.
    pub(super) fn pixels(&self) -> &Grid<[u8; 3]> {
        &self.pixels
    }

    /// Columns.
    pub(super) fn width(&self) -> usize {
        self.pixels.width()
    }

    /// Rows.
    pub(super) fn height(&self) -> usize {
        self.pixels.height()
    }

    /// The picture of a frame that is not looked at: all of it is outside.
    fn blank() -> Self {
        Self { pixels: Grid::from_vec(0, 0, Vec::new()) }
    }
}

/// What of a clip is looked at, frame by frame.
#[derive(Clone, Debug)]
pub(super) struct LookedAt {
    /// The frames whose pictures are.
    pub(super) pictures: Vec<bool>,
    /// Those whose motion is; it is known between two neighbours of them.
    pub(super) motion: Vec<bool>,
}

impl LookedAt {
    /// All of a clip of so many frames.
    pub(super) fn all(frames: usize) -> Self {
        Self { pictures: vec![true; frames], motion: vec![true; frames] }
    }
}

/// Working pictures and flows of a clip.
#[derive(Debug)]
pub(in crate::track) struct Footage {
    /// Working pixels for one clip pixel.
    pub(super) scale: f32,
    /// Columns and rows of the working pictures.
    pub(super) size: (u32, u32),
    /// Every frame; blank where it is not looked at.
    pub(super) lab: Vec<LabImage>,
    /// From every frame but the last to the next, and back.
    flows: Vec<Option<(FlowField, FlowField)>>,
    /// What the camera did from every frame but the last to the next; nothing where nobody looked.
    pub(in crate::track) camera: Vec<Affine2>,
}

impl Footage {
    /// Of pictures that are all of one size, and the flows from every one but the last to the next, and back.
    pub(in crate::track) fn new(size: (u32, u32), lab: Vec<LabImage>, flows: Vec<(FlowField, FlowField)>) -> Self {
        let camera = flows.par_iter().map(|(forward, backward)| camera_motion(forward, backward)).collect();
        Self { scale: 1.0, size, lab, flows: flows.into_iter().map(Some).collect(), camera }
    }

    /// Reads the clip at a long side of `working_side` pixels, less where the clip is long.
    pub(super) fn read(clip: &Clip, working_side: u32, looked_at: &LookedAt, stage: Stage<'_>) -> Result<Self> {
        let info = clip.info();
        let long = f64::from(info.width.max(info.height));
        let area = f64::from(info.width) * f64::from(info.height);
        let affordable = (PIXEL_BUDGET as f64 / info.frames.max(1) as f64 / area).sqrt() * long;
        let side = working_side.min((affordable as u32).max(LEAST_SIDE));
        let (width, height) = pyramid::fitted(info.width, info.height, side);
        let scale = width as f32 / info.width as f32;

        let (reading, flowing) = (stage.part(0.0, 0.35), stage.part(0.35, 1.0));
        let frames: Vec<(LabImage, Option<Pyramid>)> = (0..info.frames)
            .into_par_iter()
            .map(|f| {
                reading.at(f as f64 / info.frames as f64)?;
                if !looked_at.pictures[f] {
                    return Ok((LabImage::blank(), None));
                }
                let picture = clip.frame(f)?;
                let planes = Planes::lab(&pyramid::shrunk(&picture.rgb, width, height));
                let pyramid = looked_at.motion[f].then(|| Pyramid::of(&planes));
                Ok((LabImage::new(&planes), pyramid))
            })
            .collect::<Result<_>>()?;
        let pairs = frames.len().saturating_sub(1);
        let flows: Vec<Option<(FlowField, FlowField)>> = (0..pairs)
            .into_par_iter()
            .map(|t| {
                flowing.at(t as f64 / pairs as f64)?;
                let Some((a, b)) = frames[t].1.as_ref().zip(frames[t + 1].1.as_ref()) else { return Ok(None) };
                let forward = FlowField::between(a, b);
                flowing.at(t as f64 / pairs as f64)?;
                Ok(Some((forward, FlowField::between(b, a))))
            })
            .collect::<Result<_>>()?;
        let lab = frames.into_iter().map(|(lab, _)| lab).collect();
        let camera = flows.par_iter().map(|flows| match flows {
            Some((forward, backward)) => camera_motion(forward, backward),
            None => Affine2::IDENTITY,
        });
        let camera = camera.collect();
        Ok(Self { scale, size: (width, height), lab, flows, camera })
    }

    /// Where the place of the ground that is at `place` on frame `at` lies in every frame.
    pub(super) fn on_the_ground(&self, place: Vec2, at: usize) -> Vec<Vec2> {
        let mut path = vec![place; self.frames()];
        for f in at + 1..path.len() {
            path[f] = self.camera[f - 1].transform_point2(path[f - 1]);
        }
        for f in (0..at.min(path.len())).rev() {
            path[f] = self.camera[f].inverse().transform_point2(path[f + 1]);
        }
        path
    }

    /// How many frames there are.
    pub(super) fn frames(&self) -> usize {
        self.lab.len()
    }

    /// The flow from frame `from` to its neighbour `to`, and the flow back; nothing when they are no neighbours, or are
    /// not looked at.
    pub(in crate::track) fn flows(&self, from: usize, to: usize) -> Option<(&FlowField, &FlowField)> {
        let (forward, backward) = self.flows.get(from.min(to))?.as_ref()?;
        if to == from + 1 {
            Some((forward, backward))
        } else if from == to + 1 {
            Some((backward, forward))
        } else {
            None
        }
    }
}
