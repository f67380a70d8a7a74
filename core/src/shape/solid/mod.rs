//! One frame of a model as one closed solid in millimetres, ready to be printed.
//!
//! The posed surfaces become a signed distance on a grid ([`crate::geometry::signed_distance`]), thin parts are made thick
//! enough there, loose bits are joined, feet or a base are added, and the surface of what results is a closed manifold
//! whatever went in ([`iso_surface`]). Colours come from the nearest place of the posed surface.
//!
//! Limits: edges are rounded at the size of the grid's cell; parts thinner than a cell break up where no least thickness
//! is asked for.

mod base;
#[cfg(test)]
mod tests;
mod thin;

use glam::{Vec2, Vec3};
use image::RgbImage;
use rayon::prelude::*;

use super::RiggedModel;
use crate::error::{Error, Result};
use crate::geometry::manifold::{manifold_defect, pieces};
use crate::geometry::signed_distance::Soup;
use crate::geometry::triangle_tree::{TriangleTree, barycentric};
use crate::geometry::{Field3, TriMesh, decimate, iso_surface};
use crate::job::Stage;

/// Samples of the grid at most: 256 MB of distances.
const MAX_SAMPLES: u64 = 64 << 20;
/// Cells along the longest side where nothing else asks for more: a tenth of a millimetre per three centimetres, about
/// what a nozzle of 0.4 mm can show of a figure of a hand's length.
const CELLS: f32 = 320.0;
/// Cells across the least thickness: three hold a sheet's two sides apart with room between.
const CELLS_ACROSS: f32 = 3.0;
/// Distances are exact for so many cells on either side.
const BAND: f32 = 3.0;
/// A loose bit of this share of the whole volume is joined by a bar; below it is dropped.
const WORTH_JOINING: f64 = 0.002;
/// How much of the lowest end becomes a flat foot, in mm: two layers of a usual print, so that the first one has
/// something to lay.
const FLAT: f32 = 0.4;
/// The colour of a base.
const GREY: [u8; 3] = [168, 168, 164];

/// How large the creature is to be, before thin parts and a base make it larger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SolidSize {
    /// Its longest side, in mm.
    Longest(f32),
    /// Its height, in mm.
    Height(f32),
    /// One unit of the model's world, in mm: frames of one creature keep their relative size.
    Unit(f32),
}

/// What is wanted of the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SolidOptions {
    /// How large.
    pub size: SolidSize,
    /// No part is thinner, in mm. 0 leaves all as it is.
    pub min_thickness: f32,
    /// A plate under the feet, joined to all of them.
    pub base: bool,
    /// The size of the smallest detail, in mm; `None` chooses by size and least thickness.
    pub detail: Option<f32>,
    /// At most so many triangles; `None` leaves as many as the detail takes.
    pub max_triangles: Option<usize>,
}

impl Default for SolidOptions {
    /// 100 mm long; 1 mm thick, which a nozzle of 0.4 mm prints with two walls and a hand does not break at once.
    fn default() -> Self {
        Self { size: SolidSize::Longest(100.0), min_thickness: 1.0, base: false, detail: None, max_triangles: None }
    }
}

/// A closed solid that stands on z = 0, z up.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Vertices in mm.
    pub positions: Vec<Vec3>,
    /// Triangles, counter-clockwise seen from outside: a closed manifold.
    pub triangles: Vec<[u32; 3]>,
    /// sRGB, one a vertex.
    pub colours: Vec<[u8; 3]>,
    /// What was done.
    pub report: SolidReport,
}

/// What was done to make a solid.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct SolidReport {
    /// Width, depth and height, in mm.
    pub size_mm: [f32; 3],
    /// In cubic mm.
    pub volume_mm3: f64,
    /// Millimetres a unit of the model's world.
    pub mm_per_unit: f32,
    /// How many triangles.
    pub triangles: usize,
    /// The grid's cell, in mm.
    pub cell_mm: f32,
    /// How much of the surface belonged to parts that were too thin, in 0..=1.
    pub thickened: f32,
    /// Loose bits that bars join to the rest.
    pub joined: usize,
    /// Loose bits that were left out.
    pub dropped: usize,
    /// Hollows inside that were filled.
    pub filled: usize,
    /// Feet that the base holds; 0 without one.
    pub feet: usize,
    /// For a person to know.
    pub warnings: Vec<String>,
}

