//! What is done with a creature, as a user of the command line meets it: poses, textures, edits, crowds, prints.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::path::Path;

use common::{bar, fails_in, report_in};
use serde_json::{Value, json};

/// The mean colour of a creature from a side, and how many pixels it covers.
fn look(folder: &Path, creature: &str, view: &str, frame: &str) -> ([f64; 3], usize) {
    report_in(folder, &["render", creature, "-o", "look.png", "--frame", frame, "--view", view, "--adapter", "cpu"]);
    let picture = image::open(folder.join("look.png")).unwrap().to_rgba8();
    let seen: Vec<[u8; 4]> = picture.pixels().map(|p| p.0).filter(|p| p[3] == 255).collect();
    let mean = |c: usize| seen.iter().map(|p| f64::from(p[c])).sum::<f64>() / seen.len().max(1) as f64;
    ([mean(0), mean(1), mean(2)], seen.len())
}

#[test]
fn a_creature_takes_poses_and_motions() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    // It lies; in the last pose it stands on its end.
    let poses = json!({ "format": "marey-strokes", "version": 1, "size": [96, 64], "limbs": [{ "label": "body" }], "keyframes": [
        { "frame": 0, "strokes": [{ "limb": "body", "points": [[33, 32], [57, 32]] }] },
        { "frame": 4, "easing": "inout", "strokes": [{ "limb": "body", "points": [[45, 56], [45, 32]] }] }] });
    std::fs::write(folder.join("poses.json"), poses.to_string()).unwrap();
    let said = report_in(folder, &["pose", "bar", "--poses", "poses.json", "--fps", "12", "-o", "up.glb"]);
    assert_eq!((said["frames"].as_u64(), said["strain"][0]["limb"].as_str()), (Some(5), Some("body")), "{said}");
    let tall = |frame: &str| {
        look(folder, "up.glb", "clip", frame);
        let picture = image::open(folder.join("look.png")).unwrap().to_rgba8();
        let rows = |x: u32| (0..64).filter(|y| picture.get_pixel(x, *y).0[3] == 255).count();
        (0..96).map(rows).max().unwrap()
    };
    let (lying, standing) = (tall("0"), tall("4"));
    assert!(lying < 20 && standing > 22, "{lying} and {standing} pixels tall");

    let driven = ["pose", "bar", "--motion", "bar/motion.json", "--keep-map", "map.json", "-o", "as-it-was.glb"];
    let said = report_in(folder, &driven);
    assert_eq!(said["frames"].as_u64(), Some(6));
    let map: Value = serde_json::from_slice(&std::fs::read(folder.join("map.json")).unwrap()).unwrap();
    assert_eq!(map["limbs"]["body"]["tracks"][0], "body", "{map}");
    report_in(folder, &["pose", "bar", "--motion", "bar/motion.json", "--map", "map.json", "-o", "mapped.glb"]);

    assert!(fails_in(folder, &["pose", "bar", "-o", "a.glb"], 2).contains("--poses"));
    assert!(fails_in(folder, &["pose", "bar", "--poses", "none.json", "-o", "a.glb"], 3).contains("none.json"));
    std::fs::write(folder.join("wrong.json"), poses.to_string().replace("body", "wing")).unwrap();
    assert!(fails_in(folder, &["pose", "bar", "--poses", "wrong.json", "-o", "a.glb"], 3).contains("wing"));
    assert!(fails_in(folder, &["pose", "bar", "--motion", "poses.json", "-o", "a.glb"], 3).contains("poses.json"));
    assert!(!folder.join("a.glb").exists());
}

