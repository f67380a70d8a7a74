//! From a clip to an exported creature, by mouse and keyboard.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::print_stdout, reason = "a test says why it was skipped")]

mod common;

use std::time::{Duration, Instant};

use common::{BAR_FRAMES, Desk, bar};
use egui_kittest::kittest::Queryable as _;
use image::AnimationDecoder as _;
use marey_studio::egui::{Event, Key, Modifiers, PointerButton, Pos2, pos2, vec2};

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

fn frame(desk: &Desk) -> u64 {
    desk.harness.state().open().unwrap().frame()
}

#[test]
fn a_clip_becomes_a_creature_and_a_file() {
    let mut desk = Desk::new();
    let clip = bar(desk.folder.path());
    desk.harness.run();
    desk.harness.get_by_label("Choose a clip…");
    desk.harness.get_by_label("Open the sample: a fox that walks");

    // Opened by dropping it; nothing is drawn, and the way on says what to do.
    desk.drop_file(&clip);
    desk.wait_open();
    desk.click("Make the creature");
    assert!(desk.harness.state().notices()[0].contains("Draw a stroke"), "{:?}", desk.harness.state().notices());
    desk.click("Close this message");
    assert!(desk.harness.state().notices().is_empty());

    // One stroke, taken back and done again.
    desk.draw(&[(33.0, 32.0), (57.0, 32.0)]);
    assert_eq!(desk.limbs(), ["limb 1"]);
    let stroke = desk.harness.state().open().unwrap().stroke(0, 0).unwrap().to_vec();
    let ends = (stroke[0], stroke[stroke.len() - 1]);
    for ((x, y), (to_x, to_y)) in [(ends.0, (33.0, 32.0)), (ends.1, (57.0, 32.0))] {
        assert!((x - to_x).abs() < 0.6 && (y - to_y).abs() < 0.6, "{ends:?}");
    }
    desk.keys(CTRL, Key::Z);
    assert!(desk.limbs().is_empty());
    desk.keys(CTRL, Key::Z);
    assert!(desk.harness.state().open().is_some(), "the clip stays");
    desk.keys(CTRL_SHIFT, Key::Z);
    assert_eq!(desk.harness.state().open().unwrap().stroke(0, 0).unwrap(), stroke);

    // Along the clip by keys and by the timeline.
    desk.keys(Modifiers::NONE, Key::End);
    assert_eq!(frame(&desk), u64::from(BAR_FRAMES) - 1);
    desk.keys(Modifiers::NONE, Key::Comma);
    assert_eq!(frame(&desk), u64::from(BAR_FRAMES) - 2);
    let timeline = desk.harness.get_by_label_contains("Timeline").rect();
    let press = |desk: &mut Desk, share: f32| {
        let at = timeline.lerp_inside(vec2(share, 0.6));
        desk.harness.hover_at(at);
        desk.harness.drag_at(at);
        desk.harness.drop_at(at);
        desk.harness.run_steps(3);
    };
    press(&mut desk, 0.56);
    assert_eq!(frame(&desk), 4);

    // Drawn again there, which makes a second key frame of the same limb.
    desk.click("Draw limb 1");
    desk.draw(&[(41.0, 32.0), (65.0, 32.0)]);
    assert_eq!((desk.limbs().len(), desk.harness.state().open().unwrap().key_frames()), (1, &[0, 4][..]));

    desk.click("Make the creature");
    desk.wait("the creature", |s| s.open().is_some_and(|o| o.has_creature() && !o.is_busy()));
    desk.wait("a picture of it", |s| s.open().is_some_and(|o| o.pictures() > 0));
    assert!(desk.harness.state().open().unwrap().playing(), "what was made plays");
    desk.harness.get_by_label("The creature in 3D");

    // Out as a GIF, and once more by one key.
    desk.click("Export…");
    desk.click("GIF");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    let file = desk.home().join("bar.gif");
    assert!(desk.harness.state().notices()[0].contains("bar.gif"), "{:?}", desk.harness.state().notices());
    let gif = std::io::BufReader::new(std::fs::File::open(&file).unwrap());
    let frames = image::codecs::gif::GifDecoder::new(gif).unwrap().into_frames().collect_frames().unwrap();
    assert_eq!(frames.len(), BAR_FRAMES as usize);
    let seen = |alpha: u8| frames[3].buffer().pixels().filter(|p| p[3] == alpha).count();
    assert!(seen(255) > 150 && seen(0) > 3000, "the bar on nothing: {} {}", seen(255), seen(0));
    std::fs::remove_file(&file).unwrap();
    desk.keys(CTRL_SHIFT, Key::E);
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    assert!(file.exists());

    desk.keys(CTRL, Key::E);
    desk.click("glTF (.glb)");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    assert_eq!(&std::fs::read(desk.home().join("bar.glb")).unwrap()[..4], b"glTF");

    // A correction is followed by itself, and the creature can be made again.
    desk.keys(Modifiers::NONE, Key::Home);
    desk.keys(Modifiers::NONE, Key::Space);
    desk.harness.run_steps(2);
    assert!(!desk.harness.state().open().unwrap().playing());
    desk.keys(Modifiers::NONE, Key::Home);
    desk.draw(&[(34.0, 33.0), (58.0, 33.0)]);
    desk.wait("the correction", |s| s.open().is_some_and(|o| !o.is_busy()));
    assert!(!desk.harness.state().open().unwrap().is_motion_outdated());
    desk.harness.get_by_label("Update the creature");
}

