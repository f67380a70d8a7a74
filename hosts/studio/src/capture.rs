//! The motion of a character taken from a clip: its joints are marked on the clip, followed, and move it.
//!
//! A mark is a point with a joint's name, and equal numbers are on the drawing; joints that cannot be seen are left out,
//! and the motion's bones lead past them. Marks are followed as those of a drawing are, and corrected as they are.

use eframe::egui::{Context as Gui, Ui};
use marey_binding::{Clip, Context, Job, Part, Result};

use crate::around::Around;
use crate::background::Background;
use crate::character_door::CharacterDoor;
use crate::clip_points::Asked;
use crate::document::Document;
use crate::filling::Filling as _;
use crate::marks::Marks;
use crate::shortcuts::Command;
use crate::solved::fingerprint;
use crate::{texts, widgets};

/// A clip that is being opened.
pub(crate) type OpeningClip = Background<std::result::Result<Clip, String>>;

/// Whether a joint has no name but its number in the skeleton that was proposed.
fn is_numbered(joint: &str) -> bool {
    joint.strip_prefix("joint").is_some_and(|number| !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()))
}

/// Starts following the marks.
pub(crate) fn start(context: &Context, document: &Document) -> Result<Option<Job>> {
    let (Some((clip, _)), Some(json)) = (&document.clip, document.text(Part::Points)) else { return Ok(None) };
    context.start_point_track(clip, &context.control_points_from_json(json)?, true).map(Some)
}

impl CharacterDoor {
    /// Whether joints are marked on a clip now.
    pub(crate) fn is_marking(&self) -> bool {
        self.on_clip && self.shop.document.clip.is_some()
    }

    /// Opens a clip beside the window.
    pub(crate) fn open_clip(&mut self, gui: &Gui, path: &std::path::Path, around: &Around) {
        let (context, path) = (around.context.clone(), path.to_string_lossy().into_owned());
        self.opening = Some(Background::start(gui, move || context.open_clip(&path).map_err(|e| e.to_string())));
    }

    /// Takes in a clip that was opened.
    pub(crate) fn take_clip(&mut self, around: &mut Around) {
        let Some(answer) = self.opening.as_ref().map(Background::answer) else { return };
        let answer = match answer {
            Ok(None) => return,
            Ok(Some(answer)) => answer,
            Err(()) => Err(texts::OPENING_BROKE.into()),
        };
        self.opening = None;
        let Some(clip) = around.notices.check(answer) else { return };
        // What was marked on another clip, and said of another motion, does not fit this one.
        let parts = [(Part::Points, None), (Part::Motion, None), (Part::Map, None)];
        let set = self.shop.document.set_clip(texts::EDIT_CLIP, Some(&clip), &parts);
        around.notices.check(set);
        self.on_clip = true;
        self.selected = Some(0);
        self.go_on(around);
    }

    /// What marks are told apart by: the joint's name, or its number where it has none of its own. A skeleton that was
    /// proposed names its joints `joint0`, and so does that of the next drawing, with other joints.
    fn mark_name(joint: usize, name: &str) -> String {
        if is_numbered(name) { (joint + 1).to_string() } else { name.to_owned() }
    }

    /// Whether the marks are those of this figure's joints.
    pub(crate) fn marks_are_own(&self) -> bool {
        let document = &self.shop.document;
        document.marks.points.is_empty() || document.marked_for() == self.picture()
    }

    fn picture(&self) -> Option<u64> {
        self.shop.document.part(Part::Picture).map(|picture| fingerprint(picture))
    }

    /// The number of each mark: its joint's, or behind all joints where the figure has none of its name.
    fn numbers(&self) -> Vec<usize> {
        let joints = self.figure.as_ref().map_or(&[][..], |f| &f.joints);
        let own = self.marks_are_own();
        let names =
            joints.iter().enumerate().map(|(i, j)| (own || !is_numbered(&j.0)).then(|| Self::mark_name(i, &j.0)));
        let names: Vec<Option<String>> = names.collect();
        let mut others = joints.len()..;
        let number = |name: &String| names.iter().position(|n| n.as_ref() == Some(name));
        let marks = self.shop.document.marks.points.iter();
        marks.map(|mark| number(&mark.name).or_else(|| others.next()).unwrap_or(0)).collect()
    }

    /// The mark that has a number, by its place among the marks.
    fn mark_of(&self, number: usize) -> Option<usize> {
        self.numbers().iter().position(|n| *n == number)
    }

