//! Meshes deformed through the C ABI.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use std::ptr;

use common::*;
use marey_ffi::mry_status_code::*;
use marey_ffi::*;

const COLUMNS: u32 = 21;
const ROWS: u32 = 5;

/// A bar of squares of ten pixels, and its triangles.
fn bar() -> (Vec<mry_point>, Vec<u32>) {
    let at = |i: u32| mry_point { x: 10.0 * (i % COLUMNS) as f32, y: 10.0 * (i / COLUMNS) as f32 };
    let square = |i: u32| {
        let (a, b) = (i / (COLUMNS - 1) * COLUMNS + i % (COLUMNS - 1), COLUMNS);
        [a, a + 1, a + 1 + b, a, a + 1 + b, a + b]
    };
    ((0..COLUMNS * ROWS).map(at).collect(), (0..(COLUMNS - 1) * (ROWS - 1)).flat_map(square).collect())
}

fn point(x: f32, y: f32) -> mry_handle {
    mry_handle { kind: MRY_HANDLE_POINT, a: mry_point { x, y }, ..mry_handle::default() }
}

fn bone(from: (f32, f32), to: (f32, f32)) -> mry_handle {
    let at = |(x, y)| mry_point { x, y };
    mry_handle { kind: MRY_HANDLE_BONE, reserved0: 0, a: at(from), b: at(to) }
}

fn bind(f: &Fixture, deformer: &str, handles: &[mry_handle]) -> Result<mry_deformation, (mry_status, String)> {
    let (points, triangles) = bar();
    let mut desc = unsafe { std::mem::zeroed::<mry_deform_desc>() };
    unsafe { mry_deform_desc_init(&mut desc, size_of::<mry_deform_desc>() as u32) };
    (desc.points, desc.point_count) = (points.as_ptr(), points.len() as u64);
    (desc.triangles, desc.triangle_count) = (triangles.as_ptr(), triangles.len() as u64 / 3);
    (desc.handles, desc.handle_count) = (handles.as_ptr(), handles.len() as u64);
    desc.deformer = str(deformer);
    let (mut deformation, mut err) = (mry_deformation::default(), error());
    match unsafe { mry_deformation_create(f.context, &desc, &mut deformation, &mut err) } {
        OK => Ok(deformation),
        status => Err((status, text(&err.message))),
    }
}

fn solve(f: &Fixture, deformation: mry_deformation, targets: &[mry_handle], shape: &mut [mry_point]) -> mry_status {
    let start = shape.as_ptr();
    let to = shape.as_mut_ptr();
    unsafe {
        mry_deformation_solve(
            f.context,
            deformation,
            targets.as_ptr(),
            targets.len(),
            start,
            to,
            shape.len(),
            ptr::null_mut(),
        )
    }
}

/// Twice the areas of the triangles, signed.
fn areas(shape: &[mry_point]) -> Vec<f32> {
    let corner = |i: u32| marey::vec2(shape[i as usize].x, shape[i as usize].y);
    let area = |t: &[u32]| (corner(t[1]) - corner(t[0])).perp_dot(corner(t[2]) - corner(t[0]));
    bar().1.chunks_exact(3).map(area).collect()
}

#[test]
fn a_bar_bends_by_points_and_keeps_its_triangles() {
    let f = fixture();
    let held = [point(0.0, 0.0), point(0.0, 40.0), point(200.0, 20.0)];
    let deformation = bind(&f, "", &held).unwrap();
    let (mut shape, rest) = (bar().0, bar().0);
    assert_eq!(solve(&f, deformation, &held, &mut shape), OK);
    let moved = shape.iter().zip(&rest).map(|(a, b)| (a.x - b.x).abs().max((a.y - b.y).abs())).fold(0.0, f32::max);
    assert!(moved < 1e-2, "at rest nothing moves, not by {moved}");
    let bent = [held[0], held[1], point(140.0, 140.0)];
    assert_eq!(solve(&f, deformation, &bent, &mut shape), OK);
    let tip = shape[(2 * COLUMNS + 20) as usize];
    assert!((tip.x - 140.0).abs() < 0.01 && (tip.y - 140.0).abs() < 0.01, "{tip:?}");
    assert!(areas(&shape).iter().all(|a| *a > 0.0), "no triangle turns over");
    assert_eq!(unsafe { mry_deformation_destroy(f.context, deformation) }, OK);
    assert_eq!(solve(&f, deformation, &bent, &mut shape), code(MRY_E_STALE));
}

