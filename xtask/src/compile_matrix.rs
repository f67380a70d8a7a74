//! The header's compile matrix: every compiler here, every standard it promises, every warning an error.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Result, ensure};

use crate::header;
use crate::shell::{has, program, read, root, say, target};

pub(crate) const WARNINGS: [&str; 6] = ["-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wshadow", "-Werror"];
const C: [&str; 3] = ["c11", "c17", "c2x"];
const CPP: [&str; 3] = ["c++11", "c++17", "c++20"];
/// Standards of marey.hpp.
const WRAPPER: [&str; 2] = ["c++17", "c++20"];

/// The header in C and C++, in every standard, with every warning an error: twice in a file, in two files of one
/// program, with every INIT macro used.
pub(crate) fn run() -> Result<()> {
    let scratch = target().join("c/header-check");
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
        wrapper(cpp, &scratch)?;
    }
    Ok(())
}

/// marey.hpp from C++17 on, with exceptions and without, alone and in two files of one program. Every function is
/// instantiated by pointing at it.
fn wrapper(compiler: &str, scratch: &Path) -> Result<()> {
    let text = std::fs::read_to_string(root().join("include/marey/marey.hpp"))?;
    let unit = format!("#include <marey/marey.hpp>\n#include <marey/marey.hpp>\n{}", every_method(&text));
    let other = "#include <marey/marey.hpp>\nbool other();\nbool other() { return marey::version().empty(); }\n";
    for std in WRAPPER {
        for errors in ["-fexceptions", "-fno-exceptions"] {
            for (name, text) in [("wrapper", unit.as_str()), ("wrapper-other", other)] {
                let file = scratch.join(format!("{name}.cpp"));
                std::fs::write(&file, text)?;
                let mut command = program(compiler);
                command.args([&format!("-std={std}"), errors]).args(WARNINGS).arg("-I").arg(root().join("include"));
                read(command.arg("-c").arg(&file).arg("-o").arg(scratch.join(format!("{name}.o"))))?;
            }
            let objects = ["wrapper.o", "wrapper-other.o"].map(|o| scratch.join(o));
            read(program(compiler).arg("-r").arg("-nostdlib").args(objects).arg("-o").arg(scratch.join("both.o")))?;
        }
    }
    say(&format!("marey.hpp compiles clean with {compiler} in {}, with exceptions and without", WRAPPER.join(", ")));
    Ok(())
}

/// A use of every method of the wrapper's classes: `auto x1 = &marey::clip::info;`.
fn every_method(header: &str) -> String {
    let mut uses = String::new();
    let (mut class, mut public) = (None, false);
    for line in header.lines() {
        if let Some(rest) = line.strip_prefix("class ") {
            class = rest.split([' ', ':']).find(|w| !w.is_empty() && !w.starts_with("[["));
        } else if line.starts_with("};") || line.starts_with("struct ") {
            class = None;
        } else if line.starts_with("public:") || line.starts_with("private:") {
            public = line.starts_with("public:");
        } else if let (Some(class), true, Some(rest)) = (class, public, line.strip_prefix("  result<"))
            && let Some((head, _)) = rest.split_once('(')
            && let Some(name) = head.split_whitespace().next_back()
        {
            let n = uses.lines().count();
            uses += &format!(
                "extern const void *of_{n}; static auto use_{n} = &marey::{class}::{name}; const void *of_{n} = &use_{n};\n"
            );
        }
    }
    uses
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_method_of_the_wrapper_is_used() {
        let header = std::fs::read_to_string(super::root().join("include/marey/marey.hpp")).expect("the wrapper");
        let uses = super::every_method(&header);
        for method in ["clip::map_frame", "rig::set_stroke", "job::wait_for", "context::start_export", "creature::pose"]
        {
            assert!(uses.contains(&format!("&marey::{method};")), "{method}");
        }
    }
}
