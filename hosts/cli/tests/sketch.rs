//! Vector drawings that take a motion, as a user of the command line meets them.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::path::Path;

use common::{Desk, fails, marey, report, sample};
use image::{Rgb, RgbImage};
use serde_json::{Value, json};

impl Desk {
    /// The motion of the bundled fish.
    fn swim(&self) -> String {
        let motion = self.path("swim.json");
        report(&["path", &sample("paths/fish.json"), "-o", &motion]);
        motion
    }
}

#[test]
fn paths_move_a_drawing_into_every_format() {
    let desk = Desk::new();
    let (swim, fish) = (desk.swim(), sample("drawings/fish.svg"));
    let (svg, lottie, gif) = (desk.path("fish.svg"), desk.path("fish.json"), desk.path("fish.gif"));
    let keep = desk.path("bind.json");
    report(&["sketch", &fish, "--motion", &swim, "--as-drawn", "-o", &svg, "--keep-bind", &keep]);
    let text = std::fs::read_to_string(&svg).unwrap();
    assert!(text.contains("<animate") && !text.contains("<script"), "{}", &text[..400]);
    // The binding that was kept gives the same drawing again.
    let again = desk.path("again.svg");
    report(&["sketch", &fish, "--motion", &swim, "--bind", &keep, "-o", &again]);
    let body = |t: &str| t.split_once("<path").unwrap().1.to_owned();
    assert_eq!(body(&std::fs::read_to_string(&again).unwrap()), body(&text));
    let said = report(&["sketch", &fish, "--motion", &swim, "--bind", &keep, "-o", &lottie]);
    assert_eq!((said["frames"].as_u64(), said["strokes"].as_u64()), (Some(48), Some(16)), "{said}");
    let scene: Value = serde_json::from_str(&std::fs::read_to_string(&lottie).unwrap()).unwrap();
    assert!(!scene["layers"].as_array().unwrap().is_empty());
    report(&["sketch", &fish, "--motion", &swim, "--bind", &keep, "-o", &gif, "--scale", "0.5"]);
    assert!(std::fs::read(&gif).unwrap().starts_with(b"GIF89a"));
    for (format, name) in [("apng", "a.png"), ("webp", "a.webp"), ("png-dir", "frames"), ("sprite-sheet", "sheet")] {
        let out = desk.path(name);
        let said = report(&[
            "sketch", &fish, "--motion", &swim, "--bind", &keep, "-o", &out, "--format", format, "--scale", "0.3",
        ]);
        for file in said["files"].as_array().unwrap() {
            assert!(Path::new(file.as_str().unwrap()).exists(), "{format}: {file}");
        }
    }
}

