//! Binary STL: 80 bytes that may say anything, a count, and for each triangle its normal and corners. Readers join corners
//! that lie in exactly one place, which the vertices of a [`Solid`] never do.

use crate::error::Result;
use crate::job::Stage;
use crate::shape::solid::Solid;

/// Triangles between two looks for a cancel.
const CHUNK: usize = 1 << 16;

/// A solid as a binary STL file, in mm.
///
/// # Errors
/// A cancel.
pub fn stl(solid: &Solid, stage: Stage<'_>) -> Result<Vec<u8>> {
    let mut out = Vec::with_capacity(84 + 50 * solid.triangles.len());
    // A header that began with "solid" would be taken for text.
    let mut header = [b' '; 80];
    let text = b"Binary STL, millimetres, z up";
    header[..text.len()].copy_from_slice(text);
    out.extend_from_slice(&header);
    out.extend_from_slice(&(solid.triangles.len() as u32).to_le_bytes());
    for (i, triangle) in solid.triangles.iter().enumerate() {
        if i % CHUNK == 0 {
            stage.at(i as f64 / solid.triangles.len() as f64)?;
        }
        let [a, b, c] = triangle.map(|v| solid.positions[v as usize]);
        let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero().as_vec3();
        for value in [normal, a, b, c].iter().flat_map(|v| v.to_array()) {
            out.extend_from_slice(&value.to_le_bytes());
        }
        out.extend_from_slice(&[0, 0]);
    }
    Ok(out)
}
