//! Rule for weak modes, and rejected stable columns of a stabilisation diagram, each with its reason.

use std::f64::consts::TAU;

use super::identification_result::IdentifiedMode;
use super::method::IdentificationMethod;
use crate::identify::modal::selection::SelectionRule;
use crate::identify::modal::stabilisation::{PoleStability, StabilisationPole};
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::numeric::sorting::sort_ascending;
use crate::numeric::statistics::Z_95;

/// Maximum standard deviation of the frequency, as a share of the half-power half-bandwidth, and of the damping, relative.
const MAX_CERTAIN_STD: f64 = 0.2;

/// Maximum departure from the linear model, as a share of the mode: above it the residual is as large as other modes.
const MAX_DEPARTURE: f64 = 0.3;

/// Maximum relative standard deviation of damping for a mode narrower than the line spacing, in operational analysis.
const KNOWN_DAMPING: f64 = 0.1;

/// Minimum coherence of a mode narrower than the line spacing.
const NARROW_COHERENCE: f64 = 0.8;

/// Reason for weak modes from force pulses of one sample.
pub const UNRESOLVED_PULSE: &str = "the pulse of the force lasts one sample: it may be folded down from above half the sample rate";

/// Rule for weak modes of a method, one sentence. Operational analysis rarely finds a frequency to a tenth of the half-power bandwidth.
pub fn rule(method: IdentificationMethod) -> &'static str {
    match method {
        IdentificationMethod::SsiCov | IdentificationMethod::SsiData => {
            "weak: a damping interval that includes zero with a standard deviation of frequency above an eighth of the half-power width (of modes in 80 % of the orders: above 0.6 % as well), a half-power width below a line of the record with a damping known to no better than 10 %, or a sine removed within the half-power band with a standard deviation of frequency above a tenth of that band"
        }
        _ => {
            "weak: a standard deviation of frequency above a tenth of the half-power width or of damping above a fifth of itself, a departure from the linear model above 30 %, a half-power width below a line with a coherence below 0.8, or hits of one sample"
        }
    }
}

/// True if the 95 % confidence interval of the damping ratio includes zero, as for a sine or noise; `None` without an uncertainty.
pub fn damping_includes_zero(mode: &ModalParameters) -> Option<bool> {
    Some(Z_95 * mode.damping_std()? >= mode.damping_ratio())
}

/// Maximum standard deviation of the frequency, as a share of the half-power half-bandwidth, of a resonance with a damping interval
/// that includes zero, in operational analysis …
const CERTAIN_RESONANCE: f64 = 0.25;

/// … or minimum presence over the orders, and maximum relative standard deviation of the frequency. A measured mode of 16.271 ± 0.088 Hz and
/// 0.29 ± 0.45 % damping is in 93 % of the orders; noise poles scatter by 2 % and more.
const CERTAIN_COLUMN: (f64, f64) = (0.8, 0.006);

/// True if an operational mode is a resonance in spite of an uncertain damping.
fn is_certain_resonance(identified: &IdentifiedMode) -> bool {
    let (mode, frequency) = (&identified.mode, identified.frequency_hz());
    let half_width = mode.pole.re.abs() / TAU;
    let is_column = identified.presence.is_some_and(|p| p >= CERTAIN_COLUMN.0);
    mode.frequency_std_hz().is_some_and(|std| {
        std < CERTAIN_RESONANCE * half_width || (is_column && std < CERTAIN_COLUMN.1 * frequency)
    })
}

/// Reason why the damping of an operational mode does not prove a resonance; `None` if it does or has no uncertainty. `line_hz` is the
/// line spacing, Hz.
pub fn unresolved_damping(identified: &IdentifiedMode, line_hz: f64) -> Option<&'static str> {
    let mode = &identified.mode;
    let width = 2.0 * mode.pole.re.abs() / TAU;
    if damping_includes_zero(mode)? && !is_certain_resonance(identified) {
        return Some("the interval of its damping includes zero, and its frequency is uncertain");
    }
    (width < line_hz && mode.damping_std()? > KNOWN_DAMPING * mode.damping_ratio()).then_some(
        "its half-power width is below a line, and its damping is known to no better than 10 %",
    )
}

/// True if the standard deviation of the frequency exceeds a tenth of the half-power bandwidth.
pub fn is_frequency_uncertain(mode: &ModalParameters) -> bool {
    let half_width = mode.pole.re.abs() / TAU;
    (mode.frequency_std_hz()).is_some_and(|std| std > MAX_CERTAIN_STD * half_width)
}

