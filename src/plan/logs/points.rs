//! Roving tests: frequency responses of records at different points, by a roving sensor or a roving hammer, joined into one matrix
//! `H_oi`.
//!
//! A linear structure is reciprocal, `H_oi = H_io` (Ewins, Modal Testing, 2nd ed. (2000), §2.3): responses of one fixed sensor to forces
//! at many points are those of these points to a force at the sensor.

use super::fault_free::{self, CheckedRecording};
use super::frf_estimation::{self, EstimatedResponses, FrfStudy, ResolutionRequest};
use super::segment_samples;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::{pluralise, quoted_list};
use crate::recording::frequency_responses::{
    FrequencyResponse, FrequencyResponses, line_spacing_hz,
};
use crate::recording::join::EQUAL_RATES;
use crate::recording::signals::Recording;
use crate::spectrum::window::Window;

/// Record of some points of a roving test.
#[derive(Debug)]
pub struct PointRecord {
    /// Recording of the signals at the point.
    pub recording: Recording,
    /// Input channels and their points.
    pub inputs: Vec<(String, String)>,
    /// Output channels and their points.
    pub outputs: Vec<(String, String)>,
}

/// Checked records of a roving test.
#[derive(Debug)]
pub struct Points<'a>(Vec<CheckedRecord<'a>>);

#[derive(Debug)]
struct CheckedRecord<'a> {
    record: &'a PointRecord,
    sound: CheckedRecording,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
}

impl<'a> Points<'a> {
    /// Checks every record, the rates, and that no response is measured twice.
    ///
    /// # Errors
    /// `no-channel`, `no-signal`, `conflict`, `rate-disagrees`, each with the file.
    pub fn new(records: &'a [PointRecord]) -> Result<Points<'a>, Error> {
        let mut checked_records: Vec<CheckedRecord> = Vec::new();
        for record in records {
            let recording = &record.recording;
            let check = || -> Result<CheckedRecord, Error> {
                let channels = |terminals: &[(String, String)]| {
                    let names: Vec<String> = terminals.iter().map(|s| s.0.clone()).collect();
                    segment_samples::channel_indices(recording, &names)
                };
                let (inputs, outputs) = (channels(&record.inputs)?, channels(&record.outputs)?);
                segment_samples::check_channels(recording, &inputs, &outputs)?;
                Ok(CheckedRecord {
                    record,
                    sound: fault_free::without_faults(recording, &inputs, &outputs)?,
                    inputs,
                    outputs,
                })
            };
            checked_records.push(check().map_err(|e| e.with_file(&recording.path))?);
        }
        let points = Points(checked_records);
        points.check_duplicates()?;
        points.check_rates()?;
        Ok(points)
    }

    /// File of each record and the index range of its responses.
    pub fn files(&self) -> Vec<(&str, std::ops::Range<usize>)> {
        let mut offset = 0;
        let file_range = |p: &CheckedRecord<'a>| {
            let range = offset..offset + pairs(p.record).count();
            offset = range.end;
            (p.record.recording.path.as_str(), range)
        };
        self.0.iter().map(file_range).collect()
    }

    /// True if gaps split a record into segments.
    pub fn has_gaps(&self) -> bool {
        self.0.iter().any(|p| p.sound.recording.segments.len() > 1)
    }

    /// Rejects a response that two files contain.
    fn check_duplicates(&self) -> Result<(), Error> {
        let mut measured: Vec<(&str, &str, &str)> = Vec::new();
        for record in self.0.iter().map(|p| p.record) {
            for (output, input) in pairs(record) {
                let path = record.recording.path.as_str();
                if let Some(duplicate) = measured.iter().find(|k| (k.0, k.1) == (output, input)) {
                    let message = match duplicate.2 == path {
                        true => format!("{path} is named twice"),
                        false => format!(
                            "{output} over {input} is measured in {} and in {path}, which differ in their other channels",
                            duplicate.2
                        ),
                    };
                    return Err(Error::new(Code::Conflict, message).with_hint(
                        match duplicate.2 == path {
                            true => "name every file once",
                            false => "name fewer channels, or give --roving: files of one point need equal channels, files of several points different responses",
                        },
                    ));
                }
                measured.push((output, input, path));
            }
        }
        Ok(())
    }

    fn check_rates(&self) -> Result<(), Error> {
        let rate = |p: &CheckedRecord| p.sound.recording.rate_hz;
        let first = self.0.first().map_or(0.0, rate);
        match self
            .0
            .iter()
            .find(|p| (rate(p) / first - 1.0).abs() > EQUAL_RATES)
        {
            None => Ok(()),
            Some(other) => {
                let message = format!(
                    "the rate is {:.6} Hz, that of {} is {first:.6} Hz",
                    rate(other),
                    self.0[0].record.recording.path
                );
                Err(Error::new(Code::RateDisagrees, message)
                    .with_hint("measure all points at one rate, or state it: --rate")
                    .with_file(&other.record.recording.path))
            }
        }
    }

