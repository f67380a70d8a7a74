//! A mesh of one frame that was changed in a modelling tool comes back and plays in every frame.
//!
//! With as many vertices as before, in the same order, each vertex keeps its bones, and its new place is carried back
//! into the rest pose by the inverse of what moves it in that frame: the change is a displacement in the frames of the
//! bones. A mesh of another topology is bound anew: bones and weights are those of the nearest place of the old surface,
//! and it gets an atlas of its own whose colours are those of the nearest places.
//!
//! Limits: a new part that reaches far from the old surface follows its nearest place rigidly; where a pose folds the
//! skin flat, a change there cannot be carried back and is left out.

use std::path::Path;

use glam::{Mat4, Vec3};
use image::{Rgb, RgbImage};
use rayon::prelude::*;

use super::skin::{Atlas, four, surface_normals, textured};
use crate::error::{Error, Result};
use crate::geometry::TriMesh;
use crate::geometry::nearest_surface::NearestSurface;
use crate::job::Stage;
use crate::shape::{RiggedModel, SkinnedPart};

/// Places that differ by less than this, in clip pixels, are the same: what is written to OBJ has three decimals.
const SAME: f32 = 2e-3;
/// An edited mesh whose vertices are farther than this from the creature, as a share of the creature's size, in the
/// middle of all of them, is another thing or has another scale.
const FAR: f32 = 0.5;
/// Blended transforms that flatten space to less than this cannot be undone.
const FLAT: f32 = 1e-3;
/// At most so many vertices: far more than any tool of this kind makes of a creature.
const MOST: usize = 4_000_000;

/// A mesh as a modelling tool gives it back, in the world coordinates of the frame that it was taken from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EditedMesh {
    /// Vertices.
    pub positions: Vec<Vec3>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// What became of an edit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EditKind {
    /// So many vertices were displaced.
    Displaced(usize),
    /// The mesh was bound anew.
    BoundAnew,
}

impl EditedMesh {
    /// Reads a Wavefront OBJ.
    ///
    /// # Errors
    /// A file that cannot be read, and what [`Self::from_obj`] refuses.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_obj(&text).map_err(|e| e.in_file(path))
    }

    /// The vertices and faces of a Wavefront OBJ; faces of more corners are split into fans. All else is left out.
    ///
    /// # Errors
    /// A line that does not hold numbers, a face whose corners are not there, or too many vertices.
    pub fn from_obj(text: &str) -> Result<Self> {
        let mut out = Self::default();
        for (number, line) in text.lines().enumerate() {
            let bad = |problem: &str| {
                Error::invalid(format!("line {} of the mesh", number + 1), problem, "export it as Wavefront OBJ again")
            };
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let mut next = || words.next().and_then(|w| w.parse().ok()).filter(|v: &f32| v.is_finite());
                    let (Some(x), Some(y), Some(z)) = (next(), next(), next()) else {
                        return Err(bad("is no vertex of three numbers"));
                    };
                    if out.positions.len() >= MOST {
                        return Err(Error::invalid("the mesh", "has too many vertices", "decimate it first"));
                    }
                    out.positions.push(Vec3::new(x, y, z));
                }
                Some("f") => {
                    let count = out.positions.len() as i64;
                    let corner = |word: &str| -> Option<u32> {
                        let index: i64 = word.split('/').next()?.parse().ok()?;
                        let index = if index < 0 { count + index } else { index - 1 };
                        (0..count).contains(&index).then_some(index as u32)
                    };
                    let corners: Option<Vec<u32>> = words.map(corner).collect();
                    let Some(corners) = corners.filter(|c| c.len() >= 3) else {
                        return Err(bad("is a face whose corners are not there"));
                    };
                    out.triangles.extend(corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]));
                }
                _ => {}
            }
        }
        Ok(out)
    }

    fn check(&self, model: &RiggedModel, posed: &[TriMesh]) -> Result<()> {
        let bad = |problem: &str, remedy: &str| Err(Error::invalid("the edited mesh", problem, remedy));
        if self.positions.is_empty() || self.triangles.is_empty() {
            return bad("is empty", "give a mesh with faces");
        }
        if self.positions.len() > MOST {
            return bad("has too many vertices", "decimate it first");
        }
        if !self.positions.iter().all(|p| p.is_finite()) {
            return bad("has a vertex that is no number", "repair the mesh in the modelling tool");
        }
        if self.triangles.iter().flatten().any(|v| *v as usize >= self.positions.len()) {
            return bad("has a face whose corners are not there", "repair the mesh in the modelling tool");
        }
        let bounds = |points: &mut dyn Iterator<Item = Vec3>| {
            points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)))
        };
        let old = bounds(&mut posed.iter().flat_map(|m| m.positions.iter().copied()));
        let new = bounds(&mut self.positions.iter().copied());
        let size = (old.1 - old.0).length().max(1.0);
        let off = ((old.0 + old.1) / 2.0).distance((new.0 + new.1) / 2.0);
        let scale = (new.1 - new.0).length() / size;
        if off > FAR * size || !(0.2..5.0).contains(&scale) {
            return bad(
                &format!("is {off:.0} pixels beside the creature in that frame and {scale:.3} times as large"),
                "export it with the scale, the axes (Y up) and the frame that it was imported with",
            );
        }
        debug_assert!(!model.bones.is_empty());
        Ok(())
    }
}

