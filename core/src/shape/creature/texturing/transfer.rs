//! Another texture for a creature: of other frames, of another creature, of a picture seen from the side, or of a
//! material.
//!
//! Frames and a picture from the side are baked as the creature's own frames are, so what hides what is known and what
//! nothing shows is borrowed. Another creature's colours come limb by limb: from the same share along the limb, the same
//! angle around it, as far from the axis as its thickness says ([`super::limbs`]). A material is repeated in space along
//! the three axes and blended by how the surface faces them, so it has no seams. A region says which texels are
//! replaced; its border is soft.
//!
//! Limits: a material lies on the rest pose; on limbs it is stretched as they are when they are bent there.

use glam::{Vec2, Vec3, Vec3Swizzles};
use image::{RgbImage, RgbaImage};
use rayon::prelude::*;

use super::borrowing::{self, Known};
use super::limbs::{Limbs, OnLimb};
use super::texels::Texels;
use super::{BakeParams, Footage, bake_onto, colors_of, paint};
use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::raster::Mask;
use crate::shape::RiggedModel;

/// How strongly the axis that a surface faces most prevails when a material is laid: the cosines' power.
const FACING_POWER: i32 = 4;

/// Where other colours come from.
#[derive(Clone, Copy, Debug)]
pub enum Material<'a> {
    /// Frames of the clip; [`BakeParams::frames`] says which.
    Frames(Footage<'a>),
    /// Another creature, limb by limb.
    Creature {
        /// The creature whose textures are taken.
        model: &'a RiggedModel,
        /// Pairs of labels: a limb of this creature, and the limb of the other that it takes its colours from. Limbs that
        /// are not listed take those of the limb of the same label.
        limbs: &'a [(String, String)],
    },
    /// A picture of the creature from the side, stretched over the rest pose as the clip's camera sees it. Where it
    /// is clear it shows nothing.
    Side(&'a RgbaImage),
    /// A material that repeats.
    Repeated {
        /// One piece of it, which should fit to itself.
        picture: &'a RgbImage,
        /// The piece's width in world units.
        width: f32,
    },
}

/// Which part of the surface is replaced.
#[derive(Clone, Copy, Debug, Default)]
pub struct Region<'a> {
    /// Labels of the limbs; none for all.
    pub limbs: &'a [String],
    /// Of those, what lies within this mask of the clip's size in the rest pose, on both sides of the creature.
    pub mask: Option<&'a Mask>,
    /// Over so many world units the border of the region runs from the old colours to the new ones.
    pub soft: f32,
}

/// Gives the model the colours of `material` in `region`. The size of its textures stays. `params` say how frames and
/// pictures are baked.
///
/// # Errors
/// A label that no limb has, a region or a picture that is empty, a mask of another size, a width or a softness that is
/// no number, what [`super::bake`] says of frames, or a cancel. The model is then as it was.
pub fn transfer(
    model: &mut RiggedModel,
    material: &Material<'_>,
    region: &Region<'_>,
    params: &BakeParams,
    stage: Stage<'_>,
) -> Result<()> {
    stage.name("texturing")?;
    model.validate()?;
    let sizes: Vec<(u32, u32)> = model.parts.iter().map(|p| p.texture.dimensions()).collect();
    let texels = Texels::new(model, sizes, stage.part(0.0, 0.1))?;
    let limbs = Limbs::new(model, &texels);
    let mut weight = weights(model, &texels, &limbs, region)?;
    stage.at(0.15)?;
    let new = match material {
        Material::Frames(footage) => bake_onto(model, footage, &texels, params, stage.part(0.15, 0.9))?,
        Material::Side(picture) => from_side(model, picture, &texels, params, stage.part(0.15, 0.9))?,
        Material::Repeated { picture, width } => repeated(&texels, picture, *width)?,
        Material::Creature { model: other, limbs: pairs } => {
            let (colors, found) = from_creature(other, pairs, &texels, &limbs, stage.part(0.15, 0.9))?;
            weight.iter_mut().zip(found).for_each(|(w, f)| *w = if f { *w } else { 0.0 });
            colors
        }
    };
    stage.at(0.9)?;
    let old = colors_of(model, &texels);
    let mixed: Vec<Vec3> = (0..texels.len()).map(|i| old[i].lerp(new[i], weight[i])).collect();
    let textures = paint(&texels, &mixed);
    stage.at(1.0)?;
    model.parts.iter_mut().zip(textures).for_each(|(p, t)| p.texture = t);
    Ok(())
}

