//! Matrices with a block of two by two numbers for every vertex and every pair that touches: what Newton's method asks
//! for in the plane, factored over and over on one graph.
//!
//! Multifrontal like `cholesky`, but assembled where the factor will lie, through slots known beforehand, and factored
//! in place: nothing is looked up, copied or allocated while it is used. Solved by plain substitution, as few
//! right-hand sides share one factor.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Sub, SubAssign};

use glam::{DMat2, DVec2, Vec2};

use super::Graph;
use super::cholesky::Symbolic;

/// Numbers of a factor. 32 bits hold twice as many in a vector, and a step on a mesh alone needs no more digits; where
/// some terms are a million times as stiff as others, 64 do.
pub(crate) trait Real:
    Copy
    + Default
    + PartialOrd
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Sum
{
    /// The nearest number.
    fn of(value: f64) -> Self;
    /// The same number in 64 bits.
    fn wide(self) -> f64;
    /// Its square root.
    fn root(self) -> Self;
}

macro_rules! real {
    ($($number:ty),*) => {$(
        impl Real for $number {
            fn of(value: f64) -> Self {
                value as Self
            }
            fn wide(self) -> f64 {
                f64::from(self)
            }
            fn root(self) -> Self {
                self.sqrt()
            }
        }
    )*};
}
real!(f32, f64);

#[derive(Clone, Copy, Debug)]
struct Front {
    /// First column, columns and rows below, in vertices.
    first: u32,
    len: u32,
    below: u32,
    /// Where its rows below lie in `rows`.
    rows: u32,
    /// Where its panel begins: columns of `2 (len + below)` numbers.
    panel: u32,
    /// How many of the fronts before it hand it what they leave.
    children: u32,
}

impl Front {
    fn height(&self) -> usize {
        2 * (self.len + self.below) as usize
    }

    fn panel(&self) -> std::ops::Range<usize> {
        self.panel as usize..self.panel as usize + 2 * self.len as usize * self.height()
    }

    fn rows(&self) -> std::ops::Range<usize> {
        self.rows as usize..(self.rows + self.below) as usize
    }
}

/// What depends on the graph alone. Vertices are numbered in the order of elimination.
#[derive(Clone, Debug)]
pub(crate) struct Fronts {
    fronts: Vec<Front>,
    /// The front of each vertex's column.
    of: Vec<u32>,
    rows: Vec<u32>,
    /// The place of each of `rows` in the front of the parent.
    places: Vec<u32>,
    values: usize,
    highest: usize,
}

/// A matrix, or its factor.
#[derive(Clone, Debug)]
pub(crate) struct Matrix<R = f32> {
    values: Vec<R>,
    /// What fronts leave for their parents, one after the other.
    left: Vec<R>,
    column: Vec<R>,
}

impl Fronts {
    /// Orders `graph`, whose vertices lie at `points`; with the order of its vertices.
    pub(crate) fn new(graph: &Graph, points: &[Vec2]) -> (Self, Vec<u32>) {
        let symbolic = Symbolic::new(graph, points);
        let mut own = Self {
            fronts: Vec::new(),
            of: vec![0; graph.len()],
            rows: Vec::new(),
            places: Vec::new(),
            values: 0,
            highest: 0,
        };
        let mut children = vec![0u32; symbolic.count()];
        for b in 0..symbolic.count() {
            let (columns, rows, parent) = symbolic.block(b);
            let front = Front {
                first: columns.start as u32,
                len: columns.len() as u32,
                below: rows.len() as u32,
                rows: own.rows.len() as u32,
                panel: own.values as u32,
                children: children[b],
            };
            own.of[columns].fill(b as u32);
            if let Some(parent) = parent.filter(|_| !rows.is_empty()) {
                children[parent] += 1;
                let (columns, above, _) = symbolic.block(parent);
                own.places.extend(rows.iter().map(|&r| {
                    let r = r as usize;
                    let below = || columns.len() + above.partition_point(|&a| (a as usize) < r);
                    (if r < columns.end { r - columns.start } else { below() }) as u32
                }));
            }
            own.rows.extend_from_slice(rows);
            own.values = front.panel().end;
            own.highest = own.highest.max(front.height());
            own.fronts.push(front);
        }
        (own, symbolic.order().to_vec())
    }

