//! A crowd in one glTF file, read back by an independent reader, and crowds that cannot be.

use std::sync::Arc;

use glam::Vec3;
use marey::export::gltf::{GltfOptions, crowd_glb};
use marey::job::Progress;
use marey::shape::creature::Creature;
use marey::shape::crowd::{Crowd, CrowdFile, Instance};

use crate::gltf_reader::Reader;
use crate::model::animal;

fn crowd(instances: Vec<Instance>) -> Crowd {
    let creature = Arc::new(Creature::from(animal(8)));
    Crowd { size: (160, 120), fps: 12.0, frames: 10, creatures: vec![creature], instances }
}

fn write(crowd: &Crowd, scale: f32) -> Vec<u8> {
    let mut options = GltfOptions::default();
    options.scale = scale;
    crowd_glb(crowd, &options, Progress::new().whole()).expect("a file")
}

#[test]
fn every_instance_stands_and_moves_as_asked_and_looks_are_shared() {
    let crowd = crowd(vec![
        Instance::default(),
        Instance { at: [50.0, 5.0, -30.0], yaw: 180.0, scale: 0.5, start: 3.0, ..Instance::default() },
        Instance { start: 6.0, looped: false, speed: 0.5, ..Instance::default() },
    ]);
    let reader = Reader::open(&write(&crowd, 0.01));
    assert_eq!(reader.document.images().count(), crowd.creatures[0].model.parts.len(), "textures once");
    assert_eq!(reader.document.meshes().count(), crowd.creatures[0].model.parts.len(), "meshes once");
    assert_eq!(reader.document.skins().count(), 3);
    let model = &crowd.creatures[0].model;
    for frame in [0usize, 4, 9] {
        let posed = reader.pose((frame as f64 / crowd.fps) as f32);
        for i in 0..3 {
            let own = model.pose_at(&crowd.pose(i, frame));
            let placement = crowd.placement(i);
            for (part, mesh) in model.parts.iter().zip(own) {
                for (got, expected) in posed[&format!("{} {i}", part.name)].iter().zip(&mesh.positions) {
                    let error = (*got / 0.01 - placement.transform_point3(*expected)).length();
                    assert!(error < 2e-3, "instance {i}, frame {frame}, {}: off by {error} px", part.name);
                }
            }
        }
    }
    // The first shows the clip, the second is three frames ahead of it, and the third holds the last frame.
    assert_eq!(crowd.pose(0, 9), model.animation[1]);
    assert_eq!(crowd.pose(1, 2), model.animation[5]);
    assert_eq!(crowd.pose(2, 9), model.animation[7]);
}

#[test]
fn an_instance_turns_on_the_ground_where_it_stands() {
    let crowd = crowd(vec![Instance { yaw: 90.0, scale: 2.0, ..Instance::default() }]);
    let model = &crowd.creatures[0].model;
    let places = || model.parts.iter().flat_map(|p| &p.mesh.positions);
    let low = places().fold(f32::INFINITY, |m, p| m.min(p.y));
    let moved: Vec<Vec3> = places().map(|p| crowd.placement(0).transform_point3(*p)).collect();
    assert!((moved.iter().fold(f32::INFINITY, |m, p| m.min(p.y)) - low).abs() < 1e-2, "its feet stay on the ground");
    // What was to the right is now away from the viewer, twice as far.
    let right = places().enumerate().max_by(|a, b| a.1.x.total_cmp(&b.1.x)).expect("a vertex").0;
    assert!(moved[right].z < -50.0, "{}", moved[right]);
}

#[test]
fn a_herd_stands_apart_and_out_of_step() {
    let herd = Crowd::herd(Arc::new(Creature::from(animal(8))), 7, 24);
    herd.validate().expect("valid");
    for (i, a) in herd.instances.iter().enumerate() {
        for b in &herd.instances[..i] {
            assert!(Vec3::from(a.at).distance(Vec3::from(b.at)) > 30.0);
        }
    }
    assert!(herd.instances.windows(2).all(|w| w[0].start != w[1].start));
}

#[test]
fn crowds_that_cannot_be_are_refused_by_name() {
    let refused = |crowd: &Crowd, word: &str| {
        let error = crowd_glb(crowd, &GltfOptions::default(), Progress::new().whole()).expect_err(word).to_string();
        assert!(error.contains(word), "{error}");
    };
    let one = |instance: Instance| crowd(vec![Instance::default(), instance]);
    refused(&crowd(vec![]), "no instance");
    refused(&one(Instance { creature: 1, ..Instance::default() }), "instance 1");
    refused(&one(Instance { at: [f32::NAN, 0.0, 0.0], ..Instance::default() }), "stands at");
    refused(&one(Instance { scale: 0.0, ..Instance::default() }), "times as large");
    refused(&one(Instance { speed: f64::INFINITY, ..Instance::default() }), "plays at");
    refused(&Crowd { frames: 0, ..one(Instance::default()) }, "0 frames");
    refused(&Crowd { fps: f64::NAN, ..one(Instance::default()) }, "a second");
    refused(&Crowd { frames: 90_000, ..crowd(vec![Instance::default(); 9000]) }, "bones");
    refused(&Crowd { creatures: vec![Arc::new(animal(0).into())], ..one(Instance::default()) }, "no frame");
}

#[test]
fn files_say_what_is_wrong_with_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("crowd.json");
    let read = |text: &str| {
        std::fs::write(&path, text).expect("written");
        CrowdFile::read(&path)
    };
    let good =
        r#"{"format": "marey-crowd", "version": 1, "creatures": ["a.glb"], "instances": [{"at": [1, 2, 3]}, {}]}"#;
    let file = read(good).expect("a crowd");
    assert_eq!(file.creatures, [folder.path().join("a.glb")]);
    assert_eq!(file.instances[1], Instance::default());
    let made = file.crowd(vec![Arc::new(animal(5).into())]).expect("a crowd");
    assert_eq!((made.frames, made.size), (5, (160, 120)));
    for (text, word) in [
        ("", "crowd.json"),
        (r#"{"format": "marey-motion", "version": 1, "creatures": [], "instances": []}"#, "format"),
        (&good.replace("\"version\": 1", "\"version\": 2"), "version 2"),
        (&good.replace("[1, 2, 3]", "[1, 2]"), "line 1"),
    ] {
        let error = read(text).expect_err(word).to_string();
        assert!(error.contains(word), "{error}");
    }
    assert!(file.crowd(Vec::new()).is_err());
}
