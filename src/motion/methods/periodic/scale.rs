//! Units that give all states similar size, and the largest rate of the motion.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::contact::{ContactDamping, ContactState, Flank};
use crate::motion::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use crate::motion::taylor::{ForcingSeries, TimeVaryingElement, TimeVaryingModel};
use crate::numeric::{Matrix, eigen};

/// A state in units of its own, powers of two so that nothing is rounded: `1/√m` for a coordinate, times a frequency for a speed.
#[derive(Debug, Clone)]
pub struct StateUnits {
    /// Unit of every state.
    pub units: Vec<f64>,
    /// Unit of speeds over coordinates, 1/s.
    pub rate: f64,
    /// Largest rate of any motion, contacts closed and stiffness at its greatest, rad/s.
    pub fastest: f64,
}

impl StateUnits {
    /// State units of a machine.
    ///
    /// # Errors
    /// Branches whose law is linear in no stand; numbers that leave the range of double precision.
    pub fn new(model: &DynamicModel) -> Result<StateUnits, Error> {
        let n = model.coordinate_count();
        let mass = |i: usize| model.mass.entry(i, i);
        let values = eigen::eigenvalues(&closed_jacobian(model, greatest_factor)?)?;
        let fastest = match values.iter().map(|z| z.norm()).fold(0.0, f64::max) {
            0.0 => 1.0,
            fastest => fastest,
        };
        let rate = power_of_two(fastest);
        let lengths = (0..n).map(|i| power_of_two(mass(i).sqrt().recip()));
        let mut units: Vec<f64> = lengths.collect();
        units.extend_from_within(..);
        units[n..].iter_mut().for_each(|unit| *unit *= rate);
        for b in model.elements.iter().filter(|b| b.internal_count() > 0) {
            let inverse: f64 = b.direction.entries().map(|(i, a)| a * a / mass(i)).sum();
            units.push(power_of_two(rate / inverse.sqrt()));
        }
        Ok(StateUnits {
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
pub fn closed_jacobian(
    model: &DynamicModel,
    factor: impl Fn(&ForceElement) -> f64,
) -> Result<Matrix, Error> {
    let closed = |b: &ForceElement| {
        let held = TimeVaryingElement::new(b, Some(ContactState::Closed(Flank::Drive)));
        let factor = vec![factor(b)];
        held.map(|held| held.with_factor(factor)).ok_or_else(|| {
            let message = format!("branch {} is not linear between switches", b.name);
            Error::new(Code::Usage, message)
        })
    };
    let branches: Result<Vec<TimeVaryingElement>, Error> =
        model.elements.iter().map(closed).collect();
    let held = TimeVaryingModel {
        model,
        branches: branches?,
        half: 1.0,
    };
    let (n, all) = (
        model.coordinate_count(),
        2 * model.coordinate_count() + model.internal_count(),
    );
    let rows = all - n;
    let mut slopes = Matrix::zeros(all, all);
    let mut start = vec![0.0; all];
    for j in 0..all {
        start[j] = 1.0;
        let motion = held.motion_series(&start, &ForcingSeries::default(), 3);
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
fn greatest_factor(b: &ForceElement) -> f64 {
    let factor = b.max_factor();
    match &b.law {
        ForceLaw::Contact(c) if c.contact_damping == ContactDamping::Continuous && c.can_open() => {
            2.0 * factor
        }
        ForceLaw::Contact(_) => factor,
        _ => 1.0,
    }
}
