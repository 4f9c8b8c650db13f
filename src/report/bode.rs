//! Bode and Nyquist plots of frequency responses, measured and fitted: magnitude, phase and coherence; the complex plane.

use super::axes::{linear_range, log_range};
use super::figure::{Axis, Curve, Guide, Ink, Mark, Plot, PlotColumn, PointLabel};
use super::svg::{LineStyle, hertz, truncate_label};
use crate::modes::mode::modulus;
use crate::numeric::Complex;
use crate::numeric::sorting::sort_descending;

/// One frequency response of a Bode plot, measured and fitted.
#[derive(Debug, Clone, Default)]
pub struct BodeCurve {
    /// Label of the curve.
    pub label: String,
    /// Unit of the values.
    pub unit: String,
    /// Measured values, one per frequency line.
    pub measured: Vec<Complex>,
    /// Values are computed on refined lines and drawn as a line; measured values are drawn as points.
    pub is_computed: bool,
    /// Fitted values at the refined frequencies of the Nyquist plot; empty without a fit.
    pub fit_path: Vec<Complex>,
    /// Fitted values, one per frequency line.
    pub fitted: Option<Vec<Complex>>,
    /// Coherence, 0 to 1, one per frequency line.
    pub coherence: Option<Vec<f64>>,
}

/// Contents of a Bode plot.
#[derive(Debug, Clone, Default)]
pub struct BodePlot {
    /// Title above the plot.
    pub title: String,
    /// Abscissa label; empty for frequency in Hz.
    pub abscissa_label: &'static str,
    /// Abscissa values of the lines, in the unit of the abscissa label.
    pub frequency_hz: Vec<f64>,
    /// Responses; the first four are drawn.
    pub curves: Vec<BodeCurve>,
    /// Identified natural frequencies, Hz.
    pub modes_hz: Vec<f64>,
}

/// Largest number of responses drawn; more cannot be distinguished.
const MAX_CURVES: usize = 4;

/// Bode plot: magnitude, phase and, if measured, coherence.
pub fn bode(data: &BodePlot) -> PlotColumn {
    let curves = &data.curves[..data.curves.len().min(MAX_CURVES)];
    let abscissa_label = match data.abscissa_label {
        "" => "frequency, Hz",
        label => label,
    };
    let plot = |y: Axis, height: f64, curves: Vec<Curve>| Plot {
        height,
        guides: data.modes_hz.iter().map(|f| Guide::vertical(*f)).collect(),
        curves,
        empty: "no response",
        ..Plot::new(Axis::linear(abscissa_label), y)
    };
    let curves_of = |component: &dyn Fn(&Complex) -> f64, wraps: bool| {
        let lines = curves.iter().enumerate().flat_map(|(k, c)| {
            let curve_of = |ink, width, name: String, values: &[Complex]| {
                let y = values.iter().map(component).collect();
                let mark = Mark::Line(width, LineStyle::Solid);
                let curve = Curve::new(name, ink, mark, data.frequency_hz.clone(), y);
                if wraps { break_at_wraps(curve) } else { curve }
            };
            let name = truncate_label(&c.label, 28);
            match &c.fitted {
                None => vec![curve_of(Ink::Series(k), 1.0, name, &c.measured)],
                Some(fitted) => {
                    let pairs = c.measured.iter().zip(fitted);
                    let misfit: Vec<Complex> = pairs.map(|(a, b)| a - b).collect();
                    let dotted = Mark::Line(0.8, LineStyle::Dotted);
                    let misfit = Curve {
                        mark: dotted,
                        ..curve_of(Ink::Series(k), 0.8, String::new(), &misfit)
                    };
                    let pair = [
                        curve_of(Ink::Pale(k), 2.2, String::new(), &c.measured),
                        curve_of(Ink::Series(k), 1.0, name, fitted),
                    ];
                    // The phase of a misfit carries no information.
                    pair.into_iter().chain((!wraps).then_some(misfit)).collect()
                }
            }
        });
        lines.collect::<Vec<_>>()
    };
    let units: Vec<&str> = (curves.iter().map(|c| c.unit.as_str()))
        .filter(|u| !u.is_empty())
        .collect();
    let unit = match units.first() {
        Some(unit) if units.iter().all(|u| u == unit) => format!("magnitude, {unit}"),
        _ => "magnitude".to_string(),
    };
    let measured = curves
        .iter()
        .flat_map(|c| c.measured.iter().map(|z| z.norm()));
    let magnitude = Axis {
        range: log_range(measured).map(|(low, high)| (10f64.powf(low), 10f64.powf(high))),
        ..Axis::log(unit)
    };
    let phase = Axis {
        ticks: vec![-180.0, -90.0, 0.0, 90.0, 180.0],
        ..Axis::linear("phase, deg").over(-190.0, 190.0)
    };
    let mut plots = vec![
        plot(magnitude, 230.0, curves_of(&|z| z.norm(), false)),
        plot(phase, 110.0, curves_of(&|z| z.arg().to_degrees(), true)),
    ];
    let coherence = curves.iter().enumerate().filter_map(|(k, c)| {
        let y = c.coherence.clone()?;
        Some(Curve::line(
            "",
            Ink::Series(k),
            data.frequency_hz.clone(),
            y,
        ))
    });
    let coherence: Vec<Curve> = coherence.collect();
    if !coherence.is_empty() {
        let axis = Axis {
            ticks: vec![0.0, 0.5, 1.0],
            ..Axis::linear("coherence").over(0.0, 1.05)
        };
        plots.push(plot(axis, 70.0, coherence));
    }
    let is_fitted = curves.iter().any(|c| c.fitted.is_some());
    let mode_note = match (data.modes_hz.is_empty(), is_fitted) {
        (true, _) => "",
        (false, true) => "upright: modes",
        (false, false) => "upright: peaks",
    };
    let line_note = "broad and pale: measured, narrow: fitted, dotted: size of their difference";
    PlotColumn {
        title: data.title.clone(),
        note: note(data, curves, [line_note, mode_note]),
        linked: true,
        plots,
        ..PlotColumn::default()
    }
}

