//! Where limbs of a creature lie over each other in a frame, which of two is in front, and what to say of a limb's depth
//! so that it is otherwise.
//!
//! Depths are those of the creature that was made, with what was said since then added; what is said holds on its frame and
//! fades toward the limb's key frames around, as the library has it (`mry_rig_set_depth`).
//!
//! Known limits: one place for each pair, that which is farthest from where limbs hang; limbs that hang from one that was
//! moved are taken to stay until the creature is made again.

use eframe::egui::{Color32, Painter, Pos2, Stroke, Vec2, vec2};
use marey_binding::{Creature, CreatureLimb, Result};

use crate::document::Document;
use crate::theme;
use crate::view::Placement;

/// Lines of bones that come so near without crossing lie over each other, in sums of the limbs' radii.
const BESIDE: f32 = 0.6;
/// The share of a limb over which it swings out to the depth that is said, as the library has it.
const HIP: f32 = 0.3;
/// A limb that is moved near to where it is held is moved farther, but not without an end.
const LEAST_FREE: f32 = 0.2;
/// A mark is clicked so near to its middle, in points of the screen.
pub(crate) const NEAR: f32 = 11.0;
const RADIUS: f32 = 9.0;

/// Two limbs, one before the other; by their numbers in the document.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Overlap {
    pub(crate) front: usize,
    pub(crate) behind: usize,
    /// In clip pixels.
    pub(crate) at: (f32, f32),
    /// Whether a person said something of either on this frame.
    pub(crate) said: bool,
    /// Where the front one and the other go there, as unit vectors.
    ways: [Vec2; 2],
}

/// What is said of all limbs' depth: for each, the frames on which it is drawn or something is said, with what is said.
pub(crate) type Said = Vec<(String, Vec<(u64, Option<f32>)>)>;

/// The bones of a creature, and what was said when it was made.
pub(crate) struct Bones {
    limbs: Vec<CreatureLimb>,
    said: Said,
    height: f32,
    /// Of the frame that was asked for last, in clip pixels and toward the viewer.
    places: Option<(u64, Vec<[f32; 3]>)>,
}

/// A limb's place in an overlap.
#[derive(Clone, Copy)]
struct Place {
    at: Vec2,
    /// 0 where the limb is held, 1 at its free end.
    share: f32,
    way: Vec2,
    z: f32,
}

/// Two limbs of the creature, by its numbers, and where they meet.
struct Met {
    limbs: [usize; 2],
    places: [Place; 2],
}

impl Bones {
    pub(crate) fn new(creature: &Creature, said: Said, height: f32) -> Result<Self> {
        let limbs = (0..creature.info()?.limbs).map(|limb| creature.limb(limb)).collect::<Result<_>>()?;
        Ok(Self { limbs, said, height, places: None })
    }

    /// Where limbs lie over each other in a frame.
    pub(crate) fn overlaps(&mut self, creature: &Creature, document: &Document, frame: u64) -> Result<Vec<Overlap>> {
        let now = document.depths_said();
        let met = self.met(creature, frame)?;
        let number = |limb: usize| document.limbs.iter().position(|l| l.label == self.limbs[limb].label);
        let of = |met: Met| {
            let front = self.front(&met, &now, frame);
            let behind = 1 - front;
            let [a, b] = [number(met.limbs[front])?, number(met.limbs[behind])?];
            let said = [a, b].iter().any(|limb| document.depth(*limb, frame).depth.is_some());
            let at = (met.places[0].at + met.places[1].at) / 2.0;
            let ways = [met.places[front].way, met.places[behind].way];
            Some(Overlap { front: a, behind: b, at: (at.x, at.y), said, ways })
        };
        Ok(met.into_iter().filter_map(of).collect())
    }

