//! Sketches: how motions hold a drawing, and the drawing in motion.

use marey_ffi::{mry_binding, mry_point, mry_sketch_take};

use crate::character::points;
use crate::{Clip, Context, Drawing, Job, Motion, Result, sys};

/// How motions hold a drawing.
#[derive(Debug)]
pub struct Binding {
    pub(crate) id: mry_binding,
    pub(crate) context: Context,
}

/// How a motion is used.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionUse {
    /// Its name in the binding.
    pub name: String,
    /// Pixels of the drawing that a pixel of its clip becomes.
    pub scale: f32,
    /// How far its movement is turned, in degrees, clockwise as seen.
    pub rotation: f32,
    /// Whether left and right are exchanged, before it is turned.
    pub mirror: bool,
    /// The frame in which the drawing is as it was drawn.
    pub frame: u64,
    /// How much of its way over the picture is kept: 1 all, 0 on the spot.
    pub travel: f32,
    /// Whether it begins again where another motion lasts longer.
    pub repeat: bool,
}

/// A tracked point that holds a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundPoint {
    /// Its track.
    pub track: String,
    /// The point of the track.
    pub index: u32,
    /// The place on the drawing.
    pub at: (f32, f32),
}

/// What a binding holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BindingInfo {
    /// How many motions it names.
    pub motions: u32,
    /// How many points hold the drawing.
    pub points: u32,
    /// How many places stay.
    pub pins: u32,
    /// How many layers there are.
    pub layers: u32,
    /// How many joints hold layers together.
    pub joints: u32,
}

/// What to bind by.
#[derive(Clone, Copy, Debug, Default)]
pub struct BindOptions<'a> {
    /// What to call the motion in the binding; empty for "motion".
    pub name: &'a str,
    /// The clip that the motion was tracked in.
    pub clip: Option<&'a Clip>,
    /// The frame that the drawing is like; chosen without.
    pub frame: Option<u64>,
    /// Whether the drawing faces the other way than what moves; without, what fits better.
    pub mirror: Option<bool>,
    /// The outline of what moves in that frame, where a person drew it, in clip pixels.
    pub contour: &'a [(f32, f32)],
    /// The outline of the drawing, where a person drew it, in its pixels.
    pub outline: &'a [(f32, f32)],
}

/// A drawing in motion.
#[derive(Debug)]
pub struct SketchTake {
    pub(crate) id: mry_sketch_take,
    pub(crate) context: Context,
}

/// An element of a path, in the drawing's pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathElement {
    /// A new piece begins here.
    Move((f32, f32)),
    /// A straight line.
    Line((f32, f32)),
    /// A curve by a control point.
    Quadratic((f32, f32), (f32, f32)),
    /// A curve by two control points.
    Cubic((f32, f32), (f32, f32), (f32, f32)),
    /// A straight line to where the piece began, which is closed.
    Close,
}

/// What a drawing in motion is written as.
#[derive(Clone, Copy, Debug)]
pub struct SketchFileOptions<'a> {
    /// The file or folder.
    pub path: &'a str,
    /// The format's name; empty to go by the path's ending.
    pub format: &'a str,
    /// A name for what is inside the file; empty for the path's.
    pub name: &'a str,
    /// Whether pictures show the drawing's page, rather than all of every frame.
    pub crop: bool,
    /// Pixels a pixel of the drawing.
    pub scale: f32,
    /// What lies behind: red, green, blue, alpha.
    pub background: [u8; 4],
}

impl Context {
    /// A binding of a drawing by which nothing is held yet.
    pub fn new_binding(&self, drawing: &Drawing) -> Result<Binding> {
        Ok(Binding { id: sys::binding_create(&self.0, drawing.id)?, context: self.clone() })
    }

    /// Reads a bind.json file.
    pub fn read_binding(&self, path: &str) -> Result<Binding> {
        Ok(Binding { id: sys::binding_read(&self.0, path)?, context: self.clone() })
    }

    /// Reads the text of a bind.json.
    pub fn binding_from_json(&self, json: &str) -> Result<Binding> {
        Ok(Binding { id: sys::binding_from_json(&self.0, json)?, context: self.clone() })
    }

    /// Starts laying what moves on a drawing.
    pub fn start_bind(&self, drawing: &Drawing, motion: &Motion, options: &BindOptions<'_>) -> Result<Job> {
        let (contour, outline) = (points(options.contour), points(options.outline));
        let id = sys::start_bind(&self.0, (drawing.id, motion.id), options, (&contour, &outline))?;
        Ok(Job { id, context: self.clone() })
    }

