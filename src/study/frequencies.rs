//! Error against run time of the lowest natural frequencies: every way to solve for them, and what approximations of the
//! machine cost: fewer coordinates, shafts cut in fewer lengths.
//!
//! The error of a way is the largest relative error of the frequencies asked for. Solvers and reductions are measured against
//! the machine as written; lengths against the limit of ever finer ones, by Richardson's extrapolation of second order.

use super::timing::least;
use super::watch::{Watch, interrupted};
use super::ways::{Size, Way, Ways};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::words::counted;
use crate::machine::linear::Linear;
use crate::modes::basis::{self, Basis, Solver};
use crate::modes::equations::{Case, Equations};
use crate::modes::lowest::{self, Wanted};
use crate::modes::reduction::{Keep, Method, Reduced, frequencies};
use crate::numeric::{Matrix, definite};
use crate::plan::prepared::Prepared;
use crate::scene::model::{BarMass, Model, ShaftBody};

/// Modes compared where nobody says.
pub const USUAL: usize = 10;

/// Machines beyond this many freedoms are not decomposed whole.
const DENSE: usize = 1000;

/// Machines beyond this many freedoms are not built for a comparison of lengths.
const LONGEST: usize = 100_000;

/// Lengths of the ladder; the last two give the reference.
const LENGTHS: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, 128];

/// Refuses machines without frequencies to compare.
///
/// # Errors
/// A machine whose strain energy is no sum of squares, or without elastic modes.
pub fn refuse(prepared: &Prepared) -> Result<(), Error> {
    if !prepared.linear.is_sum_of_squares() {
        let message =
            "stiffnesses that are negative or act across have no undamped frequencies to compare";
        return Err(Error::new(Code::Conflict, message)
            .hint("state the machine without them, or ask for its motion"));
    }
    if elastic_modes(&prepared.linear) == 0 {
        let message = "the machine has no elastic mode";
        return Err(
            Error::new(Code::OutOfRange, message).hint("give its shafts or meshes a stiffness")
        );
    }
    Ok(())
}

fn elastic_modes(linear: &Linear) -> usize {
    linear.n - linear.massless.len() - linear.rigid.len()
}

/// Compares every way to the lowest elastic frequencies. Ended early, it gives the ways that were finished.
///
/// # Errors
/// Those of [`refuse`]; those of the reference.
pub fn study(model: &Model, count: usize, watch: &mut Watch) -> Result<Ways, Error> {
    let prepared = Prepared::new(model)?;
    let linear = &prepared.linear;
    refuse(&prepared)?;
    let count = count.min(elastic_modes(linear));
    if !watch.goes_on("reference") {
        return Err(interrupted());
    }
    let whole = linear.n <= DENSE;
    let basis = match whole {
        true => Some(basis::solve(linear, Solver::Factored)?),
        false => None,
    };
    let (omega, digits) = match &basis {
        Some(basis) => elastic_of(basis, count),
        None => found_few(&prepared, count)?,
    };
    let truth = Truth {
        omega,
        error: 10f64.powf(-digits),
    };
    let mut ways = Vec::new();
    let mut add =
        |method: &'static str, size, task: &mut dyn FnMut() -> Result<Vec<f64>, Error>| {
            if !watch.goes_on(method) {
                return;
            }
            ways.push(Way::taken(method, size, task, |found| truth.judge(found)));
        };
    add("lowest modes only", None, &mut || {
        found_few(&prepared, count).map(|f| f.0)
    });
    let dense: [(&'static str, Task); 3] = [
        ("all modes, graded", &|| {
            basis::solve(linear, Solver::Factored).map(|b| elastic_of(&b, count).0)
        }),
        ("all modes, singular values", &|| {
            basis::solve(linear, Solver::Singular).map(|b| elastic_of(&b, count).0)
        }),
        ("all modes, assembled K", &|| {
            assembled(&prepared, basis.as_ref(), count)
        }),
    ];
    for (name, way) in dense {
        match whole {
            true => add(name, None, &mut || way()),
            false => add(name, None, &mut || Err(too_large(linear.n))),
        }
    }
    if let Some(basis) = &basis {
        let case = Case {
            machine: &prepared.machine,
            linear,
            basis,
            speeds: None,
        };
        let order = softest(linear);
        for kept in ladder(count, order.len()) {
            add(
                "static condensation",
                Some(Size::Coordinates(kept)),
                &mut || {
                    let masters = order[..kept].to_vec();
                    reduced(&case, Method::Guyan { masters }, count)
                },
            );
            add(
                "fixed-interface modes",
                Some(Size::Coordinates(kept)),
                &mut || {
                    let boundary = order[..BOUNDARY.min(kept)].to_vec();
                    let keep = Keep::Count(kept - boundary.len());
                    reduced(&case, Method::CraigBampton { boundary, keep }, count)
                },
            );
        }
    }
    ways.extend(lengths(model, count, watch));
    let highest = truth.omega.last().copied().unwrap_or(0.0);
    Ok(Ways {
        compared: format!(
            "the lowest {} to {:.4} Hz",
            counted(count, "elastic mode"),
            highest / std::f64::consts::TAU
        ),
        norm: "largest relative error of the frequencies; of shafts in lengths, against the limit of ever finer ones",
        freedoms: linear.n,
        reference: match whole {
            true => "all modes of the graded factor",
            false => "the lowest modes by elimination",
        }
        .to_string(),
        reference_error: truth.error,
        list: ways,
        interrupted: watch.stop.is_raised(),
    })
}

