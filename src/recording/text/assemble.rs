//! Rows and header of a delimited text to groups of channels, and every repair listed.

use super::{body, columns, preamble, table};
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::words::counted;
use crate::recording::column::Column;
use crate::recording::raw::{Clock, Group, Raw, RawChannel, Repair, Stamps};
use crate::recording::settings::Settings;

/// Puts what was read in its place.
pub(super) fn assemble(
    raw: &mut Raw,
    plan: columns::Plan,
    mut body: body::Body,
    said: &preamble::Preamble,
    settings: &Settings,
) -> Result<(), Error> {
    let present = |body: &body::Body, group: Option<usize>| {
        let of = |s: &&columns::Sink| group.is_none_or(|g| s.group == g);
        let sinks = plan.sinks.iter().zip(&body.sinks).filter(|(s, _)| of(s));
        sinks.map(|(_, filled)| filled.present).max().unwrap_or(0)
    };
    if present(&body, None) == 0 {
        return Err(Error::new(
            Code::EmptyLog,
            format!("{} holds no number in any row", raw.path),
        )
        .hint("record again, or look whether the export was finished"));
    }
    for (name, why) in &plan.left_out {
        leave_out(raw, name, why);
    }
    raw.warnings.extend(plan.warnings.iter().cloned());
    let trailing = body.rows - present(&body, None);
    if trailing > 0 {
        note(
            raw,
            "footer-skipped",
            format!(
                "{} without any number at the end passed over",
                counted(trailing, "row")
            ),
        );
    }
    if let Some((count, line, text)) = &body.footer {
        let text = crate::base::units::shortened(text.trim());
        note(
            raw,
            "footer-skipped",
            format!(
                "{} after the rows passed over, from line {line} on: \"{text}\"",
                counted(*count, "line")
            ),
        );
    }
    if let Some((line, text)) = &body.cut {
        let text = crate::base::units::shortened(text.trim());
        let message = format!("the last row, line {line}, breaks off and is left out: \"{text}\"");
        note(raw, "row-incomplete", message);
    }
    if let Some((count, first)) = body.repeated {
        let message = format!(
            "{} of the header repeated between the rows passed over, the first line {first}: rows on either side are joined, and only time stamps tell what passed",
            counted(count, "line")
        );
        note(raw, "header-repeated", message);
    }
    if body.only_time > 0 {
        note(
            raw,
            "cells-missing",
            format!("only a time in {}", counted(body.only_time, "row")),
        );
    }
    let lengths: Vec<usize> = (0..plan.groups)
        .map(|group| present(&body, Some(group)))
        .collect();
    raw.groups = lengths.iter().map(|_| Group::default()).collect();
    let lines = std::mem::take(&mut body.lines);
    for (sink, mut filled) in plan.sinks.iter().zip(std::mem::take(&mut body.sinks)) {
        let length = lengths[sink.group];
        let cut = body.rows - length;
        filled.samples.truncate(length)?;
        filled.missing = filled.missing.saturating_sub(cut);
        let last = lines.of(length.saturating_sub(1)).unwrap_or(usize::MAX);
        filled.lines.retain(|line| *line <= last);
        if filled.missing == length && sink.reader.is_none() && filled.overloads == 0 && length > 0
        {
            leave_out(raw, &sink.name, "holds no number in any row");
            continue;
        }
        report_cells(raw, sink, &filled);
        let group = &mut raw.groups[sink.group];
        match sink.reader.map(|at| &plan.readers[at]) {
            Some(reader) => {
                if reader.is_in_doubt() {
                    raw.warnings.push(Warning {
                        code: "date-order",
                        message: format!(
                            "{} of `{}` may have the day or the month first: only what passed since is known",
                            reader.start, sink.name
                        ),
                        hint: Some("say which comes first: --day-first or --month-first".into()),
                    });
                }
                group.clock.start = (sink.unit == "date-time").then(|| reader.start.clone());
                group.clock.stamps = Some(Stamps {
                    name: sink.name.clone(),
                    unit: sink.unit.clone(),
                    first: reader.start.clone(),
                    seconds: filled.samples,
                    resolution: reader.resolution(),
                });
            }
            None => group
                .channels
                .push(channel(sink, filled.samples, filled.overloads)),
        }
    }
    raw.groups.retain(|group| !group.channels.is_empty());
    for group in &mut raw.groups {
        let start = group.clock.start.take();
        group.clock = Clock {
            stamps: group.clock.stamps.take(),
            stated_rates: said.rates.clone(),
            unread_rate: None,
            header_samples: said.samples,
            start: start.or_else(|| said.start.clone()),
            lines: lines.clone(),
        };
    }
    if raw.groups.is_empty() {
        return Err(Error::new(
            Code::EmptyLog,
            format!("{} holds time stamps and no channel", raw.path),
        )
        .hint("say that no column is the time, if the numbers are a channel: --time none"));
    }
    in_order(raw, settings);
    if plan.over_frequency {
        let channels = raw.groups.pop().map(|g| g.channels).unwrap_or_default();
        raw.responses = Some(table::responses(&raw.path, &channels)?);
        raw.groups.clear();
    } else if let Some(channel) = complex_channel(&raw.groups, &plan) {
        return Err(Error::new(
            Code::NotANumber,
            format!(
                "`{channel}` of {} holds complex numbers, and no column gives their frequencies",
                raw.path
            ),
        )
        .hint(
            "frequency responses need a first column of frequencies, named such as frequency_Hz",
        ));
    }
    Ok(())
}

fn complex_channel(groups: &[Group], plan: &columns::Plan) -> Option<String> {
    let sink = plan.roles.iter().find_map(|role| match role {
        columns::Role::Complex(sink) => Some(*sink),
        _ => None,
    })?;
    let name = plan.sinks[sink].name.trim_end_matches(" re").to_string();
    (!groups.is_empty()).then_some(name)
}

pub(super) fn note(raw: &mut Raw, kind: &'static str, message: String) {
    raw.repairs.push(Repair { kind, message });
}

fn leave_out(raw: &mut Raw, name: &str, why: &'static str) {
    let message = format!("column `{name}` {why}: it is no channel");
    note(raw, "column-left-out", message);
    raw.left_out.push((name.to_string(), why));
}

fn channel(sink: &columns::Sink, samples: Column, overloads: usize) -> RawChannel {
    RawChannel {
        name: sink.name.clone(),
        unit: sink.unit.clone(),
        samples,
        overloads,
    }
}

/// Says which cells hold no number, and where thousands were grouped.
fn report_cells(raw: &mut Raw, sink: &columns::Sink, filled: &body::Filled) {
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
            raw,
            "cells-missing",
            format!(
                "no number in {} of `{name}`{overloads}: {line} {}{more}",
                counted(filled.missing, "cell"),
                lines.join(", ")
            ),
        );
    }
    if filled.grouped > 0 {
        note(
            raw,
            "thousands-joined",
            format!(
                "thousands separators in {} of `{name}`",
                counted(filled.grouped, "cell")
            ),
        );
    }
}

/// The channels asked for, in the order asked for.
fn in_order(raw: &mut Raw, settings: &Settings) {
    if settings.only.is_empty() {
        return;
    }
    let place = |name: &str| {
        let means = |word: &String| {
            let renamed = settings
                .channels
                .iter()
                .find(|c| c.rename.as_deref() == Some(word.as_str()));
            crate::recording::names::means(renamed.map_or(word.as_str(), |c| c.name.as_str()), name)
        };
        settings.only.iter().position(means)
    };
    for group in &mut raw.groups {
        group.channels.sort_by_key(|channel| place(&channel.name));
    }
}
