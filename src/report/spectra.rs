//! Report of the spectra of a log: JSON document, table over the abscissa, curves and spectrogram maps.

use serde_json::{Value, json};

use super::figure::{
    Axis, Curve, Figure, Ink, LevelMap, PLOT_HEIGHT, Plot, PlotColumn, PointLabel,
};
use super::number_format::four_digits;
use super::presentation::{LogReport, Presentation, Provenance};
use super::spectrum_table::{self, decibels};
use super::table::{Table, exact};
use crate::base::error::Error;
use crate::numeric::sorting::{ascending_order, sort_descending};
use crate::plan::logs::order_cuts::rpm;
use crate::plan::logs::spectrum_study::{
    AbscissaKind, ChannelSpectrum, LabelledPeak, SpectrumKind, SpectrumResult,
};

/// JSON name of a spectrum kind.
pub fn kind(kind: SpectrumKind) -> &'static str {
    match kind {
        SpectrumKind::Density => "psd",
        SpectrumKind::Amplitude => "amplitude",
        SpectrumKind::Rms => "rms",
        SpectrumKind::Multitaper => "multitaper",
        SpectrumKind::Envelope => "envelope",
        SpectrumKind::Cepstrum => "cepstrum",
        SpectrumKind::Spectrogram => "spectrogram",
        SpectrumKind::Order => "order",
        SpectrumKind::SynchronousAverage => "average",
    }
}

/// JSON key of the abscissa.
fn key(abscissa: AbscissaKind) -> &'static str {
    match abscissa {
        AbscissaKind::Frequency => "frequency_hz",
        AbscissaKind::Order => "order",
        AbscissaKind::Quefrency => "quefrency_s",
        AbscissaKind::Angle => "angle_deg",
    }
}

impl Presentation for LogReport<SpectrumResult> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_log(&self.result.trace, &self.repairs, &self.result.diagnostics)
    }

    fn body(&self) -> Result<Value, Error> {
        let result = &self.result;
        let abscissa_key = key(result.abscissa_kind);
        let channels: Vec<Value> = result
            .channel_spectra
            .iter()
            .map(|c| channel(c, abscissa_key))
            .collect();
        let mut document = json!({
            "kind": kind(result.kind),
            "method_text": result.method_text,
            "averages": result.averages,
            "resolution": result.abscissa_step,
            "interval": result.interval.map(|(lower, upper)| json!({ "confidence": 0.95, "lower": lower, "upper": upper })),
            "channels": channels,
        });
        document[abscissa_key] = json!(result.abscissa);
        Ok(document)
    }

    fn text(&self) -> String {
        spectrum_table::text(&self.result)
    }

    fn table(&self) -> Table<'_> {
        let result = &self.result;
        let curves = &result.channel_spectra;
        let rows = curves
            .iter()
            .map(|c| c.spectrogram_rows.len())
            .min()
            .unwrap_or(0);
        let axis = key(result.abscissa_kind);
        if curves.iter().all(|c| c.spectrogram_rows.is_empty()) {
            let table = Table::default().numbers(axis, "", &result.abscissa, exact);
            return curves.iter().fold(table, |table, c| {
                table.numbers(&c.channel, &c.unit, &c.value, exact)
            });
        }
        let lines = result.abscissa.len();
        // Repeats the value of each row for all its frequency lines.
        let repeated = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..rows)
                .flat_map(|r| std::iter::repeat_n(value(r), lines))
                .collect()
        };
        let mut table = Table::default();
        if let Some(first) = curves.first() {
            let times = repeated(&|r| first.spectrogram_rows[r].time_s);
            table = table.numbers("time_s", "", times, exact);
            if !first.speed.is_empty() {
                let speeds = repeated(&|r| first.speed.get(r).map_or(f64::NAN, |&s| rpm(s)));
                table = table.numbers("speed_rpm", "", speeds, exact);
            }
        }
        let table = table.numbers(axis, "", result.abscissa.repeat(rows), exact);
        curves.iter().fold(table, |table, c| {
            let densities = c.spectrogram_rows[..rows]
                .iter()
                .flat_map(|row| row.density.iter().copied());
            table.numbers(&c.channel, &c.unit, densities.collect::<Vec<_>>(), exact)
        })
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let maps = level_maps(&self.result);
        let plots = match maps.is_empty() {
            true => PlotColumn::one(&self.title, spectrum_plot(&self.result)),
            false => PlotColumn {
                title: self.title.clone(),
                plots: maps.into_iter().chain(speed_plot(&self.result)).collect(),
                ..PlotColumn::default()
            },
        };
        Ok(vec![Figure::first(plots)])
    }
}

