//! A folder of PNG pictures, with a report that says how fast they follow each other.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::Animation;
use crate::error::Result;
use crate::export::folder::{REPORT, StagedFolder};
use crate::export::masks::{frame_name, is_frame};
use crate::export::png::encode_rgba;
use crate::export::report;
use crate::job::Stage;

pub(super) fn write(path: &Path, animation: &Animation<'_>, stage: Stage<'_>) -> Result<Vec<PathBuf>> {
    let folder = StagedFolder::begin(path, |name| name == REPORT || is_frame(name, "png"))?;
    let pack = |_: usize, _: Option<&_>, now: &_| encode_rgba(now);
    animation.each(stage, pack, |frame, png| folder.write(&frame_name(frame, "png"), &png))?;
    let Animation { name, frames, fps, size, .. } = animation;
    let report = json!({
        "format": report::FORMAT,
        "animation": { "name": name, "frames": frames, "fps": fps, "width": size.0, "height": size.1 },
    });
    folder.write(REPORT, report.to_string().as_bytes())?;
    folder.commit()?;
    Ok(vec![path.to_owned()])
}