#[test]
fn needles_keep_the_area_of_a_bar_that_is_stretched() {
    let f = fixture();
    let rest_bone = bone((0.0, 20.0), (200.0, 20.0));
    let deformation = bind(&f, "needles", &[rest_bone]).unwrap();
    let mut shape = bar().0;
    assert_eq!(solve(&f, deformation, &[bone((0.0, 20.0), (270.0, 20.0))], &mut shape), OK);
    let (now, rest): (f32, f32) = (areas(&shape).iter().sum(), areas(&bar().0).iter().sum());
    assert!((now / rest - 1.0).abs() < 0.01, "{now} of {rest}");
    let (_, why) = bind(&f, "needles", &[point(0.0, 0.0)]).unwrap_err();
    assert!(why.contains("bone"), "{why}");
}

#[test]
fn what_makes_no_sense_is_refused_and_changes_nothing() {
    let f = fixture();
    let held = [point(0.0, 0.0), point(200.0, 20.0)];
    let deformation = bind(&f, "arap", &held).unwrap();
    let mut shape = bar().0;
    let before = shape.clone();
    let nan = [point(f32::NAN, 0.0), held[1]];
    let odd = [mry_handle { kind: 7, ..held[0] }, held[1]];
    let bones = [bone((0.0, 0.0), (9.0, 9.0)), held[1]];
    assert_eq!(solve(&f, deformation, &nan, &mut shape), code(MRY_E_NON_FINITE));
    assert_eq!(solve(&f, deformation, &odd, &mut shape), code(MRY_E_ARGUMENT));
    assert_eq!(solve(&f, deformation, &bones, &mut shape), code(MRY_E_INPUT));
    assert_eq!(solve(&f, deformation, &held[..1], &mut shape), code(MRY_E_INPUT));
    assert_eq!(solve(&f, deformation, &held, &mut shape[..9]), code(MRY_E_ARGUMENT));
    shape[3].x = f32::INFINITY;
    assert_eq!(solve(&f, deformation, &held, &mut shape), code(MRY_E_NON_FINITE));
    shape[3] = before[3];
    assert_eq!(shape, before);
    assert_eq!(bind(&f, "magic", &held).unwrap_err().0, code(MRY_E_UNSUPPORTED));

    let (points, mut triangles) = bar();
    let create = |points: &[mry_point], count: u64, triangles: &[u32], iterations| unsafe {
        let mut desc = std::mem::zeroed::<mry_deform_desc>();
        mry_deform_desc_init(&mut desc, size_of::<mry_deform_desc>() as u32);
        (desc.points, desc.point_count, desc.iterations) = (points.as_ptr(), count, iterations);
        (desc.triangles, desc.triangle_count) = (triangles.as_ptr(), triangles.len() as u64 / 3);
        (desc.handles, desc.handle_count) = (held.as_ptr(), 2);
        mry_deformation_create(f.context, &desc, &mut mry_deformation::default(), ptr::null_mut())
    };
    let count = points.len() as u64;
    assert_eq!(create(&points, count, &triangles, 1000), OK);
    assert_eq!(create(&points, count, &triangles, 1001), code(MRY_E_ARGUMENT));
    assert_eq!(create(&points, u64::MAX, &triangles, 0), code(MRY_E_LIMIT));
    assert_eq!(create(&points, count, &[], 0), code(MRY_E_INPUT));
    triangles[4] = 10_000;
    assert_eq!(create(&points, count, &triangles, 0), code(MRY_E_INPUT));
}
