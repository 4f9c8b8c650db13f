//! Verification of a profile pair by the law of gearing, `i₁₂ = O₂I/O₁I`; I: intersection of the common normal with the line of centres.
//!
//! Contact at φ₁: `z₁ e^{−iφ₁} = σa + z₂ e^{iψ₂}`, tangents parallel; ψ₂ is the counter-clockwise rotation of gear 2 (external: σ = 1).

use super::centrodes::{Centrodes, Member};
use super::pitch_curve::{degrees, out_of_range};
use super::profile::{Profile, ProfileJet};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::sorting::sort_ascending;
use crate::numeric::{Complex, small_dense};

/// Intervals of each profile in the search for the first contact.
const SAMPLES: usize = 200;
/// Maximum number of Newton steps per contact.
const NEWTON_STEPS: usize = 40;
/// Relative step at which Newton's method ends: by quadratic convergence the next step is rounding.
const LAST_STEP: f64 = 3e-8;

/// Contact of a profile pair at an angle of gear 1, compared with the ratio law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearingCheck {
    /// Angle of gear 1, rad.
    pub angle_1: f64,
    /// Transmission error: rotation of gear 2 minus that of the ratio law, rad, positive in its direction of rotation.
    pub error: f64,
    /// Profile parameters of the contact on gears 1 and 2.
    pub parameters: [f64; 2],
    /// Contact point in the fixed frame, m.
    pub point: Complex,
    /// Intersection of the common normal with the line of centres, m from axis 1.
    pub normal_crossing: f64,
    /// Distance of this intersection from the pitch point of the law, m.
    pub pitch_point_deviation: f64,
    /// Instantaneous ratio `ω₁/ω₂`.
    pub ratio: f64,
}

/// Traces the contact of two profiles over angles of gear 1, rad, and compares it with the ratio law of the pair.
///
/// # Errors
/// `OutOfRange` for a rack, an angle outside the range of the law, or profiles without contact at the first angle; `NoConvergence` with the
/// angle at which the contact is lost.
pub fn check_gearing(
    pair: &Centrodes,
    first: &impl Profile,
    second: &impl Profile,
    angles: &[f64],
) -> Result<Vec<GearingCheck>, Error> {
    let Some(axis_2) = pair.mate_axis(Member::Second) else {
        return Err(out_of_range(
            "the check needs two gears; the mate is a rack".into(),
        ));
    };
    let mut checks = vec![];
    let mut previous = None;
    for &angle in angles {
        let state = pair.at(angle).ok_or_else(|| {
            out_of_range(format!(
                "angle {} lies outside the range of the ratio law",
                degrees(angle)
            ))
        })?;
        let turn = pair.displacement(Member::Second, angle).unwrap_or([0.0; 3]);
        let estimate = match previous {
            Some(estimate) => estimate,
            None => first_contact(axis_2, first, second, angle, turn[0]).ok_or_else(|| {
                out_of_range(format!(
                    "the profiles do not touch with gear 1 at {}",
                    degrees(angle)
                ))
            })?,
        };
        let contact_lost = || {
            Error::new(
                Code::NoConvergence,
                format!(
                    "the profiles lose contact with gear 1 at {}",
                    degrees(angle)
                ),
            )
        };
        // The unknown rotation of gear 2 is relative to the law.
        let ([u1, u2, error], point, normal) =
            contact(axis_2, first, second, angle, turn[0], estimate).ok_or_else(contact_lost)?;
        previous = Some([u1, u2, error]);
        let crossing = point.re - point.im * normal.re / normal.im;
        checks.push(GearingCheck {
            angle_1: angle,
            error: error * turn[1].signum(),
            parameters: [u1, u2],
            point,
            normal_crossing: crossing,
            pitch_point_deviation: crossing - state.radius_1,
            ratio: ((axis_2 - crossing) / crossing).abs(),
        });
    }
    Ok(checks)
}

