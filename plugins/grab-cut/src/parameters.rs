//! What a person may turn.

use crate::Error;

/// Settings of [`crate::GrabCut`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Gaussians for each side, 1..=32.
    pub components: u32,
    /// Rounds of learning and cutting before the final cut, 1..=10.
    pub rounds: u32,
    /// The price of an edge of no contrast, 0..=100, in the unit of evidence (natural logarithms).
    pub smoothness: f32,
    /// How much colour counts, 0..=2.
    pub colour: f32,
    /// How much the creature's shape around the limbs counts, 0..=4.
    pub shape: f32,
    /// How much place counts beside colour, 0..=400: levels of a colour channel that the creature's size is worth.
    pub place: f32,
    /// Frames over which a mask is remembered, 1..=1000.
    pub memory: f32,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { components: 5, rounds: 4, smoothness: 4.0, colour: 1.0, shape: 1.0, place: 80.0, memory: 12.0 }
    }
}

impl Parameters {
    pub(crate) fn check(&self) -> Result<(), Error> {
        let ranges = [
            ("components", self.components as f32, 1.0, 32.0),
            ("rounds", self.rounds as f32, 1.0, 10.0),
            ("smoothness", self.smoothness, 0.0, 100.0),
            ("colour", self.colour, 0.0, 2.0),
            ("shape", self.shape, 0.0, 4.0),
            ("place", self.place, 0.0, 400.0),
            ("memory", self.memory, 1.0, 1000.0),
        ];
        match ranges.into_iter().find(|(_, v, low, high)| !(low <= v && v <= high)) {
            Some((name, value, low, high)) => Err(Error::Parameter { name, value, low, high }),
            None => Ok(()),
        }
    }
}
