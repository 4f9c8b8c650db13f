//! Result of an identification by any method: modes, transfer functions and the evidence for them.

use super::frf_estimation::HitSummary;
use super::method::IdentificationMethod;
use super::mode_comparison::ModeComparison;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::quoted_list;
use crate::identify::modal::candidates::normalize_to_largest;
use crate::identify::modal::lsfd::ModeShape;
use crate::identify::modal::stabilisation::StabilisationPole;
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::operational::fdd::SdofBell;
use crate::identify::operational::harmonics::HarmonicIndicator;
use crate::identify::point_shape::{Displacement, point_displacements};
use crate::identify::rational::{ModelErrorShare, RationalFit};
use crate::identify::reciprocity::Reciprocity;
use crate::identify::series::model::ModelStructure;
use crate::identify::series::model_trajectory::{MemoryTrial, ModeTrack};
use crate::identify::series::order::OrderCandidate;
use crate::identify::series::residuals::ResidualTest;
use crate::identify::transfer::function::TransferFunction;
use crate::numeric::{Complex, ComplexMatrix};
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponses};
use crate::recording::geometry::Geometry;

/// Modes and transfer functions, and how they were had.
#[derive(Debug)]
pub struct IdentificationResult {
    /// Stages that ran, with seconds.
    pub trace: Vec<(&'static str, f64)>,
    /// The method.
    pub method: IdentificationMethod,
    /// Description of the data preparation, as text.
    pub method_text: String,
    /// Selection rule that separates modes from other poles, one sentence.
    pub selection_rule: String,
    /// Hits of an impact test.
    pub hits: Vec<HitSummary>,
    /// Channels of the mode shapes.
    pub outputs: Vec<ChannelLabel>,
    /// Channels of the participation: the inputs, where there are several.
    pub inputs: Vec<ChannelLabel>,
    /// Pairs of points that were driven both ways.
    pub reciprocity: Vec<Reciprocity>,
    /// Driving point that scales the modal masses.
    pub driving_point: Option<DrivingPoint>,
    /// The responses that were fitted; `None` where the method starts from signals.
    pub responses: Option<FrequencyResponses>,
    /// The band of the modes, Hz.
    pub band_hz: (f64, f64),
    /// Evidence for the modes; of the fit before any correction for an exponential window.
    pub evidence: Evidence,
    /// Modes by rising frequency, an exponential window taken off.
    pub modes: Vec<IdentifiedMode>,
    /// Weak modes, apart from them; empty with `IdentifyStudy::all`.
    pub weak: Vec<IdentifiedMode>,
    /// Harmonics of running speed, by rising frequency; sought where no excitation is measured.
    pub harmonics: Vec<IdentifiedHarmonic>,
    /// One transfer function for each response, the window taken off.
    pub functions: Vec<TransferFunction>,
    /// Root mean square misfit over that of the response, by response.
    pub fit_error: Vec<f64>,
    /// Shapes on points, where the geometry of the test is known.
    pub point_shapes: Option<PointShapes>,
    /// Comparison with other modes, where requested.
    pub comparison: Option<ModeComparison>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Shapes of the modes on the points of a test.
#[derive(Debug)]
pub struct PointShapes {
    /// Points, lines and channels.
    pub geometry: Geometry,
    /// Displacements of the points by mode; `None` of a point without a channel.
    pub displacements: Vec<Vec<Option<Displacement>>>,
}

impl IdentificationResult {
    /// Places the shapes on the points of a test, where the geometry places a response channel.
    ///
    /// # Errors
    /// A component that is not finite.
    pub fn place_shapes(&mut self, geometry: Geometry) -> Result<(), Error> {
        let places: Vec<_> = self
            .outputs
            .iter()
            .map(|o| geometry.place(&o.name))
            .collect();
        let placed: Vec<_> = places.iter().copied().flatten().collect();
        let missing = (self.outputs.iter().zip(&places)).filter(|(_, place)| place.is_none());
        let missing: Vec<&str> = missing.map(|(o, _)| o.name.as_str()).collect();
        if !geometry.is_empty() && !missing.is_empty() {
            self.diagnostics.push(Diagnostic {
                code: "channel-unplaced",
                message: format!(
                    "the geometry does not place {}",
                    quoted_list(missing.iter().copied())
                ),
                hint: Some("state point and direction of its [[channel]] in the sidecar".into()),
            });
        }
        if placed.is_empty() {
            return Ok(());
        }
        let n_outputs = self.outputs.len();
        let shape = |mode: &IdentifiedMode| {
            let all = mode.mode.shape.iter().zip(&places);
            let values: Vec<Complex> = match mode.mode.shape.len() == n_outputs {
                true => all.filter(|(_, p)| p.is_some()).map(|(z, _)| *z).collect(),
                false => vec![Complex::ZERO; placed.len()],
            };
            point_displacements(geometry.points.len(), &placed, &values)
        };
        let displacements = self.modes.iter().map(shape).collect::<Result<_, Error>>()?;
        self.point_shapes = Some(PointShapes {
            geometry,
            displacements,
        });
        Ok(())
    }
}

impl IdentificationResult {
    /// The rational fit, where that is the method.
    pub fn fit(&self) -> Option<&RationalFit> {
        match &self.evidence {
            Evidence::Rational(fit) => Some(fit),
            _ => None,
        }
    }

    /// Fitted responses at a frequency, Hz, with the exponential window that lay on the measured ones; empty without a fit.
    pub fn synthesise(&self, frequency_hz: f64) -> Vec<Complex> {
        match self.fit() {
            Some(fit) => fit.synthesise(frequency_hz),
            None => {
                let s = Complex::new(self.window_decay(), std::f64::consts::TAU * frequency_hz);
                self.functions.iter().map(|f| f.value(s)).collect()
            }
        }
    }

    /// Poles that are no modes, rad/s, and why.
    pub fn rejected_poles(&self) -> Vec<(Complex, &'static str)> {
        match &self.evidence {
            Evidence::Rational(fit) => fit.omitted.iter().map(|o| (o.pole, o.reason)).collect(),
            Evidence::Diagram(diagram) => diagram.omitted.clone(),
            Evidence::Orders(orders) => orders.omitted.iter().map(|o| (o.0.pole, o.1)).collect(),
            Evidence::Peaks(_) | Evidence::Tracking(_) => Vec::new(),
        }
    }

    /// Tracked modes over time, where the method follows them.
    pub fn tracking(&self) -> Option<&ModeTracking> {
        match &self.evidence {
            Evidence::Tracking(course) => Some(course),
            _ => None,
        }
    }

    /// Rate of the exponential window on the responses, 1/s.
    pub fn window_decay(&self) -> f64 {
        self.responses.as_ref().map_or(0.0, |r| r.window_decay)
    }
}

/// Driving point: a force and the motion measured along it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrivingPoint {
    /// Channel that drives.
    pub input: String,
    /// Response channel at the driving point.
    pub output: String,
    /// The unit of the modal masses: kg, or kg·m² where a torque drives.
    pub unit: &'static str,
}

/// A mode with what its method tells next to the pole.
#[derive(Debug, Clone)]
pub struct IdentifiedMode {
    /// Pole, covariance and shape.
    pub mode: ModalParameters,
    /// Modal participation of each input, the largest component 1; empty with one input.
    pub participation: Vec<Complex>,
    /// The method tells damping; without, the pole lies on the imaginary axis.
    pub has_damping: bool,
    /// Share of the orders in which it appears.
    pub presence: Option<f64>,
    /// Standard deviation of its frequency over the orders, Hz: an indication, no uncertainty.
    pub scatter_hz: Option<f64>,
    /// Departure from the linear model, where the method measures that.
    pub departure: Option<ModelErrorShare>,
    /// Why it is weak; `None` where it is not.
    pub weak: Option<&'static str>,
    /// Indicators that the mode is a harmonic of running speed.
    pub harmonic: Option<HarmonicIndicator>,
    /// The order of the running speed it lies on without being it.
    pub on_order: Option<f64>,
    /// Nominal frequency of the mains, Hz, and the multiple of it that the mode lies on, no wider than a line.
    pub on_mains: Option<(f64, usize)>,
    /// Modal mass, the largest component of the shape one, by the driving point; in its unit.
    pub modal_mass: Option<Complex>,
}

impl From<ModalParameters> for IdentifiedMode {
    fn from(mode: ModalParameters) -> IdentifiedMode {
        IdentifiedMode {
            mode,
            participation: Vec::new(),
            has_damping: true,
            presence: None,
            scatter_hz: None,
            departure: None,
            weak: None,
            harmonic: None,
            on_order: None,
            on_mains: None,
            modal_mass: None,
        }
    }
}

impl IdentifiedMode {
    /// Takes over shape, and participation where there are several inputs.
    pub fn set_shape(&mut self, found: ModeShape) {
        self.mode.shape = found.shape;
        if found.participation.len() > 1 {
            self.participation = normalize_to_largest(found.participation);
        }
    }

