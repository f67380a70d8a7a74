//! Clips of every kind that is read, in every order in which frames can be asked for.
//!
//! Each frame of the small clips under `data/clips` shows its own number as six black or white bars, lowest bit first,
//! above patches of four known colours, so that a wrong frame, order, turn or colour matrix cannot pass.

use std::path::PathBuf;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use marey::Error;
use marey::clip::{Clip, ClipOptions, FrameMemory, LentBytes, Picture};

fn fixture(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/clips").join(name)
}

fn open(name: &str) -> Clip {
    // Without a program to fall back on, a success is the embedded decoder's.
    let options = ClipOptions { ffmpeg: None, ..ClipOptions::default() };
    Clip::open_with(fixture(name), &options).unwrap_or_else(|e| panic!("{e}"))
}

fn frame(clip: &Clip, index: usize) -> Arc<Picture> {
    clip.frame(index).unwrap_or_else(|e| panic!("{e}"))
}

/// The number that a frame shows.
fn number(picture: &Picture) -> usize {
    (0..6).filter(|bit| picture.rgb.get_pixel(2 + 10 * bit + 5, 9).0[1] > 128).map(|bit| 1 << bit).sum()
}

const PATCHES: [[u8; 3]; 4] = [[200, 40, 40], [40, 180, 60], [50, 60, 200], [210, 200, 50]];

fn assert_colours(picture: &Picture, tolerance: u8) {
    for (i, patch) in PATCHES.iter().enumerate() {
        let seen = picture.rgb.get_pixel(16 * i as u32 + 8, 33).0;
        let off = (0..3).map(|c| seen[c].abs_diff(patch[c])).max().unwrap_or(0);
        assert!(off <= tolerance, "patch {i} is {seen:?}, drawn as {patch:?}");
    }
}

fn assert_counts_up(clip: &Clip, frames: usize, from: usize) {
    assert_eq!(clip.info().frames, frames);
    assert_eq!(clip.info().warnings, [""; 0]);
    for i in 0..frames {
        assert_eq!(number(&frame(clip, i)), from + i, "frame {i}");
    }
    assert!(clip.frame(frames).is_err() && clip.time(frames).is_err(), "there is no frame {frames}");
}

#[test]
fn reordered_frames_come_in_the_order_in_which_they_are_shown() {
    let clip = open("reordered.mp4");
    assert_counts_up(&clip, 30, 0);
    assert_eq!((clip.info().width, clip.info().height, clip.info().fps), (64, 48, 25.0));
    assert_eq!(clip.info().source, "mp4");
    for i in 0..30 {
        assert_colours(&frame(&clip, i), 10);
        assert!((clip.time(i).unwrap_or(-1.0) - i as f64 / 25.0).abs() < 1e-9);
    }
}

#[test]
fn any_order_of_asking_gives_the_same_pictures() {
    for name in ["reordered.mp4", "fragmented.mp4", "open_groups.mp4", "animated.gif", "animated.png", "animated.webp"]
    {
        let whole = open(name);
        let frames: Vec<_> = (0..whole.info().frames).map(|i| frame(&whole, i)).collect();
        // A cache of two pictures forces decoders to go back and to start anew.
        for cache_bytes in [0, 2 * 64 * 48 * 3, 256 << 20] {
            let options = ClipOptions { cache_bytes, ffmpeg: None, ..ClipOptions::default() };
            let clip = Clip::open_with(fixture(name), &options).unwrap_or_else(|e| panic!("{e}"));
            let mut state = 7usize;
            for _ in 0..60 {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                let i = (state >> 33) % frames.len();
                let picture = frame(&clip, i);
                assert_eq!(picture.rgb, frames[i].rgb, "{name}, frame {i}, cache of {cache_bytes} bytes");
                assert_eq!(picture.alpha, frames[i].alpha);
            }
        }
    }
}

#[test]
fn threads_share_a_clip() {
    for cache_bytes in [0, 3 * 64 * 48 * 3, 256 << 20] {
        let options = ClipOptions { cache_bytes, ..ClipOptions::default() };
        let clip = Clip::open_with(fixture("reordered.mp4"), &options).unwrap_or_else(|e| panic!("{e}"));
        std::thread::scope(|scope| {
            for thread in 0..8 {
                let clip = &clip;
                scope.spawn(move || {
                    for step in 0..40 {
                        let i = (thread * 11 + step * 7) % 30;
                        assert_eq!(number(&frame(clip, i)), i);
                    }
                });
            }
        });
    }
}

