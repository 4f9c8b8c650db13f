//! Contact of two flanks at a pinion angle: `f₁ = f₂ = 0`, `r₁ = r₂`, `n₁ ∥ n₂`, or of an edge of one flank with the other flank.
//!
//! For an edge with tangent t, `n₁ ∥ n₂` is replaced by `t·n = 0` with the normal n of the other flank and by the equation of the edge.

use std::f64::consts::PI;

use super::pair::FlankPair;
use crate::gear::bevel::tooth_section::Side;
use crate::gear::kernel::meeting::MeshingState;
use crate::gear::kernel::newton::{iterate, solve};
use crate::gear::kernel::root::roots;
use crate::gear::kernel::vector::Vector;

/// Unknowns of a contact: u, θ, x of pinion and gear, and the gear angle φ₂, rad.
pub type ContactUnknowns = [f64; 7];

/// Contact point of two flanks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPoint {
    /// Angle φ₁ of the pinion, rad.
    pub pinion_angle: f64,
    /// Parameters u, θ, x of pinion and gear, and the gear angle φ₂.
    pub unknowns: ContactUnknowns,
    /// Derivatives of the unknowns with respect to φ₁.
    pub rates: ContactUnknowns,
    /// Edge in contact; `None` for contact of both flanks.
    pub edge: Option<Edge>,
    /// Point in the fixed frame, m.
    pub point: Vector,
    /// Unit normal of the pinion, out of its material.
    pub normal: Vector,
    /// Tool surface and its motion at the contact, for pinion and gear, each in the frame of its member.
    pub meshing_states: [MeshingState; 2],
}

/// An edge of a tooth flank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// 0 for the pinion, 1 for the gear.
    pub member: usize,
    /// Side of the tooth section.
    pub side: Side,
}

/// Scalar equation with its value and its derivatives with respect to the unknowns (`row`) and to φ₁.
#[derive(Clone, Copy)]
struct Equation {
    value: f64,
    row: ContactUnknowns,
    by_phi_1: f64,
}

/// Member at a contact: tool surface and motion, with r, n and their derivatives with respect to u, θ, x in the fixed frame.
struct Member {
    meeting: MeshingState,
    r: Vector,
    n: Vector,
    dr: [Vector; 3],
    dn: [Vector; 3],
}

impl ContactPoint {
    /// Gear angle φ₂, rad.
    pub fn gear_angle(&self) -> f64 {
        self.unknowns[6]
    }

    /// Instantaneous ratio dφ₂/dφ₁.
    pub fn ratio(&self) -> f64 {
        self.rates[6]
    }
}

impl FlankPair {
    /// Contact of the flanks at φ₁ by Newton's method from `start`; `None` if the method does not converge, as for line contact.
    pub fn contact(&self, pinion_angle: f64, start: ContactUnknowns) -> Option<ContactPoint> {
        let closing = |members: &[Member; 2]| self.parallel_normals(members);
        self.solve_contact(pinion_angle, start, None, closing)
    }

    /// Contact of an edge of one flank with the other flank at φ₁, by Newton's method from `start`.
    pub fn edge_contact(
        &self,
        pinion_angle: f64,
        start: ContactUnknowns,
        edge: Edge,
    ) -> Option<ContactPoint> {
        let closing = |members: &[Member; 2]| self.edge_on_flank(members, edge);
        self.solve_contact(pinion_angle, start, Some(edge), closing)
    }

    /// Contact without initial estimates: the middle of the pinion flank is rotated until `n·v₁₂ = 0`, and the gear flank is computed at
    /// that position. Of several angles, that with the smallest deviation of the normals is taken.
    pub fn first_contact(&self) -> Option<ContactPoint> {
        let middle = self.flanks[0].middle()?;
        let pinion = self.flanks[0].envelope.meeting(middle)?;
        let relative = self.turn(0).plus(-self.ratio(), self.turn(1));
        let condition = |angle: f64| {
            let pose = self.pose(0, angle);
            let (r, n) = (pose.apply(pinion.jet.r), pose.rotate(pinion.jet.n));
            let turn = self.turn(0);
            let (dr, dn) = (turn.at(r), turn.w.cross(n));
            let f = n.dot(relative.at(r));
            Some([f, dn.dot(relative.at(r)) + n.dot(relative.w.cross(dr))])
        };
        let mut best: Option<(f64, f64, ContactUnknowns)> = None;
        for angle in roots([-PI, PI], condition) {
            let pose = self.pose(0, angle);
            let (r, n) = (pose.apply(pinion.jet.r), pose.rotate(pinion.jet.n));
            let gear_point = self.pose(1, 0.0).inverse().apply(r);
            let position = [gear_point.z, f64::hypot(gear_point.x, gear_point.y)];
            let Some(in_gear) = self.flanks[1].find(position) else {
                continue;
            };
            let Some(gear) = self.flanks[1].envelope.meeting(in_gear) else {
                continue;
            };
            let point = gear.jet.r;
            let turn = gear_point.y.atan2(gear_point.x) - point.y.atan2(point.x);
            let gear_angle = turn - 2.0 * PI * (turn / (2.0 * PI)).round();
            let mismatch = (n + self.pose(1, gear_angle).rotate(gear.jet.n)).norm();
            if best.is_none_or(|(smallest, ..)| mismatch < smallest) {
                let [u, theta, x] = middle;
                let unknowns = [u, theta, x, in_gear[0], in_gear[1], in_gear[2], gear_angle];
                best = Some((mismatch, angle, unknowns));
            }
        }
        let (_, angle, start) = best?;
        self.contact(angle, start)
    }

