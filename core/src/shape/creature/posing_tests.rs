//! Poses of a creature that is made by hand: a body, a leg under its start and a tail, drawn from its tip, at its end.

use glam::{Vec2, Vec3, vec2, vec3};
use image::RgbImage;

use super::*;
use crate::geometry::TriMesh;
use crate::job::Progress;
use crate::motion::limb_map::LimbMap;
use crate::motion::retarget::Angles;
use crate::motion::{Track, TrackFrame, TrackKind};
use crate::rig::Facing;
use crate::shape::character::Easing;
use crate::shape::{Bone, Transform};

const SIZE: (u32, u32) = (240, 200);
const LEG: f32 = 60.0;
const OFFSET: f32 = 8.0;
/// A quarter of the limbs' radius, and what rounding adds.
const SLACK: f32 = 1.25 + 1e-3;

fn creature() -> Creature {
    let curve = |from: Vec3, to: Vec3, offset: f32| -> Vec<Vec3> {
        let at = |i: usize| {
            let share = i as f32 / 40.0;
            from.lerp(to, share) + Vec3::Z * offset * path::hip_ramp(share)
        };
        (0..=40).map(at).collect()
    };
    let limbs = [
        ("body", vec3(60.0, 100.0, 0.0), vec3(180.0, 100.0, 0.0), 0.0, None, 5),
        ("leg", vec3(60.0, 100.0, 0.0), vec3(60.0, 40.0, 0.0), OFFSET, Some(false), 4),
        ("tail", vec3(180.0, 100.0, 0.0), vec3(220.0, 100.0, 0.0), 0.0, Some(true), 4),
    ];
    let (mut bones, mut placed, mut known) = (Vec::<Bone>::new(), Vec::new(), Vec::new());
    for (label, from, to, offset, held, count) in limbs {
        known.push(CreatureLimb {
            label: label.into(),
            side: None,
            twin: None,
            parent: held.map(|at_end| Hold { limb: 0, at_end }),
            reversed: label == "tail",
            first_bone: bones.len(),
            bones: count,
            length: from.distance(to),
            radius: 5.0,
            offset,
            settled: Vec::new(),
            settled_poses: Vec::new(),
        });
        for (k, bone) in chain::along(&curve(from, to, offset), count).into_iter().enumerate() {
            let above = if k > 0 { Some(bones.len() - 1) } else { held.map(|at_end| if at_end { 4 } else { 0 }) };
            bones.push(Bone { name: format!("{label}.{k}"), parent: above });
            placed.push(bone);
        }
    }
    let local = |(b, bone): (usize, &Bone)| chain::local(placed[b], bone.parent.map(|p| placed[p]));
    let rest: Vec<Transform> = bones.iter().enumerate().map(local).collect();
    let mesh = TriMesh {
        positions: vec![vec3(60.0, 90.0, 0.0), vec3(180.0, 90.0, 0.0), vec3(120.0, 110.0, 0.0)],
        normals: vec![Vec3::Z; 3],
        uvs: vec![Vec2::ZERO; 3],
        triangles: vec![[0, 1, 2]],
    };
    let part = SkinnedPart {
        name: "body".into(),
        mesh,
        bones: vec![[0; 4]; 3],
        weights: vec![[1.0, 0.0, 0.0, 0.0]; 3],
        texture: RgbImage::new(1, 1),
    };
    let model =
        RiggedModel { size: SIZE, fps: 24.0, bones, rest: rest.clone(), animation: vec![rest], parts: vec![part] };
    Creature { model, limbs: known, rest_frame: 0 }
}

fn drawn(limb: &str, points: &[(f32, f32)]) -> LimbPose {
    LimbPose { limb: limb.into(), points: points.iter().map(|&p| p.into()).collect(), ..LimbPose::default() }
}

