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

/// Identified modes and transfer functions with their evidence and diagnostics.
#[derive(Debug)]
pub struct IdentificationResult {
    /// Completed stages with their run times, s.
    pub trace: Vec<(&'static str, f64)>,
    /// Identification method.
    pub method: IdentificationMethod,
    /// Description of the data preparation, as text.
    pub method_text: String,
    /// Selection rule that separates modes from other poles, one sentence.
    pub selection_rule: String,
    /// Hits of the impact test.
    pub hits: Vec<HitSummary>,
    /// Output channels, the components of the mode shapes.
    pub outputs: Vec<ChannelLabel>,
    /// Input channels, the components of the modal participation; empty with a single input.
    pub inputs: Vec<ChannelLabel>,
    /// Reciprocity of the pairs of points excited in both directions.
    pub reciprocity: Vec<Reciprocity>,
    /// Driving point that scales the modal masses; `None` without one.
    pub driving_point: Option<DrivingPoint>,
    /// Fitted frequency responses; `None` for a method that starts from signals.
    pub responses: Option<FrequencyResponses>,
    /// Frequency band of the modes, Hz.
    pub band_hz: (f64, f64),
    /// Evidence for the modes, before correction for an exponential window.
    pub evidence: Evidence,
    /// Modes by ascending frequency, corrected for an exponential window.
    pub modes: Vec<IdentifiedMode>,
    /// Weak modes; empty with `IdentifyStudy::all`.
    pub weak: Vec<IdentifiedMode>,
    /// Harmonics of running speed by ascending frequency, for operational methods.
    pub harmonics: Vec<IdentifiedHarmonic>,
    /// Transfer function of each response, corrected for an exponential window.
    pub functions: Vec<TransferFunction>,
    /// Relative root-mean-square misfit of each response.
    pub fit_error: Vec<f64>,
    /// Mode shapes at the points of the geometry, if known.
    pub point_shapes: Option<PointShapes>,
    /// Comparison with other modes, if requested.
    pub comparison: Option<ModeComparison>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Mode shapes at the points of a test geometry.
#[derive(Debug)]
pub struct PointShapes {
    /// Points, lines and channels.
    pub geometry: Geometry,
    /// Point displacements of each mode; `None` for a point without a channel.
    pub displacements: Vec<Vec<Option<Displacement>>>,
}

impl IdentificationResult {
    /// Assigns the mode shapes to the points of a test geometry by the response channels.
    ///
    /// # Errors
    /// A shape component that is not finite.
    pub fn assign_points(&mut self, geometry: Geometry) -> Result<(), Error> {
        let points: Vec<_> = self
            .outputs
            .iter()
            .map(|o| geometry.place(&o.name))
            .collect();
        let known: Vec<_> = points.iter().copied().flatten().collect();
        let missing = (self.outputs.iter().zip(&points)).filter(|(_, point)| point.is_none());
        let missing: Vec<&str> = missing.map(|(o, _)| o.name.as_str()).collect();
        if !geometry.is_empty() && !missing.is_empty() {
            self.diagnostics.push(Diagnostic {
                code: "channel-unplaced",
                message: format!(
                    "the geometry has no position of {}",
                    quoted_list(missing.iter().copied())
                ),
                hint: Some("state point and direction of its [[channel]] in the sidecar".into()),
            });
        }
        if known.is_empty() {
            return Ok(());
        }
        let n_outputs = self.outputs.len();
        let shape = |mode: &IdentifiedMode| {
            let all = mode.mode.shape.iter().zip(&points);
            let values: Vec<Complex> = match mode.mode.shape.len() == n_outputs {
                true => all.filter(|(_, p)| p.is_some()).map(|(z, _)| *z).collect(),
                false => vec![Complex::ZERO; known.len()],
            };
            point_displacements(geometry.points.len(), &known, &values)
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
    /// Rational fit of the responses; `None` for other methods.
    pub fn fit(&self) -> Option<&RationalFit> {
        match &self.evidence {
            Evidence::Rational(fit) => Some(fit),
            _ => None,
        }
    }

    /// Synthesised responses at a frequency, Hz, including the exponential window of the measurement; empty without a fit.
    pub fn synthesise(&self, frequency_hz: f64) -> Vec<Complex> {
        match self.fit() {
            Some(fit) => fit.synthesise(frequency_hz),
            None => {
                let s = Complex::new(self.window_decay(), std::f64::consts::TAU * frequency_hz);
                self.functions.iter().map(|f| f.value(s)).collect()
            }
        }
    }

    /// Rejected poles, rad/s, with the reason.
    pub fn rejected_poles(&self) -> Vec<(Complex, &'static str)> {
        match &self.evidence {
            Evidence::Rational(fit) => fit.omitted.iter().map(|o| (o.pole, o.reason)).collect(),
            Evidence::Diagram(diagram) => diagram.omitted.clone(),
            Evidence::Orders(orders) => orders.omitted.iter().map(|o| (o.0.pole, o.1)).collect(),
            Evidence::Peaks(_) | Evidence::Tracking(_) => Vec::new(),
        }
    }

    /// Tracked modes over time; `None` for other methods.
    pub fn tracking(&self) -> Option<&ModeTracking> {
        match &self.evidence {
            Evidence::Tracking(tracking) => Some(tracking),
            _ => None,
        }
    }

    /// Decay rate of the exponential window of the responses, 1/s.
    pub fn window_decay(&self) -> f64 {
        self.responses.as_ref().map_or(0.0, |r| r.window_decay)
    }
}

/// Driving point: excitation and response at one point in one direction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrivingPoint {
    /// Excitation channel.
    pub input: String,
    /// Response channel at the driving point.
    pub output: String,
    /// Unit of the modal masses: kg, or kg·m² for an excitation torque.
    pub unit: &'static str,
}

/// Identified mode: modal parameters, participation and quality indicators.
#[derive(Debug, Clone)]
pub struct IdentifiedMode {
    /// Pole, covariance and shape.
    pub mode: ModalParameters,
    /// Modal participation vector over the inputs, largest component 1; empty with one input.
    pub participation: Vec<Complex>,
    /// True if the method identifies damping; if not, the pole is on the imaginary axis.
    pub has_damping: bool,
    /// Presence: share of the model orders with the mode.
    pub presence: Option<f64>,
    /// Scatter of the frequency over the model orders, standard deviation, Hz; not an uncertainty.
    pub scatter_hz: Option<f64>,
    /// Departure from the linear model, if the method measures it.
    pub departure: Option<ModelErrorShare>,
    /// Reason of a weak mode.
    pub weak: Option<&'static str>,
    /// Indicators that the mode is a harmonic of running speed.
    pub harmonic: Option<HarmonicIndicator>,
    /// Order of the running speed that coincides with the mode.
    pub on_order: Option<f64>,
    /// Mains frequency, Hz, and its multiple that coincides with a mode no wider than a line.
    pub on_mains: Option<(f64, usize)>,
    /// Modal mass for a largest shape component of 1, in the unit of the driving point.
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
    /// Sets the shape, and the participation for several inputs.
    pub fn set_shape(&mut self, decomposed: ModeShape) {
        self.mode.shape = decomposed.shape;
        if decomposed.participation.len() > 1 {
            self.participation = normalize_to_largest(decomposed.participation);
        }
    }

    /// Decomposes a mode with a shape over the responses of `table` into shape and participation.
    ///
    /// # Errors
    /// Errors of the singular value decomposition.
    pub fn mode_over_table(
        mode: ModalParameters,
        table: &[Vec<usize>],
    ) -> Result<IdentifiedMode, Error> {
        let residues =
            ComplexMatrix::from_fn(table.len(), table[0].len(), |o, i| mode.shape[table[o][i]]);
        let mut identified = IdentifiedMode::from(mode);
        identified.set_shape(ModeShape::from_residues(&residues)?);
        Ok(identified)
    }

    /// Natural frequency, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.mode.frequency_hz()
    }

    /// Damping ratio, if the method identifies damping.
    pub fn damping_ratio(&self) -> Option<f64> {
        self.has_damping.then(|| self.mode.damping_ratio())
    }

    /// Harmonic of running speed, if the indicator classifies the pole as one.
    fn to_harmonic(&self) -> Option<IdentifiedHarmonic> {
        let is_harmonic = self
            .harmonic
            .as_ref()
            .is_some_and(HarmonicIndicator::is_harmonic);
        is_harmonic.then(|| self.listed_as_harmonic("distributed like a sine"))
    }

    /// Harmonic at the pole, with the reason.
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

/// Spectral line of running speed or of another periodic source.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedHarmonic {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Order of the stated speed at the line.
    pub order: Option<f64>,
    /// Amplitude of each output, 0 to peak, of a sine removed before the identification; empty for a pole.
    pub amplitude: Vec<f64>,
    /// False-alarm probability of such a sine in noise.
    pub probability: Option<f64>,
    /// Kurtosis of the band envelope at a pole: 2 for noise, 1 for a sine.
    pub envelope_kurtosis: Option<f64>,
    /// Reason for the rejection as a mode, for a line without order.
    pub reason: &'static str,
}

impl IdentifiedHarmonic {
    /// Reason of a mains line.
    pub const MAINS: &str = "mains";
}

/// Splits poles into modes and harmonics of running speed.
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
    /// Weak modes; empty for the methods of one output.
    pub weak: Vec<IdentifiedMode>,
    /// Harmonics of running speed.
    pub harmonics: Vec<IdentifiedHarmonic>,
    /// Selection rule that separates modes from other poles.
    pub selection_rule: String,
    /// Stabilisation diagram, peaks, model orders or tracked modes.
    pub evidence: Evidence,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Evidence for the modes, by method.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "one of them per response")]
