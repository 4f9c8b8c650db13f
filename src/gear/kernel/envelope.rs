//! Envelope of a moving surface on the work, `f = n·v = 0`; itself a surface that a further motion can carry.

use super::jet::{Jet, Surface};
use super::meeting::MeshingState;
use super::motion::Motion;
use super::newton::newton;
use super::pose::{Direction, Point};
use super::root::{root, roots};
use super::second_order::SecondOrder;
use super::twist::Twist;
use super::vector::Vector;

/// Envelope of a surface under a motion, parametrised by `[x, θ]`; for a fixed motion the surface itself, parametrised by `[u, θ]`.
#[derive(Debug, Clone)]
pub struct Envelope<S: Surface, To> {
    /// The moving surface.
    pub surface: S,
    /// Motion of the surface in the frame of the work.
    pub motion: Motion<To, S::Frame>,
    /// First and last motion parameter x.
    pub range: [f64; 2],
}

/// Point of a flank with its generating parameters and second-order geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankPoint<Frame> {
    /// Parameters u, θ of the tool and x of the motion.
    pub at: [f64; 3],
    /// Position in the frame of the work.
    pub point: Point<Frame>,
    /// Unit normal, out of the metal of the work.
    pub normal: Direction<Frame>,
    /// Curvatures and limit functions.
    pub second_order: SecondOrder,
}

impl<S: Surface, To> Envelope<S, To> {
    /// Meshing function and derivatives of the surface point `[u, θ]` under the motion at x; `None` where the surface has no jet.
    #[inline]
    pub fn meeting(&self, [u, theta, x]: [f64; 3]) -> Option<MeshingState> {
        let jet = self.surface.jet([u, theta])?;
        let state = self.motion.at(x);
        Some(match self.motion.is_fixed() {
            true => MeshingState::at_rest(&jet, &state, x),
            false => MeshingState::new(&jet, &state),
        })
    }

    /// Parameter u of the contact at given x and θ: the root of f in the range of u, of several the one nearest the middle of the range.
    ///
    /// `None` without a contact, and for a fixed motion. Where a surface has two contacts, restrict its range to one of them.
    pub fn surface_parameter(&self, [x, theta]: [f64; 2]) -> Option<f64> {
        if self.motion.is_fixed() {
            return None;
        }
        let state = self.motion.at(x);
        root(self.surface.range(), |u| {
            let meeting = MeshingState::new(&self.surface.jet([u, theta])?, &state);
            Some([meeting.f, meeting.gradient[0]])
        })
    }

    /// Motion parameters x of all contacts of the surface point `[u, θ]` in the range of the motion, in ascending order.
    pub fn motion_parameters(&self, [u, theta]: [f64; 2]) -> Vec<f64> {
        let Some(jet) = self.surface.jet([u, theta]) else {
            return Vec::new();
        };
        roots(self.range, |x| {
            let meeting = MeshingState::new(&jet, &self.motion.at(x));
            Some([meeting.f, meeting.gradient[2]])
        })
    }

    /// Flank point at parameters `[u, θ, x]` with f = 0; `None` where the surface has no curvature there.
    pub fn point(&self, at: [f64; 3]) -> Option<FlankPoint<To>> {
        let meeting = self.meeting(at)?;
        Some(FlankPoint {
            at,
            point: Point::new(meeting.jet.r),
            normal: Direction::new(meeting.jet.n),
            second_order: SecondOrder::of(&meeting)?,
        })
    }

    /// Parameters `[x, θ]` (`[u, θ]` for a fixed motion) of the envelope as a surface at generating parameters `[u, θ, x]`.
    pub fn parameters(&self, [u, theta, x]: [f64; 3]) -> [f64; 2] {
        [if self.motion.is_fixed() { u } else { x }, theta]
    }

    /// Flank point at x and θ, with u from f = 0.
    pub fn flank(&self, [x, theta]: [f64; 2]) -> Option<FlankPoint<To>> {
        self.point([self.surface_parameter([x, theta])?, theta, x])
    }

    /// Parameters `[u, θ, x]` of the flank point on the circle `[z, radius]` about the z axis of the work, by Newton's method from `start`.
    /// `None` where the iteration does not converge.
    #[inline]
    pub fn intersect_circle(&self, [z, radius]: [f64; 2], start: [f64; 3]) -> Option<[f64; 3]> {
        newton(start, self.parameter_scales(), |at| {
            let meeting = self.meeting(at)?;
            let Jet { r, dr, .. } = meeting.jet;
            let rho = f64::hypot(r.x, r.y);
            let columns = [dr[0], dr[1], meeting.velocity];
            let radial = |d: Vector| (r.x * d.x + r.y * d.y) / rho;
            Some((
                [meeting.f, r.z - z, rho - radius],
                [meeting.gradient, columns.map(|d| d.z), columns.map(radial)],
            ))
        })
    }

