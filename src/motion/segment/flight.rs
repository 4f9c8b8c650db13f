//! The motion of a machine in one regime from a state on, and what its borders read there.

use super::border::Border;
use super::course::{Course, Stride};
use super::frame::dot;
use super::instant::Instant;
use super::machine::Machine;
use super::sensor::LANES;
use super::shared::Shared;
use crate::numeric::Matrix;
use crate::numeric::slices::add;

/// A motion; used again for the next, so that nothing is allocated on the way.
#[derive(Debug, Default)]
pub struct Flight {
    /// The motion of the parts.
    pub course: Course,
    /// q and q̇ that sticking pairs keep.
    kept: [Vec<f64>; 2],
    borders: Vec<Started>,
    /// When it started, s.
    pub epoch: f64,
    /// The longest time the bounds are asked for at once, s.
    pub reach: f64,
    push: [Vec<f64>; 2],
    given: Vec<f64>,
    carried: Vec<f64>,
    /// Of every sensor.
    sums: Vec<[f64; LANES]>,
    block: Option<Block>,
}

/// A border in a motion.
#[derive(Debug, Clone, Default)]
struct Started {
    /// Constant and slope of what is not σ.
    base: [f64; 2],
    /// Constant and slope of what ṗ has beside the row of σ.
    push: [f64; 2],
    /// What p came to at the start, where it is known to be zero.
    offset: f64,
    /// It is zero at the start.
    zero: bool,
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
    /// p̈; no number where only a bound is known.
    pub bend: f64,
    /// A bound on |p̈| from there on.
    pub bound: f64,
    /// A bound on the third derivative from there on; ∞ where none is known.
    pub jerk: f64,
}

/// States that are read off together.
#[derive(Debug)]
struct Block {
    sigma: Matrix,
    states: Matrix,
}