    fn members(&self, pinion_angle: f64, y: &ContactUnknowns) -> Option<[Member; 2]> {
        Some([self.member(0, pinion_angle, y)?, self.member(1, y[6], y)?])
    }

    fn member(&self, k: usize, angle: f64, y: &ContactUnknowns) -> Option<Member> {
        let at = [y[3 * k], y[3 * k + 1], y[3 * k + 2]];
        let meeting = self.flanks[k].envelope.meeting(at)?;
        let pose = self.pose(k, angle);
        let jet = &meeting.jet;
        let change = meeting.angular.cross(jet.n);
        Some(Member {
            r: pose.apply(jet.r),
            n: pose.rotate(jet.n),
            dr: [jet.dr[0], jet.dr[1], meeting.velocity].map(|d| pose.rotate(d)),
            dn: [jet.dn[0], jet.dn[1], change].map(|d| pose.rotate(d)),
            meeting,
        })
    }

    /// Solves f₁, f₂, the three coordinates and the two equations `closing` by Newton's method; the same elimination gives the rates.
    fn solve_contact(
        &self,
        pinion_angle: f64,
        start: ContactUnknowns,
        edge: Option<Edge>,
        closing: impl Fn(&[Member; 2]) -> [Equation; 2],
    ) -> Option<ContactPoint> {
        let scales = self.scales();
        let system = |y: &ContactUnknowns| {
            let members = self.members(pinion_angle, y)?;
            let closing = closing(&members);
            Some((self.equations(&members, closing), members))
        };
        let unknowns = iterate(start, scales, |y| {
            let (equations, members) = system(&y)?;
            let meshing = members.each_ref().map(|m| m.meeting.f);
            eliminate(
                &members,
                equations.map(|e| (e.value, e.row)),
                meshing,
                &scales,
            )
        })?;
        let (equations, members) = system(&unknowns)?;
        let rates = eliminate(
            &members,
            equations.map(|e| (e.by_phi_1, e.row)),
            [0.0; 2],
            &scales,
        )?;
        Some(ContactPoint {
            pinion_angle,
            unknowns,
            rates: std::array::from_fn(|j| -rates[j] * scales[j]),
            edge,
            point: members[0].r,
            normal: members[0].n,
            meshing_states: members.map(|m| m.meeting),
        })
    }

    /// Equations other than f₁ and f₂: three coordinates and the two arguments.
    fn equations(&self, [a, b]: &[Member; 2], [fourth, fifth]: [Equation; 2]) -> [Equation; 5] {
        let (by_phi_1, by_gear) = (self.turn(0).at(a.r), -self.turn(1).at(b.r));
        let columns = [
            a.dr[0], a.dr[1], a.dr[2], -b.dr[0], -b.dr[1], -b.dr[2], by_gear,
        ];
        let gap = (a.r - b.r).array();
        let coordinate = |k: usize| Equation {
            value: gap[k],
            row: columns.map(|d| d.array()[k]),
            by_phi_1: by_phi_1.array()[k],
        };
        [coordinate(0), coordinate(1), coordinate(2), fourth, fifth]
    }

    /// `t·(n₁×n₂) = 0` for two tangents t of the pinion, independent of the signs of the normals. The derivative of t is omitted, since its
    /// factor n₁×n₂ vanishes at the contact.
    fn parallel_normals(&self, [a, b]: &[Member; 2]) -> [Equation; 2] {
        let cross = a.n.cross(b.n);
        let columns = [
            a.dn[0].cross(b.n),
            a.dn[1].cross(b.n),
            a.dn[2].cross(b.n),
            a.n.cross(b.dn[0]),
            a.n.cross(b.dn[1]),
            a.n.cross(b.dn[2]),
            a.n.cross(self.turn(1).w.cross(b.n)),
        ];
        let by_phi_1 = self.turn(0).w.cross(a.n).cross(b.n);
        [a.dr[0], a.n.cross(a.dr[0])].map(|t| Equation {
            value: t.dot(cross),
            row: columns.map(|d| t.dot(d)),
            by_phi_1: t.dot(by_phi_1),
        })
    }

