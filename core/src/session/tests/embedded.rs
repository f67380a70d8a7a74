//! A session that carries its clip: there wherever the file goes, gone with nobody, and honest about damage.

use super::*;

/// Larger than a piece, and not a whole number of them.
fn big(seed: u8) -> Vec<u8> {
    (0..2_500_001usize).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8 ^ seed).collect()
}

fn reference(path: &Path) -> ClipReference {
    let info = ClipInfo { width: 100, height: 80, frames: 40, fps: 24.0, source: "memory", warnings: vec![] };
    ClipReference::new(path, &info, Progress::new().whole()).expect("read")
}

/// A session in `folder` with a clip and a mask, embedded and saved.
fn embedded(folder: &Path, clip: &Path) -> PathBuf {
    let path = folder.join("walk.marey");
    let mut session = Session::create(&path).expect("created");
    session.set_clip(Some(reference(clip))).expect("a clip");
    session.set_mask(7, Some(&folder.join("mask.png"))).expect("a mask");
    session.set_embedded(true).expect("embedded");
    assert!(session.is_modified());
    session.save().expect("saved");
    path
}

/// What lies in a folder, hidden things too.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").file_name());
    let mut names: Vec<String> = entries.map(|n| n.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn the_file_is_all_there_is_to_carry_about() {
    let ((_keep, folder), (_too, elsewhere)) = (folder(), folder());
    let clip = folder.join("walk.mp4");
    std::fs::write(&clip, big(1)).expect("written");
    let path = embedded(&folder, &clip);
    let moved = elsewhere.join("moved.marey");
    std::fs::rename(&path, &moved).expect("moved");
    std::fs::remove_file(&clip).expect("gone");
    std::fs::remove_file(folder.join("mask.png")).expect("gone");

    let mut session = open(&moved);
    assert!(session.warnings().is_empty() && session.is_embedded(), "{:?}", session.warnings());
    let inputs = session.document().inputs.clone();
    let unpacked = &inputs.clip.as_ref().expect("a clip").path;
    assert_eq!(std::fs::read(unpacked).expect("unpacked"), big(1));
    let mask = inputs.rig.keyframes[0].mask.clone().expect("a mask");
    assert_eq!(std::fs::read(mask).expect("unpacked"), b"a picture");

    // It is all that has them.
    assert!(session.set_embedded(false).is_err());
    session.set_parameter("creature.smoothing", Some(Value::Number(0.2))).expect("a value");
    session.save().expect("saved again from what was unpacked");
    drop(session);
    assert_eq!(names(&elsewhere), ["mask.png", "moved.marey"]);

    let mut session = open(&moved);
    assert!(session.warnings().is_empty());
    let own = elsewhere.join("own.mp4");
    std::fs::write(&own, big(2)).expect("written");
    session.set_clip(Some(reference(&own))).expect("another clip");
    session.set_mask(7, None).expect("no mask");
    session.set_embedded(false).expect("by reference again");
    session.save().expect("saved");
    drop(session);
    assert!(std::fs::metadata(&moved).expect("there").len() < 100_000);
    assert_eq!(open(&moved).document().inputs.clip.as_ref().expect("a clip").path, own);
}

#[test]
fn folders_of_images_are_carried_and_what_a_crash_leaves_is_swept() {
    let (_keep, folder) = folder();
    let clip = folder.join("frames");
    std::fs::create_dir(&clip).expect("a folder");
    for (name, bytes) in [("0000.png", &b"one"[..]), ("0001.png", b""), ("0002.png", b"three")] {
        std::fs::write(clip.join(name), bytes).expect("written");
    }
    let path = embedded(&folder, &clip);
    std::fs::remove_dir_all(&clip).expect("gone");
    let (first, second) =
        (open(&path), Session::open(&path, Access::ReadOnly, Progress::new().whole()).expect("opened"));
    let of = |session: &Session| session.document().inputs.clip.as_ref().expect("a clip").path.clone();
    assert_ne!(of(&first), of(&second), "two who read do not share");
    assert_eq!(std::fs::read(of(&second).join("0002.png")).expect("unpacked"), b"three");
    assert_eq!(std::fs::read(of(&second).join("0001.png")).expect("unpacked"), b"");
    let kept = first.unpacked_media();
    drop(first);
    assert_eq!(names(&folder).iter().filter(|n| n.starts_with('.')).count(), 2, "somebody still reads");
    drop((kept, second));
    assert_eq!(names(&folder).iter().filter(|n| n.starts_with('.')).count(), 0);

    let left = folder.join(".walk.marey-media-crash");
    std::fs::create_dir(&left).expect("a folder");
    std::fs::write(left.join("in-use"), b"").expect("written");
    drop(open(&path));
    assert!(!left.exists());
}

#[test]
fn damage_and_names_that_lead_elsewhere_are_said_and_harm_nothing() {
    let (_keep, folder) = folder();
    let clip = folder.join("walk.mp4");
    std::fs::write(&clip, big(3)).expect("written");
    let path = embedded(&folder, &clip);
    let whole = std::fs::read(&path).expect("written");
    // In the middle of the second piece.
    let mut bytes = whole.clone();
    bytes[2_000_000] ^= 1;
    std::fs::write(&path, &bytes).expect("written");
    let session = open(&path);
    assert!(session.warnings().iter().any(|w| w.contains("embedded clip is damaged")), "{:?}", session.warnings());
    assert_eq!(session.document().inputs.clip.as_ref().expect("a clip").path, clip, "the reference is left");
    drop(session);

    let record = |name: &str| {
        let data = serde_json::json!({"file": name, "of": 4, "at": 0, "base64": "ZXZpbA=="});
        record::encode(&serde_json::json!({"section": "media", "data": data})).expect("a record")
    };
    for name in
        ["../evil", "/tmp/evil", "clip/../../evil", "a/b", "clip/b/c/d", "", "clip", "clip/", "clip/.", "clip//x"]
    {
        std::fs::write(&path, [&whole[..], record(name).as_bytes()].concat()).expect("written");
        let session = open(&path);
        assert!(session.warnings().iter().any(|w| w.contains("leads elsewhere")), "{name}: {:?}", session.warnings());
        assert!(!folder.join("evil").exists() && !folder.join("../evil").exists());
    }
}

#[test]
fn a_clip_that_is_gone_cannot_be_embedded_and_nothing_is_lost() {
    let (_keep, folder) = folder();
    let clip = folder.join("walk.mp4");
    std::fs::write(&clip, big(4)).expect("written");
    let path = embedded(&folder, &clip);
    let before = std::fs::read(&path).expect("written");
    let mut session = Session::open(&path, Access::Edit, Progress::new().whole()).expect("opened");
    let other = folder.join("other.mp4");
    std::fs::write(&other, big(5)).expect("written");
    session.set_clip(Some(reference(&other))).expect("another clip");
    std::fs::remove_file(&other).expect("gone");
    let said = session.save().expect_err("nothing to embed").to_string();
    assert!(said.contains("other.mp4"), "{said}");
    assert_eq!(std::fs::read(&path).expect("there"), before);
    drop(session);
    assert_eq!(open(&path).document().inputs.clip.as_ref().expect("a clip").path, other, "the journal has the gesture");
}
