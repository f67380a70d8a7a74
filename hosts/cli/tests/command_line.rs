//! The command line as a user and a farm's scheduler meet it: exit codes, one-line errors, reports, cancels.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name)
}

fn command() -> Command {
    Command::new(env!("CARGO_BIN_EXE_marey"))
}

fn marey(args: &[&str]) -> Output {
    command().args(args).output().unwrap()
}

/// The one line of a failure.
fn fails(args: &[&str], exit_code: i32) -> String {
    let output = marey(args);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(exit_code), "{args:?}: {said}");
    assert!(output.stdout.is_empty(), "{args:?}: a failure leaves stdout to reports");
    assert_eq!(said.lines().count(), 1, "{args:?}: {said}");
    said
}

fn report(args: &[&str]) -> Value {
    let output = marey(args);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?}: {said}");
    assert!(said.is_empty(), "no bar where stderr is no terminal: {said}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), 1, "one report");
    serde_json::from_str(&text).unwrap()
}

fn camel() -> (String, String) {
    let name = |p: PathBuf| p.to_str().unwrap().to_owned();
    (name(data("camel/clip.mp4")), name(data("camel/strokes.json")))
}

#[test]
fn bad_use_is_2_and_says_what_is_missing() {
    let (clip, strokes) = camel();
    assert!(fails(&["track"], 2).contains("--strokes"));
    assert!(fails(&["fly"], 2).contains("fly"));
    assert!(fails(&["info", &clip, "--threads", "many"], 2).contains("many"));
    assert!(fails(&["info", &clip, "--threads", "100000"], 2).contains("100000"));
    let unknown = fails(&["track", &clip, "--strokes", &strokes, "-o", "m.json", "--tracker", "nobody"], 2);
    assert!(unknown.contains("nobody") && unknown.contains("space-time"), "{unknown}");
    assert!(!Path::new("m.json").exists());
    let nothing = marey(&[]);
    assert_eq!(nothing.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&nothing.stderr).contains("Examples:"), "who types nothing wants the help");
}

#[test]
fn help_and_version_are_no_mistakes() {
    for args in [&["--help"][..], &["--version"], &["creature", "--help"]] {
        let output = marey(args);
        assert!(output.status.success() && !output.stdout.is_empty() && output.stderr.is_empty(), "{args:?}");
    }
    let help = String::from_utf8(marey(&["creature", "--help"]).stdout).unwrap();
    assert!(help.contains("--obj") && help.contains("marey creature horse.mp4"), "{help}");
}

#[test]
fn bad_input_is_3_and_names_the_file() {
    let (clip, strokes) = camel();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let out = path("out");
    assert!(fails(&["info", "/no/such/clip.mp4"], 3).contains("/no/such/clip.mp4"));
    assert!(fails(&["track", &clip, "--strokes", "/no/such.json", "-o", &out], 3).contains("/no/such.json"));
    std::fs::write(path("text.mp4"), "this is no film").unwrap();
    assert!(fails(&["info", &path("text.mp4")], 3).contains("text.mp4"));
    std::fs::write(path("empty.mp4"), "").unwrap();
    assert!(fails(&["info", &path("empty.mp4")], 3).contains("empty.mp4"));
    std::fs::create_dir(path("nothing")).unwrap();
    assert!(fails(&["info", &path("nothing")], 3).contains("nothing"));

    let good = std::fs::read_to_string(&strokes).unwrap();
    let changed = [
        ("[400, 224]", "[40, 22]", "far outside"),
        ("[400, 224]", "[800, 448]", "800x448"),
        ("\"version\": 1", "\"version\": 9", "version 9"),
        ("\"frame\": 24", "\"frame\": 2400", "2400"),
        ("\"label\": \"tail\"", "\"label\": \"trunk\"", "`tail`"),
        ("[121, 94]", "[null, 94]", "not readable"),
    ];
    for (from, to, expected) in changed {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "the bundled strokes have {from}");
        std::fs::write(path("bad.json"), text).unwrap();
        for command in ["track", "segment", "creature"] {
            let said = fails(&[command, &clip, "--strokes", &path("bad.json"), "-o", &out], 3);
            assert!(said.contains("bad.json") && said.contains(expected), "{said}");
        }
    }
    assert!(!Path::new(&out).exists());
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_work() {
    let (clip, strokes) = camel();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let began = Instant::now();
    let said = fails(&["track", &clip, "--strokes", &strokes, "-o", &path("missing/m.json")], 3);
    assert!(said.contains("missing"), "{said}");
    assert!(fails(&["track", &clip, "--strokes", &strokes, "-o", &path("")], 3).contains("folder"));
    std::fs::write(path("file"), "mine").unwrap();
    std::fs::create_dir(path("full")).unwrap();
    std::fs::write(path("full/creature.glb"), "mine").unwrap();
    for target in ["file", "full"] {
        let said = fails(&["creature", &clip, "--strokes", &strokes, "-o", &path(target)], 3);
        assert!(said.contains(target), "{said}");
    }
    assert!(began.elapsed() < Duration::from_secs(5), "{:?}", began.elapsed());
    assert_eq!(std::fs::read_to_string(path("full/creature.glb")).unwrap(), "mine");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left beside them");
}

