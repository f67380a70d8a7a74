//! Any motion onto any skeleton.
//!
//! Every joint of the target follows a place of a track: a joint or a point, or a place along a limb's stroke. Bones whose
//! both ends follow something take over how the source's way between the two turns and changes its length since the
//! reference frame; other bones turn with the bone they hang from. Roots move by the source's way, scaled by the ratio of
//! the skeletons' lengths. Computed in 64 bits: onto itself a motion comes back to the last digit.
//!
//! Feet are held by moving the knee: where a foot of the source hardly moves, the target's stays where it came down, and
//! the two bones above it bend to reach it (two-bone inverse kinematics by the law of cosines).
//!
//! Known limits: in the plane only; a foot that the two bones cannot reach slides the rest of the way.

use std::collections::BTreeMap;

use glam::{DVec2, Vec2};

use super::matching::{listed, unlike};
use super::{Motion, Track, TrackFrame, TrackKind};
use crate::error::{Error, Result};

/// The skeleton that is to move.
#[derive(Clone, Copy, Debug)]
pub struct RestSkeleton<'a> {
    /// Names and places of the joints at rest, in pixels.
    pub joints: &'a [(String, Vec2)],
    /// Pairs of joints from the root outward; each comes after the one it hangs from.
    pub bones: &'a [[usize; 2]],
    /// Width and height of the picture.
    pub size: (u32, u32),
}

/// A place of a source's track.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SourcePlace {
    /// The track.
    pub track: String,
    /// How far along its points, by their length in the reference frame: 0..=1. Nothing changes for tracks of one point.
    #[serde(default)]
    pub along: f32,
    /// With another track, `along` is the share of the way from this one's first point to that one's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub toward: Option<String>,
}

impl SourcePlace {
    /// The first point of a track.
    pub fn of(track: &str) -> Self {
        Self { track: track.into(), along: 0.0, toward: None }
    }
}

/// Several joints on one stroke, in order, by the length of the bones between them.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Chain {
    /// The track.
    pub track: String,
    /// The target's joints from the track's start to its end.
    pub joints: Vec<String>,
    /// Whether the joints run from the track's end to its start.
    #[serde(default)]
    pub reversed: bool,
}

/// Which joint follows what. Joints that are not named follow the track of their own name, where there is one.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RetargetMap {
    /// Target joint to source place.
    #[serde(default)]
    pub joints: BTreeMap<String, SourcePlace>,
    /// Chains of joints.
    #[serde(default)]
    pub chains: Vec<Chain>,
}

/// What of a bone's direction is carried over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Angles {
    /// How far it turned since the reference frame: the target keeps its own rest pose.
    #[default]
    Relative,
    /// Where it points: the target takes the source's pose.
    Absolute,
}

/// How a motion is carried over.
#[derive(Clone, Debug, PartialEq)]
pub struct RetargetParams {
    /// What of a bone's direction is carried over.
    pub angles: Angles,
    /// The frame of the source that the target's rest pose corresponds to.
    pub reference: usize,
    /// Bones change their length with the source's, up to this factor either way; 1 keeps all lengths.
    pub stretch: f64,
    /// What the root's way is scaled by; `None` for the ratio of the skeletons' lengths.
    pub root_scale: Option<f64>,
    /// Joints that are to stay where they come down.
    pub planted: Vec<String>,
}

impl Default for RetargetParams {
    /// Squash and stretch up to threefold: beyond it, it is a tracking error.
    fn default() -> Self {
        Self { angles: Angles::Relative, reference: 0, stretch: 3.0, root_scale: None, planted: Vec::new() }
    }
}

/// A foot is down where it moves less a frame than this share of what it does when it is fast.
const DOWN: f64 = 0.12;
/// Frames in a row that it must be down, and over which a held foot is let go.
const SHORTEST: usize = 3;
const RELEASE: usize = 3;

