//! Segments a clip along its strokes and writes one mask a frame and the motion, with the time it took.
//!
//! `segment_eval CLIP STROKES OUT_DIR [MOTION] [paper] [NAME=NUMBER ...]`: without a motion file the strokes are tracked first.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::path::PathBuf;
use std::time::Instant;

use marey::clip::Clip;
use marey::job::Progress;
use marey::motion::Motion;
use marey::rig::Rig;
use marey::segment::{CostVolumeSegmenter, Method, SegmentParams, Segmenter};
use marey::track::Tracker;
use marey::track::limb::LimbTracker;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args: Vec<String> = std::env::args().skip(1).collect();
    let paper = args.iter().position(|a| a == "paper").map(|i| args.remove(i)).is_some();
    let mut params = SegmentParams::default();
    while let Some(at) = args.iter().position(|a| a.contains('=')) {
        let setting = args.remove(at);
        let (name, value) = setting.split_once('=').unwrap_or_default();
        let value: f32 = value.parse()?;
        match name {
            "side" => params.working_side = value as u32,
            "passes" => params.passes = value as usize,
            "reach" => params.reach = value,
            "colour" => params.colour_weight = value,
            "shape" => params.shape_weight = value,
            "edge" => params.edge_weight = value,
            "memory" => params.memory = value,
            _ => return Err(format!("no parameter is called `{name}`").into()),
        }
    }
    let [clip, strokes, out, motion @ ..] = &args[..] else {
        return Err("usage: segment_eval CLIP STROKES OUT_DIR [MOTION] [paper] [NAME=NUMBER ...]".into());
    };
    let clip = Clip::open(clip)?;
    let rig = Rig::read(strokes)?;
    let progress = Progress::new();
    let motion = match motion.first() {
        Some(file) => Motion::read(file)?,
        None => LimbTracker::default().track(&clip, &rig, progress.whole())?,
    };
    if paper {
        params.method = Method::Paper;
    }
    let segmenter = CostVolumeSegmenter { params };
    let began = Instant::now();
    let masks = segmenter.segment(&clip, &rig, &motion, progress.whole())?;
    let seconds = began.elapsed().as_secs_f64();
    let out = PathBuf::from(out);
    std::fs::create_dir_all(&out)?;
    std::fs::write(out.join("motion.json"), motion.to_json())?;
    for (frame, mask) in masks.iter().enumerate() {
        mask.to_image().save(out.join(format!("{frame:05}.png")))?;
    }
    println!("{} frames, {:.2} s, {:.1} ms a frame", masks.len(), seconds, 1e3 * seconds / masks.len().max(1) as f64);
    Ok(())
}
