//! What errors are measured against: the agreement of two unrelated methods, each as tight as patience allows.

use super::trial::{TIGHTEST, Trial, distance, growth, integrate, ladder};
use super::watch::{Watch, interrupted};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::methods::{Ladder, METHODS, Method};
use crate::motion::problem::Wanted;
use crate::plan::motion::cost::Cost;
use crate::plan::motion::scene::MotionScene;

/// What the errors are against.
pub struct Reference {
    /// Its method.
    pub method: &'static str,
    /// How exact or how fine it was asked; absent for what is exact to rounding.
    pub wanted: Option<Wanted>,
    /// What it was held against, the closest first.
    pub witnesses: Vec<Witness>,
    /// Methods that could have witnessed and did not, with the reason.
    pub silent: Vec<(&'static str, String)>,
    /// How many times as much a change of the start shows in an output over the whole time as over its first tenth: errors of
    /// rounding grow alike. Absent where nothing moves.
    pub amplification: Option<f64>,
    /// The values, output by output.
    pub values: Vec<Vec<f64>>,
}

/// Another run, and how far it is off.
pub struct Witness {
    /// Its method.
    pub method: &'static str,
    /// How exact or how fine it was asked; absent for what is exact to rounding.
    pub wanted: Option<Wanted>,
    /// It descends from the same method: what both get wrong it cannot show.
    pub related: bool,
    /// How far it is from the reference.
    pub distance: f64,
}

/// Two that agree so far need no third.
const CLOSE: f64 = 1e-11;

/// Two that agree so far need none that does not locate switches.
const FAIR: f64 = 1e-9;

/// The part of the time in which a change of the start is first seen.
const FIRST: usize = 10;

/// Least and greatest change of the start, by the size that the deformation of each state reaches, that shows how errors grow. By the
/// angle turned it would be as large as the deformations themselves.
const NUDGE: (f64, f64) = (1e-9, 1e-5);

/// The change is so many times what the reference is known to.
const BEYOND: f64 = 1e3;

/// The tightest run of a method, and the one before.
struct Climbed {
    method: &'static Method,
    trials: Vec<(Option<Wanted>, Trial)>,
}

impl Climbed {
    /// The tightest.
    fn best(&self) -> Option<&Trial> {
        self.trials.last().map(|t| &t.1)
    }

    fn values(&self) -> &[Vec<f64>] {
        self.best().map_or(&[], |t| &t.values)
    }
}

impl Reference {
    /// How far it is from the closest witness: an estimate of its own error.
    pub fn agreement(&self) -> Option<f64> {
        self.witnesses.first().map(|w| w.distance)
    }