fn channel(curve: &ChannelSpectrum, axis: &str) -> Value {
    let mut object = json!({
        "channel": curve.channel,
        "unit": curve.unit,
        "value": curve.value,
        "peaks": curve.peaks.iter().map(|l| peak(l, curve, axis)).collect::<Vec<_>>(),
    });
    if !curve.spectrogram_rows.is_empty() {
        object["rows"] = curve
            .spectrogram_rows
            .iter()
            .enumerate()
            .map(|(index, row)| {
                let speed_rpm = curve.speed.get(index).map(|&s| rpm(s));
                json!({ "time_s": row.time_s, "speed_rpm": speed_rpm, "value": row.density })
            })
            .collect();
    }
    object
}

fn peak(line: &LabelledPeak, curve: &ChannelSpectrum, axis: &str) -> Value {
    let mut object = json!({
        "value": line.value,
        "amplitude": line.amplitude,
        "amplitude_unit": curve.amplitude_unit,
        "signal_to_noise_db": line.signal_to_noise.map(decibels),
        "significant": line.significant,
        "names": line.names,
    });
    object[axis] = json!(line.position);
    object
}

/// Spectrogram maps, one per channel; empty for other kinds of spectrum.
fn level_maps(result: &SpectrumResult) -> Vec<Plot> {
    let with_rows = |c: &&ChannelSpectrum| !c.spectrogram_rows.is_empty();
    let curves: Vec<&ChannelSpectrum> = result.channel_spectra.iter().filter(with_rows).collect();
    let height = if curves.len() == 1 {
        PLOT_HEIGHT
    } else {
        240.0
    };
    let map = |curve: &ChannelSpectrum| {
        let rows = &curve.spectrogram_rows;
        let (label, abscissa, rows) = match curve.speed.is_empty() {
            true => (
                "time, s",
                rows.iter().map(|row| row.time_s).collect(),
                rows.iter().map(|row| row.density.clone()).collect(),
            ),
            false => over_speed(curve),
        };
        let levels = |row: Vec<f64>| row.into_iter().map(decibels).collect();
        Plot {
            height,
            heading: curve.channel.clone(),
            map: Some(LevelMap {
                label: format!("dB re 1 {}", curve.unit),
                x: abscissa,
                y: result.abscissa.clone(),
                columns: rows.into_iter().map(levels).collect(),
                sparse: false,
            }),
            ..Plot::new(Axis::linear(label), Axis::linear("frequency, Hz"))
        }
    };
    curves.into_iter().map(map).collect()
}

/// Plot of the tacho speed over time; `None` for maps over time.
fn speed_plot(result: &SpectrumResult) -> Option<Plot> {
    let curve = (result.channel_spectra.iter()).find(|c| !c.speed.is_empty())?;
    let times = curve.spectrogram_rows.iter().map(|row| row.time_s);
    let speeds = curve.speed.iter().map(|&s| rpm(s));
    let line = Curve::line("", Ink::Series(0), times.collect(), speeds.collect());
    Some(Plot {
        height: 120.0,
        heading: "speed".into(),
        curves: vec![line],
        ..Plot::new(Axis::linear("time, s"), Axis::linear("speed, rpm"))
    })
}

/// Largest number of columns of a map over speed.
const MAX_COLUMNS: usize = 250;

/// Largest distance, in columns, from which a column of a map over speed takes its row; tacho speeds scatter.
const MAX_DISTANCE: f64 = 3.0;

