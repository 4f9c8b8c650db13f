//! Report of identified modes and transfer functions: JSON document, tables, figures.

use std::f64::consts::TAU;

use serde_json::{Map, Value, json};

use super::bode::{self, BodeCurve, BodePlot};
use super::fdd_plot::{self, FddPlot, PlottedBell};
use super::figure::Figure;
use super::identification_table::{self, auto_mac};
use super::json::complex;
use super::mac_plot;
use super::mode_tracking;
use super::number_format::four_digits;
use super::point_shapes;
use super::pole_plots::{self, PlottedStability, StabilisationPlot};
use super::presentation::{LogReport, Presentation, Provenance};
use super::table::{Table, exact, or_blank};
use super::view::View;
use crate::base::error::Error;
use crate::base::quantity::quotient_unit;
use crate::identify::compare;
use crate::identify::modal::stabilisation::PoleStability;
use crate::identify::operational::fdd::DECAY_RANGE;
use crate::identify::transfer::function::TransferFunction;
use crate::numeric::Complex;
use crate::plan::logs::diagnostics::{coherence_at, window_damping_ratio};
use crate::plan::logs::frf_estimation::HitSummary;
use crate::plan::logs::identification_result::{
    Evidence, IdentificationResult, IdentifiedHarmonic, IdentifiedMode, PickedPeak, PointShapes,
};
use crate::plan::logs::method::structure_text;
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponse};

impl Presentation for LogReport<IdentificationResult> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_log(&self.result.trace, &self.repairs, &self.result.diagnostics)
    }

    fn body(&self) -> Result<Value, Error> {
        let result = &self.result;
        let functions = (result.functions.iter())
            .map(TransferFunction::to_json)
            .collect::<Result<Vec<Value>, Error>>()?;
        let fit = result.fit();
        let hits = result.hits.iter().map(|h| json!({ "file": h.moment.file, "time_s": h.moment.time_s, "peak": h.peak, "used": h.fault.is_none(), "fault": h.fault_text }));
        let rejected = result.rejected_poles();
        let rejected = (rejected.iter())
            .map(|(pole, reason)| json!({ "pole_rad_s": complex(*pole), "reason": reason }));
        Ok(json!({
            "method": result.method.name(),
            "rule": result.selection_rule,
            "method_text": result.method_text,
            "band_hz": [result.band_hz.0, result.band_hz.1],
            "hits": hits.collect::<Vec<_>>(),
            "averages": result.responses.as_ref().and_then(|r| r.averages),
            "driving_point": result.driving_point.as_ref().map(|d| json!({ "input": d.input, "output": d.output, "modal_mass_unit": d.unit })),
            "reciprocity": result.reciprocity.iter().map(|r| json!({ "first": { "output": r.first.0, "input": r.first.1 }, "second": { "output": r.second.0, "input": r.second.1 }, "difference": r.difference, "explained": r.explained, "beyond_noise": r.exceeds_noise() })).collect::<Vec<_>>(),
            "window_decay_1_s": result.window_decay(),
            "modes": result.modes.iter().enumerate().map(|(k, m)| mode(result, k, m, result.point_shapes.as_ref())).collect::<Vec<_>>(),
            "weak_modes": result.weak.iter().enumerate().map(|(k, m)| mode(result, k, m, None)).collect::<Vec<_>>(),
            "harmonics": result.harmonics.iter().map(|h| harmonic(result, h)).collect::<Vec<_>>(),
            "omitted": rejected.collect::<Vec<_>>(),
            "tracking": result.tracking().map_or(Value::Array(Vec::new()), mode_tracking::json),
            "evidence": evidence(&result.evidence),
            "tests": tests(&result.evidence),
            "chi2": fit.map(|f| f.chi2),
            "degrees_of_freedom": fit.map(|f| f.dof),
            "delay_s": fit.map_or(&[][..], |f| &f.delay_s),
            "delay_std_s": fit.map_or(&[][..], |f| &f.delay_std_s),
            "fit_error": result.fit_error,
            "frac": synthesis_errors(result).iter().map(|s| s.0).collect::<Vec<_>>(),
            "auto_mac": auto_mac(result),
            "comparison": result.comparison.as_ref().map(|reference| mac_plot::json(result, reference)),
            "geometry": result.point_shapes.as_ref().map(point_shapes::geometry_json),
            "transfer_functions": functions,
        }))
    }

    fn text(&self) -> String {
        let reference = self.result.comparison.as_ref();
        let compared = or_blank(reference, |r| mac_plot::text(&self.result, r));
        identification_table::text(&self.result) + &compared
    }

    fn table(&self) -> Table<'_> {
        match self.result.tracking() {
            Some(tracking) => mode_tracking::points_table(tracking),
            None => modes_table(&self.result),
        }
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let (result, name) = (&self.result, &self.title);
        let diagram = stabilisation_diagram(result, name).map(|d| pole_plots::stabilisation(&d));
        let Some(data) = curves(result, name) else {
            let tracks = result
                .tracking()
                .map(|c| mode_tracking::figure(c, &format!("{name}: modes over the record")));
            let peaks = || decomposition(result, name).map(|data| fdd_plot::figure(&data));
            let poles = || {
                let poles: Vec<_> = result.modes.iter().map(|m| m.mode.pole).collect();
                pole_plots::pole_zero(&format!("{name}: poles"), &poles, &[])
            };
            let plot = tracks.or(diagram).or_else(peaks).unwrap_or_else(poles);
            let mut figures = vec![Figure::first(plot)];
            figures.extend(shape_figures(result, name));
            return Ok(figures);
        };
        let transfer = result.functions.first();
        let poles = transfer.map_or(Vec::new(), |f| f.poles().to_vec());
        let zeros = transfer.map(TransferFunction::zeros).transpose()?;
        let zeros = zeros.map_or(Vec::new(), |z| z.zeros);
        let title = match result.outputs.first() {
            Some(output) => format!("{name}: poles of all responses, zeros of {}", output.name),
            None => name.to_string(),
        };
        let mut figures = vec![
            Figure::first(bode::bode(&data)),
            Figure::new("nyquist", bode::nyquist(&data)),
            Figure::new("poles", pole_plots::pole_zero(&title, &poles, &zeros)),
        ];
        figures.extend(diagram.map(|plots| Figure::new("stabilisation", plots)));
        figures.extend(shape_figures(result, name));
        Ok(figures)
    }

    fn views(&self) -> Vec<View> {
        let shapes = self
            .result
            .point_shapes
            .as_ref()
            .filter(|_| !self.result.modes.is_empty());
        shapes
            .map(|s| point_shapes::view(&self.result, s))
            .into_iter()
            .collect()
    }

    fn notes(&self) -> String {
        let line = |hit: &HitSummary| {
            let fault = hit.fault_text.as_ref()?;
            let file = or_blank(hit.moment.file.as_ref(), |f| format!(" of {f}"));
            Some(format!(
                "hit at {:.4} s{file} rejected: {fault}\n",
                hit.moment.time_s
            ))
        };
        self.result.hits.iter().filter_map(line).collect()
    }
}

