//! Subspace identification: modes, the stabilisation diagram, rejected poles with their reasons, and the limits of the method.

use std::f64::consts::TAU;

use super::frf_modes::natural_frequency_is_in_band;
use super::identification_result::{
    Evidence, IdentifiedMode, SignalIdentification, StabilisationDiagram,
};
use super::running::{SpeedOrders, hz_list};
use crate::base::error::Diagnostic;
use crate::identify::modal::stabilisation::{
    StabilisationPole, StabilisationTolerances, stabilisation,
};
use crate::identify::operational::fdd::FddEstimate;
use crate::identify::operational::merge_levels::{OperationalMode, UnresolvedPair};
use crate::identify::operational::shared_peaks;
use crate::identify::operational::ssi::{MAX_ORDER, SsiEstimate};

/// The modes inside the band, with the level of the spectra behind the diagram.
pub fn from_ssi(
    found: SsiEstimate,
    orders_known: &SpeedOrders,
    level: Option<FddEstimate>,
    band_hz: (f64, f64),
) -> SignalIdentification {
    let reach = found.reach_hz();
    let count = found.levels.len();
    let rates = match count {
        1 => "one sample rate".to_string(),
        _ => format!("{count} sample rates an octave apart"),
    };
    let rule = format!(
        "modes are sought from {:.4} to {:.4} Hz at {rates}, orders up to {}: poles that a neighbouring order repeats are clustered by \
         frequency and shape, and a cluster with poles of 35 % of the orders is a mode where its frequency moves by less than its \
         bandwidth when parts of the record are left out",
        reach.0.max(band_hz.0),
        reach.1.min(band_hz.1),
        MAX_ORDER,
    );
    let inside = |m: &OperationalMode| natural_frequency_is_in_band(m.mode.pole, band_hz);
    let modes: Vec<IdentifiedMode> = (found.modes.into_iter().filter(inside))
        .map(|mut m| IdentifiedMode {
            presence: Some(m.presence),
            scatter_hz: Some(m.scatter_hz),
            on_order: orders_known.coincident_order(&mut m.harmonic, &m.mode),
            harmonic: Some(m.harmonic),
            ..IdentifiedMode::from(m.mode)
        })
        .collect();
    let mut diagnostics = found.diagnostics;
    diagnostics.extend(pair_warnings(&found.pairs, band_hz));
    if let Some(level) = &level {
        diagnostics.extend(shared_peak_warnings(level, &modes, &found.pairs));
        diagnostics.extend(unexplained_peak_warnings(level, &modes, reach, band_hz));
    }
    // Of every frequency the poles of one rung, the fastest that shows it well.
    let mut poles = Vec::new();
    for (k, (rung, orders)) in found.levels.iter().zip(&found.orders).enumerate() {
        let low_hz = if k + 1 == count {
            0.0
        } else {
            0.5 * rung.band_hz.1
        };
        let shown = |p: &StabilisationPole| {
            p.frequency_hz > low_hz && (p.frequency_hz <= rung.band_hz.1 || k == 0)
        };
        poles.extend(
            stabilisation(orders, &StabilisationTolerances::default())
                .into_iter()
                .filter(shown),
        );
    }
    poles.sort_by(|a, b| (a.order.cmp(&b.order)).then(a.frequency_hz.total_cmp(&b.frequency_hz)));
    SignalIdentification {
        modes,
        weak: Vec::new(),
        harmonics: Vec::new(),
        selection_rule: rule,
        evidence: Evidence::Diagram(StabilisationDiagram {
            poles,
            level: level.map_or((Vec::new(), Vec::new()), FddEstimate::largest_values),
            omitted: (found.rejected.iter())
                .filter(|r| natural_frequency_is_in_band(r.pole, band_hz))
                .map(|r| (r.pole, r.reason))
                .collect(),
        }),
        diagnostics,
    }
}