/// Takes an edit of the mesh of `frame` into the model. The mesh is that of all parts, one after the other, as
/// `marey::export::write_obj` writes them.
///
/// # Errors
/// No such frame; a mesh that is empty, damaged, or not where the creature is in that frame; or a cancel. The model is
/// then as it was.
pub fn apply_edit(model: &mut RiggedModel, frame: usize, edit: &EditedMesh, stage: Stage<'_>) -> Result<EditKind> {
    model.validate()?;
    if frame >= model.animation.len() {
        return Err(Error::invalid(
            format!("frame {frame}"),
            "is not there",
            format!("the creature has {} frames", model.animation.len()),
        ));
    }
    stage.name("taking an edit")?;
    let posed = model.pose(frame);
    edit.check(model, &posed)?;
    let count: usize = posed.iter().map(|m| m.positions.len()).sum();
    let kind = if edit.positions.len() == count {
        displace(model, frame, &posed, &edit.positions)
    } else {
        let part = bind_anew(model, frame, &posed, edit, stage)?;
        model.parts = vec![part];
        EditKind::BoundAnew
    };
    stage.at(1.0)?;
    Ok(kind)
}

/// What moves each vertex of a part from the rest pose to a frame.
fn blends(part: &SkinnedPart, skin: &[Mat4]) -> Vec<Mat4> {
    part.bones.iter().zip(&part.weights).map(|(bones, weights)| blend(skin, bones, weights)).collect()
}

fn blend(skin: &[Mat4], bones: &[u16; 4], weights: &[f32; 4]) -> Mat4 {
    bones.iter().zip(weights).fold(Mat4::ZERO, |sum, (b, w)| sum + skin[usize::from(*b)] * *w)
}

fn skin(model: &RiggedModel, frame: usize) -> Vec<Mat4> {
    let rest = model.world(&model.rest);
    model.world(&model.animation[frame]).into_iter().zip(rest).map(|(now, rest)| now * rest.inverse()).collect()
}

/// The place in the rest pose that a blend takes to `place`.
fn back(blend: &Mat4, place: Vec3) -> Option<Vec3> {
    if blend.determinant().abs() < FLAT {
        return None;
    }
    Some(blend.inverse().transform_point3(place)).filter(|p| p.is_finite())
}

