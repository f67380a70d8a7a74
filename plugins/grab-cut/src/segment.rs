//! The whole method: learn from a few dozen frames in rounds, then cut every frame at its own resolution.

use rayon::prelude::*;

use crate::cut::{Say, cut};
use crate::footage::{Footage, Known, Limb};
use crate::mixture::Sample;
use crate::models::{Atlas, Models, centre, fit, samples, thin};
use crate::occupancy::{Counts, Occupancy};
use crate::tidy::tidy;
use crate::window::{View, Window, bounds};
use crate::{Error, Parameters};

/// Blocks that a window is worked on in, at most.
const BLOCKS: f32 = 36_000.0;
/// Frames that are learnt from, at most.
const LEARNT: usize = 96;
/// Learnt frames that share one mixture of the background.
const SCENE: usize = 8;
/// Margin around the limbs as a share of their box.
const MARGIN: f32 = 0.22;
/// Before anything is known, a limb's half width: a share of its length and one of the creature's size.
const GUESS: (f32, f32) = (0.06, 0.03);
/// Shares of that guess within which a pixel surely is creature, and beyond which it surely is not.
const SURELY_IN: f32 = 0.3;
const SURELY_OUT: f32 = 3.0;
/// Points trusted less than this teach nothing.
const TRUSTED: f32 = 0.35;
/// Evidence of a pixel's colour is kept within this.
const LIMIT: f32 = 8.0;
/// Pixels that the first guess of a chance counts for.
const DOUBT: f32 = 6.0;
/// What a painted pixel counts for beside a cut one.
const PAINTED: f32 = 8.0;
/// Blocks on each side of the first cut within which pixels are cut again.
const BAND: usize = 2;

/// The segmenter.
#[derive(Clone, Debug, Default)]
pub struct GrabCut {
    /// Its settings.
    pub parameters: Parameters,
}

/// A learnt frame and its labels so far.
struct Lesson {
    frame: usize,
    view: View,
    labels: Vec<bool>,
    counts: Counts,
}

/// All that is learnt of a clip.
struct Knowledge {
    /// Of each group of learnt frames.
    models: Vec<Models>,
    /// The middle frame of each group.
    times: Vec<f32>,
    radius: Vec<f32>,
}

impl GrabCut {
    /// Gives `put` one mask a frame, one byte a pixel, 255 on the creature and 0 elsewhere, in no order and from any
    /// thread. `go_on` is told how much is done (0..=1), from any thread, at least every 100 ms; `false` cancels.
    ///
    /// # Errors
    /// Sizes that do not agree, a limb without points or with a number that is not finite, a parameter outside its
    /// range, a frame that cannot be had or a mask that `put` does not take, or a cancel.
    pub fn segment(
        &self,
        footage: &Footage<'_>,
        put: &(dyn Fn(usize, Vec<u8>) -> Result<(), String> + Sync),
        go_on: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<(), Error> {
        self.parameters.check()?;
        check(footage)?;
        if footage.poses.is_empty() {
            return Ok(());
        }
        let work = Work::new(&self.parameters, footage, go_on);
        let mut lessons = work.lessons()?;
        let knowledge = work.learn(&mut lessons)?;
        work.cut_all(&lessons, &knowledge, put)
    }
}

fn check(footage: &Footage<'_>) -> Result<(), Error> {
    let bad = |what: String, problem: String, remedy| Err(Error::Input { what, problem, remedy });
    let pixels = footage.width.saturating_mul(footage.height);
    if pixels == 0 || pixels > 1 << 28 {
        let problem = format!("{}x{} pixels", footage.width, footage.height);
        return bad("the frames".into(), problem, "give frames of at least a pixel and at most 2^28");
    }
    let limbs = footage.poses.first().map_or(0, Vec::len);
    if !footage.poses.is_empty() && (limbs == 0 || limbs > 256) {
        return bad("the limbs".into(), format!("there are {limbs}"), "give 1 to 256");
    }
    for (f, pose) in footage.poses.iter().enumerate() {
        if pose.len() != limbs {
            let problem = format!("{} limbs, the first has {limbs}", pose.len());
            return bad(format!("frame {f}"), problem, "give the same limbs in every frame");
        }
        for (i, limb) in pose.iter().enumerate() {
            let what = || format!("limb {i} in frame {f}");
            if limb.points.is_empty() || limb.points.len() != limb.trust.len() {
                let problem = format!("{} points and {} trusts", limb.points.len(), limb.trust.len());
                return bad(what(), problem, "give at least one point and a trust for each");
            }
            let far = 10.0 * (footage.width + footage.height) as f32;
            if limb.points.iter().any(|p| !p.is_finite() || p.abs().max_element() > far)
                || limb.trust.iter().any(|t| !t.is_finite())
            {
                return bad(what(), "a number is not finite or far outside".into(), "give pixels of the frame");
            }
        }
    }
    for (&f, known) in footage.known {
        if known.len() != pixels {
            let problem = format!("{} painted pixels for {pixels}", known.len());
            return bad(format!("frame {f}"), problem, "give one entry a pixel");
        }
    }
    Ok(())
}

fn length(limb: &Limb) -> f32 {
    limb.points.windows(2).map(|p| p[0].distance(p[1])).sum()
}

/// What stays the same through all of it.
struct Work<'a> {
    parameters: &'a Parameters,
    footage: &'a Footage<'a>,
    go_on: &'a (dyn Fn(f64) -> bool + Sync),
    size: (usize, usize),
    factor: usize,
    margin: f32,
    atlas: Atlas,
    /// Each limb's half width as guessed from its longest length: one that points at the camera is no thinner for it.
    guess: Vec<f32>,
}

