//! A picture in the making: its targets, and the buffers that change with it.

use std::sync::mpsc;
use std::time::Duration;

use bytemuck::cast_slice;
use glam::{Mat4, Vec4};
use image::RgbaImage;
use marey::Result;
use wgpu::{
    BindGroup, Buffer, BufferDescriptor, BufferUsages, CommandEncoder, Device, Extent3d, LoadOp, Operations, PollType,
    Queue, RenderPass, StoreOp, SubmissionIndex, Texture, TextureFormat, TextureUsages, TextureView,
};

use super::device::failed;
use super::pipelines::Shared;
use crate::bone_shapes::Corner;
use crate::picture::View;

/// The format of pictures that are read back.
pub(super) const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;
pub(super) const DEPTH: TextureFormat = TextureFormat::Depth32Float;
/// Three matrices and two vectors.
const FRAME: u64 = 4 * (3 * 16 + 2 * 4);
/// A picture that takes longer is given up: the device hangs.
const PATIENCE: Duration = Duration::from_secs(60);

/// A picture in the making.
#[derive(Debug)]
pub(super) struct Slot {
    size: (u32, u32),
    samples: u32,
    format: TextureFormat,
    /// Of several samples; with one a pixel the picture itself is drawn into.
    fine: Option<TextureView>,
    depth: TextureView,
    /// What is read back, where it is.
    own: Option<(Texture, TextureView, Buffer)>,
    frame: Buffer,
    bones: Buffer,
    bases: Buffer,
    shapes: Buffer,
    group: BindGroup,
    submitted: Option<SubmissionIndex>,
}

impl Slot {
    pub(super) fn new(
        device: &Device,
        shared: &Shared,
        size: (u32, u32),
        samples: u32,
        format: TextureFormat,
        own: bool,
    ) -> Self {
        let texture = |format, sample_count, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("marey"),
                size: extent(size),
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let view = |texture: &Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let own = own.then(|| {
            let picture = texture(format, 1, TextureUsages::COPY_SRC);
            let back = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
            let seen = view(&picture);
            (picture, seen, empty(device, readback_size(size), back))
        });
        let (frame, bones) = (
            empty(device, FRAME, BufferUsages::UNIFORM | BufferUsages::COPY_DST),
            empty(device, 48, BufferUsages::STORAGE | BufferUsages::COPY_DST),
        );
        let vertex = BufferUsages::VERTEX | BufferUsages::COPY_DST;
        Self {
            size,
            samples,
            format,
            fine: (samples > 1).then(|| view(&texture(format, samples, TextureUsages::empty()))),
            depth: view(&texture(DEPTH, samples, TextureUsages::empty())),
            own,
            group: group(device, shared, &frame, &bones),
            frame,
            bones,
            bases: empty(device, 4, vertex),
            shapes: empty(device, 24, vertex),
            submitted: None,
        }
    }

    pub(super) fn fits(&self, size: (u32, u32), samples: u32, format: TextureFormat, own: bool) -> bool {
        (self.size, self.samples, self.format, self.own.is_some()) == (size, samples, format, own)
    }

    pub(super) fn samples(&self) -> u32 {
        self.samples
    }

    pub(super) fn format(&self) -> TextureFormat {
        self.format
    }

    pub(super) fn group(&self) -> &BindGroup {
        &self.group
    }

    pub(super) fn bases(&self) -> &Buffer {
        &self.bases
    }

    pub(super) fn shapes(&self) -> &Buffer {
        &self.shapes
    }

    /// Hands over what changes with the picture.
    pub(super) fn fill(
        &mut self,
        device: &Device,
        queue: &Queue,
        shared: &Shared,
        view: &View,
        bones: &[f32],
        bases: &[u32],
        shapes: &[Corner],
    ) {
        let flat = view.shadow.unwrap_or(Mat4::IDENTITY);
        let tones = Vec4::new(view.tones.0, view.tones.1, 0.0, 0.0);
        let matrices = [view.projection, view.turn, flat].map(|m| m.to_cols_array());
        let vectors = [view.shadow_color, tones].map(|v| v.to_array());
        let frame: Vec<f32> = matrices.as_flattened().iter().chain(vectors.as_flattened()).copied().collect();
        let shapes: Vec<f32> = shapes.iter().flat_map(|c| [c.at.to_array(), c.color.to_array()]).flatten().collect();
        queue.write_buffer(&self.frame, 0, cast_slice(&frame));
        if put(device, queue, &mut self.bones, cast_slice(bones)) {
            self.group = group(device, shared, &self.frame, &self.bones);
        }
        put(device, queue, &mut self.bases, cast_slice(bases));
        put(device, queue, &mut self.shapes, cast_slice(&shapes));
    }

