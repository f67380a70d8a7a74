//! Characters: drawings that move by their skeletons.

use marey_ffi::{mry_character, mry_motion, mry_point, mry_poser, mry_poses, mry_take};

use crate::{Context, Job, Motion, Result, sys};

/// What to make a character of: a picture, a rig, or both. Empty strings are none.
#[derive(Clone, Copy, Debug, Default)]
pub struct CharacterOptions<'a> {
    /// The drawing's file.
    pub picture: &'a str,
    /// A picture of the same size that cuts it out.
    pub mask: &'a str,
    /// A rig.json file.
    pub rig: &'a str,
    /// The text of a rig.json.
    pub rig_json: &'a str,
    /// About how many vertices the mesh has; 0 for the default.
    pub vertices: u32,
    /// How much closer they are at joints; 0 for the default.
    pub finer_at_joints: f32,
}

/// What keeps the area of a mesh that needles move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(i32)]
pub enum Area {
    /// Every triangle keeps its area.
    #[default]
    Exact = 0,
    /// Across a bone by the reciprocal of its length.
    Reciprocal = 1,
    /// Nothing.
    Off = 2,
}

/// How a motion is carried over.
#[derive(Clone, Copy, Debug, Default)]
pub struct RetargetOptions<'a> {
    /// Bones point where the motion's do, rather than turn as they do.
    pub absolute: bool,
    /// The frame that the character at rest corresponds to.
    pub reference: u64,
    /// Bones change their length up to this factor; 0 for the default, 1 for not at all.
    pub stretch: f32,
    /// What the way of the roots is scaled by; `None` for the ratio of the figures' sizes.
    pub root_scale: Option<f32>,
    /// The text of a map.json; empty for none.
    pub map: &'a str,
    /// Joints that stay where they come down.
    pub planted: &'a [String],
}

/// How a take is made.
#[derive(Clone, Copy, Debug, Default)]
pub struct TakeOptions<'a> {
    /// "needles", "arap" or a plugin's id; empty for the first.
    pub deformer: &'a str,
    /// What keeps the area, with needles.
    pub area: Area,
    /// How a motion is carried over.
    pub retarget: RetargetOptions<'a>,
}

/// How a take is written.
#[derive(Clone, Copy, Debug, Default)]
pub struct TakeFileOptions<'a> {
    /// The file or the folder.
    pub path: &'a str,
    /// The format's name; empty to go by the path's ending.
    pub format: &'a str,
    /// A name for what is inside; empty for the path's.
    pub name: &'a str,
    /// Pictures are cut to the drawing's.
    pub crop: bool,
    /// Pixels a pixel of the drawing; 0 for 1.
    pub scale: f32,
    /// What lies behind: red, green, blue, alpha.
    pub background: [u8; 4],
}

/// A cut-out drawing with a skeleton.
#[derive(Debug)]
pub struct Character {
    pub(crate) id: mry_character,
    pub(crate) context: Context,
}

/// How much a character is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CharacterInfo {
    /// Width and height of the picture.
    pub size: (u32, u32),
    /// Joints.
    pub joints: u32,
    /// Bones.
    pub bones: u32,
    /// Vertices of the mesh.
    pub vertices: u64,
    /// Triangles of the mesh.
    pub triangles: u64,
}

impl Context {
    /// Starts making a character.
    pub fn start_character(&self, options: &CharacterOptions<'_>) -> Result<Job> {
        Ok(Job { id: sys::start_character(&self.0, options)?, context: self.clone() })
    }

    /// Reads a BVH file: 0 as seen along z, 1 along x, 2 and 3 the same with z up.
    pub fn read_bvh(&self, path: &str, view: i32) -> Result<Motion> {
        Ok(Motion { id: sys::motion_read_bvh(&self.0, path, view)?, context: self.clone() })
    }

    /// Starts making a take of key poses.
    pub fn start_take_of_poses(&self, poses: &Poses, options: &TakeOptions<'_>) -> Result<Job> {
        let parts = (poses.id, mry_character::default(), mry_motion::default());
        Ok(Job { id: sys::start_take(&self.0, parts, options)?, context: self.clone() })
    }

