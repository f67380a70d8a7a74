//! A drawing that moves: from a drawing, a binding and motions to a take.
//!
//! Every layer has a mesh of its region (`region`, `layer_mesh`); its strokes are lines of the stroke-preserving solver;
//! points and pins hold the meshes, joints hold them together. A frame is solved from the one before, and every path is
//! drawn again through where its samples went (`bending`). What does not depend on an edit is kept: moving a point or
//! changing a rigidity meshes nothing.
//!
//! Known limits: a piece of a layer that lies far from all others and has no handle stays where it is; strokes that would
//! need more than [`NODES`] nodes together move with the mesh without stiffening it, the shortest first.

use glam::{Vec2, dvec2};
use kurbo::{Affine, BezPath};

use super::bending::{Bending, Cuts};
use super::layer_mesh::{self, LayerMesh, Place};
use super::layering::Layering;
use super::motion_use;
use super::region::RegionGrid;
use super::{Binding, Drawing, SketchFrame, SketchTake};
use crate::deform::stroke_preserving::{BoundStrokes, Layer, Line, Shape, StrokeMesh, Tie};
use crate::error::{Error, Result};
use crate::geometry::PlaneMesh;
use crate::job::Stage;
use crate::motion::Motion;

/// Samples along a path are so far apart, in edges of the mesh.
const SAMPLED: f64 = 0.75;
/// Samples of a part of a curve where a path is cut before its frames are known.
const PART: usize = 3;
/// Lines shorter than this many edges lie in one triangle or two, which do not bend.
const SHORT: f32 = 1.0;
/// How stiff the rim of a shape without a line is, against a line: as stiff, shapes that are pressed together would fold
/// rather than become narrower.
const FILLED: f32 = 0.05;
/// Nodes of all lines, half an edge apart and eight a line at least: with them a frame takes up to ten milliseconds.
const NODES: f32 = 6000.0;
/// Places of all strokes in all frames: 1.6 GB.
const MOST_PLACES: usize = 200_000_000;
/// Vertices of a stroke's surroundings that its affine map is fitted to, at most.
const SURROUNDINGS: usize = 64;

/// How a drawing is animated.
#[derive(Clone, Debug, PartialEq)]
pub struct SketchParams {
    /// About how many vertices the mesh of a drawing in one layer has. 600: limbs of a figure are two or three triangles
    /// wide, and a frame takes about two milliseconds.
    pub vertices: usize,
    /// How far curves may miss where the mesh takes their lines, as a share of the diagonal of what is drawn. 0.002, a third
    /// of a pixel in a drawing of 160: half as much takes half as many curves again.
    pub tolerance: f64,
    /// Standard deviation, in frames, of a Gaussian over the motion; 0 for none.
    pub smoothing: f32,
}

impl Default for SketchParams {
    fn default() -> Self {
        Self { vertices: 600, tolerance: 2e-3, smoothing: 0.0 }
    }
}

/// One layer that has strokes that move.
struct Sheet {
    /// Its strokes.
    strokes: Vec<usize>,
    mesh: LayerMesh,
    /// The stroke of each of its lines.
    lines: Vec<usize>,
}

/// A path, and where its samples hang: on a sheet, or nowhere.
struct Hung {
    drawn: BezPath,
    bending: Bending,
    sheet: Option<usize>,
    places: Vec<Place>,
    /// Its surroundings' vertices, their weights in the affine map, and their middle.
    around: Vec<(u32, [f64; 2])>,
    middle: Vec2,
}

/// A drawing bound to what moves it.
pub struct Sketch {
    drawing: Drawing,
    binding: Binding,
    params: SketchParams,
    layering: Layering,
    grid: Option<(RegionGrid, f32)>,
    sheets: Vec<Sheet>,
    /// The sheet of each layer of the binding.
    sheet_of: Vec<Option<usize>>,
    paths: Vec<Hung>,
    clips: Vec<Hung>,
    solver: Option<StrokeMesh>,
    bound: Option<BoundStrokes>,
    /// The sheet and place of each point and then of each pin.
    handles: Vec<(usize, Vec2)>,
    outside: Vec<usize>,
    shape: Shape,
    cuts: Vec<Cuts>,
    clip_cuts: Vec<Cuts>,
}

