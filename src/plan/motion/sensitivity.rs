//! How a motion amplifies a change of its start, and which digits of its readings hold: two runs compared.
//!
//! Beyond the instant at which both have parted the history is one of many; what holds there are its statistics.

use std::ops::ControlFlow;
use std::time::Instant;

use super::choice::Choice;
use super::reading::{Reader, Reading};
use super::run::ask;
use super::scene::MotionScene;
use super::statistics::{Statistics, block_error};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::base::units::duration;
use crate::motion::methods::Ladder;
use crate::motion::problem::Wanted;
use crate::motion::sensitivity::Deflections;

/// Share of the deflections by which the start is changed: far above rounding, far below what is known of any machine.
const CHANGE: f64 = 1e-9;

/// The largest share where the errors of the method are larger than [`CHANGE`].
const LARGEST_CHANGE: f64 = 1e-4;

/// The change is so many times the errors of the method.
const BEYOND_ERRORS: f64 = 10.0;

/// The share of the time after which the two runs differ by the errors of the method, not yet by their growth.
const EARLY: f64 = 1.0 / 200.0;

/// Both runs have parted where deflections differ by this share of their size: the growth ends there.
const PARTED: f64 = 0.1;

/// The second run of a method goes by so many times the tolerance.
const LOOSER: f64 = 10.0;

/// The second run of a method with a fixed step goes by so many times the step.
const SHORTER: f64 = 0.8;

/// A reading may be off by so many times what two runs differ by: the difference of one pair may be small by chance.
const CHANCE: f64 = 3.0;

/// Digits that a table shows.
const DIGITS: i32 = 4;

/// Samples compared of each output, at most.
const COMPARED: usize = 20_000;

/// The second run may take so many times the first, and [`GRACE`] seconds.
const PATIENCE: f64 = 4.0;
const GRACE: f64 = 1.0;

/// Parts of the time, at most, each with [`IN_WINDOW`] samples at least, that are predicted or not.
const WINDOWS: usize = 200;
const IN_WINDOW: usize = 20;

/// A sample has parted where it differs by this share of the range of the output: two digits no longer hold.
const APART: f64 = 0.01;

/// A part of the time is not predicted where more than this share of its samples has parted: fewer are jumps a little earlier or later.
const SHARE: f64 = 0.05;

/// What parts and meets again within less than this share of the rest of the time is predicted but for a while.
const LASTS: f64 = 0.1;

/// What is kept of a run to compare another with.
#[derive(Debug, Clone)]
pub struct Seen {
    deflections: Deflections,
    /// Of all samples one in so many.
    every: usize,
    count: usize,
    time: Vec<f64>,
    values: Vec<Vec<f64>>,
    readers: Vec<Reader>,
}

impl Seen {
    /// For the samples of a scene.
    pub fn new(scene: &MotionScene) -> Seen {
        let outputs = scene.outputs.list.len();
        Seen {
            deflections: Deflections::new(&scene.moving.train, scene.samples),
            every: scene.samples / COMPARED + 1,
            count: 0,
            time: Vec::new(),
            values: vec![Vec::new(); outputs],
            readers: vec![Reader::default(); outputs],
        }
    }

    /// Takes the next sample: instant and state, outputs.
    pub fn see(&mut self, scene: &MotionScene, (t, y): (f64, &[f64]), outputs: &[f64]) {
        self.deflections.see(&scene.moving.train, t, y);
        for (reader, value) in self.readers.iter_mut().zip(outputs) {
            reader.push(t, *value);
        }
        if self.count.is_multiple_of(self.every) {
            self.time.push(t);
            for (list, value) in self.values.iter_mut().zip(outputs) {
                list.push(*value);
            }
        }
        self.count += 1;
    }
}

