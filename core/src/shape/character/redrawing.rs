//! A stretch of the silhouette drawn anew.
//!
//! Pan and Zhang 2011, section 3.4: the curve's ends pick the nearest places of the contour, and every vertex between them
//! keeps its needle's direction and takes the length that reaches the curve. Needles that miss the curve take the change
//! of those around them. What lies inside the contour follows as rigidly as it can, so that nothing folds.
//!
//! Known limits: of the two ways round the contour the one nearer to the curve is meant; a needle that crosses the curve
//! several times takes the crossing nearest to its tip.

use glam::Vec2;

use super::Poser;
use crate::deform::arap::ArapDeformer;
use crate::deform::{Deformer, Handle, RestMesh};
use crate::error::{Error, Result};
use crate::geometry::{PlaneMesh, polygon, polyline};
use crate::job::Stage;

/// Places of the curve and of the contour that are compared to tell the way round.
const COMPARED: usize = 24;
/// Vertices that move less than this, in pixels, stay.
const STILL: f32 = 1e-3;

impl Poser {
    /// What to add to a key's [`super::KeyPose::moved`] so that the silhouette follows `curve` between its ends: for
    /// each vertex that moves, how far. `points` are the vertices as they are now, with the joints at `joints`.
    ///
    /// # Errors
    /// Another number of joints or points, a curve without length or with a place that is not a number, a curve too
    /// short to hold a vertex of the silhouette, one that no needle meets, a cancel.
    pub fn redrawn(
        &self,
        joints: &[Vec2],
        points: &[Vec2],
        curve: &[Vec2],
        stage: Stage<'_>,
    ) -> Result<Vec<(u32, Vec2)>> {
        self.count(joints)?;
        if points.len() != self.vertices() {
            let problem = format!("are {} and the mesh has {}", points.len(), self.vertices());
            return Err(Error::invalid("vertices", problem, "give each vertex its place"));
        }
        if curve.iter().chain(joints).chain(points).any(|p| !p.is_finite()) {
            return Err(Error::invalid("curve", "or the pose has a place that is not a number", "draw it again"));
        }
        let length = polyline::length(curve);
        if !(length > 0.0 && length.is_finite()) {
            return Err(Error::invalid("curve", "has no length", "draw a line along the silhouette"));
        }
        let rims = PlaneMesh { points: points.to_vec(), triangles: self.triangles().to_vec() }.rims();
        let stretch = stretch(&rims, points, curve)
            .ok_or_else(|| Error::invalid("curve", "spans no vertex of the silhouette", "draw a longer line"))?;
        let remedy = "draw it from the silhouette to the silhouette, on one side of the limb";
        let tips = self
            .tips(joints, points, &stretch, curve)
            .ok_or_else(|| Error::invalid("curve", "is met by no needle of the silhouette", remedy))?;
        let target = |v: u32| stretch.iter().position(|s| *s == v).map(|i| tips[i]);
        let rim: Vec<u32> = rims.iter().flatten().copied().collect();
        let at_rest: Vec<Handle> = rim.iter().map(|v| Handle::Point(points[*v as usize])).collect();
        let moved: Vec<Handle> = rim.iter().map(|v| Handle::Point(target(*v).unwrap_or(points[*v as usize]))).collect();
        let shape = RestMesh { points, triangles: self.triangles() };
        let mut bound = ArapDeformer::default().bind(shape, &at_rest, stage.part(0.0, 0.5))?;
        let mut after = points.to_vec();
        bound.solve(&moved, &mut after, stage.part(0.5, 1.0))?;
        // The contour is where it was drawn, whatever the deformer made of its handles.
        rim.iter().for_each(|v| after[*v as usize] = target(*v).unwrap_or(points[*v as usize]));
        let way =
            |(v, (new, old)): (usize, (&Vec2, &Vec2))| (new.distance(*old) > STILL).then(|| (v as u32, *new - *old));
        Ok(after.iter().zip(points).enumerate().filter_map(way).collect())
    }

