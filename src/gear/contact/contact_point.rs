//! The contact of two flanks at an angle of the pinion: `f₁ = f₂ = 0`, `r₁ = r₂`, `n₁ ∥ n₂`, or an edge of one on the flank of the other.
//!
//! At an edge with the tangent t the last two equations are `t·n = 0` with the other flank's normal and the edge itself.

use std::f64::consts::PI;

use super::pair::FlankPair;
use crate::gear::bevel::tooth_section::Side;
use crate::gear::kernel::meeting::Meeting;
use crate::gear::kernel::newton::{iterate, solve};
use crate::gear::kernel::root::roots;
use crate::gear::kernel::vector::Vector;

/// Unknowns of a contact: u, θ, x of both flanks and the gear's angle.
pub type ContactUnknowns = [f64; 7];

/// A contact of two flanks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPoint {
    /// Angle φ₁ of the pinion, rad.
    pub pinion_angle: f64,
    /// u, θ, x of pinion and gear, and the gear's angle φ₂.
    pub unknowns: ContactUnknowns,
    /// Derivatives of the unknowns over φ₁.
    pub rates: ContactUnknowns,
    /// The edge that touches; none where both flanks do.
    pub edge: Option<Edge>,
    /// Point in the fixed frame, m.
    pub point: Vector,
    /// Normal of the pinion, out of its metal.
    pub normal: Vector,
    /// Tool surface and its motion at the contact, for pinion and gear, each in the frame of its member.
    pub meetings: [Meeting; 2],
}

/// An edge of a tooth flank.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// 0 for the pinion, 1 for the gear.
    pub member: usize,
    /// Side of its section.
    pub side: Side,
}

/// One of the seven equations: its value, its derivatives over the unknowns and over φ₁.
#[derive(Clone, Copy)]
struct Equation {
    value: f64,
    row: ContactUnknowns,
    by_pinion: f64,
}

/// A member at a contact: its meeting, with r, n, ∂r and ∂n over u, θ, x in the fixed frame.
struct Member {
    meeting: Meeting,
    r: Vector,
    n: Vector,
    dr: [Vector; 3],
    dn: [Vector; 3],
}

impl ContactPoint {
    /// The gear's angle φ₂, rad.
    pub fn gear_angle(&self) -> f64 {
        self.unknowns[6]
    }

    /// dφ₂/dφ₁.
    pub fn ratio(&self) -> f64 {
        self.rates[6]
    }
}

impl FlankPair {
    /// The contact of the flanks at φ₁ by Newton's method from `start`; none where it finds none, as on a line contact.
    pub fn contact(&self, pinion_angle: f64, start: ContactUnknowns) -> Option<ContactPoint> {
        let closing = |members: &[Member; 2]| self.parallel_normals(members);
        self.solve_contact(pinion_angle, start, None, closing)
    }

    /// The contact of an edge of one flank with the other flank at φ₁, by Newton's method from `start`.
    pub fn edge_contact(
        &self,
        pinion_angle: f64,
        start: ContactUnknowns,
        edge: Edge,
    ) -> Option<ContactPoint> {
        let closing = |members: &[Member; 2]| self.edge_on_flank(members, edge);
        self.solve_contact(pinion_angle, start, Some(edge), closing)
    }

    /// A contact without hints: the pinion's middle is turned until `n·v₁₂ = 0`, the gear's flank is found at that place. Of several
    /// angles the one whose normals agree best is the contact.
    pub fn first_contact(&self) -> Option<ContactPoint> {
        let middle = self.flanks[0].middle()?;
        let at_middle = self.flanks[0].envelope.meeting(middle)?;
        let relative = self.turn(0).plus(-self.ratio(), self.turn(1));
        let condition = |angle: f64| {
            let pose = self.pose(0, angle);
            let (r, n) = (pose.apply(at_middle.jet.r), pose.rotate(at_middle.jet.n));
            let turn = self.turn(0);
            let (dr, dn) = (turn.at(r), turn.w.cross(n));
            let f = n.dot(relative.at(r));
            Some([f, dn.dot(relative.at(r)) + n.dot(relative.w.cross(dr))])
        };
        let mut best: Option<(f64, f64, ContactUnknowns)> = None;
        for angle in roots([-PI, PI], condition) {
            let pose = self.pose(0, angle);
            let (r, n) = (pose.apply(at_middle.jet.r), pose.rotate(at_middle.jet.n));
            let in_gear = self.pose(1, 0.0).inverse().apply(r);
            let place = [in_gear.z, f64::hypot(in_gear.x, in_gear.y)];
            let Some(at) = self.flanks[1].find(place) else {
                continue;
            };
            let Some(gear) = self.flanks[1].envelope.meeting(at) else {
                continue;
            };
            let own = gear.jet.r;
            let turn = in_gear.y.atan2(in_gear.x) - own.y.atan2(own.x);
            let gear_angle = turn - 2.0 * PI * (turn / (2.0 * PI)).round();
            let apart = (n + self.pose(1, gear_angle).rotate(gear.jet.n)).norm();
            if best.is_none_or(|(least, ..)| apart < least) {
                let [u, theta, x] = middle;
                let unknowns = [u, theta, x, at[0], at[1], at[2], gear_angle];
                best = Some((apart, angle, unknowns));
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

    /// Newton's method on f₁, f₂, the three coordinates and two closing equations, then the rates from the same elimination.
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
            equations.map(|e| (e.by_pinion, e.row)),
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
            meetings: members.map(|m| m.meeting),
        })
    }

