//! Acceptance of poles as modes: band, certainty, visibility, phase collinearity.

use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::numeric::statistics::Z_95;

/// Data by which a pole is accepted as a mode.
pub(super) struct ModeCandidate<'a> {
    /// The pole with its covariance and shape.
    pub mode: &'a ModalParameters,
    /// First and last line, Hz.
    pub band_hz: (f64, f64),
    /// The lines show one side of its peak alone.
    pub is_peak_at_end: bool,
    /// Share of the responses' power in its half-power band, each response over its largest value.
    pub visibility: f64,
    /// The misfit is beyond what noise explains.
    pub model_error: bool,
    /// Noise alone does not explain the responses.
    pub departs: bool,
    /// The responses are those to single hits.
    pub by_hit: bool,
    /// Residues repeat from hit to hit.
    pub repeats: bool,
    /// Neither noise nor departures explain the misfit: the lines that decide are taken for exact.
    pub unexplained: bool,
}

/// From this damping ratio on a pole pair is background; of hits, and where responses depart from the model, from the second on.
const MAX_DAMPING_RATIO: (f64, f64) = (0.5, 0.3);

/// Largest standard deviation of a frequency over the half-width, where responses depart from the model.
const MAX_CERTAIN_STD: f64 = 0.5;

/// Below three responses a pole with so many times the power that was measured is one of a pair that cancel; beyond the second it is no
/// mode even where it alone explains a peak: two modes of equal size a third of a half-width apart reach it.
const MAX_CANCELLING_RATIO: (f64, f64) = (2.0, 10.0);

/// Why one of a pair that cancel is not a mode.
pub(super) const CANCELLED: &str = "cancelled by its neighbours";

/// Why a pole with one side of its peak within the band is not a mode.
pub(super) const AT_END: &str =
    "its peak lies at the end of the band, within a line or half of its half-width";

/// Why a pole whose residues have no mean over the hits is not a mode.
pub(super) const UNREPEATED: &str = "its residues differ from hit to hit, as of noise or of a resonance folded down from above half the sample rate";

/// Least share of the power, and least phase collinearity, where a model error is proven.
const MIN_VISIBILITY: f64 = 0.05;
const MIN_COLLINEARITY: f64 = 0.5;

/// Why a pole is not a mode; `None` if it is.
pub(super) fn rejection_reason(candidate: &ModeCandidate) -> Option<&'static str> {
    let mode = candidate.mode;
    let (frequency, damping) = (mode.frequency_hz(), mode.damping_ratio());
    let (from, to) = candidate.band_hz;
    if !(from..=to).contains(&frequency) {
        return Some("outside the band");
    }
    if candidate.is_peak_at_end {
        return Some(AT_END);
    }
    if candidate.unexplained {
        return Some("the fit misses the responses by far more than noise and departures explain");
    }
    let background = match candidate.departs || candidate.by_hit {
        true => MAX_DAMPING_RATIO.1,
        false => MAX_DAMPING_RATIO.0,
    };
    if damping >= background {
        return Some("damped so much that it is background");
    }
    let half_width = frequency * damping.abs();
    let certain = if candidate.departs {
        MAX_CERTAIN_STD
    } else {
        1.0
    };
    if mode
        .frequency_std_hz()
        .is_none_or(|s| !(s < certain * half_width))
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
        return Some(CANCELLED);
    }
    if !candidate.repeats {
        return Some(UNREPEATED);
    }
    if candidate.model_error && candidate.visibility < MIN_VISIBILITY {
        return Some("hardly seen, where the misfit exceeds the noise");
    }
    if candidate.model_error
        && mode.shape.len() >= 3
        && collinearity(&mode.shape) < MIN_COLLINEARITY
    {
        return Some("its components share no phase, where the misfit exceeds the noise");
    }
    None
}

/// Whether a pole that cancels with others may be a mode all the same: where responses depart from the model each pole of a pair has been
/// found needed next to the other.
pub(super) fn may_explain_peak(candidate: &ModeCandidate) -> bool {
    candidate.departs && candidate.visibility <= MAX_CANCELLING_RATIO.1
}

/// Modal phase collinearity (Juang and Pappa 1985): 1 where all components lie on one line of the complex plane.
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

    fn certain(is_peak_at_end: bool, repeats: bool) -> Option<&'static str> {
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
            departs: false,
            by_hit: true,
            repeats,
            unexplained: false,
        })
    }

    /// However certain, a pole with one side of its peak in the band is no mode, nor is one whose residues differ from hit to hit.
    #[test]
    fn law_one_sided_and_unrepeated_poles_are_no_modes() {
        assert_eq!(certain(false, true), None);
        assert_eq!(certain(true, true), Some(AT_END));
        assert_eq!(certain(false, false), Some(UNREPEATED));
    }

    /// A damping of 1.1 ± 1.7 % is no damping where more than noise is left; of 1.1 ± 0.8 % it is, as either is where only noise is left.
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
                departs: model_error,
                by_hit: false,
                repeats: true,
                unexplained: false,
            })
            .is_none()
        };
        assert!(is_mode(0.004, true) && !is_mode(0.0087, true));
        assert!(is_mode(0.0087, false));
    }
}
