//! Rigs a picture, moves an arm and a leg, draws every frame and writes every picture format; says how far each comes back
//! from what was drawn, how large it is and how long it took. A contact sheet shows frames over a checkerboard.
//!
//! `take_eval PICTURE OUT_FOLDER [RIG.json POSES.json]`
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::path::Path;
use std::time::Instant;

use glam::Vec2;
use image::{Rgba, RgbaImage};
use marey::clip::Clip;
use marey::deform::needles::NeedleDeformer;
use marey::export::take::{TakeFormat, TakeOptions, TakeSubject, write_take};
use marey::job::Progress;
use marey::shape::character::{
    Animation, Canvas, Character, Drawing, Easing, KeyPose, Poses, RigParams, Take, cut_out,
};

/// The joints below `joint`, and itself.
fn limb(character: &Character, joint: usize) -> Vec<usize> {
    let mut found = vec![joint];
    let mut next = 0;
    while next < found.len() {
        let at = found[next];
        found.extend(character.skeleton.bones.iter().filter(|b| b[0] == at).map(|b| b[1]));
        next += 1;
    }
    found
}

/// Swings two limbs: the ends farthest to the left and farthest down, from the joint above the one they hang on.
fn swings(character: &Character) -> Poses {
    let skeleton = &character.skeleton;
    let rest = skeleton.rest();
    let parent = |j: usize| skeleton.bones.iter().find(|b| b[1] == j).map(|b| b[0]);
    let ends: Vec<usize> = (0..rest.len()).filter(|&j| skeleton.bones.iter().all(|b| b[0] != j)).collect();
    let farthest = |way: Vec2| ends.iter().copied().max_by(|a, b| rest[*a].dot(way).total_cmp(&rest[*b].dot(way)));
    let mut poses = Poses { fps: 24.0, step: 1, keys: Vec::new() };
    let swung = |turns: &[(usize, f32)]| {
        let mut joints = rest.clone();
        for &(end, turn) in turns {
            let Some(pivot) = parent(end).and_then(|p| parent(p).or(Some(p))) else { continue };
            let Some(&first) = limb(character, pivot)
                .iter()
                .find(|j| parent(**j) == Some(pivot) && limb(character, **j).contains(&end))
            else {
                continue;
            };
            for j in limb(character, first) {
                joints[j] = rest[pivot] + Vec2::from_angle(turn.to_radians()).rotate(rest[j] - rest[pivot]);
            }
        }
        joints
    };
    let hand = farthest(Vec2::new(-1.0, 0.3)).unwrap_or(0);
    let foot = farthest(Vec2::new(0.2, 1.0)).unwrap_or(0);
    let deep = |joint: usize| -> Vec<(u32, i32)> {
        let pivot = parent(joint).and_then(|p| parent(p).or(Some(p))).unwrap_or(0);
        let all = limb(character, pivot);
        (0..skeleton.bones.len())
            .filter(|&b| {
                skeleton.bones[b][0] != pivot && all.contains(&skeleton.bones[b][1]) || skeleton.bones[b][1] == joint
            })
            .map(|b| (b as u32, 1))
            .collect()
    };
    for (frame, turns) in [
        (0, vec![]),
        (12, vec![(hand, 50.0), (foot, -25.0)]),
        (24, vec![(hand, -70.0), (foot, 20.0)]),
        (36, vec![(hand, -30.0), (foot, 0.0)]),
        (47, vec![]),
    ] {
        let easing = Easing::InOut;
        poses.keys.push(KeyPose { frame, joints: swung(&turns), easing, moved: Vec::new(), depth: deep(hand) });
    }
    poses
}

/// Milliseconds that this program has run on a processor.
fn processor_time() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    1e3 * time.tv_sec as f64 + 1e-6 * time.tv_nsec as f64
}

