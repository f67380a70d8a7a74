//! How time passes between two keys.

use serde::{Deserialize, Serialize};

/// How the way from a key to the next one is spread over time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Easing {
    /// Evenly.
    #[default]
    Linear,
    /// Slowly first.
    In,
    /// Slowly at last.
    Out,
    /// Slowly at both ends.
    InOut,
    /// Not at all until the next key.
    Hold,
}

impl Easing {
    /// The share of the way after the share `t` of the time; 0 and 1 stay.
    pub fn share(self, t: f64) -> f64 {
        let t = t.clamp(0.0, 1.0);
        match self {
            Self::Linear => t,
            Self::In => t * t,
            Self::Out => t * (2.0 - t),
            Self::InOut => t * t * (3.0 - 2.0 * t),
            Self::Hold => t.floor(),
        }
    }
}
