//! `geardyn identify`: a log becomes frequency responses, transfer functions and modes.

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

/// Identifies and prints.
///
/// # Errors
/// Whatever is wrong with the log, the flags or the solution.
pub fn run(args: &IdentifyArgs) -> Result<u8, Errors> {
    let flags = &args.study.flags;
    let mut study = flags.read("an identification", None, &[], IdentifyStudy::read)?;
    for (path, formats) in [
        (&args.export, ["json", "csv", "mat"]),
        (&args.frf, ["csv", "json", "uff"]),
    ] {
        if let Some(path) = path {
            files::ends(path, &formats)?;
        }
    }
    let logs = logs::open_logs(&args.files, &args.log)?;
    let figures = ["", "nyquist", "poles", "stabilisation", "shapes", "mac"];
    let others = [&args.export, &args.frf];
    let inputs = [logs::paths(&logs), args.compare.iter().cloned().collect()].concat();
    let mut outputs = Outputs::check(&args.out, &figures, &others, &inputs)?;
    let reference = args.compare.as_deref().map(read_reference).transpose()?;
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
    let mut geometry = logs::geometry(&logs, &mut log)?;
    let work = |source: IdentificationInput, study: &IdentifyStudy| {
        progress::with_spinner("identifying", args.out.quiet, || {
            identification::identify(source, study)
        })
    };
    let (mut found, repairs) = match responses {
        Some(responses) => {
            let mut found = work(IdentificationInput::Responses(responses), &study)?;
            found.diagnostics.splice(0..0, log.diagnostics);
            (found, log.repairs)
        }
        None => {
            let test = match study.outputs.is_empty() {
                // All channels are settled, to be named in the error.
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
    found.place_shapes(geometry.clone())?;
    if let Some(reference) = reference {
        let shapes = found.modes.iter().map(|m| &m.mode.shape[..]);
        let comparison = ModeComparison::new(&found.outputs, shapes, reference)?;
        found.comparison = Some(comparison);
    }
    if let Some(path) = &args.export {
        let bytes = export(path, args, &found)?;
        outputs.write(path, |to| write_all(path, &bytes, to))?;
    }
    if let Some(path) = &args.frf {
        outputs.write(path, |to| write_responses(path, &found, &geometry, to))?;
    }
    outputs.present(&LogReport {
        title: logs::title(&args.files),
        repairs,
        result: found,
    })
}

/// The modes to compare with.
fn read_reference(path: &Path) -> Result<ReferenceModes, Error> {
    ReferenceModes::read(&path.display().to_string(), &load::load(path)?.text)
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

/// True if the names are responses of a file that also holds signals.
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
                .with_hint("name each channel once, as excitation or as response"));
        }
    }
    Ok(())
}

/// Refuses to write what the method does not give.
fn nothing_to_write(flag: &str, what: &str, found: &IdentificationResult) -> Error {
    let message = format!(
        "{flag} has nothing to write: {} gives no {what}",
        found.method.name()
    );
    Error::new(Code::Usage, message).with_hint(
        "name the excitation channel: --input, and a method from responses such as rational",
    )
}

/// Writes the frequency responses in the format that the file's name asks for.
fn write_responses(
    path: &Path,
    found: &IdentificationResult,
    geometry: &Geometry,
    mut to: &mut dyn Write,
) -> Result<(), Error> {
    let missing = || nothing_to_write("--frf", "frequency responses", found);
    let responses = found.responses.as_ref().ok_or_else(missing)?;
    match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => write::csv::write_responses(responses, &mut to),
        Some("uff") => write::uff::write_responses(responses, geometry, UffFormat::Text, &mut to),
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
            Some(time) => model.discretise(
                time,
                args.map.unwrap_or(DiscretisationMethod::ZeroOrderHold),
            ),
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
