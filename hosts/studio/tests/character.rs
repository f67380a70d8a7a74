//! From a picture to a character that moves, by mouse and keyboard.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::path::Path;

use common::{BAR_FRAMES, Desk, legs};
use egui_kittest::kittest::Queryable as _;
use marey_studio::egui::{Key, Modifiers};

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

fn settle(desk: &mut Desk, moves: bool) {
    let so = move |o: marey_studio::Open<'_>| !o.joints().is_empty() && !o.is_busy() && o.moves() == moves;
    desk.wait("the machine", move |s| s.open().is_some_and(so));
    desk.harness.run_steps(3);
}

/// A figure of one thick line that is bent once, on white.
fn figure(folder: &Path) -> std::path::PathBuf {
    let path = folder.join("figure.png");
    let image = image::RgbImage::from_fn(120, 160, |x, y| {
        let (x, y) = (x as f32, y as f32);
        let body = (x - 60.0).abs() < 9.0 && (30.0..140.0).contains(&y);
        let arms = (y - 60.0).abs() < 6.0 && (20.0..100.0).contains(&x);
        if body || arms { image::Rgb([40, 60, 120]) } else { image::Rgb([255, 255, 255]) }
    });
    image.save(&path).unwrap();
    path
}

#[test]
fn a_picture_takes_a_motion_and_is_exported() {
    let mut desk = Desk::new();
    let picture = figure(desk.folder.path());
    desk.harness.state_mut().open_picture(&picture);
    desk.wait_open();
    settle(&mut desk, false);
    let joints = desk.open().joints();
    assert!(joints.len() >= 5, "a body and two arms: {joints:?}");

    // A joint is moved, and back.
    let at = joints[1].1;
    let (from, to) = (desk.open().on_screen(at), desk.open().on_screen((at.0 + 3.0, at.1 + 2.0)));
    desk.harness.hover_at(from);
    desk.harness.drag_at(from);
    for step in 1..=6 {
        desk.harness.hover_at(from.lerp(to, step as f32 / 6.0));
    }
    desk.harness.drop_at(to);
    desk.harness.run_steps(3);
    settle(&mut desk, false);
    let moved = desk.open().joints()[1].1;
    assert!((moved.0 - at.0 - 3.0).abs() < 0.6 && (moved.1 - at.1 - 2.0).abs() < 0.6, "{at:?} {moved:?}");
    desk.keys(CTRL, Key::Z);
    settle(&mut desk, false);
    assert_eq!(desk.open().joints(), joints, "one step");

    // A motion of a file.
    let motion = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/characters/child/walk.motion.json");
    desk.drop_file(&motion);
    settle(&mut desk, true);
    assert!(desk.open().playing());
    desk.click("Stays on the spot");
    settle(&mut desk, true);

    // Bent by other means, a step of undo, with the mesh over it.
    let steps = |desk: &Desk| desk.open().steps().0.map(str::to_owned);
    let (before, first) = (steps(&desk), desk.open().fingerprint().unwrap());
    desk.click("Bent by");
    desk.click("as rigid as possible");
    settle(&mut desk, true);
    assert_ne!(desk.open().fingerprint().unwrap(), first);
    desk.keys(Modifiers::NONE, Key::Num4);
    desk.harness.check_accessibility();
    desk.keys(Modifiers::NONE, Key::Num4);
    desk.keys(CTRL, Key::Z);
    settle(&mut desk, true);
    assert_eq!((steps(&desk), desk.open().fingerprint().unwrap()), (before, first));

    desk.click("Export…");
    desk.click("Animated PNG");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    let frames = |desk: &Desk| {
        let file = std::fs::File::open(desk.home().join("figure.png")).unwrap();
        let png = image::codecs::png::PngDecoder::new(std::io::BufReader::new(file)).unwrap();
        let frames = image::AnimationDecoder::into_frames(png.apng().unwrap()).collect_frames().unwrap();
        frames.into_iter().map(|f| f.into_buffer().into_raw()).collect::<Vec<_>>()
    };
    let ones = frames(&desk);
    assert_eq!(ones.len(), 24);

    // It is exported as it plays: on twos, at half the speed.
    desk.click("Timing: on ones");
    desk.click("on twos");
    desk.click("half");
    desk.harness.check_accessibility();
    desk.keys(Modifiers::NONE, Key::Escape);
    desk.keys(CTRL, Key::E);
    desk.harness.get_by_label_contains("47 frames");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    let twos = frames(&desk);
    assert_eq!(twos.len(), 47);
    assert!((0..46).step_by(2).all(|f| twos[f] == twos[f + 1]), "pictures stand for two frames");
    assert_eq!((&twos[0], &twos[20]), (&ones[0], &ones[10]));
    for _ in 0..2 {
        desk.keys(CTRL, Key::Z);
    }
    desk.harness.get_by_label("Timing: on ones");

    desk.keys(CTRL, Key::E);
    desk.click("glTF (.glb)");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    assert_eq!(&std::fs::read(desk.home().join("figure.glb")).unwrap()[..4], b"glTF");

    // All of it is there after a crash.
    let mut desk = desk.again();
    desk.harness.run();
    desk.click("Open figure");
    desk.wait_open();
    settle(&mut desk, true);
    assert_eq!(desk.open().joints(), joints);
}

