//! Embedded media: the clip and the painted masks inside the session file, so that the one file is all there is to
//! carry about.
//!
//! In the file they are pieces of [`PIECE`] bytes, each a section that proves itself whole; a damaged piece costs the
//! file it is of. While the session is open they lie unpacked in a folder beside it, which goes with the last who uses
//! it; what a crash leaves of such folders is removed when the session is opened again.
//!
//! Known limit: every save writes all of them anew.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use serde::{Deserialize, Serialize};

use super::document::Inputs;
use super::durable::folder_of;
use crate::error::{Error, Result};

/// Bytes of a piece.
const PIECE: usize = 1 << 20;
/// Bytes of all media of a session; larger clips are better referred to.
const MOST: u64 = 1 << 30;
/// The file in the folder of unpacked media that is locked while they are in use.
const IN_USE: &str = "in-use";

/// A part of a file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Piece {
    /// Its name: `clip/NAME`, `clip/NAME/IMAGE` or `masks/FRAME/NAME`.
    file: String,
    /// Bytes of the file.
    of: u64,
    /// Where in the file the piece begins.
    at: u64,
    base64: String,
}

/// Media unpacked into a folder that is removed with this.
#[derive(Debug)]
pub struct UnpackedMedia {
    folder: tempfile::TempDir,
    _in_use: File,
}

impl UnpackedMedia {
    /// Whether `path` is one of these.
    pub(super) fn has(&self, path: &Path) -> bool {
        path.starts_with(self.folder.path())
    }
}

/// The media that `inputs` refer to, by the names they are to have.
fn files(inputs: &Inputs) -> Result<Vec<(String, PathBuf)>> {
    let name = |path: &Path| -> Result<String> {
        let name = path.file_name().and_then(|n| n.to_str());
        name.map(str::to_owned).ok_or_else(|| Error::file(path, "has a name that is not UTF-8", "rename it"))
    };
    let mut files = Vec::new();
    if let Some(clip) = &inputs.clip {
        let clip_name = name(&clip.path)?;
        if clip.path.is_dir() {
            let entries = std::fs::read_dir(&clip.path).and_then(Iterator::collect::<std::io::Result<Vec<_>>>);
            let entries = entries.map_err(|e| Error::io(&clip.path, "read", e))?;
            for path in entries.iter().map(std::fs::DirEntry::path).filter(|p| p.is_file()) {
                files.push((format!("clip/{clip_name}/{}", name(&path)?), path));
            }
        } else {
            files.push((format!("clip/{clip_name}"), clip.path.clone()));
        }
    }
    for key in &inputs.rig.keyframes {
        if let Some(mask) = &key.mask {
            files.push((format!("masks/{}/{}", key.frame, name(mask)?), mask.clone()));
        }
    }
    files.sort();
    Ok(files)
}

/// Calls `each` with every piece of the media of `inputs`.
///
/// # Errors
/// One of them cannot be read, or they are too large.
pub(super) fn pieces(inputs: &Inputs, mut each: impl FnMut(Piece) -> Result<()>) -> Result<()> {
    let files = files(inputs)?;
    let sizes = files.iter().map(|(_, path)| std::fs::metadata(path).map_err(|e| Error::io(path, "read", e)));
    let value = sizes.map(|meta| meta.map(|m| m.len())).sum::<Result<u64>>()?;
    if value > MOST {
        let what = "the size of the clip and the masks to embed, in bytes".to_owned();
        return Err(Error::Limit { what, value, max: MOST, remedy: "let the session refer to the clip".to_owned() });
    }
    let mut buffer = Vec::with_capacity(PIECE);
    for (name, path) in files {
        let mut open = File::open(&path).map_err(|e| Error::io(&path, "open", e))?;
        let of = open.metadata().map_err(|e| Error::io(&path, "read", e))?.len();
        let mut at = 0;
        loop {
            buffer.clear();
            let read = (&mut open).take(PIECE as u64).read_to_end(&mut buffer);
            let read = read.map_err(|e| Error::io(&path, "read", e))? as u64;
            if read == 0 && at > 0 {
                break;
            }
            each(Piece { file: name.clone(), of, at, base64: BASE64.encode(&buffer) })?;
            at += read;
            if read == 0 {
                break;
            }
        }
        if at != of {
            return Err(Error::file(path, "changed while it was read", "try again"));
        }
    }
    Ok(())
}

