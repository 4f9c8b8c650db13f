//! Linear combination of coordinates with an imposed motion, `Σ aⱼ qⱼ + x(t)`.

use super::signal::Signal;

/// Linear combination of the independent coordinates plus an imposed motion x(t).
#[derive(Debug, Clone, Default)]
pub struct LinearCombination {
    /// Index j of a coordinate and its factor aⱼ.
    pub terms: Vec<(usize, f64)>,
    /// Imposed motion x(t); absent: zero.
    pub imposed: Option<Signal>,
}

impl LinearCombination {
    /// Combination of one coordinate with the factor 1.
    pub fn coordinate(coordinate: usize) -> LinearCombination {
        LinearCombination {
            terms: vec![(coordinate, 1.0)],
            imposed: None,
        }
    }

    /// Linear part `Σ aⱼ xⱼ`, without the imposed motion.
    pub fn dot(&self, x: &[f64]) -> f64 {
        self.terms.iter().map(|&(j, a)| a * x[j]).sum()
    }

    /// Value `Σ aⱼ qⱼ + x(t)`, t in s.
    pub fn value(&self, t: f64, q: &[f64]) -> f64 {
        let imposed = self.imposed.as_ref();
        self.dot(q) + imposed.map_or(0.0, |x| x.value(t, x.piece(t)))
    }

    /// First time derivative `Σ aⱼ vⱼ + ẋ(t)`.
    pub fn rate(&self, t: f64, v: &[f64]) -> f64 {
        let imposed = self.imposed.as_ref();
        self.dot(v) + imposed.map_or(0.0, |x| x.slope(t, x.piece(t)))
    }

    /// Second time derivative `Σ aⱼ q̈ⱼ + ẍ(t)`, with `a` the accelerations q̈.
    pub fn second_rate(&self, t: f64, a: &[f64]) -> f64 {
        let imposed = self.imposed.as_ref();
        self.dot(a) + imposed.map_or(0.0, |x| x.curvature(t, x.piece(t)))
    }

    /// Combination with `x` added to the imposed motion.
    #[must_use]
    pub fn with_imposed(mut self, x: &Signal) -> LinearCombination {
        self.imposed = Some(match self.imposed {
            None => x.clone(),
            Some(sum) => sum.plus(x),
        });
        self
    }

    /// Combination in other coordinates, in which `exprs[i]` gives coordinate i; `None` if an expression is absent.
    pub fn substitute(&self, exprs: &[Option<LinearCombination>]) -> Option<LinearCombination> {
        let mut terms: Vec<(usize, f64)> = Vec::new();
        let mut combination = LinearCombination {
            terms: Vec::new(),
            imposed: self.imposed.clone(),
        };
        for &(i, a) in &self.terms {
            let expr = exprs[i].as_ref()?;
            for &(j, b) in &expr.terms {
                match terms.iter_mut().find(|t| t.0 == j) {
                    Some((_, sum)) => *sum += a * b,
                    None => terms.push((j, a * b)),
                }
            }
            if let Some(x) = &expr.imposed {
                combination = combination.with_imposed(&x.scaled(a));
            }
        }
        combination.terms = terms;
        Some(combination)
    }
}
