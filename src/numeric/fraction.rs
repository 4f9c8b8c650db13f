//! Exact fractions of arbitrary size: tooth ratios, orders, common periods.

use std::fmt;
use std::ops::{Add, Div, Mul, Sub};

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// A fraction in lowest terms. It has no largest value, so nothing overflows.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fraction(pub(super) BigRational);

impl Fraction {
    /// 0.
    pub fn zero() -> Fraction {
        Fraction(BigRational::zero())
    }

    /// 1.
    pub fn one() -> Fraction {
        Fraction(BigRational::one())
    }

    /// `top / bottom`; zero where the bottom is zero.
    pub fn new(top: i64, bottom: i64) -> Fraction {
        match bottom {
            0 => Fraction::zero(),
            _ => Fraction(BigRational::new(top.into(), bottom.into())),
        }
    }

    /// The fraction a double is; zero where it is not finite.
    pub fn from_f64(value: f64) -> Fraction {
        Fraction(BigRational::from_float(value).unwrap_or_else(BigRational::zero))
    }

    /// It is zero.
    pub fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    /// It is below zero.
    pub fn is_negative(&self) -> bool {
        self.0.is_negative()
    }

    /// It is a whole number.
    pub fn is_integer(&self) -> bool {
        self.0.is_integer()
    }

    /// Without its sign.
    pub fn abs(&self) -> Fraction {
        Fraction(self.0.abs())
    }

    /// So many times this.
    pub fn times(&self, count: u32) -> Fraction {
        Fraction(&self.0 * BigInt::from(count))
    }

    /// Fractional part above the next whole number below: in [0, 1).
    pub fn fract(&self) -> Fraction {
        Fraction(&self.0 - self.0.floor())
    }

    /// The nearest double.
    pub fn to_f64(&self) -> f64 {
        self.0.to_f64().unwrap_or(f64::NAN)
    }

    /// Numerator and denominator, the latter positive; `None` where one is beyond ±2⁶³.
    pub fn parts(&self) -> Option<(i64, i64)> {
        Some((self.0.numer().to_i64()?, self.0.denom().to_i64()?))
    }

    /// The least number above zero of which all of `all` that are not zero are whole multiples.
    pub fn greatest_common_divisor<'a>(
        all: impl Iterator<Item = &'a Fraction>,
    ) -> Option<Fraction> {
        all.filter(|f| !f.is_zero())
            .map(|f| f.0.abs())
            .reduce(|a, b| {
                // gcd(p/q, r/s) = gcd(p s, r q) / (q s)
                let top = gcd(a.numer() * b.denom(), b.numer() * a.denom());
                BigRational::new(top, a.denom() * b.denom())
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

/// Zero where the divisor is zero.
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

    /// 3/4 and 5/6 are whole multiples of 1/12, and of nothing larger.
    #[test]
    fn exact_common_measure() {
        let all = [Fraction::new(3, 4), Fraction::new(-5, 6), Fraction::zero()];
        assert_eq!(
            Fraction::greatest_common_divisor(all.iter()),
            Some(Fraction::new(1, 12))
        );
        assert_eq!(Fraction::greatest_common_divisor([].iter()), None);
    }

    /// A chain of primes whose common period has 40 digits keeps each of them.
    #[test]
    fn survives_long_periods() {
        let primes = [
            999_983, 999_979, 999_961, 999_959, 999_953, 999_931, 999_917,
        ];
        let ratio = primes
            .iter()
            .fold(Fraction::one(), |r, &p| &r * &Fraction::new(p - 1, p));
        let back = primes
            .iter()
            .fold(ratio.clone(), |r, &p| &r * &Fraction::new(p, p - 1));
        assert_eq!(back, Fraction::one());
        assert!(ratio.to_string().len() > 60, "{ratio}");
        let measure = Fraction::greatest_common_divisor([Fraction::one(), ratio].iter()).unwrap();
        assert!(measure.to_f64() < 1e-30 && measure.to_f64() > 0.0);
    }
}
