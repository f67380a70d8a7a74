//! Drawing with wgpu, on a device of our own or a host's.
//!
//! Surfaces are moved by their bones on the GPU: an instance costs its matrices a picture. What a model's buffers hold is
//! kept as long as the model. Each picture in the making has a `Slot`: its targets and what changes with it; several
//! threads may draw at once.

mod device;
mod pipelines;
mod slot;
mod uploaded;

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use image::RgbaImage;
use marey::{Error, Result};
use wgpu::{Device, Queue, RenderPipeline, TextureFormat, TextureView};

use self::device::Health;
use self::pipelines::{Key, Kind, Shared};
use self::slot::{FORMAT, Slot};
use self::uploaded::Uploaded;
use crate::bone_shapes::octahedra;
use crate::model::Prepared;
use crate::picture::View;
use crate::{Picture, Scene, Style};

/// Pictures in the making whose targets are kept for the next ones.
const KEPT_SLOTS: usize = 8;

/// A device and all that is made on it.
pub struct Gpu {
    device: Device,
    queue: Queue,
    name: String,
    /// `None` on a host's device, whose errors go to the host.
    health: Option<Arc<Health>>,
    shared: Shared,
    pipelines: Mutex<HashMap<Key, RenderPipeline>>,
    models: Mutex<Vec<(Weak<Prepared>, Arc<Uploaded>)>>,
    slots: Mutex<Vec<Slot>>,
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Gpu {{ {:?} }}", self.name)
    }
}

impl Gpu {
    /// On a device of our own: the strongest GPU there is, else what a driver simulates.
    ///
    /// # Errors
    /// None can be had.
    pub fn new() -> Result<Self> {
        let (device, queue, health) = device::open(false)?;
        Ok(Self::on(device, queue, Some(health)))
    }

    /// The same, but none that a driver simulates.
    ///
    /// # Errors
    /// None can be had.
    pub fn hardware() -> Result<Self> {
        let (device, queue, health) = device::open(true)?;
        Ok(Self::on(device, queue, Some(health)))
    }

    /// On a host's device. What goes wrong on it is reported to the host's handlers.
    ///
    /// # Errors
    /// The device cannot do what is needed.
    pub fn with_device(device: Device, queue: Queue) -> Result<Self> {
        device::check(&device)?;
        Ok(Self::on(device, queue, None))
    }

