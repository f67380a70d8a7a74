//! How points of motions become ways of control points over a drawing.
//!
//! A control point is at `at + S R (x_t - x_f)`: what its point of the motion does since the frame in which the drawing
//! is as drawn, mirrored, turned and enlarged. Before that, frames in which the point was lost are bridged, and the
//! animal's way over the picture is taken out as far as asked.
//!
//! Bridging: a place counts as far as its tracker trusts it; below [`TRUSTED`] it gives way to a cubic Hermite curve
//! between the nearest trusted frames, drawn relative to what the other points do, so that the foot of an animal that
//! walks on is not left behind. Travel: the mean of all points bound to the motion, smoothed by Whittaker's penalised
//! second differences, which follow a straight way exactly up to the first and last frame and leave the gait alone.
//!
//! Known limits: a gait slower than [`SLOW`] seconds a step is taken for travel.

use glam::{DVec2, Vec2};

use super::{Binding, MotionUse};
use crate::motion::{Motion, Track};

/// Places that are trusted as much, in 0..=1, are kept as they are.
const TRUSTED: f32 = 0.5;
/// How much a place that the tracker calls hidden is trusted, against one that is seen.
const HIDDEN: f32 = 0.5;
/// Movement whose period is longer, in seconds, is travel: an elephant's stride takes about 1.5.
const SLOW: f64 = 2.5;

/// Where control points go, frame by frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ways {
    /// Frames a second.
    pub(super) fps: f64,
    /// For each point of the binding, its place in every frame.
    pub(super) points: Vec<Vec<Vec2>>,
    pub(super) frames: usize,
}

/// The ways of all points of `binding`, which was checked against `motions`. `smoothing` is the standard deviation, in
/// frames, of a Gaussian over time; 0 for none.
pub(super) fn ways(binding: &Binding, motions: &[&Motion], smoothing: f32) -> Ways {
    let first = motions[0];
    let fps = first.fps;
    // At the first one's rate, all of the longest.
    let length = |m: &Motion| ((m.frames - 1) as f64 * fps / m.fps).round() as usize + 1;
    let frames = motions.iter().map(|m| length(m)).max().unwrap_or(1);
    let mut points = vec![Vec::new(); binding.points.len()];
    for (m, motion) in motions.iter().enumerate() {
        let own = binding.motions.get(m).cloned().unwrap_or_default();
        let bound: Vec<usize> =
            (0..binding.points.len()).filter(|&i| binding.motion_of(&binding.points[i]) == m).collect();
        let tracks: Vec<(&Track, usize)> = bound
            .iter()
            .filter_map(|&i| motion.track(&binding.points[i].track).map(|t| (t, binding.points[i].index)))
            .collect();
        let drift = Drift::of(&tracks, motion);
        for (&i, &(track, index)) in bound.iter().zip(&tracks) {
            let way = bridged(track, index, &drift.steps);
            let at = |t: f64| -> DVec2 {
                let whole = drift.at(t) * f64::from(1.0 - own.travel);
                sampled(&way, t) - whole
            };
            let start = at(own.frame as f64);
            let placed = |frame: usize| {
                let (t, rounds) = time_of(frame, fps, motion, &own);
                let beyond = drift.round(&own) * rounds;
                binding.points[i].at + own.turned((at(t) + beyond - start).as_vec2())
            };
            points[i] = (0..frames).map(placed).collect();
            smooth(&mut points[i], smoothing);
        }
    }
    Ways { fps, points, frames }
}

/// The frame of a motion, with its fraction, that is shown in a frame of the take, and how often it has begun again.
fn time_of(frame: usize, fps: f64, motion: &Motion, own: &MotionUse) -> (f64, f64) {
    let t = frame as f64 * motion.fps / fps;
    let last = (motion.frames - 1) as f64;
    if own.repeat && t > last {
        let count = motion.frames as f64;
        // Between the last frame and the first there is no movement to show.
        ((t % count).min(last), (t / count).floor())
    } else {
        (t.min(last), 0.0)
    }
}