impl std::fmt::Debug for Sketch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Sketch").field("binding", &self.binding).field("params", &self.params).finish_non_exhaustive()
    }
}

impl Sketch {
    /// Makes `drawing` ready to be moved as `binding` says.
    ///
    /// # Errors
    /// A drawing or binding that is not valid, two that do not belong together, parameters out of range, or a cancel.
    pub fn new(drawing: Drawing, binding: Binding, params: SketchParams, stage: Stage<'_>) -> Result<Self> {
        stage.name("meshing the drawing")?;
        drawing.validate()?;
        binding.check(&drawing, None)?;
        let bad = |what: &str, value: f64, remedy: &str| Err(Error::invalid(what, format!("is {value}"), remedy));
        if !(10..=20_000).contains(&params.vertices) {
            return bad("vertices of the mesh", params.vertices as f64, "from 10 to 20,000");
        }
        if !(1e-6..=0.1).contains(&params.tolerance) {
            return bad("tolerance of curves", params.tolerance, "from a millionth to a tenth of the diagonal");
        }
        if !(0.0..=1000.0).contains(&params.smoothing) {
            return bad("smoothing", f64::from(params.smoothing), "from 0 to 1,000 frames");
        }
        let layering = Layering::new(&drawing, &binding);
        let mut own = Self {
            drawing,
            binding,
            params,
            layering,
            grid: None,
            sheets: Vec::new(),
            sheet_of: Vec::new(),
            paths: Vec::new(),
            clips: Vec::new(),
            solver: None,
            bound: None,
            handles: Vec::new(),
            outside: Vec::new(),
            shape: Shape::default(),
            cuts: Vec::new(),
            clip_cuts: Vec::new(),
        };
        own.lay_grid(stage.part(0.0, 0.3))?;
        own.mesh(stage.part(0.3, 0.7))?;
        own.hang();
        own.prepare(stage.part(0.7, 0.9))?;
        own.bind(stage.part(0.9, 1.0))?;
        Ok(own)
    }

    /// The drawing.
    pub fn drawing(&self) -> &Drawing {
        &self.drawing
    }

    /// The binding.
    pub fn binding(&self) -> &Binding {
        &self.binding
    }

    /// The mesh of a layer of the binding at rest, 0 where it names none; `None` where nothing in it moves.
    pub fn mesh_of(&self, layer: usize) -> Option<&PlaneMesh> {
        self.sheet_of.get(layer).copied().flatten().map(|s| &self.sheets[s].mesh.mesh)
    }

    /// Where the vertices of that mesh were in the last frame.
    pub fn shape_of(&self, layer: usize) -> Option<&[Vec2]> {
        self.sheet_of.get(layer).copied().flatten().map(|s| &self.shape.points[s][..])
    }

    /// The points of the binding that lie outside the drawing's meshes. They hold the nearest place.
    pub fn points_outside(&self) -> &[usize] {
        &self.outside
    }

