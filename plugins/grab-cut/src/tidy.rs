//! Cleaning a mask: parts that no limb touches go, and small holes close.

/// Holes up to this share of the creature's area close.
const HOLE: f64 = 0.004;

/// Keeps what holds a pixel of `anchors`, or the largest part where none does, and closes small holes. `free(i)` says
/// whether a pixel may change.
pub(crate) fn tidy(labels: &mut [bool], width: usize, anchors: &[usize], free: impl Fn(usize) -> bool) {
    let parts = components(labels, width);
    let mut kept = vec![false; parts.sizes.len()];
    for &a in anchors.iter().filter(|&&a| labels[a]) {
        kept[parts.of[a]] = true;
    }
    let creature: Vec<usize> = (0..parts.sizes.len()).filter(|&p| parts.label[p]).collect();
    if !creature.iter().any(|&p| kept[p])
        && let Some(&largest) = creature.iter().max_by_key(|&&p| parts.sizes[p])
    {
        kept[largest] = true;
    }
    let area: usize = creature.iter().filter(|&&p| kept[p]).map(|&p| parts.sizes[p]).sum();
    for i in 0..labels.len() {
        let part = parts.of[i];
        if labels[i] && !kept[part] && free(i) {
            labels[i] = false;
        } else if !labels[i] && !parts.border[part] && (parts.sizes[part] as f64) < HOLE * area as f64 && free(i) {
            labels[i] = true;
        }
    }
}

struct Components {
    of: Vec<usize>,
    sizes: Vec<usize>,
    label: Vec<bool>,
    /// Whether a part reaches the border.
    border: Vec<bool>,
}

/// Parts of equal label, joined at sides.
fn components(labels: &[bool], width: usize) -> Components {
    let height = labels.len() / width.max(1);
    let mut out =
        Components { of: vec![usize::MAX; labels.len()], sizes: Vec::new(), label: Vec::new(), border: Vec::new() };
    let mut stack = Vec::new();
    for start in 0..labels.len() {
        if out.of[start] != usize::MAX {
            continue;
        }
        let part = out.sizes.len();
        let (mut size, mut border) = (0, false);
        out.of[start] = part;
        stack.push(start);
        while let Some(i) = stack.pop() {
            size += 1;
            let (x, y) = (i % width, i / width);
            border |= x == 0 || y == 0 || x + 1 == width || y + 1 == height;
            let beside = [
                (x > 0).then(|| i - 1),
                (x + 1 < width).then_some(i + 1),
                (y > 0).then(|| i - width),
                (y + 1 < height).then_some(i + width),
            ];
            for j in beside.into_iter().flatten() {
                if out.of[j] == usize::MAX && labels[j] == labels[start] {
                    out.of[j] = part;
                    stack.push(j);
                }
            }
        }
        out.sizes.push(size);
        out.label.push(labels[start]);
        out.border.push(border);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_what_is_anchored_and_closes_small_holes() {
        let (w, h) = (60usize, 40usize);
        let mut labels: Vec<bool> = (0..w * h)
            .map(|i| {
                let (x, y) = (i % w, i / w);
                let body = (5..40).contains(&x) && (5..30).contains(&y) && (x, y) != (20, 20);
                let hole = (10..16).contains(&x) && (10..16).contains(&y);
                let speck = (50..55).contains(&x) && (5..10).contains(&y);
                body && !hole || speck
            })
            .collect();
        tidy(&mut labels, w, &[6 * w + 6], |_| true);
        assert!(labels[20 * w + 20], "one pixel closes");
        assert!(!labels[12 * w + 12], "a big hole stays");
        assert!(!labels[7 * w + 52], "the speck goes");
        assert!(labels[29 * w + 39]);
    }
}