pub enum Evidence {
    /// Rational fit with all trial orders.
    Rational(RationalFit),
    /// Stabilisation diagram.
    Diagram(StabilisationDiagram),
    /// Peak picking.
    Peaks(PeakPicking),
    /// Trial model orders.
    Orders(OrderSelection),
    /// Tracked modes.
    Tracking(ModeTracking),
}

/// Stabilisation diagram: poles over model order, with a mode indicator.
#[derive(Debug, Default)]
pub struct StabilisationDiagram {
    /// Poles, by order, then by frequency.
    pub poles: Vec<StabilisationPole>,
    /// Mode indicator function: lines, Hz, and level.
    pub level: (Vec<f64>, Vec<f64>),
    /// Rejected poles, rad/s, with the reason.
    pub omitted: Vec<(Complex, &'static str)>,
}

/// Peak picking: peaks and spectrum levels.
#[derive(Debug, Default)]
pub struct PeakPicking {
    /// Picked peaks.
    pub peaks: Vec<PickedPeak>,
    /// Lines, Hz, and spectrum level.
    pub level: (Vec<f64>, Vec<f64>),
    /// Levels of the further singular values at these lines.
    pub below: Vec<Vec<f64>>,
}

/// Peak of an output spectrum with its modal estimates.
#[derive(Debug, Clone, Default)]
pub struct PickedPeak {
    /// Frequency of the peak, Hz.
    pub frequency_hz: f64,
    /// Prominence: power of the peak over the higher of the adjacent valleys.
    pub prominence: Option<f64>,
    /// Natural frequency, Hz, and damping ratio by half power.
    pub half_power: Option<(f64, f64)>,
    /// SDOF bell of enhanced frequency-domain decomposition, for identified damping.
    pub bell: Option<SdofBell>,
    /// Reason for the rejection as a mode; empty for a mode.
    pub reason: String,
}

/// Order selection of a difference equation, with residual tests of the chosen order.
#[derive(Debug)]
pub struct OrderSelection {
    /// Chosen model structure.
    pub chosen: ModelStructure,
    /// Trial structures, first the output without a model.
    pub candidates: Vec<OrderCandidate>,
    /// Rejected poles within the band, with the reason.
    pub omitted: Vec<(ModalParameters, &'static str)>,
    /// Residual tests: name, and statistic with its probability.
    pub tests: Vec<(&'static str, ResidualTest)>,
}

/// Tracking of modes over the time of the record.
#[derive(Debug)]
pub struct ModeTracking {
    /// Evaluation times from the first sample, s.
    pub time_s: Vec<f64>,
    /// Mode tracks over these times, by start, then by frequency.
    pub tracks: Vec<ModeTrack>,
    /// Trial orders and memories.
    pub trials: Vec<MemoryTrial>,
    /// Chosen trial.
    pub chosen: MemoryTrial,
    /// Sample rate, Hz.
    pub rate_hz: f64,
}

impl ModeTracking {
    /// Memory of a trial, s; `None` for an infinite memory.
    pub fn memory_s(&self, trial: &MemoryTrial) -> Option<f64> {
        (trial.memory.is_finite()).then(|| trial.memory / self.rate_hz)
    }
}
