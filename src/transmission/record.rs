//! Synthetic transmission error over the output angle, `e(φ) = Σ A cos(o φ + ψ)`.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;

/// Maximum number of samples of a record.
pub const MAX_SAMPLES: usize = 1 << 24;

/// Number of samples per cycle of the highest order.
const SAMPLES_PER_CYCLE: f64 = 8.0;

/// Transmission error record at equal steps of the output angle.
#[derive(Debug, Clone)]
pub struct SyntheticRecord {
    /// Revolutions of the output.
    pub turns: usize,
    /// Whether the record is periodic: the first sample follows the last.
    pub closed: bool,
    /// Transmission error at `turns · i / n` revolutions, rad.
    pub values: Vec<f64>,
}

/// Revolutions of a record (default: the common period), and whether it is periodic; `fastest` is the highest order, cycles/rev.
///
/// # Errors
/// A record with more than `MAX_SAMPLES` samples.
pub fn record_revolutions(
    requested: Option<u32>,
    period: Option<&Fraction>,
    fastest: f64,
) -> Result<(usize, bool), Error> {
    let sample_count = |turns: f64| (turns * fastest.max(1.0) * SAMPLES_PER_CYCLE).ceil();
    let period = period.map_or(Fraction::one(), |period| {
        // A period of a fraction of a revolution is repeated up to an integer number of revolutions.
        let times = Fraction::greatest_common_divisor([period, &Fraction::one()].into_iter());
        times.map_or(period.clone(), |m| &(period * &Fraction::one()) / &m)
    });
    let turns = requested.map_or(period.to_f64(), f64::from);
    if sample_count(turns) > MAX_SAMPLES as f64 {
        let message = format!(
            "{turns} turns of the output with {fastest:.0} cycles in each need {:.1e} samples (limit {MAX_SAMPLES})",
            sample_count(turns)
        );
        return Err(Error::new(Code::BudgetExceeded, message)
            .with_hint("state a shorter --window, in whole turns"));
    }
    let closed = (&Fraction::new(turns as i64, 1) / &period).is_integer();
    Ok((turns as usize, closed))
}

/// Sums the harmonics `lines` (order, complex amplitude in rad); `fastest` is the highest order resolved, cycles per revolution.
pub fn synthesise(
    lines: &[(f64, Complex)],
    turns: usize,
    fastest: f64,
    closed: bool,
) -> SyntheticRecord {
    /// Number of samples after which the phasor is recomputed to limit its rounding error.
    const PHASOR_RESTART: usize = 1024;
    let count = ((turns as f64 * fastest * SAMPLES_PER_CYCLE).ceil() as usize).max(64 * turns);
    let mut values = vec![0.0; count];
    for &(order, value) in lines {
        let cycles = order * turns as f64 / count as f64;
        let step = Complex::cis(TAU * cycles);
        for (block, part) in values.chunks_mut(PHASOR_RESTART).enumerate() {
            // Integer cycles are removed before the angle is formed.
            let mut z =
                value * Complex::cis(TAU * (cycles * (block * PHASOR_RESTART) as f64).fract());
            for e in part {
                *e += z.re;
                z *= step;
            }
        }
    }
    SyntheticRecord {
        turns,
        closed,
        values,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples agree with the formula over a million of them.
    #[test]
    fn exact_samples() {
        let lines = [
            (1.0, Complex::new(1.0, 0.5)),
            (112.5, Complex::new(-0.2, 0.1)),
            (6750.0, Complex::new(0.0, 0.1)),
        ];
        let record = synthesise(&lines, 20, 6750.0, true);
        for i in [0, 1, 17, 54_321, record.values.len() - 1] {
            let phi = 20.0 * i as f64 / record.values.len() as f64;
            let exact: f64 = lines
                .iter()
                .map(|(o, z)| (*z * Complex::cis(TAU * (o * phi).fract())).re)
                .sum();
            assert!((record.values[i] - exact).abs() < 1e-10, "{i}");
        }
    }

    /// The default record is the common period in integer revolutions; a period with too many samples is rejected.
    #[test]
    fn refuses_periods_beyond_a_record() {
        assert_eq!(
            record_revolutions(None, Some(&Fraction::new(4, 1)), 100.0).unwrap(),
            (4, true)
        );
        assert_eq!(
            record_revolutions(None, Some(&Fraction::new(3, 2)), 100.0).unwrap(),
            (3, true)
        );
        assert_eq!(
            record_revolutions(Some(2), Some(&Fraction::new(4, 1)), 100.0).unwrap(),
            (2, false)
        );
        let error =
            record_revolutions(None, Some(&Fraction::new(1_000_000_007, 1)), 100.0).unwrap_err();
        assert_eq!(error.code, Code::BudgetExceeded);
    }
}
