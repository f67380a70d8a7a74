//! The C door: the functions behind `mry_plugin_entry_v1`. They give the work to the guarded object, and turn what
//! comes of it into a status and words.

use std::ffi::{c_char, c_void};
use std::ptr;
use std::sync::{Mutex, TryLockError};

use crate::c_input::{get, handles, motion, null, slice, text, work};
use crate::error::{Error, ErrorKind, Result};
use crate::export::Bundle;
use crate::guard::{self, Guard};
use crate::log;
use crate::mesh::Mesh;
use crate::point::Point;
use crate::raw;
use crate::room::{Host, Object};
use crate::traits::Deformation;
use crate::values::{Given, Values};

/// The entry of a library.
pub const fn entry<B: Bundle>() -> raw::Entry {
    raw::Entry {
        struct_size: size_of::<raw::Entry>() as u32,
        abi_major: raw::ABI_MAJOR,
        abi_minor: raw::ABI_MINOR,
        reserved0: 0,
        init: Some(init),
        get_count: Some(get_count::<B>),
        get_descriptor: Some(get_descriptor::<B>),
        create: Some(create::<B>),
    }
}

// What goes out ------------------------------------------------------------------------------------------------------

/// Runs an entry: panics contained, the error written down.
///
/// # Safety
/// `error` is null or points at one.
unsafe fn run(error: *mut raw::Error, body: impl FnOnce() -> Result<()>) -> i32 {
    let Err(failure) = guard::contain(body) else { return raw::OK };
    // SAFETY: as this function's own.
    if let Some(error) = unsafe { error.as_mut() } {
        let room = error.message.len() - 1;
        let text = failure.message();
        let end = text.floor_char_boundary(room.min(text.len()));
        for (to, byte) in error.message.iter_mut().zip(&text.as_bytes()[..end]) {
            *to = if *byte == 0 { b' ' as c_char } else { *byte as c_char };
        }
        error.message[end] = 0;
    }
    match failure.kind() {
        ErrorKind::Cancelled => raw::CANCELLED,
        ErrorKind::Invalid => raw::E_INVALID,
        ErrorKind::Failed => raw::E_FAILED,
        ErrorKind::Unsupported => raw::E_UNSUPPORTED,
        ErrorKind::Panicked => raw::E_PANICKED,
        ErrorKind::Poisoned => raw::E_POISONED,
    }
}

/// The host's job, as C offers it.
struct CHost<'a>(&'a raw::Job);

// SAFETY: plugin.h lets every function of a job be called from any thread.
unsafe impl Sync for CHost<'_> {}

/// What an answer of the host means.
fn answer(status: i32, what: impl FnOnce() -> String) -> Result<()> {
    match status {
        raw::OK => Ok(()),
        raw::CANCELLED => Err(Error::cancelled()),
        raw::E_INVALID => Err(Error::invalid(what())),
        _ => Err(Error::failed(what())),
    }
}

