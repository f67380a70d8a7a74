//! The trackers and segmenters that a description may name.

use marey::segment::{self, CostVolumeSegmenter, SegmentParams};
use marey::track::limb::{self, LimbParams, LimbTracker};

use crate::error::{Failure, Outcome};
use crate::status::mry_status_code as Code;
use crate::string::mry_str;

/// # Safety
/// The string is valid, as the header asks.
pub(crate) unsafe fn tracker(id: mry_str) -> Outcome<LimbTracker> {
    // SAFETY: as this function's own.
    let method = match unsafe { id.text("desc.tracker")? } {
        "" | "space-time" => limb::Method::SpaceTime,
        "paper" => limb::Method::Paper,
        other => return Err(unknown("desc.tracker", other, "space-time, paper")),
    };
    Ok(LimbTracker { params: LimbParams { method, ..LimbParams::default() } })
}

/// # Safety
/// The string is valid, as the header asks.
pub(crate) unsafe fn segmenter(id: mry_str) -> Outcome<CostVolumeSegmenter> {
    // SAFETY: as this function's own.
    let method = match unsafe { id.text("desc.segmenter")? } {
        "" | "layered" => segment::Method::Layered,
        "paper" => segment::Method::Paper,
        other => return Err(unknown("desc.segmenter", other, "layered, paper")),
    };
    Ok(CostVolumeSegmenter { params: SegmentParams { method, ..SegmentParams::default() } })
}

fn unknown(param: &'static str, id: &str, known: &str) -> Failure {
    Failure::new(Code::MRY_E_UNSUPPORTED, param, format!("{param}: `{id}` is not known; there are {known}"))
}

/// What the report says about how a job was run.
///
/// # Safety
/// The strings are valid, as the header asks.
pub(crate) unsafe fn settings(tracker: mry_str, segmenter: mry_str) -> Outcome<serde_json::Value> {
    // SAFETY: as this function's own.
    let (tracker, segmenter) = unsafe { (tracker.text("desc.tracker")?, segmenter.text("desc.segmenter")?) };
    let or = |id: &str, best: &str| if id.is_empty() { best.to_owned() } else { id.to_owned() };
    Ok(serde_json::json!({ "tracker": or(tracker, "space-time"), "segmenter": or(segmenter, "layered") }))
}
