//! Measures the needle deformer on a mesh and the poses of its skeleton.
//!
//! `needle_eval MESH.obj SKELETON.json [off|reciprocal|exact]`: per pose the errors of the area, in total and per triangle,
//! turned triangles after each stage, steps of the joint areas, and milliseconds.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::collections::BTreeMap;

use glam::Vec2;
use marey::deform::needles::{AreaRule, NeedleDeformer, Needles};
use marey::deform::{Deformation, Handle, RestMesh};
use marey::job::Progress;

#[derive(serde::Deserialize)]
struct Case {
    joints: BTreeMap<String, Vec2>,
    bones: Vec<(String, String)>,
    poses: Vec<Pose>,
}

#[derive(serde::Deserialize)]
struct Pose {
    name: String,
    joints: BTreeMap<String, Vec2>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [mesh, skeleton, rest @ ..] = &args[..] else {
        return Err("usage: needle_eval MESH.obj SKELETON.json [off|reciprocal|exact]".into());
    };
    let area = match rest.first().map(String::as_str) {
        Some("off") => AreaRule::Off,
        Some("reciprocal") => AreaRule::Reciprocal,
        _ => AreaRule::Exact,
    };
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for line in std::fs::read_to_string(mesh)?.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["v", x, y, ..] => points.push(Vec2::new(x.parse()?, y.parse()?)),
            ["f", a, b, c] => {
                let index = |w: &str| w.split('/').next().unwrap_or(w).parse::<u32>().map(|i| i.wrapping_sub(1));
                triangles.push([index(a)?, index(b)?, index(c)?]);
            }
            _ => {}
        }
    }
    let case: Case = serde_json::from_str(&std::fs::read_to_string(skeleton)?)?;
    let bones = |joints: &BTreeMap<String, Vec2>| -> Vec<Handle> {
        case.bones.iter().map(|(a, b)| Handle::Bone(joints[a], joints[b])).collect()
    };
    let progress = Progress::new();
    let deformer = NeedleDeformer { area, ..NeedleDeformer::default() };
    let rest_mesh = RestMesh { points: &points, triangles: &triangles };
    let mut needles = Needles::new(&deformer, rest_mesh, &bones(&case.joints), progress.whole())?;
    let areas = |p: &[Vec2]| -> Vec<f64> {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| p[v as usize].as_dvec2());
            0.5 * (b - a).perp_dot(c - a)
        };
        triangles.iter().map(area).collect()
    };
    let before = areas(&points);
    let total: f64 = before.iter().sum();
    for pose in &case.poses {
        let targets = bones(&pose.joints);
        let first = areas(&needles.stage_one(&targets)?);
        let mut shape = points.clone();
        let began = std::time::Instant::now();
        needles.solve(&targets, &mut shape, progress.whole())?;
        let ms = 1e3 * began.elapsed().as_secs_f64();
        let after = areas(&shape);
        let error = |a: &[f64]| {
            let squares: f64 = a.iter().zip(&before).map(|(a, b)| b / total * (a / b - 1.0).powi(2)).sum();
            (100.0 * (a.iter().sum::<f64>() / total - 1.0).abs(), 100.0 * squares.sqrt())
        };
        let turned = |a: &[f64]| a.iter().zip(&before).filter(|(a, b)| *a * *b <= 0.0).count();
        let (one, two) = (error(&first), error(&after));
        let areas = &needles.settled().areas;
        let bent: Vec<usize> = areas.iter().map(|a| a.iterations).filter(|n| *n > 0).collect();
        println!(
            "{:8} area {:.2} -> {:.2} %, per triangle {:.1} -> {:.1} %, turned {} -> {}, steps {:.1} on average, {} at most, {ms:.2} ms",
            pose.name,
            one.0,
            two.0,
            one.1,
            two.1,
            turned(&first),
            turned(&after),
            bent.iter().sum::<usize>() as f64 / bent.len().max(1) as f64,
            needles.settled().iterations(),
        );
    }
    Ok(())
}
