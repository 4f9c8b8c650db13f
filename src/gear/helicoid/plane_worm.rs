//! Plane-generated double-enveloping worm pair: a plane of the wheel generates the worm, the worm generates the wheel; two contact lines.
//!
//! The worm axis is z; the wheel axis passes through (a, 0, 0) along (0, −1, 0), with rotation `φ₂ = i φ₁`. In the wheel ξ points to the
//! worm, η along y; the plane is `ζ = r_b + η tan β`. Fixed: `x = (a − ξ c − ζ s, η, ζ c − ξ s)` with s, c = sin φ₂, cos φ₂. The plane
//! has the contact line `ξ cos β (c sin β + i cos β) + η s = sin β cos β (a − r_b s)`. A worm point x with normal n has
//! a second contact after a worm rotation Δ, `tan(Δ/2) = m_x/m_y` with `m = x×n`, on the enveloped zone of the wheel
//! tooth, bounded on the plane by the limit of the second kind m_x = 0. Along a contact line n is constant and x linear in η: so are
//! m, Φ and D, and every condition on the line has a closed-form root.

use super::worm_pair::half_turn_tangent;
use crate::gear::kernel::vector::Vector;

/// Geometry of a plane-generated worm pair; lengths have the unit of the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneWorm {
    /// Centre distance a.
    pub centre_distance: f64,
    /// Ratio i = z₁/z₂.
    pub ratio: f64,
    /// Radius r_b of the base circle tangent to the plane in the middle plane.
    pub base_radius: f64,
    /// Inclination β of the plane, rad.
    pub plane_angle: f64,
}

/// Contact point of worm and wheel; velocities are lengths per radian of the worm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneWormContact {
    /// Rotation φ₂ of the wheel, rad.
    pub wheel_turn: f64,
    /// Contact point in the fixed frame.
    pub point: Vector,
    /// Contact point in the wheel frame: ξ, η, ζ.
    pub in_wheel: Vector,
    /// Height over the generating plane along its normal; 0 on the plane zone of the tooth.
    pub height: f64,
    /// Limit function Φ of the second kind; zero at the limit.
    pub second_limit: f64,
    /// Undercut function D; zero at an edge of regression of the generated flank.
    pub undercut: f64,
    /// Relative curvature, wheel minus worm, across the contact line: negative for contact from outside, infinite at an
    /// edge of regression.
    pub relative_curvature: f64,
    /// Sine of the angle between contact line and sliding velocity.
    pub lubrication_sine: f64,
    /// Sliding velocity per radian of the worm.
    pub sliding: f64,
}

impl PlaneWormContact {
    /// Angle between contact line and sliding velocity, rad.
    pub fn lubrication_angle(&self) -> f64 {
        self.lubrication_sine.min(1.0).asin()
    }

    /// Distance from the worm axis.
    pub fn worm_radius(&self) -> f64 {
        f64::hypot(self.point.x, self.point.y)
    }

    /// Distance from the wheel axis.
    pub fn wheel_radius(&self) -> f64 {
        f64::hypot(self.in_wheel.x, self.in_wheel.z)
    }
}

/// Tolerance of the rotation Δ at the limit, where both contacts coincide, rad.
const AT_LIMIT: f64 = 1e-6;

impl PlaneWorm {
    /// Generating contact line at a wheel rotation φ₂, rad.
    pub fn generating_line(&self, wheel_turn: f64) -> GeneratingLine {
        GeneratingLine::new(*self, wheel_turn, self.plane_angle.sin_cos())
    }

    /// Transformation from the wheel frame (ξ, η, ζ) to the fixed frame.
    pub(super) fn in_space(&self, point: Vector, wheel_turn: f64) -> Vector {
        let (s, c) = wheel_turn.sin_cos();
        Vector::new(
            self.centre_distance - point.x * c - point.z * s,
            point.y,
            point.z * c - point.x * s,
        )
    }

    /// Transformation from the fixed frame to the wheel frame (ξ, η, ζ), with sine and cosine of the wheel rotation.
    pub(super) fn in_wheel(&self, point: Vector, (s, c): (f64, f64)) -> Vector {
        let x = self.centre_distance - point.x;
        Vector::new(x * c - point.z * s, point.y, x * s + point.z * c)
    }

