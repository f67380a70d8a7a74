//! A clip's frames as textures: decoded by a thread of their own, the shown one first, those that play next ahead of
//! time, and small ones for the timeline. The window shows the last frame it has until the next is there.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};
use marey_binding::{Clip, ClipInfo};

/// Memory for frames as textures: some two seconds of a clip of 1280x720.
const KEPT_BYTES: usize = 192 << 20;
/// Frames that are decoded ahead of the shown one.
const AHEAD: u64 = 6;
/// Small pictures on the timeline, and how high they are in pixels.
const SMALL: (u64, usize) = (24, 72);

/// What a decoder found: a frame or a small one, and whether something behind it can be seen.
type Decoded = (u64, bool, Result<(ColorImage, bool), String>);

pub(crate) struct Frames {
    clip: Arc<Clip>,
    shared: Arc<Shared>,
    decoded: Receiver<Decoded>,
    pictures: HashMap<u64, TextureHandle>,
    /// The order in which pictures were last asked for.
    used: VecDeque<u64>,
    most: usize,
    shown: Option<u64>,
    small: Vec<(u64, Option<TextureHandle>)>,
    failed: Option<String>,
    /// Whether something behind any of its pictures can be seen.
    pub(crate) see_through: bool,
}

#[derive(Debug)]
struct Shared {
    wanted: Mutex<Wanted>,
    wake: Condvar,
}

