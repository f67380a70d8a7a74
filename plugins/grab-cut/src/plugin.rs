//! The segmenter as a plugin.

use std::collections::BTreeMap;

use glam::Vec2;
use marey_plugin::marey_plugin;
use marey_plugin::{Clip, Info, Job, Mask, MaskSink, Motion, Parameter, Plugin, Point, Result, Rig, Segmenter, Values};

use crate::{Error, Footage, GrabCut, Known, Limb, Parameters, brush};

/// The plugin.
#[derive(Debug)]
pub struct GrabCutPlugin {
    segmenter: GrabCut,
}

impl Plugin for GrabCutPlugin {
    const INFO: Info = Info::new("marey.grab-cut", "GrabCut", env!("CARGO_PKG_VERSION"))
        .about("Mixtures of colour at place and exact cuts. Best where creature and background share colours.");
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::number("colour", "Colour", 0.0, 2.0, 1.0).step(0.05).about("How much colours count."),
        Parameter::number("shape", "Shape", 0.0, 4.0, 1.0)
            .step(0.05)
            .about("How much counts what was creature around the limbs in other frames."),
        Parameter::number("smoothness", "Smoothness", 0.0, 100.0, 4.0)
            .about("The price of a border where there is no contrast."),
        Parameter::number("memory", "Memory", 1.0, 1000.0, 12.0)
            .unit("frames")
            .logarithmic()
            .about("Frames over which a mask is remembered."),
        Parameter::number("place", "Place", 0.0, 400.0, 80.0)
            .unit("levels")
            .group("Mixtures")
            .advanced()
            .about("What the creature's whole size is worth beside a channel of colour; 0 for plain colours."),
        Parameter::whole("components", "Components", 1, 32, 5)
            .group("Mixtures")
            .advanced()
            .about("Gaussians for each side."),
        Parameter::whole("rounds", "Rounds", 1, 10, 4)
            .group("Mixtures")
            .advanced()
            .about("Rounds of learning and cutting before the final cut."),
    ];

    fn create(values: &Values<'_>) -> Result<Self> {
        let number = |id: &str| values.number(id).map(|v| v as f32);
        let parameters = Parameters {
            components: values.whole("components")? as u32,
            rounds: values.whole("rounds")? as u32,
            smoothness: number("smoothness")?,
            colour: number("colour")?,
            shape: number("shape")?,
            place: number("place")?,
            memory: number("memory")?,
        };
        Ok(Self { segmenter: GrabCut { parameters } })
    }
}

impl Segmenter for GrabCutPlugin {
    fn segment(
        &mut self,
        clip: &Clip<'_>,
        rig: &Rig<'_>,
        motion: &Motion<'_>,
        masks: &MaskSink<'_>,
        job: &Job<'_>,
    ) -> Result<()> {
        let (width, height) = (clip.width(), clip.height());
        let frame = |index: usize| -> std::result::Result<Vec<u8>, String> {
            let frame = clip.frame(index).map_err(|e| e.message().to_owned())?;
            let mut pixels = Vec::with_capacity(3 * width * height);
            (0..height).for_each(|y| pixels.extend_from_slice(frame.row(y)));
            Ok(pixels)
        };
        let poses: Vec<Vec<Limb>> = (0..clip.frames()).map(|f| pose(motion, f)).collect();
        let known = painted(rig, width, height);
        let footage = Footage { width, height, frames: &frame, poses: &poses, known: &known };
        let put = |frame: usize, pixels: Vec<u8>| {
            masks.put(frame, &Mask { width, height, pixels }).map_err(|e| e.message().to_owned())
        };
        let done = self.segmenter.segment(&footage, &put, &|done| job.at(done).is_ok());
        done.map_err(|error| match error {
            Error::Cancelled => marey_plugin::Error::cancelled(),
            Error::Frame { .. } => marey_plugin::Error::failed(error.to_string()),
            other => marey_plugin::Error::invalid(other.to_string()),
        })?;
        job.at(1.0)
    }
}

