//! What can be chosen about tracking, segmenting, reconstructing and exporting: one table of named parameters with
//! their bounds, which hosts show, sessions keep and jobs resolve.
//!
//! A session keeps only what was chosen otherwise than by default, so that better defaults reach it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::export::FolderOptions;
use crate::segment::{self, SegmentParams};
use crate::shape::creature::{self, CreatureParams};
use crate::track::limb::{self, LimbParams};

/// A parameter's value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Of a switch.
    Switch(bool),
    /// Of a number, finite.
    Number(f64),
    /// Of a choice, or a text.
    Choice(String),
}

/// What values a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// On or off.
    Switch,
    /// Any number from the first to the second.
    Number(f64, f64),
    /// A whole number from the first to the second.
    Whole(f64, f64),
    /// One of these.
    Choice(&'static [&'static str]),
    /// A line of text of at most [`LONGEST`] bytes; empty by default.
    Text,
}

/// The longest text, in bytes: that of a plugin's id.
pub const LONGEST: usize = 127;

/// Which plugins work in place of what is built in, by their ids; empty for none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Helpers {
    /// The tracker.
    pub tracker: String,
    /// The segmenter.
    pub segmenter: String,
}

/// Everything that can be chosen, chosen.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Chosen {
    /// Who works in place of what is built in.
    pub helpers: Helpers,
    /// How limbs are followed.
    pub track: LimbParams,
    /// How the creature is cut out.
    pub segment: SegmentParams,
    /// How it is built.
    pub creature: CreatureParams,
    /// What is written.
    pub export: FolderOptions,
}

/// A parameter.
#[derive(Debug)]
pub struct Parameter {
    /// Its name, for ever: `track.`, `segment.`, `creature.` or `export.`, and a word.
    pub name: &'static str,
    /// The values it takes.
    pub kind: Kind,
    /// What it does, a sentence for a person.
    pub about: &'static str,
    get: fn(&Chosen) -> Value,
    set: fn(&mut Chosen, &Value),
}

macro_rules! number {
    ($kind:ident($low:literal, $high:literal), $group:ident.$field:ident, $about:literal) => {
        Parameter {
            name: concat!(stringify!($group), ".", stringify!($field)),
            kind: Kind::$kind($low, $high),
            about: $about,
            // By way of its decimal digits, or 0.04 would be shown as 0.03999999910593033.
            get: |chosen| Value::Number(chosen.$group.$field.to_string().parse().unwrap_or_default()),
            set: |chosen, value| {
                if let Value::Number(number) = value {
                    chosen.$group.$field = *number as _;
                }
            },
        }
    };
}

macro_rules! switch {
    ($group:ident.$field:ident, $about:literal) => {
        Parameter {
            name: concat!(stringify!($group), ".", stringify!($field)),
            kind: Kind::Switch,
            about: $about,
            get: |chosen| Value::Switch(chosen.$group.$field),
            set: |chosen, value| {
                if let Value::Switch(on) = value {
                    chosen.$group.$field = *on;
                }
            },
        }
    };
}

macro_rules! choice {
    ($group:ident.$field:ident, $($name:literal => $value:path),+; $about:literal) => {
        Parameter {
            name: concat!(stringify!($group), ".", stringify!($field)),
            kind: Kind::Choice(&[$($name),+]),
            about: $about,
            get: |chosen| Value::Choice(match chosen.$group.$field { $($value => $name),+ }.to_owned()),
            set: |chosen, value| {
                if let Value::Choice(name) = value {
                    match name.as_str() { $($name => chosen.$group.$field = $value,)+ _ => {} }
                }
            },
        }
    };
}

macro_rules! helper {
    ($name:literal, $field:ident, $about:literal) => {
        Parameter {
            name: $name,
            kind: Kind::Text,
            about: $about,
            get: |chosen| Value::Choice(chosen.helpers.$field.clone()),
            set: |chosen, value| {
                if let Value::Choice(id) = value {
                    chosen.helpers.$field.clone_from(id);
                }
            },
        }
    };
}