    /// How many joints are marked, and how many there are.
    pub(crate) fn marked(&self) -> (usize, usize) {
        let joints = self.figure.as_ref().map_or(0, |f| f.joints.len());
        (self.numbers().iter().filter(|n| **n < joints).count(), joints)
    }

    /// The joint that is to be marked after another: the next that is not.
    fn next_joint(&self, after: usize) -> Option<usize> {
        let (_, joints) = self.marked();
        let numbers = self.numbers();
        (1..=joints).map(|by| (after + by) % joints).find(|joint| !numbers.contains(joint))
    }

    /// Whether what is marked can move anything: the two ends of a bone, past joints that are not marked. Marks of another
    /// figure have bones already.
    pub(crate) fn marks_make_a_bone(&self) -> bool {
        let (own, _) = self.marked();
        let count = self.shop.document.marks.points.len();
        count >= 2 && (own == 0 || !self.bones_of_marks().is_empty())
    }

    /// The marked joints that are held by one another, past those that are not marked, by their marks' names.
    fn bones_of_marks(&self) -> Vec<[String; 2]> {
        let Some(figure) = &self.figure else { return Vec::new() };
        let numbers = self.numbers();
        let is_marked = |joint: &u32| numbers.contains(&(*joint as usize));
        let name = |joint: u32| Self::mark_name(joint as usize, &figure.joints[joint as usize].0);
        let bone = |joint: u32| Some([name(figure.way_to_root(joint).skip(1).find(is_marked)?), name(joint)]);
        (0..figure.joints.len() as u32).filter(is_marked).filter_map(bone).collect()
    }

    /// Which joint follows which mark, as a map.json: each its own, and one that is not marked between two that are goes
    /// between them. None where the marks are another figure's.
    pub(crate) fn map_of_marks(&self) -> Option<String> {
        let figure =
            self.figure.as_ref().filter(|_| self.marks_are_own() && !self.shop.document.marks.points.is_empty())?;
        let numbers = self.numbers();
        let is_marked = |joint: &u32| numbers.contains(&(*joint as usize));
        let name = |joint: u32| Self::mark_name(joint as usize, &figure.joints[joint as usize].0);
        let at = |joint: u32| figure.joints[joint as usize].1;
        let far = |way: &[u32]| -> f32 {
            let apart = |a: (f32, f32), b: (f32, f32)| (a.0 - b.0).hypot(a.1 - b.1);
            way.windows(2).map(|pair| apart(at(pair[0]), at(pair[1]))).sum()
        };
        let mut joints = serde_json::Map::new();
        for outer in (0..figure.joints.len() as u32).filter(is_marked) {
            joints.insert(figure.joints[outer as usize].0.clone(), serde_json::json!({ "track": name(outer) }));
            let mut way: Vec<u32> = figure.way_to_root(outer).collect();
            let Some(inner) = way.iter().skip(1).position(is_marked) else { continue };
            way.truncate(inner + 2);
            way.reverse();
            for i in 1..way.len() - 1 {
                let along = far(&way[..=i]) / far(&way).max(f32::EPSILON);
                let place = serde_json::json!({ "track": name(way[0]), "along": along, "toward": name(outer) });
                joints.entry(figure.joints[way[i] as usize].0.clone()).or_insert(place);
            }
        }
        Some(serde_json::json!({ "joints": joints }).to_string())
    }

    /// A motion of the marks with bones between them, so that other figures are laid on it too: those of this figure, and
    /// what an earlier one left.
    pub(crate) fn with_bones(&self, motion: &str) -> String {
        let read = |json: &str| serde_json::from_str::<serde_json::Value>(json).unwrap_or_default();
        let mut motion = read(motion);
        let earlier = self.shop.document.text(Part::Motion).map(read).unwrap_or_default();
        let is_track = |name: &serde_json::Value| self.shop.document.marks.points.iter().any(|m| *name == m.name);
        let kept = earlier["bones"].as_array().into_iter().flatten();
        let mut bones: Vec<serde_json::Value> =
            self.bones_of_marks().into_iter().map(|b| serde_json::json!(b)).collect();
        let is_held = |bones: &[serde_json::Value], bone: &serde_json::Value| bones.iter().any(|b| b[1] == bone[1]);
        for bone in kept.filter(|b| is_track(&b[0]) && is_track(&b[1])) {
            if !is_held(&bones, bone) {
                bones.push(bone.clone());
            }
        }
        motion["bones"] = bones.into();
        motion.to_string()
    }