#[test]
fn stiff_strokes_decoration_pins_and_layers_are_asked_for_in_words() {
    let desk = Desk::new();
    let (swim, fish, keep) = (desk.swim(), sample("drawings/fish.svg"), desk.path("bind.json"));
    let names: Vec<String> = {
        report(&[
            "sketch",
            &fish,
            "--motion",
            &swim,
            "--as-drawn",
            "-o",
            &desk.path("a.svg"),
            "--layer",
            "front=path1",
            "--keep-bind",
            &keep,
        ]);
        let bind: Value = serde_json::from_str(&std::fs::read_to_string(&keep).unwrap()).unwrap();
        let layers = bind["layers"].as_array().unwrap();
        assert_eq!(layers.len(), 2, "{bind}");
        layers.iter().flat_map(|l| l["strokes"].as_array().unwrap()).map(|s| s.as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names.len(), 16);
    let svg = desk.path("b.svg");
    report(&[
        "sketch",
        &fish,
        "--motion",
        &swim,
        "--as-drawn",
        "-o",
        &svg,
        "--rigidity",
        "path2=100",
        "--decoration",
        "path3",
        "--pin",
        "120,140",
        "--motion-scale",
        "0.5",
        "--motion-rotation",
        "90",
        "--travel",
        "0",
        "--keep-bind",
        &keep,
    ]);
    let bind: Value = serde_json::from_str(&std::fs::read_to_string(&keep).unwrap()).unwrap();
    assert_eq!(bind["motions"][0]["scale"], json!(0.5));
    assert_eq!(bind["motions"][0]["rotation"], json!(90.0));
    assert_eq!(bind["pins"][0]["at"], json!([120.0, 140.0]));
    assert_eq!(bind["strokes"].as_array().unwrap().len(), 2, "{bind}");
    // What stands still is not animated.
    let text = std::fs::read_to_string(&svg).unwrap();
    let still = text.split("<path").find(|p| p.contains("data-name=\"path3\"")).unwrap();
    assert!(!still.contains("<animate") || !still.contains("attributeName=\"d\""), "{still}");
    let wrong = |args: &[&str], code: i32, expected: &str| {
        let said = fails(&[&["sketch", &fish, "--motion", &swim, "--as-drawn", "-o", &svg], args].concat(), code);
        assert!(said.contains(expected), "{said} should say {expected}");
    };
    wrong(&["--rigidity", "path2"], 2, "STROKE=R");
    wrong(&["--rigidity", "path2=stiff"], 2, "no number");
    wrong(&["--rigidity", "nothing=2"], 3, "nothing");
    wrong(&["--pin", "12"], 2, "X,Y");
    wrong(&["--layer", "front=nothing"], 3, "nothing");
    wrong(&["--background", "mauve-ish"], 2, "no colour");
    wrong(&["--format", "flash"], 3, "flash");
}

/// A clip of a dark bar on light paper that nods, and where its ends are.
fn nodding(desk: &Desk) -> (String, String) {
    let folder = desk.path("clip");
    std::fs::create_dir(&folder).unwrap();
    let end = |frame: u32| (60.0 + 90.0 * (0.06 * frame as f32).cos(), 60.0 + 90.0 * (0.06 * frame as f32).sin());
    for frame in 0..8 {
        let (ex, ey) = end(frame);
        let picture = RgbImage::from_fn(200, 140, |x, y| {
            let (px, py, dx, dy) = (x as f32 - 60.0, y as f32 - 60.0, ex - 60.0, ey - 60.0);
            let t = ((px * dx + py * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
            let inside = (px - t * dx).hypot(py - t * dy) < 14.0;
            // A grain that goes along with the bar.
            let (u, v) = ((t * 90.0) as i32, ((px * dy - py * dx) / 90.0) as i32);
            let grain = ((u / 7 + v / 5).rem_euclid(2) * 60 + (u * 3 + v * 5).rem_euclid(40)) as u8;
            if inside { Rgb([30 + grain, 40, 90]) } else { Rgb([225, 225, 220]) }
        });
        picture.save(Path::new(&folder).join(format!("{frame:03}.png"))).unwrap();
    }
    let key = |name: &str, at: (f32, f32)| json!({ "name": name, "keys": [{ "frame": 0, "at": [at.0, at.1] }] });
    let middle = (105.0, 60.0);
    let points = json!({ "format": "marey-points", "version": 1, "size": [200, 140],
        "points": [key("root", (60.0, 60.0)), key("middle", middle), key("tip", (146.0, 60.0))] });
    (folder, desk.write("points.json", points.to_string()))
}

#[test]
fn from_a_clip_to_a_drawing_that_nods() {
    let desk = Desk::new();
    let (clip, points) = nodding(&desk);
    let motion = desk.path("motion.json");
    let said = report(&["track", &clip, "--points", &points, "-o", &motion]);
    assert_eq!(said["format"], "marey-point-report");
    assert!(!said["correct_next"].as_array().unwrap().is_empty(), "{said}");
    let tracked: Value = serde_json::from_str(&std::fs::read_to_string(&motion).unwrap()).unwrap();
    let tip = &tracked["tracks"][2]["frames"][7]["points"][0];
    let (x, y) = (tip[0].as_f64().unwrap(), tip[1].as_f64().unwrap());
    let (ex, ey) = (60.0 + 86.0 * 0.42f64.cos(), 60.0 + 86.0 * 0.42f64.sin());
    assert!((x - ex).hypot(y - ey) < 6.0, "the tip went to {x}, {y} and not to {ex}, {ey}");
    let drawing = desk.write(
        "bone.svg",
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="300" height="100"><path id="bone" fill="#eee" stroke="#000"
        stroke-width="4" d="M30 35 C120 30 200 30 270 36 C285 45 285 58 270 64 C200 70 120 70 30 65 C16 58 16 44 30 35 Z"/></svg>"##,
    );
    let (bind, preview, moving) = (desk.path("bind.json"), desk.path("bind.png"), desk.path("bone.json"));
    let said = report(&["bind", &drawing, "--motion", &motion, "--clip", &clip, "-o", &bind, "--preview", &preview]);
    let points = said["points"].as_array().unwrap();
    assert_eq!(points.len(), 3, "{said}");
    let across: Vec<f64> = points.iter().map(|p| p["at"][0].as_f64().unwrap()).collect();
    let spread = (across[2] - across[0]).abs();
    assert!(spread > 150.0, "the ends of the bar hold the ends of the bone: {across:?}");
    image::open(&preview).unwrap();
    let said = report(&["sketch", &drawing, "--motion", &motion, "--bind", &bind, "-o", &moving]);
    assert_eq!(said["frames"].as_u64(), Some(8), "{said}");
    // Without the clip the points alone suggest a figure.
    report(&["sketch", &drawing, "--motion", &motion, "-o", &desk.path("alone.svg")]);
}

#[test]
fn what_cannot_be_drawn_or_bound_is_said() {
    let desk = Desk::new();
    let swim = desk.swim();
    let (out, fish) = (desk.path("out.svg"), sample("drawings/fish.svg"));
    let svg = |name: &str, inside: &str| {
        desk.write(name, format!(r#"<svg xmlns="http://www.w3.org/2000/svg" width="60" height="60">{inside}</svg>"#))
    };
    let says = |drawing: &str, motion: &str, code: i32, expected: &str| {
        let said = fails(&["sketch", drawing, "--motion", motion, "--as-drawn", "-o", &out], code);
        assert!(said.contains(expected), "{said} should say {expected}");
        assert!(!Path::new(&out).exists());
    };
    says(&svg("empty.svg", ""), &swim, 3, "empty.svg");
    says(&svg("text.svg", "<text x='5' y='20'>moo</text>"), &swim, 3, "text");
    says(&svg("image.svg", "<image href='file:///etc/passwd' width='9' height='9'/>"), &swim, 3, "image.svg");
    says(&desk.write("no.svg", "hello"), &swim, 3, "no.svg");
    says(&desk.path("missing.svg"), &swim, 3, "missing.svg");
    says(&fish, &desk.write("no.json", "{}"), 3, "no.json");
    // A script is no part of a drawing; what is drawn moves.
    let scripted = svg("script.svg", "<script>alert(1)</script><path d='M5 5 L50 50' stroke='#000'/>");
    assert!(marey(&["sketch", &scripted, "--motion", &swim, "--as-drawn", "-o", &out]).status.success());
    assert!(!std::fs::read_to_string(&out).unwrap().contains("alert"));
    // One frame is a still drawing that plays.
    let (still, paths) = (
        desk.path("still.json"),
        desk.write(
            "one.json",
            json!({
                "format": "marey-paths", "version": 1, "size": [60, 60], "fps": 24, "seconds": 0.05,
                "points": [{ "name": "a", "path": "M80 142 L90 142" }],
            })
            .to_string(),
        ),
    );
    report(&["path", &paths, "-o", &still]);
    let said =
        report(&["sketch", &fish, "--motion", &still, "--as-drawn", "-o", &desk.path("one.gif"), "--scale", "0.3"]);
    assert_eq!(said["frames"].as_u64(), Some(1), "{said}");
    // Fewer than three points suggest no figure.
    let said = fails(&["bind", &fish, "--motion", &still, "-o", &desk.path("b.json")], 3);
    assert!(said.contains("point"), "{said}");
    let said = fails(&["sketch", &fish, &fish, "--motion", &swim, "--as-drawn", "-o", &desk.path("many")], 2);
    assert!(said.contains("--format"), "{said}");
    let many = desk.path("many");
    report(&[
        "sketch",
        &fish,
        &sample("drawings/snake.svg"),
        "--motion",
        &swim,
        "--as-drawn",
        "-o",
        &many,
        "--format",
        "lottie",
    ]);
    assert!(Path::new(&many).join("fish.json").exists() && Path::new(&many).join("snake.json").exists());
}

#[test]
fn points_are_found_on_what_moves_and_followed() {
    let desk = Desk::new();
    let (clip, points) = (sample("fox/clip.mp4"), desk.path("points.json"));
    let said = report(&["points", &clip, "--frame", "30", "-o", &points]);
    let file: Value = serde_json::from_str(&std::fs::read_to_string(&points).unwrap()).unwrap();
    let marks = file["points"].as_array().unwrap();
    assert_eq!((said["points"].as_u64(), said["frame"].as_u64()), (Some(marks.len() as u64), Some(30)));
    // On the fox, as it truly is, and all over it: nose, tail and four feet are far apart.
    let fox = image::open(sample("fox/masks/00030.png")).unwrap().to_luma8();
    let at: Vec<(f64, f64)> = marks
        .iter()
        .map(|mark| {
            let at = &mark["keys"][0]["at"];
            (at[0].as_f64().unwrap(), at[1].as_f64().unwrap())
        })
        .collect();
    for (x, y) in &at {
        let near = (-3..=3)
            .any(|dy| (-3..=3).any(|dx| fox.get_pixel((*x as i32 + dx) as u32, (*y as i32 + dy) as u32).0[0] > 127));
        assert!(near, "({x}, {y}) is beside the fox");
    }
    let inside: Vec<(u32, u32)> = fox.enumerate_pixels().filter(|p| p.2.0[0] > 127).map(|p| (p.0, p.1)).collect();
    let wide = |of: &mut dyn Iterator<Item = f64>| {
        let (low, high) = of.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
        high - low
    };
    let all = wide(&mut inside.iter().map(|p| f64::from(p.0)));
    assert!(wide(&mut at.iter().map(|p| p.0)) > 0.9 * all && at.len() >= 8, "{at:?}");
    let feet = inside.iter().map(|p| p.1).max().unwrap();
    assert!(at.iter().filter(|p| f64::from(feet) - p.1 < 25.0).count() >= 4, "{at:?}");
    let motion = desk.path("motion.json");
    report(&["track", &clip, "--points", &points, "-o", &motion]);
    assert!(std::fs::read_to_string(&motion).unwrap().contains("marey-motion"));

    // Left to itself it takes a frame on which the legs are apart. What is read is never written over.
    let said = report(&["points", &clip, "-o", &points]);
    assert!(said["points"].as_u64() >= Some(8) && said["frame"].as_u64() < Some(60), "{said}");
    let marks = std::fs::read(&points).unwrap();
    let refused = fails(&["track", &clip, "--points", &points, "-o", &points], 2);
    assert!(refused.contains("is read, and would be lost"), "{refused}");
    fails(&["track", &clip, &format!("--points={points}"), "--output", &points], 2);
    assert_eq!(std::fs::read(&points).unwrap(), marks);

    let still = desk.path("still");
    std::fs::create_dir(&still).unwrap();
    for frame in 0..3 {
        RgbImage::from_pixel(64, 48, Rgb([90, 120, 60]))
            .save(Path::new(&still).join(format!("{frame:05}.png")))
            .unwrap();
    }
    let refused = fails(&["points", &still, "-o", &points], 3);
    assert!(refused.contains("nothing is seen to move in it"), "{refused}");
}
