//! Joints that bear no track's name, found beside those that do.
//!
//! An inner joint follows the track where the ways of its outer neighbours' tracks toward the root meet, an outer one the
//! track that hangs on its inner neighbour's and points the same way: so `left_foot` follows `LeftAnkle` where `left_knee`
//! follows `LeftKnee`.

use std::collections::{HashMap, HashSet};

use glam::DVec2;

use super::retarget::{RestSkeleton, SourcePlace};
use super::{Motion, TrackKind};

/// `places` with those of joints that had none and lie beside ones that had.
pub(super) fn completed(
    motion: &Motion,
    skeleton: &RestSkeleton<'_>,
    mut places: Vec<Option<SourcePlace>>,
    reference: usize,
) -> Vec<Option<SourcePlace>> {
    let mut parents: HashMap<&str, &str> = HashMap::new();
    motion.bones.iter().for_each(|(parent, child)| {
        parents.entry(child).or_insert(parent);
    });
    // From a track toward the root; bones may close a circle, which is gone round once.
    let way = |track: &str| -> Vec<&str> {
        let first = parents.get_key_value(track).map(|(own, _)| *own);
        let first = first.or_else(|| motion.track(track).map(|t| t.name.as_str()));
        std::iter::successors(first, |t| parents.get(t).copied()).take(motion.tracks.len()).collect()
    };
    let at = |track: &str| -> Option<DVec2> {
        let own = motion.track(track).filter(|t| t.kind != TrackKind::Stroke)?;
        own.frames.get(reference)?.points.first().map(|p| p.as_dvec2())
    };
    let mut used: HashSet<String> = places.iter().flatten().map(|p| p.track.clone()).collect();
    for &[joint, _] in skeleton.bones.iter().rev() {
        if places[joint].is_some() {
            continue;
        }
        let outer = skeleton.bones.iter().filter(|b| b[0] == joint).filter_map(|b| places[b[1]].as_ref());
        let ways: Vec<Vec<&str>> = outer.map(|p| way(&p.track)).collect();
        let [first, others @ ..] = ways.as_slice() else { continue };
        let meet = first.iter().find(|t| others.iter().all(|way| way.contains(t)));
        if let Some(track) = meet.filter(|t| !others.is_empty() && !used.contains(**t) && at(t).is_some()) {
            used.insert((*track).to_owned());
            places[joint] = Some(SourcePlace::of(track));
        }
    }
    for &[joint, other] in skeleton.bones {
        let (Some(inner), None) = (&places[joint], &places[other]) else { continue };
        let taken: HashSet<&str> = used.iter().flat_map(|t| way(t)).collect();
        let Some(from) = at(&inner.track) else { continue };
        let rest = (skeleton.joints[other].1 - skeleton.joints[joint].1).as_dvec2().normalize_or_zero();
        let hanging = parents.iter().filter(|(child, parent)| **parent == inner.track && !taken.contains(**child));
        let alike = hanging.filter_map(|(child, _)| Some(((at(child)? - from).normalize_or_zero().dot(rest), *child)));
        let best = alike.filter(|a| a.0 > 0.0).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(a.1)));
        if let Some((_, track)) = best {
            used.insert(track.to_owned());
            places[other] = Some(SourcePlace::of(track));
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Track, TrackFrame};
    use glam::{Vec2, vec2};

    #[test]
    fn hands_feet_and_hips_are_found_beside_what_bears_a_name() {
        let tracks = [
            ("Hips", 50.0, 50.0),
            ("LKnee", 40.0, 70.0),
            ("LAnkle", 40.0, 90.0),
            ("LToe", 45.0, 92.0),
            ("RKnee", 60.0, 70.0),
            ("RAnkle", 60.0, 90.0),
            ("Tail", 50.0, 30.0),
        ];
        let track = |&(name, x, y): &(&str, f32, f32)| Track {
            name: name.into(),
            kind: TrackKind::Joint,
            frames: vec![TrackFrame::certain(vec![vec2(x, y)])],
        };
        let bones = [
            ("Hips", "LKnee"),
            ("LKnee", "LAnkle"),
            ("LAnkle", "LToe"),
            ("Hips", "RKnee"),
            ("RKnee", "RAnkle"),
            ("Hips", "Tail"),
        ];
        let motion = Motion {
            size: (100, 100),
            fps: 24.0,
            frames: 1,
            tracks: tracks.iter().map(track).collect(),
            bones: bones.map(|(a, b)| (a.into(), b.into())).to_vec(),
        };
        let joints: Vec<(String, Vec2)> = [
            ("middle", 0.0, 0.0),
            ("lknee", -5.0, 10.0),
            ("lfoot", -5.0, 20.0),
            ("rknee", 5.0, 10.0),
            ("rfoot", 5.0, 20.0),
            ("head", 0.0, -20.0),
            ("hat", 0.0, -30.0),
        ]
        .map(|(n, x, y)| (n.to_owned(), vec2(x, y)))
        .to_vec();
        let skeleton =
            RestSkeleton { joints: &joints, bones: &[[0, 1], [1, 2], [0, 3], [3, 4], [0, 5], [5, 6]], size: (9, 9) };
        let mut places = vec![None; 7];
        (places[1], places[3]) = (Some(SourcePlace::of("LKnee")), Some(SourcePlace::of("RKnee")));
        let found: Vec<Option<String>> =
            completed(&motion, &skeleton, places.clone(), 0).into_iter().map(|p| p.map(|p| p.track)).collect();
        let wished = [Some("Hips"), Some("LKnee"), Some("LAnkle"), Some("RKnee"), Some("RAnkle"), Some("Tail"), None];
        assert_eq!(found, wished.map(|w| w.map(str::to_owned)));
        // Bones that close a circle are not gone round for ever.
        let circle =
            Motion { bones: vec![("LKnee".into(), "RKnee".into()), ("RKnee".into(), "LKnee".into())], ..motion };
        assert_eq!(completed(&circle, &skeleton, places, 0).iter().flatten().count(), 2);
    }
}
