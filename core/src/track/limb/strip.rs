//! What a limb looks like along and across its stroke on key frames, and how well a pose fits a frame.
//!
//! A limb's appearance is a strip around its axis: colours inside, and just outside the knowledge whether something
//! else began there. A pose is judged by laying the strip along it, so that length, width and tip hold it as well as
//! texture does. Costs are sums over edges, which lets a search build poses edge by edge.

use glam::Vec2;

use super::footage::LabImage;
use super::foreground::Foreground;
use crate::raster::{Grid, Mask};

/// Places across the limb, in half widths: inside, and outside either border.
const ACROSS: [f32; 7] = [-1.5, -0.75, -0.375, 0.0, 0.375, 0.75, 1.5];
/// Places along every edge, as shares of it.
const ALONG: [f32; 2] = [0.0, 0.5];
/// Samples of one edge.
const SAMPLES: usize = ACROSS.len() * ALONG.len();
/// Squared colour distance (byte units, lightness at half weight) that counts as half different.
const COLOUR: f32 = 28.0 * 28.0;
/// Share of the cost inside that is texture; the rest is being animal at all.
const TEXTURE: f32 = 0.5;
/// Cost of animal just outside where the key frame had none.
const OUTSIDE: f32 = 0.8;
/// Cost of being hidden behind something nearer, between that of a good and that of a bad match.
const HIDDEN: f32 = 0.3;
/// Cost of an edge that points the other way than drawn; a quarter turn costs half.
const TURNED: f32 = 0.15;
/// The claims of nearer limbs are kept at one bit for so many working pixels.
pub(super) const CLAIM_CELL: f32 = 2.0;

/// Samples that are judged at once, those of an edge and some that count nothing.
const WIDE: usize = SAMPLES.next_multiple_of(8);

type Wide = [f32; WIDE];

/// What the key frame showed on an edge.
#[derive(Clone, Copy, Debug, Default)]
struct Samples {
    colours: [Wide; 3],
    /// How much the colour counts; zero where the key frame showed something else.
    inside: Wide,
    /// How much it counts that nothing of the animal is there.
    outside: Wide,
}

/// The strip on one key frame.
#[derive(Clone, Debug)]
struct KeyStrip {
    frame: usize,
    edges: Vec<Samples>,
    directions: Vec<Vec2>,
    /// Beyond the free end.
    tip: Samples,
}

/// A limb's looks on all its key frames.
#[derive(Clone, Debug)]
pub(super) struct Strip {
    /// Half widths at the vertices, working pixels.
    pub(super) radii: Vec<f32>,
    keys: Vec<KeyStrip>,
}

/// One frame as poses are judged on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct View<'a> {
    pub(super) image: &'a LabImage,
    /// How likely each of its pixels is the animal's, see [`Foreground::seen`].
    pub(super) animal: &'a Grid<u8>,
    /// What nearer limbs cover, at [`CLAIM_CELL`].
    pub(super) claimed: Option<&'a Mask>,
}

impl View<'_> {
    /// The colour at `p` and the probability that it is the animal's, or nothing outside the picture.
    #[inline]
    pub(super) fn at(&self, p: Vec2) -> Option<([u8; 3], f32)> {
        let colour = self.image.at(p)?;
        Some((colour, Foreground::probability_of(self.animal.get(p.x as usize, p.y as usize))))
    }

    #[inline]
    pub(super) fn is_claimed(&self, p: Vec2) -> bool {
        self.claimed.is_some_and(|m| m.at((p.x / CLAIM_CELL) as isize, (p.y / CLAIM_CELL) as isize))
    }
}

/// Where the samples of the edge from `a` to `b` lie. `ra` and `rb` are half widths.
#[inline]
fn places(a: Vec2, b: Vec2, ra: f32, rb: f32) -> [Vec2; SAMPLES] {
    let normal = (b - a).try_normalize().unwrap_or(Vec2::X).perp();
    std::array::from_fn(|i| {
        let along = ALONG[i / ACROSS.len()];
        a.lerp(b, along) + normal * (ACROSS[i % ACROSS.len()] * (ra + (rb - ra) * along))
    })
}

#[inline]
fn is_outside(i: usize) -> bool {
    let across = i % ACROSS.len();
    across == 0 || across == ACROSS.len() - 1
}