/// Frame `frame` of `model` as a solid.
///
/// # Errors
/// A model that is not valid or has no such frame, a size or thickness that is no number or that do not fit each other, a
/// grid that would be too large, or a cancel.
pub fn solid(model: &RiggedModel, frame: usize, options: &SolidOptions, stage: Stage<'_>) -> Result<Solid> {
    check(options)?;
    model.validate()?;
    if frame >= model.animation.len() {
        let n = model.animation.len();
        let remedy = if n == 0 { "animate it first".into() } else { format!("name one of 0 to {}", n - 1) };
        return Err(Error::invalid(format!("frame {frame}"), format!("the model has {n} frames"), remedy));
    }
    stage.name("posing the creature")?;
    Posed::new(model, &model.pose(frame), options)?.solid(options, stage)
}

fn check(options: &SolidOptions) -> Result<()> {
    let (SolidSize::Longest(size) | SolidSize::Height(size) | SolidSize::Unit(size)) = options.size;
    let real = |what: &str, value: f32, least: f32| {
        if value.is_finite() && value >= least {
            return Ok(());
        }
        Err(Error::invalid(what, format!("is {value}"), "give a length in millimetres"))
    };
    real("the size", size, f32::MIN_POSITIVE)?;
    real("the least thickness", options.min_thickness, 0.0)?;
    real("the detail", options.detail.unwrap_or(1.0), f32::MIN_POSITIVE)?;
    if options.max_triangles.is_some_and(|n| n < 100) {
        return Err(Error::invalid("the number of triangles", "is below 100", "allow at least 100, or leave it out"));
    }
    Ok(())
}

/// All parts of a frame as one soup in mm, z up.
struct Posed<'a> {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    /// Where each part's triangles end, and its texture.
    parts: Vec<(usize, &'a RgbImage)>,
    size: Vec3,
    mm_per_unit: f32,
}

impl<'a> Posed<'a> {
    fn new(model: &'a RiggedModel, meshes: &[TriMesh], options: &SolidOptions) -> Result<Self> {
        let mut posed = Self {
            positions: vec![],
            uvs: vec![],
            triangles: vec![],
            parts: vec![],
            size: Vec3::ZERO,
            mm_per_unit: 1.0,
        };
        for (mesh, part) in meshes.iter().zip(&model.parts) {
            let first = posed.positions.len() as u32;
            // World y is up; a printer's z is.
            posed.positions.extend(mesh.positions.iter().map(|p| Vec3::new(p.x, -p.z, p.y)));
            posed.uvs.extend(&mesh.uvs);
            posed.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
            posed.parts.push((posed.triangles.len(), &part.texture));
        }
        let used = || posed.triangles.iter().flatten().map(|&v| posed.positions[v as usize]);
        let (low, high) = used().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let extent = high - low;
        let (mm, side) = match options.size {
            SolidSize::Longest(mm) => (mm, extent.max_element()),
            SolidSize::Height(mm) => (mm, extent.z),
            SolidSize::Unit(mm) => (mm, 1.0),
        };
        let scale = mm / side;
        let size = extent * scale;
        if !(size.is_finite() && scale.is_finite() && size.max_element() > 0.0) {
            return Err(Error::invalid(
                "the creature in this frame",
                format!("measures {} by {} by {} units", extent.x, extent.z, extent.y),
                "choose another frame or size",
            ));
        }
        if size.max_element() < 3.0 * options.min_thickness {
            return Err(Error::invalid(
                "the print",
                format!(
                    "is {:.2} mm long, and no part may be thinner than {} mm",
                    size.max_element(),
                    options.min_thickness
                ),
                "make it larger, or allow thinner parts",
            ));
        }
        let middle = (0.5 * (low + high)).with_z(low.z);
        posed.positions.iter_mut().for_each(|p| *p = (*p - middle) * scale);
        Ok(Self { size, mm_per_unit: scale, ..posed })
    }

