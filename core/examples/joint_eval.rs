//! Measures the joint tracker on clips with ground truth.
//!
//! `joint_eval FOLDER... [step=N] [motions=FOLDER] [PARAMETER=VALUE...]`: a folder has `frames/` or `rgba/`,
//! `joints.json`, and `truth.json` or `joints-truth.json` (`{"frames": {"0": {"joint": [x, y]}}}`, with a third number above
//! 0 where the joint is seen). Without the third number a joint is seen where the picture in `labels/` has the label that
//! it has most often, or everywhere. Of the clip every N-th frame is taken, which makes a run of a walk. Prints the shares
//! of joints within 10 pixels (at 512 pixels) where they are seen and of all, the median error where they are seen, the
//! share of joints whose visibility is right, and seconds.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use marey::clip::Clip;
use marey::job::Progress;
use marey::motion::Motion;
use marey::rig::JointMarks;
use marey::track::TrackJoints;
use marey::track::joint::{JointParams, JointTracker};

type AnyError = Box<dyn std::error::Error>;

#[derive(serde::Deserialize)]
struct Truth {
    frames: BTreeMap<usize, BTreeMap<String, Vec<f32>>>,
}

fn set(p: &mut JointParams, key: &str, v: f32) -> Result<(), AnyError> {
    let count = match key {
        "found" => Some(&mut p.found),
        "beam" => Some(&mut p.beam),
        "states" => Some(&mut p.states),
        "rounds" => Some(&mut p.rounds),
        _ => None,
    };
    if let Some(count) = count {
        *count = v as usize;
        return Ok(());
    }
    if key == "working_side" {
        p.working_side = v as u32;
        return Ok(());
    }
    let place = match key {
        "colour" => &mut p.colour,
        "claimed" => &mut p.claimed,
        "hidden" => &mut p.hidden,
        "outside" => &mut p.outside,
        "length" => &mut p.length,
        "length_reach" => &mut p.length_reach,
        "attached" => &mut p.attached,
        "attached_reach" => &mut p.attached_reach,
        "inertia" => &mut p.inertia,
        "inertia_reach" => &mut p.inertia_reach,
        "still" => &mut p.still,
        "still_reach" => &mut p.still_reach,
        _ => return Err(format!("there is no parameter {key}").into()),
    };
    *place = v;
    Ok(())
}

fn first_of(folder: &Path, names: [&str; 2]) -> Result<PathBuf, AnyError> {
    let found = names.iter().map(|n| folder.join(n)).find(|p| p.exists());
    found.ok_or_else(|| format!("{}: there is no {} and no {}", folder.display(), names[0], names[1]).into())
}

fn files(folder: &Path) -> Result<Vec<PathBuf>, AnyError> {
    let mut files = std::fs::read_dir(folder)?.map(|e| Ok(e?.path())).collect::<Result<Vec<_>, std::io::Error>>()?;
    files.sort();
    Ok(files)
}

/// Adds to every joint without it whether it is seen, by the labels.
fn see(folder: &Path, truth: &mut Truth) -> Result<(), AnyError> {
    let labels = if folder.exists() { files(folder)? } else { Vec::new() };
    let pictures = labels.iter().map(|p| Ok(image::open(p)?.to_luma8())).collect::<Result<Vec<_>, AnyError>>()?;
    let label = |frame: usize, at: &[f32]| {
        let picture = pictures.get(frame)?;
        let [x, y, ..] = *at else { return None };
        (x >= 0.0 && y >= 0.0).then_some(())?;
        picture.get_pixel_checked(x as u32, y as u32).map(|p| p.0[0])
    };
    let mut counts: BTreeMap<(String, u8), usize> = BTreeMap::new();
    for (f, joints) in &truth.frames {
        for (name, at) in joints {
            if let Some(l) = label(*f, at).filter(|l| *l > 0) {
                *counts.entry((name.clone(), l)).or_default() += 1;
            }
        }
    }
    for (f, joints) in &mut truth.frames {
        for (name, at) in joints.iter_mut().filter(|(_, at)| at.len() == 2) {
            let usual =
                counts.iter().filter(|((n, _), _)| n == name).max_by_key(|(_, count)| **count).map(|((_, l), _)| *l);
            at.push(if usual.is_none() || label(*f, at) == usual { 1.0 } else { 0.0 });
        }
    }
    Ok(())
}

