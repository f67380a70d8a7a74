//! From a clip and a drawing to a drawing that lives, by mouse and keyboard.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{BAR_FRAMES, Desk, bar};
use egui_kittest::kittest::Queryable as _;
use marey_studio::egui::{Key, Modifiers};

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// A bar of two lines, as the one of the clip but twice as large.
const SVG: &str = r#"<svg xmlns="http://www.w3.org/2000/svg" width="192" height="128">
<path d="M60 52 L120 52" stroke="black" stroke-width="3" fill="none"/>
<path d="M60 76 L120 76" stroke="black" stroke-width="3" fill="none"/></svg>"#;

fn settle(desk: &mut Desk) {
    desk.wait("it to move", |s| s.open().is_some_and(|o| o.moves() && !o.is_busy()));
    desk.harness.run_steps(3);
}

/// A desk with a clip and a drawing dropped on the third door, and four points marked.
fn marked() -> Desk {
    let mut desk = Desk::new();
    let clip = bar(desk.folder.path());
    let drawing = desk.folder.path().join("bar.svg");
    std::fs::write(&drawing, SVG).unwrap();
    desk.harness.state_mut().open_for_drawing(&clip);
    desk.wait_open();
    // The machine finds points by itself, and one step takes them back.
    desk.click("Next: find points");
    desk.wait("points", |s| s.open().is_some_and(|o| o.marks().len() > 3 && !o.is_busy()));
    // The bar lies from (30, 26) to (60, 38) in frame 0; it starts no other thing.
    let on_bar = |(x, y): &(f32, f32)| (26.0..64.0).contains(x) && (22.0..42.0).contains(y);
    assert!(desk.open().points().iter().all(on_bar), "{:?}", desk.open().points());
    desk.keys(CTRL, Key::Z);
    assert_eq!(desk.open().marks().len(), 0);
    for at in [(32.0, 28.0), (57.0, 28.0), (44.0, 36.0), (33.0, 36.0)] {
        let at = desk.open().on_screen(at);
        desk.click_at(at);
    }
    assert_eq!(desk.open().marks().len(), 4);
    desk.drop_file(&drawing);
    settle(&mut desk);
    desk
}

#[test]
fn a_clip_moves_a_drawing_and_it_is_exported() {
    let mut desk = marked();
    assert_eq!(desk.open().handles().len(), 4, "equal numbers on clip and drawing");

    // A point is corrected on another frame: one step, tracked again by itself, and a key frame more.
    if desk.open().playing() {
        desk.keys(Modifiers::NONE, Key::Space);
    }
    desk.keys(Modifiers::NONE, Key::End);
    desk.harness.run_steps(3);
    let last = u64::from(BAR_FRAMES) - 1;
    assert_eq!(desk.open().frame(), last);
    // The bar has wandered two pixels a frame.
    let followed = desk.open().points()[0];
    assert!((followed.0 - 46.0).abs() < 3.0 && (followed.1 - 28.0).abs() < 3.0, "{followed:?}");
    let (from, to) = (desk.open().on_screen(followed), desk.open().on_screen((followed.0 + 4.0, followed.1 + 3.0)));
    desk.drag(from, to);
    settle(&mut desk);
    assert_eq!(desk.open().key_frames(), [0, last]);
    assert_eq!(desk.open().marks()[0].len(), 2, "{:?}", desk.open().marks());
    desk.keys(CTRL, Key::Z);
    settle(&mut desk);
    assert_eq!(desk.open().key_frames(), [0], "one step");

    // A point is moved on the drawing, and moved back.
    let before = desk.open().handles();
    let at = before[1].1;
    let (from, to) = (desk.open().on_sheet(at), desk.open().on_sheet((at.0 + 20.0, at.1 + 10.0)));
    desk.drag(from, to);
    settle(&mut desk);
    let moved = desk.open().handles()[1].1;
    assert!((moved.0 - at.0 - 20.0).abs() < 1.0 && (moved.1 - at.1 - 10.0).abs() < 1.0, "{at:?} {moved:?}");
    desk.keys(CTRL, Key::Z);
    settle(&mut desk);
    assert_eq!(desk.open().handles(), before, "one step");

    // A point that the drawing has no place for is left off it, and put back: a step each.
    assert_eq!(desk.open().selected(), Some(1));
    desk.click("It holds the drawing");
    settle(&mut desk);
    assert_eq!(desk.open().handles().iter().map(|h| h.0).collect::<Vec<_>>(), [0, 2, 3]);
    assert_eq!(desk.open().marks().len(), 4, "it is followed still");
    desk.keys(CTRL, Key::Z);
    settle(&mut desk);
    assert_eq!(desk.open().handles(), before, "one step");

    desk.click("Export…");
    desk.click("Animated SVG");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    let svg = std::fs::read_to_string(desk.home().join("bar.svg")).unwrap();
    assert!(svg.contains("<animate") && svg.matches("<path").count() >= 2, "{}", &svg[..svg.len().min(400)]);

    desk.keys(CTRL, Key::E);
    desk.click("GIF");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    let gif = image::codecs::gif::GifDecoder::new(std::io::BufReader::new(
        std::fs::File::open(desk.home().join("bar.gif")).unwrap(),
    ))
    .unwrap();
    let frames = image::AnimationDecoder::into_frames(gif).collect_frames().unwrap();
    assert_eq!(frames.len(), BAR_FRAMES as usize);
    let first = frames[0].buffer();
    assert_ne!(first.as_raw(), frames[frames.len() - 1].buffer().as_raw(), "it moves");
}

