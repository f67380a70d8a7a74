//! A Cholesky factor over blocks, for two right-hand sides at once.
//!
//! Multifrontal (Duff and Reid 1983; Liu 1992, "The Multifrontal Method for Sparse Matrix Solution"): every block of
//! the dissection is factored as one small dense matrix and hands what it leaves to its parent. Of a block's columns
//! `[L11; L21]` the factor keeps the panel `[L11^-1; -L21 L11^-1]`, so that both halves of a solve are plain products
//! with it, without a chain of divisions. Computed in 64 bits and kept in 32: a solve is bound by reading the factor,
//! and those who need more digits iterate on the residual.

use glam::Vec2;

use super::Graph;
use super::dissection::Dissection;

/// Rows of a panel that are kept side by side: whole vector registers.
const LANES: usize = 8;
type Lanes = [f32; LANES];

#[derive(Clone, Copy, Debug)]
struct Block {
    /// First column, and how many.
    first: u32,
    len: u32,
    /// Where its rows below lie in `rows`, and how many they are.
    rows: u32,
    below: u32,
    /// Where its panel begins in a factor: groups of [`LANES`] rows, in each group the columns one after the other.
    values: u32,
    parent: u32,
}

const NONE: u32 = u32::MAX;

/// What depends on the graph alone: the order, and where the factor has entries.
#[derive(Clone, Debug)]
pub(crate) struct Symbolic {
    /// The vertices as they are eliminated.
    order: Vec<u32>,
    /// The place of each vertex in that order.
    place: Vec<u32>,
    blocks: Vec<Block>,
    rows: Vec<u32>,
    values: usize,
    /// The most rows of a panel, in groups.
    most: usize,
}

impl Block {
    fn panel(&self) -> std::ops::Range<usize> {
        let groups = ((self.len + self.below) as usize).div_ceil(LANES);
        self.values as usize..self.values as usize + groups * self.len as usize
    }

    fn own(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.len) as usize
    }

    fn rows<'a>(&self, symbolic: &'a Symbolic) -> &'a [u32] {
        &symbolic.rows[self.rows as usize..(self.rows + self.below) as usize]
    }
}

