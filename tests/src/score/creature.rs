//! A creature's meshes against true meshes: intersection over union of silhouettes, and of 64^3 voxels of the union's
//! bounding box by winding number, after one constant shift in z for the whole clip.

use std::io::BufRead as _;
use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use glam::{DVec3, dvec3};
use marey::raster::Mask;

use super::masks;

/// How well the creature's shape was found.
#[derive(Clone, Debug)]
pub struct CreatureScore {
    /// Mean silhouette IoU, per cent.
    pub silhouette: f64,
    /// Mean voxel IoU, per cent.
    pub volume: f64,
}

struct Mesh {
    vertices: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

/// Scores the OBJ files of `meshes` against `truth` (an npz with V, frames x vertices x 3 in pixels, and F) and the true
/// silhouettes in `mask_dir`.
pub fn creature(meshes: &Path, truth: &Path, mask_dir: &Path) -> Result<CreatureScore> {
    let truth = read_truth(truth)?;
    let found: Vec<Mesh> =
        (0..truth.len()).map(|f| read_obj(&meshes.join(format!("{f:05}.obj")))).collect::<Result<_>>()?;
    let mut shifts: Vec<f64> = truth.iter().zip(&found).map(|(t, m)| middle_z(t) - middle_z(m)).collect();
    shifts.sort_by(f64::total_cmp);
    let shift = DVec3::Z * shifts[shifts.len() / 2];
    let (mut silhouette, mut volume) = (0.0, 0.0);
    for (f, (t, m)) in truth.iter().zip(&found).enumerate() {
        let mask = masks::read(&mask_dir.join(format!("{f:05}.png")))?;
        silhouette += outline(m, mask.width(), mask.height()).iou(&mask);
        let moved = Mesh { vertices: m.vertices.iter().map(|v| *v + shift).collect(), triangles: m.triangles.clone() };
        volume += voxel_iou(t, &moved);
    }
    let share = 100.0 / truth.len() as f64;
    Ok(CreatureScore { silhouette: silhouette * share, volume: volume * share })
}

fn middle_z(mesh: &Mesh) -> f64 {
    let (low, high) = bounds(mesh);
    (low.z + high.z) / 2.0
}

fn bounds(mesh: &Mesh) -> (DVec3, DVec3) {
    let fold =
        |pick: fn(DVec3, DVec3) -> DVec3, from: f64| mesh.vertices.iter().fold(DVec3::splat(from), |a, v| pick(a, *v));
    (fold(DVec3::min, f64::INFINITY), fold(DVec3::max, f64::NEG_INFINITY))
}

fn read_truth(path: &Path) -> Result<Vec<Mesh>> {
    let file = std::fs::File::open(path).with_context(|| path.display().to_string())?;
    let mut npz = zip::ZipArchive::new(file)?;
    let v = npyz::NpyFile::new(npz.by_name("V.npy").context("no array V")?)?;
    let vertices_a_frame = v.shape().get(1).copied().context("V is frames x vertices x 3")? as usize;
    let v: Vec<f64> = match v.dtype().descr().as_str() {
        "'<f4'" => v.into_vec::<f32>()?.into_iter().map(f64::from).collect(),
        "'<f2'" => anyhow::bail!("V in half precision is not read"),
        _ => v.into_vec::<f64>()?,
    };
    let f = npyz::NpyFile::new(npz.by_name("F.npy").context("no array F")?)?;
    let f: Vec<usize> = match f.dtype().descr().as_str() {
        "'<i4'" => f.into_vec::<i32>()?.into_iter().map(|i| i as usize).collect(),
        "'<u2'" => f.into_vec::<u16>()?.into_iter().map(usize::from).collect(),
        _ => f.into_vec::<i64>()?.into_iter().map(|i| i as usize).collect(),
    };
    let triangles: Vec<[usize; 3]> = f.as_chunks::<3>().0.to_vec();
    let frames = v.chunks_exact(3 * vertices_a_frame).map(|frame| Mesh {
        vertices: frame.as_chunks::<3>().0.iter().map(|p| DVec3::from_array(*p)).collect(),
        triangles: triangles.clone(),
    });
    Ok(frames.collect())
}

fn read_obj(path: &Path) -> Result<Mesh> {
    let file = std::fs::File::open(path).with_context(|| path.display().to_string())?;
    let mut mesh = Mesh { vertices: Vec::new(), triangles: Vec::new() };
    for line in std::io::BufReader::new(file).lines() {
        let line = line?;
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let xyz: Vec<f64> = words.take(3).map(str::parse).collect::<Result<_, _>>()?;
                ensure!(xyz.len() == 3, "{}: a vertex has three numbers", path.display());
                mesh.vertices.push(dvec3(xyz[0], xyz[1], xyz[2]));
            }
            Some("f") => {
                let corners: Vec<usize> =
                    words.map(|w| w.split('/').next().unwrap_or(w).parse()).collect::<Result<_, _>>()?;
                for i in 1..corners.len().saturating_sub(1) {
                    mesh.triangles.push([corners[0] - 1, corners[i] - 1, corners[i + 1] - 1]);
                }
            }
            _ => {}
        }
    }
    ensure!(!mesh.vertices.is_empty(), "{}: no vertices", path.display());
    Ok(mesh)
}

