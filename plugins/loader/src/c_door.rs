//! The C door, from the host's side: calls through the tables of `plugin.h`.

use std::collections::BTreeMap;
use std::ffi::{CString, c_char, c_void};
use std::ptr::{self, NonNull};

use marey_plugin::raw;

use crate::brief::{Brief, RawBrief};
use crate::describe::{self, MAX_PLUGINS, PluginInfo};
use crate::door::{Door, DoorKind, Fault, FaultKind, Instance, MAX_STATE, MeshBrief, Opened};
use crate::post::Post;
use crate::refusal::Status;
use crate::values::Value;

/// Takes a library's log lines.
pub(crate) type LogLine = Box<dyn Fn(i32, &str) + Send + Sync>;

fn blank_error() -> raw::Error {
    raw::Error { struct_size: size_of::<raw::Error>() as u32, reserved0: 0, message: [0; 512] }
}

/// What a plugin wrote into its error.
fn said(error: &raw::Error) -> String {
    let bytes: Vec<u8> = error.message.iter().map(|c| *c as u8).take_while(|b| *b != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Calls a function that takes an error last.
fn call(function: impl FnOnce(*mut raw::Error) -> i32) -> Result<(), Fault> {
    let mut error = blank_error();
    match function(&mut error) {
        raw::OK => Ok(()),
        status => Err(Fault::of(status, said(&error))),
    }
}

/// A library behind its entry, which lives as long as the process: nothing is unloaded.
struct CDoor(&'static raw::Entry);

/// Opens the door: checks the entry's version, starts the library, reads what is inside.
///
/// # Safety
/// `entry` is what the library exports under the name of plugin.h's entry. `host` lives for ever.
pub(crate) unsafe fn open(entry: *const raw::Entry, host: &'static raw::Host) -> Result<Opened, (Status, String)> {
    if entry.is_null() || !entry.is_aligned() {
        return Err((Status::NoEntry, format!("its {} is no table", raw::ENTRY)));
    }
    // SAFETY: as this function's own: all tables start with these four numbers.
    let [size, major, minor, _] = unsafe { entry.cast::<[u32; 4]>().read() };
    if major != raw::ABI_MAJOR {
        let problem =
            format!("was made for version {major}.{minor} of the interface, and this host has {}", raw::ABI_MAJOR);
        return Err((Status::AbiVersion, problem));
    }
    if (size as usize) < size_of::<raw::Entry>() {
        let problem = format!("its entry has {size} bytes, and {} are expected", size_of::<raw::Entry>());
        return Err((Status::Layout, problem));
    }
    // SAFETY: as this function's own, and as large as was checked.
    let entry: &'static raw::Entry = unsafe { &*entry };
    let (Some(init), Some(get_count), Some(get_descriptor), Some(_)) =
        (entry.init, entry.get_count, entry.get_descriptor, entry.create)
    else {
        return Err((Status::Layout, "a function of its entry is NULL".to_owned()));
    };
    // SAFETY: plugin.h: called once, first, with a host that lives for ever. The others as plugin.h says.
    call(|error| unsafe { init(host, error) })
        .map_err(|fault| (Status::Init, format!("did not start: {}", fault.message)))?;
    // SAFETY: as above.
    let count = unsafe { get_count() };
    if count > MAX_PLUGINS {
        return Err((Status::Descriptor, format!("holds {count} plugins, and at most {MAX_PLUGINS} are allowed")));
    }
    // SAFETY: as above.
    let describe = |index| unsafe { describe::descriptor(get_descriptor(index), index) };
    let plugins: Result<Vec<PluginInfo>, String> = (0..count).map(describe).collect();
    let plugins = plugins.map_err(|problem| (Status::Descriptor, problem))?;
    Ok(Opened { door: Box::new(CDoor(entry)), kind: DoorKind::C, plugins })
}

impl Door for CDoor {
    fn create(&self, index: usize, values: &[(String, Value)]) -> Result<Box<dyn Instance>, Fault> {
        let Some(create) = self.0.create else { return Err(Fault::new(FaultKind::Absurd, "create is NULL")) };
        let c_text = |text: &str| CString::new(text).unwrap_or_default();
        let texts: Vec<(CString, Option<CString>)> = values
            .iter()
            .map(|(id, value)| (c_text(id), if let Value::Text(text) = value { Some(c_text(text)) } else { None }))
            .collect();
        let raw: Vec<raw::Value> = values
            .iter()
            .zip(&texts)
            .map(|((_, value), (id, text))| raw::Value {
                id: id.as_ptr(),
                number: if let Value::Number(n) = value { *n } else { 0.0 },
                text: text.as_ref().map_or(ptr::null(), |t| t.as_ptr()),
            })
            .collect();
        let mut made = ptr::null();
        // SAFETY: plugin.h: the values and their texts are valid during the call.
        call(|error| unsafe { create(index as u32, raw.as_ptr(), raw.len() as u32, &mut made, error) })?;
        let Some(made) = NonNull::new(made.cast_mut()) else {
            return Err(Fault::new(FaultKind::Absurd, "create gave no instance"));
        };
        // SAFETY: plugin.h: an instance starts with its size.
        let size = unsafe { made.cast::<u32>().read() } as usize;
        if size < size_of::<raw::Instance>() {
            // It cannot be destroyed: where its functions are is not known.
            let problem = format!("the instance has {size} bytes, and {} are expected", size_of::<raw::Instance>());
            return Err(Fault::new(FaultKind::Absurd, problem));
        }
        Ok(Box::new(CInstance { raw: made, bound: BTreeMap::new(), next: 0 }))
    }
}

struct CInstance {
    raw: NonNull<raw::Instance>,
    bound: BTreeMap<u64, *mut c_void>,
    next: u64,
}

// SAFETY: plugin.h: an instance may be called from any thread, one call at a time, and a Box has one owner.
unsafe impl Send for CInstance {}

fn missing(what: &str) -> Fault {
    Fault::new(FaultKind::Unsupported, format!("has no function `{what}`, though it is of that kind"))
}

impl CInstance {
    fn get(&self) -> &raw::Instance {
        // SAFETY: plugin.h: the instance is valid until its destroy is called, which `drop` does.
        unsafe { self.raw.as_ref() }
    }

    fn state(&self) -> Option<&'static raw::State1> {
        let get_extension = self.get().get_extension?;
        let id = CString::new(raw::STATE_1).ok()?;
        // SAFETY: plugin.h: answers NULL or the table of that name, which lives as the library does.
        let table = unsafe { get_extension(self.raw.as_ptr(), id.as_ptr()).cast::<raw::State1>() };
        if table.is_null() || !table.is_aligned() {
            return None;
        }
        // SAFETY: as above; a table starts with its size.
        let size = unsafe { table.cast::<u32>().read() } as usize;
        // SAFETY: as above, and as large as was checked.
        (size >= size_of::<raw::State1>()).then(|| unsafe { &*table })
    }
}

impl Instance for CInstance {
    fn track(&mut self, brief: &Brief, post: &Post) -> Result<(), Fault> {
        let track = self.get().track.ok_or_else(|| missing("track"))?;
        let (told, job) = (RawBrief::new(brief), post.job());
        // SAFETY: plugin.h: all of these are valid during the call. So for the calls below.
        call(|error| unsafe { track(self.raw.as_ptr(), &told.clip, &told.rig, &job, error) })
    }

    fn segment(&mut self, brief: &Brief, post: &Post) -> Result<(), Fault> {
        let segment = self.get().segment.ok_or_else(|| missing("segment"))?;
        let (told, job) = (RawBrief::new(brief), post.job());
        // SAFETY: as for `track`.
        call(|error| unsafe { segment(self.raw.as_ptr(), &told.clip, &told.rig, &told.motion, &job, error) })
    }

    fn bind(&mut self, mesh: &MeshBrief, handles: &[raw::Handle], post: &Post) -> Result<u64, Fault> {
        let bind = self.get().bind.ok_or_else(|| missing("bind"))?;
        let raw = raw::Mesh {
            struct_size: size_of::<raw::Mesh>() as u32,
            point_count: mesh.points.len() as u32,
            points: mesh.points.as_ptr(),
            triangles: mesh.triangles.as_ptr().cast(),
            triangle_count: mesh.triangles.len() as u32,
            reserved0: 0,
        };
        let (job, mut bound) = (post.job(), ptr::null_mut());
        let count = handles.len() as u32;
        // SAFETY: as for `track`.
        call(|error| unsafe { bind(self.raw.as_ptr(), &raw, handles.as_ptr(), count, &job, &mut bound, error) })?;
        self.next += 1;
        self.bound.insert(self.next, bound);
        Ok(self.next)
    }

    fn solve(
        &mut self,
        bound: u64,
        targets: &[raw::Handle],
        points: &mut [raw::Point],
        post: &Post,
    ) -> Result<(), Fault> {
        let solve = self.get().solve.ok_or_else(|| missing("solve"))?;
        let bound = *self.bound.get(&bound).ok_or_else(|| Fault::new(FaultKind::Absurd, "nothing of it is bound"))?;
        let (job, count, len) = (post.job(), targets.len() as u32, points.len() as u32);
        // SAFETY: as for `track`; `bound` came from its bind, and was not unbound.
        call(|error| unsafe {
            solve(self.raw.as_ptr(), bound, targets.as_ptr(), count, points.as_mut_ptr(), len, &job, error)
        })
    }

    fn unbind(&mut self, bound: u64) {
        if let (Some(bound), Some(unbind)) = (self.bound.remove(&bound), self.get().unbind) {
            // SAFETY: as for `solve`; it is forgotten here.
            unsafe { unbind(self.raw.as_ptr(), bound) };
        }
    }

    fn save(&mut self) -> Result<Option<Vec<u8>>, Fault> {
        let Some(save) = self.state().and_then(|table| table.save) else { return Ok(None) };
        let mut bytes: Vec<u8> = Vec::new();
        // Asked for the size first; what grows between two calls is asked again.
        for _ in 0..4 {
            let mut size = 0;
            let (to, room) = (bytes.as_mut_ptr(), bytes.len());
            let to = if room == 0 { ptr::null_mut() } else { to };
            // SAFETY: as for `track`; there is room for `room` bytes.
            call(|error| unsafe { save(self.raw.as_ptr(), to, room, &mut size, error) })?;
            if size > MAX_STATE {
                let problem = format!("its state has {size} bytes, and at most {MAX_STATE} are allowed");
                return Err(Fault::new(FaultKind::Absurd, problem));
            }
            if size <= room {
                bytes.truncate(size);
                return Ok(Some(bytes));
            }
            bytes = vec![0; size];
        }
        Err(Fault::new(FaultKind::Absurd, "its state is of another size each time"))
    }

    fn load(&mut self, version: u32, state: &[u8]) -> Result<(), Fault> {
        let load = self.state().and_then(|table| table.load);
        let load = load.ok_or_else(|| Fault::new(FaultKind::Unsupported, "keeps no state"))?;
        // SAFETY: as for `track`.
        call(|error| unsafe { load(self.raw.as_ptr(), version, state.as_ptr(), state.len(), error) })
    }
}

impl Drop for CInstance {
    fn drop(&mut self) {
        let bound: Vec<u64> = self.bound.keys().copied().collect();
        bound.into_iter().for_each(|b| self.unbind(b));
        if let Some(destroy) = self.get().destroy {
            // SAFETY: plugin.h: called once, after all else.
            unsafe { destroy(self.raw.as_ptr()) };
        }
    }
}

/// What a plugin knows of the host. One for each library, because each logs under its own name. It lives for ever.
pub(crate) fn host(log: LogLine) -> &'static raw::Host {
    unsafe extern "C" fn c_log(host: *const raw::Host, level: i32, message: *const c_char) {
        let _ = std::panic::catch_unwind(|| {
            if message.is_null() {
                return;
            }
            // SAFETY: plugin.h: the host that was given, whose data is what was leaked below, and a C string.
            unsafe {
                let Some(host) = host.as_ref() else { return };
                let log = &*host.data.cast::<LogLine>();
                let text = std::ffi::CStr::from_ptr(message).to_string_lossy();
                log(level, &text.chars().take(4096).collect::<String>());
            }
        });
    }
    unsafe extern "C" fn no_extension(_host: *const raw::Host, _id: *const c_char) -> *const c_void {
        ptr::null()
    }
    let data: &'static mut LogLine = Box::leak(Box::new(log));
    Box::leak(Box::new(raw::Host {
        struct_size: size_of::<raw::Host>() as u32,
        abi_major: raw::ABI_MAJOR,
        abi_minor: raw::ABI_MINOR,
        reserved0: 0,
        name: c"marey".as_ptr(),
        version: concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast(),
        data: ptr::from_mut(data).cast(),
        log: Some(c_log),
        get_extension: Some(no_extension),
    }))
}