impl MotionUse {
    /// What a movement in the clip is on the drawing.
    fn turned(&self, movement: Vec2) -> Vec2 {
        let mirrored = Vec2::new(if self.mirror { -movement.x } else { movement.x }, movement.y);
        self.scale * Vec2::from_angle(self.rotation.to_radians()).rotate(mirrored)
    }
}

/// How far a place is to be trusted.
fn trust(track: &Track, frame: usize, index: usize) -> f32 {
    let frame = &track.frames[frame];
    let seen = if frame.visible[index] { 1.0 } else { HIDDEN };
    seen * frame.confidence[index].clamp(0.0, 1.0)
}

/// What all points of a motion do together.
struct Drift {
    /// The sum of the points' median steps up to each frame.
    steps: Vec<DVec2>,
    /// The slow way of their mean.
    slow: Vec<DVec2>,
}

impl Drift {
    fn of(tracks: &[(&Track, usize)], motion: &Motion) -> Self {
        let n = motion.frames;
        let place = |&(track, index): &(&Track, usize), t: usize| track.frames[t].points[index].as_dvec2();
        let mut steps = vec![DVec2::ZERO; n];
        for t in 1..n {
            let sure = |p: &&(&Track, usize)| trust(p.0, t, p.1).min(trust(p.0, t - 1, p.1)) >= TRUSTED;
            let moved: Vec<DVec2> = tracks.iter().filter(sure).map(|p| place(p, t) - place(p, t - 1)).collect();
            let along = |axis: usize| {
                let mut values: Vec<f64> = moved.iter().map(|m| m[axis]).collect();
                values.sort_unstable_by(f64::total_cmp);
                let k = values.len() / 2;
                match values.len() {
                    0 => 0.0,
                    n if n % 2 == 1 => values[k],
                    _ => 0.5 * (values[k - 1] + values[k]),
                }
            };
            steps[t] = steps[t - 1] + DVec2::new(along(0), along(1));
        }
        let mut mean = vec![DVec2::ZERO; n];
        for &(track, index) in tracks {
            let way = bridged(track, index, &steps);
            mean.iter_mut().zip(&way).for_each(|(m, w)| *m += *w / tracks.len() as f64);
        }
        // Whittaker's smoother passes half of a movement with this many frames a period.
        let period = SLOW * motion.fps;
        let slow = whittaker(&mean, (2.0 * (std::f64::consts::PI / period.max(2.0)).sin()).powi(-4));
        Self { steps, slow }
    }

    fn at(&self, t: f64) -> DVec2 {
        sampled(&self.slow, t)
    }

    /// How much farther a motion is each time it begins again.
    fn round(&self, own: &MotionUse) -> DVec2 {
        let n = self.slow.len();
        if !own.repeat || n < 2 {
            return DVec2::ZERO;
        }
        let way = self.slow[n - 1] - self.slow[0];
        way * (n as f64 / (n - 1) as f64) * f64::from(own.travel)
    }
}

/// The value between frames, linearly.
fn sampled(way: &[DVec2], t: f64) -> DVec2 {
    let last = way.len() - 1;
    let i = (t.max(0.0) as usize).min(last);
    way[i].lerp(way[(i + 1).min(last)], t.max(0.0) - i as f64)
}

