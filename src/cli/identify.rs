//! `geardyn identify`: frequency responses, transfer functions and modes from a log.

use std::io::Write;
use std::path::Path;

use super::args::IdentifyArgs;
use super::destination::output_error;
use super::logs::{self, Test};
use super::present::Outputs;
use super::{files, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::load;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::identify::transfer::export::{to_mat, write_csv};
use crate::identify::transfer::function::TransferFunction;
use crate::identify::transfer::realisation::{DiscretisationMethod, Realisation};
use crate::plan::logs::identification::{self, IdentificationInput};
use crate::plan::logs::identification_result::IdentificationResult;
use crate::plan::logs::identify_study::IdentifyStudy;
use crate::plan::logs::method::RequiredData;
use crate::plan::logs::mode_comparison::{ModeComparison, ReferenceModes};
use crate::recording::channel_names;
use crate::recording::frequency_responses::FrequencyResponses;
use crate::recording::geometry::Geometry;
use crate::recording::write;
use crate::recording::write::uff::UffFormat;
use crate::report::presentation::{LogReport, Provenance};

/// Runs the command and prints its result.
///
/// # Errors
/// Errors of the log, the flags or the identification.
pub fn run(args: &IdentifyArgs) -> Result<u8, Errors> {
    let flags = &args.study.flags;
    let mut study = flags.read("an identification", None, &[], IdentifyStudy::read)?;
    for (path, formats) in [
        (&args.export, ["json", "csv", "mat"]),
        (&args.frf, ["csv", "json", "uff"]),
    ] {
        if let Some(path) = path {
            files::check_extension(path, &formats)?;
        }
    }
    let logs = logs::open_logs(&args.files, &args.log)?;
    let figures = ["", "nyquist", "poles", "stabilisation", "shapes", "mac"];
    let other_files = [&args.export, &args.frf];
    let inputs = [logs::paths(&logs), args.compare.iter().cloned().collect()].concat();
    let mut outputs = Outputs::check(&args.out, &figures, &other_files, &inputs)?;
    let reference = args.compare.as_deref().map(read_reference).transpose()?;
    let mut log = progress::open(&logs[0].path, &logs[0].options, args.out.quiet)?;
    let responses = log
        .responses
        .take()
        .filter(|r| log.groups.is_empty() || use_file_responses(r, &study));
    if responses.is_some() && logs.len() > 1 {
        let message =
            "the file has frequency responses; only signals of several files can be joined";
        let hint = "identify files of responses separately, or join their columns in one table";
        let error = Error::new(Code::Conflict, message).with_hint(hint);
        return Err(error.with_file(&logs[0].path.display().to_string()).into());
    }
    let mut geometry = logs::geometry(&logs, &mut log)?;
    let identify = |source: IdentificationInput, study: &IdentifyStudy| {
        progress::with_spinner("identifying", args.out.quiet, || {
            identification::identify(source, study)
        })
    };
    let (mut result, repairs) = match responses {
        Some(responses) => {
            let mut result = identify(IdentificationInput::Responses(responses), &study)?;
            result.diagnostics.splice(0..0, log.diagnostics);
            (result, log.repairs)
        }
        None => {
            let test = match study.outputs.is_empty() {
                // Preprocess all channels, so that the error can list them.
                true => Test::Joined(Box::new(logs::preprocess(&logs, log, &[], args.out.quiet)?)),
                false => {
                    reject_duplicates(&study)?;
                    let sides = (&study.inputs[..], &study.outputs[..]);
                    logs::test(&logs, log, sides, args.roving, args.out.quiet)?
                }
            };
            match test {
                Test::Points(records) => {
                    for record in &records {
                        geometry.place_roving(record.inputs.iter().chain(&record.outputs));
                    }
                    let mut result = identify(IdentificationInput::Points(&records), &study)?;
                    let warnings = records.iter().flat_map(|r| &r.recording.diagnostics);
                    result.diagnostics.splice(0..0, distinct(warnings));
                    (
                        result,
                        distinct(records.iter().flat_map(|r| &r.recording.repairs)),
                    )
                }
                Test::Joined(recording) => {
                    if !study.outputs.is_empty() {
                        // The sidecar may have renamed channels; their order is that of the request.
                        let mut names = recording.channels.iter().map(|c| c.name.clone());
                        study.inputs = names.by_ref().take(study.inputs.len()).collect();
                        study.outputs = names.collect();
                    }
                    let mut result = identify(IdentificationInput::Signals(&recording), &study)?;
                    let warnings = recording.diagnostics.iter().cloned();
                    result.diagnostics.splice(0..0, warnings);
                    (result, recording.repairs)
                }
            }
        }
    };
    result.assign_points(geometry.clone())?;
    if let Some(reference) = reference {
        let shapes = result.modes.iter().map(|m| &m.mode.shape[..]);
        let comparison = ModeComparison::new(&result.outputs, shapes, reference)?;
        result.comparison = Some(comparison);
    }
    if let Some(path) = &args.export {
        let bytes = export(path, args, &result)?;
        outputs.write(path, |out| write_all(path, &bytes, out))?;
    }
    if let Some(path) = &args.frf {
        outputs.write(path, |out| write_responses(path, &result, &geometry, out))?;
    }
    outputs.present(&LogReport {
        title: logs::title(&args.files),
        repairs,
        result,
    })
}

/// Reads the reference modes of `--compare`.
fn read_reference(path: &Path) -> Result<ReferenceModes, Error> {
    ReferenceModes::read(&path.display().to_string(), &load::load(path)?.text)
}

/// Messages of several files without duplicates.
fn distinct<'m, T: Clone + PartialEq + 'm>(messages: impl Iterator<Item = &'m T>) -> Vec<T> {
    let mut distinct: Vec<T> = Vec::new();
    for message in messages {
        if !distinct.contains(message) {
            distinct.push(message.clone());
        }
    }
    distinct
}

/// True if the study names responses of a file that also holds signals, and its method accepts responses.
fn use_file_responses(responses: &FrequencyResponses, study: &IdentifyStudy) -> bool {
    let names: Vec<String> = (responses.responses.iter())
        .map(|f| f.output.name.clone())
        .collect();
    let accepts = study
        .method
        .is_none_or(|m| m.required_data() == RequiredData::Responses);
    accepts
        && study
            .outputs
            .iter()
            .all(|word| channel_names::find_channel(word, &names).is_some())
}

/// Rejects a channel named twice, before channels are taken from the log.
fn reject_duplicates(study: &IdentifyStudy) -> Result<(), Error> {
    let channels: Vec<&String> = study.inputs.iter().chain(&study.outputs).collect();
    for (k, word) in channels.iter().enumerate() {
        let is_same = |other: &&&String| {
            channel_names::matches(word, other) || channel_names::matches(other, word)
        };
        if channels[..k].iter().any(|other| is_same(&other)) {
            let is_in_both = study.inputs.contains(word) && study.outputs.contains(word);
            let role = if is_in_both {
                "as input and as output"
            } else {
                "twice"
            };
            let message = format!("{word} is named {role}");
            return Err(Error::new(Code::Conflict, message)
                .with_hint("name each channel once, as excitation or as response"));
        }
    }
    Ok(())
}

/// Error of a file whose content the method does not compute.
fn nothing_to_write(flag: &str, content: &str, result: &IdentificationResult) -> Error {
    let message = format!(
        "{flag} has nothing to write: {} gives no {content}",
        result.method.name()
    );
    Error::new(Code::Usage, message).with_hint(
        "name the excitation channel: --input, and a method from responses such as rational",
    )
}

/// Writes the frequency responses in the format of the file extension.
fn write_responses(
    path: &Path,
    result: &IdentificationResult,
    geometry: &Geometry,
    mut out: &mut dyn Write,
) -> Result<(), Error> {
    let missing_error = || nothing_to_write("--frf", "frequency responses", result);
    let responses = result.responses.as_ref().ok_or_else(missing_error)?;
    match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => write::csv::write_responses(responses, &mut out),
        Some("uff") => write::uff::write_responses(responses, geometry, UffFormat::Text, &mut out),
        _ => write::json::write_responses(responses, &Provenance::default().header(), &mut out),
    }
}

