//! The studio's screens, one after the other: what its page in the docs shows, and more.

use std::path::PathBuf;

use egui_kittest::kittest::Queryable as _;
use image::RgbImage;
use marey_studio::egui::{Key, Modifiers};

use super::{Desk, EDGE};

/// What the page shows, in this order.
pub const DOCS: [&str; 12] = [
    "start",
    "drawing",
    "creature",
    "overlap",
    "timing",
    "paint",
    "export",
    "character",
    "captured",
    "marks",
    "lives",
    "lives-export",
];

/// The window as it is, without the frame that the harness lays around everything; an error where nothing draws.
pub fn picture(desk: &mut Desk) -> Result<RgbImage, String> {
    let picture = desk.harness.render()?;
    let (width, height) = (picture.width() - 2 * EDGE, picture.height() - 2 * EDGE);
    let picture = image::imageops::crop_imm(&picture, EDGE, EDGE, width, height).to_image();
    Ok(image::DynamicImage::from(picture).to_rgb8())
}

/// Takes the screen of that name, once it is drawn as it is.
pub type Save<'a> = &'a dyn Fn(&mut Desk, &str);

/// Stops what plays, at so many frames from the first.
fn stop_at(desk: &mut Desk, frame: u32) {
    desk.harness.key_press(Key::Space);
    desk.harness.run_steps(3);
    desk.harness.key_press(Key::Home);
    for _ in 0..frame {
        desk.harness.key_press(Key::Period);
    }
}

/// The export dialog with a format and a file, as the screen of this name; and closed again.
fn export(desk: &mut Desk, save: Save<'_>, format: &str, file: &str, name: &str) {
    desk.click("Export…");
    desk.click(format);
    desk.click("File");
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    desk.harness.step();
    desk.harness.get_by_label("File").type_text(file);
    desk.harness.step();
    desk.harness.key_press(Key::Enter);
    desk.rest(1500);
    save(desk, name);
    desk.harness.key_press(Key::Escape);
    desk.harness.run_steps(3);
}

pub fn creature(desk: &mut Desk, save: Save<'_>) {
    // Drawing, in the middle of a leg.
    let clip = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../data/fox/clip.mp4");
    desk.drop_file(&clip);
    desk.wait_open();
    desk.rest(1500);
    save(desk, "empty");
    desk.draw(&[(315.0, 245.0), (370.0, 252.0), (425.0, 257.0)]);
    desk.draw(&[(425.0, 257.0), (470.0, 246.0), (515.0, 234.0)]);
    desk.draw(&[(315.0, 245.0), (285.0, 238.0), (240.0, 270.0), (190.0, 298.0), (162.0, 299.0)]);
    let leg = [(317.0, 246.0), (335.0, 285.0), (300.0, 305.0), (262.0, 312.0)];
    desk.press_along(&leg);
    save(desk, "drawing");
    desk.harness.drop_at(desk.open().on_screen(leg[3]));
    desk.harness.run_steps(3);
    desk.click("To the start");
    desk.rest(300);
    save(desk, "again");
    desk.click("Open the sample: a fox that walks");
    desk.wait_open();
    desk.wait("thumbnails", |s| s.open().is_some_and(|o| o.is_busy()));
    desk.rest(1500);
    save(desk, "making");
    desk.wait("the creature", |s| s.open().is_some_and(|o| o.has_creature() && o.pictures() > 0));
    stop_at(desk, 23);
    desk.click("Draw hind_near");
    desk.rest(1500);
    save(desk, "creature");
    if let Some((_, _, at)) = desk.open().overlaps().first().copied() {
        let at = desk.open().on_screen(at);
        desk.harness.hover_at(at);
        desk.rest(900);
        save(desk, "overlap");
        desk.click_at(at);
        desk.rest(300);
        save(desk, "ordered");
        desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        desk.harness.run_steps(3);
    }
    desk.harness.key_press(Key::Escape);
    desk.harness.key_press(Key::O);
    desk.rest(300);
    save(desk, "onion");
    desk.click("Onion skin: how much");
    save(desk, "onion-settings");
    desk.harness.key_press(Key::Escape);
    desk.harness.run_steps(2);
    desk.harness.key_press(Key::O);
    desk.click("Timing: on ones");
    desk.click("on twos");
    desk.click("slow ends");
    save(desk, "timing");
    desk.harness.key_press(Key::Escape);
    for _ in 0..2 {
        desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    }
    desk.harness.run_steps(3);
    desk.click("Paint what is the creature");
    let along = [(300.0, 235.0), (350.0, 235.0), (420.0, 240.0)];
    desk.draw(&along);
    desk.click("Paint what is not the creature");
    desk.press_along(&[(230.0, 330.0), (280.0, 335.0), (330.0, 332.0)]);
    save(desk, "paint");
    desk.harness.drop_at(desk.open().on_screen((330.0, 332.0)));
    desk.harness.run_steps(3);
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    desk.harness.key_press(Key::D);
    desk.harness.run_steps(3);
    desk.click("How the creature is made");
    save(desk, "methods");
    if desk.harness.query_by_label("It is cut out by").is_some() {
        desk.click("It is cut out by");
        save(desk, "methods-list");
        desk.harness.key_press(Key::Escape);
        desk.harness.run_steps(3);
    }
    desk.harness.key_press(Key::Escape);
    desk.harness.run_steps(3);
    desk.click("Plugins");
    desk.rest(300);
    let settings = desk.harness.query_all_by_label_contains("Settings: ").map(|n| n.rect().center()).next();
    if let Some(at) = settings {
        desk.click_at(at);
        desk.rest(400);
    }
    save(desk, "plugins");
    desk.click("Close");
    desk.harness.key_press(Key::Num3);
    desk.harness.key_press(Key::Num4);
    desk.harness.key_press(Key::V);
    desk.harness.key_press(Key::V);
    desk.rest(1500);
    save(desk, "overlays");
    export(desk, save, "Animated WebP", "Pictures/A fox that walks.webp", "export");
    desk.harness.key_press_modifiers(Modifiers::NONE, Key::F1);
    save(desk, "keys");
    desk.click("Keys of Last frame: End");
    desk.harness.key_press(Key::R);
    desk.harness.run_steps(3);
    save(desk, "keys-taken");
    desk.click("Close");
    desk.click("To the start");
    desk.rest(300);
    desk.click("Choose a clip…");
    save(desk, "path");
    desk.harness.key_press(Key::Escape);
    desk.harness.run_steps(3);
}

