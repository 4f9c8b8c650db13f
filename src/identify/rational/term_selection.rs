//! Selection of model terms by BIC: real or complex modal constants, lower and upper residual terms.
//!
//! Terms are taken out one after another for as long as it falls.

use super::basis::{ModelTerms, WhitenedProblem};
use super::projection::{ModelFit, StopCriteria, fit_at, refine};
use crate::numeric::Matrix;

/// Steps of a trial.
const STOP: StopCriteria = StopCriteria {
    steps: 6,
    min_decrease: 1.0,
    min_relative_decrease: 1e-6,
};

/// Free real numbers of a fit.
pub(super) fn parameter_count(structure: ModelTerms, fit: &ModelFit, responses: usize) -> f64 {
    let poles = fit.model.poles.len();
    (2 * poles + fit.model.delays.len() + responses * structure.columns(poles)) as f64
}

/// The structure of least criterion, with its fit; `problem` has every term, and so many independent numbers of data.
pub(super) fn select_terms(
    problem: &WhitenedProblem,
    data: f64,
    full: &ModelFit,
) -> (ModelTerms, ModelFit, usize) {
    let responses = problem.y.ncols();
    let dof = (data - parameter_count(ModelTerms::FULL, full, responses)).max(1.0);
    // a variance that is too small would keep every term
    let unit = (full.chi2 / dof).max(1.0);
    let criterion = |structure: ModelTerms, fit: &ModelFit| {
        fit.chi2 / unit + parameter_count(structure, fit, responses) * data.ln()
    };
    let mut best = (ModelTerms::FULL, full.clone());
    let mut steps = 0;
    let without: [fn(ModelTerms) -> ModelTerms; 3] = [
        |s| ModelTerms {
            complex: false,
            ..s
        },
        |s| ModelTerms { upper: false, ..s },
        |s| ModelTerms { lower: false, ..s },
    ];
    for less in without {
        let structure = less(best.0);
        if structure.columns(best.1.model.poles.len()) == 0 {
            continue;
        }
        let problem = [without_terms(problem, structure)];
        let start = fit_at(&problem, &best.1.model, structure.numerators());
        let trial = refine(&problem, start, structure.numerators(), STOP);
        steps += trial.steps;
        if criterion(structure, &trial) <= criterion(best.0, &best.1) {
            best = (structure, trial);
        }
    }
    (best.0, best.1, steps)
}

/// A problem of full structure without the residual terms that another does not have.
fn without_terms(problem: &WhitenedProblem, structure: ModelTerms) -> WhitenedProblem {
    let used: Vec<usize> = [structure.lower, structure.upper]
        .into_iter()
        .enumerate()
        .filter_map(|(j, used)| used.then_some(j))
        .collect();
    WhitenedProblem {
        pole_free_columns: Matrix::from_fn(
            problem.pole_free_columns.nrows(),
            used.len(),
            |k, j| problem.pole_free_columns[(k, used[j])],
        ),
        ..problem.clone()
    }
}
