//! A host for an author's own tests: a clip that a function paints, strokes, and a record of what the plugin gives.
//!
//! ```
//! use marey_plugin::testing::Scene;
//! use marey_plugin::Point;
//!
//! // A bright square that moves right by two pixels a frame.
//! let mut scene = Scene::new(64, 48, 8, |frame, x, y| {
//!     if (10 + 2 * frame..20 + 2 * frame).contains(&x) && (20..30).contains(&y) { [255; 3] } else { [40; 3] }
//! });
//! let limb = scene.limb("square", 5);
//! scene.stroke(limb, 0, Point::new(10.0, 25.0), Point::new(20.0, 25.0));
//! ```

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::clip::Clip;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::masks::{Mask, MaskSink};
use crate::mesh::{Handle, Mesh};
use crate::motion::{Motion, Track};
use crate::point::Point;
use crate::raw;
use crate::rig::{Limb, Rig, Stroke};
use crate::room::{self, Host};
use crate::tracks::{LimbTrack, Tracks};
use crate::traits::{Deformation, Deformer, Segmenter, Tracker};

struct Drawn {
    limb: usize,
    frame: usize,
    points: Vec<Point>,
}

/// A clip with what a user drew on it.
pub struct Scene {
    width: usize,
    height: usize,
    frames: Vec<Vec<u8>>,
    limbs: Vec<(String, usize)>,
    strokes: Vec<Drawn>,
    /// After how many looks at progress the host asks to stop.
    cancel_after: usize,
}

/// A host that records. Behind a lock, because a plugin's threads may share it.
struct Record<'a> {
    scene: &'a Scene,
    asked: AtomicUsize,
    tracks: Mutex<Tracks>,
    masks: Mutex<Vec<Option<Mask>>>,
}

impl Host for Record<'_> {
    fn progress(&self, _fraction: f64, _stage: Option<&str>) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) < self.scene.cancel_after
    }

    fn frame(&self, index: u64) -> Result<raw::Frame> {
        let pixels = usize::try_from(index).ok().and_then(|i| self.scene.frames.get(i));
        let pixels = pixels.ok_or_else(|| Error::invalid(format!("there is no frame {index}")))?;
        Ok(raw::Frame {
            struct_size: size_of::<raw::Frame>() as u32,
            width: self.scene.width as u32,
            height: self.scene.height as u32,
            stride_bytes: 3 * self.scene.width as u32,
            pixels: pixels.as_ptr(),
            token: std::ptr::null_mut(),
        })
    }

    fn release(&self, _frame: &mut raw::Frame) {}

    fn put_stroke(&self, limb: u32, frame: u64, points: &[Point], visible: &[u8], confidence: &[f32]) -> Result<()> {
        let mut tracks = self.tracks.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let (limb, frame) = (limb as usize, frame as usize);
        let (label, expected) = self.scene.limbs.get(limb).ok_or_else(|| Error::invalid("there is no such limb"))?;
        if points.len() != *expected || points.iter().any(|p| !p.is_finite()) {
            let message =
                format!("limb `{label}` on frame {frame}: {} points, or one that is not finite", points.len());
            return Err(Error::invalid(message));
        }
        let seen: Vec<bool> = visible.iter().map(|v| *v != 0).collect();
        tracks.set(limb, frame, points);
        tracks.set_visible(limb, frame, &seen);
        tracks.set_confidence(limb, frame, confidence);
        Ok(())
    }

    fn put_mask(&self, frame: u64, pixels: &[u8], width: u32, height: u32, _stride: usize) -> Result<()> {
        let mut masks = self.masks.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let place =
            masks.get_mut(frame as usize).ok_or_else(|| Error::invalid(format!("there is no frame {frame}")))?;
        if (width as usize, height as usize) != (self.scene.width, self.scene.height) {
            return Err(Error::invalid(format!("the mask of frame {frame} is {width}x{height}")));
        }
        *place = Some(Mask { width: width as usize, height: height as usize, pixels: pixels.to_vec() });
        Ok(())
    }
}

impl Scene {
    /// A clip of `frames` frames, with `paint(frame, x, y)` the colour of each pixel.
    pub fn new(width: usize, height: usize, frames: usize, paint: impl Fn(usize, usize, usize) -> [u8; 3]) -> Self {
        let frame = |f| (0..width * height).flat_map(|i| paint(f, i % width, i / width)).collect();
        let frames = (0..frames).map(frame).collect();
        Self { width, height, frames, limbs: Vec::new(), strokes: Vec::new(), cancel_after: usize::MAX }
    }

    /// Adds a limb of `points` points; gives its index.
    pub fn limb(&mut self, label: &str, points: usize) -> usize {
        self.limbs.push((label.to_owned(), points));
        self.limbs.len() - 1
    }

    /// Draws a limb as a straight line on a frame.
    pub fn stroke(&mut self, limb: usize, frame: usize, from: Point, to: Point) {
        let count = self.limbs.get(limb).map_or(2, |l| l.1);
        let points = (0..count).map(|i| from.lerp(to, i as f32 / (count.max(2) - 1) as f32)).collect();
        let at = self.strokes.partition_point(|s| (s.frame, s.limb) < (frame, limb));
        self.strokes.insert(at, Drawn { limb, frame, points });
    }

