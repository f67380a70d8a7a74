//! A look at an ELF library before the system's loader maps it.
//!
//! The loader trusts its file: one that ends too early kills the process by SIGBUS, whole tables may point nowhere.
//! Everything that the loader will read by offset is checked to lie inside the file, everything it will read or write
//! by address inside a segment: the program headers, the sections (a cut-off file loses them first), the dynamic
//! table, and the places that relocations and constructors name. It is no proof: code may still be garbage, which is
//! what the probe in another process is for.

/// What is wrong with a file.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    /// It ends before what it names.
    Truncated(String),
    /// It is something else, or for another machine.
    Format(String),
}

/// ELF's machine number of this program.
const MACHINE: u16 = if cfg!(target_arch = "x86_64") {
    62
} else if cfg!(target_arch = "aarch64") {
    183
} else {
    0
};
/// More address space than this is no plugin.
const MAX_SPAN: u64 = 1 << 32;

const PT_LOAD: u32 = 1;
const PT_DYNAMIC: u32 = 2;

struct Segment {
    offset: u64,
    address: u64,
    in_file: u64,
    in_memory: u64,
    writable: bool,
}

struct Elf<'a> {
    bytes: &'a [u8],
    segments: Vec<Segment>,
}

fn number<const N: usize>(bytes: &[u8], at: u64) -> Option<[u8; N]> {
    let at = usize::try_from(at).ok()?;
    bytes.get(at..at.checked_add(N)?)?.try_into().ok()
}

impl Elf<'_> {
    fn u16(&self, at: u64) -> Option<u16> {
        number(self.bytes, at).map(u16::from_le_bytes)
    }
    fn u32(&self, at: u64) -> Option<u32> {
        number(self.bytes, at).map(u32::from_le_bytes)
    }
    fn u64(&self, at: u64) -> Option<u64> {
        number(self.bytes, at).map(u64::from_le_bytes)
    }

    /// Whether `size` bytes from `offset` lie in the file.
    fn holds(&self, offset: u64, size: u64) -> bool {
        offset.checked_add(size).is_some_and(|end| end <= self.bytes.len() as u64)
    }

    /// Where in the file the `size` bytes at `address` come from, where one segment holds them all.
    fn at_address(&self, address: u64, size: u64) -> Option<u64> {
        self.segments.iter().find_map(|s| {
            let start = address.checked_sub(s.address)?;
            (start.checked_add(size)? <= s.in_file).then_some(s.offset + start)
        })
    }

    /// Whether `size` bytes at `address` can be written once mapped.
    fn writable(&self, address: u64, size: u64) -> bool {
        self.segments.iter().any(|s| {
            let start = address.checked_sub(s.address);
            s.writable && start.and_then(|a| a.checked_add(size)).is_some_and(|end| end <= s.in_memory)
        })
    }
}

