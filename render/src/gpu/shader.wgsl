// Surfaces on bones. The CPU's `shading.rs` and `cpu` compute the same; constants are put before this text from there.

struct Frame {
    // World to clip coordinates.
    projection: mat4x4f,
    // World to view.
    turn: mat4x4f,
    // World to the floor along the light.
    flat: mat4x4f,
    // The shadow on the background, premultiplied.
    shadow: vec4f,
    // View z that the depth style shows white and black.
    tones: vec4f,
}

@group(0) @binding(0) var<uniform> frame: Frame;
// What moves a surface: the rows of a matrix a bone, of all instances.
@group(0) @binding(1) var<storage, read> bones: array<mat3x4f>;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var smooth_sampler: sampler;

// Which style the vertices are coloured for; the numbers are the pipeline's.
override STYLE: u32 = 0;

struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) bones: vec4u,
    @location(4) weights: vec4f,
    @location(5) color: vec4f,
    // Where the instance's bones begin.
    @location(6) base: u32,
}

struct Painted {
    @builtin(position) clip: vec4f,
    @location(0) tint: vec3f,
}

struct Textured {
    @builtin(position) clip: vec4f,
    @location(0) tint: vec3f,
    @location(1) uv: vec2f,
}

struct Edged {
    @builtin(position) clip: vec4f,
    @location(0) tint: vec3f,
    @location(1) share: vec3f,
}

fn blend(v: Vertex) -> mat3x4f {
    var sum = bones[v.base + v.bones.x] * v.weights.x;
    if v.weights.y > 0.0 { sum += bones[v.base + v.bones.y] * v.weights.y; }
    if v.weights.z > 0.0 { sum += bones[v.base + v.bones.z] * v.weights.z; }
    if v.weights.w > 0.0 { sum += bones[v.base + v.bones.w] * v.weights.w; }
    return sum;
}

fn light(normal: vec3f) -> f32 {
    return AMBIENT + (1.0 - AMBIENT) * max(dot(normal, LAMP), 0.0);
}

fn surface(v: Vertex) -> Painted {
    let moved = blend(v);
    let place = vec4f(vec4f(v.position, 1.0) * moved, 1.0);
    var out: Painted;
    out.clip = frame.projection * place;
    if STYLE == TEXTURED {
        out.tint = vec3f(1.0);
        return out;
    }
    if STYLE == DEPTH {
        let z = (frame.turn * place).z;
        out.tint = vec3f(saturate((z - frame.tones.y) / (frame.tones.x - frame.tones.y)));
        return out;
    }
    let turned = (frame.turn * vec4f(vec4f(v.normal, 0.0) * moved, 0.0)).xyz;
    let length = length(turned);
    let normal = select(vec3f(0.0, 0.0, 1.0), turned / length, length > 0.0);
    if STYLE == NORMALS {
        out.tint = normal * 0.5 + 0.5;
    } else if STYLE == WIREFRAME {
        out.tint = CLAY * light(normal);
    } else if STYLE == SHADED {
        out.tint = vec3f(light(normal));
    } else {
        out.tint = v.color.rgb * light(normal);
    }
    return out;
}

@vertex
fn painted_vertex(v: Vertex) -> Painted {
    return surface(v);
}

@fragment
fn painted(in: Painted) -> @location(0) vec4f {
    return vec4f(in.tint, 1.0);
}

@vertex
fn textured_vertex(v: Vertex) -> Textured {
    let s = surface(v);
    return Textured(s.clip, s.tint, v.uv);
}

@fragment
fn textured(in: Textured) -> @location(0) vec4f {
    return vec4f(textureSample(image, smooth_sampler, in.uv).rgb * in.tint, 1.0);
}

@vertex
fn edged_vertex(v: Vertex, @builtin(vertex_index) index: u32) -> Edged {
    let s = surface(v);
    let corner = index % 3u;
    return Edged(s.clip, s.tint, vec3f(f32(corner == 0u), f32(corner == 1u), f32(corner == 2u)));
}

@fragment
fn edged(in: Edged) -> @location(0) vec4f {
    let right = dpdx(in.share);
    let down = dpdy(in.share);
    let heights = 1.0 / max(sqrt(right * right + down * down), vec3f(1e-6));
    let apart = in.share * heights;
    let lowest = min(heights.x, min(heights.y, heights.z));
    let strength = clamp(lowest / CROWDED, FAINTEST, 1.0);
    let line = strength * clamp(HALF_LINE + 0.5 - min(apart.x, min(apart.y, apart.z)), 0.0, 1.0);
    return vec4f(mix(in.tint, LINE, line), 1.0);
}

@vertex
fn shadow_vertex(v: Vertex) -> @builtin(position) vec4f {
    let place = vec4f(vec4f(v.position, 1.0) * blend(v), 1.0);
    return frame.projection * (frame.flat * place);
}

@fragment
fn shadow() -> @location(0) vec4f {
    return frame.shadow;
}

@vertex
fn shape_vertex(@location(0) at: vec3f, @location(1) color: vec3f) -> Painted {
    return Painted(frame.projection * vec4f(at, 1.0), color);
}
