//! Exact minimum cut on an image grid with eight neighbours.
//!
//! Boykov and Kolmogorov 2004, "An Experimental Comparison of Min-Cut/Max-Flow Algorithms": two search trees, from
//! the source and from the sink, grow until they touch, flow is sent along the path, and nodes cut off by it are
//! adopted again. Capacities are integers, so the cut is the same on every machine. The grid is implicit, with a rim
//! of nodes without capacity, so that no neighbour lookup needs a bounds check.

use std::collections::VecDeque;

/// Directions in pairs: `d ^ 1` is the reverse of `d`.
const DIRECTIONS: usize = 8;
/// Parent codes beyond directions.
const TERMINAL: u8 = 8;
const ORPHAN: u8 = 9;
const NONE: u8 = 10;
/// Trees.
const FREE: u8 = 0;
const SOURCE: u8 = 1;
const SINK: u8 = 2;

/// A neighbour as a step: right, below, below right, below left. Each edge is given once, from its upper or left end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Neighbour {
    Right,
    Below,
    BelowRight,
    BelowLeft,
}

/// A cut problem over `width * height` pixels.
pub(crate) struct GridCut {
    width: usize,
    height: usize,
    offsets: [isize; DIRECTIONS],
    /// Capacity left from a node in each direction.
    residual: Vec<[i32; DIRECTIONS]>,
    /// Capacity left from the source (positive) or to the sink (negative).
    terminal: Vec<i32>,
    tree: Vec<u8>,
    parent: Vec<u8>,
    /// When the distance to the terminal was last confirmed, and that distance.
    confirmed: Vec<u32>,
    distance: Vec<u32>,
    queued: Vec<bool>,
    active: VecDeque<u32>,
    orphans: VecDeque<u32>,
    time: u32,
}