    /// What to say of limbs' depth on a frame, [`None`] for nothing, so that `front` lies before each of `behind`; or, with
    /// `!before`, behind them. `front` is moved, unless another hangs from it or was moved on this frame already.
    pub(crate) fn order(
        &mut self,
        creature: &Creature,
        document: &Document,
        frame: u64,
        (moved, before, others): (usize, bool, &[usize]),
    ) -> Result<Vec<(usize, Option<f32>)>> {
        let all = self.met(creature, frame)?;
        let label = |limb: usize| document.limbs.get(limb).map_or("", |l| l.label.as_str());
        let number = |limb: usize| document.limbs.iter().position(|l| l.label == self.limbs[limb].label);
        let mut said = document.depths_said();
        let mut marks: Vec<(usize, Option<f32>)> = Vec::new();
        for met in all {
            let names = met.limbs.map(|limb| self.limbs[limb].label.as_str());
            let Some(own) = names.iter().position(|name| *name == label(moved)) else { continue };
            let other = 1 - own;
            if !others.iter().any(|limb| label(*limb) == names[other]) {
                continue;
            }
            let (front, behind) = if before { (own, other) } else { (other, own) };
            let in_order = |said: &Said| self.front(&met, said, frame) == front;
            if in_order(&said) {
                continue;
            }
            let hangs = |a: usize, b: usize| self.limbs[met.limbs[a]].parent == Some(met.limbs[b] as u32);
            let is_said = |i: usize| said_at(&said, names[i], frame).is_some();
            let mover =
                if hangs(other, own) || (is_said(other) && !is_said(own) && !hangs(own, other)) { other } else { own };
            // What was said before may be all that is wrong.
            let unsaid = with(&said, names[mover], frame, None);
            let mark = if is_said(mover) && in_order(&unsaid) {
                said = unsaid;
                None
            } else {
                let gap = self.limbs[met.limbs[0]].radius + self.limbs[met.limbs[1]].radius;
                let lacks = self.depth(&met, behind, &said, frame) + gap - self.depth(&met, front, &said, frame);
                let free = self.free(&met, mover).max(LEAST_FREE);
                let by = if mover == front { lacks } else { -lacks } / free;
                let depth = eased(keys_of(&said, names[mover]), frame) + by;
                said = with(&said, names[mover], frame, Some(depth));
                Some(depth)
            };
            let Some(limb) = number(met.limbs[mover]) else { continue };
            marks.retain(|(of, _)| *of != limb);
            marks.push((limb, mark));
        }
        Ok(marks)
    }

    /// Which of two limbs is in front where they meet; of two that are as deep the first.
    fn front(&self, met: &Met, now: &Said, frame: u64) -> usize {
        usize::from(self.depth(met, 1, now, frame) > self.depth(met, 0, now, frame))
    }

    /// How far toward the viewer one of two limbs is where they meet, with what is said now.
    fn depth(&self, met: &Met, i: usize, now: &Said, frame: u64) -> f32 {
        let label = &self.limbs[met.limbs[i]].label;
        let since = eased(keys_of(now, label), frame) - eased(keys_of(&self.said, label), frame);
        met.places[i].z + since * self.free(met, i)
    }

    /// The share of what is said that a limb has reached where it meets the other.
    fn free(&self, met: &Met, i: usize) -> f32 {
        let held = self.limbs[met.limbs[i]].parent.is_some();
        if held { smooth(met.places[i].share / HIP) } else { 1.0 }
    }

    fn met(&mut self, creature: &Creature, frame: u64) -> Result<Vec<Met>> {
        if self.places.as_ref().is_none_or(|(held, _)| *held != frame) {
            let flip = |[x, y, z]: [f32; 3]| [x, self.height - y, z];
            let places = creature.bone_places(frame)?.into_iter().map(flip).collect();
            self.places = Some((frame, places));
        }
        let places = self.places.as_ref().map_or(&[][..], |(_, places)| places);
        let line = |limb: &CreatureLimb| places.get(limb.bones.start as usize..limb.bones.end as usize).unwrap_or(&[]);
        let mut all = Vec::new();
        for a in 0..self.limbs.len() {
            for b in a + 1..self.limbs.len() {
                let limbs = [&self.limbs[a], &self.limbs[b]];
                if let Some(places) = meeting(limbs, limbs.map(line)) {
                    all.push(Met { limbs: [a, b], places });
                }
            }
        }
        Ok(all)
    }
}