    /// Another binding for the drawing. What it does not change is kept: new points and pins only bind again, other
    /// rigidities only weigh again, other joints only solve anew, other layers mesh only themselves.
    ///
    /// # Errors
    /// A binding that is not valid or not for this drawing, or a cancel; all is as before then.
    pub fn set_binding(&mut self, binding: Binding, stage: Stage<'_>) -> Result<()> {
        stage.name("binding")?;
        binding.check(&self.drawing, None)?;
        let layering = Layering::new(&self.drawing, &binding);
        let layers_kept = layering.of == self.layering.of
            && layering.count == self.layering.count
            && layering.still == self.layering.still;
        if !layers_kept || binding.joints != self.binding.joints || binding.layers != self.binding.layers {
            let mut other = Self::new(self.drawing.clone(), binding, self.params.clone(), stage)?;
            // The shape goes on where the meshes are the same.
            if layers_kept {
                other.shape = std::mem::take(&mut self.shape);
            }
            *self = other;
            return Ok(());
        }
        let handles_kept = binding.points.len() == self.binding.points.len()
            && binding.pins == self.binding.pins
            && binding.points.iter().zip(&self.binding.points).all(|(a, b)| a.at == b.at && a.layer == b.layer);
        let softened: Vec<usize> =
            (0..layering.of.len()).filter(|&s| layering.rigidity[s] != self.layering.rigidity[s]).collect();
        let before = std::mem::replace(&mut self.binding, binding);
        let handles = if handles_kept { Ok(()) } else { self.bind(stage) };
        if let Err(e) = handles {
            self.binding = before;
            return Err(e);
        }
        self.layering = layering;
        for (sheet, own) in self.sheets.iter().enumerate() {
            for (line, stroke) in own.lines.iter().enumerate().filter(|(_, s)| softened.binary_search(s).is_ok()) {
                let rigidity = self.rigidity(*stroke);
                if let Some(solver) = &mut self.solver {
                    solver.set_rigidity(sheet, line, rigidity)?;
                }
                if let Some(bound) = &mut self.bound {
                    bound.set_rigidity(sheet, line, rigidity)?;
                }
            }
        }
        Ok(())
    }

    /// Where each point of the binding goes: for each frame one place a point.
    ///
    /// # Errors
    /// Motions that are not those of the binding.
    pub fn targets(&self, motions: &[&Motion]) -> Result<Vec<Vec<Vec2>>> {
        self.binding.check(&self.drawing, Some(motions))?;
        let ways = motion_use::ways(&self.binding, motions, self.params.smoothing);
        Ok((0..ways.frames).map(|t| ways.points.iter().map(|p| p[t]).collect()).collect())
    }

    /// The drawing with the binding's points at `targets`, from the shape of the last frame on. Paths are cut evenly,
    /// finely enough for most movements.
    ///
    /// # Errors
    /// Other than one finite place a point, or a cancel.
    pub fn frame(&mut self, targets: &[Vec2], stage: Stage<'_>) -> Result<SketchFrame> {
        self.solve(targets, stage)?;
        let moved = self.moved();
        let clips = self.clips.iter().zip(&self.clip_cuts).map(|(c, cuts)| c.path(&c.samples(&self.shape), cuts));
        let affines = self.paths.iter().map(|p| p.affine(&self.shape)).collect();
        let paths = self.paths.iter().zip(&self.cuts).zip(self.each(&moved)).map(|((p, cuts), at)| p.path(at, cuts));
        Ok(SketchFrame { paths: paths.collect(), clips: clips.collect(), affines })
    }

    /// The order in which strokes are painted, the farthest first.
    pub fn order(&self) -> Vec<usize> {
        self.layering.order()
    }

    /// For each stroke with a pen that was pressed, its width at each point of its path in [`Self::frame`].
    pub fn widths(&self) -> Vec<Vec<f32>> {
        self.widths_with(&self.cuts)
    }

    /// Everything back to how it is at rest.
    pub fn reset(&mut self) {
        self.shape.points = self.sheets.iter().map(|s| s.mesh.mesh.points.clone()).collect();
    }

