//! Cubic by values and slopes at both ends (Hermite).

/// A cubic by values and slopes at both ends.
#[derive(Debug, Clone, Copy)]
pub struct HermiteCubic {
    /// Argument and value of both ends.
    pub ends: [(f64, f64); 2],
    /// Slopes there.
    pub slopes: [f64; 2],
}

impl HermiteCubic {
    /// Width, place within it, and the coefficients of s, s² and s³ as slopes.
    fn parts(&self, x: f64) -> (f64, f64, [f64; 3]) {
        let ([(x0, y0), (x1, y1)], [a, b]) = (self.ends, self.slopes);
        let h = x1 - x0;
        let chord = (y1 - y0) / h;
        (
            h,
            (x - x0) / h,
            [a, 3.0 * chord - 2.0 * a - b, a + b - 2.0 * chord],
        )
    }

    /// Value at an argument.
    pub fn value(&self, x: f64) -> f64 {
        let (h, s, [a, b, c]) = self.parts(x);
        self.ends[0].1 + h * s * (a + s * (b + s * c))
    }

    /// Slope at an argument.
    pub fn slope(&self, x: f64) -> f64 {
        let (_, s, [a, b, c]) = self.parts(x);
        a + s * (2.0 * b + s * 3.0 * c)
    }

    /// Integral from its first end.
    pub fn area(&self, x: f64) -> f64 {
        let (h, s, [a, b, c]) = self.parts(x);
        h * s * (self.ends[0].1 + h * s * (a / 2.0 + s * (b / 3.0 + s * c / 4.0)))
    }

    /// Solves a rising cubic for the argument of a value between those of the ends: Newton's step, halved in where it would leave the
    /// bracket.
    pub fn solve(&self, y: f64) -> f64 {
        let [mut low, mut high] = [self.ends[0].0, self.ends[1].0];
        let mut x = low + (high - low) * (y - self.ends[0].1) / (self.ends[1].1 - self.ends[0].1);
        for _ in 0..100 {
            let miss = self.value(x) - y;
            if miss == 0.0 {
                return x;
            }
            if miss < 0.0 {
                low = x
            } else {
                high = x
            }
            let newton = x - miss / self.slope(x);
            let next = match newton > low && newton < high {
                true => newton,
                false => 0.5 * (low + high),
            };
            if next == x || high - low <= f64::EPSILON * high {
                return next;
            }
            x = next;
        }
        x
    }
}
