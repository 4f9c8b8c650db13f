//! Transfer function by poles and residues: `H(s) = e^{−sτ} [Σ R_k/(s − p_k) + … + D + E s + Q s²]`.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::recording::frequency_responses::ChannelLabel;

/// Residual terms of modes outside the band, and direct transmission.
///
/// In units of the response times those of s: below the band `L₂/s²` stands for rigid bodies in a response of displacement,
/// above it `D` for all that is stiffer; differentiated once or twice for velocity and acceleration, hence up to s².
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DirectTerms {
    /// L₂, of `1/s²`.
    pub inverse_square: f64,
    /// L₁, of `1/s`.
    pub inverse: f64,
    /// D.
    pub constant: f64,
    /// E, of `s`.
    pub slope: f64,
    /// Q, of `s²`.
    pub square: f64,
}

impl DirectTerms {
    /// The coefficients of `s⁻²` to `s²`.
    pub fn coefficients(&self) -> [f64; 5] {
        [
            self.inverse_square,
            self.inverse,
            self.constant,
            self.slope,
            self.square,
        ]
    }

    /// Number of poles at zero that the terms add: 0, 1 or 2.
    pub(super) fn integrators(&self) -> usize {
        match (self.inverse_square != 0.0, self.inverse != 0.0) {
            (true, _) => 2,
            (false, true) => 1,
            _ => 0,
        }
    }

    /// By how many powers it grows at high frequency: 0, 1 or 2.
    pub(super) fn polynomial_degree(&self) -> usize {
        match (self.square != 0.0, self.slope != 0.0) {
            (true, _) => 2,
            (false, true) => 1,
            _ => 0,
        }
    }

    /// Value at s; terms that are nil are left out, so that s may be zero.
    fn value(&self, s: Complex) -> Complex {
        let terms = self.coefficients().into_iter().zip(-2..=2);
        terms
            .filter(|(c, _)| *c != 0.0)
            .map(|(c, power)| s.powi(power) * c)
            .fold(Complex::ZERO, |sum, term| sum + term)
    }
}

/// A transfer function of a real system, its poles in rad/s.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferFunction {
    /// Excitation channel; `None` where unknown.
    pub input: Option<ChannelLabel>,
    /// Response channel.
    pub output: ChannelLabel,
    /// Relative rms misfit over the lines it was fitted to, where it was.
    pub fit_error: Option<f64>,
    pub(super) poles: Vec<Complex>,
    pub(super) residues: Vec<Complex>,
    pub(super) direct: DirectTerms,
    pub(super) delay_s: f64,
}

impl TransferFunction {
    /// Transfer function with poles on and above the real axis, rad/s; those above represent their conjugates too.
    ///
    /// # Errors
    /// `OutOfRange` for a pole below the real axis, a real pole with a complex residue, a negative delay, what is not finite;
    /// `Conflict` for residues that are not as many as the poles.
    pub fn new(
        poles: Vec<Complex>,
        residues: Vec<Complex>,
        direct: DirectTerms,
    ) -> Result<TransferFunction, Error> {
        if poles.len() != residues.len() {
            let message = format!("{} poles have {} residues", poles.len(), residues.len());
            return Err(
                Error::new(Code::Conflict, message).with_hint("give one residue for each pole")
            );
        }
        let finite = |z: &Complex| z.re.is_finite() && z.im.is_finite();
        for (k, (p, r)) in poles.iter().zip(&residues).enumerate() {
            let wrong = if !finite(p) || !finite(r) {
                "is not finite"
            } else if p.im < 0.0 {
                "lies below the real axis: give its conjugate, which represents both"
            } else if p.im == 0.0 && r.im != 0.0 {
                "is real and has a complex residue"
            } else {
                continue;
            };
            let message = format!("pole {k}, {p} rad/s with residue {r}, {wrong}");
            return Err(Error::new(Code::OutOfRange, message).with_hint(
                "a real system has real poles with real residues, and conjugate pairs",
            ));
        }
        if let Some(c) = direct.coefficients().iter().find(|c| !c.is_finite()) {
            let message = format!("a direct term of a transfer function is {c}");
            return Err(
                Error::new(Code::OutOfRange, message).with_hint("omit it, or give a finite number")
            );
        }
        Ok(TransferFunction {
            input: None,
            output: ChannelLabel::default(),
            fit_error: None,
            poles,
            residues,
            direct,
            delay_s: 0.0,
        })
    }

    /// The same between named terminals.
    pub fn with_labels(
        mut self,
        input: Option<ChannelLabel>,
        output: ChannelLabel,
    ) -> TransferFunction {
        (self.input, self.output) = (input, output);
        self
    }

