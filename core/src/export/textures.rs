//! Textures out and in: one PNG a part, to be painted on in any program and read back.
//!
//! A part's file is called like the part. A picture that comes back may have another size, if its proportions are the
//! texture's: texture coordinates are shares, so they hold. Where it is clear, the texture stays as it was.

use std::path::{Path, PathBuf};

use image::imageops::FilterType;
use image::{Rgb, RgbImage, RgbaImage};

use super::png::encode_rgb;
use super::write_aside::write_all_aside;
use crate::error::{Error, Result};
use crate::shape::RiggedModel;
use crate::shape::character::read_drawing;

/// Longest side of a texture that is read: what renderers on small devices still take.
const MAX_SIDE: u32 = 8192;

/// The name of every part's texture file, unique, and safe in any file system.
pub fn texture_names(model: &RiggedModel) -> Vec<String> {
    let mut names: Vec<String> = Vec::with_capacity(model.parts.len());
    for (i, part) in model.parts.iter().enumerate() {
        let safe = |c: char| if c.is_alphanumeric() || "-_ ".contains(c) { c } else { '_' };
        let mut name: String = part.name.chars().map(safe).take(80).collect();
        // File systems that do not tell cases apart would write one over the other.
        let taken = |n: &String| n.to_lowercase() == format!("{}.png", name.to_lowercase());
        if name.trim().is_empty() || names.iter().any(taken) {
            name = format!("{name}-{i}");
        }
        names.push(format!("{name}.png"));
    }
    names
}

/// Writes the texture of every part into `folder`, which is made if it is not there: all files or none. The files'
/// paths.
///
/// # Errors
/// A model that is not valid or a folder that cannot be written.
pub fn write_textures(model: &RiggedModel, folder: impl AsRef<Path>) -> Result<Vec<PathBuf>> {
    let folder = folder.as_ref();
    model.validate()?;
    let files: Vec<(PathBuf, Vec<u8>)> = texture_names(model)
        .into_iter()
        .zip(&model.parts)
        .map(|(name, part)| Ok((folder.join(name), encode_rgb(&part.texture)?)))
        .collect::<Result<_>>()?;
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "create", e))?;
    write_all_aside(&files)?;
    Ok(files.into_iter().map(|(path, _)| path).collect())
}

/// Puts the pictures in `folder` that [`write_textures`] named into the model; parts without one stay as they are. The
/// parts that were changed, by name.
///
/// # Errors
/// No such picture, one that cannot be read, or one of other proportions. The model is then as it was.
pub fn read_textures(model: &mut RiggedModel, folder: impl AsRef<Path>) -> Result<Vec<String>> {
    let folder = folder.as_ref();
    if !folder.is_dir() {
        return Err(Error::file(folder, "is no folder", "give the folder that the textures were written into"));
    }
    let names = texture_names(model);
    let mut found: Vec<(usize, RgbImage)> = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let path = folder.join(name);
        if path.is_file() {
            let painted = read_drawing(&path)?;
            found.push((i, painted_on(&model.parts[i].texture, &painted).map_err(|e| e.in_file(&path))?));
        }
    }
    if found.is_empty() {
        return Err(Error::file(
            folder,
            "holds no texture of this creature",
            format!("expected at least one of {}", names.join(", ")),
        ));
    }
    Ok(found
        .into_iter()
        .map(|(i, texture)| {
            model.parts[i].texture = texture;
            model.parts[i].name.clone()
        })
        .collect())
}