fn at_rest() -> Vec<LimbPose> {
    vec![
        drawn("body", &[(60.0, 100.0), (180.0, 100.0)]),
        drawn("leg", &[(60.0, 100.0), (60.0, 160.0)]),
        drawn("tail", &[(220.0, 100.0), (180.0, 100.0)]),
    ]
}

/// Where a limb's bones are.
fn places(creature: &Creature, local: &[Transform], label: &str) -> Vec<Vec3> {
    let limb = creature.limbs.iter().find(|l| l.label == label).expect("the limb");
    chain::all_world(&creature.model.bones, local)[limb.bone_range()].iter().map(|p| p.0).collect()
}

fn posed(strokes: &[LimbPose]) -> Vec<Transform> {
    creature().posed(strokes, &PoseParams::default()).expect("a pose")
}

fn keys(keys: Vec<(usize, Easing, Vec<LimbPose>)>) -> PoseKeys {
    let key = |(frame, easing, limbs)| PoseKey { frame, easing, limbs };
    PoseKeys { size: SIZE, fps: None, step: 1, keys: keys.into_iter().map(key).collect() }
}

fn reposed(keys: &PoseKeys) -> Creature {
    creature().reposed(keys, None, &PoseParams::default(), Progress::new().whole()).expect("poses")
}

#[test]
fn drawn_as_it_rests_it_rests() {
    let creature = creature();
    let local = posed(&at_rest());
    for limb in ["body", "leg", "tail"] {
        for (a, b) in places(&creature, &local, limb).iter().zip(places(&creature, &creature.model.rest, limb)) {
            assert!(a.distance(b) < 0.05, "{limb}: {a} {b}");
        }
    }
    for (a, b) in local.iter().zip(&creature.model.rest) {
        assert!(a.rotation.dot(b.rotation).abs() > 1.0 - 1e-4);
    }
}

#[test]
fn a_limb_that_is_not_drawn_hangs_as_it_did() {
    let creature = creature();
    let local = posed(&[drawn("body", &[(100.0, 20.0), (100.0, 140.0)])]);
    assert_eq!(local[5..], creature.model.rest[5..]);
    let leg = places(&creature, &local, "leg");
    assert!(leg[0].distance(vec3(100.0, 180.0, 0.0)) < 1e-3, "{}", leg[0]);
    // The body has turned a quarter to the right, and the leg with it.
    assert!((leg[3] - leg[0]).truncate().distance(vec2(-LEG, 0.0)) < 0.1, "{}", leg[3]);
    assert_eq!(posed(&[])[..], creature.model.rest[..], "nothing drawn is the rest pose");
}

#[test]
fn a_short_stroke_leaves_the_plane_the_way_it_faces() {
    let creature = creature();
    for (facing, sign) in [(Facing::Toward, 1.0), (Facing::Away, -1.0)] {
        let leg = LimbPose { facing: Some(facing), ..drawn("leg", &[(60.0, 100.0), (60.0, 148.0)]) };
        let tail = LimbPose { facing: Some(facing), ..drawn("tail", &[(200.0, 100.0), (180.0, 100.0)]) };
        let local = posed(&[leg, tail]);
        let leg = places(&creature, &local, "leg");
        let out = leg[3].z - leg[0].z - OFFSET;
        assert!(out * sign > 25.0, "{out}");
        let length: f32 = leg.windows(2).map(|p| (p[1] - p[0]).length()).sum();
        assert!((length - LEG).abs() < 0.1 * LEG, "{length}");
        // A tail that is drawn from its tip faces with the end that is held.
        let tail = places(&creature, &local, "tail");
        assert!((tail[3].z - tail[0].z) * sign < -20.0, "{}", tail[3]);
    }
    let plain = places(&creature, &posed(&[drawn("leg", &[(60.0, 100.0), (60.0, 148.0)])]), "leg");
    assert!((plain[3].z - plain[0].z - OFFSET).abs() < 1e-3, "a little shorter is only shorter");
    let much = places(&creature, &posed(&[drawn("leg", &[(60.0, 100.0), (60.0, 115.0)])]), "leg");
    assert!(much[3].z > 40.0, "much shorter comes toward the viewer");
}

