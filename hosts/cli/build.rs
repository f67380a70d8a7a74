//! Lists the files of the plugin sdk for `marey plugin new`, which writes them into new projects.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The crates that a project brings along: their folders here, and there.
const CRATES: [(&str, &str); 2] = [("sdk", "marey-plugin"), ("abi-rs", "marey-plugin-abi")];

fn main() {
    let manifest = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let plugins = manifest.join("../../plugins");
    let mut list = String::from("[\n");
    for (folder, name) in CRATES {
        let own = plugins.join(folder);
        println!("cargo::rerun-if-changed={}", own.display());
        let cargo = own.join("Cargo.toml");
        let text = standalone(&std::fs::read_to_string(&cargo).unwrap_or_default());
        let _ = writeln!(list, "({:?}, {text:?}),", format!("{name}/Cargo.toml"));
        for file in sources(&own.join("src")) {
            let inside = file.strip_prefix(&own).unwrap_or(&file).display().to_string();
            let _ = writeln!(list, "({:?}, include_str!({:?})),", format!("{name}/{inside}"), file);
        }
    }
    list.push(']');
    let out = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    if let Err(e) = std::fs::write(out.join("sdk.rs"), list) {
        println!("cargo::error=the sdk's files cannot be listed: {e}");
    }
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> =
        entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "rs")).collect();
    files.sort();
    files
}

/// The manifest without this repository around it.
fn standalone(manifest: &str) -> String {
    let version = std::env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let text = manifest
        .replace("rust-version.workspace = true", "rust-version = \"1.95\"")
        .replace("version.workspace = true", &format!("version = \"{version}\""))
        .replace("edition.workspace = true", "edition = \"2024\"")
        .replace("license.workspace = true", "license = \"MIT OR Apache-2.0\"")
        .replace("publish.workspace = true\n", "")
        .replace("[lints]\nworkspace = true\n", "")
        .replace("marey-plugin-abi.workspace = true", "marey-plugin-abi = { path = \"../marey-plugin-abi\" }")
        .replace(
            "marey-plugin-abi = { workspace = true, optional = true }",
            "marey-plugin-abi = { path = \"../marey-plugin-abi\", optional = true }",
        )
        .replace("abi_stable.workspace = true", "abi_stable = { version = \"0.11.3\", default-features = false }");
    text.trim_end().to_owned() + "\n"
}
