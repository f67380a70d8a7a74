//! The steps that the machine fills in of a character: its skeleton is found in the picture, marked joints are followed
//! through a clip, and it takes the motion.

use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;

use eframe::egui::{Vec2, vec2};
use marey_binding::{Character, CharacterOptions, Job, Part, Result, RetargetOptions, TakeOptions};

use crate::around::Around;
use crate::capture;
use crate::character_door::CharacterDoor;
use crate::filling::{Filling, Steps};
use crate::moving::{Moving, one_frame};
use crate::needles::Needles;
use crate::notes::CharacterNotes;
use crate::running::Step;
use crate::solved::Solved;
use crate::texts;
use crate::workshop::Workshop;

/// A drawing with its skeleton.
pub(crate) struct Figure {
    /// The picture and the skeleton that it was made of.
    pub(crate) of: Made,
    pub(crate) character: Arc<Character>,
    pub(crate) joints: Vec<(String, (f32, f32))>,
    pub(crate) bones: Vec<[u32; 2]>,
    /// The edges of its mesh, each once.
    pub(crate) edges: Vec<[u32; 2]>,
    pub(crate) needles: Needles,
    pub(crate) size: Vec2,
}

impl Figure {
    /// A joint, the one that holds it, and so on to the root.
    pub(crate) fn way_to_root(&self, joint: u32) -> impl Iterator<Item = u32> {
        let parent = |joint: &u32| self.bones.iter().find(|b| b[1] == *joint).map(|b| b[0]);
        std::iter::successors(Some(joint), parent).take(self.joints.len())
    }
}

/// What something was made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Made {
    picture: Option<Arc<Vec<u8>>>,
    skeleton: Option<Arc<Vec<u8>>>,
    points: Option<Arc<Vec<u8>>>,
    motion: Option<Arc<Vec<u8>>>,
    map: Option<Arc<Vec<u8>>>,
    notes: CharacterNotes,
}

impl Filling for CharacterDoor {
    type Of = Made;

    fn shop(&mut self) -> &mut Workshop {
        &mut self.shop
    }

    fn steps(&mut self) -> &mut Steps<Made> {
        &mut self.steps
    }

    fn wanted(&mut self, around: &mut Around) -> Option<(Step, Made)> {
        around.notices.check(Solved::refresh(&mut self.solved, &around.context, &mut self.shop.document));
        if self.motion().is_none() {
            self.shop.moving = None;
            self.shop.pictures.clear();
            self.moves = None;
        }
        self.next_step()
    }

    fn start(&mut self, step: Step, made: &Made, around: &Around) -> std::result::Result<Option<Job>, String> {
        if step == Step::Character
            && let Some(bytes) = &made.picture
            && self.file.as_ref().is_none_or(|(of, _)| of != bytes)
        {
            let file = picture_file(bytes, &around.places.samples)
                .map_err(|e| texts::no_folder(&around.places.samples, &e))?;
            self.file = Some((bytes.clone(), file));
        }
        self.begin(step, made, around).map_err(|e| e.to_string())
    }

    fn take(&mut self, step: Step, job: &Job, of: Made, now: f64, around: &mut Around) -> Result<()> {
        match step {
            Step::Character => {
                let character = job.take_character()?;
                let (info, joints, bones) = (character.info()?, character.joints()?, character.bones()?);
                let size = vec2(info.size.0 as f32, info.size.1 as f32);
                let mut edges: Vec<[u32; 2]> = character
                    .triangles()?
                    .into_iter()
                    .flat_map(|[a, b, c]| [[a.min(b), a.max(b)], [b.min(c), b.max(c)], [c.min(a), c.max(a)]])
                    .collect();
                edges.sort_unstable();
                edges.dedup();
                let needles = Needles::of(&character, &joints, &bones)?;
                self.figure = Some(Figure { of, character: Arc::new(character), joints, bones, edges, needles, size });
                (self.still, self.moves) = (None, None);
            }
            Step::Still => self.still = Some(Moving::Character(Arc::new(job.take_take()?))),
            Step::Points => {
                let motion = job.take_motion()?;
                if let Some(points) = of.points {
                    let json = self.with_bones(&motion.to_json()?);
                    let motion = around.context.motion_from_json(&json)?;
                    let kept = self.shop.document.keep_solved(&points, &json);
                    around.notices.check(kept);
                    self.captured = Some((points.clone(), Arc::new(json.into_bytes())));
                    let solved = Solved { of: points, motion };
                    around.notices.check(solved.show(&around.context, &mut self.shop.document));
                    self.solved = Some(solved);
                }
            }
            Step::Move => {
                let take = job.take_take()?;
                let report: serde_json::Value = serde_json::from_str(&take.report()?).unwrap_or_default();
                self.followed = report["followed"]["map"].clone();
                let take = Moving::Character(Arc::new(take));
                self.moves = Some(of);
                let (first, marking) = (self.shop.moving.is_none(), self.is_marking());
                self.shop.show_moving(take, now);
                if first && marking {
                    // The frame that is marked on stays.
                    self.shop.playback.stop();
                }
            }
            Step::Propose | Step::Bind | Step::Rebind => {}
        }
        Ok(())
    }
}

