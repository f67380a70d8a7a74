//! `marey track CLIP (--strokes S.json | --joints J.json | --points P.json) -o motion.json`

use std::path::Path;

use marey_binding::{Motion, TrackOptions};
use serde_json::Value;

use super::{Session, check_file, next_stroke, utf8};
use crate::args::Track;
use crate::failure::Failure;
use crate::say;
use crate::watch::watch;

pub(crate) fn track(session: &Session, args: &Track) -> Result<(), Failure> {
    check_file(&args.output)?;
    match (&args.joints, &args.points, &args.strokes) {
        (Some(joints), _, _) => capture(session, args, joints),
        (None, Some(points), _) => track_points(session, args, points),
        (None, None, Some(strokes)) => track_limbs(session, args, strokes),
        // The parser asks for one of them.
        (None, None, None) => Ok(()),
    }
}

fn track_limbs(session: &Session, args: &Track, strokes: &Path) -> Result<(), Failure> {
    session.plugins_for(&args.plugins, &[&args.tracker])?;
    let (clip, rig) = session.open(&args.clip, strokes)?;
    let job = session.context.start_track(&clip, &rig, &TrackOptions { tracker: &args.tracker })?;
    watch(&job, &session.interrupt)?;
    let motion = job.take_motion()?;
    let report = finish(session, args, &motion, &motion.report(&clip, &rig)?)?;
    if let Some(report) = report {
        say_tracks(args, &motion, "limbs")?;
        next_stroke(&report).inspect(|line| say::line(line));
    }
    Ok(())
}

fn capture(session: &Session, args: &Track, marks: &Path) -> Result<(), Failure> {
    let joints = session.context.read_joints(utf8(marks)?)?;
    let clip = session.open_clip(&args.clip)?;
    joints.validate(Some(&clip)).map_err(|e| Failure::from(e).about(marks))?;
    let job = session.context.start_capture(&clip, &joints, None)?;
    watch(&job, &session.interrupt)?;
    let motion = job.take_motion()?;
    let report = finish(session, args, &motion, &motion.capture_report(&clip, &joints)?)?;
    if let Some(report) = report {
        say_tracks(args, &motion, "joints")?;
        next_mark(&report).inspect(|line| say::line(line));
    }
    Ok(())
}

fn track_points(session: &Session, args: &Track, marks: &Path) -> Result<(), Failure> {
    let points = session.context.read_control_points(utf8(marks)?)?;
    let clip = session.open_clip(&args.clip)?;
    points.validate(Some(&clip)).map_err(|e| Failure::from(e).about(marks))?;
    let job = session.context.start_point_track(&clip, &points, false)?;
    watch(&job, &session.interrupt)?;
    let motion = job.take_motion()?;
    let report = finish(session, args, &motion, &motion.point_report(&points)?)?;
    if let Some(report) = report {
        say_tracks(args, &motion, "points")?;
        next_key(&report).inspect(|line| say::line(line));
    }
    Ok(())
}

/// Writes the motion, and says the report where it was asked for; else gives it back.
fn finish(session: &Session, args: &Track, motion: &Motion, engine: &str) -> Result<Option<Value>, Failure> {
    session.interrupt.check()?;
    motion.write(utf8(&args.output)?)?;
    let report = session.report("track", engine, &args.output)?;
    if session.json {
        say::line(&report.to_string());
        return Ok(None);
    }
    Ok(Some(report))
}

fn say_tracks(args: &Track, motion: &Motion, what: &str) -> Result<(), Failure> {
    let info = motion.info()?;
    say::line(&format!("{}: {} {what} over {} frames", args.output.display(), info.tracks.len(), info.frames));
    Ok(())
}

/// The mark that would help most, for a person.
fn next_mark(report: &Value) -> Option<String> {
    let best = report.get("correct_next")?.get(0)?;
    let (joint, frame) = (best.get("joint")?.as_str()?, best.get("frame")?.as_u64()?);
    Some(format!("least certain: `{joint}` on frame {frame}; a rectangle there helps most"))
}

/// The key that would help most, for a person.
fn next_key(report: &Value) -> Option<String> {
    let best = report.get("correct_next")?.get(0)?;
    let (point, frame) = (best.get("point")?.as_str()?, best.get("frame")?.as_u64()?);
    Some(format!("least certain: `{point}` on frame {frame}; a key there helps most"))
}