    /// A mode over outputs and inputs from one whose shape is over the functions of a table.
    ///
    /// # Errors
    /// Those of the decomposition.
    pub fn mode_over_table(
        mode: ModalParameters,
        table: &[Vec<usize>],
    ) -> Result<IdentifiedMode, Error> {
        let residues =
            ComplexMatrix::from_fn(table.len(), table[0].len(), |o, i| mode.shape[table[o][i]]);
        let mut found = IdentifiedMode::from(mode);
        found.set_shape(ModeShape::from_residues(&residues)?);
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

    /// Converts to a harmonic where the pole is nearer to a line of running speed than to a mode.
    fn to_harmonic(&self) -> Option<IdentifiedHarmonic> {
        let is_one = self
            .harmonic
            .as_ref()
            .is_some_and(HarmonicIndicator::is_harmonic);
        is_one.then(|| self.listed_as_harmonic("distributed like a sine"))
    }

    /// The pole as a line that is no resonance, for a reason.
    pub fn listed_as_harmonic(&self, reason: &'static str) -> IdentifiedHarmonic {
        IdentifiedHarmonic {
            frequency_hz: self.frequency_hz(),
            order: self.harmonic.as_ref().and_then(|h| h.order),
            amplitude: Vec::new(),
            probability: None,
            envelope_kurtosis: self.harmonic.as_ref().map(|h| h.envelope_kurtosis),
            reason,
        }
    }
}

/// A line of running speed, or of anything that is no resonance.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedHarmonic {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// The order of the stated speed it lies on.
    pub order: Option<f64>,
    /// 0 to peak by output, of a sine that was found and taken out before modes were looked for; empty for a pole.
    pub amplitude: Vec<f64>,
    /// Probability that noise alone shows such a sine anywhere.
    pub probability: Option<f64>,
    /// Kurtosis of a pole's band envelope: 2 for noise, 1 for a sine.
    pub envelope_kurtosis: Option<f64>,
    /// Why it is no mode, where it lies on no order.
    pub reason: &'static str,
}

impl IdentifiedHarmonic {
    /// The reason of a line of the mains.
    pub const MAINS: &str = "mains";
}

/// Modes, and apart from them what is a line of running speed.
pub fn split_harmonics(all: Vec<IdentifiedMode>) -> (Vec<IdentifiedMode>, Vec<IdentifiedHarmonic>) {
    let mut modes = Vec::new();
    let mut harmonics = Vec::new();
    for mode in all {
        match mode.to_harmonic() {
            Some(harmonic) => harmonics.push(harmonic),
            None => modes.push(mode),
        }
    }
    (modes, harmonics)
}

/// Result of a method that starts from signals.
pub struct SignalIdentification {
    /// Modes.
    pub modes: Vec<IdentifiedMode>,
    /// Weak modes, apart from them; none by the methods of one output.
    pub weak: Vec<IdentifiedMode>,
    /// Lines of running speed.
    pub harmonics: Vec<IdentifiedHarmonic>,
    /// Selection rule that separates modes from other poles.
    pub selection_rule: String,
    /// Poles of all orders, peaks, orders tried, or the tracked modes.
    pub evidence: Evidence,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Evidence for the modes.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "one of them per response")]
