//! Times a deformer on a mesh and the poses of its handles.
//!
//! `deform_eval MESH.obj HANDLES.json OUT.json`: for every pose ten steps and one step from rest, then the handles'
//! motion with four steps a frame, each from the shape before. Milliseconds of processor time, best of repeats.
#![expect(clippy::print_stderr, reason = "an example speaks to a person")]

use std::time::Instant;

use glam::Vec2;
use marey::deform::arap::{ArapDeformer, ArapMesh};
use marey::deform::{Deformation, Deformer, Handle, RestMesh};
use marey::job::Progress;

#[derive(serde::Deserialize)]
struct Case {
    handles: Vec<Placed>,
    poses: Vec<Pose>,
    #[serde(default)]
    drag: Vec<Vec<Vec2>>,
}

#[derive(serde::Deserialize)]
struct Placed {
    vertex: usize,
}

#[derive(serde::Deserialize)]
struct Pose {
    name: String,
    targets: Vec<Vec2>,
}

type Anything<T> = Result<T, Box<dyn std::error::Error>>;

fn read_obj(path: &str) -> Anything<(Vec<Vec2>, Vec<[u32; 3]>)> {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for line in std::fs::read_to_string(path)?.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut number = || words.next().ok_or("a vertex has two numbers")?.parse().map_err(|_| "not a number");
                points.push(Vec2::new(number()?, number()?));
            }
            Some("f") => {
                let mut index = || -> Anything<u32> {
                    let word = words.next().ok_or("a face has three corners")?;
                    Ok(word
                        .split('/')
                        .next()
                        .unwrap_or(word)
                        .parse::<u32>()?
                        .checked_sub(1)
                        .ok_or("corners count from 1")?)
                };
                triangles.push([index()?, index()?, index()?]);
            }
            _ => {}
        }
    }
    Ok((points, triangles))
}

/// Milliseconds of processor time that `work` takes.
fn time_of(work: impl FnOnce() -> Anything<()>) -> Anything<f64> {
    let now = || {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        1e3 * time.tv_sec as f64 + 1e-6 * time.tv_nsec as f64
    };
    let start = now();
    work()?;
    Ok(now() - start)
}

/// Runs `work` until it has taken long enough; the shortest time in milliseconds.
fn best_of(mut work: impl FnMut() -> Anything<()>) -> Anything<f64> {
    let (began, mut best, mut runs) = (Instant::now(), f64::INFINITY, 0);
    while runs < 5 || (runs < 200 && began.elapsed().as_secs_f64() < 0.6) {
        best = best.min(time_of(&mut work)?);
        runs += 1;
    }
    Ok(best)
}

fn main() -> Anything<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [mesh, handles, out] = &args[..] else {
        return Err("usage: deform_eval MESH.obj HANDLES.json OUT.json".into());
    };
    let (rest, triangles) = read_obj(mesh)?;
    let case: Case = serde_json::from_str(&std::fs::read_to_string(handles)?)?;
    let mesh = RestMesh { points: &rest, triangles: &triangles };
    let place = |h: &Placed| rest.get(h.vertex).map(|p| Handle::Point(*p)).ok_or("a handle names no vertex");
    let bound: Vec<Handle> = case.handles.iter().map(place).collect::<Result<_, _>>()?;
    let progress = Progress::new();
    let bind = |iterations| ArapDeformer { iterations }.bind(mesh, &bound, progress.whole());
    let precompute_ms = best_of(|| Ok(bind(10).map(|_| ())?))?;
    let prepared = ArapMesh::new(mesh, progress.whole())?;
    let rebind_ms = best_of(|| Ok(prepared.bind(&ArapDeformer::default(), &bound, progress.whole()).map(|_| ())?))?;
    let (mut one, mut ten, mut four) = (bind(1)?, bind(10)?, bind(4)?);
    let time = |deformation: &mut Box<dyn Deformation>, targets: &[Handle]| -> Anything<(f64, Vec<Vec2>)> {
        let mut shape = rest.clone();
        let ms = best_of(|| {
            shape.copy_from_slice(&rest);
            Ok(deformation.solve(targets, &mut shape, progress.whole())?)
        })?;
        Ok((ms, shape))
    };
    let mut poses = serde_json::Map::new();
    for pose in &case.poses {
        let targets: Vec<Handle> = pose.targets.iter().map(|p| Handle::Point(*p)).collect();
        let (iter1_ms, _) = time(&mut one, &targets)?;
        let (iter10_ms, shape) = time(&mut ten, &targets)?;
        eprintln!("{}: {iter10_ms:.3} ms", pose.name);
        poses.insert(
            pose.name.clone(),
            serde_json::json!({
                "iter10_ms": iter10_ms, "iter1_ms": iter1_ms, "per_iter_ms": (iter10_ms - iter1_ms) / 9.0,
                "V": shape.iter().map(|p| p.to_array()).collect::<Vec<_>>(),
            }),
        );
    }
    let mut shape = rest.clone();
    let mut drag_ms = Vec::new();
    for frame in &case.drag {
        let targets: Vec<Handle> = frame.iter().map(|p| Handle::Point(*p)).collect();
        drag_ms.push(time_of(|| Ok(four.solve(&targets, &mut shape, progress.whole())?))?);
    }
    let report = serde_json::json!({ "precompute_ms": precompute_ms, "rebind_ms": rebind_ms, "poses": poses, "drag_ms": drag_ms });
    std::fs::write(out, report.to_string())?;
    Ok(())
}