#[test]
fn depth_and_bend_are_where_they_are_said_to_be() {
    let creature = creature();
    let plain = places(&creature, &posed(&at_rest()), "leg");
    let pose = LimbPose { depth: 11.0, bend: Some(-20.0), ..at_rest()[1].clone() };
    let leg = places(&creature, &posed(&[pose]), "leg");
    assert!((leg[3].z - plain[3].z - (11.0 - 20.0)).abs() < 1.0, "{} {}", leg[3], plain[3]);
    assert!(leg[0].distance(plain[0]) < 1e-3, "its joint stays closed");
}

#[test]
fn limits_hold_against_wild_strokes() {
    let creature = creature();
    let params = PoseParams::default();
    let zigzag: Vec<(f32, f32)> =
        (0..9).map(|i| (30.0 + 3.0 * i as f32, if i % 2 == 0 { 20.0 } else { 190.0 })).collect();
    let wild = [
        drawn("leg", &[(60.0, 100.0), (60.0, 400.0)]),
        drawn("leg", &[(230.0, 10.0), (10.0, 190.0)]),
        drawn("leg", &[(60.0, 100.0), (60.0, 130.0), (61.0, 100.0), (61.0, 160.0)]),
        drawn("leg", &zigzag),
    ];
    for (i, pose) in wild.into_iter().enumerate() {
        let mut posed = creature.clone();
        posed.model.animation = vec![creature.posed(&[pose], &params).expect("a pose")];
        posed.validate().expect("sound");
        let strain = &posed.strain()[1];
        // What the way out from the hip adds is not the stroke's.
        assert!(strain.longest < params.stretch * 1.03, "{i}: {strain:?}");
        assert!(strain.sharpest <= params.sharpest.to_degrees() + 0.1, "{i}: {strain:?}");
        assert!(strain.gap < SLACK, "{i}: {strain:?}");
    }
    let crossed =
        posed(&[drawn("leg", &[(60.0, 100.0), (120.0, 60.0)]), drawn("tail", &[(150.0, 120.0), (180.0, 100.0)])]);
    assert!(crossed.iter().all(|t| t.translation.is_finite() && t.rotation.is_finite()));
}

#[test]
fn lengths_can_be_kept_whatever_is_drawn() {
    let creature = creature();
    let params = PoseParams { keep_lengths: true, ..PoseParams::default() };
    let lengths = |local: &[Transform]| -> Vec<f32> { local.iter().map(|t| t.translation.length()).collect() };
    let rest = lengths(&creature.model.rest);
    for end in [(60.0, 110.0), (90.0, 170.0), (60.0, 300.0)] {
        let local = creature.posed(&[drawn("leg", &[(60.0, 100.0), end])], &params).expect("a pose");
        for (bone, (a, b)) in lengths(&local).iter().zip(&rest).enumerate() {
            assert!((a - b).abs() < 0.02, "bone {bone} toward {end:?}: {a} is not {b}");
        }
    }
}

#[test]
fn every_mistake_is_named() {
    let whole = creature();
    let leg = || drawn("leg", &[(60.0, 100.0), (60.0, 160.0)]);
    let point = |x: f32, y: f32| drawn("leg", &[(60.0, 100.0), (x, y)]);
    let cases = [
        (vec![drawn("wing", &[(0.0, 0.0), (9.0, 9.0)])], "it has `body`, `leg`, `tail`"),
        (vec![leg(), leg()], "twice"),
        (vec![drawn("leg", &[(1.0, 1.0)])], "1 points"),
        (vec![point(60.0, 100.0)], "shorter than a pixel"),
        (vec![point(f32::NAN, 1.0)], "far outside"),
        (vec![point(1e9, 1.0)], "far outside"),
        (vec![LimbPose { bend: Some(f32::INFINITY), ..leg() }], "a bend"),
        (vec![LimbPose { depth: f32::NAN, ..leg() }], "a depth"),
    ];
    for (strokes, expected) in cases {
        let message = whole.posed(&strokes, &PoseParams::default()).expect_err(expected).to_string();
        assert!(message.contains(expected), "{message} should say {expected}");
    }
    let bad = PoseParams { stretch: f32::NAN, ..PoseParams::default() };
    assert!(whole.posed(&[leg()], &bad).expect_err("stretch").to_string().contains("stretch"));
    let unknown = Creature::from(whole.model);
    assert!(unknown.posed(&[leg()], &PoseParams::default()).is_err());
}

