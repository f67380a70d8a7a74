//! Animations in every picture format, decoded by readers that did not write them: the `image` crate, and the clip reader
//! for what it does not read.

use std::path::Path;
use std::time::Duration;

use image::codecs::{gif::GifDecoder, png::PngDecoder, webp::WebPDecoder};
use image::{AnimationDecoder, Rgba, RgbaImage};
use marey::clip::{Clip, ClipOptions};
use marey::export::animation::{Animation, AnimationFormat, write};
use marey::job::Progress;
use marey::{Error, Result};

const FORMATS: [(AnimationFormat, &str); 6] = [
    (AnimationFormat::PngFolder, "frames"),
    (AnimationFormat::SpriteSheet, "sheet.json"),
    (AnimationFormat::Gif, "a.gif"),
    (AnimationFormat::Apng, "a.png"),
    (AnimationFormat::WebP, "a.webp"),
    (AnimationFormat::Mp4, "a.mp4"),
];
/// Odd, so that padding shows.
const SIZE: (u32, u32) = (121, 83);

/// A disc with an outline and a soft rim that goes around, over nothing; frames 5 and 6 are the same.
fn disc(frame: usize) -> Result<RgbaImage> {
    let frame = if frame == 6 { 5 } else { frame };
    let turn = frame as f32 * 0.5;
    let (cx, cy) = (60.0 + 34.0 * turn.cos(), 41.0 + 22.0 * turn.sin());
    Ok(RgbaImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let gap = (x as f32 + 0.5 - cx).hypot(y as f32 + 0.5 - cy) - 15.0;
        let alpha = (255.0 * (0.5 - gap).clamp(0.0, 1.0)) as u8;
        if gap > -3.0 { Rgba([40, 20, 60, alpha]) } else { Rgba([240, 180 - x as u8, 60 + y as u8, alpha]) }
    }))
}

fn animation<'a>(frames: usize, fps: f64, draw: &'a (dyn Fn(usize) -> Result<RgbaImage> + Sync)) -> Animation<'a> {
    Animation { name: "disc", frames, fps, size: SIZE, pivot: [0.5, 1.0], draw }
}

fn over(p: [u8; 4], ground: u8) -> [u8; 3] {
    let a = u32::from(p[3]);
    [0, 1, 2].map(|c| ((u32::from(p[c]) * a + u32::from(ground) * (255 - a) + 127) / 255) as u8)
}

/// The mean difference over a background.
fn apart(a: &RgbaImage, b: &RgbaImage, ground: u8) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let off = |(p, q): (&Rgba<u8>, &Rgba<u8>)| -> u32 {
        over(p.0, ground).iter().zip(over(q.0, ground)).map(|(a, b)| u32::from(a.abs_diff(b))).sum()
    };
    f64::from(a.pixels().zip(b.pixels()).map(off).sum::<u32>()) / f64::from(3 * a.width() * a.height())
}

fn same(a: &RgbaImage, b: &RgbaImage) -> bool {
    a.dimensions() == b.dimensions() && a.pixels().zip(b.pixels()).all(|(p, q)| p == q || (p.0[3] == 0 && q.0[3] == 0))
}

/// Frames and seconds for which each is shown, as the `image` crate reads them.
fn decoded(path: &Path) -> Vec<(RgbaImage, f64)> {
    let file = || std::io::BufReader::new(std::fs::File::open(path).expect("opened"));
    let frames = match path.extension().and_then(|e| e.to_str()) {
        Some("gif") => GifDecoder::new(file()).expect("a GIF").into_frames(),
        Some("png") => PngDecoder::new(file()).expect("a PNG").apng().expect("animated").into_frames(),
        _ => WebPDecoder::new(file()).expect("a WebP").into_frames(),
    };
    let frames = frames.collect_frames().expect("frames");
    frames
        .into_iter()
        .map(|f| {
            let d = Duration::from(f.delay());
            (f.into_buffer(), d.as_secs_f64())
        })
        .collect()
}

fn read(clip: &Clip, frame: usize) -> RgbaImage {
    let picture = clip.frame(frame).expect("a frame");
    RgbaImage::from_fn(clip.info().width, clip.info().height, |x, y| {
        let [r, g, b] = picture.rgb.get_pixel(x, y).0;
        Rgba([r, g, b, picture.alpha.as_ref().map_or(255, |a| a.get_pixel(x, y).0[0])])
    })
}

fn clip(path: &Path) -> Clip {
    // Without a program to fall back on, a success is the embedded decoder's.
    Clip::open_with(path, &ClipOptions { ffmpeg: None, ..ClipOptions::default() }).expect("a clip")
}

