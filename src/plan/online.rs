//! Online analysis during a simulation: spectra, orders, transmission error, without a stored history.

use std::collections::VecDeque;

use super::logs::encoder_analysis::{EncoderResult, evaluate_encoders};
use super::logs::encoder_study::{EncoderRecordings, EncoderStudy};
use super::motion::output_selection::select_outputs;
use super::motion::simulation_setup::SimulationSetup;
use super::prepared_machine::PreparedMachine;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::encoder::gear_train::GearTrain;
use crate::motion::outputs::MotionOutputs;
use crate::recording::sample_column::SampleColumn;
use crate::recording::signals::{Channel, Recording};
use crate::scene::study::{OnlineStudy, OrderTrackingStudy};
use crate::spectrum::rotation::order_demodulation::{DemodulatedOrders, OrderDemodulator};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::welch::{WelchEstimator, WelchOptions};

/// Number of samples per update of the averaged spectra.
const CHUNK: usize = 256;

/// Maximum number of stored rows of two angles for a transmission error: the latest 16 MB.
const MAX_ANGLE_ROWS: usize = 1 << 20;

/// State of the online analysis of a simulation.
pub struct OnlineAnalysis {
    /// Angles and speeds that the analyses need in addition to the requested outputs.
    extra_outputs: Vec<MotionOutputs>,
    rate_hz: f64,
    spectra: Option<OnlineSpectra>,
    track: Option<OnlineOrders>,
    te: Option<AngleBuffer>,
    peak_values: usize,
}

struct OnlineSpectra {
    estimator: WelchEstimator,
    block: usize,
    chunk: Vec<Vec<f64>>,
}

struct OnlineOrders {
    node: String,
    demodulator: OrderDemodulator,
}

struct AngleBuffer {
    shafts: [String; 2],
    teeth: GearTrain,
    angles: VecDeque<[f64; 2]>,
    max_rows: usize,
    has_dropped_rows: bool,
}

/// Results of the online analysis.
pub struct OnlineResult {
    /// Spectra of the outputs, in the order of the outputs.
    pub spectra: Option<Spectra>,
    /// Orders of the outputs, with the name of their reference node.
    pub tracks: Option<(String, DemodulatedOrders)>,
    /// Transmission error of the second shaft relative to the first, with the gear train between them.
    pub te: Option<(EncoderResult, GearTrain)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

impl OnlineAnalysis {
    /// Prepares the analysis before the simulation.
    ///
    /// # Errors
    /// A node does not exist; the teeth are invalid; orders are not distinguished; the samples fill no block.
    pub fn new(
        machine: &PreparedMachine,
        setup: &SimulationSetup,
        study: &OnlineStudy,
    ) -> Result<OnlineAnalysis, Error> {
        let rate_hz = setup.samples as f64 / setup.end_time;
        let n_outputs = setup.outputs.list.len();
        let mut names = Vec::new();
        let track = match &study.track {
            None => None,
            Some(OrderTrackingStudy { node, orders }) => {
                names.extend([format!("{node}.theta"), format!("{node}.theta.speed")]);
                Some(OnlineOrders {
                    node: node.clone(),
                    demodulator: OrderDemodulator::new(orders, f64::from(study.turns), n_outputs)?,
                })
            }
        };
        let te = match &study.te {
            None => None,
            Some(shafts) => {
                names.extend(shafts.iter().map(|node| format!("{node}.theta")));
                let Some(teeth) = &study.teeth else {
                    let message = "the teeth between the shafts are not stated";
                    return Err(Error::new(Code::MissingKey, message)
                        .with_hint("add --teeth 21:63, or `teeth` to the study"));
                };
                Some(AngleBuffer {
                    shafts: shafts.clone(),
                    teeth: GearTrain::parse(teeth)?,
                    angles: VecDeque::new(),
                    max_rows: MAX_ANGLE_ROWS,
                    has_dropped_rows: false,
                })
            }
        };
        // One selection per name: a common selection would omit the second occurrence of a node.
        let extra_outputs = names
            .iter()
            .map(|name| select_outputs(machine, &setup.model, std::slice::from_ref(name)))
            .collect::<Result<_, Error>>()?;
        let spectra = match study.spectrum {
            None => None,
            Some(block) => {
                let options = WelchOptions {
                    block: block as usize,
                    ..WelchOptions::default()
                };
                if (setup.samples + 1) < options.block {
                    let message = format!(
                        "{} samples are fewer than a block of {block}",
                        setup.samples + 1
                    );
                    return Err(Error::new(Code::TooShort, message)
                        .with_hint("request more --samples, or a shorter block"));
                }
                Some(OnlineSpectra {
                    estimator: WelchEstimator::new(rate_hz, n_outputs, &[], &options)?,
                    block: options.block,
                    chunk: vec![Vec::with_capacity(CHUNK); n_outputs],
                })
            }
        };
        Ok(OnlineAnalysis {
            extra_outputs,
            rate_hz,
            spectra,
            track,
            te,
            peak_values: 0,
        })
    }

