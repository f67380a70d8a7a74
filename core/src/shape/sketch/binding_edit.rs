//! Edits of a binding that need more than a push to one of its lists.

use std::collections::HashSet;

use glam::Vec2;

use super::binding::RIGIDITY;
use super::{Binding, Drawing, Pin, SketchLayer, StrokeSetting};

/// The layer of what was in none when the first was made.
const BEHIND: &str = "background";

impl Binding {
    /// The stroke's setting, made if there is none.
    fn setting(&mut self, stroke: &str) -> &mut StrokeSetting {
        let found = self.strokes.iter().position(|s| s.stroke == stroke);
        let i = found.unwrap_or_else(|| {
            self.strokes.push(StrokeSetting { stroke: stroke.into(), ..StrokeSetting::default() });
            self.strokes.len() - 1
        });
        &mut self.strokes[i]
    }

    /// How stiff a stroke is; 1 by default.
    pub fn rigidity(&self, stroke: &str) -> f32 {
        self.strokes.iter().find(|s| s.stroke == stroke).map_or(1.0, |s| s.rigidity)
    }

    /// Makes a stroke stiffer or softer, within what is allowed.
    pub fn set_rigidity(&mut self, stroke: &str, rigidity: f32) {
        let (softest, stiffest) = RIGIDITY.into_inner();
        let rigidity = if rigidity.is_nan() { 1.0 } else { rigidity.clamp(softest, stiffest) };
        self.setting(stroke).rigidity = rigidity;
        self.forget_defaults();
    }

    /// Whether a stroke stands still.
    pub fn is_decoration(&self, stroke: &str) -> bool {
        self.strokes.iter().any(|s| s.stroke == stroke && s.decoration)
    }

    /// Makes a stroke stand still, or move again.
    pub fn set_decoration(&mut self, stroke: &str, decoration: bool) {
        self.setting(stroke).decoration = decoration;
        self.forget_defaults();
    }

    fn forget_defaults(&mut self) {
        self.strokes.retain(|s| s.decoration || s.rigidity != 1.0);
    }

    /// The pin nearest to a place, no farther than `reach`.
    pub fn pin_near(&self, at: Vec2, reach: f32) -> Option<usize> {
        nearest(self.pins.iter().map(|p| p.at), at, reach)
    }

    /// The control point nearest to a place, no farther than `reach`.
    pub fn point_near(&self, at: Vec2, reach: f32) -> Option<usize> {
        nearest(self.points.iter().map(|p| p.at), at, reach)
    }

    /// The joint nearest to a place, no farther than `reach`.
    pub fn joint_near(&self, at: Vec2, reach: f32) -> Option<usize> {
        nearest(self.joints.iter().map(|j| j.at), at, reach)
    }

    /// Pins a place of a layer, the nearest one where `layer` is empty.
    pub fn pin(&mut self, at: Vec2, layer: &str) {
        self.pins.push(Pin { at, layer: layer.into() });
    }

    /// Puts strokes into a layer, in front of all others if it is new, and takes them out of the layers they were in.
    /// What was in no layer before the first was made stays behind them, in a layer called `background`.
    pub fn put_in_layer(&mut self, drawing: &Drawing, strokes: &[usize], layer: &str) {
        let names: Vec<&str> =
            strokes.iter().filter_map(|&s| drawing.strokes.get(s)).map(|s| s.name.as_str()).collect();
        if self.layers.is_empty() {
            let name = if layer == BEHIND { format!("{BEHIND} 0") } else { BEHIND.into() };
            let all = drawing.strokes.iter().map(|s| s.name.clone()).collect();
            self.layers.push(SketchLayer { name, strokes: all });
        }
        let taken: HashSet<&str> = names.iter().copied().collect();
        self.layers.iter_mut().for_each(|l| l.strokes.retain(|s| !taken.contains(s.as_str())));
        if self.layers.iter().all(|l| l.name != layer) {
            self.layers.push(SketchLayer { name: layer.into(), strokes: Vec::new() });
        }
        if let Some(own) = self.layers.iter_mut().find(|l| l.name == layer) {
            own.strokes.extend(names.into_iter().map(String::from));
        }
    }

    /// Puts the strokes under a brush into a layer, as [`Self::put_in_layer`] does, and says which they were.
    pub fn paint_layer(&mut self, drawing: &Drawing, layer: &str, brush: &[Vec2], radius: f32) -> Vec<usize> {
        let hit = drawing.strokes_under(brush, radius);
        if !hit.is_empty() {
            self.put_in_layer(drawing, &hit, layer);
        }
        hit
    }

    /// Takes a layer away, with its joints: its strokes go to the first of the others, its points and pins to the nearest.
    pub fn remove_layer(&mut self, layer: &str) {
        let Some(i) = self.layers.iter().position(|l| l.name == layer) else { return };
        let gone = self.layers.remove(i);
        if let Some(first) = self.layers.first_mut() {
            first.strokes.extend(gone.strokes);
        }
        self.joints.retain(|j| j.layers.0 != layer && j.layers.1 != layer);
        let named = self.points.iter_mut().map(|p| &mut p.layer).chain(self.pins.iter_mut().map(|p| &mut p.layer));
        named.filter(|l| *l == layer).for_each(String::clear);
    }
}

fn nearest(places: impl Iterator<Item = Vec2>, at: Vec2, reach: f32) -> Option<usize> {
    let gaps = places.enumerate().map(|(i, p)| (p.distance(at), i)).filter(|g| g.0 <= reach);
    gaps.min_by(|a, b| a.0.total_cmp(&b.0)).map(|g| g.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    #[test]
    fn settings_are_kept_while_they_say_something() {
        let mut binding = Binding::default();
        binding.set_rigidity("a", 1e9);
        binding.set_decoration("a", true);
        assert_eq!((binding.rigidity("a"), binding.is_decoration("a"), binding.strokes.len()), (1e3, true, 1));
        binding.set_decoration("a", false);
        binding.set_rigidity("a", f32::NAN);
        assert!(binding.strokes.is_empty());
        binding.pin(vec2(5.0, 5.0), "");
        assert_eq!((binding.pin_near(vec2(7.0, 5.0), 3.0), binding.pin_near(vec2(9.0, 5.0), 3.0)), (Some(0), None));
    }
}