pub enum Evidence {
    /// The fit, with every number of poles that was tried.
    Rational(RationalFit),
    /// Poles of all orders.
    Diagram(StabilisationDiagram),
    /// Peaks that were looked at one by one.
    Peaks(PeakPicking),
    /// Orders that were tried.
    Orders(OrderSelection),
    /// Modes that change.
    Tracking(ModeTracking),
}

/// A stabilisation diagram.
#[derive(Debug, Default)]
pub struct StabilisationDiagram {
    /// Poles by order, then frequency.
    pub poles: Vec<StabilisationPole>,
    /// Lines, Hz, and a level over them that peaks at modes.
    pub level: (Vec<f64>, Vec<f64>),
    /// Poles chosen from it, rad/s, that turned out to be no modes, and why.
    pub omitted: Vec<(Complex, &'static str)>,
}

/// Peaks, and the noise level under them.
#[derive(Debug, Default)]
pub struct PeakPicking {
    /// One for each peak.
    pub peaks: Vec<PickedPeak>,
    /// Lines, Hz, and the level.
    pub level: (Vec<f64>, Vec<f64>),
    /// Further levels over the same lines: the singular values below the largest.
    pub below: Vec<Vec<f64>>,
}

/// A peak of an output spectrum, with its estimate of a mode.
#[derive(Debug, Clone, Default)]
pub struct PickedPeak {
    /// Frequency of the peak, Hz.
    pub frequency_hz: f64,
    /// Power of the peak over that of the higher valley next to it.
    pub prominence: Option<f64>,
    /// Natural frequency, Hz, and damping ratio by half power.
    pub half_power: Option<(f64, f64)>,
    /// Lines about the peak with its shape, and their decay, where damping is identified from these.
    pub bell: Option<SdofBell>,
    /// Why it is not reported as a mode; empty where it is.
    pub reason: String,
}

/// Orders of difference equations, and what the residuals of the chosen one tell.
#[derive(Debug)]
pub struct OrderSelection {
    /// The order taken.
    pub chosen: ModelStructure,
    /// All that were tried, the output without any model first.
    pub candidates: Vec<OrderCandidate>,
    /// Roots inside the band that are no modes, and why.
    pub omitted: Vec<(ModalParameters, &'static str)>,
    /// Tests of the residuals: what was tested, and how often chance gives as much.
    pub tests: Vec<(&'static str, ResidualTest)>,
}

/// Modes over the time of the record.
#[derive(Debug)]
pub struct ModeTracking {
    /// Seconds from the first sample at which the model was looked at.
    pub time_s: Vec<f64>,
    /// Modes over these instants: those that begin first, then by frequency.
    pub tracks: Vec<ModeTrack>,
    /// Orders and memories that were tried.
    pub trials: Vec<MemoryTrial>,
    /// The one taken.
    pub chosen: MemoryTrial,
    /// Samples a second.
    pub rate_hz: f64,
}

impl ModeTracking {
    /// The memory of a trial, s; `None` where nothing is forgotten.
    pub fn memory_s(&self, trial: &MemoryTrial) -> Option<f64> {
        (trial.memory.is_finite()).then(|| trial.memory / self.rate_hz)
    }
}
