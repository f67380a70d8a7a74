//! `marey crowd CROWD -o OUT`: a creature many times over.

use marey_binding::Crowd;
use serde_json::json;

use super::render::{file, pictures, say_drawn};
use super::{Session, masks_of, utf8};
use crate::args;
use crate::failure::{BAD_USE, Failure};
use crate::say;
use crate::watch::watch;

/// A herd that nobody counted.
const COUNT: u32 = 9;

pub(crate) fn crowd(session: &Session, args: &args::Crowd) -> Result<(), Failure> {
    let look = &args.look;
    let ending = look.output.extension().map(|e| e.to_ascii_lowercase());
    if ending.is_some_and(|e| e == "glb") {
        if args.into.is_some() {
            return Err(Failure::new(
                BAD_USE,
                "--into: a clip cannot be put into a .glb; choose an animation, such as .mp4",
            ));
        }
        let crowd = open(session, args, look.frames.unwrap_or(0))?;
        crowd.write_glb(utf8(&look.output)?, args.scale)?;
        let info = crowd.info()?;
        if session.json {
            let report = json!({ "instances": info.instances, "frames": info.frames, "fps": info.fps });
            say::line(&session.report("crowd", &report.to_string(), &look.output)?.to_string());
        } else {
            let seconds = session.seconds();
            let (instances, frames) = (info.instances, info.frames);
            say::line(&format!("{}: {instances} creatures, {frames} frames, in {seconds:.1} s", look.output.display()));
        }
        return Ok(());
    }
    let (pictures, file) = (pictures(look)?, file(look)?);
    let job = match &args.into {
        None => session.context.start_render_crowd(&open(session, args, 0)?, &pictures, &file)?,
        Some(into) => {
            let clip = session.open_clip(into)?;
            let frames =
                look.frames.unwrap_or(if args.count.is_some() || !is_file(args) { clip.info()?.frames } else { 0 });
            let masks = masks_of(session, args.masks.as_deref(), &args.crowd)?;
            let crowd = open(session, args, frames)?;
            session.context.start_render_in_clip(&crowd, &clip, masks.as_ref(), args.alone, &pictures, &file)?
        }
    };
    watch(&job, &session.interrupt)?;
    say_drawn(session, "crowd", &job.report()?, &look.output)
}

/// Whether the crowd is a file that says who stands where.
fn is_file(args: &args::Crowd) -> bool {
    args.crowd.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

fn open(session: &Session, args: &args::Crowd, frames: u64) -> Result<Crowd, Failure> {
    if is_file(args) {
        if args.count.is_some() {
            return Err(Failure::new(BAD_USE, "--count: the file says how many there are; leave one of them out"));
        }
        return Ok(session.context.read_crowd(utf8(&args.crowd)?)?);
    }
    let creature = session.context.open_creature(utf8(&args.crowd)?)?;
    Ok(session.context.herd(&creature, args.count.unwrap_or(COUNT), frames)?)
}
