//! Sessions. A session is the document that a host edits: a clip by reference, the rig drawn on it, chosen parameters,
//! and the motion that was tracked. It undoes without an end, and it is safe: an edit of a session with a file is on
//! the disk before the call returns, and a crash loses at most the gesture in progress.
//!
//! A session file names its clip by a path relative to it, and tells when another clip lies there. Damage to the file
//! costs what it touches; mry_session_get_warning says what that is. One program at a time edits a session.

use std::ffi::c_char;
use std::path::Path;
use std::sync::{Arc, Mutex};

use marey::clip::Clip;
use marey::job::Progress;
use marey::session::{Access, ClipReference, Session};

use crate::border::{self, Out, OutStruct, Text, Versioned};
use crate::context::{MRY_LOG_WARNING, mry_context};
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::Table;

pub(crate) type SessionTable = Table<Mutex<Document>>;

/// A session, and what the library keeps beside it.
#[derive(Debug, Default)]
pub(crate) struct Document {
    pub(crate) session: Session,
    /// The clip as it was last opened, and for which reference.
    pub(crate) clip: Option<(Arc<ClipReference>, Arc<Clip>)>,
    /// How many calls may have changed it.
    revision: u64,
}

/// A session.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_session {
    /// The id; 0 is no session.
    pub v: u64,
}

/// Access to a session file: to edit it; no other program may.
pub const MRY_ACCESS_EDIT: i32 = 0;
/// Access to a session file: to read it, whoever edits it.
pub const MRY_ACCESS_READ_ONLY: i32 = 1;

/// How a session is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_session_state {
    /// sizeof(mry_session_state).
    pub struct_size: u32,
    /// 1 when the file lacks anything that the session has.
    pub modified: u32,
    /// 1 when it can only be read.
    pub read_only: u32,
    /// 1 when the user never gave it a name.
    pub untitled: u32,
    /// 1 while a gesture is in progress.
    pub in_gesture: u32,
    /// 1 when there is a step to undo.
    pub can_undo: u32,
    /// 1 when there is a step to redo.
    pub can_redo: u32,
    /// 1 when there is a clip.
    pub has_clip: u32,
    /// 1 when there is a motion.
    pub has_motion: u32,
    /// 1 when a limb was never tracked, or was tracked from other inputs; mry_session_get_outdated has the frames.
    pub motion_outdated: u32,
    /// 1 when no creature was made since the session was opened, or it was made from other inputs.
    pub creature_outdated: u32,
    /// How many warnings mry_session_get_warning has.
    pub warning_count: u32,
    /// How many gestures that were never saved opening it brought back.
    pub recovered_count: u64,
    /// How many gestures were finished since the session was made; undo and redo are gestures too.
    pub gesture_count: u64,
    /// Rises with every change, those of a gesture in progress included.
    pub revision: u64,
    /// 1 when a save puts the clip and the painted masks into the file, see mry_session_set_embedded.
    pub embedded: u32,
    /// 1 while a recording is in progress.
    pub recording: u32,
}

// SAFETY: repr(C), starts with its u32 size, and holds integers only.
unsafe impl Versioned for mry_session_state {
    const FIRST_SIZE: usize = 72;
}
const _: () = assert!(size_of::<mry_session_state>() == 80);

impl Call<'_> {
    /// Changes a session, unless another thread is at it.
    pub(crate) fn session_mut<T>(
        &self,
        session: mry_session,
        change: impl FnOnce(&mut Document) -> Outcome<T>,
    ) -> Outcome<T> {
        self.session(session, |document| {
            let answer = change(document)?;
            document.revision += 1;
            Ok(answer)
        })
    }

    /// Reads a session, unless another thread is at it.
    pub(crate) fn session<T>(
        &self,
        session: mry_session,
        read: impl FnOnce(&mut Document) -> Outcome<T>,
    ) -> Outcome<T> {
        let slot = self.get(&self.context.sessions, session.v, "session")?;
        let mut document = slot.value.try_lock().map_err(|e| Failure::locked(&e, "session", "using"))?;
        read(&mut document)
    }

    pub(crate) fn keep_session(&self, session: marey::Result<Session>) -> Outcome<mry_session> {
        let session = session.map_err(|e| Failure::from(e).about("path"))?;
        for warning in session.warnings() {
            self.context.log(MRY_LOG_WARNING, warning);
        }
        let document = Document { session, ..Document::default() };
        Ok(mry_session { v: self.context.sessions.insert(Mutex::new(document))? })
    }
}