/// The way of a point of a track, bridged where it was lost. `common` is what the points do together.
fn bridged(track: &Track, index: usize, common: &[DVec2]) -> Vec<DVec2> {
    let n = track.frames.len();
    let own: Vec<DVec2> = (0..n).map(|t| track.frames[t].points[index].as_dvec2() - common[t]).collect();
    let sure: Vec<usize> = (0..n).filter(|&t| trust(track, t, index) >= TRUSTED).collect();
    if sure.is_empty() {
        return (0..n).map(|t| own[t] + common[t]).collect();
    }
    // The velocity at the edge of a gap, from the trusted frames on its other side.
    let velocity = |t: usize, into: isize| {
        const BACK: isize = 2;
        let before = (1..=BACK)
            .rev()
            .map(|k| t as isize - k * into)
            .find(|&s| s >= 0 && (s as usize) < n && trust(track, s as usize, index) >= TRUSTED);
        before.map_or(DVec2::ZERO, |s| (own[t] - own[s as usize]) / (t as f64 - s as f64))
    };
    let mut out = own.clone();
    for (t, place) in out.iter_mut().enumerate() {
        let certainty = trust(track, t, index) / TRUSTED;
        if certainty >= 1.0 {
            continue;
        }
        let next = sure.partition_point(|&s| s < t);
        let bridge = match (next.checked_sub(1).map(|k| sure[k]), sure.get(next).copied()) {
            (Some(a), Some(b)) => hermite(own[a], own[b], velocity(a, 1), velocity(b, -1), a, b, t),
            (Some(a), None) => own[a],
            (None, Some(b)) => own[b],
            (None, None) => own[t],
        };
        *place = bridge.lerp(own[t], f64::from(certainty));
    }
    out.iter().zip(common).map(|(own, common)| *own + *common).collect()
}

/// From `p` in frame `a` to `q` in frame `b`, leaving and arriving at these velocities.
fn hermite(p: DVec2, q: DVec2, leaves: DVec2, arrives: DVec2, a: usize, b: usize, t: usize) -> DVec2 {
    let span = (b - a) as f64;
    let u = (t - a) as f64 / span;
    // Velocities that would carry it far past its goal are a tracker's noise.
    let most = 2.0 * p.distance(q) / span;
    let (leaves, arrives) = (leaves.clamp_length_max(most), arrives.clamp_length_max(most));
    let (u2, u3) = (u * u, u * u * u);
    p * (2.0 * u3 - 3.0 * u2 + 1.0)
        + q * (3.0 * u2 - 2.0 * u3)
        + span * (leaves * (u3 - 2.0 * u2 + u) + arrives * (u3 - u2))
}

/// The way that is near to `values` and whose second differences are small, `weight` times as important: solves
/// `(I + weight D'D) x = values`, five diagonals wide (Whittaker 1923, Eilers 2003).
fn whittaker(values: &[DVec2], weight: f64) -> Vec<DVec2> {
    let n = values.len();
    if n < 3 {
        return values.to_vec();
    }
    let mut diagonals = vec![[1.0, 0.0, 0.0]; n];
    for i in 0..n - 2 {
        let d = [1.0, -2.0, 1.0];
        for j in 0..3 {
            for k in j..3 {
                diagonals[i + j][k - j] += weight * d[j] * d[k];
            }
        }
    }
    // L D L' with two diagonals below the main one.
    let mut x = values.to_vec();
    for i in 0..n {
        let [pivot, one, two] = diagonals[i];
        let (l1, l2) = (one / pivot, two / pivot);
        if i + 1 < n {
            diagonals[i + 1][0] -= l1 * one;
            diagonals[i + 1][1] -= l1 * two;
            let own = x[i];
            x[i + 1] -= l1 * own;
        }
        if i + 2 < n {
            diagonals[i + 2][0] -= l2 * two;
            let own = x[i];
            x[i + 2] -= l2 * own;
        }
        diagonals[i] = [pivot, l1, l2];
    }
    for i in (0..n).rev() {
        let [pivot, l1, l2] = diagonals[i];
        let mut value = x[i] / pivot;
        if i + 1 < n {
            value -= l1 * x[i + 1];
        }
        if i + 2 < n {
            value -= l2 * x[i + 2];
        }
        x[i] = value;
    }
    x
}

