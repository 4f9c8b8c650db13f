//! Plane double-enveloping worms: a plane of the wheel generates the hourglass worm, the worm generates the wheel: two lines of contact.
//!
//! The worm's axis is z; the wheel's passes through (a, 0, 0) along (0, −1, 0) and turns by `φ₂ = i φ₁`. In the wheel ξ points to the
//! worm, η along y; the plane is `ζ = r_b + η tan β`. Fixed: `x = (a − ξ c − ζ s, η, ζ c − ξ s)` with s, c = sin φ₂, cos φ₂. The plane
//! touches along the straight line `ξ cos β (c sin β + i cos β) + η s = sin β cos β (a − r_b s)`. A point x of the worm with its normal n
//! touches the wheel again after a turn Δ of the worm, `tan(Δ/2) = m_x/m_y` with `m = x×n`: on the wheel this is the enveloped part of the
//! tooth, bounded on the plane by the limit of the second kind m_x = 0. Along a generating line n is constant and x linear in η: so are
//! m, Φ and D, and every condition on the line has its root in closed form.

use super::worm_pair::half_turn_tangent;
use crate::gear::kernel::vector::Vector;

/// A plane-generated worm pair; lengths have the unit of the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneWorm {
    /// Centre distance a.
    pub centre_distance: f64,
    /// Ratio i = z₁/z₂.
    pub ratio: f64,
    /// Radius r_b of the base circle that the plane touches in the middle plane.
    pub base_radius: f64,
    /// Inclination β of the plane, rad.
    pub plane_angle: f64,
}

/// Contact of the worm with its wheel; speeds are lengths a radian of the worm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneWormContact {
    /// Turn φ₂ of the wheel, rad.
    pub wheel_turn: f64,
    /// The point in space.
    pub point: Vector,
    /// The point in the wheel: ξ, η, ζ.
    pub in_wheel: Vector,
    /// Height over the generating plane along its normal; 0 on the plane part of the tooth.
    pub height: f64,
    /// Φ; zero on the limit of the second kind.
    pub second_limit: f64,
    /// D; zero where the generated flank has an edge of regression.
    pub undercut: f64,
    /// Curvature of the wheel less that of the worm across the line of contact: below zero where they touch from outside, infinite at an
    /// edge of regression.
    pub relative_curvature: f64,
    /// Sine of the angle of the line of contact to the sliding velocity.
    pub lubrication_sine: f64,
    /// Sliding velocity.
    pub sliding: f64,
}

impl PlaneWormContact {
    /// Angle of the line of contact to the sliding velocity, rad.
    pub fn lubrication_angle(&self) -> f64 {
        self.lubrication_sine.min(1.0).asin()
    }

    /// Distance from the worm's axis.
    pub fn worm_radius(&self) -> f64 {
        f64::hypot(self.point.x, self.point.y)
    }

    /// Distance from the wheel's axis.
    pub fn wheel_radius(&self) -> f64 {
        f64::hypot(self.in_wheel.x, self.in_wheel.z)
    }
}

/// Δ within this of zero is the limit itself, where both contacts are one, rad.
const AT_LIMIT: f64 = 1e-6;

impl PlaneWorm {
    /// The plane at a turn φ₂ of the wheel.
    pub fn generating_line(&self, wheel_turn: f64) -> GeneratingLine {
        GeneratingLine::new(*self, wheel_turn, self.plane_angle.sin_cos())
    }

    /// A point of space from the wheel's frame (ξ, η, ζ).
    pub(super) fn in_space(&self, point: Vector, wheel_turn: f64) -> Vector {
        let (s, c) = wheel_turn.sin_cos();
        Vector::new(
            self.centre_distance - point.x * c - point.z * s,
            point.y,
            point.z * c - point.x * s,
        )
    }

    /// A point of the wheel in the wheel's frame (ξ, η, ζ) from space, at the sine and cosine of its turn.
    pub(super) fn in_wheel(&self, point: Vector, (s, c): (f64, f64)) -> Vector {
        let x = self.centre_distance - point.x;
        Vector::new(x * c - point.z * s, point.y, x * s + point.z * c)
    }

    /// A point that touches, with its normal; the generator has the curvature `q qᵀ/d`, and `sense` is 1 where it is the worm, −1 where the
    /// plane. None where p or the sliding vanishes.
    fn touch(
        &self,
        [point, normal]: [Vector; 2],
        (q, d): (Vector, f64),
        sense: f64,
    ) -> Option<Touch> {
        let (Vector { x, y, z }, n, i) = (point, normal, self.ratio);
        // v = v₁ − v₂ and n×(ω₁ − ω₂) of turns about z and (0, −1, 0).
        let v = Vector::new(i * z - y, x, i * (self.centre_distance - x));
        let turned = Vector::new(n.y - i * n.z, -n.x, i * n.x);
        let p = turned - q * (q.dot(v) / d);
        let across = p.dot(v);
        let second_limit = sense * i * (y * n.z - z * n.y);
        let (square, sliding) = (p.dot(p), v.norm());
        let lubrication_sine = across.abs() / (square.sqrt() * sliding);
        lubrication_sine.is_finite().then_some(Touch {
            p,
            square,
            second_limit,
            undercut: across - second_limit,
            lubrication_sine,
            sliding,
        })
    }
}

