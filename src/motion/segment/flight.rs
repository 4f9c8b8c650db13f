//! The motion of a machine in one regime from a state on, and what its borders read there.

use super::border::Border;
use super::frame::dot;
use super::instant::Instant;
use super::machine::Machine;
use super::shared::Shared;
use super::spectrum::{Run, Strides};
use super::stage::add;
use crate::numeric::{Complex, Matrix};

/// A motion; used again for the next, so that nothing is allocated on the way.
#[derive(Debug, Default)]
pub struct Flight {
    run: Run,
    /// `e^{iωt₀}` of every frequency.
    turns: Vec<Complex>,
    /// The same at the instant last asked for.
    now: Vec<Complex>,
    /// q and q̇ that sticking pairs keep.
    kept: [Vec<f64>; 2],
    borders: Vec<Started>,
    /// When it started, s.
    pub epoch: f64,
    /// The longest time the bounds are asked for at once, s.
    pub reach: f64,
    sigma: Vec<f64>,
    push: [Vec<f64>; 2],
    modal: Vec<f64>,
    fade: Vec<f64>,
    strides: Strides,
}

/// A border in a motion.
#[derive(Debug, Clone, Default)]
struct Started {
    /// Constant and slope of what is not σ.
    base: [f64; 2],
    /// Constant and slope of what ṗ has beside `c Λ σ`.
    push: [f64; 2],
    /// What p came to at the start, where it is known to be zero.
    offset: f64,
    /// It is zero at the start.
    zero: bool,
    /// Bounds on p̈ part by part, before they fade.
    weights: Vec<f64>,
    /// What does not fade.
    lasting: f64,
    /// Rounding of p.
    noise: f64,
}

/// A border at an instant.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reading {
    /// p.
    pub value: f64,
    /// ṗ.
    pub rate: f64,
}

impl Flight {
    /// Starts at the state y; `span` is how long it is wanted for at most, `crossed` the border that was crossed into the regime.
    #[allow(clippy::too_many_arguments)]
    pub fn start(
        &mut self,
        shared: &Shared,
        machine: &Machine,
        (now, pieces): (Instant, &[u32]),
        y: &[f64],
        span: f64,
        crossed: Option<&Border>,
    ) {
        let (n, m) = (shared.train.n(), machine.modes.count());
        let len = machine.spectrum.count();
        self.epoch = now.high;
        self.reach = match machine.growth > 0.0 {
            true => span.min(std::f64::consts::LN_2 / machine.growth),
            false => span,
        };
        self.modal.clear();
        let momenta = &machine.modes.momenta;
        for part in [&y[..n], &y[n..2 * n]] {
            let mode = |j| dot(momenta.col_as_slice(j), part);
            self.modal.extend((0..m).map(mode));
        }
        self.modal.extend_from_slice(&y[2 * n..]);
        self.sigma.resize(len, 0.0);
        machine.stage.enter(&self.modal, &mut self.sigma);
        self.turns.clear();
        for (&omega, answer) in shared.inputs.frequencies.iter().zip(&machine.steady) {
            let (angle, rest) = now.phase(omega);
            let (s, c) = angle.sin_cos();
            let turn = Complex::new(c - s * rest, s + c * rest);
            self.turns.push(turn);
            add(&mut self.sigma, -turn.re, &answer.sigma[0]);
            add(&mut self.sigma, turn.im, &answer.sigma[1]);
        }
        self.now.clone_from(&self.turns);

        let [b0, b1] = &mut self.push;
        b0.clone_from(&machine.constant);
        b1.clear();
        b1.resize(len, 0.0);
        for (input, [value, rate]) in shared.inputs.list.iter().zip(&machine.pushes) {
            let (line, slope) = input.line(pieces, now);
            if line != 0.0 {
                add(b0, line, value);
            }
            if slope != 0.0 {
                add(b0, slope, rate);
                add(b1, slope, value);
            }
        }
        if let Some(hold) = &machine.hold {
            let [place, rate] = &mut self.kept;
            place.clear();
            place.extend_from_slice(&y[..n]);
            for j in 0..m {
                add(place, -self.modal[j], machine.modes.shapes.col_as_slice(j));
            }
            rate.resize(n, 0.0);
            let slope = |branch: usize| {
                let e = shared.train.branches[branch].imposed.as_ref();
                let piece = pieces[shared.train.drives.len() + branch];
                e.map_or(0.0, |e| e.slope(now.high, piece as usize))
            };
            hold.carry(slope, rate);
            for k in 0..n {
                add(b0, place[k], hold.from_place.col_as_slice(k));
                add(b0, rate[k], hold.from_rate.col_as_slice(k));
                add(b1, rate[k], hold.from_place.col_as_slice(k));
            }
        }
        machine.spectrum.start(
            &mut self.run,
            &self.sigma,
            (b0, b1),
            &machine.near,
            &self.turns,
            span,
        );
        self.fade.resize(self.run.bounds.len(), 0.0);
        self.start_borders(shared, machine, (now, pieces), span, crossed);
    }

