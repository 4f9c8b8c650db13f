//! Conjugate profiles from a line of action: a point at the distance l from the pitch point, in the direction α from the common tangent,
//! belongs to the arc `s = s₀ − ∫ dl/cos α`, and both profiles are read off there.
//!
//! The profile moves along its tangent, so that `dl/ds = −cos α`: the general solution of Willis' law (Litvin & Fuentes 2004, §5.4).

use super::pitch_curve::{millimetres, out_of_range};
use super::rolling::Rolling;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::quadrature;
use crate::numeric::quintic_spline::QuinticSpline;

/// Panels between two neighbouring points.
const PANELS: usize = 8;
/// Least |cos α|: where the line runs at right angles to the tangent the body would roll without end.
const STEEPEST: f64 = 1e-6;

/// Line of action in the pitch frame, by its own parameter.
#[derive(Debug, Clone)]
pub enum LineOfAction {
    /// Straight line through the pitch point at an angle (rad) to the tangent; the parameter is the distance l (m). It makes involutes.
    Straight {
        /// Angle α, rad.
        angle: f64,
    },
    /// Circle through the pitch point, touching the tangent, centre at (0, radius); the parameter is α (rad), `l = 2 r sin α`. It makes
    /// cycloids.
    Circle {
        /// Signed radius, m.
        radius: f64,
    },
    /// Curve of an arc or pin carried by a pitch circle; the parameter is the angle θ (rad) of its centre behind the line of centres.
    Arc {
        /// Distance of the arc's centre from the axis of the pitch circle, m.
        centre_distance: f64,
        /// Signed radius of the pitch circle, m.
        pitch_radius: f64,
        /// Radius of the arc, m, negative where the contact lies beyond the centre.
        arc_radius: f64,
    },
    /// Quintic splines through points of the pitch frame, by row.
    Points(PathSpline),
}

/// Splines of l and α through points of a line of action.
#[derive(Debug, Clone)]
pub struct PathSpline {
    distance: QuinticSpline,
    angle: QuinticSpline,
}

/// Contact read off a line of action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActionContact {
    /// Arc rolled, m.
    pub arc: f64,
    /// Contact point in the pitch frame, m.
    pub path_point: Complex,
    /// Contact point in the frame of the tool, m.
    pub tool_point: Complex,
    /// Contact point in the frame of the work, m.
    pub work_point: Complex,
}

impl LineOfAction {
    /// The line through points (m) of the pitch frame, seven or more, by row; it may pass through the pitch point.
    ///
    /// # Errors
    /// `OutOfRange` for fewer points, or with the row of a point that is not finite or is the pitch point itself.
    pub fn points(points: &[Complex]) -> Result<LineOfAction, Error> {
        let mut distances = vec![];
        let mut angles: Vec<f64> = vec![];
        for (row, z) in points.iter().enumerate() {
            let (mut l, mut angle) = (z.norm(), z.arg());
            if !(l > 0.0 && l.is_finite()) {
                return Err(out_of_range(format!(
                    "row {}: the point ({}, {}) m of the line of action has no direction from the pitch point",
                    row + 1,
                    z.re,
                    z.im
                ))
                .with_hint("leave the pitch point itself out: the line passes through it by interpolation"));
            }
            if let Some(before) = angles.last() {
                // Direction modulo π: beyond the pitch point the distance counts negative.
                let half_turns = ((before - angle) / std::f64::consts::PI).round();
                angle += half_turns * std::f64::consts::PI;
                if half_turns.rem_euclid(2.0) == 1.0 {
                    l = -l;
                }
            }
            distances.push(l);
            angles.push(angle);
        }
        let rows: Vec<f64> = (0..points.len()).map(|i| i as f64).collect();
        let spline = |values: &[f64]| QuinticSpline::interpolate(&rows, values);
        match (spline(&distances), spline(&angles)) {
            (Some(distance), Some(angle)) => {
                Ok(LineOfAction::Points(PathSpline { distance, angle }))
            }
            _ => Err(out_of_range(format!(
                "a line of action is given by {} points; give 7 or more",
                points.len()
            ))),
        }
    }

    /// `[l, dl/dt, α]` at a parameter.
    fn at(&self, t: f64) -> [f64; 3] {
        match self {
            LineOfAction::Straight { angle } => [t, 1.0, *angle],
            LineOfAction::Circle { radius } => {
                let (sin, cos) = t.sin_cos();
                [2.0 * radius * sin, 2.0 * radius * cos, t]
            }
            LineOfAction::Arc {
                centre_distance,
                pitch_radius,
                arc_radius,
            } => {
                // Centre of the arc seen from the pitch point, x along the tangent, which points along +y.
                let turn = Complex::new(0.0, -1.0);
                let centre = Complex::cis(t) * *centre_distance;
                let (q, dq) = (
                    (centre - *pitch_radius) * turn,
                    Complex::new(0.0, 1.0) * centre * turn,
                );
                let norm = q.norm();
                [norm - arc_radius, (q.conj() * dq).re / norm, q.arg()]
            }
            LineOfAction::Points(spline) => {
                let [l, dl, ..] = spline.distance.at(t);
                [l, dl, spline.angle.at(t)[0]]
            }
        }
    }

    /// Contacts at rising parameters, the first of which belongs to the arc `start` (m).
    ///
    /// # Errors
    /// `OutOfRange` where the line runs at right angles to the common tangent, or leaves the range of the motion.
    pub fn contacts(
        &self,
        rolling: &Rolling,
        parameters: &[f64],
        start: f64,
    ) -> Result<Vec<ActionContact>, Error> {
        let rate = |t: f64| {
            let [_, dl, angle] = self.at(t);
            -dl / angle.cos()
        };
        let mut contacts = vec![];
        let (mut arc, mut before): (f64, Option<f64>) = (start, None);
        for &t in parameters {
            if let Some(t0) = before {
                let at = |k: usize| t0 + (t - t0) * k as f64 / PANELS as f64;
                let panel = |k: usize| quadrature::panel(rate, at(k), at(k + 1));
                arc += (0..PANELS).map(panel).sum::<f64>();
            }
            before = Some(t);
            let [l, _, angle] = self.at(t);
            if !(angle.cos().abs() > STEEPEST) {
                return Err(out_of_range(format!(
                    "the line of action runs at right angles to the pitch line at its parameter {t}; it makes no profile there"
                )));
            }
            let path_point = Complex::cis(angle) * l;
            let state = rolling.at(arc).ok_or_else(|| {
                out_of_range(format!(
                    "the line of action needs the arc {}, outside the range of the ratio law",
                    millimetres(arc)
                ))
            })?;
            contacts.push(ActionContact {
                arc,
                path_point,
                tool_point: state.tool.point + path_point * state.tool.tangent,
                work_point: state.work.point + path_point * state.work.tangent,
            });
        }
        Ok(contacts)
    }
}
