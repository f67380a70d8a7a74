//! `marey`, the command line: video of something alive in, animation out.
//!
//! Exit codes: 0 done, 2 bad use, 3 bad input, 4 failed, 130 cancelled. An error is one line on stderr that names the
//! thing, the place and the remedy. With `--json` stdout holds one report and nothing else.

mod args;
mod commands;
mod failure;
mod say;
mod watch;

use clap::Parser as _;
use clap::error::ErrorKind;

use crate::args::{Args, Command, PluginCommand, SessionCommand};
use crate::failure::{Failure, one_line};

fn main() {
    std::process::exit(match Args::try_parse() {
        Ok(args) => match run(&args) {
            Ok(()) => 0,
            Err(failure) => {
                say::error(&failure.message);
                failure.exit_code
            }
        },
        // Help and version are no mistakes; clap knows where each of its texts belongs.
        Err(e) if !e.use_stderr() => {
            say::text(&e.render().to_string());
            0
        }
        Err(e) if e.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            say::help(&e.render().to_string());
            failure::BAD_USE
        }
        Err(e) => {
            say::error(&one_line(&e));
            failure::BAD_USE
        }
    });
}

fn run(args: &Args) -> Result<(), Failure> {
    let session = commands::Session::new(args.threads, args.json)?;
    match &args.command {
        Command::Info(info) => commands::info(&session, info),
        Command::Track(track) => commands::track(&session, track),
        Command::Points(points) => commands::points(&session, points),
        Command::Segment(segment) => commands::segment(&session, segment),
        Command::Creature(creature) => commands::creature(&session, creature),
        Command::Render(render) => commands::render(&session, render),
        Command::Crowd(crowd) => commands::crowd(&session, crowd),
        Command::Texture(texture) => commands::texture(&session, texture),
        Command::Edit(edit) => commands::edit(&session, edit),
        Command::Print(print) => commands::print(&session, print),
        Command::Demo(demo) => commands::demo(&session, demo),
        Command::Rig(rig) => commands::rig(&session, rig),
        Command::Character(character) => commands::character(&session, character),
        Command::Retarget(retarget) => commands::retarget(&session, retarget),
        Command::Motion(command) => commands::motion(&session, command),
        Command::Pose(pose) => commands::pose(&session, pose),
        Command::Bind(bind) => commands::bind(&session, bind),
        Command::Sketch(sketch) => commands::sketch(&session, sketch),
        Command::Path(path) => commands::path(&session, path),
        Command::Deform(deform) => commands::deform(&session, deform),
        Command::Plugin(PluginCommand::List(plugins)) => commands::plugin_list(&session, plugins),
        Command::Plugin(PluginCommand::Check(check)) => commands::plugin_check(&session, check),
        Command::Plugin(PluginCommand::New(new)) => commands::plugin_new(new),
        Command::Plugin(PluginCommand::Probe(probe)) => commands::plugin_probe(&session, probe),
        Command::Session(SessionCommand::Info(info)) => commands::session_info(&session, info),
        Command::Session(SessionCommand::Embed(embed)) => commands::session_embed(&session, embed),
        Command::Session(SessionCommand::Replay(replay)) => commands::session_replay(&session, replay),
    }
}
