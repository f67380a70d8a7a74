//! DragonBones JSON, version 5.5, its atlas and its picture.
//!
//! One weighted mesh, or where depths change one for each group of regions that stay together, ordered by the `zOrder`
//! timeline. Bones, weights and correctives are those of `puppet`; a corrective is a key of an `ffd` timeline, in
//! the armature's coordinates at rest. Every vertex is where the take has it within a third of a pixel in every frame.
//! y is down, a unit is a pixel of the picture times the scale, the origin its top left.
//!
//! Known limits: players keep a scene in packed arrays with offsets of 16 bits, so a mesh of more than some 6500 vertices
//! is refused, and so are changing depths in a take whose correctives without those of its largest part are more than
//! 65535 numbers. Few parts, the largest last, keep far from both: without changing depths a take may have any length.

use std::path::Path;

use glam::DVec2;
use serde_json::{Map, Value, json};

use super::deform::{Deform, DeformKey};
use super::puppet::{Bone, Puppet, Units};
use super::{atlas, beside, check, deform, json_bytes, number, numbers, parts, plain_name, written};
use crate::error::{Error, Result};
use crate::export::take::{TakeFiles, TakeOptions, TakeSubject};
use crate::export::write_aside::write_all_aside;
use crate::job::Stage;

const VERSION: &str = "5.5";
const ROOT: &str = "root";
const ANIMATION: &str = "take";
/// Offsets of players are 16 bits.
const MOST_PACKED: usize = 65535;

/// Writes `path`, and beside it the atlas and the picture, `NAME_tex.json` and `NAME_tex.png` as DragonBones calls them.
///
/// # Errors
/// As for [`crate::export::take::write_take`].
pub fn write(path: &Path, subject: TakeSubject<'_>, options: &TakeOptions, stage: Stage<'_>) -> Result<TakeFiles> {
    check(subject, options)?;
    let (atlas_path, _) = beside(path, "_tex.json")?;
    let (page_path, page) = beside(path, "_tex.png")?;
    let name = plain_name(subject.name);
    let texture = atlas::texture(subject)?;
    stage.at(0.1)?;
    let scene = scene(subject, options, &name, stage.part(0.1, 0.95))?;
    let atlas = atlas::dragonbones_atlas(&name, &page, &name, subject.character.size);
    stage.name("files")?;
    let files = [(path.to_owned(), json_bytes(&scene)?), (atlas_path, json_bytes(&atlas)?), (page_path, texture)];
    write_all_aside(&files)?;
    Ok(written(subject, files.map(|f| f.0).to_vec()))
}

