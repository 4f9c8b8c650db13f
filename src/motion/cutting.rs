//! Cutting force of a face-milling head over time at constant speed, `F = k_c1 b h^(1−m)` (Kienzle).

use std::f64::consts::{PI, TAU};

use super::signal::Signal;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::sorting::sort_ascending;
use crate::scene::laws::{BladeSample, FaceMill, MillChips, StatedChips};
use crate::scene::model::Axis;

/// Line segments between consecutive blade entries and exits; they are shorter at both ends, where chip thickness changes fastest.
const POINTS_PER_BLADE: usize = 24;

/// Maximum number of points of a force table.
const MAX_POINTS: f64 = 5e6;

/// Cutting force on a head at the speed `omega`, rad/s, along or about one of its axes, N or N·m, piecewise linear in time.
///
/// The force of a blade along its path is Kienzle's, `F = k_c1 b h^(1−m)` with h in millimetres of chip (Kienzle, VDI-Z 94 (1952) 299);
/// shares of F push it away from the axis and along it. The blade is at the radius r and the angle `β = slot + ψ sign Ω`, from x to y, ψ
/// counted from the middle of the slot.
///
/// # Errors
/// The head is at rest, or its blade passages exceed the size of the force table.
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

/// Force of identical blade groups.
///
/// Group i has the angle `ψ' = |Ω|t + 2πi/z` and is in the slot for ψ' in (0, arc). Its chip thickness there is
/// `h = (h_max s² + e s cos(2πi/z)) sin(πψ'/arc)`, `s = sin(π (t − t₀)/(t₁ − t₀))`: largest in the middle of the slot and zero at
/// entry and exit. The slot depth rises from zero to its maximum and falls to zero over the generating roll from t₀ to t₁. The
/// run-out e increases the chip of the first group and reduces that of the opposite one.
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
        let message = format!("{passages:.0} blade passages in one roll exceed the limit");
        return Err(Error::new(Code::BudgetExceeded, message)
            .with_hint("shorten the roll or slow the cutter"));
    }
    let instants = engagement_instants(chips.roll, pitch, chips.arc / omega.abs());
    let mut points = vec![(start, 0.0)];
    for interval in instants.windows(2) {
        let (from, duration) = (interval[0], interval[1] - interval[0]);
        points.extend((1..=POINTS_PER_BLADE).map(|k| {
            let share = 0.5 - 0.5 * (PI * k as f64 / POINTS_PER_BLADE as f64).cos();
            let t = from + duration * share;
            (t, force_at(mill, chips, omega, axis, t))
        }));
    }
    if let Some(last) = points.last_mut() {
        *last = (end, 0.0);
    }
    Signal::table(&points)
}

/// Points of the force of passes with evenly spaced samples. Each pass starts and ends at zero one step beyond its samples, so that its
/// integral is the sum of its samples times the step.
fn force_of_passes(
    mill: &FaceMill,
    (start, passes): (f64, &[Vec<BladeSample>]),
    omega: f64,
    axis: Axis,
) -> Vec<(f64, f64)> {
    let time = |head: f64| start + head / omega.abs();
    let curve = |samples: &Vec<BladeSample>| -> Vec<(f64, f64)> {
        let force = |p: &BladeSample| {
            let beta = mill.slot.unwrap_or(0.0) + p.angle * omega.signum();
            (
                time(p.head),
                blade_force(mill, [p.edge, p.thickness], axis, beta),
            )
        };
        let mut points: Vec<(f64, f64)> = samples.iter().map(force).collect();
        let step = points[1].0 - points[0].0;
        points.insert(0, (points[0].0 - step, 0.0));
        points.push((points[points.len() - 1].0 + step, 0.0));
        points
    };
    let mut curves: Vec<Vec<(f64, f64)>> = passes.iter().map(curve).collect();
    sort_ascending(&mut curves, |curve| curve[0].0);
    let mut times: Vec<f64> = curves.iter().flatten().map(|p| p.0).collect();
    times.sort_by(f64::total_cmp);
    times.dedup_by(|later, earlier| *later - *earlier <= 1e-12 * later.abs());
    let mut queued = curves.iter().peekable();
    let mut active: Vec<&Vec<(f64, f64)>> = Vec::new();
    let mut sum_at = |t: f64| {
        active.extend(std::iter::from_fn(|| {
            queued.next_if(|curve| curve[0].0 < t)
        }));
        active.retain(|curve| curve[curve.len() - 1].0 > t);
        let interpolate = |curve: &&Vec<(f64, f64)>| {
            let next = curve.partition_point(|p| p.0 < t);
            let (a, b) = (curve[next - 1], curve[next]);
            a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0)
        };
        (t, active.iter().map(interpolate).sum())
    };
    times.into_iter().map(&mut sum_at).collect()
}

/// Start and end of the roll, s, and every instant between them at which a blade enters or leaves the slot.
fn engagement_instants([start, end]: [f64; 2], pitch: f64, engagement: f64) -> Vec<f64> {
    let first = (start / pitch).floor();
    let count = ((end - start) / pitch).ceil() as usize + 1;
    let leave = engagement.rem_euclid(pitch);
    let mut instants = vec![start];
    for k in 0..=count {
        let enter = (first + k as f64) * pitch;
        instants.extend([enter, enter + leave]);
    }
    instants.push(end);
    // Instants closer than rounding are merged.
    let gap = 1e-9 * pitch;
    instants.retain(|t| (*t == start || *t > start + gap) && (*t == end || *t < end - gap));
    instants.sort_by(f64::total_cmp);
    instants.dedup_by(|later, earlier| *later - *earlier <= gap);
    instants
}

/// Sum of the forces of all groups at the instant t, s.
fn force_at(mill: &FaceMill, chips: &StatedChips, omega: f64, axis: Axis, t: f64) -> f64 {
    let [start, end] = chips.roll;
    let depth = (PI * (t - start) / (end - start)).sin();
    let group_force = |blade: u32| {
        let offset = TAU * f64::from(blade) / f64::from(chips.blades);
        let psi = (omega.abs() * t + offset).rem_euclid(TAU);
        if psi >= chips.arc {
            return 0.0;
        }
        let chip = (chips.chip * depth * depth + chips.runout * depth * offset.cos())
            * (PI * psi / chips.arc).sin();
        let beta = mill.slot.unwrap_or(0.0) + (psi - 0.5 * chips.arc) * omega.signum();
        blade_force(mill, [chips.width, chip], axis, beta)
    };
    (0..chips.blades).map(group_force).sum()
}

/// Force or moment of a blade at the angle `beta`, rad, with the given chip width and thickness, m.
fn blade_force(mill: &FaceMill, [width, chip]: [f64; 2], axis: Axis, beta: f64) -> f64 {
    /// Reference chip thickness of Kienzle's specific force, m.
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
