//! The second door: the interfaces of marey-plugin-abi, which abi_stable checks. It leads to the same objects as the C
//! door, through the same guard, and differs from it in nothing that a plugin can see.

use std::collections::BTreeMap;
use std::ffi::c_void;
use std::ptr;

use marey_plugin_abi::export::TD_Opaque;
use marey_plugin_abi::std_types::{ROption, RResult, RSlice, RStr, RString, RVec};
use marey_plugin_abi::{
    Brief1, Deformer1, Deformer1_TO, Failure1, Frame1, Handle1, HostRef, Instance1, Log1, Mesh1, Parameter1, Plugin1,
    Point1, Root1, Segmenter1, Segmenter1_TO, Tracker1, Tracker1_TO, Value1,
};

use crate::clip::Clip;
use crate::error::{Error, ErrorKind, Result};
use crate::export::Bundle;
use crate::guard::{self, Guard};
use crate::log;
use crate::mesh::{Handle, Mesh};
use crate::motion::{Motion, Track};
use crate::parameter::{Kind, Parameter};
use crate::point::Point;
use crate::raw;
use crate::rig::{Facing, Limb, Paint, Painted, Rig, Side, Stroke};
use crate::room::{Host, Object, Work};
use crate::traits::Deformation;
use crate::values::{Given, Values};

/// The root of a library.
pub fn root<B: Bundle>() -> Root1 {
    Root1 { init, plugins: plugins::<B>, create: create::<B>, get_extension: no_extension }
}

const _: () = assert!(size_of::<Point>() == size_of::<Point1>() && align_of::<Point>() == align_of::<Point1>());

fn points<'a>(from: RSlice<'a, Point1>) -> &'a [Point] {
    let from: &'a [Point1] = from.as_slice();
    // SAFETY: both are two f32 in C's layout, which is asserted above.
    unsafe { std::slice::from_raw_parts(from.as_ptr().cast(), from.len()) }
}

fn points_out(from: &[Point]) -> RSlice<'_, Point1> {
    // SAFETY: as above.
    RSlice::from_slice(unsafe { std::slice::from_raw_parts(from.as_ptr().cast::<Point1>(), from.len()) })
}

fn handles(from: RSlice<'_, Handle1>) -> Result<Vec<Handle>> {
    let point = |p: Point1| Point::new(p.x, p.y);
    let each = from.as_slice().iter().map(|handle| match handle.kind {
        raw::HANDLE_POINT => Ok(Handle::Point(point(handle.a))),
        raw::HANDLE_BONE => Ok(Handle::Bone(point(handle.a), point(handle.b))),
        other => Err(Error::unsupported(format!("the plugin does not know handles of kind {other}"))),
    });
    each.collect()
}

fn work<'a>(brief: &Brief1<'a>, host: &'a dyn Host) -> Work<'a> {
    let limbs = brief.limbs.as_slice().iter().map(|limb| Limb {
        label: limb.label.as_str(),
        side: match limb.side {
            raw::SIDE_NEAR => Some(Side::Near),
            raw::SIDE_FAR => Some(Side::Far),
            raw::SIDE_MID => Some(Side::Mid),
            _ => None,
        },
        parent: usize::try_from(limb.parent).ok(),
        points: limb.point_count as usize,
        rooted_at_start: limb.flags & raw::LIMB_ROOTED_AT_START != 0,
        terminal: limb.flags & raw::LIMB_TERMINAL != 0,
    });
    let strokes = brief.strokes.as_slice().iter().map(|stroke| Stroke {
        limb: stroke.limb as usize,
        frame: stroke.frame as usize,
        points: points(stroke.points),
        facing: match stroke.facing {
            raw::FACING_TOWARD => Some(Facing::Toward),
            raw::FACING_AWAY => Some(Facing::Away),
            _ => None,
        },
    });
    let paints = brief.paints.as_slice().iter().map(|paint| Paint {
        frame: paint.frame as usize,
        foreground: paint.foreground != 0,
        radius: paint.radius,
        points: points(paint.points),
    });
    let painted = brief.painted.as_slice().iter();
    let painted = painted.map(|p| Painted { frame: p.frame as usize, pixels: p.pixels.as_slice() });
    let rig = Rig {
        limbs: limbs.collect(),
        strokes: strokes.collect(),
        paints: paints.collect(),
        painted: painted.collect(),
    };
    let clip = &brief.clip;
    Work { clip: Clip::new(host, (clip.width, clip.height), clip.frame_count, clip.fps), rig }
}

fn motion<'a>(brief: &Brief1<'a>) -> Motion<'a> {
    let tracks = brief.tracks.as_slice().iter().map(|track| Track {
        label: track.label.as_str(),
        points: track.point_count as usize,
        places: points(track.points),
        visible: track.visible.as_slice(),
        confidence: track.confidence.as_slice(),
    });
    Motion { tracks: tracks.collect() }
}

