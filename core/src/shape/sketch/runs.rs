//! In which steps a drawing is painted: strokes in their order, and the groups that change how they look around them.
//!
//! Where layers have taken a group's strokes apart, each run of them is a group of its own: a group can hold only what is
//! painted together. Groups that change nothing are left out.

use super::Drawing;

/// A step of painting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// What follows, until it is left, belongs to this group.
    Enter(usize),
    /// A stroke.
    Paint(usize),
    /// The group entered last ends.
    Leave,
}

/// The steps for strokes in this order, the farthest first.
pub(crate) fn steps(drawing: &Drawing, order: &[usize]) -> Vec<Step> {
    let mut steps = Vec::with_capacity(order.len());
    let mut open: Vec<usize> = Vec::new();
    let mut last = None;
    for &stroke in order {
        let Some(group) = drawing.strokes.get(stroke).map(|s| s.group) else { continue };
        if last != Some(group) {
            let wanted = enclosing(drawing, group);
            let shared = open.iter().zip(&wanted).take_while(|(a, b)| a == b).count();
            steps.extend(open.drain(shared..).map(|_| Step::Leave));
            steps.extend(wanted[shared..].iter().map(|g| Step::Enter(*g)));
            open = wanted;
            last = Some(group);
        }
        steps.push(Step::Paint(stroke));
    }
    steps.extend(open.iter().map(|_| Step::Leave));
    steps
}

/// The groups around a stroke that change how it looks, from outside in.
pub(crate) fn enclosing(drawing: &Drawing, group: Option<usize>) -> Vec<usize> {
    let mut groups = Vec::new();
    let mut at = group;
    while let Some((index, group)) = at.and_then(|g| Some((g, drawing.groups.get(g)?))) {
        if group.opacity < 1.0 || group.clip.is_some() {
            groups.push(index);
        }
        // Parents come earlier; what says otherwise would go round for ever.
        at = group.parent.filter(|p| *p < index);
    }
    groups.reverse();
    groups
}

#[cfg(test)]
mod tests {
    use super::Step::{Enter, Leave, Paint};
    use super::*;
    use crate::shape::sketch::{Group, Stroke};

    fn group(parent: Option<usize>, opacity: f32) -> Group {
        Group { name: String::new(), parent, opacity, clip: None }
    }

    #[test]
    fn a_group_that_is_interrupted_becomes_two() {
        let groups = vec![group(None, 0.5), group(Some(0), 1.0), group(Some(1), 0.3)];
        let stroke = |group| Stroke { group, ..Stroke::default() };
        let strokes = vec![stroke(Some(2)), stroke(Some(1)), stroke(None), stroke(Some(0)), stroke(Some(9))];
        let drawing = Drawing { size: (1.0, 1.0), strokes, groups };
        let expected =
            [Enter(0), Enter(2), Paint(0), Leave, Paint(1), Leave, Paint(2), Enter(0), Paint(3), Leave, Paint(4)];
        assert_eq!(steps(&drawing, &[0, 1, 2, 3, 4, 77]), expected);
    }

    #[test]
    fn groups_that_name_each_other_as_parents_end() {
        let drawing = Drawing { groups: vec![group(Some(1), 0.5), group(Some(0), 0.5)], ..Drawing::default() };
        assert_eq!(enclosing(&drawing, Some(1)), [0, 1]);
    }
}
