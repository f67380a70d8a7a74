//! Pixels: float grids, bit masks, filters, and a small rasterizer. Knows nothing of clips, rigs or creatures.

mod grid;
mod lab;
mod mask;
mod planes;
pub mod pyramid;
pub mod sample;

pub use grid::Grid;
pub use mask::Mask;
pub use planes::Planes;
