//! Masks. One a frame, of the clip's size: which pixels are the creature's. Masks do not change.

use std::sync::Arc;

use marey::export::report::Report;
use marey::export::write_mask_folder;
use marey::job::Progress;
use marey::raster::Mask;

use crate::border::{self, OutStruct, Text, Versioned};
use crate::clip::frame_index;
use crate::context::mry_context;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::rows::Rows;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::Table;

/// Masks, with the report of the job that made them.
pub(crate) struct MaskSet {
    pub(crate) masks: Vec<Mask>,
    pub(crate) report: Report,
}

pub(crate) type MasksTable = Table<Arc<MaskSet>>;

/// The masks of a clip.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_masks {
    /// The id; 0 is no masks.
    pub v: u64,
}

/// What masks are.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_masks_info {
    /// sizeof(mry_masks_info).
    pub struct_size: u32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Zero.
    pub reserved0: u32,
    /// How many there are: one a frame.
    pub frame_count: u64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_masks_info {
    const FIRST_SIZE: usize = 24;
}
const _: () = assert!(size_of::<mry_masks_info>() == 24);

impl Call<'_> {
    pub(crate) fn masks(&self, masks: mry_masks) -> Outcome<Arc<MaskSet>> {
        Ok(self.get(&self.context.masks, masks.v, "masks")?.value.clone())
    }

    pub(crate) fn keep_masks(&self, masks: Arc<MaskSet>) -> Outcome<mry_masks> {
        Ok(mry_masks { v: self.context.masks.insert(masks)? })
    }
}

/// Fills in a masks info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_masks_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_masks_info_init(info: *mut mry_masks_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Destroys masks.
///
/// @param context  The context.
/// @param masks    The masks; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_masks_destroy(context: *mut mry_context, masks: mry_masks) -> mry_status {
    ending!(context, |call| {
        if masks.v != 0 {
            call.context.masks.remove(masks.v, "masks")?;
        }
        Ok(Code::MRY_OK)
    })
}

/// What masks are: size and number.
///
/// @param context   The context.
/// @param masks     The masks.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_masks_get_info(
    context: *mut mry_context,
    masks: mry_masks,
    out_info: *mut mry_masks_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let set = call.masks(masks)?;
        let (width, height) = set.masks.first().map_or((0, 0), |m| (m.width() as u32, m.height() as u32));
        let frame_count = set.masks.len() as u64;
        out.set(&mry_masks_info { struct_size: 0, width, height, reserved0: 0, frame_count });
        Ok(Code::MRY_OK)
    })
}

/// One frame's mask: a byte a pixel, 255 where it is the creature and 0 elsewhere, rows from the top.
///
/// @param context       The context.
/// @param masks         The masks.
/// @param frame         Which, counted from 0.
/// @param pixels        Where the rows go: width bytes each.
/// @param capacity      Bytes at pixels: at least stride_bytes * (height - 1) + width.
/// @param stride_bytes  From one row's start to the next's; 0 for rows without gaps. Bytes in gaps are left alone.
/// @param err           Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_ARGUMENT (frame, stride_bytes), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_masks_read(
    context: *mut mry_context,
    masks: mry_masks,
    frame: u64,
    pixels: *mut u8,
    capacity: usize,
    stride_bytes: usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let rows = Rows::new(pixels, capacity, stride_bytes, "pixels")?;
        let set = call.masks(masks)?;
        let mask = &set.masks[frame_index(frame, set.masks.len())?];
        rows.fits(mask.width(), mask.height())?;
        rows.write(mask.to_image().as_raw(), mask.width())?;
        Ok(Code::MRY_OK)
    })
}

/// Writes masks as 00000.png, 00001.png, ... (8 bits, 0 or 255) and a report.json; the folder appears whole or not at
/// all. One that was written before is replaced, anything else in the way is left alone and refused.
///
/// @param context  The context.
/// @param masks    The masks.
/// @param folder   The folder.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (something is in the way), MRY_E_STRING, MRY_E_ARGUMENT.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_masks_write_folder(
    context: *mut mry_context,
    masks: mry_masks,
    folder: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let folder = folder.name("folder")?;
        let set = call.masks(masks)?;
        let progress = Progress::new();
        let write = || write_mask_folder(folder.as_ref(), &set.masks, &set.report, progress.whole());
        call.context.executor.run(write).map_err(|e| Failure::from(e).about("folder"))?;
        Ok(Code::MRY_OK)
    })
}

/// The report of the job that made the masks, as the text of its report.json: counts, seconds, warnings, corrections.
///
/// @param context   The context.
/// @param masks     The masks.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_masks_get_report(
    context: *mut mry_context,
    masks: mry_masks,
    text: *mut std::ffi::c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        text.fill(&call.masks(masks)?.report.to_json())
    })
}
