//! The dynamic stiffness factored line by line, scaled to unit diagonal; sparse where it is large and mostly empty.

use super::system::{Factor, System};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::figure;
use crate::numeric::sparse_lu::Pattern;
use crate::numeric::{Complex, ComplexMatrix, Matrix, definite};

/// A system ready to be solved at any frequency.
pub struct Direct {
    system: System,
    pattern: Option<Pattern>,
}

/// Smaller systems are solved densely.
const SMALL: usize = 24;

/// So much of a matrix may differ from zero for it to be solved as a sparse one.
const SPARSE: f64 = 0.25;

impl Direct {
    /// Finds the order of elimination.
    ///
    /// # Errors
    /// `Hopeless` where memory runs out.
    pub fn new(system: System) -> Result<Direct, Error> {
        let n = system.len();
        let equations = &system.equations;
        let lossy = |i, j| {
            equations
                .hysteretic
                .as_ref()
                .is_some_and(|h| h[(i, j)] != 0.0)
        };
        let filled = |i: usize, j: usize| {
            equations.mass[(i, j)] != 0.0
                || equations.damping[(i, j)] != 0.0
                || equations.stiffness[(i, j)] != 0.0
                || lossy(i, j)
        };
        if n <= SMALL {
            return Ok(Direct {
                system,
                pattern: None,
            });
        }
        let all: Vec<(usize, usize)> = (0..n)
            .flat_map(|j| (0..n).map(move |i| (i, j)))
            .filter(|&(i, j)| filled(i, j))
            .collect();
        let sparse = (all.len() as f64) < SPARSE * (n * n) as f64;
        let pattern = if sparse {
            Some(Pattern::new(n, all)?)
        } else {
            None
        };
        Ok(Direct { system, pattern })
    }

    /// What is solved.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Solved as a sparse matrix.
    pub fn is_sparse(&self) -> bool {
        self.pattern.is_some()
    }

    /// Outputs by inputs at `s = iω`, ω in rad/s.
    ///
    /// # Errors
    /// At ω = 0: an output that a free machine does not have at rest. `Indefinite` where nothing damps a resonance at ω.
    pub fn at(&self, omega: f64) -> Result<ComplexMatrix, Error> {
        let system = &self.system;
        let s = Complex::new(0.0, omega);
        if omega == 0.0 && system.rigid > 0 {
            return self.at_rest();
        }
        let loads = complex(&system.loads);
        let x = self.solve(s, &loads).map_err(|_| resonance(omega))?;
        let seen = complex(&system.reads) * &x;
        let answer = system.joined(s, |read, load| seen[(read, load)]);
        let finite = (0..answer.ncols()).all(|j| {
            answer
                .col_as_slice(j)
                .iter()
                .all(|z| z.re.is_finite() && z.im.is_finite())
        });
        if finite {
            Ok(answer)
        } else {
            Err(resonance(omega))
        }
    }

    /// `D(s)⁻¹ B`.
    fn solve(&self, s: Complex, b: &ComplexMatrix) -> Result<ComplexMatrix, Error> {
        let equations = &self.system.equations;
        let n = equations.len();
        if n == 0 {
            return Ok(b.clone());
        }
        let sign = if s.im == 0.0 { 0.0 } else { s.im.signum() };
        let (ss, h) = (s * s, equations.hysteretic.as_ref());
        let entry = |i: usize, j: usize| {
            let lossy = h.map_or(0.0, |h| sign * h[(i, j)]);
            ss * equations.mass[(i, j)]
                + s * equations.damping[(i, j)]
                + Complex::new(equations.stiffness[(i, j)], lossy)
        };
        let size = |i: usize| {
            let own = equations.stiffness[(i, i)].abs()
                + s.norm() * equations.damping[(i, i)].abs()
                + ss.norm() * equations.mass[(i, i)].abs();
            // A power of two, so that scaling rounds nothing.
            if own > 0.0 {
                (-0.5 * own.log2()).round().exp2()
            } else {
                1.0
            }
        };
        let scale: Vec<f64> = (0..n).map(size).collect();
        let scaled = |i: usize, j: usize| entry(i, j) * (scale[i] * scale[j]);
        let right = ComplexMatrix::from_fn(n, b.ncols(), |i, j| b[(i, j)] * scale[i]);
        let y = match &self.pattern {
            Some(pattern) => pattern.solve(scaled, &right)?,
            None => definite::solve_complex(&ComplexMatrix::from_fn(n, n, scaled), &right)?,
        };
        Ok(ComplexMatrix::from_fn(n, b.ncols(), |i, j| {
            y[(i, j)] * scale[i]
        }))
    }

