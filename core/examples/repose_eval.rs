//! Rebuilds a creature from what `marey creature` wrote of a clip, poses it along its own strokes in every way there is,
//! and says how its silhouettes lie on the tracked creature's and on the masks, and how hard its limbs are pulled.
//! Pictures show it in poses from its side, from the front and from above.
//!
//! `repose_eval CLIP STROKES FOLDER [OUT_FOLDER [FOREIGN_MOTION]]`, where FOLDER has motion.json and masks/.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::path::Path;
use std::time::Instant;

use glam::{Mat4, Vec2, Vec3, vec3};
use image::RgbaImage;
use marey::clip::Clip;
use marey::job::Progress;
use marey::motion::Motion;
use marey::raster::{Mask, Rasterizer, Surface, clip_view, orbit_view};
use marey::rig::{Facing, Rig};
use marey::shape::character::Easing;
use marey::shape::creature::{
    Creature, CreatureParams, DriveParams, LimbPose, PoseKey, PoseKeys, PoseParams, reconstruct,
};

type Failure = Box<dyn std::error::Error>;

fn silhouette(creature: &Creature, frame: usize) -> Mask {
    let model = &creature.model;
    let mut picture = Rasterizer::new(model.size.0, model.size.1);
    for mesh in model.pose(frame) {
        picture.draw(&mesh, &clip_view(model.size.1), Surface::Bare, 0);
    }
    Mask::from_fn(model.size.0 as usize, model.size.1 as usize, |x, y| picture.id.get(x, y) == 0)
}

/// Three views of one frame beside each other.
fn views(creature: &Creature, frame: usize) -> RgbaImage {
    let model = &creature.model;
    let meshes = model.pose(frame);
    let places = || meshes.iter().flat_map(|m| &m.positions);
    let middle = places().sum::<Vec3>() / places().count().max(1) as f32;
    let size = (360u32, 300u32);
    let reach = places().map(|p| p.distance(middle)).fold(1.0, f32::max);
    let mut out = RgbaImage::new(size.0 * 3, size.1);
    for (i, (yaw, pitch)) in [(0.0, 0.0), (80.0, 5.0), (10.0, 75.0)].into_iter().enumerate() {
        let turned = orbit_view(middle, yaw, pitch, 1.0, None, (0, 0));
        let at = turned.transform_point3(middle);
        let view = Mat4::from_translation(vec3(size.0 as f32 / 2.0, size.1 as f32 / 2.0, 0.0))
            * Mat4::from_scale(Vec3::splat(0.48 * size.1 as f32 / reach))
            * Mat4::from_translation(-at)
            * turned;
        let mut raster = Rasterizer::new(size.0, size.1);
        raster.clear([58, 62, 70, 255]);
        for (part, mesh) in model.parts.iter().zip(&meshes) {
            raster.draw(mesh, &view, Surface::Lit(&part.texture), 0);
        }
        image::imageops::replace(&mut out, &raster.color, i64::from(size.0) * i as i64, 0);
    }
    out
}

fn say(name: &str, posed: &Creature, tracked: &[Mask], masks: &[Mask]) {
    let frames = posed.model.animation.len().min(masks.len());
    let (mut on_tracked, mut on_masks, mut change, mut worst) = (0.0, 0.0, 0.0, 0.0f64);
    for f in 0..frames {
        let shown = silhouette(posed, f);
        let (now, before) = (shown.iou(&masks[f]), tracked[f].iou(&masks[f]));
        on_tracked += shown.iou(&tracked[f]);
        on_masks += now;
        change += now - before;
        worst = worst.max(before - now);
    }
    let n = frames.max(1) as f64 / 100.0;
    println!(
        "{name:34} IoU with tracked {:6.2}, with masks {:6.2} ({:+.2}; worst frame -{:.2})",
        on_tracked / n,
        on_masks / n,
        change / n,
        worst * 100.0
    );
    let strain = posed.strain();
    let all = |of: fn(&marey::shape::creature::LimbStrain) -> f32| strain.iter().map(of).collect::<Vec<f32>>();
    let most = |v: Vec<f32>| v.into_iter().fold(0.0, f32::max);
    let least = all(|s| s.shortest).into_iter().fold(f32::INFINITY, f32::min);
    println!(
        "{:34} lengths {least:.3} to {:.3}, sharpest {:.1} degrees, gap {:.2} px",
        "",
        most(all(|s| s.longest)),
        most(all(|s| s.sharpest)),
        most(all(|s| s.gap))
    );
}

fn keys_of(motion: &Motion) -> PoseKeys {
    let key = |f: usize| PoseKey {
        frame: f,
        easing: Easing::Linear,
        limbs: motion
            .tracks
            .iter()
            .map(|t| LimbPose { limb: t.name.clone(), points: t.frames[f].points.clone(), ..LimbPose::default() })
            .collect(),
    };
    PoseKeys { size: motion.size, fps: None, step: 1, keys: (0..motion.frames).map(key).collect() }
}