/// Blurs a way over time by a Gaussian of `sigma` frames; its ends are held.
fn smooth(way: &mut [Vec2], sigma: f32) {
    if sigma.is_nan() || sigma <= 0.0 {
        return;
    }
    let reach = (3.0 * sigma).ceil().min(way.len() as f32) as isize;
    let source = way.to_vec();
    for (t, out) in way.iter_mut().enumerate() {
        let (mut sum, mut total) = (Vec2::ZERO, 0.0);
        for k in -reach..=reach {
            let weight = (-0.5 * (k as f32 / sigma).powi(2)).exp();
            sum += weight * source[(t as isize + k).clamp(0, source.len() as isize - 1) as usize];
            total += weight;
        }
        *out = sum / total;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{TrackFrame, TrackKind};
    use crate::shape::sketch::BindPoint;
    use glam::vec2;
    use std::f32::consts::TAU;

    fn motion(fps: f64, frames: usize, tracks: &[(&str, &dyn Fn(f32) -> Vec2)]) -> Motion {
        let track = |&(name, at): &(&str, &dyn Fn(f32) -> Vec2)| Track {
            name: name.into(),
            kind: TrackKind::Point,
            frames: (0..frames).map(|t| TrackFrame::certain(vec![at(t as f32)])).collect(),
        };
        Motion { size: (640, 480), fps, frames, tracks: tracks.iter().map(track).collect(), bones: Vec::new() }
    }

    fn bound(motions: Vec<MotionUse>, tracks: &[(&str, &str)]) -> Binding {
        let point = |&(motion, track): &(&str, &str)| BindPoint {
            motion: motion.into(),
            track: track.into(),
            at: vec2(50.0, 60.0),
            ..BindPoint::default()
        };
        Binding { motions, points: tracks.iter().map(point).collect(), ..Binding::default() }
    }

    #[test]
    fn a_movement_is_mirrored_turned_and_enlarged_from_the_frame_it_is_bound_to() {
        let own = MotionUse { scale: 2.0, rotation: 90.0, mirror: true, frame: 3, ..MotionUse::default() };
        let straight = motion(25.0, 8, &[("a", &|t| vec2(5.0 + 3.0 * t, 7.0 + t))]);
        let found = ways(&bound(vec![own], &[("", "a")]), &[&straight], 0.0);
        assert_eq!((found.frames, found.fps), (8, 25.0));
        for (t, at) in found.points[0].iter().enumerate() {
            let k = t as f32 - 3.0;
            // (3, 1) a frame, mirrored (-3, 1), a quarter turned clockwise as seen with y down (-1, -3), twice as large.
            assert!(at.distance(vec2(50.0 - 2.0 * k, 60.0 - 6.0 * k)) < 1e-4, "{t}: {at}");
        }
        let one = motion(25.0, 1, &[("a", &|_| Vec2::ONE)]);
        let still = ways(&bound(vec![], &[("", "a")]), &[&one], 1.0).points;
        assert!(still[0].len() == 1 && still[0][0].distance(vec2(50.0, 60.0)) < 1e-4);
    }

    /// A body that travels and speeds up, and feet that swing about it.
    fn walk(frames: usize) -> Motion {
        let body = |t: f32| vec2(40.0 + 3.0 * t + 0.01 * t * t, 100.0 + 2.0 * (t * TAU / 12.0).sin());
        let foot = move |t: f32, phase: f32| body(t) + vec2(15.0 * (t * TAU / 24.0 + phase).sin(), 50.0);
        motion(25.0, frames, &[("body", &body), ("left", &|t| foot(t, 0.0)), ("right", &|t| foot(t, TAU / 2.0))])
    }

    #[test]
    fn a_walker_walks_on_the_spot_and_keeps_its_gait() {
        let walk = walk(100);
        let points = [("", "body"), ("", "left"), ("", "right")];
        let still = ways(&bound(vec![MotionUse { travel: 0.0, ..MotionUse::default() }], &points), &[&walk], 0.0);
        let body = &still.points[0];
        let spread = body.iter().map(|p| (p.x - 50.0).abs()).fold(0.0, f32::max);
        assert!(spread < 4.0, "of 400 pixels of way, {spread} are left");
        let step = |p: &[Vec2]| p.windows(3).map(|p| (p[0] - 2.0 * p[1] + p[2]).length()).fold(0.0, f32::max);
        assert!(step(body) < 0.7, "{}", step(body));
        let swing = |p: &[Vec2], q: &[Vec2]| p.iter().zip(q).map(|(p, q)| p.x - q.x).fold(0.0, f32::max);
        assert!((swing(&still.points[1], body) - 15.0).abs() < 0.5);
        let half = ways(&bound(vec![MotionUse { travel: 0.5, ..MotionUse::default() }], &points), &[&walk], 0.0);
        let whole = ways(&bound(vec![], &points), &[&walk], 0.0);
        for t in 0..100 {
            let between = (still.points[1][t] + whole.points[1][t]) / 2.0;
            assert!(half.points[1][t].distance(between) < 1e-3);
        }
    }

    #[test]
    fn a_hidden_foot_is_bridged_where_the_body_went() {
        let truth = walk(60);
        let mut seen = truth.clone();
        for t in 20..30 {
            let frame = &mut seen.tracks[1].frames[t];
            frame.points[0] += vec2(200.0, -80.0);
            (frame.visible[0], frame.confidence[0]) = (false, 0.0);
        }
        for t in 52..60 {
            let frame = &mut seen.tracks[1].frames[t];
            (frame.points[0], frame.visible[0], frame.confidence[0]) = (Vec2::ZERO, false, 0.0);
        }
        let binding = bound(vec![], &[("", "body"), ("", "left"), ("", "right")]);
        let (found, wished) = (ways(&binding, &[&seen], 0.0), ways(&binding, &[&truth], 0.0));
        let gap = |t: usize| found.points[1][t].distance(wished.points[1][t]);
        assert!((20..30).all(|t| gap(t) < 9.0), "{:?}", (20..30).map(gap).collect::<Vec<_>>());
        // At the end it stays with the body, whose way of 30 pixels it would else be behind.
        assert!((52..60).all(|t| gap(t) < 30.0), "{:?}", (52..60).map(gap).collect::<Vec<_>>());
        assert!((30..52).chain(0..20).all(|t| gap(t) < 1e-4));
        // A place that is half trusted is half kept.
        seen = truth.clone();
        let frame = &mut seen.tracks[1].frames[25];
        frame.points[0].y += 40.0;
        frame.confidence[0] = 0.25;
        let half = ways(&binding, &[&seen], 0.0).points[1][25];
        assert!((half.y - wished.points[1][25].y - 20.0).abs() < 2.0, "{half}");
    }

    #[test]
    fn motions_of_other_rates_and_lengths_meet() {
        let long = motion(20.0, 41, &[("a", &|t| vec2(t, 0.0))]);
        let short = motion(40.0, 21, &[("b", &|t| vec2(0.0, t))]);
        let uses = |repeat| {
            vec![
                MotionUse { name: "long".into(), ..MotionUse::default() },
                MotionUse { name: "short".into(), repeat, ..MotionUse::default() },
            ]
        };
        let points = [("long", "a"), ("short", "b")];
        let held = ways(&bound(uses(false), &points), &[&long, &short], 0.0);
        assert_eq!((held.frames, held.fps), (41, 20.0));
        assert!((held.points[1][5].y - 70.0).abs() < 1e-4 && (held.points[1][40].y - 80.0).abs() < 1e-4);
        // Twice a frame of its own for each of the take, for as long as it lasts.
        let again = ways(&bound(uses(true), &points), &[&long, &short], 0.0);
        assert!((again.points[1][40].y - 140.0).abs() < 1.0, "{}", again.points[1][40]);
        let turned = ways(&bound(uses(false), &points), &[&short, &long], 0.0);
        assert_eq!(turned.frames, 81);
    }

    #[test]
    fn smoothing_takes_out_noise_only_when_asked() {
        let noisy = motion(25.0, 50, &[("a", &|t| vec2(t, (t * std::f32::consts::PI).cos()))]);
        let binding = bound(vec![], &[("", "a")]);
        let height = |sigma: f32| {
            ways(&binding, &[&noisy], sigma).points[0][10..40].iter().map(|p| (p.y - 59.0).abs()).fold(0.0, f32::max)
        };
        assert!((height(0.0) - 1.0).abs() < 1e-4);
        assert!(height(2.0) < 0.05);
    }
}
