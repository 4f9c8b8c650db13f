//! Tooth profiles of one body: points z(u) with `dz/du = speed · t`, `dt/du = turn · i t`, t the unit tangent.
//!
//! The curvature is turn/speed; kept apart, both serve a cusp (speed 0) and a point (an arc of radius 0).

use super::pitch_curve::{degrees, millimetres, out_of_range};
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::quintic_spline::QuinticSpline;

/// A profile with its derivatives.
pub trait Profile {
    /// First and last parameter.
    fn range(&self) -> [f64; 2];

    /// Point and derivatives at a parameter; `None` outside the range or where the profile has no point.
    fn jet(&self, u: f64) -> Option<ProfileJet>;
}

/// Point of a profile with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileJet {
    /// Position in the body's frame, m.
    pub point: Complex,
    /// Unit tangent.
    pub tangent: Complex,
    /// Arc length for each unit of the parameter, signed, m.
    pub speed: f64,
    /// Angle of the tangent for each unit of the parameter, rad.
    pub turn: f64,
}

impl ProfileJet {
    /// Curvature, 1/m, positive to the left of the tangent.
    pub fn curvature(&self) -> f64 {
        self.turn / self.speed
    }
}

/// Profiles in closed form and profiles through points.
#[derive(Debug, Clone)]
pub struct Shape(Kind);

#[derive(Debug, Clone)]
enum Kind {
    Line {
        start: Complex,
        direction: Complex,
        length: f64,
    },
    Arc {
        centre: Complex,
        radius: f64,
        angles: [f64; 2],
    },
    Involute {
        base_radius: f64,
        start_angle: f64,
        hand: f64,
        roll: [f64; 2],
    },
    Cycloid {
        base_radius: f64,
        rolling_radius: f64,
        start_angle: f64,
        angles: [f64; 2],
    },
    Points {
        x: QuinticSpline,
        y: QuinticSpline,
    },
}

impl Shape {
    /// Straight profile between two points, m; u is the distance from the first.
    ///
    /// # Errors
    /// `OutOfRange` where the points coincide or are not finite.
    pub fn line(start: Complex, end: Complex) -> Result<Shape, Error> {
        let length = (end - start).norm();
        if !(length > 0.0 && length.is_finite()) {
            return Err(out_of_range(format!(
                "a straight profile from ({}, {}) is {} long; give two points apart",
                millimetres(start.re),
                millimetres(start.im),
                millimetres(length)
            )));
        }
        Ok(Shape(Kind::Line {
            start,
            direction: (end - start) / length,
            length,
        }))
    }

    /// Arc about a centre, radius in m, u the angle (rad) between rising limits; radius 0 is a point, u then the direction of its normal.
    ///
    /// # Errors
    /// `OutOfRange` for a negative radius or limits that do not rise.
    pub fn arc(centre: Complex, radius: f64, angles: [f64; 2]) -> Result<Shape, Error> {
        if !(radius >= 0.0 && radius.is_finite() && centre.norm().is_finite()) {
            return Err(out_of_range(format!(
                "radius of an arc is {}; it must be finite and not negative",
                millimetres(radius)
            )));
        }
        check_range(angles)?;
        Ok(Shape(Kind::Arc {
            centre,
            radius,
            angles,
        }))
    }

    /// Involute of a base circle (m) about the origin, u the roll angle ξ (rad): `z = r_b (1 − i h ξ) e^{i(θ₀ + h ξ)}`, h = +1 where its
    /// azimuth rises with the radius.
    ///
    /// # Errors
    /// `OutOfRange` unless the base radius is positive and 0 ≤ ξ rises.
    pub fn involute(
        base_radius: f64,
        start_angle: f64,
        is_rising: bool,
        roll: [f64; 2],
    ) -> Result<Shape, Error> {
        check_radius(base_radius, "base circle")?;
        check_range(roll)?;
        if roll[0] < 0.0 {
            return Err(out_of_range(format!(
                "roll angle {} of an involute is negative; it must be 0 or more, from the base circle",
                degrees(roll[0])
            )));
        }
        Ok(Shape(Kind::Involute {
            base_radius,
            start_angle,
            hand: if is_rising { 1.0 } else { -1.0 },
            roll,
        }))
    }

    /// Cycloid of a circle r rolling on a base circle R about the origin, outside for r > 0, inside for r < 0, around it for r < −R;
    /// u is the angle θ (rad) of the rolling circle's centre: `z = e^{iθ₀}[(R + r) e^{iθ} − r e^{iθ(R + r)/r}]`, with a cusp at θ = 0.
    ///
    /// # Errors
    /// `OutOfRange` where R is not positive, r is 0 or −R, or θ does not rise.
    pub fn cycloid(
        base_radius: f64,
        rolling_radius: f64,
        start_angle: f64,
        angles: [f64; 2],
    ) -> Result<Shape, Error> {
        check_radius(base_radius, "base circle")?;
        check_range(angles)?;
        let is_circle = rolling_radius == 0.0 || rolling_radius == -base_radius;
        if is_circle || !rolling_radius.is_finite() {
            return Err(out_of_range(format!(
                "rolling radius {} on a base circle of {} gives no cycloid; use another radius",
                millimetres(rolling_radius),
                millimetres(base_radius)
            )));
        }
        Ok(Shape(Kind::Cycloid {
            base_radius,
            rolling_radius,
            start_angle,
            angles,
        }))
    }

