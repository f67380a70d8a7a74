//! What the user drew.

use crate::point::Point;

/// Which of a pair a limb is, seen from the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Of a pair, the one toward the viewer.
    Near,
    /// Of a pair, the one away from the viewer, often hidden.
    Far,
    /// Not of a pair: body, neck, head, tail.
    Mid,
}

/// Whether a stroke points toward the viewer or away.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Facing {
    /// Its end is nearer to the viewer than its start.
    Toward,
    /// Its end is farther from the viewer than its start.
    Away,
}

/// A body part that does not branch.
#[derive(Clone, Debug, PartialEq)]
pub struct Limb<'a> {
    /// The user's name for it, unique in the rig.
    pub label: &'a str,
    /// Its side, where the user said so.
    pub side: Option<Side>,
    /// The limb it hangs from.
    pub parent: Option<usize>,
    /// How many points it has, in every stroke and in every frame; at least 2.
    pub points: usize,
    /// Whether its first point is the end that hangs from the parent.
    pub rooted_at_start: bool,
    /// Whether nothing hangs from the other end.
    pub terminal: bool,
}

/// A limb as drawn on one frame, at equal steps from its start to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke<'a> {
    /// Index into [`Rig::limbs`].
    pub limb: usize,
    /// The frame.
    pub frame: usize,
    /// As many points as the limb has. They may lie outside the image.
    pub points: &'a [Point],
    /// Whether it leaves the image plane, where the user said so.
    pub facing: Option<Facing>,
}

/// A brush stroke that says what belongs to the creature, or does not.
#[derive(Clone, Debug, PartialEq)]
pub struct Paint<'a> {
    /// The frame.
    pub frame: usize,
    /// Creature or background.
    pub foreground: bool,
    /// The brush's radius in pixels.
    pub radius: f32,
    /// The brush's path.
    pub points: &'a [Point],
}

/// A whole mask that the user painted.
#[derive(Clone, Debug, PartialEq)]
pub struct Painted<'a> {
    /// The frame.
    pub frame: usize,
    /// A byte a pixel, 255 in and 0 out, rows of the clip's width from the top.
    pub pixels: &'a [u8],
}

/// The user's whole input for a clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rig<'a> {
    /// The limbs, in the user's order.
    pub limbs: Vec<Limb<'a>>,
    /// What was drawn, by rising frame; a limb at most once on a frame.
    pub strokes: Vec<Stroke<'a>>,
    /// What was painted, by rising frame. Trackers get none.
    pub paints: Vec<Paint<'a>>,
    /// Whole masks, by rising frame. Trackers get none.
    pub painted: Vec<Painted<'a>>,
}

impl<'a> Rig<'a> {
    /// The stroke of `limb` on `frame`, where it is drawn there.
    pub fn stroke(&self, limb: usize, frame: usize) -> Option<&Stroke<'a>> {
        self.strokes_of(limb).find(|s| s.frame == frame)
    }

    /// The strokes of `limb`, by rising frame.
    pub fn strokes_of(&self, limb: usize) -> impl Iterator<Item = &Stroke<'a>> {
        self.strokes.iter().filter(move |s| s.limb == limb)
    }

    /// The stroke of `limb` on `frame` or the nearest one before it, or else the first one after it.
    pub fn last_stroke(&self, limb: usize, frame: usize) -> Option<&Stroke<'a>> {
        let before = self.strokes_of(limb).take_while(|s| s.frame <= frame).last();
        before.or_else(|| self.strokes_of(limb).next())
    }

    /// The first stroke of `limb` after `frame`.
    pub fn next_stroke(&self, limb: usize, frame: usize) -> Option<&Stroke<'a>> {
        self.strokes_of(limb).find(|s| s.frame > frame)
    }
}
