//! Error against run time of frequency responses: line by line, sums over all and over a few modes, reduced machines.
//!
//! The error of a way is the largest difference from the direct solution over all lines, by the largest value of the same
//! output and input; the worst pair counts.

use super::watch::{Watch, interrupted};
use super::ways::{Size, Way, Ways};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::words::counted;
use crate::modes::basis::{self, Basis, Solver as BasisSolver};
use crate::modes::equations::{Case, Equations};
use crate::modes::reduction::{Keep, Method, Reduced};
use crate::numeric::{Complex, ComplexMatrix, Matrix, definite};
use crate::plan::prepared::Prepared;
use crate::plan::response::choice::LINES;
use crate::response::frequency::{Solver, Way as How, difference};
use crate::response::ports::{Input, Output, Ports};
use crate::scene::study::ResponseStudy;

/// Machines beyond this many freedoms are not taken apart into modes.
const DENSE: usize = 1000;

/// Refuses what can be known before any solution.
///
/// # Errors
/// A study without band, input or output; a machine without damping; those of its speed.
pub fn refuse(prepared: &Prepared, study: &ResponseStudy) -> Result<(), Error> {
    asked(prepared, study)?;
    prepared.speeds_at(study.speed).map(|_| ())
}

fn asked(prepared: &Prepared, study: &ResponseStudy) -> Result<((f64, f64), Ports), Error> {
    let Prepared {
        machine, linear, ..
    } = prepared;
    let Some((from, to)) = study.band else {
        return Err(
            Error::new(Code::Usage, "nothing says which frequencies are wanted")
                .hint("add --band 1:500, or `band` to the study"),
        );
    };
    let ports = Ports::read(machine, &study.inputs, &study.outputs, &study.held)?;
    if ports.inputs.is_empty() || ports.outputs.is_empty() {
        return Err(Error::new(Code::Usage, "no input or no output is named")
            .hint("add --input NAME and --output NAME, or `inputs` and `outputs` to the study"));
    }
    if !linear.is_damped(machine) {
        let message = "nothing is damped: at a resonance every response is infinite, and no error can be told";
        return Err(Error::new(Code::Conflict, message)
            .hint("give the machine its damping, in [damping] or beside the stiffnesses"));
    }
    Ok(((from, to), ports))
}

/// Compares every way to the responses a study asks for. Ended early, it gives the ways that were finished.
///
/// # Errors
/// What is missing in the study; an undamped machine; those of the direct solution.
pub fn study(prepared: &Prepared, study: &ResponseStudy, watch: &mut Watch) -> Result<Ways, Error> {
    let Prepared {
        machine, linear, ..
    } = prepared;
    let ((from, to), ports) = asked(prepared, study)?;
    let speeds = prepared.speeds_at(study.speed)?;
    let setting = prepared.setting(speeds.as_deref());
    let lines = study.lines.unwrap_or(LINES).max(2);
    let step = (to - from) / f64::from(lines - 1);
    let omega: Vec<f64> = (0..lines).map(|k| from + step * f64::from(k)).collect();
    let by = |how: How| -> Result<Vec<ComplexMatrix>, Error> {
        let solver = Solver::new(&setting, &ports, how)?;
        omega.iter().map(|&w| solver.at(w)).collect()
    };
    if !watch.goes_on("line by line") {
        return Err(interrupted());
    }
    let exact = by(How::Direct)?;
    let small = linear.n <= DENSE;
    let other = match small {
        true => by(How::Modal).ok(),
        false => None,
    };
    let reference_error = other.map_or(f64::NAN, |other| difference(&other, &exact));
    let floor = match reference_error.is_finite() {
        true => reference_error,
        false => 0.0,
    };
    let judge = |found: Vec<ComplexMatrix>| Ok(difference(&found, &exact).max(floor));
    let mut list = vec![
        Way::taken("line by line", None, || by(How::Direct), judge),
        Way::taken("all modes", None, || by(How::Modal), judge),
    ];
    match (plain(&ports), small) {
        (Some(plain), true) => {
            let basis = basis::solve(linear, BasisSolver::Factored)?;
            let case = Case {
                machine,
                linear,
                basis: &basis,
                speeds: speeds.as_deref(),
            };
            for (method, size, reduce) in reductions(&case, &plain) {
                if !watch.goes_on(method) {
                    break;
                }
                let task = || {
                    let equations = reduce()?;
                    omega
                        .iter()
                        .map(|&w| plain.through(&case, &equations, w))
                        .collect()
                };
                list.push(Way::taken(method, Some(size), task, judge));
            }
        }
        (None, _) => list.push(left_out(
            "reduced machines are compared between torques and motions of single freedoms, nothing held",
        )),
        (_, false) => list.push(left_out(&format!(
            "{} freedoms are not taken apart into modes (limit {DENSE})",
            linear.n
        ))),
    }
    Ok(Ways {
        compared: format!(
            "{} over {} to {:.4} Hz",
            counted(ports.inputs.len() * ports.outputs.len(), "response"),
            counted(lines as usize, "line"),
            to / std::f64::consts::TAU
        ),
        norm: "largest difference over all lines, by the largest value of the same response",
        freedoms: linear.n,
        reference: match small {
            true => "the direct solution, beside a sum over all modes",
            false => "the direct solution",
        }
        .to_string(),
        reference_error: floor,
        list,
        interrupted: watch.stop.is_raised(),
    })
}

