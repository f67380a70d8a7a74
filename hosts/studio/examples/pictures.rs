//! Pictures of the studio's screens for its page in the docs, light and dark.
//!
//! `cargo run --release -p marey-studio --example pictures -- docs/pictures`
#![allow(clippy::print_stdout, reason = "it is what this is for")]
#![allow(clippy::unwrap_used, reason = "a picture that cannot be made has failed")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::path::PathBuf;
use std::sync::Arc;

use common::Desk;
use marey_studio::egui::{Key, Modifiers, Theme};

fn main() {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".into()));
    for (theme, ending) in [(Theme::Dark, ""), (Theme::Light, "-light")] {
        let mut desk = Desk::in_folder(Arc::new(tempfile::tempdir().unwrap()), theme);
        let save = |desk: &mut Desk, name: &str| {
            desk.harness.run_steps(4);
            let path = folder.join(format!("studio-{name}{ending}.png"));
            // The frame that the harness lays around everything.
            let (picture, edge) = (desk.harness.render().unwrap(), 8);
            let (width, height) = (picture.width() - 2 * edge, picture.height() - 2 * edge);
            image::imageops::crop_imm(&picture, edge, edge, width, height).to_image().save(&path).unwrap();
            println!("{}", path.display());
        };
        desk.harness.run_steps(60);
        std::thread::sleep(std::time::Duration::from_millis(800));
        save(&mut desk, "start");
        desk.click("Open the sample: a fox that walks");
        desk.wait_open();
        desk.wait("thumbnails", |s| s.open().is_some_and(|o| o.is_busy()));
        for _ in 0..60 {
            desk.harness.step();
            std::thread::sleep(std::time::Duration::from_millis(25));
        }
        save(&mut desk, "making");
        desk.wait("the creature", |s| s.open().is_some_and(|o| o.has_creature() && o.pictures() > 0));
        desk.harness.key_press(Key::Space);
        desk.harness.run_steps(3);
        desk.harness.key_press(Key::Home);
        for _ in 0..23 {
            desk.harness.key_press(Key::Period);
        }
        desk.click("Draw hind_near");
        for _ in 0..60 {
            desk.harness.step();
            std::thread::sleep(std::time::Duration::from_millis(25));
        }
        save(&mut desk, "creature");
        desk.harness.key_press(Key::Num3);
        desk.harness.key_press(Key::Num4);
        desk.harness.key_press(Key::V);
        desk.harness.key_press(Key::V);
        for _ in 0..60 {
            desk.harness.step();
            std::thread::sleep(std::time::Duration::from_millis(25));
        }
        save(&mut desk, "overlays");
        desk.click("Export…");
        desk.click("Animated WebP");
        for _ in 0..60 {
            desk.harness.step();
            std::thread::sleep(std::time::Duration::from_millis(25));
        }
        save(&mut desk, "export");
        desk.harness.key_press(Key::Escape);
        desk.harness.run_steps(3);
        desk.harness.key_press_modifiers(Modifiers::NONE, Key::F1);
        save(&mut desk, "keys");
    }
}
