//! `marey render CREATURE -o OUT`: a creature from any side.

use std::path::Path;

use marey_binding::{Adapter, Camera, RenderFileOptions, RenderOptions, Style};

use super::character::{colour, parsed};
use super::{Session, utf8};
use crate::args::{self, Look, Render};
use crate::failure::{BAD_USE, Failure};
use crate::say;
use crate::watch::watch;

/// A turn around one frame takes so many pictures: 5 degrees each, three seconds at 24 a second.
const TURN: u64 = 72;
/// A turntable looks a little from above.
const TURN_PITCH: f32 = 15.0;

pub(crate) fn render(session: &Session, args: &Render) -> Result<(), Failure> {
    let look = &args.look;
    let pictures = pictures(look)?;
    let creature = session.context.open_creature(utf8(&args.creature)?)?;
    let job = session.context.start_render(&creature, &pictures, &file(look)?)?;
    watch(&job, &session.interrupt)?;
    say_drawn(session, "render", &job.report()?, &look.output)
}

/// What the pictures are like.
pub(super) fn pictures(look: &Look) -> Result<RenderOptions, Failure> {
    Ok(RenderOptions {
        size: look.size.as_deref().map(size).transpose()?.unwrap_or_default(),
        style: style(look.style),
        adapter: match look.adapter {
            args::Adapter::Auto => Adapter::Auto,
            args::Adapter::Gpu => Adapter::Gpu,
            args::Adapter::Cpu => Adapter::Cpu,
        },
        hard_edges: look.hard_edges,
        shadow: look.shadow,
        background: colour(&look.background)?,
        frame: look.frame.unwrap_or(0),
        camera: camera(look)?,
    })
}

/// What the file is like.
pub(super) fn file(look: &Look) -> Result<RenderFileOptions<'_>, Failure> {
    let turns = turns(look);
    let alone = match look.frame {
        None => 0,
        Some(_) if turns != 0.0 => TURN,
        Some(_) => 1,
    };
    Ok(RenderFileOptions {
        path: utf8(&look.output)?,
        format: look.format.as_deref().unwrap_or_default(),
        still: look.frame.is_some(),
        frames: look.frames.unwrap_or(alone),
        fps: look.fps.unwrap_or(0.0),
        turns,
    })
}

fn turns(look: &Look) -> f32 {
    look.turns.unwrap_or(if look.turntable { 1.0 } else { 0.0 })
}

/// Says what a render job wrote.
pub(super) fn say_drawn(session: &Session, command: &str, report: &str, output: &Path) -> Result<(), Failure> {
    if session.json {
        say::line(&session.report(command, report, output)?.to_string());
        return Ok(());
    }
    let report = parsed(report)?;
    let (frames, size) = (&report["frames"], &report["size"]);
    let count = if *frames == 1 { "1 picture".into() } else { format!("{frames} pictures") };
    say::line(&format!(
        "{}: {count} of {}x{}, drawn by {}, in {:.1} s",
        output.display(),
        size[0],
        size[1],
        report["renderer"].as_str().unwrap_or_default(),
        session.seconds(),
    ));
    Ok(())
}

fn style(style: args::Style) -> Style {
    match style {
        args::Style::Textured => Style::Textured,
        args::Style::Shaded => Style::Shaded,
        args::Style::Wireframe => Style::Wireframe,
        args::Style::Radius => Style::Radius,
        args::Style::Bones => Style::Bones,
        args::Style::Depth => Style::Depth,
        args::Style::Normals => Style::Normals,
    }
}

fn camera(args: &Look) -> Result<Camera, Failure> {
    let turning = if turns(args) == 0.0 && args.distance.is_none() { None } else { Some([0.0, TURN_PITCH]) };
    let view = match args.view.as_deref() {
        Some("clip") => None,
        Some(text) => Some(numbers::<2>("--view", text, "YAW,PITCH in degrees, or clip")?),
        None => turning,
    };
    let Some([yaw, pitch]) = view else { return Ok(Camera::Clip) };
    match (args.target.as_deref(), args.distance) {
        (Some(target), Some(reach)) => {
            let target = numbers::<3>("--target", target, "X,Y,Z in pixels of the clip")?;
            Ok(Camera::Placed { yaw, pitch, fov: args.fov, reach, target })
        }
        _ => Ok(Camera::Fitted { yaw, pitch, fov: args.fov }),
    }
}

fn size(text: &str) -> Result<(u32, u32), Failure> {
    let sides = text.split_once('x').and_then(|(w, h)| Some((w.trim().parse().ok()?, h.trim().parse().ok()?)));
    match sides {
        Some((width, height)) if width > 0 && height > 0 => Ok((width, height)),
        _ => Err(Failure::new(BAD_USE, format!("--size {text}: give WIDTHxHEIGHT in pixels, such as 1280x720"))),
    }
}

fn numbers<const N: usize>(option: &str, text: &str, shape: &str) -> Result<[f32; N], Failure> {
    let numbers: Option<Vec<f32>> =
        text.split(',').map(|n| n.trim().parse().ok().filter(|n: &f32| n.is_finite())).collect();
    let wrong = || Failure::new(BAD_USE, format!("{option} {text}: give {shape}"));
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(wrong)
}
