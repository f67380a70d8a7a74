//! Stage two: the shape of the areas where bones meet.
//!
//! Pan and Zhang 2011, section 3.3.3: rotation-and-scale-invariant Laplacian coordinates of the outline, and edge
//! lengths, by Gauss-Newton. A vertex of the outline between neighbours a and c is `z = (b - a) / (c - a)`, which no
//! similarity changes. Lengths and coordinates are those of the rest shape after the stretch that stage one asks for at
//! the place. Edge lengths do not see a mirrored triangle, so that each triangle also keeps its area, the more the
//! nearer it is to vanishing. Steps are damped (Levenberg 1944; Marquardt 1963) and only taken downhill.

use glam::{DMat2, DVec2, Vec2};
use rayon::prelude::*;

use crate::deform::sparse::{Graph, Symbolic};
use crate::error::Result;
use crate::geometry::PlaneMesh;
use crate::job::Stage;

/// Steps at most.
const STEPS: usize = 15;
/// Done when a step lowers the energy by less than this share, or moves nothing by this share of the mean edge.
const SETTLED: f64 = 6e-3;
const STILL: f64 = 1e-2;
/// An area whose energy is below this, in squared mean edges, only moved: rounding.
const UNBENT: f64 = 1e-7;
/// What a triangle's area weighs against edges and outline, which share 1.
const AREA: f64 = 8.0;
/// Triangles below this share of their area are pushed up as well, this hard.
const THIN: f64 = 0.3;
const PUSH: f64 = 40.0;

/// How the joint areas were settled, each on its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settled {
    /// The areas, by their first vertices. One where nothing is bent or stretched takes no step.
    pub areas: Vec<SettledArea>,
}

/// How one joint area was settled.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SettledArea {
    /// Linear systems solved.
    pub iterations: usize,
    /// The energy at the start and after each step that was taken: never rising.
    pub energies: Vec<f64>,
    /// Triangles that are turned over.
    pub flipped: usize,
}

impl Settled {
    /// Linear systems solved for the area that took most.
    pub fn iterations(&self) -> usize {
        self.areas.iter().map(|a| a.iterations).max().unwrap_or(0)
    }

    /// Triangles of joint areas that are turned over.
    pub fn flipped(&self) -> usize {
        self.areas.iter().map(|a| a.flipped).sum()
    }
}

/// The joint areas of a mesh. No triangle has free vertices of two.
#[derive(Debug)]
pub(super) struct JointAreas(Vec<Area>);

/// The vertices of one area that may move, and what they mind.
#[derive(Debug)]
struct Area {
    /// The free vertices.
    free: Vec<u32>,
    /// Their numbers, or `u32::MAX`.
    number: Vec<u32>,
    edges: Vec<[u32; 2]>,
    triangles: Vec<[u32; 3]>,
    /// A vertex of the outline between its neighbours.
    outline: Vec<[u32; 3]>,
    graph: Graph,
    symbolic: Symbolic,
    orientation: f64,
}

/// The part of one residual: what it is, and its slope at each of three vertices.
type Slope = [(u32, DVec2); 3];

impl JointAreas {
    pub(super) fn new(mesh: &PlaneMesh, free: &[bool]) -> Self {
        // Free vertices that share a triangle hang together.
        let mut area: Vec<u32> = (0..free.len() as u32).collect();
        let find = |area: &mut [u32], mut v: u32| {
            while area[v as usize] != v {
                area[v as usize] = area[area[v as usize] as usize];
                v = area[v as usize];
            }
            v
        };
        for t in &mesh.triangles {
            let movable: Vec<u32> = t.iter().copied().filter(|&v| free[v as usize]).collect();
            for pair in movable.windows(2) {
                let (a, b) = (find(&mut area, pair[0]), find(&mut area, pair[1]));
                area[a.max(b) as usize] = a.min(b);
            }
        }
        let roots: Vec<u32> = (0..free.len() as u32).map(|v| find(&mut area, v)).collect();
        let first = (0..free.len()).filter(|&v| free[v] && roots[v] == v as u32);
        let area = |root: usize| {
            let own: Vec<bool> = (0..free.len()).map(|v| free[v] && roots[v] == root as u32).collect();
            Area::new(mesh, &own)
        };
        Self(first.map(area).collect())
    }

