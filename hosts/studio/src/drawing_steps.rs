//! The steps that the machine fills in of a drawing that lives: points are followed, laid on the drawing, and it moves.
//!
//! What it proposes is not part of the document until a person corrects it, so that undo takes back what a person did and
//! nothing else.

use std::sync::Arc;

use marey_binding::{BindOptions, Binding, Job, MotionUse, Part, Result};

use crate::around::Around;
use crate::drawing_door::{DrawingDoor, LEAST};
use crate::filling::{Filling, Steps};
use crate::held::{Sheet, held};
use crate::marks::Marks;
use crate::moving::{Moving, one_frame};
use crate::running::{Purpose, Running, Step};
use crate::solved::Solved;
use crate::texts;
use crate::workshop::Workshop;

/// What something was made of: the marks, the drawing, and how it was held.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Of {
    points: Option<Arc<Vec<u8>>>,
    drawing: Option<Arc<Vec<u8>>>,
    held: String,
}

impl Filling for DrawingDoor {
    type Of = Of;

    fn shop(&mut self) -> &mut Workshop {
        &mut self.shop
    }

    fn steps(&mut self) -> &mut Steps<Of> {
        &mut self.steps
    }

    fn wanted(&mut self, around: &mut Around) -> Option<(Step, Of)> {
        around.notices.check(Solved::refresh(&mut self.solved, &around.context, &mut self.shop.document));
        self.read_sheet(around);
        self.hold(around);
        self.next_step()
    }

    fn start(&mut self, step: Step, _: &Of, around: &Around) -> std::result::Result<Option<Job>, String> {
        self.begin(step, around).map_err(|e| e.to_string())
    }

    fn take(&mut self, step: Step, job: &Job, of: Of, now: f64, around: &mut Around) -> Result<()> {
        match step {
            Step::Propose => {
                let found = Marks::parse(job.take_control_points()?.to_json()?.as_bytes());
                if let Some(frame) = found.as_ref().and_then(|found| found.frames().first().copied()) {
                    self.shop.playback.stop();
                    self.shop.playback.seek(frame, now);
                }
                self.mark(texts::EDIT_PROPOSE, around, |marks| marks.add(found));
            }
            Step::Points => {
                let motion = job.take_motion()?;
                if let Some(points) = of.points {
                    let kept = self.shop.document.keep_solved(&points, &motion.to_json()?);
                    around.notices.check(kept);
                    let solved = Solved { of: points, motion };
                    around.notices.check(solved.show(&around.context, &mut self.shop.document));
                    self.solved = Some(solved);
                }
            }
            Step::Bind => self.proposed = Some((of, job.take_binding()?.to_json()?)),
            Step::Rebind => {
                let json = job.take_binding()?.to_json()?;
                self.shop.document.set_parts(texts::EDIT_REBIND, &[(Part::Binding, Some(json.as_bytes()))])?;
            }
            Step::Still => self.still = Some(Moving::Drawing(Arc::new(job.take_sketch_take()?))),
            Step::Move => {
                let take = Moving::Drawing(Arc::new(job.take_sketch_take()?));
                self.moves = Some(of);
                self.shop.show_moving(take, now);
            }
            Step::Character => {}
        }
        Ok(())
    }
}

impl DrawingDoor {
    /// The step that is to be done, and what it is to be done for.
    fn next_step(&self) -> Option<(Step, Of)> {
        let sheet = self.sheet.as_ref();
        let drawing = sheet.map(|sheet| sheet.of.clone());
        if sheet.is_some() && self.still.is_none() {
            return Some((Step::Still, Of { drawing, ..Of::default() }));
        }
        let points = self.shop.document.part(Part::Points).filter(|_| self.shop.document.clip.is_some())?;
        if self.solved.as_ref().is_none_or(|solved| solved.of != *points) {
            return Some((Step::Points, Of { points: Some(points.clone()), ..Of::default() }));
        }
        sheet?;
        if self.shop.document.marks.points.len() < LEAST {
            return None;
        }
        let of = Of { points: Some(points.clone()), drawing, held: String::new() };
        let Some(held) = &self.held else { return Some((Step::Bind, of)) };
        let of = Of { held: held.json.clone(), ..of };
        (self.moves.as_ref() != Some(&of)).then_some((Step::Move, of))
    }

