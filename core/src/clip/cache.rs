//! The least recently used pictures are forgotten when all together exceed a number of bytes.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Picture;
use super::source::Damage;
use super::yuv::Planes;

/// A decoded picture, as far as it has been needed.
#[derive(Clone, Debug)]
pub(super) enum Entry {
    Picture(Arc<Picture>),
    Planes(Arc<Planes>),
    Damaged(Arc<Damage>),
}

impl Entry {
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Picture(p) => p.rgb.as_raw().len() + p.alpha.as_ref().map_or(0, |a| a.as_raw().len()),
            Self::Planes(p) => p.bytes(),
            Self::Damaged(damage) => damage.why.len(),
        }
    }
}

/// Pictures by number, at most `max_bytes` of them together.
#[derive(Debug)]
pub(super) struct Cache {
    max_bytes: usize,
    bytes: usize,
    clock: u64,
    entries: BTreeMap<usize, (u64, Entry)>,
    by_use: BTreeMap<u64, usize>,
}

impl Cache {
    pub(super) fn new(max_bytes: usize) -> Self {
        Self { max_bytes, bytes: 0, clock: 0, entries: BTreeMap::new(), by_use: BTreeMap::new() }
    }

    /// The picture, which becomes the most recently used.
    pub(super) fn get(&mut self, picture: usize) -> Option<Entry> {
        let (used, entry) = self.entries.get_mut(&picture)?;
        self.by_use.remove(used);
        self.clock += 1;
        *used = self.clock;
        self.by_use.insert(self.clock, picture);
        Some(entry.clone())
    }

    /// Keeps the picture, in place of what was kept under its number, and forgets others while there is too much.
    pub(super) fn insert(&mut self, picture: usize, entry: Entry) {
        self.clock += 1;
        self.bytes += entry.bytes();
        self.by_use.insert(self.clock, picture);
        if let Some((used, old)) = self.entries.insert(picture, (self.clock, entry)) {
            self.bytes -= old.bytes();
            self.by_use.remove(&used);
        }
        while self.bytes > self.max_bytes {
            let Some((_, oldest)) = self.by_use.pop_first() else { break };
            if let Some((_, entry)) = self.entries.remove(&oldest) {
                self.bytes -= entry.bytes();
            }
        }
    }

    #[cfg(test)]
    pub(super) fn bytes(&self) -> usize {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use image::RgbImage;
    use proptest::prelude::*;

    use super::*;

    fn entry(bytes: u32) -> Entry {
        Entry::Picture(Arc::new(Picture::new(RgbImage::new(bytes / 3, 1), None)))
    }

    #[test]
    fn the_least_recently_used_goes_first() {
        let mut cache = Cache::new(900);
        for i in 0..3 {
            cache.insert(i, entry(300));
        }
        assert!(cache.get(0).is_some());
        cache.insert(3, entry(300));
        assert!(cache.get(1).is_none(), "picture 1 was used longest ago");
        assert!(cache.get(0).is_some() && cache.get(2).is_some() && cache.get(3).is_some());
    }

    proptest! {
        #[test]
        fn never_more_than_its_bound(max in 0usize..2000, steps in prop::collection::vec((0usize..20, 0u32..900), 1..80)) {
            let mut cache = Cache::new(max);
            for (picture, bytes) in steps {
                cache.insert(picture, entry(bytes));
                prop_assert!(cache.bytes() <= max);
                let kept: usize = cache.entries.values().map(|(_, e)| e.bytes()).sum();
                prop_assert_eq!(kept, cache.bytes());
                prop_assert_eq!(cache.by_use.len(), cache.entries.len());
            }
        }
    }
}
