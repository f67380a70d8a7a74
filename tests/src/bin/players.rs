//! Writes takes in the formats of players, beside what they must show: `cargo xtask players` runs it.
//!
//! ```text
//! players OUT [DATA]
//! ```
//! Every case is a folder of OUT: the takes, `texture.png` and `truth.json` with the mesh, its places in every frame and the
//! triangles in drawing order. Without DATA there is a drawn figure; DATA adds the characters of a data folder, with poses
//! and with captured motion.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use glam::{Vec2, vec2};
use image::RgbaImage;
use marey::deform::needles::NeedleDeformer;
use marey::export::scene::lottie;
use marey::export::take::{TakeFormat, TakeOptions, TakeSubject, write_take};
use marey::job::Progress;
use marey::motion::bvh::{View, from_bvh};
use marey::motion::retarget::{RestSkeleton, RetargetMap, RetargetParams, SourcePlace, retarget};
use marey::shape::character::{Animation, Character, Easing, Joint, KeyPose, Poses, RigParams, Skeleton, Take};
use marey_tests::sketches;
use serde_json::json;

struct Case {
    name: String,
    picture: RgbaImage,
    character: Character,
    take: Take,
}

fn main() -> Result<()> {
    let args: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let (out, data) = match &args[..] {
        [out] => (out, None),
        [out, data] => (out, Some(data)),
        _ => bail!("usage: players OUT [DATA]"),
    };
    std::fs::create_dir_all(out)?;
    let mut cases = figures()?;
    if let Some(data) = data {
        cases.extend(children(data)?);
        cases.extend(robot(data)?);
    }
    let mut names = Vec::new();
    for case in &cases {
        write(out, case).with_context(|| case.name.clone())?;
        names.push(&case.name);
    }
    std::fs::write(out.join("cases.json"), serde_json::to_vec(&names)?)?;
    let mut moving = sketches::drawn();
    if let Some(data) = data {
        moving.extend(sketches::read(&data.join("drawings/strokes"))?);
    }
    for case in &moving {
        // As large as players show them.
        let scale = 512.0 / case.drawing.size.0.max(case.drawing.size.1);
        sketches::write(out, case, scale).with_context(|| case.name.clone())?;
    }
    let names: Vec<&String> = moving.iter().map(|case| &case.name).collect();
    std::fs::write(out.join("sketches.json"), serde_json::to_vec(&names)?)?;
    Ok(())
}

fn write(out: &Path, case: &Case) -> Result<()> {
    let folder = out.join(&case.name);
    std::fs::create_dir_all(&folder)?;
    let subject =
        TakeSubject { name: &case.name, character: &case.character, picture: &case.picture, take: &case.take };
    for (format, file) in
        [(TakeFormat::Glb, "take.glb"), (TakeFormat::Spine, "spine.json"), (TakeFormat::DragonBones, "dragon.json")]
    {
        write_take(&folder.join(file), format, subject, &TakeOptions::default(), Progress::new().whole())?;
    }
    case.picture.save(folder.join("texture.png"))?;
    std::fs::create_dir_all(folder.join("frames"))?;
    let mut draw = |frame: usize| {
        let picture = paint(case, frame);
        let path = folder.join(format!("frames/{frame:05}.png"));
        picture.save(&path).map_err(|e| marey::Error::file(&path, e.to_string(), "check the disk"))?;
        Ok(picture)
    };
    let shown = [0, 0, case.picture.width() as i32, case.picture.height() as i32];
    let path = folder.join("lottie.json");
    lottie::write(&path, subject, &TakeOptions::default(), shown, &mut draw, Progress::new().whole())?;
    let flat = |points: &[Vec2]| points.iter().flat_map(|p| [p.x, p.y]).collect::<Vec<f32>>();
    let character = &case.character;
    let triangles =
        |order: Vec<u32>| order.iter().flat_map(|t| character.mesh.triangles[*t as usize]).collect::<Vec<u32>>();
    let mut orders = Vec::new();
    let mut order_of = Vec::new();
    for (f, frame) in case.take.frames.iter().enumerate() {
        if f == 0 || case.take.frames[f - 1].depths != frame.depths {
            orders.push(triangles(character.draw_order(&frame.depths)));
        }
        order_of.push(orders.len() - 1);
    }
    let truth = json!({
        "name": case.name, "size": [character.size.0, character.size.1], "fps": case.take.fps,
        "rest": flat(&character.mesh.points),
        "frames": case.take.frames.iter().map(|f| flat(&f.points)).collect::<Vec<_>>(),
        "orders": orders, "order_of": order_of,
    });
    std::fs::write(folder.join("truth.json"), serde_json::to_vec(&truth)?)?;
    Ok(())
}

