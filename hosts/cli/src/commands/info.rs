//! `marey info CLIP`

use serde_json::json;

use super::{Session, utf8};
use crate::args::Info;
use crate::failure::Failure;
use crate::say;

pub(crate) fn info(session: &Session, args: &Info) -> Result<(), Failure> {
    let clip = session.context.open_clip(utf8(&args.clip)?)?.info()?;
    let seconds = clip.frames as f64 / clip.fps;
    if session.json {
        let report = json!({
            "command": "info",
            "path": args.clip,
            "clip": {
                "source": clip.source,
                "width": clip.width,
                "height": clip.height,
                "frames": clip.frames,
                "fps": clip.fps,
                "seconds": seconds,
            },
            "warnings": clip.warnings,
        });
        say::line(&report.to_string());
        return Ok(());
    }
    let (width, height, frames, fps) = (clip.width, clip.height, clip.frames, clip.fps);
    say::line(&format!(
        "{}: {}, {width}x{height}, {frames} frames at {fps:.3} a second, {seconds:.2} s",
        args.clip.display(),
        clip.source
    ));
    clip.warnings.iter().for_each(|warning| say::line(&format!("  {warning}")));
    Ok(())
}
