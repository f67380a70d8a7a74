//! Clips that are cut off, damaged, empty, enormous or something else: what can be used is offered, and what cannot is
//! said by name. Nothing panics.

use std::path::{Path, PathBuf};

use marey::clip::{Clip, ClipOptions};
use marey::{Category, Error};

/// Those that are read without another program.
const OWN: [&str; 13] = [
    "reordered.mp4",
    "cropped.mp4",
    "rotated.mp4",
    "variable_rate.mp4",
    "fragmented.mp4",
    "fragmented_early.mp4",
    "full_range_709.mp4",
    "trimmed.mp4",
    "sound.mov",
    "animated.gif",
    "opaque.gif",
    "animated.png",
    "animated.webp",
];

fn fixture(name: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/clips").join(name);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn open(path: &Path) -> marey::Result<Clip> {
    Clip::open_with(path, &ClipOptions { ffmpeg: None, ..ClipOptions::default() })
}

struct Scratch {
    dir: tempfile::TempDir,
}

impl Scratch {
    fn new() -> Self {
        Self { dir: tempfile::tempdir().expect("a folder") }
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.dir.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        path
    }
}

fn number(clip: &Clip, index: usize) -> Option<usize> {
    let picture = clip.frame(index).ok()?;
    Some((0..6).filter(|bit| picture.rgb.get_pixel(2 + 10 * bit + 5, 9).0[1] > 128).map(|bit| 1 << bit).sum())
}

#[test]
fn a_file_cut_off_anywhere_offers_what_came_before() {
    let scratch = Scratch::new();
    for name in ["reordered.mp4", "fragmented.mp4", "animated.gif", "opaque.gif", "animated.png", "animated.webp"] {
        let bytes = fixture(name);
        let all = open(&scratch.file(name, &bytes)).expect("whole").info().frames;
        let mut offered = 0;
        // Up to the last byte that matters: a GIF's trailer says only that nothing follows.
        for length in (1..bytes.len() - 1).step_by(61) {
            let path = scratch.file(name, &bytes[..length]);
            match open(&path) {
                Err(error) => {
                    assert!(error.to_string().contains(name), "{name} cut to {length}: {error}");
                    assert_eq!(error.category(), Category::BadInput);
                    assert_eq!(offered, 0, "{name} cut to {length} offers less than when cut shorter");
                }
                Ok(clip) => {
                    let frames = clip.info().frames;
                    assert!(frames >= offered, "{name} cut to {length} offers less than when cut shorter");
                    offered = frames;
                    for i in 0..frames {
                        assert_eq!(number(&clip, i), Some(i), "{name} cut to {length}, frame {i} of {frames}");
                    }
                    let warned = clip.info().warnings.iter().any(|w| w.contains(&frames.to_string()));
                    let tail_only = frames == all && length > bytes.len() * 3 / 4;
                    assert!(warned || tail_only, "{name} cut to {length}: {:?}", clip.info());
                }
            }
        }
        assert!(offered > all / 2, "{name}: only {offered} of {all} frames even when most of the file is there");
    }
}

#[test]
fn a_recording_without_its_index_says_so() {
    let scratch = Scratch::new();
    let bytes = fixture("cropped.mp4");
    let index = bytes.windows(4).position(|w| w == b"moov").expect("an index");
    let message = open(&scratch.file("cut.mp4", &bytes[..index - 100])).expect_err("no index").to_string();
    assert!(message.contains("cut.mp4") && message.contains("index") && message.contains("cut off"), "{message}");
}