#[test]
fn keys_hold_to_the_bit_and_limbs_keep_their_lengths_between_them() {
    let raised = vec![drawn("leg", &[(60.0, 100.0), (10.0, 67.0)])];
    let moved = vec![drawn("body", &[(70.0, 90.0), (180.0, 138.0)]), drawn("leg", &[(70.0, 90.0), (118.0, 54.0)])];
    let keys = keys(vec![
        (0, Easing::InOut, at_rest()),
        (10, Easing::Linear, raised.clone()),
        (20, Easing::Linear, moved.clone()),
    ]);
    let out = reposed(&keys);
    out.validate().expect("sound");
    assert_eq!(out.model.animation.len(), 21);
    assert_eq!(out.model.animation[0][..], posed(&at_rest())[..]);
    let last = posed(&moved);
    for (a, b) in out.model.animation[20][..9].iter().zip(&last[..9]) {
        assert!(a.translation == b.translation && a.rotation.dot(b.rotation).abs() > 1.0 - 1e-6);
    }
    let length = |f: usize, bone: usize| out.model.animation[f][bone].translation.length();
    for bone in 1..out.model.bones.len() {
        for (from, to) in [(0, 10), (10, 20)] {
            let (low, high) = (length(from, bone).min(length(to, bone)), length(from, bone).max(length(to, bone)));
            let held = (from..to).all(|f| length(f, bone) > low - 1e-3 && length(f, bone) < high + 1e-3);
            assert!(held, "bone {bone} between {from} and {to}");
        }
    }
    assert!(out.strain().iter().all(|s| s.gap < SLACK));
    // The body is drawn on frames 0 and 20 only: on frame 10 it is half way.
    let body = |f: usize| places(&out, &out.model.animation[f], "body")[0];
    assert!(body(10).distance((body(0) + body(20)) / 2.0) < 0.01);
    // Eased: little happens at first.
    let foot = |f: usize| places(&out, &out.model.animation[f], "leg")[3];
    assert!(foot(0).distance(foot(1)) < 0.6 * foot(5).distance(foot(4)));
    assert_eq!(reposed(&keys).model, out.model, "the same each time");
}

#[test]
fn steps_holds_and_rates_are_kept() {
    let up = vec![drawn("leg", &[(60.0, 100.0), (0.0, 100.0)])];
    let mut keys =
        keys(vec![(0, Easing::Hold, at_rest()), (6, Easing::Linear, up.clone()), (12, Easing::Linear, at_rest())]);
    (keys.step, keys.fps) = (2, Some(12.0));
    let creature = creature();
    let out = creature.reposed(&keys, Some(30), &PoseParams::default(), Progress::new().whole()).expect("poses");
    let animation = &out.model.animation;
    assert_eq!((animation.len(), out.model.fps), (30, 12.0));
    assert!(animation[..6].iter().all(|pose| *pose == animation[0]));
    assert!(animation[6] == animation[7] && animation[7] != animation[8] && animation[8] == animation[9]);
    assert!(animation[12..].iter().all(|pose| *pose == animation[12]));
}

