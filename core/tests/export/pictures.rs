//! The GIFs, decoded by another program's reader.

use image::{AnimationDecoder, Frame, Rgb, RgbImage, codecs::gif::GifDecoder};
use marey::export::gif::{Schedule, encode};
use marey::export::{overlay, preview};
use marey::job::Progress;
use marey::{Error, Result};

use crate::model::animal;
use crate::scene::{SIZE, Scene};

fn decode(bytes: &[u8]) -> Vec<Frame> {
    let decoder = GifDecoder::new(std::io::Cursor::new(bytes)).expect("a GIF");
    decoder.into_frames().collect_frames().expect("frames")
}

fn milliseconds(frames: &[Frame]) -> u32 {
    frames.iter().map(|f| f.delay().numer_denom_ms()).map(|(n, d)| n / d).sum()
}

/// A disc over a gradient, one pixel further in every frame.
fn moving_disc(frame: usize) -> Result<RgbImage> {
    Ok(RgbImage::from_fn(90, 60, |x, y| {
        let (dx, dy) = (x as f32 - 20.0 - frame as f32, y as f32 - 30.0);
        if dx * dx + dy * dy < 100.0 { Rgb([255, 0, 255]) } else { Rgb([x as u8, 2 * y as u8, 90]) }
    }))
}

#[test]
fn every_frame_reads_back_close_to_what_was_drawn() {
    let schedule = Schedule::new(21, 25.0, 100);
    let bytes = encode(&schedule, &[[255, 0, 255]], moving_disc, Progress::new().whole()).expect("a GIF");
    let frames = decode(&bytes);
    assert_eq!(frames.len(), 21);
    assert_eq!(milliseconds(&frames), 840);
    for (f, frame) in frames.iter().enumerate() {
        let drawn = moving_disc(f).expect("drawn");
        let mut squares = 0.0;
        for (got, expected) in frame.buffer().pixels().zip(drawn.pixels()) {
            assert_eq!(got.0[3], 255);
            if expected.0 == [255, 0, 255] {
                assert!(got.0[..3].iter().zip(expected.0).all(|(a, b)| a.abs_diff(b) <= 7), "given colours stay");
            }
            squares += got.0.iter().zip(expected.0).map(|(a, b)| f64::from(a.abs_diff(b)).powi(2)).sum::<f64>();
        }
        assert!((squares / (90.0 * 60.0 * 3.0)).sqrt() < 5.0, "frame {f}");
    }
}

#[test]
fn the_same_on_one_thread_and_stopped_when_asked() {
    let schedule = Schedule::new(21, 25.0, 100);
    let run = || encode(&schedule, &[], moving_disc, Progress::new().whole()).expect("a GIF");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    assert_eq!(one.install(run), run());

    let progress = Progress::new();
    let stop = |frame: usize| {
        if frame == 11 {
            progress.cancel();
        }
        moving_disc(frame)
    };
    assert!(matches!(encode(&schedule, &[], stop, progress.whole()), Err(Error::Cancelled)));
    let sizes = |frame: usize| Ok(RgbImage::new(10 + frame as u32, 10));
    assert!(encode(&schedule, &[], sizes, Progress::new().whole()).is_err());
    assert!(encode(&Schedule::new(0, 25.0, 9), &[], moving_disc, Progress::new().whole()).is_err());
}

#[test]
fn the_overlay_shows_limbs_mask_and_time() {
    let scene = Scene::new(8);
    let clip = scene.clip();
    let show = |masks: &[marey::raster::Mask]| {
        overlay(&clip, &scene.rig, &scene.motion, masks, Progress::new().whole()).map(|b| decode(&b))
    };
    let frames = show(&scene.masks).expect("a GIF");
    assert_eq!((frames.len(), frames[0].buffer().dimensions()), (8, SIZE));
    let bare = show(&[]).expect("a GIF without masks");
    for f in [0, 3, 7] {
        let clip_frame = clip.frame(f).expect("a frame");
        // Beside every limb vertex there is colour that the clip does not have.
        for point in scene.motion.tracks.iter().flat_map(|t| &t.frames[f].points) {
            let (x, y) = (point.x as u32, point.y as u32);
            let (shown, filmed) = (bare[f].buffer().get_pixel(x, y).0, clip_frame.rgb.get_pixel(x, y).0);
            let change: u32 = shown.iter().zip(filmed).map(|(a, b)| u32::from(a.abs_diff(b))).sum();
            assert!(change > 60, "frame {f}, {point}: {shown:?} over {filmed:?}");
        }
        let brightness = |frames: &[Frame], x: u32, y: u32| -> u32 {
            frames[f].buffer().get_pixel(x, y).0[..3].iter().map(|v| u32::from(*v)).sum()
        };
        assert!(brightness(&frames, 5, 5) + 20 < brightness(&bare, 5, 5), "outside the mask it is dimmer");
        let inside = scene.motion.tracks[0].frames[f].points[2];
        let (x, y) = (inside.x as u32, inside.y as u32 - 8);
        assert!(brightness(&frames, x, y).abs_diff(brightness(&bare, x, y)) < 60, "inside it is much as filmed");
    }
    let bar = |f: usize| (0..SIZE.0).filter(|&x| frames[f].buffer().get_pixel(x, SIZE.1 - 2).0[0] > 128).count();
    assert!(bar(0) < bar(4) && bar(4) < bar(7), "the bar grows");

    let short = show(&scene.masks[..3]).err().expect("masks of another clip");
    assert!(short.to_string().contains("3 masks"), "{short}");
}

#[test]
fn the_preview_shows_the_creature_whole_from_two_sides() {
    let model = animal(9);
    let frames = decode(&preview(&model, Progress::new().whole()).expect("a GIF"));
    assert_eq!(frames.len(), 9);
    let (width, height) = frames[0].buffer().dimensions();
    for frame in &frames {
        let background = frame.buffer().get_pixel(0, 0).0;
        let covered = |x: u32, y: u32| frame.buffer().get_pixel(x, y).0 != background;
        for half in [0..width / 2 - 2, width / 2 + 2..width] {
            let count =
                half.clone().flat_map(|x| (0..height).map(move |y| (x, y))).filter(|&(x, y)| covered(x, y)).count();
            assert!(count > 500, "{count} pixels of the creature");
            for y in 0..height {
                assert!(!covered(half.start, y) && !covered(half.end - 1, y), "it never touches the border");
            }
        }
    }
    let progress = Progress::new();
    progress.cancel();
    assert!(matches!(preview(&model, progress.whole()), Err(Error::Cancelled)));
}