fn vector(p: &Point) -> Vec2 {
    Vec2::new(p.x, p.y)
}

fn pose(motion: &Motion<'_>, frame: usize) -> Vec<Limb> {
    let limbs = motion.tracks.iter().map(|track| {
        let seen = track.visible(frame).iter().zip(track.confidence(frame));
        Limb {
            points: track.places(frame).iter().map(vector).collect(),
            trust: seen.map(|(&v, &c)| if v != 0 { c } else { 0.0 }).collect(),
        }
    });
    limbs.collect()
}

/// What was painted: whole masks, and brush strokes over them.
fn painted(rig: &Rig<'_>, width: usize, height: usize) -> BTreeMap<usize, Vec<Known>> {
    let mut known: BTreeMap<usize, Vec<Known>> = BTreeMap::new();
    for mask in rig.painted.iter().filter(|m| m.pixels.len() == width * height) {
        let of = |v: &u8| if *v >= 128 { Known::Creature } else { Known::Background };
        known.insert(mask.frame, mask.pixels.iter().map(of).collect());
    }
    for paint in &rig.paints {
        let pixels = known.entry(paint.frame).or_insert_with(|| vec![Known::Nothing; width * height]);
        let what = if paint.foreground { Known::Creature } else { Known::Background };
        let path: Vec<Vec2> = paint.points.iter().map(vector).collect();
        brush(pixels, width, &path, paint.radius, what);
    }
    known
}

marey_plugin! { segmenter: GrabCutPlugin }

#[cfg(test)]
mod tests {
    use super::*;
    use marey_plugin::ErrorKind;
    use marey_plugin::testing::Scene;

    /// A grey bar that goes right over a chequered ground with patches of the bar's own grey.
    fn scene() -> Scene {
        let mut scene = Scene::new(160, 120, 12, |frame, x, y| {
            if (30 + 2 * frame..90 + 2 * frame).contains(&x) && (50..70).contains(&y) {
                let shade = 120 + ((x - 2 * frame) * 7 + y * 3) % 20;
                return [shade as u8, shade as u8, shade as u8];
            }
            if (x / 16 + y / 16) % 4 == 0 { [125, 128, 131] } else { [60, 130 + (x * 5 + y * 11) as u8 % 30, 50] }
        });
        let bar = scene.limb("bar", 7);
        scene.stroke(bar, 0, Point::new(34.0, 60.0), Point::new(86.0, 60.0));
        scene.stroke(bar, 11, Point::new(56.0, 60.0), Point::new(108.0, 60.0));
        scene
    }

    fn plugin() -> GrabCutPlugin {
        GrabCutPlugin::create(&Values::defaults(GrabCutPlugin::PARAMETERS)).expect("defaults")
    }

    #[test]
    fn cuts_a_bar_from_ground_that_shares_its_colour() {
        let masks = scene().segment(&mut plugin()).expect("sound input");
        for (frame, mask) in masks.iter().enumerate() {
            let (mut both, mut either) = (0.0, 0.0);
            for y in 0..120 {
                for x in 0..160 {
                    let truth = (30 + 2 * frame..90 + 2 * frame).contains(&x) && (50..70).contains(&y);
                    both += f64::from(u8::from(truth && mask.get(x, y)));
                    either += f64::from(u8::from(truth || mask.get(x, y)));
                }
            }
            assert!(both / either > 0.85, "frame {frame}: {}", both / either);
        }
    }

    #[test]
    fn stops_when_the_host_asks() {
        for looks in [0, 3, 20, 50] {
            let mut scene = scene();
            scene.cancel_after(looks);
            let error = scene.segment(&mut plugin()).expect_err("the host asked to stop");
            assert_eq!(error.kind(), ErrorKind::Cancelled, "after {looks}: {error}");
        }
    }
}
