//! Feet that stay where they come down.
//!
//! A foot is down where it is low and goes with the ground. How the ground goes in the picture (the camera follows, or the
//! walk is on the spot) is measured from the low feet themselves: the median first, then, frame by frame, the mean of
//! those that are down, smoothed. While a foot is down it is put where the ground under it has gone, from the middle of
//! where it was; its limb reaches for it (see `limb_reach`), and is let go over a few frames before and after.
//!
//! Known limits: the ground goes alike under all feet, without perspective; level ground, unless the camera tilts it
//! evenly; a foot beyond its limb's length slides the rest of the way.

use glam::DVec2;

use super::limb_reach::reach;
use super::smoothing::whittaker;
use super::{Motion, Track, TrackKind};
use crate::error::{Error, Result};

/// How feet are planted.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantParams {
    /// The tracks that end in feet: limbs, or joints that are feet. Empty for those that are found.
    pub feet: Vec<String>,
    /// Where the ground is, y in pixels. `None` for where each foot comes down.
    pub ground: Option<f64>,
    /// Whether the ground stands still in the picture, rather than going as it is measured to.
    pub still: bool,
    /// Frames before and after over which a foot is let go.
    pub ease: f64,
    /// Whether the motion is a loop in place: feet are held over its seam.
    pub closed: bool,
}

impl Default for PlantParams {
    /// Let go over four frames: a sixth of a second.
    fn default() -> Self {
        Self { feet: Vec::new(), ground: None, still: false, ease: 4.0, closed: false }
    }
}

/// When a foot is down, and how it slid.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Contacts {
    /// The track that ends in it.
    pub track: String,
    /// First and last frames of the spans in which it is down. Of a loop the last may lie beyond its end.
    pub spans: Vec<(usize, usize)>,
    /// Pixels a frame that it slid over the ground while it was down, before and after.
    pub slide: (f64, f64),
}

/// A motion whose feet are planted.
#[derive(Clone, Debug, PartialEq)]
pub struct Planted {
    /// The motion.
    pub motion: Motion,
    /// Each foot.
    pub feet: Vec<Contacts>,
    /// How the ground goes in the picture, the mean over frames, in pixels a frame.
    pub ground: DVec2,
}

impl Planted {
    /// When feet are down and how they slid: `{"ground": [x, y], "feet": [{"track": "leg", "spans": [[0, 9]], "slide": [1.5,
    /// 0.0]}]}`.
    pub fn contacts_json(&self) -> String {
        serde_json::json!({ "ground": self.ground.to_array(), "feet": self.feet }).to_string()
    }
}

/// Feet end as low as the lowest, up to this share of the figure's extent.
const LOW: f64 = 0.12;
/// A foot is low in the lowest share of how far it is lifted; of a limb that is hardly lifted, this share of its length.
const NEAR_GROUND: (f64, f64) = (0.25, 0.02);
/// It goes with the ground where it differs from it by less than this share of what it does when it is fast.
const SLOW: f64 = 0.4;
/// Where the ground goes at all (this share of what a foot does when it is fast), a low foot that goes its way at this
/// share of its speed or more is down, however fast: nothing else goes back along the ground.
const ALONG: (f64, f64) = (0.2, 0.3);
/// A bone shorter than this share of the one above it is part of a foot, not of a leg.
const PART_OF_FOOT: f64 = 0.5;
/// Frames that it is down at least, and that it may seem up in between.
const SHORTEST: usize = 3;
const MISSED: usize = 1;
/// The ground's speed changes over so many frames; a camera is carried more evenly than feet.
const GROUND_PERIOD: f64 = 40.0;
/// What the median speed counts against a foot that is down, where none or few are.
const GROUND_PRIOR: f64 = 0.05;
/// Rounds of finding who is down and how the ground goes.
const ROUNDS: usize = 3;

/// A limb as places of tracks from its root to its foot, with how far it is from one to the other along it.
struct Limb {
    places: Vec<(usize, usize)>,
    /// Tracks that hang from the foot.
    below: Vec<usize>,
    length: f64,
}

