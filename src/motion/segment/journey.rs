//! A run from switch to switch: regimes, their machines, known times, samples.

use super::clock::{Clock, Tick};
use super::flight::{BLOCK, Flight};
use super::instant::Instant;
use super::machine::Machine;
use super::met::{Met, has_a_phase};
use super::search::{Outcome, Reached, Search};
use super::shared::Shared;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::instant;
use crate::motion::contact::Stand;
use crate::motion::friction::Slip;
use crate::motion::problem::{Ask, Effort, Sink, Stretch};
use crate::motion::progress::within_budget;
use crate::motion::train::{BranchStand, Law, Regime, Train};
use crate::motion::trouble;

/// Switches within a few rounding errors of one instant beyond which they will not end.
const CHATTER: u32 = 200;

/// Samples in one segment from which on they are reached by equal strides.
const MANY: f64 = 8.0;

/// Segments between two looks at whether the run is to end.
const LOOK: u64 = 16;

/// Runs a machine that is linear between switches; the machines of the regimes it meets are kept while they fill `room`, in bytes.
///
/// # Errors
/// A machine that is not; no convergence; a budget spent; switches that pile up at an instant.
pub fn run(train: &Train, ask: &Ask, room: usize, sink: &mut Sink) -> Result<Effort, Error> {
    let span = ask.to - ask.from;
    let driven = train.harmonics().fold(0.0, f64::max);
    has_a_phase("the fastest that acts", driven * span, span)?;
    let shared = Shared::new(train, span)?;
    let mut clock = Clock::new(train, ask.from)?;
    let mut regime = train.regime(ask.from, &ask.start);
    for (branch, piece) in clock.pieces() {
        if let BranchStand::Contact(stand, _) = regime.stands[branch] {
            regime.stands[branch] = BranchStand::Contact(stand, piece);
        }
    }
    train.let_slip(&mut regime, ask.from, &ask.start);
    let mut journey = Journey {
        shared: &shared,
        ask,
        now: Instant::new(ask.from),
        y: ask.start.clone(),
        regime,
        effort: Effort::default(),
        sample: 0,
        due: ask.from,
        busy: vec![0; train.branches.len()],
        crowd: (ask.from, 0),
    };
    let mut met = Met::new(train, room);
    let mut flight = Flight::default();
    let mut search = Search::default();
    let mut next = vec![0.0; ask.start.len()];
    let mut ticks = Vec::new();
    let mut crossed: Option<(usize, usize)> = None;
    loop {
        if journey.effort.steps.is_multiple_of(LOOK) {
            if ask.stop.is_due() {
                return Ok(journey.effort);
            }
            within_budget(ask, &journey.effort, journey.now.high)
                .map_err(|e| trouble::busiest(e, train, &journey.busy))?;
        }
        crossed = met.make_room(crossed);
        let place = met.place(&shared, &journey.regime.stands)?;
        journey.effort.machines = met.made();
        journey.effort.steps += 1;
        met.machine_mut(place)
            .take_up(&shared.inputs, &journey.regime.pieces);
        let machine = met.machine(place);
        let known = clock.next(&journey.regime.pieces, |branch| journey.heeds(branch));
        let end = known.min(ask.to);
        let span = journey.now.until(end).max(0.0);
        let from = crossed.map(|(machine, border)| &met.machine(machine).borders[border]);
        flight.start(
            &shared,
            machine,
            (journey.now, &journey.regime.pieces),
            &journey.y,
            span,
            from,
        );
        let (machine, ladder) = met.with_ladder(place);
        let effort = (&mut journey.effort, ask);
        let ahead = (journey.now.high, span);
        let found = search
            .next(machine, ladder, &mut flight, ahead, effort)
            .map_err(|e| trouble::busiest(e, train, &journey.busy))?;
        let reached = match found {
            Outcome::Clear => None,
            Outcome::Reached(reached) => Some(reached),
            Outcome::Ended => return Ok(journey.effort),
        };
        let tau = reached.map_or(span, |reached| reached.tau);
        let last = reached.is_none() && end >= ask.to;
        if !last {
            flight.go(machine, tau);
            flight.state(machine, &mut next);
        }
        if ask.follower.is_there() {
            let now = journey.now;
            ask.follower.follow(Stretch {
                from: now.high,
                to: now.high + tau,
                grain: machine.linear.parts.grain(),
                regime: Some(&journey.regime),
                state: &mut |t, y| match now.until(t) {
                    ahead if ahead > 0.0 => {
                        flight.go(machine, ahead.min(tau));
                        flight.state(machine, y);
                    }
                    _ => y.copy_from_slice(&journey.y),
                },
            });
        }
        if journey.deliver(machine, &mut flight, (tau, last), sink) || last {
            return Ok(journey.effort);
        }
        if tau > 0.0 {
            std::mem::swap(&mut journey.y, &mut next);
        }
        match reached {
            Some(reached) => {
                journey.now = journey.now.after(tau);
                journey.cross(machine, reached, &mut clock)?;
                crossed = Some((place, reached.border));
            }
            None => {
                journey.now = Instant::new(end);
                clock.tick(&journey.regime.pieces, end, &mut ticks);
                journey.tick(&ticks);
                crossed = None;
            }
        }
        if journey.y.iter().any(|y| !y.is_finite()) {
            let message = format!(
                "the motion leaves the range of numbers at t = {}",
                instant(end)
            );
            return Err(
                Error::new(Code::Overflow, message).hint("look for a machine that is not stable")
            );
        }
    }
}

