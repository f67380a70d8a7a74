//! The energy and its slopes.
//!
//! Places are complex numbers, and every term looks at one complex sum over a few vertices, `s = sum a_i u_i`. Some
//! weigh `|s - t|^2`, which no rotation about the origin changes where `t = 0`: what a triangle's map mirrors, what a
//! line bends, ties and handles. The others weigh `(|s| - l)^2`: a triangle's turn and scale with `l = 1`, and the pieces
//! of a line with their length. The first have the same matrix for any shape. Of the second, `c (r r' + (1 - l / |s|) q q')`
//! with r along the sum and q across it, the part across is negative for what is pushed together; whoever factors the matrix says how much
//! of that counts.
//!
//! With the map of a triangle `f z + g conj(z)`, `2 A ((|f| - 1)^2 + |g|^2)` is the as-rigid-as-possible energy of Liu et
//! al. 2008.

use glam::{DMat2, DVec2};

use crate::deform::sparse::{Fronts, Matrix};

/// A weighted sum over vertices.
#[derive(Clone, Debug, Default)]
pub(super) struct Sum(pub(super) Vec<(u32, DVec2)>);

impl Sum {
    /// Adds another one, times a complex number.
    pub(super) fn add(&mut self, other: &Self, by: DVec2) {
        for &(v, a) in &other.0 {
            let a = by.rotate(a);
            match self.0.binary_search_by_key(&v, |m| m.0) {
                Ok(at) => self.0[at].1 += a,
                Err(at) => self.0.insert(at, (v, a)),
            }
        }
    }

    /// A place in a triangle.
    pub(super) fn place(corners: [u32; 3], weights: [f64; 3]) -> Self {
        let mut sum = Self::default();
        for (v, w) in corners.into_iter().zip(weights) {
            sum.add(&Self(vec![(v, DVec2::X)]), DVec2::new(w, 0.0));
        }
        sum
    }

    pub(super) fn at(&self, u: &[DVec2]) -> DVec2 {
        self.0.iter().map(|&(v, a)| a.rotate(u[v as usize])).sum()
    }
}

/// Sums one after the other, with their places in the matrix.
#[derive(Clone, Debug, Default)]
struct Sums {
    starts: Vec<u32>,
    members: Vec<(u32, DVec2)>,
    /// For each member, and each one up to it: its block, and the height of the columns.
    slots: Vec<[u32; 2]>,
    slot_starts: Vec<u32>,
}

impl Sums {
    fn new(sums: &[Sum], fronts: &Fronts) -> Self {
        let mut own = Self { starts: vec![0], slot_starts: vec![0], ..Self::default() };
        for sum in sums {
            own.members.extend_from_slice(&sum.0);
            for (i, &(row, _)) in sum.0.iter().enumerate() {
                own.slots.extend(sum.0[..=i].iter().map(|&(c, _)| [fronts.slot(row, c), fronts.stride(c)]));
            }
            own.starts.push(own.members.len() as u32);
            own.slot_starts.push(own.slots.len() as u32);
        }
        own
    }

    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    fn members(&self, k: usize) -> &[(u32, DVec2)] {
        &self.members[self.starts[k] as usize..self.starts[k + 1] as usize]
    }

    fn at(&self, k: usize, u: &[DVec2]) -> DVec2 {
        self.members(k).iter().map(|&(v, a)| a.rotate(u[v as usize])).sum()
    }

    /// Adds what a slope of the sum is to its vertices.
    fn slope(&self, k: usize, by: DVec2, slopes: &mut [DVec2]) {
        self.members(k).iter().for_each(|&(v, a)| slopes[v as usize] += conjugate(a).rotate(by));
    }

    /// Adds a curvature of the sum: `along` its direction, and `across`.
    fn curve(&self, k: usize, along: f64, across: f64, way: DVec2, matrix: &mut Matrix<f64>) {
        let members = self.members(k);
        let mut slots = self.slots[self.slot_starts[k] as usize..].iter();
        let more = along - across;
        for (i, &(_, a)) in members.iter().enumerate() {
            let a = conjugate(a);
            let own = a.rotate(way) * more;
            for (&(_, b), &[slot, stride]) in members[..=i].iter().zip(&mut slots) {
                let round = a.rotate(b) * across;
                let other = conjugate(b).rotate(way);
                let block = DMat2::from_cols(round + own * other.x, round.perp() + own * other.y);
                matrix.add(slot, stride, block);
            }
        }
    }
}

fn conjugate(a: DVec2) -> DVec2 {
    DVec2::new(a.x, -a.y)
}

