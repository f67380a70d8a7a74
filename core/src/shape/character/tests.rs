use super::*;
use crate::deform::needles::NeedleDeformer;
use crate::job::Progress;
use crate::motion::Motion;
use crate::raster::Mask;
use glam::vec2;

/// A picture that is opaque where `inside` holds.
fn drawn(width: u32, height: u32, inside: impl Fn(Vec2) -> bool) -> RgbaImage {
    RgbaImage::from_fn(width, height, |x, y| {
        let on = inside(vec2(x as f32 + 0.5, y as f32 + 0.5));
        image::Rgba([200, 90, 40, if on { 255 } else { 0 }])
    })
}

fn near_segment(p: Vec2, a: Vec2, b: Vec2, radius: f32) -> bool {
    polygon::nearest_on_segment(a, b, p).1.distance(p) <= radius
}

fn rigged(picture: &RgbaImage) -> Result<Character> {
    Character::from_picture(picture, &RigParams::default(), Progress::new().whole())
}

/// A figure with a body, a head, two arms and two legs.
fn figure() -> RgbaImage {
    drawn(300, 400, |p| {
        near_segment(p, vec2(150.0, 140.0), vec2(150.0, 230.0), 36.0)
            || p.distance(vec2(150.0, 70.0)) < 42.0
            || near_segment(p, vec2(150.0, 140.0), vec2(40.0, 190.0), 13.0)
            || near_segment(p, vec2(150.0, 140.0), vec2(260.0, 190.0), 13.0)
            || near_segment(p, vec2(150.0, 230.0), vec2(100.0, 370.0), 16.0)
            || near_segment(p, vec2(150.0, 230.0), vec2(200.0, 370.0), 16.0)
    })
}

fn area(mesh: &PlaneMesh) -> f64 {
    (0..mesh.triangles.len()).map(|t| mesh.area(t)).sum()
}

#[test]
fn a_figure_gets_its_silhouette_five_limbs_and_regions_that_follow_them() {
    let picture = figure();
    let character = rigged(&picture).expect("a rig");
    let pixels = picture.pixels().filter(|p| p.0[3] > 127).count() as f64;
    assert!((area(&character.mesh) / pixels - 1.0).abs() < 0.01);
    assert!((0..character.mesh.triangles.len()).all(|t| character.mesh.area(t) > 0.0));
    let skeleton = &character.skeleton;
    let ends: Vec<Vec2> = (0..skeleton.joints.len())
        .filter(|j| skeleton.bones.iter().flatten().filter(|k| *k == j).count() == 1)
        .map(|j| skeleton.joints[j].at)
        .collect();
    assert_eq!(ends.len(), 5, "{ends:?}");
    for wished in [vec2(150.0, 60.0), vec2(40.0, 190.0), vec2(260.0, 190.0), vec2(100.0, 370.0), vec2(200.0, 370.0)] {
        assert!(ends.iter().any(|p| p.distance(wished) < 25.0), "{wished} in {ends:?}");
    }
    assert_eq!(skeleton.roots().len(), 1);
    // The tip of the left hand and of the right foot follow bones that end near them.
    for tip in [vec2(30.0, 194.0), vec2(204.0, 380.0)] {
        let v = (0..character.mesh.points.len())
            .min_by(|&a, &b| character.mesh.points[a].distance(tip).total_cmp(&character.mesh.points[b].distance(tip)))
            .expect("vertices");
        let bone = skeleton.bones[character.regions.bone[v] as usize];
        assert!(skeleton.joints[bone[1]].at.distance(tip) < 30.0);
    }
    assert!(character.regions.joins.iter().any(|j| *j) && !character.regions.joins.iter().all(|j| *j));
    let on = character.on_curve(vec2(60.0, 200.0)).expect("a curve");
    assert!(on.distance(vec2(60.0, 182.0)) < 12.0);
    // Twice as fine at joints as away from them.
    let coarse =
        Character::from_picture(&picture, &RigParams { vertices: 300, finer_at_joints: 1.0 }, Progress::new().whole());
    let coarse = coarse.expect("a rig").mesh.points.len();
    assert!((200..600).contains(&coarse) && character.mesh.points.len() > 1200, "{coarse}");
}