fn scene(subject: TakeSubject<'_>, options: &TakeOptions, name: &str, stage: Stage<'_>) -> Result<Value> {
    let (width, height) = subject.character.size;
    let scale = f64::from(options.scale);
    let puppet = Puppet::new(subject, Units { scale, up_from: None }, stage.part(0.0, 0.7))?;
    let bind = puppet.bind();
    let index = |bone: usize| bone + 1;
    let bone_name = |bone: usize| puppet.bones[bone].name.as_str();
    let root_taken = puppet.bones.iter().any(|b| b.name == ROOT);
    let root = if root_taken { "scene root" } else { ROOT };
    let mut bones = vec![json!({ "name": root })];
    bones.extend(puppet.bones.iter().map(|b| {
        let (place, turn) = (b.place.rest, number(b.turn.rest.x, 4));
        let transform = json!({ "x": number(place.x, 4), "y": number(place.y, 4), "skX": turn, "skY": turn });
        let parent = b.parent.map_or(root, bone_name);
        json!({ "name": b.name, "parent": parent, "length": number(b.length, 2), "transform": transform })
    }));

    let parts = parts::together(subject.character, &subject.take.frames);
    let size = DVec2::new(f64::from(width), f64::from(height)) * scale;
    let mut slots = Vec::new();
    let mut skin = Vec::new();
    let mut deforms: Vec<(usize, Value)> = Vec::new();
    // Numbers that a player packs.
    let mut packed = 0;
    for (done, part) in parts.iter().enumerate() {
        stage.at(0.7 + 0.3 * done as f64 / parts.len() as f64)?;
        let slot = bone_name(puppet.mover[part.bones[0]]).to_owned();
        slots.push(json!({ "name": slot, "parent": root }));
        let deform = Deform::new(&puppet, part);
        let rest = || deform.vertices.iter().map(|&v| puppet.rest[v as usize]);
        let mut used: Vec<usize> = Vec::new();
        let mut weights: Vec<Value> = Vec::new();
        for &v in &deform.vertices {
            let own = &puppet.weights[v as usize];
            weights.push(own.len().into());
            for &(bone, weight) in own {
                weights.extend([index(bone).into(), number(weight, 3)]);
                used.push(bone);
            }
        }
        let told = used.len();
        packed += 4 * deform.vertices.len() + 3 * told;
        used.sort_unstable();
        used.dedup();
        let pose = used.iter().flat_map(|&bone| {
            let values = bind[bone].to_cols_array().into_iter().map(|v| number(v, 6));
            std::iter::once(Value::from(index(bone))).chain(values)
        });
        skin.push(json!({ "name": slot, "display": [{
            "type": "mesh", "name": slot, "path": name, "width": width, "height": height,
            "vertices": numbers(rest().flat_map(|p| [p.x, p.y]), 2),
            "uvs": numbers(rest().map(|p| p / size).flat_map(|p| [p.x, p.y]), 5),
            "triangles": part.triangles.iter().flatten().map(|v| deform.place[*v as usize]).collect::<Vec<u32>>(),
            "edges": (0..part.hull)
                .flat_map(|i| [i, (i + 1) % part.hull].map(|v| deform.place[v]))
                .collect::<Vec<u32>>(),
            "userEdges": [],
            "weights": weights, "slotPose": [1, 0, 0, 1, 0, 0], "bonePose": pose.collect::<Vec<Value>>(),
        }] }));
        if !deform.keys.is_empty() {
            let frames = deform_frames(subject, &puppet, &deform.keys);
            let timeline = json!({ "name": slot, "slot": slot, "frame": frames });
            deforms.push((2 * told * deform.keys.len(), timeline));
        }
    }
    deforms.sort_by_key(|d| d.0);
    let keyed = |b: &Bone| 2 * (b.place.keys.len() + b.turn.keys.len() + b.scale.keys.len());
    let moving: usize =
        puppet.bones.iter().map(keyed).sum::<usize>() + deforms.iter().rev().skip(1).map(|d| d.0).sum::<usize>();
    let remedies = ["ask for fewer vertices", "take fewer frames or vertices, or keep depths as they are"];
    for ((what, value), remedy) in [("mesh", packed), ("animation", moving)].into_iter().zip(remedies) {
        if value > MOST_PACKED {
            let what = format!("how many numbers DragonBones players must pack for the {what}");
            let (value, max) = (value as u64, MOST_PACKED as u64);
            return Err(Error::Limit { what, value, max, remedy: remedy.into() });
        }
    }
    let deforms: Vec<Value> = deforms.into_iter().map(|d| d.1).collect();

    let mut animation = json!({ "duration": subject.take.frames.len(), "playTimes": 0, "name": ANIMATION });
    let moved: Vec<Value> = puppet
        .bones
        .iter()
        .map(|b| timelines(subject, b, puppet.holds))
        .filter(|t| t.len() > 1)
        .map(Value::Object)
        .collect();
    for (key, timelines) in [("bone", moved), ("ffd", deforms)] {
        if !timelines.is_empty() {
            animation[key] = timelines.into();
        }
    }
    let orders = parts::orders(&parts, &subject.take.frames);
    if orders.iter().any(|(_, order)| !parts::moves(order).is_empty()) {
        let starts: Vec<usize> = orders.iter().map(|o| o.0).collect();
        let frames = spans(&starts, subject.take.frames.len()).zip(&orders).map(|((_, duration), (_, order))| {
            let order: Vec<i64> = parts::moves(order).into_iter().flat_map(|(part, by)| [part as i64, by]).collect();
            json!({ "duration": duration, "zOrder": order })
        });
        animation["zOrder"] = json!({ "frame": frames.collect::<Vec<Value>>() });
    }
    let rate = number(subject.take.fps, 4);
    Ok(json!({
        "name": name, "version": VERSION, "compatibleVersion": VERSION, "frameRate": rate,
        "armature": [{
            "type": "Armature", "name": name, "frameRate": rate,
            "aabb": { "x": 0, "y": 0, "width": number(size.x, 2), "height": number(size.y, 2) },
            "bone": bones, "slot": slots, "skin": [{ "name": "", "slot": skin }], "animation": [animation],
            "defaultActions": [{ "gotoAndPlay": ANIMATION }],
        }],
    }))
}

