//! The caller's memory, read and written in the only ways this library does: checked for NULL, alignment and size
//! first, written only on success, the needed count excepted.

use std::ffi::c_char;
use std::mem::{MaybeUninit, size_of};

use crate::error::{Failure, Outcome, copy_text};
use crate::status::mry_status_code as Code;

/// No struct of this library will ever come near this size; a larger struct_size was never set.
const MAX_STRUCT: usize = 1 << 14;

/// A struct whose first field is `struct_size: u32`.
///
/// # Safety
/// The type is `repr(C)`, starts with that field, and any bytes that a C host may put into it are a valid value.
pub(crate) unsafe trait Versioned: Copy {
    /// Its size in the first version that had it; less is an error.
    const FIRST_SIZE: usize;
}

pub(crate) fn null(param: &'static str) -> Failure {
    Failure::new(Code::MRY_E_NULL, param, format!("{param} is NULL"))
}

pub(crate) fn check<T>(ptr: *const T, param: &'static str) -> Outcome<()> {
    if ptr.is_null() {
        return Err(null(param));
    }
    if !ptr.is_aligned() {
        let message = format!("{param} is not aligned to {} bytes", align_of::<T>());
        return Err(Failure::argument(param, message));
    }
    Ok(())
}

fn struct_size<T: Versioned>(size: u32, param: &'static str) -> Outcome<usize> {
    let size = size as usize;
    if size < T::FIRST_SIZE || size > MAX_STRUCT {
        let message =
            format!("{param}: struct_size is {size}, and {} was expected; use the INIT macro", size_of::<T>());
        return Err(Failure::new(Code::MRY_E_STRUCT_SIZE, param, message));
    }
    Ok(size)
}

/// Zeroes a struct of the caller's and sets its struct_size.
///
/// # Safety
/// `ptr` is null or `size` bytes may be written there.
pub(crate) unsafe fn init(ptr: *mut u8, size: u32) {
    if ptr.is_null() || (size as usize) < size_of::<u32>() || size as usize > MAX_STRUCT {
        return;
    }
    // SAFETY: as this function's own; the size covers the u32.
    unsafe {
        ptr.write_bytes(0, size as usize);
        ptr.cast::<u32>().write_unaligned(size);
    }
}

/// Copies a struct in. One of an older header is completed with zeros, which mean the defaults; one of a newer header
/// is refused when it asks for anything that this library does not know.
///
/// # Safety
/// `ptr` is null or points at a struct of its own struct_size.
pub(crate) unsafe fn read<T: Versioned>(ptr: *const T, param: &'static str) -> Outcome<T> {
    check(ptr, param)?;
    // SAFETY: the struct starts with its u32 size, which counts the bytes that may be read; any bytes make a T.
    unsafe {
        let size = struct_size::<T>(ptr.cast::<u32>().read(), param)?;
        let bytes = ptr.cast::<u8>();
        for i in size_of::<T>()..size {
            if *bytes.add(i) != 0 {
                let message = format!("{param} sets a field that this version of the library does not know");
                return Err(Failure::new(Code::MRY_E_UNSUPPORTED, param, message));
            }
        }
        let mut value = MaybeUninit::<T>::zeroed();
        bytes.copy_to_nonoverlapping(value.as_mut_ptr().cast::<u8>(), size.min(size_of::<T>()));
        Ok(value.assume_init())
    }
}

/// A place for one value, checked.
pub(crate) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// # Safety
    /// `ptr` is null or a T may be written there until the call returns.
    pub(crate) unsafe fn new(ptr: *mut T, param: &'static str) -> Outcome<Self> {
        check(ptr, param)?;
        Ok(Self(ptr))
    }

    /// A place that may be left out.
    ///
    /// # Safety
    /// As for [`Self::new`].
    pub(crate) unsafe fn optional(ptr: *mut T, param: &'static str) -> Outcome<Option<Self>> {
        // SAFETY: as this function's own.
        if ptr.is_null() { Ok(None) } else { unsafe { Self::new(ptr, param).map(Some) } }
    }

    pub(crate) fn set(&self, value: T) {
        // SAFETY: `new` was promised that a T may be written there.
        unsafe { self.0.write(value) }
    }
}

