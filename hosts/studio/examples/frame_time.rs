//! How long the studio thinks about a picture of its window, without drawing it: at rest, while the sample is made into a
//! creature, and while a person draws meanwhile.
//!
//! `cargo run --release -p marey-studio --example frame_time`
#![allow(clippy::print_stdout, reason = "it is what this is for")]
#![allow(clippy::unwrap_used, reason = "a measurement that cannot go on has failed")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::Desk;
use marey_studio::Studio;
use marey_studio::egui::vec2;

fn steps(desk: &mut Desk, what: &str, most: usize, mut each: impl FnMut(&mut Desk, usize), go_on: fn(&Studio) -> bool) {
    let mut times = Vec::new();
    while times.len() < most && go_on(desk.harness.state()) {
        each(desk, times.len());
        let began = Instant::now();
        desk.harness.step();
        times.push(began.elapsed().as_secs_f64() * 1000.0);
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    println!(
        "{what}: {} pictures, median {:.1} ms, 99 of 100 {:.1}, slowest {:.1}",
        times.len(),
        at(0.5),
        at(0.99),
        at(1.0)
    );
}

fn main() {
    let mut desk = Desk::new();
    desk.rest(500);
    steps(&mut desk, "the start", 200, |_, _| (), |_| true);
    desk.click("Open the sample: a fox that walks");
    desk.wait_open();
    let busy = |studio: &Studio| studio.open().is_some_and(|open| open.is_busy());
    steps(&mut desk, "while it is made", 200, |_, _| (), busy);
    let from = desk.harness.state().open().unwrap().on_screen((200.0, 120.0));
    desk.harness.hover_at(from);
    desk.harness.drag_at(from);
    desk.harness.step();
    let draw = |desk: &mut Desk, i: usize| {
        let turn = i as f32 * 0.1;
        desk.harness.hover_at(from + vec2(200.0 - 200.0 * turn.cos(), 120.0 * turn.sin()));
    };
    steps(&mut desk, "while it is made and a person draws", 300, draw, busy);
    desk.harness.drop_at(from);
    desk.wait("the creature", |s| s.open().is_some_and(|o| o.has_creature()));
    steps(&mut desk, "while it plays", 300, |_, _| (), |_| true);
}