/// The host's job, as this door offers it.
struct RustHost<'a, 'b>(&'a HostRef<'b>);

fn answer(status: i32, what: impl FnOnce() -> String) -> Result<()> {
    match status {
        raw::OK => Ok(()),
        raw::CANCELLED => Err(Error::cancelled()),
        raw::E_INVALID => Err(Error::invalid(what())),
        _ => Err(Error::failed(what())),
    }
}

impl Host for RustHost<'_, '_> {
    fn progress(&self, fraction: f64, stage: Option<&str>) -> bool {
        self.0.progress(fraction, stage.map(RStr::from_str).into())
    }

    fn frame(&self, index: u64) -> Result<raw::Frame> {
        match self.0.get_frame(index) {
            RResult::ROk(Frame1 { width, height, stride_bytes, pixels, token, .. }) => {
                let struct_size = size_of::<raw::Frame>() as u32;
                Ok(raw::Frame { struct_size, width, height, stride_bytes, pixels, token })
            }
            RResult::RErr(status) => {
                answer(status, || format!("the host has no frame {index}, or it is damaged"))?;
                Err(Error::failed("the host's answer is none"))
            }
        }
    }

    fn release(&self, frame: &mut raw::Frame) {
        self.0.release_frame(frame.token);
        (frame.pixels, frame.token) = (ptr::null(), ptr::null_mut());
    }

    fn put_stroke(&self, limb: u32, frame: u64, at: &[Point], visible: &[u8], confidence: &[f32]) -> Result<()> {
        let (visible, confidence) = (RSlice::from_slice(visible), RSlice::from_slice(confidence));
        let status = self.0.put_stroke(limb, frame, points_out(at), visible, confidence);
        answer(status, || format!("the host does not take limb {limb} on frame {frame} as it is"))
    }

    fn put_mask(&self, frame: u64, pixels: &[u8], width: u32, height: u32, stride: usize) -> Result<()> {
        let status = self.0.put_mask(frame, RSlice::from_slice(pixels), width, height, stride);
        answer(status, || format!("the host does not take the mask of frame {frame} as it is"))
    }
}

fn out<T>(result: Result<T>) -> RResult<T, Failure1> {
    match result {
        Ok(value) => RResult::ROk(value),
        Err(error) => {
            let status = match error.kind() {
                ErrorKind::Cancelled => raw::CANCELLED,
                ErrorKind::Invalid => raw::E_INVALID,
                ErrorKind::Failed => raw::E_FAILED,
                ErrorKind::Unsupported => raw::E_UNSUPPORTED,
                ErrorKind::Panicked => raw::E_PANICKED,
                ErrorKind::Poisoned => raw::E_POISONED,
            };
            RResult::RErr(Failure1 { status, message: RString::from(error.message()) })
        }
    }
}

/// An instance of any kind.
struct Behind {
    object: Guard<Box<dyn Object>>,
    bound: BTreeMap<u64, Guard<Box<dyn Deformation>>>,
    next: u64,
}

macro_rules! state {
    () => {
        fn save(&mut self) -> RResult<RVec<u8>, Failure1> {
            out(self.object.call(|object| object.save().map(RVec::from)))
        }
        fn load(&mut self, version: u32, state: RSlice<'_, u8>) -> RResult<(), Failure1> {
            out(self.object.call(|object| object.load(version, state.as_slice())))
        }
    };
}

impl Tracker1 for Behind {
    fn track(&mut self, brief: &Brief1<'_>, host: &HostRef<'_>) -> RResult<(), Failure1> {
        let host = RustHost(host);
        out(self.object.call(|object| object.track(&work(brief, &host), &host)))
    }
    state!();
}

impl Segmenter1 for Behind {
    fn segment(&mut self, brief: &Brief1<'_>, host: &HostRef<'_>) -> RResult<(), Failure1> {
        let host = RustHost(host);
        out(self.object.call(|object| object.segment(&work(brief, &host), &motion(brief), &host)))
    }
    state!();
}

impl Deformer1 for Behind {
    fn bind(&mut self, mesh: &Mesh1<'_>, rest: RSlice<'_, Handle1>, host: &HostRef<'_>) -> RResult<u64, Failure1> {
        let host = RustHost(host);
        let bound = self.object.call(|object| {
            let mesh = Mesh { points: points(mesh.points), triangles: mesh.triangles.as_slice() };
            object.bind(&mesh, &handles(rest)?, &host)
        });
        out(bound.map(|bound| {
            self.next += 1;
            self.bound.insert(self.next, Guard::new(bound));
            self.next
        }))
    }