/// Reason why a mode is weak; `None` if it is not or has no uncertainty. `line_hz` is the line spacing, Hz.
pub fn reason(mode: &IdentifiedMode, line_hz: f64, coherence: Option<f64>) -> Option<&'static str> {
    // The widening of an interval from two hits is no property of the mode.
    let widening = mode.departure.map_or(1.0, |d| d.two_hit_factor);
    let mut fitted = mode.mode.clone();
    fitted.pole_covariance = Some(fitted.pole_covariance?.map(|c| c / widening.powi(2)));
    let is_narrow = 2.0 * fitted.pole.re.abs() / TAU < line_hz;
    let is_incoherent = is_narrow && coherence.is_some_and(|c| c < NARROW_COHERENCE);
    let is_damping_uncertain = (fitted.damping_std())
        .is_some_and(|std| std > MAX_CERTAIN_STD * fitted.damping_ratio().abs());
    let is_nonlinear = mode
        .departure
        .is_some_and(|d| d.model_error > MAX_DEPARTURE);
    let reasons = [
        (
            damping_includes_zero(&fitted) == Some(true),
            "the interval of its damping includes zero",
        ),
        (
            is_frequency_uncertain(&fitted),
            "its frequency is uncertain by more than a tenth of its half-power width",
        ),
        (
            is_damping_uncertain,
            "its damping is uncertain by more than a fifth",
        ),
        (
            is_nonlinear,
            "it departs from the linear model by more than 30 %: the residual is as large as other modes",
        ),
        (
            is_incoherent,
            "its half-power width is below a line, and its coherence below 0.8",
        ),
    ];
    reasons.into_iter().find(|r| r.0).map(|r| r.1)
}

/// Modes and weak modes, each by ascending frequency; `is_joined` returns all as modes. Weak modes have their `reason`.
pub fn split_weak(
    mut all: Vec<IdentifiedMode>,
    reason: impl Fn(&IdentifiedMode) -> Option<&'static str>,
    is_joined: bool,
) -> (Vec<IdentifiedMode>, Vec<IdentifiedMode>) {
    for mode in &mut all {
        mode.weak = reason(mode);
    }
    sort_ascending(&mut all, |a| a.frequency_hz());
    all.into_iter().partition(|m| is_joined || m.weak.is_none())
}

/// Maximum relative frequency difference of neighbouring stable poles of one column.
const COLUMN_TOLERANCE: f64 = 0.005;

/// Minimum number of orders of a column.
const MIN_ORDERS: usize = 3;

