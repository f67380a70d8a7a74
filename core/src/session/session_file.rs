//! The session file: records (see [`super::record`]), first a header and then one section each for the clip, the rig,
//! the settings, what was tracked, and every part.
//!
//! A damaged section costs itself and no other. Sections of names that are not known are kept as they are; a newer
//! version, or something unknown inside a known section, is refused: reading on would lose it at the next save.
//! The clip and painted masks are referred to, by paths relative to the session file; absolute ones are tried second.

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::clip_reference::{ClipReference, ClipState};
use super::document::{Document, Inputs, Tracked};
use super::durable::folder_of;
use super::embedded::{self, Piece};
use super::part::{Part, PartKind};
use super::record;
use crate::error::{Error, Result};
use crate::job::Stage;
use crate::rig::Rig;

const FORMAT: &str = "marey-session";
const VERSION: u32 = 1;
/// The name of the sections that hold pieces of embedded media.
const MEDIA: &str = "media";
/// A session of more bytes was not made by this program.
const MAX_BYTES: u64 = 4 << 30;

#[derive(Serialize, Deserialize)]
struct Header {
    format: String,
    version: u32,
    generator: String,
    /// Tells this session's journal from others.
    session: String,
    /// The number of the last gesture that the file has.
    saved: u64,
    /// Whether the user never named it.
    scratch: bool,
    /// The sections that follow.
    sections: Vec<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Section<T> {
    section: String,
    data: T,
}

/// Of a record only whether it is a section.
#[derive(Deserialize)]
struct Named {
    section: Option<String>,
}

/// The clip's reference has the relative path.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ClipSection {
    reference: ClipReference,
    absolute: PathBuf,
}

/// What a session file holds.
#[derive(Debug, Default)]
pub(super) struct Contents {
    pub(super) document: Document,
    /// [`None`] where the header is lost.
    pub(super) id: Option<String>,
    pub(super) saved: u64,
    pub(super) scratch: bool,
    /// Whether the clip and the masks are to be put into the file.
    pub(super) embeds: bool,
    /// The pieces of them that were found in it.
    pub(super) media: Vec<Piece>,
    /// Sections that are not known, as they were.
    pub(super) unknown: Vec<serde_json::Value>,
    /// What could not be read, a sentence each.
    pub(super) lost: Vec<String>,
}

/// The bytes of a session file that is to lie at `path`.
pub(super) fn encode(contents: &Contents, path: &Path) -> Result<Vec<u8>> {
    let folder = folder_of(path);
    let Document { inputs, tracked, parts } = &contents.document;
    let clip = inputs.clip.as_ref().map(|clip| ClipSection {
        reference: ClipReference { path: relative(folder, &clip.path), ..(**clip).clone() },
        absolute: clip.path.clone(),
    });
    let mut sections = Vec::new();
    let mut add = |name: &str, record: Result<String>| record.map(|record| sections.push((name.to_owned(), record)));
    if let Some(clip) = clip {
        add("clip", section("clip", clip))?;
    }
    add("rig", section("rig", with_masks(&inputs.rig, |mask| relative(folder, mask))))?;
    add("settings", section("settings", &inputs.settings))?;
    if let Some(tracked) = tracked {
        add("tracked", section("tracked", tracked))?;
    }
    for (kind, part) in parts {
        add(kind.name(), section(kind.name(), part))?;
    }
    if contents.embeds {
        let mut pieces = String::new();
        embedded::pieces(inputs, |piece| {
            pieces += &section(MEDIA, piece)?;
            Ok(())
        })?;
        add(MEDIA, Ok(pieces))?;
    }
    for unknown in &contents.unknown {
        add(unknown["section"].as_str().unwrap_or_default(), record::encode(unknown))?;
    }
    let header = Header {
        format: FORMAT.into(),
        version: VERSION,
        generator: concat!("marey ", env!("CARGO_PKG_VERSION")).into(),
        session: contents.id.clone().unwrap_or_default(),
        saved: contents.saved,
        scratch: contents.scratch,
        sections: sections.iter().map(|(name, _)| name.clone()).collect(),
    };
    let mut text = record::encode(&header)?;
    sections.iter().for_each(|(_, record)| text += record);
    Ok(text.into_bytes())
}

