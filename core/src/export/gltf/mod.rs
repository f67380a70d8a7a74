//! A creature as one binary glTF 2.0 file (GLB): bones, skinned meshes, textures and the animation.
//!
//! Layout: the bones hang from one node named after the armature; each limb is a mesh node beside it, bound to the one
//! skin (section 3.7.3: the transform of a skinned mesh's own node is ignored, so it has none). A bone's translation
//! moves it, so limbs stretch without scale. Colours carry the light of the clip; the material reflects nothing of its
//! own, and `unlit` shows them as filmed (KHR_materials_unlit). The same model gives the same bytes.

pub(super) mod animation;
pub(super) mod buffer;
mod crowd;
mod reading;
mod skin;

pub use crowd::crowd_glb;
pub use reading::{parse_creature, read_creature};

use std::collections::BTreeMap;

use gltf_json::accessor::Type;
use gltf_json::buffer::Target;
use gltf_json::material::{PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mesh, Mode, Primitive, Semantic};
use gltf_json::scene::{Node, Scene, UnitQuaternion};
use gltf_json::skin::Skin;
use gltf_json::texture::{MagFilter, MinFilter, Sampler, Texture, WrappingMode};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Image, Index, Material, Root};
use rayon::prelude::*;

use self::buffer::Buffer;
use super::png::encode_rgb;
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::shape::creature::Creature;
use crate::shape::{RiggedModel, SkinnedPart};

/// How to write a model.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GltfOptions {
    /// Metres a world unit; 1 leaves a unit a pixel of the clip.
    pub scale: f32,
    /// Whether viewers are asked to show the texture as it is, without their lights.
    pub unlit: bool,
}

impl Default for GltfOptions {
    fn default() -> Self {
        Self { scale: 1.0, unlit: false }
    }
}

/// The bytes of a GLB file.
///
/// # Errors
/// A model that is not valid, a scale that is no positive number, a file that would be larger than the format's
/// 4 GiB, or a cancel.
pub fn glb(creature: &Creature, options: &GltfOptions, stage: Stage<'_>) -> Result<Vec<u8>> {
    creature.validate()?;
    let mut file = File::new(options)?;
    let model = &creature.model;
    let looks = file.add_looks(model, stage.part(0.0, 0.6))?;
    let armature = file.root.push(Node { name: Some("creature".into()), ..Node::default() });
    let instance = file.add_instance(model, &looks, armature, "");
    let mut writer = animation::Writer::new(&mut file.root, &mut file.buffer, model.fps);
    animation::add(&mut writer, &model.rest, &model.animation, file.scale, &instance.bones);
    writer.finish("motion");
    stage.at(0.9)?;
    let nodes = std::iter::once(armature).chain(instance.surfaces).collect();
    file.finish("creature", nodes, extras(creature, options.scale)?)
}

/// A file in the making.
struct File {
    root: Root,
    buffer: Buffer,
    scale: f32,
    unlit: bool,
    sampler: Index<Sampler>,
}

/// What all instances of a model share.
struct Looks {
    inverse_bind_matrices: Index<gltf_json::Accessor>,
    /// Name and mesh of each part that has triangles.
    meshes: Vec<(String, Index<Mesh>)>,
}

/// The nodes of one instance of a model.
struct Instanced {
    bones: Vec<Index<Node>>,
    surfaces: Vec<Index<Node>>,
}

impl File {
    fn new(options: &GltfOptions) -> Result<Self> {
        let scale = options.scale;
        if !(scale.is_finite() && scale > 0.0) {
            return Err(Error::invalid("scale", format!("is {scale}"), "give metres a pixel, above 0"));
        }
        let mut root = Root::default();
        root.asset.generator = Some(concat!("marey ", env!("CARGO_PKG_VERSION")).into());
        let sampler = root.push(Sampler {
            mag_filter: Some(Checked::Valid(MagFilter::Linear)),
            min_filter: Some(Checked::Valid(MinFilter::LinearMipmapLinear)),
            // Around a limb the texture closes; along it, it ends.
            wrap_s: Checked::Valid(WrappingMode::Repeat),
            wrap_t: Checked::Valid(WrappingMode::ClampToEdge),
            ..Sampler::default()
        });
        Ok(Self { root, buffer: Buffer::default(), scale, unlit: options.unlit, sampler })
    }