#[test]
fn poses_drawn_on_a_larger_picture_of_the_clip_fit() {
    let double = |p: &LimbPose| LimbPose { points: p.points.iter().map(|p| *p * 2.0).collect(), ..p.clone() };
    let mut large = keys(vec![(0, Easing::Linear, at_rest().iter().map(double).collect())]);
    large.size = (480, 400);
    assert_eq!(reposed(&large).model.animation[0], posed(&at_rest()));
    large.size = (480, 300);
    let progress = Progress::new();
    let refused = creature().reposed(&large, None, &PoseParams::default(), progress.whole());
    assert!(refused.expect_err("another shape").to_string().contains("480x300"));
}

#[test]
fn key_poses_are_strokes_and_come_back_from_their_file() {
    let mut pose = at_rest()[1].clone();
    (pose.facing, pose.bend, pose.depth) = (Some(Facing::Away), Some(-7.5), 3.0);
    let mut keys = keys(vec![(2, Easing::InOut, at_rest()), (9, Easing::Hold, vec![pose])]);
    (keys.fps, keys.step) = (Some(12.5), 2);
    let text = keys.to_json();
    assert_eq!(PoseKeys::from_json(&text).expect("as written"), keys);
    let rig = Rig::from_json(&text).expect("strokes too");
    let again = PoseKeys::from(&rig);
    assert_eq!(again.keys[1].limbs, keys.keys[1].limbs);
    let mistakes = [
        ("{}", "not readable"),
        (&text.replace("marey-strokes", "marey-poses"), "marey-poses"),
        (&text.replace("\"version\":1", "\"version\":7"), "version 7"),
        (&text.replace("\"step\":2", "\"step\":0"), "no frame"),
        (&text.replace("12.5", "-1"), "rate"),
        (&text.replace("\"frame\":9", "\"frame\":2"), "twice"),
        (r#"{"format":"marey-strokes","version":1,"size":[9,9],"keyframes":[]}"#, "no limb"),
    ];
    for (text, expected) in mistakes {
        let message = PoseKeys::from_json(text).expect_err(expected).to_string();
        assert!(message.contains(expected), "{message} should say {expected}");
    }
    keys.keys[1].frame = usize::MAX - 1;
    let progress = Progress::new();
    let refused = creature().reposed(&keys, None, &PoseParams::default(), progress.whole());
    assert!(matches!(refused, Err(Error::Limit { .. })), "a frame that no machine gets to");
}

/// A larger body walking to the left of its first place, with its leg as two joints and a tail that shrinks to nothing.
fn foreign(frames: usize) -> Motion {
    let track = |name: &str, kind: TrackKind, at: &dyn Fn(f32) -> Vec<Vec2>| Track {
        name: name.into(),
        kind,
        frames: (0..frames).map(|f| TrackFrame::certain(at(f as f32))).collect(),
    };
    let hip = |f: f32| vec2(900.0 - 6.0 * f, 500.0);
    let knee = move |f: f32| hip(f) + 150.0 * Vec2::from_angle(1.2 + 0.3 * (f * 0.7).sin());
    let foot = move |f: f32| knee(f) + 150.0 * Vec2::from_angle(2.0 + 0.3 * (f * 0.7).cos());
    Motion {
        size: (2000, 1000),
        fps: 30.0,
        frames,
        tracks: vec![
            track("Body", TrackKind::Stroke, &|f| {
                vec![hip(f), hip(f) + vec2(300.0, 10.0 * f), hip(f) + vec2(600.0, 0.0)]
            }),
            track("hip", TrackKind::Joint, &|f| vec![hip(f)]),
            track("knee", TrackKind::Joint, &|f| vec![knee(f)]),
            track("foot", TrackKind::Joint, &|f| vec![foot(f)]),
            track("tip", TrackKind::Stroke, &|f| {
                let tip = vec2(100.0, 0.0) * (1.0 - f / (frames - 1) as f32);
                vec![hip(f) + vec2(600.0, 0.0), hip(f) + vec2(600.0, 0.0) + tip]
            }),
        ],
        bones: Vec::new(),
    }
}

const MAP: &str = r#"{"limbs": {"body": {"tracks": ["Body"]}, "leg": {"tracks": ["hip", "knee", "foot"]},
    "tail": {"tracks": ["tip"], "reversed": true, "facing": "away"}}}"#;

