//! Modes in the course of a record: the equation followed by recursive least squares, its modes joined to tracks.

use super::found::{Evidence, FoundMode, FromSignals, ModeCourse};
use super::method::{Method, family};
use super::modal::within;
use super::record::Record;
use super::series::{ITERATED, check_cost, left_over, no_mode, of_samples, root_rule, whiteness};
use super::study::IdentifyStudy;
use crate::base::error::{Error, Warning};
use crate::identify::mode::IdentifiedMode;
use crate::identify::series::course::{INSTANTS, Track, follow, tracks};
use crate::identify::series::model::SeriesModel;

/// Share of the instants at which a mode is found, at least.
const LASTS: f64 = 0.05;

/// Follows an output, the last channel of the record, with an input, the first of two.
///
/// # Errors
/// Those of the recursion: too few samples, a memory too short.
pub fn identify(
    samples: &Record,
    band_hz: (f64, f64),
    study: &IdentifyStudy,
) -> Result<FromSignals, Error> {
    let record = of_samples(samples)?;
    let orders: Vec<usize> = match study.order {
        Some(modes) => {
            check_cost(Method::Rls, 2 * modes, record.output().len())?;
            vec![2 * modes]
        }
        None => (2..=ITERATED).step_by(2).collect(),
    };
    let memory = study.memory_s.map(|t| t * record.rate_hz());
    let course = follow(&record, &orders, memory)?;
    let mut warnings = samples.warnings.clone();
    let is_noise = course.taken.error_variance >= course.output_variance;
    if is_noise {
        warnings.push(Warning {
            code: "no-mode",
            message: "no model predicts the output better than its mean: it is noise, as far as this method sees".into(),
            hint: Some("look whether the channel is the right one; take a longer record".into()),
        });
    }
    if !is_noise {
        let fitted = course.instants.last().map_or(0, |(_, model)| model.a.len());
        warnings.extend(left_over("white", &whiteness(&course.errors, fitted)?));
    }
    let is_last = course.taken.family == course.highest && orders.len() > 1;
    if is_last && !is_noise {
        warnings.push(Warning {
            code: "order-limit",
            message: format!(
                "the error of prediction still falls at {}, where the search ends",
                family(course.highest)
            ),
            hint: Some("state a higher --order, or narrow the --band".into()),
        });
    }
    let modes = |model: &SeriesModel| -> Result<Vec<IdentifiedMode>, Error> {
        let all = model.modes()?.into_iter().zip(model.shares()?);
        Ok(all
            .filter(|(m, shares)| within(m.pole, band_hz) && no_mode(m, *shares).is_none())
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
    let least = ((LASTS * modes.len() as f64).ceil() as usize).max(2);
    let mut tracks = tracks(&modes, least);
    let begins = |t: &Track| (t.points[0].0, t.points[0].1.frequency_hz());
    tracks.sort_by(|a, b| {
        let (a, b) = (begins(a), begins(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let last = modes.len().saturating_sub(1);
    let mut at_end: Vec<FoundMode> = (tracks.iter().filter_map(|t| t.points.last()))
        .filter(|(at, _)| *at == last)
        .map(|(_, mode)| FoundMode::from(mode.clone()))
        .collect();
    at_end.sort_by(|a, b| a.frequency_hz().total_cmp(&b.frequency_hz()));
    let rule = format!(
        "{} with a memory of {}, {}; looked at {INSTANTS} times; {}; joined where it moves by less than 5 % or three standard \
         deviations, and shown where it lasts for {:.0} % of the record",
        family(course.taken.family),
        match course.taken.memory.is_finite() {
            true => format!("{:.4} s", course.taken.memory / record.rate_hz()),
            false => "the whole record".to_string(),
        },
        match (study.order, study.memory_s) {
            (Some(_), Some(_)) => "as asked",
            (Some(_), None) => "the memory by the smallest error of prediction",
            (None, Some(_)) => "the order by the smallest error of prediction",
            (None, None) => "both by the smallest error of prediction",
        },
        root_rule(),
        100.0 * LASTS
    );
    Ok(FromSignals {
        modes: at_end,
        harmonics: Vec::new(),
        rule,
        evidence: Evidence::Course(ModeCourse {
            time_s: course.instants.iter().map(|i| i.0).collect(),
            tracks,
            tried: course.tried,
            taken: course.taken,
            rate_hz: record.rate_hz(),
        }),
        warnings,
    })
}
