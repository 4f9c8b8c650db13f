//! What an identification answers, whatever the method: modes, and what they rest on.

use super::acquire::FoundHit;
use super::method::Method;
use super::reciprocity::Reciprocity;
use crate::base::error::{Error, Warning};
use crate::identify::modal::candidates::unit_largest;
use crate::identify::modal::lsfd::ModeShape;
use crate::identify::modal::stabilisation::DiagramPole;
use crate::identify::mode::IdentifiedMode;
use crate::identify::operational::decomposition::Bell;
use crate::identify::operational::harmonics::Harmonic;
use crate::identify::rational::{Departure, RationalFit};
use crate::identify::series::course::{Track, Trial};
use crate::identify::series::model::Family;
use crate::identify::series::order::Candidate;
use crate::identify::series::residuals::Test;
use crate::identify::transfer::function::TransferFunction;
use crate::numeric::{Complex, ComplexMatrix};
use crate::recording::responses::{FrequencyResponses, Terminal};

/// Modes and transfer functions, and how they were had.
#[derive(Debug)]
pub struct Identification {
    /// Stages that ran, with seconds.
    pub trace: Vec<(&'static str, f64)>,
    /// The method.
    pub method: Method,
    /// How the data were prepared, in words.
    pub how: String,
    /// How modes were told from other poles, one sentence.
    pub rule: String,
    /// Hits of an impact test.
    pub hits: Vec<FoundHit>,
    /// What shapes are over.
    pub outputs: Vec<Terminal>,
    /// What participation is over: the inputs, where there are several.
    pub inputs: Vec<Terminal>,
    /// Pairs of points that were driven both ways.
    pub reciprocity: Vec<Reciprocity>,
    /// What modal masses come from.
    pub driving_point: Option<DrivingPoint>,
    /// The responses that were fitted; `None` where the method starts from signals.
    pub responses: Option<FrequencyResponses>,
    /// The band of the modes, Hz.
    pub band_hz: (f64, f64),
    /// What the modes rest on; of a fit as it came out, an exponential window still on it.
    pub evidence: Evidence,
    /// Modes by rising frequency, an exponential window taken off.
    pub modes: Vec<FoundMode>,
    /// Weak modes, apart from them; empty with `IdentifyStudy::all`.
    pub weak: Vec<FoundMode>,
    /// What looks like running speed, by rising frequency; looked for where nothing measured drives.
    pub harmonics: Vec<FoundHarmonic>,
    /// One transfer function for each response, the window taken off.
    pub functions: Vec<TransferFunction>,
    /// Root mean square misfit over that of the response, by response.
    pub fit_error: Vec<f64>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

impl Identification {
    /// The rational fit, where that is the method.
    pub fn fit(&self) -> Option<&RationalFit> {
        match &self.evidence {
            Evidence::Rational(fit) => Some(fit),
            _ => None,
        }
    }

    /// Fitted responses at a frequency, Hz, with the exponential window that lay on the measured ones; empty without a fit.
    pub fn fitted(&self, frequency_hz: f64) -> Vec<Complex> {
        match self.fit() {
            Some(fit) => fit.synthesise(frequency_hz),
            None => {
                let s = Complex::new(self.window_decay(), std::f64::consts::TAU * frequency_hz);
                self.functions.iter().map(|f| f.value(s)).collect()
            }
        }
    }

    /// Poles that are no modes, rad/s, and why.
    pub fn omitted(&self) -> Vec<(Complex, &'static str)> {
        match &self.evidence {
            Evidence::Rational(fit) => fit.omitted.iter().map(|o| (o.pole, o.reason)).collect(),
            Evidence::Diagram(diagram) => diagram.omitted.clone(),
            Evidence::Orders(orders) => orders.omitted.iter().map(|o| (o.0.pole, o.1)).collect(),
            Evidence::Peaks(_) | Evidence::Course(_) => Vec::new(),
        }
    }

    /// The course of the modes, where the method follows them.
    pub fn course(&self) -> Option<&ModeCourse> {
        match &self.evidence {
            Evidence::Course(course) => Some(course),
            _ => None,
        }
    }

    /// Rate of the exponential window on the responses, 1/s.
    pub fn window_decay(&self) -> f64 {
        self.responses.as_ref().map_or(0.0, |r| r.window_decay)
    }
}

/// Where a force acts and the motion along it was measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrivingPoint {
    /// Channel that drives.
    pub input: String,
    /// Channel that answers there.
    pub output: String,
    /// The unit of the modal masses: kg, or kg·m² where a torque drives.
    pub unit: &'static str,
}

/// A mode with what its method tells beside the pole.
#[derive(Debug, Clone)]
pub struct FoundMode {
    /// Pole, covariance and shape.
    pub mode: IdentifiedMode,
    /// How each input drives it, the largest component 1; empty with one input.
    pub participation: Vec<Complex>,
    /// The method tells damping; without, the pole lies on the imaginary axis.
    pub has_damping: bool,
    /// Share of the orders in which it appears.
    pub presence: Option<f64>,
    /// Standard deviation of its frequency over the orders, Hz: an indication, no uncertainty.
    pub scatter_hz: Option<f64>,
    /// How far it departs from the linear model, where the method measures that.
    pub departure: Option<Departure>,
    /// Why it is weak; `None` where it is not.
    pub weak: Option<&'static str>,
    /// What it shows of being a line of running speed.
    pub harmonic: Option<Harmonic>,
    /// The order of the running speed it lies on without being it.
    pub on_order: Option<f64>,
    /// Modal mass, the largest component of the shape one, by the driving point; in its unit.
    pub modal_mass: Option<Complex>,
}

impl From<IdentifiedMode> for FoundMode {
    fn from(mode: IdentifiedMode) -> FoundMode {
        FoundMode {
            mode,
            participation: Vec::new(),
            has_damping: true,
            presence: None,
            scatter_hz: None,
            departure: None,
            weak: None,
            harmonic: None,
            on_order: None,
            modal_mass: None,
        }
    }
}

impl FoundMode {
    /// Takes over shape, and participation where there are several inputs.
    pub fn take_shape(&mut self, found: ModeShape) {
        self.mode.shape = found.shape;
        if found.participation.len() > 1 {
            self.participation = unit_largest(found.participation);
        }
    }

