//! What a step of a method makes of a mode.

use crate::motion::methods::dop853_table::STAGES;
use crate::numeric::Complex;

/// Explicit methods whose steps have a limit.
pub const EXPLICIT: [&str; 3] = ["rk4", "dopri5", "dop853"];

/// The stability polynomial `R(z) = Σ c_k z^k` of an explicit method.
///
/// Sources: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, II.4 (Runge–Kutta of order 4)
/// and II.5, Table 5.2 (Dormand–Prince 5(4), seven stages, of which the seventh is the first of the next step); order 8 from
/// its table of stages.
pub fn polynomial(method: &str) -> Option<Vec<f64>> {
    match method {
        "rk4" => Some(vec![1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0]),
        "dopri5" => Some(vec![
            1.0,
            1.0,
            1.0 / 2.0,
            1.0 / 6.0,
            1.0 / 24.0,
            1.0 / 120.0,
            1.0 / 600.0,
        ]),
        "dop853" => Some(of_stages()),
        _ => None,
    }
}

/// `k_i = 1 + z Σ a_ij k_j` as polynomials; row 12 is the end of the step.
fn of_stages() -> Vec<f64> {
    const END: usize = 12;
    let mut stages: Vec<Vec<f64>> = Vec::new();
    for row in &STAGES[..=END] {
        let mut stage = vec![0.0; END + 1];
        stage[0] = 1.0;
        for &(j, a) in *row {
            for k in 0..END {
                stage[k + 1] += a * stages[j][k];
            }
        }
        stages.push(stage);
    }
    stages.swap_remove(END)
}

/// |R(z)| of a stability polynomial at z = hλ.
pub fn amplification(coefficients: &[f64], z: Complex) -> f64 {
    let value = coefficients
        .iter()
        .rev()
        .fold(Complex::ZERO, |sum, &c| sum * z + Complex::new(c, 0.0));
    value.norm()
}
