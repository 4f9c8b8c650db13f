//! Test that tells dense modes from departures: of dense modes, noise explains the lines around every pole, although not yet the whole band.

use super::super::basis::ScaledPole;
use super::super::local_fit::cut_window;
use super::super::projection::PoleModel;
use super::{StepwiseOptions, StepwiseSearch, is_crowd, parameters_per_pole};
use crate::numeric::parallel;

/// Number of windows.
const WINDOWS: usize = 8;

/// Half-width of a window, lines.
const HALF_WINDOW: f64 = 100.0;

/// Maximum number of poles of a window.
const MAX_WINDOW_POLES: usize = 12;

/// Maximum χ² of a window over its degrees of freedom: the number of poles of the band is not final, nor is the variance.
const MAX_MISFIT: f64 = 3.0;

impl StepwiseSearch<'_> {
    /// Whether noise explains three quarters of the windows around poles of `model`; the poles of each window are selected anew, with a
    /// linear background.
    pub fn noise_explains_windows(mut self, model: &PoleModel) -> bool {
        let fit = self.fit_model(model, &[]);
        let residual = self.residual_on_all_lines(&fit);
        let poles = &model.poles;
        let interval = poles.len().div_ceil(WINDOWS).max(1);
        let centres: Vec<&ScaledPole> = poles.iter().step_by(interval).collect();
        let is_explained = |centre: &&ScaledPole| {
            let x = &self.measured.x;
            let half = HALF_WINDOW * self.measured.line_spacing;
            let from = x.partition_point(|&x| x < centre.w - half);
            let to = x.partition_point(|&x| x <= centre.w + half);
            let indices: Vec<usize> = (0..poles.len())
                .filter(|&r| (poles[r].w - centre.w).abs() <= half)
                .collect();
            let part = cut_window(
                self.measured,
                &fit,
                &residual,
                self.numerators,
                &indices,
                from,
                to,
            );
            let options = StepwiseOptions {
                max_poles: MAX_WINDOW_POLES,
                data_count: self.options.data_count * (to - from) as f64 / x.len() as f64,
                ..self.options
            };
            let inside = PoleModel {
                poles: indices.iter().map(|&r| poles[r]).collect(),
                delays: Vec::new(),
            };
            let mut search = StepwiseSearch::new(&part, self.numerators, options);
            search.threshold = self.threshold;
            let selected = search.run(&inside, &mut Vec::new()).fit;
            let count = selected.model.poles.len();
            // The background has as many parameters as a pole.
            let parameters =
                (count + 1) as f64 * parameters_per_pole(self.measured, self.numerators);
            selected.chi2 < MAX_MISFIT * (options.data_count - parameters)
                && count < MAX_WINDOW_POLES
                && !is_crowd(&selected.model.poles, self.measured.line_spacing)
        };
        let explained = parallel::map(&centres, is_explained);
        4 * explained.iter().filter(|&&explained| explained).count() >= 3 * explained.len()
    }
}
