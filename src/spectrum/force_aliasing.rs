//! Aliasing of hits: the power that a sampled force has left at half the sample rate.
//!
//! A force that drives beyond half the rate `f_s` excites resonances there, and without a filter in front of the converter one at `f`
//! appears at `f_s − f`, as sharp as it is.

use crate::base::error::Diagnostic;

/// Sampling of the pulses of a force, by the fall of its spectrum towards half the sample rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PulseSampling {
    /// It falls by 30 dB or more.
    Resolved,
    /// It falls less, by so many decibels: what lies above may be driven, and folded down.
    Folded(f64),
    /// It does not fall: a pulse of one sample, of unknown length, behind no filter.
    Unresolved,
}

/// Power over its largest in the top tenth of the lines below which a force drives nothing above them: 30 dB, as of the driven band.
const RESOLVED_SHARE: f64 = 1e-3;
const TOP_SHARE: usize = 10;

/// Power over its largest in the last fiftieth of the lines from which on nothing has filtered the force: 3 dB. A filter of a converter
/// with its edge at half the rate leaves 6 dB there.
const UNFILTERED_SHARE: f64 = 0.5;
const LAST_SHARE: usize = 50;

impl PulseSampling {
    /// Sampling of a force by the power of its lines, from zero to half the sample rate.
    pub fn new(power: &[f64]) -> PulseSampling {
        let largest = power.iter().copied().fold(0.0, f64::max);
        let top = |share: usize| {
            let lines = &power[power.len() - power.len().div_ceil(share)..];
            lines.iter().sum::<f64>() / (largest * lines.len() as f64)
        };
        match (top(LAST_SHARE), top(TOP_SHARE)) {
            (last, _) if last > UNFILTERED_SHARE => PulseSampling::Unresolved,
            (_, top) if top > RESOLVED_SHARE => PulseSampling::Folded(-10.0 * top.log10()),
            _ => PulseSampling::Resolved,
        }
    }

    /// Warning about resonances that may be folded down; `None` where the pulses are resolved.
    pub fn warning(self, rate_hz: f64) -> Option<Diagnostic> {
        let half = 0.5 * rate_hz;
        let (seen, consequence) = match self {
            PulseSampling::Resolved => return None,
            PulseSampling::Folded(decibels) => (
                format!("falls by only {decibels:.0} dB"),
                "unless a filter in front of the converter removes them, resonances above appear below it as if they were modes",
            ),
            PulseSampling::Unresolved => (
                "does not fall".to_string(),
                "the pulse lasts one sample, and any mode may be a resonance above that is folded down: all are listed as weak",
            ),
        };
        Some(Diagnostic {
            code: "aliasing",
            message: format!(
                "the spectrum of the force {seen} up to half the sample rate, {half:.4} Hz: {consequence}"
            ),
            hint: Some(
                "use a softer tip, measure at a higher rate, or with an anti-alias filter"
                    .to_string(),
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Half a sine of so many samples has a spectrum known in closed form: `cos(πfτ)/(1 − 4f²τ²)`, without folding; of two samples it falls
    /// by 7.4 dB at nine tenths and by 9.5 dB at the end of the band.
    #[test]
    fn law_longer_pulses_are_resolved() {
        let of = |width: f64| {
            let line = |k: usize| {
                let x = 0.5 * k as f64 / 999.0 * width;
                ((PI * x).cos() / (1.0 - 4.0 * x * x)).powi(2)
            };
            PulseSampling::new(&(0..1000).map(line).collect::<Vec<f64>>())
        };
        assert!(matches!(of(2.0), PulseSampling::Folded(db) if (7.4..9.6).contains(&db)));
        assert!(matches!(of(4.0), PulseSampling::Folded(_)));
        assert_eq!(of(8.0), PulseSampling::Resolved);
        assert_eq!(PulseSampling::new(&[1.0; 100]), PulseSampling::Unresolved);
        assert!(of(8.0).warning(1000.0).is_none());
    }
}
