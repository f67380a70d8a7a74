//! Parameters. What can be chosen about tracking, segmenting, reconstructing and exporting, as a table with bounds
//! that a host can show without knowing any of them. A session keeps what was chosen otherwise than by default.

use std::ffi::c_char;

use marey::session::{Kind, PARAMETERS, Parameter, Value};

use crate::border::{self, Out, OutStruct, Text, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, copy_text, mry_error};
use crate::guard::{Call, entry};
use crate::session::mry_session;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Kind of a parameter: any number from low to high.
pub const MRY_PARAMETER_NUMBER: i32 = 0;
/// Kind of a parameter: a whole number from low to high.
pub const MRY_PARAMETER_WHOLE: i32 = 1;
/// Kind of a parameter: a switch, 0 or 1.
pub const MRY_PARAMETER_SWITCH: i32 = 2;
/// Kind of a parameter: one of choice_count names, by its index.
pub const MRY_PARAMETER_CHOICE: i32 = 3;

/// Kind of a parameter: a line of text, see mry_session_set_text and mry_plugin_set_text.
pub const MRY_PARAMETER_TEXT: i32 = 4;

/// What a parameter is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_parameter_info {
    /// sizeof(mry_parameter_info).
    pub struct_size: u32,
    /// MRY_PARAMETER_NUMBER, ...; accept ones you do not know.
    pub kind: i32,
    /// The least value.
    pub low: f64,
    /// The greatest value.
    pub high: f64,
    /// The value where none is chosen.
    pub default_value: f64,
    /// How many names mry_parameter_get_choice has.
    pub choice_count: u32,
    /// Zero.
    pub reserved0: u32,
    /// Its name for ever, such as "creature.smoothing"; NUL-terminated.
    pub name: [c_char; 48],
    /// What it does, a sentence in English; NUL-terminated.
    pub about: [c_char; 136],
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_parameter_info {
    const FIRST_SIZE: usize = 224;
}
const _: () = assert!(size_of::<mry_parameter_info>() == 224);

fn nth(index: u32) -> Outcome<&'static Parameter> {
    let none = || Failure::new(Code::MRY_E_NOT_FOUND, "index", format!("there are {} parameters", PARAMETERS.len()));
    PARAMETERS.get(index as usize).ok_or_else(none)
}

/// # Safety
/// The string is valid, as the header asks.
unsafe fn named(name: mry_str) -> Outcome<&'static Parameter> {
    // SAFETY: as this function's own.
    let name = unsafe { name.name("name")? };
    let unknown = |e: marey::Error| Failure::new(Code::MRY_E_NOT_FOUND, "name", e.to_string());
    Parameter::named(name).map_err(unknown)
}

fn choices(parameter: &Parameter) -> &'static [&'static str] {
    if let Kind::Choice(names) = parameter.kind { names } else { &[] }
}

/// A value as the number that C has for it.
fn number_out(parameter: &Parameter, value: &Value) -> f64 {
    match value {
        Value::Switch(on) => f64::from(*on),
        Value::Number(number) => *number,
        Value::Choice(name) => choices(parameter).iter().position(|c| c == name).unwrap_or(0) as f64,
    }
}

/// The value that a number stands for.
fn value_in(parameter: &Parameter, number: f64) -> Outcome<Value> {
    if !number.is_finite() {
        return Err(Failure::new(Code::MRY_E_NON_FINITE, "value", format!("value is {number}")));
    }
    let whole = |count: usize| (0..count).find(|i| *i as f64 == number);
    let value = match parameter.kind {
        Kind::Number(..) | Kind::Whole(..) => Some(Value::Number(number)),
        Kind::Switch => whole(2).map(|i| Value::Switch(i == 1)),
        Kind::Choice(names) => whole(names.len()).map(|i| Value::Choice(names[i].to_owned())),
        Kind::Text => None,
    };
    let bad = |message: String| Failure::argument("value", message);
    let value = value.ok_or_else(|| bad(format!("parameter `{}` does not take {number}", parameter.name)))?;
    parameter.check(&value).map_err(|e| bad(e.to_string()))?;
    Ok(value)
}

/// Fills in a parameter info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_parameter_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_parameter_info_init(info: *mut mry_parameter_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// One of the parameters, in the order in which to show them.
///
/// @param context   The context.
/// @param index     Which, counted from 0.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there are no more), MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_parameter_get_info(
    context: *mut mry_context,
    index: u32,
    out_info: *mut mry_parameter_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |_call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let parameter = nth(index)?;
        let names = choices(parameter);
        let (kind, low, high) = match parameter.kind {
            Kind::Number(low, high) => (MRY_PARAMETER_NUMBER, low, high),
            Kind::Whole(low, high) => (MRY_PARAMETER_WHOLE, low, high),
            Kind::Switch => (MRY_PARAMETER_SWITCH, 0.0, 1.0),
            Kind::Choice(names) => (MRY_PARAMETER_CHOICE, 0.0, names.len() as f64 - 1.0),
            Kind::Text => (MRY_PARAMETER_TEXT, 0.0, 0.0),
        };
        let mut info = mry_parameter_info {
            struct_size: 0,
            kind,
            low,
            high,
            default_value: number_out(parameter, &parameter.default_value()),
            choice_count: names.len() as u32,
            reserved0: 0,
            name: [0; 48],
            about: [0; 136],
        };
        copy_text(parameter.name, &mut info.name);
        copy_text(parameter.about, &mut info.about);
        out.set(&info);
        Ok(Code::MRY_OK)
    })
}

