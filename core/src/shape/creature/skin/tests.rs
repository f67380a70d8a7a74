//! Skins of creatures made of capsules, and edits of them.

use std::sync::OnceLock;

use glam::{Vec2, Vec3, vec2};

use super::super::tests::{Scene, distance, scene, scene_of, silhouette, skin_params, strokes};
use super::super::*;
use crate::geometry::TriMesh;
use crate::geometry::manifold::{manifold_defect, pieces};
use crate::job::Progress;

/// The surface without the doubles along seams.
fn welded(mesh: &TriMesh) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let surface = mesh.surface();
    let mut number = vec![u32::MAX; mesh.positions.len()];
    let mut places = Vec::new();
    for (v, &s) in surface.iter().enumerate() {
        if s as usize == v {
            number[v] = places.len() as u32;
            places.push(mesh.positions[v]);
        }
    }
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| number[surface[v as usize] as usize])).collect();
    (places, triangles)
}

fn only_part(model: &RiggedModel) -> &SkinnedPart {
    assert_eq!(model.parts.len(), 1, "one skin");
    &model.parts[0]
}

fn limb_of(model: &RiggedModel, part: &SkinnedPart, v: usize, limb: &str) -> f32 {
    let of = |b: u16| model.bones[usize::from(b)].name.rsplit_once('.').map(|n| n.0) == Some(limb);
    part.bones[v].iter().zip(part.weights[v]).filter(|(b, _)| of(**b)).map(|(_, w)| w).sum()
}

/// The skin of a scene of six frames, which many tests look at.
fn six() -> &'static RiggedModel {
    static MODEL: OnceLock<RiggedModel> = OnceLock::new();
    MODEL.get_or_init(|| scene(6).skin())
}

/// The surface in every frame is one closed manifold without handles, right side out.
fn assert_sphere(model: &RiggedModel) {
    model.validate().expect("a model");
    for f in 0..model.animation.len() {
        let mesh = &model.pose(f)[0];
        let (places, triangles) = welded(mesh);
        assert_eq!(manifold_defect(places.len(), &triangles), None, "frame {f}");
        assert!(pieces(places.len(), &triangles).iter().all(|p| *p == 0), "frame {f} is in pieces");
        assert_eq!(places.len() as i64 - triangles.len() as i64 / 2, 2, "frame {f} has handles");
        assert!(tube::volume(mesh) > 0.0);
    }
}

#[test]
fn the_skin_is_one_closed_manifold_without_handles_in_every_frame() {
    assert_sphere(six());
    let part = only_part(six());
    assert!(part.weights.iter().all(|w| (w.iter().sum::<f32>() - 1.0).abs() < 1e-5));
    assert!(part.mesh.uvs.iter().all(|uv| uv.min_element() > 0.0 && uv.max_element() < 1.0));
    let wanted = skin_params().skin_triangles;
    assert!((wanted / 2..=wanted * 13 / 10).contains(&part.mesh.triangles.len()), "{}", part.mesh.triangles.len());
}

#[test]
fn limbs_that_touch_float_or_cross_make_neither_handles_nor_pieces() {
    let with = |change: &dyn Fn(&mut [Vec<Vec2>; 3])| {
        let strokes = |f: usize| {
            let mut s = strokes(f);
            change(&mut s);
            s
        };
        scene_of(3, strokes, |_| false).skin()
    };
    // Feet together below, thighs apart: a ring in every frame.
    assert_sphere(&with(&|s| {
        s[1] = vec![vec2(90.0, 110.0), vec2(60.0, 165.0), vec2(92.0, 215.0)];
        s[2] = vec![vec2(120.0, 110.0), vec2(150.0, 165.0), vec2(100.0, 215.0)];
    }));
    // A leg that begins away from the body.
    assert_sphere(&with(&|s| s[2].iter_mut().for_each(|p| *p += vec2(20.0, 45.0))));
    // A leg that comes back to the body.
    assert_sphere(&with(&|s| {
        s[1] = vec![vec2(80.0, 110.0), vec2(100.0, 205.0), vec2(190.0, 205.0), vec2(215.0, 120.0)];
    }));
    // Two legs in one place.
    assert_sphere(&with(&|s| s[2] = s[1].clone()));
}

#[test]
fn doubles_on_seams_stay_together_in_every_frame() {
    let model = six();
    let surface = only_part(model).mesh.surface();
    let doubles: Vec<(usize, usize)> =
        surface.iter().enumerate().filter(|(v, s)| **s as usize != *v).map(|(v, s)| (v, *s as usize)).collect();
    assert!(!doubles.is_empty());
    for f in 0..5 {
        let places = &model.pose(f)[0].positions;
        let bits = |v: usize| places[v].to_array().map(f32::to_bits);
        assert!(doubles.iter().all(|(a, b)| bits(*a) == bits(*b)));
    }
}

