//! The whole method: flow between all neighbouring frames, passes from every key frame, and their joining.

use std::collections::BTreeMap;

use glam::Vec2;
use rayon::prelude::*;

use crate::carry::{Anchor, Carried, Step, carry};
use crate::flow::Flow;
use crate::pyramid::{Level, Pyramid, luma};
use crate::rig::{Footage, Limb, Pose, Stroke};
use crate::{Error, Parameters};

/// Trust below which a point is taken to be hidden.
const HIDDEN: f32 = 0.22;
/// Confidence that a step in full trust keeps, and one in none.
const KEPT: f32 = 0.995;
const LOST: f32 = 0.85;

/// Frames that one thread reads in a row.
const TOGETHER: usize = 4;

/// The tracker.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlowTracker {
    /// Its settings.
    pub parameters: Parameters,
}

/// A limb's way from its key frames.
type Way = Vec<Option<Carried>>;

impl FlowTracker {
    /// Every limb in every frame, `[limb][frame]`. Key frames keep what was drawn. `go_on` is told how much is done
    /// (0..=1), from any thread, at least every 100 ms; `false` cancels.
    ///
    /// # Errors
    /// A limb without strokes, strokes that do not agree, a number that is not finite, a parameter outside its range, a
    /// frame that cannot be had, or a cancel.
    pub fn track(&self, footage: &Footage<'_>, go_on: &(dyn Fn(f64) -> bool + Sync)) -> Result<Vec<Vec<Pose>>, Error> {
        self.parameters.check()?;
        check(footage)?;
        if footage.limbs.is_empty() || footage.count == 0 {
            return Ok(Vec::new());
        }
        let at = |done: f64| if go_on(done) { Ok(()) } else { Err(Error::Cancelled) };
        let seen = watch(footage, &at)?;
        let pass = Pass { parameters: &self.parameters, footage, seen: &seen };
        let order = parents_first(footage.limbs);
        let (forward, backward) = rayon::join(|| pass.run(&order, true, &at), || pass.run(&order, false, &at));
        let (forward, backward) = (forward?, backward?);
        at(1.0)?;
        let joined = footage.limbs.iter().zip(forward.iter().zip(&backward));
        Ok(joined.map(|(limb, (f, b))| join(limb, f, b)).collect())
    }
}

/// What is kept of the pictures.
struct Seen {
    /// Of every frame the brightness.
    luma: Vec<Vec<u8>>,
    /// From each frame to the next, and back.
    flows: Vec<[Flow; 2]>,
}

/// Reads the frames a few at a time: their pyramids are much larger than what is kept.
fn watch(footage: &Footage<'_>, at: &(dyn Fn(f64) -> Result<(), Error> + Sync)) -> Result<Seen, Error> {
    let n = footage.count;
    let read = |f: usize| {
        at(0.9 * f as f64 / n as f64)?;
        let pixels = footage.frames.frame(f).map_err(|problem| Error::Frame { frame: f, problem })?;
        if pixels.len() != 3 * footage.width * footage.height {
            let problem = format!("{} bytes for {}x{} pixels", pixels.len(), footage.width, footage.height);
            return Err(Error::Frame { frame: f, problem });
        }
        Ok(luma(&pixels))
    };
    let pyramid = |luma: &[u8]| Pyramid::new(Level::new(footage.width, footage.height, luma));
    let starts: Vec<usize> = (0..n).step_by(TOGETHER).collect();
    let parts = starts.into_par_iter().map(|start| {
        let mut part = Seen { luma: vec![read(start)?], flows: Vec::new() };
        let mut before = pyramid(&part.luma[0]);
        for f in start + 1..(start + TOGETHER + 1).min(n) {
            let bytes = read(f)?;
            let next = pyramid(&bytes);
            let there = Flow::between(&before, &next, &|| at(0.0).is_ok()).ok_or(Error::Cancelled)?;
            let back = Flow::between(&next, &before, &|| at(0.0).is_ok()).ok_or(Error::Cancelled)?;
            part.flows.push([there, back]);
            before = next;
            // The last one belongs to the next part.
            if f < start + TOGETHER {
                part.luma.push(bytes);
            }
        }
        Ok(part)
    });
    let mut all = Seen { luma: Vec::with_capacity(n), flows: Vec::with_capacity(n) };
    for part in parts.collect::<Result<Vec<_>, Error>>()? {
        all.luma.extend(part.luma);
        all.flows.extend(part.flows);
    }
    Ok(all)
}

