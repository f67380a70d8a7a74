//! The document: a session of the library, and what it holds as panels need it.
//!
//! Every edit is one gesture of the session, which undoes it and keeps it through a crash. After each the copies here are
//! read anew; panels never change them. All calls come from the window's thread: a session serves one thread at a time.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use marey_binding::{
    Clip, ClipInfo, Context, Correction, Facing, Job, LimbDepth, Motion, Part, Result, Session, SessionState, Side,
    Stroke, TrackFrame,
};

use serde::{Deserialize, Serialize};

use crate::brush::Painted;
use crate::marks::Marks;
use crate::notes::Notes;
use crate::overlaps::Said;
use crate::solved::Stamp;
use crate::texts;

/// What is made of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Door {
    #[default]
    Creature,
    Character,
    Drawing,
}

/// Parts with their bytes, or none to take one away.
pub(crate) type Parts<'a> = &'a [(Part, Option<&'a [u8]>)];

/// What a plugin can do in the place of what is built in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    Track,
    Segment,
}

impl Step {
    fn parameter(self) -> &'static str {
        match self {
            Self::Track => "track.plugin",
            Self::Segment => "segment.plugin",
        }
    }
}

/// A limb as the session names it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Limb {
    pub(crate) label: String,
    pub(crate) side: Side,
    /// The longest drawn length, in clip pixels; 0 where it is not drawn.
    pub(crate) length: f32,
}

/// The limbs over time.
#[derive(Debug)]
pub(crate) struct Tracked {
    /// By limb, then by frame; a limb that was not tracked has no frames.
    pub(crate) limbs: Vec<Vec<TrackFrame>>,
    /// What is worth drawing next, the most helpful first.
    pub(crate) corrections: Vec<Correction>,
    /// Left, top, right, bottom of all places, in clip pixels.
    pub(crate) bounds: [f32; 4],
}

impl Tracked {
    /// What is worth correcting next: the most helpful place, or where that is shown already, the one after it.
    pub(crate) fn next_correction(&self, shown: (Option<usize>, u64)) -> Option<Correction> {
        let is_shown = |c: &Correction| (Some(c.track as usize), c.frame) == shown;
        let next = self.corrections.iter().position(is_shown).map_or(0, |at| at + 1);
        self.corrections.get(next).or(self.corrections.first()).copied()
    }
}

#[derive(Debug)]
pub(crate) struct Document {
    session: Session,
    pub(crate) title: String,
    pub(crate) clip: Option<(Arc<Clip>, ClipInfo)>,
    pub(crate) limbs: Vec<Limb>,
    /// Frames that are drawn on, rising.
    pub(crate) keys: Vec<u64>,
    strokes: HashMap<(usize, u64), Stroke>,
    /// What is said of limbs' depth, by limb and frame.
    depths: HashMap<(usize, u64), LimbDepth>,
    /// By frame.
    painted: HashMap<u64, Vec<Painted>>,
    pub(crate) tracked: Option<Tracked>,
    /// The points that are marked in the clip.
    pub(crate) marks: Marks,
    /// What the studio itself keeps in the session.
    pub(crate) notes: Notes,
    /// The other parts, as far as there are.
    parts: HashMap<Part, Arc<Vec<u8>>>,
    pub(crate) state: SessionState,
    pub(crate) undo: Option<String>,
    pub(crate) redo: Option<String>,
    /// The ids of the plugins that track and segment; empty for what is built in.
    methods: [String; 2],
    pub(crate) worked_on: bool,
}

impl Document {
    /// A new session without a name, with a clip and perhaps strokes. Reads all of the clip.
    pub(crate) fn of_clip(context: &Context, unsaved: &Path, path: &str, strokes: Option<&str>) -> Result<Self> {
        let clip = context.open_clip(path)?;
        let rig = strokes.map(|text| context.rig_from_json(text)).transpose()?;
        let session = context.new_untitled_session(&unsaved.to_string_lossy())?;
        let set_up = || {
            session.begin_gesture(texts::EDIT_OPEN)?;
            session.set_clip(Some(&clip))?;
            rig.map(|rig| session.set_rig(&rig)).transpose()?;
            session.end_gesture()
        };
        match set_up() {
            Ok(()) => Self::of(session, &stem(path)),
            Err(e) => {
                session.discard()?;
                Err(e)
            }
        }
    }