#[test]
fn silhouettes_of_all_frames_are_met() {
    let ear = |p: Vec2| distance(p, &[vec2(200.0, 90.0), vec2(208.0, 62.0)]) < 6.0;
    let scene = scene_of(6, strokes, ear);
    let model = scene.skin();
    let tubes = scene.reconstruct(&CreatureParams { surface: Surface::Tubes, ..skin_params() });
    let tubes = tubes.expect("tubes");
    let iou: Vec<f64> = (0..6).map(|f| silhouette(&model, f).iou(&scene.masks[f])).collect();
    let before: f64 = (0..6).map(|f| silhouette(&tubes, f).iou(&scene.masks[f])).sum();
    assert!(iou[0] > 0.985, "{iou:?}");
    assert!(iou.iter().sum::<f64>() > before, "{iou:?} against {before}");
}

#[test]
fn legs_stay_apart_and_follow_their_own_bones() {
    // The legs cross in the rest frame.
    let crossed = |f: usize| strokes(f + 2);
    let scene = scene_of(9, crossed, |_| false);
    let model = scene.skin();
    let part = only_part(&model);
    let foot = |leg: usize| crossed(0)[leg][2];
    for (leg, name, other) in [(1, "near", "far"), (2, "far", "near")] {
        let mut met = 0;
        for (v, p) in part.mesh.positions.iter().enumerate() {
            let (own, twin) = (limb_of(&model, part, v, name), limb_of(&model, part, v, other));
            assert!(own == 0.0 || twin == 0.0, "vertex {v} is moved by both legs");
            let at = vec2(p.x, model.size.1 as f32 - p.y);
            if at.distance(foot(leg)) < 12.0 && (p.z > 0.0) == (leg == 1) {
                assert!(own > 0.99, "a foot's vertex at {p} follows {own}");
                met += 1;
            }
        }
        assert!(met > 10, "{name} has no foot");
    }
    // Weights change gently along edges.
    let steep = part.mesh.triangles.iter().filter(|t| {
        let share = t.map(|v| limb_of(&model, part, v as usize, "body"));
        share.iter().copied().fold(0.0, f32::max) - share.iter().copied().fold(1.0, f32::min) > 0.5
    });
    assert!(steep.count() * 200 < part.mesh.triangles.len());
}

#[test]
fn triangles_are_even() {
    let part = only_part(six());
    let mut lengths = Vec::new();
    let mut slivers = 0;
    for t in &part.mesh.triangles {
        let p = t.map(|v| part.mesh.positions[v as usize]);
        let sides = [0, 1, 2].map(|k| p[k].distance(p[(k + 1) % 3]));
        let longest = sides.iter().copied().fold(0.0, f32::max);
        let height = (p[1] - p[0]).cross(p[2] - p[0]).length() / longest.max(1e-6);
        slivers += usize::from(height < 0.15 * longest);
        lengths.extend(sides);
    }
    lengths.sort_by(f32::total_cmp);
    let (low, high) = (lengths[lengths.len() / 20], lengths[lengths.len() * 19 / 20]);
    assert!(high / low < 4.0, "edges from {low} to {high}");
    assert!(slivers * 50 < part.mesh.triangles.len(), "{slivers} slivers of {}", part.mesh.triangles.len());
}

#[test]
fn threads_do_not_change_a_bit_of_the_skin() {
    let scene = scene(2);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| scene.skin())
    };
    assert!(on(1) == on(4));
}

fn sound(scene: &Scene) -> RiggedModel {
    let model = scene.skin();
    model.validate().expect("a model");
    for f in 0..model.animation.len() {
        assert!(model.pose(f)[0].positions.iter().all(|p| p.is_finite()));
    }
    model
}

#[test]
fn poor_input_gives_a_sound_skin() {
    let mut still = scene(2);
    still.motion.tracks[1].frames.iter_mut().for_each(|f| f.points.fill(vec2(80.0, 110.0)));
    sound(&still);
    let mut empty = scene(2);
    empty.masks[0] = Mask::new(300, 240);
    sound(&empty);
    let mut outside = scene(2);
    for f in &mut outside.motion.tracks[1].frames {
        f.points.iter_mut().for_each(|p| *p += vec2(-400.0, 300.0));
    }
    sound(&outside);
    let mut one = scene(2);
    one.rig.limbs.truncate(1);
    one.rig.keyframes[0].strokes.truncate(1);
    one.motion.tracks.truncate(1);
    let (places, triangles) = welded(&only_part(&sound(&one)).mesh);
    assert_eq!(manifold_defect(places.len(), &triangles), None);
}

fn edited(model: &RiggedModel, frame: usize) -> EditedMesh {
    let mesh = model.pose(frame).remove(0);
    EditedMesh { positions: mesh.positions, triangles: mesh.triangles }
}

