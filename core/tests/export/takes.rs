//! A character's take as pictures, from the drawing to files that somebody else reads.

use glam::{Vec2, vec2};
use image::{Rgba, RgbaImage};
use marey::clip::Clip;
use marey::deform::needles::NeedleDeformer;
use marey::export::take::{TakeFormat, TakeOptions, TakeSubject, write_take};
use marey::job::Progress;
use marey::shape::character::{
    Animation, Canvas, Character, Drawing, KeyPose, Poses, RigParams, Take, TakeFrame, cut_out,
};
use marey::{Error, Result};

const SIZE: (u32, u32) = (180, 220);

fn gap_to(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(b, t))
}

/// How far outside a figure with a head, two arms and two legs a place is.
fn outside(p: Vec2) -> f32 {
    let limb = |a: (f32, f32), b: (f32, f32), radius: f32| gap_to(p, a.into(), b.into()) - radius;
    limb((90.0, 80.0), (90.0, 130.0), 24.0)
        .min(p.distance(vec2(90.0, 36.0)) - 22.0)
        .min(limb((90.0, 76.0), (24.0, 130.0), 8.0))
        .min(limb((90.0, 76.0), (156.0, 130.0), 8.0))
        .min(limb((86.0, 130.0), (64.0, 200.0), 9.0))
        .min(limb((94.0, 130.0), (116.0, 200.0), 9.0))
}

fn place(x: u32, y: u32) -> Vec2 {
    vec2(x as f32 + 0.5, y as f32 + 0.5)
}

/// Its opacity and its colour there: an outline, and inside it bands of colour.
fn look(p: Vec2) -> (f32, [f32; 3]) {
    let gap = outside(p);
    let band = ((p.y / 9.0) as i32 % 3) as f32;
    let colour = if gap > -4.0 { [30.0, 20.0, 50.0] } else { [230.0 - 40.0 * band, 120.0 + 50.0 * band, 70.0] };
    ((0.5 - gap).clamp(0.0, 1.0), colour)
}

fn figure() -> RgbaImage {
    RgbaImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let (a, [r, g, b]) = look(place(x, y));
        Rgba([r, g, b, 255.0 * a].map(|v| (v + 0.5) as u8))
    })
}

fn on_paper(paper: impl Fn(Vec2) -> [f32; 3]) -> RgbaImage {
    RgbaImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let ((a, ink), ground) = (look(place(x, y)), paper(place(x, y)));
        let mixed = |c: usize| (ink[c] * a + ground[c] * (1.0 - a) + 0.5) as u8;
        Rgba([mixed(0), mixed(1), mixed(2), 255])
    })
}

fn shaded(p: Vec2) -> [f32; 3] {
    [225.0 - 0.1 * p.x, 220.0 - 0.05 * p.y, 200.0]
}

fn rigged(picture: &RgbaImage) -> Character {
    let params = RigParams { vertices: 500, ..RigParams::default() };
    Character::from_picture(picture, &params, Progress::new().whole()).expect("a rig")
}

/// The left arm swings over the body and back out.
fn waving(character: &Character) -> Take {
    let skeleton = &character.skeleton;
    let rest = skeleton.rest();
    let hand = (0..rest.len()).min_by(|&a, &b| rest[a].x.total_cmp(&rest[b].x)).expect("joints");
    let parent = |j: usize| skeleton.bones.iter().find(|b| b[1] == j).map(|b| b[0]);
    let mut arm = vec![hand];
    while let Some(up) = parent(arm[arm.len() - 1]).filter(|p| rest[*p].x < 66.0) {
        arm.push(up);
    }
    let shoulder = parent(arm[arm.len() - 1]).expect("a shoulder");
    let key = |frame: usize, turn: f32| {
        let mut joints = rest.clone();
        for &j in &arm {
            joints[j] = rest[shoulder] + Vec2::from_angle(turn.to_radians()).rotate(rest[j] - rest[shoulder]);
        }
        let bones = (0..skeleton.bones.len()).filter(|&b| arm.contains(&skeleton.bones[b][1]));
        KeyPose { frame, joints, depth: bones.map(|b| (b as u32, 1)).collect(), ..KeyPose::default() }
    };
    let poses = Poses { fps: 24.0, step: 1, keys: vec![key(0, 0.0), key(7, 40.0), key(14, -80.0)] };
    let animation = Animation::new(character, &NeedleDeformer::default(), poses, Progress::new().whole());
    Take::of_poses(&animation.expect("solved"), Progress::new().whole()).expect("a take")
}

