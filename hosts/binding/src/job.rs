//! Jobs: long work, started, watched, cancelled.

use std::time::Duration;

use marey_ffi::{mry_job, mry_status_code};

use crate::{Context, Creature, Error, Masks, Motion, Result, sys};

/// How to track. Empty strings are the best there is.
#[derive(Clone, Copy, Debug, Default)]
pub struct TrackOptions<'a> {
    /// The tracker's id.
    pub tracker: &'a str,
}

/// How to segment. Empty strings are the best there is.
#[derive(Clone, Copy, Debug, Default)]
pub struct SegmentOptions<'a> {
    /// The rig's limbs, where they are tracked already.
    pub motion: Option<&'a Motion>,
    /// The tracker's id.
    pub tracker: &'a str,
    /// The segmenter's id.
    pub segmenter: &'a str,
    /// Where to write the masks; empty for nowhere.
    pub folder: &'a str,
}

/// What covers a creature's limbs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CreatureSurface {
    /// What is usual: the skin.
    #[default]
    Usual,
    /// One connected skin over all limbs.
    Skin,
    /// A closed tube around each limb, with a texture each.
    Tubes,
}

/// How to make a creature. Empty strings are the best there is.
#[derive(Clone, Copy, Debug, Default)]
pub struct CreatureOptions<'a> {
    /// The tracker's id.
    pub tracker: &'a str,
    /// The segmenter's id.
    pub segmenter: &'a str,
    /// Where to write everything; empty for nowhere.
    pub folder: &'a str,
    /// With a folder, also a mesh for each frame.
    pub write_obj: bool,
    /// How deep limbs are for their width: `body=0.8,tail=1.2`; empty for what is usual.
    pub depths: &'a str,
    /// How far limbs of a pair stand apart, times what is usual; 0 for 1.
    pub spread: f32,
    /// What covers the limbs.
    pub surface: CreatureSurface,
}

/// Long work. Dropped before its end it is cancelled.
#[derive(Debug)]
pub struct Job {
    pub(crate) id: mry_job,
    pub(crate) context: Context,
}

/// How a job is doing.
#[derive(Clone, Debug, PartialEq)]
pub struct JobState {
    /// Whether it has ended, well or not.
    pub ended: bool,
    /// The share that is done, 0..=1.
    pub fraction: f64,
    /// What is being done.
    pub stage: String,
    /// The share of that stage that is done, 0..=1.
    pub stage_fraction: f64,
    /// Rises whenever anything else here has changed.
    pub revision: u64,
}

impl Job {
    /// How it is doing. Never waits.
    pub fn poll(&self) -> Result<JobState> {
        let state = sys::job_poll(&self.context.0, self.id)?;
        Ok(JobState {
            ended: state.status != mry_status_code::MRY_PENDING as i32,
            fraction: state.fraction,
            stage: sys::text(&state.stage),
            stage_fraction: state.stage_fraction,
            revision: state.revision,
        })
    }

    /// Waits for its end, for ever or at most so long. True when it is done, false when the time is over.
    ///
    /// # Errors
    /// What the job failed with, a cancel too.
    pub fn wait(&self, timeout: Option<Duration>) -> Result<bool> {
        let timeout = timeout.map_or(u64::MAX, |t| u64::try_from(t.as_nanos()).unwrap_or(u64::MAX - 1));
        match sys::job_wait(&self.context.0, self.id, timeout)? {
            code if code == mry_status_code::MRY_OK as i32 => Ok(true),
            code if code == mry_status_code::MRY_PENDING as i32 => Ok(false),
            code => Err(Error::new(code, "cancelled".into(), String::new())),
        }
    }

    /// Asks it to stop.
    pub fn cancel(&self) -> Result<()> {
        sys::job_cancel(&self.context.0, self.id)
    }

    /// Takes the motion that it made; once.
    pub fn take_motion(&self) -> Result<Motion> {
        Ok(Motion { id: sys::take_motion(&self.context.0, self.id)?, context: self.context.clone() })
    }

    /// Takes the masks that it made; once.
    pub fn take_masks(&self) -> Result<Masks> {
        Ok(Masks { id: sys::take_masks(&self.context.0, self.id)?, context: self.context.clone() })
    }

    /// Takes the creature that it made; once.
    pub fn take_creature(&self) -> Result<Creature> {
        Ok(Creature { id: sys::take_creature(&self.context.0, self.id)?, context: self.context.clone() })
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        sys::job_destroy(&self.context.0, self.id);
    }
}
