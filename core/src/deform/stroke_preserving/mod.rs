//! Deformation of a drawing that keeps its lines' shapes: as rigid as possible, with stiffer bands along the lines.
//!
//! After Su et al. 2018, "Live Sketch", section "Motion Transfer". There, points of lines hang on the mesh by weak links, and
//! local and global steps take the longer the stiffer a line is: more than 3,000 at a weight of 100. Here lines are part
//! of the mesh (`lines`), so that what is drawn side by side stays so, and Newton's method (`descent`) lowers the energy
//! (`terms`) in about as many steps at any rigidity.
//!
//! Known limits: the energy does not see that limbs overlap; details finer than the mesh move with their triangles.

mod descent;
pub(crate) mod embedding;
mod lines;
mod terms;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::{DVec2, Vec2};

use super::sparse::{Fronts, Graph};
use super::{RestMesh, arap};
use crate::error::{Error, Result};
use crate::job::Stage;
use descent::Descent;
pub use descent::{Effort, Settled};
use embedding::Finder;
use terms::{Pins, Sum, Terms};

/// A line that keeps its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its points, in the coordinates of its layer.
    pub points: Vec<Vec2>,
    /// Whether the last point is followed by the first.
    pub closed: bool,
    /// How stiff it is, 0..=1000: 1 is a drawn line's usual stiffness, 0 follows the mesh (beside stiffer lines with a
    /// little stiffness of its own, so that those do not distort it).
    pub rigidity: f32,
}

/// One layer: its mesh and the lines on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Vertices.
    pub points: Vec<Vec2>,
    /// Vertex indices, three a triangle, all turned the same way.
    pub triangles: Vec<[u32; 3]>,
    /// Its lines. Points outside the mesh hang on the nearest triangle.
    pub lines: Vec<Line>,
}

/// Two layers hold each other here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tie {
    /// The layers.
    pub layers: [usize; 2],
    /// Where, at rest.
    pub at: Vec2,
}

/// The shape of all layers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Layer, vertex.
    pub points: Vec<Vec<Vec2>>,
    /// Layer, line, point.
    pub lines: Vec<Vec<Vec<Vec2>>>,
}

/// The largest rigidity of a line.
pub const MOST_RIGID: f32 = 1000.0;
/// What a handle weighs against the mesh: more than the stiffest line. What it still gives way is taken out at the end.
const PIN: f64 = 1e6;
/// Handles so near to one another, in mean edges, hold one spot: nearer ones that part would tear the triangle that they
/// share into something tens of times as large.
const ONE_SPOT: f64 = 0.5;
/// So that what stiff lines push aside does not distort the others, lines that only follow have this share of the highest
/// rigidity, counted up to 1.
const FOLLOWS: f64 = 0.03;
/// A handle or tie is extrapolated so many mean edges beyond its mesh, a handle farther out moves along.
const OUTSIDE: f64 = 1.0;

/// Layers made ready for any handles.
#[derive(Clone, Debug)]
pub struct StrokeMesh {
    prepared: Arc<Prepared>,
    rigidity: Vec<f64>,
}

/// Vertices of all layers are kept in the order of elimination, shifted and scaled so that the mean edge is 1 long.
#[derive(Debug)]
struct Prepared {
    centre: DVec2,
    scale: f64,
    layers: Vec<PreparedLayer>,
    /// The place of each vertex of each layer.
    place: Vec<u32>,
    rest: Vec<DVec2>,
    fronts: Fronts,
    terms: Terms,
    /// What hangs together: the part of each vertex.
    part: Vec<u32>,
}

#[derive(Debug)]
struct PreparedLayer {
    first: usize,
    count: usize,
    rest: Vec<DVec2>,
    triangles: Vec<[u32; 3]>,
    finder: Finder,
    /// Number of its first line among all lines.
    first_line: usize,
    /// Where the points of each line hang.
    lines: Vec<Vec<Sum>>,
}

impl Prepared {
    fn inner(&self, p: Vec2) -> DVec2 {
        (p.as_dvec2() - self.centre) * self.scale
    }

    fn outer(&self, p: DVec2) -> Vec2 {
        (p / self.scale + self.centre).as_vec2()
    }
}

