//! The trackers and segmenters that a description may name: the built-in ones, and plugins by their ids.

use std::sync::Arc;

use marey::segment::{self, CostVolumeSegmenter, SegmentParams, Segmenter};
use marey::track::Tracker;
use marey::track::limb::{self, LimbParams, LimbTracker};
use marey_plugin_loader::PluginKind;

use crate::error::{Failure, Outcome};
use crate::guard::Call;
use crate::status::mry_status_code as Code;
use crate::string::mry_str;

impl Call<'_> {
    /// # Safety
    /// The string is valid, as the header asks.
    pub(crate) unsafe fn tracker(&self, id: mry_str) -> Outcome<Arc<dyn Tracker>> {
        // SAFETY: as this function's own.
        let method = match unsafe { id.text("desc.tracker")? } {
            "" | "space-time" => limb::Method::SpaceTime,
            "paper" => limb::Method::Paper,
            other => {
                match self.context.plugins.slot(other, PluginKind::Tracker).map_err(|e| e.about("desc.tracker"))? {
                    Some(slot) => return Ok(slot),
                    None => return Err(self.unknown("desc.tracker", other, "space-time, paper", PluginKind::Tracker)),
                }
            }
        };
        Ok(Arc::new(LimbTracker { params: LimbParams { method, ..LimbParams::default() } }))
    }

    /// # Safety
    /// The string is valid, as the header asks.
    pub(crate) unsafe fn segmenter(&self, id: mry_str) -> Outcome<Arc<dyn Segmenter>> {
        // SAFETY: as this function's own.
        let method = match unsafe { id.text("desc.segmenter")? } {
            "" | "layered" => segment::Method::Layered,
            "paper" => segment::Method::Paper,
            other => {
                let slot = self.context.plugins.slot(other, PluginKind::Segmenter);
                match slot.map_err(|e| e.about("desc.segmenter"))? {
                    Some(slot) => return Ok(slot),
                    None => return Err(self.unknown("desc.segmenter", other, "layered, paper", PluginKind::Segmenter)),
                }
            }
        };
        Ok(Arc::new(CostVolumeSegmenter { params: SegmentParams { method, ..SegmentParams::default() } }))
    }

    pub(crate) fn unknown(&self, param: &'static str, id: &str, known: &str, kind: PluginKind) -> Failure {
        let known: Vec<String> = std::iter::once(known.to_owned()).chain(self.context.plugins.ids(kind)).collect();
        let message = format!("{param}: `{id}` is not known; there are {}", known.join(", "));
        Failure::new(Code::MRY_E_UNSUPPORTED, param, message)
    }
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