    fn solid(&self, options: &SolidOptions, stage: Stage<'_>) -> Result<Solid> {
        let longest = self.size.max_element();
        let radius = 0.5 * options.min_thickness;
        let cell = self.cell(options)?;
        let band = (BAND * cell).max(radius + cell);
        let measures = options.base.then(|| base::Measures::new(longest, options.min_thickness, cell));
        let mut report = SolidReport { cell_mm: cell, mm_per_unit: self.mm_per_unit, ..SolidReport::default() };

        stage.part(0.0, 0.1).name("finding its surface")?;
        let soup = Soup::new(&self.positions, &self.triangles, stage.part(0.0, 0.1))?;
        stage.part(0.1, 0.35).name("measuring distances")?;
        let mut field = self.grid(cell, radius + band + cell, measures);
        soup.signed_distance(&mut field, band, stage.part(0.1, 0.35))?;
        if radius > 0.0 {
            stage.part(0.35, 0.55).name("thickening thin parts")?;
            let thin = thin::find(&soup, &field, &self.positions, &self.triangles, radius, stage.part(0.35, 0.5))?;
            thin::add_balls(&mut field, &thin.balls, radius, band, stage.part(0.5, 0.55))?;
            report.thickened = thin.share;
        }

        stage.part(0.55, 0.8).name("joining loose bits")?;
        let (positions, triangles) = joined(&mut field, radius.max(2.0 * cell), &mut report, stage.part(0.55, 0.7))?;
        stage.part(0.7, 0.8).name(if options.base { "adding the base" } else { "making the feet flat" })?;
        let ground = positions.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
        let base = measures.map(|measures| base::Base::new(measures, &positions, &triangles));
        if let Some(base) = &base {
            base.add_to(&mut field, BAND * cell);
            report.feet = base.feet;
        } else {
            base::flatten(&mut field, ground, ground + FLAT.max(cell));
        }
        stage.part(0.8, 0.9).name("making the surface")?;
        let (mut positions, mut triangles) =
            joined(&mut field, radius.max(2.0 * cell), &mut report, stage.part(0.8, 0.9))?;
        if let Some(most) = options.max_triangles.filter(|&most| most < triangles.len()) {
            stage.part(0.9, 0.95).name("leaving out triangles")?;
            (positions, triangles) = decimate(&positions, &triangles, most, stage.part(0.9, 0.95))?;
            if triangles.len() > most {
                report.warnings.push(format!("it takes {} triangles to keep its form", triangles.len()));
            }
        }
        set_apart(&mut positions, 1e-3 * cell);
        if let Some(defect) = manifold_defect(positions.len(), &triangles) {
            return Err(Error::invalid(
                "the solid",
                format!("is not closed: {defect:?}"),
                "report this with the creature",
            ));
        }

        stage.part(0.95, 1.0).name("colouring")?;
        let colours = self.colours(&soup.surface, &positions, base.as_ref(), stage.part(0.95, 1.0))?;
        stand(&mut positions, &mut report);
        report.volume_mm3 = crate::geometry::manifold::volume(&positions, &triangles);
        report.triangles = triangles.len();
        self.warn(options, &mut report);
        Ok(Solid { positions, triangles, colours, report })
    }

    /// The grid's cell.
    fn cell(&self, options: &SolidOptions) -> Result<f32> {
        let longest = self.size.max_element();
        let across = if options.min_thickness > 0.0 { options.min_thickness / CELLS_ACROSS } else { f32::INFINITY };
        let wanted = options.detail.unwrap_or(longest / CELLS).min(across);
        // What is around the creature takes part too: a tenth on each side is the rim of a base and more.
        let padded = self.size + 0.2 * longest + 4.0 * options.min_thickness + 16.0 * wanted;
        let samples = (padded.as_dvec3() / f64::from(wanted)).element_product();
        if samples <= MAX_SAMPLES as f64 {
            return Ok(wanted);
        }
        Err(Error::Limit {
            what: format!("the grid of {wanted:.3} mm for a print of {longest:.0} mm"),
            value: samples as u64,
            max: MAX_SAMPLES,
            remedy: "ask for less detail, thicker walls or a smaller print".into(),
        })
    }

