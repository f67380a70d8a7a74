//! The plugins that there are. A thread of their own looks for them, again and again, so that a rebuilt one is taken while a
//! session is open; what is chosen about them is remembered and goes to them by the same way.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use eframe::egui;
use marey_binding::{Context, Plugin, PluginKind, PluginOptions, PluginParameter, PluginParameterKind};
use serde::{Deserialize, Serialize};

use crate::{Places, texts};

/// From one look at the folders to the next.
const LOOK: Duration = Duration::from_secs(2);
/// As long a session waits for the first look: a plugin that hangs is given up by then.
const FIRST_LOOK: Duration = Duration::from_secs(10);

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum Value {
    Number(f64),
    Text(String),
}

/// What is remembered of one plugin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Remembered {
    pub(crate) off: bool,
    pub(crate) values: BTreeMap<String, Value>,
}

/// By the plugin's id.
pub(crate) type AllRemembered = BTreeMap<String, Remembered>;

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Loaded {
    pub(crate) plugin: Plugin,
    /// In the order in which to show them.
    pub(crate) parameters: Vec<(PluginParameter, Value)>,
}

/// A file that is not loaded.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Failed {
    pub(crate) file: String,
    /// The file, the problem and the remedy in a line.
    pub(crate) reason: String,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Found {
    pub(crate) loaded: Vec<Loaded>,
    pub(crate) failed: Vec<Failed>,
}

/// What is to be done about them.
#[derive(Clone, Debug)]
pub(crate) enum Ask {
    Look,
    Retry(String),
    Enable(String, bool),
    Set(String, String, Value),
}

pub(crate) struct Plugins {
    asks: Sender<Ask>,
    news: Receiver<Result<Found, String>>,
    pub(crate) found: Found,
    first: FirstLook,
}

/// Whether the folders were looked through once.
#[derive(Clone, Debug, Default)]
pub(crate) struct FirstLook(Arc<(Mutex<bool>, Condvar)>);

impl FirstLook {
    /// Waits for it, for a while.
    pub(crate) fn wait(&self) {
        let done = self.0.0.lock().unwrap_or_else(PoisonError::into_inner);
        drop(self.0.1.wait_timeout_while(done, FIRST_LOOK, |done| !*done));
    }

    fn done(&self) {
        *self.0.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.1.notify_all();
    }
}

impl Plugins {
    pub(crate) fn start(ui: &egui::Context, context: &Context, places: &Places, remembered: &AllRemembered) -> Self {
        let (asks, asked) = channel();
        let (send, news) = channel();
        let first = FirstLook::default();
        let (context, places, ui, told) = (context.clone(), places.clone(), ui.clone(), first.clone());
        let remembered = remembered.clone();
        std::thread::spawn(move || {
            let opened = open(&context, &places);
            if let Err(e) = &opened {
                let _ = send.send(Err(e.to_string()));
            } else {
                watch(&context, remembered, &asked, &send, &ui, &told);
            }
            told.done();
            ui.request_repaint();
        });
        Self { asks, news, found: Found::default(), first }
    }

    pub(crate) fn first_look(&self) -> FirstLook {
        self.first.clone()
    }

    pub(crate) fn of_kind(&self, kind: PluginKind) -> impl Iterator<Item = &Loaded> {
        self.found.loaded.iter().filter(move |l| l.plugin.kind == kind && l.plugin.enabled)
    }

    pub(crate) fn by_id(&self, id: &str) -> Option<&Loaded> {
        self.found.loaded.iter().find(|l| l.plugin.id == id)
    }

    /// Has something done, shows it as done, and remembers it.
    pub(crate) fn ask(&mut self, ask: Ask, remembered: &mut AllRemembered) {
        match &ask {
            Ask::Look | Ask::Retry(_) => {}
            Ask::Enable(id, on) => {
                remembered.entry(id.clone()).or_default().off = !on;
                self.found.loaded.iter_mut().filter(|l| l.plugin.id == *id).for_each(|l| l.plugin.enabled = *on);
            }
            Ask::Set(id, name, value) => {
                remembered.entry(id.clone()).or_default().values.insert(name.clone(), value.clone());
                let of = self.found.loaded.iter_mut().filter(|l| l.plugin.id == *id);
                of.flat_map(|l| &mut l.parameters).filter(|p| p.0.id == *name).for_each(|p| p.1 = value.clone());
            }
        }
        let _ = self.asks.send(ask);
    }

    /// Takes in what was found; gives lines about what a person should hear: what failed, or what is new.
    pub(crate) fn update(&mut self) -> Vec<Result<String, String>> {
        let mut lines = Vec::new();
        while let Ok(news) = self.news.try_recv() {
            let found = match news {
                Ok(found) => found,
                Err(message) => {
                    lines.push(Err(message));
                    continue;
                }
            };
            for now in &found.loaded {
                let newer = |before: &&Loaded| before.plugin.generation < now.plugin.generation;
                if self.by_id(&now.plugin.id).filter(newer).is_some() {
                    lines.push(Ok(texts::plugin_rebuilt(&now.plugin.name)));
                }
            }
            self.found = found;
        }
        lines
    }
}

