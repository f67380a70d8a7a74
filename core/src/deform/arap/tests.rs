use super::*;
use crate::job::Progress;
use glam::vec2;

/// A bar of `columns` by `rows` squares of 8 pixels, at (100, 50).
fn bar(columns: u32, rows: u32) -> (Vec<Vec2>, Vec<[u32; 3]>) {
    let at = |x: u32, y: u32| y * (columns + 1) + x;
    let points =
        (0..=rows).flat_map(|y| (0..=columns).map(move |x| vec2(100.0 + 8.0 * x as f32, 50.0 + 8.0 * y as f32)));
    let squares = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let triangles = squares.flat_map(|(x, y)| {
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
        if (x + y) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    });
    (points.collect(), triangles.collect())
}

fn solve(mesh: &(Vec<Vec2>, Vec<[u32; 3]>), iterations: usize, from: &[Handle], to: &[Handle]) -> Vec<Vec2> {
    let progress = Progress::new();
    let rest = RestMesh { points: &mesh.0, triangles: &mesh.1 };
    let mut bound = ArapDeformer { iterations }.bind(rest, from, progress.whole()).expect("binds");
    let mut points = mesh.0.clone();
    bound.solve(to, &mut points, progress.whole()).expect("solves");
    points
}

fn areas(points: &[Vec2], triangles: &[[u32; 3]]) -> Vec<f32> {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| points[v as usize]);
        0.5 * (b - a).perp_dot(c - a)
    };
    triangles.iter().map(area).collect()
}

/// The energy by its definition, from singular values.
fn energy(rest: &(Vec<Vec2>, Vec<[u32; 3]>), points: &[Vec2]) -> f64 {
    let map = |t: &[u32; 3], p: &[Vec2]| {
        let [a, b, c] = t.map(|v| p[v as usize].as_dvec2());
        glam::DMat2::from_cols(b - a, c - a)
    };
    rest.1
        .iter()
        .map(|t| {
            let from = map(t, &rest.0);
            let j = map(t, points) * from.inverse();
            let turned = glam::dvec2(j.x_axis.x + j.y_axis.y, j.x_axis.y - j.y_axis.x);
            let frobenius = j.x_axis.length_squared() + j.y_axis.length_squared();
            0.5 * from.determinant().abs() * (frobenius + 2.0 - 2.0 * turned.length())
        })
        .sum()
}

