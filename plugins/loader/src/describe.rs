//! What a library says of its plugins, read and judged before anything relies on it.

use std::collections::HashSet;
use std::ffi::c_char;

use marey_plugin::raw;

use crate::values::Value;

/// What a plugin does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PluginKind {
    /// Follows limbs.
    Tracker,
    /// Cuts the creature out.
    Segmenter,
    /// Moves a mesh by handles.
    Deformer,
}

/// What values a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ParameterKind {
    /// Any number of a range.
    Number,
    /// A whole number of a range.
    Whole,
    /// 0 or 1.
    Switch,
    /// The index of one of several.
    Choice,
    /// A line of text.
    Text,
    /// The path of a file.
    File,
}

/// A parameter of a plugin.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ParameterInfo {
    /// Its name for ever.
    pub id: String,
    /// What a person reads beside the control.
    pub label: String,
    /// What it does.
    pub about: String,
    /// Where it stands among others, "Search/Fine".
    pub group: String,
    /// "px", "frames".
    pub unit: String,
    /// What values it takes.
    pub kind: ParameterKind,
    /// The least value.
    pub low: f64,
    /// The greatest.
    pub high: f64,
    /// The value where none is chosen.
    pub default: f64,
    /// The text where none is chosen.
    pub default_text: String,
    /// One step of a slider; 0 for none.
    pub step: f64,
    /// What a person reads for each value of a choice.
    pub choices: Vec<String>,
    /// Shown only while this parameter has this value.
    pub visible_if: Option<(String, f64)>,
    /// `MRY_PLUGIN_ADVANCED`, ...
    pub flags: u32,
}

impl ParameterInfo {
    /// The value where none is chosen.
    pub fn default_value(&self) -> Value {
        match self.kind {
            ParameterKind::Text | ParameterKind::File => Value::Text(self.default_text.clone()),
            _ => Value::Number(self.default),
        }
    }
}

/// What a plugin says of itself.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct PluginInfo {
    /// What it does.
    pub kind: PluginKind,
    /// Its name for ever, in reverse DNS.
    pub id: String,
    /// What a person reads.
    pub name: String,
    /// Who made it.
    pub vendor: String,
    /// Its version.
    pub version: String,
    /// What it is good at.
    pub about: String,
    /// What can be chosen about it.
    pub parameters: Vec<ParameterInfo>,
    /// Of the bytes it saves.
    pub state_version: u32,
}

/// Bounds that keep a mistaken table from being followed for ever.
pub(crate) const MAX_PLUGINS: u32 = 64;
const MAX_PARAMETERS: u32 = 256;
const MAX_CHOICES: u32 = 256;
const MAX_TEXT: usize = 4096;
const MAX_ID: usize = 127;
const MAX_PARAMETER_ID: usize = 47;

/// A text of the library's; [`None`] where it is no UTF-8 or does not end.
///
/// # Safety
/// `ptr` is null or points at a NUL-terminated string that lives for ever.
unsafe fn text(ptr: *const c_char, what: &str) -> Result<String, String> {
    if ptr.is_null() {
        return Ok(String::new());
    }
    // SAFETY: as this function's own: no byte behind the NUL is read.
    let bytes = (0..MAX_TEXT).map(|i| unsafe { *ptr.add(i) } as u8).take_while(|b| *b != 0).collect::<Vec<u8>>();
    if bytes.len() == MAX_TEXT {
        return Err(format!("{what} is longer than {MAX_TEXT} bytes"));
    }
    String::from_utf8(bytes).map_err(|_| format!("{what} is not UTF-8"))
}

fn sized(size: u32, expected: usize, what: &str) -> Result<(), String> {
    if size as usize >= expected {
        return Ok(());
    }
    Err(format!("{what}: struct_size is {size}, and at least {expected} is expected"))
}

