//! Colours of vertices. The GPU's `shader.wgsl` computes the same.

use glam::{Vec3, vec3};

/// Share of light that falls on a face turned away from the lamp.
pub(crate) const AMBIENT: f32 = 0.55;
/// Where the lamp is, as the viewer sees it: over the left shoulder.
pub(crate) const LAMP: Vec3 = vec3(-0.35, 0.5, 0.79);
/// What wireframes are drawn on.
pub(crate) const CLAY: Vec3 = vec3(0.80, 0.79, 0.76);
/// What wireframes are drawn with.
pub(crate) const LINE: Vec3 = vec3(0.10, 0.16, 0.26);
/// Half the width of a line, in pixels.
pub(crate) const HALF_LINE: f32 = 0.55;
/// Triangles lower than this many pixels have fainter edges: black all over would show no form.
pub(crate) const CROWDED: f32 = 6.0;
/// How faint they become.
pub(crate) const FAINTEST: f32 = 0.25;

/// How bright a face is whose normal the viewer sees so.
pub(crate) fn light(normal: Vec3) -> f32 {
    AMBIENT + (1.0 - AMBIENT) * normal.dot(LAMP.normalize_or(Vec3::Z)).max(0.0)
}

/// Colours from dark blue over green to yellow that also tell in grey: the corners of matplotlib's viridis (CC0).
pub(crate) fn ramp(share: f32) -> Vec3 {
    const STOPS: [Vec3; 6] = [
        vec3(0.267, 0.005, 0.329),
        vec3(0.254, 0.265, 0.530),
        vec3(0.164, 0.471, 0.558),
        vec3(0.135, 0.659, 0.518),
        vec3(0.478, 0.821, 0.3185),
        vec3(0.993, 0.906, 0.144),
    ];
    let at = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let i = (at as usize).min(STOPS.len() - 2);
    STOPS[i].lerp(STOPS[i + 1], at - i as f32)
}

/// The colour of the `index`-th limb: hues a golden angle apart, so that any number of them differ.
pub(crate) fn limb_color(index: usize) -> Vec3 {
    let hue = (0.58 + index as f32 * 0.618_034).fract() * 6.0;
    let wave = |shift: f32| (((hue + shift) % 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
    let pure = vec3(wave(0.0), wave(4.0), wave(2.0));
    Vec3::splat(0.30).lerp(pure, 0.75) * 0.92 + 0.06
}
