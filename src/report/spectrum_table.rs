//! Spectra as tables for a terminal: the strongest lines of each channel.

use super::number::{brief, significant};
use super::spectra::decibels;
use super::table::{finish, plain, right_but_last};
use crate::plan::logs::spectrum_study::{Across, Curve, Spectrum, SpectrumKind};

/// Lines shown of a channel.
const ROWS: usize = 20;

/// What was done and the strongest lines.
pub fn spectrum(found: &Spectrum) -> String {
    let mut text = format!("{}\n", found.how);
    for curve in &found.curves {
        text += &format!("\n{}\n", curve.channel);
        text += &match curve.lines.is_empty() {
            true => nothing(found, curve),
            false => lines(found, curve),
        };
    }
    if found.across == Across::Order && found.curves.iter().any(|c| !c.lines.is_empty()) {
        text += &format!(
            "\nan order may be off by a line, {}\n",
            brief(found.resolution)
        );
    }
    if let Some((lower, upper)) = found.interval {
        let is_size = matches!(
            found.kind,
            SpectrumKind::Amplitude | SpectrumKind::Rms | SpectrumKind::Order
        );
        let (what, lower, upper) = match is_size {
            true => ("amplitude", lower.sqrt(), upper.sqrt()),
            false => ("density", lower, upper),
        };
        text += &format!(
            "\nrandom parts: the 95 % interval of the true {what} is {} … {} times the one shown\n",
            brief(lower),
            brief(upper)
        );
    }
    text
}

/// What a curve without lines shows.
fn nothing(found: &Spectrum, curve: &Curve) -> String {
    let (low, high) = curve
        .value
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| {
            (l.min(v), h.max(v))
        });
    match found.kind {
        SpectrumKind::Average => format!("  {} … {} {}\n", brief(low), brief(high), curve.unit),
        _ => "  no line\n".to_string(),
    }
}

/// A place, to the digits it is known by.
fn known_to(place: f64, known: f64) -> String {
    let digits = (1.0 - known.log10()).ceil().clamp(0.0, 6.0) as usize;
    format!("{place:.digits$}")
}

fn lines(found: &Spectrum, curve: &Curve) -> String {
    let (across, unit) = found.across.words();
    let mut table = plain();
    let size = match found.kind {
        SpectrumKind::Rms => "rms",
        SpectrumKind::Cepstrum => "height",
        _ => "amplitude",
    };
    table.add_row(vec![across, size, "signal to noise", "line"]);
    table.add_row(vec![unit, &curve.amplitude_unit, "dB", ""]);
    for line in curve.lines.iter().take(ROWS) {
        let ratio = line
            .signal_to_noise
            .map_or("–".to_string(), |r| format!("{:.1}", decibels(r)));
        let mut name = line.names.join(" or ");
        if !line.significant {
            name = match name.is_empty() {
                true => "not clear of the noise".to_string(),
                false => format!("{name}, not clear of the noise"),
            };
        }
        let position = match found.across {
            Across::Order => known_to(line.position, found.resolution),
            _ => significant(line.position),
        };
        table.add_row(vec![position, brief(line.amplitude), ratio, name]);
    }
    right_but_last(&mut table);
    let mut text = finish(&table);
    if curve.lines.len() > ROWS {
        text += &format!("{} more\n", curve.lines.len() - ROWS);
    }
    text
}
