//! A character's take as a scene that engines and editors play: bones, weights and correctives, or pictures.

mod atlas;
pub mod character_gltf;
mod deform;
pub mod dragonbones;
mod keys;
pub mod lottie;
mod parts;
mod puppet;
pub mod spine;

use std::path::{Path, PathBuf};

use super::take::{TakeFiles, TakeOptions, TakeSubject};
use crate::error::{Error, Result};

/// Formats name bones by 16 bits; each of ours may need three.
const MOST_BONES: usize = 16_384;

/// Checks what is to be written.
fn check(subject: TakeSubject<'_>, options: &TakeOptions) -> Result<()> {
    super::take::check(subject, options)?;
    if subject.character.skeleton.bones.len() > MOST_BONES {
        let (value, max) = (subject.character.skeleton.bones.len() as u64, MOST_BONES as u64);
        return Err(Error::Limit { what: "the bone count".into(), value, max, remedy: "take bones away".into() });
    }
    Ok(())
}

/// The character's name as files and editors can take it: without control characters, never empty.
fn plain_name(name: &str) -> String {
    let kept: String = name.chars().filter(|c| !c.is_control()).collect();
    if kept.trim().is_empty() { "character".into() } else { kept.trim().into() }
}

/// The file beside `path` of the same name with another ending.
fn beside(path: &Path, ending: &str) -> Result<(PathBuf, String)> {
    let stem = path.file_stem().filter(|s| !s.is_empty());
    let Some(stem) = stem else {
        return Err(Error::file(path, "names no file", "give the name of a file"));
    };
    let Some(stem) = stem.to_str().filter(|s| !s.chars().any(char::is_control)) else {
        return Err(Error::file(
            path,
            "has a name that is no plain text",
            "the files name each other: choose a plain name",
        ));
    };
    let name = format!("{stem}{ending}");
    if path.file_name().is_some_and(|n| n.to_str() == Some(&name)) {
        let remedy = "the main file is JSON: end its name with .json";
        return Err(Error::file(path, format!("is also the name of the {ending} file beside it"), remedy));
    }
    Ok((path.with_file_name(&name), name))
}

/// What is said of files that show the whole picture.
fn written(subject: TakeSubject<'_>, files: Vec<PathBuf>) -> TakeFiles {
    let (width, height) = subject.character.size;
    TakeFiles { files, shown: [0, 0, width as i32, height as i32], frames: subject.take.frames.len() }
}

/// A number with so many decimals at most, as JSON has it: without ends that say nothing.
fn number(value: f64, decimals: i32) -> serde_json::Value {
    let scale = 10f64.powi(decimals);
    let rounded = (value * scale).round() / scale;
    if rounded == rounded.trunc() && rounded.abs() < 1e15 {
        serde_json::Value::from(rounded as i64)
    } else {
        serde_json::Value::from(rounded)
    }
}

fn numbers(values: impl IntoIterator<Item = f64>, decimals: i32) -> serde_json::Value {
    values.into_iter().map(|v| number(v, decimals)).collect()
}

fn json_bytes(value: &serde_json::Value) -> Result<Vec<u8>> {
    serde_json::to_vec(value)
        .map_err(|e| Error::invalid("the take", format!("cannot be told in JSON: {e}"), "report this"))
}

#[cfg(test)]
mod tests;