fn displace(model: &mut RiggedModel, frame: usize, posed: &[TriMesh], edited: &[Vec3]) -> EditKind {
    let skin = skin(model, frame);
    let (mut first, mut moved) = (0, 0);
    for (part, now) in model.parts.iter_mut().zip(posed) {
        let n = now.positions.len();
        let edited = &edited[first..first + n];
        first += n;
        let surface = now.surface();
        let count = surface.iter().map(|s| *s as usize + 1).max().unwrap_or(0);
        // Of the vertices at one place on a seam the one that was moved farthest decides, so that the surface stays closed.
        let mut far: Vec<Option<(f32, usize)>> = vec![None; count];
        for v in 0..n {
            let d = edited[v].distance(now.positions[v]);
            let best = &mut far[surface[v] as usize];
            if best.is_none_or(|b| d > b.0) {
                *best = Some((d, v));
            }
        }
        let blends = blends(part, &skin);
        let before = part.mesh.positions.clone();
        let mut places: Vec<Option<Vec3>> = vec![None; count];
        for (s, best) in far.iter().enumerate() {
            if let Some((d, v)) = best.filter(|b| b.0 > SAME) {
                debug_assert!(d.is_finite());
                places[s] = back(&blends[v], edited[v]);
            }
        }
        for v in 0..n {
            if let Some(place) = places[surface[v] as usize] {
                part.mesh.positions[v] = place;
                moved += 1;
            }
        }
        if part.mesh.positions != before {
            let normals = part.mesh.smooth_normals();
            part.mesh.normals = normals;
        }
    }
    EditKind::Displaced(moved)
}

/// All parts as one mesh in the pose, with the part and the vertex of each vertex.
#[expect(clippy::type_complexity, reason = "three lists, taken apart at once")]
fn together(posed: &[TriMesh]) -> (Vec<Vec3>, Vec<[u32; 3]>, Vec<(u16, u32)>) {
    let (mut places, mut triangles, mut from) = (Vec::new(), Vec::new(), Vec::new());
    for (i, mesh) in posed.iter().enumerate() {
        let base = places.len() as u32;
        places.extend(&mesh.positions);
        from.extend((0..mesh.positions.len() as u32).map(|v| (i as u16, v)));
        triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + base)));
    }
    (places, triangles, from)
}

fn bind_anew(
    model: &RiggedModel,
    frame: usize,
    posed: &[TriMesh],
    edit: &EditedMesh,
    stage: Stage<'_>,
) -> Result<SkinnedPart> {
    let skin = skin(model, frame);
    let (places, triangles, from) = together(posed);
    let old = NearestSurface::new(&places, &triangles);
    let held = |corner: u32| {
        let (part, v) = from[corner as usize];
        (&model.parts[usize::from(part)], v as usize)
    };
    let bound: Vec<(Vec3, [u16; 4], [f32; 4])> = edit
        .positions
        .par_iter()
        .map(|&p| {
            stage.at(0.1)?;
            let nearest = old.find(p).ok_or_else(|| Error::invalid("the model", "has no surface", "build it anew"))?;
            let mut all: Vec<(u16, f32)> = Vec::with_capacity(12);
            for (corner, share) in triangles[nearest.triangle].into_iter().zip(nearest.shares) {
                let (part, v) = held(corner);
                for (bone, weight) in part.bones[v].iter().zip(part.weights[v]) {
                    match all.iter_mut().find(|a| a.0 == *bone) {
                        Some(one) => one.1 += share * weight,
                        None => all.push((*bone, share * weight)),
                    }
                }
            }
            let (bones, weights) = four(all);
            let rest = back(&blend(&skin, &bones, &weights), p).unwrap_or_else(|| {
                // Folded flat: the nearest place's own rest.
                let corners = triangles[nearest.triangle].into_iter().zip(nearest.shares);
                corners.map(|(c, s)| held(c).0.mesh.positions[held(c).1] * s).sum()
            });
            Ok((rest, bones, weights))
        })
        .collect::<Result<_>>()?;
    let rest: Vec<Vec3> = bound.iter().map(|b| b.0).collect();
    // The limb of a vertex is that of its heaviest bone: bones are called "limb.number".
    let limb_of_bone: Vec<u16> = {
        let mut names: Vec<&str> = Vec::new();
        let limb = |name: &'_ str| name.rsplit_once('.').map_or(name.len(), |(l, _)| l.len());
        model
            .bones
            .iter()
            .map(|b| {
                let name = &b.name[..limb(&b.name)];
                let at = names.iter().position(|n| *n == name).unwrap_or(names.len());
                if at == names.len() {
                    names.push(name);
                }
                at as u16
            })
            .collect()
    };
    let limb: Vec<u16> = bound.iter().map(|b| limb_of_bone[usize::from(b.1[0])]).collect();
    let normals = surface_normals(&rest, &edit.triangles);
    let (mesh, atlas) = textured(&rest, &normals, &edit.triangles, &limb, model.size.1 as f32);
    let texture = repaint(model, &mesh, &atlas, edit, &old, &triangles, &from, stage)?;
    Ok(SkinnedPart {
        name: "skin".into(),
        bones: atlas.vertex.iter().map(|v| bound[*v as usize].1).collect(),
        weights: atlas.vertex.iter().map(|v| bound[*v as usize].2).collect(),
        mesh,
        texture,
    })
}