#[test]
fn what_was_not_saved_is_there_after_a_crash() {
    let mut desk = Desk::new();
    let clip = bar(desk.folder.path());
    desk.drop_file(&clip);
    desk.wait_open();
    desk.draw(&[(33.0, 32.0), (57.0, 32.0)]);
    desk.draw(&[(33.0, 40.0), (57.0, 50.0)]);
    assert_eq!(desk.limbs(), ["limb 1", "limb 2"]);
    // Gone without a word: `close` is not called.
    let mut desk = desk.again();
    desk.harness.run();
    desk.harness.get_by_label("NOT SAVED YET");
    desk.click("Open bar");
    desk.wait_open();
    assert_eq!(desk.limbs(), ["limb 1", "limb 2"]);

    // Back at the start it is there still; discarding asks first.
    desk.keys(CTRL, Key::W);
    desk.harness.run();
    desk.click("Discard: bar");
    desk.click("Keep");
    desk.click("Discard: bar");
    desk.click("Discard");
    assert!(desk.harness.query_by_label("NOT SAVED YET").is_none());
    assert_eq!(std::fs::read_dir(desk.folder.path().join("data/unsaved")).unwrap().count(), 0);
}

#[test]
fn a_sample_is_made_at_once_stops_when_told_and_leaves_nothing_behind() {
    let mut desk = Desk::new();
    desk.harness.run();
    desk.click("Open the sample: a fox that walks");
    desk.wait_open();
    assert_eq!(desk.limbs().len(), 7);
    assert!(desk.harness.state().open().unwrap().is_busy(), "what is drawn is made at once");
    // The job does not hold the window up, and ends when it is told to.
    let began = Instant::now();
    desk.click("Cancel");
    desk.wait("the cancel", |s| s.open().is_some_and(|o| !o.is_busy()));
    assert!(began.elapsed() < Duration::from_secs(3), "{:?}", began.elapsed());
    assert!(!desk.harness.state().open().unwrap().has_creature());
    desk.click("To the start");
    desk.harness.run();
    assert!(desk.harness.query_by_label("NOT SAVED YET").is_none(), "it was only looked at");
}

