//! What there is to see: models, each with its place and its time.

use std::sync::Arc;

use glam::Mat4;
use marey::job::Stage;
use marey::shape::Transform;
use marey::shape::crowd::{Crowd, between};
use marey::{Error, Result};

use crate::{Extent, Model};

/// A model at a place.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The model.
    pub model: Model,
    /// Where it stands: from the model's world to the scene's.
    pub place: Mat4,
    /// The model's frame in the scene's first one; between whole frames poses are blended.
    pub start: f64,
    /// The model's frames for each of the scene's.
    pub speed: f64,
    /// Whether its last frame is followed by its first; else it stays as it ends.
    pub looped: bool,
}

impl Instance {
    /// A model as it is.
    pub fn new(model: Model) -> Self {
        Self { model, place: Mat4::IDENTITY, start: 0.0, speed: 1.0, looped: true }
    }

    /// The model's bones in a frame of the scene.
    pub(crate) fn pose(&self, frame: usize) -> Vec<Transform> {
        between(&self.model.rig().animation, self.start + frame as f64 * self.speed, self.looped)
    }
}

/// Models in one space.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The models.
    pub instances: Vec<Instance>,
    /// How many frames there are.
    pub frames: usize,
    /// Frames a second.
    pub fps: f64,
}

impl Scene {
    /// One model as it is.
    pub fn of(model: Model) -> Self {
        Self { frames: model.frames(), fps: model.rig().fps, instances: vec![Instance::new(model)] }
    }

    /// A crowd as it stands.
    ///
    /// # Errors
    /// A crowd or a creature that is not valid.
    pub fn of_crowd(crowd: &Crowd) -> Result<Self> {
        crowd.validate()?;
        let models: Vec<Model> =
            crowd.creatures.iter().map(|c| Model::new(Arc::new(c.model.clone()))).collect::<Result<_>>()?;
        let stands = |(i, at): (usize, &marey::shape::crowd::Instance)| {
            let model = models[at.creature].clone();
            let speed = at.speed * model.rig().fps / crowd.fps;
            Instance { model, place: crowd.placement(i), start: at.start, speed, looped: at.looped }
        };
        let instances = crowd.instances.iter().enumerate().map(stands).collect();
        Ok(Self { instances, frames: crowd.frames, fps: crowd.fps })
    }

    /// How far it reaches over all frames.
    ///
    /// # Errors
    /// A cancel.
    pub fn extent(&self, stage: Stage<'_>) -> Result<Extent> {
        let count = self.instances.len().max(1) as f64;
        let each = |(i, instance): (usize, &Instance)| {
            let part = stage.part(i as f64 / count, (i + 1) as f64 / count);
            Ok(instance.model.extent(part)?.moved(&instance.place))
        };
        let each: Vec<Extent> = self.instances.iter().enumerate().map(each).collect::<Result<_>>()?;
        Ok(Extent::join(&each))
    }

    /// # Errors
    /// Nothing to see, no such frame, a place or a time that is none.
    pub(crate) fn validate(&self, frame: usize) -> Result<()> {
        if self.instances.is_empty() || self.frames == 0 {
            return Err(Error::invalid("the scene", "is empty", "give it a model and a frame"));
        }
        if frame >= self.frames {
            let remedy = format!("give 0 to {}", self.frames - 1);
            return Err(Error::invalid(format!("frame {frame}"), "is not there", remedy));
        }
        let bad = |i: &Instance| !(i.place.is_finite() && i.start.is_finite() && i.speed.is_finite());
        match self.instances.iter().position(bad) {
            Some(i) => Err(Error::invalid(format!("instance {i}"), "is nowhere", "give it numbers for place and time")),
            None => Ok(()),
        }
    }
}
