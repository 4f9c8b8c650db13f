//! Test that distinguishes dense modes from departures: of dense modes, noise explains the lines around every pole, although not yet the whole band.

use super::super::projection::PoleModel;
use super::sub_bands::{MAX_BAND_POLES, MAX_NOISE_CHI2};
use super::{StepwiseSearch, is_crowd, parameters_per_pole};
use crate::numeric::parallel;
use crate::numeric::sorting::sort_ascending;

/// Number of windows.
const WINDOWS: usize = 8;

/// Half-width of a window, lines.
const HALF_WINDOW: f64 = 100.0;

/// Parameters of the linear background of a response.
const BACKGROUND_PARAMETERS: f64 = 4.0;

impl StepwiseSearch<'_> {
    /// Whether noise explains three quarters of the windows around poles of `model`, each with poles selected on its lines alone.
    pub fn noise_explains_windows(mut self, model: &PoleModel) -> bool {
        let fit = self.fit_model(model, &[]);
        let residual = self.residual_on_all_lines(&fit);
        let mut centres: Vec<f64> = model.poles.iter().map(|p| p.w).collect();
        sort_ascending(&mut centres, |&w| w);
        let interval = centres.len().div_ceil(WINDOWS).max(1);
        let centres: Vec<f64> = centres.into_iter().step_by(interval).collect();
        let half = HALF_WINDOW * self.measured.line_spacing;
        let per_pole = parameters_per_pole(self.measured, self.numerators);
        let background = BACKGROUND_PARAMETERS * self.measured.y.ncols() as f64;
        let is_explained = |w: &f64| {
            let selected =
                self.select_between((w - half, w + half), (&fit, &residual), &mut Vec::new());
            selected.is_some_and(|(selected, data_count)| {
                let poles = &selected.model.poles;
                let parameters = per_pole * poles.len() as f64 + background;
                selected.chi2 < MAX_NOISE_CHI2 * (data_count - parameters)
                    && poles.len() < MAX_BAND_POLES
                    && !is_crowd(poles, self.measured.line_spacing)
            })
        };
        let explained = parallel::map(&centres, is_explained);
        let count = explained.iter().filter(|&&explained| explained).count();
        count > 0 && 4 * count >= 3 * explained.len()
    }
}
