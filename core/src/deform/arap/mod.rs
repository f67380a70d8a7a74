//! As-rigid-as-possible deformation of a plane mesh by points and bones.
//!
//! Energy of Chao et al. 2010 (the "elements" energy of Liu et al. 2008), lowered by local and global steps (Sorkine
//! and Alexa 2007) that `anderson` accelerates. Where the handles jump, `clusters` first says how far whole parts
//! turn, so that ten steps from the rest shape end within a tenth of the least energy where plain steps end at up to
//! four times it. One factor serves every step, and steps work on residuals, so that a factor of 32 bits does.
//!
//! Known limits: a part of the mesh without any handle stays where it is; the energy does not see that limbs overlap.

mod anchors;
mod anderson;
mod clusters;
mod elements;
#[cfg(test)]
mod tests;
mod unfold;

use std::sync::Arc;

use glam::Vec2;

use super::sparse::{Factor, Graph, Symbolic};
use super::{Deformation, Deformer, Handle, RestMesh};
use crate::error::{Error, Result};
use crate::job::Stage;
use anchors::Anchors;
use anderson::Anderson;
use clusters::Clusters;
use elements::{Elements, Measure};
use unfold::Stars;

/// The built-in as-rigid-as-possible deformer.
#[derive(Clone, Copy, Debug)]
pub struct ArapDeformer {
    /// Local and global steps of one solve, at least 1.
    pub iterations: usize,
}

impl Default for ArapDeformer {
    /// 10 steps: within a tenth of the least energy on every measured pose.
    fn default() -> Self {
        Self { iterations: 10 }
    }
}

impl Deformer for ArapDeformer {
    fn bind(&self, mesh: RestMesh<'_>, handles: &[Handle], stage: Stage<'_>) -> Result<Box<dyn Deformation>> {
        ArapMesh::new(mesh, stage.part(0.0, 0.5))?.bind(self, handles, stage.part(0.5, 1.0))
    }
}

/// A mesh made ready for any handles: what [`ArapDeformer`] works out before it looks at them. Keep it where handles
/// come and go on one mesh. Clones share it.
#[derive(Clone, Debug)]
pub struct ArapMesh(Arc<Prepared>);

/// How stiffly a handle between vertices holds its triangle, against the mesh's own stiffness: a thousandth of the
/// mesh's give, which the last touch takes out, and few enough digits for a factor of 32 bits.
const GRIP: f64 = 1e3;
/// Clusters at most, and vertices of one at least: with 48 the worst measured pose ends at 1.13 times the least energy,
/// with 96 and more within 1.1, and their set-up shows from 200 on.
const CLUSTERS: usize = 128;
const CLUSTER_VERTICES: usize = 24;

/// Vertices are kept in the order of elimination, shifted and scaled so that the mean edge is 1 long.
#[derive(Debug)]
struct Prepared {
    centre: Vec2,
    scale: f32,
    orientation: f32,
    graph: Graph,
    symbolic: Symbolic,
    points: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    elements: Elements,
    /// The Laplacian: the diagonal, and the entries of the graph, in the mesh's own numbering.
    diagonal: Vec<f64>,
    off: Vec<f64>,
}

