//! Roots of a scalar equation `f(x) = 0` on an interval by Newton's method, with bracketing where it fails; maximum by golden section.

/// Unbracketed Newton steps from the middle before the interval is scanned.
const UNBRACKETED_STEPS: usize = 8;
/// Newton steps within a bracket; at worst every second one bisects it, which reduces the bracket to rounding.
const BRACKETED_STEPS: usize = 120;
/// Intervals of the scan for sign changes.
const SCAN_INTERVALS: usize = 48;
/// Step, relative to the interval, at which the iteration ends: by quadratic convergence the next one is rounding.
const LAST_STEP: f64 = 3e-8;
/// Final |f|, relative to its values at the ends of the interval, above which a sign change is a jump or a pole.
const JUMP: f64 = 1e-6;
/// Distance beyond the interval, relative to its length, at which a root is accepted: rounding of a root at an end.
const END_TOLERANCE: f64 = 1e-9;

/// Root of `f` in `[from, to]`; `f` returns value and derivative, or `None` where it is undefined.
///
/// Newton's method starts in the middle; where it leaves the interval or does not converge, the root is the sign change nearest the middle.
/// Effort: 2 evaluations for a linear f, about 4 for a smooth one, 48 more for a scan.
pub fn root(interval: [f64; 2], mut f: impl FnMut(f64) -> Option<[f64; 2]>) -> Option<f64> {
    let [from, to] = interval;
    let middle = 0.5 * (from + to);
    unbracketed_newton(interval, middle, &mut f).or_else(|| {
        let candidates = roots(interval, f);
        let distance = |x: &f64| (x - middle).abs();
        candidates
            .into_iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    })
}

/// Roots of `f` in `[from, to]` with a sign change, in ascending order; two roots closer than 1/48 of the interval may be missed.
pub fn roots(interval: [f64; 2], mut f: impl FnMut(f64) -> Option<[f64; 2]>) -> Vec<f64> {
    let [from, to] = interval;
    let node = |i: usize| from + (to - from) * i as f64 / SCAN_INTERVALS as f64;
    let mut roots = Vec::new();
    let mut previous = f(from).map(|[value, _]| value);
    for i in 1..=SCAN_INTERVALS {
        let value = f(node(i)).map(|[value, _]| value);
        if let (Some(a), Some(b)) = (previous, value)
            && (a == 0.0 || a * b < 0.0)
        {
            roots.extend(bracketed_newton([node(i - 1), node(i)], [a, b], &mut f));
        }
        previous = value;
    }
    if previous == Some(0.0) {
        roots.push(to);
    }
    roots
}

/// Root of `f` in `[from, to]` by its sign change, without derivatives; `None` where both ends have the same sign, where `f` is undefined,
/// and at a jump.
///
/// Bisection and inverse quadratic interpolation: Chandrupatla, Advances in Engineering Software 28, 1997, 145–149.
pub fn sign_change([from, to]: [f64; 2], mut f: impl FnMut(f64) -> Option<f64>) -> Option<f64> {
    let (mut a, mut b) = (to, from);
    let (mut fa, mut fb) = (f(a)?, f(b)?);
    if fa == 0.0 || fb == 0.0 {
        return Some(if fb == 0.0 { b } else { a });
    }
    if !(fa * fb < 0.0) {
        return None;
    }
    let tolerance = JUMP * fa.abs().max(fb.abs());
    let mut share = 0.5;
    for _ in 0..BRACKETED_STEPS {
        let x = a + share * (b - a);
        let fx = f(x)?;
        let (c, fc);
        if (fx < 0.0) == (fa < 0.0) {
            (c, fc) = (a, fa);
        } else {
            (c, fc) = (b, fb);
            (b, fb) = (a, fa);
        }
        (a, fa) = (x, fx);
        let (best, best_value) = if fa.abs() < fb.abs() {
            (a, fa)
        } else {
            (b, fb)
        };
        let smallest = (2.0 * f64::EPSILON * best.abs() + f64::MIN_POSITIVE) / (b - a).abs();
        if fx == 0.0 || smallest > 0.5 {
            return (best_value.abs() <= tolerance).then_some(best);
        }
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        share = if phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        share = share.clamp(smallest, 1.0 - smallest);
    }
    None
}

fn unbracketed_newton(
    [from, to]: [f64; 2],
    start: f64,
    f: &mut impl FnMut(f64) -> Option<[f64; 2]>,
) -> Option<f64> {
    let length = (to - from).abs();
    let (low, high) = (
        from.min(to) - END_TOLERANCE * length,
        from.max(to) + END_TOLERANCE * length,
    );
    let mut x = start;
    for _ in 0..UNBRACKETED_STEPS {
        let [value, slope] = f(x)?;
        let step = -value / slope;
        if !step.is_finite() {
            return None;
        }
        x += step;
        if step.abs() <= LAST_STEP * length {
            return (low <= x && x <= high).then_some(x);
        }
    }
    None
}

