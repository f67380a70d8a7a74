//! Segmentation seen from outside: scenes whose true masks are known, paint, bad input, cancelling, determinism.

use glam::{Vec2, vec2};
use image::{Rgb, RgbImage, Rgba, RgbaImage};
use marey::Error;
use marey::clip::Clip;
use marey::job::Progress;
use marey::motion::{Motion, Track, TrackFrame, TrackKind};
use marey::raster::Mask;
use marey::rig::{KeyFrame, Limb, Paint, Rig, Stroke};
use marey::segment::{CostVolumeSegmenter, Method, SegmentParams, Segmenter};

const SIZE: (u32, u32) = (220, 160);
const FRAMES: usize = 9;

/// A body with two swinging legs, walking over a meadow.
struct Scene {
    frames: usize,
    /// How much of the creature's colour the meadow has: 0 none, 1 all.
    camouflage: f32,
    /// By how many pixels a frame the camera follows the creature.
    pan: u32,
}

impl Scene {
    fn body(&self, frame: usize) -> [Vec2; 2] {
        let at = vec2(70.0 + 4.0 * frame as f32, 70.0);
        [at, at + vec2(70.0, 2.0)]
    }

    fn leg(&self, frame: usize, front: bool) -> [Vec2; 2] {
        let swing = 0.5 * (frame as f32 * 0.7 + if front { 0.0 } else { 2.5 }).sin();
        let hip = self.body(frame)[usize::from(front)] + vec2(0.0, 10.0);
        [hip, hip + 48.0 * vec2(swing.sin(), swing.cos())]
    }

    fn truth(&self, frame: usize) -> Mask {
        let near = |p: Vec2, [a, b]: [Vec2; 2], r: f32| {
            let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            p.distance(a + (b - a) * t) < r
        };
        Mask::from_fn(SIZE.0 as usize, SIZE.1 as usize, |x, y| {
            let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
            near(p, self.body(frame), 20.0)
                || near(p, self.leg(frame, false), 6.0)
                || near(p, self.leg(frame, true), 6.0)
        })
    }

    fn picture(&self, frame: usize) -> RgbImage {
        let truth = self.truth(frame);
        let (hide, meadow) = ([150.0, 90.0, 50.0], [70.0, 140.0, 60.0]);
        RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
            let inside = truth.get(x as usize, y as usize);
            // Grain that goes with what it lies on, differs for every pixel, and repeats nowhere.
            let x = x + if inside { 4 * (self.frames - frame) as u32 + 500 } else { self.pan * frame as u32 };
            let grain = |seed: u32| {
                let mut h = (x ^ seed.rotate_left(9)).wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77);
                h = (h ^ h >> 15).wrapping_mul(0x2C1B_3C6D);
                ((h >> 20) & 31) as f32 - 15.5
            };
            Rgb(std::array::from_fn(|c| {
                let ground = meadow[c] + self.camouflage * (hide[c] - meadow[c]);
                (if inside { hide[c] } else { ground } + grain(c as u32)) as u8
            }))
        })
    }

    fn clip(&self) -> Clip {
        Clip::from_frames((0..self.frames).map(|f| self.picture(f)).collect(), 24.0).expect("a clip")
    }

    fn strokes(&self, frame: usize) -> Vec<[Vec2; 2]> {
        vec![self.body(frame), self.leg(frame, false), self.leg(frame, true)]
    }

    fn rig(&self) -> Rig {
        let labels = ["body", "hind", "fore"];
        let limbs = labels.map(|label| Limb { label: label.into(), side: None });
        let strokes = self.strokes(0).into_iter().enumerate();
        let strokes = strokes.map(|(limb, points)| Stroke { limb, points: points.to_vec(), facing: None });
        let key = KeyFrame { frame: 0, strokes: strokes.collect(), ..KeyFrame::default() };
        Rig { size: SIZE, limbs: limbs.to_vec(), keyframes: vec![key] }
    }

    /// The true motion; legs stay where they were drawn when `stuck`.
    fn motion(&self, stuck: bool) -> Motion {
        let tracks = self.rig().limbs.into_iter().enumerate().map(|(l, limb)| {
            let at = |f: usize| if stuck && l > 0 { self.strokes(0)[l] } else { self.strokes(f)[l] };
            let frames = (0..self.frames).map(|f| {
                let [a, b] = at(f);
                TrackFrame::certain((0..9).map(|i| a.lerp(b, i as f32 / 8.0)).collect())
            });
            Track { name: limb.label, kind: TrackKind::Stroke, frames: frames.collect() }
        });
        Motion { size: SIZE, fps: 24.0, frames: self.frames, tracks: tracks.collect(), bones: Vec::new() }
    }

    fn score(&self, masks: &[Mask]) -> f64 {
        assert_eq!(masks.len(), self.frames);
        masks.iter().enumerate().map(|(f, m)| m.iou(&self.truth(f))).sum::<f64>() / self.frames as f64
    }
}

