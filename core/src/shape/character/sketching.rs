//! A pose from a skeleton drawn anew: strokes matched to bones.
//!
//! Pan and Zhang 2011, section 3: to make a key frame a person only sketches the skeleton. How strokes find their bones is
//! ours. A stroke covers a path of bones, from one joint to another; joints within the path are laid along the stroke by
//! dynamic programming, where bones keep their lengths and the stroke bends. Which strokes take which paths is chosen
//! together by a beam search: no bone twice, joints that several strokes share in one place, as little turned and moved as
//! the drawing allows. So a bone a stroke, a limb a stroke, and one line from hand to hand all work, in any order and
//! direction.
//!
//! What hangs from drawn bones and was not drawn turns with them; all else stays where it was.
//!
//! Known limits: of two limbs that look alike, each goes to the stroke that is nearer to it; strokes retraced over
//! themselves count as one long way.

use glam::{Vec2, vec2};

use super::Skeleton;
use crate::error::{Error, Result};
use crate::geometry::polyline;

/// Places along a stroke that joints may take.
const SAMPLES: usize = 40;
/// Paths that are weighed for a stroke, and choices that are followed at a time.
const PATHS: usize = 64;
const BEAM: usize = 256;
/// Bones and strokes at most: sets of bones are bits of one number, and people draw far fewer.
const MOST: usize = 128;

// Costs, in units of a mean bone's length that nothing was drawn for. Chosen on figures posed at random and drawn in the
// three ways of the tests: 40 poses each come back.
/// Bones without a stroke and strokes without a bone, for each mean bone's length of them.
const UNDRAWN: f32 = 1.0;
const UNUSED: f32 = 2.0;
/// The square of the logarithm of a bone's new length over its old.
const STRETCH: f32 = 1.0;
/// The mean square distance of the stroke from the bone, over the bone's square length.
const BEND: f32 = 20.0;
/// Half a turn.
const TURN: f32 = 0.4;
/// The square of a bone's way from where it was, in mean bone lengths; no more than [`FAR`].
const MOVE: f32 = 0.05;
const FAR: f32 = 0.6;
/// Two strokes that meet, within this share of a bone's length, without a joint there that is on both.
const LOOSE: f32 = 0.3;
const MEET: f32 = 0.15;
/// The square of the gap between two places drawn for one joint, in mean bone lengths.
const APART: f32 = 6.0;

/// A pose that was read from strokes.
#[derive(Clone, Debug, PartialEq)]
pub struct Sketched {
    /// Where each joint is now, in the skeleton's order.
    pub joints: Vec<Vec2>,
    /// The bones that each stroke was taken for, from its start on; none where it fits no bone.
    pub bones: Vec<Vec<u32>>,
}

impl Skeleton {
    /// The pose that `strokes` draw, for a skeleton whose joints were at `from`.
    ///
    /// # Errors
    /// Another number of joints, no strokes, a stroke without length or with a place that is not a number, more than 128
    /// bones or strokes, strokes that fit no bone at all.
    pub fn sketched(&self, from: &[Vec2], strokes: &[Vec<Vec2>]) -> Result<Sketched> {
        self.check(from, strokes)?;
        let drawing = Drawing::new(self, from, strokes);
        let order = drawing.order();
        let paths: Vec<Vec<Path>> = order.iter().map(|&s| drawing.paths(s)).collect();
        let best = drawing.choose(&order, &paths);
        let mut bones = vec![Vec::new(); strokes.len()];
        for (&stroke, (paths, chosen)) in order.iter().zip(paths.iter().zip(&best.chosen)) {
            if let Some(path) = chosen {
                bones[stroke].clone_from(&paths[*path].bones);
            }
        }
        if bones.iter().all(Vec::is_empty) {
            let remedy = "draw lines about as long as the bones";
            return Err(Error::invalid("sketch", "fits no bone of the skeleton", remedy));
        }
        Ok(Sketched { joints: drawing.hung(&best), bones })
    }

