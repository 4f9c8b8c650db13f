//! A surface met by a motion: `f = n·v`, its gradient, and the jet of what it envelopes.

use super::jet::Jet;
use super::motion::MotionState;
use super::twist::Twist;
use super::vector::Vector;

/// A jet carried by a motion, with the function f of meshing and its gradient over u, θ and x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshingState {
    /// The carried jet, in coordinates of the work.
    pub jet: Jet,
    /// Velocity v of its point over x.
    pub velocity: Vector,
    /// Angular velocity w.
    pub angular: Vector,
    /// `f = n·v`: zero where the surface touches its envelope.
    pub f: f64,
    /// `[∂f/∂u, ∂f/∂θ, ∂f/∂x]`; the last is Φ of the second limit.
    pub gradient: [f64; 3],
}

impl MeshingState {
    /// A jet of the moving body at a state of its motion.
    ///
    /// `f_u = n_u·v + n·(w×r_u)`, f_θ alike, `f_x = (w×n)·v + n·a`.
    #[inline]
    pub fn new(jet: &Jet, state: &MotionState) -> MeshingState {
        let jet = jet.moved(&state.pose);
        let velocity = state.velocity.at(jet.r);
        let angular = state.velocity.w;
        let (f, [f_u, f_theta]) = condition(&jet, &state.velocity);
        let f_x = angular.cross(jet.n).dot(velocity) + jet.n.dot(state.acceleration(jet.r));
        MeshingState {
            jet,
            velocity,
            angular,
            f,
            gradient: [f_u, f_theta, f_x],
        }
    }

    /// A surface that does not move: its envelope is itself, `f = x`.
    #[inline]
    pub fn at_rest(jet: &Jet, state: &MotionState, x: f64) -> MeshingState {
        MeshingState {
            jet: jet.moved(&state.pose),
            velocity: Vector::ZERO,
            angular: Vector::ZERO,
            f: x,
            gradient: [0.0, 0.0, 1.0],
        }
    }

    /// `n·v₂` of a second motion, such as the feed of a hob, given by its twist in coordinates of the work; with derivatives over u, θ.
    pub fn under(&self, second: &Twist) -> (f64, [f64; 2]) {
        condition(&self.jet, second)
    }

    /// The jet of the envelope over `[x, θ]`, u eliminated by `du = −(f_θ dθ + f_x dx)/f_u`; none where f does not change with u.
    ///
    /// It holds where f = 0.
    pub fn envelope_jet(&self) -> Option<Jet> {
        let [f_u, f_theta, f_x] = self.gradient;
        let (u_x, u_theta) = (-f_x / f_u, -f_theta / f_u);
        if !u_x.is_finite() || !u_theta.is_finite() {
            return None;
        }
        let Jet { r, n, dr, dn } = self.jet;
        Some(Jet {
            r,
            n,
            dr: [dr[0] * u_x + self.velocity, dr[1] + dr[0] * u_theta],
            dn: [dn[0] * u_x + self.angular.cross(n), dn[1] + dn[0] * u_theta],
        })
    }
}

/// `n·v(r)` with its derivatives over u and θ.
#[inline]
fn condition(jet: &Jet, twist: &Twist) -> (f64, [f64; 2]) {
    let v = twist.at(jet.r);
    let slope = |i: usize| jet.dn[i].dot(v) + jet.n.dot(twist.w.cross(jet.dr[i]));
    (jet.n.dot(v), [slope(0), slope(1)])
}
