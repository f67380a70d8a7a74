//! An independent reader of binary glTF: meshes, morphed and posed by the format's own rules.

use std::collections::HashMap;

use glam::{Mat4, Quat, Vec3};
use gltf::animation::Interpolation;
use gltf::animation::util::ReadOutputs;

/// A key-framed channel: times and values.
type Keys<T> = HashMap<usize, (Vec<f32>, Vec<T>, Interpolation)>;

pub(crate) struct Reader {
    pub(crate) document: gltf::Document,
    pub(crate) blob: Vec<u8>,
    pub(crate) rotations: Keys<Quat>,
    pub(crate) translations: Keys<Vec3>,
    scales: Keys<Vec3>,
    morphs: Keys<f32>,
}

impl Reader {
    pub(crate) fn open(bytes: &[u8]) -> Self {
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(bytes).expect("readable");
        let mut reader = Self {
            document,
            blob: blob.expect("a buffer"),
            rotations: HashMap::new(),
            translations: HashMap::new(),
            scales: HashMap::new(),
            morphs: HashMap::new(),
        };
        let document = reader.document.clone();
        for channel in document.animations().flat_map(|a| a.channels().collect::<Vec<_>>()) {
            let data = channel.reader(|_| Some(&reader.blob));
            let times: Vec<f32> = data.read_inputs().expect("times").collect();
            let node = channel.target().node().index();
            let how = channel.sampler().interpolation();
            match data.read_outputs().expect("values") {
                ReadOutputs::Rotations(values) => {
                    let values: Vec<Quat> = values.into_f32().map(Quat::from_array).collect();
                    assert_eq!(values.len(), times.len());
                    reader.rotations.insert(node, (times, values, how));
                }
                ReadOutputs::Translations(values) => {
                    let values: Vec<Vec3> = values.map(Vec3::from_array).collect();
                    assert_eq!(values.len(), times.len());
                    reader.translations.insert(node, (times, values, how));
                }
                ReadOutputs::Scales(values) => {
                    reader.scales.insert(node, (times, values.map(Vec3::from_array).collect(), how));
                }
                ReadOutputs::MorphTargetWeights(values) => {
                    reader.morphs.insert(node, (times, values.into_f32().collect(), how));
                }
            }
        }
        reader
    }

    fn world(&self, time: f32) -> HashMap<usize, Mat4> {
        let mut world = HashMap::new();
        let scene = self.document.default_scene().expect("a scene");
        let mut waiting: Vec<(gltf::Node<'_>, Mat4)> = scene.nodes().map(|n| (n, Mat4::IDENTITY)).collect();
        while let Some((node, above)) = waiting.pop() {
            let (mut translation, mut rotation, mut scale) = {
                let (t, r, s) = node.transform().decomposed();
                (Vec3::from_array(t), Quat::from_array(r), Vec3::from_array(s))
            };
            if let Some((times, values, how)) = self.translations.get(&node.index()) {
                let (i, share) = between(times, time, *how);
                translation = values[i].lerp(values[(i + 1).min(values.len() - 1)], share);
            }
            if let Some((times, values, how)) = self.scales.get(&node.index()) {
                let (i, share) = between(times, time, *how);
                scale = values[i].lerp(values[(i + 1).min(values.len() - 1)], share);
            }
            if let Some((times, values, how)) = self.rotations.get(&node.index()) {
                let (i, share) = between(times, time, *how);
                // As the format says: spherical, along the shorter arc only because the signs agree.
                let (a, b) = (values[i], values[(i + 1).min(values.len() - 1)]);
                assert!(a.dot(b) >= 0.0, "neighbouring keys lie on one side");
                rotation = a.slerp(b, share);
            }
            let matrix = above * Mat4::from_scale_rotation_translation(scale, rotation, translation);
            world.insert(node.index(), matrix);
            waiting.extend(node.children().map(|c| (c, matrix)));
        }
        world
    }

    /// Positions of every mesh at `time`, by its node's name.
    pub(crate) fn pose(&self, time: f32) -> HashMap<String, Vec<Vec3>> {
        let world = self.world(time);
        let mut posed = HashMap::new();
        for node in self.document.nodes() {
            let (Some(mesh), Some(skin)) = (node.mesh(), node.skin()) else { continue };
            let inverse: Vec<Mat4> = skin
                .reader(|_| Some(&self.blob))
                .read_inverse_bind_matrices()
                .expect("matrices")
                .map(|m| Mat4::from_cols_array_2d(&m))
                .collect();
            let skin: Vec<Mat4> = skin.joints().zip(inverse).map(|(j, m)| world[&j.index()] * m).collect();
            let primitive = mesh.primitives().next().expect("a primitive");
            let data = primitive.reader(|_| Some(&self.blob));
            let mut positions: Vec<Vec3> = data.read_positions().expect("positions").map(Vec3::from_array).collect();
            if let Some((times, values, how)) = self.morphs.get(&node.index()) {
                let (i, share) = between(times, time, *how);
                let targets = values.len() / times.len();
                for (t, (moved, _, _)) in data.read_morph_targets().enumerate() {
                    let weight = |key: usize| values[key.min(times.len() - 1) * targets + t];
                    let weight = weight(i) + (weight(i + 1) - weight(i)) * share;
                    for (p, way) in positions.iter_mut().zip(moved.expect("displacements")) {
                        *p += Vec3::from_array(way) * weight;
                    }
                }
            }
            let joints = data.read_joints(0).expect("joints").into_u16();
            let weights = data.read_weights(0).expect("weights").into_f32();
            let indices: Vec<u32> = data.read_indices().expect("indices").into_u32().collect();
            assert!(indices.iter().all(|&i| (i as usize) < positions.len()));
            let moved = positions.iter().zip(joints.zip(weights)).map(|(p, (joints, weights))| {
                let sum: f32 = weights.iter().sum();
                assert!((sum - 1.0).abs() <= 1e-6);
                joints.iter().zip(weights).map(|(j, w)| skin[usize::from(*j)].transform_point3(*p) * w).sum()
            });
            posed.insert(node.name().expect("a name").to_owned(), moved.collect());
        }
        posed
    }
}

fn between(times: &[f32], time: f32, how: Interpolation) -> (usize, f32) {
    let i = times.iter().rposition(|t| *t <= time).unwrap_or(0);
    match times.get(i + 1) {
        Some(next) if how == Interpolation::Linear => (i, ((time - times[i]) / (next - times[i])).clamp(0.0, 1.0)),
        _ => (i, 0.0),
    }
}
