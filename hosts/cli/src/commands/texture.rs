//! `marey texture CREATURE (--clip CLIP | --like CREATURE | ...) -o OUT.glb`

use std::path::Path;

use marey_binding::{Creature, Texture, TextureOptions};
use serde_json::json;

use super::{Session, check_file, masks_of, utf8};
use crate::args::surface;
use crate::failure::{BAD_INPUT, Failure};
use crate::say;
use crate::watch::watch;

pub(crate) fn texture(session: &Session, args: &surface::Texture) -> Result<(), Failure> {
    args.output.as_deref().map(check_file).transpose()?;
    let creature = session.context.open_creature(utf8(&args.creature)?)?;
    session.interrupt.check()?;
    let dressed = dressed(session, args, &creature)?;
    let dressed = dressed.as_ref().unwrap_or(&creature);
    session.interrupt.check()?;
    if let Some(folder) = &args.pictures {
        dressed.write_textures(utf8(folder)?)?;
    }
    if let Some(path) = &args.output {
        dressed.write_glb(utf8(path)?, 0.0)?;
    }
    let parts = dressed.info()?.parts;
    let files: Vec<&Path> = [&args.output, &args.pictures].into_iter().flatten().map(|p| p.as_path()).collect();
    if session.json {
        let report = json!({ "parts": parts, "files": files }).to_string();
        say::line(&session.report("texture", &report, files[0])?.to_string());
    } else {
        let files: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
        say::line(&format!("{}: textures of {parts} parts, in {:.1} s", files.join(" and "), session.seconds()));
    }
    Ok(())
}

/// The creature with what it is to wear; none where it only shows what it wears.
fn dressed(session: &Session, args: &surface::Texture, creature: &Creature) -> Result<Option<Creature>, Failure> {
    if let Some(folder) = &args.painted {
        return Ok(Some(creature.with_textures(utf8(folder)?)?));
    }
    let limbs: Vec<&str> = args.limbs.iter().map(String::as_str).collect();
    let region = args.region.as_deref().map(utf8).transpose()?.unwrap_or_default();
    let options = TextureOptions { limbs: &limbs, region, soft: args.soft };
    let start = |texture: &Texture<'_>| -> Result<Option<Creature>, Failure> {
        let job = session.context.start_texture(creature, texture, &options)?;
        watch(&job, &session.interrupt)?;
        Ok(Some(job.take_creature()?))
    };
    if let Some(path) = &args.clip {
        let clip = session.open_clip(path)?;
        let masks = masks_of(session, args.masks.as_deref(), &args.creature)?.ok_or_else(|| {
            let path = args.creature.display();
            Failure::new(BAD_INPUT, format!("{path}: has no masks beside it; give their folder with --masks"))
        })?;
        return start(&Texture::Frames { clip: &clip, masks: &masks, frames: args.frames.clone() });
    }
    if let Some(path) = &args.like {
        let like = session.context.open_creature(utf8(path)?)?;
        return start(&Texture::Creature(&like));
    }
    if let Some(path) = &args.side {
        return start(&Texture::Side(utf8(path)?));
    }
    if let Some(path) = &args.material {
        return start(&Texture::Repeated { picture: utf8(path)?, width: args.width });
    }
    Ok(None)
}
