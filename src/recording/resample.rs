//! Resampling of jittered samples to a uniform time base by least-squares band-limited interpolation.

use std::ops::Range;

use super::sample_column::SampleColumn;
use crate::base::error::Error;
use crate::numeric::band_limited::BandLimitedInterpolator;

/// Number of samples that contribute to each value.
const KERNEL_LEN: usize = 32;

/// Number of values at either end of a segment whose kernel is one-sided.
pub const HALF_KERNEL: usize = KERNEL_LEN / 2;

/// Candidate bands relative to the sample rate, widest first; the limit of 0.5 requires an infinite number of uniform samples.
const BAND_EDGES: [f64; 6] = [0.4, 0.36, 0.32, 0.28, 0.24, 0.2];

/// Largest relative error of an accepted band: −80 dB, below the noise of 16-bit converters in practice.
const MAX_BAND_ERROR: f64 = 1e-4;

/// Number of rows per block.
const BLOCK: usize = 1 << 14;

/// Interpolation error of a resampled signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResamplingError {
    /// Upper frequency limit of the band, Hz.
    pub band_hz: f64,
    /// Largest rms error of a value with a two-sided kernel, relative to the rms of a signal with a uniform spectrum in the band.
    pub error: f64,
    /// Largest relative rms error of the first and last values of a segment, [`HALF_KERNEL`] at either end.
    pub error_at_ends: f64,
}

/// Uniform time grid over one segment of time stamps.
#[derive(Debug, Clone)]
pub struct UniformGrid {
    /// Rows of the segment.
    pub rows: Range<usize>,
    /// Time of the first value, s.
    pub start_s: f64,
    /// Number of values.
    pub count: usize,
}

/// Widest candidate band, Hz, with an error up to `MAX_BAND_ERROR` in windows distributed over the segment; the narrowest candidate if
/// none satisfies it.
///
/// # Errors
/// The stamps cannot be read.
pub fn best_band(seconds: &SampleColumn, rows: &Range<usize>, rate_hz: f64) -> Result<f64, Error> {
    const TRIAL_WINDOWS: usize = 64;
    let points = KERNEL_LEN.min(rows.len());
    let mut times = vec![0.0; points];
    'bands: for share in BAND_EDGES {
        let mut interpolator = BandLimitedInterpolator::new(share * rate_hz, points);
        let last_start = rows.len() - points;
        for trial in 0..=TRIAL_WINDOWS.min(last_start) {
            let start = rows.start + last_start * trial / TRIAL_WINDOWS.min(last_start).max(1);
            seconds.read(start, &mut times)?;
            let middle = 0.5 * (times[(points - 1) / 2] + times[points / 2]);
            if interpolator.weights(&times, middle).1 > MAX_BAND_ERROR {
                continue 'bands;
            }
        }
        return Ok(share * rate_hz);
    }
    Ok(BAND_EDGES[BAND_EDGES.len() - 1] * rate_hz)
}

/// Resamples several columns of one segment with common weights and appends the values to `outputs`.
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
    let mut pending: Vec<Vec<f64>> = vec![Vec::with_capacity(BLOCK); columns.len()];
    let mut row = grid.rows.start;
    for i in 0..grid.count {
        let time = grid.start_s + i as f64 / rate_hz;
        // The row whose stamp is the last at or before `time`.
        loop {
            window.load_around(seconds, columns, row, points)?;
            if row + 1 >= grid.rows.end || window.time(row + 1) > time {
                break;
            }
            row += 1;
        }
        let first = (row + 1)
            .saturating_sub(points / 2)
            .clamp(grid.rows.start, grid.rows.end - points);
        let offset = first - window.start;
        let (weights, error) = interpolator.weights(&window.times[offset..offset + points], time);
        // The kernel of the outermost values of a segment is one-sided.
        let is_two_sided = first > grid.rows.start && first + points < grid.rows.end;
        let max_error = match is_two_sided {
            true => &mut quality.error,
            false => &mut quality.error_at_ends,
        };
        *max_error = max_error.max(error);
        for (values, pending) in window.values.iter().zip(&mut pending) {
            let neighbours = &values[offset..offset + points];
            pending.push(weights.iter().zip(neighbours).map(|(w, x)| w * x).sum());
        }
        if pending.first().is_some_and(|r| r.len() == BLOCK) || i + 1 == grid.count {
            for (output, pending) in outputs.iter_mut().zip(&mut pending) {
                output.push(pending)?;
                pending.clear();
            }
        }
    }
    Ok(quality)
}

/// Time stamps and samples around the interpolated instant.
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

    /// Loads the rows so that `points` rows on both sides of `row` are available within the segment.
    fn load_around(
        &mut self,
        seconds: &SampleColumn,
        columns: &[&SampleColumn],
        row: usize,
        points: usize,
    ) -> Result<(), Error> {
        let end = (row + points + 2).min(self.rows.end);
        if end <= self.start + self.times.len() {
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

    /// A sine sampled at jittered instants is reproduced on the grid within the stated error.
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
        let error_at = |i: usize| (y[i] - wave(i as f64 / rate)).abs();
        let ends = (0..HALF_KERNEL).chain(40_000 - HALF_KERNEL..40_000);
        let worst = ends.map(error_at).fold(0.0, f64::max);
        assert!(worst < 3.0 * quality.error_at_ends, "{worst} {quality:?}");
    }
}
