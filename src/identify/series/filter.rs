//! Filtering by polynomials of the shift operator, `C(q) = 1 + c₁q⁻¹ + …`, zero initial state.

/// `x ← x / C(q)`: `y_t = x_t − Σ c_k y_{t−k}`.
pub(super) fn filter_inverse(x: &mut [f64], c: &[f64]) {
    for t in 0..x.len() {
        let known = c.len().min(t);
        let past: f64 = (1..=known).map(|k| c[k - 1] * x[t - k]).sum();
        x[t] -= past;
    }
}

/// `B(q) q^−delay u`, with `B = b₀ + b₁q⁻¹ + …`.
pub(super) fn filter_delayed(u: &[f64], b: &[f64], delay: usize) -> Vec<f64> {
    let mut y = vec![0.0; u.len()];
    for (j, b) in b.iter().enumerate() {
        let lag = delay + j;
        (y.iter_mut().skip(lag).zip(u)).for_each(|(y, u)| *y += b * u);
    }
    y
}

/// Whether every root of `z^n + c₁z^{n−1} + …` lies inside the circle of radius one: all reflection coefficients of the step-down
/// recursion are below one (Schur 1917; Jury 1964).
pub(super) fn is_stable(c: &[f64]) -> bool {
    let mut a = c.to_vec();
    while let Some(k) = a.pop() {
        if !(k.abs() < 1.0) {
            return false;
        }
        let n = a.len();
        let scale = 1.0 / (1.0 - k * k);
        a = (0..n).map(|i| (a[i] - k * a[n - 1 - i]) * scale).collect();
    }
    true
}

/// Roots of the polynomial are pulled inward together, `c_k γ^k`, until they lie inside the circle of radius one.
pub(super) fn stabilise(mut c: Vec<f64>) -> Vec<f64> {
    const RADIUS_FACTOR: f64 = 0.95; // a radius of 2 needs 14 rounds
    if c.iter().any(|c| !c.is_finite()) {
        return vec![0.0; c.len()];
    }
    while !is_stable(&c) {
        let mut factor = 1.0;
        for c in &mut c {
            factor *= RADIUS_FACTOR;
            *c *= factor;
        }
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dividing by C after multiplying by it gives the samples back.
    #[test]
    fn law_divide_undoes_multiply() {
        let c = [-1.2, 0.7, 0.1];
        let x: Vec<f64> = (0..50).map(|t| f64::from(t * t % 17)).collect();
        let mut y = filter_delayed(&x, &[1.0, c[0], c[1], c[2]], 0);
        filter_inverse(&mut y, &c);
        assert!(x.iter().zip(&y).all(|(a, b)| (a - b).abs() < 1e-11));
    }

    /// (1 − 0.5q⁻¹)(1 + 0.9q⁻¹) is stable, (1 − 1.1q⁻¹)(1 − 0.2q⁻¹) is not until pulled in.
    #[test]
    fn exact_stability() {
        assert!(is_stable(&[0.4, -0.45]));
        assert!(!is_stable(&[-1.3, 0.22]));
        assert!(is_stable(&stabilise(vec![-1.3, 0.22])));
        assert!(is_stable(&[]));
    }
}
