//! Transmission error from two encoders: readings converted to angles at common rows, evaluated.

use std::time::Instant;

use super::attribution::{AttributedOrder, Attribution, EncoderModel};
use super::encoder_readings::{
    EncoderColumns, RowTiming, angle_from_pulse_times, angle_from_tracks, check_no_gaps,
    find_channels, index_signals, lines_per_rev, reading_scale, resample_uniform,
};
use super::encoder_study::{EncoderRecordings, EncoderStudy};
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::recording::signals::{Channel, Recording};
use crate::transmission::encoder::eccentricity::{EccentricitySplit, split_eccentricity};
use crate::transmission::encoder::evaluate::{EvaluationOptions, TeEvaluation, evaluate};
use crate::transmission::encoder::orders::KnownOrders;
use crate::transmission::encoder::readings::{EncoderScale, EncoderScales, MemoryReadings};

/// What an encoder record says.
pub struct EncoderResult {
    /// What the readings were, as text.
    pub method_text: Vec<String>,
    /// The evaluation.
    pub evaluation: TeEvaluation,
    /// Eccentricity of encoders and gears apart.
    pub separated: Vec<EccentricitySplit>,
    /// What makes the lines of each flank, where there is a model.
    pub attribution: Vec<Attribution>,
    /// What this record cannot distinguish, and what could.
    pub limits: Vec<String>,
    /// See [`EncoderStudy::radius`].
    pub radius: Option<f64>,
    /// Stages and their time, s.
    pub trace: Vec<(&'static str, f64)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Evaluates the channels of two shafts.
///
/// # Errors
/// Channels that are not there or hold no angle; missing readings; everything [`evaluate`] refuses.
pub fn evaluate_encoders(
    recordings: EncoderRecordings,
    study: &EncoderStudy,
    model: Option<&EncoderModel>,
) -> Result<EncoderResult, Error> {
    let start = Instant::now();
    let EncoderRecordings { input, output, .. } = recordings;
    let mut how = Vec::new();
    let mut diagnostics = Vec::new();
    let first = find_channels(input, &study.input)?;
    let second = find_channels(output, &study.output)?;
    for recording in [input, output]
        .into_iter()
        .chain(recordings.index.into_iter().flatten())
    {
        check_no_gaps(recording)?;
    }
    let timed = study.pulse_times || study.input.len() == 2 || study.output.len() == 2;
    let mut options = EvaluationOptions {
        train: study.train.clone(),
        scales: EncoderScales {
            input: EncoderScale::RAD,
            output: EncoderScale::RAD,
        },
        rate_hz: None,
        multiples: study.multiples,
        repair: study.repair,
        known_orders: match model {
            Some(model) => model.source_orders(&study.train)?,
            None => KnownOrders::default(),
        },
        all_multiples: study.every,
        // What the input does tells what of a line is the model's.
        input: model.is_some(),
        index: [None, None],
    };
    let evaluation = if timed {
        let curve =
            |recording: &Recording, list: &[&Channel], lines, said: &mut Vec<String>| match study
                .pulse_times
            {
                true => angle_from_pulse_times(list[0], lines, study.repair, said),
                false => angle_from_tracks(recording, list, lines, said),
            };
        let (a, b) = lines_per_rev(study)?;
        let (first, second) = (
            curve(input, &first, a, &mut how)?,
            curve(output, &second, b, &mut how)?,
        );
        let angles = resample_uniform(&first, &second)?;
        let [first, second] = angles.angles;
        options.rate_hz = Some(angles.timing.rate_hz);
        options.index = index_signals(recordings, study, angles.timing, &mut how)?;
        evaluate(&MemoryReadings(&first, &second), &options)?
    } else {
        let rows = EncoderColumns {
            input: &first[0].samples,
            output: &second[0].samples,
        };
        options.scales.input = reading_scale(&rows, first[0], false, study, &mut how)?;
        options.scales.output = reading_scale(&rows, second[0], true, study, &mut how)?;
        options.rate_hz = (!study.angle_base).then_some(input.rate_hz);
        let timing = RowTiming {
            from_s: 0.0,
            rate_hz: input.rate_hz,
        };
        options.index = index_signals(recordings, study, timing, &mut how)?;
        evaluate(&rows, &options)?
    };
    let evaluated = start.elapsed().as_secs_f64();
    how.extend(counts_passed(&evaluation, options.scales));
    how.extend(rest_rows(&evaluation));
    diagnostics.extend(evaluation.diagnostics.iter().cloned());
    for step in &evaluation.removed_steps {
        diagnostics.push(Diagnostic {
            code: "counts-repaired",
            message: format!("{} at row {}: taken out", step.describe(), step.row + 1),
            hint: None,
        });
    }
    let speed = evaluation.trace.as_ref().map(|s| s.range().0);
    let of_flank = |flank| model.map(|m| m.attribute(flank, speed, evaluation.order_error));
    let attribution = evaluation.evaluations.iter().filter_map(of_flank);
    let attribution: Vec<Attribution> = attribution.collect::<Result<_, _>>()?;
    diagnostics.extend(attribution.iter().filter_map(speed_ripple_warning));
    let split = study.pressure_angle.map_or(Vec::new(), |angle| {
        split_eccentricity(&evaluation, &study.train, angle)
    });
    let limits = ambiguities(&evaluation, study, !split.is_empty());
    Ok(EncoderResult {
        method_text: how,
        separated: split,
        attribution,
        limits,
        evaluation,
        radius: study.radius,
        trace: vec![("evaluate", evaluated)],
        diagnostics,
    })
}

/// How many counts of both encoders passed, where counters were read.
fn counts_passed(evaluation: &TeEvaluation, scales: EncoderScales) -> Option<String> {
    let turned: f64 = evaluation.runs.iter().map(|run| run.travel()).sum();
    let counts = |angle: f64, step: f64| (angle / step).round();
    let (input, output) = (scales.input.step, scales.output.step);
    (input > 0.0 && output > 0.0).then(|| {
        format!(
            "{} counts of the input and {} of the output are evaluated",
            counts(turned, input),
            counts(turned * evaluation.tooth_ratio.to_f64(), output)
        )
    })
}

/// Rows at the ends in which the input is at rest.
fn rest_rows(evaluation: &TeEvaluation) -> Option<String> {
    let named = evaluation.still.into_iter().zip(["beginning", "end"]);
    let ends: Vec<String> = named
        .filter(|(rows, _)| *rows > 0)
        .map(|(rows, end)| format!("{} at the {end}", pluralise(rows, "row")))
        .collect();
    (!ends.is_empty()).then(|| format!("the input is at rest: {} left out", ends.join(" and ")))
}

/// Says that the input does not turn evenly at the orders of declared errors.
fn speed_ripple_warning(found: &Attribution) -> Option<Diagnostic> {
    let worst = found.orders.iter().max_by(|a, b| {
        let far = |attributed_order: &AttributedOrder| {
            (attributed_order.amplitude_uniform_input / attributed_order.amplitude - 1.0).abs()
        };
        far(a).total_cmp(&far(b))
    })?;
    let far = worst.amplitude_uniform_input / worst.amplitude - 1.0;
    (far.abs() > MAX_RIPPLE_SHARE).then(|| Diagnostic {
        code: "input-uneven",
        message: format!(
            "the input does not turn evenly: of order {} it makes {:.0} % of what is measured; the model takes that off",
            worst.order,
            -100.0 * far
        ),
        hint: Some("the free driver answers the meshes; what it does is in the record, and how it passes on is the model's".into()),
    })
}

/// The share of a line that an uneven input may make unsaid.
const MAX_RIPPLE_SHARE: f64 = 0.02;

/// What is not distinguished.
fn ambiguities(evaluation: &TeEvaluation, study: &EncoderStudy, is_parted: bool) -> Vec<String> {
    let mut all = Vec::new();
    if !is_parted {
        let missing = match (evaluation.evaluations.len(), study.pressure_angle) {
            (2, None) => "both flanks are there: --pressure-angle parts them",
            (2, Some(_)) => "both flanks are there, but the lines are shared or faint",
            _ => "a record of both directions would, with --pressure-angle",
        };
        all.push(format!(
            "the eccentricity of an encoder and that of the gear on its shaft have one order and are not told apart; {missing}"
        ));
    }
    all.push(
        "errors of single encoder lines repeat with their shaft and are part of its orders; another seat of the encoder would tell them"
            .into(),
    );
    all
}