    fn check(&self, from: &[Vec2], strokes: &[Vec<Vec2>]) -> Result<()> {
        if from.len() != self.joints.len() || from.iter().any(|p| !p.is_finite()) {
            let problem = "are not as many numbers as the skeleton has joints";
            return Err(Error::invalid("joints before the sketch", problem, "give each joint a finite place"));
        }
        if strokes.is_empty() {
            return Err(Error::invalid("sketch", "has no strokes", "draw at least one bone"));
        }
        for (what, count) in [("strokes", strokes.len()), ("bones", self.bones.len())] {
            if count > MOST {
                let remedy = "draw fewer, or move the joints one by one".into();
                return Err(Error::Limit {
                    what: format!("the sketch's number of {what}"),
                    value: count as u64,
                    max: MOST as u64,
                    remedy,
                });
            }
        }
        for (i, stroke) in strokes.iter().enumerate() {
            if stroke.iter().any(|p| !p.is_finite()) {
                return Err(Error::invalid(format!("stroke {i}"), "has a place that is not a number", "draw it again"));
            }
            let length = polyline::length(stroke);
            if !(length > 0.0 && length.is_finite()) {
                return Err(Error::invalid(format!("stroke {i}"), "has no length", "draw a line along the bone"));
            }
        }
        Ok(())
    }
}

struct Stroke {
    points: Vec<Vec2>,
    length: f32,
    /// Mean square distance of what lies between two samples from the straight way.
    bend: Vec<[f32; SAMPLES]>,
}

/// A stroke along some bones.
struct Path {
    bones: Vec<u32>,
    mask: u128,
    /// The joints on the way and where the stroke puts them.
    places: Vec<(usize, Vec2)>,
    cost: f32,
}

/// How a path comes to a joint, and for every sample what it costs to lie there and the sample of the joint before.
#[derive(Clone, Copy)]
struct Reached {
    from: usize,
    bone: usize,
    costs: [(f32, usize); SAMPLES],
}

#[derive(Clone)]
struct Choice {
    cost: f32,
    taken: u128,
    chosen: Vec<Option<usize>>,
    /// For each joint, the sum of the places drawn for it and their number.
    placed: Vec<(Vec2, u32)>,
}

impl Choice {
    fn at(&self, joint: usize) -> Option<Vec2> {
        let (sum, count) = self.placed[joint];
        (count > 0).then(|| sum / count as f32)
    }
}

struct Drawing<'a> {
    skeleton: &'a Skeleton,
    from: &'a [Vec2],
    strokes: Vec<Stroke>,
    /// The mean length of the bones.
    unit: f32,
    /// What a bone costs that nothing was drawn for: nothing where the drawing is but a part.
    undrawn: f32,
    /// How far the drawing as a whole lies from the skeleton.
    shift: Vec2,
    /// For each joint its bones and what is at their other ends.
    around: Vec<Vec<(usize, usize)>>,
}

impl<'a> Drawing<'a> {
    fn new(skeleton: &'a Skeleton, from: &'a [Vec2], strokes: &[Vec<Vec2>]) -> Self {
        let strokes: Vec<Stroke> = strokes.iter().map(|s| Stroke::new(s)).collect();
        let segments = skeleton.segments(from);
        let whole: f32 = segments.iter().map(|(a, b)| a.distance(*b)).sum();
        let drawn: f32 = strokes.iter().map(|s| s.length).sum();
        let unit = if whole > 0.0 { whole } else { drawn } / skeleton.bones.len() as f32;
        let (mut shift, mut undrawn) = (Vec2::ZERO, 0.0);
        // A whole skeleton may be drawn beside the old one; a part of it is drawn where it belongs.
        if drawn > 0.7 * whole && whole > 0.0 {
            let old: Vec2 = segments.iter().map(|(a, b)| a.midpoint(*b) * a.distance(*b)).sum();
            let new: Vec2 = strokes.iter().map(|s| s.points.iter().sum::<Vec2>() / SAMPLES as f32 * s.length).sum();
            (shift, undrawn) = (new / drawn - old / whole, UNDRAWN);
        }
        let mut around = vec![Vec::new(); from.len()];
        for (b, &[one, other]) in skeleton.bones.iter().enumerate() {
            around[one].push((b, other));
            around[other].push((b, one));
        }
        Self { skeleton, from, strokes, unit: unit.max(1e-3), undrawn, shift, around }
    }

    fn before(&self, bone: usize) -> f32 {
        let [a, b] = self.skeleton.bones[bone];
        self.from[a].distance(self.from[b])
    }

    fn stretch(&self, bone: usize, length: f32) -> f32 {
        let (before, least) = (self.before(bone), 0.01 * self.unit);
        // A bone of no length may get any.
        if before < least { STRETCH } else { STRETCH * (length.max(least) / before).ln().powi(2) }
    }