/// Carries `motion` onto `skeleton`: a motion of joint tracks, one for each joint.
///
/// # Errors
/// No frames, a reference frame beyond them, a map that names what is not there, no bone whose both ends follow something,
/// a factor out of range.
pub fn retarget(
    motion: &Motion,
    skeleton: RestSkeleton<'_>,
    map: &RetargetMap,
    params: &RetargetParams,
) -> Result<Motion> {
    motion.validate()?;
    if params.reference >= motion.frames {
        let problem = format!("is {} and the motion has {} frames", params.reference, motion.frames);
        return Err(Error::invalid("reference frame", problem, "choose a frame of the motion"));
    }
    let scale_ok = params.root_scale.is_none_or(|s| s.is_finite());
    if !(params.stretch >= 1.0 && params.stretch.is_finite() && scale_ok) {
        return Err(Error::invalid("stretch or root scale", "is out of range", "give a stretch of 1 or more"));
    }
    let places = map.places(motion, &skeleton)?;
    // Source places by joint and frame.
    let over = |p: &Option<SourcePlace>| Some(find(motion, p.as_ref()?, params.reference)?.over(motion));
    let source: Vec<Option<Vec<DVec2>>> = places.iter().map(over).collect();
    let rest: Vec<DVec2> = skeleton.joints.iter().map(|j| j.1.as_dvec2()).collect();
    let parent_of: Vec<Option<usize>> =
        skeleton.bones.iter().map(|b| skeleton.bones.iter().position(|p| p[1] == b[0])).collect();
    let ways: Vec<Option<Vec<DVec2>>> = skeleton
        .bones
        .iter()
        .map(|&[a, b]| match (&source[a], &source[b]) {
            (Some(a), Some(b)) => Some(b.iter().zip(a).map(|(b, a)| *b - *a).collect()),
            _ => None,
        })
        .collect();
    let (mut own, mut theirs) = (0.0, 0.0);
    for (way, &[a, b]) in ways.iter().zip(skeleton.bones) {
        if let Some(way) = way {
            own += rest[a].distance(rest[b]);
            theirs += way[params.reference].length();
        }
    }
    if theirs <= 0.0 {
        return Err(unlike(motion, &skeleton));
    }
    let scale = params.root_scale.unwrap_or(own / theirs);
    let turns: Vec<Option<Vec<f64>>> =
        ways.iter().map(|w| w.as_ref().map(|w| unwrapped(w, params.reference))).collect();
    let mut joints: Vec<Vec<DVec2>> = vec![rest.clone(); motion.frames];
    for (f, now) in joints.iter_mut().enumerate() {
        let mut turned = vec![0.0; skeleton.bones.len()];
        let follow_root = |joint: usize| {
            // A root that follows nothing goes with the first joint of the skeleton that does.
            let leader = source[joint].as_ref().or_else(|| source.iter().flatten().next());
            leader.map_or(DVec2::ZERO, |s| (s[f] - s[params.reference]) * scale)
        };
        for joint in 0..rest.len() {
            if !skeleton.bones.iter().any(|b| b[1] == joint) {
                now[joint] = rest[joint] + follow_root(joint);
            }
        }
        for (b, &[from, to]) in skeleton.bones.iter().enumerate() {
            let before = rest[to] - rest[from];
            let mut way = before;
            match (&ways[b], &turns[b]) {
                (Some(ways), Some(turns)) => {
                    turned[b] = turns[f];
                    let (first, current) = (ways[params.reference], ways[f]);
                    let ratio = if first.length() > 1e-6 { current.length() / first.length() } else { 1.0 };
                    let ratio = ratio.clamp(1.0 / params.stretch, params.stretch);
                    way = match params.angles {
                        Angles::Relative => DVec2::from_angle(turned[b]).rotate(before) * ratio,
                        Angles::Absolute => {
                            let direction = current.try_normalize().unwrap_or(DVec2::from_angle(turned[b]));
                            turned[b] = if before.length() > 0.0 { angle(before, direction) } else { turned[b] };
                            direction * before.length() * ratio
                        }
                    };
                }
                _ => {
                    if let Some(parent) = parent_of[b] {
                        turned[b] = turned[parent];
                        way = DVec2::from_angle(turned[b]).rotate(before);
                    }
                }
            }
            now[to] = now[from] + way;
        }
    }
    for name in &params.planted {
        let foot = skeleton.joints.iter().position(|j| j.0 == *name);
        let Some(foot) = foot else {
            return Err(Error::invalid(
                format!("planted joint `{name}`"),
                "is not there",
                "name a joint of the skeleton",
            ));
        };
        let Some(source) = &source[foot] else {
            return Err(Error::invalid(format!("planted joint `{name}`"), "follows nothing", "map it to a track"));
        };
        plant(&mut joints, skeleton.bones, foot, source);
    }
    let track = |j: usize| Track {
        name: skeleton.joints[j].0.clone(),
        kind: TrackKind::Joint,
        frames: joints.iter().map(|f| TrackFrame::certain(vec![f[j].as_vec2()])).collect(),
    };
    let name = |j: usize| skeleton.joints[j].0.clone();
    Ok(Motion {
        size: skeleton.size,
        fps: motion.fps,
        frames: motion.frames,
        tracks: (0..rest.len()).map(track).collect(),
        bones: skeleton.bones.iter().map(|&[a, b]| (name(a), name(b))).collect(),
    })
}

