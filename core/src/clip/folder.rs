//! A folder of numbered images as a clip, and a single image as a clip of one frame.
//!
//! The order is that of the numbers, so `2.png` comes before `10.png`. What makes a series is the name around the last
//! number in it; two series in one folder are refused rather than guessed at. Files are judged by their content.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::{DynamicImage, ImageDecoder, ImageReader};

use super::source::{Damage, Decoded, Source, Stream};
use super::{Attempt, ClipInfo, ClipOptions, Opened, Picture, check_pixels};
use crate::error::{Error, Result};
use crate::job::Stage;

const EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "webp"];

struct Folder(Arc<Series>);

struct Series {
    paths: Vec<PathBuf>,
    size: (u32, u32),
    max_pixels: u64,
}

struct Images {
    series: Arc<Series>,
    next: usize,
}

/// The part of a file's name before its last number, the number, and the part after it.
fn split_number(stem: &str) -> Option<(&str, u64, &str)> {
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |i| {
        // The character found may be of several bytes.
        i + stem[i..].chars().next().map_or(1, char::len_utf8)
    });
    Some((&stem[..start], stem[start..end].parse().ok()?, &stem[end..]))
}

pub(super) fn open(path: &Path, options: &ClipOptions, stage: Stage<'_>) -> Attempt<Opened> {
    let mut warnings = Vec::new();
    let paths = series_in(path, &mut warnings, stage)?;
    open_series(path, paths, warnings, options, stage)
}

/// A single image.
pub(super) fn open_still(path: &Path, options: &ClipOptions, stage: Stage<'_>) -> Attempt<Opened> {
    open_series(path, vec![path.to_owned()], Vec::new(), options, stage)
}