    /// Begins drawing, into the host's target or our own.
    pub(super) fn begin<'a>(
        &'a self,
        encoder: &'a mut CommandEncoder,
        clear: Vec4,
        target: Option<&'a TextureView>,
    ) -> RenderPass<'a> {
        let target = target.or(self.own.as_ref().map(|own| &own.1));
        let [r, g, b, a] = clear.to_array().map(f64::from);
        let color = self.fine.as_ref().or(target).map(|view| wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: target.filter(|_| self.fine.is_some()),
            ops: Operations {
                load: LoadOp::Clear(wgpu::Color { r, g, b, a }),
                // Samples are not looked at again.
                store: if self.fine.is_some() { StoreOp::Discard } else { StoreOp::Store },
            },
        });
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("marey"),
            color_attachments: &[color],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(Operations { load: LoadOp::Clear(1.0), store: StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }

    /// Sets the device to work, and where the picture is our own has it copied to where it can be read.
    pub(super) fn submit(&mut self, mut encoder: CommandEncoder, queue: &Queue) {
        if let Some((picture, _, back)) = &self.own {
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row(self.size.0)), rows_per_image: None };
            let to = wgpu::TexelCopyBufferInfo { buffer: back, layout };
            encoder.copy_texture_to_buffer(picture.as_image_copy(), to, extent(self.size));
        }
        self.submitted = Some(queue.submit([encoder.finish()]));
    }

    /// Waits for the picture, and gives it with straight alpha.
    pub(super) fn read(&mut self, device: &Device, (width, height): (u32, u32)) -> Result<RgbaImage> {
        let mut out = RgbaImage::new(width, height);
        let Some((_, _, back)) = &self.own else { return Ok(out) };
        let bad = |problem: String| failed("the GPU", problem, "try again, or draw on the CPU");
        let (done, mapped) = mpsc::channel();
        back.map_async(wgpu::MapMode::Read, .., move |result| {
            // Whoever waits has gone only after a failure of its own.
            let _ = done.send(result);
        });
        let wait = PollType::Wait { submission_index: self.submitted.take(), timeout: Some(PATIENCE) };
        device.poll(wait).map_err(|e| bad(format!("gave no picture: {e}")))?;
        let mapped = mapped.try_recv().map_err(|e| bad(format!("gave no picture: {e}")))?;
        mapped.map_err(|e| bad(format!("gave no picture: {e}")))?;
        {
            let bytes = back.get_mapped_range(..).map_err(|e| bad(format!("gave no picture: {e}")))?;
            let rows = bytes.chunks_exact(row(width) as usize);
            for (to, from) in out.chunks_exact_mut(4 * width as usize).zip(rows) {
                for (to, from) in to.chunks_exact_mut(4).zip(from.chunks_exact(4)) {
                    straight(from, to);
                }
            }
        }
        back.unmap();
        Ok(out)
    }
}

#[inline]
fn straight(from: &[u8], to: &mut [u8]) {
    match u32::from(from[3]) {
        0 => to.fill(0),
        255 => to.copy_from_slice(from),
        alpha => {
            for c in 0..3 {
                to[c] = ((u32::from(from[c]) * 255 + alpha / 2) / alpha).min(255) as u8;
            }
            to[3] = from[3];
        }
    }
}

/// Bytes of a row as it is read back.
fn row(width: u32) -> u32 {
    (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// Bytes of a picture as it is read back.
pub(super) fn readback_size((width, height): (u32, u32)) -> u64 {
    u64::from(row(width)) * u64::from(height)
}

fn extent((width, height): (u32, u32)) -> Extent3d {
    Extent3d { width, height, depth_or_array_layers: 1 }
}

fn empty(device: &Device, size: u64, usage: BufferUsages) -> Buffer {
    device.create_buffer(&BufferDescriptor { label: Some("marey"), size, usage, mapped_at_creation: false })
}

fn group(device: &Device, shared: &Shared, frame: &Buffer, bones: &Buffer) -> BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("marey"),
        layout: &shared.picture,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: bones.as_entire_binding() },
        ],
    })
}

/// Writes into a buffer, of a new one where it is too small. Says whether it is new.
fn put(device: &Device, queue: &Queue, buffer: &mut Buffer, bytes: &[u8]) -> bool {
    let grows = buffer.size() < bytes.len() as u64;
    if grows {
        *buffer = empty(device, (bytes.len() as u64).next_power_of_two(), buffer.usage());
    }
    queue.write_buffer(buffer, 0, bytes);
    grows
}
