//! Sprite sheets: all frames on as few pictures as they need, trimmed, with a JSON file beside each picture in the layout
//! that Aseprite and TexturePacker write ("JSON hash") and that game engines read.
//!
//! Frames are packed on shelves, the tallest first; equal ones share a place. They are drawn twice, so that only one
//! sheet is held in memory. Where one does not hold them all there are several, numbered from 0, which name each other.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};

use image::{RgbaImage, imageops};
use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::{Animation, CHUNK, Rect, milliseconds};
use crate::error::{Error, Result};
use crate::export::png::encode_rgba;
use crate::export::write_aside::Aside;
use crate::job::Stage;

/// Pixels a side: what graphics hardware of the last ten years can hold.
const LONGEST: u32 = 8192;
/// Clear pixels between frames, so that none shows in its neighbour's rim.
const GAP: u32 = 2;

/// Where a frame goes.
#[derive(Clone, Copy, Debug)]
struct Place {
    sheet: usize,
    /// On the sheet.
    x: u32,
    y: u32,
    /// The part of the frame that is not clear.
    trimmed: Rect,
    /// The first frame that looks the same.
    like: usize,
}

pub(super) fn write(path: &Path, animation: &Animation<'_>, stage: Stage<'_>) -> Result<Vec<PathBuf>> {
    let (places, sizes) = arrange(animation, stage.part(0.0, 0.45))?;
    let stem = match path.extension().and_then(|e| e.to_str()) {
        Some("png" | "json") => path.with_extension(""),
        _ => path.to_owned(),
    };
    let named = |sheet: usize, ending: &str| {
        let mut name = stem.file_name().unwrap_or_default().to_owned();
        name.push(if sizes.len() == 1 { format!(".{ending}") } else { format!("-{sheet}.{ending}") });
        stem.with_file_name(name)
    };
    let mut files = Vec::new();
    for (sheet, &size) in sizes.iter().enumerate() {
        let share = |i: usize| 0.45 + 0.55 * i as f64 / sizes.len() as f64;
        let stage = stage.part(share(sheet), share(sheet + 1));
        let mut picture = Aside::begin(named(sheet, "png"))?;
        picture.write(&encode_rgba(&fill(animation, &places, sheet, size, stage)?)?)?;
        let mut index = Aside::begin(named(sheet, "json"))?;
        let text = serde_json::to_string_pretty(&describe(animation, &places, sheet, size, &named, sizes.len()));
        index.write(text.unwrap_or_default().as_bytes())?;
        files.extend([picture, index]);
    }
    stage.at(1.0)?;
    files.into_iter().map(Aside::commit).collect()
}

/// Width and height of each sheet.
type Sizes = Vec<(u32, u32)>;

/// Where each frame goes, and how large the sheets are.
fn arrange(animation: &Animation<'_>, stage: Stage<'_>) -> Result<(Vec<Place>, Sizes)> {
    let mut places: Vec<Place> = Vec::with_capacity(animation.frames);
    let mut seen: HashMap<(u32, u32, u64), usize> = HashMap::new();
    let pack = |_: usize, _: Option<&_>, now: &RgbaImage| {
        let trimmed = Rect::around(now.dimensions(), |i| now.as_raw()[4 * i + 3] > 0).unwrap_or(Rect::ONE);
        let mut look = DefaultHasher::new();
        look.write(trimmed.cut(now).as_raw());
        Ok((trimmed, look.finish()))
    };
    animation.each(stage, pack, |frame, (trimmed, look)| {
        let Rect { width, height, .. } = trimmed;
        if width.max(height) > LONGEST {
            return Err(Error::Limit {
                what: format!("the longer side of frame {frame} on a sprite sheet"),
                value: width.max(height).into(),
                max: LONGEST.into(),
                remedy: "scale it down".into(),
            });
        }
        let like = *seen.entry((width, height, look)).or_insert(frame);
        places.push(Place { sheet: 0, x: 0, y: 0, trimmed, like });
        Ok(())
    })?;
    let mut order: Vec<usize> = (0..places.len()).filter(|&i| places[i].like == i).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(places[i].trimmed.height));
    let room = |i: &usize| u64::from(places[*i].trimmed.width + GAP) * u64::from(places[*i].trimmed.height + GAP);
    let side = (order.iter().map(room).sum::<u64>() as f64).sqrt() as u32;
    let widest = order.iter().map(|&i| places[i].trimmed.width).max().unwrap_or(1);
    let across = side.max(widest).next_power_of_two().min(LONGEST);
    let mut sizes = vec![(0, 0)];
    let (mut x, mut y, mut shelf) = (0, 0, 0);
    for i in order {
        let Rect { width, height, .. } = places[i].trimmed;
        if x + width > across {
            (x, y, shelf) = (0, y + shelf + GAP, 0);
        }
        if y + height > LONGEST {
            sizes.push((0, 0));
            (x, y, shelf) = (0, 0, 0);
        }
        let sheet = sizes.len() - 1;
        (places[i].sheet, places[i].x, places[i].y) = (sheet, x, y);
        sizes[sheet] = (sizes[sheet].0.max(x + width), sizes[sheet].1.max(y + height));
        x += width + GAP;
        shelf = shelf.max(height);
    }
    for i in 0..places.len() {
        let first = places[places[i].like];
        (places[i].sheet, places[i].x, places[i].y) = (first.sheet, first.x, first.y);
    }
    Ok((places, sizes))
}

