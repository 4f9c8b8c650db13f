//! Recordings from files or arrays, and the analyses they take.

use std::path::Path;

use crate::base::error::Errors;
use crate::base::flags::Flags;
use crate::plan::logs::identification::{self, IdentificationInput};
use crate::plan::logs::identification_result::IdentificationResult;
use crate::plan::logs::identify_study::IdentifyStudy;
use crate::plan::logs::spectrum;
use crate::plan::logs::spectrum_study::{SpectrumResult, SpectrumStudy};
use crate::recording::sidecar;
use crate::recording::signals::Recording;
use crate::recording::{open, preprocess};

impl Recording {
    /// Reads a log (text, LVM, UFF 58, WAV, MATLAB) with the sidecar next to it, where there is one.
    ///
    /// # Errors
    /// Whatever is wrong with the log or its sidecar, with file, line and remedy.
    pub fn open(path: impl AsRef<Path>) -> Result<Recording, Errors> {
        let path = path.as_ref();
        let settings = sidecar::read_for_log(path, &Flags::default())?.0;
        let log = open::open(&path.display().to_string(), &settings)?;
        Ok(preprocess::preprocess(log, &settings)?)
    }

    /// Spectrum of the channels of the study, of all by default.
    ///
    /// ```
    /// # use geardyn::prelude::*;
    /// let recording = Recording::open("data/spindle_cutting.csv")?;
    /// let spectrum = recording.spectrum(&SpectrumStudy::default())?;
    /// assert_eq!(spectrum.channel_spectra.len(), recording.channels.len());
    /// # Ok::<(), Errors>(())
    /// ```
    ///
    /// # Errors
    /// Unknown channels; a study the record is too short for.
    pub fn spectrum(&self, study: &SpectrumStudy) -> Result<SpectrumResult, Errors> {
        let mut study = study.clone();
        if study.channels.is_empty() {
            study.channels = self.channels.iter().map(|c| c.name.clone()).collect();
        }
        Ok(spectrum::run_spectrum(self, &study)?)
    }

    /// Frequency responses, transfer functions and modes from `inputs` to `outputs`; modes from responses alone where `inputs` is empty.
    /// The channels of the study are those named here.
    ///
    /// ```
    /// # use geardyn::prelude::*;
    /// let recording = Recording::open("data/spindle_impact.csv")?;
    /// let identified = recording.identify(&["force"], &["ax", "ay"], &IdentifyStudy::default())?;
    /// assert_eq!(identified.modes.len(), 6);
    /// # Ok::<(), Errors>(())
    /// ```
    ///
    /// # Errors
    /// Unknown channels; a study the record is too short for; data that hold no mode.
    pub fn identify(
        &self,
        inputs: &[&str],
        outputs: &[&str],
        study: &IdentifyStudy,
    ) -> Result<IdentificationResult, Errors> {
        let names = |list: &[&str]| list.iter().map(|name| name.to_string()).collect();
        let study = IdentifyStudy {
            inputs: names(inputs),
            outputs: names(outputs),
            ..study.clone()
        };
        Ok(identification::identify(
            IdentificationInput::Signals(self),
            &study,
        )?)
    }
}
