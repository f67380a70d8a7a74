//! Recordings of sessions. A recording is the session as it was and every gesture after that; played, it does again
//! what a person did. It is what to send along with the report of a defect, and a test of what a session comes to.

use std::path::Path;

use marey::session::Session;

use crate::border::Out;
use crate::context::mry_context;
use crate::error::{Failure, mry_error};
use crate::guard::entry;
use crate::session::mry_session;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Begins a recording of a session; one in progress ends. Gestures are recorded as they are finished, undo and redo
/// among them. Should the file meet a full disk the recording ends, which is a warning of the session, and the gesture
/// counts.
///
/// @param context  The context.
/// @param session  The session.
/// @param path     A file that does not exist.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (a gesture is in progress), MRY_E_IO (the file exists, or cannot be written),
///         MRY_E_NO_FILE (its folder does not exist), MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_start_recording(
    context: *mut mry_context,
    session: mry_session,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        call.session_mut(session, |document| Ok(document.session.start_recording(Path::new(path))?))?;
        Ok(Code::MRY_OK)
    })
}

/// Ends the recording of a session.
///
/// @param context  The context.
/// @param session  The session.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there is none in progress), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_stop_recording(
    context: *mut mry_context,
    session: mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        if call.session_mut(session, |document| Ok(document.session.stop_recording()))? {
            return Ok(Code::MRY_OK);
        }
        Err(Failure::new(Code::MRY_E_NOT_FOUND, "session", "no recording is in progress"))
    })
}

/// Plays a recording: makes a session that is kept nowhere, and does in it what was recorded. A recording that breaks
/// off is played to there, with a warning of the session.
///
/// @param context      The context.
/// @param path         The recording.
/// @param most         How many gestures to play, at most; UINT64_MAX for all.
/// @param out_session  The session. Its recovered_count says how many were played.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT (no recording, or damaged), MRY_E_LIMIT, MRY_E_IO, MRY_E_STRING,
///         MRY_E_ARGUMENT.
/// Lifetime: until mry_session_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_replay(
    context: *mut mry_context,
    path: mry_str,
    most: u64,
    out_session: *mut mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_session, "out_session")?;
        let most = usize::try_from(most).unwrap_or(usize::MAX);
        out.set(call.keep_session(Session::replay_recording(Path::new(path), most))?);
        Ok(Code::MRY_OK)
    })
}

/// A number that tells what a session holds from anything else: the same for the same clip, strokes, parameters and
/// motion, on any machine and wherever the files lie.
///
/// @param context          The context.
/// @param session          The session.
/// @param out_fingerprint  The number.
/// @param err              Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_fingerprint(
    context: *mut mry_context,
    session: mry_session,
    out_fingerprint: *mut u64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_fingerprint, "out_fingerprint")?;
        out.set(call.session(session, |document| Ok(document.session.fingerprint()))?);
        Ok(Code::MRY_OK)
    })
}
