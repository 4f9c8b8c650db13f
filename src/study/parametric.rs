//! Parametric stability: what a stiffness that varies at imposed speed feeds, over speed and a second parameter.

use super::watch::Watch;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::figure;
use crate::machine::kinematics::mean_speeds;
use crate::motion::floquet::{self, chart::Tongue, chart::tongues};
use crate::motion::train::{Law, Train};
use crate::plan::motion::scene::MotionScene;
use crate::plan::prepared::Prepared;
use crate::scene::laws::Shape;
use crate::scene::study::{Over, Parameter, StabilityStudy};

/// Parametric stability.
pub struct Parametric {
    /// The largest Floquet multiplier at the scene's speed, but those of free turning.
    pub largest: f64,
    /// The period, s.
    pub period: f64,
    /// Speed of the first node of `[speed]`, rad/s.
    pub speed: f64,
    /// Unstable speeds, where a chart was asked.
    pub chart: Option<Chart>,
}

/// Unstable speeds.
pub struct Chart {
    /// The first and the last speed looked at, as factors of the scene's.
    pub span: [f64; 2],
    /// By the second parameter; one row at the scene's own where there is none.
    pub rows: Vec<Row>,
    /// What the rows go over.
    pub over: Option<Parameter>,
    /// The frequency with which the whole machine repeats at the scene's speed, rad/s.
    pub base: f64,
}

/// Unstable speeds at one value of the second parameter.
pub struct Row {
    /// The factor on what the scene has.
    pub factor: f64,
    /// By rising speed.
    pub tongues: Vec<Tongue>,
}

const CONSTANT: &str = "no stiffness varies at an imposed speed";

fn varies(train: &Train) -> bool {
    let mut waves = train.branches.iter().filter_map(|b| b.variation.as_ref());
    waves.any(|w| w.phase.angle().is_none())
}

/// Speed of the first node of `[speed]`, rad/s.
fn first_speed(prepared: &Prepared, study: &StabilityStudy) -> Result<f64, Error> {
    let speeds = mean_speeds(&prepared.machine, &prepared.kinematics, study.motion.speed)?;
    Ok(prepared.machine.speeds.first().map_or(0.0, |s| speeds[s.0]))
}

/// Refuses a chart that has nothing to show.
///
/// # Errors
/// A chart where no stiffness varies, or without a speed to start from.
pub fn refuse(
    prepared: &Prepared,
    scene: &MotionScene,
    study: &StabilityStudy,
) -> Result<(), Error> {
    if study.speeds.is_none() {
        return Ok(());
    }
    if !varies(&scene.moving.train) {
        let message = format!("{CONSTANT}: there is nothing to chart");
        return Err(Error::new(Code::Conflict, message)
            .hint("give a mesh `k_wave` and, in [start], mesh_phase = \"speed\""));
    }
    if first_speed(prepared, study)? == 0.0 {
        let message = "a chart over speed needs the speed of the scene to start from";
        return Err(Error::new(Code::NoSpeed, message)
            .hint("state the speed of a node in [speed] of the model"));
    }
    Ok(())
}

/// Floquet's multipliers and the chart; or why there are none. Ended early, the chart holds the rows that were finished.
///
/// # Errors
/// A chart without a speed to start from, or with a stiffness below zero; those of the multipliers.
pub fn study(
    prepared: &Prepared,
    scene: &MotionScene,
    study: &StabilityStudy,
    watch: &mut Watch,
) -> Result<Result<Parametric, String>, Error> {
    refuse(prepared, scene, study)?;
    let train = &unforced(&scene.moving.train);
    if !varies(train) {
        return Ok(Err(CONSTANT.to_string()));
    }
    let monodromy = match floquet::monodromy(train, None) {
        Ok(monodromy) => monodromy,
        Err(error) => return Ok(Err(error.message)),
    };
    let multipliers = monodromy.multipliers()?;
    let speed = first_speed(prepared, study)?;
    let mut parametric = Parametric {
        largest: multipliers.largest,
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
    let mut rows = Vec::new();
    for factor in factors {
        let (row, changed) = match study.over {
            None => ("speeds".to_string(), train.clone()),
            Some(over) => (
                format!("{} × {factor:.4}", over.parameter.name()),
                changed(train, over, factor)?,
            ),
        };
        if !watch.goes_on(&row) {
            break;
        }
        match tongues(&changed, span, points, watch.stop) {
            Ok(tongues) => rows.push(Row { factor, tongues }),
            Err(error) if error.code == Code::Interrupted => break,
            Err(error) => return Err(error),
        }
    }
    if rows.is_empty() {
        return Ok(Ok(parametric));
    }
    parametric.chart = Some(Chart {
        span,
        rows,
        over: study.over.map(|o| o.parameter),
        base: std::f64::consts::TAU / parametric.period,
    });
    Ok(Ok(parametric))
}

/// The machine without loads and imposed errors: what grows by itself does so whatever acts, and repeats with the stiffness alone.
fn unforced(train: &Train) -> Train {
    let mut train = train.clone();
    train.drives.clear();
    train.branches.iter_mut().for_each(|b| b.imposed = None);
    train
}

/// The machine with a parameter times a factor.
fn changed(train: &Train, over: Over, factor: f64) -> Result<Train, Error> {
    let mut train = train.clone();
    match over.parameter {
        Parameter::Depth => {
            for wave in train
                .branches
                .iter_mut()
                .filter_map(|b| b.variation.as_mut())
            {
                wave.shape = deeper(&wave.shape, factor);
                if wave.shape.least() <= 0.0 {
                    let message = format!(
                        "at {} times its depth a stiffness falls to zero or below",
                        figure(factor)
                    );
                    return Err(Error::new(Code::OutOfRange, message)
                        .hint("end the range of `over` sooner"));
                }
            }
        }
        Parameter::Damping => {
            for branch in &mut train.branches {
                match &mut branch.law {
                    Law::Linear { damping, .. } | Law::Nonlinear { damping, .. } => {
                        *damping *= factor
                    }
                    Law::Contact(contact) => contact.damping *= factor,
                    _ => {}
                }
            }
            train.drag *= factor;
            if let Some((_, c)) = &mut train.general {
                for j in 0..c.ncols() {
                    (0..c.nrows()).for_each(|i| c[(i, j)] *= factor);
                }
            }
        }
    }
    Ok(train)
}

/// A wave with the same mean that goes further from it.
fn deeper(shape: &Shape, factor: f64) -> Shape {
    let mean = shape.mean();
    let from_mean = |x: f64| mean + factor * (x - mean);
    match shape {
        Shape::Rectangular { high, low, duty } => Shape::Rectangular {
            high: from_mean(*high),
            low: from_mean(*low),
            duty: *duty,
        },
        Shape::Fourier { mean, terms } => Shape::Fourier {
            mean: *mean,
            terms: terms.iter().map(|&(n, a, p)| (n, factor * a, p)).collect(),
        },
        Shape::Table(values) => Shape::Table(values.iter().map(|&v| from_mean(v)).collect()),
    }
}
