//! Motion from paths. Points that run along drawn paths: motion without a clip.

use marey::motion::paths::MotionPaths;

use crate::border::Out;
use crate::context::mry_context;
use crate::error::{Failure, mry_error};
use crate::guard::entry;
use crate::motion::mry_motion;
use crate::status::{mry_status, mry_status_code as Code};
use crate::string::mry_str;

/// Makes a motion of the text of a paths.json, which names points and gives each a path as SVG path data: around a closed
/// path a point goes at constant speed, along an open one there and back. The motion loops.
///
/// @param context     The context.
/// @param json        The text.
/// @param out_motion  The motion.
/// @param err         Detail of a failure, or NULL.
/// @return MRY_OK; MRY_E_INPUT, MRY_E_STRING.
/// Lifetime: until mry_motion_destroy or the end of the context.
/// Thread: [any-thread]. Since 0.1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mry_motion_from_paths(
    context: *mut mry_context,
    json: mry_str,
    out_motion: *mut mry_motion,
    err: *mut mry_error,
) -> mry_status {
    entry!(context, err, |call| {
        let json = json.text("json")?;
        let out = Out::new(out_motion, "out_motion")?;
        let motion = MotionPaths::from_json(json).and_then(|paths| paths.motion());
        let motion = motion.map_err(|e| Failure::from(e).about("json"))?;
        out.set(call.keep_motion(std::sync::Arc::new(motion))?);
        Ok(Code::MRY_OK)
    })
}
