//! The extremes: what each makes of a scene.

use crate::base::error::Error;
use crate::motion::prescribed::{self, Motion, Prescribed};
use crate::motion::train::{Law, Mass, Train};
use crate::motion::wave::Phase;
use crate::numeric::Matrix;
use crate::plan::motion::scene::MotionScene;

/// What a case does to a scene.
pub type Change = fn(&mut Extreme);

/// A scene that cases change.
#[derive(Clone)]
pub struct Extreme {
    /// The whole machine.
    pub train: Train,
    /// Motions that are prescribed to it.
    pub motions: Vec<Motion>,
    /// The state it starts from, without what is prescribed.
    pub start: Vec<f64>,
    /// s.
    pub until: f64,
    /// Of methods that go by one.
    pub tolerance: f64,
    /// Of methods that go by one, s.
    pub step: f64,
    /// Work after which a rerun is refused, in evaluations.
    pub budget: u64,
}

impl Extreme {
    /// A scene as it is.
    pub fn of(scene: &MotionScene, tolerance: f64, step: f64) -> Extreme {
        let known = scene.moving.prescribed.as_ref();
        Extreme {
            train: known.map_or(&scene.moving.train, |k| &k.whole).clone(),
            motions: known.map_or(Vec::new(), |k| k.motions.clone()),
            start: scene.start.clone(),
            until: scene.until,
            tolerance,
            step,
            budget: budget(scene),
        }
    }

    /// The machine to integrate, and what was taken out of it.
    ///
    /// # Errors
    /// Those of [`prescribed::without`].
    pub fn moving(&self) -> Result<(Train, Option<Prescribed>), Error> {
        if self.motions.is_empty() {
            return Ok((self.train.clone(), None));
        }
        let (rest, known) = prescribed::without(self.train.clone(), self.motions.clone())?;
        Ok((rest, Some(known)))
    }
}

/// The work after which a case is refused, in evaluations of the equations of motion as [`Effort::work`] counts them, a reading of the
/// powers being one as well: some seconds for twenty freedoms. It is counted, so that a verdict does not depend on what else a computer does.
///
/// [`Effort::work`]: crate::motion::problem::Effort::work
pub const BUDGET: u64 = 3_000_000;

/// The unchanged scene, which is what is asked about, may take so many times as much.
pub const AS_IT_IS: u64 = 10;

/// [`BUDGET`] for a scene: of more than twenty freedoms, each evaluation costing in proportion, as many fewer as they are more.
pub fn budget(scene: &MotionScene) -> u64 {
    const TWENTY: u64 = 20;
    BUDGET * TWENTY / TWENTY.max(scene.moving.train.n() as u64)
}

/// Every case, the unchanged scene first.
pub const CASES: &[(&str, Change)] = &[
    ("as it is", |x| x.budget *= AS_IT_IS),
    ("stiffness × 1e6", |x| stiffness(&mut x.train, 1e6)),
    ("stiffness × 1e-6", |x| stiffness(&mut x.train, 1e-6)),
    ("inertia × 1e6", |x| inertia(&mut x.train, 1e6)),
    ("inertia × 1e-6", |x| inertia(&mut x.train, 1e-6)),
    ("damping 0", |x| damping(&mut x.train, |_, _| 0.0)),
    ("damping overcritical", |x| {
        damping(&mut x.train, |k, m| 4.0 * (k * m).sqrt())
    }),
    ("backlash 0", |x| backlash(&mut x.train, 0.0)),
    ("backlash × 1e4", |x| backlash(&mut x.train, 1e4)),
    ("speed 0", |x| speed(x, 0.0)),
    ("speed × 100", |x| speed(x, 100.0)),
    ("tolerance 1e-2", |x| x.tolerance = 1e-2),
    ("tolerance 1e-13", |x| x.tolerance = 1e-13),
    ("duration × 1000", |x| x.until *= 1000.0),
];

/// All cases, where they are left out together.
pub const ALL: &str = "all extremes";

/// Why they are, where a study says nothing of time.
pub const NO_DURATION: &str =
    "nothing says how long the motion lasts: add --until \"2 s\", or `until` to the study";

/// Names of the cases, in their order.
pub fn cases() -> impl Iterator<Item = &'static str> {
    CASES.iter().map(|c| c.0)
}

