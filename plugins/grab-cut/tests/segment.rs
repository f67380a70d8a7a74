//! What a user of the segmenter relies on.

use std::collections::BTreeMap;
use std::sync::Mutex;

use glam::{Vec2, vec2};
use grab_cut::{Error, Footage, GrabCut, Known, Limb, Parameters, brush};

const WIDTH: usize = 200;
const HEIGHT: usize = 140;
const FRAMES: usize = 10;

/// A brown body with a leg that swings, on green ground with a brown wall behind the upper half of the body.
fn inside(frame: usize, x: usize, y: usize) -> bool {
    let p = vec2(x as f32 + 0.5 - 3.0 * frame as f32, y as f32 + 0.5);
    let body = ((p - vec2(80.0, 60.0)) / vec2(38.0, 18.0)).length() < 1.0;
    let along = (p - leg(frame, 0.0)).dot(leg(frame, 1.0) - leg(frame, 0.0)) / 50.0f32.powi(2);
    body || leg(frame, along.clamp(0.0, 1.0)).distance(p) < 6.0
}

/// Of the leg at `share` of its length, as if the body stood still.
fn leg(frame: usize, share: f32) -> Vec2 {
    vec2(90.0, 62.0) + Vec2::from_angle(1.2 + 0.08 * frame as f32) * 50.0 * share
}

fn colour(frame: usize, x: usize, y: usize) -> [u8; 3] {
    let hash = |k: usize| ((x * 73 + y * 151 + k * 37 + x * y * 7) % 23) as u8;
    if inside(frame, x, y) {
        [120 + hash(0), 80 + hash(1), 50 + hash(2)]
    } else if y < 55 {
        [135 + hash(3), 100 + hash(4), 62 + hash(5)]
    } else {
        [60 + hash(6), 120 + hash(7), 55 + hash(8)]
    }
}

fn picture(frame: usize) -> Result<Vec<u8>, String> {
    Ok((0..WIDTH * HEIGHT).flat_map(|i| colour(frame, i % WIDTH, i / WIDTH)).collect())
}

fn poses() -> Vec<Vec<Limb>> {
    let limb = |points: Vec<Vec2>| Limb { trust: vec![1.0; points.len()], points };
    let pose = |frame: usize| {
        let shift = vec2(3.0 * frame as f32, 0.0);
        let body = (0..9).map(|i| vec2(50.0 + 7.5 * i as f32, 60.0) + shift).collect();
        let leg = (0..7).map(|i| leg(frame, i as f32 / 6.0) + shift).collect();
        vec![limb(body), limb(leg)]
    };
    (0..FRAMES).map(pose).collect()
}

fn run(poses: &[Vec<Limb>], known: &BTreeMap<usize, Vec<Known>>) -> Result<Vec<Vec<u8>>, Error> {
    let masks = Mutex::new(vec![Vec::new(); poses.len()]);
    let footage = Footage { width: WIDTH, height: HEIGHT, frames: &picture, poses, known };
    let put = |frame: usize, mask: Vec<u8>| {
        masks.lock().expect("no panics")[frame] = mask;
        Ok(())
    };
    GrabCut::default().segment(&footage, &put, &|_| true)?;
    Ok(masks.into_inner().expect("no panics"))
}

#[test]
fn cuts_a_creature_that_shares_its_colour_with_a_wall() {
    for (frame, mask) in run(&poses(), &BTreeMap::new()).expect("sound input").iter().enumerate() {
        let (mut both, mut either) = (0.0, 0.0);
        for (i, &m) in mask.iter().enumerate() {
            let truth = inside(frame, i % WIDTH, i / WIDTH);
            both += f64::from(u8::from(truth && m == 255));
            either += f64::from(u8::from(truth || m == 255));
        }
        assert!(both / either > 0.85, "frame {frame}: {}", both / either);
    }
}

#[test]
fn what_was_painted_stays_and_other_frames_learn_of_it() {
    let mut known = vec![Known::Nothing; WIDTH * HEIGHT];
    // A part of the wall that the user wants, and the leg's end that the user does not.
    brush(&mut known, WIDTH, &[vec2(80.0, 20.0)], 8.0, Known::Creature);
    brush(&mut known, WIDTH, &[leg(0, 1.0)], 7.0, Known::Background);
    let painted = BTreeMap::from([(0, known.clone())]);
    let masks = run(&poses(), &painted).expect("sound input");
    for (m, k) in masks[0].iter().zip(&known) {
        match k {
            Known::Creature => assert_eq!(*m, 255),
            Known::Background => assert_eq!(*m, 0),
            Known::Nothing => {}
        }
    }
}

#[test]
fn the_same_bits_with_any_number_of_threads() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| run(&poses(), &BTreeMap::new())).expect("sound input")
    };
    assert!(with(1) == with(3));
}

#[test]
fn limbs_outside_the_picture_and_without_trust_are_no_trouble() {
    let mut away = poses();
    for pose in &mut away {
        pose[0].points.iter_mut().for_each(|p| *p += vec2(900.0, -700.0));
        pose[1].trust.fill(0.0);
    }
    assert_eq!(run(&away, &BTreeMap::new()).expect("sound input").len(), FRAMES);
    let point = Limb { points: vec![vec2(50.0, 50.0)], trust: vec![1.0] };
    assert_eq!(run(&vec![vec![point]; 3], &BTreeMap::new()).expect("sound input").len(), 3);
    assert!(run(&[], &BTreeMap::new()).expect("nothing to do").is_empty());
}

#[test]
fn what_cannot_be_cut_is_named() {
    let says = |poses: &[Vec<Limb>], known: &BTreeMap<usize, Vec<Known>>, what: &str| {
        let message = run(poses, known).expect_err(what).to_string();
        assert!(message.contains(what), "{message}");
    };
    let nothing = BTreeMap::new();
    says(&[vec![], vec![]], &nothing, "the limbs: there are 0");
    let mut wrong = poses();
    wrong[3].pop();
    says(&wrong, &nothing, "frame 3: 1 limbs");
    let mut wrong = poses();
    wrong[2][1].points[0].x = f32::NAN;
    says(&wrong, &nothing, "limb 1 in frame 2");
    let mut wrong = poses();
    wrong[2][0].trust.pop();
    says(&wrong, &nothing, "9 points and 8 trusts");
    says(&poses(), &BTreeMap::from([(1, vec![Known::Nothing; 7])]), "7 painted pixels");

    let parameters = Parameters { shape: f32::NAN, ..Parameters::default() };
    let footage = Footage { width: WIDTH, height: HEIGHT, frames: &picture, poses: &poses(), known: &nothing };
    let error = GrabCut { parameters }.segment(&footage, &|_, _| Ok(()), &|_| true).expect_err("not a number");
    assert!(matches!(error, Error::Parameter { name: "shape", .. }), "{error}");

    let damaged = |frame: usize| if frame == 4 { Err("is damaged".to_owned()) } else { picture(frame) };
    let footage = Footage { frames: &damaged, ..footage };
    let error = GrabCut::default().segment(&footage, &|_, _| Ok(()), &|_| true).expect_err("a frame is damaged");
    assert_eq!(error.to_string(), "frame 4: is damaged");
}
