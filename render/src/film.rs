//! Pictures over time: an animation played, a turn around a frame, or both.

use std::path::{Path, PathBuf};

use marey::Result;
use marey::export::animation::{self, Animation, AnimationFormat};
use marey::job::Stage;

use crate::{Picture, Renderer, Scene};

/// Pictures of a scene over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// How the first frame is looked at.
    pub picture: Picture,
    /// How many pictures there are.
    pub frames: usize,
    /// Pictures a second.
    pub fps: f64,
    /// The scene's frame in the first picture.
    pub first: usize,
    /// Whether the scene moves; it starts anew at its end.
    pub plays: bool,
    /// How often the camera goes around, to the right, from the first picture to the one after the last.
    pub turns: f32,
}

impl Film {
    /// The scene's own animation from where the picture looks.
    pub fn of(scene: &Scene, picture: Picture) -> Self {
        Self { picture, frames: scene.frames, fps: scene.fps, first: 0, plays: true, turns: 0.0 }
    }

    /// The scene's frame and the view of it in a picture.
    pub fn at(&self, scene: &Scene, index: usize) -> (usize, Picture) {
        let frame = if self.plays { (self.first + index) % scene.frames.max(1) } else { self.first };
        let mut picture = self.picture;
        picture.camera.yaw += 360.0 * (self.turns * index as f32 / self.frames.max(1) as f32 % 1.0);
        (frame, picture)
    }

    /// Draws all pictures and writes them. Says which files that made; of a folder of pictures, the folder.
    ///
    /// # Errors
    /// What [`Renderer::draw`] and [`animation::write`] say, a cancel. What was there before then stays as it was.
    pub fn write(
        &self,
        renderer: &Renderer,
        scene: &Scene,
        path: &Path,
        format: AnimationFormat,
        stage: Stage<'_>,
    ) -> Result<Vec<PathBuf>> {
        stage.name("measuring")?;
        scene.extent(stage.part(0.0, 0.02))?;
        let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let draw = |index: usize| {
            let (frame, picture) = self.at(scene, index);
            renderer.draw(scene, frame, &picture, stage)
        };
        let (size, pivot) = (self.picture.size, [0.5, 0.5]);
        let film = Animation { name: &name, frames: self.frames, fps: self.fps, size, pivot, draw: &draw };
        animation::write(path, format, &film, stage.part(0.02, 1.0))
    }
}
