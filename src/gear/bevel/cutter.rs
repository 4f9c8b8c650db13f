//! Face-mill cutters: the surfaces of revolution of the blade, straight or an arc, of its Toprem and of its edge radius.
//!
//! Along the arc of a blade the sine of the blade angle grows with the height h above the tip plane, `sin a = sin α + k (h − h_p)`.
//! Litvin and Fuentes, Gear Geometry and Applied Theory, 2nd ed. 2004, section 21.2 (straight blades and their edge).

use std::f64::consts::FRAC_PI_2;

use super::frames::CutterFrame;
use crate::gear::kernel::tool::{Arc, Curve, Tool};
use crate::gear::kernel::twist::Twist;
use crate::gear::kernel::vector::Vector;

/// The surface of a part of a blade.
pub type BladeSurface = Tool<Arc, CutterFrame>;

/// Steepest sine of a blade angle: an arc that would turn further above the tooth ends there.
const STEEPEST: f64 = 0.99;

/// Side of a blade that cuts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blade {
    /// Inside blade: its radius falls from the tip; it cuts convex flanks.
    Inside,
    /// Outside blade: its radius grows from the tip; it cuts concave flanks.
    Outside,
}

/// A face-mill cutter as one flank meets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutter {
    /// Blade that cuts the flank.
    pub blade: Blade,
    /// Point radius r_p, where the blade's line meets the tip plane, m; of a curved blade its tangent at the profile height.
    pub point_radius: f64,
    /// Blade angle α > 0, of a curved blade at the profile height, rad.
    pub blade_angle: f64,
    /// Edge radius, m; 0 for a sharp edge.
    pub edge_radius: f64,
    /// Curvature k of the blade's profile, 1/m: positive of a hollow blade, which leaves profile crowning; 0 of a straight one.
    pub profile_curvature: f64,
    /// Profile height h_p above the tip plane at which a curved blade has its blade angle, m.
    pub profile_height: f64,
    /// Toprem; none where the blade reaches down to its edge.
    pub toprem: Option<Toprem>,
}

/// Straight end of a blade, steeper than the part above it, that relieves the root of the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Toprem {
    /// Angle by which it is steeper than the blade where they join, rad.
    pub angle: f64,
    /// Height above the tip plane to which it reaches, m.
    pub depth: f64,
}

/// Surfaces of the parts of a blade, from above.
#[derive(Debug, Clone, Copy)]
pub struct BladeSurfaces {
    /// Straight or curved blade.
    pub blade: BladeSurface,
    /// Toprem.
    pub toprem: Option<BladeSurface>,
    /// Torus of the edge; none for a sharp edge.
    pub edge: Option<BladeSurface>,
}

/// Why the parts of a blade do not join; lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BladeFault {
    /// The arc has no blade angle between 0° and 90° at a height within the tooth.
    Turned {
        /// The height.
        height: f64,
    },
    /// The Toprem is not shallower than the tooth.
    DeepToprem,
    /// The Toprem's angle is not below that of the blade, rad.
    SteepToprem {
        /// Angle of the blade where they join.
        blade_angle: f64,
    },
    /// The edge radius does not end below a height: that of the Toprem, else that of the tooth.
    LongEdge {
        /// Height at which it would end; none where it touches nowhere.
        height: Option<f64>,
        /// The limit.
        limit: f64,
    },
}

/// A part of a blade's profile by its place, angle and curvature at one height.
#[derive(Debug, Clone, Copy)]
struct ProfilePart {
    /// 1 where the radius grows from the tip, −1 where it falls.
    outwards: f64,
    radius: f64,
    height: f64,
    angle: f64,
    curvature: f64,
}

impl Cutter {
    /// A sharp straight blade.
    pub fn straight(blade: Blade, point_radius: f64, blade_angle: f64) -> Cutter {
        Cutter {
            blade,
            point_radius,
            blade_angle,
            edge_radius: 0.0,
            profile_curvature: 0.0,
            profile_height: 0.0,
            toprem: None,
        }
    }

    /// Surfaces of the parts of the blade up to `depth` above the tip plane.
    ///
    /// Their parameter is the length along the profile away from the tip, that of the blade from where the tangent at its profile height
    /// meets the tip plane.
    pub fn surfaces(&self, depth: f64) -> BladeSurfaces {
        let blade = self.blade_part();
        let toprem = self.toprem.map(|toprem| (toprem, blade.toprem(&toprem)));
        let lowest = toprem.map_or(blade, |(_, part)| part);
        let end = lowest.edge_height(self.edge_radius);
        let from = self.toprem.map_or(end, |toprem| toprem.depth);
        let is_round = self.edge_radius > 0.0;
        BladeSurfaces {
            blade: self.swept(blade.arc([from, depth])),
            toprem: toprem.map(|(toprem, part)| self.swept(part.arc([end, toprem.depth]))),
            edge: is_round.then(|| self.swept(lowest.edge(self.edge_radius))),
        }
    }

    /// The blade's profile at a length s of its surface, in the plane of the cutter's axis z.
    pub fn profile(&self) -> Arc {
        self.blade_part().arc([0.0, 0.0])
    }

    /// Displacement `[radius, z]` of the profile at a length s by a unit of the blade angle, m/rad: a turn about the point at the profile
    /// height, which itself moves by `h_p/cos² α` outwards.
    pub fn displacement_by_blade_angle(&self, s: f64) -> [f64; 2] {
        let part = self.blade_part();
        let [point, ..] = self.profile().at(s);
        let by_height = self.profile_height / self.blade_angle.cos().powi(2);
        [
            self.outwards() * (by_height - point.z - self.profile_height),
            self.outwards() * (point.x - part.radius),
        ]
    }

