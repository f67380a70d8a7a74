//! Loops, steady feet, other times and other creatures, as a user of the command line meets them.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{fails, report};
use serde_json::json;

/// A body on two legs that walk, with a stride of `period` frames; `names` of the body and the legs.
fn walk(names: [&str; 3], period: f64, length: f64) -> String {
    let limb = |k: usize| {
        let frame = |f: usize| {
            let (x, y) = (100.0 + 2.0 * f as f64, 100.0);
            let swing = 0.4 * (std::f64::consts::TAU * f as f64 / period).sin() * if k == 1 { 1.0 } else { -1.0 };
            let points = match k {
                0 => vec![[x, y], [x + 20.0, y - 0.3 * length], [x + 40.0, y - 0.5 * length]],
                _ => (0..5)
                    .map(|i| f64::from(i) * length / 4.0)
                    .map(|l| [x + l * swing.sin(), y + l * swing.cos()])
                    .collect(),
            };
            let count = points.len();
            json!({ "points": points, "visible": vec![true; count], "confidence": vec![0.9; count] })
        };
        json!({ "name": names[k], "kind": "stroke", "frames": (0..50).map(frame).collect::<Vec<_>>() })
    };
    let [body, one, two] = names;
    json!({
        "format": "marey-motion", "version": 1, "size": [400, 300], "fps": 24.0, "frames": 50,
        "tracks": (0..3).map(limb).collect::<Vec<_>>(), "bones": [[body, one], [body, two]],
    })
    .to_string()
}

#[test]
fn a_walk_is_looped_steadied_retimed_and_put_on_another() {
    let desk = tempfile::tempdir().unwrap();
    let path = |name: &str| desk.path().join(name).to_str().unwrap().to_owned();
    let (walking, other) = (path("walk.json"), path("other.json"));
    std::fs::write(&walking, walk(["body", "leg_left", "leg_right"], 20.0, 80.0)).unwrap();
    std::fs::write(&other, walk(["torso", "hind_near", "hind_far"], 37.0, 50.0)).unwrap();

    let cycle = report(&["motion", "cycle", &walking]);
    assert!((cycle["period"].as_f64().unwrap() - 20.0).abs() < 0.1, "{cycle}");
    let closed = path("loop.json");
    let said = report(&["motion", "loop", &walking, "-o", &closed]);
    assert_eq!(said["frames"].as_u64(), Some(20), "{said}");
    assert!(said["seam"]["pose_most"].as_f64().unwrap() < 0.01, "{said}");
    assert!((said["travel"][0].as_f64().unwrap() - 40.0).abs() < 1.0, "{said}");
    let said = report(&["motion", "plant", &closed, "-o", &path("planted.json"), "--closed"]);
    assert_eq!(said["feet"].as_array().map(Vec::len), Some(2), "{said}");
    report(&["motion", "smooth", &walking, "-o", &path("smooth.json"), "--period", "4", "--hold", "0,49"]);
    let said = report(&["motion", "retime", &closed, "-o", &path("slow.json"), "--speed", "0.5", "--closed"]);
    assert_eq!(said["frames"].as_u64(), Some(40), "{said}");
    let keys = ["--key", "0=0", "--key", "10=30:in-out", "--key", "20=49"];
    let said = report(&[&["motion", "retime", &walking, "-o", &path("keyed.json")][..], &keys].concat());
    assert_eq!(said["frames"].as_u64(), Some(21), "{said}");

    let (carried, kept) = (path("carried.json"), path("map.json"));
    let said = report(&["motion", "map", &walking, "--onto", &other, "-o", &carried, "--keep-map", &kept]);
    assert_eq!(said["map"]["limbs"]["hind_near"]["tracks"], json!(["leg_left"]), "{said}");
    let first = std::fs::read_to_string(&carried).unwrap();
    report(&["motion", "map", &walking, "--onto", &other, "-o", &carried, "--map", &kept]);
    assert_eq!(std::fs::read_to_string(&carried).unwrap(), first, "the map that was kept gives the same again");
}

#[test]
fn what_cannot_be_is_said_in_one_line() {
    let desk = tempfile::tempdir().unwrap();
    let path = |name: &str| desk.path().join(name).to_str().unwrap().to_owned();
    let (long, out) = (path("long.json"), path("out.json"));
    std::fs::write(&long, walk(["body", "a", "b"], 400.0, 80.0)).unwrap();
    let said = fails(&["motion", "loop", &long, "-o", &out], 3);
    assert!(said.contains("cycle") && said.contains("where the loop begins"), "{said}");
    assert!(fails(&["motion", "loop", &long, "-o", &out, "--start", "40", "--period", "20"], 3).contains("range"));
    assert!(fails(&["motion", "plant", &long, "-o", &out, "--feet", "hoof"], 3).contains("`hoof`"));
    assert!(fails(&["motion", "retime", &long, "-o", &out, "--key", "5"], 2).contains("AT=FRAME"));
    assert!(fails(&["motion", "retime", &long, "-o", &out, "--speed", "0"], 2).contains("--speed"));
    assert!(fails(&["motion", "smooth", &long, "-o", &out, "--period", "1"], 3).contains("period"));
    assert!(fails(&["motion", "map", &long, "--onto", &path("none.json"), "-o", &out], 3).contains("none.json"));
    assert!(!desk.path().join("out.json").exists());
}
