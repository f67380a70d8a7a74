//! What the program brings along to try it with.

use std::path::{Path, PathBuf};

use marey_binding::Part;

const CLIP: &[u8] = include_bytes!("../../../data/fox/clip.mp4");
const STROKES: &str = include_str!("../../../data/fox/strokes-k3.json");
const CHILD: &[u8] = include_bytes!("../../../data/characters/child/drawing.png");
const CHILD_RIG: &str = include_str!("../../../data/characters/child/rig.json");
const WALK: &str = include_str!("../../../data/characters/child/walk.motion.json");
const GALLOP: &[u8] = include_bytes!("../../../data/animals/horse-gallop.webp");
const GALLOP_MOTION: &str = include_str!("../../../data/animals/horse-gallop.motion.json");
const HORSE: &str = include_str!("../../../data/drawings/horse.svg");
const HORSE_POINTS: &str = include_str!("../../../data/drawings/horse.points.json");
const HORSE_MOTION: &str = include_str!("../../../data/drawings/horse.motion.json");
const HORSE_BINDING: &str = include_str!("../../../data/drawings/horse.bind.json");

/// Drawings that can be brought to life.
pub(crate) const DRAWINGS: [(&str, &str); 6] = [
    ("Horse", HORSE),
    ("Gazelle", include_str!("../../../data/drawings/gazelle.svg")),
    ("Cat", include_str!("../../../data/drawings/cat.svg")),
    ("Kangaroo", include_str!("../../../data/drawings/kangaroo.svg")),
    ("Squirrel", include_str!("../../../data/drawings/squirrel.svg")),
    ("Hummingbird", include_str!("../../../data/drawings/hummingbird.svg")),
];

/// Motions that a character can take.
pub(crate) const MOTIONS: [(&str, &str); 2] = [("Walks and waves", WALK), ("Gallops, as a horse", GALLOP_MOTION)];

/// The clip of the fox, put where it can be opened; a copy that is there already is taken.
pub(crate) fn clip(folder: &Path) -> std::io::Result<PathBuf> {
    put(folder, "fox.mp4", CLIP)
}

/// The clip of the horse, in the same way.
pub(crate) fn gallop(folder: &Path) -> std::io::Result<PathBuf> {
    put(folder, "horse-gallop.webp", GALLOP)
}

/// The child's drawing, in the same way.
pub(crate) fn child_picture(folder: &Path) -> std::io::Result<PathBuf> {
    put(folder, "child.png", CHILD)
}

fn put(folder: &Path, name: &str, bytes: &[u8]) -> std::io::Result<PathBuf> {
    let path = folder.join(name);
    if std::fs::metadata(&path).is_ok_and(|m| m.len() == bytes.len() as u64) {
        return Ok(path);
    }
    let mut aside = tempfile::NamedTempFile::new_in(folder)?;
    std::io::Write::write_all(&mut aside, bytes)?;
    aside.persist(&path).map_err(|e| e.error)?;
    Ok(path)
}

/// The fox as it was drawn on three frames, the text of a strokes.json.
pub(crate) fn strokes() -> &'static str {
    STROKES
}

/// A child's drawing with its joints, and a walk that waves.
pub(crate) fn child() -> [(Part, Option<&'static [u8]>); 4] {
    // The motion's joints are its own, so that they can point where the motion's do.
    const NOTES: &[u8] = br#"{"door": "character", "character": {"absolute": true}}"#;
    [
        (Part::Notes, Some(NOTES)),
        (Part::Picture, Some(CHILD)),
        (Part::Skeleton, Some(CHILD_RIG.as_bytes())),
        (Part::Motion, Some(WALK.as_bytes())),
    ]
}

/// A drawing of a horse, the points of one that gallops, where they go, and how they hold the drawing.
pub(crate) fn horse() -> [(Part, Option<&'static [u8]>); 4] {
    [
        (Part::Points, Some(HORSE_POINTS.as_bytes())),
        (Part::Motion, Some(HORSE_MOTION.as_bytes())),
        (Part::Drawing, Some(HORSE.as_bytes())),
        (Part::Binding, Some(HORSE_BINDING.as_bytes())),
    ]
}
