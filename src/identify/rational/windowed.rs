//! Fits in a window of lines around a pole, after subtraction of the poles outside the window: repeated with different weights, for all
//! or some responses, without the rest of the band.

use crate::numeric::{Complex, Matrix};

use super::basis::{ScaledPole, WhitenedProblem, set_complex};
use super::line_compression::Compressor;
use super::model_error::{ModeDeviation, PoleResidues, misfit, variance};
use super::projection::{ModelFit, PoleModel, StopCriteria, fit_at, residual};
use super::scaled_responses::{ScaledResponses, SeparableWeights};
use crate::numeric::sorting::sort_ascending;

/// Half-width of a window: minimum lines, half-widths of the pole and of its neighbour, and limit of the latter in half-widths of the pole.
const HALF_WINDOW: (f64, f64, f64, f64) = (8.0, 8.0, 8.0, 20.0);

/// Half-width of the window around a pole from the line spacing and the decay rates of the pole and its nearest neighbour, in equal units.
pub fn half_window(step: f64, sigma: f64, neighbour: f64) -> f64 {
    (HALF_WINDOW.0 * step)
        .max(HALF_WINDOW.1 * sigma)
        .max((HALF_WINDOW.2 * neighbour).min(HALF_WINDOW.3 * sigma))
}

/// Number of numerator coefficients per pole and response: complex residues.
pub(super) const NUMERATORS: usize = 2;

/// Number of background terms per response: `1`, `j`, `t` and `jt` times `s^q`, t from −1 to 1 over the window.
const BACKGROUND_TERMS: usize = 4;

/// Maximum number of poles in a window. The time grows with its cube, so the window of a broad pole among narrow ones is shortened.
const MAX_POLES: usize = 12;

/// Fit of the whole band, from which windows are cut.
pub(super) struct BandFit<'a> {
    /// Lines and responses.
    pub lines: &'a ScaledResponses,
    /// Noise variance by response and line.
    pub noise: &'a [Vec<f64>],
    /// Poles and their coefficients by response.
    pub modes: PoleResidues,
    /// Residual of the scaled responses, by response and line.
    pub residual: Vec<Vec<Complex>>,
}

/// Window of lines around a pole.
pub(super) struct PoleWindow<'a> {
    lines: &'a ScaledResponses,
    from: usize,
    to: usize,
    /// Indices of the poles inside the window.
    pub indices: Vec<usize>,
    /// Variance by response and line of the window, without the model error of the poles inside.
    noise: Vec<Vec<f64>>,
    /// Scaled responses without the poles outside, by response and line of the window.
    h: Vec<Vec<Complex>>,
    background: Matrix,
}

/// Fit in a window with its weights.
pub(super) struct WindowFit {
    /// Poles and coefficients of the fitted scaled responses.
    pub fit: ModelFit,
    /// Problem of the fit, possibly on compressed lines.
    pub problem: WhitenedProblem,
    /// Problem on all lines, if `problem` is compressed.
    full: Option<WhitenedProblem>,
    weights: SeparableWeights,
    /// Indices of the fitted responses.
    responses: Vec<usize>,
}

