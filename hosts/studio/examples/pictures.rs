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
use common::screens::{self, DOCS};
use image::codecs::jpeg::JpegEncoder;
use marey_studio::egui::{Key, Modifiers, Theme};

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
            desk.harness.run_steps(4);
            if !(all || DOCS.contains(&name)) {
                return;
            }
            let path = folder.join(format!("studio-{name}{ending}.jpg"));
            let picture = screens::picture(desk).unwrap();
            let file = std::fs::File::create(&path).unwrap();
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
            screens::creature(&mut desk, &save);
        }
        if wanted("character") {
            screens::character(&mut desk, &save);
        }
        if wanted("drawing") {
            screens::drawing(&mut desk, &save);
        }
    }
}
