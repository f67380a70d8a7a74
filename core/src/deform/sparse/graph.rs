//! Who touches whom: the neighbours of every vertex, in one array.

/// An undirected graph without loops.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    /// Where the neighbours of each vertex begin, and at last their count.
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Graph {
    /// The graph of `vertices` vertices in which the members of every group touch one another. Indices are in range.
    pub(crate) fn of_groups<'a>(vertices: usize, groups: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        let mut starts = vec![0u32; vertices + 1];
        for group in groups.clone() {
            for &v in group {
                starts[v as usize + 1] += group.len() as u32 - 1;
            }
        }
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let mut filled = starts.clone();
        let mut all = vec![0u32; starts[vertices] as usize];
        for group in groups {
            for (i, &v) in group.iter().enumerate() {
                for (j, &u) in group.iter().enumerate() {
                    if i != j {
                        all[filled[v as usize] as usize] = u;
                        filled[v as usize] += 1;
                    }
                }
            }
        }
        // The members of two groups appear twice: keep one of each, and no loop.
        let mut neighbours = Vec::with_capacity(all.len() / 2 + vertices);
        let mut first = 0;
        for v in 0..vertices {
            let own = &mut all[first..starts[v + 1] as usize];
            first = starts[v + 1] as usize;
            own.sort_unstable();
            starts[v] = neighbours.len() as u32;
            let mut last = v as u32;
            for &u in own.iter() {
                if u != last && u != v as u32 {
                    neighbours.push(u);
                    last = u;
                }
            }
        }
        starts[vertices] = neighbours.len() as u32;
        Self { starts, neighbours }
    }

    /// How many vertices there are.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// How many neighbours all vertices have together.
    pub(crate) fn entries(&self) -> usize {
        self.neighbours.len()
    }

    /// Where the neighbours of `v` lie among all.
    pub(crate) fn range(&self, v: usize) -> std::ops::Range<usize> {
        self.starts[v] as usize..self.starts[v + 1] as usize
    }

    /// The neighbours of `v`, rising.
    pub(crate) fn of(&self, v: usize) -> &[u32] {
        &self.neighbours[self.range(v)]
    }

    /// The place among all neighbours of the entry for `u` beside `v`, which touch.
    pub(crate) fn entry(&self, v: usize, u: u32) -> Option<usize> {
        self.of(v).iter().position(|&w| w == u).map(|k| self.starts[v] as usize + k)
    }
}
