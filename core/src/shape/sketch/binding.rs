//! How motions hold a drawing, and bind.json, its file.
//!
//! `{"format":"marey-bind","version":1,"size":[W,H],"motions":[{"name","scale","rotation","mirror","frame","travel","repeat"}],
//! "points":[{"motion","track","index","at":[x,y],"layer"}],"pins":[{"at":[x,y],"layer"}],
//! "strokes":[{"stroke","rigidity","decoration"}],"layers":[{"name","strokes":[..]}],"joints":[{"layers":[a,b],"at":[x,y]}]}`.
//! Unknown keys are ignored, an unknown version is an error.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::Drawing;
use crate::error::{Error, Result};
use crate::motion::Motion;

const FORMAT: &str = "marey-bind";
const VERSION: u32 = 1;
/// Bounds that keep a hostile file from eating the machine. A stroke is a name in a list, a point a row of a system.
const MAX_HANDLES: usize = 1024;
const MAX_LAYERS: usize = 256;
const MAX_STROKES: usize = 200_000;
/// How much stiffer or softer a stroke can be than by default.
pub(super) const RIGIDITY: std::ops::RangeInclusive<f32> = 1e-3..=1e3;
/// A motion can be enlarged or made smaller so far: what is beyond was a slip of the pen.
const SCALE: f32 = 1e3;

/// How motions hold a drawing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Binding {
    /// Width and height of the drawing's page.
    pub size: (f64, f64),
    /// The motions, in the order in which they are given to it; the first is the one meant where none is named.
    pub motions: Vec<MotionUse>,
    /// Where tracked points hold the drawing.
    pub points: Vec<BindPoint>,
    /// Places that stay where they are.
    pub pins: Vec<Pin>,
    /// Strokes that are not as strokes are by default.
    pub strokes: Vec<StrokeSetting>,
    /// Layers, the farthest first. Strokes in none belong to the first; without layers all are one.
    pub layers: Vec<SketchLayer>,
    /// What holds layers together.
    pub joints: Vec<LayerJoint>,
}

/// How a motion is used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MotionUse {
    /// Its name in this binding.
    pub name: String,
    /// Pixels of the drawing that a pixel of its clip becomes.
    pub scale: f32,
    /// How far its movement is turned, in degrees, clockwise as seen.
    pub rotation: f32,
    /// Whether left and right are exchanged, before it is turned.
    pub mirror: bool,
    /// The frame in which the drawing is as it was drawn.
    pub frame: usize,
    /// How much of its way over the picture is kept: 1 all, 0 for an animal that walks on the spot.
    pub travel: f32,
    /// Where another motion lasts longer: whether it begins again, else its last frame stays.
    pub repeat: bool,
}

impl Default for MotionUse {
    fn default() -> Self {
        Self { name: String::new(), scale: 1.0, rotation: 0.0, mirror: false, frame: 0, travel: 1.0, repeat: false }
    }
}

/// A tracked point and the place on the drawing that it moves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BindPoint {
    /// The motion; empty for the first.
    pub motion: String,
    /// The track.
    pub track: String,
    /// The point of the track.
    pub index: usize,
    /// The place on the drawing.
    pub at: Vec2,
    /// The layer it moves; empty for the nearest.
    pub layer: String,
}

/// A place that stays where it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Pin {
    /// The place on the drawing.
    pub at: Vec2,
    /// The layer it holds; empty for the nearest.
    pub layer: String,
}

/// How a stroke is treated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StrokeSetting {
    /// The stroke's name.
    pub stroke: String,
    /// How much more its shape is kept than by default; 1 for the default.
    pub rigidity: f32,
    /// Whether it stands still, whatever moves.
    pub decoration: bool,
}

impl Default for StrokeSetting {
    fn default() -> Self {
        Self { stroke: String::new(), rigidity: 1.0, decoration: false }
    }
}

/// Strokes that move together, apart from the others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SketchLayer {
    /// Its name, unique.
    pub name: String,
    /// The names of its strokes.
    pub strokes: Vec<String>,
}

