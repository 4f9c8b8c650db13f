//! Piecewise linear models with periodic coefficients, `M q̈ + C q̇ + K(t) q = f(t)`.
//!
//! In each stand the equations are linear with periodic coefficients. Their fundamental solutions and the answer to the loads are
//! tabulated once over the pieces of a period, as Taylor polynomials; a run then combines them and looks for switches
//! (Floquet's theorem does the rest: Coddington and Levinson 1955, ch. 3, th. 5.1).

use std::ops::ControlFlow;

use super::{IntegrationMethod, MethodFamily, StepControl};
use crate::base::error::Error;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::problem::{
    DenseOutput, IntegrationOptions, IntegrationStats, OdeProblem, SampleSink,
};
use crate::motion::progress::{check_budget, check_options};

pub mod applicability;

pub mod grid;

pub mod scale;

pub mod series_solution;

pub mod fundamental;

pub mod solution_cache;

pub mod run;

use run::PeriodicRun;
use solution_cache::SolutionCache;

/// Registry entry of the method.
pub const METHOD: IntegrationMethod = IntegrationMethod {
    name: "periodic",
    title: "tabulated fundamental solutions of a machine whose stiffness and loads repeat in time",
    step_control: StepControl::Exact,
    order: None,
    family: MethodFamily::Propagation,
    bound: None,
    locates_events: true,
    unsupported_reason,
    run,
};

/// Why a machine is not for it.
fn unsupported_reason(model: &DynamicModel) -> Option<String> {
    SolutionCache::new(model, 0.0)
        .err()
        .map(|error| error.message)
}

fn run(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    check_options(options, model.len())?;
    let mut walk = PeriodicRun::new(model, options.from, &options.initial_state)?;
    let end = walk.cache.grid.instant(options.to - options.from);
    let mut y = vec![0.0; model.len()];
    let mut sample = 0;
    let instant = |walk: &PeriodicRun, sample: usize| {
        walk.cache.grid.instant(options.time(sample) - options.from)
    };
    let mut next = instant(&walk, sample);
    loop {
        let segment = walk.next_segment(end);
        let last = segment.limit.is_none() && segment.to >= walk.position_of(end);
        if walk.stats.steps.is_multiple_of(16) {
            if options.cancel.should_stop() {
                return Ok(finished(walk));
            }
            check_budget(options, &walk.stats, options.from + walk.elapsed(-1.0))?;
        }
        if options.observer.is_set() {
            let (from, to) = (walk.elapsed(walk.position()), walk.elapsed(segment.to));
            options.observer.observe(DenseOutput {
                from: options.from + from,
                to: options.from + to,
                time_scale: to - from,
                regime: Some(&walk.full_regime()),
                state: &mut |t, y| {
                    let instant = walk.cache.grid.instant(t - options.from);
                    let place = walk.position_of(instant);
                    walk.value(place.clamp(walk.position(), segment.to), y);
                },
            });
        }
        while sample <= options.samples {
            let place = walk.position_of(next);
            if place > segment.to && !(last && sample == options.samples) {
                break;
            }
            walk.value(place, &mut y);
            if let ControlFlow::Break(()) = sink(options.time(sample), &y, None) {
                return Ok(finished(walk));
            }
            sample += 1;
            next = instant(&walk, sample.min(options.samples));
        }
        if last {
            return Ok(finished(walk));
        }
        walk.advance(segment)?;
    }
}

fn finished(walk: PeriodicRun) -> IntegrationStats {
    IntegrationStats {
        regimes: walk.cache.regimes as u64,
        ..walk.stats
    }
}