    /// A new session without a name for another door, with a clip and parts.
    pub(crate) fn of_parts(
        context: &Context,
        unsaved: &Path,
        door: Door,
        title: &str,
        clip: Option<&str>,
        parts: Parts<'_>,
    ) -> Result<Self> {
        let clip = clip.map(|path| context.open_clip(path)).transpose()?;
        let of = |wanted: Part| parts.iter().find(|(part, _)| *part == wanted).and_then(|(_, bytes)| *bytes);
        let solved = match (of(Part::Points), of(Part::Motion), &clip) {
            (Some(points), Some(_), Some(clip)) => Some(Stamp::new(points, &clip.info()?)),
            _ => None,
        };
        let notes = Notes { door, solved, ..Notes::default() }.bytes();
        let session = context.new_untitled_session(&unsaved.to_string_lossy())?;
        let set_up = || {
            session.begin_gesture(texts::EDIT_OPEN)?;
            if clip.is_some() {
                session.set_clip(clip.as_ref())?;
            }
            session.set_part(Part::Notes, Some(&notes))?;
            parts.iter().try_for_each(|(part, bytes)| session.set_part(*part, *bytes))?;
            session.end_gesture()
        };
        match set_up() {
            Ok(()) => Self::of(session, title),
            Err(e) => {
                session.discard()?;
                Err(e)
            }
        }
    }

    /// A session as it is.
    pub(crate) fn of(session: Session, title: &str) -> Result<Self> {
        let state = session.state()?;
        let mut document = Self {
            session,
            title: title.to_owned(),
            clip: None,
            limbs: Vec::new(),
            keys: Vec::new(),
            strokes: HashMap::new(),
            depths: HashMap::new(),
            painted: HashMap::new(),
            tracked: None,
            marks: Marks::new((1, 1)),
            notes: Notes::default(),
            parts: HashMap::new(),
            state,
            undo: None,
            redo: None,
            methods: Default::default(),
            worked_on: false,
        };
        document.refresh(true)?;
        Ok(document)
    }

    /// What opening it found damaged, lost or not there.
    pub(crate) fn warnings(&self) -> Result<Vec<String>> {
        self.session.warnings()
    }

    pub(crate) fn frames(&self) -> u64 {
        self.clip.as_ref().map_or(0, |(_, info)| info.frames)
    }

    /// Where it is kept under a name of the user's.
    pub(crate) fn named_path(&self) -> Option<PathBuf> {
        if self.state.untitled {
            return None;
        }
        self.session.path().ok().flatten().map(PathBuf::from)
    }

    /// Where it is kept, named or not.
    pub(crate) fn path(&self) -> Option<PathBuf> {
        self.session.path().ok().flatten().map(PathBuf::from)
    }

    pub(crate) fn stroke(&self, limb: usize, frame: u64) -> Option<&Stroke> {
        self.strokes.get(&(limb, frame))
    }

    /// The strokes of a frame, by limb.
    pub(crate) fn strokes_on(&self, frame: u64) -> impl Iterator<Item = (usize, &Stroke)> {
        (0..self.limbs.len()).filter_map(move |limb| Some((limb, self.stroke(limb, frame)?)))
    }

    /// What is said of a limb's depth on a frame.
    pub(crate) fn depth(&self, limb: usize, frame: u64) -> LimbDepth {
        self.depths.get(&(limb, frame)).copied().unwrap_or_default()
    }

    /// What is said of all limbs' depth.
    pub(crate) fn depths_said(&self) -> Said {
        let keys = |limb: usize| {
            let key = |frame: &u64| {
                let said = self.depth(limb, *frame).depth;
                (said.is_some() || self.stroke(limb, *frame).is_some()).then_some((*frame, said))
            };
            self.keys.iter().filter_map(key).collect()
        };
        self.limbs.iter().enumerate().map(|(limb, l)| (l.label.clone(), keys(limb))).collect()
    }