/// Cases that would change nothing in a scene, and why.
pub fn left_out(scene: &MotionScene) -> impl Iterator<Item = (&'static str, &'static str)> {
    let idle = |&(name, _): &(&'static str, Change)| Some((name, idle(name, scene)?));
    CASES.iter().filter_map(idle)
}

/// Why a case changes nothing.
pub fn idle(name: &str, scene: &MotionScene) -> Option<&'static str> {
    let known = scene.moving.prescribed.as_ref();
    let train = known.map_or(&scene.moving.train, |k| &k.whole);
    let plays = |law: &Law| matches!(law, Law::Contact(c) if c.half > 0.0);
    let imposed = train.branches.iter().any(|b| {
        let waves = b.variation.iter().chain(&b.followed);
        waves.into_iter().any(|w| w.phase.angle().is_none()) || b.imposed.is_some()
    });
    let n = scene.moving.train.n();
    let turns = known.is_some() || scene.start[n..2 * n].iter().any(|v| *v != 0.0);
    match name {
        "backlash 0" | "backlash × 1e4" if !train.branches.iter().any(|b| plays(&b.law)) => {
            Some("no contact has play")
        }
        "speed 0" | "speed × 100" if !turns && !imposed => {
            Some("the scene starts at rest and no speed is imposed")
        }
        _ => None,
    }
}

fn stiffness(train: &mut Train, factor: f64) {
    for b in &mut train.branches {
        match &mut b.law {
            Law::Linear { stiffness, .. } | Law::Maxwell { stiffness, .. } => *stiffness *= factor,
            Law::Nonlinear { characteristic, .. } => characteristic.scale(factor),
            Law::Contact(contact) => contact.stiffness *= factor,
            Law::Friction(_)
            | Law::Clutch { .. }
            | Law::Pressed(_)
            | Law::Orders { .. }
            | Law::Curve(_)
            | Law::Lagged { .. } => {}
        }
    }
}

fn inertia(train: &mut Train, factor: f64) {
    match &mut train.mass {
        Mass::Diagonal(mass) => mass.iter_mut().for_each(|m| *m *= factor),
        Mass::Full { matrix, inverse } => {
            for j in 0..matrix.ncols() {
                for i in 0..matrix.nrows() {
                    matrix[(i, j)] *= factor;
                    inverse[(i, j)] /= factor;
                }
            }
        }
    }
}

/// Sets the damper of every branch from its stiffness and effective mass.
fn damping(train: &mut Train, of: fn(f64, f64) -> f64) {
    let masses: Vec<f64> = train
        .branches
        .iter()
        .map(|b| {
            let mut w = vec![0.0; train.n()];
            b.direction.scaled().for_each(|(i, a)| w[i] += a);
            train.accelerate(&mut w);
            1.0 / b.direction.dot(&w)
        })
        .collect();
    for (b, m) in train.branches.iter_mut().zip(masses) {
        // What joins no inertia has no damping of its own.
        if !m.is_finite() {
            continue;
        }
        match &mut b.law {
            Law::Linear { stiffness, damping } => *damping = of(*stiffness, m),
            Law::Contact(contact) => contact.damping = of(contact.stiffness, m),
            _ => {}
        }
    }
    train.drag = 0.0;
    if let Some((_, c)) = &mut train.general {
        *c = Matrix::zeros(c.nrows(), c.ncols());
    }
}

fn backlash(train: &mut Train, factor: f64) {
    for b in &mut train.branches {
        if let Law::Contact(contact) = &mut b.law {
            contact.half *= factor;
        }
    }
}

fn speed(extreme: &mut Extreme, factor: f64) {
    let n = extreme.train.n() - extreme.motions.len();
    for motion in &mut extreme.motions {
        motion.course = motion.course.times(factor);
    }
    extreme.start[n..2 * n]
        .iter_mut()
        .for_each(|v| *v *= factor);
    for b in &mut extreme.train.branches {
        for wave in b.variation.iter_mut().chain(&mut b.followed) {
            if let Phase::Imposed { omega, .. } = &mut wave.phase {
                *omega *= factor;
            }
        }
        if let Some(e) = &mut b.imposed {
            e.harmonics.iter_mut().for_each(|h| h.omega *= factor);
        }
    }
}
