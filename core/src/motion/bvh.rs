//! BVH: skeletons and their motion as text, as motion capture tools write it.
//!
//! In: joints in space are laid into the plane by a view; every joint and end site becomes a joint track. Out: joint tracks
//! that are joined as trees, with the turns of their bones about z and their places as channels, so that lengths that
//! change are kept. BVH has y up, some tools' z; tracks have y down.
//!
//! Known limits: out, what is hidden or uncertain is not told.

use std::fmt::Write as _;

use glam::{DMat4, DVec2, DVec3, Vec2};

use super::{Motion, Track, TrackFrame, TrackKind};
use crate::error::{Error, Result};

/// Joints and frames at most: a hundred times what capture systems write.
const MOST: usize = 50_000_000;

/// From where a skeleton in space is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// Along z: x to the right.
    #[default]
    Front,
    /// Along x, from its far end: z to the right.
    Side,
    /// Of a file with z up: x to the right.
    FrontZUp,
    /// Of a file with z up: y to the right.
    SideZUp,
}

struct Node {
    name: String,
    parent: Option<usize>,
    offset: DVec3,
    channels: Vec<Channel>,
}

#[derive(Clone, Copy)]
enum Channel {
    Position(usize),
    Rotation(usize),
}

/// Reads the text of a BVH file as a motion, scaled so that its way and height fit `height` pixels with a margin.
///
/// # Errors
/// What is not BVH, with the line; numbers that are not finite; no frames.
pub fn from_bvh(text: &str, view: View, height: u32) -> Result<Motion> {
    let bad = |line: usize, problem: String| {
        Err(Error::invalid(format!("BVH, line {}", line + 1), problem, "export the file again"))
    };
    let mut nodes: Vec<Node> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    let mut pending: Option<usize> = None;
    let mut lines = text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty());
    let (mut frames, mut step) = (None, None);
    for (n, line) in lines.by_ref() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |w: &str| w.parse::<f64>().ok().filter(|v| v.is_finite());
        match words[..] {
            ["HIERARCHY" | "MOTION"] => {}
            ["ROOT" | "JOINT", ..] | ["End", "Site"] => {
                let parent = open.last().copied();
                let name = match (words[0], parent) {
                    ("End", Some(p)) => format!("{}End", nodes[p].name),
                    ("End", None) => return bad(n, "an end site stands outside any joint".into()),
                    _ if words.len() < 2 => return bad(n, "a joint has no name".into()),
                    _ => words[1..].join(" "),
                };
                if nodes.iter().any(|o| o.name == name) {
                    return bad(n, format!("joint `{name}` appears twice"));
                }
                nodes.push(Node { name, parent, offset: DVec3::ZERO, channels: Vec::new() });
                pending = Some(nodes.len() - 1);
            }
            ["{"] => match pending.take() {
                Some(node) => open.push(node),
                None => return bad(n, "a brace opens without a joint".into()),
            },
            ["}"] => {
                if open.pop().is_none() {
                    return bad(n, "a brace closes that none opened".into());
                }
            }
            ["OFFSET", x, y, z] => match (open.last(), number(x), number(y), number(z)) {
                (Some(&node), Some(x), Some(y), Some(z)) => nodes[node].offset = DVec3::new(x, y, z),
                _ => return bad(n, "an offset is not three numbers within a joint".into()),
            },
            ["CHANNELS", _, ..] => {
                let Some(&node) = open.last() else { return bad(n, "channels stand outside any joint".into()) };
                for word in &words[2..] {
                    let axis = "XYZ".find(&word[..word.len().min(1)]);
                    match (axis, word.get(1..)) {
                        (Some(axis), Some("position")) => nodes[node].channels.push(Channel::Position(axis)),
                        (Some(axis), Some("rotation")) => nodes[node].channels.push(Channel::Rotation(axis)),
                        _ => return bad(n, format!("`{word}` is no channel")),
                    }
                }
            }
            ["Frames:", count] => frames = count.parse::<usize>().ok(),
            ["Frame", "Time:", time] => {
                step = number(time).filter(|t| *t > 0.0);
                break;
            }
            _ => return bad(n, format!("`{}` is not understood", line.trim().chars().take(40).collect::<String>())),
        }
    }
    let (Some(frames), Some(step)) = (frames, step) else {
        return Err(Error::invalid("BVH", "has no frame count or frame time", "export the file again"));
    };
    if nodes.is_empty() || frames == 0 {
        return Err(Error::invalid("BVH", "has no joints or no frames", "export the file again"));
    }
    if frames.saturating_mul(nodes.len()) > MOST {
        let value = frames.saturating_mul(nodes.len()) as u64;
        let remedy = "cut the motion".into();
        return Err(Error::Limit { what: "joints times frames of the BVH".into(), value, max: MOST as u64, remedy });
    }
    let channels: usize = nodes.iter().map(|n| n.channels.len()).sum();
    let mut numbers = lines.flat_map(|(n, l)| l.split_whitespace().map(move |w| (n, w.parse::<f64>().ok())));
    let mut seen: Vec<Vec<DVec2>> = vec![Vec::new(); nodes.len()];
    for frame in 0..frames {
        let mut values = Vec::with_capacity(channels);
        for _ in 0..channels {
            match numbers.next() {
                Some((_, Some(value))) if value.is_finite() => values.push(value),
                Some((n, _)) => return bad(n, "holds what is not a number".into()),
                None => {
                    let problem = format!("ends in frame {frame} of {frames}");
                    return Err(Error::invalid("BVH", problem, "export the file again"));
                }
            }
        }
        let mut values = values.into_iter();
        let mut world: Vec<DMat4> = Vec::with_capacity(nodes.len());
        for (i, node) in nodes.iter().enumerate() {
            let mut place = node.offset;
            let mut turn = DMat4::IDENTITY;
            let mut placed = [false; 3];
            for (channel, value) in node.channels.iter().zip(values.by_ref()) {
                match *channel {
                    Channel::Position(axis) => {
                        // Positions replace the offset: that is how they are written.
                        if !std::mem::replace(&mut placed[axis], true) {
                            place[axis] = 0.0;
                        }
                        place[axis] += value;
                    }
                    Channel::Rotation(axis) => {
                        let axis = [DVec3::X, DVec3::Y, DVec3::Z][axis];
                        turn *= DMat4::from_axis_angle(axis, value.to_radians());
                    }
                }
            }
            let local = DMat4::from_translation(place) * turn;
            let own = node.parent.map_or(local, |p| world[p] * local);
            let at = own.w_axis;
            seen[i].push(match view {
                View::Front => DVec2::new(at.x, -at.y),
                View::Side => DVec2::new(at.z, -at.y),
                View::FrontZUp => DVec2::new(at.x, -at.z),
                View::SideZUp => DVec2::new(at.y, -at.z),
            });
            world.push(own);
        }
    }
    let all = || seen.iter().flatten();
    let (low, high) = all().fold((DVec2::MAX, DVec2::MIN), |(low, high), p| (low.min(*p), high.max(*p)));
    let extent = (high - low).max(DVec2::splat(1e-9));
    let margin = 0.05 * f64::from(height);
    let scale = (f64::from(height) - 2.0 * margin) / extent.y.max(0.2 * extent.x);
    let width = (extent.x * scale + 2.0 * margin).ceil().clamp(1.0, 1e6) as u32;
    let place = |p: DVec2| ((p - low) * scale + margin).as_vec2();
    let tracks = nodes.iter().zip(&seen).map(|(node, places)| Track {
        name: node.name.clone(),
        kind: TrackKind::Joint,
        frames: places.iter().map(|p| TrackFrame::certain(vec![place(*p)])).collect(),
    });
    let bones = nodes.iter().filter_map(|n| n.parent.map(|p| (nodes[p].name.clone(), n.name.clone())));
    Ok(Motion { size: (width, height), fps: 1.0 / step, frames, tracks: tracks.collect(), bones: bones.collect() })
}

