//! Responses on the lines about a pole, with what the poles farther away have of them taken off: fitted again and again under other
//! weights, by all responses or by some, without the rest of the band.

use crate::numeric::{Complex, Matrix};

use super::basis::{ScaledPole, WhitenedProblem, set_complex};
use super::line_compression::Compressor;
use super::model_error::{ModeDeviation, PoleResidues, misfit, variance};
use super::projection::{ModelFit, PoleModel, StopCriteria, fit_at, residual};
use super::scaled_responses::{ScaledResponses, SeparableWeights};
use crate::numeric::sorting::sort_rising;

/// Half a window: lines, half-widths of the pole, of its neighbour, and of the pole again at most for that.
const HALF_WINDOW: (f64, f64, f64, f64) = (8.0, 8.0, 8.0, 20.0);

/// Half the width of the window about a pole, from the line spacing and the decay rates of the pole and its nearest neighbour, rad/s.
pub fn half_window(step: f64, sigma: f64, neighbour: f64) -> f64 {
    (HALF_WINDOW.0 * step)
        .max(HALF_WINDOW.1 * sigma)
        .max((HALF_WINDOW.2 * neighbour).min(HALF_WINDOW.3 * sigma))
}

/// Residues are free complex numbers.
pub(super) const NUMERATORS: usize = 2;

/// Background of a window by response: `1`, `j`, `t` and `jt` times `s^q`, t from −1 to 1 over the window.
const BACKGROUND_TERMS: usize = 4;

/// Most poles of a window. That of a broad pole among narrow ones ends before 8 half-widths: its time grows with their cube.
const MAX_POLES: usize = 12;

/// A fit of the whole band, as far as windows need it.
pub(super) struct BandFit<'a> {
    /// Lines and responses.
    pub lines: &'a ScaledResponses,
    /// Variance of the noise alone.
    pub noise: &'a [Vec<f64>],
    /// Poles and what the responses have of them.
    pub modes: PoleResidues,
    /// Residual of the scaled responses.
    pub residual: Vec<Vec<Complex>>,
}

/// Lines about a pole.
pub(super) struct PoleWindow<'a> {
    lines: &'a ScaledResponses,
    from: usize,
    to: usize,
    /// Places of the poles inside it.
    pub near: Vec<usize>,
    /// Variance by response and line of the window without the departures of the poles inside.
    noise: Vec<Vec<f64>>,
    /// Scaled responses without the poles farther away, by response and line of the window.
    h: Vec<Vec<Complex>>,
    fixed: Matrix,
}

/// A fit of a window under weights of its own.
pub(super) struct WindowFit {
    /// Poles and coefficients in the scaled responses taken part in the fit.
    pub fit: ModelFit,
    /// The lines that the fit was made on.
    pub problem: WhitenedProblem,
    /// All lines, where those are fewer.
    all: Option<WhitenedProblem>,
    weights: SeparableWeights,
    /// Which responses took part.
    of: Vec<usize>,
}

