//! `marey motion ...`: what can be made of a motion.

use marey_binding::{LimbMapOptions, LoopOptions, Motion, PlantOptions, RetimeOptions};
use serde_json::{Value, json};

use super::character::{parsed, read_motion, write_motion};
use super::{Session, check_file, text_of};
use crate::args::Angles;
use crate::args::motion::{Cycle, Easing, Loop, Map, MotionCommand, Plant, Retime, Smooth, Through};
use crate::failure::{BAD_USE, FAILED, Failure};
use crate::say;

pub(crate) fn motion(session: &Session, command: &MotionCommand) -> Result<(), Failure> {
    match command {
        MotionCommand::Cycle(args) => cycle(session, args),
        MotionCommand::Loop(args) => closed(session, args),
        MotionCommand::Smooth(args) => smooth(session, args),
        MotionCommand::Plant(args) => plant(session, args),
        MotionCommand::Retime(args) => retime(session, args),
        MotionCommand::Map(args) => map(session, args),
    }
}

/// Reads the motion, makes another of it, writes that, and says so with what there is to say beside.
fn through(
    session: &Session,
    command: &str,
    through: &Through,
    make: impl FnOnce(&Motion) -> Result<(Motion, Value, String), Failure>,
) -> Result<(), Failure> {
    check_file(&through.output)?;
    let motion = read_motion(session, &through.motion, through.view)?;
    let (made, mut report, said) = make(&motion)?;
    session.interrupt.check()?;
    write_motion(&made, &through.output)?;
    let info = made.info()?;
    if session.json {
        (report["frames"], report["fps"]) = (json!(info.frames), json!(info.fps));
        say::line(&session.report(command, &report.to_string(), &through.output)?.to_string());
        return Ok(());
    }
    say::line(&format!("{}: {} frames at {:.3} a second{said}", through.output.display(), info.frames, info.fps));
    Ok(())
}

fn cycle(session: &Session, args: &Cycle) -> Result<(), Failure> {
    let motion = read_motion(session, &args.motion, args.view)?;
    let (cycle, info) = (motion.cycle()?, motion.info()?);
    if session.json {
        let limb =
            |(track, (phase, swing)): (&String, &(f64, f64))| json!({ "track": track, "phase": phase, "swing": swing });
        let report = json!({
            "period": cycle.period,
            "start": cycle.start,
            "confidence": cycle.confidence,
            "limbs": info.tracks.iter().zip(&cycle.phases).map(limb).collect::<Vec<_>>(),
        });
        say::line(&session.report("motion cycle", &report.to_string(), &args.motion)?.to_string());
        return Ok(());
    }
    say::line(&format!(
        "{}: a cycle of {:.2} frames, best from frame {:.0}, confidence {:.2}",
        args.motion.display(),
        cycle.period,
        cycle.start,
        cycle.confidence
    ));
    for (track, (phase, swing)) in info.tracks.iter().zip(&cycle.phases) {
        say::line(&format!("  {track}: foremost at {:.0} % of it, swings {swing:.1} pixels", 100.0 * phase));
    }
    Ok(())
}

fn closed(session: &Session, args: &Loop) -> Result<(), Failure> {
    let options = LoopOptions {
        range: args.period.map(|period| (args.start.unwrap_or(0.0), period)),
        cycles: args.cycles,
        keep_travel: args.keep_travel,
        frames: args.frames,
        fps: args.fps,
        fade: args.fade,
    };
    through(session, "motion loop", &args.through, |motion| {
        let (made, seam) = motion.closed(&options)?;
        let report = json!({
            "start": seam.start,
            "period": seam.period,
            "travel": seam.travel,
            "seam": {
                "pose": seam.pose.0, "pose_most": seam.pose.1, "speed": seam.speed.0, "speed_most": seam.speed.1,
                "usual_step": seam.usual.0, "usual_change": seam.usual.1,
            },
        });
        let said = format!(
            ", {:.2} frames from {:.0}; at the seam pose is off by {:.2} % of the figure and speed by {:.2} %",
            seam.period,
            seam.start,
            100.0 * seam.pose.0,
            100.0 * seam.speed.0
        );
        Ok((made, report, said))
    })
}