fn farthest(a: &[Vec2], b: &[Vec2]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn what_does_not_move_stays_and_what_moves_rigidly_moves_as_one() {
    let mesh = bar(30, 6);
    let handles = [Handle::Point(vec2(103.0, 71.0)), Handle::Bone(vec2(200.0, 73.0), vec2(330.0, 75.0))];
    assert!(farthest(&solve(&mesh, 10, &handles, &handles), &mesh.0) < 1e-3);
    let turn = Vec2::from_angle(2.0);
    let map = |p: Vec2| turn.rotate(p - vec2(40.0, 90.0)) + vec2(300.0, 20.0);
    let moved = solve(&mesh, 10, &handles, &handles.map(|h| h.map(map)));
    let wished: Vec<Vec2> = mesh.0.iter().map(|p| map(*p)).collect();
    assert!(farthest(&moved, &wished) < 0.02, "{}", farthest(&moved, &wished));
}

#[test]
fn ten_steps_end_near_the_least_energy_with_handles_in_place_and_nothing_turned_over() {
    for mesh in [bar(40, 6), bar(120, 18)] {
        let width = mesh.0.iter().map(|p| p.x).fold(0.0, f32::max) - 100.0;
        let height = mesh.0.iter().map(|p| p.y).fold(0.0, f32::max) - 50.0;
        let at = |s: f32| vec2(100.3 + s * width, 50.1 + 0.5 * height);
        let from: Vec<Handle> = [0.02, 0.35, 0.66, 0.97].map(|s| Handle::Point(at(s))).into();
        let poses = [
            [vec2(0.0, 0.0), vec2(0.0, 0.0), vec2(-0.08, 0.28), vec2(-0.4, 0.35)],
            [0.0, 0.12, 0.23, 0.34].map(|s| vec2(s, 0.0)),
        ];
        for pose in poses {
            let to: Vec<Handle> = from.iter().zip(pose).map(|(h, way)| h.map(|p| p + way * width)).collect();
            let ten = solve(&mesh, 10, &from, &to);
            let many = solve(&mesh, 300, &from, &to);
            assert!(
                energy(&mesh, &ten) < 1.1 * energy(&mesh, &many),
                "{} {}",
                energy(&mesh, &ten),
                energy(&mesh, &many)
            );
            assert!(areas(&ten, &mesh.1).iter().all(|a| *a > 0.0));
            // A point between vertices is where the point of its triangle is.
            for (h, wish) in from.iter().zip(&to) {
                let (Handle::Point(h), Handle::Point(wish)) = (h, wish) else { continue };
                let found = mesh.1.iter().find_map(|t| {
                    let [a, b, c] = t.map(|v| mesh.0[v as usize]);
                    let area = (b - a).perp_dot(c - a);
                    let w = [
                        (b - *h).perp_dot(c - *h) / area,
                        (c - *h).perp_dot(a - *h) / area,
                        (a - *h).perp_dot(b - *h) / area,
                    ];
                    w.iter()
                        .all(|w| *w >= 0.0)
                        .then(|| t.iter().zip(w).map(|(&v, w)| ten[v as usize] * w).sum::<Vec2>())
                });
                assert!(found.expect("inside").distance(*wish) < 0.01 * width / 100.0);
            }
        }
    }
}

#[test]
fn a_shape_at_rest_under_its_handles_is_kept_by_the_next_solve() {
    let mesh = bar(60, 8);
    let from = [Handle::Point(vec2(100.0, 82.0)), Handle::Point(vec2(340.0, 82.0)), Handle::Point(vec2(580.0, 82.0))];
    let to = [from[0], from[1], Handle::Point(vec2(420.0, 290.0))];
    let progress = Progress::new();
    let rest = RestMesh { points: &mesh.0, triangles: &mesh.1 };
    let mut bound = ArapDeformer { iterations: 60 }.bind(rest, &from, progress.whole()).expect("binds");
    let mut points = mesh.0.clone();
    bound.solve(&to, &mut points, progress.whole()).expect("solves");
    let settled = points.clone();
    bound.solve(&to, &mut points, progress.whole()).expect("solves");
    assert!(farthest(&settled, &points) < 0.05, "{}", farthest(&settled, &points));
}

#[test]
fn a_piece_without_handles_stays_and_orientation_does_not_matter() {
    let (mut points, mut triangles) = bar(10, 3);
    let second = points.len() as u32;
    triangles.extend(bar(10, 3).1.iter().map(|t| t.map(|v| v + second)));
    points.extend(bar(10, 3).0.iter().map(|p| *p + vec2(0.0, 300.0)));
    let from = [Handle::Point(points[0]), Handle::Point(points[10])];
    let to = [from[0], Handle::Point(vec2(110.0, 120.0))];
    let moved = solve(&(points.clone(), triangles.clone()), 10, &from, &to);
    assert!(farthest(&moved[second as usize..], &points[second as usize..]) < 1e-3);
    let mirrored: Vec<[u32; 3]> = triangles.iter().map(|t| [t[0], t[2], t[1]]).collect();
    assert!(farthest(&moved, &solve(&(points, mirrored), 10, &from, &to)) < 1e-2);
}

#[test]
fn the_same_bits_again() {
    let mesh = bar(50, 9);
    let from = [Handle::Point(vec2(100.0, 82.0)), Handle::Bone(vec2(340.0, 82.0), vec2(470.0, 90.0))];
    let to = [from[0], Handle::Bone(vec2(300.0, 182.0), vec2(330.0, 290.0))];
    assert_eq!(solve(&mesh, 10, &from, &to), solve(&mesh, 10, &from, &to));
}

#[test]
fn what_cannot_be_bound_is_refused_by_name() {
    let (points, triangles) = bar(6, 3);
    let progress = Progress::new();
    let bind = |points: &[Vec2], triangles: &[[u32; 3]], handles: &[Handle]| match ArapDeformer::default().bind(
        RestMesh { points, triangles },
        handles,
        progress.whole(),
    ) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    assert!(bind(&points, &[], &[]).contains("no triangle with an area"));
    assert!(bind(&[], &[], &[]).contains("no triangle with an area"));
    assert!(bind(&points, &[[0, 1, 999]], &[]).contains("triangle 0"));
    assert!(bind(&[vec2(f32::NAN, 0.0); 3], &[[0, 1, 2]], &[]).contains("vertex 0"));
    assert!(bind(&[vec2(1.0, 1.0); 3], &[[0, 1, 2]], &[]).contains("no triangle with an area"));
    let mut turned = triangles.clone();
    turned[4].swap(0, 1);
    assert!(bind(&points, &turned, &[]).contains("triangle 4"));
    assert!(bind(&points, &triangles, &[Handle::Point(vec2(900.0, 900.0))]).contains("handle 0"));
    assert!(bind(&points, &triangles, &[Handle::Bone(vec2(900.0, 900.0), vec2(950.0, 900.0))]).contains("outside"));
    assert!(bind(&points, &triangles, &[Handle::Point(vec2(f32::INFINITY, 0.0))]).contains("not a number"));
    // No handle at all: everything stays.
    assert_eq!(bind(&points, &triangles, &[]), "");
}

#[test]
fn after_an_error_the_shape_is_as_it_was() {
    let mesh = bar(6, 3);
    let progress = Progress::new();
    let rest = RestMesh { points: &mesh.0, triangles: &mesh.1 };
    let from = [Handle::Point(mesh.0[0])];
    let mut bound = ArapDeformer::default().bind(rest, &from, progress.whole()).expect("binds");
    let mut points = mesh.0.clone();
    for wrong in [vec![], vec![Handle::Bone(mesh.0[0], mesh.0[1])], vec![Handle::Point(vec2(0.0, f32::NAN))]] {
        assert!(bound.solve(&wrong, &mut points, progress.whole()).is_err());
    }
    assert!(bound.solve(&from, &mut points[1..], progress.whole()).is_err());
    progress.cancel();
    assert!(matches!(
        bound.solve(&[Handle::Point(vec2(0.0, 9.0))], &mut points, progress.whole()),
        Err(Error::Cancelled)
    ));
    assert_eq!(points, mesh.0);
}

#[test]
fn two_handles_on_one_spot_go_midway_and_a_bone_without_length_holds_its_spot() {
    let mesh = bar(20, 6);
    let at = mesh.0[70];
    let from = [Handle::Point(mesh.0[0]), Handle::Point(at), Handle::Point(at), Handle::Bone(mesh.0[20], mesh.0[20])];
    let to = [from[0], Handle::Point(at + vec2(0.0, 10.0)), Handle::Point(at + vec2(0.0, 20.0)), from[3]];
    let moved = solve(&mesh, 10, &from, &to);
    assert!(moved[70].distance(at + vec2(0.0, 15.0)) < 1e-3);
    assert!(moved[20].distance(mesh.0[20]) < 1e-3);
}
