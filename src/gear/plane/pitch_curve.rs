//! Pitch curves in polar form, `r₁(φ₁)`, and the centre distance of a closed mate: `∫₀^2π r₁/(a − r₁) dφ₁ = 2π/n`.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::quadrature::CumulativeIntegral;
use crate::numeric::quintic_spline::QuinticSpline;

/// Number of panels of an integral over one revolution; ten points in each reach rounding accuracy for eccentricities up to 0.9.
const PANELS: usize = 128;
/// Relative Newton step below which the iteration has converged: the next step is of the size of rounding.
const STEP_TOLERANCE: f64 = 1e-12;

/// Closed pitch curve about an axis of rotation, with one radius for each angle.
#[derive(Debug, Clone)]
pub struct PitchCurve(Shape);

#[derive(Debug, Clone)]
enum Shape {
    /// `r = p/(1 − e cos nφ)`: for n = 1 an ellipse about its focus.
    Ellipse {
        parameter: f64,
        eccentricity: f64,
        lobes: f64,
    },
    /// `r = e cos φ + √(R² − e² sin²φ)`.
    EccentricCircle {
        radius: f64,
        eccentricity: f64,
    },
    Table(QuinticSpline),
}

impl PitchCurve {
    /// Ellipse of semi-major axis A (m) about its focus, repeated `lobes` = n times per revolution: `r = A (1 − e²)/(1 − e cos nφ)`.
    ///
    /// # Errors
    /// `OutOfRange` unless A > 0, 0 ≤ e < 1, n ≥ 1.
    pub fn ellipse(semi_major: f64, eccentricity: f64, lobes: u32) -> Result<PitchCurve, Error> {
        check_length(semi_major, "semi-major axis")?;
        if !(0.0..1.0).contains(&eccentricity) {
            return Err(out_of_range(format!(
                "eccentricity of an ellipse is {eccentricity}; it must be at least 0 and below 1"
            )));
        }
        if lobes == 0 {
            return Err(out_of_range(
                "an ellipse has 0 lobes; give 1 or more".into(),
            ));
        }
        Ok(PitchCurve(Shape::Ellipse {
            parameter: semi_major * (1.0 - eccentricity) * (1.0 + eccentricity),
            eccentricity,
            lobes: f64::from(lobes),
        }))
    }

    /// Circle of a radius whose centre lies `eccentricity` (both m) from the axis, towards φ = 0.
    ///
    /// # Errors
    /// `OutOfRange` unless the axis lies inside the circle.
    pub fn eccentric_circle(radius: f64, eccentricity: f64) -> Result<PitchCurve, Error> {
        if !(radius > 0.0 && radius.is_finite() && (0.0..radius).contains(&eccentricity)) {
            return Err(out_of_range(format!(
                "the axis lies {} from the centre of a circle of radius {}; it must lie inside",
                millimetres(eccentricity),
                millimetres(radius)
            )));
        }
        Ok(PitchCurve(Shape::EccentricCircle {
            radius,
            eccentricity,
        }))
    }

    /// Periodic quintic spline through radii (m) at increasing angles (rad); the last row lies one revolution after the first and repeats its radius.
    ///
    /// # Errors
    /// `OutOfRange` with the row where an angle does not increase, a radius is not positive, or the table does not close over a revolution.
    pub fn table(angles: &[f64], radii: &[f64]) -> Result<PitchCurve, Error> {
        check_turn(angles, radii, "radius")?;
        if let Some(row) = radii.iter().position(|r| !(*r > 0.0)) {
            return Err(out_of_range(format!(
                "row {}: radius {} is not positive",
                row + 1,
                millimetres(radii[row])
            )));
        }
        let (first, last) = (radii[0], radii[radii.len() - 1]);
        if (last - first).abs() > CLOSURE_TOLERANCE * first {
            return Err(out_of_range(format!(
                "row {}: radius {} after one turn, {} in row 1; the table does not close",
                radii.len(),
                millimetres(last),
                millimetres(first)
            ))
            .with_hint("repeat the first radius in the last row"));
        }
        let mut closed_radii = radii.to_vec();
        closed_radii[radii.len() - 1] = first;
        let spline = QuinticSpline::periodic(&turn_angles(angles), &closed_radii)
            .ok_or_else(|| out_of_range("the table has fewer than three rows".into()))?;
        Ok(PitchCurve(Shape::Table(spline)))
    }

