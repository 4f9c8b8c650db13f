//! What borders are read by: one pass over the parts that any of them sees, once for borders that differ in sign and constant alone.

use super::spectrum::Other;
use crate::numeric::Complex;

/// What a part is read by, beside what it counts in a border: p, ṗ, p, ṗ, p̈, p̈, the bound on p̈, that on the third derivative.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(16))]
pub struct Lanes(pub [f64; LANES]);

/// How many sums a border is read by.
pub const LANES: usize = 8;

/// What every part counts in each lane of a border's row c.
#[derive(Debug)]
pub struct Sensor(pub Vec<Lanes>);

impl Sensor {
    /// Of a row over the parts, of the row that gives ṗ, and of the sizes |c|.
    pub fn new(turning: &[Complex], row: &[f64], rate: &[f64], sizes: &[f64]) -> Sensor {
        let pairs = row.chunks_exact(2).zip(rate.chunks_exact(2));
        let turning = turning.iter().zip(pairs).zip(sizes);
        let mut lanes: Vec<Lanes> = turning
            .map(|((lambda, (c, r)), size)| {
                let bent = Complex::new(c[0], -c[1]) * lambda * lambda;
                let (fast, bound) = (lambda.norm(), size * lambda.norm_sqr());
                let [x, y] = [bent.re, -bent.im];
                Lanes([c[0], r[0], c[1], r[1], x, y, bound, bound * fast])
            })
            .collect();
        let first = 2 * lanes.len();
        let others = row[first..].iter().zip(&rate[first..]);
        let other = |(&c, &r): (&f64, &f64)| Lanes([c, r, 0.0, 0.0, c, 0.0, c.abs(), c.abs()]);
        lanes.extend(others.map(other));
        Sensor(lanes)
    }

    /// +1 where it is the same, −1 where it reads the negative.
    pub fn sign(&self, other: &Sensor) -> Option<f64> {
        let is = |sign: f64| {
            let mut pairs = self.0.iter().zip(&other.0);
            pairs.all(|(Lanes(a), Lanes(b))| (0..6).all(|k| a[k] == sign * b[k]))
        };
        [1.0, -1.0].into_iter().find(|sign| is(*sign))
    }
}

/// Leaves out, of all sensors, the parts behind the first `turning` that none of them sees; of every other part whether it is left out.
pub fn drop_unseen(sensors: &mut [Sensor], turning: usize, others: &[Other]) -> Vec<bool> {
    let mut unseen = Vec::with_capacity(others.len());
    let mut at = turning;
    for other in others {
        let states = at..at + other.count();
        let sees = |Lanes(lane): &Lanes| lane[0] != 0.0 || lane[1] != 0.0;
        let seen = sensors.iter().any(|s| s.0[states.clone()].iter().any(sees));
        match seen {
            true => at = states.end,
            false => sensors.iter_mut().for_each(|s| {
                s.0.drain(states.clone());
            }),
        }
        unseen.push(!seen);
    }
    unseen
}