    /// Finds it, no method for longer than a patience, s: of all pairs of unrelated methods the closest, and of this pair the one that is trusted more.
    ///
    /// # Errors
    /// No method that could serve; `Interrupted` before there is one.
    pub fn find(
        scene: &MotionScene,
        patience: (&Cost, f64),
        watch: &mut Watch,
    ) -> Result<Reference, Error> {
        let (found, silent) = gather(scene, patience, watch)?;
        let Some((at, mut witnesses)) = closest(&found) else {
            let error = Error::new(Code::Hopeless, "no method gives a reference for this scene");
            let why: Vec<String> = silent
                .iter()
                .map(|(m, why)| format!("{m}: {why}"))
                .collect();
            return Err(error.hint(format!("ask for a shorter time; {}", why.join("; "))));
        };
        let own = &found[at];
        if witnesses.is_empty() {
            witnesses.extend(itself(own));
        }
        let wanted = own.trials.last().and_then(|t| t.0);
        let known = witnesses.first().map_or(0.0, |w| w.distance);
        let amplification = amplification(scene, own, known, watch);
        let method = own.method.name;
        let values = own.values().to_vec();
        Ok(Reference {
            method,
            wanted,
            witnesses,
            silent,
            amplification,
            values,
        })
    }
}

/// How little a method is trusted to be a reference: exact ones most, then those that take switches as they come, then by order.
fn doubt(method: &Method) -> u32 {
    match (method.ladder, method.locates_events) {
        (Ladder::Exact, _) => 0,
        (Ladder::Tolerance, true) => 1,
        (Ladder::Tolerance, false) if method.order != Some(2) => 2,
        (Ladder::Step, _) => 3,
        (Ladder::Tolerance, false) => 4,
    }
}

/// Runs of unrelated methods, the most trusted first, until two agree closely; and those that failed.
#[allow(clippy::type_complexity, reason = "both halves are named above")]
fn gather(
    scene: &MotionScene,
    patience: (&Cost, f64),
    watch: &mut Watch,
) -> Result<(Vec<Climbed>, Vec<(&'static str, String)>), Error> {
    let train = &scene.moving.train;
    let mut able: Vec<&'static Method> = METHODS
        .iter()
        .filter(|m| (m.refuses)(train).is_none())
        .collect();
    able.sort_by_key(|m| doubt(m));
    let (mut found, mut silent) = (Vec::<Climbed>::new(), Vec::new());
    let mut silent_kin = Vec::new();
    for method in able {
        let enough = if doubt(method) > 1 { FAIR } else { CLOSE };
        if nearest_pair(&found) <= enough {
            break;
        }
        let known = found.iter().any(|c| c.method.kin == method.kin);
        if known || silent_kin.contains(&method.kin) {
            continue;
        }
        if !watch.goes_on(&format!("reference by {}", method.name)) {
            return Err(interrupted());
        }
        match climb(scene, method, patience, watch) {
            Ok(climbed) => found.push(climbed),
            Err(error) if error.code == Code::Interrupted => return Err(error),
            Err(error) => {
                // Explicit methods are all bound alike.
                silent_kin.extend(method.bound.map(|_| method.kin));
                silent.push((method.name, error.message));
            }
        }
    }
    Ok((found, silent))
}

/// Ever tighter runs of one method, while the next fits into what is left of its time.
fn climb(
    scene: &MotionScene,
    method: &'static Method,
    (cost, patience): (&Cost, f64),
    watch: &mut Watch,
) -> Result<Climbed, Error> {
    let mut trials: Vec<(Option<Wanted>, Trial)> = Vec::new();
    let mut left = patience;
    for rung in ladder(scene, method) {
        let wanted = rung.unwrap_or(Wanted::Tolerance(TIGHTEST));
        let next = trials.last().map_or(0.0, |t| t.1.seconds * growth(method));
        if next > left {
            break;
        }
        let least = cost.least(method, wanted);
        if let Some(least) = least.filter(|least| least.is_beyond(left)) {
            match trials.is_empty() {
                true => return Err(Error::new(Code::Hopeless, least.told())),
                false => break,
            }
        }
        let patience = (watch.stop, left);
        match integrate(scene, method, wanted, &scene.start, patience) {
            Ok(trial) if distance(&trial.values, &trial.values).is_finite() => {
                left -= trial.seconds;
                // The one before is enough to compare with.
                trials.drain(..trials.len().saturating_sub(1));
                trials.push((rung, trial));
            }
            Ok(_) => {
                let message = "the motion grew beyond all numbers";
                return Err(Error::new(Code::Overflow, message));
            }
            Err(error) if error.code == Code::Interrupted || trials.is_empty() => {
                return Err(error);
            }
            Err(_) => break,
        }
    }
    Ok(Climbed { method, trials })
}

/// The distance of the closest pair.
fn nearest_pair(found: &[Climbed]) -> f64 {
    let others = |at: usize| found[at + 1..].iter().map(move |b| (at, b));
    let pairs = (0..found.len()).flat_map(others);
    pairs
        .map(|(at, b)| distance(b.values(), found[at].values()))
        .fold(f64::INFINITY, f64::min)
}

/// The most trusted of the closest pair, with all others by their distance from it; absent where there is none at all.
fn closest(found: &[Climbed]) -> Option<(usize, Vec<Witness>)> {
    let least = nearest_pair(found);
    let beside = |at: usize| {
        let others = found.iter().enumerate().filter(move |o| o.0 != at);
        let mut all: Vec<Witness> = others
            .map(|(_, other)| Witness {
                method: other.method.name,
                wanted: other.trials.last().and_then(|t| t.0),
                related: false,
                distance: distance(other.values(), found[at].values()),
            })
            .collect();
        all.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        (at, all)
    };
    let mut all = (0..found.len()).map(beside);
    // Distances go by the size of either, so that only the first of a pair has it exactly.
    all.find(|(_, w)| w.first().is_none_or(|w| w.distance <= least))
}

/// The same method asked less tightly, where no other can witness.
fn itself(own: &Climbed) -> Option<Witness> {
    let [.., (wanted, before), (_, best)] = &own.trials[..] else {
        return None;
    };
    Some(Witness {
        method: own.method.name,
        wanted: *wanted,
        related: true,
        distance: distance(&before.values, &best.values),
    })
}

/// Runs once more from a start changed by a small share of the size each state's deformation reaches.
fn amplification(scene: &MotionScene, own: &Climbed, known: f64, watch: &mut Watch) -> Option<f64> {
    let (wanted, best) = own.trials.last()?;
    let nudge = (BEYOND * known).clamp(NUDGE.0, NUDGE.1);
    if best.sizes.iter().all(|s| *s == 0.0) {
        return None;
    }
    let start: Vec<f64> = scene
        .start
        .iter()
        .zip(&best.sizes)
        .map(|(x, size)| x + nudge * size)
        .collect();
    let wanted = wanted.unwrap_or(Wanted::Tolerance(TIGHTEST));
    let patience = (watch.stop, 2.0 * best.seconds + 1.0);
    let moved = integrate(scene, own.method, wanted, &start, patience).ok()?;
    let of = |(x, r): (&Vec<f64>, &Vec<f64>)| {
        let apart: Vec<f64> = x.iter().zip(r).map(|(a, b)| (a - b).abs()).collect();
        let largest = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
        let first = largest(&apart[..=scene.samples / FIRST]);
        (first > 0.0).then(|| largest(&apart) / first)
    };
    let growth = moved.values.iter().zip(&best.values).filter_map(of);
    growth.reduce(f64::max).filter(|x| x.is_finite())
}
