//! Linear constraints `Σ aᵢ xᵢ = 0` solved in exact rational arithmetic.
//!
//! Every coefficient is the exact fraction of its double; tooth numbers are integers and stay integers.

use std::collections::{BTreeMap, HashMap};

use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

use super::fraction::Fraction;

/// Linear combination of free unknowns: coefficient by unknown, none zero.
type Combination = BTreeMap<usize, BigRational>;

/// Unknowns under constraints imposed one after the other; each unknown is free or a linear combination of the free ones.
#[derive(Debug, Clone)]
pub struct ExactConstraints {
    n: usize,
    /// Index of the first prescribed unknown; a prescribed unknown is eliminated only if a constraint has no other.
    first_prescribed: usize,
    /// Combination of free unknowns that each eliminated unknown equals; empty for an unknown that is zero.
    combinations: HashMap<usize, Combination>,
    /// Eliminated unknowns whose combination contains each free unknown.
    dependents: HashMap<usize, Vec<usize>>,
}

/// Effect of an imposed constraint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ConstraintEffect {
    /// The constraint follows from the earlier ones.
    Redundant,
    /// A free unknown is now a combination of other free unknowns.
    Eliminated,
    /// This free unknown, and every multiple of it, is now zero.
    Zeroed(usize),
}

impl ExactConstraints {
    /// Creates `n` free unknowns.
    pub fn new(n: usize) -> ExactConstraints {
        ExactConstraints::with_prescribed(n, 0)
    }

    /// Creates `n` free unknowns, followed by `n_prescribed` that are eliminated only where a constraint contains no other.
    pub fn with_prescribed(n: usize, n_prescribed: usize) -> ExactConstraints {
        ExactConstraints {
            n: n + n_prescribed,
            first_prescribed: n,
            combinations: HashMap::new(),
            dependents: HashMap::new(),
        }
    }

    /// Imposes `Σ coefficient · x = 0`; coefficients that are not finite count as zero.
    pub fn impose(&mut self, row: &[(usize, f64)]) -> ConstraintEffect {
        let mut sum = self.reduce(row);
        let Some(pivot) = sum.keys().copied().min_by_key(|j| {
            (
                *j >= self.first_prescribed,
                self.dependents.get(j).map_or(0, Vec::len),
            )
        }) else {
            return ConstraintEffect::Redundant;
        };
        let pivot_coefficient = sum.remove(&pivot).unwrap_or_else(BigRational::one);
        let is_eliminated = !sum.is_empty();
        for a in sum.values_mut() {
            *a = -(&*a / &pivot_coefficient);
        }
        for i in self.dependents.remove(&pivot).unwrap_or_default() {
            let share = self
                .combinations
                .get_mut(&i)
                .and_then(|combination| combination.remove(&pivot));
            if let Some(share) = share {
                sum.iter().for_each(|(&j, a)| self.add(i, j, a * &share));
            }
        }
        for &j in sum.keys() {
            self.dependents.entry(j).or_default().push(pivot);
        }
        self.combinations.insert(pivot, sum);
        if is_eliminated {
            ConstraintEffect::Eliminated
        } else {
            ConstraintEffect::Zeroed(pivot)
        }
    }

    /// Unknowns that no constraint has eliminated, ascending.
    pub fn free(&self) -> Vec<usize> {
        (0..self.n)
            .filter(|j| !self.combinations.contains_key(j))
            .collect()
    }

    /// True if the constraints force unknown `i` to zero.
    pub fn is_zero(&self, i: usize) -> bool {
        self.combinations.get(&i).is_some_and(BTreeMap::is_empty)
    }

    /// Unknown `i` as a linear combination of free unknowns, rounded to doubles.
    pub fn combination(&self, i: usize) -> Vec<(usize, f64)> {
        match self.combinations.get(&i) {
            None => vec![(i, 1.0)],
            Some(terms) => terms.iter().map(|(&j, a)| (j, to_double(a))).collect(),
        }
    }

