//! What must hold of any deformer of this kind, whatever the mesh.

use glam::{Vec2, vec2};
use moving_least_squares::{Deformation, Error, Falloff, Handle, Settings};
use proptest::prelude::*;

/// A strip of squares, 60 by 20, with a hole's worth of points to spare.
fn strip() -> (Vec<Vec2>, Vec<[u32; 3]>) {
    grid(31, 11, 2.0)
}

fn grid(columns: u32, rows: u32, step: f32) -> (Vec<Vec2>, Vec<[u32; 3]>) {
    let points = (0..columns * rows).map(|i| vec2((i % columns) as f32, (i / columns) as f32) * step).collect();
    let cells = (0..rows - 1).flat_map(|r| (0..columns - 1).map(move |c| r * columns + c));
    let triangles = cells.flat_map(|i| [[i, i + 1, i + columns + 1], [i, i + columns + 1, i + columns]]).collect();
    (points, triangles)
}

fn all_settings() -> impl Iterator<Item = Settings> {
    [Falloff::Gentle, Falloff::Steep]
        .into_iter()
        .flat_map(|falloff| [false, true].map(|inside| Settings { falloff, inside }))
}

fn moved(handles: &[Handle], map: impl Fn(Vec2) -> Vec2) -> Vec<Handle> {
    let one = |h: &Handle| match *h {
        Handle::Point(p) => Handle::Point(map(p)),
        Handle::Bone(a, b) => Handle::Bone(map(a), map(b)),
    };
    handles.iter().map(one).collect()
}

fn solve(settings: Settings, rest: &[Handle], targets: &[Handle]) -> Vec<Vec2> {
    let (mut points, triangles) = strip();
    let bound = Deformation::bind(&points, &triangles, rest, settings, &|_| true).expect("sound input");
    bound.solve(targets, &mut points, &|_| true).expect("the same handles");
    points
}

fn handles() -> impl Strategy<Value = Vec<Handle>> {
    let place = || (0.0..60.0f32, 0.0..20.0f32).prop_map(|(x, y)| vec2(x, y));
    let handle = prop_oneof![
        place().prop_map(Handle::Point),
        (place(), place()).prop_map(|(a, b)| Handle::Bone(a, b)),
        // On a vertex, along an edge, and without length.
        (0..31u32, 0..11u32).prop_map(|(x, y)| Handle::Point(vec2(2.0 * x as f32, 2.0 * y as f32))),
        (0..20u32, 0..11u32).prop_map(|(x, y)| Handle::Bone(
            vec2(2.0 * x as f32, 2.0 * y as f32),
            vec2(2.0 * x as f32 + 20.0, 2.0 * y as f32)
        )),
        place().prop_map(|p| Handle::Bone(p, p)),
    ];
    prop::collection::vec(handle, 1..6)
}

