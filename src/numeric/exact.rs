//! Linear constraints `Σ aᵢ xᵢ = 0` solved in exact fractions, so that ranks, null spaces and contradictions are decided, not estimated.
//!
//! Every coefficient is taken as the fraction that the double is (tooth numbers are integers and stay so).

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

/// Unknowns under constraints imposed one after the other; each unknown is a combination of those still free.
#[derive(Debug, Clone)]
pub struct Constraints {
    /// Of each unknown: which free unknowns it is made of, and how much of each. Empty: held at zero.
    made_of: Vec<BTreeMap<usize, BigRational>>,
    /// Of each free unknown: which unknowns contain it.
    contained_in: Vec<Vec<usize>>,
}

/// What one more constraint did.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing: it followed from those before.
    Redundant,
    /// One free unknown became a combination of others.
    Joined,
    /// One free unknown, and all that is made of it alone, is now zero.
    Held(usize),
}

impl Constraints {
    /// `n` unknowns, all free.
    pub fn new(n: usize) -> Constraints {
        Constraints {
            made_of: (0..n)
                .map(|i| BTreeMap::from([(i, BigRational::one())]))
                .collect(),
            contained_in: (0..n).map(|i| vec![i]).collect(),
        }
    }

    /// Imposes `Σ coefficient · x = 0`. Coefficients that are not finite are taken as zero.
    pub fn impose(&mut self, row: &[(usize, f64)]) -> Outcome {
        let mut sum = self.reduce(row);
        let Some(pivot) = sum
            .keys()
            .copied()
            .min_by_key(|&j| self.contained_in[j].len())
        else {
            return Outcome::Redundant;
        };
        let lead = sum.remove(&pivot).unwrap_or_else(BigRational::one);
        let joined = !sum.is_empty();
        for a in sum.values_mut() {
            *a = -(&*a / &lead);
        }
        for i in std::mem::take(&mut self.contained_in[pivot]) {
            let Some(share) = self.made_of[i].remove(&pivot) else {
                continue;
            };
            for (&j, a) in &sum {
                self.add(i, j, a * &share);
            }
        }
        if joined {
            Outcome::Joined
        } else {
            Outcome::Held(pivot)
        }
    }

    /// The unknowns still free.
    pub fn free(&self) -> Vec<usize> {
        (0..self.made_of.len())
            .filter(|&j| self.is_free(j))
            .collect()
    }

    /// Whether the constraints so far leave this unknown no value but zero.
    pub fn is_held(&self, i: usize) -> bool {
        self.made_of[i].is_empty()
    }

    /// Unknown `i` as a combination of free ones.
    pub fn combination(&self, i: usize) -> Vec<(usize, f64)> {
        self.made_of[i]
            .iter()
            .map(|(&j, a)| (j, a.to_f64().unwrap_or(f64::NAN)))
            .collect()
    }

    /// `Σ coefficient · x` in the unknowns still free; terms that cancel are gone, not small.
    pub fn reduced(&self, row: &[(usize, f64)]) -> Vec<(usize, f64)> {
        self.reduce(row)
            .into_iter()
            .map(|(j, a)| (j, a.to_f64().unwrap_or(f64::NAN)))
            .collect()
    }

    /// The exact ratio `x_a / x_b` as text, such as `-37/12`, where both follow from one and the same free unknown.
    pub fn ratio(&self, a: usize, b: usize) -> Option<String> {
        let (mut of_a, mut of_b) = (self.made_of[a].iter(), self.made_of[b].iter());
        match (of_a.next(), of_a.next(), of_b.next(), of_b.next()) {
            (Some((i, p)), None, Some((j, q)), None) if i == j => Some((p / q).to_string()),
            _ => None,
        }
    }

    fn is_free(&self, j: usize) -> bool {
        self.made_of[j].len() == 1 && self.made_of[j].get(&j).is_some_and(One::is_one)
    }

    fn reduce(&self, row: &[(usize, f64)]) -> BTreeMap<usize, BigRational> {
        let mut sum: BTreeMap<usize, BigRational> = BTreeMap::new();
        for &(i, coefficient) in row {
            let Some(c) = BigRational::from_float(coefficient) else {
                continue;
            };
            for (&j, a) in &self.made_of[i] {
                let entry = sum.entry(j).or_insert_with(BigRational::zero);
                *entry += a * &c;
            }
        }
        sum.retain(|_, a| !a.is_zero());
        sum
    }

    fn add(&mut self, i: usize, j: usize, a: BigRational) {
        let entry = self.made_of[i].entry(j).or_insert_with(BigRational::zero);
        let was_zero = entry.is_zero();
        *entry += a;
        if entry.is_zero() {
            self.made_of[i].remove(&j);
            self.contained_in[j].retain(|&k| k != i);
        } else if was_zero {
            self.contained_in[j].push(i);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop of three gears whose tooth numbers cancel is redundant; one tooth off and it is locked.
    #[test]
    fn exact_loop_of_gears() {
        let mut fits = Constraints::new(3);
        assert_eq!(fits.impose(&[(0, 21.0), (1, -63.0)]), Outcome::Joined);
        assert_eq!(fits.impose(&[(1, 40.0), (2, -20.0)]), Outcome::Joined);
        assert_eq!(fits.impose(&[(0, 2.0), (2, -3.0)]), Outcome::Redundant);
        assert_eq!(fits.free().len(), 1);
        assert_eq!(fits.ratio(0, 2).as_deref(), Some("3/2"));
        assert!(matches!(
            fits.impose(&[(0, 2.0), (2, -3.0000001)]),
            Outcome::Held(_)
        ));
        assert!((0..3).all(|i| fits.is_held(i)));
    }

    /// Willis: sun 18, planet 36, ring 90 held, carrier turns at 18/(18 + 90) of the sun.
    #[test]
    fn exact_planetary_ratio() {
        let (sun, planet, ring, carrier) = (0, 1, 2, 3);
        let mut stage = Constraints::new(4);
        stage.impose(&[(sun, 18.0), (planet, 36.0), (carrier, -54.0)]);
        stage.impose(&[(ring, 90.0), (planet, -36.0), (carrier, -54.0)]);
        assert_eq!(stage.free().len(), 2);
        stage.impose(&[(ring, 1.0)]);
        assert_eq!(stage.ratio(carrier, sun).as_deref(), Some("1/6"));
        assert_eq!(stage.ratio(planet, carrier).as_deref(), Some("-3/2"));
    }
}
