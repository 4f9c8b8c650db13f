//! Envelopes: the flank a moving surface leaves on the work, itself a surface that the next motion carries.

use super::jet::{Jet, Surface};
use super::meeting::Meeting;
use super::motion::Motion;
use super::newton::newton;
use super::pose::{Direction, Point};
use super::root::{root, roots};
use super::second_order::SecondOrder;
use super::twist::Twist;
use super::vector::Vector;

/// The envelope of a surface under a motion, as a surface over `[x, θ]`; of one that does not move, over its own `[u, θ]`.
#[derive(Debug, Clone)]
pub struct Envelope<S: Surface, To> {
    /// The moving surface.
    pub surface: S,
    /// Motion of the surface in the frame of the work.
    pub motion: Motion<To, S::Frame>,
    /// First and last x.
    pub range: [f64; 2],
}

/// A point of a flank: where it was made and its second order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankPoint<Frame> {
    /// Parameters u, θ of the tool and x of the motion.
    pub at: [f64; 3],
    /// Point.
    pub point: Point<Frame>,
    /// Unit normal, out of the metal of the work.
    pub normal: Direction<Frame>,
    /// Curvatures and limits.
    pub second_order: SecondOrder,
}

impl<S: Surface, To> Envelope<S, To> {
    /// The surface at `[u, θ]` met by the motion at x; none where the surface has no jet.
    #[inline]
    pub fn meeting(&self, [u, theta, x]: [f64; 3]) -> Option<Meeting> {
        let jet = self.surface.jet([u, theta])?;
        let state = self.motion.at(x);
        Some(match self.motion.is_fixed() {
            true => Meeting::at_rest(&jet, &state, x),
            false => Meeting::new(&jet, &state),
        })
    }

    /// u of the contact at given x and θ: the root of f in the range of u, of several the one nearest its middle. None where the surface
    /// does not touch there, and for a surface that does not move, every point of which is its flank. Where a surface touches twice, give
    /// it the part of its range that is meant.
    pub fn surface_parameter(&self, [x, theta]: [f64; 2]) -> Option<f64> {
        if self.motion.is_fixed() {
            return None;
        }
        let state = self.motion.at(x);
        root(self.surface.range(), |u| {
            let meeting = Meeting::new(&self.surface.jet([u, theta])?, &state);
            Some([meeting.f, meeting.gradient[0]])
        })
    }

    /// x of every contact of the surface's point at `[u, θ]` in the range of the motion, rising.
    pub fn motion_parameters(&self, [u, theta]: [f64; 2]) -> Vec<f64> {
        let Some(jet) = self.surface.jet([u, theta]) else {
            return Vec::new();
        };
        roots(self.range, |x| {
            let meeting = Meeting::new(&jet, &self.motion.at(x));
            Some([meeting.f, meeting.gradient[2]])
        })
    }

    /// The flank's point at parameters with f = 0; none where the surface has no curvature there.
    pub fn point(&self, at: [f64; 3]) -> Option<FlankPoint<To>> {
        let meeting = self.meeting(at)?;
        Some(FlankPoint {
            at,
            point: Point::new(meeting.jet.r),
            normal: Direction::new(meeting.jet.n),
            second_order: SecondOrder::of(&meeting)?,
        })
    }

    /// Parameters of a place `[u, θ, x]` on this envelope as a surface.
    pub fn own(&self, [u, theta, x]: [f64; 3]) -> [f64; 2] {
        [if self.motion.is_fixed() { u } else { x }, theta]
    }

    /// The flank's point at x and θ, with u from f = 0.
    pub fn flank(&self, [x, theta]: [f64; 2]) -> Option<FlankPoint<To>> {
        self.point([self.surface_parameter([x, theta])?, theta, x])
    }

    /// The flank's point on the circle `[z, radius]` about the work's z axis nearest `start`, `[u, θ, x]`: how a point of a blank is
    /// found. None where Newton's method finds none.
    #[inline]
    pub fn on_circle(&self, [z, radius]: [f64; 2], start: [f64; 3]) -> Option<[f64; 3]> {
        newton(start, self.scales_of_three(), |at| {
            let meeting = self.meeting(at)?;
            let Jet { r, dr, .. } = meeting.jet;
            let here = f64::hypot(r.x, r.y);
            let columns = [dr[0], dr[1], meeting.velocity];
            let outward = |d: Vector| (r.x * d.x + r.y * d.y) / here;
            Some((
                [meeting.f, r.z - z, here - radius],
                [meeting.gradient, columns.map(|d| d.z), columns.map(outward)],
            ))
        })
    }

