//! A machine stepped from regime to regime: every switch ends a step.
//!
//! In a step the regime is frozen, so the method sees a smooth problem and runs past the border. The border is then a
//! polynomial of the step; where it crosses zero, the step is taken again with h ← h − p/ṗ until it ends on the border.

use super::bernstein::{Basis, Course, Nine, course};
use super::borders::{Border, Of, Span, borders, of_contact, spans};
use super::equations::Frozen;
use super::friction::Slip;
use super::problem::{Ask, Effort, Problem, Sink, Stretch};
use super::progress::{Samples, check, next_stop, within_budget};
use super::stepper::Stepper;
use super::train::{BranchStand, Law, Regime, Train};
use super::trouble;
use super::wave::Phase;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::instant;

/// Rounding of a border's value and of the coefficients made from it, in units of ε and its size.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// A place that moves by more than this, relative to the largest, has jumped: it is no rounding of a switch located.
const JUMP: f64 = 1e-9;

/// Looks at how contacts stand where places jump.
const LOOKS: usize = 20;

/// Where a border is crossed.
struct Crossing {
    border: Border,
    /// Share of the step.
    at: f64,
    /// How fast the border's value falls there, per step.
    fall: f64,
}

/// A machine on its way.
struct Way<'a> {
    train: &'a Train,
    basis: Basis,
    regime: Regime,
    spans: Vec<Span>,
    /// Branches that have switched at the present instant.
    entered: Vec<bool>,
    /// How often each branch has switched.
    switches: Vec<u64>,
    effort: Effort,
    t: f64,
    y: Vec<f64>,
}

/// Integrates a machine, locating its switches.
///
/// # Errors
/// Those of the steps; `NoConvergence` where switches follow each other without time passing.
pub fn run<S>(train: &Train, ask: &Ask, sink: &mut Sink, stepper: &mut S) -> Result<Effort, Error>
where
    S: for<'f> Stepper<Frozen<'f>>,
{
    check(ask, train.len())?;
    let mut samples = Samples::new(ask, sink);
    let (regime, y) = train.settled(ask.from, &ask.start)?;
    let mut way = Way {
        train,
        basis: Basis::new()?,
        spans: spans(train, ask.from, &y),
        regime,
        entered: vec![false; train.branches.len()],
        switches: vec![0; train.branches.len()],
        effort: Effort::default(),
        t: ask.from,
        y,
    };
    let mut sample = way.y.clone();
    while samples.due().is_some() && way.t < ask.to {
        let stop = next_stop(|t| train.next_break(t), way.t, ask.to);
        way.enter_stretch(stop)?;
        way.give(&mut samples, &mut sample)?;
        stepper.restart();
        let mut standing = 0;
        while way.t < stop && samples.due().is_some() {
            let (t, y) = (way.t, way.y.clone());
            let switched = way.step(stop, stepper)?;
            within_budget(ask, &way.effort, way.t)
                .map_err(|e| trouble::busiest(e, train, &way.switches))?;
            if way.t > t {
                let (before, span) = (way.t.next_down(), way.t - t);
                ask.follower.follow(Stretch {
                    from: t,
                    to: way.t,
                    grain: span,
                    regime: Some(&way.regime),
                    state: &mut |at, into| match at == way.t {
                        true => into.copy_from_slice(&way.y),
                        false => stepper.inside((at - t) / span, into),
                    },
                });
                samples.give_until(before, &mut sample, Some(&way.regime), |due, into| {
                    stepper.inside((due - t) / span, into);
                })?;
                way.entered.fill(false);
            }
            standing = match way.t - t > 64.0 * f64::EPSILON * t.abs() {
                true => 0,
                false => standing + 1,
            };
            if let Some(border) = switched {
                if standing > 20 + 4 * train.branches.len() {
                    return Err(way.chatters(border, y));
                }
                way.switch(border)?;
                stepper.restart();
            }
            if way.t < stop {
                way.give(&mut samples, &mut sample)?;
            }
        }
    }
    way.give(&mut samples, &mut sample)?;
    Ok(way.effort)
}

