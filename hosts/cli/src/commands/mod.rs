//! The commands, each in its file, and what they share.

mod character;
mod creature;
mod crowd;
mod deform;
mod demo;
mod edit;
mod info;
mod motion;
mod path;
mod plugin;
mod plugin_new;
mod points;
mod pose;
mod print;
mod render;
mod segment;
mod session_files;
mod session_info;
mod sketch;
mod texture;
mod track;

pub(crate) use character::{character, retarget, rig};
pub(crate) use creature::creature;
pub(crate) use crowd::crowd;
pub(crate) use deform::deform;
pub(crate) use demo::demo;
pub(crate) use edit::edit;
pub(crate) use info::info;
pub(crate) use motion::motion;
pub(crate) use path::path;
pub(crate) use plugin::{check as plugin_check, list as plugin_list, probe as plugin_probe};
pub(crate) use plugin_new::new as plugin_new;
pub(crate) use points::points;
pub(crate) use pose::pose;
pub(crate) use print::print;
pub(crate) use render::render;
pub(crate) use segment::segment;
pub(crate) use session_files::{session_embed, session_replay};
pub(crate) use session_info::session_info;
pub(crate) use sketch::{bind, sketch};
pub(crate) use texture::texture;
pub(crate) use track::track;

use std::path::Path;
use std::time::Instant;

use marey_binding::{Clip, Context, Rig};
use serde_json::{Map, Value, json};

use crate::failure::{BAD_INPUT, BAD_USE, FAILED, Failure};
use crate::say;
use crate::watch::Interrupt;

/// One run of the program.
pub(crate) struct Session {
    context: Context,
    json: bool,
    interrupt: Interrupt,
    began: Instant,
}

impl Session {
    pub(crate) fn new(threads: u32, json: bool) -> Result<Self, Failure> {
        let began = Instant::now();
        Ok(Self { interrupt: Interrupt::listen()?, context: Context::new(threads)?, json, began })
    }

    /// Opens the clip, and says what a person should know of it.
    fn open_clip(&self, path: &Path) -> Result<Clip, Failure> {
        let clip = self.context.open_clip(utf8(path)?)?;
        for warning in clip.info()?.warnings {
            say::warning(&format!("{}: {warning}", path.display()));
        }
        Ok(clip)
    }

    /// Opens the clip and the strokes, which fit it.
    fn open(&self, clip: &Path, strokes: &Path) -> Result<(Clip, Rig), Failure> {
        let rig = self.context.read_rig(utf8(strokes)?)?;
        let clip = self.open_clip(clip)?;
        rig.validate(Some(&clip)).map_err(|e| Failure::from(e).about(strokes))?;
        Ok((clip, rig))
    }

    /// The engine's report with what the command line adds, for `--json`.
    fn report(&self, command: &str, engine: &str, output: &Path) -> Result<Value, Failure> {
        let report: Value = serde_json::from_str(engine).map_err(|e| Failure::new(FAILED, format!("report: {e}")))?;
        let mut report = match report {
            Value::Object(map) => map,
            other => Map::from_iter([("report".to_owned(), other)]),
        };
        report.insert("command".into(), json!(command));
        report.insert("output".into(), json!(output));
        report.insert("threads".into(), json!(self.context.threads()?));
        report.insert("seconds".into(), json!(self.seconds()));
        Ok(Value::Object(report))
    }

    fn seconds(&self) -> f64 {
        (self.began.elapsed().as_secs_f64() * 1e3).round() / 1e3
    }
}

/// A path for the library, whose paths are UTF-8.
fn utf8(path: &Path) -> Result<&str, Failure> {
    path.to_str().ok_or_else(|| Failure::new(BAD_USE, format!("{}: the path is not UTF-8; rename it", path.display())))
}

/// Refuses, before long work, a file that could not be written after it, or that is one of those that are read.
fn check_file(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Err(Failure::new(BAD_INPUT, format!("{}: is a folder; give the name of a file", path.display())));
    }
    if is_read(path) {
        let problem = format!("{}: is read, and would be lost; give the output another name", path.display());
        return Err(Failure::new(BAD_USE, problem));
    }
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(Failure::new(BAD_INPUT, format!("{}: is no folder to write into; create it first", folder.display())))
        }
        _ => Ok(()),
    }
}

/// Whether what was typed names this file twice: once to be written, and once to be read.
fn is_read(output: &Path) -> bool {
    let Ok(output) = output.canonicalize() else { return false };
    let is_output = |file: &str| Path::new(file).canonicalize().is_ok_and(|file| file == output);
    let words = std::env::args_os().skip(2).map(|word| word.to_string_lossy().into_owned());
    // `FILE`, `--option=FILE`, `-oFILE`
    let names = |word: &String| {
        let parts = [Some(&**word), word.split_once('=').map(|parts| parts.1), word.strip_prefix("-o")];
        parts.into_iter().flatten().any(is_output)
    };
    words.filter(names).count() > 1
}

/// The text of a `kind` file, for a map or poses that the library reads as text; none where no file was given.
fn text_of(path: Option<&Path>, kind: &str) -> Result<String, Failure> {
    let Some(path) = path else { return Ok(String::new()) };
    let bad = |problem: String| Failure::new(BAD_INPUT, format!("{}: {problem}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| bad(format!("cannot be read: {e}")))?;
    if text.is_empty() { Err(bad(format!("is empty; expected a {kind} file"))) } else { Ok(text) }
}

/// Masks as asked for, else those in the creature's folder.
fn masks_of(session: &Session, masks: Option<&Path>, creature: &Path) -> Result<Option<Clip>, Failure> {
    let beside = creature.join("masks");
    match masks {
        Some(masks) => session.open_clip(masks).map(Some),
        None if beside.is_dir() => session.open_clip(&beside).map(Some),
        None => Ok(None),
    }
}

/// The stroke that would help most, for a person.
fn next_stroke(report: &Value) -> Option<String> {
    let best = report.get("correct_next")?.get(0)?;
    let (limb, frame) = (best.get("limb")?.as_str()?, best.get("frame")?.as_u64()?);
    Some(format!("least certain: `{limb}` on frame {frame}; a stroke there helps most"))
}