impl<'a> PoleWindow<'a> {
    /// Selects the lines within `half` of a frequency, limited to [`MAX_POLES`] poles and extended to the number of lines that their fit
    /// needs; `departure` returns the model error of the poles outside.
    pub fn new(
        band: &'a BandFit,
        centre: f64,
        half: f64,
        departure: &dyn Fn(usize) -> ModeDeviation,
    ) -> PoleWindow<'a> {
        let lines = band.lines;
        let (x, step) = (&lines.x, lines.step);
        let mut distances: Vec<f64> = (band.modes.poles.iter())
            .map(|p| (p.w - centre).abs())
            .collect();
        sort_ascending(&mut distances, |&d| d);
        let mut half = match distances.get(MAX_POLES) {
            Some(next) => half.min(0.5 * (distances[MAX_POLES - 1] + next)),
            None => half,
        };
        loop {
            let from = x.partition_point(|&v| v < centre - half);
            let to = x.partition_point(|&v| v <= centre + half);
            let is_inside = |p: &ScaledPole| (p.w - centre).abs() <= half;
            let poles = &band.modes.poles;
            let indices: Vec<usize> = (0..poles.len()).filter(|&r| is_inside(&poles[r])).collect();
            let columns = (indices.len() + 1) * NUMERATORS + BACKGROUND_TERMS;
            if 2 * to.saturating_sub(from) > columns + indices.len() + 8 || to - from == x.len() {
                return PoleWindow::around(band, from, to, indices, departure);
            }
            half = (1.3 * half).max(half + step);
        }
    }

    fn around(
        band: &'a BandFit,
        from: usize,
        to: usize,
        poles: Vec<usize>,
        departure: &dyn Fn(usize) -> ModeDeviation,
    ) -> PoleWindow<'a> {
        let lines = band.lines;
        let m = to - from;
        let outside: Vec<ModeDeviation> = (0..band.modes.poles.len())
            .map(|r| match poles.contains(&r) {
                true => ModeDeviation::NONE,
                false => departure(r),
            })
            .collect();
        let noise: Vec<Vec<f64>> = band.noise.iter().map(|v| v[from..to].to_vec()).collect();
        let noise = variance(lines, from, &noise, &band.modes, &outside);
        let h = (0..lines.h.len())
            .map(|i| {
                (0..m)
                    .map(|k| {
                        let x = lines.x[from + k];
                        let h: Complex = poles.iter().map(|&r| band.modes.part(i, r, x).0).sum();
                        band.residual[i][from + k] + h * lines.power(from + k)
                    })
                    .collect()
            })
            .collect();
        let middle = 0.5 * (lines.x[from] + lines.x[to - 1]);
        let reach = (0.5 * (lines.x[to - 1] - lines.x[from])).max(f64::MIN_POSITIVE);
        let mut background = Matrix::zeros(2 * m, BACKGROUND_TERMS);
        for k in 0..m {
            let t = (lines.x[from + k] - middle) / reach;
            let (power, j) = (lines.power(from + k), Complex::new(0.0, 1.0));
            for (at, z) in [power, power * j, power * t, power * j * t]
                .into_iter()
                .enumerate()
            {
                set_complex(background.col_as_slice_mut(at), k, m, z);
            }
        }
        PoleWindow {
            lines,
            from,
            to,
            indices: poles,
            noise,
            h,
            background,
        }
    }

    /// Frequencies of the lines of the window.
    pub fn x(&self) -> &[f64] {
        &self.lines.x[self.from..self.to]
    }

    /// Variance with the model error of the given modes.
    pub fn variance(&self, modes: &PoleResidues, departures: &[ModeDeviation]) -> Vec<Vec<f64>> {
        variance(self.lines, self.from, &self.noise, modes, departures)
    }

    /// Model error of mode r from the residual `e` of a fit to some responses, relative to the response of the mode.
    pub fn misfit(
        &self,
        group: &[usize],
        e: &[Vec<Complex>],
        modes: &PoleResidues,
        r: usize,
    ) -> f64 {
        misfit(self.lines, self.from, group, e, &self.noise, modes, r)
    }

    /// Share of a mode in the power of some responses within its half-power band (at least the adjacent lines).
    pub fn visibility(&self, responses: &[usize], modes: &PoleResidues, r: usize) -> f64 {
        let pole = &modes.poles[r];
        let half = pole.sigma.max(self.lines.step);
        let (mut modal, mut total) = (0.0, 0.0);
        for k in self.from..self.to {
            let x = self.lines.x[k];
            if (x - pole.w).abs() > half {
                continue;
            }
            for &i in responses {
                modal += modes.part(i, r, x).0.norm_sqr() * self.lines.power_size(k);
                total += self.lines.h[i][k].norm_sqr();
            }
        }
        if total > 0.0 { modal / total } else { 0.0 }
    }

    /// Separable weights from the variance of the given responses.
    pub fn weights(&self, responses: &[usize], variance: &[Vec<f64>]) -> SeparableWeights {
        let selected: Vec<Vec<f64>> = responses.iter().map(|&i| variance[i].clone()).collect();
        let w = SeparableWeights::mean(&selected);
        let mut by_response = vec![1.0; self.h.len()];
        for (&i, v) in responses.iter().zip(&w.by_response) {
            by_response[i] = *v;
        }
        SeparableWeights { by_response, ..w }
    }

    /// Refines poles with the given responses.
    pub fn fit(
        &self,
        responses: &[usize],
        weights: &SeparableWeights,
        poles: &[ScaledPole],
        cancel: StopCriteria,
    ) -> WindowFit {
        let m = self.to - self.from;
        let weight: Vec<f64> = (weights.by_line.iter())
            .map(|v| (2.0 * self.lines.independence / v).sqrt())
            .collect();
        let mut y = Matrix::zeros(2 * m, responses.len());
        for (j, &i) in responses.iter().enumerate() {
            let scale = 1.0 / weights.by_response[i].sqrt();
            let column = y.col_as_slice_mut(j);
            for k in 0..m {
                set_complex(column, k, m, self.h[i][k] * (weight[k] * scale));
            }
        }
        let full = WhitenedProblem {
            x: self.x().to_vec(),
            factor: (0..m)
                .map(|k| self.lines.power(self.from + k) * weight[k])
                .collect(),
            pole_free_columns: Matrix::from_fn(2 * m, BACKGROUND_TERMS, |k, j| {
                self.background[(k, j)] * weight[k % m]
            }),
            y,
            first: responses[0],
            line_spacing: self.lines.step,
            omitted_energy: 0.0,
        };
        let model = PoleModel {
            poles: poles.to_vec(),
            delays: Vec::new(),
        };
        let (fit, reduced) = refine_compressed(&full, model, cancel);
        let (problem, full) = match reduced {
            Some(reduced) => (reduced, Some(full)),
            None => (full, None),
        };
        WindowFit {
            fit,
            problem,
            full,
            weights: weights.clone(),
            responses: responses.to_vec(),
        }
    }
}