/// Profile parameters and rotation of gear 2 relative to the law by Newton's method, with contact point and unit normal in the fixed frame.
fn contact(
    axis_2: f64,
    first: &impl Profile,
    second: &impl Profile,
    angle: f64,
    turn: f64,
    start: [f64; 3],
) -> Option<([f64; 3], Complex, Complex)> {
    let [low_1, high_1] = first.range();
    let [low_2, high_2] = second.range();
    let i = Complex::new(0.0, 1.0);
    let [mut u1, mut u2, mut error] = start;
    for step in 0..NEWTON_STEPS {
        let (jet_1, jet_2) = (first.jet(u1)?, second.jet(u2)?);
        let (e_1, e_2) = (Complex::cis(-angle), Complex::cis(turn + error));
        let (z1, z2) = (jet_1.point * e_1, jet_2.point * e_2);
        let (t1, t2) = (jet_1.tangent * e_1, jet_2.tangent * e_2);
        let gap = z1 - z2 - axis_2;
        let sine = (t1 * t2.conj()).im;
        let cosine = (t1 * t2.conj()).re;
        let columns = [t1 * jet_1.speed, -t2 * jet_2.speed, -i * z2];
        let mut a = [
            columns[0].re,
            columns[1].re,
            columns[2].re,
            columns[0].im,
            columns[1].im,
            columns[2].im,
            cosine * jet_1.turn,
            -cosine * jet_2.turn,
            -cosine,
        ];
        let mut b = [-gap.re, -gap.im, -sine];
        small_dense::solve(&mut a, &mut b);
        if !b.iter().all(|x| x.is_finite()) {
            return None;
        }
        let size_1 = b[0].abs() / (high_1 - low_1);
        let size_2 = b[1].abs() / (high_2 - low_2);
        let size = size_1.max(size_2).max(b[2].abs());
        let damping = (0.25 / size).min(1.0);
        u1 = (u1 + damping * b[0]).clamp(low_1, high_1);
        u2 = (u2 + damping * b[1]).clamp(low_2, high_2);
        error += damping * b[2];
        if size <= LAST_STEP && step > 0 {
            let jet = first.jet(u1)?;
            let e = Complex::cis(-angle);
            let gap = (jet.point * e - second.jet(u2)?.point * Complex::cis(turn + error) - axis_2)
                .norm();
            let is_contact = gap <= 1e-10 * axis_2.abs();
            return is_contact.then(|| ([u1, u2, error], jet.point * e, i * jet.tangent * e));
        }
    }
    None
}

/// Initial estimate of the contact without normals: for each point of profile 1, the rotation that moves a point of profile 2 of equal
/// radius there. Contact is an extremum of this rotation over the profile; of several, the one nearest to the law.
fn first_contact(
    axis_2: f64,
    first: &impl Profile,
    second: &impl Profile,
    angle: f64,
    turn: f64,
) -> Option<[f64; 3]> {
    let sample = |profile: &dyn Fn(f64) -> Option<ProfileJet>, [low, high]: [f64; 2]| {
        let parameter = |k: usize| low + (high - low) * k as f64 / SAMPLES as f64;
        let row = |k: usize| Some((parameter(k), profile(parameter(k))?.point));
        (0..=SAMPLES).filter_map(row).collect::<Vec<_>>()
    };
    let first_points = sample(&|u| first.jet(u), first.range());
    let second_points = sample(&|u| second.jet(u), second.range());
    let mut rotations: Vec<Option<[f64; 3]>> = vec![];
    for (u1, z1) in &first_points {
        let z = z1 * Complex::cis(-angle) - axis_2;
        let radius = z.norm();
        // Both sides of a lobe have points of this radius; the one nearer to the law is taken.
        let crossings = second_points.windows(2).filter_map(|pair| {
            let (r0, r1) = (pair[0].1.norm(), pair[1].1.norm());
            if (r0 - radius) * (r1 - radius) > 0.0 || r0 == r1 {
                return None;
            }
            let u2 = parameter_of_radius(second, radius, [pair[0].0, pair[1].0])?;
            let z2 = second.jet(u2)?.point;
            let error = (z / z2).arg() - turn;
            let revolutions = (error / std::f64::consts::TAU).round() * std::f64::consts::TAU;
            Some([*u1, u2, error - revolutions])
        });
        rotations.push(crossings.min_by(|a, b| a[2].abs().total_cmp(&b[2].abs())));
    }
    let extremes = rotations.windows(3).filter_map(|three| {
        let [a, b, c] = [three[0]?, three[1]?, three[2]?];
        ((b[2] - a[2]) * (c[2] - b[2]) <= 0.0).then_some(b)
    });
    let mut starts: Vec<[f64; 3]> = extremes.collect();
    sort_ascending(&mut starts, |a| a[2].abs());
    let mut candidates = starts.into_iter();
    candidates.find(|start| contact(axis_2, first, second, angle, turn, *start).is_some())
}

/// Profile parameter of a given radius within a bracket, by the Illinois variant of false position.
fn parameter_of_radius(profile: &impl Profile, radius: f64, [low, high]: [f64; 2]) -> Option<f64> {
    let excess = |u: f64| Some(profile.jet(u)?.point.norm() - radius);
    let (mut a, mut b) = ((low, excess(low)?), (high, excess(high)?));
    for _ in 0..8 {
        let u = a.0 - a.1 * (b.0 - a.0) / (b.1 - a.1);
        let value = excess(u)?;
        match value * a.1 > 0.0 {
            true => (a, b.1) = ((u, value), 0.5 * b.1),
            false => (b, a.1) = ((u, value), 0.5 * a.1),
        }
        if value.abs() <= 1e-14 * radius {
            return Some(u);
        }
    }
    Some(if a.1.abs() < b.1.abs() { a.0 } else { b.0 })
}