    /// Starts moving a drawing by motions, in the binding's order.
    pub fn start_sketch_take(&self, drawing: &Drawing, binding: &Binding, motions: &[&Motion]) -> Result<Job> {
        let motions: Vec<_> = motions.iter().map(|m| m.id).collect();
        let id = sys::start_sketch_take(&self.0, drawing.id, binding.id, &motions)?;
        Ok(Job { id, context: self.clone() })
    }

    /// Starts writing a drawing in motion.
    pub fn start_sketch_file(&self, take: &SketchTake, options: &SketchFileOptions<'_>) -> Result<Job> {
        Ok(Job { id: sys::start_sketch_file(&self.0, take.id, options)?, context: self.clone() })
    }

    /// Makes a motion of the text of a paths.json: points that run along drawn paths.
    pub fn motion_from_paths(&self, json: &str) -> Result<Motion> {
        Ok(Motion { id: sys::motion_from_paths(&self.0, json)?, context: self.clone() })
    }
}

impl Job {
    /// Takes the binding that it made; once.
    pub fn take_binding(&self) -> Result<Binding> {
        Ok(Binding { id: sys::take_binding(&self.context.0, self.id)?, context: self.context.clone() })
    }

    /// Takes the drawing in motion that it made; once.
    pub fn take_sketch_take(&self) -> Result<SketchTake> {
        Ok(SketchTake { id: sys::take_sketch_take(&self.context.0, self.id)?, context: self.context.clone() })
    }
}

impl Binding {
    /// The text of a bind.json.
    pub fn to_json(&self) -> Result<String> {
        sys::binding_to_json(&self.context.0, self.id)
    }

    /// Writes bind.json, whole or not at all.
    pub fn write(&self, path: &str) -> Result<()> {
        sys::binding_write(&self.context.0, self.id, path)
    }

    /// Whether a sketch can be made of it and a drawing.
    pub fn validate(&self, drawing: &Drawing) -> Result<()> {
        sys::binding_validate(&self.context.0, self.id, drawing.id)
    }

    /// Counts.
    pub fn info(&self) -> Result<BindingInfo> {
        let info = sys::binding_info(&self.context.0, self.id)?;
        Ok(BindingInfo {
            motions: info.motion_count,
            points: info.point_count,
            pins: info.pin_count,
            layers: info.layer_count,
            joints: info.joint_count,
        })
    }

    /// How a motion is used.
    pub fn motion(&self, index: u32) -> Result<MotionUse> {
        let (name, how) = sys::binding_motion(&self.context.0, self.id, index)?;
        let (scale, rotation, travel) = (how.scale, how.rotation, how.travel);
        let (mirror, repeat) = (how.mirror != 0, how.repeat != 0);
        Ok(MotionUse { name, scale, rotation, mirror, frame: how.frame, travel, repeat })
    }

    /// Says how a motion is used; a new name adds one behind the others.
    pub fn set_motion(&self, how: &MotionUse) -> Result<()> {
        let mut used = sys::motion_use();
        (used.scale, used.rotation, used.travel) = (how.scale, how.rotation, how.travel);
        (used.frame, used.mirror, used.repeat) = (how.frame, how.mirror.into(), how.repeat.into());
        sys::binding_set_motion(&self.context.0, self.id, &how.name, &used)
    }

    /// Where tracked points hold the drawing.
    pub fn points(&self) -> Result<Vec<BoundPoint>> {
        let one = |i| {
            let (track, index, at) = sys::binding_point(&self.context.0, self.id, i)?;
            Ok(BoundPoint { track, index, at: (at.x, at.y) })
        };
        (0..self.info()?.points).map(one).collect()
    }

    /// Says where a point of a track holds the drawing: `motion` empty for the first, `layer` for the nearest.
    pub fn set_point(&self, motion: &str, track: &str, index: u32, at: (f32, f32), layer: &str) -> Result<()> {
        let at = mry_point { x: at.0, y: at.1 };
        sys::binding_set_point(&self.context.0, self.id, [motion, track, layer], index, at)
    }

    /// Lets a point of a track hold the drawing no longer.
    pub fn remove_point(&self, motion: &str, track: &str, index: u32) -> Result<()> {
        sys::binding_remove_point(&self.context.0, self.id, [motion, track], index)
    }

