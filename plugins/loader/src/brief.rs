//! What a tracker or a segmenter is told: a snapshot of the rig and the motion, in the words of `plugin.h`. It is
//! owned by the call, so that a plugin that hangs keeps reading memory that is there.

use std::ffi::{CString, c_char};

use marey::clip::Clip;
use marey::motion::Motion;
use marey::rig::{Facing, Rig, Side, Skeleton};
use marey::track::limb::LimbParams;
use marey_plugin::raw;

/// A limb.
pub(crate) struct Limb {
    pub(crate) label: CString,
    pub(crate) side: i32,
    pub(crate) parent: i32,
    pub(crate) points: u32,
    pub(crate) flags: u32,
}

/// A limb on a frame.
pub(crate) struct Stroke {
    pub(crate) limb: u32,
    pub(crate) frame: u64,
    pub(crate) facing: i32,
    pub(crate) points: Vec<raw::Point>,
}

/// A brush stroke.
pub(crate) struct Paint {
    pub(crate) frame: u64,
    pub(crate) foreground: u32,
    pub(crate) radius: f32,
    pub(crate) points: Vec<raw::Point>,
}

/// A tracked limb.
pub(crate) struct Track {
    pub(crate) label: CString,
    pub(crate) points: u32,
    pub(crate) places: Vec<raw::Point>,
    pub(crate) visible: Vec<u8>,
    pub(crate) confidence: Vec<f32>,
}

/// The whole of it.
pub(crate) struct Brief {
    pub(crate) size: (u32, u32),
    pub(crate) frames: u64,
    pub(crate) fps: f64,
    pub(crate) limbs: Vec<Limb>,
    pub(crate) strokes: Vec<Stroke>,
    pub(crate) paints: Vec<Paint>,
    /// Painted masks: the frame, and a byte a pixel.
    pub(crate) painted: Vec<(u64, Vec<u8>)>,
    pub(crate) tracks: Vec<Track>,
}

pub(crate) fn point(p: marey::Vec2) -> raw::Point {
    raw::Point::new(p.x, p.y)
}

/// A label may hold anything that a user can type; C strings end at a NUL.
fn label(text: &str) -> CString {
    let bytes: Vec<u8> = text.bytes().filter(|b| *b != 0).collect();
    CString::new(bytes).unwrap_or_default()
}

/// The skeleton whose vertices a tracker follows: the same as the built-in tracker's.
pub(crate) fn skeleton(clip: &Clip, rig: &Rig) -> Skeleton {
    let info = clip.info();
    let spacing = LimbParams::default().spacing * LimbParams::scale(info.width as usize, info.height as usize);
    Skeleton::new(rig, spacing)
}

impl Brief {
    /// For a tracker: the limbs and their strokes, resampled to the skeleton's vertices.
    pub(crate) fn new(clip: &Clip, rig: &Rig, skeleton: &Skeleton) -> Self {
        let info = clip.info();
        let limbs = rig.limbs.iter().zip(&skeleton.limbs).map(|(limb, chain)| Limb {
            label: label(&limb.label),
            side: match limb.side {
                None => raw::SIDE_UNKNOWN,
                Some(Side::Near) => raw::SIDE_NEAR,
                Some(Side::Far) => raw::SIDE_FAR,
                Some(Side::Mid) => raw::SIDE_MID,
            },
            parent: chain.parent.map_or(-1, |p| p as i32),
            points: chain.vertices.len() as u32,
            flags: if chain.rooted_at_start { raw::LIMB_ROOTED_AT_START } else { 0 }
                | if chain.terminal { raw::LIMB_TERMINAL } else { 0 },
        });
        let drawn = rig.keyframes.iter().flat_map(|key| key.strokes.iter().map(move |s| (key.frame, s)));
        let strokes = drawn.filter_map(|(frame, stroke)| {
            let points = skeleton.drawn(rig, stroke.limb, frame)?;
            Some(Stroke {
                limb: stroke.limb as u32,
                frame: frame as u64,
                facing: match stroke.facing {
                    None => raw::FACING_UNKNOWN,
                    Some(Facing::Toward) => raw::FACING_TOWARD,
                    Some(Facing::Away) => raw::FACING_AWAY,
                },
                points: points.into_iter().map(point).collect(),
            })
        });
        Self {
            size: (info.width, info.height),
            frames: info.frames as u64,
            fps: info.fps,
            limbs: limbs.collect(),
            strokes: strokes.collect(),
            paints: Vec::new(),
            painted: Vec::new(),
            tracks: Vec::new(),
        }
    }

