//! Conjugate profiles from a line of action: its point at the distance l from the pitch point, at the angle α to the common tangent,
//! is the contact at the arc `s = s₀ − ∫ dl/cos α`, which gives a point of both profiles.
//!
//! The profile moves along its tangent, so `dl/ds = −cos α`: the general solution of Willis' law (Litvin & Fuentes 2004, §5.4).

use super::pitch_curve::{millimetres, out_of_range};
use super::rolling::Rolling;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::quadrature;
use crate::numeric::quintic_spline::QuinticSpline;

/// Quadrature panels between neighbouring parameters.
const PANELS: usize = 8;
/// Minimum |cos α|: a line of action perpendicular to the tangent needs an infinite arc.
const MIN_COSINE: f64 = 1e-6;

/// Line of action in the pitch frame, as a parametric curve.
#[derive(Debug, Clone)]
pub enum LineOfAction {
    /// Straight line through the pitch point at an angle to the tangent, for involutes; the parameter is the distance l, m.
    Straight {
        /// Angle α, rad.
        angle: f64,
    },
    /// Circle tangent to the common tangent at the pitch point, centre (0, radius), for cycloids; the parameter is α, rad, and
    /// `l = 2 r sin α`.
    Circle {
        /// Signed radius, m.
        radius: f64,
    },
    /// Line of action of an arc or pin fixed to a pitch circle; the parameter is the angle θ of its centre behind the line of centres, rad.
    Arc {
        /// Distance of the arc's centre from the axis of the pitch circle, m.
        centre_distance: f64,
        /// Signed radius of the pitch circle, m.
        pitch_radius: f64,
        /// Radius of the arc, m, negative where the contact lies beyond the centre.
        arc_radius: f64,
    },
    /// Quintic splines through points of the pitch frame; the parameter is the row index.
    Points(PathSpline),
}

/// Quintic splines of l, m, and α, rad, through points of a line of action.
#[derive(Debug, Clone)]
pub struct PathSpline {
    distance: QuinticSpline,
    angle: QuinticSpline,
}

/// Contact at a point of a line of action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActionContact {
    /// Rolled arc, m.
    pub arc: f64,
    /// Contact point in the pitch frame, m.
    pub path_point: Complex,
    /// Contact point in the frame of the tool, m.
    pub tool_point: Complex,
    /// Contact point in the frame of the work, m.
    pub work_point: Complex,
}

impl LineOfAction {
    /// Line of action through seven or more points of the pitch frame, m; it may pass through the pitch point.
    ///
    /// # Errors
    /// `OutOfRange` for fewer points, and for a point that is not finite or coincides with the pitch point, with its row.
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
                .with_hint("omit the pitch point: the line passes through it by interpolation"));
            }
            if let Some(previous) = angles.last() {
                // The direction is continued modulo π: beyond the pitch point the distance is negative.
                let half_turns = ((previous - angle) / std::f64::consts::PI).round();
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

    /// Distance, derivative and direction `[l, dl/dt, α]` at a parameter.
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
                // Centre of the arc relative to the pitch point, x along the common tangent, which points along +y.
                let rotation = Complex::new(0.0, -1.0);
                let centre = Complex::cis(t) * *centre_distance;
                let (q, dq) = (
                    (centre - *pitch_radius) * rotation,
                    Complex::new(0.0, 1.0) * centre * rotation,
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

    /// Contacts at ascending parameters; `start`: rolled arc of the first contact, m.
    ///
    /// # Errors
    /// `OutOfRange` where the line is perpendicular to the common tangent, and outside the range of the motion.
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
        let (mut arc, mut previous): (f64, Option<f64>) = (start, None);
        for &t in parameters {
            if let Some(t0) = previous {
                let node = |k: usize| t0 + (t - t0) * k as f64 / PANELS as f64;
                let panel = |k: usize| quadrature::panel(rate, node(k), node(k + 1));
                arc += (0..PANELS).map(panel).sum::<f64>();
            }
            previous = Some(t);
            let [l, _, angle] = self.at(t);
            if !(angle.cos().abs() > MIN_COSINE) {
                return Err(out_of_range(format!(
                    "the line of action is perpendicular to the pitch line at its parameter {t}; it gives no profile there"
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
