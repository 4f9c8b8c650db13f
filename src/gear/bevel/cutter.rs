//! Face-mill cutter: surfaces of revolution of the straight or circular-arc blade, the Toprem and the edge radius.
//!
//! Along a blade arc the blade angle a depends on the height h above the tip plane by `sin a = sin α + k (h − h_p)`.
//! Litvin and Fuentes, Gear Geometry and Applied Theory, 2nd ed. 2004, section 21.2 (straight blades and their edge).

use std::f64::consts::FRAC_PI_2;

use super::frames::CutterFrame;
use crate::gear::kernel::tool::{Arc, Curve, Tool};
use crate::gear::kernel::twist::Twist;
use crate::gear::kernel::vector::Vector;

/// Surface of revolution of a blade segment.
pub type BladeSurface = Tool<Arc, CutterFrame>;

/// Largest sine of a blade angle: limit of a blade arc above the tooth.
const MAX_SINE: f64 = 0.99;

/// Cutting side of a blade: inside or outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blade {
    /// Inside blade: radius decreases from the tip; it cuts convex flanks.
    Inside,
    /// Outside blade: radius increases from the tip; it cuts concave flanks.
    Outside,
}

/// Face-mill cutter data for one flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutter {
    /// Blade that cuts the flank.
    pub blade: Blade,
    /// Point radius r_p of the blade profile in the tip plane, m; for a curved blade of the tangent at the profile height.
    pub point_radius: f64,
    /// Blade angle α > 0, rad; for a curved blade at the profile height.
    pub blade_angle: f64,
    /// Edge radius, m; 0 for a sharp edge.
    pub edge_radius: f64,
    /// Curvature k of the blade profile, 1/m: positive for a concave blade (profile crowning), 0 for a straight blade.
    pub profile_curvature: f64,
    /// Profile height h_p of the blade angle of a curved blade above the tip plane, m.
    pub profile_height: f64,
    /// Toprem; `None` for a blade without.
    pub toprem: Option<Toprem>,
}

/// Toprem: straight, steeper end segment of a blade that relieves the root of the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Toprem {
    /// Toprem angle relative to the blade at the junction, rad.
    pub angle: f64,
    /// Height of the Toprem above the tip plane, m.
    pub depth: f64,
}

/// Surfaces of the blade segments.
#[derive(Debug, Clone, Copy)]
pub struct BladeSurfaces {
    /// Straight or curved blade.
    pub blade: BladeSurface,
    /// Toprem.
    pub toprem: Option<BladeSurface>,
    /// Torus of the edge radius; `None` for a sharp edge.
    pub edge: Option<BladeSurface>,
}

/// Geometric fault of a blade profile; lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BladeFault {
    /// Blade angle of the arc outside 0° to 90° at a height within the tooth.
    Turned {
        /// Height above the tip plane, m.
        height: f64,
    },
    /// Toprem depth not below the tooth depth.
    DeepToprem,
    /// Toprem angle not below the blade angle.
    SteepToprem {
        /// Blade angle at the junction, rad.
        blade_angle: f64,
    },
    /// Edge radius too large: its end lies above the Toprem, or above the tooth.
    LongEdge {
        /// Height of the end of the edge, m; `None` without a tangent point.
        height: Option<f64>,
        /// Limit of the height, m.
        limit: f64,
    },
}

/// Segment of a blade profile: position, angle and curvature at one height.
#[derive(Debug, Clone, Copy)]
struct ProfileSegment {
    /// Sign of the radius change from the tip: 1 outside blade, −1 inside blade.
    outwards: f64,
    radius: f64,
    height: f64,
    angle: f64,
    curvature: f64,
}

impl Cutter {
    /// Cutter with a straight blade and sharp edge.
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

    /// Surfaces of the blade segments up to `depth` above the tip plane, m.
    ///
    /// The surface parameter is the length along the profile away from the tip, for the blade from the intersection of the tangent at the
    /// profile height with the tip plane.
    pub fn surfaces(&self, depth: f64) -> BladeSurfaces {
        let blade = self.blade_segment();
        let toprem = self.toprem.map(|toprem| (toprem, blade.toprem(&toprem)));
        let last = toprem.map_or(blade, |(_, segment)| segment);
        let end = last.edge_height(self.edge_radius);
        let from = self.toprem.map_or(end, |toprem| toprem.depth);
        let is_round = self.edge_radius > 0.0;
        BladeSurfaces {
            blade: self.swept(blade.arc([from, depth])),
            toprem: toprem.map(|(toprem, segment)| self.swept(segment.arc([end, toprem.depth]))),
            edge: is_round.then(|| self.swept(last.edge(self.edge_radius))),
        }
    }

    /// Blade profile over the length s, in a plane through the cutter axis z.
    pub fn profile(&self) -> Arc {
        self.blade_segment().arc([0.0, 0.0])
    }

