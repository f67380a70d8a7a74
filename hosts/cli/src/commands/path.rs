//! `marey path PATHS.json -o motion.json`

use serde_json::json;

use super::{Session, check_file, utf8};
use crate::args::PathMotion;
use crate::failure::{BAD_INPUT, Failure};
use crate::say;

pub(crate) fn path(session: &Session, args: &PathMotion) -> Result<(), Failure> {
    check_file(&args.output)?;
    let bad = |e: std::io::Error| Failure::new(BAD_INPUT, format!("{}: cannot be read: {e}", args.paths.display()));
    let text = std::fs::read_to_string(&args.paths).map_err(bad)?;
    let motion = session.context.motion_from_paths(&text).map_err(|e| Failure::from(e).about(&args.paths))?;
    motion.write(utf8(&args.output)?)?;
    let info = motion.info()?;
    if session.json {
        let report = json!({ "frames": info.frames, "fps": info.fps, "tracks": info.tracks.len() });
        say::line(&session.report("path", &report.to_string(), &args.output)?.to_string());
        return Ok(());
    }
    say::line(&format!("{}: {} points over {} frames", args.output.display(), info.tracks.len(), info.frames));
    Ok(())
}