    /// Adds a state at time t, s, with the values of the outputs.
    ///
    /// # Errors
    /// Errors of [`OrderDemodulator::push`].
    pub fn push(
        &mut self,
        setup: &SimulationSetup,
        (t, y): (f64, &[f64]),
        values: &[f64],
    ) -> Result<(), Error> {
        let model = &setup.model.model;
        let mut extra_values = self
            .extra_outputs
            .iter()
            .flat_map(|outputs| outputs.evaluate(model, None, t, y));
        let mut next = || extra_values.next().unwrap_or(f64::NAN);
        if let Some(track) = &mut self.track {
            track.demodulator.push(t, next(), next(), values)?;
        }
        if let Some(rows) = &mut self.te {
            if rows.angles.len() == rows.max_rows {
                rows.angles.pop_front();
                rows.has_dropped_rows = true;
            }
            rows.angles.push_back([next(), next()]);
        }
        if let Some(spectra) = &mut self.spectra {
            let columns = spectra.chunk.iter_mut().zip(values);
            columns.for_each(|(column, x)| column.push(*x));
            if spectra.chunk.first().is_some_and(|c| c.len() == CHUNK) {
                spectra.flush_chunk();
            }
        }
        self.peak_values = self.peak_values.max(self.stored_values());
        Ok(())
    }

    /// Largest number of values stored at any time so far.
    pub fn peak_stored_values(&self) -> usize {
        self.peak_values
    }

    /// Limits the rows of a transmission error and the points of the orders; the defaults are 2²⁰ and 4096.
    pub fn set_limits(&mut self, rows: usize, points: usize) {
        if let Some(te) = &mut self.te {
            te.max_rows = rows;
        }
        if let Some(track) = &mut self.track {
            track.demodulator.limit_points(points);
        }
    }

    fn stored_values(&self) -> usize {
        let spectra = self
            .spectra
            .as_ref()
            .map_or(0, |s| s.chunk.len() * (CHUNK + 3 * s.block));
        let track = self
            .track
            .as_ref()
            .map_or(0, |t| t.demodulator.stored_values());
        let te = self.te.as_ref().map_or(0, |rows| 2 * rows.angles.len());
        spectra + track + te
    }

    /// Results of the online analysis; for an `interrupted` simulation those that its samples suffice for.
    ///
    /// # Errors
    /// Errors of the evaluation of a transmission error.
    pub fn finish(self, interrupted: bool) -> Result<OnlineResult, Error> {
        let mut result = OnlineResult {
            spectra: None,
            tracks: None,
            te: None,
            diagnostics: Vec::new(),
        };
        if let Some(mut average) = self.spectra {
            average.flush_chunk();
            result.spectra = match average.estimator.finish() {
                Ok(spectra) => Some(spectra),
                Err(_) if interrupted => None,
                Err(error) => return Err(error),
            };
        }
        if let Some(track) = self.track {
            let tracks = track.demodulator.finish();
            if tracks.points.is_empty() || tracks.skipped_windows > 0 {
                result.diagnostics.push(Diagnostic {
                    code: "track-coarse",
                    message: match tracks.skipped_windows {
                        0 => format!(
                            "{} makes too few revolutions for one point of the orders",
                            track.node
                        ),
                        n => format!(
                            "{n} points of the orders not computed: too few samples per turn"
                        ),
                    },
                    hint: Some(match tracks.skipped_windows {
                        0 => "lengthen the motion, or request fewer --turns".into(),
                        _ => "request more --samples".into(),
                    }),
                });
            }
            result.tracks = Some((track.node, tracks));
        }
        if let Some(rows) = self.te {
            if rows.has_dropped_rows {
                result.diagnostics.push(Diagnostic {
                    code: "te-latest",
                    message: format!(
                        "the transmission error covers only the last {} samples (storage limit)",
                        rows.angles.len()
                    ),
                    hint: None,
                });
            }
            let teeth = rows.teeth.clone();
            result.te = match rows.evaluate_encoders(self.rate_hz) {
                Ok(record) => Some((record, teeth)),
                Err(_) if interrupted => None,
                Err(error) => return Err(error),
            };
        }
        Ok(result)
    }
}

impl OnlineSpectra {
    fn flush_chunk(&mut self) {
        let views: Vec<&[f64]> = self.chunk.iter().map(Vec::as_slice).collect();
        self.estimator.push(&views);
        self.chunk.iter_mut().for_each(Vec::clear);
    }
}

impl AngleBuffer {
    /// Evaluates the angles as a log of two encoders.
    fn evaluate_encoders(self, rate_hz: f64) -> Result<EncoderResult, Error> {
        let channel = |index: usize| {
            let samples: Vec<f64> = self.angles.iter().map(|row| row[index]).collect();
            Channel {
                name: ["input", "output"][index].to_string(),
                unit: "rad".to_string(),
                samples: SampleColumn::from_slice(&samples).into(),
                overload_level: None,
                overloads: 0,
            }
        };
        let recording = Recording {
            path: format!("{} against {}", self.shafts[1], self.shafts[0]),
            dialect: "the motion itself".into(),
            metadata: Vec::new(),
            rate_hz,
            rate_std: 0.0,
            rate_source: "from the samples of the motion".into(),
            samples: self.angles.len(),
            segments: vec![0..self.angles.len()],
            segment_starts: vec![0.0],
            start: None,
            files: Vec::new(),
            channels: vec![channel(0), channel(1)],
            repairs: Vec::new(),
            diagnostics: Vec::new(),
        };
        let study = EncoderStudy {
            input: vec!["input".into()],
            output: vec!["output".into()],
            index: [None, None],
            teeth: self.teeth,
            lines: None,
            counts_per_line: 1,
            pulse_times: false,
            angle_base: false,
            multiples: None,
            every: false,
            repair: false,
            radius: None,
            pressure_angle: None,
            model: None,
        };
        let recordings = EncoderRecordings {
            input: &recording,
            output: &recording,
            index: [None, None],
        };
        evaluate_encoders(recordings, &study, None)
    }
}