    /// The function over s, the output integrated once: `R/((s − p) s) = (R/p)/(s − p) − (R/p)/s`.
    ///
    /// # Errors
    /// `OutOfRange` for a pole at zero or a term in 1/s², which has no partial fractions here.
    pub fn integrated(&self) -> Result<TransferFunction, Error> {
        let d = self.direct;
        if d.inverse_square != 0.0 || self.poles.iter().any(|p| p.norm() == 0.0) {
            let message = format!(
                "the function to `{}` integrates twice already",
                self.output.name
            );
            return Err(Error::new(Code::OutOfRange, message));
        }
        let residues: Vec<Complex> = (self.residues.iter().zip(&self.poles))
            .map(|(r, p)| r / p)
            .collect();
        let pairs = self.poles.iter().zip(&residues);
        let (sum, size) = pairs.fold((0.0, 0.0), |(sum, size), (p, r)| {
            let both = if p.im == 0.0 { r.re } else { 2.0 * r.re };
            (sum + both, size + both.abs())
        });
        // What cancels to rounding is nothing: a differentiated response has no such part.
        const ROUNDING: f64 = 1e-9;
        let left = d.constant - sum;
        let inverse = if left.abs() <= ROUNDING * (size + d.constant.abs()) {
            0.0
        } else {
            left
        };
        Ok(TransferFunction {
            residues,
            direct: DirectTerms {
                inverse_square: d.inverse,
                inverse,
                constant: d.slope,
                slope: d.square,
                square: 0.0,
            },
            ..self.clone()
        })
    }

    /// It grows with s, so that no state space holds it.
    pub fn is_improper(&self) -> bool {
        self.direct.polynomial_degree() > 0
    }

    /// The same with a dead time, s.
    ///
    /// # Errors
    /// `OutOfRange` where it is negative or not finite.
    pub fn with_delay(mut self, delay_s: f64) -> Result<TransferFunction, Error> {
        if !(delay_s >= 0.0 && delay_s.is_finite()) {
            let message = format!("a dead time of {delay_s} s cannot be");
            return Err(Error::new(Code::OutOfRange, message).with_hint(
                "check whether input and output are exchanged: the response precedes its excitation",
            ));
        }
        self.delay_s = delay_s;
        Ok(self)
    }

    /// Poles on and above the real axis, rad/s; those above represent their conjugates too.
    pub fn poles(&self) -> &[Complex] {
        &self.poles
    }

    /// The residue of each of [`TransferFunction::poles`], units of the response times rad/s.
    pub fn residues(&self) -> &[Complex] {
        &self.residues
    }

    /// The terms next to the poles.
    pub fn direct(&self) -> DirectTerms {
        self.direct
    }

    /// Dead time, s.
    pub fn delay_s(&self) -> f64 {
        self.delay_s
    }

    /// Poles with residues, conjugates after each of a pair: twice the upper ones and once the real ones.
    pub fn poles_with_conjugates(&self) -> Vec<(Complex, Complex)> {
        let both = |(&p, &r): (&Complex, &Complex)| {
            let twin = (p.im > 0.0).then(|| (p.conj(), r.conj()));
            std::iter::once((p, r)).chain(twin)
        };
        self.poles
            .iter()
            .zip(&self.residues)
            .flat_map(both)
            .collect()
    }

    /// `H(s)`; infinite or not a number at a pole. s in rad/s.
    pub fn value(&self, s: Complex) -> Complex {
        let delay = if self.delay_s == 0.0 {
            Complex::ONE
        } else {
            (-s * self.delay_s).exp()
        };
        delay * self.value_without_delay(s)
    }

    /// `H(i2πf)` at each frequency, Hz.
    pub fn response(&self, frequency_hz: &[f64]) -> Vec<Complex> {
        let at = |f: &f64| self.value(Complex::new(0.0, TAU * f));
        frequency_hz.iter().map(at).collect()
    }

    /// `H(s)` without the dead time.
    pub(super) fn value_without_delay(&self, s: Complex) -> Complex {
        let term = |(&p, &r): (&Complex, &Complex)| {
            let own = r / (s - p);
            if p.im > 0.0 {
                own + r.conj() / (s - p.conj())
            } else {
                own
            }
        };
        let poles = self.poles.iter().zip(&self.residues).map(term);
        poles.fold(self.direct.value(s), |sum, term| sum + term)
    }

    /// `dH/ds` without the dead time.
    pub(super) fn derivative_without_delay(&self, s: Complex) -> Complex {
        let terms = self.direct.coefficients().into_iter().zip(-2..=2);
        let direct = terms
            .filter(|(c, power)| *c != 0.0 && *power != 0)
            .map(|(c, power)| s.powi(power - 1) * (c * f64::from(power)))
            .fold(Complex::ZERO, |sum, term| sum + term);
        let square = |z: Complex| z * z;
        self.poles_with_conjugates()
            .iter()
            .fold(direct, |sum, &(p, r)| sum - r / square(s - p))
    }
}
