//! Transmission error from the channels of two encoders: what the readings are, brought to rows, and evaluated.

use std::time::Instant;

use super::attribution::{Attribution, Model, Row};
use super::encoder_study::{EncoderStudy, Read};
use super::readings::{
    Clock, Columns, channels, even, from_stamps, from_tracks, index_signals, lines, scale, whole,
};
use crate::base::error::{Error, Warning};
use crate::base::words::counted;
use crate::recording::signals::{Channel, Recording};
use crate::transmission::measured::eccentricity::{Parted, parted};
use crate::transmission::measured::evaluate::{Ask, Measured, evaluate};
use crate::transmission::measured::orders::Named;
use crate::transmission::measured::rows::{InMemory, Scale, Scales};

/// What an encoder record says.
pub struct EncoderRecord {
    /// What the readings were, in words.
    pub how: Vec<String>,
    /// The evaluation.
    pub measured: Measured,
    /// Eccentricity of encoders and gears apart.
    pub parted: Vec<Parted>,
    /// What makes the lines of each flank, where there is a model.
    pub attribution: Vec<Attribution>,
    /// What this record cannot tell apart, and what could.
    pub limits: Vec<String>,
    /// See [`EncoderStudy::radius`].
    pub radius: Option<f64>,
    /// Stages and their time, s.
    pub trace: Vec<(&'static str, f64)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// Evaluates the channels of two shafts.
///
/// # Errors
/// Channels that are not there or hold no angle; missing readings; everything [`evaluate`] refuses.
pub fn encoders(
    read: Read,
    study: &EncoderStudy,
    model: Option<&Model>,
) -> Result<EncoderRecord, Error> {
    let start = Instant::now();
    let Read { input, output, .. } = read;
    let mut how = Vec::new();
    let mut warnings = Vec::new();
    let first = channels(input, &study.input)?;
    let second = channels(output, &study.output)?;
    for recording in [input, output]
        .into_iter()
        .chain(read.index.into_iter().flatten())
    {
        whole(recording)?;
    }
    let timed = study.stamps || study.input.len() == 2 || study.output.len() == 2;
    let mut ask = Ask {
        teeth: study.teeth.clone(),
        scales: Scales {
            input: Scale::RAD,
            output: Scale::RAD,
        },
        rate_hz: None,
        multiples: study.multiples,
        repair: study.repair,
        named: match model {
            Some(model) => model.named(&study.teeth)?,
            None => Named::default(),
        },
        every: study.every,
        // What the input does tells what of a line is the model's.
        input: model.is_some(),
        index: [None, None],
    };
    let measured = if timed {
        let curve =
            |recording: &Recording, list: &[&Channel], lines, said: &mut Vec<String>| match study
                .stamps
            {
                true => from_stamps(list[0], lines, study.repair, said),
                false => from_tracks(recording, list, lines, said),
            };
        let (a, b) = lines(study)?;
        let (first, second) = (
            curve(input, &first, a, &mut how)?,
            curve(output, &second, b, &mut how)?,
        );
        let even = even(&first, &second)?;
        let [first, second] = even.angles;
        ask.rate_hz = Some(even.clock.rate_hz);
        ask.index = index_signals(read, study, even.clock, &mut how)?;
        evaluate(&InMemory(&first, &second), &ask)?
    } else {
        let rows = Columns {
            input: &first[0].samples,
            output: &second[0].samples,
        };
        ask.scales.input = scale(&rows, first[0], false, study, &mut how)?;
        ask.scales.output = scale(&rows, second[0], true, study, &mut how)?;
        ask.rate_hz = (!study.angle_base).then_some(input.rate_hz);
        let clock = Clock {
            from_s: 0.0,
            rate_hz: input.rate_hz,
        };
        ask.index = index_signals(read, study, clock, &mut how)?;
        evaluate(&rows, &ask)?
    };
    let evaluated = start.elapsed().as_secs_f64();
    how.extend(passed(&measured, ask.scales));
    how.extend(rested(&measured));
    warnings.extend(measured.warnings.iter().cloned());
    for jump in &measured.repaired {
        warnings.push(Warning {
            code: "counts-repaired",
            message: format!("{} at row {}: taken out", jump.told(), jump.row + 1),
            hint: None,
        });
    }
    let speed = measured.speed.as_ref().map(|s| s.range().0);
    let of_flank = |flank| model.map(|m| m.attribute(flank, speed, measured.error));
    let attribution = measured.flanks.iter().filter_map(of_flank);
    let attribution: Vec<Attribution> = attribution.collect::<Result<_, _>>()?;
    warnings.extend(attribution.iter().filter_map(uneven));
    let parted = study
        .pressure_angle
        .map_or(Vec::new(), |angle| parted(&measured, &study.teeth, angle));
    let limits = limits(&measured, study, !parted.is_empty());
    Ok(EncoderRecord {
        how,
        parted,
        attribution,
        limits,
        measured,
        radius: study.radius,
        trace: vec![("evaluate", evaluated)],
        warnings,
    })
}

/// How many counts of both encoders passed, where counters were read.
fn passed(measured: &Measured, scales: Scales) -> Option<String> {
    let turned: f64 = measured.runs.iter().map(|run| run.reach()).sum();
    let counts = |angle: f64, step: f64| (angle / step).round();
    let (input, output) = (scales.input.step, scales.output.step);
    (input > 0.0 && output > 0.0).then(|| {
        format!(
            "{} counts of the input and {} of the output are evaluated",
            counts(turned, input),
            counts(turned * measured.declared.value(), output)
        )
    })
}

/// Rows at the ends in which the input is at rest.
fn rested(measured: &Measured) -> Option<String> {
    let named = measured.still.into_iter().zip(["beginning", "end"]);
    let ends: Vec<String> = named
        .filter(|(rows, _)| *rows > 0)
        .map(|(rows, end)| format!("{} at the {end}", counted(rows, "row")))
        .collect();
    (!ends.is_empty()).then(|| format!("the input is at rest: {} left out", ends.join(" and ")))
}

/// Says that the input does not turn evenly at the orders of declared errors.
fn uneven(found: &Attribution) -> Option<Warning> {
    let worst = found.rows.iter().max_by(|a, b| {
        let far = |row: &Row| (row.even / row.amplitude - 1.0).abs();
        far(a).total_cmp(&far(b))
    })?;
    let far = worst.even / worst.amplitude - 1.0;
    (far.abs() > UNEVEN).then(|| Warning {
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
const UNEVEN: f64 = 0.02;

/// What is not told apart.
fn limits(measured: &Measured, study: &EncoderStudy, is_parted: bool) -> Vec<String> {
    let mut all = Vec::new();
    if !is_parted {
        let missing = match (measured.flanks.len(), study.pressure_angle) {
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