#[test]
fn every_format_comes_back_as_it_was_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    for fps in [24.0, 24_000.0 / 1001.0, 12.5] {
        let disc = animation(19, fps, &disc);
        for (format, name) in FORMATS {
            let path = folder.path().join(format!("{fps:.0}-{name}"));
            let files = write(&path, format, &disc, Progress::new().whole()).expect("written");
            assert!(files.iter().all(|f| f.exists()));
            if matches!(format, AnimationFormat::Gif | AnimationFormat::Apng | AnimationFormat::WebP) {
                let frames = decoded(&path);
                assert_eq!(frames.len(), 19, "{name}");
                let total: f64 = frames.iter().map(|f| f.1).sum();
                // Whole hundredths and thousandths of a second, and `image`'s rounding of 19 fractions.
                let rounding = if format == AnimationFormat::Gif { 0.0051 } else { 0.0011 };
                assert!((total - 19.0 / fps).abs() < rounding, "{name}: {total}");
                for (f, (got, _)) in frames.iter().enumerate() {
                    let drawn = (disc.draw)(f).expect("drawn");
                    if format == AnimationFormat::Gif {
                        assert!(got.pixels().all(|p| p.0[3] == 0 || p.0[3] == 255));
                        for ground in [0, 255] {
                            assert!(apart(got, &drawn, ground) < 2.0, "{f}: {}", apart(got, &drawn, ground));
                        }
                        // Nothing stays behind, and nothing is missing.
                        let wrong = |(a, b): &(&Rgba<u8>, &Rgba<u8>)| (a.0[3] > 0) != (b.0[3] >= 128);
                        assert_eq!(got.pixels().zip(drawn.pixels()).filter(wrong).count(), 0, "{f}");
                    } else {
                        assert!(same(got, &drawn), "frame {f} of {name}");
                    }
                }
            }
            if format == AnimationFormat::SpriteSheet {
                continue;
            }
            let clip = clip(&path);
            assert_eq!(clip.info().frames, 19, "{name}");
            let exact = matches!(format, AnimationFormat::Apng | AnimationFormat::Mp4);
            for f in 0..19 {
                let drawn = (disc.draw)(f).expect("drawn");
                let got = read(&clip, f);
                match format {
                    AnimationFormat::Mp4 => {
                        assert_eq!(got.dimensions(), (122, 84));
                        let got = image::imageops::crop_imm(&got, 0, 0, SIZE.0, SIZE.1).to_image();
                        assert!(apart(&got, &drawn, 255) < 2.0, "{f}: {}", apart(&got, &drawn, 255));
                    }
                    AnimationFormat::Gif => assert!(apart(&got, &drawn, 0) < 2.0),
                    _ => assert!(same(&got, &drawn), "frame {f} of {name}"),
                }
                if exact {
                    let (at, expected) = (clip.time(f).expect("a time"), f as f64 / fps);
                    assert!((at - expected).abs() < 1e-9, "{name}: {at} and not {expected}");
                }
            }
        }
    }
}

#[test]
fn one_frame_is_an_animation_and_so_are_pictures_of_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let clear = |_| Ok(RgbaImage::new(SIZE.0, SIZE.1));
    for (format, name) in FORMATS {
        for (draw, frames) in [(&disc as &(dyn Fn(usize) -> Result<RgbaImage> + Sync), 1), (&clear, 3)] {
            let path = folder.path().join(format!("{frames}-{name}"));
            write(&path, format, &animation(frames, 24.0, draw), Progress::new().whole()).expect("written");
            if format != AnimationFormat::SpriteSheet {
                let clip = clip(&path);
                assert_eq!(clip.info().frames, frames, "{name}");
                let drawn = draw(frames - 1).expect("drawn");
                let got = image::imageops::crop_imm(&read(&clip, frames - 1), 0, 0, SIZE.0, SIZE.1).to_image();
                assert!(apart(&got, &drawn, 255) < 2.0, "{name}");
            }
        }
    }
}

/// The frames of a sprite sheet, put together as its JSON says.
fn from_sheets(json: &Path) -> Vec<(String, RgbaImage, u64)> {
    let text = std::fs::read_to_string(json).expect("read");
    let index: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let meta = &index["meta"];
    let image = image::open(json.with_file_name(meta["image"].as_str().expect("a name"))).expect("a sheet").to_rgba8();
    assert_eq!((u64::from(image.width()), u64::from(image.height())), {
        (meta["size"]["w"].as_u64().expect("a width"), meta["size"]["h"].as_u64().expect("a height"))
    });
    let rect = |v: &serde_json::Value| ["x", "y", "w", "h"].map(|k| v[k].as_u64().unwrap_or(0) as u32);
    let frame = |(name, f): (&String, &serde_json::Value)| {
        let ([x, y, w, h], [sx, sy, sw, sh]) = (rect(&f["frame"]), rect(&f["spriteSourceSize"]));
        assert_eq!((w, h), (sw, sh));
        let [_, _, width, height] = rect(&f["sourceSize"]);
        let mut out = RgbaImage::new(width, height);
        let part = image::imageops::crop_imm(&image, x, y, w, h).to_image();
        image::imageops::replace(&mut out, &part, sx.into(), sy.into());
        (name.clone(), out, f["duration"].as_u64().expect("a duration"))
    };
    index["frames"].as_object().expect("frames").iter().map(frame).collect()
}

