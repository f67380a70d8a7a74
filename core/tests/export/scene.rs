//! A clip made by hand: a bright bar with one leg walks over a dark ground, and everything about it is known.

use std::path::Path;

use glam::{Vec2, vec2};
use image::{Rgb, RgbImage};
use marey::clip::Clip;
use marey::motion::{Motion, Track, TrackFrame, TrackKind};
use marey::raster::Mask;
use marey::rig::{KeyFrame, Limb, Rig, Side, Stroke};

pub(crate) const SIZE: (u32, u32) = (160, 120);
const BODY_RADIUS: f32 = 14.0;
const LEG_RADIUS: f32 = 6.0;

pub(crate) struct Scene {
    folder: tempfile::TempDir,
    pub(crate) rig: Rig,
    pub(crate) motion: Motion,
    pub(crate) masks: Vec<Mask>,
}

impl Scene {
    /// `frames` frames at the 24 a second that folders of images have.
    pub(crate) fn new(frames: usize) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let limb = |label: &str, side| Limb { label: label.into(), side: Some(side) };
        let stroke = |limb: usize, points: Vec<Vec2>| Stroke { limb, points, facing: None };
        let strokes = (0..2).map(|l| stroke(l, place(l, 0))).collect();
        let rig = Rig {
            size: SIZE,
            limbs: vec![limb("body", Side::Mid), limb("leg_far", Side::Far)],
            keyframes: vec![KeyFrame { frame: 0, strokes, ..KeyFrame::default() }],
        };
        let track = |l: usize, name: &str| {
            let at = |f: usize| {
                let mut frame = TrackFrame::certain(place(l, f));
                if f > 0 && l == 1 {
                    frame.visible[3] = false;
                    frame.confidence = vec![1.0 - 0.1 * f as f32; frame.points.len()];
                }
                frame
            };
            Track { name: name.into(), kind: TrackKind::Stroke, frames: (0..frames).map(at).collect() }
        };
        let motion = Motion {
            size: SIZE,
            fps: 24.0,
            frames,
            tracks: vec![track(0, "body"), track(1, "leg_far")],
            bones: vec![("body".into(), "leg_far".into())],
        };
        let masks: Vec<Mask> = (0..frames).map(mask).collect();
        for (f, mask) in masks.iter().enumerate() {
            let image = RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
                let noise = (x * 7 + y * 13 + (x * y) % 11) % 17;
                let inside = mask.get(x as usize, y as usize);
                if inside { Rgb([200 + noise as u8, 140, 90]) } else { Rgb([30, 50 + 2 * noise as u8, 60]) }
            });
            image.save(folder.path().join(format!("{f:05}.png"))).expect("written");
        }
        Self { folder, rig, motion, masks }
    }

    pub(crate) fn clip(&self) -> Clip {
        Clip::open(self.folder.path()).expect("a clip")
    }

    /// The folder of the clip's frames.
    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// A place for outputs that is removed with the scene.
    pub(crate) fn scratch(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join("out").join(name)
    }
}

/// Where limb `limb` is in frame `frame`.
fn place(limb: usize, frame: usize) -> Vec<Vec2> {
    let shift = 2.0 * frame as f32;
    let swing = 0.3 * (frame as f32 * 0.8).sin();
    (0..6)
        .map(|i| match limb {
            0 => vec2(40.0 + shift + 10.0 * i as f32, 45.0),
            _ => vec2(40.0 + shift, 45.0) + Vec2::from_angle(1.5 + swing) * (11.0 * i as f32),
        })
        .collect()
}

fn mask(frame: usize) -> Mask {
    let (body, leg) = (place(0, frame), place(1, frame));
    let near = |p: Vec2, a: Vec2, b: Vec2, radius: f32| {
        let share = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a + (b - a) * share) < radius
    };
    Mask::from_fn(SIZE.0 as usize, SIZE.1 as usize, |x, y| {
        let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
        near(p, body[0], body[5], BODY_RADIUS) || near(p, leg[0], leg[5], LEG_RADIUS)
    })
}

/// All names below `folder`, relative to it, in order; none when there is no such folder.
pub(crate) fn listing(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    let mut waiting = vec![folder.to_owned()];
    while let Some(at) = waiting.pop() {
        for entry in std::fs::read_dir(&at).into_iter().flatten() {
            let path = entry.expect("an entry").path();
            names.push(path.strip_prefix(folder).expect("below").to_string_lossy().into_owned());
            if path.is_dir() {
                waiting.push(path);
            }
        }
    }
    names.sort();
    names
}