    /// Settles the free vertices of `places`, given how the mesh at `rest` is stretched at each vertex.
    pub(super) fn settle(
        &self,
        rest: &[DVec2],
        stretches: &[DMat2],
        outline_weight: f64,
        places: &mut [DVec2],
        stage: Stage<'_>,
    ) -> Result<Settled> {
        // Areas do not see one another's free vertices: in any order and on any thread they settle alike.
        let given = &*places;
        let count = self.0.len() as f64;
        let settled: Vec<(SettledArea, Vec<DVec2>)> = self
            .0
            .par_iter()
            .enumerate()
            .map(|(i, area)| {
                let mut own = given.to_vec();
                let part = stage.part(i as f64 / count, (i + 1) as f64 / count);
                let settled = area.settle(rest, stretches, outline_weight, &mut own, part)?;
                Ok((settled, area.free.iter().map(|&v| own[v as usize]).collect()))
            })
            .collect::<Result<_>>()?;
        for (area, (_, own)) in self.0.iter().zip(&settled) {
            area.free.iter().zip(own).for_each(|(&v, p)| places[v as usize] = *p);
        }
        Ok(Settled { areas: settled.into_iter().map(|s| s.0).collect() })
    }
}

impl Area {
    fn new(mesh: &PlaneMesh, free: &[bool]) -> Self {
        let mut number = vec![u32::MAX; free.len()];
        let chosen: Vec<u32> = (0..free.len() as u32).filter(|&v| free[v as usize]).collect();
        for (i, &v) in chosen.iter().enumerate() {
            number[v as usize] = i as u32;
        }
        let any = |group: &[u32]| group.iter().any(|&v| free[v as usize]);
        let edges: Vec<[u32; 2]> = mesh.edges().into_iter().map(|e| e.0).filter(|e| any(e)).collect();
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().copied().filter(|t| any(t)).collect();
        let outline: Vec<[u32; 3]> = mesh
            .rims()
            .iter()
            .flat_map(|rim| {
                let n = rim.len();
                (0..n).map(move |i| [rim[(i + n - 1) % n], rim[i], rim[(i + 1) % n]]).collect::<Vec<_>>()
            })
            .filter(|o| free[o[1] as usize])
            .collect();
        // Two unknowns a vertex: x at even numbers, y at odd ones.
        let doubled = |group: &[u32]| -> Vec<u32> {
            let numbers = group.iter().map(|&v| number[v as usize]).filter(|n| *n != u32::MAX);
            numbers.flat_map(|n| [2 * n, 2 * n + 1]).collect()
        };
        let groups: Vec<Vec<u32>> = triangles.iter().chain(&outline).map(|t| doubled(t)).collect();
        let graph = Graph::of_groups(2 * chosen.len(), groups.iter().filter(|g| !g.is_empty()).map(|g| &g[..]));
        let places: Vec<Vec2> = chosen.iter().flat_map(|&v| [mesh.points[v as usize]; 2]).collect();
        let symbolic = Symbolic::new(&graph, &places);
        let area: f64 = (0..mesh.triangles.len()).map(|t| mesh.area(t)).sum();
        Self { free: chosen, number, edges, triangles, outline, graph, symbolic, orientation: area.signum() }
    }

