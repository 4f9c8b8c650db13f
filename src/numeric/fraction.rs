//! Exact fractions of arbitrary size: tooth ratios, orders, common periods.

use std::fmt;
use std::ops::{Add, Div, Mul, Sub};

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// Fraction in lowest terms with integers of arbitrary size, which cannot overflow.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fraction(pub(super) BigRational);

impl Fraction {
    /// Fraction 0.
    pub fn zero() -> Fraction {
        Fraction(BigRational::zero())
    }

    /// Fraction 1.
    pub fn one() -> Fraction {
        Fraction(BigRational::one())
    }

    /// Fraction `numerator / denominator`; zero for a zero denominator.
    pub fn new(numerator: i64, denominator: i64) -> Fraction {
        match denominator {
            0 => Fraction::zero(),
            _ => Fraction(BigRational::new(numerator.into(), denominator.into())),
        }
    }

    /// Exact fraction of a double; zero if it is not finite.
    pub fn from_f64(value: f64) -> Fraction {
        Fraction(BigRational::from_float(value).unwrap_or_else(BigRational::zero))
    }

    /// True for zero.
    pub fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    /// True below zero.
    pub fn is_negative(&self) -> bool {
        self.0.is_negative()
    }

    /// True for an integer.
    pub fn is_integer(&self) -> bool {
        self.0.is_integer()
    }

    /// Absolute value.
    pub fn abs(&self) -> Fraction {
        Fraction(self.0.abs())
    }

    /// Product with an integer.
    pub fn times(&self, count: u32) -> Fraction {
        Fraction(&self.0 * BigInt::from(count))
    }

    /// Fractional part, the difference to the floor, in [0, 1).
    pub fn fract(&self) -> Fraction {
        Fraction(&self.0 - self.0.floor())
    }

    /// Nearest double.
    pub fn to_f64(&self) -> f64 {
        self.0.to_f64().unwrap_or(f64::NAN)
    }

    /// Numerator and positive denominator; `None` if one is beyond ±2⁶³.
    pub fn parts(&self) -> Option<(i64, i64)> {
        Some((self.0.numer().to_i64()?, self.0.denom().to_i64()?))
    }

    /// Greatest common divisor: the largest number of which every nonzero fraction is an integer multiple; `None` without one.
    pub fn greatest_common_divisor<'a>(
        list: impl Iterator<Item = &'a Fraction>,
    ) -> Option<Fraction> {
        list.filter(|f| !f.is_zero())
            .map(|f| f.0.abs())
            .reduce(|a, b| {
                // gcd(p/q, r/s) = gcd(p s, r q) / (q s)
                let numerator = gcd(a.numer() * b.denom(), b.numer() * a.denom());
                BigRational::new(numerator, a.denom() * b.denom())
            })
            .map(Fraction)
    }
}

fn gcd(mut a: BigInt, mut b: BigInt) -> BigInt {
    while !b.is_zero() {
        (a, b) = (b.clone(), a % b);
    }
    a.abs()
}

impl fmt::Display for Fraction {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Add for &Fraction {
    type Output = Fraction;
    fn add(self, other: &Fraction) -> Fraction {
        Fraction(&self.0 + &other.0)
    }
}

impl Sub for &Fraction {
    type Output = Fraction;
    fn sub(self, other: &Fraction) -> Fraction {
        Fraction(&self.0 - &other.0)
    }
}

impl Mul for &Fraction {
    type Output = Fraction;
    fn mul(self, other: &Fraction) -> Fraction {
        Fraction(&self.0 * &other.0)
    }
}

/// Quotient; zero for a zero divisor.
impl Div for &Fraction {
    type Output = Fraction;
    fn div(self, other: &Fraction) -> Fraction {
        match other.is_zero() {
            true => Fraction::zero(),
            false => Fraction(&self.0 / &other.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The greatest common divisor of 3/4 and 5/6 is 1/12.
    #[test]
    fn exact_common_measure() {
        let values = [Fraction::new(3, 4), Fraction::new(-5, 6), Fraction::zero()];
        assert_eq!(
            Fraction::greatest_common_divisor(values.iter()),
            Some(Fraction::new(1, 12))
        );
        assert_eq!(Fraction::greatest_common_divisor([].iter()), None);
    }

    /// Products of ratios of primes with more than 60 digits are exact.
    #[test]
    fn survives_long_periods() {
        let primes = [
            999_983, 999_979, 999_961, 999_959, 999_953, 999_931, 999_917,
        ];
        let ratio = primes
            .iter()
            .fold(Fraction::one(), |r, &p| &r * &Fraction::new(p - 1, p));
        let product = primes
            .iter()
            .fold(ratio.clone(), |r, &p| &r * &Fraction::new(p, p - 1));
        assert_eq!(product, Fraction::one());
        assert!(ratio.to_string().len() > 60, "{ratio}");
        let divisor = Fraction::greatest_common_divisor([Fraction::one(), ratio].iter()).unwrap();
        assert!(divisor.to_f64() < 1e-30 && divisor.to_f64() > 0.0);
    }
}
