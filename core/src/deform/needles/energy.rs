//! What the joint areas mind, and its slopes.
//!
//! Pan and Zhang 2011, section 3.3.3: rotation-and-scale-invariant Laplacian coordinates of the outline, and edge
//! lengths. A vertex of the outline between neighbours a and c is `z = (b - a) / (c - a)`, which no similarity changes.
//! Lengths and coordinates are those of the rest shape after the stretch that stage one asks for at the place. Edge
//! lengths do not see a mirrored triangle, so that each triangle also keeps its area: with J the share of it that is
//! left, `((J - 1/J) / 2)^2`, which is `(J - 1)^2` nearby and rises without bound before the triangle vanishes.

use glam::{DMat2, DVec2};

use super::blend::Placed;
use crate::deform::sparse::{Fronts, Matrix};

/// What a triangle's area weighs against edges and outline, which share 1.
const AREA: f64 = 20.0;
/// Below this share of its area, what a triangle costs goes on as a parabola, so that turned ones have a way back.
const THIN: f64 = 0.2;

const NONE: u32 = u32::MAX;

/// The terms of an area. Vertices are numbered within it, free ones first and in the order of elimination.
#[derive(Debug)]
pub(super) struct Terms {
    pub(super) edges: Vec<[u32; 2]>,
    /// Turned to the left at rest.
    pub(super) triangles: Vec<[u32; 3]>,
    /// A vertex of the outline between its neighbours.
    pub(super) outline: Vec<[u32; 3]>,
    slots: Slots,
}

/// Where the blocks of pairs lie in the matrix, in the order of `PAIRS`; `NONE` where one is held.
#[derive(Debug)]
struct Slots {
    /// Of each free vertex, and how high its columns are.
    own: Vec<[u32; 2]>,
    edges: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    outline: Vec<[u32; 3]>,
}

const PAIRS: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// What the stretched rest shape has.
#[derive(Clone, Debug, Default)]
pub(super) struct Wished {
    edge_weight: f64,
    outline_weight: f64,
    lengths: Vec<f64>,
    /// `z` of each vertex of the outline, and the way between its neighbours.
    outline: Vec<(DVec2, f64)>,
    areas: Vec<f64>,
    /// The mean edge.
    pub(super) mean: f64,
}

/// Takes in half the energy's slopes.
trait Sink {
    fn slope(&mut self, v: u32, by: DVec2);
    /// Whether curvatures are asked for.
    const CURVED: bool;
    fn curve(&mut self, v: u32, by: DMat2);
    /// The curvature between the slope of `a` and the place of `b`, whose block is at `slot`.
    fn curve_pair(&mut self, a: u32, b: u32, slot: u32, by: DMat2);
}

struct Slopes<'a>(&'a mut [DVec2]);

impl Sink for Slopes<'_> {
    const CURVED: bool = false;
    fn slope(&mut self, v: u32, by: DVec2) {
        self.0[v as usize] += by;
    }
    fn curve(&mut self, _: u32, _: DMat2) {}
    fn curve_pair(&mut self, _: u32, _: u32, _: u32, _: DMat2) {}
}

struct Curves<'a> {
    own: &'a [[u32; 2]],
    slopes: &'a mut [DVec2],
    matrix: &'a mut Matrix,
}

impl Sink for Curves<'_> {
    const CURVED: bool = true;
    fn slope(&mut self, v: u32, by: DVec2) {
        self.slopes[v as usize] += by;
    }
    fn curve(&mut self, v: u32, by: DMat2) {
        if let Some(&[slot, stride]) = self.own.get(v as usize) {
            self.matrix.add(slot, stride, by);
        }
    }
    fn curve_pair(&mut self, a: u32, b: u32, slot: u32, by: DMat2) {
        if slot != NONE {
            let (column, block) = if a > b { (b, by) } else { (a, by.transpose()) };
            self.matrix.add(slot, self.own[column as usize][1], block);
        }
    }
}

impl Terms {
    pub(super) fn new(
        free: usize,
        fronts: &Fronts,
        edges: Vec<[u32; 2]>,
        triangles: Vec<[u32; 3]>,
        outline: Vec<[u32; 3]>,
    ) -> Self {
        let slot = |a: u32, b: u32| if (a.max(b) as usize) < free { fronts.slot(a, b) } else { NONE };
        let of_three = |t: &[u32; 3]| PAIRS.map(|[i, j]| slot(t[i], t[j]));
        let slots = Slots {
            own: (0..free as u32).map(|v| [fronts.slot(v, v), fronts.stride(v)]).collect(),
            edges: edges.iter().map(|&[a, b]| slot(a, b)).collect(),
            triangles: triangles.iter().map(of_three).collect(),
            outline: outline.iter().map(of_three).collect(),
        };
        Self { edges, triangles, outline, slots }
    }

