//! A character's take in the formats of engines, read back by readers written from the formats' descriptions.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{Affine2, Mat2, Vec2, vec2};
use image::RgbaImage;
use marey::Error;
use marey::deform::needles::NeedleDeformer;
use marey::export::scene::lottie;
use marey::export::take::{TakeFormat, TakeOptions, TakeSubject, write_take};
use marey::job::Progress;
use marey::shape::character::{Animation, Character, Easing, KeyPose, Poses, RigParams, Take};
use serde_json::Value;

use crate::gltf_reader::Reader;

const FORMATS: [(TakeFormat, &str); 3] =
    [(TakeFormat::Glb, "a.glb"), (TakeFormat::Spine, "a.json"), (TakeFormat::DragonBones, "a.json")];

/// A cross with an arm that is bent, stretched, raised and pulled at.
struct Figure {
    picture: RgbaImage,
    character: Character,
}

impl Figure {
    fn new() -> Self {
        let picture = RgbaImage::from_fn(160, 200, |x, y| {
            let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
            let body = (p.x - 80.0).abs() < 18.0 && (p.y - 100.0).abs() < 80.0;
            let arms = (p.y - 70.0).abs() < 12.0 && (p.x - 80.0).abs() < 70.0;
            image::Rgba(if body || arms { [x as u8, y as u8, 90, 255] } else { [0; 4] })
        });
        let params = RigParams { vertices: 250, finer_at_joints: 2.0 };
        let character = Character::from_picture(&picture, &params, Progress::new().whole()).expect("a rig");
        Self { picture, character }
    }

    fn take(&self, step: usize, frames: usize, depths: bool) -> Take {
        let skeleton = &self.character.skeleton;
        let turned = |degrees: f32, stretch: f32| {
            let mut joints = skeleton.rest();
            for (bone, &[from, to]) in skeleton.bones.iter().enumerate() {
                let way = skeleton.joints[to].at - skeleton.joints[from].at;
                let degrees = if bone % 2 == 0 { degrees } else { -0.5 * degrees };
                joints[to] = joints[from] + Vec2::from_angle(degrees.to_radians()).rotate(way) * stretch;
            }
            joints
        };
        let key = |frame, joints| KeyPose { frame, joints, ..KeyPose::default() };
        let mut keys = vec![key(0, skeleton.rest())];
        if frames > 1 {
            keys.push(key(frames / 2, turned(50.0, 1.0)));
            keys.push(key(frames - 1, turned(-40.0, 1.4)));
            keys[0].easing = Easing::InOut;
            keys[2].moved = vec![(3, vec2(3.0, -4.0))];
            if depths {
                keys[1].depth = vec![(skeleton.bones.len() as u32 - 1, -1)];
                keys[2].depth = vec![(0, 2)];
            }
        }
        let poses = Poses { fps: 12.0, step, keys };
        let progress = Progress::new();
        let own = Animation::new(&self.character, &NeedleDeformer::default(), poses, progress.whole()).expect("solved");
        Take::of_poses(&own, progress.whole()).expect("a take")
    }

    fn subject<'a>(&'a self, take: &'a Take, name: &'a str) -> TakeSubject<'a> {
        TakeSubject { name, character: &self.character, picture: &self.picture, take }
    }
}

fn write(format: TakeFormat, path: &Path, subject: TakeSubject<'_>, options: &TakeOptions) -> marey::Result<()> {
    write_take(path, format, subject, options, Progress::new().whole()).map(|_| ())
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("a file")).expect("JSON")
}