impl<'a> Work<'a> {
    fn new(parameters: &'a Parameters, footage: &'a Footage<'a>, go_on: &'a (dyn Fn(f64) -> bool + Sync)) -> Self {
        let boxes: Vec<_> = footage.poses.iter().map(|p| bounds(p)).collect();
        let largest = boxes.iter().map(|(low, high)| (*high - *low).length()).fold(0.0, f32::max);
        let margin = MARGIN * largest + 4.0;
        let size = (footage.width, footage.height);
        let area = footage.poses.iter().map(|p| Window::around(p, margin, size, 1).len()).max().unwrap_or(0);
        let factor = ((area as f32 / BLOCKS).sqrt().ceil() as usize).max(1);
        // Places are named in the pose that is trusted most: a key frame's.
        let trust = |pose: &[Limb]| pose.iter().flat_map(|l| &l.trust).sum::<f32>();
        let mut rest = (f32::NEG_INFINITY, 0);
        for (f, pose) in footage.poses.iter().enumerate() {
            if trust(pose) > rest.0 {
                rest = (trust(pose), f);
            }
        }
        let limbs = footage.poses[0].len();
        let longest = |l: usize| footage.poses.iter().map(|p| length(&p[l])).fold(1.0, f32::max);
        let guess = (0..limbs).map(|l| GUESS.0 * longest(l) + GUESS.1 * largest).collect();
        let atlas = Atlas::new(&footage.poses[rest.1], parameters.place);
        Self { parameters, footage, go_on, size, factor, margin, atlas, guess }
    }

    fn at(&self, done: f64) -> Result<(), Error> {
        if (self.go_on)(done) { Ok(()) } else { Err(Error::Cancelled) }
    }

    fn picture(&self, frame: usize) -> Result<Vec<u8>, Error> {
        let pixels = self.footage.frames.frame(frame).map_err(|problem| Error::Frame { frame, problem })?;
        if pixels.len() != 3 * self.size.0 * self.size.1 {
            let problem = format!("{} bytes for {}x{} pixels of 3", pixels.len(), self.size.0, self.size.1);
            return Err(Error::Frame { frame, problem });
        }
        Ok(pixels)
    }

    fn view(&self, frame: usize, picture: &[u8], radius: &[f32]) -> View {
        let pose = &self.footage.poses[frame];
        let window = Window::around(pose, self.margin, self.size, self.factor);
        View::new(picture, self.footage.known.get(&frame), self.size, pose, radius, window)
    }

