//! The ABI guard: the header against those of all releases that are kept in ffi/abi/history.
//!
//! abidiff (libabigail) compares two libraries by their debug information. Rust's names would drown what matters, so
//! each header is compiled into a witness: a library with an empty body for every prototype, built by `gcc -g`. Adding
//! functions and structs, and fields at the end of a struct that starts with struct_size, is allowed; all else is a
//! break, and fails. abidiff 2.2 can be told to pass over fields added at the end, but then passes over fields that
//! changed in place too; so today's structs are cut to the fields they had, and nothing is passed over. That the guard
//! guards is tested with breaks made on purpose.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};

use crate::c_host::{Build, fresh, host, is_glb};
use crate::header;
use crate::sample::Sample;
use crate::shell::{program, read, root, say};

/// The kept headers with the versions they are of, the oldest first.
fn history() -> Result<Vec<(String, PathBuf)>> {
    let folder = root().join("ffi/abi/history");
    let mut kept = Vec::new();
    for entry in std::fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
        let entry = entry?;
        kept.push((entry.file_name().to_string_lossy().into_owned(), entry.path()));
    }
    kept.sort_by_key(|(version, _)| version.split('.').map(|n| n.parse().unwrap_or(0)).collect::<Vec<u32>>());
    // Another minor version before 1.0, another major one after, is another ABI.
    let [major, minor, _] = header::version();
    let same = |version: &str| {
        let mut parts = version.split('.');
        parts.next() == Some(major) && (major != "0" || parts.next() == Some(minor))
    };
    kept.retain(|(version, _)| same(version));
    Ok(kept)
}

/// Today's header breaks none that is kept.
pub(crate) fn check() -> Result<()> {
    let scratch = fresh("abi")?;
    let today = std::fs::read_to_string(header::path())?;
    for (version, folder) in history()? {
        let kept = std::fs::read_to_string(folder.join("marey.h"))?;
        if let Some(breaks) = difference(&scratch, &kept, &today)? {
            bail!("the header breaks hosts of {version}:\n{breaks}");
        }
        say(&format!("abidiff: hosts of {version} are not broken"));
    }
    Ok(())
}

/// The oldest kept host, built with the oldest kept header, runs on today's library.
pub(crate) fn old_host(prefix: &Path, sample: &Sample) -> Result<()> {
    let Some((version, folder)) = history()?.into_iter().next() else { return Ok(()) };
    let scratch = fresh("old-host")?;
    std::fs::create_dir_all(scratch.join("include/marey"))?;
    std::fs::copy(folder.join("marey.h"), scratch.join("include/marey/marey.h"))?;
    let (program, glb) = (scratch.join("creature"), scratch.join("creature.glb"));
    let (source, include) = (folder.join("creature.c"), scratch.join("include"));
    Build { source: &source, include: &include, prefix, fixed: false, flags: &[] }.run(&program)?;
    read(host(&program).args([&sample.clip, &glb, &sample.strokes]))?;
    is_glb(&glb)?;
    say(&format!("a host of {version} runs on today's library"));
    Ok(())
}

/// What abidiff says of a host of `old` on a library of `new`, when it says anything.
fn difference(scratch: &Path, old: &str, new: &str) -> Result<Option<String>> {
    let (a, b) = (witness(scratch, "old", old)?, witness(scratch, "new", &without_growth(old, new))?);
    let output = program("abidiff").arg("--no-added-syms").arg(a).arg(b).output().context("abidiff")?;
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    Ok((!output.status.success()).then(|| said.into_owned()))
}

/// `new` with the structs of `old` cut to as many fields as they had there.
fn without_growth(old: &str, new: &str) -> String {
    let mut new = header::without_comments(new);
    for kept in header::structs(old).iter().filter(|s| s.is_sized()) {
        let open = format!("typedef struct {} {{", kept.name);
        let Some(body) = new.find(&open).map(|at| at + open.len()) else { continue };
        let Some(end) = new[body..].find('}').map(|at| body + at) else { continue };
        let fields: String = new[body..end].split_inclusive(';').take(kept.field_count()).collect();
        new.replace_range(body..end, &(fields + "\n"));
    }
    new
}

/// A library with an empty body for every prototype of the header.
fn witness(scratch: &Path, name: &str, header: &str) -> Result<PathBuf> {
    let folder = scratch.join(name);
    std::fs::create_dir_all(folder.join("marey"))?;
    std::fs::write(folder.join("marey/marey.h"), header)?;
    let mut code = String::from("#include <marey/marey.h>\n");
    let prototypes = header::prototypes(header);
    ensure!(prototypes.len() > 50, "{name}: {} prototypes", prototypes.len());
    for prototype in prototypes {
        let void = prototype.starts_with("void ") && !prototype.starts_with("void *");
        writeln!(code, "{prototype} {{ {} }}", if void { "" } else { "return 0;" })?;
    }
    // Types that are never passed alone, and enumerators.
    writeln!(code, "mry_status_code status_codes(void) {{ return MRY_OK; }}")?;
    let (source, library) = (folder.join("witness.c"), folder.join("libwitness.so"));
    std::fs::write(&source, code)?;
    let mut cc = program("cc");
    cc.args(["-std=c11", "-g", "-w", "-shared", "-fPIC", "-Wl,-soname,libwitness.so", "-I"]).arg(&folder);
    read(cc.arg(&source).arg("-o").arg(&library))?;
    Ok(library)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether hosts of today's header would be broken by `change`.
    fn breaks(name: &str, change: impl FnOnce(&str) -> String) -> bool {
        let today = std::fs::read_to_string(header::path()).expect("the header");
        let changed = change(&today);
        assert_ne!(today, changed, "{name}: nothing was changed");
        let scratch = fresh(&format!("abi-test-{name}")).expect("a folder");
        difference(&scratch, &today, &changed).expect("abidiff").is_some()
    }

    #[test]
    fn a_break_made_on_purpose_is_caught() {
        crate::system::ensure().expect("programs");
        assert!(breaks("field-grown", |h| h.replacen("  uint32_t threads;", "  uint64_t threads;", 1)));
        assert!(breaks("field-inside", |h| h.replacen(
            "  uint32_t threads;",
            "  uint32_t cores;\n  uint32_t threads;",
            1
        )));
        assert!(breaks("argument", |h| h.replacen(
            "mry_motion_get_bone(mry_context *context,",
            "mry_motion_get_bone(mry_context *context, int32_t more,",
            1
        )));
        assert!(breaks("function-gone", |h| {
            let at = h.find("\nMRY_API\nmry_status mry_clip_get_time(").expect("there");
            let end = at + h[at..].find(';').expect("its end") + 1;
            h[..at].to_owned() + &h[end..]
        }));
        assert!(breaks("status-renumbered", |h| h.replacen("MRY_E_STALE = -104", "MRY_E_STALE = -119", 1)));
    }

    #[test]
    fn growing_is_no_break() {
        crate::system::ensure().expect("programs");
        assert!(!breaks("function-new", |h| {
            h.replacen("\nMRY_API\n", "\nMRY_API\nmry_status mry_new_function(mry_context *context);\n\nMRY_API\n", 1)
        }));
        assert!(!breaks("field-at-end", |h| h.replacen("} mry_track_desc;", "  uint64_t more;\n} mry_track_desc;", 1)));
    }
}