impl Symbolic {
    /// Orders `graph`, whose vertices lie at `points`.
    pub(crate) fn new(graph: &Graph, points: &[Vec2]) -> Self {
        let dissection = Dissection::new(graph, points);
        let n = graph.len();
        let mut place = vec![0u32; n];
        for (i, &v) in dissection.order.iter().enumerate() {
            place[v as usize] = i as u32;
        }
        let count = dissection.blocks.len();
        let mut blocks: Vec<Block> = Vec::with_capacity(count);
        let mut rows = Vec::new();
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); count];
        let mut seen = vec![NONE; n];
        let (mut values, mut most) = (0, 0);
        for (b, block) in dissection.blocks.iter().enumerate() {
            let end = (block.first + block.len) as u32;
            let start = rows.len();
            let mut add = |r: u32, rows: &mut Vec<u32>| {
                if r >= end && seen[r as usize] != b as u32 {
                    seen[r as usize] = b as u32;
                    rows.push(r);
                }
            };
            for c in block.first..block.first + block.len {
                graph.of(dissection.order[c] as usize).iter().for_each(|&u| add(place[u as usize], &mut rows));
            }
            for &child in &children[b] {
                let child = blocks[child as usize];
                for k in child.rows..child.rows + child.below {
                    let r = rows[k as usize];
                    add(r, &mut rows);
                }
            }
            rows[start..].sort_unstable();
            if let Some(parent) = block.parent {
                children[parent].push(b as u32);
            }
            let below = rows.len() - start;
            let groups = (block.len + below).div_ceil(LANES);
            most = most.max(groups);
            blocks.push(Block {
                first: block.first as u32,
                len: block.len as u32,
                rows: start as u32,
                below: below as u32,
                values: values as u32,
                parent: block.parent.map_or(NONE, |p| p as u32),
            });
            values += block.len * groups;
        }
        Self { order: dissection.order, place, blocks, rows, values, most }
    }

    /// The vertices as they are eliminated.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// The place of each vertex in that order.
    pub(crate) fn place(&self) -> &[u32] {
        &self.place
    }

    /// How many blocks there are.
    pub(super) fn count(&self) -> usize {
        self.blocks.len()
    }

    /// A block's columns, its rows below them, and its parent.
    pub(super) fn block(&self, b: usize) -> (std::ops::Range<usize>, &[u32], Option<usize>) {
        let block = &self.blocks[b];
        (block.own(), block.rows(self), (block.parent != NONE).then_some(block.parent as usize))
    }

    /// The ranges of the order that lie under one another in the tree of elimination, at most `most` vertices each:
    /// parts of the graph that hang together. Vertices between them belong to none.
    pub(crate) fn parts(&self, most: usize) -> Vec<std::ops::Range<usize>> {
        let mut size: Vec<usize> = self.blocks.iter().map(|b| b.len as usize).collect();
        for b in 0..self.blocks.len() {
            if self.blocks[b].parent != NONE {
                size[self.blocks[b].parent as usize] += size[b];
            }
        }
        let whole = |b: usize| {
            size[b] <= most && (self.blocks[b].parent == NONE || size[self.blocks[b].parent as usize] > most)
        };
        let end = |b: usize| (self.blocks[b].first + self.blocks[b].len) as usize;
        (0..self.blocks.len()).filter(|&b| whole(b)).map(|b| end(b) - size[b]..end(b)).collect()
    }

    /// Factors the matrix with `diagonal` entries for each vertex and `off` ones for each entry of `graph`, in the
    /// graph's own numbering. `None` when it is not positive definite.
    pub(crate) fn factor(&self, graph: &Graph, diagonal: &[f64], off: &[f64]) -> Option<Factor> {
        let mut values = vec![[0f32; LANES]; self.values];
        let mut local = vec![0u32; self.place.len()];
        // What finished blocks leave, in the order in which their parents ask for it.
        let mut left: Vec<(usize, Vec<f64>)> = Vec::new();
        let mut spare: Vec<Vec<f64>> = Vec::new();
        let mut front: Vec<f64> = Vec::new();
        for (b, block) in self.blocks.iter().enumerate() {
            let (k, m) = (block.len as usize, block.below as usize);
            let size = k + m;
            let rows = &self.rows[block.rows as usize..(block.rows + block.below) as usize];
            for i in 0..k {
                local[block.first as usize + i] = i as u32;
            }
            for (i, &r) in rows.iter().enumerate() {
                local[r as usize] = (k + i) as u32;
            }
            front.clear();
            front.resize(size * size, 0.0);
            for c in 0..k {
                let v = self.order[block.first as usize + c] as usize;
                front[c * size + c] = diagonal[v];
                let range = graph.range(v);
                for (&u, &value) in graph.of(v).iter().zip(&off[range]) {
                    let r = self.place[u as usize];
                    if r > block.first + c as u32 {
                        front[c * size + local[r as usize] as usize] = value;
                    }
                }
            }
            while let Some((child, update)) = left.pop_if(|(child, _)| self.blocks[*child].parent == b as u32) {
                let child = &self.blocks[child];
                let from = &self.rows[child.rows as usize..(child.rows + child.below) as usize];
                let n = from.len();
                for (j, &c) in from.iter().enumerate() {
                    let column = local[c as usize] as usize * size;
                    for (i, &r) in from.iter().enumerate().skip(j) {
                        front[column + local[r as usize] as usize] += update[j * n + i];
                    }
                }
                spare.push(update);
            }
            eliminate(&mut front, size, k)?;
            invert(&mut front, size, k);
            let out = &mut values[block.panel()];
            for j in 0..k {
                for i in j..size {
                    out[i / LANES * k + j][i % LANES] = front[j * size + i] as f32;
                }
            }
            if m > 0 {
                let mut update = spare.pop().unwrap_or_default();
                update.clear();
                for j in 0..m {
                    update.extend_from_slice(&front[(k + j) * size + k..(k + j + 1) * size]);
                }
                left.push((b, update));
            }
        }
        Some(Factor { values, room: vec![[[0.0; LANES]; 2]; self.most] })
    }
}

/// Factors the first `k` columns of a dense lower matrix of `n` columns and takes their share off the rest.
fn eliminate(a: &mut [f64], n: usize, k: usize) -> Option<()> {
    for j in 0..k {
        let (before, rest) = a.split_at_mut(j * n);
        let own = &mut rest[j..n];
        for p in 0..j {
            let other = &before[p * n + j..(p + 1) * n];
            let f = other[0];
            own.iter_mut().zip(other).for_each(|(x, y)| *x -= f * y);
        }
        // Written so that a pivot that is not a number fails as well.
        if !(own[0] > 0.0 && own[0].is_finite()) {
            return None;
        }
        let root = own[0].sqrt();
        own[0] = root;
        let inverse = 1.0 / root;
        own[1..].iter_mut().for_each(|x| *x *= inverse);
    }
    let (done, rest) = a.split_at_mut(k * n);
    for j in k..n {
        let own = &mut rest[(j - k) * n + j..(j - k + 1) * n];
        let mut p = 0;
        while p + 4 <= k {
            let column = |p: usize| &done[p * n + j..(p + 1) * n];
            let (a, b, c, d) = (column(p), column(p + 1), column(p + 2), column(p + 3));
            let f = [a[0], b[0], c[0], d[0]];
            for ((((x, a), b), c), d) in own.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                *x -= (f[0] * a + f[1] * b) + (f[2] * c + f[3] * d);
            }
            p += 4;
        }
        for p in p..k {
            let other = &done[p * n + j..(p + 1) * n];
            let f = other[0];
            own.iter_mut().zip(other).for_each(|(x, y)| *x -= f * y);
        }
    }
    Some(())
}

