//! Control points as the studio needs them, out of and into a points.json.

use serde::{Deserialize, Serialize};

/// A place of a point that a person marked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Key {
    pub(crate) frame: u64,
    pub(crate) at: (f32, f32),
}

/// A point of the clip, and of the drawing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Mark {
    pub(crate) name: String,
    pub(crate) keys: Vec<Key>,
}

/// The file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Marks {
    format: String,
    version: u32,
    pub(crate) size: (u32, u32),
    pub(crate) points: Vec<Mark>,
}

impl Marks {
    pub(crate) fn new(size: (u32, u32)) -> Self {
        Self { format: "marey-points".into(), version: 1, size, points: Vec::new() }
    }

    /// What the library wrote or found to be one.
    pub(crate) fn parse(json: &[u8]) -> Option<Self> {
        serde_json::from_slice(json).ok()
    }

    /// Its bytes; none where nothing is marked.
    pub(crate) fn bytes(&self) -> Option<Vec<u8>> {
        (!self.points.is_empty()).then(|| serde_json::to_vec(self).unwrap_or_default())
    }

    /// Marks a point on a frame, in place of what was marked of it there; inside the clip.
    pub(crate) fn put(&mut self, point: usize, frame: u64, (x, y): (f32, f32)) {
        let inside = |v: f32, size: u32| v.clamp(0.0, (size.max(1) - 1) as f32);
        let at = (inside(x, self.size.0), inside(y, self.size.1));
        if self.points.get(point).is_none() {
            let name = self.free_name();
            self.points.push(Mark { name, keys: Vec::new() });
        }
        let last = self.points.len() - 1;
        let keys = &mut self.points[point.min(last)].keys;
        keys.retain(|k| k.frame != frame);
        keys.push(Key { frame, at });
        keys.sort_by_key(|k| k.frame);
    }

    /// The same for a new point of this name.
    pub(crate) fn put_named(&mut self, name: &str, frame: u64, at: (f32, f32)) {
        let point = self.points.len();
        self.put(point, frame, at);
        if let Some(point) = self.points.last_mut() {
            name.clone_into(&mut point.name);
        }
    }

    /// Marks the points of `found` as well, but those that lie where something is marked already.
    pub(crate) fn add(&mut self, found: Option<Self>) {
        let near = 0.05 * (self.size.0 as f32).hypot(self.size.1 as f32);
        let marked: Vec<Key> = self.points.iter().flat_map(|p| &p.keys).copied().collect();
        for key in found.into_iter().flat_map(|found| found.points).flat_map(|point| point.keys) {
            let on = |k: &Key| k.frame == key.frame && (k.at.0 - key.at.0).hypot(k.at.1 - key.at.1) < near;
            if !marked.iter().any(on) {
                self.put(self.points.len(), key.frame, key.at);
            }
        }
    }

    /// Takes a point's mark on a frame away, and the point with its last.
    pub(crate) fn take(&mut self, point: usize, frame: u64) {
        if let Some(mark) = self.points.get_mut(point) {
            mark.keys.retain(|k| k.frame != frame);
        }
        self.points.retain(|p| !p.keys.is_empty());
    }

    /// Moves what is marked on a frame to another.
    pub(crate) fn move_frame(&mut self, from: u64, to: u64) {
        for mark in &mut self.points {
            if let Some(key) = mark.keys.iter().find(|k| k.frame == from).copied() {
                mark.keys.retain(|k| k.frame != from && k.frame != to);
                mark.keys.push(Key { frame: to, at: key.at });
                mark.keys.sort_by_key(|k| k.frame);
            }
        }
    }

    /// The frames that are marked on, rising.
    pub(crate) fn frames(&self) -> Vec<u64> {
        let mut frames: Vec<u64> = self.points.iter().flat_map(|p| &p.keys).map(|k| k.frame).collect();
        frames.sort_unstable();
        frames.dedup();
        frames
    }

    fn free_name(&self) -> String {
        let taken = |name: &str| self.points.iter().any(|p| p.name == name);
        (1..).map(|i: u32| i.to_string()).find(|name| !taken(name)).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_put_moved_and_taken() {
        let mut marks = Marks::new((100, 50));
        marks.put(0, 0, (10.0, 70.0));
        marks.put(1, 0, (20.0, 5.0));
        marks.put(0, 9, (30.0, 5.0));
        assert_eq!(marks.points[0].keys[0].at, (10.0, 49.0), "inside the clip");
        assert_eq!((marks.frames(), &*marks.points[1].name), (vec![0, 9], "2"));
        marks.move_frame(9, 4);
        assert_eq!(marks.frames(), [0, 4]);
        let read = Marks::parse(&marks.bytes().unwrap_or_default());
        assert_eq!(read.as_ref(), Some(&marks));
        let mut found = Marks::new((100, 50));
        found.put(0, 0, (12.0, 47.0));
        found.put(1, 0, (60.0, 20.0));
        found.put(2, 0, (62.0, 20.0));
        marks.add(Some(found));
        assert_eq!(marks.points.len(), 4, "one was marked already");
        marks.points.truncate(2);
        marks.take(1, 0);
        assert_eq!(marks.points.len(), 1, "a point without marks is gone");
        marks.put(5, 0, (1.0, 1.0));
        assert_eq!(marks.points[1].name, "2", "its name is free again");
        marks.take(0, 0);
        marks.take(0, 4);
        marks.take(0, 0);
        assert_eq!(marks.bytes(), None);
    }
}
