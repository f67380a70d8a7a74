//! Pipelines: what is drawn how. Made when first needed.

use wgpu::{
    BindGroupLayout, BindGroupLayoutEntry, BindingType, BufferBindingType, CompareFunction, DepthStencilState, Device,
    Face, FilterMode, FragmentState, MipmapFilterMode, MultisampleState, PipelineCompilationOptions, PipelineLayout,
    PrimitiveState, RenderPipeline, Sampler, SamplerBindingType, SamplerDescriptor, ShaderModule, ShaderStages,
    TextureFormat, TextureSampleType, TextureViewDimension, VertexAttribute, VertexBufferLayout, VertexState,
    VertexStepMode, vertex_attr_array,
};

use super::slot::DEPTH;
use crate::Style;
use crate::shading::{AMBIENT, CLAY, CROWDED, FAINTEST, HALF_LINE, LAMP, LINE};

/// Words of a vertex: position, normal, texture coordinates, four bones in two, weights.
pub(super) const VERTEX: usize = 14;
const SURFACE: [VertexAttribute; 5] =
    vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Uint16x4, 4 => Float32x4];
const COLOR: [VertexAttribute; 1] = vertex_attr_array![5 => Unorm8x4];
const BASE: [VertexAttribute; 1] = vertex_attr_array![6 => Uint32];
const SHAPE: [VertexAttribute; 2] = vertex_attr_array![0 => Float32x3, 1 => Float32x3];

/// What a pipeline draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Shadow,
    Surface(Style),
    Shapes,
}

/// What a pipeline is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Key {
    pub(super) kind: Kind,
    pub(super) format: TextureFormat,
    pub(super) samples: u32,
}

/// What all pipelines share.
#[derive(Debug)]
pub(super) struct Shared {
    shader: ShaderModule,
    /// Of a picture: its numbers and its bones.
    pub(super) picture: BindGroupLayout,
    /// Of a part: its texture.
    pub(super) texture: BindGroupLayout,
    pub(super) sampler: Sampler,
    layout: PipelineLayout,
}

impl Shared {
    pub(super) fn new(device: &Device) -> Self {
        let vec3 = |v: glam::Vec3| format!("vec3f({:?}, {:?}, {:?})", v.x, v.y, v.z);
        let styles: String = Style::ALL
            .iter()
            .map(|(style, name)| format!("const {}: u32 = {}u;\n", name.to_uppercase(), *style as u32))
            .collect();
        let numbers = format!(
            "const AMBIENT = {AMBIENT:?};\nconst LAMP = {};\nconst CLAY = {};\nconst LINE = {};\n\
             const HALF_LINE = {HALF_LINE:?};\nconst CROWDED = {CROWDED:?};\nconst FAINTEST = {FAINTEST:?};\n",
            vec3(LAMP.normalize_or(glam::Vec3::Z)),
            vec3(CLAY),
            vec3(LINE),
        );
        let source = [&styles, &numbers, include_str!("shader.wgsl")].concat();
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("marey"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let entry = |binding: u32, visibility: ShaderStages, ty: BindingType| BindGroupLayoutEntry {
            binding,
            visibility,
            ty,
            count: None,
        };
        let buffer =
            |ty: BufferBindingType| BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let group = |entries: &[BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("marey"), entries })
        };
        let picture = group(&[
            entry(0, ShaderStages::VERTEX_FRAGMENT, buffer(BufferBindingType::Uniform)),
            entry(1, ShaderStages::VERTEX, buffer(BufferBindingType::Storage { read_only: true })),
        ]);
        let image = BindingType::Texture {
            sample_type: TextureSampleType::Float { filterable: true },
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let texture = group(&[
            entry(0, ShaderStages::FRAGMENT, image),
            entry(1, ShaderStages::FRAGMENT, BindingType::Sampler(SamplerBindingType::Filtering)),
        ]);
        let sampler = device.create_sampler(&SamplerDescriptor {
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            mipmap_filter: MipmapFilterMode::Linear,
            ..SamplerDescriptor::default()
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("marey"),
            bind_group_layouts: &[Some(&picture), Some(&texture)],
            immediate_size: 0,
        });
        Self { shader, picture, texture, sampler, layout }
    }

    pub(super) fn pipeline(&self, device: &Device, Key { kind, format, samples }: Key) -> RenderPipeline {
        let (vertex, fragment) = match kind {
            Kind::Shadow => ("shadow_vertex", "shadow"),
            Kind::Shapes => ("shape_vertex", "painted"),
            Kind::Surface(Style::Wireframe) => ("edged_vertex", "edged"),
            Kind::Surface(style) if style.is_textured() => ("textured_vertex", "textured"),
            Kind::Surface(_) => ("painted_vertex", "painted"),
        };
        let style = if let Kind::Surface(style) = kind { style as u32 } else { 0 };
        let constants = [("STYLE", f64::from(style))];
        let chosen = PipelineCompilationOptions { constants: &constants, ..Default::default() };
        let layout = |words: usize, step_mode, attributes| {
            Some(VertexBufferLayout { array_stride: 4 * words as u64, step_mode, attributes })
        };
        let surface = [
            layout(VERTEX, VertexStepMode::Vertex, &SURFACE[..]),
            layout(1, VertexStepMode::Vertex, &COLOR),
            layout(1, VertexStepMode::Instance, &BASE),
        ];
        let shape = [layout(6, VertexStepMode::Vertex, &SHAPE[..])];
        // Shapes are in front of all, each hiding its own back; shadows are behind all.
        let hides = matches!(kind, Kind::Surface(_));
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("marey"),
            layout: Some(&self.layout),
            vertex: VertexState {
                module: &self.shader,
                entry_point: Some(vertex),
                compilation_options: chosen.clone(),
                buffers: if kind == Kind::Shapes { &shape } else { &surface },
            },
            primitive: PrimitiveState {
                cull_mode: (kind == Kind::Shapes).then_some(Face::Back),
                ..PrimitiveState::default()
            },
            depth_stencil: Some(DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(hides),
                depth_compare: Some(if hides { CompareFunction::Less } else { CompareFunction::Always }),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: MultisampleState { count: samples, ..MultisampleState::default() },
            fragment: Some(FragmentState {
                module: &self.shader,
                entry_point: Some(fragment),
                compilation_options: chosen,
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
