//! A creature of a few frames, and how the command line is called.

use std::path::Path;
use std::process::{Command, Output};

const STROKES: &str = r#"{"format":"marey-strokes","version":1,"size":[96,64],"limbs":[{"label":"body"}],
    "keyframes":[{"frame":0,"strokes":[{"limb":"body","points":[[33,32],[57,32]]}]}]}"#;

pub(crate) fn marey(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_marey")).current_dir(folder).args(args).output().unwrap()
}

pub(crate) fn fails(folder: &Path, args: &[&str], exit_code: i32) -> String {
    let output = marey(folder, args);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(exit_code), "{args:?}: {said}");
    assert!(output.stdout.is_empty(), "{args:?}: a failure leaves stdout to reports");
    said
}

/// A creature of a dark bar that wanders over light ground for six frames.
pub(crate) fn bar(folder: &Path) {
    std::fs::create_dir(folder.join("clip")).unwrap();
    for frame in 0..6 {
        let at = 30 + 2 * frame;
        let image = image::RgbImage::from_fn(96, 64, |x, y| {
            let bar = x >= at && x < at + 30 && (26..38).contains(&y);
            let grain = ((x * 37 + y * 91) % 17) as u8;
            if bar { image::Rgb([60 + grain, 40, 30]) } else { image::Rgb([190, 200 - grain, 180 + grain]) }
        });
        image.save(folder.join(format!("clip/{frame:05}.png"))).unwrap();
    }
    std::fs::write(folder.join("strokes.json"), STROKES).unwrap();
    let made = marey(folder, &["creature", "clip", "--strokes", "strokes.json", "-o", "bar"]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
}