    /// Estimates the responses of every file on common lines and joins them.
    ///
    /// # Errors
    /// Errors of [`frf_estimation::estimate_responses`], with the file; `conflict` without common lines.
    pub fn acquire(
        &self,
        study: &FrfStudy,
        request: ResolutionRequest,
    ) -> Result<EstimatedResponses, Error> {
        let recordings: Vec<&CheckedRecording> = self.0.iter().map(|p| &p.sound).collect();
        let mut all = self.estimate(&recordings, study, request)?;
        if !are_alike(&all) {
            all = match all.iter().all(|a| !a.hits.is_empty()) {
                true => self.estimate_equal_blocks(&recordings, study, request, &all)?,
                false => self.estimate_equal_lengths(study, request, &all)?,
            };
        }
        if let Some(index) = (1..all.len()).find(|&k| !are_alike([&all[0], &all[k]])) {
            let name = |k: usize| &self.0[k].record.recording.path;
            let message = format!(
                "the frequency lines of {} and {} differ: {}; {}",
                name(0),
                name(index),
                all[0].method_text,
                all[index].method_text
            );
            return Err(Error::new(Code::Conflict, message)
                .with_hint("state the distance of the lines: --resolution 1"));
        }
        Ok(self.join(all))
    }

    fn estimate(
        &self,
        recordings: &[&CheckedRecording],
        study: &FrfStudy,
        request: ResolutionRequest,
    ) -> Result<Vec<EstimatedResponses>, Error> {
        let estimate = |(p, recording): (&CheckedRecord, &&CheckedRecording)| {
            frf_estimation::estimate_responses(recording, &p.inputs, &p.outputs, study, request)
                .map_err(|e| e.with_file(&p.record.recording.path))
        };
        self.0.iter().zip(recordings).map(estimate).collect()
    }

    /// Responses from blocks of equal length that use all hits of every file, under the strongest of their exponential windows.
    fn estimate_equal_blocks(
        &self,
        recordings: &[&CheckedRecording],
        study: &FrfStudy,
        request: ResolutionRequest,
        separate: &[EstimatedResponses],
    ) -> Result<Vec<EstimatedResponses>, Error> {
        let mut spacings_hz: Vec<f64> = separate
            .iter()
            .map(|a| line_spacing_hz(&a.responses.frequency_hz))
            .collect();
        spacings_hz.sort_by(f64::total_cmp);
        spacings_hz.dedup_by(|a, b| (*a / *b - 1.0).abs() < EQUAL_RATES);
        let hits = |a: &EstimatedResponses| a.hits.iter().filter(|h| h.fault.is_none()).count();
        let mut accepted: Option<(FrfStudy, Vec<EstimatedResponses>)> = None;
        for resolution_hz in spacings_hz {
            let mut study = study.clone();
            study.frequency_resolution_hz.get_or_insert(resolution_hz);
            let trial = self.estimate(recordings, &study, request);
            let uses_all = |trial: &Vec<EstimatedResponses>| {
                trial.iter().zip(separate).all(|(a, b)| hits(a) >= hits(b))
            };
            if let Ok(trial) = trial
                && uses_all(&trial)
            {
                accepted = Some((study, trial));
                break;
            }
        }
        let Some((mut study, accepted)) = accepted else {
            let message = "no block length suits the hits of every file";
            return Err(Error::new(Code::Conflict, message)
                .with_hint("state the distance of the lines: --resolution 1"));
        };
        if are_alike(&accepted) || study.window.is_some() {
            return Ok(accepted);
        }
        let decay = accepted
            .iter()
            .map(|a| a.responses.window_decay)
            .fold(0.0, f64::max);
        let end = (-decay / line_spacing_hz(&accepted[0].responses.frequency_hz)).exp();
        study.window = Some(Window::Exponential(end));
        self.estimate(recordings, &study, request)
    }

    /// Responses from records cut to the shortest, over the band in which every input has power.
    fn estimate_equal_lengths(
        &self,
        study: &FrfStudy,
        request: ResolutionRequest,
        separate: &[EstimatedResponses],
    ) -> Result<Vec<EstimatedResponses>, Error> {
        let shortest = self.0.iter().map(|p| p.sound.recording.samples).min();
        let shortened: Vec<CheckedRecording> = (self.0.iter())
            .map(|p| p.sound.truncated(shortest.unwrap_or(0)))
            .collect();
        let request = ResolutionRequest {
            band_hz: request.band_hz.or_else(|| common_band(separate)),
            ..request
        };
        self.estimate(&shortened.iter().collect::<Vec<_>>(), study, request)
    }

