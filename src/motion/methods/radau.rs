//! The Radau IIA method of order 5, implicit, with error control and the collocation polynomial as dense output.
//!
//! Source: Hairer and Wanner, Solving Ordinary Differential Equations II, 2nd edition 1996, IV.8: simplified Newton in the
//! basis where the tableau's inverse is a real number next to a complex pair, the error of order 3 filtered by the real
//! factors, Gustafsson's choice of steps; IV.8 and VI.1 for `M ẏ = f` with a singular M of zeros and ones on its diagonal.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::{format_instant, format_time};
use crate::motion::error_scale::{ErrorScale, error_norm};
use crate::motion::pencil::{FactoredPencil, HasPencil, JacobianPencil};
use crate::motion::problem::IntegrationStats;
use crate::motion::progress::clamp_time;
use crate::motion::stepper::{StepSizeRule, Stepper, equal_step};
use crate::numeric::Complex;
use crate::numeric::lu::{ComplexLu, Lu};

const SQRT_6: f64 = 2.449_489_742_783_178; // √6

/// c.
const NODES: [f64; 3] = [(4.0 - SQRT_6) / 10.0, (4.0 + SQRT_6) / 10.0, 1.0];

/// The error estimate: weights of the stages.
const ERROR: [f64; 3] = [
    (-13.0 - 7.0 * SQRT_6) / 3.0,
    (-13.0 + 7.0 * SQRT_6) / 3.0,
    -1.0 / 3.0,
];

/// The real eigenvalue of the tableau's inverse, 3 + 3^(2/3) − 3^(1/3).
const REAL_EIGENVALUE: f64 = 3.637_834_252_744_496;

/// Complex eigenvalue pair of the tableau's inverse, 3 + (3^(1/3) − 3^(2/3))/2 ∓ i (3^(5/6) + 3^(7/6))/2.
const COMPLEX_EIGENVALUE: (f64, f64) = (2.681_082_873_627_752_3, -3.050_430_199_247_410_5);

/// The basis: stages from transformed ones.
const BASIS: [[f64; 3]; 3] = [
    [
        0.094_438_762_488_975_24,
        -0.141_255_295_020_954_2,
        0.030_029_194_105_147_424,
    ],
    [
        0.250_213_122_965_333_3,
        0.204_129_352_293_799_94,
        -0.382_942_112_757_261_9,
    ],
    [1.0, 1.0, 0.0],
];

/// Inverse of the basis.
const INVERSE: [[f64; 3]; 3] = [
    [
        4.178_718_591_551_904,
        0.327_682_820_761_062_4,
        0.523_376_445_499_449_5,
    ],
    [
        -4.178_718_591_551_904,
        -0.327_682_820_761_062_4,
        0.476_623_554_500_550_44,
    ],
    [
        0.502_872_634_945_786_8,
        -2.571_926_949_855_605,
        0.596_039_204_828_224_9,
    ],
];

/// The collocation polynomial: powers θ, θ², θ³ from the stages.
const POWERS: [[f64; 3]; 3] = [
    [
        (13.0 + 7.0 * SQRT_6) / 3.0,
        (-23.0 - 22.0 * SQRT_6) / 3.0,
        (10.0 + 15.0 * SQRT_6) / 3.0,
    ],
    [
        (13.0 - 7.0 * SQRT_6) / 3.0,
        (-23.0 + 22.0 * SQRT_6) / 3.0,
        (10.0 - 15.0 * SQRT_6) / 3.0,
    ],
    [1.0 / 3.0, -8.0 / 3.0, 10.0 / 3.0],
];

/// Newton steps allowed.
const MAX_NEWTON: i32 = 7;

/// Changes of this size, relative to the states, are rounding.
const NEWTON_FLOOR: f64 = 1e-14;

/// The method between two steps.
pub struct Radau5 {
    control: StepSizeRule,
    scale: ErrorScale,
    /// The step to try next, s; zero where none is known.
    next: f64,
    /// The last accepted step and its error, for Gustafsson's choice.
    before: Option<(f64, f64)>,
    /// ∂f/∂y, and whether it belongs to the present state.
    pencil: Option<JacobianPencil>,
    fresh: bool,
    factors: Option<RadauFactors>,
    /// The last step: its start, its length, the state there, the polynomial.
    last: Option<CollocationPolynomial>,
    /// Earliest instant at which f may be evaluated; absent after a restart.
    since: Option<f64>,
}

