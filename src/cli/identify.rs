//! `geardyn identify`: a log becomes frequency responses, transfer functions and modes.

use std::path::{Path, PathBuf};

use super::args::{
    DelayWord, EstimatorWord, IdentifyArgs, KindWord, MapWord, MethodWord, RovingWord,
};
use super::files::{self, Files};
use super::logs::{self, Test};
use super::{epilogue, output, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::kind::Kind;
use crate::base::units;
use crate::identify::rational::Delay;
use crate::identify::transfer::export::{to_mat, write_csv};
use crate::identify::transfer::function::TransferFunction;
use crate::identify::transfer::realisation::{Map, Realisation};
use crate::plan::logs::acquire::EstimateStudy;
use crate::plan::logs::found::Identification;
use crate::plan::logs::identification::{self, Source};
use crate::plan::logs::method::{Method, Needs};
use crate::plan::logs::study::IdentifyStudy;
use crate::recording::names;
use crate::recording::raw::Repair;
use crate::recording::responses::FrequencyResponses;
use crate::recording::settings::Roving;
use crate::recording::write;
use crate::recording::write::uff::Form;
use crate::report;
use crate::spectrum::frf::Estimator;
use crate::spectrum::window::Window;

/// Modes that may be asked for.
const MOST_MODES: usize = 500;

/// Identifies and prints.
///
/// # Errors
/// Whatever is wrong with the log, the flags or the solution.
pub fn run(args: &IdentifyArgs) -> Result<u8, Errors> {
    let mut study = study(args)?;
    let outputs = outputs(args)?;
    let logs = logs::named(&args.files, &args.log)?;
    let files = Files::new(&outputs, &logs::paths(&logs))?;
    let mut raw = progress::open(&logs[0].path, &logs[0].settings, args.quiet)?;
    let responses = raw
        .responses
        .take()
        .filter(|r| raw.groups.is_empty() || are_meant(r, &study));
    if responses.is_some() && logs.len() > 1 {
        let message =
            "the file holds frequency responses; only signals of several files are joined";
        let hint = "identify files of responses one by one, or join their columns in one table";
        let error = Error::new(Code::Conflict, message).hint(hint);
        return Err(error.in_file(&logs[0].path.display().to_string()).into());
    }
    let work = |source: Source, study: &IdentifyStudy| {
        progress::busy("identifying", args.quiet, || {
            identification::identify(source, study)
        })
    };
    let (found, repairs) = match responses {
        Some(responses) => {
            let mut found = work(Source::Responses(responses), &study)?;
            found.warnings.splice(0..0, raw.warnings);
            (found, raw.repairs)
        }
        None => {
            let roving = args.roving.map(|word| match word {
                RovingWord::Input => Roving::Input,
                RovingWord::Output => Roving::Output,
            });
            let test = match study.outputs.is_empty() {
                // All channels are settled, to be named in the error.
                true => Test::Joined(Box::new(logs::settled(&logs, raw, &[], args.quiet)?)),
                false => {
                    refuse_twice(&study)?;
                    let sides = (&study.inputs[..], &study.outputs[..]);
                    logs::test(&logs, raw, sides, roving, args.quiet)?
                }
            };
            match test {
                Test::Points(records) => {
                    let mut found = work(Source::Points(&records), &study)?;
                    let warnings = records.iter().flat_map(|r| &r.recording.warnings);
                    found.warnings.splice(0..0, once(warnings));
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
                    let mut found = work(Source::Signals(&recording), &study)?;
                    let own = recording.warnings.iter().cloned();
                    found.warnings.splice(0..0, own);
                    (found, recording.repairs)
                }
            }
        }
    };
    let written = written(files, args, &found)?;
    if args.json {
        output::document(&report::identified::json(&found, &repairs)?)?;
        return Ok(0);
    }
    output::print(&report::log_tables::identified(&found))?;
    if !args.quiet {
        output::tell(&epilogue(&found, &repairs, &written));
    }
    Ok(0)
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
fn are_meant(responses: &FrequencyResponses, study: &IdentifyStudy) -> bool {
    let known: Vec<String> = (responses.functions.iter())
        .map(|f| f.output.name.clone())
        .collect();
    let takes = study.method.is_none_or(|m| m.needs() == Needs::Responses);
    takes
        && study
            .outputs
            .iter()
            .all(|word| names::find(word, &known).is_some())
}

/// Refuses a channel named twice, before channels are taken out of the log one by one.
fn refuse_twice(study: &IdentifyStudy) -> Result<(), Error> {
    let all: Vec<&String> = study.inputs.iter().chain(&study.outputs).collect();
    for (k, word) in all.iter().enumerate() {
        let same = |other: &&&String| names::means(word, other) || names::means(other, word);
        if all[..k].iter().any(|other| same(&other)) {
            let both = study.inputs.contains(word) && study.outputs.contains(word);
            let how = if both {
                "as input and as output"
            } else {
                "twice"
            };
            return Err(Error::new(Code::Conflict, format!("{word} is named {how}"))
                .hint("name each channel once, as what drives or as what answers"));
        }
    }
    Ok(())
}

fn study(args: &IdentifyArgs) -> Result<IdentifyStudy, Error> {
    let above_zero = |text: &Option<String>, bare, flag, what| {
        let value = text.as_deref().map(|t| above_zero(t, bare, flag, what));
        value.transpose()
    };
    let resolution_hz = above_zero(&args.resolution, HERTZ, "--resolution", "frequency")?;
    if args.overlap.is_some_and(|o| !(0.0..1.0).contains(&o)) {
        return Err(Error::new(
            Code::OutOfRange,
            "--overlap takes a share of a block, at least 0 and below 1",
        )
        .hint("half of it: --overlap 0.5"));
    }
    if args.order == Some(0) {
        return Err(Error::new(Code::OutOfRange, "--order 0 asks for no mode")
            .hint("leave it out: as many modes as are significant"));
    }
    if let Some(order) = args.order.filter(|order| *order > MOST_MODES) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("--order {order} asks for more modes than any band holds; up to {MOST_MODES}"),
        )
        .hint("leave it out: as many modes as are significant"));
    }
    Ok(IdentifyStudy {
        inputs: args.input.clone(),
        outputs: args.output.clone(),
        estimate: EstimateStudy {
            estimator: match args.estimator {
                EstimatorWord::H1 => Estimator::H1,
                EstimatorWord::H2 => Estimator::H2,
                EstimatorWord::Hv => Estimator::Hv,
            },
            window: args.window.as_deref().map(Window::parse).transpose()?,
            resolution_hz,
            overlap: args.overlap,
            impact: said(args.impact, args.no_impact),
            stepped: said(args.stepped, args.no_stepped),
            dwells_s: (args.dwells.iter())
                .map(|text| dwell(text))
                .collect::<Result<_, _>>()?,
        },
        band_hz: args.band.as_deref().map(band).transpose()?,
        order: args.order,
        delay: match args.delay {
            DelayWord::None => Delay::None,
            DelayWord::Common => Delay::Common,
            DelayWord::Each => Delay::PerResponse,
        },
        allow_unstable: args.allow_unstable,
        all: args.all,
        derivative: args.kind.map(|kind| match kind {
            KindWord::Receptance => 0,
            KindWord::Mobility => 1,
            KindWord::Accelerance => 2,
        }),
        method: args.method.map(method_of),
        speed_hz: above_zero(&args.speed, SPEED, "--speed", "speed")?,
        driving_points: args.driving_point.clone(),
        memory_s: above_zero(&args.memory, SECONDS, "--memory", "time")?,
    })
}

