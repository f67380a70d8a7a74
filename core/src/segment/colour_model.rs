//! Soft colour histograms.
//!
//! Counts are whole numbers, so sums over frames do not depend on who adds first; softness (a blur over
//! neighbouring bins) comes after counting. Reinert 2016 (section 3.6) uses 50 bins a channel and a blur of 2 bins.

/// Counts of colours, `bins` a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    bins: usize,
    counts: Vec<u32>,
    total: u64,
}

impl Counts {
    pub(super) fn new(bins: usize) -> Self {
        Self { bins, counts: vec![0; bins * bins * bins], total: 0 }
    }

    #[inline]
    pub(super) fn add(&mut self, colour: [u8; 3], weight: u32) {
        self.counts[bin(self.bins, colour)] += weight;
        self.total += u64::from(weight);
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(a, b)| *a += b);
        self.total += other.total;
    }

    /// How much was counted.
    pub(super) fn total(&self) -> u64 {
        self.total
    }

    /// The density over colours, blurred by a Gaussian of `sigma` bins: 1 is what even colours would have. 1
    /// everywhere when nothing was counted.
    pub(super) fn density(&self, sigma: f32) -> Density {
        let bins = self.bins;
        if self.total == 0 {
            return Density { bins, values: vec![1.0; self.counts.len()] };
        }
        let scale = self.counts.len() as f32 / self.total as f32;
        let mut values: Vec<f32> = self.counts.iter().map(|&c| c as f32 * scale).collect();
        let reach = (2.5 * sigma).ceil() as usize;
        let kernel: Vec<f32> = (0..=reach).map(|i| (-0.5 * (i as f32 / sigma.max(1e-3)).powi(2)).exp()).collect();
        let sum = kernel[0] + 2.0 * kernel[1..].iter().sum::<f32>();
        let kernel: Vec<f32> = kernel.iter().map(|k| k / sum).collect();
        let mut blurred = vec![0.0f32; values.len()];
        for step in [1, bins, bins * bins] {
            // Colours are sparse: spreading what is there beats gathering everywhere.
            blurred.fill(0.0);
            for (i, &v) in values.iter().enumerate() {
                if v <= 0.0 {
                    continue;
                }
                let at = i / step % bins;
                blurred[i] += v * kernel[0];
                for (k, w) in kernel.iter().enumerate().skip(1) {
                    // What would fall off the end stays in the last bin: black and white are colours, too.
                    blurred[i + k.min(bins - 1 - at) * step] += v * w;
                    blurred[i - k.min(at) * step] += v * w;
                }
            }
            std::mem::swap(&mut values, &mut blurred);
        }
        Density { bins, values }
    }
}

/// A density over colours.
#[derive(Clone, Debug)]
pub(super) struct Density {
    bins: usize,
    values: Vec<f32>,
}

impl Density {
    #[inline]
    pub(super) fn of(&self, colour: [u8; 3]) -> f32 {
        self.values[bin(self.bins, colour)]
    }
}

#[inline]
fn bin(bins: usize, colour: [u8; 3]) -> usize {
    let [r, g, b] = colour.map(|v| (usize::from(v) * bins) >> 8);
    (r * bins + g) * bins + b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blur_keeps_the_sum_and_prefers_what_was_counted() {
        let mut counts = Counts::new(16);
        (0..40).for_each(|i| counts.add([200, 30 + i, 255], 2));
        let density = counts.density(1.0);
        let mean = density.values.iter().sum::<f32>() / density.values.len() as f32;
        assert!((mean - 1.0).abs() < 1e-3, "{mean}");
        assert!(density.of([200, 50, 255]) > 20.0 * density.of([200, 120, 255]).max(1.0));
        assert!(density.of([210, 50, 240]) > 1.0, "neighbouring colours count, too");
        assert_eq!(Counts::new(4).density(1.0).of([1, 2, 3]), 1.0);
    }
}