    /// Starts making a take of a motion.
    pub fn start_take_of_motion(
        &self,
        character: &Character,
        motion: &Motion,
        options: &TakeOptions<'_>,
    ) -> Result<Job> {
        let parts = (mry_poses::default(), character.id, motion.id);
        Ok(Job { id: sys::start_take(&self.0, parts, options)?, context: self.clone() })
    }

    /// Starts writing a take.
    pub fn start_take_file(&self, take: &Take, options: &TakeFileOptions<'_>) -> Result<Job> {
        Ok(Job { id: sys::start_take_file(&self.0, take.id, options)?, context: self.clone() })
    }
}

impl Job {
    /// Takes the character that it made; once.
    pub fn take_character(&self) -> Result<Character> {
        Ok(Character { id: sys::take_character(&self.context.0, self.id)?, context: self.context.clone() })
    }

    /// Takes the take that it made; once.
    pub fn take_take(&self) -> Result<Take> {
        Ok(Take { id: sys::take_take(&self.context.0, self.id)?, context: self.context.clone() })
    }

    /// What it says of its work, as JSON.
    pub fn report(&self) -> Result<String> {
        sys::job_report(&self.context.0, self.id)
    }
}

impl Motion {
    /// The motion of a character's joints that this one leads to.
    pub fn retarget(&self, character: &Character, options: &RetargetOptions<'_>) -> Result<Motion> {
        let id = sys::motion_retarget(&self.context.0, self.id, character.id, options)?;
        Ok(Motion { id, context: self.context.clone() })
    }

    /// Which joint of a character follows what, as the text of a map.json.
    pub fn matched(&self, character: &Character, options: &RetargetOptions<'_>) -> Result<String> {
        sys::motion_match(&self.context.0, self.id, character.id, options)
    }

    /// Writes its joints as a BVH file, whole or not at all.
    pub fn write_bvh(&self, path: &str) -> Result<()> {
        sys::motion_write_bvh(&self.context.0, self.id, path)
    }
}

impl Character {
    /// How much it is made of.
    pub fn info(&self) -> Result<CharacterInfo> {
        let info = sys::character_info(&self.context.0, self.id)?;
        Ok(CharacterInfo {
            size: (info.width, info.height),
            joints: info.joint_count,
            bones: info.bone_count,
            vertices: info.vertex_count,
            triangles: info.triangle_count,
        })
    }

    /// Names and places of its joints.
    pub fn joints(&self) -> Result<Vec<(String, (f32, f32))>> {
        let one = |joint| {
            let (name, at) = sys::character_joint(&self.context.0, self.id, joint)?;
            Ok((name, (at.x, at.y)))
        };
        (0..self.info()?.joints).map(one).collect()
    }

    /// The two joints of each bone, from the root outward.
    pub fn bones(&self) -> Result<Vec<[u32; 2]>> {
        (0..self.info()?.bones).map(|bone| sys::character_bone(&self.context.0, self.id, bone)).collect()
    }

    /// The three vertices of each triangle of its mesh.
    pub fn triangles(&self) -> Result<Vec<[u32; 3]>> {
        sys::character_triangles(&self.context.0, self.id)
    }

    /// The vertices of its mesh at rest.
    pub fn vertices(&self) -> Result<Vec<(f32, f32)>> {
        Ok(places(&sys::character_vertices(&self.context.0, self.id)?))
    }

    /// The bone that each vertex follows.
    pub fn vertex_bones(&self) -> Result<Vec<u32>> {
        sys::character_vertex_bones(&self.context.0, self.id)
    }

    /// Moves its joints at rest.
    pub fn set_joints(&self, places: &[(f32, f32)]) -> Result<()> {
        sys::character_set_joints(&self.context.0, self.id, &points(places))
    }

    /// The text of a rig.json.
    pub fn to_json(&self) -> Result<String> {
        sys::character_to_json(&self.context.0, self.id)
    }

    /// Writes rig.json, whole or not at all.
    pub fn write(&self, path: &str) -> Result<()> {
        sys::character_write(&self.context.0, self.id, path)
    }

    /// Writes a PNG of the rig over the picture, whole or not at all.
    pub fn write_preview(&self, path: &str) -> Result<()> {
        sys::character_write_preview(&self.context.0, self.id, path)
    }