    /// A mode over outputs and inputs from one whose shape is over the functions of a table.
    ///
    /// # Errors
    /// Those of the decomposition.
    pub fn of_table(mode: IdentifiedMode, table: &[Vec<usize>]) -> Result<FoundMode, Error> {
        let residues =
            ComplexMatrix::from_fn(table.len(), table[0].len(), |o, i| mode.shape[table[o][i]]);
        let mut found = FoundMode::from(mode);
        found.take_shape(ModeShape::of(&residues)?);
        Ok(found)
    }

    /// Natural frequency, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.mode.frequency_hz()
    }

    /// Damping ratio, where the method tells it.
    pub fn damping_ratio(&self) -> Option<f64> {
        self.has_damping.then(|| self.mode.damping_ratio())
    }

    /// What it is where it is nearer to a line of running speed than to a mode.
    fn as_harmonic(&self) -> Option<FoundHarmonic> {
        let is_one = self.harmonic.as_ref().is_some_and(Harmonic::is_harmonic);
        is_one.then(|| self.listed_as_harmonic())
    }

    /// The pole as a line of running speed.
    pub fn listed_as_harmonic(&self) -> FoundHarmonic {
        FoundHarmonic {
            frequency_hz: self.frequency_hz(),
            order: self.harmonic.as_ref().and_then(|h| h.order),
            amplitude: Vec::new(),
            probability: None,
            envelope_kurtosis: self.harmonic.as_ref().map(|h| h.envelope_kurtosis),
        }
    }
}

/// A line of running speed, or of anything that is no resonance.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundHarmonic {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// The order of the stated speed it lies on.
    pub order: Option<f64>,
    /// 0 to peak by output, of a sine that was found and taken out before modes were looked for; empty for a pole.
    pub amplitude: Vec<f64>,
    /// How probably noise alone shows such a sine anywhere.
    pub probability: Option<f64>,
    /// Of a pole, what its band is distributed like: 2 for noise, 1 for a sine.
    pub envelope_kurtosis: Option<f64>,
}

