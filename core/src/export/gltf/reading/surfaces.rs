//! The meshes of a glTF file as skinned parts with one texture each.

use glam::{DMat4, DVec3, Vec2, Vec3, Vec4};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Material};
use image::{ImageReader, Rgb, RgbImage};

use super::bones::Bones;
use super::container::{Container, Found};
use crate::geometry::TriMesh;
use crate::shape::SkinnedPart;

/// Pixels that a texture may have.
const MAX_TEXELS: u64 = 1 << 26;

/// All triangles of a node as parts, one a primitive.
pub(super) fn parts(file: &Container<'_>, node: usize, bones: &Bones) -> Found<Vec<SkinnedPart>> {
    let root = &file.root;
    let Some(mesh) = root.nodes[node].mesh else { return Ok(Vec::new()) };
    let mesh = root.meshes.get(mesh.value()).ok_or("is damaged: a mesh is not there")?;
    let name = root.nodes[node].name.clone().or_else(|| mesh.name.clone()).unwrap_or_else(|| format!("mesh {node}"));
    let triangles = |p: &&Primitive| matches!(p.mode, Checked::Valid(Mode::Triangles));
    let many = mesh.primitives.len() > 1;
    let named = |i: usize| if many { format!("{name} {i}") } else { name.clone() };
    let primitives = mesh.primitives.iter().enumerate().filter(|(_, p)| triangles(p));
    primitives.map(|(i, p)| part(file, node, p, named(i), bones)).collect()
}

fn part(file: &Container<'_>, node: usize, primitive: &Primitive, name: String, bones: &Bones) -> Found<SkinnedPart> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let position = attribute(Semantic::Positions).ok_or_else(|| format!("is damaged: `{name}` has no positions"))?;
    let positions = file.numbers::<3>(position)?;
    let count = positions.len();
    let same = |given: usize| {
        if given == count { Ok(()) } else { Err(format!("is damaged: `{name}` has vertex lists of different lengths")) }
    };

    let skin = root_skin(file, node)?;
    // A mesh without a skin stands where its node does; that of a skin is in the space that the skin was bound in.
    let placed = if skin.is_some() { DMat4::IDENTITY } else { bones.world[node] };
    let turned = placed.inverse().transpose();
    let mut mesh = TriMesh {
        positions: positions.iter().map(|p| placed.transform_point3(DVec3::from_array(*p)).as_vec3()).collect(),
        ..TriMesh::default()
    };
    mesh.triangles = match primitive.indices {
        Some(accessor) => {
            let indices: Vec<u32> = file.numbers::<1>(accessor)?.into_iter().map(|[i]| i as u32).collect();
            indices.as_chunks::<3>().0.to_vec()
        }
        None => (0..count as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    };
    if mesh.triangles.iter().flatten().any(|i| *i as usize >= count) {
        return Err(format!("is damaged: a triangle of `{name}` has a vertex that is not there"));
    }
    mesh.uvs = match attribute(Semantic::TexCoords(0)) {
        Some(accessor) => {
            file.numbers::<2>(accessor)?.into_iter().map(|uv| Vec2::from_array(uv.map(|v| v as f32))).collect()
        }
        None => vec![Vec2::ZERO; count],
    };
    same(mesh.uvs.len())?;
    mesh.normals = match attribute(Semantic::Normals) {
        Some(accessor) => {
            let turn = |n: [f64; 3]| turned.transform_vector3(DVec3::from_array(n)).as_vec3().normalize_or(Vec3::Z);
            file.numbers::<3>(accessor)?.into_iter().map(turn).collect()
        }
        None => mesh.smooth_normals(),
    };
    same(mesh.normals.len())?;

    let (held_by, weights) = match skin {
        None => {
            let bone = bones.of_node[node].unwrap_or(0) as u16;
            (vec![[bone, 0, 0, 0]; count], vec![[1.0, 0.0, 0.0, 0.0]; count])
        }
        Some(skin) => {
            let lists = attribute(Semantic::Joints(0)).zip(attribute(Semantic::Weights(0)));
            let (joints, weights) = lists.ok_or_else(|| format!("is damaged: `{name}` has a skin but no weights"))?;
            let (joints, weights) = (file.numbers::<4>(joints)?, file.numbers::<4>(weights)?);
            same(joints.len())?;
            same(weights.len())?;
            let bone = |joint: f64| -> Found<u16> {
                let joint = skin.joints.get(joint as usize).ok_or("is damaged: a vertex hangs on no joint")?;
                Ok(bones.of_node[joint.value()].unwrap_or(0) as u16)
            };
            let mut held_by = Vec::with_capacity(count);
            let mut shares = Vec::with_capacity(count);
            for (joints, weights) in joints.iter().zip(&weights) {
                let weights = Vec4::from_array(weights.map(|w| w as f32)).max(Vec4::ZERO);
                let sum = weights.element_sum();
                let share = if sum > 0.0 && sum.is_finite() { weights / sum } else { Vec4::X };
                let mut of = [0u16; 4];
                for k in 0..4 {
                    if share[k] > 0.0 {
                        of[k] = bone(joints[k])?;
                    }
                }
                held_by.push(of);
                shares.push(share.to_array());
            }
            (held_by, shares)
        }
    };
    let texture = texture(file, primitive.material)?;
    Ok(SkinnedPart { name, mesh, bones: held_by, weights, texture })
}

fn root_skin<'a>(file: &'a Container<'_>, node: usize) -> Found<Option<&'a gltf_json::Skin>> {
    let Some(skin) = file.root.nodes[node].skin else { return Ok(None) };
    file.root.skins.get(skin.value()).map(Some).ok_or_else(|| "is damaged: a skin is not there".into())
}

/// A material's colours, or its one colour.
fn texture(file: &Container<'_>, material: Option<Index<Material>>) -> Found<RgbImage> {
    let root = &file.root;
    let white = || RgbImage::from_pixel(2, 2, Rgb([255; 3]));
    let Some(material) = material else { return Ok(white()) };
    let material = root.materials.get(material.value()).ok_or("is damaged: a material is not there")?;
    let base = &material.pbr_metallic_roughness;
    let factor = base.base_color_factor.0.map(|f| f.clamp(0.0, 1.0));
    let mut picture = match &base.base_color_texture {
        None => white(),
        Some(info) => {
            let texture = root.textures.get(info.index.value()).ok_or("is damaged: a texture is not there")?;
            let image = root.images.get(texture.source.value()).ok_or("is damaged: an image is not there")?;
            let view = image.buffer_view.ok_or("keeps its pictures in other files")?;
            decode(file.view(view)?)?
        }
    };
    // The factor multiplies light, and the texture is sRGB (glTF 2.0 section 3.9.2).
    if factor[..3] != [1.0; 3] {
        for pixel in picture.pixels_mut() {
            for (value, factor) in pixel.0.iter_mut().zip(factor) {
                let light = (f32::from(*value) / 255.0).powf(2.2) * factor;
                *value = (light.powf(1.0 / 2.2) * 255.0).round() as u8;
            }
        }
    }
    Ok(picture)
}

fn decode(bytes: &[u8]) -> Found<RgbImage> {
    let reader = ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format();
    let mut reader = reader.map_err(|e| format!("has a picture that cannot be read: {e}"))?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(16 * MAX_TEXELS);
    reader.limits(limits);
    let image = reader.decode().map_err(|e| format!("has a picture that cannot be read: {e}"))?;
    if image.width() == 0 || u64::from(image.width()) * u64::from(image.height()) > MAX_TEXELS {
        return Err(format!("has a picture of {}x{} pixels", image.width(), image.height()));
    }
    Ok(image.into_rgb8())
}
