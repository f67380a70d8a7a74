//! Gaussian mixtures of colours at places, fitted by hard assignment.
//!
//! Rother, Kolmogorov and Blake 2004, "GrabCut", sections 2 and 3: every sample belongs to one component, components
//! are refitted to their samples, and so on. The start is k-means from seeds spread by their squared distances (Arthur
//! and Vassilvitskii 2007, "k-means++"), drawn from a fixed sequence so that a fit is the same on every run.

/// Rounds of k-means.
const K_MEANS_ROUNDS: usize = 8;

/// Numbers of a sample: x, y, red, green, blue.
pub(crate) const NUMBERS: usize = 5;
/// How many of them are its place.
const PLACE: usize = 2;
/// A colour at a place.
pub(crate) type Sample = [f32; NUMBERS];

/// A weighed sum of Gaussians, each with full covariances of colour and of place. Between the two there is none: it
/// would foretell colours where nothing was seen.
#[derive(Clone, Debug)]
pub(crate) struct Mixture {
    components: Vec<Component>,
    /// Share of colours that are any at all: how much a colour never seen is to be expected.
    any: f32,
}

#[derive(Clone, Debug)]
struct Component {
    mean: Sample,
    /// Rows of the inverse of the covariance's lower Cholesky factor, so that a distance is a sum of squares.
    whiten: [[f32; NUMBERS]; NUMBERS],
    /// Logarithms: of the weight times the place's norm, and of the colour's norm.
    place_scale: f32,
    colour_scale: f32,
}

impl Mixture {
    /// Fits up to `count` components. `floor` is added to the variances: what the numbers are exact to; `any` is
    /// the share of colours that are any at all. `None` without samples.
    pub(crate) fn fit(samples: &[Sample], count: usize, floor: Sample, any: f32) -> Option<Self> {
        let mut owner = k_means(samples, count)?;
        let mixture = Self::from_owners(samples, &owner, floor, any);
        // One hard assignment by density instead of distance: long thin clusters get their samples back.
        for (o, s) in owner.iter_mut().zip(samples) {
            *o = mixture.likeliest(s);
        }
        Some(Self::from_owners(samples, &owner, floor, any))
    }

    fn from_owners(samples: &[Sample], owner: &[usize], floor: Sample, any: f32) -> Self {
        let count = owner.iter().max().map_or(0, |m| m + 1);
        let mut sums = vec![(0.0f64, [0.0f64; NUMBERS], [[0.0f64; NUMBERS]; NUMBERS]); count];
        for (s, &o) in samples.iter().zip(owner) {
            let (n, first, second) = &mut sums[o];
            *n += 1.0;
            for i in 0..NUMBERS {
                first[i] += f64::from(s[i]);
                for j in 0..=i {
                    second[i][j] += f64::from(s[i]) * f64::from(s[j]);
                }
            }
        }
        let total = samples.len() as f64;
        let components = sums.iter().filter(|(n, ..)| *n > 0.0).filter_map(|(n, first, second)| {
            let mean = first.map(|v| v / n);
            let mut covariance = [[0.0f64; NUMBERS]; NUMBERS];
            for i in 0..NUMBERS {
                for j in 0..=i {
                    if (i < PLACE) == (j < PLACE) {
                        covariance[i][j] = second[i][j] / n - mean[i] * mean[j];
                    }
                }
                covariance[i][i] = covariance[i][i].max(0.0) + f64::from(floor[i]);
            }
            Component::new(n / total, mean, &covariance)
        });
        Self { components: components.collect(), any }
    }

    fn likeliest(&self, sample: &Sample) -> usize {
        let mut best = (f32::NEG_INFINITY, 0);
        for (i, c) in self.components.iter().enumerate() {
            let (place, colour) = c.log_densities(sample);
            if place + colour > best.0 {
                best = (place + colour, i);
            }
        }
        best.1
    }

    /// The logarithm of the density of the sample's colour, of all that are seen at its place.
    #[inline]
    pub(crate) fn log_colour_at_place(&self, sample: &Sample) -> f32 {
        let mut nearest = f32::NEG_INFINITY;
        for c in &self.components {
            nearest = nearest.max(c.log_place(sample));
        }
        // Far from all components the nearest one decides, however far it is.
        let (mut here, mut both) = (0.0f32, 0.0f32);
        for c in &self.components {
            let (place, colour) = c.log_densities(sample);
            let weight = (place - nearest).exp();
            here += weight;
            if weight > 1e-4 {
                both += weight * colour.exp();
            }
        }
        let any = self.any / (256.0 * 256.0 * 256.0);
        ((1.0 - self.any) * both / here.max(f32::MIN_POSITIVE) + any).ln()
    }
}

impl Component {
    /// `None` where the covariance is not positive definite.
    fn new(weight: f64, mean: [f64; NUMBERS], covariance: &[[f64; NUMBERS]; NUMBERS]) -> Option<Self> {
        let mut lower = [[0.0f64; NUMBERS]; NUMBERS];
        for i in 0..NUMBERS {
            for j in 0..=i {
                let mut v = covariance[i][j];
                for k in 0..j {
                    v -= lower[i][k] * lower[j][k];
                }
                if i == j {
                    if v <= 0.0 || !v.is_finite() {
                        return None;
                    }
                    lower[i][i] = v.sqrt();
                } else {
                    lower[i][j] = v / lower[j][j];
                }
            }
        }
        let mut whiten = [[0.0f64; NUMBERS]; NUMBERS];
        for column in 0..NUMBERS {
            for row in column..NUMBERS {
                let mut v = if row == column { 1.0 } else { 0.0 };
                for k in column..row {
                    v -= lower[row][k] * whiten[k][column];
                }
                whiten[row][column] = v / lower[row][row];
            }
        }
        let norm = |numbers: std::ops::Range<usize>| -> f64 {
            numbers.map(|i| -lower[i][i].ln() - 0.5 * std::f64::consts::TAU.ln()).sum()
        };
        Some(Self {
            mean: mean.map(|v| v as f32),
            whiten: whiten.map(|row| row.map(|v| v as f32)),
            place_scale: (weight.ln() + norm(0..PLACE)) as f32,
            colour_scale: norm(PLACE..NUMBERS) as f32,
        })
    }