    /// The hints that are painted on a frame.
    pub(crate) fn painted(&self, frame: u64) -> &[Painted] {
        self.painted.get(&frame).map_or(&[], |hints| hints)
    }

    /// Whether a person did something to it, beyond opening it and looking at what is made of it.
    pub(crate) fn is_worked_on(&self) -> bool {
        self.worked_on || self.state.recovered > 0
    }

    /// What undo takes back. Opening the clip is not taken back: it would leave nothing to go on with.
    pub(crate) fn undo(&self) -> Option<&str> {
        self.undo.as_deref().filter(|label| *label != texts::EDIT_OPEN)
    }

    /// Takes one step back, and with it what followed from it by itself.
    pub(crate) fn undo_one(&mut self) -> Result<()> {
        if self.undo().is_some() {
            while self.session.undo_label()?.is_some_and(|label| label.ends_with(texts::EDIT_FOLLOWED)) {
                self.session.undo()?;
            }
            self.forget_clip(self.session.undo_label()?);
            self.session.undo()?;
        }
        self.refresh(true)
    }

    /// Another clip may be there after this step.
    fn forget_clip(&mut self, step: Option<String>) {
        if step.is_some_and(|step| [texts::EDIT_CLIP, texts::EDIT_MOTION].contains(&&*step)) {
            self.clip = None;
        }
    }

    pub(crate) fn redo_one(&mut self) -> Result<()> {
        self.forget_clip(self.session.redo_label()?);
        self.session.redo()?;
        while self.session.redo_label()?.is_some_and(|label| label.ends_with(texts::EDIT_FOLLOWED)) {
            self.session.redo()?;
        }
        self.refresh(true)
    }

    /// A number that is the same for what is alike to the last bit.
    pub(crate) fn fingerprint(&self) -> Result<u64> {
        self.session.fingerprint()
    }

    pub(crate) fn save(&mut self) -> Result<()> {
        self.session.save()?;
        self.refresh(false)
    }

    pub(crate) fn save_as(&mut self, path: &Path) -> Result<()> {
        let path = path.to_string_lossy();
        self.session.save_as(&path)?;
        self.title = stem(&path);
        self.refresh(false)
    }

    /// Drops everything of it that was not saved.
    pub(crate) fn discard(self) -> Result<()> {
        self.session.discard()
    }

    /// Adds a limb with its first stroke; gives its index.
    pub(crate) fn add_limb(&mut self, frame: u64, points: &[(f32, f32)]) -> Result<usize> {
        let label = self.free_label();
        let limb = self.edit(texts::EDIT_ADD_LIMB, |session| {
            let limb = session.add_limb(&label, Side::Unknown)?;
            session.set_stroke(limb, frame, points, Facing::Unknown)?;
            Ok(limb)
        })?;
        Ok(limb as usize)
    }

    /// Draws a limb on a frame, instead of what was drawn of it there.
    pub(crate) fn draw(&mut self, limb: usize, frame: u64, points: &[(f32, f32)]) -> Result<()> {
        let facing = self.stroke(limb, frame).map_or(Facing::Unknown, |s| s.facing);
        self.edit(texts::EDIT_DRAW, |session| session.set_stroke(limb as u32, frame, points, facing))
    }

    /// Paints a hint on a frame.
    pub(crate) fn paint(&mut self, frame: u64, hint: &Painted) -> Result<()> {
        let Painted { creature, radius, points } = hint;
        self.edit(texts::EDIT_PAINT, |session| session.add_paint(frame, *creature, *radius, points))
    }

    /// Takes all hints off a frame.
    pub(crate) fn remove_paint(&mut self, frame: u64) -> Result<()> {
        let count = self.painted(frame).len() as u32;
        let remove = |session: &Session| (0..count).rev().try_for_each(|index| session.remove_paint(frame, index));
        self.edit(texts::EDIT_REMOVE_PAINT, remove)
    }

    pub(crate) fn set_facing(&mut self, limb: usize, frame: u64, facing: Facing) -> Result<()> {
        let Some(points) = self.stroke(limb, frame).map(|s| s.points.clone()) else { return Ok(()) };
        self.edit(texts::EDIT_FACING, |session| session.set_stroke(limb as u32, frame, &points, facing))
    }

