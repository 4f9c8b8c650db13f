//! Runs a frequency response: lines, peaks between them, and what is strained there.

use std::f64::consts::TAU;
use std::time::Instant;

use super::choice::{self, Choice};
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::stop::{Foreseen, Stop};
use crate::base::units::duration;
use crate::base::words::counted;
use crate::modes::basis;
use crate::numeric::Complex;
use crate::plan::linear_stability::UNSTABLE;
use crate::plan::motion::scene::ALLOWED;
use crate::plan::prepared::Prepared;
use crate::plan::run::run as run_modes;
use crate::plan::stages::{self, COMPLEX, Plan, Verdict};
use crate::response::course::course;
use crate::response::direct::Direct;
use crate::response::frequency::{Effort, How, Solver};
use crate::response::peaks::{self, Peak};
use crate::response::ports::{Output, Port, Ports};
use crate::response::system::{Setting, held_frequencies};
use crate::scene::study::{ModesStudy, ResponseKind, ResponseStudy};

/// Frequency responses with their peaks.
pub struct Answer {
    /// Hz.
    pub frequency_hz: Vec<f64>,
    /// Of every input and output.
    pub pairs: Vec<Pair>,
    /// Frequencies of the pictures' lines, Hz: closer where the curves need it; empty unless pictures are wanted.
    pub drawn_hz: Vec<f64>,
    /// Why it was found so.
    pub choice: Choice,
    /// How it was found.
    pub how: How,
    /// What it took.
    pub effort: Effort,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, Verdict)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// A response of one output to one input.
pub struct Pair {
    /// The input.
    pub input: String,
    /// The output.
    pub output: String,
    /// The unit, `rad/(N·m)`; 1 where both are alike.
    pub unit: String,
    /// By line.
    pub value: Vec<Complex>,
    /// By line of the pictures.
    pub drawn: Vec<Complex>,
    /// At 0 Hz, where that exists and is not zero.
    pub at_rest: Option<f64>,
    /// Peaks, ascending.
    pub peaks: Vec<Strained>,
}

/// A peak and what is strained there.
pub struct Strained {
    /// The peak.
    pub peak: Peak,
    /// The element with the largest share of the strain energy, and the share.
    pub mostly: Option<(usize, f64)>,
}

/// What a study asks for: its band, rad/s, its inputs and outputs.
fn asked(prepared: &Prepared, study: &ResponseStudy) -> Result<((f64, f64), Ports), Error> {
    let Some(band) = study.band else {
        return Err(
            Error::new(Code::Usage, "nothing says which frequencies are wanted")
                .hint("add --band 1:500, or `band` to the study"),
        );
    };
    let ports = Ports::read(
        &prepared.machine,
        &study.inputs,
        &study.outputs,
        &study.held,
    )?;
    for (list, flag, example) in [
        (ports.inputs.len(), "input", "motor.theta"),
        (ports.outputs.len(), "output", "workpiece.theta"),
    ] {
        if list == 0 {
            let hint = format!(
                "add --{flag} NAME, or `{flag}s` to the study; names are such as {example}"
            );
            return Err(Error::new(Code::Usage, format!("no {flag} is named")).hint(hint));
        }
    }
    Ok((band, ports))
}

/// Refuses what [`run`] would refuse before it solves anything.
///
/// # Errors
/// What is missing in the study; names that do not exist; speeds that do not fit; what would take too long.
pub fn refuse(prepared: &Prepared, study: &ResponseStudy) -> Result<(), Error> {
    asked(prepared, study)?;
    prepared.speeds_at(study.speed)?;
    choice::refuse(prepared, study, &choice::choose(prepared, study))
}

