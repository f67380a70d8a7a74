//! Ground truth on made-up clips of textured limbs, and what must hold for any clip.

use glam::{Vec2, vec2};
use image::RgbImage;

use super::super::stage_set::{Bar, scene};
use super::super::{LimbParams, LimbTracker, Method, PaperParams};
use crate::clip::Clip;
use crate::error::Error;
use crate::job::Progress;
use crate::motion::Motion;
use crate::rig::{KeyFrame, Limb, Rig, Side, Stroke};
use crate::track::Tracker;

const SIZE: (u32, u32) = (220, 160);

/// A thigh and a shin that swing while the whole walks to the right.
fn leg(frame: usize) -> [Bar; 2] {
    let t = frame as f32;
    let thigh = Bar { from: vec2(60.0 + 3.0 * t, 30.0), angle: 1.5 - 0.05 * t, length: 50.0, half_width: 9.0 };
    [thigh, Bar { from: thigh.at(1.0), angle: 1.3 + 0.06 * t, length: 45.0, half_width: 7.0 }]
}

fn clip(frames: usize, picture: impl Fn(usize) -> RgbImage) -> Clip {
    Clip::from_frames((0..frames).map(picture).collect(), 24.0).expect("a clip")
}

fn stroke(limb: usize, bar: &Bar) -> Stroke {
    Stroke { limb, points: vec![bar.at(0.0), bar.at(0.5), bar.at(1.0)], facing: None }
}

fn rig(limbs: usize, keys: impl IntoIterator<Item = (usize, Vec<Stroke>)>) -> Rig {
    let key = |(frame, strokes)| KeyFrame { frame, strokes, ..KeyFrame::default() };
    Rig {
        size: SIZE,
        limbs: (0..limbs).map(|l| Limb { label: l.to_string(), side: None }).collect(),
        keyframes: keys.into_iter().map(key).collect(),
    }
}

fn leg_rig(keys: &[usize]) -> Rig {
    rig(2, keys.iter().map(|&f| (f, leg(f).iter().enumerate().map(|(l, b)| stroke(l, b)).collect())))
}

fn tracker(paper: PaperParams) -> LimbTracker {
    LimbTracker { params: LimbParams { method: Method::Paper, paper, ..LimbParams::default() } }
}

fn track(paper: PaperParams, clip: &Clip, rig: &Rig) -> Motion {
    tracker(paper).track(clip, rig, Progress::new().whole()).expect("tracked")
}

/// Mean distance of a limb's points to the truth on one frame.
fn error(motion: &Motion, limb: usize, frame: usize, truth: &Bar) -> f32 {
    let points = &motion.tracks[limb].frames[frame].points;
    let n = points.len();
    points.iter().enumerate().map(|(i, p)| p.distance(truth.at(i as f32 / (n - 1) as f32))).sum::<f32>() / n as f32
}

#[test]
fn a_walking_leg_is_followed_both_by_the_paper_and_better() {
    let clip = clip(9, |f| scene(SIZE, &leg(f), Vec2::ZERO));
    let mut means = Vec::new();
    for (params, bound) in [(PaperParams::default(), 5.0), (PaperParams::improved(), 2.0)] {
        let motion = track(params, &clip, &leg_rig(&[0]));
        let errors: Vec<f32> =
            (0..9).flat_map(|f| (0..2).map(move |l| (f, l))).map(|(f, l)| error(&motion, l, f, &leg(f)[l])).collect();
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        assert!(mean < bound, "{mean}: {errors:?}");
        means.push(mean);
        let still = error(&motion, 1, 0, &leg(8)[1]);
        assert!(mean < 0.5 * still, "no better than standing still: {mean}, {still}");
    }
}

#[test]
fn both_directions_meet_and_key_frames_and_joints_hold() {
    let clip = clip(9, |f| scene(SIZE, &leg(f), Vec2::ZERO));
    let rig = leg_rig(&[0, 8]);
    let motion = track(PaperParams::default(), &clip, &rig);
    for frame in 0..9 {
        let [thigh, shin] = [0, 1].map(|l| &motion.tracks[l].frames[frame]);
        assert!(thigh.points[thigh.points.len() - 1].distance(shin.points[0]) < 1e-3, "the knee came apart");
        assert!(error(&motion, 1, frame, &leg(frame)[1]) < 5.0);
        assert!(shin.confidence.iter().all(|c| (0.0..=1.0).contains(c)));
    }
    for (l, frame) in [(0, 0), (1, 0), (0, 8), (1, 8)] {
        let drawn = &rig.stroke(l, frame).expect("drawn").points;
        let points = &motion.tracks[l].frames[frame].points;
        assert_eq!((points[0], points[points.len() - 1]), (drawn[0], drawn[2]));
    }
}

