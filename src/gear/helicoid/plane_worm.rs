//! Plane double-enveloping worms: a plane of the wheel generates the hourglass worm, the worm generates the wheel: two lines of contact.
//!
//! The worm's axis is z; the wheel's passes through (a, 0, 0) along (0, −1, 0) and turns by `φ₂ = i φ₁`. In the wheel ξ points to the
//! worm, η along y; the plane is `ζ = r_b + η tan β`. Fixed: `x = (a − ξ c − ζ s, η, ζ c − ξ s)` with s, c = sin φ₂, cos φ₂. The plane
//! touches along the straight line `ξ cos β (c sin β + i cos β) + η s = sin β cos β (a − r_b s)`. A point x of the worm with its normal n
//! touches the wheel again after a turn Δ of the worm, `tan(Δ/2) = m_x/m_y` with `m = x×n`: on the wheel this is the enveloped part of the
//! tooth, bounded on the plane by the limit of the second kind m_x = 0.

use super::worm_pair::half_turn_tangent;
use crate::gear::kernel::root::sign_change;
use crate::gear::kernel::second_order::Curvature;
use crate::gear::kernel::twist::Twist;
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
    /// Curvature of the wheel less that of the worm across the line of contact: below zero where they touch from outside.
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

/// A point of the worm with what the second contact needs of the first.
#[derive(Debug, Clone, Copy)]
struct WormPoint {
    point: Vector,
    normal: Vector,
    /// Curvature of the worm, `p pᵀ/D`.
    curvature: Curvature,
    /// Sine and cosine of the plane's inclination.
    plane: (f64, f64),
}

/// Δ within this of zero is the limit itself, where the relative curvature of the second contact is 0 and its formula 0/0, rad.
const AT_LIMIT: f64 = 1e-6;
/// Parts of the turn in which the generating turns of a second contact are sought.
const PARTS: u32 = 24;

impl PlaneWorm {
    /// Contact of the plane at a turn of the wheel, η across the tooth; none where the line of contact runs along ξ.
    pub fn first_contact(&self, wheel_turn: f64, eta: f64) -> Option<PlaneWormContact> {
        Some(self.generated(wheel_turn, eta)?.0)
    }

    /// The second contact of the worm's point that the plane makes at a turn of the wheel; it happens at another turn.
    pub fn second_contact(&self, wheel_turn: f64, eta: f64) -> Option<PlaneWormContact> {
        let (_, worm) = self.generated(wheel_turn, eta)?;
        self.touching_again(wheel_turn, &worm)
    }

    /// Second contacts with a place η of the generating line at one turn of the wheel: `φ₂* + i Δ(φ₂*, η) = φ₂`.
    pub fn second_contacts(&self, wheel_turn: f64, eta: f64) -> Vec<PlaneWormContact> {
        let reach = self.ratio * std::f64::consts::PI;
        let off = |turn: f64| Some(self.second_contact(turn, eta)?.wheel_turn - wheel_turn);
        let place = |k: u32| wheel_turn + reach * (2.0 * f64::from(k) / f64::from(PARTS) - 1.0);
        let turns = (0..PARTS).filter_map(|k| sign_change([place(k), place(k + 1)], off));
        turns
            .filter_map(|turn| self.second_contact(turn, eta))
            .collect()
    }

    /// The limit of the second kind on the plane, ξ and η: there both parts of the tooth join.
    pub fn limit(&self, wheel_turn: f64) -> Option<[f64; 2]> {
        let (s, c) = wheel_turn.sin_cos();
        let (sb, cb) = self.plane_angle.sin_cos();
        let line = self.line(wheel_turn);
        let tangent = [-s * sb * cb, c, -self.base_radius * c * sb * cb];
        let determinant = line[0] * tangent[1] - line[1] * tangent[0];
        let place = [
            (line[2] * tangent[1] - line[1] * tangent[2]) / determinant,
            (line[0] * tangent[2] - line[2] * tangent[0]) / determinant,
        ];
        place.iter().all(|x| x.is_finite()).then_some(place)
    }

    /// Place η on the line of contact where the worm has its edge of regression, D = 0, between two places.
    pub fn undercut(&self, wheel_turn: f64, range: [f64; 2]) -> Option<f64> {
        sign_change(range, |eta| {
            Some(self.first_contact(wheel_turn, eta)?.undercut)
        })
    }

    /// Coefficients A, B, C of the line of contact `A ξ + B η = C` on the plane.
    pub fn line(&self, wheel_turn: f64) -> [f64; 3] {
        self.line_at(wheel_turn.sin_cos(), self.plane_angle.sin_cos())
    }