/// A place of a track, found: between a point of one and a point of the same or another.
struct Found<'a> {
    from: (&'a Track, usize),
    to: (&'a Track, usize),
    share: f64,
}

impl Found<'_> {
    fn over(&self, motion: &Motion) -> Vec<DVec2> {
        let place = |(track, point): (&Track, usize), f: usize| track.frames[f].points[point].as_dvec2();
        let at = |f| match self.share {
            0.0 => place(self.from, f),
            share => place(self.from, f).lerp(place(self.to, f), share),
        };
        (0..motion.frames).map(at).collect()
    }
}

impl RetargetMap {
    /// The source place of each joint: its own, along a chain, or the track of its name.
    ///
    /// # Errors
    /// A joint or a track that is not there, with the names of those that are; a share outside 0..=1.
    pub fn places(&self, motion: &Motion, skeleton: &RestSkeleton<'_>) -> Result<Vec<Option<SourcePlace>>> {
        let joint = |name: &str| {
            let joints = || listed(skeleton.joints.iter().map(|j| j.0.as_str()));
            skeleton.joints.iter().position(|j| j.0 == name).ok_or_else(|| {
                let problem = format!("names no joint of the skeleton, whose joints are {}", joints());
                Error::invalid(format!("map of joint `{name}`"), problem, "check the map")
            })
        };
        let checked = |place: &SourcePlace| {
            let wrong = |problem: String| {
                let what = format!("map to track `{}`", place.track);
                Err(Error::invalid(what, problem, "check the map"))
            };
            if let Some(missing) =
                std::iter::once(&place.track).chain(&place.toward).find(|t| motion.track(t).is_none())
            {
                let tracks = listed(motion.tracks.iter().map(|t| t.name.as_str()));
                return wrong(format!("`{missing}` is no track of the motion, whose tracks are {tracks}"));
            }
            if !(0.0..=1.0).contains(&place.along) {
                return wrong("`along` is not in 0..=1".into());
            }
            Ok(Some(place.clone()))
        };
        let own = |(name, _): &(String, Vec2)| {
            motion.track(name).filter(|t| t.kind != TrackKind::Stroke).map(|t| SourcePlace::of(&t.name))
        };
        let mut places: Vec<Option<SourcePlace>> = skeleton.joints.iter().map(own).collect();
        for chain in &self.chains {
            let joints: Vec<usize> = chain.joints.iter().map(|n| joint(n)).collect::<Result<_>>()?;
            let at = |j: usize| skeleton.joints[j].1.as_dvec2();
            let mut lengths = vec![0.0];
            for pair in joints.windows(2) {
                lengths.push(lengths[lengths.len() - 1] + at(pair[0]).distance(at(pair[1])));
            }
            let total: f64 = lengths[lengths.len() - 1];
            for (j, length) in joints.into_iter().zip(lengths) {
                let along = if total > 0.0 { length / total } else { 0.0 };
                let along = (if chain.reversed { 1.0 - along } else { along }) as f32;
                places[j] = checked(&SourcePlace { along, ..SourcePlace::of(&chain.track) })?;
            }
        }
        for (name, place) in &self.joints {
            places[joint(name)?] = checked(place)?;
        }
        Ok(places)
    }
}