impl ArapMesh {
    /// Makes `mesh` ready.
    ///
    /// # Errors
    /// No triangle with an area, triangles turned both ways, an index without its vertex, a number that is not finite.
    pub fn new(mesh: RestMesh<'_>, stage: Stage<'_>) -> Result<Self> {
        stage.at(0.0)?;
        let Checked { triangles, orientation, edge } = check(mesh)?;
        let n = mesh.points.len();
        let centre = mesh.points.iter().fold(glam::DVec2::ZERO, |s, p| s + p.as_dvec2() / n as f64).as_vec2();
        let scale = 1.0 / edge;
        let graph = Graph::of_groups(n, triangles.iter().map(|t| &t[..]));
        stage.at(0.2)?;
        let symbolic = Symbolic::new(&graph, mesh.points);
        stage.at(0.8)?;
        let points: Vec<Vec2> = symbolic.order().iter().map(|&v| (mesh.points[v as usize] - centre) * scale).collect();
        let mut placed: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| symbolic.place()[v as usize])).collect();
        // Triangles that lie near one another work on the same vertices: the order of elimination keeps them so.
        placed.sort_unstable_by_key(|t| *t.iter().min().unwrap_or(&0));
        let elements = Elements::new(&points, &placed, orientation);
        let (mut diagonal, mut off) = (vec![0.0; n], vec![0.0; graph.entries()]);
        for (t, triangle) in placed.iter().enumerate() {
            let (double_area, q) = elements.rest_of(t);
            let scale = 2.0 / f64::from(double_area);
            let corners = triangle.map(|v| symbolic.order()[v as usize]);
            let q = q.map(|q| q.as_dvec2());
            add_element(&graph, corners, |i, j| q[i].dot(q[j]) * scale, &mut diagonal, &mut off);
        }
        stage.at(1.0)?;
        Ok(Self(Arc::new(Prepared {
            centre,
            scale,
            orientation,
            graph,
            symbolic,
            points,
            triangles: placed,
            elements,
            diagonal,
            off,
        })))
    }

    /// Binds the mesh to handles, as [`Deformer::bind`] does.
    ///
    /// # Errors
    /// A handle off the mesh or with a number that is not finite.
    pub fn bind(&self, deformer: &ArapDeformer, handles: &[Handle], stage: Stage<'_>) -> Result<Box<dyn Deformation>> {
        stage.at(0.0)?;
        let mesh = &*self.0;
        let n = mesh.points.len();
        let handles: Vec<Handle> = handles.iter().map(|h| h.map(|p| (p - mesh.centre) * mesh.scale)).collect();
        let mut anchors = Anchors::new(&mesh.points, &mesh.triangles, &handles)?;
        let (diagonal, off) = mesh.matrix(&mut anchors);
        stage.at(0.2)?;
        let factor = mesh.symbolic.factor(&mesh.graph, &diagonal, &off).ok_or_else(|| {
            Error::invalid("mesh", "its triangles are too thin to deform", "use a mesh without slivers")
        })?;
        stage.at(0.7)?;
        let size = n.div_ceil(CLUSTERS).max(CLUSTER_VERTICES);
        let clusters = Clusters::new(&mesh.elements, &mesh.triangles, anchors.held(), &mesh.symbolic, &factor, size);
        stage.at(1.0)?;
        Ok(Box::new(Arap {
            iterations: deformer.iterations.max(1),
            mesh: Arc::clone(&self.0),
            factor,
            clusters,
            anchors,
            anderson: Anderson::new(n),
            last: None,
            stars: None,
            u: vec![Vec2::ZERO; n],
            work: vec![Vec2::ZERO; n],
            turns: mesh.elements.room(),
        }))
    }
}

impl Prepared {
    /// The Laplacian with what the anchors hold, in the mesh's numbering.
    fn matrix(&self, anchors: &mut Anchors) -> (Vec<f64>, Vec<f64>) {
        let (mut diagonal, mut off) = (self.diagonal.clone(), self.off.clone());
        let order = self.symbolic.order();
        for (triangle, weights) in anchors.grips() {
            let corners = triangle.map(|v| order[v as usize]);
            let w = weights.map(f64::from);
            add_element(&self.graph, corners, |i, j| GRIP * w[i] * w[j], &mut diagonal, &mut off);
        }
        for held in anchors.fixed().to_vec() {
            let v = order[held as usize] as usize;
            diagonal[v] = 1.0;
            for entry in self.graph.range(v) {
                off[entry] = 0.0;
            }
            for &u in self.graph.of(v) {
                let place = self.symbolic.place()[u as usize];
                if let Some(entry) = self.graph.entry(u as usize, v as u32) {
                    if !anchors.held()[place as usize] {
                        anchors.couple(place, held, off[entry]);
                    }
                    off[entry] = 0.0;
                }
            }
        }
        (diagonal, off)
    }
}

