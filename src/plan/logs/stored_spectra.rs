//! Analysis of spectra stored in a file: selection, conversion from dB, peaks.

use super::spectrum::{is_inside, label_peaks, labelled_peaks};
use super::spectrum_study::{
    AbscissaKind, ChannelSpectrum, SpectrumKind, SpectrumResult, SpectrumStudy,
};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::sorting::sort_descending;
use crate::recording::channel_names;
use crate::recording::frequency_responses;
use crate::recording::preprocess::unknown_channel;
use crate::spectrum::spectra::Spectra;

/// Requested spectra of a file with their peaks.
///
/// # Errors
/// A spectrum does not exist; an option requires a signal; the spectra have different lines.
pub fn analyse_stored(
    spectra: &[frequency_responses::StoredSpectrum],
    study: &SpectrumStudy,
) -> Result<SpectrumResult, Error> {
    check_flags(study)?;
    let known: Vec<String> = spectra.iter().map(|s| s.name.clone()).collect();
    let find = |word: &String| {
        channel_names::find_channel(word, &known).ok_or_else(|| unknown_channel(word, &known))
    };
    let indices = study
        .channels
        .iter()
        .map(find)
        .collect::<Result<Vec<usize>, Error>>()?;
    let selected: Vec<&frequency_responses::StoredSpectrum> =
        indices.iter().map(|&at| &spectra[at]).collect();
    let frequency_hz = selected.first().map_or(&[][..], |s| &s.frequency_hz);
    if let Some(other) = selected.iter().find(|s| s.frequency_hz != frequency_hz) {
        let message = format!(
            "{} has other spectral lines than {}",
            other.name, selected[0].name
        );
        return Err(Error::new(Code::Conflict, message).with_hint("name one spectrum at a time"));
    }
    let is_in_band = |k: &usize| is_inside(study.band, frequency_hz[*k]);
    let band_lines: Vec<usize> = (0..frequency_hz.len()).filter(is_in_band).collect();
    if band_lines.is_empty() {
        let ends = (frequency_hz.first(), frequency_hz.last());
        let (low, high) = (ends.0.unwrap_or(&0.0), ends.1.unwrap_or(&0.0));
        let message = format!("no line lies in the band; the file has {low} … {high} Hz");
        return Err(Error::new(Code::OutOfRange, message).with_hint("choose another --band"));
    }
    let descriptions: Vec<String> = selected.iter().map(|s| describe(s)).collect();
    let channel_spectra = selected
        .iter()
        .map(|spectrum| channel_spectrum(spectrum, &band_lines, study))
        .collect();
    Ok(SpectrumResult {
        trace: Vec::new(),
        method_text: descriptions.join("\n"),
        kind: match selected.iter().all(|s| s.is_power()) {
            true => SpectrumKind::Density,
            false => SpectrumKind::Amplitude,
        },
        abscissa_kind: AbscissaKind::Frequency,
        abscissa: band_lines.iter().map(|&k| frequency_hz[k]).collect(),
        channel_spectra,
        quefrency_range_s: None,
        abscissa_step: match band_lines[..] {
            [first, second, ..] => frequency_hz[second] - frequency_hz[first],
            _ => 0.0,
        },
        averages: None,
        interval: None,
        diagnostics: Vec::new(),
    })
}

/// Rejects options that require a signal over time.
fn check_flags(study: &SpectrumStudy) -> Result<(), Error> {
    let without_signal = SpectrumStudy {
        channels: study.channels.clone(),
        band: study.band,
        pulses_per_rev: study.pulses_per_rev,
        speed: study.speed,
        expected_lines: study.expected_lines.clone(),
        ..SpectrumStudy::default()
    };
    match *study == without_signal {
        true => Ok(()),
        false => Err(Error::new(
            Code::Usage,
            "the file contains spectra, not signals: no other analysis is possible",
        )
        .with_hint("omit all but --channel, --band and line names; or export the signal")),
    }
}

/// Text such as `Acceleration (FFT - (RMS)): spectrum as stored in the file, 1601 lines, converted from dB to g`.
fn describe(spectrum: &frequency_responses::StoredSpectrum) -> String {
    let decibels = match (spectrum.is_decibel, spectrum.unit.is_empty()) {
        (false, _) => String::new(),
        (true, true) => ", converted from dB to a ratio".to_string(),
        (true, false) => format!(", converted from dB to {}", spectrum.unit),
    };
    format!(
        "{}: {} as stored in the file, {} lines{decibels}",
        spectrum.name,
        spectrum.kind,
        spectrum.frequency_hz.len()
    )
}

fn channel_spectrum(
    data: &frequency_responses::StoredSpectrum,
    lines: &[usize],
    study: &SpectrumStudy,
) -> ChannelSpectrum {
    let power: Vec<f64> = data.values.iter().map(|v| data.to_power(*v)).collect();
    let scale = |p: f64| if data.is_power() { p } else { p.sqrt() };
    let value = lines.iter().map(|&k| scale(power[k])).collect();
    let spectra = Spectra {
        frequency_hz: data.frequency_hz.clone(),
        psd: vec![power],
        blocks: 1,
        bandwidth_hz: 1.0,
        ..Spectra::default()
    };
    let mut peaks = labelled_peaks(&spectra, 0, study.band, false);
    for peak in &mut peaks {
        peak.value = scale(peak.value);
        peak.amplitude = peak.value;
    }
    sort_descending(&mut peaks, |a| a.amplitude);
    let spacing = match data.frequency_hz[..] {
        [first, second, ..] => second - first,
        _ => 0.0,
    };
    label_peaks(&mut peaks, study, spacing);
    ChannelSpectrum {
        channel: data.name.clone(),
        unit: data.unit.clone(),
        amplitude_unit: data.unit.clone(),
        value,
        peaks,
        spectrogram_rows: Vec::new(),
        speed: Vec::new(),
    }
}