    /// Parameters `[u, θ, x]` of the flank point at u on the line `c_z z + c_ρ ρ = c₀` of the axial section, by Newton's method from
    /// `start`, `[θ, x]`. The system is regular at a limit of the first kind. `None` where the iteration does not converge.
    pub fn intersect_section_line(
        &self,
        u: f64,
        [c_z, c_rho, c_0]: [f64; 3],
        start: [f64; 2],
    ) -> Option<[f64; 3]> {
        let [_, theta, x] = self.parameter_scales();
        let [theta, x] = newton(start, [theta, x], |[theta, x]| {
            let meeting = self.meeting([u, theta, x])?;
            let Jet { r, dr, .. } = meeting.jet;
            let rho = f64::hypot(r.x, r.y);
            let slope = |d: Vector| c_z * d.z + c_rho * (r.x * d.x + r.y * d.y) / rho;
            let [_, f_theta, f_x] = meeting.gradient;
            Some((
                [meeting.f, c_z * r.z + c_rho * rho - c_0],
                [[f_theta, f_x], [slope(dr[1]), slope(meeting.velocity)]],
            ))
        })?;
        Some([u, theta, x])
    }

    /// Parameters `[u, θ, x]` and distance d of the flank along the ray `point + d direction`, by Newton's method from `start`: the exact
    /// deviation of a modified flank from a node of the ideal one. `None` where the iteration does not converge.
    pub fn intersect_ray(
        &self,
        point: Point<To>,
        direction: Direction<To>,
        start: [f64; 3],
    ) -> Option<([f64; 3], f64)> {
        let (origin, axis) = (point.coordinates, direction.components);
        let [u, theta, x] = start;
        let [su, st, sx] = self.parameter_scales();
        let solution = newton([u, theta, x, 0.0], [su, st, sx, su], |[u, theta, x, d]| {
            let meeting = self.meeting([u, theta, x])?;
            let Jet { r, dr, .. } = meeting.jet;
            let [f_u, f_theta, f_x] = meeting.gradient;
            let offset = (r - origin - axis * d).array();
            let columns = [dr[0], dr[1], meeting.velocity, -axis].map(Vector::array);
            let row = |i: usize| columns.map(|c| c[i]);
            Some((
                [meeting.f, offset[0], offset[1], offset[2]],
                [[f_u, f_theta, f_x, 0.0], row(0), row(1), row(2)],
            ))
        });
        solution.map(|[u, theta, x, d]| ([u, theta, x], d))
    }

    /// Surface point `[u, θ]` of a two-parameter envelope, `n·v₁ = n·v₂ = 0`: this motion at x, and a second one given by its twist in
    /// coordinates of the work, such as roll and feed of a hob. `None` where Newton's method from `start` does not converge.
    pub fn two_motion_point(&self, x: f64, second: &Twist, start: [f64; 2]) -> Option<[f64; 2]> {
        newton(start, self.surface.scales(), |[u, theta]| {
            let meeting = self.meeting([u, theta, x])?;
            let [f_u, f_theta, _] = meeting.gradient;
            let (g, row) = meeting.under(second);
            Some(([meeting.f, g], [[f_u, f_theta], row]))
        })
    }

    /// Step scales of u, θ and x for Newton's method.
    pub fn parameter_scales(&self) -> [f64; 3] {
        let [u, theta] = self.surface.scales();
        let x = match self.motion.is_fixed() {
            true => 1.0,
            false => (self.range[1] - self.range[0]).abs(),
        };
        [u, theta, x]
    }

    /// Motion parameters of the contacts of the surface point `[u, θ]` other than the known `first`: the roots of `f(x)/(x − first)`.
    ///
    /// A flank moved by the inverse of its generating motion touches the generator at the generating parameter; any other contact is a
    /// second contact.
    pub fn second_contacts(&self, [u, theta]: [f64; 2], first: f64) -> Vec<f64> {
        let Some(jet) = self.surface.jet([u, theta]) else {
            return Vec::new();
        };
        roots(self.range, |x| {
            let meeting = MeshingState::new(&jet, &self.motion.at(x));
            let (slope, distance) = (meeting.gradient[2], x - first);
            if distance == 0.0 {
                return Some([slope, 0.0]);
            }
            let quotient = meeting.f / distance;
            Some([quotient, (slope - quotient) / distance])
        })
    }
}

impl<S: Surface, To> Surface for Envelope<S, To> {
    type Frame = To;

    fn jet(&self, [first, theta]: [f64; 2]) -> Option<Jet> {
        if self.motion.is_fixed() {
            return Some(self.meeting([first, theta, 0.0])?.jet);
        }
        let u = self.surface_parameter([first, theta])?;
        self.meeting([u, theta, first])?.envelope_jet()
    }

    fn range(&self) -> [f64; 2] {
        match self.motion.is_fixed() {
            true => self.surface.range(),
            false => self.range,
        }
    }

    fn scales(&self) -> [f64; 2] {
        let [u, theta, x] = self.parameter_scales();
        [if self.motion.is_fixed() { u } else { x }, theta]
    }
}
