//! The boxes of which MP4 and QuickTime files consist (ISO/IEC 14496-12, 4.2), read without trusting a word of them.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

/// Big-endian values off the front of some bytes; [`None`] when they run out.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl<'a> Fields<'a> {
    pub(super) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, tail) = self.0.split_at_checked(count)?;
        self.0 = tail;
        Some(head)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, tail) = self.0.split_first_chunk()?;
        self.0 = tail;
        Some(*head)
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.array().map(|[b]| b)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_be_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_be_bytes)
    }

    pub(super) fn i32(&mut self) -> Option<i32> {
        self.array().map(i32::from_be_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_be_bytes)
    }

    /// Version and flags, with which a "full box" begins.
    pub(super) fn version_and_flags(&mut self) -> Option<(u8, u32)> {
        self.u32().map(|v| ((v >> 24) as u8, v & 0x00ff_ffff))
    }
}

/// A box's name.
pub(super) type Name = [u8; 4];

/// The boxes side by side in `data`. One that claims more than there is has what there is.
pub(super) fn children(data: &[u8]) -> impl Iterator<Item = (Name, &[u8])> {
    let mut rest = Fields(data);
    std::iter::from_fn(move || {
        let whole = rest.0;
        let size = rest.u32()?;
        let name = rest.array()?;
        let (size, header) = match size {
            0 => (whole.len() as u64, 8),
            1 => (rest.u64()?, 16),
            _ => (u64::from(size), 8),
        };
        let body = usize::try_from(size.checked_sub(header)?).unwrap_or(usize::MAX).min(rest.0.len());
        Some((name, rest.take(body)?))
    })
}

/// The first box of that name.
pub(super) fn child<'a>(data: &'a [u8], name: &Name) -> Option<&'a [u8]> {
    children(data).find(|(n, _)| n == name).map(|(_, body)| body)
}

/// The first box at the end of a path of names.
pub(super) fn descendant<'a>(data: &'a [u8], path: &[&Name]) -> Option<&'a [u8]> {
    path.iter().try_fold(data, |data, name| child(data, name))
}

/// A name as a person would write it.
pub(super) fn readable(name: &Name) -> String {
    name.iter().map(|&b| if b.is_ascii_graphic() { b as char } else { '?' }).collect()
}

/// A box of a file's top level.
pub(super) struct TopBox {
    pub(super) name: Name,
    /// Where its header begins, bytes from the start of the file.
    pub(super) start: u64,
    /// Where its contents begin.
    pub(super) body: u64,
    /// Where its contents end, by its own word.
    pub(super) end: u64,
}

/// More boxes than any camera writes: an hour of fragments, one a frame, is 400,000.
const MAX_TOP_BOXES: usize = 1 << 20;

/// The boxes of the file's top level, up to the first that makes no sense.
pub(super) fn top_level(file: &mut File, file_len: u64) -> std::io::Result<Vec<TopBox>> {
    let mut found = Vec::new();
    let mut start = 0u64;
    while start + 8 <= file_len && found.len() < MAX_TOP_BOXES {
        let mut header = [0u8; 16];
        let have = (file_len - start).min(16) as usize;
        file.seek(SeekFrom::Start(start))?;
        file.read_exact(&mut header[..have])?;
        let mut fields = Fields(&header[..have]);
        let (Some(size), Some(name)) = (fields.u32(), fields.array()) else { break };
        let (size, header) = match size {
            0 => (file_len - start, 8),
            1 => match fields.u64() {
                Some(size) => (size, 16),
                None => break,
            },
            _ => (u64::from(size), 8),
        };
        let plausible = name.iter().all(|b| b.is_ascii_graphic() || *b == b' ' || *b == 0xa9);
        let Some(end) = start.checked_add(size) else { break };
        if size < header || !plausible {
            break;
        }
        found.push(TopBox { name, start, body: start + header, end });
        start = end;
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_end_where_the_bytes_end() {
        let mut data = vec![0, 0, 0, 9, b'a', b'b', b'c', b'd', 7];
        data.extend([0, 0, 0, 99, b'l', b'o', b'n', b'g', 1, 2]);
        let found: Vec<_> = children(&data).collect();
        assert_eq!(found, [(*b"abcd", &[7u8][..]), (*b"long", &[1, 2][..])]);
        assert!(children(&[0, 0, 0, 3, 1, 2, 3, 4, 5]).next().is_none(), "a box smaller than its header");
        assert!(children(&[0, 0, 0, 1, 1, 2, 3, 4, 255]).next().is_none(), "a long size that is cut off");
    }
}