    /// The drawing moved by the binding's motions, from rest. Curves are cut as often as these motions need.
    ///
    /// # Errors
    /// Motions that are not those of the binding, a take too large to hold, or a cancel.
    pub fn take(&mut self, motions: &[&Motion], stage: Stage<'_>) -> Result<SketchTake> {
        stage.name("animating the drawing")?;
        let fps = motions.first().map_or(1.0, |m| m.fps);
        let targets = self.targets(motions)?;
        let places: usize = self.paths.iter().map(|p| p.places.len()).sum();
        if places.saturating_mul(targets.len()) > MOST_PLACES {
            return Err(Error::Limit {
                what: "the number of places of the drawing in all frames".into(),
                value: (places * targets.len()) as u64,
                max: MOST_PLACES as u64,
                remedy: "use a shorter motion or a simpler drawing".into(),
            });
        }
        self.reset();
        let n = targets.len() as f64;
        let (mut moved, mut clipped, mut affines) = (Vec::new(), Vec::new(), Vec::new());
        for (t, targets) in targets.iter().enumerate() {
            self.solve(targets, stage.part(0.8 * t as f64 / n, 0.8 * (t + 1) as f64 / n))?;
            moved.push(self.moved());
            clipped.push(self.clips.iter().map(|c| c.samples(&self.shape)).collect::<Vec<_>>());
            affines.push(self.paths.iter().map(|p| p.affine(&self.shape)).collect::<Vec<Affine>>());
        }
        let tolerance = self.params.tolerance * f64::from(self.grid.as_ref().map_or(1.0, |(g, _)| g.diagonal()));
        let mut starts = vec![0];
        starts.extend(self.paths.iter().scan(0, |sum, p| {
            *sum += p.places.len();
            Some(*sum)
        }));
        let mut cuts = Vec::with_capacity(self.paths.len());
        for (i, path) in self.paths.iter().enumerate() {
            stage.at(0.8 + 0.1 * i as f64 / self.paths.len() as f64)?;
            let own = starts[i]..starts[i + 1];
            cuts.push(
                path.bending.cuts(|| moved.iter().map(|m: &Vec<Vec2>| path.samples_in(&m[own.clone()])), tolerance),
            );
        }
        let clip_cuts: Vec<Cuts> = (0..self.clips.len())
            .map(|i| self.clips[i].bending.cuts(|| clipped.iter().map(|c: &Vec<Vec<Vec2>>| &c[i][..]), tolerance))
            .collect();
        let mut frames = Vec::with_capacity(targets.len());
        for (t, affines) in affines.into_iter().enumerate() {
            stage.at(0.9 + 0.1 * t as f64 / n)?;
            let paths = self.paths.iter().zip(&cuts).zip(self.each(&moved[t])).map(|((p, cuts), at)| p.path(at, cuts));
            let clips = self.clips.iter().zip(&clip_cuts).zip(&clipped[t]).map(|((c, cuts), at)| c.path(at, cuts));
            frames.push(SketchFrame { paths: paths.collect(), clips: clips.collect(), affines });
        }
        Ok(SketchTake { fps, frames, order: self.order(), widths: self.widths_with(&cuts) })
    }

    fn widths_with(&self, cuts: &[Cuts]) -> Vec<Vec<f32>> {
        let pressed = self.drawing.strokes.iter().map(|s| s.pen.as_ref().map_or(&[][..], |p| &p.widths));
        pressed.zip(&self.paths).zip(cuts).map(|((widths, path), cuts)| path.widths(widths, cuts)).collect()
    }

    /// Lays the grid over what moves, and settles the length of the meshes' edges.
    fn lay_grid(&mut self, stage: Stage<'_>) -> Result<()> {
        let moving: Vec<usize> = (0..self.drawing.strokes.len()).filter(|&s| !self.layering.still[s]).collect();
        let Some(grid) = RegionGrid::over(&self.drawing, &moving) else { return Ok(()) };
        let ink = grid.ink(moving.iter().map(|&s| &self.drawing.strokes[s]), stage)?;
        let spacing = layer_mesh::spacing(&grid, &grid.region(&ink), self.params.vertices);
        stage.at(1.0)?;
        self.grid = Some((grid, spacing));
        Ok(())
    }

    /// Meshes the layers.
    fn mesh(&mut self, stage: Stage<'_>) -> Result<()> {
        self.sheet_of = vec![None; self.layering.count];
        let Some((grid, spacing)) = &self.grid else { return Ok(()) };
        for layer in 0..self.layering.count {
            stage.at(layer as f64 / self.layering.count as f64)?;
            let strokes = self.layering.moving(layer);
            if strokes.is_empty() {
                continue;
            }
            let ink = grid.ink(strokes.iter().map(|&s| &self.drawing.strokes[s]), stage)?;
            if ink.count() == 0 {
                // All of it is far off the page.
                continue;
            }
            let mesh = LayerMesh::new(grid, &grid.region(&ink), *spacing)?;
            self.sheet_of[layer] = Some(self.sheets.len());
            self.sheets.push(Sheet { strokes, mesh, lines: Vec::new() });
        }
        Ok(())
    }