/// Makes `[L11^-1; -L21 L11^-1]` of the first `k` columns `[L11; L21]`.
fn invert(a: &mut [f64], n: usize, k: usize) {
    // Column j of the panel P is e_j / l_jj minus the columns after it, times what row j of L11 asks of them.
    for j in (0..k).rev() {
        let (before, after) = a.split_at_mut((j + 1) * n);
        let own = &mut before[j * n..];
        let inverse = 1.0 / own[j];
        let mut column = vec![0.0; n - j];
        column[0] = inverse;
        for i in k..n {
            column[i - j] = -own[i] * inverse;
        }
        for p in j + 1..k {
            let f = own[p] * inverse;
            let other = &after[(p - j - 1) * n + p..(p - j) * n];
            column[p - j..].iter_mut().zip(other).for_each(|(x, y)| *x -= f * y);
        }
        own[j..].copy_from_slice(&column);
    }
}

/// Entries of complex columns, by row in the order of elimination.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    starts: Vec<u32>,
    filled: Vec<u32>,
    /// Column and value; a column may appear twice in a row.
    entries: Vec<(u32, Vec2)>,
}

impl Rows {
    /// Room for an entry in the row of each corner of `triangles`.
    pub(crate) fn new(rows: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = vec![0u32; rows + 1];
        triangles.iter().flatten().for_each(|&v| starts[v as usize + 1] += 1);
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        Self { filled: starts.clone(), starts, entries: vec![(0, Vec2::ZERO); 3 * triangles.len()] }
    }

    pub(crate) fn add(&mut self, row: u32, column: u32, value: Vec2) {
        let at = &mut self.filled[row as usize];
        self.entries[*at as usize] = (column, value);
        *at += 1;
    }

    fn of(&self, from: usize, to: usize) -> &[(u32, Vec2)] {
        &self.entries[self.starts[from] as usize..self.starts[to] as usize]
    }
}

/// The factor of one matrix.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    values: Vec<Lanes>,
    /// Room for the rows of one panel, x and y.
    room: Vec<[Lanes; 2]>,
}

impl Factor {
    /// Solves for two right-hand sides, given and returned in the order of elimination.
    pub(crate) fn solve(&mut self, symbolic: &Symbolic, u: &mut [Vec2]) {
        for block in &symbolic.blocks {
            let (k, panel) = (block.len as usize, &self.values[block.panel()]);
            let rows = block.rows(symbolic);
            let groups = panel.len() / k;
            let room = &mut self.room[..groups];
            let own = &u[block.own()];
            for (room, group) in room.iter_mut().zip(panel.chunks_exact(k)) {
                let (mut x, mut y) = ([0f32; LANES], [0f32; LANES]);
                for (column, v) in group.iter().zip(own) {
                    for l in 0..LANES {
                        x[l] += column[l] * v.x;
                        y[l] += column[l] * v.y;
                    }
                }
                *room = [x, y];
            }
            for (i, v) in u[block.own()].iter_mut().enumerate() {
                let [x, y] = &room[i / LANES];
                *v = Vec2::new(x[i % LANES], y[i % LANES]);
            }
            for (i, &r) in (k..).zip(rows) {
                let [x, y] = &room[i / LANES];
                u[r as usize] += Vec2::new(x[i % LANES], y[i % LANES]);
            }
        }
        for block in symbolic.blocks.iter().rev() {
            let (k, panel) = (block.len as usize, &self.values[block.panel()]);
            let rows = block.rows(symbolic);
            let groups = panel.len() / k;
            let room = &mut self.room[..groups];
            // What padding is multiplied with must be a number.
            room[groups - 1] = [[0.0; LANES]; 2];
            for (i, v) in u[block.own()].iter().enumerate() {
                let [x, y] = &mut room[i / LANES];
                (x[i % LANES], y[i % LANES]) = (v.x, v.y);
            }
            for (i, &r) in (k..).zip(rows) {
                let v = u[r as usize];
                let [x, y] = &mut room[i / LANES];
                (x[i % LANES], y[i % LANES]) = (v.x, v.y);
            }
            for (j, v) in u[block.own()].iter_mut().enumerate() {
                let (mut sx, mut sy) = ([0f32; LANES], [0f32; LANES]);
                for (column, [x, y]) in panel[j..].iter().step_by(k).zip(room.iter()) {
                    for l in 0..LANES {
                        sx[l] += column[l] * x[l];
                        sy[l] += column[l] * y[l];
                    }
                }
                *v = Vec2::new(total(&sx), total(&sy));
            }
        }
    }