/// Whether two handles share a place, at which no deformation can follow both.
fn overlap(handles: &[Handle]) -> bool {
    let ends = |h: &Handle| match *h {
        Handle::Point(p) => (p, p),
        Handle::Bone(a, b) => (a, b),
    };
    let apart = |a: (Vec2, Vec2), b: (Vec2, Vec2)| {
        (0..=40).all(|i| {
            let p = a.0.lerp(a.1, i as f32 / 40.0);
            (0..=40).all(|j| p.distance(b.0.lerp(b.1, j as f32 / 40.0)) > 1.0)
        })
    };
    (0..handles.len()).any(|i| (0..i).any(|j| !apart(ends(&handles[i]), ends(&handles[j]))))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn handles_at_rest_leave_the_mesh_at_rest(rest in handles()) {
        for settings in all_settings() {
            for (p, q) in strip().0.iter().zip(solve(settings, &rest, &rest)) {
                prop_assert!(p.distance(q) < 2e-3, "{settings:?}: {p} went to {q}");
            }
        }
    }

    #[test]
    fn a_rigid_motion_of_the_handles_is_one_of_the_mesh(
        rest in handles(),
        angle in -3.0..3.0f32,
        shift in (-100.0..100.0f32, -100.0..100.0f32),
    ) {
        // One place says nothing of a turn.
        let ends: Vec<Vec2> = rest.iter().flat_map(|h| match *h { Handle::Point(p) => [p, p], Handle::Bone(a, b) => [a, b] }).collect();
        prop_assume!(ends.iter().any(|p| p.distance(ends[0]) > 2.0));
        prop_assume!(rest.iter().all(|h| !matches!(h, Handle::Bone(a, b) if a == b)) || rest.len() > 2);
        let map = |p: Vec2| Vec2::from_angle(angle).rotate(p) + vec2(shift.0, shift.1);
        for settings in all_settings() {
            for (p, q) in strip().0.iter().zip(solve(settings, &rest, &moved(&rest, map))) {
                prop_assert!(map(*p).distance(q) < 0.02, "{settings:?}: {p} went to {q}, not {}", map(*p));
            }
        }
    }

    #[test]
    fn every_pose_is_finite(rest in handles(), targets in prop::collection::vec((-1e4..1e4f32, -1e4..1e4f32), 12)) {
        let next = std::cell::Cell::new(0);
        let wild = moved(&rest, |_| {
            next.set(next.get() + 1);
            let (x, y) = targets[(next.get() - 1) % 12];
            vec2(x, y)
        });
        for settings in all_settings() {
            prop_assert!(solve(settings, &rest, &wild).iter().all(|p| p.is_finite()));
        }
    }

    #[test]
    fn vertices_on_handles_go_with_them(
        rest in handles(),
        shifts in prop::collection::vec((-20.0..20.0f32, -20.0..20.0f32), 12),
    ) {
        prop_assume!(!overlap(&rest));
        let targets: Vec<Handle> = rest.iter().zip(&shifts).zip(&shifts[6..]).map(|((h, s), t)| match *h {
            Handle::Point(p) => Handle::Point(p + vec2(s.0, s.1)),
            Handle::Bone(a, b) if a == b => Handle::Bone(a + vec2(s.0, s.1), b + vec2(s.0, s.1)),
            Handle::Bone(a, b) => Handle::Bone(a + vec2(s.0, s.1), b + vec2(t.0, t.1)),
        }).collect();
        for settings in all_settings() {
            let shape = solve(settings, &rest, &targets);
            for (p, q) in strip().0.iter().zip(&shape) {
                for (h, to) in rest.iter().zip(&targets) {
                    let expected = match (*h, *to) {
                        (Handle::Point(a), Handle::Point(b)) if a.distance(*p) < 1e-6 => b,
                        (Handle::Bone(a, b), Handle::Bone(c, d)) if a != b => {
                            let t = ((*p - a).dot(b - a) / b.distance_squared(a)).clamp(0.0, 1.0);
                            if a.lerp(b, t).distance(*p) > 1e-6 { continue }
                            c.lerp(d, t)
                        }
                        _ => continue,
                    };
                    prop_assert!(q.distance(expected) < 1e-2, "{settings:?}: {p} went to {q}, not {expected}");
                }
            }
        }
    }
}

#[test]
fn a_vertex_close_beside_a_handle_turns_with_those_far_away() {
    // (0, 14) is so near to the first handle that the others' weight is a 10^-11 of its own.
    let rest = [Handle::Point(vec2(0.0, 13.977)), Handle::Point(Vec2::ZERO), Handle::Point(Vec2::ZERO)];
    let turned = |p: Vec2| Vec2::from_angle(-2.45).rotate(p);
    for settings in all_settings() {
        let q = solve(settings, &rest, &moved(&rest, turned))[7 * 31];
        assert!(q.distance(turned(vec2(0.0, 14.0))) < 1e-4, "{settings:?}: {q}");
    }
}

#[test]
fn near_a_handle_the_shape_comes_near_its_place() {
    let rest = [Handle::Bone(vec2(1.0, 10.01), vec2(29.0, 10.01)), Handle::Point(vec2(59.99, 10.0))];
    let targets = [Handle::Bone(vec2(1.0, 30.0), vec2(29.0, 30.0)), Handle::Point(vec2(70.0, 0.0))];
    for settings in all_settings() {
        let shape = solve(settings, &rest, &targets);
        // (14, 10) is a hundredth from the bone, (60, 10) from the point.
        assert!(shape[5 * 31 + 7].distance(vec2(14.0, 30.0)) < 0.2, "{settings:?}: {}", shape[5 * 31 + 7]);
        assert!(shape[5 * 31 + 30].distance(vec2(70.0, 0.0)) < 0.3, "{settings:?}: {}", shape[5 * 31 + 30]);
    }
}