/// Figures of the mode shapes on the test points and of the MAC matrix, if available.
fn shape_figures(result: &IdentificationResult, name: &str) -> Vec<Figure> {
    if result.modes.is_empty() {
        return Vec::new();
    }
    let shapes = result.point_shapes.as_ref().map(|shapes| {
        let drawing = point_shapes::draw(result, shapes, &format!("{name}: mode shapes"));
        Figure::new("shapes", drawing)
    });
    let mac = result.comparison.as_ref().map(|r| {
        let drawing = mac_plot::draw(result, r, &format!("{name}: modal assurance criterion"));
        Figure::new("mac", drawing)
    });
    shapes.into_iter().chain(mac).collect()
}

fn mode(
    result: &IdentificationResult,
    k: usize,
    mode: &IdentifiedMode,
    shapes: Option<&PointShapes>,
) -> Value {
    let frequency = mode.frequency_hz();
    let by_channel = |terminals: &[ChannelLabel], values: &[Complex]| -> Map<String, Value> {
        let names = terminals.iter().map(|t| t.name.clone());
        names.zip(values.iter().map(|&z| complex(z))).collect()
    };
    let has_participation = !mode.participation.is_empty();
    let decay = result.window_decay();
    let shape = mode.mode.shape.as_slice();
    let has_shape = shape.len() > 1;
    let kurtosis = mode.harmonic.as_ref().map(|h| h.envelope_kurtosis);
    json!({
        "mode": k + 1,
        "frequency_hz": frequency,
        "frequency_std_hz": mode.mode.frequency_std_hz(),
        "damped_frequency_hz": mode.has_damping.then(|| mode.mode.damped_frequency_hz()),
        "damping_ratio": mode.damping_ratio(),
        "damping_std": mode.mode.damping_std(),
        "window_damping": (decay > 0.0).then(|| window_damping_ratio(decay, frequency)),
        "pole_rad_s": mode.has_damping.then(|| complex(mode.mode.pole)),
        "coherence": result.responses.as_ref().and_then(|r| coherence_at(r, frequency)),
        "presence": mode.presence,
        "scatter_hz": mode.scatter_hz,
        "weak": mode.weak,
        "model_error": mode.departure.map(|d| d.model_error),
        "frequency_spread_hz": mode.departure.map(|d| d.frequency_spread_hz),
        "damping_spread": mode.departure.map(|d| d.damping_spread),
        "envelope_kurtosis": kurtosis,
        "on_order": mode.on_order,
        "on_mains": mode.on_mains.map(|(mains, multiple)| json!({"mains_hz": mains, "multiple": multiple})),
        "phase_collinearity": has_shape.then(|| compare::phase_collinearity(shape)),
        "mean_phase_rad": has_shape.then(|| compare::mean_phase(shape)),
        "mean_phase_deviation_rad": has_shape.then(|| compare::mean_phase_deviation(shape)),
        "complexity": has_shape.then(|| compare::off_axis_share(shape)),
        "shape": by_channel(&result.outputs, &mode.mode.shape),
        "shape_on_points": shapes.map(|shapes| point_shapes::shape_json(shapes, k)),
        "modal_mass": mode.modal_mass.map(complex),
        "participation": has_participation.then(|| by_channel(&result.inputs, &mode.participation)),
    })
}