    /// `B* A^-1 B` for `count` complex columns `B`, of which each row holds few. Row by row, real and imaginary.
    ///
    /// Only the first half of a solve is needed, and only in the blocks on the way from a column's entries to the
    /// root; columns numbered along the order keep those a range.
    pub(crate) fn gram(&self, symbolic: &Symbolic, count: usize, rows: &Rows) -> Vec<[f64; 2]> {
        let mut gram = vec![[0f64; 2]; count * count];
        let mut sums = vec![[0f32; 2]; count * count];
        let mut left: Vec<(usize, usize, usize, Vec<f32>)> = Vec::new();
        let mut local = vec![0u32; symbolic.place.len()];
        for (b, block) in symbolic.blocks.iter().enumerate() {
            let (k, m) = (block.len as usize, block.below as usize);
            let first = block.first as usize;
            let mut range = rows
                .of(first, first + k)
                .iter()
                .fold((count, 0), |r, e| (r.0.min(e.0 as usize), r.1.max(e.0 as usize + 1)));
            let children = left.iter().rev().take_while(|l| symbolic.blocks[l.0].parent == b as u32).count();
            let children = left.split_off(left.len() - children);
            range = children.iter().fold(range, |r, c| (r.0.min(c.1), r.1.max(c.2)));
            if range.0 >= range.1 {
                continue;
            }
            let (low, wide) = (range.0, range.1 - range.0);
            let stride = 2 * wide;
            let below = &symbolic.rows[block.rows as usize..block.rows as usize + m];
            for i in 0..k {
                local[first + i] = i as u32;
            }
            for (i, &r) in below.iter().enumerate() {
                local[r as usize] = (k + i) as u32;
            }
            let mut w = vec![0f32; (k + m) * stride];
            for i in 0..k {
                for (c, v) in rows.of(first + i, first + i + 1) {
                    w[i * stride + *c as usize - low] += v.x;
                    w[i * stride + wide + *c as usize - low] += v.y;
                }
            }
            for (child, from, to, update) in children {
                let child = &symbolic.blocks[child];
                let n = to - from;
                let to_rows = &symbolic.rows[child.rows as usize..(child.rows + child.below) as usize];
                for (r, values) in to_rows.iter().zip(update.chunks_exact(2 * n)) {
                    let at = local[*r as usize] as usize * stride + from - low;
                    w[at..at + n].iter_mut().zip(&values[..n]).for_each(|(w, v)| *w += v);
                    w[at + wide..at + wide + n].iter_mut().zip(&values[n..]).for_each(|(w, v)| *w += v);
                }
            }
            let panel = &self.values[block.panel()];
            let (own, rest) = w.split_at_mut(k * stride);
            let given = own.to_vec();
            own.fill(0.0);
            for (i, row) in own.chunks_exact_mut(stride).chain(rest.chunks_exact_mut(stride)).enumerate() {
                for (j, from) in given.chunks_exact(stride).enumerate().take(if i < k { i + 1 } else { k }) {
                    let f = panel[i / LANES * k + j][i % LANES];
                    row.iter_mut().zip(from).for_each(|(r, o)| *r += f * o);
                }
            }
            for row in w[..k * stride].chunks_exact(stride) {
                let (re, im) = row.split_at(wide);
                for a in 0..wide {
                    let (ar, ai) = (re[a], im[a]);
                    if ar == 0.0 && ai == 0.0 {
                        continue;
                    }
                    let sums = &mut sums[(low + a) * count + low + a..(low + a) * count + low + wide];
                    for ((s, br), bi) in sums.iter_mut().zip(&re[a..]).zip(&im[a..]) {
                        s[0] += ar * br + ai * bi;
                        s[1] += ar * bi - ai * br;
                    }
                }
            }
            if m > 0 {
                left.push((b, low, low + wide, w.split_off(k * stride)));
            }
        }
        for a in 0..count {
            for b in a..count {
                let [re, im] = sums[a * count + b];
                gram[a * count + b] = [f64::from(re), f64::from(im)];
                gram[b * count + a] = [f64::from(re), -f64::from(im)];
            }
        }
        gram
    }
}