/// A frame, nearest pixels, straight alpha.
fn paint(case: &Case, frame: usize) -> RgbaImage {
    let (mesh, frame) = (&case.character.mesh, &case.take.frames[frame]);
    let (width, height) = case.picture.dimensions();
    let mut out = RgbaImage::new(width, height);
    for t in case.character.draw_order(&frame.depths) {
        let corners = mesh.triangles[t as usize];
        let [a, b, c] = corners.map(|v| frame.points[v as usize]);
        let rest = corners.map(|v| mesh.points[v as usize]);
        let area = (b - a).perp_dot(c - a);
        if area.abs() < 1e-6 {
            continue;
        }
        let (low, high) = (a.min(b).min(c).max(Vec2::ZERO), a.max(b).max(c).min(vec2(width as f32, height as f32)));
        for y in low.y as u32..high.y.ceil().max(0.0) as u32 {
            for x in low.x as u32..high.x.ceil().max(0.0) as u32 {
                let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
                let (wb, wc) = ((p - a).perp_dot(c - a) / area, (b - a).perp_dot(p - a) / area);
                if wb < 0.0 || wc < 0.0 || wb + wc > 1.0 {
                    continue;
                }
                let at = rest[0] * (1.0 - wb - wc) + rest[1] * wb + rest[2] * wc;
                let (u, v) = ((at.x.max(0.0) as u32).min(width - 1), (at.y.max(0.0) as u32).min(height - 1));
                out.put_pixel(x, y, *case.picture.get_pixel(u, v));
            }
        }
    }
    out
}

fn posed(character: &Character, poses: Poses) -> Result<Take> {
    let progress = Progress::new();
    let animation = Animation::new(character, &NeedleDeformer::default(), poses, progress.whole())?;
    Ok(Take::of_poses(&animation, progress.whole())?)
}

/// Every bone turned by `degrees` more than the one it hangs from, this way and that, and stretched.
fn turned(character: &Character, degrees: f32, stretch: f32) -> Vec<Vec2> {
    let skeleton = &character.skeleton;
    let parents = skeleton.parents();
    let rest = skeleton.rest();
    let mut joints = rest.clone();
    let mut turns: Vec<f32> = Vec::new();
    for (bone, &[from, to]) in skeleton.bones.iter().enumerate() {
        let turn = parents[bone].map_or(0.2 * degrees, |p| turns[p] + if bone % 2 == 0 { degrees } else { -degrees });
        turns.push(turn);
        let stretch = if bone % 3 == 1 { stretch } else { 1.0 };
        joints[to] = joints[from] + Vec2::from_angle(turn.to_radians()).rotate(rest[to] - rest[from]) * stretch;
    }
    joints
}

/// Key poses that bend, stretch, pull at a vertex and raise a limb, over two seconds.
fn keys(character: &Character, step: usize) -> Poses {
    let last = character.skeleton.bones.len() as u32 - 1;
    let key = |frame, joints| KeyPose { frame, joints, ..KeyPose::default() };
    let mut keys = vec![
        key(0, character.skeleton.rest()),
        key(16, turned(character, 40.0, 1.0)),
        key(30, turned(character, -50.0, 1.3)),
        key(47, character.skeleton.rest()),
    ];
    keys[1].easing = Easing::InOut;
    keys[1].depth = vec![(last, 1), (0, -1)];
    keys[2].moved = vec![(3, vec2(4.0, -6.0))];
    keys[2].depth = vec![(last, -2)];
    Poses { fps: 24.0, step, keys }
}

fn rigged(picture: &RgbaImage, skeleton: Option<Skeleton>) -> Result<Character> {
    let character = Character::from_picture(picture, &RigParams::default(), Progress::new().whole())?;
    Ok(match skeleton {
        Some(skeleton) => character.with_skeleton(skeleton)?,
        None => character,
    })
}

