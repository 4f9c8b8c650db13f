//! Bounds of allowed values, printed so that the printed value is allowed.

/// A bound of allowed values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// Values from this one upward.
    AtLeast(f64),
    /// Values up to this one.
    AtMost(f64),
}

impl Bound {
    /// The bound itself.
    pub fn value(self) -> f64 {
        match self {
            Bound::AtLeast(value) | Bound::AtMost(value) => value,
        }
    }

    /// The bound in another unit, of so many to one.
    pub fn scaled(self, factor: f64) -> Bound {
        match self {
            Bound::AtLeast(value) => Bound::AtLeast(factor * value),
            Bound::AtMost(value) => Bound::AtMost(factor * value),
        }
    }

    /// The nearest allowed value with so many decimals: rounded up from a least value, down from a greatest one, and off the bound itself.
    pub fn text(self, decimals: usize) -> String {
        /// Share of the last decimal by which the text keeps off the bound: rounding of what computed it.
        const OFF: f64 = 1e-3;
        let unit = 10f64.powi(decimals as i32);
        let rounded = match self {
            Bound::AtLeast(value) => (value * unit + OFF).ceil() / unit,
            Bound::AtMost(value) => (value * unit - OFF).floor() / unit,
        };
        // No negative zero.
        format!("{:.decimals$}", rounded + 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_bounds_are_kept_as_printed() {
        assert_eq!(Bound::AtLeast(69.011445).text(4), "69.0115");
        assert_eq!(Bound::AtMost(69.011445).text(4), "69.0114");
        assert_eq!(Bound::AtLeast(0.5).text(1), "0.6");
        assert_eq!(Bound::AtMost(-0.70745).text(4), "-0.7075");
        assert_eq!(Bound::AtLeast(-1e-9).text(4), "0.0001");
        assert_eq!(Bound::AtMost(0.0690114).scaled(1e3).text(2), "69.01");
    }
}