    /// The limit at rest of a free machine: it accelerates as one under what does not balance, and deforms under the rest.
    ///
    /// With R its rigid motions, `K x + M R a = b`, `Rᵀ M x = 0`: `x → x + R a / s²`.
    fn at_rest(&self) -> Result<ComplexMatrix, Error> {
        let system = &self.system;
        let (equations, rigid, n) = (&system.equations, system.rigid, system.len());
        let b = &system.loads;
        if system.undamped_rigid < rigid {
            let message = "a machine that only dampers hold has no answer at rest";
            return Err(Error::new(Code::Conflict, message)
                .hint("ask above 0 Hz, or prescribe an angle: --hold NODE"));
        }
        let own = Matrix::from_fn(rigid, rigid, |i, j| equations.mass[(i, j)]);
        let push = Matrix::from_fn(rigid, b.ncols(), |i, j| b[(i, j)]);
        let a = definite::solve(&own, &push)?;
        // The rest deforms: rows and columns of K beyond the rigid motions, which are exactly zero there.
        let rest = n - rigid;
        let k = Matrix::from_fn(rest, rest, |i, j| {
            equations.stiffness[(rigid + i, rigid + j)]
        });
        let f = Matrix::from_fn(rest, b.ncols(), |i, j| {
            b[(rigid + i, j)]
                - (0..rigid)
                    .map(|r| equations.mass[(rigid + i, r)] * a[(r, j)])
                    .sum::<f64>()
        });
        let bent = if rest > 0 {
            definite::solve(&k, &f)?
        } else {
            f
        };
        let mut answer = ComplexMatrix::zeros(system.outputs.len(), system.inputs.len());
        for (o, terms) in system.outputs.iter().enumerate() {
            if self.turns_away(terms) {
                let message = format!(
                    "`{}` has no value at 0 Hz: the machine is free to turn away",
                    system.names[o]
                );
                let hint = "ask above 0 Hz, or for a difference that no rigid motion changes, or prescribe an angle: --hold NODE";
                return Err(Error::new(Code::Conflict, message).hint(hint));
            }
            for (i, loads) in system.inputs.iter().enumerate() {
                let mut sum = 0.0;
                for &(_, load) in loads.iter().filter(|t| t.0 == Factor::ONE) {
                    for &(factor, row) in terms.iter().filter(|t| !t.0.lossy) {
                        let value = match factor.power {
                            0 => (0..rest)
                                .map(|j| system.reads[(row, rigid + j)] * bent[(j, load)])
                                .sum(),
                            2 => (0..rigid)
                                .map(|r| system.reads[(row, r)] * a[(r, load)])
                                .sum(),
                            _ => 0.0,
                        };
                        sum += value;
                    }
                }
                let direct = system.through[o][i].iter().filter(|t| t.0 == Factor::ONE);
                answer[(o, i)] = Complex::new(sum + direct.map(|t| t.1).sum::<f64>(), 0.0);
            }
        }
        Ok(answer)
    }

    /// Whether rows for a displacement or a speed see a motion that strains nothing.
    fn turns_away(&self, terms: &[(Factor, usize)]) -> bool {
        let (reads, rigid) = (&self.system.reads, self.system.rigid);
        let largest = |row: usize, count: usize| {
            (0..count)
                .map(|j| reads[(row, j)].abs())
                .fold(0.0, f64::max)
        };
        terms
            .iter()
            .filter(|t| t.0.power < 2)
            .any(|&(_, row)| largest(row, rigid) > RELATIVE * largest(row, reads.ncols()))
    }
}

/// Of the largest entry of a row: less along a rigid motion is rounding of ratios that are fractions.
const RELATIVE: f64 = 1e-12;

/// Frequencies whose square times an inertia may leave the range of numbers, rad/s.
const HIGHEST: f64 = 1e100;

/// No answer at a frequency, rad/s.
pub(super) fn resonance(omega: f64) -> Error {
    let at = format!("at {} Hz", figure(omega / std::f64::consts::TAU));
    if omega > HIGHEST {
        let message = format!("{at} the forces of inertia leave the range of numbers");
        return Error::new(Code::Overflow, message).hint("ask for lower frequencies");
    }
    let message = format!("{at} the machine is at a resonance that nothing damps");
    Error::new(Code::Indefinite, message)
        .hint("give the machine its damping, or ask beside this frequency")
}

fn complex(a: &Matrix) -> ComplexMatrix {
    ComplexMatrix::from_fn(a.nrows(), a.ncols(), |i, j| Complex::new(a[(i, j)], 0.0))
}

impl System {
    /// `Σ φ_c φ_b g(c, b) + d`, outputs by inputs, from `g = c D⁻¹ b` of every row and column.
    pub(super) fn joined(&self, s: Complex, g: impl Fn(usize, usize) -> Complex) -> ComplexMatrix {
        ComplexMatrix::from_fn(self.outputs.len(), self.inputs.len(), |o, i| {
            let mut sum = Complex::ZERO;
            for &(read, row) in &self.outputs[o] {
                for &(load, column) in &self.inputs[i] {
                    sum += read.at(s) * load.at(s) * g(row, column);
                }
            }
            self.through[o][i]
                .iter()
                .fold(sum, |sum, &(factor, value)| sum + factor.at(s) * value)
        })
    }
}
