//! What an author of plugins and a person who uses one type: from `marey plugin new` to a tracked clip.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A run of the program that sees no plugins but those it is told of.
fn marey(home: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_marey"));
    command.args(args).env_remove("MAREY_PLUGIN_PATH").env_remove("XDG_DATA_HOME").env_remove("XDG_CACHE_HOME");
    command.env("HOME", home).output().expect("runs")
}

fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn good(output: Output) -> Output {
    assert!(output.status.success(), "{}{}", out(&output), err(&output));
    output
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn c_plugin(source: &str, flags: &[&str], to: &Path) {
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-O2", "-std=gnu11", "-fvisibility=hidden"]).args(flags);
    cc.arg("-I").arg(root().join("include")).arg(root().join("plugins").join(source)).arg("-o").arg(to);
    assert!(cc.status().expect("a C compiler").success());
}

/// The bundled clip and its strokes.
fn camel() -> (String, String) {
    let folder = root().join("data/camel");
    let at = |name: &str| folder.join(name).display().to_string();
    (at("clip.mp4"), at("strokes.json"))
}

fn tracks(file: &Path) -> usize {
    let motion: Value = serde_json::from_slice(&std::fs::read(file).expect("written")).expect("JSON");
    motion["tracks"].as_array().expect("tracks").len()
}

#[test]
fn from_a_new_project_to_a_tracked_clip() {
    let home = tempfile::tempdir().expect("a folder");
    let project = home.path().join("my-tracker");
    let shown = project.display().to_string();
    good(marey(home.path(), &["plugin", "new", "my-tracker", "-o", &shown]));
    let again = marey(home.path(), &["plugin", "new", "my-tracker", "-o", &shown]);
    assert_eq!(again.status.code(), Some(3), "{}", err(&again));
    // One folder for all runs of this test, so that the sdk's dependencies are built once.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("new-plugin");
    for task in ["test", "build"] {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.arg(task).current_dir(&project).env("CARGO_TARGET_DIR", &target);
        // Built as its author would, not as this test is.
        let said = cargo.env_remove("RUSTFLAGS").output().expect("cargo");
        good(said);
    }
    let library = target.join("debug/libmy_tracker.so").display().to_string();
    let checked = good(marey(home.path(), &["plugin", "check", &library, "--json"]));
    let report: Value = serde_json::from_str(&out(&checked)).expect("JSON");
    assert_eq!(report["passed"], true, "{report}");
    let doors: Vec<&Value> = report["plugins"].as_array().expect("a list").iter().map(|p| &p["door"]).collect();
    assert_eq!(doors, ["c", "rust"], "the suite goes through both doors");
    let (clip, strokes) = camel();
    let motion = home.path().join("motion.json");
    let to = motion.display().to_string();
    let id = "org.example.my-tracker";
    let track = ["track", &clip, "--strokes", &strokes, "--plugin", &library, "--tracker", id, "-o", &to];
    good(marey(home.path(), &track));
    let plain = std::fs::read(&motion).expect("written");
    assert!(tracks(&motion) > 3);
    let eased = [&track[..], &["--set", "org.example.my-tracker:ease=1"]].concat();
    good(marey(home.path(), &eased));
    assert_ne!(std::fs::read(&motion).expect("written"), plain, "the parameter counts");
    let odd = [&track[..], &["--set", "org.example.my-tracker:ease=7"]].concat();
    let odd = marey(home.path(), &odd);
    assert_eq!(odd.status.code(), Some(2), "{}", err(&odd));
    assert!(err(&odd).contains("from 0 to 1"), "{}", err(&odd));
}

#[test]
fn names_that_are_none_are_refused() {
    let home = tempfile::tempdir().expect("a folder");
    for name in ["", "My Plugin", "../up", "1st", "ends-"] {
        let said = marey(home.path(), &["plugin", "new", name]);
        assert_eq!(said.status.code(), Some(2), "{name}: {}", err(&said));
    }
}

#[test]
fn installed_plugins_are_listed_and_used_and_bad_ones_say_why() {
    let home = tempfile::tempdir().expect("a folder");
    let folder = home.path().join(".local/share/marey/plugins");
    std::fs::create_dir_all(&folder).expect("a folder");
    let empty = good(marey(home.path(), &["plugin", "list"]));
    assert!(out(&empty).contains("no plugins"), "{}", out(&empty));
    c_plugin("example-c/nearest.c", &[], &folder.join("nearest.so"));
    c_plugin("bad/bad.c", &["-DEXIT_ON_LOAD"], &folder.join("exits.so"));
    c_plugin("bad/bad.c", &["-DCREATE_FAILS"], &folder.join("fails.so"));
    std::fs::write(folder.join("text.so"), "no library").expect("written");
    let listed = good(marey(home.path(), &["plugin", "list", "--json"]));
    let report: Value = serde_json::from_str(&out(&listed)).expect("JSON");
    let id = "org.marey.example-c.nearest";
    assert_eq!(report["plugins"].as_array().expect("a list").len(), 1, "{report}");
    assert_eq!(report["plugins"][0]["id"], id);
    assert_eq!(report["plugins"][0]["parameters"][0]["unit"], "px");
    assert_eq!(report["failures"].as_array().expect("a list").len(), 3, "{report}");
    let text = good(marey(home.path(), &["plugin", "list"]));
    for part in ["exit code 0", "no model file", "no ELF"] {
        assert!(err(&text).contains(part), "{part}: {}", err(&text));
    }
    let (clip, strokes) = camel();
    let motion = home.path().join("motion.json");
    let to = motion.display().to_string();
    good(marey(home.path(), &["track", &clip, "--strokes", &strokes, "--tracker", id, "-o", &to]));
    assert!(tracks(&motion) > 3);
    let unknown = marey(home.path(), &["track", &clip, "--strokes", &strokes, "--tracker", "org.none", "-o", &to]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(err(&unknown).contains(id), "it says what there is: {}", err(&unknown));
    let other = marey(home.path(), &["segment", &clip, "--strokes", &strokes, "--segmenter", id, "-o", &to]);
    assert!(err(&other).contains("is a tracker, not a segmenter"), "{}", err(&other));
}

#[test]
fn a_segmenter_in_rust_cuts_out_what_it_is_told_and_a_panic_is_one_line() {
    let home = tempfile::tempdir().expect("a folder");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--locked", "--package", "marey-plugin-bad"]).current_dir(root());
    good(cargo.output().expect("cargo"));
    // Beside the program that is tested, whatever folder things are built in.
    let beside = Path::new(env!("CARGO_BIN_EXE_marey")).with_file_name("libmarey_plugin_bad.so");
    let library = beside.display().to_string();
    let (clip, strokes) = camel();
    let folder = home.path().join("masks");
    let to = folder.display().to_string();
    let id = "org.marey.bad.panics-in-create";
    let plugin = ["--plugin", &library];
    let segment = ["segment", &clip, "--strokes", &strokes, "--tracker", "paper", "--segmenter", id, "-o", &to];
    let panics = [&segment[..], &plugin, &["--set", "org.marey.bad.panics-in-create:panic=1"]].concat();
    let said = marey(home.path(), &panics);
    assert_eq!(said.status.code(), Some(4), "{}", err(&said));
    assert_eq!(err(&said).lines().count(), 1, "{}", err(&said));
    assert!(err(&said).contains("in create") && err(&said).contains("lib.rs:") && !folder.exists(), "{}", err(&said));
    good(marey(home.path(), &[&segment[..], &plugin].concat()));
    assert!(folder.join("00000.png").is_file() && folder.join("report.json").is_file());
    let report: Value =
        serde_json::from_slice(&std::fs::read(folder.join("report.json")).expect("read")).expect("JSON");
    assert!(report.to_string().contains(id), "the report says who did it: {report}");
}

#[test]
fn the_suite_says_in_plain_words_what_is_wrong() {
    let home = tempfile::tempdir().expect("a folder");
    let file = home.path().join("bad.so");
    let shown = file.display().to_string();
    for (flag, code, says) in [
        ("-DNOT_A_NUMBER", 3, "NaN"),
        ("-DMISSING_FRAME", 3, "did not give limb `bar`"),
        ("-DDEAF", 3, "went on working"),
        ("-DREFUSES_STATE", 3, "does not load what it saved"),
        ("-DCRASH", 4, "signal 11"),
        ("-DOTHER_ABI", 3, "version 99.0"),
    ] {
        c_plugin("bad/bad.c", &[flag], &file);
        let said = marey(home.path(), &["plugin", "check", &shown]);
        let text = out(&said) + &err(&said);
        assert_eq!(said.status.code(), Some(code), "{flag}: {text}");
        assert!(text.contains(says), "{flag}: {text}");
    }
    c_plugin("example-c/nearest.c", &[], &file);
    good(marey(home.path(), &["plugin", "check", &shown]));
    let none = marey(home.path(), &["plugin", "check", "/nowhere.so"]);
    assert_eq!(none.status.code(), Some(2), "{}", err(&none));
}

#[test]
fn the_guide_does_what_it_says() {
    let home = tempfile::tempdir().expect("a folder");
    let pages = ["README.md", "c.md", "publishing.md"];
    let mut script = String::new();
    for page in pages {
        let text = std::fs::read_to_string(root().join("docs/plugins").join(page)).expect("a page");
        let blocks = text.split("```sh\n").skip(1).filter_map(|rest| rest.split("\n```").next());
        for block in blocks {
            script += block;
            script.push('\n');
        }
    }
    assert!(script.contains("plugin new") && script.contains("sha256sum"), "{script}");
    let programs = Path::new(env!("CARGO_BIN_EXE_marey")).parent().expect("a folder").to_owned();
    let cargo = Path::new(env!("CARGO")).parent().expect("a folder").to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([programs, cargo].into_iter().chain(std::env::split_paths(&path))).expect("a PATH");
    let (clip, strokes) = camel();
    let full = |path: PathBuf| path.canonicalize().expect("a file");
    // Cargo and rustup keep what they have in the real home.
    let real = PathBuf::from(std::env::var_os("HOME").unwrap_or_default());
    let mut shell = Command::new("sh");
    shell.args(["-e", "-c", &script]).current_dir(home.path()).env("HOME", home.path()).env("PATH", path);
    shell.env("CLIP", full(clip.into())).env("STROKES", full(strokes.into()));
    shell.env("INCLUDE", full(root().join("include")));
    shell.env("EXAMPLE", full(root().join("plugins/example-c/nearest.c")));
    for (name, folder) in [("CARGO_HOME", ".cargo"), ("RUSTUP_HOME", ".rustup")] {
        shell.env(name, std::env::var_os(name).map_or_else(|| real.join(folder), PathBuf::from));
    }
    // What the project depends on is built once for both tests that build one.
    shell.env("CARGO_BUILD_BUILD_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).join("new-plugin"));
    for name in ["RUSTFLAGS", "CARGO_TARGET_DIR", "MAREY_PLUGIN_PATH", "XDG_DATA_HOME", "XDG_CACHE_HOME"] {
        shell.env_remove(name);
    }
    let said = good(shell.output().expect("a shell"));
    assert!(out(&said).contains("org.example.my-tracker  MyTracker"), "{}", out(&said));
}
