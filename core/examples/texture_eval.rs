//! How far a creature's texture is from the frames it came from: the mean absolute error (levels of 255, mean over
//! channels) inside the mask and the drawing, seen from the clip's own view, on the key frame and over all frames.
//!
//! `texture_eval CLIP STROKES FOLDER [OUT]`: FOLDER is what `marey creature` wrote (motion.json and masks/); textures
//! and views from the clip's side, the back, the front and above go to OUT.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::path::Path;
use std::time::Instant;

use glam::Vec3;
use marey::clip::Clip;
use marey::geometry::TriMesh;
use marey::job::Progress;
use marey::motion::Motion;
use marey::raster::{Mask, Rasterizer, Surface, clip_view, orbit_view};
use marey::rig::Rig;
use marey::shape::RiggedModel;
use marey::shape::creature::texturing::{BakeParams, Footage, bake};
use marey::shape::creature::{CreatureParams, reconstruct};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [clip, strokes, folder, rest @ ..] = &args[..] else {
        return Err("usage: texture_eval CLIP STROKES FOLDER [OUT]".into());
    };
    let clip = Clip::open(clip)?;
    let rig = Rig::read(strokes)?;
    let folder = Path::new(folder);
    let motion = Motion::read(folder.join("motion.json"))?;
    let masks: Vec<Mask> = (0..motion.frames)
        .map(|f| Ok(Mask::from_image(&image::open(folder.join(format!("masks/{f:05}.png")))?.to_luma8())))
        .collect::<Result<_, Failure>>()?;
    let progress = Progress::new();
    let single = CreatureParams { texture_views: 1, ..CreatureParams::default() };
    let creature = reconstruct(&clip, &rig, &motion, &masks, &single, progress.whole())?;
    let (model, key) = (&creature.model, creature.rest_frame);
    report("one frame", &clip, model, &masks, key)?;
    if let Some(out) = rest.first() {
        look(model, key, Path::new(out), "one")?;
    }
    let mut baked = model.clone();
    let mut params = BakeParams::of(&creature);
    let footage = Footage { clip: &clip, masks: &masks, motion: Some(&motion) };
    let began = Instant::now();
    bake(&mut baked, &footage, &params, progress.whole())?;
    println!("baked in {:.2} s", began.elapsed().as_secs_f64());
    report("best views", &clip, &baked, &masks, key)?;
    if let Some(out) = rest.first() {
        look(&baked, key, Path::new(out), "best")?;
    }
    // Each frame with a texture of its own: what the texture's resolution and the mask's border cost.
    let mut own = (0.0, 0);
    for frame in (0..masks.len()).step_by(4).filter(|f| masks[*f].count() > 0) {
        params.key_frame = frame;
        params.frames = (frame, frame);
        let mut one = model.clone();
        bake(&mut one, &footage, &params, progress.whole())?;
        let e = error(&clip, &one, &masks[frame], frame)?;
        own = (own.0 + e.0, own.1 + e.1);
    }
    println!("{:28} {:32} {:5.2}", "a texture for each frame", "", own.0 / own.1 as f64);
    Ok(())
}

fn report(what: &str, clip: &Clip, model: &RiggedModel, masks: &[Mask], key: usize) -> Result<(), Failure> {
    let errors: Vec<(f64, usize)> =
        (0..masks.len()).map(|f| error(clip, model, &masks[f], f)).collect::<Result<_, Failure>>()?;
    let mean = |of: &[(f64, usize)]| of.iter().map(|e| e.0).sum::<f64>() / of.iter().map(|e| e.1).sum::<usize>() as f64;
    println!("{what:28} key frame {:5.2}   all frames {:5.2}", mean(&errors[key..=key]), mean(&errors));
    Ok(())
}

/// The sum of absolute errors and how many pixels it is over.
fn error(clip: &Clip, model: &RiggedModel, mask: &Mask, frame: usize) -> Result<(f64, usize), Failure> {
    let picture = draw(model, &model.pose(frame), &clip_view(model.size.1), model.size);
    let seen = clip.frame(frame)?;
    let (mut sum, mut count) = (0.0, 0);
    for (x, y, p) in picture.color.enumerate_pixels() {
        if p.0[3] > 0 && mask.get(x as usize, y as usize) {
            let other = seen.rgb.get_pixel(x, y).0;
            sum += (0..3).map(|c| f64::from(p.0[c].abs_diff(other[c]))).sum::<f64>() / 3.0;
            count += 1;
        }
    }
    Ok((sum, count))
}

fn draw(model: &RiggedModel, meshes: &[TriMesh], view: &glam::Mat4, (w, h): (u32, u32)) -> Rasterizer {
    let mut picture = Rasterizer::new(w, h);
    for (i, (mesh, part)) in meshes.iter().zip(&model.parts).enumerate() {
        picture.draw(mesh, view, Surface::Flat(&part.texture), i as u16);
    }
    picture
}

/// Writes the textures and four views.
fn look(model: &RiggedModel, frame: usize, out: &Path, name: &str) -> Result<(), Failure> {
    std::fs::create_dir_all(out)?;
    let meshes = model.pose(frame);
    let places = || meshes.iter().flat_map(|m| m.positions.iter().copied());
    let low = places().fold(Vec3::INFINITY, Vec3::min);
    let high = places().fold(Vec3::NEG_INFINITY, Vec3::max);
    let (w, h) = (640u32, 480u32);
    let scale = (0.9 * w as f32 / (high.x - low.x)).min(0.9 * h as f32 / (high.y - low.y));
    let mut sheet = image::RgbaImage::from_pixel(2 * w, 2 * h, image::Rgba([90, 96, 105, 255]));
    for (i, (yaw, pitch)) in [(0.0, 0.0), (180.0, 0.0), (70.0, 0.0), (20.0, 60.0)].into_iter().enumerate() {
        let view = orbit_view((low + high) / 2.0, yaw, pitch, scale, None, (w, h));
        let picture = draw(model, &meshes, &view, (w, h));
        let (x, y) = (i as u32 % 2 * w, i as u32 / 2 * h);
        image::imageops::overlay(&mut sheet, &picture.color, i64::from(x), i64::from(y));
    }
    sheet.save(out.join(format!("{name}.png")))?;
    for part in &model.parts {
        part.texture.save(out.join(format!("{name}-{}.png", part.name)))?;
    }
    Ok(())
}
