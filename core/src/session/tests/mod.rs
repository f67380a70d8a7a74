//! The session as its user knows it: nothing that was done is lost, and what is damaged says so.

mod editing;
mod embedded;
mod files;
mod parts;
mod recording;
mod recovery;
mod retracking;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{Vec2, vec2};

use super::journal::path_of;
use super::*;
use crate::clip::ClipInfo;
use crate::job::Progress;
use crate::motion::{Motion, Track, TrackFrame, TrackKind};
use crate::rig::{Facing, Paint, Rig, Side};

fn bar(y: f32) -> Vec<Vec2> {
    vec![vec2(10.0, y), vec2(40.5, y + 0.25), vec2(80.0, y)]
}

fn clip(path: &Path) -> ClipReference {
    std::fs::write(path, b"frames").expect("written");
    let info =
        ClipInfo { width: 100, height: 80, frames: 40, fps: 24000.0 / 1001.0, source: "memory", warnings: vec![] };
    ClipReference::new(path, &info, Progress::new().whole()).expect("read")
}

fn motion(rig: &Rig) -> Arc<Motion> {
    let track = |limb: &crate::rig::Limb| Track {
        name: limb.label.clone(),
        kind: TrackKind::Stroke,
        frames: (0..3).map(|f| TrackFrame::certain(vec![vec2(0.1 * f as f32, 1.0), vec2(9.0, 2.0)])).collect(),
    };
    let tracks = rig.limbs.iter().map(track).collect();
    Arc::new(Motion { size: rig.size, fps: 24.0, frames: 3, tracks, bones: vec![("body".into(), "tail".into())] })
}

/// Does something of every kind, a gesture each.
fn draw(session: &mut Session, folder: &Path) {
    session.set_clip(Some(clip(&folder.join("clip.mp4")))).expect("a clip");
    session.add_limb("body", None).expect("a limb");
    session.add_limb("leg", Some(Side::Near)).expect("a limb");
    session.set_stroke(0, 3, bar(20.0), None).expect("a stroke");
    session.set_stroke(1, 3, bar(40.0), Some(Facing::Toward)).expect("a stroke");
    session.set_stroke(0, 20, bar(30.0), None).expect("a stroke");
    let paint = |radius| Paint { foreground: radius > 2.0, radius, points: bar(50.0) };
    session.add_paint(3, paint(2.0)).expect("paint");
    session.add_paint(3, paint(4.5)).expect("paint");
    session.remove_paint(3, 0).expect("less paint");
    session.set_mask(7, Some(&folder.join("mask.png"))).expect("a mask");
    session.add_limb("tail", None).expect("a limb");
    session.set_stroke(2, 5, bar(60.0), None).expect("a stroke");
    session.set_parameter("creature.smoothing", Some(Value::Number(0.1))).expect("a value");
    let inputs = session.document().inputs.clone();
    session.set_motion(Some(Tracked { motion: motion(&inputs.rig), inputs })).expect("a motion");
    session.remove_limb(1).expect("no leg");
    session.set_limb(1, "long tail", Some(Side::Mid)).expect("a label");
    session.remove_stroke(0, 20).expect("no stroke");
}
const DRAWN: u64 = 17;

fn open(path: &Path) -> Session {
    Session::open(path, Access::Edit, Progress::new().whole()).expect("opened")
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = std::fs::canonicalize(folder.path()).expect("a path");
    std::fs::write(path.join("mask.png"), b"a picture").expect("written");
    (folder, path)
}

/// The document after each gesture of [`draw`], the empty one first.
fn states(folder: &Path) -> Vec<Document> {
    let mut session = Session::new();
    draw(&mut session, folder);
    let mut states = vec![session.document().clone()];
    while session.undo().expect("undone").is_some() {
        states.push(session.document().clone());
    }
    states.reverse();
    states
}
