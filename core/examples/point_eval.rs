//! Measures the point tracker on clips with ground truth.
//!
//! `point_eval FOLDER... [motions=FOLDER] [within=PIXELS] [corrections=MOST] [every=FRAMES] [PARAMETER=VALUE...]
//! [/ PARAMETER=VALUE...]`: a folder has `frames/`, `rgba/` or `clip.mp4`, and either `points.json` with
//! `points-truth.json` or `truth.json` (`{"frames": {"0": {"point": [x, y]}}}`), or only `truth.json` with the axes of
//! limbs, of which twelve points are taken that a person might mark. `masks/` has the creature in every frame.
//!
//! Prints, with one key a point (with `every`, one on every so manieth frame as well): the shares of places right within
//! 0.2 and 0.05 of the square root of the mask's area, the median error, swaps a thousand places (a place is swapped where
//! it is within 8 pixels of another point's, and not of its own), and the share of places whose error is above the limit
//! though their confidence is above a half. Then, as the worst place of all is corrected until every place is within 8
//! pixels: corrections, places still beyond that, places a correction, and the same of the swaps with half of the corrections. Last, seconds of reading, of the
//! first solve and of the slowest and the mean later one.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use marey::clip::Clip;
use marey::job::Progress;
use marey::motion::Motion;
use marey::rig::{PointKey, PointMark, PointMarks};
use marey::{Vec2, vec2};

use marey::track::point::{PointFootage, PointParams};

type AnyError = Box<dyn std::error::Error>;
type Truth = BTreeMap<usize, BTreeMap<String, Vec2>>;

fn set(p: &mut PointParams, key: &str, v: f32) -> Result<(), AnyError> {
    let count = match key {
        "looked_at" => Some(&mut p.looked_at),
        "candidates" => Some(&mut p.candidates),
        "skip" => Some(&mut p.skip),
        "steps" => Some(&mut p.steps),
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
        "apart" => &mut p.apart,
        "looks" => &mut p.looks,
        "update" => &mut p.update,
        "flow" => &mut p.flow,
        "flow_reach" => &mut p.flow_reach,
        "velocity" => &mut p.velocity,
        "velocity_reach" => &mut p.velocity_reach,
        "inertia" => &mut p.inertia,
        "inertia_reach" => &mut p.inertia_reach,
        "turn" => &mut p.turn,
        "hide" => &mut p.hide,
        "looks_reach" => &mut p.looks_reach,
        "lost" => &mut p.lost,
        "alike" => &mut p.alike,
        "together" => &mut p.together,
        "shared" => &mut p.shared,
        "guide" => &mut p.guide,
        "guide_reach" => &mut p.guide_reach,
        "dear" => &mut p.dear,
        "smooth" => &mut p.smooth,
        "leap" => &mut p.leap,
        "hidden" => &mut p.hidden,
        _ => return Err(format!("there is no parameter {key}").into()),
    };
    *place = v;
    Ok(())
}

/// Shares of limbs at which points are taken, by what the limb's name begins with.
const ON_LIMBS: [(&str, &[f32]); 6] = [
    ("body", &[0.5]),
    ("neck", &[0.9]),
    ("tail", &[0.5, 0.92]),
    ("hind", &[0.5, 0.92]),
    ("fore", &[0.5, 0.92]),
    ("wing", &[0.5, 0.92]),
];

struct Case {
    clip: Clip,
    marks: PointMarks,
    truth: Truth,
    areas: Vec<Option<f32>>,
}

fn mask_area(folder: &Path, frame: usize) -> Option<f32> {
    let picture = image::open(folder.join("masks").join(format!("{frame:05}.png"))).ok()?.to_luma8();
    Some(picture.pixels().filter(|p| p.0[0] > 127).count() as f32)
}

