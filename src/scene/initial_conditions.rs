//! Reads `[start]`: initial conditions of a simulation.

use super::laws::{InitialState, MeshPhase};
use super::model::Name;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::base::tables::read_table;

/// Angles, speeds and mesh phases at the start of a motion.
#[derive(Debug, Clone, Default)]
pub struct InitialConditions {
    /// At rest or running.
    pub at: InitialState,
    /// Phase of the mesh waves: from angles or mean speeds.
    pub phase: MeshPhase,
    /// Angles of nodes in place of that, rad.
    pub angles: Vec<(Name, f64)>,
    /// Speeds of nodes in place of that, rad/s.
    pub speeds: Vec<(Name, f64)>,
}

/// Reads it.
pub fn read(f: &mut TableReader) -> InitialConditions {
    InitialConditions {
        at: f
            .choice(
                "at",
                &[
                    ("rest", InitialState::Rest),
                    ("steady", InitialState::Steady),
                ],
            )
            .unwrap_or_default(),
        phase: f
            .choice(
                "mesh_phase",
                &[("angle", MeshPhase::Angle), ("speed", MeshPhase::Speed)],
            )
            .unwrap_or_default(),
        angles: read_table(f, "angle", |f| read_node_values(f, QuantityKind::Angle))
            .unwrap_or_default(),
        speeds: read_table(f, "speed", |f| read_node_values(f, QuantityKind::Speed))
            .unwrap_or_default(),
    }
}

fn read_node_values(f: &mut TableReader, kind: QuantityKind) -> Vec<(Name, f64)> {
    let named = f.all_quantities(kind, ValueRange::Any);
    let named = named.into_iter().map(|(entry, value)| {
        let name = Name {
            text: entry.key.clone(),
            span: entry.key_span.clone(),
        };
        (name, value)
    });
    named.collect()
}