fn at_rest(character: &Character) -> TakeFrame {
    TakeFrame {
        points: character.mesh.points.clone(),
        joints: character.skeleton.rest(),
        depths: vec![0; character.skeleton.bones.len()],
    }
}

/// The mean of how far colours, as they are seen, and opacities are apart, and the largest.
fn apart(a: &RgbaImage, b: &RgbaImage) -> (f64, u32) {
    assert_eq!(a.dimensions(), b.dimensions());
    let seen =
        |p: &Rgba<u8>, c: usize| if c == 3 { 255 * u32::from(p.0[3]) } else { u32::from(p.0[c]) * u32::from(p.0[3]) };
    let (mut sum, mut worst) = (0u64, 0);
    for (p, q) in a.pixels().zip(b.pixels()) {
        for c in 0..4 {
            let off = (seen(p, c).abs_diff(seen(q, c)) + 127) / 255;
            sum += u64::from(off);
            worst = worst.max(off);
        }
    }
    (sum as f64 / f64::from(4 * a.width() * a.height()), worst)
}

#[test]
fn a_cut_out_keeps_alpha_and_takes_the_paper_off() {
    let picture = figure();
    let cut = cut_out(&picture).expect("cut out");
    assert!(cut.pixels().zip(picture.pixels()).all(|(a, b)| a == b || (a.0[3] == 0 && b.0[3] == 0)));
    for paper in [|_: Vec2| [250.0, 250.0, 250.0], shaded, |_: Vec2| [255.0, 240.0, 90.0]] {
        let cut = cut_out(&on_paper(paper)).expect("cut out");
        let (mean, _) = apart(&cut, &picture);
        let wrong = cut.pixels().zip(picture.pixels()).filter(|(a, b)| a.0[3].abs_diff(b.0[3]) > 60).count();
        // Some in the notch of the neck, whose sides are one line.
        assert!(mean < 0.1 && wrong < 16, "{mean} {wrong}");
        for (x, y, p) in cut.enumerate_pixels() {
            let gap = outside(place(x, y));
            // What is half clear and what lies under the rim is ink, not paper.
            if p.0[3] > 0 && gap > -1.0 || p.0[3] == 0 && gap < 2.5 {
                let off = p.0.iter().zip([30u8, 20, 50]).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0);
                assert!(off < 80, "{x},{y} at {gap}: {:?}", p.0);
            }
            assert!(gap < 3.0 || p.0[3] == 0, "{x},{y} at {gap}: {:?}", p.0);
        }
    }
    for picture in [RgbaImage::new(0, 0), RgbaImage::new(9, 9), RgbaImage::from_pixel(9, 9, Rgba([5, 5, 5, 255]))] {
        assert!(cut_out(&picture).is_err());
    }
}