/// All parameters, in the order in which they are shown.
pub static PARAMETERS: [Parameter; 34] = [
    helper!("track.plugin", tracker, "The plugin that follows limbs, by its id; empty for the built-in tracker."),
    choice!(track.method, "space-time" => limb::Method::SpaceTime, "paper" => limb::Method::Paper;
        "How limbs are followed between key frames."),
    number!(Whole(128.0, 4096.0), track.working_side, "Longest side of the image that is tracked on, in pixels."),
    number!(Number(4.0, 64.0), track.spacing, "Distance between the points of a limb, in pixels of a 512-pixel clip."),
    helper!("segment.plugin", segmenter, "The plugin that cuts the creature out, by its id; empty for the built-in."),
    choice!(segment.method, "layered" => segment::Method::Layered, "paper" => segment::Method::Paper;
        "How the creature is told from what is around it."),
    number!(Whole(128.0, 4096.0), segment.working_side, "Longest side of the image that is cut, in pixels."),
    number!(Whole(1.0, 10.0), segment.passes, "How often masks and their models are refined in turn."),
    number!(Number(0.05, 4.0), segment.reach, "How far from the strokes creature may be, as a share of its extent."),
    number!(Number(0.0, 20.0), segment.colour_weight, "Weight of colours."),
    number!(Number(0.0, 20.0), segment.shape_weight, "Weight of the limbs' shapes."),
    number!(Number(0.0, 100.0), segment.edge_weight, "Cost of a border between pixels of equal colour."),
    number!(Number(0.0, 100.0), segment.memory, "For how many frames a mask is remembered, before and after."),
    number!(Number(0.0, 1.0), creature.extension, "Share by which strokes are lengthened at both ends."),
    number!(Number(0.0, 50.0), creature.min_vote, "Radii below this are noise, in pixels of a 512-pixel clip."),
    number!(Number(0.0, 1.0), creature.percentile, "Share of the measured radii that lie below the one taken."),
    number!(Whole(0.0, 20.0), creature.neighbours, "Neighbours along a limb whose measured radii count as well."),
    number!(Number(0.0, 1.0), creature.max_rejected, "Share of doubtful measurements above which a radius is unknown."),
    number!(Number(0.0, 1.0), creature.smoothing, "How far radii are smoothed along a limb, as a share of its length."),
    number!(
        Number(0.0, 1.0),
        creature.foreshortened,
        "Share of its longest length below which a limb leaves the image plane."
    ),
    number!(Number(0.0, 10.0), creature.spread, "How far limbs of a pair stand apart, times what their body says."),
    number!(Whole(0.0, 20.0), creature.settling_rounds, "How often limbs are moved into the middle of their pixels."),
    number!(Number(0.01, 10_000.0), creature.settling_stiffness, "How stiffly limbs bend while they settle."),
    choice!(creature.surface, "tubes" => creature::Surface::Tubes, "skin" => creature::Surface::Skin;
        "What covers the limbs: one connected skin, or a tube around each."),
    switch!(creature.fill_silhouette, "Cover what limbs miss of the silhouette, such as ears and hooves."),
    number!(Number(0.5, 20.0), creature.patch_step, "Size of the triangles that do, in pixels of a 512-pixel clip."),
    number!(Whole(500.0, 200_000.0), creature.skin_triangles, "About how many triangles a skin has."),
    number!(Whole(6.0, 128.0), creature.around, "Vertices around the tube of a limb."),
    number!(Whole(1.0, 64.0), creature.max_bones, "Largest number of bones of a limb."),
    number!(Whole(64.0, 8192.0), creature.max_texture, "Longest side of a texture, in pixels."),
    number!(Whole(1.0, 1024.0), creature.texture_views, "Most frames that give colours; 1 takes the key frame alone."),
    switch!(export.obj, "Also write a mesh for each frame."),
    switch!(export.gifs, "Also write overlay.gif and preview.gif."),
    number!(Number(1e-6, 1e6), export.scale, "Metres for a pixel of the clip in glTF."),
];