    fn settle(
        &self,
        rest: &[DVec2],
        stretches: &[DMat2],
        outline_weight: f64,
        places: &mut [DVec2],
        stage: Stage<'_>,
    ) -> Result<SettledArea> {
        let wished = Wished::new(self, rest, stretches, outline_weight);
        let mut settled = SettledArea::default();
        let mut energy = self.energy(&wished, places);
        settled.energies.push(energy);
        let mean = wished.lengths.iter().sum::<f64>() / wished.lengths.len().max(1) as f64;
        if energy < UNBENT * mean * mean {
            return Ok(settled);
        }
        let mut damping = 1e-3;
        while settled.iterations < STEPS {
            stage.at(settled.iterations as f64 / STEPS as f64)?;
            let system = self.assemble(&wished, places);
            let mut next = None;
            while settled.iterations < STEPS {
                settled.iterations += 1;
                let Some(step) = self.step(&system, damping) else {
                    damping *= 10.0;
                    continue;
                };
                let mut trial = places.to_vec();
                self.free.iter().zip(&step).for_each(|(&v, d)| trial[v as usize] += *d);
                let lower = self.energy(&wished, &trial);
                if lower < energy {
                    let longest = step.iter().map(|d| d.length()).fold(0.0, f64::max);
                    next = Some((trial, lower, longest));
                    damping = (damping / 5.0).max(1e-6);
                    break;
                }
                damping *= 10.0;
                if damping > 1e6 {
                    break;
                }
            }
            let Some((trial, lower, longest)) = next else { break };
            places.copy_from_slice(&trial);
            let drop = energy - lower;
            energy = lower;
            settled.energies.push(energy);
            let turned = self.flipped(places);
            if turned == 0 && (drop < SETTLED * energy || longest < STILL * mean) {
                break;
            }
        }
        settled.flipped = self.flipped(places);
        Ok(settled)
    }

    fn flipped(&self, places: &[DVec2]) -> usize {
        self.triangles.iter().filter(|t| self.area(t, places) <= 0.0).count()
    }

    fn area(&self, t: &[u32; 3], places: &[DVec2]) -> f64 {
        let [a, b, c] = t.map(|v| places[v as usize]);
        0.5 * self.orientation * (b - a).perp_dot(c - a)
    }

    /// Calls `visit` with every residual and its slope.
    fn residuals(&self, wished: &Wished, places: &[DVec2], mut visit: impl FnMut(f64, Slope)) {
        let root = wished.edge_weight.sqrt();
        for (&[a, b], length) in self.edges.iter().zip(&wished.lengths) {
            let way = places[b as usize] - places[a as usize];
            let now = way.length();
            let along = if now > 0.0 { way / now } else { DVec2::X };
            visit(root * (now - length), [(b, root * along), (a, -root * along), (a, DVec2::ZERO)]);
        }
        for (&[a, b, c], (z, size)) in self.outline.iter().zip(&wished.outline) {
            let chord = places[c as usize] - places[a as usize];
            let square = chord.length_squared();
            // Neighbours on one spot have no frame; the edges part them again.
            if square < 1e-4 * size * size {
                continue;
            }
            let over = DVec2::new(chord.x, -chord.y) / square;
            let now = (places[b as usize] - places[a as usize]).rotate(over);
            let weight = wished.outline_weight.sqrt() * size;
            let gap = now - *z;
            // Derivatives as complex numbers; a number p + iq acts as the matrix [p -q; q p].
            let slopes = [(now - DVec2::X).rotate(over), over, -now.rotate(over)].map(|d| d * weight);
            visit(weight * gap.x, [(a, slope_x(slopes[0])), (b, slope_x(slopes[1])), (c, slope_x(slopes[2]))]);
            visit(weight * gap.y, [(a, slope_y(slopes[0])), (b, slope_y(slopes[1])), (c, slope_y(slopes[2]))]);
        }
        for (t, area) in self.triangles.iter().zip(&wished.areas) {
            let now = self.area(t, places);
            let [a, b, c] = t.map(|v| places[v as usize]);
            // In lengths, as the other residuals are.
            let scale = 1.0 / area.sqrt();
            let half = 0.5 * self.orientation * scale;
            let slope = [b - c, c - a, a - b].map(|e| DVec2::new(e.y, -e.x) * half);
            let with = |weight: f64| [0, 1, 2].map(|i| (t[i], slope[i] * weight));
            let root = AREA.sqrt();
            visit(root * (now - area) * scale, with(root));
            if now < THIN * area {
                let root = PUSH.sqrt();
                visit(root * (now - THIN * area) * scale, with(root));
            }
        }
    }

