//! A character's take as one binary glTF 2.0 file: a flat mesh on bones, with corrective morph targets.
//!
//! Bones, weights and correctives are those of `puppet`. The frame whose correctives are worst off gives a morph
//! target, every frame takes as much of it as fits best, and so on until all are within the tolerance (pivoted
//! Gram-Schmidt). Weights are `LINEAR` keys, frames left out where the line between their neighbours does; targets are
//! sparse. Two seconds of key poses take 10 to 30 targets; of captured motion, in which joint areas settle anew in every
//! frame, half as many targets as frames or more. Every vertex is where the take has it within a third of a pixel in every
//! frame.
//!
//! Depths are heights above the plane: every region has its own vertices and lies a quarter of a unit above the one that
//! is drawn before it; a morph target for each other order moves them up and down. The mesh's rim cuts the drawing, so
//! where its inside is opaque the material is `MASK`, which writes depth and lets raised regions cover others; with half
//! clear insides it is `BLEND`, and engines that write no depth then keep the order of the first frame.
//! `KHR_materials_unlit` shows the picture as it is. y is up, a unit is a pixel of the picture times the scale, the origin
//! its bottom left, the viewer at +z.
//!
//! Known limits: between frames, a bone on its way to another turn is on a circle where the take is on its own way.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DAffine2, DVec2, Vec2};
use gltf_json::accessor::Type;
use gltf_json::animation::Property;
use gltf_json::buffer::Target;
use gltf_json::material::{AlphaCutoff, AlphaMode};
use gltf_json::mesh::{Mesh, Mode, MorphTarget, Primitive, Semantic};
use gltf_json::scene::{Node, Scene, UnitQuaternion};
use gltf_json::skin::Skin;
use gltf_json::texture::{MagFilter, MinFilter, Sampler, WrappingMode};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};

use super::puppet::{Bone, Puppet, TOLERANCE, Units};
use super::{atlas, check, keys, parts, plain_name, written};
use crate::error::Result;
use crate::export::gltf::animation::Writer;
use crate::export::gltf::buffer::Buffer;
use crate::export::gltf::{add_material, not_writable, pack};
use crate::export::take::{TakeFiles, TakeOptions, TakeSubject};
use crate::export::write_aside;
use crate::job::Stage;

/// How far regions lie apart, in pixels: seen from the side nothing, and thousands of steps of a depth buffer.
const LAYER: f64 = 0.25;
/// Of the tolerance, what shapes may leave of a corrective, what is left out as too small for one, and what keys of
/// weights may add.
const LEFT: f64 = 0.7 * TOLERANCE;
const SMALL: f64 = 0.9 * TOLERANCE;
const BETWEEN: f64 = 0.25 * TOLERANCE;
/// Where the texture is clearer the material shows nothing: well below the half at which the mesh's rim lies.
const CUTOFF: f32 = 0.25;
/// Writes `path`.
///
/// # Errors
/// As for [`crate::export::take::write_take`].
pub fn write(path: &Path, subject: TakeSubject<'_>, options: &TakeOptions, stage: Stage<'_>) -> Result<TakeFiles> {
    check(subject, options)?;
    let bytes = glb(subject, options, stage)?;
    write_aside(path, &bytes)?;
    Ok(written(subject, vec![path.to_owned()]))
}

