//! Sample rates an octave apart: a mode is sought at a rate a few times its frequency, so that block rows of one number span its periods
//! whatever the rate of the record and the number of channels.

use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};

/// Band of a rung over its rate. Two octaves and more: every frequency lies in two rungs.
const BAND_OVER_RATE: (f64, f64) = (0.075, 0.4);

/// Block rows of a rung: 2.4 periods of its lowest frequency.
const BLOCK_ROWS: usize = 32;

/// Block rows of the last rung, which reaches further down.
const LAST_BLOCK_ROWS: usize = 96;

/// The lowest frequency of the last rung over its rate, with all its block rows.
const LAST_LOW_OVER_RATE: f64 = 0.02;

/// Periods of the lowest frequency in the record, at least.
const MIN_PERIODS: f64 = 30.0;

/// Rungs of fewer samples are not halved again.
const MIN_SAMPLES_TO_HALVE: usize = 6000;

/// Samples for each block row, at least.
const MIN_SAMPLES_PER_ROW: usize = 24;

/// Parts of a record for the uncertainty, and samples for each of them and each block row.
const JACKKNIFE_PARTS: (usize, usize) = (5, 12);
const MIN_SAMPLES_PER_PART: usize = 10;

/// Block rows below which nothing is identified.
const MIN_ROWS: usize = 4;

/// One sample rate.
#[derive(Debug, Clone, PartialEq)]
pub struct DecimationLevel {
    /// The record's samples for one of this rung.
    pub factor: usize,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Frequencies of the modes sought, Hz.
    pub band_hz: (f64, f64),
    /// Block rows of the Hankel matrix.
    pub block_rows: usize,
    /// Parts of the record that are left out one after the other.
    pub parts: usize,
}

/// Decimation levels by falling rate, without those that hold nothing of `band_hz`, and the limits of the analysis.
///
/// # Errors
/// `TooShort` for a record without enough samples for a few block rows; `OutOfRange` for a band that no rung holds.
pub fn decimation_levels(
    rate_hz: f64,
    samples: usize,
    band_hz: Option<(f64, f64)>,
) -> Result<(Vec<DecimationLevel>, Vec<Diagnostic>), Error> {
    let duration = samples as f64 / rate_hz;
    if samples < MIN_SAMPLES_PER_ROW * MIN_ROWS {
        let message = format!("{samples} samples are too few for output-only identification");
        return Err(Error::new(Code::TooShort, message).with_hint(format!(
            "take a longer record: {} samples at least, better a thousand periods of the lowest mode",
            MIN_SAMPLES_PER_ROW * MIN_ROWS
        )));
    }
    let mut all: Vec<DecimationLevel> = Vec::new();
    loop {
        let factor = 1 << all.len();
        let (rate, count) = (rate_hz / factor as f64, samples / factor);
        let is_last = count < MIN_SAMPLES_TO_HALVE;
        let block_rows = match is_last {
            true => LAST_BLOCK_ROWS.min(count / MIN_SAMPLES_PER_ROW),
            false => BLOCK_ROWS,
        };
        let spanned = LAST_LOW_OVER_RATE * LAST_BLOCK_ROWS as f64 * rate / block_rows as f64;
        let low = match is_last {
            true => spanned.max(MIN_PERIODS / duration),
            false => BAND_OVER_RATE.0 * rate,
        };
        all.push(DecimationLevel {
            factor,
            rate_hz: rate,
            band_hz: (low, BAND_OVER_RATE.1 * rate),
            block_rows,
            parts: (count / (MIN_SAMPLES_PER_PART * block_rows))
                .clamp(JACKKNIFE_PARTS.0, JACKKNIFE_PARTS.1),
        });
        if is_last {
            break;
        }
    }
    let reach = (all[all.len() - 1].band_hz.0, all[0].band_hz.1);
    let diagnostics = limits(duration, rate_hz, reach, band_hz, &all);
    if let Some((low, high)) = band_hz {
        all.retain(|r| r.band_hz.0 <= high && r.band_hz.1 >= low);
        if all.is_empty() {
            let message = format!(
                "no mode can be identified from {low} to {high} Hz: a record of {duration:.4} s at {rate_hz} Hz covers modes from {:.4} to {:.4} Hz",
                reach.0, reach.1
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("widen the band, or take a longer record for lower modes or a higher sample rate for higher modes"));
        }
    }
    Ok((all, diagnostics))
}

