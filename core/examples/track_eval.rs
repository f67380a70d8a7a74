//! Tracks the limbs of one clip and writes motion.json, saying how long it took: for comparing parameters.
//!
//! `cargo run --release -p marey --example track_eval -- CLIP STROKES.json MOTION.json [paper]`
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::time::Instant;

use marey::clip::Clip;
use marey::job::Progress;
use marey::rig::Rig;
use marey::track::Tracker;
use marey::track::limb::{LimbTracker, Method};
use marey::{Error, Result};

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [clip, strokes, out, rest @ ..] = args.as_slice() else {
        return Err(Error::invalid("arguments", "too few", "give CLIP STROKES.json MOTION.json"));
    };
    let clip = Clip::open(clip)?;
    let rig = Rig::read(strokes)?;
    let mut tracker = LimbTracker::default();
    if rest.iter().any(|a| a == "paper") {
        tracker.params.method = Method::Paper;
    }
    let start = Instant::now();
    let motion = tracker.track(&clip, &rig, Progress::new().whole())?;
    println!("{:.3} s, {} frames", start.elapsed().as_secs_f64(), motion.frames);
    std::fs::write(out, motion.to_json()).map_err(|e| Error::io(out, "write", e))
}
