//! Which strokes are in which layer, the order in which they are painted, and where layers cross.
//!
//! Joints are proposed as in Live Sketch: one in the middle of each place at which the regions of two layers lie over each
//! other. Where a layer lies within another almost as a whole, such as eyes in a head, one joint would let it spin: it
//! gets two.

use std::collections::HashMap;

use glam::{Vec2, vec2};

use super::region::RegionGrid;
use super::{Binding, Drawing, LayerJoint};
use crate::error::Result;
use crate::job::Stage;
use crate::raster::{Mask, morphology};

/// The region of a layer that lies in another's by more than this share is held at two places.
const INLAID: f32 = 0.7;

/// The strokes of each layer of a binding, in the drawing's order.
pub(super) struct Layering {
    /// The layer of each stroke.
    pub(super) of: Vec<usize>,
    /// Whether each stroke stands still.
    pub(super) still: Vec<bool>,
    /// How stiff each stroke is.
    pub(super) rigidity: Vec<f32>,
    /// How many layers there are, one where none is named.
    pub(super) count: usize,
}

impl Layering {
    /// As `binding`, which was checked against `drawing`, says.
    pub(super) fn new(drawing: &Drawing, binding: &Binding) -> Self {
        let number: HashMap<&str, usize> =
            drawing.strokes.iter().enumerate().map(|(i, s)| (s.name.as_str(), i)).collect();
        let n = drawing.strokes.len();
        let (mut of, mut still, mut rigidity) = (vec![0; n], vec![false; n], vec![1.0; n]);
        for (l, layer) in binding.layers.iter().enumerate() {
            layer.strokes.iter().filter_map(|s| number.get(s.as_str())).for_each(|&s| of[s] = l);
        }
        for setting in &binding.strokes {
            if let Some(&s) = number.get(setting.stroke.as_str()) {
                (still[s], rigidity[s]) = (setting.decoration, setting.rigidity);
            }
        }
        Self { of, still, rigidity, count: binding.layers.len().max(1) }
    }

    /// The strokes of a layer that move.
    pub(super) fn moving(&self, layer: usize) -> Vec<usize> {
        (0..self.of.len()).filter(|&s| self.of[s] == layer && !self.still[s]).collect()
    }

    /// All strokes, the farthest first.
    pub(super) fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.of.len()).collect();
        order.sort_by_key(|&s| self.of[s]);
        order
    }
}

impl Drawing {
    /// Where the layers of `binding` should hold each other: one joint in the middle of each place at which two of them
    /// cross.
    ///
    /// # Errors
    /// The drawing or the binding is not valid, they do not belong together, or a cancel.
    pub fn propose_joints(&self, binding: &Binding, stage: Stage<'_>) -> Result<Vec<LayerJoint>> {
        stage.name("finding joints")?;
        self.validate()?;
        binding.check(self, None)?;
        let layering = Layering::new(self, binding);
        let moving: Vec<usize> = (0..self.strokes.len()).filter(|&s| !layering.still[s]).collect();
        let Some(grid) = RegionGrid::over(self, &moving) else { return Ok(Vec::new()) };
        let mut regions = Vec::with_capacity(layering.count);
        for layer in 0..layering.count {
            stage.at(layer as f64 / layering.count as f64)?;
            let strokes = layering.moving(layer);
            let ink = grid.ink(strokes.iter().map(|&s| &self.strokes[s]), stage.part(0.0, 0.0))?;
            regions.push(grid.region(&ink));
        }
        let mut joints = Vec::new();
        for (a, one) in regions.iter().enumerate() {
            for (b, other) in regions.iter().enumerate().skip(a + 1) {
                stage.at(1.0)?;
                let names = (binding.layers[a].name.clone(), binding.layers[b].name.clone());
                let places = crossings(&grid, one, other);
                joints.extend(places.into_iter().map(|at| LayerJoint { layers: names.clone(), at }));
            }
        }
        Ok(joints)
    }
}

