//! Identification methods: names and required data.

use crate::base::table_reader::Word;
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
    /// The word users say.
    pub fn name(self) -> &'static str {
        let row = Self::WORDS.iter().find(|(_, method, _)| *method == self);
        row.map_or("", |(word, ..)| word)
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

#[rustfmt::skip]
impl Word for IdentificationMethod {
    const WORDS: &'static [(&'static str, IdentificationMethod, &'static str)] = &[
        ("rational", IdentificationMethod::Rational, "Common poles by maximum likelihood, with uncertainty"),
        ("plscf", IdentificationMethod::Plscf, "Least-squares complex frequency domain over rising orders"),
        ("lsce", IdentificationMethod::Lsce, "Least-squares complex exponential over rising orders"),
        ("rfp", IdentificationMethod::Rfp, "Rational fraction polynomials over rising orders"),
        ("circle", IdentificationMethod::Circle, "A circle through each peak, with the half-power width for comparison"),
        ("vector-fitting", IdentificationMethod::VectorFitting, "Significant poles of vector fitting, refined together"),
        ("aaa", IdentificationMethod::Aaa, "Significant poles of barycentric interpolation, refined together"),
        ("ssi-cov", IdentificationMethod::SsiCov, "No input: stochastic subspace from covariances, with uncertainty"),
        ("ssi-data", IdentificationMethod::SsiData, "No input: stochastic subspace from data"),
        ("free-decay", IdentificationMethod::FreeDecay, "No input: common poles of free decays, with uncertainty; the default if the record rings down after a release"),
        ("fdd", IdentificationMethod::Fdd, "No input: peaks of the spectral matrix, no damping"),
        ("efdd", IdentificationMethod::Efdd, "No input: peaks of the spectral matrix, damping from their bells; --svg shows these"),
        ("ar", IdentificationMethod::Ar, "One output, no input: autoregressive"),
        ("arma", IdentificationMethod::Arma, "One output, no input: autoregressive, moving average"),
        ("arx", IdentificationMethod::Arx, "One input, one output: autoregressive"),
        ("armax", IdentificationMethod::Armax, "One input, one output: autoregressive, moving average"),
        ("output-error", IdentificationMethod::OutputError, "One input, one output: noise on the output only"),
        ("rls", IdentificationMethod::Rls, "One output, with or without an input: modes that change in the course of the record, by recursive least squares"),
    ];
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
