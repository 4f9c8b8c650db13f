//! Linear constraints `Σ aᵢ xᵢ = 0` solved in exact rational arithmetic.
//!
//! Every coefficient is taken as the fraction that the double is (tooth numbers are integers and stay so).

use std::collections::{BTreeMap, HashMap};

use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

use super::fraction::Fraction;

/// A combination of free unknowns, none twice, none zero.
type Combination = BTreeMap<usize, BigRational>;

/// Unknowns under constraints imposed one after the other; each unknown is free or a combination of those still free.
#[derive(Debug, Clone)]
pub struct ExactConstraints {
    n: usize,
    /// Unknowns from here on are given: others follow them as long as there are others.
    given: usize,
    /// Combination of free unknowns that each eliminated unknown equals. Empty: held at zero.
    made_of: HashMap<usize, Combination>,
    /// Eliminated unknowns that contain each free unknown.
    contained_in: HashMap<usize, Vec<usize>>,
}

/// Effect of one more constraint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ConstraintEffect {
    /// Nothing: it followed from those before.
    Redundant,
    /// One free unknown became a combination of others.
    Joined,
    /// One free unknown, and all that is made of it alone, is now zero.
    Zeroed(usize),
}

impl ExactConstraints {
    /// `n` unknowns, all free.
    pub fn new(n: usize) -> ExactConstraints {
        ExactConstraints::with_prescribed(n, 0)
    }

    /// `n` unknowns and behind them so many that are given: one of these follows from others only where a constraint holds
    /// nothing else.
    pub fn with_prescribed(n: usize, given: usize) -> ExactConstraints {
        ExactConstraints {
            n: n + given,
            given: n,
            made_of: HashMap::new(),
            contained_in: HashMap::new(),
        }
    }

    /// Imposes `Σ coefficient · x = 0`. Coefficients that are not finite are taken as zero.
    pub fn impose(&mut self, row: &[(usize, f64)]) -> ConstraintEffect {
        let mut sum = self.reduce(row);
        let Some(pivot) = sum.keys().copied().min_by_key(|j| {
            (
                *j >= self.given,
                self.contained_in.get(j).map_or(0, Vec::len),
            )
        }) else {
            return ConstraintEffect::Redundant;
        };
        let lead = sum.remove(&pivot).unwrap_or_else(BigRational::one);
        let joined = !sum.is_empty();
        for a in sum.values_mut() {
            *a = -(&*a / &lead);
        }
        for i in self.contained_in.remove(&pivot).unwrap_or_default() {
            let share = self
                .made_of
                .get_mut(&i)
                .and_then(|made_of| made_of.remove(&pivot));
            if let Some(share) = share {
                sum.iter().for_each(|(&j, a)| self.add(i, j, a * &share));
            }
        }
        for &j in sum.keys() {
            self.contained_in.entry(j).or_default().push(pivot);
        }
        self.made_of.insert(pivot, sum);
        if joined {
            ConstraintEffect::Joined
        } else {
            ConstraintEffect::Zeroed(pivot)
        }
    }

    /// The unknowns still free.
    pub fn free(&self) -> Vec<usize> {
        (0..self.n)
            .filter(|j| !self.made_of.contains_key(j))
            .collect()
    }

    /// Whether the constraints so far leave this unknown no value but zero.
    pub fn is_zero(&self, i: usize) -> bool {
        self.made_of.get(&i).is_some_and(BTreeMap::is_empty)
    }

    /// Unknown `i` as a combination of free ones.
    pub fn combination(&self, i: usize) -> Vec<(usize, f64)> {
        match self.made_of.get(&i) {
            None => vec![(i, 1.0)],
            Some(made_of) => made_of.iter().map(|(&j, a)| (j, double(a))).collect(),
        }
    }

    /// Unknown `i` as an exact combination of free ones.
    pub fn exact_combination(&self, i: usize) -> Vec<(usize, Fraction)> {
        match self.made_of.get(&i) {
            None => vec![(i, Fraction::one())],
            Some(made_of) => (made_of.iter().map(|(&j, a)| (j, Fraction(a.clone())))).collect(),
        }
    }

    /// `Σ coefficient · x` in the unknowns still free; terms that cancel are gone, not small.
    pub fn reduce_row(&self, row: &[(usize, f64)]) -> Vec<(usize, f64)> {
        if row.iter().all(|(i, _)| !self.made_of.contains_key(i)) {
            return row.to_vec();
        }
        self.reduce(row)
            .into_iter()
            .map(|(j, a)| (j, double(&a)))
            .collect()
    }

