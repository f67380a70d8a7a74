//! Scores of what `marey` writes against ground truth, for the tests and for the measured table in the documentation;
//! and somebody who edits sessions.

pub mod editing;
pub mod scene;
pub mod score;
pub mod sketches;
