//! Undo and redo: steps of edits, one a gesture, without an end.

use std::mem::take;

use super::document::{Document, Inputs};
use super::edit::Edit;
use crate::error::Result;

/// What takes the document from one state to another, and what a person calls it.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) label: String,
    /// To be applied in this order.
    pub(super) edits: Vec<Edit>,
    /// The number of the state that it leads to.
    pub(super) leads_to: u64,
}

/// The steps back and forward from the present state.
#[derive(Debug, Default)]
pub(super) struct History {
    pub(super) back: Vec<Step>,
    pub(super) forward: Vec<Step>,
    /// The number of the present state; two states of one number are the same.
    pub(super) state: u64,
}

impl History {
    /// Remembers how to go back from the new state `number`.
    pub(super) fn did(&mut self, label: String, inverse: Vec<Edit>, number: u64) {
        self.forward.clear();
        self.back.push(Step { label, edits: inverse, leads_to: self.state });
        self.state = number;
    }

    /// Moves over the last step back or forward, which has been applied and whose inverse this is.
    pub(super) fn moved(&mut self, back: bool, label: String, inverse: Vec<Edit>, unknown: u64) {
        let (from, to) = if back { (&mut self.back, &mut self.forward) } else { (&mut self.forward, &mut self.back) };
        // After a restart there may be no step to say which state this is: then it is a new one.
        let leads_to = from.pop().map_or(unknown, |step| step.leads_to);
        to.push(Step { label, edits: inverse, leads_to: self.state });
        self.state = leads_to;
    }
}

/// Applies all edits, or none; gives those that take them back, in the order to apply them.
pub(super) fn apply_all(document: &mut Document, edits: &[Edit]) -> Result<Vec<Edit>> {
    let mut inverse = Vec::with_capacity(edits.len());
    for edit in edits {
        match edit.apply(document) {
            Ok(back) => inverse.push(back),
            Err(error) => {
                take_back(document, &inverse);
                return Err(error);
            }
        }
    }
    inverse.reverse();
    Ok(inverse)
}

/// Applies the inverses of edits, the last one first.
pub(super) fn take_back(document: &mut Document, inverses: &[Edit]) {
    for edit in inverses.iter().rev() {
        // It fits: it was made from the state that it is applied to.
        let applied = edit.apply(document);
        debug_assert!(applied.is_ok(), "{applied:?}");
    }
}

/// A step in the making: a stroke being drawn, a slider being dragged.
#[derive(Debug)]
pub(super) struct Gesture {
    pub(super) label: String,
    /// The inputs before it.
    pub(super) before: Inputs,
    pub(super) done: Vec<Edit>,
    /// The inverse of each.
    pub(super) inverses: Vec<Edit>,
}

impl Gesture {
    /// Applies an edit. One that replaces the last one leaves a single change of the two.
    pub(super) fn apply(&mut self, document: &mut Document, edit: Edit) -> Result<()> {
        let inverse = edit.apply(document)?;
        match self.done.last_mut() {
            Some(last) if edit.replaces(last) => *last = edit,
            _ => {
                self.done.push(edit);
                self.inverses.push(inverse);
            }
        }
        // Back where it began: nothing happened.
        if self.done.last() == self.inverses.last() {
            self.done.pop();
            self.inverses.pop();
        }
        Ok(())
    }

    /// The edits that take all of it back, in the order to apply them.
    pub(super) fn take_inverse(&mut self) -> Vec<Edit> {
        let mut inverse = take(&mut self.inverses);
        inverse.reverse();
        inverse
    }
}
