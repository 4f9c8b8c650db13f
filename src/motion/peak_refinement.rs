//! Extremes between samples: where three samples of an output have a peak, the states between are interpolated, and the output is
//! evaluated there.
//!
//! Of every coordinate x, ẋ and ẍ are known at both samples. The quintic through them is off by `x⁽⁶⁾ h⁶/46 080` at the middle, and the
//! equations show how much: where its second derivative is off by r there, it is off by `r h²/24` itself, and its slope by 3.43 times
//! that over h at most. A peak is taken only where that leaves the digits shown.

use super::dynamic_model::{DynamicModel, ElementState};
use super::output_statistics::StatisticsAccumulator;
use super::outputs::MotionOutputs;
use super::regime::Regime;

/// A refined peak may be off by this share of its size: half of the fourth digit.
const MAX_ERROR: f64 = 5e-5;

/// Parts of the time between two samples at whose ends an output is evaluated.
const PARTS: usize = 8;

/// A sample with what holds there.
struct Sample {
    t: f64,
    state: Vec<f64>,
    /// The regime, where the method has one.
    regime: Option<Regime>,
    outputs: Vec<f64>,
}

/// Refines the extremes of outputs while a motion runs.
pub struct PeakRefinement<'m> {
    model: &'m DynamicModel,
    outputs: &'m MotionOutputs,
    /// The last two samples.
    last: [Option<Sample>; 2],
}

impl<'m> PeakRefinement<'m> {
    /// For outputs of a model.
    pub fn new(model: &'m DynamicModel, outputs: &'m MotionOutputs) -> PeakRefinement<'m> {
        PeakRefinement {
            model,
            outputs,
            last: [None, None],
        }
    }

    /// Takes the next sample and raises the extremes that lie next to the one before.
    pub fn push(
        &mut self,
        (t, y): (f64, &[f64]),
        regime: Option<&Regime>,
        outputs: &[f64],
        accumulators: &mut [StatisticsAccumulator],
    ) {
        // The equations do not give the acceleration of nodes without inertia.
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
                // The vertex of the parabola is higher than the middle by half of this at most.
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

/// The peak of an output between two samples of one regime, upward where `sense` is 1; absent where it is not known well enough.
fn peak(
    (model, outputs): (&DynamicModel, &MotionOutputs),
    output: usize,
    sense: f64,
    one: &Sample,
    two: &Sample,
) -> Option<(f64, f64)> {
    let held = [one, two].map(|s| model.output_regime(s.regime.as_ref(), s.t, &s.state));
    if !are_alike(model, &held[0], &held[1]) {
        return None;
    }
    let between = Interpolant::new(model, [(one, &held[0]), (two, &held[1])]);
    let value_at = |share: f64, state: &[f64]| {
        let t = between.time(share);
        let regime = carried_on(model, &held[0], t, state);
        outputs.evaluate(model, Some(&regime), t, state)[output]
    };
    let value = |share: f64| value_at(share, &between.state(share));
    let mut values = [0.0; PARTS + 1];
    for (k, x) in values.iter_mut().enumerate() {
        *x = match k {
            0 => one.outputs[output],
            PARTS => two.outputs[output],
            _ => value(k as f64 / PARTS as f64),
        };
    }
    let best = (1..PARTS).max_by(|i, j| (sense * values[*i]).total_cmp(&(sense * values[*j])))?;
    let bend = 2.0 * values[best] - values[best - 1] - values[best + 1];
    let vertex = 0.5 * (values[best + 1] - values[best - 1]) / bend;
    let share = (best as f64 + vertex.clamp(-1.0, 1.0)) / PARTS as f64;
    let highest = match share.is_finite() {
        true => (share, value(share)),
        false => (best as f64 / PARTS as f64, values[best]),
    };
    let (share, found) = match sense * highest.1 >= sense * values[best] {
        true => highest,
        false => (best as f64 / PARTS as f64, values[best]),
    };
    let middle = between.state(0.5);
    let off = between.error_states(
        model,
        &carried_on(model, &held[0], between.time(0.5), &middle),
    );
    let known = value_at(0.5, &middle);
    let error: f64 = off
        .iter()
        .map(|state| (value_at(0.5, state) - known).abs())
        .sum();
    (error <= MAX_ERROR * found.abs()).then(|| (between.time(share), found))
}

/// Whether the same contacts are closed, the same pairs stick and the same lines of known signals hold.
fn are_alike(model: &DynamicModel, a: &Regime, b: &Regime) -> bool {
    let lines = model.forces.len() + model.elements.len();
    let same = |pair: (&ElementState, &ElementState)| match pair {
        (ElementState::Contact(a, _), ElementState::Contact(b, _)) => a == b,
        (a, b) => a == b,
    };
    a.pieces[..lines] == b.pieces[..lines] && a.states.iter().zip(&b.states).all(same)
}

/// The regime at a state, with contacts and friction as in another.
fn carried_on(model: &DynamicModel, held: &Regime, t: f64, y: &[f64]) -> Regime {
    let mut regime = model.contact_regime(t, y);
    for (own, held) in regime.states.iter_mut().zip(&held.states) {
        *own = match (*own, *held) {
            (ElementState::Contact(_, piece), ElementState::Contact(state, _)) => {
                ElementState::Contact(state, piece)
            }
            (_, held) => held,
        };
    }
    regime
}

/// States between two samples.
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

    fn time(&self, share: f64) -> f64 {
        self.ends[0].t + share * self.h
    }

    /// Value, slope and second derivative of a coordinate, by the quintic through all three at both ends.
    fn jet(&self, i: usize, s: f64) -> [f64; 3] {
        let h = self.h;
        let of = |end: usize| {
            let (y, slope) = (&self.ends[end].state, &self.slopes[end]);
            [y[i], h * y[self.n + i], h * h * slope[self.n + i]]
        };
        let ([x0, v0, a0], [x1, v1, a1]) = (of(0), of(1));
        // What the parabola at the first end leaves at the second.
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

    /// The state; inner states by the cubic through values and slopes.
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

    /// The state at the middle with what the coordinates may be off by, and with what their slopes may be off by.
    fn error_states(&self, model: &DynamicModel, regime: &Regime) -> [Vec<f64>; 2] {
        const SLOPE_RATIO: f64 = 3.43;
        let (n, h, middle) = (self.n, self.h, self.state(0.5));
        let mut slope = vec![0.0; middle.len()];
        model.derivative_in(Some(regime), self.time(0.5), &middle, &mut slope);
        let mut states = [middle.clone(), middle];
        for i in 0..n {
            let off = (self.jet(i, 0.5)[2] - slope[n + i]) * h * h / 24.0;
            states[0][i] += off;
            states[1][n + i] += SLOPE_RATIO * off / h;
        }
        states
    }
}