/// Fills in a session state with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param state  Where to write; NULL does nothing.
/// @param size   sizeof(mry_session_state) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_state_init(state: *mut mry_session_state, size: u32) {
    // SAFETY: the caller owns `size` bytes at `state`, or passes NULL.
    unsafe { border::init(state.cast(), size) }
}

/// Creates an empty session.
///
/// @param context      The context.
/// @param path         A new file for it; empty to keep it in memory only until mry_session_save_as.
/// @param out_session  The session.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (the file exists, or another program edits it), MRY_E_NO_FILE, MRY_E_IO, MRY_E_STRING.
/// Lifetime: until mry_session_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_create(
    context: *mut mry_context,
    path: mry_str,
    out_session: *mut mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = if path.len == 0 { None } else { Some(path.name("path")?) };
        let out = Out::new(out_session, "out_session")?;
        let session = path.map_or_else(|| Ok(Session::new()), |path| Session::create(path.as_ref()));
        out.set(call.keep_session(session)?);
        Ok(Code::MRY_OK)
    })
}

/// Creates an empty session that the user has not named yet, in a folder of the host's, so that a crash does not lose
/// it. mry_session_save_as moves it to its name, mry_session_discard removes it.
///
/// @param context      The context.
/// @param folder       Where it is kept until then; it must exist.
/// @param out_session  The session.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_IO, MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_session_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_create_untitled(
    context: *mut mry_context,
    folder: mry_str,
    out_session: *mut mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let folder = folder.name("folder")?;
        let out = Out::new(out_session, "out_session")?;
        out.set(call.keep_session(Session::create_untitled(folder.as_ref()))?);
        Ok(Code::MRY_OK)
    })
}

/// One of the sessions without a name that a crash left in a folder: offer them to the user, then open them or remove
/// the files. Those that a program is editing are left out.
///
/// @param context   The context.
/// @param folder    The folder that mry_session_create_untitled was given.
/// @param index     Which, counted from 0.
/// @param path      Where its path goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at path.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there are no more), MRY_E_BUFFER_TOO_SMALL, MRY_E_NO_FILE, MRY_E_IO, MRY_E_STRING,
///         MRY_E_ARGUMENT.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_find_left(
    context: *mut mry_context,
    folder: mry_str,
    index: u32,
    path: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |_call| {
        let folder = folder.name("folder")?;
        let text = Text::new(path, capacity, out_size, "path")?;
        let left = Session::left_in(folder.as_ref()).map_err(|e| Failure::from(e).about("folder"))?;
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "index", format!("there are {} sessions", left.len()));
        text.fill(&left.get(index as usize).ok_or_else(none)?.to_string_lossy())
    })
}

/// Opens a session file, with every gesture that was finished since its last save. Reads all of the clip that it
/// refers to, to tell whether it is still the same. Warnings say what was damaged, lost or not found.
///
/// @param context      The context.
/// @param path         The file.
/// @param access       MRY_ACCESS_EDIT, ...
/// @param out_session  The session.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_INPUT (no session, of a newer version, or edited by another program),
///         MRY_E_LIMIT, MRY_E_IO, MRY_E_STRING, MRY_E_ARGUMENT.
/// Lifetime: until mry_session_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_open(
    context: *mut mry_context,
    path: mry_str,
    access: i32,
    out_session: *mut mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_session, "out_session")?;
        let access = match access {
            MRY_ACCESS_EDIT => Access::Edit,
            MRY_ACCESS_READ_ONLY => Access::ReadOnly,
            _ => return Err(Failure::argument("access", format!("access is {access}, which is no MRY_ACCESS"))),
        };
        out.set(call.keep_session(Session::open(Path::new(path), access, Progress::new().whole()))?);
        Ok(Code::MRY_OK)
    })
}

