//! A folder that holds a clip with what is known of it: `clip.mp4`, `frames/` or `rgba/`, `strokes-k*.json`, `truth.json`,
//! `masks/`, and for rendered creatures `meshes.npz`.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

/// One measured clip.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The folder's name.
    pub name: String,
    /// The folder.
    pub dir: PathBuf,
    /// The video file or the folder of frames.
    pub clip: PathBuf,
    /// The stroke files, each with its number of key frames.
    pub strokes: Vec<(usize, PathBuf)>,
}

impl Scene {
    /// The scene in `dir`, where there is one.
    pub fn at(dir: &Path) -> Option<Self> {
        Self::with(dir, "truth.json")
    }

    /// The clip in `dir` beside which something called `known` lies.
    fn with(dir: &Path, known: &str) -> Option<Self> {
        let clip = ["clip.mp4", "frames", "rgba"].iter().map(|c| dir.join(c)).find(|c| c.exists())?;
        if !dir.join(known).exists() {
            return None;
        }
        let strokes = (1..10)
            .map(|k| (k, dir.join(format!("strokes-k{k}.json"))))
            .filter(|(_, path)| path.exists())
            .collect::<Vec<_>>();
        let name = dir.file_name()?.to_string_lossy().into_owned();
        Some(Self { name, dir: dir.to_owned(), clip, strokes })
    }

    /// All scenes in `data` and up to two folders below it, by path.
    pub fn all(data: &Path) -> Result<Vec<Self>> {
        Self::below(data, "truth.json")
    }

    /// As [`Self::all`], clips of which only the masks are known among them.
    pub fn all_masked(data: &Path) -> Result<Vec<Self>> {
        Self::below(data, "masks")
    }

    fn below(data: &Path, known: &str) -> Result<Vec<Self>> {
        fn walk(dir: &Path, known: &str, depth: usize, scenes: &mut Vec<Scene>) -> Result<()> {
            if let Some(scene) = Scene::with(dir, known) {
                scenes.push(scene);
                return Ok(());
            }
            if depth == 0 {
                return Ok(());
            }
            let entries = std::fs::read_dir(dir).with_context(|| dir.display().to_string())?;
            let mut folders: Vec<PathBuf> =
                entries.filter_map(|e| Some(e.ok()?.path())).filter(|p| p.is_dir()).collect();
            folders.sort();
            folders.iter().try_for_each(|f| walk(f, known, depth - 1, scenes))
        }
        let mut scenes = Vec::new();
        walk(data, known, 2, &mut scenes)?;
        Ok(scenes)
    }
}