#[test]
fn sprite_sheets_hold_every_frame_trimmed_and_as_many_sheets_as_it_takes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("disc.png");
    let files = write(&path, AnimationFormat::SpriteSheet, &animation(19, 12.5, &disc), Progress::new().whole());
    assert_eq!(files.expect("written"), ["disc.png", "disc.json"].map(|n| folder.path().join(n)));
    let frames = from_sheets(&folder.path().join("disc.json"));
    assert_eq!(frames.len(), 19);
    assert_eq!(frames.iter().map(|f| f.2).sum::<u64>(), 1520);
    for (f, (name, picture, _)) in frames.iter().enumerate() {
        assert!(name == &format!("disc {f:05}") && same(picture, &disc(f).expect("drawn")), "{name}");
    }
    // Discs of 31 pixels, trimmed, and two of them the same: 18 with their gaps.
    let sheet = image::open(&path).expect("a sheet");
    assert!(sheet.width() * sheet.height() < 2 * 18 * 34 * 34, "{}x{}", sheet.width(), sheet.height());

    let corners = |frame: usize| {
        let mut picture = RgbaImage::new(4100, 4100);
        picture.put_pixel(0, 0, Rgba([9, 8, 7, 255]));
        picture.put_pixel(4099, 4099, Rgba([frame as u8, 8, 7, 255]));
        Ok(picture)
    };
    let large = Animation { size: (4100, 4100), ..animation(2, 24.0, &corners) };
    let files = write(&folder.path().join("b"), AnimationFormat::SpriteSheet, &large, Progress::new().whole());
    let files = files.expect("written");
    assert_eq!(files, ["b-0.png", "b-0.json", "b-1.png", "b-1.json"].map(|n| folder.path().join(n)));
    for (f, file) in [&files[1], &files[3]].into_iter().enumerate() {
        let frames = from_sheets(file);
        assert_eq!(frames.len(), 1);
        assert_eq!(frames[0].1.get_pixel(4099, 4099).0, [f as u8, 8, 7, 255]);
    }
}

#[test]
fn what_cannot_be_written_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let empty = || std::fs::read_dir(folder.path()).expect("listed").count() == 0;
    for (format, name) in FORMATS {
        let path = folder.path().join(name);
        let fails = |animation: &Animation<'_>, path: &Path| {
            let error = write(path, format, animation, Progress::new().whole()).expect_err("refused");
            assert!(empty(), "{format:?} left something after {error}");
            error.to_string()
        };
        assert!(fails(&animation(0, 24.0, &disc), &path).contains("no frames"));
        for rate in [0.0, -1.0, f64::NAN, 1e9] {
            assert!(fails(&animation(9, rate, &disc), &path).contains("rate"));
        }
        let grows = |f: usize| Ok(RgbaImage::new(SIZE.0 + f as u32 / 9, SIZE.1));
        assert!(fails(&animation(12, 24.0, &grows), &path).contains("size"), "{format:?}");
        let breaks = |f: usize| if f == 11 { Err(Error::invalid("frame", "is broken", "mend it")) } else { disc(f) };
        assert!(fails(&animation(19, 24.0, &breaks), &path).contains("broken"));
        if format != AnimationFormat::PngFolder {
            assert!(fails(&animation(9, 24.0, &disc), &folder.path().join("missing").join(name)).contains("missing"));
        }
        let progress = Progress::new();
        let stop = |f: usize| {
            if f == 11 {
                progress.cancel();
            }
            disc(f)
        };
        let cancelled = write(&path, format, &animation(19, 24.0, &stop), progress.whole());
        assert!(matches!(cancelled, Err(Error::Cancelled)) && empty(), "{format:?}");
    }
    let wide = |_| Ok(RgbaImage::new(20_000, 2));
    let wide = Animation { size: (20_000, 2), ..animation(1, 24.0, &wide) };
    for (format, name) in [(AnimationFormat::WebP, "w.webp"), (AnimationFormat::Mp4, "w.mp4")] {
        let refused = write(&folder.path().join(name), format, &wide, Progress::new().whole());
        assert!(matches!(refused, Err(Error::Limit { .. })) && empty(), "{format:?}");
    }
}

#[test]
fn the_same_bytes_on_one_thread() {
    let folder = tempfile::tempdir().expect("a folder");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    for (format, name) in FORMATS {
        if format == AnimationFormat::PngFolder {
            continue;
        }
        let run = |name: String| {
            let written =
                write(&folder.path().join(name), format, &animation(19, 24.0, &disc), Progress::new().whole());
            std::fs::read(&written.expect("written")[0]).expect("read")
        };
        let alone = one.install(|| run(format!("one-{name}")));
        assert_eq!(alone, run(name.to_owned()), "{format:?}");
    }
}
