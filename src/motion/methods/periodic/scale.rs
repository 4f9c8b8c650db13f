//! Units in which every state of a machine is of like size, and the fastest rate of its motion.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::contact::{Flank, Losses, Stand};
use crate::motion::series::{Held, HeldBranch, Sources};
use crate::motion::train::{Branch, Law, Train};
use crate::numeric::{Matrix, general};

/// A state in units of its own, powers of two so that nothing is rounded: `1/√m` for a coordinate, times a frequency for a speed.
#[derive(Debug, Clone)]
pub struct Scale {
    /// Of every state.
    pub units: Vec<f64>,
    /// Of speeds over coordinates, 1/s.
    pub rate: f64,
    /// Largest rate of any motion, contacts closed and stiffness at its greatest, rad/s.
    pub fastest: f64,
}

impl Scale {
    /// Of a machine.
    ///
    /// # Errors
    /// Branches whose law is linear in no stand; numbers that leave the range of double precision.
    pub fn new(train: &Train) -> Result<Scale, Error> {
        let n = train.n();
        let mass = |i: usize| train.mass.at(i, i);
        let values = general::eigenvalues(&closed(train, greatest_factor)?)?;
        let fastest = match values.iter().map(|z| z.norm()).fold(0.0, f64::max) {
            0.0 => 1.0,
            fastest => fastest,
        };
        let rate = power_of_two(fastest);
        let lengths = (0..n).map(|i| power_of_two(mass(i).sqrt().recip()));
        let mut units: Vec<f64> = lengths.collect();
        units.extend_from_within(..);
        units[n..].iter_mut().for_each(|unit| *unit *= rate);
        for b in train.branches.iter().filter(|b| b.inner() > 0) {
            let inverse: f64 = b.direction.scaled().map(|(i, a)| a * a / mass(i)).sum();
            units.push(power_of_two(rate / inverse.sqrt()));
        }
        Ok(Scale {
            units,
            rate,
            fastest,
        })
    }
}

fn power_of_two(x: f64) -> f64 {
    x.log2().round().exp2()
}

/// ∂ẏ/∂y of `y = [q, v, z]` with everything closed, and a factor on the stiffness of every branch.
///
/// # Errors
/// Branches whose law is linear in no stand.
pub fn closed(train: &Train, factor: impl Fn(&Branch) -> f64) -> Result<Matrix, Error> {
    let closed = |b: &Branch| {
        let held = HeldBranch::new(b, Some(Stand::Closed(Flank::Drive)));
        let factor = vec![factor(b)];
        held.map(|held| held.with_factor(factor)).ok_or_else(|| {
            let message = format!("branch {} is not linear between switches", b.name);
            Error::new(Code::Usage, message)
        })
    };
    let branches: Result<Vec<HeldBranch>, Error> = train.branches.iter().map(closed).collect();
    let held = Held {
        train,
        branches: branches?,
        half: 1.0,
    };
    let (n, all) = (train.n(), 2 * train.n() + train.inner());
    let rows = all - n;
    let mut slopes = Matrix::zeros(all, all);
    let mut start = vec![0.0; all];
    for j in 0..all {
        start[j] = 1.0;
        let motion = held.motion(&start, &Sources::default(), 3);
        let of = |k: usize, row: usize| motion[k * rows + row];
        for i in 0..n {
            slopes[(i, j)] = of(1, i);
            slopes[(n + i, j)] = 2.0 * of(2, i);
        }
        (n..rows).for_each(|row| slopes[(n + row, j)] = of(1, row));
        start[j] = 0.0;
    }
    Ok(slopes)
}

/// The greatest size of a stiffness wave, doubled where the law can double the stiffness.
fn greatest_factor(b: &Branch) -> f64 {
    let factor = b.greatest_factor();
    match &b.law {
        Law::Contact(c) if c.losses == Losses::Continuous && c.opens() => 2.0 * factor,
        Law::Contact(_) => factor,
        _ => 1.0,
    }
}