    /// What it costs that a stroke from sample `i` to `k` is a bone from the joint `one` to the joint `other`.
    fn section(&self, stroke: &Stroke, (i, k): (usize, usize), bone: usize, (one, other): (usize, usize)) -> f32 {
        let arc = stroke.length * (k - i) as f32 / (SAMPLES - 1) as f32;
        let (a, b) = (stroke.points[i], stroke.points[k]);
        let (old_a, old_b) = (self.from[one] + self.shift, self.from[other] + self.shift);
        let turned = match ((b - a).try_normalize(), (old_b - old_a).try_normalize()) {
            (Some(new), Some(old)) => 0.5 * (1.0 - new.dot(old)),
            _ => 0.0,
        };
        let way = a.midpoint(b).distance_squared(old_a.midpoint(old_b)) / (self.unit * self.unit);
        self.stretch(bone, arc) + BEND * stroke.bend[i][k] / (arc * arc) + TURN * turned + (MOVE * way).min(FAR)
    }

    /// How near an end of one stroke comes to the other, in pixels.
    fn apart(&self, a: usize, b: usize) -> f32 {
        let ends = |s: usize| [self.strokes[s].points[0], self.strokes[s].points[SAMPLES - 1]];
        let one = |s: usize, t: usize| {
            ends(s).into_iter().flat_map(move |e| self.strokes[t].points.iter().map(move |p| e.distance(*p)))
        };
        one(a, b).chain(one(b, a)).fold(f32::INFINITY, f32::min)
    }

    /// The strokes, the longest first and then always the one that comes nearest to those before: where strokes meet
    /// decides more than their shapes.
    fn order(&self) -> Vec<usize> {
        let mut open: Vec<(f32, usize)> = (0..self.strokes.len()).map(|s| (-self.strokes[s].length, s)).collect();
        let mut order = Vec::with_capacity(open.len());
        while let Some(next) = (0..open.len()).min_by(|&a, &b| open[a].0.total_cmp(&open[b].0)) {
            let (_, stroke) = open.remove(next);
            if order.is_empty() {
                open.iter_mut().for_each(|o| o.0 = f32::INFINITY);
            }
            open.iter_mut().for_each(|o| o.0 = o.0.min(self.apart(o.1, stroke)));
            order.push(stroke);
        }
        order
    }

    /// The paths of bones that a stroke fits best.
    fn paths(&self, stroke: usize) -> Vec<Path> {
        let stroke = &self.strokes[stroke];
        let mut paths: Vec<Path> = Vec::new();
        for start in 0..self.from.len() {
            let mut reached: Vec<Option<Reached>> = vec![None; self.from.len()];
            let mut first = [(f32::INFINITY, 0); SAMPLES];
            first[0] = (0.0, 0);
            reached[start] = Some(Reached { from: start, bone: usize::MAX, costs: first });
            let mut waiting = vec![start];
            while let Some(one) = waiting.pop() {
                let Some(Reached { costs, .. }) = reached[one] else { continue };
                for &(bone, other) in &self.around[one] {
                    if reached[other].is_some() {
                        continue;
                    }
                    let mut next = [(f32::INFINITY, 0); SAMPLES];
                    for (i, before) in costs.iter().enumerate().filter(|c| c.1.0.is_finite()) {
                        for (k, best) in next.iter_mut().enumerate().skip(i + 1) {
                            let cost = before.0 + self.section(stroke, (i, k), bone, (one, other));
                            if cost < best.0 {
                                *best = (cost, i);
                            }
                        }
                    }
                    reached[other] = Some(Reached { from: one, bone, costs: next });
                    waiting.push(other);
                }
            }
            for end in (0..self.from.len()).filter(|e| *e != start) {
                let Some(Reached { costs, .. }) = &reached[end] else { continue };
                if !costs[SAMPLES - 1].0.is_finite() {
                    continue;
                }
                let mut path = Path { bones: Vec::new(), mask: 0, places: Vec::new(), cost: costs[SAMPLES - 1].0 };
                let (mut joint, mut sample) = (end, SAMPLES - 1);
                while let Some(Reached { from, bone, costs }) = &reached[joint] {
                    path.places.push((joint, stroke.points[sample]));
                    if joint == start {
                        break;
                    }
                    path.bones.push(*bone as u32);
                    path.mask |= 1 << bone;
                    (joint, sample) = (*from, costs[sample].1);
                }
                path.bones.reverse();
                paths.push(path);
            }
        }
        paths.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        paths.truncate(PATHS);
        paths
    }