/// Limbs point where the motion's do.
fn pointing() -> DriveParams {
    DriveParams { angles: Some(Angles::Absolute), ..DriveParams::default() }
}

fn driven(motion: &Motion, map: Option<&str>, params: &DriveParams) -> Result<Creature> {
    let map = map.map(|text| LimbMap::from_json(text).expect("a map"));
    creature().driven(motion, map.as_ref(), params, Progress::new().whole())
}

#[test]
fn another_bodys_motion_moves_it_in_its_own_proportions() {
    let motion = foreign(12);
    let out = driven(&motion, Some(MAP), &pointing()).expect("driven");
    out.validate().expect("sound");
    assert_eq!((out.model.animation.len(), out.model.fps), (12, 30.0));
    let lengths = |local: &[Transform]| -> Vec<f32> { local.iter().skip(1).map(|t| t.translation.length()).collect() };
    let rest = lengths(&out.model.rest);
    for (f, local) in out.model.animation.iter().enumerate() {
        for (bone, (a, b)) in lengths(local).iter().zip(&rest).enumerate() {
            assert!((a - b).abs() < 0.02, "frame {f}, bone {bone}: {a} is not {b}");
        }
    }
    assert!(out.strain().iter().all(|s| s.gap < 1e-4));
    // It starts where the creature does, and goes a body's length as far as the other one does.
    let start = |f: usize| places(&out, &out.model.animation[f], "body")[0];
    assert!(start(0).distance(vec3(60.0, 100.0, 0.0)) < 1e-3);
    let scale = (120.0 + LEG + 40.0) / (600.0 + 300.0 + 100.0);
    assert!((start(0).x - start(11).x - 66.0 * scale).abs() < 1.0, "{}", start(11));
    // The leg points where the other's does.
    let leg = places(&out, &out.model.animation[0], "leg");
    let theirs = motion.tracks[3].frames[0].points[0] - motion.tracks[1].frames[0].points[0];
    let turn = (leg[3] - leg[0]).truncate().angle_to(vec2(theirs.x, -theirs.y));
    assert!(turn.abs() < 0.1, "{turn}");
    // The tail ends away from the viewer, where it is seen from its tip.
    let tail = places(&out, &out.model.animation[11], "tail");
    assert!(tail[3].z.abs() > 30.0, "{}", tail[3]);
}

