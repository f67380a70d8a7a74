//! Version. Before 1.0 a new minor version may break the ABI, and the library's file name carries the minor number
//! (libmarey.so.0.1); a new patch version never does.

use std::ffi::c_char;

use crate::error::Failure;
use crate::status::{mry_status, mry_status_code};

const fn number(text: &str) -> u32 {
    let (bytes, mut value, mut i) = (text.as_bytes(), 0, 0);
    while i < bytes.len() {
        value = value * 10 + (bytes[i] - b'0') as u32;
        i += 1;
    }
    value
}

const MAJOR: u32 = number(env!("CARGO_PKG_VERSION_MAJOR"));
const MINOR: u32 = number(env!("CARGO_PKG_VERSION_MINOR"));
const PATCH: u32 = number(env!("CARGO_PKG_VERSION_PATCH"));
/// What MRY_ABI_VERSION in the header is.
pub(crate) const ABI: u32 = MAJOR << 16 | MINOR;

/// The library's version, packed as MRY_VERSION is: major * 65536 + minor * 256 + patch.
///
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn mry_version() -> u32 {
    MAJOR << 16 | MINOR << 8 | PATCH
}

/// The library's version as text, such as "0.1.0".
///
/// Lifetime: for ever.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn mry_version_string() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Whether the library speaks the ABI of the header that the host was compiled with. MRY_CONTEXT_DESC_INIT carries
/// the same number, so that mry_context_create makes this check too.
///
/// @param abi_version  MRY_ABI_VERSION.
/// @return MRY_OK, MRY_E_ABI.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub extern "C" fn mry_abi_check(abi_version: u32) -> mry_status {
    check(abi_version).map_or_else(|failure| failure.status, |()| mry_status_code::MRY_OK as mry_status)
}

pub(crate) fn check(abi_version: u32) -> Result<(), Failure> {
    if abi_version == ABI {
        return Ok(());
    }
    let (major, minor) = (abi_version >> 16, abi_version & 0xffff);
    Err(Failure::new(
        mry_status_code::MRY_E_ABI,
        "abi_version",
        format!(
            "the host was compiled with marey.h {major}.{minor}, and this is libmarey {MAJOR}.{MINOR}; use one pair"
        ),
    ))
}