impl GridCut {
    /// A problem without any capacity.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let stride = (width + 2) as isize;
        let nodes = (width + 2) * (height + 2);
        Self {
            width,
            height,
            offsets: [1, -1, stride, -stride, stride + 1, -stride - 1, stride - 1, 1 - stride],
            residual: vec![[0; DIRECTIONS]; nodes],
            terminal: vec![0; nodes],
            tree: vec![FREE; nodes],
            parent: vec![NONE; nodes],
            confirmed: vec![0; nodes],
            distance: vec![0; nodes],
            queued: vec![false; nodes],
            active: VecDeque::new(),
            orphans: VecDeque::new(),
            time: 0,
        }
    }

    fn node(&self, x: usize, y: usize) -> usize {
        (y + 1) * (self.width + 2) + x + 1
    }

    /// Adds to what it costs to put the pixel on the sink's side (positive) or on the source's side (negative).
    pub(crate) fn add_terminal(&mut self, x: usize, y: usize, cost: i32) {
        let node = self.node(x, y);
        self.terminal[node] = self.terminal[node].saturating_add(cost);
    }

    /// Sets what it costs to part the pixel from its neighbour, which must be inside the grid.
    pub(crate) fn set_edge(&mut self, x: usize, y: usize, to: Neighbour, cost: i32) {
        let node = self.node(x, y);
        let direction = match to {
            Neighbour::Right => 0,
            Neighbour::Below => 2,
            Neighbour::BelowRight => 4,
            Neighbour::BelowLeft => 6,
        };
        let other = self.step(node, direction);
        self.residual[node][direction] = cost.max(0);
        self.residual[other][direction ^ 1] = cost.max(0);
    }

    #[inline]
    fn step(&self, node: usize, direction: usize) -> usize {
        node.wrapping_add_signed(self.offsets[direction])
    }

    fn activate(&mut self, node: usize) {
        if !self.queued[node] {
            self.queued[node] = true;
            self.active.push_back(node as u32);
        }
    }

    /// Finds the minimum cut.
    pub(crate) fn solve(&mut self) {
        for y in 0..self.height {
            for x in 0..self.width {
                let node = self.node(x, y);
                if self.terminal[node] != 0 {
                    self.tree[node] = if self.terminal[node] > 0 { SOURCE } else { SINK };
                    self.parent[node] = TERMINAL;
                    self.distance[node] = 1;
                    self.activate(node);
                }
            }
        }
        while let Some(&front) = self.active.front() {
            let node = front as usize;
            let meeting = if self.tree[node] == FREE { None } else { self.grow(node) };
            match meeting {
                // The node stays in front: it may touch the other tree again.
                Some((from, direction)) => {
                    self.time += 1;
                    self.augment(from, direction);
                    self.adopt();
                }
                None => {
                    self.active.pop_front();
                    self.queued[node] = false;
                }
            }
        }
    }

    /// Whether the pixel is on the source's side. Pixels that neither side reaches are not.
    pub(crate) fn on_source_side(&self, x: usize, y: usize) -> bool {
        self.tree[self.node(x, y)] == SOURCE
    }

    /// Grows the tree at `node`; the edge from the source's tree to the sink's, where they touch.
    fn grow(&mut self, node: usize) -> Option<(usize, usize)> {
        let tree = self.tree[node];
        for direction in 0..DIRECTIONS {
            let other = self.step(node, direction);
            let left =
                if tree == SOURCE { self.residual[node][direction] } else { self.residual[other][direction ^ 1] };
            if left <= 0 {
                continue;
            }
            if self.tree[other] == FREE {
                self.tree[other] = tree;
                self.parent[other] = (direction ^ 1) as u8;
                self.confirmed[other] = self.confirmed[node];
                self.distance[other] = self.distance[node] + 1;
                self.activate(other);
            } else if self.tree[other] != tree {
                return Some(if tree == SOURCE { (node, direction) } else { (other, direction ^ 1) });
            } else if self.confirmed[other] <= self.confirmed[node] && self.distance[other] > self.distance[node] + 1 {
                self.parent[other] = (direction ^ 1) as u8;
                self.confirmed[other] = self.confirmed[node];
                self.distance[other] = self.distance[node] + 1;
            }
        }
        None
    }

    /// Sends as much flow as fits through the edge and the two tree paths that it joins.
    fn augment(&mut self, from: usize, direction: usize) {
        let to = self.step(from, direction);
        let mut flow = self.residual[from][direction];
        let mut node = from;
        while self.parent[node] != TERMINAL {
            let up = usize::from(self.parent[node]);
            let above = self.step(node, up);
            flow = flow.min(self.residual[above][up ^ 1]);
            node = above;
        }
        flow = flow.min(self.terminal[node]);
        node = to;
        while self.parent[node] != TERMINAL {
            let up = usize::from(self.parent[node]);
            flow = flow.min(self.residual[node][up]);
            node = self.step(node, up);
        }
        flow = flow.min(-self.terminal[node]);

        self.residual[from][direction] -= flow;
        self.residual[to][direction ^ 1] += flow;
        node = from;
        while self.parent[node] != TERMINAL {
            let up = usize::from(self.parent[node]);
            let above = self.step(node, up);
            self.residual[above][up ^ 1] -= flow;
            self.residual[node][up] += flow;
            if self.residual[above][up ^ 1] == 0 {
                self.orphans.push_back(node as u32);
            }
            node = above;
        }
        self.terminal[node] -= flow;
        if self.terminal[node] == 0 {
            self.orphans.push_back(node as u32);
        }
        node = to;
        while self.parent[node] != TERMINAL {
            let up = usize::from(self.parent[node]);
            let above = self.step(node, up);
            self.residual[node][up] -= flow;
            self.residual[above][up ^ 1] += flow;
            if self.residual[node][up] == 0 {
                self.orphans.push_back(node as u32);
            }
            node = above;
        }
        self.terminal[node] += flow;
        if self.terminal[node] == 0 {
            self.orphans.push_back(node as u32);
        }
    }

    /// Finds new parents for nodes that were cut off, or sets them free.
    fn adopt(&mut self) {
        // Only now: the walks of `augment` needed the old parents.
        for i in 0..self.orphans.len() {
            let node = self.orphans[i] as usize;
            self.parent[node] = ORPHAN;
        }
        while let Some(front) = self.orphans.pop_front() {
            let node = front as usize;
            let tree = self.tree[node];
            let mut best: Option<(u32, usize)> = None;
            for direction in 0..DIRECTIONS {
                let other = self.step(node, direction);
                if self.tree[other] != tree || self.capacity_toward(node, direction, tree) <= 0 {
                    continue;
                }
                if let Some(distance) = self.distance_to_terminal(other)
                    && best.is_none_or(|(d, _)| distance < d)
                {
                    best = Some((distance, direction));
                }
            }
            if let Some((distance, direction)) = best {
                self.parent[node] = direction as u8;
                self.confirmed[node] = self.time;
                self.distance[node] = distance + 1;
                continue;
            }
            for direction in 0..DIRECTIONS {
                let other = self.step(node, direction);
                if self.tree[other] != tree {
                    continue;
                }
                if self.capacity_toward(node, direction, tree) > 0 {
                    self.activate(other);
                }
                if usize::from(self.parent[other]) == direction ^ 1 {
                    self.parent[other] = ORPHAN;
                    self.orphans.push_back(other as u32);
                }
            }
            self.tree[node] = FREE;
            self.parent[node] = NONE;
        }
    }

    /// Capacity of the edge that would join `node` to its neighbour as a child in `tree`.
    fn capacity_toward(&self, node: usize, direction: usize, tree: u8) -> i32 {
        if tree == SOURCE {
            self.residual[self.step(node, direction)][direction ^ 1]
        } else {
            self.residual[node][direction]
        }
    }

    /// How far the node is from its terminal along its tree; `None` when the path ends in an orphan.
    fn distance_to_terminal(&mut self, start: usize) -> Option<u32> {
        let (mut node, mut steps) = (start, 0u32);
        let total = loop {
            if self.confirmed[node] == self.time {
                break steps + self.distance[node];
            }
            match self.parent[node] {
                TERMINAL => {
                    self.confirmed[node] = self.time;
                    self.distance[node] = 1;
                    break steps + 1;
                }
                ORPHAN | NONE => return None,
                up => {
                    steps += 1;
                    node = self.step(node, usize::from(up));
                }
            }
        };
        let (mut node, mut distance) = (start, total);
        while self.confirmed[node] != self.time {
            self.confirmed[node] = self.time;
            self.distance[node] = distance;
            distance -= 1;
            node = self.step(node, usize::from(self.parent[node]));
        }
        Some(total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const EDGES: [(Neighbour, isize, isize); 4] = [
        (Neighbour::Right, 1, 0),
        (Neighbour::Below, 0, 1),
        (Neighbour::BelowRight, 1, 1),
        (Neighbour::BelowLeft, -1, 1),
    ];

    fn energy(labels: u32, w: usize, h: usize, terminals: &[i32], edges: &[i32]) -> i64 {
        let label = |x: usize, y: usize| labels >> (y * w + x) & 1 == 1;
        let mut sum = 0i64;
        for y in 0..h {
            for x in 0..w {
                let t = i64::from(terminals[y * w + x]);
                sum += if label(x, y) { (-t).max(0) } else { t.max(0) };
                for (k, (_, dx, dy)) in EDGES.iter().enumerate() {
                    let (nx, ny) = (x as isize + dx, y as isize + dy);
                    if nx >= 0
                        && (nx as usize) < w
                        && (ny as usize) < h
                        && label(x, y) != label(nx as usize, ny as usize)
                    {
                        sum += i64::from(edges[(y * w + x) * 4 + k]);
                    }
                }
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn no_labelling_is_cheaper(
            terminals in prop::collection::vec(-40i32..40, 12),
            edges in prop::collection::vec(0i32..25, 48),
        ) {
            let (w, h) = (4, 3);
            let mut cut = GridCut::new(w, h);
            for y in 0..h {
                for x in 0..w {
                    cut.add_terminal(x, y, terminals[y * w + x]);
                    for (k, (to, dx, dy)) in EDGES.into_iter().enumerate() {
                        let (nx, ny) = (x as isize + dx, y as isize + dy);
                        if nx >= 0 && (nx as usize) < w && (ny as usize) < h {
                            cut.set_edge(x, y, to, edges[(y * w + x) * 4 + k]);
                        }
                    }
                }
            }
            cut.solve();
            let mut labels = 0u32;
            for y in 0..h {
                for x in 0..w {
                    labels |= u32::from(cut.on_source_side(x, y)) << (y * w + x);
                }
            }
            let best = (0..1u32 << (w * h)).map(|l| energy(l, w, h, &terminals, &edges)).min();
            prop_assert_eq!(Some(energy(labels, w, h, &terminals, &edges)), best);
        }
    }
}
