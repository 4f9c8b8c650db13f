//! Identification study: channels, band, method and options; `None`: chosen from the data.

use super::frf_estimation::FrfStudy;
use super::method::IdentificationMethod;
use crate::identify::rational::DelayModel;

/// Request for the identification of a log.
#[derive(Debug, Clone, Default)]
pub struct IdentifyStudy {
    /// Channels that drive.
    pub inputs: Vec<String>,
    /// Response channels.
    pub outputs: Vec<String>,
    /// Options for the estimation of responses.
    pub estimate: FrfStudy,
    /// Lines used, Hz.
    pub band_hz: Option<(f64, f64)>,
    /// Pole pairs; as many as are significant where `None`.
    pub order: Option<usize>,
    /// A delay to be estimated.
    pub delay: DelayModel,
    /// Poles may be unstable.
    pub allow_unstable: bool,
    /// Order of differentiation of the motion in every response, where the units are ambiguous.
    pub derivative: Option<u8>,
    /// List weak modes among the others.
    pub all: bool,
    /// The method; by what is named where `None`.
    pub method: Option<IdentificationMethod>,
    /// Speed of what turns, Hz.
    pub speed_hz: Option<f64>,
    /// Output at the driving point, `INPUT=OUTPUT` with several inputs: modal masses by the first, reciprocity between all.
    pub driving_points: Vec<String>,
    /// Memory of a model that follows the process, s; by best prediction where `None`.
    pub memory_s: Option<f64>,
}