/// Interrupts a phase curve where it wraps from −180° to 180°.
fn break_at_wraps(curve: Curve) -> Curve {
    let (mut x, mut y) = (
        Vec::with_capacity(curve.x.len()),
        Vec::with_capacity(curve.y.len()),
    );
    for (k, (&frequency, &phase)) in curve.x.iter().zip(&curve.y).enumerate() {
        if k > 0 && (phase - curve.y[k - 1]).abs() > 180.0 {
            x.push(frequency);
            y.push(f64::NAN);
        }
        x.push(frequency);
        y.push(phase);
    }
    Curve { x, y, ..curve }
}

/// Note on the line styles and, if some responses are omitted, on the number drawn.
fn note(data: &BodePlot, curves: &[BodeCurve], [line_note, mode_note]: [&str; 2]) -> String {
    let is_fitted = curves.iter().any(|c| c.fitted.is_some());
    let n_responses = data.curves.len();
    let omitted = match n_responses > curves.len() {
        true => format!("{} of {n_responses} responses", curves.len()),
        false => String::new(),
    };
    let notes = [if is_fitted { line_note } else { "" }, mode_note, &omitted];
    let notes: Vec<&str> = notes.into_iter().filter(|n| !n.is_empty()).collect();
    notes.join("; ")
}

/// Largest number of frequencies labelled on a Nyquist plot.
const MAX_MARKS: usize = 6;

/// Frequency labels of the first response at its largest magnitudes: at the identified modes, else at its peaks.
fn frequency_marks(data: &BodePlot) -> Vec<PointLabel> {
    let Some(curve) = data
        .curves
        .first()
        .filter(|_| data.abscissa_label.is_empty())
    else {
        return Vec::new();
    };
    let magnitude = |i: usize| curve.measured.get(i).map_or(f64::NAN, |z| modulus(*z));
    let count = data.frequency_hz.len().min(curve.measured.len());
    let nearest_line = |f: &f64| {
        let lines = data.frequency_hz.iter().enumerate().take(count);
        lines
            .min_by(|a, b| (a.1 - f).abs().total_cmp(&(b.1 - f).abs()))
            .map(|l| l.0)
    };
    let mut lines: Vec<usize> = match data.modes_hz.is_empty() {
        false => data.modes_hz.iter().filter_map(nearest_line).collect(),
        true => (1..count.saturating_sub(1))
            .filter(|&i| magnitude(i) > magnitude(i - 1) && magnitude(i) >= magnitude(i + 1))
            .collect(),
    };
    lines.retain(|&i| magnitude(i).is_finite());
    sort_descending(&mut lines, |&a| magnitude(a));
    lines.dedup();
    lines.truncate(MAX_MARKS);
    let label = |i: usize| PointLabel {
        x: curve.measured[i].re,
        y: curve.measured[i].im,
        text: hertz(data.frequency_hz[i]),
    };
    lines.into_iter().map(label).collect()
}

/// Nyquist plot with equal scales: measured responses as points, fitted or computed ones as lines.
pub fn nyquist(data: &BodePlot) -> PlotColumn {
    let curves = &data.curves[..data.curves.len().min(MAX_CURVES)];
    let coordinates = |values: &[Complex]| -> (Vec<f64>, Vec<f64>) {
        let finite = values.iter().filter(|z| z.is_finite());
        finite.map(|z| (z.re, z.im)).unzip()
    };
    let frequencies = |values: &[Complex]| {
        let lines = values.iter().zip(&data.frequency_hz);
        let finite = lines.filter(|(z, _)| z.is_finite());
        ("frequency, Hz", finite.map(|(_, f)| *f).collect())
    };
    let lines = curves.iter().enumerate().flat_map(|(k, c)| {
        let mark = match c.is_computed {
            true => Mark::Line(1.2, LineStyle::Solid),
            false => Mark::Discs(1.1),
        };
        let (x, y) = coordinates(&c.measured);
        let measured = Curve {
            along: data
                .abscissa_label
                .is_empty()
                .then(|| frequencies(&c.measured)),
            ..Curve::new(truncate_label(&c.label, 28), Ink::Series(k), mark, x, y)
        };
        let (x, y) = coordinates(&c.fit_path);
        let traced = (!c.fit_path.is_empty()).then(|| Curve::line("", Ink::Series(k), x, y));
        [Some(measured), traced].into_iter().flatten()
    });
    let lines: Vec<Curve> = lines.collect();
    let axis = |name: &str, values_of: fn(&Curve) -> &[f64]| Axis {
        range: linear_range(lines.iter().flat_map(|c| values_of(c).iter().copied())),
        ..Axis::linear(name)
    };
    let unit = curves.first().map_or("", |c| c.unit.as_str());
    let has_common_unit = !unit.is_empty() && curves.iter().all(|c| c.unit == unit);
    let unit = if has_common_unit {
        format!(", {unit}")
    } else {
        String::new()
    };
    let plot = Plot {
        height: 560.0,
        equal_scales: true,
        labels: frequency_marks(data),
        empty: "no response",
        ..Plot::new(
            axis(&format!("real part{unit}"), |c| &c.x),
            axis(&format!("imaginary part{unit}"), |c| &c.y),
        )
    };
    PlotColumn {
        note: note(
            data,
            curves,
            ["broad and pale: measured, narrow: fitted", ""],
        ),
        ..PlotColumn::one(
            &data.title,
            Plot {
                curves: lines,
                ..plot
            },
        )
    }
}
