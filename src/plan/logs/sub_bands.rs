//! pLSCF in overlapping sub-bands of a wide band; a mode must have a pole in two of them.
//!
//! One polynomial over a wide band fits the largest responses and misses weak modes. A polynomial over a sub-band fits both, and
//! its noise poles differ from those of other sub-bands. So every spectral line lies in two sub-bands.

use std::f64::consts::{PI, TAU};

use crate::base::error::Error;
use crate::identify::modal::candidates::OrderPoles;
use crate::identify::modal::measured_frf::MeasuredFrf;
use crate::identify::modal::plscf::{PlscfOptions, plscf};
use crate::identify::modal::selection::{SelectedMode, SelectionRule, select_modes};
use crate::numeric::sorting::sort_ascending;

/// Spectral lines of half a sub-band: a sub-band has thirty for each coefficient of the highest order.
const HALF_BAND_LINES: usize = 1200;

/// Minimum number of half sub-bands of a wide band.
const MIN_HALF_BANDS: usize = 5;

/// Frequency responses within a sub-band.
pub struct SubBand<'a> {
    responses: MeasuredFrf<'a>,
}

impl SubBand<'_> {
    fn contains(&self, frequency_hz: f64) -> bool {
        let (low, high) = self.responses.band_limits_hz();
        (low..=high).contains(&frequency_hz)
    }

    /// Distance of a frequency from the centre, Hz.
    fn distance_from_centre(&self, frequency_hz: f64) -> f64 {
        let (low, high) = self.responses.band_limits_hz();
        (frequency_hz - 0.5 * (low + high)).abs()
    }
}

/// Sub-bands of a wide band, overlapping by half; `None` for a band of fewer lines than five half sub-bands.
pub fn sub_bands<'a>(measured: &MeasuredFrf<'a>) -> Option<Vec<SubBand<'a>>> {
    let lines = measured.frequency_hz();
    let halves = lines.len() / HALF_BAND_LINES;
    if halves < MIN_HALF_BANDS {
        return None;
    }
    let edge = |h: usize| (h * lines.len() / halves).min(lines.len() - 1);
    let sub_band = |(from, to): (usize, usize)| {
        let responses = measured.band(lines[edge(from)], lines[edge(to)]).ok()?;
        Some(SubBand { responses })
    };
    let pairs = (0..halves - 1).map(|h| (h, h + 2));
    std::iter::once((0, 1))
        .chain(pairs)
        .chain([(halves - 1, halves)])
        .map(sub_band)
        .collect()
}

/// Poles of all orders by pLSCF in each sub-band, and the modes identified in two sub-bands, from the one with the nearest centre.
///
/// # Errors
/// As [`plscf`].
pub fn plscf_by_sub_band(
    bands: &[SubBand],
    rule: &SelectionRule,
) -> Result<(Vec<OrderPoles>, Vec<SelectedMode>), Error> {
    let mut poles: Vec<OrderPoles> = Vec::new();
    let mut selected: Vec<Vec<SelectedMode>> = Vec::new();
    for (k, band) in bands.iter().enumerate() {
        let orders = plscf(&band.responses, &PlscfOptions::default())?;
        selected.push(select_modes(
            &orders,
            band.responses.frequency_resolution_hz(),
            rule,
        ));
        for (at, order) in orders.into_iter().enumerate() {
            let is_nearest = |f: f64| nearest(bands, f) == Some(k);
            let nearest_poles = order
                .poles
                .into_iter()
                .filter(|p| is_nearest(p.pole.im / TAU))
                .collect();
            match poles.get_mut(at) {
                Some(merged) => {
                    let previous = std::mem::take(&mut merged.poles);
                    *merged = OrderPoles::new(merged.order, [previous, nearest_poles].concat());
                }
                None => poles.push(OrderPoles::new(order.order, nearest_poles)),
            }
        }
    }
    let mut modes = Vec::new();
    for (k, candidates) in selected.iter().enumerate() {
        for mode in candidates {
            let f = mode.mode.damped_frequency_hz();
            let others = (0..bands.len()).filter(|&o| o != k && bands[o].contains(f));
            let agree = others.into_iter().any(|o| {
                let half_width = |m: &SelectedMode| {
                    m.mode.pole.re.abs() + PI * bands[o].responses.frequency_resolution_hz()
                };
                (selected[o].iter()).any(|m| {
                    (m.mode.pole - mode.mode.pole).norm()
                        < rule.cluster_cut * (half_width(m) + half_width(mode))
                })
            });
            if agree && nearest(bands, f) == Some(k) {
                modes.push(mode.clone());
            }
        }
    }
    sort_ascending(&mut modes, |a| a.mode.pole.norm());
    Ok((poles, modes))
}

/// Index of the sub-band with the nearest centre among those that contain a frequency.
fn nearest(bands: &[SubBand], frequency_hz: f64) -> Option<usize> {
    let distance = |&k: &usize| bands[k].distance_from_centre(frequency_hz);
    (0..bands.len())
        .filter(|&k| bands[k].contains(frequency_hz))
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Selection rule as a sentence of a report.
pub fn rule_text(bands: &[SubBand], rule: &SelectionRule) -> String {
    let count = bands.len();
    format!(
        "{count} sub-bands overlapping by half, a mode must be found in two; in each {}",
        rule.rule_text()
    )
}
