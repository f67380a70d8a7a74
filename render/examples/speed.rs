//! Pictures a second of ten creatures of 20 000 triangles at 1280 x 720, on the CPU and on what is found of a GPU; with a
//! folder as argument every style is also written there as seen from three sides, of a creature's file where one follows.
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::time::Instant;

use marey::job::Progress;
use marey_render::{Adapter, Camera, Film, Model, Picture, Renderer, Scene, Style};

#[path = "../tests/common/mod.rs"]
mod common;

const SIZE: (u32, u32) = (1280, 720);
const PICTURES: usize = 24;

/// Of all threads of this process, in seconds: what other programs do at the same time does not change it.
fn processor_time() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::new(common::animal(20_000, PICTURES))?;
    let triangles: usize = model.rig().parts.iter().map(|p| p.mesh.triangles.len()).sum();
    let scene = common::herd(&model, 10);
    let progress = Progress::new();
    let stage = progress.whole();
    let extent = scene.extent(stage)?;
    println!("10 creatures of {triangles} triangles, {} x {}", SIZE.0, SIZE.1);
    for adapter in [Adapter::Cpu, Adapter::Gpu] {
        let began = Instant::now();
        let renderer = match Renderer::new(adapter) {
            Ok(renderer) => renderer,
            Err(error) => {
                println!("no GPU: {error}");
                continue;
            }
        };
        let opened = began.elapsed();
        println!("{} (opened in {:.0} ms)", renderer.describe(), opened.as_secs_f64() * 1e3);
        for style in [Style::Textured, Style::Shaded, Style::Wireframe] {
            let camera = Camera::around(&extent, 25.0, 15.0, Some(35.0), SIZE);
            let picture = Picture { style, ..Picture::new(SIZE, camera) };
            let film = Film::of(&scene, picture);
            let draw = |index: usize| {
                let (frame, picture) = film.at(&scene, index);
                renderer.draw(&scene, frame, &picture, stage)
            };
            draw(0)?;
            let mut best = (f64::INFINITY, f64::INFINITY);
            for _ in 0..3 {
                let (began, busy) = (Instant::now(), processor_time());
                for index in 0..PICTURES {
                    draw(index)?;
                }
                best = (best.0.min(began.elapsed().as_secs_f64()), best.1.min(processor_time() - busy));
            }
            let (rate, busy) = (PICTURES as f64 / best.0, best.1 / PICTURES as f64);
            println!("  {style:?}: {rate:.1} pictures a second, {:.0} ms of one core each", 1e3 * busy);
        }
        if let Some(folder) = std::env::args().nth(1) {
            let one = match std::env::args().nth(2) {
                Some(path) => marey::export::gltf::read_creature(path)?.model,
                None => common::animal(3000, PICTURES),
            };
            let one = Scene::of(Model::new(one)?);
            let extent = one.extent(stage)?;
            for (style, name) in Style::ALL {
                for (side, yaw, pitch) in [("side", 0.0, 0.0), ("front", 90.0, 0.0), ("above", 30.0, 40.0)] {
                    let size = (480, 360);
                    let camera = Camera::around(&extent, yaw, pitch, Some(30.0), size);
                    let picture =
                        Picture { style, shadow: 0.35, background: [235, 235, 230, 255], ..Picture::new(size, camera) };
                    let drawn = renderer.draw(&one, 5, &picture, stage)?;
                    drawn.save(format!("{folder}/{name}-{side}-{adapter:?}.png"))?;
                }
            }
        }
    }
    Ok(())
}