impl PreparedLayer {
    /// Where `p` hangs, with what `index` makes of the layer's vertices, and the place.
    fn hang(&self, p: DVec2, reach: f64, index: impl Fn(u32) -> u32) -> (Sum, DVec2) {
        let (t, near) = self.finder.find(&self.rest, &self.triangles, p);
        let p = near + (p - near).clamp_length_max(reach);
        let corners = self.triangles[t];
        let weights = embedding::weights(corners.map(|v| self.rest[v as usize]), p);
        (Sum::place(corners.map(index), weights), p)
    }
}

fn rigid(what: String, value: f32) -> Result<f64> {
    if (0.0..=MOST_RIGID).contains(&value) {
        return Ok(f64::from(value));
    }
    Err(Error::invalid(what, format!("has the rigidity {value}"), "give one in 0..=1000"))
}

impl StrokeMesh {
    /// Makes `layers` ready.
    ///
    /// # Errors
    /// No layers; a layer without triangles that have an area, with triangles turned both ways, or an index without its
    /// vertex; a number that is not finite, a rigidity out of range, a tie of layers that are not there.
    pub fn new(layers: &[Layer], ties: &[Tie], stage: Stage<'_>) -> Result<Self> {
        stage.at(0.0)?;
        if layers.is_empty() {
            return Err(Error::invalid("layers", "there are none", "give at least one"));
        }
        let checked = layers.iter().enumerate().map(|(i, l)| check(i, l)).collect::<Result<Vec<_>>>()?;
        for (i, tie) in ties.iter().enumerate() {
            let [a, b] = tie.layers;
            if a >= layers.len() || b >= layers.len() || a == b || !tie.at.is_finite() {
                let problem = format!("joins the layers {a} and {b} of {} at {}", layers.len(), tie.at);
                return Err(Error::invalid(format!("tie {i}"), problem, "join two layers at a finite place"));
            }
        }
        let mut rigidity = Vec::new();
        for (i, layer) in layers.iter().enumerate() {
            for (k, line) in layer.lines.iter().enumerate() {
                rigidity.push(rigid(format!("layer {i}, line {k}"), line.rigidity)?);
            }
        }
        let n: usize = layers.iter().map(|l| l.points.len()).sum();
        let all = || layers.iter().flat_map(|l| &l.points);
        let centre = all().fold(DVec2::ZERO, |s, p| s + p.as_dvec2() / n as f64);
        let triangles: usize = checked.iter().map(|c| c.triangles.len()).sum();
        let edge = checked.iter().map(|c| f64::from(c.edge) * c.triangles.len() as f64).sum::<f64>() / triangles as f64;
        let scale = 1.0 / edge;
        let (mut prepared, mut first, mut first_line) = (Vec::new(), 0, 0);
        for (layer, checked) in layers.iter().zip(checked) {
            let rest: Vec<DVec2> = layer.points.iter().map(|p| (p.as_dvec2() - centre) * scale).collect();
            let finder = Finder::new(&rest, &checked.triangles, f64::from(checked.edge) * scale);
            let count = rest.len();
            let triangles = checked.triangles;
            prepared.push(PreparedLayer { first, count, rest, triangles, finder, first_line, lines: Vec::new() });
            (first, first_line) = (first + count, first_line + layer.lines.len());
        }
        stage.at(0.1)?;
        // Everything that looks at several vertices, numbered layer after layer.
        let (mut stretches, mut bends) = (Vec::new(), Vec::new());
        for (own, layer) in prepared.iter_mut().zip(layers) {
            let index = |v: u32| v + own.first as u32;
            for (k, line) in layer.lines.iter().enumerate() {
                let points: Vec<DVec2> = line.points.iter().map(|p| (p.as_dvec2() - centre) * scale).collect();
                let hung: Vec<Sum> = points.iter().map(|p| own.hang(*p, f64::INFINITY, index).0).collect();
                if let Some((nodes, step)) = lines::nodes(&points, line.closed) {
                    let places: Vec<Sum> = nodes.iter().map(|p| own.hang(*p, f64::INFINITY, index).0).collect();
                    let number = (own.first_line + k) as u32;
                    lines::terms(number, (&nodes, step), line.closed, &places, &mut stretches, &mut bends);
                }
                own.lines.push(hung);
            }
        }
        let mut tied: Vec<Sum> = ties
            .iter()
            .map(|tie| {
                let [a, b] = tie.layers.map(|l| {
                    let layer = &prepared[l];
                    layer.hang((tie.at.as_dvec2() - centre) * scale, OUTSIDE, |v| v + layer.first as u32).0
                });
                let mut sum = a;
                sum.add(&b, -DVec2::X);
                sum
            })
            .collect();
        stage.at(0.3)?;
        let mut groups: Vec<Vec<u32>> = Vec::new();
        for layer in &prepared {
            groups.extend(layer.triangles.iter().map(|t| t.map(|v| v + layer.first as u32).to_vec()));
        }
        let sums = stretches.iter().chain(&bends).map(|t| &t.sum).chain(&tied);
        groups.extend(sums.map(|s| s.0.iter().map(|m| m.0).collect()));
        let graph = Graph::of_groups(n, groups.iter().map(|g| &g[..]));
        let points: Vec<Vec2> = all().map(|p| ((p.as_dvec2() - centre) * scale).as_vec2()).collect();
        let (fronts, order) = Fronts::new(&graph, &points);
        stage.at(0.7)?;
        let mut place = vec![0; n];
        order.iter().enumerate().for_each(|(i, &v)| place[v as usize] = i as u32);
        let replace = |sum: &mut Sum| {
            sum.0.iter_mut().for_each(|m| m.0 = place[m.0 as usize]);
            sum.0.sort_by_key(|m| m.0);
        };
        let mine = stretches.iter_mut().chain(&mut bends).map(|t| &mut t.sum).chain(&mut tied);
        mine.chain(prepared.iter_mut().flat_map(|l| l.lines.iter_mut().flatten())).for_each(replace);
        let rest: Vec<DVec2> = order
            .iter()
            .map(|&v| {
                let layer = &prepared[prepared.partition_point(|l| l.first <= v as usize) - 1];
                layer.rest[v as usize - layer.first]
            })
            .collect();
        let mut triangles: Vec<[u32; 3]> =
            prepared.iter().flat_map(|l| l.triangles.iter().map(|t| t.map(|v| place[v as usize + l.first]))).collect();
        // Triangles near one another work on the same vertices: the order of elimination keeps them so.
        triangles.sort_unstable_by_key(|t| *t.iter().min().unwrap_or(&0));
        let terms = Terms::new(&rest, &triangles, &stretches, &bends, &tied, &fronts);
        let part = parts(n, groups.iter().map(|g| g.iter().map(|&v| place[v as usize])));
        stage.at(1.0)?;
        let prepared = Prepared { centre, scale, layers: prepared, place, rest, fronts, terms, part };
        Ok(Self { prepared: Arc::new(prepared), rigidity })
    }