/// The generating plane at a turn of the wheel, with what is constant along its line of contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneratingLine {
    pair: PlaneWorm,
    wheel_turn: f64,
    /// Sine and cosine of φ₂ and of β.
    turn: (f64, f64),
    plane: (f64, f64),
    /// Coefficients A, B, C of the line of contact `A ξ + B η = C` on the plane.
    pub coefficients: [f64; 3],
    /// ξ at η = 0, and its change a unit of η; the point in space likewise.
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
        let over = 1.0 / a;
        let xi = [constant * over, -b * over];
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

    /// Contact of the plane at a place η across the tooth; none where the line of contact runs along ξ.
    pub fn first_contact(&self, eta: f64) -> Option<PlaneWormContact> {
        let touch = self.generated(eta)?;
        let (sb, cb) = self.plane;
        Some(PlaneWormContact {
            wheel_turn: self.wheel_turn,
            point: self.place(eta),
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

    /// The second contact of the worm's point that the plane makes at a place η; it happens at another turn of the wheel. None on the limit of
    /// the second kind, where it is the first contact and its curvature 0.
    pub fn touching_again(&self, eta: f64) -> Option<PlaneWormContact> {
        let half = half_turn_tangent(self.place(eta), self.normal);
        let wheel_turn = self.wheel_turn + 2.0 * self.pair.ratio * half.atan();
        let cosine = 1.0 / (1.0 + half * half).sqrt();
        let turn = wheel_turn.sin_cos();
        self.turned(eta, (half * cosine, cosine), (wheel_turn, turn))
    }

    /// The second contact at this turn of the wheel with the worm's line that the plane makes at another, φ₂*.
    ///
    /// The turn `Δ = (φ₂ − φ₂*)/i` between them is known, so that `m_x cos(Δ/2) = m_y sin(Δ/2)` is linear in η.
    pub fn second_contact(&self, generating_turn: f64) -> Option<PlaneWormContact> {
        let made = GeneratingLine::new(self.pair, generating_turn, self.plane);
        let half_turn = (0.5 * (self.wheel_turn - generating_turn) / self.pair.ratio).sin_cos();
        let [constant, slope] = made.point.map(|x| {
            let moment = x.cross(made.normal);
            moment.x * half_turn.1 - moment.y * half_turn.0
        });
        made.turned(-constant / slope, half_turn, (self.wheel_turn, self.turn))
    }

    /// The limit of the second kind on the plane, ξ and η: there both parts of the tooth join.
    pub fn limit(&self) -> Option<[f64; 2]> {
        let [constant, slope] = self.point.map(|x| x.cross(self.normal).x);
        let eta = -constant / slope;
        eta.is_finite()
            .then(|| [self.xi[0] + eta * self.xi[1], eta])
    }

    /// Place η where the worm has its edge of regression, D = 0; none where D is the same along the line.
    pub fn undercut(&self) -> Option<f64> {
        let one = self.pair.base_radius;
        let [at_zero, at_one] = [0.0, one].map(|eta| Some(self.generated(eta)?.undercut));
        let eta = one * at_zero? / (at_zero? - at_one?);
        eta.is_finite().then_some(eta)
    }

    fn place(&self, eta: f64) -> Vector {
        self.point[0] + self.point[1] * eta
    }

    /// The plane and the worm's flank that it leaves.
    fn generated(&self, eta: f64) -> Option<Touch> {
        self.pair
            .touch([self.place(eta), self.normal], (Vector::ZERO, 1.0), -1.0)
    }

    /// The worm's point at a place η after the turn Δ, of which sine and cosine of the half are given, at a turn of the wheel where it touches
    /// again.
    fn turned(
        &self,
        eta: f64,
        (sine, cosine): (f64, f64),
        (wheel_turn, turn): (f64, (f64, f64)),
    ) -> Option<PlaneWormContact> {
        let made = self.generated(eta)?;
        if 2.0 * sine.abs() <= AT_LIMIT {
            return None;
        }
        let (sin, cos) = (2.0 * sine * cosine, cosine * cosine - sine * sine);
        let by_turn = |r: Vector| Vector::new(r.x * cos - r.y * sin, r.x * sin + r.y * cos, r.z);
        let [point, normal, p] = [self.place(eta), self.normal, made.p].map(by_turn);
        let touch = self.pair.touch([point, normal], (p, made.undercut), 1.0)?;
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

/// Second order of a generator that touches its envelope.
struct Touch {
    p: Vector,
    square: f64,
    second_limit: f64,
    undercut: f64,
    lubrication_sine: f64,
    sliding: f64,
}

impl Touch {
    /// Induced curvature `p²/D`, that of the envelope less that of the generator.
    fn induced(&self) -> f64 {
        self.square / self.undercut
    }
}
