//! The pose that the skin is built in: the rest pose with its limbs moved apart in depth.
//!
//! Limbs that cross or touch in the rest frame would melt into one surface, though other frames show them apart. Each
//! limb is shifted along the view's direction, growing from its joint outward and carried on to what hangs from it,
//! until its cross-sections clear those that it touches in the rest frame only. The image does not change, so masks hold
//! in this pose as in the rest frame. What touches in nearly all frames, as a shoulder does the chest, is left to melt.
//!
//! Limit: in a clip of one frame nothing tells a touch from a joint, so nothing is moved.

use super::super::limb::LimbShape;
use super::super::path::hip_ramp;

/// Rounds of pushing, and how much of what is missing each makes good: all pairs settle in under thirty.
const ROUNDS: usize = 60;
const STEP: f32 = 0.5;
/// About so many places a limb are looked at.
const PLACES: usize = 48;
/// At most so many frames, evenly over the clip, are asked whether two places stay together.
const WITNESSES: usize = 24;
/// Places that are clear of each other in more than this share of them only touch.
const CLEAR: f32 = 0.2;
/// A place that takes less than this share of its limb's push is at the joint.
const JOINT: f32 = 0.4;

/// A cross-section for telling whether limbs touch.
#[derive(Clone, Copy)]
struct Disc {
    /// Middle in the image, y down.
    at: glam::Vec2,
    z: f32,
    /// Half the width and half the depth.
    half: glam::Vec2,
    /// How much of its limb's own push it takes.
    ramp: f32,
    sample: usize,
}

/// The limbs in one frame only, `rest`, moved apart in depth with `gap` between them.
pub(super) fn apart(limbs: &[LimbShape], order: &[usize], rest: usize, gap: f32) -> Vec<LimbShape> {
    let mut out: Vec<LimbShape> = limbs
        .iter()
        .map(|l| {
            let mut one = l.clone();
            one.axis.frames = vec![l.axis.frames[rest].clone()];
            one.axis.visible = vec![l.axis.visible[rest].clone()];
            one.z = vec![l.z[rest].clone()];
            one
        })
        .collect();
    let discs: Vec<Vec<Disc>> = out.iter().map(discs).collect();
    let touching = touching(&discs, limbs, order, gap);
    let push = pushes(&touching, limbs, gap);
    for &l in order {
        let base = inherited(limbs, &push, l);
        let limb = &mut out[l];
        for i in 0..limb.z[0].len() {
            limb.z[0][i] += base + push[l] * hip_ramp(limb.axis.share(i as f32));
        }
    }
    out
}

/// The push that a limb takes from those that it hangs from.
fn inherited(limbs: &[LimbShape], push: &[f32], limb: usize) -> f32 {
    let (mut at, mut sum) = (limb, 0.0);
    // Bounded, should parents ever go round.
    for _ in 0..limbs.len() {
        let Some((parent, at_end)) = limbs[at].trunk else { break };
        sum += if at_end { push[parent] } else { 0.0 };
        at = parent;
    }
    sum
}

fn discs(limb: &LimbShape) -> Vec<Disc> {
    let normals = limb.normals(0);
    let (first, last) = super::super::tube::covered(limb);
    let step = ((last - first) / PLACES).max(1);
    (first..=last)
        .step_by(step)
        .map(|i| Disc {
            at: limb.axis.frames[0][i] + normals[i] * limb.shift(i),
            z: limb.z[0][i],
            half: glam::vec2(limb.half_width(i), limb.half_width(i) * limb.depth_ratio[i]),
            ramp: hip_ramp(limb.axis.share(i as f32)),
            sample: i,
        })
        .collect()
}

/// Two places that touch in the rest frame only.
struct Touch {
    limbs: [usize; 2],
    discs: [Disc; 2],
    /// Whether the first hangs from the second, which then stays.
    trunk: bool,
}