    pub(super) fn energy(&self, wished: &Wished, places: &[DVec2]) -> f64 {
        let mut sum = 0.0;
        for (&[a, b], length) in self.edges.iter().zip(&wished.lengths) {
            sum += wished.edge_weight * (places[b as usize].distance(places[a as usize]) - length).powi(2);
        }
        for (t, area) in self.triangles.iter().zip(&wished.areas) {
            sum += 2.0 * AREA * area * kept(doubled(t, places) / (2.0 * area)).0;
        }
        let mut outline = 0.0;
        for (&[a, b, c], (z, size)) in self.outline.iter().zip(&wished.outline) {
            let chord = places[c as usize] - places[a as usize];
            let square = chord.length_squared();
            if square >= LEAST_CHORD * size * size {
                let over = DVec2::new(chord.x, -chord.y) / square;
                outline += size * size * ((places[b as usize] - places[a as usize]).rotate(over) - z).length_squared();
            }
        }
        sum + wished.outline_weight * outline
    }

    /// Half the energy's slope at every vertex.
    pub(super) fn slopes(&self, wished: &Wished, places: &[DVec2], slopes: &mut [DVec2]) {
        slopes.fill(DVec2::ZERO);
        self.visit(wished, places, &mut Slopes(slopes));
    }

    /// Half the energy's slopes, and a positive definite stand-in for half its curvature.
    pub(super) fn curves(&self, wished: &Wished, places: &[DVec2], slopes: &mut [DVec2], matrix: &mut Matrix) {
        slopes.fill(DVec2::ZERO);
        matrix.clear();
        self.visit(wished, places, &mut Curves { own: &self.slots.own, slopes, matrix });
    }

    /// Makes a matrix somewhat heavier on its diagonal.
    pub(super) fn damp(&self, matrix: &mut Matrix, by: f32) {
        self.slots.own.iter().for_each(|&[slot, stride]| matrix.damp(slot, stride, 1.0 + by));
    }

    fn visit<S: Sink>(&self, wished: &Wished, places: &[DVec2], sink: &mut S) {
        for (k, (&[a, b], length)) in self.edges.iter().zip(&wished.lengths).enumerate() {
            let way = places[b as usize] - places[a as usize];
            let now = way.length();
            let along = if now > 0.0 { way / now } else { DVec2::X };
            let pull = wished.edge_weight * (now - length) * along;
            sink.slope(a, -pull);
            sink.slope(b, pull);
            if S::CURVED {
                // Across, a spring that is too long holds back; one that is too short gives way, which is left out.
                let across = (1.0 - length / now.max(1e-9)).max(0.0);
                let curve = (outer(along, along) * (1.0 - across) + DMat2::from_diagonal(DVec2::splat(across)))
                    * wished.edge_weight;
                sink.curve(a, curve);
                sink.curve(b, curve);
                sink.curve_pair(a, b, self.slots.edges[k], -curve);
            }
        }
        for (k, (t, area)) in self.triangles.iter().zip(&wished.areas).enumerate() {
            let [a, b, c] = t.map(|v| places[v as usize]);
            let share = 0.5 / area;
            let (_, slope, curve) = kept((b - a).perp_dot(c - a) * share);
            let ways = [b - c, c - a, a - b].map(|e| DVec2::new(e.y, -e.x) * share);
            let weight = AREA * area;
            for i in 0..3 {
                sink.slope(t[i], ways[i] * (weight * slope));
            }
            if S::CURVED {
                let curve = weight * curve;
                for i in 0..3 {
                    sink.curve(t[i], outer(ways[i], ways[i]) * curve);
                }
                for (pair, [i, j]) in PAIRS.into_iter().enumerate() {
                    sink.curve_pair(t[i], t[j], self.slots.triangles[k][pair], outer(ways[i], ways[j]) * curve);
                }
            }
        }
        for (k, (t, (z, size))) in self.outline.iter().zip(&wished.outline).enumerate() {
            let [a, b, c] = t.map(|v| places[v as usize]);
            let chord = c - a;
            let square = chord.length_squared();
            // Neighbours on one spot have no frame; the edges part them again.
            if square < LEAST_CHORD * size * size {
                continue;
            }
            let over = DVec2::new(chord.x, -chord.y) / square;
            let now = (b - a).rotate(over);
            let weight = wished.outline_weight * size * size;
            let gap = (now - z) * weight;
            // Derivatives as complex numbers; a number p + iq acts as the matrix [p -q; q p].
            let ways = [(now - DVec2::X).rotate(over), over, -now.rotate(over)];
            for i in 0..3 {
                sink.slope(t[i], conjugate(ways[i]).rotate(gap));
            }
            if S::CURVED {
                let curve = |i: usize, j: usize| {
                    let m = conjugate(ways[i]).rotate(ways[j]) * weight;
                    DMat2::from_cols(m, m.perp())
                };
                for i in 0..3 {
                    sink.curve(t[i], curve(i, i));
                }
                for (pair, [i, j]) in PAIRS.into_iter().enumerate() {
                    sink.curve_pair(t[i], t[j], self.slots.outline[k][pair], curve(i, j));
                }
            }
        }
    }

