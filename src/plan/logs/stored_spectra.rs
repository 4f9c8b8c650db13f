//! Peaks of spectra stored in a file.

use super::spectrum::{is_inside, label_peaks, labelled_peaks};
use super::spectrum_study::{
    AbscissaKind, ChannelSpectrum, SpectrumKind, SpectrumResult, SpectrumStudy,
};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::sorting::sort_falling;
use crate::recording::channel_names;
use crate::recording::frequency_responses;
use crate::recording::preprocess::unknown_channel;
use crate::spectrum::spectra::Spectra;

/// The spectra named, as the file holds them, with their peaks.
///
/// # Errors
/// One that is not there, flags that need a signal, spectra over different lines.
pub fn analyse_stored(
    held: &[frequency_responses::StoredSpectrum],
    study: &SpectrumStudy,
) -> Result<SpectrumResult, Error> {
    check_flags(study)?;
    let known: Vec<String> = held.iter().map(|s| s.name.clone()).collect();
    let find = |word: &String| {
        channel_names::find_channel(word, &known).ok_or_else(|| unknown_channel(word, &known))
    };
    let places = study
        .channels
        .iter()
        .map(find)
        .collect::<Result<Vec<usize>, Error>>()?;
    let chosen: Vec<&frequency_responses::StoredSpectrum> =
        places.iter().map(|&at| &held[at]).collect();
    let frequency_hz = chosen.first().map_or(&[][..], |s| &s.frequency_hz);
    if let Some(other) = chosen.iter().find(|s| s.frequency_hz != frequency_hz) {
        let message = format!(
            "{} lies over other lines than {}",
            other.name, chosen[0].name
        );
        return Err(Error::new(Code::Conflict, message).with_hint("name one spectrum at a time"));
    }
    let inside = |k: &usize| is_inside(study.band, frequency_hz[*k]);
    let kept: Vec<usize> = (0..frequency_hz.len()).filter(inside).collect();
    if kept.is_empty() {
        let ends = (frequency_hz.first(), frequency_hz.last());
        let (low, high) = (ends.0.unwrap_or(&0.0), ends.1.unwrap_or(&0.0));
        let message = format!("no line lies in the band; the file holds {low} … {high} Hz");
        return Err(Error::new(Code::OutOfRange, message).with_hint("choose another --band"));
    }
    let how: Vec<String> = chosen.iter().map(|s| describe(s)).collect();
    let channel_spectra = chosen
        .iter()
        .map(|held| channel_spectrum(held, &kept, study))
        .collect();
    Ok(SpectrumResult {
        trace: Vec::new(),
        method_text: how.join("\n"),
        kind: match chosen.iter().all(|s| s.is_power()) {
            true => SpectrumKind::Density,
            false => SpectrumKind::Amplitude,
        },
        abscissa_kind: AbscissaKind::Frequency,
        abscissa: kept.iter().map(|&k| frequency_hz[k]).collect(),
        channel_spectra,
        quefrency_range_s: None,
        abscissa_step: match kept[..] {
            [first, second, ..] => frequency_hz[second] - frequency_hz[first],
            _ => 0.0,
        },
        averages: None,
        interval: None,
        diagnostics: Vec::new(),
    })
}

/// Rejects options that require a time signal.
fn check_flags(study: &SpectrumStudy) -> Result<(), Error> {
    let plain = SpectrumStudy {
        channels: study.channels.clone(),
        band: study.band,
        pulses_per_rev: study.pulses_per_rev,
        speed: study.speed,
        expected_lines: study.expected_lines.clone(),
        ..SpectrumStudy::default()
    };
    match *study == plain {
        true => Ok(()),
        false => Err(Error::new(
            Code::Usage,
            "the file holds spectra and no signal, so nothing else can be made of it",
        )
        .with_hint("omit all but --channel, --band and what names lines; or export the signal")),
    }
}

/// `Acceleration (FFT - (RMS)): analyse_stored as the file holds it, 1601 lines, brought from dB to g`.
fn describe(held: &frequency_responses::StoredSpectrum) -> String {
    let decibels = match (held.is_decibel, held.unit.is_empty()) {
        (false, _) => String::new(),
        (true, true) => ", brought from dB to a ratio".to_string(),
        (true, false) => format!(", brought from dB to {}", held.unit),
    };
    format!(
        "{}: {} as the file holds it, {} lines{decibels}",
        held.name,
        held.kind,
        held.frequency_hz.len()
    )
}

fn channel_spectrum(
    held: &frequency_responses::StoredSpectrum,
    kept: &[usize],
    study: &SpectrumStudy,
) -> ChannelSpectrum {
    let power: Vec<f64> = held.values.iter().map(|v| held.to_power(*v)).collect();
    let shown = |power: f64| if held.is_power() { power } else { power.sqrt() };
    let value = kept.iter().map(|&k| shown(power[k])).collect();
    let spectra = Spectra {
        frequency_hz: held.frequency_hz.clone(),
        psd: vec![power],
        blocks: 1,
        bandwidth_hz: 1.0,
        ..Spectra::default()
    };
    let mut found = labelled_peaks(&spectra, 0, study.band, false);
    for line in &mut found {
        line.value = shown(line.value);
        line.amplitude = line.value;
    }
    sort_falling(&mut found, |a| a.amplitude);
    let spacing = match held.frequency_hz[..] {
        [first, second, ..] => second - first,
        _ => 0.0,
    };
    label_peaks(&mut found, study, spacing);
    ChannelSpectrum {
        channel: held.name.clone(),
        unit: held.unit.clone(),
        amplitude_unit: held.unit.clone(),
        value,
        peaks: found,
        spectrogram_rows: Vec::new(),
        speed: Vec::new(),
    }
}