#[test]
fn a_character_is_exported_from_the_start_by_three_clicks() {
    let mut desk = Desk::new();
    desk.harness.run();
    desk.click("Open the sample: a girl who waves");
    settle(&mut desk, true);
    assert_eq!(desk.open().joints().len(), 15);
    desk.click("Export…");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    assert_eq!(&std::fs::read(desk.home().join("A girl who waves.gif")).unwrap()[..6], b"GIF89a");
}

#[test]
fn what_is_no_picture_and_no_motion_is_said() {
    let mut desk = Desk::new();
    let file = desk.folder.path().join("notes.png");
    std::fs::write(&file, "no picture").unwrap();
    desk.harness.state_mut().open_picture(&file);
    desk.wait("the message", |s| !s.notices().is_empty());
    assert!(desk.harness.state().open().is_none());

    let picture = figure(desk.folder.path());
    desk.harness.state_mut().open_picture(&picture);
    desk.wait_open();
    settle(&mut desk, false);
    let motion = desk.folder.path().join("walk.bvh");
    std::fs::write(&motion, "no motion").unwrap();
    desk.drop_file(&motion);
    desk.wait("the message", |s| s.notices().iter().any(|n| n.contains("walk.bvh")));
    settle(&mut desk, false);
}

/// A desk with the figure and a clip, on which nothing is marked yet.
fn with_clip() -> Desk {
    let mut desk = Desk::new();
    let (picture, clip) = (figure(desk.folder.path()), legs(desk.folder.path()));
    desk.harness.state_mut().open_picture(&picture);
    desk.wait_open();
    settle(&mut desk, false);
    desk.click("From a clip…");
    desk.type_path(clip.to_str().unwrap());
    desk.wait("the clip", |s| s.open().is_some_and(|o| !o.is_busy() && o.on_clip((0.0, 0.0)) != o.on_clip((1.0, 0.0))));
    desk.harness.run_steps(3);
    desk
}

/// Where joints are marked on the clip: body and legs, as they come.
const MARKS: [(f32, f32); 5] = [(48.0, 18.0), (20.0, 18.0), (72.0, 18.0), (62.0, 54.0), (34.0, 54.0)];

fn mark(desk: &mut Desk, count: usize) {
    for at in &MARKS[..count] {
        let at = desk.open().on_clip(*at);
        desk.click_at(at);
    }
    settle(desk, true);
}

