//! The second door, from the host's side: calls through the interfaces of marey-plugin-abi.

use std::ffi::c_void;
use std::ptr;

use marey_plugin::raw;
use marey_plugin_abi::export::TD_Opaque;
use marey_plugin_abi::std_types::{ROption, RResult, RSlice, RStr, RString, RVec};
use marey_plugin_abi::{
    Brief1, Clip1, Failure1, Frame1, Handle1, Header, Host1, Host1_TO, Instance1, Limb1, Log1, Mesh1, Mismatch, Paint1,
    Painted1, Parameter1, Plugin1, Point1, Root1_Ref, Stroke1, Track1, Value1,
};

use crate::brief::Brief;
use crate::c_door::LogLine;
use crate::describe::{MAX_PLUGINS, ParameterInfo, ParameterKind, PluginInfo, PluginKind};
use crate::door::{Door, DoorKind, Fault, FaultKind, Instance, MAX_STATE, MeshBrief, Opened};
use crate::post::Post;
use crate::refusal::Status;
use crate::values::Value;

/// Opens the door: checks versions and layouts, starts the library, reads what is inside.
///
/// # Safety
/// `symbol` is what a library that is never unloaded exports under abi_stable's name.
pub(crate) unsafe fn open(symbol: *const c_void, log: LogLine) -> Result<Opened, (Status, String)> {
    if symbol.is_null() || !(symbol as usize).is_multiple_of(align_of::<usize>()) {
        return Err((Status::NoEntry, "its header is no header".to_owned()));
    }
    // SAFETY: as this function's own: a header is a reference to static data, and is checked before it is believed.
    let header = unsafe { ptr::read(ptr::from_ref(&symbol).cast::<Header>()) };
    let log: &'static LogLine = Box::leak(Box::new(log));
    // SAFETY: as this function's own.
    let root = unsafe { marey_plugin_abi::open(header) }.map_err(|(what, said)| {
        // Tens of kilobytes of types: for the log; a person gets one line.
        log(raw::LOG_WARNING, &said);
        match what {
            Mismatch::Version => (Status::AbiVersion, "was made for another version of the Rust door".to_owned()),
            Mismatch::Layout => (Status::Layout, "lays out the types of the Rust door in another way".to_owned()),
            Mismatch::Start => (Status::Init, format!("did not start: {said}")),
        }
    })?;
    (root.init())(Log1 { data: ptr::from_ref(log).cast(), line: log_line });
    let plugins = (root.plugins())();
    if plugins.len() > MAX_PLUGINS as usize {
        let problem = format!("holds {} plugins, and at most {MAX_PLUGINS} are allowed", plugins.len());
        return Err((Status::Descriptor, problem));
    }
    let plugins = plugins.iter().map(plugin).collect::<Result<_, _>>();
    let plugins = plugins.map_err(|problem| (Status::Descriptor, problem))?;
    Ok(Opened { door: Box::new(RustDoor(root)), kind: DoorKind::Rust, plugins })
}

extern "C" fn log_line(data: *const c_void, level: i32, line: RStr<'_>) {
    let _ = std::panic::catch_unwind(|| {
        // SAFETY: the data is what `open` leaked.
        if let Some(log) = unsafe { data.cast::<LogLine>().as_ref() } {
            log(level, &line.as_str().chars().take(4096).collect::<String>());
        }
    });
}

fn plugin(from: &Plugin1) -> Result<PluginInfo, String> {
    Ok(PluginInfo {
        kind: match from.kind {
            raw::TRACKER => PluginKind::Tracker,
            raw::SEGMENTER => PluginKind::Segmenter,
            raw::DEFORMER => PluginKind::Deformer,
            other => return Err(format!("`{}` is of kind {other}, which this host does not know", from.id)),
        },
        id: from.id.to_string(),
        name: from.name.to_string(),
        vendor: from.vendor.to_string(),
        version: from.version.to_string(),
        about: from.about.to_string(),
        parameters: from.parameters.iter().map(parameter).collect::<Result<_, _>>()?,
        state_version: from.state_version,
    })
}

fn parameter(from: &Parameter1) -> Result<ParameterInfo, String> {
    let kind = match from.kind {
        raw::NUMBER => ParameterKind::Number,
        raw::WHOLE => ParameterKind::Whole,
        raw::SWITCH => ParameterKind::Switch,
        raw::CHOICE => ParameterKind::Choice,
        raw::TEXT => ParameterKind::Text,
        raw::FILE => ParameterKind::File,
        other => return Err(format!("parameter `{}` is of kind {other}, which this host does not know", from.id)),
    };
    Ok(ParameterInfo {
        id: from.id.to_string(),
        label: from.label.to_string(),
        about: from.about.to_string(),
        group: from.group.to_string(),
        unit: from.unit.to_string(),
        kind,
        low: from.low,
        high: from.high,
        default: from.default_value,
        default_text: from.default_text.to_string(),
        step: from.step,
        choices: from.choices.iter().map(RString::to_string).collect(),
        visible_if: (!from.visible_if.is_empty()).then(|| (from.visible_if.to_string(), from.visible_value)),
        flags: from.flags,
    })
}

