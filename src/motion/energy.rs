//! The energy balance: what is stored, what is put in, what is lost.

use std::f64::consts::TAU;

use super::train::{BranchStand, Law, Regime, Train};
use super::wave::{Phase, Wave};
use crate::numeric::Matrix;

/// Powers at one instant, W.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Powers {
    /// By loads, motors, imposed motions and stiffness that varies of itself.
    pub put_in: f64,
    /// In dampers, friction, flanks that let go.
    pub lost: f64,
}

impl Train {
    /// Kinetic and potential energy, J.
    pub fn stored(&self, regime: &Regime, t: f64, y: &[f64]) -> f64 {
        let n = self.n();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let kinetic: f64 = 0.5
            * v.iter()
                .zip(self.momentum(v))
                .map(|(v, p)| v * p)
                .sum::<f64>();
        let mut inner = 2 * n;
        let mut potential = 0.0;
        for (at, b) in self.branches.iter().enumerate() {
            let (delta, _) = b.deflection(t, q, v, self.imposed_piece(regime, at));
            potential += match (&b.law, regime.stands[at]) {
                (Law::Linear { stiffness, .. }, _) => 0.5 * stiffness * delta * delta,
                (Law::Contact(contact), BranchStand::Contact(stand, piece)) => {
                    contact.stored(stand, b.factor(t, q, piece).0, delta)
                }
                (Law::Nonlinear { characteristic, .. }, _) => characteristic.stored(delta),
                (Law::Maxwell { stiffness, .. }, _) => 0.5 * y[inner] * y[inner] / stiffness,
                _ => 0.0,
            };
            inner += b.inner();
        }
        let general = self
            .general
            .as_ref()
            .map_or(0.0, |(k, _)| 0.5 * form(k, q, q));
        kinetic + potential + general
    }

    /// What a branch of dry friction loses at an instant, W.
    pub fn rubbed_away(&self, regime: &Regime, t: f64, y: &[f64], branch: usize) -> f64 {
        let n = self.n();
        let b = &self.branches[branch];
        let (_, rate) = b.deflection(t, &y[..n], &y[n..2 * n], self.imposed_piece(regime, branch));
        let aside = self.aside(branch, Some(regime), t, y);
        let beside = aside.map_or(0.0, |(force, along)| force * along.dot(&y[n..2 * n]));
        self.held(regime, t, y, branch) * rate + beside
    }

    /// What is put in and lost at an instant.
    pub fn powers(&self, regime: &Regime, t: f64, y: &[f64]) -> Powers {
        let n = self.n();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut powers = Powers::default();
        for (at, drive) in self.drives.iter().enumerate() {
            powers.put_in +=
                drive.signal.value(t, regime.pieces[at] as usize) * drive.direction.dot(v);
        }
        let mut inner = 2 * n;
        for (at, b) in self.branches.iter().enumerate() {
            let z = if b.inner() > 0 { y[inner] } else { 0.0 };
            inner += b.inner();
            let piece = self.imposed_piece(regime, at);
            let (delta, rate) = b.deflection(t, q, v, piece);
            let force = match b.law {
                Law::Friction(_) | Law::Clutch { .. } | Law::Pressed(_) => {
                    self.held(regime, t, y, at)
                }
                _ => self.force(at, Some(regime), t, y, z).0,
            };
            // Where the force does not act along w, the difference is put in; so is what an imposed e pushes.
            let acted = b.acts().dot(v);
            powers.put_in += force * (b.direction.dot(v) - acted);
            powers.put_in -= b
                .imposed
                .as_ref()
                .map_or(0.0, |e| force * e.slope(t, piece as usize));
            for Wave { shape, phase } in &b.followed {
                let psi = phase.at(t, q);
                let slope = shape.slope_in(psi, shape.piece(psi));
                powers.put_in -= force * slope * phase.imposed_rate(t);
            }
            match &b.law {
                Law::Linear { stiffness, .. } => powers.lost += (force - stiffness * delta) * rate,
                Law::Contact(contact) => {
                    let BranchStand::Contact(stand, of_wave) = regime.stands[at] else {
                        continue;
                    };
                    let (factor, slope) = b.factor(t, q, of_wave);
                    let beyond = contact.beyond(stand, delta);
                    powers.lost += (force - factor * contact.stiffness * beyond) * rate;
                    if let Some(wave) = &b.variation {
                        let rate = slope * wave.phase.imposed_rate(t);
                        powers.put_in += 0.5 * contact.stiffness * rate * beyond * beyond;
                    }
                }
                Law::Nonlinear { damping, .. } => powers.lost += damping * rate * rate,
                Law::Friction(_) | Law::Clutch { .. } | Law::Pressed(_) => {
                    powers.lost += self.rubbed_away(regime, t, y, at);
                }
                Law::Curve(_) | Law::Lagged { .. } | Law::Orders { .. } => {
                    powers.put_in -= force * rate;
                }
                Law::Maxwell { damping, .. } => powers.lost += z * z / damping,
            }
        }
        powers.lost += self.drag
            * v.iter()
                .zip(self.momentum(v))
                .map(|(v, p)| v * p)
                .sum::<f64>();
        if let Some((k, c)) = &self.general {
            powers.lost += form(c, v, v) + 0.5 * (form(k, v, q) - form(k, q, v));
        }
        powers
    }
}

