//! creature.glb, read back by an independent reader and posed by the format's own rules.

use marey::export::gltf::{GltfOptions, glb};
use marey::job::Progress;
use marey::shape::RiggedModel;

use crate::gltf_reader::Reader;
use crate::model::{add_island, animal};

fn write(model: &RiggedModel, options: &GltfOptions) -> Vec<u8> {
    glb(&model.clone().into(), options, Progress::new().whole()).expect("a file")
}

fn scaled(scale: f32) -> GltfOptions {
    let mut options = GltfOptions::default();
    options.scale = scale;
    options
}

#[test]
fn plays_the_model_frame_by_frame() {
    for scale in [1.0, 0.01] {
        let mut model = animal(20);
        add_island(&mut model);
        let reader = Reader::open(&write(&model, &scaled(scale)));
        for frame in [0, 1, 7, 19] {
            let posed = reader.pose((frame as f64 / model.fps) as f32);
            assert_eq!(posed.len(), model.parts.len());
            for (part, mesh) in model.parts.iter().zip(model.pose(frame)) {
                for (got, expected) in posed[&part.name].iter().zip(&mesh.positions) {
                    let error = (*got / scale - *expected).length();
                    assert!(error < 1e-3, "{}, frame {frame}: off by {error} px", part.name);
                }
            }
        }
    }
}

#[test]
fn has_the_hierarchy_names_and_textures_of_the_model() {
    let mut model = animal(5);
    add_island(&mut model);
    let reader = Reader::open(&write(&model, &GltfOptions::default()));
    let document = &reader.document;
    let skin = document.skins().next().expect("a skin");
    assert_eq!(document.skins().count(), 1);
    let joints: Vec<gltf::Node<'_>> = skin.joints().collect();
    assert_eq!(joints.len(), model.bones.len());
    for (bone, joint) in model.bones.iter().zip(&joints) {
        assert_eq!(joint.name(), Some(bone.name.as_str()));
        let parent = bone.parent.map_or_else(|| skin.skeleton().expect("an armature"), |p| joints[p].clone());
        assert!(parent.children().any(|c| c.index() == joint.index()), "{} hangs where it should", bone.name);
    }
    for (part, image) in model.parts.iter().zip(document.images()) {
        let gltf::image::Source::View { view, mime_type } = image.source() else { panic!("embedded") };
        assert_eq!(mime_type, "image/png");
        let png = &reader.blob[view.offset()..view.offset() + view.length()];
        assert_eq!(image::load_from_memory(png).expect("a picture").to_rgb8(), part.texture);
    }
    for material in document.materials() {
        let look = material.pbr_metallic_roughness();
        assert_eq!((look.metallic_factor(), look.roughness_factor()), (0.0, 1.0));
        assert!(look.base_color_texture().is_some());
    }
}

#[test]
fn keeps_no_key_that_says_nothing() {
    let reader = Reader::open(&write(&animal(20), &GltfOptions::default()));
    let bone = |name: &str| reader.document.nodes().find(|n| n.name() == Some(name)).expect("a bone").index();
    assert_eq!(reader.rotations[&bone("body.1")].0.len(), 20);
    assert!(!reader.rotations.contains_key(&bone("body.2")), "never leaves its rest");
    assert!(!reader.translations.contains_key(&bone("body.2")));
    assert_eq!(reader.rotations[&bone("body.3")].0.len(), 1, "turned once and for all");
}

#[test]
fn one_frame_and_many_bones_are_written_too() {
    let still = animal(1);
    let posed = Reader::open(&write(&still, &GltfOptions::default())).pose(0.0);
    let expected = still.pose(0);
    assert!((posed["body"][5] - expected[0].positions[5]).length() < 1e-3);

    let mut many = animal(2);
    for _ in 0..60 {
        add_island(&mut many);
    }
    assert!(many.bones.len() > 256);
    let posed = Reader::open(&write(&many, &GltfOptions::default())).pose(0.0);
    let expected = many.pose(0).pop().expect("the last part");
    assert!((posed["tail"][9] - expected.positions[9]).length() < 1e-3);
}

#[test]
fn the_same_model_gives_the_same_bytes() {
    let model = animal(6);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let alone = one.install(|| write(&model, &GltfOptions::default()));
    assert_eq!(alone, write(&model, &GltfOptions::default()));
}

#[test]
fn refuses_what_no_reader_could_show() {
    let refused = |change: fn(&mut RiggedModel), word: &str| {
        let mut model = animal(3);
        change(&mut model);
        let error = glb(&model.into(), &GltfOptions::default(), Progress::new().whole()).expect_err(word);
        assert!(error.to_string().contains(word), "{error}");
    };
    refused(|m| m.parts[1].mesh.positions[3].x = f32::NAN, "leg_near");
    refused(|m| m.parts[0].mesh.triangles[0] = [0, 1, 99_999], "body");
    refused(|m| m.parts[0].bones[0] = [999, 0, 0, 0], "body");
    refused(|m| m.parts[0].weights[0] = [0.0; 4], "weights");
    refused(|m| m.animation[2][4].translation.y = f32::INFINITY, "frame 2");
    refused(|m| m.bones[1].parent = Some(1), "parent");
    refused(|m| m.parts.clear(), "surface");
    for scale in [0.0, -1.0, f32::NAN] {
        assert!(glb(&animal(1).into(), &scaled(scale), Progress::new().whole()).is_err());
    }
    let progress = Progress::new();
    progress.cancel();
    assert!(matches!(glb(&animal(1).into(), &GltfOptions::default(), progress.whole()), Err(marey::Error::Cancelled)));
}
