//! Pictures and animations of creatures from any side.

use crate::{Clip, Context, Creature, Crowd, Job, Result, sys};

/// Who draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(i32)]
pub enum Adapter {
    /// A GPU where there is one, else the CPU.
    #[default]
    Auto = 0,
    /// A GPU, or one that a driver simulates.
    Gpu = 1,
    /// The CPU.
    Cpu = 2,
}

/// What is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(i32)]
pub enum Style {
    /// The texture's colours as they are.
    #[default]
    Textured = 0,
    /// The texture under a lamp.
    Shaded = 1,
    /// The edges of the triangles.
    Wireframe = 2,
    /// How far the surface is from its bones.
    Radius = 3,
    /// Which bones move the surface, and the bones.
    Bones = 4,
    /// How near it is.
    Depth = 5,
    /// Where the surface faces.
    Normals = 6,
}

/// From where.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Camera {
    /// Far enough to show the whole animation; degrees, and `fov` 0 to look in parallel.
    Fitted {
        /// To the right.
        yaw: f32,
        /// From above.
        pitch: f32,
        /// Between bottom and top.
        fov: f32,
    },
    /// As the clip's own.
    #[default]
    Clip,
    /// Around a target; `reach` is the distance to it, or without `fov` the height of the picture, in world units.
    Placed {
        /// To the right.
        yaw: f32,
        /// From above.
        pitch: f32,
        /// Between bottom and top.
        fov: f32,
        /// World units.
        reach: f32,
        /// What is in the middle.
        target: [f32; 3],
    },
}

/// What pictures are like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderOptions {
    /// Width and height in pixels; zeros for the clip's.
    pub size: (u32, u32),
    /// What is shown.
    pub style: Style,
    /// Who draws.
    pub adapter: Adapter,
    /// Edges are not smoothed.
    pub hard_edges: bool,
    /// How dark the shadow on the floor is, 0 for none to 1.
    pub shadow: f32,
    /// What lies behind: red, green, blue, alpha.
    pub background: [u8; 4],
    /// The frame; of an animation the first.
    pub frame: u64,
    /// From where.
    pub camera: Camera,
}

/// What a file is like.
#[derive(Clone, Copy, Debug, Default)]
pub struct RenderFileOptions<'a> {
    /// The file or the folder.
    pub path: &'a str,
    /// The format's name; empty to go by the path's ending.
    pub format: &'a str,
    /// The creature does not move.
    pub still: bool,
    /// How many pictures; 0 for as many as the animation has.
    pub frames: u64,
    /// Pictures a second; 0 for the creature's.
    pub fps: f64,
    /// How often the camera goes around.
    pub turns: f32,
}

impl Creature {
    /// A picture: RGBA, rows from the top, straight alpha.
    pub fn render(&self, options: &RenderOptions) -> Result<Vec<u8>> {
        sys::creature_render(&self.context.0, self.id, options)
    }
}

impl Context {
    /// Who draws for this choice, for a person.
    pub fn renderer(&self, adapter: Adapter) -> Result<String> {
        sys::context_renderer(&self.0, adapter)
    }

    /// Starts drawing a creature into a file.
    pub fn start_render(
        &self,
        creature: &Creature,
        pictures: &RenderOptions,
        file: &RenderFileOptions<'_>,
    ) -> Result<Job> {
        Ok(Job { id: sys::start_render(&self.0, creature.id, pictures, file)?, context: self.clone() })
    }

    /// Starts drawing a crowd into a file.
    pub fn start_render_crowd(
        &self,
        crowd: &Crowd,
        pictures: &RenderOptions,
        file: &RenderFileOptions<'_>,
    ) -> Result<Job> {
        Ok(Job { id: sys::start_render_crowd(&self.0, crowd.id, pictures, file, None)?, context: self.clone() })
    }

    /// Starts putting a crowd back into the clip that it was filmed in. Pictures in `masks` are bright where who was
    /// filmed is, and hide what is behind it. `alone`, only the crowd is drawn.
    pub fn start_render_in_clip(
        &self,
        crowd: &Crowd,
        clip: &Clip,
        masks: Option<&Clip>,
        alone: bool,
        pictures: &RenderOptions,
        file: &RenderFileOptions<'_>,
    ) -> Result<Job> {
        let into = Some((clip.id, masks.map(|m| m.id), alone));
        Ok(Job { id: sys::start_render_crowd(&self.0, crowd.id, pictures, file, into)?, context: self.clone() })
    }
}
