//! What a library's plugins are, as C reads it. Made once, and there for as long as the library is loaded.

use std::ffi::{CString, c_char};
use std::ptr;

use crate::export::Registration;
use crate::parameter::{Kind, Parameter};
use crate::raw;

/// The C descriptors of all plugins.
pub(crate) struct Descriptors(pub(crate) Vec<raw::Descriptor>);

// SAFETY: all pointers are to leaked memory that is never written to.
unsafe impl Send for Descriptors {}
// SAFETY: as above.
unsafe impl Sync for Descriptors {}

/// The text with a NUL, for ever. A NUL inside would end it early for its reader; the host refuses the id then.
fn text(text: &str) -> *const c_char {
    let bytes: Vec<u8> = text.bytes().map(|b| if b == 0 { b' ' } else { b }).collect();
    CString::new(bytes).map_or(ptr::null(), |text| Box::leak(text.into_boxed_c_str()).as_ptr())
}

fn optional(some: &str) -> *const c_char {
    if some.is_empty() { ptr::null() } else { text(some) }
}

fn list<T>(items: Vec<T>) -> *const T {
    if items.is_empty() { ptr::null() } else { items.leak().as_ptr() }
}

fn parameter(parameter: &Parameter) -> *const raw::Parameter {
    let mut raw = raw::Parameter {
        struct_size: size_of::<raw::Parameter>() as u32,
        kind: raw::NUMBER,
        id: text(parameter.id),
        label: text(parameter.label),
        about: optional(parameter.about),
        group: optional(parameter.group),
        unit: optional(parameter.unit),
        low: 0.0,
        high: 0.0,
        default_value: 0.0,
        step: parameter.step,
        choices: ptr::null(),
        default_text: ptr::null(),
        visible_if: parameter.visible_if.map_or(ptr::null(), |(id, _)| text(id)),
        visible_value: parameter.visible_if.map_or(0.0, |(_, value)| value),
        choice_count: 0,
        flags: parameter.flags,
    };
    match parameter.kind {
        Kind::Number { low, high, default } => (raw.low, raw.high, raw.default_value) = (low, high, default),
        Kind::Whole { low, high, default } => {
            raw.kind = raw::WHOLE;
            (raw.low, raw.high, raw.default_value) = (low.into(), high.into(), default.into());
        }
        Kind::Switch { default } => {
            raw.kind = raw::SWITCH;
            (raw.high, raw.default_value) = (1.0, f64::from(u8::from(default)));
        }
        Kind::Choice { names, default } => {
            raw.kind = raw::CHOICE;
            raw.choice_count = names.len() as u32;
            raw.choices = list(names.iter().map(|n| text(n)).collect());
            (raw.high, raw.default_value) = (names.len().saturating_sub(1) as f64, default.into());
        }
        Kind::Text { default } => {
            raw.kind = raw::TEXT;
            raw.default_text = optional(default);
        }
        Kind::File => raw.kind = raw::FILE,
    }
    Box::leak(Box::new(raw))
}

impl Descriptors {
    pub(crate) fn new(registrations: &[Registration]) -> Self {
        let one = |r: &Registration| raw::Descriptor {
            struct_size: size_of::<raw::Descriptor>() as u32,
            kind: r.kind,
            id: text(r.info.id),
            name: text(r.info.name),
            vendor: optional(r.info.vendor),
            version: text(r.info.version),
            about: optional(r.info.about),
            parameters: list(r.parameters.iter().map(parameter).collect()),
            parameter_count: r.parameters.len() as u32,
            state_version: r.state_version,
        };
        Self(registrations.iter().map(one).collect())
    }
}
