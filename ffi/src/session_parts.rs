//! Session parts. Files that a session holds whole for characters and sketches: marked points, a drawing, what binds them,
//! a picture and its skeleton. Setting one is an edit like others: a step of undo, on the disk when the call returns.
//!
//! A part goes in and out as the bytes of its file. Objects are made of them by the calls that read such text, such as
//! mry_control_points_from_json, and give them by those that write it, such as mry_control_points_to_json.

use marey::session::{LARGEST_PART, Part, PartKind};

use crate::border::{self, List};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::entry;
use crate::session::mry_session;
use crate::status::{mry_status, mry_status_code as Code};

/// Part of a session: control points, a points.json.
pub const MRY_PART_POINTS: i32 = 0;
/// Part of a session: joints marked in the clip, a joints.json.
pub const MRY_PART_JOINTS: i32 = 1;
/// Part of a session: a vector drawing, an SVG.
pub const MRY_PART_DRAWING: i32 = 2;
/// Part of a session: how points hold the drawing, a bind.json.
pub const MRY_PART_BINDING: i32 = 3;
/// Part of a session: the picture of a character, a PNG, JPEG, WebP or GIF.
pub const MRY_PART_PICTURE: i32 = 4;
/// Part of a session: a character's mesh and skeleton, a rig.json.
pub const MRY_PART_SKELETON: i32 = 5;
/// Part of a session: the motion that moves a character, a motion.json.
pub const MRY_PART_MOTION: i32 = 6;
/// Part of a session: which joint follows what, a map.json.
pub const MRY_PART_MAP: i32 = 7;
/// Part of a session: text of the host's own.
pub const MRY_PART_NOTES: i32 = 8;

fn kind_in(part: i32) -> Outcome<PartKind> {
    let kind = usize::try_from(part).ok().and_then(|i| PartKind::ALL.get(i).copied());
    kind.ok_or_else(|| Failure::argument("part", format!("part is {part}, which is no MRY_PART")))
}

/// Sets a part of a session, in place of the one it has, or takes it away.
///
/// @param context  The context.
/// @param session  The session.
/// @param part     MRY_PART_POINTS, ...
/// @param bytes    The bytes of its file, which are copied; NULL with count 0 to take it away.
/// @param count    How many; at most 64 MiB.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (part), MRY_E_INPUT (they are not such a file, or the session is read-only),
///         MRY_E_LIMIT, MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_part(
    context: *mut mry_context,
    session: mry_session,
    part: i32,
    bytes: *const u8,
    count: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let kind = kind_in(part)?;
        let bytes = border::slice(bytes, count, LARGEST_PART, "bytes")?;
        call.session(session, |_| Ok(()))?;
        let part = if bytes.is_empty() { None } else { Some(Part::new(kind, bytes)) };
        let part = part.transpose().map_err(|e| Failure::from(e).about("bytes"))?;
        call.session_mut(session, |document| Ok(document.session.set_part(kind, part).map(|_| Code::MRY_OK)?))
    })
}

/// A part of a session, as the bytes of its file.
///
/// @param context    The context.
/// @param session    The session.
/// @param part       MRY_PART_POINTS, ...
/// @param bytes      Where they go, without a NUL; NULL with capacity 0 to ask for the count.
/// @param capacity   Room at bytes.
/// @param out_count  How many there are.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (it has none), MRY_E_BUFFER_TOO_SMALL, MRY_E_ARGUMENT (part), MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_part(
    context: *mut mry_context,
    session: mry_session,
    part: i32,
    bytes: *mut u8,
    capacity: usize,
    out_count: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let list = List::new(bytes, capacity, out_count, "bytes")?;
        let kind = kind_in(part)?;
        let held = call.session(session, |document| {
            let none = || Failure::new(Code::MRY_E_NOT_FOUND, "part", format!("the session has no {}", kind.name()));
            document.session.document().parts.get(&kind).cloned().ok_or_else(none)
        })?;
        list.fill(held.bytes())
    })
}
