use std::f32::consts::TAU;

use glam::{Quat, Vec2, Vec3, vec2, vec3};
use image::{Rgb, RgbImage, Rgba, RgbaImage};

use super::*;
use crate::geometry::TriMesh;
use crate::job::Progress;
use crate::raster::{Rasterizer, Surface, clip_view};
use crate::shape::{Bone, SkinnedPart, Transform};

const SIZE: (u32, u32) = (200, 120);
const AROUND: usize = 32;
const ALONG: usize = 16;
const GREEN: [u8; 3] = [20, 200, 20];

/// A tube along x on four bones, whose texture runs around it from the top over the viewer's side.
fn tube(name: &str, first_bone: u16, from: Vec3, length: f32, radius: f32) -> SkinnedPart {
    let mut mesh = TriMesh::default();
    let (mut bones, mut weights) = (Vec::new(), Vec::new());
    for a in 0..=ALONG {
        for r in 0..=AROUND {
            let angle = TAU * (r % AROUND) as f32 / AROUND as f32;
            let normal = vec3(0.0, angle.cos(), angle.sin());
            let share = a as f32 / ALONG as f32;
            mesh.positions.push(from + vec3(share * length, 0.0, 0.0) + normal * radius);
            mesh.normals.push(normal);
            mesh.uvs.push(vec2(r as f32 / AROUND as f32, share));
            let k = ((share * 3.0) as u16).min(2);
            let t = share * 3.0 - f32::from(k);
            bones.push([first_bone + k, first_bone + k + 1, 0, 0]);
            weights.push([1.0 - t, t, 0.0, 0.0]);
        }
    }
    let at = |a: usize, r: usize| (a * (AROUND + 1) + r) as u32;
    for a in 0..ALONG {
        for r in 0..AROUND {
            mesh.triangles.push([at(a, r), at(a, r + 1), at(a + 1, r + 1)]);
            mesh.triangles.push([at(a, r), at(a + 1, r + 1), at(a + 1, r)]);
        }
    }
    SkinnedPart { name: name.into(), mesh, bones, weights, texture: RgbImage::new(2, 2) }
}

/// A creature of tubes along x: name, start, length, radius. In frame f it has turned around its own axis by
/// `turns[f]` and moved by 3 f pixels.
fn creature(tubes: &[(&str, Vec3, f32, f32)], turns: &[f32]) -> RiggedModel {
    let (mut bones, mut rest, mut parts) = (Vec::new(), Vec::new(), Vec::new());
    for (name, from, length, radius) in tubes {
        parts.push(tube(name, bones.len() as u16, *from, *length, *radius));
        for k in 0..4 {
            let parent = (k > 0).then(|| bones.len() - 1);
            bones.push(Bone { name: format!("{name}.{k}"), parent });
            let translation = if k == 0 { *from } else { vec3(length / 3.0, 0.0, 0.0) };
            rest.push(Transform { translation, rotation: Quat::IDENTITY });
        }
    }
    let pose = |f: usize| {
        let mut pose: Vec<Transform> = rest.clone();
        for (t, _) in pose.iter_mut().zip(&bones).filter(|(_, b): &(_, &Bone)| b.parent.is_none()) {
            t.rotation = Quat::from_rotation_x(turns[f]);
            t.translation.x += 3.0 * f as f32;
        }
        pose
    };
    let animation = (0..turns.len()).map(pose).collect();
    RiggedModel { size: SIZE, fps: 25.0, bones, rest, animation, parts }
}

fn paint_all(model: &mut RiggedModel, color: impl Fn(usize, Vec2) -> [u8; 3]) {
    for (p, part) in model.parts.iter_mut().enumerate() {
        part.texture =
            RgbImage::from_fn(128, 112, |x, y| Rgb(color(p, vec2((x as f32 + 0.5) / 128.0, (y as f32 + 0.5) / 112.0))));
    }
}

