//! Harmonics of the running speed in operational data: orders of a stated speed, removed sines, and series of evenly spaced sines.

use std::f64::consts::TAU;

use super::identification_result::{IdentifiedHarmonic, IdentifiedMode};
use super::weak;
use crate::base::error::Diagnostic;
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::operational::harmonics::{HarmonicIndicator, RunningSpeed};
use crate::identify::operational::spacing::{HarmonicSeries, series};
use crate::spectrum::tones::Tone;

/// Tolerance of the frequencies of a harmonic series, spectral lines of the record.
const LINE_TOLERANCE: f64 = 1.5;

/// Evenly spaced series among removed sines and harmonic poles; `line_hz` is the line spacing of the record, Hz.
pub fn find_series(tones: &[Tone], modes: &[IdentifiedMode], line_hz: f64) -> Vec<HarmonicSeries> {
    let poles = modes.iter().filter(|m| is_sine(m));
    let mut lines: Vec<f64> = (tones.iter().map(|t| t.frequency_hz))
        .chain(poles.map(IdentifiedMode::frequency_hz))
        .collect();
    lines.sort_by(f64::total_cmp);
    series(&lines, LINE_TOLERANCE * line_hz)
}

/// True if the harmonic indicator of a pole identifies it as a harmonic.
pub fn is_sine(mode: &IdentifiedMode) -> bool {
    mode.harmonic
        .as_ref()
        .is_some_and(HarmonicIndicator::is_harmonic)
}

/// True if a mode is narrow and lies on a harmonic series, unless it has structural damping and contains a removed sine.
pub fn in_series(list: &[HarmonicSeries], mode: &IdentifiedMode, orders: &SpeedOrders) -> bool {
    /// Largest half-power half-bandwidth, relative to the spacing.
    const NARROW: f64 = 0.05;
    let half_band = mode.mode.pole.re.abs() / TAU;
    let std = mode.mode.frequency_std_hz().unwrap_or(0.0);
    if orders.is_structural(&mode.mode) && orders.contains_removed_sine(&mode.mode) {
        return false;
    }
    list.iter().any(|s| {
        let tolerance = (LINE_TOLERANCE * orders.line_hz)
            .max(std)
            .min(NARROW * s.spacing_hz);
        half_band < NARROW * s.spacing_hz && s.contains(mode.frequency_hz(), tolerance)
    })
}

/// Warning that names a series of evenly spaced sines.
pub fn series_warning(series: &HarmonicSeries) -> Option<Diagnostic> {
    let (first, last) = (series.lines_hz.first()?, series.lines_hz.last()?);
    Some(Diagnostic {
        code: "evenly-spaced",
        message: format!(
            "{} sines from {first:.4} to {last:.4} Hz are {:.4} Hz apart, as harmonics of a shaft or sidebands of a mesh are; a narrow pole in their series is listed with them",
            series.lines_hz.len(),
            series.spacing_hz
        ),
        hint: Some(
            "state the speed: --speed; or repeat at another speed: a mode keeps its frequency"
                .to_string(),
        ),
    })
}

/// Half-power half-bandwidth above which a pole has structural damping, spectral lines of the record.
const STRUCTURE_LINES: f64 = 10.0;

/// Running speed with the sines removed from the record.
pub struct SpeedOrders<'a> {
    /// Stated running speed.
    pub running: Option<&'a RunningSpeed>,
    /// Removed sines.
    pub tones: &'a [Tone],
    /// Line spacing of the complete record, Hz.
    pub line_hz: f64,
}

impl SpeedOrders<'_> {
    /// Takes the order of a pole that is a mode, not a harmonic. A harmonic has a constant envelope, or a damping interval that includes
    /// zero, or it is much narrower than a structural mode and a sine of that order was removed; if the damping has no interval, a
    /// narrow pole is a harmonic.
    pub fn coincident_order(
        &self,
        harmonic: &mut HarmonicIndicator,
        mode: &ModalParameters,
    ) -> Option<f64> {
        let order = harmonic.order?;
        let matches = |t: &Tone| self.running.and_then(|r| r.order(t.frequency_hz)) == Some(order);
        let is_remnant = || match weak::damping_includes_zero(mode) {
            Some(true) => true,
            Some(false) => !self.is_structural(mode) && self.tones.iter().any(matches),
            None => !self.is_structural(mode),
        };
        match harmonic.is_sine() || is_remnant() {
            true => None,
            false => harmonic.order.take(),
        }
    }

    /// True if a pole is much wider than a spectral line of the record.
    fn is_structural(&self, mode: &ModalParameters) -> bool {
        mode.pole.re.abs() / TAU > STRUCTURE_LINES * self.line_hz
    }

    /// True if a sine was removed within the half-power band of a pole.
    pub fn contains_removed_sine(&self, mode: &ModalParameters) -> bool {
        let half_width_hz = mode.pole.re.abs() / TAU;
        let is_within = |t: &Tone| (t.frequency_hz - mode.frequency_hz()).abs() < half_width_hz;
        self.tones.iter().any(is_within)
    }

    /// True if a pole is the remnant of a removed sine of varying frequency: within two lines of the sine and without structural damping.
    pub fn is_remnant_of_sine(&self, mode: &ModalParameters) -> bool {
        !self.is_structural(mode) && self.is_near_removed_sine(mode.frequency_hz(), self.line_hz)
    }

    /// True if a sine was removed within two lines of a frequency, Hz.
    pub fn is_near_removed_sine(&self, frequency_hz: f64, line_hz: f64) -> bool {
        let is_close = |t: &Tone| (t.frequency_hz - frequency_hz).abs() < 2.0 * line_hz;
        self.tones.iter().any(is_close)
    }
}

/// Warning that lists the modes on orders of the running speed.
pub fn order_warning(modes: &[IdentifiedMode]) -> Option<Diagnostic> {
    let pairs = modes
        .iter()
        .filter_map(|m| m.on_order.map(|o| (m.frequency_hz(), o)));
    let list: Vec<String> = pairs
        .map(|(f, o)| format!("{f:.4} Hz (order {o})"))
        .collect();
    (!list.is_empty()).then(|| Diagnostic {
        code: "mode-on-order",
        message: format!(
            "{}: at an order of the running speed, but accepted as a mode: no sine remains there, and its damping is structural",
            list.join(", ")
        ),
        hint: Some("repeat at another speed: a mode keeps its frequency".to_string()),
    })
}

/// Warning that lists the harmonics of the running speed.
pub fn harmonic_warning(harmonics: &[IdentifiedHarmonic]) -> Option<Diagnostic> {
    let frequencies: Vec<f64> = (harmonics.iter())
        .filter(|h| h.reason != IdentifiedHarmonic::MAINS)
        .map(|h| h.frequency_hz)
        .collect();
    (!frequencies.is_empty()).then(|| Diagnostic {
        code: "harmonic",
        message: format!(
            "{}: sines rather than modes, such as harmonics of a running speed; listed apart from the modes",
            hz_list(&frequencies)
        ),
        hint: Some("repeat at another speed: modes do not move with it".to_string()),
    })
}

/// First frequencies of a list as text, and the number of the others.
pub fn hz_list(frequencies: &[f64]) -> String {
    const MAX_LINES_LISTED: usize = 6;
    let mut list: Vec<String> = (frequencies.iter().take(MAX_LINES_LISTED))
        .map(|f| format!("{f:.4} Hz"))
        .collect();
    if frequencies.len() > MAX_LINES_LISTED {
        list.push(format!("{} more", frequencies.len() - MAX_LINES_LISTED));
    }
    list.join(", ")
}
