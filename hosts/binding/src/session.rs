//! Sessions: the document that a host edits.

use std::ops::Range;

use marey_ffi::{
    MRY_ACCESS_EDIT, MRY_ACCESS_READ_ONLY, MRY_PAINT_BACKGROUND, MRY_PAINT_FOREGROUND, MRY_PART_BINDING,
    MRY_PART_DRAWING, MRY_PART_JOINTS, MRY_PART_MAP, MRY_PART_MOTION, MRY_PART_NOTES, MRY_PART_PICTURE,
    MRY_PART_POINTS, MRY_PART_SKELETON, mry_clip, mry_motion, mry_point, mry_session, mry_status_code as Code,
};

use crate::{Clip, Context, Error, Facing, Job, LimbDepth, Motion, Result, Rig, Side, sys};

/// A document with unlimited undo. An edit of a session with a file is on the disk before the call returns.
///
/// Dropped without a save, what was done stays in its journal and is there when the file is opened again.
#[derive(Debug)]
pub struct Session {
    id: mry_session,
    context: Context,
}

/// What a session file is opened for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// To be edited; no other program may.
    Edit,
    /// To be read, whoever edits it.
    ReadOnly,
}

/// A file that a session holds whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(i32)]
pub enum Part {
    /// Control points, a points.json.
    Points = MRY_PART_POINTS,
    /// Joints marked in the clip, a joints.json.
    Joints = MRY_PART_JOINTS,
    /// A vector drawing, an SVG.
    Drawing = MRY_PART_DRAWING,
    /// How points hold the drawing, a bind.json.
    Binding = MRY_PART_BINDING,
    /// The picture of a character.
    Picture = MRY_PART_PICTURE,
    /// A character's mesh and skeleton, a rig.json.
    Skeleton = MRY_PART_SKELETON,
    /// The motion that moves a character, a motion.json.
    Motion = MRY_PART_MOTION,
    /// Which joint follows what, a map.json.
    Map = MRY_PART_MAP,
    /// Text of the host's own.
    Notes = MRY_PART_NOTES,
}

/// How a session is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionState {
    /// Whether the file lacks anything that the session has.
    pub modified: bool,
    /// Whether it can only be read.
    pub read_only: bool,
    /// Whether the user never gave it a name.
    pub untitled: bool,
    /// Whether a gesture is in progress.
    pub in_gesture: bool,
    /// Whether there is a clip.
    pub has_clip: bool,
    /// Whether there is a motion.
    pub has_motion: bool,
    /// Whether a limb is to be tracked, for the first time or again.
    pub motion_outdated: bool,
    /// Whether a creature is to be made, for the first time or again.
    pub creature_outdated: bool,
    /// How many gestures that were never saved opening it brought back.
    pub recovered: u64,
    /// How many gestures were finished since it was made.
    pub gestures: u64,
    /// Rises with every change.
    pub revision: u64,
    /// Whether a save puts the clip and the painted masks into the file.
    pub embedded: bool,
}

impl Context {
    /// An empty session in a new file, or in memory only where the path is empty.
    pub fn new_session(&self, path: &str) -> Result<Session> {
        Ok(Session { id: sys::session_create(&self.0, path)?, context: self.clone() })
    }

    /// An empty session that the user has not named yet, kept in `folder` so that a crash does not lose it.
    pub fn new_untitled_session(&self, folder: &str) -> Result<Session> {
        Ok(Session { id: sys::session_create_untitled(&self.0, folder)?, context: self.clone() })
    }

    /// The sessions without a name that a crash left in `folder`.
    pub fn sessions_left_in(&self, folder: &str) -> Result<Vec<String>> {
        (0..).map_while(|index| found(sys::session_find_left(&self.0, folder, index)).transpose()).collect()
    }

    /// Opens a session file, with every gesture that was finished since its last save.
    pub fn open_session(&self, path: &str, access: Access) -> Result<Session> {
        let access = if access == Access::Edit { MRY_ACCESS_EDIT } else { MRY_ACCESS_READ_ONLY };
        Ok(Session { id: sys::session_open(&self.0, path, access)?, context: self.clone() })
    }
}

impl Context {
    /// Plays a recording: the session that its first `most` gestures lead to, kept in memory only.
    pub fn replay(&self, path: &str, most: u64) -> Result<Session> {
        Ok(Session { id: sys::session_replay(&self.0, path, most)?, context: self.clone() })
    }
}

/// A fair question may have no answer.
pub(crate) fn found<T>(answer: Result<T>) -> Result<Option<T>> {
    match answer {
        Ok(answer) => Ok(Some(answer)),
        Err(e) if e.code() == Code::MRY_E_NOT_FOUND as i32 => Ok(None),
        Err(e) => Err(e),
    }
}

fn points_of(points: &[(f32, f32)]) -> Vec<mry_point> {
    points.iter().map(|&(x, y)| mry_point { x, y }).collect()
}

impl Session {
    /// Drops what was not saved; the file is as it was saved last.
    pub fn discard(self) -> Result<()> {
        sys::session_discard(&self.context.0, self.id)
    }