/// The new atlas' colours: for each texel that of the nearest place of the old surface.
fn repaint(
    model: &RiggedModel,
    mesh: &TriMesh,
    atlas: &Atlas,
    edit: &EditedMesh,
    old: &NearestSurface<'_>,
    triangles: &[[u32; 3]],
    from: &[(u16, u32)],
    stage: Stage<'_>,
) -> Result<RgbImage> {
    let (w, h) = (atlas.size.0 as usize, atlas.size.1 as usize);
    let color_at = |p: Vec3| -> Option<[f32; 3]> {
        let nearest = old.find(p)?;
        let corners = triangles[nearest.triangle].map(|c| from[c as usize]);
        let part = &model.parts[usize::from(corners[0].0)];
        let uv: glam::Vec2 =
            corners.into_iter().zip(nearest.shares).map(|((_, v), s)| part.mesh.uvs[v as usize] * s).sum();
        let (tw, th) = part.texture.dimensions();
        let (x, y) = ((uv.x * tw as f32) as u32, (uv.y * th as f32) as u32);
        Some(part.texture.get_pixel(x.min(tw - 1), y.min(th - 1)).0.map(f32::from))
    };
    let painted: Vec<Vec<(usize, [f32; 3])>> = mesh
        .triangles
        .par_chunks(256)
        .map(|some| {
            stage.at(0.5)?;
            let mut out = Vec::new();
            for t in some {
                let at = t.map(|v| mesh.uvs[v as usize] * glam::vec2(w as f32, h as f32));
                let places = t.map(|v| edit.positions[atlas.vertex[v as usize] as usize]);
                let (low, high) = (at[0].min(at[1]).min(at[2]) - 1.0, at[0].max(at[1]).max(at[2]) + 1.0);
                let area = (at[1] - at[0]).perp_dot(at[2] - at[0]);
                for y in low.y.max(0.0) as usize..=(high.y.max(0.0) as usize).min(h - 1) {
                    for x in low.x.max(0.0) as usize..=(high.x.max(0.0) as usize).min(w - 1) {
                        let p = glam::vec2(x as f32 + 0.5, y as f32 + 0.5);
                        let s = [1, 2, 0].map(|i| (at[(i + 1) % 3] - at[i]).perp_dot(p - at[i]) / area);
                        // A texel's width beyond the border, for those that lie half outside.
                        if s.iter().all(|s| *s >= -0.02 - 0.7 / area.abs().sqrt().max(1.0)) {
                            let inside = s.map(|s| s.clamp(0.0, 1.0));
                            let sum: f32 = inside.iter().sum();
                            let place = (places[0] * inside[0] + places[1] * inside[1] + places[2] * inside[2]) / sum;
                            out.extend(color_at(place).map(|c| (y * w + x, c)));
                        }
                    }
                }
            }
            Ok(out)
        })
        .collect::<Result<_>>()?;
    let mut color = vec![[0.0f32; 3]; w * h];
    let mut known = crate::raster::Grid::new(w, h, false);
    for (at, c) in painted.into_iter().flatten() {
        color[at] = c;
        known.data_mut()[at] = true;
    }
    crate::raster::push_pull(&mut color, &known, crate::raster::Wrap::default(), [128.0; 3]);
    Ok(RgbImage::from_fn(w as u32, h as u32, |x, y| {
        Rgb(color[y as usize * w + x as usize].map(|v| v.round().clamp(0.0, 255.0) as u8))
    }))
}