fn total(lanes: &Lanes) -> f32 {
    ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;
    use proptest::prelude::*;

    /// A Laplacian plus something on the diagonal, on a jagged strip of triangles.
    fn system(n: usize, seed: &[f64]) -> (Graph, Vec<Vec2>, Vec<f64>, Vec<f64>) {
        let points: Vec<Vec2> = (0..n).map(|i| vec2((i / 2) as f32, (i % 2) as f32 + 0.1 * (i % 7) as f32)).collect();
        let triangles: Vec<[u32; 3]> = (0..n as u32 - 2).map(|i| [i, i + 1, i + 2]).collect();
        let graph = Graph::of_groups(n, triangles.iter().map(|t| &t[..]));
        let mut diagonal: Vec<f64> = (0..n).map(|i| 0.05 + seed[i % seed.len()].abs()).collect();
        let mut off = vec![0.0; graph.entries()];
        for v in 0..n {
            for (&u, entry) in graph.of(v).iter().zip(graph.range(v)) {
                off[entry] = -1.0 - ((v + u as usize) % 3) as f64;
                diagonal[v] -= off[entry];
            }
        }
        (graph, points, diagonal, off)
    }

    proptest! {
        #[test]
        fn a_solve_undoes_the_matrix(n in 3usize..200, seed in prop::collection::vec(-1.0f64..1.0, 5)) {
            let (graph, points, diagonal, off) = system(n, &seed);
            let symbolic = Symbolic::new(&graph, &points);
            let mut factor = symbolic.factor(&graph, &diagonal, &off).expect("definite");
            let wished: Vec<Vec2> = (0..n).map(|i| vec2((i as f32).sin(), seed[i % 5] as f32)).collect();
            let mut u = vec![Vec2::ZERO; n];
            for v in 0..n {
                let sum: glam::DVec2 = graph.of(v).iter().zip(graph.range(v)).map(|(&w, e)| wished[w as usize].as_dvec2() * off[e]).sum();
                u[symbolic.place()[v] as usize] = (sum + wished[v].as_dvec2() * diagonal[v]).as_vec2();
            }
            factor.solve(&symbolic, &mut u);
            for v in 0..n {
                prop_assert!(u[symbolic.place()[v] as usize].distance(wished[v]) < 2e-3);
            }
        }

        #[test]
        fn the_gram_matrix_is_what_solves_give(n in 3usize..120, seed in prop::collection::vec(-1.0f64..1.0, 5)) {
            let (graph, points, diagonal, off) = system(n, &seed);
            let symbolic = Symbolic::new(&graph, &points);
            let mut factor = symbolic.factor(&graph, &diagonal, &off).expect("definite");
            let triangles: Vec<[u32; 3]> = (0..n as u32 - 2).map(|i| [i, i + 1, i + 2]).collect();
            let count = 1 + n / 20;
            let mut rows = Rows::new(n, &triangles);
            let mut columns = vec![vec![Vec2::ZERO; n]; count];
            for (t, triangle) in triangles.iter().enumerate() {
                for &v in triangle {
                    let (column, value) = (t * count / triangles.len(), vec2(seed[t % 5] as f32, 0.3 * (v % 4) as f32));
                    rows.add(v, column as u32, value);
                    columns[column][v as usize] += value;
                }
            }
            let gram = factor.gram(&symbolic, count, &rows);
            for b in 0..count {
                let mut solved = columns[b].clone();
                factor.solve(&symbolic, &mut solved);
                for a in 0..count {
                    let (mut re, mut im) = (0.0, 0.0);
                    for (x, y) in columns[a].iter().zip(&solved) {
                        re += f64::from(x.dot(*y));
                        im += f64::from(x.perp_dot(*y));
                    }
                    let size = 1e-3 * (gram[a * count + a][0] * gram[b * count + b][0]).sqrt() + 1e-3;
                    prop_assert!((gram[a * count + b][0] - re).abs() < size && (gram[a * count + b][1] - im).abs() < size);
                }
            }
        }
    }

    #[test]
    fn what_is_not_definite_has_no_factor() {
        let (graph, points, mut diagonal, off) = system(30, &[0.1]);
        diagonal[7] = -1.0;
        assert!(Symbolic::new(&graph, &points).factor(&graph, &diagonal, &off).is_none());
        diagonal[7] = f64::NAN;
        assert!(Symbolic::new(&graph, &points).factor(&graph, &diagonal, &off).is_none());
    }
}
