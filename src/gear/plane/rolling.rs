//! Two centrodes rolling on each other: `z_work = c_w + (z_tool − c_t) e^{i(ψ_w − ψ_t)}` at the same arc s.
//!
//! A centrode is given by its point c, the direction ψ of its tangent and its curvature κ = dψ/ds. At arc 0 the tangent of a line or circle
//! points along +y.

use std::f64::consts::TAU;

use super::centrodes::{Centrodes, Member};
use super::pitch_curve::{millimetres, out_of_range};
use crate::base::error::Error;
use crate::numeric::Complex;

/// Curve of a body that rolls without slip, by its arc.
#[derive(Debug, Clone)]
pub enum Centrode {
    /// Pitch line of a rack: the y axis.
    Line,
    /// Pitch circle about the origin; the signed radius (m) is negative where the circle lies to the right of its tangent.
    Circle {
        /// Signed radius, m.
        radius: f64,
    },
    /// Centrode of one body of a pair.
    Member {
        /// The pair.
        pair: Centrodes,
        /// The body.
        member: Member,
    },
}

/// Point of a centrode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CentrodePoint {
    /// Position in the body's frame, m.
    pub point: Complex,
    /// Unit tangent in the body's frame.
    pub tangent: Complex,
    /// Curvature, 1/m, positive to the left of the tangent.
    pub curvature: f64,
}

impl Centrode {
    /// Pitch circle of a signed radius, m.
    ///
    /// # Errors
    /// `OutOfRange` for a radius of zero or one that is not finite.
    pub fn circle(radius: f64) -> Result<Centrode, Error> {
        if radius.is_finite() && radius != 0.0 {
            return Ok(Centrode::Circle { radius });
        }
        Err(out_of_range(format!(
            "radius of a pitch circle is {}; it must be finite and not zero",
            millimetres(radius)
        )))
    }

    /// The point at an arc (m); `None` outside the range of the law.
    pub fn at(&self, arc: f64) -> Option<CentrodePoint> {
        match self {
            Centrode::Line => Some(CentrodePoint {
                point: Complex::new(0.0, arc),
                tangent: Complex::new(0.0, 1.0),
                curvature: 0.0,
            }),
            Centrode::Circle { radius } => {
                let direction = Complex::cis(arc / radius);
                Some(CentrodePoint {
                    point: direction * *radius,
                    tangent: Complex::new(0.0, 1.0) * direction,
                    curvature: radius.recip(),
                })
            }
            Centrode::Member { pair, member } => {
                let state = pair.at(pair.angle_at_arc(arc)?)?;
                let (origin, angle) = pair.pose(*member, &state);
                let turn = Complex::cis(-angle);
                Some(CentrodePoint {
                    point: (Complex::new(state.radius_1, 0.0) - origin) * turn,
                    tangent: Complex::cis(state.tangent_angle) * turn,
                    curvature: state.curvatures[*member as usize],
                })
            }
        }
    }

    /// Distance of a point to the left of the curve, m, and the arc of its foot, by Newton's method from a near arc; `scale` is a length of the
    /// problem, m.
    pub(super) fn foot(&self, point: Complex, near: f64, scale: f64) -> Option<(f64, f64)> {
        let mut arc = near;
        for _ in 0..30 {
            let at = self.at(arc)?;
            let local = (point - at.point) * at.tangent.conj();
            let step = local.re / (1.0 - at.curvature * local.im);
            arc += step;
            if step.abs() <= 1e-14 * scale {
                break;
            }
        }
        let at = self.at(arc)?;
        Some((((point - at.point) * at.tangent.conj()).im, arc))
    }

    /// Arc (m) after which the curve repeats; `None` where it does not.
    pub fn arc_of_turn(&self) -> Option<f64> {
        match self {
            Centrode::Line => None,
            Centrode::Circle { radius } => Some(TAU * radius.abs()),
            Centrode::Member { pair, member } => pair.closed_arc(*member).ok(),
        }
    }
}

/// Relative motion of a tool and the work it generates.
#[derive(Debug, Clone)]
pub struct Rolling {
    /// Centrode of the body whose profile is given.
    pub tool: Centrode,
    /// Centrode of the body whose profile is generated.
    pub work: Centrode,
}

/// Both centrodes at one arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollingState {
    /// Point of the tool's centrode.
    pub tool: CentrodePoint,
    /// Point of the work's centrode.
    pub work: CentrodePoint,
}

impl Rolling {
    /// The motion of two gears: gear 1 is the tool.
    pub fn of_pair(pair: &Centrodes) -> Rolling {
        let body = |member| Centrode::Member {
            pair: pair.clone(),
            member,
        };
        Rolling {
            tool: body(Member::First),
            work: body(Member::Second),
        }
    }

    /// The state at an arc (m); `None` outside the range.
    pub fn at(&self, arc: f64) -> Option<RollingState> {
        Some(RollingState {
            tool: self.tool.at(arc)?,
            work: self.work.at(arc)?,
        })
    }

    /// The same motion with tool and work exchanged.
    pub fn reversed(&self) -> Rolling {
        Rolling {
            tool: self.work.clone(),
            work: self.tool.clone(),
        }
    }
}

impl RollingState {
    /// Curvature of the work's centrode less that of the tool's, 1/m: the tool turns against the work by this for each m rolled.
    pub fn relative_curvature(&self) -> f64 {
        self.work.curvature - self.tool.curvature
    }

    /// A point of the tool in the pitch frame: origin in the pitch point, x along the common tangent.
    pub fn to_pitch_frame(&self, tool_point: Complex) -> Complex {
        (tool_point - self.tool.point) * self.tool.tangent.conj()
    }

    /// A point of the tool in the frame of the work.
    pub fn to_work(&self, tool_point: Complex) -> Complex {
        self.work.point + self.to_pitch_frame(tool_point) * self.work.tangent
    }
}