/// Averages spectrogram rows of equal speed; columns by rising speed, rpm.
fn over_speed(curve: &ChannelSpectrum) -> (&'static str, Vec<f64>, Vec<Vec<f64>>) {
    let range =
        (curve.speed.iter()).fold((f64::INFINITY, 0.0f64), |(l, h), &s| (l.min(s), h.max(s)));
    let bins = MAX_COLUMNS.min(curve.spectrogram_rows.len()).max(1);
    let width = (range.1 - range.0) / bins as f64;
    let bin = |speed: f64| ((speed - range.0) / width.max(f64::MIN_POSITIVE)) as usize;
    let order = ascending_order(curve.speed.iter().copied());
    let mut means: Vec<(f64, Vec<f64>)> = Vec::new();
    for group in order.chunk_by(|&a, &b| bin(curve.speed[a]) == bin(curve.speed[b])) {
        let weight = 1.0 / group.len() as f64;
        let speed = group.iter().map(|&row| weight * curve.speed[row]).sum();
        let mut mean = vec![0.0; curve.spectrogram_rows[group[0]].density.len()];
        for &row in group {
            let terms = mean.iter_mut().zip(&curve.spectrogram_rows[row].density);
            terms.for_each(|(m, d)| *m += weight * d);
        }
        means.push((speed, mean));
    }
    // An empty column takes its nearest neighbour; wider gaps remain.
    let column = |k: usize| {
        let centre = range.0 + (k as f64 + 0.5) * width;
        let dist = |mean: &(f64, Vec<f64>)| (mean.0 - centre).abs();
        let nearest = means.iter().min_by(|a, b| dist(a).total_cmp(&dist(b)))?;
        (dist(nearest) <= MAX_DISTANCE * width).then(|| (rpm(centre), nearest.1.clone()))
    };
    let (speeds, rows) = (0..bins).filter_map(column).unzip();
    ("speed, rpm", speeds, rows)
}

/// Largest number of labelled lines in one plot.
const MAX_LABELS: usize = 12;

/// Plot of the spectra as curves with the strongest lines labelled.
fn spectrum_plot(result: &SpectrumResult) -> Plot {
    let (name, unit) = result.abscissa_kind.label();
    let unit_of = |unit: &str| match unit {
        "" => String::new(),
        unit => format!(", {unit}"),
    };
    let spectra = &result.channel_spectra;
    let unit_of_values = unit_of(spectra.first().map_or("", |c| &c.unit));
    let label = match result.kind {
        SpectrumKind::Order | SpectrumKind::SynchronousAverage => {
            format!("amplitude{unit_of_values}")
        }
        other => format!("{}{unit_of_values}", kind(other)),
    };
    let mut strongest: Vec<&LabelledPeak> = spectra.iter().flat_map(|c| &c.peaks).collect();
    sort_descending(&mut strongest, |a| a.amplitude);
    strongest.truncate(MAX_LABELS);
    let text = |line: &LabelledPeak| match line.names.first() {
        Some(name) => format!("{} {name}", four_digits(line.position)),
        None => four_digits(line.position),
    };
    // The shortest quefrencies, the mean level of the spectrum, would dominate the ordinate.
    let lowest = result.quefrency_range_s.map_or(f64::NEG_INFINITY, |s| s.0);
    let from = result.abscissa.partition_point(|p| *p < lowest);
    let curve = |(k, c): (usize, &ChannelSpectrum)| {
        let (x, y) = (result.abscissa[from..].to_vec(), c.value[from..].to_vec());
        Curve::line(&c.channel, Ink::Series(k), x, y)
    };
    let peak_label = |line: &LabelledPeak| PointLabel {
        x: line.position,
        y: line.value,
        text: text(line),
    };
    let y = match result.kind {
        SpectrumKind::Density | SpectrumKind::Multitaper => Axis::log(label),
        _ => Axis::of_magnitudes(
            label,
            spectra.iter().flat_map(|c| c.value[from..].iter().copied()),
        ),
    };
    Plot {
        curves: spectra.iter().enumerate().map(curve).collect(),
        labels: strongest.into_iter().map(peak_label).collect(),
        ..Plot::new(Axis::linear(format!("{name}{}", unit_of(unit))), y)
    }
}
