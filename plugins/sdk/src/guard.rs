//! Panics contained: every entry into an author's code goes through here, destructors included.
//!
//! A panic that crosses the C border ends the process, so none may. What panicked is poisoned: it is given no more
//! work, and is only dropped, which may panic again.

use std::any::Any;
use std::cell::RefCell;
use std::mem::ManuallyDrop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

use crate::error::{Error, ErrorKind, Result};
use crate::job::Level;
use crate::log::log;

thread_local! {
    /// What the hook heard of the last panic on this thread: the message, with its place.
    static HEARD: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Sends what panics say to the host's log instead of stderr. Each plugin has a standard library of its own, so this
/// touches neither the host nor other plugins; and the host's hook would never hear of a plugin's panic.
pub(crate) fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        std::panic::set_hook(Box::new(|info| {
            let said = said(info.payload());
            let place = info.location().map_or(String::new(), |l| format!(", at {}:{}", l.file(), l.line()));
            let text = format!("panicked: {said}{place}");
            log(Level::Error, &text);
            // A thread that is ending may have no such memory any more.
            let _ = HEARD.try_with(|heard| {
                if let Ok(mut heard) = heard.try_borrow_mut() {
                    *heard = Some(text);
                }
            });
        }));
    });
}

fn said(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// Runs `body`; a panic becomes an error that tells where it was.
pub(crate) fn contain<R>(body: impl FnOnce() -> Result<R>) -> Result<R> {
    catch_unwind(AssertUnwindSafe(body)).unwrap_or_else(|payload| {
        let heard = HEARD.try_with(|heard| heard.try_borrow_mut().ok()?.take()).ok().flatten();
        let text = heard.unwrap_or_else(|| format!("panicked: {}", said(&*payload)));
        // Dropping what was thrown may panic in turn.
        std::mem::forget(payload);
        Err(Error::new(ErrorKind::Panicked, text))
    })
}

/// An author's object behind the guard.
pub(crate) struct Guard<T> {
    value: ManuallyDrop<T>,
    poisoned: bool,
}

impl<T> Guard<T> {
    pub(crate) fn new(value: T) -> Self {
        Self { value: ManuallyDrop::new(value), poisoned: false }
    }

    /// Gives the object work.
    pub(crate) fn call<R>(&mut self, work: impl FnOnce(&mut T) -> Result<R>) -> Result<R> {
        if self.poisoned {
            return Err(Error::new(ErrorKind::Poisoned, "it panicked before, and is given no more work"));
        }
        // Judged by whether it returned: an error that tells of another object's panic is no panic of this one.
        let mut returned = false;
        let result = contain(|| {
            let result = work(&mut self.value);
            returned = true;
            result
        });
        self.poisoned = !returned;
        result
    }
}

impl<T> Drop for Guard<T> {
    fn drop(&mut self) {
        let _ = contain(|| {
            // SAFETY: dropped here and nowhere else; `self` is going away.
            unsafe { ManuallyDrop::drop(&mut self.value) };
            Ok(())
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Nasty;

    impl Drop for Nasty {
        fn drop(&mut self) {
            panic!("again");
        }
    }

    #[test]
    fn panics_are_told_once_then_poison_and_drops_are_contained() {
        let mut guard = Guard::new(Nasty);
        assert_eq!(guard.call(|_| Ok(3)).expect("no panic"), 3);
        let first = guard.call(|_| -> Result<()> { panic!("{}", "over") }).expect_err("panics");
        assert_eq!(first.kind(), ErrorKind::Panicked);
        assert!(first.message().contains("over"), "{first}");
        assert_eq!(guard.call(|_| Ok(())).expect_err("poisoned").kind(), ErrorKind::Poisoned);
        drop(guard);
    }

    #[test]
    fn what_is_thrown_may_panic_when_dropped() {
        let thrown = contain(|| -> Result<()> { std::panic::panic_any(Nasty) }).expect_err("panics");
        assert!(thrown.message().contains("no message"), "{thrown}");
    }
}