/// Where two lines of bones cross, or else come near to each other, away from where the limbs hang.
fn meeting(limbs: [&CreatureLimb; 2], lines: [&[[f32; 3]]; 2]) -> Option<[Place; 2]> {
    let wide = limbs[0].radius + limbs[1].radius;
    // A limb lies on another where it begins, whether it meets it there or not.
    let joints: Vec<Vec2> = lines.iter().filter_map(|line| line.first()).map(|p| vec2(p[0], p[1])).collect();
    let from_joints = |at: Vec2| joints.iter().map(|j| (*j - at).length()).fold(f32::INFINITY, f32::min);
    let mut best: Option<(bool, f32, [Place; 2])> = None;
    for (i, a) in lines[0].windows(2).enumerate() {
        for (j, b) in lines[1].windows(2).enumerate() {
            let (s, t) = nearest(flat(a), flat(b));
            let places = [place(lines[0], i, s), place(lines[1], j, t)];
            let apart = (places[0].at - places[1].at).length();
            let far = from_joints(places[0].at).min(from_joints(places[1].at));
            let crosses = apart < 1e-3;
            if far < wide || !(crosses || apart < BESIDE * wide) {
                continue;
            }
            // A crossing before what is only near; of crossings the farthest from a joint, else the nearest.
            let worth = if crosses { far } else { -apart };
            if best.as_ref().is_none_or(|b| (crosses, worth) > (b.0, b.1)) {
                best = Some((crosses, worth, places));
            }
        }
    }
    best.map(|best| best.2)
}

fn flat(pair: &[[f32; 3]]) -> [Vec2; 2] {
    [vec2(pair[0][0], pair[0][1]), vec2(pair[1][0], pair[1][1])]
}

fn place(line: &[[f32; 3]], i: usize, t: f32) -> Place {
    let [from, to] = flat(&line[i..i + 2]);
    let share = (i as f32 + t) / (line.len() - 1).max(1) as f32;
    let z = line[i][2] + (line[i + 1][2] - line[i][2]) * t;
    Place { at: from + (to - from) * t, share, way: (to - from).normalized(), z }
}

/// Where on two straight lines the places are that are nearest to each other, 0..=1 along each.
fn nearest([a, b]: [Vec2; 2], [c, d]: [Vec2; 2]) -> (f32, f32) {
    let cross = |u: Vec2, v: Vec2| u.x * v.y - u.y * v.x;
    let (u, v) = (b - a, d - c);
    let det = cross(u, v);
    if det.abs() > f32::EPSILON {
        let (s, t) = (cross(c - a, v) / det, cross(c - a, u) / det);
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            return (s, t);
        }
    }
    let on =
        |at: Vec2, from: Vec2, way: Vec2| ((at - from).dot(way) / way.length_sq().max(f32::EPSILON)).clamp(0.0, 1.0);
    let ends = [(0.0, on(a, c, v)), (1.0, on(b, c, v)), (on(c, a, u), 0.0), (on(d, a, u), 1.0)];
    let apart = |(s, t): (f32, f32)| ((a + u * s) - (c + v * t)).length_sq();
    ends.into_iter().min_by(|x, y| apart(*x).total_cmp(&apart(*y))).unwrap_or_default()
}

fn keys_of<'a>(said: &'a Said, label: &str) -> &'a [(u64, Option<f32>)] {
    said.iter().find(|(of, _)| of == label).map_or(&[], |(_, keys)| keys)
}

fn said_at(said: &Said, label: &str, frame: u64) -> Option<f32> {
    keys_of(said, label).iter().find(|(key, _)| *key == frame)?.1
}

/// The same with something else said of a limb on a frame.
fn with(said: &Said, label: &str, frame: u64, depth: Option<f32>) -> Said {
    let mut said = said.clone();
    if let Some((_, keys)) = said.iter_mut().find(|(of, _)| of == label) {
        match keys.binary_search_by_key(&frame, |key| key.0) {
            Ok(at) => keys[at].1 = depth,
            Err(at) => keys.insert(at, (frame, depth)),
        }
    }
    said
}

