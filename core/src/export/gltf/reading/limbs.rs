//! The limbs of a file's bones: as the file says, else as their names do (`limb.0`, `limb.1`, ... are a limb's chain).

use glam::{Mat4, Vec3};
use serde::Deserialize;

use crate::shape::RiggedModel;
use crate::shape::creature::{CreatureLimb, Hold};

/// What the scene says of itself beside the format, where we wrote it.
#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Said {
    pub(super) metres_per_pixel: Option<f64>,
    pub(super) clip: Option<SaidClip>,
    pub(super) rest_frame: Option<f64>,
    pub(super) limbs: Option<serde_json::Value>,
}

#[derive(Deserialize)]
pub(super) struct SaidClip {
    pub(super) size: [f64; 2],
    pub(super) fps: f64,
    pub(super) frames: f64,
}

/// The limbs whose chains are all there; by their names where the file says nothing that holds.
pub(super) fn limbs(model: &RiggedModel, said: Option<serde_json::Value>) -> Vec<CreatureLimb> {
    let named = by_names(model);
    let Some(Ok(mut limbs)) = said.map(serde_json::from_value::<Vec<CreatureLimb>>) else { return named };
    // Other programs may list the bones in another order.
    for limb in &mut limbs {
        let Some(found) = named.iter().find(|n| n.label == limb.label && n.bones == limb.bones) else { return named };
        limb.first_bone = found.first_bone;
    }
    limbs
}

fn by_names(model: &RiggedModel) -> Vec<CreatureLimb> {
    let part_of = |bone: usize| {
        let (limb, number) = model.bones[bone].name.rsplit_once('.')?;
        Some((limb, number.parse::<usize>().ok()?))
    };
    let mut chains: Vec<(String, usize, usize)> = Vec::new();
    for bone in 0..model.bones.len() {
        match (part_of(bone), chains.last_mut()) {
            (Some((limb, number)), Some((label, first, count)))
                if limb == label && number == *count && *first + number == bone =>
            {
                *count += 1;
            }
            (Some((limb, 0)), _) => chains.push((limb.to_owned(), bone, 1)),
            _ => {}
        }
    }
    chains.retain(|(_, _, count)| *count >= 2);
    let world: Vec<Vec3> = model.world(&model.rest).iter().map(|m: &Mat4| m.w_axis.truncate()).collect();
    let limb = |(label, first, count): &(String, usize, usize)| {
        let places = &world[*first..first + count];
        let parent = model.bones[*first].parent.and_then(|bone| {
            let holder = chains.iter().position(|(_, f, n)| (*f..f + n).contains(&bone))?;
            let (_, f, n) = &chains[holder];
            Some(Hold { limb: holder, at_end: bone + 1 == f + n })
        });
        let length = places.windows(2).map(|w| w[0].distance(w[1])).sum();
        CreatureLimb {
            label: label.clone(),
            side: None,
            twin: None,
            parent,
            reversed: false,
            first_bone: *first,
            bones: *count,
            length,
            radius: radius(model, &world, *first..first + count),
            offset: parent.map_or(0.0, |_| places[count - 1].z - places[0].z),
            settled: Vec::new(),
            settled_poses: Vec::new(),
        }
    };
    chains.iter().map(limb).collect()
}

/// The mean distance of a chain's surface from its bones.
fn radius(model: &RiggedModel, world: &[Vec3], chain: std::ops::Range<usize>) -> f32 {
    let (mut sum, mut count) = (0.0f64, 0u32);
    for part in &model.parts {
        for (v, place) in part.mesh.positions.iter().enumerate() {
            let heaviest = (0..4).max_by(|a, b| part.weights[v][*a].total_cmp(&part.weights[v][*b])).unwrap_or(0);
            let bone = usize::from(part.bones[v][heaviest]);
            if chain.contains(&bone) {
                sum += f64::from(place.distance(world[bone]));
                count += 1;
            }
        }
    }
    (sum / f64::from(count.max(1))) as f32
}