    fn start_borders(
        &mut self,
        shared: &Shared,
        machine: &Machine,
        (now, pieces): (Instant, &[u32]),
        span: f64,
        crossed: Option<&Border>,
    ) {
        let [b0, b1] = &self.push;
        if self.borders.len() < machine.borders.len() {
            self.borders
                .resize(machine.borders.len(), Started::default());
        }
        for (border, started) in machine.borders.iter().zip(&mut self.borders) {
            let (mut base, mut slope) = (border.constant, 0.0);
            let mut size = base.abs();
            for &(input, [value, rate]) in &border.direct {
                let (line, change) = shared.inputs.list[input].line(pieces, now);
                base += value * line + rate * change;
                slope += value * change;
                size += (value * line).abs() + (rate * change).abs();
            }
            if let Some([place, rate]) = &border.dense {
                let (by_place, by_rate) = (dot(place, &self.kept[0]), dot(rate, &self.kept[1]));
                base += by_place + by_rate;
                slope += dot(place, &self.kept[1]);
                size += by_place.abs() + by_rate.abs();
            }
            started.base = [base, slope];
            started.push = [slope + dot(&border.row, b0), dot(&border.row, b1)];
            started.lasting = border.swing + dot(&border.sizes, &self.run.lasting);
            started.weights.clear();
            let both = border.sizes.iter().zip(&self.run.bounds);
            started.weights.extend(both.map(|(c, bound)| c * bound));
            let parts = dot(&border.sizes, &self.run.sizes);
            const ROUNDED: f64 = 4.0 * f64::EPSILON;
            started.noise = ROUNDED * (size + (slope * span).abs() + border.steady + parts);
            started.zero = crossed.is_some_and(|crossed| border.is_back_of(crossed));
            started.offset = 0.0;
        }
        if self
            .borders
            .iter()
            .take(machine.borders.len())
            .any(|b| b.zero)
        {
            self.move_to(shared, machine, 0.0);
            for at in 0..machine.borders.len() {
                if self.borders[at].zero {
                    self.borders[at].offset = self.read(machine, at, 0.0).value;
                }
            }
        }
    }

    /// Goes to τ, for [`Flight::read`] and [`Flight::state`].
    pub fn move_to(&mut self, shared: &Shared, machine: &Machine, tau: f64) {
        machine.spectrum.at(
            &self.run,
            &machine.near,
            tau,
            &mut self.sigma,
            &mut self.fade,
        );
        self.turn_inputs(shared, tau);
    }

    /// Prepares [`Flight::stride_to`] over equal strides of h.
    pub fn stride(&mut self, machine: &Machine, h: f64) {
        machine.spectrum.stride(h, &mut self.strides);
    }

    /// Goes to τ, one stride after the last time, for [`Flight::state`].
    pub fn stride_to(&mut self, shared: &Shared, machine: &Machine, tau: f64) {
        machine.spectrum.after_stride(
            &self.run,
            &machine.near,
            tau,
            &mut self.sigma,
            &mut self.strides,
        );
        self.turn_inputs(shared, tau);
    }

    fn turn_inputs(&mut self, shared: &Shared, tau: f64) {
        for ((now, start), omega) in self
            .now
            .iter_mut()
            .zip(&self.turns)
            .zip(&shared.inputs.frequencies)
        {
            let (s, c) = (omega * tau).sin_cos();
            *now = start * Complex::new(c, s);
        }
    }

