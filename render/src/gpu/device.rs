//! Finding an adapter and opening a device on it.

use std::future::Future;
use std::pin::pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};

use marey::{Error, Result};
use wgpu::{
    Adapter, Backends, Device, DeviceDescriptor, DeviceType, DownlevelFlags, Instance, InstanceDescriptor,
    InstanceFlags, Limits, PowerPreference, Queue, RequestAdapterOptions,
};

use super::lock;

/// What went wrong on a device.
#[derive(Debug, Default)]
pub(super) struct Health {
    lost: AtomicBool,
    message: Mutex<Option<String>>,
}

impl Health {
    pub(super) fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Acquire)
    }

    fn say(&self, message: String) {
        lock(&self.message).get_or_insert(message);
    }

    /// # Errors
    /// What went wrong since the last time, or that the device is gone.
    pub(super) fn check(&self, name: &str) -> Result<()> {
        let message = lock(&self.message).take();
        let (problem, remedy) = match (self.is_lost(), message) {
            (false, None) => return Ok(()),
            (true, message) => (format!("is gone: {}", message.unwrap_or_default()), "try again, or draw on the CPU"),
            (false, Some(message)) => (message, "draw less at once, or on the CPU"),
        };
        Err(failed(name, problem, remedy))
    }
}

pub(super) fn failed(name: &str, problem: String, remedy: &str) -> Error {
    Error::Helper { what: name.into(), problem, remedy: remedy.into(), code: 0 }
}

/// Opens the best device there is; with `hardware` one that no driver simulates.
pub(super) fn open(hardware: bool) -> Result<(Device, Queue, Arc<Health>)> {
    // OpenGL is looked at only where there is nothing better: its loaders take long and may write to the terminal.
    let backends = if hardware && !has_hardware() { &[][..] } else { &[Backends::PRIMARY, Backends::GL] };
    let mut adapters = backends.iter().filter_map(|backends| adapter(*backends));
    let Some(adapter) = adapters.find(|a| !hardware || a.get_info().device_type != DeviceType::Cpu) else {
        let problem = "there is none: no driver for Vulkan, Metal, Direct3D 12 or OpenGL was found";
        let remedy = "install one (Mesa's needs no GPU: mesa-vulkan-drivers), or choose the CPU";
        return Err(failed("the GPU", problem.into(), remedy));
    };
    let (has, info) = (adapter.limits(), adapter.get_info());
    let limits = Limits {
        max_texture_dimension_2d: has.max_texture_dimension_2d,
        max_buffer_size: has.max_buffer_size,
        max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
        ..Limits::downlevel_defaults()
    };
    let wanted = DeviceDescriptor { required_limits: limits, ..DeviceDescriptor::default() };
    let (device, queue) = block_on(adapter.request_device(&wanted))
        .map_err(|e| failed(&info.name, format!("does not open: {e}"), "choose the CPU"))?;
    let health = Arc::new(Health::default());
    let (lost, errors) = (health.clone(), health.clone());
    device.set_device_lost_callback(move |_, message| {
        lost.say(message);
        lost.lost.store(true, Ordering::Release);
    });
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| errors.say(error.to_string())));
    Ok((device, queue, health))
}

/// Whether it is worth looking for a GPU: on Linux each has a device file. Loading drivers only to find that there is none
/// takes half a second, and some write to the terminal.
fn has_hardware() -> bool {
    const FILES: [&str; 4] = ["/dev/dri", "/dev/nvidiactl", "/dev/dxg", "/dev/kfd"];
    !cfg!(target_os = "linux") || FILES.iter().any(|file| std::path::Path::new(file).exists())
}

/// The strongest adapter that can do what is needed.
fn adapter(backends: Backends) -> Option<Adapter> {
    let instance = Instance::new(InstanceDescriptor {
        backends,
        // No validation layers: they are slow, and write where we may not.
        flags: InstanceFlags::empty(),
        ..InstanceDescriptor::new_without_display_handle()
    });
    let options = RequestAdapterOptions { power_preference: PowerPreference::HighPerformance, ..Default::default() };
    let adapter = block_on(instance.request_adapter(&options)).ok()?;
    let can = adapter.get_downlevel_capabilities().flags.contains(DownlevelFlags::VERTEX_STORAGE);
    can.then_some(adapter)
}

/// # Errors
/// A host's device cannot read bones in its vertex shaders.
pub(super) fn check(device: &Device) -> Result<()> {
    let limits = device.limits();
    if limits.max_storage_buffers_per_shader_stage > 0 && limits.max_storage_buffer_binding_size > 0 {
        return Ok(());
    }
    let problem = "was opened without storage buffers".into();
    Err(failed(&describe(device), problem, "open it with the limits that WebGPU grants everywhere"))
}

/// What it is called.
pub(super) fn describe(device: &Device) -> String {
    let info = device.adapter_info();
    format!("{} ({})", info.name, info.backend)
}

/// The result of a future that waits for nothing but the driver: with wgpu's native backends it is there at once.
fn block_on<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(out) = future.as_mut().poll(&mut context) {
            return out;
        }
        std::thread::yield_now();
    }
}
