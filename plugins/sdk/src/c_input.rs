//! What the host tells through the C door, read into views: every pointer looked at before it is followed.

use std::ffi::{CStr, c_char};

use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::mesh::Handle;
use crate::motion::{Motion, Track};
use crate::raw;
use crate::rig::{Facing, Limb, Paint, Painted, Rig, Side, Stroke};
use crate::room::{Host, Work};

pub(crate) fn null(what: &str) -> Error {
    Error::invalid(format!("the host gave no {what}"))
}

/// # Safety
/// `ptr` is null or points at a T that lives for `'a`.
pub(crate) unsafe fn get<'a, T>(ptr: *const T, what: &str) -> Result<&'a T> {
    // SAFETY: as this function's own.
    unsafe { ptr.as_ref() }.ok_or_else(|| null(what))
}

/// # Safety
/// `ptr` is null or points at `count` values that live for `'a`.
pub(crate) unsafe fn slice<'a, T>(ptr: *const T, count: usize, what: &str) -> Result<&'a [T]> {
    match (count, ptr.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(null(what)),
        // SAFETY: as this function's own.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts(ptr, count) }),
    }
}

/// # Safety
/// `ptr` is null or points at a NUL-terminated string that lives for `'a`.
pub(crate) unsafe fn text<'a>(ptr: *const c_char, what: &str) -> Result<&'a str> {
    if ptr.is_null() {
        return Err(null(what));
    }
    // SAFETY: as this function's own.
    let text = unsafe { CStr::from_ptr(ptr) };
    text.to_str().map_err(|_| Error::invalid(format!("the host's {what} is not UTF-8")))
}

/// # Safety
/// The pointers are as plugin.h says, and live for `'a`.
pub(crate) unsafe fn rig<'a>(raw: &raw::Rig) -> Result<Rig<'a>> {
    // SAFETY: as this function's own, here and below.
    let limbs = unsafe { slice(raw.limbs, raw.limb_count as usize, "limbs")? };
    let limbs = limbs.iter().map(|limb: &raw::Limb| {
        Ok(Limb {
            // SAFETY: as above.
            label: unsafe { text(limb.label, "label")? },
            side: match limb.side {
                raw::SIDE_NEAR => Some(Side::Near),
                raw::SIDE_FAR => Some(Side::Far),
                raw::SIDE_MID => Some(Side::Mid),
                _ => None,
            },
            parent: usize::try_from(limb.parent).ok(),
            points: limb.point_count as usize,
            rooted_at_start: limb.flags & raw::LIMB_ROOTED_AT_START != 0,
            terminal: limb.flags & raw::LIMB_TERMINAL != 0,
        })
    });
    // SAFETY: as above.
    let strokes = unsafe { slice(raw.strokes, raw.stroke_count as usize, "strokes")? };
    let strokes = strokes.iter().map(|stroke: &raw::Stroke| {
        Ok(Stroke {
            limb: stroke.limb as usize,
            frame: stroke.frame as usize,
            // SAFETY: as above.
            points: unsafe { slice(stroke.points, stroke.point_count as usize, "points")? },
            facing: match stroke.facing {
                raw::FACING_TOWARD => Some(Facing::Toward),
                raw::FACING_AWAY => Some(Facing::Away),
                _ => None,
            },
        })
    });
    // SAFETY: as above.
    let paints = unsafe { slice(raw.paints, raw.paint_count as usize, "paints")? };
    let paints = paints.iter().map(|paint: &raw::Paint| {
        Ok(Paint {
            frame: paint.frame as usize,
            foreground: paint.foreground != 0,
            radius: paint.radius,
            // SAFETY: as above.
            points: unsafe { slice(paint.points, paint.point_count as usize, "points")? },
        })
    });
    Ok(Rig {
        limbs: limbs.collect::<Result<_>>()?,
        strokes: strokes.collect::<Result<_>>()?,
        paints: paints.collect::<Result<_>>()?,
        painted: Vec::new(),
    })
}

/// # Safety
/// The pointers are as plugin.h says, and live for `'a`.
pub(crate) unsafe fn work<'a>(host: &'a dyn Host, clip: *const raw::Clip, drawn: *const raw::Rig) -> Result<Work<'a>> {
    // SAFETY: as this function's own, here and below.
    let (clip, raw) = unsafe { (get(clip, "clip")?, get(drawn, "rig")?) };
    // SAFETY: as above.
    let mut rig = unsafe { rig(raw)? };
    let pixels = clip.width as usize * clip.height as usize;
    // SAFETY: as above.
    for painted in unsafe { slice(raw.painted, raw.painted_count as usize, "painted")? } {
        // SAFETY: as above; a painted mask is of the clip's size.
        let pixels = unsafe { slice(painted.pixels, pixels, "pixels")? };
        rig.painted.push(Painted { frame: painted.frame as usize, pixels });
    }
    Ok(Work { clip: Clip::new(host, (clip.width, clip.height), clip.frame_count, clip.fps), rig })
}

/// # Safety
/// The pointers are as plugin.h says, and live for `'a`.
pub(crate) unsafe fn motion<'a>(raw: *const raw::Motion, frames: usize) -> Result<Motion<'a>> {
    // SAFETY: as this function's own, here and below.
    let raw = unsafe { get(raw, "motion")? };
    // SAFETY: as above.
    let tracks = unsafe { slice(raw.tracks, raw.track_count as usize, "tracks")? };
    let tracks = tracks.iter().map(|track: &raw::Track| {
        let count = frames * track.point_count as usize;
        // SAFETY: as above; the three lists are of this length.
        unsafe {
            Ok(Track {
                label: text(track.label, "label")?,
                points: track.point_count as usize,
                places: slice(track.points, count, "points")?,
                visible: slice(track.visible, count, "visible")?,
                confidence: slice(track.confidence, count, "confidence")?,
            })
        }
    });
    Ok(Motion { tracks: tracks.collect::<Result<_>>()? })
}

/// # Safety
/// As for `slice` above.
pub(crate) unsafe fn handles(raw: *const raw::Handle, count: u32) -> Result<Vec<Handle>> {
    // SAFETY: as this function's own.
    let raw = unsafe { slice(raw, count as usize, "handles")? };
    raw.iter()
        .map(|handle| match handle.kind {
            raw::HANDLE_POINT => Ok(Handle::Point(handle.a)),
            raw::HANDLE_BONE => Ok(Handle::Bone(handle.a, handle.b)),
            other => Err(Error::unsupported(format!("the plugin does not know handles of kind {other}"))),
        })
        .collect()
}
