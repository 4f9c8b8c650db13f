//! Recordings from files or arrays, and the analyses they take.

use std::path::Path;
use std::sync::Arc;

use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::flags::Flags;
use crate::plan::logs::identification::{self, IdentificationInput};
use crate::plan::logs::identification_result::IdentificationResult;
use crate::plan::logs::identify_study::IdentifyStudy;
use crate::plan::logs::spectrum;
use crate::plan::logs::spectrum_study::{SpectrumResult, SpectrumStudy};
use crate::recording::sample_column::SampleColumn;
use crate::recording::signals::{Channel, Recording};
use crate::recording::{open, preprocess};
use crate::scene;

impl Recording {
    /// Reads a log (text, LVM, UFF 58, WAV, MATLAB) with the sidecar next to it, where there is one.
    ///
    /// # Errors
    /// Whatever is wrong with the log or its sidecar, with file, line and remedy.
    pub fn open(path: impl AsRef<Path>) -> Result<Recording, Errors> {
        let path = path.as_ref();
        let settings = scene::sidecar::read_for_log(path, &Flags::default())?.0;
        let log = open::open(&path.display().to_string(), &settings)?;
        Ok(preprocess::preprocess(log, &settings)?)
    }

    /// Makes a recording of sampled signals: sampling rate, Hz, and for each channel its name, its unit (`m/s²`, `N`; empty where
    /// unknown) and its samples.
    ///
    /// ```
    /// use geardyn::Recording;
    ///
    /// let rate = 1000.0;
    /// let sine: Vec<f64> = (0..4000).map(|k| (2.0 * 3.14159265 * 50.0 * k as f64 / rate).sin()).collect();
    /// let recording = Recording::from_arrays(rate, &[("ax", "m/s²", &sine)])?;
    /// let spectrum = recording.spectrum(&Default::default())?;
    /// assert_eq!(spectrum.channel_spectra.len(), 1);
    /// # Ok::<(), geardyn::Errors>(())
    /// ```
    ///
    /// # Errors
    /// A rate that is not above zero, channels of different lengths, two channels of one name, samples that are not finite.
    pub fn from_arrays(
        rate_hz: f64,
        channels: &[(&str, &str, &[f64])],
    ) -> Result<Recording, Errors> {
        let samples = channels.first().map_or(0, |c| c.2.len());
        check(rate_hz, channels, samples)?;
        let channel = |(name, unit, values): &(&str, &str, &[f64])| Channel {
            name: name.to_string(),
            unit: unit.to_string(),
            samples: Arc::new(SampleColumn::from_slice(values)),
            overload_level: None,
            overloads: 0,
        };
        Ok(Recording {
            path: String::new(),
            dialect: "arrays".to_string(),
            metadata: Vec::new(),
            rate_hz,
            rate_std: 0.0,
            rate_source: "as given".to_string(),
            samples,
            segments: std::iter::once(0..samples).collect(),
            segment_starts: vec![0.0],
            start: None,
            files: Vec::new(),
            channels: channels.iter().map(channel).collect(),
            repairs: Vec::new(),
            diagnostics: Vec::new(),
        })
    }

    /// Spectrum of the channels of the study, of all by default.
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

fn check(rate_hz: f64, channels: &[(&str, &str, &[f64])], samples: usize) -> Result<(), Error> {
    if !(rate_hz > 0.0 && rate_hz.is_finite()) {
        let message = format!("sampling rate {rate_hz} Hz is not above zero");
        return Err(Error::new(Code::OutOfRange, message));
    }
    if samples == 0 {
        return Err(Error::new(
            Code::OutOfRange,
            "the recording holds no sample",
        ));
    }
    for (k, (name, _, values)) in channels.iter().enumerate() {
        if values.len() != samples {
            let message = format!(
                "channel {name} has {} samples, the first channel {samples}",
                values.len()
            );
            return Err(
                Error::new(Code::Conflict, message).with_hint("give channels of one length")
            );
        }
        if channels[..k].iter().any(|other| other.0 == *name) {
            return Err(Error::new(
                Code::Conflict,
                format!("two channels are called {name}"),
            ));
        }
        if let Some(at) = values.iter().position(|x| !x.is_finite()) {
            let message = format!("sample {at} of channel {name} is {}", values[at]);
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("give the parts between gaps as recordings of their own"));
        }
    }
    Ok(())
}