/// # Safety
/// The descriptor is as plugin.h says.
pub(crate) unsafe fn descriptor(raw: *const raw::Descriptor, index: u32) -> Result<PluginInfo, String> {
    let what = format!("descriptor {index}");
    // SAFETY: as this function's own, here and below.
    let raw = unsafe { raw.as_ref() }.ok_or_else(|| format!("{what} is NULL"))?;
    sized(raw.struct_size, size_of::<raw::Descriptor>(), &what)?;
    if raw.parameter_count > MAX_PARAMETERS {
        return Err(format!("{what} has {} parameters, and at most {MAX_PARAMETERS} are allowed", raw.parameter_count));
    }
    if raw.parameters.is_null() && raw.parameter_count > 0 {
        return Err(format!("{what} has {} parameters, but parameters is NULL", raw.parameter_count));
    }
    let kind = match raw.kind {
        raw::TRACKER => PluginKind::Tracker,
        raw::SEGMENTER => PluginKind::Segmenter,
        raw::DEFORMER => PluginKind::Deformer,
        other => return Err(format!("{what} is of kind {other}, which this host does not know")),
    };
    let parameter = |i| {
        // SAFETY: as above; there are parameter_count pointers.
        unsafe { parameter(*raw.parameters.add(i as usize), &format!("{what}, parameter {i}")) }
    };
    // SAFETY: as above.
    unsafe {
        Ok(PluginInfo {
            kind,
            id: text(raw.id, "the id")?,
            name: text(raw.name, "the name")?,
            vendor: text(raw.vendor, "the vendor")?,
            version: text(raw.version, "the version")?,
            about: text(raw.about, "about")?,
            parameters: (0..raw.parameter_count).map(parameter).collect::<Result<_, _>>()?,
            state_version: raw.state_version,
        })
    }
}

/// # Safety
/// The parameter is as plugin.h says.
unsafe fn parameter(raw: *const raw::Parameter, what: &str) -> Result<ParameterInfo, String> {
    // SAFETY: as this function's own, here and below.
    let raw = unsafe { raw.as_ref() }.ok_or_else(|| format!("{what} is NULL"))?;
    sized(raw.struct_size, size_of::<raw::Parameter>(), what)?;
    if raw.choice_count > MAX_CHOICES || raw.choice_count > 0 && raw.choices.is_null() {
        return Err(format!("{what} has {} choices, or a NULL in their place", raw.choice_count));
    }
    let kind = match raw.kind {
        raw::NUMBER => ParameterKind::Number,
        raw::WHOLE => ParameterKind::Whole,
        raw::SWITCH => ParameterKind::Switch,
        raw::CHOICE => ParameterKind::Choice,
        raw::TEXT => ParameterKind::Text,
        raw::FILE => ParameterKind::File,
        other => return Err(format!("{what} is of kind {other}, which this host does not know")),
    };
    // SAFETY: as above; there are choice_count pointers.
    let choice = |i| unsafe { text(*raw.choices.add(i as usize), what) };
    let choices: Vec<String> = (0..raw.choice_count).map(choice).collect::<Result<_, _>>()?;
    let (low, high) = match kind {
        ParameterKind::Number | ParameterKind::Whole => (raw.low, raw.high),
        ParameterKind::Switch => (0.0, 1.0),
        ParameterKind::Choice => (0.0, choices.len() as f64 - 1.0),
        ParameterKind::Text | ParameterKind::File => (0.0, 0.0),
    };
    // SAFETY: as above.
    unsafe {
        let visible_if = text(raw.visible_if, what)?;
        Ok(ParameterInfo {
            id: text(raw.id, what)?,
            label: text(raw.label, what)?,
            about: text(raw.about, what)?,
            group: text(raw.group, what)?,
            unit: text(raw.unit, what)?,
            kind,
            low,
            high,
            default: if matches!(kind, ParameterKind::Text | ParameterKind::File) { 0.0 } else { raw.default_value },
            default_text: text(raw.default_text, what)?,
            step: raw.step,
            choices,
            visible_if: (!visible_if.is_empty()).then_some((visible_if, raw.visible_value)),
            flags: raw.flags,
        })
    }
}

/// An id that a file name, a command line and a settings file can hold.
fn is_name(id: &str, most: usize) -> bool {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '.' | '-' | '_');
    !id.is_empty() && id.len() <= most && id.chars().all(allowed)
}