pub fn character(desk: &mut Desk, save: Save<'_>) {
    // As it walks, with a joint selected.
    desk.click("Open the sample: a girl who waves");
    desk.wait("the girl to walk", |s| s.open().is_some_and(|o| o.moves() && !o.is_busy() && o.pictures() > 8));
    stop_at(desk, 6);
    for _ in 0..8 {
        desk.harness.key_press(Key::L);
    }
    desk.rest(800);
    save(desk, "character");
    desk.harness.key_press(Key::Num5);
    save(desk, "needles");
    desk.harness.key_press(Key::Num5);
    desk.click("Export…");
    desk.rest(1200);
    save(desk, "character-export");
    desk.harness.key_press(Key::Escape);
    desk.harness.run_steps(3);
    // A motion from a clip, in the middle of marking and marked.
    let clip = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../data/gbot-walk/frames");
    desk.click("From a clip…");
    desk.type_path(clip.to_str().unwrap());
    desk.wait("the clip", |s| s.open().is_some_and(|o| !o.is_busy() && o.marks().is_empty()));
    desk.rest(1500);
    let marks = [
        (127.2, 155.9),
        (127.2, 112.0),
        (127.2, 66.0),
        (149.2, 119.7),
        (136.0, 143.1),
        (144.9, 167.6),
        (99.7, 119.7),
        (115.6, 140.4),
        (142.3, 149.2),
        (139.8, 159.0),
        (145.2, 185.3),
        (158.9, 218.0),
        (107.4, 163.1),
        (95.5, 185.4),
        (72.6, 211.9),
    ];
    for (i, at) in marks.into_iter().enumerate() {
        if i == 7 {
            desk.rest(500);
            save(desk, "capture");
        }
        let at = desk.open().on_clip(at);
        desk.click_at(at);
    }
    desk.wait("the motion", |s| s.open().is_some_and(|o| o.moves() && !o.is_busy()));
    desk.rest(800);
    save(desk, "captured");
    desk.harness.key_press(Key::G);
    for _ in 0..8 {
        desk.harness.key_press(Key::Period);
    }
    desk.rest(800);
    save(desk, "captured-moves");

    desk.click("To the start");
    desk.harness.run_steps(3);
}

pub fn drawing(desk: &mut Desk, save: Save<'_>) {
    // Points that were found, without a drawing yet.
    let clip = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../data/animals/kangaroo-hop.webp");
    desk.harness.state_mut().open_for_drawing(&clip);
    desk.wait_open();
    desk.rest(1500);
    save(desk, "unmarked");
    desk.click("Next: find points");
    desk.wait("points", |s| s.open().is_some_and(|o| o.marks().len() > 2));
    desk.wait("the points", |s| s.open().is_some_and(|o| !o.is_busy()));
    desk.rest(800);
    save(desk, "marks");
    // The horse: equal numbers, and in motion.
    desk.click("To the start");
    desk.harness.run_steps(3);
    desk.click("Open the sample: a horse that gallops");
    desk.wait("the horse to gallop", |s| s.open().is_some_and(|o| o.moves() && !o.is_busy() && o.pictures() > 8));
    stop_at(desk, 5);
    desk.rest(800);
    save(desk, "lives");
    desk.click("Numbers");
    for _ in 0..8 {
        desk.harness.key_press(Key::Period);
    }
    desk.rest(800);
    save(desk, "gallops");
    export(desk, save, "Lottie (.json)", "Pictures/A horse that gallops.json", "lives-export");
}
