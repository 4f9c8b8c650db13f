//! The energy balance of a run: powers added up along the motion itself, stretch by stretch between switches and kinks.
//!
//! Each stretch is gone through in panels of Gauss's three points with Kronrod's four between them (Kronrod 1965; Piessens et al.,
//! QUADPACK, 1983, sec. 2.2.1); where the two rules differ by more than is allowed the panel is halved. What their sums differ by
//! over the run bounds by far what the better one is off by, so the balance says how well it is known.

use std::cell::RefCell;
use std::rc::Rc;

use super::energy::Powers;
use super::prescribed::Prescribed;
use super::problem::{Follower, Stretch};
use super::progress::{hopeless, inside};
use super::regime::{BranchStand, Regime};
use super::train::Train;
use super::wave::{Phase, Wave};
use crate::base::stop::Stop;

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
    /// The largest energy stored at any instant looked at.
    pub largest: f64,
    /// What the two rules differ by over the run.
    pub off: f64,
    /// Readings of the powers.
    pub readings: u64,
    /// Where adding up was given up, a share of the run; absent where it came to the end.
    pub given_up: Option<f64>,
}

impl Balance {
    /// What does not add up, as a share of the largest of all parts.
    pub fn gap(&self) -> f64 {
        self.share((self.after - self.before) - self.put_in + self.lost)
    }

    /// What the gap may be off by; absent where the powers were not added up to the end.
    pub fn doubt(&self) -> Option<f64> {
        match self.given_up {
            None => Some(self.share(self.off)),
            Some(_) => None,
        }
    }

    /// The largest of all parts, J.
    pub fn size(&self) -> f64 {
        self.largest.max(self.put_in.abs()).max(self.lost.abs())
    }

    fn share(&self, energy: f64) -> f64 {
        match self.size() {
            0.0 => 0.0,
            size => energy / size,
        }
    }
}

/// Kronrod's seven points from −1 to 1, with their weights and Gauss's.
const POINTS: [(f64, f64, f64); 7] = [
    (-0.960_491_268_708_020_3, 0.104_656_226_026_467_27, 0.0),
    (
        -0.774_596_669_241_483_4,
        0.268_488_089_868_333_44,
        5.0 / 9.0,
    ),
    (-0.434_243_749_346_802_6, 0.401_397_414_775_962_2, 0.0),
    (0.0, 0.450_916_538_658_474_1, 8.0 / 9.0),
    (0.434_243_749_346_802_6, 0.401_397_414_775_962_2, 0.0),
    (0.774_596_669_241_483_4, 0.268_488_089_868_333_44, 5.0 / 9.0),
    (0.960_491_268_708_020_3, 0.104_656_226_026_467_27, 0.0),
];

/// What two rules may differ by in a panel, as a share of the work done to and fro in it.
const OF_WORK: f64 = 1e-6;

/// And of the largest part of the balance, shared out over the run.
const OF_ALL: f64 = 1e-5;

/// A panel is not made shorter than this share of its stretch: a switch that the method stepped over lies in it.
const SHORTEST: f64 = 1e-6;

/// Readings of the powers after which adding up is given up: some seconds for twenty freedoms.
pub const READINGS: u64 = 3_000_000;

/// Where adding up ends.
pub struct Limit {
    /// After so many readings.
    pub readings: u64,
    /// Or before, where it would take far more.
    pub foresees: bool,
    /// Or once this is due.
    pub stop: Stop,
}

/// Adds up the powers of a run.
pub struct Meter {
    train: Train,
    /// Where motions are prescribed the whole machine is looked at, with the power that keeps them up.
    known: Option<Prescribed>,
    run: [f64; 2],
    limit: Limit,
    balance: Balance,
    /// What the two rules differ by so far, in what is put in and in what is lost.
    off: [f64; 2],
    last: Option<Place>,
}

/// The whole machine at an end of a stretch.
struct Place {
    /// Where the stretch began, s.
    from: f64,
    t: f64,
    state: Vec<f64>,
    regime: Regime,
}

