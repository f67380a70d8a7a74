//! Wavefront OBJ: one file a frame in world coordinates, with one material file and the textures beside them.
//!
//! What does not change from frame to frame (texture coordinates, faces) is formatted once.

use std::path::Path;

use rayon::prelude::*;

use super::folder::{REPORT, StagedFolder};
use super::masks::{frame_name, is_frame};
use super::png::encode_rgb;
use super::report::Report;
use crate::error::{Error, Result};
use crate::geometry::TriMesh;
use crate::job::Stage;
use crate::shape::RiggedModel;

const MATERIALS: &str = "creature.mtl";

/// Writes `folder/00000.obj` and so on, `creature.mtl` and a PNG for each part. The folder must exist.
///
/// # Errors
/// A model that is not valid, a file that cannot be written, or a cancel.
pub fn write_obj(folder: &Path, model: &RiggedModel, stage: Stage<'_>) -> Result<()> {
    model.validate()?;
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(|e| Error::io(&path, "write", e))
    };
    let names: Vec<String> = model.parts.iter().enumerate().map(|(i, p)| plain_name(i, &p.name)).collect();
    let mut materials = String::new();
    for name in &names {
        materials += &format!("newmtl {name}\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {name}.png\n");
    }
    write(MATERIALS, materials.as_bytes())?;
    model.parts.par_iter().zip(&names).try_for_each(|(part, name)| {
        stage.at(0.0)?;
        write(&format!("{name}.png"), &encode_rgb(&part.texture)?)
    })?;

    let mut first = 1;
    let mut still = Vec::with_capacity(model.parts.len());
    for (part, name) in model.parts.iter().zip(&names) {
        still.push(faces(&part.mesh, name, first));
        first += part.mesh.positions.len();
    }
    let done = std::sync::atomic::AtomicUsize::new(0);
    (0..model.animation.len()).into_par_iter().try_for_each(|frame| {
        let n = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        stage.at(n as f64 / model.animation.len() as f64)?;
        let mut out = format!("mtllib {MATERIALS}\n").into_bytes();
        for ((mesh, name), still) in model.pose(frame).iter().zip(&names).zip(&still) {
            out.extend_from_slice(format!("o {name}\n").as_bytes());
            for position in &mesh.positions {
                number_line(&mut out, "v", &position.to_array(), 3);
            }
            for normal in &mesh.normals {
                number_line(&mut out, "vn", &normal.to_array(), 3);
            }
            out.extend_from_slice(still);
        }
        write(&frame_name(frame, "obj"), &out)
    })
}

/// The meshes alone, with report.json where there is a report, put into `target` whole or not at all.
///
/// # Errors
/// As [`write_obj`], or a target that is somebody else's ([`StagedFolder::begin`]).
pub fn write_obj_folder(target: &Path, model: &RiggedModel, report: Option<&Report>, stage: Stage<'_>) -> Result<()> {
    let folder = StagedFolder::begin(target, is_ours)?;
    stage.name("writing meshes")?;
    write_obj(folder.path(), model, stage)?;
    if let Some(report) = report {
        folder.write(REPORT, report.to_json().as_bytes())?;
    }
    stage.at(1.0)?;
    folder.commit()
}

fn is_ours(name: &str) -> bool {
    let numbered = |n: &str| n.len() >= 2 && n.bytes().all(|b| b.is_ascii_digit());
    let texture = || name.strip_suffix(".png").and_then(|n| n.split_once('_')).is_some_and(|(n, _)| numbered(n));
    [MATERIALS, REPORT].contains(&name) || is_frame(name, "obj") || texture()
}

/// Texture coordinates and faces of a part whose first vertex has the number `first`.
fn faces(mesh: &TriMesh, name: &str, first: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(mesh.uvs.len() * 16 + mesh.triangles.len() * 36);
    for uv in &mesh.uvs {
        // Here v points up.
        number_line(&mut out, "vt", &[uv.x, 1.0 - uv.y], 5);
    }
    out.extend_from_slice(format!("usemtl {name}\n").as_bytes());
    for triangle in &mesh.triangles {
        out.push(b'f');
        for corner in triangle {
            let i = first + *corner as usize;
            out.extend_from_slice(format!(" {i}/{i}/{i}").as_bytes());
        }
        out.push(b'\n');
    }
    out
}

/// A name that no reader stumbles over and that is unique by its number.
fn plain_name(index: usize, label: &str) -> String {
    let plain: String = label.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(60).collect();
    format!("{index:02}_{plain}")
}

/// `key 1.25 -3 0.5`: at most `decimals` digits after the point, none that say nothing.
fn number_line(out: &mut Vec<u8>, key: &str, values: &[f32], decimals: u32) {
    out.extend_from_slice(key.as_bytes());
    for value in values {
        out.push(b' ');
        push_number(out, *value, decimals);
    }
    out.push(b'\n');
}

/// The standard formatter takes ten times as long, and a clip has millions of numbers.
fn push_number(out: &mut Vec<u8>, value: f32, decimals: u32) {
    let unit = 10u64.pow(decimals);
    let fixed = (f64::from(value) * unit as f64).round() as i64;
    if fixed < 0 {
        out.push(b'-');
    }
    let (whole, mut rest) = (fixed.unsigned_abs() / unit, fixed.unsigned_abs() % unit);
    let mut digits = [0u8; 20];
    let mut at = digits.len();
    let mut left = whole;
    loop {
        at -= 1;
        digits[at] = b'0' + (left % 10) as u8;
        left /= 10;
        if left == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[at..]);
    let mut place = unit / 10;
    if rest > 0 {
        out.push(b'.');
    }
    while rest > 0 {
        out.push(b'0' + (rest / place) as u8);
        rest %= place;
        place /= 10;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_read_back_to_half_a_digit(value in -1e5f32..1e5, decimals in 1u32..6) {
            let mut out = Vec::new();
            push_number(&mut out, value, decimals);
            let text = String::from_utf8(out).expect("ascii");
            let back: f64 = text.parse().expect("a number");
            prop_assert!((back - f64::from(value)).abs() <= 0.501 * 0.1f64.powi(decimals as i32), "{}", text);
            prop_assert!(text != "-0" && !(text.contains('.') && text.ends_with('0')), "{}", text);
        }
    }
}
