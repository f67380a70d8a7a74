//! Errors. What went wrong, in words, in memory of the caller's own: no thread-local state, no allocation.

use std::ffi::c_char;
use std::sync::TryLockError;

use crate::status::{self, mry_status, mry_status_code};

/// The detail of a failed call. Pass one as the last argument, or NULL. It is filled when the status is negative, and
/// by mry_job_wait and the mry_job_take functions for a job's failure; otherwise it is left alone.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_error {
    /// sizeof(mry_error).
    pub struct_size: u32,
    /// The status that the call returned.
    pub status: mry_status,
    /// One line naming the thing, the place and the remedy: UTF-8, NUL-terminated, cut between characters.
    pub message: [c_char; 512],
    /// The parameter at fault, as this header names it; empty where no single one is.
    pub param: [c_char; 64],
}

/// Fills in an error with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param error  Where to write; NULL does nothing.
/// @param size   sizeof(mry_error) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_error_init(error: *mut mry_error, size: u32) {
    // SAFETY: the caller owns `size` bytes at `error`, or passes NULL.
    unsafe { crate::border::init(error.cast(), size) }
}

/// Why a call fails, before it reaches the caller's memory.
#[derive(Clone, Debug)]
pub(crate) struct Failure {
    pub(crate) status: mry_status,
    pub(crate) param: &'static str,
    pub(crate) message: String,
}

pub(crate) type Outcome<T> = Result<T, Failure>;

impl Failure {
    pub(crate) fn new(status: mry_status_code, param: &'static str, message: impl Into<String>) -> Self {
        Self { status: status as mry_status, param, message: message.into() }
    }

    /// A value outside its range.
    pub(crate) fn argument(param: &'static str, message: impl Into<String>) -> Self {
        Self::new(mry_status_code::MRY_E_ARGUMENT, param, message)
    }

    /// An object that cannot be locked now, or not any more; `doing` is what the thread that has it does with it.
    pub(crate) fn locked<T>(error: &TryLockError<T>, param: &'static str, doing: &str) -> Self {
        match error {
            TryLockError::WouldBlock => {
                Self::new(mry_status_code::MRY_E_BUSY, param, format!("another thread is {doing} the {param}"))
            }
            TryLockError::Poisoned(_) => {
                Self::new(mry_status_code::MRY_E_POISONED, param, format!("the {param} was poisoned; destroy it"))
            }
        }
    }

    /// Names the parameter that an error of the engine is about.
    pub(crate) fn about(mut self, param: &'static str) -> Self {
        self.param = param;
        self
    }
}

impl From<marey::Error> for Failure {
    fn from(error: marey::Error) -> Self {
        Self { status: status::of(&error) as mry_status, param: "", message: error.to_string() }
    }
}

/// Copies as much of `text` as fits before a NUL, never half a character.
pub(crate) fn copy_text(text: &str, to: &mut [c_char]) {
    let Some(room) = to.len().checked_sub(1) else { return };
    let end = text.floor_char_boundary(room.min(text.len()));
    // A NUL inside would end the text early for its reader; show it as a space.
    for (slot, byte) in to.iter_mut().zip(text.as_bytes()[..end].iter()) {
        *slot = if *byte == 0 { b' ' as c_char } else { *byte as c_char };
    }
    to[end..].fill(0);
}

#[cfg(test)]
mod tests {
    use super::copy_text;
    use std::ffi::c_char;

    fn cut(text: &str, room: usize) -> String {
        let mut buffer = vec![1 as c_char; room];
        copy_text(text, &mut buffer);
        let end = buffer.iter().position(|c| *c == 0).expect("terminated");
        assert!(buffer[end..].iter().all(|c| *c == 0), "no bytes of an older text may stay");
        String::from_utf8(buffer[..end].iter().map(|c| *c as u8).collect()).expect("whole characters")
    }

    #[test]
    fn text_is_cut_between_characters_of_any_length() {
        assert_eq!(cut("abc", 8), "abc");
        assert_eq!(cut("abc", 4), "abc");
        assert_eq!(cut("abc", 3), "ab");
        for (text, width) in [("ééééé", 2), ("馬馬馬馬", 3), ("🐎🐎🐎", 4)] {
            for room in 1..=text.len() + 2 {
                let whole = (room - 1).min(text.len()) / width;
                assert_eq!(cut(text, room).chars().count(), whole, "{text} in {room}");
            }
        }
        assert_eq!(cut("a\0b", 8), "a b");
    }
}
