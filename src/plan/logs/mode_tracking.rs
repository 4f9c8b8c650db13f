//! Modes that change in time: recursive least squares, modes joined to tracks.

use super::frf_modes::natural_frequency_is_in_band;
use super::identification_result::{Evidence, IdentifiedMode, ModeTracking, SignalIdentification};
use super::identify_study::IdentifyStudy;
use super::method::{IdentificationMethod, structure_text};
use super::segment_samples::SegmentSamples;
use super::time_series::{
    MAX_ITERATIVE_ORDER, check_cost, rejection_reason, residual_diagnostic, root_rule_text,
    to_io_data, whiteness_test,
};
use crate::base::error::{Diagnostic, Error};
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::series::model::PolynomialModel;
use crate::identify::series::model_trajectory::{INSTANTS, ModeTrack, mode_tracks, track_model};
use crate::numeric::sorting::sort_ascending;

/// Share of the instants at which a mode is found, at least.
const MIN_TRACK_SHARE: f64 = 0.05;

/// Follows an output, the last channel of the record, with an input, the first of two.
///
/// # Errors
/// Those of the recursion: too few samples, a memory too short.
pub fn identify_tracking(
    samples: &SegmentSamples,
    band_hz: (f64, f64),
    study: &IdentifyStudy,
) -> Result<SignalIdentification, Error> {
    let record = to_io_data(samples)?;
    let orders: Vec<usize> = match study.order {
        Some(modes) => {
            check_cost(IdentificationMethod::Rls, 2 * modes, record.output().len())?;
            vec![2 * modes]
        }
        None => (2..=MAX_ITERATIVE_ORDER).step_by(2).collect(),
    };
    let memory = study.memory_s.map(|t| t * record.rate_hz());
    let course = track_model(&record, &orders, memory)?;
    let mut diagnostics = samples.diagnostics.clone();
    let is_noise = course.selected.error_variance >= course.output_variance;
    if is_noise {
        diagnostics.push(Diagnostic {
            code: "no-mode",
            message: "no model predicts the output better than its mean: it is indistinguishable from noise".into(),
            hint: Some("check whether the channel is the right one; take a longer record".into()),
        });
    }
    if !is_noise {
        let fitted = course.instants.last().map_or(0, |(_, model)| model.a.len());
        diagnostics.extend(residual_diagnostic(
            "white",
            &whiteness_test(&course.errors, fitted)?,
        ));
    }
    let is_last = course.selected.family == course.max_structure && orders.len() > 1;
    if is_last && !is_noise {
        diagnostics.push(Diagnostic {
            code: "order-limit",
            message: format!(
                "the error of prediction still falls at {}, the end of the search",
                structure_text(course.max_structure)
            ),
            hint: Some("state a higher --order, or narrow the --band".into()),
        });
    }
    let modes = |model: &PolynomialModel| -> Result<Vec<ModalParameters>, Error> {
        let all = model.modes()?.into_iter().zip(model.mode_shares()?);
        Ok(all
            .filter(|(m, shares)| {
                natural_frequency_is_in_band(m.pole, band_hz)
                    && rejection_reason(m, *shares).is_none()
            })
            .map(|(m, _)| m)
            .collect())
    };
    let modes = (course.instants.iter())
        .map(|(_, model)| {
            if is_noise {
                Ok(Vec::new())
            } else {
                modes(model)
            }
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let least = ((MIN_TRACK_SHARE * modes.len() as f64).ceil() as usize).max(2);
    let mut tracks = mode_tracks(&modes, least);
    let begins = |t: &ModeTrack| (t.points[0].0, t.points[0].1.frequency_hz());
    tracks.sort_by(|a, b| {
        let (a, b) = (begins(a), begins(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let last = modes.len().saturating_sub(1);
    let mut at_end: Vec<IdentifiedMode> = (tracks.iter().filter_map(|t| t.points.last()))
        .filter(|(at, _)| *at == last)
        .map(|(_, mode)| IdentifiedMode::from(mode.clone()))
        .collect();
    sort_ascending(&mut at_end, |a| a.frequency_hz());
    let rule = format!(
        "{} with a memory of {}, {}; evaluated at {INSTANTS} times; {}; joined where it moves by less than 5 % or three standard \
         deviations, and shown where it lasts for {:.0} % of the record",
        structure_text(course.selected.family),
        match course.selected.memory.is_finite() {
            true => format!("{:.4} s", course.selected.memory / record.rate_hz()),
            false => "the whole record".to_string(),
        },
        match (study.order, study.memory_s) {
            (Some(_), Some(_)) => "as requested",
            (Some(_), None) => "the memory by the smallest error of prediction",
            (None, Some(_)) => "the order by the smallest error of prediction",
            (None, None) => "both by the smallest error of prediction",
        },
        root_rule_text(),
        100.0 * MIN_TRACK_SHARE
    );
    Ok(SignalIdentification {
        modes: at_end,
        weak: Vec::new(),
        harmonics: Vec::new(),
        selection_rule: rule,
        evidence: Evidence::Tracking(ModeTracking {
            time_s: course.instants.iter().map(|i| i.0).collect(),
            tracks,
            trials: course.trials,
            chosen: course.selected,
            rate_hz: record.rate_hz(),
        }),
        diagnostics,
    })
}
