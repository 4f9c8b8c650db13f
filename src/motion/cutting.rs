//! Cutting forces of a face-milling head over time at constant speed (Kienzle's law).

use std::f64::consts::{PI, TAU};

use super::signal::Signal;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::sorting::sort_rising;
use crate::scene::laws::{FaceMill, MillChips, MillPlace, StatedChips};
use crate::scene::model::Axis;

/// Straight lines between one blade's entry or exit and the next; they crowd at both, where the chip is steep.
const POINTS_PER_BLADE: usize = 24;

/// The most points of a force over time.
const MAX_POINTS: f64 = 5e6;

/// Cutting force on a head at the speed `omega`, rad/s, along or about one of its axes, N or N·m: straight lines through points.
///
/// The force of a blade along its path is Kienzle's, `F = k_c1 b h^(1−m)` with h in millimetres of chip (Kienzle, VDI-Z 94 (1952) 299);
/// shares of F push it away from the axis and along it. The blade is at the radius r and the angle `β = slot + ψ sign Ω`, from x to y, ψ
/// counted from the middle of the slot.
///
/// # Errors
/// The head does not turn, or turns so often that the table would be absurd.
pub fn cutting_force(mill: &FaceMill, omega: f64, axis: Axis) -> Result<Signal, Error> {
    if omega == 0.0 {
        let hint = "state the speed of the cutter's node in [speed]";
        return Err(Error::new(
            Code::UndeterminedSpeed,
            "a face-mill load needs the speed of its node",
        )
        .with_hint(hint));
    }
    match &mill.chips {
        MillChips::Stated(chips) => stated_force(mill, chips, omega, axis),
        MillChips::Passes { start, passes, .. } => {
            Signal::table(&force_of_passes(mill, (*start, passes), omega, axis))
        }
    }
}

/// Force of alike groups.
///
/// Group i stands at `ψ' = |Ω|t + 2πi/z` and is in the slot for ψ' in (0, arc). There its chip is
/// `h = (h_max s² + e s cos(2πi/z)) sin(πψ'/arc)`, `s = sin(π (t − t₀)/(t₁ − t₀))`: it enters thin, cuts thickest in the middle
/// of the slot and leaves thin, while the generating roll from t₀ to t₁ carries the slot from nothing to its full depth and
/// out again; the run-out e lets the first group cut more and the one opposite less.
fn stated_force(
    mill: &FaceMill,
    chips: &StatedChips,
    omega: f64,
    axis: Axis,
) -> Result<Signal, Error> {
    let [start, end] = chips.roll;
    let pitch = TAU / (omega.abs() * f64::from(chips.blades));
    let passages = (end - start) / pitch;
    if 2.0 * passages * POINTS_PER_BLADE as f64 > MAX_POINTS {
        let message = format!("{passages:.0} blade passages in one roll are too many");
        return Err(Error::new(Code::BudgetExceeded, message)
            .with_hint("shorten the roll or slow the cutter"));
    }
    let edges = engagement_instants(chips.roll, pitch, chips.arc / omega.abs());
    let mut points = vec![(start, 0.0)];
    for pair in edges.windows(2) {
        let (from, long) = (pair[0], pair[1] - pair[0]);
        points.extend((1..=POINTS_PER_BLADE).map(|k| {
            let share = 0.5 - 0.5 * (PI * k as f64 / POINTS_PER_BLADE as f64).cos();
            let t = from + long * share;
            (t, force_at(mill, chips, omega, axis, t))
        }));
    }
    if let Some(last) = points.last_mut() {
        *last = (end, 0.0);
    }
    Signal::table(&points)
}

/// Points of the force of passes with evenly spaced places, each from and to zero a step beyond its ends: its integral is the sum of its
/// places times the step.
fn force_of_passes(
    mill: &FaceMill,
    (start, passes): (f64, &[Vec<MillPlace>]),
    omega: f64,
    axis: Axis,
) -> Vec<(f64, f64)> {
    let time = |head: f64| start + head / omega.abs();
    let curve = |places: &Vec<MillPlace>| -> Vec<(f64, f64)> {
        let force = |p: &MillPlace| {
            let beta = mill.slot.unwrap_or(0.0) + p.angle * omega.signum();
            (
                time(p.head),
                blade_force(mill, [p.edge, p.thickness], axis, beta),
            )
        };
        let mut points: Vec<(f64, f64)> = places.iter().map(force).collect();
        let step = points[1].0 - points[0].0;
        points.insert(0, (points[0].0 - step, 0.0));
        points.push((points[points.len() - 1].0 + step, 0.0));
        points
    };
    let mut curves: Vec<Vec<(f64, f64)>> = passes.iter().map(curve).collect();
    sort_rising(&mut curves, |curve| curve[0].0);
    let mut times: Vec<f64> = curves.iter().flatten().map(|p| p.0).collect();
    times.sort_by(f64::total_cmp);
    times.dedup_by(|later, earlier| *later - *earlier <= 1e-12 * later.abs());
    let mut waiting = curves.iter().peekable();
    let mut open: Vec<&Vec<(f64, f64)>> = Vec::new();
    let mut at = |t: f64| {
        open.extend(std::iter::from_fn(|| {
            waiting.next_if(|curve| curve[0].0 < t)
        }));
        open.retain(|curve| curve[curve.len() - 1].0 > t);
        let of = |curve: &&Vec<(f64, f64)>| {
            let next = curve.partition_point(|p| p.0 < t);
            let (a, b) = (curve[next - 1], curve[next]);
            a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0)
        };
        (t, open.iter().map(of).sum())
    };
    times.into_iter().map(&mut at).collect()
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

/// The sum over the groups at one instant.
fn force_at(mill: &FaceMill, chips: &StatedChips, omega: f64, axis: Axis, t: f64) -> f64 {
    let [start, end] = chips.roll;
    let deep = (PI * (t - start) / (end - start)).sin();
    let share = |blade: u32| {
        let place = TAU * f64::from(blade) / f64::from(chips.blades);
        let psi = (omega.abs() * t + place).rem_euclid(TAU);
        if psi >= chips.arc {
            return 0.0;
        }
        let chip = (chips.chip * deep * deep + chips.runout * deep * place.cos())
            * (PI * psi / chips.arc).sin();
        let beta = mill.slot.unwrap_or(0.0) + (psi - 0.5 * chips.arc) * omega.signum();
        blade_force(mill, [chips.width, chip], axis, beta)
    };
    (0..chips.blades).map(share).sum()
}

/// Force or moment of a blade at the angle `beta` whose chip has this width and thickness, m.
fn blade_force(mill: &FaceMill, [width, chip]: [f64; 2], axis: Axis, beta: f64) -> f64 {
    /// Kienzle's k is the force on a chip of 1 mm × 1 mm.
    const MILLIMETRE: f64 = 1e-3;
    let force = mill.specific_force
        * width
        * MILLIMETRE
        * (chip.max(0.0) / MILLIMETRE).powf(1.0 - mill.exponent);
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
}
