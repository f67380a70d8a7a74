//! The conformance suite: runs every plugin of a library on little scenes, and says in plain words what is wrong.
//!
//! It checks what a host relies on and an author can forget: results for odd scenes too, the same result each time, a
//! prompt stop, values at the ends of their ranges, state that survives a round trip. It does not judge quality.

use std::path::Path;
use std::time::{Duration, Instant};

use image::RgbImage;
use marey::clip::Clip;
use marey::deform::{Deformer as _, Handle, RestMesh};
use marey::job::Progress;
use marey::motion::{Motion, Track, TrackFrame, TrackKind};
use marey::rig::{KeyFrame, Limb, Rig, Stroke};
use marey::segment::Segmenter as _;
use marey::track::Tracker as _;
use marey::{Error, Vec2, vec2};

use crate::describe::{ParameterKind, PluginInfo, PluginKind};
use crate::door::DoorKind;
use crate::options::Options;
use crate::refusal::Refusal;
use crate::registry::Registry;
use crate::slot::{Policy, Slot};
use crate::values::Value;

/// How long a plugin under test may be silent.
const SILENCE: Duration = Duration::from_secs(5);

/// One thing that was tried.
#[derive(Debug, serde::Serialize)]
struct Check {
    name: &'static str,
    passed: bool,
    /// What came of it, a sentence.
    detail: String,
}

#[derive(Debug, serde::Serialize)]
struct Report {
    id: String,
    name: String,
    version: String,
    kind: PluginKind,
    door: DoorKind,
    checks: Vec<Check>,
}

/// Runs the suite on a library, with `cache` for its private copies. Gives the report.
pub(crate) fn run(file: &Path, cache: &Path) -> Result<serde_json::Value, Refusal> {
    let mut reports = Vec::new();
    for door in [DoorKind::C, DoorKind::Rust] {
        let mut options = Options::new(cache);
        (options.silence, options.settle) = (SILENCE, Duration::ZERO);
        // What fails here is reported, not counted.
        options.strikes = u32::MAX;
        options.door = Some(door);
        let registry = Registry::new(options)?;
        match registry.load(file) {
            Ok(_) => {}
            // A library need not have both doors.
            Err(refusal) if refusal.status == crate::Status::NoEntry && !reports.is_empty() => continue,
            Err(refusal) if refusal.status == crate::Status::NoEntry && door == DoorKind::C => continue,
            Err(refusal) => return Err(refusal),
        }
        for listed in registry.plugins() {
            let checks = plugin(&registry, &listed.info);
            let PluginInfo { id, name, version, kind, .. } = listed.info;
            reports.push(Report { id, name, version, kind, door: listed.door, checks });
        }
    }
    let passed = reports.iter().all(|r| r.checks.iter().all(|c| c.passed));
    Ok(serde_json::json!({ "format": "marey-plugin-check", "version": 1, "passed": passed, "plugins": reports }))
}

fn plugin(registry: &Registry, info: &PluginInfo) -> Vec<Check> {
    let mut checks = Vec::new();
    let mut check = |name, outcome: Result<String, String>| {
        let (passed, detail) = match outcome {
            Ok(detail) => (true, detail),
            Err(detail) => (false, detail),
        };
        checks.push(Check { name, passed, detail });
    };
    let slot = || {
        // One that hung is tried on: each check stands for itself.
        let _ = registry.set_enabled(&info.id, true);
        registry.slot(&info.id, info.kind, Policy::Keep).map_err(|e| e.to_string())
    };
    for scene in Scene::all() {
        check(scene.name, slot().and_then(|slot| work(&slot, info.kind, &scene)).map(|_| "done".to_owned()));
    }
    let scene = Scene::walk("", 12, (96, 64));
    check("gives the same result each time", same_twice(&slot, info.kind, &scene));
    check("stops soon when it is cancelled", slot().and_then(|slot| cancels(&slot, info.kind)));
    check("takes the least and the greatest value of each parameter", extremes(registry, info, &scene, &slot));
    check("carries its state over", slot().and_then(|slot| carries(&slot, &slot_of(registry, info)?)));
    checks
}

fn slot_of(registry: &Registry, info: &PluginInfo) -> Result<Slot, String> {
    registry.slot(&info.id, info.kind, Policy::Keep).map_err(|e| e.to_string())
}

/// A clip with what is drawn on it.
struct Scene {
    name: &'static str,
    clip: Clip,
    rig: Rig,
}