    /// Pins a place; `layer` empty for the nearest.
    pub fn add_pin(&self, at: (f32, f32), layer: &str) -> Result<()> {
        sys::binding_add_pin(&self.context.0, self.id, mry_point { x: at.0, y: at.1 }, layer)
    }

    /// Takes a pin away; those behind it move down.
    pub fn remove_pin(&self, index: u32) -> Result<()> {
        sys::binding_remove_pin(&self.context.0, self.id, index)
    }

    /// How much more than by default a stroke keeps its shape, and whether it stands still.
    pub fn stroke(&self, stroke: &str) -> Result<(f32, bool)> {
        sys::binding_stroke(&self.context.0, self.id, stroke)
    }

    /// Says how a stroke is treated.
    pub fn set_stroke(&self, stroke: &str, rigidity: f32, decoration: bool) -> Result<()> {
        sys::binding_set_stroke(&self.context.0, self.id, stroke, rigidity, decoration)
    }

    /// Puts the strokes that a brush touches into a layer, and says how many.
    pub fn paint_layer(&self, drawing: &Drawing, layer: &str, brush: &[(f32, f32)], radius: f32) -> Result<u32> {
        sys::binding_paint_layer(&self.context.0, (self.id, drawing.id), layer, &points(brush), radius)
    }

    /// Puts strokes into a layer; a new name makes one in front of the others.
    pub fn set_layer(&self, drawing: &Drawing, layer: &str, strokes: &[&str]) -> Result<()> {
        sys::binding_set_layer(&self.context.0, (self.id, drawing.id), layer, strokes)
    }

    /// Writes a PNG of the drawing with numbers where tracked points hold it, beside the frame of the clip that it is like.
    pub fn write_preview(&self, drawing: &Drawing, motion: &Motion, clip: Option<&Clip>, path: &str) -> Result<()> {
        let clip = clip.map_or(marey_ffi::mry_clip::default(), |c| c.id);
        sys::binding_write_preview(&self.context.0, (self.id, drawing.id), motion.id, clip, path)
    }

    /// Proposes joints where layers cross, in place of those that were there.
    pub fn propose_joints(&self, drawing: &Drawing) -> Result<()> {
        sys::binding_propose_joints(&self.context.0, self.id, drawing.id)
    }
}

impl SketchTake {
    /// How many frames there are, and how many a second.
    pub fn frames(&self) -> Result<(u64, f64)> {
        let info = sys::sketch_take_info(&self.context.0, self.id)?;
        Ok((info.frame_count, info.fps))
    }

    /// The path of a stroke in a frame.
    pub fn stroke(&self, frame: u64, stroke: u32) -> Result<Vec<PathElement>> {
        let elements = sys::sketch_take_stroke(&self.context.0, self.id, frame, stroke)?;
        let one = |e: &marey_ffi::mry_path_element| {
            let [a, b, c] = e.points.map(|p| (p.x, p.y));
            match e.kind {
                marey_ffi::MRY_PATH_MOVE => PathElement::Move(a),
                marey_ffi::MRY_PATH_LINE => PathElement::Line(a),
                marey_ffi::MRY_PATH_QUADRATIC => PathElement::Quadratic(a, b),
                marey_ffi::MRY_PATH_CUBIC => PathElement::Cubic(a, b, c),
                _ => PathElement::Close,
            }
        };
        Ok(elements.iter().map(one).collect())
    }

    /// Width and height in pixels of what pictures show, and where their left upper corner lies on the drawing.
    pub fn measure(&self, scale: f32, crop: bool) -> Result<((u32, u32), (f32, f32))> {
        let (width, height, corner) = sys::sketch_take_measure(&self.context.0, self.id, scale, crop)?;
        Ok(((width, height), (corner.x, corner.y)))
    }

    /// Width, height and pixels (red, green, blue, alpha) of a frame, `scale` pixels a pixel of the drawing.
    pub fn draw(&self, frame: u64, scale: f32, crop: bool) -> Result<(u32, u32, Vec<u8>)> {
        sys::sketch_take_draw(&self.context.0, self.id, frame, scale, crop)
    }
}

impl Drop for Binding {
    fn drop(&mut self) {
        sys::binding_destroy(&self.context.0, self.id);
    }
}

impl Drop for SketchTake {
    fn drop(&mut self) {
        sys::sketch_take_destroy(&self.context.0, self.id);
    }
}
