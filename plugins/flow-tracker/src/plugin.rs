//! The tracker as a plugin.

use glam::Vec2;
use marey_plugin::marey_plugin;
use marey_plugin::{
    Clip, Error as PluginError, Info, Job, Parameter, Plugin, Point, Result, Rig, Tracker, Tracks, Values,
};

use crate::{Error, FlowTracker, Footage, Limb, Parameters, Stroke};

/// The plugin.
#[derive(Debug)]
pub struct FlowPlugin {
    tracker: FlowTracker,
}

impl Plugin for FlowPlugin {
    const INFO: Info = Info::new("marey.flow-tracker", "Dense flow", env!("CARGO_PKG_VERSION")).about(
        "Follows strokes by dense flow, held to how they looked on key frames. Best where surfaces are textured.",
    );
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::number("width", "Band", 0.0, 0.5, 0.04).step(0.01).about(
            "Half the width of the band around a stroke whose motion counts, as a share of the stroke's length.",
        ),
        Parameter::number("disagreement", "Disagreement", 0.1, 20.0, 1.0)
            .unit("px")
            .logarithmic()
            .advanced()
            .about("How far flow there and back may miss itself before it counts half."),
        Parameter::number("anchor", "Hold to looks", 0.0, 1.0, 0.8)
            .step(0.05)
            .about("How strongly points are pulled back to what looks as they did on their key frame."),
        Parameter::number("length", "Keep length", 0.0, 1.0, 0.3)
            .step(0.05)
            .about("How much of its drawn length a limb takes back in every frame."),
    ];

    fn create(values: &Values<'_>) -> Result<Self> {
        let number = |id: &str| values.number(id).map(|v| v as f32);
        let parameters = Parameters {
            width: number("width")?,
            disagreement: number("disagreement")?,
            anchor: number("anchor")?,
            length: number("length")?,
        };
        Ok(Self { tracker: FlowTracker { parameters } })
    }
}

impl Tracker for FlowPlugin {
    fn track(&mut self, clip: &Clip<'_>, rig: &Rig<'_>, job: &Job<'_>) -> Result<Tracks> {
        let frame = |index: usize| -> std::result::Result<Vec<u8>, String> {
            let frame = clip.frame(index).map_err(|e| e.message().to_owned())?;
            let mut pixels = Vec::with_capacity(3 * frame.width() * frame.height());
            (0..frame.height()).for_each(|y| pixels.extend_from_slice(frame.row(y)));
            Ok(pixels)
        };
        let limbs: Vec<Limb> = rig
            .limbs
            .iter()
            .enumerate()
            .map(|(l, limb)| Limb {
                strokes: rig
                    .strokes_of(l)
                    .map(|s| Stroke { frame: s.frame, points: s.points.iter().map(|p| Vec2::new(p.x, p.y)).collect() })
                    .collect(),
                parent: limb.parent,
                rooted_at_start: limb.rooted_at_start,
            })
            .collect();
        let footage =
            Footage { width: clip.width(), height: clip.height(), count: clip.frames(), frames: &frame, limbs: &limbs };
        let poses = self.tracker.track(&footage, &|done| job.at(done).is_ok()).map_err(|error| match error {
            Error::Cancelled => PluginError::cancelled(),
            Error::Frame { .. } => PluginError::failed(error.to_string()),
            other => PluginError::invalid(other.to_string()),
        })?;
        job.at(1.0)?;
        let mut tracks = Tracks::new(clip, rig);
        for (l, frames) in poses.iter().enumerate() {
            for (f, pose) in frames.iter().enumerate() {
                let points: Vec<Point> = pose.points.iter().map(|p| Point::new(p.x, p.y)).collect();
                tracks.set(l, f, &points);
                tracks.set_visible(l, f, &pose.visible);
                tracks.set_confidence(l, f, &pose.confidence);
            }
        }
        Ok(tracks)
    }
}

marey_plugin! { tracker: FlowPlugin }

#[cfg(test)]
mod tests {
    use super::*;
    use marey_plugin::ErrorKind;
    use marey_plugin::testing::Scene;

    const FRAMES: usize = 24;

    /// A textured arm that turns about (80, 60), a pixel and a half a frame at its tip, on textured ground that moves
    /// the other way.
    fn scene() -> (Scene, usize) {
        let mut scene = Scene::new(160, 120, FRAMES, |frame, x, y| {
            let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - Vec2::new(80.0, 60.0);
            let on_arm = Vec2::from_angle(-turn(frame)).rotate(p);
            let waves = |p: Vec2| {
                40.0 * (0.9 * p.x + 0.3 * p.y).sin() + 35.0 * (0.35 * p.x - 0.8 * p.y).sin() + 30.0 * (0.21 * p.x).cos()
            };
            let shade = if (-8.0..60.0).contains(&on_arm.x) && on_arm.y.abs() < 8.0 {
                140.0 + waves(on_arm)
            } else {
                90.0 + waves(0.5 * p + Vec2::new(0.4 * frame as f32, 7.0))
            };
            [shade as u8; 3]
        });
        let arm = scene.limb("arm", 9);
        (scene, arm)
    }

