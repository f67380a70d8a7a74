//! A vector drawing, and how points hold it: what a person said, with what the machine proposes for the rest.

use std::sync::Arc;

use eframe::egui::{Vec2, vec2};
use marey_binding::{BoundPoint, Context, Drawing, Motion, MotionUse, Result};

/// The drawing of the document, read.
pub(crate) struct Sheet {
    /// What it was read from.
    pub(crate) of: Arc<Vec<u8>>,
    pub(crate) drawing: Drawing,
    pub(crate) strokes: Vec<String>,
    pub(crate) size: Vec2,
}

/// How the drawing is held, as it is now: what a person said, and what the machine proposes for the rest.
pub(crate) struct Held {
    pub(crate) json: String,
    pub(crate) points: Vec<BoundPoint>,
    pub(crate) how: MotionUse,
    pub(crate) stiffness: f32,
}

impl Sheet {
    pub(crate) fn read(context: &Context, of: &Arc<Vec<u8>>) -> Result<Self> {
        let drawing = context.drawing_from_svg(&String::from_utf8_lossy(of))?;
        let info = drawing.info()?;
        let strokes = (0..info.strokes).map(|i| drawing.stroke(i).map(|s| s.name)).collect::<Result<_>>()?;
        let size = vec2(info.size.0 as f32, info.size.1 as f32);
        Ok(Self { of: of.clone(), drawing, strokes, size })
    }
}

/// What a person said of how a drawing is held, with the machine's proposal for points that were marked since; none where
/// there is no proposal for them yet. Points that a person left off the drawing do not hold it.
pub(crate) fn held(
    context: &Context,
    sheet: &Sheet,
    motion: &Motion,
    (said, proposed): (Option<&str>, Option<&str>),
    is_on: impl Fn(&str) -> bool,
) -> Result<Option<Held>> {
    let tracks = motion.info()?.tracks;
    let read = |json: Option<&str>| json.map(|json| context.binding_from_json(json)).transpose();
    let (said, proposed) = (read(said)?, read(proposed)?);
    let Some(binding) = said.as_ref().or(proposed.as_ref()) else { return Ok(None) };
    let there = binding.points()?;
    let is_there = |track: &String| there.iter().any(|p| p.track == *track);
    if !tracks.iter().filter(|track| is_on(track)).all(is_there) && said.is_some() {
        let Some(proposed) = &proposed else { return Ok(None) };
        for point in proposed.points()?.iter().filter(|p| !is_there(&p.track)) {
            binding.set_point("", &point.track, point.index, point.at, "")?;
        }
    }
    for gone in binding.points()?.iter().filter(|p| !(tracks.contains(&p.track) && is_on(&p.track))) {
        binding.remove_point("", &gone.track, gone.index)?;
    }
    binding.validate(&sheet.drawing)?;
    let stiffness = sheet.strokes.first().map_or(Ok(1.0), |stroke| binding.stroke(stroke).map(|s| s.0))?;
    Ok(Some(Held { json: binding.to_json()?, points: binding.points()?, how: binding.motion(0)?, stiffness }))
}