/// Root between two points with values of opposite sign; `None` at a pole.
fn bracketed_newton(
    [mut from, mut to]: [f64; 2],
    [f_from, f_to]: [f64; 2],
    f: &mut impl FnMut(f64) -> Option<[f64; 2]>,
) -> Option<f64> {
    if f_from == 0.0 {
        return Some(from);
    }
    let length = (to - from).abs();
    let mut x = 0.5 * (from + to);
    for _ in 0..BRACKETED_STEPS {
        let [value, slope] = f(x)?;
        if value == 0.0 {
            return Some(x);
        }
        if (value < 0.0) == (f_from < 0.0) {
            from = x;
        } else {
            to = x;
        }
        let newton = x - value / slope;
        let is_inside = (newton - from) * (newton - to) < 0.0;
        let next = if is_inside { newton } else { 0.5 * (from + to) };
        let step = (next - x).abs();
        x = next;
        if step <= LAST_STEP * LAST_STEP * length || (is_inside && step <= LAST_STEP * length) {
            return (value.abs() <= f_from.abs().max(f_to.abs())).then_some(x);
        }
    }
    None
}

/// Golden-section steps: they reduce the bracket to 1e-5 of its length, and the error of the maximum to 1e-10 of the variation in it.
const GOLDEN_STEPS: usize = 24;

/// Argument and value of the maximum of `f` in `[from, to]`: the largest of `parts` + 1 samples, refined by golden section between its
/// neighbours; `None` where `f` is undefined at all samples.
pub fn greatest(
    [from, to]: [f64; 2],
    parts: u32,
    mut f: impl FnMut(f64) -> Option<f64>,
) -> Option<[f64; 2]> {
    let spacing = (to - from) / f64::from(parts);
    let samples = (0..=parts).filter_map(|k| {
        let x = from + spacing * f64::from(k);
        Some([x, f(x)?])
    });
    let mut best = samples.max_by(|a, b| a[1].total_cmp(&b[1]))?;
    let [mut low, mut high] = [(best[0] - spacing).max(from), (best[0] + spacing).min(to)];
    let share = 0.5 * (3.0 - 5f64.sqrt());
    for _ in 0..GOLDEN_STEPS {
        // Divide the longer side of the bracket in the golden ratio.
        let is_right = high - best[0] > best[0] - low;
        let x = match is_right {
            true => best[0] + share * (high - best[0]),
            false => best[0] - share * (best[0] - low),
        };
        let value = f(x).unwrap_or(f64::NEG_INFINITY);
        match (value > best[1], is_right) {
            (true, true) => (low, best) = (best[0], [x, value]),
            (true, false) => (high, best) = (best[0], [x, value]),
            (false, true) => high = x,
            (false, false) => low = x,
        }
    }
    Some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Roots of a linear function, a cubic and an arctangent; unbracketed Newton steps leave the interval of the arctangent.
    #[test]
    fn exact_roots() {
        assert_eq!(root([0.0, 4.0], |x| Some([2.0 * x - 3.0, 2.0])), Some(1.5));
        let cubic = |x: f64| Some([x * x * x - 2.0, 3.0 * x * x]);
        let x = root([0.0, 3.0], cubic).unwrap();
        assert!((x - 2f64.cbrt()).abs() < 1e-15, "{x}");
        let arctangent = |x: f64| {
            Some([
                (20.0 * (x - 0.1)).atan(),
                20.0 / (1.0 + (20.0 * (x - 0.1)).powi(2)),
            ])
        };
        let x = root([-4.0, 3.0], arctangent).unwrap();
        assert!((x - 0.1).abs() < 1e-15, "{x}");
    }

    /// The root of `cos x = x` to rounding; no root at a jump or without a sign change.
    #[test]
    fn exact_sign_change() {
        let x = sign_change([0.0, 2.0], |x: f64| Some(x.cos() - x)).unwrap();
        assert!((x - 0.7390851332151607).abs() < 3e-16, "{x}");
        assert_eq!(sign_change([-1.0, 3.0], |x: f64| Some(x.signum())), None);
        assert_eq!(sign_change([0.0, 0.5], |x: f64| Some(x.cos() - x)), None);
    }

    /// All sign changes are roots; a pole and a root outside the interval are not.
    #[test]
    fn exact_all_roots() {
        let zeros = roots([0.5, 10.0], |x| Some([x.sin(), x.cos()]));
        assert_eq!(zeros.len(), 3);
        for (i, x) in zeros.iter().enumerate() {
            let exact = std::f64::consts::PI * (i as f64 + 1.0);
            assert!((x - exact).abs() < 4e-15, "{x}");
        }
        let pole = |x: f64| Some([1.0 / (x - 0.3), -1.0 / (x - 0.3).powi(2)]);
        assert!(roots([-1.0, 1.0], pole).is_empty());
        assert_eq!(root([0.0, 1.0], |x| Some([x - 2.0, 1.0])), None);
    }
}