/// Runs a study; `drawn`: pictures are wanted of it.
///
/// # Errors
/// What is missing in the study; names that do not exist; those of the solution.
pub fn run(prepared: &Prepared, study: &ResponseStudy, drawn: bool) -> Result<Answer, Error> {
    let start = Instant::now();
    let Prepared {
        machine, linear, ..
    } = prepared;
    let ((from, to), mut ports) = asked(prepared, study)?;
    ports
        .outputs
        .iter_mut()
        .for_each(|port| shown_as(port, study.shown));
    let speeds = prepared.speeds_at(study.speed)?;
    let setting = prepared.setting(speeds.as_deref());
    let choice = choice::choose(prepared, study);
    choice::refuse(prepared, study, &choice)?;
    let lines = study.lines.unwrap_or(choice::LINES);
    let step = (to - from) / f64::from(lines - 1);
    let omega: Vec<f64> = (0..lines)
        .map(|k| {
            if k + 1 == lines {
                to
            } else {
                from + step * f64::from(k)
            }
        })
        .collect();
    let mut solver = Solver::new(&setting, &ports, choice.way)?;
    solver.check(&omega)?;
    let allowed = Stop::default().allowing(ALLOWED);
    let line = |(k, &w): (usize, &f64)| {
        let done = k as f64 / omega.len() as f64;
        match allowed.foresees(done) {
            Some(foreseen) => Err(too_long(foreseen, k)),
            None => solver.at(w),
        }
    };
    let lined = omega.iter().enumerate().map(line);
    let values = lined.collect::<Result<Vec<_>, Error>>()?;

    let natural = natural(prepared, &ports, (from, to));
    let strain = Strain::new(&setting, &ports)?;
    let damped = linear.is_damped(machine);
    let mut pairs = Vec::new();
    for (i, input) in ports.inputs.iter().enumerate() {
        for (o, output) in ports.outputs.iter().enumerate() {
            let value: Vec<Complex> = values.iter().map(|h| h[(o, i)]).collect();
            let sizes: Vec<(f64, f64)> = omega
                .iter()
                .zip(&value)
                .map(|(&w, z)| (w, z.norm()))
                .collect();
            let height = |w: f64| Ok(solver.at(w)?[(o, i)].norm());
            let found = match damped {
                true => peaks::peaks(&sizes, &natural, height)?,
                false => Vec::new(),
            };
            // A force at rest that only rounding leaves is none.
            let largest = sizes.iter().fold(0.0f64, |m, s| m.max(s.1));
            let at_rest = solver.at(0.0).ok().map(|h| h[(o, i)].norm());
            let strained = |peak: Peak| {
                Ok(Strained {
                    mostly: strain.mostly(peak.omega, i)?,
                    peak,
                })
            };
            pairs.push(Pair {
                input: input.name.clone(),
                output: output.name.clone(),
                drawn: Vec::new(),
                unit: per(output.unit, input.unit),
                at_rest: at_rest.filter(|h| *h > ROUNDING * largest),
                value,
                peaks: found
                    .into_iter()
                    .map(strained)
                    .collect::<Result<_, Error>>()?,
            });
        }
    }
    let mut drawn_hz = Vec::new();
    if drawn {
        let course = course(&omega, values, &widths(&pairs), |w| solver.at(w));
        drawn_hz = course.omega.iter().map(|w| w / TAU).collect();
        for (k, pair) in pairs.iter_mut().enumerate() {
            let (i, o) = (k / ports.outputs.len(), k % ports.outputs.len());
            pair.drawn = course.values.iter().map(|h| h[(o, i)]).collect();
        }
    }
    let mut warnings = prepared.warnings();
    warnings.extend(unstable(prepared, study.speed)?);
    if !damped {
        warnings.push(Warning {
            code: "undamped",
            message: "nothing damps this machine: its peaks are infinite and none is listed".to_string(),
            hint: Some("give branches a damping_ratio or c, or see `geardyn modes` for the natural frequencies".to_string()),
        });
    }
    Ok(Answer {
        frequency_hz: omega.iter().map(|w| w / TAU).collect(),
        drawn_hz,
        pairs,
        how: solver.how(),
        effort: Effort {
            seconds: start.elapsed().as_secs_f64(),
            ..solver.effort
        },
        plan: choice::plan(prepared, study),
        choice,
        warnings,
    })
}

/// The warning of roots that grow, where anything could feed them.
fn unstable(prepared: &Prepared, speed: Option<f64>) -> Result<Option<Warning>, Error> {
    let (machine, linear) = (&prepared.machine, &prepared.linear);
    let turns = speed.is_some_and(|speed| speed != 0.0) && !machine.spins.is_empty();
    let fed = linear
        .branches
        .iter()
        .any(|b| b.damping < 0.0 || b.loss_factor < 0.0 || b.force.is_some());
    if !(turns || fed || !linear.is_sum_of_squares()) || linear.n > COMPLEX {
        return Ok(None);
    }
    let study = ModesStudy {
        damped: true,
        speed: speed.filter(|_| turns),
        ..ModesStudy::default()
    };
    let answer = run_modes(prepared, &study, &Plan::modes(prepared, &study))?;
    Ok(answer.warnings.into_iter().find(|w| w.code == UNSTABLE))
}

fn too_long(foreseen: Foreseen, lines: usize) -> Error {
    let message = format!(
        "{} took {}; {}",
        counted(lines, "line"),
        duration(foreseen.spent),
        foreseen.told()
    );
    Error::new(Code::Hopeless, message)
        .hint("ask for fewer --lines, or model the machine with fewer coordinates")
}

