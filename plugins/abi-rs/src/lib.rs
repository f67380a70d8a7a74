//! The second door of a plugin library: the interfaces of `plugin.h` in types whose layout abi_stable checks when the
//! library is loaded.
//!
//! **Frozen.** `tracker/1`, `segmenter/1` and `deformer/1` are [`Tracker1`], [`Segmenter1`] and [`Deformer1`], and none
//! of the types below ever changes: abi_stable refuses a library that is older than its host by one field. What is new
//! becomes a trait of its own, asked for by [`Root1::get_extension`]. The C door is the contract that
//! lasts; this one stands beside it, says the same, and is told apart by nothing that a plugin can see.
//!
//! abi_stable is used here and nowhere else. Never load a library by `RootModule::load_from_file`: it keeps one library
//! a process, whatever file is named; [`open`] takes what a loader of one's own found. No function here may panic on a
//! plugin's side: a panic in a method of `#[sabi_trait]` ends the process, so the sdk's guard stands in front.
#![allow(non_camel_case_types, reason = "abi_stable names trait objects so")]
#![allow(non_local_definitions, reason = "abi_stable 0.11 expands to such")]
#![allow(
    missing_docs,
    unreachable_pub,
    unused_qualifications,
    clippy::all,
    reason = "what abi_stable expands to is not ours"
)]

use std::ffi::c_void;

use abi_stable::library::{AbiHeaderRef, LibraryError, RootModule};
use abi_stable::package_version_strings;
use abi_stable::sabi_types::{RRef, VersionStrings};
use abi_stable::std_types::{RBox, ROption, RResult, RSlice, RStr, RString, RVec};
use abi_stable::{StableAbi, sabi_trait};

pub use abi_stable::std_types;

/// The symbol that a library exports, with its NUL.
pub use abi_stable::library::ROOT_MODULE_LOADER_NAME_WITH_NUL as SYMBOL;

/// A place in clip pixels.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug, Default, PartialEq)]
pub struct Point1 {
    pub x: f32,
    pub y: f32,
}

/// The clip.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Clip1 {
    pub width: u32,
    pub height: u32,
    pub frame_count: u64,
    pub fps: f64,
}

/// A lent frame, as `mry_plugin_frame`.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Frame1 {
    pub width: u32,
    pub height: u32,
    pub stride_bytes: u32,
    pub reserved0: u32,
    pub pixels: *const u8,
    pub token: *mut c_void,
}

/// A limb, as `mry_plugin_limb`.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Limb1<'a> {
    pub label: RStr<'a>,
    pub side: i32,
    pub parent: i32,
    pub point_count: u32,
    pub flags: u32,
}

/// A limb on a frame, as `mry_plugin_stroke`.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Stroke1<'a> {
    pub points: RSlice<'a, Point1>,
    pub frame: u64,
    pub limb: u32,
    pub facing: i32,
}

/// A brush stroke, as `mry_plugin_paint`.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Paint1<'a> {
    pub points: RSlice<'a, Point1>,
    pub frame: u64,
    pub foreground: u32,
    pub radius: f32,
}

/// A painted mask, as `mry_plugin_painted`.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Painted1<'a> {
    pub pixels: RSlice<'a, u8>,
    pub frame: u64,
}

/// A tracked limb, as `mry_plugin_track`.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Track1<'a> {
    pub label: RStr<'a>,
    pub points: RSlice<'a, Point1>,
    pub visible: RSlice<'a, u8>,
    pub confidence: RSlice<'a, f32>,
    pub point_count: u32,
}

/// All that a tracker or a segmenter is told; a tracker gets no paints and no tracks.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Brief1<'a> {
    pub clip: Clip1,
    pub limbs: RSlice<'a, Limb1<'a>>,
    pub strokes: RSlice<'a, Stroke1<'a>>,
    pub paints: RSlice<'a, Paint1<'a>>,
    pub painted: RSlice<'a, Painted1<'a>>,
    pub tracks: RSlice<'a, Track1<'a>>,
}

/// A mesh, as `mry_plugin_mesh`; three indices a triangle.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Mesh1<'a> {
    pub points: RSlice<'a, Point1>,
    pub triangles: RSlice<'a, [u32; 3]>,
}

/// A handle, as `mry_plugin_handle`.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Handle1 {
    pub kind: i32,
    pub a: Point1,
    pub b: Point1,
}

/// Why a call failed: a status of `plugin.h` that is not 0, and words.
#[repr(C)]
#[derive(StableAbi, Clone, Debug)]
pub struct Failure1 {
    pub status: i32,
    pub message: RString,
}