/// The unit of a flag's number where bare, and the size in SI of what the study counts in: turns a second where rad/s are SI.
type Bare = (Kind, &'static str, f64);

const HERTZ: Bare = (Kind::Frequency, "Hz", std::f64::consts::TAU);
const SPEED: Bare = (Kind::Speed, "rpm", std::f64::consts::TAU);
const SECONDS: Bare = (Kind::Time, "s", 1.0);

/// A number to the fifteen digits that 2π there and back leaves: 700, not 699.999 999 999 999 9.
fn without_rounding(x: f64) -> f64 {
    format!("{x:.14e}").parse().unwrap_or(x)
}

/// What a flag takes, above zero; `what` it is in words.
fn above_zero(text: &str, (kind, unit, size): Bare, flag: &str, what: &str) -> Result<f64, Error> {
    let value = without_rounding(units::parse_or_bare(text, kind, unit, flag)? / size);
    match value > 0.0 {
        true => Ok(value),
        false => Err(Error::new(
            Code::OutOfRange,
            format!("{flag} takes a {what} above zero"),
        )),
    }
}

/// Of two flags that exclude each other, which was said.
fn said(yes: bool, no: bool) -> Option<bool> {
    (yes || no).then_some(yes)
}

fn method_of(word: MethodWord) -> Method {
    match word {
        MethodWord::Rational => Method::Rational,
        MethodWord::Plscf => Method::Plscf,
        MethodWord::Lsce => Method::Lsce,
        MethodWord::Rfp => Method::Rfp,
        MethodWord::Circle => Method::Circle,
        MethodWord::VectorFitting => Method::VectorFitting,
        MethodWord::Aaa => Method::Aaa,
        MethodWord::SsiCov => Method::SsiCov,
        MethodWord::SsiData => Method::SsiData,
        MethodWord::FreeDecay => Method::FreeDecay,
        MethodWord::Fdd => Method::Fdd,
        MethodWord::Efdd => Method::Efdd,
        MethodWord::Ar => Method::Ar,
        MethodWord::Arma => Method::Arma,
        MethodWord::Arx => Method::Arx,
        MethodWord::Armax => Method::Armax,
        MethodWord::OutputError => Method::OutputError,
        MethodWord::Rls => Method::Rls,
    }
}

/// `A:B`, frequencies, Hz where bare.
pub fn band(text: &str) -> Result<(f64, f64), Error> {
    let hint = "--band takes low:high, such as 10:2000 or \"10 Hz:2 kHz\"";
    range(text, HERTZ, "--band", ("a band", hint))
}

/// `FROM:TO`, s where bare.
fn dwell(text: &str) -> Result<(f64, f64), Error> {
    let hint = "--dwells takes from:to, from:to, …, such as 0.5:2.5,3:5";
    range(text, SECONDS, "--dwells", ("a dwell", hint))
}

/// `A:B` with 0 ≤ A < B; `what` it is in words, and how it is written.
fn range(
    text: &str,
    (kind, unit, size): Bare,
    flag: &str,
    (what, hint): (&str, &str),
) -> Result<(f64, f64), Error> {
    let wrong = || {
        let message = format!("\"{}\" is not {what}", units::shortened(text));
        Error::new(Code::OutOfRange, message).hint(hint)
    };
    let (low, high) = text.split_once(':').ok_or_else(wrong)?;
    let value =
        |t: &str| units::parse_or_bare(t, kind, unit, flag).map(|x| without_rounding(x / size));
    let (low, high) = (value(low)?, value(high)?);
    match low >= 0.0 && low < high {
        true => Ok((low, high)),
        false => Err(wrong()),
    }
}

/// Every file this command will write.
fn outputs(args: &IdentifyArgs) -> Result<Vec<PathBuf>, Error> {
    let mut all: Vec<PathBuf> = args.csv.iter().cloned().collect();
    if let Some(path) = &args.csv {
        files::ends(path, &["csv"])?;
    }
    if let Some(path) = &args.svg {
        files::ends(path, &["svg"])?;
        all.extend(pictures(path));
    }
    if let Some(path) = &args.export {
        files::ends(path, &["json", "csv", "mat"])?;
        all.push(path.clone());
    }
    if let Some(path) = &args.frf {
        files::ends(path, &["csv", "json", "uff"])?;
        all.push(path.clone());
    }
    Ok(all)
}

/// The pictures: the first at the name given, the others beside it.
fn pictures(path: &Path) -> [PathBuf; 4] {
    let beside = |what: &str| {
        let mut name = path.file_stem().unwrap_or_default().to_os_string();
        name.push(what);
        path.with_file_name(name)
    };
    [
        path.to_path_buf(),
        beside("-nyquist.svg"),
        beside("-poles.svg"),
        beside("-stabilisation.svg"),
    ]
}

/// What the method has to show.
fn drawn(path: &Path, name: &str, found: &Identification) -> Result<Vec<(PathBuf, String)>, Error> {
    let [first, nyquist, poles, stabilisation] = pictures(path);
    let diagram =
        report::identified::diagram(found, name).map(|d| report::poles_picture::stabilisation(&d));
    let Some(shown) = report::identified::curves(found, name) else {
        // Without responses the first picture is what the modes were chosen from.
        let course = found.course().map(|c| {
            report::mode_course::draw(c, &format!("{name}: modes in the course of the record"))
        });
        let picture = (course.or(diagram))
            .or_else(|| {
                let shown = report::identified::decomposition(found, name);
                shown.map(|s| report::decomposition_picture::draw(&s))
            })
            .unwrap_or_else(|| {
                let poles: Vec<_> = found.modes.iter().map(|m| m.mode.pole).collect();
                report::poles_picture::pole_zero(&format!("{name}: poles"), &poles, &[])
            });
        return Ok(vec![(first, picture)]);
    };
    let transfer = found.functions.first();
    let crosses = transfer.map_or(Vec::new(), |f| f.poles().to_vec());
    let zeros = transfer
        .map(|f| f.zeros())
        .transpose()?
        .map_or(Vec::new(), |z| z.zeros);
    let title = match found.outputs.first() {
        Some(output) => format!("{name}: poles of all responses, zeros of {}", output.name),
        None => name.to_string(),
    };
    let mut all = vec![
        (first, report::bode::bode(&shown)),
        (nyquist, report::bode::nyquist(&shown)),
        (
            poles,
            report::poles_picture::pole_zero(&title, &crosses, &zeros),
        ),
    ];
    all.extend(diagram.map(|d| (stabilisation, d)));
    Ok(all)
}

/// Writes what was asked for and says what.
fn written(
    mut files: Files,
    args: &IdentifyArgs,
    found: &Identification,
) -> Result<Vec<PathBuf>, Error> {
    let mut all: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    if let Some(path) = &args.csv {
        all.push((path.clone(), report::identified::csv(found).into_bytes()));
    }
    if let Some(path) = &args.svg {
        let drawn = drawn(path, &logs::title(&args.files), found)?;
        all.extend(
            drawn
                .into_iter()
                .map(|(path, text)| (path, text.into_bytes())),
        );
    }
    let none = |flag: &str, what: &str| {
        let message = format!(
            "{flag} has nothing to write: {} gives no {what}",
            found.method.word()
        );
        Error::new(Code::Usage, message)
            .hint("name what drives: --input, and a method from responses such as rational")
    };
    if args.export.is_some() && found.functions.is_empty() {
        return Err(none("--export", "transfer functions"));
    }
    if let Some(path) = &args.export {
        all.push((path.clone(), export(path, args, found)?));
    }
    if let Some(path) = &args.frf {
        let responses = found
            .responses
            .as_ref()
            .ok_or_else(|| none("--frf", "frequency responses"))?;
        let mut bytes = Vec::new();
        match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => write::csv::responses(responses, &mut bytes)?,
            Some("uff") => write::uff::responses(responses, Form::Text, &mut bytes)?,
            _ => write::json::responses(responses, &report::json::log_header(&[]), &mut bytes)?,
        }
        all.push((path.clone(), bytes));
    }
    for (path, bytes) in &all {
        files.write(path, bytes)?;
    }
    files.finish()
}