    /// The flank's point at u on the line `c_z z + c_ρ ρ = c₀` of axial sections, `[c_z, c_ρ, c₀]`, nearest `start`, `[θ, x]`; regular where
    /// the flank turns back on the line, at its limit of the first kind. None where Newton's method finds none.
    pub fn on_section_line(
        &self,
        u: f64,
        [c_z, c_rho, c_0]: [f64; 3],
        start: [f64; 2],
    ) -> Option<[f64; 3]> {
        let [_, theta, x] = self.scales_of_three();
        let [theta, x] = newton(start, [theta, x], |[theta, x]| {
            let meeting = self.meeting([u, theta, x])?;
            let Jet { r, dr, .. } = meeting.jet;
            let rho = f64::hypot(r.x, r.y);
            let along = |d: Vector| c_z * d.z + c_rho * (r.x * d.x + r.y * d.y) / rho;
            let [_, f_theta, f_x] = meeting.gradient;
            Some((
                [meeting.f, c_z * r.z + c_rho * rho - c_0],
                [[f_theta, f_x], [along(dr[1]), along(meeting.velocity)]],
            ))
        })?;
        Some([u, theta, x])
    }

    /// The flank's distance d along the ray `point + d direction`, with its place `[u, θ, x]`, by Newton's method from `start`: the exact
    /// deviation of a changed flank from a node of the ideal one.
    pub fn on_ray(
        &self,
        point: Point<To>,
        direction: Direction<To>,
        start: [f64; 3],
    ) -> Option<([f64; 3], f64)> {
        let (from, along) = (point.coordinates, direction.components);
        let [u, theta, x] = start;
        let [su, st, sx] = self.scales_of_three();
        let found = newton([u, theta, x, 0.0], [su, st, sx, su], |[u, theta, x, d]| {
            let meeting = self.meeting([u, theta, x])?;
            let Jet { r, dr, .. } = meeting.jet;
            let [f_u, f_theta, f_x] = meeting.gradient;
            let off = (r - from - along * d).array();
            let columns = [dr[0], dr[1], meeting.velocity, -along].map(Vector::array);
            let row = |i: usize| columns.map(|c| c[i]);
            Some((
                [meeting.f, off[0], off[1], off[2]],
                [[f_u, f_theta, f_x, 0.0], row(0), row(1), row(2)],
            ))
        });
        found.map(|[u, theta, x, d]| ([u, theta, x], d))
    }

    /// The point `[u, θ]` of the surface that touches under two motions at once, this one at x and a second of the given twist in
    /// coordinates of the work, such as roll and feed of a hob: `n·v₁ = n·v₂ = 0`. None where Newton's method from `start` finds none.
    pub fn under_two_motions(&self, x: f64, second: &Twist, start: [f64; 2]) -> Option<[f64; 2]> {
        newton(start, self.surface.scales(), |[u, theta]| {
            let meeting = self.meeting([u, theta, x])?;
            let [f_u, f_theta, _] = meeting.gradient;
            let (g, row) = meeting.under(second);
            Some(([meeting.f, g], [[f_u, f_theta], row]))
        })
    }

    /// Sizes of u, θ and x.
    pub fn scales_of_three(&self) -> [f64; 3] {
        let [u, theta] = self.surface.scales();
        let x = match self.motion.is_fixed() {
            true => 1.0,
            false => (self.range[1] - self.range[0]).abs(),
        };
        [u, theta, x]
    }

    /// Motion parameters at which the surface's point `[u, θ]` touches besides the known `first`: the roots of `f(x)/(x − first)`.
    ///
    /// A flank carried back by the motion that made it touches its generator at the parameter of its making, and where it does so again
    /// is the second contact.
    pub fn second_contacts(&self, [u, theta]: [f64; 2], first: f64) -> Vec<f64> {
        let Some(jet) = self.surface.jet([u, theta]) else {
            return Vec::new();
        };
        roots(self.range, |x| {
            let meeting = Meeting::new(&jet, &self.motion.at(x));
            let (slope, apart) = (meeting.gradient[2], x - first);
            if apart == 0.0 {
                return Some([slope, 0.0]);
            }
            let quotient = meeting.f / apart;
            Some([quotient, (slope - quotient) / apart])
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
        let [u, theta, x] = self.scales_of_three();
        [if self.motion.is_fixed() { u } else { x }, theta]
    }
}