/// How a motion amplifies a change of its start.
#[derive(Debug, Clone)]
pub struct Sensitivity {
    /// How many times as large the change becomes; absent where every digit shown holds and the method makes errors of its own, larger
    /// than what such a change leaves.
    pub factor: Option<f64>,
    /// Both runs parted, so that the factor is a lower bound.
    pub parted: bool,
    /// Share of the deflections by which the start was changed.
    pub change: f64,
    /// Of each output.
    pub outputs: Vec<Digits>,
    /// What the further runs took, s.
    pub seconds: f64,
}

/// What holds of an output.
#[derive(Debug, Clone)]
pub struct Digits {
    /// From here on its history cannot be predicted, s.
    pub until: Option<f64>,
    /// What its reading may be off by; absent where it is not predictable.
    pub end: Option<f64>,
    /// The least value.
    pub least: Option<f64>,
    /// The instant of it, s.
    pub least_at: Option<f64>,
    /// The greatest value.
    pub greatest: Option<f64>,
    /// The instant of it, s.
    pub greatest_at: Option<f64>,
    /// The mean.
    pub mean: f64,
    /// The root of the mean square about it.
    pub rms: f64,
    /// What holds of the second half of the time, where the history does not.
    pub second_half: Option<Statistics>,
    /// Four digits of every reading hold, by the range of the output.
    pub all_shown: bool,
}

impl Sensitivity {
    /// From here on the history of some output cannot be predicted, s.
    pub fn until(&self) -> Option<f64> {
        let all = self.outputs.iter().filter_map(|o| o.until);
        all.reduce(f64::min)
    }

    /// Every digit that a table shows holds.
    pub fn all_shown(&self) -> bool {
        self.outputs.iter().all(|o| o.all_shown)
    }

    /// Runs the motion again from a changed start and compares; `hear` hears what share is done.
    ///
    /// # Errors
    /// Those of the method; `Hopeless` where the second run takes far longer than the first.
    pub fn measure(
        scene: &MotionScene,
        choice: &Choice,
        (first, seconds): (&Seen, f64),
        stop: &Stop,
        hear: &dyn Fn(f64),
    ) -> Result<Sensitivity, Error> {
        let begun = Instant::now();
        let patience = PATIENCE * seconds + GRACE;
        let again = |change: f64, wanted: Wanted| {
            let changed = first
                .deflections
                .moved(&scene.moving.train, &scene.start, change);
            run(scene, (choice, wanted), changed, (stop, patience), hear)
        };
        let other = match (choice.method.ladder, choice.wanted) {
            (Ladder::Exact, wanted) => wanted,
            (_, Wanted::Tolerance(tolerance)) => Wanted::Tolerance((LOOSER * tolerance).min(0.1)),
            (_, Wanted::Step(step)) => Wanted::Step(SHORTER * step),
        };
        let second = again(CHANGE, other)?;
        let outputs = (0..first.values.len()).map(|at| digits(first, &second, at));
        let outputs: Vec<Digits> = outputs.collect();
        let shown = outputs.iter().all(|o| o.all_shown);
        let apart = |other: &Seen, until| first.deflections.apart(&other.deflections, until);
        let (change, most) = match (choice.method.ladder, shown) {
            (Ladder::Exact, _) => (CHANGE, Some(apart(&second, scene.until))),
            (_, true) => (CHANGE, None),
            (_, false) => {
                let errors = apart(&second, EARLY * scene.until);
                let change = (BEYOND_ERRORS * errors).clamp(CHANGE, LARGEST_CHANGE);
                let third = again(change, choice.wanted)?;
                (change, Some(apart(&third, scene.until)))
            }
        };
        Ok(Sensitivity {
            factor: most.map(|most| most / change),
            parted: most.is_some_and(|most| most > PARTED),
            change,
            outputs,
            seconds: begun.elapsed().as_secs_f64(),
        })
    }
}

