//! Textures of a rigged model from the frames of its clip.
//!
//! Reinert 2016, section 3.8 takes one frame, as blending frames blurs and shading changes. Here every texel takes one
//! frame too, but each the one that shows it best, with the key frame preferred (`candidates`); where two frames meet,
//! colours are levelled (`levelling`). What no frame shows takes what it should look like (`borrowing`). All is
//! done texel by texel on the posed surface (`texels`, `view`), so it works for tubes and for one skin alike, whatever
//! their charts.
//!
//! Limits: the light of the clip stays in the texture; a limb that is tracked wrongly in most frames, the key frame
//! included, gives wrong colours.

mod borrowing;
mod candidates;
mod levelling;
mod limbs;
#[cfg(test)]
mod tests;
mod texels;
mod transfer;
mod view;

pub use transfer::{Material, Region, transfer};

use glam::Vec3;
use image::{Rgb, RgbImage};
use rayon::prelude::*;

use self::borrowing::Known;
use self::candidates::{Candidates, Choice};
use self::limbs::{Limbs, label_of};
use self::texels::Texels;
use self::view::View;
use super::Creature;
use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::motion::Motion;
use crate::raster::{Grid, Mask, Wrap, push_pull};
use crate::shape::RiggedModel;

/// Frames that are drawn at the same time.
const TOGETHER: usize = 4;
/// The colour of a model that no frame shows at all.
const GREY: Vec3 = Vec3::splat(128.0);
/// Samples at least this good are lent to other places.
const LENT: u8 = 64;
/// Samples worse than this lie at the outline or are seen edge on, where a border that is a pixel off, or the clip's
/// coarser colour channels, bring in the background. They are dropped where a good one within this many world units has
/// another colour by this many levels. Depth counts less: at the outline the surface runs away from the viewer.
const WEAK: u8 = 110;
const WEAK_REACH: f32 = 8.0;
const WEAK_DEPTH: f32 = 0.2;
const WEAK_DIFFERENCE: f32 = 10.0;
/// A limb that the tracker does not trust at all still counts this much.
const LEAST_TRUST: f32 = 0.15;
/// How far texels of a chart are continued around it, so that a renderer that reads between texels, or a smaller size of
/// the texture, sees no other chart.
const GUTTER: usize = 4;
/// Keeps corrections near 0 where the key frame is far: they fade over about 1 / sqrt(anchor) texels.
const LEVEL_ANCHOR: f32 = 1e-4;
const LEVEL_ROUNDS: usize = 80;
const SMOOTH_ANCHOR: f32 = 1e-3;
const SMOOTH_ROUNDS: usize = 40;

/// What the colours come from.
#[derive(Clone, Copy, Debug)]
pub struct Footage<'a> {
    /// The clip.
    pub clip: &'a Clip,
    /// One mask a frame of the model's animation.
    pub masks: &'a [Mask],
    /// The limbs over time, for how far the tracker trusts each in each frame.
    pub motion: Option<&'a Motion>,
}

/// Parameters of [`bake`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BakeParams {
    /// The frame whose colours are preferred where it shows them.
    pub key_frame: usize,
    /// The first and the last frame that may give colours.
    pub frames: (usize, usize),
    /// At most so many frames are looked at, evenly spread.
    pub max_views: usize,
    /// Texels along a pixel of the clip. 0 keeps the size of the textures.
    pub density: f32,
    /// Longest side of a texture in texels.
    pub max_side: u32,
    /// What the key frame is preferred by: another frame must show a texel this many times better (as a natural
    /// logarithm) to be taken instead.
    pub key_bonus: f32,
    /// Whether what no frame shows may look like the other limb of its pair or like its own other side.
    pub borrow: bool,
    /// Pairs of limbs, by label.
    pub twins: Vec<(String, String)>,
}

impl Default for BakeParams {
    fn default() -> Self {
        Self {
            key_frame: 0,
            frames: (0, usize::MAX),
            max_views: 64,
            density: 1.0,
            max_side: 2048,
            key_bonus: 2.5,
            borrow: true,
            twins: Vec::new(),
        }
    }
}

impl BakeParams {
    /// The defaults for a creature: its rest frame is the key frame, its pairs are pairs.
    pub fn of(creature: &Creature) -> Self {
        let label = |l: usize| creature.limbs.get(l).map(|limb| limb.label.clone());
        let pair = |l: usize| {
            let twin = creature.limbs[l].twin.filter(|t| *t > l)?;
            Some((label(l)?, label(twin)?))
        };
        let twins = (0..creature.limbs.len()).filter_map(pair).collect();
        let last = creature.model.animation.len().saturating_sub(1);
        Self { key_frame: creature.rest_frame.min(last), twins, ..Self::default() }
    }
}