#[test]
fn info_says_what_a_clip_is() {
    let (clip, _) = camel();
    let report = report(&["info", &clip, "--json"]);
    assert_eq!(report["command"], "info");
    assert_eq!((&report["clip"]["width"], &report["clip"]["height"]), (&400.into(), &224.into()));
    assert_eq!((&report["clip"]["frames"], &report["clip"]["source"]), (&36.into(), &"mp4".into()));
    assert!(report["clip"]["fps"].as_f64().unwrap() > 1.0 && report["warnings"].is_array());
    let text = String::from_utf8(marey(&["info", &clip]).stdout).unwrap();
    assert!(text.contains("400x224") && text.contains("36 frames"), "{text}");
}

#[test]
fn track_writes_a_motion_and_reports_on_it() {
    let (clip, strokes) = camel();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("motion.json");
    let report =
        report(&["track", &clip, "--strokes", &strokes, "-o", out.to_str().unwrap(), "--json", "--threads", "2"]);
    assert_eq!((&report["command"], &report["threads"]), (&"track".into(), &2.into()));
    assert_eq!(report["limbs"].as_array().unwrap().len(), 8);
    assert!(report["correct_next"][0]["frame"].is_u64() && report["seconds"].as_f64().unwrap() > 0.0);
    let motion: Value = serde_json::from_str(&std::fs::read_to_string(&out).unwrap()).unwrap();
    assert_eq!((&motion["format"], &motion["frames"]), (&"marey-motion".into(), &36.into()));
    let drawn = &motion["tracks"][0]["frames"][0];
    assert_eq!((&drawn["points"][0][0], &drawn["points"][0][1]), (&121.0.into(), &94.0.into()));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn joints_are_captured_and_reported_on() {
    let name = |file: &str| data(&format!("gbot-walk/{file}")).to_str().unwrap().to_owned();
    let (clip, joints) = (name("frames"), name("joints.json"));
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("motion.json");
    let out = out.to_str().unwrap();
    let report = report(&["track", &clip, "--joints", &joints, "-o", out, "--json"]);
    assert_eq!(report["command"], "track");
    assert_eq!((report["joints"].as_array().unwrap().len(), report["bones"].as_array().unwrap().len()), (16, 15));
    assert!(report["visible"].as_f64().unwrap() > 0.5 && report["confidence"].as_f64().unwrap() > 0.5);
    assert!(report["correct_next"][0]["frame"].is_u64() && report["correct_next"][0]["joint"].is_string());
    let motion: Value = serde_json::from_str(&std::fs::read_to_string(out).unwrap()).unwrap();
    assert_eq!((&motion["frames"], &motion["tracks"][0]["kind"]), (&20.into(), &"joint".into()));
    assert_eq!(motion["bones"][0], serde_json::json!(["Hip", "Chest"]));

    let missing = fails(&["track", &clip, "--joints", "/no/such.json", "-o", out], 3);
    assert!(missing.contains("/no/such.json"), "{missing}");
    let (camel, strokes) = camel();
    assert!(fails(&["track", &camel, "--joints", &joints, "-o", out], 3).contains("joints.json: "));
    assert!(fails(&["track", &camel, "--joints", &joints, "--strokes", &strokes, "-o", out], 2).contains("--strokes"));
    let bad = folder.path().join("bad.json");
    let text = std::fs::read_to_string(&joints).unwrap().replace("[\"Hip\", \"Chest\"]", "[\"Hip\", \"Nobody\"]");
    std::fs::write(&bad, text).unwrap();
    let bad = fails(&["track", &clip, "--joints", bad.to_str().unwrap(), "-o", out], 3);
    assert!(bad.contains("bad.json") && bad.contains("`Nobody`"), "{bad}");
}

#[test]
fn segment_writes_a_mask_for_every_frame() {
    let (clip, strokes) = camel();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("masks");
    let report = report(&["segment", &clip, "--strokes", &strokes, "-o", out.to_str().unwrap(), "--json"]);
    assert_eq!(report["command"], "segment");
    let pictures =
        std::fs::read_dir(&out).unwrap().filter(|e| e.as_ref().unwrap().path().extension().is_some_and(|e| e == "png"));
    assert_eq!(pictures.count(), 36);
    assert!(out.join("00000.png").exists() && out.join("00035.png").exists());
}

#[test]
fn a_signal_cancels_with_130_and_leaves_nothing() {
    let (clip, strokes) = camel();
    for signal in ["INT", "TERM"] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("camel");
        let mut creature = command();
        creature.args(["creature", &clip, "--strokes", &strokes, "-o"]).arg(&out);
        let mut child = creature.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(400));
        assert!(child.try_wait().unwrap().is_none(), "it ended before it could be cancelled");
        let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        let asked = Instant::now();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
        assert!(output.stdout.is_empty());
        assert_eq!(String::from_utf8_lossy(&output.stderr).lines().count(), 1);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[test]
fn the_demo_says_what_to_open_and_runs_again() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("demo");
    let run = || marey(&["demo", "-o", out.to_str().unwrap()]);
    let output = run();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(said.lines().count(), 5, "{said}");
    for name in ["creature.glb", "motion.json", "masks", "overlay.gif", "preview.gif", "report.json", "strokes.json"] {
        assert!(out.join(name).exists(), "{name}");
    }
    let drawn = std::fs::read_to_string(out.join("strokes.json")).unwrap().replacen("[121, 94]", "[121, 95]", 1);
    std::fs::write(out.join("strokes.json"), &drawn).unwrap();
    assert!(run().status.success());
    assert_eq!(std::fs::read_to_string(out.join("strokes.json")).unwrap(), drawn, "a person's strokes stay");
}

