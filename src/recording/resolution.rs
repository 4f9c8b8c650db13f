//! Resolution of time stamps: the value of one unit of the last digit.

/// Resolution of stamps: the same everywhere, or coarser the larger the number where a fixed count of significant digits was written
/// (`%.5g` writes 9.9998, then 10.000, 10.001).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Resolution {
    /// One unit of the finest digit written, s.
    pub finest_s: f64,
    significant: Option<SignificantDigits>,
}

/// Numbers of a fixed count of significant digits.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SignificantDigits {
    digits: i32,
    /// The first stamp, in its unit.
    first: f64,
    /// Seconds of the unit.
    unit_s: f64,
}

impl Resolution {
    /// One unit, s, for all stamps.
    pub fn constant(finest_s: f64) -> Resolution {
        Resolution {
            finest_s,
            significant: None,
        }
    }

    /// Resolution of stamps with at most `digits` significant digits and none finer than `finest_s`, the first of which is `first` units of
    /// `unit_s` seconds.
    pub(super) fn from_digits(finest_s: f64, digits: i32, first: f64, unit_s: f64) -> Resolution {
        let significant = SignificantDigits {
            digits,
            first,
            unit_s,
        };
        Resolution {
            finest_s,
            significant: Some(significant),
        }
    }

    /// Number of significant digits written, where that is known and may matter.
    pub fn digits(&self) -> Option<i32> {
        self.significant.map(|s| s.digits)
    }

    /// One unit of the last digit of a stamp, s; `since_s` after the first.
    pub fn unit_at(&self, since_s: f64) -> f64 {
        let Some(SignificantDigits {
            digits,
            first,
            unit_s,
        }) = self.significant
        else {
            return self.finest_s;
        };
        /// A stamp just below a power of ten may be that power, but for the rounding of the difference.
        const ABOVE: f64 = 1.0 + 1e-9;
        let size = (first + since_s / unit_s).abs() * ABOVE;
        if size == 0.0 {
            return self.finest_s;
        }
        let leading = size.log10().floor() as i32;
        let unit = unit_s * 10f64.powi(leading + 1 - digits);
        self.finest_s.max(unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five digits: ten thousandths up to 10, thousandths up to 100; nothing finer than what was written.
    #[test]
    fn exact_unit_of_the_last_digit() {
        let five = Resolution::from_digits(1e-6, 5, 0.0, 1.0);
        let cases = [
            (0.0, 1e-6),
            (0.002, 1e-6),
            (9.9, 1e-4),
            (10.0, 1e-3),
            (99.0, 1e-3),
        ];
        for (seconds, unit) in cases {
            assert!(
                (five.unit_at(seconds) / unit - 1.0).abs() < 1e-12,
                "{seconds}"
            );
        }
        assert_eq!(Resolution::constant(1e-3).unit_at(500.0), 1e-3);
    }
}