fn harmonic(result: &IdentificationResult, harmonic: &IdentifiedHarmonic) -> Value {
    let names = result.outputs.iter().map(|t| t.name.clone());
    let amplitude: Map<String, Value> = names
        .zip(harmonic.amplitude.iter().map(|&a| json!(a)))
        .collect();
    json!({
        "frequency_hz": harmonic.frequency_hz,
        "order": harmonic.order,
        "amplitude": (!amplitude.is_empty()).then_some(amplitude),
        "probability": harmonic.probability,
        "envelope_kurtosis": harmonic.envelope_kurtosis,
        "reason": harmonic.reason,
    })
}

/// FRAC of measured and fitted values, and their relative difference, for each response inside the band.
fn synthesis_errors(result: &IdentificationResult) -> Vec<(f64, Option<f64>)> {
    let Some(plot) = curves(result, "") else {
        return Vec::new();
    };
    let errors = |c: &BodeCurve| {
        let fitted = c.fitted.as_ref()?;
        let pairs: (Vec<Complex>, Vec<Complex>) = (c.measured.iter().zip(fitted)).unzip();
        let error = compare::synthesis_error(&pairs.0, &pairs.1);
        Some((compare::frac(&pairs.0, &pairs.1), error))
    };
    plot.curves.iter().filter_map(errors).collect()
}

/// Evidence for the modes, one entry per trial.
fn evidence(evidence: &Evidence) -> Value {
    match evidence {
        Evidence::Rational(fit) => fit.evidence.iter().map(|s| json!({ "pole_pairs_before": s.poles_before, "pole_pairs": s.poles_after, "chi2_before": s.chi2_before, "chi2": s.chi2_after, "probability": s.probability, "accepted": s.accepted, "reason": s.reason })).collect(),
        Evidence::Diagram(diagram) => diagram.poles.iter().map(|p| json!({ "order": p.order, "frequency_hz": p.frequency_hz, "damping_ratio": p.damping_ratio, "stability": stability_word(p.stability) })).collect(),
        Evidence::Peaks(peaks) => peaks.peaks.iter().map(|p| json!({ "frequency_hz": p.frequency_hz, "prominence": p.prominence, "half_power": p.half_power.map(|(f, d)| json!({ "frequency_hz": f, "damping_ratio": d })), "bell_hz": bell_hz(p), "reason": p.reason })).collect(),
        Evidence::Orders(orders) => orders.candidates.iter().map(|c| json!({ "model": structure_text(c.family), "error_variance": c.error_variance, "aic": c.aic, "bic": c.bic, "mdl": c.mdl, "accepted": c.family == orders.chosen })).collect(),
        Evidence::Tracking(tracking) => mode_tracking::trials(tracking),
    }
}

/// First and last frequency of the spectral bell of a peak, Hz.
fn bell_hz(peak: &PickedPeak) -> Option<[f64; 2]> {
    let lines = &peak.bell.as_ref()?.lines;
    Some([lines.first()?.0, lines.last()?.0])
}