    /// Changes how stiff a line is.
    ///
    /// # Errors
    /// A line that is not there, or a rigidity out of range.
    pub fn set_rigidity(&mut self, layer: usize, line: usize, rigidity: f32) -> Result<()> {
        let number = self.prepared.line(layer, line)?;
        self.rigidity[number] = rigid(format!("layer {layer}, line {line}"), rigidity)?;
        Ok(())
    }

    /// Binds the layers to handles: the layer that each one moves, and where it lies at rest. Of handles in one place,
    /// that place goes midway. Layers that hang together with no handle stay.
    ///
    /// # Errors
    /// A layer that is not there, or a place that is not finite.
    pub fn bind(&self, handles: &[(usize, Vec2)], stage: Stage<'_>) -> Result<BoundStrokes> {
        stage.at(0.0)?;
        let prepared = &self.prepared;
        let (mut sums, mut spots, mut shares): (Vec<Sum>, Vec<(usize, DVec2)>, _) =
            (Vec::new(), Vec::new(), Vec::new());
        for (i, &(layer, at)) in handles.iter().enumerate() {
            let Some(own) = prepared.layers.get(layer).filter(|_| at.is_finite()) else {
                let problem = format!("lies in layer {layer} of {} at {at}", prepared.layers.len());
                return Err(Error::invalid(format!("handle {i}"), problem, "give a layer and a finite place"));
            };
            let at = prepared.inner(at);
            let (mut sum, near) = own.hang(at, OUTSIDE, |v| prepared.place[v as usize + own.first]);
            sum.0.sort_by_key(|m| m.0);
            let same = spots.iter().position(|(l, spot)| *l == layer && spot.distance(near) < ONE_SPOT);
            let spot = same.map_or(near, |s| spots[s].1);
            shares.push(Share { pin: same.unwrap_or(spots.len()), offset: spot - at });
            if same.is_none() {
                spots.push((layer, near));
                sums.push(sum);
            }
        }
        let pins = Pins::new(&sums, PIN, &prepared.fronts);
        let mut driven = vec![false; prepared.rest.len()];
        sums.iter().flat_map(|s| &s.0).for_each(|m| driven[prepared.part[m.0 as usize] as usize] = true);
        let driven: Vec<bool> = prepared.part.iter().map(|&p| driven[p as usize]).collect();
        stage.at(1.0)?;
        Ok(BoundStrokes {
            descent: Descent::new(&prepared.fronts, prepared.rest.len()),
            prepared: Arc::clone(prepared),
            rigidity: self.rigidity.clone(),
            pins,
            part: sums.iter().map(|s| prepared.part[s.0[0].0 as usize]).collect(),
            shares,
            driven,
        })
    }
}

