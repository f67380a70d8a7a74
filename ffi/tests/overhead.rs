//! What a call costs beyond its work: the border's checks, the lookup of the object, the guard against panics.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ptr;
use std::time::Instant;

use common::*;
use marey_ffi::*;

/// Nanoseconds a call, the best of several rounds: what else the machine does only adds.
fn nanoseconds(mut call: impl FnMut() -> mry_status) -> f64 {
    const CALLS: u32 = 20_000;
    let round = |_| {
        let began = Instant::now();
        for _ in 0..CALLS {
            assert_eq!(call(), OK);
        }
        began.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS)
    };
    (0..30).map(round).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_trivial_getter_costs_little() {
    let f = fixture();
    let (c, rig, mut err) = (f.context, f.rig(), error());
    let (mut threads, mut limbs) = (0, 0);
    let of_context = nanoseconds(|| unsafe { mry_context_get_threads(c, &mut threads, &mut err) });
    let of_object = nanoseconds(|| unsafe { mry_rig_get_limb_count(c, rig, &mut limbs, ptr::null_mut()) });
    // 50 ns is the promise in the release build on a machine of its own.
    assert!(of_context < 150.0 && of_object < 150.0, "context {of_context:.1} ns, object {of_object:.1} ns");
}
