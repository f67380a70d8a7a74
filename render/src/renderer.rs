//! Who draws: a GPU, or the CPU.

use image::RgbaImage;
use marey::Result;
use marey::job::Stage;

use crate::{Picture, Scene, cpu};

/// Who is to draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Adapter {
    /// A GPU where there is one, else the CPU.
    #[default]
    Auto,
    /// A GPU, or one that is simulated by a driver; without either an error.
    Gpu,
    /// The CPU.
    Cpu,
}

/// Draws scenes. Making one may take a good part of a second: keep it. Any number of threads may draw at once.
#[derive(Debug)]
pub struct Renderer {
    #[cfg(feature = "gpu")]
    gpu: Option<crate::gpu::Gpu>,
    /// Whether what the GPU cannot draw, the CPU may.
    #[cfg(feature = "gpu")]
    either: bool,
}

#[cfg(feature = "gpu")]
impl Renderer {
    /// # Errors
    /// A GPU was asked for, and none can be had.
    pub fn new(adapter: Adapter) -> Result<Self> {
        use crate::gpu::Gpu;
        let gpu = match adapter {
            Adapter::Cpu => None,
            // A driver that simulates a GPU needs more time than our own code for the same picture.
            Adapter::Auto => Gpu::hardware().ok(),
            Adapter::Gpu => Some(Gpu::new()?),
        };
        Ok(Self { gpu, either: adapter == Adapter::Auto })
    }

    /// The GPU, where one draws.
    pub fn gpu(&self) -> Option<&crate::gpu::Gpu> {
        self.gpu.as_ref()
    }

    /// Draws a frame of a scene. Straight alpha. `stage` can cancel, and is not moved.
    ///
    /// # Errors
    /// What cannot be drawn: a size, camera, frame or scene that is not sound, more than the GPU takes, a GPU that failed, a cancel.
    pub fn draw(&self, scene: &Scene, frame: usize, picture: &Picture, stage: Stage<'_>) -> Result<RgbaImage> {
        match &self.gpu {
            Some(gpu) if !self.either || gpu.holds(picture.size) => gpu.draw(scene, frame, picture),
            _ => cpu::draw(scene, frame, picture, stage),
        }
    }

    /// Whether the device is gone, so that a new renderer is needed.
    pub fn is_lost(&self) -> bool {
        self.gpu.as_ref().is_some_and(crate::gpu::Gpu::is_lost)
    }

    /// Who draws, for a person.
    pub fn describe(&self) -> String {
        self.gpu.as_ref().map_or_else(|| "CPU".into(), |gpu| gpu.describe().to_owned())
    }
}

#[cfg(not(feature = "gpu"))]
impl Renderer {
    /// # Errors
    /// A GPU was asked for: this build has no way to one.
    pub fn new(adapter: Adapter) -> Result<Self> {
        match adapter {
            Adapter::Gpu => {
                let (what, problem) = ("the GPU".into(), "this build has no code for one".into());
                let remedy = "choose the CPU, or build with the feature `gpu`".into();
                Err(marey::Error::Helper { what, problem, remedy, code: 0 })
            }
            Adapter::Auto | Adapter::Cpu => Ok(Self {}),
        }
    }

    /// Draws a frame of a scene. Straight alpha. `stage` can cancel, and is not moved.
    ///
    /// # Errors
    /// A size, camera, frame or scene that is not sound, a cancel.
    pub fn draw(&self, scene: &Scene, frame: usize, picture: &Picture, stage: Stage<'_>) -> Result<RgbaImage> {
        cpu::draw(scene, frame, picture, stage)
    }

    /// Whether the device is gone, so that a new renderer is needed.
    pub fn is_lost(&self) -> bool {
        false
    }

    /// Who draws, for a person.
    pub fn describe(&self) -> String {
        "CPU".into()
    }
}
