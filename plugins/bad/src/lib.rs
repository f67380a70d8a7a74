//! Plugins in Rust that are broken on purpose: one library, and one plugin in it for each way. The guard of the sdk has
//! to hold all of them.

use marey_plugin::{
    Clip, Deformation, Deformer, Handle, Info, Job, Level, Mask, MaskSink, Mesh, Motion, Parameter, Plugin, Point,
    Result, Rig, Segmenter, Tracker, Tracks, Values, log, marey_plugin,
};

/// How a tracker breaks.
trait Break: Send + 'static {
    const ID: &'static str;
    fn track(clip: &Clip<'_>, rig: &Rig<'_>) -> Tracks;
}

/// A tracker that breaks in one way.
struct Broken<B> {
    _how: std::marker::PhantomData<B>,
}

impl<B: Break> Plugin for Broken<B> {
    const INFO: Info = Info::new(B::ID, "Broken on purpose", "1.0.0");

    fn create(_values: &Values<'_>) -> Result<Self> {
        Ok(Self { _how: std::marker::PhantomData })
    }
}

impl<B: Break> Tracker for Broken<B> {
    fn track(&mut self, clip: &Clip<'_>, rig: &Rig<'_>, _job: &Job<'_>) -> Result<Tracks> {
        Ok(B::track(clip, rig))
    }
}

struct Panics;

impl Break for Panics {
    const ID: &'static str = "org.marey.bad.panics";
    fn track(_clip: &Clip<'_>, rig: &Rig<'_>) -> Tracks {
        panic!("{} limbs are too many", rig.limbs.len())
    }
}

struct OutOfBounds;

impl Break for OutOfBounds {
    const ID: &'static str = "org.marey.bad.out-of-bounds";
    fn track(clip: &Clip<'_>, rig: &Rig<'_>) -> Tracks {
        let mut tracks = Tracks::new(clip, rig);
        let past = clip.frames() * 1000;
        tracks.limbs[0].places[past] = Point::default();
        tracks
    }
}

struct NotANumber;

impl Break for NotANumber {
    const ID: &'static str = "org.marey.bad.not-a-number";
    fn track(clip: &Clip<'_>, rig: &Rig<'_>) -> Tracks {
        let mut tracks = Tracks::new(clip, rig);
        tracks.limbs[0].places.fill(Point::new(f32::NAN, 0.0));
        tracks
    }
}

struct TooFew;

impl Break for TooFew {
    const ID: &'static str = "org.marey.bad.too-few";
    fn track(clip: &Clip<'_>, rig: &Rig<'_>) -> Tracks {
        let mut tracks = Tracks::new(clip, rig);
        tracks.limbs[0].places.pop();
        tracks
    }
}

/// Throws something whose own destructor panics.
struct ThrowsABomb;

struct Bomb;

impl Drop for Bomb {
    fn drop(&mut self) {
        panic!("a bomb");
    }
}

impl Break for ThrowsABomb {
    const ID: &'static str = "org.marey.bad.throws-a-bomb";
    fn track(_clip: &Clip<'_>, _rig: &Rig<'_>) -> Tracks {
        std::panic::panic_any(Bomb)
    }
}

/// Panics when it is dropped, otherwise good; and a thread of its own panics too.
struct PanicsInDrop;

impl Plugin for PanicsInDrop {
    const INFO: Info = Info::new("org.marey.bad.panics-in-drop", "Broken on purpose", "1.0.0");

    fn create(_values: &Values<'_>) -> Result<Self> {
        Ok(Self)
    }
}

impl Tracker for PanicsInDrop {
    fn track(&mut self, clip: &Clip<'_>, rig: &Rig<'_>, _job: &Job<'_>) -> Result<Tracks> {
        let _ = std::thread::spawn(|| panic!("a thread of the plugin's own")).join();
        let mut tracks = Tracks::new(clip, rig);
        for limb in 0..rig.limbs.len() {
            for frame in 0..clip.frames() {
                tracks.set(limb, frame, rig.last_stroke(limb, frame).map_or(&[], |s| s.points));
            }
        }
        Ok(tracks)
    }
}

impl Drop for PanicsInDrop {
    fn drop(&mut self) {
        panic!("in drop");
    }
}

/// Panics when it is made with a value that is allowed.
struct PanicsInCreate;

impl Plugin for PanicsInCreate {
    const INFO: Info = Info::new("org.marey.bad.panics-in-create", "Broken on purpose", "1.0.0");
    const PARAMETERS: &[Parameter] = &[Parameter::switch("panic", "Panic", false)];

    fn create(values: &Values<'_>) -> Result<Self> {
        assert!(!values.switch("panic")?, "in create");
        log(Level::Info, "made");
        Ok(Self)
    }
}

impl Segmenter for PanicsInCreate {
    fn segment(
        &mut self,
        clip: &Clip<'_>,
        _rig: &Rig<'_>,
        motion: &Motion<'_>,
        masks: &MaskSink<'_>,
        job: &Job<'_>,
    ) -> Result<()> {
        for frame in 0..clip.frames() {
            job.at(frame as f64 / clip.frames() as f64)?;
            let mut mask = Mask::new(clip.width(), clip.height());
            for track in &motion.tracks {
                for p in track.places(frame) {
                    mask.set(p.x as usize, p.y as usize, true);
                }
            }
            masks.put(frame, &mask)?;
        }
        Ok(())
    }
}

/// A deformer that moves all points as its first handle moves, and breaks when that goes far to the left.
struct Shifts;

struct Bound(Point);

impl Plugin for Shifts {
    const INFO: Info = Info::new("org.marey.bad.shifts", "Shifts", "1.0.0");

    fn create(_values: &Values<'_>) -> Result<Self> {
        Ok(Self)
    }
}

fn place(handle: &Handle) -> Point {
    match *handle {
        Handle::Point(p) | Handle::Bone(p, _) => p,
    }
}

impl Deformer for Shifts {
    type Bound = Bound;

    fn bind(&mut self, _mesh: &Mesh<'_>, handles: &[Handle], _job: &Job<'_>) -> Result<Bound> {
        handles.first().map(|h| Bound(place(h))).ok_or_else(|| marey_plugin::Error::invalid("one handle is needed"))
    }
}

impl Deformation for Bound {
    fn solve(&mut self, targets: &[Handle], points: &mut [Point], _job: &Job<'_>) -> Result<()> {
        let to = place(&targets[0]);
        if to.x < -1000.0 {
            points.fill(Point::new(f32::INFINITY, 0.0));
            return Ok(());
        }
        assert!(to.x >= -100.0, "too far to the left");
        points.iter_mut().for_each(|p| *p = p.moved(to.x - self.0.x, to.y - self.0.y));
        self.0 = to;
        Ok(())
    }
}

marey_plugin! {
    tracker: Broken<Panics>,
    tracker: Broken<OutOfBounds>,
    tracker: Broken<NotANumber>,
    tracker: Broken<TooFew>,
    tracker: Broken<ThrowsABomb>,
    tracker: PanicsInDrop,
    segmenter: PanicsInCreate,
    deformer: Shifts,
}