fn segment(clip: &Clip, rig: &Rig, motion: &Motion) -> Vec<Mask> {
    let segmenter = CostVolumeSegmenter::default();
    segmenter.segment(clip, rig, motion, Progress::new().whole()).expect("masks")
}

#[test]
fn a_walker_is_cut_out_even_where_the_tracker_lost_its_legs() {
    let scene = Scene { frames: FRAMES, camouflage: 0.0, pan: 0 };
    let followed = scene.score(&segment(&scene.clip(), &scene.rig(), &scene.motion(false)));
    assert!(followed > 0.95, "{followed}");
    let lost = scene.score(&segment(&scene.clip(), &scene.rig(), &scene.motion(true)));
    assert!(lost > 0.85, "{lost}");
}

#[test]
fn the_papers_method_finds_the_bulk_of_a_distinct_creature() {
    let scene = Scene { frames: 3, camouflage: 0.0, pan: 0 };
    let params = SegmentParams { method: Method::Paper, ..SegmentParams::default() };
    let masks = CostVolumeSegmenter { params }
        .segment(&scene.clip(), &scene.rig(), &scene.motion(false), Progress::new().whole())
        .expect("masks");
    let score = scene.score(&masks);
    assert!(score > 0.8, "{score}");
}

#[test]
fn paint_is_kept_exactly_and_helps_its_neighbours() {
    let scene = Scene { frames: FRAMES, camouflage: 0.97, pan: 3 };
    let (clip, motion, mut rig) = (scene.clip(), scene.motion(false), scene.rig());
    let blind = scene.score(&segment(&clip, &rig, &motion));

    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("mask.png");
    scene.truth(0).to_image().save(&file).expect("saved");
    rig.keyframes[0].mask = Some(file);
    let dot = Paint { foreground: true, radius: 3.0, points: vec![vec2(20.5, 20.5)] };
    let hole = Paint { foreground: false, radius: 2.0, points: vec![vec2(90.5, 70.5), vec2(110.5, 70.5)] };
    rig.keyframes[0].paint = vec![dot, hole];
    let masks = segment(&clip, &rig, &motion);

    let truth = scene.truth(0);
    let expected = Mask::from_fn(SIZE.0 as usize, SIZE.1 as usize, |x, y| {
        let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
        let off_line = p.distance(vec2(p.x.clamp(90.5, 110.5), 70.5));
        if off_line <= 2.0 { false } else { p.distance(vec2(20.5, 20.5)) <= 3.0 || truth.get(x, y) }
    });
    assert!(masks[0] == expected, "the painted frame differs from what was painted");
    let later = |masks: &[Mask]| masks[1..].iter().enumerate().map(|(i, m)| m.iou(&scene.truth(i + 1))).sum::<f64>();
    let helped = later(&masks) / (FRAMES - 1) as f64;
    assert!(helped > 0.7 && helped > blind + 0.02, "{blind} without paint, {helped} with");
}

