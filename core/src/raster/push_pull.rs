//! Filling of holes by push and pull: unknown pixels take the colours of the nearest known ones, smoothly.
//!
//! Method: Gortler et al., "The Lumigraph", 1996, section 3.5: known colours are averaged down a pyramid to one pixel,
//! and what is still unknown is filled from the level above on the way back. Known pixels come back exactly. The
//! pyramid wraps around where the picture does (a cylinder's texture: Reinert 2016, section 3.8).

use super::Grid;

/// Which borders of the picture join.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wrap {
    /// The right border joins the left one.
    pub x: bool,
    /// The bottom border joins the top one.
    pub y: bool,
}

/// Fills the pixels of `color` where `known` is false; the others are not touched. `color` is row-major, as wide as
/// `known`. Where nothing is known at all, everything becomes `default`.
pub fn push_pull(color: &mut [[f32; 3]], known: &Grid<bool>, wrap: Wrap, default: [f32; 3]) {
    let (width, height) = (known.width(), known.height());
    if width == 0 || height == 0 || color.len() != width * height {
        return;
    }
    if !known.data().contains(&true) {
        color.fill(default);
        return;
    }
    let mut levels = vec![Level {
        width,
        height,
        color: color.to_vec(),
        weight: known.data().iter().map(|&k| f32::from(u8::from(k))).collect(),
    }];
    while let Some(level) = levels.last()
        && (level.width > 1 || level.height > 1)
    {
        let next = level.pulled(wrap);
        levels.push(next);
    }
    while levels.len() > 1 {
        if let Some(coarse) = levels.pop()
            && let Some(fine) = levels.last_mut()
        {
            fine.push_from(&coarse, wrap);
        }
    }
    for ((out, filled), known) in color.iter_mut().zip(&levels[0].color).zip(known.data()) {
        if !known {
            *out = *filled;
        }
    }
}

/// One level of the pyramid; weights in 0..=1 say how far a colour is known.
struct Level {
    width: usize,
    height: usize,
    color: Vec<[f32; 3]>,
    weight: Vec<f32>,
}

impl Level {
    /// The level at half the size: weighted means of 4 x 4 pixels with tent weights.
    fn pulled(&self, wrap: Wrap) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut out = Self {
            width,
            height,
            color: Vec::with_capacity(width * height),
            weight: Vec::with_capacity(width * height),
        };
        const TENT: [f32; 4] = [0.125, 0.375, 0.375, 0.125];
        for y in 0..height {
            for x in 0..width {
                let (mut sum, mut total) = ([0.0f32; 3], 0.0f32);
                for (j, ty) in TENT.iter().enumerate() {
                    let sy = place(2 * y as isize + j as isize - 1, self.height, wrap.y);
                    for (i, tx) in TENT.iter().enumerate() {
                        let sx = place(2 * x as isize + i as isize - 1, self.width, wrap.x);
                        let at = sy * self.width + sx;
                        let w = tx * ty * self.weight[at];
                        total += w;
                        for c in 0..3 {
                            sum[c] += w * self.color[at][c];
                        }
                    }
                }
                out.color.push(if total > 0.0 { sum.map(|s| s / total) } else { [0.0; 3] });
                // A quarter of known pixels is enough to make the coarse pixel known.
                out.weight.push((4.0 * total).min(1.0));
            }
        }
        out
    }

    /// Blends in the coarser level where this one is not known.
    fn push_from(&mut self, coarse: &Self, wrap: Wrap) {
        for y in 0..self.height {
            for x in 0..self.width {
                let at = y * self.width + x;
                let w = self.weight[at];
                if w >= 1.0 {
                    continue;
                }
                let up = coarse.bilinear(x as f32 / 2.0 - 0.25, y as f32 / 2.0 - 0.25, wrap);
                for c in 0..3 {
                    self.color[at][c] = (1.0 - w) * up[c] + w * self.color[at][c];
                }
            }
        }
    }

    fn bilinear(&self, x: f32, y: f32, wrap: Wrap) -> [f32; 3] {
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let (x0, y0) = (x.floor() as isize, y.floor() as isize);
        let mut out = [0.0; 3];
        for (j, wy) in [1.0 - fy, fy].into_iter().enumerate() {
            for (i, wx) in [1.0 - fx, fx].into_iter().enumerate() {
                let at = place(y0 + j as isize, self.height, wrap.y) * self.width
                    + place(x0 + i as isize, self.width, wrap.x);
                for c in 0..3 {
                    out[c] += wx * wy * self.color[at][c];
                }
            }
        }
        out
    }
}

/// The index inside `0..size` for a place that may lie outside.
fn place(i: isize, size: usize, wrap: bool) -> usize {
    if wrap { i.rem_euclid(size as isize) as usize } else { i.clamp(0, size as isize - 1) as usize }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn known_pixels_stay_and_all_are_within_their_range(
            width in 1usize..23, height in 1usize..19, seed in 0u32..1000, x in any::<bool>(), y in any::<bool>(),
        ) {
            let random = |i: usize| (seed.wrapping_mul(747_796_405).wrapping_add((i as u32).wrapping_mul(2_654_435_761)) >> 8) % 256;
            let known = Grid::from_vec(width, height, (0..width * height).map(|i| random(i) < 40).collect());
            let color: Vec<[f32; 3]> = (0..width * height)
                .map(|i| if known.data()[i] { [random(3 * i) as f32, 7.0, 200.0] } else { [f32::NAN, 1e9, -5.0] })
                .map(|c| if c[0].is_nan() { [0.0, 1e9, -5.0] } else { c })
                .collect();
            let mut filled = color.clone();
            push_pull(&mut filled, &known, Wrap { x, y }, [1.0, 2.0, 3.0]);
            if known.data().contains(&true) {
                for i in 0..width * height {
                    if known.data()[i] {
                        prop_assert_eq!(filled[i], color[i]);
                    }
                    prop_assert!((0.0..=255.001).contains(&filled[i][0]), "{:?}", filled[i]);
                    prop_assert!((filled[i][1] - 7.0).abs() < 1e-3 && (filled[i][2] - 200.0).abs() < 1e-2);
                }
            } else {
                prop_assert!(filled.iter().all(|c| *c == [1.0, 2.0, 3.0]));
            }
        }
    }

    #[test]
    fn colour_flows_over_a_joined_border_only() {
        let known = Grid::from_vec(16, 1, (0..16).map(|x| x == 1 || x == 8).collect());
        let color: Vec<[f32; 3]> = (0..16).map(|x| [if x == 1 { 100.0 } else { 0.0 }; 3]).collect();
        let fill = |x| {
            let mut c = color.clone();
            push_pull(&mut c, &known, Wrap { x, y: false }, [0.0; 3]);
            c[15][0]
        };
        assert!(fill(true) > 60.0 && fill(false) < 30.0, "{} {}", fill(true), fill(false));
    }
}
