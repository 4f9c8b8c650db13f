//! Stress cases: extreme changes of stiffness, inertia, damping, backlash, speed and settings of a scene.

use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ForceLaw, MassMatrix};
use crate::motion::prescribed::{self, PrescribedMotion, PrescribedReduction};
use crate::motion::wave::WavePhase;
use crate::numeric::Matrix;
use crate::plan::motion::simulation_setup::SimulationSetup;

/// Change of a scene that defines a case.
pub type Perturbation = fn(&mut PerturbedScene);

/// Scene to which a case is applied.
#[derive(Clone)]
pub struct PerturbedScene {
    /// Full machine, before elimination of prescribed motions.
    pub model: DynamicModel,
    /// Prescribed motions.
    pub motions: Vec<PrescribedMotion>,
    /// Initial state, without prescribed coordinates.
    pub start: Vec<f64>,
    /// End of the integration, s.
    pub end_time: f64,
    /// Tolerance of adaptive methods.
    pub tolerance: f64,
    /// Step of fixed-step methods, s.
    pub step: f64,
    /// Work limit of the integration, in evaluations; see [`MAX_WORK`].
    pub budget: u64,
}

impl PerturbedScene {
    /// Unchanged scene of a simulation setup.
    pub fn new(setup: &SimulationSetup, tolerance: f64, step: f64) -> PerturbedScene {
        let prescribed = setup.model.prescribed.as_ref();
        PerturbedScene {
            model: prescribed
                .map_or(&setup.model.model, |k| &k.full_model)
                .clone(),
            motions: prescribed.map_or(Vec::new(), |k| k.motions.clone()),
            start: setup.initial_state.clone(),
            end_time: setup.end_time,
            tolerance,
            step,
            budget: work_limit(setup),
        }
    }

    /// Model to integrate, and its reduction by the prescribed motions.
    ///
    /// # Errors
    /// Those of [`prescribed::eliminate_motions`].
    pub fn integration_model(&self) -> Result<(DynamicModel, Option<PrescribedReduction>), Error> {
        if self.motions.is_empty() {
            return Ok((self.model.clone(), None));
        }
        let (model, reduction) =
            prescribed::eliminate_motions(self.model.clone(), self.motions.clone())?;
        Ok((model, Some(reduction)))
    }
}

/// Work limit of a case, in evaluations of the equations of motion as counted by [`IntegrationStats::work`]; an evaluation of the
/// powers counts as one. The limit is some seconds for 20 degrees of freedom; as a count it does not depend on the load of
/// the computer.
///
/// [`IntegrationStats::work`]: crate::motion::problem::IntegrationStats::work
pub const MAX_WORK: u64 = 3_000_000;

/// Factor on the work limit for the unchanged scene.
pub const BASELINE_FACTOR: u64 = 10;

/// Work limit for a scene: [`MAX_WORK`], reduced in inverse proportion above 20 degrees of freedom, as the cost of an
/// evaluation grows with their number.
pub fn work_limit(setup: &SimulationSetup) -> u64 {
    const TWENTY: u64 = 20;
    MAX_WORK * TWENTY / TWENTY.max(setup.model.model.coordinate_count() as u64)
}

/// All cases with their names, the unchanged scene first.
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

/// Name of all cases together, if none of them is run.
pub const ALL_CASES: &str = "all extremes";

/// Reason why no case is run if a study states no duration.
pub const REASON_NO_DURATION: &str = "the duration of the motion is not stated: add --until \"2 s\", or `until = \"2 s\"` to the study";

/// Names of the cases, in their order.
pub fn case_names() -> impl Iterator<Item = &'static str> {
    CASES.iter().map(|c| c.0)
}

/// Names of the cases that would change nothing in a scene, with the reason.
pub fn skipped_cases(
    setup: &SimulationSetup,
) -> impl Iterator<Item = (&'static str, &'static str)> {
    let reason =
        |&(name, _): &(&'static str, Perturbation)| Some((name, no_effect_reason(name, setup)?));
    CASES.iter().filter_map(reason)
}

/// Reason why a case changes nothing; `None` if it has an effect.
pub fn no_effect_reason(name: &str, setup: &SimulationSetup) -> Option<&'static str> {
    let prescribed = setup.model.prescribed.as_ref();
    let model = prescribed.map_or(&setup.model.model, |k| &k.full_model);
    let has_backlash = |law: &ForceLaw| matches!(law, ForceLaw::Contact(c) if c.half_play > 0.0);
    let is_imposed = model.elements.iter().any(|b| {
        let waves = b.stiffness_wave.iter().chain(&b.angle_waves);
        waves.into_iter().any(|w| w.phase.angle().is_none()) || b.imposed_displacement.is_some()
    });
    let n = setup.model.model.coordinate_count();
    let rotates = prescribed.is_some() || setup.initial_state[n..2 * n].iter().any(|v| *v != 0.0);
    match name {
        "backlash 0" | "backlash × 1e4" if !model.elements.iter().any(|b| has_backlash(&b.law)) => {
            Some("no contact has play")
        }
        "speed 0" | "speed × 100" if !rotates && !is_imposed => {
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
fn damping(model: &mut DynamicModel, coefficient: fn(f64, f64) -> f64) {
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
        // An element that acts on no inertia keeps its damping.
        if !m.is_finite() {
            continue;
        }
        match &mut b.law {
            ForceLaw::Linear { stiffness, damping } => *damping = coefficient(*stiffness, m),
            ForceLaw::Contact(contact) => contact.damping = coefficient(contact.stiffness, m),
            _ => {}
        }
    }
    model.mass_damping = 0.0;
    if let Some((_, c)) = &mut model.global_matrices {
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

fn speed(scene: &mut PerturbedScene, factor: f64) {
    let n = scene.model.coordinate_count() - scene.motions.len();
    for motion in &mut scene.motions {
        motion.signal = motion.signal.scaled(factor);
    }
    scene.start[n..2 * n].iter_mut().for_each(|v| *v *= factor);
    for b in &mut scene.model.elements {
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