/// Soft stripes around and along.
fn stripes(_: usize, uv: Vec2) -> [u8; 3] {
    let wave = |t: f32| (128.0 + 70.0 * (TAU * t).sin()) as u8;
    [wave(uv.x + uv.y), wave(3.0 * uv.y), wave(2.0 * uv.x)]
}

/// The clip of the model before green, and its masks.
fn film(model: &RiggedModel, gain: impl Fn(usize) -> f32) -> (Clip, Vec<Mask>) {
    let (w, h) = model.size;
    let (mut frames, mut masks) = (Vec::new(), Vec::new());
    for f in 0..model.animation.len() {
        let mut picture = Rasterizer::new(w, h);
        for (i, (mesh, part)) in model.pose(f).iter().zip(&model.parts).enumerate() {
            picture.draw(mesh, &clip_view(h), Surface::Flat(&part.texture), i as u16);
        }
        frames.push(RgbImage::from_fn(w, h, |x, y| match picture.color.get_pixel(x, y).0 {
            [.., 0] => Rgb(GREEN),
            [r, g, b, _] => Rgb([r, g, b].map(|c| (f32::from(c) * gain(f)).min(255.0) as u8)),
        }));
        masks.push(Mask::from_fn(w as usize, h as usize, |x, y| picture.id.get(x, y) != Rasterizer::NOTHING));
    }
    (Clip::from_frames(frames, 25.0).expect("frames"), masks)
}

fn grey(model: &RiggedModel) -> RiggedModel {
    let mut out = model.clone();
    paint_all(&mut out, |_, _| [128; 3]);
    out
}

/// Bakes at the size that the textures have.
fn baked(model: &RiggedModel, clip: &Clip, masks: &[Mask], params: BakeParams) -> RiggedModel {
    let mut out = grey(model);
    let params = BakeParams { density: 0.0, ..params };
    bake(&mut out, &Footage { clip, masks, motion: None }, &params, Progress::new().whole()).expect("baked");
    out
}

/// The mean difference in levels of a part's texture from what `truth` says, over texels whose shares satisfy `of`.
fn difference(texture: &RgbImage, of: impl Fn(Vec2) -> bool, truth: impl Fn(Vec2) -> [u8; 3]) -> f32 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (x, y, p) in texture.enumerate_pixels() {
        let uv = vec2((x as f32 + 0.5) / texture.width() as f32, (y as f32 + 0.5) / texture.height() as f32);
        if of(uv) {
            let t = truth(uv);
            sum += (0..3).map(|c| f32::from(p.0[c].abs_diff(t[c]))).sum::<f32>() / 3.0;
            count += 1.0;
        }
    }
    sum / count
}

/// Texels that face the viewer by half at least, away from the tube's open ends.
fn front(uv: Vec2) -> bool {
    (uv.x - 0.25).abs() < 0.16 && (uv.y - 0.5).abs() < 0.45
}

fn back(uv: Vec2) -> bool {
    front(vec2(1.0 - uv.x, uv.y))
}

fn body(turns: &[f32]) -> RiggedModel {
    let mut model = creature(&[("body", vec3(30.0, 60.0, 0.0), 110.0, 24.0)], turns);
    paint_all(&mut model, stripes);
    model
}

#[test]
fn what_the_frames_show_comes_back() {
    let model = body(&[0.0, 0.5, -0.5, 0.9, -0.9]);
    let (clip, masks) = film(&model, |_| 1.0);
    let out = baked(&model, &clip, &masks, BakeParams::default());
    let seen = difference(&out.parts[0].texture, front, |uv| stripes(0, uv));
    assert!(seen < 3.0, "{seen}");
    // The top faces up in the key frame, and the viewer in a turned one.
    let top = |uv: Vec2| !(0.04..0.96).contains(&uv.x) && (uv.y - 0.5).abs() < 0.4;
    let turned = difference(&out.parts[0].texture, top, |uv| stripes(0, uv));
    assert!(turned < 10.0, "{turned}");
    let alone = baked(&model, &clip, &masks, BakeParams { frames: (0, 0), ..BakeParams::default() });
    assert!(difference(&alone.parts[0].texture, top, |uv| stripes(0, uv)) > 1.5 * turned);
}

