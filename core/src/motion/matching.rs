//! Which joint of a skeleton follows which place of a motion.
//!
//! A map says it, or names do: letter for letter, or else by their letters and digits alone, and what hangs on what bears a
//! name. Where neither leads to one bone
//! that moves, the two figures are laid over each other, each stretched to a unit square: both are taken apart into a
//! spine, the longest way between places where the figure branches, and the limbs that hang on it; limbs are paired so
//! that tips, roots and directions lie close, and joints are placed along what they are paired with by length. A figure
//! without branches follows, or is followed by, the longest way through the other.
//!
//! Known limits: a figure that faces left is laid over one that faces right as it stands, tail on head; single points
//! without bones match by name only.

use std::collections::BTreeMap;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::beside_named::completed;
use super::retarget::{Chain, RestSkeleton, RetargetMap, SourcePlace};
use super::{Motion, TrackKind};
use crate::error::{Error, Result};

/// What a map was made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MadeFrom {
    /// The map that was given, and names.
    Map,
    /// Names, and what lies beside joints that bear one.
    Names,
    /// The likeness of the two figures.
    Likeness,
}

const FORMAT: &str = "marey-map";

#[derive(Serialize, Deserialize)]
struct MapFile {
    #[serde(default)]
    format: Option<String>,
    #[serde(default)]
    version: Option<u32>,
    #[serde(default)]
    joints: BTreeMap<String, SourcePlace>,
    #[serde(default)]
    chains: Vec<Chain>,
}

impl RetargetMap {
    /// Reads the text of a map.json: `{"format": "marey-map", "version": 1, "joints": {"knee": {"track": "hind_leg",
    /// "along": 0.5}}, "chains": [{"track": "tail", "joints": ["rump", "tip"], "reversed": false}]}`. Format and version
    /// may be left out.
    ///
    /// # Errors
    /// What is not readable as one.
    pub fn from_json(text: &str) -> Result<Self> {
        let bad = |problem: String| Error::invalid("map", problem, "expected a marey-map file");
        let file: MapFile = serde_json::from_str(text).map_err(|e| bad(format!("is not readable: {e}")))?;
        if file.format.is_some_and(|f| f != FORMAT) || file.version.is_some_and(|v| v != 1) {
            return Err(bad(format!("is not in the format {FORMAT}, version 1")));
        }
        if file.joints.is_empty() && file.chains.is_empty() {
            return Err(bad("names no joints and no chains".into()));
        }
        Ok(Self { joints: file.joints, chains: file.chains })
    }

    /// The text of a map.json.
    pub fn to_json(&self) -> String {
        let file = MapFile {
            format: Some(FORMAT.into()),
            version: Some(1),
            joints: self.joints.clone(),
            chains: self.chains.clone(),
        };
        serde_json::to_string(&file).unwrap_or_default()
    }
}

/// A map that names every joint that follows something: `given` completed, or one that is found where it is `None`.
///
/// # Errors
/// A reference frame beyond the end; a map that names what is not there; nothing that matches, with the names on both sides.
pub fn complete(
    motion: &Motion,
    skeleton: RestSkeleton<'_>,
    given: Option<&RetargetMap>,
    reference: usize,
) -> Result<(RetargetMap, MadeFrom)> {
    motion.validate()?;
    if reference >= motion.frames {
        let problem = format!("is {reference} and the motion has {} frames", motion.frames);
        return Err(Error::invalid("reference frame", problem, "choose a frame of the motion"));
    }
    let moves = |places: &[Option<SourcePlace>]| {
        skeleton.bones.iter().any(|&[a, b]| places[a].is_some() && places[b].is_some())
    };
    let made = |places: Vec<Option<SourcePlace>>, from| {
        let places = match from {
            MadeFrom::Names => completed(motion, &skeleton, places, reference),
            _ => places,
        };
        let named = places.into_iter().zip(skeleton.joints).filter_map(|(p, j)| Some((j.0.clone(), p?)));
        Ok((RetargetMap { joints: named.collect(), chains: Vec::new() }, from))
    };
    if let Some(given) = given {
        let places = given.places(motion, &skeleton)?;
        return if moves(&places) { made(places, MadeFrom::Map) } else { Err(unlike(motion, &skeleton)) };
    }
    let exact = RetargetMap::default().places(motion, &skeleton)?;
    if moves(&exact) {
        return made(exact, MadeFrom::Names);
    }
    let loose = skeleton.joints.iter().map(|j| {
        let same = |t: &&super::Track| t.kind != TrackKind::Stroke && letters(&t.name) == letters(&j.0);
        motion.tracks.iter().find(same).map(|t| SourcePlace::of(&t.name))
    });
    let loose: Vec<Option<SourcePlace>> = loose.collect();
    if moves(&loose) {
        return made(loose, MadeFrom::Names);
    }
    let places = by_likeness(motion, &skeleton, reference);
    if moves(&places) { made(places, MadeFrom::Likeness) } else { Err(unlike(motion, &skeleton)) }
}