    /// Lets the host ask the plugin to stop after it looked `looks` times at progress.
    pub fn cancel_after(&mut self, looks: usize) {
        self.cancel_after = looks;
    }

    fn rig(&self) -> Rig<'_> {
        let limbs = self.limbs.iter().map(|(label, points)| Limb {
            label,
            side: None,
            parent: None,
            points: *points,
            rooted_at_start: true,
            terminal: true,
        });
        let strokes = self.strokes.iter();
        let strokes = strokes.map(|s| Stroke { limb: s.limb, frame: s.frame, points: &s.points, facing: None });
        Rig { limbs: limbs.collect(), strokes: strokes.collect(), ..Rig::default() }
    }

    fn record(&self) -> Record<'_> {
        let count = |points: usize| self.frames.len() * points;
        let limbs = self.limbs.iter().map(|(_, points)| LimbTrack {
            points: *points,
            places: vec![Point::default(); count(*points)],
            visible: vec![1; count(*points)],
            confidence: vec![1.0; count(*points)],
        });
        Record {
            scene: self,
            asked: AtomicUsize::new(0),
            tracks: Mutex::new(Tracks { limbs: limbs.collect() }),
            masks: Mutex::new(vec![None; self.frames.len()]),
        }
    }

    fn clip<'a>(&self, host: &'a dyn Host) -> Clip<'a> {
        Clip::new(host, (self.width as u32, self.height as u32), self.frames.len() as u64, 24.0)
    }

    /// Runs a tracker, and checks what it gives as a host does.
    ///
    /// # Errors
    /// Those of the tracker, and what a host refuses: too many points or too few, a place that is not finite.
    pub fn track(&self, tracker: &mut impl Tracker) -> Result<Tracks> {
        let record = self.record();
        let (clip, rig) = (self.clip(&record), self.rig());
        let tracks = tracker.track(&clip, &rig, &Job::new(&record))?;
        room::put(&tracks, &clip, &rig, &record)?;
        let mut kept = record.tracks.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        for s in &self.strokes {
            kept.set(s.limb, s.frame, &s.points);
        }
        Ok(kept)
    }

    /// Runs a segmenter on limbs that move evenly from one drawn stroke to the next, and checks what it gives.
    ///
    /// # Errors
    /// Those of the segmenter, and what a host refuses: a mask of another size, a frame without a mask.
    pub fn segment(&self, segmenter: &mut impl Segmenter) -> Result<Vec<Mask>> {
        let record = self.record();
        let (clip, rig) = (self.clip(&record), self.rig());
        let places: Vec<Vec<Point>> = (0..self.limbs.len()).map(|l| self.between(&rig, l)).collect();
        let ones: Vec<(Vec<u8>, Vec<f32>)> = places.iter().map(|p| (vec![1; p.len()], vec![1.0; p.len()])).collect();
        let tracks = self.limbs.iter().zip(&places).zip(&ones).map(|(((label, points), places), ones)| Track {
            label,
            points: *points,
            places,
            visible: &ones.0,
            confidence: &ones.1,
        });
        let motion = Motion { tracks: tracks.collect() };
        segmenter.segment(&clip, &rig, &motion, &MaskSink::new(&record), &Job::new(&record))?;
        let masks = record.masks.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        let whole = masks.into_iter().enumerate();
        whole.map(|(f, mask)| mask.ok_or_else(|| Error::invalid(format!("frame {f} has no mask")))).collect()
    }

    fn between(&self, rig: &Rig<'_>, limb: usize) -> Vec<Point> {
        let place = |frame| {
            let Some(a) = rig.last_stroke(limb, frame) else { return Vec::new() };
            let Some(b) = rig.next_stroke(limb, frame).filter(|b| b.frame > a.frame) else { return a.points.to_vec() };
            let t = frame.saturating_sub(a.frame) as f32 / (b.frame - a.frame) as f32;
            a.points.iter().zip(b.points).map(|(p, q)| p.lerp(*q, t)).collect()
        };
        (0..self.frames.len()).flat_map(place).collect()
    }

    /// Runs a deformer once, from the mesh at rest.
    ///
    /// # Errors
    /// Those of the deformer, and a place that is not finite.
    pub fn deform(
        deformer: &mut impl Deformer,
        mesh: &Mesh<'_>,
        rest: &[Handle],
        targets: &[Handle],
    ) -> Result<Vec<Point>> {
        let scene = Self::new(1, 1, 1, |_, _, _| [0; 3]);
        let record = scene.record();
        let mut points = mesh.points.to_vec();
        deformer.bind(mesh, rest, &Job::new(&record))?.solve(targets, &mut points, &Job::new(&record))?;
        match points.iter().position(|p| !p.is_finite()) {
            Some(i) => Err(Error::invalid(format!("point {i} is not finite"))),
            None => Ok(points),
        }
    }
}
