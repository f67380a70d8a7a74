//! Parameters of plugins. What can be chosen about a plugin, as a table with bounds that a host can show without knowing
//! any of them. Values live in the context: an instance of a new build is made from them.

use std::ffi::c_char;

use marey_plugin_loader::{ParameterInfo, ParameterKind, PluginInfo, Value};

use crate::border::{self, Out, OutStruct, Text, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, copy_text, mry_error};
use crate::guard::{Call, entry};
use crate::parameter::{
    MRY_PARAMETER_CHOICE, MRY_PARAMETER_NUMBER, MRY_PARAMETER_SWITCH, MRY_PARAMETER_TEXT, MRY_PARAMETER_WHOLE,
};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Kind of a parameter: the path of a file.
pub const MRY_PARAMETER_FILE: i32 = 5;

/// A parameter for those who know the method; a host may fold it away.
pub const MRY_PARAMETER_ADVANCED: u32 = 1;
/// A parameter that is not to be shown.
pub const MRY_PARAMETER_HIDDEN: u32 = 2;
/// A parameter whose slider does better with the logarithm.
pub const MRY_PARAMETER_LOGARITHMIC: u32 = 4;

/// What a parameter of a plugin is. All texts are NUL-terminated.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_plugin_parameter_info {
    /// sizeof(mry_plugin_parameter_info).
    pub struct_size: u32,
    /// MRY_PARAMETER_NUMBER, ...; accept ones you do not know.
    pub kind: i32,
    /// The least value.
    pub low: f64,
    /// The greatest value.
    pub high: f64,
    /// The value where none is chosen.
    pub default_value: f64,
    /// One step of a slider; 0 for none.
    pub step: f64,
    /// The value of the parameter visible_if for which this one is shown.
    pub visible_value: f64,
    /// How many names mry_plugin_get_parameter_choice has.
    pub choice_count: u32,
    /// MRY_PARAMETER_ADVANCED, ...
    pub flags: u32,
    /// Its name for ever.
    pub id: [c_char; 48],
    /// The id of the parameter that decides whether this one is shown; empty for always.
    pub visible_if: [c_char; 48],
    /// What a person reads beside the control.
    pub label: [c_char; 64],
    /// Where it stands among others, "Search/Fine"; may be empty.
    pub group: [c_char; 64],
    /// "px", "frames"; may be empty.
    pub unit: [c_char; 16],
    /// What it does, a sentence; may be empty.
    pub about: [c_char; 264],
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_plugin_parameter_info {
    const FIRST_SIZE: usize = 560;
}
const _: () = assert!(size_of::<mry_plugin_parameter_info>() == 560);

impl Call<'_> {
    /// # Safety
    /// The string is valid, as the header asks.
    unsafe fn plugin(&self, id: mry_str) -> Outcome<PluginInfo> {
        // SAFETY: as this function's own.
        let id = unsafe { id.name("id")? };
        let plugins = self.context.plugins.registry()?.plugins();
        let none = || Failure::new(Code::MRY_E_PLUGIN_NOT_FOUND, "id", format!("plugin {id} is not loaded"));
        plugins.into_iter().find(|p| p.info.id == id).map(|p| p.info).ok_or_else(none)
    }

    /// # Safety
    /// The strings are valid, as the header asks.
    unsafe fn choose_for_plugin(&self, id: mry_str, name: mry_str, value: Value) -> Outcome<Code> {
        // SAFETY: as this function's own.
        let (id, name) = unsafe { (id.name("id")?, name.name("name")?) };
        self.context.plugins.registry()?.choose(id, name, value).map_err(|e| about_parameter(&e))?;
        Ok(Code::MRY_OK)
    }
}

/// A value that a parameter does not take is the host's mistake, not the plugin's.
fn about_parameter(refusal: &marey_plugin_loader::Refusal) -> Failure {
    let not_found = refusal.status as i32 == Code::MRY_E_PLUGIN_NOT_FOUND as i32;
    let of_parameter = refusal.what.starts_with("parameter");
    let message = refusal.to_string();
    match (not_found, of_parameter) {
        (true, true) => Failure::new(Code::MRY_E_NOT_FOUND, "name", message),
        (true, false) => Failure::new(Code::MRY_E_PLUGIN_NOT_FOUND, "id", message),
        (false, _) => Failure::argument("value", message),
    }
}

fn nth(plugin: &PluginInfo, index: u32) -> Outcome<&ParameterInfo> {
    let count = plugin.parameters.len();
    let none = || Failure::new(Code::MRY_E_NOT_FOUND, "index", format!("{} has {count} parameters", plugin.id));
    plugin.parameters.get(index as usize).ok_or_else(none)
}

