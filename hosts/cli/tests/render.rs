//! `marey render` as a user meets it.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{bar, fails_in, marey_in};
use serde_json::Value;

#[test]
fn creatures_are_drawn_from_any_side_into_any_format() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    let cases: [(&[&str], u64, (u32, u32)); 6] = [
        (&["-o", "one.png", "--frame", "3", "--view", "-30,20", "--style", "shaded", "--shadow", "0.5"], 1, (96, 64)),
        (&["-o", "turn.gif", "--turntable", "--frame", "0", "--frames", "8", "--size", "60x40"], 8, (60, 40)),
        (&["-o", "all.webp", "--view", "90,0", "--fov", "0", "--background", "white"], 6, (96, 64)),
        (&["-o", "bones.png", "--style", "bones", "--turns", "-1"], 6, (96, 64)),
        (&["-o", "near.png", "--frame", "0", "--target", "48,32,0", "--distance", "40"], 1, (96, 64)),
        (&["-o", "frames", "--hard-edges", "--fps", "12"], 6, (96, 64)),
    ];
    for (args, frames, size) in cases {
        let mut all = vec!["render", "bar", "--adapter", "cpu", "--json"];
        all.extend(args);
        let output = marey_in(folder, &all);
        assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((report["frames"].as_u64(), report["renderer"].as_str()), (Some(frames), Some("CPU")), "{args:?}");
        assert_eq!(
            (report["size"][0].as_u64(), report["size"][1].as_u64()),
            (Some(size.0.into()), Some(size.1.into()))
        );
        let path = folder.join(args[1]);
        let picture = if path.is_dir() { path.join("00000.png") } else { path };
        let picture = image::open(&picture).unwrap().to_rgba8();
        assert_eq!(picture.dimensions(), size, "{args:?}");
        let seen = picture.pixels().filter(|p| p.0[3] == 255 && p.0[0] < 150).count();
        assert!(seen > 50, "{args:?}: {seen} pixels of the creature");
    }
    // The clip's own view, which is the one without --view, lies on the clip.
    let over = image::open(folder.join("frames/00002.png")).unwrap().to_rgba8();
    let clip = image::open(folder.join("clip/00002.png")).unwrap().to_rgb8();
    let (mut inside, mut far) = (0, 0);
    for (x, y, p) in over.enumerate_pixels().filter(|p| p.2.0[3] == 255) {
        inside += 1;
        far += u32::from(clip.get_pixel(x, y).0[0].abs_diff(p.0[0]) > 50);
    }
    assert!(inside > 200 && far * 8 < inside, "{far} of {inside} pixels are not the clip's");
}

#[test]
fn what_cannot_be_drawn_is_said_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    let render = |args: &[&str], code: i32| {
        let mut all = vec!["render", "bar", "--adapter", "cpu"];
        all.extend(args);
        let said = fails_in(folder, &all, code);
        assert_eq!(said.lines().count(), 1, "{args:?}: {said}");
        said
    };
    assert!(render(&["-o", "a.gif", "--size", "big"], 2).contains("1280x720"));
    assert!(render(&["-o", "a.gif", "--size", "0x9"], 2).contains("0x9"));
    assert!(render(&["-o", "a.gif", "--view", "left"], 2).contains("YAW,PITCH"));
    assert!(render(&["-o", "a.gif", "--view", "nan,0"], 2).contains("nan"));
    assert!(render(&["-o", "a.gif", "--style", "cubist"], 2).contains("wireframe"));
    assert!(render(&["-o", "a.gif", "--background", "mud"], 2).contains("mud"));
    assert!(render(&["-o", "a.gif", "--frame", "6"], 2).contains('6'));
    assert!(render(&["-o", "a.gif", "--shadow", "7"], 3).contains("shadow"));
    assert!(render(&["-o", "a.bmp"], 3).contains("bmp"));
    assert!(render(&["-o", "no/a.gif"], 3).contains("no"));
    assert!(fails_in(folder, &["render", "nobody", "-o", "a.gif"], 3).contains("nobody"));
    assert!(!folder.join("a.gif").exists());
}
