//! The animation of a glTF file: one rotation and one translation channel a bone, keyed on every frame.
//!
//! Between keys rotations are slerped and translations lerped (`LINEAR`, glTF 2.0 section 3.11), so neighbouring
//! quaternions are brought to one hemisphere first. A channel that never changes is one key, and none at all where it
//! is what the bone's node says anyway.

use std::collections::BTreeMap;

use glam::{Quat, Vec3};
use gltf_json::accessor::{Accessor, Type};
use gltf_json::animation::{Animation, Channel, Interpolation, Property, Sampler, Target};
use gltf_json::scene::Node;
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};

use super::buffer::Buffer;
use crate::shape::Transform;

/// Values closer than this are the same: far below what a 16-bit texture or a screen could show.
const SAME_ROTATION: f32 = 1e-6;
const SAME_TRANSLATION: f32 = 1e-5;

/// Adds channels for bones with these nodes: from `rest` through `poses`, one a frame.
pub(super) fn add(
    writer: &mut Writer<'_>,
    rest: &[Transform],
    poses: &[Vec<Transform>],
    scale: f32,
    nodes: &[Index<Node>],
) {
    for (bone, &node) in nodes.iter().enumerate() {
        let rest = &rest[bone];
        let rotations = continuous(rest.rotation.normalize(), poses.iter().map(|f| f[bone].rotation));
        let near = |a: &[f32; 4], b: &[f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME_ROTATION);
        writer.all(node, Property::Rotation, Type::Vec4, &rotations, rest.rotation.normalize().to_array(), near);

        let scaled = |t: Vec3| (t * scale).to_array();
        let translations: Vec<[f32; 3]> = poses.iter().map(|f| scaled(f[bone].translation)).collect();
        let near =
            move |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME_TRANSLATION * scale);
        writer.all(node, Property::Translation, Type::Vec3, &translations, scaled(rest.translation), near);
    }
}

/// Unit quaternions, each on the side of the one before it, the first on that of `start`.
fn continuous(start: Quat, rotations: impl Iterator<Item = Quat>) -> Vec<[f32; 4]> {
    let mut last = start;
    rotations
        .map(|q| {
            let q = q.normalize();
            last = if last.dot(q) < 0.0 { -q } else { q };
            last.to_array()
        })
        .collect()
}

/// Channels in the making.
pub(in crate::export) struct Writer<'a> {
    pub(in crate::export) root: &'a mut Root,
    pub(in crate::export) buffer: &'a mut Buffer,
    fps: f64,
    /// The accessors of keys' times, by their frames.
    times: BTreeMap<Vec<usize>, Index<Accessor>>,
    channels: Vec<Channel>,
    samplers: Vec<Sampler>,
}

impl<'a> Writer<'a> {
    pub(in crate::export) fn new(root: &'a mut Root, buffer: &'a mut Buffer, fps: f64) -> Self {
        Self { root, buffer, fps, times: BTreeMap::new(), channels: Vec::new(), samplers: Vec::new() }
    }

    /// Adds the animation, where it has channels.
    pub(in crate::export) fn finish(self, name: &str) {
        let (channels, samplers) = (self.channels, self.samplers);
        if !channels.is_empty() {
            self.root.push(Animation { extensions: None, extras: None, channels, name: Some(name.into()), samplers });
        }
    }

    /// A channel with a key on every frame, unless nothing changes.
    fn all<const N: usize>(
        &mut self,
        node: Index<Node>,
        property: Property,
        type_: Type,
        values: &[[f32; N]],
        at_rest: [f32; N],
        same: impl Fn(&[f32; N], &[f32; N]) -> bool,
    ) {
        let Some(first) = values.first() else { return };
        let still = values.iter().all(|v| same(v, first));
        if still && same(first, &at_rest) {
            return;
        }
        let frames: Vec<usize> = (0..if still { 1 } else { values.len() }).collect();
        self.keys(node, property, type_, &frames, &values[..frames.len()], still);
    }

    /// A channel with keys on `frames`; for weights `values` has as many for each as there are targets.
    pub(in crate::export) fn keys<const N: usize>(
        &mut self,
        node: Index<Node>,
        property: Property,
        type_: Type,
        frames: &[usize],
        values: &[[f32; N]],
        holds: bool,
    ) {
        let input = match self.times.get(frames) {
            Some(&known) => known,
            None => {
                let times: Vec<[f32; 1]> = frames.iter().map(|f| [(*f as f64 / self.fps) as f32]).collect();
                let accessor = self.buffer.floats(self.root, &times, Type::Scalar, None, true);
                self.times.insert(frames.to_vec(), accessor);
                accessor
            }
        };
        let output = self.buffer.floats(self.root, values, type_, None, false);
        let sampler = Index::new(self.samplers.len() as u32);
        let interpolation = Checked::Valid(if holds { Interpolation::Step } else { Interpolation::Linear });
        self.samplers.push(Sampler { extensions: None, extras: None, input, interpolation, output });
        let target = Target { extensions: None, extras: None, node, path: Checked::Valid(property) };
        self.channels.push(Channel { sampler, target, extensions: None, extras: None });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_rotations_never_take_the_long_way() {
        let turn = |degrees: f32| Quat::from_rotation_y(degrees.to_radians());
        let given = [turn(170.0), -turn(175.0), turn(181.0), -turn(359.0), turn(365.0)];
        let out = continuous(-turn(165.0), given.into_iter());
        let mut last = -turn(165.0);
        for (q, original) in out.into_iter().map(Quat::from_array).zip(given) {
            assert!(last.dot(q) >= 0.0);
            assert!(q.dot(original).abs() > 0.999_999, "the rotation itself stays");
            last = q;
        }
    }
}
