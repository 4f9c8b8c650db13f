//! Exact transmission error of an involute pair with an eccentric second gear.
//!
//! The first-order term has amplitude e along the line of action; the second-order term, about e²/a, is some thousandths of that.

use std::f64::consts::TAU;

use super::chain::TransmissionChain;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::{Gear, Machine};
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;

/// Pair of external involute gears; the second rotates about an axis offset from its own.
#[derive(Debug, Clone, Copy)]
pub struct EccentricPair {
    base: [f64; 2],
    distance: f64,
    offset: f64,
}

/// Number of samples per revolution of the eccentric gear.
const SAMPLES: usize = 64;

impl EccentricPair {
    /// Pair with base radii, centre distance and offset, m.
    ///
    /// # Errors
    /// Base circles that touch or overlap at the smallest distance: there is no line of action.
    pub fn new(base: [f64; 2], distance: f64, offset: f64) -> Result<EccentricPair, Error> {
        let is_positive = base
            .iter()
            .chain([&distance])
            .all(|x| x.is_finite() && *x > 0.0);
        if is_positive && offset >= 0.0 && base[0] + base[1] < distance - offset {
            return Ok(EccentricPair {
                base,
                distance,
                offset,
            });
        }
        let message = format!(
            "base radii of {} and {} m have no line of action at {distance} m less {offset} m",
            base[0], base[1]
        );
        Err(Error::new(Code::OutOfRange, message)
            .with_hint("the centres must be farther apart than the base circles reach"))
    }

    /// Deviation of φ₂ from the angle `nominal` of a concentric gear, rad.
    ///
    /// # Errors
    /// No convergence; has not occurred for any valid pair.
    pub fn deviation(&self, nominal: f64) -> Result<f64, Error> {
        /// Relative angle tolerance, at the rounding error; Newton's iteration converges quadratically.
        const ANGLE_TOLERANCE: f64 = 1e-15;
        let [r1, r2] = self.base;
        let sum = r1 + r2;
        let driver = -nominal * r2 / r1;
        let involute = |cos: f64| {
            let alpha = cos.acos();
            alpha.tan() - alpha
        };
        let constant = sum * involute(sum / self.distance);
        let mut angle = nominal;
        for _ in 0..50 {
            let (sin, cos) = angle.sin_cos();
            let centre = (self.distance + self.offset * cos, self.offset * sin);
            let slope = (-self.offset * sin, self.offset * cos);
            let d = centre.0.hypot(centre.1);
            let psi = centre.1.atan2(centre.0);
            let along = (centre.0 * slope.0 + centre.1 * slope.1) / d;
            let across = (centre.0 * slope.1 - centre.1 * slope.0) / (d * d);
            let cosine = sum / d;
            let value =
                r1 * (driver - psi) + r2 * (angle - psi) + sum * involute(cosine) - constant;
            // d inv α = tan² α dα, dα = cot α dd / d.
            let tan = (1.0 - cosine * cosine).sqrt() / cosine;
            let derivative = r2 - sum * across + sum * tan * along / d;
            let step = value / derivative;
            angle -= step;
            if step.abs() <= ANGLE_TOLERANCE * angle.abs().max(1.0) {
                return Ok(angle - nominal);
            }
        }
        Err(Error::new(
            Code::NoConvergence,
            "the exact eccentric pair did not converge",
        ))
    }

    /// Harmonics of the deviation along the line of action over one turn, m: order 1 first.
    ///
    /// # Errors
    /// Those of [`EccentricPair::deviation`].
    pub fn harmonics(&self) -> Result<Vec<Complex>, Error> {
        let mut samples = (0..SAMPLES)
            .map(|k| Ok(self.base[1] * self.deviation(TAU * k as f64 / SAMPLES as f64)?))
            .collect::<Result<Vec<f64>, Error>>()?;
        let mut transform = RealFft::new(SAMPLES);
        let mut spectrum = vec![Complex::ZERO; transform.lines()];
        transform.forward(&mut samples, &mut spectrum);
        Ok(spectrum[1..SAMPLES / 4]
            .iter()
            .map(|z| *z * (2.0 / SAMPLES as f64))
            .collect())
    }
}