/// Calls `hit(column, row, z, sign)` wherever the ray along z through a cell's centre meets a triangle; sign is +1 for
/// triangles seen counter-clockwise from +z. Cells are `step` wide from `low`; a hair's offset keeps rays off edges.
fn scan(
    mesh: &Mesh,
    low: DVec3,
    step: DVec3,
    columns: usize,
    rows: usize,
    mut hit: impl FnMut(usize, usize, f64, i32),
) {
    let first = |v: f64| ((v - 0.5).ceil().max(0.0)) as usize;
    let last = |v: f64, n: usize| ((v - 0.5).floor()).min(n as f64 - 1.0);
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| (mesh.vertices[i] - low) / step);
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if area == 0.0 {
            continue;
        }
        let (x1, y1) = (last(a.x.max(b.x).max(c.x), columns), last(a.y.max(b.y).max(c.y), rows));
        for i in first(a.x.min(b.x).min(c.x))..columns {
            if i as f64 > x1 {
                break;
            }
            for j in first(a.y.min(b.y).min(c.y))..rows {
                if j as f64 > y1 {
                    break;
                }
                let (x, y) = (i as f64 + 0.5 + 1.37e-5, j as f64 + 0.5 + 2.11e-5);
                let u = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / area;
                let v = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / area;
                if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
                    hit(i, j, a.z + u * (b.z - a.z) + v * (c.z - a.z), if area > 0.0 { 1 } else { -1 });
                }
            }
        }
    }
}

/// Which pixels' centres the mesh covers, seen along z.
fn outline(mesh: &Mesh, width: usize, height: usize) -> Mask {
    let mut mask = Mask::new(width, height);
    scan(mesh, DVec3::ZERO, DVec3::ONE, width, height, |x, y, _, _| mask.set(x, height - 1 - y, true));
    mask
}

fn voxel_iou(a: &Mesh, b: &Mesh) -> f64 {
    const N: usize = 64;
    let ((a_low, a_high), (b_low, b_high)) = (bounds(a), bounds(b));
    let low = a_low.min(b_low) - 0.5;
    let step = (a_high.max(b_high) + 0.5 - low) / N as f64;
    let crossings = |mesh: &Mesh| {
        let mut columns: Vec<Vec<(f64, i32)>> = vec![Vec::new(); N * N];
        scan(mesh, low, step, N, N, |x, y, z, sign| columns[y * N + x].push((z, sign)));
        columns
    };
    let inside = |column: &[(f64, i32)], z: f64| column.iter().filter(|c| c.0 < z).map(|c| c.1).sum::<i32>() != 0;
    let (mut both, mut any) = (0u32, 0u32);
    for (ca, cb) in crossings(a).iter().zip(&crossings(b)) {
        for k in 0..N {
            let z = k as f64 + 0.5;
            let (ia, ib) = (inside(ca, z), inside(cb, z));
            both += u32::from(ia && ib);
            any += u32::from(ia || ib);
        }
    }
    f64::from(both) / f64::from(any.max(1))
}
