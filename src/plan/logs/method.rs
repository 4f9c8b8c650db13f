//! The methods of identification: their words, and what they take.

use crate::identify::series::model::Family;

/// A method that ends in modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Common poles by maximum likelihood.
    Rational,
    /// Poly-reference least-squares complex frequency domain.
    Plscf,
    /// Least-squares complex exponential.
    Lsce,
    /// Rational fraction polynomials.
    Rfp,
    /// One peak at a time: circle, checked by half power.
    Circle,
    /// Poles moved to the zeros of their own correction.
    VectorFitting,
    /// Barycentric interpolation.
    Aaa,
    /// Stochastic subspace from covariances.
    SsiCov,
    /// Stochastic subspace from data.
    SsiData,
    /// Common poles of the transforms of free decays.
    FreeDecay,
    /// Frequency-domain decomposition.
    Fdd,
    /// The same with damping from the bell of each peak.
    Efdd,
    /// `A y = e`.
    Ar,
    /// `A y = C e`.
    Arma,
    /// `A y = B u + e`.
    Arx,
    /// `A y = B u + C e`.
    Armax,
    /// `y = B/F u + e`.
    OutputError,
    /// `A y = B u + e` whose coefficients change, by recursive least squares.
    Rls,
}

/// What a method starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// Frequency responses, read or estimated from an input and outputs.
    Responses,
    /// Signals of outputs, no input.
    Outputs,
    /// The signal of one output, no input.
    OneOutput,
    /// Signals of one input and one output.
    InputAndOutput,
    /// The signal of one output, and of one input where it was measured.
    OutputAndPerhapsInput,
}

impl Method {
    /// Every method.
    pub const ALL: [Method; 18] = [
        Method::Rational,
        Method::Plscf,
        Method::Lsce,
        Method::Rfp,
        Method::Circle,
        Method::VectorFitting,
        Method::Aaa,
        Method::SsiCov,
        Method::SsiData,
        Method::FreeDecay,
        Method::Fdd,
        Method::Efdd,
        Method::Ar,
        Method::Arma,
        Method::Arx,
        Method::Armax,
        Method::OutputError,
        Method::Rls,
    ];

    /// The word users say.
    pub fn word(self) -> &'static str {
        match self {
            Method::Rational => "rational",
            Method::Plscf => "plscf",
            Method::Lsce => "lsce",
            Method::Rfp => "rfp",
            Method::Circle => "circle",
            Method::VectorFitting => "vector-fitting",
            Method::Aaa => "aaa",
            Method::SsiCov => "ssi-cov",
            Method::SsiData => "ssi-data",
            Method::FreeDecay => "free-decay",
            Method::Fdd => "fdd",
            Method::Efdd => "efdd",
            Method::Ar => "ar",
            Method::Arma => "arma",
            Method::Arx => "arx",
            Method::Armax => "armax",
            Method::OutputError => "output-error",
            Method::Rls => "rls",
        }
    }

    /// What it starts from.
    pub fn needs(self) -> Needs {
        match self {
            Method::Rational
            | Method::Plscf
            | Method::Lsce
            | Method::Rfp
            | Method::Circle
            | Method::VectorFitting
            | Method::Aaa => Needs::Responses,
            Method::SsiCov | Method::SsiData | Method::FreeDecay | Method::Fdd | Method::Efdd => {
                Needs::Outputs
            }
            Method::Ar | Method::Arma => Needs::OneOutput,
            Method::Arx | Method::Armax | Method::OutputError => Needs::InputAndOutput,
            Method::Rls => Needs::OutputAndPerhapsInput,
        }
    }
}

/// A family with its numbers of coefficients.
pub fn family(family: Family) -> String {
    match family {
        Family::Ar { a } => format!("AR({a})"),
        Family::Arma { a, c } => format!("ARMA({a}, {c})"),
        Family::Arx { a, b, delay } => format!("ARX({a}, {b}, delay {delay})"),
        Family::Armax { a, b, c, delay } => format!("ARMAX({a}, {b}, {c}, delay {delay})"),
        Family::OutputError { b, f, delay } => format!("output-error({b}, {f}, delay {delay})"),
    }
}