#[test]
fn points_and_drawing_are_there_after_a_crash() {
    let desk = marked();
    let marks = desk.open().marks();
    let mut desk = desk.again();
    desk.harness.run();
    desk.click("Open bar");
    desk.wait_open();
    assert_eq!(desk.open().marks(), marks);
    settle(&mut desk);
    assert_eq!(desk.open().handles().len(), 4);
    assert_eq!(desk.open().followed(), 0, "where the points go was kept");
    desk.click("Remove point 2");
    settle(&mut desk);
    let notices = desk.harness.state().notices();
    assert_eq!((desk.open().marks().len(), desk.open().handles().len()), (3, 3), "{notices:?}");
}

#[test]
fn a_drawing_is_exported_from_the_start_by_three_clicks() {
    let mut desk = Desk::new();
    desk.harness.run();
    desk.click("Open the sample: a horse that gallops");
    settle(&mut desk);
    let open = desk.open();
    assert_eq!((open.marks().len(), open.handles().len()), (14, 14));
    assert!(open.playing());
    desk.click("Export…");
    desk.click("Export");
    desk.wait("the export", |s| s.open().is_some_and(|o| !o.is_busy()));
    let svg = std::fs::read_to_string(desk.home().join("A horse that gallops.svg")).unwrap();
    assert!(svg.contains("<animate"));
    // It was only looked at.
    desk.click("To the start");
    desk.harness.run();
    assert!(desk.harness.query_by_label("NOT SAVED YET").is_none());
}

#[test]
fn where_points_go_is_kept_for_these_marks_and_this_clip_only() {
    let mut desk = marked();
    assert!(desk.open().followed() > 0);
    // What was kept goes with the step that it was followed for, and comes back with it.
    let (marks, followed) = (desk.open().marks(), desk.open().followed());
    let still = |desk: &mut Desk| {
        if desk.open().playing() {
            desk.keys(Modifiers::NONE, Key::Space);
        }
        desk.keys(Modifiers::NONE, Key::End);
    };
    still(&mut desk);
    let way = desk.open().points();
    desk.keys(CTRL, Key::Z);
    desk.keys(CTRL, Key::Z);
    assert_eq!(desk.open().marks().len(), 3, "the drawing, and the last point");
    desk.keys(CTRL_SHIFT, Key::Z);
    desk.keys(CTRL_SHIFT, Key::Z);
    settle(&mut desk);
    still(&mut desk);
    assert_eq!((desk.open().marks(), desk.open().points()), (marks, way));
    assert!(desk.open().followed() <= followed + 1);

    // Another clip under the same name is followed anew.
    let frame = desk.folder.path().join("bar/00003.png");
    let mut desk = {
        let mut image = image::open(&frame).unwrap().to_rgb8();
        image.put_pixel(0, 0, image::Rgb([1, 2, 3]));
        image.save(&frame).unwrap();
        desk.again()
    };
    desk.harness.run();
    desk.click("Open bar");
    desk.wait_open();
    settle(&mut desk);
    assert_eq!(desk.open().followed(), 1);
}

#[test]
fn space_pans_while_the_mouse_is_dragged_and_plays_alone() {
    let mut desk = marked();
    if desk.open().playing() {
        desk.keys(Modifiers::NONE, Key::Space);
    }
    let marks = desk.open().marks();
    for sheet in [false, true] {
        let place =
            |desk: &Desk| if sheet { desk.open().on_sheet((90.0, 64.0)) } else { desk.open().on_screen((50.0, 50.0)) };
        let before = place(&desk);
        desk.harness.key_down(Key::Space);
        let by = marey_studio::egui::vec2(40.0, 16.0);
        desk.drag(before, before + by);
        desk.harness.key_up(Key::Space);
        desk.harness.run_steps(3);
        // A drag is one after six points.
        assert!(place(&desk).distance(before + by) < 6.5, "{before:?} {:?}", place(&desk));
        assert!(!desk.open().playing(), "it panned");
        desk.keys(CTRL, Key::Num0);
        assert!(place(&desk).distance(before) < 0.5);
    }
    assert_eq!(desk.open().marks(), marks);
    desk.keys(Modifiers::NONE, Key::Space);
    assert!(desk.open().playing());
}
