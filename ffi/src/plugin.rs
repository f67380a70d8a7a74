//! One plugin. What is loaded, what is not and why, and switching a plugin off. Plugins are counted by their ids; the
//! counting changes with mry_plugins_rescan and mry_plugins_load only.

use std::ffi::c_char;

use marey_plugin_loader::{DoorKind, Listed, PluginKind};

use crate::border::{self, Out, OutStruct, Text, Versioned};
use crate::context::mry_context;
use crate::error::{Failure, Outcome, copy_text, mry_error};
use crate::guard::{Call, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Kind of a plugin: it follows limbs.
pub const MRY_PLUGIN_KIND_TRACKER: i32 = 1;
/// Kind of a plugin: it cuts the creature out.
pub const MRY_PLUGIN_KIND_SEGMENTER: i32 = 2;
/// Kind of a plugin: it moves a mesh by handles.
pub const MRY_PLUGIN_KIND_DEFORMER: i32 = 3;

/// Door of a plugin: the table of plugin.h.
pub const MRY_PLUGIN_DOOR_C: i32 = 1;
/// Door of a plugin: the types that abi_stable checks.
pub const MRY_PLUGIN_DOOR_RUST: i32 = 2;

/// A plugin that is loaded.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_plugin_info {
    /// sizeof(mry_plugin_info).
    pub struct_size: u32,
    /// MRY_PLUGIN_KIND_TRACKER, ...; accept ones you do not know.
    pub kind: i32,
    /// MRY_PLUGIN_DOOR_C, ...; accept ones you do not know.
    pub door: i32,
    /// 0 when it is switched off, by the user or because it failed too often.
    pub enabled: u32,
    /// The number of its newest build, counted over all files.
    pub generation: u64,
    /// How many instances of it there are, of all builds.
    pub instance_count: u32,
    /// How many parameters mry_plugin_get_parameter has.
    pub parameter_count: u32,
    /// Its name for ever, such as "org.example.nearest"; NUL-terminated.
    pub id: [c_char; 128],
    /// What a person reads; NUL-terminated.
    pub name: [c_char; 96],
    /// Who made it; NUL-terminated, may be empty.
    pub vendor: [c_char; 96],
    /// Such as "1.2.0"; NUL-terminated.
    pub version: [c_char; 32],
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_plugin_info {
    const FIRST_SIZE: usize = 384;
}
const _: () = assert!(size_of::<mry_plugin_info>() == 384);

impl Call<'_> {
    fn nth_plugin(&self, index: u32) -> Outcome<Listed> {
        let mut plugins = self.context.plugins.registry()?.plugins();
        let index = index as usize;
        if index >= plugins.len() {
            let message = format!("there are {} plugins", plugins.len());
            return Err(Failure::new(Code::MRY_E_NOT_FOUND, "index", message));
        }
        Ok(plugins.swap_remove(index))
    }
}

/// Fills in a plugin info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_plugin_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_info_init(info: *mut mry_plugin_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// One of the plugins that are loaded.
///
/// @param context   The context.
/// @param index     Which, counted from 0.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there are no more), MRY_E_PLUGIN_NOT_FOUND (the context has no plugins),
///         MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_get_info(
    context: *mut mry_context,
    index: u32,
    out_info: *mut mry_plugin_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let plugin = call.nth_plugin(index)?;
        let mut info = mry_plugin_info {
            struct_size: 0,
            kind: match plugin.info.kind {
                PluginKind::Tracker => MRY_PLUGIN_KIND_TRACKER,
                PluginKind::Segmenter => MRY_PLUGIN_KIND_SEGMENTER,
                PluginKind::Deformer => MRY_PLUGIN_KIND_DEFORMER,
            },
            door: match plugin.door {
                DoorKind::C => MRY_PLUGIN_DOOR_C,
                DoorKind::Rust => MRY_PLUGIN_DOOR_RUST,
            },
            enabled: u32::from(plugin.disabled.is_none()),
            generation: plugin.generation,
            instance_count: plugin.instances as u32,
            parameter_count: plugin.info.parameters.len() as u32,
            id: [0; 128],
            name: [0; 96],
            vendor: [0; 96],
            version: [0; 32],
        };
        copy_text(&plugin.info.id, &mut info.id);
        copy_text(&plugin.info.name, &mut info.name);
        copy_text(&plugin.info.vendor, &mut info.vendor);
        copy_text(&plugin.info.version, &mut info.version);
        out.set(&info);
        Ok(Code::MRY_OK)
    })
}

/// What a plugin is good at, in its author's words.
///
/// @param context   The context.
/// @param index     Which, counted from 0.
/// @param text      Where the text goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (index), MRY_E_BUFFER_TOO_SMALL, MRY_E_PLUGIN_NOT_FOUND.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_get_about(
    context: *mut mry_context,
    index: u32,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        text.fill(&call.nth_plugin(index)?.info.about)
    })
}

/// The file that a plugin was loaded from.
///
/// @param context   The context.
/// @param index     Which, counted from 0.
/// @param text      Where the path goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity  Bytes at text.
/// @param out_size  Bytes needed, with the NUL.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (index), MRY_E_BUFFER_TOO_SMALL, MRY_E_PLUGIN_NOT_FOUND.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_get_file(
    context: *mut mry_context,
    index: u32,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let text = Text::new(text, capacity, out_size, "text")?;
        text.fill(&call.nth_plugin(index)?.file.to_string_lossy())
    })
}

/// One of the files whose newest build is not loaded: why, as a line that names the file, the problem and the remedy.
///
/// @param context     The context.
/// @param index       Which, counted from 0.
/// @param out_status  The reason, a status of the MRY_E_PLUGIN block.
/// @param text        Where the line goes, UTF-8 with a NUL; NULL with capacity 0 to ask for the size.
/// @param capacity    Bytes at text.
/// @param out_size    Bytes needed, with the NUL.
/// @param err         Detail of a failure of this call, or NULL.
/// @return MRY_OK; MRY_E_NOT_FOUND (there are no more), MRY_E_BUFFER_TOO_SMALL, MRY_E_PLUGIN_NOT_FOUND.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_get_failure(
    context: *mut mry_context,
    index: u32,
    out_status: *mut mry_status,
    text: *mut c_char,
    capacity: usize,
    out_size: *mut usize,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_status, "out_status")?;
        let text = Text::new(text, capacity, out_size, "text")?;
        let failures = call.context.plugins.registry()?.failures();
        let none = || Failure::new(Code::MRY_E_NOT_FOUND, "index", format!("there are {} failures", failures.len()));
        let (_, refusal) = failures.get(index as usize).ok_or_else(none)?;
        let filled = text.fill(&refusal.to_string())?;
        out.set(refusal.status as mry_status);
        Ok(filled)
    })
}

/// Switches a plugin off or on again, also one that was switched off because it hung. Jobs at work are not disturbed.
///
/// @param context  The context.
/// @param id       The plugin's id.
/// @param enabled  0 for off, 1 for on.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_PLUGIN_NOT_FOUND (id), MRY_E_ARGUMENT, MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_plugin_set_enabled(
    context: *mut mry_context,
    id: mry_str,
    enabled: u32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let id = id.name("id")?;
        if enabled > 1 {
            return Err(Failure::argument("enabled", format!("enabled is {enabled}, and 0 or 1 is allowed")));
        }
        let registry = call.context.plugins.registry()?;
        registry.set_enabled(id, enabled == 1).map_err(|e| Failure::from(e).about("id"))?;
        Ok(Code::MRY_OK)
    })
}