struct RustDoor(Root1_Ref);

impl Door for RustDoor {
    fn create(&self, index: usize, values: &[(String, Value)]) -> Result<Box<dyn Instance>, Fault> {
        let values: Vec<Value1<'_>> = values
            .iter()
            .map(|(id, value)| match value {
                Value::Number(number) => Value1 { id: id.as_str().into(), number: *number, text: ROption::RNone },
                Value::Text(text) => {
                    Value1 { id: id.as_str().into(), number: 0.0, text: ROption::RSome(text.as_str().into()) }
                }
            })
            .collect();
        match (self.0.create())(index as u32, RSlice::from_slice(&values)) {
            RResult::ROk(instance) => Ok(Box::new(RustInstance(instance))),
            RResult::RErr(failure) => Err(fault(&failure)),
        }
    }
}

fn fault(failure: &Failure1) -> Fault {
    Fault::of(failure.status, failure.message.to_string())
}

fn outcome<T>(result: RResult<T, Failure1>) -> Result<T, Fault> {
    result.into_result().map_err(|failure| fault(&failure))
}

/// A post as this door offers it.
struct PostHost<'a>(&'a Post);

impl Host1 for PostHost<'_> {
    fn progress(&self, fraction: f64, stage: ROption<RStr<'_>>) -> bool {
        self.0.progress(fraction, stage.into_option().map(|s| s.as_str()))
    }

    fn get_frame(&self, index: u64) -> RResult<Frame1, i32> {
        match self.0.get_frame(index) {
            Ok(raw::Frame { width, height, stride_bytes, pixels, token, .. }) => {
                RResult::ROk(Frame1 { width, height, stride_bytes, reserved0: 0, pixels, token })
            }
            Err(status) => RResult::RErr(status),
        }
    }

    fn release_frame(&self, token: *mut c_void) {
        self.0.release_frame(token);
    }

    fn put_stroke(
        &self,
        limb: u32,
        frame: u64,
        points: RSlice<'_, Point1>,
        visible: RSlice<'_, u8>,
        confidence: RSlice<'_, f32>,
    ) -> i32 {
        let points = points.as_slice();
        if [visible.len(), confidence.len()] != [points.len(); 2] {
            return raw::E_INVALID;
        }
        // SAFETY: both are two f32 in C's layout, which is asserted below.
        let points = unsafe { std::slice::from_raw_parts(points.as_ptr().cast::<raw::Point>(), points.len()) };
        self.0.put_stroke(limb, frame, points, Some(visible.as_slice()), Some(confidence.as_slice()))
    }

    fn put_mask(&self, frame: u64, pixels: RSlice<'_, u8>, width: u32, height: u32, stride: usize) -> i32 {
        match self.0.mask_bytes(frame, (width, height), stride) {
            Ok(bytes) if bytes <= pixels.len() => self.0.put_mask(frame, pixels.as_slice(), stride),
            Ok(_) => raw::E_INVALID,
            Err(status) => status,
        }
    }
}

const _: () =
    assert!(size_of::<raw::Point>() == size_of::<Point1>() && align_of::<raw::Point>() == align_of::<Point1>());

fn points(from: &[raw::Point]) -> RSlice<'_, Point1> {
    // SAFETY: both are two f32 in C's layout, which is asserted above.
    RSlice::from_slice(unsafe { std::slice::from_raw_parts(from.as_ptr().cast::<Point1>(), from.len()) })
}

fn handles(from: &[raw::Handle]) -> Vec<Handle1> {
    let point = |p: raw::Point| Point1 { x: p.x, y: p.y };
    from.iter().map(|h| Handle1 { kind: h.kind, a: point(h.a), b: point(h.b) }).collect()
}

