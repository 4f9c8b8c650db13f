//! Spectra as tables for a terminal: the strongest lines of each channel.

use super::number_format::{four_digits, significant};
use super::table::{Table, or_dash};
use crate::numeric::statistics::extremes;
use crate::plan::logs::spectrum_study::{
    AbscissaKind, ChannelSpectrum, SpectrumKind, SpectrumResult,
};

/// Lines shown of a channel.
const MAX_ROWS: usize = 20;

/// Processing steps and the strongest lines.
pub fn text(found: &SpectrumResult) -> String {
    let mut text = format!("{}\n", found.method_text);
    for curve in &found.channel_spectra {
        text += &format!("\n{}\n", curve.channel);
        text += &match curve.peaks.is_empty() {
            true => no_lines_text(found, curve),
            false => lines(found, curve),
        };
    }
    if found.abscissa_kind == AbscissaKind::Order
        && found.channel_spectra.iter().any(|c| !c.peaks.is_empty())
    {
        text += &format!(
            "\nuncertainty of an order: one line, {}\n",
            four_digits(found.abscissa_step)
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
            four_digits(lower),
            four_digits(upper)
        );
    }
    text
}

/// Summary of a curve without lines.
fn no_lines_text(found: &SpectrumResult, curve: &ChannelSpectrum) -> String {
    let (low, high) = extremes(curve.value.iter().copied());
    match found.kind {
        SpectrumKind::SynchronousAverage => format!(
            "  {} … {} {}\n",
            four_digits(low),
            four_digits(high),
            curve.unit
        ),
        _ => "  no line\n".to_string(),
    }
}

/// A ratio of powers in dB.
pub fn decibels(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

/// A place, to the digits it is known by.
fn format_to_resolution(place: f64, known: f64) -> String {
    let digits = (1.0 - known.log10()).ceil().clamp(0.0, 6.0) as usize;
    format!("{place:.digits$}")
}

fn lines(found: &SpectrumResult, curve: &ChannelSpectrum) -> String {
    let (across, unit) = found.abscissa_kind.label();
    let size = match found.kind {
        SpectrumKind::Rms => "rms",
        SpectrumKind::Cepstrum => "height",
        _ => "amplitude",
    };
    let mut table = Table::default()
        .column(across, unit)
        .column(size, &curve.amplitude_unit)
        .columns("signal to noise [dB]|line");
    for line in curve.peaks.iter().take(MAX_ROWS) {
        let ratio = or_dash(line.signal_to_noise, |r| format!("{:.1}", decibels(r)));
        let mut name = line.names.join(" or ");
        if !line.significant {
            name = match name.is_empty() {
                true => "not significant".to_string(),
                false => format!("{name}, not significant"),
            };
        }
        let position = match found.abscissa_kind {
            AbscissaKind::Order => format_to_resolution(line.position, found.abscissa_step),
            _ => significant(line.position),
        };
        table.row([position, four_digits(line.amplitude), ratio, name]);
    }
    let mut text = table.text();
    if curve.peaks.len() > MAX_ROWS {
        text += &format!("{} more\n", curve.peaks.len() - MAX_ROWS);
    }
    text
}