    /// Changes the marks, one step of undo.
    fn mark(&mut self, label: &str, around: &mut Around, change: impl FnOnce(&mut Marks)) {
        self.shop.playback.stop();
        let mut marks = self.shop.document.marks.clone();
        change(&mut marks);
        let bytes = marks.bytes();
        let marked = if let Some(bytes) = &bytes {
            let picture = if self.marks_are_own() { self.picture() } else { self.shop.document.marked_for() };
            self.shop.document.set_joint_marks(label, bytes, picture)
        } else {
            // Without marks there is nothing that it moves by.
            self.shop.document.set_parts(label, &[(Part::Points, None), (Part::Motion, None), (Part::Map, None)])
        };
        around.notices.check(marked);
        self.go_on(around);
    }

    /// Marks a joint on the frame that is shown.
    fn mark_joint(&mut self, label: &str, number: usize, at: (f32, f32), around: &mut Around) {
        let (frame, mark) = (self.shop.playback.frame(), self.mark_of(number));
        let joint = self.figure.as_ref().and_then(|f| f.joints.get(number)).map(|j| Self::mark_name(number, &j.0));
        self.mark(label, around, |marks| match (mark, joint) {
            (Some(mark), _) => marks.put(mark, frame, at),
            (None, Some(joint)) => marks.put_named(&joint, frame, at),
            (None, None) => {}
        });
    }

    /// Takes the selected joint's mark off the frame that is shown.
    pub(crate) fn unmark(&mut self, around: &mut Around) {
        let frame = self.shop.playback.frame();
        if let Some(mark) = self.selected.and_then(|number| self.mark_of(number)) {
            self.mark(texts::EDIT_UNMARK, around, |marks| marks.take(mark, frame));
        }
    }

    /// Moves what is marked on a frame to another.
    pub(crate) fn move_marks(&mut self, from: u64, to: u64, around: &mut Around) {
        self.mark(texts::EDIT_MOVE_KEY, around, |marks| marks.move_frame(from, to));
    }

    /// Goes to the frame and the joint that a mark helps most.
    pub(crate) fn next_correction(&mut self) {
        let shown = (self.selected.and_then(|number| self.mark_of(number)), self.shop.playback.frame());
        let worst = self.shop.document.tracked.as_ref().and_then(|t| t.next_correction(shown));
        if let Some(worst) = worst {
            self.on_clip = true;
            self.shop.playback.stop();
            self.shop.playback.seek(worst.frame, 0.0);
            self.selected = self.numbers().get(worst.track as usize).copied();
        }
    }

    /// The clip with the marks.
    pub(crate) fn show_clip(&mut self, ui: &mut Ui, around: &mut Around) {
        let numbers = self.numbers();
        let joint = |number: usize| self.figure.as_ref()?.joints.get(number).map(|j| j.0.as_str());
        let own = self.marks_are_own();
        let can_be_marked =
            |number: &usize| !numbers.contains(number) && joint(*number).is_some_and(|name| own || !is_numbered(name));
        let next = self.selected.filter(can_be_marked);
        let (marked, joints) = self.marked();
        let hint = match next.and_then(joint) {
            Some(name) => {
                let name = Some(name).filter(|name| !is_numbered(name));
                Some(texts::mark_joint(next.unwrap_or(0), name, marked, joints))
            }
            None if numbers.is_empty() => Some(texts::SELECT_JOINT.into()),
            None => None,
        };
        let mut on_clip = self.on_clip;
        let asked = self.clip.show(ui, &self.shop, (&numbers, self.selected), hint.as_deref(), |ui| {
            if widgets::word_toggle(ui, texts::ON_CLIP, true, Command::Clip) {
                on_clip = false;
            }
        });
        self.on_clip = on_clip;
        match asked {
            Some(Asked::Mark(at)) => match next {
                Some(number) => {
                    self.mark_joint(texts::EDIT_MARK, number, at, around);
                    self.selected = self.next_joint(number);
                }
                // A click beside a joint that is marked lets go of it, and goes on with what is not.
                None => self.selected = self.next_joint(self.selected.unwrap_or(joints)),
            },
            Some(Asked::Move(number, at)) => {
                self.selected = Some(number);
                self.mark_joint(texts::EDIT_MOVE_POINT, number, at, around);
            }
            Some(Asked::Select(number)) => self.selected = number,
            None => {}
        }
    }

    /// Where the marks are in the frame that is shown, by number.
    pub(crate) fn points(&self) -> Vec<(usize, (f32, f32))> {
        let handles = crate::clip_points::handles(&self.shop.document, self.shop.playback.frame(), &self.numbers());
        handles.iter().map(|h| (h.number, h.at)).collect()
    }
}
