//! Data sets 58 to channels, responses and spectra.

use super::Set;
use super::codes;
use super::header::Header;
use super::names::{Names, numerator, unit};
use crate::base::error::{Error, Warning};
use crate::base::kind::Kind;
use crate::base::units;
use crate::numeric::Complex;
use crate::recording::column::Column;
use crate::recording::raw::{Clock, Group, Raw, RawChannel, Stamps, rate_of_step};
use crate::recording::resolution::Resolution;
use crate::recording::responses::{FrequencyResponse, FrequencyResponses, Spectrum, Terminal};
use crate::recording::settings::Settings;
use crate::recording::stated_rates::StatedRate;

/// The increment in the header has six digits or more.
const INCREMENT: f64 = 1e-5;

/// Deals the sets out by their type of function.
pub(super) fn assemble(
    sets: Vec<Set>,
    is_si: bool,
    settings: &Settings,
    raw: &mut Raw,
) -> Result<(), Error> {
    let names = Names::of(&sets);
    if let Some(first) = sets.first() {
        let said = first
            .header
            .ids
            .iter()
            .enumerate()
            .filter(|(_, id)| !id.is_empty());
        let facts = said.map(|(at, id)| (format!("header line {}", at + 1), id.clone()));
        raw.facts.extend(facts);
    }
    let context = Context { names, is_si };
    let mut coherences = Vec::new();
    let mut left_out: Vec<&str> = Vec::new();
    let mut responses: Vec<Function> = Vec::new();
    for set in sets {
        let over_time = set.header.abscissa.data_type == codes::TIME;
        let over_frequency = set.header.abscissa.data_type == codes::FREQUENCY;
        match (set.header.function, set.values.im.is_empty()) {
            (codes::TIME_RESPONSE, true) => context.channel(set, settings, raw)?,
            (codes::GENERAL, true) if over_time => context.channel(set, settings, raw)?,
            (codes::FREQUENCY_RESPONSE | codes::TRANSMISSIBILITY, _) => {
                responses.push(context.response(set));
            }
            (codes::COHERENCE | codes::MULTIPLE_COHERENCE, _) => coherences.push(set),
            (2 | 3 | 9 | 10 | 12 | 18 | 20 | 21 | 24, _) => context.spectrum(set, raw),
            (codes::GENERAL, _) if over_frequency => context.spectrum(set, raw),
            (function, _) => {
                left_out.push(codes::FUNCTIONS.get(function).unwrap_or(&"unknown"));
            }
        }
    }
    for set in coherences {
        context.coherence(set, &mut responses, raw);
    }
    raw.responses = together(responses, raw);
    if let Some(responses) = &mut raw.responses {
        responses.add_variances();
    }
    tell_apart(raw);
    if !left_out.is_empty() {
        let count = left_out.len();
        left_out.sort_unstable();
        left_out.dedup();
        raw.warnings.push(Warning {
            code: "functions-left-out",
            message: format!("{count} functions not read: {}", left_out.join(", ")),
            hint: None,
        });
    }
    Ok(())
}

/// A response with its lines and the points it joins.
struct Function {
    header: Header,
    lines: Vec<f64>,
    response: FrequencyResponse,
}

struct Context {
    names: Names,
    is_si: bool,
}