fn glb(subject: TakeSubject<'_>, options: &TakeOptions, stage: Stage<'_>) -> Result<Vec<u8>> {
    let (width, height) = subject.character.size;
    let scale = f64::from(options.scale);
    let puppet = Puppet::new(subject, Units { scale, up_from: Some(f64::from(height)) }, stage.part(0.0, 0.5))?;
    stage.name("morph targets")?;
    let shapes = Shapes::new(&puppet, stage.part(0.5, 0.9))?;
    stage.name("file")?;
    let parts = parts::regions(subject.character, &subject.take.frames);
    let name = plain_name(subject.name);
    let mut root = Root::default();
    let mut buffer = Buffer::default();
    root.asset.generator = Some(concat!("marey ", env!("CARGO_PKG_VERSION")).into());

    let armature = root.push(Node { name: Some(name.clone()), ..Node::default() });
    let nodes = add_bones(&mut root, &puppet, armature);
    let inverse: Vec<[f32; 16]> = puppet.bind().into_iter().map(inverse_bind).collect();
    let matrices = buffer.floats(&mut root, &inverse, Type::Mat4, None, false);
    let skin = root.push(Skin {
        extensions: None,
        extras: None,
        inverse_bind_matrices: Some(matrices),
        joints: nodes.clone(),
        name: Some(name.clone()),
        skeleton: Some(armature),
    });

    let sampler = root.push(Sampler {
        mag_filter: Some(Checked::Valid(MagFilter::Linear)),
        min_filter: Some(Checked::Valid(MinFilter::LinearMipmapLinear)),
        wrap_s: Checked::Valid(WrappingMode::ClampToEdge),
        wrap_t: Checked::Valid(WrappingMode::ClampToEdge),
        ..Sampler::default()
    });
    let png = atlas::texture(subject)?;
    let material = add_material(&mut root, &mut buffer, &name, &png, sampler, true);
    let look = &mut root.materials[material.value()];
    look.double_sided = true;
    if atlas::is_glass(subject.picture) {
        look.alpha_mode = Checked::Valid(AlphaMode::Blend);
    } else {
        look.alpha_mode = Checked::Valid(AlphaMode::Mask);
        look.alpha_cutoff = Some(AlphaCutoff(CUTOFF));
    }

    // Every part has its own vertices: one of the mesh's, and the part that it is in.
    let corners: Vec<(usize, usize)> =
        parts.iter().enumerate().flat_map(|(p, part)| part.vertices.iter().map(move |v| (*v as usize, p))).collect();
    let orders = parts::orders(&parts, &subject.take.frames);
    let heights = |order: &[usize]| {
        let mut heights = vec![0.0; order.len()];
        order.iter().enumerate().for_each(|(layer, &part)| heights[part] = (LAYER * scale * layer as f64) as f32);
        heights
    };
    let flat = heights(&orders[0].1);
    let vertices = Some(Target::ArrayBuffer);
    let at = |&(v, p): &(usize, usize)| [puppet.rest[v].x as f32, puppet.rest[v].y as f32, flat[p]];
    let positions: Vec<[f32; 3]> = corners.iter().map(at).collect();
    let size = DVec2::new(f64::from(width), f64::from(height)) * scale;
    let uv = |&(v, _): &(usize, usize)| (puppet.rest[v] / size).as_vec2();
    let uvs: Vec<[f32; 2]> = corners.iter().map(uv).map(|p| [p.x, 1.0 - p.y]).collect();
    let (joints, weights): (Vec<[u16; 4]>, Vec<[f32; 4]>) =
        corners.iter().map(|(v, _)| influences(&puppet.weights[*v])).unzip();
    let attributes = BTreeMap::from([
        (Checked::Valid(Semantic::Positions), buffer.floats(&mut root, &positions, Type::Vec3, vertices, true)),
        (Checked::Valid(Semantic::TexCoords(0)), buffer.floats(&mut root, &uvs, Type::Vec2, vertices, false)),
        (Checked::Valid(Semantic::Joints(0)), buffer.joints(&mut root, &joints, nodes.len())),
        (Checked::Valid(Semantic::Weights(0)), buffer.floats(&mut root, &weights, Type::Vec4, vertices, false)),
    ]);
    let starts: Vec<u32> = parts
        .iter()
        .scan(0, |sum, part| {
            let here = *sum;
            *sum += part.vertices.len() as u32;
            Some(here)
        })
        .collect();
    // The other way round: y is up.
    let triangles: Vec<[u32; 3]> = parts
        .iter()
        .zip(starts)
        .flat_map(|(part, start)| part.triangles.iter().map(move |[a, b, c]| [a + start, c + start, b + start]))
        .collect();
    let indices = buffer.indices(&mut root, &triangles, positions.len());
    let mut kinds: Vec<&[usize]> = orders.iter().map(|o| &o.1[..]).filter(|o| *o != &orders[0].1[..]).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let raised = kinds.iter().map(|order| {
        let heights = heights(order);
        corners.iter().map(|(_, p)| [0.0, 0.0, heights[*p] - flat[*p]]).collect::<Vec<[f32; 3]>>()
    });
    let corrected =
        shapes.shapes.iter().map(|(_, shape)| corners.iter().map(|(v, _)| [shape[*v].x, shape[*v].y, 0.0]).collect());
    let targets: Vec<MorphTarget> = corrected
        .chain(raised)
        .map(|values: Vec<[f32; 3]>| {
            let positions = Some(buffer.displacements(&mut root, &values));
            MorphTarget { positions, normals: None, tangents: None }
        })
        .collect();
    let has_targets = !targets.is_empty();
    let primitive = Primitive {
        attributes,
        extensions: None,
        extras: None,
        indices: Some(indices),
        material: Some(material),
        mode: Checked::Valid(Mode::Triangles),
        targets: has_targets.then_some(targets),
    };
    let names = shapes.shapes.iter().map(|(frame, _)| format!("corrective {frame}"));
    let names: Vec<String> = names.chain((0..kinds.len()).map(|k| format!("order {}", k + 1))).collect();
    let mesh = root.push(Mesh {
        extensions: None,
        extras: if has_targets { extras(&serde_json::json!({ "targetNames": names }))? } else { None },
        name: Some(name.clone()),
        primitives: vec![primitive],
        weights: has_targets.then(|| vec![0.0; names.len()]),
    });
    let node = Node { name: Some(format!("{name} mesh")), mesh: Some(mesh), skin: Some(skin), ..Node::default() };
    let node = root.push(node);

    let mut writer = Writer::new(&mut root, &mut buffer, subject.take.fps);
    for (bone, &at) in puppet.bones.iter().zip(&nodes) {
        animate(&mut writer, at, bone, puppet.holds);
    }
    if has_targets {
        let mut frames = shapes.keys.clone();
        // Orders jump from one frame to the next.
        frames.extend(orders.iter().skip(1).flat_map(|o| if puppet.holds { [o.0, o.0] } else { [o.0 - 1, o.0] }));
        frames.sort_unstable();
        frames.dedup();
        let order_in = |f: usize| &orders[orders.partition_point(|o| o.0 <= f).max(1) - 1].1[..];
        let values: Vec<[f32; 1]> = frames
            .iter()
            .flat_map(|&f| {
                let raised = kinds.iter().map(move |k| f32::from(u8::from(*k == order_in(f))));
                shapes.weights[f].iter().copied().chain(raised).map(|w| [w])
            })
            .collect();
        writer.keys(node, Property::MorphTargetWeights, Type::Scalar, &frames, &values, puppet.holds);
    }
    writer.finish("take");
    let units = serde_json::json!({
        "units": "1 unit is 1 pixel of the picture times the scale", "scale": options.scale,
        "picture": { "size": [width, height] }, "fps": subject.take.fps, "frames": subject.take.frames.len(),
    });
    let scene = Scene { extensions: None, extras: extras(&units)?, name: Some(name), nodes: vec![armature, node] };
    root.scene = Some(root.push(scene));
    pack(&mut root, buffer)
}

