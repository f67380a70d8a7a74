//! `marey edit CREATURE --mesh MESH.obj --frame N -o OUT.glb`

use marey_binding::EditedMesh;

use super::character::parsed;
use super::{Session, check_file, utf8};
use crate::args::surface::Edit;
use crate::failure::Failure;
use crate::say;
use crate::watch::watch;

pub(crate) fn edit(session: &Session, args: &Edit) -> Result<(), Failure> {
    check_file(&args.output)?;
    let creature = session.context.open_creature(utf8(&args.creature)?)?;
    let job = session.context.start_edit(&creature, args.frame, &EditedMesh::File(utf8(&args.mesh)?))?;
    watch(&job, &session.interrupt)?;
    let (edited, report) = (job.take_creature()?, job.report()?);
    edited.write_glb(utf8(&args.output)?, 0.0)?;
    if session.json {
        say::line(&session.report("edit", &report, &args.output)?.to_string());
        return Ok(());
    }
    let report = parsed(&report)?;
    let what = if report["kind"] == "displaced" { "moved" } else { "bound anew" };
    say::line(&format!(
        "{}: {} vertices {what}, in {:.1} s",
        args.output.display(),
        report["vertices"],
        session.seconds()
    ));
    Ok(())
}
