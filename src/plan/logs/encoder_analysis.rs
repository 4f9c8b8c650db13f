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
use crate::encoder::eccentricity::{EccentricitySplit, split_eccentricity};
use crate::encoder::evaluate::{EvaluationOptions, TeEvaluation, evaluate};
use crate::encoder::orders::KnownOrders;
use crate::encoder::readings::{EncoderScale, EncoderScales, MemoryReadings};
use crate::recording::signals::{Channel, Recording};

/// Result of an encoder record.
pub struct EncoderResult {
    /// Description of the readings, as text.
    pub method_text: Vec<String>,
    /// The evaluation.
    pub measured: TeEvaluation,
    /// Eccentricity of encoders and gears apart.
    pub separated: Vec<EccentricitySplit>,
    /// Attribution of the lines of each flank, where there is a model.
    pub attribution: Vec<Attribution>,
    /// Quantities that this record cannot distinguish, and measurements that could.
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
    read: EncoderRecordings,
    study: &EncoderStudy,
    model: Option<&EncoderModel>,
) -> Result<EncoderResult, Error> {
    let start = Instant::now();
    let EncoderRecordings { input, output, .. } = read;
    let mut how = Vec::new();
    let mut diagnostics = Vec::new();
    let first = find_channels(input, &study.input)?;
    let second = find_channels(output, &study.output)?;
    for recording in [input, output]
        .into_iter()
        .chain(read.index.into_iter().flatten())
    {
        check_no_gaps(recording)?;
    }
    let timed = study.pulse_times || study.input.len() == 2 || study.output.len() == 2;
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
        // What the input does tells what of a line is the model's.
        input: model.is_some(),
        index: [None, None],
    };
    let measured = if timed {
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
        let even = resample_uniform(&first, &second)?;
        let [first, second] = even.angles;
        options.rate_hz = Some(even.timing.rate_hz);
        options.index = index_signals(read, study, even.timing, &mut how)?;
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
        options.index = index_signals(read, study, timing, &mut how)?;
        evaluate(&rows, &options)?
    };
    let evaluated = start.elapsed().as_secs_f64();
    how.extend(counts_passed(&measured, options.scales));
    how.extend(rest_rows(&measured));
    diagnostics.extend(measured.diagnostics.iter().cloned());
    for jump in &measured.removed_steps {
        diagnostics.push(Diagnostic {
            code: "counts-repaired",
            message: format!("{} at row {}: taken out", jump.describe(), jump.row + 1),
            hint: None,
        });
    }
    let speed = measured.speed.as_ref().map(|s| s.range().0);
    let of_flank = |flank| model.map(|m| m.attribute(flank, speed, measured.order_error));
    let attribution = measured.flanks.iter().filter_map(of_flank);
    let attribution: Vec<Attribution> = attribution.collect::<Result<_, _>>()?;
    diagnostics.extend(attribution.iter().filter_map(speed_ripple_warning));
    let parted = study.pressure_angle.map_or(Vec::new(), |angle| {
        split_eccentricity(&measured, &study.teeth, angle)
    });
    let limits = ambiguities(&measured, study, !parted.is_empty());
    Ok(EncoderResult {
        method_text: how,
        separated: parted,
        attribution,
        limits,
        measured,
        radius: study.radius,
        trace: vec![("evaluate", evaluated)],
        diagnostics,
    })
}

/// Number of counts of both encoders, where counters were read.
fn counts_passed(measured: &TeEvaluation, scales: EncoderScales) -> Option<String> {
    let turned: f64 = measured.runs.iter().map(|run| run.travel()).sum();
    let counts = |angle: f64, step: f64| (angle / step).round();
    let (input, output) = (scales.input.step, scales.output.step);
    (input > 0.0 && output > 0.0).then(|| {
        format!(
            "{} counts of the input and {} of the output are evaluated",
            counts(turned, input),
            counts(turned * measured.tooth_ratio.to_f64(), output)
        )
    })
}

/// Rows at the ends in which the input is at rest.
fn rest_rows(measured: &TeEvaluation) -> Option<String> {
    let named = measured.still.into_iter().zip(["beginning", "end"]);
    let ends: Vec<String> = named
        .filter(|(rows, _)| *rows > 0)
        .map(|(rows, end)| format!("{} at the {end}", pluralise(rows, "row")))
        .collect();
    (!ends.is_empty()).then(|| format!("the input is at rest: {} left out", ends.join(" and ")))
}

/// Says that the input does not turn evenly at the orders of declared errors.
fn speed_ripple_warning(found: &Attribution) -> Option<Diagnostic> {
    let worst = found.rows.iter().max_by(|a, b| {
        let far = |row: &AttributedOrder| (row.amplitude_uniform_input / row.amplitude - 1.0).abs();
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
        hint: Some("the free driver responds to the meshes; its motion is in the record, its transmission is the model's".into()),
    })
}

/// The share of a line that an uneven input may make unsaid.
const MAX_RIPPLE_SHARE: f64 = 0.02;

/// Ambiguities that the record leaves unresolved.
fn ambiguities(measured: &TeEvaluation, study: &EncoderStudy, is_parted: bool) -> Vec<String> {
    let mut all = Vec::new();
    if !is_parted {
        let missing = match (measured.flanks.len(), study.pressure_angle) {
            (2, None) => "both flanks are there: --pressure-angle parts them",
            (2, Some(_)) => "both flanks are there, but the lines are shared or faint",
            _ => "a record of both directions would, with --pressure-angle",
        };
        all.push(format!(
            "the eccentricity of an encoder and that of the gear on its shaft have one order and are not separated; {missing}"
        ));
    }
    all.push(
        "errors of single encoder lines repeat with their shaft and are part of its orders; another mounting position of the encoder would separate them"
            .into(),
    );
    all
}
