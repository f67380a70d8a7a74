//! A creature from tracked strokes and masks: generalized cylinders around the limbs, textured, on a bone hierarchy.
//! Source: Reinert, Ritschel, Seidel, "Animated 3D Creatures from Single-view Video by Skeletal Sketching", 2016.

mod axis;
mod bones;
mod chain;
mod creature_limb;
mod driving;
mod edit;
mod fringe;
mod limb;
mod motion;
mod params;
mod path;
mod pose_keys;
mod posing;
mod radius;
mod refine;
mod reposing;
mod settling;
mod skin;
mod strain;
mod texture;
pub mod texturing;
mod tube;

#[cfg(test)]
mod posing_tests;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

pub use creature_limb::{CreatureLimb, Hold};
pub use driving::DriveParams;
pub use edit::{EditKind, EditedMesh, apply_edit};
pub use params::{CreatureParams, CrossSection, LegSpread, Surface};
pub use pose_keys::{PoseKey, PoseKeys};
pub use posing::{LimbPose, PoseParams};
pub use settling::SettledPose;
pub use strain::LimbStrain;

use self::axis::Axis;
use self::limb::LimbShape;
use self::texturing::{BakeParams, Footage};
use super::{RiggedModel, SkinnedPart};
use crate::clip::{Clip, FrameImage};
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::motion::Motion;
use crate::raster::{Grid, Mask};
use crate::rig::{LimbChain, Rig, Side, Skeleton};
use crate::segment::{label_limbs_by_depth, limb_sides};

/// Shortest side of the paper's working resolution, which its pixel constants are for.
const PAPER_SIZE: f32 = 512.0;
/// Depth over width of a limb in the middle that hangs from another, as a share of a body's.
const BRANCH: f32 = 0.8;

/// A reconstructed creature.
#[derive(Clone, Debug, PartialEq)]
pub struct Creature {
    /// Textured meshes on animated bones.
    pub model: RiggedModel,
    /// Which bones carry which limb, in the rig's order. Empty where that is not known, as of a file that another
    /// program wrote.
    pub limbs: Vec<CreatureLimb>,
    /// The frame that gave the rest pose and the colours: the first key frame.
    pub rest_frame: usize,
}

impl From<RiggedModel> for Creature {
    /// A model of which no limb is known.
    fn from(model: RiggedModel) -> Self {
        Self { model, limbs: Vec::new(), rest_frame: 0 }
    }
}

impl Creature {
    /// Checks the model ([`RiggedModel::validate`]), and that every limb's bones, parent and twin are there.
    pub fn validate(&self) -> Result<()> {
        self.model.validate()?;
        for (l, limb) in self.limbs.iter().enumerate() {
            let bad = |problem: &str| {
                Err(Error::invalid(format!("limb `{}`", limb.label), problem, "build the creature anew"))
            };
            if limb.bones < 2 || limb.first_bone.saturating_add(limb.bones) > self.model.bones.len() {
                return bad("has bones that are not there");
            }
            let linked = [limb.parent.map(|p| p.limb), limb.twin];
            if linked.into_iter().flatten().any(|other| other == l || other >= self.limbs.len()) {
                return bad("hangs from or pairs with a limb that is not there");
            }
            let real = [limb.length, limb.radius, limb.offset].iter().all(|v| v.is_finite());
            let mut moved =
                limb.settled_poses.iter().flat_map(|p| p.stroke.iter().chain(&p.moved)).chain(&limb.settled);
            if !(real && moved.all(|v| v.is_finite())) {
                return bad("holds something that is no number");
            }
            let bones = limb.settled.len();
            if limb.settled_poses.iter().any(|p| (p.stroke.len(), p.moved.len()) != (bones, bones)) {
                return bad("has settled poses of another number of bones");
            }
        }
        // A chain of parents longer than there are limbs goes round.
        let up = |l: usize| self.limbs[l].parent.map(|p| p.limb);
        if (0..self.limbs.len()).any(|l| std::iter::successors(Some(l), |l| up(*l)).nth(self.limbs.len()).is_some()) {
            return Err(Error::invalid("the creature", "has limbs that hang in a circle", "build the creature anew"));
        }
        Ok(())
    }
}