/// Finds frequencies, rad/s.
type Task<'a> = &'a dyn Fn() -> Result<Vec<f64>, Error>;

/// What frequencies are compared with.
struct Truth {
    /// rad/s.
    omega: Vec<f64>,
    /// Their own relative error, below which none can be told.
    error: f64,
}

/// Coordinates that keep their place where the rest is replaced by modes.
const BOUNDARY: usize = 2;

impl Truth {
    /// How far frequencies are off, where all are there.
    fn judge(&self, found: Vec<f64>) -> Result<f64, String> {
        match found.len() < self.omega.len() {
            true => Err(format!(
                "gives {} of {} modes",
                found.len(),
                self.omega.len()
            )),
            false => Ok(worst(&found, &self.omega).max(self.error)),
        }
    }
}

fn worst(found: &[f64], truth: &[f64]) -> f64 {
    found
        .iter()
        .zip(truth)
        .fold(0.0, |m, (f, t)| ((f - t).abs() / t).max(m))
}

/// The lowest elastic frequencies of all, rad/s, and the digits of the poorest.
fn elastic_of(basis: &Basis, count: usize) -> (Vec<f64>, f64) {
    let range = basis.n_rigid..basis.n_rigid + count;
    let digits = basis.digits[range.clone()]
        .iter()
        .fold(f64::INFINITY, |m, d| m.min(*d));
    (basis.omega[range].to_vec(), digits)
}

fn found_few(prepared: &Prepared, count: usize) -> Result<(Vec<f64>, f64), Error> {
    let wanted = Wanted {
        count: count + prepared.linear.rigid.len(),
        near: None,
    };
    let found = lowest::find(&prepared.linear, prepared.forest.as_ref(), wanted)?;
    let elastic: Vec<_> = found.modes.iter().filter(|m| !m.rigid).collect();
    let digits = elastic.iter().fold(f64::INFINITY, |m, e| m.min(e.digits));
    Ok((elastic.iter().map(|m| m.omega()).collect(), digits))
}

/// By the textbook's way: K and M assembled, one symmetric eigenvalue problem.
fn assembled(prepared: &Prepared, basis: Option<&Basis>, count: usize) -> Result<Vec<f64>, Error> {
    let Some(basis) = basis else {
        return Err(too_large(prepared.linear.n));
    };
    let linear = &prepared.linear;
    let case = Case {
        machine: &prepared.machine,
        linear,
        basis,
        speeds: None,
    };
    let identity = Matrix::identity(linear.n, linear.n);
    let equations = Equations::over(&case, identity, Vec::new(), 0);
    let values = definite::pencil(&equations.stiffness, &equations.mass)?.values;
    let elastic = values.iter().skip(linear.rigid.len()).take(count);
    Ok(elastic.map(|v| v.max(0.0).sqrt()).collect())
}

