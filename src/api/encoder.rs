//! Transmission error between two encoders: orders with their sources, deviations, backlash.

use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error, Errors};
use crate::encoder::flank::{FlankEvaluation, OrderEstimate};
use crate::encoder::gear_train::GearTrain;
use crate::plan::logs::encoder_analysis::{EncoderResult, evaluate_encoders};
use crate::plan::logs::encoder_study::{COUNTS_PER_LINE, EncoderRecordings, EncoderStudy};
use crate::recording::signals::Recording;

/// Transmission error measured by two encoders.
#[derive(Debug, Clone)]
pub struct MeasuredTransmissionError {
    /// Output revolutions per input revolution, by the tooth numbers.
    pub ratio: f64,
    /// One or two flanks; the one with more output revolutions first.
    pub flanks: Vec<MeasuredFlank>,
    /// Mean angular backlash of the output, rad, if the record turns both ways.
    pub backlash: Option<f64>,
    /// Warnings about the record.
    pub diagnostics: Vec<Diagnostic>,
}

/// Transmission error `θ₂ − r θ₁` of one direction of rotation, rad of the output: θ₁, θ₂ the angles of input and output, counted in the
/// same sense, and r the ratio. The output angle is `φ = r θ₁`, from the index mark of the output if there is one, otherwise from the zero of
/// the input.
#[derive(Debug, Clone)]
pub struct MeasuredFlank {
    /// The input angle increases.
    pub forward: bool,
    /// Output angle of the first value, rad.
    pub first_angle: f64,
    /// Output angle between two values, rad.
    pub angle_step: f64,
    /// Errors about their mean at equally spaced output angles, rad.
    pub values: Vec<f64>,
    /// Fitted orders, ascending.
    pub orders: Vec<MeasuredOrder>,
    /// Noise without the fitted orders, rad rms.
    pub noise: f64,
    /// Total single-flank composite deviation F_i′ of the fitted orders, rad.
    pub total_deviation: f64,
    /// Tooth-to-tooth deviation f_i′ of the fitted orders, rad.
    pub tooth_to_tooth_deviation: f64,
}

/// One order of a measured transmission error.
#[derive(Debug, Clone)]
pub struct MeasuredOrder {
    /// Order per revolution of the output.
    pub order: f64,
    /// The order as an exact fraction.
    pub order_fraction: String,
    /// Shafts and meshes of this order.
    pub sources: Vec<String>,
    /// Amplitude, rad zero to peak.
    pub amplitude: f64,
    /// Standard deviation of the amplitude, rad.
    pub amplitude_std: f64,
    /// 95 % interval of the amplitude, rad; `None` for an order that the record does not resolve from another.
    pub interval: Option<(f64, f64)>,
    /// Phase ψ of `A cos(o φ + ψ)`, φ the output angle, rad.
    pub phase: f64,
    /// The order exceeds the noise (99.9 % over all orders examined).
    pub significant: bool,
}

impl EncoderStudy {
    /// A study of two channels that hold angles, with the teeth between them from input to output: `21:63,17:40`.
    ///
    /// # Errors
    /// Teeth that are not of that form.
    pub fn new(input: &str, output: &str, teeth: &str) -> Result<EncoderStudy, Errors> {
        Ok(EncoderStudy {
            input: vec![input.to_string()],
            output: vec![output.to_string()],
            index: [None, None],
            teeth: GearTrain::parse(teeth)?,
            lines: None,
            counts_per_line: COUNTS_PER_LINE,
            pulse_times: false,
            angle_base: false,
            multiples: None,
            repair: false,
            every: false,
            radius: None,
            pressure_angle: None,
            model: None,
        })
    }
}