impl Prepared {
    fn line(&self, layer: usize, line: usize) -> Result<usize> {
        let found = self.layers.get(layer).filter(|l| line < l.lines.len());
        found.map(|l| l.first_line + line).ok_or_else(|| {
            Error::invalid(format!("layer {layer}, line {line}"), "is not there", "name a line that was given")
        })
    }
}

/// The pin that a handle moves, and the way from the handle to it.
#[derive(Clone, Copy, Debug)]
struct Share {
    pin: usize,
    offset: DVec2,
}

/// Layers bound to their handles.
#[derive(Debug)]
pub struct BoundStrokes {
    prepared: Arc<Prepared>,
    rigidity: Vec<f64>,
    pins: Pins,
    /// What hangs together with each pin.
    part: Vec<u32>,
    /// The pin of each handle.
    shares: Vec<Share>,
    /// Vertices that hang together with a handle.
    driven: Vec<bool>,
    descent: Descent,
}

impl BoundStrokes {
    /// The shape at rest.
    pub fn rest(&self) -> Shape {
        let mut shape = Shape::default();
        self.show(&self.prepared.rest, &mut shape);
        shape
    }

    /// Changes how stiff a line is.
    ///
    /// # Errors
    /// A line that is not there, or a rigidity out of range.
    pub fn set_rigidity(&mut self, layer: usize, line: usize, rigidity: f32) -> Result<()> {
        let number = self.prepared.line(layer, line)?;
        self.rigidity[number] = rigid(format!("layer {layer}, line {line}"), rigidity)?;
        self.descent.forget();
        Ok(())
    }

    /// How far a solve goes.
    pub fn set_effort(&mut self, effort: Effort) {
        self.descent.effort = effort;
    }

    /// How the last solve went.
    pub fn settled(&self) -> &Settled {
        &self.descent.settled
    }

    /// Moves the layers so that every handle is at its target. `shape` holds the shape to start from, as far as its
    /// `points` go, and is given the new one; after an error it is as it was.
    ///
    /// # Errors
    /// Other than one finite target a handle, a shape of other layers or with a number that is not finite, or a cancel.
    pub fn solve(&mut self, targets: &[Vec2], shape: &mut Shape, stage: Stage<'_>) -> Result<()> {
        stage.at(0.0)?;
        if targets.len() != self.shares.len() || targets.iter().any(|t| !t.is_finite()) {
            let problem = format!("{} finite ones were expected", self.shares.len());
            return Err(Error::invalid("targets", problem, "pass one for each handle that was bound"));
        }
        let own = &*self.prepared;
        let counts = shape.points.iter().map(Vec::len);
        if !counts.eq(own.layers.iter().map(|l| l.count)) || shape.points.iter().flatten().any(|p| !p.is_finite()) {
            let problem = "does not have a finite place for each vertex that was bound";
            return Err(Error::invalid("shape", problem, "start from the shape at rest or from the last one"));
        }
        let targets = self.places(targets);
        let mut u = self.start(shape);
        self.shift(&targets, &mut u);
        if !targets.is_empty() {
            let floor = FOLLOWS * self.rigidity.iter().copied().fold(0.0, f64::max).min(1.0);
            let rigidity: Vec<f64> = self.rigidity.iter().map(|r| r.max(floor)).collect();
            let system = descent::System {
                terms: &own.terms,
                fronts: &own.fronts,
                rigidity: &rigidity,
                pins: &self.pins,
                targets: &targets,
            };
            self.descent.run(&system, &mut u, stage)?;
            self.pins.touch(&targets, &mut u);
        }
        self.show(&u, shape);
        Ok(())
    }