/// Diagnostics for a stated band or a record length beyond the observable range.
fn limits(
    duration: f64,
    rate_hz: f64,
    reach: (f64, f64),
    band_hz: Option<(f64, f64)>,
    all: &[DecimationLevel],
) -> Vec<Diagnostic> {
    /// A band that ends so little beyond is not worth a word.
    const BAND_END_TOLERANCE: f64 = 1.05;
    let mut diagnostics = Vec::new();
    let mut warn = |code: &'static str, message: String, hint: String| {
        diagnostics.push(Diagnostic {
            code,
            message,
            hint: Some(hint),
        });
    };
    let rows = all[all.len() - 1].block_rows;
    let low = band_hz.map_or(0.0, |b| b.0);
    if rows < LAST_BLOCK_ROWS && low * BAND_END_TOLERANCE < reach.0 {
        warn(
            "few-block-rows",
            format!(
                "{rows} block rows where {LAST_BLOCK_ROWS} are usual, for the record is short: no mode is sought below {:.4} Hz",
                reach.0
            ),
            format!(
                "take a record {:.1} times as long",
                (LAST_BLOCK_ROWS * MIN_SAMPLES_PER_ROW) as f64
                    / (rows * MIN_SAMPLES_PER_ROW) as f64
            ),
        );
    } else if low > 0.0 && low * BAND_END_TOLERANCE < reach.0 {
        warn(
            "few-block-rows",
            format!(
                "no mode is sought below {:.4} Hz, though the band begins at {low} Hz: {duration:.4} s hold too few periods",
                reach.0
            ),
            format!("take a record of {:.4} s or more", duration * reach.0 / low),
        );
    }
    if let Some((_, high)) = band_hz.filter(|b| b.1 > reach.1 * BAND_END_TOLERANCE) {
        warn(
            "band-cut",
            format!(
                "no mode is sought above {:.4} Hz, {} of the sample rate, though the band ends at {high} Hz",
                reach.1, BAND_OVER_RATE.1
            ),
            format!(
                "sample at {:.0} Hz or more, instead of {rate_hz}",
                high / BAND_OVER_RATE.1
            ),
        );
    }
    diagnostics
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every frequency between the ends lies in two rungs, whatever the rate; 2.4 periods of the lowest fit into the block rows.
    #[test]
    fn law_rungs_overlap() {
        for (rate, samples) in [(12.0, 8000), (1651.0, 123_825), (25_600.0, 2_560_000)] {
            let (levels, diagnostics) = decimation_levels(rate, samples, None).unwrap();
            assert!(diagnostics.is_empty());
            for pair in levels.windows(3) {
                assert!(pair[2].band_hz.1 > pair[0].band_hz.0, "{pair:?}");
            }
            for level in &levels[..levels.len() - 1] {
                assert!(level.block_rows as f64 * level.band_hz.0 / level.rate_hz > 2.39);
            }
        }
    }

    #[test]
    fn law_limits_are_said() {
        let code = |samples: usize, band| {
            let (_, diagnostics) = decimation_levels(100.0, samples, band).unwrap();
            diagnostics.iter().map(|w| w.code).collect::<Vec<_>>()
        };
        assert_eq!(code(1000, None), ["few-block-rows"]);
        assert_eq!(code(20_000, Some((0.01, 30.0))), ["few-block-rows"]);
        assert_eq!(code(20_000, Some((1.0, 49.0))), ["band-cut"]);
        assert!(code(20_000, Some((5.0, 30.0))).is_empty());
        assert_eq!(
            decimation_levels(100.0, 50, None).unwrap_err().code,
            Code::TooShort
        );
        let nowhere = decimation_levels(100.0, 20_000, Some((45.0, 49.0)));
        assert_eq!(nowhere.unwrap_err().code, Code::OutOfRange);
    }
}