#[test]
fn textures_go_out_and_come_back_and_are_taken_from_anything() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    let said = report_in(folder, &["texture", "bar", "--pictures", "skin"]);
    let pictures: Vec<_> = std::fs::read_dir(folder.join("skin")).unwrap().map(|e| e.unwrap().path()).collect();
    assert_eq!(said["parts"].as_u64(), Some(pictures.len() as u64), "{said}");
    for path in &pictures {
        let size = image::image_dimensions(path).unwrap();
        image::RgbImage::from_pixel(size.0 * 2, size.1 * 2, image::Rgb([10, 200, 30])).save(path).unwrap();
    }
    report_in(folder, &["texture", "bar", "--painted", "skin", "-o", "green.glb"]);
    let (green, before) = (look(folder, "green.glb", "40,20", "2"), look(folder, "bar", "40,20", "2"));
    assert!(green.0[1] > 190.0 && green.0[0] < 20.0 && before.0[1] < 120.0, "{green:?} of {before:?}");
    assert_eq!(green.1, before.1, "only the colours changed");

    report_in(folder, &["texture", "bar", "--like", "green.glb", "-o", "like.glb"]);
    assert!(look(folder, "like.glb", "clip", "0").0[1] > 180.0);
    image::RgbImage::from_pixel(96, 64, image::Rgb([250, 0, 250])).save(folder.join("pink.png")).unwrap();
    report_in(folder, &["texture", "bar", "--material", "pink.png", "--width", "20", "--limbs", "body", "-o", "m.glb"]);
    assert!(look(folder, "m.glb", "180,0", "0").0[0] > 230.0);
    report_in(folder, &["texture", "bar", "--side", "pink.png", "-o", "s.glb"]);
    assert!(look(folder, "s.glb", "clip", "0").0[2] > 230.0);
    // From the clip's own frames a green one is as dark again as it was filmed.
    report_in(
        folder,
        &["texture", "green.glb", "--clip", "clip", "--masks", "bar/masks", "--frames", "0,4", "-o", "c.glb"],
    );
    let filmed = look(folder, "c.glb", "clip", "0").0;
    assert!((filmed[1] - look(folder, "bar", "clip", "0").0[1]).abs() < 15.0, "{filmed:?}");

    let texture =
        |args: &[&str], code: i32| fails_in(folder, &[&["texture", "bar", "-o", "a.glb"], args].concat(), code);
    assert!(texture(&[], 2).contains("--like"));
    assert!(texture(&["--painted", "clip"], 3).contains("skin.png"));
    assert!(texture(&["--painted", "nowhere"], 3).contains("nowhere"));
    assert!(texture(&["--material", "pink.png", "--limbs", "wing"], 3).contains("wing"));
    assert!(texture(&["--material", "strokes.json"], 3).contains("strokes.json"));
    assert!(texture(&["--material", "pink.png", "--width", "nan"], 2).contains("width"));
    assert!(texture(&["--side", "pink.png", "--region", "skin/../strokes.json"], 3).contains("strokes.json"));
    assert!(texture(&["--clip", "clip", "--frames", "4,4"], 2).contains("--frames"));
    assert!(fails_in(folder, &["texture", "green.glb", "--clip", "clip", "-o", "a.glb"], 3).contains("--masks"));
    assert!(!folder.join("a.glb").exists());
}

#[test]
fn a_mesh_that_was_changed_elsewhere_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    report_in(folder, &["creature", "clip", "--strokes", "strokes.json", "-o", "bar2", "--obj"]);
    let mesh = std::fs::read_to_string(folder.join("bar2/meshes/00003.obj")).unwrap();
    // Twice as thick, as an artist would scale it about its middle.
    let numbers = |line: &str| line.split_whitespace().skip(1).map(|w| w.parse().unwrap()).collect::<Vec<f64>>();
    let all: Vec<Vec<f64>> = mesh.lines().filter(|l| l.starts_with("v ")).map(numbers).collect();
    let middle = all.iter().map(|v| v[1]).sum::<f64>() / all.len() as f64;
    let thick: String = mesh
        .lines()
        .map(|line| match line.strip_prefix("v ") {
            Some(_) => {
                let v = numbers(line);
                format!("v {} {} {}\n", v[0], middle + 2.0 * (v[1] - middle), v[2])
            }
            None => format!("{line}\n"),
        })
        .collect();
    std::fs::write(folder.join("thick.obj"), thick).unwrap();
    let said = report_in(folder, &["edit", "bar2", "--mesh", "thick.obj", "--frame", "3", "-o", "thick.glb"]);
    assert_eq!(said["kind"], "displaced", "{said}");
    for frame in ["0", "5"] {
        let (before, after) =
            (look(folder, "bar2", "clip", frame).1 as f64, look(folder, "thick.glb", "clip", frame).1);
        assert!((1.7..2.3).contains(&(after as f64 / before)), "frame {frame}: {before} and {after} pixels");
    }
    // Half of its triangles: another mesh.
    let mut number = 0;
    let half: String = mesh
        .lines()
        .filter(|l| {
            !l.starts_with("f ") || {
                number += 1;
                number % 2 == 0
            }
        })
        .chain(["v 40 30 0"])
        .map(|l| format!("{l}\n"))
        .collect();
    std::fs::write(folder.join("half.obj"), half).unwrap();
    let said = report_in(folder, &["edit", "bar2", "--mesh", "half.obj", "--frame", "3", "-o", "half.glb"]);
    assert_eq!(said["kind"], "bound_anew", "{said}");

    let edit = |mesh: &str, frame: &str, code: i32| {
        fails_in(folder, &["edit", "bar2", "--mesh", mesh, "--frame", frame, "-o", "a.glb"], code)
    };
    assert!(edit("none.obj", "3", 3).contains("none.obj"));
    assert!(edit("strokes.json", "3", 3).contains("is empty"));
    assert!(edit("thick.obj", "6", 2).contains('6'));
    let metres: String =
        all.iter().map(|v| format!("v {} {} {}\n", v[0] / 100.0, v[1] / 100.0, v[2] / 100.0)).collect();
    std::fs::write(folder.join("metres.obj"), metres + "f 1 2 3\n").unwrap();
    assert!(edit("metres.obj", "3", 3).contains("scale"));
    assert!(!folder.join("a.glb").exists());
}

