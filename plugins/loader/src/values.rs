//! Values of parameters. They live here and not in plugins, so that an instance can be made again from them.

use std::collections::BTreeMap;

use crate::describe::{ParameterInfo, ParameterKind, PluginInfo};
use crate::refusal::{Refusal, Status};

/// The value of one parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number, a whole number, a switch (0 or 1), or the index of a choice.
    Number(f64),
    /// A text or a path.
    Text(String),
}

/// What was chosen otherwise than by default, by the parameter's id.
pub(crate) type Chosen = BTreeMap<String, Value>;

/// Whether `parameter` takes `value`; why not, where it does not.
fn fits(parameter: &ParameterInfo, value: &Value) -> Result<(), String> {
    let text = matches!(parameter.kind, ParameterKind::Text | ParameterKind::File);
    match value {
        Value::Text(t) if text && t.len() <= 4096 && !t.contains('\0') => Ok(()),
        Value::Text(_) if text => Err("is longer than 4096 bytes, or holds a NUL".to_owned()),
        Value::Text(_) => Err("is a text, and a number is needed".to_owned()),
        Value::Number(_) if text => Err("is a number, and a text is needed".to_owned()),
        Value::Number(n) => {
            let whole = parameter.kind != ParameterKind::Number;
            let in_range = (parameter.low..=parameter.high).contains(n) && (!whole || n.fract() == 0.0);
            let numbers = if whole { "whole numbers" } else { "numbers" };
            let expected = || format!("is {n}, and {numbers} from {} to {} are allowed", parameter.low, parameter.high);
            if in_range { Ok(()) } else { Err(expected()) }
        }
    }
}

/// Checks a value for the parameter `name` of a plugin.
pub(crate) fn check(plugin: &PluginInfo, name: &str, value: &Value) -> Result<(), Refusal> {
    let refuse = |status, problem: String, remedy: String| {
        Refusal::new(status, format!("parameter `{name}` of {}", plugin.id), problem, remedy)
    };
    let Some(parameter) = plugin.parameters.iter().find(|p| p.id == name) else {
        let known: Vec<&str> = plugin.parameters.iter().map(|p| p.id.as_str()).collect();
        return Err(refuse(Status::NotFound, "is not known".into(), format!("there are: {}", known.join(", "))));
    };
    fits(parameter, value).map_err(|problem| refuse(Status::Descriptor, problem, "choose another value".into()))
}

/// A value for each parameter: what was chosen where it fits, or else the default. A new build of a plugin may have
/// narrowed a range.
pub(crate) fn complete(plugin: &PluginInfo, chosen: &Chosen) -> Vec<(String, Value)> {
    let parameters = plugin.parameters.iter();
    let value = |p: &ParameterInfo| {
        let fitting = chosen.get(&p.id).filter(|v| fits(p, v).is_ok());
        fitting.cloned().unwrap_or_else(|| p.default_value())
    };
    parameters.map(|p| (p.id.clone(), value(p))).collect()
}
