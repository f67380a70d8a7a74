//! Solids of shapes whose measures are known.

use glam::Quat;
use proptest::prelude::*;

use super::*;
use crate::export::print::{stl, three_mf};
use crate::geometry::manifold::volume;
use crate::geometry::triangle_tree::tests::cuboid;
use crate::job::Progress;
use crate::shape::{Bone, SkinnedPart, Transform};

const STILL: Transform = Transform { translation: Vec3::ZERO, rotation: Quat::IDENTITY };

/// A model of boxes in world coordinates (y up), one part each, each in one colour.
fn boxes(all: &[(Vec3, Vec3, [u8; 3])]) -> RiggedModel {
    let parts = all.iter().enumerate().map(|(i, &(low, high, colour))| {
        let (positions, triangles) = cuboid(low, high);
        let n = positions.len();
        SkinnedPart {
            name: format!("part{i}"),
            mesh: TriMesh { normals: vec![Vec3::Z; n], uvs: vec![Vec2::splat(0.5); n], positions, triangles },
            bones: vec![[0; 4]; n],
            weights: vec![[1.0, 0.0, 0.0, 0.0]; n],
            texture: RgbImage::from_pixel(4, 4, image::Rgb(colour)),
        }
    });
    RiggedModel {
        size: (64, 64),
        fps: 25.0,
        bones: vec![Bone { name: "all.0".into(), parent: None }],
        rest: vec![STILL],
        animation: vec![vec![STILL]; 2],
        parts: parts.collect(),
    }
}

/// A body on four legs, one of them shorter, 40 units long.
fn table() -> RiggedModel {
    let leg = |x: f32, z: f32, foot: f32| (Vec3::new(x, foot, z), Vec3::new(x + 3.0, 12.0, z + 3.0), [200, 30, 30]);
    boxes(&[
        (Vec3::new(0.0, 10.0, 0.0), Vec3::new(40.0, 20.0, 14.0), [30, 200, 30]),
        leg(1.0, 1.0, 0.0),
        leg(36.0, 1.0, 0.0),
        leg(1.0, 10.0, 0.0),
        leg(36.0, 10.0, 3.0),
    ])
}

fn made(model: &RiggedModel, options: &SolidOptions) -> Result<Solid> {
    let progress = Progress::new();
    let solid = solid(model, 0, options, progress.whole())?;
    assert_eq!(manifold_defect(solid.positions.len(), &solid.triangles), None);
    assert_eq!(pieces(solid.positions.len(), &solid.triangles).iter().max(), Some(&0), "one piece");
    assert_eq!(solid.colours.len(), solid.positions.len());
    assert!((volume(&solid.positions, &solid.triangles) - solid.report.volume_mm3).abs() < 1e-6);
    let lowest = solid.positions.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
    assert_eq!(lowest, 0.0, "it stands on the bed");
    Ok(solid)
}

fn coarse() -> SolidOptions {
    SolidOptions { size: SolidSize::Longest(40.0), detail: Some(0.5), ..SolidOptions::default() }
}

/// How thick the solid is at a place, along x and y, the less of both.
fn thickness(solid: &Solid, z: f32, x: f32) -> f32 {
    let tree = TriangleTree::new(&solid.positions, &solid.triangles);
    let from = Vec3::new(x, -100.0, z);
    let first = tree.first_hit(from, Vec3::Y, 0.0, 200.0).expect("the ray meets it");
    let second = tree.first_hit(from, Vec3::Y, first.distance + 1e-3, 200.0).expect("and comes out");
    second.distance - first.distance
}