    /// Displacement `[radius, z]` of the profile at a length s per unit blade angle, m/rad: a rotation about the point at the profile
    /// height, and the outward displacement `h_p/cos² α` of that point.
    pub fn displacement_by_blade_angle(&self, s: f64) -> [f64; 2] {
        let segment = self.blade_segment();
        let [point, ..] = self.profile().at(s);
        let by_height = self.profile_height / self.blade_angle.cos().powi(2);
        [
            self.outwards() * (by_height - point.z - self.profile_height),
            self.outwards() * (point.x - segment.radius),
        ]
    }

    /// Displacement `[radius, z]` of the profile at a length s along the normal per unit profile curvature, m²: `t² (1 − cos kt)/(kt)²`
    /// at the length t from the fixed point at the profile height.
    pub fn displacement_by_curvature(&self, s: f64) -> [f64; 2] {
        let [_, tangent, _] = self.profile().at(s);
        let t = s - self.profile_height / self.blade_angle.cos();
        let half = 0.5 * self.profile_curvature * t;
        let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
        let along = 0.5 * (t * sinc).powi(2);
        [-tangent.z, tangent.x].map(|normal| self.outwards() * along * normal)
    }

    /// Fault of the blade for a tooth depth, m; `None` for a valid blade.
    pub fn fault(&self, depth: f64) -> Option<BladeFault> {
        let blade = self.blade_segment();
        let sine = |height: &f64| blade.sine_at(*height);
        let is_out_of_range = |height: &f64| !(sine(height) > 0.0 && sine(height) < MAX_SINE);
        if let Some(height) = [0.0, depth].into_iter().find(is_out_of_range) {
            return Some(BladeFault::Turned { height });
        }
        let mut last = blade;
        let mut limit = depth;
        if let Some(toprem) = self.toprem {
            if toprem.depth >= depth {
                return Some(BladeFault::DeepToprem);
            }
            let blade_angle = blade.angle_at(toprem.depth);
            if toprem.angle >= blade_angle {
                return Some(BladeFault::SteepToprem { blade_angle });
            }
            (last, limit) = (blade.toprem(&toprem), toprem.depth);
        }
        let height = last.edge_height(self.edge_radius);
        (!(height < limit)).then_some(BladeFault::LongEdge {
            height: height.is_finite().then_some(height),
            limit,
        })
    }

    /// Sign of the radius change from the tip: 1 outside blade, −1 inside blade.
    pub fn outwards(&self) -> f64 {
        match self.blade {
            Blade::Inside => -1.0,
            Blade::Outside => 1.0,
        }
    }

    fn blade_segment(&self) -> ProfileSegment {
        let outwards = self.outwards();
        ProfileSegment {
            outwards,
            radius: self.point_radius + outwards * self.profile_height * self.blade_angle.tan(),
            height: self.profile_height,
            angle: self.blade_angle,
            curvature: self.profile_curvature,
        }
    }

    /// Surface of revolution of a profile about the cutter axis, with the normal into the blade.
    fn swept(&self, profile: Arc) -> BladeSurface {
        let tool = Tool::new(profile, Twist::turn(Vector::Z, Vector::ZERO));
        match self.blade {
            Blade::Inside => tool,
            Blade::Outside => tool.flipped(),
        }
    }
}

impl ProfileSegment {
    fn sine_at(&self, height: f64) -> f64 {
        self.angle.sin() + self.curvature * (height - self.height)
    }

    fn angle_at(&self, height: f64) -> f64 {
        match self.curvature == 0.0 {
            true => self.angle,
            false => self.sine_at(height).clamp(-MAX_SINE, MAX_SINE).asin(),
        }
    }

    /// Length of the profile at a height, m, from the intersection of the tangent at `self.height` with the tip plane.
    fn length_at(&self, height: f64) -> f64 {
        let cos = self.angle.cos();
        match self.curvature == 0.0 {
            true => height / cos,
            false => self.height / cos + (self.angle_at(height) - self.angle) / self.curvature,
        }
    }

    /// Profile arc between two heights.
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

    /// Toprem segment below this segment.
    fn toprem(&self, toprem: &Toprem) -> ProfileSegment {
        let joint = self.arc([toprem.depth; 2]);
        let [point, ..] = joint.at(joint.range[0]);
        ProfileSegment {
            radius: point.x,
            height: toprem.depth,
            angle: self.angle_at(toprem.depth) - toprem.angle,
            curvature: 0.0,
            ..*self
        }
    }

    /// Height of the tangent point of an edge of the radius ρ, `ρ (1 − sin a)` with `sin a = (sin α + k (ρ − h_p))/(1 + k ρ)`; NaN
    /// without a tangent point.
    fn edge_height(&self, radius: f64) -> f64 {
        let sine = self.sine_at(radius) / (1.0 + self.curvature * radius);
        match sine.abs() < 1.0 && self.curvature * radius > -1.0 {
            true => radius * (1.0 - sine),
            false => f64::NAN,
        }
    }

    /// Arc of the edge from the tip plane up to this segment.
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