fn write_all(path: &Path, bytes: &[u8], out: &mut dyn Write) -> Result<(), Error> {
    out.write_all(bytes).map_err(|e| output_error(path, &e))
}

/// Encodes the identified model in the format of the file extension.
fn export(
    path: &Path,
    args: &IdentifyArgs,
    result: &IdentificationResult,
) -> Result<Vec<u8>, Error> {
    if result.functions.is_empty() {
        return Err(nothing_to_write("--export", "transfer functions", result));
    }
    let sample_time = args
        .sample_time
        .as_deref()
        .map(|t| quantity::parse_or_bare(t, QuantityKind::Time, "s", "--sample-time"))
        .transpose()?;
    // Accelerations of a stiff residual grow with s²: the state space represents their integrals.
    let (mut proper, mut integrated) = (result.functions.clone(), 0);
    while proper.iter().any(TransferFunction::is_improper) {
        proper = proper
            .iter()
            .map(TransferFunction::integrated)
            .collect::<Result<Vec<_>, Error>>()?;
        integrated += 1;
    }
    let model = || -> Result<Realisation, Error> {
        let model = Realisation::from_transfer_functions(&proper)?;
        match sample_time {
            Some(sample_time) => model.discretise(
                sample_time,
                args.map.unwrap_or(DiscretisationMethod::ZeroOrderHold),
            ),
            None => Ok(model),
        }
    };
    match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => {
            let mut bytes = Vec::new();
            write_csv(&result.functions, &mut bytes).map_err(|e| output_error(path, &e))?;
            Ok(bytes)
        }
        Some("mat") => to_mat(&proper, &model()?),
        _ => {
            let functions = result
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
