//! Measures the needle deformer on a mesh and the poses of its skeleton.
//!
//! `needle_eval MESH.obj SKELETON.json [off|reciprocal|exact]`: milliseconds to bind; per pose the errors of the area, in
//! total and per triangle, turned triangles after each stage, steps of the joint areas, and milliseconds.
//!
//! `needle_eval MESH.obj SKELETON.json drag`: every joint is dragged through 60 frames, each from the shape before: `turn`
//! swings it about its parent by up to 60 degrees with all that hangs below it, `carry` moves it round a circle with what
//! hangs below, `alone` moves it round the circle while all other joints stay. Per drag milliseconds of processor time on one
//! thread, turned triangles, steps, and how far the shape is from one that is solved for from rest, in pixels of a figure
//! 512 high.
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
    let began = std::time::Instant::now();
    let mut needles = Needles::new(&deformer, rest_mesh, &bones(&case.joints), progress.whole())?;
    println!("bound in {:.1} ms", 1e3 * began.elapsed().as_secs_f64());
    let areas = |p: &[Vec2]| -> Vec<f64> {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| p[v as usize].as_dvec2());
            0.5 * (b - a).perp_dot(c - a)
        };
        triangles.iter().map(area).collect()
    };
    if rest.first().map(String::as_str) == Some("drag") {
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        return Ok(one.install(|| drag(&case, rest_mesh, &deformer))?);
    }
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

/// Milliseconds of processor time of this process.
fn processor_time() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    1e3 * now.tv_sec as f64 + 1e-6 * now.tv_nsec as f64
}

type Joints = BTreeMap<String, Vec2>;

const FRAMES: usize = 60;

/// The joints in a frame of a drag of `joint`, with those that hang `below` it. A root has nothing to swing about, and
/// carries all.
fn dragged(case: &Case, how: &str, joint: &str, below: &[&str], frame: usize) -> Option<Joints> {
    let mut joints = case.joints.clone();
    let parent = case.bones.iter().find(|(_, b)| b == joint).map(|(a, _)| case.joints[a]);
    let phase = (frame + 1) as f32 / FRAMES as f32 * std::f32::consts::TAU;
    let mut place = |name: &str, map: &dyn Fn(Vec2) -> Vec2| joints.insert(name.to_owned(), map(case.joints[name]));
    if how == "turn" {
        let (pivot, turn) = (parent?, Vec2::from_angle(phase.sin() * std::f32::consts::FRAC_PI_3));
        for name in below.iter().chain([&joint]) {
            place(name, &|p| pivot + turn.rotate(p - pivot));
        }
        return Some(joints);
    }
    let own = case.bones.iter().filter(|(a, b)| a == joint || b == joint);
    let shortest = own.map(|(a, b)| case.joints[a].distance(case.joints[b])).fold(f32::MAX, f32::min);
    let shift = 0.15 * shortest * (Vec2::from_angle(phase) - Vec2::X);
    place(joint, &|p| p + shift);
    if how == "carry" {
        parent?;
        for name in below {
            place(name, &|p| p + shift);
        }
    }
    Some(joints)
}

fn drag(case: &Case, mesh: RestMesh<'_>, deformer: &NeedleDeformer) -> marey::error::Result<()> {
    let progress = Progress::new();
    let bones = |joints: &Joints| -> Vec<Handle> {
        case.bones.iter().map(|(a, b)| Handle::Bone(joints[a], joints[b])).collect()
    };
    let turned = |p: &[Vec2]| {
        let area = |p: &[Vec2], t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| p[v as usize]);
            (b - a).perp_dot(c - a)
        };
        mesh.triangles.iter().filter(|t| area(p, t) * area(mesh.points, t) <= 0.0).count()
    };
    let high = mesh.points.iter().fold((f32::MAX, f32::MIN), |r, p| (r.0.min(p.y), r.1.max(p.y)));
    let wide = mesh.points.iter().fold((f32::MAX, f32::MIN), |r, p| (r.0.min(p.x), r.1.max(p.x)));
    let pixels = 512.0 / (high.1 - high.0).max(wide.1 - wide.0);
    let mut needles = Needles::new(deformer, mesh, &bones(&case.joints), progress.whole())?;
    let mut anew = Needles::new(deformer, mesh, &bones(&case.joints), progress.whole())?;
    for how in ["turn", "carry", "alone"] {
        for joint in case.joints.keys() {
            let mut below: Vec<&str> = vec![joint];
            for (a, b) in &case.bones {
                if below.contains(&a.as_str()) {
                    below.push(b);
                }
            }
            let frames: Vec<Joints> = (0..FRAMES).filter_map(|f| dragged(case, how, joint, &below[1..], f)).collect();
            if frames.is_empty() {
                continue;
            }
            let mut times = vec![f64::INFINITY; frames.len()];
            let (mut folds, mut steps, mut most, mut apart) = (0, 0, 0, 0f32);
            for repeat in 0..3 {
                let mut shape = mesh.points.to_vec();
                needles.solve(&bones(&case.joints), &mut shape, progress.whole())?;
                for (joints, time) in frames.iter().zip(&mut times) {
                    let targets = bones(joints);
                    let began = processor_time();
                    needles.solve(&targets, &mut shape, progress.whole())?;
                    *time = time.min(processor_time() - began);
                    if repeat == 0 {
                        folds += turned(&shape);
                        steps += needles.settled().iterations();
                        most = most.max(needles.settled().iterations());
                        let mut cold = mesh.points.to_vec();
                        anew.solve(&targets, &mut cold, progress.whole())?;
                        folds += turned(&cold);
                        apart = shape.iter().zip(&cold).map(|(a, b)| a.distance(*b) * pixels).fold(apart, f32::max);
                    }
                }
            }
            times.sort_unstable_by(f64::total_cmp);
            println!(
                "{how:5} {joint:5} {:5.2} ms, {:5.2} at most, turned {folds}, steps {:.1}, {most} at most, {apart:.2} px apart",
                times[FRAMES / 2],
                times[FRAMES - 1],
                steps as f64 / FRAMES as f64,
            );
        }
    }
    Ok(())
}
