//! Memory of the host's. A host that has an allocator of its own can lend the memory for decoded frames, which are what
//! the library keeps most of: to count it, to bound it, or to share it with a device. Everything else, and all of it
//! without such an allocator, is the library's own.

use std::ffi::c_void;
use std::ops::Deref;
use std::ptr::NonNull;
use std::sync::Arc;

use marey::clip::{FrameMemory, LentBytes};

use crate::border::{self, Versioned};
use crate::error::Outcome;

/// Lends memory for one frame. It is called from several threads at a time, and must not call the library nor throw.
///
/// @param size       Bytes, at least 1.
/// @param alignment  What the address must be a multiple of: 64.
/// @param user       user of the description.
/// @return The memory; NULL where there is none, which makes the frame fail with MRY_E_MEMORY.
/// Thread: [worker-thread].
pub type mry_alloc_fn = Option<unsafe extern "C" fn(size: usize, alignment: usize, user: *mut c_void) -> *mut c_void>;

/// Takes memory back, which the library does not look at any more: when a frame leaves the cache and no map shows it,
/// and at the latest before mry_context_destroy returns. As mry_alloc_fn, it must not call the library nor throw.
///
/// @param memory     What mry_alloc_fn gave.
/// @param size       What it was asked for.
/// @param alignment  What it was asked for.
/// @param user       user of the description.
/// Thread: [worker-thread].
pub type mry_free_fn =
    Option<unsafe extern "C" fn(memory: *mut c_void, size: usize, alignment: usize, user: *mut c_void)>;

/// Where the memory for decoded frames comes from. Start from MRY_ALLOCATOR_INIT.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_allocator {
    /// sizeof(mry_allocator).
    pub struct_size: u32,
    /// Zero.
    pub reserved0: u32,
    /// Lends memory.
    pub alloc: mry_alloc_fn,
    /// Takes it back.
    pub free: mry_free_fn,
    /// Handed to both.
    pub user: *mut c_void,
}

// SAFETY: repr(C), starts with its u32 size; an integer, nullable functions and a pointer, which the host vouches for.
unsafe impl Versioned for mry_allocator {
    const FIRST_SIZE: usize = 32;
}
const _: () = assert!(size_of::<mry_allocator>() == 32);

/// Fills in an allocator with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param allocator  Where to write; NULL does nothing.
/// @param size       sizeof(mry_allocator) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_allocator_init(allocator: *mut mry_allocator, size: u32) {
    // SAFETY: the caller owns `size` bytes at `allocator`, or passes NULL.
    unsafe { border::init(allocator.cast(), size) }
}

/// What every address is a multiple of: a line of the cache, and what wide vector loads ask for.
const ALIGNMENT: usize = 64;

/// A host that lends memory.
#[derive(Clone, Copy)]
struct Lender {
    alloc: unsafe extern "C" fn(usize, usize, *mut c_void) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void, usize, usize, *mut c_void),
    user: *mut c_void,
}

// SAFETY: the callbacks' contract says that they are called from any thread; the pointer is only handed to them.
unsafe impl Send for Lender {}
// SAFETY: as above.
unsafe impl Sync for Lender {}

impl std::fmt::Debug for Lender {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the host's allocator")
    }
}

/// Memory that is the host's.
struct HostBytes {
    start: NonNull<u8>,
    size: usize,
    lender: Lender,
}

// SAFETY: nobody else has the memory until it is given back, and it is written before it is shared.
unsafe impl Send for HostBytes {}
// SAFETY: as above.
unsafe impl Sync for HostBytes {}

impl LentBytes for HostBytes {}

impl Deref for HostBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        // SAFETY: `lend` wrote `size` bytes there, and they stay until the drop.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.size) }
    }
}

impl Drop for HostBytes {
    fn drop(&mut self) {
        // SAFETY: the host gave the function for this, and the memory is its own.
        unsafe { (self.lender.free)(self.start.as_ptr().cast(), self.size, ALIGNMENT, self.lender.user) }
    }
}

impl FrameMemory for Lender {
    fn lend(&self, contents: &[u8]) -> Option<Box<dyn LentBytes>> {
        // SAFETY: the host gave the function for this.
        let start = unsafe { (self.alloc)(contents.len(), ALIGNMENT, self.user) };
        let start = NonNull::new(start.cast::<u8>())?;
        // SAFETY: the host lends that many bytes there, to nobody else.
        unsafe { start.as_ptr().copy_from_nonoverlapping(contents.as_ptr(), contents.len()) };
        Some(Box::new(HostBytes { start, size: contents.len(), lender: *self }))
    }
}

/// The allocator at `ptr`, or none for NULL.
///
/// # Safety
/// As for [`border::read`].
pub(crate) unsafe fn read(ptr: *const mry_allocator) -> Outcome<Option<Arc<dyn FrameMemory>>> {
    if ptr.is_null() {
        return Ok(None);
    }
    // SAFETY: as this function's own.
    let allocator = unsafe { border::read(ptr, "desc.allocator")? };
    border::reserved(allocator.reserved0)?;
    let alloc = allocator.alloc.ok_or_else(|| border::null("desc.allocator.alloc"))?;
    let free = allocator.free.ok_or_else(|| border::null("desc.allocator.free"))?;
    Ok(Some(Arc::new(Lender { alloc, free, user: allocator.user })))
}
