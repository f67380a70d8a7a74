//! What hosts edit and read through the binding.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use marey_binding::{Context, Facing, LimbDepth, Side};

#[test]
fn depths_are_said_undone_kept_and_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.marey").to_str().unwrap().to_owned();
    let context = Context::new(1).unwrap();
    let session = context.new_session(&path).unwrap();
    session.set_rig(&context.new_rig(96, 64).unwrap()).unwrap();
    let leg = session.add_limb("leg", Side::Near).unwrap();
    session.set_stroke(leg, 0, &[(5.0, 5.0), (40.0, 30.0)], Facing::Unknown).unwrap();
    let front = LimbDepth { depth: Some(12.5), bend: None };
    session.set_depth(leg, 3, front).unwrap();
    let rig = session.rig().unwrap();
    assert_eq!((rig.depth(leg, 3).unwrap(), rig.depth(leg, 0).unwrap()), (front, LimbDepth::default()));
    assert_eq!(rig.key_frames().unwrap(), [0, 3]);
    assert!(session.undo().unwrap());
    assert_eq!(session.rig().unwrap().depth(leg, 3).unwrap(), LimbDepth::default());
    assert!(session.redo().unwrap());
    assert!(session.set_depth(leg, 3, LimbDepth { depth: Some(f32::NAN), bend: None }).is_err());
    assert!(session.set_depth(leg + 1, 3, front).is_err());
    drop(session);
    let session = context.open_session(&path, marey_binding::Access::Edit).unwrap();
    assert_eq!(session.rig().unwrap().depth(leg, 3).unwrap(), front, "from its journal");
    session.set_depth(leg, 3, LimbDepth::default()).unwrap();
    assert_eq!(session.rig().unwrap().key_frames().unwrap(), [0], "nothing is said any more");

    let both = LimbDepth { depth: Some(-2.0), bend: Some(4.0) };
    let rig = session.rig().unwrap();
    rig.set_depth(leg, 1, both).unwrap();
    assert_eq!(rig.depth(leg, 1).unwrap(), both);
    let read = context.rig_from_json(&rig.to_json().unwrap()).unwrap();
    assert_eq!(read.depth(leg, 1).unwrap(), both);
}

#[test]
fn what_is_see_through_in_a_clip_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let context = Context::new(1).unwrap();
    let save = |name: &str, alpha: fn(u32) -> u8| {
        let clip = folder.path().join(name);
        std::fs::create_dir(&clip).unwrap();
        for frame in 0..2 {
            let picture = image::RgbaImage::from_fn(6, 4, |x, _| image::Rgba([9, 200, 7, alpha(x)]));
            picture.save(clip.join(format!("{frame:05}.png"))).unwrap();
        }
        context.open_clip(clip.to_str().unwrap()).unwrap()
    };
    let clip = save("half", |x| (x * 50) as u8);
    assert_eq!(clip.alpha(1).unwrap()[..6], [0, 50, 100, 150, 200, 250]);
    assert_eq!(save("whole", |_| 255).alpha(0).unwrap(), [255; 24]);
    assert!(clip.alpha(2).is_err());
}