    /// Triangles that are turned over or gone.
    pub(super) fn turned(&self, places: &[DVec2]) -> usize {
        self.triangles.iter().filter(|t| doubled(t, places) <= 0.0).count()
    }

    /// The largest share of a step at which no triangle vanishes that is sound before it.
    pub(super) fn room(&self, places: &[DVec2], step: &[DVec2]) -> f64 {
        let mut room = f64::INFINITY;
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| places[v as usize]);
            let [da, db, dc] = t.map(|v| step.get(v as usize).copied().unwrap_or_default());
            let (p, q, dp, dq) = (b - a, c - a, db - da, dc - da);
            // The area along the step is a parabola: where does it first vanish?
            let (none, once, twice) = (p.perp_dot(q), p.perp_dot(dq) + dp.perp_dot(q), dp.perp_dot(dq));
            if none <= 0.0 || (once >= 0.0 && twice >= 0.0) {
                continue;
            }
            let square = once * once - 4.0 * twice * none;
            if square < 0.0 {
                continue;
            }
            let root = 2.0 * none / (-once + square.sqrt());
            if root > 0.0 {
                room = room.min(root);
            }
        }
        room
    }
}

/// Neighbours nearer than the root of this share of their distance at rest have no frame.
const LEAST_CHORD: f64 = 1e-4;

fn doubled(t: &[u32; 3], places: &[DVec2]) -> f64 {
    let [a, b, c] = t.map(|v| places[v as usize]);
    (b - a).perp_dot(c - a)
}

/// Half what a triangle costs that kept a share of its area, the slope and the curvature.
fn kept(share: f64) -> (f64, f64, f64) {
    let at = |j: f64| {
        let inverse = 1.0 / (j * j);
        (0.125 * (j * j + inverse) - 0.25, 0.25 * (j - inverse / j), 0.25 + 0.75 * inverse * inverse)
    };
    if share >= THIN {
        return at(share);
    }
    let (value, slope, curve) = at(THIN);
    let by = share - THIN;
    (value + by * (slope + 0.5 * curve * by), slope + curve * by, curve)
}

fn outer(a: DVec2, b: DVec2) -> DMat2 {
    DMat2::from_cols(a * b.x, a * b.y)
}

fn conjugate(z: DVec2) -> DVec2 {
    DVec2::new(z.x, -z.y)
}

