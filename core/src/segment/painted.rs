//! What the user painted on key frames: whole masks, and strokes of creature and background over them.
//!
//! Painted pixels are kept exactly in their frame, teach colours to all frames, and count for more when masks are
//! carried to neighbouring frames.

use std::collections::BTreeMap;

use glam::{Vec2, vec2};

use crate::error::{Error, Result};
use crate::raster::{Grid, Mask};
use crate::rig::{KeyFrame, Paint, Rig};

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Known {
    #[default]
    Nothing,
    Background,
    Creature,
}

/// The painted pixels of every key frame that has any, in the clip's size.
#[derive(Default)]
pub(super) struct Painted {
    frames: BTreeMap<usize, Grid<Known>>,
}

impl Painted {
    /// Reads painted masks and draws painted strokes.
    pub(super) fn read(rig: &Rig) -> Result<Self> {
        let mut frames = BTreeMap::new();
        for key in rig.keyframes.iter().filter(|k| k.mask.is_some() || !k.paint.is_empty()) {
            frames.insert(key.frame, paint(rig.size, key)?);
        }
        Ok(Self { frames })
    }

    /// Puts what is known of `frame` into its mask.
    pub(super) fn apply(&self, frame: usize, mask: &mut Mask) {
        let Some(known) = self.frames.get(&frame) else { return };
        for y in 0..mask.height().min(known.height()) {
            for x in 0..mask.width().min(known.width()) {
                match known.get(x, y) {
                    Known::Nothing => {}
                    what => mask.set(x, y, what == Known::Creature),
                }
            }
        }
    }

    /// What is known at a smaller size, for each frame with anything: of the known pixels that a small one covers,
    /// the majority.
    pub(super) fn reduced(&self, width: usize, height: usize) -> BTreeMap<usize, Grid<Known>> {
        self.frames.iter().map(|(&frame, known)| (frame, reduce(known, width, height))).collect()
    }
}

pub(super) fn reduce(known: &Grid<Known>, width: usize, height: usize) -> Grid<Known> {
    let mut votes = Grid::new(width, height, (0u32, 0u32));
    for y in 0..known.height() {
        let to = y * height / known.height();
        for x in 0..known.width() {
            let at = x * width / known.width();
            let (creature, background) = votes.get(at, to);
            match known.get(x, y) {
                Known::Nothing => {}
                Known::Creature => votes.set(at, to, (creature + 1, background)),
                Known::Background => votes.set(at, to, (creature, background + 1)),
            }
        }
    }
    let decided = votes.data().iter().map(|&(creature, background)| match creature + background {
        0 => Known::Nothing,
        _ if creature > background => Known::Creature,
        _ => Known::Background,
    });
    Grid::from_vec(width, height, decided.collect())
}

fn paint(size: (u32, u32), key: &KeyFrame) -> Result<Grid<Known>> {
    let (width, height) = (size.0 as usize, size.1 as usize);
    let mut known = Grid::new(width, height, Known::Nothing);
    if let Some(path) = &key.mask {
        let bad = |problem: String| {
            Error::file(path, problem, format!("expected an 8-bit image of {width}x{height}, white on the creature"))
        };
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
        let reader = image::ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format();
        let reader = reader.map_err(|e| Error::io(path, "read", e))?;
        let found = reader.into_dimensions().map_err(|e| bad(format!("the painted mask is not readable: {e}")))?;
        if found != size {
            return Err(bad(format!("the painted mask is {}x{}", found.0, found.1)));
        }
        let image = image::open(path).map_err(|e| bad(format!("the painted mask is not readable: {e}")))?;
        let mask = Mask::from_image(&image.to_luma8());
        for y in 0..height {
            for x in 0..width {
                known.set(x, y, if mask.get(x, y) { Known::Creature } else { Known::Background });
            }
        }
    }
    brush_over(&mut known, &key.paint);
    Ok(known)
}

/// Paints strokes over what is known, each over those before it.
pub(super) fn brush_over(known: &mut Grid<Known>, strokes: &[Paint]) {
    for stroke in strokes {
        let what = if stroke.foreground { Known::Creature } else { Known::Background };
        let last = stroke.points.last().copied();
        for pair in stroke.points.windows(2) {
            brush(known, pair[0], pair[1], stroke.radius, what);
        }
        if let (1, Some(dot)) = (stroke.points.len(), last) {
            brush(known, dot, dot, stroke.radius, what);
        }
    }
}

/// Paints every pixel whose centre is within `radius` of the segment.
fn brush(known: &mut Grid<Known>, from: Vec2, to: Vec2, radius: f32, what: Known) {
    let (low, high) = (from.min(to) - radius, from.max(to) + radius);
    let size = vec2(known.width() as f32, known.height() as f32);
    let (low, high) = (low.clamp(Vec2::ZERO, size), high.clamp(Vec2::ZERO, size));
    let along = to - from;
    for y in low.y.floor() as usize..(high.y.ceil() as usize).min(known.height()) {
        for x in low.x.floor() as usize..(high.x.ceil() as usize).min(known.width()) {
            let centre = vec2(x as f32 + 0.5, y as f32 + 0.5);
            let t = if along.length_squared() > 0.0 {
                ((centre - from).dot(along) / along.length_squared()).clamp(0.0, 1.0)
            } else {
                0.0
            };
            if centre.distance(from + along * t) <= radius {
                known.set(x, y, what);
            }
        }
    }
}
