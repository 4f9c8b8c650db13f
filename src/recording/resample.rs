//! Resampling of jittered samples to a uniform time base by least-squares band-limited interpolation.

use std::ops::Range;

use super::sample_column::SampleColumn;
use crate::base::error::Error;
use crate::numeric::band_limited::BandLimitedInterpolator;

/// Neighbours each value is made from.
const KERNEL_LEN: usize = 32;

/// Values at either end of a segment that have fewer neighbours on one side.
pub const HALF_KERNEL: usize = KERNEL_LEN / 2;

/// Bands tried from the widest, as parts of the rate; half of it could be had from endless even samples only.
const BAND_EDGES: [f64; 6] = [0.4, 0.36, 0.32, 0.28, 0.24, 0.2];

/// The error a band is taken for: −80 dB, below the noise of 16-bit converters in practice.
const MAX_BAND_ERROR: f64 = 1e-4;

/// Rows of stamps held at once.
const BLOCK: usize = 1 << 14;

/// Fidelity of a resampled signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResamplingError {
    /// Up to here the signal is kept, Hz.
    pub band_hz: f64,
    /// The largest rms error of a value relative to a signal spread over the band, where it has neighbours on both sides.
    pub error: f64,
    /// The same of the first and last values of a segment, [`HALF_KERNEL`] to either end.
    pub error_at_ends: f64,
}

/// A uniform grid laid over one segment of stamps.
#[derive(Debug, Clone)]
pub struct UniformGrid {
    /// Rows of the segment.
    pub rows: Range<usize>,
    /// Time of the first value, s.
    pub start_s: f64,
    /// Values.
    pub count: usize,
}

/// The widest band that `MAX_BAND_ERROR` can be kept in, judged at windows spread over the segment; the narrowest where none is
/// good.
///
/// # Errors
/// The stamps cannot be read.
pub fn best_band(seconds: &SampleColumn, rows: &Range<usize>, rate_hz: f64) -> Result<f64, Error> {
    const TRIAL_WINDOWS: usize = 64;
    let points = KERNEL_LEN.min(rows.len());
    let mut times = vec![0.0; points];
    'bands: for part in BAND_EDGES {
        let mut interpolator = BandLimitedInterpolator::new(part * rate_hz, points);
        let spare = rows.len() - points;
        for place in 0..=TRIAL_WINDOWS.min(spare) {
            let start = rows.start + spare * place / TRIAL_WINDOWS.min(spare).max(1);
            seconds.read(start, &mut times)?;
            let middle = 0.5 * (times[(points - 1) / 2] + times[points / 2]);
            if interpolator.weights(&times, middle).1 > MAX_BAND_ERROR {
                continue 'bands;
            }
        }
        return Ok(part * rate_hz);
    }
    Ok(BAND_EDGES[BAND_EDGES.len() - 1] * rate_hz)
}

/// Resamples several columns of one segment together, since they share the weights; appends to `outputs`.
///
/// # Errors
/// Samples cannot be read or written.
pub fn resample(
    seconds: &SampleColumn,
    columns: &[&SampleColumn],
    grid: &UniformGrid,
    rate_hz: f64,
    band_hz: f64,
    outputs: &mut [SampleColumn],
) -> Result<ResamplingError, Error> {
    let points = KERNEL_LEN.min(grid.rows.len());
    let mut interpolator = BandLimitedInterpolator::new(band_hz, points);
    let mut window = KernelWindow::new(grid.rows.clone(), columns.len());
    let mut quality = ResamplingError {
        band_hz,
        error: 0.0,
        error_at_ends: 0.0,
    };
    let mut ready: Vec<Vec<f64>> = vec![Vec::with_capacity(BLOCK); columns.len()];
    let mut nearest = grid.rows.start;
    for i in 0..grid.count {
        let at = grid.start_s + i as f64 / rate_hz;
        // The row whose stamp is the last at or before `at`.
        loop {
            window.load_around(seconds, columns, nearest, points)?;
            if nearest + 1 >= grid.rows.end || window.time(nearest + 1) > at {
                break;
            }
            nearest += 1;
        }
        let first = (nearest + 1)
            .saturating_sub(points / 2)
            .clamp(grid.rows.start, grid.rows.end - points);
        let local = first - window.start;
        let (weights, error) = interpolator.weights(&window.times[local..local + points], at);
        // The outermost values of a segment have fewer neighbours on one side.
        let inside = first > grid.rows.start && first + points < grid.rows.end;
        let worst = match inside {
            true => &mut quality.error,
            false => &mut quality.error_at_ends,
        };
        *worst = worst.max(error);
        for (values, ready) in window.values.iter().zip(&mut ready) {
            let near = &values[local..local + points];
            ready.push(weights.iter().zip(near).map(|(w, x)| w * x).sum());
        }
        if ready.first().is_some_and(|r| r.len() == BLOCK) || i + 1 == grid.count {
            for (output, ready) in outputs.iter_mut().zip(&mut ready) {
                output.push(ready)?;
                ready.clear();
            }
        }
    }
    Ok(quality)
}