/// Plants the feet of `motion`.
///
/// # Errors
/// A track that is not there or has nothing to bend, a ground or an ease out of range, no feet.
pub fn plant(motion: &Motion, params: &PlantParams) -> Result<Planted> {
    motion.checked(SHORTEST)?;
    let given = [params.ground.unwrap_or(0.0), params.ease];
    if !given.iter().all(|v| v.is_finite()) || !(0.0..=1000.0).contains(&params.ease) {
        let problem = format!("are {} and {}", given[0], given[1]);
        return Err(Error::invalid("ground and frames to let go", problem, "give numbers, frames of 0 to 1000"));
    }
    let limbs: Vec<Limb> = if params.feet.is_empty() {
        found_limbs(motion)
    } else {
        params.feet.iter().map(|name| named_limb(motion, name)).collect::<Result<_>>()?
    };
    if limbs.is_empty() {
        let remedy = "name the limbs that end in feet, or joints that hang from others";
        return Err(Error::invalid("feet of the motion", "are not to be found", remedy));
    }
    // A loop is planted with itself before and after, and the middle is what counts.
    let (count, turns) = (motion.frames, if params.closed { 3 } else { 1 });
    let mut made = motion.clone();
    if params.closed {
        super::edit::check_points(motion, count.saturating_mul(turns))?;
        made = motion.at_times(
            &(0..turns * count).map(|f| (f % count) as f64).collect::<Vec<_>>(),
            super::sampling::Ends::Open,
            motion.fps,
        );
    }
    let paths: Vec<Vec<DVec2>> = limbs.iter().map(|l| (0..made.frames).map(|f| l.foot(&made, f)).collect()).collect();
    let (down, way) = contacts(&limbs, &paths, params);
    for ((limb, path), spans) in limbs.iter().zip(&paths).zip(&down) {
        let offsets = offsets(path, spans, &way, params);
        for (f, offset) in offsets.into_iter().enumerate() {
            if offset.length_squared() > 1e-12 {
                limb.reach(&mut made, f, path[f] + offset);
            }
        }
    }
    let after: Vec<Vec<DVec2>> = limbs.iter().map(|l| (0..made.frames).map(|f| l.foot(&made, f)).collect()).collect();
    if params.closed {
        for track in &mut made.tracks {
            track.frames.drain(..count);
            track.frames.truncate(count);
        }
        made.frames = count;
    }
    let first = if params.closed { count } else { 0 };
    let feet = limbs.iter().zip(&down).enumerate().map(|(i, (limb, spans))| Contacts {
        track: made.tracks[limb.places[limb.places.len() - 1].0].name.clone(),
        spans: spans
            .iter()
            .filter(|s| (first..first + count).contains(&s.0))
            .map(|s| (s.0 - first, s.1 - first))
            .collect(),
        slide: (slide(&paths[i], spans, &way), slide(&after[i], spans, &way)),
    });
    let feet: Vec<Contacts> = feet.collect();
    made.validate()?;
    let ground = (way[way.len() - 1] - way[0]) / (way.len() - 1) as f64;
    Ok(Planted { motion: made, feet, ground })
}

impl Limb {
    /// Of a stroke: all its points, from the end that hangs.
    fn stroke(motion: &Motion, track: usize) -> Self {
        let own = &motion.tracks[track];
        let count = own.frames[0].points.len();
        let above = motion.bones.iter().find(|b| b.1 == own.name).and_then(|b| motion.track(&b.0));
        let turned = above.is_some_and(|above| {
            let gap = |point: usize| -> f64 {
                let near = |f: usize| {
                    let p = own.frames[f].points[point];
                    above.frames[f].points.iter().map(|q| f64::from(q.distance(p))).fold(f64::INFINITY, f64::min)
                };
                (0..motion.frames).map(near).sum()
            };
            gap(count - 1) < gap(0)
        });
        let mut places: Vec<(usize, usize)> = (0..count).map(|p| (track, p)).collect();
        if turned {
            places.reverse();
        }
        Self::of(motion, places, Vec::new())
    }