/// Looks at a whole file.
pub(crate) fn check(bytes: &[u8]) -> Result<(), Flaw> {
    let format = |what: &str| Err(Flaw::Format(what.to_owned()));
    let cut = |what: &str| Err(Flaw::Truncated(format!("{what} lies past the end of the file")));
    if bytes.is_empty() {
        return Err(Flaw::Truncated("the file is empty".to_owned()));
    }
    if !bytes.starts_with(b"\x7fELF") {
        return format("it is no ELF library");
    }
    if bytes.len() < 64 {
        return cut("the header");
    }
    let mut elf = Elf { bytes, segments: Vec::new() };
    let header = |at| elf.u16(at).unwrap_or(0);
    if bytes[4] != 2 || bytes[5] != 1 || bytes[6] != 1 {
        return format("it is no 64-bit little-endian ELF file");
    }
    if MACHINE != 0 && header(18) != MACHINE {
        return format("it is for another machine");
    }
    if header(16) != 3 {
        return format("it is no shared library");
    }
    let (entry_size, count) = (header(54), u64::from(header(56)));
    if entry_size != 56 || count == 0 || count > 512 {
        return format("its program headers are damaged");
    }
    let first = elf.u64(32).unwrap_or(u64::MAX);
    if !elf.holds(first, 56 * count) {
        return cut("a program header");
    }
    let (section_size, sections) = (u64::from(header(58)), u64::from(header(60)));
    if sections > 0 && (section_size != 64 || !elf.holds(elf.u64(40).unwrap_or(u64::MAX), section_size * sections)) {
        return cut("the section table");
    }
    let mut dynamic = None;
    let mut end = 0;
    for i in 0..count {
        let at = first + 56 * i;
        let read = || {
            let segment = Segment {
                offset: elf.u64(at + 8)?,
                address: elf.u64(at + 16)?,
                in_file: elf.u64(at + 32)?,
                in_memory: elf.u64(at + 40)?,
                writable: elf.u32(at + 4)? & 2 != 0,
            };
            Some((elf.u32(at)?, segment, elf.u64(at + 48)?))
        };
        let Some((kind, segment, align)) = read() else { return cut("a program header") };
        if kind == PT_LOAD || kind == PT_DYNAMIC {
            if !elf.holds(segment.offset, segment.in_file) {
                return cut("a segment");
            }
            let last = segment.address.checked_add(segment.in_memory).filter(|last| *last <= MAX_SPAN);
            let Some(last) = last else { return format("a segment is larger than a plugin can be") };
            if segment.in_memory < segment.in_file {
                return format("a segment is larger in the file than in memory");
            }
            if kind == PT_LOAD {
                let aligned = align.is_power_of_two() && (4096..=1 << 24).contains(&align);
                if !aligned || segment.address % align != segment.offset % align || segment.address < end {
                    return format("its segments overlap or are not aligned");
                }
                end = last;
                elf.segments.push(segment);
            } else {
                dynamic = Some(segment);
            }
        }
    }
    let Some(dynamic) = dynamic else { return format("it has no dynamic table") };
    if elf.at_address(dynamic.address, dynamic.in_file) != Some(dynamic.offset) {
        return format("its dynamic table lies in no segment");
    }
    check_dynamic(&elf, &dynamic).map_err(|what| Flaw::Format(what.to_owned()))
}