/// One more run, from another start and as exact as said.
fn run(
    scene: &MotionScene,
    (choice, wanted): (&Choice, Wanted),
    start: Vec<f64>,
    (stop, patience): (&Stop, f64),
    hear: &dyn Fn(f64),
) -> Result<Seen, Error> {
    let train = &scene.moving.train;
    let mut ask = ask(scene, choice, scene.samples, &stop.within(patience));
    (ask.start, ask.effort) = (start, wanted);
    let mut seen = Seen::new(scene);
    let mut finite = true;
    (choice.method.run)(train, &ask, &mut |t, y, regime| {
        let now = scene.outputs.at(train, regime, t, y);
        finite = now.iter().all(|value| value.is_finite());
        seen.see(scene, (t, y), &now);
        hear(t / scene.until);
        match finite {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    })?;
    if !finite {
        return Err(Error::new(Code::Overflow, "the second run diverged"));
    }
    if seen.count <= scene.samples {
        let message = format!(
            "a run from a changed start takes more than {}, {PATIENCE} times the first",
            duration(patience)
        );
        return Err(Error::new(Code::Hopeless, message));
    }
    Ok(seen)
}

/// What holds of an output.
fn digits(first: &Seen, second: &Seen, output: usize) -> Digits {
    let (a, b) = (&first.values[output], &second.values[output]);
    let readings = [first, second].map(|seen| seen.readers[output].reading());
    let until = parted(a, b).map(|at| first.time[at]);
    let [Some(x), Some(y)] = readings else {
        return Digits {
            until,
            end: None,
            least: None,
            least_at: None,
            greatest: None,
            greatest_at: None,
            mean: f64::NAN,
            rms: f64::NAN,
            second_half: None,
            all_shown: false,
        };
    };
    let predicted = |at: f64| until.is_none_or(|until| at <= until);
    let off = |x: f64, y: f64| CHANCE * (x - y).abs();
    let extreme = |x: (f64, f64), y: (f64, f64)| {
        let both = predicted(x.1) && predicted(y.1);
        let (value, at) = (off(x.0, y.0), off(x.1, y.1));
        let known = both && 2.0 * at <= x.1;
        (both.then_some(value), known.then_some(at))
    };
    let (least, greatest) = (extreme(x.least, y.least), extreme(x.greatest, y.greatest));
    let scatter = |of: fn(&Reading) -> f64| match until {
        None => 0.0,
        Some(_) => block_error([a, b], of),
    };
    let mean = off(x.mean, y.mean).max(scatter(|r| r.mean));
    let rms = off(x.rms, y.rms).max(scatter(|r| r.rms));
    let end = until.is_none().then(|| off(x.end, y.end));
    let size = x.greatest.0.abs().max(x.least.0.abs());
    let holds =
        |error: Option<f64>| error.is_some_and(|error| 2.0 * error <= size * 10f64.powi(-DIGITS));
    let all_shown = [end, least.0, greatest.0, Some(mean), Some(rms)]
        .into_iter()
        .all(holds);
    let half = |values: &[f64]| values[values.len() / 2..].to_vec();
    Digits {
        until,
        end,
        least: least.0,
        least_at: least.1,
        greatest: greatest.0,
        greatest_at: greatest.1,
        mean,
        rms,
        second_half: until.map(|_| Statistics::of([&half(a), &half(b)])),
        all_shown,
    }
}

/// The first sample of the time that is not predicted, where both runs stay apart: in [`LASTS`] of what follows at least.
fn parted(a: &[f64], b: &[f64]) -> Option<usize> {
    let range = |values: &[f64]| {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max) - least
    };
    let limit = APART * range(a).max(range(b));
    let windows = (a.len() / IN_WINDOW).clamp(1, WINDOWS);
    let long = a.len().div_ceil(windows).max(1);
    let lost = a.chunks(long).zip(b.chunks(long)).map(|(a, b)| {
        let apart = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > limit);
        apart.count() as f64 > SHARE * a.len() as f64
    });
    let lost: Vec<bool> = lost.collect();
    let first = (0..lost.len()).find(|&at| {
        let rest = &lost[at..];
        let count = rest.iter().filter(|lost| **lost).count();
        lost[at] && count as f64 >= LASTS * rest.len() as f64
    });
    first.map(|window| window * long)
}
