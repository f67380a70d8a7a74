//! Plugins: what is loaded, what is not and why, and what can be chosen about them.

use marey_ffi::{
    MRY_PARAMETER_CHOICE, MRY_PARAMETER_FILE, MRY_PARAMETER_HIDDEN, MRY_PARAMETER_SWITCH, MRY_PARAMETER_TEXT,
    MRY_PARAMETER_WHOLE, MRY_PLUGIN_DOOR_RUST, MRY_PLUGIN_KIND_DEFORMER, MRY_PLUGIN_KIND_SEGMENTER,
};

use crate::session::found;
use crate::{Context, Result, sys};

/// Where plugins come from.
#[derive(Clone, Debug, Default)]
pub struct PluginOptions<'a> {
    /// Look where the environment says too, and keep copies in the user's cache.
    pub environment: bool,
    /// Folders to look in before all others.
    pub folders: Vec<String>,
    /// The folder for private copies; empty for the user's cache, with `environment`.
    pub cache: &'a str,
    /// The program that tries a file in another process first; empty for none.
    pub probe: &'a str,
}

/// What a plugin does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PluginKind {
    /// It follows limbs.
    Tracker,
    /// It cuts the creature out.
    Segmenter,
    /// It moves a mesh by handles.
    Deformer,
}

/// A plugin that is loaded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plugin {
    /// What it does.
    pub kind: PluginKind,
    /// Its name for ever.
    pub id: String,
    /// What a person reads.
    pub name: String,
    /// Who made it.
    pub vendor: String,
    /// Its version.
    pub version: String,
    /// What it is good at.
    pub about: String,
    /// The file it came from.
    pub file: String,
    /// Whether it came by the door that abi_stable checks.
    pub rust_door: bool,
    /// Whether it may be used.
    pub enabled: bool,
    /// The number of its newest build.
    pub generation: u64,
    /// How many instances there are.
    pub instances: u32,
}

/// What values a parameter of a plugin takes.
#[derive(Clone, Debug, PartialEq)]
pub enum PluginParameterKind {
    /// Any number from the first to the second.
    Number(f64, f64),
    /// A whole number from the first to the second.
    Whole(f64, f64),
    /// 0 or 1.
    Switch,
    /// The index of one of these.
    Choice(Vec<String>),
    /// A line of text.
    Text,
    /// The path of a file.
    File,
}

/// A parameter of a plugin, to be shown without knowing any.
#[derive(Clone, Debug, PartialEq)]
pub struct PluginParameter {
    /// Its name for ever.
    pub id: String,
    /// What a person reads beside the control.
    pub label: String,
    /// What it does.
    pub about: String,
    /// Where it stands among others.
    pub group: String,
    /// "px", "frames".
    pub unit: String,
    /// What values it takes.
    pub kind: PluginParameterKind,
    /// The value where none is chosen; 0 for texts.
    pub default: f64,
    /// One step of a slider; 0 for none.
    pub step: f64,
    /// Shown only while this parameter has this value.
    pub visible_if: Option<(String, f64)>,
    /// Not to be shown.
    pub hidden: bool,
}

impl Context {
    /// Lets the context use plugins. Once; loads nothing yet.
    pub fn open_plugins(&self, options: &PluginOptions<'_>) -> Result<()> {
        sys::plugins_open(&self.0, options)
    }

    /// Looks for plugins that are new, and for new builds; gives how many files are loaded, refused or gone.
    pub fn rescan_plugins(&self) -> Result<u32> {
        sys::plugins_rescan(&self.0)
    }

    /// Loads one library or bundle by its name.
    pub fn load_plugin(&self, file: &str) -> Result<()> {
        sys::plugins_load(&self.0, file)
    }

    /// Takes a file out of quarantine.
    pub fn retry_plugin(&self, file: &str) -> Result<()> {
        sys::plugins_retry(&self.0, file)
    }

    /// The report of the conformance suite on a library, as JSON.
    pub fn check_plugin(&self, file: &str) -> Result<String> {
        sys::plugins_check(&self.0, file)
    }

