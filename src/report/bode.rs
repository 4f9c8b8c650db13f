//! Frequency responses as plots: magnitude, phase and coherence over frequency; measured against fitted; in the complex plane.

use super::axes::{linear_range, log_range};
use super::figure::{Axis, Curve, Guide, Ink, Mark, Plot, PlotColumn, PointLabel};
use super::svg::{LineStyle, hertz, truncate_label};
use crate::modes::mode::modulus;
use crate::numeric::Complex;
use crate::numeric::sorting::sort_falling;

/// One frequency response of a Bode plot, measured and fitted.
#[derive(Debug, Clone, Default)]
pub struct BodeCurve {
    /// Label of the curve.
    pub label: String,
    /// Unit of its values.
    pub unit: String,
    /// Measured values by line.
    pub measured: Vec<Complex>,
    /// They were computed on lines that follow the curve: drawn as a line.
    pub computed: bool,
    /// Fitted values on as many places between the lines as its path in the plane needs; empty without a fit.
    pub traced: Vec<Complex>,
    /// Fitted values by line.
    pub fitted: Option<Vec<Complex>>,
    /// Coherence by line.
    pub coherence: Option<Vec<f64>>,
}

/// Contents of a Bode plot.
#[derive(Debug, Clone, Default)]
pub struct BodePlot {
    /// Above it.
    pub title: String,
    /// Label of the abscissa; frequency in Hz where empty.
    pub across: &'static str,
    /// Lines, in the unit of what it is over.
    pub frequency_hz: Vec<f64>,
    /// Responses; the first few are drawn.
    pub curves: Vec<BodeCurve>,
    /// Identified natural frequencies, Hz.
    pub modes_hz: Vec<f64>,
}

/// Responses drawn at once: more cannot be distinguished.
const MAX_COUNT: usize = 4;

