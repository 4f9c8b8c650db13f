//! What a motion costs at least, known before any work: steps that stability or the study bounds, and the room of its history.

use std::time::Instant;

use super::choice::{Choice, choose};
use super::dense::{Dense, ROOM};
use super::scene::MotionScene;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::{duration, enough, seconds};
use crate::base::words::counted;
use crate::motion::methods::{METHODS, Method};
use crate::motion::problem::{Problem, Wanted};
use crate::motion::progress::rounded;
use crate::motion::trouble::{Fastest, fastest};
use crate::scene::study::SimulateStudy;

/// Numbers that a history may hold.
const NUMBERS: f64 = ROOM / 8.0;

/// What steps of a scene cost.
pub struct Cost<'s> {
    until: f64,
    coordinates: usize,
    /// Seconds of one evaluation of f.
    evaluation: f64,
    fastest: Option<Fastest<'s>>,
}

/// A run costs at least this.
pub struct Least<'s> {
    /// Steps; none where nothing bounds them.
    pub steps: f64,
    /// Seconds.
    pub seconds: f64,
    /// What bounds the steps; absent where the study gives them.
    pub by: Option<Fastest<'s>>,
    /// Its matrices, where these cost more than the steps.
    pub matrices: Option<Dense>,
}

impl<'s> Cost<'s> {
    /// Times an evaluation of f, in a millisecond.
    pub fn new(scene: &'s MotionScene) -> Cost<'s> {
        let train = &scene.moving.train;
        let mut slope = vec![0.0; train.len()];
        let begin = Instant::now();
        let mut least = f64::INFINITY;
        while begin.elapsed().as_secs_f64() < 1e-3 {
            const MANY: u32 = 16;
            let some = Instant::now();
            (0..MANY).for_each(|_| train.slope(0.0, &scene.start, &mut slope));
            least = least.min(some.elapsed().as_secs_f64() / f64::from(MANY));
        }
        Cost {
            until: scene.until,
            coordinates: train.n(),
            evaluation: least,
            fastest: fastest(train),
        }
    }

    /// What a run by a method costs at least; absent where nothing tells before.
    pub fn least(&self, method: &Method, wanted: Wanted) -> Option<Least<'s>> {
        let stages = method.bound.map_or(1.0, |b| f64::from(b.stages));
        let (steps, by) = match (wanted, method.bound, self.fastest) {
            (Wanted::Step(h), ..) => (self.until / h, None),
            (Wanted::Tolerance(_), Some(bound), Some(fastest)) => {
                (self.until * fastest.rate / bound.radius, Some(fastest))
            }
            _ => (0.0, None),
        };
        let seconds = steps * stages * self.evaluation;
        let matrices = Dense::of(method, self.coordinates);
        let matrices = matrices.filter(|m| m.seconds > seconds || m.bytes > ROOM);
        (steps > 0.0 || matrices.is_some()).then(|| Least {
            steps,
            seconds: matrices.map_or(seconds, |m| m.seconds.max(seconds)),
            by,
            matrices,
        })
    }
}

impl Least<'_> {
    /// More than so many seconds, or than the room there is.
    pub fn is_beyond(&self, seconds: f64) -> bool {
        self.seconds > seconds || self.matrices.is_some_and(|m| m.bytes > ROOM)
    }

    /// In words.
    pub fn told(&self) -> String {
        if let Some(matrices) = &self.matrices {
            return matrices.told();
        }
        let text = format!(
            "it would take {} steps and {} at least",
            rounded(self.steps),
            duration(self.seconds)
        );
        match self.by {
            Some(by) => format!("{text}, for steps bound by stability: {}", by.told()),
            None => text,
        }
    }
}

/// Refuses histories of all outputs, so many at a time, that would take more room than is allowed.
///
/// # Errors
/// `Hopeless`, with what they would take.
pub fn room(scene: &MotionScene, histories: usize) -> Result<(), Error> {
    let columns = histories * (scene.outputs.list.len() + 1);
    let numbers = columns as f64 * (scene.samples as f64 + 1.0);
    if numbers <= NUMBERS {
        return Ok(());
    }
    let message = format!(
        "{} at {} instants would take {:.0} GB, and {:.0} are allowed",
        counted(columns, "column"),
        scene.samples + 1,
        8e-9 * numbers,
        8e-9 * NUMBERS
    );
    Err(Error::new(Code::Hopeless, message).hint("ask for fewer --samples"))
}

/// Refuses a motion that would take longer than is allowed, or whose history would take more room.
///
/// # Errors
/// `Hopeless`, with the estimate and what to try.
pub fn refuse(scene: &MotionScene, choice: &Choice, study: &SimulateStudy) -> Result<(), Error> {
    if study.running.history {
        room(scene, 1)
            .map_err(|e| e.hint("ask for fewer --samples, or keep none with --no-history"))?;
    }
    let least = Cost::new(scene).least(choice.method, choice.wanted);
    let Some(least) = least.filter(|least| least.is_beyond(scene.allowed)) else {
        return Ok(());
    };
    let room = match least.matrices {
        Some(_) => format!(" and {:.0} GB", 1e-9 * ROOM),
        None => String::new(),
    };
    let message = format!(
        "{} is hopeless here: {}, and {}{room} are allowed",
        choice.method.name,
        least.told(),
        duration(scene.allowed)
    );
    if least.matrices.is_some() {
        return Err(Error::new(Code::Hopeless, message).hint(without_matrices(scene)));
    }
    let free = SimulateStudy {
        method: None,
        step: None,
        ..study.clone()
    };
    let other = choose(&scene.moving.train, &free).ok();
    let other = other.filter(|other| other.method.name != choice.method.name);
    let other = other.map_or(String::new(), |other| {
        format!(
            ", or leave method and step out: the plan takes {}",
            other.method.name
        )
    });
    let step = match choice.wanted {
        Wanted::Step(_) => ", take a longer step",
        Wanted::Tolerance(_) => "",
    };
    Err(Error::new(Code::Hopeless, message).hint(format!(
        "ask for a shorter time ({} reach t = {} at most), allow more with --allow {}{step}{other}",
        duration(scene.allowed),
        seconds(scene.until * scene.allowed / least.seconds),
        enough(least.seconds)
    )))
}

/// What to try where matrices are too large.
fn without_matrices(scene: &MotionScene) -> String {
    let train = &scene.moving.train;
    let explicit = METHODS.iter().filter(|m| m.bound.is_some());
    let able: Vec<&str> = explicit
        .filter(|m| (m.refuses)(train).is_none())
        .map(|m| m.name)
        .collect();
    match able.is_empty() {
        true => "model the machine with fewer coordinates".to_string(),
        false => format!(
            "{} go without matrices: name one by --method; or model the machine with fewer coordinates",
            able.join(", ")
        ),
    }
}