/// Where two regions should be held together.
fn crossings(grid: &RegionGrid, one: &Mask, other: &Mask) -> Vec<Vec2> {
    let mut both = one.clone();
    both.intersect(other);
    let parts = morphology::parts(&both);
    let least = one.count().min(other.count()) as f32;
    let mut places = Vec::new();
    for (part, &area) in parts.areas.iter().enumerate() {
        // Rims that touch are no crossing.
        if (area as f32) < grid.expanded() * grid.expanded() {
            continue;
        }
        let cells: Vec<Vec2> = (0..parts.labels.height())
            .flat_map(|y| (0..parts.labels.width()).map(move |x| (x, y)))
            .filter(|&(x, y)| parts.labels.get(x, y) == part as u32 + 1)
            .map(|(x, y)| vec2(x as f32, y as f32))
            .collect();
        let n = cells.len() as f32;
        let middle = cells.iter().sum::<Vec2>() / n;
        // The middle of a crescent lies outside it.
        let nearest = |p: Vec2| {
            cells.iter().copied().min_by(|a, b| a.distance_squared(p).total_cmp(&b.distance_squared(p))).unwrap_or(p)
        };
        let place = |p: Vec2| grid.place(nearest(p) + 0.5);
        if area as f32 > INLAID * least {
            let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
            for c in &cells {
                let d = *c - middle;
                (xx, xy, yy) = (xx + d.x * d.x / n, xy + d.x * d.y / n, yy + d.y * d.y / n);
            }
            // The long axis, and the standard deviation along it.
            let angle = 0.5 * f32::atan2(2.0 * xy, xx - yy);
            let long = (0.5 * (xx + yy) + (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt()).sqrt();
            places.extend([-1.0, 1.0].map(|side| place(middle + side * long * Vec2::from_angle(angle))));
        } else {
            places.push(place(middle));
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Progress;
    use crate::shape::sketch::{BindPoint, Fill, Paint, Pen, Stroke};
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
    fn joints_are_where_layers_cross() {
        // A body, two legs that cross it, an eye within it, and something far off.
        let own = drawing(&[
            ("M 20 60 H 180 V 100 H 20 Z", true),
            ("M 50 80 V 180", false),
            ("M 150 80 V 180", false),
            ("M 100 70 h 12 v 6 h -12 z", true),
            ("M 10 10 h 10", false),
        ]);
        let mut binding = Binding::default();
        for (layer, strokes) in [("legs", vec![1, 2]), ("eye", vec![3]), ("sun", vec![4])] {
            binding.put_in_layer(&own, &strokes, layer);
        }
        let names: Vec<&str> = binding.layers.iter().map(|l| l.name.as_str()).collect();
        assert_eq!(names, ["background", "legs", "eye", "sun"]);
        assert_eq!(Layering::new(&own, &binding).order(), [0, 1, 2, 3, 4]);
        let joints = own.propose_joints(&binding, Progress::new().whole()).expect("valid");
        let of = |name: &str| joints.iter().filter(|j| j.layers.1 == name).map(|j| j.at).collect::<Vec<_>>();
        let legs = of("legs");
        assert_eq!(legs.len(), 2, "{joints:?}");
        assert!(legs.iter().zip([50.0, 150.0]).all(|(at, x)| at.distance(vec2(x, 90.0)) < 3.0), "{legs:?}");
        let eye = of("eye");
        assert_eq!(eye.len(), 2, "{joints:?}");
        assert!((eye[0].y - 73.0).abs() < 1.0 && (eye[1].x - eye[0].x) > 4.0, "{eye:?}");
        assert!(of("sun").is_empty());
        binding.joints = joints;
        binding.points.push(BindPoint { layer: "legs".into(), ..BindPoint::default() });
        binding.remove_layer("legs");
        binding.check(&own, None).expect("nothing is left of the legs");
        assert_eq!(binding.layers[0].strokes, ["s0", "s1", "s2"]);
    }
}