#[test]
fn the_rest_pose_draws_the_cut_out() {
    for picture in [figure(), on_paper(shaded)] {
        let (character, cut) = (rigged(&picture), cut_out(&picture).expect("cut out"));
        let take = Take { fps: 24.0, frames: vec![at_rest(&character)] };
        let drawn = |scale: f32, depths: &[i32]| {
            let canvas = Canvas::new(&character, &take, scale, true).expect("a canvas");
            let frame = TakeFrame { depths: depths.to_vec(), ..at_rest(&character) };
            Drawing::new(&character, &cut, scale).expect("a drawing").draw(&frame, &canvas, [0; 4])
        };
        // Whatever lies over whatever.
        let mixed: Vec<i32> = (0..character.skeleton.bones.len()).map(|b| (b * 7 % 5) as i32).collect();
        for depths in [&[][..], &mixed] {
            let (mean, worst) = apart(&drawn(1.0, depths), &cut);
            assert!(mean < 0.01 && worst <= 2, "{mean} {worst}");
        }
        // At half the size each pixel is the mean of four.
        let half = RgbaImage::from_fn(SIZE.0 / 2, SIZE.1 / 2, |x, y| {
            let four =
                [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| cut.get_pixel(2 * x + i, 2 * y + j).0.map(u32::from));
            let alpha: u32 = four.iter().map(|p| p[3]).sum();
            let mean = |c: usize| ((four.iter().map(|p| p[c] * p[3]).sum::<u32>() + alpha / 2) / alpha.max(1)) as u8;
            Rgba([mean(0), mean(1), mean(2), ((alpha + 2) / 4) as u8])
        });
        let (mean, worst) = apart(&drawn(0.5, &[]), &half);
        // In the notch of the neck a pixel has two sides of the drawing in it.
        let wrong = drawn(0.5, &[]).pixels().zip(half.pixels()).filter(|(a, b)| a.0[3].abs_diff(b.0[3]) > 3).count();
        assert!(mean < 0.01 && wrong <= 2, "{mean} {worst} {wrong}");
    }
}

#[test]
fn an_arm_over_the_body_leaves_no_line() {
    let picture = figure();
    let (character, cut) = (rigged(&picture), cut_out(&picture).expect("cut out"));
    // The lower left arm is pulled over the body, which stays.
    let arm: Vec<bool> = character.mesh.points.iter().map(|p| p.x < 58.0 && (90.0..145.0).contains(&p.y)).collect();
    let near: Vec<usize> = (0..arm.len()).filter(|&v| arm[v]).map(|v| character.regions.bone[v] as usize).collect();
    let depths: Vec<i32> = (0..character.skeleton.bones.len()).map(|b| i32::from(near.contains(&b))).collect();
    let frame = |step: usize| {
        let pulled = |(p, arm): (&Vec2, &bool)| if *arm { *p + vec2(5.0, -1.3) * step as f32 } else { *p };
        let points = character.mesh.points.iter().zip(&arm).map(pulled).collect();
        TakeFrame { points, depths: depths.clone(), ..at_rest(&character) }
    };
    let take = Take { fps: 24.0, frames: (0..16).map(frame).collect() };
    let canvas = Canvas::new(&character, &take, 1.0, true).expect("a canvas");
    let drawing = Drawing::new(&character, &cut, 1.0).expect("a drawing");
    let (mut crossed, mut rims) = (0, 0);
    for (f, frame) in take.frames.iter().enumerate() {
        let drawn = drawing.draw(frame, &canvas, [0; 4]);
        for (x, y, before) in cut.enumerate_pixels() {
            if gap_to(place(x, y), vec2(90.0, 80.0), vec2(90.0, 130.0)) < 18.0 {
                let now = drawn.get_pixel((x as i32 - canvas.origin.x) as u32, (y as i32 - canvas.origin.y) as u32).0;
                assert_eq!(now[3], 255, "frame {f}: {x},{y}");
                crossed += usize::from(before.0[..3].iter().zip(now).any(|(a, b)| a.abs_diff(b) > 60));
                // Its outline is mixed with what it lies over.
                rims += usize::from((45..110).contains(&now[0]));
            }
        }
    }
    assert!(crossed > 1000 && rims > 200, "the arm does lie over the body: {crossed} {rims}");
}

