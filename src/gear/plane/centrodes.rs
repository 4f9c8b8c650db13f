//! Centrodes of two gears, `r₁ = a/(i₁₂ ± 1)`, `r₂ = i₁₂ r₁`, and of a pinion and a rack; `ds = √(r₁² + r₁′²) dφ₁` for both.
//!
//! Fixed frame: axis 1 at the origin, the pitch point at (r₁, 0), axis 2 at (a, 0) for external and (−a, 0) for internal gears. Gear 1
//! rotates clockwise by φ₁, so the pitch point in the frame of gear 1 is `r₁(φ₁) e^{iφ₁}`. Points of the plane are complex numbers, m.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use super::pitch_curve::{PitchCurve, check_length, degrees, out_of_range};
use super::ratio_law::RatioLaw;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::quadrature::CumulativeIntegral;
use crate::numeric::statistics::extremes;

/// Angle intervals of a period, or of the full range, in a search for extremes.
const POSITIONS: usize = 360;

/// Type of the gear that meshes with gear 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mate {
    /// External gear, rotating opposite to gear 1.
    External,
    /// Internal gear around gear 1, rotating in the same direction.
    Internal,
}

/// Centrodes of two gears with parallel axes, or of a gear and a rack.
#[derive(Debug, Clone)]
pub struct Centrodes(Arc<Curves>);

#[derive(Debug)]
struct Curves {
    source: Source,
    arc: CumulativeIntegral,
    /// Start of the range of φ₁ of the arc integral, rad: one period, or the full range.
    first: f64,
    last: f64,
    repeats: bool,
}

#[derive(Debug)]
enum Source {
    Gears {
        law: RatioLaw,
        centre_distance: f64,
        /// +1 for an external, −1 for an internal mate.
        side: f64,
    },
    Rack {
        curve: PitchCurve,
        /// Start of the travel integral over one revolution, rad.
        first: f64,
        travel: CumulativeIntegral,
    },
}

/// Member of a pair of centrodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Member {
    /// Gear 1.
    First,
    /// Gear 2 or the rack.
    Second,
}

/// Kinematic state of a pair of centrodes at an angle of gear 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PitchState {
    /// Angle of gear 1, rad.
    pub angle_1: f64,
    /// Angle of gear 2, rad, opposite to gear 1 for an external mate; 0 for a rack.
    pub angle_2: f64,
    /// Travel of a rack, m; 0 for a gear.
    pub travel: f64,
    /// Pitch radius r₁ of gear 1, m; the pitch point is at (r₁, 0).
    pub radius_1: f64,
    /// Derivative dr₁/dφ₁, m/rad.
    pub radius_slope: f64,
    /// Arc rate ds/dφ₁, m/rad.
    pub arc_rate: f64,
    /// Direction of the common tangent in the fixed frame, rad.
    pub tangent_angle: f64,
    /// Curvatures of both centrodes, 1/m, positive towards axis 1.
    pub curvatures: [f64; 2],
}

impl Centrodes {
    /// Centrodes of a ratio law at a centre distance a, m.
    ///
    /// # Errors
    /// `OutOfRange` if a is not positive, or for an internal mate with a ratio i₁₂ of 1 or less.
    pub fn of_gears(law: &RatioLaw, centre_distance: f64, mate: Mate) -> Result<Centrodes, Error> {
        check_length(centre_distance, "centre distance")?;
        let side = match mate {
            Mate::External => 1.0,
            Mate::Internal => -1.0,
        };
        let ends = law.panel_ends();
        for angle in &ends {
            let ratio = law.at(*angle).map_or(f64::NAN, |state| state.ratio);
            if !(ratio + side > 0.0) {
                return Err(out_of_range(format!(
                    "ratio i12 is {ratio:.6} at {}; i12 must exceed 1 for an internal gear",
                    degrees(*angle)
                )));
            }
        }
        let source = Source::Gears {
            law: law.clone(),
            centre_distance,
            side,
        };
        Ok(Centrodes::new(source, ends, law.period().is_some()))
    }