/// Fills in a parameter info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_plugin_parameter_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_parameter_info_init(info: *mut mry_plugin_parameter_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// One of the parameters of a plugin, in the order in which to show them.
///
/// @param context   The context.
/// @param id        The plugin's id.
/// @param index     Which, counted from 0.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there are no more), MRY_E_PLUGIN_NOT_FOUND (id), MRY_E_STRUCT_SIZE, MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_get_parameter(
    context: *mut mry_context,
    id: mry_str,
    index: u32,
    out_info: *mut mry_plugin_parameter_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let plugin = call.plugin(id)?;
        let parameter = nth(&plugin, index)?;
        let (visible_if, visible_value) = parameter.visible_if.clone().unwrap_or_default();
        let mut info = mry_plugin_parameter_info {
            struct_size: 0,
            kind: match parameter.kind {
                ParameterKind::Number => MRY_PARAMETER_NUMBER,
                ParameterKind::Whole => MRY_PARAMETER_WHOLE,
                ParameterKind::Switch => MRY_PARAMETER_SWITCH,
                ParameterKind::Choice => MRY_PARAMETER_CHOICE,
                ParameterKind::Text => MRY_PARAMETER_TEXT,
                ParameterKind::File => MRY_PARAMETER_FILE,
            },
            low: parameter.low,
            high: parameter.high,
            default_value: parameter.default,
            step: parameter.step,
            visible_value,
            choice_count: parameter.choices.len() as u32,
            flags: parameter.flags,
            id: [0; 48],
            visible_if: [0; 48],
            label: [0; 64],
            group: [0; 64],
            unit: [0; 16],
            about: [0; 264],
        };
        copy_text(&parameter.id, &mut info.id);
        copy_text(&visible_if, &mut info.visible_if);
        copy_text(&parameter.label, &mut info.label);
        copy_text(&parameter.group, &mut info.group);
        copy_text(&parameter.unit, &mut info.unit);
        copy_text(&parameter.about, &mut info.about);
        out.set(&info);
        Ok(Code::MRY_OK)
    })
}

/// The name of one of the values of a choice.
///
/// @param context   The context.
/// @param id        The plugin's id.
/// @param index     Which parameter.
/// @param choice    Which value, below choice_count.
/// @param text      Where the name goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (index, choice), MRY_E_PLUGIN_NOT_FOUND (id), MRY_E_BUFFER_TOO_SMALL, MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_get_parameter_choice(
    context: *mut mry_context,
    id: mry_str,
    index: u32,
    choice: u32,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let plugin = call.plugin(id)?;
        let names = &nth(&plugin, index)?.choices;
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "choice", format!("there are {} choices", names.len()));
        text.fill(names.get(choice as usize).ok_or_else(none)?)
    })
}

/// Chooses the value of a parameter for instances that are made from now on; one at work is made anew for its next job.
///
/// @param context  The context.
/// @param id       The plugin's id.
/// @param name     The parameter's id.
/// @param value    From low to high; 0 or 1 for a switch, an index for a choice.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (name), MRY_E_PLUGIN_NOT_FOUND (id), MRY_E_ARGUMENT (value), MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_set_number(
    context: *mut mry_context,
    id: mry_str,
    name: mry_str,
    value: f64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| { call.choose_for_plugin(id, name, Value::Number(value)) })
}

/// Chooses the text or the path of a parameter, as mry_plugin_set_number does a number.
///
/// @param context  The context.
/// @param id       The plugin's id.
/// @param name     The parameter's id.
/// @param value    The text, up to 4096 bytes.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (name), MRY_E_PLUGIN_NOT_FOUND (id), MRY_E_ARGUMENT (value), MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_set_text(
    context: *mut mry_context,
    id: mry_str,
    name: mry_str,
    value: mry_str,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let value = value.text("value")?;
        call.choose_for_plugin(id, name, Value::Text(value.to_owned()))
    })
}

/// The value of a parameter, chosen or by default.
///
/// @param context    The context.
/// @param id         The plugin's id.
/// @param name       The parameter's id.
/// @param out_value  As mry_plugin_set_number takes it.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (name), MRY_E_PLUGIN_NOT_FOUND (id), MRY_E_KIND (it is a text), MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_get_number(
    context: *mut mry_context,
    id: mry_str,
    name: mry_str,
    out_value: *mut f64,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_value, "out_value")?;
        let (id, name) = (id.name("id")?, name.name("name")?);
        match call.context.plugins.registry()?.value(id, name).map_err(|e| about_parameter(&e))? {
            Value::Number(number) => out.set(number),
            Value::Text(_) => return Err(Failure::new(Code::MRY_E_KIND, "name", format!("`{name}` is a text"))),
        }
        Ok(Code::MRY_OK)
    })
}

/// The text of a parameter, chosen or by default.
///
/// @param context   The context.
/// @param id        The plugin's id.
/// @param name      The parameter's id.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (name), MRY_E_PLUGIN_NOT_FOUND (id), MRY_E_KIND (it is a number),
///         MRY_E_BUFFER_TOO_SMALL, MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_get_text(
    context: *mut mry_context,
    id: mry_str,
    name: mry_str,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        let (id, name) = (id.name("id")?, name.name("name")?);
        match call.context.plugins.registry()?.value(id, name).map_err(|e| about_parameter(&e))? {
            Value::Text(value) => text.fill(&value),
            Value::Number(_) => Err(Failure::new(Code::MRY_E_KIND, "name", format!("`{name}` is a number"))),
        }
    })
}