#[test]
fn a_painted_mask_that_does_not_fit_is_an_error_that_names_it() {
    let scene = Scene { frames: 2, camouflage: 0.0, pan: 0 };
    let folder = tempfile::tempdir().expect("a folder");
    for (name, write) in [("small.png", true), ("broken.png", false), ("missing.png", false)] {
        let file = folder.path().join(name);
        if write {
            Mask::new(10, 10).to_image().save(&file).expect("saved");
        } else if name == "broken.png" {
            std::fs::write(&file, b"not a picture").expect("written");
        }
        let mut rig = scene.rig();
        rig.keyframes[0].mask = Some(file);
        let result =
            CostVolumeSegmenter::default().segment(&scene.clip(), &rig, &scene.motion(false), Progress::new().whole());
        let message = result.expect_err(name).to_string();
        assert!(message.contains(name), "{message}");
    }
}

#[test]
fn a_transparent_clip_brings_its_own_masks() {
    let scene = Scene { frames: 3, camouflage: 1.0, pan: 0 };
    let folder = tempfile::tempdir().expect("a folder");
    for frame in 0..scene.frames {
        let (picture, truth) = (scene.picture(frame), scene.truth(frame));
        let image = RgbaImage::from_fn(SIZE.0, SIZE.1, |x, y| {
            let [r, g, b] = picture.get_pixel(x, y).0;
            Rgba([r, g, b, if truth.get(x as usize, y as usize) { 255 } else { 0 }])
        });
        image.save(folder.path().join(format!("{frame:03}.png"))).expect("saved");
    }
    let clip = Clip::open(folder.path()).expect("a clip");
    let masks = segment(&clip, &scene.rig(), &scene.motion(false));
    assert_eq!(scene.score(&masks), 1.0);
}

#[test]
fn threads_do_not_change_a_bit() {
    let scene = Scene { frames: 5, camouflage: 0.5, pan: 0 };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| segment(&scene.clip(), &scene.rig(), &scene.motion(true)))
    };
    assert!(run(1) == run(3));
}

#[test]
fn cancelled_work_stops() {
    let scene = Scene { frames: 3, camouflage: 0.0, pan: 0 };
    let progress = Progress::new();
    progress.cancel();
    for method in [Method::Layered, Method::Paper] {
        let params = SegmentParams { method, ..SegmentParams::default() };
        let result =
            CostVolumeSegmenter { params }.segment(&scene.clip(), &scene.rig(), &scene.motion(false), progress.whole());
        assert!(matches!(result, Err(Error::Cancelled)), "{method:?}");
    }
}

#[test]
fn poor_input_gives_masks_not_panics() {
    // One frame.
    let single = Scene { frames: 1, camouflage: 0.0, pan: 0 };
    assert!(single.score(&segment(&single.clip(), &single.rig(), &single.motion(false))) > 0.9);
    // A leg that is never in the picture, and one that the tracker has no place for.
    let scene = Scene { frames: 3, camouflage: 0.0, pan: 0 };
    let mut motion = scene.motion(false);
    for frame in &mut motion.tracks[1].frames {
        frame.points.iter_mut().for_each(|p| *p += vec2(-400.0, 0.0));
    }
    for frame in &mut motion.tracks[2].frames {
        frame.points.iter_mut().for_each(|p| *p = Vec2::NAN);
    }
    assert!(scene.score(&segment(&scene.clip(), &scene.rig(), &motion)) > 0.7);
    motion.tracks.clear();
    assert_eq!(segment(&scene.clip(), &scene.rig(), &motion).len(), 3);
    // One colour everywhere: nothing can be told apart, the shape along the strokes is all there is.
    let grey = Clip::from_frames(vec![RgbImage::from_pixel(SIZE.0, SIZE.1, Rgb([128; 3])); 3], 24.0).expect("a clip");
    for method in [Method::Layered, Method::Paper] {
        let params = SegmentParams { method, ..SegmentParams::default() };
        let masks = CostVolumeSegmenter { params }
            .segment(&grey, &scene.rig(), &scene.motion(false), Progress::new().whole())
            .expect("masks");
        assert_eq!(masks.len(), 3);
    }
}
