//! Acceptance of poles as modes by band, uncertainty, share of the response power and phase collinearity.

use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::numeric::statistics::Z_95;

/// Pole with the data that decide whether it is a mode.
pub(super) struct ModeCandidate<'a> {
    /// The pole with its covariance and shape.
    pub mode: &'a ModalParameters,
    /// First and last line, Hz.
    pub band_hz: (f64, f64),
    /// Only one side of the peak lies within the band.
    pub is_peak_at_end: bool,
    /// Share of the response power in the half-power band of the pole, each response divided by its largest value.
    pub visibility: f64,
    /// The misfit exceeds the noise.
    pub model_error: bool,
    /// The responses depart from the linear model by more than noise.
    pub has_departures: bool,
    /// The responses are those to individual hits.
    pub by_hit: bool,
    /// The residues are repeatable from hit to hit.
    pub is_repeatable: bool,
    /// Neither noise nor departures explain the misfit.
    pub has_unexplained_misfit: bool,
}

/// Damping ratios above which a pole pair is background: in general, and for hits or responses that depart from the model.
const MAX_DAMPING_RATIO: (f64, f64) = (0.5, 0.3);

/// Largest standard deviation of a frequency, relative to the half-width, for responses that depart from the model.
const MAX_CERTAIN_STD: f64 = 0.5;

/// Visibility above which a pole of fewer than three responses belongs to a cancelling pair, and above which it is rejected even if it
/// alone explains a peak: two modes of equal size a third of a half-width apart reach the second.
const MAX_CANCELLING_RATIO: (f64, f64) = (2.0, 10.0);

/// Reason for rejecting a pole of a cancelling pair.
pub(super) const POLE_CANCELLATION: &str = "cancelled by its neighbours";

/// Reason for rejecting a pole with only one side of its peak within the band.
pub(super) const BAND_LIMIT: &str =
    "its peak lies at the end of the band, within a line or half of its half-width";

/// Reason for rejecting a pole whose residues are not repeatable over the hits.
pub(super) const NOT_REPEATABLE: &str = "its residues differ from hit to hit, as of noise or of a resonance folded down from above half the sample rate";

/// Least visibility and least phase collinearity of a mode if the misfit exceeds the noise.
const MIN_VISIBILITY: f64 = 0.05;
const MIN_COLLINEARITY: f64 = 0.5;

/// Reason for rejecting a pole as a mode; `None` if it is accepted.
pub(super) fn rejection_reason(candidate: &ModeCandidate) -> Option<&'static str> {
    let mode = candidate.mode;
    let (frequency, damping) = (mode.frequency_hz(), mode.damping_ratio());
    let (from, to) = candidate.band_hz;
    if !(from..=to).contains(&frequency) {
        return Some("outside the band");
    }
    if candidate.is_peak_at_end {
        return Some(BAND_LIMIT);
    }
    if candidate.has_unexplained_misfit {
        return Some("the fit misses the responses by far more than noise and departures explain");
    }
    let max_damping = match candidate.has_departures || candidate.by_hit {
        true => MAX_DAMPING_RATIO.1,
        false => MAX_DAMPING_RATIO.0,
    };
    if damping >= max_damping {
        return Some("damping too high for a mode: background");
    }
    let half_width = frequency * damping.abs();
    let max_std_ratio = if candidate.has_departures {
        MAX_CERTAIN_STD
    } else {
        1.0
    };
    if mode
        .frequency_std_hz()
        .is_none_or(|s| !(s < max_std_ratio * half_width))
    {
        return Some("its frequency is less certain than its half-power width");
    }
    if mode.damping_std().is_none_or(|s| !(s < damping.abs())) {
        return Some("its damping is uncertain by more than itself");
    }
    if candidate.model_error
        && mode
            .damping_std()
            .is_none_or(|s| !(Z_95 * s < damping.abs()))
    {
        return Some(
            "its damping is not known to be above zero, where the misfit exceeds the noise",
        );
    }
    if mode.shape.len() < 3 && candidate.visibility > MAX_CANCELLING_RATIO.0 {
        return Some(POLE_CANCELLATION);
    }
    if !candidate.is_repeatable {
        return Some(NOT_REPEATABLE);
    }
    if candidate.model_error && candidate.visibility < MIN_VISIBILITY {
        return Some("weakly observable, and the misfit exceeds the noise");
    }
    if candidate.model_error
        && mode.shape.len() >= 3
        && collinearity(&mode.shape) < MIN_COLLINEARITY
    {
        return Some("its components differ in phase, and the misfit exceeds the noise");
    }
    None
}

/// Returns `true` if a pole of a cancelling pair may still be a mode: for responses that depart from the model, the search has shown each
/// pole of the pair to be necessary.
pub(super) fn may_explain_peak(candidate: &ModeCandidate) -> bool {
    candidate.has_departures && candidate.visibility <= MAX_CANCELLING_RATIO.1
}

/// Modal phase collinearity (Juang and Pappa 1985), 0 to 1: 1 if all components lie on one line through the origin.
fn collinearity(shape: &[Complex]) -> f64 {
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for z in shape {
        xx += z.re * z.re;
        yy += z.im * z.im;
        xy += z.re * z.im;
    }
    let total = xx + yy;
    if total == 0.0 {
        return 0.0;
    }
    ((xx - yy) / total).powi(2) + (2.0 * xy / total).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reason_of_hit_pole(is_peak_at_end: bool, is_repeatable: bool) -> Option<&'static str> {
        let mode = ModalParameters {
            pole: Complex::new(-10.0, 1000.0),
            pole_covariance: Some([1.0, 1.0, 0.0]),
            shape: vec![Complex::new(1.0, 0.0)],
        };
        rejection_reason(&ModeCandidate {
            mode: &mode,
            band_hz: (1.0, 1000.0),
            is_peak_at_end,
            visibility: 0.5,
            model_error: false,
            has_departures: false,
            by_hit: true,
            is_repeatable,
            has_unexplained_misfit: false,
        })
    }

    /// Poles with only one side of the peak in the band, or with residues that differ from hit to hit, are rejected however certain.
    #[test]
    fn law_one_sided_and_unrepeated_poles_are_no_modes() {
        assert_eq!(reason_of_hit_pole(false, true), None);
        assert_eq!(reason_of_hit_pole(true, true), Some(BAND_LIMIT));
        assert_eq!(reason_of_hit_pole(false, false), Some(NOT_REPEATABLE));
    }

    /// With a model error, a damping of 1.1 ± 1.7 % is rejected and 1.1 ± 0.8 % accepted; without one, both are accepted.
    #[test]
    fn law_damping_is_above_zero() {
        let (omega, damping) = (1000.0, 0.011);
        let is_mode = |std: f64, model_error: bool| {
            let mode = ModalParameters {
                pole: Complex::new(-damping * omega, omega),
                pole_covariance: Some([(std * omega).powi(2), 1.0, 0.0]),
                shape: vec![Complex::new(1.0, 0.0)],
            };
            rejection_reason(&ModeCandidate {
                mode: &mode,
                band_hz: (1.0, 1000.0),
                is_peak_at_end: false,
                visibility: 0.5,
                model_error,
                has_departures: model_error,
                by_hit: false,
                is_repeatable: true,
                has_unexplained_misfit: false,
            })
            .is_none()
        };
        assert!(is_mode(0.004, true) && !is_mode(0.0087, true));
        assert!(is_mode(0.0087, false));
    }
}
