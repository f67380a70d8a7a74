//! The Rust mirror of `plugin.h` has its structs, field for field, and its numbers: asked of a C compiler.

use std::fmt::Write as _;
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::process::Command;

use marey_plugin::raw;

fn header_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../include")
}

/// The statements that print C's view, and what Rust says they should print.
struct Asked {
    statements: String,
    expected: String,
}

macro_rules! ask {
    ($asked:expr, $($rust:ident as $c:literal { $($field:ident),+ $(,)? })+) => {$(
        let _ = writeln!($asked.statements, "printf(\"{0} %zu\\n\", sizeof({0}));", $c);
        let _ = writeln!($asked.expected, "{} {}", $c, size_of::<raw::$rust>());
        $(
            let field = stringify!($field);
            let _ = writeln!(
                $asked.statements,
                "printf(\"{0}.{1} %zu %zu\\n\", offsetof({0}, {1}), sizeof((({0} *)0)->{1}));", $c, field
            );
            let size = size_of_field(|t: &raw::$rust| &t.$field);
            let _ = writeln!($asked.expected, "{}.{} {} {}", $c, field, offset_of!(raw::$rust, $field), size);
        )+
        // Every byte belongs to a listed field, so that none was forgotten and none is implicit padding.
        let listed: usize = [$(size_of_field(|t: &raw::$rust| &t.$field)),+].iter().sum();
        assert_eq!(listed, size_of::<raw::$rust>(), "{}", $c);
    )+};
}

fn size_of_field<T, F>(_: impl Fn(&T) -> &F) -> usize {
    size_of::<F>()
}

macro_rules! ask_numbers {
    ($asked:expr, $($name:ident),+ $(,)?) => {$(
        let name = stringify!($name);
        let _ = writeln!($asked.statements, "printf(\"{0} %lld\\n\", (long long)MRY_PLUGIN_{0});", name);
        let _ = writeln!($asked.expected, "{} {}", name, i64::from(raw::$name));
    )+};
}

#[test]
fn the_mirror_is_the_header() {
    let mut asked = Asked { statements: String::new(), expected: String::new() };
    ask! { asked,
        Error as "mry_plugin_error" { struct_size, reserved0, message }
        Point as "mry_plugin_point" { x, y }
        Clip as "mry_plugin_clip" { struct_size, width, height, reserved0, frame_count, fps }
        Frame as "mry_plugin_frame" { struct_size, width, height, stride_bytes, pixels, token }
        Limb as "mry_plugin_limb" { label, side, parent, point_count, flags }
        Stroke as "mry_plugin_stroke" { points, frame, limb, point_count, facing, reserved0 }
        Paint as "mry_plugin_paint" { points, frame, point_count, foreground, radius, reserved0 }
        Painted as "mry_plugin_painted" { pixels, frame }
        Rig as "mry_plugin_rig" {
            struct_size, limb_count, limbs, strokes, paints, painted, stroke_count, paint_count, painted_count, reserved0,
        }
        Track as "mry_plugin_track" { label, points, visible, confidence, point_count, reserved0 }
        Motion as "mry_plugin_motion" { struct_size, track_count, tracks }
        Mesh as "mry_plugin_mesh" { struct_size, point_count, points, triangles, triangle_count, reserved0 }
        Handle as "mry_plugin_handle" { kind, reserved0, a, b }
        Job as "mry_plugin_job" {
            struct_size, reserved0, data, progress, get_frame, release_frame, put_stroke, put_mask,
        }
        Host as "mry_plugin_host" {
            struct_size, abi_major, abi_minor, reserved0, name, version, data, log, get_extension,
        }
        Parameter as "mry_plugin_parameter" {
            struct_size, kind, id, label, about, group, unit, low, high, default_value, step, choices, default_text,
            visible_if, visible_value, choice_count, flags,
        }
        Value as "mry_plugin_value" { id, number, text }
        Descriptor as "mry_plugin_descriptor" {
            struct_size, kind, id, name, vendor, version, about, parameters, parameter_count, state_version,
        }
        Instance as "mry_plugin_instance" {
            struct_size, reserved0, data, destroy, track, segment, bind, solve, unbind, get_extension,
        }
        Entry as "mry_plugin_entry" {
            struct_size, abi_major, abi_minor, reserved0, init, get_count, get_descriptor, create,
        }
        State1 as "mry_plugin_state_1" { struct_size, reserved0, save, load }
    }
    ask_numbers! { asked,
        ABI_MAJOR, ABI_MINOR, OK, CANCELLED, E_INVALID, E_FAILED, E_UNSUPPORTED, E_PANICKED, E_POISONED,
        SIDE_UNKNOWN, SIDE_NEAR, SIDE_FAR, SIDE_MID, LIMB_ROOTED_AT_START, LIMB_TERMINAL,
        FACING_UNKNOWN, FACING_TOWARD, FACING_AWAY, HANDLE_POINT, HANDLE_BONE, CONTINUE, CANCEL,
        LOG_ERROR, LOG_WARNING, LOG_INFO, NUMBER, WHOLE, SWITCH, CHOICE, TEXT, FILE, ADVANCED, HIDDEN, LOGARITHMIC,
        TRACKER, SEGMENTER, DEFORMER,
    }
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let (source, program) = (folder.join("layout.c"), folder.join("layout"));
    let text = format!(
        "#include <marey/plugin.h>\n#include <stdio.h>\nint main(void) {{\n{}return 0;\n}}\n",
        asked.statements
    );
    std::fs::write(&source, text).expect("written");
    let strict = ["-std=c11", "-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wstrict-prototypes", "-Werror"];
    let mut built = Command::new("cc");
    built.args(strict).arg("-I").arg(header_folder()).arg(&source).arg("-o").arg(&program);
    assert!(built.status().expect("a C compiler").success());
    let said = Command::new(&program).output().expect("runs").stdout;
    assert_eq!(String::from_utf8_lossy(&said), asked.expected);
}

#[test]
fn the_header_is_clean_c_and_cpp() {
    let compilers = [("cc", "c", "c11"), ("cc", "c", "c17"), ("c++", "c++", "c++11"), ("c++", "c++", "c++20")];
    let source = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("alone.c");
    std::fs::write(&source, "#include <marey/plugin.h>\nint alone(void);\nint alone(void) { return 0; }\n")
        .expect("written");
    for (compiler, language, standard) in compilers {
        let mut command = Command::new(compiler);
        command.args(["-Wall", "-Wextra", "-pedantic", "-Wconversion", "-Wshadow", "-Werror", "-fsyntax-only"]);
        command.args(["-x", language]).arg(format!("-std={standard}")).arg("-I").arg(header_folder());
        let Ok(status) = command.arg(&source).status() else {
            assert_eq!(compiler, "c++", "a C compiler is needed");
            continue;
        };
        assert!(status.success(), "{compiler} -std={standard}");
    }
}
