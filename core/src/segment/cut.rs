//! The mask of one frame as a minimum cut over colour evidence, a prior and contrast (Boykov and Jolly 2001; Rother,
//! Kolmogorov and Blake 2004), tidied afterwards.

use super::contrast::Contrast;
use super::evidence::Evidence;
use super::grid_cut::{GridCut, Neighbour};
use super::painted::Known;
use super::scene::{STROKE_WIDTH, Scene};
use super::stroke_field::NOWHERE;
use crate::raster::Mask;
use crate::raster::morphology::{parts, without_holes};

/// Fixed point of the cut's capacities.
const UNIT: f32 = 256.0;
/// More than all other costs of a pixel together.
const CERTAIN: i32 = 1 << 20;
/// Holes of at most this share of the mask are filled; larger ones are seen between limbs.
const HOLE_SHARE: f32 = 0.002;
/// Parts without a stroke that are this large, compared with the largest, are a limb whose track has been lost, if
/// most of them is no farther from some stroke than this share of the creature's extent.
const ISLAND_SHARE: f32 = 0.1;
const ISLAND_REACH: f32 = 0.25;
/// No cell: out of reach.
const FAR: u32 = u32::MAX;
const EDGES: [(Neighbour, isize, usize); 4] =
    [(Neighbour::Right, 1, 0), (Neighbour::Below, 0, 1), (Neighbour::BelowRight, 1, 1), (Neighbour::BelowLeft, -1, 1)];

/// The best mask of a frame under colour evidence and the prior of every cell (natural logarithms of odds).
pub(super) fn cut(scene: &Scene<'_>, frame: usize, evidence: &Evidence, prior: &[f32]) -> Mask {
    let image = &scene.working.frames[frame];
    let field = &scene.fields[frame];
    let (columns, rows) = scene.windows[frame].clone();
    let (width, height) = (columns.len(), rows.len());
    let (left, top) = (columns.start, rows.start);
    let mut near = vec![FAR; width * height];
    for (line, y) in near.chunks_exact_mut(width.max(1)).zip(rows) {
        for (cell, &place) in line.iter_mut().zip(&field.row(y)[columns.clone()]) {
            *cell = scene.cells.of(place).map_or(FAR, |c| c as u32);
        }
    }
    let contrast = Contrast::of(image, &scene.windows[frame]);
    let closeness = EDGES.map(|(_, dx, dy)| if dx != 0 && dy != 0 { std::f32::consts::FRAC_1_SQRT_2 } else { 1.0 });
    let closeness = closeness.map(|c| c * scene.params.edge_weight * UNIT);
    let mut problem = GridCut::new(width, height);
    for y in 0..height {
        for x in 0..width {
            let own = near[y * width + x];
            if own != FAR {
                let odds = scene.params.colour_weight * evidence.at(x + left, y + top)
                    + scene.params.shape_weight * prior[own as usize];
                problem.add_terminal(x, y, (odds * UNIT) as i32);
            }
            let here = image.get(x + left, y + top);
            for ((to, dx, dy), closeness) in EDGES.into_iter().zip(closeness) {
                let (nx, ny) = (x.wrapping_add_signed(dx), y + dy);
                if nx >= width || ny >= height {
                    continue;
                }
                let other = near[ny * width + nx];
                if own == FAR && other == FAR {
                    continue;
                }
                let cost = (contrast.weight(here, image.get(nx + left, ny + top)) * closeness) as i32;
                // What is out of reach is background: its edges are pulls towards it.
                match (own != FAR, other != FAR) {
                    (true, true) => problem.set_edge(x, y, to, cost),
                    (true, false) => problem.add_terminal(x, y, -cost),
                    _ => problem.add_terminal(nx, ny, -cost),
                }
            }
        }
    }
    if let Some(known) = scene.known.get(&frame) {
        for y in 0..height {
            for x in 0..width {
                match known.get(x + left, y + top) {
                    Known::Creature => problem.add_terminal(x, y, CERTAIN),
                    Known::Background => problem.add_terminal(x, y, -CERTAIN),
                    Known::Nothing => {}
                }
            }
        }
    }
    problem.solve();
    let mut mask = Mask::new(scene.working.width, scene.working.height);
    for y in 0..height {
        for x in 0..width {
            if problem.on_source_side(x, y) {
                mask.set(x + left, y + top, true);
            }
        }
    }
    tidied(scene, frame, &mask)
}

/// The mask without specks and pinholes, and without parts that no stroke passes through.
fn tidied(scene: &Scene<'_>, frame: usize, mask: &Mask) -> Mask {
    let mask = without_holes(mask, (mask.count() as f32 * HOLE_SHARE) as usize);
    let parts = parts(&mask);
    let mut kept: Vec<bool> = vec![false; parts.areas.len() + 1];
    let mut near = vec![0usize; parts.areas.len() + 1];
    for (index, place) in scene.fields[frame].data().iter().enumerate() {
        let part = parts.labels.data()[index] as usize;
        near[part] += usize::from(place.sample != NOWHERE && place.distance() <= ISLAND_REACH * scene.extent);
        let painted = scene.known.get(&frame).is_some_and(|k| k.data()[index] == Known::Creature);
        if painted || (place.sample != NOWHERE && place.distance() <= STROKE_WIDTH) {
            kept[part] = true;
        }
    }
    let largest = parts.areas.iter().max().copied().unwrap_or(0);
    for (part, &area) in parts.areas.iter().enumerate() {
        kept[part + 1] |= area as f32 >= ISLAND_SHARE * largest as f32 && 2 * near[part + 1] > area;
    }
    kept[0] = false;
    Mask::from_fn(mask.width(), mask.height(), |x, y| kept[parts.labels.get(x, y) as usize])
}
