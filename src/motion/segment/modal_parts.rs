//! Modal parts of a linear system, `σ̇ = Λ σ + β`, each with a closed-form solution.

use super::dense::DenseSystem;
use crate::numeric::Complex;

/// Decoupled modal parts of a linear system. States σ in order: two of every oscillatory part, then those of the other parts.
#[derive(Debug, Clone, Default)]
pub struct ModalParts {
    /// Eigenvalues λ, 1/s, with Im λ > 0: `ζ̇ = λ ζ + β`, σ = (Re ζ, Im ζ).
    pub oscillatory: Vec<Complex>,
    /// Non-oscillatory parts.
    pub others: Vec<NonOscillatoryPart>,
}

/// Non-oscillatory modal part, or a dense part of coupled states.
#[derive(Debug, Clone)]
pub enum NonOscillatoryPart {
    /// First-order decay `ẋ = λ x + β`.
    Decay(f64),
    /// Rigid motion `ṗ = v`, `v̇ = λ v + β`, damped or undamped; σ = (p, v).
    RigidMotion(f64),
    /// Near-critical damping, `η̈ + d η̇ + w² η = β` with d near 2w, for which two exponentials would cancel; σ = (η, η̇).
    Critical {
        /// Damping d, 1/s.
        d: f64,
        /// Squared natural frequency w², 1/s².
        square: f64,
    },
    /// Coupled states with nearly coincident eigenvectors, solved by matrix exponentials.
    Dense(Box<DenseSystem>),
}

impl NonOscillatoryPart {
    /// Number of states.
    pub fn count(&self) -> usize {
        match self {
            NonOscillatoryPart::Decay(_) => 1,
            NonOscillatoryPart::RigidMotion(_) | NonOscillatoryPart::Critical { .. } => 2,
            NonOscillatoryPart::Dense(dense) => dense.count(),
        }
    }

    /// Upper bound of the rates of change of the part, 1/s.
    pub fn rate(&self) -> f64 {
        match self {
            NonOscillatoryPart::Decay(lambda) | NonOscillatoryPart::RigidMotion(lambda) => {
                lambda.abs()
            }
            NonOscillatoryPart::Critical { d, .. } => d.abs(),
            NonOscillatoryPart::Dense(dense) => dense.norm(),
        }
    }
}

/// Harmonic forcing near an eigenvalue: steady-state and free response would cancel.
#[derive(Debug, Clone)]
pub struct ResonantForcing {
    /// Index of the oscillatory part, or of the other part.
    pub part: PartIndex,
    /// Index of the harmonic in the list of frequencies.
    pub frequency: usize,
    /// Frequency ω, rad/s.
    pub omega: f64,
    /// Forcing of ζ per `e^{iωt}`, 1/s; for a rigid motion the real part acts on v.
    pub push: Complex,
}

/// Index of a modal part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PartIndex {
    /// Index of an oscillatory part.
    Oscillatory(usize),
    /// Index of a non-oscillatory part and of its first state.
    Other(usize, usize),
}

/// Steady-state response to a harmonic.
#[derive(Debug, Clone)]
pub struct SteadyState {
    /// Steady-state phasors of σ.
    pub phasors: Vec<Complex>,
    /// Forcing phasors of σ without steady-state response.
    pub residual: Vec<Complex>,
    /// Near-resonant forcing that replaces it.
    pub near: Vec<ResonantForcing>,
}

impl ModalParts {
    /// Number of states.
    pub fn count(&self) -> usize {
        2 * self.oscillatory.len()
            + self
                .others
                .iter()
                .map(NonOscillatoryPart::count)
                .sum::<usize>()
    }

    /// Largest growth rate of any part, 1/s; zero if none grows.
    pub fn growth(&self) -> f64 {
        let oscillations = self.oscillatory.iter().map(|l| l.re);
        let others = self.others.iter().map(|other| match other {
            NonOscillatoryPart::Decay(lambda) | NonOscillatoryPart::RigidMotion(lambda) => *lambda,
            NonOscillatoryPart::Critical { d, .. } => -d,
            NonOscillatoryPart::Dense(dense) => dense.growth(),
        });
        oscillations.chain(others).fold(0.0, f64::max)
    }

