//! `geardyn identify`: a log becomes frequency responses, transfer functions and modes.

use std::io::Write;
use std::path::Path;

use super::args::{
    DelayArg, DiscretisationArg, EstimatorArg, IdentifyArgs, MethodArg, ResponseFormArg, RovingWord,
};
use super::destination::output_error;
use super::logs::{self, Test};
use super::present::Outputs;
use super::{files, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::identify::rational::DelayModel;
use crate::identify::transfer::export::{to_mat, write_csv};
use crate::identify::transfer::function::TransferFunction;
use crate::identify::transfer::realisation::{DiscretisationMethod, Realisation};
use crate::plan::logs::frf_estimation::FrfStudy;
use crate::plan::logs::identification::{self, IdentificationInput};
use crate::plan::logs::identification_result::IdentificationResult;
use crate::plan::logs::identify_study::IdentifyStudy;
use crate::plan::logs::method::{IdentificationMethod, RequiredData};
use crate::recording::channel_names;
use crate::recording::frequency_responses::FrequencyResponses;
use crate::recording::read_options::Roving;
use crate::recording::write;
use crate::recording::write::uff::UffFormat;
use crate::report::presentation::{LogReport, Provenance};
use crate::spectrum::frf::Estimator;
use crate::spectrum::window::Window;

/// Modes that may be asked for.
const MAX_MODES: usize = 500;

/// Identifies and prints.
///
/// # Errors
/// Whatever is wrong with the log, the flags or the solution.
pub fn run(args: &IdentifyArgs) -> Result<u8, Errors> {
    let mut study = study(args)?;
    for (path, formats) in [
        (&args.export, ["json", "csv", "mat"]),
        (&args.frf, ["csv", "json", "uff"]),
    ] {
        if let Some(path) = path {
            files::ends(path, &formats)?;
        }
    }
    let logs = logs::open_logs(&args.files, &args.log)?;
    let figures = ["", "nyquist", "poles", "stabilisation"];
    let others = [&args.export, &args.frf];
    let mut outputs = Outputs::check(&args.out, &figures, &others, &logs::paths(&logs))?;
    let mut log = progress::open(&logs[0].path, &logs[0].options, args.out.quiet)?;
    let responses = log
        .responses
        .take()
        .filter(|r| log.groups.is_empty() || use_file_responses(r, &study));
    if responses.is_some() && logs.len() > 1 {
        let message =
            "the file holds frequency responses; only signals of several files are joined";
        let hint = "identify files of responses one by one, or join their columns in one table";
        let error = Error::new(Code::Conflict, message).with_hint(hint);
        return Err(error.with_file(&logs[0].path.display().to_string()).into());
    }
    let work = |source: IdentificationInput, study: &IdentifyStudy| {
        progress::with_spinner("identifying", args.out.quiet, || {
            identification::identify(source, study)
        })
    };
    let (found, repairs) = match responses {
        Some(responses) => {
            let mut found = work(IdentificationInput::Responses(responses), &study)?;
            found.diagnostics.splice(0..0, log.diagnostics);
            (found, log.repairs)
        }
        None => {
            let roving = args.roving.map(|word| match word {
                RovingWord::Input => Roving::Input,
                RovingWord::Output => Roving::Output,
            });
            let test = match study.outputs.is_empty() {
                // All channels are settled, to be named in the error.
                true => Test::Joined(Box::new(logs::preprocess(&logs, log, &[], args.out.quiet)?)),
                false => {
                    reject_duplicates(&study)?;
                    let sides = (&study.inputs[..], &study.outputs[..]);
                    logs::test(&logs, log, sides, roving, args.out.quiet)?
                }
            };
            match test {
                Test::Points(records) => {
                    let mut found = work(IdentificationInput::Points(&records), &study)?;
                    let warnings = records.iter().flat_map(|r| &r.recording.diagnostics);
                    found.diagnostics.splice(0..0, once(warnings));
                    (
                        found,
                        once(records.iter().flat_map(|r| &r.recording.repairs)),
                    )
                }
                Test::Joined(recording) => {
                    if !study.outputs.is_empty() {
                        // The sidecar may have given channels other names; they stand in the order asked for.
                        let names: Vec<String> =
                            recording.channels.iter().map(|c| c.name.clone()).collect();
                        let (drive, answer) = names.split_at(study.inputs.len().min(names.len()));
                        (study.inputs, study.outputs) = (drive.to_vec(), answer.to_vec());
                    }
                    let mut found = work(IdentificationInput::Signals(&recording), &study)?;
                    let own = recording.diagnostics.iter().cloned();
                    found.diagnostics.splice(0..0, own);
                    (found, recording.repairs)
                }
            }
        }
    };
    if let Some(path) = &args.export {
        let bytes = export(path, args, &found)?;
        outputs.write(path, |to| write_all(path, &bytes, to))?;
    }
    if let Some(path) = &args.frf {
        outputs.write(path, |to| write_responses(path, &found, to))?;
    }
    outputs.present(&LogReport {
        title: logs::title(&args.files),
        repairs,
        result: found,
    })
}

/// Messages of several files, equal ones once.
fn once<'m, T: Clone + PartialEq + 'm>(all: impl Iterator<Item = &'m T>) -> Vec<T> {
    let mut kept: Vec<T> = Vec::new();
    for one in all {
        if !kept.contains(one) {
            kept.push(one.clone());
        }
    }
    kept
}

/// Whether what is asked for are the responses of a file that holds signals too.
fn use_file_responses(responses: &FrequencyResponses, study: &IdentifyStudy) -> bool {
    let known: Vec<String> = (responses.responses.iter())
        .map(|f| f.output.name.clone())
        .collect();
    let takes = study
        .method
        .is_none_or(|m| m.required_data() == RequiredData::Responses);
    takes
        && study
            .outputs
            .iter()
            .all(|word| channel_names::find_channel(word, &known).is_some())
}

/// Refuses a channel named twice, before channels are taken out of the log one by one.
fn reject_duplicates(study: &IdentifyStudy) -> Result<(), Error> {
    let all: Vec<&String> = study.inputs.iter().chain(&study.outputs).collect();
    for (k, word) in all.iter().enumerate() {
        let same = |other: &&&String| {
            channel_names::matches(word, other) || channel_names::matches(other, word)
        };
        if all[..k].iter().any(|other| same(&other)) {
            let both = study.inputs.contains(word) && study.outputs.contains(word);
            let how = if both {
                "as input and as output"
            } else {
                "twice"
            };
            return Err(Error::new(Code::Conflict, format!("{word} is named {how}"))
                .with_hint("name each channel once, as what drives or as what answers"));
        }
    }
    Ok(())
}

fn study(args: &IdentifyArgs) -> Result<IdentifyStudy, Error> {
    let above_zero = |text: &Option<String>, bare, flag, what| {
        let value = text.as_deref().map(|t| parse_positive(t, bare, flag, what));
        value.transpose()
    };
    let resolution_hz = above_zero(&args.resolution, HERTZ, "--resolution", "frequency")?;
    if args.overlap.is_some_and(|o| !(0.0..1.0).contains(&o)) {
        return Err(Error::new(
            Code::OutOfRange,
            "--overlap takes a share of a block, at least 0 and below 1",
        )
        .with_hint("half of it: --overlap 0.5"));
    }
    if args.order == Some(0) {
        return Err(Error::new(Code::OutOfRange, "--order 0 asks for no mode")
            .with_hint("leave it out: as many modes as are significant"));
    }
    if let Some(order) = args.order.filter(|order| *order > MAX_MODES) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("--order {order} asks for more modes than any band holds; up to {MAX_MODES}"),
        )
        .with_hint("leave it out: as many modes as are significant"));
    }
    Ok(IdentifyStudy {
        inputs: args.input.clone(),
        outputs: args.output.clone(),
        estimate: FrfStudy {
            estimator: match args.estimator {
                EstimatorArg::H1 => Estimator::H1,
                EstimatorArg::H2 => Estimator::H2,
                EstimatorArg::Hv => Estimator::Hv,
            },
            window: args.window.as_deref().map(Window::parse).transpose()?,
            frequency_resolution_hz: resolution_hz,
            overlap: args.overlap,
            impact: tri_state(args.impact, args.no_impact),
            stepped: tri_state(args.stepped, args.no_stepped),
            dwells_s: (args.dwells.iter())
                .map(|text| dwell(text))
                .collect::<Result<_, _>>()?,
        },
        band_hz: args.band.as_deref().map(parse_band).transpose()?,
        order: args.order,
        delay: match args.delay {
            DelayArg::None => DelayModel::None,
            DelayArg::Common => DelayModel::Common,
            DelayArg::Each => DelayModel::PerResponse,
        },
        allow_unstable: args.allow_unstable,
        all: args.all,
        derivative: args.kind.map(|kind| match kind {
            ResponseFormArg::Receptance => 0,
            ResponseFormArg::Mobility => 1,
            ResponseFormArg::Accelerance => 2,
        }),
        method: args.method.map(method_from_arg),
        speed_hz: above_zero(&args.speed, SPEED, "--speed", "speed")?,
        driving_points: args.driving_point.clone(),
        memory_s: above_zero(&args.memory, SECONDS, "--memory", "time")?,
    })
}

