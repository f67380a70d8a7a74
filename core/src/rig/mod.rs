//! What the user drew: labelled limbs, strokes on key frames, painted hints, and the tree they make.

mod joint_marks;
mod point_marks;
mod skeleton;
mod strokes_file;

pub use joint_marks::{JointMark, JointMarks};
pub use point_marks::{PointKey, PointMark, PointMarks};
pub use skeleton::{LimbChain, Skeleton};

use glam::Vec2;
use std::path::PathBuf;

use crate::error::{Error, Result};

/// Which of a pair a limb is, seen from the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Of a pair, the one toward the viewer.
    Near,
    /// Of a pair, the one away from the viewer, often hidden.
    Far,
    /// Not of a pair: body, neck, head, tail.
    Mid,
}

/// Whether a stroke points toward the viewer or away, for limbs that leave the image plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Facing {
    /// Its end is nearer to the viewer than its start.
    Toward,
    /// Its end is farther from the viewer than its start.
    Away,
}

/// A body part that does not branch.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limb {
    /// The user's name for it, unique in the rig.
    pub label: String,
    /// Its side, where it is one of a pair.
    pub side: Option<Side>,
}

/// A limb as drawn on one frame.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stroke {
    /// Index into [`Rig::limbs`].
    pub limb: usize,
    /// At least two points, from the limb's start to its end, in clip pixels. They may lie outside the image.
    pub points: Vec<Vec2>,
    /// Whether it leaves the image plane, where the user said so.
    pub facing: Option<Facing>,
}

/// A brush stroke that says what belongs to the creature.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paint {
    /// Creature or background.
    pub foreground: bool,
    /// Brush radius in clip pixels.
    pub radius: f32,
    /// The brush's path in clip pixels.
    pub points: Vec<Vec2>,
}

/// Where a limb is in depth, as the user said on one frame. It holds on that frame and fades toward the limb's key
/// frames around it; a limb may be marked where it is not drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimbDepth {
    /// Index into [`Rig::limbs`].
    pub limb: usize,
    /// How far its free part stands from where it would, in clip pixels toward the viewer.
    pub depth: Option<f32>,
    /// How far its free end stands from where it is held, in clip pixels toward the viewer, in place of what its
    /// length in the image says.
    pub bend: Option<f32>,
}

/// All that the user did on one frame.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyFrame {
    /// The frame, counted from 0.
    pub frame: usize,
    /// At most one stroke a limb.
    pub strokes: Vec<Stroke>,
    /// Where limbs are in depth, at most one entry a limb.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub depths: Vec<LimbDepth>,
    /// Painted hints for the segmenter.
    pub paint: Vec<Paint>,
    /// A whole painted mask (an 8-bit image of the clip's size), where the user gave one.
    pub mask: Option<PathBuf>,
}

/// The user's whole input for a clip.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rig {
    /// Width and height of the clip that was drawn on.
    pub size: (u32, u32),
    /// The limbs, in the user's order.
    pub limbs: Vec<Limb>,
    /// Key frames by rising frame.
    pub keyframes: Vec<KeyFrame>,
}

/// Strokes farther outside the image than this many image sizes are a mistake, not a limb that leaves the picture.
const MAX_OUTSIDE: f32 = 2.0;
/// Bounds that keep a hostile file from eating the machine.
const MAX_LIMBS: usize = 256;
const MAX_KEYFRAMES: usize = 100_000;
const MAX_POINTS: usize = 10_000;

impl Rig {
    /// Checks everything that trackers rely on. `frames` is the clip's frame count and `size` its size, when known.
    pub fn validate(&self, clip: Option<((u32, u32), usize)>) -> Result<()> {
        if let Some((size, _)) = clip
            && size != self.size
        {
            return Err(Error::invalid(
                "strokes",
                format!("drawn on {}x{}, but the clip is {}x{}", self.size.0, self.size.1, size.0, size.1),
                "scale the strokes or use the clip they were drawn on",
            ));
        }
        self.validate_draft()?;
        for (i, limb) in self.limbs.iter().enumerate() {
            if self.keys_of(i).next().is_none() {
                let what = format!("limb `{}`", limb.label);
                return Err(Error::invalid(what, "has no stroke", "draw it on a key frame or remove it"));
            }
        }
        if self.keyframes.iter().all(|k| k.strokes.is_empty()) {
            return Err(Error::invalid("strokes", "no key frame has a stroke", "draw each limb on one frame"));
        }
        if let (Some((_, frames)), Some(last)) = (clip, self.keyframes.last())
            && last.frame >= frames
        {
            return Err(Error::invalid(
                format!("key frame {}", last.frame),
                format!("is past the clip's last frame {}", frames.saturating_sub(1)),
                "frames count from 0",
            ));
        }
        Ok(())
    }