/// What a program that tries plugins in another process has to print.
///
/// # Errors
/// There is no such mode; for a person.
pub fn probe(mode: &str, file: &str) -> Result<String, String> {
    let context = Context::new(1).map_err(|e| e.to_string())?;
    context.probe_plugin(mode, file).map_err(|e| e.to_string())
}

fn open(context: &Context, places: &Places) -> marey_binding::Result<()> {
    let text = |path: &Path| path.to_string_lossy().into_owned();
    let probe = places.probe.as_deref().map(text).unwrap_or_default();
    let options = match &places.plugin_cache {
        Some(cache) => PluginOptions {
            environment: false,
            folders: vec![text(&places.plugins)],
            cache: &text(cache),
            probe: &probe,
        },
        None => PluginOptions { environment: true, probe: &probe, ..PluginOptions::default() },
    };
    context.open_plugins(&options)
}

fn watch(
    context: &Context,
    mut remembered: AllRemembered,
    asked: &Receiver<Ask>,
    send: &Sender<Result<Found, String>>,
    ui: &egui::Context,
    first: &FirstLook,
) {
    let mut last = None;
    let mut loaded: Vec<String> = Vec::new();
    let mut next = Ask::Look;
    loop {
        let done = match &next {
            Ask::Look => Ok(()),
            Ask::Retry(file) => context.retry_plugin(file),
            Ask::Enable(id, on) => context.set_plugin_enabled(id, *on),
            Ask::Set(id, name, value) => set(context, id, name, value),
        };
        if let Err(e) = done {
            let _ = send.send(Err(e.to_string()));
        }
        let found = look(context, &mut remembered).and_then(|found| {
            let is_loaded = |file: &String| found.loaded.iter().any(|l| l.plugin.file == *file);
            if found.failed.is_empty() || loaded.iter().all(is_loaded) {
                return Ok(found);
            }
            // What was refused for what another file brought, as a build under another name is, may be good now.
            found.failed.iter().for_each(|failed| drop(context.retry_plugin(&failed.file)));
            look(context, &mut remembered)
        });
        if let Ok(found) = &found {
            loaded = found.loaded.iter().map(|l| l.plugin.file.clone()).collect();
        }
        first.done();
        let found = found.map_err(|e| e.to_string());
        if last.as_ref() != Some(&found) {
            last = Some(found.clone());
            if send.send(found).is_err() {
                return;
            }
            ui.request_repaint();
        }
        next = match asked.recv_timeout(LOOK) {
            Ok(ask) => ask,
            Err(RecvTimeoutError::Timeout) => Ask::Look,
            Err(RecvTimeoutError::Disconnected) => return,
        };
    }
}

/// Looks through the folders, and lets what is remembered of new plugins be so.
fn look(context: &Context, remembered: &mut AllRemembered) -> marey_binding::Result<Found> {
    context.rescan_plugins()?;
    for plugin in context.plugins()? {
        // Once: from then on what is chosen is what the plugin has.
        let Some(wanted) = remembered.remove(&plugin.id) else { continue };
        for (name, value) in &wanted.values {
            // A parameter that a new build has no more is no loss.
            let _ = set(context, &plugin.id, name, value);
        }
        if wanted.off {
            context.set_plugin_enabled(&plugin.id, false)?;
        }
    }
    find(context)
}

fn set(context: &Context, id: &str, name: &str, value: &Value) -> marey_binding::Result<()> {
    match value {
        Value::Number(value) => context.set_plugin_number(id, name, *value),
        Value::Text(value) => context.set_plugin_text(id, name, value),
    }
}

fn find(context: &Context) -> marey_binding::Result<Found> {
    let with_parameters = |plugin: Plugin| {
        let value = |parameter: PluginParameter| {
            let value = match parameter.kind {
                PluginParameterKind::Text | PluginParameterKind::File => {
                    Value::Text(context.plugin_text(&plugin.id, &parameter.id)?)
                }
                _ => Value::Number(context.plugin_number(&plugin.id, &parameter.id)?),
            };
            Ok((parameter, value))
        };
        let parameters = context.plugin_parameters(&plugin.id)?.into_iter().map(value);
        let parameters = parameters.collect::<marey_binding::Result<_>>()?;
        Ok(Loaded { parameters, plugin })
    };
    let loaded = context.plugins()?.into_iter().map(with_parameters).collect::<marey_binding::Result<_>>()?;
    let failed = |(_, reason): (i32, String)| Failed { file: file_of(&reason), reason };
    Ok(Found { loaded, failed: context.plugin_failures()?.into_iter().map(failed).collect() })
}

/// The file that a line of a failure begins with: up to the colon behind it, of which its name may have some.
fn file_of(reason: &str) -> String {
    let ends = reason.match_indices(": ").map(|(at, _)| &reason[..at]);
    let mut ends = ends.peekable();
    let shortest = ends.peek().copied().unwrap_or(reason);
    ends.find(|file| Path::new(file).exists()).unwrap_or(shortest).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_of_a_failure_is_what_its_line_begins_with() {
        assert_eq!(file_of("/no/where.so: is no library: really; build it"), "/no/where.so");
        assert_eq!(file_of("nothing"), "nothing");
    }
}
