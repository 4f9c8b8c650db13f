//! Spectra of a log: document, table over frequency, curves and maps.

use serde_json::{Value, json};

use super::figure::{
    Axis, Curve, Figure, Ink, LevelMap, PLOT_HEIGHT, Plot, PlotColumn, PointLabel,
};
use super::number_format::four_digits;
use super::presentation::{LogReport, Presentation, Provenance};
use super::spectrum_table::{self, decibels};
use super::table::{Table, exact};
use crate::base::error::Error;
use crate::numeric::sorting::{rising_order, sort_falling};
use crate::plan::logs::order_cuts::rpm;
use crate::plan::logs::spectrum_study::{
    AbscissaKind, ChannelSpectrum, LabelledPeak, SpectrumKind, SpectrumResult,
};

/// The word for a kind of spectrum.
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

/// The key of the places.
fn key(across: AbscissaKind) -> &'static str {
    match across {
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
        let found = &self.result;
        let place = key(found.abscissa_kind);
        let channels: Vec<Value> = found
            .channel_spectra
            .iter()
            .map(|c| channel(c, place))
            .collect();
        let mut document = json!({
            "kind": kind(found.kind),
            "method_text": found.method_text,
            "averages": found.averages,
            "resolution": found.abscissa_step,
            "interval": found.interval.map(|(lower, upper)| json!({ "confidence": 0.95, "lower": lower, "upper": upper })),
            "channels": channels,
        });
        document[place] = json!(found.abscissa);
        Ok(document)
    }

    fn text(&self) -> String {
        spectrum_table::text(&self.result)
    }

    fn table(&self) -> Table<'_> {
        let found = &self.result;
        let curves = &found.channel_spectra;
        let rows = curves
            .iter()
            .map(|c| c.spectrogram_rows.len())
            .min()
            .unwrap_or(0);
        let place = key(found.abscissa_kind);
        if curves.iter().all(|c| c.spectrogram_rows.is_empty()) {
            let places = Table::default().numbers(place, "", &found.abscissa, exact);
            return curves.iter().fold(places, |table, c| {
                table.numbers(&c.channel, &c.unit, &c.value, exact)
            });
        }
        let lines = found.abscissa.len();
        // A value of every row, for each of its lines.
        let each = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..rows)
                .flat_map(|r| std::iter::repeat_n(of(r), lines))
                .collect()
        };
        let mut table = Table::default();
        if let Some(first) = curves.first() {
            let times = each(&|r| first.spectrogram_rows[r].time_s);
            table = table.numbers("time_s", "", times, exact);
            if !first.speed.is_empty() {
                let speeds = each(&|r| first.speed.get(r).map_or(f64::NAN, |&s| rpm(s)));
                table = table.numbers("speed_rpm", "", speeds, exact);
            }
        }
        let table = table.numbers(place, "", found.abscissa.repeat(rows), exact);
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

fn channel(curve: &ChannelSpectrum, place: &str) -> Value {
    let mut all = json!({
        "channel": curve.channel,
        "unit": curve.unit,
        "value": curve.value,
        "peaks": curve.peaks.iter().map(|l| peak(l, curve, place)).collect::<Vec<_>>(),
    });
    if !curve.spectrogram_rows.is_empty() {
        all["rows"] = curve
            .spectrogram_rows
            .iter()
            .enumerate()
            .map(|(at, row)| {
                let speed_rpm = curve.speed.get(at).map(|&s| rpm(s));
                json!({ "time_s": row.time_s, "speed_rpm": speed_rpm, "value": row.density })
            })
            .collect();
    }
    all
}

fn peak(line: &LabelledPeak, curve: &ChannelSpectrum, place: &str) -> Value {
    let mut all = json!({
        "value": line.value,
        "amplitude": line.amplitude,
        "amplitude_unit": curve.amplitude_unit,
        "signal_to_noise_db": line.signal_to_noise.map(decibels),
        "significant": line.significant,
        "names": line.names,
    });
    all[place] = json!(line.position);
    all
}

/// Spectrograms as maps, one for each channel; none of other spectra.
fn level_maps(found: &SpectrumResult) -> Vec<Plot> {
    let with_rows = |c: &&ChannelSpectrum| !c.spectrogram_rows.is_empty();
    let curves: Vec<&ChannelSpectrum> = found.channel_spectra.iter().filter(with_rows).collect();
    let height = if curves.len() == 1 {
        PLOT_HEIGHT
    } else {
        240.0
    };
    let map = |curve: &ChannelSpectrum| {
        let rows = &curve.spectrogram_rows;
        let (across, times, rows) = match curve.speed.is_empty() {
            true => (
                "time, s",
                rows.iter().map(|row| row.time_s).collect(),
                rows.iter().map(|row| row.density.clone()).collect(),
            ),
            false => over_speed(curve),
        };
        let decibel = |row: Vec<f64>| row.into_iter().map(decibels).collect();
        Plot {
            height,
            heading: curve.channel.clone(),
            map: Some(LevelMap {
                label: format!("dB re 1 {}", curve.unit),
                x: times,
                y: found.abscissa.clone(),
                columns: rows.into_iter().map(decibel).collect(),
                sparse: false,
            }),
            ..Plot::new(Axis::linear(across), Axis::linear("frequency, Hz"))
        }
    };
    curves.into_iter().map(map).collect()
}