/// The numbered images of the folder, in order.
fn series_in(path: &Path, warnings: &mut Vec<String>, stage: Stage<'_>) -> Result<Vec<PathBuf>> {
    const EXPECTED: &str = "expected images like 00000.png, 00001.png, ... of one series";
    let mut series: BTreeMap<(String, String), BTreeMap<u64, PathBuf>> = BTreeMap::new();
    let mut unnumbered = Vec::new();
    for entry in std::fs::read_dir(path).map_err(|e| Error::io(path, "read", e))? {
        stage.at(0.0)?;
        let file = entry.map_err(|e| Error::io(path, "read", e))?.path();
        let extension = file.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let hidden = file.file_name().is_none_or(|n| n.to_string_lossy().starts_with('.'));
        if hidden || !extension.is_some_and(|e| EXTENSIONS.contains(&e.as_str())) || file.is_dir() {
            continue;
        }
        let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let Some((before, number, after)) = split_number(&stem) else {
            unnumbered.push(file);
            continue;
        };
        let images = series.entry((before.to_owned(), after.to_owned())).or_default();
        if let Some(other) = images.insert(number, file.clone()) {
            let (a, b) = (name_of(&other), name_of(&file));
            let (a, b) = if a < b { (a, b) } else { (b, a) };
            return Err(Error::file(path, format!("holds both {a} and {b} for frame {number}"), "remove one of them"));
        }
    }
    unnumbered.sort();
    let mut found = series.into_iter();
    let Some((_, images)) = found.next() else {
        return match unnumbered.as_slice() {
            [] => Err(Error::file(path, "holds no images", EXPECTED)),
            [_] => Ok(unnumbered),
            [first, ..] => {
                Err(Error::file(path, format!("holds images without a number, like {}", name_of(first)), EXPECTED))
            }
        };
    };
    if let Some((_, others)) = found.next() {
        let examples = [&images, &others].map(|s| {
            let name = s.values().next().map_or_else(String::new, |p| name_of(p));
            format!("{name} ({} images)", s.len())
        });
        let problem = format!("holds more than one series of images: {} and {}", examples[0], examples[1]);
        return Err(Error::file(path, problem, "keep one series in a folder"));
    }
    if let Some(first) = unnumbered.first() {
        warnings.push(format!("{} has no number and is left out", name_of(first)));
    }
    let numbers: Vec<u64> = images.keys().copied().collect();
    let gap = numbers.windows(2).enumerate().find(|(_, w)| w[1] > w[0] + 1);
    if let Some((i, w)) = gap {
        let missing = numbers[numbers.len() - 1] - numbers[0] + 1 - numbers.len() as u64;
        warnings.push(format!(
            "{missing} numbers are missing, the first after {}; frame {} is {}",
            name_of(&images[&w[0]]),
            i + 1,
            name_of(&images[&w[1]])
        ));
    }
    Ok(images.into_values().collect())
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn open_series(
    path: &Path,
    paths: Vec<PathBuf>,
    mut warnings: Vec<String>,
    options: &ClipOptions,
    stage: Stage<'_>,
) -> Attempt<Opened> {
    let mut size = None;
    let mut unreadable = None;
    for (frame, file) in paths.iter().enumerate() {
        stage.at(frame as f64 / paths.len() as f64)?;
        let this = match decoder(file).and_then(|mut d| oriented_size(&mut d)) {
            Ok(size) => size,
            Err(why) => {
                warnings.push(format!("frame {frame} ({}) is damaged: {why}", name_of(file)));
                unreadable.get_or_insert((file, why));
                continue;
            }
        };
        check_pixels(file, this.0, this.1, options)?;
        let (w, h) = *size.get_or_insert(this);
        if this != (w, h) {
            let problem = format!("is {}x{} pixels, unlike the {w}x{h} of the frames before it", this.0, this.1);
            return Err(Error::file(file, problem, "all frames of a clip need one size").into());
        }
    }
    let Some(size) = size else {
        let (file, why) = unreadable.map_or((path, "holds no images".to_owned()), |(f, why)| (f.as_path(), why));
        return Err(Error::file(file, format!("is no readable image: {why}"), "expected PNG, JPEG or WebP").into());
    };
    let fps = if options.images_fps.is_finite() && options.images_fps > 0.0 { options.images_fps } else { 24.0 };
    let info = ClipInfo { width: size.0, height: size.1, frames: paths.len(), fps, source: "images", warnings };
    let times = (0..paths.len()).map(|i| i as f64 / fps).collect();
    let series = Series { paths, size, max_pixels: options.max_pixels };
    Ok(Opened { info, times, pictures: None, source: Box::new(Folder(Arc::new(series))) })
}

type Decoding<T> = std::result::Result<T, String>;

fn decoder(path: &Path) -> Decoding<impl ImageDecoder> {
    let file = std::fs::File::open(path).map_err(|e| e.to_string())?;
    let reader = ImageReader::new(BufReader::new(file)).with_guessed_format().map_err(|e| e.to_string())?;
    reader.into_decoder().map_err(|e| e.to_string())
}

/// The size once turned as the camera says.
fn oriented_size(decoder: &mut impl ImageDecoder) -> Decoding<(u32, u32)> {
    use image::metadata::Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    let (w, h) = decoder.dimensions();
    let turned = decoder.orientation().map_err(|e| e.to_string())?;
    Ok(if matches!(turned, Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH) { (h, w) } else { (w, h) })
}

fn read(series: &Series, path: &Path) -> Decoding<Picture> {
    let mut decoder = decoder(path)?;
    if oriented_size(&mut decoder)? != series.size {
        return Err("its size has changed since the clip was opened".to_owned());
    }
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(series.max_pixels.saturating_mul(16));
    decoder.set_limits(limits).map_err(|e| e.to_string())?;
    let orientation = decoder.orientation().map_err(|e| e.to_string())?;
    let mut image = DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())?;
    image.apply_orientation(orientation);
    if image.color().has_alpha() {
        let rgba = image.into_rgba8();
        Ok(Picture::from_rgba(rgba.as_raw(), rgba.width(), rgba.height()))
    } else {
        Ok(Picture::new(image.into_rgb8(), None))
    }
}

impl Source for Folder {
    fn restart(&self, picture: usize) -> usize {
        picture
    }

    fn stream(&self, picture: usize) -> Result<Box<dyn Stream>> {
        Ok(Box::new(Images { series: Arc::clone(&self.0), next: picture }))
    }

    fn max_streams(&self) -> usize {
        64
    }
}

impl Stream for Images {
    fn next(&mut self) -> Result<Option<(usize, Decoded)>> {
        let Some(path) = self.series.paths.get(self.next) else { return Ok(None) };
        let number = self.next;
        self.next += 1;
        Ok(Some((
            number,
            match read(&self.series, path) {
                Ok(picture) => Decoded::Picture(Arc::new(picture)),
                Err(why) => Decoded::Damaged(Damage { why: format!("{}: {why}", name_of(path)), first: number }),
            },
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_number_of_a_name_counts() {
        assert_eq!(split_number("00012"), Some(("", 12, "")));
        assert_eq!(split_number("cow1_0007"), Some(("cow1_", 7, "")));
        assert_eq!(split_number("é7 left"), Some(("é", 7, " left")));
        assert_eq!(split_number("cover"), None);
        assert_eq!(split_number("99999999999999999999999"), None, "no frame has that number");
    }
}