    /// Says how deep limbs are on a frame, or no longer.
    pub(crate) fn set_depths(&mut self, frame: u64, said: &[(usize, Option<f32>)]) -> Result<()> {
        let said: Vec<(u32, LimbDepth)> = said
            .iter()
            .map(|(limb, depth)| (*limb as u32, LimbDepth { depth: *depth, ..self.depth(*limb, frame) }))
            .collect();
        self.edit(texts::EDIT_ORDER, |session| {
            said.iter().try_for_each(|(limb, depth)| session.set_depth(*limb, frame, *depth))
        })
    }

    pub(crate) fn remove_stroke(&mut self, limb: usize, frame: u64) -> Result<()> {
        self.edit(texts::EDIT_REMOVE_STROKE, |session| session.remove_stroke(limb as u32, frame))
    }

    pub(crate) fn remove_limb(&mut self, limb: usize) -> Result<()> {
        self.edit(texts::EDIT_REMOVE_LIMB, |session| session.remove_limb(limb as u32))
    }

    pub(crate) fn set_limb(&mut self, limb: usize, label: &str, side: Side) -> Result<()> {
        self.edit(texts::EDIT_NAME_LIMB, |session| session.set_limb(limb as u32, label, side))
    }

    /// Replaces everything that is drawn by a strokes.json.
    pub(crate) fn take_strokes(&mut self, context: &Context, path: &str) -> Result<()> {
        let rig = context.read_rig(path)?;
        self.edit(texts::EDIT_TAKE_STROKES, |session| session.set_rig(&rig))
    }

    /// Moves all that is drawn on a frame to another; what was drawn there is replaced.
    pub(crate) fn move_key(&mut self, from: u64, to: u64) -> Result<()> {
        let strokes: Vec<(usize, Stroke)> = self.strokes_on(from).map(|(limb, s)| (limb, s.clone())).collect();
        let depths: Vec<(u32, LimbDepth)> = (0..self.limbs.len())
            .map(|limb| (limb as u32, self.depth(limb, from)))
            .filter(|(_, depth)| *depth != LimbDepth::default())
            .collect();
        self.edit(texts::EDIT_MOVE_KEY, |session| {
            for (limb, depth) in &depths {
                session.set_depth(*limb, from, LimbDepth::default())?;
                session.set_depth(*limb, to, *depth)?;
            }
            for (limb, stroke) in &strokes {
                session.remove_stroke(*limb as u32, from)?;
                session.set_stroke(*limb as u32, to, &stroke.points, stroke.facing)?;
            }
            Ok(())
        })
    }

    /// The bytes of a part.
    pub(crate) fn part(&self, part: Part) -> Option<&Arc<Vec<u8>>> {
        self.parts.get(&part)
    }

    /// The text of a part.
    pub(crate) fn text(&self, part: Part) -> Option<&str> {
        std::str::from_utf8(self.part(part)?).ok()
    }

    /// Sets parts, one step of undo.
    pub(crate) fn set_parts(&mut self, label: &str, parts: Parts<'_>) -> Result<()> {
        self.edit(label, |session| parts.iter().try_for_each(|(part, bytes)| session.set_part(*part, *bytes)))
    }

    /// Chooses the clip, or none, with parts that go with it; one step of undo.
    pub(crate) fn set_clip(&mut self, label: &str, clip: Option<&Clip>, parts: Parts<'_>) -> Result<()> {
        let there = self.state.has_clip;
        // It is opened anew by whoever reads the session.
        self.clip = None;
        self.edit(label, |session| {
            if clip.is_some() || there {
                session.set_clip(clip)?;
            }
            parts.iter().try_for_each(|(part, bytes)| session.set_part(*part, *bytes))
        })
    }

