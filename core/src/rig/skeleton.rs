//! The tree that joined strokes make, with every limb sampled at the same places on every key frame.
//!
//! Strokes that start or end near another's start or end share that vertex. Where joins close a circle, the join that
//! would close it is left open, so that what remains is a tree, or several (Reinert 2016, section 3.4; exact optima
//! over trees need this).

use glam::Vec2;

use super::Rig;
use crate::geometry::polyline;

/// Ends closer than this share of the image diagonal are joined: what a steady hand misses by.
const JOIN_DISTANCE: f32 = 0.025;

/// One limb's vertices in the skeleton.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LimbChain {
    /// Vertex indices from the stroke's start to its end; the ends may be shared with other limbs.
    pub vertices: Vec<usize>,
    /// The limb whose end this limb hangs from, nearer to the root; `None` for a limb that holds a root.
    pub parent: Option<usize>,
    /// Whether the chain's first vertex is the end nearer to the root.
    pub rooted_at_start: bool,
    /// Whether nothing hangs from the end away from the root.
    pub terminal: bool,
}

/// All limbs' vertices as a forest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skeleton {
    /// The limbs, in the rig's order.
    pub limbs: Vec<LimbChain>,
    /// Each vertex's parent; `None` for roots.
    pub parent: Vec<Option<usize>>,
    /// All vertices, parents before children.
    pub order: Vec<usize>,
}

impl Skeleton {
    /// The skeleton of a valid rig, with vertices about `spacing` clip pixels apart.
    pub fn new(rig: &Rig, spacing: f32) -> Self {
        let count = |limb| ((rig.length_hint(limb) / spacing).round() as usize + 1).max(2);
        let ends = join_ends(rig);
        let mut vertex_of_end = vec![None; ends.iter().max().map_or(0, |m| m + 1)];
        let mut vertices = 0;
        let mut chains: Vec<Vec<usize>> = Vec::with_capacity(rig.limbs.len());
        for limb in 0..rig.limbs.len() {
            let n = count(limb);
            let chain = (0..n).map(|i| {
                let mut fresh = || {
                    vertices += 1;
                    vertices - 1
                };
                match i {
                    0 => *vertex_of_end[ends[2 * limb]].get_or_insert_with(fresh),
                    _ if i == n - 1 => *vertex_of_end[ends[2 * limb + 1]].get_or_insert_with(fresh),
                    _ => fresh(),
                }
            });
            chains.push(chain.collect());
        }
        Self::grow(rig, &chains, vertices)
    }

    /// Hangs the chains from roots: the longest limb's start first, then the longest limb not yet reached.
    fn grow(rig: &Rig, chains: &[Vec<usize>], vertices: usize) -> Self {
        let mut by_length: Vec<usize> = (0..chains.len()).collect();
        by_length.sort_by(|&a, &b| rig.length_hint(b).total_cmp(&rig.length_hint(a)).then(a.cmp(&b)));
        let blank = LimbChain { vertices: Vec::new(), parent: None, rooted_at_start: true, terminal: true };
        let mut limbs = vec![blank; chains.len()];
        let mut parent = vec![None; vertices];
        let mut order = Vec::with_capacity(vertices);
        let mut placed = vec![false; chains.len()];
        for &root in &by_length {
            if placed[root] {
                continue;
            }
            let mut waiting = std::collections::VecDeque::from([(root, true, None)]);
            placed[root] = true;
            order.push(chains[root][0]);
            while let Some((limb, at_start, from)) = waiting.pop_front() {
                let chain = &chains[limb];
                let outward: Vec<usize> = if at_start { chain.clone() } else { chain.iter().rev().copied().collect() };
                for pair in outward.windows(2) {
                    parent[pair[1]] = Some(pair[0]);
                    order.push(pair[1]);
                }
                limbs[limb] =
                    LimbChain { vertices: chain.clone(), parent: from, rooted_at_start: at_start, terminal: true };
                let near_end = (from.is_none()).then_some(outward[0]);
                for end in near_end.into_iter().chain(outward.last().copied()) {
                    for &next in &by_length {
                        let (first, last) = (chains[next][0], chains[next][chains[next].len() - 1]);
                        if placed[next] || (first != end && last != end) {
                            continue;
                        }
                        placed[next] = true;
                        waiting.push_back((next, first == end, Some(limb)));
                        if outward.last() == Some(&end) {
                            limbs[limb].terminal = false;
                        }
                    }
                }
            }
        }
        Self { limbs, parent, order }
    }

    /// How many vertices there are.
    pub fn len(&self) -> usize {
        self.parent.len()
    }

    /// Whether there is no vertex.
    pub fn is_empty(&self) -> bool {
        self.parent.is_empty()
    }

