//! Any motion onto the limbs of a creature, and which limb follows what.
//!
//! Every limb of the creature follows a source: a stroke's track, or joints or points in a row. It takes over how the source
//! turns, place for place along its length, from the source's mean pose (or a frame of it), and keeps its own lengths,
//! its own mean pose, and its place on the limb that carries it. Limbs that follow nothing go with what they hang from. The
//! way of the whole is scaled by the figures' sizes; a source that faces the other way is mirrored.
//!
//! Without a map limbs are paired with the source's strokes, or with the chains between the branches of its joints: by
//! names, by what parts and sides names speak of, and by where limbs begin, end and point in the figure.
//!
//! Known limits: in the plane; a limb hangs by its first point; one chain goes to one limb, so that a neck and a head drawn
//! apart do not both follow one chain of joints; names are understood in English.

use std::collections::BTreeMap;

use glam::{DVec2, Vec2};
use serde::{Deserialize, Serialize};

use super::matching::{MOST_PLACES, listed, paired, prune};
use super::retarget::{Angles, Chain, RestSkeleton, RetargetMap, RetargetParams, retarget};
use super::{Motion, Track, TrackFrame, TrackKind};
use crate::error::{Error, Result};
use crate::rig::Facing;

/// A limb of a creature at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct RestLimb {
    /// Its label.
    pub name: String,
    /// The limb that carries it, by index.
    pub parent: Option<usize>,
    /// Its points from where it hangs, in pixels.
    pub points: Vec<Vec2>,
}

/// What a limb follows.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LimbSource {
    /// A stroke's track; or joints or points, from where the limb hangs to its end.
    pub tracks: Vec<String>,
    /// Whether it runs the other way: from the end to where the limb hangs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub reversed: bool,
    /// Where to a limb in space leaves the image plane when it is drawn short.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facing: Option<Facing>,
}

/// Which limb follows what.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LimbMap {
    /// By the limb's label.
    pub limbs: BTreeMap<String, LimbSource>,
}

/// How a motion is carried over to limbs.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbMapParams {
    /// Whether limbs turn as the source's do, or point where they point.
    pub angles: Angles,
    /// The source's frame that the limbs at rest correspond to; `None` for its mean pose.
    pub reference: Option<usize>,
    /// Limbs change their length with the source's, up to this factor either way; 1 keeps lengths.
    pub stretch: f64,
    /// What the way of the whole is scaled by; `None` for the ratio of the figures' sizes, 0 to stay in place.
    pub travel: Option<f64>,
    /// Whether the source is mirrored; `None` where it faces the other way.
    pub mirror: Option<bool>,
}

impl Default for LimbMapParams {
    fn default() -> Self {
        Self { angles: Angles::Relative, reference: None, stretch: 1.0, travel: None, mirror: None }
    }
}

const FORMAT: &str = "marey-limb-map";

#[derive(Serialize, Deserialize)]
struct MapFile {
    #[serde(default)]
    format: Option<String>,
    #[serde(default)]
    version: Option<u32>,
    limbs: BTreeMap<String, LimbSource>,
}

impl LimbMap {
    /// Reads the text of a limb map: `{"format": "marey-limb-map", "version": 1, "limbs": {"fore_near": {"tracks":
    /// ["LeftArm", "LeftForeArm", "LeftHand"], "reversed": true, "facing": "toward"}}}`. Format and version may be left out.
    ///
    /// # Errors
    /// What is not readable as one.
    pub fn from_json(text: &str) -> Result<Self> {
        let bad = |problem: String| Error::invalid("limb map", problem, "expected a marey-limb-map file");
        let file: MapFile = serde_json::from_str(text).map_err(|e| bad(format!("is not readable: {e}")))?;
        if file.format.is_some_and(|f| f != FORMAT) || file.version.is_some_and(|v| v != 1) {
            return Err(bad(format!("is not in the format {FORMAT}, version 1")));
        }
        if file.limbs.is_empty() {
            return Err(bad("names no limbs".into()));
        }
        Ok(Self { limbs: file.limbs })
    }

    /// The text of a limb map.
    pub fn to_json(&self) -> String {
        let file = MapFile { format: Some(FORMAT.into()), version: Some(1), limbs: self.limbs.clone() };
        serde_json::to_string_pretty(&file).unwrap_or_default()
    }
}

