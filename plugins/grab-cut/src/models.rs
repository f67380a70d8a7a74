//! What creature and background look like, learnt from labelled frames.
//!
//! The same colour on both sides is what defeats a plain GrabCut. Here a sample is a colour at a place: the creature's
//! on the creature itself, as it lay in one pose, the background's in the picture, for a while at a time. A white flank
//! then does not claim the white stones behind the legs.

use glam::{Vec2, vec2};

use crate::footage::Limb;
use crate::limb_field::Place;
use crate::mixture::{Mixture, Sample};
use crate::window::View;

/// Samples that one mixture is fitted to.
pub(crate) const SAMPLES: usize = 9000;
/// Variances of what the numbers are exact to: colour levels, and places in the unit of [`Atlas`].
const COLOUR_FLOOR: f32 = 8.0;
const PLACE_FLOOR: f32 = 4.0;
/// Share of colours that are any at all: how surprising is one that was never seen. At 0.2 for the creature, which is
/// seen less of, drawn animals gained a point or two of J, and a black swan on dark water lost twenty.
const ANY: f32 = 0.02;

/// Turns places into numbers that weigh like colours.
pub(crate) struct Atlas {
    /// The pose in which places on the creature are named.
    rest: Vec<Limb>,
    /// Levels for a pixel.
    unit: f32,
}

impl Atlas {
    /// `levels` for the whole size of the creature.
    pub(crate) fn new(rest: &[Limb], levels: f32) -> Self {
        let (low, high) = crate::window::bounds(rest);
        let size = (high - low).length();
        Self { rest: rest.to_vec(), unit: if size > 0.0 && size.is_finite() { levels / size } else { 0.0 } }
    }

    /// The sample of a pixel as background.
    pub(crate) fn in_picture(&self, colour: [u8; 3], at: Vec2) -> Sample {
        sample(colour, at * self.unit)
    }

    /// The sample of a pixel as creature. `factor` is the pixels for one unit of the place's offset.
    pub(crate) fn on_creature(&self, colour: [u8; 3], place: &Place, factor: f32) -> Sample {
        let points = &self.rest[usize::from(place.limb)].points;
        let (at, tangent) = point_at(points, place.along);
        let away = if place.beyond == 0 {
            vec2(-tangent.y, tangent.x) * place.offset
        } else {
            tangent * place.offset.abs() * f32::from(place.beyond)
        };
        sample(colour, (at + away * factor) * self.unit)
    }
}

fn sample(colour: [u8; 3], at: Vec2) -> Sample {
    let [r, g, b] = colour.map(f32::from);
    [at.x, at.y, r, g, b]
}

/// The point at a share of a polyline's length, and the direction there.
fn point_at(points: &[Vec2], along: f32) -> (Vec2, Vec2) {
    let total: f32 = points.windows(2).map(|p| p[0].distance(p[1])).sum();
    let mut left = along.clamp(0.0, 1.0) * total;
    let mut last = (points.first().copied().unwrap_or_default(), Vec2::X);
    for pair in points.windows(2) {
        let length = pair[0].distance(pair[1]);
        if length <= 0.0 {
            continue;
        }
        let tangent = (pair[1] - pair[0]) / length;
        if left <= length {
            return (pair[0] + tangent * left, tangent);
        }
        left -= length;
        last = (pair[1], tangent);
    }
    last
}

/// Both sides' mixtures, where there was anything to fit them to.
pub(crate) struct Models {
    creature: Option<Mixture>,
    background: Option<Mixture>,
}

/// A mixture of samples, where there are any.
pub(crate) fn fit(samples: &[Sample], components: usize) -> Option<Mixture> {
    Mixture::fit(samples, components, [PLACE_FLOOR, PLACE_FLOOR, COLOUR_FLOOR, COLOUR_FLOOR, COLOUR_FLOOR], ANY)
}

impl Models {
    pub(crate) fn new(creature: Option<Mixture>, background: Option<Mixture>) -> Self {
        Self { creature, background }
    }

    /// How much likelier the creature is than the background, as a natural logarithm; 0 where a side is unknown.
    pub(crate) fn evidence(&self, as_creature: &Sample, as_background: &Sample) -> f32 {
        match (&self.creature, &self.background) {
            (Some(c), Some(b)) => c.log_colour_at_place(as_creature) - b.log_colour_at_place(as_background),
            _ => 0.0,
        }
    }
}

/// Every `n`th of the samples, so that at most [`SAMPLES`] are left.
pub(crate) fn thin(samples: Vec<Sample>) -> Vec<Sample> {
    let step = samples.len().div_ceil(SAMPLES).max(1);
    samples.into_iter().step_by(step).collect()
}

/// The samples of a labelled view: the creature's and the background's, every `step`th pixel.
pub(crate) fn samples(
    atlas: &Atlas,
    view: &View,
    step: usize,
    label: impl Fn(usize) -> Option<bool>,
) -> (Vec<Sample>, Vec<Sample>) {
    let (mut creature, mut background) = (Vec::new(), Vec::new());
    let w = view.window;
    for i in (0..w.len()).step_by(step) {
        match (label(i), view.place(i)) {
            (Some(true), Some(place)) => {
                creature.push(atlas.on_creature(view.colours[i], &place, w.factor as f32));
            }
            (Some(false), _) => background.push(atlas.in_picture(view.colours[i], centre(view, i))),
            _ => {}
        }
    }
    (creature, background)
}

/// The middle of a block in the frame.
pub(crate) fn centre(view: &View, index: usize) -> Vec2 {
    let w = view.window;
    vec2((w.left + index % w.width) as f32 + 0.5, (w.top + index / w.width) as f32 + 0.5) * w.factor as f32
}
