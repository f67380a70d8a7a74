//! The energy of one picture's labels, and the labels of least energy.
//!
//! Rother 2004, equations 2, 4 and 11: what each pixel's colour says, and a price for parting neighbours that falls
//! with their contrast, `gamma exp(-beta |difference|^2) / distance`, beta from the picture's mean contrast.

use crate::max_flow::MaxFlow;

/// Whole capacities for one unit of energy.
const UNITS: f32 = 64.0;
/// More than any pixel's arcs can carry.
const FIXED: i32 = 1 << 24;
/// Even arcs of [`MaxFlow`] as steps.
const PAIRS: [(usize, isize, isize, f32); 4] =
    [(0, 1, 0, 1.0), (2, 0, 1, 1.0), (4, 1, 1, std::f32::consts::SQRT_2), (6, -1, 1, std::f32::consts::SQRT_2)];

/// What is known of a pixel before the cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Say {
    /// Evidence for the creature (positive) or against it, as a natural logarithm.
    Evidence(f32),
    /// Decided.
    Fixed(bool),
    /// Decided, and so far from anything undecided that it need not be in the graph.
    Outside(bool),
}

/// Labels of a picture `width` wide; `true` for the creature. `None` when `go_on` said no.
pub(crate) fn cut(
    width: usize,
    colours: &[[u8; 3]],
    says: &[Say],
    gamma: f32,
    go_on: impl FnMut() -> bool,
) -> Option<Vec<bool>> {
    let height = colours.len() / width.max(1);
    let difference = |i: usize, j: usize| {
        let d = |c: usize| f32::from(colours[i][c]) - f32::from(colours[j][c]);
        d(0) * d(0) + d(1) * d(1) + d(2) * d(2)
    };
    let pairs = |i: usize| {
        let (x, y) = (i % width, i / width);
        PAIRS.into_iter().filter_map(move |(arc, dx, dy, far)| {
            let (nx, ny) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            (nx < width && ny < height).then_some((arc, ny * width + nx, far))
        })
    };
    let inside = |i: usize| !matches!(says[i], Say::Outside(_));
    let (mut sum, mut n) = (0.0f64, 0.0f64);
    for i in (0..colours.len()).filter(|&i| inside(i)) {
        for (_, j, _) in pairs(i).filter(|p| inside(p.1)) {
            sum += f64::from(difference(i, j));
            n += 1.0;
        }
    }
    let mean = if n > 0.0 { (sum / n) as f32 } else { 0.0 };
    let beta = if mean > 1e-3 { 1.0 / (2.0 * mean) } else { 0.0 };
    let mut flow = MaxFlow::new(width, height);
    for i in (0..colours.len()).filter(|&i| inside(i)) {
        let (x, y) = (i % width, i / width);
        let unary = match says[i] {
            Say::Evidence(e) => (e * UNITS).round() as i32,
            Say::Fixed(creature) | Say::Outside(creature) => {
                if creature {
                    FIXED
                } else {
                    -FIXED
                }
            }
        };
        flow.add_unary(x, y, unary);
        for (arc, j, far) in pairs(i).filter(|p| inside(p.1)) {
            let price = gamma * (-beta * difference(i, j)).exp() / far;
            flow.set_pair(x, y, arc, (price * UNITS).round() as i32);
        }
    }
    if !flow.run(go_on) {
        return None;
    }
    let labels = says.iter().enumerate().map(|(i, say)| match say {
        Say::Fixed(creature) | Say::Outside(creature) => *creature,
        Say::Evidence(_) => flow.is_source(i % width, i / width),
    });
    Some(labels.collect())
}
