//! Any motion on a creature: in every frame the tracks pose the limbs that follow them.
//!
//! A limb follows a stroke track, or a chain of tracks such as the joints of a captured leg. Another body's motion turns
//! the limbs from their own mean pose as it turns that body's from its, since a camel does not carry its head where a fox
//! does; a motion of the same body says where limbs point. Where the creature keeps its bones' lengths, each limb takes directions, and how much of its greatest length it shows; else the whole motion is
//! scaled and limbs lie along it. The root starts where the creature's own animation starts, and its way is scaled by how
//! much longer the creature's limbs are; a motion of the creature's own clip stays where it is.
//!
//! Known limits: what a body does in depth is not in a motion, so that legs drawn short come toward the viewer unless
//! the map says otherwise; where limbs point as the motion's, one that runs the other way has to be mirrored.

use std::collections::BTreeMap;

use glam::{Vec2, vec2};

use super::posing::{Key, Poser, labels};
use super::{Creature, CreatureLimb, LimbPose, PoseParams, path};
use crate::error::{Error, Result};
use crate::geometry::polyline;
use crate::job::Stage;
use crate::motion::limb_map::{LimbMap, LimbMapParams, LimbSource, map_limbs, propose_map, rest_limbs};
use crate::motion::retarget::Angles;
use crate::motion::{Motion, TrackKind, listed};
use crate::rig::Facing;
use crate::shape::character::Easing;

/// A body whose limbs are longer or shorter by less than this share is the same.
const SAME: f32 = 0.05;

/// How a motion drives a creature.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveParams {
    /// Limits of every pose.
    pub pose: PoseParams,
    /// What the root's way is scaled by; `None` for the ratio of the limbs' lengths.
    pub root_scale: Option<f32>,
    /// Whether left and right of the motion change places. Where limbs turn as another body's, they do so without being
    /// told where that body faces the other way.
    pub mirror: bool,
    /// Whether limbs turn as the motion's do, each from its own mean pose, or point where they point; `None` for the
    /// latter with a body of the same lengths in a picture of the same size, else the former.
    pub angles: Option<Angles>,
}

impl Default for DriveParams {
    /// The creature's bones keep their lengths: another body's changes of length say nothing about this one.
    fn default() -> Self {
        let pose = PoseParams { keep_lengths: true, ..PoseParams::default() };
        Self { pose, root_scale: None, mirror: false, angles: None }
    }
}

impl Creature {
    /// What each limb follows: what `given` says; or else the stroke track of its name, letter for letter or by letters
    /// and digits alone; or else, where no name is the same, what [`propose_map`] finds alike.
    ///
    /// # Errors
    /// A map that names what is not there, or nothing that matches, with the names on both sides.
    pub fn matched(&self, motion: &Motion, given: Option<&LimbMap>) -> Result<LimbMap> {
        motion.validate()?;
        if let Some(given) = given {
            for (label, source) in &given.limbs {
                let what = || format!("limb `{label}` in the map");
                if self.limbs.iter().all(|l| l.label != *label) {
                    let remedy = format!("it has {}", labels(&self.limbs));
                    return Err(Error::invalid(what(), "is none of the creature's", remedy));
                }
                if let Some(track) = source.tracks.iter().find(|t| motion.track(t).is_none()) {
                    let remedy = format!("the motion has {}", tracks(motion));
                    return Err(Error::invalid(what(), format!("follows `{track}`, which is no track"), remedy));
                }
                if points(motion, source, 0).len() < 2 {
                    return Err(Error::invalid(what(), "follows less than two points", "name a stroke or more tracks"));
                }
            }
        }
        // A map is meant as it is written: what it leaves out rests.
        if let Some(given) = given.filter(|g| !g.limbs.is_empty()) {
            return Ok(given.clone());
        }
        let letters = |name: &str| -> String {
            name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
        };
        let strokes = || {
            motion.tracks.iter().filter(|t| t.kind == TrackKind::Stroke && t.frames.iter().all(|f| f.points.len() > 1))
        };
        let named = |limb: &CreatureLimb| {
            let exact = strokes().find(|t| t.name == limb.label);
            let track = exact.or_else(|| strokes().find(|t| letters(&t.name) == letters(&limb.label)))?;
            let source = LimbSource { tracks: vec![track.name.clone()], ..LimbSource::default() };
            Some((limb.label.clone(), source))
        };
        let limbs: BTreeMap<String, LimbSource> = self.limbs.iter().filter_map(named).collect();
        if !limbs.is_empty() {
            return Ok(LimbMap { limbs });
        }
        let alike = rest_limbs(&self.motion(), None).and_then(|limbs| propose_map(motion, &limbs));
        alike.map_err(|e| {
            let problem = format!("suits no limb: {e}; its tracks are {}", tracks(motion));
            let remedy = format!(
                "give a map: {{\"limbs\": {{LIMB: {{\"tracks\": [TRACK, ...]}}, ...}}}}, with the limbs {}",
                labels(&self.limbs)
            );
            Error::invalid("motion", problem, remedy)
        })
    }

