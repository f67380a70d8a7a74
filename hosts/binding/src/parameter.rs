//! What can be chosen about tracking, segmenting, reconstructing and exporting.

use marey_ffi::{MRY_PARAMETER_CHOICE, MRY_PARAMETER_SWITCH, MRY_PARAMETER_TEXT, MRY_PARAMETER_WHOLE};

use crate::session::found;
use crate::{Context, Result, sys};

/// A parameter, to be shown without knowing any.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name for ever.
    pub name: String,
    /// What it does, a sentence.
    pub about: String,
    /// What values it takes.
    pub kind: ParameterKind,
    /// Its value where none is chosen.
    pub default: f64,
}

/// What values a parameter takes.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterKind {
    /// Any number from the first to the second.
    Number(f64, f64),
    /// A whole number from the first to the second.
    Whole(f64, f64),
    /// 0 or 1.
    Switch,
    /// The index of one of these.
    Choice(Vec<String>),
    /// A line of text, see [`crate::Session::set_text`].
    Text,
}

impl Context {
    /// All parameters, in the order in which to show them.
    pub fn parameters(&self) -> Result<Vec<Parameter>> {
        (0..).map_while(|index| self.parameter(index).transpose()).collect()
    }

    fn parameter(&self, index: u32) -> Result<Option<Parameter>> {
        let Some(info) = found(sys::parameter_info(&self.0, index))? else { return Ok(None) };
        let kind = match info.kind {
            MRY_PARAMETER_SWITCH => ParameterKind::Switch,
            MRY_PARAMETER_WHOLE => ParameterKind::Whole(info.low, info.high),
            MRY_PARAMETER_CHOICE => {
                let name = |choice| sys::parameter_choice(&self.0, index, choice);
                ParameterKind::Choice((0..info.choice_count).map(name).collect::<Result<_>>()?)
            }
            MRY_PARAMETER_TEXT => ParameterKind::Text,
            _ => ParameterKind::Number(info.low, info.high),
        };
        let (name, about) = (sys::text(&info.name), sys::text(&info.about));
        Ok(Some(Parameter { name, about, kind, default: info.default_value }))
    }
}
