//! Somebody who edits a session for ever: draws, drags, paints, tracks, and takes back, the same way every time. What
//! they do next depends on the session alone, so that a second one can check what became of the first.

use std::sync::Arc;

use glam::vec2;
use marey::Result;
use marey::motion::{Motion, Track, TrackFrame, TrackKind};
use marey::rig::{Paint, Rig, Side};
use marey::session::{Session, Tracked, Value};

/// Saves come after every so many gestures.
const SAVE_EVERY: u64 = 7;

/// Does one gesture, which changes something.
pub fn gesture(session: &mut Session) -> Result<()> {
    let number = session.gestures() + 1;
    let inputs = session.document().inputs.clone();
    let rig = &inputs.rig;
    if rig.limbs.is_empty() {
        let size = (640, 480 + (number % 100) as u32);
        session.begin_gesture("start")?;
        session.set_rig(Rig { size, limbs: Vec::new(), keyframes: Vec::new() })?;
        session.add_limb("body", None)?;
        return session.end_gesture().map(drop);
    }
    let chance = scatter(number);
    let limb = chance as usize / 16 % rig.limbs.len();
    let frame = chance as usize / 1024 % 90;
    // No two gestures draw the same.
    let at = vec2((number % 500) as f32 + 0.1, (number / 500 % 400) as f32 + 0.7);
    let points = || (0..12).map(|i| at + vec2(3.7 * i as f32, 0.3 * (i * i) as f32)).collect::<Vec<_>>();
    match chance % 16 {
        0..=3 if session.undo()?.is_some() => {}
        4..=5 if session.redo()?.is_some() => {}
        6 if rig.limbs.len() < 12 => drop(session.add_limb(&format!("limb {number}"), Some(Side::Near))?),
        7 if rig.limbs.len() > 2 => drop(session.remove_limb(limb)?),
        8 => drop(session.add_paint(frame, Paint { foreground: true, radius: 4.0, points: points() })?),
        9 => drop(session.set_motion(Some(Tracked { motion: motion(rig, number), inputs: inputs.clone() }))?),
        10 => drop(session.set_limb(limb, &format!("renamed {number}"), None)?),
        _ => {
            session.begin_gesture("drag")?;
            for step in 0..20 {
                session.set_parameter("creature.smoothing", Some(Value::Number(f64::from(step) / 20.0)))?;
            }
            session.set_stroke(limb, frame, points(), None)?;
            session.end_gesture()?;
        }
    }
    Ok(())
}

/// Saves where it is time to.
pub fn save(session: &mut Session) -> Result<()> {
    if session.gestures().is_multiple_of(SAVE_EVERY) { session.save() } else { Ok(()) }
}

fn motion(rig: &Rig, number: u64) -> Arc<Motion> {
    let at = |f: usize| vec2(f as f32 + 0.01 * number as f32, number as f32);
    let track = |label: &String| Track {
        name: label.clone(),
        kind: TrackKind::Stroke,
        frames: (0..90).map(|f| TrackFrame::certain((0..8).map(|i| at(f + i)).collect())).collect(),
    };
    let tracks = rig.limbs.iter().map(|l| track(&l.label)).collect();
    Arc::new(Motion { size: rig.size, fps: 24.0, frames: 90, tracks, bones: Vec::new() })
}

/// A number without a pattern for each number: splitmix64, Steele and others 2014.
pub fn scatter(number: u64) -> u64 {
    let mut z = number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
