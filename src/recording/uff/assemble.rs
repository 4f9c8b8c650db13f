//! Conversion of data sets 58 to channels, frequency responses and spectra.

use super::DataSet58;
use super::codes;
use super::header::{DofLabel, UffHeader};
use super::names::{PointNames, axis_unit, response_unit};
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::numeric::Complex;
use crate::recording::frequency_responses::{
    ChannelLabel, FrequencyResponse, FrequencyResponses, StoredSpectrum,
};
use crate::recording::raw::{
    ChannelGroup, RawChannel, RawLog, RawTiming, TimeStamps, rate_from_interval,
};
use crate::recording::read_options::ReadOptions;
use crate::recording::resolution::Resolution;
use crate::recording::sample_column::SampleColumn;
use crate::recording::stated_rates::StatedRate;

/// Relative tolerance of the abscissa increment, which the header states with six or more digits.
const INCREMENT_TOLERANCE: f64 = 1e-5;

/// Distributes the data sets to channels, responses and spectra by function type.
pub(super) fn assemble(
    data_sets: Vec<DataSet58>,
    is_si: bool,
    options: &ReadOptions,
    log: &mut RawLog,
) -> Result<(), Error> {
    let names = PointNames::new(&data_sets);
    if let Some(first) = data_sets.first() {
        let lines = first
            .header
            .ids
            .iter()
            .enumerate()
            .filter(|(_, id)| !id.is_empty());
        let entries = lines.map(|(at, id)| (format!("header line {}", at + 1), id.clone()));
        log.metadata.extend(entries);
    }
    let context = FileContext { names, is_si };
    let mut coherences = Vec::new();
    let mut left_out: Vec<&str> = Vec::new();
    let mut responses: Vec<UffResponse> = Vec::new();
    for set in data_sets {
        let over_time = set.header.abscissa.data_type == codes::TIME;
        let over_frequency = set.header.abscissa.data_type == codes::FREQUENCY;
        match (set.header.function, set.values.im.is_empty()) {
            (codes::TIME_RESPONSE, true) => context.channel(set, options, log)?,
            (codes::TYPE_GENERAL, true) if over_time => context.channel(set, options, log)?,
            (codes::FREQUENCY_RESPONSE | codes::TYPE_TRANSMISSIBILITY, _) => {
                responses.push(context.response(set));
            }
            (codes::COHERENCE | codes::TYPE_MULTIPLE_COHERENCE, _) => coherences.push(set),
            (2 | 3 | 9 | 10 | 12 | 18 | 20 | 21 | 24, _) => context.spectrum(set, log),
            (codes::TYPE_GENERAL, _) if over_frequency => context.spectrum(set, log),
            (function, _) => {
                left_out.push(codes::FUNCTION_TYPES.get(function).unwrap_or(&"unknown"));
            }
        }
    }
    for set in coherences {
        context.coherence(set, &mut responses, log);
    }
    log.responses = collect_responses(responses, log);
    if let Some(responses) = &mut log.responses {
        responses.variances_from_coherence();
    }
    make_names_unique(log);
    if !left_out.is_empty() {
        let count = left_out.len();
        left_out.sort_unstable();
        left_out.dedup();
        log.diagnostics.push(Diagnostic {
            code: "functions-left-out",
            message: format!("{count} functions not read: {}", left_out.join(", ")),
            hint: None,
        });
    }
    Ok(())
}

/// Lists the channels of all sets with their degrees of freedom, without duplicates.
pub(super) fn channel_places(data_sets: &[DataSet58]) -> Vec<(String, DofLabel)> {
    let names = PointNames::new(data_sets);
    let mut places: Vec<(String, DofLabel)> = Vec::new();
    for header in data_sets.iter().map(|set| &set.header) {
        let ends = [
            (names.response_name(header), &header.response),
            (names.point_name(&header.reference), &header.reference),
        ];
        for (name, dof) in ends {
            if dof.node != 0 && !places.iter().any(|(known, _)| *known == name) {
                places.push((name, dof.clone()));
            }
        }
    }
    places
}

/// Response with its header and its lines, Hz.
struct UffResponse {
    header: UffHeader,
    lines: Vec<f64>,
    response: FrequencyResponse,
}

struct FileContext {
    names: PointNames,
    is_si: bool,
}

