//! `geardyn convert`: a log in another format.

use std::io::Write;

use super::args::ConvertArgs;
use super::files::{self, OutputFiles};
use super::{footer, output, progress, render};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::text::pluralise;
use crate::recording::channel_names;
use crate::recording::frequency_responses::FrequencyResponses;
use crate::recording::geometry::Geometry;
use crate::recording::preprocess::{self, unknown_channel};
use crate::recording::raw::RawLog;
use crate::recording::read_options::ReadOptions;
use crate::recording::signals::Recording;
use crate::recording::write::{self, uff::UffFormat};
use crate::report::presentation::Provenance;
use crate::report::recording::rate;

/// Formats by the end of the file's name.
const FORMATS: &[&str] = &["csv", "uff", "json"];

/// Format of the output.
enum Content {
    Signals(Recording),
    Responses(FrequencyResponses),
}

/// Reads, settles and writes.
///
/// # Errors
/// Whatever is wrong with the log, the flags or the output.
pub fn run(args: &ConvertArgs) -> Result<u8, Errors> {
    files::check_extension(&args.to, FORMATS)?;
    let format = args.to.extension().and_then(|e| e.to_str()).unwrap_or("");
    if args.binary && format != "uff" {
        return Err(Error::new(
            Code::Usage,
            format!("--binary applies to UFF, not to {format}"),
        )
        .with_hint("omit it, or end the name in .uff")
        .into());
    }
    let (options, sidecar) = args.log.options(&args.file)?;
    let inputs: Vec<_> = sidecar.into_iter().chain([args.file.clone()]).collect();
    let mut files = OutputFiles::new(std::slice::from_ref(&args.to), &inputs)?;
    let mut log = progress::open(&args.file, &options, args.quiet)?;
    let geometry = match options.geometry.is_empty() {
        true => std::mem::take(&mut log.geometry),
        false => options.geometry.clone(),
    };
    let mut told = String::new();
    let content = content(log, options, &args.channel, &mut told)?;
    let form = if args.binary {
        UffFormat::Binary
    } else {
        UffFormat::Text
    };
    let name = args.to.display();
    files.write_with(&args.to, |mut to| {
        write_as(&content, &geometry, (format, form), &mut to).map_err(|e| Error {
            message: format!("{name}: {}", e.message),
            ..e
        })
    })?;
    files.finish()?;
    if !args.quiet {
        told += &format!("wrote {}: {}\n", args.to.display(), summary(&content));
        output::print_note(&told);
    }
    Ok(0)
}

/// Signals where the file holds them, else responses; only the channels named.
fn content(
    raw_log: RawLog,
    mut options: ReadOptions,
    words: &[String],
    told: &mut String,
) -> Result<Content, Errors> {
    if raw_log.groups.is_empty()
        && let Some(responses) = raw_log.responses
    {
        return Ok(Content::Responses(select_outputs(responses, words)?));
    }
    options.keep_channels = words.to_vec();
    let recording = preprocess::preprocess(raw_log, &options)?;
    *told += &footer::repairs(&recording.repairs);
    *told += &footer::warnings(&recording.diagnostics);
    if let Some(start) = &recording.start {
        let start = render::sanitise(start);
        *told += &format!("times are seconds from {start}, the first sample of the log\n");
    }
    Ok(Content::Signals(recording))
}

/// Responses whose output is named; all by default.
fn select_outputs(
    mut responses: FrequencyResponses,
    words: &[String],
) -> Result<FrequencyResponses, Error> {
    let known: Vec<String> = responses
        .responses
        .iter()
        .map(|f| f.output.name.clone())
        .collect();
    let mut kept = Vec::new();
    for word in words {
        let at = channel_names::find_channel(word, &known)
            .ok_or_else(|| unknown_channel(word, &known))?;
        kept.push(known[at].clone());
    }
    if !kept.is_empty() {
        responses
            .responses
            .retain(|f| kept.contains(&f.output.name));
    }
    Ok(responses)
}

fn write_as(
    content: &Content,
    geometry: &Geometry,
    (format, form): (&str, UffFormat),
    to: &mut dyn Write,
) -> Result<(), Error> {
    let mut to = to;
    let header = Provenance::default().header();
    match (content, format) {
        (Content::Signals(r), "csv") => write::csv::write_recording(r, &mut to),
        (Content::Signals(r), "uff") => write::uff::write_recording(r, geometry, form, &mut to),
        (Content::Signals(r), _) => write::json::write_recording(r, &header, &mut to),
        (Content::Responses(r), "csv") => write::csv::write_responses(r, &mut to),
        (Content::Responses(r), "uff") => write::uff::write_responses(r, geometry, form, &mut to),
        (Content::Responses(r), _) => write::json::write_responses(r, &header, &mut to),
    }
}

fn summary(content: &Content) -> String {
    match content {
        Content::Signals(r) => format!(
            "{}, {} at {} Hz",
            pluralise(r.channels.len(), "channel"),
            pluralise(r.samples, "sample"),
            rate(r.rate_hz)
        ),
        Content::Responses(r) => format!(
            "{} over {}",
            pluralise(r.responses.len(), "response"),
            pluralise(r.frequency_hz.len(), "line")
        ),
    }
}