    /// The equations besides f₁ and f₂ at two members, the last two given.
    fn equations(&self, [a, b]: &[Member; 2], [fourth, fifth]: [Equation; 2]) -> [Equation; 5] {
        let (by_pinion, by_gear) = (self.turn(0).at(a.r), -self.turn(1).at(b.r));
        let columns = [
            a.dr[0], a.dr[1], a.dr[2], -b.dr[0], -b.dr[1], -b.dr[2], by_gear,
        ];
        let apart = (a.r - b.r).array();
        let coordinate = |k: usize| Equation {
            value: apart[k],
            row: columns.map(|d| d.array()[k]),
            by_pinion: by_pinion.array()[k],
        };
        [coordinate(0), coordinate(1), coordinate(2), fourth, fifth]
    }

    /// `t·(n₁×n₂) = 0` for two tangents t of the pinion: the sign of neither normal matters. They may differ from step to step: the
    /// derivative of t is multiplied by n₁×n₂, which vanishes at the contact.
    fn parallel_normals(&self, [a, b]: &[Member; 2]) -> [Equation; 2] {
        let apart = a.n.cross(b.n);
        let columns = [
            a.dn[0].cross(b.n),
            a.dn[1].cross(b.n),
            a.dn[2].cross(b.n),
            a.n.cross(b.dn[0]),
            a.n.cross(b.dn[1]),
            a.n.cross(b.dn[2]),
            a.n.cross(self.turn(1).w.cross(b.n)),
        ];
        let by_pinion = self.turn(0).w.cross(a.n).cross(b.n);
        [a.dr[0], a.n.cross(a.dr[0])].map(|t| Equation {
            value: t.dot(apart),
            row: columns.map(|d| t.dot(d)),
            by_pinion: t.dot(by_pinion),
        })
    }

    /// An edge, where `c_z z + c_ρ ρ = c₀` in its section, touches the other flank: `t·n = 0`, `t = n_own × (c_z k + c_ρ e_ρ)`.
    fn edge_on_flank(&self, members: &[Member; 2], edge: Edge) -> [Equation; 2] {
        let k = edge.member;
        let (own, other) = (&members[k], &members[1 - k]);
        let [c_z, c_rho, c_0] = self.flanks[k].section.side(edge.side);
        let turn = self.turn(k);
        let axis = turn.w;
        let off = own.r - self.centre(k);
        let z = off.dot(axis);
        let out = off - axis * z;
        let rho = out.norm();
        let (e_rho, e_phi) = (out * (1.0 / rho), axis.cross(out) * (1.0 / rho));
        let gradient = axis * c_z + e_rho * c_rho;
        let t = own.n.cross(gradient);
        let mut on_edge = [0.0; 7];
        let mut touching = [0.0; 7];
        for i in 0..3 {
            on_edge[3 * k + i] = gradient.dot(own.dr[i]);
            let bent = e_phi * (c_rho * e_phi.dot(own.dr[i]) / rho);
            let dt = own.dn[i].cross(gradient) + own.n.cross(bent);
            touching[3 * k + i] = dt.dot(other.n);
            touching[3 * (1 - k) + i] = t.dot(other.dn[i]);
        }
        // A turn of either member about its axis turns t or the other normal.
        let by = |member: usize| {
            let w = self.turn(member).w;
            match member == k {
                true => w.cross(t).dot(other.n),
                false => t.dot(w.cross(other.n)),
            }
        };
        touching[6] = by(1);
        [
            Equation {
                value: c_z * z + c_rho * rho - c_0,
                row: on_edge,
                by_pinion: 0.0,
            },
            Equation {
                value: t.dot(other.n),
                row: touching,
                by_pinion: by(0),
            },
        ]
    }

    fn scales(&self) -> ContactUnknowns {
        let [a, b] = [0, 1].map(|k| self.flanks[k].envelope.scales_of_three());
        [a[0], a[1], a[2], b[0], b[1], b[2], 1.0]
    }
}

/// Solves `J Δ = g` for the step Δ in units of the scales: `∇f·Δ = f` of each member gives the unknown with its largest scaled derivative,
/// and five equations `(g, row)` remain.
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
    let mut kept = [0, 0, 0, 0, 6];
    let mut given = [0, 0];
    let mut shares = [[0.0; 3]; 2];
    for k in 0..2 {
        let gradient = members[k].meeting.gradient;
        let change: [f64; 3] = std::array::from_fn(|i| gradient[i] * scales[3 * k + i]);
        let larger = |i: usize, j: usize| {
            if change[j].abs() > change[i].abs() {
                j
            } else {
                i
            }
        };
        let most = larger(larger(0, 1), 2);
        let [i, j] = [[1, 2], [0, 2], [0, 1]][most];
        let inverse = 1.0 / change[most];
        shares[k] = [
            change[i] * inverse,
            change[j] * inverse,
            meshing[k] * inverse,
        ];
        given[k] = 3 * k + most;
        (kept[2 * k], kept[2 * k + 1]) = (3 * k + i, 3 * k + j);
        let [a, b, c] = shares[k];
        for (value, row) in &mut equations {
            let by = row[given[k]];
            row[3 * k + i] -= by * a;
            row[3 * k + j] -= by * b;
            *value -= by * c;
        }
    }
    let rows = equations.map(|(_, row)| kept.map(|j| row[j]));
    let found = solve(rows, equations.map(|(value, _)| value))?;
    let mut step = [0.0; 7];
    (0..5).for_each(|m| step[kept[m]] = found[m]);
    for k in 0..2 {
        let [a, b, c] = shares[k];
        step[given[k]] = c - a * found[2 * k] - b * found[2 * k + 1];
    }
    step.iter().all(|x| x.is_finite()).then_some(step)
}
