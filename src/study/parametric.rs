//! Parametric stability: Floquet multipliers over speed and a second parameter.

use std::sync::{Mutex, PoisonError};

use super::monitor::Monitor;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_number;
use crate::machine::kinematics::mean_speeds;
use crate::motion::dynamic_model::{DynamicModel, ForceLaw};
use crate::motion::floquet::{
    self, stability_chart::InstabilityTongue, stability_chart::instability_tongues,
};
use crate::numeric::parallel;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::prepared_machine::PreparedMachine;
use crate::scene::laws::Waveform;
use crate::scene::study::{ParameterSweep, StabilityStudy, SweepParameter};

/// Stability of a machine with periodically varying stiffness, by the largest Floquet multiplier.
pub struct ParametricResult {
    /// Largest modulus of the Floquet multipliers at the speed of the scene, except those of free rotation.
    pub max_multiplier: f64,
    /// Period, s.
    pub period: f64,
    /// Speed of the first node of `[speed]`, rad/s.
    pub speed: f64,
    /// Chart of unstable speeds, if requested.
    pub chart: Option<StabilityChart>,
}

/// Tolerance on the modulus of a multiplier of 1.
const MULTIPLIER_TOLERANCE: f64 = 1e-9;

impl ParametricResult {
    /// Whether no perturbation grows from period to period.
    pub fn is_stable(&self) -> bool {
        self.max_multiplier <= 1.0 + MULTIPLIER_TOLERANCE
    }

    /// Growth rate of the fastest growing perturbation, 1/s.
    pub fn growth_rate(&self) -> f64 {
        self.max_multiplier.ln() / self.period
    }
}

/// Chart of unstable speeds, optionally over a second parameter.
pub struct StabilityChart {
    /// First and last speed of the chart, relative to the speed of the scene.
    pub span: [f64; 2],
    /// Rows by the second parameter; without one, a single row with factor 1.
    pub rows: Vec<ChartRow>,
    /// Second parameter, if any.
    pub parameter: Option<SweepParameter>,
    /// Frequency of the common period of all stiffnesses at the speed of the scene, rad/s.
    pub base: f64,
}

/// Unstable speeds at one value of the second parameter.
pub struct ChartRow {
    /// Factor on the parameter value of the scene.
    pub factor: f64,
    /// Instability tongues by rising speed.
    pub tongues: Vec<InstabilityTongue>,
}

const CONSTANT: &str = "no stiffness varies at an imposed speed";

fn has_varying_stiffness(model: &DynamicModel) -> bool {
    let mut waves = model
        .elements
        .iter()
        .filter_map(|b| b.stiffness_wave.as_ref());
    waves.any(|w| w.phase.angle().is_none())
}

/// Speed of the first node of `[speed]`, rad/s.
fn first_speed(machine: &PreparedMachine, study: &StabilityStudy) -> Result<f64, Error> {
    let speeds = mean_speeds(&machine.machine, &machine.kinematics, study.motion.speed)?;
    Ok(machine.machine.speeds.first().map_or(0.0, |s| speeds[s.0]))
}

/// Checks that a requested chart is possible.
///
/// # Errors
/// A chart without a periodically varying stiffness, or without a speed in the setup.
pub fn check_study(
    machine: &PreparedMachine,
    setup: &SimulationSetup,
    study: &StabilityStudy,
) -> Result<(), Error> {
    if study.speeds.is_none() {
        return Ok(());
    }
    if !has_varying_stiffness(&setup.model.model) {
        let message = format!("{CONSTANT}: there is nothing to chart");
        return Err(Error::new(Code::Conflict, message)
            .with_hint("give a mesh `k_wave` and, in [start], mesh_phase = \"speed\""));
    }
    if first_speed(machine, study)? == 0.0 {
        let message = "a chart over speed requires the speed of the setup";
        return Err(Error::new(Code::UndeterminedSpeed, message)
            .with_hint("state the speed of a node in [speed] of the model"));
    }
    Ok(())
}