/// Adds what one triangle gives to the matrix entries of its corners.
fn add_element(
    graph: &Graph,
    corners: [u32; 3],
    value: impl Fn(usize, usize) -> f64,
    diagonal: &mut [f64],
    off: &mut [f64],
) {
    for i in 0..3 {
        diagonal[corners[i] as usize] += value(i, i);
        for j in (0..3).filter(|&j| j != i) {
            if let Some(entry) = graph.entry(corners[i] as usize, corners[j]) {
                off[entry] += value(i, j);
            }
        }
    }
}

/// A mesh bound to its handles.
struct Arap {
    iterations: usize,
    mesh: Arc<Prepared>,
    factor: Factor,
    clusters: Option<Clusters>,
    anchors: Anchors,
    anderson: Anderson,
    /// The clusters' rotations, and the targets they are for.
    last: Option<(Vec<Vec2>, Vec<[f64; 2]>)>,
    /// Made when triangles first need to be turned back.
    stars: Option<Stars>,
    u: Vec<Vec2>,
    work: Vec<Vec2>,
    turns: Vec<Vec2>,
}

impl Arap {
    /// The clusters' rotations for `targets`, kept for the next call.
    fn rotations(&mut self, targets: &[Vec2]) -> Option<Vec<[f64; 2]>> {
        let clusters = self.clusters.as_ref()?;
        if let Some((at, rotations)) = &self.last
            && at == targets
        {
            return Some(rotations.clone());
        }
        self.work.fill(Vec2::ZERO);
        self.anchors.pull(targets, &mut self.work);
        self.factor.solve(&self.mesh.symbolic, &mut self.work);
        self.anchors.place(targets, &mut self.work);
        self.mesh.elements.turns(&self.work, &mut self.turns);
        let rotations = clusters.rotations(&self.turns);
        self.last = Some((targets.to_vec(), rotations.clone()));
        Some(rotations)
    }

    /// The first step: what turned since the shape `self.u`, cluster by cluster, and then everything in its place.
    fn jump(&mut self, targets: &[Vec2]) {
        let now = self.anchors.at(&self.u);
        let before = if self.anchors.at_rest(&now) {
            self.clusters.as_ref().map(|c| vec![[1.0, 0.0]; c.len()])
        } else {
            self.rotations(&now)
        };
        let after = self.rotations(targets);
        self.mesh.elements.turns(&self.u, &mut self.turns);
        if let (Some(clusters), Some(before), Some(after)) = (&self.clusters, before, after) {
            let turned: Vec<Vec2> = before
                .iter()
                .zip(&after)
                .map(|(b, a)| glam::dvec2(a[0] * b[0] + a[1] * b[1], a[1] * b[0] - a[0] * b[1]).as_vec2())
                .collect();
            for (t, &cluster) in clusters.of().iter().enumerate() {
                self.turns[t] = turned[cluster as usize].rotate(self.turns[t]);
            }
        }
        self.u.fill(Vec2::ZERO);
        self.anchors.pull(targets, &mut self.u);
        self.mesh.elements.pulls(&self.turns, &mut self.u);
        self.anchors.clear(&mut self.u);
        self.factor.solve(&self.mesh.symbolic, &mut self.u);
        self.anchors.place(targets, &mut self.u);
    }

    fn measure(&mut self, targets: &[Vec2]) -> Measure {
        let mut measure = self.mesh.elements.gradient(&self.u, &mut self.work);
        measure.energy += self.anchors.gradient(targets, &self.u, &mut self.work);
        measure
    }

    fn lower(&mut self, targets: &[Vec2], stage: Stage<'_>) -> Result<Measure> {
        self.jump(targets);
        self.anderson.forget();
        let mut best = f64::INFINITY;
        for k in 1..=self.iterations {
            stage.at(k as f64 / (self.iterations + 1) as f64)?;
            let mut measure = self.measure(targets);
            if measure.energy > best {
                // The combination was worse than what it combined: the plain step never is.
                self.u.copy_from_slice(self.anderson.plain());
                self.anderson.forget();
                measure = self.measure(targets);
            }
            best = measure.energy;
            if k == self.iterations {
                return Ok(measure);
            }
            self.anchors.clear(&mut self.work);
            self.factor.solve(&self.mesh.symbolic, &mut self.work);
            self.work.iter_mut().for_each(|v| *v = -*v);
            self.anderson.advance(&mut self.u, &self.work);
        }
        Ok(Measure::default())
    }
}

