//! `cargo xtask c-host`: what a C author does. The header goes through every compiler here, every standard it
//! promises and every warning; hosts/c is built with plain `cc` against target/marey, shared and static, and run.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, ensure};

use crate::header;
use crate::library::{self, Profile};
use crate::shell::{has, program, read, root, say, target};

const WARNINGS: [&str; 6] = ["-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wshadow", "-Werror"];
const C: [&str; 3] = ["c11", "c17", "c2x"];
const CPP: [&str; 3] = ["c++11", "c++17", "c++20"];

pub(crate) fn run(args: &[String]) -> Result<()> {
    let profile = Profile::of(args)?;
    compile_matrix()?;
    programs(&library::build(profile)?)
}

/// The header in C and C++, in every standard, with every warning an error: twice in a file, in two files of one
/// program, with every INIT macro used.
fn compile_matrix() -> Result<()> {
    let scratch = target().join("marey/header-check");
    std::fs::create_dir_all(&scratch)?;
    let text = std::fs::read_to_string(header::path())?;
    let mut unit = String::from("#include <marey/marey.h>\n#include <marey/marey.h>\n");
    for name in header::structs(&text).iter().map(|s| &s.name) {
        let init = format!("{}_INIT", name.to_uppercase());
        if text.contains(&format!("#define {init} ")) {
            writeln!(unit, "extern {name} of_{name}; {name} of_{name} = {init};")?;
        }
    }
    writeln!(unit, "mry_str name(void);\nmry_str name(void) {{ return MRY_STR(\"a\"); }}")?;
    writeln!(
        unit,
        "int same(void);\nint same(void) {{ return MRY_VERSION > 0 && mry_abi_check(MRY_ABI_VERSION) == MRY_OK; }}"
    )?;
    let other = "#include <marey/marey.h>\nint other(void);\nint other(void) { return MRY_E_NULL < 0 ? 0 : 1; }\n";

    let compilers = [("gcc", "g++"), ("clang", "clang++")];
    let found: Vec<_> = compilers.iter().filter(|(c, cpp)| has(c) && has(cpp)).collect();
    ensure!(!found.is_empty(), "neither gcc nor clang is here; install one");
    for (c, cpp) in found {
        let runs = C.map(|std| (*c, std, "c")).into_iter().chain(CPP.map(|std| (*cpp, std, "cpp")));
        for (compiler, std, extension) in runs {
            for (name, text) in [("unit", unit.as_str()), ("other", other)] {
                let file = scratch.join(format!("{name}.{extension}"));
                std::fs::write(&file, text)?;
                let mut command = program(compiler);
                command.arg(format!("-std={std}")).args(WARNINGS).arg("-I").arg(root().join("include"));
                if extension == "c" {
                    command.arg("-Wstrict-prototypes");
                }
                read(command.arg("-c").arg(&file).arg("-o").arg(scratch.join(format!("{name}.o"))))?;
            }
            // Nothing that the header brings may clash between the files of a program.
            let objects = ["unit.o", "other.o"].map(|o| scratch.join(o));
            read(program(compiler).arg("-r").arg("-nostdlib").args(objects).arg("-o").arg(scratch.join("both.o")))?;
        }
        say(&format!("marey.h compiles clean with {c} in {} and {cpp} in {}", C.join(", "), CPP.join(", ")));
    }
    Ok(())
}

/// Builds hosts/c/creature.c against the shared and against the static library, and runs both on the bundled clip.
fn programs(marey: &Path) -> Result<()> {
    let scratch = marey.join("c-host");
    if scratch.exists() {
        std::fs::remove_dir_all(&scratch)?;
    }
    std::fs::create_dir_all(&scratch)?;
    let source = root().join("hosts/c/creature.c");
    let compile = |name: &str| -> (PathBuf, Command) {
        let (path, mut cc) = (scratch.join(name), program("cc"));
        cc.arg("-std=c11").arg("-O1").args(WARNINGS).arg("-Wstrict-prototypes").arg(&source);
        cc.arg("-I").arg(marey.join("include")).arg("-o").arg(&path);
        (path, cc)
    };

    let (shared, mut cc) = compile("creature-shared");
    read(cc.arg("-L").arg(marey.join("lib")).arg("-lmarey").arg("-Wl,-rpath,$ORIGIN/../lib"))?;
    let (fixed, mut cc) = compile("creature-static");
    let pc = std::fs::read_to_string(marey.join("lib/pkgconfig/marey.pc"))?;
    let private = pc.lines().find_map(|l| l.strip_prefix("Libs.private:")).context("marey.pc: no Libs.private")?;
    read(cc.arg(marey.join("lib/libmarey.a")).args(private.split_whitespace()))?;

    let clip = root().join("data/camel/clip.mp4");
    let mut written = Vec::new();
    for host in [&shared, &fixed] {
        let out = host.with_extension("glb");
        let said = read(program(&host.to_string_lossy()).arg(&clip).arg(&out))?;
        ensure!(said.contains("cancelled"), "{}: did not show a cancel:\n{said}", host.display());
        let glb = std::fs::read(&out).with_context(|| out.display().to_string())?;
        ensure!(glb.starts_with(b"glTF"), "{}: not a glTF binary", out.display());
        say(&format!("{}: {} bytes of glTF", host.display(), glb.len()));
        written.push(glb);
    }
    ensure!(written[0] == written[1], "the shared and the static library give different creatures");
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_header_compiles_clean_everywhere() {
        super::compile_matrix().expect("clean");
    }
}