    fn begin(&self, step: Step, around: &Around) -> Result<Option<Job>> {
        let (context, document) = (&around.context, &self.shop.document);
        match step {
            Step::Points => {
                let (Some((clip, _)), Some(json)) = (&document.clip, document.text(Part::Points)) else {
                    return Ok(None);
                };
                let points = context.control_points_from_json(json)?;
                context.start_point_track(clip, &points, true).map(Some)
            }
            Step::Bind => self.start_bind(None, None, around),
            Step::Still => {
                let Some(sheet) = &self.sheet else { return Ok(None) };
                let (w, h) = (sheet.size.x, sheet.size.y);
                let motion = context.motion_from_json(&one_frame(&[("still", (w / 2.0, h / 2.0))], (w, h)))?;
                let binding = context.new_binding(&sheet.drawing)?;
                binding.set_motion(&MotionUse {
                    name: "still".into(),
                    scale: 1.0,
                    rotation: 0.0,
                    mirror: false,
                    frame: 0,
                    travel: 1.0,
                    repeat: false,
                })?;
                binding.set_point("", "still", 0, (w / 2.0, h / 2.0), "")?;
                context.start_sketch_take(&sheet.drawing, &binding, &[&motion]).map(Some)
            }
            Step::Move => {
                let (Some(sheet), Some(held), Some(solved)) = (&self.sheet, &self.held, &self.solved) else {
                    return Ok(None);
                };
                let binding = context.binding_from_json(&held.json)?;
                context.start_sketch_take(&sheet.drawing, &binding, &[&solved.motion]).map(Some)
            }
            Step::Propose | Step::Rebind | Step::Character => Ok(None),
        }
    }

    /// Finds points to mark: on the frame that is shown where something is marked or somebody went there, else where most is seen.
    pub(crate) fn find_points(&mut self, around: &mut Around) {
        let shown = self.shop.playback.frame();
        let frame = (shown > 0 || !self.shop.document.marks.points.is_empty()).then_some(shown);
        let Some((clip, _)) = &self.shop.document.clip else {
            around.notices.failed(texts::MARK_HINT);
            return;
        };
        if self.shop.running.is_some() {
            around.notices.failed(texts::BUSY);
            return;
        }
        let started = around.context.start_propose_points(clip, frame, 0);
        if let Some(job) = around.notices.check(started) {
            self.shop.running = Some(Running::new(job, Purpose::Step(Step::Propose)));
        }
    }

    fn start_bind(&self, frame: Option<u64>, mirror: Option<bool>, around: &Around) -> Result<Option<Job>> {
        let (Some(sheet), Some(solved)) = (&self.sheet, &self.solved) else { return Ok(None) };
        let clip = self.shop.document.clip.as_ref().map(|(clip, _)| &**clip);
        let options = BindOptions { clip, frame, mirror, ..BindOptions::default() };
        around.context.start_bind(&sheet.drawing, &solved.motion, &options).map(Some)
    }

    /// Lays what moves on the drawing anew, in place of what was corrected.
    pub(crate) fn rebind(&mut self, frame: Option<u64>, mirror: Option<bool>, around: &mut Around) {
        if self.shop.running.is_some() {
            around.notices.failed(texts::BUSY);
            return;
        }
        let started = self.start_bind(frame, mirror, around);
        if let Some(Some(job)) = around.notices.check(started) {
            self.shop.running = Some(Running::new(job, Purpose::Step(Step::Rebind)));
        }
    }

    /// Reads the drawing where it is another.
    fn read_sheet(&mut self, around: &mut Around) {
        let Some(of) = self.shop.document.part(Part::Drawing) else {
            self.sheet = None;
            self.still = None;
            self.shop.moving = None;
            self.moves = None;
            return;
        };
        if self.sheet.as_ref().is_some_and(|sheet| sheet.of == *of) {
            return;
        }
        let read = Sheet::read(&around.context, of);
        self.sheet = around.notices.check(read);
        self.still = None;
        self.still_pictures.clear();
        self.shop.moving = None;
        self.shop.pictures.clear();
        self.moves = None;
        self.sheet_looking.fit();
    }

    /// Puts together how the drawing is held.
    fn hold(&mut self, around: &mut Around) {
        self.held = None;
        let (Some(sheet), Some(solved)) = (&self.sheet, &self.solved) else { return };
        if self.shop.document.part(Part::Points) != Some(&solved.of) {
            return;
        }
        let is_of_these = |of: &Of| of.points.as_ref() == Some(&solved.of) && of.drawing.as_ref() == Some(&sheet.of);
        let proposed = self.proposed.as_ref().filter(|p| is_of_these(&p.0)).map(|p| &p.1);
        let said = self.shop.document.text(Part::Binding);
        let is_on = |point: &str| self.shop.document.is_on_drawing(point);
        let held = held(&around.context, sheet, &solved.motion, (said, proposed.map(String::as_str)), is_on);
        // Without an answer there is something to be proposed yet.
        self.held = around.notices.check(held).flatten();
    }

    /// Changes how the drawing is held, one step of undo.
    pub(crate) fn change_held(
        &mut self,
        label: &str,
        around: &mut Around,
        change: impl FnOnce(&Binding, &Sheet) -> Result<()>,
    ) {
        let (Some(held), Some(sheet)) = (&self.held, &self.sheet) else { return };
        let changed = || {
            let binding = around.context.binding_from_json(&held.json)?;
            change(&binding, sheet)?;
            binding.to_json()
        };
        if let Some(json) = around.notices.check(changed()) {
            let set = self.shop.document.set_parts(label, &[(Part::Binding, Some(json.as_bytes()))]);
            around.notices.check(set);
        }
        self.go_on(around);
    }
}