#[test]
fn flipped_bits_never_panic() {
    let scratch = Scratch::new();
    for (i, name) in OWN.iter().enumerate() {
        let bytes = fixture(name);
        for place in (i % 7..bytes.len()).step_by(29) {
            for flip in [0xff, 0x01] {
                let mut damaged = bytes.clone();
                damaged[place] ^= flip;
                match open(&scratch.file(name, &damaged)) {
                    Err(error) => assert!(error.to_string().contains(name), "{name}, byte {place}: {error}"),
                    Ok(clip) => {
                        for frame in 0..clip.info().frames.min(60) {
                            match clip.frame(frame) {
                                Ok(picture) => {
                                    assert_eq!(
                                        picture.rgb.dimensions(),
                                        (clip.info().width, clip.info().height),
                                        "{name}, byte {place}, frame {frame}"
                                    );
                                }
                                Err(error) => {
                                    let text = error.to_string();
                                    assert!(text.contains(&format!("frame {frame}")) && text.contains(name), "{text}");
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// In a clip with a start every ten frames, damage in the second ten leaves the first and the third.
#[test]
fn damage_midway_spoils_only_what_builds_on_it() {
    let scratch = Scratch::new();
    let bytes = fixture("reordered.mp4");
    let data = bytes.windows(4).position(|w| w == b"mdat").expect("pictures");
    let mut found = false;
    for place in (data..bytes.len()).step_by(3) {
        let mut damaged = bytes.clone();
        damaged[place..(place + 8).min(bytes.len())].fill(0xff);
        let Ok(clip) = open(&scratch.file("damaged.mp4", &damaged)) else { continue };
        let bad: Vec<usize> = (0..30).filter(|&i| clip.frame(i).is_err()).collect();
        let Some(&first) = bad.iter().find(|i| (11..20).contains(*i)) else { continue };
        if bad.iter().any(|i| !(10..20).contains(i)) {
            continue;
        }
        found = true;
        for i in (0..10).chain(20..30) {
            assert_eq!(number(&clip, i), Some(i), "damage at byte {place}");
        }
        let message = clip.frame(first).expect_err("damaged").to_string();
        assert!(message.contains(&format!("frame {first} ")) && message.contains("byte"), "{message}");
        // Decoding begins at frame 10, or at frame 0 where frame 10 itself cannot be recognised any more.
        let good = match bad[0] {
            10 => ["the frames before frame 10 are not touched", "the 10 frames before frame 10 are good"].to_vec(),
            11 => vec!["the frame before it is good"],
            _ => vec!["frames before it are good"],
        };
        assert!(good.iter().any(|g| message.contains(g)), "{message}; bad are {bad:?}");
    }
    assert!(found, "no damage stayed within the second ten frames");
}

#[test]
fn what_is_no_clip_is_refused_by_name() {
    let scratch = Scratch::new();
    let cases: [(&str, &[u8], &str); 6] = [
        ("empty.mp4", b"", "is empty"),
        ("notes.mp4", b"Dear diary, today I filmed a horse.", "no kind of video"),
        ("header.mp4", b"\0\0\0\x14ftypisom\0\0\0\0isom", "index"),
        ("header.gif", b"GIF89a", "cut off"),
        ("header.png", b"\x89PNG\r\n\x1a\n", "no readable image"),
        ("header.webp", b"RIFF\x04\0\0\0WEBP", "no readable image"),
    ];
    for (name, bytes, expected) in cases {
        let error = open(&scratch.file(name, bytes)).expect_err(name);
        let message = error.to_string();
        assert!(message.contains(name) && message.contains(expected), "{message}");
        assert!(matches!(error, Error::File { .. }), "{message}");
    }
    let missing = open(&scratch.dir.path().join("nowhere.mp4")).expect_err("nothing there");
    assert!(missing.to_string().contains("nowhere.mp4"));
    assert_eq!(missing.category(), Category::BadInput);
}

/// Where ffmpeg is installed it must not find a film in a text.
#[test]
fn text_is_no_video_for_ffmpeg_either() {
    let scratch = Scratch::new();
    let path = scratch.file("diary.txt", "Dear diary, today I filmed a horse.\n".repeat(50).as_bytes());
    let message = Clip::open(&path).expect_err("text").to_string();
    assert!(message.contains("diary.txt"), "{message}");
}

#[test]
fn enormous_pictures_are_refused_before_they_cost_memory() {
    let scratch = Scratch::new();
    let mut gif = fixture("opaque.gif");
    gif[6..10].fill(0xff);
    let mut png = fixture("animated.png");
    png[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
    let mut webp = fixture("animated.webp");
    webp[24..30].fill(0xff);
    for (name, bytes) in [("bomb.gif", gif), ("bomb.png", png), ("bomb.webp", webp)] {
        let error = open(&scratch.file(name, &bytes)).expect_err("enormous");
        assert_eq!(error.category(), Category::Limit, "{error}");
        assert!(error.to_string().contains(name), "{error}");
    }
    for name in OWN {
        let options = ClipOptions { max_pixels: 64 * 48 - 1, ffmpeg: None, ..ClipOptions::default() };
        let error = Clip::open_with(scratch.file(name, &fixture(name)), &options).expect_err("too large");
        assert_eq!(error.category(), Category::Limit, "{error}");
    }
}

/// The sample table of this file lies before its data; four billion samples in it must neither be believed nor counted.
#[test]
fn absurd_counts_are_not_believed() {
    let scratch = Scratch::new();
    let bytes = fixture("reordered.mp4");
    let body = |name: &[u8; 4]| bytes.windows(4).position(|w| w == name).expect("a table") + 4;
    let (sizes, durations, chunks) = (body(b"stsz"), body(b"stts"), body(b"stsc"));
    for (size, count) in [(1u32, u32::MAX), (0, u32::MAX), (u32::MAX, u32::MAX), (1, 1 << 21)] {
        let mut absurd = bytes.clone();
        absurd[sizes + 4..sizes + 8].copy_from_slice(&size.to_be_bytes());
        absurd[sizes + 8..sizes + 12].copy_from_slice(&count.to_be_bytes());
        absurd[durations + 8..durations + 12].copy_from_slice(&u32::MAX.to_be_bytes());
        absurd[chunks + 12..chunks + 16].copy_from_slice(&u32::MAX.to_be_bytes());
        match open(&scratch.file("absurd.mp4", &absurd)) {
            Err(error) => assert!(error.to_string().contains("absurd.mp4"), "{error}"),
            Ok(clip) => assert!(clip.info().frames <= 30 && !clip.info().warnings.is_empty(), "{:?}", clip.info()),
        }
    }
}