    /// Radius and its derivatives `[r, r′, r″]` (m, m/rad, m/rad²) at an angle (rad).
    pub fn at(&self, angle: f64) -> [f64; 3] {
        match &self.0 {
            Shape::Ellipse {
                parameter: p,
                eccentricity: e,
                lobes: n,
            } => {
                let (sin, cos) = (n * angle).sin_cos();
                let g = 1.0 - e * cos;
                let (g1, g2) = (e * n * sin, e * n * n * cos);
                [
                    p / g,
                    -p * g1 / (g * g),
                    p * (2.0 * g1 * g1 / g - g2) / (g * g),
                ]
            }
            Shape::EccentricCircle {
                radius,
                eccentricity: e,
            } => {
                let (sin, cos) = angle.sin_cos();
                let root = ((radius - e * sin) * (radius + e * sin)).sqrt();
                let root_1 = -e * e * sin * cos / root;
                let root_2 = (e * e * (sin * sin - cos * cos) - root_1 * root_1) / root;
                [e * cos + root, -e * sin + root_1, -e * cos + root_2]
            }
            Shape::Table(spline) => {
                let [r, r1, r2, _] = spline.at(angle);
                [r, r1, r2]
            }
        }
    }

    /// Angles (rad) over one revolution between which the curve is smooth.
    pub(super) fn panel_ends(&self) -> Vec<f64> {
        match &self.0 {
            Shape::Table(spline) => panels_between(spline.knots()),
            _ => even_panels(TAU),
        }
    }

    /// Largest radius (m) over the panel ends.
    fn largest_radius(&self) -> f64 {
        let radii = self.panel_ends().into_iter().map(|angle| self.at(angle)[0]);
        radii.fold(0.0, f64::max)
    }

    /// Centre distance (m) at which an external mate closes after `lobes` = n revolutions of this curve, each of which turns it by 2π/n.
    ///
    /// Litvin & Fuentes, Gear Geometry and Applied Theory, 2nd ed. (2004), §12.7.
    ///
    /// # Errors
    /// `OutOfRange` for n = 0; `NoConvergence` if the closure equation has no root.
    pub fn closing_centre_distance(&self, lobes: u32) -> Result<f64, Error> {
        if lobes == 0 {
            return Err(out_of_range(
                "a closed mate needs a whole number of passes; give 1 or more".into(),
            ));
        }
        let angle = TAU / f64::from(lobes);
        let ends = self.panel_ends();
        let integral = |f: &dyn Fn(f64) -> f64| CumulativeIntegral::new(f, ends.clone()).total();
        // G(a) = ∫ r/(a − r) decreases from +∞ and is convex: Newton's method converges monotonically from a start left of the root.
        let largest_radius = self.largest_radius();
        let mut a = largest_radius * (1.0 + 1e-3);
        let excess = |a: f64| integral(&|x| ratio_of(self.at(x)[0], a)) - angle;
        let mut gap = 1e-3;
        while !(excess(a) > 0.0) && gap > 1e-12 {
            gap *= 0.1;
            a = largest_radius * (1.0 + gap);
        }
        for _ in 0..200 {
            let slope = integral(&|x| {
                let r = self.at(x)[0];
                r / ((a - r) * (a - r))
            });
            let step = excess(a) / slope;
            a += step;
            if step.abs() <= STEP_TOLERANCE * a {
                return Ok(a);
            }
        }
        Err(Error::new(
            Code::NoConvergence,
            format!("the mate is not closed after {lobes} passes at any centre distance"),
        ))
    }
}

