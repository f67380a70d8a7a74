use super::*;
use crate::job::Progress;
use glam::vec2;

/// A bar of `columns` by `rows` squares of 8 pixels at `at`.
fn bar(at: Vec2, columns: u32, rows: u32, lines: Vec<Line>) -> Layer {
    let index = |x: u32, y: u32| y * (columns + 1) + x;
    let points = (0..=rows).flat_map(|y| (0..=columns).map(move |x| at + 8.0 * vec2(x as f32, y as f32)));
    let squares = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let triangles = squares.flat_map(|(x, y)| {
        let [a, b, c, d] = [index(x, y), index(x + 1, y), index(x + 1, y + 1), index(x, y + 1)];
        if (x + y) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    });
    Layer { points: points.collect(), triangles: triangles.collect(), lines }
}

fn farthest(a: &Shape, b: &Shape) -> f32 {
    let points = a.points.iter().flatten().zip(b.points.iter().flatten());
    let lines = a.lines.iter().flatten().flatten().zip(b.lines.iter().flatten().flatten());
    points.chain(lines).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn what_moves_rigidly_moves_as_one() {
    let line = Line { points: vec![vec2(110.0, 60.0), vec2(300.0, 90.0)], closed: false, rigidity: 30.0 };
    let handles = [vec2(104.0, 70.0), vec2(200.0, 71.0), vec2(330.0, 80.0)];
    let progress = Progress::new();
    let mesh = StrokeMesh::new(&[bar(vec2(100.0, 50.0), 30, 6, vec![line])], &[], progress.whole()).expect("a mesh");
    let mut bound = mesh.bind(&handles.map(|h| (0, h)), progress.whole()).expect("binds");
    let turn = Vec2::from_angle(2.0);
    let map = |p: Vec2| turn.rotate(p - vec2(40.0, 90.0)) + vec2(300.0, 20.0);
    let mut shape = bound.rest();
    let mut wished = shape.clone();
    let lines = wished.lines.iter_mut().flatten().flatten();
    wished.points.iter_mut().flatten().chain(lines).for_each(|p| *p = map(*p));
    bound.solve(&handles.map(map), &mut shape, progress.whole()).expect("solves");
    assert!(farthest(&shape, &wished) < 1e-3, "{}", farthest(&shape, &wished));
}

fn line(points: &[Vec2], rigidity: f32) -> Line {
    Line { points: points.to_vec(), closed: false, rigidity }
}

fn circle(middle: Vec2, radius: f32, rigidity: f32) -> Line {
    let points = (0..24).map(|i| middle + radius * Vec2::from_angle(i as f32 / 24.0 * std::f32::consts::TAU)).collect();
    Line { points, closed: true, rigidity }
}

fn bound(layers: &[Layer], ties: &[Tie], handles: &[(usize, Vec2)]) -> BoundStrokes {
    let progress = Progress::new();
    let mesh = StrokeMesh::new(layers, ties, progress.whole()).expect("a mesh");
    mesh.bind(handles, progress.whole()).expect("binds")
}

fn solved(bound: &mut BoundStrokes, targets: &[Vec2], from: &Shape) -> Shape {
    let mut shape = from.clone();
    bound.solve(targets, &mut shape, Progress::new().whole()).expect("solves");
    shape
}

/// A long bar that is bent over a quarter circle, with a straight line and a circle on it.
fn bent(rigidity: f32) -> (BoundStrokes, Vec<Vec2>) {
    let lines =
        vec![line(&[vec2(130.0, 66.0), vec2(230.0, 66.0)], rigidity), circle(vec2(300.0, 75.0), 14.0, rigidity)];
    let handles: Vec<(usize, Vec2)> = [0.0, 0.33, 0.66, 1.0].map(|s| (0, vec2(104.0 + 232.0 * s, 74.0))).into();
    let targets = handles.iter().map(|(_, p)| {
        let angle = (p.x - 104.0) / 232.0 * std::f32::consts::FRAC_PI_2;
        vec2(104.0, 74.0) + 148.0 * vec2(angle.sin(), 1.0 - angle.cos())
    });
    let targets = targets.collect();
    (bound(&[bar(vec2(100.0, 50.0), 30, 6, lines)], &[], &handles), targets)
}

/// Root mean square of the change of edges.
fn strain(rest: &[Vec2], now: &[Vec2]) -> f32 {
    let squares =
        rest.windows(2).zip(now.windows(2)).map(|(r, n)| (n[0].distance(n[1]) / r[0].distance(r[1]) - 1.0).powi(2));
    (squares.sum::<f32>() / (rest.len() - 1) as f32).sqrt()
}

#[test]
fn stiffer_lines_keep_more_of_their_shape_and_handles_are_hit() {
    let mut last = (f32::INFINITY, f32::INFINITY);
    for rigidity in [0.0, 0.3, 10.0, 1000.0] {
        let (mut bent, targets) = bent(rigidity);
        let rest = bent.rest();
        let shape = solved(&mut bent, &targets, &rest);
        let [straight, round] = [0, 1].map(|k| (&rest.lines[0][k], &shape.lines[0][k]));
        let strained = strain(round.0, round.1);
        let (a, b) = (straight.1[0], straight.1[1]);
        let middle = bent.rest().lines[0][0][0].lerp(rest.lines[0][0][1], 0.5);
        let nearest = (0..rest.points[0].len())
            .min_by(|&i, &j| rest.points[0][i].distance(middle).total_cmp(&rest.points[0][j].distance(middle)))
            .expect("a vertex");
        // How far the vertex at its middle is off the straight way between its ends.
        let off = |p: Vec2, a: Vec2, b: Vec2| (b - a).normalize().perp_dot(p - a);
        let sag = off(shape.points[0][nearest], a, b)
            - off(rest.points[0][nearest], rest.lines[0][0][0], rest.lines[0][0][1]);
        assert!(strained < last.0 && sag.abs() < last.1, "{rigidity}: {strained} {sag} after {last:?}");
        last = (strained, sag.abs());
        let hung = bent.pins.at(1, &bent.start(&shape));
        assert!(bent.prepared.outer(hung).distance(targets[1]) < 0.01);
    }
    assert!(last.0 < 0.002 && last.1 < 0.5, "{last:?}");
}

#[test]
fn any_rigidity_takes_few_steps_that_only_go_down() {
    for rigidity in [0.1, 1.0, 10.0, 100.0, 1000.0] {
        let (mut bent, targets) = bent(0.0);
        let rest = bent.rest();
        let flat = solved(&mut bent, &targets, &rest);
        (0..2).for_each(|k| bent.set_rigidity(0, k, rigidity).expect("a line"));
        bent.set_effort(Effort { steps: 500, tolerance: 0.0 });
        let far = |bent: &mut BoundStrokes, from: &Shape| {
            solved(bent, &targets, from);
            bent.settled().energies.clone()
        };
        let least = far(&mut bent, &rest).last().copied().expect("energies");
        bent.set_effort(Effort::default());
        for from in [&rest, &flat] {
            let energies = far(&mut bent, from);
            assert!(energies.windows(2).all(|w| w[1] <= w[0]), "{energies:?}");
            assert!(
                energies.len() <= 11 && energies[energies.len() - 1] < 1.01 * least,
                "{rigidity}: {energies:?} {least}"
            );
        }
    }
}

#[test]
fn one_handle_carries_and_no_handle_leaves() {
    let layer = || bar(vec2(100.0, 50.0), 12, 4, vec![line(&[vec2(110.0, 60.0), vec2(180.0, 70.0)], 1.0)]);
    let mut one = bound(&[layer(), layer()], &[], &[(0, vec2(131.0, 63.0))]);
    let rest = one.rest();
    let mut shape = rest.clone();
    for way in [vec2(30.0, -200.0), vec2(1e4, 1e4)] {
        one.solve(&[vec2(131.0, 63.0) + way], &mut shape, Progress::new().whole()).expect("solves");
        let moved = |a: &[Vec2], b: &[Vec2]| a.iter().zip(b).map(|(a, b)| (*b - *a).distance(way)).fold(0.0, f32::max);
        assert!(moved(&rest.points[0], &shape.points[0]) < 5e-3, "{}", moved(&rest.points[0], &shape.points[0]));
        assert!(moved(&rest.lines[0][0], &shape.lines[0][0]) < 5e-3);
        assert_eq!(rest.points[1], shape.points[1]);
    }
    let mut none = bound(&[layer()], &[], &[]);
    let mut moved = one.rest();
    moved.points.pop();
    moved.points[0].iter_mut().for_each(|p| *p += 7.0);
    none.solve(&[], &mut moved, Progress::new().whole()).expect("solves");
    assert_eq!(moved.points[0], rest.points[0]);
}

#[test]
fn ties_hold_and_carry() {
    let stiff = |at: Vec2| bar(at, 12, 4, vec![line(&[at + 4.0, at + vec2(90.0, 20.0)], 100.0)]);
    let layers = [stiff(vec2(100.0, 50.0)), stiff(vec2(180.0, 50.0)), stiff(vec2(180.0, 60.0))];
    let ties = [Tie { layers: [0, 1], at: vec2(188.0, 66.0) }, Tie { layers: [2, 1], at: vec2(250.0, 75.0) }];
    let handles = [(0, vec2(110.0, 66.0)), (0, vec2(150.0, 66.0)), (1, vec2(270.0, 60.0))];
    let mut tied = bound(&layers, &ties, &handles);
    let rest = tied.rest();
    let targets = [vec2(90.0, 90.0), vec2(120.0, 120.0), vec2(300.0, 40.0)];
    let shape = solved(&mut tied, &targets, &rest);
    let u = tied.start(&shape);
    for (i, gap) in tied.prepared.terms.tie_gaps(&u).into_iter().enumerate() {
        assert!(gap / tied.prepared.scale < 0.5, "tie {i}: {gap}");
    }
    let way =
        |layer: usize| shape.points[layer].iter().zip(&rest.points[layer]).map(|(a, b)| a.distance(*b)).sum::<f32>();
    assert!(way(2) > 10.0 * rest.points[2].len() as f32 * 0.5, "{}", way(2));
}

#[test]
fn any_targets_give_a_shape() {
    let (mut bent, _) = bent(3.0);
    let rest = bent.rest();
    let mut shape = rest.clone();
    let same = vec2(200.0, 80.0);
    for targets in [
        [same; 4],
        [vec2(1e4, -1e4), vec2(-1e4, 3.0), vec2(0.0, 1e4), same],
        [vec2(336.0, 74.0), vec2(260.0, 74.0), vec2(180.0, 74.0), vec2(104.0, 74.0)],
        [vec2(1e30, 0.0), same, same, same],
    ] {
        bent.solve(&targets, &mut shape, Progress::new().whole()).expect("solves");
        let all = shape.points.iter().flatten().chain(shape.lines.iter().flatten().flatten());
        assert!(all.into_iter().all(|p| p.is_finite()), "{targets:?}");
    }
    let twice = [(0, vec2(140.0, 74.0)), (0, vec2(140.0, 74.0)), (0, vec2(300.0, 74.0))];
    let mut twice = bound(&[bar(vec2(100.0, 50.0), 30, 6, Vec::new())], &[], &twice);
    let targets = [vec2(140.0, 64.0), vec2(140.0, 84.0), vec2(300.0, 74.0)];
    let rest = twice.rest();
    assert!(farthest(&solved(&mut twice, &targets, &rest), &rest) < 1.0);
}

#[test]
fn odd_lines_hang_on_the_mesh() {
    let at = vec2(100.0, 50.0);
    let lines = vec![
        line(&[], 1.0),
        line(&[at + 5.0], 10.0),
        line(&[at + 5.0, at + 5.0, at + 5.0], 1000.0),
        line(&[at - 200.0, at + vec2(40.0, -30.0), at + vec2(40.0, 5.0)], 1.0),
        line(&[at + 5.0, at + vec2(60.0, 20.0), at + 5.0], 1.0),
        Line { points: vec![at + 2.0, at + vec2(2.5, 2.0)], closed: true, rigidity: 1.0 },
    ];
    let handles = [(0, at), (0, at + vec2(500.0, 10.0))];
    let mut odd = bound(&[bar(at, 12, 4, lines.clone())], &[], &handles);
    let rest = odd.rest();
    for (line, own) in lines.iter().zip(&rest.lines[0]) {
        assert!(line.points.iter().zip(own).all(|(a, b)| a.distance(*b) < 1e-2), "{line:?} {own:?}");
    }
    let turn = Vec2::from_angle(0.7);
    let shape = solved(&mut odd, &handles.map(|(_, p)| turn.rotate(p - at) + at), &rest);
    assert!(shape.lines.iter().flatten().flatten().all(|p| p.is_finite()));
    assert_eq!(shape.lines[0].iter().map(Vec::len).collect::<Vec<_>>(), [0, 1, 3, 3, 3, 2]);
}

#[test]
fn bad_input_is_refused_and_a_cancel_changes_nothing() {
    let progress = Progress::new();
    let good = bar(vec2(0.0, 0.0), 4, 4, vec![line(&[vec2(1.0, 1.0), vec2(9.0, 9.0)], 1.0)]);
    let new = |layer: Layer| StrokeMesh::new(&[good.clone(), layer], &[], progress.whole()).map(|_| ());
    let refused = |layer: Layer| matches!(new(layer), Err(Error::Invalid { what, .. }) if what.starts_with("layer 1"));
    assert!(refused(Layer { triangles: Vec::new(), ..good.clone() }));
    assert!(refused(Layer { points: Vec::new(), ..good.clone() }));
    assert!(refused(Layer { points: vec![Vec2::NAN; 25], ..good.clone() }));
    assert!(refused(Layer { lines: vec![line(&[Vec2::INFINITY], 1.0)], ..good.clone() }));
    for rigidity in [-1.0, 1001.0, f32::NAN] {
        assert!(refused(Layer { lines: vec![line(&[Vec2::ONE], rigidity)], ..good.clone() }), "{rigidity}");
    }
    assert!(StrokeMesh::new(&[], &[], progress.whole()).is_err());
    for layers in [[0, 0], [0, 2]] {
        let tie = Tie { layers, at: Vec2::ONE };
        assert!(StrokeMesh::new(&[good.clone(), good.clone()], &[tie], progress.whole()).is_err());
    }
    let mut mesh = StrokeMesh::new(&[good], &[], progress.whole()).expect("a mesh");
    assert!(mesh.set_rigidity(0, 1, 1.0).is_err() && mesh.set_rigidity(1, 0, 1.0).is_err());
    assert!(mesh.bind(&[(1, Vec2::ONE)], progress.whole()).is_err());
    assert!(mesh.bind(&[(0, Vec2::NAN)], progress.whole()).is_err());
    let mut bound = mesh.bind(&[(0, Vec2::ONE), (0, vec2(30.0, 30.0))], progress.whole()).expect("binds");
    let rest = bound.rest();
    let mut shape = rest.clone();
    let targets = [vec2(5.0, 1.0), vec2(60.0, 0.0)];
    assert!(bound.solve(&targets[..1], &mut shape, progress.whole()).is_err());
    assert!(bound.solve(&[Vec2::NAN; 2], &mut shape, progress.whole()).is_err());
    assert!(bound.solve(&targets, &mut Shape::default(), progress.whole()).is_err());
    let late = Progress::new();
    late.cancel();
    assert!(matches!(bound.solve(&targets, &mut shape, late.whole()), Err(Error::Cancelled)));
    assert_eq!(shape, rest);
}

#[test]
fn a_solve_is_the_same_on_any_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let (mut bent, targets) = bent(5.0);
            let rest = bent.rest();
            solved(&mut bent, &targets, &rest)
        })
    };
    assert_eq!(on(1), on(4));
}

#[test]
fn lines_that_only_follow_are_no_worse_beside_stiff_ones() {
    let at = vec2(100.0, 50.0);
    let strained = |rigidity: f32| {
        let middle = |k: usize| at + vec2(40.0 + 40.0 * k as f32, 24.0);
        let lines = (0..5).map(|k| circle(middle(k), 14.0, if k % 2 == 0 { rigidity } else { 0.0 })).collect();
        let handles = [0.0, 80.0, 160.0, 240.0].map(|x| (0, at + vec2(x, 24.0)));
        let mut stretched = bound(&[bar(at, 30, 6, lines)], &[], &handles);
        let rest = stretched.rest();
        let shape = solved(&mut stretched, &handles.map(|(_, p)| vec2(100.0 + 1.35 * (p.x - 100.0), p.y)), &rest);
        let of = |k: usize| strain(&rest.lines[0][k], &shape.lines[0][k]);
        [of(0) + of(2) + of(4), of(1) + of(3)]
    };
    let (plain, tagged) = (strained(0.0), strained(1.0));
    assert!(tagged[0] < 0.25 * plain[0] && tagged[1] <= plain[1], "{plain:?} {tagged:?}");
}
