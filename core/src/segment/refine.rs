//! From a small mask to crisp edges at the clip's size: a guided filter along the picture's own colours, in the
//! neighbourhood of the mask's outline only.

use glam::vec2;

use crate::clip::FrameImage;
use crate::raster::guided_filter::guided_filter;
use crate::raster::sample::bilinear;
use crate::raster::{Grid, Mask};

/// Half the filter's window, in pixels of the small mask.
const RADIUS: f32 = 2.0;
/// Variance of colour (0..=1 scale) below which there is no edge to follow.
const SMOOTHNESS: f32 = 4e-4;

/// The mask at the picture's size.
pub(super) fn refine(picture: &FrameImage, small: &Mask) -> Mask {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let scale = vec2(small.width() as f32 / width as f32, small.height() as f32 / height as f32);
    let radius = (RADIUS / scale.max_element()).round().max(1.0) as usize;
    let mut out = Mask::new(width, height);
    let Some((low, high)) = extent(small) else { return out };
    let margin = 2 * radius + 2;
    let at = |v: usize, scale: f32| (v as f32 / scale) as usize;
    let (x0, y0) = (at(low.0, scale.x).saturating_sub(margin), at(low.1, scale.y).saturating_sub(margin));
    let x1 = (at(high.0 + 1, scale.x) + margin).min(width);
    let y1 = (at(high.1 + 1, scale.y) + margin).min(height);
    let (w, h) = (x1 - x0, y1 - y0);
    let floats = Grid::from_vec(
        small.width(),
        small.height(),
        (0..small.height())
            .flat_map(|y| (0..small.width()).map(move |x| (x, y)))
            .map(|(x, y)| f32::from(u8::from(small.get(x, y))))
            .collect(),
    );
    let mut map = Grid::new(w, h, 0.0f32);
    let mut guide: [Grid<f32>; 3] = std::array::from_fn(|_| Grid::new(w, h, 0.0));
    for y in 0..h {
        for x in 0..w {
            let centre = vec2((x + x0) as f32 + 0.5, (y + y0) as f32 + 0.5);
            map.set(x, y, bilinear(&floats, centre * scale));
            let colour = picture.get_pixel((x + x0) as u32, (y + y0) as u32).0;
            for c in 0..3 {
                guide[c].set(x, y, f32::from(colour[c]) / 255.0);
            }
        }
    }
    let filtered = guided_filter(&guide, &map, radius, SMOOTHNESS);
    for y in 0..h {
        for x in 0..w {
            out.set(x + x0, y + y0, filtered.get(x, y) > 0.5);
        }
    }
    out
}

/// The first and last column and row of the mask.
fn extent(mask: &Mask) -> Option<((usize, usize), (usize, usize))> {
    let mut found: Option<((usize, usize), (usize, usize))> = None;
    for y in 0..mask.height() {
        for x in (0..mask.width()).filter(|&x| mask.get(x, y)) {
            let (low, high) = found.unwrap_or(((x, y), (x, y)));
            found = Some(((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y))));
        }
    }
    found
}
