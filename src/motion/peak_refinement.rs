//! Extremes between samples: if three samples of an output have a peak, the states between them are interpolated and the output is
//! evaluated there.
//!
//! For every coordinate x, ẋ and ẍ are known at both samples. The error of the quintic Hermite interpolant is `x⁽⁶⁾ h⁶/46 080` at the
//! middle. The equations of motion give the residual r of its second derivative there, from which its error is `r h²/24` and that of its
//! slope at most `3.43 r h/24`. A peak is accepted only if these errors do not affect the printed digits.

use super::dynamic_model::{DynamicModel, ElementState};
use super::output_statistics::StatisticsAccumulator;
use super::outputs::MotionOutputs;
use super::regime::Regime;

/// Largest relative error of a refined peak: half a unit of the fourth digit.
const MAX_ERROR: f64 = 5e-5;

/// Number of subintervals between two samples at whose ends an output is evaluated.
const PARTS: usize = 8;

/// Sample with its regime and outputs.
struct Sample {
    t: f64,
    state: Vec<f64>,
    /// Regime, if the method uses regimes.
    regime: Option<Regime>,
    outputs: Vec<f64>,
}

/// Refinement of the output extremes during an integration run.
pub struct PeakRefinement<'m> {
    model: &'m DynamicModel,
    outputs: &'m MotionOutputs,
    /// Last two samples, the older first.
    last: [Option<Sample>; 2],
}

impl<'m> PeakRefinement<'m> {
    /// Refinement for the outputs of a model.
    pub fn new(model: &'m DynamicModel, outputs: &'m MotionOutputs) -> PeakRefinement<'m> {
        PeakRefinement {
            model,
            outputs,
            last: [None, None],
        }
    }

    /// Adds the next sample and extends the extremes around the previous one.
    pub fn push(
        &mut self,
        (t, y): (f64, &[f64]),
        regime: Option<&Regime>,
        outputs: &[f64],
        accumulators: &mut [StatisticsAccumulator],
    ) {
        // The equations do not give the acceleration of massless nodes.
        if self.model.has_massless() {
            return;
        }
        let next = Sample {
            t,
            state: y.to_vec(),
            regime: regime.cloned(),
            outputs: outputs.to_vec(),
        };
        if let [Some(before), Some(middle)] = &self.last {
            for (at, accumulator) in accumulators.iter_mut().enumerate() {
                let [a, b, c] = [before, middle, &next].map(|s| s.outputs[at]);
                // The vertex of the parabola exceeds the middle sample by at most half of this.
                let reach = (2.0 * b - a - c) / 8.0;
                if (b - a) * (b - c) < 0.0 || reach == 0.0 || !accumulator.is_beyond(b + reach) {
                    continue;
                }
                for (one, two) in [(before, middle), (middle, &next)] {
                    if let Some((t, value)) =
                        peak((self.model, self.outputs), at, reach.signum(), one, two)
                    {
                        accumulator.extend(t, value);
                    }
                }
            }
        }
        let middle = self.last[1].take();
        self.last = [middle, Some(next)];
    }
}

/// Time and value of the peak of an output between two samples of one regime, a maximum for `sense` 1; `None` if its error is too large.
fn peak(
    (model, outputs): (&DynamicModel, &MotionOutputs),
    output: usize,
    sense: f64,
    one: &Sample,
    two: &Sample,
) -> Option<(f64, f64)> {
    let regimes = [one, two].map(|s| model.output_regime(s.regime.as_ref(), s.t, &s.state));
    if !is_same_regime(model, &regimes[0], &regimes[1]) {
        return None;
    }
    let interpolant = Interpolant::new(model, [(one, &regimes[0]), (two, &regimes[1])]);
    let value_at = |theta: f64, state: &[f64]| {
        let t = interpolant.time(theta);
        let regime = with_states_of(model, &regimes[0], t, state);
        outputs.evaluate(model, Some(&regime), t, state)[output]
    };
    let value = |theta: f64| value_at(theta, &interpolant.state(theta));
    let mut values = [0.0; PARTS + 1];
    for (k, x) in values.iter_mut().enumerate() {
        *x = match k {
            0 => one.outputs[output],
            PARTS => two.outputs[output],
            _ => value(k as f64 / PARTS as f64),
        };
    }
    let top = (1..PARTS).max_by(|i, j| (sense * values[*i]).total_cmp(&(sense * values[*j])))?;
    let curvature = 2.0 * values[top] - values[top - 1] - values[top + 1];
    let vertex = 0.5 * (values[top + 1] - values[top - 1]) / curvature;
    let theta = (top as f64 + vertex.clamp(-1.0, 1.0)) / PARTS as f64;
    let refined = match theta.is_finite() {
        true => (theta, value(theta)),
        false => (top as f64 / PARTS as f64, values[top]),
    };
    let (theta, extreme) = match sense * refined.1 >= sense * values[top] {
        true => refined,
        false => (top as f64 / PARTS as f64, values[top]),
    };
    let middle = interpolant.state(0.5);
    let perturbed = interpolant.error_states(
        model,
        &with_states_of(model, &regimes[0], interpolant.time(0.5), &middle),
    );
    let reference = value_at(0.5, &middle);
    let error: f64 = perturbed
        .iter()
        .map(|state| (value_at(0.5, state) - reference).abs())
        .sum();
    (error <= MAX_ERROR * extreme.abs()).then(|| (interpolant.time(theta), extreme))
}

