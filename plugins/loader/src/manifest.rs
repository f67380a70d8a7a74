//! `plugin.json` of a bundle: enough to list and to refuse a plugin without loading it.
//!
//! ```json
//! {"format": "marey-plugin", "version": 1, "id": "org.example.mine", "name": "Mine", "vendor": "Example",
//!  "plugin_version": "0.1.0",
//!  "files": {"linux-x86_64": {"path": "linux-x86_64/libmine.so", "sha256": "..."}}}
//! ```
//! `sha256` may be left out while a plugin is being written. Parameters are not listed: they come from the code.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use crate::refusal::{Refusal, Status};

/// The manifest's file name.
pub(crate) const NAME: &str = "plugin.json";
/// More than a list of a few files is a mistake.
const MAX_BYTES: u64 = 1 << 20;

/// What kind of machine a library is for, as bundles name it.
pub(crate) fn platform() -> String {
    format!("{}-{}", std::env::consts::OS, std::env::consts::ARCH)
}

#[derive(Clone, Debug, serde::Deserialize)]
struct Manifest {
    format: String,
    version: u32,
    id: String,
    files: BTreeMap<String, File>,
}

#[derive(Clone, Debug, serde::Deserialize)]
struct File {
    path: PathBuf,
    sha256: Option<String>,
}

/// What a bundle says of the library for this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Bundled {
    pub(crate) id: String,
    pub(crate) file: PathBuf,
    pub(crate) sha256: Option<String>,
}

/// Reads a bundle's manifest.
pub(crate) fn read(bundle: &Path) -> Result<Bundled, Refusal> {
    let path = bundle.join(NAME);
    let bad = |problem: String| {
        let remedy = "expected a manifest as docs/plugins/publishing.md shows";
        Refusal::file(Status::Format, &path, problem, remedy)
    };
    let size = std::fs::metadata(&path).map_err(|e| bad(format!("cannot be read: {e}")))?.len();
    if size > MAX_BYTES {
        return Err(bad(format!("has {size} bytes, and at most {MAX_BYTES} are allowed")));
    }
    let text = std::fs::read_to_string(&path).map_err(|e| bad(format!("cannot be read: {e}")))?;
    let manifest: Manifest = serde_json::from_str(&text).map_err(|e| bad(format!("is no manifest: {e}")))?;
    if manifest.format != "marey-plugin" {
        return Err(bad(format!("is of format `{}`", manifest.format)));
    }
    if manifest.version != 1 {
        return Err(bad(format!("is of version {}, and 1 is known here", manifest.version)));
    }
    let Some(file) = manifest.files.get(&platform()) else {
        let known: Vec<&str> = manifest.files.keys().map(String::as_str).collect();
        let remedy = format!("ask its author for one, or build it; there are: {}", known.join(", "));
        return Err(Refusal::file(Status::Format, bundle, format!("has no library for {}", platform()), remedy));
    };
    if !file.path.components().all(|c| matches!(c, Component::Normal(_))) {
        return Err(bad(format!("names {}, which leads out of the bundle", file.path.display())));
    }
    Ok(Bundled {
        id: manifest.id,
        file: bundle.join(&file.path),
        sha256: file.sha256.as_ref().map(|s| s.to_ascii_lowercase()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn manifests_are_read_or_refused_with_the_reason() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |text: &str| std::fs::write(folder.path().join(NAME), text).expect("written");
        let platform = platform();
        let good = |path: &str| {
            format!(
                r#"{{"format":"marey-plugin","version":1,"id":"org.x.y","other":3,"files":{{"{platform}":{{"path":"{path}"}}}}}}"#
            )
        };
        assert!(read(folder.path()).is_err());
        write(&good("a/libx.so"));
        assert_eq!(read(folder.path()).expect("good").file, folder.path().join("a/libx.so"));
        for bad in [
            "{".to_owned(),
            good("/etc/passwd"),
            good("../x.so"),
            good("a").replace("\"version\":1", "\"version\":2"),
            good("a").replace("marey-plugin", "other"),
            good("a").replace(&platform, "amiga-m68k"),
        ] {
            write(&bad);
            assert_eq!(read(folder.path()).expect_err(&bad).status, Status::Format);
        }
    }
}