    /// Second-order contact elements at a point with its normal; the generator has the curvature `q qᵀ/d`, `sense` is 1 for the worm, −1
    /// for the plane. `None` for vanishing p or sliding.
    fn touch(
        &self,
        [point, normal]: [Vector; 2],
        (q, d): (Vector, f64),
        sense: f64,
    ) -> Option<Touch> {
        let (Vector { x, y, z }, n, i) = (point, normal, self.ratio);
        // v = v₁ − v₂ and n×(ω₁ − ω₂) for rotations about z and (0, −1, 0).
        let v = Vector::new(i * z - y, x, i * (self.centre_distance - x));
        let n_omega = Vector::new(n.y - i * n.z, -n.x, i * n.x);
        let p = n_omega - q * (q.dot(v) / d);
        let p_v = p.dot(v);
        let second_limit = sense * i * (y * n.z - z * n.y);
        let (square, sliding) = (p.dot(p), v.norm());
        let lubrication_sine = p_v.abs() / (square.sqrt() * sliding);
        lubrication_sine.is_finite().then_some(Touch {
            p,
            square,
            second_limit,
            undercut: p_v - second_limit,
            lubrication_sine,
            sliding,
        })
    }
}

/// Contact line of the generating plane at a wheel rotation, with the quantities constant along the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneratingLine {
    pair: PlaneWorm,
    wheel_turn: f64,
    /// Sine and cosine of φ₂ (`turn`) and of β (`plane`).
    turn: (f64, f64),
    plane: (f64, f64),
    /// Coefficients A, B, C of the contact line `A ξ + B η = C` on the plane.
    pub coefficients: [f64; 3],
    /// ξ at η = 0 and slope dξ/dη; likewise for the point in the fixed frame.
    xi: [f64; 2],
    point: [Vector; 2],
    normal: Vector,
}

impl GeneratingLine {
    fn new(pair: PlaneWorm, wheel_turn: f64, plane: (f64, f64)) -> GeneratingLine {
        let (turn, (sb, cb)) = (wheel_turn.sin_cos(), plane);
        let (s, c) = turn;
        let [a, b, constant] = [
            cb * (c * sb + pair.ratio * cb),
            s,
            sb * cb * (pair.centre_distance - pair.base_radius * s),
        ];
        let inverse = 1.0 / a;
        let xi = [constant * inverse, -b * inverse];
        let (r, tan) = (pair.base_radius, sb / cb);
        GeneratingLine {
            pair,
            wheel_turn,
            turn,
            plane,
            coefficients: [a, b, constant],
            xi,
            point: [
                Vector::new(
                    pair.centre_distance - xi[0] * c - r * s,
                    0.0,
                    r * c - xi[0] * s,
                ),
                Vector::new(-xi[1] * c - tan * s, 1.0, tan * c - xi[1] * s),
            ],
            normal: Vector::new(-cb * s, -sb, cb * c),
        }
    }

    /// First contact, of the plane at the position η across the tooth; `None` for a contact line along ξ.
    pub fn first_contact(&self, eta: f64) -> Option<PlaneWormContact> {
        let touch = self.generated(eta)?;
        let (sb, cb) = self.plane;
        Some(PlaneWormContact {
            wheel_turn: self.wheel_turn,
            point: self.point_at(eta),
            in_wheel: Vector::new(
                self.xi[0] + eta * self.xi[1],
                eta,
                self.pair.base_radius + eta * sb / cb,
            ),
            height: 0.0,
            second_limit: touch.second_limit,
            undercut: touch.undercut,
            relative_curvature: -touch.induced(),
            lubrication_sine: touch.lubrication_sine,
            sliding: touch.sliding,
        })
    }