    /// Reads key poses for it.
    pub fn read_poses(&self, path: &str) -> Result<Poses> {
        Ok(Poses { id: sys::poses_read(&self.context.0, self.id, path)?, context: self.context.clone() })
    }

    /// Binds it to its skeleton.
    pub fn poser(&self, deformer: &str, area: Area) -> Result<Poser> {
        let id = sys::poser_create(&self.context.0, self.id, deformer, area as i32)?;
        let shape = vec![mry_point::default(); self.info()?.vertices as usize];
        Ok(Poser { id, context: self.context.clone(), shape })
    }
}

impl Drop for Character {
    fn drop(&mut self) {
        sys::character_destroy(&self.context.0, self.id);
    }
}

pub(crate) fn points(places: &[(f32, f32)]) -> Vec<mry_point> {
    places.iter().map(|&(x, y)| mry_point { x, y }).collect()
}

pub(crate) fn places(points: &[mry_point]) -> Vec<(f32, f32)> {
    points.iter().map(|p| (p.x, p.y)).collect()
}

/// A character bound to its skeleton.
#[derive(Debug)]
pub struct Poser {
    id: mry_poser,
    context: Context,
    shape: Vec<mry_point>,
}

impl Poser {
    /// The mesh with the joints at these places.
    pub fn pose(&mut self, joints: &[(f32, f32)]) -> Result<Vec<(f32, f32)>> {
        sys::poser_pose(&self.context.0, self.id, &points(joints), &mut self.shape)?;
        Ok(places(&self.shape))
    }
}

impl Poser {
    /// The same on from the pose before, while the pointer moves: many times as fast, and within a pixel.
    pub fn drag(&mut self, joints: &[(f32, f32)]) -> Result<Vec<(f32, f32)>> {
        sys::poser_drag(&self.context.0, self.id, &points(joints), &mut self.shape)?;
        Ok(places(&self.shape))
    }
}

impl Drop for Poser {
    fn drop(&mut self) {
        sys::poser_destroy(&self.context.0, self.id);
    }
}

/// Key poses of a character.
#[derive(Debug)]
pub struct Poses {
    id: mry_poses,
    context: Context,
}

impl Drop for Poses {
    fn drop(&mut self) {
        sys::poses_destroy(&self.context.0, self.id);
    }
}

/// A character in motion.
#[derive(Debug)]
pub struct Take {
    pub(crate) id: mry_take,
    pub(crate) context: Context,
}

impl Take {
    /// How many frames there are, and how many a second.
    pub fn frames(&self) -> Result<(u64, f64)> {
        let info = sys::take_info(&self.context.0, self.id)?;
        Ok((info.frame_count, info.fps))
    }

    /// The mesh in a frame.
    pub fn points(&self, frame: u64) -> Result<Vec<(f32, f32)>> {
        Ok(places(&sys::take_points(&self.context.0, self.id, frame)?))
    }

    /// The joints in a frame.
    pub fn joints(&self, frame: u64) -> Result<Vec<(f32, f32)>> {
        Ok(places(&sys::take_joints(&self.context.0, self.id, frame)?))
    }

    /// Width and height in pixels of what pictures show, and where their left upper corner lies on the drawing.
    pub fn measure(&self, scale: f32, crop: bool) -> Result<((u32, u32), (f32, f32))> {
        let (width, height, corner) = sys::take_measure(&self.context.0, self.id, scale, crop)?;
        Ok(((width, height), (corner.x, corner.y)))
    }

    /// Width, height and pixels (red, green, blue, alpha) of a frame, `scale` pixels a pixel of the drawing.
    pub fn draw(&self, frame: u64, scale: f32, crop: bool) -> Result<(u32, u32, Vec<u8>)> {
        sys::take_draw(&self.context.0, self.id, frame, scale, crop)
    }

    /// The text of the report of the job that made it.
    pub fn report(&self) -> Result<String> {
        sys::take_report(&self.context.0, self.id)
    }
}

impl Drop for Take {
    fn drop(&mut self) {
        sys::take_destroy(&self.context.0, self.id);
    }
}