impl Way<'_> {
    /// Hands over what is due at the present instant, as everything stands from then on.
    fn give(&self, samples: &mut Samples, sample: &mut [f64]) -> Result<(), Error> {
        samples.give_until(self.t, sample, Some(&self.regime), |_, into| {
            into.copy_from_slice(&self.y);
        })
    }

    /// The pieces known beforehand, up to the next known break.
    fn enter_stretch(&mut self, stop: f64) -> Result<(), Error> {
        let middle = self.t + 0.5 * (stop - self.t);
        let train = self.train;
        let drives = train.drives.len();
        for (at, drive) in train.drives.iter().enumerate() {
            self.regime.pieces[at] = drive.signal.piece(middle) as u32;
        }
        for (at, branch) in train.branches.iter().enumerate() {
            let mut jumps = false;
            if let Some(e) = &branch.imposed {
                let piece = e.piece(middle) as u32;
                jumps |= piece != self.regime.pieces[drives + at];
                self.regime.pieces[drives + at] = piece;
            }
            if let (Some(wave), BranchStand::Contact(stand, old)) =
                (&branch.variation, self.regime.stands[at])
                && let Phase::Imposed { .. } = wave.phase
            {
                let piece = wave.shape.piece(wave.phase.at(middle, &[])) as u32;
                jumps |= piece != old;
                self.regime.stands[at] = BranchStand::Contact(stand, piece);
            }
            if let Some(Phase::Imposed { .. }) = branch.law.phase() {
                let piece = train.path_piece(at, middle, &[]);
                self.regime.pieces[train.path_at(at)] = piece;
            }
            if jumps {
                self.stand_anew(at);
            }
        }
        self.settle()
    }

    /// One step, to `stop` at most, and the border it ends on.
    fn step<S>(&mut self, stop: f64, stepper: &mut S) -> Result<Option<Border>, Error>
    where
        S: for<'f> Stepper<Frozen<'f>>,
    {
        let frozen = Frozen {
            train: self.train,
            regime: &self.regime,
        };
        let (t, y) = (self.t, &self.y);
        let mut effort = self.effort;
        let (mut reached, mut state) = stepper.step(&frozen, (t, y), stop, &mut effort)?;
        effort.steps += 1;
        let h = reached - t;
        let mut switched = None;
        if let Some(crossing) = self.crossing(t, h, stepper, &mut effort) {
            let rounding = 4.0 * f64::EPSILON * t.abs().max(reached.abs());
            let mut target = t + crossing.at * h;
            if target - t <= rounding {
                self.effort = effort;
                return Ok(Some(crossing.border));
            }
            let rate = crossing.fall / h;
            for _ in 0..4 {
                (reached, state) = stepper.step(&frozen, (t, y), target, &mut effort)?;
                switched = (reached == target).then_some(crossing.border);
                let (value, size) =
                    crossing
                        .border
                        .value(self.train, &self.regime, &self.spans, reached, &state);
                effort.evaluations += 1;
                let change = value / rate;
                let better = (target + change).min(stop);
                let near = value.abs() <= 8.0 * f64::EPSILON * size || change.abs() <= rounding;
                if switched.is_none() || near || !(better > t + rounding && change.abs() < 0.1 * h)
                {
                    break;
                }
                target = better;
            }
        }
        self.effort = effort;
        (self.t, self.y) = (reached, state);
        Ok(switched)
    }

    /// The first border that the last step crosses.
    fn crossing<S>(&self, t: f64, h: f64, stepper: &S, effort: &mut Effort) -> Option<Crossing>
    where
        S: for<'f> Stepper<Frozen<'f>>,
    {
        let all = borders(self.train, &self.regime, &self.spans);
        if all.is_empty() {
            return None;
        }
        let mut first: Option<Crossing> = None;
        let states: Vec<Vec<f64>> = self
            .basis
            .points
            .iter()
            .map(|&theta| {
                let mut y = self.y.clone();
                if theta > 0.0 {
                    stepper.inside(theta, &mut y);
                }
                y
            })
            .collect();
        effort.evaluations += all.len() as u64;
        for border in all {
            let mut size: f64 = 0.0;
            let values: Nine = std::array::from_fn(|j| {
                let u = t + self.basis.points[j] * h;
                let (value, of) =
                    border.value(self.train, &self.regime, &self.spans, u, &states[j]);
                size = size.max(of);
                value
            });
            let b = self.basis.coefficients(&values);
            let steepest = b
                .windows(2)
                .map(|p| (p[1] - p[0]).abs())
                .fold(0.0, f64::max)
                * 8.0
                / h;
            let noise = ROUNDING * size + 8.0 * f64::EPSILON * t.abs() * steepest;
            match course(&b, noise, self.entered[border.branch(&self.spans)]) {
                Course::Clear => {}
                Course::Grazed => effort.grazed += 1,
                Course::Crossed(at, fall) => {
                    if first.as_ref().is_none_or(|f| at < f.at) {
                        first = Some(Crossing { border, at, fall });
                    }
                }
            }
        }
        first
    }

    /// Goes to the other side of a border.
    fn switch(&mut self, border: Border) -> Result<(), Error> {
        let n = self.train.n();
        let branch = border.branch(&self.spans);
        self.entered[branch] = true;
        self.switches[branch] += 1;
        self.effort.events += 1;
        match border {
            Border::Contact(_, which) => {
                let beyond = of_contact(
                    self.train,
                    &self.regime,
                    branch,
                    which,
                    self.t,
                    &self.y[..n],
                );
                if let (Some((_, stand)), BranchStand::Contact(_, piece)) =
                    (beyond, self.regime.stands[branch])
                {
                    self.regime.stands[branch] = BranchStand::Contact(stand, piece);
                }
            }
            Border::Rest(_) => {
                self.regime.stands[branch] = BranchStand::Friction(Slip::Stick);
                self.stop();
            }
            Border::Loose(_, slip) => {
                self.regime.stands[branch] = BranchStand::Friction(slip);
            }
            Border::Piece(span, up) => {
                self.effort.events -= 1;
                self.switches[branch] -= 1;
                self.spans[span].step(self.train, up);
                let span = self.spans[span];
                match (span.of, self.regime.stands[branch]) {
                    (Of::Stiffness, BranchStand::Contact(stand, _)) => {
                        self.regime.stands[branch] = BranchStand::Contact(stand, span.piece());
                        self.stand_anew(branch);
                    }
                    (Of::Path, _) => {
                        let at = self.train.path_at(branch);
                        self.regime.pieces[at] = span.piece();
                    }
                    _ => {}
                }
            }
        }
        self.settle()
    }

    /// How a contact stands after its stiffness or its e has jumped.
    fn stand_anew(&mut self, branch: usize) {
        let n = self.train.n();
        let b = &self.train.branches[branch];
        let (q, v) = (&self.y[..n], &self.y[n..2 * n]);
        if let (Law::Contact(contact), BranchStand::Contact(stand, piece)) =
            (&b.law, self.regime.stands[branch])
        {
            let imposed = self.train.imposed_piece(&self.regime, branch);
            let (delta, rate) = b.deflection(self.t, q, v, imposed);
            let anew = contact.stand(delta, rate, b.factor(self.t, q, piece).0);
            self.effort.events += u64::from(anew != stand);
            self.regime.stands[branch] = BranchStand::Contact(anew, piece);
        }
    }

    /// Lets overloaded pairs slide, and what has no inertia take its place.
    fn settle(&mut self) -> Result<(), Error> {
        let before = self.regime.sticking().len();
        self.train.let_slip(&mut self.regime, self.t, &self.y);
        let after = self.regime.sticking().len();
        self.effort.events += (before - after) as u64;
        if self.train.has_light() {
            self.place_light()?;
        }
        Ok(())
    }

    /// Where places jump, contacts may stand otherwise there.
    fn place_light(&mut self) -> Result<(), Error> {
        let n = self.train.n();
        for _ in 0..LOOKS {
            let y = self.train.consistent(&self.regime, self.t, &self.y)?;
            let size = y[..n].iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let places = y[..n].iter().zip(&self.y[..n]);
            let jumps = places.fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) > JUMP * size;
            self.y = y;
            if !jumps {
                break;
            }
            for branch in 0..self.train.branches.len() {
                self.stand_anew(branch);
            }
        }
        Ok(())
    }

    /// Takes the last rounding of a rate from pairs that have come to rest: `v ← v − M⁻¹Wᵀ(W M⁻¹Wᵀ)⁻¹ (W v − ė)`.
    fn stop(&mut self) {
        let n = self.train.n();
        let v = self.y[n..2 * n].to_vec();
        let sticking = self.regime.sticking();
        let momentum: Vec<f64> = self
            .train
            .momentum(&v)
            .iter()
            .map(|p| p * (1.0 + self.train.drag))
            .collect();
        let imposed = |branch: usize| {
            let piece = self.train.imposed_piece(&self.regime, branch) as usize;
            let e = self.train.branches[branch].imposed.as_ref();
            e.map_or(0.0, |e| e.slope(self.t, piece))
        };
        let held = self.train.reactions(&sticking, &momentum, &v, imposed);
        let mut change = vec![0.0; n];
        for (&at, held) in sticking.iter().zip(held) {
            let direction = &self.train.branches[at].direction;
            direction.scaled().for_each(|(i, a)| change[i] += a * held);
        }
        self.train.accelerate(&mut change);
        for (v, change) in self.y[n..2 * n].iter_mut().zip(change) {
            *v -= change;
        }
    }

    fn chatters(&self, border: Border, y: Vec<f64>) -> Error {
        let name = &self.train.branches[border.branch(&self.spans)].name;
        let (_, size) = border.value(self.train, &self.regime, &self.spans, self.t, &y);
        Error::new(
            Code::NoConvergence,
            format!(
                "branch {name} switches to and fro at t = {} without time passing (values of size {size:.1e})",
                instant(self.t)
            ),
        )
        .hint("give it damping, or take a method without events")
    }
}