impl Scene {
    /// A bar that walks to the right over stripes, drawn on the first and the last frame.
    fn walk(name: &'static str, frames: usize, (width, height): (u32, u32)) -> Self {
        let x0 = |f: usize| width as f32 * 0.2 + 1.5 * f as f32;
        let (y, length) = (height as f32 * 0.5, width as f32 * 0.3);
        let paint = |f: usize| {
            RgbImage::from_fn(width, height, |px, py| {
                let (u, v) = (px as f32 + 0.5 - x0(f), py as f32 + 0.5 - y);
                let inside = (0.0..length).contains(&u) && v.abs() < 4.0;
                image::Rgb(if inside { [220, (u * 3.0) as u8, 60] } else { [30, 40 + (py % 7 * 3) as u8, 50] })
            })
        };
        let stroke = |limb, f: usize, dy: f32| Stroke {
            limb,
            points: vec![vec2(x0(f) + 1.0, y + dy), vec2(x0(f) + length - 1.0, y + dy)],
            facing: None,
        };
        let key = |f: usize| KeyFrame { frame: f, strokes: vec![stroke(0, f, 0.0)], ..KeyFrame::default() };
        let mut keyframes = vec![key(0)];
        if frames > 1 {
            keyframes.push(key(frames - 1));
        }
        let limbs = vec![Limb { label: "bar".to_owned(), side: None }];
        // Frames of one size and a rate above 0 make a clip.
        #[expect(clippy::unwrap_used, reason = "the scene is the suite's own")]
        let clip = Clip::from_frames((0..frames).map(paint).collect(), 24.0).unwrap();
        Self { name, clip, rig: Rig { size: (width, height), limbs, keyframes } }
    }

    fn all() -> Vec<Self> {
        let walk = Self::walk("works on a thing that walks", 12, (96, 64));
        let one = Self::walk("works on a clip of one frame", 1, (64, 48));
        let mut late = Self::walk("works where the first frame is not drawn on", 8, (96, 64));
        late.rig.keyframes.remove(0);
        let mut outside = Self::walk("works where a limb leaves the picture", 8, (96, 64));
        for key in &mut outside.rig.keyframes {
            key.strokes[0].points.iter_mut().for_each(|p| p.x -= 40.0);
        }
        let mut two = Self::walk("works on limbs that hang together", 6, (101, 53));
        two.rig.limbs.push(Limb { label: "größer \"2\"".to_owned(), side: Some(marey::rig::Side::Near) });
        let end = two.rig.keyframes[0].strokes[0].points[1];
        let second = Stroke { limb: 1, points: vec![end, end + vec2(4.0, 15.0)], facing: None };
        two.rig.keyframes[0].strokes.push(second);
        vec![walk, one, late, outside, two]
    }

    /// The strokes, held still between key frames.
    fn motion(&self) -> Motion {
        let skeleton = crate::brief::skeleton(&self.clip, &self.rig);
        let frames = self.clip.info().frames;
        let track = |l: usize| {
            let keys: Vec<usize> = self.rig.keys_of(l).map(|(f, _)| f).collect();
            let near = |f: usize| keys.iter().rev().find(|k| **k <= f).or(keys.first()).copied().unwrap_or(0);
            let frame = |f| TrackFrame::certain(skeleton.drawn(&self.rig, l, near(f)).unwrap_or_default());
            let name = self.rig.limbs[l].label.clone();
            Track { name, kind: TrackKind::Stroke, frames: (0..frames).map(frame).collect() }
        };
        let tracks = (0..self.rig.limbs.len()).map(track).collect();
        Motion { size: self.rig.size, fps: 24.0, frames, tracks, bones: Vec::new() }
    }
}

/// What a plugin made of a scene, as numbers to compare.
fn work(slot: &Slot, kind: PluginKind, scene: &Scene) -> Result<Vec<f32>, String> {
    let progress = Progress::new();
    let stage = progress.whole();
    let made = match kind {
        PluginKind::Tracker => slot.track(&scene.clip, &scene.rig, stage).map(|motion| {
            let frames = motion.tracks.iter().flat_map(|t| &t.frames);
            frames.flat_map(|f| f.points.iter().flat_map(|p| [p.x, p.y]).chain(f.confidence.clone())).collect()
        }),
        PluginKind::Segmenter => slot
            .segment(&scene.clip, &scene.rig, &scene.motion(), stage)
            .map(|masks| masks.iter().flat_map(|m| m.to_image().into_raw()).map(f32::from).collect()),
        PluginKind::Deformer => deform(slot, scene),
    };
    made.map_err(|e| e.to_string())
}

