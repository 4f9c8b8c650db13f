//! Ratio functions of two axes: `i₁₂(φ₁) = ω₁/ω₂`, `φ₂ = ∫ dφ₁/i₁₂`.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use super::curve_law::CurveLaw;
use super::pitch_curve::{
    CLOSURE_TOLERANCE, PitchCurve, check_turn, degrees, even_panels, out_of_range, panels_between,
    turn_angles,
};
use crate::base::error::Error;
use crate::numeric::quintic_spline::QuinticSpline;

/// Relative distance from an integer up to which a ratio counts as an integer.
const INTEGER_TOLERANCE: f64 = 1e-9;

/// Ratio function `i₁₂(φ₁)`, positive in its whole range.
#[derive(Debug, Clone)]
pub struct RatioLaw(Law);

#[derive(Debug, Clone)]
enum Law {
    Constant(f64),
    Linear {
        first: f64,
        slope: f64,
        range: f64,
    },
    Elliptic(f64),
    Sine {
        mean: f64,
        amplitude: f64,
        cycles: f64,
    },
    Table(Arc<QuinticSpline>),
    Curve(Arc<CurveLaw>),
}

/// Values of a ratio function at one angle of gear 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RatioState {
    /// Angle φ₂ of gear 2, rad; 0 at φ₁ = 0.
    pub angle_2: f64,
    /// Ratio `i₁₂ = ω₁/ω₂`.
    pub ratio: f64,
    /// First derivative `di₁₂/dφ₁`, 1/rad.
    pub slope: f64,
    /// Second derivative `d²i₁₂/dφ₁²`, 1/rad².
    pub second: f64,
}

impl RatioLaw {
    /// Constant ratio function.
    ///
    /// # Errors
    /// `OutOfRange` unless it is positive.
    pub fn constant(ratio: f64) -> Result<RatioLaw, Error> {
        check_ratio(ratio)?;
        Ok(RatioLaw(Law::Constant(ratio)))
    }

    /// Ratio linear in φ₁, from `first` at φ₁ = 0 to `last` at φ₁ = `range` (rad); not defined outside.
    ///
    /// # Errors
    /// `OutOfRange` unless all three are positive.
    pub fn linear(first: f64, last: f64, range: f64) -> Result<RatioLaw, Error> {
        check_ratio(first)?;
        check_ratio(last)?;
        if !(range > 0.0 && range <= 1e6) {
            return Err(out_of_range(format!(
                "the ratio changes over {}; give a positive angle of at most 1e6 rad",
                degrees(range)
            )));
        }
        Ok(RatioLaw(Law::Linear {
            first,
            slope: (last - first) / range,
            range,
        }))
    }

    /// Ratio of two equal ellipses about their foci: `i₁₂ = (1 + e² − 2e cos φ₁)/(1 − e²)`, `tan(φ₂/2) = (1+e)/(1−e) tan(φ₁/2)`.
    ///
    /// # Errors
    /// `OutOfRange` unless 0 ≤ e < 1.
    pub fn elliptic(eccentricity: f64) -> Result<RatioLaw, Error> {
        if !(0.0..1.0).contains(&eccentricity) {
            return Err(out_of_range(format!(
                "eccentricity of elliptic centrodes is {eccentricity}; it must be at least 0 and below 1"
            )));
        }
        Ok(RatioLaw(Law::Elliptic(eccentricity)))
    }

    /// Ratio `i₁₂ = mean + amplitude sin(cycles φ₁)`; the centrode of gear 2 closes if `cycles √(mean² − amplitude²)` is an integer.
    ///
    /// # Errors
    /// `OutOfRange` unless |amplitude| < mean and `cycles` ≥ 1.
    pub fn sine(mean: f64, amplitude: f64, cycles: u32) -> Result<RatioLaw, Error> {
        check_ratio(mean)?;
        if !(amplitude.abs() < mean) {
            return Err(out_of_range(format!(
                "amplitude {amplitude} of the ratio reaches its mean {mean}, so that the ratio is not positive everywhere"
            )));
        }
        if cycles == 0 {
            return Err(out_of_range(
                "a sine ratio has 0 cycles in a turn; give 1 or more, or a constant ratio".into(),
            ));
        }
        Ok(RatioLaw(Law::Sine {
            mean,
            amplitude,
            cycles: f64::from(cycles),
        }))
    }