/// Unpacks the media of the session at `path` and lets `inputs` refer to them; also says what is damaged.
///
/// # Errors
/// They cannot be written beside the session.
pub(super) fn unpack(pieces: &[Piece], path: &Path, inputs: &mut Inputs) -> Result<(Arc<UnpackedMedia>, Vec<String>)> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let (parent, prefix) = (folder_of(path), format!(".{name}-media-"));
    remove_left(parent, &prefix);
    let folder = tempfile::Builder::new().prefix(&prefix).tempdir_in(parent);
    let folder = folder.map_err(|e| Error::io(parent, "unpack the clip in", e))?;
    let in_use = File::create(folder.path().join(IN_USE)).and_then(|f| f.lock_shared().map(|()| f));
    let in_use = in_use.map_err(|e| Error::io(folder.path(), "unpack the clip in", e))?;

    let mut whole: BTreeMap<&str, (u64, u64)> = BTreeMap::new();
    let mut lost = Vec::new();
    for piece in pieces {
        let Some(place) = place_in(folder.path(), &piece.file) else {
            lost.push(format!("the embedded file `{}` has a name that leads elsewhere; it is left out", piece.file));
            continue;
        };
        if let Ok(bytes) = BASE64.decode(&piece.base64)
            && piece.at.checked_add(bytes.len() as u64).is_some_and(|end| end <= piece.of && piece.of <= MOST)
        {
            write_at(&place, piece.at, &bytes)?;
            whole.entry(&piece.file).or_insert((0, piece.of)).0 += bytes.len() as u64;
        }
    }
    let damaged = |name: &str| pieces.iter().any(|p| p.file.starts_with(name)) && !is_whole(&whole, pieces, name);
    if damaged("clip/") {
        lost.push("the embedded clip is damaged; choose the clip again".into());
    } else if let Some(clip) = &mut inputs.clip
        && let Some(name) = clip.path.file_name().map(|n| folder.path().join("clip").join(n))
        && name.exists()
    {
        Arc::make_mut(clip).path = name;
    }
    if inputs.rig.keyframes.iter().any(|k| k.mask.is_some()) {
        for key in &mut Arc::make_mut(&mut inputs.rig).keyframes {
            let Some(mask) = &mut key.mask else { continue };
            let name = format!("masks/{}/", key.frame);
            if damaged(&name) {
                lost.push(format!("the embedded mask of frame {} is damaged; choose it again", key.frame));
            } else if let Some(place) = mask.file_name().map(|n| folder.path().join(&name).join(n))
                && place.exists()
            {
                *mask = place;
            }
        }
    }
    Ok((Arc::new(UnpackedMedia { folder, _in_use: in_use }), lost))
}

/// Whether every file whose name begins so has all its bytes.
fn is_whole(found: &BTreeMap<&str, (u64, u64)>, pieces: &[Piece], name: &str) -> bool {
    let mut named = pieces.iter().map(|p| p.file.as_str()).filter(|file| file.starts_with(name));
    named.all(|file| found.get(file).is_some_and(|(have, of)| have == of))
}

/// Where a file of that name goes; nowhere when the name leads out of the folder.
fn place_in(folder: &Path, name: &str) -> Option<PathBuf> {
    let parts: Vec<&str> = name.split('/').collect();
    let known = matches!(parts[..], ["clip", _] | ["clip", _, _] | ["masks", _, _]);
    // What one system takes for a name may be a way up, or another disk, on the next.
    let plain = |part: &&str| {
        let mut components = Path::new(part).components();
        matches!((components.next(), components.next()), (Some(Component::Normal(name)), None) if name == *part)
    };
    (known && parts.iter().all(plain)).then(|| folder.join(name))
}

fn write_at(place: &Path, at: u64, bytes: &[u8]) -> Result<()> {
    let parent = folder_of(place);
    std::fs::create_dir_all(parent).map_err(|e| Error::io(parent, "create", e))?;
    let open = File::options().create(true).write(true).truncate(false).open(place);
    let written = open.and_then(|mut file| file.seek(SeekFrom::Start(at)).and_then(|_| file.write_all(bytes)));
    written.map_err(|e| Error::io(place, "write", e))
}

/// Removes what crashes left of unpacked media. What cannot be removed does no harm.
fn remove_left(parent: &Path, prefix: &str) {
    let Ok(entries) = std::fs::read_dir(parent) else { return };
    for entry in entries.flatten().filter(|e| e.file_name().to_string_lossy().starts_with(prefix)) {
        let in_use = File::open(entry.path().join(IN_USE));
        if in_use.is_ok_and(|file| file.try_lock().is_ok()) {
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
}
