//! Stress cases: changes of stiffness, inertia, damping, backlash and settings of a scene.

use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ForceLaw, MassMatrix};
use crate::motion::prescribed::{self, PrescribedMotion, PrescribedReduction};
use crate::motion::wave::WavePhase;
use crate::numeric::Matrix;
use crate::plan::motion::simulation_setup::SimulationSetup;

/// Change of a scene that defines a case.
pub type Perturbation = fn(&mut PerturbedScene);

/// A scene that cases change.
#[derive(Clone)]
pub struct PerturbedScene {
    /// The whole machine.
    pub model: DynamicModel,
    /// Motions that are prescribed to it.
    pub motions: Vec<PrescribedMotion>,
    /// The state it starts from, without what is prescribed.
    pub start: Vec<f64>,
    /// s.
    pub end_time: f64,
    /// Tolerance of adaptive methods.
    pub tolerance: f64,
    /// Step of fixed-step methods, s.
    pub step: f64,
    /// Work after which a rerun is refused, in evaluations.
    pub budget: u64,
}

impl PerturbedScene {
    /// A scene as it is.
    pub fn new(setup: &SimulationSetup, tolerance: f64, step: f64) -> PerturbedScene {
        let known = setup.model.prescribed.as_ref();
        PerturbedScene {
            model: known.map_or(&setup.model.model, |k| &k.whole).clone(),
            motions: known.map_or(Vec::new(), |k| k.motions.clone()),
            start: setup.initial_state.clone(),
            end_time: setup.end_time,
            tolerance,
            step,
            budget: work_limit(setup),
        }
    }

    /// The machine to integrate, and what was taken out of it.
    ///
    /// # Errors
    /// Those of [`prescribed::eliminate_motions`].
    pub fn integration_model(&self) -> Result<(DynamicModel, Option<PrescribedReduction>), Error> {
        if self.motions.is_empty() {
            return Ok((self.model.clone(), None));
        }
        let (rest, known) =
            prescribed::eliminate_motions(self.model.clone(), self.motions.clone())?;
        Ok((rest, Some(known)))
    }
}

/// The work after which a case is refused, in evaluations of the equations of motion as [`IntegrationStats::work`] counts them, a reading of the
/// powers being one as well: some seconds for twenty degrees of freedom. It is counted, so that a verdict does not depend on
/// what else a computer does.
///
/// [`IntegrationStats::work`]: crate::motion::problem::IntegrationStats::work
pub const MAX_WORK: u64 = 3_000_000;

/// Factor on the work limit of the unchanged scene, the one under study.
pub const BASELINE_FACTOR: u64 = 10;

/// [`MAX_WORK`] for a scene: of more than twenty degrees of freedom, each evaluation costing in proportion, as many fewer as
/// they are more.
pub fn work_limit(setup: &SimulationSetup) -> u64 {
    const TWENTY: u64 = 20;
    MAX_WORK * TWENTY / TWENTY.max(setup.model.model.coordinate_count() as u64)
}

/// Every case, the unchanged scene first.
pub const CASES: &[(&str, Perturbation)] = &[
    ("as it is", |x| x.budget *= BASELINE_FACTOR),
    ("stiffness × 1e6", |x| stiffness(&mut x.model, 1e6)),
    ("stiffness × 1e-6", |x| stiffness(&mut x.model, 1e-6)),
    ("inertia × 1e6", |x| inertia(&mut x.model, 1e6)),
    ("inertia × 1e-6", |x| inertia(&mut x.model, 1e-6)),
    ("damping 0", |x| damping(&mut x.model, |_, _| 0.0)),
    ("damping overcritical", |x| {
        damping(&mut x.model, |k, m| 4.0 * (k * m).sqrt())
    }),
    ("backlash 0", |x| backlash(&mut x.model, 0.0)),
    ("backlash × 1e4", |x| backlash(&mut x.model, 1e4)),
    ("speed 0", |x| speed(x, 0.0)),
    ("speed × 100", |x| speed(x, 100.0)),
    ("tolerance 1e-2", |x| x.tolerance = 1e-2),
    ("tolerance 1e-13", |x| x.tolerance = 1e-13),
    ("duration × 1000", |x| x.end_time *= 1000.0),
];

/// All cases, where they are left out together.
pub const ALL_CASES: &str = "all extremes";

/// Why they are, where a study says nothing of time.
pub const REASON_NO_DURATION: &str =
    "the duration of the motion is not stated: add --until \"2 s\", or `until` to the study";

