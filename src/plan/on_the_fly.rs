//! Found while a motion runs, without its history: spectra, orders, transmission error; memory goes by the analysis, not by the duration.

use std::collections::VecDeque;

use super::logs::encoder_study::{EncoderStudy, Read};
use super::logs::encoders::{EncoderRecord, encoders};
use super::motion::scene::MotionScene;
use super::motion::wanted::outputs;
use super::prepared::Prepared;
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::motion::outputs::Outputs;
use crate::recording::column::Column;
use crate::recording::signals::{Channel, Recording};
use crate::scene::study::{RunningStudy, TrackStudy};
use crate::spectrum::rotation::demodulation::{Demodulator, Tracks};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::welch::{Welch, WelchOptions};
use crate::transmission::measured::teeth::Teeth;

/// Samples handed on to the averages at a time.
const CHUNK: usize = 256;

/// Rows of two angles kept for a transmission error, the latest: 16 MB.
const ROWS: usize = 1 << 20;

/// Everything found while a motion runs.
pub struct OnTheFly {
    /// Angles and speeds that the analyses need beside what is shown.
    beside: Vec<Outputs>,
    rate_hz: f64,
    spectra: Option<Averages>,
    track: Option<Followed>,
    te: Option<Rows>,
    most: usize,
}

struct Averages {
    welch: Welch,
    block: usize,
    chunk: Vec<Vec<f64>>,
}

struct Followed {
    node: String,
    demodulator: Demodulator,
}

struct Rows {
    shafts: [String; 2],
    teeth: Teeth,
    angles: VecDeque<[f64; 2]>,
    most: usize,
    left: bool,
}

/// What was found.
pub struct Found {
    /// Of the outputs, in their order.
    pub spectra: Option<Spectra>,
    /// Orders of the outputs, and the node they turn with.
    pub tracks: Option<(String, Tracks)>,
    /// Of the second shaft against the first.
    pub te: Option<(EncoderRecord, Teeth)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

impl OnTheFly {
    /// Before the motion.
    ///
    /// # Errors
    /// Nodes that are not there, teeth that are none, orders that are not told apart, fewer samples than a block.
    pub fn new(
        prepared: &Prepared,
        scene: &MotionScene,
        study: &RunningStudy,
    ) -> Result<OnTheFly, Error> {
        let rate_hz = scene.samples as f64 / scene.until;
        let shown = scene.outputs.list.len();
        let mut names = Vec::new();
        let track = match &study.track {
            None => None,
            Some(TrackStudy { node, orders }) => {
                names.extend([format!("{node}.theta"), format!("{node}.theta.speed")]);
                Some(Followed {
                    node: node.clone(),
                    demodulator: Demodulator::new(orders, f64::from(study.turns), shown)?,
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
                        "nothing says which teeth lie between the shafts",
                    );
                    return Err(error.hint("add --teeth 21:63, or `teeth` to the study"));
                };
                Some(Rows {
                    shafts: shafts.clone(),
                    teeth: Teeth::parse(teeth)?,
                    angles: VecDeque::new(),
                    most: ROWS,
                    left: false,
                })
            }
        };
        // Each by itself: of one list a node of two analyses would be left out the second time.
        let beside = names
            .iter()
            .map(|name| outputs(prepared, &scene.moving, std::slice::from_ref(name)))
            .collect::<Result<_, Error>>()?;
        let spectra = match study.spectrum {
            None => None,
            Some(block) => {
                let options = WelchOptions {
                    block: block as usize,
                    ..WelchOptions::default()
                };
                if (scene.samples + 1) < options.block {
                    let message = format!("{} samples fill no block of {block}", scene.samples + 1);
                    return Err(Error::new(Code::TooShort, message)
                        .hint("ask for more --samples, or a shorter block"));
                }
                Some(Averages {
                    welch: Welch::new(rate_hz, shown, &[], &options)?,
                    block: options.block,
                    chunk: vec![Vec::with_capacity(CHUNK); shown],
                })
            }
        };
        Ok(OnTheFly {
            beside,
            rate_hz,
            spectra,
            track,
            te,
            most: 0,
        })
    }

    /// Takes one state with the outputs there.
    ///
    /// # Errors
    /// Those of [`Demodulator::push`].
    pub fn watch(
        &mut self,
        scene: &MotionScene,
        (t, y): (f64, &[f64]),
        values: &[f64],
    ) -> Result<(), Error> {
        let train = &scene.moving.train;
        let mut beside = self.beside.iter().flat_map(|one| one.at(train, None, t, y));
        let mut next = || beside.next().unwrap_or(f64::NAN);
        if let Some(followed) = &mut self.track {
            followed.demodulator.push(t, next(), next(), values)?;
        }
        if let Some(rows) = &mut self.te {
            if rows.angles.len() == rows.most {
                rows.angles.pop_front();
                rows.left = true;
            }
            rows.angles.push_back([next(), next()]);
        }
        if let Some(averages) = &mut self.spectra {
            let lists = averages.chunk.iter_mut().zip(values);
            lists.for_each(|(list, x)| list.push(*x));
            if averages.chunk.first().is_some_and(|c| c.len() == CHUNK) {
                averages.pass_on();
            }
        }
        self.most = self.most.max(self.held());
        Ok(())
    }