impl Strip {
    /// The looks of `poses` on their key frames. `closed` says that the limb ends there, so that beyond its tip there
    /// should be nothing of it.
    pub(super) fn new(radii: Vec<f32>, keys: &[(usize, View<'_>, &[Vec2])], closed: bool) -> Self {
        let keys = keys.iter().map(|(frame, view, pose)| KeyStrip::new(*frame, view, pose, &radii, closed)).collect();
        Self { radii, keys }
    }

    /// The two key frames around `frame`, as indices for [`Self::edge_cost`].
    pub(super) fn keys_around(&self, frame: usize) -> [usize; 2] {
        let after = self.keys.iter().position(|k| k.frame >= frame).unwrap_or(self.keys.len() - 1);
        let before = self.keys.iter().rposition(|k| k.frame <= frame).unwrap_or(0);
        [before, after]
    }

    /// Cost of edge `e` from `a` to `b`, the better of the two keys; at most about 1.
    #[inline]
    pub(super) fn edge_cost(&self, view: &View<'_>, keys: [usize; 2], e: usize, a: Vec2, b: Vec2) -> f32 {
        let at = places(a, b, self.radii[e], self.radii[e + 1]);
        let direction = (b - a).try_normalize().unwrap_or(Vec2::X);
        let against =
            |key: &KeyStrip| judge(view, &key.edges[e], &at) + TURNED * 0.5 * (1.0 - direction.dot(key.directions[e]));
        let cost = against(&self.keys[keys[0]]);
        if keys[0] == keys[1] { cost } else { cost.min(against(&self.keys[keys[1]])) }
    }

    /// Cost of what lies beyond the tip.
    #[inline]
    pub(super) fn tip_cost(&self, view: &View<'_>, keys: [usize; 2], pose: &[Vec2]) -> f32 {
        let (a, b, r) = beyond(pose, &self.radii);
        let at = places(a, b, r, r);
        judge(view, &self.keys[keys[0]].tip, &at).min(judge(view, &self.keys[keys[1]].tip, &at))
    }

    /// Mean cost of a whole pose on the frame of `view`.
    pub(super) fn cost(&self, view: &View<'_>, frame: usize, pose: &[Vec2]) -> f32 {
        self.cost_from(view, self.keys_around(frame), pose, &mut vec![0.0; pose.len()], 0, f32::INFINITY)
    }

    /// The same where `sums[e]` is known to be the cost of all edges before `e`, up to edge `from`; fills in the others.
    /// Infinite, and the sums unfinished, as soon as it is more than `most`.
    pub(super) fn cost_from(
        &self,
        view: &View<'_>,
        keys: [usize; 2],
        pose: &[Vec2],
        sums: &mut [f32],
        from: usize,
        most: f32,
    ) -> f32 {
        let n = pose.len() as f32;
        for e in from..pose.len() - 1 {
            sums[e + 1] = sums[e] + self.edge_cost(view, keys, e, pose[e], pose[e + 1]);
            if sums[e + 1] > most * n {
                return f32::INFINITY;
            }
        }
        (sums[pose.len() - 1] + self.tip_cost(view, keys, pose)) / n
    }
}

impl Strip {
    /// The cost of `pose` with what is seen, and how it changes where something in front hides each place.
    pub(super) fn hideable(&self, view: &View<'_>, frame: usize, pose: &[Vec2]) -> Hideable {
        let [before, after] = self.keys_around(frame);
        let mut samples = Vec::with_capacity((pose.len() - 1) * SAMPLES);
        for e in 0..pose.len() - 1 {
            let at = places(pose[e], pose[e + 1], self.radii[e], self.radii[e + 1]);
            let cost = |key: usize| judge(view, &self.keys[key].edges[e], &at);
            let key = if before == after || cost(before) <= cost(after) { before } else { after };
            let key = &self.keys[key].edges[e];
            let costs = key.costs(view, &at);
            for (i, &p) in at.iter().enumerate() {
                if key.counts(i) && !view.is_claimed(p) {
                    let change = HIDDEN * key.inside[i] - costs[i];
                    // What is off the picture is never hidden.
                    if p.min_element() >= 0.0 {
                        let cell = p / CLAIM_CELL;
                        samples.push((cell.x as usize, cell.y as usize, change * (NORM / pose.len() as f32)));
                    }
                }
            }
        }
        Hideable { samples }
    }
}

/// What hiding parts of a pose changes.
#[derive(Clone, Debug)]
pub(super) struct Hideable {
    /// Columns and rows in claim cells, and what being hidden there adds to the pose's cost.
    samples: Vec<(usize, usize, f32)>,
}

impl Hideable {
    /// What the pose's cost changes by when `front` is in front of it.
    pub(super) fn change(&self, front: &Mask) -> f32 {
        let inside = |x: usize, y: usize| x < front.width() && y < front.height() && front.get(x, y);
        self.samples.iter().filter(|s| inside(s.0, s.1)).map(|s| s.2).sum()
    }
}

/// The piece after the limb's end: as long as the limb is wide there.
fn beyond(pose: &[Vec2], radii: &[f32]) -> (Vec2, Vec2, f32) {
    let n = pose.len();
    let r = radii[n - 1];
    let direction = (pose[n - 1] - pose[n - 2]).try_normalize().unwrap_or(Vec2::X);
    (pose[n - 1] + direction * (0.8 * r), pose[n - 1] + direction * (2.0 * r), r)
}

impl KeyStrip {
    fn new(frame: usize, view: &View<'_>, pose: &[Vec2], radii: &[f32], closed: bool) -> Self {
        let edges = (0..pose.len() - 1)
            .map(|e| {
                let at = places(pose[e], pose[e + 1], radii[e], radii[e + 1]);
                Samples::learn(view, &at, is_outside)
            })
            .collect();
        let directions = pose.windows(2).map(|p| (p[1] - p[0]).try_normalize().unwrap_or(Vec2::X)).collect();
        let (a, b, r) = beyond(pose, radii);
        let at = places(a, b, r, r);
        let tip = if closed { Samples::learn(view, &at, |_| true) } else { Samples::default() };
        Self { frame, edges, directions, tip }
    }
}

impl Samples {
    /// What is seen at places of a key frame, of which some are `outside` of the limb.
    fn learn(view: &View<'_>, at: &[Vec2; SAMPLES], outside: impl Fn(usize) -> bool) -> Self {
        let mut out = Self::default();
        for (i, p) in at.iter().enumerate() {
            let Some((colour, animal)) = view.at(*p) else { continue };
            if view.is_claimed(*p) {
                continue;
            }
            (0..3).for_each(|c| out.colours[c][i] = f32::from(colour[c]));
            if outside(i) {
                out.outside[i] = if animal < 0.5 { 1.0 - animal } else { 0.0 };
            } else {
                // A stroke drawn past the limb's border is no reason to look for background.
                out.inside[i] = if animal > 0.35 { 1.0 } else { 0.15 };
            }
        }
        out
    }

    /// Whether a sample counts at all.
    #[inline]
    fn counts(&self, i: usize) -> bool {
        self.inside[i] + self.outside[i] > 0.0
    }

    /// What each sample costs at its place.
    #[inline]
    fn costs(&self, view: &View<'_>, at: &[Vec2; SAMPLES]) -> Wide {
        let (mut colours, mut animal, mut hidden) = ([[0.0; WIDE]; 3], [0.0; WIDE], [1.0; WIDE]);
        for (i, &p) in at.iter().enumerate() {
            if self.counts(i)
                && let Some((colour, likely)) = view.at(p)
                && !(self.inside[i] > 0.0 && view.is_claimed(p))
            {
                (0..3).for_each(|c| colours[c][i] = f32::from(colour[c]));
                animal[i] = likely;
                hidden[i] = 0.0;
            }
        }
        let mut costs = [0.0; WIDE];
        for i in 0..WIDE {
            let dl = colours[0][i] - self.colours[0][i];
            let da = colours[1][i] - self.colours[1][i];
            let db = colours[2][i] - self.colours[2][i];
            let d = 0.5 * dl * dl + da * da + db * db;
            let inside = TEXTURE * d / (d + COLOUR) + (1.0 - TEXTURE) * (1.0 - animal[i]);
            let inside = if hidden[i] > 0.0 { HIDDEN } else { inside };
            costs[i] = self.inside[i] * inside + self.outside[i] * OUTSIDE * animal[i];
        }
        costs
    }
}

/// One over the number of samples inside an edge.
const NORM: f32 = 1.0 / (SAMPLES as f32 * 5.0 / 7.0);

#[inline]
fn judge(view: &View<'_>, samples: &Samples, at: &[Vec2; SAMPLES]) -> f32 {
    samples.costs(view, at)[..SAMPLES].iter().sum::<f32>() * NORM
}