/// Refines a model on compressed lines, since the window of a broad pole covers most of the band. Returns the compressed problem, or `None`
/// if no line was compressed.
fn refine_compressed(
    problem: &WhitenedProblem,
    model: PoleModel,
    cancel: StopCriteria,
) -> (ModelFit, Option<WhitenedProblem>) {
    let mut compressor = Compressor::new(problem);
    let mut lines = compressor.compress(&model, &[]);
    let fit = fit_at(&[&*lines.problem], &model, NUMERATORS);
    let fit = compressor.refine(fit, &mut lines, NUMERATORS, cancel);
    let reduced = (!lines.is_uncompressed()).then(|| lines.problem.into_owned());
    (fit, reduced)
}

impl WindowFit {
    /// Poles with their coefficients in all responses; zero for responses that were not fitted.
    pub fn modes(&self, responses: usize) -> PoleResidues {
        let mut by_response = vec![vec![0.0; 2 * self.fit.model.poles.len()]; responses];
        for (j, &i) in self.responses.iter().enumerate() {
            by_response[i] = coefficients(&self.fit, j, self.weights.by_response[i]);
        }
        PoleResidues {
            poles: self.fit.model.poles.clone(),
            coefficients: by_response,
        }
    }

    /// Residual of the fitted scaled responses, by response and line.
    pub fn residual(&self, independence: f64) -> Vec<Vec<Complex>> {
        let fit = &self.fit;
        let e = match &self.full {
            Some(full) => &residual(full, &fit.model, NUMERATORS, &fit.fits[0]),
            None => &fit.fits[0].e,
        };
        let m = e.nrows() / 2;
        (self.responses.iter().enumerate())
            .map(|(j, &i)| {
                let column = e.col_as_slice(j);
                let scale = |k: usize| {
                    (self.weights.by_response[i] * self.weights.by_line[k] / 2.0 / independence)
                        .sqrt()
                };
                (0..m)
                    .map(|k| Complex::new(column[k], column[m + k]) * scale(k))
                    .collect()
            })
            .collect()
    }
}

/// Coefficients of the poles in a scaled response, column `column` of a fit.
pub(super) fn coefficients(fitted: &ModelFit, column: usize, by_response: f64) -> Vec<f64> {
    let fit = &fitted.fits[0];
    (0..NUMERATORS * fitted.model.poles.len())
        .map(|j| fit.c[(j, column)] / fit.column_norms[j] * by_response.sqrt())
        .collect()
}
