//! Spine JSON, version 4.2, its atlas and its picture, from the format's public description.
//!
//! A slot for each bone's region, with a weighted mesh of the region's triangles; `drawOrder` keys carry depths. Bones,
//! weights and correctives are those of `puppet`; a corrective is a `deform` key, told to every bone of a vertex
//! in that bone's own coordinates. Every vertex is where the take has it within a third of a pixel in every frame. y is
//! up, a unit is a pixel of the picture times the scale, the origin its bottom left.
//!
//! Known limits: a region with holes or of several pieces has only its longest outline as hull, which editors use and
//! players do not. Between frames bones turn evenly.

use std::path::Path;

use glam::DVec2;
use serde_json::{Map, Value, json};

use super::puppet::{Bone, Puppet, Units};
use super::{atlas, beside, check, deform, json_bytes, number, numbers, parts, plain_name, written};
use crate::error::{Error, Result};
use crate::export::take::{TakeFiles, TakeOptions, TakeSubject};
use crate::export::write_aside::write_all_aside;
use crate::job::Stage;

const VERSION: &str = "4.2.00";
/// Players keep twice a vertex's index in 16 bits.
const MOST_VERTICES: usize = 32_767;
const ROOT: &str = "root";
const ANIMATION: &str = "take";

/// Writes `path`, and beside it the atlas and the picture of the same name.
///
/// # Errors
/// As for [`crate::export::take::write_take`].
pub fn write(path: &Path, subject: TakeSubject<'_>, options: &TakeOptions, stage: Stage<'_>) -> Result<TakeFiles> {
    check(subject, options)?;
    let (atlas_path, _) = beside(path, ".atlas")?;
    let (page_path, page) = beside(path, ".png")?;
    let name = plain_name(subject.name);
    let texture = atlas::texture(subject)?;
    stage.at(0.1)?;
    let scene = scene(subject, options, &name, stage.part(0.1, 0.95))?;
    let atlas = atlas::spine_atlas(&page, &name, subject.character.size);
    stage.name("files")?;
    let files = [(path.to_owned(), json_bytes(&scene)?), (atlas_path, atlas.into_bytes()), (page_path, texture)];
    write_all_aside(&files)?;
    Ok(written(subject, files.map(|f| f.0).to_vec()))
}