impl Context {
    /// Puts a time response into the group of its clock.
    fn channel(&self, set: Set, settings: &Settings, raw: &mut Raw) -> Result<(), Error> {
        let Set { header, values, .. } = set;
        let scale = time_scale(&header, settings)?;
        let samples = Column::from_slice(&values.re);
        let mut clock = Clock {
            header_samples: Some(header.count),
            start: Some(header.ids[2].clone()).filter(|date| date.contains(':')),
            ..Clock::default()
        };
        let mut same = None;
        if header.is_even {
            let increment = header.step * scale;
            clock.stated_rates = vec![rate(&header, increment)];
            same = raw.groups.iter().position(|group| {
                let channel = group.channels.first();
                group.clock.stated_rates == clock.stated_rates
                    && group.clock.header_samples == clock.header_samples
                    && channel.is_some_and(|c| c.samples.len() == values.re.len())
            });
        } else {
            let start = values.x[0];
            let seconds: Vec<f64> = values.x.iter().map(|x| (x - start) * scale).collect();
            same = position_of(&raw.groups, &seconds)?.or(same);
            let largest = values.x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            clock.stamps = Some(Stamps {
                name: match header.abscissa.label.is_empty() {
                    true => "time".to_string(),
                    false => header.abscissa.label.clone(),
                },
                unit: unit(&header.abscissa, true),
                first: String::new(),
                seconds: Column::from_slice(&seconds),
                // Six digits in text, single precision in bytes.
                resolution: Resolution::fixed(
                    match header.ordinate_kind.is_double && set.is_binary {
                        true => f64::EPSILON * largest * scale,
                        false => 10.0_f64.powf(largest.log10().floor() - 5.0) * scale,
                    },
                ),
            });
        }
        let channel = RawChannel {
            name: self.names.of_response(&header),
            unit: unit(&header.ordinate, self.is_si),
            samples,
            overloads: values.overloads,
        };
        match same.and_then(|at| raw.groups.get_mut(at)) {
            Some(group) => group.channels.push(channel),
            None => raw.groups.push(Group {
                clock,
                channels: vec![channel],
            }),
        }
        Ok(())
    }

    fn response(&self, set: Set) -> Function {
        let lines = lines(&set);
        let response = FrequencyResponse {
            input: self.names.input(&set.header, self.is_si),
            output: Terminal {
                name: self.names.of_response(&set.header),
                unit: numerator(&set.header, self.is_si),
            },
            value: complex(&set),
            ..FrequencyResponse::default()
        };
        Function {
            header: set.header,
            lines,
            response,
        }
    }

    fn spectrum(&self, set: Set, raw: &mut Raw) {
        raw.spectra.push(Spectrum {
            name: self.names.of_response(&set.header),
            unit: set.header.ordinate.unit.clone(),
            kind: codes::FUNCTIONS
                .get(set.header.function)
                .copied()
                .unwrap_or("spectrum"),
            is_decibel: set.header.ordinate.unit.starts_with("dB"),
            frequency_hz: lines(&set),
            value: complex(&set),
        });
    }

    /// Gives a coherence to the responses between the same points; a multiple one to all at its response point.
    fn coherence(&self, set: Set, responses: &mut [Function], raw: &mut Raw) {
        let is_multiple = set.header.function == codes::MULTIPLE_COHERENCE;
        let lines = lines(&set);
        let mut taken = false;
        for function in responses {
            let between = function.header.response == set.header.response
                && (is_multiple || function.header.reference == set.header.reference);
            if between && function.lines == lines && function.response.coherence.is_none() {
                function.response.coherence = Some(set.values.re.clone());
                taken = true;
                if !is_multiple {
                    break;
                }
            }
        }
        if !taken {
            self.spectrum(set, raw);
        }
    }
}

/// The rate by the increment, Hz; by the line that states it with more digits where the two agree.
fn rate(header: &Header, increment: f64) -> StatedRate {
    let (before, after) = codes::RATE_LINE;
    let stated = header.ids[3]
        .strip_prefix(before)
        .and_then(|rest| rest.strip_suffix(after));
    let stated: Option<f64> = stated.and_then(|rate| rate.parse().ok());
    match stated {
        Some(rate) if (rate * increment - 1.0).abs() < INCREMENT => {
            StatedRate::of_samples(rate, "header line 4")
        }
        _ => StatedRate::of_samples(rate_of_step(increment), "abscissa increment"),
    }
}

/// The group whose stamps are these.
fn position_of(groups: &[Group], seconds: &[f64]) -> Result<Option<usize>, Error> {
    for (at, group) in groups.iter().enumerate() {
        let stamps = group.clock.stamps.as_ref().map(|stamps| &stamps.seconds);
        if let Some(stamps) = stamps.filter(|stamps| stamps.len() == seconds.len()) {
            let mut known = vec![0.0; seconds.len()];
            stamps.read(0, &mut known)?;
            if known == seconds {
                return Ok(Some(at));
            }
        }
    }
    Ok(None)
}

