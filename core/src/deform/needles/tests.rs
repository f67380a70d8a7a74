use super::*;
use crate::job::Progress;
use glam::vec2;

/// A capsule around the line from `x` 60 to 260, of radius 24.
fn capsule() -> PlaneMesh {
    let arc = |centre: f32, from: f32| {
        (0..24)
            .map(move |i| vec2(centre, 80.0) + 24.0 * Vec2::from_angle(from + i as f32 / 24.0 * std::f32::consts::PI))
    };
    let outline: Vec<Vec2> =
        arc(260.0, -std::f32::consts::FRAC_PI_2).chain(arc(60.0, std::f32::consts::FRAC_PI_2)).collect();
    PlaneMesh::within(&[outline], |_| 6.0)
}

fn bind(deformer: NeedleDeformer, mesh: &PlaneMesh, bones: &[Handle]) -> Needles {
    let rest = RestMesh { points: &mesh.points, triangles: &mesh.triangles };
    Needles::new(&deformer, rest, bones, Progress::new().whole()).expect("binds")
}

fn areas(mesh: &PlaneMesh, points: &[Vec2]) -> Vec<f64> {
    let moved = PlaneMesh { points: points.to_vec(), triangles: mesh.triangles.clone() };
    (0..moved.triangles.len()).map(|t| moved.area(t)).collect()
}

fn arm() -> [Handle; 2] {
    let (a, b, c) = (vec2(60.0, 80.0), vec2(160.0, 80.0), vec2(260.0, 80.0));
    [Handle::Bone(a, b), Handle::Bone(b, c)]
}

#[test]
fn stretch_keeps_the_area_by_the_rule() {
    let mesh = capsule();
    let total = |points: &[Vec2]| areas(&mesh, points).iter().sum::<f64>();
    let rest = total(&mesh.points);
    let bones = [Handle::Bone(vec2(60.0, 80.0), vec2(260.0, 80.0))];
    for longer in [0.5, 1.35, 2.5] {
        let target = [Handle::Bone(vec2(60.0, 80.0), vec2(60.0, 80.0 + 200.0 * longer))];
        let area = |area| {
            let mut points = mesh.points.clone();
            let mut needles = bind(NeedleDeformer { area, ..NeedleDeformer::default() }, &mesh, &bones);
            needles.solve(&target, &mut points, Progress::new().whole()).expect("solves");
            (
                total(&points) / rest,
                areas(&mesh, &points)
                    .iter()
                    .zip(areas(&mesh, &mesh.points))
                    .map(|(a, b)| (a / b - 1.0).abs())
                    .fold(0.0, f64::max),
            )
        };
        let (exact, worst) = area(AreaRule::Exact);
        assert!((exact - 1.0).abs() < 1e-4 && worst < 1e-2, "{exact} {worst}");
        // The body keeps its area, and the caps change by the square of the needles' change.
        let caps = std::f64::consts::PI * 24.0 * 24.0 / rest;
        let wished = 1.0 - caps + caps / f64::from(longer * longer);
        assert!((area(AreaRule::Reciprocal).0 - wished).abs() < 0.02, "{} {wished}", area(AreaRule::Reciprocal).0);
        let wished = (1.0 - caps) * f64::from(longer) + caps;
        assert!((area(AreaRule::Off).0 - wished).abs() < 0.02);
    }
}

#[test]
fn bends_fold_nothing_keep_the_area_and_never_raise_the_energy() {
    let mesh = capsule();
    let mut needles = bind(NeedleDeformer::default(), &mesh, &arm());
    let rest: f64 = areas(&mesh, &mesh.points).iter().sum();
    for degrees in [-90.0f32, -40.0, 0.0, 15.0, 60.0, 90.0, 110.0] {
        let tip = vec2(160.0, 80.0) + 100.0 * Vec2::from_angle(degrees.to_radians());
        let target = [arm()[0], Handle::Bone(vec2(160.0, 80.0), tip)];
        let mut points = mesh.points.clone();
        needles.solve(&target, &mut points, Progress::new().whole()).expect("solves");
        let bent = areas(&mesh, &points);
        assert!(bent.iter().all(|a| *a > 0.0), "{degrees}");
        assert!((bent.iter().sum::<f64>() / rest - 1.0).abs() < 0.015, "{degrees} {}", bent.iter().sum::<f64>() / rest);
        let settled = needles.settled();
        assert!(settled.areas.iter().all(|a| a.energies.windows(2).all(|e| e[1] < e[0])));
        assert!(settled.iterations() <= 15 && settled.flipped() == 0);
        assert_eq!(settled.iterations() == 0, degrees == 0.0);
        if degrees == 0.0 {
            assert!(points.iter().zip(&mesh.points).all(|(a, b)| a.distance(*b) < 1e-3));
        }
    }
}

