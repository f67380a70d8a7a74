//! Where both doors lead: an author's object without its type, and the host without its language.

use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::masks::MaskSink;
use crate::mesh::{Handle, Mesh};
use crate::motion::Motion;
use crate::point::Point;
use crate::raw;
use crate::rig::Rig;
use crate::tracks::Tracks;
use crate::traits::{Deformation, Deformer, Segmenter, Tracker};
use crate::values::Values;

/// What a door asks of the host while a piece of work lasts. The functions are those of `mry_plugin_job`.
pub trait Host: Sync {
    /// Whether to go on.
    fn progress(&self, fraction: f64, stage: Option<&str>) -> bool;
    /// Lends a frame.
    ///
    /// # Errors
    /// As `get_frame`.
    fn frame(&self, index: u64) -> Result<raw::Frame>;
    /// Gives it back.
    fn release(&self, frame: &mut raw::Frame);
    /// A limb on a frame. The three lists are of one length.
    ///
    /// # Errors
    /// As `put_stroke`.
    fn put_stroke(&self, limb: u32, frame: u64, points: &[Point], visible: &[u8], confidence: &[f32]) -> Result<()>;
    /// A mask. `pixels` holds all rows.
    ///
    /// # Errors
    /// As `put_mask`.
    fn put_mask(&self, frame: u64, pixels: &[u8], width: u32, height: u32, stride: usize) -> Result<()>;
}

/// What to work on.
pub(crate) struct Work<'a> {
    pub(crate) clip: Clip<'a>,
    pub(crate) rig: Rig<'a>,
}

/// An author's object.
pub(crate) trait Object: Send {
    fn track(&mut self, _work: &Work<'_>, _host: &dyn Host) -> Result<()> {
        Err(another())
    }
    fn segment(&mut self, _work: &Work<'_>, _motion: &Motion<'_>, _host: &dyn Host) -> Result<()> {
        Err(another())
    }
    fn bind(&mut self, _mesh: &Mesh<'_>, _handles: &[Handle], _host: &dyn Host) -> Result<Box<dyn Deformation>> {
        Err(another())
    }
    fn save(&self) -> Result<Vec<u8>>;
    fn load(&mut self, version: u32, state: &[u8]) -> Result<()>;
}

fn another() -> Error {
    Error::unsupported("the plugin is of another kind")
}

struct TrackerObject<T>(T);
struct SegmenterObject<T>(T);
struct DeformerObject<T>(T);

macro_rules! state {
    () => {
        fn save(&self) -> Result<Vec<u8>> {
            self.0.save()
        }
        fn load(&mut self, version: u32, state: &[u8]) -> Result<()> {
            self.0.load(version, state)
        }
    };
}

impl<T: Tracker> Object for TrackerObject<T> {
    fn track(&mut self, work: &Work<'_>, host: &dyn Host) -> Result<()> {
        let tracks = self.0.track(&work.clip, &work.rig, &Job::new(host))?;
        put(&tracks, &work.clip, &work.rig, host)
    }
    state!();
}

impl<T: Segmenter> Object for SegmenterObject<T> {
    fn segment(&mut self, work: &Work<'_>, motion: &Motion<'_>, host: &dyn Host) -> Result<()> {
        self.0.segment(&work.clip, &work.rig, motion, &MaskSink::new(host), &Job::new(host))
    }
    state!();
}

impl<T: Deformer> Object for DeformerObject<T> {
    fn bind(&mut self, mesh: &Mesh<'_>, handles: &[Handle], host: &dyn Host) -> Result<Box<dyn Deformation>> {
        Ok(Box::new(self.0.bind(mesh, handles, &Job::new(host))?))
    }
    state!();
}

pub(crate) fn create_tracker<T: Tracker>(values: &Values<'_>) -> Result<Box<dyn Object>> {
    Ok(Box::new(TrackerObject(T::create(values)?)))
}

pub(crate) fn create_segmenter<T: Segmenter>(values: &Values<'_>) -> Result<Box<dyn Object>> {
    Ok(Box::new(SegmenterObject(T::create(values)?)))
}

pub(crate) fn create_deformer<T: Deformer>(values: &Values<'_>) -> Result<Box<dyn Object>> {
    Ok(Box::new(DeformerObject(T::create(values)?)))
}

/// Hands a tracker's result to the host, which judges what is in it; only what cannot be handed over is refused here.
pub(crate) fn put(tracks: &Tracks, clip: &Clip<'_>, rig: &Rig<'_>, host: &dyn Host) -> Result<()> {
    if tracks.limbs.len() != rig.limbs.len() {
        let message = format!("the tracker gave {} limbs, and the rig has {}", tracks.limbs.len(), rig.limbs.len());
        return Err(Error::failed(message));
    }
    for (l, (track, limb)) in tracks.limbs.iter().zip(&rig.limbs).enumerate() {
        let needed = clip.frames().saturating_mul(track.points);
        let counts = [track.places.len(), track.visible.len(), track.confidence.len()];
        if counts.iter().any(|c| *c != needed) {
            let message = format!("limb `{}`: the tracker gave {counts:?} entries, not {needed} of each", limb.label);
            return Err(Error::failed(message));
        }
        for frame in 0..clip.frames() {
            let part = frame * track.points..(frame + 1) * track.points;
            let (visible, confidence) = (&track.visible[part.clone()], &track.confidence[part.clone()]);
            host.put_stroke(l as u32, frame as u64, &track.places[part], visible, confidence)?;
        }
    }
    Ok(())
}