/// Makes the textures of all parts anew from the footage. The texture coordinates stay; the size may change.
///
/// # Errors
/// A model that is not valid, footage of another size or length, no frame in range with a mask, parameters that are no
/// numbers, or a cancel. The model is then as it was.
pub fn bake(model: &mut RiggedModel, footage: &Footage<'_>, params: &BakeParams, stage: Stage<'_>) -> Result<()> {
    stage.name("texturing")?;
    check(model, footage, params)?;
    let sizes = if params.density > 0.0 {
        texels::sizes(model, params.density, params.max_side)
    } else {
        model.parts.iter().map(|p| p.texture.dimensions()).collect()
    };
    let texels = Texels::new(model, sizes, stage.part(0.0, 0.1))?;
    let colors = bake_onto(model, footage, &texels, params, stage.part(0.1, 0.95))?;
    let textures = paint(&texels, &colors);
    stage.at(1.0)?;
    model.parts.iter_mut().zip(textures).for_each(|(p, t)| p.texture = t);
    Ok(())
}

/// The colours of all texels from the footage.
fn bake_onto(
    model: &RiggedModel,
    footage: &Footage<'_>,
    texels: &Texels,
    params: &BakeParams,
    stage: Stage<'_>,
) -> Result<Vec<Vec3>> {
    let frames = check(model, footage, params)?;
    let candidates = collect(model, footage, &frames, texels, stage.part(0.0, 0.7))?;
    let mut choice = candidates.choose(texels, params.key_bonus, stage.part(0.7, 0.75))?;
    drop_strays(texels, &mut choice);
    let mut colors = levelled(texels, &candidates, &choice, frames[0] as u16, stage.part(0.75, 0.85))?;
    complete(model, texels, &choice, &mut colors, params, stage.part(0.85, 1.0))?;
    Ok(colors)
}

/// The colours that the textures have now.
fn colors_of(model: &RiggedModel, texels: &Texels) -> Vec<Vec3> {
    let of = |t: &texels::Texel| {
        let texture = &model.parts[usize::from(t.part)].texture;
        let (w, at) = (texture.width(), t.at);
        Vec3::from(texture.get_pixel(at % w, at / w).0.map(f32::from))
    };
    texels.list.iter().map(of).collect()
}

/// Checks what [`bake`] was given; the frames to look at, the key frame first.
fn check(model: &RiggedModel, footage: &Footage<'_>, params: &BakeParams) -> Result<Vec<usize>> {
    model.validate()?;
    let info = footage.clip.info();
    if (info.width, info.height) != model.size {
        return Err(Error::invalid(
            "the clip",
            format!("is {}x{}, the model's was {}x{}", info.width, info.height, model.size.0, model.size.1),
            "give the clip that the model was made from",
        ));
    }
    let count = model.animation.len();
    if footage.masks.len() != count || info.frames < count {
        return Err(Error::invalid(
            "the footage",
            format!("has {} masks and {} frames for {count} frames of animation", footage.masks.len(), info.frames),
            "give the clip that the model was made from and one mask a frame",
        ));
    }
    let size = (info.width as usize, info.height as usize);
    if let Some(f) = footage.masks.iter().position(|m| (m.width(), m.height()) != size) {
        return Err(Error::invalid(format!("mask {f}"), "is not of the clip's size", "give masks of the clip's size"));
    }
    if !params.density.is_finite() || params.density < 0.0 || !params.key_bonus.is_finite() || params.max_side == 0 {
        return Err(Error::invalid("the parameters of texturing", "are out of range", "give numbers of 0 and above"));
    }
    if params.key_frame >= count {
        return Err(Error::invalid(
            format!("key frame {}", params.key_frame),
            format!("the model has {count} frames"),
            "frames count from 0",
        ));
    }
    let shown = |f: &usize| footage.masks[*f].count() > 0;
    let last = params.frames.1.min(count - 1);
    let usable: Vec<usize> = (params.frames.0..=last).filter(shown).collect();
    let Some(&first) = usable.first() else {
        return Err(Error::invalid(
            format!("frames {} to {last}", params.frames.0),
            "show nothing of the creature: their masks are empty",
            "choose frames with a mask",
        ));
    };
    // A range without the key frame has its own: the frame nearest to it.
    let key = usable.iter().copied().min_by_key(|f| f.abs_diff(params.key_frame)).unwrap_or(first);
    let views = params.max_views.clamp(1, usable.len());
    let mut out = vec![key];
    let spread = (0..views).map(|n| usable[n * usable.len() / views]);
    out.extend(spread.filter(|f| *f != key));
    out.truncate(views);
    Ok(out)
}