fn tests(evidence: &Evidence) -> Value {
    match evidence {
        Evidence::Orders(orders) => orders.tests.iter().map(|(name, t)| json!({ "residuals": name, "statistic": t.statistic, "degrees_of_freedom": t.dof, "probability": t.probability })).collect(),
        _ => Value::Array(Vec::new()),
    }
}

fn stability_word(stability: PoleStability) -> &'static str {
    match stability {
        PoleStability::New => "new",
        PoleStability::Frequency => "frequency",
        PoleStability::Damping => "damping",
        PoleStability::Shape => "shape",
        PoleStability::Stable => "stable",
    }
}

/// Table of modes, one row per mode.
fn modes_table(result: &IdentificationResult) -> Table<'static> {
    let mut table =
        Table::new("mode|frequency_hz|frequency_std_hz|damping_ratio|damping_std|coherence");
    for output in &result.outputs {
        let part = |part| format!("{} {part}", output.name);
        table = table.column(&part("re"), "").column(&part("im"), "");
    }
    let has_mass = result.driving_point.is_some();
    let mut table = table.columns_if(has_mass, "modal_mass_re|modal_mass_im");
    let parts = |z: Option<Complex>| [z.map(|z| z.re), z.map(|z| z.im)].map(|x| or_blank(x, exact));
    for (k, m) in result.modes.iter().enumerate() {
        let responses = result.responses.as_ref();
        let coherence = responses.and_then(|r| coherence_at(r, m.frequency_hz()));
        let mut cells = vec![
            (k + 1).to_string(),
            exact(m.frequency_hz()),
            or_blank(m.mode.frequency_std_hz(), exact),
            or_blank(m.damping_ratio(), exact),
            or_blank(m.mode.damping_std(), exact),
            or_blank(coherence, exact),
        ];
        // Cells of the shape are blank for a method without shapes.
        let shape = |k: usize| m.mode.shape.get(k).copied();
        cells.extend((0..result.outputs.len()).flat_map(|k| parts(shape(k))));
        if has_mass {
            cells.extend(parts(m.modal_mass));
        }
        table.row(cells);
    }
    table
}

/// Measured and fitted responses inside the band; `None` for a method that identifies from signals.
fn curves(result: &IdentificationResult, title: &str) -> Option<BodePlot> {
    let responses = result.responses.as_ref()?;
    let (low, high) = result.band_hz;
    let lines: Vec<usize> = (0..responses.frequency_hz.len())
        .filter(|&k| (low..=high).contains(&responses.frequency_hz[k]))
        .collect();
    let hz = |&k: &usize| responses.frequency_hz[k];
    let synthesised: Vec<Vec<Complex>> = lines.iter().map(|k| result.synthesise(hz(k))).collect();
    let fitted = |i: usize| -> Option<Vec<Complex>> {
        synthesised.iter().map(|v| v.get(i).copied()).collect()
    };
    let path: Vec<Vec<Complex>> =
        (plot_frequencies(result, &lines.iter().map(hz).collect::<Vec<f64>>()))
            .into_iter()
            .map(|f| result.synthesise(f))
            .collect();
    let traced = |i: usize| path.iter().filter_map(|v| v.get(i).copied()).collect();
    let curve = |(i, f): (usize, &FrequencyResponse)| BodeCurve {
        fit_path: traced(i),
        label: label(f),
        unit: unit(f),
        measured: lines.iter().map(|&k| f.values[k]).collect(),
        fitted: fitted(i),
        is_computed: false,
        coherence: f
            .coherence
            .as_ref()
            .map(|c| lines.iter().map(|&k| c[k]).collect()),
    };
    Some(BodePlot {
        title: title.to_string(),
        abscissa_label: "",
        frequency_hz: lines.iter().map(hz).collect(),
        curves: responses.responses.iter().enumerate().map(curve).collect(),
        modes_hz: result
            .modes
            .iter()
            .map(IdentifiedMode::frequency_hz)
            .collect(),
    })
}

