//! Makes what a field on a grid encloses one ball: in one piece, without handles or hollows, so that its surface is a sphere
//! however it is bent.
//!
//! Method: region growing by simple points, as in the topology correction of brain surfaces (Han et al. 2002). From a seed the
//! ball takes the samples of the inside one by one, those of lowest rank first, each only if that changes no topology
//! (Bertrand 1994: one component of the inside and one of the outside around it, for the pair of connectivities that
//! [`super::iso_surface()`] draws: 6 inside, 18 outside). What two fronts leave between them is cut by a gap of one sample.
//! Hollows are filled before.
//!
//! Limits: what does not hang together with the seed is dropped; a real hole is cut open where its ring ranks highest.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Field3;

/// What a changed sample is worth, in cells on the other side of the level: small, so that the gap is narrow.
const BESIDE: f32 = 0.25;

/// Bits of the 27 samples around one; x runs fastest, then y, then z, and bit 13 is the sample itself.
const AROUND: u32 = 0x7ff_ffff & !(1 << 13);
/// Those that share a side with the middle, and those that share a side or an edge.
const SIDES: u32 = beside_middle(1);
const EDGES: u32 = beside_middle(2);
/// For each of the 27 those of the other 26 around the middle at a side's distance, and at an edge's or less.
const BY_SIDE: [u32; 27] = neighbours(1);
const BY_EDGE: [u32; 27] = neighbours(2);

const fn apart(a: usize, b: usize) -> usize {
    let (x, y, z) = ((a % 3).abs_diff(b % 3), (a / 3 % 3).abs_diff(b / 3 % 3), (a / 9).abs_diff(b / 9));
    // Steps in all, or too many to touch.
    if x > 1 || y > 1 || z > 1 { 9 } else { x + y + z }
}

const fn neighbours(steps: usize) -> [u32; 27] {
    let mut out = [0; 27];
    let mut a = 0;
    while a < 27 {
        let mut b = 0;
        while b < 27 {
            if a != b && b != 13 && apart(a, b) <= steps {
                out[a] |= 1 << b;
            }
            b += 1;
        }
        a += 1;
    }
    out
}

const fn beside_middle(steps: usize) -> u32 {
    neighbours(steps)[13]
}

/// All that lies beside some of `set`, and `set`.
fn grown(set: u32, beside: &[u32; 27]) -> u32 {
    let (mut rest, mut out) = (set, set);
    while rest != 0 {
        out |= beside[rest.trailing_zeros() as usize];
        rest &= rest - 1;
    }
    out
}

/// Whether a set is not empty and hangs together.
fn is_one(set: u32, beside: &[u32; 27]) -> bool {
    let mut part = set & set.wrapping_neg();
    loop {
        let next = grown(part, beside) & set;
        if next == part {
            return part != 0 && part == set;
        }
        part = next;
    }
}

/// Whether the middle of 27 samples can change sides without a change of topology; `inside` are those around it that are.
fn is_simple(inside: u32) -> bool {
    let outside = !inside & AROUND;
    let faces = inside & SIDES;
    let near = grown(faces, &BY_SIDE) & inside;
    let own = grown(near, &BY_SIDE) & inside;
    let free = outside & EDGES;
    let other = grown(free, &BY_EDGE) & outside;
    is_one(own, &BY_SIDE) && is_one(other, &BY_EDGE)
}

/// The samples of a grid with their 26 neighbours.
struct Samples {
    dims: [usize; 3],
    /// Steps in memory to each of the 27 around a sample.
    step: [isize; 27],
}

impl Samples {
    fn new(dims: [usize; 3]) -> Self {
        let (row, plane) = (dims[0] as isize, (dims[0] * dims[1]) as isize);
        let step = std::array::from_fn(|i| {
            let i = i as isize;
            (i % 3 - 1) + (i / 3 % 3 - 1) * row + (i / 9 - 1) * plane
        });
        Self { dims, step }
    }

    /// Whether a sample is on the grid's rim.
    fn on_rim(&self, at: usize) -> bool {
        let [nx, ny, nz] = self.dims;
        let place = [at % nx, at / nx % ny, at / (nx * ny)];
        (0..3).any(|k| place[k] == 0 || place[k] + 1 == [nx, ny, nz][k])
    }

    fn at(&self, from: usize, neighbour: usize) -> usize {
        from.wrapping_add_signed(self.step[neighbour])
    }
}

/// Changes `field` so that its inside, below `level`, is one ball that holds the sample of lowest `rank` inside. `rank` has
/// one number a sample; where two parts meet that must not, those of highest rank are given up. Returns how many samples
/// that hung together with it were cut away. The grid's rim and what is no number count as outside, as in
/// [`super::iso_surface()`].
pub fn keep_ball(field: &mut Field3, level: f32, rank: &[f32]) -> usize {
    let samples = Samples::new(field.dims);
    let n = field.values.len().min(rank.len());
    let inside: Vec<bool> = (0..n).map(|i| field.values[i] < level && !samples.on_rim(i)).collect();
    let inside = without_hollows(inside, &samples, field, level);
    let seed = (0..n).filter(|i| inside[*i]).min_by(|a, b| rank[*a].total_cmp(&rank[*b]));
    let Some(seed) = seed else { return 0 };
    let (ball, met) = grow(&inside, seed, rank, &samples);
    let mut cut = 0;
    for i in 0..n {
        if inside[i] && !ball[i] {
            field.values[i] = level + BESIDE * field.cell;
            cut += usize::from(met[i]);
        }
    }
    cut
}