/// A triangle's map `f z + g conj(z)`: of the ways to its second and third corner.
#[derive(Clone, Debug)]
struct Element {
    corners: [u32; 3],
    f: [DVec2; 2],
    g: [DVec2; 2],
    /// Twice the area.
    weight: f64,
}

/// A term that belongs to a line.
#[derive(Clone, Debug)]
pub(super) struct OfLine {
    pub(super) line: u32,
    /// Multiplied by the line's rigidity.
    pub(super) weight: f64,
    /// What the sum is long at rest; a bend vanishes.
    pub(super) length: f64,
    /// The piece that turns as it does, among all.
    pub(super) piece: u32,
    pub(super) sum: Sum,
}

/// The terms of a mesh with its lines and ties.
#[derive(Clone, Debug)]
pub(super) struct Terms {
    elements: Vec<Element>,
    turns: Sums,
    mirrors: Sums,
    stretches: Sums,
    bends: Sums,
    /// Line, weight, and the length, or the piece that turns as a bend does.
    of_stretch: Vec<(u32, f64, f64)>,
    of_bend: Vec<(u32, f64, u32)>,
    ties: Sums,
    own: Vec<[u32; 2]>,
}

/// What a tie weighs against the mesh: between a stiff line and a handle.
const TIE: f64 = 1e5;

/// A sum with its wished value.
#[derive(Clone, Debug)]
pub(super) struct Pins {
    sums: Sums,
    weight: f64,
}

impl Pins {
    pub(super) fn new(places: &[Sum], weight: f64, fronts: &Fronts) -> Self {
        Self { sums: Sums::new(places, fronts), weight }
    }

    pub(super) fn at(&self, pin: usize, u: &[DVec2]) -> DVec2 {
        self.sums.at(pin, u)
    }

    /// The least moves of vertices that bring the pins to `targets`. Pins that share vertices disturb one another; some
    /// rounds settle them.
    pub(super) fn touch(&self, targets: &[DVec2], u: &mut [DVec2]) {
        for _ in 0..8 {
            for (k, target) in targets.iter().enumerate() {
                let square: f64 = self.sums.members(k).iter().map(|m| m.1.length_squared()).sum();
                let gap = (*target - self.at(k, u)) / square;
                self.sums.slope(k, gap, u);
            }
        }
    }
}

/// How the terms `(|s| - l)^2` enter a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Curves {
    /// As they curve, with this share of what is negative.
    Newton(f64),
    /// As if each sum kept its direction, times a factor.
    Turned(f64),
}

impl Terms {
    /// `triangles` with their corners at rest.
    pub(super) fn new(
        rest: &[DVec2],
        triangles: &[[u32; 3]],
        stretches: &[OfLine],
        bends: &[OfLine],
        ties: &[Sum],
        fronts: &Fronts,
    ) -> Self {
        let elements: Vec<Element> = triangles.iter().map(|t| Element::new(*t, rest)).collect();
        let sums = |of: fn(&Element) -> [DVec2; 2]| -> Sums {
            let sum = |e: &Element| {
                let [b, c] = of(e);
                let mut sum = Sum::default();
                for (v, a) in e.corners.into_iter().zip([-b - c, b, c]) {
                    sum.add(&Sum(vec![(v, DVec2::X)]), a);
                }
                sum
            };
            Sums::new(&elements.iter().map(sum).collect::<Vec<_>>(), fronts)
        };
        let of_lines = |terms: &[OfLine]| Sums::new(&terms.iter().map(|t| t.sum.clone()).collect::<Vec<_>>(), fronts);
        Self {
            turns: sums(|e| e.f),
            mirrors: sums(|e| e.g),
            stretches: of_lines(stretches),
            bends: of_lines(bends),
            of_stretch: stretches.iter().map(|t| (t.line, t.weight, t.length)).collect(),
            of_bend: bends.iter().map(|t| (t.line, t.weight, t.piece)).collect(),
            ties: Sums::new(ties, fronts),
            own: (0..rest.len() as u32).map(|v| [fronts.slot(v, v), fronts.stride(v)]).collect(),
            elements,
        }
    }

