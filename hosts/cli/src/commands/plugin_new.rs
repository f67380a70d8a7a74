//! `marey plugin new NAME`: a project that builds, passes its own tests and loads.
//!
//! The project brings the sdk along, in `vendor/`: it builds anywhere, whether or not the sdk is in a registry by then.
//! `--sdk PATH` names one instead that is kept elsewhere.

use std::path::{Path, PathBuf};

use crate::args::PluginNew;
use crate::failure::{BAD_INPUT, BAD_USE, FAILED, Failure};
use crate::say;

/// The files of the sdk that a project brings along, by their places in it.
const SDK: &[(&str, &str)] = &include!(concat!(env!("OUT_DIR"), "/sdk.rs"));

const CARGO: &str = include_str!("../../templates/Cargo.toml.txt");
const LIB: &str = include_str!("../../templates/lib.rs.txt");
const README: &str = include_str!("../../templates/README.md.txt");

/// A name that a crate, a file and an id can have.
fn check_name(name: &str) -> Result<(), Failure> {
    let starts = name.starts_with(|c: char| c.is_ascii_lowercase());
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if starts && name.len() <= 40 && name.chars().all(allowed) && !name.ends_with('-') {
        return Ok(());
    }
    let message = format!("`{name}` is no name for a plugin; use a-z, 0-9 and '-', such as my-tracker");
    Err(Failure::new(BAD_USE, message))
}

/// `my-tracker` as a type's name.
fn type_name(name: &str) -> String {
    let word = |word: &str| {
        let mut letters = word.chars();
        letters.next().map_or(String::new(), |first| first.to_ascii_uppercase().to_string() + letters.as_str())
    };
    name.split('-').map(word).collect()
}

pub(crate) fn new(args: &PluginNew) -> Result<(), Failure> {
    check_name(&args.name)?;
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(&args.name));
    if folder.exists() {
        return Err(Failure::new(BAD_INPUT, format!("{}: is there already; choose another name", folder.display())));
    }
    let sdk = match &args.sdk {
        Some(path) => {
            let full = path.canonicalize().ok().filter(|p| p.join("Cargo.toml").is_file());
            let none = || Failure::new(BAD_INPUT, format!("{}: is no folder of the sdk", path.display()));
            full.ok_or_else(none)?.display().to_string()
        }
        None => "vendor/marey-plugin".to_owned(),
    };
    let fill = |text: &str| {
        let text = text.replace("{{name}}", &args.name).replace("{{Name}}", &type_name(&args.name));
        text.replace("{{library}}", &args.name.replace('-', "_")).replace("{{sdk}}", &sdk)
    };
    let mut files = vec![
        ("Cargo.toml".to_owned(), fill(CARGO)),
        ("src/lib.rs".to_owned(), fill(LIB)),
        ("README.md".to_owned(), fill(README)),
        (".gitignore".to_owned(), "/target\n".to_owned()),
    ];
    if args.sdk.is_none() {
        files.extend(SDK.iter().map(|(path, text)| (format!("vendor/{path}"), (*text).to_owned())));
    }
    // Written aside and renamed: a failure leaves no half of a project.
    let aside = folder.with_file_name(format!(".{}.{}.tmp", args.name, std::process::id()));
    let written = write(&aside, &files).and_then(|()| std::fs::rename(&aside, &folder));
    if let Err(e) = written {
        let _ = std::fs::remove_dir_all(&aside);
        return Err(Failure::new(FAILED, format!("{}: cannot be written: {e}", folder.display())));
    }
    let (shown, library) = (folder.display(), args.name.replace('-', "_"));
    say::line(&format!(
        "{shown}: a tracker that you can change.\n  cd {shown}\n  cargo test\n  cargo build --release\n  \
         marey plugin check target/release/lib{library}.so\n  \
         marey track CLIP --strokes S.json --plugin target/release/lib{library}.so --tracker org.example.{} -o m.json",
        args.name
    ));
    Ok(())
}

fn write(folder: &Path, files: &[(String, String)]) -> std::io::Result<()> {
    for (path, text) in files {
        let path = folder.join(path);
        std::fs::create_dir_all(path.parent().unwrap_or(folder))?;
        std::fs::write(path, text)?;
    }
    Ok(())
}