/// A place for a struct of the caller's size, checked.
pub(crate) struct OutStruct<T> {
    ptr: *mut T,
    size: usize,
}

impl<T: Versioned> OutStruct<T> {
    /// # Safety
    /// `ptr` is null or points at a struct of its own struct_size, which may be written until the call returns.
    pub(crate) unsafe fn new(ptr: *mut T, param: &'static str) -> Outcome<Self> {
        check(ptr, param)?;
        // SAFETY: the struct starts with its u32 size.
        let size = unsafe { struct_size::<T>(ptr.cast::<u32>().read(), param)? };
        Ok(Self { ptr, size })
    }

    /// A struct that may be left out.
    ///
    /// # Safety
    /// As for [`Self::new`].
    pub(crate) unsafe fn optional(ptr: *mut T, param: &'static str) -> Outcome<Option<Self>> {
        // SAFETY: as this function's own.
        if ptr.is_null() { Ok(None) } else { unsafe { Self::new(ptr, param).map(Some) } }
    }

    /// Writes all of `value` that the caller's struct has room for; its struct_size stays.
    pub(crate) fn set(&self, value: &T) {
        let skip = size_of::<u32>();
        let count = self.size.min(size_of::<T>()) - skip;
        // SAFETY: `new` was promised that `size` bytes may be written; a struct is at least its size field.
        unsafe {
            let from = std::ptr::from_ref(value).cast::<u8>().add(skip);
            from.copy_to_nonoverlapping(self.ptr.cast::<u8>().add(skip), count);
        }
    }
}

/// `count` values of the caller's to read.
///
/// # Safety
/// `ptr` is null or `count` values may be read there until the call returns.
pub(crate) unsafe fn slice<'a, T>(ptr: *const T, count: usize, max: usize, param: &'static str) -> Outcome<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    check(ptr, param)?;
    if count > max {
        let message = format!("{param} has {count} entries, and at most {max} are allowed");
        return Err(Failure::new(Code::MRY_E_LIMIT, param, message));
    }
    // SAFETY: not null, aligned, promised readable; `max` keeps the size far below isize::MAX.
    Ok(unsafe { std::slice::from_raw_parts(ptr, count) })
}

/// A caller's buffer for as many values as there turn out to be.
pub(crate) struct Buffer<T> {
    pub(crate) ptr: *mut T,
    capacity: usize,
    param: &'static str,
}

impl<T: Copy> Buffer<T> {
    /// # Safety
    /// `ptr` is null, or `capacity` values may be written there until the call returns.
    pub(crate) unsafe fn new(ptr: *mut T, capacity: usize, param: &'static str) -> Outcome<Self> {
        if capacity > 0 {
            check(ptr, param)?;
        }
        Ok(Self { ptr, capacity, param })
    }

    /// Whether `count` values fit; says how many are needed when they do not.
    pub(crate) fn fits(&self, count: usize) -> Outcome<()> {
        if count <= self.capacity {
            return Ok(());
        }
        let message = format!("{} has room for {}, and {count} are needed", self.param, self.capacity);
        Err(Failure::new(Code::MRY_E_BUFFER_TOO_SMALL, self.param, message))
    }

    /// Writes `values` when they fit.
    pub(crate) fn write(&self, values: &[T]) -> Outcome<()> {
        self.fits(values.len())?;
        if !values.is_empty() {
            // SAFETY: `new` was promised room for `capacity` values, and that is enough.
            unsafe { values.as_ptr().copy_to_nonoverlapping(self.ptr, values.len()) }
        }
        Ok(())
    }
}

/// A caller's buffer, and the place for the count that it has to hold.
pub(crate) struct List<T> {
    buffer: Buffer<T>,
    out_count: Out<usize>,
}