#[test]
fn overlapping_parts_become_one_solid_of_their_size() {
    let solid = made(&table(), &coarse()).expect("a solid");
    let [width, depth, height] = solid.report.size_mm;
    assert!(
        (width - 40.0).abs() < 0.2 && (depth - 14.0).abs() < 0.2 && (height - 20.0).abs() < 0.2,
        "{:?}",
        solid.report
    );
    // The body, and what of the legs is below it.
    let expected = 40.0 * 10.0 * 14.0 + 9.0 * (3.0 * 10.0 + 7.0);
    assert!((solid.report.volume_mm3 / expected - 1.0).abs() < 0.03, "{} for {expected}", solid.report.volume_mm3);
    assert_eq!((solid.report.thickened, solid.report.joined, solid.report.dropped), (0.0, 0, 0));
    // Colours are those of the nearest part: the body above, the legs below.
    for (p, colour) in solid.positions.iter().zip(&solid.colours) {
        if p.z > 12.5 {
            assert_eq!(*colour, [30, 200, 30], "{p}");
        } else if p.z < 9.0 {
            assert_eq!(*colour, [200, 30, 30], "{p}");
        }
    }
}

#[test]
fn size_is_what_was_asked_for() {
    let height = made(&table(), &SolidOptions { size: SolidSize::Height(30.0), ..coarse() }).expect("a solid");
    assert!((height.report.size_mm[2] - 30.0).abs() < 0.2, "{:?}", height.report);
    let unit = made(&table(), &SolidOptions { size: SolidSize::Unit(0.5), ..coarse() }).expect("a solid");
    assert!((unit.report.size_mm[0] - 20.0).abs() < 0.2, "{:?}", unit.report);
}

#[test]
fn thin_parts_become_thick_enough_and_thick_ones_stay() {
    let bar = |t: f32| (Vec3::new(10.0, 4.0, 5.0 - 0.5 * t), Vec3::new(30.0, 5.5, 5.0 + 0.5 * t), [1, 2, 3]);
    let block = |x: f32| (Vec3::new(x, 0.0, 0.0), Vec3::new(x + 10.0, 10.0, 10.0), [9, 9, 9]);
    // A sheet of 0.1 mm between two blocks, thinner than a cell.
    let model = boxes(&[block(0.0), block(30.0), bar(0.1)]);
    let options = SolidOptions { min_thickness: 1.5, ..coarse() };
    let solid = made(&model, &options).expect("a solid");
    assert!(solid.report.thickened > 0.01 && solid.report.joined == 0, "{:?}", solid.report);
    for x in [-8.0, -4.0, 0.0, 3.0, 8.0] {
        let thick = thickness(&solid, 4.75, x);
        assert!(thick > 1.4 && thick < 1.8, "{thick} at {x}");
    }
    let [_, depth, height] = solid.report.size_mm;
    assert!((depth - 10.0).abs() < 0.2 && (height - 10.0).abs() < 0.2, "blocks do not grow: {:?}", solid.report);
    // As it is, the sheet is lost between samples and the blocks are joined by a bar.
    let without = made(&model, &SolidOptions { min_thickness: 0.0, ..coarse() }).expect("a solid");
    assert!(without.report.joined == 1 && without.report.thickened == 0.0, "{:?}", without.report);
}

#[test]
fn loose_bits_are_joined_or_left_out() {
    let block = |x: f32, s: f32| (Vec3::new(x, 0.0, 0.0), Vec3::new(x + s, s, s), [9, 9, 9]);
    let far = made(&boxes(&[block(0.0, 20.0), block(30.0, 10.0)]), &coarse()).expect("a solid");
    assert_eq!((far.report.joined, far.report.dropped), (1, 0));
    assert!((far.report.size_mm[0] - 40.0).abs() < 0.3);
    assert!(far.report.warnings.iter().any(|w| w.contains("joined")));
    let crumb = made(&boxes(&[block(0.0, 20.0), block(38.0, 2.0)]), &coarse()).expect("a solid");
    assert_eq!((crumb.report.joined, crumb.report.dropped), (0, 1));
    assert!(crumb.report.size_mm[0] < 20.5 && crumb.report.warnings.iter().any(|w| w.contains("left out")));
}

