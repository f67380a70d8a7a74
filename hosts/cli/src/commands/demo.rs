//! `marey demo`: the whole job on the bundled camel, with its inputs beside the results, so that a stroke can be moved
//! and the job run again.

use std::path::Path;

use marey_binding::CreatureOptions;

use super::{Session, utf8};
use crate::args::Demo;
use crate::failure::{FAILED, Failure};
use crate::say;
use crate::watch::watch;

const CLIP: &[u8] = include_bytes!("../../../../data/camel/clip.mp4");
const STROKES: &str = include_str!("../../../../data/camel/strokes.json");

pub(crate) fn demo(session: &Session, args: &Demo) -> Result<(), Failure> {
    let folder = &args.output;
    // The inputs come into the folder last: a demo that is cancelled leaves nothing.
    let inputs = tempfile::tempdir().map_err(|e| failed(folder, &e))?;
    let clip_file = inputs.path().join("clip.mp4");
    std::fs::write(&clip_file, CLIP).map_err(|e| failed(&clip_file, &e))?;
    let clip = session.context.open_clip(utf8(&clip_file)?)?;
    let rig = session.context.rig_from_json(STROKES)?;
    let options = CreatureOptions { folder: utf8(folder)?, ..CreatureOptions::default() };
    let job = session.context.start_creature(&clip, &rig, &options)?;
    watch(&job, &session.interrupt)?;
    let creature = job.take_creature()?;
    for (name, bytes) in [("clip.mp4", CLIP), ("strokes.json", STROKES.as_bytes())] {
        let path = folder.join(name);
        // A person's own strokes from an earlier run stay.
        if path.exists() {
            continue;
        }
        std::fs::write(&path, bytes).map_err(|e| failed(&path, &e))?;
    }
    if session.json {
        say::line(&session.report("demo", &creature.report()?, folder)?.to_string());
        return Ok(());
    }
    let shown = folder.display();
    say::text(&format!(
        "\
{shown}/preview.gif   the creature, from the clip's view and from another: open it first
{shown}/overlay.gif   what was understood: the clip with limbs and mask
{shown}/creature.glb  open in Blender (File, Import, glTF 2.0) and press play
{shown}/report.json   seconds, counts, and which stroke to draw next
then move a stroke in {shown}/strokes.json: marey creature {shown}/clip.mp4 --strokes {shown}/strokes.json -o {shown}
"
    ));
    Ok(())
}

fn failed(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(FAILED, format!("{}: cannot write: {error}", path.display()))
}