/// Whether two regimes have the same contact and friction states and the same pieces of the known signals.
fn is_same_regime(model: &DynamicModel, a: &Regime, b: &Regime) -> bool {
    let n_pieces = model.forces.len() + model.elements.len();
    let same = |pair: (&ElementState, &ElementState)| match pair {
        (ElementState::Contact(a, _), ElementState::Contact(b, _)) => a == b,
        (a, b) => a == b,
    };
    a.pieces[..n_pieces] == b.pieces[..n_pieces] && a.states.iter().zip(&b.states).all(same)
}

/// Regime at a state with the contact and friction states of another regime.
fn with_states_of(model: &DynamicModel, source: &Regime, t: f64, y: &[f64]) -> Regime {
    let mut regime = model.contact_regime(t, y);
    for (state, source) in regime.states.iter_mut().zip(&source.states) {
        *state = match (*state, *source) {
            (ElementState::Contact(_, piece), ElementState::Contact(state, _)) => {
                ElementState::Contact(state, piece)
            }
            (_, source) => source,
        };
    }
    regime
}

/// Hermite interpolant of the states between two samples.
struct Interpolant<'s> {
    ends: [&'s Sample; 2],
    /// ẏ at the ends.
    slopes: [Vec<f64>; 2],
    n: usize,
    h: f64,
}

impl<'s> Interpolant<'s> {
    fn new(model: &DynamicModel, ends: [(&'s Sample, &Regime); 2]) -> Interpolant<'s> {
        let slopes = ends.map(|(sample, regime)| {
            let mut slope = vec![0.0; sample.state.len()];
            model.derivative_in(Some(regime), sample.t, &sample.state, &mut slope);
            slope
        });
        let ends = ends.map(|(sample, _)| sample);
        Interpolant {
            ends,
            slopes,
            n: model.coordinate_count(),
            h: ends[1].t - ends[0].t,
        }
    }

    fn time(&self, theta: f64) -> f64 {
        self.ends[0].t + theta * self.h
    }

    /// Value, slope and second derivative of coordinate i at s in [0, 1], by the quintic Hermite interpolant.
    fn jet(&self, i: usize, s: f64) -> [f64; 3] {
        let h = self.h;
        let derivatives = |end: usize| {
            let (y, slope) = (&self.ends[end].state, &self.slopes[end]);
            [y[i], h * y[self.n + i], h * h * slope[self.n + i]]
        };
        let ([x0, v0, a0], [x1, v1, a1]) = (derivatives(0), derivatives(1));
        // Residuals at the second end of the Taylor parabola at the first.
        let (dx, dv, da) = (x1 - x0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0);
        let c = [
            10.0 * dx - 4.0 * dv + 0.5 * da,
            -15.0 * dx + 7.0 * dv - da,
            6.0 * dx - 3.0 * dv + 0.5 * da,
        ];
        let x = x0 + s * (v0 + s * (0.5 * a0 + s * (c[0] + s * (c[1] + s * c[2]))));
        let v = v0 + s * (a0 + s * (3.0 * c[0] + s * (4.0 * c[1] + s * 5.0 * c[2])));
        let a = a0 + s * (6.0 * c[0] + s * (12.0 * c[1] + s * 20.0 * c[2]));
        [x, v / h, a / (h * h)]
    }

    /// State at s in [0, 1]; internal states by the cubic Hermite interpolant.
    fn state(&self, s: f64) -> Vec<f64> {
        let (n, h) = (self.n, self.h);
        let [a, b] = self.ends.map(|end| &end.state);
        let mut state = a.clone();
        for i in 0..n {
            let [x, v, _] = self.jet(i, s);
            (state[i], state[n + i]) = (x, v);
        }
        for i in 2 * n..a.len() {
            let (va, vb) = (h * self.slopes[0][i], h * self.slopes[1][i]);
            let d = b[i] - a[i];
            state[i] = a[i] + s * (va + s * (3.0 * d - 2.0 * va - vb + s * (va + vb - 2.0 * d)));
        }
        state
    }

    /// States at the middle perturbed by the error bounds of the coordinates and by those of their slopes.
    fn error_states(&self, model: &DynamicModel, regime: &Regime) -> [Vec<f64>; 2] {
        const SLOPE_RATIO: f64 = 3.43;
        let (n, h, middle) = (self.n, self.h, self.state(0.5));
        let mut slope = vec![0.0; middle.len()];
        model.derivative_in(Some(regime), self.time(0.5), &middle, &mut slope);
        let mut states = [middle.clone(), middle];
        for i in 0..n {
            let error = (self.jet(i, 0.5)[2] - slope[n + i]) * h * h / 24.0;
            states[0][i] += error;
            states[1][n + i] += SLOPE_RATIO * error / h;
        }
        states
    }
}
