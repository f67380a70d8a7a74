//! Pictures of the studio's screens: those of its page in the docs, or `all`, light and dark; of one door only where a
//! third word is `creature`, `character` or `drawing`.
//!
//! `cargo run --release -p marey-studio --example pictures -- docs/pictures`, after `cargo build --release -p marey-flow-tracker
//! -p marey-grab-cut`, whose plugins the pictures show.
#![allow(clippy::print_stdout, reason = "it is what this is for")]
#![allow(clippy::unwrap_used, reason = "a picture that cannot be made has failed")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::path::PathBuf;
use std::sync::Arc;

use common::Desk;
use egui_kittest::kittest::Queryable as _;
use image::codecs::jpeg::JpegEncoder;
use marey_studio::egui::{Key, Modifiers, Theme};

/// What the page shows.
const DOCS: [&str; 7] = ["start", "drawing", "creature", "export", "character", "lives", "lives-export"];

fn main() {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".into()));
    let all = std::env::args().nth(2).is_some_and(|a| a == "all");
    for (theme, ending) in [(Theme::Dark, ""), (Theme::Light, "-light")] {
        if theme == Theme::Light && !all {
            continue;
        }
        let mut desk = Desk::in_folder(Arc::new(tempfile::tempdir().unwrap()), theme);
        let plugins = desk.folder.path().join("data/plugins");
        let built = std::env::current_exe().unwrap().parent().unwrap().join("..");
        for name in ["libflow_tracker.so", "libgrab_cut.so"] {
            // Without them there is a list without them.
            let _ = std::fs::copy(built.join(name), plugins.join(name));
        }
        std::fs::write(plugins.join("half-built.so"), "no library yet").unwrap();
        let save = |desk: &mut Desk, name: &str| {
            if !(all || DOCS.contains(&name)) {
                return;
            }
            desk.harness.run_steps(4);
            let path = folder.join(format!("studio-{name}{ending}.jpg"));
            // The frame that the harness lays around everything.
            let (picture, edge) = (desk.harness.render().unwrap(), 8);
            let (width, height) = (picture.width() - 2 * edge, picture.height() - 2 * edge);
            let picture = image::imageops::crop_imm(&picture, edge, edge, width, height).to_image();
            let file = std::fs::File::create(&path).unwrap();
            let picture = image::DynamicImage::from(picture).to_rgb8();
            // Half a dozen times smaller than PNG, and letters are still clean.
            picture.write_with_encoder(JpegEncoder::new_with_quality(file, 88)).unwrap();
            println!("{}", path.display());
        };
        if theme == Theme::Light {
            desk.harness.step();
            desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::L);
        }
        let door = std::env::args().nth(3);
        let wanted = |name: &str| door.as_ref().is_none_or(|door| door == name);
        desk.rest(1200);
        save(&mut desk, "start");
        if wanted("creature") {
            creature(&mut desk, &save);
        }
        if wanted("character") {
            character(&mut desk, &save);
        }
        if wanted("drawing") {
            drawing(&mut desk, &save);
        }
    }
}

/// Keeps a picture under a name.
type Save<'a> = &'a dyn Fn(&mut Desk, &str);

fn creature(desk: &mut Desk, save: Save<'_>) {
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
    desk.harness.key_press(Key::Space);
    desk.harness.run_steps(3);
    desk.harness.key_press(Key::Home);
    for _ in 0..23 {
        desk.harness.key_press(Key::Period);
    }
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
    desk.click("Export…");
    desk.click("Animated WebP");
    desk.click("File");
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    desk.harness.step();
    desk.harness.get_by_label("File").type_text("/home/ada/Pictures/A fox that walks.webp");
    desk.harness.step();
    desk.harness.key_press(Key::Enter);
    desk.rest(1500);
    save(desk, "export");
    desk.harness.key_press(Key::Escape);
    desk.harness.run_steps(3);
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

fn character(desk: &mut Desk, save: Save<'_>) {
    // As it walks, with a joint selected.
    desk.click("Open the sample: a girl who waves");
    desk.wait("the girl to walk", |s| s.open().is_some_and(|o| o.moves() && !o.is_busy() && o.pictures() > 8));
    desk.harness.key_press(Key::Space);
    desk.harness.run_steps(3);
    desk.harness.key_press(Key::Home);
    for _ in 0..6 {
        desk.harness.key_press(Key::Period);
    }
    for _ in 0..8 {
        desk.harness.key_press(Key::L);
    }
    desk.rest(800);
    save(desk, "character");
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
        (127.2, 147.2),
        (127.2, 103.2),
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

fn drawing(desk: &mut Desk, save: Save<'_>) {
    // While points are marked, without a drawing yet.
    let clip = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../data/animals/kangaroo-hop.webp");
    desk.harness.state_mut().open_for_drawing(&clip);
    desk.wait_open();
    desk.rest(1500);
    save(desk, "unmarked");
    for at in [
        (22.0, 180.0),
        (148.0, 58.0),
        (280.0, 128.0),
        (226.0, 312.0),
        (370.0, 330.0),
        (286.0, 442.0),
        (425.0, 290.0),
        (500.0, 334.0),
    ] {
        let at = desk.open().on_screen(at);
        desk.click_at(at);
    }
    desk.wait("the points", |s| s.open().is_some_and(|o| !o.is_busy()));
    desk.rest(800);
    save(desk, "marks");
    // The horse: equal numbers, and in motion.
    desk.click("To the start");
    desk.harness.run_steps(3);
    desk.click("Open the sample: a horse that gallops");
    desk.wait("the horse to gallop", |s| s.open().is_some_and(|o| o.moves() && !o.is_busy() && o.pictures() > 8));
    desk.harness.key_press(Key::Space);
    desk.harness.run_steps(3);
    desk.harness.key_press(Key::Home);
    for _ in 0..5 {
        desk.harness.key_press(Key::Period);
    }
    desk.rest(800);
    save(desk, "lives");
    desk.click("Numbers");
    for _ in 0..8 {
        desk.harness.key_press(Key::Period);
    }
    desk.rest(800);
    save(desk, "gallops");
    desk.click("Export…");
    desk.click("Lottie (.json)");
    desk.click("File");
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    desk.harness.step();
    desk.harness.get_by_label("File").type_text("/home/ada/Pictures/A horse that gallops.json");
    desk.harness.step();
    desk.harness.key_press(Key::Enter);
    desk.rest(1200);
    save(desk, "lives-export");
    desk.harness.key_press(Key::Escape);
    desk.harness.run_steps(3);
}
