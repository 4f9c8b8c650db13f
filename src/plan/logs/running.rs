//! Lines of running speed among what responses alone show: orders of a stated speed, sines, and series of evenly spaced ones.

use std::f64::consts::TAU;

use super::identification_result::{IdentifiedHarmonic, IdentifiedMode};
use super::weak;
use crate::base::error::Diagnostic;
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::operational::harmonics::{HarmonicIndicator, RunningSpeed};
use crate::identify::operational::spacing::{HarmonicSeries, series};
use crate::spectrum::tones::Tone;

/// Lines of the record within which a line has its place in a series.
const LINE_TOLERANCE: f64 = 1.5;

/// Series of evenly spaced sines: of those taken out, and of poles distributed like one.
pub fn evenly_spaced(
    tones: &[Tone],
    modes: &[IdentifiedMode],
    line_hz: f64,
) -> Vec<HarmonicSeries> {
    let poles = modes.iter().filter(|m| is_sine(m));
    let mut lines: Vec<f64> = (tones.iter().map(|t| t.frequency_hz))
        .chain(poles.map(IdentifiedMode::frequency_hz))
        .collect();
    lines.sort_by(f64::total_cmp);
    series(&lines, LINE_TOLERANCE * line_hz)
}

/// Whether a pole is a line of running speed by itself.
pub fn is_sine(mode: &IdentifiedMode) -> bool {
    mode.harmonic
        .as_ref()
        .is_some_and(HarmonicIndicator::is_harmonic)
}

/// Whether a mode is narrow, in its place on a series, and not damped as a structure about a sine taken out there.
pub fn is_on(all: &[HarmonicSeries], mode: &IdentifiedMode, orders: &SpeedOrders) -> bool {
    /// Half-power half-bandwidth over the spacing.
    const NARROW: f64 = 0.05;
    let half_band = mode.mode.pole.re.abs() / TAU;
    let std = mode.mode.frequency_std_hz().unwrap_or(0.0);
    if orders.is_structural(&mode.mode) && orders.contains_removed_sine(&mode.mode) {
        return false;
    }
    all.iter().any(|s| {
        let tolerance = (LINE_TOLERANCE * orders.line_hz)
            .max(std)
            .min(NARROW * s.spacing_hz);
        half_band < NARROW * s.spacing_hz && s.holds(mode.frequency_hz(), tolerance)
    })
}

/// Says which sines are evenly spaced.
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
            "state the speed: --speed; or repeat at another speed: a mode stays where it is"
                .to_string(),
        ),
    })
}

/// A pole whose half-power half-bandwidth exceeds so many lines of the record is damped as a structure is.
const STRUCTURE_LINES: f64 = 10.0;

/// Running speed as known after the removal of sines.
pub struct SpeedOrders<'a> {
    /// The speed as stated.
    pub running: Option<&'a RunningSpeed>,
    /// Sines taken out.
    pub tones: &'a [Tone],
    /// Distance of the lines of the whole record, Hz.
    pub line_hz: f64,
}

impl SpeedOrders<'_> {
    /// Order that coincides with a mode, no longer reported as its own: nothing shows a line there. A line has a constant envelope, a
    /// damping whose interval includes zero, or, where it is much narrower than a structure, had a sine that was removed on that order;
    /// without an uncertainty narrowness suffices.
    pub fn coincident_order(
        &self,
        harmonic: &mut HarmonicIndicator,
        mode: &ModalParameters,
    ) -> Option<f64> {
        let order = harmonic.order?;
        let is_on_it = |t: &Tone| self.running.and_then(|r| r.order(t.frequency_hz)) == Some(order);
        let is_remnant = || match weak::damping_includes_zero(mode) {
            Some(true) => true,
            Some(false) => !self.is_structural(mode) && self.tones.iter().any(is_on_it),
            None => !self.is_structural(mode),
        };
        match harmonic.is_sine() || is_remnant() {
            true => None,
            false => harmonic.order.take(),
        }
    }

    /// Whether a pole is much wider than a line of the record, as a structure is.
    fn is_structural(&self, mode: &ModalParameters) -> bool {
        mode.pole.re.abs() / TAU > STRUCTURE_LINES * self.line_hz
    }

    /// Whether a sine was taken out within the half-power band of a pole.
    pub fn contains_removed_sine(&self, mode: &ModalParameters) -> bool {
        let half_width_hz = mode.pole.re.abs() / TAU;
        let is_within = |t: &Tone| (t.frequency_hz - mode.frequency_hz()).abs() < half_width_hz;
        self.tones.iter().any(is_within)
    }

    /// Whether a pole is what a sine that wanders left when it was taken out: within two lines of it, and not damped as a structure is.
    pub fn is_remnant_of_sine(&self, mode: &ModalParameters) -> bool {
        !self.is_structural(mode) && self.is_near_removed_sine(mode.frequency_hz(), self.line_hz)
    }

    /// Whether a sine within two lines was taken out.
    pub fn is_near_removed_sine(&self, frequency_hz: f64, line_hz: f64) -> bool {
        let near = |t: &Tone| (t.frequency_hz - frequency_hz).abs() < 2.0 * line_hz;
        self.tones.iter().any(near)
    }
}

/// Says which modes lie on orders of the running speed.
pub fn order_warning(modes: &[IdentifiedMode]) -> Option<Diagnostic> {
    let on = modes
        .iter()
        .filter_map(|m| m.on_order.map(|o| (m.frequency_hz(), o)));
    let places: Vec<String> = on.map(|(f, o)| format!("{f:.4} Hz (order {o})")).collect();
    (!places.is_empty()).then(|| Diagnostic {
        code: "mode-on-order",
        message: format!(
            "{}: on an order of the running speed, and a mode all the same: no sine is left there, and its damping is that of a structure",
            places.join(", ")
        ),
        hint: Some("repeat at another speed: a mode stays where it is".to_string()),
    })
}

/// Says that there are lines of running speed.
pub fn harmonic_warning(harmonics: &[IdentifiedHarmonic]) -> Option<Diagnostic> {
    let places: Vec<f64> = (harmonics.iter())
        .filter(|h| h.reason != IdentifiedHarmonic::MAINS)
        .map(|h| h.frequency_hz)
        .collect();
    (!places.is_empty()).then(|| Diagnostic {
        code: "harmonic",
        message: format!(
            "{}: like running speed, and listed apart from the modes",
            hz_list(&places)
        ),
        hint: Some("repeat at another speed: what moves with it is no mode".to_string()),
    })
}

/// The first few frequencies of a list, and how many more there are.
pub fn hz_list(frequencies: &[f64]) -> String {
    const MAX_LINES_LISTED: usize = 6;
    let mut places: Vec<String> = (frequencies.iter().take(MAX_LINES_LISTED))
        .map(|f| format!("{f:.4} Hz"))
        .collect();
    if frequencies.len() > MAX_LINES_LISTED {
        places.push(format!("{} more", frequencies.len() - MAX_LINES_LISTED));
    }
    places.join(", ")
}
