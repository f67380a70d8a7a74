//! What the program brings along to try it with.

use std::path::{Path, PathBuf};

const CLIP: &[u8] = include_bytes!("../../../data/fox/clip.mp4");
const STROKES: &str = include_str!("../../../data/fox/strokes-k3.json");

/// The clip of the fox, put where it can be opened; a copy that is there already is taken.
pub(crate) fn clip(folder: &Path) -> std::io::Result<PathBuf> {
    let path = folder.join("fox.mp4");
    if std::fs::metadata(&path).is_ok_and(|m| m.len() == CLIP.len() as u64) {
        return Ok(path);
    }
    let mut aside = tempfile::NamedTempFile::new_in(folder)?;
    std::io::Write::write_all(&mut aside, CLIP)?;
    aside.persist(&path).map_err(|e| e.error)?;
    Ok(path)
}

/// The fox as it was drawn on three frames, the text of a strokes.json.
pub(crate) fn strokes() -> &'static str {
    STROKES
}
