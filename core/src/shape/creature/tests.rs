//! Creatures made of capsules, whose true shape is known.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, vec2};
use image::{Rgb, RgbImage};

use super::*;
use crate::geometry::TriMesh;
use crate::job::Progress;
use crate::motion::{Track, TrackFrame, TrackKind};
use crate::raster::{Rasterizer, Surface, clip_view};
use crate::rig::{Facing, KeyFrame, Limb, Stroke};

const WIDTH: usize = 300;
const HEIGHT: usize = 240;
const BODY: f32 = 26.0;
const LEG: f32 = 9.0;

fn tubes() -> CreatureParams {
    CreatureParams { surface: super::Surface::Tubes, ..CreatureParams::default() }
}

/// A skin of few triangles with the colours of one frame, which is enough for its shape.
pub(super) fn skin_params() -> CreatureParams {
    CreatureParams { skin_triangles: 7000, texture_views: 1, ..CreatureParams::default() }
}

/// A body with two legs that swing against each other, in colours that tell places apart.
pub(super) struct Scene {
    pub clip: Clip,
    pub rig: Rig,
    pub motion: Motion,
    pub masks: Vec<Mask>,
}

pub(super) fn strokes(frame: usize) -> [Vec<Vec2>; 3] {
    let swing = 0.5 * (frame as f32 * 0.9).cos();
    let leg = |angle: f32| {
        let foot = vec2(80.0, 110.0) + 95.0 * vec2(angle.sin(), angle.cos());
        vec![vec2(80.0, 110.0), vec2(80.0, 110.0).lerp(foot, 0.5), foot]
    };
    [vec![vec2(80.0, 110.0), vec2(150.0, 108.0), vec2(230.0, 110.0)], leg(swing), leg(-swing)]
}

pub(super) fn distance(p: Vec2, line: &[Vec2]) -> f32 {
    let to = |a: Vec2, b: Vec2| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-6)).clamp(0.0, 1.0);
        p.distance(a.lerp(b, t))
    };
    line.windows(2).map(|s| to(s[0], s[1])).fold(f32::INFINITY, f32::min)
}

pub(super) fn scene_of(
    frames: usize,
    strokes: impl Fn(usize) -> [Vec<Vec2>; 3],
    extra: impl Fn(Vec2) -> bool,
) -> Scene {
    let labels = [("body", Side::Mid), ("near", Side::Near), ("far", Side::Far)];
    let limbs = labels.iter().map(|(l, s)| Limb { label: (*l).into(), side: Some(*s) }).collect();
    let drawn = strokes(0).into_iter().enumerate().map(|(limb, points)| Stroke { limb, points, facing: None });
    let key = KeyFrame { frame: 0, strokes: drawn.collect(), ..KeyFrame::default() };
    let rig = Rig { size: (WIDTH as u32, HEIGHT as u32), limbs, keyframes: vec![key] };
    let track = |l: usize| Track {
        name: labels[l].0.into(),
        kind: TrackKind::Stroke,
        frames: (0..frames).map(|f| TrackFrame::certain(strokes(f)[l].clone())).collect(),
    };
    let motion = Motion { size: rig.size, fps: 24.0, frames, tracks: (0..3).map(track).collect(), bones: Vec::new() };
    let mask = |f: usize| {
        let s = strokes(f);
        Mask::from_fn(WIDTH, HEIGHT, |x, y| {
            let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
            distance(p, &s[0]) < BODY || distance(p, &s[1]) < LEG || distance(p, &s[2]) < LEG || extra(p)
        })
    };
    let masks: Vec<Mask> = (0..frames).map(mask).collect();
    let picture = |mask: &Mask| {
        RgbImage::from_fn(WIDTH as u32, HEIGHT as u32, |x, y| {
            if mask.get(x as usize, y as usize) {
                Rgb([100 + (x / 2) as u8, 100 + (y / 2) as u8, 150])
            } else {
                Rgb([0, 0, 0])
            }
        })
    };
    let clip = Clip::from_frames(masks.iter().map(picture).collect(), 24.0).expect("frames of one size");
    Scene { clip, rig, motion, masks }
}

pub(super) fn scene(frames: usize) -> Scene {
    scene_of(frames, strokes, |_| false)
}

impl Scene {
    pub(super) fn reconstruct(&self, params: &CreatureParams) -> Result<RiggedModel> {
        let progress = Progress::new();
        reconstruct(&self.clip, &self.rig, &self.motion, &self.masks, params, progress.whole()).map(|c| c.model)
    }

    fn creature(&self) -> Creature {
        let progress = Progress::new();
        reconstruct(&self.clip, &self.rig, &self.motion, &self.masks, &tubes(), progress.whole()).expect("a creature")
    }