#[test]
fn a_hollow_is_filled() {
    let mut model =
        boxes(&[(Vec3::ZERO, Vec3::splat(20.0), [9, 9, 9]), (Vec3::splat(5.0), Vec3::splat(15.0), [9, 9, 9])]);
    // The inner box faces inwards: a hollow.
    model.parts[1].mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let solid = made(&model, &coarse()).expect("a solid");
    assert_eq!(solid.report.filled, 1);
    assert!((solid.report.volume_mm3 / 64000.0 - 1.0).abs() < 0.02, "{}", solid.report.volume_mm3);
}

#[test]
fn a_base_holds_all_feet() {
    let with = made(&table(), &SolidOptions { base: true, ..coarse() }).expect("a solid");
    assert_eq!(with.report.feet, 4);
    let bare = made(&table(), &coarse()).expect("a solid");
    let [width, depth, height] = with.report.size_mm;
    assert!(width > bare.report.size_mm[0] + 1.0 && depth > bare.report.size_mm[1] + 1.0 && height > 20.5);
    // The bed meets the whole plate, and the short leg has its post.
    let flat: Vec<&Vec3> = with.positions.iter().filter(|p| p.z < 0.01).collect();
    let reach = flat.iter().map(|p| p.x).fold(f32::NEG_INFINITY, f32::max);
    assert!(reach > 0.45 * width, "{reach} of {width}");
    assert!(with.colours.contains(&GREY) && with.colours.contains(&[200, 30, 30]));
}

#[test]
fn fewer_triangles_keep_the_form_and_stay_closed() {
    let whole = made(&table(), &coarse()).expect("a solid");
    let few = made(&table(), &SolidOptions { max_triangles: Some(1500), ..coarse() }).expect("a solid");
    assert!(few.report.triangles <= 1500 && whole.report.triangles > 5000);
    assert!((few.report.volume_mm3 / whole.report.volume_mm3 - 1.0).abs() < 0.02);
}

#[test]
fn what_cannot_be_printed_is_refused_with_words() {
    let refused = |model: &RiggedModel, frame: usize, options: &SolidOptions, words: &str| {
        let progress = Progress::new();
        let error = solid(model, frame, options, progress.whole()).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    let table = table();
    refused(&table, 2, &coarse(), "name one of 0 to 1");
    for bad in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
        refused(&table, 0, &SolidOptions { size: SolidSize::Longest(bad), ..coarse() }, "the size");
        refused(&table, 0, &SolidOptions { detail: Some(bad), ..coarse() }, "the detail");
    }
    refused(&table, 0, &SolidOptions { min_thickness: f32::NAN, ..coarse() }, "the least thickness");
    refused(&table, 0, &SolidOptions { max_triangles: Some(3), ..coarse() }, "at least 100");
    refused(&table, 0, &SolidOptions { size: SolidSize::Longest(2.0), ..coarse() }, "allow thinner parts");
    refused(&table, 0, &SolidOptions { size: SolidSize::Longest(1e6), ..coarse() }, "less detail");
    refused(&table, 0, &SolidOptions { detail: Some(1e-6), ..coarse() }, "less detail");
    refused(&boxes(&[]), 0, &coarse(), "has no surface");
    let mut flat = boxes(&[(Vec3::ZERO, Vec3::new(20.0, 20.0, 0.0), [1; 3])]);
    refused(&flat, 0, &coarse(), "holds no volume");
    flat.parts[0].mesh.positions.fill(Vec3::ONE);
    refused(&flat, 0, &coarse(), "measures 0 by 0 by 0");
}

#[test]
fn a_cancel_ends_it_anywhere() {
    let table = table();
    for share in [0.0, 0.05, 0.2, 0.4, 0.6, 0.9] {
        let progress = Progress::new();
        let watched = progress.clone();
        let (stop, ended) = (std::sync::atomic::AtomicBool::new(false), std::sync::atomic::Ordering::Relaxed);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while watched.fraction() < share && !stop.load(ended) {
                    std::thread::yield_now();
                }
                watched.cancel();
            });
            let result = solid(&table, 0, &coarse(), progress.whole());
            stop.store(true, ended);
            // The last share may be over before the cancel is seen.
            assert!(matches!(result, Err(Error::Cancelled)) || share > 0.5, "at {share}");
        });
    }
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| made(&table(), &SolidOptions { base: true, min_thickness: 3.5, ..coarse() }).expect("a solid"))
    };
    assert!(with(1) == with(3));
}

