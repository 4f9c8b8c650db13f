//! Runs a motion and keeps what was asked of it.

use std::ops::ControlFlow;
use std::time::Instant;

use super::choice::Choice;
use super::fineness::{Coarse, Fineness};
use super::reading::{Reader, Reading};
use super::scene::MotionScene;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::base::units::instant;
use crate::motion::meter::{Balance, Limit, Meter, READINGS};
use crate::motion::problem::{Ask, Effort, Follower};
use crate::motion::progress::too_long;
use crate::motion::trouble;

/// The answer to a study of motion.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Instants, s; none where no history is kept.
    pub time: Vec<f64>,
    /// Values of each output, SI; none where no history is kept.
    pub values: Vec<Vec<f64>>,
    /// Extremes and means of each output.
    pub readings: Vec<Option<Reading>>,
    /// The output that its samples follow least, where too few of them lie in a period to read extremes off.
    pub coarse: Option<Coarse>,
    /// How far it came, s.
    pub reached: f64,
    /// What it cost.
    pub effort: Effort,
    /// Seconds.
    pub seconds: f64,
    /// The energy balance, where asked for.
    pub balance: Option<Balance>,
    /// It was stopped before its end.
    pub interrupted: bool,
}

/// What a scene asks of a method.
pub fn ask(scene: &MotionScene, choice: &Choice, samples: usize, stop: &Stop) -> Ask {
    Ask {
        from: 0.0,
        to: scene.until,
        start: scene.start.clone(),
        samples,
        effort: choice.wanted,
        budget: u64::MAX,
        stop: stop.allowing(scene.allowed),
        follower: Follower::default(),
    }
}

/// Integrates and keeps the history. `stop` ends the run early; what was finished is whole.
///
/// # Errors
/// Those of the method.
pub fn run(
    scene: &MotionScene,
    choice: &Choice,
    energy: bool,
    stop: &Stop,
) -> Result<Motion, Error> {
    watched(scene, choice, energy, stop, (true, &mut |_, _| Ok(())))
}

/// What looks on while a motion runs: at an instant with the state, at the outputs.
pub type Watch<'a> = dyn FnMut((f64, &[f64]), &[f64]) -> Result<(), Error> + 'a;

/// The same under eyes that see every instant, its history kept or not.
///
/// # Errors
/// Those of the method, and of those that look on.
pub fn watched(
    scene: &MotionScene,
    choice: &Choice,
    energy: bool,
    stop: &Stop,
    (keep, watch): (bool, &mut Watch),
) -> Result<Motion, Error> {
    let train = &scene.moving.train;
    let mut ask = ask(scene, choice, scene.samples, stop);
    let meter = energy.then(|| {
        let limit = Limit {
            readings: READINGS,
            foresees: false,
            stop: stop.clone(),
        };
        let known = scene.moving.prescribed.as_ref();
        let (meter, follower) = Meter::new(train, known, [ask.from, ask.to], limit);
        ask.follower = follower;
        meter
    });
    let (mut time, mut values) = (Vec::new(), vec![Vec::new(); scene.outputs.list.len()]);
    let mut readers = vec![Reader::default(); scene.outputs.list.len()];
    let mut fineness = Fineness::new(scene);
    let (mut count, mut reached, mut refused) = (0, 0.0, None);
    let start = Instant::now();
    let effort = (choice.method.run)(train, &ask, &mut |t, y, regime| {
        let now = scene.outputs.at(train, regime, t, y);
        if let Some(at) = now.iter().position(|value| !value.is_finite()) {
            refused = Some(beyond_numbers(&scene.outputs.list[at].name, now[at], t));
            return ControlFlow::Break(());
        }
        for (reader, value) in readers.iter_mut().zip(&now) {
            reader.push(t, *value);
        }
        fineness.look(scene, (t, y), regime, &now);
        if keep {
            time.push(t);
            for (list, value) in values.iter_mut().zip(&now) {
                list.push(*value);
            }
        }
        reached = t;
        refused = watch((t, y), &now).err();
        count += 1;
        // Where nothing switches, samples alone take time.
        if count % LOOK == 0 && refused.is_none() {
            let foreseen = ask.stop.foresees(t / ask.to);
            refused = foreseen.map(|foreseen| too_long(&ask, foreseen, t));
        }
        match refused {
            None => ControlFlow::Continue(()),
            Some(_) => ControlFlow::Break(()),
        }
    });
    let effort = refused
        .map_or(effort, Err)
        .map_err(|e| trouble::swiftest(e, train))?;
    let seconds = start.elapsed().as_secs_f64();
    let balance = meter.map(|meter| meter.borrow().balance());
    Ok(Motion {
        time,
        values,
        readings: readers.iter().map(Reader::reading).collect(),
        coarse: fineness.coarsest(FEWEST),
        reached,
        effort,
        seconds,
        balance,
        interrupted: count <= ask.samples,
    })
}

fn beyond_numbers(output: &str, value: f64, t: f64) -> Error {
    let message = format!("{output} is {value} at t = {}", instant(t));
    Error::new(Code::Overflow, message).hint(
        "look at the sizes of loads, stiffness, inertia and the start, and at how long it runs",
    )
}

/// Samples in a period below which extremes may be a fifth short, cos(π/5).
pub const FEWEST: f64 = 5.0;

/// Samples between two looks at how long the whole would take.
const LOOK: usize = 1024;