impl CharacterDoor {
    /// What the character is to be made of.
    fn figure_of(&self) -> Made {
        let part = |part| self.shop.document.part(part).cloned();
        Made { picture: part(Part::Picture), skeleton: part(Part::Skeleton), ..Made::default() }
    }

    /// What is to play.
    fn moves_of(&self) -> Made {
        let map = self.shop.document.part(Part::Map).cloned();
        let notes = self.shop.document.character_notes();
        Made { motion: self.motion().cloned(), map, notes, ..self.figure_of() }
    }

    /// The motion that it takes: what was captured of the marks that are there, else what the session has.
    pub(crate) fn motion(&self) -> Option<&Arc<Vec<u8>>> {
        let document = &self.shop.document;
        let captured = self.captured.as_ref().filter(|(of, _)| document.part(Part::Points) == Some(of));
        captured.map(|(_, motion)| motion).or(document.part(Part::Motion))
    }

    fn next_step(&self) -> Option<(Step, Made)> {
        let figure = self.figure_of();
        figure.picture.as_ref()?;
        if self.figure.as_ref().is_none_or(|f| f.of != figure) {
            return Some((Step::Character, figure));
        }
        if self.still.is_none() {
            return Some((Step::Still, figure));
        }
        let points = self.shop.document.part(Part::Points).filter(|_| self.shop.document.clip.is_some());
        if let Some(points) = points
            && self.solved.as_ref().is_none_or(|solved| solved.of != *points)
        {
            let of = Made { points: Some(points.clone()), ..Made::default() };
            return self.marks_make_a_bone().then_some((Step::Points, of));
        }
        let moves = self.moves_of();
        moves.motion.as_ref()?;
        (self.moves.as_ref() != Some(&moves)).then_some((Step::Move, moves))
    }

    fn begin(&mut self, step: Step, made: &Made, around: &Around) -> Result<Option<Job>> {
        let context = &around.context;
        match (step, &self.figure) {
            (Step::Character, _) => {
                let path = self.file.as_ref().map(|(_, f)| f.path().to_string_lossy().into_owned());
                let rig = made.skeleton.as_ref().map(|s| String::from_utf8_lossy(s));
                let options = CharacterOptions {
                    picture: path.as_deref().unwrap_or_default(),
                    rig_json: rig.as_deref().unwrap_or_default(),
                    ..CharacterOptions::default()
                };
                context.start_character(&options).map(Some)
            }
            (Step::Still, Some(figure)) => {
                let joints: Vec<(&str, (f32, f32))> = figure.joints.iter().map(|(n, at)| (n.as_str(), *at)).collect();
                let motion = context.motion_from_json(&one_frame(&joints, (figure.size.x, figure.size.y)))?;
                context.start_take_of_motion(&figure.character, &motion, &TakeOptions::default()).map(Some)
            }
            (Step::Points, _) => capture::start(context, &self.shop.document),
            (Step::Move, Some(figure)) => {
                let Some(json) = made.motion.as_ref().map(|m| String::from_utf8_lossy(m)) else { return Ok(None) };
                let motion = context.motion_from_json(&json)?;
                self.tracks = motion.info()?.tracks;
                let own = self.map_of_marks().unwrap_or_default();
                let retarget = RetargetOptions {
                    absolute: made.notes.absolute,
                    stretch: made.notes.stretch,
                    root_scale: made.notes.on_spot.then_some(0.0),
                    map: self.shop.document.text(Part::Map).unwrap_or(&own),
                    ..RetargetOptions::default()
                };
                let options = TakeOptions { retarget, deformer: &made.notes.deformer, ..TakeOptions::default() };
                context.start_take_of_motion(&figure.character, &motion, &options).map(Some)
            }
            _ => Ok(None),
        }
    }
}

fn picture_file(bytes: &[u8], folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut file = tempfile::Builder::new().prefix("picture-").tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.flush()?;
    Ok(file)
}