#[test]
fn a_limb_is_hidden_behind_a_post_and_found_again() {
    let limb = |f: usize| Bar { from: vec2(30.0 + 6.0 * f as f32, 70.0), angle: 0.2, length: 50.0, half_width: 9.0 };
    let post = Bar { from: vec2(112.0, -20.0), angle: std::f32::consts::FRAC_PI_2, length: 260.0, half_width: 12.0 };
    let flat = |p: image::Rgb<u8>| image::Rgb([p.0[2] / 2, p.0[2] / 2, 130]);
    let picture = |f: usize| {
        let mut image = scene(SIZE, &[limb(f)], Vec2::ZERO);
        let posts = scene(SIZE, &[post], Vec2::ZERO);
        for (x, y, p) in image.enumerate_pixels_mut() {
            if (x as f32 - 112.0).abs() < 5.0 {
                *p = flat(*posts.get_pixel(x, y));
            }
        }
        image
    };
    let clip = clip(21, picture);
    // Flow is lost at the post, so look as far around as the paper does.
    let wide = PaperParams { flow_window: Some(64.0), ..PaperParams::improved() };
    let motion = track(wide, &clip, &rig(1, [(0, vec![stroke(0, &limb(0))])]));
    let n = motion.tracks[0].frames[0].points.len();
    let behind = |f: usize, i: usize| (limb(f).at(i as f32 / (n - 1) as f32).x - 112.0).abs() < 4.0;
    let (mut hidden, mut seen) = ((0, 0), (0, 0));
    for f in 1..21 {
        for (i, visible) in motion.tracks[0].frames[f].visible.iter().enumerate() {
            let count = if behind(f, i) { &mut hidden } else { &mut seen };
            count.0 += usize::from(*visible);
            count.1 += 1;
        }
    }
    let rate = |c: (usize, usize)| c.0 as f32 / c.1 as f32;
    assert!(hidden.1 > 10 && rate(hidden) < rate(seen), "{hidden:?} {seen:?}");
    assert!(error(&motion, 0, 20, &limb(20)) < 4.0, "{}", error(&motion, 0, 20, &limb(20)));
}

#[test]
fn a_limb_may_leave_the_picture() {
    let limb = |f: usize| Bar { from: vec2(120.0 + 5.0 * f as f32, 80.0), angle: 0.1, length: 60.0, half_width: 9.0 };
    let clip = clip(13, |f| scene(SIZE, &[limb(f)], Vec2::ZERO));
    let motion = track(PaperParams::improved(), &clip, &rig(1, [(0, vec![stroke(0, &limb(0))])]));
    let last = &motion.tracks[0].frames[12];
    let end = last.points.len() - 1;
    assert!(last.points[end].x > 225.0 && !last.visible[end], "{:?}", last.points[end]);
    assert!(error(&motion, 0, 12, &limb(12)) < 6.0, "{}", error(&motion, 0, 12, &limb(12)));
}

#[test]
fn a_far_limb_that_is_never_seen_moves_like_its_twin() {
    let limb = |f: usize| Bar { from: vec2(50.0 + 4.0 * f as f32, 60.0), angle: 1.2, length: 60.0, half_width: 9.0 };
    let clip = clip(6, |f| scene(SIZE, &[limb(f)], Vec2::ZERO));
    let shifted = Bar { from: limb(0).from + vec2(3.0, -1.0), ..limb(0) };
    let mut rig = rig(2, [(0, vec![stroke(0, &limb(0)), stroke(1, &shifted)])]);
    rig.limbs[0] = Limb { label: "fore_near".into(), side: Some(Side::Near) };
    rig.limbs[1] = Limb { label: "fore_far".into(), side: Some(Side::Far) };
    let motion = track(PaperParams::default(), &clip, &rig);
    let point = |limb: usize, f: usize| motion.tracks[limb].frames[f].points[5];
    assert!(point(0, 5).distance(point(0, 0)) > 10.0);
    assert!((point(1, 5) - point(1, 0)).distance(point(0, 5) - point(0, 0)) < 1.0);
    assert!(motion.tracks[1].frames[3].visible.iter().skip(2).all(|v| !v));
}

#[test]
fn odd_rigs_and_clips_give_whole_motions() {
    let one = clip(1, |_| scene(SIZE, &leg(0), Vec2::ZERO));
    let motion = track(PaperParams::default(), &one, &leg_rig(&[0]));
    assert_eq!(motion.tracks[0].frames.len(), 1);

    let clip = clip(5, |f| scene(SIZE, &leg(f), Vec2::ZERO));
    let [thigh, shin] = leg(3);
    let late = rig(2, [(1, vec![stroke(0, &leg(1)[0])]), (3, vec![stroke(0, &thigh), stroke(1, &shin)])]);
    let outside = Bar { from: vec2(-150.0, -90.0), angle: 0.3, length: 60.0, half_width: 4.0 };
    let outside = rig(1, [(2, vec![stroke(0, &outside)])]);
    let flat = Clip::from_frames(vec![RgbImage::new(SIZE.0, SIZE.1); 4], 24.0).expect("a clip");
    for params in [PaperParams::default(), PaperParams::improved()] {
        for (clip, rig) in [(&clip, &late), (&clip, &outside), (&flat, &leg_rig(&[0]))] {
            let motion = track(params.clone(), clip, rig);
            motion.validate().expect("a valid motion");
            assert!(motion.tracks.iter().all(|t| t.frames.len() == clip.info().frames));
        }
        // A limb that was drawn late is followed back from there.
        let motion = track(params.clone(), &clip, &late);
        assert!(error(&motion, 1, 1, &leg(1)[1]) < 6.0, "{}", error(&motion, 1, 1, &leg(1)[1]));
    }
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let clip = clip(4, |f| scene(SIZE, &leg(f), Vec2::ZERO));
    let rig = leg_rig(&[0, 3]);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| track(PaperParams::improved(), &clip, &rig))
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn a_cancel_is_heard_at_once() {
    let clip = clip(40, |f| scene((660, 480), &leg(f), Vec2::ZERO));
    let mut rig = leg_rig(&[0]);
    rig.size = (660, 480);
    let slow = PaperParams { coarse_to_fine: false, ..PaperParams::default() };
    let progress = Progress::new();
    let (result, waited) = std::thread::scope(|scope| {
        let work = scope.spawn(|| tracker(slow).track(&clip, &rig, progress.whole()));
        while progress.fraction() <= 0.1 {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let asked = std::time::Instant::now();
        progress.cancel();
        (work.join().expect("no panic"), asked.elapsed())
    });
    assert!(matches!(result, Err(Error::Cancelled)));
    // 100 ms is the promise on a free machine; tests share theirs.
    assert!(waited.as_millis() < 500, "{waited:?}");
}
