//! Time in double-double precision, so that many short segments add up without loss.

/// `high + low`, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubleTime {
    /// The instant, rounded.
    pub high: f64,
    /// Rounding remainder.
    pub low: f64,
}

impl DoubleTime {
    /// A known instant.
    pub fn new(t: f64) -> DoubleTime {
        DoubleTime { high: t, low: 0.0 }
    }

    /// So much later. Two-sum: Knuth, The Art of Computer Programming 2, 3rd ed. (1997), §4.2.2, Theorem B.
    pub fn after(self, tau: f64) -> DoubleTime {
        let low = self.low + tau;
        let high = self.high + low;
        let part = high - self.high;
        let lost = (self.high - (high - part)) + (low - part);
        let rest = (self.low - (low - (low - self.low))) + (tau - (low - self.low));
        DoubleTime {
            high,
            low: lost + rest,
        }
    }

    /// From here to a known instant, s.
    pub fn until(self, t: f64) -> f64 {
        (t - self.high) - self.low
    }

    /// `ω t` as an angle and what rounding took from it, rad.
    pub fn phase(self, omega: f64) -> (f64, f64) {
        let angle = omega * self.high;
        (angle, omega.mul_add(self.high, -angle) + omega * self.low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A million tenths of an ulp are not lost.
    #[test]
    fn law_small_steps_add_up() {
        let mut t = DoubleTime::new(1.0);
        let step = 0.1 * f64::EPSILON;
        for _ in 0..1_000_000 {
            t = t.after(step);
        }
        assert!((t.until(1.0) + 1e6 * step).abs() < 1e-9 * 1e6 * step);
    }
}