    /// The exact ratio `x_a / x_b` as text, such as `-37/12`, where both follow from one and the same free unknown.
    pub fn ratio_text(&self, a: usize, b: usize) -> Option<String> {
        let held = self.is_zero(a);
        self.exact_ratio(a, b)
            .filter(|_| !held)
            .map(|f| f.to_string())
    }

    /// The exact ratio `x_a / x_b`, zero where `x_a` is held; absent where the two do not hang together or `x_b` is held.
    pub fn exact_ratio(&self, a: usize, b: usize) -> Option<Fraction> {
        let (j, q) = self.single(b)?;
        if self.is_zero(a) {
            return Some(Fraction::zero());
        }
        let (i, p) = self.single(a)?;
        (i == j).then(|| Fraction(p / q))
    }

    /// The one free unknown that unknown `i` follows, and by how much.
    fn single(&self, i: usize) -> Option<(usize, BigRational)> {
        let Some(made_of) = self.made_of.get(&i) else {
            return Some((i, BigRational::one()));
        };
        let mut terms = made_of.iter();
        match (terms.next(), terms.next()) {
            (Some((&j, a)), None) => Some((j, a.clone())),
            _ => None,
        }
    }

    fn reduce(&self, row: &[(usize, f64)]) -> Combination {
        let mut sum = Combination::new();
        for &(i, coefficient) in row {
            let Some(c) = BigRational::from_float(coefficient) else {
                continue;
            };
            match self.made_of.get(&i) {
                None => *sum.entry(i).or_insert_with(BigRational::zero) += c,
                Some(made_of) => {
                    for (&j, a) in made_of {
                        *sum.entry(j).or_insert_with(BigRational::zero) += a * &c;
                    }
                }
            }
        }
        sum.retain(|_, a| !a.is_zero());
        sum
    }

    /// Adds `a` of the free unknown `j` to the combination of `i`.
    fn add(&mut self, i: usize, j: usize, a: BigRational) {
        let made_of = self.made_of.entry(i).or_default();
        let entry = made_of.entry(j).or_insert_with(BigRational::zero);
        let was_zero = entry.is_zero();
        *entry += a;
        if entry.is_zero() {
            made_of.remove(&j);
            if let Some(list) = self.contained_in.get_mut(&j) {
                list.retain(|&k| k != i);
            }
        } else if was_zero {
            self.contained_in.entry(j).or_default().push(i);
        }
    }
}

fn double(a: &BigRational) -> f64 {
    a.to_f64().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop of three gears whose tooth numbers cancel is redundant; one tooth off and it is locked.
    #[test]
    fn exact_loop_of_gears() {
        let mut fits = ExactConstraints::new(3);
        assert_eq!(
            fits.impose(&[(0, 21.0), (1, -63.0)]),
            ConstraintEffect::Joined
        );
        assert_eq!(
            fits.impose(&[(1, 40.0), (2, -20.0)]),
            ConstraintEffect::Joined
        );
        assert_eq!(
            fits.impose(&[(0, 2.0), (2, -3.0)]),
            ConstraintEffect::Redundant
        );
        assert_eq!(fits.free().len(), 1);
        assert_eq!(fits.ratio_text(0, 2).as_deref(), Some("3/2"));
        assert!(matches!(
            fits.impose(&[(0, 2.0), (2, -3.0000001)]),
            ConstraintEffect::Zeroed(_)
        ));
        assert!((0..3).all(|i| fits.is_zero(i)));
    }

    /// Willis: sun 18, planet 36, ring 90 held, carrier turns at 18/(18 + 90) of the sun.
    #[test]
    fn exact_planetary_ratio() {
        let (sun, planet, ring, carrier) = (0, 1, 2, 3);
        let mut stage = ExactConstraints::new(4);
        stage.impose(&[(sun, 18.0), (planet, 36.0), (carrier, -54.0)]);
        stage.impose(&[(ring, 90.0), (planet, -36.0), (carrier, -54.0)]);
        assert_eq!(stage.free().len(), 2);
        stage.impose(&[(ring, 1.0)]);
        assert_eq!(stage.ratio_text(carrier, sun).as_deref(), Some("1/6"));
        assert_eq!(stage.ratio_text(planet, carrier).as_deref(), Some("-3/2"));
    }
}