    /// Lets saves put the clip and the painted masks into the file, or refer to them.
    pub fn set_embedded(&self, embedded: bool) -> Result<()> {
        sys::session_set_embedded(&self.context.0, self.id, embedded)
    }

    /// Begins a recording of its gestures in a file that does not exist.
    pub fn start_recording(&self, path: &str) -> Result<()> {
        sys::session_start_recording(&self.context.0, self.id, path)
    }

    /// Ends the recording.
    pub fn stop_recording(&self) -> Result<()> {
        sys::session_stop_recording(&self.context.0, self.id)
    }

    /// A number that is the same for what is alike to the last bit, on any machine.
    pub fn fingerprint(&self) -> Result<u64> {
        sys::session_fingerprint(&self.context.0, self.id)
    }

    /// Saves it to its file, whole or not at all.
    pub fn save(&self) -> Result<()> {
        sys::session_save(&self.context.0, self.id)
    }

    /// Saves it under another name and goes on there.
    pub fn save_as(&self, path: &str) -> Result<()> {
        sys::session_save_as(&self.context.0, self.id, path)
    }

    /// How it is.
    pub fn state(&self) -> Result<SessionState> {
        let state = sys::session_state(&self.context.0, self.id)?;
        Ok(SessionState {
            modified: state.modified != 0,
            read_only: state.read_only != 0,
            untitled: state.untitled != 0,
            in_gesture: state.in_gesture != 0,
            has_clip: state.has_clip != 0,
            has_motion: state.has_motion != 0,
            motion_outdated: state.motion_outdated != 0,
            creature_outdated: state.creature_outdated != 0,
            recovered: state.recovered_count,
            gestures: state.gesture_count,
            revision: state.revision,
            embedded: state.embedded == 1,
        })
    }

    /// Where it is kept; [`None`] for memory.
    pub fn path(&self) -> Result<Option<String>> {
        found(sys::session_path(&self.context.0, self.id))
    }

    /// What opening it found damaged, lost or not there, a sentence each.
    pub fn warnings(&self) -> Result<Vec<String>> {
        let count = sys::session_state(&self.context.0, self.id)?.warning_count;
        (0..count).map(|index| sys::session_warning(&self.context.0, self.id, index)).collect()
    }

    /// Begins a gesture: the edits until its end are one step of undo.
    pub fn begin_gesture(&self, label: &str) -> Result<()> {
        sys::session_begin_gesture(&self.context.0, self.id, label)
    }

    /// Ends the gesture.
    pub fn end_gesture(&self) -> Result<()> {
        sys::session_end_gesture(&self.context.0, self.id)
    }

    /// Takes the gesture in progress back.
    pub fn cancel_gesture(&self) -> Result<()> {
        sys::session_cancel_gesture(&self.context.0, self.id)
    }

    /// Takes the last step back; false where there is none.
    pub fn undo(&self) -> Result<bool> {
        Ok(found(sys::session_undo(&self.context.0, self.id))?.is_some())
    }

    /// Does the last step that was taken back again; false where there is none.
    pub fn redo(&self) -> Result<bool> {
        Ok(found(sys::session_redo(&self.context.0, self.id))?.is_some())
    }

    /// What [`Self::undo`] would take back.
    pub fn undo_label(&self) -> Result<Option<String>> {
        found(sys::session_undo_label(&self.context.0, self.id))
    }

    /// What [`Self::redo`] would do again.
    pub fn redo_label(&self) -> Result<Option<String>> {
        found(sys::session_redo_label(&self.context.0, self.id))
    }

    /// Chooses the clip, by reference, or none.
    pub fn set_clip(&self, clip: Option<&Clip>) -> Result<()> {
        sys::session_set_clip(&self.context.0, self.id, clip.map_or(mry_clip::default(), |c| c.id))
    }

    /// The clip, opened; [`None`] where none is chosen.
    pub fn clip(&self) -> Result<Option<Clip>> {
        let clip = found(sys::session_clip(&self.context.0, self.id))?;
        Ok(clip.map(|id| Clip { id, context: self.context.clone() }))
    }

    /// Sets a part by the bytes of its file, or takes it away.
    pub fn set_part(&self, part: Part, bytes: Option<&[u8]>) -> Result<()> {
        sys::session_set_part(&self.context.0, self.id, part as i32, bytes.unwrap_or_default())
    }

    /// A part, as the bytes of its file; [`None`] where it has none.
    pub fn part(&self, part: Part) -> Result<Option<Vec<u8>>> {
        found(sys::session_part(&self.context.0, self.id, part as i32))
    }

    /// Replaces everything that is drawn by a copy of `rig`.
    pub fn set_rig(&self, rig: &Rig) -> Result<()> {
        sys::session_set_rig(&self.context.0, self.id, rig.id)
    }

    /// A copy of what is drawn.
    pub fn rig(&self) -> Result<Rig> {
        Ok(Rig { id: sys::session_rig(&self.context.0, self.id)?, context: self.context.clone() })
    }

    /// Takes in a motion as if it had been tracked from what is drawn now, or takes the motion away.
    pub fn set_motion(&self, motion: Option<&Motion>) -> Result<()> {
        sys::session_set_motion(&self.context.0, self.id, motion.map_or(mry_motion::default(), |m| m.id))
    }