    /// Adds the meshes and textures of a model.
    fn add_looks(&mut self, model: &RiggedModel, stage: Stage<'_>) -> Result<Looks> {
        let textures: Vec<Vec<u8>> = model
            .parts
            .par_iter()
            .map(|part| {
                stage.at(0.0)?;
                encode_rgb(&part.texture)
            })
            .collect::<Result<_>>()?;
        stage.at(1.0)?;
        let matrices = skin::inverse_bind_matrices(model, self.scale);
        let inverse_bind_matrices = self.buffer.floats(&mut self.root, &matrices, Type::Mat4, None, false);
        let mut meshes = Vec::with_capacity(model.parts.len());
        for (part, texture) in model.parts.iter().zip(&textures) {
            // The format knows no empty accessor.
            if part.mesh.triangles.is_empty() {
                continue;
            }
            let (root, buffer) = (&mut self.root, &mut self.buffer);
            let material = add_material(root, buffer, &part.name, texture, self.sampler, self.unlit);
            let mesh = add_mesh(root, buffer, part, self.scale, model.bones.len(), material);
            meshes.push((part.name.clone(), mesh));
        }
        Ok(Looks { inverse_bind_matrices, meshes })
    }

    /// Adds bones below `armature` and the surfaces that they hold; `suffix` tells the instance's nodes from others'.
    fn add_instance(&mut self, model: &RiggedModel, looks: &Looks, armature: Index<Node>, suffix: &str) -> Instanced {
        let bones = add_bones(&mut self.root, model, self.scale, armature, suffix);
        let name = self.root.nodes[armature.value()].name.clone();
        let skin = self.root.push(Skin {
            extensions: None,
            extras: None,
            inverse_bind_matrices: Some(looks.inverse_bind_matrices),
            joints: bones.clone(),
            name,
            skeleton: Some(armature),
        });
        let surface = |(name, mesh): &(String, Index<Mesh>)| {
            let (name, mesh) = (Some(format!("{name}{suffix}")), Some(*mesh));
            self.root.push(Node { name, mesh, skin: Some(skin), ..Node::default() })
        };
        Instanced { bones, surfaces: looks.meshes.iter().map(surface).collect() }
    }

    /// The whole file, with these nodes in its scene.
    fn finish(mut self, name: &str, nodes: Vec<Index<Node>>, extras: gltf_json::Extras) -> Result<Vec<u8>> {
        let scene = Scene { extensions: None, extras, name: Some(name.into()), nodes };
        self.root.scene = Some(self.root.push(scene));
        pack(&mut self.root, self.buffer)
    }
}

fn add_bones(
    root: &mut Root,
    model: &RiggedModel,
    scale: f32,
    armature: Index<Node>,
    suffix: &str,
) -> Vec<Index<Node>> {
    let bones: Vec<Index<Node>> = model
        .bones
        .iter()
        .zip(&model.rest)
        .map(|(bone, rest)| {
            root.push(Node {
                name: Some(format!("{}{suffix}", bone.name)),
                rotation: Some(UnitQuaternion(rest.rotation.normalize().to_array())),
                translation: Some((rest.translation * scale).to_array()),
                ..Node::default()
            })
        })
        .collect();
    for (child, bone) in model.bones.iter().enumerate() {
        let parent = bone.parent.map_or(armature, |p| bones[p]);
        root.nodes[parent.value()].children.get_or_insert_default().push(bones[child]);
    }
    bones
}

/// Adds a material that shows a PNG and reflects nothing of its own.
pub(super) fn add_material(
    root: &mut Root,
    buffer: &mut Buffer,
    name: &str,
    png: &[u8],
    sampler: Index<Sampler>,
    unlit: bool,
) -> Index<Material> {
    let view = buffer.view(root, png, None);
    let source = root.push(Image {
        buffer_view: Some(view),
        mime_type: Some(gltf_json::image::MimeType("image/png".into())),
        name: Some(name.into()),
        uri: None,
        extensions: None,
        extras: None,
    });
    let texture = root.push(Texture { name: None, sampler: Some(sampler), source, extensions: None, extras: None });
    let texture = gltf_json::texture::Info { index: texture, tex_coord: 0, extensions: None, extras: None };
    let extension =
        gltf_json::extensions::material::Material { unlit: Some(gltf_json::extensions::material::Unlit {}) };
    if unlit && root.extensions_used.is_empty() {
        root.extensions_used.push("KHR_materials_unlit".into());
    }
    root.push(Material {
        name: Some(name.into()),
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_texture: Some(texture),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(1.0),
            ..PbrMetallicRoughness::default()
        },
        extensions: unlit.then_some(extension),
        ..Material::default()
    })
}