#[test]
fn files_hold_the_solid_to_the_bit() {
    let solid = made(&table(), &SolidOptions { max_triangles: Some(1000), ..coarse() }).expect("a solid");
    let progress = Progress::new();
    let bytes = stl(&solid, progress.whole()).expect("not cancelled");
    assert_eq!(bytes.len(), 84 + 50 * solid.triangles.len());
    assert!(!bytes.starts_with(b"solid"));
    // As a slicer reads it: corners in one place are one vertex.
    let mut places = std::collections::HashMap::new();
    let triangles: Vec<[u32; 3]> = bytes[84..]
        .chunks_exact(50)
        .map(|facet| {
            let number = |i: usize| f32::from_le_bytes(facet[4 * i..4 * i + 4].try_into().expect("four bytes"));
            let normal = Vec3::new(number(0), number(1), number(2));
            assert!((normal.length() - 1.0).abs() < 1e-4, "no facet without an area");
            std::array::from_fn(|corner| {
                let at: [u32; 3] = std::array::from_fn(|axis| (number(3 + 3 * corner + axis) + 0.0).to_bits());
                let next = places.len() as u32;
                *places.entry(at).or_insert(next)
            })
        })
        .collect();
    assert_eq!((manifold_defect(places.len(), &triangles), places.len()), (None, solid.positions.len()));

    let packed = three_mf(&solid, progress.whole()).expect("not cancelled");
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(packed)).expect("a zip");
    let mut text = String::new();
    std::io::Read::read_to_string(&mut archive.by_name("3D/3dmodel.model").expect("the model"), &mut text)
        .expect("text");
    let attribute = |line: &str, name: &str| -> f32 {
        let rest = &line[line.find(&format!(" {name}=\"")).expect("there") + name.len() + 3..];
        rest[..rest.find('"').expect("closed")].parse().expect("a number")
    };
    let vertices = text.lines().filter(|l| l.starts_with("<vertex "));
    let read: Vec<Vec3> = vertices.map(|l| Vec3::from(["x", "y", "z"].map(|n| attribute(l, n)))).collect();
    assert_eq!(read, solid.positions);
    let read: Vec<[u32; 3]> = text
        .lines()
        .filter(|l| l.starts_with("<triangle "))
        .map(|l| ["v1", "v2", "v3"].map(|n| attribute(l, n) as u32))
        .collect();
    assert_eq!(read, solid.triangles);
    assert!(text.contains("<m:color color=\"#C81E1EFF\"/>"), "the legs' colour");
    progress.cancel();
    assert!(stl(&solid, progress.whole()).is_err() && three_mf(&solid, progress.whole()).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn any_heap_of_boxes_becomes_one_closed_solid(
        heap in proptest::collection::vec(proptest::array::uniform6(0.0f32..20.0), 1..6),
        thick in prop_oneof![Just(0.0f32), 1.0f32..4.0],
        base in any::<bool>(),
        few in any::<bool>(),
    ) {
        let parts: Vec<(Vec3, Vec3, [u8; 3])> = heap
            .iter()
            .map(|n| (Vec3::from_slice(&n[..3]), Vec3::from_slice(&n[..3]) + Vec3::from_slice(&n[3..]) + 0.05, [7; 3]))
            .collect();
        let options = SolidOptions {
            size: SolidSize::Longest(20.0),
            detail: Some(0.5),
            min_thickness: thick,
            base,
            max_triangles: few.then_some(2000),
        };
        match made(&boxes(&parts), &options) {
            Ok(solid) => prop_assert!(solid.report.volume_mm3 > 0.0),
            // A heap of sheets thinner than a cell.
            Err(error) => prop_assert!(thick == 0.0 && error.to_string().contains("holds no volume"), "{}", error),
        }
    }
}
