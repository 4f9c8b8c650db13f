//! Files of one test that each hold other points, of a roving sensor or a roving hammer: frequency responses file by file, joined into
//! one matrix `H_oi`.
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

/// The record of some points of a test.
#[derive(Debug)]
pub struct PointRecord {
    /// Recording of the signals at the point.
    pub recording: Recording,
    /// Channels of the inputs, and the points they act at.
    pub inputs: Vec<(String, String)>,
    /// Channels of the outputs, and the points they are at.
    pub outputs: Vec<(String, String)>,
}

/// The records of a test, checked.
#[derive(Debug)]
pub struct Points<'a>(Vec<Checked<'a>>);

#[derive(Debug)]
struct Checked<'a> {
    record: &'a PointRecord,
    sound: CheckedRecording,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
}

impl<'a> Points<'a> {
    /// Checks every record alone, and that no response is measured twice.
    ///
    /// # Errors
    /// `no-channel`, `no-signal`, `conflict`, `rate-disagrees`, with the file.
    pub fn new(records: &'a [PointRecord]) -> Result<Points<'a>, Error> {
        let mut all: Vec<Checked> = Vec::new();
        for own in records {
            let recording = &own.recording;
            let checked = || -> Result<Checked, Error> {
                let channels = |side: &[(String, String)]| {
                    let words: Vec<String> = side.iter().map(|s| s.0.clone()).collect();
                    segment_samples::channel_indices(recording, &words)
                };
                let (inputs, outputs) = (channels(&own.inputs)?, channels(&own.outputs)?);
                segment_samples::check_channels(recording, &inputs, &outputs)?;
                Ok(Checked {
                    record: own,
                    sound: fault_free::without_faults(recording, &inputs, &outputs)?,
                    inputs,
                    outputs,
                })
            };
            all.push(checked().map_err(|e| e.with_file(&recording.path))?);
        }
        let points = Points(all);
        points.refuse_doubles()?;
        points.refuse_rates()?;
        Ok(points)
    }

    /// The file of each record, and its responses among all.
    pub fn files(&self) -> Vec<(&str, std::ops::Range<usize>)> {
        let mut from = 0;
        let one = |p: &Checked<'a>| {
            let own = from..from + pairs(p.record).count();
            from = own.end;
            (p.record.recording.path.as_str(), own)
        };
        self.0.iter().map(one).collect()
    }

    /// Whether gaps cut a record.
    pub fn has_gaps(&self) -> bool {
        self.0.iter().any(|p| p.sound.recording.segments.len() > 1)
    }

    /// A response that two files hold.
    fn refuse_doubles(&self) -> Result<(), Error> {
        let mut known: Vec<(&str, &str, &str)> = Vec::new();
        for own in self.0.iter().map(|p| p.record) {
            for (output, input) in pairs(own) {
                let path = own.recording.path.as_str();
                if let Some(other) = known.iter().find(|k| (k.0, k.1) == (output, input)) {
                    let message = match other.2 == path {
                        true => format!("{path} is named twice"),
                        false => format!(
                            "{output} over {input} is measured in {} and in {path}, which differ in their other channels",
                            other.2
                        ),
                    };
                    return Err(Error::new(Code::Conflict, message).with_hint(
                        match other.2 == path {
                            true => "name every file once",
                            false => "files of one point have equal channels, files of several points no response twice: name fewer channels, or give --roving",
                        },
                    ));
                }
                known.push((output, input, path));
            }
        }
        Ok(())
    }

