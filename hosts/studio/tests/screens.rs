//! The screens look as they were reviewed: the pictures of the studio's page in the docs are what it shows now.
//!
//! Where one differs, look at both. If the new one is right, it belongs into the docs: the example `pictures` puts it there.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::print_stdout, reason = "it says where to look")]

mod common;

use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;

use common::Desk;
use common::screens::{self, DOCS};
use image::RgbImage;
use image::imageops::{FilterType, resize};
use marey_studio::egui::Theme;

/// Pixels of a block that is compared whole: the edges of letters may fall otherwise, and JPEG leaves its traces.
const BLOCK: u32 = 4;
/// A block is another one where a channel's mean differs by more.
const LEVELS: u8 = 28;
/// So many blocks may be others: a word that changed has more.
const MOST: usize = 30;
/// Looks, half a second apart, until a screen is as it was.
const PATIENCE: u32 = 20;

fn others(a: &RgbImage, b: &RgbImage) -> usize {
    if a.dimensions() != b.dimensions() {
        return usize::MAX;
    }
    let blocks = |i: &RgbImage| resize(i, i.width() / BLOCK, i.height() / BLOCK, FilterType::Triangle);
    let far = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| (0..3).any(|c| a[c].abs_diff(b[c]) > LEVELS);
    let (a, b) = (blocks(a), blocks(b));
    a.pixels().zip(b.pixels()).filter(|pair| far(*pair)).count()
}

#[test]
fn what_the_docs_show_is_what_a_person_sees() {
    if let Err(problem) = marey_binding::Context::new(1).unwrap().renderer(marey_binding::Adapter::Gpu) {
        println!("skipped: nothing draws here ({problem}); `cargo xtask test` installs a driver");
        return;
    }
    let mut desk = Desk::in_folder(Arc::new(tempfile::tempdir().unwrap()), Theme::Dark);
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/pictures");
    let seen = RefCell::new(Vec::new());
    let compare = |desk: &mut Desk, name: &str| {
        desk.harness.run_steps(4);
        if !DOCS.contains(&name) {
            return;
        }
        let reviewed = image::open(docs.join(format!("studio-{name}.jpg"))).unwrap().to_rgb8();
        let (mut now, mut different) = (RgbImage::new(1, 1), usize::MAX);
        // A frame that is still decoded on a busy machine is no other screen.
        for _ in 0..PATIENCE {
            now = screens::picture(desk).unwrap();
            different = others(&now, &reviewed);
            if different <= MOST {
                break;
            }
            desk.rest(500);
        }
        println!("{name}: {different} blocks differ");
        let aside = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("studio-{name}.png"));
        if different > MOST {
            now.save(&aside).unwrap();
        }
        seen.borrow_mut().push((name.to_owned(), different, aside));
    };
    desk.rest(1200);
    compare(&mut desk, "start");
    screens::creature(&mut desk, &compare);
    screens::character(&mut desk, &compare);
    screens::drawing(&mut desk, &compare);
    let seen = seen.into_inner();
    assert_eq!(seen.iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>(), DOCS);
    let changed: Vec<_> = seen.iter().filter(|(_, different, _)| *different > MOST).collect();
    assert!(changed.is_empty(), "these are not as they were reviewed: {changed:?}");
}

#[test]
fn a_word_that_changed_is_seen_and_the_traces_of_a_codec_are_not() {
    let screen =
        image::open(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/pictures/studio-start.jpg")).unwrap();
    let screen = screen.to_rgb8();
    let mut again = std::io::Cursor::new(Vec::new());
    screen.write_with_encoder(image::codecs::jpeg::JpegEncoder::new_with_quality(&mut again, 80)).unwrap();
    let again = image::load_from_memory(again.get_ref()).unwrap().to_rgb8();
    assert!(others(&screen, &again) <= MOST / 3);
    // The heading moves by ten points.
    let mut moved = screen.clone();
    let heading = image::imageops::crop_imm(&screen, 190, 100, 220, 50).to_image();
    image::imageops::replace(&mut moved, &heading, 200, 100);
    assert!(others(&screen, &moved) > 3 * MOST, "{}", others(&screen, &moved));
}
