//! Animates a drawing, times it, and measures what becomes of its strokes.
//!
//! `sketch_eval DRAWING.svg OUT [BIND.json MOTION.json...]`: frames of the take as pictures in the folder OUT, with the
//! mesh and the control points, and numbers. Without a binding, control points are spread over the drawing and swung by
//! sines whose phases differ.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use glam::Vec2;
use image::{Rgba, RgbaImage};
use kurbo::{ParamCurve, ParamCurveArclen};
use marey::job::Progress;
use marey::motion::{Motion, Track, TrackFrame, TrackKind};
use marey::shape::sketch::{BindPoint, Binding, Drawing, Sketch, SketchCanvas, SketchParams, SketchTake, draw_sketch};

type Anything<T> = Result<T, Box<dyn std::error::Error>>;

/// Milliseconds of processor time.
fn now() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    1e3 * time.tv_sec as f64 + 1e-6 * time.tv_nsec as f64
}

/// Control points as far from one another as may be, each swung by sines.
fn swung(drawing: &Drawing, count: usize, frames: usize) -> (Binding, Motion) {
    let places: Vec<Vec2> = drawing.strokes.iter().flat_map(|s| s.flatten(0.5)).flatten().collect();
    let size = drawing.bounds().map_or(1.0, |b| b.width().hypot(b.height())) as f32;
    let mut chosen: Vec<Vec2> = places.first().copied().into_iter().collect();
    while chosen.len() < count {
        let gap = |p: &Vec2| chosen.iter().map(|c| c.distance(*p)).fold(f32::INFINITY, f32::min);
        let Some(far) = places.iter().max_by(|a, b| gap(a).total_cmp(&gap(b))) else { break };
        chosen.push(*far);
    }
    let track = |(i, at): (usize, &Vec2)| {
        let place = |t: usize| {
            let phase = std::f32::consts::TAU * t as f32 / 24.0;
            let way = Vec2::new(
                (phase + 1.7 * i as f32).sin() - (1.7 * i as f32).sin(),
                (phase + 2.9 * i as f32).cos() - (2.9 * i as f32).cos(),
            );
            *at + 0.045 * size * way
        };
        let frames = (0..frames).map(|t| TrackFrame::certain(vec![place(t)])).collect();
        Track { name: format!("p{i}"), kind: TrackKind::Point, frames }
    };
    let tracks: Vec<Track> = chosen.iter().enumerate().map(track).collect();
    let point = |(i, at): (usize, &Vec2)| BindPoint { track: format!("p{i}"), at: *at, ..BindPoint::default() };
    let binding = Binding { points: chosen.iter().enumerate().map(point).collect(), ..Binding::default() };
    (binding, Motion { size: (1, 1), fps: 24.0, frames, tracks, bones: Vec::new() })
}

/// Points along every segment of a path.
fn along(path: &kurbo::BezPath) -> Vec<Vec2> {
    let points = path.segments().flat_map(|s| (0..16).map(move |k| s.eval(f64::from(k) / 16.0)));
    points.map(|p| Vec2::new(p.x as f32, p.y as f32)).collect()
}

/// The rms distance after the best similarity, as a share of the extent, and the rms of the edges' change of length.
fn distortion(rest: &[Vec2], now: &[Vec2]) -> (f32, f32) {
    let n = rest.len() as f32;
    let middle = |p: &[Vec2]| p.iter().sum::<Vec2>() / n;
    let (a, b) = (middle(rest), middle(now));
    let (mut z, mut square) = (Vec2::ZERO, 0.0);
    for (p, q) in rest.iter().zip(now) {
        let (p, q) = (*p - a, *q - b);
        z += Vec2::new(p.dot(q), p.perp_dot(q));
        square += p.length_squared();
    }
    let z = z / square.max(1e-12);
    let left: f32 = rest.iter().zip(now).map(|(p, q)| (*q - b).distance_squared(z.rotate(*p - a))).sum();
    let edges = rest.windows(2).zip(now.windows(2)).filter(|(r, _)| r[0].distance(r[1]) > 1e-3);
    let (mut sum, mut count) = (0.0, 0.0f32);
    for (r, q) in edges {
        sum += (q[0].distance(q[1]) / r[0].distance(r[1]) - 1.0).powi(2);
        count += 1.0;
    }
    ((left / square.max(1e-12)).sqrt(), (sum / count.max(1.0)).sqrt())
}

fn line(image: &mut RgbaImage, a: Vec2, b: Vec2, color: Rgba<u8>) {
    let steps = a.distance(b).ceil().clamp(1.0, 4000.0) as usize;
    for k in 0..=steps {
        let p = a.lerp(b, k as f32 / steps as f32);
        if p.x >= 0.0 && p.y >= 0.0 && (p.x as u32) < image.width() && (p.y as u32) < image.height() {
            image.put_pixel(p.x as u32, p.y as u32, color);
        }
    }
}

