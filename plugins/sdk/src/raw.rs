//! `include/marey/plugin.h` in Rust, field for field; a test compares them through a C compiler. For hosts.
#![allow(missing_docs, reason = "plugin.h documents them")]

use std::ffi::{c_char, c_void};

pub use crate::point::Point;

pub const ABI_MAJOR: u32 = 1;
pub const ABI_MINOR: u32 = 0;
/// The symbol that a plugin exports.
pub const ENTRY: &str = "mry_plugin_entry_v1";

pub const OK: i32 = 0;
pub const CANCELLED: i32 = 1;
pub const E_INVALID: i32 = -1;
pub const E_FAILED: i32 = -2;
pub const E_UNSUPPORTED: i32 = -3;
pub const E_PANICKED: i32 = -4;
pub const E_POISONED: i32 = -5;

pub const SIDE_UNKNOWN: i32 = 0;
pub const SIDE_NEAR: i32 = 1;
pub const SIDE_FAR: i32 = 2;
pub const SIDE_MID: i32 = 3;
pub const LIMB_ROOTED_AT_START: u32 = 1;
pub const LIMB_TERMINAL: u32 = 2;
pub const FACING_UNKNOWN: i32 = 0;
pub const FACING_TOWARD: i32 = 1;
pub const FACING_AWAY: i32 = 2;
pub const HANDLE_POINT: i32 = 1;
pub const HANDLE_BONE: i32 = 2;

pub const CONTINUE: i32 = 0x100;
pub const CANCEL: i32 = 0x200;

pub const LOG_ERROR: i32 = 1;
pub const LOG_WARNING: i32 = 2;
pub const LOG_INFO: i32 = 3;

pub const NUMBER: i32 = 0;
pub const WHOLE: i32 = 1;
pub const SWITCH: i32 = 2;
pub const CHOICE: i32 = 3;
pub const TEXT: i32 = 4;
pub const FILE: i32 = 5;
pub const ADVANCED: u32 = 1;
pub const HIDDEN: u32 = 2;
pub const LOGARITHMIC: u32 = 4;

pub const TRACKER: i32 = 1;
pub const SEGMENTER: i32 = 2;
pub const DEFORMER: i32 = 3;

pub const STATE_1: &str = "mry.state/1";

