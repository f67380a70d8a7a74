//! Session jobs. Tracking a session and making its creature, with the parameters chosen in it. A job works on the
//! session as it is when the job starts; mry_session_take takes its motion in as one step of undo, whatever was edited
//! meanwhile. Results are compared by what they were made of: an edit that is undone puts nothing out of date.
//!
//! Only what is out of date is tracked: a stroke that was drawn or corrected re-does its limb, the limbs that hang on
//! it and the twin it is told from, between the key frames around it. Everything else keeps its place to the bit, and
//! the time taken is that share of the clip's. Take the motion away (mry_session_set_motion) to track all anew.

use std::path::PathBuf;
use std::sync::Arc;

use marey::motion::Motion;
use marey::pipeline::{self, PipelineOptions};
use marey::segment::{CostVolumeSegmenter, SegmentParams, Segmenter};
use marey::session::{Chosen, Document, Helpers, Incremental, Inputs, Tracked};
use marey::track::Tracker;
use marey::track::limb::{LimbParams, LimbTracker};
use marey_plugin_loader::{PluginKind, Slot};

use crate::border::{List, Out};
use crate::context::mry_context;
use crate::creature::{Creature, Origin, mry_creature};
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::job::mry_job;
use crate::limb::limb_index;
use crate::masks::MaskSet;
use crate::running::{Job, Part, Product, Work};
use crate::session::mry_session;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Frames one after another.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_frame_range {
    /// The first.
    pub first: u64,
    /// How many.
    pub count: u64,
}

/// What a session's job made for the session.
#[derive(Clone)]
pub(crate) struct ForSession {
    session: u64,
    inputs: Inputs,
    motion: Arc<Motion>,
    creature: bool,
}