/// A place at which two layers hold each other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LayerJoint {
    /// Their names.
    pub layers: (String, String),
    /// The place on the drawing.
    pub at: Vec2,
}

#[derive(Serialize, Deserialize)]
struct BindFile {
    format: String,
    version: u32,
    size: (f64, f64),
    #[serde(default)]
    motions: Vec<MotionUse>,
    #[serde(default)]
    points: Vec<BindPoint>,
    #[serde(default)]
    pins: Vec<Pin>,
    #[serde(default)]
    strokes: Vec<StrokeSetting>,
    #[serde(default)]
    layers: Vec<SketchLayer>,
    #[serde(default)]
    joints: Vec<LayerJoint>,
}

impl Binding {
    /// Reads bind.json and checks what can be checked without its drawing.
    ///
    /// # Errors
    /// The file cannot be read, is no bind.json, or contradicts itself.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_json(&text).map_err(|e| e.in_file(path))
    }

    /// Parses the text of a bind.json and checks what can be checked without its drawing.
    ///
    /// # Errors
    /// It is no bind.json, or contradicts itself.
    pub fn from_json(text: &str) -> Result<Self> {
        let file: BindFile = serde_json::from_str(text)
            .map_err(|e| Error::invalid("binding", format!("not readable: {e}"), "expected a marey-bind file"))?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(Error::invalid(
                "binding",
                format!("the file says {} version {}", file.format, file.version),
                format!("expected {FORMAT} version {VERSION}"),
            ));
        }
        let BindFile { size, motions, points, pins, strokes, layers, joints, .. } = file;
        let binding = Self { size, motions, points, pins, strokes, layers, joints };
        binding.validate()?;
        Ok(binding)
    }

    /// The binding as the text of a bind.json.
    pub fn to_json(&self) -> String {
        let own = self.clone();
        let file = BindFile {
            format: FORMAT.into(),
            version: VERSION,
            size: own.size,
            motions: own.motions,
            points: own.points,
            pins: own.pins,
            strokes: own.strokes,
            layers: own.layers,
            joints: own.joints,
        };
        serde_json::to_string(&file).unwrap_or_default()
    }

    /// Checks what holds whatever the drawing and the motions are.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate(&self) -> Result<()> {
        let listed: usize = self.layers.iter().map(|l| l.strokes.len()).sum();
        let counts = [
            ("motions", self.motions.len(), MAX_HANDLES),
            ("points", self.points.len(), MAX_HANDLES),
            ("pins", self.pins.len(), MAX_HANDLES),
            ("joints", self.joints.len(), MAX_HANDLES),
            ("layers", self.layers.len(), MAX_LAYERS),
            ("strokes", self.strokes.len().max(listed), MAX_STROKES),
        ];
        if let Some((what, value, max)) = counts.into_iter().find(|(_, value, max)| value > max) {
            return Err(Error::Limit {
                what: format!("the number of {what} in the binding"),
                value: value as u64,
                max: max as u64,
                remedy: "a dozen points and a few layers move most drawings".into(),
            });
        }
        if ![self.size.0, self.size.1].iter().all(|s| s.is_finite() && *s >= 0.0) {
            return Err(Error::invalid("binding", "its size is no size", "give the drawing's width and height"));
        }
        self.validate_motions()?;
        let layers = self.validate_layers()?;
        let known = |what: String, layer: &str| {
            if layer.is_empty() || layers.contains(layer) {
                return Ok(());
            }
            let remedy = format!("name one of {}", listed_names(self.layers.iter().map(|l| l.name.as_str())));
            Err(Error::invalid(what, format!("its layer `{layer}` is not there"), remedy))
        };
        let finite = |what: String, at: Vec2| match at.is_finite() {
            true => Ok(()),
            false => Err(Error::invalid(what, "its place holds something that is no number", "place it again")),
        };
        for (i, point) in self.points.iter().enumerate() {
            let what = format!("point {i} (track `{}`)", point.track);
            finite(what.clone(), point.at)?;
            known(what.clone(), &point.layer)?;
            if !point.motion.is_empty() && self.motions.iter().all(|m| m.name != point.motion) {
                let remedy = format!("name one of {}", listed_names(self.motions.iter().map(|m| m.name.as_str())));
                return Err(Error::invalid(what, format!("its motion `{}` is not there", point.motion), remedy));
            }
        }
        for (i, pin) in self.pins.iter().enumerate() {
            finite(format!("pin {i}"), pin.at)?;
            known(format!("pin {i}"), &pin.layer)?;
        }
        for (i, joint) in self.joints.iter().enumerate() {
            let (a, b) = &joint.layers;
            let what = format!("joint {i} (`{a}` and `{b}`)");
            finite(what.clone(), joint.at)?;
            if a == b || a.is_empty() || b.is_empty() {
                return Err(Error::invalid(what, "does not name two layers", "name the two that it holds together"));
            }
            known(what.clone(), a)?;
            known(what, b)?;
        }
        let mut set = HashSet::with_capacity(self.strokes.len());
        for setting in &self.strokes {
            let what = format!("stroke `{}`", setting.stroke);
            if !set.insert(setting.stroke.as_str()) {
                return Err(Error::invalid(what, "is set twice", "keep one setting for each stroke"));
            }
            if !RIGIDITY.contains(&setting.rigidity) {
                let problem = format!("a rigidity of {}", setting.rigidity);
                let remedy = format!("from {} to {}, 1 by default", RIGIDITY.start(), RIGIDITY.end());
                return Err(Error::invalid(what, problem, remedy));
            }
        }
        Ok(())
    }

    fn validate_motions(&self) -> Result<()> {
        let mut names = HashSet::with_capacity(self.motions.len());
        for (i, motion) in self.motions.iter().enumerate() {
            let what = || format!("motion {i} (`{}`)", motion.name);
            if !names.insert(motion.name.as_str()) {
                return Err(Error::invalid(what(), "its name is there twice", "give each motion a name of its own"));
            }
            let checks = [
                ("scale", motion.scale, motion.scale > 0.0 && motion.scale <= SCALE),
                ("rotation", motion.rotation, motion.rotation.abs() <= 3600.0),
                ("travel", motion.travel, (-10.0..=10.0).contains(&motion.travel)),
            ];
            if let Some((name, value, _)) = checks.into_iter().find(|c| !c.2) {
                let remedy = "a scale is above 0, a rotation in degrees, a travel 1 for all of the way and 0 for none";
                return Err(Error::invalid(what(), format!("its {name} is {value}"), remedy));
            }
        }
        Ok(())
    }

    fn validate_layers(&self) -> Result<HashSet<&str>> {
        let mut names = HashSet::with_capacity(self.layers.len());
        let mut claimed: HashMap<&str, &str> = HashMap::new();
        for (i, layer) in self.layers.iter().enumerate() {
            if layer.name.trim().is_empty() {
                return Err(Error::invalid(format!("layer {i}"), "has no name", "name each layer"));
            }
            let what = format!("layer `{}`", layer.name);
            if !names.insert(layer.name.as_str()) {
                return Err(Error::invalid(what, "is there twice", "give each layer a name of its own"));
            }
            for stroke in &layer.strokes {
                if let Some(other) = claimed.insert(stroke, &layer.name) {
                    let problem = format!("its stroke `{stroke}` is in layer `{other}` already");
                    return Err(Error::invalid(what, problem, "a stroke is in one layer"));
                }
            }
        }
        Ok(names)
    }

    /// Checks the binding against the drawing that it holds and, where they are given, the motions that move it: one
    /// for each of [`Self::motions`], or a single one where none is listed.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self, drawing: &Drawing, motions: Option<&[&Motion]>) -> Result<()> {
        self.validate()?;
        let (own, page) = (self.size, drawing.size);
        // Sizes of files are written with few digits.
        if own != (0.0, 0.0) && ((own.0 - page.0).abs() > 0.5 || (own.1 - page.1).abs() > 0.5) {
            let problem = format!("made for a page of {} x {}, and this is {} x {}", own.0, own.1, page.0, page.1);
            return Err(Error::invalid("binding", problem, "use the drawing it was made on"));
        }
        let strokes: HashSet<&str> = drawing.strokes.iter().map(|s| s.name.as_str()).collect();
        let of_layers = self.layers.iter().flat_map(|l| l.strokes.iter().map(move |s| (Some(&l.name), s)));
        for (layer, stroke) in of_layers.chain(self.strokes.iter().map(|s| (None, &s.stroke))) {
            if !strokes.contains(stroke.as_str()) {
                let what = layer.map_or_else(|| "settings of strokes".into(), |l| format!("layer `{l}`"));
                let remedy = "the drawing's strokes are called otherwise: see their ids";
                return Err(Error::invalid(what, format!("stroke `{stroke}` is not in the drawing"), remedy));
            }
        }
        motions.map_or(Ok(()), |motions| self.check_motions(motions))
    }

    fn check_motions(&self, motions: &[&Motion]) -> Result<()> {
        let expected = self.motions.len().max(1);
        if motions.len() != expected {
            let problem = format!("it names {expected}, and {} came", motions.len());
            return Err(Error::invalid("motions of the binding", problem, "give one for each, in its order"));
        }
        for (i, motion) in motions.iter().enumerate() {
            motion.validate()?;
            let own = self.motions.get(i).cloned().unwrap_or_default();
            if own.frame >= motion.frames {
                return Err(Error::invalid(
                    format!("motion {i} (`{}`)", own.name),
                    format!("the drawing is bound to its frame {}, and it has {}", own.frame, motion.frames),
                    "frames count from 0",
                ));
            }
        }
        for (i, point) in self.points.iter().enumerate() {
            let what = format!("point {i} (track `{}`)", point.track);
            let motion = motions[self.motion_of(point)];
            let Some(track) = motion.track(&point.track) else {
                let remedy = format!("name one of {}", listed_names(motion.tracks.iter().map(|t| t.name.as_str())));
                return Err(Error::invalid(what, "the motion has no such track", remedy));
            };
            let count = track.frames.first().map_or(0, |f| f.points.len());
            if point.index >= count {
                let problem = format!("its index is {}, and the track has {count} points", point.index);
                return Err(Error::invalid(what, problem, "indices count from 0"));
            }
        }
        Ok(())
    }

    /// Which of the motions a point follows.
    pub(super) fn motion_of(&self, point: &BindPoint) -> usize {
        self.motions.iter().position(|m| m.name == point.motion).unwrap_or(0)
    }
}