impl<'a> PoleWindow<'a> {
    /// The lines within `half` of a frequency, of [`MAX_POLES`] poles at most, and at least as many as the poles within need; `departure` is
    /// what the poles farther away depart by.
    pub fn new(
        band: &'a BandFit,
        centre: f64,
        half: f64,
        departure: &dyn Fn(usize) -> ModeDeviation,
    ) -> PoleWindow<'a> {
        let lines = band.lines;
        let (x, step) = (&lines.x, lines.step);
        let mut apart: Vec<f64> = (band.modes.poles.iter())
            .map(|p| (p.w - centre).abs())
            .collect();
        sort_rising(&mut apart, |&d| d);
        let mut half = match apart.get(MAX_POLES) {
            Some(beyond) => half.min(0.5 * (apart[MAX_POLES - 1] + beyond)),
            None => half,
        };
        loop {
            let from = x.partition_point(|&v| v < centre - half);
            let to = x.partition_point(|&v| v <= centre + half);
            let inside = |p: &ScaledPole| (p.w - centre).abs() <= half;
            let poles = &band.modes.poles;
            let near: Vec<usize> = (0..poles.len()).filter(|&r| inside(&poles[r])).collect();
            let columns = (near.len() + 1) * NUMERATORS + BACKGROUND_TERMS;
            if 2 * to.saturating_sub(from) > columns + near.len() + 8 || to - from == x.len() {
                return PoleWindow::around(band, from, to, near, departure);
            }
            half = (1.3 * half).max(half + step);
        }
    }

    fn around(
        band: &'a BandFit,
        from: usize,
        to: usize,
        near: Vec<usize>,
        departure: &dyn Fn(usize) -> ModeDeviation,
    ) -> PoleWindow<'a> {
        let lines = band.lines;
        let m = to - from;
        let far: Vec<ModeDeviation> = (0..band.modes.poles.len())
            .map(|r| match near.contains(&r) {
                true => ModeDeviation::NONE,
                false => departure(r),
            })
            .collect();
        let noise: Vec<Vec<f64>> = band.noise.iter().map(|v| v[from..to].to_vec()).collect();
        let noise = variance(lines, from, &noise, &band.modes, &far);
        let h = (0..lines.h.len())
            .map(|i| {
                (0..m)
                    .map(|k| {
                        let x = lines.x[from + k];
                        let own: Complex = near.iter().map(|&r| band.modes.part(i, r, x).0).sum();
                        band.residual[i][from + k] + own * lines.power(from + k)
                    })
                    .collect()
            })
            .collect();
        let middle = 0.5 * (lines.x[from] + lines.x[to - 1]);
        let reach = (0.5 * (lines.x[to - 1] - lines.x[from])).max(f64::MIN_POSITIVE);
        let mut fixed = Matrix::zeros(2 * m, BACKGROUND_TERMS);
        for k in 0..m {
            let t = (lines.x[from + k] - middle) / reach;
            let (power, j) = (lines.power(from + k), Complex::new(0.0, 1.0));
            for (at, z) in [power, power * j, power * t, power * j * t]
                .into_iter()
                .enumerate()
            {
                set_complex(fixed.col_as_slice_mut(at), k, m, z);
            }
        }
        PoleWindow {
            lines,
            from,
            to,
            near,
            noise,
            h,
            fixed,
        }
    }

    /// Frequencies of its lines.
    pub fn x(&self) -> &[f64] {
        &self.lines.x[self.from..self.to]
    }

    /// The variance under departures of some modes.
    pub fn variance(&self, modes: &PoleResidues, departures: &[ModeDeviation]) -> Vec<Vec<f64>> {
        variance(self.lines, self.from, &self.noise, modes, departures)
    }

    /// Residual at a mode of a fit to some responses, as a share of the mode's own value.
    pub fn misfit(
        &self,
        of: &[usize],
        residual: &[Vec<Complex>],
        modes: &PoleResidues,
        r: usize,
    ) -> f64 {
        misfit(self.lines, self.from, of, residual, &self.noise, modes, r)
    }

    /// Share of the power of some responses that a mode has within its half-power band, and at least on the nearest lines.
    pub fn visibility(&self, of: &[usize], modes: &PoleResidues, r: usize) -> f64 {
        let pole = &modes.poles[r];
        let half = pole.sigma.max(self.lines.step);
        let (mut own, mut all) = (0.0, 0.0);
        for k in self.from..self.to {
            let x = self.lines.x[k];
            if (x - pole.w).abs() > half {
                continue;
            }
            for &i in of {
                own += modes.part(i, r, x).0.norm_sqr() * self.lines.power_size(k);
                all += self.lines.h[i][k].norm_sqr();
            }
        }
        if all > 0.0 { own / all } else { 0.0 }
    }

    /// A variance as weights, common to the lines of the responses named.
    pub fn weights(&self, of: &[usize], variance: &[Vec<f64>]) -> SeparableWeights {
        let own: Vec<Vec<f64>> = of.iter().map(|&i| variance[i].clone()).collect();
        let own = SeparableWeights::mean(&own);
        let mut by_response = vec![1.0; self.h.len()];
        for (&i, v) in of.iter().zip(&own.by_response) {
            by_response[i] = *v;
        }
        SeparableWeights { by_response, ..own }
    }

    /// Poles brought to their places by the responses named.
    pub fn fit(
        &self,
        of: &[usize],
        weights: &SeparableWeights,
        poles: &[ScaledPole],
        cancel: StopCriteria,
    ) -> WindowFit {
        let m = self.to - self.from;
        let unit: Vec<f64> = (weights.by_line.iter())
            .map(|v| (2.0 * self.lines.independence / v).sqrt())
            .collect();
        let mut y = Matrix::zeros(2 * m, of.len());
        for (at, &i) in of.iter().enumerate() {
            let scale = 1.0 / weights.by_response[i].sqrt();
            let column = y.col_as_slice_mut(at);
            for k in 0..m {
                set_complex(column, k, m, self.h[i][k] * (unit[k] * scale));
            }
        }
        let all = WhitenedProblem {
            x: self.x().to_vec(),
            factor: (0..m)
                .map(|k| self.lines.power(self.from + k) * unit[k])
                .collect(),
            pole_free_columns: Matrix::from_fn(2 * m, BACKGROUND_TERMS, |k, j| {
                self.fixed[(k, j)] * unit[k % m]
            }),
            y,
            first: of[0],
            line_spacing: self.lines.step,
            omitted_energy: 0.0,
        };
        let model = PoleModel {
            poles: poles.to_vec(),
            delays: Vec::new(),
        };
        let (fit, fewer) = refine_on_fewer(&all, model, cancel);
        let (problem, all) = match fewer {
            Some(fewer) => (fewer, Some(all)),
            None => (all, None),
        };
        WindowFit {
            fit,
            problem,
            all,
            weights: weights.clone(),
            of: of.to_vec(),
        }
    }
}