    /// Periodic quintic spline through angles φ₂ at increasing φ₁ (rad) over one revolution of gear 1, in which gear 2 turns 2π/n (last row).
    ///
    /// # Errors
    /// `OutOfRange` with the row at which either column, or the spline between rows, does not increase, or if the table does not close.
    pub fn table(angles_1: &[f64], angles_2: &[f64]) -> Result<RatioLaw, Error> {
        check_turn(angles_1, angles_2, "the angle of gear 2")?;
        if let Some(row) = (1..angles_2.len()).find(|&i| angles_2[i] <= angles_2[i - 1]) {
            return Err(out_of_range(format!(
                "row {}: angle {} of gear 2 does not rise above {}; the table is not monotonic",
                row + 1,
                degrees(angles_2[row]),
                degrees(angles_2[row - 1])
            )));
        }
        let n = angles_2.len() - 1;
        let advance = angles_2[n] - angles_2[0];
        let passes = (TAU / advance).round().max(1.0);
        if (advance * passes - TAU).abs() > CLOSURE_TOLERANCE * TAU {
            return Err(out_of_range(format!(
                "row {}: gear 2 turns {} in a turn of gear 1; the table does not close",
                n + 1,
                degrees(advance)
            ))
            .with_hint(format!(
                "make gear 2 turn 360 deg/n, nearest {}",
                degrees(TAU / passes)
            )));
        }
        let mut closed_angles = angles_2.to_vec();
        closed_angles[n] = angles_2[0] + TAU / passes;
        let x = turn_angles(angles_1);
        let spline = QuinticSpline::periodic(&x, &closed_angles)
            .ok_or_else(|| out_of_range("the table has fewer than three rows".into()))?;
        for (row, pair) in x.windows(2).enumerate() {
            let rate = |i: u32| spline.at(pair[0] + (pair[1] - pair[0]) * f64::from(i) / 16.0)[1];
            if (0..=16).any(|i| !(rate(i) > 0.0)) {
                return Err(out_of_range(format!(
                    "rows {} and {}: the spline through the table falls between them; the table is not monotonic enough",
                    row + 1,
                    row + 2
                ))
                .with_hint("add rows there, or smooth the table"));
            }
        }
        Ok(RatioLaw(Law::Table(Arc::new(spline))))
    }

    /// Ratio function of a pitch curve of gear 1 at a centre distance a (m): `i₁₂ = (a − r₁)/r₁`.
    ///
    /// # Errors
    /// `OutOfRange` if the centre distance does not exceed the largest radius.
    pub fn of_pitch_curve(curve: &PitchCurve, centre_distance: f64) -> Result<RatioLaw, Error> {
        let law = CurveLaw::new(curve, centre_distance)?;
        Ok(RatioLaw(Law::Curve(Arc::new(law))))
    }

