//! A face-mill cutter head with discrete blades: the cones and edge tori of its blades, each off by its run-out.

use std::f64::consts::TAU;

use crate::gear::bevel::cutter::Cutter;
use crate::gear::bevel::frames::CutterFrame;
use crate::gear::kernel::tool::{Arc, Line, Tool};
use crate::gear::kernel::vector::Vector;

/// Offset of a blade from its place in the head.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BladeOffset {
    /// Away from the cutter's axis, m.
    pub radial: f64,
    /// Along the axis out of the tips, m.
    pub axial: f64,
}

/// Feed of the roll: the cradle turns on from blade to blade.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeFeed {
    /// Blades that cut the flank.
    pub blades: u32,
    /// Turn of the cradle in a turn of the cutter, rad; negative where φ_c falls as the blades move along growing θ.
    pub cradle_per_turn: f64,
}

impl BladeFeed {
    /// Cradle angle Δx from blade to blade, rad.
    pub fn step(&self) -> f64 {
        self.cradle_per_turn.abs() / f64::from(self.blades)
    }

    /// `dx/dθ`: turn of the cradle while a blade moves on by a radian.
    pub fn drag(&self) -> f64 {
        self.cradle_per_turn / TAU
    }
}

/// A blade of the head: its straight edge and its rounded tip, swept about the cutter's axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct BladeSurfaces {
    pub(super) cone: Tool<Line, CutterFrame>,
    pub(super) edge: Option<Tool<Arc, CutterFrame>>,
}

impl BladeSurfaces {
    /// The surfaces of a cutter's blade of the length `depth` along the axis.
    pub(super) fn new(cutter: &Cutter, depth: f64, offset: BladeOffset) -> BladeSurfaces {
        let moved = offset.radial * Vector::X + offset.axial * Vector::Z;
        let mut cone = cutter.cone(depth);
        cone.curve.point += moved;
        let mut edge = cutter.edge();
        if let Some(edge) = &mut edge {
            edge.curve.centre += moved;
        }
        BladeSurfaces { cone, edge }
    }
}