    /// For a segmenter: what was painted too, and the motion.
    pub(crate) fn for_segmenter(clip: &Clip, rig: &Rig, skeleton: &Skeleton, motion: &Motion) -> marey::Result<Self> {
        let mut brief = Self::new(clip, rig, skeleton);
        for key in &rig.keyframes {
            let frame = key.frame as u64;
            brief.paints.extend(key.paint.iter().map(|paint| Paint {
                frame,
                foreground: u32::from(paint.foreground),
                radius: paint.radius,
                points: paint.points.iter().copied().map(point).collect(),
            }));
            if let Some(path) = &key.mask {
                let expected = format!("expected an 8-bit image of {}x{}", brief.size.0, brief.size.1);
                let bad = |what: String| marey::Error::file(path, what, expected.clone());
                let image = image::open(path).map_err(|e| bad(format!("the painted mask is not readable: {e}")))?;
                if (image.width(), image.height()) != brief.size {
                    return Err(bad(format!("the painted mask is {}x{}", image.width(), image.height())));
                }
                // The engine's own reading of a painted mask: in from the middle grey up.
                let mask = marey::raster::Mask::from_image(&image.to_luma8());
                brief.painted.push((frame, mask.to_image().into_raw()));
            }
        }
        brief.tracks = motion
            .tracks
            .iter()
            .map(|track| Track {
                label: label(&track.name),
                points: track.frames.first().map_or(0, |f| f.points.len() as u32),
                places: track.frames.iter().flat_map(|f| f.points.iter().copied().map(point)).collect(),
                visible: track.frames.iter().flat_map(|f| f.visible.iter().map(|v| u8::from(*v))).collect(),
                confidence: track.frames.iter().flat_map(|f| f.confidence.iter().copied()).collect(),
            })
            .collect();
        Ok(brief)
    }

    /// Where each limb is drawn.
    pub(crate) fn is_drawn(&self, limb: usize, frame: usize) -> bool {
        self.strokes.iter().any(|s| s.limb as usize == limb && s.frame as usize == frame)
    }
}

/// The same in the structs of `plugin.h`, which point into the brief.
pub(crate) struct RawBrief {
    pub(crate) clip: raw::Clip,
    pub(crate) rig: raw::Rig,
    pub(crate) motion: raw::Motion,
    _limbs: Vec<raw::Limb>,
    _strokes: Vec<raw::Stroke>,
    _paints: Vec<raw::Paint>,
    _painted: Vec<raw::Painted>,
    _tracks: Vec<raw::Track>,
}

impl RawBrief {
    pub(crate) fn new(brief: &Brief) -> Self {
        let text = |label: &CString| -> *const c_char { label.as_ptr() };
        let limbs: Vec<_> = brief
            .limbs
            .iter()
            .map(|l| raw::Limb {
                label: text(&l.label),
                side: l.side,
                parent: l.parent,
                point_count: l.points,
                flags: l.flags,
            })
            .collect();
        let strokes: Vec<_> = brief
            .strokes
            .iter()
            .map(|s| raw::Stroke {
                points: s.points.as_ptr(),
                frame: s.frame,
                limb: s.limb,
                point_count: s.points.len() as u32,
                facing: s.facing,
                reserved0: 0,
            })
            .collect();
        let paints: Vec<_> = brief
            .paints
            .iter()
            .map(|p| raw::Paint {
                points: p.points.as_ptr(),
                frame: p.frame,
                point_count: p.points.len() as u32,
                foreground: p.foreground,
                radius: p.radius,
                reserved0: 0,
            })
            .collect();
        let painted: Vec<_> = brief
            .painted
            .iter()
            .map(|(frame, pixels)| raw::Painted { pixels: pixels.as_ptr(), frame: *frame })
            .collect();
        let tracks: Vec<_> = brief
            .tracks
            .iter()
            .map(|t| raw::Track {
                label: text(&t.label),
                points: t.places.as_ptr(),
                visible: t.visible.as_ptr(),
                confidence: t.confidence.as_ptr(),
                point_count: t.points,
                reserved0: 0,
            })
            .collect();
        Self {
            clip: raw::Clip {
                struct_size: size_of::<raw::Clip>() as u32,
                width: brief.size.0,
                height: brief.size.1,
                reserved0: 0,
                frame_count: brief.frames,
                fps: brief.fps,
            },
            rig: raw::Rig {
                struct_size: size_of::<raw::Rig>() as u32,
                limb_count: limbs.len() as u32,
                limbs: limbs.as_ptr(),
                strokes: strokes.as_ptr(),
                paints: paints.as_ptr(),
                painted: painted.as_ptr(),
                stroke_count: strokes.len() as u32,
                paint_count: paints.len() as u32,
                painted_count: painted.len() as u32,
                reserved0: 0,
            },
            motion: raw::Motion {
                struct_size: size_of::<raw::Motion>() as u32,
                track_count: tracks.len() as u32,
                tracks: tracks.as_ptr(),
            },
            _limbs: limbs,
            _strokes: strokes,
            _paints: paints,
            _painted: painted,
            _tracks: tracks,
        }
    }
}