impl Call<'_> {
    fn session_track_work(&self, session: mry_session) -> Outcome<Work> {
        let (clip, inputs, tracked, Chosen { track, helpers, .. }) = self.session_inputs(session)?;
        let tracker = self.session_tracker(&helpers, track)?;
        Ok(Box::new(move |progress| {
            let tracker = Incremental { tracker: &*tracker, inputs: &inputs, tracked: tracked.as_ref() };
            let motion = Arc::new(tracker.track(&clip, &inputs.rig, progress.whole())?);
            let made = ForSession { session: session.v, inputs, motion: motion.clone(), creature: false };
            Ok(Product { motion: Part::Made(motion), for_session: Part::Made(made), ..Product::default() })
        }))
    }

    unsafe fn session_creature_work(&self, session: mry_session, folder: mry_str) -> Outcome<Work> {
        // SAFETY: the string is valid, as the header asks.
        let folder = if folder.len == 0 { None } else { Some(PathBuf::from(unsafe { folder.name("folder")? })) };
        let (clip, inputs, tracked, chosen) = self.session_inputs(session)?;
        let Chosen { helpers, track, segment, creature, export, .. } = chosen;
        let tracker = self.session_tracker(&helpers, track)?;
        let segmenter = self.session_segmenter(&helpers, segment)?;
        Ok(Box::new(move |progress| {
            let tracker = Incremental { tracker: &*tracker, inputs: &inputs, tracked: tracked.as_ref() };
            let mut options = PipelineOptions::new(&tracker, &*segmenter);
            options.creature = creature;
            options.settings = serde_json::to_value(&inputs.settings).unwrap_or_default();
            let whole = progress.whole();
            let made = match &folder {
                None => pipeline::creature(&clip, &inputs.rig, &options, whole)?,
                Some(folder) => pipeline::creature_to_folder(&clip, &inputs.rig, &options, folder, &export, whole)?,
            };
            let motion = Arc::new(made.motion);
            let masks = Arc::new(MaskSet { masks: made.masks, report: made.report });
            let rig = (*inputs.rig).clone();
            let origin = Origin { clip, rig, masks: masks.clone() };
            let creature = Creature::new(Some(origin), motion.clone(), made.creature);
            let made = ForSession { session: session.v, inputs, motion: motion.clone(), creature: true };
            Ok(Product {
                motion: Part::Made(motion),
                masks: Part::Made(masks),
                creature: Part::Made(Arc::new(creature)),
                for_session: Part::Made(made),
                ..Product::default()
            })
        }))
    }

    /// The tracker that is chosen in a session: a plugin, or the built-in one.
    fn session_tracker(&self, helpers: &Helpers, params: LimbParams) -> Outcome<Arc<dyn Tracker>> {
        if helpers.tracker.is_empty() {
            return Ok(Arc::new(LimbTracker { params }));
        }
        Ok(self.session_plugin(&helpers.tracker, PluginKind::Tracker)?)
    }

    /// The segmenter that is chosen in a session: a plugin, or the built-in one.
    fn session_segmenter(&self, helpers: &Helpers, params: SegmentParams) -> Outcome<Arc<dyn Segmenter>> {
        if helpers.segmenter.is_empty() {
            return Ok(Arc::new(CostVolumeSegmenter { params }));
        }
        Ok(self.session_plugin(&helpers.segmenter, PluginKind::Segmenter)?)
    }

    fn session_plugin(&self, id: &str, kind: PluginKind) -> Outcome<Arc<Slot>> {
        let slot = self.context.plugins.slot(id, kind).map_err(|e| e.about("session"))?;
        slot.ok_or_else(|| {
            let message =
                format!("the session works with plugin {id}, which is not loaded; load it, or choose another");
            Failure::new(Code::MRY_E_PLUGIN_NOT_FOUND, "session", message)
        })
    }

    /// What a job works on: the clip, what is drawn, which fits it, what was tracked before, and what is chosen.
    fn session_inputs(
        &self,
        session: mry_session,
    ) -> Outcome<(Arc<marey::clip::Clip>, Inputs, Option<Tracked>, Chosen)> {
        self.session(session, |document| {
            let clip = document.clip(&self.context.clip_options(Default::default()))?;
            let Document { inputs, tracked, .. } = document.session.document().clone();
            let fit = ((clip.info().width, clip.info().height), clip.info().frames);
            inputs.rig.validate(Some(fit)).map_err(|e| Failure::from(e).about("session"))?;
            let chosen = inputs.settings.resolve();
            Ok((clip, inputs, tracked, chosen))
        })
    }

    fn session_take(&self, session: mry_session, job: &Job) -> Outcome<Code> {
        let keep = |made: ForSession| {
            if made.session != session.v {
                return Err(Failure::argument("job", "the job was started from another session"));
            }
            self.session_mut(session, |document| {
                let ForSession { inputs, motion, creature, .. } = made;
                if creature {
                    document.session.set_creature(motion, inputs)?;
                } else {
                    document.session.set_motion(Some(Tracked { motion, inputs }))?;
                }
                Ok(())
            })
        };
        job.take(|p| &mut p.for_session, keep)
    }
}

/// Starts tracking a session. Gives a motion.
///
/// @param context  The context.
/// @param session  The session.
/// @param out_job  The job, to be taken in by mry_session_take.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there is no clip), MRY_E_INPUT (the rig is not valid for the clip),
///         MRY_E_PLUGIN_NOT_FOUND, MRY_E_PLUGIN_DISABLED (the plugin that is chosen), what mry_clip_open returns,
///         MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context; the session may be edited and go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_start_track(
    context: *mut mry_context,
    session: mry_session,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.session_track_work(session)?;
        out.set(call.keep_job(&call.start("track", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Starts making the creature of a session: track, segment, reconstruct, and write into a folder where one is given,
/// as the export parameters say. Gives a motion, masks and a creature.
///
/// @param context  The context.
/// @param session  The session.
/// @param folder   Where to write everything, see mry_creature_write_folder; empty for nowhere.
/// @param out_job  The job, to be taken in by mry_session_take.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there is no clip), MRY_E_INPUT (the rig is not valid for the clip),
///         MRY_E_PLUGIN_NOT_FOUND, MRY_E_PLUGIN_DISABLED (the plugin that is chosen), what mry_clip_open returns,
///         MRY_E_BUSY.
/// Lifetime: until mry_job_destroy or the end of the context; the session may be edited and go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_start_creature(
    context: *mut mry_context,
    session: mry_session,
    folder: mry_str,
    out_job: *mut mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_job, "out_job")?;
        let work = call.session_creature_work(session, folder)?;
        out.set(call.keep_job(&call.start("creature", work)?)?);
        Ok(Code::MRY_OK)
    })
}