    /// Hangs strokes and clips on the sheets.
    fn hang(&mut self) {
        let edge = self.grid.as_ref().map_or(1.0, |(grid, spacing)| f64::from(spacing * grid.cell));
        let sheet_of = |s: usize| if self.layering.still[s] { None } else { self.sheet_of[self.layering.of[s]] };
        let hang = |path: &BezPath, sheet: Option<usize>| {
            Hung::new(path, SAMPLED * edge, sheet.map(|s| (s, &self.sheets[s].mesh)))
        };
        self.paths = self.drawing.strokes.iter().enumerate().map(|(s, k)| hang(&k.path, sheet_of(s))).collect();
        // A clip goes with most of what it shows.
        let mut votes = vec![vec![0usize; self.sheets.len() + 1]; self.drawing.groups.len()];
        for (s, stroke) in self.drawing.strokes.iter().enumerate() {
            let mut group = stroke.group;
            while let Some(g) = group {
                votes[g][sheet_of(s).map_or(0, |s| s + 1)] += 1;
                group = self.drawing.groups[g].parent;
            }
        }
        let empty = BezPath::new();
        let clips = self.drawing.groups.iter().zip(&votes).map(|(group, votes)| {
            let most = (0..votes.len()).rev().max_by_key(|&i| votes[i]).and_then(|i| i.checked_sub(1));
            hang(group.clip.as_ref().map_or(&empty, |c| &c.path), most)
        });
        self.clips = clips.collect();
        self.cuts = self.paths.iter().map(|p| p.bending.even_cuts(PART)).collect();
        self.clip_cuts = self.clips.iter().map(|p| p.bending.even_cuts(PART)).collect();
        self.reset();
    }

    /// Makes the solver ready.
    fn prepare(&mut self, stage: Stage<'_>) -> Result<()> {
        let Some((grid, spacing)) = &self.grid else { return Ok(()) };
        if self.sheets.is_empty() {
            return Ok(());
        }
        let edge = spacing * grid.cell;
        // The longest lines first, as many as the solver bears.
        let mut lengths: Vec<(f32, usize, usize)> = Vec::new();
        for (sheet, own) in self.sheets.iter().enumerate() {
            for &stroke in &own.strokes {
                let length = |(line, round): (&[Vec2], bool)| {
                    let back = if round { line[0].distance(line[line.len() - 1]) } else { 0.0 };
                    crate::geometry::polyline::length(line) + back
                };
                let longest = self.paths[stroke].bending.lines().map(length).fold(0.0, f32::max);
                lengths.push((longest / edge, sheet, stroke));
            }
        }
        lengths.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
        let mut nodes = 0.0;
        let mut kept: Vec<(usize, usize)> = lengths
            .into_iter()
            .take_while(|(length, ..)| {
                nodes += (2.0 * length).max(8.0);
                *length > SHORT && nodes <= NODES
            })
            .map(|(_, sheet, stroke)| (sheet, stroke))
            .collect();
        kept.sort_unstable();
        let mut layers: Vec<Layer> = self
            .sheets
            .iter()
            .map(|s| {
                let PlaneMesh { points, triangles } = s.mesh.mesh.clone();
                Layer { points, triangles, lines: Vec::new() }
            })
            .collect();
        self.sheets.iter_mut().for_each(|s| s.lines.clear());
        for (sheet, stroke) in kept {
            for (points, closed) in self.paths[stroke].bending.lines().filter(|(l, _)| l.len() > 1) {
                let rigidity = self.rigidity(stroke);
                layers[sheet].lines.push(Line { points: points.to_vec(), closed, rigidity });
                self.sheets[sheet].lines.push(stroke);
            }
        }
        let layer = |name: &str| self.binding.layers.iter().position(|l| l.name == name).and_then(|l| self.sheet_of[l]);
        let ties: Vec<Tie> = self
            .binding
            .joints
            .iter()
            .filter_map(|j| Some(Tie { layers: [layer(&j.layers.0)?, layer(&j.layers.1)?], at: j.at }))
            .collect();
        self.solver = Some(StrokeMesh::new(&layers, &ties, stage)?);
        Ok(())
    }