#[test]
fn maps_names_mirrors_and_mistakes() {
    let motion = foreign(4);
    let creature = creature();
    let named = creature.matched(&motion, None).expect("by name");
    assert_eq!(named.limbs.keys().collect::<Vec<_>>(), ["body"]);
    assert_eq!(LimbMap::from_json(&named.to_json()).expect("as written"), named);
    let resting = driven(&motion, None, &pointing()).expect("driven");
    assert!(resting.model.animation.iter().all(|local| local[5..] == resting.model.rest[5..]), "no track, no motion");
    let mirrored = DriveParams { mirror: true, root_scale: Some(0.0), ..pointing() };
    let out = driven(&motion, None, &mirrored).expect("driven");
    let body = places(&out, &out.model.animation[3], "body");
    assert!(body[0].distance(vec3(60.0, 100.0, 0.0)) < 1e-3 && body[4].x < -40.0, "{body:?}");
    let cases = [
        (r#"{"limbs": {"wing": {"tracks": ["Body"]}}}"#, "`wing`"),
        (r#"{"limbs": {"leg": {"tracks": ["shin"]}}}"#, "`shin`"),
        (r#"{"limbs": {"leg": {"tracks": ["hip"]}}}"#, "two points"),
        (r#"{"limbs": {"leg": {"tracks": []}}}"#, "two points"),
    ];
    for (map, expected) in cases {
        let message = driven(&motion, Some(map), &pointing()).expect_err(expected).to_string();
        assert!(message.contains(expected), "{message} should say {expected}");
    }
    assert!(LimbMap::from_json("[]").is_err() && LimbMap::from_json(r#"{"limbs": {}}"#).is_err());
    // Where no name is the same, what lies alike is followed.
    let mut strange = creature.motion();
    strange.tracks.iter_mut().for_each(|t| t.name = format!("{} of a stranger", t.name));
    strange.bones.clear();
    let alike = creature.matched(&strange, None).expect("alike");
    for limb in &creature.limbs {
        assert_eq!(alike.limbs[&limb.label].tracks, [format!("{} of a stranger", limb.label)]);
    }
    assert!(LimbMap::from_json(r#"{"format": "x", "limbs": {"a": {"tracks": ["b"]}}}"#).is_err());
    let mut huge = motion.clone();
    huge.tracks[0].frames[1].points[1] = Vec2::splat(f32::MAX);
    let message = driven(&huge, None, &pointing()).expect_err("huge").to_string();
    assert!(message.contains("bounds"), "{message}");
    let bad = DriveParams { root_scale: Some(f32::NAN), ..pointing() };
    assert!(driven(&motion, None, &bad).is_err());
    let progress = Progress::new();
    progress.cancel();
    let cancelled = creature.driven(&motion, None, &pointing(), progress.whole());
    assert!(matches!(cancelled, Err(Error::Cancelled)));
}

#[test]
fn another_bodys_motion_turns_limbs_from_their_own_pose() {
    let creature = creature();
    // The same steps by a body that carries itself quite otherwise: twice as large, and all of it turned by half a right angle.
    let turned = |points: &[Vec2]| -> Vec<Vec2> {
        let turn = Vec2::from_angle(0.8);
        points.iter().map(|p| turn.rotate(*p - vec2(120.0, 100.0)) * 2.0 + vec2(400.0, 400.0)).collect()
    };
    let swing = |f: usize| 0.4 * (f as f32 * 0.7).sin();
    let mut motion = creature.motion();
    (motion.size, motion.frames, motion.bones) = ((800, 800), 18, Vec::new());
    for track in &mut motion.tracks {
        let rest = track.frames[0].points.clone();
        let hip = rest[0];
        let frame = |f: usize| {
            let angle = if track.name == "leg" { swing(f) } else { 0.0 };
            let points: Vec<Vec2> = rest.iter().map(|p| hip + Vec2::from_angle(angle).rotate(*p - hip)).collect();
            TrackFrame::certain(turned(&points))
        };
        track.frames = (0..18).map(frame).collect();
    }
    let out = driven(&motion, None, &DriveParams { root_scale: Some(0.0), ..DriveParams::default() }).expect("driven");
    let way = |local: &[Transform], limb: &str| {
        let at = places(&out, local, limb);
        (at[at.len() - 1] - at[0]).truncate().to_angle()
    };
    let mean = (0..18).map(|f| way(&out.model.animation[f], "leg")).sum::<f32>() / 18.0;
    assert!(
        (mean - way(&creature.model.animation[0], "leg")).abs() < 0.05,
        "{mean}: the leg swings about its own pose"
    );
    for f in 0..18 {
        let local = &out.model.animation[f];
        assert!((way(local, "body") - way(&creature.model.animation[0], "body")).abs() < 0.02, "the body stays level");
        let about = (0..18).map(swing).sum::<f32>() / 18.0;
        // World y goes up where the picture's goes down.
        assert!((way(local, "leg") - mean + swing(f) - about).abs() < 0.06, "frame {f} swings as theirs does");
    }
    let pointing = driven(&motion, None, &pointing()).expect("driven");
    let at = places(&pointing, &pointing.model.animation[0], "body");
    assert!((at[4] - at[0]).truncate().to_angle() < -0.7, "pointing, it tips over");
}