    /// Second contact of the worm point generated at the position η, at another wheel rotation. `None` at the limit of
    /// the second kind, where both contacts coincide with zero relative curvature.
    pub fn second_contact_at(&self, eta: f64) -> Option<PlaneWormContact> {
        let half = half_turn_tangent(self.point_at(eta), self.normal);
        let wheel_turn = self.wheel_turn + 2.0 * self.pair.ratio * half.atan();
        let cosine = 1.0 / (1.0 + half * half).sqrt();
        let turn = wheel_turn.sin_cos();
        self.rotated(eta, (half * cosine, cosine), (wheel_turn, turn))
    }

    /// Second contact at this wheel rotation with the worm line generated at another rotation φ₂*.
    ///
    /// The worm rotation `Δ = (φ₂ − φ₂*)/i` is known, so `m_x cos(Δ/2) = m_y sin(Δ/2)` is linear in η.
    pub fn second_contact(&self, generating_turn: f64) -> Option<PlaneWormContact> {
        let line = GeneratingLine::new(self.pair, generating_turn, self.plane);
        let half_turn = (0.5 * (self.wheel_turn - generating_turn) / self.pair.ratio).sin_cos();
        let [constant, slope] = line.point.map(|x| {
            let moment = x.cross(line.normal);
            moment.x * half_turn.1 - moment.y * half_turn.0
        });
        line.rotated(-constant / slope, half_turn, (self.wheel_turn, self.turn))
    }

    /// Limit of the second kind on the plane, ξ and η: junction of both zones of the tooth.
    pub fn limit(&self) -> Option<[f64; 2]> {
        let [constant, slope] = self.point.map(|x| x.cross(self.normal).x);
        let eta = -constant / slope;
        eta.is_finite()
            .then(|| [self.xi[0] + eta * self.xi[1], eta])
    }

    /// Position η of the edge of regression of the worm, D = 0; `None` for constant D along the line.
    pub fn undercut(&self) -> Option<f64> {
        let unit = self.pair.base_radius;
        let [at_zero, at_one] = [0.0, unit].map(|eta| Some(self.generated(eta)?.undercut));
        let eta = unit * at_zero? / (at_zero? - at_one?);
        eta.is_finite().then_some(eta)
    }

    fn point_at(&self, eta: f64) -> Vector {
        self.point[0] + self.point[1] * eta
    }

    /// Contact elements of the plane and the generated worm flank.
    fn generated(&self, eta: f64) -> Option<Touch> {
        self.pair
            .touch([self.point_at(eta), self.normal], (Vector::ZERO, 1.0), -1.0)
    }

    /// Second contact of the worm point at the position η after the worm rotation Δ, given by sine and cosine of Δ/2, at the wheel rotation
    /// of contact.
    fn rotated(
        &self,
        eta: f64,
        (sine, cosine): (f64, f64),
        (wheel_turn, turn): (f64, (f64, f64)),
    ) -> Option<PlaneWormContact> {
        let first = self.generated(eta)?;
        if 2.0 * sine.abs() <= AT_LIMIT {
            return None;
        }
        let (sin, cos) = (2.0 * sine * cosine, cosine * cosine - sine * sine);
        let rotate = |r: Vector| Vector::new(r.x * cos - r.y * sin, r.x * sin + r.y * cos, r.z);
        let [point, normal, p] = [self.point_at(eta), self.normal, first.p].map(rotate);
        let touch = self.pair.touch([point, normal], (p, first.undercut), 1.0)?;
        let in_wheel = self.pair.in_wheel(point, turn);
        let (sb, cb) = self.plane;
        Some(PlaneWormContact {
            wheel_turn,
            point,
            in_wheel,
            height: (in_wheel.z - self.pair.base_radius) * cb - in_wheel.y * sb,
            second_limit: touch.second_limit,
            undercut: touch.undercut,
            relative_curvature: touch.induced(),
            lubrication_sine: touch.lubrication_sine,
            sliding: touch.sliding,
        })
    }
}

/// Second-order contact elements of a generator and its envelope.
struct Touch {
    p: Vector,
    square: f64,
    second_limit: f64,
    undercut: f64,
    lubrication_sine: f64,
    sliding: f64,
}

impl Touch {
    /// Induced normal curvature `p²/D`, envelope minus generator.
    fn induced(&self) -> f64 {
        self.square / self.undercut
    }
}
