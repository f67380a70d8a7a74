//! A small animal made by hand: a body and two legs of tubes on bent, stretched and turned bones.

use glam::{Mat4, Quat, Vec2, Vec3};
use image::{Rgb, RgbImage};
use marey::geometry::TriMesh;
use marey::shape::{Bone, RiggedModel, SkinnedPart, Transform};

const AROUND: usize = 12;
const BONES: usize = 6;
pub(crate) const SIZE: (u32, u32) = (160, 120);

/// Tubes along `BONES` bones each: the body to the right, the legs down from it. `frames` frames at 12 a second.
pub(crate) fn animal(frames: usize) -> RiggedModel {
    let mut model = RiggedModel {
        size: SIZE,
        fps: 12.0,
        bones: Vec::new(),
        rest: Vec::new(),
        animation: vec![Vec::new(); frames],
        parts: Vec::new(),
    };
    let body = add_limb(&mut model, "body", None, Vec3::new(40.0, 70.0, 0.0), 0.0, 14.0, 12.0);
    add_limb(&mut model, "leg_near", Some(body + BONES - 1), Vec3::new(0.0, -4.0, 6.0), -1.5, 9.0, 5.0);
    add_limb(&mut model, "leg far / \"quoted\"", Some(body), Vec3::new(0.0, -4.0, -6.0), -1.4, 9.0, 5.0);
    model
}

/// A limb of its own tree, far from the rest.
pub(crate) fn add_island(model: &mut RiggedModel) {
    add_limb(model, "tail", None, Vec3::new(20.0, 100.0, 3.0), 0.7, 5.0, 3.0);
}

fn add_limb(
    model: &mut RiggedModel,
    name: &str,
    parent: Option<usize>,
    at: Vec3,
    heading: f32,
    step: f32,
    radius: f32,
) -> usize {
    let first = model.bones.len();
    for i in 0..BONES {
        let above = if i == 0 { parent } else { Some(first + i - 1) };
        model.bones.push(Bone { name: format!("{name}.{i}"), parent: above });
        let rotation = if i == 0 { Quat::from_rotation_z(heading) } else { Quat::IDENTITY };
        let translation = if i == 0 { at } else { Vec3::X * step };
        model.rest.push(Transform { translation, rotation });
        for (frame, pose) in model.animation.iter_mut().enumerate() {
            let phase = frame as f32 * 0.55 + first as f32;
            let bend = Quat::from_rotation_z(0.25 * phase.sin()) * Quat::from_rotation_y(0.15 * (phase * 1.3).cos());
            // Every other frame on the other side of the sphere: the same turn, the other sign.
            let sign = if (frame + i) % 2 == 0 { 1.0 } else { -1.0 };
            let stretch = 1.0 + 0.1 * (phase * 0.7).sin();
            // One bone never moves, and one is turned once and for all.
            let moved = match i {
                2 => Transform { translation, rotation },
                3 => Transform { translation, rotation: Quat::from_rotation_x(0.4) },
                _ => Transform { translation: translation * stretch, rotation: rotation * bend * sign },
            };
            pose.push(moved);
        }
    }
    let world: Vec<Mat4> = model.world(&model.rest);
    model.parts.push(tube(name, first, &world[first..], step, radius));
    first
}

fn tube(name: &str, first: usize, world: &[Mat4], step: f32, radius: f32) -> SkinnedPart {
    let rings = 2 * BONES + 1;
    let mut part = SkinnedPart {
        name: name.into(),
        mesh: TriMesh::default(),
        bones: Vec::new(),
        weights: Vec::new(),
        texture: RgbImage::from_fn(32, 16, |x, y| {
            let check = (x / 4 + y / 4) % 2 == 0;
            if check { Rgb([200, 150, 90]) } else { Rgb([(8 * x) as u8, 60, (16 * y) as u8]) }
        }),
    };
    for ring in 0..rings {
        let along = ring as f32 / 2.0;
        let bone = (along as usize).min(BONES - 1);
        let share = along - bone as f32;
        let next = (bone + 1).min(BONES - 1);
        for side in 0..=AROUND {
            let angle = std::f32::consts::TAU * side as f32 / AROUND as f32;
            let out = Vec3::new(0.0, angle.cos(), angle.sin());
            let grow = 1.0 - 0.7 * (ring as f32 / (rings - 1) as f32 - 0.4).abs();
            let local = Vec3::X * step * share + out * radius * grow;
            part.mesh.positions.push(world[bone].transform_point3(local));
            part.mesh.normals.push(world[bone].transform_vector3(out));
            part.mesh.uvs.push(Vec2::new(side as f32 / AROUND as f32, ring as f32 / (rings - 1) as f32));
            let (near, far) = ((first + bone) as u16, (first + next) as u16);
            // The same bone twice and a bone without weight: both are allowed in a model.
            part.bones.push([near, far, 0, near]);
            part.weights.push([0.5 * (1.0 - share), share, 0.0, 0.5 * (1.0 - share)]);
        }
    }
    let row = (AROUND + 1) as u32;
    for ring in 0..rings as u32 - 1 {
        for side in 0..AROUND as u32 {
            let a = ring * row + side;
            part.mesh.triangles.push([a, a + 1, a + row]);
            part.mesh.triangles.push([a + 1, a + row + 1, a + row]);
        }
    }
    part
}