fn add_mesh(
    root: &mut Root,
    buffer: &mut Buffer,
    part: &SkinnedPart,
    scale: f32,
    bones: usize,
    material: Index<Material>,
) -> Index<Mesh> {
    let vertices = Some(Target::ArrayBuffer);
    let mesh = &part.mesh;
    let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| (*p * scale).to_array()).collect();
    let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|n| n.normalize_or(glam::Vec3::Z).to_array()).collect();
    let uvs: Vec<[f32; 2]> = mesh.uvs.iter().map(|uv| uv.to_array()).collect();
    let (joints, weights) = skin::influences(part);
    let attributes = BTreeMap::from([
        (Semantic::Positions, buffer.floats(root, &positions, Type::Vec3, vertices, true)),
        (Semantic::Normals, buffer.floats(root, &normals, Type::Vec3, vertices, false)),
        (Semantic::TexCoords(0), buffer.floats(root, &uvs, Type::Vec2, vertices, false)),
        (Semantic::Joints(0), buffer.joints(root, &joints, bones)),
        (Semantic::Weights(0), buffer.floats(root, &weights, Type::Vec4, vertices, false)),
    ]);
    let indices = buffer.indices(root, &mesh.triangles, mesh.positions.len());
    let primitive = Primitive {
        attributes: attributes.into_iter().map(|(k, v)| (Checked::Valid(k), v)).collect(),
        extensions: None,
        extras: None,
        indices: Some(indices),
        material: Some(material),
        mode: Checked::Valid(Mode::Triangles),
        targets: None,
    };
    root.push(Mesh {
        extensions: None,
        extras: None,
        name: Some(part.name.clone()),
        primitives: vec![primitive],
        weights: None,
    })
}

/// What the file cannot say otherwise: its units, the clip it came from, and the limbs that its bones make.
fn extras(creature: &Creature, scale: f32) -> Result<gltf_json::Extras> {
    let model = &creature.model;
    let value = serde_json::json!({
        "units": if scale == 1.0 { "1 unit is 1 pixel of the clip" } else { "metres" },
        "metres_per_pixel": scale,
        "clip": { "size": [model.size.0, model.size.1], "fps": model.fps, "frames": model.animation.len() },
        "rest_frame": creature.rest_frame,
        "limbs": creature.limbs,
    });
    serde_json::value::to_raw_value(&value).map(Some).map_err(|e| not_writable(&e))
}

pub(super) fn not_writable(error: &serde_json::Error) -> Error {
    Error::invalid("the model", format!("cannot be described in JSON: {error}"), "report this with the model")
}

/// The container: a header, the JSON and the buffer, each padded to whole words (glTF 2.0 section 4.4).
pub(super) fn pack(root: &mut Root, buffer: Buffer) -> Result<Vec<u8>> {
    let buffer = buffer.into_bytes();
    root.push(gltf_json::Buffer {
        byte_length: USize64::from(buffer.len()),
        name: None,
        uri: None,
        extensions: None,
        extras: None,
    });
    let mut json = root.to_vec().map_err(|e| not_writable(&e))?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + buffer.len();
    let Ok(total) = u32::try_from(total) else {
        return Err(Error::Limit {
            what: "the size of the glTF file in bytes".into(),
            value: total as u64,
            max: u64::from(u32::MAX),
            remedy: "use fewer frames, vertices or texels".into(),
        });
    };
    let mut out = Vec::with_capacity(total as usize);
    out.extend_from_slice(b"glTF");
    for word in [2, total, json.len() as u32] {
        out.extend_from_slice(&word.to_le_bytes());
    }
    out.extend_from_slice(b"JSON");
    out.extend_from_slice(&json);
    out.extend_from_slice(&(buffer.len() as u32).to_le_bytes());
    out.extend_from_slice(b"BIN\0");
    out.extend_from_slice(&buffer);
    Ok(out)
}
