//! What lies under a brush.

use glam::Vec2;

use super::Drawing;
use crate::geometry::polygon;

/// Lines are followed to this share of the brush's radius.
const FINE: f32 = 0.1;
/// A brush is looked at every half radius, and so often at most.
const MOST: usize = 10_000;

impl Drawing {
    /// The strokes that a brush of this radius touches on its way, in the drawing's order: those whose line it touches,
    /// and the topmost filled shape under each place of its middle.
    pub fn strokes_under(&self, brush: &[Vec2], radius: f32) -> Vec<usize> {
        let brush: Vec<Vec2> = brush.iter().copied().filter(|p| p.is_finite()).collect();
        let radius = if radius.is_finite() { radius.max(0.0) } else { 0.0 };
        let Some(&start) = brush.first() else { return Vec::new() };
        let step = (0.5 * radius).max(0.5);
        let mut way = vec![start];
        for leg in brush.windows(2) {
            let steps = (leg[0].distance(leg[1]) / step).ceil().max(1.0) as usize;
            way.extend((1..=steps.min(MOST)).map(|k| leg[0].lerp(leg[1], k as f32 / steps.min(MOST) as f32)));
            if way.len() > MOST {
                break;
            }
        }
        let low = way.iter().copied().fold(Vec2::MAX, Vec2::min);
        let high = way.iter().copied().fold(Vec2::MIN, Vec2::max);
        let mut hit = vec![false; self.strokes.len()];
        let mut covered = vec![false; way.len()];
        for (s, stroke) in self.strokes.iter().enumerate().rev() {
            let Some(bounds) = stroke.bounds() else { continue };
            let reach = radius + 0.5 * stroke.pen.as_ref().map_or(0.0, |p| p.widest() as f32);
            let apart = bounds.x0 as f32 > high.x + reach
                || bounds.y0 as f32 > high.y + reach
                || (bounds.x1 as f32) < low.x - reach
                || (bounds.y1 as f32) < low.y - reach;
            if apart {
                continue;
            }
            let lines = stroke.flatten(f64::from((FINE * radius).max(0.05)));
            if stroke.pen.is_some() || stroke.fill.is_none() {
                hit[s] = lines.iter().any(|l| touches(l, &way, reach));
            }
            let Some(fill) = &stroke.fill else { continue };
            for (p, covered) in way.iter().zip(&mut covered).filter(|(_, covered)| !**covered) {
                let inside = if fill.even_odd { polygon::contain(&lines, *p) } else { winding(&lines, *p) != 0 };
                *covered = inside;
                hit[s] |= inside;
            }
        }
        (0..hit.len()).filter(|&s| hit[s]).collect()
    }
}

fn touches(line: &[Vec2], way: &[Vec2], reach: f32) -> bool {
    let near = |a: Vec2, b: Vec2| way.iter().any(|p| polygon::nearest_on_segment(a, b, *p).1.distance(*p) <= reach);
    match line {
        [one] => near(*one, *one),
        _ => line.windows(2).any(|l| near(l[0], l[1])),
    }
}

/// How often closed polygons go round a place.
fn winding(polygons: &[Vec<Vec2>], p: Vec2) -> i32 {
    let mut rounds = 0;
    for polygon in polygons {
        for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let side = (*b - *a).perp_dot(p - *a);
            match (a.y <= p.y, b.y <= p.y) {
                (true, false) if side > 0.0 => rounds += 1,
                (false, true) if side < 0.0 => rounds -= 1,
                _ => {}
            }
        }
    }
    rounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::sketch::{Fill, Paint, Pen, Stroke};
    use glam::vec2;
    use kurbo::BezPath;

    fn drawing(paths: &[(&str, bool)]) -> Drawing {
        let stroke = |(i, &(path, filled)): (usize, &(&str, bool))| Stroke {
            name: format!("s{i}"),
            path: BezPath::from_svg(path).expect("a path"),
            fill: filled.then_some(Fill { paint: Paint::Color([0; 3]), opacity: 1.0, even_odd: false }),
            pen: (!filled).then(|| Pen::plain(2.0)),
            ..Stroke::default()
        };
        Drawing { size: (200.0, 200.0), strokes: paths.iter().enumerate().map(stroke).collect(), groups: Vec::new() }
    }

    #[test]
    fn a_brush_takes_the_lines_it_touches_and_the_topmost_fill() {
        let own = drawing(&[
            ("M 0 0 H 200 V 200 H 0 Z", true),
            ("M 20 20 H 80 V 80 H 20 Z", true),
            ("M 50 150 H 150", false),
            ("M 50 120", false),
        ]);
        assert_eq!(own.strokes_under(&[vec2(50.0, 50.0)], 4.0), [1]);
        assert_eq!(own.strokes_under(&[vec2(100.0, 140.0), vec2(100.0, 160.0)], 1.0), [0, 2]);
        assert_eq!(own.strokes_under(&[vec2(50.0, 125.0)], 5.0), [0, 3]);
        assert!(own.strokes_under(&[vec2(300.0, 300.0), vec2(f32::NAN, 0.0)], 9.0).is_empty());
        assert!(own.strokes_under(&[], 9.0).is_empty());
    }
}