fn left_out(why: &str) -> Way {
    Way {
        method: "reduced machines",
        size: None,
        error: None,
        seconds: 0.0,
        failed: Some(why.to_string()),
    }
}

/// Torques on freedoms and motions of freedoms, all that a reduced machine is asked.
struct Plain {
    inputs: Vec<usize>,
    /// The freedom, and how often it is differentiated.
    outputs: Vec<(usize, u8)>,
}

fn plain(ports: &Ports) -> Option<Plain> {
    let inputs = ports.inputs.iter().map(|port| match port.what {
        Input::Torque(freedom) => Some(freedom),
        _ => None,
    });
    let outputs = ports.outputs.iter().map(|port| match &port.what {
        Output::Sum(terms, times) => match terms[..] {
            [(freedom, 1.0)] => Some((freedom, *times)),
            _ => None,
        },
        _ => None,
    });
    Some(Plain {
        inputs: inputs.collect::<Option<_>>()?,
        outputs: outputs.collect::<Option<_>>()?,
    })
    .filter(|_| ports.held.is_empty())
}

impl Plain {
    /// Outputs by inputs through reduced equations.
    fn through(
        &self,
        case: &Case,
        equations: &Equations,
        omega: f64,
    ) -> Result<ComplexMatrix, Error> {
        let s = Complex::new(0.0, omega);
        let sees = |freedom: usize| equations.sees(&case.linear.transform[freedom]);
        let loads: Vec<Vec<f64>> = self.inputs.iter().map(|&f| sees(f)).collect();
        let loads = ComplexMatrix::from_fn(equations.len(), loads.len(), |i, j| {
            Complex::new(loads[j][i], 0.0)
        });
        let x = definite::solve_complex(&equations.dynamic_stiffness(s), &loads)?;
        let rows: Vec<(Vec<f64>, Complex)> = self
            .outputs
            .iter()
            .map(|&(f, times)| (sees(f), s.powu(u32::from(times))))
            .collect();
        Ok(ComplexMatrix::from_fn(
            rows.len(),
            self.inputs.len(),
            |o, i| {
                let (row, factor) = &rows[o];
                let sum: Complex = row.iter().enumerate().map(|(k, a)| x[(k, i)] * a).sum();
                sum * factor
            },
        ))
    }

    /// Coordinates that are loaded or measured, where each freedom follows one alone.
    fn ports(&self, case: &Case) -> Option<Vec<usize>> {
        let freedoms = self.inputs.iter().copied();
        let all = freedoms.chain(self.outputs.iter().map(|o| o.0));
        let mut ports = all
            .map(|f| match case.linear.transform[f][..] {
                [(j, _)] => Some(j),
                _ => None,
            })
            .collect::<Option<Vec<usize>>>()?;
        ports.sort_unstable();
        ports.dedup();
        Some(ports)
    }
}

type Reduce<'a> = Box<dyn Fn() -> Result<Equations, Error> + 'a>;

/// Every reduction over its ladder of sizes.
fn reductions<'a>(case: &'a Case<'a>, plain: &Plain) -> Vec<(&'static str, Size, Reduce<'a>)> {
    let mut all: Vec<(&'static str, Size, Reduce)> = Vec::new();
    let elastic = case.basis.omega.len() - case.basis.n_rigid;
    let ports = plain.ports(case);
    if let Some(masters) = ports.clone() {
        let size = Size::Coordinates(masters.len());
        let reduce = move || {
            let masters = masters.clone();
            Ok(Reduced::new(case, Method::Guyan { masters })?.equations)
        };
        all.push(("static condensation", size, Box::new(reduce)));
    }
    let mut kept = 1;
    while kept < elastic {
        let truncated = move || Ok(lowest(case, case.basis, kept));
        all.push(("modes alone", Size::Modes(kept), Box::new(truncated)));
        if let Some(ports) = ports.clone() {
            let boundary = ports.clone();
            let with_rest = move || {
                let (keep, ports) = (Keep::Count(kept), ports.clone());
                Ok(Reduced::new(case, Method::Modal { keep, ports })?.equations)
            };
            let name = "modes and static residual";
            all.push((name, Size::Modes(kept), Box::new(with_rest)));
            let fixed = move || {
                let (keep, boundary) = (Keep::Count(kept), boundary.clone());
                Ok(Reduced::new(case, Method::CraigBampton { boundary, keep })?.equations)
            };
            all.push(("fixed-interface modes", Size::Modes(kept), Box::new(fixed)));
        }
        kept *= 2;
    }
    all
}

/// The machine over its rigid motions and its lowest elastic modes.
fn lowest(case: &Case, basis: &Basis, kept: usize) -> Equations {
    let columns = (basis.n_rigid + kept).min(basis.shapes.ncols());
    let transform = Matrix::from_fn(basis.shapes.nrows(), columns, |i, j| basis.shapes[(i, j)]);
    Equations::over(case, transform, Vec::new(), basis.n_rigid)
}