    /// Frames to learn from: evenly spread, and all painted ones.
    fn lessons(&self) -> Result<Vec<Lesson>, Error> {
        let n = self.footage.poses.len();
        let step = n.div_ceil(LEARNT);
        let mut frames: Vec<usize> = (0..n).step_by(step).collect();
        frames.extend(self.footage.known.keys().filter(|&&f| f < n));
        frames.sort_unstable();
        frames.dedup();
        let count = frames.len() as f64;
        frames
            .par_iter()
            .enumerate()
            .map(|(i, &frame)| {
                self.at(0.1 * i as f64 / count)?;
                let view = self.view(frame, &self.picture(frame)?, &self.guess);
                let labels = vec![false; view.window.len()];
                Ok(Lesson { frame, view, labels, counts: Counts::new(self.guess.len()) })
            })
            .collect()
    }

    /// Whether a pixel is surely creature or surely not before anything was cut.
    fn first_label(&self, lesson: &Lesson, index: usize) -> Option<bool> {
        match lesson.view.known(index) {
            Known::Creature => return Some(true),
            Known::Background => return Some(false),
            Known::Nothing => {}
        }
        let place = lesson.view.place(index)?;
        let limb = usize::from(place.limb);
        let distance = place.offset.abs() * self.factor as f32 / self.guess[limb];
        let trust = &self.footage.poses[lesson.frame][limb].trust;
        let at = ((place.along * (trust.len() - 1) as f32).round() as usize).min(trust.len() - 1);
        if distance > SURELY_OUT {
            Some(false)
        } else if distance < SURELY_IN {
            (trust[at] >= TRUSTED && place.beyond == 0).then_some(true)
        } else {
            None
        }
    }

    fn learn(&self, lessons: &mut [Lesson]) -> Result<Knowledge, Error> {
        let rounds = self.parameters.rounds as usize;
        let mut knowledge = self.know(lessons, true)?;
        for round in 0..rounds {
            let from = 0.1 + 0.6 * round as f64 / rounds as f64;
            let count = lessons.len() as f64;
            let counted: &[Lesson] = lessons;
            let labels: Vec<Vec<bool>> = counted
                .par_iter()
                .enumerate()
                .map(|(i, lesson)| {
                    self.at(from + 0.6 / rounds as f64 * i as f64 / count)?;
                    let occupancy = (round > 0).then(|| self.occupancy(counted, lesson.frame));
                    self.cut_view(&lesson.view, lesson.frame, &knowledge, occupancy.as_ref())
                })
                .collect::<Result<_, Error>>()?;
            for (lesson, labels) in lessons.iter_mut().zip(labels) {
                lesson.labels = labels;
            }
            // Radii first: cells are counted by the limb that is nearest for its radius.
            if round == 0 {
                lessons.par_iter_mut().try_for_each(|l| self.count(l))?;
                let all = Occupancy::gather(self.guess.len(), lessons.iter().map(|l| (&l.counts, 1.0)));
                let radius = all.radii(2.0 * self.factor as f32);
                lessons.par_iter_mut().try_for_each(|l| {
                    l.view.measure(&self.footage.poses[l.frame], &radius);
                    self.at(0.0)
                })?;
                knowledge.radius = radius;
            }
            lessons.par_iter_mut().try_for_each(|l| self.count(l))?;
            let radius = std::mem::take(&mut knowledge.radius);
            knowledge = self.know(lessons, false)?;
            knowledge.radius = radius;
        }
        Ok(knowledge)
    }

    fn count(&self, lesson: &mut Lesson) -> Result<(), Error> {
        self.at(0.0)?;
        let mut counts = Counts::new(self.guess.len());
        for i in 0..lesson.view.window.len() {
            if let Some(place) = lesson.view.place(i) {
                let weight = if lesson.view.known(i) == Known::Nothing { 1.0 } else { PAINTED };
                counts.add(place.cell(), lesson.labels[i], weight);
            }
        }
        lesson.counts = counts;
        Ok(())
    }

    /// Mixtures of what is labelled so far.
    fn know(&self, lessons: &[Lesson], first: bool) -> Result<Knowledge, Error> {
        let taken: Vec<(Vec<Sample>, Vec<Sample>)> = lessons
            .par_iter()
            .map(|lesson| {
                let label = |i: usize| match first {
                    true => self.first_label(lesson, i),
                    false => Some(lesson.labels[i]),
                };
                self.at(0.0)?;
                Ok(samples(&self.atlas, &lesson.view, 3, label))
            })
            .collect::<Result<_, Error>>()?;
        let components = self.parameters.components as usize;
        let creature = fit(&thin(taken.iter().flat_map(|(c, _)| c).copied().collect()), components);
        let groups: Vec<_> = taken.chunks(SCENE).zip(lessons.chunks(SCENE)).collect();
        let models: Vec<Models> = groups
            .par_iter()
            .map(|(taken, _)| {
                self.at(0.0)?;
                let background = thin(taken.iter().flat_map(|(_, b)| b).copied().collect());
                Ok(Models::new(creature.clone(), fit(&background, components)))
            })
            .collect::<Result<_, Error>>()?;
        let times = groups.iter().map(|(_, l)| 0.5 * (l[0].frame + l[l.len() - 1].frame) as f32).collect();
        Ok(Knowledge { models, times, radius: Vec::new() })
    }

