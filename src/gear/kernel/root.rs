//! Roots of one equation on an interval by Newton's method, bracketed where it fails.

/// Newton steps tried from the middle before the interval is scanned.
const FREE_STEPS: usize = 8;
/// Newton steps within a bracket; half of them at worst halve it, so the bracket falls to rounding.
const BRACKETED_STEPS: usize = 120;
/// Parts of the interval whose ends are compared in sign.
const PARTS: usize = 48;
/// A step below this share of the interval is the last: the next would be its square, rounding.
const LAST_STEP: f64 = 3e-8;
/// A change of sign that ends above this share of the values at the ends of the interval is a jump or a pole.
const JUMP: f64 = 1e-6;
/// A root this share of the interval's length beyond it counts as inside: rounding of a root at an end.
const BEYOND: f64 = 1e-9;

/// A root of `f` in `[from, to]`, `f` giving value and derivative, none where it is not defined.
///
/// Newton's method starts in the middle; where it leaves the interval or does not settle, the sign change nearest the middle is taken. An
/// interval with one root gives that root. Effort: 2 evaluations for a linear f, about 4 for a smooth one, 48 more for a scan.
pub fn root(interval: [f64; 2], mut f: impl FnMut(f64) -> Option<[f64; 2]>) -> Option<f64> {
    let [from, to] = interval;
    let middle = 0.5 * (from + to);
    free_newton(interval, middle, &mut f).or_else(|| {
        let found = roots(interval, f);
        let distance = |x: &f64| (x - middle).abs();
        found
            .into_iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    })
}

/// The roots of `f` in `[from, to]` that change its sign, rising; two that lie within a forty-eighth of the interval may be missed.
pub fn roots(interval: [f64; 2], mut f: impl FnMut(f64) -> Option<[f64; 2]>) -> Vec<f64> {
    let [from, to] = interval;
    let place = |i: usize| from + (to - from) * i as f64 / PARTS as f64;
    let mut found = Vec::new();
    let mut before = f(from).map(|[value, _]| value);
    for i in 1..=PARTS {
        let here = f(place(i)).map(|[value, _]| value);
        if let (Some(a), Some(b)) = (before, here)
            && (a == 0.0 || a * b < 0.0)
        {
            found.extend(bracketed_newton([place(i - 1), place(i)], [a, b], &mut f));
        }
        before = here;
    }
    if before == Some(0.0) {
        found.push(to);
    }
    found
}