/// Fills what is outside but cannot be reached from the rim.
fn without_hollows(mut inside: Vec<bool>, samples: &Samples, field: &mut Field3, level: f32) -> Vec<bool> {
    let mut open: Vec<bool> = (0..inside.len()).map(|i| samples.on_rim(i)).collect();
    let mut waiting: Vec<usize> = (0..inside.len()).filter(|i| open[*i]).collect();
    let [nx, ny, nz] = samples.dims;
    while let Some(at) = waiting.pop() {
        let place = [at % nx, at / nx % ny, at / (nx * ny)];
        for k in (0..27).filter(|k| EDGES >> k & 1 == 1) {
            let there = [place[0] + k % 3, place[1] + k / 3 % 3, place[2] + k / 9];
            if (0..3).any(|a| there[a] == 0 || there[a] > [nx, ny, nz][a]) {
                continue;
            }
            let other = samples.at(at, k);
            if !open[other] && !inside[other] {
                open[other] = true;
                waiting.push(other);
            }
        }
    }
    for i in 0..inside.len() {
        if !open[i] && !inside[i] {
            inside[i] = true;
            field.values[i] = level - BESIDE * field.cell;
        }
    }
    inside
}

/// The ball, and all samples that were looked at for it.
fn grow(inside: &[bool], seed: usize, rank: &[f32], samples: &Samples) -> (Vec<bool>, Vec<bool>) {
    let (mut ball, mut waits, mut met) =
        (vec![false; inside.len()], vec![false; inside.len()], vec![false; inside.len()]);
    let mut queue = BinaryHeap::new();
    let key = |i: usize| Reverse((Ordered(rank[i]), i));
    queue.push(key(seed));
    met[seed] = true;
    while let Some(Reverse((_, at))) = queue.pop() {
        waits[at] = false;
        let around: u32 = (0..27).filter(|k| *k != 13 && ball[samples.at(at, *k)]).map(|k| 1 << k).sum();
        if at != seed && !is_simple(around) {
            continue;
        }
        ball[at] = true;
        // A neighbour that was refused may fit now.
        for k in (0..27).filter(|k| *k != 13) {
            let other = samples.at(at, k);
            if inside[other] && !ball[other] && !waits[other] {
                (waits[other], met[other]) = (true, true);
                queue.push(key(other));
            }
        }
    }
    (ball, met)
}

#[derive(PartialEq)]
struct Ordered(f32);

impl Eq for Ordered {}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::iso_surface;
    use crate::geometry::manifold::{manifold_defect, pieces};
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;

    fn sampled(n: usize, value: impl Fn(Vec3) -> f32) -> Field3 {
        let mut field = Field3::new([n; 3], Vec3::splat(-0.5 * (n - 1) as f32), 1.0, 0.0);
        for z in 0..n {
            for y in 0..n {
                for x in 0..n {
                    let i = field.index(x, y, z);
                    field.values[i] = value(field.position(x, y, z));
                }
            }
        }
        field
    }

    fn assert_sphere(field: &Field3) -> usize {
        let (positions, triangles) = iso_surface(field, 0.0);
        assert_eq!(manifold_defect(positions.len(), &triangles), None);
        assert!(pieces(positions.len(), &triangles).iter().all(|p| *p == 0));
        assert_eq!(positions.len() as i64 - triangles.len() as i64 / 2, 2, "Euler");
        positions.len()
    }

    #[test]
    fn a_ring_is_cut_where_it_is_thinnest() {
        // Thinner toward +x.
        let ring = |p: Vec3| Vec2::new(p.truncate().length() - 12.0, p.z).length() - (4.0 - 0.15 * p.x);
        let mut field = sampled(40, ring);
        let (rank, before) = (field.values.clone(), field.clone());
        let cut = keep_ball(&mut field, 0.0, &rank);
        assert_sphere(&field);
        let changed: Vec<usize> = (0..rank.len()).filter(|i| field.values[*i] != before.values[*i]).collect();
        assert_eq!(changed.len(), cut);
        assert!(cut > 5 && cut < 60, "{cut}");
        assert!(changed.iter().all(|i| i % 40 > 25), "not at the thin side");
    }

    #[test]
    fn a_hollow_is_filled_a_loose_bit_dropped_and_a_ball_left_alone() {
        let shell = |p: Vec3| ((p.length() - 8.0).abs() - 2.0).min(p.distance(Vec3::splat(12.5)) - 1.5);
        let mut field = sampled(40, shell);
        let rank = field.values.clone();
        assert_eq!(keep_ball(&mut field, 0.0, &rank), 0);
        assert_sphere(&field);
        assert!(field.sample(Vec3::ZERO) < 0.0 && field.sample(Vec3::splat(12.5)) > 0.0);
        let mut ball = sampled(30, |p| p.length() - 9.3);
        let (rank, before) = (ball.values.clone(), ball.clone());
        assert_eq!(keep_ball(&mut ball, 0.0, &rank), 0);
        assert!(ball == before);
        let mut empty = sampled(5, |_| 1.0);
        assert_eq!(keep_ball(&mut empty, 0.0, &[1.0; 125]), 0);
    }

    proptest! {
        #[test]
        fn whatever_a_field_is_its_surface_becomes_one_sphere(
            dims in [3usize..9, 3usize..9, 3usize..9],
            share in 0.1f32..0.95,
            values in proptest::collection::vec(0.0f32..1.0, 512),
        ) {
            let mut field = Field3::new(dims, Vec3::ZERO, 1.0, 0.0);
            let n = field.values.len();
            field.values.copy_from_slice(&values[..n]);
            field.values.iter_mut().for_each(|v| *v -= share);
            let rank: Vec<f32> = values.iter().rev().copied().take(n).collect();
            let there = !iso_surface(&field, 0.0).1.is_empty();
            keep_ball(&mut field, 0.0, &rank);
            if there {
                assert_sphere(&field);
            }
        }
    }
}
