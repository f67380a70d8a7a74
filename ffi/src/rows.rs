//! Pictures in the caller's memory: rows of bytes with a distance between them.

use crate::border::{Buffer, check};
use crate::error::{Failure, Outcome};

/// A caller's buffer for the rows of a picture.
pub(crate) struct Rows {
    buffer: Buffer<u8>,
    stride: usize,
}

impl Rows {
    /// # Safety
    /// `ptr` is null, or `capacity` bytes may be written there until the call returns.
    pub(crate) unsafe fn new(ptr: *mut u8, capacity: usize, stride: usize, param: &'static str) -> Outcome<Self> {
        check(ptr, param)?;
        // SAFETY: as this function's own.
        Ok(Self { buffer: unsafe { Buffer::new(ptr, capacity, param)? }, stride })
    }

    /// Checks that `height` rows of `row_bytes` fit; returns the distance between rows.
    pub(crate) fn fits(&self, row_bytes: usize, height: usize) -> Outcome<usize> {
        let stride = if self.stride == 0 { row_bytes } else { self.stride };
        if stride < row_bytes {
            let message = format!("stride_bytes is {stride}, and a row has {row_bytes} bytes");
            return Err(Failure::argument("stride_bytes", message));
        }
        let all = height.checked_sub(1).and_then(|rows| stride.checked_mul(rows)?.checked_add(row_bytes));
        let all = all.ok_or_else(|| Failure::argument("stride_bytes", "stride_bytes is absurdly large"))?;
        self.buffer.fits(all)?;
        Ok(stride)
    }

    /// Writes rows of `row_bytes` each; bytes between rows are left alone.
    pub(crate) fn write(&self, pixels: &[u8], row_bytes: usize) -> Outcome<()> {
        let stride = self.fits(row_bytes, pixels.len() / row_bytes.max(1))?;
        for (y, row) in pixels.chunks_exact(row_bytes.max(1)).enumerate() {
            // SAFETY: `fits` has found the last row's end within the buffer.
            unsafe { row.as_ptr().copy_to_nonoverlapping(self.buffer.ptr.add(y * stride), row_bytes) }
        }
        Ok(())
    }
}