#[test]
fn cropping_and_fragments_and_sound_and_open_groups() {
    let cropped = open("cropped.mp4");
    assert_counts_up(&cropped, 8, 0);
    assert_eq!((cropped.info().width, cropped.info().height), (70, 54));
    assert_colours(&frame(&cropped, 3), 10);
    assert_counts_up(&open("fragmented.mp4"), 30, 0);
    assert_counts_up(&open("fragmented_early.mp4"), 30, 0);
    assert_counts_up(&open("sound.mov"), 10, 0);
    assert_counts_up(&open("open_groups.mp4"), 30, 0);
}

#[test]
fn a_cut_without_re_encoding_begins_where_it_was_cut() {
    let clip = open("trimmed.mp4");
    let first = number(&frame(&clip, 0));
    assert_eq!(first, 13, "cut at half a second of 25 frames a second");
    assert_counts_up(&clip, 17, first);
    assert_eq!(clip.time(0).ok(), Some(0.0));
}

#[test]
fn uneven_times_are_kept() {
    let clip = open("variable_rate.mp4");
    assert_counts_up(&clip, 12, 0);
    for i in 0..12 {
        let drawn = (30 * i + 5 * i * i) as f64 / 1000.0;
        assert!((clip.time(i).unwrap_or(-1.0) - drawn).abs() < 1e-3, "frame {i} at {:?}, not {drawn}", clip.time(i));
    }
}

#[test]
fn a_recording_held_upright_is_turned() {
    let lying = open("reordered.mp4");
    let turned = open("rotated.mp4");
    assert_eq!((turned.info().width, turned.info().height), (48, 64));
    for i in 0..turned.info().frames {
        let back = image::imageops::rotate90(&frame(&turned, i).rgb);
        assert_eq!(number(&frame(&lying, i)), i);
        assert!(back.as_raw()[..] == frame(&lying, i).rgb.as_raw()[..]);
    }
}

#[test]
fn colours_follow_the_matrix_and_range_of_the_stream() {
    let clip = open("full_range_709.mp4");
    assert_counts_up(&clip, 4, 0);
    (0..4).for_each(|i| assert_colours(&frame(&clip, i), 10));
    // The bars are drawn with 20 and 235: a wrong range stretches or squeezes them.
    let bar = frame(&clip, 1).rgb.get_pixel(7, 9).0;
    assert!(bar.iter().all(|v| v.abs_diff(235) <= 6), "a bar of 235 is {bar:?}");
}

/// The animations have a hole at the bottom right, and in odd frames a second one at the bottom left.
fn assert_holes(clip: &Clip) {
    for i in 0..clip.info().frames {
        let picture = frame(clip, i);
        let alpha = picture.alpha.as_ref().unwrap_or_else(|| panic!("frame {i} has holes"));
        assert_eq!(alpha.get_pixel(62, 46).0, [0], "frame {i}");
        assert_eq!(alpha.get_pixel(1, 46).0, [if i % 2 == 1 { 0 } else { 255 }], "frame {i}");
        assert_eq!(alpha.get_pixel(30, 30).0, [255], "frame {i}");
    }
}

#[test]
fn animations_are_composed_and_keep_their_holes() {
    for (name, source) in [("animated.gif", "gif"), ("animated.png", "apng"), ("animated.webp", "webp")] {
        let clip = open(name);
        assert_eq!(clip.info().source, source);
        assert_counts_up(&clip, 12, 0);
        assert_holes(&clip);
        assert_colours(&frame(&clip, 5), 8);
        let time = |i| clip.time(i).unwrap_or(-1.0);
        assert!((time(1) - 0.1).abs() < 1e-9 && (time(2) - 0.15).abs() < 1e-9, "frames last 0.1 and 0.05 s in turn");
    }
    let opaque = open("opaque.gif");
    assert_counts_up(&opaque, 12, 0);
    assert!(frame(&opaque, 7).alpha.is_none(), "nothing to see through");
}