    fn on(device: Device, queue: Queue, health: Option<Arc<Health>>) -> Self {
        let name = device::describe(&device);
        let shared = Shared::new(&device);
        let (pipelines, models, slots) = Default::default();
        Self { device, queue, name, health, shared, pipelines, models, slots }
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Its queue.
    pub fn queue(&self) -> &Queue {
        &self.queue
    }

    /// What draws, for a person.
    pub fn describe(&self) -> &str {
        &self.name
    }

    /// Whether the device is gone.
    pub fn is_lost(&self) -> bool {
        self.health.as_ref().is_some_and(|h| h.is_lost())
    }

    /// Whether it can draw a picture of this size.
    pub fn holds(&self, (width, height): (u32, u32)) -> bool {
        let limits = self.device.limits();
        width.max(height) <= limits.max_texture_dimension_2d
            && slot::readback_size((width, height)) <= limits.max_buffer_size
    }

    /// Draws a frame of a scene. Straight alpha.
    ///
    /// # Errors
    /// A size, camera, frame or scene that is not sound, more than the device holds, a device that failed.
    pub fn draw(&self, scene: &Scene, frame: usize, picture: &Picture) -> Result<RgbaImage> {
        let view = picture.view(scene, frame)?;
        self.check_size(picture)?;
        let mut slot = self.slot(picture.size, samples(picture), FORMAT, true)?;
        self.encode(scene, frame, picture, &view, &mut slot, None)?;
        let drawn = slot.read(&self.device, picture.size);
        self.healthy()?;
        let drawn = drawn?;
        self.keep(slot);
        Ok(drawn)
    }

    /// Draws a frame of a scene into a host's texture, of the picture's size and one sample a pixel; premultiplied alpha. The
    /// format is one that holds colours as they are stored: `Rgba8Unorm`, `Bgra8Unorm`.
    ///
    /// # Errors
    /// A size, camera, frame or scene that is not sound, more than the device holds.
    pub fn draw_into(
        &self,
        target: &TextureView,
        format: TextureFormat,
        scene: &Scene,
        frame: usize,
        picture: &Picture,
    ) -> Result<()> {
        let view = picture.view(scene, frame)?;
        self.check_size(picture)?;
        let mut slot = self.slot(picture.size, samples(picture), format, false)?;
        self.encode(scene, frame, picture, &view, &mut slot, Some(target))?;
        self.keep(slot);
        self.healthy()
    }

    fn check_size(&self, picture: &Picture) -> Result<()> {
        if self.holds(picture.size) {
            return Ok(());
        }
        let (w, h) = picture.size;
        let most = self.device.limits().max_texture_dimension_2d;
        let problem = format!("is {w}x{h} pixels, and {} draws {most} on a side", self.name);
        Err(Error::invalid("the picture", problem, "ask for a smaller one, or draw on the CPU"))
    }

    fn healthy(&self) -> Result<()> {
        self.health.as_ref().map_or(Ok(()), |h| h.check(&self.name))
    }

    fn slot(&self, size: (u32, u32), samples: u32, format: TextureFormat, own: bool) -> Result<Slot> {
        self.healthy()?;
        let mut slots = lock(&self.slots);
        match slots.iter().position(|s| s.fits(size, samples, format, own)) {
            Some(i) => Ok(slots.swap_remove(i)),
            None => Ok(Slot::new(&self.device, &self.shared, size, samples, format, own)),
        }
    }

    fn keep(&self, slot: Slot) {
        let mut slots = lock(&self.slots);
        if slots.len() >= KEPT_SLOTS {
            slots.remove(0);
        }
        slots.push(slot);
    }

    /// What the device holds of a model.
    fn uploaded(&self, model: &Arc<Prepared>) -> Arc<Uploaded> {
        let mut models = lock(&self.models);
        models.retain(|(model, _)| model.strong_count() > 0);
        if let Some((_, uploaded)) = models.iter().find(|(m, _)| std::ptr::eq(m.as_ptr(), Arc::as_ptr(model))) {
            return uploaded.clone();
        }
        let uploaded = Arc::new(Uploaded::new(&self.device, &self.queue, &self.shared, model));
        models.push((Arc::downgrade(model), uploaded.clone()));
        uploaded
    }

    fn pipeline(&self, key: Key) -> RenderPipeline {
        let mut pipelines = lock(&self.pipelines);
        pipelines.entry(key).or_insert_with(|| self.shared.pipeline(&self.device, key)).clone()
    }

    fn encode(
        &self,
        scene: &Scene,
        frame: usize,
        picture: &Picture,
        view: &View,
        slot: &mut Slot,
        target: Option<&TextureView>,
    ) -> Result<()> {
        // Instances of a model lie together, so that one call draws them all.
        let mut groups: Vec<(Arc<Uploaded>, &Arc<Prepared>, Vec<usize>)> = Vec::new();
        for (i, instance) in scene.instances.iter().enumerate() {
            let model = &instance.model.0;
            match groups.iter_mut().find(|g| Arc::ptr_eq(g.1, model)) {
                Some(group) => group.2.push(i),
                None => groups.push((self.uploaded(model), model, vec![i])),
            }
        }
        let (mut bones, mut bases, mut shapes) = (Vec::new(), Vec::new(), Vec::new());
        for (_, model, members) in &groups {
            for instance in members.iter().map(|i| &scene.instances[*i]) {
                bases.push((bones.len() / 12) as u32);
                let pose = instance.pose(frame);
                for m in model.skin(&pose, &instance.place) {
                    (0..3).for_each(|row| bones.extend_from_slice(&m.row(row).to_array()));
                }
                if picture.style == Style::Bones {
                    let joints = model.joints(&pose, &instance.place);
                    octahedra(&model.links, &joints, &view.turn, &mut shapes);
                }
            }
        }
        if bones.len() as u64 * 4 > self.device.limits().max_storage_buffer_binding_size {
            let problem = format!("has {} instances, more bones than {} holds", scene.instances.len(), self.name);
            return Err(Error::invalid("the scene", problem, "draw fewer at once, or on the CPU"));
        }
        slot.fill(&self.device, &self.queue, &self.shared, view, &bones, &bases, &shapes);

        let key = |kind: Kind| Key { kind, format: slot.format(), samples: slot.samples() };
        let surface = self.pipeline(key(Kind::Surface(picture.style)));
        let shadow = view.shadow.map(|_| self.pipeline(key(Kind::Shadow)));
        let in_front = (!shapes.is_empty()).then(|| self.pipeline(key(Kind::Shapes)));
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = slot.begin(&mut encoder, view.clear, target);
            pass.set_bind_group(0, slot.group(), &[]);
            let mut draw = |pipeline: &RenderPipeline, style: Style| {
                pass.set_pipeline(pipeline);
                let mut first = 0;
                for (uploaded, model, members) in &groups {
                    pass.set_vertex_buffer(2, slot.bases().slice(4 * first as u64..));
                    uploaded.draw(&self.device, &mut pass, model, style, members.len() as u32);
                    first += members.len();
                }
            };
            if let Some(shadow) = &shadow {
                draw(shadow, Style::Textured);
            }
            draw(&surface, picture.style);
            if let Some(in_front) = &in_front {
                pass.set_pipeline(in_front);
                pass.set_vertex_buffer(0, slot.shapes().slice(..));
                pass.draw(0..shapes.len() as u32, 0..1);
            }
        }
        slot.submit(encoder, &self.queue);
        Ok(())
    }
}

fn samples(picture: &Picture) -> u32 {
    if picture.smooth { 4 } else { 1 }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