/// A figure drawn here, with one name that needs care, in poses, on twos, and standing still.
fn figures() -> Result<Vec<Case>> {
    let near = |p: Vec2, a: Vec2, b: Vec2| {
        let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a.lerp(b, along))
    };
    let limbs = [
        (vec2(150.0, 140.0), vec2(150.0, 230.0), 36.0, [70, 120, 200]),
        (vec2(150.0, 70.0), vec2(150.0, 71.0), 42.0, [240, 200, 160]),
        (vec2(150.0, 140.0), vec2(40.0, 190.0), 13.0, [200, 80, 60]),
        (vec2(150.0, 140.0), vec2(260.0, 190.0), 13.0, [60, 160, 80]),
        (vec2(150.0, 230.0), vec2(100.0, 370.0), 16.0, [90, 60, 120]),
        (vec2(150.0, 230.0), vec2(200.0, 370.0), 16.0, [150, 130, 40]),
    ];
    let picture = RgbaImage::from_fn(300, 400, |x, y| {
        let p = vec2(x as f32 + 0.5, y as f32 + 0.5);
        let inside = limbs.iter().rev().find(|(a, b, radius, _)| near(p, *a, *b) < *radius);
        let stripe = if (x / 6 + y / 9) % 2 == 0 { 0 } else { 15 };
        inside.map_or(image::Rgba([0; 4]), |l| image::Rgba([l.3[0] + stripe, l.3[1] + stripe, l.3[2] + stripe, 255]))
    });
    let character = rigged(&picture, None)?;
    let mut cases = Vec::new();
    for (name, poses) in [
        ("figure \"Ä\"", keys(&character, 1)),
        ("figure on twos", keys(&character, 2)),
        ("figure still", Poses { keys: keys(&character, 1).keys[1..2].to_vec(), fps: 12.5, step: 1 }),
    ] {
        let poses = match poses.keys.len() {
            1 => Poses { keys: vec![KeyPose { frame: 0, ..poses.keys[0].clone() }], ..poses },
            _ => poses,
        };
        let take = posed(&character, poses)?;
        cases.push(Case { name: name.into(), picture: picture.clone(), character: character.clone(), take });
    }
    Ok(cases)
}

/// The children's drawings, each in poses and with captured motion.
fn children(data: &Path) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for n in 1..=4 {
        let folder = data.join(format!("children/characters/char{n}"));
        let mut picture = image::open(folder.join("texture.png"))?.to_rgba8();
        let mask = image::open(folder.join("mask.png"))?.to_luma8();
        for (to, from) in picture.pixels_mut().zip(mask.pixels()) {
            to.0[3] = from.0[0];
        }
        let text = std::fs::read_to_string(folder.join("char_cfg.yaml"))?;
        let character = rigged(&picture, Some(listed(&text)?))?;
        let case = |what: &str, take| Case {
            name: format!("char{n} {what}"),
            picture: picture.clone(),
            character: character.clone(),
            take,
        };
        cases.push(case("poses", posed(&character, keys(&character, 1))?));
        let (file, view) = if n % 2 == 1 {
            ("children/bvh/fair1/dab.bvh", View::FrontZUp)
        } else {
            ("children/bvh/cmu1/jumping_jacks.bvh", View::Front)
        };
        cases.push(case("motion", moved(&character, &std::fs::read_to_string(data.join(file))?, view)?));
    }
    Ok(cases)
}

/// The skeleton of a list of joints with their parents; the root and the hip lie on one spot.
fn listed(text: &str) -> Result<Skeleton> {
    let mut joints: Vec<Joint> = Vec::new();
    let mut parents: Vec<String> = Vec::new();
    let mut numbers: Vec<f32> = Vec::new();
    for line in text.lines().map(|l| l.trim().trim_start_matches("- ").trim_start_matches("- ")) {
        if let Ok(number) = line.parse() {
            numbers.push(number);
        } else if let Some(name) = line.strip_prefix("name: ") {
            let [.., x, y] = numbers[..] else { bail!("joint `{name}` has no place") };
            joints.push(Joint { name: name.into(), at: vec2(x, y) });
        } else if let Some(parent) = line.strip_prefix("parent: ") {
            parents.push(parent.into());
        }
    }
    let find = |name: &String| joints.iter().position(|j| &j.name == name);
    let bones = parents
        .iter()
        .enumerate()
        .filter_map(|(j, p)| Some([find(p)?, j]))
        .filter(|b| b != &[0, 1])
        .collect::<Vec<_>>();
    // Without the joint at the root's place.
    let bones = bones.into_iter().map(|[a, b]| [if a == 1 { 0 } else { a }, b]).collect();
    Ok(Skeleton { joints, bones })
}

