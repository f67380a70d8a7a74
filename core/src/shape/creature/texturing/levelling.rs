//! A smooth field of corrections over texels: it is asked for given steps between neighbours, and is otherwise flat.
//!
//! Least squares over the graph of neighbouring texels, seams included: the discrete Poisson equation of gradient
//! domain editing (Perez, Gangnet and Blake 2003, "Poisson image editing"), by conjugate gradients with the diagonal as
//! preconditioner. Sums are taken in an order that does not depend on threads.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::texels::Texels;
use crate::error::Result;
use crate::job::Stage;

/// The residual is this far below the first one, in levels squared, when the field is good: far below a level.
const GOOD: f64 = 1e-6;
const CHUNK: usize = 8192;

/// The corrections `c` of the texels in `free` (0 elsewhere) that make `c[i] - c[j]` for neighbours as near to
/// `step(i, j)` as they can be, and themselves small with the weight `anchor`.
pub(super) fn level(
    texels: &Texels,
    free: &[bool],
    step: impl Fn(usize, usize) -> Option<Vec3> + Sync,
    anchor: f32,
    rounds: usize,
    stage: Stage<'_>,
) -> Result<Vec<Vec3>> {
    let mut out = vec![Vec3::ZERO; texels.len()];
    let unknown: Vec<u32> = (0..free.len() as u32).filter(|&i| free[i as usize]).collect();
    if unknown.is_empty() {
        return Ok(out);
    }
    let mut row = vec![u32::MAX; free.len()];
    unknown.iter().enumerate().for_each(|(r, &i)| row[i as usize] = r as u32);
    // Right side, diagonal, and the free neighbours, up to four and those over seams; a pair without a step does not pull.
    let rows: Vec<(Vec3, f32, Vec<u32>)> = unknown
        .par_iter()
        .with_min_len(1024)
        .map(|&i| {
            let mut out = (Vec3::ZERO, anchor, Vec::new());
            for &j in texels.beside(i as usize) {
                if let Some(step) = step(i as usize, j as usize) {
                    out.0 += step;
                    out.1 += 1.0;
                    if free[j as usize] {
                        out.2.push(row[j as usize]);
                    }
                }
            }
            out
        })
        .collect();
    let apply = |x: &[Vec3]| -> Vec<Vec3> {
        let of = |(r, (_, diagonal, beside)): (usize, &(Vec3, f32, Vec<u32>))| {
            beside.iter().fold(x[r] * *diagonal, |sum, &other| sum - x[other as usize])
        };
        rows.par_iter().enumerate().with_min_len(1024).map(of).collect()
    };
    let mut x = vec![Vec3::ZERO; unknown.len()];
    let mut residual: Vec<Vec3> = rows.iter().map(|s| s.0).collect();
    let scaled = |r: &[Vec3]| -> Vec<Vec3> { r.iter().zip(&rows).map(|(r, s)| *r / s.1.max(1e-6)).collect() };
    let mut z = scaled(&residual);
    let mut way = z.clone();
    let mut product = dot(&residual, &z);
    let enough = product.max_element() * GOOD;
    for round in 0..rounds {
        stage.at(round as f64 / rounds as f64)?;
        if product.max_element() <= enough.max(1e-9) {
            break;
        }
        let bent = apply(&way);
        let curvature = dot(&way, &bent);
        let length = ratio(product, curvature);
        for (((x, r), w), b) in x.iter_mut().zip(&mut residual).zip(&way).zip(&bent) {
            *x += *w * length;
            *r -= *b * length;
        }
        z = scaled(&residual);
        let next = dot(&residual, &z);
        let keep = ratio(next, product);
        way.iter_mut().zip(&z).for_each(|(w, z)| *w = *z + *w * keep);
        product = next;
    }
    unknown.iter().zip(x).for_each(|(&i, x)| out[i as usize] = x);
    Ok(out)
}

fn ratio(a: DVec3, b: DVec3) -> Vec3 {
    let of = |a: f64, b: f64| if b > 1e-30 { (a / b) as f32 } else { 0.0 };
    Vec3::new(of(a.x, b.x), of(a.y, b.y), of(a.z, b.z))
}

/// The product of two fields a channel.
fn dot(a: &[Vec3], b: &[Vec3]) -> DVec3 {
    let chunks: Vec<DVec3> = a
        .par_chunks(CHUNK)
        .zip(b.par_chunks(CHUNK))
        .map(|(a, b)| a.iter().zip(b).fold(DVec3::ZERO, |s, (a, b)| s + (*a * *b).as_dvec3()))
        .collect();
    chunks.into_iter().fold(DVec3::ZERO, |s, c| s + c)
}