fn check(footage: &Footage<'_>) -> Result<(), Error> {
    let bad = |what: String, problem: String, remedy| Err(Error::Input { what, problem, remedy });
    let pixels = footage.width.saturating_mul(footage.height);
    if pixels == 0 || pixels > 1 << 28 {
        let problem = format!("{}x{} pixels", footage.width, footage.height);
        return bad("the frames".into(), problem, "give frames of at least a pixel and at most 2^28");
    }
    for (l, limb) in footage.limbs.iter().enumerate() {
        let what = || format!("limb {l}");
        let Some(first) = limb.strokes.first() else {
            return bad(what(), "is nowhere drawn".into(), "draw it on a key frame");
        };
        if first.points.len() < 2 {
            return bad(what(), format!("has {} points", first.points.len()), "give at least 2");
        }
        if limb.parent.is_some_and(|p| p >= footage.limbs.len()) {
            return bad(what(), "hangs from a limb that there is not".into(), "name one that is followed");
        }
        for (i, stroke) in limb.strokes.iter().enumerate() {
            let what = || format!("limb {l} on frame {}", stroke.frame);
            if stroke.frame >= footage.count {
                return bad(what(), format!("there are {} frames", footage.count), "frames count from 0");
            }
            if i > 0 && limb.strokes[i - 1].frame >= stroke.frame {
                return bad(what(), "is out of order".into(), "list strokes by rising frame");
            }
            if stroke.points.len() != first.points.len() {
                let problem = format!("{} points, the first stroke has {}", stroke.points.len(), first.points.len());
                return bad(what(), problem, "give every stroke of a limb as many");
            }
            let far = 10.0 * (footage.width + footage.height) as f32;
            if stroke.points.iter().any(|p| !p.is_finite() || p.abs().max_element() > far) {
                return bad(what(), "a point is not finite or far outside".into(), "give pixels of the frame");
            }
        }
    }
    Ok(())
}

/// Limbs so that each comes after the one it hangs from; those in a circle hang from nothing.
fn parents_first(limbs: &[Limb]) -> Vec<usize> {
    let mut order = Vec::with_capacity(limbs.len());
    let mut placed = vec![false; limbs.len()];
    loop {
        let before = order.len();
        for (i, limb) in limbs.iter().enumerate() {
            if !placed[i] && limb.parent.is_none_or(|p| placed[p]) {
                placed[i] = true;
                order.push(i);
            }
        }
        if order.len() == before {
            order.extend((0..limbs.len()).filter(|&i| !placed[i]));
            return order;
        }
    }
}

struct Pass<'a> {
    parameters: &'a Parameters,
    footage: &'a Footage<'a>,
    seen: &'a Seen,
}

/// The stroke that a pass last came by on its way to `frame`.
fn nearest_key(limb: &Limb, frame: usize, forward: bool) -> Option<&Stroke> {
    if forward {
        limb.strokes.iter().rev().find(|s| s.frame <= frame)
    } else {
        limb.strokes.iter().find(|s| s.frame >= frame)
    }
}

/// Where a limb hangs: its own point, and the parent's that is nearest to it where both were drawn.
#[derive(Clone, Copy)]
struct Joint {
    own: usize,
    parent: usize,
    parents: usize,
    offset: Vec2,
}

