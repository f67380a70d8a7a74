//! Creatures: a textured mesh on animated bones.

use std::ops::Range;

use marey_ffi::mry_creature;

use crate::{Context, Job, Masks, Motion, Result, sys};

/// A reconstructed creature.
#[derive(Debug)]
pub struct Creature {
    pub(crate) id: mry_creature,
    pub(crate) context: Context,
}

/// How much a creature is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreatureInfo {
    /// Bones.
    pub bones: u32,
    /// Limbs that are known.
    pub limbs: u32,
    /// Parts of its surface.
    pub parts: u32,
    /// Frames of the animation.
    pub frames: u64,
    /// Vertices of all parts.
    pub vertices: u64,
    /// Triangles of all parts.
    pub triangles: u64,
}

/// A limb of a creature.
#[derive(Clone, Debug, PartialEq)]
pub struct CreatureLimb {
    /// The user's name for it.
    pub label: String,
    /// Its length in the image plane, in pixels of the clip.
    pub length: f32,
    /// Its mean radius, in pixels of the clip.
    pub radius: f32,
    /// The limb it hangs from; none for one that holds a root.
    pub parent: Option<u32>,
    /// Its bones, evenly along its stroke, from the end nearer to the root outward.
    pub bones: Range<u32>,
}

impl Creature {
    /// How much it is made of.
    pub fn info(&self) -> Result<CreatureInfo> {
        let info = sys::creature_info(&self.context.0, self.id)?;
        Ok(CreatureInfo {
            bones: info.bone_count,
            limbs: info.limb_count,
            parts: info.part_count,
            frames: info.frame_count,
            vertices: info.vertex_count,
            triangles: info.triangle_count,
        })
    }

    /// A limb's label and how long and thick it is.
    pub fn limb(&self, limb: u32) -> Result<CreatureLimb> {
        let (label, info) = sys::creature_limb(&self.context.0, self.id, limb)?;
        Ok(CreatureLimb {
            label,
            length: info.length,
            radius: info.radius,
            parent: u32::try_from(info.parent).ok(),
            bones: info.first_bone..info.first_bone + info.bone_count,
        })
    }

    /// Where its bones begin in a frame, in world units: x right, y up, z toward the viewer.
    pub fn bone_places(&self, frame: u64) -> Result<Vec<[f32; 3]>> {
        let pose = sys::creature_pose(&self.context.0, self.id, frame)?;
        let mut world: Vec<([f32; 3], [f32; 4])> = Vec::with_capacity(pose.len());
        for (bone, own) in (0..).zip(&pose) {
            let parent = sys::creature_bone_parent(&self.context.0, self.id, bone)?;
            // Parents come before children.
            let above = usize::try_from(parent).ok().and_then(|parent| world.get(parent).copied());
            let (at, turn) = above.unwrap_or(([0.0; 3], [0.0, 0.0, 0.0, 1.0]));
            let moved = turned(turn, own.translation);
            let place = [at[0] + moved[0], at[1] + moved[1], at[2] + moved[2]];
            world.push((place, after(turn, own.rotation)));
        }
        Ok(world.into_iter().map(|bone| bone.0).collect())
    }

    /// The motion that drives it.
    pub fn motion(&self) -> Result<Motion> {
        Ok(Motion { id: sys::creature_motion(&self.context.0, self.id)?, context: self.context.clone() })
    }

    /// The masks it was built from.
    pub fn masks(&self) -> Result<Masks> {
        Ok(Masks { id: sys::creature_masks(&self.context.0, self.id)?, context: self.context.clone() })
    }

    /// The text of the report of the job that made it.
    pub fn report(&self) -> Result<String> {
        sys::creature_report(&self.context.0, self.id)
    }

    /// Writes a glTF binary, whole or not at all. `scale` is metres a world unit, 0 for 1.
    pub fn write_glb(&self, path: &str, scale: f32) -> Result<()> {
        sys::creature_write_glb(&self.context.0, self.id, path, scale)
    }

