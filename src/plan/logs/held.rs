//! Peaks of spectra that a file holds, instead of signals to make them from.

use super::spectrum::{is_inside, lines, name};
use super::spectrum_study::{Across, Curve, Spectrum, SpectrumKind, SpectrumStudy};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::names;
use crate::recording::responses;
use crate::recording::settle::no_channel;
use crate::spectrum::spectra::Spectra;

/// The spectra named, as the file holds them, with their peaks.
///
/// # Errors
/// One that is not there, flags that need a signal, spectra over different lines.
pub fn spectrum(held: &[responses::Spectrum], study: &SpectrumStudy) -> Result<Spectrum, Error> {
    refuse_flags(study)?;
    let known: Vec<String> = held.iter().map(|s| s.name.clone()).collect();
    let find = |word: &String| names::find(word, &known).ok_or_else(|| no_channel(word, &known));
    let places = study
        .channels
        .iter()
        .map(find)
        .collect::<Result<Vec<usize>, Error>>()?;
    let chosen: Vec<&responses::Spectrum> = places.iter().map(|&at| &held[at]).collect();
    let frequency_hz = chosen.first().map_or(&[][..], |s| &s.frequency_hz);
    if let Some(other) = chosen.iter().find(|s| s.frequency_hz != frequency_hz) {
        let message = format!(
            "{} lies over other lines than {}",
            other.name, chosen[0].name
        );
        return Err(Error::new(Code::Conflict, message).hint("name one spectrum at a time"));
    }
    let inside = |k: &usize| is_inside(study.band, frequency_hz[*k]);
    let kept: Vec<usize> = (0..frequency_hz.len()).filter(inside).collect();
    if kept.is_empty() {
        let ends = (frequency_hz.first(), frequency_hz.last());
        let (low, high) = (ends.0.unwrap_or(&0.0), ends.1.unwrap_or(&0.0));
        let message = format!("no line lies in the band; the file holds {low} … {high} Hz");
        return Err(Error::new(Code::OutOfRange, message).hint("choose another --band"));
    }
    let how: Vec<String> = chosen.iter().map(|s| in_words(s)).collect();
    let curves = chosen
        .iter()
        .map(|held| curve(held, &kept, study))
        .collect();
    Ok(Spectrum {
        trace: Vec::new(),
        how: how.join("\n"),
        kind: match chosen.iter().all(|s| s.is_power()) {
            true => SpectrumKind::Density,
            false => SpectrumKind::Amplitude,
        },
        across: Across::Frequency,
        places: kept.iter().map(|&k| frequency_hz[k]).collect(),
        curves,
        sought: None,
        resolution: match kept[..] {
            [first, second, ..] => frequency_hz[second] - frequency_hz[first],
            _ => 0.0,
        },
        averages: None,
        interval: None,
        warnings: Vec::new(),
    })
}

/// What only a signal can give.
fn refuse_flags(study: &SpectrumStudy) -> Result<(), Error> {
    let plain = SpectrumStudy {
        channels: study.channels.clone(),
        band: study.band,
        pulses: study.pulses,
        speed: study.speed,
        expected: study.expected.clone(),
        ..SpectrumStudy::default()
    };
    match *study == plain {
        true => Ok(()),
        false => Err(Error::new(
            Code::Usage,
            "the file holds spectra and no signal, so nothing else can be made of it",
        )
        .hint("leave out all but --channel, --band and what names lines; or export the signal")),
    }
}

/// `Acceleration (FFT - (RMS)): spectrum as the file holds it, 1601 lines, brought from dB to g`.
fn in_words(held: &responses::Spectrum) -> String {
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

fn curve(held: &responses::Spectrum, kept: &[usize], study: &SpectrumStudy) -> Curve {
    let power: Vec<f64> = held.value.iter().map(|v| held.power(*v)).collect();
    let shown = |power: f64| if held.is_power() { power } else { power.sqrt() };
    let value = kept.iter().map(|&k| shown(power[k])).collect();
    let spectra = Spectra {
        frequency_hz: held.frequency_hz.clone(),
        psd: vec![power],
        blocks: 1,
        bandwidth_hz: 1.0,
        ..Spectra::default()
    };
    let mut found = lines(&spectra, 0, study.band, false);
    for line in &mut found {
        line.value = shown(line.value);
        line.amplitude = line.value;
    }
    found.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    let spacing = match held.frequency_hz[..] {
        [first, second, ..] => second - first,
        _ => 0.0,
    };
    name(&mut found, study, spacing);
    Curve {
        channel: held.name.clone(),
        unit: held.unit.clone(),
        amplitude_unit: held.unit.clone(),
        value,
        lines: found,
        rows: Vec::new(),
        speed: Vec::new(),
    }
}