struct Score {
    seen: f32,
    all: f32,
    median: f32,
    judged: f32,
}

fn score(motion: &Motion, marks: &JointMarks, truth: &Truth, step: usize) -> Score {
    let unit = 512.0 / motion.size.0.max(motion.size.1) as f32;
    let (mut seen, mut all, mut judged) = ((0, 0), (0, 0), (0, 0));
    let mut errors = Vec::new();
    for (f, joints) in truth.frames.iter().filter(|(f, _)| *f % step == 0 && *f / step < motion.frames) {
        for (name, at) in joints {
            let Some(track) = motion.track(name) else { continue };
            let [x, y, visible] = at[..] else { continue };
            if marks.mark(name, f / step).is_some() {
                continue;
            }
            let frame = &track.frames[f / step];
            let error = unit * frame.points[0].distance(marey::vec2(x, y));
            let hit = usize::from(error <= 10.0);
            all = (all.0 + hit, all.1 + 1);
            if visible > 0.0 {
                seen = (seen.0 + hit, seen.1 + 1);
                errors.push(error);
            }
            judged = (judged.0 + usize::from(frame.visible[0] == (visible > 0.0)), judged.1 + 1);
        }
    }
    errors.sort_by(f32::total_cmp);
    let share = |(n, of): (usize, usize)| 100.0 * n as f32 / of.max(1) as f32;
    let median = errors.get(errors.len() / 2).copied().unwrap_or(0.0);
    Score { seen: share(seen), all: share(all), median, judged: share(judged) }
}

fn main() -> Result<(), AnyError> {
    let mut params = JointParams::default();
    let (mut folders, mut step, mut motions) = (Vec::new(), 1, None);
    for arg in std::env::args().skip(1) {
        match arg.split_once('=') {
            Some(("step", v)) => step = v.parse::<usize>()?.max(1),
            Some(("motions", v)) => motions = Some(PathBuf::from(v)),
            Some((key, v)) => set(&mut params, key, v.parse()?)?,
            None => folders.push(PathBuf::from(arg)),
        }
    }
    if folders.is_empty() {
        return Err("usage: joint_eval FOLDER... [step=N] [motions=FOLDER] [PARAMETER=VALUE...]".into());
    }
    let tracker = JointTracker { params };
    println!("{:<32} {:>7} {:>7} {:>7} {:>7} {:>7}", "", "seen<10", "all<10", "median", "visible", "seconds");
    for folder in folders {
        let text = std::fs::read_to_string(first_of(&folder, ["truth.json", "joints-truth.json"])?)?;
        let mut truth: Truth = serde_json::from_str(&text)?;
        see(&folder.join("labels"), &mut truth)?;
        let frames = tempfile::tempdir()?;
        for (i, file) in files(&first_of(&folder, ["frames", "rgba"])?)?.iter().step_by(step).enumerate() {
            std::fs::copy(file, frames.path().join(format!("{i:05}.png")))?;
        }
        let clip = Clip::open(frames.path())?;
        let marks = JointMarks::read(folder.join("joints.json"))?;
        let (progress, start) = (Progress::new(), Instant::now());
        let motion = tracker.track_joints(&clip, &marks, progress.whole())?;
        let seconds = start.elapsed().as_secs_f64();
        let Score { seen, all, median, judged } = score(&motion, &marks, &truth, step);
        let name = folder.display().to_string();
        println!("{name:<32} {seen:>7.1} {all:>7.1} {median:>7.1} {judged:>7.1} {seconds:>7.1}");
        if let Some(motions) = &motions {
            std::fs::create_dir_all(motions)?;
            let name = name.trim_matches('/').replace('/', "-");
            std::fs::write(motions.join(format!("{name}.json")), motion.to_json())?;
        }
    }
    Ok(())
}