/// The limbs of a creature from its own motion's strokes: in a frame, or its mean pose.
///
/// # Errors
/// No strokes, a frame that is not there, bones that close a circle.
pub fn rest_limbs(motion: &Motion, frame: Option<usize>) -> Result<Vec<RestLimb>> {
    motion.checked(1)?;
    if let Some(frame) = frame.filter(|f| *f >= motion.frames) {
        let problem = format!("is {frame} and the motion has {} frames", motion.frames);
        return Err(Error::invalid("frame of the limbs at rest", problem, "choose a frame of the motion"));
    }
    let strokes: Vec<&Track> = motion.tracks.iter().filter(|t| t.kind == TrackKind::Stroke).collect();
    let find = |name: &str| strokes.iter().position(|t| t.name == name);
    let parent: Vec<Option<usize>> =
        strokes.iter().map(|t| motion.bones.iter().find(|b| b.1 == t.name).and_then(|b| find(&b.0))).collect();
    let rest = |t: &&Track| match frame {
        Some(frame) => t.frames[frame].points.iter().map(|p| p.as_dvec2()).collect(),
        None => mean_pose(&places(t)),
    };
    let mut poses: Vec<Vec<DVec2>> = strokes.iter().map(rest).collect();
    for limb in in_order(&parent)? {
        // Where it hangs over all frames, it hangs at rest.
        if let (Some(above), None) = (parent[limb], frame) {
            let (point, offset) = hung(strokes[limb], strokes[above]);
            let moved = poses[above][point] + offset - poses[limb][0];
            poses[limb].iter_mut().for_each(|p| *p += moved);
        }
    }
    let limb = |i: usize| RestLimb {
        name: strokes[i].name.clone(),
        parent: parent[i],
        points: poses[i].iter().map(|p| p.as_vec2()).collect(),
    };
    let limbs: Vec<RestLimb> = (0..strokes.len()).map(limb).collect();
    check_limbs(&limbs)?;
    Ok(limbs)
}

/// Limbs with those that carry before those that are carried.
fn in_order(parent: &[Option<usize>]) -> Result<Vec<usize>> {
    let mut order: Vec<usize> = (0..parent.len()).filter(|l| parent[*l].is_none()).collect();
    let mut next = 0;
    while next < order.len() {
        let above = order[next];
        order.extend((0..parent.len()).filter(|l| parent[*l] == Some(above)));
        next += 1;
    }
    if order.len() < parent.len() {
        return Err(Error::invalid("limbs of the creature", "carry one another in a circle", "leave one bone out"));
    }
    Ok(order)
}

fn check_limbs(limbs: &[RestLimb]) -> Result<()> {
    let wrong = |what: String, problem: &str| Err(Error::invalid(what, problem, "give limbs of two points at least"));
    if limbs.is_empty() {
        return wrong("creature".into(), "has no limbs");
    }
    for (i, limb) in limbs.iter().enumerate() {
        let what = || format!("limb `{}`", limb.name);
        if limb.points.len() < 2 || !limb.points.iter().all(|p| p.is_finite()) {
            return wrong(what(), "has fewer than two points, or one that is no number");
        }
        if limb.parent.is_some_and(|p| p >= limbs.len()) {
            return wrong(what(), "hangs on a limb that is not there");
        }
        if limbs[..i].iter().any(|l| l.name == limb.name) {
            return wrong(what(), "is there twice");
        }
    }
    Ok(())
}

fn places(track: &Track) -> Vec<Vec<DVec2>> {
    track.frames.iter().map(|f| f.points.iter().map(|p| p.as_dvec2()).collect()).collect()
}

/// The point of `above` that `limb` hangs nearest to over all frames, and how far from it on average.
fn hung(limb: &Track, above: &Track) -> (usize, DVec2) {
    let offsets = |point: usize| {
        above.frames.iter().zip(&limb.frames).map(move |(a, l)| l.points[0].as_dvec2() - a.points[point].as_dvec2())
    };
    let far = |point: usize| offsets(point).map(|o| o.length()).sum::<f64>();
    let point = (0..above.frames[0].points.len()).min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap_or(0);
    (point, offsets(point).sum::<DVec2>() / above.frames.len() as f64)
}