/// The tables that the loader follows by address, and the places that they make it write to or call.
fn check_dynamic(elf: &Elf<'_>, dynamic: &Segment) -> Result<(), &'static str> {
    let mut entries = std::collections::BTreeMap::new();
    let mut ended = false;
    let mut needed = Vec::new();
    for i in 0..dynamic.in_file / 16 {
        let at = dynamic.offset + 16 * i;
        let (Some(tag), Some(value)) = (elf.u64(at), elf.u64(at + 8)) else { return Err("its dynamic table is cut") };
        match tag {
            0 => {
                ended = true;
                break;
            }
            1 => needed.push(value),
            // What would change how the rest is read, or run code before it was looked at, no plugin needs.
            22 => return Err("it asks for text relocations"),
            0x7fff_fffd | 0x7fff_ffff | 0x6fff_fefc | 0x6fff_fefb => return Err("it asks for filters or auditors"),
            _ => {
                entries.insert(tag, value);
            }
        }
    }
    if !ended {
        return Err("its dynamic table does not end");
    }
    let get = |tag: u64| entries.get(&tag).copied();
    let (Some(strings), Some(strings_size), Some(symbols)) = (get(5), get(10), get(6)) else {
        return Err("it has no symbols or names for them");
    };
    let Some(strings) = elf.at_address(strings, strings_size).filter(|_| strings_size > 0) else {
        return Err("the names of its symbols lie in no segment");
    };
    let last = usize::try_from(strings + strings_size - 1).ok().and_then(|at| elf.bytes.get(at));
    if last != Some(&0) {
        return Err("the names of its symbols do not end");
    }
    if needed.into_iter().chain(get(14)).any(|name| name >= strings_size) {
        return Err("the name of a library it needs lies outside its names");
    }
    if get(11).is_some_and(|size| size != 24) || get(9).is_some_and(|size| size != 24) {
        return Err("its symbols or relocations are of a size that is not ELF's");
    }
    let symbol_count = symbol_count(elf, get(4), get(0x6fff_fef5))?;
    let Some(symbols) = symbol_count.checked_mul(24).and_then(|size| elf.at_address(symbols, size)) else {
        return Err("its symbols lie in no segment");
    };
    for i in 0..symbol_count {
        let at = symbols + 24 * i;
        let (name, value, section) = (elf.u32(at), elf.u64(at + 8), elf.u16(at + 6));
        if name.is_none_or(|n| u64::from(n) >= strings_size) {
            return Err("the name of a symbol lies outside its names");
        }
        // Defined here, and no thread-local: an address in a segment.
        let kind = usize::try_from(at + 4).ok().and_then(|a| elf.bytes.get(a)).map_or(0, |info| info & 15);
        if section.is_some_and(|s| s != 0 && s < 0xff00) && kind != 6 && kind != 3 {
            let inside = |v: u64| elf.segments.iter().any(|s| v >= s.address && v <= s.address + s.in_memory);
            if !value.is_some_and(inside) {
                return Err("a symbol lies in no segment");
            }
        }
    }
    for (table, size) in [(7, 8), (23, 2)] {
        let (Some(address), Some(size)) = (get(table), get(size)) else { continue };
        let Some(first) = elf.at_address(address, size) else { return Err("its relocations lie in no segment") };
        for i in 0..size / 24 {
            let at = first + 24 * i;
            let (Some(place), Some(info)) = (elf.u64(at), elf.u64(at + 8)) else { return Err("a relocation is cut") };
            if info >> 32 >= symbol_count {
                return Err("a relocation names a symbol that there is not");
            }
            // R_X86_64_NONE and R_AARCH64_NONE write nothing.
            if info & 0xffff_ffff != 0 && !elf.writable(place, 8) {
                return Err("a relocation lies outside what can be written");
            }
        }
    }
    for (table, size) in [(25, 27), (26, 28)] {
        let (Some(address), Some(size)) = (get(table), get(size)) else { continue };
        if elf.at_address(address, size).is_none() || size % 8 != 0 {
            return Err("its constructors lie in no segment");
        }
    }
    Ok(())
}

/// How many symbols there are: the hash tables say it, in their ways.
fn symbol_count(elf: &Elf<'_>, sysv: Option<u64>, gnu: Option<u64>) -> Result<u64, &'static str> {
    let bad = "its hash table is damaged";
    if let Some(at) = sysv.and_then(|address| elf.at_address(address, 8)) {
        return elf.u32(at + 4).map(u64::from).ok_or(bad);
    }
    let at = gnu.and_then(|address| elf.at_address(address, 16)).ok_or(bad)?;
    let read = |at| elf.u32(at).ok_or(bad);
    let (buckets, first, bloom) = (u64::from(read(at)?), u64::from(read(at + 4)?), u64::from(read(at + 8)?));
    if buckets == 0 || bloom == 0 || !bloom.is_power_of_two() || buckets > 1 << 20 || bloom > 1 << 20 {
        return Err(bad);
    }
    let table = at + 16 + 8 * bloom;
    let chains = table + 4 * buckets;
    let mut last = 0;
    for i in 0..buckets {
        last = last.max(u64::from(read(table + 4 * i)?));
    }
    if last == 0 {
        return Ok(first);
    }
    if last < first {
        return Err(bad);
    }
    // The chain of the last bucket ends at an entry whose lowest bit is set.
    while read(chains + 4 * (last - first))? & 1 == 0 {
        last += 1;
    }
    Ok(last + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn library() -> Vec<u8> {
        let folder = tempfile::tempdir().expect("a folder");
        let (source, library) = (folder.path().join("a.c"), folder.path().join("a.so"));
        std::fs::write(&source, "#include <math.h>\n__attribute__((constructor)) static void up(void) {}\ndouble f(double x) { return sin(x); }\n").expect("written");
        let mut cc = std::process::Command::new("cc");
        cc.args(["-shared", "-fPIC", "-g", "-o"]).arg(&library).arg(&source).arg("-lm");
        assert!(cc.status().expect("a C compiler").success());
        std::fs::read(&library).expect("read")
    }

    #[test]
    fn whole_libraries_pass_and_every_cut_is_seen() {
        let whole = library();
        assert_eq!(check(&whole), Ok(()));
        for cut in 0..whole.len() {
            assert!(check(&whole[..cut]).is_err(), "cut to {cut} of {} bytes", whole.len());
        }
        assert!(matches!(check(b""), Err(Flaw::Truncated(_))));
        assert!(matches!(check(b"a text file"), Err(Flaw::Format(_))));
        assert!(matches!(check(&[0; 4096]), Err(Flaw::Format(_))));
    }

    #[test]
    fn no_change_of_a_byte_makes_it_panic() {
        let whole = library();
        let mut changed = whole.clone();
        for at in 0..whole.len() {
            for value in [0, 0xff, whole[at] ^ 0x10] {
                changed[at] = value;
                let _ = check(&changed);
            }
            changed[at] = whole[at];
        }
    }
}