    /// The creature moved by `motion`, with its frames and its rate; `map` is as [`Self::matched`] completes it.
    ///
    /// # Errors
    /// What [`Self::matched`] refuses, a motion without frames, a parameter out of range, or a cancel.
    pub fn driven(
        &self,
        motion: &Motion,
        map: Option<&LimbMap>,
        params: &DriveParams,
        stage: Stage<'_>,
    ) -> Result<Creature> {
        stage.name("posing")?;
        let poser = Poser::new(self, &params.pose, params.pose.keep_lengths)?;
        let map = self.matched(motion, map)?;
        if motion.frames == 0 {
            return Err(Error::invalid("motion", "has no frame", "give one with at least one frame"));
        }
        if params.root_scale.is_some_and(|s| !(-1000.0..=1000.0).contains(&s)) {
            return Err(Error::invalid("root scale", "is out of range", "give a factor of at most 1000"));
        }
        let (followed, ratio) = self.follow(motion, &map, params.mirror)?;
        let same_body = ratio == 1.0 && motion.size == self.model.size;
        if params.angles.map_or(!same_body, |a| a == Angles::Relative) {
            return self.turned(motion, &map, params, stage);
        }
        let root_scale = params.root_scale.unwrap_or(ratio);
        // Everything moves with the first root that follows something.
        let lead = (0..self.limbs.len()).find(|&l| self.limbs[l].parent.is_none() && followed[l].is_some());
        let height = self.model.size.1 as f32;
        let first_pose = self.model.animation.first().unwrap_or(&self.model.rest);
        let placed = super::chain::all_world(&self.model.bones, first_pose);
        // Strokes of the same clip are where they are.
        let in_place = !params.pose.keep_lengths && root_scale == 1.0 && ratio == 1.0 && motion.size == self.model.size;
        let start = lead.filter(|_| !in_place).and_then(|l| {
            let bones = &placed[self.limbs[l].bone_range()];
            let mut own: Vec<Vec2> = bones.iter().map(|(p, _)| vec2(p.x, height - p.y)).collect();
            if !params.pose.keep_lengths {
                self.limbs[l].settle(&mut own, true);
            }
            Some((own[0], followed[l].as_ref()?.held(&self.limbs[l], 0)))
        });
        let lead_at =
            |f: usize| lead.and_then(|l| Some(followed[l].as_ref()?.held(&self.limbs[l], f))).unwrap_or_default();
        let poses: Vec<Vec<LimbPose>> = self
            .limbs
            .iter()
            .zip(&followed)
            .map(|(limb, followed)| {
                let Some(followed) = followed else { return Vec::new() };
                let own = if followed.length > 0.0 { limb.length / followed.length } else { 1.0 };
                let scale = if params.pose.keep_lengths { own } else { ratio };
                let pose = |f: usize| {
                    let from = followed.held(limb, f);
                    let moved = |(own, theirs): (Vec2, Vec2)| own + (lead_at(f) - theirs) * root_scale;
                    let to = start.map_or(from, |start| moved(start) + (from - lead_at(f)) * ratio);
                    LimbPose {
                        limb: limb.label.clone(),
                        points: followed.frames[f].iter().map(|p| to + (*p - from) * scale).collect(),
                        facing: followed.facing,
                        ..LimbPose::default()
                    }
                };
                (0..motion.frames).map(pose).collect()
            })
            .collect();
        let keys: Vec<Vec<Key<'_>>> = poses.iter().map(|limb| every_frame(limb)).collect();
        let animation = poser.animate(&keys, motion.frames, 1, stage)?;
        let mut out = self.clone();
        out.model.animation = animation;
        out.model.fps = motion.fps;
        Ok(out)
    }
}

