//! Transmission error from two encoders: readings are converted to angles at common sample times and evaluated.

use std::time::Instant;

use super::attribution::{AttributedOrder, Attribution, EncoderModel};
use super::encoder_readings::{
    EncoderColumns, RowTiming, angle_from_pulse_times, angle_from_tracks, check_no_gaps,
    find_channels, index_signals, lines_per_rev, reading_scale, resample_uniform,
};
use super::encoder_study::{EncoderRecordings, EncoderStudy};
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::encoder::eccentricity::{EccentricitySplit, split_eccentricity};
use crate::encoder::evaluate::{EvaluationOptions, TeEvaluation, evaluate};
use crate::encoder::orders::KnownOrders;
use crate::encoder::readings::{EncoderScale, EncoderScales, MemoryReadings};
use crate::recording::signals::{Channel, Recording};

/// Evaluated transmission error of an encoder record.
pub struct EncoderResult {
    /// Conversion of the readings, as text.
    pub method_text: Vec<String>,
    /// Transmission error and its order lines.
    pub measured: TeEvaluation,
    /// Eccentricities of encoder and gear of each shaft, separated by the two flanks.
    pub separated: Vec<EccentricitySplit>,
    /// Attribution of the order lines of each flank to the error sources of the model; empty without a model.
    pub attribution: Vec<Attribution>,
    /// Quantities that this record cannot distinguish, and measurements that could.
    pub limits: Vec<String>,
    /// See [`EncoderStudy::radius`].
    pub radius: Option<f64>,
    /// Stages with their run time, s.
    pub trace: Vec<(&'static str, f64)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Evaluates the transmission error between the encoder channels of two shafts.
///
/// # Errors
/// Channels do not exist or hold no angle; readings are missing; errors of [`evaluate`].
pub fn evaluate_encoders(
    read: EncoderRecordings,
    study: &EncoderStudy,
    model: Option<&EncoderModel>,
) -> Result<EncoderResult, Error> {
    let start = Instant::now();
    let EncoderRecordings { input, output, .. } = read;
    let mut method_text = Vec::new();
    let mut diagnostics = Vec::new();
    let first = find_channels(input, &study.input)?;
    let second = find_channels(output, &study.output)?;
    for recording in [input, output]
        .into_iter()
        .chain(read.index.into_iter().flatten())
    {
        check_no_gaps(recording)?;
    }
    let is_timed = study.pulse_times || study.input.len() == 2 || study.output.len() == 2;
    let mut options = EvaluationOptions {
        teeth: study.teeth.clone(),
        scales: EncoderScales {
            input: EncoderScale::RAD,
            output: EncoderScale::RAD,
        },
        rate_hz: None,
        multiples: study.multiples,
        repair: study.repair,
        known_orders: match model {
            Some(model) => model.source_orders(&study.teeth)?,
            None => KnownOrders::default(),
        },
        all_multiples: study.every,
        // The input motion separates the speed ripple from the modelled part of a line.
        input: model.is_some(),
        index: [None, None],
    };
    let measured = if is_timed {
        let to_angle = |recording: &Recording,
                        tracks: &[&Channel],
                        lines,
                        text: &mut Vec<String>| match study.pulse_times {
            true => angle_from_pulse_times(tracks[0], lines, study.repair, text),
            false => angle_from_tracks(recording, tracks, lines, text),
        };
        let (a, b) = lines_per_rev(study)?;
        let (first, second) = (
            to_angle(input, &first, a, &mut method_text)?,
            to_angle(output, &second, b, &mut method_text)?,
        );
        let resampled = resample_uniform(&first, &second)?;
        let [first, second] = resampled.angles;
        options.rate_hz = Some(resampled.timing.rate_hz);
        options.index = index_signals(read, study, resampled.timing, &mut method_text)?;
        evaluate(&MemoryReadings(&first, &second), &options)?
    } else {
        let rows = EncoderColumns {
            input: &first[0].samples,
            output: &second[0].samples,
        };
        options.scales.input = reading_scale(&rows, first[0], false, study, &mut method_text)?;
        options.scales.output = reading_scale(&rows, second[0], true, study, &mut method_text)?;
        options.rate_hz = (!study.angle_base).then_some(input.rate_hz);
        let timing = RowTiming {
            from_s: 0.0,
            rate_hz: input.rate_hz,
        };
        options.index = index_signals(read, study, timing, &mut method_text)?;
        evaluate(&rows, &options)?
    };
    let evaluation_s = start.elapsed().as_secs_f64();
    method_text.extend(counts_passed(&measured, options.scales));
    method_text.extend(rest_rows(&measured));
    diagnostics.extend(measured.diagnostics.iter().cloned());
    for jump in &measured.removed_steps {
        diagnostics.push(Diagnostic {
            code: "counts-repaired",
            message: format!("{} at row {}: taken out", jump.describe(), jump.row + 1),
            hint: None,
        });
    }
    let speed = measured.speed.as_ref().map(|s| s.range().0);
    let attribute = |flank| model.map(|m| m.attribute(flank, speed, measured.order_error));
    let attribution = measured.flanks.iter().filter_map(attribute);
    let attribution: Vec<Attribution> = attribution.collect::<Result<_, _>>()?;
    diagnostics.extend(attribution.iter().filter_map(speed_ripple_warning));
    let eccentricities = study.pressure_angle.map_or(Vec::new(), |angle| {
        split_eccentricity(&measured, &study.teeth, angle)
    });
    let limits = ambiguities(&measured, study, !eccentricities.is_empty());
    Ok(EncoderResult {
        method_text,
        separated: eccentricities,
        attribution,
        limits,
        measured,
        radius: study.radius,
        trace: vec![("evaluate", evaluation_s)],
        diagnostics,
    })
}

/// Number of evaluated counts of both encoders, as text; `None` unless both are counters.
fn counts_passed(measured: &TeEvaluation, scales: EncoderScales) -> Option<String> {
    let travel: f64 = measured.runs.iter().map(|run| run.travel()).sum();
    let counts = |angle: f64, step: f64| (angle / step).round();
    let (input, output) = (scales.input.step, scales.output.step);
    (input > 0.0 && output > 0.0).then(|| {
        format!(
            "{} counts of the input and {} of the output are evaluated",
            counts(travel, input),
            counts(travel * measured.tooth_ratio.to_f64(), output)
        )
    })
}

/// Rows at the beginning and at the end in which the input is at rest, as text.
fn rest_rows(measured: &TeEvaluation) -> Option<String> {
    let counts = measured.rest_rows.into_iter().zip(["beginning", "end"]);
    let ends: Vec<String> = counts
        .filter(|(rows, _)| *rows > 0)
        .map(|(rows, end)| format!("{} at the {end}", pluralise(rows, "row")))
        .collect();
    (!ends.is_empty()).then(|| format!("the input is at rest: {} omitted", ends.join(" and ")))
}

/// Warning for speed ripple of the input at the orders of declared errors.
fn speed_ripple_warning(attribution: &Attribution) -> Option<Diagnostic> {
    let worst = attribution.rows.iter().max_by(|a, b| {
        let ripple = |r: &AttributedOrder| (r.amplitude_uniform_input / r.amplitude - 1.0).abs();
        ripple(a).total_cmp(&ripple(b))
    })?;
    let share = worst.amplitude_uniform_input / worst.amplitude - 1.0;
    (share.abs() > MAX_RIPPLE_SHARE).then(|| Diagnostic {
        code: "input-uneven",
        message: format!(
            "the input does not turn uniformly: of order {} it causes {:.0} % of the measured amplitude; the model subtracts it",
            worst.order,
            -100.0 * share
        ),
        hint: Some("the free driver responds to the meshes; its motion is in the record, its transmission is the model's".into()),
    })
}

/// Share of a line caused by input speed ripple above which a warning is issued.
const MAX_RIPPLE_SHARE: f64 = 0.02;

/// Quantities that the record does not separate, each with a measurement that would.
fn ambiguities(measured: &TeEvaluation, study: &EncoderStudy, is_separated: bool) -> Vec<String> {
    let mut list = Vec::new();
    if !is_separated {
        let missing = match (measured.flanks.len(), study.pressure_angle) {
            (2, None) => "both flanks are recorded: pass --pressure-angle to separate them",
            (2, Some(_)) => "both flanks are recorded, but the lines are shared or weak",
            _ => "record both directions and pass --pressure-angle",
        };
        list.push(format!(
            "the eccentricity of an encoder and that of the gear on its shaft have the same order and are not separated; {missing}"
        ));
    }
    list.push(
        "errors of single encoder lines repeat with their shaft and are part of its orders; another mounting position of the encoder would separate them"
            .into(),
    );
    list
}