    /// Centrodes of a gear with a given pitch curve and of a rack that moves perpendicular to the line from the axis to the pitch point.
    pub fn of_rack(curve: &PitchCurve) -> Centrodes {
        let ends = curve.panel_ends();
        let source = Source::Rack {
            curve: curve.clone(),
            first: ends[0],
            travel: CumulativeIntegral::new(|x| curve.at(x)[0], ends.clone()),
        };
        Centrodes::new(source, ends, true)
    }

    fn new(source: Source, ends: Vec<f64>, repeats: bool) -> Centrodes {
        let (first, last) = (ends[0], ends[ends.len() - 1]);
        let arc = CumulativeIntegral::new(|x| source.arc_rate(x), ends);
        Centrodes(Arc::new(Curves {
            source,
            arc,
            first,
            last,
            repeats,
        }))
    }

    /// Type of the mate; `None` for a rack.
    pub fn mate(&self) -> Option<Mate> {
        match self.0.source {
            Source::Rack { .. } => None,
            Source::Gears { side, .. } if side < 0.0 => Some(Mate::Internal),
            Source::Gears { .. } => Some(Mate::External),
        }
    }

    /// State at an angle φ₁, rad; `None` outside the range of the law.
    pub fn at(&self, angle_1: f64) -> Option<PitchState> {
        self.0.source.at(angle_1)
    }

    /// Rolled arc length from φ₁ = 0 to an angle of gear 1, rad; m.
    pub fn arc(&self, angle_1: f64) -> f64 {
        self.0.arc_from_start(angle_1) - self.0.arc_from_start(0.0)
    }

    /// Arc length of one period, or of the full range, m.
    pub fn arc_of_period(&self) -> f64 {
        self.0.arc.total()
    }

    /// First and last angle of gear 1 of one period, or of the full range, rad.
    pub fn period(&self) -> [f64; 2] {
        [self.0.first, self.0.last]
    }

    /// Minimum and maximum of a quantity over one period, or over the full range, at 361 angles of gear 1.
    pub fn extremes(&self, value: impl Fn(f64) -> Option<f64>) -> [f64; 2] {
        extremes(self.angles().filter_map(value)).into()
    }

    /// Angles of gear 1 over one period, or over the full range, at equal steps with both ends, rad.
    pub fn angles(&self) -> impl Iterator<Item = f64> + use<> {
        let [first, last] = self.period();
        (0..=POSITIONS).map(move |i| first + (last - first) * i as f64 / POSITIONS as f64)
    }

    /// Arc length of the closed centrode of a member, m.
    ///
    /// # Errors
    /// `OutOfRange` for open centrodes.
    pub fn closed_arc(&self, member: Member) -> Result<f64, Error> {
        let Source::Gears { law, .. } = &self.0.source else {
            return match member {
                Member::First => Ok(self.arc_of_period()),
                Member::Second => Err(out_of_range("a rack is not a closed curve".into())),
            };
        };
        law.check_closed()?;
        let [period, advance] = law.period().unwrap_or([TAU, TAU]);
        let periods = match member {
            Member::First => TAU / period,
            Member::Second => TAU / advance,
        };
        Ok(self.arc_of_period() * periods)
    }

    /// Angle φ₁, rad, at a rolled arc length, m; `None` outside the range.
    pub fn angle_at_arc(&self, arc: f64) -> Option<f64> {
        let curves = &*self.0;
        let total = curves.arc.total();
        let arc = arc + curves.arc_from_start(0.0);
        let periods = match curves.repeats {
            true => (arc / total).floor(),
            false => 0.0,
        };
        let remainder = arc - periods * total;
        let slack = 1e-12 * total;
        if !(-slack..=total + slack).contains(&remainder) {
            return None;
        }
        let rate = |x: f64| curves.source.arc_rate(x.clamp(curves.first, curves.last));
        let angle = curves.arc.inverse(rate, remainder.clamp(0.0, total));
        Some(angle.clamp(curves.first, curves.last) + periods * (curves.last - curves.first))
    }

    /// Pose of a member at a state: origin, m, and angle, rad, of its frame in the fixed frame.
    pub fn pose(&self, member: Member, state: &PitchState) -> (Complex, f64) {
        match (member, &self.0.source) {
            (Member::First, _) => (Complex::new(0.0, 0.0), -state.angle_1),
            (Member::Second, Source::Rack { .. }) => (Complex::new(0.0, -state.travel), 0.0),
            (
                Member::Second,
                Source::Gears {
                    centre_distance,
                    side,
                    ..
                },
            ) => {
                let origin = Complex::new(side * centre_distance, 0.0);
                (origin, side * state.angle_2)
            }
        }
    }