fn section<T: Serialize>(name: &str, data: T) -> Result<String> {
    record::encode(&Section { section: name.into(), data })
}

/// Reads the session file at `path`.
///
/// # Errors
/// It cannot be read, nothing in it is a session's, or it is of a newer version.
pub(super) fn read(path: &Path) -> Result<Contents> {
    decode(&bytes(path)?, path)
}

/// The bytes of a file of records.
///
/// # Errors
/// It cannot be read, or is absurdly large.
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>> {
    let bytes = std::fs::metadata(path).map_err(|e| Error::io(path, "open", e))?.len();
    if bytes > MAX_BYTES {
        let (what, remedy) = ("the size of the session in bytes".to_owned(), "expected a session file".to_owned());
        return Err(Error::Limit { what, value: bytes, max: MAX_BYTES, remedy });
    }
    std::fs::read(path).map_err(|e| Error::io(path, "read", e))
}

/// Where in `bytes` the sections that the header promises end; [`None`] where the header is damaged.
pub(super) fn end_of_sections(bytes: &[u8]) -> Option<usize> {
    let mut lines = record::lines(bytes);
    let header: Header = serde_json::from_str(lines.next()?.text?).ok()?;
    let last = header.sections.len().checked_sub(1)?;
    lines.nth(last).map(|line| line.end)
}

pub(super) fn decode(bytes: &[u8], path: &Path) -> Result<Contents> {
    let mut contents = Contents::default();
    let mut expected: Option<Vec<String>> = None;
    let (mut found, mut damaged) = (Vec::new(), false);
    for line in record::lines(bytes) {
        let Some(text) = line.text else {
            damaged = true;
            continue;
        };
        let Named { section } = parse(text, path, "header")?;
        if let Some(name) = section {
            contents.take(&name, text, path)?;
            found.push(name);
            continue;
        }
        let header: Header = parse(text, path, "header")?;
        if header.format != FORMAT || header.version > VERSION {
            let problem = format!("is {} version {}, written by {}", header.format, header.version, header.generator);
            let remedy = format!("this program reads {FORMAT} version {VERSION}; use a newer one");
            return Err(Error::file(path, problem, remedy));
        }
        (contents.id, contents.saved, contents.scratch) = (Some(header.session), header.saved, header.scratch);
        expected = Some(header.sections);
    }
    if expected.is_none() && found.is_empty() {
        return Err(Error::file(path, "is no session, or nothing of it can be read", "expected a marey-session file"));
    }
    if expected.is_none() {
        contents.lost.push("the header is damaged; gestures since the last save, if there were any, are lost".into());
    }
    for name in expected.iter().flatten().filter(|name| !found.contains(name)) {
        contents.lost.push(match name.as_str() {
            "tracked" => "the tracked motion is damaged and lost; track again".into(),
            MEDIA => "the embedded clip is damaged and lost; choose the clip again".into(),
            "clip" => "the reference to the clip is damaged and lost; choose the clip again".into(),
            "rig" => "the strokes are damaged and lost".into(),
            name => format!("the section `{name}` is damaged and lost"),
        });
    }
    if damaged && expected.is_none() {
        contents.lost.push(format!("of its sections only {} could be read", found.join(", ")));
    }
    Ok(contents)
}