/// Each key's place among the keys, and how many frames it lasts.
fn spans(starts: &[usize], frames: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..starts.len()).map(move |k| (k, starts.get(k + 1).copied().unwrap_or(frames) - starts[k]))
}

/// A key that lasts `duration`, and then gives way evenly unless it holds or is the last.
fn lasting(duration: usize, last: bool, holds: bool) -> Value {
    let mut entry = json!({ "duration": duration });
    if !last && !holds {
        entry["tweenEasing"] = 0.into();
    }
    entry
}

fn deform_frames(subject: TakeSubject<'_>, puppet: &Puppet, keys: &[DeformKey]) -> Value {
    let starts: Vec<usize> = keys.iter().map(|k| k.frame).collect();
    spans(&starts, subject.take.frames.len())
        .map(|(k, duration)| {
            let mut entry = lasting(duration, k + 1 == keys.len(), puppet.holds);
            let key = &keys[k];
            if !key.values.is_empty() {
                if key.first > 0 {
                    entry["offset"] = (2 * key.first).into();
                }
                let values = key.values.iter().flat_map(|v| [f64::from(v.x), f64::from(v.y)]);
                entry["vertices"] = numbers(values, deform::DECIMALS);
            }
            entry
        })
        .collect()
}

/// What a bone does: turns and places beside those at rest, scales by those at rest.
fn timelines(subject: TakeSubject<'_>, bone: &Bone, holds: bool) -> Map<String, Value> {
    let mut all = Map::new();
    all.insert("name".into(), bone.name.clone().into());
    let frames = |keys: &[(usize, DVec2)], fill: &dyn Fn(&mut Value, DVec2)| -> Value {
        let starts: Vec<usize> = keys.iter().map(|k| k.0).collect();
        spans(&starts, subject.take.frames.len())
            .map(|(k, duration)| {
                let mut entry = lasting(duration, k + 1 == keys.len(), holds);
                fill(&mut entry, keys[k].1);
                entry
            })
            .collect()
    };
    let pair = |entry: &mut Value, value: DVec2, usual: f64| {
        for (key, value) in [("x", value.x), ("y", value.y)] {
            if value != usual {
                entry[key] = number(value, 4);
            }
        }
    };
    if !bone.place.keys.is_empty() {
        let moved = |entry: &mut Value, v: DVec2| pair(entry, v - bone.place.rest, 0.0);
        all.insert("translateFrame".into(), frames(&bone.place.keys, &moved));
    }
    if !bone.turn.keys.is_empty() {
        let turned = |entry: &mut Value, v: DVec2| entry["rotate"] = number(v.x - bone.turn.rest.x, 3);
        all.insert("rotateFrame".into(), frames(&bone.turn.keys, &turned));
    }
    if !bone.scale.keys.is_empty() {
        all.insert("scaleFrame".into(), frames(&bone.scale.keys, &|entry: &mut Value, v: DVec2| pair(entry, v, 1.0)));
    }
    all
}
