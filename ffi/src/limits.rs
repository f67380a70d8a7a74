//! Limits. What a context will work on at most, so that a hostile file cannot eat the machine. They are set when the
//! context is created; what exceeds one is refused with MRY_E_LIMIT.

use marey::clip::ClipOptions;

use crate::border::{self, Versioned};
use crate::error::{Failure, Outcome};

/// The most of everything. Zero in a field is its default. Start from MRY_LIMITS_INIT.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_limits {
    /// sizeof(mry_limits).
    pub struct_size: u32,
    /// Objects of one kind alive at a time; 65536, and no more than that.
    pub objects: u32,
    /// Pixels of one frame; 64 million. The options of a clip can only ask for less.
    pub frame_pixels: u64,
    /// Bytes of decoded frames that one clip keeps; 256 MB. The options of a clip can only ask for less.
    pub cache_bytes: u64,
    /// Frames of one clip; 1 million.
    pub frames: u64,
    /// Points of one stroke or brush path; 10000, and no more than that.
    pub points: u32,
    /// Key frames of one rig; 100000, and no more than that.
    pub key_frames: u32,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_limits {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_limits>() == 40);

/// Limits with the defaults filled in.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    pub(crate) objects: usize,
    frame_pixels: u64,
    cache_bytes: u64,
    pub(crate) frames: u64,
    pub(crate) points: usize,
    pub(crate) key_frames: usize,
}

impl Limits {
    /// The limits at `ptr`, or the defaults for NULL.
    ///
    /// # Safety
    /// As for [`border::read`].
    pub(crate) unsafe fn read(ptr: *const mry_limits) -> Outcome<Self> {
        // SAFETY: as this function's own; zeros are numbers.
        let asked =
            unsafe { if ptr.is_null() { std::mem::zeroed::<mry_limits>() } else { border::read(ptr, "desc.limits")? } };
        let own = ClipOptions::default();
        Ok(Self {
            objects: bounded(asked.objects, 1 << 16, "objects")?,
            frame_pixels: or(asked.frame_pixels, own.max_pixels),
            cache_bytes: or(asked.cache_bytes, own.cache_bytes as u64),
            frames: or(asked.frames, 1 << 20),
            points: bounded(asked.points, 10_000, "points")?,
            key_frames: bounded(asked.key_frames, 100_000, "key_frames")?,
        })
    }

    /// How a clip may be opened: as `asked`, within the limits.
    pub(crate) fn clip_options(&self, mut asked: ClipOptions) -> ClipOptions {
        asked.max_pixels = asked.max_pixels.min(self.frame_pixels);
        asked.cache_bytes = asked.cache_bytes.min(usize::try_from(self.cache_bytes).unwrap_or(usize::MAX));
        asked
    }
}

fn or(asked: u64, default: u64) -> u64 {
    if asked == 0 { default } else { asked }
}

fn bounded(asked: u32, most: u32, field: &str) -> Outcome<usize> {
    if asked > most {
        let message = format!("desc.limits.{field} is {asked}, and at most {most} are allowed");
        return Err(Failure::argument("desc.limits", message));
    }
    Ok(if asked == 0 { most } else { asked } as usize)
}

/// Fills in limits with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param limits  Where to write; NULL does nothing.
/// @param size    sizeof(mry_limits) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_limits_init(limits: *mut mry_limits, size: u32) {
    // SAFETY: the caller owns `size` bytes at `limits`, or passes NULL.
    unsafe { border::init(limits.cast(), size) }
}
