//! Which terms the data ask for: real or complex constants, residual terms below and above, by the criterion of Schwarz (1978),
//! `χ² + parameters · ln(data)`. Terms are taken out one after another for as long as it falls.

use super::basis::{Problem, Structure};
use super::projection::{Fitted, Stop, at, refine};
use crate::numeric::Matrix;

/// Steps of a trial.
const STOP: Stop = Stop {
    steps: 6,
    fall: 1.0,
    share: 1e-6,
};

/// Free real numbers of a fit.
pub(super) fn parameters(structure: Structure, fitted: &Fitted, responses: usize) -> f64 {
    let poles = fitted.model.poles.len();
    (2 * poles + fitted.model.delays.len() + responses * structure.columns(poles)) as f64
}

/// The structure of least criterion, with its fit; `problem` has every term, and so many independent numbers of data.
pub(super) fn choose(problem: &Problem, data: f64, full: &Fitted) -> (Structure, Fitted, usize) {
    let responses = problem.y.ncols();
    let freedom = (data - parameters(Structure::FULL, full, responses)).max(1.0);
    // a variance that is too small would keep every term
    let unit = (full.chi2 / freedom).max(1.0);
    let criterion = |structure: Structure, fitted: &Fitted| {
        fitted.chi2 / unit + parameters(structure, fitted, responses) * data.ln()
    };
    let mut best = (Structure::FULL, full.clone());
    let mut steps = 0;
    let without: [fn(Structure) -> Structure; 3] = [
        |s| Structure {
            complex: false,
            ..s
        },
        |s| Structure { upper: false, ..s },
        |s| Structure { lower: false, ..s },
    ];
    for less in without {
        let structure = less(best.0);
        if structure.columns(best.1.model.poles.len()) == 0 {
            continue;
        }
        let problem = [reduced(problem, structure)];
        let start = at(&problem, &best.1.model, structure.numerators());
        let trial = refine(&problem, start, structure.numerators(), STOP);
        steps += trial.steps;
        if criterion(structure, &trial) <= criterion(best.0, &best.1) {
            best = (structure, trial);
        }
    }
    (best.0, best.1, steps)
}

/// A problem of full structure without the residual terms that another does not have.
fn reduced(problem: &Problem, structure: Structure) -> Problem {
    let used: Vec<usize> = [structure.lower, structure.upper]
        .into_iter()
        .enumerate()
        .filter_map(|(j, used)| used.then_some(j))
        .collect();
    Problem {
        fixed: Matrix::from_fn(problem.fixed.nrows(), used.len(), |k, j| {
            problem.fixed[(k, used[j])]
        }),
        ..problem.clone()
    }
}