    /// Room for a matrix.
    pub(crate) fn matrix<R: Real>(&self) -> Matrix<R> {
        let zero = R::default();
        Matrix { values: vec![zero; self.values], left: Vec::new(), column: vec![zero; self.highest] }
    }

    /// Where the block of a vertex and another one, or itself, lies, which touch.
    pub(crate) fn slot(&self, a: u32, b: u32) -> u32 {
        let (row, column) = (a.max(b), a.min(b));
        let front = &self.fronts[self.of[column as usize] as usize];
        let place = if row < front.first + front.len {
            row - front.first
        } else {
            front.len + self.rows[front.rows()].partition_point(|&r| r < row) as u32
        };
        front.panel + 2 * (column - front.first) * front.height() as u32 + 2 * place
    }

    /// The height of the columns of a vertex.
    pub(crate) fn stride(&self, v: u32) -> u32 {
        self.fronts[self.of[v as usize] as usize].height() as u32
    }

    /// Replaces a matrix by its factor; whether it is positive definite.
    pub(crate) fn factor<R: Real>(&self, matrix: &mut Matrix<R>) -> bool {
        let Matrix { values, left, .. } = matrix;
        // Where each thing in `left` begins, and whose it is.
        let mut stack: Vec<(usize, usize)> = Vec::new();
        left.clear();
        for (b, front) in self.fronts.iter().enumerate() {
            let (height, k, m) = (front.height(), 2 * front.len as usize, 2 * front.below as usize);
            let panel = &mut values[front.panel()];
            let begins = left.len();
            left.resize(begins + m * m, R::default());
            let (given, own) = left.split_at_mut(begins);
            let from = stack.len() - front.children as usize;
            for &(child, at) in &stack[from..] {
                let places = &self.places[self.fronts[child].rows()];
                let size = 2 * places.len();
                for (j, &column) in places.iter().enumerate() {
                    for side in 0..2 {
                        let column = 2 * column as usize + side;
                        let to = if column < k {
                            &mut panel[column * height..(column + 1) * height]
                        } else {
                            // Rows of what is left are those below alone.
                            &mut own[(column - k) * m..(column - k + 1) * m]
                        };
                        let shift = if column < k { 0 } else { k };
                        let source = &given[at + (2 * j + side) * size..at + (2 * j + side + 1) * size];
                        for (pair, &row) in source.as_chunks::<2>().0.iter().zip(places).skip(j) {
                            let row = 2 * row as usize - shift;
                            to[row] += pair[0];
                            to[row + 1] += pair[1];
                        }
                    }
                }
            }
            if !eliminate(panel, height, k) {
                return false;
            }
            for j in (0..m).step_by(2) {
                let (first, second) = own[j * m..(j + 2) * m].split_at_mut(m);
                subtract(&mut first[j..], &mut second[j..], panel, height, k + j, k);
            }
            // What the children left is used up.
            if let Some(&(_, at)) = stack.get(from) {
                left.copy_within(begins.., at);
                left.truncate(at + m * m);
                stack.truncate(from);
                stack.push((b, at));
            } else {
                stack.push((b, begins));
            }
            if m == 0 {
                stack.pop();
            }
        }
        true
    }

