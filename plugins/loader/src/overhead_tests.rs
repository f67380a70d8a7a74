//! What a call costs beyond its work, through either door, and what the way from the host's thread to the plugin's adds.

use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use marey::clip::Clip;
use marey_plugin::raw;

use crate::brief::Brief;
use crate::door::{DoorKind, Instance, MeshBrief};
use crate::post::Post;
use crate::{Options, PluginKind, Policy, Registry, library};

/// A library of the sdk with both doors: the broken plugins, one of which is a good deformer.
fn library_with_both_doors() -> PathBuf {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--locked", "--message-format=json", "--package", "marey-plugin-bad"]).current_dir(root);
    let said = cargo.output().expect("cargo");
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let lines = String::from_utf8_lossy(&said.stdout).into_owned();
    let artifacts = lines.lines().filter_map(|l| serde_json::from_str::<serde_json::Value>(l).ok());
    let mut files = artifacts.filter_map(|a| a["filenames"][0].as_str().map(PathBuf::from));
    files.rfind(|f| f.ends_with("libmarey_plugin_bad.so")).expect("a library")
}

/// The best of several rounds: other programs only add.
fn nanoseconds(mut call: impl FnMut()) -> f64 {
    let round = |call: &mut dyn FnMut()| {
        let began = Instant::now();
        (0..2000).for_each(|_| call());
        began.elapsed().as_secs_f64() / 2000.0 * 1e9
    };
    (0..20).map(|_| round(&mut call)).fold(f64::INFINITY, f64::min)
}

#[expect(clippy::print_stdout, reason = "measured numbers are for whoever reads the test's output")]
fn say(line: &str) {
    println!("measured: {line}");
}

#[test]
fn a_call_through_either_door_costs_less_than_a_microsecond() {
    let file = library_with_both_doors();
    for door in [DoorKind::C, DoorKind::Rust] {
        let opened = library::open(&file, &file, Some(door), Box::new(|_, _| {})).expect("opened");
        assert_eq!(opened.kind, door);
        let index = opened.plugins.iter().position(|p| p.kind == PluginKind::Deformer).expect("a deformer");
        let mut instance: Box<dyn Instance> = opened.door.create(index, &[]).expect("made");
        let at = |x: f32| {
            [raw::Handle {
                kind: raw::HANDLE_POINT,
                reserved0: 0,
                a: raw::Point::new(x, 0.0),
                b: raw::Point::new(x, 0.0),
            }]
        };
        let points = vec![raw::Point::new(0.0, 0.0), raw::Point::new(1.0, 0.0), raw::Point::new(0.0, 1.0)];
        let mesh = MeshBrief { points: points.clone(), triangles: vec![[0, 1, 2]] };
        let post = Post::for_mesh();
        let bound = instance.bind(&mesh, &at(0.0), &post).expect("bound");
        let mut moved = points;
        let took = nanoseconds(|| instance.solve(bound, &at(1.0), &mut moved, &post).expect("solved"));
        say(&format!("{door:?} door: a call costs {took:.0} ns"));
        assert!(took < 1000.0, "{door:?}: {took} ns");
        assert_eq!(moved[0].x, 1.0);
    }
}

#[test]
fn frames_are_lent_not_copied_and_quickly() {
    let pixels = image::RgbImage::from_pixel(640, 480, image::Rgb([1, 2, 3]));
    let clip = Clip::from_frames(vec![pixels; 3], 24.0).expect("a clip");
    let picture = clip.frame(1).expect("a frame");
    let post = Post::for_masks(&clip);
    let lent = post.get_frame(1).expect("lent");
    assert_eq!(lent.pixels, picture.rgb.as_raw().as_ptr(), "the very same memory");
    let again = post.get_frame(1).expect("lent");
    assert_ne!(lent.token, again.token);
    post.release_frame(lent.token);
    post.release_frame(lent.token);
    assert_eq!(post.take_back(), 1);
    let took = nanoseconds(|| {
        let frame = post.get_frame(1).expect("lent");
        post.release_frame(frame.token);
    });
    let asked = nanoseconds(|| assert!(post.progress(0.5, None)));
    say(&format!("lending a frame and taking it back {took:.0} ns, asking progress {asked:.0} ns"));
    assert!(took < 1000.0 && asked < 1000.0);
    post.detach();
    assert_eq!(post.get_frame(1).expect_err("gone"), raw::CANCELLED);
}

#[test]
fn what_is_put_is_checked() {
    let clip = Clip::from_frames(vec![image::RgbImage::new(40, 30); 2], 24.0).expect("a clip");
    let limb = crate::brief::Limb { label: c"a".to_owned(), side: 0, parent: -1, points: 2, flags: 0 };
    let brief = Arc::new(Brief {
        size: (40, 30),
        frames: 2,
        fps: 24.0,
        limbs: vec![limb],
        strokes: Vec::new(),
        paints: Vec::new(),
        painted: Vec::new(),
        tracks: Vec::new(),
    });
    let post = Post::for_tracks(&clip, &brief);
    let points = [raw::Point::new(1.0, 2.0), raw::Point::new(3.0, 4.0)];
    assert_eq!(post.put_stroke(0, 0, &points, None, Some(&[0.0, 1.0])), raw::OK);
    assert_eq!(post.put_stroke(0, 0, &points, None, Some(&[0.0, 1.1])), raw::E_INVALID);
    assert_eq!(post.put_stroke(0, 2, &points, None, None), raw::E_INVALID);
    assert_eq!(post.put_stroke(1, 0, &points, None, None), raw::E_INVALID);
    assert_eq!(post.put_stroke(0, 1, &points[..1], None, None), raw::E_INVALID);
    assert_eq!(post.put_mask(0, &[0; 1200], 40), raw::E_INVALID, "no segmenter");
    assert!(post.flaw().expect("told").contains("confidence"), "the first flaw is kept");
    let masks = Post::for_masks(&clip);
    assert_eq!(masks.mask_bytes(0, (40, 30), 40), Ok(1200));
    assert_eq!(masks.mask_bytes(0, (40, 30), 64), Ok(64 * 29 + 40));
    for (size, stride) in [((30, 40), 40), ((40, 30), 39), ((40, 30), usize::MAX)] {
        assert_eq!(masks.mask_bytes(0, size, stride), Err(raw::E_INVALID));
    }
}

#[test]
fn the_way_to_the_plugins_thread_and_back_is_measured() {
    use marey::deform::{Deformer as _, Handle, RestMesh};
    let folder = tempfile::tempdir().expect("a folder");
    let mut options = Options::new(folder.path());
    options.settle = Duration::ZERO;
    let registry = Registry::new(options).expect("a registry");
    registry.load(&library_with_both_doors()).expect("loaded");
    let slot = registry.slot("org.marey.bad.shifts", PluginKind::Deformer, Policy::Keep).expect("a slot");
    let rest = [marey::vec2(0.0, 0.0), marey::vec2(1.0, 0.0), marey::vec2(0.0, 1.0)];
    let progress = marey::job::Progress::new();
    let handle = [Handle::Point(rest[0])];
    let mesh = RestMesh { points: &rest, triangles: &[[0, 1, 2]] };
    let mut bound = slot.bind(mesh, &handle, progress.whole()).expect("bound");
    let mut points = rest;
    let took = nanoseconds(|| bound.solve(&handle, &mut points, progress.whole()).expect("solved"));
    say(&format!("a call from the engine, to the plugin's own thread and back: {:.1} us", took / 1e3));
    assert!(took < 1e6, "{took} ns");
}