    /// Where the needles of the vertices of `stretch` reach the curve; `None` where none does.
    fn tips(&self, joints: &[Vec2], points: &[Vec2], stretch: &[u32], curve: &[Vec2]) -> Option<Vec<Vec2>> {
        let bones = self.skeleton().segments(joints);
        let needle = |v: u32| {
            let tip = points[v as usize];
            let (a, b) = bones[self.bone_of(v) as usize];
            let foot = polygon::nearest_on_segment(a, b, tip).1;
            (foot, tip - foot)
        };
        // For each vertex, its needle's new length over its old one.
        let reached: Vec<Option<f32>> = stretch
            .iter()
            .map(|v| {
                let (foot, way) = needle(*v);
                let near = |a: &f32, b: &f32| (a - 1.0).abs().total_cmp(&(b - 1.0).abs());
                curve.windows(2).filter_map(|w| crossing(foot, way, w[0], w[1])).min_by(near)
            })
            .collect();
        let known: Vec<usize> = (0..reached.len()).filter(|i| reached[*i].is_some()).collect();
        let (&first, &last) = known.first().zip(known.last())?;
        let share = |i: usize| {
            let at = |i: usize| reached[i].unwrap_or(1.0);
            match known.binary_search(&i) {
                Ok(_) => at(i),
                // Before the first and after the last crossing the change fades to none at the stretch's end.
                Err(0) => 1.0 + (at(first) - 1.0) * (i + 1) as f32 / (first + 1) as f32,
                Err(k) if k == known.len() => {
                    1.0 + (at(last) - 1.0) * (reached.len() - i) as f32 / (reached.len() - last) as f32
                }
                Err(k) => {
                    let (before, after) = (known[k - 1], known[k]);
                    let t = (i - before) as f32 / (after - before) as f32;
                    at(before) + (at(after) - at(before)) * t
                }
            }
        };
        let needles = stretch.iter().map(|v| needle(*v));
        Some(needles.enumerate().map(|(i, (foot, way))| foot + way * share(i)).collect())
    }
}

/// How far along `way` from `foot` the segment is met, in lengths of `way`.
fn crossing(foot: Vec2, way: Vec2, a: Vec2, b: Vec2) -> Option<f32> {
    let along = b - a;
    let turn = way.perp_dot(along);
    if turn == 0.0 {
        return None;
    }
    let (t, s) = ((a - foot).perp_dot(along) / turn, (a - foot).perp_dot(way) / turn);
    // A needle does not point the other way, and does not vanish.
    (t > 1e-3 && (0.0..=1.0).contains(&s)).then_some(t)
}