impl Host for CHost<'_> {
    fn progress(&self, fraction: f64, stage: Option<&str>) -> bool {
        let Some(progress) = self.0.progress else { return true };
        // Long enough for a word or two, and nothing is allocated for it.
        let mut name = [0u8; 64];
        let name = stage.map_or(ptr::null(), |stage| {
            let end = stage.floor_char_boundary((name.len() - 1).min(stage.len()));
            name[..end].copy_from_slice(&stage.as_bytes()[..end]);
            name.as_ptr().cast()
        });
        // SAFETY: the host's own function and job; the name is NUL-terminated.
        let answer = unsafe { progress(self.0, fraction, name) };
        answer != raw::CANCEL
    }

    fn frame(&self, index: u64) -> Result<raw::Frame> {
        let mut frame = raw::Frame {
            struct_size: size_of::<raw::Frame>() as u32,
            width: 0,
            height: 0,
            stride_bytes: 0,
            pixels: ptr::null(),
            token: ptr::null_mut(),
        };
        let get = self.0.get_frame.ok_or_else(|| null("get_frame"))?;
        // SAFETY: the host's own function and job.
        let status = unsafe { get(self.0, index, &mut frame) };
        answer(status, || format!("the host has no frame {index}, or it is damaged"))?;
        Ok(frame)
    }

    fn release(&self, frame: &mut raw::Frame) {
        if let Some(release) = self.0.release_frame {
            // SAFETY: the host's own function and job, and a frame that came from `frame`.
            unsafe { release(self.0, frame) };
        }
    }

    fn put_stroke(&self, limb: u32, frame: u64, points: &[Point], visible: &[u8], confidence: &[f32]) -> Result<()> {
        let put = self.0.put_stroke.ok_or_else(|| null("put_stroke"))?;
        let count = points.len().min(visible.len()).min(confidence.len()) as u32;
        let (points, visible, confidence) = (points.as_ptr(), visible.as_ptr(), confidence.as_ptr());
        // SAFETY: the host's own function and job; each list has at least `count` entries.
        let status = unsafe { put(self.0, limb, frame, points, visible, confidence, count) };
        answer(status, || format!("the host does not take limb {limb} on frame {frame} as it is"))
    }

    fn put_mask(&self, frame: u64, pixels: &[u8], width: u32, height: u32, stride: usize) -> Result<()> {
        let put = self.0.put_mask.ok_or_else(|| null("put_mask"))?;
        // SAFETY: the host's own function and job; the pixels hold all rows, which the caller saw to.
        let status = unsafe { put(self.0, frame, pixels.as_ptr(), width, height, stride) };
        answer(status, || format!("the host does not take the mask of frame {frame} as it is"))
    }
}

// The library --------------------------------------------------------------------------------------------------------

/// A host's log may be called from any thread, for ever (plugin.h).
struct LogTo(*const raw::Host);
// SAFETY: see the type.
unsafe impl Send for LogTo {}
// SAFETY: see the type.
unsafe impl Sync for LogTo {}

impl LogTo {
    fn line(&self, level: i32, line: &str) {
        let bytes: Vec<u8> = line.bytes().filter(|b| *b != 0).chain([0]).collect();
        // SAFETY: the host lives as long as the library; the line is NUL-terminated.
        unsafe {
            if let Some(log) = (*self.0).log {
                log(self.0, level, bytes.as_ptr().cast());
            }
        }
    }
}

unsafe extern "C" fn init(host: *const raw::Host, error: *mut raw::Error) -> i32 {
    let body = || {
        // SAFETY: plugin.h: the host is valid for as long as the library is loaded.
        let host = unsafe { get(host, "host")? };
        if host.abi_major != raw::ABI_MAJOR {
            return Err(Error::unsupported(format!("made for major version {}", raw::ABI_MAJOR)));
        }
        let to = LogTo(host);
        log::set(Box::new(move |level, line| to.line(level, line)));
        guard::listen();
        Ok(())
    };
    // SAFETY: plugin.h: the error is NULL or valid.
    unsafe { run(error, body) }
}

unsafe extern "C" fn get_count<B: Bundle>() -> u32 {
    B::state().registrations.len() as u32
}

unsafe extern "C" fn get_descriptor<B: Bundle>(index: u32) -> *const raw::Descriptor {
    let found = guard::contain(|| {
        let descriptor = B::state().descriptors().0.get(index as usize);
        Ok(descriptor.map_or(ptr::null(), ptr::from_ref))
    });
    found.unwrap_or(ptr::null())
}

