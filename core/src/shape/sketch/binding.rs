//! How motions hold a drawing, and bind.json, its file.
//!
//! `{"format":"marey-bind","version":1,"size":[W,H],"motions":[{"name","scale","rotation","mirror","frame","travel"}],
//! "points":[{"motion","track","index","at":[x,y],"layer"}],"pins":[{"at":[x,y],"layer"}],
//! "strokes":[{"stroke","rigidity","decoration"}],"layers":[{"name","strokes":[..]}],"joints":[{"layers":[a,b],"at":[x,y]}]}`.
//! Unknown keys are ignored, an unknown version is an error.

use glam::Vec2;
use serde::{Deserialize, Serialize};

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
}

impl Default for MotionUse {
    fn default() -> Self {
        Self { name: String::new(), scale: 1.0, rotation: 0.0, mirror: false, frame: 0, travel: 1.0 }
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