struct RadauFactors {
    h: f64,
    real: FactoredPencil<f64, Lu>,
    pair: FactoredPencil<Complex, ComplexLu>,
}

#[derive(Clone)]
struct CollocationPolynomial {
    t: f64,
    h: f64,
    y: Vec<f64>,
    powers: [Vec<f64>; 3],
}

impl CollocationPolynomial {
    fn rise(&self, theta: f64, i: usize) -> f64 {
        theta * (self.powers[0][i] + theta * (self.powers[1][i] + theta * self.powers[2][i]))
    }
}

/// Result of simplified Newton iteration.
struct StageValues {
    /// Stage states less the start.
    rise: [Vec<f64>; 3],
    rounds: i32,
    rate: f64,
}

impl Radau5 {
    /// Before the first step.
    pub fn new(control: StepSizeRule, scale: ErrorScale) -> Radau5 {
        Radau5 {
            control,
            scale,
            next: 0.0,
            before: None,
            pencil: None,
            fresh: false,
            factors: None,
            last: None,
            since: None,
        }
    }

    fn tolerance(&self) -> f64 {
        match self.control {
            StepSizeRule::Tolerance(tolerance) => tolerance,
            StepSizeRule::Fixed(_) => 1e-13,
        }
    }

    /// Newton steps allowed: more where the step cannot be cut.
    fn rounds(&self) -> i32 {
        match self.control {
            StepSizeRule::Tolerance(_) => MAX_NEWTON,
            StepSizeRule::Fixed(_) => 6 * MAX_NEWTON,
        }
    }

    /// Stages, from the last polynomial carried on.
    fn guess(&self, t: f64, h: f64, y: &[f64]) -> [Vec<f64>; 3] {
        let carried = |c: f64| match &self.last {
            Some(last) => {
                let theta = (t + c * h - last.t) / last.h;
                (0..y.len())
                    .map(|i| last.rise(theta, i) + (last.y[i] - y[i]))
                    .collect()
            }
            None => vec![0.0; y.len()],
        };
        NODES.map(carried)
    }

    /// Simplified Newton for the stages; absent where it does not converge.
    fn stages<P: HasPencil>(
        &self,
        problem: &P,
        clock: impl Fn(f64) -> f64,
        (t, y): (f64, &[f64]),
        factors: &RadauFactors,
        stats: &mut IntegrationStats,
    ) -> Option<StageValues> {
        let (n, h) = (y.len(), factors.h);
        let pencil = self.pencil.as_ref()?;
        let tolerance = self.tolerance();
        let rounds = self.rounds();
        let enough = (tolerance * tolerance.sqrt().clamp(1e-3, 0.03)).max(NEWTON_FLOOR);
        let mut rise = self.guess(t, h, y);
        let mut moved: [Vec<f64>; 3] = std::array::from_fn(|k| {
            (0..n)
                .map(|i| (0..3).map(|j| INVERSE[k][j] * rise[j][i]).sum())
                .collect()
        });
        let mut slopes = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        let mut size_before = f64::NAN;
        for round in 0..rounds {
            for k in 0..3 {
                let state: Vec<f64> = (0..n).map(|i| y[i] + rise[k][i]).collect();
                problem.derivative(clock(t + NODES[k] * h), &state, &mut slopes[k]);
            }
            stats.evaluations += 3;
            let into =
                |k: usize, i: usize| -> f64 { (0..3).map(|j| INVERSE[k][j] * slopes[j][i]).sum() };
            let pair = Complex::new(COMPLEX_EIGENVALUE.0, COMPLEX_EIGENVALUE.1) / h;
            let mut real: Vec<f64> = (0..n)
                .map(|i| into(0, i) - pencil.mass_entry(i) * REAL_EIGENVALUE / h * moved[0][i])
                .collect();
            let mut complex: Vec<Complex> = (0..n)
                .map(|i| {
                    Complex::new(into(1, i), into(2, i))
                        - pair * pencil.mass_entry(i) * Complex::new(moved[1][i], moved[2][i])
                })
                .collect();
            pencil.solve(&factors.real, &mut real);
            pencil.solve_complex(&factors.pair, &mut complex);
            let change: Vec<f64> = complex.iter().map(|z| z.re).collect();
            let turned: Vec<f64> = complex.iter().map(|z| z.im).collect();
            for i in 0..n {
                moved[0][i] += real[i];
                moved[1][i] += change[i];
                moved[2][i] += turned[i];
            }
            for k in 0..3 {
                for i in 0..n {
                    rise[k][i] = (0..3).map(|j| BASIS[k][j] * moved[j][i]).sum();
                }
            }
            let reached: Vec<f64> = (0..n).map(|i| y[i] + rise[2][i]).collect();
            let sizes = self.scale.sizes(y, &reached, h);
            let square: f64 = [&real, &change, &turned]
                .iter()
                .map(|x| error_norm(x, &sizes).powi(2))
                .sum();
            let size = (square / 3.0).sqrt();
            if !size.is_finite() {
                return None;
            }
            let rate = size / size_before;
            let hopeless =
                rate >= 1.0 || rate.powi(rounds - 1 - round) / (1.0 - rate) * size > enough;
            if hopeless && size > enough {
                return None;
            }
            // Changes this small tell nothing of the rate: they are rounding.
            let small = size <= NEWTON_FLOOR || round > 0 && size <= enough;
            if small || rate / (1.0 - rate) * size < enough {
                return Some(StageValues {
                    rise,
                    rounds: round + 1,
                    rate: if small || rate.is_nan() { 0.0 } else { rate },
                });
            }
            size_before = size;
        }
        None
    }