impl Deformation for Arap {
    fn solve(&mut self, targets: &[Handle], points: &mut [Vec2], stage: Stage<'_>) -> Result<()> {
        let (centre, scale) = (self.mesh.centre, self.mesh.scale);
        let targets = self.anchors.targets(targets, |p| (p - centre) * scale)?;
        if points.len() != self.u.len() || points.iter().any(|p| !p.is_finite()) {
            let problem = format!("{} finite ones were expected", self.u.len());
            return Err(Error::invalid("points of the mesh", problem, "pass the shape of the mesh that was bound"));
        }
        for (i, &v) in self.mesh.symbolic.order().iter().enumerate() {
            self.u[i] = (points[v as usize] - centre) * scale;
        }
        let measure = self.lower(&targets, stage)?;
        let anchors = &self.anchors;
        anchors.touch(&targets, &mut self.u);
        if measure.flipped > 0 || anchors.grips().len() > 0 {
            let mesh = &*self.mesh;
            let stars = self.stars.get_or_insert_with(|| Stars::new(mesh.points.len(), &mesh.triangles));
            let (elements, triangles, orientation) = (&mesh.elements, &mesh.triangles[..], mesh.orientation);
            let (rest, held) = (&mesh.points[..], anchors.held());
            let mesh = unfold::Mesh { elements, triangles, stars, rest, held, orientation };
            mesh.unfold(&mut self.u, |u| anchors.touch(&targets, u));
        }
        for (i, &v) in self.mesh.symbolic.order().iter().enumerate() {
            points[v as usize] = self.u[i] / scale + centre;
        }
        Ok(())
    }
}

pub(super) struct Checked {
    pub(super) triangles: Vec<[u32; 3]>,
    /// 1 where triangles turn from x to y, else -1.
    orientation: f32,
    /// The mean edge's length.
    pub(super) edge: f32,
}

/// The triangles that have an area.
pub(super) fn check(mesh: RestMesh<'_>) -> Result<Checked> {
    let bad = |i: usize, problem: String, remedy: &str| Err(Error::invalid(format!("triangle {i}"), problem, remedy));
    if let Some(i) = mesh.points.iter().position(|p| !p.is_finite()) {
        return Err(Error::invalid(format!("vertex {i} of the mesh"), "is not a number", "give finite places"));
    }
    if let Some((i, t)) =
        mesh.triangles.iter().enumerate().find(|(_, t)| t.iter().any(|&v| v as usize >= mesh.points.len()))
    {
        return bad(i, format!("names a vertex of {t:?}, and there are {}", mesh.points.len()), "check the mesh");
    }
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.points[v as usize].as_dvec2());
        (b - a).perp_dot(c - a)
    };
    let (mut length, mut total, mut signed) = (0.0, 0.0, 0.0);
    for t in mesh.triangles {
        let [a, b, c] = t.map(|v| mesh.points[v as usize]);
        length += f64::from(a.distance(b) + b.distance(c) + c.distance(a));
        total += area(t).abs();
        signed += area(t);
    }
    if total.is_nan() || total <= 0.0 || !total.is_finite() {
        return Err(Error::invalid("mesh", "has no triangle with an area", "give at least one"));
    }
    let orientation = f64::signum(signed);
    // Below this a triangle's own area drowns in the rounding of its vertices.
    let least = 1e-7 * total / mesh.triangles.len() as f64;
    if let Some(i) = mesh.triangles.iter().position(|t| area(t) * orientation < -least) {
        return bad(i, "is turned the other way than most".into(), "turn all triangles the same way");
    }
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().copied().filter(|t| area(t) * orientation > least).collect();
    Ok(Checked {
        triangles,
        orientation: orientation as f32,
        edge: (length / (3 * mesh.triangles.len()) as f64) as f32,
    })
}