    fn grid(&self, cell: f32, margin: f32, base: Option<base::Measures>) -> Field3 {
        let half = 0.5 * self.size;
        let (rim, below) = base.map_or((0.0, 0.0), |p| (p.rim + p.post, p.thickness));
        let side = Vec3::new(1.0, 1.0, 0.0) * rim + margin;
        // Samples keep off the round numbers that surfaces like to lie on.
        let low = Vec3::new(-half.x, -half.y, -below) - side - 0.37 * cell;
        let high = Vec3::new(half.x, half.y, self.size.z) + side;
        let dims = ((high - low) / cell).ceil().to_array().map(|n| n as usize + 1);
        Field3::new(dims, low, cell, 0.0)
    }

    fn colours(
        &self,
        surface: &TriangleTree,
        positions: &[Vec3],
        base: Option<&base::Base>,
        stage: Stage<'_>,
    ) -> Result<Vec<[u8; 3]>> {
        positions
            .par_iter()
            .map(|p| {
                stage.at(0.0)?;
                let reach = base.map_or(f32::INFINITY, |b| b.distance(*p).abs());
                let Some(near) = surface.nearest(*p, reach) else { return Ok(GREY) };
                let triangle = self.triangles[near.triangle as usize];
                let shares = barycentric(near.point, triangle.map(|v| self.positions[v as usize]));
                let [a, b, c] = triangle.map(|v| self.uvs[v as usize]);
                let part = self.parts.partition_point(|(end, _)| *end <= near.triangle as usize);
                Ok(texel(self.parts[part].1, a * shares.x + b * shares.y + c * shares.z))
            })
            .collect()
    }

    fn warn(&self, options: &SolidOptions, report: &mut SolidReport) {
        let mut warn = |text: String| report.warnings.push(text);
        if report.dropped > 0 {
            warn(format!("{} loose bits were left out", report.dropped));
        }
        if report.joined > 0 {
            warn(format!(
                "{} loose parts were joined by bars of {} mm",
                report.joined,
                options.min_thickness.max(4.0 * report.cell_mm)
            ));
        }
        if report.thickened > 0.2 {
            let share = 100.0 * report.thickened;
            warn(format!(
                "{share:.0} % of the surface was thinner than {} mm; a larger print keeps more of its form",
                options.min_thickness
            ));
        }
        if !options.base && report.size_mm[2] > 0.0 {
            // Two feet or a narrow stand tip over on the bed.
            let narrow = report.size_mm[1] < 0.25 * report.size_mm[2];
            if narrow {
                warn("it is narrow for its height and may not stand; a base helps".into());
            }
        }
    }
}

/// The texture's colour, between its texels.
fn texel(texture: &RgbImage, uv: Vec2) -> [u8; 3] {
    let (w, h) = texture.dimensions();
    let at = uv.clamp(Vec2::ZERO, Vec2::ONE) * Vec2::new(w as f32, h as f32) - 0.5;
    let (low, share) = (at.floor(), at - at.floor());
    let read = |dx: i64, dy: i64, channel: usize| {
        let x = (low.x as i64 + dx).clamp(0, i64::from(w) - 1) as u32;
        let y = (low.y as i64 + dy).clamp(0, i64::from(h) - 1) as u32;
        f32::from(texture.get_pixel(x, y)[channel])
    };
    std::array::from_fn(|c| {
        let top = read(0, 0, c) + (read(1, 0, c) - read(0, 0, c)) * share.x;
        let bottom = read(0, 1, c) + (read(1, 1, c) - read(0, 1, c)) * share.x;
        (top + (bottom - top) * share.y).round() as u8
    })
}

