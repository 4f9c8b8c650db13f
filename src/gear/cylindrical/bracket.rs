//! Root of a continuous function between two places where its signs differ (Illinois variant of regula falsi).

/// Iterations after which the bracket is taken as it is; 8 to 12 are usual.
const MAX_ITERATIONS: usize = 200;

/// The place in `[low, high]` where `f` changes its sign, to rounding; `None` where the signs at the ends are equal.
pub fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    let (mut at_low, mut at_high) = (f(low), f(high));
    if at_low == 0.0 {
        return Some(low);
    }
    if at_high == 0.0 {
        return Some(high);
    }
    if !(at_low * at_high < 0.0) {
        return None;
    }
    for i in 0..MAX_ITERATIONS {
        let middle = 0.5 * (low + high);
        let secant = high - at_high * (high - low) / (at_high - at_low);
        // Every fourth step halves the bracket, so that a flat end cannot hold it open.
        let next = if i % 4 == 3 || !(secant - low).is_finite() {
            middle
        } else {
            secant
        };
        if middle <= low.min(high) || middle >= low.max(high) {
            break;
        }
        let value = f(next);
        if value == 0.0 || next == low || next == high {
            return Some(next);
        }
        if value * at_high < 0.0 {
            (low, at_low) = (high, at_high);
        } else {
            at_low *= 0.5;
        }
        (high, at_high) = (next, value);
    }
    Some(high)
}