    /// The best choice of a path for each stroke.
    fn choose(&self, order: &[usize], paths: &[Vec<Path>]) -> Choice {
        let empty = Choice { cost: 0.0, taken: 0, chosen: Vec::new(), placed: vec![(Vec2::ZERO, 0); self.from.len()] };
        let mut beam = vec![empty.clone()];
        for (turn, (&stroke, own)) in order.iter().zip(paths).enumerate() {
            let met: Vec<usize> = (0..turn).filter(|t| self.apart(order[*t], stroke) < MEET * self.unit).collect();
            let unused = UNUSED * self.strokes[stroke].length / self.unit;
            let mut next: Vec<(f32, usize, Option<usize>)> = Vec::new();
            for (c, choice) in beam.iter().enumerate() {
                next.push((choice.cost + unused, c, None));
                for (p, path) in own.iter().enumerate().filter(|(_, p)| p.mask & choice.taken == 0) {
                    let gaps: f32 = path.places.iter().filter_map(|(j, at)| Some(self.gap(choice.at(*j)?, *at))).sum();
                    let others = met.iter().filter_map(|&t| Some(&paths[t][choice.chosen[t]?]));
                    let loose = others.filter(|o| !self.joined(path, o)).count() as f32;
                    next.push((choice.cost + path.cost + gaps + LOOSE * loose, c, Some(p)));
                }
            }
            next.sort_by(|a, b| a.0.total_cmp(&b.0));
            next.truncate(BEAM);
            beam = next
                .into_iter()
                .map(|(cost, before, chosen)| {
                    let mut choice = beam[before].clone();
                    choice.cost = cost;
                    choice.chosen.push(chosen);
                    if let Some(path) = chosen.map(|p| &own[p]) {
                        choice.taken |= path.mask;
                        for &(joint, at) in &path.places {
                            let (sum, count) = &mut choice.placed[joint];
                            (*sum, *count) = (*sum + at, *count + 1);
                        }
                    }
                    choice
                })
                .collect();
        }
        let whole = |choice: &Choice| choice.cost + self.between(choice);
        beam.into_iter().min_by(|a, b| whole(a).total_cmp(&whole(b))).unwrap_or(empty)
    }

    /// Whether two paths have a joint in one place.
    fn joined(&self, a: &Path, b: &Path) -> bool {
        let near = |p: Vec2, q: Vec2| p.distance(q) < 4.0 * MEET * self.unit;
        a.places.iter().any(|(j, p)| b.places.iter().any(|(k, q)| j == k && near(*p, *q)))
    }

    fn gap(&self, a: Vec2, b: Vec2) -> f32 {
        APART * a.distance_squared(b) / (self.unit * self.unit)
    }

    /// What bones cost that were not drawn, more where both their ends were.
    fn between(&self, choice: &Choice) -> f32 {
        let open = self.skeleton.bones.iter().enumerate().filter(|(b, _)| choice.taken & (1 << b) == 0);
        open.map(|(b, &[one, other])| {
            let ends = choice.at(one).zip(choice.at(other));
            self.undrawn * self.before(b) / self.unit + ends.map_or(0.0, |(p, q)| self.stretch(b, p.distance(q)))
        })
        .sum()
    }

    /// All joints: the drawn ones, what hangs from them turned with its bone, and the others where they were.
    fn hung(&self, choice: &Choice) -> Vec<Vec2> {
        let mut at: Vec<Vec2> =
            (0..self.from.len()).map(|j| choice.at(j).unwrap_or(self.from[j] + self.shift)).collect();
        // The turn of the bone that ends at a joint, where that was drawn or hangs from what was.
        let mut turns: Vec<Option<Vec2>> = choice.placed.iter().map(|p| (p.1 > 0).then_some(Vec2::X)).collect();
        for &[one, other] in &self.skeleton.bones {
            let Some(turn) = turns[one] else { continue };
            let old = self.from[other] - self.from[one];
            if choice.placed[other].1 == 0 {
                at[other] = at[one] + turn.rotate(old);
                turns[other] = Some(turn);
            } else if let (Some(old), Some(new)) = (old.try_normalize(), (at[other] - at[one]).try_normalize()) {
                turns[other] = Some(vec2(old.x, -old.y).rotate(new));
            }
        }
        at
    }
}

