//! Modal identification from FRFs: poles by model order or by peak, then mode shapes and residues by LSFD.

use std::f64::consts::TAU;

use super::identification_result::{
    Evidence, IdentifiedMode, PeakPicking, PickedPeak, StabilisationDiagram,
};
use super::identify_study::IdentifyStudy;
use super::method::IdentificationMethod;
use super::sub_bands;
use super::transfer_functions::{PartialFractions, transfer_functions, without_window};
use super::weak::columns;
use crate::base::error::{Diagnostic, Error};
use crate::identify::modal::candidates::OrderPoles;
use crate::identify::modal::lsfd::{self, ResidueFit};
use crate::identify::modal::measured_frf::MeasuredFrf;
use crate::identify::modal::plscf::{PlscfOptions, plscf};
use crate::identify::modal::selection::{SelectionRule, select_modes};
use crate::identify::modal::stabilisation::{StabilisationTolerances, stabilisation};
use crate::identify::modal::{lsce, rfp, sdof};
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::transfer::function::TransferFunction;
use crate::numeric::Complex;
use crate::numeric::sorting::{sort_ascending, sort_descending};
use crate::recording::channel_unit::ResponseKind;
use crate::recording::frequency_responses::FrequencyResponses;
use crate::spectrum::integrate::MotionQuantity;