impl Case {
    fn read(folder: &Path) -> Result<Self, AnyError> {
        let frames = ["frames", "rgba", "clip.mp4"].map(|n| folder.join(n)).into_iter().find(|p| p.exists());
        let clip = Clip::open(frames.ok_or("there is no clip")?)?;
        let own = folder.join("points-truth.json");
        let text = std::fs::read_to_string(if own.exists() { own } else { folder.join("truth.json") })?;
        let json: serde_json::Value = serde_json::from_str(&text)?;
        let (marks, truth) = if let Some(limbs) = json.get("limbs") {
            let (mut marks, mut truth) = (PointMarks::default(), Truth::new());
            marks.size = (clip.info().width, clip.info().height);
            for (limb, v) in limbs.as_object().ok_or("limbs")? {
                let axes: Vec<Vec<[f32; 3]>> = serde_json::from_value(v["axis"].clone())?;
                let Some((_, shares)) = ON_LIMBS.iter().find(|(n, _)| limb.starts_with(n)) else { continue };
                for share in *shares {
                    let name = format!("{limb} {share}");
                    for (f, axis) in axes.iter().enumerate().take(clip.info().frames) {
                        let [x, y, _] = axis[(share * (axis.len() - 1) as f32).round() as usize];
                        truth.entry(f).or_default().insert(name.clone(), vec2(x, y));
                        if f == 0 {
                            marks.put(&name, PointKey { frame: 0, at: vec2(x, y) });
                        }
                    }
                }
            }
            (marks, truth)
        } else {
            (PointMarks::read(folder.join("points.json"))?, serde_json::from_value(json["frames"].clone())?)
        };
        let areas =
            (0..clip.info().frames).map(|f| if truth.contains_key(&f) { mask_area(folder, f) } else { None }).collect();
        Ok(Self { clip, marks, truth, areas })
    }

    /// Marks every point on every so manieth frame on which its place is known.
    fn mark_every(&mut self, every: usize) {
        for (f, points) in self.truth.iter().filter(|t| every > 0 && t.0 % every == 0) {
            for (name, at) in points {
                if self.marks.point(name).is_some_and(|p| p.key(*f).is_none()) {
                    self.marks.put(name, PointKey { frame: *f, at: *at });
                }
            }
        }
    }

    /// Every place whose truth is known and that is no first key: frame, point, where it should be.
    fn places(&self) -> impl Iterator<Item = (usize, &PointMark, Vec2)> {
        self.truth.iter().flat_map(move |(f, points)| {
            points.iter().filter_map(move |(name, at)| {
                let mark = self.marks.point(name)?;
                mark.key(*f).is_none().then_some((*f, mark, *at))
            })
        })
    }

    fn errors(&self, motion: &Motion) -> Vec<(usize, String, f32, Vec2)> {
        let error = |(f, mark, at): (usize, &PointMark, Vec2)| {
            let place = motion.track(&mark.name).map_or(Vec2::INFINITY, |t| t.frames[f].points[0]);
            (f, mark.name.clone(), place.distance(at), at)
        };
        self.places().map(error).collect()
    }

    fn swaps(&self, motion: &Motion, within: f32) -> f32 {
        let (mut swaps, mut count) = (0, 0);
        for (f, mark, at) in self.places() {
            let Some(place) = motion.track(&mark.name).map(|t| t.frames[f].points[0]) else { continue };
            let on_another = self.truth[&f].iter().any(|(n, p)| *n != mark.name && p.distance(place) < within);
            count += 1;
            swaps += usize::from(on_another && place.distance(at) > within);
        }
        1000.0 * swaps as f32 / count.max(1) as f32
    }
}