fn reduced(case: &Case, method: Method, count: usize) -> Result<Vec<f64>, Error> {
    let reduced = Reduced::new(case, method)?;
    let all = frequencies(case.linear, &reduced.equations)?;
    let rigid = case.linear.rigid.len();
    Ok(all.into_iter().skip(rigid).take(count).collect())
}

fn too_large(n: usize) -> Error {
    let message = format!("{n} freedoms are not decomposed whole (limit {DENSE})");
    Error::new(Code::Hopeless, message)
}

/// Coordinates with inertia by rising `k_ii/m_ii`: the softest and heaviest are kept first.
///
/// Henshell and Ong, Earthquake Engineering and Structural Dynamics 3 (1975), pp. 375–383.
fn softest(linear: &Linear) -> Vec<usize> {
    let (mut k, mut m) = (vec![0.0; linear.n], vec![0.0; linear.n]);
    for branch in &linear.branches {
        for (i, a) in branch.direction.scaled() {
            k[i] += branch.stiffness * a * a;
        }
    }
    for mass in &linear.masses {
        for (i, a) in mass.direction.scaled() {
            m[i] += mass.value * a * a;
        }
    }
    let mut order: Vec<usize> = (0..linear.n).filter(|&i| m[i] > 0.0).collect();
    order.sort_by(|&a, &b| (k[a] / m[a]).total_cmp(&(k[b] / m[b])));
    order
}

/// Doubling from what is just enough, below all.
fn ladder(count: usize, all: usize) -> Vec<usize> {
    let mut sizes = Vec::new();
    let mut size = count + BOUNDARY;
    while size < all {
        sizes.push(size);
        size *= 2;
    }
    sizes
}

/// Every shaft with a mass of its own cut in more and more lengths.
fn lengths(model: &Model, count: usize, watch: &mut Watch) -> Vec<Way> {
    const NAME: &str = "shafts in lengths";
    let cut = model.shafts.iter().any(|s| weighs(&s.body));
    if !cut {
        return Vec::new();
    }
    let mut rungs: Vec<(usize, Result<Vec<f64>, Error>, f64)> = Vec::new();
    for lengths in LENGTHS {
        if !watch.goes_on(NAME) {
            return Vec::new();
        }
        let finer = with_lengths(model, lengths);
        let (found, seconds) = least(|| {
            let prepared = Prepared::new(&finer)?;
            if prepared.linear.n > LONGEST {
                return Err(too_large(prepared.linear.n));
            }
            found_few(&prepared, count).map(|f| f.0)
        });
        let ends = found.is_err();
        rungs.push((lengths, found, seconds));
        if ends && lengths > 1 {
            break;
        }
    }
    // The two finest whose modes are all there.
    let whole: Vec<&Vec<f64>> = rungs
        .iter()
        .filter_map(|r| r.1.as_ref().ok())
        .filter(|f| f.len() == count)
        .collect();
    let [.., coarse, fine] = whole[..] else {
        return Vec::new();
    };
    let omega: Vec<f64> = fine
        .iter()
        .zip(coarse)
        .map(|(f, c)| f + (f - c) / 3.0)
        .collect();
    // What is left after the extrapolation is of fourth order.
    let error = worst(fine, &omega).powi(2);
    let limit = Truth { omega, error };
    // The finest gave the limit: its own error cannot be told from it.
    rungs.pop();
    rungs
        .into_iter()
        .map(|(lengths, found, seconds)| {
            Way::judged(NAME, Some(Size::Lengths(lengths)), found, seconds, |f| {
                limit.judge(f)
            })
        })
        .collect()
}

fn weighs(body: &Option<ShaftBody>) -> bool {
    matches!(body, Some(ShaftBody::Bar { mass, .. }) if *mass != BarMass::None)
}

fn with_lengths(model: &Model, lengths: usize) -> Model {
    let mut finer = model.clone();
    for shaft in finer.shafts.iter_mut().filter(|s| weighs(&s.body)) {
        if let Some(ShaftBody::Bar { segments, .. }) = &mut shaft.body {
            *segments = lengths;
        }
    }
    finer
}
