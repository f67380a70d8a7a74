//! Lottie as a sequence of pictures: a PNG inside the JSON for each frame that differs from the one before, cut to what it
//! shows, and an image layer for the time it is shown.
//!
//! Lottie has no mesh deformation, and players agree on pictures: every one of them shows exactly these frames. The other
//! way, patches of the drawing as image layers that move by affine maps, was measured and lost: key poses of two seconds
//! fell into 1468 patches for half a pixel, and where depths change into 5872 layers, 11 MB beside 15 MB of pictures, off by
//! 2.1 of 255 at the patches' seams; captured motion into more than players can draw.
//!
//! The file is as large as the frames' PNGs and a third; a smaller scale makes it smaller, by its square. What players can
//! hold in memory, an uncompressed bitmap a frame, is the format's limit, and takes beyond it are refused.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use image::RgbaImage;
use serde_json::{Value, json};

use super::{check, json_bytes, number, plain_name};
use crate::error::{Error, Result};
use crate::export::take::{TakeFiles, TakeOptions, TakeSubject};
use crate::export::{png, write_aside};
use crate::job::Stage;

/// Pixels that all pictures together may have: a gigabyte of bitmaps.
const MOST_PIXELS: u64 = 1 << 28;

/// Draws a frame; all frames have one size.
pub type Draw<'a> = dyn FnMut(usize) -> Result<RgbaImage> + 'a;

/// Writes `path`. `draw` gives the frames, which show `shown` (left, top, width and height in pixels of the character's
/// picture).
///
/// # Errors
/// As for [`crate::export::take::write_take`].
pub fn write(
    path: &Path,
    subject: TakeSubject<'_>,
    options: &TakeOptions,
    shown: [i32; 4],
    draw: &mut Draw<'_>,
    stage: Stage<'_>,
) -> Result<TakeFiles> {
    check(subject, options)?;
    let frames = subject.take.frames.len();
    let (mut assets, mut layers): (Vec<Value>, Vec<Value>) = (Vec::new(), Vec::new());
    let mut size = (0, 0);
    let mut pixels = 0;
    let mut last: Option<RgbaImage> = None;
    let still = |of: Value| json!({ "a": 0, "k": of });
    stage.name("pictures")?;
    for frame in 0..frames {
        stage.at(frame as f64 / frames as f64)?;
        let picture = draw(frame)?;
        size = picture.dimensions();
        if last.as_ref() == Some(&picture) {
            if let Some(layer) = layers.last_mut() {
                layer["op"] = (frame + 1).into();
            }
            continue;
        }
        let [left, top, width, height] = visible(&picture);
        let cut = image::imageops::crop_imm(&picture, left, top, width, height).to_image();
        pixels += u64::from(width) * u64::from(height);
        if pixels > MOST_PIXELS {
            return Err(Error::Limit {
                what: "how many pixels Lottie players must hold".into(),
                value: pixels,
                max: MOST_PIXELS,
                remedy: "give a smaller scale, take fewer frames, or write a video or an animated picture".into(),
            });
        }
        let id = format!("frame{frame}");
        let data = format!("data:image/png;base64,{}", BASE64.encode(png::encode_rgba(&cut)?));
        assets.push(json!({ "id": id, "w": width, "h": height, "u": "", "p": data, "e": 1 }));
        layers.push(json!({
            "ty": 2, "ind": layers.len() + 1, "nm": id, "refId": id, "ip": frame, "op": frame + 1, "st": 0, "sr": 1,
            "ddd": 0, "bm": 0,
            "ks": {
                "o": still(100.into()), "r": still(0.into()), "p": still(json!([left, top, 0])),
                "a": still(json!([0, 0, 0])), "s": still(json!([100, 100, 100])),
            },
        }));
        last = Some(picture);
    }
    let scene = json!({
        "v": "5.7.0", "fr": number(subject.take.fps, 4), "ip": 0, "op": frames, "w": size.0, "h": size.1,
        "nm": plain_name(subject.name), "ddd": 0, "assets": assets, "layers": layers,
    });
    write_aside(path, &json_bytes(&scene)?)?;
    Ok(TakeFiles { files: vec![path.to_owned()], shown, frames })
}

/// Left, top, width and height of what is not clear; a pixel where everything is.
fn visible(picture: &RgbaImage) -> [u32; 4] {
    let shown = picture.enumerate_pixels().filter(|p| p.2.0[3] > 0);
    let bounds =
        shown.fold([u32::MAX, u32::MAX, 0, 0], |[l, t, r, b], (x, y, _)| [l.min(x), t.min(y), r.max(x), b.max(y)]);
    let [left, top, right, bottom] = bounds;
    if left > right { [0, 0, 1, 1] } else { [left, top, right - left + 1, bottom - top + 1] }
}
