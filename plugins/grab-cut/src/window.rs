//! The part of a frame around the limbs, at a size that is quick to work on.

use glam::{Vec2, vec2};

use crate::footage::{Known, Limb};
use crate::limb_field::{LimbField, Place};

/// A rectangle of a frame, in blocks of `factor` by `factor` pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    /// Left and top in blocks.
    pub(crate) left: usize,
    pub(crate) top: usize,
    /// Size in blocks.
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Pixels along the side of a block.
    pub(crate) factor: usize,
}

/// The box around all limbs.
pub(crate) fn bounds(limbs: &[Limb]) -> (Vec2, Vec2) {
    let points = limbs.iter().flat_map(|l| &l.points);
    points.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
}

impl Window {
    /// The limbs' box with `margin` pixels around it, inside a frame of `size`; the whole frame without limbs in it.
    pub(crate) fn around(limbs: &[Limb], margin: f32, size: (usize, usize), factor: usize) -> Self {
        let (low, high) = bounds(limbs);
        let blocks = |pixels: f32, limit: usize| (pixels.max(0.0) as usize).min(limit);
        let (across, down) = (size.0.div_ceil(factor), size.1.div_ceil(factor));
        let f = factor as f32;
        let left = blocks(((low.x - margin) / f).floor(), across);
        let top = blocks(((low.y - margin) / f).floor(), down);
        let right = blocks(((high.x + margin) / f).ceil(), across);
        let bottom = blocks(((high.y + margin) / f).ceil(), down);
        if left + 1 < right && top + 1 < bottom {
            Self { left, top, width: right - left, height: bottom - top, factor }
        } else {
            Self { left: 0, top: 0, width: across, height: down, factor }
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.width * self.height
    }

    /// Pixels of a frame that a block covers; blocks at the right and lower border are cut off.
    pub(crate) fn pixels(
        &self,
        x: usize,
        y: usize,
        size: (usize, usize),
    ) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        let span = |block: usize, limit: usize| block * self.factor..((block + 1) * self.factor).min(limit);
        (span(self.left + x, size.0), span(self.top + y, size.1))
    }

    /// Where a point of the frame lies in the window, in blocks.
    pub(crate) fn inside(&self, p: Vec2) -> Vec2 {
        p / self.factor as f32 - vec2(self.left as f32, self.top as f32)
    }
}

/// What there is to know of a frame before it is cut.
pub(crate) struct View {
    pub(crate) window: Window,
    /// Mean colours of the blocks.
    pub(crate) colours: Vec<[u8; 3]>,
    pub(crate) field: LimbField,
    /// Painted blocks; empty where nothing was painted.
    pub(crate) known: Vec<Known>,
}

impl View {
    /// Looks at a frame of `size` through a window. `radius` is in pixels of the frame.
    pub(crate) fn new(
        frame: &[u8],
        known: Option<&Vec<Known>>,
        size: (usize, usize),
        limbs: &[Limb],
        radius: &[f32],
        window: Window,
    ) -> Self {
        let mut colours = Vec::with_capacity(window.len());
        let mut blocks = Vec::new();
        for y in 0..window.height {
            for x in 0..window.width {
                let (xs, ys) = window.pixels(x, y, size);
                let (mut sum, mut n) = ([0u32; 3], 0u32);
                let mut votes = [0u32; 3];
                for row in ys {
                    for column in xs.clone() {
                        let at = row * size.0 + column;
                        for c in 0..3 {
                            sum[c] += u32::from(frame[3 * at + c]);
                        }
                        n += 1;
                        if let Some(known) = known {
                            votes[known[at] as usize] += 1;
                        }
                    }
                }
                colours.push(sum.map(|s| ((s + n / 2) / n.max(1)) as u8));
                if known.is_some() {
                    let [_, background, creature] = votes;
                    blocks.push(match background + creature {
                        0 => Known::Nothing,
                        _ if creature > background => Known::Creature,
                        _ => Known::Background,
                    });
                }
            }
        }
        let field = Self::field(limbs, radius, window);
        Self { window, colours, field, known: blocks }
    }

    fn field(limbs: &[Limb], radius: &[f32], window: Window) -> LimbField {
        let moved: Vec<Limb> = limbs
            .iter()
            .map(|l| Limb { points: l.points.iter().map(|&p| window.inside(p)).collect(), trust: l.trust.clone() })
            .collect();
        let radius: Vec<f32> = radius.iter().map(|r| r / window.factor as f32).collect();
        LimbField::new(window.width, window.height, &moved, &radius)
    }

    /// Looks for nearest limbs again, now that their radii are known.
    pub(crate) fn measure(&mut self, limbs: &[Limb], radius: &[f32]) {
        self.field = Self::field(limbs, radius, self.window);
    }

    pub(crate) fn place(&self, index: usize) -> Option<Place> {
        self.field.at(index % self.window.width, index / self.window.width)
    }

    pub(crate) fn known(&self, index: usize) -> Known {
        self.known.get(index).copied().unwrap_or_default()
    }
}
