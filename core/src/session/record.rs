//! Records: lines that prove themselves whole. Session files and journals are made of them.
//!
//! A record is `LENGTH CRC TEXT` and a line feed: the text's bytes in decimal, their CRC-32 in eight hexadecimal
//! digits, and the text, which is JSON on one line. A reader that meets a damaged line goes on at the next line feed,
//! so damage costs the records it touches and no others. CRC-32 finds accidents, not forgery.

use serde::Serialize;

use crate::error::{Error, Result};

/// `value` as a record.
pub(super) fn encode(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string(value).map_err(|e| {
        Error::invalid("session", format!("cannot be written: {e}"), "use paths and numbers JSON can hold")
    })?;
    Ok(format!("{} {:08x} {text}\n", text.len(), crc32fast::hash(text.as_bytes())))
}

/// One line of a file of records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Line<'a> {
    /// The byte after its line feed.
    pub(super) end: usize,
    /// The record's text; [`None`] where the line is not what was written.
    pub(super) text: Option<&'a str>,
    /// Whether the file ends before its line feed.
    pub(super) torn: bool,
}

/// The lines of a file of records, whatever its bytes.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let rest = bytes.get(at..).filter(|rest| !rest.is_empty())?;
        let feed = rest.iter().position(|b| *b == b'\n');
        at += feed.map_or(rest.len(), |feed| feed + 1);
        let text = feed.and_then(|feed| decode(&rest[..feed]));
        Some(Line { end: at, text, torn: feed.is_none() })
    })
}

fn decode(line: &[u8]) -> Option<&str> {
    let mut fields = std::str::from_utf8(line).ok()?.splitn(3, ' ');
    let (length, sum, text) = (fields.next()?, fields.next()?, fields.next()?);
    let whole = length.parse() == Ok(text.len())
        && sum.len() == 8
        && u32::from_str_radix(sum, 16) == Ok(crc32fast::hash(text.as_bytes()));
    whole.then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damage_costs_the_records_it_touches_and_no_others() {
        let words = ["one", "two\nlines, größer", "three"];
        let file: String = words.iter().map(|w| encode(w).expect("a text")).collect();
        let texts =
            |bytes: &[u8]| -> Vec<String> { lines(bytes).filter_map(|l| serde_json::from_str(l.text?).ok()).collect() };
        assert_eq!(texts(file.as_bytes()), words);
        for cut in 0..file.len() {
            let whole = &file.as_bytes()[..cut];
            let read = texts(whole);
            assert_eq!(read[..], words[..read.len()], "cut at {cut}");
            assert_eq!(lines(whole).any(|l| l.torn), whole.last().is_some_and(|b| *b != b'\n'));
        }
        for at in 0..file.len() {
            for bit in 0..8 {
                let mut bytes = file.clone().into_bytes();
                bytes[at] ^= 1 << bit;
                let read = texts(&bytes);
                // A flipped line feed joins two records; a flipped letter of the sum may only change its case.
                assert!(
                    read.len() + 2 >= words.len() && read.iter().all(|r| words.contains(&r.as_str())),
                    "{at} {bit}"
                );
            }
        }
    }
}