    fn refuse_rates(&self) -> Result<(), Error> {
        let rate = |p: &Checked| p.sound.recording.rate_hz;
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

    /// Responses of every file over common lines, joined.
    ///
    /// # Errors
    /// Those of [`frf_estimation::estimate_responses`], with the file; `conflict` where no common lines can be had.
    pub fn acquire(
        &self,
        study: &FrfStudy,
        request: ResolutionRequest,
    ) -> Result<EstimatedResponses, Error> {
        let whole: Vec<&CheckedRecording> = self.0.iter().map(|p| &p.sound).collect();
        let mut all = self.each(&whole, study, request)?;
        if !are_alike(&all) {
            all = match all.iter().all(|a| !a.hits.is_empty()) {
                true => self.of_equal_blocks(&whole, study, request, &all)?,
                false => self.of_equal_lengths(study, request, &all)?,
            };
        }
        if let Some(at) = (1..all.len()).find(|&k| !are_alike([&all[0], &all[k]])) {
            let name = |k: usize| &self.0[k].record.recording.path;
            let message = format!(
                "the frequency lines of {} and {} differ: {}; {}",
                name(0),
                name(at),
                all[0].method_text,
                all[at].method_text
            );
            return Err(Error::new(Code::Conflict, message)
                .with_hint("state the distance of the lines: --resolution 1"));
        }
        Ok(self.joined(all))
    }

    fn each(
        &self,
        sounds: &[&CheckedRecording],
        study: &FrfStudy,
        request: ResolutionRequest,
    ) -> Result<Vec<EstimatedResponses>, Error> {
        let one = |(p, sound): (&Checked, &&CheckedRecording)| {
            frf_estimation::estimate_responses(sound, &p.inputs, &p.outputs, study, request)
                .map_err(|e| e.with_file(&p.record.recording.path))
        };
        self.0.iter().zip(sounds).map(one).collect()
    }

    /// Hits in blocks as long as every file has them without losing one, under the strongest of their exponential windows.
    fn of_equal_blocks(
        &self,
        sounds: &[&CheckedRecording],
        study: &FrfStudy,
        request: ResolutionRequest,
        own: &[EstimatedResponses],
    ) -> Result<Vec<EstimatedResponses>, Error> {
        let mut apart: Vec<f64> = own
            .iter()
            .map(|a| line_spacing_hz(&a.responses.frequency_hz))
            .collect();
        apart.sort_by(f64::total_cmp);
        apart.dedup_by(|a, b| (*a / *b - 1.0).abs() < EQUAL_RATES);
        let used = |a: &EstimatedResponses| a.hits.iter().filter(|h| h.fault.is_none()).count();
        let mut found: Option<(FrfStudy, Vec<EstimatedResponses>)> = None;
        for resolution_hz in apart {
            let mut study = study.clone();
            study.frequency_resolution_hz.get_or_insert(resolution_hz);
            let tried = self.each(sounds, &study, request);
            let keeps_all = |tried: &Vec<EstimatedResponses>| {
                tried.iter().zip(own).all(|(a, b)| used(a) >= used(b))
            };
            if let Ok(tried) = tried
                && keeps_all(&tried)
            {
                found = Some((study, tried));
                break;
            }
        }
        let Some((mut study, found)) = found else {
            let message = "no length of block suits the hits of every file";
            return Err(Error::new(Code::Conflict, message)
                .with_hint("state the distance of the lines: --resolution 1"));
        };
        if are_alike(&found) || study.window.is_some() {
            return Ok(found);
        }
        let decay = found
            .iter()
            .map(|a| a.responses.window_decay)
            .fold(0.0, f64::max);
        let end = (-decay / line_spacing_hz(&found[0].responses.frequency_hz)).exp();
        study.window = Some(Window::Exponential(end));
        self.each(sounds, &study, request)
    }

    /// Records as long as the shortest of them, over the band in which every input has power.
    fn of_equal_lengths(
        &self,
        study: &FrfStudy,
        request: ResolutionRequest,
        own: &[EstimatedResponses],
    ) -> Result<Vec<EstimatedResponses>, Error> {
        let shortest = self.0.iter().map(|p| p.sound.recording.samples).min();
        let cut: Vec<CheckedRecording> = (self.0.iter())
            .map(|p| p.sound.beginning(shortest.unwrap_or(0)))
            .collect();
        let request = ResolutionRequest {
            band_hz: request.band_hz.or_else(|| common_band(own)),
            ..request
        };
        self.each(&cut.iter().collect::<Vec<_>>(), study, request)
    }

    fn joined(&self, all: Vec<EstimatedResponses>) -> EstimatedResponses {
        let usable_hz = common_band(&all);
        let is_alone = self.0.iter().all(|p| p.record.outputs.len() == 1);
        let output = self.0.first().and_then(|p| p.record.outputs.first());
        let is_roving_hammer = is_alone
            && self.0.iter().all(|p| p.record.outputs.first() == output)
            && self
                .0
                .iter()
                .any(|p| p.record.inputs != self.0[0].record.inputs);
        let how = {
            let same = all.iter().all(|a| a.method_text == all[0].method_text);
            let one = |(p, a): (&Checked, &EstimatedResponses)| {
                format!("{}: {}", p.record.recording.path, a.method_text)
            };
            let hows: Vec<String> = match same {
                true => vec![all[0].method_text.clone()],
                false => self.0.iter().zip(&all).map(one).collect(),
            };
            let shown = hows.len().min(4);
            let more = match hows.len() - shown {
                0 => String::new(),
                n => format!("; {} more", pluralise(n, "file")),
            };
            format!(
                "{} with other points each{}; {}{more}",
                pluralise(all.len(), "record"),
                match is_roving_hammer {
                    true => ", shapes over the points of the force by reciprocity",
                    false => "",
                },
                hows[..shown].join("; ")
            )
        };
        let least = |value: fn(&FrequencyResponses) -> Option<f64>| {
            all.iter()
                .filter_map(|a| value(&a.responses))
                .reduce(f64::min)
        };
        let mut responses = FrequencyResponses {
            frequency_hz: all[0].responses.frequency_hz.clone(),
            responses: Vec::new(),
            averages: least(|r| r.averages),
            window_decay: all[0].responses.window_decay,
            usable_band_hz: usable_hz,
            independent_lines_per_line: least(|r| r.independent_lines_per_line),
        };
        let nearest: Option<Vec<f64>> = all.iter().map(|a| a.finest_resolution_hz).collect();
        let mut joined = EstimatedResponses {
            responses: FrequencyResponses::default(),
            method_text: how,
            hits: Vec::new(),
            by_hit: Vec::new(),
            has_unresolved_pulses: all.iter().any(|a| a.has_unresolved_pulses),
            spectra: None,
            finest_resolution_hz: nearest.and_then(|n| n.into_iter().reduce(f64::max)),
            smearing_limit_lines: all
                .iter()
                .map(|a| a.smearing_limit_lines)
                .fold(0.0, f64::max),
            smearing_hz: all.iter().map(|a| a.smearing_hz).fold(0.0, f64::max),
            diagnostics: Vec::new(),
        };
        for (point, estimated_responses) in self.0.iter().zip(all) {
            let own = point.record;
            let path = &own.recording.path;
            for (mut f, (output, input)) in estimated_responses
                .responses
                .responses
                .into_iter()
                .zip(pairs(own))
            {
                f.output.name = output.to_string();
                if let Some(terminal) = &mut f.input {
                    terminal.name = input.to_string();
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

/// Points of outputs and inputs in the order of the responses of a record.
fn pairs(record: &PointRecord) -> impl Iterator<Item = (&str, &str)> {
    let inputs = &record.inputs;
    (record.outputs.iter())
        .flat_map(move |o| inputs.iter().map(move |i| (o.1.as_str(), i.1.as_str())))
}

/// Force and motion change their points.
fn transpose(f: &mut FrequencyResponse) {
    if let Some(input) = &mut f.input {
        std::mem::swap(&mut input.name, &mut f.output.name);
    }
}

/// Whether responses have the same lines and the same exponential window.
fn are_alike<'a>(all: impl IntoIterator<Item = &'a EstimatedResponses>) -> bool {
    let mut all = all.into_iter().map(|a| &a.responses);
    let Some(first) = all.next() else {
        return false;
    };
    let near = |a: f64, b: f64| (a - b).abs() <= EQUAL_RATES * b.abs();
    all.all(|r| {
        r.frequency_hz.len() == first.frequency_hz.len()
            && (r.frequency_hz.iter().zip(&first.frequency_hz)).all(|(a, b)| near(*a, *b))
            && near(r.window_decay, first.window_decay)
    })
}

/// The band in which every input has power.
fn common_band(all: &[EstimatedResponses]) -> Option<(f64, f64)> {
    let bands = all.iter().filter_map(|a| a.responses.usable_band_hz);
    let common = bands.reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))?;
    (common.0 < common.1).then_some(common)
}