/// Where a place is, by the lengths in the reference frame; `None` for a track without points.
fn find<'a>(motion: &'a Motion, place: &SourcePlace, reference: usize) -> Option<Found<'a>> {
    let track = motion.track(&place.track)?;
    let points = &track.frames[reference].points;
    let whole = |point: usize, share: f64| Found { from: (track, point), to: (track, point + 1), share };
    if points.is_empty() {
        return None;
    }
    if let Some(toward) = &place.toward {
        let to = (motion.track(toward)?, 0);
        return Some(Found { from: (track, 0), to, share: f64::from(place.along) });
    }
    let steps: Vec<f64> = points.windows(2).map(|p| p[0].as_dvec2().distance(p[1].as_dvec2())).collect();
    let mut left = steps.iter().sum::<f64>() * f64::from(place.along);
    for (point, step) in steps.iter().enumerate() {
        if left < *step {
            return Some(whole(point, left / step));
        }
        left -= step;
    }
    Some(whole(if place.along > 0.0 { points.len() - 1 } else { 0 }, 0.0))
}

/// The angle from `a` to `b`, to the last digit near zero too.
pub(super) fn angle(a: DVec2, b: DVec2) -> f64 {
    a.perp_dot(b).atan2(a.dot(b))
}

/// How far a way has turned since frame `reference`, without jumps of whole turns. Where it has no length it keeps its
/// turn.
fn unwrapped(ways: &[DVec2], reference: usize) -> Vec<f64> {
    let mut turns = vec![0.0; ways.len()];
    let mut follow = |frames: &mut dyn Iterator<Item = usize>| {
        let (mut turn, mut last) = (0.0, ways[reference]);
        for f in frames {
            if ways[f].length() > 1e-9 {
                if last.length() > 1e-9 {
                    turn += angle(last, ways[f]);
                }
                last = ways[f];
            }
            turns[f] = turn;
        }
    };
    follow(&mut (reference + 1..ways.len()));
    follow(&mut (0..reference).rev());
    turns
}

/// Holds `foot` where it comes down, while it is down in the `source`.
fn plant(joints: &mut [Vec<DVec2>], bones: &[[usize; 2]], foot: usize, source: &[DVec2]) {
    let speeds: Vec<f64> = source.windows(2).map(|p| p[0].distance(p[1])).collect();
    let mut sorted = speeds.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let Some(fast) = sorted.get(sorted.len() * 9 / 10) else { return };
    // A frame is down when the foot moves little on either side of it.
    let slow = |f: usize| {
        let before = f.checked_sub(1).map(|g| speeds[g]);
        let sides = before.into_iter().chain(speeds.get(f).copied());
        sides.fold(f64::INFINITY, f64::min) <= DOWN * fast
    };
    let above = |joint: usize| bones.iter().find(|b| b[1] == joint).map(|b| b[0]);
    let Some(knee) = above(foot) else { return };
    let hip = above(knee);
    let mut f = 0;
    while f < source.len() {
        let from = f;
        while f < source.len() && slow(f) {
            f += 1;
        }
        if f - from >= SHORTEST {
            let held = joints[from][foot];
            for (g, now) in joints.iter_mut().enumerate().take((f + RELEASE).min(source.len())).skip(from) {
                let late = g.saturating_sub(f - 1) as f64 / (RELEASE + 1) as f64;
                let wished = held.lerp(now[foot], late);
                reach(now, bones, hip, knee, foot, wished);
            }
        }
        f = f.max(from + 1);
    }
}

