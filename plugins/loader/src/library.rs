//! A private copy mapped into the process, for ever, and the door that it exports.

use std::mem::ManuallyDrop;
use std::path::Path;

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
use marey_plugin::raw;

use crate::c_door::{self, LogLine};
use crate::describe;
use crate::door::{DoorKind, Opened};
use crate::refusal::{Refusal, Status};
use crate::rust_door;
use crate::values::{self, Chosen};

/// Maps `copy` and opens its door: the one that is asked for, or else the C door where there is one. `file` is what a
/// person knows it by.
pub(crate) fn open(copy: &Path, file: &Path, door: Option<DoorKind>, log: LogLine) -> Result<Opened, Refusal> {
    // RTLD_NOW: a function that is missing is found out here, not when it is called, which would end the process.
    // SAFETY: the library's constructors run, which nobody can vouch for; that is the loader's honest limit.
    let library = unsafe { Library::open(Some(copy), RTLD_NOW | RTLD_LOCAL) }.map_err(|e| refused(copy, file, &e))?;
    // Never unmapped: threads, destructors and pointers of the library may outlive whoever knows of it.
    let library = ManuallyDrop::new(library);
    // SAFETY: the symbol is the table of plugin.h, or nothing of ours; it is only looked at through `c_door::open`.
    let entry = unsafe { library.get::<*const raw::Entry>(raw::ENTRY.as_bytes()) }.map(|symbol| symbol.into_raw());
    let refuse = |(status, problem): (Status, String)| {
        let remedy = match status {
            Status::AbiVersion | Status::Layout => "build it anew with this host's plugin.h or sdk",
            Status::Init => "see what it needs, or tell its author",
            _ => "tell its author",
        };
        Refusal::file(status, file, problem, remedy)
    };
    let opened = match entry {
        // SAFETY: what the library exports under that name; the host is leaked.
        Ok(entry) if door != Some(DoorKind::Rust) => {
            unsafe { c_door::open(entry.cast_const().cast(), c_door::host(log)) }.map_err(refuse)?
        }
        _ => {
            // SAFETY: the symbol is abi_stable's header, or nothing of ours; it is only looked at through `open`.
            let header = unsafe { library.get::<*const std::ffi::c_void>(marey_plugin_abi::SYMBOL.as_bytes()) };
            let remedy = "a plugin exports mry_plugin_entry_v1 (plugin.h) or is made by marey_plugin! (sdk)";
            let none = |_| Refusal::file(Status::NoEntry, file, "exports no plugin", remedy);
            let header = if door == Some(DoorKind::C) { Err(()) } else { header.map_err(drop) }.map_err(none)?;
            // SAFETY: what the library exports under that name; it is never unloaded.
            unsafe { rust_door::open(header.into_raw().cast_const().cast(), log) }.map_err(refuse)?
        }
    };
    describe::check(&opened.plugins).map_err(|problem| refuse((Status::Descriptor, problem)))?;
    Ok(opened)
}

fn refused(copy: &Path, file: &Path, error: &libloading::Error) -> Refusal {
    let mut said = error.to_string();
    if let libloading::Error::DlOpen { .. } = error
        && let Some(source) = std::error::Error::source(error)
    {
        said = source.to_string();
    }
    let said = said.replace(&*copy.to_string_lossy(), "it");
    if said.contains("failed to map segment") {
        let remedy = "choose a cache folder on a disk that is not mounted noexec";
        let folder = copy.parent().unwrap_or(copy);
        return Refusal::file(Status::Copy, folder, "files in it may not be run", remedy);
    }
    let missing = said.contains("undefined symbol") || said.contains("cannot open shared object file");
    let remedy = if missing {
        "install what it needs, or tell its author"
    } else {
        "get it again, or build it for this machine"
    };
    Refusal::file(Status::Dlopen, file, format!("cannot be loaded: {said}"), remedy)
}

/// Makes and drops one instance of each plugin, with its defaults.
pub(crate) fn smoke(opened: &Opened, file: &Path) -> Result<(), Refusal> {
    for (index, plugin) in opened.plugins.iter().enumerate() {
        let values = values::complete(plugin, &Chosen::new());
        if let Err(fault) = opened.door.create(index, &values) {
            let panicked = fault.kind == crate::door::FaultKind::Panicked;
            let status = if panicked { Status::Panicked } else { Status::Init };
            let problem = format!("plugin {} cannot be made with its defaults: {}", plugin.id, fault.message);
            return Err(Refusal::file(status, file, problem, "see what it needs, or tell its author"));
        }
    }
    Ok(())
}
