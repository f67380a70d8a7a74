//! A drawing or a character in motion: its frames as textures, drawn by the library on a thread of their own, the shown
//! one first and those that play next ahead of time. The window shows the last frame it has until the next is there.

use std::collections::HashMap;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use eframe::egui::{ColorImage, Context, Rect, TextureHandle, TextureOptions, pos2, vec2};
use marey_binding::{Result, SketchTake, Take};

use crate::timing::Timing;

/// Memory for frames as textures.
const KEPT_BYTES: usize = 128 << 20;
/// Frames that are drawn ahead of the shown one.
const AHEAD: u64 = 8;

/// What the library made to move.
#[derive(Clone, Debug)]
pub(crate) enum Moving {
    Drawing(Arc<SketchTake>),
    Character(Arc<Take>),
}

impl Moving {
    /// How many frames there are, and how many a second.
    pub(crate) fn frames(&self) -> Result<(u64, f64)> {
        match self {
            Self::Drawing(take) => take.frames(),
            Self::Character(take) => take.frames(),
        }
    }

    /// Width and height in pixels of what pictures show, and where their left upper corner lies.
    pub(crate) fn measure(&self, scale: f32) -> Result<((u32, u32), (f32, f32))> {
        match self {
            Self::Drawing(take) => take.measure(scale, false),
            Self::Character(take) => take.measure(scale, false),
        }
    }

    /// A frame as it is in files.
    pub(crate) fn draw(&self, frame: u64, scale: f32) -> std::result::Result<ColorImage, String> {
        let drawn = match self {
            Self::Drawing(take) => take.draw(frame, scale, false),
            Self::Character(take) => take.draw(frame, scale, false),
        };
        let (width, height, rgba) = drawn.map_err(|e| e.to_string())?;
        Ok(ColorImage::from_rgba_unmultiplied([width as usize, height as usize], &rgba))
    }

