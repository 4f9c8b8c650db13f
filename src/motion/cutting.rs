//! Cutting forces of a face-milling head over time at constant speed (Kienzle's law).

use std::f64::consts::{PI, TAU};

use super::signal::Signal;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::scene::laws::FaceMill;
use crate::scene::model::Axis;

/// Straight lines between one blade's entry or exit and the next; they crowd at both, where the chip is steep.
const POINTS_PER_BLADE: usize = 24;

/// The most points of a force over time.
const MAX_POINTS: f64 = 5e6;

/// Cutting force on a head at the speed `omega`, rad/s, along or about one of its axes, N or N·m: straight lines through points.
///
/// Blade i stands at `ψ = |Ω|t + 2πi/z` and is in the slot for ψ in (0, arc). There its chip is
/// `h = (h_max s² + e s cos(2πi/z)) sin(πψ/arc)`, `s = sin(π (t − t₀)/(t₁ − t₀))`: it enters thin, cuts thickest in the middle
/// of the slot and leaves thin, while the generating roll from t₀ to t₁ carries the slot from nothing to its full depth and
/// out again; the run-out e lets the first blade cut more and the one opposite less. Its force along its path is Kienzle's,
/// `F = k_c1 b h^(1−m)` with h in millimetres of chip (Kienzle, VDI-Z 94 (1952) 299); shares of F push it away from the axis
/// and along it. The blade is at the radius r and the angle `β = slot + (ψ − arc/2) sign Ω`, from x to y.
///
/// # Errors
/// The head does not turn, or turns so often that the table would be absurd.
pub fn cutting_force(mill: &FaceMill, omega: f64, axis: Axis) -> Result<Signal, Error> {
    let [start, end] = mill.roll;
    if omega == 0.0 {
        let hint = "state the speed of the cutter's node in [speed]";
        return Err(Error::new(
            Code::UndeterminedSpeed,
            "a face-mill load needs the speed of its node",
        )
        .with_hint(hint));
    }
    let pitch = TAU / (omega.abs() * f64::from(mill.blades));
    let passages = (end - start) / pitch;
    if 2.0 * passages * POINTS_PER_BLADE as f64 > MAX_POINTS {
        let message = format!("{passages:.0} blade passages in one roll are too many");
        return Err(Error::new(Code::BudgetExceeded, message)
            .with_hint("shorten the roll or slow the cutter"));
    }
    let edges = engagement_instants(mill.roll, pitch, mill.arc / omega.abs());
    let mut points = vec![(start, 0.0)];
    for pair in edges.windows(2) {
        let (from, long) = (pair[0], pair[1] - pair[0]);
        points.extend((1..=POINTS_PER_BLADE).map(|k| {
            let share = 0.5 - 0.5 * (PI * k as f64 / POINTS_PER_BLADE as f64).cos();
            let t = from + long * share;
            (t, force_at(mill, omega, axis, t))
        }));
    }
    if let Some(last) = points.last_mut() {
        *last = (end, 0.0);
    }
    Signal::table(&points)
}

/// Begin and end of the roll, and between them every instant at which a blade enters or leaves the slot.
fn engagement_instants([start, end]: [f64; 2], pitch: f64, stay: f64) -> Vec<f64> {
    let first = (start / pitch).floor();
    let count = ((end - start) / pitch).ceil() as usize + 1;
    let leave = stay.rem_euclid(pitch);
    let mut all = vec![start];
    for k in 0..=count {
        let enter = (first + k as f64) * pitch;
        all.extend([enter, enter + leave]);
    }
    all.push(end);
    // What lies closer than rounding distinguishes is one edge.
    let apart = 1e-9 * pitch;
    all.retain(|t| (*t == start || *t > start + apart) && (*t == end || *t < end - apart));
    all.sort_by(f64::total_cmp);
    all.dedup_by(|later, earlier| *later - *earlier <= apart);
    all
}

/// The sum over the blades at one instant.
fn force_at(mill: &FaceMill, omega: f64, axis: Axis, t: f64) -> f64 {
    /// Kienzle's k is the force on a chip of 1 mm × 1 mm.
    const MILLIMETRE: f64 = 1e-3;
    let [start, end] = mill.roll;
    let deep = (PI * (t - start) / (end - start)).sin();
    let share = |blade: u32| {
        let place = TAU * f64::from(blade) / f64::from(mill.blades);
        let psi = (omega.abs() * t + place).rem_euclid(TAU);
        if psi >= mill.arc {
            return 0.0;
        }
        let chip = (mill.chip * deep * deep + mill.runout * deep * place.cos())
            * (PI * psi / mill.arc).sin();
        let force = mill.specific_force
            * mill.width
            * MILLIMETRE
            * (chip.max(0.0) / MILLIMETRE).powf(1.0 - mill.exponent);
        let beta = mill.slot.unwrap_or(0.0) + (psi - 0.5 * mill.arc) * omega.signum();
        let (sine, cosine) = beta.sin_cos();
        force
            * match axis {
                Axis::Theta => mill.sense * mill.radius,
                Axis::X => -mill.sense * sine + mill.radial * cosine,
                Axis::Y => mill.sense * cosine + mill.radial * sine,
                Axis::Z => mill.axial,
                Axis::TiltX => mill.axial * mill.radius * sine,
                Axis::TiltY => -mill.axial * mill.radius * cosine,
            }
    };
    (0..mill.blades).map(share).sum()
}
