//! Drawing without a GPU: vertices are moved and coloured, then bands of rows are filled, all in parallel.
//!
//! Each band is filled by the triangles that reach it in their order, so that pictures are the same bits with any number of
//! threads. Smooth pictures are drawn at twice their size and halved.

mod band;
mod corners;

use std::ops::Range;

use image::RgbaImage;
use marey::Result;
use marey::job::Stage;
use rayon::prelude::*;

use self::band::{Band, Material};
use self::corners::Corners;
use crate::bone_shapes::octahedra;
use crate::{Picture, Scene, Style};

/// Rows of the picture in a band: at a width of 1280 smooth samples of one fill half a megabyte, which caches hold.
const ROWS: u32 = 16;

pub(crate) fn draw(scene: &Scene, frame: usize, picture: &Picture, stage: Stage<'_>) -> Result<RgbaImage> {
    let view = picture.view(scene, frame)?;
    let fine = if picture.smooth { 2 } else { 1 };
    let mut corners = Corners::new(picture.size, fine, &view.projection);
    let mut batches: Vec<(Range<usize>, Material<'_>)> = Vec::new();
    if let Some(flat) = &view.shadow {
        for instance in &scene.instances {
            let skin = instance.model.0.skin(&instance.pose(frame), &(*flat * instance.place));
            for part in &instance.model.rig().parts {
                batches.push((corners.add_flat(part, &skin), Material::Shadow));
            }
        }
    }
    let mut shapes = Vec::new();
    for instance in &scene.instances {
        stage.at(0.0)?;
        let model = &instance.model.0;
        let pose = instance.pose(frame);
        let skin = model.skin(&pose, &instance.place);
        let colors = model.colors(picture.style);
        for (p, part) in model.rig.parts.iter().enumerate() {
            let colors = colors.map(|c| &c[p][..]);
            let range = corners.add_surface(part, &skin, colors, picture.style, &view);
            batches.push((range, Material::surface(picture.style, &model.textures[p])));
        }
        if picture.style == Style::Bones {
            let joints = model.joints(&pose, &instance.place);
            octahedra(&model.links, &joints, &view.turn, &mut shapes);
        }
    }
    batches.push((corners.add_shapes(&shapes), Material::InFront));

    let (width, height) = picture.size;
    let bins = corners.bins(ROWS * fine);
    let mut out = RgbaImage::new(width, height);
    let row = width as usize * 4;
    out.par_chunks_mut(row * ROWS as usize).enumerate().try_for_each_init(Band::default, |band, (b, lines)| {
        stage.at(0.0)?;
        let first = b * (ROWS * fine) as usize;
        let rows = first..first + lines.len() / row * fine as usize;
        band.begin((width * fine) as usize, rows, view.clear);
        let mut batch = 0;
        for &triangle in &bins[b] {
            while !batches[batch].0.contains(&(triangle as usize)) {
                batch += 1;
            }
            band.fill(corners.triangle(triangle), &batches[batch].1, view.shadow_color, fine as f32);
        }
        band.resolve(lines, fine as usize);
        Ok(())
    })?;
    Ok(out)
}