    /// Checks what holds of a rig from its first stroke on, finished or not.
    pub fn validate_draft(&self) -> Result<()> {
        let counts = [("limbs", self.limbs.len(), MAX_LIMBS), ("key frames", self.keyframes.len(), MAX_KEYFRAMES)];
        if let Some((what, value, max)) = counts.into_iter().find(|(_, value, max)| value > max) {
            return Err(Error::Limit {
                what: format!("the number of {what}"),
                value: value as u64,
                max: max as u64,
                remedy: "draw one limb for each body part, on the frames that need it".into(),
            });
        }
        for (i, limb) in self.limbs.iter().enumerate() {
            if limb.label.trim().is_empty() {
                return Err(Error::invalid(format!("limb {i}"), "has no label", "give each limb a name"));
            }
            if self.limbs[..i].iter().any(|other| other.label == limb.label) {
                let what = format!("limb `{}`", limb.label);
                return Err(Error::invalid(what, "is listed twice", "give each limb its own label"));
            }
        }
        if (self.size.0 == 0 || self.size.1 == 0) && !self.keyframes.is_empty() {
            return Err(Error::invalid("strokes", "the size is empty", "give the clip's width and height"));
        }
        for pair in self.keyframes.windows(2) {
            if pair[0].frame >= pair[1].frame {
                return Err(Error::invalid(
                    format!("key frame {}", pair[1].frame),
                    "is listed twice or out of order",
                    "list each frame once",
                ));
            }
        }
        self.keyframes.iter().try_for_each(|key| self.validate_key(key))
    }

    fn validate_key(&self, key: &KeyFrame) -> Result<()> {
        let named = |limb: usize, what: &str| {
            let labelled = self.limbs.get(limb).map(|l| format!("limb `{}` on key frame {}", l.label, key.frame));
            labelled.ok_or_else(|| {
                Error::invalid(
                    format!("key frame {}", key.frame),
                    format!("a {what} is of limb {limb}, and there are {}", self.limbs.len()),
                    "add the limb first",
                )
            })
        };
        for (i, stroke) in key.strokes.iter().enumerate() {
            let what = named(stroke.limb, "stroke")?;
            if key.strokes[..i].iter().any(|other| other.limb == stroke.limb) {
                return Err(Error::invalid(what, "is drawn twice", "keep one stroke for each limb and frame"));
            }
            self.validate_points(&what, &stroke.points, 2)?;
            if crate::geometry::polyline::length(&stroke.points) < 1.0 {
                return Err(Error::invalid(what, "is shorter than a pixel", "draw along the whole body part"));
            }
        }
        for (i, mark) in key.depths.iter().enumerate() {
            let what = named(mark.limb, "depth")?;
            if key.depths[..i].iter().any(|other| other.limb == mark.limb) {
                return Err(Error::invalid(what, "has two depths", "keep one for each limb and frame"));
            }
            self.validate_depth(&what, mark.depth, mark.bend)?;
        }
        for paint in &key.paint {
            let what = format!("paint on key frame {}", key.frame);
            self.validate_points(&what, &paint.points, 1)?;
            if !(paint.radius.is_finite() && paint.radius > 0.0) {
                return Err(Error::invalid(what, "the radius is no positive number", "give it in pixels"));
            }
        }
        Ok(())
    }

    /// Checks a depth and a bend: real numbers, within what a limb can be off the image plane.
    fn validate_depth(&self, what: &str, depth: Option<f32>, bend: Option<f32>) -> Result<()> {
        let most = MAX_OUTSIDE * self.size.0.max(self.size.1) as f32;
        for (name, value) in [("depth", depth), ("bend", bend)] {
            if value.is_some_and(|v| !(-most..=most).contains(&v)) {
                let problem = format!("its {name} is {}", value.unwrap_or_default());
                return Err(Error::invalid(what, problem, format!("give clip pixels, {most} at most")));
            }
        }
        Ok(())
    }

