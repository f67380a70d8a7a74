//! Safe Rust over the C ABI of Marey, for the hosts of this repository.
//!
//! The hosts use nothing else of the engine: what they can do, a C program can do. Objects destroy themselves; they
//! keep their context alive. Everything may be used from any thread. Unsafe code is in `sys` alone.
//!
//! ```no_run
//! use marey_binding::{Context, CreatureOptions};
//!
//! # fn main() -> marey_binding::Result<()> {
//! let context = Context::new(0)?;
//! let clip = context.open_clip("horse.mp4")?;
//! let rig = context.read_rig("strokes.json")?;
//! let job = context.start_creature(&clip, &rig, &CreatureOptions::default())?;
//! job.wait(None)?;
//! job.take_creature()?.write_glb("horse.glb", 0.0)?;
//! # Ok(())
//! # }
//! ```

mod character;
mod clip;
mod context;
mod control_points;
mod creature;
mod creature_surface;
mod crowd;
mod deformation;
mod drawing;
mod error;
mod job;
mod joints;
mod masks;
mod motion;
mod motion_shaping;
mod parameter;
mod plugin;
mod print;
mod render;
mod retiming;
mod rig;
mod session;
mod sketch;
mod sys;

pub use character::{
    Area, Character, CharacterInfo, CharacterOptions, Poser, Poses, RetargetOptions, Take, TakeFileOptions, TakeOptions,
};
pub use clip::{Clip, ClipInfo};
pub use context::Context;
pub use control_points::ControlPoints;
pub use creature::{Creature, CreatureFile, CreatureInfo, CreatureLimb, ReposeOptions};
pub use creature_surface::{EditedMesh, Texture, TextureOptions};
pub use crowd::{Crowd, CrowdInfo, Instance, Play};
pub use deformation::{Deformation, Handle};
pub use drawing::{Drawing, DrawingInfo, DrawingStroke, PenSample};
pub use error::{Error, Result, Status};
pub use job::{CreatureOptions, CreatureSurface, Job, JobState, SegmentOptions, TrackOptions};
pub use joints::Joints;
pub use masks::Masks;
pub use motion::{Correction, Motion, MotionInfo, TrackFrame};
pub use motion_shaping::{Cycle, LimbMapOptions, LoopOptions, PlantOptions, Seam};
pub use parameter::{Parameter, ParameterKind};
pub use plugin::{Plugin, PluginKind, PluginOptions, PluginParameter, PluginParameterKind};
pub use print::{PrintOptions, PrintSize, Solid, SolidInfo, SolidMesh};
pub use render::{Adapter, Camera, RenderFileOptions, RenderOptions, Style};
pub use retiming::RetimeOptions;
pub use rig::{Facing, Limb, LimbDepth, Rig, Side, Stroke};
pub use session::{Access, Part, Session, SessionState};
pub use sketch::{
    BindOptions, Binding, BindingInfo, BoundPoint, MotionUse, PathElement, SketchFileOptions, SketchTake,
};

/// The library's version, such as "0.1.0".
pub fn version() -> &'static str {
    sys::version()
}