fn smooth(session: &Session, args: &Smooth) -> Result<(), Failure> {
    let held = if args.hold_none { Some(&[][..]) } else { args.hold.as_deref() };
    through(session, "motion smooth", &args.through, |motion| {
        Ok((motion.smooth(args.period, held)?, json!({}), String::new()))
    })
}

fn plant(session: &Session, args: &Plant) -> Result<(), Failure> {
    let options =
        PlantOptions { feet: &args.feet, ground: args.ground, still: args.still, ease: args.ease, closed: args.closed };
    through(session, "motion plant", &args.through, |motion| {
        let made = motion.planted(&options)?;
        let report = parsed(&motion.contacts(&options)?)?;
        let mut said = String::new();
        for foot in report["feet"].as_array().into_iter().flatten() {
            let slide = |i: usize| foot["slide"][i].as_f64().unwrap_or_default();
            let down = foot["spans"].as_array().map_or(0, Vec::len);
            let name = foot["track"].as_str().unwrap_or_default();
            let (before, after) = (slide(0), slide(1));
            said += &format!("\n  {name}: down {down} times, slid {before:.2} pixels a frame, now {after:.2}");
        }
        Ok((made, report, said))
    })
}

/// AT=FRAME or AT=FRAME:EASING.
fn time_key(text: &str) -> Result<(f64, f64, i32), Failure> {
    let wrong =
        || Failure::new(BAD_USE, format!("--key {text}: expected AT=FRAME or AT=FRAME:EASING, such as 24=30:in-out"));
    let (at, rest) = text.split_once('=').ok_or_else(wrong)?;
    let (frame, easing) = rest.split_once(':').unwrap_or((rest, "linear"));
    let easing = <Easing as clap::ValueEnum>::from_str(easing, false).map_err(|_| wrong())?;
    Ok((at.trim().parse().map_err(|_| wrong())?, frame.trim().parse().map_err(|_| wrong())?, easing as i32))
}

fn retime(session: &Session, args: &Retime) -> Result<(), Failure> {
    let keys: Vec<(f64, f64, i32)> = args.key.iter().map(|k| time_key(k)).collect::<Result<_, _>>()?;
    // Zero would stand for the default.
    for (value, what) in [(args.speed, "--speed"), (f64::from(args.hold), "--hold")] {
        if value == 0.0 {
            return Err(Failure::new(BAD_USE, format!("{what} is 0; give one above 0")));
        }
    }
    let options = RetimeOptions {
        direction: if args.backward { 1 } else { 2 * i32::from(args.there_and_back) },
        speed: args.speed,
        seconds: args.seconds,
        fps: args.fps,
        easing: args.easing as i32,
        hold: args.hold,
        closed: args.closed,
        smooth: args.smooth,
        keys: &keys,
    };
    through(session, "motion retime", &args.through, |motion| Ok((motion.retimed(&options)?, json!({}), String::new())))
}

fn map(session: &Session, args: &Map) -> Result<(), Failure> {
    args.keep_map.as_deref().map(check_file).transpose()?;
    let creature = read_motion(session, &args.onto, args.through.view)?;
    let given = text_of(args.map.as_deref(), "marey-limb-map")?;
    let options = LimbMapOptions {
        absolute: args.angles == Angles::Absolute,
        mirror: args.mirror,
        reference: args.reference,
        rest: args.rest,
        stretch: args.stretch,
        travel: args.travel,
        map: &given,
    };
    through(session, "motion map", &args.through, |motion| {
        let made = motion.on_limbs(&creature, &options)?;
        let map = parsed(&motion.limb_map(&creature, &options)?)?;
        if let Some(path) = &args.keep_map {
            std::fs::write(path, format!("{map:#}\n"))
                .map_err(|e| Failure::new(FAILED, format!("{}: cannot write: {e}", path.display())))?;
        }
        let mut said = String::new();
        for (limb, source) in map["limbs"].as_object().into_iter().flatten() {
            let tracks: Vec<&str> =
                source["tracks"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
            said += &format!("\n  {limb} follows {}", tracks.join(", "));
        }
        Ok((made, json!({ "map": map }), said))
    })
}