    pub(super) fn skin(&self) -> RiggedModel {
        self.reconstruct(&skin_params()).expect("a creature")
    }

    pub(super) fn model(&self) -> RiggedModel {
        self.reconstruct(&tubes()).expect("a creature")
    }
}

pub(super) fn silhouette(model: &RiggedModel, frame: usize) -> Mask {
    let mut picture = Rasterizer::new(model.size.0, model.size.1);
    for mesh in model.pose(frame) {
        picture.draw(&mesh, &clip_view(model.size.1), Surface::Bare, 0);
    }
    Mask::from_fn(WIDTH, HEIGHT, |x, y| picture.id.get(x, y) == 0)
}

fn part<'a>(model: &'a RiggedModel, meshes: &'a [TriMesh], name: &str) -> &'a TriMesh {
    &meshes[model.parts.iter().position(|p| p.name == name).expect("the part")]
}

fn extent(mesh: &TriMesh, keep: impl Fn(&Vec3) -> bool, of: impl Fn(&Vec3) -> f32) -> f32 {
    let values = || mesh.positions.iter().filter(|p| keep(p)).map(&of);
    values().fold(f32::NEG_INFINITY, f32::max) - values().fold(f32::INFINITY, f32::min)
}

/// Every directed edge between places has exactly as many partners in the other direction, and the volume is positive.
fn assert_closed(mesh: &TriMesh, name: &str) {
    let mut edges: BTreeMap<[[u32; 3]; 2], i32> = BTreeMap::new();
    let key = |i: u32| mesh.positions[i as usize].to_array().map(f32::to_bits);
    for t in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (key(t[k]), key(t[(k + 1) % 3]));
            if a != b {
                *edges.entry([a, b]).or_default() += 1;
                *edges.entry([b, a]).or_default() -= 1;
            }
        }
    }
    assert!(edges.values().all(|&n| n == 0), "{name} is open");
    assert!(tube::volume(mesh) > 0.0, "{name} is inside out");
}

#[test]
fn widths_and_places_of_capsules_come_back() {
    let scene = scene(8);
    let model = scene.model();
    let rest = model.pose(0);
    let body = extent(part(&model, &rest, "body"), |p| (p.x - 170.0).abs() < 6.0, |p| p.y);
    assert!((body - 2.0 * BODY).abs() < 3.0, "{body}");
    let foot = strokes(0)[1][2];
    let low = |p: &Vec3| (p.y - (HEIGHT as f32 - foot.y) - 20.0).abs() < 4.0;
    let leg = extent(part(&model, &rest, "near"), low, |p| p.x);
    // Measured level while the leg leans by half a radian.
    assert!((leg - 2.0 * LEG / 0.5f32.cos()).abs() < 6.0, "{leg}");
    for f in 0..8 {
        let iou = silhouette(&model, f).iou(&scene.masks[f]);
        assert!(iou > 0.93, "frame {f}: {iou}");
    }
    let deep = |name: &str| {
        let mesh = part(&model, &rest, name);
        mesh.positions.iter().map(|p| p.z).sum::<f32>() / mesh.positions.len() as f32
    };
    assert!(deep("near") > 5.0 && deep("far") < -5.0, "near and far legs stand on their own sides");
}

#[test]
fn parts_are_closed_and_bound_to_real_bones_in_every_frame() {
    let scene = scene_of(5, strokes, |p| distance(p, &[vec2(215.0, 90.0), vec2(225.0, 66.0)]) < 6.0);
    let model = scene.model();
    for part in &model.parts {
        assert_closed(&part.mesh, &part.name);
        let n = part.mesh.positions.len();
        assert!(part.bones.len() == n && part.weights.len() == n && part.mesh.uvs.len() == n);
        assert!(part.bones.iter().flatten().all(|&b| usize::from(b) < model.bones.len()));
        assert!(part.weights.iter().all(|w| (w.iter().sum::<f32>() - 1.0).abs() < 1e-5 && w.iter().all(|v| *v >= 0.0)));
        assert!(part.mesh.uvs.iter().all(|uv| uv.min_element() >= 0.0 && uv.max_element() <= 1.0));
    }
    for frame in 0..5 {
        for (mesh, part) in model.pose(frame).iter().zip(&model.parts) {
            assert_closed(mesh, &part.name);
            assert!(mesh.positions.iter().all(|p| p.is_finite()));
        }
    }
    assert!(model.bones.iter().enumerate().all(|(i, b)| b.parent.is_none_or(|p| p < i)));
    let roots = model.bones.iter().filter(|b| b.parent.is_none()).count();
    assert_eq!(roots, 1, "joined strokes make one hierarchy");
    assert_eq!(model.rest, model.animation[0]);
}