/// Floquet multipliers and the chart, or the reason why there are none. After cancellation the chart contains the finished rows.
///
/// # Errors
/// Errors of [`check_study`] and of the multipliers; a stiffness that falls to zero or below.
pub fn parametric_stability(
    machine: &PreparedMachine,
    setup: &SimulationSetup,
    study: &StabilityStudy,
    monitor: &mut Monitor,
) -> Result<Result<ParametricResult, String>, Error> {
    check_study(machine, setup, study)?;
    let model = &unforced(&setup.model.model);
    if !has_varying_stiffness(model) {
        return Ok(Err(CONSTANT.to_string()));
    }
    let monodromy = match floquet::monodromy(model, None) {
        Ok(monodromy) => monodromy,
        Err(error) => return Ok(Err(error.message)),
    };
    let multipliers = monodromy.multipliers()?;
    let speed = first_speed(machine, study)?;
    let mut parametric = ParametricResult {
        max_multiplier: multipliers.largest,
        period: monodromy.period,
        speed,
        chart: None,
    };
    let Some(range) = study.speeds else {
        return Ok(Ok(parametric));
    };
    let span = [range.from / speed, range.to / speed];
    let points = range.count as usize;
    let factors: Vec<f64> = match study.over {
        None => vec![1.0],
        Some(over) => over.factors().collect(),
    };
    let cancel = monitor.cancel;
    let monitor = Mutex::new(monitor);
    let row = |&factor: &f64| -> Result<Option<ChartRow>, Error> {
        let (row, scaled) = match study.over {
            None => ("speeds".to_string(), model.clone()),
            Some(over) => (
                format!("{} × {factor:.4}", over.parameter.name()),
                scale_parameter(model, over, factor)?,
            ),
        };
        let can_proceed = monitor
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .proceed(&row);
        if !can_proceed {
            return Ok(None);
        }
        match instability_tongues(&scaled, span, points, cancel) {
            Ok(tongues) => Ok(Some(ChartRow { factor, tongues })),
            Err(error) if error.code == Code::Interrupted => Ok(None),
            Err(error) => Err(error),
        }
    };
    let rows: Vec<ChartRow> = parallel::try_map(&factors, row)?
        .into_iter()
        .flatten()
        .collect();
    if rows.is_empty() {
        return Ok(Ok(parametric));
    }
    parametric.chart = Some(StabilityChart {
        span,
        rows,
        parameter: study.over.map(|o| o.parameter),
        base: std::f64::consts::TAU / parametric.period,
    });
    Ok(Ok(parametric))
}

/// Model without loads and imposed errors: parametric stability and its period depend on the stiffness variation alone.
fn unforced(model: &DynamicModel) -> DynamicModel {
    let mut model = model.clone();
    model.forces.clear();
    model
        .elements
        .iter_mut()
        .for_each(|b| b.imposed_displacement = None);
    model
}

/// Model with a parameter multiplied by a factor.
fn scale_parameter(
    model: &DynamicModel,
    over: ParameterSweep,
    factor: f64,
) -> Result<DynamicModel, Error> {
    let mut model = model.clone();
    match over.parameter {
        SweepParameter::Depth => {
            for wave in model
                .elements
                .iter_mut()
                .filter_map(|b| b.stiffness_wave.as_mut())
            {
                wave.waveform = scale_variation(&wave.waveform, factor);
                if wave.waveform.lower_bound() <= 0.0 {
                    let message = format!(
                        "at {} times its depth a stiffness falls to zero or below",
                        format_number(factor)
                    );
                    return Err(Error::new(Code::OutOfRange, message)
                        .with_hint("lower the upper end of `over`"));
                }
            }
        }
        SweepParameter::Damping => {
            for branch in &mut model.elements {
                match &mut branch.law {
                    ForceLaw::Linear { damping, .. } | ForceLaw::Nonlinear { damping, .. } => {
                        *damping *= factor
                    }
                    ForceLaw::Contact(contact) => contact.damping *= factor,
                    _ => {}
                }
            }
            model.mass_damping *= factor;
            if let Some((_, c)) = &mut model.global_matrices {
                for j in 0..c.ncols() {
                    (0..c.nrows()).for_each(|i| c[(i, j)] *= factor);
                }
            }
        }
    }
    Ok(model)
}

/// Waveform with the same mean and its variation multiplied by a factor.
fn scale_variation(waveform: &Waveform, factor: f64) -> Waveform {
    let mean = waveform.mean();
    let from_mean = |x: f64| mean + factor * (x - mean);
    match waveform {
        Waveform::Rectangular { high, low, duty } => Waveform::Rectangular {
            high: from_mean(*high),
            low: from_mean(*low),
            duty: *duty,
        },
        Waveform::Fourier { mean, terms } => Waveform::Fourier {
            mean: *mean,
            terms: terms.iter().map(|&(n, a, p)| (n, factor * a, p)).collect(),
        },
        Waveform::Table(values) => Waveform::Table(values.iter().map(|&v| from_mean(v)).collect()),
    }
}
