//! Modes that are weak, by a stated rule, and stable columns of a diagram that are no modes, each with its reason.

use std::f64::consts::TAU;

use super::identification_result::IdentifiedMode;
use crate::identify::modal::selection::SelectionRule;
use crate::identify::modal::stabilisation::{PoleStability, StabilisationPole};
use crate::numeric::Complex;
use crate::numeric::statistics::Z_95;

/// A frequency less certain than this share of the half-power width makes a mode weak.
const MAX_CERTAIN_STD: f64 = 0.1;

/// Below a line's width a mode is weak unless its damping is known to better than this share, as a standard deviation.
const KNOWN_DAMPING: f64 = 0.1;

/// Below a line's width a mode is weak where its coherence is below this as well.
const NARROW_COHERENCE: f64 = 0.8;

/// The rule as a sentence.
pub const RULE: &str = "weak: a standard deviation of frequency above a tenth of the half-power width, a damping interval that includes zero, or a half-power width below a line with a damping known to no better than 10 % or a coherence below 0.8";

/// Why a mode is weak; `None` where it is not, or its method gives no uncertainty. `line_hz` is the distance of the lines.
pub fn reason(mode: &IdentifiedMode, line_hz: f64, coherence: Option<f64>) -> Option<&'static str> {
    let width = 2.0 * mode.mode.pole.re.abs() / TAU;
    // What the difference of two hits adds to an interval says little of the mode.
    let wider = mode.departure.map_or(1.0, |d| d.two_hit_factor);
    let frequency = mode.mode.frequency_std_hz()? / wider;
    let damping = mode.mode.damping_std()? / wider;
    let ratio = mode.mode.damping_ratio();
    if Z_95 * damping >= ratio {
        return Some("the interval of its damping includes zero");
    }
    if width < line_hz && damping > KNOWN_DAMPING * ratio {
        return Some(
            "its half-power width is below a line, and its damping is known to no better than 10 %",
        );
    }
    if width < line_hz && coherence.is_some_and(|c| c < NARROW_COHERENCE) {
        return Some("its half-power width is below a line, and its coherence below 0.8");
    }
    (frequency > MAX_CERTAIN_STD * width)
        .then_some("its frequency is uncertain by more than a tenth of its half-power width")
}

/// Modes by rising frequency, and apart from them, unless they are joined, the weak ones; each of these with its reason. `coherence` is
/// that at a frequency, Hz, where it is known.
pub fn split_weak(
    mut all: Vec<IdentifiedMode>,
    line_hz: f64,
    coherence: impl Fn(f64) -> Option<f64>,
    is_joined: bool,
) -> (Vec<IdentifiedMode>, Vec<IdentifiedMode>) {
    for mode in &mut all {
        mode.weak = reason(mode, line_hz, coherence(mode.frequency_hz()));
    }
    all.sort_by(|a, b| a.frequency_hz().total_cmp(&b.frequency_hz()));
    all.into_iter().partition(|m| is_joined || m.weak.is_none())
}

/// Stable poles over rising orders this near to the next are one column, relative.
const COLUMN_TOLERANCE: f64 = 0.005;

/// Fewer orders make no column.
const MIN_ORDERS: usize = 3;

/// Stable columns of a diagram without a mode, rad/s, and why.
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
    stable.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let next = |a: &&StabilisationPole, b: &&StabilisationPole| {
        b.frequency_hz - a.frequency_hz < COLUMN_TOLERANCE * b.frequency_hz
    };
    let mut omitted = Vec::new();
    for column in stable.chunk_by(next) {
        let mut own: Vec<usize> = column.iter().map(|p| p.order).collect();
        own.sort_unstable();
        own.dedup();
        let middle = column[column.len() / 2];
        let (f, damping) = (middle.frequency_hz, middle.damping_ratio);
        let ends = (
            column[0].frequency_hz,
            column[column.len() - 1].frequency_hz,
        );
        let is_held = |m: &IdentifiedMode| (ends.0..=ends.1).contains(&m.frequency_hz());
        if own.len() < MIN_ORDERS || modes.iter().any(is_held) {
            continue;
        }
        let half_width = |m: &IdentifiedMode| m.mode.pole.re.abs() / TAU;
        let is_beside = |m: &IdentifiedMode| {
            (m.frequency_hz() - f).abs() < half_width(m).max(COLUMN_TOLERANCE * f)
        };
        let reason = if !(band_hz.0..=band_hz.1).contains(&f) {
            "a stable column outside the band"
        } else if !(0.0..=rule.max_damping_ratio).contains(&damping) {
            "a stable column whose damping is negative or that of a background"
        } else if modes.iter().any(is_beside) {
            "a stable column within the half-power band of a mode, taken as that mode"
        } else if (own.len() as f64) < rule.presence * orders.len() as f64 {
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
    use crate::identify::modal_parameters::ModalParameters;

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
        let seen = mode(543.68, 0.00034, 0.056, 0.000138);
        assert!(reason(&seen, 0.5, None).is_some_and(|r| r.contains("below a line")));
        let why = |m: &IdentifiedMode, line_hz| reason(m, line_hz, Some(1.0)).unwrap_or_default();
        assert!(why(&mode(500.0, 0.001, 0.01, 0.0006), 0.1).contains("zero"));
        assert!(why(&mode(500.0, 0.001, 0.2, 0.0001), 0.1).contains("tenth"));
        assert_eq!(why(&mode(500.0, 0.001, 0.01, 0.00002), 2.0), "");
    }

    /// 34.05354 ± 0.00047 Hz with a damping of 0.0226 ± 0.0014 % from lines 0.3125 Hz apart: weak at a coherence of 0.434, not at 0.95.
    #[test]
    fn law_narrow_modes_of_noise_are_weak() {
        let seen = mode(34.05354, 0.000226, 0.00024, 0.000007);
        let of = |coherence| reason(&seen, 0.3125, Some(coherence));
        assert!(of(0.434).is_some_and(|r| r.contains("coherence")));
        assert_eq!(of(0.95), None);
    }

    /// Nine stable poles at 120 Hz, where no mode is reported, have a reason; those of a mode have none.
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
        let found = columns(&poles, &modes, (1.0, 200.0), &SelectionRule::default());
        assert_eq!(found.len(), 1);
        assert!((found[0].0.norm() / TAU - 120.0).abs() < 1e-9);
        assert!(found[0].1.contains("fewer than a third"));
    }
}
