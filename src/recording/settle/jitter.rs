//! Jittered rows resampled onto even steps.

use super::Settled;
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::recording::column::Column;
use crate::recording::raw::Stamps;
use crate::recording::resample::{self, Grid};
use crate::recording::stated_rates::SAME_RATE;
use crate::recording::time_base::{Spacing, TimeBase};

impl Settled {
    /// Resamples jittered rows.
    pub(super) fn even_out(&mut self, base: &TimeBase, stamps: &Stamps) -> Result<(), Error> {
        let Spacing::Jittered {
            rms_s,
            most_s,
            steps_s: (short, long),
        } = base.spacing
        else {
            return Ok(());
        };
        let (rate, seconds) = (self.rate_hz, &stamps.seconds);
        let resolution_s = stamps.resolution.at(0.0);
        let longest = base
            .stretches
            .iter()
            .max_by_key(|s| s.len())
            .cloned()
            .unwrap_or(0..0);
        if longest.len() < 3 {
            let message = format!(
                "the longest stretch without a gap has {} samples",
                longest.len()
            );
            return Err(Error::new(Code::TooShort, message));
        }
        /// A clock that runs this many times as fast elsewhere has no rate.
        const UNEVEN: f64 = 2.0;
        /// Rows that tell the drift from the jitter.
        const TELLING: usize = 100;
        if longest.len() >= TELLING && base.drift_hz.1 > UNEVEN * base.drift_hz.0 {
            let text = crate::base::units::seconds;
            let message = format!(
                "the time stamps are too uneven to resample: steps of {} to {}",
                text(short),
                text(long)
            );
            return Err(Error::new(Code::BadTime, message)
                .hint("log with even steps, or leave the stamps aside: --time none --rate HZ"));
        }
        let band = resample::best_band(seconds, &longest, rate)?;
        let columns: Vec<&Column> = self.channels.iter().map(|c| &c.samples).collect();
        let mut outputs: Vec<Column> = columns.iter().map(|_| Column::default()).collect();
        let (mut worst, mut worst_at_ends, mut at) = (0.0f64, 0.0f64, 0);
        for (rows, &start_s) in base.stretches.iter().zip(&base.starts) {
            let grid = Grid {
                rows: rows.clone(),
                start_s,
                count: rows.len(),
            };
            let quality = resample::resample(seconds, &columns, &grid, rate, band, &mut outputs)?;
            worst = worst.max(quality.error);
            worst_at_ends = worst_at_ends.max(quality.error_at_ends);
        }
        // The outputs hold the stretches end to end.
        for stretch in &mut self.stretches {
            stretch.rows = at..at + stretch.rows.len();
            at = stretch.rows.end;
        }
        for (channel, output) in self.channels.iter_mut().zip(outputs) {
            channel.samples = output;
        }
        /// An error this large, −20 dB, is no resampling.
        const USELESS: f64 = 0.1;
        if worst > USELESS {
            let message = format!(
                "the time stamps are too uneven to resample: even below {band:.4} Hz the error would be {:.0} %",
                100.0 * worst
            );
            return Err(Error::new(Code::BadTime, message)
                .hint("log with even steps, or leave the stamps aside: --time none --rate HZ"));
        }
        let decibels = |error: f64| 20.0 * error.max(1e-12).log10();
        let minus = |error: f64| format!("{:.0}", decibels(error)).replace('-', "−");
        let (inside, at_ends) = (minus(worst), minus(worst_at_ends));
        let ends = resample::ENDS;
        let text = crate::base::units::seconds;
        let drift = match (base.drift_hz.1 / base.drift_hz.0 - 1.0).abs() > SAME_RATE {
            true => format!(
                "; the clock drifts between {:.1} and {:.1} Hz",
                base.drift_hz.0, base.drift_hz.1
            ),
            false => String::new(),
        };
        // Stamps whose last digit is a good part of a step are rounded as well.
        const COARSE: f64 = 0.02;
        let rounded = match resolution_s * rate > COARSE {
            true => format!(", rounded to {}", text(resolution_s)),
            false => String::new(),
        };
        let message = format!(
            "resampled to {rate:.6} Hz, band-limited: error below {inside} dB up to {band:.4} Hz, {at_ends} dB within {ends} samples of an end of a stretch (stamps up to {} off an even grid, {} rms, steps of {} to {}{rounded}{drift})",
            text(most_s),
            text(rms_s),
            text(short),
            text(long)
        );
        self.repair("resampled", message);
        let message = format!("the jitter of the time stamps limits trust above {band:.4} Hz");
        self.warnings.push(Warning {
            code: "time-jitter",
            message,
            hint: None,
        });
        Ok(())
    }
}