/// The mean pose of a line: its mean first place, and each segment's mean direction and length.
fn mean_pose(frames: &[Vec<DVec2>]) -> Vec<DVec2> {
    let count = frames.len() as f64;
    let mut out = vec![frames.iter().map(|f| f[0]).sum::<DVec2>() / count];
    for i in 1..frames[0].len() {
        let segments = || frames.iter().map(|f| f[i] - f[i - 1]);
        let direction = segments().map(|s| s.normalize_or_zero()).sum::<DVec2>();
        let direction = direction.try_normalize().unwrap_or(segments().next().unwrap_or_default().normalize_or_zero());
        out.push(out[i - 1] + direction * (segments().map(|s| s.length()).sum::<f64>() / count));
    }
    out
}

/// A source in every frame, from where the limb hangs.
fn line(motion: &Motion, limb: &str, source: &LimbSource) -> Result<Vec<Vec<DVec2>>> {
    let what = || format!("source of limb `{limb}`");
    let mut lines: Vec<Vec<DVec2>> = vec![Vec::new(); motion.frames];
    for name in &source.tracks {
        let Some(track) = motion.track(name) else {
            let tracks = listed(motion.tracks.iter().map(|t| t.name.as_str()));
            let problem = format!("`{name}` is no track of the motion, whose tracks are {tracks}");
            return Err(Error::invalid(what(), problem, "check the map"));
        };
        for (line, frame) in lines.iter_mut().zip(&track.frames) {
            let all = track.kind == TrackKind::Stroke;
            line.extend(frame.points.iter().take(if all { usize::MAX } else { 1 }).map(|p| p.as_dvec2()));
        }
    }
    if lines.iter().any(|l| l.len() < 2) {
        return Err(Error::invalid(what(), "has fewer than two points", "name a stroke, or two joints at least"));
    }
    if source.reversed {
        lines.iter_mut().for_each(|l| l.reverse());
    }
    Ok(lines)
}

/// Carries `motion` onto the limbs of a creature in a picture of `size` pixels: a motion with a stroke for every limb, under
/// its label, with as many points as the limb has at rest.
///
/// # Errors
/// Limbs or a map that name what is not there, limbs in a circle, a reference beyond the end, a factor out of range.
pub fn map_limbs(
    motion: &Motion,
    limbs: &[RestLimb],
    size: (u32, u32),
    map: &LimbMap,
    params: &LimbMapParams,
) -> Result<Motion> {
    motion.checked(1)?;
    check_limbs(limbs)?;
    if let Some(unknown) = map.limbs.keys().find(|name| limbs.iter().all(|l| l.name != **name)) {
        let problem =
            format!("is none of the creature, whose limbs are {}", listed(limbs.iter().map(|l| l.name.as_str())));
        return Err(Error::invalid(format!("limb `{unknown}` of the map"), problem, "check the map"));
    }
    if let Some(reference) = params.reference.filter(|r| *r >= motion.frames) {
        let problem = format!("is {reference} and the motion has {} frames", motion.frames);
        return Err(Error::invalid("reference frame", problem, "choose a frame of the motion"));
    }
    let mirror = match params.mirror {
        Some(mirror) => mirror,
        None => faces_other_way(motion, limbs, map)?,
    };
    // The source as one stroke for each limb that follows something, after a frame of its reference pose.
    let mut sources = Vec::new();
    let mut chains = Vec::new();
    for limb in limbs {
        let Some(source) = map.limbs.get(&limb.name) else { continue };
        let mut lines = line(motion, &limb.name, source)?;
        if mirror {
            lines.iter_mut().flatten().for_each(|p| p.x = f64::from(motion.size.0) - p.x);
        }
        let reference = params.reference.map_or_else(|| mean_pose(&lines), |r| lines[r].clone());
        lines.insert(0, reference);
        let frames = lines.iter().map(|l| TrackFrame::certain(l.iter().map(|p| p.as_vec2()).collect())).collect();
        sources.push(Track { name: limb.name.clone(), kind: TrackKind::Stroke, frames });
        let joints = (0..limb.points.len()).map(|p| joint(&limb.name, p)).collect();
        chains.push(Chain { track: limb.name.clone(), joints, reversed: false });
    }
    let frames = motion.frames + 1;
    let source = Motion { size: motion.size, fps: motion.fps, frames, tracks: sources, bones: Vec::new() };
    let (joints, bones) = skeleton(limbs)?;
    let how = RetargetParams {
        angles: params.angles,
        reference: 0,
        stretch: params.stretch,
        root_scale: params.travel,
        planted: Vec::new(),
    };
    let map = RetargetMap { joints: BTreeMap::new(), chains };
    let carried = retarget(&source, RestSkeleton { joints: &joints, bones: &bones, size }, &map, &how)?;
    let mut at = 0;
    let tracks = limbs.iter().map(|limb| {
        let own = at..at + limb.points.len();
        at = own.end;
        let frame = |f: usize| {
            let points: Vec<Vec2> = own.clone().map(|j| carried.tracks[j].frames[f].points[0]).collect();
            // Nobody drew it.
            TrackFrame { confidence: vec![0.99; points.len()], ..TrackFrame::certain(points) }
        };
        Track { name: limb.name.clone(), kind: TrackKind::Stroke, frames: (1..frames).map(frame).collect() }
    });
    let tracks: Vec<Track> = tracks.collect();
    let bone = |l: &RestLimb| l.parent.map(|p| (limbs[p].name.clone(), l.name.clone()));
    let bones = limbs.iter().filter_map(bone).collect();
    let made = Motion { size, fps: motion.fps, frames: motion.frames, tracks, bones };
    made.validate()?;
    Ok(made)
}

