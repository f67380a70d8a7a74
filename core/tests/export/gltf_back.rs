//! Creatures read back from creature.glb: as they were, in other units, without what we say beside the format, and from
//! damaged bytes.

use marey::export::gltf::{GltfOptions, glb, parse_creature, read_creature};
use marey::job::Progress;
use marey::shape::RiggedModel;
use marey::shape::creature::{Creature, CreatureLimb, Hold, SettledPose};
use proptest::prelude::*;

use crate::model::{add_island, animal};

/// The animal with what posing needs to know of its three limbs.
fn creature(frames: usize) -> Creature {
    let limb = |label: &str, first_bone: usize, parent: Option<Hold>| CreatureLimb {
        label: label.into(),
        side: None,
        twin: None,
        parent,
        reversed: false,
        first_bone,
        bones: 6,
        length: 45.5,
        radius: 5.25,
        offset: 6.0,
        settled: vec![marey::Vec2::new(0.5, -1.25); 6],
        settled_poses: vec![SettledPose {
            stroke: (0..6).map(|k| marey::Vec2::new(9.0 * k as f32, 0.25)).collect(),
            moved: vec![marey::Vec2::new(0.75, -1.5); 6],
        }],
    };
    let body = |at_end| Some(Hold { limb: 0, at_end });
    let limbs =
        vec![limb("body", 0, None), limb("leg_near", 6, body(true)), limb("leg far / \"quoted\"", 12, body(false))];
    Creature { model: animal(frames), limbs, rest_frame: 2 }
}

fn write(creature: &Creature, scale: f32) -> Vec<u8> {
    let mut options = GltfOptions::default();
    options.scale = scale;
    glb(creature, &options, Progress::new().whole()).expect("a file")
}

fn assert_same_poses(one: &RiggedModel, other: &RiggedModel, tolerance: f32) {
    assert_eq!(one.animation.len(), other.animation.len());
    for frame in 0..one.animation.len() {
        for (a, b) in one.pose(frame).iter().zip(other.pose(frame)) {
            assert_eq!(a.triangles, b.triangles);
            for (p, q) in a.positions.iter().zip(&b.positions) {
                assert!(p.distance(*q) < tolerance, "frame {frame}: {p} and {q}");
            }
        }
    }
}

#[test]
fn a_creature_comes_back_as_it_was() {
    let written = creature(9);
    let read = parse_creature(&write(&written, 1.0)).expect("a creature");
    assert_eq!(read.limbs, written.limbs);
    assert_eq!(read.rest_frame, 2);
    let (one, other) = (&read.model, &written.model);
    assert_eq!((one.size, one.fps, &one.bones, &one.rest), (other.size, other.fps, &other.bones, &other.rest));
    for (a, b) in one.parts.iter().zip(&other.parts) {
        assert_eq!((&a.name, &a.texture, &a.mesh.uvs), (&b.name, &b.texture, &b.mesh.uvs));
    }
    assert_same_poses(one, other, 1e-3);
    // Written and read again and again, nothing creeps.
    let again = (0..20).fold(read, |c, _| parse_creature(&write(&c, 1.0)).expect("a creature"));
    assert_same_poses(&again.model, &written.model, 1e-3);
    assert_eq!(again.limbs, written.limbs);
}

#[test]
fn metres_become_pixels_again() {
    let written = creature(4);
    let read = parse_creature(&write(&written, 0.013)).expect("a creature");
    assert_same_poses(&read.model, &written.model, 2e-3);
    assert_eq!(read.limbs, written.limbs);
}

#[test]
fn a_file_and_its_folder_are_both_creatures() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("creature.glb"), write(&creature(3), 1.0)).expect("written");
    let of_folder = read_creature(folder.path()).expect("of the folder");
    assert_eq!(of_folder, read_creature(folder.path().join("creature.glb")).expect("of the file"));
    let missing = read_creature(folder.path().join("none.glb")).expect_err("no file");
    assert!(missing.to_string().contains("none.glb"), "{missing}");
}

/// The JSON of a file changed, as another program would write it anew.
fn rewritten(bytes: &[u8], change: impl Fn(&mut serde_json::Value)) -> Vec<u8> {
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four")) as usize;
    let mut value: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).expect("JSON");
    change(&mut value);
    let mut json = serde_json::to_vec(&value).expect("JSON");
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut out = bytes[..12].to_vec();
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(json);
    out.extend(&bytes[20 + length..]);
    out
}

#[test]
fn limbs_are_known_by_their_bones_where_nothing_else_says_them() {
    let mut with_tail = creature(6);
    add_island(&mut with_tail.model);
    let bare = rewritten(&write(&with_tail, 1.0), |v| {
        v["scenes"][0].as_object_mut().expect("a scene").remove("extras");
        // And the joints in another order, so that each stands for another of the matrices: only names count here.
        v["skins"][0]["joints"].as_array_mut().expect("joints").reverse();
        for mesh in v["meshes"].as_array_mut().expect("meshes") {
            mesh["primitives"][0]["attributes"].as_object_mut().expect("lists").remove("NORMAL");
        }
    });
    let read = parse_creature(&bare).expect("a creature");
    let mut labels: Vec<&str> = read.limbs.iter().map(|l| l.label.as_str()).collect();
    labels.sort_unstable();
    assert_eq!(labels, ["body", "leg far / \"quoted\"", "leg_near", "tail"]);
    let limb = |label: &str| read.limbs.iter().find(|l| l.label == label).expect("the limb");
    assert_eq!(read.limbs[limb("leg_near").parent.expect("hangs").limb].label, "body");
    assert!(limb("leg_near").parent.expect("hangs").at_end);
    assert!(!limb("leg far / \"quoted\"").parent.expect("hangs").at_end);
    for limb in &read.limbs {
        let names: Vec<&str> = limb.bone_range().map(|b| read.model.bones[b].name.as_str()).collect();
        assert_eq!(names[0], format!("{}.0", limb.label));
        assert_eq!(names.len(), 6);
    }
    assert_eq!((read.model.animation.len(), read.model.fps.round()), (6, 12.0));
}

#[test]
fn what_cannot_be_a_creature_is_refused_by_name() {
    let good = write(&creature(3), 1.0);
    let refused = |bytes: &[u8], word: &str| {
        let error = parse_creature(bytes).expect_err(word).to_string();
        assert!(error.contains(word), "{error}");
    };
    refused(b"", "no binary glTF");
    refused(b"{\"asset\":{}}", "no binary glTF");
    refused(&good[..good.len() / 2], "cut off");
    refused(&rewritten(&good, |v| v["nodes"][1]["scale"] = serde_json::json!([2, 2, 2])), "scale");
    refused(&rewritten(&good, |v| v["nodes"][2]["children"] = serde_json::json!([1])), "parents");
    refused(&rewritten(&good, |v| v["buffers"][0]["uri"] = "creature.bin".into()), "other files");
    refused(&rewritten(&good, |v| v["accessors"][1]["count"] = 4_000_000_000u64.into()), "elements");
    refused(
        &rewritten(&good, |v| {
            for node in v["nodes"].as_array_mut().expect("nodes") {
                node.as_object_mut().expect("a node").remove("mesh");
            }
        }),
        "no mesh",
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn damage_is_an_error_or_a_valid_creature(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        in_json in any::<bool>(),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = write(&creature(2), 1.0);
        let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four")) as usize;
        for (at, value) in changes {
            let range = if in_json { 20 + length } else { bytes.len() };
            let at = at.index(range);
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok(creature) = parse_creature(&bytes) {
            prop_assert!(creature.validate().is_ok());
        }
    }
}
