//! `marey print CREATURE --frame N -o OUT.stl`

use marey_binding::{PrintOptions, PrintSize};

use super::character::parsed;
use super::{Session, check_file, utf8};
use crate::args::Print;
use crate::failure::Failure;
use crate::say;
use crate::watch::watch;

pub(crate) fn print(session: &Session, args: &Print) -> Result<(), Failure> {
    check_file(&args.output)?;
    let creature = session.context.open_creature(utf8(&args.creature)?)?;
    let options = PrintOptions {
        frame: args.frame,
        size: match (args.size, args.height, args.mm_per_unit) {
            (_, Some(height), _) => PrintSize::Height(height),
            (_, _, Some(unit)) => PrintSize::Unit(unit),
            (size, ..) => PrintSize::Longest(size),
        },
        min_thickness: Some(args.min_thickness).filter(|t| *t != 0.0),
        detail: args.detail.unwrap_or_default(),
        base: args.base,
        max_triangles: args.max_triangles.unwrap_or_default(),
        path: utf8(&args.output)?,
    };
    let job = session.context.start_print(&creature, &options)?;
    watch(&job, &session.interrupt)?;
    let (solid, report) = (job.take_solid()?, job.report()?);
    if session.json {
        say::line(&session.report("print", &report, &args.output)?.to_string());
        return Ok(());
    }
    parsed(&report)?["warnings"].as_array().into_iter().flatten().filter_map(|w| w.as_str()).for_each(say::warning);
    let info = solid.info()?;
    let [width, depth, height] = info.size;
    say::line(&format!(
        "{}: {width:.1} x {depth:.1} x {height:.1} mm, {:.1} cubic cm, {} triangles, in {:.1} s",
        args.output.display(),
        info.volume / 1000.0,
        info.triangles,
        session.seconds()
    ));
    Ok(())
}
