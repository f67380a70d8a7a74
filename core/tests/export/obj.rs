//! OBJ frames, read by a few lines of our own as other programs read them.

use glam::Vec3;
use marey::export::write_obj;
use marey::job::Progress;

use crate::model::animal;
use crate::scene::listing;

#[test]
fn every_frame_holds_the_posed_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = animal(4);
    write_obj(folder.path(), &model, Progress::new().whole()).expect("written");
    let names = listing(folder.path());
    assert_eq!(names.iter().filter(|n| n.ends_with(".obj")).count(), 4);
    let materials = std::fs::read_to_string(folder.path().join("creature.mtl")).expect("materials");
    for frame in 0..4 {
        let text = std::fs::read_to_string(folder.path().join(format!("{frame:05}.obj"))).expect("a frame");
        let rows = |key: &str| -> Vec<Vec<f32>> {
            let lines = text.lines().filter_map(|l| l.strip_prefix(key)?.strip_prefix(' '));
            lines.map(|l| l.split(' ').map(|n| n.parse().expect("a number")).collect()).collect()
        };
        let meshes = model.pose(frame);
        let vertices = rows("v");
        let expected: Vec<Vec3> = meshes.iter().flat_map(|m| m.positions.clone()).collect();
        assert_eq!(vertices.len(), expected.len());
        for (got, expected) in vertices.iter().zip(&expected) {
            assert!((Vec3::from_slice(got) - *expected).length() < 1e-3);
        }
        assert_eq!(rows("vn").len(), expected.len());
        for (got, expected) in rows("vt").iter().zip(meshes.iter().flat_map(|m| &m.uvs)) {
            assert!((got[0] - expected.x).abs() < 1e-5 && (1.0 - got[1] - expected.y).abs() < 1e-5);
        }
        let mut first = 1;
        let mut faces = text.lines().filter_map(|l| l.strip_prefix("f "));
        for mesh in &meshes {
            for triangle in &mesh.triangles {
                let corners: Vec<String> = triangle.iter().map(|i| i + first).map(|i| format!("{i}/{i}/{i}")).collect();
                assert_eq!(faces.next(), Some(corners.join(" ").as_str()));
            }
            first += mesh.positions.len() as u32;
        }
        for used in text.lines().filter_map(|l| l.strip_prefix("usemtl ")) {
            assert!(materials.contains(&format!("newmtl {used}\n")));
            let texture = image::open(folder.path().join(format!("{used}.png"))).expect("a texture").to_rgb8();
            assert_eq!(texture, model.parts[0].texture);
        }
    }
}