impl Stroke {
    fn new(points: &[Vec2]) -> Self {
        let length = polyline::length(points);
        let points = polyline::resample(points, SAMPLES);
        let bend = (0..SAMPLES)
            .map(|i| {
                std::array::from_fn(|k| {
                    if k < i + 2 {
                        return 0.0;
                    }
                    let (a, b) = (points[i], points[k]);
                    let off = |p: &Vec2| crate::geometry::polygon::nearest_on_segment(a, b, *p).1.distance_squared(*p);
                    points[i + 1..k].iter().map(off).sum::<f32>() / (k - i - 1) as f32
                })
            })
            .collect();
        Self { points, length, bend }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::character::Joint;

    /// A figure: 0 hip, 1 chest, 2 neck, 3 head, 4..=6 left arm, 7..=9 right arm, 10..=12 left leg, 13..=15 right leg.
    fn figure() -> Skeleton {
        let at = [
            (200., 230.),
            (200., 150.),
            (200., 110.),
            (200., 60.),
            (170., 120.),
            (130., 165.),
            (100., 210.),
            (230., 120.),
            (270., 165.),
            (300., 210.),
            (180., 240.),
            (170., 310.),
            (160., 380.),
            (220., 240.),
            (230., 310.),
            (240., 380.),
        ];
        let bones = [
            [0, 1],
            [1, 2],
            [2, 3],
            [2, 4],
            [4, 5],
            [5, 6],
            [2, 7],
            [7, 8],
            [8, 9],
            [0, 10],
            [10, 11],
            [11, 12],
            [0, 13],
            [13, 14],
            [14, 15],
        ];
        let joints = at.iter().enumerate().map(|(i, p)| Joint { name: i.to_string(), at: vec2(p.0, p.1) }).collect();
        Skeleton { joints, bones: bones.to_vec() }.checked().expect("a skeleton")
    }

    /// Every bone turned against its parent by up to `most`, the whole moved by `way`; the numbers repeat.
    fn posed(skeleton: &Skeleton, seed: u32, most: f32, way: Vec2) -> Vec<Vec2> {
        let mut state = seed.wrapping_mul(2_654_435_761).wrapping_add(12345);
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
        };
        let rest = skeleton.rest();
        let parents = skeleton.parents();
        let mut at = rest.clone();
        let mut turns = vec![0.0; skeleton.bones.len()];
        skeleton.roots().into_iter().for_each(|r| at[r] += way);
        for (b, &[one, other]) in skeleton.bones.iter().enumerate() {
            // Short bones at the trunk hardly turn.
            let most = if rest[one].distance(rest[other]) < 45.0 { 0.3 * most } else { most };
            turns[b] = parents[b].map_or(0.0, |p| turns[p]) + most * random();
            at[other] = at[one] + Vec2::from_angle(turns[b]).rotate(rest[other] - rest[one]);
        }
        at
    }

    /// Strokes along chains of joints, with a hand that shakes by a pixel or two.
    fn drawn(at: &[Vec2], chains: &[&[usize]]) -> Vec<Vec<Vec2>> {
        let shaky = |p: Vec2, i: usize| p + vec2((i as f32 * 1.7).sin(), (i as f32 * 2.3).cos()) * 1.2;
        chains
            .iter()
            .map(|chain| {
                let mut points = Vec::new();
                for w in chain.windows(2) {
                    (0..12).for_each(|i| points.push(shaky(at[w[0]].lerp(at[w[1]], i as f32 / 12.0), points.len())));
                }
                points.push(at[chain[chain.len() - 1]]);
                points
            })
            .collect()
    }

    fn worst(a: &[Vec2], b: &[Vec2]) -> f32 {
        a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
    }

