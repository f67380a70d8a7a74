//! One connected skin over all limbs.
//!
//! Method: the limbs, moved apart where they only touch ([`apart`]), are joined to one solid ([`body`]), whose surface is
//! bound to the bones ([`weights`]) and fitted to the silhouettes of all frames: single frames by moving the limbs
//! ([`posing`]), all together by moving the surface ([`silhouette`]). It gets one atlas ([`atlas`]).
//!
//! Limit: limbs that run through each other in the rest frame are cut apart, which may be seen when they part.

mod apart;
mod atlas;
mod body;
mod posing;
mod ring;
mod silhouette;
#[cfg(test)]
mod tests;
mod weights;

use glam::{Mat4, Vec3};

pub(super) use self::atlas::Atlas;
use self::ring::Neighbours;
pub(super) use self::ring::normals as surface_normals;
pub(super) use self::weights::four;
use super::bones::Bones;
use super::fringe::Lattice;
use super::limb::LimbShape;
use crate::clip::FrameImage;
use crate::error::Result;
use crate::geometry::{TriMesh, iso_surface};
use crate::job::Stage;
use crate::raster::{Mask, Rasterizer, Surface, clip_view};
use crate::shape::SkinnedPart;

/// What the skin is made of.
pub(super) struct Source<'a> {
    pub order: &'a [usize],
    pub max_bones: usize,
    pub rest: usize,
    pub keys: &'a [usize],
    pub masks: &'a [Mask],
    /// The rest frame.
    pub image: &'a FrameImage,
    pub sheets: &'a [Option<Lattice>],
    /// About how many triangles are wanted.
    pub triangles: usize,
}

/// More triangles than wanted by this share, and the skin is made anew of larger ones.
const OVER: f32 = 1.2;
/// No edge is shorter in clip pixels: masks know nothing smaller.
const SHORTEST: f32 = 1.0;

/// The grid's cell for about so many triangles. A surface crosses 1.5 of a grid's edges a cell of its area, on the mean of
/// all directions, and each crossing becomes two triangles.
fn cell_of(limbs: &[LimbShape], sheets: &[Option<Lattice>], triangles: usize) -> f32 {
    let tubes: f32 = limbs.iter().map(area).sum();
    let sheets: f32 = sheets.iter().flatten().map(|s| 2.0 * s.area()).sum();
    (3.0 * (tubes + sheets) / triangles.max(1) as f32).sqrt().max(SHORTEST)
}

/// About the area of a limb's cylinder: an ellipse's perimeter is nearly that of a circle of its mean square radius.
fn area(limb: &LimbShape) -> f32 {
    let around = |i: usize| {
        let (a, b) = (limb.half_width(i), limb.half_width(i) * limb.depth_ratio[i]);
        std::f32::consts::TAU * ((a * a + b * b) / 2.0).sqrt()
    };
    (limb.axis.first..=limb.axis.last).map(around).sum::<f32>() * limb.axis.spacing()
}

/// The skin in the rest pose, without colours.
///
/// Moves the limbs, and the bones with them, to meet the silhouettes of the frames.
pub(super) fn skin(
    limbs: &mut [LimbShape],
    bones: &mut Bones,
    source: &Source<'_>,
    stage: Stage<'_>,
) -> Result<SkinnedPart> {
    let Source { order, rest, masks, .. } = *source;
    let inward = super::root_first(limbs, |l| l.trunk);
    let mut cell = cell_of(limbs, source.sheets, source.triangles);
    let (apart, body, mut places, triangles) = loop {
        let apart = apart::apart(limbs, &inward, rest, 2.0 * cell);
        let body = body::body(&apart, source.sheets, cell, stage.part(0.0, 0.2))?;
        let (places, triangles) = iso_surface(&body.field, 0.0);
        stage.at(0.3)?;
        let over = triangles.len() as f32 / source.triangles.max(1) as f32;
        if over <= OVER {
            break (apart, body, places, triangles);
        }
        cell *= over.sqrt();
    };
    let ring = Neighbours::new(places.len(), &triangles);
    let binding = weights::bind(&places, &ring, &body, &apart, bones);
    let n = limbs.len();
    for (v, p) in places.iter_mut().enumerate() {
        for l in 0..n {
            let (w, s) = (binding.share[v * n + l], binding.sample[v * n + l]);
            if w > 0.0 && s.is_finite() {
                p.z += w * (limbs[l].place(rest, s).z - apart[l].place(0, s).z);
            }
        }
    }
    let fit = silhouette::Fit {
        triangles: &triangles,
        ring: &ring,
        binding: &binding,
        masks,
        rest,
        keys: source.keys,
        reach: 6.0 * cell,
    };
    fit.run(&mut places, limbs, order, bones, source.max_bones, stage.part(0.4, 1.0))?;
    let normals = ring::normals(&places, &triangles);
    let (mesh, atlas) = textured(&places, &normals, &triangles, &binding.limb, masks[rest].height() as f32);
    let pick = |v: &u32| *v as usize;
    let mut seen = Rasterizer::new(masks[rest].width() as u32, masks[rest].height() as u32);
    let view = clip_view(masks[rest].height() as u32);
    for chart in 0..atlas.charts() {
        let triangles = atlas.of_chart(chart);
        let part = TriMesh { positions: mesh.positions.clone(), triangles, ..TriMesh::default() };
        seen.draw(&part, &view, Surface::Bare, chart as u16);
    }
    let default = super::texture::mean_color(source.image, &masks[rest]);
    Ok(SkinnedPart {
        name: "skin".into(),
        bones: atlas.vertex.iter().map(|v| binding.bones[pick(v)]).collect(),
        weights: atlas.vertex.iter().map(|v| binding.weights[pick(v)]).collect(),
        texture: atlas.paint(source.image, &masks[rest], &seen.id, default),
        mesh,
    })
}

/// The surface with texture coordinates, and how it lies in the atlas. `limb` is the limb of each vertex.
pub(super) fn textured(
    places: &[Vec3],
    normals: &[Vec3],
    triangles: &[[u32; 3]],
    limb: &[u16],
    clip_height: f32,
) -> (TriMesh, Atlas) {
    let atlas = Atlas::new(places, triangles, limb, clip_height);
    let mesh = TriMesh {
        positions: atlas.vertex.iter().map(|v| places[*v as usize]).collect(),
        normals: atlas.vertex.iter().map(|v| normals[*v as usize]).collect(),
        uvs: atlas.uvs.clone(),
        triangles: atlas.triangles.clone(),
    };
    (mesh, atlas)
}

/// For each frame what each bone does to the rest pose.
fn skin_matrices(bones: &Bones, rest: usize) -> Vec<Vec<Mat4>> {
    let world = |local: &[crate::shape::Transform]| {
        let mut world: Vec<Mat4> = Vec::with_capacity(local.len());
        for (bone, transform) in bones.bones.iter().zip(local) {
            let matrix = transform.matrix();
            world.push(bone.parent.map_or(matrix, |p| world[p] * matrix));
        }
        world
    };
    let back: Vec<Mat4> = world(&bones.animation[rest]).into_iter().map(|m| m.inverse()).collect();
    bones.animation.iter().map(|a| world(a).into_iter().zip(&back).map(|(now, back)| now * *back).collect()).collect()
}
