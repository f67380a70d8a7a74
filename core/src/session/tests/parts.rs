//! Parts: points, drawings and characters are held, undone and recovered as strokes are.

use super::*;
use crate::rig::{PointKey, PointMarks};

const SVG: &str = r#"<svg xmlns="http://www.w3.org/2000/svg" width="40" height="30">
<path d="M2 2 L30 20" stroke="black" fill="none"/></svg>"#;

fn marks(count: usize) -> Part {
    let mut marks = PointMarks { size: (100, 80), points: Vec::new() };
    for i in 0..count {
        marks.put(&(i + 1).to_string(), PointKey { frame: 0, at: vec2(3.0 * i as f32, 7.25) });
    }
    Part::new(PartKind::Points, marks.to_json().as_bytes()).expect("points")
}

fn picture() -> Part {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(3, 2, image::Rgba([200, 10, 0, 255]))
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("a PNG");
    Part::new(PartKind::Picture, bytes.get_ref()).expect("a picture")
}

#[test]
fn parts_are_saved_undone_and_recovered() {
    let (_keep, folder) = folder();
    let path = folder.join("lives.marey");
    let mut session = Session::create(&path).expect("created");
    let drawing = Part::new(PartKind::Drawing, SVG.as_bytes()).expect("a drawing");
    session.set_part(PartKind::Drawing, Some(drawing.clone())).expect("set");
    session.set_part(PartKind::Picture, Some(picture())).expect("set");
    let before = session.fingerprint();
    session.save().expect("saved");

    // A drag is one gesture, however often the points move in it.
    session.begin_gesture("drag").expect("begun");
    for count in 1..5 {
        session.set_part(PartKind::Points, Some(marks(count))).expect("set");
    }
    session.end_gesture().expect("ended");
    assert_ne!(session.fingerprint(), before);
    session.set_part(PartKind::Picture, None).expect("taken away");
    session.undo().expect("undone");
    let document = session.document().clone();
    drop(session);

    // The program ended without a save.
    let mut session = open(&path);
    assert_eq!((session.document(), session.replayed(), session.warnings()), (&document, 3, &[][..]));
    assert_eq!(session.document().parts[&PartKind::Drawing].bytes(), SVG.as_bytes());
    assert_eq!(session.document().parts[&PartKind::Points], marks(4));
    session.undo().expect("undone");
    assert!(!session.document().parts.contains_key(&PartKind::Points), "one step for the drag");
    assert_eq!(session.fingerprint(), before);
    session.save().expect("saved");
    drop(session);
    assert_eq!(open(&path).document().parts.len(), 2);
}

#[test]
fn what_is_not_the_file_it_should_be_is_refused_and_damage_costs_one_part() {
    for (kind, bytes) in [
        (PartKind::Points, &b"{}"[..]),
        (PartKind::Joints, b"[1]"),
        (PartKind::Drawing, b"<html/>"),
        (PartKind::Binding, b"{\"format\": \"marey-points\"}"),
        (PartKind::Picture, b"no picture"),
        (PartKind::Skeleton, b""),
        (PartKind::Motion, b"HIERARCHY"),
        (PartKind::Map, b"{}"),
        (PartKind::Notes, &[0xff, 0xfe]),
    ] {
        assert!(Part::new(kind, bytes).is_err(), "{}", kind.name());
    }
    assert!(Part::new(PartKind::Notes, &vec![b' '; LARGEST_PART + 1]).is_err(), "too large");
    let mut session = Session::new();
    assert!(session.set_part(PartKind::Drawing, Some(marks(1))).is_err(), "of another kind");
    assert_eq!(session.gestures(), 0);

    let (_keep, folder) = folder();
    let path = folder.join("lives.marey");
    let mut session = Session::create(&path).expect("created");
    session.set_part(PartKind::Points, Some(marks(2))).expect("set");
    session.set_part(PartKind::Notes, Some(Part::new(PartKind::Notes, b"door 3").expect("text"))).expect("set");
    session.save().expect("saved");
    drop(session);
    let text = std::fs::read_to_string(&path).expect("read").replacen("7.25", "7.75", 1);
    std::fs::write(&path, text).expect("written");
    let session = open(&path);
    assert!(session.warnings().iter().any(|w| w.contains("points")), "{:?}", session.warnings());
    assert_eq!(session.document().parts.keys().collect::<Vec<_>>(), [&PartKind::Notes]);
}

#[test]
fn a_journal_of_the_version_before_is_read() {
    let (_keep, folder) = folder();
    let path = folder.join("walk.marey");
    let mut session = Session::create(&path).expect("created");
    session.add_limb("body", None).expect("a limb");
    drop(session);
    let journal = path_of(&path);
    let text = std::fs::read_to_string(&journal).expect("read");
    let (head, rest) = text.split_once('\n').expect("a header");
    let mut header: serde_json::Value =
        serde_json::from_str(head.splitn(3, ' ').nth(2).expect("three fields")).expect("JSON");
    assert_eq!(header["version"], 2);
    header["version"] = 1.into();
    std::fs::write(&journal, record::encode(&header).expect("text") + rest).expect("written");
    assert_eq!(open(&path).document().inputs.rig.limbs.len(), 1);
}