/// Reconstructs the creature that `rig` marks in `clip`, from its limbs over time (`motion`: one track a limb, by
/// label) and one mask a frame.
///
/// # Errors
/// When the rig or the motion does not fit the clip, masks are missing or of another size, or the work is cancelled.
pub fn reconstruct(
    clip: &Clip,
    rig: &Rig,
    motion: &Motion,
    masks: &[Mask],
    params: &CreatureParams,
    stage: Stage<'_>,
) -> Result<Creature> {
    let info = clip.info();
    let size = (info.width, info.height);
    rig.validate(Some((size, info.frames)))?;
    check(rig, motion, masks, size)?;
    if let Some((label, _)) = params.depths.iter().find(|(label, _)| rig.limbs.iter().all(|l| l.label != *label)) {
        return Err(Error::invalid(format!("depth of `{label}`"), "is of no limb", "name a limb of the rig"));
    }
    stage.name("fitting")?;
    let frames = motion.frames;
    let rest = rig.keyframes.iter().find(|k| !k.strokes.is_empty()).map_or(0, |k| k.frame).min(frames - 1);
    let skeleton = Skeleton::new(rig, 10.0);
    let mut axes = axes(rig, motion, &skeleton, params)?;
    let twins: Vec<Option<usize>> = (0..rig.limbs.len()).map(|l| rig.twin(l)).collect();
    let labels = label_all(rig, motion, masks, stage.part(0.0, 0.3))?;
    let min_vote = params.min_vote * paper_scale(size);
    let strokes = axes.clone();
    let votes = radius::vote(&axes, &labels, min_vote, stage.part(0.3, 0.35))?;
    let parents: Vec<Option<usize>> = skeleton.limbs.iter().map(|c| c.parent).collect();
    let mut radii = radius::fit(&axes, &votes, &twins, &parents, params);
    for round in 0..params.settling_rounds {
        let fraction = 0.35 + 0.2 * f64::from(round) / f64::from(params.settling_rounds);
        for (l, axis) in axes.iter_mut().enumerate() {
            stage.at(fraction)?;
            refine::settle(axis, l, &radii[l], skeleton.limbs[l].terminal, &labels, params.settling_stiffness);
        }
        let votes = radius::vote(&axes, &labels, min_vote, stage.part(fraction, fraction))?;
        radii = radius::fit(&axes, &votes, &twins, &parents, params);
    }
    for (l, r) in radii.iter_mut().enumerate() {
        let keys: Vec<usize> = rig.keys_of(l).map(|(f, _)| f).collect();
        radius::hold_inside(r, &axes[l], &keys, masks, min_vote);
    }
    stage.at(0.58)?;
    let mut limbs: Vec<LimbShape> = axes
        .into_iter()
        .zip(radii)
        .enumerate()
        .map(|(l, (axis, radii))| shape_limb(rig, &skeleton, l, axis, radii, twins[l], params))
        .collect();
    find_trunks(&mut limbs, &skeleton);
    if let CrossSection::Ratio { middle, .. } = params.cross_section {
        flatten_branches(&mut limbs, middle, params);
    }
    let order = root_first(&limbs, |l| l.parent);
    place_in_depth(&mut limbs, &order, rig, params);
    let mut bones = bones::lay(&limbs, &order, frames, params.max_bones);
    stage.name("texturing")?;
    let picture = clip.frame(rest)?;
    let parts = match params.surface {
        Surface::Tubes => build_parts(&limbs, &bones, rest, &picture.rgb, masks, params, stage.part(0.6, 0.7))?,
        Surface::Skin => {
            let keys: Vec<usize> = rig.keyframes.iter().map(|k| k.frame).filter(|f| *f < frames).collect();
            let tubes: Vec<tube::Tube> = limbs.par_iter().map(|l| tube::tube(l, rest, params.around)).collect();
            let front = texture::visibility(tubes.iter().map(|t| &t.mesh), size);
            let scale = paper_scale(size);
            let sheets = if params.fill_silhouette {
                fringe::lattices(
                    &limbs,
                    rest,
                    masks,
                    &front,
                    params.patch_step.max(0.5) * scale,
                    stage.part(0.6, 0.62),
                )?
            } else {
                limbs.iter().map(|_| None).collect()
            };
            let source = skin::Source {
                order: &order,
                max_bones: params.max_bones,
                rest,
                keys: &keys,
                masks,
                image: &picture.rgb,
                sheets: &sheets,
                triangles: params.skin_triangles,
            };
            vec![skin::skin(&mut limbs, &mut bones, &source, stage.part(0.62, 0.7))?]
        }
    };
    let finished = finished_limbs(&limbs, &strokes, &bones, &skeleton);
    let model = RiggedModel {
        size,
        fps: motion.fps,
        rest: bones.animation[rest].clone(),
        bones: bones.bones,
        animation: bones.animation,
        parts,
    };
    let mut creature = Creature { model, limbs: finished, rest_frame: rest };
    if params.texture_views > 1 && masks.iter().any(|m| m.count() > 0) {
        let bake =
            BakeParams { max_views: params.texture_views, max_side: params.max_texture, ..BakeParams::of(&creature) };
        let footage = Footage { clip, masks, motion: Some(motion) };
        texturing::bake(&mut creature.model, &footage, &bake, stage.part(0.7, 1.0))?;
    }
    stage.at(1.0)?;
    Ok(creature)
}

