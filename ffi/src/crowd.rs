//! Crowds. Creatures many times over, each instance at its own place, turn, size and moment: drawn into pictures and
//! files, put back into the clip that they were filmed in, or written as one glTF file. Crowds do not change.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use marey::export::gltf::{GltfOptions, crowd_glb, read_creature};
use marey::export::write_aside;
use marey::job::Progress;
use marey::shape::creature;
use marey::shape::crowd::{Crowd as Instances, CrowdFile, Instance};

use crate::border::{self, Out, OutStruct, Versioned};
use crate::context::mry_context;
use crate::creature::mry_creature;
use crate::creature_files::metres;
use crate::error::{Failure, Outcome, mry_error};
use crate::guard::{Call, ending, entry};
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;
use crate::table::Table;

/// An instance's motion starts anew when it has ended.
pub const MRY_PLAY_LOOP: i32 = 0;
/// An instance's motion stays as it ends.
pub const MRY_PLAY_ONCE: i32 = 1;
/// An instance holds the pose of its start.
pub const MRY_PLAY_HOLD: i32 = 2;

/// No crowd has more instances.
const MOST_INSTANCES: usize = 10_000;

/// A crowd, and what is drawn of it.
pub(crate) struct Crowd {
    pub(crate) crowd: Instances,
    scene: OnceLock<marey_render::Scene>,
}

impl Crowd {
    fn new(crowd: Instances) -> Self {
        Self { crowd, scene: OnceLock::new() }
    }

    /// The crowd made ready for drawing.
    pub(crate) fn scene(&self) -> marey::Result<marey_render::Scene> {
        if let Some(scene) = self.scene.get() {
            return Ok(scene.clone());
        }
        let scene = marey_render::Scene::of_crowd(&self.crowd)?;
        Ok(self.scene.get_or_init(|| scene).clone())
    }
}

pub(crate) type CrowdTable = Table<Arc<Crowd>>;

/// A crowd.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct mry_crowd {
    /// The id; 0 is no crowd.
    pub v: u64,
}

/// A creature in a crowd. All zero but for the creature is the creature as it was filmed.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct mry_instance {
    /// The creature.
    pub creature: mry_creature,
    /// Moved by x, y, z, in world units; z below 0 is behind the creature that was filmed.
    pub at: [f32; 3],
    /// Turned about the vertical, in degrees: 90 turns a creature that looks right away from the viewer.
    pub yaw: f32,
    /// Times its size, about the ground below its middle; 0 for 1.
    pub scale: f32,
    /// MRY_PLAY_LOOP, ...
    pub play: i32,
    /// The frame of its motion in the crowd's first frame, whole or not.
    pub start: f64,
    /// Times as fast; 0 for 1, below 0 backwards.
    pub speed: f64,
}
const _: () = assert!(size_of::<mry_instance>() == 48);

impl mry_instance {
    fn read(&self, creature: usize) -> Outcome<Instance> {
        let (looped, held) = match self.play {
            MRY_PLAY_LOOP => (true, false),
            MRY_PLAY_ONCE => (false, false),
            MRY_PLAY_HOLD => (false, true),
            play => return Err(Failure::argument("instances", format!("a play is {play}, which is no MRY_PLAY"))),
        };
        let or_one = |v: f64| if v == 0.0 { 1.0 } else { v };
        Ok(Instance {
            creature,
            at: self.at,
            yaw: self.yaw,
            scale: or_one(f64::from(self.scale)) as f32,
            start: self.start,
            speed: if held { 0.0 } else { or_one(self.speed) },
            looped,
        })
    }
}

/// What a crowd is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct mry_crowd_info {
    /// sizeof(mry_crowd_info).
    pub struct_size: u32,
    /// Pixels across of the clip that it stands in.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// How many different creatures there are.
    pub creature_count: u32,
    /// How many instances there are.
    pub instance_count: u64,
    /// How many frames.
    pub frame_count: u64,
    /// Frames a second.
    pub fps: f64,
}