fn main() -> Anything<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [drawing, out, others @ ..] = &args[..] else {
        return Err("usage: sketch_eval DRAWING.svg OUT [BIND.json MOTION.json...]".into());
    };
    let drawing = Drawing::read_svg(drawing)?.drawing;
    let progress = Progress::new();
    let (binding, motions) = match others {
        [bind, motions @ ..] => {
            (Binding::read(bind)?, motions.iter().map(Motion::read).collect::<Result<Vec<_>, _>>()?)
        }
        [] => {
            let (binding, motion) = swung(&drawing, 8, 48);
            (binding, vec![motion])
        }
    };
    let motions: Vec<&Motion> = motions.iter().collect();
    let start = now();
    let mut sketch = Sketch::new(drawing.clone(), binding.clone(), SketchParams::default(), progress.whole())?;
    let made = now() - start;
    let start = now();
    let take: SketchTake = sketch.take(&motions, progress.whole())?;
    let taken = (now() - start) / take.frames.len() as f64;
    let targets = sketch.targets(&motions)?;
    sketch.reset();
    let mut meshes = Vec::new();
    let (mut flips, mut slowest, mut total) = (0, 0f64, 0.0);
    for targets in &targets {
        let start = now();
        let _ = sketch.frame(targets, progress.whole())?;
        let spent = now() - start;
        (slowest, total) = (slowest.max(spent), total + spent);
        let layers = 0..binding.layers.len().max(1);
        let shapes: Vec<_> = layers.filter_map(|l| Some((sketch.mesh_of(l)?, sketch.shape_of(l)?))).collect();
        for (mesh, shape) in &shapes {
            let turned = |t: &&[u32; 3]| {
                let [a, b, c] = t.map(|v| shape[v as usize]);
                (b - a).perp_dot(c - a) <= 0.0
            };
            flips += mesh.triangles.iter().filter(turned).count();
        }
        meshes.push(shapes.iter().map(|(m, s)| (m.triangles.clone(), s.to_vec())).collect::<Vec<_>>());
    }
    let mut moved = binding.clone();
    if let Some(p) = moved.points.first_mut() {
        p.at += Vec2::ONE;
    }
    let start = now();
    sketch.set_binding(moved, progress.whole())?;
    let _ = sketch.frame(&targets[targets.len() / 2], progress.whole())?;
    let edited = now() - start;
    let vertices: usize = meshes[0].iter().map(|m| m.1.len()).sum();
    let points: usize = take.frames[0].paths.iter().map(|p| p.elements().len()).sum();
    let before: usize = drawing.strokes.iter().map(|s| s.path.elements().len()).sum();
    let least = drawing.bounds().map_or(0.0, |b| b.width().hypot(b.height())) / 20.0;
    let long = |s: &usize| take.frames[0].paths[*s].segments().map(|s| s.arclen(0.1)).sum::<f64>() > least;
    let strokes: Vec<usize> = (0..drawing.strokes.len()).filter(long).collect();
    let (mut bend, mut stretch, mut count) = (0.0, 0.0, 0.0f32);
    for frame in &take.frames[1..] {
        for &s in &strokes {
            let (b, s) = distortion(&along(&take.frames[0].paths[s]), &along(&frame.paths[s]));
            (bend, stretch, count) = (bend + b, stretch + s, count + 1.0);
        }
    }
    println!(
        "{} strokes, {before} elements, {points} in the take; {vertices} vertices, {flips} turned in {} frames",
        drawing.strokes.len(),
        take.frames.len()
    );
    println!(
        "ready {made:.1} ms, a frame {:.2} ms (slowest {slowest:.2}), of a take {taken:.2} ms, after an edit {edited:.2} ms",
        total / targets.len() as f64
    );
    println!("strokes: {:.2} % off a similarity, edges {:.2} %", 100.0 * bend / count, 100.0 * stretch / count);
    std::fs::create_dir_all(out)?;
    let canvas = SketchCanvas::around(&drawing, &take, 512.0 / drawing.size.0.max(drawing.size.1))?;
    let view = canvas.transform();
    let place = |p: Vec2| {
        let q = view * kurbo::Point::new(p.x.into(), p.y.into());
        Vec2::new(q.x as f32, q.y as f32)
    };
    let every = take.frames.len().div_ceil(12).max(1);
    let shown: Vec<usize> = (0..take.frames.len()).step_by(every).collect();
    let (w, h) = canvas.size();
    let mut sheet = RgbaImage::from_pixel(w * 4, h * shown.len().div_ceil(4) as u32, Rgba([255; 4]));
    for (i, &t) in shown.iter().enumerate() {
        let mut picture = RgbaImage::from_pixel(w, h, Rgba([255; 4]));
        for (triangles, points) in &meshes[t] {
            for t in triangles {
                let [a, b, c] = t.map(|v| place(points[v as usize]));
                for (a, b) in [(a, b), (b, c), (c, a)] {
                    line(&mut picture, a, b, Rgba([205, 225, 245, 255]));
                }
            }
        }
        image::imageops::overlay(&mut picture, &draw_sketch(&drawing, &take, t, &canvas), 0, 0);
        for p in &targets[t] {
            let p = place(*p);
            for k in -3..=3 {
                line(
                    &mut picture,
                    p + Vec2::new(-3.0, k as f32),
                    p + Vec2::new(3.0, k as f32),
                    Rgba([230, 30, 30, 255]),
                );
            }
        }
        image::imageops::overlay(&mut sheet, &picture, i64::from(w) * (i as i64 % 4), i64::from(h) * (i as i64 / 4));
    }
    sheet.save(format!("{out}/sheet.png"))?;
    for t in 0..take.frames.len() {
        draw_sketch(&drawing, &take, t, &canvas).save(format!("{out}/{t:04}.png"))?;
    }
    Ok(())
}