fn take(model: &mut RiggedModel, frame: usize, edit: &EditedMesh) -> Result<EditKind> {
    apply_edit(model, frame, edit, Progress::new().whole())
}

#[test]
fn an_edit_of_one_frame_plays_in_every_frame() {
    let original = six().clone();
    let mut model = original.clone();
    let mut edit = edited(&original, 3);
    assert_eq!(take(&mut model, 3, &edit).expect("no change"), EditKind::Displaced(0));
    assert!(model == original);
    // A hump on the back.
    let hump = |p: &Vec3| p.x > 130.0 && p.x < 170.0 && p.y > 145.0;
    let chosen: Vec<usize> = (0..edit.positions.len()).filter(|v| hump(&edit.positions[*v])).collect();
    chosen.iter().for_each(|v| edit.positions[*v].y += 10.0);
    assert_eq!(take(&mut model, 3, &edit).expect("an edit"), EditKind::Displaced(chosen.len()));
    for f in 0..6 {
        let (now, before) = (&model.pose(f)[0], &original.pose(f)[0]);
        for v in 0..now.positions.len() {
            let rise = (now.positions[v] - before.positions[v]).y;
            let wanted = if chosen.contains(&v) { 10.0 } else { 0.0 };
            assert!((rise - wanted).abs() < 2.0, "frame {f}: vertex {v} rose by {rise}");
        }
        let (places, triangles) = welded(now);
        assert_eq!(manifold_defect(places.len(), &triangles), None);
    }
}

#[test]
fn another_topology_is_bound_anew() {
    let original = six().clone();
    let mut model = original.clone();
    let (positions, mut triangles) = welded(&original.pose(2)[0]);
    // A triangle less: then it is not the same mesh any more; the doubles are gone as well.
    triangles.truncate(triangles.len() - 1);
    let edit = EditedMesh { positions, triangles };
    assert_eq!(take(&mut model, 2, &edit).expect("an edit"), EditKind::BoundAnew);
    model.validate().expect("a model");
    for f in 0..6 {
        let old = silhouette(&original, f);
        assert!(silhouette(&model, f).iou(&old) > 0.98, "frame {f}");
    }
    let colour = |m: &RiggedModel| {
        let t = &m.parts[0].texture;
        let uvs = &m.parts[0].mesh.uvs;
        let sum: f32 = uvs
            .iter()
            .map(|uv| {
                let (x, y) = ((uv.x * t.width() as f32) as u32, (uv.y * t.height() as f32) as u32);
                f32::from(t.get_pixel(x.min(t.width() - 1), y.min(t.height() - 1)).0[0])
            })
            .sum();
        sum / uvs.len() as f32
    };
    assert!((colour(&model) - colour(&original)).abs() < 6.0, "{} {}", colour(&model), colour(&original));
}

#[test]
fn edits_that_cannot_be_are_named_and_change_nothing() {
    let original = six().clone();
    let mut model = original.clone();
    let good = edited(&original, 1);
    let with = |change: &dyn Fn(&mut EditedMesh)| {
        let mut edit = good.clone();
        change(&mut edit);
        edit
    };
    let cases: [(&str, EditedMesh); 6] = [
        ("empty", EditedMesh::default()),
        ("no number", with(&|e| e.positions[5].y = f32::NAN)),
        ("no number", with(&|e| e.positions[5].y = f32::INFINITY)),
        ("not there", with(&|e| e.triangles[0][1] = u32::MAX)),
        ("beside the creature", with(&|e| e.positions.iter_mut().for_each(|p| p.x += 5000.0))),
        ("times as large", with(&|e| e.positions.iter_mut().for_each(|p| *p *= 0.01))),
    ];
    for (problem, edit) in cases {
        let error = take(&mut model, 1, &edit).expect_err(problem).to_string();
        assert!(error.contains(problem), "{error}");
        assert!(model == original);
    }
    assert!(take(&mut model, 6, &good).expect_err("no frame").to_string().contains("frame 6"));
    let progress = Progress::new();
    progress.cancel();
    assert!(matches!(apply_edit(&mut model, 1, &good, progress.whole()), Err(Error::Cancelled)));
    for text in ["v 1 2\n", "v a b c\n", "v 1 2 inf\n", "v 0 0 0\nf 1 2 3\n", "f 1 2\n", "v 0 0 0\nf -1 -2 -3\n"] {
        assert!(EditedMesh::from_obj(text).is_err(), "{text}");
    }
    let quad = EditedMesh::from_obj("# x\no a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1 1 1\nf 1/1 2//2 3/3/3 -1\n")
        .expect("a quad");
    assert_eq!(quad.triangles, [[0, 1, 2], [0, 2, 3]]);
}
