//! Meshes that follow a few handles.

use marey_ffi::{MRY_HANDLE_BONE, MRY_HANDLE_POINT, mry_deformation, mry_handle, mry_point};

use crate::{Context, Result, sys};

/// What a person moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Handle {
    /// A point of the mesh.
    Point((f32, f32)),
    /// A straight bone from its root to its tip.
    Bone((f32, f32), (f32, f32)),
}

/// A mesh bound to its handles.
#[derive(Debug)]
pub struct Deformation {
    id: mry_deformation,
    context: Context,
}

impl Context {
    /// Binds a mesh to handles where they lie at rest. `deformer` is "arap", "needles" or a plugin's id, and empty for
    /// the first; `iterations` are the steps of one of its solves, 0 for the default.
    pub fn bind_mesh(
        &self,
        points: &[(f32, f32)],
        triangles: &[[u32; 3]],
        handles: &[Handle],
        deformer: &str,
        iterations: u32,
    ) -> Result<Deformation> {
        let points: Vec<mry_point> = points.iter().map(|&p| point(p)).collect();
        let id = sys::deformation(&self.0, &points, triangles, &raw(handles), deformer, iterations)?;
        Ok(Deformation { id, context: self.clone() })
    }
}

impl Deformation {
    /// The shape in which every handle is where `targets` say, starting from `shape`, which has a place for every point
    /// of the mesh and is given the new ones.
    pub fn solve(&self, targets: &[Handle], shape: &mut [(f32, f32)]) -> Result<()> {
        let mut points: Vec<mry_point> = shape.iter().map(|&p| point(p)).collect();
        sys::deformation_solve(&self.context.0, self.id, &raw(targets), &mut points)?;
        shape.iter_mut().zip(points).for_each(|(to, p)| *to = (p.x, p.y));
        Ok(())
    }
}

impl Drop for Deformation {
    fn drop(&mut self) {
        sys::deformation_destroy(&self.context.0, self.id);
    }
}

fn point((x, y): (f32, f32)) -> mry_point {
    mry_point { x, y }
}

fn raw(handles: &[Handle]) -> Vec<mry_handle> {
    let one = |handle: &Handle| match *handle {
        Handle::Point(at) => mry_handle { kind: MRY_HANDLE_POINT, reserved0: 0, a: point(at), b: point(at) },
        Handle::Bone(root, tip) => mry_handle { kind: MRY_HANDLE_BONE, reserved0: 0, a: point(root), b: point(tip) },
    };
    handles.iter().map(one).collect()
}