    /// What of the matrix is the same for any shape. `keep` holds every vertex a little where it is.
    pub(super) fn base(&self, rigidity: &[f64], pins: &Pins, keep: f64, matrix: &mut Matrix<f64>) {
        matrix.clear();
        for &[slot, stride] in &self.own {
            matrix.add(slot, stride, DMat2::from_diagonal(DVec2::splat(keep)));
        }
        for (k, element) in self.elements.iter().enumerate() {
            self.mirrors.curve(k, element.weight, element.weight, DVec2::X, matrix);
        }
        for (k, &(line, weight, _)) in self.of_bend.iter().enumerate() {
            let weight = weight * rigidity[line as usize];
            if weight > 0.0 {
                self.bends.curve(k, weight, weight, DVec2::X, matrix);
            }
        }
        (0..self.ties.len()).for_each(|k| self.ties.curve(k, TIE, TIE, DVec2::X, matrix));
        (0..pins.sums.len()).for_each(|k| pins.sums.curve(k, pins.weight, pins.weight, DVec2::X, matrix));
    }

    /// Adds the rest of the matrix at the shape `u`.
    pub(super) fn curves(&self, u: &[DVec2], rigidity: &[f64], how: Curves, matrix: &mut Matrix<f64>) {
        let curve = |sums: &Sums, k: usize, weight: f64, length: f64, matrix: &mut Matrix<f64>| match how {
            Curves::Turned(by) => sums.curve(k, by * weight, by * weight, DVec2::X, matrix),
            Curves::Newton(share) => {
                let s = sums.at(k, u);
                let across = 1.0 - length / s.length().max(SHORT * length);
                let across = if across < 0.0 { share * across } else { across };
                sums.curve(k, weight, across * weight, direction(s), matrix);
            }
        };
        for (k, element) in self.elements.iter().enumerate() {
            curve(&self.turns, k, element.weight, 1.0, matrix);
        }
        for (k, &(line, weight, length)) in self.of_stretch.iter().enumerate() {
            let weight = weight * rigidity[line as usize];
            if weight > 0.0 {
                curve(&self.stretches, k, weight, length, matrix);
            }
        }
    }

    /// The energy at `u`, and half its slopes. `turns` is what the terms `(|s| - l)^2` count.
    pub(super) fn slopes(
        &self,
        u: &[DVec2],
        rigidity: &[f64],
        pins: &Pins,
        targets: &[DVec2],
        turns: f64,
        slopes: &mut [DVec2],
    ) -> f64 {
        slopes.fill(DVec2::ZERO);
        let mut energy = 0.0;
        for e in &self.elements {
            let (f, g) = e.map(u);
            let more = f.length() - 1.0;
            energy += e.weight * (turns * more * more + g.length_squared());
            e.slope(direction(f) * (turns * more * e.weight), g * e.weight, slopes);
        }
        for (k, &(line, weight, length)) in self.of_stretch.iter().enumerate() {
            let weight = turns * weight * rigidity[line as usize];
            if weight > 0.0 {
                let s = self.stretches.at(k, u);
                let more = s.length() - length;
                energy += weight * more * more;
                self.stretches.slope(k, direction(s) * (weight * more), slopes);
            }
        }
        let mut flat = |sums: &Sums, k: usize, weight: f64, wished: DVec2| {
            let s = sums.at(k, u) - wished;
            energy += weight * s.length_squared();
            sums.slope(k, s * weight, slopes);
        };
        for (k, &(line, weight, _)) in self.of_bend.iter().enumerate() {
            let weight = weight * rigidity[line as usize];
            if weight > 0.0 {
                flat(&self.bends, k, weight, DVec2::ZERO);
            }
        }
        (0..self.ties.len()).for_each(|k| flat(&self.ties, k, TIE, DVec2::ZERO));
        targets.iter().enumerate().for_each(|(k, target)| flat(&pins.sums, k, pins.weight, *target));
        energy
    }

    /// What pulls the shape `u + step`, where everything went along its tangent, to where it turns as far as the step
    /// says.
    pub(super) fn swings(&self, u: &[DVec2], step: &[DVec2], rigidity: &[f64], pulls: &mut [DVec2]) {
        pulls.fill(DVec2::ZERO);
        for e in &self.elements {
            let ((f, g), (f_step, g_step)) = (e.map(u), e.map(step));
            let swing = Swing::new(f, f_step);
            e.slope(swing.own(f, f_step) * e.weight, swing.other(g, g_step) * e.weight, pulls);
        }
        for (k, &(line, weight, _)) in self.of_stretch.iter().enumerate() {
            let weight = weight * rigidity[line as usize];
            if weight > 0.0 {
                let (s, by) = (self.stretches.at(k, u), self.stretches.at(k, step));
                self.stretches.slope(k, Swing::new(s, by).own(s, by) * weight, pulls);
            }
        }
        for (k, &(line, weight, piece)) in self.of_bend.iter().enumerate() {
            let weight = weight * rigidity[line as usize];
            if weight > 0.0 {
                let at = |u| self.stretches.at(piece as usize, u);
                let swing = Swing::new(at(u), at(step));
                self.bends.slope(k, swing.other(self.bends.at(k, u), self.bends.at(k, step)) * weight, pulls);
            }
        }
    }

