//! Measures the stroke-preserving deformer on meshes with handles and strokes.
//!
//! `stroke_eval CASE...`: folders with `mesh.obj`, `handles.json` and `strokes.json`. Per pose the distortion of the
//! strokes, in percent: edges' lengths (root mean square), and places after the best rigid motion, of the stroke's length;
//! as rigid as possible alone, then with all strokes of rigidity 1, then with every second one, those and the others
//! apart. Then Newton steps until the energy is within 1 % of the least that 3,000 steps find, at rigidities from 0.1 to
//! 1,000, from the shape at rest and from the shape without rigidity (a slider that jumps), with milliseconds of processor
//! time. At last the milliseconds of a frame of the handles'
//! motion and of a slider's, with the case's strokes and with 16 others.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::path::Path;

use glam::{DVec2, Vec2};
use marey::deform::stroke_preserving::{BoundStrokes, Effort, Layer, Line, Shape, StrokeMesh};
use marey::job::Progress;

#[derive(serde::Deserialize)]
struct Handles {
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

#[derive(serde::Deserialize)]
struct Strokes {
    strokes: Vec<Vec<Vec2>>,
}

type Anything<T> = Result<T, Box<dyn std::error::Error>>;

/// Cases are shown as pixels of a figure so high.
const HIGH: f32 = 512.0;

struct Case {
    points: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    strokes: Vec<Vec<Vec2>>,
    handles: Vec<(usize, Vec2)>,
    poses: Vec<Pose>,
    drag: Vec<Vec<Vec2>>,
}

impl Case {
    fn read(folder: &Path) -> Anything<Self> {
        let text = |name: &str| std::fs::read_to_string(folder.join(name));
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for line in text("mesh.obj")?.lines() {
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
        let Handles { handles, mut poses, mut drag } = serde_json::from_str(&text("handles.json")?)?;
        let Strokes { mut strokes } = serde_json::from_str(&text("strokes.json")?)?;
        let low = points.iter().copied().fold(Vec2::MAX, Vec2::min);
        let scale = HIGH / (points.iter().copied().fold(Vec2::MIN, Vec2::max) - low).max_element();
        let all = poses.iter_mut().map(|p| &mut p.targets).chain(&mut drag).chain(&mut strokes);
        all.flatten().chain(&mut points).for_each(|p| *p = (*p - low) * scale);
        let handles = handles.iter().map(|h| (0, points[h.vertex])).collect();
        Ok(Self { points, triangles, strokes, handles, poses, drag })
    }

    fn bind(&self, rigidity: impl Fn(usize) -> f32) -> Anything<BoundStrokes> {
        let line = |(i, s): (usize, &Vec<Vec2>)| {
            let closed = s.len() > 2 && s[0] == s[s.len() - 1];
            Line { points: s.clone(), closed, rigidity: rigidity(i) }
        };
        let lines = self.strokes.iter().enumerate().map(line).collect();
        let layer = Layer { points: self.points.clone(), triangles: self.triangles.clone(), lines };
        let progress = Progress::new();
        let mesh = StrokeMesh::new(&[layer], &[], progress.whole())?;
        Ok(mesh.bind(&self.handles, progress.whole())?)
    }
}

/// Root mean squares in percent: of edges' lengths, and of places after the best rigid motion over the length.
fn distortion(rest: &[Vec2], now: &[Vec2]) -> (f64, f64) {
    let wide = |s: &[Vec2]| -> Vec<DVec2> { s.iter().map(|p| p.as_dvec2()).collect() };
    let (a, b) = (wide(rest), wide(now));
    let n = a.len() as f64;
    let (am, bm) = (a.iter().sum::<DVec2>() / n, b.iter().sum::<DVec2>() / n);
    let pairs = || a.iter().zip(&b).map(|(a, b)| (*a - am, *b - bm));
    let turn = pairs().map(|(a, b)| DVec2::new(a.dot(b), a.perp_dot(b))).sum::<DVec2>().normalize_or(DVec2::X);
    let off = (pairs().map(|(a, b)| turn.rotate(a).distance_squared(b)).sum::<f64>() / n).sqrt();
    let lengths = |s: &[DVec2]| -> Vec<f64> { s.windows(2).map(|w| w[0].distance(w[1])).collect() };
    let (la, lb) = (lengths(&a), lengths(&b));
    let kept: Vec<f64> = la.iter().zip(&lb).filter(|(a, _)| **a > 0.0).map(|(a, b)| (b / a - 1.0).powi(2)).collect();
    (100.0 * (kept.iter().sum::<f64>() / kept.len() as f64).sqrt(), 100.0 * off / la.iter().sum::<f64>())
}

/// Milliseconds of processor time of this thread.
fn processor_time() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    1e3 * now.tv_sec as f64 + 1e-6 * now.tv_nsec as f64
}

fn median(mut of: Vec<f64>) -> f64 {
    of.sort_unstable_by(f64::total_cmp);
    of[of.len() / 2]
}

fn solved(bound: &mut BoundStrokes, targets: &[Vec2], from: &Shape) -> Anything<Shape> {
    let mut shape = from.clone();
    bound.solve(targets, &mut shape, Progress::new().whole())?;
    Ok(shape)
}

fn show(case: &Case, shape: &Shape, which: impl Fn(usize) -> bool) -> String {
    let all: Vec<(f64, f64)> = (0..case.strokes.len())
        .filter(|i| which(*i))
        .map(|i| distortion(&case.strokes[i], &shape.lines[0][i]))
        .collect();
    let mean = |of: fn(&(f64, f64)) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
    let turned = |p: &[Vec2], t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| p[v as usize]);
        (b - a).perp_dot(c - a)
    };
    let turned = case.triangles.iter().filter(|t| turned(&shape.points[0], t) * turned(&case.points, t) <= 0.0).count();
    let worst = all.iter().map(|d| d.0).fold(0.0, f64::max);
    format!("edges {:5.2} (worst {worst:5.2}) places {:.3} turned {turned}", mean(|d| d.0), mean(|d| d.1))
}

