//! Online analysis of a running simulation: spectra, orders, transmission error, without its history.

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

/// Samples handed on to the averages at a time.
const CHUNK: usize = 256;

/// Rows of two angles kept for a transmission error, the latest: 16 MB.
const ROWS: usize = 1 << 20;

/// Everything found while a motion runs.
pub struct OnlineAnalysis {
    /// Angles and speeds that the analyses need next to what is shown.
    extra_outputs: Vec<MotionOutputs>,
    rate_hz: f64,
    spectra: Option<OnlineSpectra>,
    track: Option<OnlineOrders>,
    te: Option<AngleBuffer>,
    max_rows: usize,
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
    left: bool,
}

/// Results of the online analysis.
pub struct OnlineResult {
    /// Spectra of the outputs, in their order.
    pub spectra: Option<Spectra>,
    /// Orders of the outputs, and the node they turn with.
    pub tracks: Option<(String, DemodulatedOrders)>,
    /// Transmission error of the second shaft against the first.
    pub te: Option<(EncoderResult, GearTrain)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

impl OnlineAnalysis {
    /// Before the motion.
    ///
    /// # Errors
    /// Nodes that are not there, teeth that are none, orders that are not distinguished, fewer samples than a block.
    pub fn new(
        machine: &PreparedMachine,
        setup: &SimulationSetup,
        study: &OnlineStudy,
    ) -> Result<OnlineAnalysis, Error> {
        let rate_hz = setup.samples as f64 / setup.end_time;
        let shown = setup.outputs.list.len();
        let mut names = Vec::new();
        let track = match &study.track {
            None => None,
            Some(OrderTrackingStudy { node, orders }) => {
                names.extend([format!("{node}.theta"), format!("{node}.theta.speed")]);
                Some(OnlineOrders {
                    node: node.clone(),
                    demodulator: OrderDemodulator::new(orders, f64::from(study.turns), shown)?,
                })
            }
        };
        let te = match &study.te {
            None => None,
            Some(shafts) => {
                names.extend(shafts.iter().map(|node| format!("{node}.theta")));
                let Some(teeth) = &study.teeth else {
                    let error = Error::new(
                        Code::MissingKey,
                        "the teeth between the shafts are not stated",
                    );
                    return Err(error.with_hint("add --teeth 21:63, or `teeth` to the study"));
                };
                Some(AngleBuffer {
                    shafts: shafts.clone(),
                    teeth: GearTrain::parse(teeth)?,
                    angles: VecDeque::new(),
                    max_rows: ROWS,
                    left: false,
                })
            }
        };
        // Each by itself: of one list a node of two analyses would be left out the second time.
        let beside = names
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
                    let message = format!("{} samples fill no block of {block}", setup.samples + 1);
                    return Err(Error::new(Code::TooShort, message)
                        .with_hint("request more --samples, or a shorter block"));
                }
                Some(OnlineSpectra {
                    estimator: WelchEstimator::new(rate_hz, shown, &[], &options)?,
                    block: options.block,
                    chunk: vec![Vec::with_capacity(CHUNK); shown],
                })
            }
        };
        Ok(OnlineAnalysis {
            extra_outputs: beside,
            rate_hz,
            spectra,
            track,
            te,
            max_rows: 0,
        })
    }

    /// Takes one state with the outputs there.
    ///
    /// # Errors
    /// Those of [`OrderDemodulator::push`].
    pub fn push(
        &mut self,
        setup: &SimulationSetup,
        (t, y): (f64, &[f64]),
        values: &[f64],
    ) -> Result<(), Error> {
        let model = &setup.model.model;
        let mut beside = self
            .extra_outputs
            .iter()
            .flat_map(|one| one.evaluate(model, None, t, y));
        let mut next = || beside.next().unwrap_or(f64::NAN);
        if let Some(followed) = &mut self.track {
            followed.demodulator.push(t, next(), next(), values)?;
        }
        if let Some(rows) = &mut self.te {
            if rows.angles.len() == rows.max_rows {
                rows.angles.pop_front();
                rows.left = true;
            }
            rows.angles.push_back([next(), next()]);
        }
        if let Some(averages) = &mut self.spectra {
            let lists = averages.chunk.iter_mut().zip(values);
            lists.for_each(|(list, x)| list.push(*x));
            if averages.chunk.first().is_some_and(|c| c.len() == CHUNK) {
                averages.flush_chunk();
            }
        }
        self.max_rows = self.max_rows.max(self.stored_values());
        Ok(())
    }

    /// The most numbers held at any time so far.
    pub fn peak_stored_values(&self) -> usize {
        self.max_rows
    }

    /// Keeps at most so many rows for a transmission error and so many points of orders, in place of a million and 4096.
    pub fn set_limits(&mut self, rows: usize, points: usize) {
        if let Some(te) = &mut self.te {
            te.max_rows = rows;
        }
        if let Some(followed) = &mut self.track {
            followed.demodulator.limit_points(points);
        }
    }

    fn stored_values(&self) -> usize {
        let spectra = self
            .spectra
            .as_ref()
            .map_or(0, |a| a.chunk.len() * (CHUNK + 3 * a.block));
        let track = self
            .track
            .as_ref()
            .map_or(0, |f| f.demodulator.stored_values());
        let te = self.te.as_ref().map_or(0, |r| 2 * r.angles.len());
        spectra + track + te
    }

    /// Results of the online analysis. Of a motion that was `interrupted` whatever its part gives.
    ///
    /// # Errors
    /// Those of the evaluation of a transmission error.
    pub fn finish(self, interrupted: bool) -> Result<OnlineResult, Error> {
        let mut diagnostics = Vec::new();
        let mut result = OnlineResult {
            spectra: None,
            tracks: None,
            te: None,
            diagnostics: Vec::new(),
        };
        if let Some(mut averages) = self.spectra {
            averages.flush_chunk();
            result.spectra = match averages.estimator.finish() {
                Ok(spectra) => Some(spectra),
                Err(_) if interrupted => None,
                Err(error) => return Err(error),
            };
        }
        if let Some(followed) = self.track {
            let tracks = followed.demodulator.finish();
            if tracks.points.is_empty() || tracks.skipped_windows > 0 {
                diagnostics.push(Diagnostic {
                    code: "track-coarse",
                    message: match tracks.skipped_windows {
                        0 => format!(
                            "{} turns too little for one point of the orders",
                            followed.node
                        ),
                        n => format!(
                            "{n} points of the orders fell out: too few samples in their turns"
                        ),
                    },
                    hint: Some("request more --samples, a longer motion or other --turns".into()),
                });
            }
            result.tracks = Some((followed.node, tracks));
        }
        if let Some(rows) = self.te {
            if rows.left {
                diagnostics.push(Diagnostic {
                    code: "te-latest",
                    message: format!(
                        "the transmission error is that of the last {} samples: no more are kept",
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
        result.diagnostics = diagnostics;
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
    /// As a log of two encoders would be.
    fn evaluate_encoders(self, rate_hz: f64) -> Result<EncoderResult, Error> {
        let channel = |at: usize| {
            let samples: Vec<f64> = self.angles.iter().map(|row| row[at]).collect();
            Channel {
                name: ["input", "output"][at].to_string(),
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
            rate_source: "by the samples of the motion".into(),
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
        let read = EncoderRecordings {
            input: &recording,
            output: &recording,
            index: [None, None],
        };
        evaluate_encoders(read, &study, None)
    }
}