/// Poles brought to their places on the lines that they need, and these lines; `None` for all. The window of a broad pole is most of the
/// band.
fn refine_on_fewer(
    all: &WhitenedProblem,
    model: PoleModel,
    cancel: StopCriteria,
) -> (ModelFit, Option<WhitenedProblem>) {
    let mut compressor = Compressor::new(all);
    let mut lines = compressor.compress(&model, &[]);
    let fit = fit_at(&[&*lines.problem], &model, NUMERATORS);
    let fit = compressor.refine(fit, &mut lines, NUMERATORS, cancel);
    let fewer = (!lines.is_whole()).then(|| lines.problem.into_owned());
    (fit, fewer)
}

impl WindowFit {
    /// Poles with their coefficients in every response: zero for those that took no part.
    pub fn modes(&self, responses: usize) -> PoleResidues {
        let mut all = vec![vec![0.0; 2 * self.fit.model.poles.len()]; responses];
        for (at, &i) in self.of.iter().enumerate() {
            all[i] = coefficients(&self.fit, at, self.weights.by_response[i]);
        }
        PoleResidues {
            poles: self.fit.model.poles.clone(),
            coefficients: all,
        }
    }

    /// Residual of the scaled responses that took part, by line.
    pub fn residual(&self, independence: f64) -> Vec<Vec<Complex>> {
        let fit = &self.fit;
        let e = match &self.all {
            Some(all) => &residual(all, &fit.model, NUMERATORS, &fit.fits[0]),
            None => &fit.fits[0].e,
        };
        let m = e.nrows() / 2;
        (self.of.iter().enumerate())
            .map(|(at, &i)| {
                let column = e.col_as_slice(at);
                let unit = |k: usize| {
                    (self.weights.by_response[i] * self.weights.by_line[k] / 2.0 / independence)
                        .sqrt()
                };
                (0..m)
                    .map(|k| Complex::new(column[k], column[m + k]) * unit(k))
                    .collect()
            })
            .collect()
    }
}

/// Coefficients of the poles in a scaled response, the column `fit_at` of a fit.
pub(super) fn coefficients(fitted: &ModelFit, at: usize, by_response: f64) -> Vec<f64> {
    let fit = &fitted.fits[0];
    (0..NUMERATORS * fitted.model.poles.len())
        .map(|j| fit.c[(j, at)] / fit.column_norms[j] * by_response.sqrt())
        .collect()
}