/// Looks at all frames, a few at a time.
fn collect(
    model: &RiggedModel,
    footage: &Footage<'_>,
    frames: &[usize],
    texels: &Texels,
    stage: Stage<'_>,
) -> Result<Candidates> {
    let key = View::new(model, footage, frames[0])?;
    let sharp = key.sharpness();
    let mut out = Candidates::new(frames[0], &key.samples(texels, 1.0));
    for (n, some) in frames[1..].chunks(TOGETHER).enumerate() {
        stage.at((n * TOGETHER + 1) as f64 / frames.len() as f64)?;
        let views: Vec<View> = some
            .par_iter()
            .map(|&f| {
                stage.at(0.0)?;
                View::new(model, footage, f)
            })
            .collect::<Result<_>>()?;
        for view in views {
            stage.at(0.0)?;
            let weight = if sharp > 0.0 { (view.sharpness() / sharp).clamp(0.25, 1.0) } else { 1.0 };
            out.add(view.frame, &view.samples(texels, weight));
        }
    }
    stage.at(1.0)?;
    Ok(out)
}

/// How far each bone's limb is trusted in a frame.
fn frame_trust(model: &RiggedModel, motion: Option<&Motion>, frame: usize) -> Vec<f32> {
    let of = |name: &str| {
        let confidence = &motion?.track(label_of(name))?.frames.get(frame)?.confidence;
        let mean = confidence.iter().sum::<f32>() / confidence.len().max(1) as f32;
        Some(mean.clamp(LEAST_TRUST, 1.0))
    };
    model.bones.iter().map(|b| of(&b.name).unwrap_or(1.0)).collect()
}

/// Takes back weak samples that do not look like the good ones beside them.
fn drop_strays(texels: &Texels, choice: &mut Choice) {
    let flat: Vec<Vec3> = texels.rest.iter().map(|p| p.with_z(p.z * WEAK_DEPTH)).collect();
    let good = Known::new(&flat, &choice.color, |i| choice.quality[i] >= WEAK);
    let stray = |i: usize| {
        let weak = choice.frame[i] != Choice::NONE && choice.quality[i] < WEAK;
        let off = |c: Vec3| (c - choice.color[i]).abs().element_sum() / 3.0 > WEAK_DIFFERENCE;
        weak && good.near(flat[i], WEAK_REACH).is_some_and(off)
    };
    let strays: Vec<bool> = (0..texels.len()).into_par_iter().with_min_len(256).map(stray).collect();
    for i in (0..strays.len()).filter(|i| strays[*i]) {
        choice.frame[i] = Choice::NONE;
        choice.quality[i] = 0;
    }
}

/// The colours taken, with those of other frames brought to what the key frame shows beside them.
fn levelled(
    texels: &Texels,
    candidates: &Candidates,
    choice: &Choice,
    key: u16,
    stage: Stage<'_>,
) -> Result<Vec<Vec3>> {
    let free: Vec<bool> = choice.frame.iter().map(|f| *f != Choice::NONE && *f != key).collect();
    let step = |i: usize, j: usize| {
        let (own, other) = (choice.frame[i], choice.frame[j]);
        if other == Choice::NONE {
            return None;
        }
        if own == other {
            return Some(Vec3::ZERO);
        }
        // What both frames show at one of the two texels says how far they differ; else what they show side by side,
        // unless one of them is mixed with the background.
        let at_own = candidates.shown(i, other, WEAK).map(|c| c - choice.color[i]);
        let at_other = candidates.shown(j, own, WEAK).map(|c| choice.color[j] - c);
        match (at_own, at_other) {
            (Some(a), Some(b)) => Some((a + b) / 2.0),
            (Some(a), None) | (None, Some(a)) => Some(a),
            (None, None) if choice.quality[i].min(choice.quality[j]) < WEAK => None,
            (None, None) => Some(choice.color[j] - choice.color[i]),
        }
    };
    let corrections = levelling::level(texels, &free, step, LEVEL_ANCHOR, LEVEL_ROUNDS, stage)?;
    Ok(choice.color.iter().zip(corrections).map(|(c, d)| (*c + d).clamp(Vec3::ZERO, Vec3::splat(255.0))).collect())
}

