//! Identification study: channels, band, method and options; `None`: chosen from the data.

use super::frf_estimation::FrfStudy;
use super::method::IdentificationMethod;
use crate::identify::rational::DelayModel;

/// What is asked of a log.
#[derive(Debug, Clone, Default)]
pub struct IdentifyStudy {
    /// Channels that drive.
    pub inputs: Vec<String>,
    /// Channels that answer.
    pub outputs: Vec<String>,
    /// How responses are estimated.
    pub estimate: FrfStudy,
    /// Lines used, Hz.
    pub band_hz: Option<(f64, f64)>,
    /// Pole pairs; as many as are significant where `None`.
    pub order: Option<usize>,
    /// A delay to be estimated.
    pub delay: DelayModel,
    /// Poles may be unstable.
    pub allow_unstable: bool,
    /// How often the motion in every response was differentiated, where the units do not tell.
    pub derivative: Option<u8>,
    /// List weak modes among the others.
    pub all: bool,
    /// The method; by what is named where `None`.
    pub method: Option<IdentificationMethod>,
    /// Speed of what turns, Hz.
    pub speed_hz: Option<f64>,
    /// Output at the driving point, `INPUT=OUTPUT` with several inputs: modal masses by the first, reciprocity between all.
    pub driving_points: Vec<String>,
    /// How long a sample counts in a model that follows the process, s; by what predicts best where `None`.
    pub memory_s: Option<f64>,
}