    fn line_at(&self, (s, c): (f64, f64), (sb, cb): (f64, f64)) -> [f64; 3] {
        [
            cb * (c * sb + self.ratio * cb),
            s,
            sb * cb * (self.centre_distance - self.base_radius * s),
        ]
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

    /// A point of the wheel in the wheel's frame (ξ, η, ζ) from space.
    pub(super) fn in_wheel(&self, point: Vector, wheel_turn: f64) -> Vector {
        let (s, c) = wheel_turn.sin_cos();
        let x = self.centre_distance - point.x;
        Vector::new(x * c - point.z * s, point.y, x * s + point.z * c)
    }

    /// Turns of worm and wheel, a radian of the worm.
    fn turns(&self) -> [Twist; 2] {
        let wheel = Twist::turn(-Vector::Y, Vector::X * self.centre_distance);
        [
            Twist::turn(Vector::Z, Vector::ZERO),
            wheel.times(self.ratio),
        ]
    }

    /// The first contact and the worm's point there.
    fn generated(&self, wheel_turn: f64, eta: f64) -> Option<(PlaneWormContact, WormPoint)> {
        let (s, c) = wheel_turn.sin_cos();
        let (sb, cb) = self.plane_angle.sin_cos();
        let [a, b, constant] = self.line_at((s, c), (sb, cb));
        let xi = (constant - b * eta) / a;
        let zeta = self.base_radius + eta * sb / cb;
        let point = Vector::new(
            self.centre_distance - xi * c - zeta * s,
            eta,
            zeta * c - xi * s,
        );
        let normal = Vector::new(-cb * s, -sb, cb * c);
        let tangents = [
            Vector::new(-c, 0.0, -s),
            normal.cross(Vector::new(-c, 0.0, -s)),
        ];
        let plane = Curvature {
            tangents,
            components: [0.0; 3],
        };
        let [worm, wheel] = self.turns();
        let touch = Touch::of(&plane, normal, point, &wheel, &worm)?;
        let contact = PlaneWormContact {
            wheel_turn,
            point,
            in_wheel: Vector::new(xi, eta, zeta),
            height: 0.0,
            second_limit: touch.second_limit,
            undercut: touch.undercut,
            relative_curvature: -touch.induced(),
            lubrication_sine: touch.lubrication_sine,
            sliding: touch.sliding,
        };
        let [p1, p2] = touch.p;
        let curvature = Curvature {
            tangents,
            components: [p1 * p1, p1 * p2, p2 * p2].map(|x| x / touch.undercut),
        };
        let worm_point = WormPoint {
            point,
            normal,
            curvature,
            plane: (sb, cb),
        };
        (xi.is_finite() && touch.undercut != 0.0).then_some((contact, worm_point))
    }

    /// The worm's point turned on until it touches the wheel again.
    fn touching_again(&self, wheel_turn: f64, worm: &WormPoint) -> Option<PlaneWormContact> {
        let half = half_turn_tangent(worm.point, worm.normal);
        let turn = 2.0 * half.atan();
        let share = 1.0 / (1.0 + half * half);
        let (sin, cos) = (2.0 * half * share, (1.0 - half * half) * share);
        let turned = |r: Vector| Vector::new(r.x * cos - r.y * sin, r.x * sin + r.y * cos, r.z);
        let (point, normal) = (turned(worm.point), turned(worm.normal));
        let curvature = Curvature {
            tangents: worm.curvature.tangents.map(turned),
            ..worm.curvature
        };
        let wheel_turn = wheel_turn + self.ratio * turn;
        let [first, second] = self.turns();
        let touch = Touch::of(&curvature, normal, point, &first, &second)?;
        let in_wheel = self.in_wheel(point, wheel_turn);
        let (sb, cb) = worm.plane;
        Some(PlaneWormContact {
            wheel_turn,
            point,
            in_wheel,
            height: (in_wheel.z - self.base_radius) * cb - in_wheel.y * sb,
            second_limit: touch.second_limit,
            undercut: touch.undercut,
            relative_curvature: match turn.abs() > AT_LIMIT {
                true => touch.induced(),
                false => 0.0,
            },
            lubrication_sine: touch.lubrication_sine,
            sliding: touch.sliding,
        })
    }
}

/// Second order of a generator that touches its envelope.
struct Touch {
    p: [f64; 2],
    second_limit: f64,
    undercut: f64,
    lubrication_sine: f64,
    sliding: f64,
}

impl Touch {
    /// A generator of known curvature with its turn and that of the work; none where p vanishes.
    fn of(
        generator: &Curvature,
        normal: Vector,
        point: Vector,
        own: &Twist,
        work: &Twist,
    ) -> Option<Touch> {
        let relative = own.plus(-1.0, work);
        let v = relative.at(point);
        let turned = normal.cross(relative.w);
        let [v1, v2] = generator.in_tangents(v);
        let [t1, t2] = generator.in_tangents(turned);
        let [w11, w12, w22] = generator.components;
        let p = [t1 - w11 * v1 - w12 * v2, t2 - w12 * v1 - w22 * v2];
        let across = p[0] * v1 + p[1] * v2;
        // f = n·(v_own − v_work) at a point carried by the generator.
        let rate = own.w.cross(work.at(point)) - work.w.cross(own.at(point));
        let second_limit = normal.dot(rate);
        let (length, sliding) = (f64::hypot(p[0], p[1]), v.norm());
        let share = across.abs() / (length * sliding);
        (length > 0.0 && share.is_finite()).then_some(Touch {
            p,
            second_limit,
            undercut: across - second_limit,
            lubrication_sine: share,
            sliding,
        })
    }

    /// Induced curvature `p²/D`, that of the envelope less that of the generator.
    fn induced(&self) -> f64 {
        (self.p[0] * self.p[0] + self.p[1] * self.p[1]) / self.undercut
    }
}
