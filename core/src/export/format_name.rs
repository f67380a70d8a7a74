//! Which of several formats a name or a file's ending stands for.

use std::path::Path;

use crate::error::{Error, Result};

/// The format called `name`, or else the one that the path's ending stands for: `.json` is Lottie, `.png` an animated PNG, no
/// ending a folder of pictures.
///
/// # Errors
/// A name or an ending that is not known.
pub(super) fn choose<T: Copy>(all: &[(T, &str)], name: Option<&str>, path: &Path) -> Result<T> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let wanted = match (name, extension.as_deref()) {
        (Some(name), _) => name,
        (None, Some("json")) => "lottie",
        (None, Some("png")) => "apng",
        (None, Some(ending)) => ending,
        (None, None) => "png-dir",
    };
    all.iter().find(|f| f.1 == wanted).map(|f| f.0).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|f| f.1).collect();
        Error::invalid("format", format!("`{wanted}` is not known"), format!("choose one of {}", names.join(", ")))
    })
}