/// What the two rules make of a panel.
#[derive(Default)]
struct Panel {
    put_in: f64,
    lost: f64,
    /// Of the sizes of both.
    work: f64,
    /// What they differ by.
    off: [f64; 2],
}

impl Meter {
    /// For a run of a machine from one instant to another, s; and what goes along with that run.
    pub fn new(
        train: &Train,
        known: Option<&Prescribed>,
        run: [f64; 2],
        limit: Limit,
    ) -> (Rc<RefCell<Meter>>, Follower) {
        let meter = Meter {
            train: train.clone(),
            known: known.cloned(),
            run,
            limit,
            balance: Balance::default(),
            off: [0.0; 2],
            last: None,
        };
        let meter = Rc::new(RefCell::new(meter));
        let along = Rc::clone(&meter);
        let follow = move |stretch: Stretch| {
            let mut meter = along.borrow_mut();
            let before = meter.balance.readings;
            meter.pass(stretch);
            meter.balance.readings - before
        };
        (meter, Follower::new(follow))
    }

    /// The balance so far.
    pub fn balance(&self) -> Balance {
        Balance {
            off: self.off[0].abs() + self.off[1].abs(),
            ..self.balance
        }
    }

    /// Adds up one more stretch.
    fn pass(&mut self, mut stretch: Stretch) {
        if self.balance.given_up.is_some() {
            return;
        }
        let (from, to) = (stretch.from, stretch.to);
        let mut y = vec![0.0; 2 * self.train.n() + self.train.inner()];
        let start = self.place(&mut stretch, from, &mut y);
        let stored = self.whole().stored(&start.regime, start.t, &start.state);
        match &self.last {
            None => self.balance.before = stored,
            Some(last) => self.balance.put_in += self.jumped(last, &start),
        }
        self.seen(stored);
        // Nor is one shorter than its instants can be told apart.
        let shortest = (SHORTEST * (to - from)).max(16.0 * f64::EPSILON * to.abs());
        let mut t = from;
        let mut length = stretch.grain.min(to - from).max(shortest);
        while t < to {
            let end = if t + 1.25 * length < to {
                t + length
            } else {
                to
            };
            let panel = self.panel(&mut stretch, [t, end], &mut y);
            let share = (end - t) / (self.run[1] - self.run[0]);
            let allowed = OF_WORK * panel.work + OF_ALL * share * self.balance.size();
            let off = panel.off[0].abs() + panel.off[1].abs();
            if off > allowed && end - t > shortest {
                length = 0.5 * (end - t);
            } else {
                self.balance.put_in += panel.put_in;
                self.balance.lost += panel.lost;
                self.off[0] += panel.off[0];
                self.off[1] += panel.off[1];
                t = end;
                if off < 0.02 * allowed {
                    length *= 2.0;
                }
            }
            let share = (t - self.run[0]) / (self.run[1] - self.run[0]);
            let (spent, allowed) = (self.balance.readings, self.limit.readings);
            if spent > allowed
                || self.limit.foresees && hopeless(spent, allowed, share)
                || self.limit.stop.is_due()
            {
                self.balance.given_up = Some(share);
                return;
            }
        }
        let end = self.place(&mut stretch, to, &mut y);
        // A method that locates nothing steps over jumps of stiffness.
        self.balance.put_in += self.stepped(&start.regime, &end);
        self.balance.after = self.whole().stored(&end.regime, end.t, &end.state);
        self.seen(self.balance.after);
        self.last = Some(end);
    }

    fn whole(&self) -> &Train {
        self.known.as_ref().map_or(&self.train, |k| &k.whole)
    }

    fn seen(&mut self, stored: f64) {
        self.balance.largest = self.balance.largest.max(stored.abs());
    }