impl Wished {
    /// Measures the rest shape of an area, stretched at each of its vertices.
    pub(super) fn measure(&mut self, terms: &Terms, rest: &[DVec2], placed: &[Placed], outline_weight: f64) {
        let way = |a: u32, b: u32| {
            let (a, b) = (a as usize, b as usize);
            (placed[a].stretch + placed[b].stretch) * 0.5 * (rest[b] - rest[a])
        };
        self.edge_weight = 1.0 - outline_weight;
        self.outline_weight = outline_weight;
        self.outline.clear();
        self.outline.extend(terms.outline.iter().map(|&[a, b, c]| {
            let (to_b, to_c) = (way(a, b), way(a, b) + way(b, c));
            let square = to_c.length_squared().max(1e-12);
            (to_b.rotate(conjugate(to_c)) / square, to_c.length().max(1e-6))
        }));
        self.lengths.clear();
        self.lengths.extend(terms.edges.iter().map(|&[a, b]| way(a, b).length()));
        self.mean = self.lengths.iter().sum::<f64>() / self.lengths.len().max(1) as f64;
        self.areas.clear();
        self.areas.extend(terms.triangles.iter().map(|t| {
            let mean = t.iter().map(|&v| placed[v as usize].stretch.determinant()).sum::<f64>() / 3.0;
            (0.5 * doubled(t, rest) * mean).max(1e-9)
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deform::sparse::Graph;
    use glam::{Vec2, dvec2};

    /// A strip of five vertices, the first three free, the outline running along its top.
    fn strip() -> (Terms, Wished, Fronts, [DVec2; 5]) {
        let rest = [dvec2(1.0, 1.0), dvec2(0.5, 0.0), dvec2(1.5, 0.1), dvec2(0.0, 1.0), dvec2(2.0, 1.1)];
        let triangles = vec![[3, 1, 0], [1, 2, 0], [0, 2, 4]];
        let edges = vec![[0, 1], [0, 2], [1, 2], [0, 3], [1, 3], [0, 4], [2, 4]];
        let graph = Graph::of_groups(3, [&[0u32, 1][..], &[0, 1, 2]].into_iter());
        let (fronts, order) = Fronts::new(&graph, &[Vec2::X, Vec2::ZERO, Vec2::Y]);
        assert_eq!(order.len(), 3);
        let terms = Terms::new(3, &fronts, edges, triangles, vec![[4, 0, 3]]);
        let placed = Placed { at: DVec2::ZERO, turn: 0.0, stretch: DMat2::from_diagonal(dvec2(1.2, 1.0 / 1.2)) };
        let mut wished = Wished::default();
        wished.measure(&terms, &rest, &[placed; 5], 0.4);
        (terms, wished, fronts, rest)
    }

    #[test]
    fn slopes_are_those_of_the_energy_also_beyond_what_is_thin() {
        let (terms, wished, _, rest) = strip();
        // The second and third time a triangle is thin, and turned over.
        for lift in [0.0, 0.75, 1.2] {
            let mut places = rest;
            places[1] += dvec2(0.1, lift);
            let mut slopes = [DVec2::ZERO; 5];
            terms.slopes(&wished, &places, &mut slopes);
            assert_eq!(terms.turned(&places) > 0, lift == 1.2);
            for v in 0..3 {
                for axis in [DVec2::X, DVec2::Y] {
                    let at = |by: f64| {
                        let mut moved = places;
                        moved[v] += by * axis;
                        terms.energy(&wished, &moved)
                    };
                    let wished = (at(1e-6) - at(-1e-6)) / 4e-6;
                    let own = slopes[v].dot(axis);
                    assert!((own - wished).abs() < 1e-4 * (1.0 + wished.abs()), "{lift} {v} {own} {wished}");
                }
            }
        }
    }

    #[test]
    fn the_matrix_leads_downhill_and_steps_end_before_a_triangle_vanishes() {
        let (terms, wished, fronts, rest) = strip();
        let mut places = rest;
        places[0].y += 0.3;
        let (mut slopes, mut matrix) = ([DVec2::ZERO; 5], fronts.matrix());
        terms.curves(&wished, &places, &mut slopes, &mut matrix);
        assert!(fronts.factor(&mut matrix));
        let mut step: Vec<DVec2> = slopes[..3].iter().map(|s| -*s).collect();
        fronts.solve(&mut matrix, &mut step);
        let lower: Vec<DVec2> =
            places.iter().enumerate().map(|(v, p)| *p + *step.get(v).unwrap_or(&DVec2::ZERO)).collect();
        assert!(terms.energy(&wished, &lower) < 0.3 * terms.energy(&wished, &places));
        // The lower vertex is pushed up through the upper side.
        let push = [DVec2::ZERO, dvec2(0.0, 4.0), DVec2::ZERO];
        let room = terms.room(&rest, &push);
        let at = |share: f64| {
            let mut moved = rest;
            moved[1] += push[1] * share;
            terms.turned(&moved)
        };
        assert_eq!((at(0.99 * room), at(1.01 * room)), (0, 1));
        assert_eq!(terms.room(&rest, &[DVec2::ONE; 3].map(|d| d * 1e-9)).min(1.0), 1.0);
    }
}