/// Colours for all texels that no frame shows.
fn complete(
    model: &RiggedModel,
    texels: &Texels,
    choice: &Choice,
    colors: &mut [Vec3],
    params: &BakeParams,
    stage: Stage<'_>,
) -> Result<()> {
    let seen: Vec<bool> = choice.frame.iter().map(|f| *f != Choice::NONE).collect();
    let mut unknown: Vec<u32> = (0..texels.len() as u32).filter(|i| !seen[*i as usize]).collect();
    let mut borrowed = Vec::new();
    if params.borrow {
        let limbs = Limbs::new(model, texels);
        let twins: Vec<Option<usize>> = limbs
            .list
            .iter()
            .map(|l| {
                let other = |(a, b): &(String, String)| match (*a == l.label, *b == l.label) {
                    (true, _) => limbs.find(b),
                    (_, true) => limbs.find(a),
                    _ => None,
                };
                params.twins.iter().find_map(other)
            })
            .collect();
        let lent = Known::new(&texels.rest, colors, |i| choice.quality[i] >= LENT);
        for step in 0..3 {
            stage.at(0.2 * f64::from(step))?;
            borrowed.extend(borrowing::borrow(texels, &limbs, &twins, &lent, &mut unknown, step as usize));
        }
    }
    let mut known = seen;
    for (i, c) in borrowed {
        colors[i as usize] = c;
        known[i as usize] = true;
    }
    stage.at(0.6)?;
    let places: Vec<Vec3> = unknown.iter().map(|i| texels.rest[*i as usize]).collect();
    let filled = borrowing::fill(&places, &Known::new(&texels.rest, colors, |i| known[i]));
    let filled = filled.unwrap_or_else(|| vec![GREY; places.len()]);
    unknown.iter().zip(filled).for_each(|(i, c)| colors[*i as usize] = c);
    // What was filled runs smoothly into what is known, and over seams.
    let free: Vec<bool> = known.iter().map(|k| !k).collect();
    let step = |i: usize, j: usize| Some(colors[j] - colors[i]);
    let smooth = levelling::level(texels, &free, step, SMOOTH_ANCHOR, SMOOTH_ROUNDS, stage.part(0.7, 1.0))?;
    colors.iter_mut().zip(smooth).for_each(|(c, d)| *c += d);
    Ok(())
}

/// The textures, with what lies between their charts filled.
fn paint(texels: &Texels, colors: &[Vec3]) -> Vec<RgbImage> {
    let of = |number: &Grid<u32>| {
        let (w, h) = (number.width(), number.height());
        let mut known = Grid::from_vec(w, h, number.data().iter().map(|n| *n != Texels::NONE).collect());
        let color = |n: &u32| if *n == Texels::NONE { [0.0; 3] } else { colors[*n as usize].to_array() };
        let mut out: Vec<[f32; 3]> = number.data().iter().map(color).collect();
        for _ in 0..GUTTER {
            grow(&mut out, &mut known);
        }
        push_pull(&mut out, &known, Wrap::default(), GREY.to_array());
        RgbImage::from_fn(w as u32, h as u32, |x, y| {
            Rgb(out[y as usize * w + x as usize].map(|v| v.round().clamp(0.0, 255.0) as u8))
        })
    };
    texels.number.par_iter().map(of).collect()
}

/// Continues what is known by one texel: the mean of the known ones around.
fn grow(color: &mut [[f32; 3]], known: &mut Grid<bool>) {
    let (w, h) = (known.width() as isize, known.height() as isize);
    let before = known.clone();
    for y in 0..h {
        for x in 0..w {
            if before.get(x as usize, y as usize) {
                continue;
            }
            let (mut sum, mut count) = (Vec3::ZERO, 0.0);
            for (dx, dy) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
                let (sx, sy) = (x + dx, y + dy);
                if sx >= 0 && sy >= 0 && sx < w && sy < h && before.get(sx as usize, sy as usize) {
                    sum += Vec3::from(color[(sy * w + sx) as usize]);
                    count += 1.0;
                }
            }
            if count > 0.0 {
                color[(y * w + x) as usize] = (sum / count).to_array();
                known.set(x as usize, y as usize, true);
            }
        }
    }
}
