//! `marey pose CREATURE (--poses POSES.json | --motion MOTION) -o OUT.glb`

use marey_binding::{Creature, ReposeOptions};
use serde_json::{Value, json};

use super::character::{parsed, read_motion};
use super::{Session, check_file, text_of, utf8};
use crate::args::{self, Angles, Lengths};
use crate::failure::{BAD_USE, FAILED, Failure};
use crate::say;

pub(crate) fn pose(session: &Session, args: &args::Pose) -> Result<(), Failure> {
    check_file(&args.output)?;
    args.keep_map.as_deref().map(check_file).transpose()?;
    let map = text_of(args.map.as_deref(), "marey-limb-map")?;
    let options = ReposeOptions {
        keep_lengths: args.lengths.map(|lengths| lengths == Lengths::Kept),
        stretch: args.stretch,
        root_scale: args.root_scale,
        mirror: args.mirror,
        absolute: args.angles.map(|angles| angles == Angles::Absolute),
        frames: args.frames.unwrap_or(0),
        map: &map,
    };
    let creature = session.context.open_creature(utf8(&args.creature)?)?;
    session.interrupt.check()?;
    let mut followed = Value::Null;
    let posed = match (&args.poses, &args.motion) {
        (Some(poses), _) => creature
            .repose(&with_rate(&text_of(Some(poses), "marey-strokes")?, args.fps), &options)
            .map_err(|e| Failure::from(e).about(poses))?,
        (None, Some(path)) => {
            let motion = read_motion(session, path, args.view)?;
            followed = parsed(&creature.matched(&motion, &map)?)?;
            creature.drive(&motion, &options)?
        }
        (None, None) => return Err(Failure::new(BAD_USE, "give --poses or --motion; `marey --help` shows how")),
    };
    session.interrupt.check()?;
    posed.write_glb(utf8(&args.output)?, 0.0)?;
    if let Some(path) = &args.keep_map {
        std::fs::write(path, format!("{followed:#}\n"))
            .map_err(|e| Failure::new(FAILED, format!("{}: cannot write: {e}", path.display())))?;
    }
    say_of(session, args, &posed, &followed)
}

fn say_of(session: &Session, args: &args::Pose, posed: &Creature, followed: &Value) -> Result<(), Failure> {
    let info = posed.info()?;
    let strain = parsed(&posed.strain()?)?;
    if session.json {
        let report = json!({
            "frames": info.frames,
            "strain": strain,
            "followed": followed,
            "files": std::iter::once(&args.output).chain(&args.keep_map).collect::<Vec<_>>(),
        });
        say::line(&session.report("pose", &report.to_string(), &args.output)?.to_string());
        return Ok(());
    }
    let limbs = strain.as_array().map_or(0, Vec::len);
    let most = |of: &str| {
        let values = strain.as_array().into_iter().flatten().filter_map(|limb| limb[of].as_f64());
        values.fold(0.0, f64::max)
    };
    say::line(&format!(
        "{}: {} frames of {limbs} limbs; stretched {:.2} times at most, in {:.1} s",
        args.output.display(),
        info.frames,
        most("longest"),
        session.seconds()
    ));
    Ok(())
}

/// The poses with another rate; what is no JSON is left for the library to say.
fn with_rate(poses: &str, fps: Option<f64>) -> String {
    match (serde_json::from_str::<Value>(poses), fps) {
        (Ok(Value::Object(mut file)), Some(fps)) => {
            file.insert("fps".into(), json!(fps));
            Value::Object(file).to_string()
        }
        _ => poses.to_owned(),
    }
}
