//! Mesh of a pair of gears by its gear file, whatever the kind of the gears.

use std::sync::Arc;

use super::bevel_mesh::BevelMesh;
use super::gear_mesh::{GearMesh, MeshFile};

/// The mesh of a pair by its gear file.
#[derive(Debug, Clone)]
pub enum PairMesh {
    /// Gears on parallel axes.
    Cylindrical(Arc<GearMesh>),
    /// Bevel and hypoid gears.
    Bevel(Arc<BevelMesh>),
}

impl PairMesh {
    /// The file.
    pub fn file(&self) -> &MeshFile {
        match self {
            PairMesh::Cylindrical(mesh) => &mesh.file,
            PairMesh::Bevel(mesh) => &mesh.file,
        }
    }

    /// Lever of the tooth force about the pinion's axis, m: the base radius, or that at the reference contact.
    pub fn lever(&self) -> f64 {
        match self {
            PairMesh::Cylindrical(mesh) => mesh.pair.outlines[0].base_radius,
            PairMesh::Bevel(mesh) => mesh.levers[0],
        }
    }

    /// Common face width, m.
    pub fn face_width(&self) -> f64 {
        let [first, second] = match self {
            PairMesh::Cylindrical(mesh) => mesh.pair.members.map(|m| m.face_width),
            PairMesh::Bevel(mesh) => (mesh.bevel.members.each_ref()).map(|m| m.blank.face_width),
        };
        first.min(second)
    }

    /// The torque of the file, N·m at the pinion, below zero where its flanks push backwards.
    pub fn stated_torque(&self) -> Option<f64> {
        let torque = self.file().torque?;
        Some(match self {
            PairMesh::Bevel(mesh) if mesh.is_backward => -torque,
            _ => torque,
        })
    }
}