#[test]
fn an_arm_beside_the_body_does_not_drag_it_when_measured_inside() {
    // A horseshoe: two columns joined at the top, with a gap of one cell between them.
    let (points, triangles) = grid(8, 20, 2.0);
    let gap = |t: &[u32; 3]| {
        let middle = t.iter().map(|&i| points[i as usize]).sum::<Vec2>() / 3.0;
        (6.0..8.0).contains(&middle.x) && middle.y > 6.0
    };
    let triangles: Vec<[u32; 3]> = triangles.into_iter().filter(|t| !gap(t)).collect();
    let rest = [Handle::Bone(vec2(3.0, 2.0), vec2(3.0, 38.0)), Handle::Bone(vec2(11.0, 2.0), vec2(11.0, 38.0))];
    let swung = [rest[0], Handle::Bone(vec2(11.0, 2.0), vec2(46.0, 10.0))];
    let drag = |inside: bool| {
        let settings = Settings { inside, ..Settings::default() };
        let bound = Deformation::bind(&points, &triangles, &rest, settings, &|_| true).expect("sound input");
        let mut shape = points.clone();
        bound.solve(&swung, &mut shape, &|_| true).expect("the same handles");
        let body = points.iter().zip(&shape).filter(|(p, _)| p.x <= 6.0 && p.y > 20.0);
        body.map(|(p, q)| p.distance(*q)).fold(0.0, f32::max)
    };
    let (through_air, inside) = (drag(false), drag(true));
    assert!(inside < 0.3 * through_air, "{inside} against {through_air}");
}

#[test]
fn what_cannot_be_used_is_named() {
    let (points, triangles) = strip();
    let bind = |points: &[Vec2], triangles: &[[u32; 3]], handles: &[Handle]| {
        Deformation::bind(points, triangles, handles, Settings::default(), &|_| true).map(|_| ())
    };
    let one = [Handle::Point(vec2(1.0, 1.0))];
    assert_eq!(bind(&[], &triangles, &one), Err(Error::Empty("vertices")));
    assert_eq!(bind(&points, &[], &one), Err(Error::Empty("triangles")));
    assert_eq!(bind(&points, &triangles, &[]), Err(Error::Empty("handles")));
    assert!(matches!(bind(&points, &[[0, 1, 4000]], &one), Err(Error::Triangle { triangle: 0, vertex: 4000, .. })));
    let nan = [Handle::Point(vec2(f32::NAN, 1.0))];
    assert_eq!(bind(&points, &triangles, &nan), Err(Error::NotFinite { what: "handle", index: 0 }));
    let huge = [vec2(0.0, 0.0), vec2(1e30, 0.0), vec2(0.0, 1.0)];
    assert_eq!(bind(&huge, &[[0, 1, 2]], &one), Err(Error::NotFinite { what: "vertex", index: 1 }));

    let bound = Deformation::bind(&points, &triangles, &one, Settings::default(), &|_| true).expect("sound input");
    let mut shape = points.clone();
    let bone = [Handle::Bone(vec2(0.0, 0.0), vec2(1.0, 0.0))];
    assert!(matches!(bound.solve(&bone, &mut shape, &|_| true), Err(Error::Handles(_))));
    assert!(bound.solve(&nan, &mut shape, &|_| true).is_err());
    assert_eq!(shape, points, "an error leaves the shape alone");
}

#[test]
fn cancels_and_leaves_the_shape() {
    let (points, triangles) = grid(150, 150, 1.0);
    let rest = [Handle::Point(vec2(3.0, 3.0)), Handle::Point(vec2(100.0, 100.0))];
    let stopped = Deformation::bind(&points, &triangles, &rest, Settings::default(), &|_| false);
    assert_eq!(stopped.map(|_| ()), Err(Error::Cancelled));
    let bound = Deformation::bind(&points, &triangles, &rest, Settings::default(), &|_| true).expect("sound input");
    let mut shape = points.clone();
    let targets = [rest[1], rest[0]];
    assert_eq!(bound.solve(&targets, &mut shape, &|done| done < 0.5), Err(Error::Cancelled));
    assert_eq!(shape, points);
}