    fn solve(
        &mut self,
        bound: u64,
        targets: RSlice<'_, Handle1>,
        points: &mut RVec<Point1>,
        host: &HostRef<'_>,
    ) -> RResult<(), Failure1> {
        let host = RustHost(host);
        let Some(bound) = self.bound.get_mut(&bound) else { return out(Err(Error::failed("nothing of it is bound"))) };
        let points = points.as_mut_slice();
        // SAFETY: both are two f32 in C's layout, which is asserted above; borrowed once, for the call.
        let points = unsafe { std::slice::from_raw_parts_mut(points.as_mut_ptr().cast::<Point>(), points.len()) };
        let job = crate::job::Job::new(&host);
        out(bound.call(|bound| bound.solve(&handles(targets)?, points, &job)))
    }

    fn unbind(&mut self, bound: u64) {
        self.bound.remove(&bound);
    }
    state!();
}

extern "C" fn init(log: Log1) {
    /// A host's log may be called from any thread, for ever.
    struct LogTo(Log1);
    // SAFETY: see the type.
    unsafe impl Send for LogTo {}
    // SAFETY: see the type.
    unsafe impl Sync for LogTo {}
    impl LogTo {
        fn line(&self, level: i32, line: &str) {
            (self.0.line)(self.0.data, level, RStr::from_str(line));
        }
    }
    let _ = guard::contain(|| {
        let to = LogTo(log);
        log::set(Box::new(move |level, line| to.line(level, line)));
        guard::listen();
        Ok(())
    });
}

fn parameter(parameter: &Parameter) -> Parameter1 {
    let mut made = Parameter1 {
        kind: raw::NUMBER,
        flags: parameter.flags,
        id: parameter.id.into(),
        label: parameter.label.into(),
        about: parameter.about.into(),
        group: parameter.group.into(),
        unit: parameter.unit.into(),
        low: 0.0,
        high: 0.0,
        default_value: 0.0,
        step: parameter.step,
        choices: RVec::new(),
        default_text: RString::new(),
        visible_if: parameter.visible_if.map_or("", |(id, _)| id).into(),
        visible_value: parameter.visible_if.map_or(0.0, |(_, value)| value),
    };
    match parameter.kind {
        Kind::Number { low, high, default } => (made.low, made.high, made.default_value) = (low, high, default),
        Kind::Whole { low, high, default } => {
            made.kind = raw::WHOLE;
            (made.low, made.high, made.default_value) = (low.into(), high.into(), default.into());
        }
        Kind::Switch { default } => {
            made.kind = raw::SWITCH;
            (made.high, made.default_value) = (1.0, f64::from(u8::from(default)));
        }
        Kind::Choice { names, default } => {
            made.kind = raw::CHOICE;
            made.choices = names.iter().map(|n| RString::from(*n)).collect();
            (made.high, made.default_value) = (names.len().saturating_sub(1) as f64, default.into());
        }
        Kind::Text { default } => {
            made.kind = raw::TEXT;
            made.default_text = default.into();
        }
        Kind::File => made.kind = raw::FILE,
    }
    made
}

extern "C" fn plugins<B: Bundle>() -> RVec<Plugin1> {
    let all = guard::contain(|| {
        let each = B::state().registrations.iter().map(|r| Plugin1 {
            kind: r.kind,
            state_version: r.state_version,
            id: r.info.id.into(),
            name: r.info.name.into(),
            vendor: r.info.vendor.into(),
            version: r.info.version.into(),
            about: r.info.about.into(),
            parameters: r.parameters.iter().map(parameter).collect(),
        });
        Ok(each.collect())
    });
    all.unwrap_or_default()
}

extern "C" fn create<B: Bundle>(index: u32, values: RSlice<'_, Value1<'_>>) -> RResult<Instance1, Failure1> {
    out(guard::contain(|| {
        let none = || Error::invalid(format!("there is no plugin {index}"));
        let registration = B::state().registrations.get(index as usize).ok_or_else(none)?;
        let given = values.as_slice().iter().map(|value| Given {
            id: value.id.as_str(),
            number: value.number,
            text: if let ROption::RSome(text) = value.text { Some(text.as_str()) } else { None },
        });
        let values = Values::checked(registration.parameters, given.collect())?;
        let object = Guard::new((registration.create)(&values)?);
        let behind = Behind { object, bound: BTreeMap::new(), next: 0 };
        Ok(match registration.kind {
            raw::TRACKER => Instance1::Tracker(Tracker1_TO::from_value(behind, TD_Opaque)),
            raw::SEGMENTER => Instance1::Segmenter(Segmenter1_TO::from_value(behind, TD_Opaque)),
            _ => Instance1::Deformer(Deformer1_TO::from_value(behind, TD_Opaque)),
        })
    }))
}

extern "C" fn no_extension(_id: RStr<'_>) -> *const c_void {
    ptr::null()
}