    /// The error of order 3 filtered by the real factors, over sizes.
    #[allow(clippy::too_many_arguments, reason = "a step has these parts")]
    fn error<P: HasPencil>(
        &self,
        problem: &P,
        t: f64,
        y: &[f64],
        slope: &[f64],
        stages: &StageValues,
        factors: &RadauFactors,
        again: bool,
        stats: &mut IntegrationStats,
    ) -> f64 {
        let n = y.len();
        let Some(pencil) = &self.pencil else {
            return f64::INFINITY;
        };
        let reached: Vec<f64> = (0..n).map(|i| y[i] + stages.rise[2][i]).collect();
        let sizes = self.scale.sizes(y, &reached, factors.h);
        let of_stages: Vec<f64> = (0..n)
            .map(|i| {
                let sum: f64 = (0..3).map(|k| ERROR[k] * stages.rise[k][i]).sum();
                pencil.mass_entry(i) * sum / factors.h
            })
            .collect();
        let filtered = |slope: &[f64]| -> Vec<f64> {
            let mut error: Vec<f64> = (0..n).map(|i| slope[i] + of_stages[i]).collect();
            pencil.solve(&factors.real, &mut error);
            error
        };
        let mut error = filtered(slope);
        let size = error_norm(&error, &sizes) / self.tolerance();
        if !(again && size > 1.0) {
            return size;
        }
        error.iter_mut().zip(y).for_each(|(e, y)| *e += y);
        let mut moved = vec![0.0; n];
        problem.derivative(t, &error, &mut moved);
        stats.evaluations += 1;
        error_norm(&filtered(&moved), &sizes) / self.tolerance()
    }

    /// A first step from the sizes of the state and its slope, s.
    fn first(&self, y: &[f64], slope: &[f64], left: f64) -> f64 {
        let sizes = self.scale.sizes(y, y, 1e-3 * left);
        let sensible = 0.01 * error_norm(y, &sizes) / error_norm(slope, &sizes);
        match sensible > 0.0 && sensible.is_finite() {
            true => sensible.clamp(1e-10 * left, 1e-2 * left),
            false => 1e-6 * left,
        }
    }

    fn polynomial(t: f64, h: f64, y: &[f64], rise: &[Vec<f64>; 3]) -> CollocationPolynomial {
        let powers = std::array::from_fn(|p| {
            (0..y.len())
                .map(|i| (0..3).map(|k| POWERS[k][p] * rise[k][i]).sum())
                .collect()
        });
        CollocationPolynomial {
            t,
            h,
            y: y.to_vec(),
            powers,
        }
    }
}

impl<P: HasPencil> Stepper<P> for Radau5 {
    fn restart(&mut self) {
        self.pencil = None;
        self.factors = None;
        self.last = None;
        self.before = None;
        self.since = None;
    }

