//! Pixels: float grids, bit masks, filters, and a small rasterizer. Knows nothing of clips, rigs or creatures.

pub(crate) mod bilateral;
mod cover;
pub(crate) mod distance;
pub(crate) mod gaussian;
mod grid;
pub(crate) mod guided_filter;
mod lab;
pub(crate) mod marching_squares;
mod mask;
pub(crate) mod morphology;
mod painter;
mod planes;
mod push_pull;
pub mod pyramid;
mod rasterizer;
pub mod sample;
pub(crate) mod thinning;

pub use cover::Cover;
pub use grid::Grid;
pub use mask::Mask;
pub use painter::{Piece, Texture, paint};
pub use planes::Planes;
pub use push_pull::{Wrap, push_pull};
pub use rasterizer::{Rasterizer, Surface, clip_view, orbit_view};
