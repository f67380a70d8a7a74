//! A slot as the engine's own tracker, segmenter and deformer. Here what a plugin gave becomes the engine's, and only
//! here: checked by the post, completed by what the host knows better.

use std::sync::Arc;

use glam::Vec2;
use marey::clip::Clip;
use marey::deform::{Deformation, Deformer, Handle, RestMesh};
use marey::job::Stage;
use marey::motion::{Motion, Track, TrackFrame, TrackKind};
use marey::raster::Mask;
use marey::rig::Rig;
use marey::segment::Segmenter;
use marey::track::Tracker;
use marey::{Error, Result};
use marey_plugin::raw;

use crate::brief::{Brief, point, skeleton};
use crate::door::MeshBrief;
use crate::generation::Generation;
use crate::post::Post;
use crate::refusal::{Refusal, Status};
use crate::slot::Slot;
use crate::worker::Worker;

impl Slot {
    fn output(&self, problem: String) -> Error {
        let remedy = "choose another plugin, and tell its author";
        Refusal::new(Status::Output, format!("plugin {}", self.id), problem, remedy).into()
    }
}

impl Tracker for Slot {
    fn track(&self, clip: &Clip, rig: &Rig, stage: Stage<'_>) -> Result<Motion> {
        let info = clip.info();
        rig.validate(Some(((info.width, info.height), info.frames)))?;
        stage.name("tracking")?;
        let skeleton = skeleton(clip, rig);
        let brief = Arc::new(Brief::new(clip, rig, &skeleton));
        let post = Post::for_tracks(clip, &brief);
        let told = brief.clone();
        self.run(&post, stage, move |instance, post| instance.track(&told, post))?;
        let limbs = post.take_tracks(&brief).map_err(|problem| self.output(problem))?;
        let tracks = limbs.into_iter().enumerate().map(|(l, frames)| Track {
            name: rig.limbs[l].label.clone(),
            kind: TrackKind::Stroke,
            frames: frames
                .into_iter()
                .enumerate()
                .map(|(f, given)| match skeleton.drawn(rig, l, f) {
                    Some(drawn) => TrackFrame::certain(drawn),
                    None => given.unwrap_or_default(),
                })
                .collect(),
        });
        let tracks = tracks.collect();
        let bones = skeleton.limbs.iter().enumerate();
        let bones = bones.filter_map(|(l, c)| Some((rig.limbs[c.parent?].label.clone(), rig.limbs[l].label.clone())));
        Ok(Motion { size: rig.size, fps: info.fps, frames: info.frames, tracks, bones: bones.collect() })
    }
}

impl Segmenter for Slot {
    fn segment(&self, clip: &Clip, rig: &Rig, motion: &Motion, stage: Stage<'_>) -> Result<Vec<Mask>> {
        let info = clip.info();
        rig.validate(Some(((info.width, info.height), info.frames)))?;
        let counts = |t: &Track| {
            let points = t.frames.first().map_or(0, |f| f.points.len());
            let whole = |f: &TrackFrame| [f.points.len(), f.visible.len(), f.confidence.len()] == [points; 3];
            t.frames.len() == info.frames && t.frames.iter().all(whole)
        };
        if motion.tracks.len() != rig.limbs.len() || !motion.tracks.iter().all(counts) {
            return Err(Error::invalid("motion", "is not of this clip and rig", "track them first"));
        }
        stage.name("segmenting")?;
        let brief = Brief::for_segmenter(clip, rig, &skeleton(clip, rig), motion)?;
        let post = Post::for_masks(clip);
        self.run(&post, stage, move |instance, post| instance.segment(&brief, post))?;
        post.take_masks().map_err(|problem| self.output(problem))
    }
}

/// A deformer's slot can be shared with what it bound, which outlives the call.
impl Deformer for Slot {
    fn bind(&self, mesh: RestMesh<'_>, handles: &[Handle], stage: Stage<'_>) -> Result<Box<dyn Deformation>> {
        check_mesh(mesh, handles)?;
        let told =
            MeshBrief { points: mesh.points.iter().copied().map(point).collect(), triangles: mesh.triangles.to_vec() };
        let (count, raw) = (told.points.len(), raw_handles(handles));
        let rest = raw.clone();
        let (bound, generation, worker) =
            self.run(&Post::for_mesh(), stage, move |instance, post| instance.bind(&told, &rest, post))?;
        let slot = self.again();
        Ok(Box::new(Bound {
            slot,
            worker,
            generation,
            bound,
            points: count,
            kinds: raw.iter().map(|h| h.kind).collect(),
        }))
    }
}