/// 16 arcs of 20 points all over the mesh.
fn arcs(points: &[Vec2]) -> Vec<Vec<Vec2>> {
    let arc = |k: usize| {
        let middle = points[k * points.len() / 16];
        (0..20).map(|i| middle + HIGH / 20.0 * Vec2::from_angle(k as f32 + 0.2 * i as f32)).collect()
    };
    (0..16).map(arc).collect()
}

/// The handles' motion, and a slider that moves by a tenth in every frame.
fn motion(case: &Case) -> Anything<()> {
    let mut bound = case.bind(|_| 1.0)?;
    for name in ["motion", "slider"] {
        let mut shape = bound.rest();
        let (mut times, mut steps, mut rigidity) = (Vec::new(), 0, 1.0);
        if let ("slider", Some(pose)) = (name, case.poses.first()) {
            bound.solve(&pose.targets, &mut shape, Progress::new().whole())?;
        }
        for frame in &case.drag {
            let began = processor_time();
            let mut targets = frame;
            if let ("slider", Some(pose)) = (name, case.poses.first()) {
                targets = &pose.targets;
                rigidity = f32::min(1.1 * rigidity, 1000.0);
                bound.set_rigidity(0, 0, rigidity)?;
            }
            bound.solve(targets, &mut shape, Progress::new().whole())?;
            times.push(processor_time() - began);
            steps += bound.settled().iterations();
        }
        if !times.is_empty() {
            let most = times.iter().copied().fold(0.0, f64::max);
            let mean = steps as f64 / times.len() as f64;
            let strokes = case.strokes.len();
            println!(
                "{name} of {strokes} strokes: {:.2} ms a frame, {most:.2} at most, {mean:.1} steps",
                median(times)
            );
        }
    }
    Ok(())
}

