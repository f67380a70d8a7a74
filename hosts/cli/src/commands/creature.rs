//! `marey creature CLIP --strokes S.json -o DIR`

use marey_binding::{CreatureOptions, CreatureSurface};

use super::{Session, next_stroke, utf8};
use crate::args::{Creature, Surface};
use crate::failure::Failure;
use crate::say;
use crate::watch::watch;

pub(crate) fn creature(session: &Session, args: &Creature) -> Result<(), Failure> {
    session.plugins_for(&args.drawn.plugins, &[&args.drawn.tracker, &args.segmenter])?;
    let (clip, rig) = session.open(&args.drawn.clip, &args.drawn.strokes)?;
    let options = CreatureOptions {
        tracker: &args.drawn.tracker,
        segmenter: &args.segmenter,
        folder: utf8(&args.output)?,
        write_obj: args.obj,
        depths: &args.depth.join(","),
        spread: args.spread,
        surface: match args.surface {
            Surface::Skin => CreatureSurface::Skin,
            Surface::Tubes => CreatureSurface::Tubes,
        },
    };
    let job = session.context.start_creature(&clip, &rig, &options)?;
    watch(&job, &session.interrupt)?;
    let creature = job.take_creature()?;
    let report = session.report("creature", &creature.report()?, &args.output)?;
    if session.json {
        say::line(&report.to_string());
        return Ok(());
    }
    let info = creature.info()?;
    say::line(&format!(
        "{}: {} bones, {} triangles, {} frames, in {:.1} s",
        args.output.join("creature.glb").display(),
        info.bones,
        info.triangles,
        info.frames,
        session.seconds()
    ));
    next_stroke(&report).inspect(|line| say::line(line));
    Ok(())
}
