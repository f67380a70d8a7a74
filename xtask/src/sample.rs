//! A clip that every step of the engine gets through in a moment, for programs that are watched while they run: a dark
//! creature of a body and two legs that walks over light, uneven ground, and the strokes on its first frame.

use std::path::{Path, PathBuf};

use anyhow::Result;

const SIZE: (u16, u16) = (96, 64);
const FRAMES: u16 = 8;

const STROKES: &str = r#"{"format": "marey-strokes", "version": 1, "size": [96, 64],
 "limbs": [{"label": "body"}, {"label": "hind"}, {"label": "fore"}],
 "keyframes": [{"frame": 0, "strokes": [
   {"limb": "body", "points": [[22, 26], [38, 26], [54, 26]]},
   {"limb": "hind", "points": [[22, 26], [24, 40], [26, 54]]},
   {"limb": "fore", "points": [[54, 26], [52, 40], [50, 54]]}]}]}
"#;

/// A clip and the strokes drawn on it.
pub(crate) struct Sample {
    pub(crate) clip: PathBuf,
    pub(crate) strokes: PathBuf,
}

/// Writes the clip and the strokes into `folder`.
pub(crate) fn write(folder: &Path) -> Result<Sample> {
    std::fs::create_dir_all(folder)?;
    let sample = Sample { clip: folder.join("clip.gif"), strokes: folder.join("strokes.json") };
    std::fs::write(&sample.strokes, STROKES)?;
    // 0..64 the ground from dark to light, 64..80 the creature.
    let palette: Vec<u8> = (0..64u8)
        .flat_map(|i| [150 + i, 160 + i, 140 + i])
        .chain((0..16).flat_map(|i| [50 + 2 * i, 30 + i, 20 + i]))
        .collect();
    let mut gif = gif::Encoder::new(std::fs::File::create(&sample.clip)?, SIZE.0, SIZE.1, &palette)?;
    for frame in 0..FRAMES {
        let pixels = (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| pixel(x.into(), y.into(), frame.into())));
        let picture = gif::Frame {
            delay: 5,
            ..gif::Frame::from_indexed_pixels(SIZE.0, SIZE.1, pixels.collect::<Vec<_>>(), None)
        };
        gif.write_frame(&picture)?;
    }
    Ok(sample)
}

/// The colour of a pixel. The creature goes right, its legs swing against each other.
fn pixel(x: i32, y: i32, frame: i32) -> u8 {
    let left = 18 + 2 * frame;
    let swing = (frame - 4).abs() - 4;
    let leg = |top_x: i32, swing: i32| {
        let centre = top_x + swing * (y - 26) / 28;
        (26..56).contains(&y) && (x - centre).abs() <= 3
    };
    let body = (left..left + 40).contains(&x) && (20..33).contains(&y);
    if body || leg(left + 4, 4 + swing) || leg(left + 36, -4 - swing) {
        64 + ((x * 5 + y * 3 - 10 * frame).rem_euclid(16)) as u8
    } else {
        ((x * x * 7 + y * y * 5 + x * y * 3) % 64) as u8
    }
}