/// A name that no label has: labels hold no line breaks.
fn joint(limb: &str, point: usize) -> String {
    format!("{limb}\n{point}")
}

/// Limbs as joints and bones: their points in order; then, for each that hangs, a joint at its first point that goes with
/// the limb above.
#[expect(clippy::type_complexity, reason = "what a skeleton at rest is made of")]
fn skeleton(limbs: &[RestLimb]) -> Result<(Vec<(String, Vec2)>, Vec<[usize; 2]>)> {
    let parent: Vec<Option<usize>> = limbs.iter().map(|l| l.parent).collect();
    let first: Vec<usize> = limbs
        .iter()
        .scan(0, |at, l| {
            let own = *at;
            *at += l.points.len();
            Some(own)
        })
        .collect();
    let named = |l: &RestLimb| l.points.iter().enumerate().map(|(i, p)| (joint(&l.name, i), *p)).collect::<Vec<_>>();
    let mut joints: Vec<(String, Vec2)> = limbs.iter().flat_map(named).collect();
    let mut bones = Vec::new();
    for limb in in_order(&parent)? {
        let root = limbs[limb].points[0];
        if let Some(above) = parent[limb] {
            let near = |p: &&(usize, &Vec2)| p.1.distance_squared(root);
            let points = || limbs[above].points.iter().enumerate();
            let nearest = points().min_by(|a, b| near(&a).total_cmp(&near(&b))).map_or(0, |p| p.0);
            joints.push((joint(&limbs[limb].name, usize::MAX), root));
            bones.push([first[above] + nearest, joints.len() - 1]);
            bones.push([joints.len() - 1, first[limb]]);
        }
        bones.extend((1..limbs[limb].points.len()).map(|i| [first[limb] + i - 1, first[limb] + i]));
    }
    Ok((joints, bones))
}

/// Whether the source's limbs lie beside each other the other way round than the creature's.
fn faces_other_way(motion: &Motion, limbs: &[RestLimb], map: &LimbMap) -> Result<bool> {
    let mut pairs = Vec::new();
    for limb in limbs {
        let Some(source) = map.limbs.get(&limb.name) else { continue };
        let mean = mean_pose(&line(motion, &limb.name, source)?);
        let middle = |sum: f64, count: usize| sum / count as f64;
        let own = middle(limb.points.iter().map(|p| f64::from(p.x)).sum(), limb.points.len());
        pairs.push((own, middle(mean.iter().map(|p| p.x).sum(), mean.len())));
    }
    let along: f64 =
        pairs.iter().enumerate().flat_map(|(i, a)| pairs[..i].iter().map(move |b| (a.0 - b.0) * (a.1 - b.1))).sum();
    Ok(along < 0.0)
}