// SAFETY: repr(C), starts with its u32 size, and holds numbers only.
unsafe impl Versioned for mry_crowd_info {
    const FIRST_SIZE: usize = 40;
}
const _: () = assert!(size_of::<mry_crowd_info>() == 40);

impl Call<'_> {
    pub(crate) fn crowd(&self, crowd: mry_crowd) -> Outcome<Arc<Crowd>> {
        Ok(self.get(&self.context.crowds, crowd.v, "crowd")?.value.clone())
    }

    fn keep_crowd(&self, crowd: Instances) -> Outcome<mry_crowd> {
        Ok(mry_crowd { v: self.context.crowds.insert(Arc::new(Crowd::new(crowd)))? })
    }
}

/// How many frames, as the engine counts them.
fn frames(frame_count: u64) -> usize {
    usize::try_from(frame_count).unwrap_or(usize::MAX)
}

/// Fills in a crowd info with struct_size set and everything else zero, for languages without the INIT macros.
///
/// @param info  Where to write; NULL does nothing.
/// @param size  sizeof(mry_crowd_info) as the caller knows it.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_crowd_info_init(info: *mut mry_crowd_info, size: u32) {
    // SAFETY: the caller owns `size` bytes at `info`, or passes NULL.
    unsafe { border::init(info.cast(), size) }
}

/// Makes a crowd of these instances.
///
/// @param context      The context.
/// @param instances    Who stands where.
/// @param count        How many.
/// @param frame_count  How many frames; 0 for those of the longest creature.
/// @param fps          Frames a second; 0 for those of the first instance's creature.
/// @param out_crowd    The crowd.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (no instance, a place, size or time that is none), MRY_E_ARGUMENT (play),
///         MRY_E_LIMIT.
/// Lifetime: until mry_crowd_destroy or the end of the context; the creatures may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_crowd_create(
    context: *mut mry_context,
    instances: *const mry_instance,
    count: usize,
    frame_count: u64,
    fps: f64,
    out_crowd: *mut mry_crowd,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_crowd, "out_crowd")?;
        let instances = border::slice(instances, count, MOST_INSTANCES, "instances")?;
        let mut ids: Vec<mry_creature> = Vec::new();
        let mut creatures: Vec<Arc<creature::Creature>> = Vec::new();
        let mut placed = Vec::with_capacity(instances.len());
        for instance in instances {
            let known = ids.iter().position(|id| *id == instance.creature);
            let index = match known {
                Some(index) => index,
                None => {
                    creatures
                        .push(call.creature(instance.creature).map_err(|e| e.about("instances"))?.creature.clone());
                    ids.push(instance.creature);
                    ids.len() - 1
                }
            };
            placed.push(instance.read(index)?);
        }
        let first = creatures.first().ok_or_else(|| Failure::argument("count", "a crowd has at least one instance"))?;
        let longest = creatures.iter().map(|c| c.model.animation.len()).max().unwrap_or(0);
        let crowd = Instances {
            size: first.model.size,
            fps: if fps == 0.0 { first.model.fps } else { fps },
            frames: if frame_count == 0 { longest } else { frames(frame_count) },
            instances: placed,
            creatures,
        };
        crowd.validate()?;
        out.set(call.keep_crowd(crowd)?);
        Ok(Code::MRY_OK)
    })
}

/// Makes a herd: a creature many times over, in rows behind one another, each at another moment of its motion.
///
/// @param context      The context.
/// @param creature     The creature.
/// @param count        How many of it.
/// @param frame_count  How many frames; 0 for the creature's.
/// @param out_crowd    The crowd.
/// @param err          Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT (none of it, a creature without frames), MRY_E_LIMIT.
/// Lifetime: until mry_crowd_destroy or the end of the context; the creature may go before.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_crowd_create_herd(
    context: *mut mry_context,
    creature: mry_creature,
    count: u32,
    frame_count: u64,
    out_crowd: *mut mry_crowd,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = Out::new(out_crowd, "out_crowd")?;
        let creature = call.creature(creature)?.creature.clone();
        let count = count as usize;
        if count > MOST_INSTANCES {
            let message = format!("count is {count}, and at most {MOST_INSTANCES} are allowed");
            return Err(Failure::new(Code::MRY_E_LIMIT, "count", message));
        }
        let own = creature.model.animation.len();
        let crowd = Instances::herd(creature, count, if frame_count == 0 { own } else { frames(frame_count) });
        crowd.validate()?;
        out.set(call.keep_crowd(crowd)?);
        Ok(Code::MRY_OK)
    })
}

