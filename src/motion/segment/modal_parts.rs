//! Modal parts of a linear system, each with a closed-form solution.

use super::dense::DenseSystem;
use crate::numeric::Complex;

/// Parts of a segment solved on their own. Their states σ follow one another: two of every oscillatory part, then those of the others.
#[derive(Debug, Clone, Default)]
pub struct ModalParts {
    /// λ with Im λ > 0: `ζ̇ = λ ζ + β`, σ = (Re ζ, Im ζ).
    pub oscillatory: Vec<Complex>,
    /// The rest.
    pub others: Vec<NonOscillatoryPart>,
}

/// A part that is not oscillatory, or cannot be separated from the others.
#[derive(Debug, Clone)]
pub enum NonOscillatoryPart {
    /// `ẋ = λ x + β`.
    Decay(f64),
    /// `ṗ = v`, `v̇ = λ v + β`; σ = (p, v). Rigid motions, braked or not.
    RigidMotion(f64),
    /// `η̈ + d η̇ + w² η = β` with d near 2w, where two exponentials would cancel; σ = (η, η̇).
    Critical {
        /// 1/s.
        d: f64,
        /// 1/s².
        square: f64,
    },
    /// All states at once, by matrix exponentials: where eigenvectors nearly coincide.
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

    /// A rate that no change of the part exceeds, 1/s.
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

/// A harmonic so near a root that their responses must not be taken apart.
#[derive(Debug, Clone)]
pub struct ResonantForcing {
    /// Index of the oscillatory part, or of the other part.
    pub part: PartIndex,
    /// Which harmonic, by its place in the list of frequencies.
    pub frequency: usize,
    /// ω, rad/s.
    pub omega: f64,
    /// The push on ζ per `e^{iωt}`; for a coast on v, the real part counting.
    pub push: Complex,
}

/// A part by its number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PartIndex {
    /// Index of an oscillatory part.
    Oscillatory(usize),
    /// Index of another part: its number and its first state.
    Other(usize, usize),
}

/// Steady-state response to a harmonic.
#[derive(Debug, Clone)]
pub struct SteadyState {
    /// Phasors of σ.
    pub phasors: Vec<Complex>,
    /// Phasors of the push on σ that the response does not contain.
    pub left: Vec<Complex>,
    /// Near-resonant forcing that carries this push.
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

    /// The fastest growth of a part, 1/s; zero where none grows.
    pub fn growth(&self) -> f64 {
        let oscillations = self.oscillatory.iter().map(|l| l.re);
        let others = self.others.iter().map(|other| match other {
            NonOscillatoryPart::Decay(lambda) | NonOscillatoryPart::RigidMotion(lambda) => *lambda,
            NonOscillatoryPart::Critical { d, .. } => -d,
            NonOscillatoryPart::Dense(dense) => dense.growth(),
        });
        oscillations.chain(others).fold(0.0, f64::max)
    }

    /// `Λ` applied to the left: the row c Λ.
    pub fn rate_row(&self, c: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; c.len()];
        for (k, l) in self.oscillatory.iter().enumerate() {
            out[2 * k] = c[2 * k] * l.re + c[2 * k + 1] * l.im;
            out[2 * k + 1] = c[2 * k + 1] * l.re - c[2 * k] * l.im;
        }
        let mut at = 2 * self.oscillatory.len();
        for other in &self.others {
            match other {
                NonOscillatoryPart::Decay(lambda) => out[at] = c[at] * lambda,
                NonOscillatoryPart::RigidMotion(lambda) => out[at + 1] = c[at] + c[at + 1] * lambda,
                NonOscillatoryPart::Critical { d, square } => {
                    out[at] = -square * c[at + 1];
                    out[at + 1] = c[at] - d * c[at + 1];
                }
                NonOscillatoryPart::Dense(dense) => dense.rate_of(&c[at..], &mut out[at..]),
            }
            at += other.count();
        }
        out
    }

    /// `|c|` part by part: of every oscillatory part, then of every other state.
    pub fn part_sizes(&self, c: &[f64]) -> Vec<f64> {
        let two = 2 * self.oscillatory.len();
        let oscillations = c[..two].chunks_exact(2).map(|c| c[0].hypot(c[1]));
        oscillations
            .chain(c[two..].iter().map(|c| c.abs()))
            .collect()
    }

    /// Steady-state response to `Re(b e^{iωt})`; pushes too near a root are left out. `span` is the length of the run, s.
    pub fn steady_state(
        &self,
        b: &[Complex],
        (frequency, omega): (usize, f64),
        span: f64,
    ) -> SteadyState {
        let i = Complex::new(0.0, 1.0);
        let s = i * omega;
        let mut out = vec![Complex::ZERO; b.len()];
        let mut left = out.clone();
        let mut near = Vec::new();
        for (k, &lambda) in self.oscillatory.iter().enumerate() {
            let (x, y) = (b[2 * k], b[2 * k + 1]);
            // β(t) = P e^{iωt} + Q e^{−iωt}
            let p = (x + i * y) * 0.5;
            let q = (x.conj() + i * y.conj()) * 0.5;
            let mut turn = |push: Complex, signed: f64| {
                let kappa = i * signed - lambda;
                if push == Complex::ZERO {
                    return Complex::ZERO;
                }
                if kappa.norm() < RESONANCE_RATIO * lambda.norm() {
                    let (real, imaginary) = match signed == omega {
                        true => (push, -i * push),
                        false => (push.conj(), i * push.conj()),
                    };
                    left[2 * k] += real;
                    left[2 * k + 1] += imaginary;
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
            let forward = turn(p, omega);
            let backward = turn(q, -omega).conj();
            out[2 * k] = forward + backward;
            out[2 * k + 1] = (forward - backward) * -i;
        }
        let mut at = 2 * self.oscillatory.len();
        for (number, other) in self.others.iter().enumerate() {
            let mut slow = |state: usize| {
                left[state] = b[state];
                near.push(ResonantForcing {
                    part: PartIndex::Other(number, at),
                    frequency,
                    omega,
                    push: b[state],
                });
            };
            match other {
                NonOscillatoryPart::Decay(lambda) if omega.abs().max(lambda.abs()) * span < 1.0 => {
                    slow(at)
                }
                NonOscillatoryPart::Decay(lambda) => out[at] = b[at] / (s - lambda),
                NonOscillatoryPart::RigidMotion(_) if omega.abs() * span < 1.0 => slow(at + 1),
                NonOscillatoryPart::RigidMotion(lambda) => {
                    out[at + 1] = b[at + 1] / (s - lambda);
                    out[at] = out[at + 1] / s;
                }
                NonOscillatoryPart::Critical { d, square } => {
                    out[at] = b[at + 1] / (s * s + s * d + square);
                    out[at + 1] = out[at] * s;
                }
                // It knows its harmonics itself.
                NonOscillatoryPart::Dense(dense) => {
                    left[at..at + dense.count()].copy_from_slice(&b[at..at + dense.count()])
                }
            }
            at += other.count();
        }
        SteadyState {
            phasors: out,
            left,
            near,
        }
    }
}

/// |iω − λ| below this share of |λ| is taken as resonance: apart, a digit would go.
const RESONANCE_RATIO: f64 = 0.1;
