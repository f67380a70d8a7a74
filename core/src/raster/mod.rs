//! Pixels: float grids, bit masks, filters, and a small rasterizer. Knows nothing of clips, rigs or creatures.

mod grid;
mod mask;

pub use grid::Grid;
pub use mask::Mask;