/// Captured motion, every second frame and 150 at most.
fn moved(character: &Character, bvh: &str, view: View) -> Result<Take> {
    let mut motion = from_bvh(bvh, view, 512)?;
    let step = (motion.frames / 150).max(1);
    motion.frames = motion.frames.div_ceil(step);
    motion.fps /= step as f64;
    for track in &mut motion.tracks {
        track.frames = track.frames.iter().step_by(step).cloned().collect();
    }
    let pairs = [
        ("root", "Hips"),
        ("torso", "Spine1"),
        ("neck", "Head"),
        ("right_shoulder", "RightArm"),
        ("right_elbow", "RightForeArm"),
        ("right_hand", "RightHand"),
        ("left_shoulder", "LeftArm"),
        ("left_elbow", "LeftForeArm"),
        ("left_hand", "LeftHand"),
        ("right_hip", "RightUpLeg"),
        ("right_knee", "RightLeg"),
        ("right_foot", "RightFoot"),
        ("left_hip", "LeftUpLeg"),
        ("left_knee", "LeftLeg"),
        ("left_foot", "LeftFoot"),
    ];
    let known = |track: &str| motion.track(track).is_some();
    let other = |track: &str| {
        match track {
            "RightArm" => "RightShoulder",
            "RightForeArm" => "RightElbow",
            "RightHand" => "RightWrist",
            "LeftArm" => "LeftShoulder",
            "LeftForeArm" => "LeftElbow",
            "LeftHand" => "LeftWrist",
            "RightUpLeg" => "RightHip",
            "RightLeg" => "RightKnee",
            "RightFoot" => "RightAnkle",
            "LeftUpLeg" => "LeftHip",
            "LeftLeg" => "LeftKnee",
            "LeftFoot" => "LeftAnkle",
            "Spine1" => "Chest",
            other => other,
        }
        .to_owned()
    };
    let joints = pairs
        .into_iter()
        .filter(|(joint, _)| character.skeleton.joint(joint).is_some())
        .map(|(joint, track)| {
            (joint, if known(track) && known("RightForeArm") { track.to_owned() } else { other(track) })
        })
        .filter(|(_, track)| known(track))
        .map(|(joint, track)| (joint.to_owned(), SourcePlace::of(&track)))
        .collect();
    let named: Vec<(String, Vec2)> = character.skeleton.joints.iter().map(|j| (j.name.clone(), j.at)).collect();
    let skeleton = RestSkeleton { joints: &named, bones: &character.skeleton.bones, size: character.size };
    let params = RetargetParams { stretch: 1.25, ..RetargetParams::default() };
    let map = RetargetMap { joints, ..RetargetMap::default() };
    let own = retarget(&motion, skeleton, &map, &params)?;
    let progress = Progress::new();
    let mut poser = character.poser(&NeedleDeformer::default(), progress.whole())?;
    Ok(Take::of_motion(&mut poser, &own, &[], progress.whole())?)
}

/// A robot in its rest pose, with the joints that it came with.
fn robot(data: &Path) -> Result<Vec<Case>> {
    let folder = data.join("gbot");
    let picture = image::open(folder.join("rest.png"))?.to_rgba8();
    let text: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(folder.join("rest.json"))?)?;
    let places = text["joints"].as_object().context("no joints")?;
    let joints: Vec<Joint> = places
        .iter()
        .map(|(name, at)| {
            let number = |i: usize| at[i].as_f64().unwrap_or(0.0) as f32;
            Joint { name: name.clone(), at: vec2(number(0), number(1)) }
        })
        .collect();
    let find = |name: &str| joints.iter().position(|j| j.name == name).with_context(|| format!("no joint {name}"));
    let mut bones = Vec::new();
    for chain in [
        &["Hip", "Chest", "Head"][..],
        &["Chest", "RightArm", "RightForearm", "RightHand"],
        &["Chest", "LeftArm", "LeftForearm", "LeftHand"],
        &["Hip", "LeftLeg", "LeftLowerLeg", "LeftFoot"],
        &["Hip", "RightLeg", "RightLowerLeg", "RightFoot"],
    ] {
        for pair in chain.windows(2) {
            bones.push([find(pair[0])?, find(pair[1])?]);
        }
    }
    let used: Vec<Joint> = joints.clone();
    let character = rigged(&picture, Some(Skeleton { joints: used, bones }))?;
    let take = posed(&character, keys(&character, 1))?;
    Ok(vec![Case { name: "gbot poses".into(), picture, character, take }])
}