/// The unit of a flag's number where bare, and the size in SI of what the study counts in: turns a second where rad/s are SI.
type DefaultUnit = (QuantityKind, &'static str, f64);

const HERTZ: DefaultUnit = (QuantityKind::Frequency, "Hz", std::f64::consts::TAU);
const SPEED: DefaultUnit = (QuantityKind::Speed, "rpm", std::f64::consts::TAU);
const SECONDS: DefaultUnit = (QuantityKind::Time, "s", 1.0);

/// A number to the fifteen digits that 2π there and back leaves: 700, not 699.999 999 999 999 9.
fn round_15_digits(x: f64) -> f64 {
    format!("{x:.14e}").parse().unwrap_or(x)
}

/// What a flag takes, above zero; `what` it is as text.
fn parse_positive(
    text: &str,
    (kind, unit, size): DefaultUnit,
    flag: &str,
    what: &str,
) -> Result<f64, Error> {
    let value = round_15_digits(quantity::parse_or_bare(text, kind, unit, flag)? / size);
    match value > 0.0 {
        true => Ok(value),
        false => Err(Error::new(
            Code::OutOfRange,
            format!("{flag} takes a {what} above zero"),
        )),
    }
}

/// Of two flags that exclude each other, which was said.
fn tri_state(yes: bool, no: bool) -> Option<bool> {
    (yes || no).then_some(yes)
}

fn method_from_arg(word: MethodArg) -> IdentificationMethod {
    match word {
        MethodArg::Rational => IdentificationMethod::Rational,
        MethodArg::Plscf => IdentificationMethod::Plscf,
        MethodArg::Lsce => IdentificationMethod::Lsce,
        MethodArg::Rfp => IdentificationMethod::Rfp,
        MethodArg::Circle => IdentificationMethod::Circle,
        MethodArg::VectorFitting => IdentificationMethod::VectorFitting,
        MethodArg::Aaa => IdentificationMethod::Aaa,
        MethodArg::SsiCov => IdentificationMethod::SsiCov,
        MethodArg::SsiData => IdentificationMethod::SsiData,
        MethodArg::FreeDecay => IdentificationMethod::FreeDecay,
        MethodArg::Fdd => IdentificationMethod::Fdd,
        MethodArg::Efdd => IdentificationMethod::Efdd,
        MethodArg::Ar => IdentificationMethod::Ar,
        MethodArg::Arma => IdentificationMethod::Arma,
        MethodArg::Arx => IdentificationMethod::Arx,
        MethodArg::Armax => IdentificationMethod::Armax,
        MethodArg::OutputError => IdentificationMethod::OutputError,
        MethodArg::Rls => IdentificationMethod::Rls,
    }
}

/// `A:B`, frequencies, Hz where bare.
pub fn parse_band(text: &str) -> Result<(f64, f64), Error> {
    let hint = "--band takes low:high, such as 10:2000 or \"10 Hz:2 kHz\"";
    range(text, HERTZ, "--band", ("a band", hint))
}

/// `FROM:TO`, s where bare.
fn dwell(text: &str) -> Result<(f64, f64), Error> {
    let hint = "--dwells takes from:to, from:to, …, such as 0.5:2.5,3:5";
    range(text, SECONDS, "--dwells", ("a dwell", hint))
}

/// `A:B` with 0 ≤ A < B; `what` it is as text, and how it is written.
fn range(
    text: &str,
    (kind, unit, size): DefaultUnit,
    flag: &str,
    (what, hint): (&str, &str),
) -> Result<(f64, f64), Error> {
    let wrong = || {
        let message = format!("\"{}\" is not {what}", quantity::truncate(text));
        Error::new(Code::OutOfRange, message).with_hint(hint)
    };
    let (low, high) = text.split_once(':').ok_or_else(wrong)?;
    let value =
        |t: &str| quantity::parse_or_bare(t, kind, unit, flag).map(|x| round_15_digits(x / size));
    let (low, high) = (value(low)?, value(high)?);
    match low >= 0.0 && low < high {
        true => Ok((low, high)),
        false => Err(wrong()),
    }
}

/// Refuses to write what the method does not give.
fn nothing_to_write(flag: &str, what: &str, found: &IdentificationResult) -> Error {
    let message = format!(
        "{flag} has nothing to write: {} gives no {what}",
        found.method.name()
    );
    Error::new(Code::Usage, message)
        .with_hint("name what drives: --input, and a method from responses such as rational")
}

/// Writes the frequency responses in the format that the file's name asks for.
fn write_responses(
    path: &Path,
    found: &IdentificationResult,
    mut to: &mut dyn Write,
) -> Result<(), Error> {
    let missing = || nothing_to_write("--frf", "frequency responses", found);
    let responses = found.responses.as_ref().ok_or_else(missing)?;
    match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => write::csv::write_responses(responses, &mut to),
        Some("uff") => write::uff::write_responses(responses, UffFormat::Text, &mut to),
        _ => write::json::write_responses(responses, &Provenance::default().header(), &mut to),
    }
}