/// Says where two modes may be one, or one two.
fn pair_warnings(pairs: &[UnresolvedPair], band_hz: (f64, f64)) -> Vec<Diagnostic> {
    let inside = |p: &&UnresolvedPair| p.single_hz >= band_hz.0 && p.single_hz <= band_hz.1;
    let warning = |p: &UnresolvedPair| Diagnostic {
        code: "close-pair",
        message: format!(
            "{:.4} and {:.4} Hz at one sample rate are one mode, {:.4} Hz, at another, and {}",
            p.pair_hz.0.min(p.pair_hz.1),
            p.pair_hz.0.max(p.pair_hz.1),
            p.single_hz,
            match p.is_resolved {
                true => "listed as two: their distance exceeds their uncertainty",
                false => "listed as one: their distance is within their uncertainty",
            }
        ),
        hint: Some("take a longer record, or sensors where the two shapes differ".to_string()),
    };
    pairs.iter().filter(inside).map(warning).collect()
}

/// Says which modes share their peak of the spectra with another that is not found.
fn shared_peak_warnings(
    level: &FddEstimate,
    modes: &[IdentifiedMode],
    pairs: &[UnresolvedPair],
) -> Vec<Diagnostic> {
    let warning = |(k, mode): (usize, &IdentifiedMode)| {
        let (f, half_band_hz) = (mode.frequency_hz(), mode.mode.pole.re.abs() / TAU);
        let reach = shared_peaks::reach_hz(level, half_band_hz);
        let is_near = |other_hz: f64| (other_hz - f).abs() <= reach;
        let is_known = pairs.iter().any(|p| is_near(p.single_hz))
            || (modes.iter().enumerate()).any(|(o, m)| o != k && is_near(m.frequency_hz()));
        let ratio = shared_peaks::second_mode_ratio(level, f, half_band_hz)?;
        (!is_known).then(|| Diagnostic {
            code: "close-pair",
            message: format!(
                "{f:.4} Hz may be two modes: the second singular value of the spectra peaks there too, at {:.0} % of the first",
                100.0 * ratio
            ),
            hint: Some("take a longer record, or sensors where the two shapes differ".to_string()),
        })
    };
    modes.iter().enumerate().filter_map(warning).collect()
}

/// Says which peaks of the spectra no mode explains.
fn unexplained_peak_warnings(
    level: &FddEstimate,
    modes: &[IdentifiedMode],
    reach: (f64, f64),
    band_hz: (f64, f64),
) -> Vec<Diagnostic> {
    /// Lines of the spectra, and half-power half-bandwidths of a mode, within which a peak is its own.
    const OWN: (f64, f64) = (4.0, 2.0);
    let line_hz = level.frequency_hz.get(1).copied().unwrap_or(0.0);
    let is_own = |f: f64, m: &IdentifiedMode| {
        let half_band = m.mode.pole.re.abs() / TAU;
        (m.frequency_hz() - f).abs() < (OWN.0 * line_hz).max(OWN.1 * half_band)
    };
    let mut unexplained = (level.peaks.iter())
        .filter(|p| p.bell.is_some() && !p.harmonic.is_harmonic())
        .map(|p| p.frequency_hz)
        .filter(|f| (band_hz.0..=band_hz.1).contains(f))
        .filter(|f| !modes.iter().any(|m| is_own(*f, m)))
        .peekable();
    if unexplained.peek().is_none() {
        return Vec::new();
    }
    let (inside, outside): (Vec<f64>, Vec<f64>) =
        unexplained.partition(|f| (reach.0..=reach.1).contains(f));
    let warning = |places: Vec<f64>, message: &str, hint: &str| {
        (!places.is_empty()).then(|| Diagnostic {
            code: "peak-without-mode",
            message: format!("{}: {message}", hz_list(&places)),
            hint: Some(hint.to_string()),
        })
    };
    let inside = warning(
        inside,
        "the spectra peak there, but no mode is certain enough",
        "check the stable poles listed with their reasons (--json), take a longer record, or --method efdd",
    );
    let outside = warning(
        outside,
        &format!(
            "the spectra peak there, beyond the {:.4} to {:.4} Hz in which modes are sought",
            reach.0, reach.1
        ),
        "take a longer record for lower, a higher rate for higher modes, or --method efdd",
    );
    inside.into_iter().chain(outside).collect()
}