#[test]
fn a_name_says_nothing() {
    let dir = tempfile::tempdir().expect("a folder");
    for (name, alias) in [("reordered.mp4", "clip.gif"), ("animated.gif", "clip.mp4"), ("animated.webp", "clip.png")] {
        let path = dir.path().join(alias);
        std::fs::copy(fixture(name), &path).expect("copied");
        let clip = Clip::open(&path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(clip.info().frames, open(name).info().frames);
    }
}

/// VP9 and 4:4:4 are for ffmpeg. Where there is none, the message has to say what to do.
#[test]
fn other_formats_go_through_ffmpeg_or_say_so() {
    let installed =
        ["ffmpeg", "ffprobe"].iter().all(|p| std::process::Command::new(p).arg("-version").output().is_ok());
    for (name, frames) in [("vp9.webm", 10), ("high_444.mp4", 4)] {
        for program in [None, Some("no-such-program-of-marey".into())] {
            let options = ClipOptions { ffmpeg: program, ..ClipOptions::default() };
            let message = Clip::open_with(fixture(name), &options).expect_err("no program").to_string();
            assert!(message.contains(name) && message.contains("ffmpeg") && message.contains("libx264"), "{message}");
        }
        if installed {
            let clip = Clip::open(fixture(name)).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(clip.info().source, "ffmpeg");
            assert_counts_up(&clip, frames, 0);
            assert_colours(&frame(&clip, 2), 12);
            assert_eq!(number(&frame(&clip, 1)), 1, "and back");
            assert_eq!(clip.info().fps, 25.0);
        }
    }
}

#[test]
fn frames_in_memory_are_a_clip() {
    let frames: Vec<_> = (0..5u8).map(|i| image::RgbImage::from_pixel(4, 3, image::Rgb([i, 0, 0]))).collect();
    let clip = Clip::from_frames(frames.clone(), 12.0).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((clip.info().frames, clip.info().fps), (5, 12.0));
    assert!((0..5).all(|i| frame(&clip, i).rgb.as_raw()[..] == frames[i].as_raw()[..]));
    assert!(Clip::from_frames(Vec::new(), 12.0).is_err());
    assert!(Clip::from_frames(frames.clone(), f64::NAN).is_err());
    let odd = [frames, vec![image::RgbImage::new(5, 3)]].concat();
    assert!(Clip::from_frames(odd, 12.0).expect_err("sizes differ").to_string().contains("frame 5"));
}

mod folders {
    use image::{Rgb, RgbImage, Rgba, RgbaImage};

    use super::*;

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let dir = tempfile::tempdir().expect("a folder");
        for (i, name) in names.iter().enumerate() {
            let path = dir.path().join(name);
            RgbImage::from_pixel(6, 4, Rgb([10 * i as u8, 0, 0])).save(path).expect("saved");
        }
        dir
    }

    fn reds(clip: &Clip) -> Vec<u8> {
        (0..clip.info().frames).map(|i| frame(clip, i).rgb.get_pixel(0, 0).0[0]).collect()
    }

    #[test]
    fn numbers_order_not_letters() {
        let dir = folder(&["walk10.png", "walk9.png", "walk2.PNG", "walk100.png"]);
        let clip = Clip::open(dir.path()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(reds(&clip), [20, 10, 0, 30]);
        assert!(clip.info().warnings[0].contains("95 numbers are missing"), "{:?}", clip.info().warnings);
        assert_eq!(clip.info().fps, 24.0);
        let options = ClipOptions { images_fps: 12.0, ..ClipOptions::default() };
        let slow = Clip::open_with(dir.path(), &options).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(slow.time(3).ok(), Some(0.25));
    }

    #[test]
    fn what_is_unclear_is_refused_by_name() {
        for (names, expected) in [
            (&["a1.png", "a2.png", "b1.png"][..], "more than one series"),
            (&["1.png", "01.png"], "both 01.png and 1.png"),
            (&["cover.png", "back.png"], "without a number"),
            (&[], "no images"),
        ] {
            let dir = folder(names);
            let message = Clip::open(dir.path()).expect_err(expected).to_string();
            assert!(message.contains(expected), "{names:?}: {message}");
        }
    }

    #[test]
    fn a_change_of_size_names_the_file() {
        let dir = folder(&["0.png", "1.png"]);
        RgbImage::new(7, 4).save(dir.path().join("2.png")).expect("saved");
        let message = Clip::open(dir.path()).expect_err("another size").to_string();
        assert!(message.contains("2.png") && message.contains("7x4") && message.contains("6x4"), "{message}");
    }

    #[test]
    fn a_damaged_image_spoils_only_its_frame() {
        let dir = folder(&["0.png", "1.png", "2.png", "3.png"]);
        let bytes = std::fs::read(dir.path().join("1.png")).expect("read");
        std::fs::write(dir.path().join("1.png"), &bytes[..bytes.len() / 2 + 10]).expect("written");
        std::fs::write(dir.path().join("2.png"), "no image").expect("written");
        let clip = Clip::open(dir.path()).unwrap_or_else(|e| panic!("{e}"));
        assert!(clip.info().warnings.iter().any(|w| w.contains("frame 2 (2.png)")), "{:?}", clip.info().warnings);
        assert!(clip.frame(1).expect_err("cut off").to_string().contains("1.png"));
        assert!(clip.frame(2).expect_err("text").to_string().contains("2.png"));
        assert!(clip.frame(0).is_ok() && clip.frame(3).is_ok());
    }

    #[test]
    fn opacity_is_kept() {
        let dir = tempfile::tempdir().expect("a folder");
        RgbaImage::from_pixel(3, 2, Rgba([1, 2, 3, 77])).save(dir.path().join("0.png")).expect("saved");
        let picture = frame(&Clip::open(dir.path()).unwrap_or_else(|e| panic!("{e}")), 0);
        assert_eq!(picture.rgb.get_pixel(0, 0).0, [1, 2, 3]);
        assert_eq!(picture.alpha.as_ref().map(|a| a.get_pixel(0, 0).0), Some([77]));
    }

    #[test]
    fn one_image_is_a_clip_of_one_frame() {
        let dir = folder(&["portrait.png"]);
        let clip = Clip::open(dir.path().join("portrait.png")).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((clip.info().frames, clip.info().width, clip.info().height), (1, 6, 4));
        assert!(clip.frame(0).is_ok());
    }
}

/// Lends memory, counts what is out, and has no more than so much.
#[derive(Debug)]
struct Lender {
    out: Arc<AtomicUsize>,
    most: AtomicUsize,
}

struct Lent {
    bytes: Vec<u8>,
    out: Arc<AtomicUsize>,
}

impl std::ops::Deref for Lent {
    type Target = [u8];
    fn deref(&self) -> &[u8] {
        &self.bytes
    }
}

impl LentBytes for Lent {}

impl Drop for Lent {
    fn drop(&mut self) {
        self.out.fetch_sub(self.bytes.len(), Ordering::Relaxed);
    }
}

impl FrameMemory for Lender {
    fn lend(&self, contents: &[u8]) -> Option<Box<dyn LentBytes>> {
        let bytes = contents.len();
        let out = self.out.fetch_add(bytes, Ordering::Relaxed) + bytes;
        if out > self.most.load(Ordering::Relaxed) {
            self.out.fetch_sub(bytes, Ordering::Relaxed);
            return None;
        }
        Some(Box::new(Lent { bytes: contents.to_vec(), out: self.out.clone() }))
    }
}

#[test]
fn frames_lie_in_lent_memory_and_give_it_back() {
    for name in ["reordered.mp4", "animated.gif", "animated.png", "animated.webp"] {
        let own = open(name);
        let out = Arc::new(AtomicUsize::new(0));
        let lender = Arc::new(Lender { out: out.clone(), most: AtomicUsize::new(usize::MAX) });
        let options = ClipOptions { ffmpeg: None, memory: Some(lender.clone()), ..ClipOptions::default() };
        let clip = Clip::open_with(fixture(name), &options).unwrap_or_else(|e| panic!("{e}"));
        for i in 0..own.info().frames {
            assert_eq!(frame(&clip, i).rgb, frame(&own, i).rgb, "{name}, frame {i}");
        }
        let picture = frame(&clip, 0);
        assert!(out.load(Ordering::Relaxed) >= own.info().frames * picture.rgb.as_raw().len());

        drop(clip);
        assert_eq!(out.load(Ordering::Relaxed), picture.rgb.as_raw().len(), "{name}: the picture outlives its clip");
        drop(picture);
        assert_eq!(out.load(Ordering::Relaxed), 0, "{name}");

        // Where no memory is lent the frame is refused, and comes when there is some again.
        let options = ClipOptions { cache_bytes: 0, ..options };
        let clip = Clip::open_with(fixture(name), &options).unwrap_or_else(|e| panic!("{e}"));
        lender.most.store(100, Ordering::Relaxed);
        let refused = clip.frame(1);
        assert!(matches!(refused, Err(Error::Memory { .. })), "{name}: {refused:?}");
        lender.most.store(usize::MAX, Ordering::Relaxed);
        assert_eq!(frame(&clip, 1).rgb, frame(&own, 1).rgb);
    }
}