#[test]
fn an_ear_without_a_stroke_is_covered() {
    let ear = |p: Vec2| distance(p, &[vec2(200.0, 90.0), vec2(208.0, 62.0)]) < 6.0;
    let scene = scene_of(4, strokes, ear);
    let place = (207, 66);
    let with = scene.model();
    let without = scene.reconstruct(&CreatureParams { fill_silhouette: false, ..tubes() });
    for f in 0..4 {
        assert!(silhouette(&with, f).get(place.0, place.1), "frame {f}");
    }
    assert!(!silhouette(&without.expect("a creature"), 0).get(place.0, place.1));
}

#[test]
fn colours_are_those_of_the_frame_and_never_black() {
    let scene = scene(3);
    let model = scene.model();
    let mut picture = Rasterizer::new(model.size.0, model.size.1);
    for (i, (mesh, part)) in model.pose(0).iter().zip(&model.parts).enumerate() {
        picture.draw(mesh, &clip_view(model.size.1), Surface::Flat(&part.texture), i as u16);
    }
    let frame = scene.clip.frame(0).expect("frame 0");
    let (mut wrong, mut all) = (0, 0);
    for (x, y, p) in picture.color.enumerate_pixels() {
        if picture.id.get(x as usize, y as usize) != Rasterizer::NOTHING {
            let near = (0..3).all(|c| p.0[c].abs_diff(frame.rgb.get_pixel(x, y).0[c]) <= 6);
            (wrong, all) = (wrong + usize::from(!near), all + 1);
        }
    }
    assert!(wrong * 8 < all, "{wrong} of {all} pixels have another colour");
    for part in &model.parts {
        let cylinder_only = part.texture.pixels().filter(|p| p.0[2] > 140).count();
        assert!(cylinder_only * 3 > part.texture.pixels().count(), "{} is mostly empty", part.name);
        let dark = |uv: &Vec2| {
            let (x, y) = (uv.x * part.texture.width() as f32, uv.y * part.texture.height() as f32);
            let p = part
                .texture
                .get_pixel((x as u32).min(part.texture.width() - 1), (y as u32).min(part.texture.height() - 1));
            p.0.iter().all(|c| *c < 90)
        };
        assert!(!part.mesh.uvs.iter().any(dark), "{} has a black hole", part.name);
    }
}

#[test]
fn a_foreshortened_leg_keeps_its_length_and_its_facing() {
    let shrinking = |f: usize| {
        let mut s = strokes(0);
        let keep = if f == 5 { 0.3 } else { 1.0 };
        s[1] = s[1].iter().map(|p| s[1][0].lerp(*p, keep)).collect();
        s
    };
    let mut scene = scene_of(8, shrinking, |_| false);
    let depth = |model: &RiggedModel, f: usize| {
        let chain: Vec<usize> = (0..model.bones.len()).filter(|&b| model.bones[b].name.starts_with("near.")).collect();
        let world = model.world(&model.animation[f]);
        let at: Vec<Vec3> = chain.iter().map(|&b| world[b].transform_point3(Vec3::ZERO)).collect();
        let length: f32 = at.windows(2).map(|p| p[0].distance(p[1])).sum();
        (at[at.len() - 1].z - at[0].z, length)
    };
    let params = CreatureParams { settling_rounds: 0, ..tubes() };
    let toward = depth(&scene.reconstruct(&params).expect("a creature"), 5);
    scene.rig.keyframes[0].strokes[1].facing = Some(Facing::Away);
    let model = scene.reconstruct(&params).expect("a creature");
    let (away, whole) = (depth(&model, 5), depth(&model, 0));
    assert!(toward.0 > 60.0 && away.0 < -40.0, "{toward:?} {away:?}");
    assert!((away.1 / whole.1 - 1.0).abs() < 0.15, "{away:?} {whole:?}");
}

#[test]
fn a_track_beside_its_limb_is_settled_into_the_mask() {
    let mut scene = scene(8);
    for f in 1..8 {
        for p in &mut scene.motion.tracks[1].frames[f].points[1..] {
            p.x += 4.0;
        }
    }
    let mean = |rounds| {
        let model = scene.reconstruct(&CreatureParams { settling_rounds: rounds, ..tubes() }).expect("a creature");
        (1..8).map(|f| silhouette(&model, f).iou(&scene.masks[f])).sum::<f64>() / 7.0
    };
    let (tracked, settled) = (mean(0), mean(2));
    assert!(settled > tracked + 0.005, "{tracked} {settled}");
}