#[derive(Debug)]
struct Wanted {
    frame: u64,
    /// Decoded, or not to be had.
    held: HashSet<u64>,
    small: VecDeque<u64>,
    closed: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Wanted> {
        self.wanted.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Frames {
    pub(crate) fn new(ui: &Context, clip: Arc<Clip>, info: &ClipInfo) -> Self {
        let frames = info.frames.max(1);
        let count = frames.min(SMALL.0);
        let small: Vec<u64> = (0..count).map(|i| i * frames / count).collect();
        let wanted = Wanted { frame: 0, held: HashSet::new(), small: small.iter().copied().collect(), closed: false };
        let shared = Arc::new(Shared { wanted: Mutex::new(wanted), wake: Condvar::new() });
        let (send, decoded) = channel();
        let (worker, ui, size) = (shared.clone(), ui.clone(), [info.width as usize, info.height as usize]);
        let of = clip.clone();
        std::thread::spawn(move || decode(&worker, &of, frames, size, &send, &ui));
        let bytes = 4 * size[0] * size[1];
        Self {
            clip,
            shared,
            decoded,
            pictures: HashMap::new(),
            used: VecDeque::new(),
            most: (KEPT_BYTES / bytes.max(1)).max(AHEAD as usize + 2),
            shown: None,
            small: small.into_iter().map(|frame| (frame, None)).collect(),
            failed: None,
            see_through: false,
        }
    }

    /// Of which clip they are.
    pub(crate) fn clip(&self) -> &Arc<Clip> {
        &self.clip
    }

    /// Takes in what was decoded, and asks for `frame`. Gives what went wrong, once.
    pub(crate) fn update(&mut self, ui: &Context, frame: u64) -> Option<String> {
        let mut failed = None;
        for (at, small, picture) in self.decoded.try_iter() {
            let picture = match picture {
                Ok((picture, see_through)) => {
                    self.see_through |= see_through;
                    ui.load_texture(format!("frame {at}"), picture, TextureOptions::LINEAR)
                }
                Err(message) => {
                    failed = Some(message);
                    continue;
                }
            };
            if small {
                if let Some((_, kept)) = self.small.iter_mut().find(|(frame, _)| *frame == at) {
                    *kept = Some(picture);
                }
            } else {
                self.pictures.insert(at, picture);
                self.used.push_back(at);
            }
        }
        if self.pictures.contains_key(&frame) {
            self.shown = Some(frame);
            self.used.retain(|at| *at != frame);
            self.used.push_back(frame);
        }
        let mut wanted = self.shared.lock();
        while self.used.len() > self.most {
            let Some(oldest) = self.used.pop_front() else { break };
            self.pictures.remove(&oldest);
            wanted.held.remove(&oldest);
        }
        wanted.frame = frame;
        drop(wanted);
        self.shared.wake.notify_one();
        // Every frame of a broken file would say the same.
        let first = self.failed.is_none();
        if let Some(message) = &failed {
            self.failed = Some(message.clone());
        }
        failed.filter(|_| first)
    }

    /// The frame that was asked for, or else the one before it.
    pub(crate) fn picture(&self) -> Option<&TextureHandle> {
        self.pictures.get(&self.shown?)
    }

    /// Frames with their small pictures, as far as there are.
    pub(crate) fn small(&self) -> &[(u64, Option<TextureHandle>)] {
        &self.small
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        self.shared.lock().closed = true;
        self.shared.wake.notify_one();
    }
}

fn decode(shared: &Shared, clip: &Clip, frames: u64, size: [usize; 2], send: &Sender<Decoded>, ui: &Context) {
    loop {
        let (frame, small) = {
            let mut wanted = shared.lock();
            loop {
                if wanted.closed {
                    return;
                }
                let ahead = (0..=AHEAD.min(frames - 1)).map(|i| (wanted.frame + i) % frames);
                if let Some(next) = ahead.into_iter().find(|frame| !wanted.held.contains(frame)) {
                    wanted.held.insert(next);
                    break (next, false);
                }
                if let Some(next) = wanted.small.pop_front() {
                    break (next, true);
                }
                wanted = shared.wake.wait(wanted).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let picture = read(clip, frame, size, small.then_some(SMALL.1)).map_err(|e| e.to_string());
        if send.send((frame, small, picture)).is_err() {
            return;
        }
        ui.request_repaint();
    }
}

/// A frame, and whether something of it is see-through. One of another height is on paper.
pub(crate) fn read(
    clip: &Clip,
    frame: u64,
    size: [usize; 2],
    height: Option<usize>,
) -> marey_binding::Result<(ColorImage, bool)> {
    let (rgb, alpha) = (clip.frame(frame)?, clip.alpha(frame)?);
    let opaque = alpha.iter().all(|a| *a == 255);
    let picture = match (height, opaque) {
        (Some(height), true) => smaller(&rgb, size, height),
        (Some(height), false) => smaller(&on_white(&rgb, &alpha), size, height),
        (None, true) => ColorImage::from_rgb(size, &rgb),
        (None, false) => ColorImage::from_rgba_unmultiplied(size, &with_alpha(&rgb, &alpha)),
    };
    Ok((picture, !opaque))
}

fn with_alpha(rgb: &[u8], alpha: &[u8]) -> Vec<u8> {
    rgb.as_chunks::<3>().0.iter().zip(alpha).flat_map(|(&[r, g, b], a)| [r, g, b, *a]).collect()
}

/// As it looks on paper.
fn on_white(rgb: &[u8], alpha: &[u8]) -> Vec<u8> {
    let over = |c: u8, a: u8| 255 - ((255 - u32::from(c)) * u32::from(a) / 255) as u8;
    rgb.as_chunks::<3>().0.iter().zip(alpha).flat_map(|(pixel, a)| pixel.map(|c| over(c, *a))).collect()
}

/// A picture of that height, each pixel the mean of those that it covers.
fn smaller(rgb: &[u8], [width, height]: [usize; 2], to_height: usize) -> ColorImage {
    let to_height = to_height.min(height).max(1);
    let to_width = (width * to_height / height.max(1)).max(1);
    let mut small = Vec::with_capacity(3 * to_width * to_height);
    for y in 0..to_height {
        let rows = y * height / to_height..((y + 1) * height / to_height).max(y * height / to_height + 1);
        for x in 0..to_width {
            let columns = x * width / to_width..((x + 1) * width / to_width).max(x * width / to_width + 1);
            let mut sum = [0_usize; 3];
            for row in rows.clone() {
                for column in columns.clone() {
                    let at = 3 * (row * width + column);
                    (0..3).for_each(|c| sum[c] += usize::from(rgb[at + c]));
                }
            }
            let count = (rows.len() * columns.len()).max(1);
            small.extend(sum.map(|s| (s / count) as u8));
        }
    }
    ColorImage::from_rgb([to_width, to_height], &small)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::Color32;

    #[test]
    fn small_pictures_are_means() {
        // Two columns of black and white, four rows.
        let rgb: Vec<u8> = (0..8).flat_map(|i| if i % 2 == 0 { [0; 3] } else { [200; 3] }).collect();
        let small = smaller(&rgb, [2, 4], 2);
        assert_eq!((small.size, small.pixels), ([1, 2], vec![Color32::from_gray(100); 2]));
        assert_eq!(on_white(&[0, 100, 255, 9, 9, 9], &[255, 0]), [0, 100, 255, 255, 255, 255]);
        assert_eq!(with_alpha(&[1, 2, 3, 4, 5, 6], &[7, 8]), [1, 2, 3, 7, 4, 5, 6, 8]);
        assert_eq!(smaller(&rgb, [2, 4], 99).size, [2, 4], "never larger");
    }
}
