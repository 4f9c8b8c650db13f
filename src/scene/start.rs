//! `[start]`: where motion begins.

use super::laws::{PhaseOf, StartAt};
use super::model::Name;
use super::tables::one;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;

/// Where motion begins.
#[derive(Debug, Clone, Default)]
pub struct Start {
    /// At rest or running.
    pub at: StartAt,
    /// What angles waves hang on.
    pub phase: PhaseOf,
    /// Angles of nodes in place of that, rad.
    pub angles: Vec<(Name, f64)>,
    /// Speeds of nodes in place of that, rad/s.
    pub speeds: Vec<(Name, f64)>,
}

/// Reads it.
pub fn read(f: &mut Fields) -> Start {
    Start {
        at: f
            .choice(
                "at",
                &[("rest", StartAt::Rest), ("steady", StartAt::Steady)],
            )
            .unwrap_or_default(),
        phase: f
            .choice(
                "mesh_phase",
                &[("angle", PhaseOf::Angle), ("speed", PhaseOf::Speed)],
            )
            .unwrap_or_default(),
        angles: one(f, "angle", |f| named(f, Kind::Angle)).unwrap_or_default(),
        speeds: one(f, "speed", |f| named(f, Kind::Speed)).unwrap_or_default(),
    }
}

fn named(f: &mut Fields, kind: Kind) -> Vec<(Name, f64)> {
    let named = f.every_quantity(kind, Range::Any);
    let named = named.into_iter().map(|(entry, value)| {
        let name = Name {
            text: entry.key.clone(),
            place: entry.key_place.clone(),
        };
        (name, value)
    });
    named.collect()
}