/// What holds in a frame of what is said on some: from key to key it changes smoothly, and is 0 at keys of which nothing
/// is said.
fn eased(keys: &[(u64, Option<f32>)], frame: u64) -> f32 {
    let said = |i: usize| keys.get(i).and_then(|key| key.1).unwrap_or(0.0);
    let after = keys.partition_point(|(key, _)| *key <= frame);
    if after == 0 || after == keys.len() {
        return said(after.saturating_sub(1));
    }
    let (from, to) = (keys[after - 1].0, keys[after].0);
    let t = (frame - from) as f32 / (to - from) as f32;
    said(after - 1) + (said(after) - said(after - 1)) * smooth(t)
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// What a limb lies over and under: whether it is in front, and the other one.
pub(crate) fn of(overlaps: &[Overlap], limb: usize) -> impl Iterator<Item = (bool, usize)> {
    overlaps.iter().filter_map(move |o| match (o.front == limb, o.behind == limb) {
        (true, _) => Some((true, o.behind)),
        (_, true) => Some((false, o.front)),
        _ => None,
    })
}

/// The overlap whose mark is at a place of the screen.
pub(crate) fn at(overlaps: &[Overlap], placed: Placement, at: Pos2) -> Option<&Overlap> {
    let far = |o: &&Overlap| placed.to_screen(o.at).distance(at);
    overlaps.iter().filter(|o| far(o) <= NEAR).min_by(|a, b| far(a).total_cmp(&far(b)))
}

/// Each as a bridge: the line in front goes through, the other is cut; a bright ring where a person said so.
pub(crate) fn paint(painter: &Painter, placed: Placement, overlaps: &[Overlap], hovered: Option<&Overlap>) {
    for overlap in overlaps {
        let at = placed.to_screen(overlap.at);
        let radius = if hovered == Some(overlap) { RADIUS + 2.5 } else { RADIUS };
        let ring = if overlap.said {
            Stroke::new(2.0, Color32::WHITE)
        } else {
            Stroke::new(1.0, Color32::from_white_alpha(120))
        };
        painter.circle(at, radius, Color32::from_black_alpha(205), ring);
        let [front, behind] = overlap.ways.map(|way| way * (radius - 1.5));
        let pen = |limb: usize, wide: f32| Stroke::new(wide, theme::limb(limb));
        for side in [-1.0, 1.0] {
            painter.line_segment([at + behind * side, at + behind * (side * 0.45)], pen(overlap.behind, 2.5));
        }
        painter.line_segment([at - front, at + front], pen(overlap.front, 3.5));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limb(parent: Option<u32>) -> CreatureLimb {
        CreatureLimb { label: String::new(), length: 100.0, radius: 5.0, parent, bones: 0..2 }
    }

    #[test]
    fn limbs_that_cross_meet_there_and_limbs_that_hang_together_do_not() {
        let (down, up) = ([[0.0, 0.0, 1.0], [100.0, 100.0, 3.0]], [[0.0, 100.0, 0.0], [100.0, 0.0, 0.0]]);
        let legs = [&limb(Some(0)), &limb(Some(0))];
        let [a, b] = meeting(legs, [&down, &up]).expect("they cross");
        assert!((a.at - vec2(50.0, 50.0)).length() < 1e-3 && (b.share - 0.5).abs() < 1e-4 && (a.z - 2.0).abs() < 1e-4);
        // From one hip, apart at once.
        let away = [[0.0, 0.0, 0.0], [-100.0, 100.0, 0.0]];
        assert!(meeting(legs, [&down, &away]).is_none());
        // Side by side, nearer than they are wide.
        let beside = [[4.0, 0.0, 0.0], [104.0, 100.0, 0.0]];
        assert!(meeting(legs, [&down, &beside]).is_some());
        let apart = [[20.0, 0.0, 0.0], [120.0, 100.0, 0.0]];
        assert!(meeting(legs, [&down, &apart]).is_none());
        assert!(meeting(legs, [&[], &up]).is_none(), "a limb without bones");
    }

    #[test]
    fn what_is_said_holds_on_its_frame_and_fades() {
        let keys = [(0, None), (10, Some(8.0)), (20, None)];
        assert_eq!([0, 5, 10, 15, 20, 30].map(|f| eased(&keys, f)), [0.0, 4.0, 8.0, 4.0, 0.0, 0.0]);
        assert_eq!((eased(&[], 3), eased(&[(4, Some(2.0))], 9)), (0.0, 2.0));
    }
}
