//! Units, sources and phases of the lines of a transmission error.

use std::f64::consts::PI;

use serde_json::{Value, json};

use crate::encoder::flank::FlankEvaluation;
use crate::machine::components::Machine;
use crate::plan::logs::encoder_analysis::EncoderResult;
use crate::plan::transmission::result::TransmissionResult;
use crate::transmission::coincidence::SeparationTest;

/// Arc seconds in a radian.
pub const ARCSEC: f64 = 648_000.0 / PI;

/// Unit of an output's errors.
#[derive(Debug, Clone, Copy)]
pub struct TeUnit {
    /// Number of these units in a rad, or in a m.
    pub times: f64,
    /// In words.
    pub name: &'static str,
    /// At the end of keys.
    pub key: &'static str,
}

impl TeUnit {
    /// Arc seconds of what turns, µm of what slides.
    pub fn for_output(machine: &Machine, result: &TransmissionResult) -> TeUnit {
        match machine.dofs[result.chain.ends.output].axis.is_rotation() {
            true => TeUnit {
                times: ARCSEC,
                name: "arcsec",
                key: "arcsec",
            },
            false => TeUnit {
                times: 1e6,
                name: "µm",
                key: "um",
            },
        }
    }

    /// Object whose numbers, rad or m, are under keys that end in the unit, with `others` behind them.
    pub fn object(self, values: &[(&str, Option<f64>)], others: Value) -> Value {
        let mut object = serde_json::Map::new();
        for &(key, value) in values {
            let value = value.map(|x| x * self.times);
            object.insert(format!("{key}_{}", self.key), json!(value));
        }
        if let Value::Object(others) = others {
            object.extend(others);
        }
        Value::Object(object)
    }
}

/// A second record, as text.
pub fn separation_test_text(machine: &Machine, test: &SeparationTest) -> String {
    let degrees = |turns: f64| (360.0 * turns).round();
    match test {
        SeparationTest::Remesh { pair, teeth, shift } => format!(
            "mesh {} {teeth} {} further on: their phases separate by {}°",
            machine.elements[*pair].name,
            if *teeth == 1 { "tooth" } else { "teeth" },
            degrees(*shift)
        ),
        SeparationTest::Reseat => "turn the gear on its seat".to_string(),
        SeparationTest::Reversal(shift) => format!(
            "run it backward, on the other flanks: their phases separate by {}°",
            degrees(*shift)
        ),
        SeparationTest::Torque => {
            "change the torque: effects of stiffness change with it".to_string()
        }
        SeparationTest::SpeedOrTester => {
            "change the speed, if the transfer functions differ; else measure each alone on a tester"
                .to_string()
        }
    }
}

/// Arc seconds of an angle, rad.
pub fn arcsec(angle: f64) -> f64 {
    angle * 648_000.0 / PI
}

/// Degrees in [0, 360).
pub fn degrees(angle: f64) -> f64 {
    angle.to_degrees().rem_euclid(360.0)
}

/// Which way the input turned.
pub fn direction_name(flank: &FlankEvaluation) -> &'static str {
    if flank.forward { "forward" } else { "backward" }
}

/// A length on the line of action, µm, where the radius is known.
pub fn micrometres(found: &EncoderResult, angle: f64) -> Option<f64> {
    found.radius.map(|r| 1e6 * r * angle)
}