    fn join(&self, all: Vec<EstimatedResponses>) -> EstimatedResponses {
        let usable_hz = common_band(&all);
        let is_single_output = self.0.iter().all(|p| p.record.outputs.len() == 1);
        let output = self.0.first().and_then(|p| p.record.outputs.first());
        let is_roving_hammer = is_single_output
            && self.0.iter().all(|p| p.record.outputs.first() == output)
            && self
                .0
                .iter()
                .any(|p| p.record.inputs != self.0[0].record.inputs);
        let method_text = {
            let is_common = all.iter().all(|a| a.method_text == all[0].method_text);
            let file_text = |(p, a): (&CheckedRecord, &EstimatedResponses)| {
                format!("{}: {}", p.record.recording.path, a.method_text)
            };
            let texts: Vec<String> = match is_common {
                true => vec![all[0].method_text.clone()],
                false => self.0.iter().zip(&all).map(file_text).collect(),
            };
            let shown = texts.len().min(4);
            let remainder = match texts.len() - shown {
                0 => String::new(),
                n => format!("; {} more", pluralise(n, "file")),
            };
            format!(
                "{} with different points{}; {}{remainder}",
                pluralise(all.len(), "record"),
                match is_roving_hammer {
                    true => ", shapes over the points of the force by reciprocity",
                    false => "",
                },
                texts[..shown].join("; ")
            )
        };
        let minimum = |value: fn(&FrequencyResponses) -> Option<f64>| {
            all.iter()
                .filter_map(|a| value(&a.responses))
                .reduce(f64::min)
        };
        let mut responses = FrequencyResponses {
            frequency_hz: all[0].responses.frequency_hz.clone(),
            responses: Vec::new(),
            averages: minimum(|r| r.averages),
            window_decay: all[0].responses.window_decay,
            usable_band_hz: usable_hz,
            independent_lines_per_line: minimum(|r| r.independent_lines_per_line),
        };
        let finest: Option<Vec<f64>> = all.iter().map(|a| a.finest_resolution_hz).collect();
        let mut joined = EstimatedResponses {
            responses: FrequencyResponses::default(),
            method_text,
            hits: Vec::new(),
            hit_responses: Vec::new(),
            has_unresolved_pulses: all.iter().any(|a| a.has_unresolved_pulses),
            spectra: None,
            finest_resolution_hz: finest.and_then(|n| n.into_iter().reduce(f64::max)),
            smearing_limit_lines: all
                .iter()
                .map(|a| a.smearing_limit_lines)
                .fold(0.0, f64::max),
            smearing_hz: all.iter().map(|a| a.smearing_hz).fold(0.0, f64::max),
            diagnostics: Vec::new(),
        };
        for (point, estimated_responses) in self.0.iter().zip(all) {
            let record = point.record;
            let path = &record.recording.path;
            for (mut f, (output, input)) in estimated_responses
                .responses
                .responses
                .into_iter()
                .zip(pairs(record))
            {
                f.output.name = output.to_string();
                if let Some(label) = &mut f.input {
                    label.name = input.to_string();
                }
                if is_roving_hammer {
                    transpose(&mut f);
                }
                responses.responses.push(f);
            }
            joined
                .hits
                .extend(estimated_responses.hits.into_iter().map(|mut hit| {
                    hit.moment.file.get_or_insert_with(|| path.clone());
                    hit
                }));
            joined
                .diagnostics
                .extend(
                    estimated_responses
                        .diagnostics
                        .into_iter()
                        .map(|w| Diagnostic {
                            message: format!(
                                "{}: {}",
                                quoted_list(std::iter::once(path.as_str())),
                                w.message
                            ),
                            ..w
                        }),
                );
        }
        joined.responses = responses;
        joined
    }
}

/// Output and input points of the responses of a record, in their order.
fn pairs(record: &PointRecord) -> impl Iterator<Item = (&str, &str)> {
    let inputs = &record.inputs;
    (record.outputs.iter())
        .flat_map(move |o| inputs.iter().map(move |i| (o.1.as_str(), i.1.as_str())))
}

/// Exchanges the points of force and motion by reciprocity.
fn transpose(f: &mut FrequencyResponse) {
    if let Some(input) = &mut f.input {
        std::mem::swap(&mut input.name, &mut f.output.name);
    }
}

/// True if responses have equal lines and equal exponential windows.
fn are_alike<'a>(responses: impl IntoIterator<Item = &'a EstimatedResponses>) -> bool {
    let mut responses = responses.into_iter().map(|a| &a.responses);
    let Some(first) = responses.next() else {
        return false;
    };
    let equal = |a: f64, b: f64| (a - b).abs() <= EQUAL_RATES * b.abs();
    responses.all(|r| {
        r.frequency_hz.len() == first.frequency_hz.len()
            && (r.frequency_hz.iter().zip(&first.frequency_hz)).all(|(a, b)| equal(*a, *b))
            && equal(r.window_decay, first.window_decay)
    })
}

/// Common usable band of the responses, Hz.
fn common_band(all: &[EstimatedResponses]) -> Option<(f64, f64)> {
    let bands = all.iter().filter_map(|a| a.responses.usable_band_hz);
    let common = bands.reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))?;
    (common.0 < common.1).then_some(common)
}