/// Takes what a job made into the session that it was started from, as one step of undo; once. The mry_job_take
/// functions give the same results to the host.
///
/// @param context  The context.
/// @param session  The session.
/// @param job      The job.
/// @param err      Detail of the job's or the call's failure, or NULL.
/// @return MRY_OK; MRY_PENDING and MRY_CANCELLED (nothing is taken), the error the job ended with, MRY_E_TAKEN,
///         MRY_E_KIND (not a session's job), MRY_E_ARGUMENT (another session's), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_take(
    context: *mut mry_context,
    session: mry_session,
    job: mry_job,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.session(session, |_| Ok(()))?;
        call.session_take(session, &*call.job(job)?)
    })
}

/// Tracks a session, takes the motion in, and returns when it is done. Work that was started before comes first.
///
/// @param context  The context.
/// @param session  The session.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; what mry_session_start_track, mry_job_wait and mry_session_take return.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_run_track(
    context: *mut mry_context,
    session: mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let work = call.session_track_work(session)?;
        let (_, job) = call.run("track", work)?;
        call.session_take(session, &job)
    })
}

/// Makes the creature of a session, takes its motion in, and returns when it is done. Work that was started before
/// comes first.
///
/// @param context       The context.
/// @param session       The session.
/// @param folder        Where to write everything, see mry_creature_write_folder; empty for nowhere.
/// @param out_creature  The creature.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; what mry_session_start_creature, mry_job_wait and mry_session_take return.
/// Lifetime: until mry_creature_destroy or the end of the context.
/// Thread: [outside-callbacks]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_run_creature(
    context: *mut mry_context,
    session: mry_session,
    folder: mry_str,
    out_creature: *mut mry_creature,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_creature, "out_creature")?;
        let work = call.session_creature_work(session, folder)?;
        let (_, job) = call.run("creature", work)?;
        call.session_take(session, &job)?;
        job.take(|p| &mut p.creature, |creature| call.keep_creature(creature).map(|id| out.set(id)))
    })
}

/// The frames in which a limb's track is out of date: never tracked, or tracked from other inputs. The key frames
/// around a change still hold. Limbs that are joined to this one may follow it.
///
/// @param context    The context.
/// @param session    The session.
/// @param limb       Its index.
/// @param ranges     Where the ranges go, rising and apart; NULL with capacity 0 to ask for their count.
/// @param capacity   Ranges at ranges.
/// @param out_count  How many there are; 0 for a limb that is up to date.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (limb), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_outdated(
    context: *mut mry_context,
    session: mry_session,
    limb: u32,
    ranges: *mut mry_frame_range,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let list = List::new(ranges, capacity, out_count, "ranges")?;
        call.session(session, |document| {
            let rig = &document.session.document().inputs.rig;
            let label = &rig.limbs[limb_index(rig, limb)?].label;
            let outdated = document.session.outdated();
            let frames = outdated.limbs.iter().find(|l| l.label == *label).map_or(&[][..], |l| &l.frames);
            let range = |r: &std::ops::Range<usize>| mry_frame_range { first: r.start as u64, count: r.len() as u64 };
            list.fill(&frames.iter().map(range).collect::<Vec<_>>())
        })
    })
}
