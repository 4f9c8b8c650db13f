//! Which terms the data ask for: real or complex constants, residual terms below and above, by the criterion of Schwarz (1978),
//! `χ² + parameters · ln(data)`. Terms are taken out one after another for as long as it falls.

use super::basis::Structure;
use super::lines::{Lines, Weights};
use super::projection::{Fitted, Stop, at, refine};

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

/// The structure of least criterion, with its fit.
pub(super) fn choose(
    lines: &Lines,
    weights: &Weights,
    full: &Fitted,
) -> (Structure, Fitted, usize) {
    let responses = lines.h.len();
    let data = lines.data();
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
        let problem = [lines.shared(weights, structure)];
        let start = at(&problem, &best.1.model, structure.numerators());
        let trial = refine(&problem, start, structure.numerators(), STOP);
        steps += trial.steps;
        if criterion(structure, &trial) <= criterion(best.0, &best.1) {
            best = (structure, trial);
        }
    }
    (best.0, best.1, steps)
}
