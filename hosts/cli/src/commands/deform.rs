//! `marey deform MESH.obj HANDLES.json OUT.json`: what a deformer makes of a mesh, and how long it takes.

use std::path::Path;
use std::time::{Duration, Instant};

use marey_binding::{Deformation, Handle};
use serde_json::{Map, json};

use super::{Session, check_file};
use crate::args::Deform;
use crate::failure::{BAD_INPUT, FAILED, Failure};
use crate::say;

type Place = (f32, f32);

/// Work is repeated at least so often, and until it has taken so long.
const REPEATS: usize = 5;
const LONG_ENOUGH: Duration = Duration::from_millis(600);
const MOST_REPEATS: usize = 200;

#[derive(serde::Deserialize)]
struct Case {
    handles: Vec<Held>,
    poses: Vec<Pose>,
    #[serde(default)]
    drag: Vec<Vec<Place>>,
}

#[derive(serde::Deserialize)]
struct Held {
    vertex: usize,
}

#[derive(serde::Deserialize)]
struct Pose {
    name: String,
    targets: Vec<Place>,
}

pub(crate) fn deform(session: &Session, args: &Deform) -> Result<(), Failure> {
    check_file(&args.output)?;
    session.plugins_for(&args.plugins, &[&args.deformer])?;
    let (rest, triangles) = read_mesh(&args.mesh)?;
    let case: Case = serde_json::from_str(&read(&args.handles)?).map_err(|e| bad(&args.handles, &e.to_string()))?;
    let place = |held: &Held| {
        let none =
            || bad(&args.handles, &format!("a handle names vertex {}, and there are {}", held.vertex, rest.len()));
        rest.get(held.vertex).copied().map(Handle::Point).ok_or_else(none)
    };
    let handles = case.handles.iter().map(place).collect::<Result<Vec<_>, _>>()?;
    let bind = |steps| Ok(session.context.bind_mesh(&rest, &triangles, &handles, &args.deformer, steps)?);
    let precompute_ms = best_of(|| bind(10).map(drop))?;
    let (one, ten, four) = (bind(1)?, bind(10)?, bind(4)?);

    let mut poses = Map::new();
    for pose in &case.poses {
        session.interrupt.check()?;
        let (iter1_ms, _) = pose_of(&one, &rest, &pose.targets)?;
        let (iter10_ms, shape) = pose_of(&ten, &rest, &pose.targets)?;
        let found = json!({
            "iter10_ms": iter10_ms,
            "iter1_ms": iter1_ms,
            "per_iter_ms": (iter10_ms - iter1_ms) / 9.0,
            "V": shape,
        });
        poses.insert(pose.name.clone(), found);
    }
    let (mut shape, mut drag_ms) = (rest.clone(), Vec::new());
    for targets in &case.drag {
        session.interrupt.check()?;
        let targets = points(targets);
        let began = now();
        four.solve(&targets, &mut shape)?;
        drag_ms.push(now() - began);
    }
    let report = json!({ "precompute_ms": precompute_ms, "poses": poses, "drag_ms": drag_ms });
    std::fs::write(&args.output, report.to_string())
        .map_err(|e| Failure::new(FAILED, format!("{}: cannot be written: {e}", args.output.display())))?;
    if session.json {
        let report = json!({ "command": "deform", "output": args.output, "precompute_ms": precompute_ms });
        say::line(&report.to_string());
        return Ok(());
    }
    say::line(&format!("{}: bound in {precompute_ms:.2} ms", args.output.display()));
    let times = report["poses"].as_object().into_iter().flatten();
    times.for_each(|(name, pose)| say::line(&format!("  {name}: {:.3} ms", pose["iter10_ms"].as_f64().unwrap_or(0.0))));
    Ok(())
}

fn points(places: &[Place]) -> Vec<Handle> {
    places.iter().copied().map(Handle::Point).collect()
}

/// The shape of a pose from rest, and the milliseconds it takes.
fn pose_of(deformation: &Deformation, rest: &[Place], targets: &[Place]) -> Result<(f64, Vec<Place>), Failure> {
    let (mut shape, targets) = (rest.to_vec(), points(targets));
    let ms = best_of(|| {
        shape.copy_from_slice(rest);
        Ok(deformation.solve(&targets, &mut shape)?)
    })?;
    Ok((ms, shape))
}

/// The shortest time of several, in milliseconds.
fn best_of(mut work: impl FnMut() -> Result<(), Failure>) -> Result<f64, Failure> {
    let (began, mut best, mut runs) = (Instant::now(), f64::INFINITY, 0);
    while runs < REPEATS || (runs < MOST_REPEATS && began.elapsed() < LONG_ENOUGH) {
        let start = now();
        work()?;
        best = best.min(now() - start);
        runs += 1;
    }
    Ok(best)
}

/// Milliseconds of processor time of this program; of the clock where the system does not tell.
fn now() -> f64 {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        1e3 * time.tv_sec as f64 + 1e-6 * time.tv_nsec as f64
    }
    #[cfg(not(unix))]
    {
        use std::sync::OnceLock;
        static BEGAN: OnceLock<Instant> = OnceLock::new();
        1e3 * BEGAN.get_or_init(Instant::now).elapsed().as_secs_f64()
    }
}

fn bad(path: &Path, problem: &str) -> Failure {
    Failure::new(BAD_INPUT, format!("{}: {problem}", path.display()))
}

fn read(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|e| bad(path, &format!("cannot be read: {e}")))
}

/// The vertices and triangles of an OBJ file; larger faces are cut into fans.
fn read_mesh(path: &Path) -> Result<(Vec<Place>, Vec<[u32; 3]>), Failure> {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for (number, line) in read(path)?.lines().enumerate() {
        let wrong = |what: &str| bad(path, &format!("line {}: {what}", number + 1));
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut coordinate = || words.next().and_then(|w| w.parse().ok());
                points.push(coordinate().zip(coordinate()).ok_or_else(|| wrong("a vertex is two numbers or more"))?);
            }
            Some("f") => {
                let corner = |word: &str| {
                    let index =
                        word.split('/').next().and_then(|w| w.parse::<u32>().ok()).and_then(|i| i.checked_sub(1));
                    index.ok_or_else(|| wrong("a face is of vertices that count from 1"))
                };
                let corners = words.map(corner).collect::<Result<Vec<u32>, _>>()?;
                let Some((&first, rest)) = corners.split_first() else { return Err(wrong("a face has no corners")) };
                triangles.extend(rest.windows(2).map(|pair| [first, pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    Ok((points, triangles))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_read_and_what_is_none_is_said_with_its_line() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("mesh.obj");
        let read = |text: &str| {
            std::fs::write(&path, text).expect("written");
            read_mesh(&path).map_err(|e| e.message)
        };
        let (points, triangles) = read("# a square\nv 0 0 0\nv 1 0\nv 1 1\nv 0 1\nf 1/1 2/2/2 3 4\n").expect("a mesh");
        assert_eq!((points.len(), triangles), (4, vec![[0, 1, 2], [0, 2, 3]]));
        for (text, said) in
            [("v 0\n", "line 1"), ("v 0 0\nf 0 1 2\n", "line 2"), ("f\n", "line 1"), ("v x y", "line 1")]
        {
            assert!(read(text).expect_err(text).contains(said), "{text}");
        }
    }
}