    /// Range of φ₁ (rad) in which the ratio function is defined; infinite if it is periodic.
    pub fn range(&self) -> [f64; 2] {
        match self.0 {
            Law::Linear { range, .. } => [0.0, range],
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Period in φ₁ and rotation of gear 2 over one period, rad; `None` if the ratio function is not periodic.
    pub fn period(&self) -> Option<[f64; 2]> {
        let period = match &self.0 {
            Law::Linear { .. } => return None,
            Law::Sine { cycles, .. } => TAU / cycles,
            _ => TAU,
        };
        Some([period, self.at(period)?.angle_2])
    }

    /// Returns an error unless the centrodes of the ratio function close.
    ///
    /// # Errors
    /// `OutOfRange`, with the nearest ratio function that closes as a hint if one exists.
    pub fn check_closed(&self) -> Result<(), Error> {
        let Some([_, advance]) = self.period() else {
            return Err(out_of_range(
                "the ratio is not periodic over a turn, so the centrodes are open and have no closed outline"
                    .into(),
            )
            .with_hint("use a periodic law, or omit the tooth numbers"));
        };
        let n = TAU / advance;
        if matches!(self.0, Law::Constant(_)) || (n - n.round()).abs() <= INTEGER_TOLERANCE * n {
            return Ok(());
        }
        let error = out_of_range(format!(
            "gear 2 turns {} in a period of the ratio, and its turn takes {n:.6} periods; its centrode does not close",
            degrees(advance)
        ));
        Err(match self.0 {
            Law::Sine {
                amplitude, cycles, ..
            } => {
                let mean = (n.round().max(1.0) / cycles).hypot(amplitude);
                error.with_hint(format!("give the ratio the mean {mean}"))
            }
            _ => error.with_hint("use the centre distance that closes the pitch curve"),
        })
    }

    /// Angle of gear 2, ratio and its derivatives at an angle of gear 1 (rad); `None` outside the range.
    pub fn at(&self, angle_1: f64) -> Option<RatioState> {
        let [low, high] = self.range();
        if !(low..=high).contains(&angle_1) || !angle_1.is_finite() {
            return None;
        }
        Some(match &self.0 {
            Law::Constant(ratio) => RatioState {
                angle_2: angle_1 / ratio,
                ratio: *ratio,
                slope: 0.0,
                second: 0.0,
            },
            Law::Linear { first, slope, .. } => {
                let x = slope * angle_1 / first;
                let mean = if x == 0.0 { 1.0 } else { x.ln_1p() / x };
                RatioState {
                    angle_2: angle_1 / first * mean,
                    ratio: first + slope * angle_1,
                    slope: *slope,
                    second: 0.0,
                }
            }
            Law::Elliptic(e) => {
                let ((sin, cos), scale) = (angle_1.sin_cos(), (1.0 - e) * (1.0 + e));
                RatioState {
                    angle_2: angle_1 + 2.0 * (e * sin / (1.0 - e * cos)).atan(),
                    ratio: (1.0 + e * e - 2.0 * e * cos) / scale,
                    slope: 2.0 * e * sin / scale,
                    second: 2.0 * e * cos / scale,
                }
            }
            Law::Sine {
                mean,
                amplitude,
                cycles,
            } => {
                let root = ((mean - amplitude) * (mean + amplitude)).sqrt();
                // ∫ dy/(m + A cos y) = (y − 2 atan(A sin y/(m + w + A cos y)))/w, w² = m² − A².
                let integral = |y: f64| {
                    let (sin, cos) = y.sin_cos();
                    y - 2.0 * (amplitude * sin / (mean + root + amplitude * cos)).atan()
                };
                let x = cycles * angle_1;
                let (sin, cos) = x.sin_cos();
                RatioState {
                    angle_2: (integral(x - FRAC_PI_2) - integral(-FRAC_PI_2)) / (cycles * root),
                    ratio: mean + amplitude * sin,
                    slope: amplitude * cycles * cos,
                    second: -amplitude * cycles * cycles * sin,
                }
            }
            Law::Table(spline) => {
                let [y, y1, y2, y3] = spline.at(angle_1);
                RatioState {
                    angle_2: y - spline.at(0.0)[0],
                    ratio: y1.recip(),
                    slope: -y2 / (y1 * y1),
                    second: (2.0 * y2 * y2 / y1 - y3) / (y1 * y1),
                }
            }
            Law::Curve(law) => {
                let ([r, r1, r2], a) = (law.curve.at(angle_1), law.centre_distance);
                RatioState {
                    angle_2: law.angle_2(angle_1) - law.angle_2(0.0),
                    ratio: (a - r) / r,
                    slope: -a * r1 / (r * r),
                    second: a * (2.0 * r1 * r1 / r - r2) / (r * r),
                }
            }
        })
    }

    /// Angles of gear 1 (rad), over a period or the range, between which the ratio function is smooth.
    pub(super) fn panel_ends(&self) -> Vec<f64> {
        match &self.0 {
            Law::Table(spline) => panels_between(spline.knots()),
            Law::Curve(law) => law.curve.panel_ends(),
            Law::Linear { range, .. } => even_panels(*range),
            Law::Sine { cycles, .. } => even_panels(TAU / cycles),
            Law::Constant(_) | Law::Elliptic(_) => even_panels(TAU),
        }
    }
}

/// Range of ratios in which squares and products stay far from overflow.
const RATIO_RANGE: [f64; 2] = [1e-6, 1e6];

fn check_ratio(ratio: f64) -> Result<(), Error> {
    let [min, max] = RATIO_RANGE;
    if (min..=max).contains(&ratio) {
        return Ok(());
    }
    Err(out_of_range(format!(
        "a ratio is {ratio}; it must be positive, from {min} to {max} (the sense of rotation is set by the kind of the pair)"
    )))
}
