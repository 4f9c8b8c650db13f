//! Identification methods: names and required data.

use crate::identify::series::model::ModelStructure;

/// A method that ends in modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IdentificationMethod {
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

/// Data that a method requires.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RequiredData {
    /// Frequency responses, read or estimated from an input and outputs.
    Responses,
    /// Signals of outputs, no input.
    Outputs,
    /// The signal of one output, no input.
    OneOutput,
    /// Signals of one input and one output.
    InputAndOutput,
    /// The signal of one output, and of one input where it was measured.
    OutputWithOptionalInput,
}

impl IdentificationMethod {
    /// Every method.
    pub const ALL: [IdentificationMethod; 18] = [
        IdentificationMethod::Rational,
        IdentificationMethod::Plscf,
        IdentificationMethod::Lsce,
        IdentificationMethod::Rfp,
        IdentificationMethod::Circle,
        IdentificationMethod::VectorFitting,
        IdentificationMethod::Aaa,
        IdentificationMethod::SsiCov,
        IdentificationMethod::SsiData,
        IdentificationMethod::FreeDecay,
        IdentificationMethod::Fdd,
        IdentificationMethod::Efdd,
        IdentificationMethod::Ar,
        IdentificationMethod::Arma,
        IdentificationMethod::Arx,
        IdentificationMethod::Armax,
        IdentificationMethod::OutputError,
        IdentificationMethod::Rls,
    ];

    /// The word users say.
    pub fn name(self) -> &'static str {
        match self {
            IdentificationMethod::Rational => "rational",
            IdentificationMethod::Plscf => "plscf",
            IdentificationMethod::Lsce => "lsce",
            IdentificationMethod::Rfp => "rfp",
            IdentificationMethod::Circle => "circle",
            IdentificationMethod::VectorFitting => "vector-fitting",
            IdentificationMethod::Aaa => "aaa",
            IdentificationMethod::SsiCov => "ssi-cov",
            IdentificationMethod::SsiData => "ssi-data",
            IdentificationMethod::FreeDecay => "free-decay",
            IdentificationMethod::Fdd => "fdd",
            IdentificationMethod::Efdd => "efdd",
            IdentificationMethod::Ar => "ar",
            IdentificationMethod::Arma => "arma",
            IdentificationMethod::Arx => "arx",
            IdentificationMethod::Armax => "armax",
            IdentificationMethod::OutputError => "output-error",
            IdentificationMethod::Rls => "rls",
        }
    }

    /// Data that the method requires.
    pub fn required_data(self) -> RequiredData {
        match self {
            IdentificationMethod::Rational
            | IdentificationMethod::Plscf
            | IdentificationMethod::Lsce
            | IdentificationMethod::Rfp
            | IdentificationMethod::Circle
            | IdentificationMethod::VectorFitting
            | IdentificationMethod::Aaa => RequiredData::Responses,
            IdentificationMethod::SsiCov
            | IdentificationMethod::SsiData
            | IdentificationMethod::FreeDecay
            | IdentificationMethod::Fdd
            | IdentificationMethod::Efdd => RequiredData::Outputs,
            IdentificationMethod::Ar | IdentificationMethod::Arma => RequiredData::OneOutput,
            IdentificationMethod::Arx
            | IdentificationMethod::Armax
            | IdentificationMethod::OutputError => RequiredData::InputAndOutput,
            IdentificationMethod::Rls => RequiredData::OutputWithOptionalInput,
        }
    }
}

/// A family with its numbers of coefficients.
pub fn structure_text(family: ModelStructure) -> String {
    match family {
        ModelStructure::Ar { a } => format!("AR({a})"),
        ModelStructure::Arma { a, c } => format!("ARMA({a}, {c})"),
        ModelStructure::Arx { a, b, delay } => format!("ARX({a}, {b}, delay {delay})"),
        ModelStructure::Armax { a, b, c, delay } => format!("ARMAX({a}, {b}, {c}, delay {delay})"),
        ModelStructure::OutputError { b, f, delay } => {
            format!("output-error({b}, {f}, delay {delay})")
        }
    }
}
