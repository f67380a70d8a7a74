//! Brush strokes as known pixels.

use glam::{Vec2, vec2};

use crate::footage::Known;

/// Sets every pixel whose centre is within `radius` of the path, in a picture `width` pixels wide with one entry a
/// pixel. A single point is a dot.
pub fn brush(known: &mut [Known], width: usize, path: &[Vec2], radius: f32, what: Known) {
    if width == 0 {
        return;
    }
    let size = vec2(width as f32, (known.len() / width) as f32);
    let starts = path.iter().copied();
    let ends = path.iter().copied().skip(1).chain(path.last().copied().filter(|_| path.len() == 1));
    for (from, to) in starts.zip(ends) {
        let low = (from.min(to) - radius).clamp(Vec2::ZERO, size);
        let high = (from.max(to) + radius).clamp(Vec2::ZERO, size);
        let along = to - from;
        for y in low.y.floor() as usize..high.y.ceil() as usize {
            for x in low.x.floor() as usize..high.x.ceil() as usize {
                let centre = vec2(x as f32 + 0.5, y as f32 + 0.5);
                let t = (centre - from).dot(along) / along.length_squared().max(1e-12);
                if centre.distance(from + along * t.clamp(0.0, 1.0)) <= radius {
                    known[y * width + x] = what;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paints_a_capsule_and_a_dot_also_over_the_border() {
        let mut known = vec![Known::Nothing; 40 * 30];
        brush(&mut known, 40, &[vec2(10.0, 10.0), vec2(20.0, 10.0)], 3.0, Known::Creature);
        brush(&mut known, 40, &[vec2(40.0, 30.0)], 4.0, Known::Background);
        let count = |what| known.iter().filter(|k| **k == what).count();
        assert!((80..=96).contains(&count(Known::Creature)), "{}", count(Known::Creature));
        assert!((9..=16).contains(&count(Known::Background)), "{}", count(Known::Background));
        assert_eq!(known[10 * 40 + 15], Known::Creature);
        brush(&mut known, 40, &[], 4.0, Known::Background);
    }
}
