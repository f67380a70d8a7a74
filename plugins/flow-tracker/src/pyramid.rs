//! A picture's brightness at falling resolutions, from its own down.

/// One resolution.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Brightness, 0 to 255, row by row.
    pub(crate) pixels: Vec<f32>,
}

/// A picture, finest level first.
#[derive(Clone, Debug)]
pub(crate) struct Pyramid {
    pub(crate) levels: Vec<Level>,
}

/// The short side of the coarsest level is at least this.
const SHORTEST: usize = 20;

impl Pyramid {
    /// Of a picture's brightness.
    pub(crate) fn new(finest: Level) -> Self {
        let mut levels = vec![finest];
        while let Some(last) = levels.last()
            && last.width.min(last.height) >= 2 * SHORTEST
        {
            let half = last.halved();
            levels.push(half);
        }
        Self { levels }
    }
}

/// Brightness as it is kept: a byte a pixel.
pub(crate) fn luma(rgb: &[u8]) -> Vec<u8> {
    // Rec. 601, as cameras weigh it.
    let one = |p: &[u8]| 0.299 * f32::from(p[0]) + 0.587 * f32::from(p[1]) + 0.114 * f32::from(p[2]);
    rgb.chunks_exact(3).map(|p| one(p).round() as u8).collect()
}

impl Level {
    /// From what is kept.
    pub(crate) fn new(width: usize, height: usize, luma: &[u8]) -> Self {
        Self { width, height, pixels: luma.iter().map(|&v| f32::from(v)).collect() }
    }

    /// At half the resolution; the last row or column of odd sizes is left out.
    pub(crate) fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            let top = &self.pixels[2 * y * self.width..][..self.width];
            let bottom = &self.pixels[(2 * y + 1) * self.width..][..self.width];
            for x in 0..width {
                pixels.push(0.25 * (top[2 * x] + top[2 * x + 1] + bottom[2 * x] + bottom[2 * x + 1]));
            }
        }
        Self { width, height, pixels }
    }

    /// Brightness between pixel centres; the border's beyond it. `x` and `y` count from the first pixel's centre.
    #[inline]
    pub(crate) fn sample(&self, x: f32, y: f32) -> f32 {
        let x = x.clamp(0.0, (self.width - 1) as f32);
        let y = y.clamp(0.0, (self.height - 1) as f32);
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(self.width - 1), (y0 + 1).min(self.height - 1));
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let row = |y: usize| {
            let (a, b) = (self.pixels[y * self.width + x0], self.pixels[y * self.width + x1]);
            a + fx * (b - a)
        };
        let (a, b) = (row(y0), row(y1));
        a + fy * (b - a)
    }
}
