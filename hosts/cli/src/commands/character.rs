//! `marey rig`, `marey character` and `marey retarget`: a drawing, its skeleton, and what moves it.

use std::path::Path;

use marey_binding::{Area, Character, CharacterOptions, Motion, RetargetOptions, TakeFileOptions, TakeOptions};
use serde_json::{Value, json};

use super::{Session, check_file, text_of, utf8};
use crate::args::{self, Carry};
use crate::failure::{BAD_USE, FAILED, Failure};
use crate::say;
use crate::watch::watch;

pub(crate) fn rig(session: &Session, args: &args::Rig) -> Result<(), Failure> {
    check_file(&args.output)?;
    args.preview.as_deref().map(check_file).transpose()?;
    let options = CharacterOptions {
        picture: utf8(&args.picture)?,
        mask: optional(args.mask.as_deref())?,
        vertices: args.vertices,
        finer_at_joints: args.finer_at_joints,
        ..CharacterOptions::default()
    };
    let character = made(session, &options)?;
    session.interrupt.check()?;
    if let Some(preview) = &args.preview {
        character.write_preview(utf8(preview)?)?;
    }
    character.write(utf8(&args.output)?)?;
    let info = character.info()?;
    if session.json {
        let joints: Vec<Value> =
            character.joints()?.into_iter().map(|(name, at)| json!({ "name": name, "at": at })).collect();
        let report = json!({
            "character": parts(&character)?,
            "joints": joints,
            "bones": character.bones()?,
            "files": std::iter::once(&args.output).chain(&args.preview).collect::<Vec<_>>(),
            "warnings": [],
        });
        say::line(&session.report("rig", &report.to_string(), &args.output)?.to_string());
        return Ok(());
    }
    say::line(&format!(
        "{}: {} joints, {} bones, {} vertices, {} triangles",
        args.output.display(),
        info.joints,
        info.bones,
        info.vertices,
        info.triangles
    ));
    Ok(())
}

pub(crate) fn character(session: &Session, args: &args::Character) -> Result<(), Failure> {
    let output = utf8(&args.output)?;
    args.keep_motion.as_deref().map(check_file).transpose()?;
    args.carry.keep_map.as_deref().map(check_file).transpose()?;
    session.plugins_for(&args.plugins, &[&args.deformer])?;
    let background = colour(&args.background)?;
    let options = CharacterOptions {
        picture: utf8(&args.picture)?,
        mask: optional(args.mask.as_deref())?,
        rig: utf8(&args.rig)?,
        ..CharacterOptions::default()
    };
    let character = made(session, &options)?;
    let map = text_of(args.carry.map.as_deref(), "marey-map")?;
    let take = TakeOptions {
        deformer: &args.deformer,
        area: match args.area {
            args::Area::Exact => Area::Exact,
            args::Area::Reciprocal => Area::Reciprocal,
            args::Area::Off => Area::Off,
        },
        retarget: carrying(&args.carry, &map),
    };
    let mut motion = None;
    let job = match (&args.poses, &args.motion) {
        (Some(poses), _) => {
            let poses = character.read_poses(utf8(poses)?)?;
            session.context.start_take_of_poses(&poses, &take)?
        }
        (None, Some(path)) => {
            let read = read_motion(session, path, args.carry.view)?;
            let job = session.context.start_take_of_motion(&character, &read, &take)?;
            motion = Some(read);
            job
        }
        (None, None) => return Err(Failure::new(BAD_USE, "give --poses or --motion; `marey --help` shows how")),
    };
    watch(&job, &session.interrupt)?;
    let played = job.take_take()?;
    let file = TakeFileOptions {
        path: output,
        format: args.format.as_deref().unwrap_or_default(),
        name: "",
        crop: args.no_grow,
        scale: args.scale,
        background,
    };
    let writing = session.context.start_take_file(&played, &file)?;
    watch(&writing, &session.interrupt)?;
    let mut report: Value = parsed(&played.report()?)?;
    let written = parsed(&writing.report()?)?;
    let mut files: Vec<Value> = written["files"].as_array().cloned().unwrap_or_default();
    if let Some(motion) = &motion {
        if let Some(path) = &args.keep_motion {
            write_motion(&motion.retarget(&character, &take.retarget)?, path)?;
            files.push(json!(path));
        }
        if let Some(path) = &args.carry.keep_map {
            keep_map(motion, &character, &take.retarget, path)?;
            files.push(json!(path));
        }
    }
    report["files"] = json!(files);
    report["shown"] = written["shown"].clone();
    report["timings"]["writing"] = written["timings"]["writing"].clone();
    if session.json {
        say::line(&session.report("character", &report.to_string(), &args.output)?.to_string());
        return Ok(());
    }
    warn(&report);
    let (frames, fps) = played.frames()?;
    say::line(&format!("{output}: {frames} frames at {fps:.3} a second, in {:.1} s", session.seconds()));
    Ok(())
}