fn main() -> Anything<()> {
    let folders: Vec<String> = std::env::args().skip(1).collect();
    if folders.is_empty() {
        return Err("usage: stroke_eval CASE...".into());
    }
    for folder in &folders {
        let mut case = Case::read(Path::new(folder))?;
        let began = processor_time();
        case.bind(|_| 1.0)?;
        println!(
            "{folder}: {} vertices, {} strokes, bound in {:.1} ms",
            case.points.len(),
            case.strokes.len(),
            processor_time() - began
        );
        for pose in &case.poses {
            let targets = &pose.targets;
            let mut plain = case.bind(|_| 0.0)?;
            let rest = plain.rest();
            let long = Effort { steps: 3000, tolerance: 0.0 };
            plain.set_effort(long);
            let flat = solved(&mut plain, targets, &rest)?;
            println!("{:8} plain    {}", pose.name, show(&case, &flat, |_| true));
            let mut bound = case.bind(|_| 1.0)?;
            let shape = solved(&mut bound, targets, &rest)?;
            println!("{:8} all      {}", pose.name, show(&case, &shape, |_| true));
            let mut some = case.bind(|i| f32::from(i % 2 == 1))?;
            let shape = solved(&mut some, targets, &rest)?;
            println!("{:8} tagged   {}", pose.name, show(&case, &shape, |i| i % 2 == 1));
            println!("{:8} others   {}", pose.name, show(&case, &shape, |i| i % 2 == 0));
            println!("{:8}  (plain) {}", pose.name, show(&case, &flat, |i| i % 2 == 0));
            for rigidity in [0.1, 1.0, 10.0, 100.0, 1000.0] {
                let mut bound = case.bind(|_| rigidity)?;
                bound.set_effort(long);
                let exact = solved(&mut bound, targets, &rest)?;
                let least = bound.settled().energies.last().copied().unwrap_or(0.0);
                let slid_exact = solved(&mut bound, targets, &flat)?;
                let slid_least = bound.settled().energies.last().copied().unwrap_or(0.0);
                let least = least.min(slid_least);
                bound.set_effort(Effort::default());
                let steps = |bound: &BoundStrokes| {
                    let energies = &bound.settled().energies;
                    let needed = energies.iter().position(|e| *e <= 1.01 * least);
                    needed.map_or(format!("> {}", energies.len() - 1), |n| n.to_string())
                };
                let mut out = format!("{:8} {rigidity:6}  ", pose.name);
                for (name, from) in [("rest", &rest), ("slider", &flat)] {
                    let mut times = Vec::new();
                    let mut shape = from.clone();
                    for _ in 0..3 {
                        // A slider comes from elsewhere; at rest, everything is ready.
                        if name == "slider" {
                            (0..case.strokes.len()).try_for_each(|line| bound.set_rigidity(0, line, 0.0))?;
                            solved(&mut bound, targets, &flat)?;
                        }
                        (0..case.strokes.len()).try_for_each(|line| bound.set_rigidity(0, line, rigidity))?;
                        let began = processor_time();
                        shape = solved(&mut bound, targets, from)?;
                        times.push(processor_time() - began);
                    }
                    let far = shape.points[0].iter().zip(&exact.points[0]).map(|(a, b)| a.distance(*b));
                    let best = times.iter().copied().fold(f64::INFINITY, f64::min);
                    out += &format!(
                        "{name} {} of {} steps, {best:.1} ms, {:.2} px off; ",
                        steps(&bound),
                        bound.settled().iterations(),
                        far.fold(0.0, f32::max)
                    );
                }
                println!("{out}{} {least:.4} {slid_least:.4}", show(&case, &slid_exact, |_| true));
            }
        }
        motion(&case)?;
        case.strokes = arcs(&case.points);
        motion(&case)?;
    }
    Ok(())
}