#[test]
fn takes_are_written_and_read_back() -> Result<()> {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = on_paper(shaded);
    let character = rigged(&picture);
    let mut take = waving(&character);
    take.frames[3].points.iter_mut().for_each(|p| *p += vec2(-40.0, 25.5));
    let subject = TakeSubject { name: "waving", character: &character, picture: &picture, take: &take };
    for grow in [true, false] {
        for background in [[0, 0, 0, 0], [20, 120, 220, 255]] {
            let options = TakeOptions { grow, scale: 0.75, background };
            let path = folder.path().join(format!("{grow}-{}.webp", background[3]));
            let written = write_take(&path, TakeFormat::WebP, subject, &options, Progress::new().whole())?;
            assert_eq!((written.files.len(), written.frames), (1, 15));
            let canvas = Canvas::new(&character, &take, 0.75, grow)?;
            assert_eq!(written.shown, canvas.shown());
            assert_eq!(grow, written.shown != [0, 0, 180, 220], "the arm leaves the picture: {:?}", written.shown);
            let clip = Clip::open(&path)?;
            assert_eq!((clip.info().frames, clip.info().width, clip.info().height), (15, canvas.size.0, canvas.size.1));
            let drawing = Drawing::new(&character, &cut_out(&picture)?, 0.75)?;
            for f in 0..15 {
                let (read, drawn) = (clip.frame(f)?, drawing.draw(&take.frames[f], &canvas, background));
                assert_eq!(read.alpha.is_none(), background[3] == 255);
                let seen = |x, y| read.alpha.as_ref().map_or(255, |a| a.get_pixel(x, y).0[0]);
                for (x, y, p) in drawn.enumerate_pixels() {
                    assert!(seen(x, y) == p.0[3] && (p.0[3] == 0 || read.rgb.get_pixel(x, y).0[..] == p.0[..3]));
                }
            }
        }
    }
    let path = folder.path().join("frames");
    for format in [TakeFormat::PngFolder, TakeFormat::PngFolder] {
        // Again into its own folder.
        let written = write_take(&path, format, subject, &TakeOptions::default(), Progress::new().whole())?;
        assert_eq!((written.files, Clip::open(&path)?.info().frames), (vec![path.clone()], 15));
    }
    Ok(())
}

#[test]
fn what_is_no_take_of_this_character_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = figure();
    let character = rigged(&picture);
    let rest = Take { fps: 24.0, frames: vec![at_rest(&character)] };
    let with = |change: &dyn Fn(&mut Take)| {
        let mut take = rest.clone();
        change(&mut take);
        take
    };
    let far = |p: f32| with(&|t| t.frames[0].points[3].x = p);
    let path = folder.path().join("take.png");
    let refused = |take: &Take, picture: &RgbaImage, options: TakeOptions| {
        let subject = TakeSubject { name: "take", character: &character, picture, take };
        let error = write_take(&path, TakeFormat::Apng, subject, &options, Progress::new().whole());
        let error = error.expect_err("refused");
        assert_eq!(std::fs::read_dir(folder.path()).expect("listed").count(), 0);
        (matches!(error, Error::Limit { .. }), error.to_string())
    };
    let plain = TakeOptions::default();
    for (take, problem) in [
        (Take { fps: 24.0, frames: Vec::new() }, "no frames"),
        (with(&|t| t.frames[0].points.truncate(9)), "vertices"),
        (with(&|t| t.frames[0].depths = vec![1]), "depths"),
        (far(f32::NAN), "not a number"),
        (far(f32::INFINITY), "not a number"),
        (with(&|t| t.fps = f64::NAN), "rate"),
    ] {
        let (_, said) = refused(&take, &picture, plain);
        assert!(said.contains(problem), "{said}");
    }
    assert!(refused(&rest, &RgbaImage::new(9, 9), plain).1.contains("9x9"));
    assert!(refused(&far(1e9), &picture, plain).0);
    for scale in [0.0, -1.0, f32::NAN] {
        assert!(refused(&rest, &picture, TakeOptions { scale, ..plain }).1.contains("scale"));
    }
    assert!(refused(&rest, &picture, TakeOptions { scale: 1e6, ..plain }).0);
    // Cut to the picture, a vertex that is flung away harms nothing.
    let subject = TakeSubject { name: "take", character: &character, picture: &picture, take: &far(1e9) };
    let cut = TakeOptions { grow: false, ..plain };
    let written = write_take(&path, TakeFormat::Apng, subject, &cut, Progress::new().whole()).expect("written");
    assert_eq!((written.shown, written.frames), ([0, 0, 180, 220], 1));
}
