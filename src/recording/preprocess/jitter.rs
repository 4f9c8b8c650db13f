//! Resampling of rows with jittered time stamps.

use super::Preprocessing;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::recording::raw::TimeStamps;
use crate::recording::resample::{self, UniformGrid};
use crate::recording::sample_column::SampleColumn;
use crate::recording::stated_rates::SAME_RATE;
use crate::recording::time_base::{Spacing, TimeBase};

impl Preprocessing {
    /// Resamples jittered rows.
    pub(super) fn resample_jitter(
        &mut self,
        base: &TimeBase,
        stamps: &TimeStamps,
    ) -> Result<(), Error> {
        let Spacing::Jittered {
            rms_s,
            max_s: most_s,
            steps_s: (short, long),
        } = base.spacing
        else {
            return Ok(());
        };
        let (rate, seconds) = (self.rate_hz, &stamps.seconds);
        let resolution_s = stamps.resolution.unit_at(0.0);
        let longest = base
            .segments
            .iter()
            .max_by_key(|s| s.len())
            .cloned()
            .unwrap_or(0..0);
        if longest.len() < 3 {
            let message = format!(
                "the longest segment without a gap has {} samples",
                longest.len()
            );
            return Err(Error::new(Code::TooShort, message));
        }
        /// A clock that runs this many times as fast elsewhere has no rate.
        const MAX_RATE_RATIO: f64 = 2.0;
        /// Rows that tell the drift from the jitter.
        const MIN_ROWS_FOR_DRIFT: usize = 100;
        if longest.len() >= MIN_ROWS_FOR_DRIFT && base.drift_hz.1 > MAX_RATE_RATIO * base.drift_hz.0
        {
            let text = crate::base::quantity::format_time;
            let message = format!(
                "the time stamps are too uneven to resample: steps of {} to {}",
                text(short),
                text(long)
            );
            return Err(Error::new(Code::InvalidTimeStamps, message).with_hint(
                "log with even steps, or leave the stamps aside: --time none --rate HZ",
            ));
        }
        let band = resample::best_band(seconds, &longest, rate)?;
        let columns: Vec<&SampleColumn> = self.channels.iter().map(|c| &c.samples).collect();
        let mut outputs: Vec<SampleColumn> =
            columns.iter().map(|_| SampleColumn::default()).collect();
        let (mut worst, mut worst_at_ends, mut at) = (0.0f64, 0.0f64, 0);
        for (rows, &start_s) in base.segments.iter().zip(&base.segment_starts) {
            let grid = UniformGrid {
                rows: rows.clone(),
                start_s,
                count: rows.len(),
            };
            let quality = resample::resample(seconds, &columns, &grid, rate, band, &mut outputs)?;
            worst = worst.max(quality.error);
            worst_at_ends = worst_at_ends.max(quality.error_at_ends);
        }
        // The outputs hold the segments end to end.
        for segment in &mut self.segments {
            segment.rows = at..at + segment.rows.len();
            at = segment.rows.end;
        }
        for (channel, output) in self.channels.iter_mut().zip(outputs) {
            channel.samples = output;
        }
        /// An error this large, −20 dB, is no resampling.
        const MAX_ERROR: f64 = 0.1;
        if worst > MAX_ERROR {
            let message = format!(
                "the time stamps are too uneven to resample: even below {band:.4} Hz the error would be {:.0} %",
                100.0 * worst
            );
            return Err(Error::new(Code::InvalidTimeStamps, message).with_hint(
                "log with even steps, or leave the stamps aside: --time none --rate HZ",
            ));
        }
        let decibels = |error: f64| 20.0 * error.max(1e-12).log10();
        let minus = |error: f64| format!("{:.0}", decibels(error)).replace('-', "−");
        let (inside, at_ends) = (minus(worst), minus(worst_at_ends));
        let ends = resample::HALF_KERNEL;
        let text = crate::base::quantity::format_time;
        let drift = match (base.drift_hz.1 / base.drift_hz.0 - 1.0).abs() > SAME_RATE {
            true => format!(
                "; the clock drifts between {:.1} and {:.1} Hz",
                base.drift_hz.0, base.drift_hz.1
            ),
            false => String::new(),
        };
        // Stamps whose last digit is a good part of a step are rounded as well.
        const WARN_ERROR: f64 = 0.02;
        let rounded = match resolution_s * rate > WARN_ERROR {
            true => format!(", rounded to {}", text(resolution_s)),
            false => String::new(),
        };
        let message = format!(
            "resampled to {rate:.6} Hz, band-limited: error below {inside} dB up to {band:.4} Hz, {at_ends} dB within {ends} samples of an end of a segment (stamps up to {} off an even grid, {} rms, steps of {} to {}{rounded}{drift})",
            text(most_s),
            text(rms_s),
            text(short),
            text(long)
        );
        self.push_repair("resampled", message);
        let message = format!(
            "the time stamps are uneven: the signals were resampled, accurately up to {band:.4} Hz"
        );
        self.diagnostics.push(Diagnostic {
            code: "time-jitter",
            message,
            hint: None,
        });
        Ok(())
    }
}
