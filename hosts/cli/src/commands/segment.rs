//! `marey segment CLIP --strokes S.json -o DIR`

use marey_binding::SegmentOptions;

use super::{Session, utf8};
use crate::args::Segment;
use crate::failure::Failure;
use crate::say;
use crate::watch::watch;

pub(crate) fn segment(session: &Session, args: &Segment) -> Result<(), Failure> {
    session.plugins_for(&args.drawn.plugins, &[&args.drawn.tracker, &args.segmenter])?;
    let (clip, rig) = session.open(&args.drawn.clip, &args.drawn.strokes)?;
    let options = SegmentOptions {
        motion: None,
        tracker: &args.drawn.tracker,
        segmenter: &args.segmenter,
        folder: utf8(&args.output)?,
    };
    let job = session.context.start_segment(&clip, &rig, &options)?;
    watch(&job, &session.interrupt)?;
    let masks = job.take_masks()?;
    if session.json {
        say::line(&session.report("segment", &masks.report()?, &args.output)?.to_string());
        return Ok(());
    }
    say::line(&format!("{}: {} masks", args.output.display(), masks.frames()?));
    Ok(())
}
