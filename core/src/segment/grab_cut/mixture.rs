//! A Gaussian mixture of colours, fitted by hard assignment.
//!
//! Rother, Kolmogorov and Blake 2004, "GrabCut": every colour belongs to one component, components are refitted to
//! theirs. The start is by k-means from seeds that lie far apart, the same on every run.

use glam::{DMat3, DVec3};

/// Components of a mixture, the paper's.
const COMPONENTS: usize = 5;
/// Rounds of k-means.
const ROUNDS: usize = 8;
/// Added to every variance, in squared levels: the flat colours of cartoons vary not at all.
const NOISE: f64 = 16.0;
/// The share of colours that may be any: how surprising is one that was never seen.
const ANY: f64 = 0.01;

/// What colours something has.
#[derive(Clone, Debug)]
pub(super) struct Mixture(Vec<Component>);

#[derive(Clone, Debug)]
struct Component {
    mean: DVec3,
    inverse: DMat3,
    /// Its weight times the density at its mean.
    height: f64,
}

impl Mixture {
    /// Of colours with levels in 0..=255; `None` of none.
    pub(super) fn fit(colours: &[DVec3]) -> Option<Self> {
        let mut centres = vec![*colours.first()?];
        while centres.len() < COMPONENTS {
            let away = |c: &DVec3| centres.iter().map(|m| m.distance_squared(*c)).fold(f64::INFINITY, f64::min);
            match colours.iter().max_by(|a, b| away(a).total_cmp(&away(b))) {
                Some(farthest) if away(farthest) > NOISE => centres.push(*farthest),
                _ => break,
            }
        }
        let nearest = |centres: &[DVec3], c: &DVec3| {
            let away = |i: &usize| centres[*i].distance_squared(*c);
            (0..centres.len()).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0)
        };
        let mut groups = vec![Vec::new(); centres.len()];
        for _ in 0..ROUNDS {
            groups.iter_mut().for_each(Vec::clear);
            colours.iter().for_each(|c| groups[nearest(&centres, c)].push(*c));
            for (centre, group) in centres.iter_mut().zip(&groups).filter(|(_, g)| !g.is_empty()) {
                *centre = group.iter().sum::<DVec3>() / group.len() as f64;
            }
        }
        let fitted = groups.iter().filter(|g| !g.is_empty()).map(|g| Component::of(g, colours.len()));
        Some(Self(fitted.collect()))
    }

    /// The natural logarithm of a colour's density.
    pub(super) fn log_density(&self, colour: DVec3) -> f64 {
        let own: f64 = self.0.iter().map(|c| c.density(colour)).sum();
        ((1.0 - ANY) * own + ANY / 256.0f64.powi(3)).ln()
    }
}

impl Component {
    fn of(colours: &[DVec3], all: usize) -> Self {
        let count = colours.len() as f64;
        let mean = colours.iter().sum::<DVec3>() / count;
        let mut covariance = DMat3::from_diagonal(DVec3::splat(NOISE));
        for c in colours {
            let d = *c - mean;
            covariance += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * (1.0 / count);
        }
        let height = count / all as f64 / (std::f64::consts::TAU.powi(3) * covariance.determinant()).sqrt();
        Self { mean, inverse: covariance.inverse(), height }
    }

    fn density(&self, colour: DVec3) -> f64 {
        let d = colour - self.mean;
        self.height * (-0.5 * d.dot(self.inverse * d)).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_as_likely_as_they_are_frequent() {
        let colours: Vec<DVec3> = (0..400)
            .map(|i| if i % 4 == 0 { DVec3::splat(20.0) } else { DVec3::new(200.0, 30.0, f64::from(i % 9)) })
            .collect();
        let mixture = Mixture::fit(&colours).expect("colours");
        let (dark, red) = (DVec3::splat(20.0), DVec3::new(200.0, 30.0, 4.0));
        assert!(mixture.log_density(dark) > mixture.log_density(DVec3::splat(120.0)) + 5.0);
        assert!(mixture.log_density(red) > mixture.log_density(DVec3::new(30.0, 200.0, 4.0)) + 5.0);
        assert!(Mixture::fit(&[]).is_none());
        let flat = Mixture::fit(&[dark; 10]).expect("colours");
        assert!(flat.log_density(dark).is_finite() && flat.log_density(red).is_finite());
    }
}