unsafe extern "C" fn create<B: Bundle>(
    index: u32,
    values: *const raw::Value,
    value_count: u32,
    out_instance: *mut *const raw::Instance,
    error: *mut raw::Error,
) -> i32 {
    let body = || {
        let none = || Error::invalid(format!("there is no plugin {index}"));
        let registration = B::state().registrations.get(index as usize).ok_or_else(none)?;
        if out_instance.is_null() {
            return Err(null("out_instance"));
        }
        // SAFETY: plugin.h: the values and their strings are valid during the call.
        let values = unsafe { slice(values, value_count as usize, "values")? };
        let given = values.iter().map(|v| {
            // SAFETY: as above.
            let text = unsafe { if v.text.is_null() { None } else { Some(text(v.text, "text")?) } };
            // SAFETY: as above.
            Ok(Given { id: unsafe { crate::c_input::text(v.id, "id")? }, number: v.number, text })
        });
        let values = Values::checked(registration.parameters, given.collect::<Result<_>>()?)?;
        let object = (registration.create)(&values)?;
        let of = |kind| registration.kind == kind;
        let raw = raw::Instance {
            struct_size: size_of::<raw::Instance>() as u32,
            reserved0: 0,
            data: ptr::null_mut(),
            destroy: Some(destroy),
            track: of(raw::TRACKER).then_some(track as _),
            segment: of(raw::SEGMENTER).then_some(segment as _),
            bind: of(raw::DEFORMER).then_some(bind as _),
            solve: of(raw::DEFORMER).then_some(solve as _),
            unbind: of(raw::DEFORMER).then_some(unbind as _),
            get_extension: Some(get_extension),
        };
        let held = Box::into_raw(Box::new(Held { raw, object: Mutex::new(Guard::new(object)) }));
        // SAFETY: not null, and a pointer may be written there, as plugin.h says.
        unsafe { out_instance.write(held.cast()) };
        Ok(())
    };
    // SAFETY: plugin.h: the error is NULL or valid.
    unsafe { run(error, body) }
}

// Instances ----------------------------------------------------------------------------------------------------------

/// An instance as the host sees it, with what it does not see behind.
#[repr(C)]
struct Held {
    raw: raw::Instance,
    object: Mutex<Guard<Box<dyn Object>>>,
}

/// Gives an instance work.
///
/// # Safety
/// `instance` came from [`create`] and was not destroyed; `error` is null or valid.
unsafe fn on(
    instance: *const raw::Instance,
    error: *mut raw::Error,
    body: impl FnOnce(&mut dyn Object) -> Result<()>,
) -> i32 {
    let body = || {
        // SAFETY: as this function's own; an instance is the first field of what holds it.
        let held = unsafe { get(instance.cast::<Held>(), "instance")? };
        let mut object = match held.object.try_lock() {
            Ok(object) => object,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => {
                return Err(Error::failed("the host calls an instance on two threads at a time"));
            }
        };
        object.call(|object| body(&mut **object))
    };
    // SAFETY: as this function's own.
    unsafe { run(error, body) }
}

unsafe extern "C" fn destroy(instance: *const raw::Instance) {
    if !instance.is_null() {
        // SAFETY: made by `create`, and destroyed once, as plugin.h says.
        drop(unsafe { Box::from_raw(instance.cast_mut().cast::<Held>()) });
    }
}

unsafe extern "C" fn track(
    instance: *const raw::Instance,
    clip: *const raw::Clip,
    rig: *const raw::Rig,
    job: *const raw::Job,
    error: *mut raw::Error,
) -> i32 {
    // SAFETY: plugin.h: all of these are valid during the call. So for the functions below.
    unsafe {
        on(instance, error, |object| {
            let host = CHost(get(job, "job")?);
            object.track(&work(&host, clip, rig)?, &host)
        })
    }
}

unsafe extern "C" fn segment(
    instance: *const raw::Instance,
    clip: *const raw::Clip,
    rig: *const raw::Rig,
    tracked: *const raw::Motion,
    job: *const raw::Job,
    error: *mut raw::Error,
) -> i32 {
    // SAFETY: as for `track`.
    unsafe {
        on(instance, error, |object| {
            let host = CHost(get(job, "job")?);
            let work = work(&host, clip, rig)?;
            object.segment(&work, &motion(tracked, work.clip.frames())?, &host)
        })
    }
}

