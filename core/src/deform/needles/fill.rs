//! Where the solve of a joint area starts: without folds, mostly.
//!
//! The blend of the bones' maps folds on the inside of a bend. What it says of turn and stretch is sound, so that the
//! area is filled anew from those (a Poisson problem), and then a few local and global steps as rigid as possible follow
//! (Liu et al. 2008), with the stretch. One factor for all.

use glam::{DMat2, DVec2, Vec2};

use super::blend::Placed;
use crate::deform::sparse::{Factor, Graph, Symbolic};

/// Local and global steps.
const ROUNDS: usize = 4;

/// The fill of one area, whose free vertices come first.
#[derive(Debug)]
pub(super) struct Fill {
    symbolic: Symbolic,
    factor: Factor,
    /// Of each corner of each triangle, area times the slope of its share.
    slopes: Vec<[DVec2; 3]>,
}

impl Fill {
    /// `None` when the mesh at rest is too flat.
    pub(super) fn new(graph: &Graph, rest: &[DVec2], triangles: &[[u32; 3]]) -> Option<Self> {
        let free = graph.len();
        let points: Vec<Vec2> = rest[..free].iter().map(|p| p.as_vec2()).collect();
        let symbolic = Symbolic::new(graph, &points);
        let (mut diagonal, mut off) = (vec![0.0; free], vec![0.0; graph.entries()]);
        let mut slopes = Vec::with_capacity(triangles.len());
        for t in triangles {
            let [a, b, c] = t.map(|v| rest[v as usize]);
            let own = [c - b, a - c, b - a].map(|e| 0.5 * e.perp());
            let area = 0.5 * (b - a).perp_dot(c - a);
            for i in 0..3 {
                for j in 0..3 {
                    let (v, u) = (t[i] as usize, t[j] as usize);
                    if v >= free || u >= free {
                        continue;
                    }
                    let weight = own[i].dot(own[j]) / area;
                    if i == j {
                        diagonal[v] += weight;
                    } else if let Some(entry) = graph.entry(v, t[j]) {
                        off[entry] += weight;
                    }
                }
            }
            slopes.push(own);
        }
        let factor = symbolic.factor(graph, &diagonal, &off)?;
        Some(Self { symbolic, factor, slopes })
    }

    /// Fills `places`, as `placed` asks for turns and stretches.
    pub(super) fn fill(&mut self, rest: &[DVec2], triangles: &[[u32; 3]], placed: &[Placed], places: &mut [DVec2]) {
        self.pour(rest, triangles, places, |_, corners, _| {
            let (turn, stretch) = mean(placed, corners);
            turned_by(DVec2::from_angle(turn), stretch)
        });
        self.relax(rest, triangles, placed, places);
    }

    /// As rigid as possible while triangles are turned over.
    fn relax(&mut self, rest: &[DVec2], triangles: &[[u32; 3]], placed: &[Placed], places: &mut [DVec2]) {
        let folded = |places: &[DVec2]| {
            triangles.iter().any(|t| {
                let [a, b, c] = t.map(|v| places[v as usize]);
                (b - a).perp_dot(c - a) <= 0.0
            })
        };
        for _ in 0..ROUNDS {
            if !folded(places) {
                break;
            }
            self.pour(rest, triangles, places, |_, corners, now| {
                let stretch = mean(placed, corners).1;
                let m = now * stretch.transpose();
                let turn = DVec2::new(m.x_axis.x + m.y_axis.y, m.x_axis.y - m.y_axis.x);
                turned_by(turn.try_normalize().unwrap_or(DVec2::X), stretch)
            });
        }
    }

    /// Carries the shape `last` of `before` on to `placed`: every triangle turns and stretches as stage one does.
    pub(super) fn carry(
        &mut self,
        rest: &[DVec2],
        triangles: &[[u32; 3]],
        [before, placed]: [&[Placed]; 2],
        last: &[DVec2],
        places: &mut [DVec2],
    ) {
        let maps: Vec<DMat2> = triangles.iter().zip(&self.slopes).map(|(t, s)| map_of(rest, t, s, last)).collect();
        self.pour(rest, triangles, places, |k, corners, _| {
            let ((old_turn, old), (turn, new)) = (mean(before, corners), mean(placed, corners));
            let map = if old == new { maps[k] } else { maps[k] * old.inverse() * new };
            turned_by(DVec2::from_angle(turn - old_turn), map)
        });
    }

    /// Moves the free vertices so that the triangles' maps come nearest to what `wish` makes of each: of its number, its
    /// corners, and the map that it has.
    fn pour(
        &mut self,
        rest: &[DVec2],
        triangles: &[[u32; 3]],
        places: &mut [DVec2],
        wish: impl Fn(usize, [usize; 3], DMat2) -> DMat2,
    ) {
        let place = self.symbolic.place();
        let mut right = vec![Vec2::ZERO; place.len()];
        for (k, (t, slopes)) in triangles.iter().zip(&self.slopes).enumerate() {
            let now = map_of(rest, t, slopes, places);
            let corners = t.map(|v| v as usize);
            let lacking = wish(k, corners, now) - now;
            for (v, slope) in corners.into_iter().zip(slopes) {
                if v < place.len() {
                    right[place[v] as usize] += (lacking * *slope).as_vec2();
                }
            }
        }
        self.factor.solve(&self.symbolic, &mut right);
        for (p, at) in places.iter_mut().zip(place) {
            *p += right[*at as usize].as_dvec2();
        }
    }
}

/// Turn and stretch of a triangle.
fn mean(placed: &[Placed], corners: [usize; 3]) -> (f64, DMat2) {
    let [p, q, r] = corners.map(|v| &placed[v]);
    ((p.turn + q.turn + r.turn) / 3.0, (p.stretch + q.stretch + r.stretch) * (1.0 / 3.0))
}

fn turned_by(turn: DVec2, map: DMat2) -> DMat2 {
    DMat2::from_cols(turn.rotate(map.x_axis), turn.rotate(map.y_axis))
}

/// The linear map of a triangle.
fn map_of(rest: &[DVec2], t: &[u32; 3], slopes: &[DVec2; 3], places: &[DVec2]) -> DMat2 {
    let [a, b, c] = t.map(|v| rest[v as usize]);
    let area = 0.5 * (b - a).perp_dot(c - a);
    let mut map = DMat2::ZERO;
    for (&v, slope) in t.iter().zip(slopes) {
        let p = places[v as usize];
        map += DMat2::from_cols(p * slope.x, p * slope.y);
    }
    map * (1.0 / area)
}