    /// Writes everything into a folder, whole or not at all.
    pub fn write_folder(&self, folder: &str, write_obj: bool, scale: f32) -> Result<()> {
        sys::creature_write_folder(&self.context.0, self.id, folder, write_obj, scale)
    }
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A vector turned by the unit quaternion x, y, z, w: v + 2 q x (q x v + w v).
fn turned([x, y, z, w]: [f32; 4], v: [f32; 3]) -> [f32; 3] {
    let q = [x, y, z];
    let inner = cross(q, v);
    let outer = cross(q, [inner[0] + w * v[0], inner[1] + w * v[1], inner[2] + w * v[2]]);
    [v[0] + 2.0 * outer[0], v[1] + 2.0 * outer[1], v[2] + 2.0 * outer[2]]
}

/// The turn that turns by `inner` first and then by `outer`.
fn after(outer: [f32; 4], inner: [f32; 4]) -> [f32; 4] {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (outer, inner);
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

/// What is written of a creature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum CreatureFile {
    /// One glTF binary.
    Glb = 1,
    /// A folder of meshes, one a frame.
    Obj = 2,
    /// A GIF of the clip with limbs and masks over it.
    Overlay = 3,
    /// A GIF of the creature, as filmed and from another side.
    Preview = 4,
    /// A folder with everything.
    Folder = 5,
}

impl Context {
    /// Starts writing a creature, whole or not at all. `write_obj` is for [`CreatureFile::Folder`]; `scale` is metres a
    /// world unit, 0 for 1.
    pub fn start_export(
        &self,
        creature: &Creature,
        what: CreatureFile,
        path: &str,
        write_obj: bool,
        scale: f32,
    ) -> Result<Job> {
        let id = sys::start_export(&self.0, creature.id, what as i32, path, (write_obj, scale))?;
        Ok(Job { id, context: self.clone() })
    }
}

/// How a creature is posed.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReposeOptions<'a> {
    /// Whether bones keep their lengths; none for what poses and motions do by themselves.
    pub keep_lengths: Option<bool>,
    /// A limb gets at most this many times its length; 0 for 1.25.
    pub stretch: f32,
    /// What the way of the roots is scaled by; none for the ratio of the limbs' lengths.
    pub root_scale: Option<f32>,
    /// Whether left and right of a motion change places.
    pub mirror: bool,
    /// Whether limbs point where a motion's do, or turn as they do from their own mean pose; none for what suits it.
    pub absolute: Option<bool>,
    /// How many frames to make of key poses; 0 for up to the last key.
    pub frames: u64,
    /// The text of a map.json that says which limb follows what of a motion; empty to match by names.
    pub map: &'a str,
}

impl Creature {
    /// The creature moving from key pose to key pose: the text of a strokes.json.
    pub fn repose(&self, poses: &str, options: &ReposeOptions<'_>) -> Result<Creature> {
        let id = sys::creature_repose(&self.context.0, self.id, poses, options)?;
        Ok(Creature { id, context: self.context.clone() })
    }

    /// The creature moving as a motion does.
    pub fn drive(&self, motion: &Motion, options: &ReposeOptions<'_>) -> Result<Creature> {
        let id = sys::creature_drive(&self.context.0, self.id, motion.id, options)?;
        Ok(Creature { id, context: self.context.clone() })
    }

    /// Which limb follows what of a motion, as the text of a map.json.
    pub fn matched(&self, motion: &Motion, map: &str) -> Result<String> {
        sys::creature_match(&self.context.0, self.id, motion.id, map)
    }

    /// How hard the animation pulls the limbs, as JSON.
    pub fn strain(&self) -> Result<String> {
        sys::creature_strain(&self.context.0, self.id)
    }
}

impl Drop for Creature {
    fn drop(&mut self) {
        sys::creature_destroy(&self.context.0, self.id);
    }
}