    #[test]
    fn a_bone_a_stroke_a_limb_a_stroke_and_one_line_from_hand_to_hand() {
        let skeleton = figure();
        let each: Vec<Vec<usize>> = skeleton.bones.iter().map(|b| vec![b[1], b[0]]).collect();
        let each: Vec<&[usize]> = each.iter().map(Vec::as_slice).collect();
        let limbs: [&[usize]; 6] =
            [&[0, 1, 2, 3], &[6, 5, 4, 2], &[2, 7, 8, 9], &[0, 10, 11, 12], &[15, 14, 13, 0], &[1, 2]];
        let across: [&[usize]; 3] = [&[9, 8, 7, 2, 4, 5, 6], &[12, 11, 10, 0, 13, 14, 15], &[3, 2, 1, 0]];
        for seed in 0..12 {
            let truth = posed(&skeleton, seed, 0.8, vec2(40.0, -25.0));
            for (way, chains) in [("bones", &each[..]), ("limbs", &limbs[..5]), ("across", &across[..])] {
                let own = skeleton.sketched(&skeleton.rest(), &drawn(&truth, chains)).expect("matched");
                let off = worst(&own.joints, &truth);
                assert!(off < 14.0, "pose {seed} drawn by {way}: {off} px off, {:?}", own.bones);
                assert_eq!(own.bones.iter().map(Vec::len).sum::<usize>(), skeleton.bones.len(), "{way}");
            }
        }
    }

    #[test]
    fn what_is_not_drawn_hangs_as_it_did_and_a_sketch_may_lie_beside() {
        let skeleton = figure();
        let rest = skeleton.rest();
        // One arm only, raised where it is now.
        let mut raised = rest.clone();
        raised[8] = rest[7] + Vec2::from_angle(-0.9).rotate(rest[8] - rest[7]);
        raised[9] = raised[8] + Vec2::from_angle(-1.6).rotate(rest[9] - rest[8]);
        let own = skeleton.sketched(&rest, &drawn(&raised, &[&[7, 8, 9]])).expect("matched");
        assert!(worst(&own.joints, &raised) < 8.0, "{:?}", own.bones);
        assert!((0..7).chain(10..16).all(|j| own.joints[j] == rest[j]));
        // The upper arm alone: the forearm turns with it.
        let own = skeleton.sketched(&rest, &drawn(&raised, &[&[7, 8]])).expect("matched");
        let bend = |at: &[Vec2]| (at[8] - at[7]).angle_to(at[9] - at[8]);
        assert!((bend(&own.joints) - bend(&rest)).abs() < 0.05, "{:?}", own.bones);
        let truth = posed(&skeleton, 3, 0.7, Vec2::ZERO);
        // All of it, on another part of the page.
        let aside: Vec<Vec2> = truth.iter().map(|p| *p + vec2(500.0, 90.0)).collect();
        let chains: [&[usize]; 5] = [&[0, 1, 2, 3], &[2, 4, 5, 6], &[2, 7, 8, 9], &[0, 10, 11, 12], &[0, 13, 14, 15]];
        let own = skeleton.sketched(&rest, &drawn(&aside, &chains)).expect("matched");
        assert!(worst(&own.joints, &aside) < 14.0);
    }

    #[test]
    fn what_is_no_sketch_is_refused_by_name() {
        let skeleton = figure();
        let rest = skeleton.rest();
        let line = vec![vec2(0.0, 0.0), vec2(50.0, 0.0)];
        for (strokes, problem) in [
            (vec![], "no strokes"),
            (vec![line.clone(), vec![vec2(3.0, 3.0)]], "stroke 1: has no length"),
            (vec![vec![]], "stroke 0: has no length"),
            (vec![vec![vec2(f32::NAN, 0.0), vec2(1.0, 1.0)]], "not a number"),
            (vec![vec![vec2(-3e38, 0.0), vec2(3e38, 0.0)]], "no length"),
            (vec![line.clone(); 129], "number of strokes"),
        ] {
            let error = skeleton.sketched(&rest, &strokes).expect_err("refused").to_string();
            assert!(error.contains(problem), "{error}");
        }
        assert!(skeleton.sketched(&rest[..3], std::slice::from_ref(&line)).is_err());
        // A dot of a line beside bones of a hundred pixels is no bone, and says so.
        let error = skeleton.sketched(&rest, &[vec![vec2(0.0, 0.0), vec2(0.4, 0.0)]]).expect_err("refused");
        assert!(error.to_string().contains("fits no bone"), "{error}");
    }

    #[test]
    fn bones_on_one_spot_take_a_sketch() {
        let mut skeleton = figure();
        skeleton.joints.iter_mut().for_each(|j| j.at = vec2(50.0, 50.0));
        let rest = skeleton.rest();
        let own = skeleton.sketched(&rest, &drawn(&figure().rest(), &[&[0, 1, 2, 3]])).expect("matched");
        assert!(own.joints.iter().all(|p| p.is_finite()));
    }
}