impl Creature {
    /// What each limb follows over all frames, and how much longer the limbs are than what they follow.
    fn follow(&self, motion: &Motion, map: &LimbMap, mirror: bool) -> Result<(Vec<Option<Followed>>, f32)> {
        let follow = |limb: &CreatureLimb| Some(Followed::new(motion, map.limbs.get(&limb.label)?, mirror));
        let followed: Vec<Option<Followed>> = self.limbs.iter().map(follow).collect();
        let (mut strokes, mut axes, mut theirs) = (0.0, 0.0, 0.0);
        for (limb, followed) in self.limbs.iter().zip(&followed) {
            if let Some(followed) = followed {
                strokes += limb.stroke_length();
                axes += limb.length;
                theirs += followed.length;
            }
        }
        if !(theirs > 0.0 && theirs.is_finite()) {
            return Err(Error::invalid("motion", "has strokes of no length or of no bounds", "give tracks of limbs"));
        }
        // Lengths of one body differ by so much between one tracking and the next, and its motion may be tracked or its bones'.
        let same = [strokes, axes].iter().any(|own: &f32| (own / theirs - 1.0).abs() < SAME);
        Ok((followed, if same { 1.0 } else { strokes / theirs }))
    }

    /// The creature moved by `motion` carried onto its own limbs first.
    fn turned(&self, motion: &Motion, map: &LimbMap, params: &DriveParams, stage: Stage<'_>) -> Result<Creature> {
        let how = LimbMapParams {
            stretch: if params.pose.keep_lengths { 1.0 } else { f64::from(params.pose.stretch) },
            travel: params.root_scale.map(f64::from),
            mirror: params.mirror.then_some(true),
            ..LimbMapParams::default()
        };
        // Limbs are carried over from where they hang, also those that were drawn from their ends.
        let mut own = self.motion();
        let (mut from, mut to) = (map.clone(), LimbMap::default());
        for (limb, track) in self.limbs.iter().zip(&mut own.tracks) {
            if limb.reversed {
                track.frames.iter_mut().for_each(|f| f.points.reverse());
            }
            if let Some(source) = from.limbs.get_mut(&limb.label) {
                source.reversed ^= limb.reversed;
                let tracks = vec![limb.label.clone()];
                let carried = LimbSource { tracks, reversed: limb.reversed, facing: source.facing };
                to.limbs.insert(limb.label.clone(), carried);
            }
        }
        let carried = map_limbs(motion, &rest_limbs(&own, None)?, self.model.size, &from, &how)?;
        let how =
            DriveParams { root_scale: Some(1.0), mirror: false, angles: Some(Angles::Absolute), ..params.clone() };
        self.driven(&carried, Some(&to), &how, stage)
    }
}

fn every_frame(poses: &[LimbPose]) -> Vec<Key<'_>> {
    poses.iter().enumerate().map(|(frame, pose)| Key { frame, pose, easing: Easing::Hold }).collect()
}

/// The stroke that a limb follows, over all frames.
struct Followed {
    frames: Vec<Vec<Vec2>>,
    /// Its length when it lies in the image plane.
    length: f32,
    facing: Option<Facing>,
}

impl Followed {
    fn new(motion: &Motion, source: &LimbSource, mirror: bool) -> Self {
        let mut frames: Vec<Vec<Vec2>> = (0..motion.frames).map(|f| points(motion, source, f)).collect();
        if mirror {
            let width = motion.size.0 as f32;
            frames.iter_mut().flatten().for_each(|p| p.x = width - p.x);
        }
        let length = path::full_length_of(frames.iter().map(|p| polyline::length(p)).collect());
        Self { frames, length, facing: source.facing }
    }

    /// Where the end that is to be held is.
    fn held(&self, limb: &CreatureLimb, frame: usize) -> Vec2 {
        let points = &self.frames[frame];
        let end = if limb.reversed { points.last() } else { points.first() };
        end.copied().unwrap_or_default()
    }
}

/// The points of a limb's source in a frame, from the limb's start to its end.
fn points(motion: &Motion, source: &LimbSource, frame: usize) -> Vec<Vec2> {
    let tracks = source.tracks.iter().filter_map(|name| motion.track(name)?.frames.get(frame));
    let mut points: Vec<Vec2> = tracks.flat_map(|t| t.points.iter().copied()).collect();
    if source.reversed {
        points.reverse();
    }
    points
}

fn tracks(motion: &Motion) -> String {
    listed(motion.tracks.iter().map(|t| t.name.as_str()))
}
