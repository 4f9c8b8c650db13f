//! pLSCF by overlapping sub-bands of a wide band; modes kept where two sub-bands agree.
//!
//! One polynomial over many lines spends its order on what is large and sees little of the rest; over a part it sees all, and
//! what noise makes it see besides differs from part to part. So every line lies in two parts, and a mode is what both find.

use std::f64::consts::{PI, TAU};

use crate::base::error::Error;
use crate::identify::modal::candidates::OrderPoles;
use crate::identify::modal::measured_frf::MeasuredFrf;
use crate::identify::modal::plscf::{PlscfOptions, plscf as poles};
use crate::identify::modal::selection::{SelectedMode, SelectionRule, select_modes};
use crate::numeric::sorting::sort_rising;

/// Lines of half a part: thirty for each coefficient of the highest order in a whole one.
const HALF_BAND_LINES: usize = 1200;

/// With fewer halves the band is not wide.
const MIN_HALF_BANDS: usize = 5;

/// Frequency responses within a sub-band.
pub struct SubBand<'a> {
    lines: MeasuredFrf<'a>,
}

impl SubBand<'_> {
    fn contains(&self, frequency_hz: f64) -> bool {
        let (low, high) = self.lines.band_limits_hz();
        (low..=high).contains(&frequency_hz)
    }

    /// Distance of a frequency from the centre.
    fn distance_from_centre(&self, frequency_hz: f64) -> f64 {
        let (low, high) = self.lines.band_limits_hz();
        (frequency_hz - 0.5 * (low + high)).abs()
    }
}

/// Sub-bands of a wide band, overlapping by half; none where it has fewer lines than five half sub-bands.
pub fn sub_bands<'a>(measured: &MeasuredFrf<'a>) -> Option<Vec<SubBand<'a>>> {
    let lines = measured.frequency_hz();
    let halves = lines.len() / HALF_BAND_LINES;
    if halves < MIN_HALF_BANDS {
        return None;
    }
    let edge = |h: usize| (h * lines.len() / halves).min(lines.len() - 1);
    let part = |(from, to): (usize, usize)| {
        let lines = measured.band(lines[edge(from)], lines[edge(to)]).ok()?;
        Some(SubBand { lines })
    };
    let pairs = (0..halves - 1).map(|h| (h, h + 2));
    std::iter::once((0, 1))
        .chain(pairs)
        .chain([(halves - 1, halves)])
        .map(part)
        .collect()
}

/// pLSCF in each sub-band: poles of all orders, and the modes found in two sub-bands, each from the one whose centre is nearest.
///
/// # Errors
/// As [`poles`].
pub fn plscf_by_sub_band(
    parts: &[SubBand],
    rule: &SelectionRule,
) -> Result<(Vec<OrderPoles>, Vec<SelectedMode>), Error> {
    let mut all: Vec<OrderPoles> = Vec::new();
    let mut found: Vec<Vec<SelectedMode>> = Vec::new();
    for (k, part) in parts.iter().enumerate() {
        let orders = poles(&part.lines, &PlscfOptions::default())?;
        found.push(select_modes(
            &orders,
            part.lines.frequency_resolution_hz(),
            rule,
        ));
        for (at, order) in orders.into_iter().enumerate() {
            let own = |f: f64| nearest(parts, f) == Some(k);
            let kept = order
                .poles
                .into_iter()
                .filter(|p| own(p.pole.im / TAU))
                .collect();
            match all.get_mut(at) {
                Some(known) => {
                    let before = std::mem::take(&mut known.poles);
                    *known = OrderPoles::new(known.order, [before, kept].concat());
                }
                None => all.push(OrderPoles::new(order.order, kept)),
            }
        }
    }
    let mut modes = Vec::new();
    for (k, own) in found.iter().enumerate() {
        for mode in own {
            let f = mode.mode.damped_frequency_hz();
            let others = (0..parts.len()).filter(|&o| o != k && parts[o].contains(f));
            let agree = others.into_iter().any(|o| {
                let reach = |m: &SelectedMode| {
                    m.mode.pole.re.abs() + PI * parts[o].lines.frequency_resolution_hz()
                };
                (found[o].iter()).any(|m| {
                    (m.mode.pole - mode.mode.pole).norm()
                        < rule.cluster_cut * (reach(m) + reach(mode))
                })
            });
            if agree && nearest(parts, f) == Some(k) {
                modes.push(mode.clone());
            }
        }
    }
    sort_rising(&mut modes, |a| a.mode.pole.norm());
    Ok((all, modes))
}

/// The part in whose middle a frequency lies.
fn nearest(parts: &[SubBand], frequency_hz: f64) -> Option<usize> {
    let off = |&k: &usize| parts[k].distance_from_centre(frequency_hz);
    (0..parts.len())
        .filter(|&k| parts[k].contains(frequency_hz))
        .min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// The selection rule as text of a report.
pub fn rule_text(parts: &[SubBand], rule: &SelectionRule) -> String {
    let count = parts.len();
    format!(
        "{count} sub-bands overlapping by half, a mode must be found in two; in each {}",
        rule.rule_text()
    )
}
