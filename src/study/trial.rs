//! One run of a method on a scene: the outputs it gives, given up when it takes too long.

use std::ops::ControlFlow;
use std::time::Instant;

use super::elastic_sizes::ElasticSizes;
use super::watch::interrupted;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::base::units;
use crate::motion::methods::{Ladder, Method};
use crate::motion::problem::{Ask, Effort, Follower, Wanted};
use crate::plan::motion::scene::MotionScene;

/// The tightest tolerance a method is asked for: below, rounding decides.
pub const TIGHTEST: f64 = 1e-13;

/// Tolerances of the ladder.
const TOLERANCES: [f64; 6] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, TIGHTEST];

/// Divisions of the time by fixed-step methods.
const STEPS: [f64; 4] = [1e3, 1e4, 1e5, 1e6];

/// A run that came to its end.
pub struct Trial {
    /// Of each output, at every sample.
    pub values: Vec<Vec<f64>>,
    /// The largest size of each state at any sample, without rigid motion where anything deforms.
    pub sizes: Vec<f64>,
    /// What it cost.
    pub effort: Effort,
    /// How long it took, s.
    pub seconds: f64,
}

/// Runs a method, for so many seconds at most; what is seen to take longer is not begun, or given up.
///
/// # Errors
/// Those of the method; `Hopeless` where patience runs out, `Interrupted` where somebody asks for the end.
pub fn integrate(
    scene: &MotionScene,
    method: &Method,
    wanted: Wanted,
    start: &[f64],
    (stop, patience): (&Stop, f64),
) -> Result<Trial, Error> {
    let train = &scene.moving.train;
    let ask = Ask {
        from: 0.0,
        to: scene.until,
        start: start.to_vec(),
        samples: scene.samples,
        effort: wanted,
        budget: u64::MAX,
        stop: stop.within(patience).allowing(patience),
        follower: Follower::default(),
    };
    let mut values = vec![Vec::with_capacity(scene.samples + 1); scene.outputs.list.len()];
    let mut sizes = ElasticSizes::new(train, &scene.moving.rigid);
    let (mut count, mut reached) = (0, 0.0);
    let begin = Instant::now();
    let effort = (method.run)(train, &ask, &mut |t, y, regime| {
        for (list, value) in values.iter_mut().zip(scene.outputs.at(train, regime, t, y)) {
            list.push(value);
        }
        sizes.note(y);
        (count, reached) = (count + 1, t);
        ControlFlow::Continue(())
    })?;
    if stop.is_raised() {
        return Err(interrupted());
    }
    if count <= scene.samples {
        let message = format!(
            "given up after {patience} s at t = {} of {}",
            units::seconds(reached),
            units::seconds(scene.until)
        );
        return Err(Error::new(Code::Hopeless, message));
    }
    Ok(Trial {
        values,
        sizes: sizes.sizes(),
        effort,
        seconds: begin.elapsed().as_secs_f64(),
    })
}

/// What a method is asked, the coarsest first.
pub fn ladder(scene: &MotionScene, method: &Method) -> Vec<Option<Wanted>> {
    match method.ladder {
        Ladder::Exact => vec![None],
        Ladder::Tolerance => TOLERANCES.map(|t| Some(Wanted::Tolerance(t))).to_vec(),
        Ladder::Step => STEPS.map(|n| Some(Wanted::Step(scene.until / n))).to_vec(),
    }
}

/// How many times as much the next rung of the ladder costs at most. Steps go by a root of the tolerance: that of the order, but
/// no more than the fourth, since errors are estimated with less.
pub fn growth(method: &Method) -> f64 {
    match method.ladder {
        Ladder::Step => 10.0,
        _ => 100.0f64.powf(1.0 / f64::from(method.order.unwrap_or(4).min(4))),
    }
}

/// The worst output's largest difference over all samples, each by its own largest size in the reference.
pub fn distance(values: &[Vec<f64>], reference: &[Vec<f64>]) -> f64 {
    let of = |(x, r): (&Vec<f64>, &Vec<f64>)| {
        let size = r.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let worst = x.iter().zip(r).fold(0.0f64, |m, (a, b)| {
            let d = (a - b).abs();
            if d.is_nan() { f64::INFINITY } else { m.max(d) }
        });
        if size > 0.0 { worst / size } else { worst }
    };
    values.iter().zip(reference).map(of).fold(0.0, f64::max)
}