/// Places and half-power widths of all peaks, rad/s; where a neighbour hides the width, a hundredth of the place.
fn widths(pairs: &[Pair]) -> Vec<(f64, f64)> {
    const HIDDEN: f64 = 1e-2;
    let all = pairs.iter().flat_map(|p| &p.peaks).map(|s| s.peak);
    let width = |p: Peak| {
        p.half_power
            .map_or(HIDDEN * p.omega, |(low, high)| high - low)
    };
    let mut all: Vec<(f64, f64)> = all.map(|p| (p.omega, width(p))).collect();
    // Peaks of several responses at one mode have one circle.
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.dedup_by(|a, b| (a.0 - b.0).abs() < 0.1 * b.1);
    all
}

/// Of the largest value of a response: at rest less is rounding.
const ROUNDING: f64 = 1e-9;

/// A motion as displacement, speed or acceleration.
fn shown_as(port: &mut Port<Output>, shown: Option<ResponseKind>) {
    let (Output::Sum(_, times), Some(shown)) = (&mut port.what, shown) else {
        return;
    };
    let turns = port.unit.starts_with("rad");
    (*times, port.unit) = match (shown, turns) {
        (ResponseKind::Receptance, true) => (0, "rad"),
        (ResponseKind::Receptance, false) => (0, "m"),
        (ResponseKind::Mobility, true) => (1, "rad/s"),
        (ResponseKind::Mobility, false) => (1, "m/s"),
        (ResponseKind::Accelerance, true) => (2, "rad/s²"),
        (ResponseKind::Accelerance, false) => (2, "m/s²"),
    };
}

/// One unit per another.
fn per(output: &str, input: &str) -> String {
    match (output == input, input.contains(['·', '/'])) {
        (true, _) => "1".to_string(),
        (false, true) => format!("{output}/({input})"),
        (false, false) => format!("{output}/{input}"),
    }
}

/// Natural frequencies in the band, rad/s, with what is prescribed free: near enough for a search; none of a large machine.
pub fn natural(prepared: &Prepared, ports: &Ports, (from, to): (f64, f64)) -> Vec<f64> {
    const MOST: usize = 400;
    if prepared.linear.n > MOST {
        return Vec::new();
    }
    let held = prepared.setting(None);
    let solver = stages::solver(prepared.linear.n);
    let omega = held_frequencies(&held, ports, solver)
        .or_else(|_| basis::solve(&prepared.linear, solver).map(|b| b.omega))
        .unwrap_or_default();
    omega.into_iter().filter(|w| *w > from && *w < to).collect()
}

/// What every spring is strained by each input.
pub(super) struct Strain<'a> {
    direct: Direct,
    /// Element and stiffness of every output.
    springs: Vec<(usize, f64)>,
    setting: Setting<'a>,
}

impl<'a> Strain<'a> {
    pub fn new(setting: &Setting<'a>, ports: &Ports) -> Result<Strain<'a>, Error> {
        let springs: Vec<_> = setting
            .linear
            .branches
            .iter()
            .filter(|b| b.stiffness > 0.0)
            .collect();
        let outputs = springs.iter().map(|b| Port {
            name: setting.machine.branch_name(b.index),
            unit: "",
            what: Output::Deflection(b.index),
        });
        let ports = Ports {
            outputs: outputs.collect(),
            ..ports.clone()
        };
        let springs = springs
            .iter()
            .map(|b| (setting.machine.branches[b.index].element, b.stiffness))
            .collect();
        Ok(Strain {
            direct: Direct::new(setting, &ports)?,
            springs,
            setting: *setting,
        })
    }

    /// The element with most of the strain energy.
    fn mostly(&self, omega: f64, input: usize) -> Result<Option<(usize, f64)>, Error> {
        let mut energy = vec![0.0; self.setting.machine.elements.len()];
        for (element, share) in self.energies(omega, &[(input, Complex::new(1.0, 0.0))])? {
            energy[element] += share;
        }
        let total: f64 = energy.iter().sum();
        let largest = (0..energy.len()).max_by(|&a, &b| energy[a].total_cmp(&energy[b]));
        Ok(largest
            .filter(|_| total > 0.0)
            .map(|element| (element, energy[element] / total)))
    }

    /// Of every spring its element and twice the energy that inputs of these amplitudes put into it, J.
    pub fn energies(
        &self,
        omega: f64,
        inputs: &[(usize, Complex)],
    ) -> Result<Vec<(usize, f64)>, Error> {
        let deflections = self.direct.at(omega)?;
        let of = |(row, &(element, stiffness)): (usize, &(usize, f64))| {
            let zero = Complex::new(0.0, 0.0);
            let delta = inputs.iter().fold(zero, |sum, &(input, size)| {
                sum + deflections[(row, input)] * size
            });
            (element, stiffness * delta.norm_sqr())
        };
        Ok(self.springs.iter().enumerate().map(of).collect())
    }
}