/// Whether a library's plugins can be what it says they are.
pub(crate) fn check(plugins: &[PluginInfo]) -> Result<(), String> {
    if plugins.is_empty() {
        return Err("there is no plugin in the library".to_owned());
    }
    let mut ids = HashSet::new();
    for plugin in plugins {
        if !is_name(&plugin.id, MAX_ID) || !plugin.id.contains('.') {
            let id = plugin.id.chars().take(MAX_ID).collect::<String>();
            return Err(format!("`{id}` is no id: it takes reverse DNS, a-z, 0-9, '.', '-', '_', up to {MAX_ID}"));
        }
        if !ids.insert(&plugin.id) {
            return Err(format!("two plugins are called `{}`", plugin.id));
        }
        if plugin.name.trim().is_empty() || plugin.version.trim().is_empty() {
            return Err(format!("`{}` has no name or no version", plugin.id));
        }
        let mut names = HashSet::new();
        for parameter in &plugin.parameters {
            check_parameter(parameter).map_err(|e| format!("`{}`, parameter `{}`: {e}", plugin.id, parameter.id))?;
            if !names.insert(&parameter.id) {
                return Err(format!("`{}` has two parameters `{}`", plugin.id, parameter.id));
            }
        }
        for parameter in &plugin.parameters {
            if let Some((other, _)) = &parameter.visible_if
                && !names.contains(other)
            {
                return Err(format!("`{}`: visible_if names `{other}`, which is no parameter", plugin.id));
            }
        }
    }
    Ok(())
}

fn check_parameter(parameter: &ParameterInfo) -> Result<(), String> {
    if !is_name(&parameter.id, MAX_PARAMETER_ID) {
        return Err(format!("the id takes a-z, 0-9, '_', '-', '.', up to {MAX_PARAMETER_ID} characters"));
    }
    if parameter.label.trim().is_empty() {
        return Err("has no label".to_owned());
    }
    let ParameterInfo { low, high, default, step, .. } = *parameter;
    if ![low, high, default, step].iter().all(|v| v.is_finite()) {
        return Err(format!("a range of {low} to {high} by {step}, and {default} by default, is not finite"));
    }
    if parameter.kind == ParameterKind::Choice && parameter.choices.is_empty() {
        return Err("a choice of nothing".to_owned());
    }
    if low > high || step < 0.0 || !(low..=high).contains(&default) {
        return Err(format!("{default} by default is not in {low} to {high}, or the step {step} is below 0"));
    }
    let whole = matches!(parameter.kind, ParameterKind::Whole | ParameterKind::Switch | ParameterKind::Choice);
    if whole && [low, high, default].iter().any(|v| v.fract() != 0.0) {
        return Err("whole numbers are needed for range and default".to_owned());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plugin() -> PluginInfo {
        let parameter = ParameterInfo {
            id: "reach".into(),
            label: "Reach".into(),
            about: String::new(),
            group: String::new(),
            unit: "px".into(),
            kind: ParameterKind::Number,
            low: 1.0,
            high: 9.0,
            default: 3.0,
            default_text: String::new(),
            step: 0.0,
            choices: Vec::new(),
            visible_if: None,
            flags: 0,
        };
        PluginInfo {
            kind: PluginKind::Tracker,
            id: "org.example.one".into(),
            name: "One".into(),
            vendor: String::new(),
            version: "1".into(),
            about: String::new(),
            parameters: vec![parameter],
            state_version: 0,
        }
    }

    type Change = fn(&mut PluginInfo);

    #[test]
    fn what_cannot_be_is_refused_with_its_place() {
        assert_eq!(check(&[plugin()]), Ok(()));
        assert!(check(&[]).is_err());
        assert!(check(&[plugin(), plugin()]).expect_err("twice").contains("org.example.one"));
        let changes: [Change; 9] = [
            |p| p.id = "No Dots".into(),
            |p| p.id = "a.".repeat(80),
            |p| p.name = " ".into(),
            |p| p.parameters[0].id = "Größe".into(),
            |p| p.parameters[0].label = String::new(),
            |p| p.parameters[0].high = f64::NAN,
            |p| p.parameters[0].default = 10.0,
            |p| p.parameters[0].kind = ParameterKind::Choice,
            |p| p.parameters[0].visible_if = Some(("other".into(), 1.0)),
        ];
        for (i, change) in changes.into_iter().enumerate() {
            let mut changed = plugin();
            change(&mut changed);
            assert!(check(&[changed]).is_err(), "change {i}");
        }
    }
}