    /// Row `c Λ`, the time derivative of an output row c.
    pub fn rate_row(&self, c: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; c.len()];
        for (k, l) in self.oscillatory.iter().enumerate() {
            out[2 * k] = c[2 * k] * l.re + c[2 * k + 1] * l.im;
            out[2 * k + 1] = c[2 * k + 1] * l.re - c[2 * k] * l.im;
        }
        let mut j = 2 * self.oscillatory.len();
        for other in &self.others {
            match other {
                NonOscillatoryPart::Decay(lambda) => out[j] = c[j] * lambda,
                NonOscillatoryPart::RigidMotion(lambda) => out[j + 1] = c[j] + c[j + 1] * lambda,
                NonOscillatoryPart::Critical { d, square } => {
                    out[j] = -square * c[j + 1];
                    out[j + 1] = c[j] - d * c[j + 1];
                }
                NonOscillatoryPart::Dense(dense) => dense.rate_of(&c[j..], &mut out[j..]),
            }
            j += other.count();
        }
        out
    }

    /// Moduli of an output row c: of every oscillatory part, then of every other state.
    pub fn part_sizes(&self, c: &[f64]) -> Vec<f64> {
        let two = 2 * self.oscillatory.len();
        let oscillations = c[..two].chunks_exact(2).map(|c| c[0].hypot(c[1]));
        oscillations
            .chain(c[two..].iter().map(|c| c.abs()))
            .collect()
    }

    /// Steady-state response to `Re(b e^{iωt})` except near-resonant forcing. `span` is the length of the run, s.
    pub fn steady_state(
        &self,
        b: &[Complex],
        (frequency, omega): (usize, f64),
        span: f64,
    ) -> SteadyState {
        let i = Complex::new(0.0, 1.0);
        let s = i * omega;
        let mut out = vec![Complex::ZERO; b.len()];
        let mut residual = out.clone();
        let mut near = Vec::new();
        for (k, &lambda) in self.oscillatory.iter().enumerate() {
            let (x, y) = (b[2 * k], b[2 * k + 1]);
            // β(t) = P e^{iωt} + Q e^{−iωt}
            let p = (x + i * y) * 0.5;
            let q = (x.conj() + i * y.conj()) * 0.5;
            let mut respond = |push: Complex, signed: f64| {
                let kappa = i * signed - lambda;
                if push == Complex::ZERO {
                    return Complex::ZERO;
                }
                if kappa.norm() < RESONANCE_RATIO * lambda.norm() {
                    let (real, imaginary) = match signed == omega {
                        true => (push, -i * push),
                        false => (push.conj(), i * push.conj()),
                    };
                    residual[2 * k] += real;
                    residual[2 * k + 1] += imaginary;
                    near.push(ResonantForcing {
                        part: PartIndex::Oscillatory(k),
                        frequency,
                        omega: signed,
                        push,
                    });
                    return Complex::ZERO;
                }
                push / kappa
            };
            let forward = respond(p, omega);
            let backward = respond(q, -omega).conj();
            out[2 * k] = forward + backward;
            out[2 * k + 1] = (forward - backward) * -i;
        }
        let mut j = 2 * self.oscillatory.len();
        for (number, other) in self.others.iter().enumerate() {
            let mut add_near = |state: usize| {
                residual[state] = b[state];
                near.push(ResonantForcing {
                    part: PartIndex::Other(number, j),
                    frequency,
                    omega,
                    push: b[state],
                });
            };
            match other {
                NonOscillatoryPart::Decay(lambda) if omega.abs().max(lambda.abs()) * span < 1.0 => {
                    add_near(j)
                }
                NonOscillatoryPart::Decay(lambda) => out[j] = b[j] / (s - lambda),
                NonOscillatoryPart::RigidMotion(_) if omega.abs() * span < 1.0 => add_near(j + 1),
                NonOscillatoryPart::RigidMotion(lambda) => {
                    out[j + 1] = b[j + 1] / (s - lambda);
                    out[j] = out[j + 1] / s;
                }
                NonOscillatoryPart::Critical { d, square } => {
                    out[j] = b[j + 1] / (s * s + s * d + square);
                    out[j + 1] = out[j] * s;
                }
                // Dense parts include their harmonics.
                NonOscillatoryPart::Dense(dense) => {
                    residual[j..j + dense.count()].copy_from_slice(&b[j..j + dense.count()])
                }
            }
            j += other.count();
        }
        SteadyState {
            phasors: out,
            residual,
            near,
        }
    }
}

/// Largest |iω − λ|/|λ| of a near-resonant forcing: separate responses would lose one digit.
const RESONANCE_RATIO: f64 = 0.1;