#[test]
fn a_creature_becomes_many_and_is_put_back_into_its_clip() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    let crowd = json!({ "format": "marey-crowd", "version": 1, "creatures": ["bar"], "frames": 6, "instances": [
        { "creature": 0, "at": [0, 0, 0] }, { "creature": 0, "at": [0, 22, -10], "start": 2, "loop": true }] });
    std::fs::write(folder.join("two.json"), crowd.to_string()).unwrap();
    let said = report_in(folder, &["crowd", "two.json", "-o", "two.glb"]);
    assert_eq!((said["instances"].as_u64(), said["frames"].as_u64()), (Some(2), Some(6)), "{said}");
    let json_of = |path: &str| gltf_json(&std::fs::read(folder.join(path)).unwrap());
    let count = |glb: &Value, of: &str| glb[of].as_array().map_or(0, Vec::len);
    assert_eq!(count(&json_of("two.glb"), "skins"), 2 * count(&json_of("bar/creature.glb"), "skins"));
    assert_eq!(count(&json_of("two.glb"), "images"), count(&json_of("bar/creature.glb"), "images"), "looks are shared");

    report_in(
        folder,
        &["crowd", "two.json", "--into", "clip", "--masks", "bar/masks", "-o", "both", "--adapter", "cpu"],
    );
    let dark = |path: &str| {
        let picture = image::open(folder.join(path)).unwrap().to_rgb8();
        picture.pixels().filter(|p| p.0[0] < 120).count()
    };
    let (one, both) = (dark("clip/00003.png"), dark("both/00003.png"));
    assert!(both > one * 3 / 2, "{one} dark pixels before and {both} with another one");
    let herd = ["crowd", "bar", "--count", "4", "-o", "herd.gif", "--view", "0,20", "--adapter", "cpu"];
    assert_eq!(report_in(folder, &herd)["frames"].as_u64(), Some(6));

    assert!(fails_in(folder, &["crowd", "two.json", "--count", "3", "-o", "a.glb"], 2).contains("--count"));
    assert!(fails_in(folder, &["crowd", "two.json", "--into", "clip", "-o", "a.glb"], 2).contains("--into"));
    std::fs::write(folder.join("bad.json"), crowd.to_string().replace(r#""creature":0"#, r#""creature":5"#)).unwrap();
    assert!(fails_in(folder, &["crowd", "bad.json", "-o", "a.glb"], 3).contains("bad.json"));
    assert!(!folder.join("a.glb").exists());
}

/// The JSON of a glTF binary: a header of 12 bytes, the chunk's length and kind, and the chunk.
fn gltf_json(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

#[test]
fn a_frame_is_printed_in_millimetres() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    let said = report_in(folder, &["print", "bar", "--frame", "2", "--size", "30", "--detail", "0.8", "-o", "bar.stl"]);
    let triangles = said["triangles"].as_u64().unwrap();
    let stl = std::fs::read(folder.join("bar.stl")).unwrap();
    assert_eq!(stl.len() as u64, 84 + 50 * triangles, "an STL is a header and 50 bytes a triangle");
    let coordinate = |triangle: usize, i: usize| {
        let at = 84 + 50 * triangle + 12 + 4 * i;
        f32::from_le_bytes(stl[at..at + 4].try_into().unwrap())
    };
    let xs = (0..triangles as usize).flat_map(|t| (0..3).map(move |k| (t, 3 * k)));
    let (low, high) =
        xs.fold((f32::MAX, f32::MIN), |(l, h), (t, i)| (l.min(coordinate(t, i)), h.max(coordinate(t, i))));
    assert!((high - low - 30.0).abs() < 1.0, "{} mm long", high - low);
    report_in(folder, &["print", "bar", "--height", "12", "--detail", "1", "--base", "-o", "bar.3mf"]);
    assert_eq!(&std::fs::read(folder.join("bar.3mf")).unwrap()[..2], b"PK", "a 3MF is a zip");

    let print = |args: &[&str], code: i32| fails_in(folder, &[&["print", "bar"], args].concat(), code);
    assert!(print(&["-o", "a.obj"], 3).contains(".stl"));
    assert!(print(&["-o", "a.stl", "--frame", "6"], 2).contains('6'));
    assert!(print(&["-o", "a.stl", "--size", "2", "--min-thickness", "1"], 3).contains("mm"));
    assert!(print(&["-o", "a.stl", "--size", "10", "--height", "3"], 2).contains("--height"));
    assert!(!folder.join("a.stl").exists());
}
