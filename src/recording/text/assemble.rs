//! Rows and header of a delimited text to groups of channels, and every repair listed.

use super::{body, columns, frequency_table, preamble};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::recording::raw::{ChannelGroup, RawChannel, RawLog, RawTiming, Repair, TimeStamps};
use crate::recording::read_options::ReadOptions;
use crate::recording::sample_column::SampleColumn;

/// Puts what was read in its place.
pub(super) fn assemble(
    log: &mut RawLog,
    plan: columns::ColumnPlan,
    mut body: body::TableData,
    said: &preamble::Preamble,
    options: &ReadOptions,
) -> Result<(), Error> {
    let present = |body: &body::TableData, group: Option<usize>| {
        let of = |s: &&columns::ColumnSink| group.is_none_or(|g| s.group == g);
        let sinks = plan.sinks.iter().zip(&body.sinks).filter(|(s, _)| of(s));
        sinks
            .map(|(_, filled)| filled.last_row_with_value)
            .max()
            .unwrap_or(0)
    };
    if present(&body, None) == 0 {
        return Err(Error::new(
            Code::EmptyLog,
            format!("{} holds no number in any row", log.path),
        )
        .with_hint("record again, or check whether the export was finished"));
    }
    for (name, why) in &plan.left_out {
        leave_out(log, name, why);
    }
    log.diagnostics.extend(plan.diagnostics.iter().cloned());
    let trailing = body.rows - present(&body, None);
    if trailing > 0 {
        note(
            log,
            "footer-skipped",
            format!(
                "{} without any number at the end skipped",
                pluralise(trailing, "row")
            ),
        );
    }
    if let Some((count, line, text)) = &body.footer {
        let text = crate::base::quantity::truncate(text.trim());
        note(
            log,
            "footer-skipped",
            format!(
                "{} after the rows skipped, from line {line} on: \"{text}\"",
                pluralise(*count, "line")
            ),
        );
    }
    if let Some((line, text)) = &body.cut {
        let text = crate::base::quantity::truncate(text.trim());
        let message = format!("the last row, line {line}, breaks off and is left out: \"{text}\"");
        note(log, "row-incomplete", message);
    }
    if let Some(first) = body.repeated.first() {
        let message = format!(
            "{} of the header repeated between the rows skipped, the first line {first}: rows on either side are joined, and only time stamps give the time between",
            pluralise(body.repeated.len(), "line")
        );
        note(log, "header-repeated", message);
    }
    if body.time_only_rows > 0 {
        note(
            log,
            "cells-missing",
            format!("only a time in {}", pluralise(body.time_only_rows, "row")),
        );
    }
    let lengths: Vec<usize> = (0..plan.groups)
        .map(|group| present(&body, Some(group)))
        .collect();
    log.groups = lengths.iter().map(|_| ChannelGroup::default()).collect();
    let lines = std::mem::take(&mut body.lines);
    for (sink, mut filled) in plan.sinks.iter().zip(std::mem::take(&mut body.sinks)) {
        let length = lengths[sink.group];
        let cut = body.rows - length;
        filled.samples.truncate(length)?;
        filled.missing = filled.missing.saturating_sub(cut);
        let last = lines
            .line_of_row(length.saturating_sub(1))
            .unwrap_or(usize::MAX);
        filled.lines.retain(|line| *line <= last);
        if filled.missing == length && sink.reader.is_none() && filled.overloads == 0 && length > 0
        {
            leave_out(log, &sink.name, "holds no number in any row");
            continue;
        }
        report_cells(log, sink, &filled);
        let group = &mut log.groups[sink.group];
        match sink.reader.map(|at| &plan.stamp_parsers[at]) {
            Some(reader) => {
                if reader.is_ambiguous() {
                    log.diagnostics.push(Diagnostic {
                        code: "date-order",
                        message: format!(
                            "{} of `{}` may have the day or the month first: only what passed since is known",
                            reader.start, sink.name
                        ),
                        hint: Some("state which comes first: --day-first or --month-first".into()),
                    });
                }
                group.timing.start = (sink.unit == "date-time").then(|| reader.start.clone());
                group.timing.stamps = Some(TimeStamps {
                    name: sink.name.clone(),
                    unit: sink.unit.clone(),
                    first: reader.start.clone(),
                    first_s: reader.first_s(),
                    seconds: filled.samples,
                    resolution: reader.resolution(),
                });
            }
            None => group
                .channels
                .push(channel(sink, filled.samples, filled.overloads)),
        }
    }
    log.groups.retain(|group| !group.channels.is_empty());
    for group in &mut log.groups {
        let start = group.timing.start.take();
        group.timing = RawTiming {
            stamps: group.timing.stamps.take(),
            stated_rates: said.rates.clone(),
            invalid_rate: None,
            header_samples: said.samples,
            start: start.or_else(|| said.start.clone()),
            lines: lines.clone(),
            repeated_header: body.repeated.clone(),
        };
    }
    if log.groups.is_empty() {
        return Err(Error::new(
            Code::EmptyLog,
            format!("{} contains time stamps and no channel", log.path),
        )
        .with_hint("state that no column is the time, if the numbers are a channel: --time none"));
    }
    select_channels(log, options);
    if plan.over_frequency {
        let channels = log.groups.pop().map(|g| g.channels).unwrap_or_default();
        log.responses = Some(frequency_table::responses(&log.path, &channels)?);
        log.groups.clear();
    } else if let Some(channel) = complex_channel(&log.groups, &plan) {
        return Err(Error::new(
            Code::NotANumber,
            format!(
                "`{channel}` of {} contains complex numbers, but no column gives their frequencies",
                log.path
            ),
        )
        .with_hint("add a first column of frequencies, named such as frequency_Hz"));
    }
    Ok(())
}