    /// Takes in where the marked points go; with what is worth correcting, by name and frame.
    pub(crate) fn take_points(&mut self, motion: Option<&Motion>, next: &[(String, u64, f32)]) -> Result<()> {
        self.tracked = None;
        let Some(motion) = motion else { return Ok(()) };
        let point = |p: &crate::marks::Mark| Limb { label: p.name.clone(), side: Side::Unknown, length: 0.0 };
        let points: Vec<Limb> = self.marks.points.iter().map(point).collect();
        let mut tracked = tracked(motion, &points)?;
        let index = |name: &str| points.iter().position(|p| p.label == name);
        let correction = |(name, frame, confidence): &(String, u64, f32)| {
            Some(Correction { track: index(name)? as u32, frame: *frame, confidence: *confidence })
        };
        tracked.corrections = next.iter().filter_map(correction).collect();
        self.tracked = Some(tracked);
        Ok(())
    }

    /// The plugin that does a step, by its id; empty for what is built in.
    pub(crate) fn method(&self, step: Step) -> &str {
        &self.methods[step as usize]
    }

    pub(crate) fn set_method(&mut self, step: Step, id: &str) -> Result<()> {
        self.edit(texts::EDIT_METHOD, |session| session.set_text(step.parameter(), id))
    }

    pub(crate) fn start_creature(&self) -> Result<Job> {
        self.session.start_creature("")
    }

    pub(crate) fn start_track(&self) -> Result<Job> {
        self.session.start_track()
    }

    /// Takes in what a job of this session made: a step of its own, or a part of the last one where nobody asked for it.
    pub(crate) fn take(&mut self, job: &Job, asked: bool) -> Result<()> {
        let followed = || self.undo.as_deref().map(|last| format!("{last}{}", texts::EDIT_FOLLOWED));
        let label = if asked { None } else { followed() };
        self.session.begin_gesture(label.as_deref().unwrap_or(texts::EDIT_MAKE))?;
        let taken = self.session.take(job).and_then(|_| self.session.end_gesture());
        if taken.is_err() {
            // What failed is said; that nothing of it stays is all there is to do about it.
            let _ = self.session.cancel_gesture();
        }
        self.refresh(true)?;
        taken
    }

    /// One step of undo, or nothing.
    fn edit<T>(&mut self, label: &str, edit: impl FnOnce(&Session) -> Result<T>) -> Result<T> {
        self.session.begin_gesture(label)?;
        self.worked_on = true;
        let edited = edit(&self.session).and_then(|value| self.session.end_gesture().map(|()| value));
        if edited.is_err() {
            // What failed is said; that nothing of it stays is all there is to do about it.
            let _ = self.session.cancel_gesture();
        }
        self.refresh(false)?;
        edited
    }

    /// Reads the session anew. The motion is large, and changes with few of the edits.
    fn refresh(&mut self, motion: bool) -> Result<()> {
        let session = &self.session;
        self.state = session.state()?;
        let undo = session.undo_label()?;
        self.undo = undo.map(|label| label.strip_suffix(texts::EDIT_FOLLOWED).unwrap_or(&label).to_owned());
        self.redo = session.redo_label()?;
        if self.state.has_clip != self.clip.is_some() {
            // A clip that cannot be found any more is said by a warning, and strokes are still worth having.
            self.clip = match session.clip() {
                Ok(Some(clip)) => clip.info().ok().map(|info| (Arc::new(clip), info)),
                _ => None,
            };
        }
        for step in [Step::Track, Step::Segment] {
            self.methods[step as usize] = session.text(step.parameter())?;
        }
        self.refresh_parts()?;
        let session = &self.session;
        let rig = session.rig()?;
        self.limbs.clear();
        for (index, limb) in rig.limbs()?.into_iter().enumerate() {
            let length = rig.length_hint(index as u32)?;
            self.limbs.push(Limb { label: limb.label, side: limb.side, length });
        }
        if self.door() != Door::Creature {
            // What is tracked there is the door's to say.
            self.keys = self.marks.frames();
            return Ok(());
        }
        self.keys = rig.key_frames()?;
        self.strokes.clear();
        self.depths.clear();
        for frame in &self.keys {
            for limb in 0..self.limbs.len() {
                let depth = rig.depth(limb as u32, *frame)?;
                if depth != LimbDepth::default() {
                    self.depths.insert((limb, *frame), depth);
                }
                if let Some(stroke) = rig.stroke(limb as u32, *frame)? {
                    self.strokes.insert((limb, *frame), stroke);
                }
            }
        }
        self.painted = painted(&rig.to_json()?);
        if motion {
            self.tracked = session.motion()?.map(|motion| tracked(&motion, &self.limbs)).transpose()?;
        }
        if let Some(tracked) = &mut self.tracked {
            // Limbs that were added or named since were not tracked.
            tracked.limbs.resize_with(self.limbs.len(), Vec::new);
            if let Some(motion) = session.motion()? {
                // Limbs that the motion does not know have no advice; that is no reason to refuse an edit.
                tracked.corrections = motion.corrections(Some(&rig)).unwrap_or_default();
            }
        }
        Ok(())
    }

