//! Mesh of two gears of a gear file, as a model names it.
//!
//! Lengths and angles are those of the working pitch circles: `m_w = 2 r_w cos β_w/z`, `tan β_w = tan β r_w/r`, so that the normal of the
//! mesh is that of the teeth at their centre distance.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::base::source_span::{SourceFile, SourceSpan};
use crate::gear::cylindrical::pair::Pair;
use crate::gear::hand::Hand;
use crate::gear::load::mesh::MeshOptions;

/// A gear file that a mesh of a model names.
#[derive(Debug, Clone)]
pub struct MeshFile {
    /// The file.
    pub source: Arc<SourceFile>,
    /// Place of `pair` in the file.
    pub place: SourceSpan,
    /// Place of the file's name in the model.
    pub span: SourceSpan,
    /// Torque of `[mesh]` where it is one, N·m at the pinion.
    pub torque: Option<f64>,
    /// Key of the model that states a stiffness next to the file, and its place.
    pub stated_stiffness: Option<(String, SourceSpan)>,
}

/// A pair of cylindrical gears as a mesh of a model takes it from its gear file.
#[derive(Debug)]
pub struct GearMesh {
    /// The file.
    pub file: MeshFile,
    /// Gears in mesh.
    pub pair: Pair,
    /// Hand of the pinion.
    pub hand: Hand,
    /// Normal backlash at mean thicknesses and mean centre distance, m.
    pub backlash: f64,
    /// Stiffness, modifications and discretisation of the loaded mesh.
    pub options: MeshOptions,
}

impl GearMesh {
    /// Tooth numbers of pinion and gear.
    pub fn teeth(&self) -> [u32; 2] {
        self.pair.members.map(|m| m.gear.teeth)
    }

    /// The second gear is internal.
    pub fn is_internal(&self) -> bool {
        self.pair.members[1].gear.internal
    }

    /// Helix angle on the working pitch cylinders, rad.
    pub fn helix_angle(&self) -> f64 {
        let base = self.base_helix_angle().tan();
        (base / self.pair.working_pressure_angle.cos()).atan()
    }

    /// Base helix angle β_b, rad, without sign.
    pub fn base_helix_angle(&self) -> f64 {
        self.pair.members[0].gear.base_helix_angle().abs()
    }

    /// Normal pressure angle on the working pitch cylinders, rad.
    pub fn pressure_angle(&self) -> f64 {
        (self.pair.working_pressure_angle.tan() * self.helix_angle().cos()).atan()
    }

    /// Transverse module on the working pitch cylinders, m.
    pub fn transverse_module(&self) -> f64 {
        let [diameter, _] = self.pair.working_diameters();
        diameter / f64::from(self.teeth()[0])
    }

    /// Normal module on the working pitch cylinders, m.
    pub fn normal_module(&self) -> f64 {
        self.transverse_module() * self.helix_angle().cos()
    }

    /// Radii of the tip circles, m.
    pub fn tip_radii(&self) -> [f64; 2] {
        self.pair.outlines.map(|outline| outline.tip_radius)
    }

    /// Phase of the cycle of friction at the pitch point, rad: that cycle begins where a pair comes into contact.
    pub fn path_phase(&self) -> f64 {
        TAU * self.pair.path_ends()[0] / self.pair.base_pitch()
    }
}