    fn step(
        &mut self,
        problem: &P,
        (t, y): (f64, &[f64]),
        end: f64,
        stats: &mut IntegrationStats,
    ) -> Result<(f64, Vec<f64>), Error> {
        let since = *self.since.get_or_insert(t);
        let clock = move |t: f64| clamp_time(t, since, end);
        self.scale.update(y);
        let mut slope = vec![0.0; y.len()];
        problem.derivative(clock(t), y, &mut slope);
        stats.evaluations += 1;
        let left = end - t;
        let wanted = match self.control {
            StepSizeRule::Fixed(h) => equal_step(left, h),
            StepSizeRule::Tolerance(_) if self.next > 0.0 => self.next,
            StepSizeRule::Tolerance(_) => self.first(y, &slope, left),
        };
        let mut h = wanted.min(left);
        let mut refused = false;
        self.fresh = false;
        loop {
            if !(h > 4.0 * f64::EPSILON * t.abs() && h > 0.0) && h < left {
                return Err(Error::new(
                    Code::NoConvergence,
                    format!("no step from t = {} keeps the error within the tolerance", format_instant(t)),
                )
                .with_hint("the motion jumps there or overflows: take a coarser tolerance, or check the machine at that time"));
            }
            if self.pencil.is_none() {
                self.pencil = Some(problem.pencil(clock(t), y, stats));
                self.fresh = true;
                self.factors = None;
            }
            let factors = match (self.factors.take().filter(|f| f.h == h), &self.pencil) {
                (Some(factors), _) => factors,
                (None, Some(pencil)) => {
                    stats.factorisations += 2;
                    match (
                        pencil.real(REAL_EIGENVALUE / h),
                        pencil
                            .complex(Complex::new(COMPLEX_EIGENVALUE.0, COMPLEX_EIGENVALUE.1) / h),
                    ) {
                        (Ok(real), Ok(pair)) => RadauFactors { h, real, pair },
                        _ => {
                            stats.rejected += 1;
                            h *= 0.5;
                            continue;
                        }
                    }
                }
                (None, None) => continue,
            };
            let Some(stages) = self.stages(problem, clock, (t, y), &factors, stats) else {
                if self.fresh {
                    if matches!(self.control, StepSizeRule::Fixed(_)) {
                        return Err(Error::new(
                            Code::NoConvergence,
                            format!(
                                "Newton's iteration of a step of {} at t = {} does not converge",
                                format_time(h),
                                format_instant(t)
                            ),
                        )
                        .with_hint("request a shorter step"));
                    }
                    stats.rejected += 1;
                    h *= 0.5;
                    // What was carried on may be what misled it.
                    self.last = None;
                } else {
                    self.pencil = None;
                    self.factors = Some(factors);
                }
                continue;
            };
            let u = if h == left { end } else { t + h };
            let error = match self.control {
                StepSizeRule::Fixed(_) => 0.0,
                StepSizeRule::Tolerance(_) => self.error(
                    problem,
                    clock(t),
                    y,
                    &slope,
                    &stages,
                    &factors,
                    refused || self.before.is_none(),
                    stats,
                ),
            };
            let rounds = f64::from(self.rounds());
            let safety = 0.9 * (2.0 * rounds + 1.0) / (2.0 * rounds + f64::from(stages.rounds));
            let plain = error.powf(-0.25);
            if !(error <= 1.0) {
                stats.rejected += 1;
                refused = true;
                h *= match error.is_finite() {
                    true => (safety * plain).clamp(0.1, 0.9),
                    false => 0.1,
                };
                continue;
            }
            let reached: Vec<f64> = (0..y.len()).map(|i| y[i] + stages.rise[2][i]).collect();
            let predicted = match self.before {
                Some((before, then)) if error > 0.0 => {
                    plain.min(plain * h / before * (then / error).powf(0.25))
                }
                _ => plain,
            };
            let factor = (safety * predicted).clamp(0.2, if refused { 1.0 } else { 8.0 });
            let stale = stages.rounds > 2 && stages.rate > 1e-3;
            // Small changes are not worth new factors.
            let grown = match !stale && (0.9..1.2).contains(&factor) {
                true => h,
                false => h * factor,
            };
            self.next = match h == left {
                true => grown.max(self.next),
                false => grown,
            };
            if stale {
                self.pencil = None;
            }
            self.before = Some((h, error.max(1e-2)));
            self.last = Some(Radau5::polynomial(t, h, y, &stages.rise));
            self.factors = Some(factors);
            self.scale.update(&reached);
            return Ok((u, reached));
        }
    }

    fn interpolate(&self, theta: f64, y: &mut [f64]) {
        if let Some(last) = &self.last {
            for i in 0..y.len() {
                y[i] = last.y[i] + last.rise(theta, i);
            }
        }
    }
}