fn complex_channel(groups: &[ChannelGroup], plan: &columns::ColumnPlan) -> Option<String> {
    let sink = plan.roles.iter().find_map(|role| match role {
        columns::ColumnRole::Complex(sink) => Some(*sink),
        _ => None,
    })?;
    let name = plan.sinks[sink].name.trim_end_matches(" re").to_string();
    (!groups.is_empty()).then_some(name)
}

pub(super) fn note(log: &mut RawLog, kind: &'static str, message: String) {
    log.repairs.push(Repair { kind, message });
}

fn leave_out(log: &mut RawLog, name: &str, why: &'static str) {
    let message = format!("column `{name}` {why}: not a channel");
    note(log, "column-left-out", message);
    log.skipped_columns.push((name.to_string(), why));
}

fn channel(sink: &columns::ColumnSink, samples: SampleColumn, overloads: usize) -> RawChannel {
    RawChannel {
        name: sink.name.clone(),
        unit: sink.unit.clone(),
        samples,
        overloads,
    }
}

/// Says which cells hold no number, and where thousands were grouped.
fn report_cells(log: &mut RawLog, sink: &columns::ColumnSink, filled: &body::ColumnData) {
    let name = &sink.name;
    if filled.missing > 0 {
        let lines: Vec<String> = filled.lines.iter().map(usize::to_string).collect();
        let line = if filled.missing == 1 { "line" } else { "lines" };
        let more = filled.missing.saturating_sub(filled.lines.len());
        let more = if more > 0 {
            format!(" and {more} more")
        } else {
            String::new()
        };
        let overloads = match filled.overloads {
            0 => String::new(),
            n => format!(", {n} of them overloads"),
        };
        note(
            log,
            "cells-missing",
            format!(
                "no number in {} of `{name}`{overloads}: {line} {}{more}",
                pluralise(filled.missing, "cell"),
                lines.join(", ")
            ),
        );
    }
    if filled.grouped > 0 {
        note(
            log,
            "thousands-joined",
            format!(
                "thousands separators in {} of `{name}`",
                pluralise(filled.grouped, "cell")
            ),
        );
    }
}

/// The requested channels, in the requested order.
fn select_channels(log: &mut RawLog, options: &ReadOptions) {
    if options.keep_channels.is_empty() {
        return;
    }
    let place = |name: &str| {
        let means = |word: &String| {
            let renamed = options
                .channels
                .iter()
                .find(|c| c.rename.as_deref() == Some(word.as_str()));
            crate::recording::channel_names::matches(
                renamed.map_or(word.as_str(), |c| c.name.as_str()),
                name,
            )
        };
        options.keep_channels.iter().position(means)
    };
    for group in &mut log.groups {
        group.channels.sort_by_key(|channel| place(&channel.name));
    }
}
