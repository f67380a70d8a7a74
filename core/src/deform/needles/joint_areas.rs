//! Stage two: the shape of the areas where bones meet.
//!
//! Each is solved for on its own: from the start that `fill` makes, down the `energy`, by `descent`. On a drag an area whose
//! bones keep their places to one another only moves along, and the others start from their last shape.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::blend::{Blend, Placed, Posed};
use super::descent::{Descent, System};
use super::energy::{Terms, Wished};
use super::fill::Fill;
use crate::deform::sparse::{Fronts, Graph};
use crate::error::Result;
use crate::geometry::PlaneMesh;
use crate::job::Stage;

/// From one frame to the next of a drag bones turn by less than this against one another, and stretch by less than this
/// share. With steps of 50 degrees a limb that straightens stays creased.
const TURN: f64 = 0.35;
const STRETCH: f64 = 0.2;

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
    /// The energy at the start and after each step that was taken: never rising. None of an area that moved along.
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
    /// The free vertices in the order of elimination, then those that hold them.
    vertices: Vec<u32>,
    free: usize,
    rest: Vec<DVec2>,
    /// The bones that any of them follows.
    bones: Vec<u32>,
    terms: Terms,
    fronts: Fronts,
    fill: Option<Fill>,
    wished: Wished,
    descent: Descent,
    /// What the last solve started from: the bones, and stage one.
    posed: Vec<Posed>,
    placed: Vec<Placed>,
    /// Where it ended.
    solved: Vec<DVec2>,
    /// Where the free vertices are.
    places: Vec<DVec2>,
}

impl JointAreas {
    pub(super) fn new(mesh: &PlaneMesh, free: &[bool], blend: &Blend) -> Self {
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
        let (edges, rims) = (mesh.edges(), mesh.rims());
        let area = |root: usize| {
            let own: Vec<bool> = (0..free.len()).map(|v| free[v] && roots[v] == root as u32).collect();
            Area::new(mesh, &edges, &rims, &own, blend)
        };
        Self(first.map(area).collect())
    }

    /// Settles the areas, going on from the last time when `warm`.
    pub(super) fn settle(
        &mut self,
        blend: &Blend,
        posed: &[Posed],
        outline_weight: f64,
        warm: bool,
        stage: Stage<'_>,
    ) -> Result<Settled> {
        // Areas do not see one another's free vertices: in any order and on any thread they settle alike.
        let count = self.0.len() as f64;
        let settle = |(i, area): (usize, &mut Area)| {
            let part = stage.part(i as f64 / count, (i + 1) as f64 / count);
            area.settle(blend, posed, outline_weight, warm, part)
        };
        let areas = self.0.par_iter_mut().enumerate().map(settle).collect::<Result<_>>()?;
        Ok(Settled { areas })
    }

    /// Every free vertex and where it is.
    pub(super) fn each(&self, mut visit: impl FnMut(u32, DVec2)) {
        self.0.iter().for_each(|a| a.vertices.iter().zip(&a.places).for_each(|(&v, p)| visit(v, *p)));
    }
}

impl Area {
    fn new(mesh: &PlaneMesh, edges: &[([u32; 2], u32)], rims: &[Vec<u32>], free: &[bool], blend: &Blend) -> Self {
        let any = |group: &[u32]| group.iter().any(|&v| free[v as usize]);
        let orientation = (0..mesh.triangles.len()).map(|t| mesh.area(t)).sum::<f64>();
        let edges: Vec<[u32; 2]> = edges.iter().map(|e| e.0).filter(|e| any(e)).collect();
        let triangles = mesh.triangles.iter().filter(|t| any(&t[..]));
        let triangles: Vec<[u32; 3]> =
            triangles.map(|&[a, b, c]| if orientation < 0.0 { [a, c, b] } else { [a, b, c] }).collect();
        let outline: Vec<[u32; 3]> = rims
            .iter()
            .flat_map(|rim| {
                let n = rim.len();
                (0..n).map(move |i| [rim[(i + n - 1) % n], rim[i], rim[(i + 1) % n]]).collect::<Vec<_>>()
            })
            .filter(|o| free[o[1] as usize])
            .collect();

        const NONE: u32 = u32::MAX;
        let chosen: Vec<u32> = (0..free.len() as u32).filter(|&v| free[v as usize]).collect();
        let mut number = vec![NONE; free.len()];
        chosen.iter().enumerate().for_each(|(i, &v)| number[v as usize] = i as u32);
        let graph_of = |groups: &[&[[u32; 3]]], number: &[u32]| {
            let groups: Vec<Vec<u32>> = groups
                .iter()
                .flat_map(|g| g.iter())
                .map(|t| t.iter().map(|&v| number[v as usize]).filter(|n| (*n as usize) < chosen.len()).collect())
                .collect();
            Graph::of_groups(chosen.len(), groups.iter().map(|g: &Vec<u32>| &g[..]))
        };
        let points: Vec<Vec2> = chosen.iter().map(|&v| mesh.points[v as usize]).collect();
        let (fronts, order) = Fronts::new(&graph_of(&[&triangles, &outline], &number), &points);
        let mut vertices: Vec<u32> = order.iter().map(|&i| chosen[i as usize]).collect();
        vertices.iter().enumerate().for_each(|(i, &v)| number[v as usize] = i as u32);
        for &v in triangles.iter().chain(&outline).flatten() {
            if number[v as usize] == NONE {
                number[v as usize] = vertices.len() as u32;
                vertices.push(v);
            }
        }
        let graph = graph_of(&[&triangles], &number);
        let inside = |t: [u32; 3]| t.map(|v| number[v as usize]);
        let triangles: Vec<[u32; 3]> = triangles.into_iter().map(inside).collect();
        let outline = outline.into_iter().map(inside).collect();
        let edges = edges.into_iter().map(|e| e.map(|v| number[v as usize])).collect();
        let rest: Vec<DVec2> = vertices.iter().map(|&v| mesh.points[v as usize].as_dvec2()).collect();
        let fill = Fill::new(&graph, &rest, &triangles);
        let terms = Terms::new(chosen.len(), &fronts, edges, triangles, outline);
        let mut bones: Vec<u32> = vertices.iter().flat_map(|&v| blend.bones_of(v)).collect();
        bones.sort_unstable();
        bones.dedup();
        let free = chosen.len();
        Self {
            descent: Descent::new(&fronts, vertices.len(), free),
            vertices,
            free,
            rest,
            bones,
            terms,
            fronts,
            fill,
            wished: Wished::default(),
            posed: Vec::new(),
            placed: Vec::new(),
            solved: Vec::new(),
            places: Vec::new(),
        }
    }