/// Modes, and apart from them what is a line of running speed.
pub fn apart(all: Vec<FoundMode>) -> (Vec<FoundMode>, Vec<FoundHarmonic>) {
    let mut modes = Vec::new();
    let mut harmonics = Vec::new();
    for mode in all {
        match mode.as_harmonic() {
            Some(harmonic) => harmonics.push(harmonic),
            None => modes.push(mode),
        }
    }
    (modes, harmonics)
}

/// What a method that starts from signals answers.
pub struct FromSignals {
    /// Modes.
    pub modes: Vec<FoundMode>,
    /// Lines of running speed.
    pub harmonics: Vec<FoundHarmonic>,
    /// How they were told from other poles.
    pub rule: String,
    /// Poles of all orders, peaks, orders tried, or the course of the modes.
    pub evidence: Evidence,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// What modes rest on.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "one of them per answer")]
pub enum Evidence {
    /// The fit, with every number of poles that was tried.
    Rational(RationalFit),
    /// Poles of all orders.
    Diagram(Diagram),
    /// Peaks that were looked at one by one.
    Peaks(Peaks),
    /// Orders that were tried.
    Orders(Orders),
    /// Modes that change.
    Course(ModeCourse),
}

/// A stabilisation diagram.
#[derive(Debug, Default)]
pub struct Diagram {
    /// Poles by order, then frequency.
    pub poles: Vec<DiagramPole>,
    /// Lines, Hz, and a level over them that peaks at modes.
    pub level: (Vec<f64>, Vec<f64>),
    /// Poles chosen from it, rad/s, that turned out to be no modes, and why.
    pub omitted: Vec<(Complex, &'static str)>,
}

/// Peaks, and the level they stand on.
#[derive(Debug, Default)]
pub struct Peaks {
    /// One for each peak.
    pub peaks: Vec<Peak>,
    /// Lines, Hz, and the level.
    pub level: (Vec<f64>, Vec<f64>),
    /// Further levels over the same lines: the singular values below the largest.
    pub below: Vec<Vec<f64>>,
}

/// A peak.
#[derive(Debug, Clone, Default)]
pub struct Peak {
    /// Where it stands, Hz.
    pub frequency_hz: f64,
    /// Its power over that of the higher valley beside it.
    pub prominence: Option<f64>,
    /// Natural frequency, Hz, and damping ratio by half power.
    pub half_power: Option<(f64, f64)>,
    /// The lines about it with its shape, and their decay, where damping is told from these.
    pub bell: Option<Bell>,
    /// Why it is not reported as a mode; empty where it is.
    pub reason: String,
}

/// Orders of difference equations, and what the residuals of the chosen one tell.
#[derive(Debug)]
pub struct Orders {
    /// The order taken.
    pub chosen: Family,
    /// All that were tried, the output without any model first.
    pub candidates: Vec<Candidate>,
    /// Roots inside the band that are no modes, and why.
    pub omitted: Vec<(IdentifiedMode, &'static str)>,
    /// Tests of the residuals: what was tested, and how often chance gives as much.
    pub tests: Vec<(&'static str, Test)>,
}

/// Modes in the course of the record.
#[derive(Debug)]
pub struct ModeCourse {
    /// Seconds from the first sample at which the model was looked at.
    pub time_s: Vec<f64>,
    /// Modes over these instants: those that begin first, then by frequency.
    pub tracks: Vec<Track>,
    /// Orders and memories that were tried.
    pub tried: Vec<Trial>,
    /// The one taken.
    pub taken: Trial,
    /// Samples a second.
    pub rate_hz: f64,
}

impl ModeCourse {
    /// The memory of a trial, s; `None` where nothing is forgotten.
    pub fn memory_s(&self, trial: &Trial) -> Option<f64> {
        (trial.memory.is_finite()).then(|| trial.memory / self.rate_hz)
    }
}