#[test]
fn threads_do_not_change_a_bit() {
    let scene = scene(6);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| scene.model())
    };
    assert!(on(1) == on(2));
}

#[test]
fn poor_input_is_graceful() {
    let one = scene(1);
    assert_closed(&one.model().parts[0].mesh, "one frame");
    let mut empty = scene(3);
    empty.masks = vec![Mask::new(WIDTH, HEIGHT); 3];
    let model = empty.model();
    assert!(model.parts.iter().all(|p| p.mesh.positions.iter().all(|v| v.is_finite())));
    let mut hidden = scene(3);
    hidden.motion.tracks[2].frames.iter_mut().for_each(|f| f.visible.fill(false));
    assert_eq!(hidden.model().parts.len(), 3);
    let mut outside = scene(3);
    for f in &mut outside.motion.tracks[1].frames {
        f.points.iter_mut().for_each(|p| *p += vec2(-400.0, 300.0));
    }
    assert!(outside.model().parts[1].mesh.positions.iter().all(|v| v.is_finite()));
    let mut still = scene(2);
    still.motion.tracks[1].frames.iter_mut().for_each(|f| f.points.fill(vec2(80.0, 110.0)));
    assert!(still.model().parts[1].mesh.positions.iter().all(|v| v.is_finite()));
}

#[test]
fn mistakes_are_named_and_a_cancel_is_heard() {
    let mut wrong = scene(3);
    wrong.masks.pop();
    assert!(wrong.reconstruct(&tubes()).expect_err("two masks").to_string().contains("masks"));
    let mut wrong = scene(3);
    wrong.masks[1] = Mask::new(5, 5);
    assert!(wrong.reconstruct(&tubes()).expect_err("a small mask").to_string().contains("mask 1"));
    let mut wrong = scene(3);
    wrong.motion.tracks.remove(1);
    assert!(wrong.reconstruct(&tubes()).expect_err("no track").to_string().contains("`near`"));
    let scene = scene(3);
    let progress = Progress::new();
    progress.cancel();
    let params = tubes();
    let result = reconstruct(&scene.clip, &scene.rig, &scene.motion, &scene.masks, &params, progress.whole());
    assert!(matches!(result, Err(Error::Cancelled)));
}

#[test]
fn its_own_strokes_bring_a_creature_back() {
    let scene = scene(6);
    let creature = scene.creature();
    let params = DriveParams { pose: PoseParams::default(), ..DriveParams::default() };
    for motion in [&scene.motion, &creature.motion()] {
        let driven = creature.driven(motion, None, &params, Progress::new().whole()).expect("driven");
        for f in 0..6 {
            let iou = |c: &Creature| silhouette(&c.model, f).iou(&scene.masks[f]);
            let (tracked, posed) = (iou(&creature), iou(&driven));
            assert!((tracked - posed).abs() < 0.01, "frame {f}: {posed} is not {tracked}");
        }
    }
}

#[test]
fn a_leg_goes_in_front_where_a_key_says_so() {
    let mut scene = scene(9);
    let depth = |creature: &Creature, label: &str, frame: usize| {
        let limb = creature.limbs.iter().find(|l| l.label == label).expect("the limb");
        let world = creature.model.world(&creature.model.animation[frame]);
        world[limb.first_bone + limb.bones - 1].w_axis.z
    };
    let plain = scene.creature();
    let mark = |limb, depth, bend| crate::rig::LimbDepth { limb, depth, bend };
    let keyed = |frame: usize, depths| KeyFrame { frame, depths, ..KeyFrame::default() };
    // Keys hold until the next one: the far leg is in front on frame 4 only, and the near one bends on frame 8.
    scene.rig.keyframes.push(keyed(4, vec![mark(2, Some(60.0), None)]));
    scene.rig.keyframes.push(keyed(8, vec![mark(2, Some(0.0), None), mark(1, None, Some(30.0))]));
    let creature = scene.creature();
    for (frame, more) in [(0, 0.0), (2, 30.0), (4, 60.0), (6, 30.0), (8, 0.0)] {
        let moved = depth(&creature, "far", frame) - depth(&plain, "far", frame);
        assert!((moved - more).abs() < 0.5, "frame {frame}: {moved} is not {more}");
    }
    assert!(depth(&creature, "far", 4) > depth(&creature, "near", 4), "in front");
    let bent = |frame: usize| depth(&creature, "near", frame) - depth(&plain, "near", frame);
    assert!(bent(0).abs() < 1e-3 && (bent(8) - 30.0).abs() < 0.5, "{} {}", bent(0), bent(8));
}