impl Recording {
    /// Transmission error between two encoders whose readings are channels of this recording.
    ///
    /// ```
    /// # use geardyn::prelude::*;
    /// let recording = Recording::open("data/y2250_te.csv")?;
    /// let error = recording.transmission_error(&EncoderStudy {
    ///     lines: Some((10_000, 36_000)),
    ///     ..EncoderStudy::new("index_gear_1", "work_spindle", "30:37,54:36,1:90")?
    /// })?;
    /// let first = &error.flanks[0].orders[0];
    /// assert!(first.order == 1.0 && first.significant);
    /// # Ok::<(), Errors>(())
    /// ```
    ///
    /// # Errors
    /// Unknown channels; rows that were resampled when read; a ratio other than that of the teeth; lost counts without `repair`; instants of
    /// pulses, `radius`, `pressure_angle` and `model`, which are of the command alone.
    pub fn transmission_error(
        &self,
        study: &EncoderStudy,
    ) -> Result<MeasuredTransmissionError, Errors> {
        self.check_encoder_study(study)
            .map_err(|error| error.with_file(&self.path))?;
        let channels = EncoderRecordings {
            input: self,
            output: self,
            index: [0, 1].map(|k| study.index[k].as_ref().map(|_| self)),
        };
        Ok(MeasuredTransmissionError::new(evaluate_encoders(
            channels, study, None,
        )?))
    }

    fn check_encoder_study(&self, study: &EncoderStudy) -> Result<(), Error> {
        let refuse =
            |message: &str, hint: &str| Err(Error::new(Code::Usage, message).with_hint(hint));
        if self.repairs.iter().any(|repair| repair.kind == "resampled") {
            return refuse(
                "the rows were resampled to even times; encoders are evaluated as they were read",
                "state `time = \"none\"` and a rate in the sidecar, and `angle_base` in the study",
            );
        }
        let is_of_command = study.pulse_times
            || study.radius.is_some()
            || study.pressure_angle.is_some()
            || study.model.is_some();
        if is_of_command {
            return refuse(
                "instants of pulses, a radius, a pressure angle and a model are not evaluated here",
                "run `geardyn te` on the log",
            );
        }
        let has_columns = |names: &[String]| matches!(names.len(), 1 | 2);
        if !has_columns(&study.input) || !has_columns(&study.output) {
            return refuse(
                "an encoder has one channel, or two tracks",
                "name them in `input` and `output`",
            );
        }
        if study.input.iter().any(|name| study.output.contains(name)) {
            return refuse(
                "one channel is named for both encoders",
                "name separate channels in `input` and `output`",
            );
        }
        let is_zero = |(a, b): (usize, usize)| a == 0 || b == 0;
        if study.counts_per_line == 0 || study.lines.is_some_and(is_zero) {
            return refuse(
                "an encoder has 0 lines per turn, or 0 counts per line",
                "state the lines per turn of both encoders in `lines`, input first",
            );
        }
        Ok(())
    }
}

impl MeasuredTransmissionError {
    fn new(result: EncoderResult) -> MeasuredTransmissionError {
        let measured = result.measured;
        MeasuredTransmissionError {
            ratio: measured.tooth_ratio.to_f64(),
            flanks: measured
                .flanks
                .into_iter()
                .map(MeasuredFlank::new)
                .collect(),
            backlash: measured.backlash.map(|backlash| backlash.mean),
            diagnostics: result.diagnostics,
        }
    }
}

impl MeasuredFlank {
    fn new(flank: FlankEvaluation) -> MeasuredFlank {
        let step = std::f64::consts::TAU / flank.signal.samples_per_rev as f64;
        MeasuredFlank {
            forward: flank.forward,
            first_angle: flank.signal.first as f64 * step,
            angle_step: step,
            values: flank.signal.values,
            orders: flank.lines.into_iter().map(MeasuredOrder::new).collect(),
            noise: flank.noise,
            total_deviation: flank.fitted.total,
            tooth_to_tooth_deviation: flank.fitted.per_pitch,
        }
    }
}

impl MeasuredOrder {
    fn new(estimate: OrderEstimate) -> MeasuredOrder {
        MeasuredOrder {
            order: estimate.order.value,
            order_fraction: estimate.order.fraction.to_string(),
            sources: estimate.order.names,
            amplitude: estimate.amplitude,
            amplitude_std: estimate.deviation,
            interval: estimate.interval,
            phase: estimate.phase,
            significant: estimate.significant,
        }
    }
}