impl<T: Copy> List<T> {
    /// # Safety
    /// As for [`Buffer::new`] and [`Out::new`].
    pub(crate) unsafe fn new(
        ptr: *mut T,
        capacity: usize,
        out_count: *mut usize,
        param: &'static str,
    ) -> Outcome<Self> {
        // SAFETY: as this function's own.
        unsafe { Ok(Self { buffer: Buffer::new(ptr, capacity, param)?, out_count: Out::new(out_count, "out_count")? }) }
    }

    /// Writes the count, and refuses when so many values do not fit: before work that would be for nothing.
    pub(crate) fn fits(&self, count: usize) -> Outcome<()> {
        self.out_count.set(count);
        self.buffer.fits(count)
    }

    /// Writes `values` when they fit, and their count either way.
    pub(crate) fn fill(&self, values: &[T]) -> Outcome<Code> {
        self.out_count.set(values.len());
        self.buffer.write(values)?;
        Ok(Code::MRY_OK)
    }
}

/// A caller's buffer for text with a NUL, and the place for the bytes that it has to hold.
pub(crate) struct Text {
    buffer: Buffer<c_char>,
    out_size: Out<usize>,
}

impl Text {
    /// # Safety
    /// As for [`Buffer::new`] and [`Out::new`].
    pub(crate) unsafe fn new(
        ptr: *mut c_char,
        capacity: usize,
        out_size: *mut usize,
        param: &'static str,
    ) -> Outcome<Self> {
        // SAFETY: as this function's own.
        unsafe { Ok(Self { buffer: Buffer::new(ptr, capacity, param)?, out_size: Out::new(out_size, "out_size")? }) }
    }

    /// Writes `text` and a NUL when they fit, and the bytes needed either way.
    pub(crate) fn fill(&self, text: &str) -> Outcome<Code> {
        let mut bytes = vec![0; text.len() + 1];
        copy_text(text, &mut bytes);
        self.out_size.set(bytes.len());
        self.buffer.write(&bytes)?;
        Ok(Code::MRY_OK)
    }
}

/// Lists of one capacity, any of which may be left out, and the place for the count that each has to hold.
pub(crate) struct Lists {
    capacity: usize,
    wanted: bool,
    out_count: Out<usize>,
}

impl Lists {
    /// # Safety
    /// As for [`Out::new`].
    pub(crate) unsafe fn new(capacity: usize, out_count: *mut usize) -> Outcome<Self> {
        // SAFETY: as this function's own.
        Ok(Self { capacity, wanted: false, out_count: unsafe { Out::new(out_count, "out_count")? } })
    }

    /// One of the lists, with `each` values an entry.
    ///
    /// # Safety
    /// `ptr` is null, or `each` values for every entry may be written there until the call returns.
    pub(crate) unsafe fn list<T: Copy>(
        &mut self,
        ptr: *mut T,
        each: usize,
        param: &'static str,
    ) -> Outcome<Option<Buffer<T>>> {
        let absurd = || Failure::argument("capacity", format!("capacity is {}, which is absurd", self.capacity));
        let capacity = self.capacity.checked_mul(each).ok_or_else(absurd)?;
        self.wanted |= !ptr.is_null();
        // SAFETY: as this function's own.
        if ptr.is_null() { Ok(None) } else { unsafe { Buffer::new(ptr, capacity, param).map(Some) } }
    }

    /// Writes the count, and refuses when `count` entries do not fit: one list speaks for all, before any is written.
    pub(crate) fn fit(&self, count: usize) -> Outcome<()> {
        self.out_count.set(count);
        if self.wanted && count > self.capacity {
            let message = format!("capacity is {}, and {count} are needed", self.capacity);
            return Err(Failure::new(Code::MRY_E_BUFFER_TOO_SMALL, "capacity", message));
        }
        Ok(())
    }
}

/// A field of a description that this version has no use for must be zero.
pub(crate) fn reserved(value: u32) -> Outcome<()> {
    if value == 0 {
        return Ok(());
    }
    Err(Failure::new(Code::MRY_E_UNSUPPORTED, "desc", "desc.reserved0 is not zero"))
}
