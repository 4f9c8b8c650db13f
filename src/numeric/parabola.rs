//! Parabola through three equidistant values about a peak.

/// Vertex of the parabola through three values one step apart: its place in steps from the middle one and its value; the middle one
/// itself where the values do not bend down.
pub fn vertex([before, middle, after]: [f64; 3]) -> (f64, f64) {
    let bend = before - 2.0 * middle + after;
    if bend >= 0.0 {
        return (0.0, middle);
    }
    let shift = 0.5 * (before - after) / bend;
    (shift, middle - 0.25 * (before - after) * shift)
}

/// The same through the logarithms of three values, such as lines of a spectrum.
pub fn log_vertex(values: [f64; 3]) -> (f64, f64) {
    let (shift, top) = vertex(values.map(|value| value.max(f64::MIN_POSITIVE).ln()));
    match shift {
        0.0 => (0.0, values[1]),
        _ => (shift, top.exp()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `3 − 2 (x − 0.3)²`, and its exponential.
    #[test]
    fn law_vertex_of_a_parabola() {
        let values = [-1.0, 0.0, 1.0].map(|x: f64| 3.0 - 2.0 * (x - 0.3).powi(2));
        let (shift, top) = vertex(values);
        assert!((shift - 0.3).abs() < 1e-15 && (top - 3.0).abs() < 1e-15);
        let (shift, top) = log_vertex(values.map(f64::exp));
        assert!((shift - 0.3).abs() < 1e-14 && (top - 3.0_f64.exp()).abs() < 1e-13);
        assert_eq!(vertex([1.0, 0.5, 1.0]), (0.0, 0.5));
    }
}