pub(crate) fn retarget(session: &Session, args: &args::Retarget) -> Result<(), Failure> {
    check_file(&args.output)?;
    args.carry.keep_map.as_deref().map(check_file).transpose()?;
    let character = made(session, &CharacterOptions { rig: utf8(&args.rig)?, ..CharacterOptions::default() })?;
    let map = text_of(args.carry.map.as_deref(), "marey-map")?;
    let options = carrying(&args.carry, &map);
    let motion = read_motion(session, &args.motion, args.carry.view)?;
    let carried = motion.retarget(&character, &options)?;
    session.interrupt.check()?;
    write_motion(&carried, &args.output)?;
    let followed = parsed(&motion.matched(&character, &options)?)?;
    if let Some(path) = &args.carry.keep_map {
        keep_map(&motion, &character, &options, path)?;
    }
    let info = carried.info()?;
    if session.json {
        let report = json!({
            "character": parts(&character)?,
            "frames": info.frames,
            "fps": info.fps,
            "followed": { "map": followed },
            "files": std::iter::once(&args.output).chain(&args.carry.keep_map).collect::<Vec<_>>(),
        });
        say::line(&session.report("retarget", &report.to_string(), &args.output)?.to_string());
        return Ok(());
    }
    let joints = followed["joints"].as_object().map_or(0, serde_json::Map::len);
    say::line(&format!(
        "{}: {} frames; {joints} of {} joints follow the motion",
        args.output.display(),
        info.frames,
        info.tracks.len()
    ));
    Ok(())
}

fn made(session: &Session, options: &CharacterOptions<'_>) -> Result<Character, Failure> {
    let job = session.context.start_character(options)?;
    watch(&job, &session.interrupt)?;
    Ok(job.take_character()?)
}

fn parts(character: &Character) -> Result<Value, Failure> {
    let info = character.info()?;
    Ok(json!({
        "size": info.size,
        "vertices": info.vertices,
        "triangles": info.triangles,
        "joints": info.joints,
        "bones": info.bones,
    }))
}

pub(super) fn parsed(text: &str) -> Result<Value, Failure> {
    serde_json::from_str(text).map_err(|e| Failure::new(FAILED, format!("report: {e}")))
}

fn warn(report: &Value) {
    let warnings = report["warnings"].as_array().into_iter().flatten().filter_map(Value::as_str);
    warnings.for_each(say::warning);
    if report["followed"]["made_from"] == "likeness" {
        say::warning("no names match: joints follow what lies alike; --keep-map writes the map, to correct it");
    }
}

fn optional(path: Option<&Path>) -> Result<&str, Failure> {
    path.map_or(Ok(""), utf8)
}

fn is_bvh(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("bvh"))
}

pub(super) fn read_motion(session: &Session, path: &Path, view: args::View) -> Result<Motion, Failure> {
    if is_bvh(path) {
        return Ok(session.context.read_bvh(utf8(path)?, view as i32)?);
    }
    Ok(session.context.read_motion(utf8(path)?)?)
}

pub(super) fn write_motion(motion: &Motion, path: &Path) -> Result<(), Failure> {
    if is_bvh(path) {
        motion.write_bvh(utf8(path)?)?;
    } else {
        motion.write(utf8(path)?)?;
    }
    Ok(())
}

fn carrying<'a>(carry: &'a Carry, map: &'a str) -> RetargetOptions<'a> {
    RetargetOptions {
        absolute: carry.angles == args::Angles::Absolute,
        reference: carry.reference,
        stretch: carry.stretch,
        root_scale: carry.root_scale,
        map,
        planted: &carry.planted,
    }
}

fn keep_map(motion: &Motion, character: &Character, options: &RetargetOptions<'_>, path: &Path) -> Result<(), Failure> {
    let map = parsed(&motion.matched(character, options)?)?;
    std::fs::write(path, format!("{map:#}\n"))
        .map_err(|e| Failure::new(FAILED, format!("{}: cannot write: {e}", path.display())))
}

/// Red, green, blue and alpha of `#rgb`, `#rrggbb`, `#rrggbbaa` or a name.
pub(super) fn colour(text: &str) -> Result<[u8; 4], Failure> {
    let wrong = || {
        let problem = "is no colour; give #rrggbb, #rrggbbaa, none, white or black";
        Failure::new(BAD_USE, format!("--background {text}: {problem}"))
    };
    let digits = match text {
        "none" | "transparent" => "00000000",
        "white" => "ffffff",
        "black" => "000000",
        other => other.strip_prefix('#').unwrap_or(other),
    };
    if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return Err(wrong());
    }
    let wide: String = match digits.len() {
        3 => digits.chars().flat_map(|c| [c, c]).chain("ff".chars()).collect(),
        6 => format!("{digits}ff"),
        8 => digits.to_owned(),
        _ => return Err(wrong()),
    };
    let number = u32::from_str_radix(&wide, 16).map_err(|_| wrong())?;
    Ok(number.to_be_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read_as_the_web_writes_them() {
        for (text, is) in [
            ("none", [0; 4]),
            ("#fff", [255; 4]),
            ("102030", [16, 32, 48, 255]),
            ("#10203040", [16, 32, 48, 64]),
            ("black", [0, 0, 0, 255]),
        ] {
            assert_eq!(colour(text).expect(text), is, "{text}");
        }
        for text in ["", "#12345", "#ggg", "pink-ish", "#é1é"] {
            assert_eq!(colour(text).expect_err(text).exit_code, BAD_USE);
        }
    }
}
