//! Runs a motion and keeps what was asked of it.

use std::ops::ControlFlow;
use std::time::Instant;

use super::choice::Choice;
use super::cost::ALLOWED;
use super::reading::{Reader, Reading};
use super::scene::MotionScene;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::motion::energy::{Balance, Meter};
use crate::motion::problem::{Ask, Effort};
use crate::motion::progress::too_long;
use crate::motion::regime::Regime;
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
    /// How far it came, s.
    pub reached: f64,
    /// What it cost.
    pub effort: Effort,
    /// Seconds.
    pub seconds: f64,
    /// The energy balance, where asked for, and the same from half as many samples.
    pub balance: Option<[Balance; 2]>,
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
        stop: stop.allowing(ALLOWED),
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
    // Powers change faster than what is shown of them.
    let finer = if energy {
        FINER.max(LEAST.div_ceil(scene.samples))
    } else {
        1
    };
    let ask = ask(scene, choice, scene.samples * finer, stop);
    let (mut time, mut values) = (Vec::new(), vec![Vec::new(); scene.outputs.list.len()]);
    let mut readers = vec![Reader::default(); scene.outputs.list.len()];
    let mut meters = [Meter::default(), Meter::default()];
    let (mut count, mut reached, mut refused) = (0, 0.0, None);
    let start = Instant::now();
    let effort = (choice.method.run)(train, &ask, &mut |t, y, regime| {
        if energy {
            let meters = &mut meters[..if count % 2 == 0 { 2 } else { 1 }];
            book(meters, scene, regime, (t, y));
        }
        if count % finer == 0 {
            let now = scene.outputs.at(train, regime, t, y);
            for (reader, value) in readers.iter_mut().zip(&now) {
                reader.push(t, *value);
            }
            if keep {
                time.push(t);
                for (list, value) in values.iter_mut().zip(&now) {
                    list.push(*value);
                }
            }
            reached = t;
            refused = watch((t, y), &now).err();
        }
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
    let balance = energy.then(|| meters.map(Meter::balance));
    Ok(Motion {
        time,
        values,
        readings: readers.iter().map(Reader::reading).collect(),
        reached,
        effort,
        seconds,
        balance,
        interrupted: count <= ask.samples,
    })
}

/// Samples between two looks at how long the whole would take.
const LOOK: usize = 1024;

/// Samples of powers for each sample shown.
const FINER: usize = 4;

/// The least number of samples of powers.
const LEAST: usize = 20_000;

/// Books the energy of a state; where motions are prescribed, of the whole machine with the power that keeps them up.
fn book(meters: &mut [Meter], scene: &MotionScene, known: Option<&Regime>, (t, y): (f64, &[f64])) {
    let train = &scene.moving.train;
    let regime = train.stands(known, t, y);
    let Some(known) = &scene.moving.prescribed else {
        let samples = meters.iter_mut();
        samples.for_each(|m| m.sample(train, &regime, (t, y), 0.0));
        return;
    };
    let (state, power) = (known.state(t, y), known.power(train, &regime, t, y));
    let whole = known.regime(&regime, t, &state);
    for meter in meters {
        let jolts = meter.time().map_or(0.0, |from| known.jolts(from, t));
        meter.put_in(jolts);
        meter.sample(&known.whole, &whole, (t, &state), power);
    }
}