fn extras(value: &serde_json::Value) -> Result<gltf_json::Extras> {
    serde_json::value::to_raw_value(value).map(Some).map_err(|e| not_writable(&e))
}

fn turned(degrees: f64) -> [f32; 4] {
    let half = degrees.to_radians() / 2.0;
    [0.0, 0.0, half.sin() as f32, half.cos() as f32]
}

fn inverse_bind(bone: DAffine2) -> [f32; 16] {
    let [a, b, c, d, x, y] = bone.inverse().to_cols_array();
    [a, b, 0.0, 0.0, c, d, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, 0.0, 1.0].map(|v| v as f32)
}

fn influences(weights: &[(usize, f64)]) -> ([u16; 4], [f32; 4]) {
    let (mut joints, mut shares) = ([0; 4], [0.0; 4]);
    for (i, &(bone, weight)) in weights.iter().take(4).enumerate() {
        (joints[i], shares[i]) = (bone as u16, weight as f32);
    }
    shares[0] = 1.0 - shares[1..].iter().sum::<f32>();
    (joints, shares)
}

fn add_bones(root: &mut Root, puppet: &Puppet, armature: Index<Node>) -> Vec<Index<Node>> {
    let mut nodes: Vec<Index<Node>> = Vec::with_capacity(puppet.bones.len());
    for bone in &puppet.bones {
        let place = bone.place.rest;
        let own = root.push(Node {
            name: Some(bone.name.clone()),
            rotation: (bone.turn.rest.x != 0.0).then(|| UnitQuaternion(turned(bone.turn.rest.x))),
            translation: Some([place.x as f32, place.y as f32, 0.0]),
            ..Node::default()
        });
        let parent = bone.parent.map_or(armature, |p| nodes[p]);
        root.nodes[parent.value()].children.get_or_insert_default().push(own);
        nodes.push(own);
    }
    nodes
}