/// Rejected stable columns of a diagram: pole, rad/s, and reason.
pub fn columns(
    poles: &[StabilisationPole],
    modes: &[IdentifiedMode],
    band_hz: (f64, f64),
    rule: &SelectionRule,
) -> Vec<(Complex, &'static str)> {
    let mut orders: Vec<usize> = poles.iter().map(|p| p.order).collect();
    orders.dedup();
    let mut stable: Vec<&StabilisationPole> = (poles.iter())
        .filter(|p| p.stability == PoleStability::Stable)
        .collect();
    sort_ascending(&mut stable, |a| a.frequency_hz);
    let is_same_column = |a: &&StabilisationPole, b: &&StabilisationPole| {
        b.frequency_hz - a.frequency_hz < COLUMN_TOLERANCE * b.frequency_hz
    };
    let mut omitted = Vec::new();
    for column in stable.chunk_by(is_same_column) {
        let mut column_orders: Vec<usize> = column.iter().map(|p| p.order).collect();
        column_orders.sort_unstable();
        column_orders.dedup();
        let middle = column[column.len() / 2];
        let (f, damping) = (middle.frequency_hz, middle.damping_ratio);
        let limits = (
            column[0].frequency_hz,
            column[column.len() - 1].frequency_hz,
        );
        let is_identified = |m: &IdentifiedMode| (limits.0..=limits.1).contains(&m.frequency_hz());
        if column_orders.len() < MIN_ORDERS || modes.iter().any(is_identified) {
            continue;
        }
        let half_width = |m: &IdentifiedMode| m.mode.pole.re.abs() / TAU;
        let is_near = |m: &IdentifiedMode| {
            (m.frequency_hz() - f).abs() < half_width(m).max(COLUMN_TOLERANCE * f)
        };
        let reason = if !(band_hz.0..=band_hz.1).contains(&f) {
            "a stable column outside the band"
        } else if !(0.0..=rule.max_damping_ratio).contains(&damping) {
            "a stable column whose damping is negative or that of a background"
        } else if modes.iter().any(is_near) {
            "a stable column within the half-power band of a mode, taken as that mode"
        } else if (column_orders.len() as f64) < rule.presence * orders.len() as f64 {
            "a stable column over fewer than a third of the orders"
        } else {
            "a stable column whose poles differ from order to order by more than half a half-bandwidth"
        };
        let pole = Complex::new(-damping, (1.0 - damping * damping).max(0.0).sqrt()) * (TAU * f);
        omitted.push((pole, reason));
    }
    omitted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::rational::ModelErrorShare;

    fn mode(
        frequency_hz: f64,
        damping: f64,
        frequency_std: f64,
        damping_std: f64,
    ) -> IdentifiedMode {
        let w = TAU * frequency_hz;
        IdentifiedMode::from(ModalParameters {
            pole: Complex::new(-damping, (1.0 - damping * damping).sqrt()) * w,
            pole_covariance: Some([
                (damping_std * w).powi(2),
                (TAU * frequency_std).powi(2),
                0.0,
            ]),
            shape: Vec::new(),
        })
    }

    /// 543.68 ± 0.11 Hz with a damping of 0.034 ± 0.027 %: half-power width 0.37 Hz, lines 0.5 Hz.
    #[test]
    fn law_weak_modes() {
        let narrow = mode(543.68, 0.00034, 0.056, 0.000138);
        assert!(reason(&narrow, 0.5, None).is_some_and(|r| r.contains("tenth")));
        let why = |m: &IdentifiedMode, line_hz| reason(m, line_hz, Some(1.0)).unwrap_or_default();
        assert!(why(&mode(500.0, 0.001, 0.01, 0.0006), 0.1).contains("zero"));
        assert!(why(&mode(500.0, 0.001, 0.2, 0.0001), 0.1).contains("tenth"));
        assert!(why(&mode(500.0, 0.001, 0.05, 0.00025), 0.1).contains("fifth"));
        assert_eq!(why(&mode(500.0, 0.001, 0.01, 0.00002), 2.0), "");
    }

    /// A peak of a plate, 49.737 ± 0.042 Hz with a damping of 0.422 ± 0.085 %, is a mode in spite of its narrow width; a departure by half of
    /// the mode makes it weak, whatever its intervals.
    #[test]
    fn law_departing_modes_are_weak() {
        let departing = |share: f64| IdentifiedMode {
            departure: Some(ModelErrorShare {
                model_error: share,
                groups: 5,
                frequency_spread_hz: 0.0,
                damping_spread: 0.0,
                two_hit_factor: 1.0,
                by_hit: true,
            }),
            ..mode(49.737, 0.00422, 0.021, 0.00043)
        };
        let weak_reason = |m: &IdentifiedMode| reason(m, 0.512, Some(0.998));
        assert_eq!(weak_reason(&departing(0.274)), None);
        assert!(weak_reason(&departing(0.5)).is_some_and(|r| r.contains("departs")));
    }

    /// 34.05354 ± 0.00047 Hz with a damping of 0.0226 ± 0.0014 % at a line spacing of 0.3125 Hz: weak at a coherence of 0.434, not at 0.95.
    #[test]
    fn law_narrow_modes_of_noise_are_weak() {
        let narrow = mode(34.05354, 0.000226, 0.00024, 0.000007);
        let weak_reason = |coherence| reason(&narrow, 0.3125, Some(coherence));
        assert!(weak_reason(0.434).is_some_and(|r| r.contains("coherence")));
        assert_eq!(weak_reason(0.95), None);
    }

    /// 88.9 ± 3.4 Hz with a damping of 4.7 ± 8.0 % from operational analysis is weak; 6.206 ± 0.065 Hz with 2.2 ± 1.7 % is not, though its
    /// frequency is uncertain by more than a tenth of its half-power width.
    #[test]
    fn law_weak_modes_of_responses_alone() {
        let weak_reason = |m: &IdentifiedMode| unresolved_damping(m, 1.0 / 60.0);
        let phantom = mode(88.9, 0.047, 3.4 / Z_95, 0.08 / Z_95);
        assert!(weak_reason(&phantom).is_some_and(|r| r.contains("zero")));
        let real = mode(6.206, 0.022, 0.065 / Z_95, 0.017 / Z_95);
        assert_eq!(weak_reason(&real), None);
        assert!(is_frequency_uncertain(&real.mode));
    }

    /// Modes of measured structures with uncertain damping: 17.43 ± 0.23 Hz with 3.4 ± 3.9 % is certain in frequency, 16.271 ± 0.088 Hz
    /// with 0.29 ± 0.45 % in 93 % of the orders; in half of them it is weak.
    #[test]
    fn law_certain_frequencies_of_responses_alone() {
        let weak_reason = |f: f64, damping: f64, std: f64, damping_std: f64, presence: f64| {
            let identified = IdentifiedMode {
                presence: Some(presence),
                ..mode(f, damping, std / Z_95, damping_std / Z_95)
            };
            unresolved_damping(&identified, 1.0 / 720.0)
        };
        assert_eq!(weak_reason(17.43, 0.034, 0.23, 0.039, 0.5), None);
        assert_eq!(weak_reason(16.271, 0.0029, 0.088, 0.0045, 0.93), None);
        assert!(weak_reason(16.271, 0.0029, 0.088, 0.0045, 0.5).is_some());
        assert!(weak_reason(0.1817, 0.045, 0.0084, 0.086, 0.93).is_some());
    }

    /// Nine stable poles at 120 Hz without a mode have a reason; those of a mode have none.
    #[test]
    fn law_stable_columns_have_a_reason() {
        let pole = |order: usize, f: f64| StabilisationPole {
            order,
            frequency_hz: f,
            damping_ratio: 0.01,
            stability: PoleStability::Stable,
        };
        let mut poles: Vec<StabilisationPole> = Vec::new();
        for order in 1..=40 {
            poles.push(pole(order, 80.0));
            if order > 31 {
                poles.push(pole(order, 120.0));
            }
        }
        let modes = [mode(80.0, 0.01, 0.01, 1e-4)];
        let rejected = columns(&poles, &modes, (1.0, 200.0), &SelectionRule::default());
        assert_eq!(rejected.len(), 1);
        assert!((rejected[0].0.norm() / TAU - 120.0).abs() < 1e-9);
        assert!(rejected[0].1.contains("fewer than a third"));
    }
}