/// Some names for a message.
fn listed_names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    let all: Vec<&str> = names.collect();
    let more = if all.len() > SHOWN { ", ..." } else { "" };
    match all.is_empty() {
        true => "none".into(),
        false => format!("{}{more}", all[..all.len().min(SHOWN)].join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Track, TrackFrame, TrackKind};
    use crate::shape::sketch::Stroke;

    const GOOD: &str = r#"{"format":"marey-bind","version":1,"size":[100,80],"news":1,
        "motions":[{"name":"walk","scale":0.5,"frame":2}],
        "points":[{"track":"nose","at":[10,12.5],"layer":"head"},{"motion":"walk","track":"tail","at":[90,20]}],
        "pins":[{"at":[50,70]}],"strokes":[{"stroke":"s1","rigidity":10},{"stroke":"s3","decoration":true}],
        "layers":[{"name":"body","strokes":["s0"]},{"name":"head","strokes":["s1"]}],
        "joints":[{"layers":["body","head"],"at":[30,30]}]}"#;

    fn drawing() -> Drawing {
        let strokes = (0..4).map(|i| Stroke { name: format!("s{i}"), ..Stroke::default() }).collect();
        Drawing { size: (100.0, 80.0), strokes, groups: Vec::new() }
    }

    fn motion(frames: usize) -> Motion {
        let track = |name: &str| Track {
            name: name.into(),
            kind: TrackKind::Point,
            frames: vec![TrackFrame::certain(vec![Vec2::ONE]); frames],
        };
        Motion { size: (10, 10), fps: 25.0, frames, tracks: vec![track("nose"), track("tail")], bones: Vec::new() }
    }

    #[test]
    fn round_trip_keeps_everything() {
        let binding = Binding::from_json(GOOD).expect("valid");
        assert_eq!((binding.motions[0].scale, binding.motions[0].travel), (0.5, 1.0));
        assert_eq!(binding.points[1].at, Vec2::new(90.0, 20.0));
        assert_eq!(Binding::from_json(&binding.to_json()).expect("valid"), binding);
        binding.check(&drawing(), Some(&[&motion(3)])).expect("all is there");
        let empty = Binding::from_json(r#"{"format":"marey-bind","version":1,"size":[0,0]}"#).expect("valid");
        assert_eq!(empty, Binding::default());
    }

    #[test]
    fn every_mistake_is_named() {
        let twice = |what: &str| GOOD.replace(what, &format!("{what},{what}"));
        let cases = [
            (GOOD.replace("\"version\":1", "\"version\":9"), "version 9"),
            (GOOD.replace("[50,70]", "[50]"), "not readable"),
            (GOOD.replace("[50,70]", "[1e39,70]"), "out of range"),
            (GOOD.replace("[100,80]", "[-1,80]"), "no size"),
            (GOOD.replace("\"layer\":\"head\"", "\"layer\":\"wing\""), "`wing` is not there; name one of body, head"),
            (GOOD.replace("\"motion\":\"walk\"", "\"motion\":\"run\""), "`run` is not there"),
            (GOOD.replace("[\"body\",\"head\"]", "[\"body\",\"body\"]"), "two layers"),
            (GOOD.replace("[\"s1\"]", "[\"s1\",\"s0\"]"), "in layer `body` already"),
            (twice(r#"{"stroke":"s1","rigidity":10}"#), "set twice"),
            (twice(r#"{"name":"walk","scale":0.5,"frame":2}"#), "there twice"),
            (GOOD.replace("\"name\":\"head\"", "\"name\":\"body\""), "there twice"),
            (GOOD.replace("\"name\":\"head\"", "\"name\":\" \""), "no name"),
            (GOOD.replace("\"scale\":0.5", "\"scale\":0"), "scale is 0"),
            (GOOD.replace("\"rigidity\":10", "\"rigidity\":-1"), "rigidity of -1"),
            (GOOD.replace("\"pins\":[", &format!("\"pins\":[{}", "{},".repeat(2000))), "at most 1024"),
        ];
        for (text, expected) in cases {
            let message = Binding::from_json(&text).expect_err(expected).to_string();
            assert!(message.contains(expected), "{message} should say {expected}");
        }
    }

    #[test]
    fn what_is_not_in_the_drawing_or_the_motion_is_named() {
        let good = Binding::from_json(GOOD).expect("valid");
        let other = |edit: &dyn Fn(&mut Binding)| {
            let mut binding = good.clone();
            edit(&mut binding);
            binding.check(&drawing(), Some(&[&motion(3)])).expect_err("wrong").to_string()
        };
        assert!(other(&|b| b.size = (99.0, 80.0)).contains("made for a page of 99 x 80"));
        assert!(other(&|b| b.layers[0].strokes.push("s9".into())).contains("layer `body`: stroke `s9`"));
        assert!(other(&|b| b.strokes[0].stroke = "s9".into()).contains("stroke `s9` is not in the drawing"));
        assert!(other(&|b| b.points[0].track = "ear".into()).contains("no such track; name one of nose, tail"));
        assert!(other(&|b| b.points[0].index = 1).contains("has 1 points"));
        assert!(other(&|b| b.motions[0].frame = 3).contains("its frame 3, and it has 3"));
        assert!(other(&|b| b.points[0].at.x = f32::NAN).contains("no number"));
        let none = good.check(&drawing(), Some(&[])).expect_err("no motion").to_string();
        assert!(none.contains("names 1, and 0 came"), "{none}");
    }
}
