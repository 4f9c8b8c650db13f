//! A scene ready to move: equations, start, wanted outputs.

use super::wanted::outputs;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::kinematics::{Kinematics, mean_speeds};
use crate::machine::linear::Linear;
use crate::machine::operating::Operating;
use crate::machine::parts::Machine;
use crate::machine::spin::spinning;
use crate::motion::assemble::assemble;
use crate::motion::moving::Moving;
use crate::motion::outputs::Outputs;
use crate::motion::problem::Problem;
use crate::motion::start;
use crate::plan::prepared::Prepared;
use crate::scene::laws::{Curve, Drive};
use crate::scene::start::Start;
use crate::scene::study::SimulateStudy;

/// A scene ready to move.
pub struct MotionScene {
    /// The equations.
    pub moving: Moving,
    /// The state at zero.
    pub start: Vec<f64>,
    /// What is wanted of the motion.
    pub outputs: Outputs,
    /// To this instant, s.
    pub until: f64,
    /// How many equal steps the outputs divide the time into.
    pub samples: usize,
    /// How long the work may take, s.
    pub allowed: f64,
}

/// Samples where a study names no number.
pub const SAMPLES: u32 = 1000;

/// Seconds that the work of a motion may take where a study names no time.
pub const ALLOWED: f64 = 3600.0;

impl MotionScene {
    /// Assembles, finds the start, resolves the outputs.
    ///
    /// # Errors
    /// What has no motion in time; names that do not exist; a study without an end.
    pub fn new(
        prepared: &Prepared,
        begin: &Start,
        study: &SimulateStudy,
    ) -> Result<MotionScene, Error> {
        let Some(until) = study.until else {
            let error = Error::new(Code::MissingKey, "nothing says how long the motion lasts");
            return Err(error.hint("add --until \"2 s\", or `until` to the study"));
        };
        if !(until.is_finite() && until > 0.0) {
            let error = Error::new(
                Code::OutOfRange,
                format!("a motion until {until} s cannot be"),
            );
            return Err(error.hint("--until takes a time above zero"));
        }
        let Prepared {
            machine,
            kinematics,
            ..
        } = prepared;
        let speeds = match machine.speeds.is_empty() && study.speed.is_none() {
            true => None,
            false => Some(spinning(machine, kinematics, study.speed)?),
        };
        let shifted;
        let machine = match study.speed {
            None => machine,
            Some(_) => {
                shifted = at_speed(machine, kinematics, speeds.as_deref())?;
                &shifted
            }
        };
        let moving = assemble(machine, kinematics, begin, speeds.as_deref())?;
        let linear = Linear::new(machine, kinematics, &Operating::default())?;
        let mut start = start::state(&moving, &linear, speeds.as_deref(), begin.at, 0.0)?;
        let n = moving.train.n();
        let carried = moving.carried(0.0);
        for (list, offset) in [(&begin.angles, 0), (&begin.speeds, n)] {
            for (name, value) in list {
                let stays = machine
                    .freedom(&name.text)
                    .and_then(|f| linear.free.iter().position(|&i| i == f));
                if let Some(None) = stays.map(|i| moving.place(i)) {
                    let message = format!(
                        "`{}` has no start of its own: it moves as a motor prescribes, or has no inertia and follows its neighbours",
                        name.text
                    );
                    return Err(Error::new(Code::Conflict, message)
                        .at(&name.place)
                        .hint("leave its start out"));
                }
                let Some(j) = stays.and_then(|i| moving.place(i)) else {
                    let message = format!(
                        "`{}` is no freedom that stays: rigid joints tie it to another, or it does not exist",
                        name.text
                    );
                    let hint = format!(
                        "name one of {}",
                        crate::base::words::listed(
                            moving.train.coordinates.iter().map(String::as_str)
                        )
                    );
                    return Err(Error::new(Code::NoSuchFreedom, message)
                        .at(&name.place)
                        .hint(hint));
                };
                let known = if offset == 0 {
                    carried[j].0
                } else {
                    carried[j].1
                };
                start[offset + j] = *value - known;
            }
        }
        let outputs = outputs(prepared, &moving, &study.outputs)?;
        let samples = study.samples.unwrap_or(SAMPLES) as usize;
        debug_assert_eq!(start.len(), moving.train.len());
        Ok(MotionScene {
            moving,
            start,
            outputs,
            until,
            samples,
            allowed: study.allow.unwrap_or(ALLOWED),
        })
    }
}

/// The machine with its motors set to other speeds, as a converter does: the same torque at the same slip.
fn at_speed(
    machine: &Machine,
    kinematics: &Kinematics,
    speeds: Option<&[f64]>,
) -> Result<Machine, Error> {
    let mut machine = machine.clone();
    let before = match machine.speeds.is_empty() {
        true => None,
        false => Some(mean_speeds(&machine, kinematics, None)?),
    };
    for motor in &mut machine.motors {
        let speed = |list: Option<&[f64]>| list.map_or(0.0, |s| s[motor.freedom]);
        let (old, new) = (speed(before.as_deref()), speed(speeds));
        match &mut motor.drive {
            Drive::Curve { curve, .. } => *curve = shifted(curve, new - old),
            Drive::Speed(course) if old != 0.0 => {
                course.points.iter_mut().for_each(|p| p.1 *= new / old);
            }
            Drive::Speed(_) | Drive::Angle(_) => {}
        }
    }
    Ok(machine)
}

/// A torque curve moved along its speeds.
fn shifted(curve: &Curve, by: f64) -> Curve {
    match curve {
        Curve::Straight { stall, idle } => Curve::Straight {
            stall: stall * (idle + by) / idle,
            idle: idle + by,
        },
        Curve::Induction {
            pull_out,
            slip,
            synchronous,
        } => Curve::Induction {
            pull_out: *pull_out,
            slip: slip * synchronous / (synchronous + by),
            synchronous: synchronous + by,
        },
        Curve::Table(points) => Curve::Table(points.iter().map(|p| (p.0 + by, p.1)).collect()),
    }
}
