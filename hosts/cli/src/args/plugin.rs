//! What can be typed after `marey plugin`, and for plugins anywhere.

use std::path::PathBuf;

use clap::Subcommand;

/// Which plugins to use beside those that are installed.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct Plugins {
    /// Load this plugin too (a library or a bundle); may be repeated
    #[arg(long, value_name = "FILE")]
    pub(crate) plugin: Vec<PathBuf>,
    /// Choose the value of a plugin's parameter; may be repeated
    #[arg(long, value_name = "ID:PARAMETER=VALUE")]
    pub(crate) set: Vec<String>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum PluginCommand {
    /// List the plugins that are installed, and those that could not be loaded
    List(PluginList),
    /// Run the conformance suite on a plugin and say what is wrong
    Check(PluginCheck),
    /// Begin a new plugin: a project that builds, passes its own tests and loads
    New(PluginNew),
    /// Try a plugin for another process
    #[command(hide = true)]
    Probe(PluginProbe),
}

#[derive(Debug, clap::Args)]
pub(crate) struct PluginList {
    /// Load this plugin too (a library or a bundle); may be repeated
    #[arg(long, value_name = "FILE")]
    pub(crate) plugin: Vec<PathBuf>,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey plugin check target/release/libmine.so")]
pub(crate) struct PluginCheck {
    /// The library (*.so) or bundle (*.marey)
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
}

#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  marey plugin new my-tracker && cd my-tracker && cargo test")]
pub(crate) struct PluginNew {
    /// The plugin's name: a-z, 0-9 and '-'
    #[arg(value_name = "NAME")]
    pub(crate) name: String,
    /// The folder to write [default: NAME]
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Use the sdk in this folder instead of bringing it along
    #[arg(long, value_name = "DIR")]
    pub(crate) sdk: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct PluginProbe {
    /// How
    pub(crate) mode: String,
    /// The library
    pub(crate) file: PathBuf,
}