/// Second-order terms neglected by the order table, rad: those of all gear offsets in external parallel-axis pairs, summed at the
/// output. Those of other pairs are of the same order of magnitude.
pub fn neglected_second_order(machine: &Machine, chain: &TransmissionChain) -> f64 {
    let mut sum = 0.0;
    for error in machine
        .errors
        .iter()
        .filter(|error| error.cause.is_offset())
    {
        let offset: f64 = error.waveform.harmonics().iter().map(|h| h.1).sum();
        for act in &error.acts {
            let pair = |gear: &&Gear| gear.branches.contains(&act.branch) && gear.teeth.is_some();
            let gears: Vec<&Gear> = machine.gears.iter().filter(pair).collect();
            let [a, b] = gears[..] else { continue };
            let direction = &machine.branches[act.branch].direction;
            let arm = |gear: &Gear| {
                let term = direction.terms.iter().find(|t| t.0 == gear.rotation_dof);
                term.map_or(0.0, |t| direction.scale * t.1)
            };
            let (gear, mate) = if a.rotation_dof == error.rotation_dof {
                (a, b)
            } else {
                (b, a)
            };
            let base = [arm(mate), arm(gear)];
            let lever = gear.mesh_geometries.first().map_or(1.0, |seat| seat.lever);
            let pair = EccentricPair::new(base, (base[0] + base[1]) / lever, offset);
            let second = pair
                .and_then(|pair| pair.harmonics())
                .map_or(0.0, |h| h[1].norm());
            sum += second * chain.transmission(act.branch).abs();
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Teeth 20 and 40, module 2 mm, α = 20°, offset 20 µm at the standard distance plus twice the offset: 40 µm peak to peak along
    /// the line of action, 1.064176 mrad, 19.9999969 µm at order 1 and 7.1966 nm at order 2 (solved independently with mpmath).
    #[test]
    fn exact_20_40() {
        let cos = (std::f64::consts::PI / 9.0).cos();
        let pair = EccentricPair::new([0.02 * cos, 0.04 * cos], 0.06004, 2e-5).unwrap();
        let harmonics = pair.harmonics().unwrap();
        assert!(
            (harmonics[0].norm() - 19.9999969e-6).abs() < 5e-14,
            "{:e}",
            harmonics[0].norm()
        );
        assert!(
            (harmonics[1].norm() - 7.1966e-9).abs() < 5e-14,
            "{:e}",
            harmonics[1].norm()
        );
        let deviations: Vec<f64> = (0..7200)
            .map(|k| pair.deviation(TAU * f64::from(k) / 7200.0).unwrap())
            .collect();
        let range = deviations.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x))
            - deviations.iter().fold(f64::INFINITY, |m, x| m.min(*x));
        // The reference range is that of sampled angles, 2e-9 rad smaller than 4e-5 m over the base radius.
        assert!((range - 0.001064176).abs() < 2e-9, "{range}");
        assert!((range * pair.base[1] - 4e-5).abs() < 1e-9);
        // On the pitch circle 2e/cos α_w: the cumulative pitch deviation of such a gear.
        assert!((range * 0.04 - 0.042567e-3).abs() < 5e-10);
        let working = (0.06 * cos / 0.06004).acos();
        assert!((range * 0.04 * working.cos() / 4e-5 - 0.04 / 0.06004 * 0.06 / 0.04).abs() < 1e-3);
    }

    /// The second-order term is proportional to the square of the offset, and zero without offset.
    #[test]
    fn order_second_of_the_offset() {
        let second = |e: f64| {
            EccentricPair::new([0.03, 0.05], 0.086, e)
                .unwrap()
                .harmonics()
                .unwrap()[1]
                .norm()
        };
        assert!((second(1e-4) / second(1e-5) - 100.0).abs() < 0.5);
        assert!(second(0.0) < 1e-17);
        assert!(EccentricPair::new([0.03, 0.05], 0.0801, 2e-4).is_err());
        assert!(EccentricPair::new([0.03, f64::NAN], 0.0801, 0.0).is_err());
    }
}
