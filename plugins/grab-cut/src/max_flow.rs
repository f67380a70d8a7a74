//! Minimum cut of an image grid with eight neighbours, and which pixels are on the source's side of it.
//!
//! Boykov and Kolmogorov 2004, "An Experimental Comparison of Min-Cut/Max-Flow Algorithms for Energy Minimization in
//! Vision": a tree grows from the source and one from the sink; where they touch, flow is pushed along the joined
//! path; what that path no longer feeds looks for another parent. Distances to the terminals with time stamps keep the
//! paths short, as the paper advises. Capacities are whole numbers, so the cut is exact and the same everywhere.
//!
//! Pixels that are decided before the cut are left out of the graph, so a narrow band costs no more than its pixels.

use std::collections::VecDeque;

/// Arcs of a pixel: right, left, down, up, and the diagonals, each beside its reverse (`arc ^ 1`).
pub(crate) const ARCS: usize = 8;
const NOBODY: u8 = 255;
const TERMINAL: u8 = 254;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Tree {
    None,
    Source,
    Sink,
}

#[derive(Clone, Copy)]
struct Node {
    /// What is left of the arc to each neighbour.
    residual: [i32; ARCS],
    /// What is left from the source (positive) or to the sink (negative).
    terminal: i32,
    /// When `distance` was last known to hold.
    stamp: u32,
    /// Arcs to the terminal.
    distance: u32,
    /// The arc to the parent.
    parent: u8,
    tree: Tree,
    waiting: bool,
}

/// A cut to be found.
pub(crate) struct MaxFlow {
    width: usize,
    /// With a rim of unconnected nodes around the picture, so that every arc has an end.
    nodes: Vec<Node>,
    steps: [isize; ARCS],
    active: VecDeque<u32>,
    orphans: VecDeque<u32>,
    clock: u32,
}

