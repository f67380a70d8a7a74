//! Creatures back from binary glTF: our own files as they were, and those that a modelling program wrote of them.
//!
//! What is read: triangles, the first texture coordinates, four weights a vertex, base colours, and the first animation
//! in whole frames. Limits: no scale or shear in bones, nothing kept in other files; morph targets, cameras, lights and
//! vertex colours are left out.

mod bones;
mod container;
mod limbs;
mod surfaces;

use std::path::Path;

use self::bones::{Bones, Timing};
use self::container::{Container, Found};
use self::limbs::Said;
use crate::error::{Error, Result};
use crate::shape::RiggedModel;
use crate::shape::creature::Creature;

/// Nodes that a file may have.
const MAX_NODES: usize = 1 << 14;
/// Bytes that a file may have: what the format can say.
const MAX_BYTES: u64 = u32::MAX as u64;

/// Reads a creature from a file, or from the creature.glb of a creature's folder.
///
/// # Errors
/// A path that cannot be read, or a file that is damaged or holds what cannot be a creature.
pub fn read_creature(path: impl AsRef<Path>) -> Result<Creature> {
    let given = path.as_ref();
    let path = &if given.is_dir() { given.join("creature.glb") } else { given.to_owned() };
    let size = std::fs::metadata(path).map_err(|e| Error::io(path, "read", e))?.len();
    if size > MAX_BYTES {
        let what = format!("{}: the file's bytes", path.display());
        return Err(Error::Limit { what, value: size, max: MAX_BYTES, remedy: "binary glTF holds less".into() });
    }
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
    parse_creature(&bytes).map_err(|e| e.in_file(path))
}

/// A creature from the bytes of a binary glTF file.
///
/// # Errors
/// Bytes that are damaged or hold what cannot be a creature.
pub fn parse_creature(bytes: &[u8]) -> Result<Creature> {
    let bad = |problem: String| Error::invalid("the creature", problem, "give a creature.glb, or one exported from it");
    let creature = read(bytes).map_err(bad)?;
    creature.validate().map_err(|e| bad(format!("holds no creature: {e}")))?;
    Ok(creature)
}

fn read(bytes: &[u8]) -> Found<Creature> {
    let file = Container::new(bytes)?;
    let root = &file.root;
    if root.nodes.len() > MAX_NODES {
        return Err(format!("has {} nodes, and {MAX_NODES} are the most", root.nodes.len()));
    }
    let scene = root.scene.map_or(0, |s| s.value());
    let extras = root.scenes.get(scene).and_then(|s| s.extras.as_ref());
    let said: Said = extras.and_then(|e| serde_json::from_str(e.get()).ok()).unwrap_or_default();
    let clip =
        said.clip.filter(|c| (1.0..1000.0).contains(&c.fps) && c.size.iter().all(|s| (1.0..65536.0).contains(s)));
    let timing =
        Timing { fps: clip.as_ref().map(|c| c.fps), frames: clip.as_ref().map(|c| c.frames.clamp(1.0, 1e6) as usize) };
    let surfaces: Vec<usize> = (0..root.nodes.len()).filter(|n| root.nodes[*n].mesh.is_some()).collect();
    if surfaces.is_empty() {
        return Err("has no mesh".into());
    }
    let bones = Bones::new(&file, &surfaces, timing)?;
    let mut parts = Vec::new();
    for node in surfaces {
        parts.extend(surfaces::parts(&file, node, &bones)?);
    }
    let mut model = RiggedModel {
        size: (0, 0),
        fps: bones.fps,
        bones: bones.bones,
        rest: bones.rest,
        animation: bones.animation,
        parts,
    };
    let metres = said.metres_per_pixel.filter(|m| m.is_finite() && *m > 0.0).unwrap_or(1.0) as f32;
    if metres != 1.0 {
        to_pixels(&mut model, metres);
    }
    model.size = match clip {
        Some(clip) => (clip.size[0] as u32, clip.size[1] as u32),
        None => bounds(&model),
    };
    let limbs = limbs::limbs(&model, said.limbs);
    let last = model.animation.len().saturating_sub(1);
    let rest_frame = said.rest_frame.map_or(0, |f| f.clamp(0.0, last as f64) as usize);
    Ok(Creature { model, limbs, rest_frame })
}

/// From metres to pixels of the clip.
fn to_pixels(model: &mut RiggedModel, metres: f32) {
    let poses = std::iter::once(&mut model.rest).chain(&mut model.animation);
    poses.flatten().for_each(|t| t.translation /= metres);
    model.parts.iter_mut().flat_map(|p| &mut p.mesh.positions).for_each(|p| *p /= metres);
}

/// The size of a picture that the model at rest fits into, where no clip is known.
fn bounds(model: &RiggedModel) -> (u32, u32) {
    let places = || model.parts.iter().flat_map(|p| &p.mesh.positions);
    let side = |of: fn(&glam::Vec3) -> f32| places().map(of).fold(1.0f32, f32::max).ceil().min(16384.0) as u32;
    (side(|p| p.x), side(|p| p.y))
}
