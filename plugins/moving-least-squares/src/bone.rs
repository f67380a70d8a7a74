//! A bone's weight on a vertex: integrals over the bone in closed form.
//!
//! Schaefer 2006, section 4 and its appendix, for weights `1 / distance^(2 a)`, a = 1 and 2. With x along the bone,
//! measured from the vertex' foot, and h the vertex' distance from the bone's line, all of them are combinations of
//! the integrals of `x^k / (x^2 + h^2)^a` for k = 0, 1, 2.

use glam::DVec2;

use crate::deformation::Falloff;

/// The integrals of weight times `(1-t)^2`, `t (1-t)` and `t^2`, t from 0 at the bone's root to 1 at its tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moments {
    pub(crate) root: f64,
    pub(crate) mixed: f64,
    pub(crate) tip: f64,
}

/// A vertex nearer to a bone's line than this share of its distance along it is taken to lie on the line: there the
/// closed forms are differences of huge numbers.
const ON_LINE: f64 = 1e-3;

/// The moments of the bone from `root` to `tip`, which must not be one place, at `v`, which must not lie on it.
pub(crate) fn moments(root: DVec2, tip: DVec2, v: DVec2, falloff: Falloff) -> Moments {
    let length = root.distance(tip);
    let along = (tip - root) / length;
    let foot = (v - root).dot(along);
    let h = along.perp_dot(v - root).abs();
    let (x0, x1) = (-foot, length - foot);
    let beyond = if x0 > 0.0 { x0 } else { -x1 };
    let [i0, i1, i2] =
        if beyond > 0.0 && h < ON_LINE * beyond { beyond_the_end(x0, x1, falloff) } else { beside(x0, x1, h, falloff) };
    // t = (x + foot) / length
    let first = (i1 + foot * i0) / length;
    let second = (i2 + 2.0 * foot * i1 + foot * foot * i0) / (length * length);
    Moments { root: (i0 - 2.0 * first + second).max(0.0), mixed: (first - second).max(0.0), tip: second.max(0.0) }
}

fn beside(x0: f64, x1: f64, h: f64, falloff: Falloff) -> [f64; 3] {
    let h2 = h * h;
    let (r0, r1) = (x0 * x0 + h2, x1 * x1 + h2);
    // The angle under which the bone is seen.
    let angle = (h * (x1 - x0)).atan2(h2 + x0 * x1);
    match falloff {
        Falloff::Gentle => [angle / h, 0.5 * (r1 / r0).ln(), (x1 - x0) - h * angle],
        Falloff::Steep => {
            let share = x1 / r1 - x0 / r0;
            [(share + angle / h) / (2.0 * h2), 0.5 * (1.0 / r0 - 1.0 / r1), 0.5 * (angle / h - share)]
        }
    }
}

fn beyond_the_end(x0: f64, x1: f64, falloff: Falloff) -> [f64; 3] {
    match falloff {
        Falloff::Gentle => [1.0 / x0 - 1.0 / x1, (x1 / x0).ln(), x1 - x0],
        Falloff::Steep => {
            let cube = |x: f64| 1.0 / (3.0 * x * x * x);
            let square = |x: f64| 1.0 / (2.0 * x * x);
            [cube(x0) - cube(x1), square(x0) - square(x1), 1.0 / x0 - 1.0 / x1]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;
    use proptest::prelude::*;

    fn by_sums(root: DVec2, tip: DVec2, v: DVec2, power: i32) -> Moments {
        let n = 200_000;
        let step = root.distance(tip) / f64::from(n);
        let (mut a, mut b, mut c) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let t = (f64::from(i) + 0.5) / f64::from(n);
            let w = step / root.lerp(tip, t).distance_squared(v).powi(power);
            a += w * (1.0 - t) * (1.0 - t);
            b += w * t * (1.0 - t);
            c += w * t * t;
        }
        Moments { root: a, mixed: b, tip: c }
    }

    #[test]
    fn closed_forms_are_the_integrals() {
        let (root, tip) = (dvec2(10.0, 20.0), dvec2(90.0, -5.0));
        let on = |t: f64, off: f64| root.lerp(tip, t) + (tip - root).normalize().perp() * off;
        for (falloff, power) in [(Falloff::Gentle, 1), (Falloff::Steep, 2)] {
            for (t, off) in [(0.5, 3.0), (0.1, -20.0), (-0.7, 0.05), (1.4, 0.0), (1.4, 0.04), (3.0, 100.0), (-0.2, 1.0)]
            {
                let v = on(t, off);
                let (found, truth) = (moments(root, tip, v, falloff), by_sums(root, tip, v, power));
                for (f, e) in [(found.root, truth.root), (found.mixed, truth.mixed), (found.tip, truth.tip)] {
                    assert!((f - e).abs() < 2e-5 * (truth.root + truth.tip), "{falloff:?} at {t}, {off}: {f} for {e}");
                }
            }
        }
    }

    proptest! {
        #[test]
        fn never_negative_never_endless(
            rx in -50.0..50.0f64, ry in -50.0..50.0f64, tx in -50.0..50.0f64, ty in -50.0..50.0f64,
            vx in -500.0..500.0f64, vy in -500.0..500.0f64,
        ) {
            let (root, tip, v) = (dvec2(rx, ry), dvec2(tx, ty), dvec2(vx, vy));
            prop_assume!(root.distance(tip) > 1e-3);
            let along = ((v - root).dot(tip - root) / root.distance_squared(tip)).clamp(0.0, 1.0);
            prop_assume!(root.lerp(tip, along).distance(v) > 1e-4);
            for falloff in [Falloff::Gentle, Falloff::Steep] {
                let m = moments(root, tip, v, falloff);
                prop_assert!(m.root.is_finite() && m.mixed.is_finite() && m.tip.is_finite());
                prop_assert!(m.root >= 0.0 && m.mixed >= 0.0 && m.tip >= 0.0 && m.root + m.tip > 0.0);
            }
        }
    }
}
