//! What a person chose, handed to a plugin when it is created.

use crate::error::{Error, Result};
use crate::parameter::{Kind, Parameter};

/// One value of each parameter: what was chosen, or the default.
#[derive(Debug)]
pub struct Values<'a> {
    parameters: &'static [Parameter],
    given: Vec<Given<'a>>,
}

/// A value as it comes through a door.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given<'a> {
    pub(crate) id: &'a str,
    pub(crate) number: f64,
    pub(crate) text: Option<&'a str>,
}

impl<'a> Values<'a> {
    /// The defaults of `parameters`.
    pub fn defaults(parameters: &'static [Parameter]) -> Self {
        Self { parameters, given: Vec::new() }
    }

    /// The values that the host gives, checked against what was declared.
    pub(crate) fn checked(parameters: &'static [Parameter], given: Vec<Given<'a>>) -> Result<Self> {
        for value in &given {
            let Some(parameter) = parameters.iter().find(|p| p.id == value.id) else {
                return Err(Error::invalid(format!("there is no parameter `{}`", value.id)));
            };
            let (low, high, whole) = match parameter.kind {
                Kind::Number { low, high, .. } => (low, high, false),
                Kind::Whole { low, high, .. } => (f64::from(low), f64::from(high), true),
                Kind::Switch { .. } => (0.0, 1.0, true),
                Kind::Choice { names, .. } => (0.0, names.len().saturating_sub(1) as f64, true),
                Kind::Text { .. } | Kind::File => continue,
            };
            let number = value.number;
            if !(low..=high).contains(&number) || whole && number.fract() != 0.0 {
                let message = format!("parameter `{}` is {number}, and {low} to {high} is allowed", value.id);
                return Err(Error::invalid(message));
            }
        }
        Ok(Self { parameters, given })
    }

    /// These values with another number for one parameter, for tests.
    ///
    /// # Errors
    /// There is no such parameter, or the number is out of its range.
    pub fn with(mut self, id: &'a str, number: f64) -> Result<Self> {
        self.given.retain(|v| v.id != id);
        self.given.push(Given { id, number, text: None });
        Self::checked(self.parameters, self.given)
    }

    fn find(&self, id: &str) -> Result<(&'static Parameter, Option<&Given<'a>>)> {
        // The last of two values for one parameter counts.
        let given = self.given.iter().rev().find(|v| v.id == id);
        let parameter = self.parameters.iter().find(|p| p.id == id);
        parameter
            .map(|p| (p, given))
            .ok_or_else(|| Error::failed(format!("the plugin asks for a parameter `{id}`, which it did not declare")))
    }

    /// The value of a number or whole number.
    ///
    /// # Errors
    /// There is no such parameter, or it is of another kind. So for all of these.
    pub fn number(&self, id: &str) -> Result<f64> {
        let (parameter, given) = self.find(id)?;
        match parameter.kind {
            Kind::Number { default, .. } => Ok(given.map_or(default, |v| v.number)),
            Kind::Whole { default, .. } => Ok(given.map_or(f64::from(default), |v| v.number)),
            _ => Err(another_kind(id)),
        }
    }

    /// The value of a whole number.
    pub fn whole(&self, id: &str) -> Result<i32> {
        let (parameter, given) = self.find(id)?;
        let Kind::Whole { default, .. } = parameter.kind else { return Err(another_kind(id)) };
        Ok(given.map_or(default, |v| v.number as i32))
    }

    /// Whether a switch is on.
    pub fn switch(&self, id: &str) -> Result<bool> {
        let (parameter, given) = self.find(id)?;
        let Kind::Switch { default } = parameter.kind else { return Err(another_kind(id)) };
        Ok(given.map_or(default, |v| v.number == 1.0))
    }

    /// The index of what was chosen.
    pub fn choice(&self, id: &str) -> Result<usize> {
        let (parameter, given) = self.find(id)?;
        let Kind::Choice { default, .. } = parameter.kind else { return Err(another_kind(id)) };
        Ok(given.map_or(default as usize, |v| v.number as usize))
    }

    /// The text, or the path.
    pub fn text(&self, id: &str) -> Result<String> {
        let (parameter, given) = self.find(id)?;
        let default = match parameter.kind {
            Kind::Text { default } => default,
            Kind::File => "",
            _ => return Err(another_kind(id)),
        };
        Ok(given.and_then(|v| v.text).unwrap_or(default).to_owned())
    }
}

fn another_kind(id: &str) -> Error {
    Error::failed(format!("the plugin asks for parameter `{id}` as another kind than it declared"))
}