    /// The motion, up to date or not; [`None`] before the first.
    pub fn motion(&self) -> Result<Option<Motion>> {
        let motion = found(sys::session_motion(&self.context.0, self.id))?;
        Ok(motion.map(|id| Motion { id, context: self.context.clone() }))
    }

    /// Chooses the text of a parameter, such as `track.plugin`; empty for the default.
    pub fn set_text(&self, name: &str, text: &str) -> Result<()> {
        sys::session_set_text(&self.context.0, self.id, name, text)
    }

    /// The text of a parameter, chosen or by default.
    pub fn text(&self, name: &str) -> Result<String> {
        sys::session_text(&self.context.0, self.id, name)
    }

    /// Adds a limb behind the others; gives its index.
    pub fn add_limb(&self, label: &str, side: Side) -> Result<u32> {
        sys::session_add_limb(&self.context.0, self.id, label, side.code())
    }

    /// Removes a limb with its strokes.
    pub fn remove_limb(&self, limb: u32) -> Result<()> {
        sys::session_remove_limb(&self.context.0, self.id, limb)
    }

    /// Gives a limb another label and side.
    pub fn set_limb(&self, limb: u32, label: &str, side: Side) -> Result<()> {
        sys::session_set_limb(&self.context.0, self.id, limb, label, side.code())
    }

    /// Draws a limb on a frame, in clip pixels, instead of what was drawn of it there before.
    pub fn set_stroke(&self, limb: u32, frame: u64, points: &[(f32, f32)], facing: Facing) -> Result<()> {
        sys::session_set_stroke(&self.context.0, self.id, (limb, frame), &points_of(points), facing.code())
    }

    /// Says where a limb is in depth on a frame; with nothing said, takes back what was. It need not be drawn there.
    pub fn set_depth(&self, limb: u32, frame: u64, depth: LimbDepth) -> Result<()> {
        sys::session_set_depth(&self.context.0, self.id, (limb, frame), depth.code())
    }

    /// Takes a limb's stroke off a frame.
    pub fn remove_stroke(&self, limb: u32, frame: u64) -> Result<()> {
        sys::session_remove_stroke(&self.context.0, self.id, limb, frame)
    }

    /// Paints a hint for the segmenter: what is along the path is the creature's, or is not.
    pub fn add_paint(&self, frame: u64, creature: bool, radius: f32, points: &[(f32, f32)]) -> Result<()> {
        let kind = if creature { MRY_PAINT_FOREGROUND } else { MRY_PAINT_BACKGROUND };
        sys::session_add_paint(&self.context.0, self.id, (frame, kind, radius), &points_of(points))
    }

    /// Removes a painted hint of a frame.
    pub fn remove_paint(&self, frame: u64, index: u32) -> Result<()> {
        sys::session_remove_paint(&self.context.0, self.id, frame, index)
    }

    /// Gives a frame a painted mask, by the path of an image; empty to take it off.
    pub fn set_mask(&self, frame: u64, path: &str) -> Result<()> {
        sys::session_set_mask(&self.context.0, self.id, frame, path)
    }

    /// Chooses the value of a parameter, or [`None`] for its default.
    pub fn set_parameter(&self, name: &str, value: Option<f64>) -> Result<()> {
        match value {
            Some(value) => sys::session_set_parameter(&self.context.0, self.id, name, value),
            None => sys::session_reset_parameter(&self.context.0, self.id, name),
        }
    }

    /// The value of a parameter, chosen or by default.
    pub fn parameter(&self, name: &str) -> Result<f64> {
        sys::session_parameter(&self.context.0, self.id, name)
    }

    /// Starts tracking it as it is now.
    pub fn start_track(&self) -> Result<Job> {
        Ok(Job { id: sys::session_start_track(&self.context.0, self.id)?, context: self.context.clone() })
    }

    /// Starts making its creature as it is now, and writing it into `folder` unless that is empty.
    pub fn start_creature(&self, folder: &str) -> Result<Job> {
        Ok(Job { id: sys::session_start_creature(&self.context.0, self.id, folder)?, context: self.context.clone() })
    }

    /// Takes in what a job of this session made, as one step of undo; once. False when the job has not ended.
    ///
    /// # Errors
    /// What the job failed with, a cancel too.
    pub fn take(&self, job: &Job) -> Result<bool> {
        match sys::session_take(&self.context.0, self.id, job.id)? {
            code if code == Code::MRY_OK as i32 => Ok(true),
            code if code == Code::MRY_PENDING as i32 => Ok(false),
            code => Err(Error::new(code, "cancelled".into(), String::new())),
        }
    }

    /// The frames in which a limb is to be tracked, for the first time or again.
    pub fn outdated(&self, limb: u32) -> Result<Vec<Range<u64>>> {
        let ranges = sys::session_outdated(&self.context.0, self.id, limb)?;
        Ok(ranges.iter().map(|r| r.first..r.first + r.count).collect())
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        sys::session_destroy(&self.context.0, self.id);
    }
}
