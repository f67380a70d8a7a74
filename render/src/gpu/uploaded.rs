//! What a device holds of a model.

use std::sync::OnceLock;

use marey::shape::SkinnedPart;
use wgpu::util::DeviceExt as _;
use wgpu::{BindGroup, Buffer, BufferUsages, Device, Extent3d, Queue, RenderPass, TextureFormat};

use super::pipelines::Shared;
use crate::Style;
use crate::model::Prepared;
use crate::texture::Texture;

/// What a device holds of a model.
#[derive(Debug)]
pub(super) struct Uploaded {
    parts: Vec<Part>,
    /// Colours for the styles that have some, when first needed.
    radius: OnceLock<Vec<Buffer>>,
    bones: OnceLock<Vec<Buffer>>,
    /// Vertices of one triangle after the other, when first needed: edges need to know which corner is which.
    apart: OnceLock<Vec<Buffer>>,
}

#[derive(Debug)]
struct Part {
    vertices: Buffer,
    indices: Buffer,
    /// Stands in where a style has no colours, with as many as any other would have.
    blank: Buffer,
    corners: u32,
    texture: BindGroup,
}

impl Uploaded {
    pub(super) fn new(device: &Device, queue: &Queue, shared: &Shared, model: &Prepared) -> Self {
        let part = |(part, texture): (&SkinnedPart, &Texture)| {
            let triangles = &part.mesh.triangles;
            // Once by index, and once corner by corner for the wireframe.
            let most = part.mesh.positions.len().max(3 * triangles.len());
            Part {
                vertices: buffer(device, &vertices(part, 0..part.mesh.positions.len()), BufferUsages::VERTEX),
                indices: buffer(device, triangles.as_flattened(), BufferUsages::INDEX),
                blank: buffer(device, &vec![u32::MAX; most], BufferUsages::VERTEX),
                corners: 3 * triangles.len() as u32,
                texture: upload(device, queue, shared, texture),
            }
        };
        let parts = model.rig.parts.iter().zip(&model.textures).map(part).collect();
        let (radius, bones, apart) = Default::default();
        Self { parts, radius, bones, apart }
    }

    /// Draws so many instances, of which the bases of the bones are bound.
    pub(super) fn draw(
        &self,
        device: &Device,
        pass: &mut RenderPass<'_>,
        model: &Prepared,
        style: Style,
        instances: u32,
    ) {
        let colors = match style {
            Style::Radius => Some(&self.radius),
            Style::Bones => Some(&self.bones),
            _ => None,
        };
        let colors = colors.map(|held| {
            held.get_or_init(|| {
                let colors = model.colors(style).unwrap_or_default();
                colors.iter().map(|c| buffer(device, bytemuck::cast_slice(c), BufferUsages::VERTEX)).collect()
            })
        });
        let apart = (style == Style::Wireframe).then(|| {
            self.apart.get_or_init(|| {
                let corners =
                    |p: &SkinnedPart| vertices(p, p.mesh.triangles.as_flattened().iter().map(|v| *v as usize));
                model.rig.parts.iter().map(|p| buffer(device, &corners(p), BufferUsages::VERTEX)).collect()
            })
        });
        for (p, part) in self.parts.iter().enumerate().filter(|(_, part)| part.corners > 0) {
            // The layout has a texture, used or not.
            pass.set_bind_group(1, &part.texture, &[]);
            pass.set_vertex_buffer(1, colors.map_or(&part.blank, |c| &c[p]).slice(..));
            match apart {
                Some(apart) => {
                    pass.set_vertex_buffer(0, apart[p].slice(..));
                    pass.draw(0..part.corners, 0..instances);
                }
                None => {
                    pass.set_vertex_buffer(0, part.vertices.slice(..));
                    pass.set_index_buffer(part.indices.slice(..), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed(0..part.corners, 0, 0..instances);
                }
            }
        }
    }
}

fn vertices(part: &SkinnedPart, which: impl Iterator<Item = usize>) -> Vec<u32> {
    let vertex = |v: usize| {
        let (p, n, uv) = (part.mesh.positions[v], part.mesh.normals[v], part.mesh.uvs[v]);
        let place = [p.x, p.y, p.z, n.x, n.y, n.z, uv.x, uv.y].map(f32::to_bits);
        let [a, b, c, d] = part.bones[v].map(u32::from);
        place.into_iter().chain([a | b << 16, c | d << 16]).chain(part.weights[v].map(f32::to_bits))
    };
    which.flat_map(vertex).collect()
}

fn buffer(device: &Device, words: &[u32], usage: BufferUsages) -> Buffer {
    // A buffer of nothing cannot be bound.
    let contents: &[u8] = if words.is_empty() { &[0; 64] } else { bytemuck::cast_slice(words) };
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("marey"), contents, usage })
}

fn upload(device: &Device, queue: &Queue, shared: &Shared, texture: &Texture) -> BindGroup {
    // What is larger than the device holds is shown by its smaller versions.
    let most = device.limits().max_texture_dimension_2d;
    let fits = |level: &&image::RgbImage| level.width().max(level.height()) <= most;
    let shrunk;
    let mut levels: Vec<&image::RgbImage> = texture.levels.iter().filter(fits).collect();
    if levels.is_empty() {
        let last = &texture.levels[texture.levels.len() - 1];
        let (w, h) = (last.width().min(most), last.height().min(most));
        shrunk = image::imageops::resize(last, w, h, image::imageops::FilterType::Triangle);
        levels.push(&shrunk);
    }
    let size =
        |level: &image::RgbImage| Extent3d { width: level.width(), height: level.height(), depth_or_array_layers: 1 };
    let on_device = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("marey"),
        size: size(levels[0]),
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (mip_level, level) in (0..).zip(&levels) {
        let pixels: Vec<u8> = level.pixels().flat_map(|p| [p.0[0], p.0[1], p.0[2], 255]).collect();
        let to = wgpu::TexelCopyTextureInfo { mip_level, ..on_device.as_image_copy() };
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * level.width()), rows_per_image: None };
        queue.write_texture(to, &pixels, layout, size(level));
    }
    let view = on_device.create_view(&wgpu::TextureViewDescriptor::default());
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("marey"),
        layout: &shared.texture,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&shared.sampler) },
        ],
    })
}
