//! Face-mill cutters: the cone of straight blades `r = (r_p ∓ s sin α) e_θ − s cos α k` and the torus of their edge radius.
//!
//! Litvin and Fuentes, Gear Geometry and Applied Theory, 2nd ed. 2004, section 21.2.

use std::f64::consts::FRAC_PI_2;

use super::frames::CutterFrame;
use crate::gear::kernel::tool::{Arc, Curve, Line, Tool};
use crate::gear::kernel::twist::Twist;
use crate::gear::kernel::vector::Vector;

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
    /// Point radius r_p, where the blade's line meets the tip plane, m.
    pub point_radius: f64,
    /// Blade angle α > 0, rad.
    pub blade_angle: f64,
    /// Edge radius, m; 0 for a sharp edge.
    pub edge_radius: f64,
}

impl Cutter {
    /// The cone of the blade up to `depth` from the tip plane; its parameter s is the length along the blade from the tip plane.
    pub fn cone(&self, depth: f64) -> Tool<Line, CutterFrame> {
        let (sin, cos) = self.blade_angle.sin_cos();
        self.swept(Line {
            point: self.point_radius * Vector::X,
            direction: Vector::new(self.outwards() * sin, 0.0, -cos),
            range: [self.edge_end(), depth / cos],
        })
    }

    /// The torus of the edge from the tip plane to the cone; none for a sharp edge.
    pub fn edge(&self) -> Option<Tool<Arc, CutterFrame>> {
        let (sin, cos) = self.blade_angle.sin_cos();
        let inside = self.edge_end() * sin - self.edge_radius * cos;
        let arc = Arc {
            centre: Vector::new(
                self.point_radius + self.outwards() * inside,
                0.0,
                -self.edge_radius,
            ),
            radius: self.edge_radius,
            first: Vector::Z,
            second: self.outwards() * Vector::X,
            range: [0.0, FRAC_PI_2 - self.blade_angle],
        };
        (self.edge_radius > 0.0).then(|| self.swept(arc))
    }

    /// Length s along the blade at which the edge radius ends: `ρ (1 − sin α)/cos α`.
    pub fn edge_end(&self) -> f64 {
        let (sin, cos) = self.blade_angle.sin_cos();
        self.edge_radius * (1.0 - sin) / cos
    }

    /// 1 where the radius grows from the tip, −1 where it falls.
    pub fn outwards(&self) -> f64 {
        match self.blade {
            Blade::Inside => -1.0,
            Blade::Outside => 1.0,
        }
    }

    /// A profile turned about the cutter's axis, its normal into the blade.
    fn swept<C: Curve>(&self, curve: C) -> Tool<C, CutterFrame> {
        let tool = Tool::new(curve, Twist::turn(Vector::Z, Vector::ZERO));
        match self.blade {
            Blade::Inside => tool,
            Blade::Outside => tool.flipped(),
        }
    }
}