#[test]
fn weights_change_the_shape_and_stage_one_alone_is_the_blend() {
    let mesh = capsule();
    let target = [arm()[0], Handle::Bone(vec2(160.0, 80.0), vec2(160.0, 180.0))];
    let shape = |outline_weight, joint_areas| {
        let mut needles =
            bind(NeedleDeformer { outline_weight, joint_areas, ..NeedleDeformer::default() }, &mesh, &arm());
        let mut points = mesh.points.clone();
        needles.solve(&target, &mut points, Progress::new().whole()).expect("solves");
        (points, needles.stage_one(&target).expect("places"))
    };
    assert_ne!(shape(0.1, true).0, shape(0.9, true).0);
    let (points, first) = shape(0.5, false);
    assert_eq!(points, first);
}

#[test]
fn a_bone_without_length_moves_and_one_that_vanishes_leaves_numbers() {
    let mesh = capsule();
    let bones = [
        arm()[0],
        Handle::Bone(vec2(160.0, 80.0), vec2(160.0, 80.0)),
        Handle::Bone(vec2(160.0, 80.0), vec2(260.0, 80.0)),
    ];
    let mut needles = bind(NeedleDeformer::default(), &mesh, &bones);
    let mut points = mesh.points.clone();
    let moved = bones.map(|b| b.map(|p| p + vec2(30.0, -9.0)));
    needles.solve(&moved, &mut points, Progress::new().whole()).expect("solves");
    assert!(points.iter().zip(&mesh.points).all(|(a, b)| a.distance(*b + vec2(30.0, -9.0)) < 1e-2));
    let vanished = bones.map(|b| b.map(|_| vec2(100.0, 100.0)));
    needles.solve(&vanished, &mut points, Progress::new().whole()).expect("solves");
    assert!(points.iter().all(|p| p.is_finite()));
}

#[test]
fn what_cannot_be_bound_or_solved_is_refused_by_name() {
    let mesh = capsule();
    let rest = RestMesh { points: &mesh.points, triangles: &mesh.triangles };
    let progress = Progress::new();
    let bind = |rest: RestMesh<'_>, handles: &[Handle]| match NeedleDeformer::default().bind(
        rest,
        handles,
        progress.whole(),
    ) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    assert!(bind(rest, &[]).contains("none"));
    assert!(bind(rest, &[Handle::Point(vec2(1.0, 1.0))]).contains("is a point"));
    assert!(bind(rest, &[Handle::Bone(vec2(1.0, 1.0), vec2(f32::NAN, 1.0))]).contains("not a number"));
    assert!(bind(RestMesh { points: &mesh.points, triangles: &[] }, &arm()).contains("no triangles"));
    assert!(bind(RestMesh { points: &mesh.points[..2], triangles: &mesh.triangles }, &arm()).contains("not there"));
    let mut needles = Needles::new(&NeedleDeformer::default(), rest, &arm(), progress.whole()).expect("binds");
    let mut points = mesh.points.clone();
    assert!(needles.solve(&arm()[..1], &mut points, progress.whole()).is_err());
    assert!(needles.solve(&arm(), &mut points[1..], progress.whole()).is_err());
    progress.cancel();
    let bent = [arm()[0], Handle::Bone(vec2(160.0, 80.0), vec2(160.0, 180.0))];
    assert!(matches!(needles.solve(&bent, &mut points, progress.whole()), Err(Error::Cancelled)));
    assert_eq!(points, mesh.points);
}