#[test]
fn the_side_turned_away_mirrors_the_one_that_is_seen() {
    let model = body(&[0.0, 0.0]);
    let (clip, masks) = film(&model, |_| 1.0);
    let out = baked(&model, &clip, &masks, BakeParams::default());
    let mirrored = difference(&out.parts[0].texture, back, |uv| stripes(0, vec2(1.0 - uv.x, uv.y)));
    assert!(mirrored < 5.0, "{mirrored}");
}

#[test]
fn a_hidden_limb_looks_like_its_twin_and_else_like_its_surroundings() {
    let tubes = [
        ("near", vec3(30.0, 60.0, 30.0), 100.0, 14.0),
        ("far", vec3(30.0, 60.0, -30.0), 100.0, 12.0),
        ("body", vec3(30.0, 100.0, 0.0), 100.0, 10.0),
    ];
    let mut model = creature(&tubes, &[0.0, 0.0]);
    let (blue, red) = ([40, 60, 200], [200, 40, 40]);
    paint_all(&mut model, |p, _| if p == 2 { red } else { blue });
    let (clip, masks) = film(&model, |_| 1.0);
    let twins = vec![("near".to_owned(), "far".to_owned())];
    let with = baked(&model, &clip, &masks, BakeParams { twins, ..BakeParams::default() });
    assert!(difference(&with.parts[1].texture, |_| true, |_| blue) < 2.0);
    let without = baked(&model, &clip, &masks, BakeParams { borrow: false, ..BakeParams::default() });
    let filled = &without.parts[1].texture;
    assert!(difference(filled, |_| true, |_| blue) > 2.0, "the surroundings are not all blue");
    assert!(difference(filled, |_| true, |_| [128; 3]) > 20.0, "something known is better than grey");
}

#[test]
fn frames_of_another_exposure_leave_no_seam() {
    let model = body(&[0.0, 0.0, 0.0]);
    let (clip, mut masks) = film(&model, |f| if f == 0 { 1.0 } else { 1.2 });
    // The key frame shows the left two thirds only.
    masks[0] = Mask::from_fn(SIZE.0 as usize, SIZE.1 as usize, |x, y| x < 103 && masks[0].get(x, y));
    let out = baked(&model, &clip, &masks, BakeParams::default());
    let right = |uv: Vec2| front(uv) && uv.y > 0.75;
    let off = difference(&out.parts[0].texture, right, |uv| stripes(0, uv));
    assert!(off < 5.0, "{off}");
}

#[test]
fn a_frame_that_is_off_does_not_show() {
    let mut model = body(&[0.0; 5]);
    let (clip, mut masks) = film(&model, |_| 1.0);
    masks[0] = Mask::from_fn(SIZE.0 as usize, SIZE.1 as usize, |x, y| x < 100 && masks[0].get(x, y));
    // In one frame the model stands 20 pixels beside the picture.
    model.animation[3][0].translation.x += 20.0;
    let out = baked(&model, &clip, &masks, BakeParams::default());
    let off = difference(&out.parts[0].texture, front, |uv| stripes(0, uv));
    assert!(off < 4.0, "{off}");
}

#[test]
fn threads_do_not_change_a_bit() {
    let model = body(&[0.0, 0.6, -0.6]);
    let (clip, masks) = film(&model, |_| 1.0);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| baked(&model, &clip, &masks, BakeParams::default()))
    };
    assert!(on(1) == on(3));
}

#[test]
fn the_size_follows_the_clip_and_its_bound() {
    let mut model = body(&[0.0]);
    let (clip, masks) = film(&model, |_| 1.0);
    let footage = Footage { clip: &clip, masks: &masks, motion: None };
    let mut size = |density, max_side| {
        let params = BakeParams { density, max_side, ..BakeParams::default() };
        bake(&mut model, &footage, &params, Progress::new().whole()).expect("baked");
        model.parts[0].texture.dimensions()
    };
    let (w, h) = size(1.0, 2048);
    // The surface is 150 by 110 pixels.
    assert!((120..160).contains(&w) && (100..140).contains(&h), "{w}x{h}");
    let (w, h) = size(4.0, 100);
    assert!(w.max(h) == 100);
}

