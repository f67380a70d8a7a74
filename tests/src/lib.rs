//! Scores of what `marey` writes against ground truth, for the tests and for the measured table in the documentation.

pub mod scene;
pub mod score;
