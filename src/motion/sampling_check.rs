//! Sampling check: whether the samples of an output resolve its oscillation, by `ω ≈ mean |ẋ| / mean |x − x̄|`.

use std::f64::consts::TAU;

use super::dynamic_model::DynamicModel;
use super::outputs::MotionOutputs;
use super::problem::OdeProblem;
use super::regime::Regime;

/// Maximum number of examined samples; each costs one evaluation of the equations of motion.
const MAX_EVALUATIONS: usize = 256;

/// Difference step of a slope as a fraction of the sample interval.
const SLOPE_STEP: f64 = 1e-4;

/// Oscillation amplitude relative to the size of an output below which it is negligible.
const MIN_RELATIVE_AMPLITUDE: f64 = 1e-3;

/// Fewest samples for a check of the sampling.
const MIN_SAMPLES: usize = 4;

/// Check of the sampling of outputs during an integration run.
///
/// For a sine, the mean absolute slope over the mean absolute deviation is ω, whatever the phases of the samples. Oscillations faster than
/// the sampling are thus detected, which the samples alone would show as slow (aliasing). A jump contributes by its height only. An
/// oscillation that is in phase with the samples and has zero slope there is not detected.
pub struct SamplingCheck<'m> {
    model: &'m DynamicModel,
    outputs: &'m MotionOutputs,
    samples: usize,
    /// Sample interval, s.
    spacing: f64,
    /// Number of samples from one examined sample to the next.
    stride: usize,
    n_samples: usize,
    /// Values of each output at the examined samples.
    values: Vec<Vec<f64>>,
    /// Sum of the absolute slopes of each output, its unit per s.
    slopes: Vec<f64>,
}

/// Undersampled output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UndersampledOutput {
    /// Index of the output.
    pub output: usize,
    /// Samples per period of the equivalent sine.
    pub per_period: f64,
}

impl<'m> SamplingCheck<'m> {
    /// Check for the outputs of a model at equally spaced samples up to `end_time`, s.
    pub fn new(
        model: &'m DynamicModel,
        outputs: &'m MotionOutputs,
        (end_time, samples): (f64, usize),
    ) -> SamplingCheck<'m> {
        let count = outputs.list.len();
        SamplingCheck {
            model,
            outputs,
            samples,
            spacing: end_time / samples as f64,
            stride: samples / MAX_EVALUATIONS + 1,
            n_samples: 0,
            values: vec![Vec::new(); count],
            slopes: vec![0.0; count],
        }
    }

    /// Adds the next sample: time, state, regime and output values.
    pub fn push(&mut self, (t, y): (f64, &[f64]), regime: Option<&Regime>, outputs: &[f64]) {
        let model = self.model;
        let due = self.n_samples.is_multiple_of(self.stride);
        self.n_samples += 1;
        // With massless nodes the equations do not give the derivative of every state.
        if !due || model.has_massless() || self.samples < MIN_SAMPLES {
            return;
        }
        // The regime is frozen between the two instants of a slope.
        let frozen = model.output_regime(regime, t, y);
        let regime = Some(&*frozen);
        let step = SLOPE_STEP * self.spacing;
        let mut slope = vec![0.0; model.len()];
        model.derivative_in(regime, t, y, &mut slope);
        let ahead: Vec<f64> = y.iter().zip(&slope).map(|(y, s)| y + step * s).collect();
        let later = self.outputs.evaluate(model, regime, t + step, &ahead);
        for (at, (value, later)) in outputs.iter().zip(&later).enumerate() {
            if later.is_finite() {
                self.values[at].push(*value);
                self.slopes[at] += (later - value).abs() / step;
            }
        }
    }

    /// Output with the fewest samples per period, if they are fewer than `min_per_period`.
    pub fn worst_output(&self, min_per_period: f64) -> Option<UndersampledOutput> {
        let resolution = |(output, values): (usize, &Vec<f64>)| {
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let mad = values.iter().map(|x| (x - mean).abs()).sum::<f64>() / count;
            let size = values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let phase =
                self.spacing * self.slopes[output] / count / mad.max(MIN_RELATIVE_AMPLITUDE * size);
            UndersampledOutput {
                output,
                per_period: TAU / phase,
            }
        };
        let outputs = self.values.iter().enumerate().map(resolution);
        let coarse = outputs.filter(|output| output.per_period < min_per_period);
        coarse.min_by(|a, b| a.per_period.total_cmp(&b.per_period))
    }
}
