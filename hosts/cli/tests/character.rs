//! Drawings that move, as a user of the command line meets them: rigs of all kinds of drawings, poses and motions on them,
//! and what is said where something is wrong.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{Desk, fails, report, sample};
use image::{Rgba, RgbaImage};
use serde_json::{Value, json};

impl Desk {
    /// A picture of what is nearer to one of the lines than its half width.
    fn drawing(&self, name: &str, size: (u32, u32), lines: &[([f32; 4], f32)]) -> String {
        let inside = |x: f32, y: f32| {
            lines.iter().any(|&([ax, ay, bx, by], width)| {
                let (dx, dy) = (bx - ax, by - ay);
                let t = (((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy).max(1e-9)).clamp(0.0, 1.0);
                (x - ax - t * dx).hypot(y - ay - t * dy) < width
            })
        };
        let picture = RgbaImage::from_fn(size.0, size.1, |x, y| {
            if inside(x as f32 + 0.5, y as f32 + 0.5) {
                Rgba([180, (x % 256) as u8, (y % 256) as u8, 255])
            } else {
                Rgba([0; 4])
            }
        });
        picture.save(self.path(name)).unwrap();
        self.path(name)
    }

    /// A figure with a body, four legs, a neck and a tail.
    fn animal(&self) -> String {
        let lines = [
            ([60.0, 80.0, 180.0, 80.0], 22.0),
            ([60.0, 90.0, 50.0, 180.0], 8.0),
            ([90.0, 90.0, 95.0, 180.0], 8.0),
            ([150.0, 90.0, 145.0, 180.0], 8.0),
            ([180.0, 90.0, 190.0, 180.0], 8.0),
            ([180.0, 80.0, 220.0, 25.0], 10.0),
            ([60.0, 75.0, 20.0, 40.0], 5.0),
        ];
        self.drawing("animal.png", (256, 200), &lines)
    }

    fn rigged(&self, picture: &str) -> String {
        let rig = self.path("rig.json");
        report(&["rig", picture, "-o", &rig]);
        rig
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> =
            std::fs::read_dir(self.0.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

fn joints(rig: &str) -> Vec<(String, [f64; 2])> {
    let rig: Value = serde_json::from_str(&std::fs::read_to_string(rig).unwrap()).unwrap();
    let at = |j: &Value, i: usize| j["at"][i].as_f64().unwrap();
    let one = |j: &Value| (j["name"].as_str().unwrap().to_owned(), [at(j, 0), at(j, 1)]);
    rig["joints"].as_array().unwrap().iter().map(one).collect()
}

#[test]
fn the_bundled_child_is_rigged_and_its_rig_is_read_again() {
    let desk = Desk::new();
    let (rig, preview) = (desk.path("rig.json"), desk.path("rig.png"));
    let said = report(&[
        "rig",
        &sample("characters/child/drawing.png"),
        "-o",
        &rig,
        "--preview",
        &preview,
        "--vertices",
        "600",
    ]);
    let character = &said["character"];
    assert!(character["joints"].as_u64().unwrap() >= 8, "{character}");
    assert_eq!(character["bones"].as_u64().unwrap(), character["joints"].as_u64().unwrap() - 1, "one tree");
    let vertices = character["vertices"].as_u64().unwrap();
    assert!((500..2400).contains(&vertices), "{vertices}");
    assert_eq!(said["joints"].as_array().unwrap().len(), joints(&rig).len());
    let shown = image::open(&preview).unwrap().into_rgb8();
    assert!(shown.pixels().any(|p| p.0 == [20; 3]), "bones are drawn");
    // Joints at rest, as the rig has them, carry any motion of their names.
    let still: Vec<Value> = joints(&rig)
        .iter()
        .map(|(name, at)| {
            let frame = json!({ "points": [at], "visible": [true], "confidence": [1.0] });
            json!({ "name": name, "kind": "joint", "frames": [frame, frame] })
        })
        .collect();
    let motion =
        json!({ "format": "marey-motion", "version": 1, "size": [9, 9], "fps": 12.0, "frames": 2, "tracks": still });
    let motion = desk.write("still.json", motion.to_string());
    let out = desk.path("carried.json");
    report(&["retarget", &motion, "--rig", &rig, "-o", &out]);
    let carried: Value = serde_json::from_str(&std::fs::read_to_string(&out).unwrap()).unwrap();
    for (track, (name, at)) in carried["tracks"].as_array().unwrap().iter().zip(joints(&rig)) {
        assert_eq!(track["name"].as_str().unwrap(), name);
        for frame in 0..2 {
            let place = &track["frames"][frame]["points"][0];
            assert!(
                (place[0].as_f64().unwrap() - at[0]).abs() < 1e-4 && (place[1].as_f64().unwrap() - at[1]).abs() < 1e-4
            );
        }
    }
}

#[test]
fn drawings_of_all_kinds_get_a_skeleton_along_their_limbs() {
    let desk = Desk::new();
    let near = |rig: &str, x: f64, y: f64| joints(rig).iter().any(|(_, [jx, jy])| (jx - x).hypot(jy - y) < 22.0);
    let animal = desk.rigged(&desk.animal());
    for (x, y) in [(50.0, 180.0), (95.0, 180.0), (145.0, 180.0), (190.0, 180.0), (220.0, 25.0), (20.0, 40.0)] {
        assert!(near(&animal, x, y), "no joint at {x}, {y}: {:?}", joints(&animal));
    }
    let snake: Vec<([f32; 4], f32)> = (0..12)
        .map(|i| {
            let at = |i: i32| [20.0 + 18.0 * i as f32, 60.0 + 35.0 * (i as f32 * 0.8).sin()];
            let (a, b) = (at(i), at(i + 1));
            ([a[0], a[1], b[0], b[1]], 9.0)
        })
        .collect();
    let snake = desk.rigged(&desk.drawing("snake.png", (256, 120), &snake));
    assert!(joints(&snake).len() >= 4 && near(&snake, 20.0, 60.0), "{:?}", joints(&snake));
    let fish =
        [([40.0, 60.0, 120.0, 60.0], 30.0), ([150.0, 60.0, 190.0, 30.0], 7.0), ([150.0, 60.0, 190.0, 90.0], 7.0)];
    let fish = desk.rigged(&desk.drawing("fish.png", (210, 120), &fish));
    assert!(near(&fish, 190.0, 30.0) && near(&fish, 190.0, 90.0), "{:?}", joints(&fish));
    let plant = [([60.0, 190.0, 60.0, 40.0], 6.0), ([60.0, 120.0, 110.0, 70.0], 5.0), ([60.0, 90.0, 15.0, 50.0], 5.0)];
    let plant = desk.rigged(&desk.drawing("plant.png", (130, 200), &plant));
    assert!(near(&plant, 110.0, 70.0) && near(&plant, 15.0, 50.0) && near(&plant, 60.0, 190.0), "{:?}", joints(&plant));
    // Two pieces, and a ring with its hole.
    let pieces = [([30.0, 30.0, 30.0, 100.0], 12.0), ([90.0, 30.0, 90.0, 100.0], 12.0)];
    let pieces = desk.rigged(&desk.drawing("pieces.png", (120, 130), &pieces));
    assert!(near(&pieces, 30.0, 30.0) && near(&pieces, 90.0, 100.0), "{:?}", joints(&pieces));
    let ring: Vec<([f32; 4], f32)> = (0..24)
        .map(|i| {
            let at = |i: i32| {
                let (sin, cos) = (std::f32::consts::TAU * i as f32 / 24.0).sin_cos();
                [64.0 + 40.0 * cos, 64.0 + 40.0 * sin]
            };
            let (a, b) = (at(i), at(i + 1));
            ([a[0], a[1], b[0], b[1]], 9.0)
        })
        .collect();
    let ring = desk.rigged(&desk.drawing("ring.png", (128, 128), &ring));
    assert!(!joints(&ring).is_empty());
}

#[test]
fn the_strokes_of_a_tracked_animal_move_a_drawn_one() {
    let desk = Desk::new();
    let rig = desk.rigged(&desk.animal());
    let leg = |name: &str, x: f64, phase: f64| {
        let frame = |f: u32| {
            let swing = (f64::from(f) * 0.8 + phase).sin();
            json!({ "points": [[x, 50.0], [x + 6.0 * swing, 75.0], [x + 14.0 * swing, 100.0]],
                    "visible": [true, true, true], "confidence": [1.0, 1.0, 1.0] })
        };
        json!({ "name": name, "kind": "stroke", "frames": (0..8).map(frame).collect::<Vec<_>>() })
    };
    let body = json!({ "points": [[20.0, 50.0], [100.0, 50.0]], "visible": [true, true], "confidence": [1.0, 1.0] });
    let body = json!({ "name": "body", "kind": "stroke", "frames": vec![body; 8] });
    let motion = json!({
        "format": "marey-motion", "version": 1, "size": [128, 128], "fps": 12.0, "frames": 8,
        "tracks": [body, leg("hind_a", 22.0, 0.0), leg("hind_b", 34.0, 3.0), leg("fore_a", 86.0, 0.1), leg("fore_b", 98.0, 3.0)],
        "bones": [["body", "hind_a"], ["body", "hind_b"], ["body", "fore_a"], ["body", "fore_b"]],
    });
    let motion = desk.write("motion.json", motion.to_string());
    let (out, map, bvh) = (desk.path("carried.json"), desk.path("map.json"), desk.path("carried.bvh"));
    let said = report(&["retarget", &motion, "--rig", &rig, "-o", &out, "--keep-map", &map]);
    let followed = said["followed"]["map"]["joints"].as_object().unwrap().clone();
    // Each drawn foot follows the end of a leg of its own, from left to right as they stand.
    let mut feet: Vec<(String, [f64; 2])> = joints(&rig).into_iter().filter(|j| j.1[1] > 165.0).collect();
    feet.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let order: Vec<&str> = feet.iter().map(|f| followed[&f.0]["track"].as_str().unwrap()).collect();
    assert_eq!(order, ["hind_a", "hind_b", "fore_a", "fore_b"]);
    let carried: Value = serde_json::from_str(&std::fs::read_to_string(&out).unwrap()).unwrap();
    let track = carried["tracks"].as_array().unwrap().iter().find(|t| t["name"] == feet[0].0.as_str()).unwrap().clone();
    let xs: Vec<f64> = (0..8).map(|f| track["frames"][f]["points"][0][0].as_f64().unwrap()).collect();
    let way = xs.iter().copied().fold(f64::MIN, f64::max) - xs.iter().copied().fold(f64::MAX, f64::min);
    assert!(way > 10.0, "the foot swings: {xs:?}");
    // The map that was found is one that can be given back, and BVH is another way out and in.
    let again = desk.path("again.json");
    report(&["retarget", &motion, "--rig", &rig, "-o", &again, "--map", &map]);
    assert_eq!(std::fs::read(&out).unwrap(), std::fs::read(&again).unwrap());
    report(&["retarget", &out, "--rig", &rig, "-o", &bvh]);
    assert!(std::fs::read_to_string(&bvh).unwrap().starts_with("HIERARCHY"));
    report(&["retarget", &bvh, "--rig", &rig, "-o", &again]);
}

#[test]
fn the_bundled_child_walks_and_every_picture_is_read_by_others() {
    let desk = Desk::new();
    let (picture, rig, poses) = (
        sample("characters/child/drawing.png"),
        sample("characters/child/rig.json"),
        sample("characters/child/poses.json"),
    );
    let play = |out: &str, more: &[&str]| {
        let out = desk.path(out);
        report(&[&["character", &picture, "--rig", &rig, "--poses", &poses, "-o", &out], more].concat())
    };
    let said = play("frames", &["--scale", "0.5"]);
    assert_eq!((said["frames"].as_u64(), said["fps"].as_f64()), (Some(25), Some(24.0)));
    assert_eq!(said["files"][0].as_str().unwrap(), desk.path("frames"));
    let frames: Vec<RgbaImage> =
        (0..25).map(|f| image::open(desk.path(&format!("frames/{f:05}.png"))).unwrap().into_rgba8()).collect();
    let differ = |a: &RgbaImage, b: &RgbaImage| a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count();
    assert_eq!(frames[0], frames[24], "the walk goes round");
    assert!(differ(&frames[0], &frames[12]) > 500);
    let gif = play("child.gif", &["--scale", "0.5", "--background", "white"]);
    assert_eq!(gif["shown"], said["shown"], "the same is shown in every format");
    use image::AnimationDecoder;
    let file = std::io::BufReader::new(std::fs::File::open(desk.path("child.gif")).unwrap());
    let decoded = image::codecs::gif::GifDecoder::new(file).unwrap().into_frames().collect_frames().unwrap();
    assert_eq!(decoded[0].buffer().dimensions(), frames[0].dimensions());
    // A palette has no room for every shade.
    assert!(decoded[0].buffer().get_pixel(0, 0).0.iter().all(|c| *c >= 245));
    for out in ["child.png", "child.webp", "child.mp4"] {
        play(out, &["--scale", "0.5", "--background", "#ffffff"]);
        let clip = report(&["info", &desk.path(out)]);
        assert_eq!(clip["clip"]["frames"].as_u64(), Some(25), "{out}: {clip}");
    }
    let cropped = play("cropped", &["--no-grow"]);
    assert_eq!(cropped["shown"], json!([0, 0, 349, 408]));
    // A take that is written again is the same, and another deformer makes another.
    let bytes = std::fs::read(desk.path("child.gif")).unwrap();
    play("child.gif", &["--scale", "0.5", "--background", "white", "--threads", "1"]);
    assert_eq!(std::fs::read(desk.path("child.gif")).unwrap(), bytes);
    play("child.gif", &["--scale", "0.5", "--background", "white", "--deformer", "arap"]);
    assert_ne!(std::fs::read(desk.path("child.gif")).unwrap(), bytes);
    assert!(
        fails(
            &[
                "character",
                &picture,
                "--rig",
                &rig,
                "--poses",
                &poses,
                "-o",
                &desk.path("x.gif"),
                "--background",
                "teal-ish"
            ],
            2
        )
        .contains("teal-ish")
    );
    assert!(
        fails(
            &["character", &picture, "--rig", &rig, "--poses", &poses, "-o", &desk.path("x.gif"), "--deformer", "clay"],
            2
        )
        .contains("clay")
    );
    report(&["demo", "--character", "-o", &desk.path("demo")]);
    assert!(desk.0.path().join("demo/child.gif").exists());
}

#[test]
fn a_mask_cuts_out_what_an_opaque_picture_does_not_show() {
    let desk = Desk::new();
    let noise = RgbaImage::from_fn(120, 90, |x, y| {
        Rgba([(x * 97 % 256) as u8, (y * 61 % 256) as u8, (x * y % 256) as u8, 255])
    });
    noise.save(desk.path("noise.png")).unwrap();
    let mask = image::GrayImage::from_fn(120, 90, |x, y| {
        image::Luma([if (20..100).contains(&x) && (35..55).contains(&y) { 255 } else { 0 }])
    });
    mask.save(desk.path("mask.png")).unwrap();
    let rig = desk.path("rig.json");
    report(&["rig", &desk.path("noise.png"), "-o", &rig, "--mask", &desk.path("mask.png")]);
    assert!(joints(&rig).iter().all(|j| (30.0..60.0).contains(&j.1[1])), "{:?}", joints(&rig));
    image::GrayImage::new(5, 5).save(desk.path("small.png")).unwrap();
    let said = fails(&["rig", &desk.path("noise.png"), "-o", &rig, "--mask", &desk.path("small.png")], 3);
    assert!(said.contains("5x5") && said.contains("120x90"), "{said}");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let desk = Desk::new();
    let picture = desk.animal();
    let rig = desk.rigged(&picture);
    let before = desk.names();
    let out = desk.path("out.gif");
    let poses = desk.path("poses.json");
    RgbaImage::new(0, 0).save(desk.path("none.png")).ok();
    RgbaImage::new(40, 40).save(desk.path("clear.png")).unwrap();
    RgbaImage::from_pixel(40, 40, Rgba([9, 9, 9, 255])).save(desk.path("full.png")).unwrap();
    let bad = desk.path("bad.json");
    for (name, says) in [("clear.png", "transparent"), ("full.png", "one colour"), ("missing.png", "missing.png")] {
        let said = fails(&["rig", &desk.path(name), "-o", &bad], 3);
        assert!(said.contains(says) && said.contains(name), "{said}");
    }
    assert!(fails(&["rig", &picture, "-o", &bad, "--vertices", "9000000"], 3).contains("vertex count"));
    assert!(fails(&["rig", &picture, "-o", &bad, "--finer-at-joints", "0.5"], 3).contains("finer_at_joints"));
    assert!(fails(&["rig", &picture, "-o", &bad, "--finer-at-joints", "NaN"], 2).contains("finer"));
    assert!(fails(&["rig", &picture, "-o", &desk.path("no/rig.json")], 3).contains("create it"));
    assert!(fails(&["character", &picture, "--rig", &rig, "-o", &out], 2).contains("--poses"));

    // Rigs that cannot be used.
    let good: Value = serde_json::from_str(&std::fs::read_to_string(&rig).unwrap()).unwrap();
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut rig = good.clone();
        change(&mut rig);
        desk.write("changed.json", rig.to_string())
    };
    desk.write("poses.json", r#"{"format": "marey-poses", "version": 1, "keys": [{"frame": 0}, {"frame": 4}]}"#);
    let animate =
        |rig: &str, code: i32| fails(&["character", &picture, "--rig", rig, "--poses", &poses, "-o", &out], code);
    let text = std::fs::read_to_string(&rig).unwrap();
    assert!(animate(&desk.write("cut.json", &text[..text.len() / 2]), 3).contains("not readable"));
    assert!(animate(&changed(&|r| r["version"] = json!(7)), 3).contains("version 7"));
    assert!(animate(&changed(&|r| r["size"] = json!([10, 10])), 3).contains("10x10"));
    assert!(
        animate(&changed(&|r| r["joints"][1]["name"] = r["joints"][0]["name"].clone()), 3)
            .contains("no joint is called")
    );
    assert!(animate(&changed(&|r| r["bones"] = json!([])), 3).contains("no bones"));
    assert!(animate(&changed(&|r| r["bones"][0][1] = json!("nobody")), 3).contains("nobody"));
    assert!(animate(&changed(&|r| r["joints"][0]["at"] = json!([1e300, 0])), 3).contains("changed.json"));

    // Poses that cannot be used.
    let pose = |text: &str| {
        desk.write("poses.json", text);
        animate(&rig, 3)
    };
    assert!(pose(r#"{"format": "marey-poses", "version": 1, "keys": []}"#).contains("no keys"));
    assert!(
        pose(r#"{"format": "marey-poses", "version": 1, "keys": [{"frame": 0, "joints": {"wing": [1, 2]}}]}"#)
            .contains("`wing`")
    );
    assert!(
        pose(r#"{"format": "marey-poses", "version": 1, "keys": [{"frame": 4}, {"frame": 2}]}"#).contains("frame 2")
    );
    assert!(pose(r#"{"format": "marey-poses", "vers"#).contains("not readable"));
    assert!(
        pose(r#"{"format": "marey-poses", "version": 1, "keys": [{"frame": 0, "joints": {"j": [NaN, 0]}}]}"#)
            .contains("poses.json")
    );

    // Motions and maps that lead nowhere: both sides' names are said, and how a map is written.
    let frame = json!({ "points": [[1.0, 2.0]], "visible": [true], "confidence": [1.0] });
    let nose = json!({ "format": "marey-motion", "version": 1, "size": [9, 9], "fps": 12.0, "frames": 1,
                       "tracks": [{ "name": "nose", "kind": "point", "frames": [frame] }] });
    let motion = desk.write("nose.json", nose.to_string());
    let name = joints(&rig)[0].0.clone();
    let said = fails(&["character", &picture, "--rig", &rig, "--motion", &motion, "-o", &out], 3);
    assert!(said.contains("`nose`") && said.contains(&format!("`{name}`")) && said.contains(r#"{"joints""#), "{said}");
    let map = desk.write("map.json", format!(r#"{{"joints": {{"{name}": {{"track": "tail"}}}}}}"#));
    let said = fails(&["character", &picture, "--rig", &rig, "--motion", &motion, "--map", &map, "-o", &out], 3);
    assert!(said.contains("`tail`") && said.contains("`nose`"), "{said}");
    let map = desk.write("map.json", r#"{"joints": {"wing": {"track": "nose"}}}"#);
    let said = fails(&["character", &picture, "--rig", &rig, "--motion", &motion, "--map", &map, "-o", &out], 3);
    assert!(said.contains("`wing`"), "{said}");
    let map = desk.write("map.json", r#"{"joints": {"#);
    assert!(fails(&["retarget", &motion, "--rig", &rig, "--map", &map, "-o", &bad], 3).contains("not readable"));
    assert!(fails(&["retarget", &motion, "--rig", &rig, "--reference", "9", "-o", &bad], 3).contains("reference"));
    let line = json!({ "points": [[1.0, 2.0], [1.0, 9.0]], "visible": [true, true], "confidence": [1.0, 1.0] });
    let line = json!({ "format": "marey-motion", "version": 1, "size": [9, 9], "fps": 12.0, "frames": 1,
                       "tracks": [{ "name": "line", "kind": "stroke", "frames": [line] }] });
    let line = desk.write("line.json", line.to_string());
    let said = fails(&["character", &picture, "--rig", &rig, "--motion", &line, "-o", &desk.path("out.xyz")], 3);
    assert!(said.contains("`xyz`") && said.contains("dragonbones"), "{said}");

    let after: Vec<String> = desk.names();
    let left: Vec<&String> = after.iter().filter(|n| n.starts_with("out") || n.as_str() == "bad.json").collect();
    assert!(left.is_empty(), "{left:?}; before: {before:?}");
}

#[test]
fn skeletons_that_are_odd_but_whole_are_moved() {
    let desk = Desk::new();
    let picture = desk.animal();
    let rig = desk.rigged(&picture);
    let good: Value = serde_json::from_str(&std::fs::read_to_string(&rig).unwrap()).unwrap();
    let first = good["joints"][0].clone();
    let mut odd = good;
    // A bone outside the drawing, one without length, and two on one spot.
    let root = first["name"].clone();
    let joints = odd["joints"].as_array_mut().unwrap();
    joints.push(json!({ "name": "outside", "at": [-300.0, -300.0] }));
    joints.push(json!({ "name": "far", "at": [-340.0, -300.0] }));
    joints.push(json!({ "name": "same", "at": first["at"] }));
    joints.push(json!({ "name": "twin_a", "at": [120.0, 60.0] }));
    joints.push(json!({ "name": "twin_b", "at": [120.0, 60.0] }));
    let bones = odd["bones"].as_array_mut().unwrap();
    bones.push(json!(["outside", "far"]));
    for name in ["same", "twin_a", "twin_b"] {
        bones.push(json!([root, name]));
    }
    let rig = desk.write("odd.json", odd.to_string());
    let frame = |x: f64| json!({ "points": [[x, 0.0], [x, 50.0]], "visible": [true, true], "confidence": [1.0, 1.0] });
    let motion = json!({ "format": "marey-motion", "version": 1, "size": [99, 99], "fps": 12.0, "frames": 2,
                         "tracks": [{ "name": "line", "kind": "stroke", "frames": [frame(0.0), frame(9.0)] }] });
    let motion = desk.write("line.json", motion.to_string());
    let out = desk.path("carried.json");
    report(&["retarget", &motion, "--rig", &rig, "-o", &out]);
    let carried: Value = serde_json::from_str(&std::fs::read_to_string(&out).unwrap()).unwrap();
    let finite = carried["tracks"].as_array().unwrap().iter().all(|t| t["frames"][1]["points"][0][0].is_number());
    assert!(finite, "{carried}");
}

#[test]
#[cfg(unix)]
fn a_cancel_leaves_nothing() {
    let desk = Desk::new();
    let lines: Vec<([f32; 4], f32)> = (0..40).map(|i| ([200.0, 1000.0, 60.0 + 48.0 * i as f32, 60.0], 9.0)).collect();
    let picture = desk.drawing("large.png", (2000, 2000), &lines);
    let rig = desk.path("rig.json");
    let mut child = Command::new(env!("CARGO_BIN_EXE_marey"))
        .args(["rig", &picture, "-o", &rig, "--vertices", "150000"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(400));
    let asked = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let code = child.wait().unwrap().code();
    // Work that was done just before is no failure.
    assert!(code == Some(130) || code == Some(0), "{code:?}");
    assert!(code == Some(0) || !PathBuf::from(&rig).exists());
    assert!(asked.elapsed() < Duration::from_secs(5));
}