    /// The most numbers held at any time so far.
    pub fn most_held(&self) -> usize {
        self.most
    }

    /// Keeps at most so many rows for a transmission error and so many points of orders, in place of a million and 4096.
    pub fn keep(&mut self, rows: usize, points: usize) {
        if let Some(te) = &mut self.te {
            te.most = rows;
        }
        if let Some(followed) = &mut self.track {
            followed.demodulator.keep(points);
        }
    }

    fn held(&self) -> usize {
        let spectra = self
            .spectra
            .as_ref()
            .map_or(0, |a| a.chunk.len() * (CHUNK + 3 * a.block));
        let track = self.track.as_ref().map_or(0, |f| f.demodulator.held());
        let te = self.te.as_ref().map_or(0, |r| 2 * r.angles.len());
        spectra + track + te
    }

    /// What was found. Of a motion that was `interrupted` whatever its part gives.
    ///
    /// # Errors
    /// Those of the evaluation of a transmission error.
    pub fn finish(self, interrupted: bool) -> Result<Found, Error> {
        let mut warnings = Vec::new();
        let mut found = Found {
            spectra: None,
            tracks: None,
            te: None,
            warnings: Vec::new(),
        };
        if let Some(mut averages) = self.spectra {
            averages.pass_on();
            found.spectra = match averages.welch.finish() {
                Ok(spectra) => Some(spectra),
                Err(_) if interrupted => None,
                Err(error) => return Err(error),
            };
        }
        if let Some(followed) = self.track {
            let tracks = followed.demodulator.finish();
            if tracks.points.is_empty() || tracks.coarse > 0 {
                warnings.push(Warning {
                    code: "track-coarse",
                    message: match tracks.coarse {
                        0 => format!(
                            "{} turns too little for one point of the orders",
                            followed.node
                        ),
                        n => format!(
                            "{n} points of the orders fell out: too few samples in their turns"
                        ),
                    },
                    hint: Some("ask for more --samples, a longer motion or other --turns".into()),
                });
            }
            found.tracks = Some((followed.node, tracks));
        }
        if let Some(rows) = self.te {
            if rows.left {
                warnings.push(Warning {
                    code: "te-latest",
                    message: format!(
                        "the transmission error is that of the last {} samples: no more are kept",
                        rows.angles.len()
                    ),
                    hint: None,
                });
            }
            let teeth = rows.teeth.clone();
            found.te = match rows.evaluate(self.rate_hz) {
                Ok(record) => Some((record, teeth)),
                Err(_) if interrupted => None,
                Err(error) => return Err(error),
            };
        }
        found.warnings = warnings;
        Ok(found)
    }
}

impl Averages {
    fn pass_on(&mut self) {
        let views: Vec<&[f64]> = self.chunk.iter().map(Vec::as_slice).collect();
        self.welch.push(&views);
        self.chunk.iter_mut().for_each(Vec::clear);
    }
}

impl Rows {
    /// As a log of two encoders would be.
    fn evaluate(self, rate_hz: f64) -> Result<EncoderRecord, Error> {
        let channel = |at: usize| {
            let samples: Vec<f64> = self.angles.iter().map(|row| row[at]).collect();
            Channel {
                name: ["input", "output"][at].to_string(),
                unit: "rad".to_string(),
                samples: Column::from_slice(&samples).into(),
                overload_level: None,
                overloads: 0,
            }
        };
        let recording = Recording {
            path: format!("{} against {}", self.shafts[1], self.shafts[0]),
            dialect: "the motion itself".into(),
            facts: Vec::new(),
            rate_hz,
            rate_std: 0.0,
            rate_source: "by the samples of the motion".into(),
            samples: self.angles.len(),
            stretches: vec![0..self.angles.len()],
            starts: vec![0.0],
            start: None,
            files: Vec::new(),
            channels: vec![channel(0), channel(1)],
            repairs: Vec::new(),
            warnings: Vec::new(),
        };
        let study = EncoderStudy {
            input: vec!["input".into()],
            output: vec!["output".into()],
            index: [None, None],
            teeth: self.teeth,
            lines: None,
            counts_per_line: 1,
            stamps: false,
            angle_base: false,
            multiples: None,
            every: false,
            repair: false,
            radius: None,
            pressure_angle: None,
        };
        let read = Read {
            input: &recording,
            output: &recording,
            index: [None, None],
        };
        encoders(read, &study, None)
    }
}
