//! Makes a character of a picture and draws its mesh, regions, curve skeleton and joints over it.
//!
//! `rig_eval PICTURE OUT.png [RIG.json]`
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use glam::Vec2;
use image::{Rgba, RgbaImage};
use marey::job::Progress;
use marey::shape::character::{Character, RigParams};

fn line(image: &mut RgbaImage, a: Vec2, b: Vec2, colour: [u8; 4], width: f32) {
    let steps = (a.distance(b) * 2.0).ceil().max(1.0) as usize;
    for k in 0..=steps {
        let p = a.lerp(b, k as f32 / steps as f32);
        let reach = (0.5 * width) as i32;
        for (dx, dy) in (-reach..=reach).flat_map(|dx| (-reach..=reach).map(move |dy| (dx, dy))) {
            let (x, y) = (p.x as i32 + dx, p.y as i32 + dy);
            if x >= 0 && y >= 0 && (x as u32) < image.width() && (y as u32) < image.height() {
                image.put_pixel(x as u32, y as u32, Rgba(colour));
            }
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [picture, out, rest @ ..] = &args[..] else { return Err("usage: rig_eval PICTURE OUT.png [RIG.json]".into()) };
    let picture = image::open(picture)?.to_rgba8();
    let began = std::time::Instant::now();
    let character = Character::from_picture(&picture, &RigParams::default(), Progress::new().whole())?;
    println!(
        "{} vertices, {} triangles, {} joints, {} bones, {:.0} ms",
        character.mesh.points.len(),
        character.mesh.triangles.len(),
        character.skeleton.joints.len(),
        character.skeleton.bones.len(),
        1e3 * began.elapsed().as_secs_f64()
    );
    // Small pictures are shown larger.
    let zoom = (900 / picture.width().max(picture.height())).clamp(1, 6);
    let (width, height) = (picture.width() * zoom, picture.height() * zoom);
    let mut image = image::imageops::resize(&picture, width, height, image::imageops::FilterType::Triangle);
    for p in image.pixels_mut() {
        let strength = 0.5 * f32::from(p.0[3]) / 255.0;
        let pale = |c: u8| (f32::from(c) * strength + 255.0 * (1.0 - strength)) as u8;
        p.0 = [pale(p.0[0]), pale(p.0[1]), pale(p.0[2]), 255];
    }
    let at = |v: u32| character.mesh.points[v as usize] * zoom as f32;
    for (t, joins) in character.mesh.triangles.iter().zip(&character.regions.joins) {
        let hue = character.regions.bone[t[0] as usize] as f32 * 2.4;
        let tint = |shift: f32| (140.0 + 100.0 * (hue + shift).sin()) as u8;
        let colour = if *joins { [60, 60, 60, 255] } else { [tint(0.0), tint(2.1), tint(4.2), 255] };
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            line(&mut image, at(a), at(b), colour, 1.0);
        }
    }
    for curve in &character.curve {
        curve.windows(2).for_each(|s| line(&mut image, s[0] * zoom as f32, s[1] * zoom as f32, [0, 90, 255, 255], 2.0));
    }
    for (a, b) in character.skeleton.segments(&character.skeleton.rest()) {
        line(&mut image, a * zoom as f32, b * zoom as f32, [255, 0, 0, 255], 3.0);
    }
    for (i, joint) in character.skeleton.joints.iter().enumerate() {
        let colour = if character.skeleton.roots().contains(&i) { [255, 0, 255, 255] } else { [0, 0, 0, 255] };
        line(&mut image, joint.at * zoom as f32, joint.at * zoom as f32, colour, 9.0);
    }
    image.save(out)?;
    if let Some(rig) = rest.first() {
        std::fs::write(rig, character.to_json())?;
    }
    Ok(())
}
