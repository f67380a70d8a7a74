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
    watch(&job, &session.interrupt).map_err(|e| e.about(&args.clip))?;
    let points = job.take_control_points()?;
    session.interrupt.check()?;
    points.write(utf8(&args.output)?)?;
    let file: serde_json::Value = serde_json::from_str(&points.to_json()?).unwrap_or_default();
    let count = file["points"].as_array().map_or(0, Vec::len);
    let frame = &file["points"][0]["keys"][0]["frame"];
    if session.json {
        let engine = json!({ "points": count, "frame": frame }).to_string();
        say::line(&session.report("points", &engine, &args.output)?.to_string());
    } else {
        say::line(&format!("{}: {count} points on frame {frame}", args.output.display()));
    }
    Ok(())
}