#[test]
fn paper_is_told_from_a_drawing_on_it() {
    let cut = figure();
    let on_paper = RgbaImage::from_fn(300, 400, |x, y| {
        let shade = (230 - (x / 10) as i32 + ((x * 7 + y * 13) % 5) as i32) as u8;
        let p = cut.get_pixel(x, y).0;
        // Only the outline is drawn: the inside is paper.
        let rim = p[3] > 0
            && (-3i32..=3).any(|d| {
                let at = |x: i32, y: i32| cut.get_pixel(x.clamp(0, 299) as u32, y.clamp(0, 399) as u32).0[3] == 0;
                at(x as i32 + d, y as i32) || at(x as i32, y as i32 + d)
            });
        image::Rgba(if rim { [40, 40, 60, 255] } else { [shade, shade, shade - 12, 255] })
    });
    let found = cutout::opacity(&on_paper).expect("a drawing");
    let mask = |g: &Grid<f32>| Mask::from_fn(300, 400, |x, y| g.get(x, y) > 0.5);
    let wished = Mask::from_fn(300, 400, |x, y| cut.get_pixel(x as u32, y as u32).0[3] > 0);
    assert!(mask(&found).iou(&wished) > 0.97, "{}", mask(&found).iou(&wished));
}

#[test]
fn what_is_no_drawing_is_refused_by_name() {
    for (picture, problem) in [
        (RgbaImage::new(0, 0), "no pixels"),
        (RgbaImage::new(50, 40), "transparent"),
        (RgbaImage::from_pixel(50, 40, image::Rgba([9, 9, 9, 255])), "one colour"),
        (drawn(50, 40, |p| p.x < 1.0 && p.y < 1.0), "triangles"),
    ] {
        match rigged(&picture) {
            Ok(c) => assert!(problem == "triangles" && !c.mesh.triangles.is_empty()),
            Err(error) => assert!(error.to_string().contains(problem), "{error}"),
        }
    }
    let progress = Progress::new();
    progress.cancel();
    assert!(matches!(
        Character::from_picture(&figure(), &RigParams::default(), progress.whole()),
        Err(Error::Cancelled)
    ));
    let wrong = RigParams { vertices: 10_000_000, ..RigParams::default() };
    assert!(matches!(Character::from_picture(&figure(), &wrong, Progress::new().whole()), Err(Error::Limit { .. })));
}

#[test]
fn pieces_holes_and_a_limb_of_one_pixel() {
    let picture = drawn(260, 200, |p| {
        let ring = (p.distance(vec2(70.0, 100.0)) - 45.0).abs() < 14.0;
        let bar = near_segment(p, vec2(160.0, 60.0), vec2(230.0, 60.0), 15.0);
        let hair = (p.x - 195.5).abs() < 0.6 && (60.0..160.0).contains(&p.y);
        let crumb = p.distance(vec2(150.0, 150.0)) < 6.0;
        ring || bar || hair || crumb
    });
    let character = rigged(&picture).expect("a rig");
    let pixels = picture.pixels().filter(|p| p.0[3] > 127).count() as f64;
    assert!((area(&character.mesh) / pixels - 1.0).abs() < 0.03, "{} {pixels}", area(&character.mesh));
    assert_eq!(character.mesh.rims().len(), 4);
    // The ring and the bar have trees of their own, the crumb has none; the ring's circle is open.
    assert_eq!(character.skeleton.roots().len(), 2);
    let ends_at = |p: Vec2, reach: f32| character.skeleton.joints.iter().any(|j| j.at.distance(p) < reach);
    assert!(ends_at(vec2(195.5, 158.0), 10.0), "the hair's tip: {:?}", character.skeleton.joints);
    let crumb =
        (0..character.mesh.points.len()).filter(|&v| character.mesh.points[v].distance(vec2(150.0, 150.0)) < 7.0);
    assert!(crumb.count() > 3);
}

#[test]
fn a_disc_gets_a_bone_and_the_same_rig_twice() {
    let picture = drawn(120, 120, |p| p.distance(vec2(60.0, 60.0)) < 40.0);
    let character = rigged(&picture).expect("a rig");
    assert!(!character.skeleton.bones.is_empty());
    assert_eq!(character, rigged(&picture).expect("a rig"));
}

#[test]
fn bones_outside_of_no_length_and_on_one_spot_have_their_results() {
    let character = rigged(&figure()).expect("a rig");
    let joint = |name: &str, x: f32, y: f32| Joint { name: name.into(), at: vec2(x, y) };
    let joints = vec![
        joint("a", 150.0, 140.0),
        joint("b", 150.0, 230.0),
        joint("out", 290.0, 20.0),
        joint("further", 295.0, 5.0),
        joint("b2", 150.0, 230.0),
        joint("c", 100.0, 370.0),
        joint("c2", 100.0, 370.0),
    ];
    let bones = vec![[0, 1], [2, 3], [1, 4], [4, 5], [1, 6]];
    let own = character.with_skeleton(Skeleton { joints, bones }).expect("kept");
    let order = |a: &str, b: &str| {
        let (a, b) = (own.skeleton.joint(a), own.skeleton.joint(b));
        own.skeleton.bones.iter().position(|k| Some(k[0]) == a && Some(k[1]) == b).expect("the bone") as u32
    };
    let owned = |bone: u32| own.regions.bone.iter().filter(|b| **b == bone).count();
    // Outside: nothing. On one spot: the one that comes first has it.
    assert_eq!(owned(order("out", "further")), 0);
    let (first, second) = (order("b2", "c"), order("b", "c2"));
    assert_eq!(owned(first.max(second)), 0);
    assert!(owned(first.min(second)) > 50);
}