    /// Where the vertices of `limb` lie on its stroke on `frame`, where it is drawn there: equal arc-length steps.
    pub fn drawn(&self, rig: &Rig, limb: usize, frame: usize) -> Option<Vec<Vec2>> {
        let stroke = rig.stroke(limb, frame)?;
        Some(polyline::resample(&stroke.points, self.limbs[limb].vertices.len()))
    }
}

/// A class for each limb end (`2 * limb` its start, `2 * limb + 1` its end); ends of one class are one vertex.
/// Decided on the first key frame on which both limbs are drawn.
fn join_ends(rig: &Rig) -> Vec<usize> {
    let limbs = rig.limbs.len();
    let within = JOIN_DISTANCE * Vec2::new(rig.size.0 as f32, rig.size.1 as f32).length();
    let mut gaps = Vec::new();
    for a in 0..limbs {
        for b in a + 1..limbs {
            let both = rig.keys_of(a).find_map(|(frame, s)| rig.stroke(b, frame).map(|t| (s, t)));
            let Some((s, t)) = both else { continue };
            // A limb shorter than two such distances would join itself to everything around it.
            let reach = within.min(0.4 * polyline::length(&s.points)).min(0.4 * polyline::length(&t.points));
            for (i, p) in [s.points[0], s.points[s.points.len() - 1]].into_iter().enumerate() {
                for (j, q) in [t.points[0], t.points[t.points.len() - 1]].into_iter().enumerate() {
                    if p.distance(q) <= reach {
                        gaps.push((p.distance(q), 2 * a + i, 2 * b + j));
                    }
                }
            }
        }
    }
    gaps.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut class: Vec<usize> = (0..2 * limbs).collect();
    // A join is a circle when the two limbs already hang together another way: follow limbs as well as ends.
    let mut tree: Vec<usize> = (0..limbs).collect();
    for (_, a, b) in gaps {
        if class[a] == class[b] {
            continue;
        }
        let (ta, tb) = (tree[a / 2], tree[b / 2]);
        if ta == tb {
            continue;
        }
        let (ca, cb) = (class[a], class[b]);
        class.iter_mut().filter(|c| **c == cb).for_each(|c| *c = ca);
        tree.iter_mut().filter(|t| **t == tb).for_each(|t| *t = ta);
    }
    class
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::{KeyFrame, Limb, Stroke};
    use glam::vec2;

    fn rig(strokes: &[&[(f32, f32)]]) -> Rig {
        let limbs = (0..strokes.len()).map(|i| Limb { label: i.to_string(), side: None }).collect();
        let strokes = strokes.iter().enumerate().map(|(limb, points)| Stroke {
            limb,
            points: points.iter().map(|&p| p.into()).collect(),
            facing: None,
        });
        let key = KeyFrame { frame: 0, strokes: strokes.collect(), ..KeyFrame::default() };
        Rig { size: (400, 300), limbs, keyframes: vec![key] }
    }

    #[test]
    fn legs_hang_from_the_body_and_parents_come_first() {
        let rig = rig(&[
            &[(100.0, 100.0), (100.0, 200.0)],
            &[(102.0, 99.0), (300.0, 100.0)],
            &[(300.0, 200.0), (301.0, 101.0)],
        ]);
        let skeleton = Skeleton::new(&rig, 10.0);
        assert_eq!(skeleton.limbs[0].parent, Some(1));
        assert_eq!(skeleton.limbs[2].parent, Some(1));
        assert!(skeleton.limbs[0].rooted_at_start && !skeleton.limbs[2].rooted_at_start);
        assert!(skeleton.limbs[0].terminal && !skeleton.limbs[1].terminal);
        assert_eq!(skeleton.limbs[0].vertices[0], skeleton.limbs[1].vertices[0]);
        assert_eq!(skeleton.order.len(), skeleton.len());
        let mut seen = vec![false; skeleton.len()];
        for &v in &skeleton.order {
            assert!(skeleton.parent[v].is_none_or(|p| seen[p]));
            seen[v] = true;
        }
        assert_eq!(skeleton.drawn(&rig, 0, 0).expect("drawn")[0], vec2(100.0, 100.0));
    }

    #[test]
    fn a_circle_is_cut_and_apart_is_apart() {
        let triangle = rig(&[
            &[(100.0, 100.0), (200.0, 100.0)],
            &[(200.0, 100.0), (150.0, 200.0)],
            &[(150.0, 200.0), (100.0, 100.0)],
            &[(300.0, 250.0), (350.0, 250.0)],
        ]);
        let skeleton = Skeleton::new(&triangle, 10.0);
        assert_eq!(skeleton.parent.iter().filter(|p| p.is_none()).count(), 2);
        assert_eq!(skeleton.order.len(), skeleton.len());
    }
}
