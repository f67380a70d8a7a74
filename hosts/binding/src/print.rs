//! Printing: a frame of a creature as a closed solid in millimetres.

use marey_ffi::mry_solid;

use crate::{Context, Creature, Job, Result, sys};

/// How large a print is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PrintSize {
    /// Its longest side, in mm.
    Longest(f32),
    /// Its height, in mm.
    Height(f32),
    /// Millimetres a world unit.
    Unit(f32),
}

/// What to print, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintOptions<'a> {
    /// Which frame.
    pub frame: u64,
    /// How large, before thin parts and a base make it larger.
    pub size: PrintSize,
    /// No part is thinner, in mm; `None` leaves thin parts as they are.
    pub min_thickness: Option<f32>,
    /// The size of the smallest detail, in mm; 0 chooses by size and thickness.
    pub detail: f32,
    /// A plate under the feet.
    pub base: bool,
    /// At most so many triangles; 0 for as many as the detail takes.
    pub max_triangles: u32,
    /// Where to write it, a name that ends in .stl or .3mf; empty for nowhere.
    pub path: &'a str,
}

impl Default for PrintOptions<'_> {
    fn default() -> Self {
        Self {
            frame: 0,
            size: PrintSize::Longest(100.0),
            min_thickness: Some(1.0),
            detail: 0.0,
            base: false,
            max_triangles: 0,
            path: "",
        }
    }
}

/// A closed solid in millimetres, z up.
#[derive(Debug)]
pub struct Solid {
    pub(crate) id: mry_solid,
    pub(crate) context: Context,
}

/// What a solid is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidInfo {
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// In cubic mm.
    pub volume: f64,
    /// Width, depth and height, in mm.
    pub size: [f32; 3],
    /// How much of the surface belonged to parts that were too thin, 0..=1.
    pub thickened: f32,
}

/// A solid's surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolidMesh {
    /// x, y, z in mm, for each vertex.
    pub positions: Vec<f32>,
    /// Red, green, blue, for each vertex.
    pub colours: Vec<u8>,
    /// Three vertices, counter-clockwise seen from outside.
    pub triangles: Vec<u32>,
}

impl Context {
    /// Starts making a solid of a frame of a creature, and a file of it where a path is given.
    pub fn start_print(&self, creature: &Creature, options: &PrintOptions<'_>) -> Result<Job> {
        Ok(Job { id: sys::start_print(&self.0, creature.id, options)?, context: self.clone() })
    }
}

impl Job {
    /// Takes the solid that a print job made; once.
    pub fn take_solid(&self) -> Result<Solid> {
        Ok(Solid { id: sys::take_solid(&self.context.0, self.id)?, context: self.context.clone() })
    }
}

impl Solid {
    /// What it is.
    pub fn info(&self) -> Result<SolidInfo> {
        let info = sys::solid_info(&self.context.0, self.id)?;
        Ok(SolidInfo {
            vertices: info.vertex_count,
            triangles: info.triangle_count,
            volume: info.volume,
            size: [info.width, info.depth, info.height],
            thickened: info.thickened,
        })
    }

    /// Its surface.
    pub fn mesh(&self) -> Result<SolidMesh> {
        let (positions, colours) = sys::solid_vertices(&self.context.0, self.id)?;
        Ok(SolidMesh { positions, colours, triangles: sys::solid_triangles(&self.context.0, self.id)? })
    }

    /// Writes it, whole or not at all, as the path's ending says: .stl or .3mf.
    pub fn write(&self, path: &str) -> Result<()> {
        sys::solid_write(&self.context.0, self.id, path)
    }
}

impl Drop for Solid {
    fn drop(&mut self) {
        sys::solid_destroy(&self.context.0, self.id);
    }
}