#[repr(C)]
#[derive(Debug)]
pub struct Error {
    pub struct_size: u32,
    pub reserved0: u32,
    pub message: [c_char; 512],
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Clip {
    pub struct_size: u32,
    pub width: u32,
    pub height: u32,
    pub reserved0: u32,
    pub frame_count: u64,
    pub fps: f64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub struct_size: u32,
    pub width: u32,
    pub height: u32,
    pub stride_bytes: u32,
    pub pixels: *const u8,
    pub token: *mut c_void,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Limb {
    pub label: *const c_char,
    pub side: i32,
    pub parent: i32,
    pub point_count: u32,
    pub flags: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    pub points: *const Point,
    pub frame: u64,
    pub limb: u32,
    pub point_count: u32,
    pub facing: i32,
    pub reserved0: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Paint {
    pub points: *const Point,
    pub frame: u64,
    pub point_count: u32,
    pub foreground: u32,
    pub radius: f32,
    pub reserved0: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Painted {
    pub pixels: *const u8,
    pub frame: u64,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Rig {
    pub struct_size: u32,
    pub limb_count: u32,
    pub limbs: *const Limb,
    pub strokes: *const Stroke,
    pub paints: *const Paint,
    pub painted: *const Painted,
    pub stroke_count: u32,
    pub paint_count: u32,
    pub painted_count: u32,
    pub reserved0: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Track {
    pub label: *const c_char,
    pub points: *const Point,
    pub visible: *const u8,
    pub confidence: *const f32,
    pub point_count: u32,
    pub reserved0: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    pub struct_size: u32,
    pub track_count: u32,
    pub tracks: *const Track,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Mesh {
    pub struct_size: u32,
    pub point_count: u32,
    pub points: *const Point,
    pub triangles: *const u32,
    pub triangle_count: u32,
    pub reserved0: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Handle {
    pub kind: i32,
    pub reserved0: u32,
    pub a: Point,
    pub b: Point,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Job {
    pub struct_size: u32,
    pub reserved0: u32,
    pub data: *mut c_void,
    pub progress: Option<unsafe extern "C" fn(*const Job, f64, *const c_char) -> i32>,
    pub get_frame: Option<unsafe extern "C" fn(*const Job, u64, *mut Frame) -> i32>,
    pub release_frame: Option<unsafe extern "C" fn(*const Job, *mut Frame)>,
    pub put_stroke: Option<unsafe extern "C" fn(*const Job, u32, u64, *const Point, *const u8, *const f32, u32) -> i32>,
    pub put_mask: Option<unsafe extern "C" fn(*const Job, u64, *const u8, u32, u32, usize) -> i32>,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Host {
    pub struct_size: u32,
    pub abi_major: u32,
    pub abi_minor: u32,
    pub reserved0: u32,
    pub name: *const c_char,
    pub version: *const c_char,
    pub data: *mut c_void,
    pub log: Option<unsafe extern "C" fn(*const Host, i32, *const c_char)>,
    pub get_extension: Option<unsafe extern "C" fn(*const Host, *const c_char) -> *const c_void>,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    pub struct_size: u32,
    pub kind: i32,
    pub id: *const c_char,
    pub label: *const c_char,
    pub about: *const c_char,
    pub group: *const c_char,
    pub unit: *const c_char,
    pub low: f64,
    pub high: f64,
    pub default_value: f64,
    pub step: f64,
    pub choices: *const *const c_char,
    pub default_text: *const c_char,
    pub visible_if: *const c_char,
    pub visible_value: f64,
    pub choice_count: u32,
    pub flags: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Value {
    pub id: *const c_char,
    pub number: f64,
    pub text: *const c_char,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Descriptor {
    pub struct_size: u32,
    pub kind: i32,
    pub id: *const c_char,
    pub name: *const c_char,
    pub vendor: *const c_char,
    pub version: *const c_char,
    pub about: *const c_char,
    pub parameters: *const *const Parameter,
    pub parameter_count: u32,
    pub state_version: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    pub struct_size: u32,
    pub reserved0: u32,
    pub data: *mut c_void,
    pub destroy: Option<unsafe extern "C" fn(*const Instance)>,
    pub track: Option<unsafe extern "C" fn(*const Instance, *const Clip, *const Rig, *const Job, *mut Error) -> i32>,
    pub segment: Option<
        unsafe extern "C" fn(*const Instance, *const Clip, *const Rig, *const Motion, *const Job, *mut Error) -> i32,
    >,
    pub bind: Option<
        unsafe extern "C" fn(
            *const Instance,
            *const Mesh,
            *const Handle,
            u32,
            *const Job,
            *mut *mut c_void,
            *mut Error,
        ) -> i32,
    >,
    pub solve: Option<
        unsafe extern "C" fn(
            *const Instance,
            *mut c_void,
            *const Handle,
            u32,
            *mut Point,
            u32,
            *const Job,
            *mut Error,
        ) -> i32,
    >,
    pub unbind: Option<unsafe extern "C" fn(*const Instance, *mut c_void)>,
    pub get_extension: Option<unsafe extern "C" fn(*const Instance, *const c_char) -> *const c_void>,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub struct_size: u32,
    pub abi_major: u32,
    pub abi_minor: u32,
    pub reserved0: u32,
    pub init: Option<unsafe extern "C" fn(*const Host, *mut Error) -> i32>,
    pub get_count: Option<unsafe extern "C" fn() -> u32>,
    pub get_descriptor: Option<unsafe extern "C" fn(u32) -> *const Descriptor>,
    pub create: Option<unsafe extern "C" fn(u32, *const Value, u32, *mut *const Instance, *mut Error) -> i32>,
}

// SAFETY: a table of functions and numbers, never written to.
unsafe impl Sync for Entry {}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct State1 {
    pub struct_size: u32,
    pub reserved0: u32,
    pub save: Option<unsafe extern "C" fn(*const Instance, *mut u8, usize, *mut usize, *mut Error) -> i32>,
    pub load: Option<unsafe extern "C" fn(*const Instance, u32, *const u8, usize, *mut Error) -> i32>,
}