    /// Whether the ratio law is periodic.
    pub fn repeats(&self) -> bool {
        self.0.repeats
    }

    /// Position of the axis of a member on the line of centres, m; `None` for a rack.
    pub fn mate_axis(&self, member: Member) -> Option<f64> {
        match (member, &self.0.source) {
            (Member::First, _) => Some(0.0),
            (_, Source::Rack { .. }) => None,
            (
                _,
                Source::Gears {
                    centre_distance,
                    side,
                    ..
                },
            ) => Some(side * centre_distance),
        }
    }

    /// Counter-clockwise rotation of a member, rad, or displacement of a rack along y, m, with two derivatives with respect to φ₁.
    pub fn displacement(&self, member: Member, angle_1: f64) -> Option<[f64; 3]> {
        if member == Member::First {
            return Some([-angle_1, -1.0, 0.0]);
        }
        match &self.0.source {
            Source::Gears { law, side, .. } => {
                let state = law.at(angle_1)?;
                let rate = side / state.ratio;
                Some([
                    side * state.angle_2,
                    rate,
                    -rate * state.slope / state.ratio,
                ])
            }
            Source::Rack { curve, .. } => {
                let [r, slope, _] = curve.at(angle_1);
                Some([-self.at(angle_1)?.travel, -r, -slope])
            }
        }
    }
}

impl Curves {
    /// Arc length from the start of the range, m.
    fn arc_from_start(&self, angle_1: f64) -> f64 {
        let length = self.last - self.first;
        let periods = match self.repeats {
            true => ((angle_1 - self.first) / length).floor(),
            false => 0.0,
        };
        let remainder = angle_1 - periods * length;
        periods * self.arc.total() + self.arc.at(|x| self.source.arc_rate(x), remainder)
    }
}

impl Source {
    /// Pitch radius and derivatives `[r₁, r₁′, r₁″]`, m.
    fn polar(&self, angle_1: f64) -> Option<[f64; 3]> {
        match self {
            Source::Rack { curve, .. } => Some(curve.at(angle_1)),
            Source::Gears {
                law,
                centre_distance: a,
                side,
            } => {
                let state = law.at(angle_1)?;
                let sum = state.ratio + side;
                let slope = state.slope / sum;
                Some([
                    a / sum,
                    -a * slope / sum,
                    a * (2.0 * slope * slope - state.second / sum) / sum,
                ])
            }
        }
    }

    fn arc_rate(&self, angle_1: f64) -> f64 {
        self.polar(angle_1)
            .map_or(f64::NAN, |[r, r1, _]| r.hypot(r1))
    }

    fn at(&self, angle_1: f64) -> Option<PitchState> {
        let [r, r1, r2] = self.polar(angle_1)?;
        let arc_rate = r.hypot(r1);
        // δ = π/2 − atan(r₁′/r₁) is the direction of the tangent; in the frame of a member its angle is subtracted.
        let tangent_rate = (r1 * r1 - r * r2) / (arc_rate * arc_rate);
        let (angle_2, travel, mate_rate) = match self {
            Source::Gears { law, side, .. } => {
                let state = law.at(angle_1)?;
                (state.angle_2, 0.0, side / state.ratio)
            }
            Source::Rack {
                curve,
                first,
                travel,
            } => {
                let path = |x: f64| {
                    let turns = ((x - first) / TAU).floor();
                    turns * travel.total() + travel.at(|x| curve.at(x)[0], x - turns * TAU)
                };
                (0.0, path(angle_1) - path(0.0), 0.0)
            }
        };
        Some(PitchState {
            angle_1,
            angle_2,
            travel,
            radius_1: r,
            radius_slope: r1,
            arc_rate,
            tangent_angle: FRAC_PI_2 - (r1 / r).atan(),
            curvatures: [
                (tangent_rate + 1.0) / arc_rate,
                (tangent_rate - mate_rate) / arc_rate,
            ],
        })
    }
}