/// Brings the foot to `wished` by bending the two bones above it the way they are bent; what hangs from it goes along.
fn reach(now: &mut [DVec2], bones: &[[usize; 2]], hip: Option<usize>, knee: usize, foot: usize, wished: DVec2) {
    let foot_was = now[foot];
    let target = match hip {
        Some(hip) => {
            let leg = super::limb_reach::reach(&[now[hip], now[knee], foot_was], wished);
            now[knee] = leg[1];
            leg[2]
        }
        None => wished,
    };
    let moved = target - foot_was;
    now[foot] = target;
    let mut below = vec![foot];
    while let Some(joint) = below.pop() {
        for b in bones.iter().filter(|b| b[0] == joint) {
            now[b[1]] += moved;
            below.push(b[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    fn names(places: &[(&str, f32, f32)]) -> Vec<(String, Vec2)> {
        places.iter().map(|&(n, x, y)| (n.to_string(), vec2(x, y))).collect()
    }

    /// A leg that swings and stands, with a toe; it stretches a little as it goes.
    fn walk(joints: &[(String, Vec2)], bones: &[[usize; 2]], frames: usize) -> Motion {
        let place = |j: usize, f: usize| {
            let t = f as f32 * 0.37;
            let swing = Vec2::from_angle(0.6 * t.sin() + 0.05 * j as f32 * (t.cos() - 1.0));
            let rest = joints[j].1;
            joints[0].1
                + swing.rotate(rest - joints[0].1) * (1.0 + 0.05 * (t * 2.0).sin())
                + vec2(3.1 * f as f32, t.sin())
        };
        Motion {
            size: (640, 480),
            fps: 25.0,
            frames,
            tracks: joints
                .iter()
                .enumerate()
                .map(|(j, (name, _))| Track {
                    name: name.clone(),
                    kind: TrackKind::Joint,
                    frames: (0..frames).map(|f| TrackFrame::certain(vec![place(j, f)])).collect(),
                })
                .collect(),
            bones: bones.iter().map(|&[a, b]| (joints[a].0.clone(), joints[b].0.clone())).collect(),
        }
    }

    const BONES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 3]];

    fn leg() -> Vec<(String, Vec2)> {
        names(&[("hip", 201.3, 100.7), ("knee", 215.9, 170.2), ("foot", 205.5, 240.1), ("toe", 230.6, 246.3)])
    }

    #[test]
    fn onto_itself_a_motion_comes_back_to_the_last_digit() {
        let joints = leg();
        let motion = walk(&joints, &BONES, 60);
        let first: Vec<(String, Vec2)> =
            motion.tracks.iter().map(|t| (t.name.clone(), t.frames[0].points[0])).collect();
        let skeleton = RestSkeleton { joints: &first, bones: &BONES, size: (640, 480) };
        for angles in [Angles::Relative, Angles::Absolute] {
            let params = RetargetParams { angles, ..RetargetParams::default() };
            let own = retarget(&motion, skeleton, &RetargetMap::default(), &params).expect("carried over");
            for (a, b) in own.tracks.iter().zip(&motion.tracks) {
                for (a, b) in a.frames.iter().zip(&b.frames) {
                    assert!(a.points[0].as_dvec2().distance(b.points[0].as_dvec2()) < 1e-6);
                }
            }
        }
    }

    #[test]
    fn a_larger_skeleton_of_another_pose_keeps_its_pose_or_takes_the_sources() {
        let motion = walk(&leg(), &BONES, 30);
        let other = names(&[("hip", 50.0, 50.0), ("knee", 190.0, 60.0), ("foot", 330.0, 50.0), ("toe", 380.0, 50.0)]);
        let skeleton = RestSkeleton { joints: &other, bones: &BONES, size: (900, 900) };
        let go = |angles| {
            let params = RetargetParams { angles, ..RetargetParams::default() };
            retarget(&motion, skeleton, &RetargetMap::default(), &params).expect("carried over")
        };
        let at = |m: &Motion, name: &str, f: usize| m.track(name).expect("track").frames[f].points[0];
        assert!(at(&go(Angles::Relative), "foot", 0).distance(vec2(330.0, 50.0)) < 1e-3);
        let (absolute, f) = (go(Angles::Absolute), 17);
        let direction = |m: &Motion| (at(m, "foot", f) - at(m, "knee", f)).normalize();
        assert!(direction(&absolute).distance(direction(&motion)) < 1e-5);
        let length = |m: &Motion, f: usize| at(m, "foot", f).distance(at(m, "knee", f));
        assert!((length(&absolute, f) / length(&absolute, 0) - length(&motion, f) / length(&motion, 0)).abs() < 1e-4);
        let ratio = (140.36 + 140.36 + 50.0)
            / (leg()[0].1.distance(leg()[1].1) + leg()[1].1.distance(leg()[2].1) + leg()[2].1.distance(leg()[3].1));
        let way = |m: &Motion| at(m, "hip", 29) - at(m, "hip", 0);
        assert!((way(&absolute).length() / way(&motion).length() - ratio).abs() < 0.01);
    }

    #[test]
    fn a_stroke_drives_a_chain_and_what_follows_nothing_goes_along() {
        let frames = 12;
        let tail = |f: usize| {
            (0..=10).map(|i| vec2(100.0, 100.0) + 10.0 * i as f32 * Vec2::from_angle(0.1 * f as f32)).collect()
        };
        let motion = Motion {
            size: (300, 300),
            fps: 10.0,
            frames,
            tracks: vec![Track {
                name: "tail".into(),
                kind: TrackKind::Stroke,
                frames: (0..frames).map(|f| TrackFrame::certain(tail(f))).collect(),
            }],
            bones: Vec::new(),
        };
        let joints = names(&[("base", 10.0, 10.0), ("mid", 10.0, 60.0), ("tip", 10.0, 110.0), ("ring", 20.0, 110.0)]);
        let skeleton = RestSkeleton { joints: &joints, bones: &BONES, size: (200, 200) };
        let chain =
            Chain { track: "tail".into(), joints: ["base", "mid", "tip"].map(String::from).into(), reversed: false };
        let map = RetargetMap { chains: vec![chain], ..RetargetMap::default() };
        let own = retarget(&motion, skeleton, &map, &RetargetParams::default()).expect("carried over");
        let turn = Vec2::from_angle(0.5);
        let at = |name: &str| own.track(name).expect("track").frames[5].points[0];
        assert!(at("tip").distance(vec2(10.0, 10.0) + turn.rotate(vec2(0.0, 100.0))) < 1e-3);
        assert!(at("ring").distance(vec2(10.0, 10.0) + turn.rotate(vec2(10.0, 100.0))) < 1e-3);
        for map in [
            RetargetMap::default(),
            RetargetMap { joints: [("nose".to_string(), SourcePlace::of("tail"))].into(), ..RetargetMap::default() },
            RetargetMap { joints: [("tip".to_string(), SourcePlace::of("fin"))].into(), ..RetargetMap::default() },
            RetargetMap {
                joints: [("tip".to_string(), SourcePlace { along: 7.0, ..SourcePlace::of("tail") })].into(),
                ..RetargetMap::default()
            },
        ] {
            assert!(retarget(&motion, skeleton, &map, &RetargetParams::default()).is_err());
        }
        let late = RetargetParams { reference: 99, ..RetargetParams::default() };
        assert!(retarget(&motion, skeleton, &map, &late).is_err());
    }

    #[test]
    fn a_foot_that_stands_is_held() {
        let joints = names(&[("hip", 100.0, 100.0), ("knee", 110.0, 150.0), ("foot", 100.0, 200.0)]);
        let bones = [[0, 1], [1, 2]];
        // The hip moves on; the foot stands for ten frames and swings for ten.
        let foot = |f: usize| if f < 10 { 100.0 } else { 100.0 + 8.0 * (f - 10) as f32 };
        let place = |j: usize, f: usize| match j {
            0 => vec2(90.0 + 3.0 * f as f32, 100.0),
            1 => vec2(0.5 * (90.0 + 3.0 * f as f32 + foot(f)) + 12.0, 150.0),
            _ => vec2(foot(f), 198.0),
        };
        let track = |j: usize| Track {
            name: joints[j].0.clone(),
            kind: TrackKind::Joint,
            frames: (0..20).map(|f| TrackFrame::certain(vec![place(j, f)])).collect(),
        };
        let motion =
            Motion { size: (300, 300), fps: 10.0, frames: 20, tracks: (0..3).map(track).collect(), bones: Vec::new() };
        let other = names(&[("hip", 100.0, 100.0), ("knee", 150.0, 190.0), ("foot", 100.0, 215.0)]);
        let skeleton = RestSkeleton { joints: &other, bones: &bones, size: (300, 300) };
        let slide = |planted: Vec<String>| {
            let params = RetargetParams { planted, ..RetargetParams::default() };
            let own = retarget(&motion, skeleton, &RetargetMap::default(), &params).expect("carried over");
            let feet: Vec<Vec2> = own.track("foot").expect("track").frames.iter().map(|f| f.points[0]).collect();
            let longest = feet[1..10].iter().map(|p| p.distance(feet[0])).fold(0.0, f32::max);
            let jump = feet.windows(2).map(|p| p[0].distance(p[1])).fold(0.0, f32::max);
            (longest, jump)
        };
        assert!(slide(Vec::new()).0 > 1.0);
        let (longest, jump) = slide(vec!["foot".into()]);
        assert!(longest < 1e-3 && jump < 25.0, "{longest} {jump}");
        let unknown = RetargetParams { planted: vec!["wing".into()], ..RetargetParams::default() };
        assert!(retarget(&motion, skeleton, &RetargetMap::default(), &unknown).is_err());
    }
}
