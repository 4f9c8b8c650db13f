//! Contact of two profiles: sliding and curvature by Euler–Savary, `1/m_w = 1/m_t − (κ_w − κ_t)/f_s`.
//!
//! m is the distance of a centre of curvature from the pitch point along the normal, `f_s = ∂f/∂s = −sin α`, α the angle of the normal and
//! the common tangent (Litvin & Fuentes 2004, ch. 6).

use super::profile::ProfileJet;
use super::rolling::Rolling;
use crate::numeric::Complex;

/// Contact of a tool's profile and the profile it generates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Parameter on the tool's profile.
    pub parameter: f64,
    /// Arc rolled, m.
    pub arc: f64,
    /// Contact point in the frame of the tool, m.
    pub tool_point: Complex,
    /// Contact point in the frame of the work, m.
    pub work_point: Complex,
    /// Contact point in the pitch frame (origin in the pitch point, x along the common tangent), m: a point of the line of action.
    pub path_point: Complex,
    /// Unit tangent of the generated profile in the frame of the work.
    pub work_tangent: Complex,
    /// Distance of the contact from the pitch point along the normal `i t`, signed, m.
    pub normal_distance: f64,
    /// `f_s`: −sin of the angle between normal and common tangent; 0 is a limit of the second kind.
    pub second_limit: f64,
    /// Speed of the contact on the tool's profile, m, times a common factor.
    pub tool_speed: f64,
    /// Speed of the contact on the generated profile, m, times the same factor; 0 is a limit of the first kind.
    pub work_speed: f64,
    /// Curvature of the tool's profile, 1/m, positive to the left of its tangent.
    pub tool_curvature: f64,
    /// Curvature of the generated profile, 1/m.
    pub work_curvature: f64,
    /// `∂f/∂u`, m.
    pub(super) slope: f64,
    /// Turn of the tangent of the generated profile, with the factor of the speeds.
    pub(super) work_turn: f64,
}

impl Contact {
    /// The contact of a profile's point at an arc where f vanishes; `None` outside the range of the motion.
    pub(super) fn new(rolling: &Rolling, u: f64, jet: &ProfileJet, arc: f64) -> Option<Contact> {
        let state = rolling.at(arc)?;
        let path_point = state.to_pitch_frame(jet.point);
        let tangent = jet.tangent * state.tool.tangent.conj();
        let normal_distance = (path_point * tangent.conj()).im;
        let relative = state.relative_curvature();
        let slope = jet.speed + jet.turn * normal_distance;
        let second_limit = -tangent.re;
        // du : ds = f_s : −f_u keeps both profiles in contact.
        let tool_speed = jet.speed * second_limit;
        let work_speed = tool_speed + relative * normal_distance * slope;
        let work_turn = jet.turn * second_limit - relative * slope;
        Some(Contact {
            parameter: u,
            arc,
            tool_point: jet.point,
            work_point: state.to_work(jet.point),
            path_point,
            work_tangent: tangent * state.work.tangent,
            normal_distance,
            second_limit,
            tool_speed,
            work_speed,
            tool_curvature: jet.curvature(),
            work_curvature: work_turn / work_speed,
            slope,
            work_turn,
        })
    }

    /// Arc at a near parameter, to first order.
    pub(super) fn arc_near(&self, u: f64) -> f64 {
        self.arc - (u - self.parameter) * self.slope / self.second_limit
    }

    /// Specific sliding ζ of tool and work: `1 − (speed of the other)/(own speed)`.
    pub fn specific_sliding(&self) -> [f64; 2] {
        [
            1.0 - self.work_speed / self.tool_speed,
            1.0 - self.tool_speed / self.work_speed,
        ]
    }

    /// Sliding velocity for each m rolled: tool against work along the tool's tangent.
    pub fn sliding(&self) -> f64 {
        (self.tool_speed - self.work_speed) / self.slope
    }
}