fn main() -> Result<(), AnyError> {
    let mut sets = vec![(String::new(), PointParams::default())];
    let (mut folders, mut motions, mut within, mut most, mut every) = (Vec::new(), None, 8.0f32, 1000usize, 0usize);
    for arg in std::env::args().skip(1) {
        match arg.split_once('=') {
            Some(("motions", v)) => motions = Some(PathBuf::from(v)),
            Some(("within", v)) => within = v.parse()?,
            Some(("corrections", v)) => most = v.parse()?,
            Some(("every", v)) => every = v.parse()?,
            Some((key, v)) => {
                let last = sets.len() - 1;
                set(&mut sets[last].1, key, v.parse()?)?;
                sets[last].0 += &format!(" {arg}");
            }
            None if arg == "/" => sets.push((String::new(), PointParams::default())),
            None => folders.push(PathBuf::from(arg)),
        }
    }
    if folders.is_empty() {
        return Err("usage: point_eval FOLDER... [motions=FOLDER] [within=PIXELS] [PARAMETER=VALUE...]".into());
    }
    println!(
        "{:<18} {:>6} {:>6} {:>6} {:>6} {:>6} | {:>5} {:>5} {:>7} {:>6} | {:>6} {:>6} {:>6} {:>6}",
        "",
        "PCK20",
        "PCK05",
        "median",
        "swaps",
        "sure",
        "corr",
        "left",
        "a corr",
        "swaps",
        "read",
        "solve",
        "worst",
        "mean"
    );
    let mut means = vec![(0.0f32, 0.0f32, 0.0f32); sets.len()];
    for folder in &folders {
        let mut case = Case::read(folder)?;
        case.mark_every(every);
        let progress = Progress::new();
        let start = Instant::now();
        let mut solver = PointFootage::read(&case.clip, &sets[0].1, progress.whole())?;
        let read = start.elapsed().as_secs_f64();
        for (set_at, (label, params)) in sets.iter().enumerate() {
            solver.set_params(params);
            let start = Instant::now();
            let mut motion = solver.track(&case.marks, progress.whole())?;
            let first = start.elapsed().as_secs_f64();
            let errors = case.errors(&motion);
            let right = |share: f32| {
                let hits =
                    errors.iter().filter(|(f, _, e, _)| *e < share * case.areas[*f].unwrap_or(0.0).sqrt()).count();
                100.0 * hits as f32 / errors.len().max(1) as f32
            };
            let mut sorted: Vec<f32> = errors.iter().map(|e| e.2).collect();
            sorted.sort_by(f32::total_cmp);
            let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
            let trusted =
                |e: &&(usize, String, f32, Vec2)| motion.track(&e.1).is_some_and(|t| t.frames[e.0].confidence[0] > 0.5);
            let sure: Vec<_> = errors.iter().filter(trusted).collect();
            let wrong = 100.0 * sure.iter().filter(|e| e.2 > within).count() as f32 / sure.len().max(1) as f32;
            let swaps = case.swaps(&motion, within);
            if let Some(motions) = &motions {
                std::fs::create_dir_all(motions)?;
                let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
                std::fs::write(motions.join(format!("{name}.json")), motion.to_json())?;
            }
            let (pck20, pck05) = (right(0.2), right(0.05));
            let (mut corrections, mut marks, mut later) = (0, case.marks.clone(), Vec::new());
            let mut half = swaps;
            while corrections < most {
                let Some(worst) =
                    case.errors(&motion).into_iter().filter(|e| e.2 > within).max_by(|a, b| a.2.total_cmp(&b.2))
                else {
                    break;
                };
                marks.put(&worst.1, PointKey { frame: worst.0, at: worst.3 });
                corrections += 1;
                let start = Instant::now();
                motion = solver.track(&marks, progress.whole())?;
                later.push(start.elapsed().as_secs_f64());
                half = case.swaps(&motion, within);
            }
            let left = case.errors(&motion).iter().filter(|e| e.2 > within).count();
            let slowest = later.iter().copied().fold(0.0, f64::max);
            let mean = later.iter().sum::<f64>() / later.len().max(1) as f64;
            let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            println!(
                "{name:<18} {pck20:>6.1} {pck05:>6.1} {median:>6.1} {swaps:>6.1} {wrong:>6.1} | {corrections:>5} {left:>5} {:>7.1} {half:>6.1} | {read:>6.2} {first:>6.3} {slowest:>6.3} {mean:>6.3}{label}",
                errors.len() as f32 / corrections.max(1) as f32
            );
            means[set_at].0 += pck20;
            means[set_at].1 += pck05;
            means[set_at].2 += swaps;
        }
    }
    let n = folders.len() as f32;
    for ((label, _), m) in sets.iter().zip(&means) {
        println!("mean {:>6.1} {:>6.1} swaps {:>6.1} {label}", m.0 / n, m.1 / n, m.2 / n);
    }
    Ok(())
}