/// The texture with `painted` laid over it, at the painted size.
///
/// # Errors
/// A picture that is empty, too large, or of other proportions than the texture.
pub fn painted_on(texture: &RgbImage, painted: &RgbaImage) -> Result<RgbImage> {
    let ((w, h), (pw, ph)) = (texture.dimensions(), painted.dimensions());
    if pw == 0 || ph == 0 || pw > MAX_SIDE || ph > MAX_SIDE {
        let problem = format!("is {pw}x{ph}");
        return Err(Error::invalid(
            "the texture",
            problem,
            format!("give one of at most {MAX_SIDE} texels along a side"),
        ));
    }
    // A texel of rounding may be lost where a picture is scaled.
    let off = (u64::from(pw) * u64::from(h)).abs_diff(u64::from(ph) * u64::from(w));
    if off > u64::from(w.max(h).max(pw).max(ph)) {
        return Err(Error::invalid(
            "the texture",
            format!("is {pw}x{ph}"),
            format!("give it as {w}x{h}, or scaled with the same proportions"),
        ));
    }
    let below = if (pw, ph) == (w, h) {
        texture.clone()
    } else {
        image::imageops::resize(texture, pw, ph, FilterType::Triangle)
    };
    Ok(RgbImage::from_fn(pw, ph, |x, y| {
        let ([r, g, b, a], old) = (painted.get_pixel(x, y).0, below.get_pixel(x, y).0);
        let over = |new: u8, old: u8| {
            let (new, old, a) = (u32::from(new), u32::from(old), u32::from(a));
            ((new * a + old * (255 - a) + 127) / 255) as u8
        };
        Rgb([over(r, old[0]), over(g, old[1]), over(b, old[2])])
    }))
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec2, Vec3};
    use image::Rgba;

    use super::*;
    use crate::geometry::TriMesh;
    use crate::shape::{Bone, SkinnedPart, Transform};

    fn model() -> RiggedModel {
        let part = |name: &str, shade: u8| SkinnedPart {
            name: name.into(),
            mesh: TriMesh {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                normals: vec![Vec3::Z; 3],
                uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
                triangles: vec![[0, 1, 2]],
            },
            bones: vec![[0; 4]; 3],
            weights: vec![[1.0, 0.0, 0.0, 0.0]; 3],
            texture: RgbImage::from_fn(40, 20, |x, y| Rgb([shade, x as u8, y as u8])),
        };
        let rest = vec![Transform { translation: Vec3::ZERO, rotation: Quat::IDENTITY }];
        RiggedModel {
            size: (10, 10),
            fps: 25.0,
            bones: vec![Bone { name: "root".into(), parent: None }],
            rest: rest.clone(),
            animation: vec![rest],
            parts: vec![part("leg/near", 1), part("LEG_near", 2), part("", 3)],
        }
    }

    #[test]
    fn a_painted_texture_comes_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let before = model();
        let files = write_textures(&before, folder.path().join("textures")).expect("written");
        assert_eq!(files.len(), 3);
        let mut after = before.clone();
        after.parts.iter_mut().for_each(|p| p.texture = RgbImage::new(40, 20));
        assert_eq!(read_textures(&mut after, folder.path().join("textures")).expect("read").len(), 3);
        assert!(after == before);

        // Somebody paints twice as large, and leaves all but a corner clear.
        let painted = RgbaImage::from_fn(80, 40, |x, _| if x < 10 { Rgba([9, 9, 9, 255]) } else { Rgba([0; 4]) });
        painted.save(&files[1]).expect("saved");
        std::fs::remove_file(&files[0]).expect("removed");
        assert_eq!(read_textures(&mut after, folder.path().join("textures")).expect("read")[0], "LEG_near");
        let texture = &after.parts[1].texture;
        assert_eq!(texture.dimensions(), (80, 40));
        assert_eq!((texture.get_pixel(5, 5).0, texture.get_pixel(60, 5).0[0]), ([9, 9, 9], 2));
        assert!(after.parts[0] == before.parts[0]);
    }

    #[test]
    fn what_does_not_fit_is_refused_and_nothing_changes() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut after = model();
        let refused = |after: &mut RiggedModel, what: &str| {
            let error = read_textures(after, folder.path()).expect_err(what).to_string();
            assert!(error.contains(what), "{error}");
            assert!(*after == model());
        };
        refused(&mut after, "holds no texture");
        let files = write_textures(&after, folder.path()).expect("written");
        RgbaImage::from_pixel(40, 30, Rgba([1, 2, 3, 255])).save(&files[2]).expect("saved");
        refused(&mut after, "40x30");
        std::fs::write(&files[2], b"\x89PNG\r\n\x1a\nnothing more").expect("written");
        refused(&mut after, "-2.png");
        let missing = read_textures(&mut after, folder.path().join("elsewhere"));
        assert!(missing.expect_err("no folder").to_string().contains("is no folder"));
    }
}
