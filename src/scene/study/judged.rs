//! Studies of the methods themselves: error against run time, and where they break.

use super::motion::simulate;
use super::{ResponseStudy, SimulateStudy, SpeedRange, response, texts};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::fields::Fields;
use crate::base::notes::Range;
use crate::base::units;
use crate::scene::common::MOST;

/// Error against run time, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AccuracyStudy {
    /// What is to be exact.
    pub of: Subject,
    /// The motion.
    pub motion: SimulateStudy,
    /// How many elastic modes are compared.
    pub lowest: Option<u32>,
    /// The responses.
    pub response: ResponseStudy,
    /// Only these methods; all that apply where empty.
    pub methods: Vec<String>,
    /// The error that is wanted in the end, relative.
    pub wanted: Option<f64>,
}

/// What a study of accuracy compares.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Subject {
    /// The motion in time.
    #[default]
    Motion,
    /// The lowest natural frequencies.
    Modes,
    /// Frequency responses.
    Response,
}

/// Reads its keys.
pub(super) fn accuracy(f: &mut Fields) -> AccuracyStudy {
    let words = [
        ("motion", Subject::Motion),
        ("modes", Subject::Modes),
        ("response", Subject::Response),
    ];
    let mut study = AccuracyStudy {
        of: f.choice("of", &words).unwrap_or_default(),
        wanted: f.optional_number("error", Range::Positive),
        ..AccuracyStudy::default()
    };
    match study.of {
        Subject::Motion => {
            study.motion = simulate(f);
            study.methods = texts(f, "methods");
        }
        Subject::Modes => study.lowest = f.optional_count("lowest", 1, MOST),
        Subject::Response => study.response = response::response(f),
    }
    study
}

/// Where methods and machine break, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StabilityStudy {
    /// The motion.
    pub motion: SimulateStudy,
    /// Only these methods; all that apply where empty.
    pub methods: Vec<String>,
    /// Speeds of a parametric stability chart.
    pub speeds: Option<SpeedRange>,
    /// What else the chart goes over.
    pub over: Option<Over>,
}

/// The second axis of a stability chart: factors on what the scene has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Over {
    /// What is changed.
    pub parameter: Parameter,
    /// The first factor.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// How many, both ends included.
    pub count: u32,
}

/// What a stability chart can go over beside speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// How far every stiffness wave goes from its mean.
    Depth,
    /// Every damping.
    Damping,
}

impl Parameter {
    /// The word for it in files.
    pub fn name(self) -> &'static str {
        match self {
            Parameter::Depth => "depth",
            Parameter::Damping => "damping",
        }
    }
}

impl Over {
    /// Reads `depth=A:B:N` or `damping=A:B:N`.
    pub fn parse(text: &str, subject: &str) -> Result<Over, Error> {
        const MOST_ROWS: u32 = 1000;
        let form = || {
            let message = format!(
                "\"{}\" is no second axis of a chart",
                units::shortened(text)
            );
            let hint = format!(
                "{subject} takes depth=first:last:rows or damping=first:last:rows, factors on what the scene has, such as depth=0:1:21"
            );
            Error::new(Code::OutOfRange, message).hint(hint)
        };
        let (name, range) = text.split_once('=').ok_or_else(form)?;
        let known = [Parameter::Depth, Parameter::Damping];
        let parameter = known.into_iter().find(|p| p.name() == name.trim());
        let parts: Vec<&str> = range.split(':').map(str::trim).collect();
        let [from, to, count] = parts[..] else {
            return Err(form());
        };
        let number = |text: &str| {
            text.parse::<f64>()
                .ok()
                .filter(|x| x.is_finite() && *x >= 0.0)
        };
        match (parameter, number(from), number(to), count.parse::<u32>()) {
            (Some(parameter), Some(from), Some(to), Ok(count))
                if from < to && (2..=MOST_ROWS).contains(&count) =>
            {
                Ok(Over {
                    parameter,
                    from,
                    to,
                    count,
                })
            }
            _ => Err(form()),
        }
    }

    /// The factors, rising.
    pub fn factors(self) -> impl Iterator<Item = f64> {
        let steps = f64::from(self.count - 1);
        (0..self.count).map(move |k| self.from + (self.to - self.from) * f64::from(k) / steps)
    }
}
