//! What a call costs beyond its work: the border's checks, the lookup of the object, the guard against panics.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![expect(clippy::print_stdout, reason = "the numbers are worth reading where the test is run for them")]

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
    // 50 ns is the promise, in the release build on a machine of its own: `cargo xtask cancels` keeps it to that.
    let most = if cfg!(debug_assertions) { 150.0 } else { 50.0 };
    let said = format!("a getter of the context takes {of_context:.1} ns, one of an object {of_object:.1} ns");
    println!("{said}");
    assert!(of_context < most && of_object < most, "{said}");
}
