//! `geardyn convert`: a log in another format.

use std::io::Write;

use super::args::ConvertArgs;
use super::files::{self, Files};
use super::{diagnostic, epilogue, output, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::words::counted;
use crate::recording::names;
use crate::recording::raw::Raw;
use crate::recording::responses::FrequencyResponses;
use crate::recording::settings::Settings;
use crate::recording::settle::{self, no_channel};
use crate::recording::signals::Recording;
use crate::recording::write::{self, uff::Form};
use crate::report::json::log_header;
use crate::report::log_tables::rate;

/// Formats by the end of the file's name.
const FORMATS: &[&str] = &["csv", "uff", "json"];

/// What is written.
enum Content {
    Signals(Recording),
    Responses(FrequencyResponses),
}

/// Reads, settles and writes.
///
/// # Errors
/// Whatever is wrong with the log, the flags or the output.
pub fn run(args: &ConvertArgs) -> Result<u8, Errors> {
    files::ends(&args.to, FORMATS)?;
    let format = args.to.extension().and_then(|e| e.to_str()).unwrap_or("");
    if args.binary && format != "uff" {
        return Err(Error::new(
            Code::Usage,
            format!("--binary says how UFF is written, not {format}"),
        )
        .hint("leave it out, or end the name in .uff")
        .into());
    }
    let (settings, sidecar) = args.log.settings(&args.file)?;
    let inputs: Vec<_> = sidecar.into_iter().chain([args.file.clone()]).collect();
    let mut files = Files::new(std::slice::from_ref(&args.to), &inputs)?;
    let raw = progress::open(&args.file, &settings, args.quiet)?;
    let mut told = String::new();
    let content = content(raw, settings, &args.channel, &mut told)?;
    let form = if args.binary {
        Form::Binary
    } else {
        Form::Text
    };
    let name = args.to.display();
    files.write_with(&args.to, |mut to| {
        write_as(&content, format, form, &mut to).map_err(|e| Error {
            message: format!("{name}: {}", e.message),
            ..e
        })
    })?;
    files.finish()?;
    if !args.quiet {
        told += &format!("wrote {}: {}\n", args.to.display(), summary(&content));
        output::tell(&told);
    }
    Ok(0)
}

/// Signals where the file holds them, else responses; only the channels named.
fn content(
    raw: Raw,
    mut settings: Settings,
    words: &[String],
    told: &mut String,
) -> Result<Content, Errors> {
    if raw.groups.is_empty()
        && let Some(responses) = raw.responses
    {
        return Ok(Content::Responses(named(responses, words)?));
    }
    settings.only = words.to_vec();
    let recording = settle::settle(raw, &settings)?;
    *told += &epilogue::repairs(&recording.repairs);
    *told += &epilogue::warnings(&recording.warnings);
    if let Some(start) = &recording.start {
        let start = diagnostic::harmless(start);
        *told += &format!("times are seconds from {start}, the first sample of the log\n");
    }
    Ok(Content::Signals(recording))
}

/// Of the responses those whose output is named; all where none is.
fn named(mut responses: FrequencyResponses, words: &[String]) -> Result<FrequencyResponses, Error> {
    let known: Vec<String> = responses
        .functions
        .iter()
        .map(|f| f.output.name.clone())
        .collect();
    let mut kept = Vec::new();
    for word in words {
        let at = names::find(word, &known).ok_or_else(|| no_channel(word, &known))?;
        kept.push(known[at].clone());
    }
    if !kept.is_empty() {
        responses
            .functions
            .retain(|f| kept.contains(&f.output.name));
    }
    Ok(responses)
}

fn write_as(content: &Content, format: &str, form: Form, to: &mut dyn Write) -> Result<(), Error> {
    let mut to = to;
    let header = log_header(&[]);
    match (content, format) {
        (Content::Signals(r), "csv") => write::csv::signals(r, &mut to),
        (Content::Signals(r), "uff") => write::uff::signals(r, form, &mut to),
        (Content::Signals(r), _) => write::json::signals(r, &header, &mut to),
        (Content::Responses(r), "csv") => write::csv::responses(r, &mut to),
        (Content::Responses(r), "uff") => write::uff::responses(r, form, &mut to),
        (Content::Responses(r), _) => write::json::responses(r, &header, &mut to),
    }
}

fn summary(content: &Content) -> String {
    match content {
        Content::Signals(r) => format!(
            "{}, {} at {} Hz",
            counted(r.channels.len(), "channel"),
            counted(r.samples, "sample"),
            rate(r.rate_hz)
        ),
        Content::Responses(r) => format!(
            "{} over {}",
            counted(r.functions.len(), "response"),
            counted(r.frequency_hz.len(), "line")
        ),
    }
}