#[test]
fn mistakes_are_named_and_leave_the_model_alone() {
    let model = body(&[0.0, 0.1]);
    let (clip, masks) = film(&model, |_| 1.0);
    let refused = |masks: &[Mask], params: BakeParams, what: &str| {
        let mut out = model.clone();
        let error = bake(&mut out, &Footage { clip: &clip, masks, motion: None }, &params, Progress::new().whole());
        let error = error.expect_err(what).to_string();
        assert!(error.contains(what), "{error}");
        assert!(out == model);
    };
    let empty = vec![Mask::new(SIZE.0 as usize, SIZE.1 as usize); 2];
    refused(&empty, BakeParams::default(), "empty");
    refused(&masks[..1], BakeParams::default(), "masks");
    refused(&[masks[0].clone(), Mask::new(3, 3)], BakeParams::default(), "mask 1");
    refused(&masks, BakeParams { density: f32::NAN, ..BakeParams::default() }, "parameters");
    refused(&masks, BakeParams { density: 1e6, max_side: u32::MAX, ..BakeParams::default() }, "texels");
    refused(&masks, BakeParams { key_frame: 9, ..BakeParams::default() }, "key frame 9");
    refused(&masks, BakeParams { frames: (5, 9), ..BakeParams::default() }, "frames 5");
    let mut out = model.clone();
    let progress = Progress::new();
    progress.cancel();
    let footage = Footage { clip: &clip, masks: &masks, motion: None };
    assert!(matches!(bake(&mut out, &footage, &BakeParams::default(), progress.whole()), Err(Error::Cancelled)));
    assert!(out == model);
}

#[test]
fn a_cancel_half_way_leaves_the_model_alone() {
    let model = body(&[0.0; 60]);
    let (clip, masks) = film(&model, |_| 1.0);
    let footage = Footage { clip: &clip, masks: &masks, motion: None };
    let progress = Progress::new();
    let mut out = model.clone();
    let result = std::thread::scope(|scope| {
        scope.spawn(|| {
            while progress.fraction() < 0.15 {
                std::thread::yield_now();
            }
            progress.cancel();
        });
        bake(&mut out, &footage, &BakeParams::default(), progress.whole())
    });
    assert!(matches!(result, Err(Error::Cancelled)));
    assert!(out == model);
}

fn given(model: &RiggedModel, material: &Material<'_>, region: &Region<'_>) -> Result<RiggedModel> {
    let mut out = model.clone();
    transfer(&mut out, material, region, &BakeParams::default(), Progress::new().whole()).map(|()| out)
}

#[test]
fn a_material_covers_its_region_with_a_soft_border() {
    let tubes = [("near", vec3(30.0, 40.0, 0.0), 100.0, 14.0), ("body", vec3(30.0, 90.0, 0.0), 100.0, 14.0)];
    let mut model = creature(&tubes, &[0.0]);
    paint_all(&mut model, |_, _| [10, 10, 10]);
    let picture = RgbImage::from_pixel(5, 3, Rgb([250, 130, 70]));
    let material = Material::Repeated { picture: &picture, width: 7.0 };
    let limbs = ["near".to_owned()];
    let out = given(&model, &material, &Region { limbs: &limbs, ..Region::default() }).expect("laid");
    assert!(difference(&out.parts[0].texture, |_| true, |_| [250, 130, 70]) < 1.0);
    assert!(out.parts[1].texture == model.parts[1].texture);
    let left = Mask::from_fn(SIZE.0 as usize, SIZE.1 as usize, |x, _| x < 80);
    let region = Region { mask: Some(&left), soft: 20.0, ..Region::default() };
    let out = given(&model, &material, &region).expect("laid");
    let along: Vec<u8> = (0..112).map(|y| out.parts[1].texture.get_pixel(32, y).0[0]).collect();
    assert!(along[5] == 250 && along[105] == 10, "{along:?}");
    assert!(along.windows(2).all(|w| w[0] >= w[1] && w[0] - w[1] < 30), "{along:?}");
}