struct Journey<'a> {
    shared: &'a Shared<'a>,
    ask: &'a Ask,
    now: Instant,
    y: Vec<f64>,
    regime: Regime,
    effort: Effort,
    /// The next sample, and a time before which it is not due.
    sample: usize,
    due: f64,
    /// Events of every branch.
    busy: Vec<u64>,
    /// An instant, and how many events came within rounding of it.
    crowd: (f64, u32),
}

impl Journey<'_> {
    /// Whether the wave of a branch counts as it stands.
    fn heeds(&self, branch: usize) -> bool {
        let stand = self.regime.stands[branch];
        !matches!(stand, BranchStand::Contact(Stand::Open, _))
    }

    /// Delivers the samples up to τ; true where the run is to end early.
    fn deliver(
        &mut self,
        machine: &Machine,
        flight: &mut Flight,
        (tau, last): (f64, bool),
        sink: &mut Sink,
    ) -> bool {
        if self.now.until(self.due) >= tau && !last {
            return false;
        }
        let usual = (self.ask.to - self.ask.from) / self.ask.samples.max(1) as f64;
        let stride = (tau > MANY * usual).then(|| machine.linear.parts.stride(usual));
        let mut times = [0.0; BLOCK];
        while self.sample <= self.ask.samples {
            if self.ask.stop.is_due() {
                return true;
            }
            let t = self.ask.time(self.sample);
            let ahead = self.now.until(t).max(0.0);
            if ahead >= tau && !last {
                self.due = t;
                return false;
            }
            if ahead == 0.0 {
                self.sample += 1;
                if sink(t, &self.y, Some(&self.regime)).is_break() {
                    return true;
                }
                continue;
            }
            let mut count = 0;
            while count < BLOCK && self.sample + count <= self.ask.samples {
                let ahead = self.now.until(self.ask.time(self.sample + count));
                if ahead >= tau && !last {
                    break;
                }
                times[count] = ahead;
                count += 1;
            }
            let (ask, first) = (self.ask, self.sample);
            self.sample += count;
            let regime = Some(&self.regime);
            let mut give = |at: usize, y: &[f64]| sink(ask.time(first + at), y, regime).is_break();
            if flight.states(machine, stride.as_ref(), &times[..count], &mut give) {
                return true;
            }
        }
        false
    }

    /// A border was reached: what stands beyond it.
    fn cross(
        &mut self,
        machine: &Machine,
        reached: Reached,
        clock: &mut Clock,
    ) -> Result<(), Error> {
        let border = &machine.borders[reached.border];
        self.effort.events += 1;
        self.busy[border.branch] += 1;
        // While it stood open its wave went on unheeded.
        let piece = clock.piece(border.branch, self.now.high);
        self.regime.stands[border.branch] = match (border.to, piece) {
            (BranchStand::Contact(stand, _), Some(piece)) => BranchStand::Contact(stand, piece),
            (to, _) => to,
        };
        let near = 64.0 * f64::EPSILON * self.now.high.abs().max(self.shared.span);
        self.crowd = match (self.now.high - self.crowd.0).abs() <= near {
            true => (self.crowd.0, self.crowd.1 + 1),
            false => (self.now.high, 0),
        };
        if self.crowd.1 > CHATTER {
            let name = &self.shared.train.branches[border.branch].name;
            let message = format!(
                "`{name}` switches without end at t = {}",
                instant(self.now.high)
            );
            return Err(Error::new(Code::NoConvergence, message)
                .hint("give it some damping, or take a method that does not locate switches"));
        }
        self.shared
            .train
            .let_slip(&mut self.regime, self.now.high, &self.y);
        Ok(())
    }

    /// Known times were passed: lines, waves, and what stands otherwise since.
    fn tick(&mut self, ticks: &[Tick]) {
        let train = self.shared.train;
        let turned = |tick: &Tick| matches!(tick, Tick::Piece(..));
        let before = match ticks.iter().any(turned) {
            true => self.regime.pieces.clone(),
            false => Vec::new(),
        };
        for tick in ticks {
            match *tick {
                Tick::Piece(at, piece) => self.regime.pieces[at] = piece,
                Tick::Wave(branch, piece) => {
                    if let BranchStand::Contact(stand, _) = self.regime.stands[branch] {
                        self.regime.stands[branch] = BranchStand::Contact(stand, piece);
                    }
                }
            }
        }
        for tick in ticks {
            let branch = match *tick {
                Tick::Piece(at, _) => at.checked_sub(train.drives.len()),
                Tick::Wave(branch, _) => Some(branch),
            };
            if let Some(branch) = branch {
                self.stand_again(branch, &before);
            }
        }
        train.let_slip(&mut self.regime, self.now.high, &self.y);
    }

    /// How a branch stands whose wave or imposed motion jumped.
    fn stand_again(&mut self, branch: usize, before: &[u32]) {
        let train = self.shared.train;
        let (n, t) = (train.n(), self.now.high);
        let b = &train.branches[branch];
        let (q, v) = (&self.y[..n], &self.y[n..2 * n]);
        let piece = train.imposed_piece(&self.regime, branch);
        let (delta, rate) = b.deflection(t, q, v, piece);
        const ROUNDED: f64 = 64.0 * f64::EPSILON;
        let next = match (&b.law, self.regime.stands[branch]) {
            (Law::Contact(contact), BranchStand::Contact(stand, of_wave)) => {
                let factor = b.factor(t, q, of_wave).0;
                let holds = contact.borders(stand, factor).iter().all(|(border, _)| {
                    let size = border.constant.abs()
                        + (border.deflection * delta).abs()
                        + (border.rate * rate).abs();
                    border.at(delta, rate) >= -ROUNDED * size
                });
                match holds {
                    true => return,
                    false => BranchStand::Contact(contact.stand(delta, rate, factor), of_wave),
                }
            }
            (Law::Friction(_), BranchStand::Friction(_)) => {
                let was = before[train.drives.len() + branch];
                let slope = |piece: u32| {
                    b.imposed
                        .as_ref()
                        .map_or(0.0, |e| e.slope(t, piece as usize))
                };
                if slope(was) == slope(piece) {
                    return;
                }
                BranchStand::Friction(match rate {
                    rate if rate > 0.0 => Slip::Forward,
                    rate if rate < 0.0 => Slip::Backward,
                    _ => Slip::Stick,
                })
            }
            _ => return,
        };
        self.effort.events += 1;
        self.busy[branch] += 1;
        self.regime.stands[branch] = next;
    }
}