/// How many states are read off together.
pub const BLOCK: usize = 64;

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
        let n = shared.train.n();
        let growth = machine.linear.parts.growth;
        self.epoch = now.high;
        self.reach = match growth > 0.0 {
            true => span.min(std::f64::consts::LN_2 / growth),
            false => span,
        };
        self.given.clear();
        self.given.extend_from_slice(y);
        for &omega in &shared.inputs.frequencies {
            let (angle, rest) = now.phase(omega);
            let (s, c) = angle.sin_cos();
            self.given.extend([c - s * rest, s + c * rest]);
        }
        let turns = &self.given[y.len()..];
        let sigma = &mut self.course.sigma;
        sigma.clear();
        sigma.extend_from_slice(turns);
        sigma.resize(turns.len() + machine.linear.enter.rows(), 0.0);
        let enter = &machine.linear.enter;
        enter.times(&self.given, &mut sigma[turns.len()..]);

        let first = turns.len();
        let [b0, b1] = &mut self.push;
        b0.clone_from(&machine.load.push);
        b1.clear();
        b1.resize(b0.len(), 0.0);
        for &input in &machine.load.rising {
            let (line, slope) = shared.inputs.list[input].line(pieces, now);
            let [value, rate] = &machine.linear.pushes[input];
            add(b0, line, value);
            add(b0, slope, rate);
            add(b1, slope, value);
        }
        if let Some(hold) = &machine.linear.hold {
            let [place, rate] = &mut self.kept;
            place.clear();
            place.extend_from_slice(&y[..n]);
            // What modes do not carry of it.
            self.carried.resize(y.len(), 0.0);
            machine
                .linear
                .leave
                .times(&self.course.sigma, &mut self.carried);
            add(place, -1.0, &self.carried[..n]);
            rate.resize(n, 0.0);
            let slope = |branch: usize| {
                let e = &shared.train.branches[branch].imposed;
                let piece = pieces[shared.train.drives.len() + branch];
                e.as_ref()
                    .map_or(0.0, |e| e.slope(now.high, piece as usize))
            };
            hold.carry(slope, rate);
            let (b0, b1) = (&mut b0[first..], &mut b1[first..]);
            for k in 0..n {
                add(b0, place[k], hold.from_place.col_as_slice(k));
                add(b0, rate[k], hold.from_rate.col_as_slice(k));
                add(b1, rate[k], hold.from_place.col_as_slice(k));
            }
        }
        let [b0, b1] = &self.push;
        self.course.start(&machine.linear.parts, (b0, b1), span);
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
        self.borders.clear();
        let load = &machine.load;
        let steady = load.rising.is_empty() && machine.linear.hold.is_none();
        for (border, still) in machine.borders.iter().zip(&load.borders) {
            let (mut base, mut slope, mut size) = (still.base, 0.0, still.size);
            let rises = |direct: &&(usize, [f64; 2])| load.rising.contains(&direct.0);
            for &(input, [value, rate]) in border.direct.iter().filter(rises) {
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
            let parts = dot(&border.sizes, &self.course.sizes);
            const ROUNDED: f64 = 4.0 * f64::EPSILON;
            let zero = crossed.is_some_and(|crossed| border.is_back_of(crossed));
            self.borders.push(Started {
                base: [base, slope],
                push: match steady {
                    true => [still.push, 0.0],
                    false => [slope + dot(&border.row, b0), dot(&border.row, b1)],
                },
                offset: match zero {
                    true => base + dot(&border.row, &self.course.sigma),
                    false => 0.0,
                },
                zero,
                noise: ROUNDED * (size + (slope * span).abs() + parts),
            });
        }
    }

    /// Goes to τ, exactly.
    pub fn go(&mut self, machine: &Machine, tau: f64) {
        if tau != self.course.tau || !self.course.is_exact() {
            self.course.go(&machine.linear.parts, &machine.unseen, tau);
        }
    }

    /// Goes on by a stride.
    pub fn stride(&mut self, machine: &Machine, stride: &Stride) {
        let tau = self.course.tau + stride.span;
        let parts = &machine.linear.parts;
        self.course.stride(parts, &machine.unseen, stride, tau);
    }

    /// The same from a τ nearby, where the way is short.
    pub fn near(&mut self, machine: &Machine, tau: f64) {
        if !self
            .course
            .nudge(&machine.linear.parts, &machine.unseen, tau)
        {
            self.go(machine, tau);
        }
    }

    /// Reads all sensors where the motion is; bounds hold from there on for `horizon` seconds at most.
    pub fn look(&mut self, machine: &Machine, horizon: f64) {
        self.sums.resize(machine.sensors.len(), [0.0; LANES]);
        for sensor in 0..machine.sensors.len() {
            self.sense(machine, sensor, horizon);
        }
    }

    /// The same of one border's sensor alone.
    pub fn look_at(&mut self, machine: &Machine, border: usize, horizon: f64) -> Reading {
        self.sense(machine, machine.borders[border].sensor, horizon);
        self.read(machine, border)
    }

    fn sense(&mut self, machine: &Machine, sensor: usize, horizon: f64) {
        let (parts, own) = (&machine.linear.parts, &machine.sensors[sensor]);
        self.sums[sensor] = self.course.sense(parts, &machine.unseen, horizon, own);
    }

    /// A border where the motion was looked at.
    pub fn read(&self, machine: &Machine, at: usize) -> Reading {
        let (border, started) = (&machine.borders[at], &self.borders[at]);
        let tau = self.course.tau;
        let [p, v, q, w, a, b, bound, jerk] = self.sums[border.sensor];
        let sign = border.sign;
        let (bend, jerk) = match machine.linear.parts.is_plain() {
            true => (sign * (a + b), jerk),
            false => (f64::NAN, f64::INFINITY),
        };
        Reading {
            value: match started.zero && tau == 0.0 {
                true => 0.0,
                false => started.base[0] + started.base[1] * tau - started.offset + sign * (p + q),
            },
            rate: started.push[0] + started.push[1] * tau + sign * (v + w),
            bend,
            bound,
            jerk,
        }
    }

    /// Rounding of p.
    pub fn noise(&self, at: usize) -> f64 {
        self.borders[at].noise
    }

    /// Whether a border is zero at the start.
    pub fn starts_on(&self, at: usize) -> bool {
        self.borders[at].zero
    }

    /// The state y where the motion is.
    pub fn state(&mut self, machine: &Machine, y: &mut [f64]) {
        self.course.finish(&machine.linear.parts, &machine.unseen);
        machine.linear.leave.times(&self.course.sigma, y);
        self.keep(machine, self.course.tau, y);
    }

    /// The states at some times, at most [`BLOCK`], where equal ones by strides; `give` may end it early.
    pub fn states(
        &mut self,
        machine: &Machine,
        stride: Option<&Stride>,
        times: &[f64],
        mut give: impl FnMut(usize, &[f64]) -> bool,
    ) -> bool {
        if let ([tau], None) = (times, stride) {
            self.go(machine, *tau);
            let mut y = std::mem::take(&mut self.carried);
            y.resize(machine.linear.leave.rows(), 0.0);
            self.state(machine, &mut y);
            let ended = give(0, &y);
            self.carried = y;
            return ended;
        }
        let (rows, states) = (machine.linear.leave.count(), machine.linear.leave.rows());
        let mut block = match self.block.take() {
            Some(block) if block.sigma.nrows() == rows => block,
            _ => Block {
                sigma: Matrix::zeros(rows, BLOCK),
                states: Matrix::zeros(states, BLOCK),
            },
        };
        let (parts, unseen) = (&machine.linear.parts, &machine.unseen);
        for (at, &tau) in times.iter().enumerate() {
            match stride {
                Some(stride) if at > 0 => self.course.stride(parts, unseen, stride, tau),
                _ => self.course.go(parts, unseen, tau),
            }
            self.course.finish(parts, unseen);
            let column = block.sigma.col_as_slice_mut(at);
            column.copy_from_slice(&self.course.sigma);
        }
        let leave = &machine.linear.leave;
        leave.first_columns(&block.sigma, times.len(), &mut block.states);
        let ended = times.iter().enumerate().any(|(at, &tau)| {
            let y = block.states.col_as_slice_mut(at);
            self.keep(machine, tau, y);
            give(at, y)
        });
        self.block = Some(block);
        ended
    }

    /// Adds what sticking pairs keep.
    fn keep(&self, machine: &Machine, tau: f64, y: &mut [f64]) {
        if machine.linear.hold.is_none() {
            return;
        }
        let n = self.kept[0].len();
        let (q, v) = y.split_at_mut(n);
        add(q, 1.0, &self.kept[0]);
        add(q, tau, &self.kept[1]);
        add(v, 1.0, &self.kept[1]);
    }
}