/// Reads a crowd from a file and opens its creatures:
/// {"format": "marey-crowd", "version": 1, "creatures": ["fox/creature.glb"], "frames": 60, "instances":
/// [{"creature": 0, "at": [120, 0, -80], "yaw": 180, "scale": 0.8, "start": 12, "speed": 1, "loop": true}]}.
/// Paths are relative to the file; size, fps and frames may be left out, and all of an instance but its creature.
///
/// @param context    The context.
/// @param path       The file.
/// @param out_crowd  The crowd.
/// @param err        Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_NO_FILE, MRY_E_IO, MRY_E_INPUT, MRY_E_LIMIT, MRY_E_STRING.
/// Lifetime: until mry_crowd_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_crowd_read(
    context: *mut mry_context,
    path: mry_str,
    out_crowd: *mut mry_crowd,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path = path.name("path")?;
        let out = Out::new(out_crowd, "out_crowd")?;
        let file = CrowdFile::read(path).map_err(|e| Failure::from(e).about("path"))?;
        let creatures =
            file.creatures.iter().map(|path| read_creature(path).map(Arc::new)).collect::<Result<_, _>>()?;
        out.set(call.keep_crowd(file.crowd(creatures).map_err(|e| e.in_file(path))?)?);
        Ok(Code::MRY_OK)
    })
}

/// What a crowd is: counts, frames, rate.
///
/// @param context   The context.
/// @param crowd     The crowd.
/// @param out_info  The answer; its struct_size must be set.
/// @param err       Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_STRUCT_SIZE.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_crowd_get_info(
    context: *mut mry_context,
    crowd: mry_crowd,
    out_info: *mut mry_crowd_info,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let out = OutStruct::new(out_info, "out_info")?;
        let crowd = call.crowd(crowd)?;
        let crowd = &crowd.crowd;
        out.set(&mry_crowd_info {
            struct_size: 0,
            width: crowd.size.0,
            height: crowd.size.1,
            creature_count: crowd.creatures.len() as u32,
            instance_count: crowd.instances.len() as u64,
            frame_count: crowd.frames as u64,
            fps: crowd.fps,
        });
        Ok(Code::MRY_OK)
    })
}

/// Writes a crowd as one glTF 2.0 binary: each creature's meshes and textures once, a skeleton and a stretch of motion
/// for every instance. The file appears whole or not at all.
///
/// @param context  The context.
/// @param crowd    The crowd.
/// @param path     The file, in a folder that exists.
/// @param scale    Metres a world unit; 0 for 1.
/// @param err      Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_IO, MRY_E_INPUT (no place for a file), MRY_E_LIMIT, MRY_E_ARGUMENT, MRY_E_NON_FINITE,
///         MRY_E_STRING.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_crowd_write_glb(
    context: *mut mry_context,
    crowd: mry_crowd,
    path: mry_str,
    scale: f32,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let path: &Path = path.name("path")?.as_ref();
        let mut options = GltfOptions::default();
        options.scale = metres(scale)?;
        let crowd = call.crowd(crowd)?;
        let progress = Progress::new();
        let bytes = call.context.executor.run(|| crowd_glb(&crowd.crowd, &options, progress.whole()))?;
        write_aside(path, &bytes).map_err(|e| Failure::from(e).about("path"))?;
        Ok(Code::MRY_OK)
    })
}

/// Destroys a crowd.
///
/// @param context  The context.
/// @param crowd    The crowd; {0} is no error.
/// @return MRY_OK.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_crowd_destroy(context: *mut mry_context, crowd: mry_crowd) -> mry_status {
    ending!(context, |call| {
        if crowd.v != 0 {
            call.context.crowds.remove(crowd.v, "crowd")?;
        }
        Ok(Code::MRY_OK)
    })
}
