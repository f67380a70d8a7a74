//! An edit of a session is tracked where it matters, and nowhere else.

use std::ops::Range;
use std::sync::Mutex;

use super::*;
use crate::clip::Clip;
use crate::error::Result;
use crate::job::Stage;
use crate::track::{Earlier, Tracker};

/// Notes what it is asked for.
#[derive(Default)]
struct Noting(Mutex<Vec<Asked>>);

/// The frames of every limb, or [`None`] for the whole clip.
type Asked = Option<Vec<Vec<Range<usize>>>>;

fn range(start: usize, end: usize) -> Vec<Range<usize>> {
    vec![Range { start, end }]
}

fn still(rig: &Rig, frames: usize) -> Motion {
    let track = |limb: &crate::rig::Limb| Track {
        name: limb.label.clone(),
        kind: TrackKind::Stroke,
        frames: vec![TrackFrame::certain(bar(9.0)); frames],
    };
    Motion { size: rig.size, fps: 24.0, frames, tracks: rig.limbs.iter().map(track).collect(), bones: vec![] }
}

impl Tracker for Noting {
    fn track(&self, clip: &Clip, rig: &Rig, _: Stage<'_>) -> Result<Motion> {
        self.0.lock().expect("alone").push(None);
        Ok(still(rig, clip.info().frames))
    }

    fn retrack(&self, clip: &Clip, rig: &Rig, earlier: Earlier<'_>, _: Stage<'_>) -> Result<Motion> {
        self.0.lock().expect("alone").push(Some(earlier.outdated.to_vec()));
        Ok(still(rig, clip.info().frames))
    }
}

#[test]
fn only_what_is_out_of_date_is_asked_for() {
    let (_keep, folder) = folder();
    let frames = (0..40).map(|_| image::RgbImage::new(100, 80)).collect();
    let footage = Clip::from_frames(frames, 24.0).expect("a clip");
    let mut session = Session::new();
    let reference = ClipReference { fps: 24.0, ..clip(&folder.join("clip.mp4")) };
    session.set_clip(Some(reference)).expect("a clip");
    for (limb, label) in ["body", "tail"].into_iter().enumerate() {
        session.add_limb(label, None).expect("a limb");
        for frame in [0, 10, 20, 30] {
            session.set_stroke(limb, frame, bar(20.0 + frame as f32), None).expect("a stroke");
        }
    }
    let noting = Noting::default();
    let asked = |session: &mut Session| {
        let Document { inputs, tracked, .. } = session.document().clone();
        let tracker = Incremental { tracker: &noting, inputs: &inputs, tracked: tracked.as_ref() };
        let motion = tracker.track(&footage, &inputs.rig, Progress::new().whole()).expect("tracked");
        session.set_motion(Some(Tracked { motion: Arc::new(motion), inputs })).expect("taken");
        noting.0.lock().expect("alone").drain(..).collect::<Vec<_>>()
    };
    assert_eq!(asked(&mut session), [None], "nothing is tracked yet");
    assert_eq!(asked(&mut session), [], "all is up to date");
    session.set_stroke(1, 20, bar(50.0), None).expect("a stroke");
    assert_eq!(asked(&mut session), [Some(vec![vec![], range(11, 30)])]);
    session.set_stroke(0, 35, bar(50.0), None).expect("a stroke");
    session.remove_stroke(1, 10).expect("no stroke");
    assert_eq!(asked(&mut session), [Some(vec![range(31, 40), range(1, 20)])]);
    session.remove_limb(0).expect("no limb");
    assert_eq!(asked(&mut session), [Some(vec![vec![]])], "what is left holds");
    session.set_parameter("track.spacing", Some(Value::Number(12.0))).expect("a value");
    assert_eq!(asked(&mut session), [None], "another way of tracking");
    session.set_motion(None).expect("away");
    assert_eq!(asked(&mut session), [None]);
}
