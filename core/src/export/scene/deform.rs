//! Correctives as deform keys of a part: for Spine and DragonBones.
//!
//! Keys are as few as linear interpolation gives the rest by, a part at a time; of a key only the stretch of vertices
//! between the first and the last that move is told. Values are multiples of a tenth of a pixel: 0.07 at worst.

use glam::Vec2;

use super::keys;
use super::parts::Part;
use super::puppet::{Puppet, TOLERANCE};

/// Of the tolerance: below this a vertex needs no corrective at all; what interpolation between keys and what leaving out
/// small ends of a key may use. Rounding has the rest.
const STILL: f64 = 0.9 * TOLERANCE;
const BETWEEN: f64 = 0.4 * TOLERANCE;
const UNTOLD: f64 = 0.3 * TOLERANCE;
/// Decimals of correctives in pixels.
pub(super) const DECIMALS: i32 = 1;

/// A key: correctives of the part's vertices from `first` on, none for the others.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DeformKey {
    pub(super) frame: usize,
    pub(super) first: usize,
    pub(super) values: Vec<Vec2>,
}

/// A part's vertices, those that move most first, and its deform keys.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Deform {
    /// The part's vertices among the mesh's.
    pub(super) vertices: Vec<u32>,
    /// Where each vertex of the part has gone.
    pub(super) place: Vec<u32>,
    pub(super) keys: Vec<DeformKey>,
}

impl Deform {
    pub(super) fn new(puppet: &Puppet, part: &Part) -> Self {
        let most = |v: u32| {
            let off = |f: &Vec<Vec2>| f64::from(f[v as usize].length()) * puppet.growth[v as usize];
            puppet.correctives.iter().map(off).fold(0.0, f64::max)
        };
        let most: Vec<f64> = part.vertices.iter().map(|&v| most(v)).collect();
        let mut order: Vec<usize> = (0..most.len()).collect();
        order.sort_by(|&a, &b| most[b].total_cmp(&most[a]));
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(to, &from)| place[from] = to as u32);
        let vertices: Vec<u32> = order.iter().map(|&v| part.vertices[v]).collect();
        let keys = keys(puppet, &vertices);
        Self { vertices, place, keys }
    }
}

/// The deform keys of some vertices, none where their bones do.
pub(super) fn keys(puppet: &Puppet, vertices: &[u32]) -> Vec<DeformKey> {
    let frames = puppet.correctives.len();
    let growth: Vec<f32> = vertices.iter().map(|&v| puppet.growth[v as usize] as f32).collect();
    let scale = puppet.scale as f32;
    let [still, between, untold] = [STILL, BETWEEN, UNTOLD].map(|share| share as f32 * scale);
    let values: Vec<Vec<Vec2>> =
        puppet.correctives.iter().map(|frame| vertices.iter().map(|&v| frame[v as usize]).collect()).collect();
    let off = |a: Vec2, b: Vec2, v: usize| (a - b).length() * growth[v];
    // The vertices that ever need a corrective.
    let moves: Vec<bool> = (0..growth.len()).map(|v| values.iter().any(|f| off(f[v], Vec2::ZERO, v) > still)).collect();
    let moving: Vec<usize> = (0..growth.len()).filter(|v| moves[*v]).collect();
    if moving.is_empty() {
        return Vec::new();
    }
    let chosen = if puppet.holds {
        keys::stepped(frames, |a, b| moving.iter().all(|&v| off(values[a][v], values[b][v], v) <= between))
    } else {
        keys::linear(frames, |a, b| {
            (a + 1..b).all(|f| {
                let share = keys::share(f, a, b) as f32;
                moving.iter().all(|&v| off(values[a][v].lerp(values[b][v], share), values[f][v], v) <= between)
            })
        })
    };
    chosen
        .into_iter()
        .map(|frame| {
            let needed = |v: &usize| moves[*v] && off(values[frame][*v], Vec2::ZERO, *v) > untold;
            let first = (0..growth.len()).find(needed).unwrap_or(0);
            let after = (0..growth.len()).rev().find(needed).map_or(first, |v| v + 1);
            let told = |v: usize| if moves[v] { values[frame][v] } else { Vec2::ZERO };
            DeformKey { frame, first, values: (first..after).map(told).collect() }
        })
        .collect()
}
