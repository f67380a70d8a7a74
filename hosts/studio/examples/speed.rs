//! How long the library takes for a picture of the 3D view: a creature's folder or .glb, by adapter and size.
//!
//! `cargo run --release -p marey-studio --example speed -- CREATURE`
#![allow(clippy::print_stdout, reason = "it is what this is for")]

use std::time::Instant;

use marey_binding::{Adapter, Camera, Context, RenderOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("name a creature's folder, or its .glb")?;
    let context = Context::new(0)?;
    let creature = context.open_creature(&path)?;
    let info = creature.info()?;
    println!("{} vertices, {} triangles, {} frames", info.vertices, info.triangles, info.frames);
    for adapter in [Adapter::Auto, Adapter::Gpu, Adapter::Cpu] {
        match context.renderer(adapter) {
            Ok(name) => println!("{adapter:?} is {name}"),
            Err(e) => {
                println!("{adapter:?}: {e}");
                continue;
            }
        }
        for size in [(320, 320), (640, 640), (1280, 1280)] {
            let mut times: Vec<f64> = Vec::new();
            for turn in 0..24_u64 {
                let options = RenderOptions {
                    size,
                    adapter,
                    shadow: 0.35,
                    frame: turn % info.frames,
                    camera: Camera::Fitted { yaw: 15.0 * turn as f32, pitch: 12.0, fov: 24.0 },
                    ..RenderOptions::default()
                };
                let began = Instant::now();
                creature.render(&options)?;
                times.push(began.elapsed().as_secs_f64() * 1000.0);
            }
            times.sort_by(f64::total_cmp);
            println!(
                "  {}x{}: {:.1} ms a picture, slowest {:.1}",
                size.0,
                size.1,
                times[times.len() / 2],
                times[times.len() - 1]
            );
        }
    }
    Ok(())
}