    /// Reads the parts anew.
    fn refresh_parts(&mut self) -> Result<()> {
        const ALL: [Part; 9] = [
            Part::Points,
            Part::Joints,
            Part::Drawing,
            Part::Binding,
            Part::Picture,
            Part::Skeleton,
            Part::Motion,
            Part::Map,
            Part::Notes,
        ];
        for part in ALL {
            match self.session.part(part)? {
                None => drop(self.parts.remove(&part)),
                // What is as it was stays the same to whoever holds it.
                Some(bytes) if self.parts.get(&part).is_some_and(|held| **held == bytes) => {}
                Some(bytes) => drop(self.parts.insert(part, Arc::new(bytes))),
            }
        }
        let size = self.clip.as_ref().map_or((1, 1), |(_, info)| (info.width, info.height));
        let read = self.part(Part::Points).and_then(|bytes| Marks::parse(bytes));
        self.marks = read.unwrap_or_else(|| Marks::new(size));
        // They are asked for with every picture of the window.
        self.notes = Notes::parse(self.part(Part::Notes));
        Ok(())
    }

    fn free_label(&self) -> String {
        let taken = |label: &str| self.limbs.iter().any(|l| l.label == label);
        (1..).map(texts::limb_label).find(|label| !taken(label)).unwrap_or_default()
    }
}

fn tracked(motion: &Motion, limbs: &[Limb]) -> Result<Tracked> {
    let info = motion.info()?;
    let mut bounds = [f32::INFINITY, f32::INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY];
    let of = |limb: &Limb| {
        let Some(track) = info.tracks.iter().position(|name| *name == limb.label) else { return Ok(Vec::new()) };
        (0..info.frames).map(|frame| motion.frame(track as u32, frame)).collect::<Result<Vec<_>>>()
    };
    let limbs: Vec<Vec<TrackFrame>> = limbs.iter().map(of).collect::<Result<_>>()?;
    for (x, y) in limbs.iter().flatten().flat_map(|frame| &frame.points) {
        bounds = [bounds[0].min(*x), bounds[1].min(*y), bounds[2].max(*x), bounds[3].max(*y)];
    }
    Ok(Tracked { limbs, corrections: Vec::new(), bounds })
}

/// The hints of a strokes.json, which is the only place that tells of them.
fn painted(json: &str) -> HashMap<u64, Vec<Painted>> {
    let read: Strokes = serde_json::from_str(json).unwrap_or_default();
    let hint =
        |hint: PaintEntry| Painted { creature: hint.kind == "foreground", radius: hint.radius, points: hint.points };
    let of = |key: KeyEntry| (key.frame, key.paint.into_iter().map(hint).collect());
    read.keyframes.into_iter().filter(|key| !key.paint.is_empty()).map(of).collect()
}

#[derive(Default, Deserialize)]
struct Strokes {
    keyframes: Vec<KeyEntry>,
}

#[derive(Deserialize)]
struct KeyEntry {
    frame: u64,
    #[serde(default)]
    paint: Vec<PaintEntry>,
}

#[derive(Deserialize)]
struct PaintEntry {
    kind: String,
    radius: f32,
    points: Vec<(f32, f32)>,
}

/// What a file is called for a person.
pub(crate) fn stem(path: &str) -> String {
    Path::new(path).file_stem().map_or_else(|| path.to_owned(), |name| name.to_string_lossy().into_owned())
}
