//! A crowd as one binary glTF file: the meshes and textures of each creature once, and for every instance a skeleton of
//! its own below a node that places it, with its own stretch of the motion.

use gltf_json::Index;
use gltf_json::scene::{Node, UnitQuaternion};

use super::animation::{self, Writer};
use super::{File, GltfOptions, not_writable};
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::shape::crowd::{Crowd, pivot, placed};

/// Numbers that the file's animation may hold; the format ends at 4 GiB.
const MAX_KEYS: u64 = 1 << 28;

/// The bytes of a GLB file with a whole crowd.
///
/// # Errors
/// A crowd that is not valid or so large that the format could not hold it, a scale that is no positive number, or a
/// cancel.
pub fn crowd_glb(crowd: &Crowd, options: &GltfOptions, stage: Stage<'_>) -> Result<Vec<u8>> {
    crowd.validate()?;
    let bones = crowd.instances.iter().map(|i| crowd.creatures[i.creature].model.bones.len() as u64);
    let keys = bones.sum::<u64>() * crowd.frames as u64;
    if keys > MAX_KEYS {
        let what = "the crowd's bones in all frames".into();
        return Err(Error::Limit {
            what,
            value: keys,
            max: MAX_KEYS,
            remedy: "write fewer instances or frames".into(),
        });
    }
    let mut file = File::new(options)?;
    let scale = file.scale;
    let mut looks = Vec::with_capacity(crowd.creatures.len());
    for (c, creature) in crowd.creatures.iter().enumerate() {
        let count = crowd.creatures.len() as f64;
        let used = crowd.instances.iter().any(|i| i.creature == c);
        let part = stage.part(0.3 * c as f64 / count, 0.3 * (c + 1) as f64 / count);
        looks.push(if used { Some(file.add_looks(&creature.model, part)?) } else { None });
    }
    let mut nodes: Vec<Index<Node>> = Vec::new();
    let mut bones = Vec::with_capacity(crowd.instances.len());
    for (i, instance) in crowd.instances.iter().enumerate() {
        let Some(looks) = &looks[instance.creature] else { continue };
        let model = &crowd.creatures[instance.creature].model;
        let (turn, moved) = placed(instance, pivot(model));
        let armature = file.root.push(Node {
            name: Some(format!("creature {i}")),
            rotation: Some(UnitQuaternion(turn.to_array())),
            translation: Some((moved * scale).to_array()),
            scale: (instance.scale != 1.0).then_some([instance.scale; 3]),
            ..Node::default()
        });
        let made = file.add_instance(model, looks, armature, &format!(" {i}"));
        nodes.push(armature);
        nodes.extend(made.surfaces);
        bones.push(made.bones);
    }
    let mut writer = Writer::new(&mut file.root, &mut file.buffer, crowd.fps);
    for (i, instance) in crowd.instances.iter().enumerate() {
        stage.at(0.3 + 0.6 * i as f64 / crowd.instances.len() as f64)?;
        let poses: Vec<_> = (0..crowd.frames).map(|frame| crowd.pose(i, frame)).collect();
        animation::add(&mut writer, &crowd.creatures[instance.creature].model.rest, &poses, scale, &bones[i]);
    }
    writer.finish("motion");
    let said = serde_json::json!({
        "metres_per_pixel": scale,
        "clip": { "size": [crowd.size.0, crowd.size.1], "fps": crowd.fps, "frames": crowd.frames },
    });
    let extras = serde_json::value::to_raw_value(&said).map_err(|e| not_writable(&e))?;
    file.finish("crowd", nodes, Some(extras))
}