/// Names of the cases, in their order.
pub fn case_names() -> impl Iterator<Item = &'static str> {
    CASES.iter().map(|c| c.0)
}

/// Cases that would change nothing in a scene, and why.
pub fn skipped_cases(
    setup: &SimulationSetup,
) -> impl Iterator<Item = (&'static str, &'static str)> {
    let idle =
        |&(name, _): &(&'static str, Perturbation)| Some((name, no_effect_reason(name, setup)?));
    CASES.iter().filter_map(idle)
}

/// Why a case changes nothing.
pub fn no_effect_reason(name: &str, setup: &SimulationSetup) -> Option<&'static str> {
    let known = setup.model.prescribed.as_ref();
    let model = known.map_or(&setup.model.model, |k| &k.whole);
    let plays = |law: &ForceLaw| matches!(law, ForceLaw::Contact(c) if c.half_play > 0.0);
    let imposed = model.elements.iter().any(|b| {
        let waves = b.stiffness_wave.iter().chain(&b.angle_waves);
        waves.into_iter().any(|w| w.phase.angle().is_none()) || b.imposed_displacement.is_some()
    });
    let n = setup.model.model.coordinate_count();
    let turns = known.is_some() || setup.initial_state[n..2 * n].iter().any(|v| *v != 0.0);
    match name {
        "backlash 0" | "backlash × 1e4" if !model.elements.iter().any(|b| plays(&b.law)) => {
            Some("no contact has play")
        }
        "speed 0" | "speed × 100" if !turns && !imposed => {
            Some("the setup starts at rest and no speed is imposed")
        }
        _ => None,
    }
}

fn stiffness(model: &mut DynamicModel, factor: f64) {
    for b in &mut model.elements {
        match &mut b.law {
            ForceLaw::Linear { stiffness, .. } | ForceLaw::Maxwell { stiffness, .. } => {
                *stiffness *= factor
            }
            ForceLaw::Nonlinear { characteristic, .. } => characteristic.scale(factor),
            ForceLaw::Contact(contact) => contact.stiffness *= factor,
            ForceLaw::Friction(_)
            | ForceLaw::Clutch { .. }
            | ForceLaw::LoadFriction(_)
            | ForceLaw::AngleLocked { .. }
            | ForceLaw::TorqueSpeed(_)
            | ForceLaw::LaggedTorque { .. } => {}
        }
    }
}

fn inertia(model: &mut DynamicModel, factor: f64) {
    match &mut model.mass {
        MassMatrix::Diagonal(mass) => mass.iter_mut().for_each(|m| *m *= factor),
        MassMatrix::Full { matrix, inverse } => {
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
fn damping(model: &mut DynamicModel, of: fn(f64, f64) -> f64) {
    let masses: Vec<f64> = model
        .elements
        .iter()
        .map(|b| {
            let mut w = vec![0.0; model.coordinate_count()];
            b.direction.entries().for_each(|(i, a)| w[i] += a);
            model.apply_inverse_mass(&mut w);
            1.0 / b.direction.dot(&w)
        })
        .collect();
    for (b, m) in model.elements.iter_mut().zip(masses) {
        // What joins no inertia has no damping of its own.
        if !m.is_finite() {
            continue;
        }
        match &mut b.law {
            ForceLaw::Linear { stiffness, damping } => *damping = of(*stiffness, m),
            ForceLaw::Contact(contact) => contact.damping = of(contact.stiffness, m),
            _ => {}
        }
    }
    model.mass_damping = 0.0;
    if let Some((_, c)) = &mut model.unattached {
        *c = Matrix::zeros(c.nrows(), c.ncols());
    }
}

fn backlash(model: &mut DynamicModel, factor: f64) {
    for b in &mut model.elements {
        if let ForceLaw::Contact(contact) = &mut b.law {
            contact.half_play *= factor;
        }
    }
}

fn speed(extreme: &mut PerturbedScene, factor: f64) {
    let n = extreme.model.coordinate_count() - extreme.motions.len();
    for motion in &mut extreme.motions {
        motion.signal = motion.signal.scaled(factor);
    }
    extreme.start[n..2 * n]
        .iter_mut()
        .for_each(|v| *v *= factor);
    for b in &mut extreme.model.elements {
        for wave in b.stiffness_wave.iter_mut().chain(&mut b.angle_waves) {
            if let WavePhase::Imposed { omega, .. } = &mut wave.phase {
                *omega *= factor;
            }
        }
        if let Some(e) = &mut b.imposed_displacement {
            e.harmonics.iter_mut().for_each(|h| h.omega *= factor);
        }
    }
}