    /// Solves with a factor.
    pub(crate) fn solve<R: Real>(&self, factor: &mut Matrix<R>, right: &mut [DVec2]) {
        let Matrix { values, column, .. } = factor;
        for front in &self.fronts {
            let (height, k) = (front.height(), 2 * front.len as usize);
            let t = &mut column[..height];
            let own = front.first as usize..(front.first + front.len) as usize;
            gather(&right[own.clone()], t);
            t[k..].fill(R::default());
            for (j, l) in values[front.panel()].chunks_exact(height).enumerate() {
                t[j] /= l[j];
                let x = t[j];
                t[j + 1..].iter_mut().zip(&l[j + 1..]).for_each(|(t, l)| *t -= x * *l);
            }
            for (v, t) in right[own].iter_mut().zip(t.as_chunks::<2>().0) {
                *v = DVec2::new(t[0].wide(), t[1].wide());
            }
            for (&r, t) in self.rows[front.rows()].iter().zip(t[k..].as_chunks::<2>().0) {
                right[r as usize] += DVec2::new(t[0].wide(), t[1].wide());
            }
        }
        for front in self.fronts.iter().rev() {
            let (height, k) = (front.height(), 2 * front.len as usize);
            let t = &mut column[..height];
            let own = front.first as usize..(front.first + front.len) as usize;
            gather(&right[own.clone()], t);
            for (&r, t) in self.rows[front.rows()].iter().zip(t[k..].as_chunks_mut::<2>().0) {
                *t = [R::of(right[r as usize].x), R::of(right[r as usize].y)];
            }
            for (j, l) in values[front.panel()].chunks_exact(height).enumerate().rev() {
                t[j] = (t[j] - dot(&l[j + 1..], &t[j + 1..])) / l[j];
            }
            for (v, t) in right[own].iter_mut().zip(t.as_chunks::<2>().0) {
                *v = DVec2::new(t[0].wide(), t[1].wide());
            }
        }
    }
}

impl<R: Real> Matrix<R> {
    /// Makes it zero.
    pub(crate) fn clear(&mut self) {
        self.values.fill(R::default());
    }

    /// Makes it the same as another one on the same graph.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.values.copy_from_slice(&other.values);
    }

    /// Adds to the block at `slot` of columns `stride` high.
    pub(crate) fn add(&mut self, slot: u32, stride: u32, block: DMat2) {
        let own = &mut self.values[slot as usize..(slot + stride) as usize + 2];
        own[0] += R::of(block.x_axis.x);
        own[1] += R::of(block.x_axis.y);
        own[stride as usize] += R::of(block.y_axis.x);
        own[stride as usize + 1] += R::of(block.y_axis.y);
    }

    /// Multiplies what lies on the diagonal of a block on the diagonal.
    pub(crate) fn damp(&mut self, slot: u32, stride: u32, by: R) {
        self.values[slot as usize] *= by;
        self.values[(slot + stride) as usize + 1] *= by;
    }
}

fn gather<R: Real>(from: &[DVec2], to: &mut [R]) {
    for (v, t) in from.iter().zip(to.as_chunks_mut::<2>().0) {
        *t = [R::of(v.x), R::of(v.y)];
    }
}

/// In eight sums, that vectors hold, and always in the same order.
fn dot<R: Real>(a: &[R], b: &[R]) -> R {
    let mut sums = [R::default(); 8];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        for l in 0..8 {
            sums[l] += a[l] * b[l];
        }
    }
    let rest: R = a_rest.iter().zip(b_rest).map(|(a, b)| *a * *b).sum();
    sums.into_iter().sum::<R>() + rest
}

/// Factors the `k` columns of a panel, two at a time.
fn eliminate<R: Real>(panel: &mut [R], height: usize, k: usize) -> bool {
    for j in (0..k).step_by(2) {
        let (done, rest) = panel.split_at_mut(j * height);
        let (first, second) = rest[..2 * height].split_at_mut(height);
        let (first, second) = (&mut first[j..], &mut second[j..]);
        subtract(first, second, done, height, j, j);
        if !positive(first[0]) {
            return false;
        }
        let root = first[0].root();
        first[0] = root;
        let inverse = R::of(1.0) / root;
        first[1..].iter_mut().for_each(|x| *x *= inverse);
        let f = first[1];
        second[1..].iter_mut().zip(&first[1..]).for_each(|(y, x)| *y -= f * *x);
        if !positive(second[1]) {
            return false;
        }
        let root = second[1].root();
        second[1] = root;
        let inverse = R::of(1.0) / root;
        second[2..].iter_mut().for_each(|x| *x *= inverse);
    }
    true
}

/// Whether a pivot serves; one that is not a number does not.
fn positive<R: Real>(pivot: R) -> bool {
    pivot > R::default() && pivot.wide().is_finite()
}