/// The surface of the field's one solid. Hollows are filled, bits that are large enough are joined to the largest by bars
/// of `radius`, which go into the field, and others are left out.
fn joined(
    field: &mut Field3,
    radius: f32,
    report: &mut SolidReport,
    stage: Stage<'_>,
) -> Result<(Vec<Vec3>, Vec<[u32; 3]>)> {
    loop {
        stage.at(0.0)?;
        let (positions, triangles) = iso_surface(field, 0.0);
        stage.at(0.5)?;
        let piece = pieces(positions.len(), &triangles);
        let mut volumes = vec![0.0f64; piece.iter().max().map_or(0, |m| *m as usize + 1)];
        for (&[a, b, c], &p) in triangles.iter().zip(&piece) {
            let corner = |v: u32| positions[v as usize].as_dvec3();
            volumes[p as usize] += corner(a).dot(corner(b).cross(corner(c))) / 6.0;
        }
        let main = (0..volumes.len()).fold(0, |best, p| if volumes[p] > volumes[best] { p } else { best });
        let Some(&whole) = volumes.get(main).filter(|v| **v > 0.0) else {
            return Err(Error::invalid(
                "the creature in this frame",
                "holds no volume at this size and detail",
                "make it larger, give a least thickness, or check that its faces point outwards",
            ));
        };
        let of = |wanted: usize| -> Vec<[u32; 3]> {
            triangles.iter().zip(&piece).filter(|(_, p)| **p as usize == wanted).map(|(t, _)| *t).collect()
        };
        let own = of(main);
        let tree = TriangleTree::new(&positions, &own);
        let mut bars = Vec::new();
        let (mut dropped, mut filled) = (0, 0);
        for (p, volume) in volumes.iter().enumerate().filter(|(p, _)| *p != main) {
            stage.at(0.5)?;
            if *volume < WORTH_JOINING * whole {
                if *volume < 0.0 {
                    filled += 1;
                } else {
                    dropped += 1;
                }
                continue;
            }
            let nearest = of(p).iter().flatten().map(|&v| positions[v as usize]).fold(
                None,
                |best: Option<(Vec3, Vec3, f32)>, at| {
                    let limit = best.map_or(f32::INFINITY, |b| b.2);
                    tree.nearest(at, limit).map(|n| (at, n.point, n.distance)).or(best)
                },
            );
            bars.extend(nearest.map(|(from, to, _)| (from, to)));
        }
        if bars.is_empty() {
            report.dropped = dropped;
            report.filled = filled;
            return Ok(compact(&positions, &own));
        }
        report.joined += bars.len();
        for (from, to) in bars {
            // Deep enough into both for the bar to hold.
            let way = (to - from).normalize_or_zero() * radius;
            base::add_bar(field, from - way, to + way, radius);
        }
    }
}

/// Only the vertices that triangles use.
fn compact(positions: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut number = vec![u32::MAX; positions.len()];
    let mut kept = Vec::new();
    let triangles = triangles
        .iter()
        .map(|t| {
            t.map(|v| {
                let number = &mut number[v as usize];
                if *number == u32::MAX {
                    *number = kept.len() as u32;
                    kept.push(positions[v as usize]);
                }
                *number
            })
        })
        .collect();
    (kept, triangles)
}

/// Moves vertices that lie in one place apart by `step`: an STL knows vertices by their place alone.
fn set_apart(positions: &mut [Vec3], step: f32) {
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    loop {
        let key = |v: &u32| (positions[*v as usize] + 0.0).to_array().map(f32::to_bits);
        order.sort_unstable_by_key(|v| (key(v), *v));
        let twice: Vec<u32> = order.windows(2).filter(|w| key(&w[0]) == key(&w[1])).map(|w| w[1]).collect();
        if twice.is_empty() {
            return;
        }
        for (i, v) in twice.into_iter().enumerate() {
            positions[v as usize].x += step * (i + 1) as f32;
        }
    }
}

/// Puts the lowest vertices on z = 0 and the middle over the origin.
fn stand(positions: &mut [Vec3], report: &mut SolidReport) {
    let (low, high) = positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    let middle = (0.5 * (low + high)).with_z(low.z);
    positions.iter_mut().for_each(|p| *p -= middle);
    report.size_mm = (high - low).to_array();
}