    fn turn(frame: usize) -> f32 {
        0.03 * frame as f32
    }

    fn truth(frame: usize, share: f32) -> Point {
        let p = Vec2::new(80.0, 60.0) + Vec2::from_angle(turn(frame)) * 52.0 * share;
        Point::new(p.x, p.y)
    }

    fn plugin() -> FlowPlugin {
        FlowPlugin::create(&Values::defaults(FlowPlugin::PARAMETERS)).expect("defaults")
    }

    #[test]
    fn follows_a_textured_arm_from_one_and_from_two_key_frames() {
        for keys in [&[0][..], &[0, FRAMES - 1], &[12]] {
            let (mut scene, arm) = scene();
            for &key in keys {
                scene.stroke(arm, key, truth(key, 0.0), truth(key, 1.0));
            }
            let tracks = scene.track(&mut plugin()).expect("sound input");
            for frame in 0..FRAMES {
                for (i, p) in tracks.get(arm, frame).iter().enumerate() {
                    let error = p.distance(truth(frame, i as f32 / 8.0));
                    assert!(error < 1.5, "keys {keys:?}, frame {frame}, point {i}: {error}");
                }
            }
        }
    }

    #[test]
    fn the_same_bits_with_any_number_of_threads() {
        let wave = |f: usize, i: usize| ((i % 80) as f32 * 0.4 - 0.7 * f as f32).sin() * ((i / 80) as f32 * 0.3).cos();
        let frame = |f: usize| Ok((0..80 * 60).flat_map(|i| [(128.0 + 90.0 * wave(f, i)) as u8; 3]).collect());
        let points = (0..8).map(|i| Vec2::new(20.0 + 4.0 * i as f32, 30.0)).collect();
        let limbs = [Limb { strokes: vec![Stroke { frame: 3, points }], ..Limb::default() }];
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let footage = Footage { width: 80, height: 60, count: 9, frames: &frame, limbs: &limbs };
            pool.install(|| FlowTracker::default().track(&footage, &|_| true)).expect("sound input")
        };
        assert!(with(1) == with(3));
    }

    #[test]
    fn stops_when_the_host_asks() {
        for looks in [0, 2, 30, 200] {
            let (mut scene, arm) = scene();
            scene.stroke(arm, 0, truth(0, 0.0), truth(0, 1.0));
            scene.cancel_after(looks);
            let error = scene.track(&mut plugin()).expect_err("the host asked to stop");
            assert_eq!(error.kind(), ErrorKind::Cancelled, "after {looks}: {error}");
        }
    }

    #[test]
    fn what_cannot_be_followed_is_named() {
        let frame = |_: usize| Ok(vec![90; 3 * 32 * 24]);
        let stroke = |frame: usize, points: &[Vec2]| Stroke { frame, points: points.to_vec() };
        let track = |limbs: &[Limb]| {
            let footage = Footage { width: 32, height: 24, count: 5, frames: &frame, limbs };
            FlowTracker::default().track(&footage, &|_| true).map(|_| ()).map_err(|e| e.to_string())
        };
        let line = [Vec2::new(3.0, 3.0), Vec2::new(20.0, 9.0)];
        let limb = |strokes: Vec<Stroke>| [Limb { strokes, ..Limb::default() }];
        assert_eq!(track(&limb(vec![stroke(4, &line)])), Ok(()));
        let says = |limbs: &[Limb], what: &str| {
            let message = track(limbs).expect_err(what);
            assert!(message.contains(what), "{message}");
        };
        says(&limb(vec![]), "nowhere drawn");
        says(&limb(vec![stroke(5, &line)]), "there are 5 frames");
        says(&limb(vec![stroke(1, &line[..1])]), "give at least 2");
        says(&limb(vec![stroke(2, &line), stroke(1, &line)]), "out of order");
        says(&limb(vec![stroke(1, &[line[0], Vec2::new(f32::NAN, 0.0)])]), "not finite");
        let own_child = [Limb { strokes: vec![stroke(0, &line)], parent: Some(0), rooted_at_start: true }];
        assert_eq!(track(&own_child), Ok(()), "a circle hangs from nothing");
        let short = |_: usize| Ok(vec![0; 10]);
        let limbs = limb(vec![stroke(0, &line)]);
        let footage = Footage { width: 32, height: 24, count: 5, frames: &short, limbs: &limbs };
        let error = FlowTracker::default().track(&footage, &|_| true).expect_err("too few bytes");
        assert!(error.to_string().starts_with("frame "), "{error}");
    }
}