/// The limb's rest stroke turned about its start by so many degrees, and made so many times as long.
fn turned(rest: &[LimbPose], label: &str, degrees: f32, longer: f32) -> Option<LimbPose> {
    let pose = rest.iter().find(|p| p.limb == label)?;
    let turn = Vec2::from_angle(degrees.to_radians());
    let points = pose.points.iter().map(|p| pose.points[0] + turn.rotate(*p - pose.points[0]) * longer);
    Some(LimbPose { points: points.collect(), ..pose.clone() })
}

fn main() -> Result<(), Failure> {
    let args: Vec<String> = std::env::args().collect();
    let [_, clip, strokes, folder, rest @ ..] = args.as_slice() else {
        return Err("repose_eval CLIP STROKES FOLDER [OUT_FOLDER [FOREIGN_MOTION]]".into());
    };
    let clip = Clip::open(clip)?;
    let rig = Rig::read(strokes)?;
    let motion = Motion::read(Path::new(folder).join("motion.json"))?;
    let masks: Vec<Mask> = (0..motion.frames)
        .map(|f| Ok(Mask::from_image(&image::open(format!("{folder}/masks/{f:05}.png"))?.into_luma8())))
        .collect::<Result<_, Failure>>()?;
    let progress = Progress::new();
    let creature = reconstruct(&clip, &rig, &motion, &masks, &CreatureParams::default(), progress.whole())?;
    let tracked: Vec<Mask> = (0..motion.frames).map(|f| silhouette(&creature, f)).collect();
    say("tracked", &creature, &tracked, &masks);
    let own = creature.motion();
    let params = PoseParams::default();
    for (name, motion) in [("its own axes", &own), ("the tracker's strokes", &motion)] {
        let start = Instant::now();
        let posed = creature.reposed(&keys_of(motion), None, &params, progress.whole())?;
        let seconds = start.elapsed().as_secs_f64();
        say(&format!("posed along {name}"), &posed, &tracked, &masks);
        println!("{:34} {:.2} ms a frame", "", seconds * 1e3 / motion.frames as f64);
        for keep_lengths in [false, true] {
            let params = DriveParams { pose: PoseParams { keep_lengths, ..params.clone() }, ..DriveParams::default() };
            let driven = creature.driven(motion, None, &params, progress.whole())?;
            say(
                &format!("driven by {name}{}", if keep_lengths { ", lengths kept" } else { "" }),
                &driven,
                &tracked,
                &masks,
            );
        }
    }
    let between = creature.reposed(&PoseKeys::from(&rig), Some(motion.frames), &params, progress.whole())?;
    say("key frames and in-betweens", &between, &tracked, &masks);
    for strain in creature.strain() {
        println!("{strain:?}");
    }
    let Some(out) = rest.first() else { return Ok(()) };
    std::fs::create_dir_all(out)?;
    let save = |name: &str, creature: &Creature, frame: usize| views(creature, frame).save(format!("{out}/{name}.png"));
    save("rest", &creature, creature.rest_frame)?;
    let at_rest: Vec<LimbPose> = keys_of(&own).keys.swap_remove(creature.rest_frame).limbs;
    let one = |limbs: Vec<LimbPose>| PoseKeys {
        size: own.size,
        fps: None,
        step: 1,
        keys: vec![PoseKey { frame: 0, easing: Easing::Linear, limbs }],
    };
    let labels: Vec<&str> = creature.limbs.iter().map(|l| l.label.as_str()).collect();
    let legs: Vec<&str> = creature.limbs.iter().filter(|l| l.twin.is_some()).map(|l| l.label.as_str()).collect();
    let pose = |edits: Vec<Option<LimbPose>>| {
        creature.reposed(&one(edits.into_iter().flatten().collect()), None, &params, progress.whole())
    };
    save(
        "body-up",
        &pose(labels.iter().filter(|l| l.contains("body")).map(|l| turned(&at_rest, l, -25.0, 1.0)).collect())?,
        0,
    )?;
    let swung = legs.iter().enumerate().map(|(i, l)| turned(&at_rest, l, if i % 2 == 0 { 35.0 } else { -35.0 }, 1.0));
    save("legs-swung", &pose(swung.collect())?, 0)?;
    let raised = legs.iter().take(1).map(|l| {
        let mut pose = turned(&at_rest, l, 0.0, 0.35)?;
        pose.facing = Some(Facing::Toward);
        Some(pose)
    });
    save("leg-toward", &pose(raised.collect())?, 0)?;
    save("legs-long", &pose(legs.iter().map(|l| turned(&at_rest, l, 0.0, 2.0)).collect())?, 0)?;
    if let Some(path) = rest.get(1) {
        let foreign = Motion::read(path)?;
        let driven = creature.driven(&foreign, None, &DriveParams::default(), progress.whole())?;
        for f in 0..4 {
            save(&format!("foreign-{f}"), &driven, f * foreign.frames / 4)?;
        }
        println!("foreign: {:?}", driven.strain());
    }
    Ok(())
}
