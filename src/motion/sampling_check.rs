//! Check that the samples of an output resolve its oscillation, by mean slope over deviation.

use std::f64::consts::TAU;

use super::dynamic_model::DynamicModel;
use super::outputs::MotionOutputs;
use super::problem::OdeProblem;
use super::regime::Regime;

/// Instants looked at, at most: a slope costs an evaluation of the equations.
const MAX_EVALUATIONS: usize = 256;

/// Share of the time between two samples over which a slope is taken.
const SLOPE_STEP: f64 = 1e-4;

/// Oscillation amplitude, as a share of an output's size, below which it is negligible.
const MIN_RELATIVE_AMPLITUDE: f64 = 1e-3;

/// Fewest samples for a check of the sampling.
const MIN_SAMPLES: usize = 4;

/// Looks at outputs while a motion runs.
///
/// For a sine the mean size of the slope over the mean deviation is its ω, wherever the samples lie in its period; so what is as fast
/// as the samples, or much faster, is seen, where a look at the samples alone would take it for something slow. A jump counts by
/// its height and no more. What repeats exactly from sample to sample with no slope there cannot be seen.
pub struct SamplingCheck<'m> {
    model: &'m DynamicModel,
    outputs: &'m MotionOutputs,
    samples: usize,
    /// Between two samples, s.
    spacing: f64,
    /// Stride between examined samples.
    stride: usize,
    seen: usize,
    /// Values of each output, where examined.
    values: Vec<Vec<f64>>,
    /// Sum of the absolute slopes of each output.
    slopes: Vec<f64>,
}

/// An output whose samples do not follow it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UndersampledOutput {
    /// Index of the output.
    pub output: usize,
    /// Samples in a period of a sine that goes so far.
    pub per_period: f64,
}

impl<'m> SamplingCheck<'m> {
    /// For outputs of a model at equal steps over a time, s.
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
            seen: 0,
            values: vec![Vec::new(); count],
            slopes: vec![0.0; count],
        }
    }

    /// Adds the next sample: the state, the contact states and the outputs there.
    pub fn push(&mut self, (t, y): (f64, &[f64]), regime: Option<&Regime>, now: &[f64]) {
        let model = self.model;
        let due = self.seen.is_multiple_of(self.stride);
        self.seen += 1;
        // Where nodes have no inertia the equations give no slope of every state.
        if !due || model.has_massless() || self.samples < MIN_SAMPLES {
            return;
        }
        // Nothing switches between the two instants of a slope.
        let stood = model.output_regime(regime, t, y);
        let regime = Some(&*stood);
        let near = SLOPE_STEP * self.spacing;
        let mut slope = vec![0.0; model.len()];
        model.derivative_in(regime, t, y, &mut slope);
        let beyond: Vec<f64> = y.iter().zip(&slope).map(|(y, s)| y + near * s).collect();
        let then = self.outputs.evaluate(model, regime, t + near, &beyond);
        for (at, (now, then)) in now.iter().zip(&then).enumerate() {
            if then.is_finite() {
                self.values[at].push(*now);
                self.slopes[at] += (then - now).abs() / near;
            }
        }
    }

    /// The output that is followed least, where so few samples as `fewest` lie in a period.
    pub fn worst_output(&self, fewest: f64) -> Option<UndersampledOutput> {
        let of = |(output, values): (usize, &Vec<f64>)| {
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let off = values.iter().map(|x| (x - mean).abs()).sum::<f64>() / count;
            let size = values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let turned =
                self.spacing * self.slopes[output] / count / off.max(MIN_RELATIVE_AMPLITUDE * size);
            UndersampledOutput {
                output,
                per_period: TAU / turned,
            }
        };
        let all = self.values.iter().enumerate().map(of);
        all.filter(|coarse| coarse.per_period < fewest)
            .min_by(|a, b| a.per_period.total_cmp(&b.per_period))
    }
}