    /// A border where the motion was moved to, τ.
    pub fn read(&self, machine: &Machine, at: usize, tau: f64) -> Reading {
        let (border, started) = (&machine.borders[at], &self.borders[at]);
        let mut value = started.base[0] + started.base[1] * tau - started.offset;
        let mut rate = started.push[0] + started.push[1] * tau;
        for ((c, r), sigma) in border.row.iter().zip(&border.rate).zip(&self.sigma) {
            value += c * sigma;
            rate += r * sigma;
        }
        for ([p, q], turn) in border.phasors.iter().zip(&self.now) {
            value += p.re * turn.re - p.im * turn.im;
            rate += q.re * turn.re - q.im * turn.im;
        }
        if started.zero && tau == 0.0 {
            value = 0.0;
        }
        Reading { value, rate }
    }

    /// Prepares bounds on p̈ from τ on, for `horizon` seconds at most.
    pub fn fade(&mut self, machine: &Machine, tau: f64, horizon: f64) {
        machine.spectrum.fade(tau, horizon, &mut self.fade);
    }

    /// The bound on |p̈| of a border that [`Flight::fade`] prepared.
    pub fn bound(&self, machine: &Machine, at: usize, until: f64) -> f64 {
        let started = &self.borders[at];
        let lasting = match machine.growth > 0.0 && !machine.near.is_empty() {
            true => started.lasting * (machine.growth * until).exp(),
            false => started.lasting,
        };
        lasting + dot(&started.weights, &self.fade)
    }

    /// Rounding of p.
    pub fn noise(&self, at: usize) -> f64 {
        self.borders[at].noise
    }

    /// Whether a border is zero at the start.
    pub fn starts_on(&self, at: usize) -> bool {
        self.borders[at].zero
    }

    /// The state y where the motion was moved to, τ.
    pub fn state(&mut self, machine: &Machine, tau: f64, y: &mut [f64]) {
        let (n, m) = (machine.modes.shapes.nrows(), machine.modes.count());
        machine.stage.leave(&self.sigma, &mut self.modal);
        for (answer, turn) in machine.steady.iter().zip(&self.now) {
            add(&mut self.modal, turn.re, &answer.modal[0]);
            add(&mut self.modal, -turn.im, &answer.modal[1]);
        }
        let (q, rest) = y.split_at_mut(n);
        let (v, z) = rest.split_at_mut(n);
        match machine.hold {
            Some(_) => {
                q.copy_from_slice(&self.kept[0]);
                v.copy_from_slice(&self.kept[1]);
                add(q, tau, &self.kept[1]);
            }
            None => {
                q.fill(0.0);
                v.fill(0.0);
            }
        }
        let (places, rates) = self.modal.split_at(m);
        sum_shapes(&machine.modes.shapes, (places, &rates[..m]), (q, v));
        z.copy_from_slice(&self.modal[2 * m..]);
    }
}

/// `q += Φ η`, `v += Φ η̇`, four modes at a time.
fn sum_shapes(shapes: &Matrix, (eta, rate): (&[f64], &[f64]), (q, v): (&mut [f64], &mut [f64])) {
    const AT_ONCE: usize = 4;
    let whole = eta.len() - eta.len() % AT_ONCE;
    for first in (0..whole).step_by(AT_ONCE) {
        let [a, b, c, d] = std::array::from_fn(|k| shapes.col_as_slice(first + k));
        let (x, y) = (&eta[first..first + AT_ONCE], &rate[first..first + AT_ONCE]);
        let columns = a.iter().zip(b).zip(c.iter().zip(d));
        for ((q, v), ((a, b), (c, d))) in q.iter_mut().zip(v.iter_mut()).zip(columns) {
            *q += (a * x[0] + b * x[1]) + (c * x[2] + d * x[3]);
            *v += (a * y[0] + b * y[1]) + (c * y[2] + d * y[3]);
        }
    }
    for j in whole..eta.len() {
        add(q, eta[j], shapes.col_as_slice(j));
        add(v, rate[j], shapes.col_as_slice(j));
    }
}