/// Takes off two columns, from their row `row` on, what the first `k` columns of a panel ask for.
fn subtract<R: Real>(first: &mut [R], second: &mut [R], panel: &[R], height: usize, row: usize, k: usize) {
    let n = height - row;
    let (first, second) = (&mut first[..n], &mut second[..n]);
    let column = |p: usize| &panel[p * height + row..(p + 1) * height];
    let mut p = 0;
    while p + 4 <= k {
        let (a, b, c, d) = (&column(p)[..n], &column(p + 1)[..n], &column(p + 2)[..n], &column(p + 3)[..n]);
        let (f, g) = ([a[0], b[0], c[0], d[0]], [a[1], b[1], c[1], d[1]]);
        for i in 0..n {
            first[i] -= (f[0] * a[i] + f[1] * b[i]) + (f[2] * c[i] + f[3] * d[i]);
            second[i] -= (g[0] * a[i] + g[1] * b[i]) + (g[2] * c[i] + g[3] * d[i]);
        }
        p += 4;
    }
    if p < k {
        let (a, b) = (&column(p)[..n], &column(p + 1)[..n]);
        let (f, g) = ([a[0], b[0]], [a[1], b[1]]);
        for i in 0..n {
            first[i] -= f[0] * a[i] + f[1] * b[i];
            second[i] -= g[0] * a[i] + g[1] * b[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A matrix on a grid of triangles, made of a positive block for every vertex and every edge, and its product with
    /// `x`.
    fn system(side: usize, seed: &[f64], x: &[DVec2]) -> (Fronts, Matrix<f32>, Vec<DVec2>, Vec<u32>) {
        let at = |r: usize, c: usize| (r * side + c) as u32;
        let cells = (0..side - 1).flat_map(|r| (0..side - 1).map(move |c| (r, c)));
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|(r, c)| [[at(r, c), at(r, c + 1), at(r + 1, c)], [at(r + 1, c + 1), at(r + 1, c), at(r, c + 1)]])
            .collect();
        let n = side * side;
        let graph = Graph::of_groups(n, triangles.iter().map(|t| &t[..]));
        let points: Vec<Vec2> = (0..n).map(|v| Vec2::new((v % side) as f32, (v / side) as f32)).collect();
        let (fronts, order) = Fronts::new(&graph, &points);
        let mut place = vec![0u32; n];
        order.iter().enumerate().for_each(|(i, &v)| place[v as usize] = i as u32);
        let (mut matrix, mut product) = (fronts.matrix(), vec![DVec2::ZERO; n]);
        let mut add = |v: usize, u: usize, block: DMat2| {
            product[place[v] as usize] += block * x[place[u] as usize];
            let (a, b) = (place[v], place[u]);
            if a >= b {
                matrix.add(fronts.slot(a, b), fronts.stride(b), block);
            }
        };
        for v in 0..n {
            add(v, v, DMat2::from_diagonal(DVec2::splat(0.5)));
            for &u in graph.of(v).iter().filter(|u| **u as usize > v) {
                let way = DVec2::from_angle(seed[(v + u as usize) % seed.len()]);
                let spring = DMat2::from_cols(way * way.x, way * way.y);
                add(v, v, spring);
                add(u as usize, u as usize, spring);
                add(v, u as usize, -spring);
                add(u as usize, v, -spring);
            }
        }
        (fronts, matrix, product, order)
    }

    proptest! {
        #[test]
        fn a_solve_undoes_the_matrix(side in 2usize..14, seed in prop::collection::vec(0.0..6.0f64, 5)) {
            let x: Vec<DVec2> = (0..side * side).map(|v| DVec2::new((v % 7) as f64 - 3.0, (v % 5) as f64)).collect();
            let (fronts, mut matrix, mut right, _) = system(side, &seed, &x);
            prop_assert!(fronts.factor(&mut matrix));
            fronts.solve(&mut matrix, &mut right);
            for (own, wished) in right.iter().zip(&x) {
                prop_assert!(own.distance(*wished) < 1e-3, "{own} {wished}");
            }
        }
    }

    #[test]
    fn what_is_not_definite_has_no_factor() {
        for bad in [-100.0, f64::NAN] {
            let (fronts, mut matrix, ..) = system(6, &[0.3], &[DVec2::ZERO; 36]);
            matrix.add(fronts.slot(20, 20), fronts.stride(20), DMat2::from_diagonal(DVec2::splat(bad)));
            assert!(!fronts.factor(&mut matrix));
        }
    }
}