    #[inline]
    fn log_place(&self, sample: &Sample) -> f32 {
        let (x, y) = (sample[0] - self.mean[0], sample[1] - self.mean[1]);
        let (u, v) = (self.whiten[0][0] * x, self.whiten[1][0] * x + self.whiten[1][1] * y);
        self.place_scale - 0.5 * (u * u + v * v)
    }

    /// Of the place with the component's weight, and of the colour.
    #[inline]
    fn log_densities(&self, sample: &Sample) -> (f32, f32) {
        let mut off = [0.0; NUMBERS];
        for i in PLACE..NUMBERS {
            off[i] = sample[i] - self.mean[i];
        }
        let mut sum = 0.0;
        for i in PLACE..NUMBERS {
            let mut v = 0.0;
            for j in PLACE..=i {
                v += self.whiten[i][j] * off[j];
            }
            sum += v * v;
        }
        (self.log_place(sample), self.colour_scale - 0.5 * sum)
    }
}

fn squared_distance(a: &Sample, b: &Sample) -> f32 {
    let mut sum = 0.0;
    for i in 0..NUMBERS {
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    }
    sum
}

/// The cluster of every sample.
fn k_means(samples: &[Sample], count: usize) -> Option<Vec<usize>> {
    let mut centres = vec![*samples.first()?];
    let mut nearest: Vec<f32> = samples.iter().map(|s| squared_distance(s, &centres[0])).collect();
    // The golden ratio's multiples are spread evenly over 0..1.
    let mut share = 0.5f64;
    while centres.len() < count.max(1) {
        let total: f64 = nearest.iter().map(|&d| f64::from(d)).sum();
        if total <= 0.0 {
            break;
        }
        share = (share + 0.618_033_988_749_894_9).fract();
        let mut left = share * total;
        let chosen = nearest.iter().position(|&d| {
            left -= f64::from(d);
            left < 0.0
        });
        let centre = samples[chosen.unwrap_or(samples.len() - 1)];
        centres.push(centre);
        for (n, s) in nearest.iter_mut().zip(samples) {
            *n = n.min(squared_distance(s, &centre));
        }
    }
    let mut owner = vec![0; samples.len()];
    for _ in 0..K_MEANS_ROUNDS {
        let mut sums = vec![(0.0f64, [0.0f64; NUMBERS]); centres.len()];
        let mut moved = false;
        for (o, s) in owner.iter_mut().zip(samples) {
            let mut best = (f32::INFINITY, 0);
            for (i, c) in centres.iter().enumerate() {
                let d = squared_distance(s, c);
                if d < best.0 {
                    best = (d, i);
                }
            }
            moved |= *o != best.1;
            *o = best.1;
            sums[best.1].0 += 1.0;
            for i in 0..NUMBERS {
                sums[best.1].1[i] += f64::from(s[i]);
            }
        }
        if !moved {
            break;
        }
        for (c, (n, sum)) in centres.iter_mut().zip(&sums) {
            if *n > 0.0 {
                *c = sum.map(|v| (v / n) as f32);
            }
        }
    }
    Some(owner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White at the left and red at the right; a fifth of the left is black.
    fn two_places() -> Vec<Sample> {
        let mut samples = Vec::new();
        for i in 0..1000 {
            let a = i as f32 * 2.399_963;
            let r = 20.0 * ((i as f32 + 0.5) / 1000.0).sqrt();
            let left = if i % 5 == 0 { 10.0 } else { 240.0 };
            let noise = (i % 7) as f32;
            samples.push([50.0 + r * a.cos(), 50.0 + r * a.sin(), left + noise, left, left - noise]);
            samples.push([150.0 + r * a.cos(), 50.0 + r * a.sin(), 200.0 - noise, 20.0, 20.0 + noise]);
        }
        samples
    }

    #[test]
    fn tells_what_colours_there_are_where() {
        let mixture = Mixture::fit(&two_places(), 3, [4.0; 5], 0.01).expect("samples");
        let at = |x: f32, colour: f32| mixture.log_colour_at_place(&[x, 50.0, colour, colour, colour]);
        assert!(at(50.0, 240.0) > at(150.0, 240.0) + 5.0, "white is at the left");
        let share = (at(50.0, 13.0) - at(50.0, 243.0)).exp();
        assert!((share - 0.25).abs() < 0.05, "a fifth against four: {share}");
        assert!(at(-4000.0, 240.0).is_finite());
    }

    #[test]
    fn one_colour_is_a_component_and_nothing_is_none() {
        let mixture = Mixture::fit(&[[7.0; 5]; 50], 5, [1.0; 5], 0.01).expect("samples");
        assert_eq!(mixture.components.len(), 1);
        assert!(mixture.log_colour_at_place(&[7.0; 5]) > mixture.log_colour_at_place(&[7.0, 7.0, 9.0, 9.0, 9.0]));
        assert!(Mixture::fit(&[], 5, [1.0; 5], 0.01).is_none());
    }
}