/// Closes a session. What was not saved stays in its journal and is there when the file is opened again; a gesture in
/// progress is gone.
///
/// @param context  The context.
/// @param session  The session; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_destroy(context: *mut mry_context, session: mry_session) -> mry_status {
    ending!(context, |call| {
        if session.v != 0 {
            call.context.sessions.remove(session.v, "session")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// Drops what was not saved: the file is as it was saved last; of a session without a name nothing stays. The session
/// is then empty, without a file, and still to be destroyed.
///
/// @param context  The context.
/// @param session  The session.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_discard(
    context: *mut mry_context,
    session: mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.session_mut(session, |document| {
            document.clip = None;
            Ok(std::mem::replace(&mut document.session, Session::new()).discard()?)
        })?;
        Ok(Code::MRY_OK)
    })
}

/// Saves a session to its file, whole or not at all; it is on the disk when the call returns.
///
/// @param context  The context.
/// @param session  The session.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (it has no file, is read-only, or a gesture is in progress), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_save(
    context: *mut mry_context,
    session: mry_session,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        call.session_mut(session, |document| Ok(document.session.save()?))?;
        Ok(Code::MRY_OK)
    })
}

/// Saves a session under another name, over what is there, and goes on with that file. The old file is as it was saved
/// last; that of a session without a name is gone.
///
/// @param context  The context.
/// @param session  The session.
/// @param path     The file, in a folder that exists.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (another program edits that file, or a gesture is in progress), MRY_E_NO_FILE, MRY_E_IO,
///         MRY_E_STRING, MRY_E_ARGUMENT, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_save_as(
    context: *mut mry_context,
    session: mry_session,
    path: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        call.session_mut(session, |document| {
            document.session.save_as(path.as_ref()).map_err(|e| Failure::from(e).about("path"))
        })?;
        Ok(Code::MRY_OK)
    })
}

/// How a session is.
///
/// @param context    The context.
/// @param session    The session.
/// @param out_state  The answer; its struct_size must be set.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_state(
    context: *mut mry_context,
    session: mry_session,
    out_state: *mut mry_session_state,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_state, "out_state")?;
        call.session(session, |document| {
            let Document { session, revision, .. } = document;
            let outdated = session.outdated();
            out.set(&mry_session_state {
                struct_size: 0,
                modified: session.is_modified().into(),
                read_only: session.is_read_only().into(),
                untitled: session.is_untitled().into(),
                in_gesture: session.in_gesture().into(),
                can_undo: session.undo_label().is_some().into(),
                can_redo: session.redo_label().is_some().into(),
                has_clip: session.document().inputs.clip.is_some().into(),
                has_motion: session.document().tracked.is_some().into(),
                motion_outdated: (!outdated.limbs.is_empty()).into(),
                creature_outdated: outdated.creature.into(),
                warning_count: session.warnings().len() as u32,
                recovered_count: session.replayed() as u64,
                gesture_count: session.gestures(),
                revision: *revision,
                embedded: session.is_embedded().into(),
                recording: session.is_recording().into(),
            });
            Ok(Code::MRY_OK)
        })
    })
}

/// Where a session is kept.
///
/// @param context   The context.
/// @param session   The session.
/// @param path      Where the path goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at path.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (it is kept in memory only), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_path(
    context: *mut mry_context,
    session: mry_session,
    path: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(path, capacity, out_size, "path")?;
        call.session(session, |document| {
            let none = || Failure::new(Code::MRY_E_NOT_FOUND, "session", "the session has no file");
            text.fill(&document.session.path().ok_or_else(none)?.to_string_lossy())
        })
    })
}

/// One thing that opening the session found damaged, lost or not there, such as its clip.
///
/// @param context   The context.
/// @param session   The session.
/// @param index     Which, below warning_count.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (index), MRY_E_BUFFER_TOO_SMALL, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_warning(
    context: *mut mry_context,
    session: mry_session,
    index: u32,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        call.session(session, |document| {
            let warnings = document.session.warnings();
            let none =
                || Failure::new(Code::MRY_E_NOT_FOUND, "index", format!("there are {} warnings", warnings.len()));
            text.fill(warnings.get(index as usize).ok_or_else(none)?)
        })
    })
}