fn letters(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// That nothing follows, with both sides' names and how a map is written.
pub(super) fn unlike(motion: &Motion, skeleton: &RestSkeleton<'_>) -> Error {
    let joints = listed(skeleton.joints.iter().map(|j| j.0.as_str()));
    let tracks = listed(motion.tracks.iter().map(|t| t.name.as_str()));
    let problem =
        format!("has no bone whose both ends follow the motion: its joints are {joints}, the tracks {tracks}");
    let (joint, track) = (skeleton.joints.first().map_or("", |j| &j.0), motion.tracks.first().map_or("", |t| &t.name));
    let remedy = format!(r#"give a map: {{"joints": {{"{joint}": {{"track": "{track}", "along": 0.0}}, ...}}}}"#);
    Error::invalid("skeleton", problem, remedy)
}

/// The first few names.
pub(crate) fn listed<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 5;
    let more = names.len().saturating_sub(SHOWN);
    let mut shown: Vec<String> = names.take(SHOWN).map(|n| format!("`{n}`")).collect();
    if more > 0 {
        shown.push(format!("{more} more"));
    }
    if shown.is_empty() { "none".into() } else { shown.join(", ") }
}

/// Figures of more joints are matched by name only; the search takes their square.
pub(super) const MOST_PLACES: usize = 2000;
/// What is shorter than this share of the longest way through a figure is no limb. A hand is a twentieth of it.
const TWIG: f64 = 0.12;

/// A spine, and limbs from the spine outward, as indices of places.
struct Figure {
    spine: Vec<usize>,
    limbs: Vec<Vec<usize>>,
}

/// A way through a source: places in pixels of the reference frame, and what they are of.
struct Way {
    at: Vec<DVec2>,
    source: Source,
}

enum Source {
    /// A limb's stroke, and whether it runs from its end.
    Stroke(String, bool),
    /// Joints' tracks.
    Joints(Vec<String>),
}

impl Way {
    fn place(&self, share: f64) -> SourcePlace {
        match &self.source {
            Source::Stroke(track, turned) => {
                let along = if *turned { 1.0 - share } else { share };
                SourcePlace { along: along as f32, ..SourcePlace::of(track) }
            }
            Source::Joints(tracks) => {
                let shares = shares(&self.at);
                let next = shares.partition_point(|s| *s < share - 1e-6).min(tracks.len() - 1);
                if (shares[next] - share).abs() <= 1e-6 || next == 0 {
                    return SourcePlace::of(&tracks[next]);
                }
                let (from, to) = (shares[next - 1], shares[next]);
                let along = ((share - from) / (to - from)) as f32;
                SourcePlace { track: tracks[next - 1].clone(), along, toward: Some(tracks[next].clone()) }
            }
        }
    }

    fn ends(&self) -> (DVec2, DVec2) {
        (self.at[0], self.at[self.at.len() - 1])
    }
}

/// How far along each place of a line is, in 0..=1.
fn shares(at: &[DVec2]) -> Vec<f64> {
    let mut passed = vec![0.0];
    at.windows(2).for_each(|p| passed.push(passed[passed.len() - 1] + p[0].distance(p[1])));
    let whole = passed[passed.len() - 1];
    passed.iter().map(|p| if whole > 0.0 { p / whole } else { 0.0 }).collect()
}

/// The longest way from `from`, not by way of `before`, to a place that `ends` it, with its length.
fn longest(
    at: &[DVec2],
    near: &[Vec<usize>],
    from: usize,
    before: Option<usize>,
    ends: &dyn Fn(usize) -> bool,
) -> (f64, Vec<usize>) {
    let mut came = vec![usize::MAX; at.len()];
    let (mut best, mut waiting) = ((0.0, from), vec![(0.0, from, before)]);
    while let Some((length, last, before)) = waiting.pop() {
        if length > best.0 && ends(last) {
            best = (length, last);
        }
        for &n in near[last].iter().filter(|n| Some(**n) != before) {
            came[n] = last;
            waiting.push((length + at[last].distance(at[n]), n, Some(last)));
        }
    }
    let mut way = vec![best.1];
    while way[way.len() - 1] != from {
        way.push(came[way[way.len() - 1]]);
    }
    way.reverse();
    (best.0, way)
}

/// The longest way through a tree between places that end it: from any to the farthest, and on to the one farthest from that.
fn across(at: &[DVec2], near: &[Vec<usize>], from: usize, ends: &dyn Fn(usize) -> bool) -> (f64, Vec<usize>) {
    let far = longest(at, near, from, None, ends).1;
    longest(at, near, far[far.len() - 1], None, ends)
}

/// Takes off what is shorter than `least` between its end and where it branches off, the shortest first: fingers and the
/// ends of bones are no limbs.
pub(super) fn prune(at: &[DVec2], near: &mut [Vec<usize>], least: f64) {
    loop {
        let twig = |leaf: usize| {
            let (mut way, mut length) = (vec![leaf], 0.0);
            let mut next = near[leaf].first().copied();
            while let Some(n) = next {
                let last = way[way.len() - 1];
                length += at[last].distance(at[n]);
                way.push(n);
                next = if near[n].len() == 2 { near[n].iter().copied().find(|m| *m != last) } else { None };
            }
            (near[way[way.len() - 1]].len() > 2 && length < least).then_some((length, way))
        };
        let leaves = (0..at.len()).filter(|&n| near[n].len() == 1);
        let Some((_, way)) = leaves.filter_map(twig).min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        for pair in way.windows(2) {
            near[pair[0]].clear();
            near[pair[1]].retain(|n| *n != pair[0]);
        }
    }
}

/// Takes a forest apart. Of its trees the one with the longest way counts; bones that close a circle do not.
fn take_apart(at: &[DVec2], bones: &[[usize; 2]]) -> Option<Figure> {
    if at.len() > MOST_PLACES {
        return None;
    }
    let mut near = vec![Vec::new(); at.len()];
    let mut tree: Vec<usize> = (0..at.len()).collect();
    for &[a, b] in bones {
        let (from, to) = (tree[a], tree[b]);
        if from != to {
            tree.iter_mut().filter(|t| **t == to).for_each(|t| *t = from);
            near[a].push(b);
            near[b].push(a);
        }
    }
    let roots = (0..at.len()).filter(|&n| tree[n] == n && !near[n].is_empty());
    let across_all = |n| across(at, &near, n, &|_| true);
    let (length, whole) = roots.map(across_all).max_by(|a, b| a.0.total_cmp(&b.0))?;
    prune(at, &mut near, TWIG * length);
    let branches = |n: usize| near[n].len() > 2;
    let Some(first) = (0..at.len()).find(|&n| tree[n] == tree[whole[0]] && branches(n)) else {
        return Some(Figure { spine: whole, limbs: Vec::new() });
    };
    let (_, spine) = across(at, &near, first, &branches);
    let mut limbs = Vec::new();
    for &root in &spine {
        for &n in near[root].iter().filter(|n| !spine.contains(n)) {
            let mut limb = vec![root];
            limb.extend(longest(at, &near, n, Some(root), &|_| true).1);
            limbs.push(limb);
        }
    }
    Some(Figure { spine, limbs })
}

/// A source's spine and limbs.
fn ways(motion: &Motion, reference: usize) -> Option<(Way, Vec<Way>)> {
    let places = |t: &super::Track| -> Vec<DVec2> { t.frames[reference].points.iter().map(|p| p.as_dvec2()).collect() };
    let strokes: Vec<&super::Track> = motion.tracks.iter().filter(|t| t.kind == TrackKind::Stroke).collect();
    if strokes.is_empty() {
        let joints: Vec<&super::Track> = motion.tracks.iter().collect();
        let at: Vec<DVec2> = joints.iter().map(|t| places(t)[0]).collect();
        let find = |name: &str| joints.iter().position(|t| t.name == name);
        let bones: Vec<[usize; 2]> = motion.bones.iter().filter_map(|(a, b)| Some([find(a)?, find(b)?])).collect();
        let figure = take_apart(&at, &bones)?;
        let way = |nodes: &Vec<usize>| Way {
            at: nodes.iter().map(|&n| at[n]).collect(),
            source: Source::Joints(nodes.iter().map(|&n| joints[n].name.clone()).collect()),
        };
        return Some((way(&figure.spine), figure.limbs.iter().map(way).collect()));
    }
    let length = |t: &super::Track| places(t).windows(2).map(|p| p[0].distance(p[1])).sum::<f64>();
    let parent = |t: &super::Track| motion.bones.iter().find(|b| b.1 == t.name).map(|b| b.0.as_str());
    let carries = |t: &super::Track| motion.bones.iter().any(|b| b.0 == t.name);
    let roots = strokes.iter().filter(|t| parent(t).is_none() && (carries(t) || motion.bones.is_empty()));
    let spine = roots.max_by(|a, b| length(a).total_cmp(&length(b))).or(strokes.first())?;
    let way = |t: &super::Track, turned: bool| {
        let mut at = places(t);
        if turned {
            at.reverse();
        }
        Way { at, source: Source::Stroke(t.name.clone(), turned) }
    };
    let limbs = strokes.iter().filter(|t| t.name != spine.name).map(|t| {
        // A limb begins at the end that lies nearer to what it hangs on.
        let on = parent(t).and_then(|p| motion.track(p)).unwrap_or(spine);
        let own = places(t);
        let gap = |p: DVec2| places(on).iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
        way(t, gap(own[own.len() - 1]) < gap(own[0]))
    });
    Some((way(spine, false), limbs.collect()))
}

/// A figure's places in a square from -1 to 1.
fn frame(at: impl Iterator<Item = DVec2> + Clone) -> impl Fn(DVec2) -> DVec2 {
    let low = at.clone().fold(DVec2::MAX, DVec2::min);
    let high = at.fold(DVec2::MIN, DVec2::max);
    let half = ((high - low) / 2.0).max(DVec2::splat(0.1 * (high - low).max_element().max(1e-9)));
    move |p| (p - (low + high) / 2.0) / half
}

fn by_likeness(motion: &Motion, skeleton: &RestSkeleton<'_>, reference: usize) -> Vec<Option<SourcePlace>> {
    let mut found = vec![None; skeleton.joints.len()];
    let at: Vec<DVec2> = skeleton.joints.iter().map(|j| j.1.as_dvec2()).collect();
    let (Some(mut own), Some((spine, limbs))) = (take_apart(&at, skeleton.bones), ways(motion, reference)) else {
        return found;
    };
    if limbs.is_empty() && !own.limbs.is_empty() {
        // The longest way through the skeleton: its spine with the longest limb at either end.
        let length = |limb: &Vec<usize>| limb.windows(2).map(|p| at[p[0]].distance(at[p[1]])).sum::<f64>();
        let end = |own: &mut Figure| {
            let tip = own.spine[own.spine.len() - 1];
            let hanging = (0..own.limbs.len()).filter(|&l| own.limbs[l][0] == tip);
            if let Some(l) = hanging.max_by(|&a, &b| length(&own.limbs[a]).total_cmp(&length(&own.limbs[b]))) {
                let limb = own.limbs.remove(l);
                own.spine.extend(&limb[1..]);
            }
            own.spine.reverse();
        };
        end(&mut own);
        end(&mut own);
    }
    let ours = frame(at.iter().copied());
    let all: Vec<DVec2> = std::iter::once(&spine).chain(&limbs).flat_map(|w| w.at.iter().copied()).collect();
    let theirs = frame(all.iter().copied());
    let ends = |line: &[usize]| (ours(at[line[0]]), ours(at[line[line.len() - 1]]));
    let apart = |(a, b): (DVec2, DVec2), (c, d): (DVec2, DVec2)| a.distance(c) + b.distance(d);

    let ((a, b), (c, d)) = (ends(&own.spine), spine.ends());
    let (c, d) = (theirs(c), theirs(d));
    let turned = apart((a, b), (d, c)) < apart((a, b), (c, d));
    let along: Vec<DVec2> = own.spine.iter().map(|&n| at[n]).collect();
    match own.spine[..] {
        // Limbs that hang on one joint hang on the middle of a spine.
        [only] => found[only] = Some(spine.place(0.5)),
        _ if spine.at.len() == 1 => {
            let nearer = if apart((a, a), (c, c)) <= apart((b, b), (c, c)) { 0 } else { own.spine.len() - 1 };
            found[own.spine[nearer]] = Some(spine.place(0.0));
        }
        _ => {
            for (&n, share) in own.spine.iter().zip(shares(&along)) {
                found[n] = Some(spine.place(if turned { 1.0 - share } else { share }));
            }
        }
    }
    let cost = |limb: &[usize], way: &Way| {
        let ((root, tip), (from, to)) = (ends(limb), way.ends());
        let (from, to) = (theirs(from), theirs(to));
        let way = (tip - root).normalize_or_zero().dot((to - from).normalize_or_zero());
        // Squares keep legs in their order where all of one figure stand to one side of the other's.
        tip.distance_squared(to) + 0.5 * root.distance_squared(from) + 0.5 * (1.0 - way)
    };
    let costs: Vec<Vec<f64>> = own.limbs.iter().map(|l| limbs.iter().map(|w| cost(l, w)).collect()).collect();
    for (limb, way) in paired(&costs, limbs.len()) {
        let nodes = &own.limbs[limb];
        let line: Vec<DVec2> = nodes.iter().map(|&n| at[n]).collect();
        for (&n, share) in nodes.iter().zip(shares(&line)) {
            found[n].get_or_insert_with(|| limbs[way].place(share));
        }
    }
    found
}

/// Pairs of rows and columns of least total cost: the nearest first, then exchanges while they help.
pub(super) fn paired(costs: &[Vec<f64>], columns: usize) -> Vec<(usize, usize)> {
    // Rows and columns without a partner are paired with others that cost nothing.
    let count = costs.len().max(columns);
    let cost = |row: usize, column: usize| costs.get(row).and_then(|r| r.get(column)).copied().unwrap_or(0.0);
    let mut order: Vec<(usize, usize)> = (0..costs.len()).flat_map(|r| (0..columns).map(move |c| (r, c))).collect();
    order.sort_by(|a, b| cost(a.0, a.1).total_cmp(&cost(b.0, b.1)));
    let mut of = vec![usize::MAX; count];
    let mut taken = vec![false; count];
    for (r, c) in order {
        if of[r] == usize::MAX && !taken[c] {
            (of[r], taken[c]) = (c, true);
        }
    }
    for row in 0..count {
        if of[row] == usize::MAX
            && let Some(free) = taken.iter().position(|t| !t)
        {
            (of[row], taken[free]) = (free, true);
        }
    }
    // Each exchange lowers the total by more than rounding, so they end; the bound is for what no one has seen.
    for _ in 0..count * count {
        let better = (0..count)
            .flat_map(|a| (0..a).map(move |b| (a, b)))
            .find(|&(a, b)| cost(a, of[b]) + cost(b, of[a]) + 1e-9 < cost(a, of[a]) + cost(b, of[b]));
        let Some((a, b)) = better else { break };
        of.swap(a, b);
    }
    (0..costs.len()).map(|r| (r, of[r])).filter(|p| p.1 < columns).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Track, TrackFrame};
    use glam::{Vec2, vec2};

    fn track(name: &str, kind: TrackKind, points: &[(f32, f32)]) -> Track {
        let points: Vec<Vec2> = points.iter().map(|&(x, y)| vec2(x, y)).collect();
        Track { name: name.into(), kind, frames: vec![TrackFrame::certain(points)] }
    }

    fn motion(tracks: Vec<Track>, bones: &[(&str, &str)]) -> Motion {
        let bones = bones.iter().map(|&(a, b)| (a.to_string(), b.to_string())).collect();
        Motion { size: (100, 100), fps: 24.0, frames: 1, tracks, bones }
    }

    /// A standing figure: legs to the left and right below, arms beside, a head above.
    fn biped() -> (Vec<(String, Vec2)>, Vec<[usize; 2]>) {
        let joints = [
            ("hip", 50.0, 60.0),
            ("chest", 50.0, 30.0),
            ("head", 50.0, 5.0),
            ("hand_l", 20.0, 45.0),
            ("hand_r", 80.0, 45.0),
            ("knee_l", 40.0, 80.0),
            ("foot_l", 38.0, 99.0),
            ("knee_r", 60.0, 80.0),
            ("foot_r", 62.0, 99.0),
        ];
        let joints = joints.iter().map(|&(n, x, y)| (n.to_string(), vec2(x, y))).collect();
        (joints, vec![[0, 1], [1, 2], [1, 3], [1, 4], [0, 5], [5, 6], [0, 7], [7, 8]])
    }

    fn matched(motion: &Motion) -> BTreeMap<String, SourcePlace> {
        let (joints, bones) = biped();
        let skeleton = RestSkeleton { joints: &joints, bones: &bones, size: (100, 100) };
        let (map, from) = complete(motion, skeleton, None, 0).expect("alike");
        assert_eq!(from, MadeFrom::Likeness);
        map.joints
    }

    #[test]
    fn the_strokes_of_an_animal_move_the_limbs_that_lie_where_they_do() {
        use TrackKind::Stroke;
        let horse = motion(
            vec![
                track("body", Stroke, &[(20.0, 40.0), (80.0, 40.0)]),
                track("fore", Stroke, &[(78.0, 90.0), (78.0, 65.0), (78.0, 42.0)]),
                track("hind", Stroke, &[(22.0, 41.0), (22.0, 65.0), (22.0, 90.0)]),
                track("neck", Stroke, &[(80.0, 39.0), (95.0, 10.0)]),
            ],
            &[("body", "fore"), ("body", "hind"), ("body", "neck")],
        );
        let map = matched(&horse);
        assert_eq!((map["foot_l"].track.as_str(), map["foot_l"].along), ("hind", 1.0));
        // It is drawn from the hoof up.
        assert_eq!((map["foot_r"].track.as_str(), map["foot_r"].along), ("fore", 0.0));
        assert!((map["knee_r"].along - 0.5).abs() < 0.1, "{:?}", map["knee_r"]);
        assert!(map["hip"].track == "body" && map["chest"].track == "body" && map["hip"].along != map["chest"].along);
        assert!(["head", "hand_r"].iter().any(|j| map.get(*j).is_some_and(|p| p.track == "neck")), "{map:?}");
    }

    #[test]
    fn a_skeleton_with_other_names_and_other_joints_is_laid_over() {
        use TrackKind::Joint;
        let joint = |n: &str, x, y| track(n, Joint, &[(x, y)]);
        let bvh = motion(
            vec![
                joint("Root", 10.0, 50.0),
                joint("Spine", 10.0, 40.0),
                joint("Neck", 10.0, 30.0),
                joint("Skull", 10.0, 20.0),
                joint("ArmL", 5.0, 35.0),
                joint("ArmR", 15.0, 35.0),
                joint("Thumb", 16.0, 34.0),
                joint("Finger", 16.5, 35.0),
                joint("LegL", 8.0, 70.0),
                joint("LegR", 12.0, 70.0),
            ],
            &[
                ("Root", "Spine"),
                ("Spine", "Neck"),
                ("Neck", "Skull"),
                ("Neck", "ArmL"),
                ("Neck", "ArmR"),
                ("ArmR", "Thumb"),
                ("ArmR", "Finger"),
                ("Root", "LegL"),
                ("Root", "LegR"),
            ],
        );
        let map = matched(&bvh);
        for (joint, track) in
            [("hip", "Root"), ("chest", "Neck"), ("head", "Skull"), ("hand_l", "ArmL"), ("foot_r", "LegR")]
        {
            assert_eq!(map[joint], SourcePlace::of(track), "{joint}");
        }
        // A knee lies between two joints where the source has none.
        let knee = &map["knee_l"];
        assert_eq!((knee.track.as_str(), knee.toward.as_deref()), ("Root", Some("LegL")));
        assert!(knee.along > 0.3 && knee.along < 0.7);
    }

    #[test]
    fn names_that_differ_by_case_only_and_figures_without_branches() {
        use TrackKind::Joint;
        let (joints, bones) = biped();
        let skeleton = RestSkeleton { joints: &joints, bones: &bones, size: (100, 100) };
        let named = motion(vec![track("Hip", Joint, &[(1.0, 2.0)]), track("CHEST", Joint, &[(1.0, 1.0)])], &[]);
        let (map, from) = complete(&named, skeleton, None, 0).expect("alike");
        assert_eq!((map.joints.len(), from), (2, MadeFrom::Names));

        let snake = motion(vec![track("snake", TrackKind::Stroke, &[(0.0, 0.0), (0.0, 50.0)])], &[]);
        let (map, _) = complete(&snake, skeleton, None, 0).expect("alike");
        let leg = ["foot_l", "foot_r"].iter().filter(|f| map.joints.contains_key(**f)).count();
        assert!(leg == 1 && map.joints["chest"].along < map.joints["hip"].along, "{map:?}");

        // Bones that close a circle lead to no endless search.
        let all: Vec<(String, String)> =
            (0..40).flat_map(|a| (0..40).map(move |b| (format!("j{a}"), format!("j{b}")))).collect();
        let tracks = (0..40).map(|i| track(&format!("j{i}"), Joint, &[(i as f32, (i * i % 7) as f32)])).collect();
        let dense = Motion { bones: all, ..motion(tracks, &[]) };
        assert!(complete(&dense, skeleton, None, 0).is_ok());
        assert!(complete(&dense, skeleton, None, 1).expect_err("one frame").to_string().contains("1 frames"));

        let points = motion(vec![track("nose", TrackKind::Point, &[(1.0, 2.0)])], &[]);
        let said = complete(&points, skeleton, None, 0).expect_err("nothing to follow").to_string();
        assert!(said.contains("`nose`") && said.contains("`hand_r`") && said.contains("4 more"), "{said}");
    }

    #[test]
    fn exchanges_find_the_pairs_that_the_nearest_first_would_miss() {
        let costs = [vec![1.0, 2.0], vec![1.1, 9.0]];
        assert_eq!(paired(&costs, 2), vec![(0, 1), (1, 0)]);
        assert_eq!(paired(&[vec![3.0, 1.0, 2.0]], 3), vec![(0, 1)]);
        assert_eq!(paired(&[vec![3.0], vec![1.0]], 1), vec![(1, 0)]);
        assert_eq!(paired(&[], 1), vec![]);
    }
}
