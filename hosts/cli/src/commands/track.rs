//! `marey track CLIP --strokes S.json -o motion.json`

use marey_binding::TrackOptions;

use super::{Session, check_file, next_stroke, utf8};
use crate::args::Track;
use crate::failure::Failure;
use crate::say;
use crate::watch::watch;

pub(crate) fn track(session: &Session, args: &Track) -> Result<(), Failure> {
    check_file(&args.output)?;
    session.plugins_for(&args.drawn.plugins, &[&args.drawn.tracker])?;
    let (clip, rig) = session.open(&args.drawn)?;
    let job = session.context.start_track(&clip, &rig, &TrackOptions { tracker: &args.drawn.tracker })?;
    watch(&job, &session.interrupt)?;
    let motion = job.take_motion()?;
    session.interrupt.check()?;
    motion.write(utf8(&args.output)?)?;
    let report = session.report("track", &motion.report(&clip, &rig)?, &args.output)?;
    if session.json {
        say::line(&report.to_string());
        return Ok(());
    }
    let info = motion.info()?;
    say::line(&format!("{}: {} limbs over {} frames", args.output.display(), info.tracks.len(), info.frames));
    next_stroke(&report).inspect(|line| say::line(line));
    Ok(())
}
