//! The cutting torque of a face-mill head over time, at its mean speed.

use std::f64::consts::TAU;

use super::signal::Signal;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::scene::laws::FaceMill;

/// Points of the torque for each passage of a blade group.
const POINTS: f64 = 48.0;

/// The most points of a torque over time.
const MOST: f64 = 5e6;

/// Torque on the head, N·m: straight lines through 48 points a blade passage.
///
/// Blade i stands at `ψ = Ωt + 2πi/z` and is in the slot for ψ in (0, arc). There its chip is
/// `h = h_max sin²(π (t − t₀)/(t₁ − t₀)) sin(π ψ/arc) + run-out`: it enters thin, cuts thickest in the middle of the slot and
/// leaves thin, while the generating roll from t₀ to t₁ carries the slot from nothing to its full depth and out again. Its
/// force is Kienzle's, `F = k_c1 b h^(1−m)` with h in millimetres of chip (Kienzle, VDI-Z 94 (1952) 299).
///
/// # Errors
/// The head does not turn, or turns so often that the table would be absurd.
pub fn torque(mill: &FaceMill, omega: f64) -> Result<Signal, Error> {
    let [start, end] = mill.roll;
    let passages = (end - start) * omega.abs() * f64::from(mill.blades) / TAU;
    if passages == 0.0 {
        let hint = "state the speed of the cutter's node in [speed]";
        return Err(Error::new(
            Code::NoSpeed,
            "a face-mill load needs the speed of its node",
        )
        .hint(hint));
    }
    let count = (passages * POINTS).ceil();
    if count > MOST {
        let message = format!("{passages:.0} blade passages in one roll are too many");
        return Err(Error::new(Code::Hopeless, message).hint("shorten the roll or slow the cutter"));
    }
    let step = (end - start) / count;
    let mut points = vec![(start, 0.0)];
    points.extend((1..count as usize).map(|k| {
        let t = start + step * k as f64;
        (t, mill.sense * at(mill, omega.abs(), t))
    }));
    points.push((end, 0.0));
    Signal::table(&points)
}

fn at(mill: &FaceMill, omega: f64, t: f64) -> f64 {
    let [start, end] = mill.roll;
    let depth = (TAU / 2.0 * (t - start) / (end - start)).sin().powi(2);
    let force = |blade: u32| {
        let psi = (omega * t + TAU * f64::from(blade) / f64::from(mill.blades)).rem_euclid(TAU);
        if psi >= mill.arc {
            return 0.0;
        }
        let uneven = mill.runout * (TAU * f64::from(blade) / f64::from(mill.blades)).cos();
        let chip = (mill.chip * depth + uneven * depth.sqrt()) * (TAU / 2.0 * psi / mill.arc).sin();
        // Kienzle's k is the force on a chip of 1 mm × 1 mm.
        const MILLIMETRE: f64 = 1e-3;
        mill.specific_force
            * mill.width
            * MILLIMETRE
            * (chip.max(0.0) / MILLIMETRE).powf(1.0 - mill.exponent)
    };
    mill.radius * (0..mill.blades).map(force).sum::<f64>()
}