/// The picture of a sheet.
fn fill(
    animation: &Animation<'_>,
    places: &[Place],
    sheet: usize,
    (width, height): (u32, u32),
    stage: Stage<'_>,
) -> Result<RgbaImage> {
    let mut out = RgbaImage::new(width, height);
    let on_it: Vec<usize> = (0..places.len()).filter(|&i| places[i].sheet == sheet && places[i].like == i).collect();
    for (done, some) in on_it.chunks(CHUNK).enumerate() {
        let at = (done * CHUNK) as f64 / on_it.len() as f64;
        let drawn = some.par_iter().map(|&frame| {
            stage.at(at)?;
            Ok(places[frame].trimmed.cut(&animation.draw(frame)?))
        });
        let drawn: Vec<RgbaImage> = drawn.collect::<Result<_>>()?;
        for (&frame, picture) in some.iter().zip(&drawn) {
            imageops::replace(&mut out, picture, places[frame].x.into(), places[frame].y.into());
        }
    }
    Ok(out)
}

fn describe(
    animation: &Animation<'_>,
    places: &[Place],
    sheet: usize,
    (width, height): (u32, u32),
    named: &dyn Fn(usize, &str) -> PathBuf,
    sheets: usize,
) -> Value {
    let rect = |x: u32, y: u32, r: Rect| json!({ "x": x, "y": y, "w": r.width, "h": r.height });
    let mut frames = Map::new();
    for (i, place) in places.iter().enumerate().filter(|(_, p)| p.sheet == sheet) {
        let trimmed = place.trimmed;
        let entry = json!({
            "frame": rect(place.x, place.y, trimmed),
            "rotated": false,
            "trimmed": (trimmed.width, trimmed.height) != animation.size,
            "spriteSourceSize": rect(trimmed.x, trimmed.y, trimmed),
            "sourceSize": { "w": animation.size.0, "h": animation.size.1 },
            "pivot": { "x": animation.pivot[0], "y": animation.pivot[1] },
            "duration": milliseconds(i, animation.fps),
        });
        // Readers sort the frames by their names.
        frames.insert(format!("{} {i:05}", animation.name), entry);
    }
    let file_name = |path: PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let others: Vec<String> = (0..sheets).filter(|&s| s != sheet).map(|s| file_name(named(s, "json"))).collect();
    let mut meta = json!({
        "app": "marey",
        "version": env!("CARGO_PKG_VERSION"),
        "image": file_name(named(sheet, "png")),
        "format": "RGBA8888",
        "size": { "w": width, "h": height },
        "scale": "1",
        "frameTags": [{ "name": animation.name, "from": 0, "to": places.len() - 1, "direction": "forward" }],
    });
    if !others.is_empty() {
        meta["related_multi_packs"] = json!(others);
    }
    json!({ "frames": frames, "meta": meta })
}