type Bound = Guard<Box<dyn Deformation>>;

unsafe extern "C" fn bind(
    instance: *const raw::Instance,
    mesh: *const raw::Mesh,
    rest: *const raw::Handle,
    handle_count: u32,
    job: *const raw::Job,
    out_bound: *mut *mut c_void,
    error: *mut raw::Error,
) -> i32 {
    // SAFETY: as for `track`.
    unsafe {
        on(instance, error, |object| {
            let host = CHost(get(job, "job")?);
            let mesh = get(mesh, "mesh")?;
            let mesh = Mesh {
                points: slice(mesh.points, mesh.point_count as usize, "points")?,
                triangles: slice(mesh.triangles.cast(), mesh.triangle_count as usize, "triangles")?,
            };
            if out_bound.is_null() {
                return Err(null("out_bound"));
            }
            let bound = object.bind(&mesh, &handles(rest, handle_count)?, &host)?;
            out_bound.write(Box::into_raw(Box::new(Bound::new(bound))).cast());
            Ok(())
        })
    }
}

unsafe extern "C" fn solve(
    instance: *const raw::Instance,
    bound: *mut c_void,
    targets: *const raw::Handle,
    target_count: u32,
    points: *mut Point,
    point_count: u32,
    job: *const raw::Job,
    error: *mut raw::Error,
) -> i32 {
    // SAFETY: as for `track`; plugin.h: one call at a time for an instance, so nobody else has what is bound.
    unsafe {
        on(instance, error, |_| {
            let host = CHost(get(job, "job")?);
            let bound = bound.cast::<Bound>().as_mut().ok_or_else(|| null("bound"))?;
            let targets = handles(targets, target_count)?;
            let points = match point_count {
                0 => &mut [],
                _ if points.is_null() => return Err(null("points")),
                count => std::slice::from_raw_parts_mut(points, count as usize),
            };
            bound.call(|bound| bound.solve(&targets, points, &crate::job::Job::new(&host)))
        })
    }
}

unsafe extern "C" fn unbind(_instance: *const raw::Instance, bound: *mut c_void) {
    if !bound.is_null() {
        // SAFETY: made by `bind`, and unbound once, as plugin.h says.
        drop(unsafe { Box::from_raw(bound.cast::<Bound>()) });
    }
}

static STATE_1: raw::State1 =
    raw::State1 { struct_size: size_of::<raw::State1>() as u32, reserved0: 0, save: Some(save), load: Some(load) };

unsafe extern "C" fn get_extension(_instance: *const raw::Instance, id: *const c_char) -> *const c_void {
    // SAFETY: plugin.h: a string, valid during the call.
    match unsafe { text(id, "id") } {
        Ok(raw::STATE_1) => ptr::from_ref(&STATE_1).cast(),
        _ => ptr::null(),
    }
}

unsafe extern "C" fn save(
    instance: *const raw::Instance,
    bytes: *mut u8,
    capacity: usize,
    out_size: *mut usize,
    error: *mut raw::Error,
) -> i32 {
    // SAFETY: as for `track`.
    unsafe {
        on(instance, error, |object| {
            let state = object.save()?;
            if out_size.is_null() {
                return Err(null("out_size"));
            }
            out_size.write(state.len());
            if state.len() <= capacity && !bytes.is_null() {
                bytes.copy_from_nonoverlapping(state.as_ptr(), state.len());
            }
            Ok(())
        })
    }
}

unsafe extern "C" fn load(
    instance: *const raw::Instance,
    state_version: u32,
    bytes: *const u8,
    size: usize,
    error: *mut raw::Error,
) -> i32 {
    // SAFETY: as for `track`.
    unsafe { on(instance, error, |object| object.load(state_version, slice(bytes, size, "bytes")?)) }
}