/// The vertices of one rim between those nearest to the curve's ends, the way round that is nearer to the curve.
fn stretch(rims: &[Vec<u32>], points: &[Vec2], curve: &[Vec2]) -> Option<Vec<u32>> {
    let (start, end) = (*curve.first()?, *curve.last()?);
    let gap = |rim: &Vec<u32>, p: Vec2| {
        rim.iter().map(|v| points[*v as usize].distance(p)).enumerate().min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let rim = rims.iter().min_by(|a, b| {
        let both = |rim: &Vec<u32>| gap(rim, start).map_or(f32::INFINITY, |g| g.1) + gap(rim, end).map_or(0.0, |g| g.1);
        both(a).total_cmp(&both(b))
    })?;
    let (from, to) = (gap(rim, start)?.0, gap(rim, end)?.0);
    let n = rim.len();
    let ahead: Vec<u32> = (0..=(to + n - from) % n).map(|i| rim[(from + i) % n]).collect();
    let back: Vec<u32> = (0..=(from + n - to) % n).map(|i| rim[(from + n - i) % n]).collect();
    let drawn = polyline::resample(curve, COMPARED);
    let far = |way: &Vec<u32>| {
        let places: Vec<Vec2> = way.iter().map(|v| points[*v as usize]).collect();
        polyline::resample(&places, COMPARED).iter().zip(&drawn).map(|(a, b)| a.distance(*b)).sum::<f32>()
    };
    let way = if far(&ahead) <= far(&back) { ahead } else { back };
    // The ends lie where they are.
    (way.len() > 2).then(|| way[1..way.len() - 1].to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deform::needles::NeedleDeformer;
    use crate::job::Progress;
    use crate::shape::character::{Character, Joint, Skeleton};
    use glam::vec2;

    /// A bar along one bone, 200 long and 40 wide.
    fn bar() -> Character {
        let outline = vec![vec2(0.0, 0.0), vec2(200.0, 0.0), vec2(200.0, 40.0), vec2(0.0, 40.0)];
        let joints = [10.0, 190.0].map(|x| Joint { name: format!("{x}"), at: vec2(x, 20.0) }).to_vec();
        let skeleton = Skeleton { joints, bones: vec![[0, 1]] };
        Character::new((200, 40), PlaneMesh::within(&[outline], |_| 6.0), skeleton).expect("a character")
    }

    fn redrawn(curve: &[Vec2]) -> Result<(Character, Vec<(u32, Vec2)>)> {
        let (own, progress) = (bar(), Progress::new());
        let poser = own.poser(&NeedleDeformer::default(), progress.whole())?;
        let moved = poser.redrawn(&own.skeleton.rest(), &own.mesh.points, curve, progress.whole())?;
        Ok((own, moved))
    }

    #[test]
    fn a_bulge_is_followed_along_the_needles_and_nothing_folds() {
        for (height, way) in [(-22.0, "out"), (12.0, "in")] {
            let arc: Vec<Vec2> = (0..=40)
                .map(|i| {
                    let t = i as f32 / 40.0;
                    vec2(60.0 + 80.0 * t, height * (std::f32::consts::PI * t).sin())
                })
                .collect();
            for curve in [arc.clone(), arc.iter().rev().copied().collect()] {
                let (mut own, moved) = redrawn(&curve).expect("followed");
                let top: Vec<u32> = (0..own.mesh.points.len() as u32)
                    .filter(|v| own.mesh.points[*v as usize].y < 0.1)
                    .filter(|v| (70.0..130.0).contains(&own.mesh.points[*v as usize].x))
                    .collect();
                assert!(top.len() > 6);
                let rest = own.mesh.points.clone();
                moved.iter().for_each(|(v, by)| own.mesh.points[*v as usize] += *by);
                for v in top {
                    let now = own.mesh.points[v as usize];
                    // Needles stand upright on this bone.
                    assert!((now.x - rest[v as usize].x).abs() < 1e-3, "{way}");
                    let wished = height * (std::f32::consts::PI * (now.x - 60.0) / 80.0).sin();
                    assert!((now.y - wished).abs() < 0.2, "{way} {now} {wished}");
                }
                for (p, q) in rest.iter().zip(&own.mesh.points).filter(|(p, _)| p.y > 39.9) {
                    assert_eq!(p, q, "the other side stays");
                }
                assert!((0..own.mesh.triangles.len()).all(|t| own.mesh.area(t) > 0.0), "{way}");
                // What lies inside follows.
                assert!(moved.iter().any(|(v, _)| (5.0..35.0).contains(&rest[*v as usize].y)));
            }
        }
    }

    #[test]
    fn what_is_no_curve_is_refused_by_name() {
        for (curve, problem) in [
            (vec![], "no length"),
            (vec![vec2(60.0, 0.0)], "no length"),
            (vec![vec2(60.0, 0.0), vec2(f32::NAN, 1.0)], "not a number"),
            (vec![vec2(60.0, 0.0), vec2(61.0, 0.0)], "spans no vertex"),
            (vec![vec2(60.0, 900.0), vec2(60.0, -900.0), vec2(-5.0, -900.0)], ""),
        ] {
            match redrawn(&curve) {
                Err(error) => assert!(error.to_string().contains(problem), "{error}"),
                Ok((own, moved)) => assert!(problem.is_empty() && moved.len() <= own.mesh.points.len()),
            }
        }
        let (own, progress) = (bar(), Progress::new());
        let poser = own.poser(&NeedleDeformer::default(), progress.whole()).expect("bound");
        let curve = [vec2(60.0, 0.0), vec2(140.0, 0.0)];
        assert!(poser.redrawn(&[], &own.mesh.points, &curve, progress.whole()).is_err());
        assert!(poser.redrawn(&own.skeleton.rest(), &[], &curve, progress.whole()).is_err());
        progress.cancel();
        let cancelled = poser.redrawn(&own.skeleton.rest(), &own.mesh.points, &curve, progress.whole());
        assert!(matches!(cancelled, Err(Error::Cancelled)));
    }
}