    fn settle(
        &mut self,
        blend: &Blend,
        posed: &[Posed],
        outline_weight: f64,
        warm: bool,
        stage: Stage<'_>,
    ) -> Result<SettledArea> {
        let now: Vec<Posed> = self.bones.iter().map(|&b| posed[b as usize]).collect();
        if warm && let Some((turn, shift)) = moved_as_one(&self.posed, &now, 1e-3 * self.wished.mean) {
            self.places.clear();
            self.places.extend(self.solved[..self.free].iter().map(|p| turn.rotate(*p) + shift));
            return Ok(SettledArea { flipped: self.terms.turned(&self.solved), ..SettledArea::default() });
        }
        let near = warm && is_near(&self.posed, &now);
        self.posed = now;
        let placed = self.vertices.iter().map(|&v| blend.place(v as usize, posed)).collect();
        let before = std::mem::replace(&mut self.placed, placed);
        self.wished.measure(&self.terms, &self.rest, &self.placed, outline_weight);
        let stage_one = || self.placed.iter().map(|p| p.at).collect::<Vec<_>>();
        let mut places = stage_one();
        let mut sound = false;
        if near && let Some(fill) = &mut self.fill {
            places[..self.free].copy_from_slice(&self.solved[..self.free]);
            fill.carry(&self.rest, &self.terms.triangles, [&before, &self.placed], &self.solved, &mut places);
            sound = self.terms.turned(&places) == 0;
        }
        let system = System { terms: &self.terms, wished: &self.wished, fronts: &self.fronts, free: self.free };
        if !sound {
            places = stage_one();
            // An area that only moved stays as stage one has it, to the bit.
            if system.energy(&places) >= system.unbent()
                && let Some(fill) = &mut self.fill
            {
                fill.fill(&self.rest, &self.terms.triangles, &self.placed, &mut places);
            }
        }
        let settled = self.descent.run(&system, &self.placed, !sound, &mut places, stage)?;
        self.places.clear();
        self.places.extend_from_slice(&places[..self.free]);
        self.solved = places;
        Ok(settled)
    }
}

/// Whether the bones turned and stretched little enough against one another to go on from the last shape.
fn is_near(from: &[Posed], to: &[Posed]) -> bool {
    let turns = || from.iter().zip(to).map(|(a, b)| b.turn - a.turn);
    let range = turns().fold((f64::MAX, f64::MIN), |r, t| (r.0.min(t), r.1.max(t)));
    let stretched = |(a, b): (&Posed, &Posed)| (b.along / a.along).ln().abs() < STRETCH;
    from.len() == to.len() && range.1 - range.0 < TURN && from.iter().zip(to).all(stretched)
}

/// The turn and shift that brings all bones from where they were to where they are, if one does within `give`.
fn moved_as_one(from: &[Posed], to: &[Posed], give: f64) -> Option<(DVec2, DVec2)> {
    let (old, new) = (from.first()?, to.first()?);
    let turn = DVec2::from_angle(new.turn - old.turn);
    let shift = new.root - turn.rotate(old.root);
    let same = |a: DVec2, b: DVec2| (turn.rotate(a) + shift).distance_squared(b) <= give * give;
    let all = from.len() == to.len()
        && from.iter().zip(to).all(|(a, b)| {
            same(a.root, b.root) && same(a.tip, b.tip) && (b.turn - a.turn - (new.turn - old.turn)).abs() < 1.0
        });
    all.then_some((turn, shift))
}