#[test]
fn a_rig_file_comes_back_and_damaged_ones_are_refused() {
    let character = rigged(&figure()).expect("a rig");
    let text = character.to_json();
    assert_eq!(Character::from_json(&text).expect("comes back"), character);
    for (damage, with, problem) in [
        ("marey-rig", "marey-strokes", "format"),
        ("\"version\":1", "\"version\":7", "version 7"),
        ("\"triangles\":[[", "\"triangles\":[[999999,0,1],[", "not there"),
        ("\"bones\":[[\"joint", "\"bones\":[[\"elbow", "elbow"),
        ("{", "", "not readable"),
    ] {
        let error = Character::from_json(&text.replacen(damage, with, 1)).expect_err("refused").to_string();
        assert!(error.contains(problem), "{error}");
    }
}

/// The figure with its left arm up by `degrees`, and where its joints are then.
fn arm_up(character: &Character, degrees: f32) -> Vec<Vec2> {
    let skeleton = &character.skeleton;
    let hand = (0..skeleton.joints.len())
        .min_by(|&a, &b| skeleton.joints[a].at.x.total_cmp(&skeleton.joints[b].at.x))
        .expect("joints");
    let bone = skeleton.bones.iter().position(|b| b[1] == hand).expect("a bone");
    let from = skeleton.joints[skeleton.bones[bone][0]].at;
    let mut joints = skeleton.rest();
    joints[hand] = from + Vec2::from_angle(degrees.to_radians()).rotate(joints[hand] - from);
    joints
}

#[test]
fn in_betweens_are_exact_at_both_ends_and_turn_the_shorter_way() {
    let character = rigged(&figure()).expect("a rig");
    let (low, high) = (arm_up(&character, -50.0), arm_up(&character, 60.0));
    let key = |frame, joints: &Vec<Vec2>| KeyPose { frame, joints: joints.clone(), ..KeyPose::default() };
    let mut keys = vec![key(0, &low), key(10, &high), key(14, &low)];
    keys[1].moved = vec![(5, vec2(3.0, -2.0))];
    keys[1].easing = Easing::InOut;
    keys[1].depth = vec![(1, 2)];
    let poses = Poses { fps: 24.0, step: 1, keys };
    let progress = Progress::new();
    let own = Animation::new(&character, &NeedleDeformer::default(), poses.clone(), progress.whole()).expect("solved");
    let mut poser = character.poser(&NeedleDeformer::default(), progress.whole()).expect("bound");
    let mut wished = poser.pose(&high, progress.whole()).expect("posed");
    wished[5] += vec2(3.0, -2.0);
    assert_eq!(own.frame(10).expect("a frame"), wished);
    assert_eq!(own.frame(0).expect("a frame"), poser.pose(&low, progress.whole()).expect("posed"));
    assert_eq!((own.frames(), own.joints(10), own.joints(99)), (15, high.clone(), low.clone()));
    assert_eq!((own.depths(12)[1], own.depths(3)[1]), (2, 0));
    // Near an end there is no jump, and nothing folds on the way.
    let farthest = |a: &[Vec2], b: &[Vec2]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    for f in 0..14 {
        let (a, b) = (own.frame(f).expect("a frame"), own.frame(f + 1).expect("a frame"));
        assert!(farthest(&a, &b) < 95.0, "{f}");
        let folded = character.mesh.triangles.iter().filter(|&&t| {
            let [p, q, r] = t.map(|v| a[v as usize]);
            (q - p).perp_dot(r - p) <= 0.0
        });
        assert!(folded.count() * 200 < character.mesh.triangles.len(), "{f}");
    }
    // Half way, the arm is half way round.
    let middle = own.joints(5);
    assert!(farthest(&middle, &arm_up(&character, 5.0)) < 0.1);
    // On twos every other frame is the one before.
    let twos = Poses { step: 2, ..poses };
    let twos = Animation::new(&character, &NeedleDeformer::default(), twos, progress.whole()).expect("solved");
    assert_eq!(twos.frame(4).expect("a frame"), twos.frame(5).expect("a frame"));
    assert_eq!(twos.frame(4).expect("a frame"), own.frame(4).expect("a frame"));
}