    /// Contact of the edge `c_z z + c_ρ ρ = c₀` of the section with the other flank: `t·n = 0`, `t = n_edge × (c_z k + c_ρ e_ρ)`.
    fn edge_on_flank(&self, members: &[Member; 2], edge: Edge) -> [Equation; 2] {
        let k = edge.member;
        let (owner, other) = (&members[k], &members[1 - k]);
        let [c_z, c_rho, c_0] = self.flanks[k].section.side(edge.side);
        let turn = self.turn(k);
        let axis = turn.w;
        let position = owner.r - self.centre(k);
        let z = position.dot(axis);
        let radial = position - axis * z;
        let rho = radial.norm();
        let (e_rho, e_phi) = (radial * (1.0 / rho), axis.cross(radial) * (1.0 / rho));
        let gradient = axis * c_z + e_rho * c_rho;
        let t = owner.n.cross(gradient);
        let mut edge_row = [0.0; 7];
        let mut contact_row = [0.0; 7];
        for i in 0..3 {
            edge_row[3 * k + i] = gradient.dot(owner.dr[i]);
            let gradient_change = e_phi * (c_rho * e_phi.dot(owner.dr[i]) / rho);
            let dt = owner.dn[i].cross(gradient) + owner.n.cross(gradient_change);
            contact_row[3 * k + i] = dt.dot(other.n);
            contact_row[3 * (1 - k) + i] = t.dot(other.dn[i]);
        }
        // Rotation of a member about its axis rotates t or the other normal.
        let rotation_derivative = |member: usize| {
            let w = self.turn(member).w;
            match member == k {
                true => w.cross(t).dot(other.n),
                false => t.dot(w.cross(other.n)),
            }
        };
        contact_row[6] = rotation_derivative(1);
        [
            Equation {
                value: c_z * z + c_rho * rho - c_0,
                row: edge_row,
                by_phi_1: 0.0,
            },
            Equation {
                value: t.dot(other.n),
                row: contact_row,
                by_phi_1: rotation_derivative(0),
            },
        ]
    }

    fn scales(&self) -> ContactUnknowns {
        let [a, b] = [0, 1].map(|k| self.flanks[k].envelope.parameter_scales());
        [a[0], a[1], a[2], b[0], b[1], b[2], 1.0]
    }
}

/// Solves `J Δ = g` for the step Δ, scaled by `scales`: `∇f·Δ = f` of each member eliminates the unknown with the largest scaled
/// derivative, and five equations `(g, row)` remain.
#[inline]
fn eliminate(
    members: &[Member; 2],
    mut equations: [(f64, ContactUnknowns); 5],
    meshing: [f64; 2],
    scales: &ContactUnknowns,
) -> Option<ContactUnknowns> {
    for (_, row) in &mut equations {
        (0..7).for_each(|j| row[j] *= scales[j]);
    }
    let mut columns = [0, 0, 0, 0, 6];
    let mut pivots = [0, 0];
    let mut ratios = [[0.0; 3]; 2];
    for k in 0..2 {
        let gradient = members[k].meeting.gradient;
        let scaled: [f64; 3] = std::array::from_fn(|i| gradient[i] * scales[3 * k + i]);
        let larger = |i: usize, j: usize| {
            if scaled[j].abs() > scaled[i].abs() {
                j
            } else {
                i
            }
        };
        let pivot = larger(larger(0, 1), 2);
        let [i, j] = [[1, 2], [0, 2], [0, 1]][pivot];
        let inverse = 1.0 / scaled[pivot];
        ratios[k] = [
            scaled[i] * inverse,
            scaled[j] * inverse,
            meshing[k] * inverse,
        ];
        pivots[k] = 3 * k + pivot;
        (columns[2 * k], columns[2 * k + 1]) = (3 * k + i, 3 * k + j);
        let [a, b, c] = ratios[k];
        for (value, row) in &mut equations {
            let factor = row[pivots[k]];
            row[3 * k + i] -= factor * a;
            row[3 * k + j] -= factor * b;
            *value -= factor * c;
        }
    }
    let rows = equations.map(|(_, row)| columns.map(|j| row[j]));
    let solution = solve(rows, equations.map(|(value, _)| value))?;
    let mut step = [0.0; 7];
    (0..5).for_each(|m| step[columns[m]] = solution[m]);
    for k in 0..2 {
        let [a, b, c] = ratios[k];
        step[pivots[k]] = c - a * solution[2 * k] - b * solution[2 * k + 1];
    }
    step.iter().all(|x| x.is_finite()).then_some(step)
}