/// How far each texel is replaced.
fn weights(model: &RiggedModel, texels: &Texels, limbs: &Limbs, region: &Region<'_>) -> Result<Vec<f32>> {
    if !(region.soft.is_finite() && region.soft >= 0.0) {
        return Err(Error::invalid("the region's border", format!("is {}", region.soft), "give a width of 0 or more"));
    }
    let wanted: Vec<usize> = region
        .limbs
        .iter()
        .map(|label| {
            limbs.find(label).ok_or_else(|| {
                let known: Vec<&str> = limbs.list.iter().map(|l| l.label.as_str()).collect();
                Error::invalid(
                    format!("limb `{label}`"),
                    "is not in the creature",
                    format!("it has {}", known.join(", ")),
                )
            })
        })
        .collect::<Result<_>>()?;
    if let Some(mask) = region.mask
        && (mask.width(), mask.height()) != (model.size.0 as usize, model.size.1 as usize)
    {
        let problem = format!("is {}x{}, the clip {}x{}", mask.width(), mask.height(), model.size.0, model.size.1);
        return Err(Error::invalid("the region's mask", problem, "give a mask of the clip's size"));
    }
    let inside: Vec<bool> = (0..texels.len())
        .map(|i| {
            let of_limb = wanted.is_empty() || wanted.contains(&usize::from(limbs.of_texel[i]));
            let p = texels.rest[i];
            let shown = |m: &Mask| m.at(p.x.floor() as isize, (model.size.1 as f32 - p.y).floor() as isize);
            of_limb && region.mask.is_none_or(shown)
        })
        .collect();
    if !inside.contains(&true) {
        return Err(Error::invalid(
            "the region",
            "holds nothing of the creature",
            "choose other limbs or another mask",
        ));
    }
    let outside = Known::new(&texels.rest, &texels.rest, |i| !inside[i]);
    Ok((0..texels.len())
        .into_par_iter()
        .with_min_len(256)
        .map(|i| match inside[i] {
            false => 0.0,
            true if region.soft == 0.0 => 1.0,
            true => outside.distance(texels.rest[i], region.soft).map_or(1.0, |d| {
                let t = d / region.soft;
                t * t * (3.0 - 2.0 * t)
            }),
        })
        .collect())
}

/// A picture as the only frame of a clip in which the creature stands in its rest pose.
fn from_side(
    model: &RiggedModel,
    picture: &RgbaImage,
    texels: &Texels,
    params: &BakeParams,
    stage: Stage<'_>,
) -> Result<Vec<Vec3>> {
    let (pw, ph) = picture.dimensions();
    let opaque: Vec<(u32, u32)> =
        picture.enumerate_pixels().filter(|p| p.2.0[3] >= 128).map(|(x, y, _)| (x, y)).collect();
    let (Some(left), Some(right), Some(top), Some(bottom)) = (
        opaque.iter().map(|p| p.0).min(),
        opaque.iter().map(|p| p.0).max(),
        opaque.iter().map(|p| p.1).min(),
        opaque.iter().map(|p| p.1).max(),
    ) else {
        return Err(Error::invalid(
            "the picture",
            format!("of {pw}x{ph} shows nothing"),
            "give one that is not all clear",
        ));
    };
    let low = texels.rest.iter().fold(Vec3::INFINITY, |a, p| a.min(*p));
    let high = texels.rest.iter().fold(Vec3::NEG_INFINITY, |a, p| a.max(*p));
    // What is opaque lies over the creature, border to border.
    let from = Vec2::new(left as f32, top as f32);
    let size = Vec2::new((right - left + 1) as f32, (bottom - top + 1) as f32);
    let scale = size / (high - low).xy().max(Vec2::ONE);
    // A frame of its own size: the creature may stand partly outside the clip.
    let margin = 8.0;
    let extent = (high - low).xy() + 2.0 * margin;
    let (w, h) = (extent.x.ceil() as u32, extent.y.ceil() as u32);
    let source = |x: u32, y: u32| from + (Vec2::new(x as f32, y as f32) + 0.5 - margin) * scale;
    let plain = RgbImage::from_fn(pw, ph, |x, y| {
        let [r, g, b, _] = picture.get_pixel(x, y).0;
        image::Rgb([r, g, b])
    });
    let frame = RgbImage::from_fn(w, h, |x, y| image::Rgb(super::view::bilinear(&plain, source(x, y))));
    // The border of what is opaque is stretched outward a little, or the creature's own border would show nothing.
    let mask = Mask::from_fn(w as usize, h as usize, |x, y| {
        let at = source(x as u32, y as u32).clamp(from, from + size - 1.0);
        picture.get_pixel(at.x as u32, at.y as u32).0[3] >= 128
    });
    let mut still = model.clone();
    still.size = (w, h);
    let shift = Vec3::new(margin - low.x, h as f32 - margin - high.y, 0.0);
    still
        .rest
        .iter_mut()
        .zip(&model.bones)
        .filter(|(_, b)| b.parent.is_none())
        .for_each(|(t, _)| t.translation += shift);
    still.animation = vec![still.rest.clone()];
    for part in &mut still.parts {
        part.mesh.positions.iter_mut().for_each(|p| *p += shift);
    }
    let clip = Clip::from_frames(vec![frame], 1.0)?;
    let params = BakeParams { key_frame: 0, frames: (0, 0), ..params.clone() };
    let footage = Footage { clip: &clip, masks: &[mask], motion: None };
    bake_onto(&still, &footage, texels, &params, stage)
}