/// A grid whose corners are handles: held still, then moved as one, then one corner pulled.
fn deform(slot: &Slot, scene: &Scene) -> marey::Result<Vec<f32>> {
    let n = 4 + scene.clip.info().frames as u32 % 5;
    let points: Vec<Vec2> = (0..n * n).map(|i| vec2((i % n) as f32, (i / n) as f32) * 10.0).collect();
    let cells = (0..(n - 1) * (n - 1)).map(|i| i / (n - 1) * n + i % (n - 1));
    let triangles: Vec<[u32; 3]> = cells.flat_map(|i| [[i, i + 1, i + n], [i + 1, i + n + 1, i + n]]).collect();
    let side = (n - 1) as f32 * 10.0;
    let rest = [vec2(0.0, 0.0), vec2(side, 0.0), vec2(0.0, side)].map(Handle::Point);
    let progress = Progress::new();
    let stage = progress.whole();
    let mut bound = slot.bind(RestMesh { points: &points, triangles: &triangles }, &rest, stage)?;
    let mut moved = points.clone();
    bound.solve(&rest, &mut moved, stage)?;
    let off =
        |moved: &[Vec2], by: Vec2| moved.iter().zip(&points).map(|(m, p)| m.distance(*p + by)).fold(0.0, f32::max);
    if off(&moved, Vec2::ZERO) > 1.0 {
        return Err(Error::invalid("the mesh", "moves though no handle does", "keep the rest shape there"));
    }
    let by = vec2(7.0, -3.0);
    let shifted = [vec2(0.0, 0.0), vec2(side, 0.0), vec2(0.0, side)].map(|p| Handle::Point(p + by));
    bound.solve(&shifted, &mut moved, stage)?;
    if off(&moved, by) > 1.0 {
        return Err(Error::invalid("the mesh", "does not move along with all its handles", "move it as they do"));
    }
    let pulled = [vec2(-9.0, -9.0), vec2(side, 0.0), vec2(0.0, side)].map(Handle::Point);
    bound.solve(&pulled, &mut moved, stage)?;
    Ok(moved.iter().flat_map(|p| [p.x, p.y]).collect())
}

fn same_twice(slot: &dyn Fn() -> Result<Slot, String>, kind: PluginKind, scene: &Scene) -> Result<String, String> {
    let (one, other) = (work(&slot()?, kind, scene)?, work(&slot()?, kind, scene)?);
    let same = one.len() == other.len() && one.iter().zip(&other).all(|(a, b)| a.to_bits() == b.to_bits());
    if same { Ok("bit for bit".to_owned()) } else { Err("two runs of new instances differ".to_owned()) }
}

fn cancels(slot: &Slot, kind: PluginKind) -> Result<String, String> {
    if kind == PluginKind::Deformer {
        return Ok("deformers are too quick to be cancelled".to_owned());
    }
    let scene = Scene::walk("", 40, (320, 240));
    let progress = Progress::new();
    let motion = scene.motion();
    let began = Instant::now();
    let result = std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(30));
            progress.cancel();
        });
        match kind {
            PluginKind::Segmenter => slot.segment(&scene.clip, &scene.rig, &motion, progress.whole()).map(drop),
            _ => slot.track(&scene.clip, &scene.rig, progress.whole()).map(drop),
        }
    });
    let took = began.elapsed().as_millis();
    match result {
        Ok(()) => Ok(format!("was done after {took} ms, before it could be cancelled")),
        Err(Error::Cancelled) if slot.generation().is_some() => {
            Ok(format!("stopped {} ms after", took.saturating_sub(30)))
        }
        Err(Error::Cancelled) => {
            Err("went on working: ask job progress at least every 50 ms, and return when it says cancel".to_owned())
        }
        Err(other) => Err(other.to_string()),
    }
}

fn extremes(
    registry: &Registry,
    info: &PluginInfo,
    scene: &Scene,
    slot: &dyn Fn() -> Result<Slot, String>,
) -> Result<String, String> {
    let mut tried = 0;
    for parameter in &info.parameters {
        let values = match parameter.kind {
            ParameterKind::Text | ParameterKind::File => continue,
            ParameterKind::Choice | ParameterKind::Switch => (0..=parameter.high as u32).map(f64::from).collect(),
            _ => vec![parameter.low, parameter.high],
        };
        for value in values {
            let choose =
                |value| registry.choose(&info.id, &parameter.id, Value::Number(value)).map_err(|e| e.to_string());
            choose(value)?;
            let outcome = slot().and_then(|slot| work(&slot, info.kind, scene));
            choose(parameter.default)?;
            outcome.map_err(|e| format!("with `{}` at {value}: {e}", parameter.id))?;
            tried += 1;
        }
    }
    Ok(format!("{tried} values of {} parameters", info.parameters.len()))
}

fn carries(one: &Slot, other: &Slot) -> Result<String, String> {
    one.renew().map_err(|e| e.to_string())?;
    let Some((version, bytes)) = one.save().map_err(|e| e.to_string())? else {
        return Ok("it keeps none".to_owned());
    };
    other.load(version, &bytes).map_err(|e| format!("it does not load what it saved: {e}"))?;
    let again = other.save().map_err(|e| e.to_string())?;
    if again == Some((version, bytes.clone())) {
        Ok(format!("{} bytes, the same after a round trip", bytes.len()))
    } else {
        Err("what it saves after loading is not what it loaded".to_owned())
    }
}
