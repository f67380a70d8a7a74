//! Reconstructs one clip from what `marey creature` wrote before and writes a mesh for each frame and pictures: for
//! comparing parameters without tracking anew.
//!
//! `cargo run --release -p marey --example creature_eval -- CLIP STROKES.json FOLDER OUT [tubes]`, FOLDER with
//! motion.json and masks/.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::path::Path;
use std::time::Instant;

use marey::clip::Clip;
use marey::job::Progress;
use marey::motion::Motion;
use marey::raster::{Mask, Rasterizer, Surface, clip_view, orbit_view};
use marey::rig::Rig;
use marey::shape::creature::{self, CreatureParams, reconstruct};
use marey::{Error, Result, vec3};

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [clip, strokes, folder, out, rest @ ..] = args.as_slice() else {
        return Err(Error::invalid("arguments", "too few", "give CLIP STROKES.json FOLDER OUT"));
    };
    let clip = Clip::open(clip)?;
    let rig = Rig::read(strokes)?;
    let motion = Motion::read(Path::new(folder).join("motion.json"))?;
    let masks: Vec<Mask> = (0..motion.frames)
        .map(|f| {
            let path = Path::new(folder).join(format!("masks/{f:05}.png"));
            let picture = image::open(&path).map_err(|e| Error::invalid("mask", e.to_string(), "give masks"))?;
            Ok(Mask::from_image(&picture.to_luma8()))
        })
        .collect::<Result<_>>()?;
    let mut params = CreatureParams::default();
    let tubes = rest.iter().any(|a| a == "tubes");
    params.surface = if tubes { creature::Surface::Tubes } else { creature::Surface::Skin };
    let start = Instant::now();
    let made = reconstruct(&clip, &rig, &motion, &masks, &params, Progress::new().whole())?;
    println!("{:.3} s, rest frame {}", start.elapsed().as_secs_f64(), made.rest_frame);
    let model = made.model;
    model.validate()?;
    let folder = Path::new(out);
    let io = |e| Error::io(out, "write", e);
    std::fs::create_dir_all(folder.join("meshes")).map_err(io)?;
    let (mut sum, mut worst) = (0.0, 1.0f64);
    for f in 0..motion.frames {
        let meshes = model.pose(f);
        let mut text = String::new();
        let mut base = 1;
        for mesh in &meshes {
            for p in &mesh.positions {
                text += &format!("v {} {} {}\n", p.x, p.y, p.z);
            }
            for t in &mesh.triangles {
                text += &format!("f {} {} {}\n", t[0] + base, t[1] + base, t[2] + base);
            }
            base += mesh.positions.len() as u32;
        }
        std::fs::write(folder.join(format!("meshes/{f:05}.obj")), text).map_err(io)?;
        let mut picture = Rasterizer::new(model.size.0, model.size.1);
        for mesh in &meshes {
            picture.draw(mesh, &clip_view(model.size.1), Surface::Bare, 0);
        }
        let drawn = Mask::from_fn(masks[f].width(), masks[f].height(), |x, y| picture.id.get(x, y) == 0);
        let iou = drawn.iou(&masks[f]);
        if rig.keyframes.iter().any(|k| k.frame == f) {
            println!("key frame {f}: {:.2}", 100.0 * iou);
        }
        sum += iou;
        worst = worst.min(iou);
    }
    println!("mean {:.2} worst {:.2}", 100.0 * sum / motion.frames as f64, 100.0 * worst);
    println!(
        "{} vertices, {} triangles",
        model.parts.iter().map(|p| p.mesh.positions.len()).sum::<usize>(),
        model.parts.iter().map(|p| p.mesh.triangles.len()).sum::<usize>()
    );
    let size = model.size;
    for f in [0, motion.frames / 3, 2 * motion.frames / 3] {
        let meshes = model.pose(f);
        let all = || meshes.iter().flat_map(|m| &m.positions);
        let (low, high) = all().fold((vec3(1e9, 1e9, 1e9), vec3(-1e9, -1e9, -1e9)), |(l, h), p| (l.min(*p), h.max(*p)));
        let scale = 0.9 * (size.0 as f32 / (high.x - low.x)).min(size.1 as f32 / (high.y - low.y));
        for (name, yaw, pitch) in [("side", 0.0, 0.0), ("front", 90.0, 0.0), ("above", 0.0, 80.0), ("half", 40.0, 15.0)]
        {
            let view = orbit_view((low + high) / 2.0, yaw, pitch, scale, None, size);
            let mut picture = Rasterizer::new(size.0, size.1);
            picture.clear([58, 62, 70, 255]);
            let clay = rest.iter().any(|a| a == "clay");
            for (part, mesh) in model.parts.iter().zip(&meshes) {
                let surface = if clay { Surface::Clay([190, 170, 150]) } else { Surface::Lit(&part.texture) };
                picture.draw(mesh, &view, surface, 0);
            }
            picture
                .color
                .save(folder.join(format!("{name}-{f:03}.png")))
                .map_err(|e| Error::invalid("png", e.to_string(), "x"))?;
        }
    }
    Ok(())
}
