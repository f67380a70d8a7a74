//! What a tracker gives back.

use crate::clip::Clip;
use crate::point::Point;
use crate::rig::Rig;

/// A limb in every frame, flat: `frames * points` entries, frame after frame.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbTrack {
    /// How many points the limb has.
    pub points: usize,
    /// Where they are.
    pub places: Vec<Point>,
    /// 1 for each that is seen, 0 for one that is hidden or outside the image.
    pub visible: Vec<u8>,
    /// How far each place is to be trusted, 0 to 1.
    pub confidence: Vec<f32>,
}

/// Every limb in every frame. On frames where a limb is drawn the host keeps the drawn stroke, whatever stands here.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracks {
    /// One a limb, in the rig's order.
    pub limbs: Vec<LimbTrack>,
}

impl Tracks {
    /// Room for all limbs of `rig` in all frames of `clip`: everything seen, certain and at (0, 0).
    pub fn new(clip: &Clip<'_>, rig: &Rig<'_>) -> Self {
        let limb = |points: usize| {
            let count = clip.frames() * points;
            LimbTrack {
                points,
                places: vec![Point::default(); count],
                visible: vec![1; count],
                confidence: vec![1.0; count],
            }
        };
        Self { limbs: rig.limbs.iter().map(|l| limb(l.points)).collect() }
    }

    /// Puts `limb` on `frame`. Points past the limb's own number are dropped; a limb or frame that there is not is
    /// passed over.
    pub fn set(&mut self, limb: usize, frame: usize, points: &[Point]) {
        if let Some(to) = self.limbs.get_mut(limb).and_then(|l| part(&mut l.places, frame, l.points)) {
            to.iter_mut().zip(points).for_each(|(to, p)| *to = *p);
        }
    }

    /// Says which points of `limb` are seen on `frame`, as [`Self::set`].
    pub fn set_visible(&mut self, limb: usize, frame: usize, visible: &[bool]) {
        if let Some(to) = self.limbs.get_mut(limb).and_then(|l| part(&mut l.visible, frame, l.points)) {
            to.iter_mut().zip(visible).for_each(|(to, v)| *to = u8::from(*v));
        }
    }

    /// Says how far the places of `limb` on `frame` are to be trusted, as [`Self::set`].
    pub fn set_confidence(&mut self, limb: usize, frame: usize, confidence: &[f32]) {
        if let Some(to) = self.limbs.get_mut(limb).and_then(|l| part(&mut l.confidence, frame, l.points)) {
            to.iter_mut().zip(confidence).for_each(|(to, c)| *to = *c);
        }
    }

    /// Where `limb` is on `frame`; empty for one that there is not.
    pub fn get(&self, limb: usize, frame: usize) -> &[Point] {
        self.limbs
            .get(limb)
            .and_then(|l| l.places.get(frame.checked_mul(l.points)?..(frame + 1).checked_mul(l.points)?))
            .unwrap_or(&[])
    }
}

fn part<T>(all: &mut [T], frame: usize, each: usize) -> Option<&mut [T]> {
    let start = frame.checked_mul(each)?;
    all.get_mut(start..start.checked_add(each)?)
}