/// Seconds in a unit of the abscissa.
fn time_scale(header: &Header, settings: &Settings) -> Result<f64, Error> {
    let written = header.abscissa.unit.as_str();
    match (settings.time_unit.as_deref(), written) {
        (Some(unit), _) => units::parse(&format!("1 {unit}"), Kind::Time, "the unit of time"),
        (None, "" | "s" | "sec" | "S" | "seconds" | "Seconds") => Ok(1.0),
        (None, unit) => units::parse(
            &format!("1 {unit}"),
            Kind::Time,
            "the abscissa of the UFF file",
        ),
    }
}

/// Abscissa, Hz.
fn lines(set: &Set) -> Vec<f64> {
    let scale = match set.header.abscissa.unit.as_str() {
        "kHz" => 1e3,
        "rad/s" | "Rad/s" => std::f64::consts::TAU.recip(),
        "rpm" | "RPM" | "1/min" => 60.0_f64.recip(),
        _ => 1.0,
    };
    let Header { start, step, .. } = set.header;
    match set.header.is_even {
        true => (0..set.values.re.len())
            .map(|k| (start + k as f64 * step) * scale)
            .collect(),
        false => set.values.x.iter().map(|x| x * scale).collect(),
    }
}

fn complex(set: &Set) -> Vec<Complex> {
    let im = |k: usize| set.values.im.get(k).copied().unwrap_or(0.0);
    let values = set.values.re.iter().enumerate();
    values.map(|(k, &re)| Complex::new(re, im(k))).collect()
}

/// The responses over the lines most of them share; the others are said to be left out.
fn together(functions: Vec<Function>, raw: &mut Raw) -> Option<FrequencyResponses> {
    let sharing = |lines: &[f64]| functions.iter().filter(|f| f.lines == lines).count();
    let mut best: Option<(usize, Vec<f64>)> = None;
    for function in &functions {
        if best
            .as_ref()
            .is_some_and(|(_, lines)| *lines == function.lines)
        {
            continue;
        }
        let count = sharing(&function.lines);
        if best.as_ref().is_none_or(|&(most, _)| count > most) {
            best = Some((count, function.lines.clone()));
        }
    }
    let (count, frequency_hz) = best?;
    let others = functions.len() - count;
    if others > 0 {
        raw.warnings.push(Warning {
            code: "functions-left-out",
            message: format!(
                "{others} of {} frequency responses lie on other lines than the rest and are left out",
                functions.len()
            ),
            hint: Some("put them into files of their own".into()),
        });
    }
    let kept: Vec<Function> = (functions.into_iter())
        .filter(|f| f.lines == frequency_hz)
        .collect();
    // What this crate wrote is the same in every set; what differs is not believed.
    let said = |line: usize, words: [&str; 3]| {
        let mut all = kept.iter().map(|f| codes::pair(&f.header.ids[line], words));
        let first = all.next()??;
        all.all(|other| other == Some(first)).then_some(first)
    };
    let behind = said(3, codes::AVERAGES_LINE);
    let usable_hz = said(4, codes::USABLE_LINE).filter(|(low, high)| *low >= 0.0 && low < high);
    let line_independence = said(1, codes::INDEPENDENCE_LINE)
        .map(|(lines, line)| lines / line)
        .filter(|share| *share > 0.0 && *share <= 1.0);
    let functions = kept.into_iter().map(|f| f.response).collect();
    Some(FrequencyResponses {
        frequency_hz,
        functions,
        averages: behind.map(|b| b.0).filter(|n| *n > 0.0),
        window_decay: behind.map_or(0.0, |b| b.1.max(0.0)),
        usable_hz,
        line_independence,
    })
}

/// Channels of one name are numbered.
fn tell_apart(raw: &mut Raw) {
    let mut seen: Vec<String> = Vec::new();
    let channels = raw.groups.iter_mut().flat_map(|group| &mut group.channels);
    for (at, channel) in channels.enumerate() {
        if channel.name.is_empty() {
            channel.name = format!("function {}", at + 1);
        }
        let before = seen.iter().filter(|name| **name == channel.name).count();
        seen.push(channel.name.clone());
        if before > 0 {
            channel.name = format!("{} ({})", channel.name, before + 1);
        }
    }
}
