//! `marey points CLIP -o points.json`

use serde_json::json;

use super::{Session, check_file, utf8};
use crate::args::Points;
use crate::failure::Failure;
use crate::say;
use crate::watch::watch;

pub(crate) fn points(session: &Session, args: &Points) -> Result<(), Failure> {
    check_file(&args.output)?;
    let clip = session.open_clip(&args.clip)?;
    let job = session.context.start_propose_points(&clip, args.frame, args.most)?;
    watch(&job, &session.interrupt)?;
    let points = job.take_control_points()?;
    session.interrupt.check()?;
    points.write(utf8(&args.output)?)?;
    let file: serde_json::Value = serde_json::from_str(&points.to_json()?).unwrap_or_default();
    let count = file["points"].as_array().map_or(0, Vec::len);
    if session.json {
        let engine = json!({ "points": count, "frame": args.frame }).to_string();
        say::line(&session.report("points", &engine, &args.output)?.to_string());
    } else {
        say::line(&format!("{}: {count} points on frame {}", args.output.display(), args.frame));
    }
    Ok(())
}
