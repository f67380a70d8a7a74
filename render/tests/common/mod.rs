//! A walking animal of tubes, as fine as wanted: what tests and measurements draw.

use glam::{Mat4, Quat, Vec2, Vec3, vec2, vec3};
use image::{Rgb, RgbImage};
use marey::geometry::TriMesh;
use marey::shape::{Bone, RiggedModel, SkinnedPart, Transform};

/// Limbs: name, root and tip, radii there, swing in degrees, phase.
const LIMBS: [(&str, Vec3, Vec3, f32, f32, f32, f32); 6] = [
    ("body", vec3(90.0, 130.0, 0.0), vec3(210.0, 135.0, 0.0), 34.0, 30.0, 0.0, 0.0),
    ("neck", vec3(205.0, 145.0, 0.0), vec3(250.0, 205.0, 0.0), 20.0, 14.0, 10.0, 0.0),
    ("hind_near", vec3(100.0, 115.0, 18.0), vec3(95.0, 20.0, 18.0), 18.0, 8.0, 22.0, 0.0),
    ("hind_far", vec3(100.0, 115.0, -18.0), vec3(95.0, 20.0, -18.0), 18.0, 8.0, 22.0, 0.5),
    ("fore_near", vec3(200.0, 115.0, 16.0), vec3(200.0, 20.0, 16.0), 16.0, 8.0, 22.0, 0.25),
    ("fore_far", vec3(200.0, 115.0, -16.0), vec3(200.0, 20.0, -16.0), 16.0, 8.0, 22.0, 0.75),
];
const BONES: usize = 5;

/// An animal in a clip of 320 x 240, of about so many triangles.
pub(crate) fn animal(triangles: usize, frames: usize) -> RiggedModel {
    // A tube of 3 n rings of n corners has 6 n * n triangles.
    let around = ((triangles as f32 / LIMBS.len() as f32 / 6.0).sqrt().round() as usize).max(3);
    let (mut bones, mut rest, mut parts) = (Vec::new(), Vec::new(), Vec::new());
    let mut animation = vec![Vec::new(); frames];
    for (l, &(name, from, to, thick, thin, swing, phase)) in LIMBS.iter().enumerate() {
        let first = bones.len();
        let along = to - from;
        let root = if l == 0 { Vec3::ZERO } else { LIMBS[0].1 };
        for k in 0..BONES {
            let parent = if k > 0 { Some(first + k - 1) } else { (l > 0).then_some(0) };
            bones.push(Bone { name: format!("{name}.{k}"), parent });
            let translation = if k > 0 { along / (BONES - 1) as f32 } else { from - root };
            rest.push(Transform { translation, rotation: Quat::IDENTITY });
            for (f, pose) in animation.iter_mut().enumerate() {
                let time = f as f32 / frames as f32 + phase;
                let turn = swing.to_radians() * (time * std::f32::consts::TAU).sin() / if k == 0 { 1.0 } else { 4.0 };
                pose.push(Transform { translation, rotation: Quat::from_rotation_z(turn) });
            }
        }
        parts.push(tube(name, first, (from, to), (thick, thin), around, l));
    }
    RiggedModel { size: (320, 240), fps: 24.0, bones, rest, animation, parts }
}

fn tube(name: &str, first: usize, (from, to): (Vec3, Vec3), radii: (f32, f32), around: usize, l: usize) -> SkinnedPart {
    let rings = 3 * around;
    let axis = (to - from).normalize();
    let side = axis.cross(Vec3::Z).normalize();
    let mut mesh = TriMesh::default();
    let (mut bones, mut weights) = (Vec::new(), Vec::new());
    for r in 0..=rings {
        let share = r as f32 / rings as f32;
        // Rounded at both ends.
        let cap = (1.0 - (2.0 * share - 1.0).powi(8)).max(0.0).sqrt();
        let radius = (radii.0 + (radii.1 - radii.0) * share) * cap;
        let at = share * (BONES - 1) as f32;
        let k = (at as usize).min(BONES - 2);
        for a in 0..=around {
            let angle = a as f32 / around as f32 * std::f32::consts::TAU;
            let out = side * angle.cos() + axis.cross(side) * angle.sin();
            mesh.positions.push(from + (to - from) * share + out * radius);
            mesh.normals.push((out * cap + axis * (2.0 * share - 1.0).powi(7)).normalize_or(axis));
            mesh.uvs.push(vec2(a as f32 / around as f32, share));
            bones.push([(first + k) as u16, (first + k + 1) as u16, 0, 0]);
            weights.push([1.0 - (at - k as f32), at - k as f32, 0.0, 0.0]);
        }
    }
    let row = around as u32 + 1;
    for r in 0..rings as u32 {
        for a in 0..around as u32 {
            let v = r * row + a;
            mesh.triangles.push([v, v + 1, v + row]);
            mesh.triangles.push([v + 1, v + row + 1, v + row]);
        }
    }
    let texture = RgbImage::from_fn(128, 128, |x, y| {
        let spot = if (x / 16 + y / 16) % 2 == 0 { 40 } else { 0 };
        Rgb([150 + spot, 100 + spot + 10 * l as u8, 60 + (y / 2) as u8])
    });
    SkinnedPart { name: name.into(), mesh, bones, weights, texture }
}

/// A flat square in the clip's plane, `side` wide around a place, of one colour.
#[allow(dead_code)]
pub(crate) fn square(center: Vec3, side: f32, color: [u8; 3]) -> RiggedModel {
    let corner = |x: f32, y: f32| center + vec3(x, y, 0.0) * side / 2.0;
    let mesh = TriMesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        normals: vec![Vec3::Z; 4],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let still = Transform { translation: Vec3::ZERO, rotation: Quat::IDENTITY };
    let part = SkinnedPart {
        name: "square".into(),
        mesh,
        bones: vec![[0; 4]; 4],
        weights: vec![[1.0, 0.0, 0.0, 0.0]; 4],
        texture: RgbImage::from_pixel(4, 4, Rgb(color)),
    };
    RiggedModel {
        size: (64, 48),
        fps: 24.0,
        bones: vec![Bone { name: "square.0".into(), parent: None }],
        rest: vec![still],
        animation: vec![vec![still]],
        parts: vec![part],
    }
}

/// So many of a model in two rows, each at its own time.
#[allow(dead_code)]
pub(crate) fn herd(model: &marey_render::Model, count: usize) -> marey_render::Scene {
    let instance = |i: usize| marey_render::Instance {
        place: Mat4::from_translation(vec3((i % 5) as f32 * 230.0, 0.0, (i / 5) as f32 * -260.0)),
        start: 3.0 * i as f64,
        ..marey_render::Instance::new(model.clone())
    };
    marey_render::Scene { instances: (0..count).map(instance).collect(), ..marey_render::Scene::of(model.clone()) }
}