    /// Quintic splines of both coordinates over the chord length, through seven points (m) or more.
    ///
    /// # Errors
    /// `OutOfRange` with the row where a point repeats the one before it, and for fewer points.
    pub fn points(points: &[Complex]) -> Result<Shape, Error> {
        if points.len() < 7 {
            return Err(out_of_range(format!(
                "a profile is given by {} points; give 7 or more",
                points.len()
            )));
        }
        let mut chord = vec![0.0];
        for (row, pair) in points.windows(2).enumerate() {
            let length = (pair[1] - pair[0]).norm();
            if !(length > 0.0 && length.is_finite()) {
                return Err(out_of_range(format!(
                    "row {}: the point ({}, {}) m repeats the row before it or is not finite",
                    row + 2,
                    pair[1].re,
                    pair[1].im
                )));
            }
            chord.push(chord[row] + length);
        }
        let coordinate = |f: fn(&Complex) -> f64| {
            let values: Vec<f64> = points.iter().map(f).collect();
            QuinticSpline::interpolate(&chord, &values)
        };
        match (coordinate(|z| z.re), coordinate(|z| z.im)) {
            (Some(x), Some(y)) => Ok(Shape(Kind::Points { x, y })),
            _ => Err(out_of_range(
                "the points are too close for their chord length to increase; omit some".into(),
            )),
        }
    }
}

impl Profile for Shape {
    fn range(&self) -> [f64; 2] {
        match &self.0 {
            Kind::Line { length, .. } => [0.0, *length],
            Kind::Arc { angles, .. } | Kind::Cycloid { angles, .. } => *angles,
            Kind::Involute { roll, .. } => *roll,
            Kind::Points { x, .. } => [x.knots()[0], x.knots()[x.knots().len() - 1]],
        }
    }

    fn jet(&self, u: f64) -> Option<ProfileJet> {
        let [low, high] = self.range();
        if !(low..=high).contains(&u) {
            return None;
        }
        let i = Complex::new(0.0, 1.0);
        Some(match &self.0 {
            Kind::Line {
                start, direction, ..
            } => ProfileJet {
                point: start + direction * u,
                tangent: *direction,
                speed: 1.0,
                turn: 0.0,
            },
            Kind::Arc { centre, radius, .. } => ProfileJet {
                point: centre + Complex::cis(u) * *radius,
                tangent: i * Complex::cis(u),
                speed: *radius,
                turn: 1.0,
            },
            Kind::Involute {
                base_radius,
                start_angle,
                hand,
                ..
            } => {
                let tangent = Complex::cis(start_angle + hand * u);
                ProfileJet {
                    point: tangent * Complex::new(1.0, -hand * u) * *base_radius,
                    tangent,
                    speed: base_radius * u,
                    turn: *hand,
                }
            }
            Kind::Cycloid {
                base_radius,
                rolling_radius: r,
                start_angle,
                ..
            } => {
                let (sum, x) = (base_radius + r, u * base_radius / r);
                let start = Complex::cis(*start_angle);
                // dz/dθ = 2 (R + r) sin(x/2) e^{i(θ₀ + θ + x/2)} with x = θ R/r.
                ProfileJet {
                    point: start * (Complex::cis(u) * sum - Complex::cis(u + x) * *r),
                    tangent: start * Complex::cis(u + 0.5 * x),
                    speed: 2.0 * sum * (0.5 * x).sin(),
                    turn: 1.0 + 0.5 * base_radius / r,
                }
            }
            Kind::Points { x, y } => {
                let ([x, x1, x2, _], [y, y1, y2, _]) = (x.at(u), y.at(u));
                let speed = x1.hypot(y1);
                ProfileJet {
                    point: Complex::new(x, y),
                    tangent: Complex::new(x1, y1) / speed,
                    speed,
                    turn: (x1 * y2 - y1 * x2) / (speed * speed),
                }
            }
        })
    }
}

fn check_radius(radius: f64, what: &str) -> Result<(), Error> {
    if radius > 0.0 && radius.is_finite() {
        return Ok(());
    }
    Err(out_of_range(format!(
        "radius of a {what} is {}; it must be positive",
        millimetres(radius)
    )))
}

fn check_range([low, high]: [f64; 2]) -> Result<(), Error> {
    if low < high && low.is_finite() && high.is_finite() {
        return Ok(());
    }
    Err(out_of_range(format!(
        "a profile runs from {low} to {high}; the limits must increase"
    )))
}