impl Slot {
    /// A slot of the same plugin for errors and strikes of what was bound.
    fn again(&self) -> Self {
        Self::new(self.registry.clone(), &self.id, self.kind, crate::slot::Policy::Keep)
    }
}

/// What a plugin bound, on the instance that bound it.
struct Bound {
    slot: Slot,
    worker: Arc<Worker>,
    generation: Arc<Generation>,
    bound: u64,
    points: usize,
    kinds: Vec<i32>,
}

impl Deformation for Bound {
    fn solve(&mut self, targets: &[Handle], points: &mut [Vec2], stage: Stage<'_>) -> Result<()> {
        let raw = raw_handles(targets);
        if !raw.iter().map(|h| h.kind).eq(self.kinds.iter().copied()) {
            return Err(Error::invalid("handles", "are not those that were bound", "bind the mesh to them first"));
        }
        if points.len() != self.points {
            let problem = format!("the shape has {} points, and {} were bound", points.len(), self.points);
            return Err(Error::invalid("points", problem, "give one for each point of the mesh"));
        }
        check_finite(targets, points)?;
        let post = Post::for_mesh();
        let mut moved: Vec<raw::Point> = points.iter().copied().map(point).collect();
        let bound = self.bound;
        let work = move |instance: &mut dyn crate::door::Instance, post: &Post| {
            instance.solve(bound, &raw, &mut moved, post).map(|()| moved)
        };
        let moved = self.slot.on(&self.worker, &self.generation, &post, stage, work).map_err(|(error, _)| error)?;
        if let Some(i) = moved.iter().position(|p| !p.is_finite()) {
            return Err(self.slot.output(format!("point {i} is ({}, {})", moved[i].x, moved[i].y)));
        }
        points.iter_mut().zip(moved).for_each(|(to, p)| *to = Vec2::new(p.x, p.y));
        Ok(())
    }
}

impl Drop for Bound {
    fn drop(&mut self) {
        let bound = self.bound;
        self.worker.send(move |instance| instance.unbind(bound));
    }
}

fn raw_handles(handles: &[Handle]) -> Vec<raw::Handle> {
    let raw = |kind, a, b| raw::Handle { kind, reserved0: 0, a: point(a), b: point(b) };
    let each = handles.iter().map(|handle| match *handle {
        Handle::Point(at) => raw(raw::HANDLE_POINT, at, at),
        Handle::Bone(root, tip) => raw(raw::HANDLE_BONE, root, tip),
    });
    each.collect()
}

fn check_finite(handles: &[Handle], points: &[Vec2]) -> Result<()> {
    if let Some(i) = handles.iter().position(|h| !h.is_finite()) {
        return Err(Error::invalid(format!("handle {i}"), "is not a number", "give it a place"));
    }
    if let Some(i) = points.iter().position(|p| !p.is_finite()) {
        return Err(Error::invalid(format!("point {i} of the mesh"), "is not a number", "give it a place"));
    }
    Ok(())
}

fn check_mesh(mesh: RestMesh<'_>, handles: &[Handle]) -> Result<()> {
    if mesh.triangles.is_empty() {
        return Err(Error::invalid("mesh", "has no triangles", "give at least one"));
    }
    if u32::try_from(mesh.points.len()).is_err() || u32::try_from(mesh.triangles.len()).is_err() {
        return Err(Error::invalid("mesh", "is too large", "use a coarser one"));
    }
    let count = mesh.points.len();
    if let Some(t) = mesh.triangles.iter().position(|t| t.iter().any(|i| *i as usize >= count)) {
        let problem = format!("names a vertex past the last, {}", count.saturating_sub(1));
        return Err(Error::invalid(format!("triangle {t}"), problem, "vertices count from 0"));
    }
    check_finite(handles, mesh.points)
}
