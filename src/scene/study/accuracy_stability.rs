//! Options of accuracy and stability studies.

use super::{ReadStudy, ResponseStudy, SimulateStudy, SpeedRange, Study};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::flags::Flags;
use crate::base::quantity;
use crate::base::table_reader::{TableReader, Word};
use crate::scene::Scene;
use crate::scene::shared_keys::MAX_COUNT;

/// Error against run time, as the command has it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AccuracyStudy {
    /// Target of the accuracy comparison.
    pub target: AccuracyTarget,
    /// The motion.
    pub motion: SimulateStudy,
    /// Number of elastic modes compared.
    pub lowest: Option<u32>,
    /// The responses.
    pub response: ResponseStudy,
    /// Only these methods; all that apply where empty.
    pub methods: Vec<String>,
    /// The error that is target in the end, relative.
    pub target_error: Option<f64>,
}

/// Quantity compared by a study of accuracy.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum AccuracyTarget {
    /// The motion in time.
    #[default]
    Motion,
    /// The lowest natural frequencies.
    Modes,
    /// Frequency responses.
    Response,
}

impl Word for AccuracyTarget {
    const WORDS: &'static [(&'static str, AccuracyTarget, &'static str)] = &[
        ("motion", AccuracyTarget::Motion, "The motion in time"),
        (
            "modes",
            AccuracyTarget::Modes,
            "The lowest natural frequencies",
        ),
        ("response", AccuracyTarget::Response, "Frequency responses"),
    ];
}

impl ReadStudy for AccuracyStudy {
    const KIND: &'static str = "accuracy";

    fn read(f: &mut TableReader) -> AccuracyStudy {
        let mut study = AccuracyStudy {
            target: f.word("of").unwrap_or_default(),
            target_error: f.optional_number("error", ValueRange::Positive),
            ..AccuracyStudy::default()
        };
        match study.target {
            AccuracyTarget::Motion => {
                study.motion = SimulateStudy::read_motion(f);
                study.methods = f.texts("methods");
            }
            AccuracyTarget::Modes => study.lowest = f.optional_count("lowest", 1, MAX_COUNT),
            AccuracyTarget::Response => study.response = ResponseStudy::read(f),
        }
        study
    }

    /// A study of the same target; of the motion also the motion that the scene lists.
    fn listed<'s>(scene: &'s Scene, flags: &Flags) -> Option<&'s Study> {
        let own = scene.listed(Self::KIND);
        let of = |study: &'s Study| study.text("of").unwrap_or("motion");
        let target = flags.text("of").or(own.map(of)).unwrap_or("motion");
        let motion = scene.listed(SimulateStudy::KIND).filter(|_| own.is_none());
        own.or(motion).filter(|study| of(study) == target)
    }
}

/// Study of the stability limits of methods and machine, with the options of the command.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StabilityStudy {
    /// The motion.
    pub motion: SimulateStudy,
    /// Only these methods; all that apply where empty.
    pub methods: Vec<String>,
    /// Speeds of a parametric stability chart.
    pub speeds: Option<SpeedRange>,
    /// Second parameter of the chart.
    pub over: Option<ParameterSweep>,
}

impl ReadStudy for StabilityStudy {
    const KIND: &'static str = "stability";

    fn read(f: &mut TableReader) -> StabilityStudy {
        let study = StabilityStudy {
            motion: SimulateStudy::read_motion(f),
            methods: f.texts("methods"),
            speeds: f.parsed("speeds", SpeedRange::parse),
            over: f.parsed("over", ParameterSweep::parse),
        };
        f.requires("over", "speeds");
        study
    }

    /// A study of stability, else the motion that the scene lists.
    fn listed<'s>(scene: &'s Scene, _flags: &Flags) -> Option<&'s Study> {
        let motion = || scene.listed(SimulateStudy::KIND);
        scene.listed(Self::KIND).or_else(motion)
    }
}

/// The second axis of a stability chart: factors on what the scene has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSweep {
    /// Swept parameter.
    pub parameter: SweepParameter,
    /// The first factor.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// Number of values, both ends included.
    pub count: u32,
}

/// Second parameter of a stability chart, next to speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SweepParameter {
    /// Modulation depth of every stiffness wave about its mean.
    Depth,
    /// Every damping.
    Damping,
}

impl SweepParameter {
    /// The word for it in files.
    pub fn name(self) -> &'static str {
        match self {
            SweepParameter::Depth => "depth",
            SweepParameter::Damping => "damping",
        }
    }
}

impl ParameterSweep {
    /// Reads `depth=A:B:N` or `damping=A:B:N`.
    pub fn parse(text: &str, subject: &str) -> Result<ParameterSweep, Error> {
        const MAX_ROWS: u32 = 1000;
        let form = || {
            let message = format!(
                "\"{}\" is not a second axis of a chart",
                quantity::truncate(text)
            );
            let hint = format!(
                "{subject} takes depth=first:last:rows or damping=first:last:rows, factors of the values of the scene, such as depth=0:1:21"
            );
            Error::new(Code::OutOfRange, message).with_hint(hint)
        };
        let (name, range) = text.split_once('=').ok_or_else(form)?;
        let known = [SweepParameter::Depth, SweepParameter::Damping];
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
                if from < to && (2..=MAX_ROWS).contains(&count) =>
            {
                Ok(ParameterSweep {
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