/// `xᵀ A y`.
fn form(a: &Matrix, x: &[f64], y: &[f64]) -> f64 {
    (0..x.len())
        .map(|i| x[i] * (0..y.len()).map(|j| a[(i, j)] * y[j]).sum::<f64>())
        .sum()
}

/// The balance over a run, J.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Balance {
    /// Stored at the start.
    pub before: f64,
    /// Stored at the end.
    pub after: f64,
    /// Put in.
    pub put_in: f64,
    /// Lost.
    pub lost: f64,
    /// The largest energy stored at any sample.
    pub largest: f64,
}

impl Balance {
    /// What does not add up, as a share of the largest of all parts.
    pub fn gap(&self) -> f64 {
        let size = self.largest.max(self.put_in.abs()).max(self.lost.abs());
        match size {
            0.0 => 0.0,
            size => ((self.after - self.before) - self.put_in + self.lost) / size,
        }
    }
}

/// Adds up powers over equally spaced samples by Simpson's rule. A stiffness wave that jumps between two of them is booked
/// with the motion at that instant, interpolated through both. What opens or closes in between costs the rule order there.
#[derive(Debug, Default)]
pub struct Meter {
    samples: Vec<(f64, Powers)>,
    last: Option<(f64, Vec<f64>)>,
    balance: Balance,
}

impl Meter {
    /// Takes one more sample; `driven` is what prescribed motions put in beside the machine's own drives, W.
    pub fn sample(&mut self, train: &Train, regime: &Regime, (t, y): (f64, &[f64]), driven: f64) {
        let stored = train.stored(regime, t, y);
        match &self.last {
            None => self.balance.before = stored,
            Some((before, from)) => {
                self.balance.put_in += jumps(train, (*before, from), (t, y));
            }
        }
        self.balance.after = stored;
        self.balance.largest = self.balance.largest.max(stored.abs());
        let mut powers = train.powers(regime, t, y);
        powers.put_in += driven;
        self.samples.push((t, powers));
        self.last = Some((t, y.to_vec()));
        if let [a, b, c] = self.samples[..] {
            let sixth = (c.0 - a.0) / 6.0;
            self.balance.put_in += sixth * (a.1.put_in + 4.0 * b.1.put_in + c.1.put_in);
            self.balance.lost += sixth * (a.1.lost + 4.0 * b.1.lost + c.1.lost);
            self.samples = vec![c];
        }
    }

    /// The instant of the last sample, s.
    pub fn time(&self) -> Option<f64> {
        self.last.as_ref().map(|last| last.0)
    }

    /// Books what was put in at an instant, J.
    pub fn put_in(&mut self, energy: f64) {
        self.balance.put_in += energy;
    }

    /// The balance so far.
    pub fn balance(mut self) -> Balance {
        if let [a, b] = self.samples[..] {
            let half = (b.0 - a.0) / 2.0;
            self.balance.put_in += half * (a.1.put_in + b.1.put_in);
            self.balance.lost += half * (a.1.lost + b.1.lost);
        }
        self.balance
    }
}

/// What stiffness waves that jump at imposed speed put in between two samples, J.
fn jumps(train: &Train, (t, from): (f64, &[f64]), (u, to): (f64, &[f64])) -> f64 {
    let n = train.n();
    let mut sum = 0.0;
    for b in &train.branches {
        let (Law::Contact(contact), Some(wave)) = (&b.law, &b.variation) else {
            continue;
        };
        let Phase::Imposed { omega, start } = wave.phase else {
            continue;
        };
        let (first, last) = (wave.phase.at(t, &[]), wave.phase.at(u, &[]));
        let mut psi = wave.shape.next_piece(first);
        while psi <= last {
            let at = (psi * TAU - start) / omega;
            let q = between((t, from), (u, to), at, n);
            let piece = b.imposed.as_ref().map_or(0, |e| e.piece(at) as u32);
            let (delta, rate) = b.deflection(at, &q, &from[n..2 * n], piece);
            let next = wave.shape.next_piece(psi);
            let (old, new) = (
                wave.shape.value(psi - 1e-9),
                wave.shape.value(psi + 1e-9 * (next - psi)),
            );
            let beyond = contact.beyond(contact.stand(delta, rate, new), delta);
            sum += 0.5 * contact.stiffness * (new - old) * beyond * beyond;
            psi = next;
        }
    }
    sum
}

/// Positions at an instant between two samples: the cubic through both positions and speeds.
fn between((t, from): (f64, &[f64]), (u, to): (f64, &[f64]), at: f64, n: usize) -> Vec<f64> {
    let h = u - t;
    let s = (at - t) / h;
    let (a, b) = ((1.0 + 2.0 * s) * (1.0 - s).powi(2), s * s * (3.0 - 2.0 * s));
    let (c, d) = (h * s * (1.0 - s).powi(2), h * s * s * (s - 1.0));
    (0..n)
        .map(|i| a * from[i] + b * to[i] + c * from[n + i] + d * to[n + i])
        .collect()
}
