//! The plugin part of the C ABI as safe functions.

use std::ptr;

use marey_ffi::*;

use super::{Handle, check, sized_text, str};
use crate::error::Result;
use crate::plugin::PluginOptions;

pub(crate) fn plugins_open(handle: &Handle, options: &PluginOptions<'_>) -> Result<()> {
    let mut desc = sized!(mry_plugins_desc_init, mry_plugins_desc);
    let folders = options.folders.join("\n");
    desc.flags = if options.environment { MRY_PLUGINS_ENVIRONMENT } else { 0 };
    (desc.folders, desc.cache, desc.probe) = (str(&folders), str(options.cache), str(options.probe));
    call!(mry_plugins_open(handle, ptr::from_ref(&desc))).map(drop)
}

pub(crate) fn plugins_rescan(handle: &Handle) -> Result<u32> {
    let mut changes = 0;
    call!(mry_plugins_rescan(handle, &mut changes))?;
    Ok(changes)
}

pub(crate) fn plugins_load(handle: &Handle, file: &str) -> Result<()> {
    call!(mry_plugins_load(handle, str(file))).map(drop)
}

pub(crate) fn plugins_retry(handle: &Handle, file: &str) -> Result<()> {
    call!(mry_plugins_retry(handle, str(file))).map(drop)
}

/// Room for any report or answer: asking for the size first would run everything twice.
const ROOM: usize = 1 << 20;

/// A text that is not cheap to make.
fn long_text(mut read: impl FnMut(*mut std::ffi::c_char, usize, &mut usize) -> Result<mry_status>) -> Result<String> {
    let (mut bytes, mut size) = (vec![0; ROOM], 0);
    read(bytes.as_mut_ptr(), bytes.len(), &mut size)?;
    Ok(super::text(&bytes))
}

pub(crate) fn plugins_check(handle: &Handle, file: &str) -> Result<String> {
    long_text(|text, capacity, size| call!(mry_plugins_check(handle, str(file), text, capacity, size)))
}

pub(crate) fn plugins_probe(handle: &Handle, mode: &str, file: &str) -> Result<String> {
    long_text(|text, capacity, size| call!(mry_plugins_probe(handle, str(mode), str(file), text, capacity, size)))
}

pub(crate) fn plugin_info(handle: &Handle, index: u32) -> Result<mry_plugin_info> {
    let mut info = sized!(mry_plugin_info_init, mry_plugin_info);
    call!(mry_plugin_get_info(handle, index, &mut info))?;
    Ok(info)
}

pub(crate) fn plugin_about(handle: &Handle, index: u32) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_plugin_get_about(handle, index, text, capacity, size)))
}

pub(crate) fn plugin_file(handle: &Handle, index: u32) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_plugin_get_file(handle, index, text, capacity, size)))
}

pub(crate) fn plugin_failure(handle: &Handle, index: u32) -> Result<(mry_status, String)> {
    let mut status = 0;
    let line = sized_text(|text, capacity, size| {
        call!(mry_plugin_get_failure(handle, index, &mut status, text, capacity, size))
    })?;
    Ok((status, line))
}

pub(crate) fn plugin_set_enabled(handle: &Handle, id: &str, enabled: bool) -> Result<()> {
    call!(mry_plugin_set_enabled(handle, str(id), u32::from(enabled))).map(drop)
}

pub(crate) fn plugin_parameter(handle: &Handle, id: &str, index: u32) -> Result<mry_plugin_parameter_info> {
    let mut info = sized!(mry_plugin_parameter_info_init, mry_plugin_parameter_info);
    call!(mry_plugin_get_parameter(handle, str(id), index, &mut info))?;
    Ok(info)
}

pub(crate) fn plugin_choice(handle: &Handle, id: &str, index: u32, choice: u32) -> Result<String> {
    sized_text(|text, capacity, size| {
        call!(mry_plugin_get_parameter_choice(handle, str(id), index, choice, text, capacity, size))
    })
}

pub(crate) fn plugin_set_number(handle: &Handle, id: &str, name: &str, value: f64) -> Result<()> {
    call!(mry_plugin_set_number(handle, str(id), str(name), value)).map(drop)
}

pub(crate) fn plugin_set_text(handle: &Handle, id: &str, name: &str, value: &str) -> Result<()> {
    call!(mry_plugin_set_text(handle, str(id), str(name), str(value))).map(drop)
}

pub(crate) fn plugin_number(handle: &Handle, id: &str, name: &str) -> Result<f64> {
    let mut value = 0.0;
    call!(mry_plugin_get_number(handle, str(id), str(name), &mut value))?;
    Ok(value)
}

pub(crate) fn plugin_text(handle: &Handle, id: &str, name: &str) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_plugin_get_text(handle, str(id), str(name), text, capacity, size)))
}
