//! `marey bind` and `marey sketch`: a vector drawing, what holds it, and the drawing in motion.

use std::path::{Path, PathBuf};

use marey_binding::{BindOptions, Binding, Drawing, Motion, MotionUse, SketchFileOptions};
use serde_json::{Value, json};

use super::character::{colour, parsed};
use super::{Session, check_file, utf8};
use crate::args::{self, Laying};
use crate::failure::{BAD_INPUT, BAD_USE, Failure};
use crate::say;
use crate::watch::watch;

pub(crate) fn bind(session: &Session, args: &args::Bind) -> Result<(), Failure> {
    check_file(&args.output)?;
    args.preview.as_deref().map(check_file).transpose()?;
    let drawing = drawing(session, &args.drawing)?;
    let motion = session.context.read_motion(utf8(&args.motion)?)?;
    let (binding, mut report) = laid(session, &drawing, &motion, &args.motion, &args.laying)?;
    binding.write(utf8(&args.output)?)?;
    let mut files = vec![args.output.clone()];
    if let Some(preview) = &args.preview {
        let clip = args.laying.clip.as_deref().map(|path| session.open_clip(path)).transpose()?;
        binding.write_preview(&drawing, &motion, clip.as_ref(), utf8(preview)?)?;
        files.push(preview.clone());
    }
    report["files"] = json!(files);
    if session.json {
        say::line(&session.report("bind", &report.to_string(), &args.output)?.to_string());
        return Ok(());
    }
    warn(&report);
    say::line(&format!("{}: {} points hold the drawing", args.output.display(), binding.info()?.points));
    Ok(())
}

pub(crate) fn sketch(session: &Session, args: &args::Sketch) -> Result<(), Failure> {
    let background = colour(&args.background)?;
    args.keep_bind.as_deref().map(check_file).transpose()?;
    let read = |path: &PathBuf| -> Result<Motion, Failure> { Ok(session.context.read_motion(utf8(path)?)?) };
    let motions: Vec<Motion> = args.motion.iter().map(read).collect::<Result<_, _>>()?;
    let [first, ..] = &motions[..] else { return Err(Failure::new(BAD_USE, "give a --motion")) };
    if motions.len() > 1 && args.bind.is_none() {
        return Err(Failure::new(BAD_USE, "several motions need --bind, which says which point is whose"));
    }
    if args.drawings.len() > 1 && (args.bind.is_some() || args.keep_bind.is_some()) {
        return Err(Failure::new(BAD_USE, "a binding is of one drawing; give one"));
    }
    let mut made = Vec::new();
    for path in &args.drawings {
        let drawing = drawing(session, path)?;
        let (binding, report) = match &args.bind {
            Some(bind) => {
                let binding = session.context.read_binding(utf8(bind)?)?;
                adjust(&binding, &drawing, &args.laying)?;
                binding.validate(&drawing).map_err(|e| Failure::from(e).about(bind))?;
                (binding, json!({ "warnings": [] }))
            }
            None => laid(session, &drawing, first, &args.motion[0], &args.laying)?,
        };
        let output = output_for(path, args)?;
        let all: Vec<&Motion> = motions.iter().collect();
        let moving = session.context.start_sketch_take(&drawing, &binding, &all)?;
        watch(&moving, &session.interrupt)?;
        let take = moving.take_sketch_take()?;
        let mut report = joined(report, &parsed(&moving.report()?)?);
        let file = SketchFileOptions {
            path: utf8(&output)?,
            format: args.format.as_deref().unwrap_or_default(),
            name: "",
            crop: args.no_grow,
            scale: args.scale,
            background,
        };
        let writing = session.context.start_sketch_file(&take, &file)?;
        watch(&writing, &session.interrupt)?;
        let written = parsed(&writing.report()?)?;
        let mut files: Vec<Value> = written["files"].as_array().cloned().unwrap_or_default();
        if let Some(keep) = &args.keep_bind {
            binding.write(utf8(keep)?)?;
            files.push(json!(keep));
        }
        report["files"] = json!(files);
        report["drawing"] = json!(path);
        report["timings"]["writing"] = written["timings"]["writing"].clone();
        if !session.json {
            warn(&report);
            let (frames, fps) = take.frames()?;
            say::line(&format!("{}: {frames} frames at {fps:.3} a second", output.display()));
        }
        made.push(report);
    }
    if session.json {
        let report = if let [one] = &made[..] { one.clone() } else { json!({ "sketches": made }) };
        say::line(&session.report("sketch", &report.to_string(), &args.output)?.to_string());
    }
    Ok(())
}

/// Where a drawing's sketch is written: the output, or in it where there are several.
fn output_for(drawing: &Path, args: &args::Sketch) -> Result<PathBuf, Failure> {
    if args.drawings.len() == 1 {
        return Ok(args.output.clone());
    }
    let stem = drawing.file_stem().unwrap_or_default().to_string_lossy();
    let ending = match args.format.as_deref() {
        None => {
            return Err(Failure::new(
                BAD_USE,
                "several drawings need --format: svg, lottie, gif, apng, webp, mp4, mp4-alpha, png-dir or sprite-sheet",
            ));
        }
        Some("lottie") => ".json",
        Some("png-dir" | "sprite-sheet") => "",
        Some("apng") => ".png",
        Some("mp4-alpha") => ".mp4",
        Some(other) => &format!(".{other}"),
    };
    std::fs::create_dir_all(&args.output)
        .map_err(|e| Failure::new(BAD_INPUT, format!("{}: is no folder to write into: {e}", args.output.display())))?;
    Ok(args.output.join(format!("{stem}{ending}")))
}

