//! What all passes over a clip share: its frames, its limbs, limb coordinates of every pixel, and what was painted.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::painted::{Known, Painted};
use super::params::SegmentParams;
use super::stroke_field::{Cells, NOWHERE, Place, stroke_field};
use super::working::{Limbs, Working};
use crate::error::Result;
use crate::job::Stage;
use crate::raster::{Grid, Mask};

/// Pixels this near to a stroke lie on it, in working pixels.
pub(super) const STROKE_WIDTH: f32 = 1.5;

/// The clip as the passes see it, at working size.
pub(super) struct Scene<'a> {
    pub(super) working: &'a Working,
    pub(super) limbs: &'a Limbs,
    pub(super) params: &'a SegmentParams,
    pub(super) cells: Cells,
    /// For every frame the limb coordinates of its pixels.
    pub(super) fields: Vec<Grid<Place>>,
    /// For every frame the columns and rows within which creature can be.
    pub(super) windows: Vec<(Range<usize>, Range<usize>)>,
    /// What the user painted.
    pub(super) known: BTreeMap<usize, Grid<Known>>,
    /// The masks of frames that are painted all over.
    pub(super) painted: BTreeMap<usize, Mask>,
    /// The creature's size in pixels.
    pub(super) extent: f32,
}

impl<'a> Scene<'a> {
    pub(super) fn new(
        working: &'a Working,
        limbs: &'a Limbs,
        params: &'a SegmentParams,
        painted: &Painted,
        stage: Stage<'_>,
    ) -> Result<Self> {
        let extent = limbs.extent();
        let cells = Cells::new(limbs.len(), params.reach * extent);
        let known = painted.reduced(working.width, working.height);
        let prepared = each_frame(working.frames.len(), stage, |frame| {
            let field = stroke_field(limbs, frame, working.width, working.height);
            // Creature may be painted anywhere.
            let window = match known.contains_key(&frame) {
                true => (0..working.width, 0..working.height),
                false => window(&field, cells),
            };
            Ok((field, window))
        })?;
        let (fields, windows) = prepared.into_iter().unzip();
        let whole = known.iter().filter(|(_, k)| k.data().iter().all(|&p| p != Known::Nothing));
        let mask = |k: &Grid<Known>| Mask::from_fn(k.width(), k.height(), |x, y| k.get(x, y) == Known::Creature);
        let painted = whole.map(|(&frame, k)| (frame, mask(k))).collect();
        Ok(Self { working, limbs, params, cells, fields, windows, known, painted, extent })
    }

    /// Runs `work` for every frame side by side; results in order.
    pub(super) fn each_frame<T: Send>(&self, stage: Stage<'_>, work: impl Fn(usize) -> T + Sync) -> Result<Vec<T>> {
        each_frame(self.working.frames.len(), stage, |frame| Ok(work(frame)))
    }

    /// Whether a pixel lies on a part of a stroke that should show creature.
    pub(super) fn on_stroke(&self, frame: usize, place: Place) -> bool {
        place.sample != NOWHERE && place.distance() <= STROKE_WIDTH && {
            let sample = usize::from(place.sample);
            self.limbs.trusted[sample] && self.limbs.visible[frame][sample]
        }
    }
}

/// The columns and rows that have a cell.
fn window(field: &Grid<Place>, cells: Cells) -> (Range<usize>, Range<usize>) {
    let mut found: Option<(Range<usize>, Range<usize>)> = None;
    for y in 0..field.height() {
        for (x, &place) in field.row(y).iter().enumerate() {
            if cells.of(place).is_some() {
                let (columns, rows) = found.unwrap_or((x..x + 1, y..y + 1));
                found = Some((columns.start.min(x)..columns.end.max(x + 1), rows.start..y + 1));
            }
        }
    }
    found.unwrap_or((0..0, 0..0))
}

/// Runs `work` for every frame side by side; results in order.
pub(super) fn each_frame<T: Send>(
    frames: usize,
    stage: Stage<'_>,
    work: impl Fn(usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let done: Vec<Result<T>> = (0..frames)
        .into_par_iter()
        .map(|frame| {
            stage.at(frame as f64 / frames as f64)?;
            work(frame)
        })
        .collect();
    done.into_iter().collect()
}