/// A material by the three planes.
fn repeated(texels: &Texels, picture: &RgbImage, width: f32) -> Result<Vec<Vec3>> {
    let (w, h) = picture.dimensions();
    if w == 0 || h == 0 {
        return Err(Error::invalid("the material", "is an empty picture", "give a picture"));
    }
    if !(width.is_finite() && width > 0.0) {
        return Err(Error::invalid("the material's width", format!("is {width}"), "give world units above 0"));
    }
    let scale = w as f32 / width;
    let at = |p: Vec2| {
        let (x, y) = (p.x * scale - 0.5, -p.y * scale - 0.5);
        let (low_x, low_y) = (x.floor(), y.floor());
        let texel = |dx: i64, dy: i64| {
            let x = (low_x as i64 + dx).rem_euclid(i64::from(w)) as u32;
            let y = (low_y as i64 + dy).rem_euclid(i64::from(h)) as u32;
            Vec3::from(picture.get_pixel(x, y).0.map(f32::from))
        };
        let (fx, fy) = (x - low_x, y - low_y);
        texel(0, 0).lerp(texel(1, 0), fx).lerp(texel(0, 1).lerp(texel(1, 1), fx), fy)
    };
    let color = |(p, n): (&Vec3, &Vec3)| {
        let share = n.abs().map(|c| c.powi(FACING_POWER));
        (at(p.zy()) * share.x + at(p.xz()) * share.y + at(p.xy()) * share.z) / share.element_sum().max(1e-6)
    };
    Ok(texels.rest.par_iter().zip(&texels.normal).with_min_len(1024).map(color).collect())
}

/// Another creature's colours, and which texels have any: limbs without a counterpart have none.
fn from_creature(
    other: &RiggedModel,
    pairs: &[(String, String)],
    texels: &Texels,
    limbs: &Limbs,
    stage: Stage<'_>,
) -> Result<(Vec<Vec3>, Vec<bool>)> {
    other.validate()?;
    let sizes = other.parts.iter().map(|p| p.texture.dimensions()).collect();
    let source = Texels::new(other, sizes, stage.part(0.0, 0.3))?;
    let source_limbs = Limbs::new(other, &source);
    for (own, theirs) in pairs {
        if limbs.find(own).is_none() || source_limbs.find(theirs).is_none() {
            let which = if limbs.find(own).is_none() {
                format!("limb `{own}`")
            } else {
                format!("the other's limb `{theirs}`")
            };
            return Err(Error::invalid(which, "is not there", "name limbs that the creatures have"));
        }
    }
    let counterpart = |label: &str| {
        let listed = pairs.iter().find(|(own, _)| own == label).map_or(label, |(_, theirs)| theirs);
        source_limbs.find(listed)
    };
    let map: Vec<Option<usize>> = limbs.list.iter().map(|l| counterpart(&l.label)).collect();
    if map.iter().all(Option::is_none) {
        return Err(Error::invalid(
            "the creatures",
            "have no limb in common",
            "say which limb takes which one's colours",
        ));
    }
    // A creature that walks the other way is the mirror image in the picture.
    let turned = turned(limbs, &source_limbs, &map);
    let colors = colors_of(other, &source);
    let known = Known::new(&source.rest, &colors, |_| true);
    stage.at(0.4)?;
    let places: Vec<Option<(Vec3, f32)>> = (0..texels.len())
        .into_par_iter()
        .with_min_len(256)
        .map(|i| {
            let limb = usize::from(limbs.of_texel[i]);
            let (own, theirs) = (&limbs.list[limb], &source_limbs.list[map[limb]?]);
            let at = own.on(texels.rest[i]);
            let radius = theirs.radius(at.share);
            let mut off = at.off * (radius / own.radius(at.share));
            if turned {
                off.y = -off.y;
            }
            Some((theirs.place(OnLimb { share: at.share, off }), 4.0 + 2.0 * radius))
        })
        .collect();
    stage.at(0.6)?;
    let near: Vec<Option<Vec3>> =
        places.par_iter().with_min_len(256).map(|p| p.and_then(|(place, far)| known.near(place, far))).collect();
    stage.at(0.8)?;
    let missing: Vec<usize> = (0..near.len()).filter(|i| near[*i].is_none() && places[*i].is_some()).collect();
    let wanted: Vec<Vec3> = missing.iter().filter_map(|i| places[*i].map(|p| p.0)).collect();
    let mut out: Vec<Vec3> = near.iter().map(|c| c.unwrap_or(super::GREY)).collect();
    if let Some(filled) = borrowing::fill(&wanted, &known) {
        missing.iter().zip(filled).for_each(|(i, c)| out[*i] = c);
    }
    stage.at(1.0)?;
    Ok((out, places.iter().map(Option::is_some).collect()))
}

/// Whether the limbs of one creature stand the other way around in x than those of the other.
fn turned(own: &Limbs, other: &Limbs, map: &[Option<usize>]) -> bool {
    let pairs: Vec<(f32, f32)> =
        own.list.iter().zip(map).filter_map(|(l, m)| m.map(|m| (l.middle().x, other.list[m].middle().x))).collect();
    let n = pairs.len().max(1) as f32;
    let mean = pairs.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    pairs.iter().map(|p| (p.0 - mean.0) * (p.1 - mean.1)).sum::<f32>() < 0.0
}