impl Pass<'_> {
    /// Carries every limb away from its key frames, until the next one.
    fn run(
        &self,
        order: &[usize],
        forward: bool,
        at: &(dyn Fn(f64) -> Result<(), Error> + Sync),
    ) -> Result<Vec<Way>, Error> {
        let n = self.footage.count;
        let mut ways: Vec<Way> = vec![vec![None; n]; self.footage.limbs.len()];
        let level = |f: usize| Level::new(self.footage.width, self.footage.height, &self.seen.luma[f]);
        // Key frames' looks, until the pass has left their limbs behind.
        let mut keys: BTreeMap<usize, Level> = BTreeMap::new();
        let mut last: Option<Level> = None;
        let frames: Vec<usize> = if forward { (0..n).collect() } else { (0..n).rev().collect() };
        for (k, &frame) in frames.iter().enumerate() {
            at(0.9 + 0.1 * k as f64 / n as f64)?;
            let now = level(frame);
            let looks = now.halved();
            let from = last.replace(now);
            let to = last.as_ref();
            for &l in order {
                let limb = &self.footage.limbs[l];
                if let Some(stroke) = limb.strokes.iter().find(|s| s.frame == frame) {
                    let trust = vec![1.0; stroke.points.len()];
                    ways[l][frame] = Some(Carried { points: stroke.points.clone(), trust });
                    continue;
                }
                let (Some(from), Some(to)) = (&from, to) else { continue };
                let Some(&before) = k.checked_sub(1).and_then(|k| frames.get(k)) else { continue };
                let Some(pose) = ways[l][before].as_ref().map(|c| c.points.clone()) else { continue };
                let key = nearest_key(limb, frame, forward);
                let Some(key) = key else { continue };
                let pair = before.min(frame);
                let [there, back] = &self.seen.flows[pair];
                let (there, back) = if forward { (there, back) } else { (back, there) };
                let step = Step { there, back, from, to, looks: &looks };
                let picture = keys.entry(key.frame).or_insert_with(|| level(key.frame).halved());
                let anchor = Anchor { points: &key.points, picture };
                let length: f32 = key.points.windows(2).map(|p| p[0].distance(p[1])).sum();
                let root = self.joint(l, key.frame).and_then(|joint| {
                    let parent = ways[joint.parent][frame].as_ref()?;
                    Some((joint.own, parent.points[joint.parents] + joint.offset))
                });
                let half_width = self.parameters.width * length;
                ways[l][frame] = Some(carry(&pose, half_width, &step, &anchor, root, self.parameters));
            }
            let held = |key: usize| {
                self.footage.limbs.iter().any(|l| nearest_key(l, frame, forward).is_some_and(|s| s.frame == key))
            };
            keys.retain(|&key, _| held(key));
        }
        Ok(ways)
    }

    fn joint(&self, l: usize, frame: usize) -> Option<Joint> {
        let limb = &self.footage.limbs[l];
        let parent = limb.parent?;
        let own_stroke = limb.strokes.iter().find(|s| s.frame == frame)?;
        let parents_stroke = self.footage.limbs[parent].strokes.iter().find(|s| s.frame == frame)?;
        let own = if limb.rooted_at_start { 0 } else { own_stroke.points.len() - 1 };
        let at = own_stroke.points[own];
        let mut best = (f32::INFINITY, 0);
        for (i, p) in parents_stroke.points.iter().enumerate() {
            if p.distance(at) < best.0 {
                best = (p.distance(at), i);
            }
        }
        Some(Joint { own, parent, parents: best.1, offset: at - parents_stroke.points[best.1] })
    }
}

/// Confidence along a way: what each step kept of it.
fn confidences(limb: &Limb, way: &Way, forward: bool) -> Vec<Vec<f32>> {
    let n = way.len();
    let mut out: Vec<Vec<f32>> = vec![Vec::new(); n];
    let mut current = vec![0.0f32; limb.strokes[0].points.len()];
    for k in 0..n {
        let frame = if forward { k } else { n - 1 - k };
        if limb.strokes.iter().any(|s| s.frame == frame) {
            current.fill(1.0);
        } else if let Some(carried) = &way[frame] {
            for (c, t) in current.iter_mut().zip(&carried.trust) {
                *c *= LOST + (KEPT - LOST) * t.sqrt();
            }
        }
        out[frame].clone_from(&current);
    }
    out
}

/// Both ways, joined point by point.
fn join(limb: &Limb, forward: &Way, backward: &Way) -> Vec<Pose> {
    let (sure, sure_back) = (confidences(limb, forward, true), confidences(limb, backward, false));
    let count = limb.strokes[0].points.len();
    (0..forward.len())
        .map(|frame| match (&forward[frame], &backward[frame]) {
            (Some(a), Some(b)) => {
                let before = limb.strokes.iter().rev().find(|s| s.frame <= frame).map_or(frame, |s| s.frame);
                let after = limb.strokes.iter().find(|s| s.frame >= frame).map_or(frame, |s| s.frame);
                let share = (frame - before) as f32 / (after - before).max(1) as f32;
                let mut pose = Pose::default();
                for i in 0..count {
                    // Errors grow with the way: near a key frame its own track is the better one by far.
                    let (wa, wb) = (sure[frame][i] * (1.0 - share).powi(2), sure_back[frame][i] * share.powi(2));
                    let t = if wa + wb > 0.0 { wb / (wa + wb) } else { share };
                    pose.points.push(a.points[i].lerp(b.points[i], t));
                    let apart = a.points[i].distance(b.points[i]) / 20.0;
                    let both = sure[frame][i] * (1.0 - t) + sure_back[frame][i] * t;
                    pose.confidence.push(both / (1.0 + (t * (1.0 - t) * 4.0) * apart * apart));
                    pose.visible.push(a.trust[i] * (1.0 - t) + b.trust[i] * t >= HIDDEN);
                }
                pose
            }
            (Some(a), None) => one_sided(a, &sure[frame]),
            (None, Some(b)) => one_sided(b, &sure_back[frame]),
            (None, None) => Pose {
                points: limb.strokes[0].points.clone(),
                confidence: vec![0.0; count],
                visible: vec![false; count],
            },
        })
        .collect()
}

fn one_sided(carried: &Carried, confidence: &[f32]) -> Pose {
    Pose {
        points: carried.points.clone(),
        confidence: confidence.to_vec(),
        visible: carried.trust.iter().map(|t| *t >= HIDDEN).collect(),
    }
}