    /// Unknown `i` as an exact linear combination of free unknowns.
    pub fn exact_combination(&self, i: usize) -> Vec<(usize, Fraction)> {
        match self.combinations.get(&i) {
            None => vec![(i, Fraction::one())],
            Some(terms) => (terms.iter().map(|(&j, a)| (j, Fraction(a.clone())))).collect(),
        }
    }

    /// `Σ coefficient · x` in the free unknowns; terms that cancel are absent instead of small.
    pub fn reduce_row(&self, row: &[(usize, f64)]) -> Vec<(usize, f64)> {
        if row.iter().all(|(i, _)| !self.combinations.contains_key(i)) {
            return row.to_vec();
        }
        self.reduce(row)
            .into_iter()
            .map(|(j, a)| (j, to_double(&a)))
            .collect()
    }

    /// Exact ratio `x_a / x_b` as text, such as `-37/12`; `None` unless both are non-zero multiples of one free unknown.
    pub fn ratio_text(&self, a: usize, b: usize) -> Option<String> {
        let is_zero = self.is_zero(a);
        self.exact_ratio(a, b)
            .filter(|_| !is_zero)
            .map(|f| f.to_string())
    }

    /// Exact ratio `x_a / x_b`, 0 if `x_a` is zero; `None` if `x_b` is zero or the two are not multiples of one free unknown.
    pub fn exact_ratio(&self, a: usize, b: usize) -> Option<Fraction> {
        let (j, q) = self.free_multiple(b)?;
        if self.is_zero(a) {
            return Some(Fraction::zero());
        }
        let (i, p) = self.free_multiple(a)?;
        (i == j).then(|| Fraction(p / q))
    }

    /// The free unknown of which `i` is a multiple, and the factor; `None` if `i` depends on several or is zero.
    fn free_multiple(&self, i: usize) -> Option<(usize, BigRational)> {
        let Some(combination) = self.combinations.get(&i) else {
            return Some((i, BigRational::one()));
        };
        let mut terms = combination.iter();
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
            match self.combinations.get(&i) {
                None => *sum.entry(i).or_insert_with(BigRational::zero) += c,
                Some(combination) => {
                    for (&j, a) in combination {
                        *sum.entry(j).or_insert_with(BigRational::zero) += a * &c;
                    }
                }
            }
        }
        sum.retain(|_, a| !a.is_zero());
        sum
    }

    /// Adds `a x_j`, `j` free, to the combination of unknown `i`.
    fn add(&mut self, i: usize, j: usize, a: BigRational) {
        let combination = self.combinations.entry(i).or_default();
        let coefficient = combination.entry(j).or_insert_with(BigRational::zero);
        let was_zero = coefficient.is_zero();
        *coefficient += a;
        if coefficient.is_zero() {
            combination.remove(&j);
            if let Some(dependents) = self.dependents.get_mut(&j) {
                dependents.retain(|&k| k != i);
            }
        } else if was_zero {
            self.dependents.entry(j).or_default().push(i);
        }
    }
}

fn to_double(a: &BigRational) -> f64 {
    a.to_f64().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop of three gears whose ratios multiply to one is redundant; a ratio off by 3e-8 locks it.
    #[test]
    fn exact_loop_of_gears() {
        let mut constraints = ExactConstraints::new(3);
        assert_eq!(
            constraints.impose(&[(0, 21.0), (1, -63.0)]),
            ConstraintEffect::Eliminated
        );
        assert_eq!(
            constraints.impose(&[(1, 40.0), (2, -20.0)]),
            ConstraintEffect::Eliminated
        );
        assert_eq!(
            constraints.impose(&[(0, 2.0), (2, -3.0)]),
            ConstraintEffect::Redundant
        );
        assert_eq!(constraints.free().len(), 1);
        assert_eq!(constraints.ratio_text(0, 2).as_deref(), Some("3/2"));
        assert!(matches!(
            constraints.impose(&[(0, 2.0), (2, -3.0000001)]),
            ConstraintEffect::Zeroed(_)
        ));
        assert!((0..3).all(|i| constraints.is_zero(i)));
    }

    /// Willis equation: sun 18, planet 36, ring 90 fixed; the carrier turns at 18/(18 + 90) of the sun.
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
