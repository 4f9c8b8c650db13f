//! Machines whose stiffness and loads repeat in time: `M q̈ + C q̇ + K(t) q = f(t)`, `K(t + T) = K(t)`, in each stand of the contacts.
//!
//! In each stand the equations are linear with periodic coefficients. Their fundamental solutions and the answer to the loads are
//! tabulated once over the pieces of a period, as Taylor polynomials; a run then combines them and looks for switches
//! (Floquet's theorem does the rest: Coddington and Levinson 1955, ch. 3, th. 5.1).

use std::ops::ControlFlow;

use super::{Kin, Ladder, Method};
use crate::base::error::Error;
use crate::motion::problem::{Ask, Effort, Problem, Sink, Stretch};
use crate::motion::progress::{check, within_budget};
use crate::motion::train::Train;

/// What it does not take.
pub mod foreign;

/// The common period and its pieces.
pub mod grid;

/// Units of the states.
pub mod scale;

/// Solutions over one piece.
pub mod table;

/// What a machine does by itself over a piece.
pub mod free;

/// All of them.
pub mod tables;

/// From switch to switch.
pub mod walk;

use tables::Tables;
use walk::Walk;

/// Its row.
pub const METHOD: Method = Method {
    name: "periodic",
    title: "tabulated fundamental solutions of a machine whose stiffness and loads repeat in time",
    ladder: Ladder::Exact,
    order: None,
    kin: Kin::Propagation,
    bound: None,
    locates_events: true,
    refuses,
    run,
};

/// Why a machine is not for it.
fn refuses(train: &Train) -> Option<String> {
    Tables::new(train, 0.0).err().map(|error| error.message)
}

fn run(train: &Train, ask: &Ask, sink: &mut Sink) -> Result<Effort, Error> {
    check(ask, train.len())?;
    let mut walk = Walk::new(train, ask.from, &ask.start)?;
    let end = walk.tables.grid.instant(ask.to - ask.from);
    let mut y = vec![0.0; train.len()];
    let mut sample = 0;
    let instant =
        |walk: &Walk, sample: usize| walk.tables.grid.instant(ask.time(sample) - ask.from);
    let mut next = instant(&walk, sample);
    loop {
        let leg = walk.leg(end);
        let last = leg.limit.is_none() && leg.to >= walk.place_of(end);
        if walk.effort.steps.is_multiple_of(16) {
            if ask.stop.is_due() {
                return Ok(finished(walk));
            }
            within_budget(ask, &walk.effort, ask.from + walk.elapsed(-1.0))?;
        }
        if ask.follower.is_there() {
            let (from, to) = (walk.elapsed(walk.place()), walk.elapsed(leg.to));
            ask.follower.follow(Stretch {
                from: ask.from + from,
                to: ask.from + to,
                grain: to - from,
                regime: Some(&walk.whole_regime()),
                state: &mut |t, y| {
                    let instant = walk.tables.grid.instant(t - ask.from);
                    let place = walk.place_of(instant);
                    walk.value(place.clamp(walk.place(), leg.to), y);
                },
            });
        }
        while sample <= ask.samples {
            let place = walk.place_of(next);
            if place > leg.to && !(last && sample == ask.samples) {
                break;
            }
            walk.value(place, &mut y);
            if let ControlFlow::Break(()) = sink(ask.time(sample), &y, None) {
                return Ok(finished(walk));
            }
            sample += 1;
            next = instant(&walk, sample.min(ask.samples));
        }
        if last {
            return Ok(finished(walk));
        }
        walk.pass(leg)?;
    }
}

fn finished(walk: Walk) -> Effort {
    Effort {
        machines: walk.tables.machines as u64,
        ..walk.effort
    }
}