impl FileContext {
    /// Adds a time response to the channel group of its clock.
    fn channel(
        &self,
        set: DataSet58,
        options: &ReadOptions,
        log: &mut RawLog,
    ) -> Result<(), Error> {
        let DataSet58 { header, values, .. } = set;
        let scale = time_scale(&header, options)?;
        let samples = SampleColumn::from_slice(&values.re);
        let mut timing = RawTiming {
            header_samples: Some(header.count),
            start: Some(header.ids[2].clone()).filter(|date| date.contains(':')),
            ..RawTiming::default()
        };
        let mut group_index = None;
        if header.is_uniform {
            let increment = header.step * scale;
            timing.stated_rates = vec![rate(&header, increment)];
            group_index = log.groups.iter().position(|group| {
                let channel = group.channels.first();
                group.timing.stated_rates == timing.stated_rates
                    && group.timing.header_samples == timing.header_samples
                    && channel.is_some_and(|c| c.samples.len() == values.re.len())
            });
        } else {
            let start = values.x[0];
            let seconds: Vec<f64> = values.x.iter().map(|x| (x - start) * scale).collect();
            group_index = position_of(&log.groups, &seconds)?.or(group_index);
            let largest = values.x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            timing.stamps = Some(TimeStamps {
                name: match header.abscissa.label.is_empty() {
                    true => "time".to_string(),
                    false => header.abscissa.label.clone(),
                },
                unit: axis_unit(&header.abscissa, true),
                first: String::new(),
                first_s: start * scale,
                seconds: SampleColumn::from_slice(&seconds),
                // Text has six digits, binary data single precision.
                resolution: Resolution::constant(
                    match header.ordinate_kind.is_double && set.is_binary {
                        true => f64::EPSILON * largest * scale,
                        false => 10.0_f64.powf(largest.log10().floor() - 5.0) * scale,
                    },
                ),
            });
        }
        let channel = RawChannel {
            name: self.names.response_name(&header),
            unit: axis_unit(&header.ordinate, self.is_si),
            samples,
            overloads: values.overloads,
        };
        match group_index.and_then(|at| log.groups.get_mut(at)) {
            Some(group) => group.channels.push(channel),
            None => log.groups.push(ChannelGroup {
                timing,
                channels: vec![channel],
            }),
        }
        Ok(())
    }

    fn response(&self, set: DataSet58) -> UffResponse {
        let lines = abscissa_hz(&set);
        let response = FrequencyResponse {
            input: self.names.input(&set.header, self.is_si),
            output: ChannelLabel {
                name: self.names.response_name(&set.header),
                unit: response_unit(&set.header, self.is_si),
            },
            values: complex(&set),
            ..FrequencyResponse::default()
        };
        UffResponse {
            header: set.header,
            lines,
            response,
        }
    }

    fn spectrum(&self, set: DataSet58, log: &mut RawLog) {
        log.spectra.push(StoredSpectrum {
            name: self.names.response_name(&set.header),
            unit: set.header.ordinate.unit.clone(),
            kind: codes::FUNCTION_TYPES
                .get(set.header.function)
                .copied()
                .unwrap_or("spectrum"),
            is_decibel: set.header.ordinate.unit.starts_with("dB"),
            frequency_hz: abscissa_hz(&set),
            values: complex(&set),
        });
    }

    /// Assigns a coherence to the response between the same points, a multiple coherence to all responses at its response point.
    fn coherence(&self, set: DataSet58, responses: &mut [UffResponse], log: &mut RawLog) {
        let is_multiple = set.header.function == codes::TYPE_MULTIPLE_COHERENCE;
        let lines = abscissa_hz(&set);
        let mut is_assigned = false;
        for function in responses {
            let is_match = function.header.response == set.header.response
                && (is_multiple || function.header.reference == set.header.reference);
            if is_match && function.lines == lines && function.response.coherence.is_none() {
                function.response.coherence = Some(set.values.re.clone());
                is_assigned = true;
                if !is_multiple {
                    break;
                }
            }
        }
        if !is_assigned {
            self.spectrum(set, log);
        }
    }
}

/// Sample rate by the increment, s; the rate of header line 4, which has more digits, if the two agree.
fn rate(header: &UffHeader, increment: f64) -> StatedRate {
    let (before, after) = codes::RATE_LINE;
    let stated = header.ids[3]
        .strip_prefix(before)
        .and_then(|rest| rest.strip_suffix(after));
    let stated: Option<f64> = stated.and_then(|rate| rate.parse().ok());
    match stated {
        Some(rate) if (rate * increment - 1.0).abs() < INCREMENT_TOLERANCE => {
            StatedRate::is_sample_rate(rate, "header line 4")
        }
        _ => StatedRate::is_sample_rate(rate_from_interval(increment), "abscissa increment"),
    }
}

/// Index of the group with these stamps, s.
fn position_of(groups: &[ChannelGroup], seconds: &[f64]) -> Result<Option<usize>, Error> {
    for (at, group) in groups.iter().enumerate() {
        let stamps = group.timing.stamps.as_ref().map(|stamps| &stamps.seconds);
        if let Some(stamps) = stamps.filter(|stamps| stamps.len() == seconds.len()) {
            let mut times = vec![0.0; seconds.len()];
            stamps.read(0, &mut times)?;
            if times == seconds {
                return Ok(Some(at));
            }
        }
    }
    Ok(None)
}