    /// Of a joint: itself, the joint it hangs from, and the one that hangs from.
    fn joint(motion: &Motion, track: usize) -> Self {
        let find = |name: &str| motion.tracks.iter().position(|t| t.name == name);
        let above = |t: usize| motion.bones.iter().find(|b| b.1 == motion.tracks[t].name).and_then(|b| find(&b.0));
        let mut places = vec![(track, 0)];
        let mut at = track;
        while let Some(next) = above(at).filter(|n| places.len() < 3 && places.iter().all(|p| p.0 != *n)) {
            places.push((next, 0));
            at = next;
        }
        places.reverse();
        let mut below = vec![track];
        let mut next = 0;
        while next < below.len() {
            let name = &motion.tracks[below[next]].name;
            let hanging = motion.bones.iter().filter(|b| b.0 == *name).filter_map(|b| find(&b.1));
            let new: Vec<usize> = hanging.filter(|t| !below.contains(t) && places.iter().all(|p| p.0 != *t)).collect();
            below.extend(new);
            next += 1;
        }
        below.remove(0);
        Self::of(motion, places, below)
    }

    fn of(motion: &Motion, places: Vec<(usize, usize)>, below: Vec<usize>) -> Self {
        let length = |f: usize| -> f64 {
            let at = |p: &(usize, usize)| motion.tracks[p.0].frames[f].points[p.1].as_dvec2();
            places.windows(2).map(|p| at(&p[0]).distance(at(&p[1]))).sum()
        };
        let mut lengths: Vec<f64> = (0..motion.frames).map(length).collect();
        lengths.sort_by(f64::total_cmp);
        let length = lengths[lengths.len() / 2];
        Self { places, below, length }
    }

    fn at(&self, motion: &Motion, frame: usize) -> Vec<DVec2> {
        self.places.iter().map(|&(t, p)| motion.tracks[t].frames[frame].points[p].as_dvec2()).collect()
    }

    fn foot(&self, motion: &Motion, frame: usize) -> DVec2 {
        let (track, point) = self.places[self.places.len() - 1];
        motion.tracks[track].frames[frame].points[point].as_dvec2()
    }

    fn reach(&self, motion: &mut Motion, frame: usize, target: DVec2) {
        let before = self.at(motion, frame);
        let after = reach(&before, target);
        for (&(track, point), place) in self.places.iter().zip(&after) {
            motion.tracks[track].frames[frame].points[point] = place.as_vec2();
        }
        let moved = (after[after.len() - 1] - before[before.len() - 1]).as_vec2();
        for &track in &self.below {
            motion.tracks[track].frames[frame].points.iter_mut().for_each(|p| *p += moved);
        }
    }
}

fn named_limb(motion: &Motion, name: &str) -> Result<Limb> {
    let Some(track) = motion.tracks.iter().position(|t| t.name == name) else {
        let tracks = super::matching::listed(motion.tracks.iter().map(|t| t.name.as_str()));
        let problem = format!("is no track of the motion, whose tracks are {tracks}");
        return Err(Error::invalid(format!("foot `{name}`"), problem, "name one of them"));
    };
    let limb = match motion.tracks[track].kind {
        TrackKind::Stroke => Limb::stroke(motion, track),
        _ => Limb::joint(motion, track),
    };
    if limb.places.len() < 2 {
        let remedy = "name a limb of two points at least, or a joint that hangs from another";
        return Err(Error::invalid(format!("foot `{name}`"), "has nothing to bend", remedy));
    }
    Ok(limb)
}

/// Limbs and joints that hang on something, that nothing hangs on, and whose ends come as low as the lowest.
fn found_limbs(motion: &Motion) -> Vec<Limb> {
    let strokes = motion.tracks.iter().any(|t| t.kind == TrackKind::Stroke);
    let carries = |t: &Track| motion.bones.iter().any(|b| b.0 == t.name);
    let hangs = |t: &Track| motion.bones.iter().any(|b| b.1 == t.name);
    let candidates = motion.tracks.iter().enumerate().filter(|(_, t)| match strokes {
        // A stroke that others hang on may still be a leg: the tree is drawn in any order.
        true => t.kind == TrackKind::Stroke && (hangs(t) || carries(t)),
        false => t.kind == TrackKind::Joint && hangs(t) && !carries(t),
    });
    let joint = |leaf: usize| {
        // Toes are carried by the foot that is planted.
        let mut limb = Limb::joint(motion, leaf);
        while let [above, knee, foot] = limb.places[..] {
            let length = |a: (usize, usize), b: (usize, usize)| Limb::of(motion, vec![a, b], Vec::new()).length;
            if length(knee, foot) >= PART_OF_FOOT * length(above, knee) {
                break;
            }
            limb = Limb::joint(motion, knee.0);
        }
        limb
    };
    let limbs: Vec<Limb> = candidates.map(|(i, _)| if strokes { Limb::stroke(motion, i) } else { joint(i) }).collect();
    let limbs: Vec<Limb> = limbs.into_iter().filter(|l| l.places.len() > 1).collect();
    let level = |l: &Limb| {
        let heights: Vec<f64> = (0..motion.frames).map(|f| l.foot(motion, f).y).collect();
        quantile(heights, 0.9)
    };
    let levels: Vec<f64> = limbs.iter().map(level).collect();
    let lowest = levels.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let reach = LOW * motion.extent();
    limbs.into_iter().zip(levels).filter(|(_, level)| lowest - level <= reach).map(|(limb, _)| limb).collect()
}