    /// The same at another time.
    pub(crate) fn retimed(&self, timing: Timing) -> Result<Self> {
        let Some(how) = timing.options() else { return Ok(self.clone()) };
        Ok(match self {
            Self::Drawing(take) => Self::Drawing(Arc::new(take.retimed(&how)?)),
            Self::Character(take) => Self::Character(Arc::new(take.retimed(&how)?)),
        })
    }

    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Drawing(a), Self::Drawing(b)) => Arc::ptr_eq(a, b),
            (Self::Character(a), Self::Character(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

/// A motion of one frame, as the text of a motion.json: what stands still.
pub(crate) fn one_frame(points: &[(&str, (f32, f32))], size: (f32, f32)) -> String {
    let track = |(name, at): &(&str, (f32, f32))| {
        let frame = serde_json::json!({ "points": [at], "visible": [true], "confidence": [1.0] });
        serde_json::json!({ "name": name, "kind": "point", "frames": [frame] })
    };
    let side = |v: f32| v.ceil().max(1.0) as u32;
    let motion = serde_json::json!({
        "format": "marey-motion",
        "version": 1,
        "size": [side(size.0), side(size.1)],
        "fps": 24.0,
        "frames": 1,
        "tracks": points.iter().map(track).collect::<Vec<_>>(),
    });
    motion.to_string()
}

/// What is to be drawn.
#[derive(Debug, Default)]
struct Wanted {
    of: Option<(u64, Moving)>,
    frames: u64,
    frame: u64,
    scale: f32,
    /// Drawn, or not to be had.
    held: Vec<u64>,
    closed: bool,
}

type Shared = (Mutex<Wanted>, Condvar);
/// Of which, the frame, and its picture.
type Drawn = (u64, u64, std::result::Result<ColorImage, String>);

/// Textures of what moves.
pub(crate) struct MovingPictures {
    shared: Arc<Shared>,
    drawn: Receiver<Drawn>,
    /// Counts what was shown: pictures of what was there before are dropped.
    number: u64,
    moving: Option<Moving>,
    scale: f32,
    pictures: HashMap<u64, TextureHandle>,
    shown: Option<TextureHandle>,
    most: usize,
    /// What pictures show, in pixels of the drawing.
    pub(crate) area: Rect,
    pub(crate) failed: Option<String>,
    /// How many pictures were drawn.
    pub(crate) count: u64,
}

impl MovingPictures {
    pub(crate) fn new(ui: &Context) -> Self {
        let shared = Arc::new(Shared::default());
        let (send, drawn) = channel();
        let (worker, ui) = (shared.clone(), ui.clone());
        std::thread::spawn(move || draw(&worker, &send, &ui));
        Self {
            shared,
            drawn,
            number: 0,
            moving: None,
            scale: 0.0,
            pictures: HashMap::new(),
            shown: None,
            most: 1,
            area: Rect::ZERO,
            failed: None,
            count: 0,
        }
    }

    /// Takes in what was drawn, and asks for `frame` at so many pixels a pixel of the drawing.
    pub(crate) fn update(&mut self, ui: &Context, moving: &Moving, frame: u64, scale: f32) {
        // Sizes in steps of a quarter, so that a panel that is drawn wider does not have all drawn anew at each point.
        let scale = 2.0_f32.powf((scale.clamp(0.05, 8.0).log2() * 2.0).ceil() / 2.0);
        let other = self.moving.as_ref().is_none_or(|m| !m.is(moving));
        if other || self.scale != scale {
            self.renew(moving, scale);
        }
        for (number, at, picture) in self.drawn.try_iter() {
            if number != self.number {
                continue;
            }
            match picture {
                Ok(picture) => {
                    let texture = ui.load_texture(format!("moving {at}"), picture, TextureOptions::LINEAR);
                    self.pictures.insert(at, texture);
                    self.count += 1;
                }
                Err(message) => self.failed = Some(message),
            }
        }
        let mut wanted = lock(&self.shared.0);
        // The frame itself, or the last one before it that is drawn: drawing may be slower than time.
        let frames = wanted.frames.max(1);
        let behind = |at: &u64| (frame + frames - at % frames) % frames;
        if let Some((_, picture)) = self.pictures.iter().min_by_key(|(at, _)| behind(at)) {
            self.shown = Some(picture.clone());
        }
        while self.pictures.len() > self.most {
            // The one that is shown last from here on.
            let ahead = |at: &u64| (at + wanted.frames - frame % wanted.frames.max(1)) % wanted.frames.max(1);
            let Some(farthest) = self.pictures.keys().copied().max_by_key(ahead) else { break };
            self.pictures.remove(&farthest);
            wanted.held.retain(|at| *at != farthest);
        }
        wanted.frame = frame;
        drop(wanted);
        self.shared.1.notify_one();
    }

    fn renew(&mut self, moving: &Moving, scale: f32) {
        self.number += 1;
        (self.moving, self.scale, self.failed) = (Some(moving.clone()), scale, None);
        // The last picture stays until the first of the new ones is there.
        self.pictures.clear();
        let measured = moving.measure(1.0).and_then(|area| Ok((area, moving.measure(scale)?.0, moving.frames()?.0)));
        let mut wanted = lock(&self.shared.0);
        match measured {
            Ok((((width, height), corner), pixels, frames)) => {
                self.area = Rect::from_min_size(pos2(corner.0, corner.1), vec2(width as f32, height as f32));
                let bytes = 4 * pixels.0 as usize * pixels.1 as usize;
                self.most = (KEPT_BYTES / bytes.max(1)).max(AHEAD as usize + 2);
                let of = Some((self.number, moving.clone()));
                *wanted = Wanted { of, frames, scale, ..Wanted::default() };
            }
            Err(e) => {
                self.failed = Some(e.to_string());
                wanted.of = None;
            }
        }
    }

    /// The frame that was asked for, or else the one before it.
    pub(crate) fn picture(&self) -> Option<&TextureHandle> {
        self.shown.as_ref()
    }

    /// Nothing moves any more.
    pub(crate) fn clear(&mut self) {
        self.number += 1;
        (self.moving, self.shown, self.failed) = (None, None, None);
        self.pictures.clear();
        lock(&self.shared.0).of = None;
    }
}

impl Drop for MovingPictures {
    fn drop(&mut self) {
        lock(&self.shared.0).closed = true;
        self.shared.1.notify_one();
    }
}

fn lock(wanted: &Mutex<Wanted>) -> MutexGuard<'_, Wanted> {
    wanted.lock().unwrap_or_else(PoisonError::into_inner)
}

fn draw(shared: &Shared, send: &Sender<Drawn>, ui: &Context) {
    loop {
        let (number, moving, frame, scale) = {
            let mut wanted = lock(&shared.0);
            loop {
                if wanted.closed {
                    return;
                }
                let frames = wanted.frames.max(1);
                let ahead = (0..=AHEAD.min(frames - 1)).map(|i| (wanted.frame + i) % frames);
                let next = ahead.into_iter().find(|frame| !wanted.held.contains(frame));
                if let (Some((number, moving)), Some(next)) = (wanted.of.clone(), next) {
                    wanted.held.push(next);
                    break (number, moving, next, wanted.scale);
                }
                wanted = shared.1.wait(wanted).unwrap_or_else(PoisonError::into_inner);
            }
        };
        if send.send((number, frame, moving.draw(frame, scale))).is_err() {
            return;
        }
        ui.request_repaint();
    }
}
