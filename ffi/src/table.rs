//! Objects behind ids. An id holds the object's place, the kind, the context and the place's generation, so that an
//! id that outlived its object, or strayed from another context, is found out instead of followed.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::error::{Failure, Outcome};
use crate::status::mry_status_code;

/// An object and whether a contained panic may have left it half-changed.
#[derive(Debug)]
pub(crate) struct Slot<T> {
    pub(crate) value: T,
    poisoned: AtomicBool,
}

/// All objects of one kind in one context.
pub(crate) struct Table<T> {
    kind: u64,
    /// How many may be alive at a time.
    most: usize,
    places: Mutex<Places<T>>,
}

struct Places<T> {
    objects: Vec<(u32, Option<Arc<Slot<T>>>)>,
    free: Vec<usize>,
}

/// Bits of an id, from the low end: 16 place, 10 context, 6 kind, 32 generation (never 0).
const PLACE_BITS: u32 = 16;
const CONTEXT_SHIFT: u32 = PLACE_BITS;
const KIND_SHIFT: u32 = CONTEXT_SHIFT + 10;
const GENERATION_SHIFT: u32 = 32;

impl<T> Table<T> {
    /// An empty table for `most` objects. `kind` and `context` tell ids of other tables from this one's.
    pub(crate) fn new(kind: u64, context: u64, most: usize) -> Self {
        let kind = (kind & 0x3f) << KIND_SHIFT | (context & 0x3ff) << CONTEXT_SHIFT;
        Self { kind, most, places: Mutex::new(Places { objects: Vec::new(), free: Vec::new() }) }
    }

    fn lock(&self) -> MutexGuard<'_, Places<T>> {
        self.places.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps `value` and gives its id.
    pub(crate) fn insert(&self, value: T) -> Outcome<u64> {
        let mut places = self.lock();
        let place = match places.free.pop() {
            Some(place) => place,
            None if places.objects.len() < self.most.min(1 << PLACE_BITS) => {
                places.objects.push((1, None));
                places.objects.len() - 1
            }
            None => {
                return Err(Failure::new(
                    mry_status_code::MRY_E_LIMIT,
                    "",
                    format!("{} objects of one kind are alive in the context; destroy some", places.objects.len()),
                ));
            }
        };
        let (generation, object) = &mut places.objects[place];
        *object = Some(Arc::new(Slot { value, poisoned: AtomicBool::new(false) }));
        Ok(u64::from(*generation) << GENERATION_SHIFT | self.kind | place as u64)
    }

    fn place(&self, id: u64) -> (usize, u32) {
        let place = (id & ((1 << PLACE_BITS) - 1)) as usize;
        let foreign = id & 0xffff_ffff & !((1 << PLACE_BITS) - 1) != self.kind;
        (if foreign { usize::MAX } else { place }, (id >> GENERATION_SHIFT) as u32)
    }

    /// The object of `id`.
    pub(crate) fn get(&self, id: u64, param: &'static str) -> Outcome<Arc<Slot<T>>> {
        let (place, generation) = self.place(id);
        let places = self.lock();
        let slot = match places.objects.get(place) {
            Some((current, Some(slot))) if *current == generation => slot.clone(),
            _ => return Err(stale(id, param)),
        };
        if slot.poisoned.load(Ordering::Acquire) {
            let message = format!("{param} was poisoned by an earlier defect; destroy it");
            return Err(Failure::new(mry_status_code::MRY_E_POISONED, param, message));
        }
        Ok(slot)
    }

    /// Lets only the destruction of the object of `id` go on, where it is one of these.
    pub(crate) fn poison(&self, id: u64) {
        let (place, generation) = self.place(id);
        if let Some((current, Some(slot))) = self.lock().objects.get(place)
            && *current == generation
        {
            slot.poisoned.store(true, Ordering::Release);
        }
    }

    /// Takes the object of `id` out, poisoned or not; its id is stale from here on.
    pub(crate) fn remove(&self, id: u64, param: &'static str) -> Outcome<Arc<Slot<T>>> {
        let (place, generation) = self.place(id);
        let mut places = self.lock();
        let slot = match places.objects.get_mut(place) {
            Some((current, object)) if *current == generation => object.take().ok_or_else(|| stale(id, param))?,
            _ => return Err(stale(id, param)),
        };
        // A place whose generations are used up is never used again: its old ids must stay stale.
        if let Some(next) = generation.checked_add(1) {
            places.objects[place].0 = next;
            places.free.push(place);
        }
        Ok(slot)
    }

    /// All objects alive, in no particular order.
    pub(crate) fn all(&self) -> Vec<Arc<Slot<T>>> {
        self.lock().objects.iter().filter_map(|(_, slot)| slot.clone()).collect()
    }
}

fn stale(id: u64, param: &'static str) -> Failure {
    let message = if id == 0 {
        format!("{param} is null")
    } else {
        format!("{param} is of no object alive in this context: destroyed, or of another context")
    };
    Failure::new(mry_status_code::MRY_E_STALE, param, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_of_the_dead_and_of_others_are_stale() {
        let table = Table::new(1, 7, 9);
        let a = table.insert("a").expect("room");
        table.remove(a, "x").expect("alive");
        let b = table.insert("b").expect("room");
        assert_eq!(a & 0xffff, b & 0xffff, "the place is used again");
        assert!(table.get(a, "x").is_err() && table.remove(a, "x").is_err());
        assert_eq!(table.get(b, "x").expect("alive").value, "b");
        let (other_kind, other_context) = (Table::new(2, 7, 9), Table::new(1, 8, 9));
        other_kind.insert("c").expect("room");
        other_context.insert("d").expect("room");
        assert!(other_kind.get(b, "x").is_err() && other_context.get(b, "x").is_err());
        assert!(table.get(0, "x").is_err() && table.get(u64::MAX, "x").is_err());
    }

    #[test]
    fn a_place_whose_generations_are_used_up_is_retired() {
        let table = Table::new(1, 0, 9);
        let id = table.insert(()).expect("room");
        table.lock().objects[0].0 = u32::MAX;
        let last = id | 0xffff_ffff << GENERATION_SHIFT;
        table.remove(last, "x").expect("alive");
        assert_ne!(table.insert(()).expect("room") & 0xffff, 0);
    }
}