    /// How stiff the lines of a stroke are.
    fn rigidity(&self, stroke: usize) -> f32 {
        let drawn = self.drawing.strokes[stroke].pen.is_some();
        self.layering.rigidity[stroke] * if drawn { 1.0 } else { FILLED }
    }

    /// Binds the solver to points and pins.
    fn bind(&mut self, stage: Stage<'_>) -> Result<()> {
        let Some(solver) = &self.solver else { return Ok(()) };
        let points = self.binding.points.iter().map(|p| (p.at, &p.layer));
        let all: Vec<(Vec2, usize)> = points
            .chain(self.binding.pins.iter().map(|p| (p.at, &p.layer)))
            .map(|(at, layer)| (at, self.sheet_at(at, layer)))
            .collect();
        let nearest: Vec<(usize, Vec2)> = all.iter().map(|&(at, s)| (s, self.sheets[s].mesh.nearest(at))).collect();
        let bound = solver.bind(&nearest, stage)?;
        let away = |i: &usize| all[*i].0.distance(nearest[*i].1) > 1e-3;
        self.outside = (0..self.binding.points.len()).filter(away).collect();
        self.handles = nearest;
        self.bound = Some(bound);
        Ok(())
    }

    /// The sheet that a handle holds: its layer's, or that on which it lies with the nearest line, the front one of equals.
    fn sheet_at(&self, at: Vec2, layer: &str) -> usize {
        let named = self.binding.layers.iter().position(|l| l.name == layer).and_then(|l| self.sheet_of[l]);
        if let Some(sheet) = named {
            return sheet;
        }
        if self.sheets.len() < 2 {
            return 0;
        }
        let gap = |s: &usize| {
            let sheet = &self.sheets[*s];
            let away = sheet.mesh.nearest(at).distance(at);
            let samples = sheet.strokes.iter().flat_map(|&k| self.paths[k].bending.samples());
            (away, samples.map(|p| p.distance(at)).fold(f32::INFINITY, f32::min))
        };
        let found = (0..self.sheets.len()).rev().map(|s| (gap(&s), s));
        found.min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))).map_or(0, |f| f.1)
    }

    fn solve(&mut self, targets: &[Vec2], stage: Stage<'_>) -> Result<()> {
        let points = &self.binding.points;
        if targets.len() != points.len() || targets.iter().any(|t| !t.is_finite()) {
            let problem = format!("{} finite ones were expected", points.len());
            return Err(Error::invalid("places of the points", problem, "give one for each point of the binding"));
        }
        let Some(bound) = self.bound.as_mut().filter(|_| !self.handles.is_empty()) else { return stage.at(1.0) };
        // A handle outside holds the nearest place, which moves as it does.
        let held: Vec<Vec2> = points
            .iter()
            .zip(targets)
            .map(|(p, target)| *target - p.at)
            .chain(self.binding.pins.iter().map(|_| Vec2::ZERO))
            .zip(&self.handles)
            .map(|(movement, (_, at))| *at + movement)
            .collect();
        bound.solve(&held, &mut self.shape, stage)
    }

    /// Where the samples of all strokes are, one stroke after another.
    fn moved(&self) -> Vec<Vec2> {
        self.paths.iter().flat_map(|p| p.samples_of_places(&self.shape)).collect()
    }

    /// The samples of each stroke within those of all.
    fn each<'a>(&'a self, moved: &'a [Vec2]) -> impl Iterator<Item = &'a [Vec2]> {
        let mut rest = moved;
        self.paths.iter().map(move |p| {
            let (own, others) = rest.split_at(p.places.len());
            rest = others;
            p.samples_in(own)
        })
    }
}

