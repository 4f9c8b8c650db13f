//! The answer of a subspace identification: modes, the diagram, rejected poles with their reasons, and what limits it.

use std::f64::consts::TAU;

use super::found::{Diagram, Evidence, FoundMode, FromSignals};
use super::modal::within;
use super::running::{Orders, hz_list};
use crate::base::error::Warning;
use crate::identify::modal::stabilisation::{DiagramPole, Tolerances, stabilisation};
use crate::identify::operational::decomposition::Decomposition;
use crate::identify::operational::rungs::{OperationalMode, Pair};
use crate::identify::operational::subspace::{HIGHEST_ORDER, Subspace};

/// The modes inside the band, with the level of the spectra behind the diagram.
pub fn of_subspace(
    found: Subspace,
    orders_known: &Orders,
    level: Option<Decomposition>,
    band_hz: (f64, f64),
) -> FromSignals {
    let reach = found.reach_hz();
    let count = found.rungs.len();
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
        HIGHEST_ORDER,
    );
    let inside = |m: &OperationalMode| within(m.mode.pole, band_hz);
    let modes: Vec<FoundMode> = (found.modes.into_iter().filter(inside))
        .map(|mut m| FoundMode {
            presence: Some(m.presence),
            scatter_hz: Some(m.scatter_hz),
            on_order: orders_known.beneath(&mut m.harmonic, m.mode.pole.re.abs() / TAU),
            harmonic: Some(m.harmonic),
            ..FoundMode::from(m.mode)
        })
        .collect();
    let mut warnings = found.warnings;
    warnings.extend(of_pairs(&found.pairs, band_hz));
    if let Some(level) = &level {
        warnings.extend(of_peaks_without_modes(level, &modes, reach, band_hz));
    }
    // Of every frequency the poles of one rung, the fastest that shows it well.
    let mut poles = Vec::new();
    for (k, (rung, orders)) in found.rungs.iter().zip(&found.orders).enumerate() {
        let low_hz = if k + 1 == count {
            0.0
        } else {
            0.5 * rung.band_hz.1
        };
        let shown = |p: &DiagramPole| {
            p.frequency_hz > low_hz && (p.frequency_hz <= rung.band_hz.1 || k == 0)
        };
        poles.extend(
            stabilisation(orders, &Tolerances::default())
                .into_iter()
                .filter(shown),
        );
    }
    poles.sort_by(|a, b| (a.order.cmp(&b.order)).then(a.frequency_hz.total_cmp(&b.frequency_hz)));
    FromSignals {
        modes,
        harmonics: Vec::new(),
        rule,
        evidence: Evidence::Diagram(Diagram {
            poles,
            level: level.map_or((Vec::new(), Vec::new()), Decomposition::largest_values),
            omitted: (found.rejected.iter())
                .filter(|r| within(r.pole, band_hz))
                .map(|r| (r.pole, r.reason))
                .collect(),
        }),
        warnings,
    }
}

/// Says where two modes may be one, or one two.
fn of_pairs(pairs: &[Pair], band_hz: (f64, f64)) -> Vec<Warning> {
    let inside = |p: &&Pair| p.one_hz >= band_hz.0 && p.one_hz <= band_hz.1;
    let warning = |p: &Pair| Warning {
        code: "close-pair",
        message: format!(
            "{:.4} and {:.4} Hz at one sample rate are one mode, {:.4} Hz, at another, and {}",
            p.two_hz.0.min(p.two_hz.1),
            p.two_hz.0.max(p.two_hz.1),
            p.one_hz,
            match p.are_two {
                true => "listed as two: they are further apart than they are uncertain",
                false => "listed as one: the two are no further apart than they are uncertain",
            }
        ),
        hint: Some("take a longer record, or sensors where the two shapes differ".to_string()),
    };
    pairs.iter().filter(inside).map(warning).collect()
}

/// Says which peaks of the spectra no mode explains.
fn of_peaks_without_modes(
    level: &Decomposition,
    modes: &[FoundMode],
    reach: (f64, f64),
    band_hz: (f64, f64),
) -> Vec<Warning> {
    /// Lines of the spectra, and half-power half-bandwidths of a mode, within which a peak is its own.
    const OWN: (f64, f64) = (4.0, 2.0);
    let line_hz = level.frequency_hz.get(1).copied().unwrap_or(0.0);
    let is_own = |f: f64, m: &FoundMode| {
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
        (!places.is_empty()).then(|| Warning {
            code: "peak-without-mode",
            message: format!("{}: {message}", hz_list(&places)),
            hint: Some(hint.to_string()),
        })
    };
    let inside = warning(
        inside,
        "the spectra peak there, and no mode is certain enough",
        "look at the stable poles listed with their reasons (--json), take a longer record, or --method efdd",
    );
    let outside = warning(
        outside,
        &format!(
            "the spectra peak there, beyond the {:.4} to {:.4} Hz in which modes are sought",
            reach.0, reach.1
        ),
        "take a longer record for lower, a faster one for higher modes, or --method efdd",
    );
    inside.into_iter().chain(outside).collect()
}