/// The root of `f` in `[from, to]` by its change of sign, without derivatives; none where its ends have one sign, where it is not defined,
/// and where it jumps.
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
    let small = JUMP * fa.abs().max(fb.abs());
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
        let (best, value) = if fa.abs() < fb.abs() {
            (a, fa)
        } else {
            (b, fb)
        };
        let smallest = (2.0 * f64::EPSILON * best.abs() + f64::MIN_POSITIVE) / (b - a).abs();
        if fx == 0.0 || smallest > 0.5 {
            return (value.abs() <= small).then_some(best);
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

fn free_newton(
    [from, to]: [f64; 2],
    start: f64,
    f: &mut impl FnMut(f64) -> Option<[f64; 2]>,
) -> Option<f64> {
    let length = (to - from).abs();
    let (low, high) = (
        from.min(to) - BEYOND * length,
        from.max(to) + BEYOND * length,
    );
    let mut x = start;
    for _ in 0..FREE_STEPS {
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

/// The root between two places with values of different sign; none where they part at a pole.
fn bracketed_newton(
    [mut from, mut to]: [f64; 2],
    [at_from, at_to]: [f64; 2],
    f: &mut impl FnMut(f64) -> Option<[f64; 2]>,
) -> Option<f64> {
    if at_from == 0.0 {
        return Some(from);
    }
    let length = (to - from).abs();
    let mut x = 0.5 * (from + to);
    for _ in 0..BRACKETED_STEPS {
        let [value, slope] = f(x)?;
        if value == 0.0 {
            return Some(x);
        }
        if (value < 0.0) == (at_from < 0.0) {
            from = x;
        } else {
            to = x;
        }
        let newton = x - value / slope;
        let inside = (newton - from) * (newton - to) < 0.0;
        let next = if inside { newton } else { 0.5 * (from + to) };
        let step = (next - x).abs();
        x = next;
        if step <= LAST_STEP * LAST_STEP * length || (inside && step <= LAST_STEP * length) {
            return (value.abs() <= at_from.abs().max(at_to.abs())).then_some(x);
        }
    }
    None
}

/// Steps of golden section: they leave 1e-5 of two parts, and 1e-10 of what the value changes over them.
const GOLDEN_STEPS: usize = 24;

/// Place and value of the greatest `f` in `[from, to]`: the best of `parts` + 1 samples, refined by golden section between its neighbours;
/// none where `f` is defined at no sample.
pub fn greatest(
    [from, to]: [f64; 2],
    parts: u32,
    mut f: impl FnMut(f64) -> Option<f64>,
) -> Option<[f64; 2]> {
    let part = (to - from) / f64::from(parts);
    let samples = (0..=parts).filter_map(|k| {
        let x = from + part * f64::from(k);
        Some([x, f(x)?])
    });
    let mut best = samples.max_by(|a, b| a[1].total_cmp(&b[1]))?;
    let [mut low, mut high] = [(best[0] - part).max(from), (best[0] + part).min(to)];
    let share = 0.5 * (3.0 - 5f64.sqrt());
    for _ in 0..GOLDEN_STEPS {
        // The larger side of the best place is tried.
        let rises = high - best[0] > best[0] - low;
        let x = match rises {
            true => best[0] + share * (high - best[0]),
            false => best[0] - share * (best[0] - low),
        };
        let value = f(x).unwrap_or(f64::NEG_INFINITY);
        match (value > best[1], rises) {
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

    /// A linear, a curved and a flat function; Newton's method alone leaves the interval of the last.
    #[test]
    fn exact_roots() {
        assert_eq!(root([0.0, 4.0], |x| Some([2.0 * x - 3.0, 2.0])), Some(1.5));
        let cubic = |x: f64| Some([x * x * x - 2.0, 3.0 * x * x]);
        let found = root([0.0, 3.0], cubic).unwrap();
        assert!((found - 2f64.cbrt()).abs() < 1e-15, "{found}");
        let flat = |x: f64| {
            Some([
                (20.0 * (x - 0.1)).atan(),
                20.0 / (1.0 + (20.0 * (x - 0.1)).powi(2)),
            ])
        };
        let found = root([-4.0, 3.0], flat).unwrap();
        assert!((found - 0.1).abs() < 1e-15, "{found}");
    }

    /// A root to rounding without derivatives.
    #[test]
    fn exact_sign_change() {
        let found = sign_change([0.0, 2.0], |x: f64| Some(x.cos() - x)).unwrap();
        assert!((found - 0.7390851332151607).abs() < 3e-16, "{found}");
        assert_eq!(sign_change([-1.0, 3.0], |x: f64| Some(x.signum())), None);
        assert_eq!(sign_change([0.0, 0.5], |x: f64| Some(x.cos() - x)), None);
    }

    /// Every sign change is found, a pole is none, and so is a root outside.
    #[test]
    fn exact_all_roots() {
        let found = roots([0.5, 10.0], |x| Some([x.sin(), x.cos()]));
        assert_eq!(found.len(), 3);
        for (i, x) in found.iter().enumerate() {
            let exact = std::f64::consts::PI * (i as f64 + 1.0);
            assert!((x - exact).abs() < 4e-15, "{x}");
        }
        let pole = |x: f64| Some([1.0 / (x - 0.3), -1.0 / (x - 0.3).powi(2)]);
        assert!(roots([-1.0, 1.0], pole).is_empty());
        assert_eq!(root([0.0, 1.0], |x| Some([x - 2.0, 1.0])), None);
    }
}
