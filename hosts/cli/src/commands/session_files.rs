//! `marey session embed FILE`, `marey session replay FILE`

use marey_binding::Access;
use serde_json::json;

use super::{Session, utf8};
use crate::args::{SessionEmbed, SessionReplay};
use crate::failure::Failure;
use crate::say;

pub(crate) fn session_embed(run: &Session, args: &SessionEmbed) -> Result<(), Failure> {
    let session = run.context.open_session(utf8(&args.file)?, Access::Edit)?;
    session.set_embedded(true)?;
    session.save()?;
    let warnings = session.warnings()?;
    if run.json {
        say::line(&json!({ "command": "session embed", "path": args.file, "warnings": warnings }).to_string());
        return Ok(());
    }
    say::line(&format!("{}: carries its clip and its masks", args.file.display()));
    warnings.iter().for_each(|warning| say::line(&format!("  {warning}")));
    Ok(())
}

pub(crate) fn session_replay(run: &Session, args: &SessionReplay) -> Result<(), Failure> {
    let session = run.context.replay(utf8(&args.file)?, args.most)?;
    if let Some(output) = &args.output {
        session.save_as(utf8(output)?)?;
    }
    let (state, warnings) = (session.state()?, session.warnings()?);
    let fingerprint = format!("{:016x}", session.fingerprint()?);
    if run.json {
        let report = json!({
            "command": "session replay",
            "path": args.file,
            "played": state.recovered,
            "fingerprint": fingerprint,
            "output": args.output,
            "warnings": warnings,
        });
        say::line(&report.to_string());
        return Ok(());
    }
    let played = state.recovered;
    say::line(&format!("{}: {played} gestures played; they lead to {fingerprint}", args.file.display()));
    warnings.iter().for_each(|warning| say::line(&format!("  {warning}")));
    Ok(())
}