    /// Where the pins belong, with the handles at `targets`.
    fn places(&self, targets: &[Vec2]) -> Vec<DVec2> {
        let mut sums = vec![(DVec2::ZERO, 0.0); self.part.len()];
        for (share, target) in self.shares.iter().zip(targets) {
            let (sum, count) = &mut sums[share.pin];
            *sum += self.prepared.inner(*target) + share.offset;
            *count += 1.0;
        }
        sums.into_iter().map(|(sum, count)| sum / count).collect()
    }

    /// Moves what hangs together by the mean way of its pins.
    fn shift(&self, targets: &[DVec2], u: &mut [DVec2]) {
        let mut ways = vec![(DVec2::ZERO, 0.0); u.len()];
        for (pin, (target, part)) in targets.iter().zip(&self.part).enumerate() {
            let (way, count) = &mut ways[*part as usize];
            *way += *target - self.pins.at(pin, u);
            *count += 1.0;
        }
        for (u, part) in u.iter_mut().zip(&self.prepared.part) {
            let (way, count) = ways[*part as usize];
            *u += way / f64::max(count, 1.0);
        }
    }

    /// The vertices of `shape`; those that no handle moves are at rest.
    fn start(&self, shape: &Shape) -> Vec<DVec2> {
        let own = &*self.prepared;
        let mut u = own.rest.clone();
        for (layer, points) in own.layers.iter().zip(&shape.points) {
            for (&at, p) in own.place[layer.first..].iter().zip(points) {
                if self.driven[at as usize] {
                    u[at as usize] = own.inner(*p);
                }
            }
        }
        u
    }

    fn show(&self, u: &[DVec2], shape: &mut Shape) {
        let own = &*self.prepared;
        let points = |l: &PreparedLayer| {
            own.place[l.first..l.first + l.count].iter().map(|&at| own.outer(u[at as usize])).collect()
        };
        shape.points = own.layers.iter().map(points).collect();
        let line = |sums: &Vec<Sum>| sums.iter().map(|s| own.outer(s.at(u))).collect();
        shape.lines = own.layers.iter().map(|l| l.lines.iter().map(line).collect()).collect();
    }
}

/// What hangs together through `groups`: a number for each of `n` vertices, which is one of them.
fn parts(n: usize, groups: impl Iterator<Item = impl Iterator<Item = u32>>) -> Vec<u32> {
    fn find(root: &mut [u32], mut v: u32) -> u32 {
        while root[v as usize] != v {
            root[v as usize] = root[root[v as usize] as usize];
            v = root[v as usize];
        }
        v
    }
    let mut root: Vec<u32> = (0..n as u32).collect();
    for mut group in groups {
        let Some(first) = group.next() else { continue };
        for v in group {
            let (a, b) = (find(&mut root, first), find(&mut root, v));
            root[a.max(b) as usize] = a.min(b);
        }
    }
    (0..n as u32).map(|v| find(&mut root, v)).collect()
}

fn check(number: usize, layer: &Layer) -> Result<arap::Checked> {
    if let Some(k) = layer.lines.iter().position(|l| l.points.iter().any(|p| !p.is_finite())) {
        let what = format!("layer {number}, line {k}");
        return Err(Error::invalid(what, "has a point that is not a number", "give finite places"));
    }
    arap::check(RestMesh { points: &layer.points, triangles: &layer.triangles }).map_err(|e| match e {
        Error::Invalid { what, problem, remedy } => {
            Error::Invalid { what: format!("layer {number}, {what}"), problem, remedy }
        }
        other => other,
    })
}
