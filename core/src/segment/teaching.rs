//! What pixels teach: which of them show creature, which background, as far as is known so far, and the evidence that
//! the colours learned from them give for all pixels.

use rayon::prelude::*;

use super::backdrop::Backdrop;
use super::evidence::{Evidence, Lesson, Lessons, Tiles, colour_evidence};
use super::limb_radius::Radii;
use super::painted::Known;
use super::scene::Scene;
use crate::error::Result;
use crate::job::Stage;
use crate::raster::Mask;

/// Distances from a stroke, in radii, up to which all is creature and from which on all is background.
const INSIDE: f32 = 0.7;
const OUTSIDE: f32 = 1.3;
/// Pixels by which an outline is uncertain, however thin the limb.
const MARGIN: f32 = 1.5;
/// Limbs whose tracks are trusted less teach nothing beside their strokes.
const TRUSTED: f32 = 0.5;

/// Who says what is creature.
#[derive(Clone, Copy)]
pub(super) enum Teacher<'m> {
    /// The strokes as drawn on key frames.
    Drawn,
    /// These pixels of tracked strokes.
    Accepted(&'m [Mask]),
    /// Limbs of these radii, in every frame trusted as far as given for each limb.
    Shape(&'m Radii, &'m [Vec<f32>]),
    /// The masks of the last pass.
    Masks(&'m [Mask]),
}

/// What a pixel teaches.
fn lesson(scene: &Scene<'_>, teacher: Teacher<'_>, frame: usize, x: usize, y: usize) -> Lesson {
    match scene.known.get(&frame).map_or(Known::Nothing, |k| k.get(x, y)) {
        Known::Creature => return Lesson::Creature,
        Known::Background => return Lesson::Background,
        Known::Nothing => {}
    }
    if let Teacher::Masks(masks) = teacher {
        return if masks[frame].get(x, y) { Lesson::Creature } else { Lesson::Background };
    }
    let place = scene.fields[frame].get(x, y);
    if scene.cells.of(place).is_none() {
        return Lesson::Background;
    }
    let sample = usize::from(place.sample);
    let limb = usize::from(scene.limbs.limb[sample]);
    let creature = match teacher {
        Teacher::Shape(radii, trust) => {
            let (r, d) = (radii[sample][place.side()], place.distance());
            if d > (OUTSIDE * r).max(r + MARGIN) {
                return Lesson::Background;
            }
            d <= INSIDE * r && scene.limbs.visible[frame][sample] && trust[frame][limb] > TRUSTED
        }
        Teacher::Accepted(accepted) => scene.on_stroke(frame, place) && accepted[frame].get(x, y),
        _ => scene.on_stroke(frame, place) && scene.limbs.drawn[frame][limb],
    };
    if creature { Lesson::Creature } else { Lesson::Nothing }
}

/// Evidence of every frame under the models that are taught, for pixels at most `within` from a stroke.
pub(super) fn evidence(
    scene: &Scene<'_>,
    teacher: Teacher<'_>,
    within: f32,
    stage: Stage<'_>,
) -> Result<Vec<Evidence>> {
    let frames = scene.working.frames.len();
    // Counts are whole numbers: the sum does not depend on how the frames are shared out.
    let all = (0..frames)
        .into_par_iter()
        .try_fold(
            || Lessons::new(scene.limbs),
            |mut lessons, frame| {
                stage.at(0.4 * frame as f64 / frames as f64)?;
                teach(scene, teacher, frame, &mut lessons);
                Ok(lessons)
            },
        )
        .try_reduce(
            || Lessons::new(scene.limbs),
            |mut a, b| {
                a.merge(&b);
                Ok(a)
            },
        )?;
    let colours = all.learn();
    // Strokes alone do not say what is background near them.
    let backdrop = matches!(teacher, Teacher::Shape(..) | Teacher::Masks(_))
        .then(|| Backdrop::learn(scene.working, |f, x, y| lesson(scene, teacher, f, x, y) == Lesson::Background));
    let backdrop = backdrop.flatten();
    scene.each_frame(stage.part(0.4, 1.0), |frame| {
        let near = [frame.checked_sub(2), Some(frame), Some(frame + 2).filter(|&f| f < frames)];
        let lesson = |f: usize, x: usize, y: usize| lesson(scene, teacher, f, x, y);
        let window = &scene.windows[frame];
        let tiles = Tiles::learn(scene.working, near.into_iter().flatten(), window, lesson);
        let place = |x: usize, y: usize| {
            let place = scene.fields[frame].get(x, y);
            (scene.cells.of(place).is_some() && place.distance() <= within).then_some(place)
        };
        let mut evidence = colour_evidence(
            &scene.working.frames[frame],
            window,
            place,
            scene.limbs,
            &colours,
            &tiles,
            backdrop.as_ref(),
        );
        if let Some(known) = scene.known.get(&frame) {
            evidence.overrule(known.data());
        }
        evidence
    })
}

/// Counts what the pixels of a frame teach.
fn teach(scene: &Scene<'_>, teacher: Teacher<'_>, frame: usize, lessons: &mut Lessons) {
    let (image, field) = (&scene.working.frames[frame], &scene.fields[frame]);
    let (columns, rows) = &scene.windows[frame];
    for y in 0..scene.working.height {
        let row = image.row(y);
        if !rows.contains(&y) {
            row.iter().for_each(|&colour| lessons.add_background(colour));
            continue;
        }
        row[..columns.start].iter().for_each(|&colour| lessons.add_background(colour));
        row[columns.end..].iter().for_each(|&colour| lessons.add_background(colour));
        for x in columns.clone() {
            match lesson(scene, teacher, frame, x, y) {
                Lesson::Background => lessons.add_background(row[x]),
                Lesson::Creature => lessons.add_creature(row[x], field.get(x, y), scene.limbs),
                Lesson::Nothing => {}
            }
        }
    }
}