#[test]
fn a_motion_is_taken_from_a_clip_by_marking_joints() {
    let mut desk = with_clip();
    let joints = desk.open().joints();
    // The way on says what to do.
    desk.click("Next: mark joints");
    assert!(desk.harness.state().notices()[0].contains("Click on the clip"), "{:?}", desk.harness.state().notices());
    desk.click("Close this message");
    let count = MARKS.len().min(joints.len());
    mark(&mut desk, count);
    assert_eq!((desk.open().marks().len(), desk.open().key_frames()), (count, &[0][..]));
    assert!(!desk.open().playing(), "the frame that is marked on stays");
    assert_eq!(desk.open().steps().0, Some("new point"));

    // It was followed: the thing wanders a pixel a frame.
    let before = desk.open().points();
    desk.keys(Modifiers::NONE, Key::End);
    settle(&mut desk, true);
    let after = desk.open().points();
    for (a, b) in before.iter().zip(&after) {
        assert!((b.0 - a.0 - (BAR_FRAMES - 1) as f32).abs() < 2.5 && (b.1 - a.1).abs() < 2.5, "{a:?} {b:?}");
    }

    // A correction by dragging: one step, which undo takes back with what was followed.
    let from = desk.open().on_clip(after[0]);
    let to = desk.open().on_clip((after[0].0 + 4.0, after[0].1 + 3.0));
    desk.drag(from, to);
    settle(&mut desk, true);
    assert_eq!(desk.open().key_frames(), [0, u64::from(BAR_FRAMES) - 1]);
    desk.keys(CTRL, Key::Z);
    settle(&mut desk, true);
    assert_eq!((desk.open().key_frames(), desk.open().points()), (&[0][..], after), "one step");

    // A joint is chosen by key, and its mark taken off; and brought back.
    desk.keys(Modifiers::NONE, Key::Home);
    desk.keys(Modifiers::NONE, Key::Escape);
    desk.keys(Modifiers::NONE, Key::L);
    desk.keys(Modifiers::NONE, Key::Delete);
    assert_eq!(desk.open().marks().len(), count - 1);
    desk.keys(CTRL, Key::Z);
    settle(&mut desk, true);
    assert_eq!(desk.open().marks().len(), count);

    // The drawing in place of the clip, and out.
    desk.keys(Modifiers::NONE, Key::G);
    desk.harness.get_by_label("The character as it was drawn");
    assert!(desk.harness.query_by_label_contains("The clip, frame").is_none());
    desk.click("Export…");
    desk.click("GIF");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    let gif = std::fs::File::open(desk.home().join("figure.gif")).unwrap();
    let gif = image::codecs::gif::GifDecoder::new(std::io::BufReader::new(gif)).unwrap();
    let frames = image::AnimationDecoder::into_frames(gif).collect_frames().unwrap();
    assert_eq!(frames.len(), BAR_FRAMES as usize);

    // All of it is there after a crash, and is not followed again.
    let marks = desk.open().marks();
    let mut desk = desk.again();
    desk.harness.run();
    desk.click("Open figure");
    desk.wait_open();
    settle(&mut desk, true);
    assert_eq!((desk.open().marks(), desk.open().followed()), (marks, 0));

    // Another motion takes the clip away, and undo brings both back.
    desk.drop_file(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/characters/child/walk.motion.json"));
    desk.wait("the motion", |s| s.open().is_some_and(|o| !o.is_busy() && o.marks().is_empty()));
    settle(&mut desk, true);
    desk.keys(CTRL, Key::Z);
    settle(&mut desk, true);
    assert_eq!(desk.open().marks().len(), count);
    desk.keys(CTRL_SHIFT, Key::Z);
    settle(&mut desk, true);
    assert!(desk.open().marks().is_empty());
}

#[test]
fn what_is_no_clip_is_said_and_changes_nothing() {
    let mut desk = with_clip();
    mark(&mut desk, 3);
    let marks = desk.open().marks();
    let file = desk.folder.path().join("notes.mp4");
    std::fs::write(&file, "no clip").unwrap();
    desk.click("From a clip…");
    desk.type_path(file.to_str().unwrap());
    desk.wait("the message", |s| s.notices().iter().any(|n| n.contains("notes.mp4")));
    settle(&mut desk, true);
    assert_eq!(desk.open().marks(), marks);
}