fn drawing(session: &Session, path: &Path) -> Result<Drawing, Failure> {
    let drawing = session.context.read_svg(utf8(path)?)?;
    for left_out in drawing.info()?.left_out {
        say::warning(&format!("{}: {left_out}", path.display()));
    }
    Ok(drawing)
}

/// Lays a motion on a drawing, as the arguments ask.
fn laid(
    session: &Session,
    drawing: &Drawing,
    motion: &Motion,
    file: &Path,
    laying: &Laying,
) -> Result<(Binding, Value), Failure> {
    let clip = laying.clip.as_deref().map(|path| session.open_clip(path)).transpose()?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    if laying.as_drawn {
        let binding = as_drawn(session, drawing, motion, &name)?;
        finish(&binding, drawing, laying)?;
        return Ok((binding, json!({ "warnings": [] })));
    }
    let options = BindOptions {
        name: &name,
        clip: clip.as_ref(),
        frame: laying.frame,
        mirror: laying.mirror,
        ..BindOptions::default()
    };
    let job = session.context.start_bind(drawing, motion, &options)?;
    watch(&job, &session.interrupt)?;
    let (binding, report) = (job.take_binding()?, parsed(&job.report()?)?);
    finish(&binding, drawing, laying)?;
    Ok((binding, report))
}

/// Holds a drawing where the motion's points are.
fn as_drawn(session: &Session, drawing: &Drawing, motion: &Motion, name: &str) -> Result<Binding, Failure> {
    let binding = session.context.new_binding(drawing)?;
    let plain =
        MotionUse { name: name.into(), scale: 1.0, rotation: 0.0, mirror: false, frame: 0, travel: 1.0, repeat: true };
    binding.set_motion(&plain)?;
    for (track, number) in motion.info()?.tracks.iter().zip(0..) {
        for (at, index) in motion.frame(number, 0)?.points.into_iter().zip(0..) {
            binding.set_point("", track, index, at, "")?;
        }
    }
    Ok(binding)
}

/// What the arguments say, and joints where they make layers.
fn finish(binding: &Binding, drawing: &Drawing, laying: &Laying) -> Result<(), Failure> {
    adjust(binding, drawing, laying)?;
    if !laying.layer.is_empty() {
        binding.propose_joints(drawing)?;
    }
    Ok(binding.validate(drawing)?)
}

/// What the arguments say of motions, strokes, pins and layers.
fn adjust(binding: &Binding, drawing: &Drawing, laying: &Laying) -> Result<(), Failure> {
    if binding.info()?.motions > 0 {
        let mut how = binding.motion(0)?;
        how.scale *= laying.motion_scale;
        how.rotation = laying.motion_rotation.unwrap_or(how.rotation);
        how.travel = laying.travel.unwrap_or(how.travel);
        binding.set_motion(&how)?;
    }
    for text in &laying.rigidity {
        let (stroke, rigidity) = pair(text, "--rigidity", "STROKE=R")?;
        let wrong = || Failure::new(BAD_USE, format!("--rigidity {text}: `{rigidity}` is no number"));
        binding.set_stroke(stroke, rigidity.parse().map_err(|_| wrong())?, binding.stroke(stroke)?.1)?;
    }
    for stroke in &laying.decoration {
        binding.set_stroke(stroke, binding.stroke(stroke)?.0, true)?;
    }
    for text in &laying.pin {
        let numbers: Option<Vec<f32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y]) => binding.add_pin((x, y), "")?,
            _ => return Err(Failure::new(BAD_USE, format!("--pin {text}: give X,Y in pixels of the drawing"))),
        }
    }
    for text in &laying.layer {
        let (layer, strokes) = pair(text, "--layer", "NAME=STROKE,...")?;
        let strokes: Vec<&str> = strokes.split(',').collect();
        binding.set_layer(drawing, layer, &strokes)?;
    }
    Ok(())
}

fn pair<'a>(text: &'a str, option: &str, shape: &str) -> Result<(&'a str, &'a str), Failure> {
    text.split_once('=').ok_or_else(|| Failure::new(BAD_USE, format!("{option} {text}: give {shape}")))
}

/// Two reports in one; warnings of both.
fn joined(mut report: Value, other: &Value) -> Value {
    let warnings = |of: &Value| of["warnings"].as_array().cloned().unwrap_or_default();
    let all: Vec<Value> = warnings(&report).into_iter().chain(warnings(other)).collect();
    for (key, value) in other.as_object().into_iter().flatten() {
        report[key] = value.clone();
    }
    report["warnings"] = json!(all);
    report
}

fn warn(report: &Value) {
    report["warnings"].as_array().into_iter().flatten().filter_map(Value::as_str).for_each(say::warning);
}