    /// Chances around the limbs, seen from `frame`.
    fn occupancy(&self, lessons: &[Lesson], frame: usize) -> Occupancy {
        let memory = self.parameters.memory;
        let weighed = lessons.iter().map(|l| {
            let away = (l.frame as f32 - frame as f32) / memory;
            (&l.counts, (-0.5 * away * away).exp() + 0.05)
        });
        Occupancy::gather(self.guess.len(), weighed)
    }

    /// What is known of one pixel.
    fn say(&self, view: &View, index: usize, colour: [u8; 3], models: &Models, occupancy: Option<&Occupancy>) -> Say {
        match view.known(index) {
            Known::Creature => return Say::Fixed(true),
            Known::Background => return Say::Fixed(false),
            Known::Nothing => {}
        }
        let Some(place) = view.place(index) else { return Say::Fixed(false) };
        let limb = usize::from(place.limb);
        let distance = place.offset.abs() * self.factor as f32 / self.guess[limb];
        let guess = (1.5 * (1.0 - distance)).clamp(-2.0, 1.0);
        let start = 1.0 / (1.0 + (-guess).exp());
        let chance = occupancy.map_or(start, |o| o.chance(place.cell(), start, DOUBT)).clamp(0.01, 0.99);
        let shape = (chance / (1.0 - chance)).ln();
        let as_creature = self.atlas.on_creature(colour, &place, self.factor as f32);
        let as_background = self.atlas.in_picture(colour, centre(view, index));
        let looks = models.evidence(&as_creature, &as_background).clamp(-LIMIT, LIMIT);
        Say::Evidence(self.parameters.colour * looks + self.parameters.shape * shape)
    }

