//! Linear combination of coordinates with an imposed motion, `Σ aⱼ qⱼ + x(t)`.

use super::signal::Signal;

/// Something in the independent coordinates: `terms · q`, and what is imposed on it in time.
#[derive(Debug, Clone, Default)]
pub struct LinearCombination {
    /// Coordinate and factor.
    pub terms: Vec<(usize, f64)>,
    /// Motion imposed in time.
    pub imposed: Option<Signal>,
}

impl LinearCombination {
    /// One coordinate.
    pub fn coordinate(coordinate: usize) -> LinearCombination {
        LinearCombination {
            terms: vec![(coordinate, 1.0)],
            imposed: None,
        }
    }

    /// `Σ aⱼ xⱼ`, without what is imposed.
    pub fn dot(&self, x: &[f64]) -> f64 {
        self.terms.iter().map(|&(j, a)| a * x[j]).sum()
    }

    /// Value of the combination at `t`.
    pub fn value(&self, t: f64, q: &[f64]) -> f64 {
        let known = self.imposed.as_ref();
        self.dot(q) + known.map_or(0.0, |x| x.value(t, x.piece(t)))
    }

    /// Rate of the combination at `t`.
    pub fn rate(&self, t: f64, v: &[f64]) -> f64 {
        let known = self.imposed.as_ref();
        self.dot(v) + known.map_or(0.0, |x| x.slope(t, x.piece(t)))
    }

    /// The rate of that.
    pub fn second_rate(&self, t: f64, a: &[f64]) -> f64 {
        let known = self.imposed.as_ref();
        self.dot(a) + known.map_or(0.0, |x| x.curvature(t, x.piece(t)))
    }

    /// The same with `x` imposed as well.
    #[must_use]
    pub fn with_imposed(mut self, x: &Signal) -> LinearCombination {
        self.imposed = Some(match self.imposed {
            None => x.clone(),
            Some(sum) => sum.plus(x),
        });
        self
    }

    /// The same in other coordinates, in which `places` gives each of its own; none where one of these has none.
    pub fn substitute(&self, places: &[Option<LinearCombination>]) -> Option<LinearCombination> {
        let mut terms: Vec<(usize, f64)> = Vec::new();
        let mut whole = LinearCombination {
            terms: Vec::new(),
            imposed: self.imposed.clone(),
        };
        for &(i, a) in &self.terms {
            let place = places[i].as_ref()?;
            for &(j, b) in &place.terms {
                match terms.iter_mut().find(|t| t.0 == j) {
                    Some((_, sum)) => *sum += a * b,
                    None => terms.push((j, a * b)),
                }
            }
            if let Some(x) = &place.imposed {
                whole = whole.with_imposed(&x.scaled(a));
            }
        }
        whole.terms = terms;
        Some(whole)
    }
}