#[test]
fn deform_gives_shapes_and_times() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (mesh, handles, out) = (path("bar.obj"), path("handles.json"), path("out.json"));
    let mut text = String::new();
    (0..33).for_each(|i| text += &format!("v {} {} 0\n", 10 * (i % 11), 10 * (i / 11)));
    for i in 0..20 {
        let corner = i + i / 10 + 1;
        text += &format!("f {} {} {} {}\n", corner, corner + 1, corner + 12, corner + 11);
    }
    std::fs::write(&mesh, text).unwrap();
    let poses = r#"{"handles": [{"vertex": 0}, {"vertex": 22}, {"vertex": 21}],
        "poses": [{"name": "bend", "targets": [[0, 0], [0, 20], [70, 70]]}], "drag": [[[0, 0], [0, 20], [99, 12]]]}"#;
    std::fs::write(&handles, poses).unwrap();
    let report = report(&["deform", &mesh, &handles, &out, "--json"]);
    assert!(report["precompute_ms"].as_f64().unwrap() > 0.0);
    let found: Value = serde_json::from_str(&std::fs::read_to_string(&out).unwrap()).unwrap();
    let tip = &found["poses"]["bend"]["V"][21];
    let off = |i: usize| (tip[i].as_f64().unwrap() - 70.0).abs();
    assert!(off(0) < 0.01 && off(1) < 0.01, "{tip}");
    assert_eq!(found["drag_ms"].as_array().unwrap().len(), 1);
    std::fs::write(&handles, poses.replace("\"vertex\": 21", "\"vertex\": 99")).unwrap();
    assert!(fails(&["deform", &mesh, &handles, &out], 3).contains("vertex 99"));
    assert!(fails(&["deform", &mesh, "/no/such.json", &out], 3).contains("/no/such.json"));
    std::fs::write(&handles, poses).unwrap();
    let unknown = fails(&["deform", &mesh, &handles, &out, "--deformer", "magic"], 2);
    assert!(unknown.contains("magic") && unknown.contains("arap"), "{unknown}");
}
