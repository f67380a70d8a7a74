//! What the tests of the C ABI share: a context, a small clip, a rig, and the library's own defaults.
#![allow(dead_code, reason = "each test file is a crate of its own and uses a part")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::ffi::{CStr, c_char};
use std::path::Path;
use std::ptr;

use marey_ffi::*;

pub(crate) const OK: mry_status = mry_status_code::MRY_OK as mry_status;

/// A context that is destroyed with the test.
pub(crate) struct Fixture {
    pub(crate) context: *mut mry_context,
    pub(crate) folder: tempfile::TempDir,
}

impl Drop for Fixture {
    fn drop(&mut self) {
        unsafe { mry_context_destroy(self.context) };
    }
}

pub(crate) fn str(text: &str) -> mry_str {
    mry_str { data: text.as_ptr().cast(), len: text.len() }
}

pub(crate) fn error() -> mry_error {
    let mut error = mry_error { struct_size: 0, status: 77, message: [1; 512], param: [1; 64] };
    unsafe { mry_error_init(&mut error, size_of::<mry_error>() as u32) };
    error
}

pub(crate) fn text(chars: &[c_char]) -> String {
    let bytes: Vec<u8> = chars.iter().take_while(|c| **c != 0).map(|c| *c as u8).collect();
    String::from_utf8(bytes).expect("UTF-8")
}

pub(crate) fn code(code: mry_status_code) -> mry_status {
    code as mry_status
}

pub(crate) fn status_text(status: mry_status) -> String {
    unsafe { CStr::from_ptr(mry_status_text(status)) }.to_str().expect("UTF-8").to_owned()
}

pub(crate) fn context_desc(threads: u32) -> mry_context_desc {
    mry_context_desc {
        struct_size: size_of::<mry_context_desc>() as u32,
        abi_version: mry_version() >> 8 & 0xff | (mry_version() >> 16) << 16,
        threads,
        reserved0: 0,
        log: None,
        log_user: ptr::null_mut(),
        limits: ptr::null(),
        executor: ptr::null(),
        allocator: ptr::null(),
    }
}

pub(crate) fn context(threads: u32) -> *mut mry_context {
    let (mut context, mut err) = (ptr::null_mut(), error());
    let status = unsafe { mry_context_create(&context_desc(threads), &mut context, &mut err) };
    assert_eq!(status, OK, "{}", text(&err.message));
    context
}

pub(crate) fn fixture() -> Fixture {
    Fixture { context: context(2), folder: tempfile::tempdir().unwrap() }
}

/// Width and height of the small clip.
pub(crate) const SIZE: (u32, u32) = (96, 64);
pub(crate) const FRAMES: u64 = 6;

/// A dark bar that wanders over a light, uneven ground.
pub(crate) fn write_clip(folder: &Path) {
    for frame in 0..FRAMES as u32 {
        let at = 30 + 2 * frame;
        let image = image::RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
            let bar = x >= at && x < at + 30 && (26..38).contains(&y);
            let grain = ((x * 37 + y * 91) % 17) as u8;
            if bar { image::Rgb([60 + grain, 40, 30]) } else { image::Rgb([190, 200 - grain, 180 + grain]) }
        });
        image.save(folder.join(format!("{frame:05}.png"))).unwrap();
    }
}

pub(crate) const STROKES: &str = r#"{"format":"marey-strokes","version":1,"size":[96,64],"limbs":[{"label":"body"}],
    "keyframes":[{"frame":0,"strokes":[{"limb":"body","points":[[33,32],[57,32]]}]}]}"#;

/// The rig of a small character: a bar of 40 by 8 pixels with three joints along it.
pub(crate) fn bar_rig() -> String {
    let (columns, rows) = (11, 3);
    let points: Vec<String> =
        (0..columns * rows).map(|i| format!("[{}, {}]", 4 + 4 * (i % columns), 6 + 4 * (i / columns))).collect();
    let triangles: Vec<String> = (0..(columns - 1) * (rows - 1))
        .map(|i| {
            let a = i / (columns - 1) * columns + i % (columns - 1);
            let c = a + columns;
            format!("[{a}, {}, {}], [{a}, {}, {c}]", a + 1, c + 1, c + 1)
        })
        .collect();
    format!(
        r#"{{"format": "marey-rig", "version": 1, "size": [48, 20], "mesh": {{"points": [{}], "triangles": [{}]}},
        "joints": [{{"name": "a", "at": [6, 10]}}, {{"name": "b", "at": [24, 10]}}, {{"name": "c", "at": [42, 10]}}],
        "bones": [["a", "b"], ["b", "c"]], "curve": [[[6, 10], [42, 10]]]}}"#,
        points.join(", "),
        triangles.join(", ")
    )
}