#[test]
fn another_creature_gives_its_colours_limb_by_limb() {
    let source = body(&[0.0]);
    let mut model = creature(&[("trunk", vec3(20.0, 50.0, 0.0), 150.0, 12.0)], &[0.0]);
    paint_all(&mut model, |_, _| [0; 3]);
    let pairs = [("trunk".to_owned(), "body".to_owned())];
    let material = Material::Creature { model: &source, limbs: &pairs };
    let out = given(&model, &material, &Region::default()).expect("given");
    let off = difference(&out.parts[0].texture, |_| true, |uv| stripes(0, uv));
    assert!(off < 6.0, "{off}");
    let unknown = given(&model, &Material::Creature { model: &source, limbs: &[] }, &Region::default());
    assert!(unknown.expect_err("no limb in common").to_string().contains("in common"));
}

#[test]
fn a_picture_from_the_side_and_a_frame_are_laid_on_what_they_show() {
    let model = body(&[0.0, 0.8]);
    let (red, blue) = ([220, 30, 30], [30, 30, 220]);
    let picture = RgbaImage::from_fn(60, 30, |x, _| {
        let [r, g, b] = if x < 30 { red } else { blue };
        Rgba([r, g, b, 255])
    });
    let out = given(&model, &Material::Side(&picture), &Region::default()).expect("laid");
    let truth = |uv: Vec2| if uv.y < 0.5 { red } else { blue };
    let ends = |uv: Vec2| (uv.y - 0.5).abs() > 0.05;
    assert!(difference(&out.parts[0].texture, |uv| front(uv) && ends(uv), truth) < 4.0);
    assert!(difference(&out.parts[0].texture, |uv| back(uv) && ends(uv), truth) < 6.0);
    let clear = RgbaImage::new(9, 9);
    let error = given(&model, &Material::Side(&clear), &Region::default()).expect_err("nothing to see");
    assert!(error.to_string().contains("shows nothing"), "{error}");

    let (clip, masks) = film(&model, |_| 1.0);
    let footage = Footage { clip: &clip, masks: &masks, motion: None };
    let mut out = grey(&model);
    let params = BakeParams { frames: (1, 1), ..BakeParams::default() };
    transfer(&mut out, &Material::Frames(footage), &Region::default(), &params, Progress::new().whole()).expect("laid");
    // In frame 1 the viewer sees what has turned toward it.
    let seen = |uv: Vec2| (uv.x - 0.25 + 0.8 / TAU).abs() < 0.12 && (uv.y - 0.5).abs() < 0.4;
    let off = difference(&out.parts[0].texture, seen, |uv| stripes(0, uv));
    assert!(off < 4.0, "{off}");
}

#[test]
fn poor_transfers_are_refused() {
    let model = body(&[0.0]);
    let picture = RgbImage::from_pixel(4, 4, Rgb([1, 2, 3]));
    let refused = |material: Material<'_>, region: Region<'_>, what: &str| {
        let error = given(&model, &material, &region).expect_err(what).to_string();
        assert!(error.contains(what), "{error}");
    };
    let good = Material::Repeated { picture: &picture, width: 9.0 };
    refused(Material::Repeated { picture: &picture, width: f32::NAN }, Region::default(), "width");
    refused(Material::Repeated { picture: &RgbImage::new(0, 0), width: 9.0 }, Region::default(), "empty");
    let tusk = ["tusk".to_owned()];
    refused(good, Region { limbs: &tusk, ..Region::default() }, "`tusk`");
    refused(good, Region { soft: -1.0, ..Region::default() }, "border");
    refused(good, Region { mask: Some(&Mask::new(4, 4)), ..Region::default() }, "mask");
    let nothing = Mask::new(SIZE.0 as usize, SIZE.1 as usize);
    refused(good, Region { mask: Some(&nothing), ..Region::default() }, "nothing");
}