/// Plot frequencies, Hz: the lines, and about every mode frequencies equally spaced in angle on its modal circle, `f − f₀ ∝ tan(θ/2)`.
fn plot_frequencies(result: &IdentificationResult, lines: &[f64]) -> Vec<f64> {
    const ANGLES: i32 = 60;
    let (Some(&low), Some(&high)) = (lines.first(), lines.last()) else {
        return Vec::new();
    };
    let circle = |m: &IdentifiedMode| {
        let (f, half_width) = (m.mode.damped_frequency_hz(), m.mode.pole.re.abs() / TAU);
        let step = std::f64::consts::PI / f64::from(2 * ANGLES);
        (1 - ANGLES..ANGLES).map(move |k| f + half_width * (f64::from(k) * step).tan())
    };
    let mut frequencies: Vec<f64> = (result.modes.iter().filter(|m| m.has_damping))
        .flat_map(circle)
        .filter(|f| (low..=high).contains(f))
        .chain(lines.iter().copied())
        .collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies
}

/// Stabilisation diagram; `None` for a method without a sweep of orders.
fn stabilisation_diagram(result: &IdentificationResult, name: &str) -> Option<StabilisationPlot> {
    let Evidence::Diagram(diagram) = &result.evidence else {
        return None;
    };
    let stability = |s: PoleStability| match s {
        PoleStability::Stable => PlottedStability::Stable,
        PoleStability::New => PlottedStability::New,
        _ => PlottedStability::Frequency,
    };
    let in_band = |f: &f64| (result.band_hz.0..=result.band_hz.1).contains(f);
    let level = diagram
        .level
        .0
        .iter()
        .zip(&diagram.level.1)
        .filter(|(f, _)| in_band(f));
    Some(StabilisationPlot {
        title: format!("{name}: poles by {}", result.method.name()),
        poles: diagram
            .poles
            .iter()
            .map(|p| (p.order, p.frequency_hz, stability(p.stability)))
            .collect(),
        selected_hz: result
            .modes
            .iter()
            .map(IdentifiedMode::frequency_hz)
            .collect(),
        level: level.map(|(f, l)| (*f, *l)).unzip(),
        band_hz: result.band_hz,
    })
}

/// Singular values with their peaks, bells and decays; `None` for a method without peak picking.
fn decomposition(result: &IdentificationResult, name: &str) -> Option<FddPlot> {
    let Evidence::Peaks(peaks) = &result.evidence else {
        return None;
    };
    let (lines, first) = &peaks.level;
    let band_lines: Vec<usize> = (0..lines.len())
        .filter(|&k| (result.band_hz.0..=result.band_hz.1).contains(&lines[k]))
        .collect();
    let in_band = |values: &Vec<f64>| band_lines.iter().map(|&k| values[k]).collect();
    let label = |m: &IdentifiedMode| {
        let index = lines.partition_point(|&f| f < m.frequency_hz());
        let index = index.min(lines.len().checked_sub(1)?);
        let text = format!("{} Hz", four_digits(m.frequency_hz()));
        Some((lines[index], first[index], text))
    };
    let bell = |peak: &PickedPeak| {
        let bell = peak.bell.as_ref()?;
        let f = peak.frequency_hz;
        let words = match bell.pole {
            Some((pole, _)) => {
                let damping = -100.0 * pole.re / pole.norm();
                format!(
                    "{} Hz, damping {damping:.2} %",
                    four_digits(pole.norm() / TAU)
                )
            }
            None => format!("{} Hz, no line", four_digits(f)),
        };
        Some(PlottedBell {
            words,
            lines: bell.lines.clone(),
            decay: bell.decay.iter().map(|(t, rest)| (t * f, *rest)).collect(),
            line: bell.pole.map(|(pole, start)| (start, pole.re / f)),
        })
    };
    Some(FddPlot {
        title: format!("{name}: peaks by {}", result.method.name()),
        frequency_hz: in_band(lines),
        singular_values: std::iter::once(first)
            .chain(&peaks.below)
            .map(in_band)
            .collect(),
        labels: result.modes.iter().filter_map(label).collect(),
        bells: peaks.peaks.iter().filter_map(bell).collect(),
        fitted: DECAY_RANGE,
    })
}

/// Label of a response in plots.
fn label(f: &FrequencyResponse) -> String {
    match &f.input {
        Some(input) if !input.name.is_empty() => format!("{}/{}", f.output.name, input.name),
        _ => f.output.name.clone(),
    }
}

fn unit(f: &FrequencyResponse) -> String {
    match &f.input {
        Some(input) if !input.unit.is_empty() && !f.output.unit.is_empty() => {
            quotient_unit(&f.output.unit, &input.unit)
        }
        _ => f.output.unit.clone(),
    }
}
