//! A creature's surface changed: what it wears, and its form as a modelling tool gives it back.

use std::ops::Range;

use crate::{Clip, Context, Creature, Job, Result, sys};

/// Where textures come from.
#[derive(Clone, Debug)]
pub enum Texture<'a> {
    /// The clip that the creature was made of, seen in all frames or some.
    Frames {
        /// The clip.
        clip: &'a Clip,
        /// Pictures that are bright where the creature is, such as the masks/ of its folder.
        masks: &'a Clip,
        /// The frames that give colours; none for all.
        frames: Option<Range<u64>>,
    },
    /// Another creature, limb by limb of the same label.
    Creature(&'a Creature),
    /// A picture of the creature's side, a file.
    Side(&'a str),
    /// A picture of a material, a file, which repeats.
    Repeated {
        /// The file.
        picture: &'a str,
        /// How wide one piece is, in world units; 0 for the picture's pixels.
        width: f32,
    },
}

/// What of a creature gets other textures.
#[derive(Clone, Copy, Debug, Default)]
pub struct TextureOptions<'a> {
    /// Labels of limbs; none for all.
    pub limbs: &'a [&'a str],
    /// Of those, what lies where this picture is bright, as the creature is seen at rest; empty for all.
    pub region: &'a str,
    /// Over so many world units the border runs from the old colours to the new ones.
    pub soft: f32,
}

/// A mesh that a modelling tool gives back.
#[derive(Clone, Copy, Debug)]
pub enum EditedMesh<'a> {
    /// A Wavefront OBJ.
    File(&'a str),
    /// Lists.
    Lists {
        /// Vertices in world coordinates of the frame.
        positions: &'a [[f32; 3]],
        /// Triangles, counter-clockwise seen from outside.
        triangles: &'a [[u32; 3]],
    },
}

impl Context {
    /// Starts giving a creature other textures; the job makes a creature.
    pub fn start_texture(
        &self,
        creature: &Creature,
        texture: &Texture<'_>,
        options: &TextureOptions<'_>,
    ) -> Result<Job> {
        Ok(Job { id: sys::start_texture(&self.0, creature.id, texture, options)?, context: self.clone() })
    }

    /// Starts taking an edited mesh of a frame into a creature; the job makes a creature.
    pub fn start_edit(&self, creature: &Creature, frame: u64, mesh: &EditedMesh<'_>) -> Result<Job> {
        Ok(Job { id: sys::start_edit(&self.0, creature.id, frame, mesh)?, context: self.clone() })
    }
}

impl Creature {
    /// Writes the textures of all parts into a folder as PNG pictures.
    pub fn write_textures(&self, folder: &str) -> Result<()> {
        sys::write_textures(&self.context.0, self.id, folder)
    }

    /// The creature with the textures that are in a folder.
    pub fn with_textures(&self, folder: &str) -> Result<Creature> {
        Ok(Creature { id: sys::read_textures(&self.context.0, self.id, folder)?, context: self.context.clone() })
    }
}
