//! What an author implements.

use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::info::Info;
use crate::job::Job;
use crate::masks::MaskSink;
use crate::mesh::{Handle, Mesh};
use crate::motion::Motion;
use crate::parameter::Parameter;
use crate::point::Point;
use crate::rig::Rig;
use crate::tracks::Tracks;
use crate::values::Values;

/// What every plugin says of itself, and how it is made. An instance is worked by one thread at a time.
pub trait Plugin: Sized + Send + 'static {
    /// What it is called.
    const INFO: Info;
    /// What a person can choose about it.
    const PARAMETERS: &'static [Parameter] = &[];
    /// Of the bytes that [`Self::save`] gives; raise it when they change.
    const STATE_VERSION: u32 = 0;

    /// Makes an instance.
    ///
    /// # Errors
    /// What the values ask for cannot be had.
    fn create(values: &Values<'_>) -> Result<Self>;

    /// What the instance has learnt and would miss when a new build of the plugin takes its place; nothing by default.
    ///
    /// # Errors
    /// It cannot be saved now.
    fn save(&self) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }

    /// Takes in what a build with [`Self::STATE_VERSION`] `version` saved.
    ///
    /// # Errors
    /// The version or the bytes cannot be read; the host then goes on with what [`Self::create`] made.
    fn load(&mut self, version: u32, state: &[u8]) -> Result<()> {
        if state.is_empty() {
            return Ok(());
        }
        Err(Error::unsupported(format!("the plugin does not read state of version {version}")))
    }
}

/// Turns key-frame strokes into strokes on every frame.
pub trait Tracker: Plugin {
    /// Follows every limb of `rig` through `clip`.
    ///
    /// # Errors
    /// What was drawn cannot be followed, a frame cannot be read, or the host asked to stop.
    fn track(&mut self, clip: &Clip<'_>, rig: &Rig<'_>, job: &Job<'_>) -> Result<Tracks>;
}

/// Cuts the creature out of every frame.
pub trait Segmenter: Plugin {
    /// Gives a mask for every frame to `masks`. `motion` is the rig's limbs, tracked.
    ///
    /// # Errors
    /// A frame cannot be read, or the host asked to stop.
    fn segment(
        &mut self,
        clip: &Clip<'_>,
        rig: &Rig<'_>,
        motion: &Motion<'_>,
        masks: &MaskSink<'_>,
        job: &Job<'_>,
    ) -> Result<()>;
}

/// Moves a mesh by handles.
pub trait Deformer: Plugin {
    /// A mesh bound to its handles.
    type Bound: Deformation;

    /// Prepares all that does not change while the handles move. `handles` are where they lie on the mesh at rest.
    ///
    /// # Errors
    /// A mesh or a handle that cannot be used, or the host asked to stop.
    fn bind(&mut self, mesh: &Mesh<'_>, handles: &[Handle], job: &Job<'_>) -> Result<Self::Bound>;
}

/// A mesh bound to its handles.
pub trait Deformation: Send + 'static {
    /// Moves the mesh so that every handle is where `targets` say, of the same kinds and in the same order as they
    /// were bound. `points` hold the shape to start from, and are given the new one.
    ///
    /// # Errors
    /// Targets that cannot be met, or the host asked to stop.
    fn solve(&mut self, targets: &[Handle], points: &mut [Point], job: &Job<'_>) -> Result<()>;
}