/// Speed of the tacho over time, where the maps are over speed.
fn speed_plot(found: &SpectrumResult) -> Option<Plot> {
    let curve = (found.channel_spectra.iter()).find(|c| !c.speed.is_empty())?;
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

/// Columns of a map over speed, at most.
const SPEEDS: usize = 250;

/// Largest distance of a row from a column of a map over speed that it fills, columns: speeds between pulses of a tacho scatter.
const NEAR_COLUMNS: f64 = 3.0;

/// Rows of equal speed averaged, by rising speed in rpm.
fn over_speed(curve: &ChannelSpectrum) -> (&'static str, Vec<f64>, Vec<Vec<f64>>) {
    let ends =
        (curve.speed.iter()).fold((f64::INFINITY, 0.0f64), |(l, h), &s| (l.min(s), h.max(s)));
    let bins = SPEEDS.min(curve.spectrogram_rows.len()).max(1);
    let width = (ends.1 - ends.0) / bins as f64;
    let bin = |speed: f64| ((speed - ends.0) / width.max(f64::MIN_POSITIVE)) as usize;
    let order = rising_order(curve.speed.iter().copied());
    let mut means: Vec<(f64, Vec<f64>)> = Vec::new();
    for group in order.chunk_by(|&a, &b| bin(curve.speed[a]) == bin(curve.speed[b])) {
        let share = 1.0 / group.len() as f64;
        let speed = group.iter().map(|&at| share * curve.speed[at]).sum();
        let mut mean = vec![0.0; curve.spectrogram_rows[group[0]].density.len()];
        for &at in group {
            let both = mean.iter_mut().zip(&curve.spectrogram_rows[at].density);
            both.for_each(|(m, d)| *m += share * d);
        }
        means.push((speed, mean));
    }
    // Columns are even; one that no row fell into shows its neighbour, a gap of several stays.
    let column = |k: usize| {
        let middle = ends.0 + (k as f64 + 0.5) * width;
        let off = |mean: &(f64, Vec<f64>)| (mean.0 - middle).abs();
        let nearest = means.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(nearest) <= NEAR_COLUMNS * width).then(|| (rpm(middle), nearest.1.clone()))
    };
    let (speeds, rows) = (0..bins).filter_map(column).unzip();
    ("speed, rpm", speeds, rows)
}

/// Labels of one plot at most, the strongest lines first.
const LABELS: usize = 12;

/// The spectra as curves, the strongest lines labelled.
fn spectrum_plot(found: &SpectrumResult) -> Plot {
    let (across, unit) = found.abscissa_kind.label();
    let unit_of = |unit: &str| match unit {
        "" => String::new(),
        unit => format!(", {unit}"),
    };
    let spectra = &found.channel_spectra;
    let unit_of_values = unit_of(spectra.first().map_or("", |c| &c.unit));
    let up = match found.kind {
        SpectrumKind::Order | SpectrumKind::SynchronousAverage => {
            format!("amplitude{unit_of_values}")
        }
        kind_of => format!("{}{unit_of_values}", kind(kind_of)),
    };
    let mut strongest: Vec<&LabelledPeak> = spectra.iter().flat_map(|c| &c.peaks).collect();
    sort_falling(&mut strongest, |a| a.amplitude);
    strongest.truncate(LABELS);
    let text = |line: &LabelledPeak| match line.names.first() {
        Some(name) => format!("{} {name}", four_digits(line.position)),
        None => four_digits(line.position),
    };
    // What lies at the shortest quefrencies, the level of the spectrum, would hide the rest.
    let lowest = found.quefrency_range_s.map_or(f64::NEG_INFINITY, |s| s.0);
    let from = found.abscissa.partition_point(|p| *p < lowest);
    let curve = |(k, c): (usize, &ChannelSpectrum)| {
        let (x, y) = (found.abscissa[from..].to_vec(), c.value[from..].to_vec());
        Curve::line(&c.channel, Ink::Series(k), x, y)
    };
    let label = |line: &LabelledPeak| PointLabel {
        x: line.position,
        y: line.value,
        text: text(line),
    };
    let y = match found.kind {
        SpectrumKind::Density | SpectrumKind::Multitaper => Axis::log(up),
        _ => Axis::of_magnitudes(
            up,
            spectra.iter().flat_map(|c| c.value[from..].iter().copied()),
        ),
    };
    Plot {
        curves: spectra.iter().enumerate().map(curve).collect(),
        labels: strongest.into_iter().map(label).collect(),
        ..Plot::new(Axis::linear(format!("{across}{}", unit_of(unit))), y)
    }
}
