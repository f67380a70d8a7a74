//! A limb as a chain that would rather keep its shape: where its points say nothing of their own, they follow the rest.
//!
//! As-rigid-as-possible deformation (Sorkine and Alexa 2007) of a polyline: in turns, every edge takes the rotation of
//! its neighbourhood, and points solve for trusted targets and edges together, a tridiagonal system.

use glam::Vec2;

/// Pull of an edge's shape against that of a fully trusted point.
const RIGIDITY: f32 = 0.8;
/// Keeps the system sound where nothing is trusted.
const LEAST: f32 = 0.002;
const ROUNDS: usize = 6;

/// What the chain is drawn to.
pub(crate) struct Pull {
    pub(crate) target: Vec2,
    /// How strongly: 0 to 1 from the pictures, more from what it hangs on.
    pub(crate) weight: f32,
}

/// The points nearest to their targets that keep the shape of `before`, with edges of `lengths`.
pub(crate) fn settle(before: &[Vec2], lengths: &[f32], pulls: &[Pull]) -> Vec<Vec2> {
    let n = before.len();
    if n < 2 {
        return pulls.iter().map(|p| p.target).collect();
    }
    let edge = |i: usize| (before[i + 1] - before[i]).try_normalize().unwrap_or(Vec2::X) * lengths[i];
    let rest: Vec<Vec2> = (0..n - 1).map(edge).collect();
    // Untrusted targets must not turn the edges beside them.
    let mut points = solve(pulls, &rest);
    for _ in 0..ROUNDS {
        let turned: Vec<Vec2> = (0..n - 1)
            .map(|e| {
                let mut turn = 1e-6 * Vec2::X;
                for near in e.saturating_sub(2)..(e + 3).min(n - 1) {
                    let now = points[near + 1] - points[near];
                    let weight = (pulls[near].weight.min(1.0) + pulls[near + 1].weight.min(1.0) + LEAST)
                        / (1 + near.abs_diff(e)) as f32;
                    turn += weight * Vec2::new(rest[near].dot(now), rest[near].perp_dot(now));
                }
                turn.normalize_or(Vec2::X).rotate(rest[e])
            })
            .collect();
        points = solve(pulls, &turned);
    }
    points
}

/// Least squares of weighed targets and edges, by elimination (Thomas).
fn solve(pulls: &[Pull], edges: &[Vec2]) -> Vec<Vec2> {
    let n = pulls.len();
    let mut diagonal: Vec<f32> = pulls.iter().map(|p| p.weight + LEAST).collect();
    let mut right: Vec<Vec2> = pulls.iter().map(|p| p.target * (p.weight + LEAST)).collect();
    for (i, e) in edges.iter().enumerate() {
        diagonal[i] += RIGIDITY;
        diagonal[i + 1] += RIGIDITY;
        right[i] -= RIGIDITY * *e;
        right[i + 1] += RIGIDITY * *e;
    }
    for i in 1..n {
        let factor = RIGIDITY / diagonal[i - 1];
        diagonal[i] -= factor * RIGIDITY;
        let carried = right[i - 1] * factor;
        right[i] += carried;
    }
    let mut points = vec![Vec2::ZERO; n];
    for i in (0..n).rev() {
        let next = if i + 1 < n { RIGIDITY * points[i + 1] } else { Vec2::ZERO };
        points[i] = (right[i] + next) / diagonal[i];
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn untrusted_points_follow_the_turn_of_the_rest() {
        let before: Vec<Vec2> = (0..9).map(|i| vec2(10.0 * i as f32, 0.0)).collect();
        let turn = |p: Vec2| Vec2::from_angle(0.5).rotate(p) + vec2(3.0, 4.0);
        let pull = |i: usize, p: &Vec2| {
            let lost = (3..6).contains(&i);
            Pull { target: if lost { *p } else { turn(*p) }, weight: if lost { 0.0 } else { 1.0 } }
        };
        let pulls: Vec<Pull> = before.iter().enumerate().map(|(i, p)| pull(i, p)).collect();
        let after = settle(&before, &[10.0; 8], &pulls);
        for (p, q) in before.iter().zip(&after) {
            assert!(turn(*p).distance(*q) < 1.0, "{p} went to {q}");
        }
    }
}