fn ratio_of(r: f64, a: f64) -> f64 {
    r / (a - r)
}

/// Relative difference of first and last row up to which a table counts as closed: the sixth digit of a printed table.
pub(super) const CLOSURE_TOLERANCE: f64 = 1e-5;

/// Returns an error unless the angles (rad) increase and span one revolution; `quantity` names the other column.
pub(super) fn check_turn(angles: &[f64], values: &[f64], quantity: &str) -> Result<(), Error> {
    if angles.len() != values.len() || angles.len() < 4 {
        return Err(out_of_range(format!(
            "the table has {} angles and {} values of {quantity}; give 4 rows or more",
            angles.len(),
            values.len()
        )));
    }
    if let Some(row) =
        (0..angles.len()).find(|&i| !(angles[i].is_finite() && values[i].is_finite()))
    {
        return Err(out_of_range(format!(
            "row {}: not a finite number",
            row + 1
        )));
    }
    if let Some(row) = (1..angles.len()).find(|&i| angles[i] <= angles[i - 1]) {
        return Err(out_of_range(format!(
            "row {}: angle {} does not rise above {}",
            row + 1,
            degrees(angles[row]),
            degrees(angles[row - 1])
        )));
    }
    let span = angles[angles.len() - 1] - angles[0];
    if (span - TAU).abs() > CLOSURE_TOLERANCE * TAU {
        return Err(out_of_range(format!(
            "row {}: the angles span {}; the table does not close over a turn of 360 deg",
            angles.len(),
            degrees(span)
        )));
    }
    Ok(())
}

/// Angles (rad) with the last set to exactly one revolution after the first.
pub(super) fn turn_angles(angles: &[f64]) -> Vec<f64> {
    let mut turn = angles.to_vec();
    turn[angles.len() - 1] = angles[0] + TAU;
    turn
}

/// Ends of equal panels from 0 to `length`.
pub(super) fn even_panels(length: f64) -> Vec<f64> {
    let end = |i| length * i as f64 / PANELS as f64;
    (0..=PANELS).map(end).collect()
}

/// Ends of panels that break at every knot, at least `PANELS` panels in all.
pub(super) fn panels_between(knots: &[f64]) -> Vec<f64> {
    let n_parts = PANELS.div_ceil(knots.len() - 1).max(1);
    let mut ends = vec![knots[0]];
    for pair in knots.windows(2) {
        let end = |i| pair[0] + (pair[1] - pair[0]) * i as f64 / n_parts as f64;
        ends.extend((1..n_parts).map(end));
        ends.push(pair[1]);
    }
    ends
}

/// Range of lengths (m) in which squares and products stay far from overflow.
const LENGTH_RANGE: [f64; 2] = [1e-9, 1e9];

/// Returns an error for a length (m) outside `LENGTH_RANGE`; `quantity` names it.
pub(super) fn check_length(length: f64, quantity: &str) -> Result<(), Error> {
    let [shortest, longest] = LENGTH_RANGE;
    if (shortest..=longest).contains(&length) {
        return Ok(());
    }
    Err(out_of_range(format!(
        "{quantity} is {}; it must be positive, from {} to {}",
        millimetres(length),
        millimetres(shortest),
        millimetres(longest)
    )))
}

/// Text of an angle (rad) in degrees, for messages.
pub(super) fn degrees(angle: f64) -> String {
    format!("{} deg", round_to_six_decimals(angle.to_degrees()))
}

/// Text of a length (m) in millimetres, for messages.
pub(super) fn millimetres(length: f64) -> String {
    format!("{} mm", round_to_six_decimals(1e3 * length))
}

fn round_to_six_decimals(x: f64) -> f64 {
    (1e6 * x).round() / 1e6
}

pub(super) fn out_of_range(message: String) -> Error {
    Error::new(Code::OutOfRange, message)
}