    fn energy(&self, wished: &Wished, places: &[DVec2]) -> f64 {
        let mut sum = 0.0;
        self.residuals(wished, places, |r, _| sum += r * r);
        sum
    }

    fn assemble(&self, wished: &Wished, places: &[DVec2]) -> System {
        let n = self.graph.len();
        let mut system = System { diagonal: vec![0.0; n], off: vec![0.0; self.graph.entries()], right: vec![0.0; n] };
        self.residuals(wished, places, |r, slope| {
            let parts = || {
                let free = slope.iter().filter(|(v, _)| self.number[*v as usize] != u32::MAX);
                free.flat_map(|(v, s)| {
                    let i = 2 * self.number[*v as usize];
                    [(i, s.x), (i + 1, s.y)]
                })
            };
            for (i, s) in parts() {
                system.right[i as usize] -= s * r;
                for (j, q) in parts() {
                    if i == j {
                        system.diagonal[i as usize] += s * q;
                    } else if let Some(entry) = self.graph.entry(i as usize, j) {
                        system.off[entry] += s * q;
                    }
                }
            }
        });
        system
    }

    /// The damped step of every free vertex; `None` when the system is too flat.
    fn step(&self, system: &System, damping: f64) -> Option<Vec<DVec2>> {
        let largest = system.diagonal.iter().copied().fold(0.0, f64::max);
        let diagonal: Vec<f64> = system.diagonal.iter().map(|d| d * (1.0 + damping) + 1e-9 * largest).collect();
        let mut factor = self.symbolic.factor(&self.graph, &diagonal, &system.off)?;
        let mut u = vec![Vec2::ZERO; self.graph.len()];
        for (i, &v) in self.symbolic.order().iter().enumerate() {
            u[i].x = system.right[v as usize] as f32;
        }
        factor.solve(&self.symbolic, &mut u);
        let place = self.symbolic.place();
        let value = |i: usize| f64::from(u[place[i] as usize].x);
        Some((0..self.free.len()).map(|i| DVec2::new(value(2 * i), value(2 * i + 1))).collect())
    }
}

fn slope_x(d: DVec2) -> DVec2 {
    DVec2::new(d.x, -d.y)
}

fn slope_y(d: DVec2) -> DVec2 {
    DVec2::new(d.y, d.x)
}

struct System {
    diagonal: Vec<f64>,
    off: Vec<f64>,
    right: Vec<f64>,
}

/// What the stretched rest shape has.
struct Wished {
    edge_weight: f64,
    outline_weight: f64,
    lengths: Vec<f64>,
    /// `z` of each vertex of the outline, and the way between its neighbours.
    outline: Vec<(DVec2, f64)>,
    areas: Vec<f64>,
}

impl Wished {
    fn new(own: &Area, rest: &[DVec2], stretches: &[DMat2], outline_weight: f64) -> Self {
        let way = |a: u32, b: u32| {
            let (a, b) = (a as usize, b as usize);
            (stretches[a] + stretches[b]) * 0.5 * (rest[b] - rest[a])
        };
        let outline = own.outline.iter().map(|&[a, b, c]| {
            let (to_b, to_c) = (way(a, b), way(a, b) + way(b, c));
            let square = to_c.length_squared().max(1e-12);
            (to_b.rotate(DVec2::new(to_c.x, -to_c.y)) / square, to_c.length().max(1e-6))
        });
        let area = |t: &[u32; 3]| {
            let mean = t.iter().map(|&v| stretches[v as usize].determinant()).sum::<f64>() / 3.0;
            (own.area(t, rest) * mean).max(1e-9)
        };
        Self {
            edge_weight: 1.0 - outline_weight,
            outline_weight,
            lengths: own.edges.iter().map(|&[a, b]| way(a, b).length()).collect(),
            outline: outline.collect(),
            areas: own.triangles.iter().map(area).collect(),
        }
    }
}
