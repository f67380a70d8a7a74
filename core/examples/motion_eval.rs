//! Measures what is done to motions.
//!
//! - `motion_eval cycle MOTION.json`: its period, where it closes best, and each limb's phase.
//! - `motion_eval loop MOTION.json OUT.json [START PERIOD [FADE]]`: the loop's seam, beside its usual step.
//! - `motion_eval smooth MOTION.json OUT.json PERIOD`: how far places went, and how much less steps change.
//! - `motion_eval plant MOTION.json OUT.json [closed]`: when feet are down, and how they slid.
//! - `motion_eval map MOTION.json|BVH CREATURE_MOTION.json OUT.json`: the map that is proposed, and the motion by it.
//! - `motion_eval draw MOTION.json OUT.svg`: its limbs as lines that move, over and over.
#![expect(clippy::print_stderr, clippy::print_stdout, reason = "an example speaks to a person")]

use marey::Vec2;
use marey::motion::limb_map::{LimbMapParams, map_limbs, propose_map, rest_limbs};
use marey::motion::{
    LoopParams, Motion, PlantParams, SmoothParams, TrackKind, bvh, close_loop, find_cycle, plant, smooth,
};

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if let Err(e) = run(&args.iter().map(String::as_str).collect::<Vec<_>>()) {
        eprintln!("{e}");
        std::process::exit(1);
    }
}

/// Pixels by which steps of a point change from frame to frame, the mean.
fn jitter(motion: &Motion) -> f32 {
    let changes = motion.tracks.iter().flat_map(|t| {
        t.frames.windows(3).flat_map(|w| {
            (0..w[0].points.len()).map(|i| (w[2].points[i] - 2.0 * w[1].points[i] + w[0].points[i]).length())
        })
    });
    let (sum, count) = changes.fold((0.0, 0.0), |(s, n), c| (s + c, n + 1.0));
    sum / f32::max(count, 1.0)
}

/// Limbs as lines that move; joints as lines along their bones.
fn drawn(motion: &Motion) -> String {
    let lines: Vec<Vec<Vec<Vec2>>> = match motion.tracks.iter().all(|t| t.kind == TrackKind::Stroke) {
        true => motion.tracks.iter().map(|t| t.frames.iter().map(|f| f.points.clone()).collect()).collect(),
        false => {
            let first = |name: &str, f: usize| motion.track(name).map(|t| t.frames[f].points[0]);
            let bone = |(a, b): &(String, String)| {
                (0..motion.frames).filter_map(|f| Some(vec![first(a, f)?, first(b, f)?])).collect()
            };
            motion.bones.iter().map(bone).collect()
        }
    };
    let all = || lines.iter().flatten().flatten().copied();
    let (low, high) = (all().fold(Vec2::MAX, Vec2::min) - 8.0, all().fold(Vec2::MIN, Vec2::max) + 8.0);
    let size = high - low;
    let mut out = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='{:.0}' viewBox='{:.0} {:.0} {:.0} {:.0}' fill='none' \
         stroke-width='4' stroke-linecap='round' stroke-linejoin='round'>\n",
        (0.8 * size.x).min(420.0),
        low.x,
        low.y,
        size.x,
        size.y
    );
    const COLOURS: [&str; 6] = ["#c0392b", "#2471a3", "#1e8449", "#b9770e", "#7d3c98", "#566573"];
    for (k, line) in lines.iter().enumerate() {
        let pose =
            |points: &Vec<Vec2>| points.iter().map(|p| format!("{:.1},{:.1}", p.x, p.y)).collect::<Vec<_>>().join(" ");
        let values: Vec<String> = line.iter().chain(line.first()).map(pose).collect();
        out += &format!(
            "<polyline stroke='{}' points='{}'><animate attributeName='points' dur='{:.3}s' repeatCount='indefinite' \
             values='{}'/></polyline>\n",
            COLOURS[k % COLOURS.len()],
            values[0],
            motion.frames as f64 / motion.fps,
            values.join(";")
        );
    }
    out + "</svg>\n"
}

fn run(args: &[&str]) -> Result<(), Box<dyn std::error::Error>> {
    match args {
        ["cycle", motion] => {
            let cycle = find_cycle(&Motion::read(motion)?)?;
            println!("period {:.2}, start {}, confidence {:.2}", cycle.period, cycle.start, cycle.confidence);
            cycle.limbs.iter().for_each(|l| println!("  {}: phase {:.2}, swing {:.1}", l.track, l.phase, l.swing));
        }
        ["loop", motion, out, rest @ ..] => {
            let number = |k: usize| rest.get(k).and_then(|v| v.parse::<f64>().ok());
            let mut params = LoopParams { range: number(0).zip(number(1)), ..LoopParams::default() };
            params.fade = number(2).unwrap_or(params.fade);
            let closed = close_loop(&Motion::read(motion)?, &params)?;
            println!(
                "{} frames from {} for {:.2}, travel {:.1}",
                closed.motion.frames, closed.start, closed.period, closed.travel
            );
            println!("extent {:.1}, {:.4?}", closed.motion.extent(), closed.seam);
            std::fs::write(out, closed.motion.to_json())?;
        }
        ["smooth", motion, out, period] => {
            let motion = Motion::read(motion)?;
            let made = smooth(&motion, &SmoothParams { period: period.parse()?, ..SmoothParams::default() })?;
            println!("steps change by {:.3} px, before by {:.3}", jitter(&made), jitter(&motion));
            std::fs::write(out, made.to_json())?;
        }
        ["plant", motion, out, rest @ ..] => {
            let params = PlantParams { closed: rest.contains(&"closed"), ..PlantParams::default() };
            let planted = plant(&Motion::read(motion)?, &params)?;
            println!("ground {:.2}", planted.ground);
            planted.feet.iter().for_each(|f| println!("  {:.3?}", f));
            std::fs::write(out, planted.motion.to_json())?;
        }
        ["map", motion, creature, out] => {
            let motion = match motion.ends_with(".bvh") {
                true => bvh::from_bvh(&std::fs::read_to_string(motion)?, bvh::View::Side, 400)?,
                false => Motion::read(motion)?,
            };
            let creature = Motion::read(creature)?;
            let limbs = rest_limbs(&creature, None)?;
            let map = propose_map(&motion, &limbs)?;
            println!("{}", map.to_json());
            let made = map_limbs(&motion, &limbs, creature.size, &map, &LimbMapParams::default())?;
            std::fs::write(out, made.to_json())?;
        }
        ["draw", motion, out] => std::fs::write(out, drawn(&Motion::read(motion)?))?,
        _ => return Err("see the head of core/examples/motion_eval.rs".into()),
    }
    Ok(())
}
