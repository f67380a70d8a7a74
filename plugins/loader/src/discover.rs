//! Where plugins lie: libraries (`*.so`) and bundles (`*.marey`, a folder with a `plugin.json`) in the given folders,
//! at most two folders deep. Names that start with `@` or `.` are passed over, and so are links that lead out of the
//! folder.

use std::path::{Path, PathBuf};

use crate::manifest::{self, Bundled};
use crate::refusal::{Refusal, Status};

const MAX_DEPTH: usize = 2;
const MAX_FILES: usize = 4096;

/// A library to load.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Candidate {
    pub(crate) file: PathBuf,
    /// What its bundle's manifest says of it.
    pub(crate) id: Option<String>,
    pub(crate) sha256: Option<String>,
}

/// What lies in `folders`, in their order and by name; each file once.
pub(crate) fn discover(folders: &[PathBuf]) -> Vec<Result<Candidate, Refusal>> {
    let mut found = Vec::new();
    for folder in folders {
        let Ok(root) = folder.canonicalize() else { continue };
        let mut count = 0;
        walk(&root, &root, 0, &mut count, &mut found);
    }
    let mut seen = std::collections::HashSet::new();
    found.retain(|c| match c {
        Ok(candidate) => seen.insert(candidate.file.clone()),
        Err(_) => true,
    });
    found
}

/// A library or a bundle that was named.
pub(crate) fn named(path: &Path) -> Result<Candidate, Refusal> {
    let full = path.canonicalize().map_err(|e| {
        Refusal::file(Status::NotFound, path, format!("cannot be opened: {e}"), "name a library or a bundle")
    })?;
    if full.is_dir() { bundle(&full) } else { Ok(Candidate { file: full, id: None, sha256: None }) }
}

fn bundle(path: &Path) -> Result<Candidate, Refusal> {
    let Bundled { id, file, sha256 } = manifest::read(path)?;
    let inside = file.canonicalize().ok().filter(|f| f.starts_with(path));
    let Some(file) = inside else {
        let problem = format!("names {}, which is not there or lies outside", file.display());
        return Err(Refusal::file(Status::NotFound, path, problem, "install the bundle again"));
    };
    Ok(Candidate { file, id: Some(id), sha256 })
}

fn walk(root: &Path, folder: &Path, depth: usize, count: &mut usize, found: &mut Vec<Result<Candidate, Refusal>>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    paths.sort();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let Ok(full) = path.canonicalize() else { continue };
        if name.starts_with(['@', '.']) || !full.starts_with(root) {
            continue;
        }
        *count += 1;
        if *count > MAX_FILES {
            let problem = format!("holds more than {MAX_FILES} files");
            found.push(Err(Refusal::file(Status::NotFound, root, problem, "give plugins a folder of their own")));
            return;
        }
        let library = path.extension().is_some_and(|e| e == std::env::consts::DLL_EXTENSION);
        if full.is_dir() && path.extension().is_some_and(|e| e == "marey") {
            found.push(bundle(&full));
        } else if full.is_dir() && depth < MAX_DEPTH {
            walk(root, &full, depth + 1, count, found);
        } else if library && full.is_file() {
            found.push(Ok(Candidate { file: full, id: None, sha256: None }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_and_bundles_are_found_in_order_and_traps_are_passed_over() {
        let root = tempfile::tempdir().expect("a folder");
        let root = root.path().canonicalize().expect("a folder");
        let (first, second, outside) = (root.join("first"), root.join("second"), root.join("outside"));
        for folder in [&first.join("a/b/c"), &second, &outside, &second.join("x.marey/lib")] {
            std::fs::create_dir_all(folder).expect("a folder");
        }
        for file in ["first/@off.so", "first/.hidden.so", "first/a/b/deep.so", "first/a/b/c/too_deep.so"] {
            std::fs::write(root.join(file), "").expect("written");
        }
        for file in ["second/z.so", "second/note.txt", "second/x.marey/lib/x.so", "outside/evil.so"] {
            std::fs::write(root.join(file), "").expect("written");
        }
        let manifest = format!(
            r#"{{"format":"marey-plugin","version":1,"id":"org.x.x","files":{{"{}":{{"path":"lib/x.so"}}}}}}"#,
            manifest::platform()
        );
        std::fs::write(second.join("x.marey/plugin.json"), manifest).expect("written");
        std::os::unix::fs::symlink(outside.join("evil.so"), first.join("link.so")).expect("linked");
        let found = discover(&[first.clone(), root.join("none"), second.clone(), first.clone()]);
        let files: Vec<PathBuf> = found.into_iter().map(|c| c.expect("good").file).collect();
        assert_eq!(files, [first.join("a/b/deep.so"), second.join("x.marey/lib/x.so"), second.join("z.so")]);
    }
}