/// Result of a modal identification from frequency responses.
pub struct ModalIdentification {
    /// Modes, corrected for the exponential window.
    pub modes: Vec<IdentifiedMode>,
    /// Selection rule that separates modes from other poles.
    pub selection_rule: String,
    /// Stabilisation diagram, or picked peaks.
    pub evidence: Evidence,
    /// Transfer functions, corrected for the exponential window.
    pub functions: Vec<TransferFunction>,
    /// Relative rms misfit by response.
    pub fit_error: Vec<f64>,
    /// Data-quality warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Maximum model order of LSCE and RFP: 30 modes.
const DEFAULT_MAX_ORDER: usize = 60;

/// Minimum height of a peak for a circle fit, relative to the largest peak.
const MIN_PEAK_SHARE: f64 = 0.05;

/// Identifies poles, shapes and residues from the spectral lines inside the band, by pLSCF, LSCE, RFP or circle fits.
///
/// # Errors
/// Errors of the method; responses without information.
pub fn identify_modal(
    method: IdentificationMethod,
    responses: &FrequencyResponses,
    band_hz: (f64, f64),
    study: &IdentifyStudy,
) -> Result<ModalIdentification, Error> {
    let is_line = |f: f64| f > 0.0 && (band_hz.0..=band_hz.1).contains(&f);
    let indices: Vec<usize> = (0..responses.frequency_hz.len())
        .filter(|&k| is_line(responses.frequency_hz[k]) && responses.is_determined(k))
        .collect();
    let lines: Vec<f64> = indices.iter().map(|&k| responses.frequency_hz[k]).collect();
    let at_lines = |&f: &usize| -> Vec<Complex> {
        let value = &responses.responses[f].values;
        indices.iter().map(|&k| value[k]).collect()
    };
    let table = responses.index_matrix();
    let rows: Vec<Vec<Vec<Complex>>> = (table.iter())
        .map(|row| row.iter().map(at_lines).collect())
        .collect();
    let measured = MeasuredFrf::new(&lines, &rows)?;
    let values = rows.concat();
    let level = sdof::summed_response(&values);
    let quantities = motion_candidates(responses, study);
    let (mut modes, selection_rule, evidence) = match method {
        IdentificationMethod::Circle => circle_fits(&lines, &values, level, quantities[0]),
        _ => {
            let rule = SelectionRule::default();
            let (orders, selected, rule_text) = match sub_bands::sub_bands(&measured)
                .filter(|_| method == IdentificationMethod::Plscf)
            {
                Some(bands) => {
                    let (orders, selected) = sub_bands::plscf_by_sub_band(&bands, &rule)?;
                    (orders, selected, sub_bands::rule_text(&bands, &rule))
                }
                None => {
                    let orders = poles_by_order(method, &measured)?;
                    let selected = select_modes(&orders, measured.frequency_resolution_hz(), &rule);
                    (orders, selected, rule.rule_text())
                }
            };
            let modes = selected.into_iter().map(|s| IdentifiedMode {
                presence: Some(s.presence),
                scatter_hz: Some(s.scatter_hz),
                ..IdentifiedMode::from(s.mode)
            });
            let diagram = StabilisationDiagram {
                poles: stabilisation(&orders, &StabilisationTolerances::default()),
                level: (lines.clone(), level),
                omitted: Vec::new(),
            };
            (modes.collect(), rule_text, Evidence::Diagram(diagram))
        }
    };
    limit_modes(&mut modes, study.order);
    let mut identification = ModalIdentification {
        modes,
        selection_rule,
        evidence,
        functions: Vec::new(),
        fit_error: Vec::new(),
        diagnostics: Vec::new(),
    };
    identification.add_residues(responses, &table, &measured, &quantities)?;
    if let Evidence::Diagram(diagram) = &mut identification.evidence {
        let rule = SelectionRule::default();
        diagram.omitted = columns(&diagram.poles, &identification.modes, band_hz, &rule);
    }
    Ok(identification)
}

/// Reduces the modes to the requested number, those with the largest presence over the orders first, and sorts them by frequency.
fn limit_modes(modes: &mut Vec<IdentifiedMode>, order: Option<usize>) {
    sort_descending(modes, |m| m.presence.unwrap_or(0.0));
    modes.truncate(order.unwrap_or(usize::MAX));
    sort_ascending(modes, |a| a.frequency_hz());
}

/// Candidate motion quantities of the responses: as declared, by their units, else displacement or acceleration.
fn motion_candidates(responses: &FrequencyResponses, study: &IdentifyStudy) -> Vec<MotionQuantity> {
    let quantity = |derivative_order: u8| match derivative_order {
        0 => MotionQuantity::Displacement,
        1 => MotionQuantity::Velocity,
        _ => MotionQuantity::Acceleration,
    };
    let kinds: Vec<ResponseKind> = (responses.responses.iter())
        .map(|f| ResponseKind::from_units(f.input.as_ref().map_or("", |i| &i.unit), &f.output.unit))
        .collect();
    match (study.derivative, kinds.first()) {
        (Some(order), _) => vec![quantity(order)],
        (None, Some(ResponseKind::MotionOverForce(order)))
            if kinds.iter().all(|k| k == &kinds[0]) =>
        {
            vec![quantity(*order)]
        }
        (None, Some(ResponseKind::Unknown)) => {
            vec![MotionQuantity::Displacement, MotionQuantity::Acceleration]
        }
        _ => vec![MotionQuantity::Displacement],
    }
}

/// Poles of every model order, by the method.
fn poles_by_order(
    method: IdentificationMethod,
    measured: &MeasuredFrf,
) -> Result<Vec<OrderPoles>, Error> {
    let n_lines = measured.n_lines();
    match method {
        // LSCE limits its order to 2/5 of the number of spectral lines.
        IdentificationMethod::Lsce => {
            lsce::lsce(measured, DEFAULT_MAX_ORDER.min(n_lines * 2 / 5) / 2 * 2)
        }
        IdentificationMethod::Rfp => rfp::rfp(
            measured,
            DEFAULT_MAX_ORDER.min((n_lines / 2).saturating_sub(2)) / 2 * 2,
        ),
        _ => plscf(measured, &PlscfOptions::default()),
    }
}

/// Modes by a circle fit of each peak, checked by the half-power method, in order of falling peak height.
fn circle_fits(
    lines: &[f64],
    values: &[Vec<Complex>],
    level: Vec<f64>,
    quantity: MotionQuantity,
) -> (Vec<IdentifiedMode>, String, Evidence) {
    let (mut modes, mut picked) = (Vec::new(), Vec::new());
    let band_hz = (lines[0], lines[lines.len() - 1]);
    for (peak, (from, to)) in sdof::separate_peaks(&level, MIN_PEAK_SHARE) {
        let share = |r: &&Vec<Complex>| {
            let largest = r
                .iter()
                .map(|z| z.norm_sqr())
                .fold(f64::MIN_POSITIVE, f64::max);
            r[peak].norm_sqr() / largest
        };
        let Some(response) = (values.iter()).max_by(|a, b| share(a).total_cmp(&share(b))) else {
            continue;
        };
        let half_power = sdof::half_power(lines, response, peak, quantity).ok();
        let fit = sdof::circle_fit(&lines[from..=to], &response[from..=to], quantity);
        let limit = SelectionRule::default().max_damping_ratio;
        let reason = match &fit {
            Err(error) => error.message.clone(),
            Ok(mode) if mode.damping_ratio() > limit => format!(
                "the circle fit gives a damping ratio of {:.0} % (limit {:.0} %)",
                100.0 * mode.damping_ratio(),
                100.0 * limit
            ),
            Ok(mode) if !natural_frequency_is_in_band(mode.pole, band_hz) => {
                "the circle fit gives a natural frequency outside the band".to_string()
            }
            Ok(mode) => half_power
                .as_ref()
                .and_then(|half| method_disagreement(mode, half))
                .unwrap_or_default(),
        };
        let is_mode = reason.is_empty();
        picked.push(PickedPeak {
            frequency_hz: lines[peak],
            prominence: None,
            half_power: half_power.map(|m| (m.frequency_hz(), m.damping_ratio())),
            bell: None,
            reason,
        });
        let mode = fit.ok().filter(|_| is_mode).map(IdentifiedMode::from);
        modes.extend(mode.map(|mode| (level[peak], mode)));
    }
    let rule = format!(
        "peaks of the sum of all responses above {} % of its largest value, none inside the half-power band of a higher one; a circle \
         through the lines within half power of each, and the half-power width for comparison",
        100.0 * MIN_PEAK_SHARE
    );
    let peaks = PeakPicking {
        peaks: picked,
        level: (lines.to_vec(), level),
        below: Vec::new(),
    };
    sort_descending(&mut modes, |(level, _)| *level);
    let modes = modes.into_iter().map(|(_, mode)| mode).collect();
    (modes, rule, Evidence::Peaks(peaks))
}

/// Message where circle fit and half-power method differ by more than the residual of a neighbouring mode explains.
fn method_disagreement(circle: &ModalParameters, half_power: &ModalParameters) -> Option<String> {
    const MAX_FREQUENCY_DIFFERENCE: f64 = 1.0; // half-power half-bandwidths of the wider resonance
    const MAX_DAMPING_RATIO_FACTOR: f64 = 2.0;
    let half_width_hz = |m: &ModalParameters| m.frequency_hz() * m.damping_ratio();
    let distance_hz = (circle.frequency_hz() - half_power.frequency_hz()).abs();
    let ratio = circle.damping_ratio() / half_power.damping_ratio();
    let agree = distance_hz
        < MAX_FREQUENCY_DIFFERENCE * half_width_hz(circle).max(half_width_hz(half_power))
        && (1.0 / MAX_DAMPING_RATIO_FACTOR..=MAX_DAMPING_RATIO_FACTOR).contains(&ratio);
    (!agree).then(|| {
        let text = |m: &ModalParameters| {
            let (f, d) = (m.frequency_hz(), 100.0 * m.damping_ratio());
            format!("{f:.4} Hz and {d:.2} %")
        };
        format!(
            "the circle fit gives {}, half power {}: this is not a single resonance",
            text(circle),
            text(half_power)
        )
    })
}

impl ModalIdentification {
    /// Adds shapes, transfer functions and misfits, in the motion quantity of least misfit.
    fn add_residues(
        &mut self,
        responses: &FrequencyResponses,
        table: &[Vec<usize>],
        measured: &MeasuredFrf,
        quantities: &[MotionQuantity],
    ) -> Result<(), Error> {
        let poles: Vec<Complex> = self.modes.iter().map(|m| m.mode.pole).collect();
        if poles.is_empty() {
            return Ok(());
        }
        let mut best: Option<(ResidueFit, Vec<f64>)> = None;
        for &quantity in quantities {
            let fit = lsfd::fit_residues(measured, &poles, quantity)?;
            let mut errors = vec![0.0; responses.responses.len()];
            for (o, i, f) in table_cells(table) {
                errors[f] = fit.misfit(measured, o, i);
            }
            let cost = |e: &[f64]| e.iter().map(|x| x * x).sum::<f64>();
            if best.as_ref().is_none_or(|b| cost(&errors) < cost(&b.1)) {
                best = Some((fit, errors));
            }
        }
        let Some((fit, errors)) = best else {
            return Ok(());
        };
        let mut residues = vec![Vec::new(); responses.responses.len()];
        let mut terms = vec![[0.0; 2]; responses.responses.len()];
        for (o, i, f) in table_cells(table) {
            residues[f] = fit.residues.iter().map(|r| r[(o, i)]).collect();
            terms[f] = [fit.lower_residual[(o, i)], fit.upper_residual[(o, i)]];
        }
        self.functions = transfer_functions(
            responses,
            &PartialFractions {
                poles: &poles,
                residues: &residues,
                residual_terms: &terms,
                derivative: fit.motion.derivative_order() as u8,
                delay_s: &[],
                fit_error: &errors,
            },
        )?;
        for (k, mode) in self.modes.iter_mut().enumerate() {
            mode.set_shape(fit.mode_shape(k)?);
            mode.mode = without_window(&mode.mode, responses.window_decay);
        }
        self.fit_error = errors;
        Ok(())
    }
}

/// Output, input and response index of every cell of the FRF matrix.
fn table_cells(table: &[Vec<usize>]) -> impl Iterator<Item = (usize, usize, usize)> {
    let row = |(o, row): (usize, &Vec<usize>)| {
        let cells: Vec<_> = row.iter().enumerate().map(|(i, &f)| (o, i, f)).collect();
        cells
    };
    table.iter().enumerate().flat_map(row)
}

/// Whether the natural frequency |λ|/2π of a pole lies within a band, Hz.
pub fn natural_frequency_is_in_band(pole: Complex, (low, high): (f64, f64)) -> bool {
    (low..=high).contains(&(pole.norm() / TAU))
}