#[test]
fn a_session_with_a_name_is_saved_and_listed() {
    let mut desk = Desk::new();
    let clip = bar(desk.folder.path());
    let file = desk.folder.path().join("walk.marey");
    {
        let context = marey_binding::Context::new(1).unwrap();
        let session = context.new_session(file.to_str().unwrap()).unwrap();
        session.set_clip(Some(&context.open_clip(clip.to_str().unwrap()).unwrap())).unwrap();
        session.save().unwrap();
    }
    desk.drop_file(&file);
    desk.wait_open();
    desk.harness.get_by_label("Saved");
    desk.draw(&[(33.0, 32.0), (57.0, 32.0)]);
    desk.harness.get_by_label("Not saved");
    desk.keys(CTRL, Key::S);
    desk.harness.get_by_label("Saved");

    // What came after the save is saved when it is left.
    desk.draw(&[(33.0, 40.0), (57.0, 50.0)]);
    desk.click("To the start");
    desk.harness.run();
    desk.click("Open walk");
    desk.wait_open();
    assert_eq!(desk.limbs(), ["limb 1", "limb 2"]);
    desk.harness.get_by_label("Saved");
    desk.click("To the start");
    desk.click("Take off the list: walk");
    assert!(desk.harness.query_by_label("Open walk").is_none());
    assert!(file.exists());
}

#[test]
fn key_frames_are_dragged_and_clips_zoomed() {
    let mut desk = Desk::new();
    let clip = bar(desk.folder.path());
    desk.drop_file(&clip);
    desk.wait_open();
    desk.draw(&[(33.0, 32.0), (57.0, 32.0)]);
    let timeline = desk.harness.get_by_label_contains("Timeline").rect();
    // The strip leaves eight points free at each side; diamonds are above it.
    let x_of = |frame: f32| {
        let (left, wide) = (timeline.left() + 8.0, timeline.width() - 16.0);
        pos2(left + wide * (frame + 0.5) / BAR_FRAMES as f32, timeline.top() + 10.0)
    };
    desk.harness.hover_at(x_of(0.0));
    desk.harness.drag_at(x_of(0.0));
    for step in 1..=10 {
        desk.harness.hover_at(x_of(0.3 * step as f32));
    }
    desk.harness.drop_at(x_of(3.0));
    desk.harness.run_steps(3);
    let open = desk.harness.state().open().unwrap();
    assert_eq!((open.key_frames(), open.frame()), (&[3][..], 3));
    desk.keys(CTRL, Key::Z);
    assert_eq!(desk.harness.state().open().unwrap().key_frames(), [0], "one step");

    let place = |desk: &Desk, at| desk.harness.state().open().unwrap().on_screen(at);
    let (before, cursor) = (place(&desk, (20.0, 20.0)), place(&desk, (60.0, 40.0)));
    desk.harness.hover_at(cursor);
    desk.harness.step();
    desk.harness.event(Event::Zoom(1.5));
    desk.harness.run_steps(2);
    assert!(place(&desk, (60.0, 40.0)).distance(cursor) < 0.1, "what is under the cursor stays");
    let wide = |a: Pos2| a.distance(cursor);
    let now = place(&desk, (20.0, 20.0));
    assert!((wide(now) / wide(before) - 1.5).abs() < 0.01, "{before:?} {now:?}");
    // Space and the mouse move it, and do not play it.
    desk.harness.key_down(Key::Space);
    desk.harness.drag_at(cursor);
    desk.harness.hover_at(cursor + vec2(30.0, 12.0));
    desk.harness.hover_at(cursor + vec2(60.0, 24.0));
    desk.harness.drop_at(cursor + vec2(60.0, 24.0));
    desk.harness.key_up(Key::Space);
    desk.harness.run_steps(3);
    assert!(place(&desk, (20.0, 20.0)).distance(now + vec2(60.0, 24.0)) < 1.0);
    assert_eq!(desk.limbs().len(), 1, "nothing was drawn");
    assert!(!desk.harness.state().open().unwrap().playing());
    desk.keys(CTRL, Key::Num0);
    assert!(place(&desk, (20.0, 20.0)).distance(before) < 0.1);
}