impl Hung {
    fn new(drawn: &BezPath, spacing: f64, on: Option<(usize, &LayerMesh)>) -> Self {
        let mut own = Self {
            drawn: drawn.clone(),
            bending: Bending::new(drawn, spacing),
            sheet: on.map(|o| o.0),
            places: Vec::new(),
            around: Vec::new(),
            middle: Vec2::ZERO,
        };
        let Some((_, mesh)) = on else { return own };
        own.places = own.bending.samples().iter().map(|p| mesh.place(*p)).collect();
        let mut around: Vec<u32> = own.places.iter().flat_map(|p| p.corners).collect();
        around.sort_unstable();
        around.dedup();
        let every = around.len().div_ceil(SURROUNDINGS).max(1);
        let around: Vec<u32> = around.into_iter().step_by(every).collect();
        let rest = |v: u32| mesh.mesh.points[v as usize].as_dvec2();
        let middle = around.iter().map(|&v| rest(v)).sum::<glam::DVec2>() / around.len().max(1) as f64;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for &v in &around {
            let d = rest(v) - middle;
            (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
        }
        let determinant = xx * yy - xy * xy;
        own.middle = middle.as_vec2();
        if determinant > 0.0 {
            let weight = |v: u32| {
                let d = rest(v) - middle;
                [(yy * d.x - xy * d.y) / determinant, (xx * d.y - xy * d.x) / determinant]
            };
            own.around = around.into_iter().map(|v| (v, weight(v))).collect();
        }
        own
    }

    fn samples_of_places<'a>(&'a self, shape: &'a Shape) -> impl Iterator<Item = Vec2> {
        let points: &[Vec2] = self.sheet.map_or(&[], |s| &shape.points[s]);
        self.places.iter().map(move |p| p.at(points))
    }

    /// Where its samples are.
    fn samples(&self, shape: &Shape) -> Vec<Vec2> {
        if self.sheet.is_none() { self.bending.samples().to_vec() } else { self.samples_of_places(shape).collect() }
    }

    /// Its samples when those of its places are `moved`: what hangs nowhere has no places and stays.
    fn samples_in<'a>(&'a self, moved: &'a [Vec2]) -> &'a [Vec2] {
        if self.sheet.is_none() { self.bending.samples() } else { moved }
    }

    fn path(&self, at: &[Vec2], cuts: &[u16]) -> BezPath {
        if self.sheet.is_none() { self.drawn.clone() } else { self.bending.path(at, cuts) }
    }

    /// The pen's widths along that path, from those along the drawn one.
    fn widths(&self, widths: &[f32], cuts: &[u16]) -> Vec<f32> {
        if self.sheet.is_none() || widths.is_empty() { widths.to_vec() } else { self.bending.widths(widths, cuts) }
    }

    /// What its surroundings do on the whole: the affine map nearest to what their vertices do.
    fn affine(&self, shape: &Shape) -> Affine {
        let Some(points) = self.sheet.map(|s| &shape.points[s]).filter(|_| !self.around.is_empty()) else {
            return Affine::IDENTITY;
        };
        let at = |v: u32| points[v as usize].as_dvec2();
        let (mut x, mut y, mut middle) = (glam::DVec2::ZERO, glam::DVec2::ZERO, glam::DVec2::ZERO);
        for &(v, w) in &self.around {
            let p = at(v);
            (x, y, middle) = (x + p * w[0], y + p * w[1], middle + p / self.around.len() as f64);
        }
        let rest = self.middle.as_dvec2();
        let offset = middle - dvec2(x.x * rest.x + y.x * rest.y, x.y * rest.x + y.y * rest.y);
        Affine::new([x.x, x.y, y.x, y.y, offset.x, offset.y])
    }
}
