//! Strings across the border: UTF-8 with a length in, a caller's buffer out.

use std::ffi::{CStr, c_char};

use crate::border;
use crate::error::{Failure, Outcome};
use crate::status::mry_status_code;

/// A string for the library to read during the call: UTF-8, with its length or with len = MRY_STRZ where a NUL ends
/// it. MRY_STR("text") makes one from a C string.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_str {
    /// The first byte; may be NULL when len is 0.
    pub data: *const c_char,
    /// How many bytes, without a NUL; or MRY_STRZ.
    pub len: usize,
}

/// The longest string that is read: a megabyte-long path is a mistake, a long JSON text is not.
const MAX_BYTES: usize = 256 << 20;

impl mry_str {
    /// The text, as UTF-8 that lives as long as the call.
    pub(crate) unsafe fn text<'a>(self, param: &'static str) -> Outcome<&'a str> {
        // SAFETY: by the header's contract data points at len bytes, or at a NUL-terminated string.
        let bytes = unsafe {
            if self.len == usize::MAX {
                if self.data.is_null() {
                    return Err(Failure::new(mry_status_code::MRY_E_NULL, param, format!("{param} is NULL")));
                }
                CStr::from_ptr(self.data).to_bytes()
            } else {
                border::slice(self.data.cast::<u8>(), self.len, MAX_BYTES, param)?
            }
        };
        std::str::from_utf8(bytes).map_err(|e| {
            let at = e.valid_up_to();
            Failure::new(mry_status_code::MRY_E_STRING, param, format!("{param} is not UTF-8 at byte {at}"))
        })
    }

    /// The text of a path or a name: not empty, without a NUL.
    pub(crate) unsafe fn name<'a>(self, param: &'static str) -> Outcome<&'a str> {
        // SAFETY: as for `text`.
        let text = unsafe { self.text(param)? };
        if text.is_empty() {
            return Err(Failure::argument(param, format!("{param} is empty")));
        }
        if text.contains('\0') {
            return Err(Failure::new(mry_status_code::MRY_E_STRING, param, format!("{param} holds a NUL")));
        }
        Ok(text)
    }
}

impl From<&'static str> for mry_str {
    fn from(text: &'static str) -> Self {
        Self { data: text.as_ptr().cast(), len: text.len() }
    }
}