/// The value that a share of all lies below.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(((values.len().saturating_sub(1)) as f64 * share).round() as usize).copied().unwrap_or(0.0)
}

/// Spans of frames in which each foot is down, and where the ground has gone by each frame.
fn contacts(limbs: &[Limb], paths: &[Vec<DVec2>], params: &PlantParams) -> (Vec<Vec<(usize, usize)>>, Vec<DVec2>) {
    let count = paths[0].len();
    // Speeds over the two frames on either side: one frame's jitter is as much as a slow foot's way.
    let speed = |path: &[DVec2], f: usize| {
        let (a, b) = (f.saturating_sub(1), (f + 1).min(count - 1));
        (path[b] - path[a]) / (b - a).max(1) as f64
    };
    let speeds: Vec<Vec<DVec2>> = paths.iter().map(|p| (0..count).map(|f| speed(p, f)).collect()).collect();
    let low: Vec<Vec<bool>> = limbs
        .iter()
        .zip(paths)
        .map(|(limb, path)| {
            let level = |share: f64| quantile(path.iter().map(|p| p.y).collect(), share);
            let lift = NEAR_GROUND.0 * (level(0.9) - level(0.1));
            path.iter().map(|p| p.y >= level(0.9) - lift.max(NEAR_GROUND.1 * limb.length)).collect()
        })
        .collect();
    let mut grounds = vec![DVec2::ZERO; count];
    if !params.still {
        // In the middle of a span in which it is low a foot goes with the ground; at its ends it comes and goes.
        let within = |(speeds, low): (&Vec<DVec2>, &Vec<bool>)| -> Vec<DVec2> {
            let middle = |(a, b): (usize, usize)| speeds[a + (b - a) / 4..=b - (b - a) / 4].to_vec();
            spans(low).into_iter().flat_map(middle).collect()
        };
        let while_low: Vec<DVec2> = speeds.iter().zip(&low).flat_map(within).collect();
        let middle = |axis: fn(&DVec2) -> f64| quantile(while_low.iter().map(axis).collect(), 0.5);
        grounds = vec![DVec2::new(middle(|v| v.x), middle(|v| v.y)); count];
    }
    let mut down: Vec<Vec<bool>> = Vec::new();
    for round in 0..ROUNDS {
        down = speeds
            .iter()
            .zip(&low)
            .map(|(speeds, low)| {
                let apart: Vec<f64> = speeds.iter().zip(&grounds).map(|(s, g)| s.distance(*g)).collect();
                // A foot that never goes anywhere is down for good: a pixel a frame is jitter.
                let fast = quantile(apart.clone(), 0.9);
                let is_down = |f: usize| {
                    let ground = grounds[f];
                    let along = speeds[f].dot(ground) >= ALONG.1 * ground.length_squared();
                    low[f] && (apart[f] <= (SLOW * fast).max(1.0) || (ground.length() >= ALONG.0 * fast && along))
                };
                held(&(0..count).map(is_down).collect::<Vec<_>>())
            })
            .collect();
        if params.still || round + 1 == ROUNDS {
            break;
        }
        grounds = ground_speeds(&speeds, &down, &grounds, params.closed);
    }
    let mut way = vec![DVec2::ZERO];
    for f in 1..count {
        way.push(way[f - 1] + 0.5 * (grounds[f - 1] + grounds[f]));
    }
    (down.iter().map(|d| spans(d)).collect(), way)
}