fn over_checks(picture: &RgbaImage) -> RgbaImage {
    RgbaImage::from_fn(picture.width(), picture.height(), |x, y| {
        let p = picture.get_pixel(x, y).0;
        let ground = if (x / 12 + y / 12) % 2 == 0 { [255.0, 120.0, 255.0] } else { [90.0, 200.0, 90.0] };
        let a = f32::from(p[3]) / 255.0;
        let mix = |c: usize| (f32::from(p[c]) * a + ground[c] * (1.0 - a) + 0.5) as u8;
        Rgba([mix(0), mix(1), mix(2), 255])
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [picture, out, rest @ ..] = &args[..] else {
        return Err("usage: take_eval PICTURE OUT_FOLDER [RIG.json POSES.json]".into());
    };
    let out = Path::new(out);
    std::fs::create_dir_all(out)?;
    let picture = image::open(picture)?.to_rgba8();
    let progress = Progress::new();
    let character = match rest.first() {
        Some(rig) => Character::read(rig)?,
        None => Character::from_picture(&picture, &RigParams::default(), progress.whole())?,
    };
    let poses = match rest.get(1) {
        Some(poses) => Poses::read(poses, &character)?,
        None => swings(&character),
    };
    let animation = Animation::new(&character, &NeedleDeformer::default(), poses, progress.whole())?;
    let take = Take::of_poses(&animation, progress.whole())?;
    let began = Instant::now();
    let cut = cut_out(&picture)?;
    println!("cut out in {:.0} ms", 1e3 * began.elapsed().as_secs_f64());
    cut.save(out.join("cut.png"))?;
    over_checks(&cut).save(out.join("cut-on-checks.png"))?;
    let canvas = Canvas::new(&character, &take, 1.0, true)?;
    let began = Instant::now();
    let drawing = Drawing::new(&character, &cut, 1.0)?;
    println!("prepared in {:.0} ms", 1e3 * began.elapsed().as_secs_f64());
    let frames: Vec<RgbaImage> = take.frames.iter().map(|f| drawing.draw(f, &canvas, [0; 4])).collect();
    for scale in [1.0, 0.5, 1024.0 / canvas.size.1 as f32] {
        let canvas = Canvas::new(&character, &take, scale, true)?;
        let drawing = Drawing::new(&character, &cut, scale)?;
        let draw = |f| {
            let began = processor_time();
            std::hint::black_box(drawing.draw(f, &canvas, [0; 4]));
            processor_time() - began
        };
        let mean = |times: Vec<f64>| times.iter().sum::<f64>() / times.len() as f64;
        let each = (0..3).map(|_| mean(take.frames.iter().map(draw).collect())).fold(f64::INFINITY, f64::min);
        let ((w, h), n) = (canvas.size, character.mesh.points.len());
        println!("{} frames of {w}x{h}, {n} vertices: {each:.2} ms of one core each", frames.len());
    }
    let rest = marey::shape::character::TakeFrame {
        points: character.mesh.points.clone(),
        joints: Vec::new(),
        depths: Vec::new(),
    };
    let still = drawing.draw(&rest, &canvas, [0; 4]);
    let (mut sum, mut worst) = (0u64, 0u8);
    for (x, y, p) in cut.enumerate_pixels() {
        let (sx, sy) = (x as i32 - canvas.origin.x, y as i32 - canvas.origin.y);
        let got = still.get_pixel(sx as u32, sy as u32).0;
        for c in 0..4 {
            // Colours count by how much they are seen.
            let seen = |q: [u8; 4]| if c == 3 { u32::from(q[3]) } else { u32::from(q[c]) * u32::from(q[3]) / 255 };
            let off = seen(got).abs_diff(seen(p.0)) as u8;
            sum += u64::from(off);
            worst = worst.max(off);
        }
    }
    println!("rest pose: mean {:.4}, worst {worst}", sum as f64 / (4 * cut.width() * cut.height()) as f64);
    let shown: Vec<usize> = (0..8).map(|i| i * (frames.len() - 1) / 7).collect();
    let (w, h) = canvas.size;
    let mut sheet = RgbaImage::new(w * 4, h * 2);
    for (i, &f) in shown.iter().enumerate() {
        let (x, y) = (i as u32 % 4 * w, i as u32 / 4 * h);
        image::imageops::replace(&mut sheet, &over_checks(&frames[f]), i64::from(x), i64::from(y));
    }
    sheet.save(out.join("sheet.png"))?;

    let options = TakeOptions::default();
    for (format, name) in [
        (TakeFormat::PngFolder, "frames"),
        (TakeFormat::SpriteSheet, "sprites.json"),
        (TakeFormat::Gif, "take.gif"),
        (TakeFormat::Apng, "take.png"),
        (TakeFormat::WebP, "take.webp"),
        (TakeFormat::Mp4, "take.mp4"),
    ] {
        let path = out.join(name);
        let began = Instant::now();
        let subject = TakeSubject { name: "take", character: &character, picture: &picture, take: &take };
        let written = write_take(&path, format, subject, &options, Progress::new().whole())?;
        let spent = 1e3 * began.elapsed().as_secs_f64() / frames.len() as f64;
        let mut bytes = 0;
        for file in &written.files {
            let whole = |p: &Path| -> std::io::Result<u64> { Ok(std::fs::metadata(p)?.len()) };
            bytes += if file.is_dir() {
                std::fs::read_dir(file)?.map(|e| whole(&e?.path())).sum::<std::io::Result<u64>>()?
            } else {
                whole(file)?
            };
        }
        print!("{name}: {} KB, {spent:.1} ms a frame", bytes / 1000);
        if format == TakeFormat::SpriteSheet {
            println!();
            continue;
        }
        let clip = Clip::open(&path)?;
        let (mut sum, mut alpha, mut count) = (0u64, 0u64, 0u64);
        for (f, drawn) in frames.iter().enumerate() {
            let read = clip.frame(f)?;
            for (x, y, p) in drawn.enumerate_pixels() {
                let got = read.rgb.get_pixel(x, y).0;
                let opaque = |p: u8, a: u8| (u32::from(p) * u32::from(a) + 255 * (255 - u32::from(a)) + 127) / 255;
                let a = read.alpha.as_ref().map_or(255, |m| m.get_pixel(x, y).0[0]);
                for c in 0..3 {
                    sum += u64::from(opaque(got[c], a).abs_diff(opaque(p.0[c], p.0[3])));
                }
                alpha += u64::from(a.abs_diff(p.0[3]));
                count += 1;
            }
        }
        println!(
            "; {} frames at {}; over white off by {:.4}, alpha by {:.4}",
            clip.info().frames,
            clip.info().fps,
            sum as f64 / (3 * count) as f64,
            alpha as f64 / count as f64
        );
    }
    Ok(())
}
