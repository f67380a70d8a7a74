//! Which decoder serves which request: a few streams at once behind one bounded cache.
//!
//! A request for a picture that is not at hand takes the idle stream that stands closest before it, or starts a new
//! one when none is near. Everything decoded on the way is kept, so that the neighbourhood comes quickly afterwards.
//! Reading in order therefore decodes every picture once, from one thread or from several, and threads that read far
//! apart do not pull one decoder back and forth. No lock is held while decoding.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use super::cache::{Cache, Entry};
use super::source::{Damage, Decoded, Source, Stream};
use super::{ClipOptions, FrameMemory};
use crate::error::Result;

/// A stream a little before the restart point of a request still serves it better than a new decoder.
const NEAR: usize = 8;

pub(super) struct Pool {
    source: Box<dyn Source>,
    memory: Option<Arc<dyn FrameMemory>>,
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    cache: Cache,
    idle: Vec<Idle>,
    /// The next picture of each stream that is decoding now, by ticket.
    busy: Vec<(u64, usize)>,
    clock: u64,
}

struct Idle {
    stream: Box<dyn Stream>,
    next: usize,
    since: u64,
}

impl Pool {
    pub(super) fn new(source: Box<dyn Source>, options: &ClipOptions) -> Self {
        let state = State { cache: Cache::new(options.cache_bytes), idle: Vec::new(), busy: Vec::new(), clock: 0 };
        Self { source, memory: options.memory.clone(), state: Mutex::new(state), changed: Condvar::new() }
    }

    /// Who lends the memory for frames.
    pub(super) fn memory(&self) -> Option<&Arc<dyn FrameMemory>> {
        self.memory.as_ref()
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The picture, from the cache or decoded now; [`None`] when its stream passes by without it.
    pub(super) fn get(&self, picture: usize) -> Result<Option<Entry>> {
        let near = self.source.restart(picture).saturating_sub(NEAR);
        let serves = |next: usize| next <= picture && next >= near;
        let mut state = self.lock();
        loop {
            if let Some(entry) = state.cache.get(picture) {
                return Ok(Some(entry));
            }
            let best =
                (0..state.idle.len()).filter(|&i| serves(state.idle[i].next)).max_by_key(|&i| state.idle[i].next);
            if let Some(best) = best {
                let idle = state.idle.swap_remove(best);
                return self.run(state, Some(idle), picture);
            }
            let awaited = state.busy.iter().any(|&(_, next)| serves(next));
            if !awaited && state.busy.len() < self.source.max_streams().max(1) {
                if state.busy.len() + state.idle.len() >= self.source.max_streams().max(1) {
                    let oldest = (0..state.idle.len()).min_by_key(|&i| state.idle[i].since);
                    oldest.map(|i| state.idle.swap_remove(i));
                }
                return self.run(state, None, picture);
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Decodes forward to `picture`, with `idle` or a new stream.
    fn run(&self, mut state: MutexGuard<'_, State>, idle: Option<Idle>, picture: usize) -> Result<Option<Entry>> {
        state.clock += 1;
        let ticket = Ticket { pool: self, id: state.clock };
        state.busy.push((ticket.id, idle.as_ref().map_or_else(|| self.source.restart(picture), |i| i.next)));
        drop(state);

        // Decoders of other people's making meet files of nobody's making: one that panics spoils its frame only.
        let guarded = |work: &mut dyn FnMut() -> Result<_>| catch_unwind(AssertUnwindSafe(work)).ok();
        let failed = || {
            let damage = Damage { why: "its data makes the decoder fail".to_owned(), first: picture };
            Ok(Some(Entry::Damaged(Arc::new(damage))))
        };
        let mut stream = idle.map(|idle| idle.stream);
        let found = loop {
            let next = guarded(&mut || {
                let stream = match &mut stream {
                    Some(stream) => stream,
                    none => none.insert(self.source.stream(picture)?),
                };
                stream.next()
            });
            let Some(next) = next else { return failed() };
            let Some((number, decoded)) = next? else { break None };
            let entry = match decoded {
                Decoded::Picture(p) => Entry::Picture(p.lent(self.memory())?),
                Decoded::Planes(p) => Entry::Planes(Arc::new(p.lent(self.memory())?)),
                Decoded::Damaged(damage) => Entry::Damaged(Arc::new(damage)),
            };
            let mut state = self.lock();
            state.cache.insert(number, entry.clone());
            if let Some(busy) = state.busy.iter_mut().find(|b| b.0 == ticket.id) {
                busy.1 = number + 1;
            }
            self.changed.notify_all();
            if number >= picture {
                state.clock += 1;
                let since = state.clock;
                state.idle.extend(stream.map(|stream| Idle { stream, next: number + 1, since }));
                break (number == picture).then_some(entry);
            }
        };
        drop(ticket);
        Ok(found)
    }

    /// Keeps what a picture has become.
    pub(super) fn keep(&self, picture: usize, entry: Entry) {
        self.lock().cache.insert(picture, entry);
    }

    /// Where decoding has to begin to reach `picture`.
    pub(super) fn restart(&self, picture: usize) -> usize {
        self.source.restart(picture)
    }
}

/// A place among the busy streams, given back whatever happens to the decoder.
struct Ticket<'a> {
    pool: &'a Pool,
    id: u64,
}

impl Drop for Ticket<'_> {
    fn drop(&mut self) {
        self.pool.lock().busy.retain(|b| b.0 != self.id);
        self.pool.changed.notify_all();
    }
}
