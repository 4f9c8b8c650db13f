//! Separation of encoder eccentricity from gear eccentricity by means of both flanks.
//!
//! An encoder reads the same error whichever flank carries, `E`. A gear's eccentricity acts along the line of action of the flank that
//! carries, and the two lines stand at ± the transverse pressure angle α to the tangent: on the driven gear the drive flank shows
//! `E + G e^{−iα}` and the coast flank `E + G e^{iα}`, on the driving gear the other way round. Two equations, two unknowns; noise
//! grows by `1/(√2 sin α)`.

use super::evaluate::TeEvaluation;
use super::flank::{FlankEvaluation, OrderEstimate};
use super::gear_train::GearTrain;
use crate::numeric::Complex;

/// Contributions of encoder and gear to order 1 of a shaft.
#[derive(Debug, Clone, PartialEq)]
pub struct EccentricitySplit {
    /// `input` or `output`.
    pub shaft: &'static str,
    /// Eccentricity error of the encoder, rad of the output, zero to peak.
    pub encoder: f64,
    /// Eccentricity error of the gear.
    pub gear: f64,
    /// Standard deviation of either.
    pub deviation: f64,
}

/// Eccentricity split of each shaft whose order is unique; empty unless both flanks were measured and the train is one pair.
pub fn split_eccentricity(
    measured: &TeEvaluation,
    teeth: &GearTrain,
    pressure_angle: f64,
) -> Vec<EccentricitySplit> {
    let forward = |up: bool| measured.flanks.iter().find(|f| f.forward == up);
    let (Some(drive), Some(coast)) = (forward(true), forward(false)) else {
        return Vec::new();
    };
    if teeth.pairs().len() != 1 {
        return Vec::new();
    }
    let both = [("input", -1.0), ("output", 1.0)];
    both.into_iter()
        .filter_map(|(shaft, sense)| split_shaft(shaft, sense * pressure_angle, drive, coast))
        .collect()
}

fn split_shaft(
    shaft: &'static str,
    angle: f64,
    drive: &FlankEvaluation,
    coast: &FlankEvaluation,
) -> Option<EccentricitySplit> {
    let line = |flank: &FlankEvaluation| -> Option<(Complex, f64)> {
        let is_own = |l: &&OrderEstimate| l.order.names == [shaft] && l.interval.is_some();
        let found = flank.lines.iter().find(is_own)?;
        Some((
            Complex::from_polar(found.amplitude, found.phase),
            found.deviation,
        ))
    };
    let ((d, sd), (c, sc)) = (line(drive)?, line(coast)?);
    let gear = (c - d) / Complex::new(0.0, 2.0 * angle.sin());
    let encoder = d - gear * Complex::from_polar(1.0, -angle);
    Some(EccentricitySplit {
        shaft,
        encoder: encoder.norm(),
        gear: gear.norm(),
        deviation: sd.hypot(sc) / (2.0 * angle.sin().abs()),
    })
}