impl Contents {
    /// Takes over a section, whose `text` is whole.
    fn take(&mut self, name: &str, text: &str, path: &Path) -> Result<()> {
        let Document { inputs, tracked, parts } = &mut self.document;
        let checked = match name {
            "clip" => {
                let ClipSection { mut reference, absolute } = data(text, path, "clip")?;
                // A path that is relative to the session file travels with it.
                let beside = folder_of(path).join(&reference.path);
                reference.path = if beside.exists() || !absolute.exists() { beside } else { absolute };
                inputs.clip = Some(Arc::new(reference));
                Ok(())
            }
            "rig" => {
                let rig: Rig = data(text, path, "rig")?;
                inputs.rig = Arc::new(with_masks(&rig, |mask| folder_of(path).join(mask)));
                inputs.rig.validate_draft()
            }
            "settings" => {
                inputs.settings = data(text, path, "settings")?;
                inputs.settings.check()
            }
            MEDIA => {
                self.media.push(data(text, path, MEDIA)?);
                Ok(())
            }
            "tracked" => {
                let read: Tracked = data(text, path, "tracked")?;
                let checked = read.check().and_then(|()| read.inputs.rig.validate_draft());
                *tracked = Some(read);
                checked
            }
            _ if PartKind::ALL.iter().any(|kind| kind.name() == name) => {
                let part: Part = data(text, path, name)?;
                parts.insert(part.kind(), part);
                Ok(())
            }
            _ => {
                self.unknown.push(parse(text, path, name)?);
                Ok(())
            }
        };
        checked.map_err(|e| {
            Error::file(path, e.to_string(), "the file was not written by this program; mend or remove it")
        })
    }
}

fn data<T: DeserializeOwned>(text: &str, path: &Path, name: &str) -> Result<T> {
    parse::<Section<T>>(text, path, name).map(|section| section.data)
}

fn parse<T: DeserializeOwned>(text: &str, path: &Path, name: &str) -> Result<T> {
    serde_json::from_str(text).map_err(|e| {
        let remedy = "it was written by a newer program; use that one";
        Error::file(path, format!("the section `{name}` has something this program does not know: {e}"), remedy)
    })
}

/// The rig with its masks' paths replaced.
fn with_masks(rig: &Rig, replace: impl Fn(&Path) -> PathBuf) -> Rig {
    let mut rig = rig.clone();
    for mask in rig.keyframes.iter_mut().filter_map(|k| k.mask.as_mut()) {
        *mask = replace(mask);
    }
    rig
}

/// The way from `folder` to `path`, where both are absolute and have a common root.
fn relative(folder: &Path, path: &Path) -> PathBuf {
    let (Ok(folder), true) = (std::path::absolute(folder), path.is_absolute()) else { return path.to_owned() };
    let parts = |p: &Path| -> Vec<PathBuf> { p.components().map(|c| PathBuf::from(c.as_os_str())).collect() };
    let (from, to) = (parts(&folder), parts(path));
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return path.to_owned();
    }
    let up = from[common..].iter().map(|_| PathBuf::from(Component::ParentDir.as_os_str()));
    up.chain(to[common..].iter().cloned()).collect()
}

/// What a person should know about the clip and the masks of `inputs`.
///
/// # Errors
/// A cancel.
pub(super) fn check_media(inputs: &Inputs, stage: Stage<'_>) -> Result<Vec<String>> {
    let mut warnings = Vec::new();
    if let Some(clip) = &inputs.clip {
        match clip.state(stage)? {
            ClipState::Unchanged => {}
            ClipState::Changed => {
                warnings.push(format!(
                    "{}: the clip is not the one that was drawn on; choose the right one",
                    clip.path.display()
                ));
            }
            ClipState::Missing => {
                warnings.push(format!("{}: the clip is not there; choose it where it is now", clip.path.display()));
            }
        }
    }
    for (frame, mask) in inputs.rig.keyframes.iter().filter_map(|k| Some((k.frame, k.mask.as_ref()?))) {
        if !mask.is_file() {
            warnings
                .push(format!("{}: the painted mask of frame {frame} is not there; choose it again", mask.display()));
        }
    }
    Ok(warnings)
}
