//! `marey plugin (list | check FILE | new NAME | probe MODE FILE)`

use std::path::PathBuf;

use serde_json::{Value, json};

use marey_binding::{Plugin, PluginKind, PluginOptions, PluginParameterKind};

use super::{Session, utf8};
use crate::args::{PluginCheck, PluginList, PluginProbe, Plugins};
use crate::failure::{BAD_INPUT, FAILED, Failure};
use crate::say;

impl Session {
    /// Lets this run use plugins: those in the folders that the environment names, and the files that were named.
    pub(crate) fn use_plugins(&self, files: &[PathBuf]) -> Result<(), Failure> {
        self.open_plugins()?;
        self.context.rescan_plugins()?;
        for file in files {
            self.context.load_plugin(utf8(file)?)?;
        }
        Ok(())
    }

    /// Uses plugins where `ids` name any: what is built in has no dot in its name.
    pub(crate) fn plugins_for(&self, plugins: &Plugins, ids: &[&str]) -> Result<(), Failure> {
        if plugins.plugin.is_empty() && plugins.set.is_empty() && !ids.iter().any(|id| id.contains('.')) {
            return Ok(());
        }
        self.use_plugins(&plugins.plugin)?;
        for choice in &plugins.set {
            self.choose(choice)?;
        }
        Ok(())
    }

    fn open_plugins(&self) -> Result<(), Failure> {
        // This program tries files for itself, in a process of their own.
        let own = std::env::current_exe().ok();
        let probe = own.as_deref().and_then(|p| p.to_str()).unwrap_or_default();
        let options = PluginOptions { environment: true, probe, ..PluginOptions::default() };
        self.context.open_plugins(&options)?;
        Ok(())
    }

    /// `ID:PARAMETER=VALUE`
    fn choose(&self, choice: &str) -> Result<(), Failure> {
        let bad = || Failure::new(crate::failure::BAD_USE, format!("--set {choice}: expected ID:PARAMETER=VALUE"));
        let (id, rest) = choice.split_once(':').ok_or_else(bad)?;
        let (name, value) = rest.split_once('=').ok_or_else(bad)?;
        let parameters = self.context.plugin_parameters(id)?;
        let Some(parameter) = parameters.iter().find(|p| p.id == name) else {
            let known: Vec<&str> = parameters.iter().map(|p| p.id.as_str()).collect();
            let message = format!("--set {choice}: {id} has no parameter `{name}`; there are: {}", known.join(", "));
            return Err(Failure::new(crate::failure::BAD_USE, message));
        };
        match &parameter.kind {
            PluginParameterKind::Text | PluginParameterKind::File => self.context.set_plugin_text(id, name, value)?,
            PluginParameterKind::Choice(names) if names.iter().any(|n| n == value) => {
                let index = names.iter().position(|n| n == value).unwrap_or(0);
                self.context.set_plugin_number(id, name, index as f64)?;
            }
            _ => self.context.set_plugin_number(id, name, value.parse().map_err(|_| bad())?)?,
        }
        Ok(())
    }
}

fn kind(plugin: &Plugin) -> &'static str {
    match plugin.kind {
        PluginKind::Tracker => "tracker",
        PluginKind::Segmenter => "segmenter",
        PluginKind::Deformer => "deformer",
    }
}

/// Shows what is loaded, and what is not and why.
pub(crate) fn list(session: &Session, args: &PluginList) -> Result<(), Failure> {
    session.use_plugins(&args.plugin)?;
    let (loaded, failures) = (session.context.plugins()?, session.context.plugin_failures()?);
    if session.json {
        let mut rows = Vec::new();
        for plugin in &loaded {
            let parameters: Vec<Value> = session.context.plugin_parameters(&plugin.id)?.iter().map(parameter).collect();
            rows.push(json!({
                "id": plugin.id, "kind": kind(plugin), "name": plugin.name, "vendor": plugin.vendor,
                "version": plugin.version, "about": plugin.about, "file": plugin.file, "enabled": plugin.enabled,
                "door": if plugin.rust_door { "rust" } else { "c" }, "parameters": parameters,
            }));
        }
        let failures: Vec<Value> = failures.iter().map(|(s, line)| json!({ "status": s, "message": line })).collect();
        let report = json!({ "command": "plugin list", "plugins": rows, "failures": failures });
        say::line(&report.to_string());
        return Ok(());
    }
    if loaded.is_empty() && failures.is_empty() {
        say::line(
            "no plugins; they are looked for in $MAREY_PLUGIN_PATH, ~/.local/share/marey/plugins and /usr/lib/marey/plugins",
        );
    }
    for plugin in &loaded {
        say::line(&format!("{}  {} {} ({})  {}", plugin.id, plugin.name, plugin.version, kind(plugin), plugin.file));
    }
    failures.iter().for_each(|(_, line)| say::warning(line));
    Ok(())
}

fn parameter(parameter: &marey_binding::PluginParameter) -> Value {
    let (kind, low, high, choices) = match &parameter.kind {
        PluginParameterKind::Number(low, high) => ("number", *low, *high, Vec::new()),
        PluginParameterKind::Whole(low, high) => ("whole", *low, *high, Vec::new()),
        PluginParameterKind::Switch => ("switch", 0.0, 1.0, Vec::new()),
        PluginParameterKind::Choice(names) => ("choice", 0.0, names.len() as f64 - 1.0, names.clone()),
        PluginParameterKind::Text => ("text", 0.0, 0.0, Vec::new()),
        PluginParameterKind::File => ("file", 0.0, 0.0, Vec::new()),
    };
    json!({
        "id": parameter.id, "label": parameter.label, "about": parameter.about, "group": parameter.group,
        "unit": parameter.unit, "kind": kind, "low": low, "high": high, "default": parameter.default,
        "choices": choices,
    })
}

/// Runs the conformance suite and shows what is wrong.
pub(crate) fn check(session: &Session, args: &PluginCheck) -> Result<(), Failure> {
    session.open_plugins()?;
    let report = session.context.check_plugin(utf8(&args.file)?)?;
    let report: Value = serde_json::from_str(&report).map_err(|e| Failure::new(FAILED, format!("report: {e}")))?;
    let passed = report.get("passed").and_then(Value::as_bool).unwrap_or(false);
    if session.json {
        say::line(&report.to_string());
    } else {
        for plugin in report.get("plugins").and_then(Value::as_array).into_iter().flatten() {
            let word = |value: &Value, key: &str| value.get(key).and_then(Value::as_str).unwrap_or_default().to_owned();
            say::line(&format!("{} {} ({} door)", word(plugin, "id"), word(plugin, "version"), word(plugin, "door")));
            for check in plugin.get("checks").and_then(Value::as_array).into_iter().flatten() {
                let good = check.get("passed").and_then(Value::as_bool).unwrap_or(false);
                let (mark, name, detail) = (if good { "ok" } else { "NO" }, word(check, "name"), word(check, "detail"));
                say::line(&format!("  {mark}  {name}: {detail}"));
            }
        }
    }
    if passed {
        return Ok(());
    }
    Err(Failure::new(BAD_INPUT, format!("{}: does not do what plugin.h asks, as listed", args.file.display())))
}

/// Tries a plugin for another process, which started this one.
pub(crate) fn probe(session: &Session, args: &PluginProbe) -> Result<(), Failure> {
    say::line(&session.context.probe_plugin(&args.mode, utf8(&args.file)?)?);
    Ok(())
}