/// Factor of the abscissa unit to seconds.
fn time_scale(header: &UffHeader, options: &ReadOptions) -> Result<f64, Error> {
    let written = header.abscissa.unit.as_str();
    match (options.time_unit.as_deref(), written) {
        (Some(unit), _) => {
            quantity::parse(&format!("1 {unit}"), QuantityKind::Time, "the unit of time")
        }
        (None, "" | "s" | "sec" | "S" | "seconds" | "Seconds") => Ok(1.0),
        (None, unit) => quantity::parse(
            &format!("1 {unit}"),
            QuantityKind::Time,
            "the abscissa of the UFF file",
        ),
    }
}

/// Abscissa, Hz.
fn abscissa_hz(set: &DataSet58) -> Vec<f64> {
    let scale = match set.header.abscissa.unit.as_str() {
        "kHz" => 1e3,
        "rad/s" | "Rad/s" => std::f64::consts::TAU.recip(),
        "rpm" | "RPM" | "1/min" => 60.0_f64.recip(),
        _ => 1.0,
    };
    let UffHeader { start, step, .. } = set.header;
    match set.header.is_uniform {
        true => (0..set.values.re.len())
            .map(|k| (start + k as f64 * step) * scale)
            .collect(),
        false => set.values.x.iter().map(|x| x * scale).collect(),
    }
}

fn complex(set: &DataSet58) -> Vec<Complex> {
    let im = |k: usize| set.values.im.get(k).copied().unwrap_or(0.0);
    let values = set.values.re.iter().enumerate();
    values.map(|(k, &re)| Complex::new(re, im(k))).collect()
}

/// Collects the responses over the most common lines; reports the others as left out.
fn collect_responses(functions: Vec<UffResponse>, log: &mut RawLog) -> Option<FrequencyResponses> {
    let count_sharing = |lines: &[f64]| functions.iter().filter(|f| f.lines == lines).count();
    let mut best: Option<(usize, Vec<f64>)> = None;
    for function in &functions {
        if best
            .as_ref()
            .is_some_and(|(_, lines)| *lines == function.lines)
        {
            continue;
        }
        let count = count_sharing(&function.lines);
        if best.as_ref().is_none_or(|&(largest, _)| count > largest) {
            best = Some((count, function.lines.clone()));
        }
    }
    let (count, frequency_hz) = best?;
    let others = functions.len() - count;
    if others > 0 {
        log.diagnostics.push(Diagnostic {
            code: "functions-left-out",
            message: format!(
                "{others} of {} frequency responses lie on other lines than the rest and are left out",
                functions.len()
            ),
            hint: Some("put them into separate files".into()),
        });
    }
    let sets: Vec<UffResponse> = (functions.into_iter())
        .filter(|f| f.lines == frequency_hz)
        .collect();
    // Values written by this crate are equal in all sets; differing values are ignored.
    let shared = |line: usize, words: [&str; 3]| {
        let mut pairs = sets.iter().map(|f| codes::pair(&f.header.ids[line], words));
        let first = pairs.next()??;
        pairs.all(|other| other == Some(first)).then_some(first)
    };
    let averaging = shared(3, codes::AVERAGES_LINE);
    let usable_hz = shared(4, codes::USABLE_LINE).filter(|(low, high)| *low >= 0.0 && low < high);
    let line_independence = shared(1, codes::INDEPENDENCE_LINE)
        .map(|(lines, line)| lines / line)
        .filter(|share| *share > 0.0 && *share <= 1.0);
    let functions = sets.into_iter().map(|f| f.response).collect();
    Some(FrequencyResponses {
        frequency_hz,
        responses: functions,
        averages: averaging.map(|b| b.0).filter(|n| *n > 0.0),
        window_decay: averaging.map_or(0.0, |b| b.1.max(0.0)),
        usable_band_hz: usable_hz,
        independent_lines_per_line: line_independence,
    })
}

/// Numbers the channels of equal names.
fn make_names_unique(log: &mut RawLog) {
    let mut names: Vec<String> = Vec::new();
    let channels = log.groups.iter_mut().flat_map(|group| &mut group.channels);
    for (at, channel) in channels.enumerate() {
        if channel.name.is_empty() {
            channel.name = format!("function {}", at + 1);
        }
        let earlier = names.iter().filter(|name| **name == channel.name).count();
        names.push(channel.name.clone());
        if earlier > 0 {
            channel.name = format!("{} ({})", channel.name, earlier + 1);
        }
    }
}