/// Parts of a body by words of names, as far as they tell limbs apart.
const PARTS: [&[&str]; 6] = [
    &["fore", "front", "arm", "forearm", "hand", "wing", "elbow", "wrist"],
    &["hind", "back", "rear", "leg", "foot", "thigh", "knee", "ankle", "toe", "shin", "upleg"],
    &["head", "face", "skull"],
    &["neck"],
    &["tail"],
    &["body", "torso", "trunk", "spine", "chest", "abdomen", "pelvis"],
];
/// Sides by words: what is near is taken for left, as for one that walks to the left.
const SIDES: [&[&str]; 2] = [&["left", "l", "near"], &["right", "r", "far"]];

/// The words of a name: split where letters end, and before capitals.
fn words(name: &str) -> Vec<String> {
    let mut out = vec![String::new()];
    let mut before = ' ';
    for c in name.chars() {
        if !c.is_alphabetic() || (c.is_uppercase() && before.is_lowercase()) {
            out.push(String::new());
        }
        if let Some(word) = out.last_mut().filter(|_| c.is_alphabetic()) {
            word.extend(c.to_lowercase());
        }
        before = c;
    }
    out.retain(|w| !w.is_empty());
    out
}

/// Which of `kinds` the words speak of most; the first of equals.
fn spoken(words: &[String], kinds: &[&[&str]]) -> Option<usize> {
    let count = |kind: &&[&str]| words.iter().filter(|w| kind.contains(&w.as_str())).count();
    let counts: Vec<usize> = kinds.iter().map(count).collect();
    let most = counts.iter().copied().max().filter(|m| *m > 0)?;
    counts.iter().position(|c| *c == most)
}

/// What a name is worth against geometry, whose costs are of 0 to about 5: the same name decides, parts nearly do.
const SAME_NAME: f64 = -20.0;
const SAME_PART: f64 = -6.0;
const OTHER_PART: f64 = 6.0;
const SIDE: f64 = 1.0;
/// What names do not speak for is paired where it lies no farther apart than this: a third of the figure at either end.
const ALIKE: f64 = 1.5;
/// Limbs or sources that are paired: no animal has more, and the search takes their cube.
const MOST_LIMBS: usize = 500;
/// Chains of joints shorter than this share of the figure's extent are no limbs; a hand is a tenth of it.
const TWIG: f64 = 0.12;

/// A map that pairs limbs with strokes, or with chains of joints.
///
/// # Errors
/// Limbs that are none, or nothing that a limb could follow.
pub fn propose_map(motion: &Motion, limbs: &[RestLimb]) -> Result<LimbMap> {
    motion.checked(1)?;
    check_limbs(limbs)?;
    let sources = possible_sources(motion);
    if let Some(value) = [limbs.len(), sources.len()].into_iter().max().filter(|n| *n > MOST_LIMBS) {
        let (what, remedy) = ("the number of limbs to pair".into(), "give a map of limbs to tracks".into());
        return Err(Error::Limit { what, value: value as u64, max: MOST_LIMBS as u64, remedy });
    }
    let poses: Vec<Vec<DVec2>> = sources.iter().map(|s| Ok(mean_pose(&line(motion, "", s)?))).collect::<Result<_>>()?;
    let own: Vec<Vec<DVec2>> = limbs.iter().map(|l| l.points.iter().map(|p| p.as_dvec2()).collect()).collect();
    let names: Vec<Vec<String>> = sources.iter().map(|s| s.tracks.iter().flat_map(|t| words(t)).collect()).collect();
    let name_cost = |limb: &RestLimb, source: usize| {
        let (ours, theirs) = (words(&limb.name), &names[source]);
        let letters = |words: &[String]| words.concat();
        if sources[source].tracks.len() == 1 && letters(&ours) == letters(theirs) && !ours.is_empty() {
            return SAME_NAME;
        }
        let part = match (spoken(&ours, &PARTS), spoken(theirs, &PARTS)) {
            (Some(a), Some(b)) => {
                if a == b {
                    SAME_PART
                } else {
                    OTHER_PART
                }
            }
            _ => 0.0,
        };
        let side = match (spoken(&ours, &SIDES), spoken(theirs, &SIDES)) {
            (Some(a), Some(b)) => {
                if a == b {
                    -SIDE
                } else {
                    SIDE
                }
            }
            _ => 0.0,
        };
        part + side
    };
    let ours = unit_square(&own);
    let best = [false, true].map(|mirror| {
        let turned: Vec<Vec<DVec2>> =
            poses.iter().map(|p| p.iter().map(|q| if mirror { DVec2::new(-q.x, q.y) } else { *q }).collect()).collect();
        let theirs = unit_square(&turned);
        let cost = |l: usize, s: usize| {
            let ends = |at: &[DVec2], to: &dyn Fn(DVec2) -> DVec2| (to(at[0]), to(at[at.len() - 1]));
            let ((root, tip), (from, to)) = (ends(&own[l], &ours), ends(&turned[s], &theirs));
            let way = (tip - root).normalize_or_zero().dot((to - from).normalize_or_zero());
            let like = 0.5 * tip.distance_squared(to) + 0.5 * root.distance_squared(from) + 0.5 * (1.0 - way);
            name_cost(&limbs[l], s) + like
        };
        let costs: Vec<Vec<f64>> = (0..limbs.len()).map(|l| (0..sources.len()).map(|s| cost(l, s)).collect()).collect();
        let pairs: Vec<(usize, usize)> =
            paired(&costs, sources.len()).into_iter().filter(|&(l, s)| costs[l][s] < ALIKE).collect();
        (pairs.iter().map(|&(l, s)| costs[l][s]).sum::<f64>(), pairs)
    });
    let [straight, mirrored] = best;
    let pairs = if mirrored.0 < straight.0 - 1e-9 { mirrored.1 } else { straight.1 };
    if pairs.is_empty() {
        let tracks = listed(motion.tracks.iter().map(|t| t.name.as_str()));
        let problem = format!("follow nothing of the motion, whose tracks are {tracks}");
        return Err(Error::invalid("limbs of the creature", problem, "give a map of limbs to tracks"));
    }
    Ok(LimbMap { limbs: pairs.into_iter().map(|(l, s)| (limbs[l].name.clone(), sources[s].clone())).collect() })
}

