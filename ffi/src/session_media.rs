//! Session contents. The clip, the rig and the motion of a session, whole: taken in as a step of undo, given out as
//! objects of their own that later edits leave alone.

use std::path::Path;
use std::sync::{Arc, RwLock};

use marey::clip::{Clip, ClipOptions};
use marey::job::Progress;
use marey::session::{ClipReference, Tracked};

use crate::border::Out;
use crate::clip::{mry_clip, mry_clip_options, options_in};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, entry};
use crate::motion::mry_motion;
use crate::rig::mry_rig;
use crate::session::{Document, mry_session};
use crate::status::{mry_status, mry_status_code as Code};

impl Document {
    /// The clip, opened where it is not open yet.
    pub(crate) fn clip(&mut self, options: &ClipOptions) -> Outcome<Arc<Clip>> {
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "session", "the session has no clip; choose one first");
        let reference = self.session.document().inputs.clip.clone().ok_or_else(none)?;
        match &self.clip {
            Some((of, clip)) if *of == reference => Ok(clip.clone()),
            _ => {
                let clip = Clip::open_with(&reference.path, options).map_err(|e| Failure::from(e).about("session"))?;
                // An embedded clip stays unpacked for as long as anybody reads it.
                let clip = match self.session.unpacked_media() {
                    Some(unpacked) => Arc::new(clip.keeping(unpacked)),
                    None => Arc::new(clip),
                };
                self.clip = Some((reference, clip.clone()));
                Ok(clip)
            }
        }
    }
}

impl Call<'_> {
    fn set_clip(&self, session: mry_session, clip: mry_clip) -> Outcome<Code> {
        let clip = if clip.v == 0 { None } else { Some(self.clip(clip, "clip")?) };
        let refer = |clip: &Arc<Clip>| ClipReference::new(Path::new(clip.name()), clip.info(), Progress::new().whole());
        let reference = clip.as_ref().map(refer).transpose().map_err(|e| Failure::from(e).about("clip"))?;
        self.session_mut(session, |document| {
            document.session.set_clip(reference)?;
            document.clip = document.session.document().inputs.clip.clone().zip(clip);
            Ok(Code::MRY_OK)
        })
    }
}

/// Chooses the clip of a session, by reference: the session keeps its path, and reads all of it to know it again. As
/// long as nothing is drawn, the rig takes its size.
///
/// @param context  The context.
/// @param session  The session.
/// @param clip     A clip that was opened from a file or folder; {0} for none.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT (its path is not UTF-8, or the session is read-only), MRY_E_IO,
///         MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_clip(
    context: *mut mry_context,
    session: mry_session,
    clip: mry_clip,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        // A session that is none is told before a clip that is none.
        call.session(session, |_| Ok(()))?;
        call.set_clip(session, clip)
    })
}

/// The clip of a session, opened where it is not open yet.
///
/// @param context   The context.
/// @param session   The session.
/// @param options   How to open it; NULL for the defaults. Left out of account where it is open already.
/// @param out_clip  The clip.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there is none), what mry_clip_open returns, MRY_E_BUSY.
/// Lifetime: until mry_clip_close or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_clip(
    context: *mut mry_context,
    session: mry_session,
    options: *const mry_clip_options,
    out_clip: *mut mry_clip,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_clip, "out_clip")?;
        let options = options_in(options, call.context)?;
        let clip = call.session(session, |document| document.clip(&options))?;
        out.set(call.keep_clip(clip)?);
        Ok(Code::MRY_OK)
    })
}

/// Lets further saves put the clip and the painted masks into the session's file, so that the one file is all there is
/// to carry about; or refer to them, which is how a session begins. Every save then writes them anew. While such a
/// session is open they lie unpacked in a hidden folder beside it.
///
/// @param context   The context.
/// @param session   The session.
/// @param embedded  1 to embed, 0 to refer.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (embedded), MRY_E_INPUT (the session is read-only, or it is all that has them),
///         MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_embedded(
    context: *mut mry_context,
    session: mry_session,
    embedded: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        if embedded > 1 {
            return Err(Failure::argument("embedded", format!("embedded is {embedded}; give 0 or 1")));
        }
        call.session_mut(session, |document| Ok(document.session.set_embedded(embedded == 1)?))?;
        Ok(Code::MRY_OK)
    })
}

/// Replaces everything that is drawn in a session.
///
/// @param context  The context.
/// @param session  The session.
/// @param rig      The rig, which is copied; it may be incomplete.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the rig is not sound, or the session is read-only), MRY_E_LIMIT, MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_rig(
    context: *mut mry_context,
    session: mry_session,
    rig: mry_rig,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.session(session, |_| Ok(()))?;
        let rig = call.rig(rig, |rig| Ok(rig.clone()))?;
        call.session_mut(session, |document| Ok(document.session.set_rig(rig).map(|_| Code::MRY_OK)?))
    })
}

/// A copy of what is drawn in a session.
///
/// @param context  The context.
/// @param session  The session.
/// @param out_rig  The rig.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUSY.
/// Lifetime: until mry_rig_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_rig(
    context: *mut mry_context,
    session: mry_session,
    out_rig: *mut mry_rig,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_rig, "out_rig")?;
        let rig = call.session(session, |document| Ok((*document.session.document().inputs.rig).clone()))?;
        out.set(mry_rig { v: call.context.rigs.insert(RwLock::new(rig))? });
        Ok(Code::MRY_OK)
    })
}

/// Gives a session a motion from elsewhere, as if it had been tracked from what is drawn now; or takes its motion
/// away.
///
/// @param context  The context.
/// @param session  The session.
/// @param motion   The motion, with one track a limb in the rig's order; {0} for none.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the motion is not of this rig, or the session is read-only), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_motion(
    context: *mut mry_context,
    session: mry_session,
    motion: mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.session(session, |_| Ok(()))?;
        let motion = if motion.v == 0 { None } else { Some(call.motion(motion)?) };
        call.session_mut(session, |document| {
            let inputs = document.session.document().inputs.clone();
            document.session.set_motion(motion.map(|motion| Tracked { motion, inputs }))?;
            Ok(Code::MRY_OK)
        })
    })
}

/// The motion of a session, up to date or not.
///
/// @param context     The context.
/// @param session     The session.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there is none), MRY_E_BUSY.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_motion(
    context: *mut mry_context,
    session: mry_session,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_motion, "out_motion")?;
        let motion = call.session(session, |document| {
            let none = || Failure::new(Code::MRY_E_NOT_FOUND, "session", "nothing is tracked yet");
            Ok(document.session.document().tracked.as_ref().ok_or_else(none)?.motion.clone())
        })?;
        out.set(call.keep_motion(motion)?);
        Ok(Code::MRY_OK)
    })
}
