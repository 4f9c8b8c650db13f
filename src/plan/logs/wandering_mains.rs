//! Lines of the mains among what responses alone show: sines, and poles no wider than a line, or than a grid wanders.

use std::f64::consts::TAU;

use super::identification_result::IdentifiedHarmonic;
use super::mains::{HINT, WIDEST, as_line};
use super::running::SpeedOrders;
use super::weak::damping_includes_zero;
use crate::base::error::Diagnostic;
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::operational::spacing::HarmonicSeries;
use crate::spectrum::mains::{mains_multiple, names};

/// Half-power width, Hz, of the first multiple of a grid that stays within the standard range of ±0.05 Hz of continental Europe
/// (Commission Regulation (EU) 2017/1485, annex III).
const WANDERING_WIDTH: f64 = 0.1;

/// Whether a pole is a line of the mains: no wider than a line of the record, or no wider than a grid wanders and near a sine taken out
/// there, or with a damping whose interval includes zero.
pub fn is_wandering_line(mode: &ModalParameters, orders: &SpeedOrders) -> bool {
    let (f, width) = (mode.frequency_hz(), 2.0 * mode.pole.re.abs() / TAU);
    let wanders = mains_multiple(f, 0.5 * width).is_some_and(|(_, k)| {
        width <= (WANDERING_WIDTH * k as f64).min(WIDEST)
            && (orders.is_near_removed_sine(f, orders.line_hz.max(0.5 * width))
                || damping_includes_zero(mode) == Some(true))
    });
    wanders || as_line(mode, orders.line_hz).is_some()
}

/// Labels the lines of the mains among those of running speed: on no order, and in no series but that of the mains.
pub fn label_mains(harmonics: &mut [IdentifiedHarmonic], evenly: &[HarmonicSeries], line_hz: f64) {
    let positions: Vec<f64> = harmonics.iter().map(|h| h.frequency_hz).collect();
    let is_shaft = |f: f64| {
        let is_other = |s: &&HarmonicSeries| mains_multiple(s.spacing_hz, line_hz).is_none();
        evenly
            .iter()
            .filter(is_other)
            .any(|s| s.contains(f, 2.0 * line_hz))
    };
    for (harmonic, name) in harmonics.iter_mut().zip(names(&positions, 2.0 * line_hz)) {
        if name.is_some() && harmonic.order.is_none() && !is_shaft(harmonic.frequency_hz) {
            harmonic.reason = IdentifiedHarmonic::MAINS;
        }
    }
}

/// Warning about the lines of the mains among what is no mode.
pub fn mains_warning(harmonics: &[IdentifiedHarmonic]) -> Option<Diagnostic> {
    let all: Vec<String> = (harmonics.iter())
        .filter(|h| h.reason == IdentifiedHarmonic::MAINS)
        .map(|h| format!("{:.4} Hz", h.frequency_hz))
        .collect();
    (!all.is_empty()).then(|| Diagnostic {
        code: "mains",
        message: format!(
            "at or around a harmonic of the mains, listed apart from the modes: {}",
            all.join(", ")
        ),
        hint: Some(HINT.to_string()),
    })
}