/// Places in a square from -1 to 1 around all.
fn unit_square(lines: &[Vec<DVec2>]) -> impl Fn(DVec2) -> DVec2 + use<> {
    let all = || lines.iter().flatten().copied();
    let (low, high) = (all().fold(DVec2::MAX, DVec2::min), all().fold(DVec2::MIN, DVec2::max));
    let half = ((high - low) / 2.0).max(DVec2::splat(0.1 * (high - low).max_element().max(1e-9)));
    move |p| (p - (low + high) / 2.0) / half
}

/// The strokes of a motion; without any, the chains of its joints between roots, branches and ends.
fn possible_sources(motion: &Motion) -> Vec<LimbSource> {
    let strokes = motion.tracks.iter().filter(|t| t.kind == TrackKind::Stroke && t.frames[0].points.len() > 1);
    let strokes: Vec<LimbSource> =
        strokes.map(|t| LimbSource { tracks: vec![t.name.clone()], ..LimbSource::default() }).collect();
    if !strokes.is_empty() {
        return strokes;
    }
    let find = |name: &str| motion.tracks.iter().position(|t| t.name == name);
    let bones: Vec<[usize; 2]> = motion.bones.iter().filter_map(|(a, b)| Some([find(a)?, find(b)?])).collect();
    let at: Vec<DVec2> = motion.tracks.iter().map(|t| mean_pose(&places(t))[0]).collect();
    let mut near = vec![Vec::new(); at.len()];
    for &[a, b] in &bones {
        near[a].push(b);
        near[b].push(a);
    }
    // Fingers and toes are no limbs.
    if at.len() <= MOST_PLACES {
        prune(&at, &mut near, TWIG * motion.extent());
    }
    let above = |joint: usize| bones.iter().find(|b| b[1] == joint).map(|b| b[0]);
    let below = |joint: usize| near[joint].iter().copied().filter(|n| above(*n) == Some(joint)).collect::<Vec<_>>();
    let mut out = Vec::new();
    for joint in 0..at.len() {
        let children = below(joint);
        if above(joint).is_some() && children.len() < 2 {
            continue;
        }
        for child in children {
            let mut chain = vec![joint, child];
            while let [next] = below(chain[chain.len() - 1])[..] {
                if chain.contains(&next) {
                    break;
                }
                chain.push(next);
            }
            // A limb begins at its own first joint, not in the middle of the body.
            let own = if chain.len() > 3 { &chain[1..] } else { &chain[..] };
            out.push(LimbSource {
                tracks: own.iter().map(|j| motion.tracks[*j].name.clone()).collect(),
                ..LimbSource::default()
            });
        }
    }
    out
}