fn check(rig: &Rig, motion: &Motion, masks: &[Mask], size: (u32, u32)) -> Result<()> {
    motion.validate()?;
    if motion.frames == 0 {
        return Err(Error::invalid("motion", "has no frame", "track the limbs over at least one frame"));
    }
    if motion.size != size {
        return Err(Error::invalid(
            "motion",
            format!("is of a clip of {}x{}", motion.size.0, motion.size.1),
            format!("this clip is {}x{}", size.0, size.1),
        ));
    }
    if masks.len() != motion.frames {
        return Err(Error::invalid(
            "masks",
            format!("there are {} for {} frames", masks.len(), motion.frames),
            "give one mask a frame",
        ));
    }
    if let Some(f) = masks.iter().position(|m| (m.width(), m.height()) != (size.0 as usize, size.1 as usize)) {
        return Err(Error::invalid(format!("mask {f}"), "is not of the clip's size", "give masks of the clip's size"));
    }
    if let Some(limb) = rig.limbs.iter().find(|l| motion.track(&l.label).is_none()) {
        return Err(Error::invalid(format!("limb `{}`", limb.label), "has no track", "track every limb of the rig"));
    }
    Ok(())
}

/// The axes of all limbs, from the root outward.
fn axes(rig: &Rig, motion: &Motion, skeleton: &Skeleton, params: &CreatureParams) -> Result<Vec<Axis>> {
    rig.limbs
        .iter()
        .zip(&skeleton.limbs)
        .map(|(limb, chain)| {
            let track = motion
                .track(&limb.label)
                .ok_or_else(|| Error::invalid(format!("limb `{}`", limb.label), "has no track", "track every limb"))?;
            Ok(Axis::new(track, !chain.rooted_at_start, params.extension))
        })
        .collect()
}

/// Which limb every pixel of every frame belongs to.
fn label_all(rig: &Rig, motion: &Motion, masks: &[Mask], stage: Stage<'_>) -> Result<Vec<Grid<u16>>> {
    let sides = limb_sides(rig);
    let done = std::sync::atomic::AtomicUsize::new(0);
    (0..masks.len())
        .into_par_iter()
        .map(|f| {
            let n = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            stage.at(n as f64 / masks.len() as f64)?;
            let strokes: Vec<Vec<glam::Vec2>> = rig
                .limbs
                .iter()
                .map(|l| motion.track(&l.label).map_or_else(Vec::new, |t| t.frames[f].points.clone()))
                .collect();
            Ok(label_limbs_by_depth(&masks[f], &strokes, &sides))
        })
        .collect()
}

fn shape_limb(
    rig: &Rig,
    skeleton: &Skeleton,
    l: usize,
    axis: Axis,
    radii: radius::Radii,
    twin: Option<usize>,
    params: &CreatureParams,
) -> LimbShape {
    let chain = &skeleton.limbs[l];
    let ends = root_and_tip;
    let own = ends(chain);
    let parent = chain.parent.map(|p| (p, ends(&skeleton.limbs[p]).1 == own.0));
    let shared =
        |v: Option<usize>| skeleton.limbs.iter().enumerate().any(|(o, c)| o != l && (ends(c).0 == v || ends(c).1 == v));
    let label = rig.limbs[l].label.clone();
    let wanted = params.depths.iter().find(|(name, _)| *name == label).map(|(_, r)| *r);
    let ratio = |i: usize| {
        let (left, right) = (radii.left[i].max(1e-3), radii.right[i].max(1e-3));
        match (wanted, params.cross_section) {
            (Some(r), _) => r.clamp(0.05, 20.0),
            (None, CrossSection::Ratio { middle, paired }) => {
                let is_paired = matches!(rig.limbs[l].side, Some(Side::Near | Side::Far));
                if is_paired { paired } else { middle }.clamp(0.05, 20.0)
            }
            (None, CrossSection::Paper) => 0.5 + 0.5 * left.min(right) / left.max(right),
        }
    };
    let depth_ratio = (0..axis.samples()).map(ratio).collect();
    let facing = path::facing_over_time(rig, l, !chain.rooted_at_start, axis.frames.len());
    let rises = path::rises(&axis, &facing, params.foreshortened);
    let still = vec![0.0; axis.frames.len()];
    LimbShape {
        label,
        side: rig.limbs[l].side,
        twin,
        parent,
        trunk: None,
        joined: (shared(own.0), shared(own.1)),
        z: Vec::new(),
        rise: path::eased(rises, &rig.depth_keys(l, |d| d.bend)),
        depth: path::eased(still, &rig.depth_keys(l, |d| d.depth)),
        axis,
        radii,
        depth_ratio,
        clip_height: rig.size.1 as f32,
        offset: 0.0,
    }
}

