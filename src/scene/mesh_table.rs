//! `[mesh]` of a file of cylindrical gears: load, stiffness, discretisation.

use super::mesh_torques::torques;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceSpan;
use crate::base::table_reader::{TableReader, Word};
use crate::gear::load::body::Body;
use crate::gear::load::compliance::StiffnessMethod;
use crate::gear::load::hertz::ContactModel;
use crate::gear::load::mesh::{MAX_POSITIONS, MAX_SLICES};

/// Load on a mesh and its discretisation.
#[derive(Debug, Clone)]
pub struct MeshStudy {
    /// Torques at the pinion, N·m; the mesh is computed where there are any.
    pub torques: Vec<f64>,
    /// Stiffness of the tooth pairs.
    pub method: StiffnessMethod,
    /// Positions in one pitch.
    pub positions: usize,
    /// Slices along the face width.
    pub slices: usize,
    /// Seek the tip relief of least peak-to-peak over the torques.
    pub least_relief: bool,
}

/// `[mesh]` as written.
#[derive(Debug, Default)]
pub struct MeshTable {
    pub(super) torques: Vec<f64>,
    pub(super) positions: Option<u32>,
    pub(super) slices: Option<u32>,
    pub(super) method: Option<MeshMethod>,
    pub(super) body: Option<BodyModel>,
    pub(super) least_relief: bool,
}

/// Stiffness of tooth pairs.
#[derive(Debug, Clone, Copy)]
pub enum MeshMethod {
    /// Potential energy of the teeth.
    Energy,
    /// c′ of ISO 6336-1.
    Iso6336,
}

impl Word for MeshMethod {
    const WORDS: &'static [(&'static str, MeshMethod, &'static str)] = &[
        (
            "energy",
            MeshMethod::Energy,
            "Potential energy of teeth with their fillets",
        ),
        (
            "iso-6336",
            MeshMethod::Iso6336,
            "c′ of ISO 6336-1:2006, constant along the flank",
        ),
    ];
}

/// Model of the gear bodies.
#[derive(Debug, Clone, Copy)]
pub enum BodyModel {
    /// No deflection below the root circle.
    Rigid,
    /// Half plane.
    HalfPlane,
    /// Elastic ring on a rigid shaft.
    Ring,
}

impl Word for BodyModel {
    const WORDS: &'static [(&'static str, BodyModel, &'static str)] = &[
        (
            "half-plane",
            BodyModel::HalfPlane,
            "Half plane in plane strain",
        ),
        (
            "ring",
            BodyModel::Ring,
            "Elastic ring on a rigid shaft; needs bore_diameter",
        ),
        (
            "rigid",
            BodyModel::Rigid,
            "No deflection below the root circle",
        ),
    ];
}

/// Reads `[mesh]`.
pub fn mesh(f: &mut TableReader) -> MeshTable {
    MeshTable {
        torques: torques(f),
        positions: f.optional_count("positions", 2, MAX_POSITIONS),
        slices: f.optional_count("slices", 1, MAX_SLICES),
        method: f.word("method"),
        body: f.word("body"),
        least_relief: f.flag("least_relief"),
    }
}

impl MeshTable {
    /// The stiffness method with bodies of the bores.
    pub(super) fn method(
        &self,
        bores: [Option<f64>; 2],
        span: &SourceSpan,
    ) -> Result<StiffnessMethod, Error> {
        if let Some(MeshMethod::Iso6336) = self.method {
            return match self.body {
                None => Ok(StiffnessMethod::Iso6336 { webs: [None; 2] }),
                Some(_) => Err(Error::new(
                    Code::Conflict,
                    "`body` applies to the energy method only; ISO 6336-1 assumes solid discs",
                )
                .with_span(span)
                .with_hint("omit `body`")),
            };
        }
        let body = |bore: Option<f64>| match (self.body, bore) {
            (Some(BodyModel::Rigid), _) => Ok(Body::Rigid),
            (None | Some(BodyModel::HalfPlane), _) => Ok(Body::HalfPlane),
            (Some(BodyModel::Ring), Some(bore)) => Ok(Body::Ring {
                bore_radius: 0.5 * bore,
            }),
            (Some(BodyModel::Ring), None) => Err(Error::new(
                Code::MissingKey,
                "the elastic ring needs the bore of each gear",
            )
            .with_span(span)
            .with_hint("give `bore_diameter` in `pinion` and in `gear`")),
        };
        Ok(StiffnessMethod::Energy {
            bodies: [body(bores[0])?, body(bores[1])?],
            contact: ContactModel::default(),
        })
    }
}