/// How fast the ground goes, from the feet that are down.
fn ground_speeds(speeds: &[Vec<DVec2>], down: &[Vec<bool>], before: &[DVec2], even: bool) -> Vec<DVec2> {
    let count = before.len();
    let prior = before.iter().sum::<DVec2>() / count as f64;
    let mut values = vec![prior * GROUND_PRIOR; count];
    let mut weights = vec![GROUND_PRIOR; count];
    for (speeds, down) in speeds.iter().zip(down) {
        for (f, speed) in speeds.iter().enumerate() {
            // The first and the last frame of a span feel the foot come and go.
            let within = down[f] && f.checked_sub(1).is_none_or(|g| down[g]) && down.get(f + 1) != Some(&false);
            if within {
                values[f] += *speed;
                weights[f] += 1.0;
            }
        }
    }
    if even {
        let mean = values.iter().sum::<DVec2>() / weights.iter().sum::<f64>();
        return vec![mean; count];
    }
    values.iter_mut().zip(&weights).for_each(|(v, w)| *v /= *w);
    let penalty = (2.0 * (std::f64::consts::PI / GROUND_PERIOD).sin()).powi(-6);
    whittaker(&values, &weights, &vec![false; count], penalty)
}

/// `down` without gaps that are too short, then without spans that are.
fn held(down: &[bool]) -> Vec<bool> {
    let mut out = down.to_vec();
    let up: Vec<bool> = down.iter().map(|d| !d).collect();
    for (a, b) in spans(&up) {
        if a > 0 && b + 1 < down.len() && b - a < MISSED {
            out[a..=b].fill(true);
        }
    }
    for (a, b) in spans(&out.clone()) {
        if b - a + 1 < SHORTEST {
            out[a..=b].fill(false);
        }
    }
    out
}

/// First and last indices of what is true in a row.
fn spans(of: &[bool]) -> Vec<(usize, usize)> {
    let mut out: Vec<(usize, usize)> = Vec::new();
    for f in (0..of.len()).filter(|f| of[*f]) {
        match out.last_mut() {
            Some(last) if last.1 + 1 == f => last.1 = f,
            _ => out.push((f, f)),
        }
    }
    out
}

/// How far a foot is moved in each frame.
fn offsets(path: &[DVec2], spans: &[(usize, usize)], way: &[DVec2], params: &PlantParams) -> Vec<DVec2> {
    let mut out = vec![DVec2::ZERO; path.len()];
    let mut down = vec![false; path.len()];
    spans.iter().for_each(|&(a, b)| down[a..=b].fill(true));
    let share = |steps: usize| 1.0 - super::closing::smoother_step(steps as f64 / (params.ease + 1.0));
    for &(a, b) in spans {
        let place = (a..=b).map(|f| path[f] - way[f]).sum::<DVec2>() / (b - a + 1) as f64;
        let offset = |f: usize| {
            let to = place + way[f];
            DVec2::new(to.x, params.ground.unwrap_or(to.y)) - path[f]
        };
        (a..=b).for_each(|f| out[f] = offset(f));
        for steps in 1..=params.ease.ceil() as usize {
            for (at, from) in [(a.checked_sub(steps), a), (Some(b + steps), b)] {
                if let Some(f) = at.filter(|f| down.get(*f) == Some(&false)) {
                    out[f] += offset(from) * share(steps);
                }
            }
        }
    }
    if let Some(ground) = params.ground {
        // No foot is below the ground.
        for f in (0..path.len()).filter(|f| !down[*f]) {
            out[f].y = out[f].y.min(ground - path[f].y);
        }
    }
    out
}

/// Pixels a frame that a foot slides over the ground while it is down.
fn slide(path: &[DVec2], spans: &[(usize, usize)], way: &[DVec2]) -> f64 {
    let steps = spans.iter().flat_map(|&(a, b)| a..b);
    let (sum, count) = steps.fold((0.0, 0.0), |(sum, count), f| {
        (sum + ((path[f + 1] - path[f]) - (way[f + 1] - way[f])).length(), count + 1.0)
    });
    if count > 0.0 { sum / count } else { 0.0 }
}