    /// How far apart what ties hold is.
    #[cfg(test)]
    pub(super) fn tie_gaps(&self, u: &[DVec2]) -> Vec<f64> {
        (0..self.ties.len()).map(|k| self.ties.at(k, u).length()).collect()
    }

    /// The energy at `u`.
    pub(super) fn energy(&self, u: &[DVec2], rigidity: &[f64], pins: &Pins, targets: &[DVec2]) -> f64 {
        let mut energy = 0.0;
        for e in &self.elements {
            let (f, g) = e.map(u);
            energy += e.weight * ((f.length() - 1.0).powi(2) + g.length_squared());
        }
        for (k, &(line, weight, length)) in self.of_stretch.iter().enumerate() {
            energy += weight * rigidity[line as usize] * (self.stretches.at(k, u).length() - length).powi(2);
        }
        for (k, &(line, weight, _)) in self.of_bend.iter().enumerate() {
            energy += weight * rigidity[line as usize] * self.bends.at(k, u).length_squared();
        }
        let ties = (0..self.ties.len()).map(|k| self.ties.at(k, u).length_squared());
        let pinned = targets.iter().enumerate().map(|(k, t)| pins.at(k, u).distance_squared(*t));
        energy + TIE * ties.sum::<f64>() + pins.weight * pinned.sum::<f64>()
    }
}

/// Sums shorter than this share of what they should be curve no more than those.
const SHORT: f64 = 0.01;
/// The farthest that a step turns something, in radians.
const FARTHEST: f64 = 1.5;
/// A step shortens nothing to less than this.
const SHRUNK: f64 = 0.1;

/// How something turns and stretches in a step, by what the step does to a sum along it.
struct Swing {
    angle: f64,
    turn: DVec2,
    stretch: f64,
}

impl Swing {
    fn new(s: DVec2, by: DVec2) -> Self {
        let square = s.length_squared().max(f64::MIN_POSITIVE);
        let angle = (s.perp_dot(by) / square).clamp(-FARTHEST, FARTHEST);
        Self { angle, turn: DVec2::from_angle(angle), stretch: (1.0 + s.dot(by) / square).max(SHRUNK) }
    }

    /// From where the step brings the sum to where turning and stretching does.
    fn own(&self, s: DVec2, by: DVec2) -> DVec2 {
        self.turn.rotate(s) * self.stretch - (s + by)
    }

    /// The same for another sum, which turns along.
    fn other(&self, s: DVec2, by: DVec2) -> DVec2 {
        self.turn.rotate(s + by - s.perp() * self.angle) - (s + by)
    }
}

/// Unit vector; what has no length points along x.
fn direction(s: DVec2) -> DVec2 {
    s.try_normalize().unwrap_or(DVec2::X)
}

impl Element {
    fn new(corners: [u32; 3], rest: &[DVec2]) -> Self {
        let [a, b, c] = corners.map(|v| rest[v as usize]);
        let (to_b, to_c) = (b - a, c - a);
        let twice = to_b.perp_dot(to_c);
        // 1 / (b conj(c) - conj(b) c)
        let inverse = DVec2::new(0.0, 0.5 / twice);
        Self {
            corners,
            f: [conjugate(to_c), -conjugate(to_b)].map(|x| x.rotate(inverse)),
            g: [-to_c, to_b].map(|x| x.rotate(inverse)),
            weight: twice.abs(),
        }
    }

    /// `f` and `g` in the shape `u`.
    fn map(&self, u: &[DVec2]) -> (DVec2, DVec2) {
        let [a, b, c] = self.corners.map(|v| u[v as usize]);
        let of = |k: [DVec2; 2]| k[0].rotate(b - a) + k[1].rotate(c - a);
        (of(self.f), of(self.g))
    }

    /// Adds what slopes of `f` and `g` are to the corners.
    fn slope(&self, f: DVec2, g: DVec2, slopes: &mut [DVec2]) {
        let [at_b, at_c] = [0, 1].map(|k| conjugate(self.f[k]).rotate(f) + conjugate(self.g[k]).rotate(g));
        let [a, b, c] = self.corners.map(|v| v as usize);
        slopes[a] -= at_b + at_c;
        slopes[b] += at_b;
        slopes[c] += at_c;
    }
}
