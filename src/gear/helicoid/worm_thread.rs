//! Flank types of cylindrical worms: ZA, ZI, ZN, ZK, ZC, with `tan γ = z₁/q` and `tan α_x = tan α_n/cos γ`.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::axial_profile::{AxialProfile, Helicoid};
use super::grinding_wheel::{GrindingWheel, ToolAxis};
use crate::gear::kernel::root::sign_change;

/// Flank type of a worm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FlankType {
    /// Straight in the axial plane.
    Za,
    /// Involute helicoid.
    Zi,
    /// Straight in the plane across the thread space.
    ZnSpace,
    /// Straight in the plane across the thread.
    ZnThread,
    /// Ground by a conical wheel of this radius at the reference cylinder.
    Zk {
        /// Radius R₀ of the wheel.
        wheel_radius: f64,
    },
    /// Ground by a wheel with a convex arc.
    Zc {
        /// Radius R₀ of the wheel.
        wheel_radius: f64,
        /// Radius of the arc.
        arc_radius: f64,
    },
}

/// A worm's thread by its basic data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WormThread {
    /// Flank type.
    pub flank: FlankType,
    /// Number of starts z₁.
    pub starts: u32,
    /// Axial module m.
    pub module: f64,
    /// Diameter quotient q = d₁/m.
    pub diameter_quotient: f64,
    /// Normal pressure angle α_n, rad.
    pub pressure_angle: f64,
}

impl WormThread {
    /// Reference radius `r = q m/2`.
    pub fn reference_radius(&self) -> f64 {
        0.5 * self.diameter_quotient * self.module
    }

    /// Lead parameter `p = z₁ m/2`.
    pub fn lead(&self) -> f64 {
        0.5 * f64::from(self.starts) * self.module
    }

    /// Lead angle at the reference cylinder, rad.
    pub fn lead_angle(&self) -> f64 {
        (f64::from(self.starts) / self.diameter_quotient).atan()
    }

    /// Axial pressure angle α_x, rad.
    pub fn axial_pressure_angle(&self) -> f64 {
        (self.pressure_angle.tan() / self.lead_angle().cos()).atan()
    }

    /// Base radius of the involute helicoid: `cos γ_b = cos γ cos α_n`, `r_b = p/tan γ_b`.
    pub fn base_radius(&self) -> f64 {
        let base_lead = (self.lead_angle().cos() * self.pressure_angle.cos()).acos();
        self.lead() / base_lead.tan()
    }

    /// The thread ground by the same wheel at another radius, as after dressing; none of threads that no wheel grinds.
    pub fn reground(&self, radius: f64) -> Option<WormThread> {
        let flank = match self.flank {
            FlankType::Zk { .. } => FlankType::Zk {
                wheel_radius: radius,
            },
            FlankType::Zc { arc_radius, .. } => FlankType::Zc {
                wheel_radius: radius,
                arc_radius,
            },
            _ => return None,
        };
        Some(WormThread { flank, ..*self })
    }

    /// The flank through `z = π m/4` on the reference cylinder, in a space whose middle is z = 0; none where the wheel does not reach.
    pub fn helicoid(&self) -> Option<Helicoid> {
        let (r, lead) = (self.reference_radius(), self.lead());
        let profile = match self.flank {
            FlankType::Za => AxialProfile::Straight {
                slope: self.axial_pressure_angle().tan(),
            },
            FlankType::Zi => AxialProfile::Involute {
                base_radius: self.base_radius(),
            },
            FlankType::ZnSpace => self.normal_line(0.0)?,
            FlankType::ZnThread => self.normal_line(FRAC_PI_2 * self.module)?,
            FlankType::Zk { wheel_radius } => AxialProfile::Ground(self.wheel(wheel_radius, None)?),
            FlankType::Zc {
                wheel_radius,
                arc_radius,
            } => AxialProfile::Ground(self.wheel(wheel_radius, Some(arc_radius))?),
        };
        let helicoid = Helicoid {
            lead,
            profile,
            shift: 0.0,
        };
        helicoid.through(r, FRAC_PI_4 * self.module)
    }

    /// The line at α_n across the thread through the reference point, in a plane at the axial height `middle`.
    fn normal_line(&self, middle: f64) -> Option<AxialProfile> {
        let (r, lead, lead_angle) = (self.reference_radius(), self.lead(), self.lead_angle());
        let (sine, cosine) = lead_angle.sin_cos();
        let wanted = FRAC_PI_4 * self.module - middle;
        // The point of the plane on the reference cylinder whose helix passes the axial height.
        let place = |s: f64| {
            let across = s * sine;
            let x = (r * r - across * across).sqrt();
            let height = s * cosine + lead * across.atan2(x);
            x.is_finite().then_some([height - wanted, x])
        };
        let limit = PI * self.module;
        let s = sign_change([-limit, limit], |s| Some(place(s)?[0]))?;
        let slope = self.pressure_angle.tan();
        let offset = s - slope * place(s)?[1];
        Some(AxialProfile::NormalLine {
            lead_angle,
            offset,
            slope,
        })
    }

    /// The wheel at the lead angle whose flank passes the reference point.
    fn wheel(&self, wheel_radius: f64, profile_radius: Option<f64>) -> Option<GrindingWheel> {
        let r = self.reference_radius();
        let axis = ToolAxis {
            distance: wheel_radius + r,
            angle: self.lead_angle(),
        };
        let wheel = |height: f64| {
            let place = [wheel_radius, height];
            GrindingWheel::new(axis, place, self.pressure_angle, profile_radius)
        };
        let middle = FRAC_PI_4 * self.module;
        let lead = self.lead();
        let missed = |height: f64| Some(wheel(height).profile(lead, r)?.height - middle);
        Some(wheel(sign_change([0.5 * middle, 1.5 * middle], missed)?))
    }
}