/// Magnitude, phase and, where it was measured, coherence.
pub fn bode(shown: &BodePlot) -> PlotColumn {
    let curves = &shown.curves[..shown.curves.len().min(MAX_COUNT)];
    let across = match shown.across {
        "" => "frequency, Hz",
        across => across,
    };
    let plot = |y: Axis, height: f64, curves: Vec<Curve>| Plot {
        height,
        guides: shown.modes_hz.iter().map(|f| Guide::vertical(*f)).collect(),
        curves,
        empty: "no response",
        ..Plot::new(Axis::linear(across), y)
    };
    let both = |of: &dyn Fn(&Complex) -> f64, wraps: bool| {
        let lines = curves.iter().enumerate().flat_map(|(k, c)| {
            let over = |ink, width, name: String, values: &[Complex]| {
                let y = values.iter().map(of).collect();
                let mark = Mark::Line(width, LineStyle::Solid);
                let curve = Curve::new(name, ink, mark, shown.frequency_hz.clone(), y);
                if wraps { broken(curve) } else { curve }
            };
            let name = truncate_label(&c.label, 28);
            match &c.fitted {
                None => vec![over(Ink::Series(k), 1.0, name, &c.measured)],
                Some(fitted) => {
                    let pairs = c.measured.iter().zip(fitted);
                    let misfit: Vec<Complex> = pairs.map(|(a, b)| a - b).collect();
                    let dotted = Mark::Line(0.8, LineStyle::Dotted);
                    let misfit = Curve {
                        mark: dotted,
                        ..over(Ink::Series(k), 0.8, String::new(), &misfit)
                    };
                    let both = [
                        over(Ink::Pale(k), 2.2, String::new(), &c.measured),
                        over(Ink::Series(k), 1.0, name, fitted),
                    ];
                    // The phase of a misfit says nothing.
                    both.into_iter().chain((!wraps).then_some(misfit)).collect()
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
        plot(magnitude, 230.0, both(&|z| z.norm(), false)),
        plot(phase, 110.0, both(&|z| z.arg().to_degrees(), true)),
    ];
    let coherence = curves.iter().enumerate().filter_map(|(k, c)| {
        let y = c.coherence.clone()?;
        Some(Curve::line(
            "",
            Ink::Series(k),
            shown.frequency_hz.clone(),
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
    let upright = match (shown.modes_hz.is_empty(), is_fitted) {
        (true, _) => "",
        (false, true) => "upright: modes",
        (false, false) => "upright: peaks",
    };
    let widths = "broad and pale: measured, narrow: fitted, dotted: size of their difference";
    PlotColumn {
        title: shown.title.clone(),
        note: note(shown, curves, [widths, upright]),
        linked: true,
        plots,
        ..PlotColumn::default()
    }
}

/// A curve interrupted where it wraps from −180° to 180°.
fn broken(curve: Curve) -> Curve {
    let (mut x, mut y) = (
        Vec::with_capacity(curve.x.len()),
        Vec::with_capacity(curve.y.len()),
    );
    for (k, (&at, &phase)) in curve.x.iter().zip(&curve.y).enumerate() {
        if k > 0 && (phase - curve.y[k - 1]).abs() > 180.0 {
            x.push(at);
            y.push(f64::NAN);
        }
        x.push(at);
        y.push(phase);
    }
    Curve { x, y, ..curve }
}

/// Meaning of the widths, and how many responses are not shown.
fn note(shown: &BodePlot, curves: &[BodeCurve], [widths, upright]: [&str; 2]) -> String {
    let fitted = curves.iter().any(|c| c.fitted.is_some());
    let all = shown.curves.len();
    let part = match all > curves.len() {
        true => format!("{} of {all} responses", curves.len()),
        false => String::new(),
    };
    let notes = [if fitted { widths } else { "" }, upright, &part];
    let notes: Vec<&str> = notes.into_iter().filter(|n| !n.is_empty()).collect();
    notes.join("; ")
}

/// Frequencies named on a Nyquist plot.
const MARKS: usize = 6;

/// Frequencies of the first response where it is largest: at the identified modes, else at its peaks.
fn frequency_marks(shown: &BodePlot) -> Vec<PointLabel> {
    let Some(curve) = shown.curves.first().filter(|_| shown.across.is_empty()) else {
        return Vec::new();
    };
    let size = |i: usize| curve.measured.get(i).map_or(f64::NAN, |z| modulus(*z));
    let count = shown.frequency_hz.len().min(curve.measured.len());
    let nearest = |f: &f64| {
        let lines = shown.frequency_hz.iter().enumerate().take(count);
        lines
            .min_by(|a, b| (a.1 - f).abs().total_cmp(&(b.1 - f).abs()))
            .map(|l| l.0)
    };
    let mut lines: Vec<usize> = match shown.modes_hz.is_empty() {
        false => shown.modes_hz.iter().filter_map(nearest).collect(),
        true => (1..count.saturating_sub(1))
            .filter(|&i| size(i) > size(i - 1) && size(i) >= size(i + 1))
            .collect(),
    };
    lines.retain(|&i| size(i).is_finite());
    sort_falling(&mut lines, |&a| size(a));
    lines.dedup();
    lines.truncate(MARKS);
    let label = |i: usize| PointLabel {
        x: curve.measured[i].re,
        y: curve.measured[i].im,
        text: hertz(shown.frequency_hz[i]),
    };
    lines.into_iter().map(label).collect()
}

/// The responses in the complex plane, equal scales; points measured, lines fitted or computed.
pub fn nyquist(shown: &BodePlot) -> PlotColumn {
    let curves = &shown.curves[..shown.curves.len().min(MAX_COUNT)];
    let parts = |values: &[Complex]| -> (Vec<f64>, Vec<f64>) {
        let known = values.iter().filter(|z| z.is_finite());
        known.map(|z| (z.re, z.im)).unzip()
    };
    let frequencies = |values: &[Complex]| {
        let lines = values.iter().zip(&shown.frequency_hz);
        let known = lines.filter(|(z, _)| z.is_finite());
        ("frequency, Hz", known.map(|(_, f)| *f).collect())
    };
    let lines = curves.iter().enumerate().flat_map(|(k, c)| {
        let mark = match c.computed {
            true => Mark::Line(1.2, LineStyle::Solid),
            false => Mark::Discs(1.1),
        };
        let (x, y) = parts(&c.measured);
        let measured = Curve {
            along: shown.across.is_empty().then(|| frequencies(&c.measured)),
            ..Curve::new(truncate_label(&c.label, 28), Ink::Series(k), mark, x, y)
        };
        let (x, y) = parts(&c.traced);
        let traced = (!c.traced.is_empty()).then(|| Curve::line("", Ink::Series(k), x, y));
        [Some(measured), traced].into_iter().flatten()
    });
    let lines: Vec<Curve> = lines.collect();
    let axis = |name: &str, of: fn(&Curve) -> &[f64]| Axis {
        range: linear_range(lines.iter().flat_map(|c| of(c).iter().copied())),
        ..Axis::linear(name)
    };
    let unit = curves.first().map_or("", |c| c.unit.as_str());
    let common = !unit.is_empty() && curves.iter().all(|c| c.unit == unit);
    let unit = if common {
        format!(", {unit}")
    } else {
        String::new()
    };
    let plot = Plot {
        height: 560.0,
        equal_scales: true,
        labels: frequency_marks(shown),
        empty: "no response",
        ..Plot::new(
            axis(&format!("real part{unit}"), |c| &c.x),
            axis(&format!("imaginary part{unit}"), |c| &c.y),
        )
    };
    PlotColumn {
        note: note(
            shown,
            curves,
            ["broad and pale: measured, narrow: fitted", ""],
        ),
        ..PlotColumn::one(
            &shown.title,
            Plot {
                curves: lines,
                ..plot
            },
        )
    }
}