impl Parameter {
    /// The parameter called `name`.
    ///
    /// # Errors
    /// There is none.
    pub fn named(name: &str) -> Result<&'static Self> {
        PARAMETERS.iter().find(|p| p.name == name).ok_or_else(|| {
            Error::invalid(format!("parameter `{name}`"), "is not known", "names are like `creature.smoothing`")
        })
    }

    /// Its value where none is chosen.
    pub fn default_value(&self) -> Value {
        (self.get)(&Chosen::default())
    }

    /// Whether it takes `value`.
    ///
    /// # Errors
    /// It does not; the message says what it takes.
    pub fn check(&self, value: &Value) -> Result<()> {
        let (fits, expected) = match (self.kind, value) {
            (Kind::Switch, value) => (matches!(value, Value::Switch(_)), "expected true or false".to_owned()),
            (Kind::Number(low, high), value) => {
                (matches!(value, Value::Number(n) if (low..=high).contains(n)), format!("expected {low} to {high}"))
            }
            (Kind::Whole(low, high), value) => (
                matches!(value, Value::Number(n) if (low..=high).contains(n) && n.fract() == 0.0),
                format!("expected a whole number from {low} to {high}"),
            ),
            (Kind::Choice(names), value) => (
                matches!(value, Value::Choice(name) if names.contains(&name.as_str())),
                format!("expected one of {}", names.join(", ")),
            ),
            (Kind::Text, value) => (
                matches!(value, Value::Choice(text) if text.len() <= LONGEST && !text.contains(char::is_control)),
                format!("expected a line of at most {LONGEST} bytes"),
            ),
        };
        if fits {
            return Ok(());
        }
        Err(Error::invalid(format!("parameter `{}`", self.name), format!("does not take {value:?}"), expected))
    }
}

/// What was chosen otherwise than by default. Values of parameters that this version does not know are kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Settings(BTreeMap<String, Value>);

impl Settings {
    /// The value of a parameter.
    ///
    /// # Errors
    /// There is no such parameter.
    pub fn get(&self, name: &str) -> Result<Value> {
        let parameter = Parameter::named(name)?;
        Ok(self.0.get(name).cloned().unwrap_or_else(|| parameter.default_value()))
    }

    /// Chooses a value, or [`None`] for the default; gives what was chosen before.
    pub(super) fn set(&mut self, name: &str, value: Option<Value>) -> Result<Option<Value>> {
        let parameter = Parameter::named(name)?;
        let Some(value) = value else { return Ok(self.0.remove(name)) };
        parameter.check(&value)?;
        Ok(self.0.insert(name.to_owned(), value))
    }

    /// Everything, chosen or by default.
    pub fn resolve(&self) -> Chosen {
        let mut chosen = Chosen::default();
        for parameter in &PARAMETERS {
            if let Some(value) = self.0.get(parameter.name) {
                (parameter.set)(&mut chosen, value);
            }
        }
        chosen
    }

    /// Checks the values of the parameters that are known; those of a file may be anything.
    pub(super) fn check(&self) -> Result<()> {
        self.0.iter().try_for_each(|(name, value)| Parameter::named(name).map_or(Ok(()), |p| p.check(value)))
    }

    /// Whether all parameters whose names start so are the same in both.
    pub(super) fn same(&self, start: &str, other: &Self) -> bool {
        let group = |settings: &Self| -> Vec<(String, Value)> {
            settings.0.iter().filter(|(name, _)| name.starts_with(start)).map(|(n, v)| (n.clone(), v.clone())).collect()
        };
        group(self) == group(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_takes_its_default_and_its_bounds_and_nothing_beyond() {
        for parameter in &PARAMETERS {
            let name = parameter.name;
            parameter.check(&parameter.default_value()).expect(name);
            let good = match parameter.kind {
                Kind::Switch => vec![Value::Switch(true), Value::Switch(false)],
                Kind::Number(low, high) | Kind::Whole(low, high) => vec![Value::Number(low), Value::Number(high)],
                Kind::Choice(names) => names.iter().map(|n| Value::Choice((*n).to_owned())).collect(),
                Kind::Text => vec![Value::Choice("org.example.nearest".into())],
            };
            for value in good {
                let mut settings = Settings::default();
                settings.set(name, Some(value.clone())).expect(name);
                assert_eq!((parameter.get)(&settings.resolve()), value, "{name}");
            }
            let bad = [f64::NAN, f64::INFINITY, -1.0, 1e12].map(Value::Number);
            let text = if parameter.kind == Kind::Text { "two\nlines" } else { "nothing" };
            for value in bad.into_iter().chain([Value::Choice(text.into())]) {
                assert!(parameter.check(&value).is_err(), "{name} {value:?}");
            }
        }
        assert!(Parameter::named("creature.wings").is_err());
        assert!(Settings::default().set("creature.around", Some(Value::Number(20.5))).is_err());
    }
}
