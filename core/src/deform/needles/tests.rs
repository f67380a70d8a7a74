use super::*;
use crate::job::Progress;
use glam::vec2;

/// A capsule around the line from `x` 60 to 260, of radius 24.
fn capsule() -> PlaneMesh {
    capsule_to(260.0, 6.0)
}

fn capsule_to(end: f32, spacing: f32) -> PlaneMesh {
    let arc = |centre: f32, from: f32| {
        (0..24)
            .map(move |i| vec2(centre, 80.0) + 24.0 * Vec2::from_angle(from + i as f32 / 24.0 * std::f32::consts::PI))
    };
    let outline: Vec<Vec2> =
        arc(end, -std::f32::consts::FRAC_PI_2).chain(arc(60.0, std::f32::consts::FRAC_PI_2)).collect();
    PlaneMesh::within(&[outline], |_| spacing)
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
    let mut steps = 0;
    for degrees in [-90.0f32, -40.0, 0.0, 15.0, 60.0, 90.0, 110.0] {
        let tip = vec2(160.0, 80.0) + 100.0 * Vec2::from_angle(degrees.to_radians());
        let target = [arm()[0], Handle::Bone(vec2(160.0, 80.0), tip)];
        let mut points = mesh.points.clone();
        needles.solve(&target, &mut points, Progress::new().whole()).expect("solves");
        let bent = areas(&mesh, &points);
        assert!(bent.iter().all(|a| *a > 0.0), "{degrees}");
        let off = (bent.iter().sum::<f64>() / rest - 1.0).abs();
        assert!(off < if degrees.abs() <= 90.0 { 0.005 } else { 0.01 }, "{degrees} {off}");
        let settled = needles.settled();
        assert!(settled.areas.iter().all(|a| a.energies.windows(2).all(|e| e[1] < e[0])));
        assert!(settled.iterations() <= 15 && settled.flipped() == 0);
        steps += settled.iterations();
        assert_eq!(settled.iterations() == 0, degrees == 0.0);
        if degrees == 0.0 {
            assert!(points.iter().zip(&mesh.points).all(|(a, b)| a.distance(*b) < 1e-3));
        }
    }
    assert!(steps <= 6 * 8, "{steps}");
}

/// Four joints on a line, the last bone or the last two turned.
fn limb(elbow: f32, wrist: f32) -> [Handle; 3] {
    let turned = |from: Vec2, degrees: f32| from + 100.0 * Vec2::from_angle(degrees.to_radians());
    let (a, b) = (vec2(60.0, 80.0), vec2(160.0, 80.0));
    let c = turned(b, elbow);
    [Handle::Bone(a, b), Handle::Bone(b, c), Handle::Bone(c, turned(c, elbow + wrist))]
}

fn farthest(a: &[Vec2], b: &[Vec2]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn a_drag_folds_nothing_ends_where_a_solve_from_rest_does_and_solves_what_it_bends() {
    let mesh = capsule_to(360.0, 4.0);
    let [mut needles, mut anew] = [0; 2].map(|_| bind(NeedleDeformer::default(), &mesh, &limb(0.0, 0.0)));
    let progress = Progress::new();
    let mut points = mesh.points.clone();
    needles.solve(&limb(0.0, 0.0), &mut points, progress.whole()).expect("solves");
    // Up at the elbow, on at the wrist, and back at once.
    let up = (1..=12).map(|f| (5.0 * f as f32, 0.0));
    let on = (1..=12).map(|f| (60.0, 5.0 * f as f32));
    let back = (1..=12).map(|f| (60.0 - 5.0 * f as f32, 60.0 - 5.0 * f as f32));
    let mut before = (0.0, 0.0);
    for (elbow, wrist) in up.chain(on).chain(back) {
        needles.solve(&limb(elbow, wrist), &mut points, progress.whole()).expect("solves");
        let mut wished = mesh.points.clone();
        anew.solve(&limb(elbow, wrist), &mut wished, progress.whole()).expect("solves");
        assert!(farthest(&points, &wished) < 0.5, "{elbow} {wrist} {}", farthest(&points, &wished));
        assert!(areas(&mesh, &points).iter().all(|a| *a > 0.0));
        let settled = &needles.settled().areas;
        assert_eq!(settled.len(), 2);
        assert!(settled.iter().all(|a| a.iterations <= 10 && a.energies.windows(2).all(|e| e[1] < e[0])));
        let bends = settled.iter().filter(|a| a.iterations > 0).count();
        let moves = usize::from(elbow != before.0) + usize::from(wrist != before.1);
        before = (elbow, wrist);
        assert!(bends <= moves, "{elbow} {wrist} {bends}");
    }
    assert!(farthest(&points, &mesh.points) < 0.5);
}

#[test]
fn the_same_bits_on_any_number_of_threads_and_after_anything() {
    let mesh = capsule_to(360.0, 6.0);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let mut needles = bind(NeedleDeformer::default(), &mesh, &limb(0.0, 0.0));
            let (mut points, mut shapes) = (mesh.points.clone(), Vec::new());
            for degrees in [20.0, 28.0, 37.0] {
                needles.solve(&limb(degrees, -degrees), &mut points, Progress::new().whole()).expect("solves");
                shapes.push(points.clone());
            }
            points.copy_from_slice(&mesh.points);
            needles.solve(&limb(70.0, 10.0), &mut points, Progress::new().whole()).expect("solves");
            shapes.push(points);
            shapes
        })
    };
    let shapes = on(1);
    assert_eq!(shapes, on(3));
    let mut needles = bind(NeedleDeformer::default(), &mesh, &limb(0.0, 0.0));
    let mut points = mesh.points.clone();
    needles.solve(&limb(70.0, 10.0), &mut points, Progress::new().whole()).expect("solves");
    assert_eq!(points, shapes[3]);
    // Too far from the last result to go on from it.
    let cancelled = Progress::new();
    cancelled.cancel();
    assert!(needles.solve(&limb(20.0, 0.0), &mut points, cancelled.whole()).is_err());
    assert_eq!(points, shapes[3]);
    needles.solve(&limb(20.0, -20.0), &mut points, Progress::new().whole()).expect("solves");
    assert_eq!(points, shapes[0]);
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
