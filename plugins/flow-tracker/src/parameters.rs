//! What a person may turn.

use crate::Error;

/// Settings of [`crate::FlowTracker`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Half the width of the band around a stroke whose motion counts, as a share of the stroke's length, 0..=0.5.
    pub width: f32,
    /// Pixels by which flow there and back may miss itself before it counts half, 0.1..=20.
    pub disagreement: f32,
    /// How strongly points are pulled back to what looks like their key frame, 0..=1.
    pub anchor: f32,
    /// How much a limb keeps its drawn length against what the flow makes of it, 0..=1 a frame.
    pub length: f32,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { width: 0.04, disagreement: 1.0, anchor: 0.8, length: 0.3 }
    }
}

impl Parameters {
    pub(crate) fn check(&self) -> Result<(), Error> {
        let ranges = [
            ("width", self.width, 0.0, 0.5),
            ("disagreement", self.disagreement, 0.1, 20.0),
            ("anchor", self.anchor, 0.0, 1.0),
            ("length", self.length, 0.0, 1.0),
        ];
        match ranges.into_iter().find(|(_, v, low, high)| !(low <= v && v <= high)) {
            Some((name, value, low, high)) => Err(Error::Parameter { name, value, low, high }),
            None => Ok(()),
        }
    }
}