/// Tells a plugin the brief, in lists that live as long as the call.
fn tell<R>(brief: &Brief, work: impl FnOnce(&Brief1<'_>) -> R) -> R {
    let text = |label: &std::ffi::CString| label.to_string_lossy().into_owned();
    let names: Vec<String> = brief.limbs.iter().map(|l| text(&l.label)).collect();
    let track_names: Vec<String> = brief.tracks.iter().map(|t| text(&t.label)).collect();
    let limbs: Vec<_> = brief
        .limbs
        .iter()
        .zip(&names)
        .map(|(l, name)| Limb1 {
            label: name.as_str().into(),
            side: l.side,
            parent: l.parent,
            point_count: l.points,
            flags: l.flags,
        })
        .collect();
    let strokes: Vec<_> = brief
        .strokes
        .iter()
        .map(|s| Stroke1 { points: points(&s.points), frame: s.frame, limb: s.limb, facing: s.facing })
        .collect();
    let paints: Vec<_> = brief
        .paints
        .iter()
        .map(|p| Paint1 { points: points(&p.points), frame: p.frame, foreground: p.foreground, radius: p.radius })
        .collect();
    let painted: Vec<_> =
        brief.painted.iter().map(|(frame, p)| Painted1 { pixels: RSlice::from_slice(p), frame: *frame }).collect();
    let tracks: Vec<_> = brief
        .tracks
        .iter()
        .zip(&track_names)
        .map(|(t, name)| Track1 {
            label: name.as_str().into(),
            points: points(&t.places),
            visible: RSlice::from_slice(&t.visible),
            confidence: RSlice::from_slice(&t.confidence),
            point_count: t.points,
        })
        .collect();
    work(&Brief1 {
        clip: Clip1 { width: brief.size.0, height: brief.size.1, frame_count: brief.frames, fps: brief.fps },
        limbs: RSlice::from_slice(&limbs),
        strokes: RSlice::from_slice(&strokes),
        paints: RSlice::from_slice(&paints),
        painted: RSlice::from_slice(&painted),
        tracks: RSlice::from_slice(&tracks),
    })
}

struct RustInstance(Instance1);

fn another() -> Fault {
    Fault::new(FaultKind::Unsupported, "is of another kind than it says")
}

impl Instance for RustInstance {
    fn track(&mut self, brief: &Brief, post: &Post) -> Result<(), Fault> {
        let Instance1::Tracker(tracker) = &mut self.0 else { return Err(another()) };
        let host = PostHost(post);
        let host = Host1_TO::from_ptr(&host, TD_Opaque);
        outcome(tell(brief, |brief| tracker.track(brief, &host)))
    }

    fn segment(&mut self, brief: &Brief, post: &Post) -> Result<(), Fault> {
        let Instance1::Segmenter(segmenter) = &mut self.0 else { return Err(another()) };
        let host = PostHost(post);
        let host = Host1_TO::from_ptr(&host, TD_Opaque);
        outcome(tell(brief, |brief| segmenter.segment(brief, &host)))
    }

    fn bind(&mut self, mesh: &MeshBrief, rest: &[raw::Handle], post: &Post) -> Result<u64, Fault> {
        let Instance1::Deformer(deformer) = &mut self.0 else { return Err(another()) };
        let host = PostHost(post);
        let host = Host1_TO::from_ptr(&host, TD_Opaque);
        let mesh = Mesh1 { points: points(&mesh.points), triangles: RSlice::from_slice(&mesh.triangles) };
        outcome(deformer.bind(&mesh, RSlice::from_slice(&handles(rest)), &host))
    }

    fn solve(
        &mut self,
        bound: u64,
        targets: &[raw::Handle],
        moved: &mut [raw::Point],
        post: &Post,
    ) -> Result<(), Fault> {
        let Instance1::Deformer(deformer) = &mut self.0 else { return Err(another()) };
        let host = PostHost(post);
        let host = Host1_TO::from_ptr(&host, TD_Opaque);
        let mut given: RVec<Point1> = points(moved).as_slice().into();
        outcome(deformer.solve(bound, RSlice::from_slice(&handles(targets)), &mut given, &host))?;
        if given.len() != moved.len() {
            return Err(Fault::new(FaultKind::Absurd, format!("gave {} points for {}", given.len(), moved.len())));
        }
        moved.iter_mut().zip(given.iter()).for_each(|(to, p)| *to = raw::Point::new(p.x, p.y));
        Ok(())
    }

    fn unbind(&mut self, bound: u64) {
        if let Instance1::Deformer(deformer) = &mut self.0 {
            deformer.unbind(bound);
        }
    }

    fn save(&mut self) -> Result<Option<Vec<u8>>, Fault> {
        let saved = match &mut self.0 {
            Instance1::Tracker(tracker) => tracker.save(),
            Instance1::Segmenter(segmenter) => segmenter.save(),
            Instance1::Deformer(deformer) => deformer.save(),
        };
        let bytes = outcome(saved)?;
        if bytes.len() > MAX_STATE {
            let problem = format!("its state has {} bytes, and at most {MAX_STATE} are allowed", bytes.len());
            return Err(Fault::new(FaultKind::Absurd, problem));
        }
        Ok(Some(bytes.to_vec()))
    }

    fn load(&mut self, version: u32, state: &[u8]) -> Result<(), Fault> {
        let state = RSlice::from_slice(state);
        outcome(match &mut self.0 {
            Instance1::Tracker(tracker) => tracker.load(version, state),
            Instance1::Segmenter(segmenter) => segmenter.load(version, state),
            Instance1::Deformer(deformer) => deformer.load(version, state),
        })
    }
}