fn touching(discs: &[Vec<Disc>], limbs: &[LimbShape], order: &[usize], gap: f32) -> Vec<Touch> {
    let ancestors: Vec<Vec<usize>> = (0..limbs.len()).map(|l| ancestors(limbs, l)).collect();
    let frames = limbs.first().map_or(0, |l| l.axis.frames.len());
    let witnesses: Vec<usize> = (0..frames).step_by(frames.div_ceil(WITNESSES).max(1)).collect();
    let inside = |p: &Disc, q: &Disc| {
        let (flat, deep) = (p.at.distance(q.at) / q.half.x.max(1e-3), (p.z - q.z) / q.half.y.max(1e-3));
        flat * flat + deep * deep < 1.0
    };
    let mut out = Vec::new();
    for (rank, &a) in order.iter().enumerate() {
        for &b in &order[..rank] {
            let trunk = ancestors[a].contains(&b);
            let buried = |p: &Disc, own: usize, other: usize| {
                ancestors[own].iter().any(|&t| t != other && discs[t].iter().any(|q| inside(p, q)))
            };
            // Whether a place of one limb is clear of all of the other in many frames.
            let parts = |p: &Disc, own: usize, other: usize| {
                let clear = witnesses.iter().filter(|&&f| {
                    let at = limbs[own].axis.frames[f][p.sample];
                    discs[other]
                        .iter()
                        .all(|q| at.distance(limbs[other].axis.frames[f][q.sample]) > p.half.x + q.half.x + gap)
                });
                clear.count() as f32 > CLEAR * witnesses.len() as f32
            };
            let loose = |own: usize, other: usize| -> Vec<&Disc> {
                let free = |p: &&Disc| p.ramp > JOINT && !buried(p, own, other) && parts(p, own, other);
                discs[own].iter().filter(free).collect()
            };
            let others = if trunk { discs[b].iter().collect() } else { loose(b, a) };
            for p in loose(a, b) {
                for q in &others {
                    if p.at.distance(q.at) < p.half.x + q.half.x + gap {
                        out.push(Touch { limbs: [a, b], discs: [*p, **q], trunk });
                    }
                }
            }
        }
    }
    out
}

/// What a limb hangs from, and what that hangs from.
pub(super) fn ancestors(limbs: &[LimbShape], limb: usize) -> Vec<usize> {
    let mut out = Vec::new();
    let mut at = limbs[limb].trunk;
    while let Some((p, _)) = at.filter(|(p, _)| !out.contains(p)) {
        out.push(p);
        at = limbs[p].trunk;
    }
    out
}

/// How far each limb is shifted so that all that touches clears.
fn pushes(touching: &[Touch], limbs: &[LimbShape], gap: f32) -> Vec<f32> {
    let mut push = vec![0.0f32; limbs.len()];
    for _ in 0..ROUNDS {
        let base: Vec<f32> = (0..limbs.len()).map(|l| inherited(limbs, &push, l)).collect();
        let place = |l: usize, d: &Disc| d.z + base[l] + push[l] * d.ramp;
        // The largest that is missing in either direction counts.
        let mut change = vec![[0.0f32; 2]; limbs.len()];
        for Touch { limbs: [a, b], discs: [p, q], trunk } in touching {
            let share = p.at.distance(q.at) / (p.half.x + q.half.x + gap);
            let wanted = (p.half.y + q.half.y) * (1.0 - share * share).max(0.0).sqrt() + gap;
            let between = place(*a, p) - place(*b, q);
            let missing = STEP * (wanted - between.abs());
            if missing > 0.0 {
                let (up, part) = (usize::from(between >= 0.0), if *trunk { 1.0 } else { 0.5 });
                change[*a][up] = change[*a][up].max(missing * part);
                if !trunk {
                    change[*b][1 - up] = change[*b][1 - up].max(missing * part);
                }
            }
        }
        if change.iter().flatten().all(|c| *c < 0.05) {
            break;
        }
        push.iter_mut().zip(&change).for_each(|(p, c)| *p += c[1] - c[0]);
    }
    push
}
