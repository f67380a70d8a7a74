//! `marey demo`: the whole job on the bundled camel, or on a bundled drawing, with its inputs beside the results, so that
//! a stroke, a pose or a point can be moved and the job run again.

use std::path::Path;

use marey_binding::{CharacterOptions, CreatureOptions, SketchFileOptions, TakeFileOptions, TakeOptions};

use super::{Session, utf8};
use crate::args::Demo;
use crate::failure::{FAILED, Failure};
use crate::say;
use crate::watch::watch;

const CLIP: &[u8] = include_bytes!("../../../../data/camel/clip.mp4");
const STROKES: &str = include_str!("../../../../data/camel/strokes.json");

const DRAWING: [(&str, &[u8]); 3] = [
    ("drawing.png", include_bytes!("../../../../data/characters/child/drawing.png")),
    ("rig.json", include_bytes!("../../../../data/characters/child/rig.json")),
    ("poses.json", include_bytes!("../../../../data/characters/child/poses.json")),
];

const SKETCH: [(&str, &[u8]); 4] = [
    ("gallop.webp", include_bytes!("../../../../data/animals/horse-gallop.webp")),
    ("points.json", include_bytes!("../../../../data/animals/horse-gallop.points.json")),
    ("drawing.svg", include_bytes!("../../../../data/drawings/horse.svg")),
    // As `marey bind` proposes it, and a person has corrected it: one hind leg is drawn, where the clip has two.
    ("bind.json", include_bytes!("../../../../data/drawings/horse.bind.json")),
];

pub(crate) fn demo(session: &Session, args: &Demo) -> Result<(), Failure> {
    // What one demo writes is read by the commands that it tells of: each has a folder of its own.
    let usual = match (args.character, args.sketch) {
        (true, _) => "marey-demo-character",
        (_, true) => "marey-demo-sketch",
        _ => "marey-demo",
    };
    let folder = args.output.as_deref().unwrap_or(Path::new(usual));
    if args.character {
        return drawing(session, folder);
    }
    if args.sketch {
        return sketch(session, folder);
    }
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

fn drawing(session: &Session, folder: &Path) -> Result<(), Failure> {
    // All is made aside: a demo that is cancelled leaves nothing.
    let aside = tempfile::tempdir().map_err(|e| failed(folder, &e))?;
    for (name, bytes) in DRAWING {
        let path = aside.path().join(name);
        std::fs::write(&path, bytes).map_err(|e| failed(&path, &e))?;
    }
    let [picture, rig, poses, gif] =
        ["drawing.png", "rig.json", "poses.json", "child.gif"].map(|n| aside.path().join(n));
    let options = CharacterOptions { picture: utf8(&picture)?, rig: utf8(&rig)?, ..CharacterOptions::default() };
    let job = session.context.start_character(&options)?;
    watch(&job, &session.interrupt)?;
    let character = job.take_character()?;
    let poses = character.read_poses(utf8(&poses)?)?;
    let job = session.context.start_take_of_poses(&poses, &TakeOptions::default())?;
    watch(&job, &session.interrupt)?;
    let take = job.take_take()?;
    let file = TakeFileOptions { path: utf8(&gif)?, background: [255; 4], ..TakeFileOptions::default() };
    watch(&session.context.start_take_file(&take, &file)?, &session.interrupt)?;
    std::fs::create_dir_all(folder).map_err(|e| failed(folder, &e))?;
    for name in ["drawing.png", "rig.json", "poses.json", "child.gif"] {
        let path = folder.join(name);
        // A person's own poses from an earlier run stay.
        if name != "child.gif" && path.exists() {
            continue;
        }
        std::fs::copy(aside.path().join(name), &path).map_err(|e| failed(&path, &e))?;
    }
    if session.json {
        say::line(&session.report("demo", &take.report()?, folder)?.to_string());
        return Ok(());
    }
    let shown = folder.display();
    say::text(&format!(
        "\
{shown}/child.gif     a drawing that walks and waves: open it first
then move a joint in {shown}/poses.json:
  marey character {shown}/drawing.png --rig {shown}/rig.json --poses {shown}/poses.json -o {shown}/child.gif
"
    ));
    Ok(())
}

fn sketch(session: &Session, folder: &Path) -> Result<(), Failure> {
    // All is made aside: a demo that is cancelled leaves nothing.
    let aside = tempfile::tempdir().map_err(|e| failed(folder, &e))?;
    let at = |name: &str| aside.path().join(name);
    for (name, bytes) in SKETCH {
        std::fs::write(at(name), bytes).map_err(|e| failed(&at(name), &e))?;
    }
    let clip = session.context.open_clip(utf8(&at("gallop.webp"))?)?;
    let points = session.context.read_control_points(utf8(&at("points.json"))?)?;
    let drawing = session.context.read_svg(utf8(&at("drawing.svg"))?)?;
    let job = session.context.start_point_track(&clip, &points, false)?;
    watch(&job, &session.interrupt)?;
    let motion = job.take_motion()?;
    motion.write(utf8(&at("motion.json"))?)?;
    let binding = session.context.read_binding(utf8(&at("bind.json"))?)?;
    binding.write_preview(&drawing, &motion, Some(&clip), utf8(&at("bind.png"))?)?;
    let job = session.context.start_sketch_take(&drawing, &binding, &[&motion])?;
    watch(&job, &session.interrupt)?;
    let (take, said) = (job.take_sketch_take()?, job.report()?);
    const MADE: [&str; 2] = ["horse.svg", "horse.gif"];
    for name in MADE {
        let path = at(name);
        let file = SketchFileOptions {
            path: utf8(&path)?,
            format: "",
            name: "",
            crop: false,
            scale: 2.0,
            background: [255; 4],
        };
        watch(&session.context.start_sketch_file(&take, &file)?, &session.interrupt)?;
    }
    std::fs::create_dir_all(folder).map_err(|e| failed(folder, &e))?;
    let inputs = SKETCH.map(|(name, _)| name);
    for name in inputs.into_iter().chain(["motion.json", "bind.png"]).chain(MADE) {
        let path = folder.join(name);
        // A person's own from an earlier run stay.
        if inputs.contains(&name) && path.exists() {
            continue;
        }
        std::fs::copy(at(name), &path).map_err(|e| failed(&path, &e))?;
    }
    if session.json {
        say::line(&session.report("demo", &said, folder)?.to_string());
        return Ok(());
    }
    let shown = folder.display();
    say::text(&format!(
        "\
{shown}/horse.svg     a drawing that gallops, in any browser: open it first (horse.gif is the same as pixels)
{shown}/bind.png      which point of the clip holds which place of the drawing
then draw another over {shown}/drawing.svg, or move a point in {shown}/bind.json:
  marey sketch {shown}/drawing.svg --motion {shown}/motion.json --bind {shown}/bind.json -o {shown}/horse.svg
"
    ));
    Ok(())
}

fn failed(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(FAILED, format!("{}: cannot write: {error}", path.display()))
}
