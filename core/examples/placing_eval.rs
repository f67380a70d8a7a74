//! Finds objects in clips from their control points and places the points on drawings; says how well.
//!
//! `placing_eval CASES.json [OUT_FOLDER]`. A case is `{"name", "clip", "frame", "points": [[x,y],..], "mask": image of the
//! object, "outline": [[x,y],..], "mirror": bool, "truth": {"0": [[x,y],..]}}`: all but name, clip, frame and points may be
//! missing. A point of the truth may have several right places. The out folder gets each case's mask and places.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::Vec2;
use marey::clip::Clip;
use marey::job::Progress;
use marey::raster::Mask;
use marey::segment::grab_cut::{object_contour, object_mask};
use marey::shape::sketch::{ObjectShape, Placing, place_points};

#[derive(serde::Deserialize)]
struct Case {
    name: String,
    clip: PathBuf,
    frame: usize,
    points: Vec<Vec2>,
    mask: Option<PathBuf>,
    #[serde(default)]
    outline: Vec<Vec2>,
    mirror: Option<bool>,
    #[serde(default)]
    truth: BTreeMap<usize, Vec<Vec2>>,
}

/// Errors of one way of placing, over all cases.
#[derive(Default)]
struct Errors {
    all: Vec<f32>,
    wrong_ways: usize,
    trusted: Vec<(f32, f32)>,
}

impl Errors {
    fn add(&mut self, case: &Case, placed: &Placing) -> String {
        let (low, high) = marey::geometry::polygon::extent(&case.outline).unwrap_or_default();
        let height = (high - low).y;
        let own: Vec<f32> = case
            .truth
            .iter()
            .map(|(i, right)| {
                let away = right.iter().map(|r| r.distance(placed.places[*i])).fold(f32::INFINITY, f32::min);
                self.trusted.push((placed.confidence[*i], away / height));
                away / height
            })
            .collect();
        let wrong = case.mirror.is_some_and(|m| m != placed.mirror);
        self.wrong_ways += usize::from(wrong);
        self.all.extend(&own);
        format!("{}{}", summary(&own), if wrong { " WRONG WAY" } else { "" })
    }
}

fn summary(errors: &[f32]) -> String {
    let count = errors.len().max(1) as f32;
    let near = errors.iter().filter(|e| **e < 0.1).count() as f32;
    format!("{:5.1} % {:3.0} %", 100.0 * errors.iter().sum::<f32>() / count, 100.0 * near / count)
}

fn mask_of(path: &Path) -> Result<Mask, Box<dyn std::error::Error>> {
    Ok(Mask::from_image(&image::open(path)?.to_luma8()))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [cases, out @ ..] = &args[..] else { return Err("usage: placing_eval CASES.json [OUT_FOLDER]".into()) };
    let cases: Vec<Case> = serde_json::from_str(&std::fs::read_to_string(cases)?)?;
    let progress = Progress::new();
    let mut errors: [Errors; 5] = Default::default();
    let (mut ious, mut milliseconds) = (Vec::new(), Vec::new());
    println!("IoU of the object; then mean error as a share of the drawing's height and share within a tenth of it:");
    println!("with the true contour and way | true contour | found contour | points alone, true way | points alone");
    for case in &cases {
        let picture = Clip::open(&case.clip)?.frame(case.frame)?;
        let began = Instant::now();
        let mask = object_mask(&picture, &case.points, &[], progress.whole())?;
        let cutting = began.elapsed().as_secs_f64() * 1e3;
        let mut line = format!("{:40} {cutting:4.0} ms", case.name);
        let truth = case.mask.as_deref().map(mask_of).transpose()?;
        if let Some(truth) = &truth {
            ious.push(mask.iou(truth));
            line += &format!(" IoU {:.3}", mask.iou(truth));
        }
        if let Some(folder) = out.first() {
            std::fs::create_dir_all(folder)?;
            mask.to_image().save(Path::new(folder).join(format!("{}.png", case.name)))?;
        }
        if !case.outline.is_empty() {
            let (found, exact) = (object_contour(&mask), truth.as_ref().map(object_contour).unwrap_or_default());
            let ways = [
                (ObjectShape::Contour(&exact), case.mirror),
                (ObjectShape::Contour(&exact), None),
                (ObjectShape::Contour(&found), None),
                (ObjectShape::Points(&[]), case.mirror),
                (ObjectShape::Points(&[]), None),
            ];
            for (errors, (shape, mirror)) in errors.iter_mut().zip(ways) {
                let began = Instant::now();
                let placed = place_points(shape, &case.points, &case.outline, mirror, progress.whole())?;
                milliseconds.push(began.elapsed().as_secs_f64() * 1e3);
                line += &format!(" | {}", errors.add(case, &placed));
                if let (Some(folder), None) = (out.first(), mirror) {
                    let name = if matches!(shape, ObjectShape::Points(_)) { "points" } else { "contour" };
                    let text = serde_json::to_string(&placed.places)?;
                    std::fs::write(Path::new(folder).join(format!("{}-{name}.json", case.name)), text)?;
                }
            }
        }
        println!("{line}");
    }
    println!("mean IoU {:.3}", ious.iter().sum::<f64>() / ious.len().max(1) as f64);
    milliseconds.sort_by(f64::total_cmp);
    println!("placing: median {:.0} ms", milliseconds.get(milliseconds.len() / 2).copied().unwrap_or(0.0));
    for (name, errors) in
        ["true contour and way", "true contour", "found contour", "points, true way", "points"].iter().zip(&mut errors)
    {
        errors.trusted.sort_by(|a, b| b.0.total_cmp(&a.0));
        let half = errors.trusted.len() / 2;
        let mean = |part: &[(f32, f32)]| 100.0 * part.iter().map(|t| t.1).sum::<f32>() / part.len().max(1) as f32;
        println!(
            "{name:22} {} wrong way {}; trusted half {:.1} %, the other {:.1} %",
            summary(&errors.all),
            errors.wrong_ways,
            mean(&errors.trusted[..half]),
            mean(&errors.trusted[half..])
        );
    }
    Ok(())
}