/// Finds what each limb is part of: the thickest limb at the joint where it begins, unless that is itself. The skeleton's
/// root may lie on a tail or a leg, so its parents say nothing of what carries what.
fn find_trunks(limbs: &mut [LimbShape], skeleton: &Skeleton) {
    let ends: Vec<(Option<usize>, Option<usize>)> = skeleton.limbs.iter().map(root_and_tip).collect();
    for l in 0..limbs.len() {
        let own = limbs[l].mean_radius();
        let beside = (0..limbs.len())
            .filter(|&o| o != l && Some(o) != limbs[l].twin && (ends[o].0 == ends[l].0 || ends[o].1 == ends[l].0));
        let thickest = beside
            .map(|o| (limbs[o].mean_radius(), o))
            .filter(|(r, _)| *r > own)
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        limbs[l].trunk = thickest.map(|(_, o)| (o, ends[o].1 == ends[l].0));
    }
    // A limb that is the thickest at its joint hangs from its parent, where that does not hang from it.
    for l in 0..limbs.len() {
        if limbs[l].trunk.is_some() {
            continue;
        }
        let mut at = limbs[l].parent;
        let mut steps = 0;
        while let Some((p, _)) = at.filter(|(p, _)| *p != l && steps <= limbs.len()) {
            at = limbs[p].trunk;
            steps += 1;
        }
        if at.is_none() {
            limbs[l].trunk = limbs[l].parent;
        }
    }
}

/// The vertices of a chain at the root and away from it.
fn root_and_tip(chain: &LimbChain) -> (Option<usize>, Option<usize>) {
    let (first, last) = (chain.vertices.first().copied(), chain.vertices.last().copied());
    if chain.rooted_at_start { (first, last) } else { (last, first) }
}

/// Limbs in the middle that hang from another (necks, heads, tails) are flatter than bodies.
fn flatten_branches(limbs: &mut [LimbShape], middle: f32, params: &CreatureParams) {
    for limb in limbs {
        let chosen = params.depths.iter().any(|(name, _)| *name == limb.label);
        let paired = matches!(limb.side, Some(Side::Near | Side::Far));
        if limb.trunk.is_some() && !paired && !chosen {
            limb.depth_ratio.fill((middle * BRANCH).clamp(0.05, 20.0));
        }
    }
}

/// The limbs, parents before children.
fn root_first(limbs: &[LimbShape], parent: impl Fn(&LimbShape) -> Option<(usize, bool)>) -> Vec<usize> {
    let mut order: Vec<usize> = Vec::with_capacity(limbs.len());
    while order.len() < limbs.len() {
        let before = order.len();
        for l in 0..limbs.len() {
            if !order.contains(&l) && parent(&limbs[l]).is_none_or(|(p, _)| order.contains(&p)) {
                order.push(l);
            }
        }
        if order.len() == before {
            break;
        }
    }
    order
}

/// What posing will need of the limbs.
fn finished_limbs(
    limbs: &[LimbShape],
    strokes: &[Axis],
    bones: &bones::Bones,
    skeleton: &Skeleton,
) -> Vec<CreatureLimb> {
    limbs
        .iter()
        .enumerate()
        .map(|(l, limb)| {
            let core = |axis: &Axis| -> Vec<Vec<glam::Vec2>> {
                axis.frames.iter().map(|points| points[axis.first..=axis.last].to_vec()).collect()
            };
            let count = bones.of_limb[l].len();
            let (settled, settled_poses) = settling::settled(&core(&strokes[l]), &core(&limb.axis), count);
            CreatureLimb {
                label: limb.label.clone(),
                side: limb.side,
                twin: limb.twin,
                parent: limb.parent.map(|(limb, at_end)| Hold { limb, at_end }),
                reversed: !skeleton.limbs[l].rooted_at_start,
                first_bone: bones.of_limb[l].first().copied().unwrap_or(0),
                bones: count,
                length: path::full_length(&limb.axis),
                radius: limb.mean_radius(),
                offset: limb.offset,
                settled,
                settled_poses,
            }
        })
        .collect()
}