/// The stamps and samples about the place being interpolated.
struct KernelWindow {
    rows: Range<usize>,
    start: usize,
    times: Vec<f64>,
    values: Vec<Vec<f64>>,
}

impl KernelWindow {
    fn new(rows: Range<usize>, columns: usize) -> KernelWindow {
        KernelWindow {
            start: rows.start,
            rows,
            times: Vec::new(),
            values: vec![Vec::new(); columns],
        }
    }

    fn time(&self, row: usize) -> f64 {
        self.times[row - self.start]
    }

    /// Makes sure that `points` rows on both sides of `row` are held, as far as there are any.
    fn load_around(
        &mut self,
        seconds: &SampleColumn,
        columns: &[&SampleColumn],
        row: usize,
        points: usize,
    ) -> Result<(), Error> {
        let last = (row + points + 2).min(self.rows.end);
        if last <= self.start + self.times.len() {
            return Ok(());
        }
        let start = row.saturating_sub(2 * points).max(self.rows.start);
        let count = (BLOCK + 4 * points).min(self.rows.end - start);
        self.start = start;
        self.times.resize(count, 0.0);
        seconds.read(start, &mut self.times)?;
        for (values, column) in self.values.iter_mut().zip(columns) {
            values.resize(count, 0.0);
            column.read(start, values)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A sine sampled at jittered instants comes out on the grid to the stated error.
    #[test]
    fn exact_sine_from_jittered_stamps() {
        let mut random = fastrand::Rng::with_seed(11);
        let rate = 100.0;
        let t: Vec<f64> = (0..40_000)
            .map(|i| f64::from(i) / rate + 2e-3 * (random.f64() - 0.5))
            .collect();
        let wave = |t: f64| (TAU * 17.3 * t).sin();
        let x: Vec<f64> = t.iter().map(|&t| wave(t)).collect();
        let (seconds, column) = (SampleColumn::from_slice(&t), SampleColumn::from_slice(&x));
        let rows = 0..t.len();
        let band = best_band(&seconds, &rows, rate).unwrap();
        assert!(band > 25.0, "{band}");
        let grid = UniformGrid {
            rows,
            start_s: 0.0,
            count: 40_000,
        };
        let mut out = [SampleColumn::default()];
        let quality = resample(&seconds, &[&column], &grid, rate, band, &mut out).unwrap();
        let error = quality.error;
        assert!(error < 2e-4, "{error}");
        let mut y = vec![0.0; out[0].len()];
        out[0].read(0, &mut y).unwrap();
        let worst = (40..39_960)
            .map(|i| (y[i] - wave(i as f64 / rate)).abs())
            .fold(0.0, f64::max);
        assert!(worst < 10.0 * error, "{worst} {error}");
        let wrong = |i: usize| (y[i] - wave(i as f64 / rate)).abs();
        let ends = (0..HALF_KERNEL).chain(40_000 - HALF_KERNEL..40_000);
        let worst = ends.map(wrong).fold(0.0, f64::max);
        assert!(worst < 3.0 * quality.error_at_ends, "{worst} {quality:?}");
    }
}