fn scene(subject: TakeSubject<'_>, options: &TakeOptions, name: &str, stage: Stage<'_>) -> Result<Value> {
    let (width, height) = subject.character.size;
    let scale = f64::from(options.scale);
    let puppet = Puppet::new(subject, Units { scale, up_from: Some(f64::from(height)) }, stage.part(0.0, 0.7))?;
    let bind = puppet.bind();
    // Ours follow the root that the format wants.
    let index = |bone: usize| bone + 1;
    let bone_name = |bone: usize| puppet.bones[bone].name.as_str();
    let root_taken = puppet.bones.iter().any(|b| b.name == ROOT);
    let root = if root_taken { "scene root" } else { ROOT };
    let mut bones = vec![json!({ "name": root })];
    bones.extend(puppet.bones.iter().map(|b| {
        let mut entry = json!({ "name": b.name, "parent": b.parent.map_or(root, bone_name) });
        let place = b.place.rest;
        for (key, value, decimals) in
            [("length", b.length, 2), ("rotation", b.turn.rest.x, 4), ("x", place.x, 4), ("y", place.y, 4)]
        {
            if value != 0.0 {
                entry[key] = number(value, decimals);
            }
        }
        entry
    }));

    let parts = parts::regions(subject.character, &subject.take.frames);
    let mut slots = Vec::new();
    let (mut skin, mut deforms) = (Map::new(), Map::new());
    let local = |bone: usize| bind[bone].inverse();
    for (done, part) in parts.iter().enumerate() {
        stage.at(0.7 + 0.3 * done as f64 / parts.len() as f64)?;
        if part.vertices.len() > MOST_VERTICES {
            let what = "the vertex count of a region".into();
            let (value, max) = (part.vertices.len() as u64, MOST_VERTICES as u64);
            return Err(Error::Limit { what, value, max, remedy: "ask for fewer vertices".into() });
        }
        let bone = puppet.mover[part.bones[0]];
        let slot = bone_name(bone).to_owned();
        slots.push(json!({ "name": slot, "bone": bone_name(bone), "attachment": slot }));
        let size = DVec2::new(f64::from(width), f64::from(height)) * scale;
        let uvs = part.vertices.iter().map(|&v| puppet.rest[v as usize] / size).flat_map(|p| [p.x, 1.0 - p.y]);
        let mut vertices: Vec<Value> = Vec::new();
        for &v in &part.vertices {
            let weights = &puppet.weights[v as usize];
            vertices.push(weights.len().into());
            for &(bone, weight) in weights {
                let p = local(bone).transform_point2(puppet.rest[v as usize]);
                vertices.extend([index(bone).into(), number(p.x, 2), number(p.y, 2), number(weight, 3)]);
            }
        }
        let hull = part.hull;
        let mesh = json!({
            "type": "mesh", "path": name, "uvs": numbers(uvs, 5), "vertices": vertices, "hull": hull,
            "triangles": part.triangles.iter().flatten().copied().collect::<Vec<u32>>(),
            "edges": (0..hull).flat_map(|i| [2 * i, 2 * ((i + 1) % hull)]).collect::<Vec<usize>>(),
            "width": number(size.x, 2), "height": number(size.y, 2),
        });
        skin.insert(slot.clone(), json!({ slot.clone(): mesh }));
        let keys = deform::keys(&puppet, &part.vertices);
        if keys.is_empty() {
            continue;
        }
        // Two numbers for each weight.
        let before: Vec<usize> = part
            .vertices
            .iter()
            .scan(0, |sum, &v| {
                let here = *sum;
                *sum += 2 * puppet.weights[v as usize].len();
                Some(here)
            })
            .collect();
        let entries = keys.iter().map(|key| {
            let told = |(i, value): (usize, &glam::Vec2)| {
                let of = |&(bone, _): &(usize, f64)| (local(bone).matrix2 * value.as_dvec2()).to_array();
                puppet.weights[part.vertices[key.first + i] as usize].iter().map(of).collect::<Vec<_>>()
            };
            let values = key.values.iter().enumerate().flat_map(told).flatten();
            let mut entry = timed(subject, key.frame, puppet.holds);
            if !key.values.is_empty() {
                entry["vertices"] = numbers(values, deform::DECIMALS);
                if before[key.first] > 0 {
                    entry["offset"] = before[key.first].into();
                }
            }
            entry
        });
        let entries: Vec<Value> = entries.collect();
        deforms.insert(slot.clone(), json!({ slot: { "deform": entries } }));
    }

    let mut animation = Map::new();
    let moved: Map<String, Value> = puppet
        .bones
        .iter()
        .map(|b| (b.name.clone(), Value::Object(timelines(subject, b, puppet.holds))))
        .filter(|b| b.1.as_object().is_some_and(|t| !t.is_empty()))
        .collect();
    if !moved.is_empty() {
        animation.insert("bones".into(), moved.into());
    }
    if !deforms.is_empty() {
        animation.insert("attachments".into(), json!({ "default": deforms }));
    }
    let orders = parts::orders(&parts, &subject.take.frames);
    if orders.iter().any(|(_, order)| !parts::moves(order).is_empty()) {
        let order = orders.iter().map(|(frame, order)| {
            let offsets: Vec<Value> = parts::moves(order)
                .into_iter()
                .map(|(part, by)| json!({ "slot": slots[part]["name"], "offset": by }))
                .collect();
            let mut entry = timed(subject, *frame, false);
            if !offsets.is_empty() {
                entry["offsets"] = offsets.into();
            }
            entry
        });
        animation.insert("drawOrder".into(), order.collect());
    }
    Ok(json!({
        "skeleton": {
            "spine": VERSION, "x": 0, "y": 0,
            "width": number(f64::from(width) * scale, 2), "height": number(f64::from(height) * scale, 2),
            "fps": number(subject.take.fps, 4), "images": "./",
        },
        "bones": bones, "slots": slots,
        "skins": [{ "name": "default", "attachments": skin }],
        "animations": { ANIMATION: animation },
    }))
}

/// A key of a frame.
fn timed(subject: TakeSubject<'_>, frame: usize, holds: bool) -> Value {
    let mut entry = json!({});
    if frame > 0 {
        entry["time"] = number(frame as f64 / subject.take.fps, 5);
    }
    if holds {
        entry["curve"] = "stepped".into();
    }
    entry
}

/// What a bone does: turns and places beside those at rest, scales as they are.
fn timelines(subject: TakeSubject<'_>, bone: &Bone, holds: bool) -> Map<String, Value> {
    let mut all = Map::new();
    let keys = |channel: &[(usize, DVec2)], fill: &dyn Fn(&mut Value, DVec2)| -> Value {
        let entry = |&(frame, value): &(usize, DVec2)| {
            let mut entry = timed(subject, frame, holds);
            fill(&mut entry, value);
            entry
        };
        channel.iter().map(entry).collect()
    };
    let pair = |entry: &mut Value, value: DVec2, usual: f64| {
        for (key, value) in [("x", value.x), ("y", value.y)] {
            if value != usual {
                entry[key] = number(value, 4);
            }
        }
    };
    if !bone.turn.keys.is_empty() {
        let turned = |entry: &mut Value, v: DVec2| entry["value"] = number(v.x - bone.turn.rest.x, 3);
        all.insert("rotate".into(), keys(&bone.turn.keys, &turned));
    }
    if !bone.place.keys.is_empty() {
        let moved = |entry: &mut Value, v: DVec2| pair(entry, v - bone.place.rest, 0.0);
        all.insert("translate".into(), keys(&bone.place.keys, &moved));
    }
    if !bone.scale.keys.is_empty() {
        all.insert("scale".into(), keys(&bone.scale.keys, &|entry: &mut Value, v: DVec2| pair(entry, v, 1.0)));
    }
    all
}