    /// What a probe program prints.
    pub fn probe_plugin(&self, mode: &str, file: &str) -> Result<String> {
        sys::plugins_probe(&self.0, mode, file)
    }

    /// The plugins that are loaded.
    pub fn plugins(&self) -> Result<Vec<Plugin>> {
        (0..).map_while(|index| self.plugin(index).transpose()).collect()
    }

    fn plugin(&self, index: u32) -> Result<Option<Plugin>> {
        let Some(info) = found(sys::plugin_info(&self.0, index))? else { return Ok(None) };
        Ok(Some(Plugin {
            kind: match info.kind {
                MRY_PLUGIN_KIND_SEGMENTER => PluginKind::Segmenter,
                MRY_PLUGIN_KIND_DEFORMER => PluginKind::Deformer,
                _ => PluginKind::Tracker,
            },
            id: sys::text(&info.id),
            name: sys::text(&info.name),
            vendor: sys::text(&info.vendor),
            version: sys::text(&info.version),
            about: sys::plugin_about(&self.0, index)?,
            file: sys::plugin_file(&self.0, index)?,
            rust_door: info.door == MRY_PLUGIN_DOOR_RUST,
            enabled: info.enabled != 0,
            generation: info.generation,
            instances: info.instance_count,
        }))
    }

    /// The files that are not loaded: the status, and why in a line.
    pub fn plugin_failures(&self) -> Result<Vec<(i32, String)>> {
        (0..).map_while(|index| found(sys::plugin_failure(&self.0, index)).transpose()).collect()
    }

    /// Switches a plugin off or on.
    pub fn set_plugin_enabled(&self, id: &str, enabled: bool) -> Result<()> {
        sys::plugin_set_enabled(&self.0, id, enabled)
    }

    /// The parameters of a plugin, in the order in which to show them.
    pub fn plugin_parameters(&self, id: &str) -> Result<Vec<PluginParameter>> {
        (0..).map_while(|index| self.plugin_parameter(id, index).transpose()).collect()
    }

    fn plugin_parameter(&self, id: &str, index: u32) -> Result<Option<PluginParameter>> {
        let Some(info) = found(sys::plugin_parameter(&self.0, id, index))? else { return Ok(None) };
        let kind = match info.kind {
            MRY_PARAMETER_WHOLE => PluginParameterKind::Whole(info.low, info.high),
            MRY_PARAMETER_SWITCH => PluginParameterKind::Switch,
            MRY_PARAMETER_CHOICE => {
                let name = |choice| sys::plugin_choice(&self.0, id, index, choice);
                PluginParameterKind::Choice((0..info.choice_count).map(name).collect::<Result<_>>()?)
            }
            MRY_PARAMETER_TEXT => PluginParameterKind::Text,
            MRY_PARAMETER_FILE => PluginParameterKind::File,
            _ => PluginParameterKind::Number(info.low, info.high),
        };
        let visible_if = sys::text(&info.visible_if);
        Ok(Some(PluginParameter {
            id: sys::text(&info.id),
            label: sys::text(&info.label),
            about: sys::text(&info.about),
            group: sys::text(&info.group),
            unit: sys::text(&info.unit),
            kind,
            default: info.default_value,
            step: info.step,
            visible_if: (!visible_if.is_empty()).then_some((visible_if, info.visible_value)),
            hidden: info.flags & MRY_PARAMETER_HIDDEN != 0,
        }))
    }

    /// Chooses the value of a parameter of a plugin.
    pub fn set_plugin_number(&self, id: &str, name: &str, value: f64) -> Result<()> {
        sys::plugin_set_number(&self.0, id, name, value)
    }

    /// Chooses the text of a parameter of a plugin.
    pub fn set_plugin_text(&self, id: &str, name: &str, value: &str) -> Result<()> {
        sys::plugin_set_text(&self.0, id, name, value)
    }

    /// The value of a parameter of a plugin.
    pub fn plugin_number(&self, id: &str, name: &str) -> Result<f64> {
        sys::plugin_number(&self.0, id, name)
    }

    /// The text of a parameter of a plugin.
    pub fn plugin_text(&self, id: &str, name: &str) -> Result<String> {
        sys::plugin_text(&self.0, id, name)
    }
}
