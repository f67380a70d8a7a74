//! Symmetric positive definite systems on plane graphs: an order of elimination and a Cholesky factor.

mod cholesky;
mod dissection;
mod graph;
mod newton;

pub(crate) use cholesky::{Factor, Rows, Symbolic};
pub(crate) use graph::Graph;
pub(crate) use newton::{Fronts, Matrix};
