//! A sketch's take as vectors that move: every curve stays a curve, and its bending is in its points.

pub(super) mod animated_svg;
pub(super) mod curve;
mod keys;
pub(super) mod lottie;
mod shade;

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::job::Stage;

/// Bytes of a file: more than any player opens.
const MOST_BYTES: usize = 64 << 20;

/// What `write` says of each of so many strokes, in their order.
fn of_each(count: usize, stage: Stage<'_>, write: impl Fn(usize) -> String + Sync) -> Result<Vec<String>> {
    let (done, bytes) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let one = |stroke: usize| {
        stage.at(done.fetch_add(1, Ordering::Relaxed) as f64 / count as f64)?;
        let text = write(stroke);
        let value = bytes.fetch_add(text.len(), Ordering::Relaxed) + text.len();
        if value > MOST_BYTES {
            let what = "how many bytes the file takes, counted up to where it is too many,".into();
            let remedy = "take fewer frames, simplify the drawing, or write a video or an animated picture".into();
            return Err(Error::Limit { what, value: value as u64, max: MOST_BYTES as u64, remedy });
        }
        Ok(text)
    };
    (0..count).into_par_iter().map(one).collect()
}

/// Writes `units` of which ten to the power of `decimals` are 1, without ends that say nothing. JSON wants a digit before
/// the point, SVG does not.
fn put(out: &mut String, units: i64, decimals: u32, zero: bool) {
    let one = 10u64.pow(decimals);
    let (whole, mut rest) = (units.unsigned_abs() / one, units.unsigned_abs() % one);
    if units < 0 {
        out.push('-');
    }
    if whole > 0 || zero || rest == 0 {
        out.push_str(&whole.to_string());
    }
    if rest > 0 {
        let mut digits = decimals as usize;
        while rest.is_multiple_of(10) {
            rest /= 10;
            digits -= 1;
        }
        out.push_str(&format!(".{rest:0digits$}"));
    }
}

/// A number as JSON and attributes of SVG have it.
fn text(value: f64, decimals: u32) -> String {
    let mut out = String::new();
    put(&mut out, units(value, decimals), decimals, true);
    out
}

fn units(value: f64, decimals: u32) -> i64 {
    // The cast cuts off at both ends, and makes 0 of what is not a number.
    (value * 10f64.powi(decimals as i32)).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_can_be() {
        let put = |units, zero| {
            let mut out = String::new();
            put(&mut out, units, 2, zero);
            out
        };
        let short = [-1250, -50, -7, 0, 5, 100, 101].map(|u| put(u, false));
        assert_eq!(short, ["-12.5", "-.5", "-.07", "0", ".05", "1", "1.01"]);
        assert_eq!(put(-50, true), "-0.5");
        assert_eq!(text(f64::NAN, 2), "0");
    }
}