/// The picture of the small character: a red bar on clear ground.
pub(crate) fn bar_picture() -> image::RgbaImage {
    image::RgbaImage::from_fn(48, 20, |x, y| {
        let inside = (4..44).contains(&x) && (6..14).contains(&y);
        image::Rgba(if inside { [200, 40 + x as u8, 30, 255] } else { [0; 4] })
    })
}

pub(crate) fn view(picture: &image::RgbaImage) -> mry_image_view {
    let mut view = unsafe { std::mem::zeroed::<mry_image_view>() };
    unsafe { mry_image_view_init(&mut view, size_of::<mry_image_view>() as u32) };
    (view.format, view.width, view.height) = (MRY_FORMAT_RGBA8, picture.width(), picture.height());
    view.data = picture.as_raw().as_ptr();
    view
}

pub(crate) fn character_desc() -> mry_character_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_character_desc>() };
    unsafe { mry_character_desc_init(&mut desc, size_of::<mry_character_desc>() as u32) };
    desc
}

impl Fixture {
    /// The small character with its picture.
    pub(crate) fn character(&self) -> mry_character {
        let (picture, rig) = (bar_picture(), bar_rig());
        let (pixels, mut desc) = (view(&picture), character_desc());
        (desc.pixels, desc.rig_json) = (&pixels, str(&rig));
        let (mut character, mut err) = (mry_character::default(), error());
        let status = unsafe { mry_run_character(self.context, &desc, &mut character, &mut err) };
        assert_eq!(status, OK, "{}", text(&err.message));
        character
    }

    pub(crate) fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }

    /// The small clip, opened.
    pub(crate) fn clip(&self) -> mry_clip {
        let folder = self.folder.path().join("clip");
        if !folder.exists() {
            std::fs::create_dir(&folder).unwrap();
            write_clip(&folder);
        }
        let (mut clip, mut err) = (mry_clip::default(), error());
        let path = self.path("clip");
        let status = unsafe { mry_clip_open(self.context, str(&path), ptr::null(), &mut clip, &mut err) };
        assert_eq!(status, OK, "{}", text(&err.message));
        clip
    }

    pub(crate) fn rig(&self) -> mry_rig {
        let (mut rig, mut err) = (mry_rig::default(), error());
        let status = unsafe { mry_rig_from_json(self.context, str(STROKES), &mut rig, &mut err) };
        assert_eq!(status, OK, "{}", text(&err.message));
        rig
    }

    /// A session in memory, with the small clip and its rig.
    pub(crate) fn session(&self) -> mry_session {
        let (mut session, mut err) = (mry_session::default(), error());
        unsafe {
            assert_eq!(mry_session_create(self.context, str(""), &mut session, &mut err), OK);
            let status = mry_session_set_clip(self.context, session, self.clip(), &mut err);
            assert_eq!(status, OK, "{}", text(&err.message));
            assert_eq!(mry_session_set_rig(self.context, session, self.rig(), &mut err), OK);
        }
        session
    }

    pub(crate) fn track_desc(&self) -> mry_track_desc {
        let mut desc = zeroed_track();
        (desc.clip, desc.rig) = (self.clip(), self.rig());
        desc
    }

    pub(crate) fn creature_desc(&self) -> mry_creature_desc {
        let mut desc = unsafe { std::mem::zeroed::<mry_creature_desc>() };
        unsafe { mry_creature_desc_init(&mut desc, size_of::<mry_creature_desc>() as u32) };
        (desc.clip, desc.rig) = (self.clip(), self.rig());
        desc
    }

    pub(crate) fn motion(&self) -> mry_motion {
        let (mut motion, mut err) = (mry_motion::default(), error());
        let status = unsafe { mry_run_track(self.context, &self.track_desc(), &mut motion, &mut err) };
        assert_eq!(status, OK, "{}", text(&err.message));
        motion
    }
}

pub(crate) fn zeroed_track() -> mry_track_desc {
    let mut desc = unsafe { std::mem::zeroed::<mry_track_desc>() };
    unsafe { mry_track_desc_init(&mut desc, size_of::<mry_track_desc>() as u32) };
    desc
}