/// Hangs limbs where their parents are in depth, and pairs on both sides of the middle.
fn place_in_depth(limbs: &mut [LimbShape], order: &[usize], rig: &Rig, params: &CreatureParams) {
    let depth_of = |limb: &LimbShape| {
        let ratio = limb.depth_ratio.iter().sum::<f32>() / limb.depth_ratio.len().max(1) as f32;
        limb.mean_radius() * ratio
    };
    for &l in order {
        let parent = limbs[l].parent;
        let body_depth = limbs[l].trunk.map_or(0.0, |(p, _)| depth_of(&limbs[p]));
        let offset = path::pair_offset(limbs[l].side, limbs[l].mean_radius_from(0.5), body_depth, params);
        let base: Vec<f32> = match parent {
            None => vec![0.0; limbs[l].axis.frames.len()],
            Some((p, at_end)) => {
                let at = if at_end { limbs[p].axis.last } else { limbs[p].axis.first };
                limbs[p].z.iter().map(|z| z[at]).collect()
            }
        };
        let limb = &mut limbs[l];
        limb.offset = offset;
        let depth = |frame: usize, i: usize| {
            let share = limb.axis.share(i as f32);
            let aside = offset * path::hip_ramp(share) + limb.depth[frame] * path::free_part(share, parent.is_some());
            path::bent(share, limb.rise[frame]) + (base[frame] + aside)
        };
        limb.z = (0..base.len()).map(|f| (0..limb.axis.samples()).map(|i| depth(f, i)).collect()).collect();
    }
    debug_assert_eq!(limbs.len(), rig.limbs.len());
}

/// Meshes, weights and textures of all limbs in the rest frame.
fn build_parts(
    limbs: &[LimbShape],
    bones: &bones::Bones,
    rest: usize,
    image: &FrameImage,
    masks: &[Mask],
    params: &CreatureParams,
    stage: Stage<'_>,
) -> Result<Vec<SkinnedPart>> {
    let tubes: Vec<tube::Tube> = limbs.par_iter().map(|l| tube::tube(l, rest, params.around)).collect();
    stage.at(0.2)?;
    let mut front = texture::visibility(tubes.iter().map(|t| &t.mesh), image.dimensions());
    let step = params.patch_step.max(0.5) * paper_scale(image.dimensions());
    let patches = if params.fill_silhouette {
        fringe::patches(limbs, rest, masks, &front, step, stage.part(0.2, 0.5))?
    } else {
        vec![None; limbs.len()]
    };
    stage.at(0.5)?;
    texture::add_visible(&mut front, patches.iter().map(|p| p.as_ref().map(|p| &p.mesh)));
    let view = texture::View { image, mask: &masks[rest], front: &front };
    let seen: Vec<texture::Unrolled> = limbs
        .par_iter()
        .enumerate()
        .map(|(l, limb)| {
            texture::project(limb, l as u16, rest, &view, texture::unrolled_size(limb, params.max_texture))
        })
        .collect();
    stage.at(0.7)?;
    let default = texture::mean_color(image, &masks[rest]);
    let parts = (0..limbs.len()).into_par_iter().map(|l| {
        let limb = &limbs[l];
        let mut unrolled = seen[l].clone();
        if let Some(twin) = limb.twin {
            texture::borrow(&mut unrolled, &seen[twin]);
        }
        texture::fill(&mut unrolled, default);
        let patch = patches[l].as_ref().map(|p| (p, texture::crop(p.bounds, l as u16, &view, default)));
        let (atlas, cylinder, sheet) = texture::atlas(&unrolled, patch.as_ref().map(|(_, c)| c));
        let mut mesh = tubes[l].mesh.clone();
        mesh.uvs.iter_mut().for_each(|uv| *uv = cylinder.place(*uv));
        let mut samples = tubes[l].samples.clone();
        if let (Some((patch, crop)), Some(sheet)) = (&patch, sheet) {
            let base = mesh.positions.len() as u32;
            mesh.positions.extend(&patch.mesh.positions);
            mesh.normals.extend(&patch.mesh.normals);
            mesh.uvs.extend(patch.mesh.uvs.iter().map(|p| sheet.place(crop.share(*p))));
            mesh.triangles.extend(patch.mesh.triangles.iter().map(|t| t.map(|i| i + base)));
            samples.extend(&patch.samples);
        }
        let (joints, weights) = bones::bind(limb, &samples, &bones.of_limb[l]);
        SkinnedPart { name: limb.label.clone(), mesh, bones: joints, weights, texture: atlas }
    });
    let parts = parts.collect();
    stage.at(1.0)?;
    Ok(parts)
}

/// How much larger this clip's pixels are than those of the paper's working size.
fn paper_scale((width, height): (u32, u32)) -> f32 {
    width.min(height) as f32 / PAPER_SIZE
}