/// The name of one of the values of a choice.
///
/// @param context   The context.
/// @param index     Which parameter.
/// @param choice    Which value, below choice_count.
/// @param text      Where the name goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (index, choice), MRY_E_BUFFER_TOO_SMALL.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_parameter_get_choice(
    context: *mut mry_context,
    index: u32,
    choice: u32,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |_call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let names = choices(nth(index)?);
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "choice", format!("there are {} choices", names.len()));
        text.fill(names.get(choice as usize).ok_or_else(none)?)
    })
}

impl Call<'_> {
    fn choose(&self, session: mry_session, parameter: &Parameter, value: Option<Value>) -> Outcome<Code> {
        self.session_mut(session, |document| {
            document.session.set_parameter(parameter.name, value)?;
            Ok(Code::MRY_OK)
        })
    }
}

/// Chooses the value of a parameter in a session; within a gesture only the last value of it counts.
///
/// @param context  The context.
/// @param session  The session.
/// @param name     The parameter's name.
/// @param value    A number within its bounds; 0 or 1 of a switch; the index of a choice.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (name), MRY_E_ARGUMENT (value), MRY_E_NON_FINITE, MRY_E_STRING,
///         MRY_E_INPUT (the session is read-only), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_parameter(
    context: *mut mry_context,
    session: mry_session,
    name: mry_str,
    value: f64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let parameter = named(name)?;
        call.choose(session, parameter, Some(value_in(parameter, value)?))
    })
}

/// Chooses the text of a parameter of kind MRY_PARAMETER_TEXT in a session, such as "track.plugin": the id of the plugin
/// that works in place of the built-in tracker.
///
/// @param context  The context.
/// @param session  The session.
/// @param name     The parameter's name.
/// @param text     A line of at most 127 bytes; empty for the default.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (name), MRY_E_ARGUMENT (text, or a parameter of another kind), MRY_E_STRING,
///         MRY_E_INPUT (the session is read-only), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_set_text(
    context: *mut mry_context,
    session: mry_session,
    name: mry_str,
    text: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let (parameter, text) = (named(name)?, text.text("text")?);
        let value = Value::Choice(text.to_owned());
        if parameter.kind != Kind::Text {
            let message = format!("parameter `{}` takes no text; see mry_session_set_parameter", parameter.name);
            return Err(Failure::argument("name", message));
        }
        parameter.check(&value).map_err(|e| Failure::argument("text", e.to_string()))?;
        call.choose(session, parameter, Some(value).filter(|_| !text.is_empty()))
    })
}

/// The text of a parameter of kind MRY_PARAMETER_TEXT in a session, chosen or by default.
///
/// @param context   The context.
/// @param session   The session.
/// @param name      The parameter's name.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (name), MRY_E_ARGUMENT (a parameter of another kind), MRY_E_BUFFER_TOO_SMALL,
///         MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_text(
    context: *mut mry_context,
    session: mry_session,
    name: mry_str,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let parameter = named(name)?;
        let out = Text::new(text, capacity, out_size, "text")?;
        call.session(session, |document| match document.session.document().inputs.settings.get(parameter.name)? {
            Value::Choice(text) if parameter.kind == Kind::Text => out.fill(&text),
            _ => Err(Failure::argument("name", format!("parameter `{}` has no text", parameter.name))),
        })
    })
}

/// Gives a parameter its default value again.
///
/// @param context  The context.
/// @param session  The session.
/// @param name     The parameter's name.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (name), MRY_E_STRING, MRY_E_INPUT (the session is read-only), MRY_E_IO, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_reset_parameter(
    context: *mut mry_context,
    session: mry_session,
    name: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| { call.choose(session, named(name)?, None) })
}

/// The value of a parameter in a session, chosen or by default.
///
/// @param context    The context.
/// @param session    The session.
/// @param name       The parameter's name.
/// @param out_value  As mry_session_set_parameter takes it.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (name), MRY_E_STRING, MRY_E_BUSY.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_session_get_parameter(
    context: *mut mry_context,
    session: mry_session,
    name: mry_str,
    out_value: *mut f64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let parameter = named(name)?;
        let out = Out::new(out_value, "out_value")?;
        call.session(session, |document| {
            let value = document.session.document().inputs.settings.get(parameter.name)?;
            out.set(number_out(parameter, &value));
            Ok(Code::MRY_OK)
        })
    })
}