fn write_all(path: &Path, bytes: &[u8], to: &mut dyn Write) -> Result<(), Error> {
    to.write_all(bytes).map_err(|e| output_error(path, &e))
}

/// The identified model in the format that the file's name asks for.
fn export(
    path: &Path,
    args: &IdentifyArgs,
    found: &IdentificationResult,
) -> Result<Vec<u8>, Error> {
    if found.functions.is_empty() {
        return Err(nothing_to_write("--export", "transfer functions", found));
    }
    let time = args
        .sample_time
        .as_deref()
        .map(|t| quantity::parse_or_bare(t, QuantityKind::Time, "s", "--sample-time"))
        .transpose()?;
    // Accelerations of a stiff residual grow with s²: a state space holds their integrals.
    let (mut proper, mut integrated) = (found.functions.clone(), 0);
    while proper.iter().any(TransferFunction::is_improper) {
        proper = proper
            .iter()
            .map(TransferFunction::integrated)
            .collect::<Result<Vec<_>, Error>>()?;
        integrated += 1;
    }
    let model = || -> Result<Realisation, Error> {
        let model = Realisation::from_transfer_functions(&proper)?;
        match time {
            Some(time) => model.discretise(time, discretisation_from_arg(args.map)),
            None => Ok(model),
        }
    };
    match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => {
            let mut bytes = Vec::new();
            write_csv(&found.functions, &mut bytes).map_err(|e| output_error(path, &e))?;
            Ok(bytes)
        }
        Some("mat") => to_mat(&proper, &model()?),
        _ => {
            let functions = found
                .functions
                .iter()
                .map(|f| f.to_json())
                .collect::<Result<Vec<_>, Error>>()?;
            let document = serde_json::json!({
                "transfer_functions": functions,
                "state_space_integrated": integrated,
                "state_space": model()?.to_json(),
            });
            Ok(format!("{document:#}\n").into_bytes())
        }
    }
}

fn discretisation_from_arg(word: DiscretisationArg) -> DiscretisationMethod {
    match word {
        DiscretisationArg::ZeroOrderHold => DiscretisationMethod::ZeroOrderHold,
        DiscretisationArg::Bilinear => DiscretisationMethod::Bilinear,
        DiscretisationArg::Impulse => DiscretisationMethod::ImpulseInvariant,
    }
}