fn animate(writer: &mut Writer<'_>, node: Index<Node>, bone: &Bone, holds: bool) {
    let frames = |keys: &[(usize, DVec2)]| keys.iter().map(|k| k.0).collect::<Vec<usize>>();
    for (channel, property, z) in [(&bone.place, Property::Translation, 0.0), (&bone.scale, Property::Scale, 1.0)] {
        if !channel.keys.is_empty() {
            let values: Vec<[f32; 3]> = channel.keys.iter().map(|k| [k.1.x as f32, k.1.y as f32, z]).collect();
            writer.keys(node, property, Type::Vec3, &frames(&channel.keys), &values, holds);
        }
    }
    if !bone.turn.keys.is_empty() {
        let values: Vec<[f32; 4]> = bone.turn.keys.iter().map(|k| turned(k.1.x)).collect();
        // Half angles that go on change a quaternion's sign where they should: neighbours are on one side.
        writer.keys(node, Property::Rotation, Type::Vec4, &frames(&bone.turn.keys), &values, holds);
    }
}

/// Shapes that correctives are sums of.
struct Shapes {
    /// The frame that each comes from, and its displacements.
    shapes: Vec<(usize, Vec<Vec2>)>,
    /// How much of each shape each frame has.
    weights: Vec<Vec<f32>>,
    /// The frames whose weights are told.
    keys: Vec<usize>,
}

impl Shapes {
    fn new(puppet: &Puppet, stage: Stage<'_>) -> Result<Self> {
        use rayon::prelude::*;
        let frames = puppet.correctives.len();
        let scale = puppet.scale;
        let off = |d: Vec2, v: usize| f64::from(d.length()) * puppet.growth[v];
        let moving: Vec<usize> = (0..puppet.rest.len())
            .filter(|&v| puppet.correctives.iter().any(|f| off(f[v], v) > SMALL * scale))
            .collect();
        let mut left: Vec<Vec<Vec2>> =
            puppet.correctives.iter().map(|f| moving.iter().map(|&v| f[v]).collect()).collect();
        let mut own = Self { shapes: Vec::new(), weights: vec![Vec::new(); frames], keys: Vec::new() };
        // What a shape moves at most, in the world.
        let mut reach: Vec<f64> = Vec::new();
        loop {
            stage.at(own.shapes.len() as f64 / frames as f64)?;
            let worst = |f: &Vec<Vec2>| f.iter().zip(&moving).map(|(d, v)| off(*d, *v)).fold(0.0, f64::max);
            let worst: Vec<f64> = left.par_iter().map(worst).collect();
            let frame = (0..frames).max_by(|&a, &b| worst[a].total_cmp(&worst[b])).unwrap_or(0);
            if worst[frame] <= LEFT * scale || own.shapes.len() == frames {
                break;
            }
            let shape = left[frame].clone();
            let dot = |a: &[Vec2], b: &[Vec2]| -> f64 {
                a.iter().zip(b).map(|(a, b)| f64::from(a.x) * f64::from(b.x) + f64::from(a.y) * f64::from(b.y)).sum()
            };
            let square = dot(&shape, &shape);
            own.weights.par_iter_mut().zip(&mut left).for_each(|(weights, left)| {
                let share = (dot(left, &shape) / square) as f32;
                left.iter_mut().zip(&shape).for_each(|(d, s)| *d -= *s * share);
                weights.push(share);
            });
            reach.push(worst[frame]);
            let mut full = vec![Vec2::ZERO; puppet.rest.len()];
            moving.iter().zip(&shape).for_each(|(v, d)| full[*v] = *d);
            own.shapes.push((frame, full));
        }
        let near = |share: &dyn Fn(usize) -> f32, f: usize| -> bool {
            let off = |k: usize| f64::from((share(k) - own.weights[f][k]).abs()) * reach[k];
            (0..reach.len()).map(off).sum::<f64>() <= BETWEEN * scale
        };
        own.keys = if puppet.holds {
            keys::stepped(frames, |a, b| near(&|k| own.weights[a][k], b))
        } else {
            keys::linear(frames, |a, b| {
                (a + 1..b).all(|f| {
                    let share = keys::share(f, a, b) as f32;
                    near(&|k| own.weights[a][k] + (own.weights[b][k] - own.weights[a][k]) * share, f)
                })
            })
        };
        Ok(own)
    }
}