#[test]
fn what_cannot_be_opened_is_said_with_its_reason() {
    let mut desk = Desk::new();
    let file = desk.folder.path().join("notes.mp4");
    std::fs::write(&file, "not a film").unwrap();
    desk.drop_file(&file);
    desk.wait("the message", |s| !s.notices().is_empty());
    assert!(desk.harness.state().notices()[0].contains("notes.mp4"), "{:?}", desk.harness.state().notices());
    assert!(desk.harness.state().open().is_none());
    desk.harness.get_by_label("Choose a clip…");
}

#[test]
fn limbs_are_named_selected_and_removed() {
    let mut desk = Desk::new();
    let clip = bar(desk.folder.path());
    desk.drop_file(&clip);
    desk.wait_open();
    desk.draw(&[(33.0, 32.0), (57.0, 32.0)]);
    desk.draw(&[(57.4, 32.0), (80.0, 50.0)]);
    let open = desk.harness.state().open().unwrap();
    let (first, second) = (open.stroke(0, 0).unwrap(), open.stroke(1, 0).unwrap());
    assert_eq!(first.last(), second.first(), "what begins near an end meets it");

    let field = desk.harness.get_by_label("Name of limb 2");
    field.click();
    desk.harness.run_steps(2);
    assert_eq!(desk.harness.state().open().unwrap().selected(), Some(1));
    desk.harness.key_press_modifiers(CTRL, Key::A);
    desk.harness.step();
    desk.harness.get_by_label("Name of limb 2").type_text("tail");
    desk.harness.run_steps(2);
    desk.harness.key_press(Key::Enter);
    desk.harness.run_steps(3);
    assert_eq!(desk.limbs(), ["limb 1", "tail"]);

    // Escape lets go of it, a click on its stroke takes hold of it again.
    desk.keys(Modifiers::NONE, Key::Escape);
    assert_eq!(desk.harness.state().open().unwrap().selected(), None);
    let at = desk.harness.state().open().unwrap().on_screen((68.7, 41.0));
    for pressed in [true, false] {
        let click =
            Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
        desk.harness.event(click);
    }
    desk.harness.run_steps(3);
    assert_eq!(desk.harness.state().open().unwrap().selected(), Some(1));

    desk.keys(Modifiers::NONE, Key::Delete);
    assert!(desk.harness.state().open().unwrap().stroke(1, 0).is_none(), "its stroke here is gone");
    desk.click("Remove tail");
    assert_eq!(desk.limbs(), ["limb 1"]);
    for _ in 0..3 {
        desk.keys(CTRL, Key::Z);
    }
    assert_eq!(desk.limbs(), ["limb 1", "limb 2"]);
}

/// The window's own drawing, which everything else here does without.
#[test]
fn the_start_is_drawn_light_and_dark() {
    let gpu = marey_binding::Context::new(1).unwrap().renderer(marey_binding::Adapter::Gpu);
    if let Err(e) = gpu {
        println!("skipped: {e}");
        return;
    }
    let mut desk = Desk::new();
    desk.harness.run();
    let ground = |desk: &mut Desk| {
        let picture = desk.harness.render().unwrap();
        let colors: std::collections::HashSet<_> = picture.pixels().map(|p| p.0).collect();
        assert!(colors.len() > 100, "letters, lines and the fox: {} colours", colors.len());
        picture.get_pixel(100, 800).0
    };
    assert!(ground(&mut desk)[..3].iter().all(|c| *c < 64));
    desk.keys(CTRL, Key::L);
    assert!(ground(&mut desk)[..3].iter().all(|c| *c > 192));
    let desk = &mut desk.again();
    desk.harness.run();
    assert!(ground(desk)[..3].iter().all(|c| *c > 192), "it is remembered");
}

#[test]
fn keys_are_listed_and_the_list_closes() {
    let mut desk = Desk::new();
    desk.harness.run();
    desk.keys(Modifiers::NONE, Key::F1);
    desk.harness.get_by_label("Export again, as last time");
    desk.harness.check_accessibility();
    desk.keys(Modifiers::NONE, Key::Escape);
    assert!(desk.harness.query_by_label("Export again, as last time").is_none());
}
