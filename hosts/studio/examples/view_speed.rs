//! How long the library takes for a picture of the 3D view, at rest and while things move: a creature's folder or .glb, by
//! adapter and size. Prints the best of all and the median, since a machine that does other things too is slower at times.
//!
//! `cargo run --release -p marey-studio --example view_speed -- CREATURE`
#![allow(clippy::print_stdout, reason = "it is what this is for")]

use std::time::Instant;

use marey_binding::{Adapter, Camera, Context, RenderOptions};

const PICTURES: u64 = 30;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("name a creature's folder, or its .glb")?;
    let context = Context::new(0)?;
    let creature = context.open_creature(&path)?;
    let info = creature.info()?;
    println!("{} vertices, {} triangles, {} frames", info.vertices, info.triangles, info.frames);
    for adapter in [Adapter::Gpu, Adapter::Cpu] {
        match context.renderer(adapter) {
            Ok(name) => println!("{adapter:?}: {name}"),
            Err(e) => {
                println!("{adapter:?}: {e}");
                continue;
            }
        }
        for (size, hard_edges) in [((270, 315), true), ((540, 630), false), ((1080, 1260), false)] {
            let mut times: Vec<f64> = Vec::new();
            for turn in 0..PICTURES {
                let options = RenderOptions {
                    size,
                    adapter,
                    hard_edges,
                    shadow: 0.35,
                    frame: turn % info.frames,
                    camera: Camera::Fitted { yaw: 12.0 * turn as f32, pitch: 12.0, fov: 24.0 },
                    ..RenderOptions::default()
                };
                let began = Instant::now();
                creature.render(&options)?;
                times.push(began.elapsed().as_secs_f64() * 1000.0);
            }
            times.sort_by(f64::total_cmp);
            let edges = if hard_edges { "hard" } else { "smooth" };
            println!("  {}x{} {edges}: {:.1} ms, median {:.1}", size.0, size.1, times[0], times[times.len() / 2]);
        }
    }
    Ok(())
}