    /// Displacement `[radius, z]` of the profile at a length s along its normal by a unit of the profile curvature, m²: `t² (1 − cos kt)/(kt)²`
    /// at the length t from the point at the profile height, which stays.
    pub fn displacement_by_curvature(&self, s: f64) -> [f64; 2] {
        let [_, tangent, _] = self.profile().at(s);
        let t = s - self.profile_height / self.blade_angle.cos();
        let half = 0.5 * self.profile_curvature * t;
        let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
        let along = 0.5 * (t * sinc).powi(2);
        [-tangent.z, tangent.x].map(|normal| self.outwards() * along * normal)
    }

    /// Why there is no blade for teeth of a depth, m; none where there is one.
    pub fn fault(&self, depth: f64) -> Option<BladeFault> {
        let blade = self.blade_part();
        let sine = |height: &f64| blade.sine_at(*height);
        let turned = |height: &f64| !(sine(height) > 0.0 && sine(height) < STEEPEST);
        if let Some(height) = [0.0, depth].into_iter().find(turned) {
            return Some(BladeFault::Turned { height });
        }
        let mut lowest = blade;
        let mut limit = depth;
        if let Some(toprem) = self.toprem {
            if toprem.depth >= depth {
                return Some(BladeFault::DeepToprem);
            }
            let blade_angle = blade.angle_at(toprem.depth);
            if toprem.angle >= blade_angle {
                return Some(BladeFault::SteepToprem { blade_angle });
            }
            (lowest, limit) = (blade.toprem(&toprem), toprem.depth);
        }
        let height = lowest.edge_height(self.edge_radius);
        (!(height < limit)).then_some(BladeFault::LongEdge {
            height: height.is_finite().then_some(height),
            limit,
        })
    }

    /// 1 where the radius grows from the tip, −1 where it falls.
    pub fn outwards(&self) -> f64 {
        match self.blade {
            Blade::Inside => -1.0,
            Blade::Outside => 1.0,
        }
    }

    fn blade_part(&self) -> ProfilePart {
        let outwards = self.outwards();
        ProfilePart {
            outwards,
            radius: self.point_radius + outwards * self.profile_height * self.blade_angle.tan(),
            height: self.profile_height,
            angle: self.blade_angle,
            curvature: self.profile_curvature,
        }
    }

    /// A profile turned about the cutter's axis, its normal into the blade.
    fn swept(&self, profile: Arc) -> BladeSurface {
        let tool = Tool::new(profile, Twist::turn(Vector::Z, Vector::ZERO));
        match self.blade {
            Blade::Inside => tool,
            Blade::Outside => tool.flipped(),
        }
    }
}

impl ProfilePart {
    fn sine_at(&self, height: f64) -> f64 {
        self.angle.sin() + self.curvature * (height - self.height)
    }

    fn angle_at(&self, height: f64) -> f64 {
        match self.curvature == 0.0 {
            true => self.angle,
            false => self.sine_at(height).clamp(-STEEPEST, STEEPEST).asin(),
        }
    }

    /// Length of the profile at a height, 0 where the tangent at its own height meets the tip plane.
    fn length_at(&self, height: f64) -> f64 {
        let cos = self.angle.cos();
        match self.curvature == 0.0 {
            true => height / cos,
            false => self.height / cos + (self.angle_at(height) - self.angle) / self.curvature,
        }
    }

    /// The profile between two heights.
    fn arc(&self, heights: [f64; 2]) -> Arc {
        let (sin, cos) = self.angle.sin_cos();
        let at_height = Arc {
            point: Vector::new(self.radius, 0.0, -self.height),
            direction: Vector::new(self.outwards * sin, 0.0, -cos),
            curvature: Vector::new(self.outwards * cos, 0.0, sin) * self.curvature,
            range: [0.0, 0.0],
        };
        let range = heights.map(|height| self.length_at(height));
        at_height.measured_from(-self.height / cos, range)
    }

    /// The Toprem that joins this part.
    fn toprem(&self, toprem: &Toprem) -> ProfilePart {
        let joint = self.arc([toprem.depth; 2]);
        let [point, ..] = joint.at(joint.range[0]);
        ProfilePart {
            radius: point.x,
            height: toprem.depth,
            angle: self.angle_at(toprem.depth) - toprem.angle,
            curvature: 0.0,
            ..*self
        }
    }

    /// Height at which an edge of the radius ρ touches this part, `ρ (1 − sin a)` with `sin a = (sin α + k (ρ − h_p))/(1 + k ρ)`; not a
    /// number where it touches nowhere.
    fn edge_height(&self, radius: f64) -> f64 {
        let sine = self.sine_at(radius) / (1.0 + self.curvature * radius);
        match sine.abs() < 1.0 && self.curvature * radius > -1.0 {
            true => radius * (1.0 - sine),
            false => f64::NAN,
        }
    }

    /// The arc of the edge from the tip plane up to this part.
    fn edge(&self, radius: f64) -> Arc {
        let height = self.edge_height(radius);
        let joint = self.arc([height; 2]);
        let [point, ..] = joint.at(joint.range[0]);
        let angle = self.angle_at(height);
        let outwards = self.outwards * Vector::X;
        let centre = Vector::X * point.x - outwards * (radius * angle.cos()) - Vector::Z * radius;
        let angles = [0.0, FRAC_PI_2 - angle];
        Arc::about(centre, radius, [Vector::Z, outwards], angles)
    }
}
