//! The deformer as a plugin.

use glam::Vec2;
use marey_plugin::{Deformation as Bound, Deformer, Info, Job, Mesh, Parameter, Plugin, Point, Result, Values};
use marey_plugin::{Error as PluginError, Handle as Target, marey_plugin};

use crate::{Deformation, Error, Falloff, Handle, Settings};

/// The plugin.
#[derive(Debug)]
pub struct MovingLeastSquares {
    settings: Settings,
}

impl Plugin for MovingLeastSquares {
    const INFO: Info = Info::new("marey.moving-least-squares", "Moving least squares", env!("CARGO_PKG_VERSION"))
        .about(
            "Rigid moving least squares by points and bones. No iterations: the shape depends on the handles alone.",
        );
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::choice("falloff", "Falloff", &["gentle", "steep"], 1)
            .about("How fast a handle's pull falls with distance: by its square, or by its fourth power."),
        Parameter::switch("inside", "Measure inside", true)
            .about("Measures distance inside the mesh, so that a hand beside the hip does not drag it."),
    ];

    fn create(values: &Values<'_>) -> Result<Self> {
        let falloff = if values.choice("falloff")? == 0 { Falloff::Gentle } else { Falloff::Steep };
        Ok(Self { settings: Settings { falloff, inside: values.switch("inside")? } })
    }
}

impl Deformer for MovingLeastSquares {
    type Bound = BoundMesh;

    fn bind(&mut self, mesh: &Mesh<'_>, handles: &[Target], job: &Job<'_>) -> Result<BoundMesh> {
        let points: Vec<Vec2> = mesh.points.iter().map(|p| vector(*p)).collect();
        let go_on = |done: f64| job.at(done).is_ok();
        Deformation::bind(&points, mesh.triangles, &to_handles(handles), self.settings, &go_on)
            .map(|bound| BoundMesh { bound, points })
            .map_err(refuse)
    }
}

/// A bound mesh behind the door.
#[derive(Debug)]
pub struct BoundMesh {
    bound: Deformation,
    points: Vec<Vec2>,
}

impl Bound for BoundMesh {
    fn solve(&mut self, targets: &[Target], points: &mut [Point], job: &Job<'_>) -> Result<()> {
        if points.len() != self.points.len() {
            let message = format!("{} vertices, and {} were bound; bind again", points.len(), self.points.len());
            return Err(PluginError::invalid(message));
        }
        let go_on = |done: f64| job.at(done).is_ok();
        self.bound.solve(&to_handles(targets), &mut self.points, &go_on).map_err(refuse)?;
        for (to, p) in points.iter_mut().zip(&self.points) {
            *to = Point::new(p.x, p.y);
        }
        Ok(())
    }
}

fn vector(p: Point) -> Vec2 {
    Vec2::new(p.x, p.y)
}

fn to_handles(handles: &[Target]) -> Vec<Handle> {
    let one = |h: &Target| match *h {
        Target::Point(p) => Handle::Point(vector(p)),
        Target::Bone(root, tip) => Handle::Bone(vector(root), vector(tip)),
    };
    handles.iter().map(one).collect()
}

fn refuse(error: Error) -> PluginError {
    match error {
        Error::Cancelled => PluginError::cancelled(),
        other => PluginError::invalid(other.to_string()),
    }
}

marey_plugin! { deformer: MovingLeastSquares }

#[cfg(test)]
mod tests {
    use super::*;
    use marey_plugin::testing::Scene;

    #[test]
    fn bends_a_bar_through_the_door() {
        let points: Vec<Point> = (0..33).map(|i| Point::new((i % 11) as f32 * 10.0, (i / 11) as f32 * 10.0)).collect();
        let triangles: Vec<[u32; 3]> = (0..2u32)
            .flat_map(|r| (0..10).map(move |c| r * 11 + c))
            .flat_map(|i| [[i, i + 1, i + 12], [i, i + 12, i + 11]])
            .collect();
        let mesh = Mesh { points: &points, triangles: &triangles };
        let bone = |a: (f32, f32), b: (f32, f32)| Target::Bone(a.into(), b.into());
        let rest = [bone((0.0, 10.0), (50.0, 10.0)), bone((50.0, 10.0), (100.0, 10.0))];
        let bent = [rest[0], bone((50.0, 10.0), (50.0, 60.0))];
        let values = Values::defaults(MovingLeastSquares::PARAMETERS);
        let mut plugin = MovingLeastSquares::create(&values).expect("defaults");
        let moved = Scene::deform(&mut plugin, &mesh, &rest, &bent).expect("sound input");
        assert!(moved[21].distance(Point::new(50.0, 60.0)) < 1e-3, "the tip follows: {:?}", moved[21]);
        assert!(moved[11].distance(points[11]) < 1e-3, "the root stays: {:?}", moved[11]);
        let refused = Scene::deform(&mut plugin, &mesh, &rest, &[bent[0]]);
        assert!(refused.expect_err("one handle is missing").message().contains("2 were bound"));
    }
}
