//! Gestures. What a person does in one go, such as drawing a stroke or dragging a slider, is one gesture and one step
//! of undo, however many edits it takes. An edit outside of a gesture is one of its own. A finished gesture is on the
//! disk when the call that finishes it returns; one that cannot be written is taken back, and the call says why.

use std::ffi::c_char;

use crate::border::Text;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::session::mry_session;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Begins a gesture.
///
/// @param context  The context.
/// @param session  The session.
/// @param label    What it does, for a menu: "draw the tail".
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (one is in progress, or the session is read-only), MRY_E_STRING, MRY_E_ARGUMENT,
///         MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_begin_gesture(
    context: *mut mry_context,
    session: mry_session,
    label: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let label = label.name("label")?;
        call.session_mut(session, |document| Ok(document.session.begin_gesture(label)?))?;
        Ok(Code::MRY_OK)
    })
}

/// Ends a gesture. One that changed nothing leaves no step.
///
/// @param context  The context.
/// @param session  The session.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (none is in progress), MRY_E_IO (it is taken back), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_end_gesture(
    context: *mut mry_context,
    session: mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.session_mut(session, |document| Ok(document.session.end_gesture().map(drop)?))?;
        Ok(Code::MRY_OK)
    })
}

/// Takes the gesture in progress back.
///
/// @param context  The context.
/// @param session  The session.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (none is in progress), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_cancel_gesture(
    context: *mut mry_context,
    session: mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.session_mut(session, |document| Ok(document.session.cancel_gesture()?))?;
        Ok(Code::MRY_OK)
    })
}

fn stepped(step: Option<marey::session::Outdated>, what: &str) -> Outcome<Code> {
    let none = || Failure::new(Code::MRY_E_NOT_FOUND, "session", format!("there is nothing to {what}"));
    step.map(|_| Code::MRY_OK).ok_or_else(none)
}

/// Takes the last step back. There is no end to it while the session is open.
///
/// @param context  The context.
/// @param session  The session.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there is no step), MRY_E_INPUT (a gesture is in progress, or the session is
///         read-only), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_undo(
    context: *mut mry_context,
    session: mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| { call.session_mut(session, |document| stepped(document.session.undo()?, "undo")) })
}

/// Does the last step that was taken back again.
///
/// @param context  The context.
/// @param session  The session.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there is no step), MRY_E_INPUT (a gesture is in progress, or the session is
///         read-only), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_redo(
    context: *mut mry_context,
    session: mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| { call.session_mut(session, |document| stepped(document.session.redo()?, "redo")) })
}

fn fill_label(text: &Text, label: Option<&str>) -> Outcome<Code> {
    text.fill(label.ok_or_else(|| Failure::new(Code::MRY_E_NOT_FOUND, "session", "there is no such step"))?)
}

/// What mry_session_undo would take back, for a menu.
///
/// @param context   The context.
/// @param session   The session.
/// @param label     Where the label goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at label.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there is no step), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_undo_label(
    context: *mut mry_context,
    session: mry_session,
    label: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(label, capacity, out_size, "label")?;
        call.session(session, |document| fill_label(&text, document.session.undo_label()))
    })
}

/// What mry_session_redo would do again, for a menu.
///
/// @param context   The context.
/// @param session   The session.
/// @param label     Where the label goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at label.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there is no step), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_redo_label(
    context: *mut mry_context,
    session: mry_session,
    label: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(label, capacity, out_size, "label")?;
        call.session(session, |document| fill_label(&text, document.session.redo_label()))
    })
}