fn number(value: &Value, usual: f32) -> f32 {
    value.as_f64().map_or(usual, |v| v as f32)
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// Places and texture coordinates of what a scene shows in a frame, in drawing order.
type Shown = Vec<(Vec2, Vec2)>;

/// Every vertex is where the take has it, by its texture coordinates; gives the largest and the mean error.
fn compare(figure: &Figure, take: &Take, scale: f32, mut read: impl FnMut(usize) -> Shown) -> (f32, f32) {
    let size = vec2(figure.character.size.0 as f32, figure.character.size.1 as f32);
    let (mut most, mut sum, mut count) = (0f32, 0.0, 0);
    for (f, frame) in take.frames.iter().enumerate() {
        let mut seen = vec![false; frame.points.len()];
        for (at, uv) in read(f) {
            let rest = uv * size;
            let gap = |v: &usize| figure.character.mesh.points[*v].distance(rest);
            let v = (0..seen.len()).min_by(|a, b| gap(a).total_cmp(&gap(b))).expect("vertices");
            assert!(gap(&v) < 0.02, "a vertex that is none of the mesh's");
            seen[v] = true;
            let off = (at / scale).distance(frame.points[v]);
            (most, sum, count) = (most.max(off), sum + off, count + 1);
        }
        assert!(seen.iter().all(|s| *s), "a vertex is missing");
    }
    let mean = sum / count as f32;
    assert!(most <= 0.3 && mean <= 0.1, "off by {most} px, {mean} on average");
    (most, mean)
}

/// A frame's share of the way from one key to the next, and which.
fn between(starts: &[f32], at: f32, holds: bool) -> (usize, f32) {
    let i = starts.iter().rposition(|t| *t <= at + 1e-4).unwrap_or(0);
    match starts.get(i + 1) {
        Some(next) if !holds => (i, ((at - starts[i]) / (next - starts[i])).clamp(0.0, 1.0)),
        _ => (i, 0.0),
    }
}

fn local(place: Vec2, degrees: f32, scale: Vec2) -> Affine2 {
    Affine2 { matrix2: Mat2::from_angle(degrees.to_radians()) * Mat2::from_diagonal(scale), translation: place }
}

fn world(bones: &[Value], local: impl Fn(&Value) -> Affine2) -> Vec<Affine2> {
    let mut world: Vec<Affine2> = Vec::new();
    for bone in bones {
        let parent = bones.iter().position(|b| b["name"] == bone["parent"]);
        world.push(parent.map_or(Affine2::IDENTITY, |p| world[p]) * local(bone));
    }
    world
}

/// Slots in the order that moves give: those moved go to their places, the others fill what is left.
fn ordered(count: usize, moves: &[(usize, i64)]) -> Vec<usize> {
    let mut order = vec![None; count];
    moves.iter().for_each(|&(slot, by)| order[(slot as i64 + by) as usize] = Some(slot));
    let mut others = (0..count).filter(|s| moves.iter().all(|m| m.0 != *s));
    order.into_iter().map(|slot| slot.or_else(|| others.next()).expect("a slot")).collect()
}

fn spine(scene: &Value, time: f32, height: f32) -> (Shown, Vec<String>) {
    let animation = &scene["animations"]["take"];
    let channel = |bone: &Value, line: &str, key: &str, usual: f32| {
        let keys = list(&animation["bones"][bone["name"].as_str().expect("a name")][line]);
        let starts: Vec<f32> = keys.iter().map(|k| number(&k["time"], 0.0)).collect();
        let value = |i: usize| keys.get(i).map_or(usual, |k| number(&k[key], usual));
        let holds = keys.first().is_some_and(|k| k["curve"] == "stepped");
        let (i, share) = between(&starts, time, holds);
        if keys.is_empty() { usual } else { value(i) + (value((i + 1).min(keys.len() - 1)) - value(i)) * share }
    };
    let bones = list(&scene["bones"]);
    let world = world(bones, |b| {
        let place = vec2(
            number(&b["x"], 0.0) + channel(b, "translate", "x", 0.0),
            number(&b["y"], 0.0) + channel(b, "translate", "y", 0.0),
        );
        let turn = number(&b["rotation"], 0.0) + channel(b, "rotate", "value", 0.0);
        local(place, turn, vec2(channel(b, "scale", "x", 1.0), channel(b, "scale", "y", 1.0)))
    });
    let slots = list(&scene["slots"]);
    let orders = list(&animation["drawOrder"]);
    let starts: Vec<f32> = orders.iter().map(|k| number(&k["time"], 0.0)).collect();
    let moves: Vec<(usize, i64)> = orders
        .get(between(&starts, time, true).0)
        .map_or(&[][..], |k| list(&k["offsets"]))
        .iter()
        .map(|m| (slots.iter().position(|s| s["name"] == m["slot"]), m["offset"].as_i64()))
        .map(|(slot, by)| (slot.expect("a slot"), by.expect("a number")))
        .collect();
    let (mut shown, mut drawn) = (Shown::new(), Vec::new());
    for slot in ordered(slots.len(), &moves) {
        let name = slots[slot]["name"].as_str().expect("a name");
        drawn.push(name.to_owned());
        let mesh = &scene["skins"][0]["attachments"][name][slots[slot]["attachment"].as_str().expect("a name")];
        let keys = list(&animation["attachments"]["default"][name][name]["deform"]);
        let starts: Vec<f32> = keys.iter().map(|k| number(&k["time"], 0.0)).collect();
        let holds = keys.first().is_some_and(|k| k["curve"] == "stepped");
        let (key, share) = between(&starts, time, holds);
        let told = |key: usize, i: usize| {
            let first = keys[key]["offset"].as_u64().unwrap_or(0) as usize;
            i.checked_sub(first).map_or(0.0, |i| number(&keys[key]["vertices"][i], 0.0))
        };
        let deform = |i: usize| {
            let next = (key + 1).min(keys.len().max(1) - 1);
            if keys.is_empty() { 0.0 } else { told(key, i) + (told(next, i) - told(key, i)) * share }
        };
        let uvs: Vec<f32> = list(&mesh["uvs"]).iter().map(|v| number(v, 0.0)).collect();
        let (vertices, hull) = (uvs.len() / 2, mesh["hull"].as_u64().expect("a hull") as usize);
        assert!(hull >= 3 && hull <= vertices);
        assert!(list(&mesh["triangles"]).iter().all(|v| (v.as_u64().expect("an index") as usize) < vertices));
        let numbers: Vec<f32> = list(&mesh["vertices"]).iter().map(|v| number(v, 0.0)).collect();
        let (mut i, mut d) = (0, 0);
        for v in 0..vertices {
            let count = numbers[i] as usize;
            i += 1;
            let (mut at, mut sum) = (Vec2::ZERO, 0.0);
            for _ in 0..count {
                let p = vec2(numbers[i + 1] + deform(d), numbers[i + 2] + deform(d + 1));
                at += world[numbers[i] as usize].transform_point2(p) * numbers[i + 3];
                sum += numbers[i + 3];
                (i, d) = (i + 4, d + 2);
            }
            assert!((sum - 1.0).abs() < 1e-5);
            shown.push((vec2(at.x, height - at.y), vec2(uvs[2 * v], uvs[2 * v + 1])));
        }
        assert_eq!(i, numbers.len());
    }
    (shown, drawn)
}

fn dragonbones(scene: &Value, frame: usize) -> Shown {
    let armature = &scene["armature"][0];
    let animation = &armature["animation"][0];
    // Keys that last: where they start, and whether they give way.
    let starts = |keys: &[Value]| -> Vec<f32> {
        let starts = keys.iter().scan(0.0, |at, key| {
            let here = *at;
            *at += number(&key["duration"], 1.0);
            Some(here)
        });
        starts.collect()
    };
    let blend = |keys: &[Value], value: &dyn Fn(usize) -> f32, usual: f32| {
        if keys.is_empty() {
            return usual;
        }
        let (i, share) = between(&starts(keys), frame as f32, false);
        let share = if keys[i]["tweenEasing"].is_number() { share } else { 0.0 };
        value(i) + (value((i + 1).min(keys.len() - 1)) - value(i)) * share
    };
    let bones = list(&armature["bone"]);
    let world = world(bones, |b| {
        let lines = list(&animation["bone"]).iter().find(|l| l["name"] == b["name"]);
        let channel = |line: &str, key: &str, usual: f32| {
            let keys = lines.map_or(&[][..], |l| list(&l[line]));
            blend(keys, &|i| number(&keys[i][key], usual), usual)
        };
        let rest = |key: &str| number(&b["transform"][key], 0.0);
        let place =
            vec2(rest("x") + channel("translateFrame", "x", 0.0), rest("y") + channel("translateFrame", "y", 0.0));
        let scale = vec2(channel("scaleFrame", "x", 1.0), channel("scaleFrame", "y", 1.0));
        local(place, rest("skX") + channel("rotateFrame", "rotate", 0.0), scale)
    });
    let mut shown = Shown::new();
    for slot in list(&armature["skin"][0]["slot"]) {
        let mesh = &slot["display"][0];
        let keys =
            list(&animation["ffd"]).iter().find(|t| t["slot"] == slot["name"]).map_or(&[][..], |t| list(&t["frame"]));
        let told = |key: usize, i: usize| {
            let first = keys[key]["offset"].as_u64().unwrap_or(0) as usize;
            i.checked_sub(first).map_or(0.0, |i| number(&keys[key]["vertices"][i], 0.0))
        };
        let deform = |i: usize| blend(keys, &|key| told(key, i), 0.0);
        let pose: Vec<f32> = list(&mesh["bonePose"]).iter().map(|v| number(v, 0.0)).collect();
        let bind = |bone: usize| {
            let at = pose.chunks(7).find(|c| c[0] as usize == bone).expect("a pose");
            Affine2::from_cols_array(&[at[1], at[2], at[3], at[4], at[5], at[6]])
        };
        let weights: Vec<f32> = list(&mesh["weights"]).iter().map(|v| number(v, 0.0)).collect();
        let vertices: Vec<f32> = list(&mesh["vertices"]).iter().map(|v| number(v, 0.0)).collect();
        let mut i = 0;
        for v in 0..vertices.len() / 2 {
            let p = vec2(vertices[2 * v] + deform(2 * v), vertices[2 * v + 1] + deform(2 * v + 1));
            let count = weights[i] as usize;
            i += 1;
            let mut at = Vec2::ZERO;
            for _ in 0..count {
                let bone = weights[i] as usize;
                at += (world[bone] * bind(bone).inverse()).transform_point2(p) * weights[i + 1];
                i += 2;
            }
            let uv = |k: usize| number(&mesh["uvs"][2 * v + k], 0.0);
            shown.push((at, vec2(uv(0), uv(1))));
        }
        assert_eq!(i, weights.len());
    }
    shown
}

#[test]
fn every_vertex_is_where_the_take_has_it() {
    let figure = Figure::new();
    let folder = tempfile::tempdir().expect("a folder");
    for (step, frames, scale) in [(1, 13, 1.0), (2, 13, 1.0), (1, 1, 1.0), (1, 9, 0.5)] {
        let take = figure.take(step, frames, true);
        let options = TakeOptions { scale, ..TakeOptions::default() };
        let height = 200.0 * scale;
        let time = |f: usize| (f as f64 / take.fps) as f32;
        for (format, file) in FORMATS {
            let path = folder.path().join(format!("{step}{frames}{scale}{format:?}{file}"));
            write(format, &path, figure.subject(&take, "a \"figure\" é"), &options).expect("written");
            let errors = match format {
                TakeFormat::Spine => {
                    let scene = json(&path);
                    compare(&figure, &take, scale, |f| spine(&scene, time(f), height).0)
                }
                TakeFormat::DragonBones => {
                    let scene = json(&path);
                    compare(&figure, &take, scale, |f| dragonbones(&scene, f))
                }
                _ => {
                    let reader = Reader::open(&std::fs::read(&path).expect("a file"));
                    compare(&figure, &take, scale, |f| glb(&reader, time(f) + 1e-5, height))
                }
            };
            assert!(frames == 1 || errors.0 > 0.0);
        }
    }
}

fn glb(reader: &Reader, time: f32, height: f32) -> Shown {
    let posed = reader.pose(time);
    let points = posed.values().next().expect("a mesh");
    let mesh = reader.document.meshes().next().expect("a mesh").primitives().next().expect("a primitive");
    let uvs = mesh.reader(|_| Some(&reader.blob)).read_tex_coords(0).expect("uvs").into_f32();
    points.iter().zip(uvs).map(|(p, uv)| (vec2(p.x, height - p.y), Vec2::from_array(uv))).collect()
}

#[test]
fn depths_are_the_order_that_regions_are_drawn_in() {
    let figure = Figure::new();
    let folder = tempfile::tempdir().expect("a folder");
    let take = figure.take(1, 13, true);
    let skeleton = &figure.character.skeleton;
    let name = |b: usize| skeleton.bones[b].map(|j| skeleton.joints[j].name.clone()).join("-");
    let wished = |f: usize| {
        let bones = figure.character.triangle_bones();
        let mut order: Vec<u32> =
            figure.character.draw_order(&take.frames[f].depths).iter().map(|t| bones[*t as usize]).collect();
        order.dedup();
        order.into_iter().map(|b| name(b as usize)).collect::<Vec<_>>()
    };
    let path = folder.path().join("a.json");
    write(TakeFormat::Spine, &path, figure.subject(&take, "a"), &TakeOptions::default()).expect("written");
    let scene = json(&path);
    let slots = |f: usize| spine(&scene, (f as f64 / take.fps) as f32, 200.0).1;
    for f in [0, 5, 6, 11, 12] {
        // A bone that stretches moves its region by its end.
        let drawn: Vec<String> = slots(f).iter().map(|n| n.trim_end_matches("-stretch").to_owned()).collect();
        assert_eq!(drawn, wished(f), "{f}");
    }
    assert!(slots(0) != slots(6) && slots(6) != slots(12));

    let path = folder.path().join("a.glb");
    write(TakeFormat::Glb, &path, figure.subject(&take, "a"), &TakeOptions::default()).expect("written");
    let reader = Reader::open(&std::fs::read(&path).expect("a file"));
    for f in [0, 6, 12] {
        let posed = reader.pose((f as f64 / take.fps) as f32 + 1e-5);
        let points = posed.values().next().expect("a mesh");
        // A region's vertices lie at its layer, most of them its bone's own; layers rise with the order.
        let mesh = reader.document.meshes().next().expect("a mesh").primitives().next().expect("a primitive");
        let uvs = mesh.reader(|_| Some(&reader.blob)).read_tex_coords(0).expect("uvs").into_f32();
        let mut counts: BTreeMap<i32, BTreeMap<usize, usize>> = BTreeMap::new();
        for (p, uv) in points.iter().zip(uvs) {
            let rest = vec2(uv[0] * 160.0, uv[1] * 200.0);
            let gap = |v: &usize| figure.character.mesh.points[*v].distance(rest);
            let v = (0..figure.character.mesh.points.len()).min_by(|a, b| gap(a).total_cmp(&gap(b))).expect("one");
            let bone = figure.character.regions.bone[v] as usize;
            *counts.entry((p.z * 1000.0).round() as i32).or_default().entry(bone).or_default() += 1;
        }
        let most = |c: BTreeMap<usize, usize>| c.into_iter().max_by_key(|c| c.1).map_or(0, |c| c.0);
        let drawn: Vec<String> = counts.into_values().map(|c| name(most(c))).collect();
        assert_eq!(drawn, wished(f), "{f}");
    }
}

#[test]
fn what_does_not_move_has_no_keys_and_what_does_has_few() {
    let figure = Figure::new();
    let folder = tempfile::tempdir().expect("a folder");
    let path = |file: &str| folder.path().join(file);
    let mut take = figure.take(1, 41, false);
    write(TakeFormat::Spine, &path("a.json"), figure.subject(&take, "a"), &TakeOptions::default()).expect("written");
    let scene = json(&path("a.json"));
    let keys = |scene: &Value| -> usize {
        let bones = scene["animations"]["take"]["bones"].as_object().cloned().unwrap_or_default();
        bones.values().flat_map(|b| b.as_object().expect("lines").values().map(|l| list(l).len())).sum()
    };
    let channels = 3 * list(&scene["bones"]).len();
    assert!(keys(&scene) > 0 && keys(&scene) < channels * 41 / 2, "{} of {}", keys(&scene), channels * 41);
    assert!(scene["animations"]["take"]["drawOrder"].is_null());

    let rest = figure.take(1, 1, false).frames[0].clone();
    take.frames = vec![rest; 30];
    for (format, file) in FORMATS {
        write(format, &path(file), figure.subject(&take, "a"), &TakeOptions::default()).expect("written");
    }
    assert_eq!(Reader::open(&std::fs::read(path("a.glb")).expect("a file")).document.animations().count(), 0);
    let animation = &json(&path("a.json"))["armature"][0]["animation"][0];
    assert_eq!(
        (animation["bone"].is_null(), animation["ffd"].is_null(), animation["duration"].as_u64()),
        (true, true, Some(30))
    );
}

#[test]
fn what_is_no_take_of_the_character_is_refused_and_nothing_is_written() {
    let figure = Figure::new();
    let folder = tempfile::tempdir().expect("a folder");
    let good = figure.take(1, 3, false);
    let mut other = good.clone();
    other.frames[1].points.pop();
    let mut no_number = good.clone();
    no_number.frames[2].points[4].x = f32::NAN;
    let rate = Take { fps: f64::NAN, ..good.clone() };
    let empty = Take { frames: Vec::new(), ..good.clone() };
    let small = RgbaImage::new(10, 10);
    let options = TakeOptions::default();
    for (format, file) in FORMATS {
        let path = folder.path().join(file);
        for (take, problem) in [
            (&other, "of this character"),
            (&no_number, "not a number"),
            (&rate, "frames a second"),
            (&empty, "no frames"),
        ] {
            let error = write(format, &path, figure.subject(take, "a"), &options).expect_err("refused");
            assert!(error.to_string().contains(problem), "{error}");
        }
        let subject = TakeSubject { picture: &small, ..figure.subject(&good, "a") };
        assert!(write(format, &path, subject, &options).is_err());
        let options = TakeOptions { scale: 0.0, ..options };
        assert!(write(format, &path, figure.subject(&good, "a"), &options).is_err());
        let progress = Progress::new();
        progress.cancel();
        let cancelled =
            write_take(&path, format, figure.subject(&good, "a"), &TakeOptions::default(), progress.whole());
        assert!(matches!(cancelled, Err(Error::Cancelled)));
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("listed").count(), 0);
    // The picture beside it is in the way: the old main file stays.
    let path = folder.path().join("a.json");
    std::fs::write(&path, "old").expect("written");
    std::fs::create_dir(folder.path().join("a.png")).expect("a folder");
    assert!(write(TakeFormat::Spine, &path, figure.subject(&good, "a"), &options).is_err());
    assert_eq!(std::fs::read_to_string(&path).expect("still there"), "old");
    assert_eq!(std::fs::read_dir(folder.path()).expect("listed").count(), 2);
    // The main file cannot be its own picture.
    let error = write(TakeFormat::Spine, &folder.path().join("b.png"), figure.subject(&good, "a"), &options);
    assert!(error.is_err_and(|e| e.to_string().contains(".json")));
}

#[test]
fn lottie_holds_the_frames_themselves() {
    let figure = Figure::new();
    let folder = tempfile::tempdir().expect("a folder");
    let take = figure.take(1, 5, false);
    // A square that moves, stays, and goes.
    let frame = |f: usize| {
        RgbaImage::from_fn(60, 50, |x, y| {
            let at = [10, 20, 20, 30, 200][f];
            image::Rgba(if x >= at && x < at + 8 && (5..20).contains(&y) { [200, 40, 9, 255] } else { [0; 4] })
        })
    };
    let path = folder.path().join("a.json");
    let mut draw = |f: usize| Ok(frame(f));
    let shown = [0, 0, 60, 50];
    let options = TakeOptions::default();
    lottie::write(&path, figure.subject(&take, "a"), &options, shown, &mut draw, Progress::new().whole())
        .expect("written");
    let scene = json(&path);
    assert_eq!((scene["w"].as_u64(), scene["h"].as_u64(), scene["op"].as_u64()), (Some(60), Some(50), Some(5)));
    assert_eq!(list(&scene["assets"]).len(), 4);
    for f in 0..5 {
        let mut got = RgbaImage::new(60, 50);
        for layer in list(&scene["layers"]) {
            if !(layer["ip"].as_u64() <= Some(f as u64) && layer["op"].as_u64() > Some(f as u64)) {
                continue;
            }
            let asset = list(&scene["assets"]).iter().find(|a| a["id"] == layer["refId"]).expect("an asset");
            let data = asset["p"].as_str().and_then(|p| p.strip_prefix("data:image/png;base64,")).expect("a PNG");
            let png = base64::Engine::decode(&base64::engine::general_purpose::STANDARD, data).expect("base64");
            let picture = image::load_from_memory(&png).expect("a PNG").to_rgba8();
            let place = |i: usize| layer["ks"]["p"]["k"][i].as_i64().expect("a place");
            image::imageops::replace(&mut got, &picture, place(0), place(1));
        }
        assert_eq!(got, frame(f), "{f}");
    }
    let mut fails = |_: usize| Err(Error::Cancelled);
    assert!(
        lottie::write(&path, figure.subject(&take, "a"), &options, shown, &mut fails, Progress::new().whole()).is_err()
    );
    assert_eq!(json(&path), scene, "the old file stays");
}
