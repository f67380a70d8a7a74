//! `marey session info FILE`

use marey_binding::Access;
use serde_json::{Value, json};

use super::{Session, utf8};
use crate::args::SessionInfo;
use crate::failure::{FAILED, Failure};
use crate::say;

pub(crate) fn session_info(run: &Session, args: &SessionInfo) -> Result<(), Failure> {
    let session = run.context.open_session(utf8(&args.file)?, Access::ReadOnly)?;
    let (state, warnings) = (session.state()?, session.warnings()?);
    let rig: Value = serde_json::from_str(&session.rig()?.to_json()?)
        .map_err(|e| Failure::new(FAILED, format!("{}: {e}", args.file.display())))?;
    let key_frames = rig["keyframes"].as_array().map_or(0, Vec::len);
    let labels = rig["limbs"].as_array().into_iter().flatten().filter_map(|limb| limb["label"].as_str());
    let limb = |(index, label): (usize, &str)| -> Result<Value, Failure> {
        let outdated = session.outdated(index as u32)?;
        let ranges: Vec<[u64; 2]> = outdated.iter().map(|range| [range.start, range.end]).collect();
        Ok(json!({ "label": label, "outdated": ranges }))
    };
    let limbs = labels.enumerate().map(limb).collect::<Result<Vec<_>, _>>()?;
    if run.json {
        let report = json!({
            "command": "session info",
            "path": args.file,
            "size": rig["size"],
            "limbs": limbs,
            "keyframes": key_frames,
            "has_clip": state.has_clip,
            "has_motion": state.has_motion,
            "motion_outdated": state.motion_outdated,
            "gestures": state.gestures,
            "unsaved_gestures": state.recovered,
            "embedded": state.embedded,
            "fingerprint": format!("{:016x}", session.fingerprint()?),
            "warnings": warnings,
        });
        say::line(&report.to_string());
        return Ok(());
    }
    let tracked = match (state.has_motion, state.motion_outdated) {
        (false, _) => "not tracked",
        (true, false) => "tracked",
        (true, true) => "tracked in part",
    };
    say::line(&format!(
        "{}: {} limbs on {key_frames} key frames, {tracked}, {} gestures, {} of them not saved",
        args.file.display(),
        limbs.len(),
        state.gestures,
        state.recovered
    ));
    warnings.iter().for_each(|warning| say::line(&format!("  {warning}")));
    Ok(())
}