/// The joints of `motion` as a BVH file. Strokes and points are left out; joints that hang on nothing become roots.
///
/// # Errors
/// No joint tracks, or bones that close a circle.
pub fn to_bvh(motion: &Motion) -> Result<String> {
    motion.validate()?;
    let tracks: Vec<&Track> = motion.tracks.iter().filter(|t| t.kind == TrackKind::Joint).collect();
    if tracks.is_empty() || motion.frames == 0 {
        return Err(Error::invalid("motion", "has no joint tracks", "BVH holds joints: track or retarget some"));
    }
    let index = |name: &str| tracks.iter().position(|t| t.name == name);
    let parent: Vec<Option<usize>> =
        tracks.iter().map(|t| motion.bones.iter().find(|b| b.1 == t.name).and_then(|b| index(&b.0))).collect();
    let children: Vec<Vec<usize>> =
        (0..tracks.len()).map(|j| (0..tracks.len()).filter(|&k| parent[k] == Some(j)).collect()).collect();
    let at = |j: usize, f: usize| {
        let p: Vec2 = tracks[j].frames[f].points.first().copied().unwrap_or_default();
        DVec2::new(f64::from(p.x), -f64::from(p.y))
    };
    // A joint turns as the bone to its first child does since the first frame.
    let turn = |j: usize, f: usize| -> f64 {
        children[j].first().map_or(0.0, |&k| {
            let (before, after) = (at(k, 0) - at(j, 0), at(k, f) - at(j, f));
            if before.length() > 1e-9 && after.length() > 1e-9 { super::retarget::angle(before, after) } else { 0.0 }
        })
    };
    let mut out = String::from("HIERARCHY\n");
    let mut order = Vec::new();
    for root in (0..tracks.len()).filter(|&j| parent[j].is_none()) {
        hierarchy(root, 0, &parent, &children, &|j| tracks[j].name.clone(), &|j| at(j, 0), &mut out, &mut order);
    }
    if order.len() < tracks.len() {
        return Err(Error::invalid("bones of the motion", "close a circle", "leave one of them out"));
    }
    let _ = write!(out, "MOTION\nFrames: {}\nFrame Time: {:.9}\n", motion.frames, 1.0 / motion.fps.max(1e-6));
    for f in 0..motion.frames {
        let mut line = String::new();
        for &j in &order {
            let (place, before) = match parent[j] {
                Some(p) => (DVec2::from_angle(-turn(p, f)).rotate(at(j, f) - at(p, f)), turn(p, f)),
                None => (at(j, f), 0.0),
            };
            let own = if children[j].is_empty() { 0.0 } else { (turn(j, f) - before).to_degrees() };
            let _ = write!(line, "{:.6} {:.6} 0 {:.8} 0 0 ", place.x, place.y, own);
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }
    Ok(out)
}

fn hierarchy(
    joint: usize,
    depth: usize,
    parent: &[Option<usize>],
    children: &[Vec<usize>],
    name: &impl Fn(usize) -> String,
    at: &impl Fn(usize) -> DVec2,
    out: &mut String,
    order: &mut Vec<usize>,
) {
    let pad = "\t".repeat(depth);
    let offset = parent[joint].map_or(at(joint), |p| at(joint) - at(p));
    let kind = if parent[joint].is_none() { "ROOT" } else { "JOINT" };
    let _ = write!(
        out,
        "{pad}{kind} {}\n{pad}{{\n{pad}\tOFFSET {:.6} {:.6} 0\n{pad}\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n",
        name(joint),
        offset.x,
        offset.y
    );
    order.push(joint);
    for &child in &children[joint] {
        hierarchy(child, depth + 1, parent, children, name, at, out, order);
    }
    if children[joint].is_empty() {
        let _ = write!(out, "{pad}\tEnd Site\n{pad}\t{{\n{pad}\t\tOFFSET 0 0 0\n{pad}\t}}\n");
    }
    let _ = writeln!(out, "{pad}}}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    fn motion() -> Motion {
        let rest = [
            ("hip", vec2(100.0, 90.0)),
            ("knee", vec2(110.0, 140.0)),
            ("foot", vec2(100.0, 190.0)),
            ("hand", vec2(160.0, 100.0)),
        ];
        let track = |(j, (name, at)): (usize, (&str, Vec2))| Track {
            name: name.into(),
            kind: TrackKind::Joint,
            frames: (0..9)
                .map(|f| {
                    let turn = Vec2::from_angle(0.2 * (f * (j + 1)) as f32 % 3.0);
                    TrackFrame::certain(vec![
                        vec2(100.0 + f as f32, 90.0) + turn.rotate(at - vec2(100.0, 90.0)) * (1.0 + 0.02 * f as f32),
                    ])
                })
                .collect(),
        };
        let bones = [("hip", "knee"), ("knee", "foot"), ("hip", "hand")].map(|(a, b)| (a.to_string(), b.to_string()));
        Motion {
            size: (300, 300),
            fps: 24.0,
            frames: 9,
            tracks: rest.into_iter().enumerate().map(track).collect(),
            bones: bones.into(),
        }
    }

    #[test]
    fn a_motion_comes_back_up_to_the_view_of_the_reader() {
        let own = motion();
        let back = from_bvh(&to_bvh(&own).expect("written"), View::Front, 400).expect("read");
        assert_eq!((back.frames, back.bones.len()), (9, 3 + 2));
        assert!((back.fps - 24.0).abs() < 1e-3);
        let at = |m: &Motion, name: &str, f: usize| m.track(name).expect("track").frames[f].points[0];
        // The reader scales and moves the whole: compare with the hip and the foot of the first frame in place.
        let (a, b) = (at(&own, "hip", 0), at(&back, "hip", 0));
        let scale = at(&back, "foot", 0).distance(b) / at(&own, "foot", 0).distance(a);
        for name in ["hip", "knee", "foot", "hand"] {
            for f in 0..9 {
                assert!(at(&back, name, f).distance(b + (at(&own, name, f) - a) * scale) < 2e-3);
            }
        }
    }

    #[test]
    fn rotations_are_composed_in_the_order_of_the_channels() {
        let text = "HIERARCHY\nROOT a\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n JOINT b\n {\n  OFFSET 0 2 0\n  CHANNELS 3 Zrotation Xrotation Yrotation\n  End Site\n  {\n   OFFSET 0 1 0\n  }\n }\n}\nMOTION\nFrames: 2\nFrame Time: 0.04\n0 0 0 0 0 0 0 0 0\n1 0 0 90 0 0 -90 0 0\n";
        let own = from_bvh(text, View::Front, 100).expect("read");
        let at = |name: &str, f: usize| own.track(name).expect("track").frames[f].points[0];
        let unit = at("a", 0).distance(at("b", 0)) / 2.0;
        assert!((at("a", 1) - at("a", 0)).distance(vec2(unit, 0.0)) < 1e-3);
        assert!((at("b", 1) - at("a", 1)).distance(vec2(-2.0 * unit, 0.0)) < 1e-3);
        assert!((at("bEnd", 1) - at("b", 1)).distance(vec2(0.0, -unit)) < 1e-3);
        let lying = text.replace("OFFSET 0 2 0", "OFFSET 0 0 2");
        let own = from_bvh(&lying, View::SideZUp, 100).expect("read");
        let at = |name: &str| own.track(name).expect("track").frames[0].points[0];
        assert!(at("b").y < at("a").y && at("bEnd").x > at("b").x);
    }

    #[test]
    fn damaged_files_are_refused_with_their_line() {
        let good = to_bvh(&motion()).expect("written");
        for (damage, with) in [
            ("OFFSET", "OFFSIDE"),
            ("Zrotation", "Wrotation"),
            ("{", ""),
            ("Frames: 9", "Frames: 99"),
            ("Frame Time: 0", "Frame Time: -1"),
            ("MOTION\n", "MOTION\nFrames: 0\nFrame Time: 1\n"),
        ] {
            assert!(from_bvh(&good.replacen(damage, with, 1), View::Front, 100).is_err(), "{damage}");
        }
        assert!(from_bvh("", View::Front, 100).is_err());
        assert!(from_bvh(&good[..good.len() - 30], View::Front, 100).is_err());
        let mut circle = motion();
        circle.bones.push(("foot".into(), "hip".into()));
        assert!(to_bvh(&circle).is_err());
        circle.tracks.clear();
        assert!(to_bvh(&circle).is_err());
    }
}
