//! One file for each thing that is scored.

mod creature;
mod masks;
mod tracks;

pub use creature::{CreatureScore, creature};
pub use masks::{MaskScore, masks};
pub use tracks::{TrackScore, Truth, tracks};