#[test]
fn easings_keep_their_ends() {
    for easing in [Easing::Linear, Easing::In, Easing::Out, Easing::InOut, Easing::Hold] {
        assert_eq!((easing.share(0.0), easing.share(1.0), easing.share(7.0)), (0.0, 1.0, 1.0));
        let steps: Vec<f64> = (0..=20).map(|i| easing.share(f64::from(i) / 20.0)).collect();
        assert!(steps.windows(2).all(|s| s[0] <= s[1]));
    }
    assert_eq!(Easing::Hold.share(0.999), 0.0);
}

#[test]
fn a_poses_file_comes_back_and_damaged_ones_are_refused() {
    let character = rigged(&figure()).expect("a rig");
    let key = KeyPose {
        frame: 3,
        joints: arm_up(&character, 30.0),
        easing: Easing::Out,
        moved: vec![(7, vec2(1.0, 2.5))],
        depth: vec![(2, -1)],
    };
    let poses = Poses { fps: 12.0, step: 2, keys: vec![key] };
    let text = poses.to_json(&character);
    assert_eq!(Poses::from_json(&text, &character).expect("comes back"), poses);
    for (damage, with) in [
        ("marey-poses", "marey-rig"),
        ("\"version\":1", "\"version\":2"),
        ("\"joint0\"", "\"elbow\""),
        ("\"step\":2", "\"step\":0"),
        ("[[7,", "[[70000,"),
        ("\"keys\":[", "\"keys\":[{}"),
    ] {
        assert!(
            text.contains(damage) && Poses::from_json(&text.replacen(damage, with, 1), &character).is_err(),
            "{damage}"
        );
    }
    // A joint that is left out hangs as it does at rest.
    let partly = "{\"format\":\"marey-poses\",\"version\":1,\"keys\":[{\"frame\":0,\"joints\":{}}]}";
    assert_eq!(Poses::from_json(partly, &character).expect("read").keys[0].joints, character.skeleton.rest());
}

#[test]
fn a_motion_drives_the_character_by_its_joints() {
    use crate::motion::retarget::{RestSkeleton, RetargetMap, RetargetParams, retarget};
    use crate::motion::{Track, TrackFrame, TrackKind};
    let character = rigged(&figure()).expect("a rig");
    let named: Vec<(String, Vec2)> = character.skeleton.joints.iter().map(|j| (j.name.clone(), j.at)).collect();
    let poses: Vec<Vec<Vec2>> = (0..5).map(|f| arm_up(&character, 12.0 * f as f32)).collect();
    let track = |j: usize| Track {
        name: named[j].0.clone(),
        kind: TrackKind::Joint,
        frames: poses.iter().map(|p| TrackFrame::certain(vec![p[j]])).collect(),
    };
    let motion =
        Motion { size: (300, 400), fps: 24.0, frames: 5, tracks: (0..named.len()).map(track).collect(), bones: vec![] };
    let skeleton = RestSkeleton { joints: &named, bones: &character.skeleton.bones, size: character.size };
    let own = retarget(&motion, skeleton, &RetargetMap::default(), &RetargetParams::default()).expect("carried over");
    let progress = Progress::new();
    let mut poser = character.poser(&NeedleDeformer::default(), progress.whole()).expect("bound");
    let take = Take::of_motion(&mut poser, &own, &[], progress.whole()).expect("posed");
    assert_eq!(take.frames.len(), 5);
    let driven = poser.pose(&poses[4], progress.whole()).expect("posed");
    assert_eq!(take.frames[4].points, driven);
    let mut dragged = poser.pose(&poses[3], progress.whole()).expect("posed");
    poser.drag(&poses[4], &mut dragged, progress.whole()).expect("dragged");
    assert!(dragged.iter().zip(&driven).all(|(a, b)| a.distance(*b) < 0.5));
    assert!(poser.drag(&poses[4][1..], &mut dragged, progress.whole()).is_err());
    assert!(poser.joints_of(&own, 5).is_err());
    let bones = character.triangle_bones();
    let mut depths = vec![0; character.skeleton.bones.len()];
    let drawn = |depths: &[i32]| -> Vec<u32> {
        let order = character.draw_order(depths);
        assert_eq!(order.iter().collect::<std::collections::HashSet<_>>().len(), character.mesh.triangles.len());
        let mut regions: Vec<u32> = order.iter().map(|t| bones[*t as usize]).collect();
        regions.dedup();
        regions
    };
    // Regions stay together: outer bones over inner ones, and a raised one over all.
    assert!(drawn(&depths).is_sorted());
    depths[0] = 3;
    assert_eq!(drawn(&depths).last(), Some(&0));
}