    /// The whole machine at an instant of a stretch, and what its prescribed motions put in, W.
    fn look(&self, stretch: &mut Stretch, at: f64, y: &mut [f64]) -> (Place, f64) {
        // Nothing is looked up on the far sides of the kinks at its ends.
        let t = inside(at, stretch.from, stretch.to);
        (stretch.state)(at, y);
        let regime = self.train.stands(stretch.regime, t, y);
        let place = |state, regime| Place {
            from: stretch.from,
            t,
            state,
            regime,
        };
        match &self.known {
            None => (place(y.to_vec(), regime.into_owned()), 0.0),
            Some(known) => {
                let state = known.state(t, y);
                let power = known.power(&self.train, &regime, t, y);
                let whole = known.regime(&regime, t, &state);
                (place(state, whole), power)
            }
        }
    }

    fn place(&self, stretch: &mut Stretch, at: f64, y: &mut [f64]) -> Place {
        self.look(stretch, at, y).0
    }

    fn panel(&mut self, stretch: &mut Stretch, [from, to]: [f64; 2], y: &mut [f64]) -> Panel {
        let half = 0.5 * (to - from);
        let mut panel = Panel::default();
        let (mut put_in, mut lost) = (0.0, 0.0);
        for (x, kronrod, gauss) in POINTS {
            let (place, driven) = self.look(stretch, from + half * (1.0 + x), y);
            let Powers {
                put_in: given,
                lost: taken,
            } = self.whole().powers(&place.regime, place.t, &place.state);
            let given = given + driven;
            panel.put_in += half * kronrod * given;
            panel.lost += half * kronrod * taken;
            panel.work += half * kronrod * (given.abs() + taken.abs());
            put_in += half * gauss * given;
            lost += half * gauss * taken;
            if x == 0.0 {
                let stored = self.whole().stored(&place.regime, place.t, &place.state);
                self.seen(stored);
            }
        }
        self.balance.readings += POINTS.len() as u64;
        panel.off = [panel.put_in - put_in, panel.lost - lost];
        panel
    }

    /// What stiffness in steps over an angle put in up to a place, J, since it stood as in `before`. Its jumps turn nothing, so that
    /// the energy they bring comes from outside.
    fn stepped(&self, before: &Regime, now: &Place) -> f64 {
        let train = self.whole();
        let mut old = now.regime.clone();
        for (at, b) in train.branches.iter().enumerate() {
            let wave = b.variation.as_ref();
            let over_an_angle = |w: &Wave| w.phase.angle().is_some() && w.shape.is_steps();
            if let BranchStand::Contact(_, piece) = &mut old.stands[at]
                && let BranchStand::Contact(_, former) = before.stands[at]
                && wave.is_some_and(over_an_angle)
            {
                *piece = former;
            }
        }
        if old == now.regime {
            return 0.0;
        }
        train.stored(&now.regime, now.t, &now.state) - train.stored(&old, now.t, &now.state)
    }

    /// What was put in at the instant between two stretches, J: by stiffness or imposed e that jump of themselves, by stiffness in steps
    /// over an angle, and by prescribed speeds that do.
    fn jumped(&self, last: &Place, next: &Place) -> f64 {
        let train = self.whole();
        let jolts = self.known.as_ref();
        let jolts = jolts.map_or(0.0, |known| known.jolts(last.from, next.from))
            + self.stepped(&last.regime, next);
        let mut regime = last.regime.clone();
        let imposed = train.drives.len()..train.drives.len() + train.branches.len();
        regime.pieces[imposed.clone()].copy_from_slice(&next.regime.pieces[imposed]);
        for (at, b) in train.branches.iter().enumerate() {
            let wave = b.variation.as_ref();
            let of_itself = wave.is_some_and(|w| matches!(w.phase, Phase::Imposed { .. }));
            if let BranchStand::Contact(..) = regime.stands[at]
                && (of_itself || b.imposed.is_some())
            {
                regime.stands[at] = next.regime.stands[at];
            }
        }
        if regime == last.regime {
            return jolts;
        }
        let after = train.stored(&regime, next.t, &last.state);
        jolts + after - train.stored(&last.regime, last.t, &last.state)
    }
}