/// A parameter, as `mry_plugin_parameter`.
#[repr(C)]
#[derive(StableAbi, Clone, Debug)]
pub struct Parameter1 {
    pub kind: i32,
    pub flags: u32,
    pub id: RString,
    pub label: RString,
    pub about: RString,
    pub group: RString,
    pub unit: RString,
    pub low: f64,
    pub high: f64,
    pub default_value: f64,
    pub step: f64,
    pub choices: RVec<RString>,
    pub default_text: RString,
    pub visible_if: RString,
    pub visible_value: f64,
}

/// What a plugin is, as `mry_plugin_descriptor`.
#[repr(C)]
#[derive(StableAbi, Clone, Debug)]
pub struct Plugin1 {
    pub kind: i32,
    pub state_version: u32,
    pub id: RString,
    pub name: RString,
    pub vendor: RString,
    pub version: RString,
    pub about: RString,
    pub parameters: RVec<Parameter1>,
}

/// The value of a parameter.
#[repr(C)]
#[derive(StableAbi, Clone, Copy, Debug)]
pub struct Value1<'a> {
    pub id: RStr<'a>,
    pub number: f64,
    pub text: ROption<RStr<'a>>,
}

/// The host's end of a piece of work: the functions of `mry_plugin_job`, callable from any thread.
#[sabi_trait]
pub trait Host1: Sync {
    /// Whether to go on.
    fn progress(&self, fraction: f64, stage: ROption<RStr<'_>>) -> bool;
    fn get_frame(&self, index: u64) -> RResult<Frame1, i32>;
    fn release_frame(&self, token: *mut c_void);
    fn put_stroke(
        &self,
        limb: u32,
        frame: u64,
        points: RSlice<'_, Point1>,
        visible: RSlice<'_, u8>,
        confidence: RSlice<'_, f32>,
    ) -> i32;
    fn put_mask(&self, frame: u64, pixels: RSlice<'_, u8>, width: u32, height: u32, stride: usize) -> i32;
}

/// A host, lent for a call.
pub type HostRef<'a> = Host1_TO<'a, RRef<'a, ()>>;

/// tracker/1
#[sabi_trait]
pub trait Tracker1: Send {
    fn track(&mut self, brief: &Brief1<'_>, host: &HostRef<'_>) -> RResult<(), Failure1>;
    fn save(&mut self) -> RResult<RVec<u8>, Failure1>;
    fn load(&mut self, version: u32, state: RSlice<'_, u8>) -> RResult<(), Failure1>;
}

/// segmenter/1
#[sabi_trait]
pub trait Segmenter1: Send {
    fn segment(&mut self, brief: &Brief1<'_>, host: &HostRef<'_>) -> RResult<(), Failure1>;
    fn save(&mut self) -> RResult<RVec<u8>, Failure1>;
    fn load(&mut self, version: u32, state: RSlice<'_, u8>) -> RResult<(), Failure1>;
}

/// deformer/1. What is bound is known by a number.
#[sabi_trait]
pub trait Deformer1: Send {
    fn bind(&mut self, mesh: &Mesh1<'_>, rest: RSlice<'_, Handle1>, host: &HostRef<'_>) -> RResult<u64, Failure1>;
    fn solve(
        &mut self,
        bound: u64,
        targets: RSlice<'_, Handle1>,
        points: &mut RVec<Point1>,
        host: &HostRef<'_>,
    ) -> RResult<(), Failure1>;
    fn unbind(&mut self, bound: u64);
    fn save(&mut self) -> RResult<RVec<u8>, Failure1>;
    fn load(&mut self, version: u32, state: RSlice<'_, u8>) -> RResult<(), Failure1>;
}

pub type TrackerBox = Tracker1_TO<'static, RBox<()>>;
pub type SegmenterBox = Segmenter1_TO<'static, RBox<()>>;
pub type DeformerBox = Deformer1_TO<'static, RBox<()>>;

/// An instance.
#[repr(u8)]
#[derive(StableAbi)]
pub enum Instance1 {
    Tracker(TrackerBox),
    Segmenter(SegmenterBox),
    Deformer(DeformerBox),
}

/// Where log lines go, for as long as the library is loaded.
#[repr(C)]
#[derive(StableAbi, Clone, Copy)]
pub struct Log1 {
    pub data: *const c_void,
    pub line: extern "C" fn(*const c_void, i32, RStr<'_>),
}

/// What a library exports.
#[repr(C)]
#[derive(StableAbi)]
#[sabi(kind(Prefix(prefix_ref = Root1_Ref)))]
#[sabi(missing_field(panic))]
pub struct Root1 {
    /// Called once, first.
    pub init: extern "C" fn(Log1),
    /// What is inside.
    pub plugins: extern "C" fn() -> RVec<Plugin1>,
    /// Makes an instance of one of them.
    pub create: extern "C" fn(u32, RSlice<'_, Value1<'_>>) -> RResult<Instance1, Failure1>,
    /// More, by "name/REVISION"; null for what the library does not have.
    #[sabi(last_prefix_field)]
    pub get_extension: extern "C" fn(RStr<'_>) -> *const c_void,
}

impl RootModule for Root1_Ref {
    abi_stable::declare_root_module_statics! {Root1_Ref}
    const BASE_NAME: &'static str = "marey_plugin";
    const NAME: &'static str = "marey plugin";
    // The interface's own version, whatever the crate's: it is frozen.
    const VERSION_STRINGS: VersionStrings = package_version_strings!();
}

/// Why a library does not come in by this door.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mismatch {
    /// It is made with another abi_stable, or for another version of these interfaces.
    Version,
    /// A type is laid out in another way.
    Layout,
    /// It did not start.
    Start,
}

/// Checks a library's header and layouts, and gives its root.
///
/// # Errors
/// What does not match, and the whole of what abi_stable says of it, which may be tens of kilobytes.
///
/// # Safety
/// `symbol` is what a library exports under [`SYMBOL`], and the library is never unloaded.
pub unsafe fn open(symbol: AbiHeaderRef) -> Result<Root1_Ref, (Mismatch, String)> {
    let opened = symbol.upgrade().and_then(|header| header.init_root_module::<Root1_Ref>());
    opened.map_err(|error| {
        let what = match &error {
            LibraryError::AbiInstability(_) => Mismatch::Layout,
            LibraryError::RootModule { .. } => Mismatch::Start,
            _ => Mismatch::Version,
        };
        (what, error.to_string())
    })
}

pub use abi_stable::library::AbiHeaderRef as Header;

/// What the sdk's macro needs to export a root.
#[doc(hidden)]
pub mod export {
    pub use abi_stable::library::{__call_root_module_loader, CheckTypeLayout, LibHeader, RootModuleResult};
    pub use abi_stable::prefix_type::PrefixTypeTrait;
    pub use abi_stable::sabi_trait::TD_Opaque;
    pub use abi_stable::type_level::downcasting::TD_Opaque as Opaque;

    /// The header of a root.
    ///
    /// # Safety
    /// `constructor` gives a `Root1_Ref` by `__call_root_module_loader`.
    pub const unsafe fn header(constructor: extern "C" fn() -> RootModuleResult) -> LibHeader {
        // SAFETY: as this function's own.
        unsafe { LibHeader::from_constructor::<crate::Root1_Ref>(constructor, CheckTypeLayout::Yes) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A change of any of these would shut out every plugin that was built before it.
    #[test]
    #[cfg(target_pointer_width = "64")]
    fn the_interfaces_are_frozen() {
        let sizes = [
            ("Point1", size_of::<Point1>(), 8),
            ("Clip1", size_of::<Clip1>(), 24),
            ("Frame1", size_of::<Frame1>(), 32),
            ("Limb1", size_of::<Limb1<'_>>(), 32),
            ("Stroke1", size_of::<Stroke1<'_>>(), 32),
            ("Paint1", size_of::<Paint1<'_>>(), 32),
            ("Painted1", size_of::<Painted1<'_>>(), 24),
            ("Track1", size_of::<Track1<'_>>(), 72),
            ("Brief1", size_of::<Brief1<'_>>(), 104),
            ("Mesh1", size_of::<Mesh1<'_>>(), 32),
            ("Handle1", size_of::<Handle1>(), 20),
            ("Failure1", size_of::<Failure1>(), 40),
            ("Parameter1", size_of::<Parameter1>(), 304),
            ("Plugin1", size_of::<Plugin1>(), 200),
            ("Value1", size_of::<Value1<'_>>(), 48),
            ("Log1", size_of::<Log1>(), 16),
            ("Root1", size_of::<Root1>(), 32),
        ];
        let changed: Vec<_> = sizes.iter().filter(|(_, now, frozen)| now != frozen).collect();
        assert!(changed.is_empty(), "{changed:?}");
        assert_eq!(<Root1_Ref as RootModule>::VERSION_STRINGS.version.as_str(), "1.0.0");
    }
}