    fn models<'k>(&self, knowledge: &'k Knowledge, frame: usize) -> &'k Models {
        let mut best = 0;
        for (i, t) in knowledge.times.iter().enumerate() {
            if (t - frame as f32).abs() < (knowledge.times[best] - frame as f32).abs() {
                best = i;
            }
        }
        &knowledge.models[best]
    }

    fn cut_view(
        &self,
        view: &View,
        frame: usize,
        knowledge: &Knowledge,
        occupancy: Option<&Occupancy>,
    ) -> Result<Vec<bool>, Error> {
        let models = self.models(knowledge, frame);
        let mut says = Vec::with_capacity(view.window.len());
        for i in 0..view.window.len() {
            if i % view.window.width == 0 {
                self.at(0.0)?;
            }
            says.push(self.say(view, i, view.colours[i], models, occupancy));
        }
        let mut labels = cut(view.window.width, &view.colours, &says, self.parameters.smoothness, || (self.go_on)(0.0))
            .ok_or(Error::Cancelled)?;
        tidy(&mut labels, view.window.width, &self.anchors(view, frame), |i| view.known(i) == Known::Nothing);
        Ok(labels)
    }

    /// Blocks of a window that trusted points of limbs lie in.
    fn anchors(&self, view: &View, frame: usize) -> Vec<usize> {
        let w = view.window;
        let pose = &self.footage.poses[frame];
        let trusted = pose.iter().flat_map(|l| l.points.iter().zip(&l.trust)).filter(|(_, t)| **t >= TRUSTED);
        let inside = trusted.filter_map(|(&p, _)| {
            let p = w.inside(p);
            (p.x >= 0.0 && p.y >= 0.0 && p.x < w.width as f32 && p.y < w.height as f32)
                .then(|| p.y as usize * w.width + p.x as usize)
        });
        inside.collect()
    }

    fn cut_all(
        &self,
        lessons: &[Lesson],
        knowledge: &Knowledge,
        put: &(dyn Fn(usize, Vec<u8>) -> Result<(), String> + Sync),
    ) -> Result<(), Error> {
        let n = self.footage.poses.len();
        (0..n)
            .into_par_iter()
            .map(|frame| -> Result<(), Error> {
                self.at(0.7 + 0.3 * frame as f64 / n as f64)?;
                let picture = self.picture(frame)?;
                let view = self.view(frame, &picture, &knowledge.radius);
                let occupancy = self.occupancy(lessons, frame);
                let labels = self.cut_view(&view, frame, knowledge, Some(&occupancy))?;
                let mask = self.sharpen(&view, frame, &picture, &labels, knowledge, &occupancy)?;
                put(frame, mask).map_err(|problem| Error::Frame { frame, problem })
            })
            .collect()
    }

    /// The mask of the frame: blocks' labels, and around their border pixels cut anew.
    fn sharpen(
        &self,
        view: &View,
        frame: usize,
        picture: &[u8],
        labels: &[bool],
        knowledge: &Knowledge,
        occupancy: &Occupancy,
    ) -> Result<Vec<u8>, Error> {
        let w = view.window;
        let mut mask = vec![0u8; self.size.0 * self.size.1];
        let border = near_border(labels, w.width, BAND);
        let known = self.footage.known.get(&frame);
        let models = self.models(knowledge, frame);
        let wide = (w.width * w.factor).min(self.size.0 - w.left * w.factor);
        let high = (w.height * w.factor).min(self.size.1 - w.top * w.factor);
        let (mut says, mut colours) = (vec![Say::Outside(false); wide * high], vec![[0u8; 3]; wide * high]);
        for (i, &label) in labels.iter().enumerate() {
            if i % w.width == 0 {
                self.at(0.0)?;
            }
            let (xs, ys) = w.pixels(i % w.width, i / w.width, self.size);
            for y in ys {
                for x in xs.clone() {
                    let to = (y - w.top * w.factor) * wide + x - w.left * w.factor;
                    let from = y * self.size.0 + x;
                    colours[to] = [picture[3 * from], picture[3 * from + 1], picture[3 * from + 2]];
                    let painted = known.map_or(Known::Nothing, |k| k[from]);
                    says[to] = match (painted, border[i]) {
                        (Known::Creature, _) => Say::Fixed(true),
                        (Known::Background, _) => Say::Fixed(false),
                        (_, 0) => Say::Outside(label),
                        (_, 1) => Say::Fixed(label),
                        _ => self.say(view, i, colours[to], models, Some(occupancy)),
                    };
                }
            }
        }
        let fine = if w.factor == 1 {
            labels.to_vec()
        } else {
            cut(wide, &colours, &says, self.parameters.smoothness, || (self.go_on)(0.0)).ok_or(Error::Cancelled)?
        };
        for y in 0..high {
            for x in 0..wide {
                mask[(y + w.top * w.factor) * self.size.0 + x + w.left * w.factor] = 255 * u8::from(fine[y * wide + x]);
            }
        }
        if let Some(known) = known {
            for (m, k) in mask.iter_mut().zip(known) {
                match k {
                    Known::Creature => *m = 255,
                    Known::Background => *m = 0,
                    Known::Nothing => {}
                }
            }
        }
        Ok(mask)
    }
}

/// For each block: 2 within `reach` of where labels change, 1 beside those, 0 elsewhere.
fn near_border(labels: &[bool], width: usize, reach: usize) -> Vec<u8> {
    let height = labels.len() / width.max(1);
    let mut out = vec![0u8; labels.len()];
    for y in 0..height {
        for x in 0..width {
            let i = y * width + x;
            let right = x + 1 < width && labels[i] != labels[i + 1];
            let below = y + 1 < height && labels[i] != labels[i + width];
            if !right && !below {
                continue;
            }
            for ny in y.saturating_sub(reach)..(y + reach + 2).min(height) {
                for nx in x.saturating_sub(reach)..(x + reach + 2).min(width) {
                    let outer = ny + reach == y || nx + reach == x || ny == y + reach + 1 || nx == x + reach + 1;
                    let value = if outer { 1 } else { 2 };
                    out[ny * width + nx] = out[ny * width + nx].max(value);
                }
            }
        }
    }
    out
}
