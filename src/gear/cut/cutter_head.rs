//! A face-mill cutter head with discrete blades: feed of the roll, and the surfaces of its blades, each off by its run-out.

use std::f64::consts::TAU;

use crate::gear::bevel::cutter::BladeSurfaces;
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

impl BladeSurfaces {
    /// The surfaces of a blade off its place.
    pub(super) fn at(mut self, offset: BladeOffset) -> BladeSurfaces {
        let by = offset.radial * Vector::X + offset.axial * Vector::Z;
        self.blade.curve.point += by;
        for part in self.toprem.iter_mut().chain(&mut self.edge) {
            part.curve.point += by;
        }
        self
    }
}