    fn validate_points(&self, what: &str, points: &[Vec2], at_least: usize) -> Result<()> {
        if points.len() < at_least {
            let problem = format!("has {} point{}", points.len(), if points.len() == 1 { "" } else { "s" });
            return Err(Error::invalid(what, problem, format!("draw at least {at_least}")));
        }
        if points.len() > MAX_POINTS {
            return Err(Error::Limit {
                what: format!("the number of points of {what}"),
                value: points.len() as u64,
                max: MAX_POINTS as u64,
                remedy: "simplify the stroke".into(),
            });
        }
        let size = Vec2::new(self.size.0 as f32, self.size.1 as f32);
        for (i, p) in points.iter().enumerate() {
            if !p.is_finite() {
                return Err(Error::invalid(format!("{what}, point {i}"), "is not a number", "remove the point"));
            }
            let far = size * MAX_OUTSIDE;
            if p.cmplt(-far).any() || p.cmpgt(size + far).any() {
                return Err(Error::invalid(
                    format!("{what}, point {i}"),
                    format!("({}, {}) is far outside the {}x{} image", p.x, p.y, self.size.0, self.size.1),
                    "give pixels of the clip",
                ));
            }
        }
        Ok(())
    }

    /// The stroke of `limb` on key frame `frame`, where there is one.
    pub fn stroke(&self, limb: usize, frame: usize) -> Option<&Stroke> {
        let key = self.keyframes.iter().find(|k| k.frame == frame)?;
        key.strokes.iter().find(|s| s.limb == limb)
    }

    /// The frames on which `limb` is drawn, rising.
    pub fn keys_of(&self, limb: usize) -> impl Iterator<Item = (usize, &Stroke)> {
        self.keyframes.iter().filter_map(move |k| k.strokes.iter().find(|s| s.limb == limb).map(|s| (k.frame, s)))
    }

    /// What is said of `limb`'s depth over time: the frames on which it is drawn or `said` gives something, rising, with
    /// what is said there.
    pub fn depth_keys(&self, limb: usize, said: impl Fn(&LimbDepth) -> Option<f32>) -> Vec<(usize, Option<f32>)> {
        let key = |k: &KeyFrame| {
            let value = k.depths.iter().find(|d| d.limb == limb).and_then(&said);
            (value.is_some() || k.strokes.iter().any(|s| s.limb == limb)).then_some((k.frame, value))
        };
        self.keyframes.iter().filter_map(key).collect()
    }

    /// The longest drawn length of `limb` in pixels: the length hint of a drawing tool.
    pub fn length_hint(&self, limb: usize) -> f32 {
        self.keys_of(limb).map(|(_, s)| crate::geometry::polyline::length(&s.points)).fold(0.0, f32::max)
    }

    /// The other limb of a pair: the limb of the opposite side whose strokes start nearest to this one's, on the first
    /// frame where both are drawn; labels that differ only in the side's word (`hind_near`, `hind_far`) win.
    pub fn twin(&self, limb: usize) -> Option<usize> {
        let opposite = match self.limbs.get(limb)?.side? {
            Side::Near => Side::Far,
            Side::Far => Side::Near,
            Side::Mid => return None,
        };
        let bare = |label: &str| label.to_lowercase().replace("near", "").replace("far", "");
        let own = bare(&self.limbs[limb].label);
        let candidates = (0..self.limbs.len()).filter(|&l| self.limbs[l].side == Some(opposite));
        let by_name: Vec<usize> = candidates.clone().filter(|&l| bare(&self.limbs[l].label) == own).collect();
        if by_name.len() == 1 {
            return by_name.first().copied();
        }
        let gap = |other: usize| {
            self.keyframes
                .iter()
                .find_map(|k| {
                    let start = |l| k.strokes.iter().find(|s| s.limb == l).map(|s| s.points[0]);
                    start(limb).zip(start(other)).map(|(a, b)| a.distance(b))
                })
                .unwrap_or(f32::INFINITY)
        };
        candidates
            .map(|l| (gap(l), l))
            .filter(|(g, _)| g.is_finite())
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, l)| l)
    }
}