/// The identified model in the format that the file's name asks for.
fn export(path: &Path, args: &IdentifyArgs, found: &Identification) -> Result<Vec<u8>, Error> {
    let time = args
        .sample_time
        .as_deref()
        .map(|t| units::parse_or_bare(t, Kind::Time, "s", "--sample-time"))
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
        let model = Realisation::of(&proper)?;
        match time {
            Some(time) => model.sampled(time, map_of(args.map)),
            None => Ok(model),
        }
    };
    let failed = |e| {
        Error::new(
            Code::OutputFailed,
            format!("{} could not be written: {e}", path.display()),
        )
    };
    match path.extension().and_then(|e| e.to_str()) {
        Some("csv") => {
            let mut bytes = Vec::new();
            write_csv(&found.functions, &mut bytes).map_err(failed)?;
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

fn map_of(word: MapWord) -> Map {
    match word {
        MapWord::ZeroOrderHold => Map::ZeroOrderHold,
        MapWord::Bilinear => Map::Bilinear,
        MapWord::Impulse => Map::ImpulseInvariant,
    }
}

/// What was done to the data, doubts, what was written.
fn epilogue(found: &Identification, repairs: &[Repair], written: &[PathBuf]) -> String {
    let mut text = String::from("\n");
    text += &epilogue::repairs(repairs);
    for hit in found.hits.iter().filter(|h| h.fault.is_some()) {
        let why = hit.fault.map_or("", |f| f.words());
        let file = (hit.moment.file.as_ref()).map_or(String::new(), |f| format!(" of {f}"));
        text += &format!("hit at {:.4} s{file} left out: {why}\n", hit.moment.time_s);
    }
    text += &epilogue::warnings(&found.warnings);
    text += &epilogue::written(written);
    text
}