impl MaxFlow {
    /// A grid of pixels without capacities.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let stride = width + 2;
        let s = stride as isize;
        let empty = Node {
            residual: [0; ARCS],
            terminal: 0,
            stamp: 0,
            distance: 0,
            parent: NOBODY,
            tree: Tree::None,
            waiting: false,
        };
        Self {
            width,
            nodes: vec![empty; stride * (height + 2)],
            steps: [1, -1, s, -s, s + 1, -s - 1, s - 1, 1 - s],
            active: VecDeque::new(),
            orphans: VecDeque::new(),
            clock: 0,
        }
    }

    fn index(&self, x: usize, y: usize) -> usize {
        (y + 1) * (self.width + 2) + x + 1
    }

    /// Adds to what the pixel costs on the sink's side (positive) or on the source's (negative).
    pub(crate) fn add_unary(&mut self, x: usize, y: usize, cost: i32) {
        let node = self.index(x, y);
        self.nodes[node].terminal = self.nodes[node].terminal.saturating_add(cost);
    }

    /// Sets the cost of parting the pixel from the neighbour at `arc` (an even one: right, down, down right, down
    /// left), which must lie inside the picture.
    pub(crate) fn set_pair(&mut self, x: usize, y: usize, arc: usize, cost: i32) {
        let node = self.index(x, y);
        let other = self.across(node, arc);
        self.nodes[node].residual[arc] = cost.max(0);
        self.nodes[other].residual[arc ^ 1] = cost.max(0);
    }

    /// Whether the pixel is on the source's side once [`Self::run`] is through.
    pub(crate) fn is_source(&self, x: usize, y: usize) -> bool {
        self.nodes[self.index(x, y)].tree == Tree::Source
    }

    #[inline]
    fn across(&self, node: usize, arc: usize) -> usize {
        node.wrapping_add_signed(self.steps[arc])
    }

    /// Finds the cut. `go_on` is asked every so often; `false` leaves the cut unfinished and is handed back.
    pub(crate) fn run(&mut self, mut go_on: impl FnMut() -> bool) -> bool {
        for node in 0..self.nodes.len() {
            let n = &mut self.nodes[node];
            if n.terminal != 0 {
                n.tree = if n.terminal > 0 { Tree::Source } else { Tree::Sink };
                n.parent = TERMINAL;
                n.distance = 1;
                n.waiting = true;
                self.active.push_back(node as u32);
            }
        }
        let mut turns = 0u32;
        while let Some(&front) = self.active.front() {
            turns += 1;
            if turns.is_multiple_of(1 << 11) && !go_on() {
                return false;
            }
            let node = front as usize;
            if self.nodes[node].tree != Tree::None
                && let Some((from, arc)) = self.grow(node)
            {
                // It stays in front: it may touch the other tree elsewhere too.
                self.clock += 1;
                self.push(from, arc);
                self.adopt();
                continue;
            }
            self.active.pop_front();
            self.nodes[node].waiting = false;
        }
        true
    }

    fn wait(&mut self, node: usize) {
        if !self.nodes[node].waiting {
            self.nodes[node].waiting = true;
            self.active.push_back(node as u32);
        }
    }

    /// Takes free neighbours into the node's tree; an arc from the source's tree into the sink's, if it touches.
    fn grow(&mut self, node: usize) -> Option<(usize, usize)> {
        let me = self.nodes[node];
        for arc in 0..ARCS {
            let other = self.across(node, arc);
            let left = if me.tree == Tree::Source { me.residual[arc] } else { self.nodes[other].residual[arc ^ 1] };
            if left == 0 {
                continue;
            }
            let beside = &mut self.nodes[other];
            if beside.tree == Tree::None {
                beside.tree = me.tree;
                beside.parent = (arc ^ 1) as u8;
                beside.stamp = me.stamp;
                beside.distance = me.distance + 1;
                self.wait(other);
            } else if beside.tree != me.tree {
                return Some(if me.tree == Tree::Source { (node, arc) } else { (other, arc ^ 1) });
            } else if beside.stamp <= me.stamp && beside.distance > me.distance + 1 {
                beside.parent = (arc ^ 1) as u8;
                beside.stamp = me.stamp;
                beside.distance = me.distance + 1;
            }
        }
        None
    }

    /// Pushes what fits along source, `from`, `arc` and sink; nodes whose arc to the parent fills up become orphans.
    fn push(&mut self, from: usize, arc: usize) {
        let to = self.across(from, arc);
        let mut flow = self.nodes[from].residual[arc];
        for (end, toward_source) in [(from, true), (to, false)] {
            let mut node = end;
            while self.nodes[node].parent != TERMINAL {
                let up = usize::from(self.nodes[node].parent);
                let parent = self.across(node, up);
                flow = flow.min(if toward_source {
                    self.nodes[parent].residual[up ^ 1]
                } else {
                    self.nodes[node].residual[up]
                });
                node = parent;
            }
            flow = flow.min(self.nodes[node].terminal.abs());
        }
        self.nodes[from].residual[arc] -= flow;
        self.nodes[to].residual[arc ^ 1] += flow;
        let first_orphan = self.orphans.len();
        for (end, toward_source) in [(from, true), (to, false)] {
            let mut node = end;
            while self.nodes[node].parent != TERMINAL {
                let up = usize::from(self.nodes[node].parent);
                let parent = self.across(node, up);
                let (down, back) = if toward_source { (parent, node) } else { (node, parent) };
                let arc = if toward_source { up ^ 1 } else { up };
                self.nodes[down].residual[arc] -= flow;
                self.nodes[back].residual[arc ^ 1] += flow;
                if self.nodes[down].residual[arc] == 0 {
                    self.orphans.push_back(node as u32);
                }
                node = parent;
            }
            self.nodes[node].terminal -= if toward_source { flow } else { -flow };
            if self.nodes[node].terminal == 0 {
                self.orphans.push_back(node as u32);
            }
        }
        for i in first_orphan..self.orphans.len() {
            let node = self.orphans[i] as usize;
            self.nodes[node].parent = NOBODY;
        }
    }

    /// Finds every orphan the parent nearest to its terminal, or lets it go.
    fn adopt(&mut self) {
        while let Some(front) = self.orphans.pop_front() {
            let node = front as usize;
            let tree = self.nodes[node].tree;
            let feeds = |nodes: &[Node], other: usize, arc: usize| {
                if tree == Tree::Source { nodes[other].residual[arc ^ 1] } else { nodes[node].residual[arc] }
            };
            let mut best: Option<(u32, usize)> = None;
            for arc in 0..ARCS {
                let other = self.across(node, arc);
                if self.nodes[other].tree == tree
                    && feeds(&self.nodes, other, arc) > 0
                    && let Some(distance) = self.distance(other)
                    && best.is_none_or(|(d, _)| distance < d)
                {
                    best = Some((distance, arc));
                }
            }
            if let Some((distance, arc)) = best {
                let n = &mut self.nodes[node];
                (n.parent, n.stamp, n.distance) = (arc as u8, self.clock, distance + 1);
                continue;
            }
            for arc in 0..ARCS {
                let other = self.across(node, arc);
                if self.nodes[other].tree != tree {
                    continue;
                }
                if feeds(&self.nodes, other, arc) > 0 {
                    self.wait(other);
                }
                if usize::from(self.nodes[other].parent) == arc ^ 1 {
                    self.nodes[other].parent = NOBODY;
                    self.orphans.push_back(other as u32);
                }
            }
            let n = &mut self.nodes[node];
            (n.tree, n.parent) = (Tree::None, NOBODY);
        }
    }

    /// Arcs from the node to its terminal, `None` where its path ends in an orphan.
    fn distance(&mut self, start: usize) -> Option<u32> {
        let (mut node, mut walked) = (start, 0);
        let total = loop {
            let n = &mut self.nodes[node];
            if n.stamp == self.clock && n.parent != NOBODY {
                break walked + n.distance;
            }
            match n.parent {
                NOBODY => return None,
                TERMINAL => {
                    (n.stamp, n.distance) = (self.clock, 1);
                    break walked + 1;
                }
                up => {
                    walked += 1;
                    node = self.across(node, usize::from(up));
                }
            }
        };
        let (mut node, mut left) = (start, total);
        while self.nodes[node].stamp != self.clock {
            (self.nodes[node].stamp, self.nodes[node].distance) = (self.clock, left);
            left -= 1;
            node = self.across(node, usize::from(self.nodes[node].parent));
        }
        Some(total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PAIRS: [(usize, isize, isize); 4] = [(0, 1, 0), (2, 0, 1), (4, 1, 1), (6, -1, 1)];

    proptest! {
        #[test]
        fn no_other_labelling_costs_less(
            unary in prop::collection::vec(-30i32..30, 12),
            pair in prop::collection::vec(0i32..20, 48),
        ) {
            let (w, h) = (3usize, 4usize);
            let beside = |x: usize, y: usize, dx: isize, dy: isize| {
                let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
                (x < w && y < h).then_some((x, y))
            };
            let mut flow = MaxFlow::new(w, h);
            for y in 0..h {
                for x in 0..w {
                    flow.add_unary(x, y, unary[y * w + x]);
                    for (k, (arc, dx, dy)) in PAIRS.into_iter().enumerate() {
                        if beside(x, y, dx, dy).is_some() {
                            flow.set_pair(x, y, arc, pair[(y * w + x) * 4 + k]);
                        }
                    }
                }
            }
            prop_assert!(flow.run(|| true));
            let cost = |label: &dyn Fn(usize, usize) -> bool| {
                let mut sum = 0;
                for y in 0..h {
                    for x in 0..w {
                        let u = unary[y * w + x];
                        sum += if label(x, y) { (-u).max(0) } else { u.max(0) };
                        for (k, (_, dx, dy)) in PAIRS.into_iter().enumerate() {
                            if let Some((nx, ny)) = beside(x, y, dx, dy)
                                && label(x, y) != label(nx, ny)
                            {
                                sum += pair[(y * w + x) * 4 + k];
                            }
                        }
                    }
                }
                sum
            };
            let found = cost(&|x, y| flow.is_source(x, y));
            let best = (0u32..1 << 12).map(|bits| cost(&|x, y| bits >> (y * w + x) & 1 == 1)).min();
            prop_assert_eq!(Some(found), best);
        }
    }

    #[test]
    fn stops_when_asked() {
        let (w, h) = (200, 200);
        let mut flow = MaxFlow::new(w, h);
        for y in 0..h {
            for x in 0..w {
                flow.add_unary(x, y, ((x * 7 + y * 13) % 11) as i32 - 5);
                if x + 1 < w {
                    flow.set_pair(x, y, 0, 3);
                }
            }
        }
        assert!(!flow.run(|| false));
    }
}
