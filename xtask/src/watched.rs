//! C programs that are watched while they run: hosts/c and the random calls of tests/abi/soak.c, under AddressSanitizer
//! with UBSan and its leak check, and under valgrind, which sees into the library too.

use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};

use crate::c_host::{Build, fresh, host};
use crate::library::{self, Profile};
use crate::sample::{self, Sample};
use crate::shell::{self, program, read, root, say};

const SANITIZE: [&str; 3] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"];
/// Calls in the tests; `cargo xtask soak` makes a million.
const SANITIZED_CALLS: &str = "20000";
const VALGRIND_CALLS: &str = "1500";
const SEED: &str = "1";

pub(crate) fn run(prefix: &Path, sample: &Sample) -> Result<()> {
    let folder = fresh("watched")?;
    let creature = build(prefix, &folder, &root().join("hosts/c/creature.c"), &SANITIZE)?;
    let glb = folder.join("creature.glb");
    read(host(&creature).args([&sample.clip, &glb, &sample.strokes]))?;
    let driver = build(prefix, &folder, &root().join("tests/abi/soak.c"), &SANITIZE)?;
    let said = read(&mut soak(&driver, sample, &folder, SEED, SANITIZED_CALLS)?)?;
    say(&format!("AddressSanitizer and UBSan have nothing to say of hosts/c and of {}", said.trim()));
    not_sanitized(&prefix.join("lib/libmarey.so"))?;

    let creature = build(prefix, &folder, &root().join("hosts/c/creature.c"), &[])?;
    read(valgrind().arg(creature).args([&sample.clip, &glb, &sample.strokes]))?;
    let driver = build(prefix, &folder, &root().join("tests/abi/soak.c"), &[])?;
    let plain = soak(&driver, sample, &folder, SEED, VALGRIND_CALLS)?;
    let said = read(valgrind().current_dir(folder.join("out")).arg(plain.get_program()).args(plain.get_args()))?;
    say(&format!("valgrind finds no error and no leak in hosts/c and in {}", said.trim()));
    Ok(())
}

/// `cargo xtask soak [CALLS [SEED]]`: the random calls by the million, under the sanitizers.
pub(crate) fn long(args: &[String]) -> Result<()> {
    let calls = args.first().map_or("1000000", String::as_str);
    let seed = args.get(1).map_or(SEED, String::as_str);
    ensure!(args.len() < 3 && calls.parse::<u64>().is_ok(), "usage: cargo xtask soak [CALLS [SEED]]");
    let prefix = fresh("prefix")?;
    library::build(Profile::Release, &prefix)?;
    let (folder, sample) = (fresh("watched")?, sample::write(&fresh("sample")?)?);
    let driver = build(&prefix, &folder, &root().join("tests/abi/soak.c"), &SANITIZE)?;
    shell::run(&mut soak(&driver, &sample, &folder, seed, calls)?)
}

fn build(prefix: &Path, folder: &Path, source: &Path, flags: &[&str]) -> Result<PathBuf> {
    let to = folder.join(source.file_stem().unwrap_or_default());
    Build { source, include: &prefix.join("include"), prefix, fixed: false, flags }.run(&to)?;
    Ok(to)
}

fn soak(driver: &Path, sample: &Sample, folder: &Path, seed: &str, calls: &str) -> Result<std::process::Command> {
    let out = folder.join("out");
    std::fs::create_dir_all(&out)?;
    let mut command = host(driver);
    // Names that are no paths of anybody's are written to, too, where it runs.
    command.current_dir(&out).args([&sample.clip, &sample.strokes, &out]).args([seed, calls]);
    Ok(command)
}

/// Leaks and errors are failures. What is still reachable at the end is what the C++ runtime and Rust's keep for ever.
fn valgrind() -> std::process::Command {
    let mut command = program("valgrind");
    command.args(["--quiet", "--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=definite,indirect"]);
    command.args(["--show-leak-kinds=definite,indirect", "--fair-sched=yes"]);
    command
}

/// The library that is installed carries no sanitizer.
fn not_sanitized(library: &Path) -> Result<()> {
    let needed = read(program("nm").args(["--dynamic", "--undefined-only"]).arg(library))?;
    ensure!(!needed.contains("__asan") && !needed.contains("__ubsan"), "{}: sanitized", library.display());
    Ok(())
}
