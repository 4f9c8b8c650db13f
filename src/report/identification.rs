//! Identified modes and transfer functions: document, table, figures.

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
        let found = &self.result;
        let functions = (found.functions.iter())
            .map(TransferFunction::to_json)
            .collect::<Result<Vec<Value>, Error>>()?;
        let fit = found.fit();
        let hits = found.hits.iter().map(|h| json!({ "file": h.moment.file, "time_s": h.moment.time_s, "peak": h.peak, "used": h.fault.is_none(), "fault": h.fault_text }));
        let omitted = found.rejected_poles();
        let omitted = (omitted.iter())
            .map(|(pole, reason)| json!({ "pole_rad_s": complex(*pole), "reason": reason }));
        Ok(json!({
            "method": found.method.name(),
            "rule": found.selection_rule,
            "method_text": found.method_text,
            "band_hz": [found.band_hz.0, found.band_hz.1],
            "hits": hits.collect::<Vec<_>>(),
            "averages": found.responses.as_ref().and_then(|r| r.averages),
            "driving_point": found.driving_point.as_ref().map(|d| json!({ "input": d.input, "output": d.output, "modal_mass_unit": d.unit })),
            "reciprocity": found.reciprocity.iter().map(|r| json!({ "first": { "output": r.first.0, "input": r.first.1 }, "second": { "output": r.second.0, "input": r.second.1 }, "difference": r.difference, "explained": r.explained, "beyond_noise": r.is_broken() })).collect::<Vec<_>>(),
            "window_decay_1_s": found.window_decay(),
            "modes": found.modes.iter().enumerate().map(|(k, m)| mode(found, k, m, found.point_shapes.as_ref())).collect::<Vec<_>>(),
            "weak_modes": found.weak.iter().enumerate().map(|(k, m)| mode(found, k, m, None)).collect::<Vec<_>>(),
            "harmonics": found.harmonics.iter().map(|h| harmonic(found, h)).collect::<Vec<_>>(),
            "omitted": omitted.collect::<Vec<_>>(),
            "tracking": found.tracking().map_or(Value::Array(Vec::new()), mode_tracking::json),
            "evidence": evidence(&found.evidence),
            "tests": tests(&found.evidence),
            "chi2": fit.map(|f| f.chi2),
            "degrees_of_freedom": fit.map(|f| f.dof),
            "delay_s": fit.map_or(&[][..], |f| &f.delay_s),
            "delay_std_s": fit.map_or(&[][..], |f| &f.delay_std_s),
            "fit_error": found.fit_error,
            "frac": synthesis_errors(found).iter().map(|s| s.0).collect::<Vec<_>>(),
            "auto_mac": auto_mac(found),
            "comparison": found.comparison.as_ref().map(|with| mac_plot::json(found, with)),
            "geometry": found.point_shapes.as_ref().map(point_shapes::geometry_json),
            "transfer_functions": functions,
        }))
    }

    fn text(&self) -> String {
        let with = self.result.comparison.as_ref();
        let compared = or_blank(with, |with| mac_plot::text(&self.result, with));
        identification_table::text(&self.result) + &compared
    }

    fn table(&self) -> Table<'_> {
        match self.result.tracking() {
            Some(course) => mode_tracking::points_table(course),
            None => modes_table(&self.result),
        }
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let (found, name) = (&self.result, &self.title);
        let diagram = stabilisation_diagram(found, name).map(|d| pole_plots::stabilisation(&d));
        let Some(shown) = curves(found, name) else {
            let tracks = found.tracking().map(|c| {
                mode_tracking::figure(c, &format!("{name}: modes in the course of the record"))
            });
            let peaks = || decomposition(found, name).map(|shown| fdd_plot::figure(&shown));
            let poles = || {
                let poles: Vec<_> = found.modes.iter().map(|m| m.mode.pole).collect();
                pole_plots::pole_zero(&format!("{name}: poles"), &poles, &[])
            };
            let plot = tracks.or(diagram).or_else(peaks).unwrap_or_else(poles);
            let mut all = vec![Figure::first(plot)];
            all.extend(shape_figures(found, name));
            return Ok(all);
        };
        let transfer = found.functions.first();
        let poles = transfer.map_or(Vec::new(), |f| f.poles().to_vec());
        let zeros = transfer.map(TransferFunction::zeros).transpose()?;
        let zeros = zeros.map_or(Vec::new(), |z| z.zeros);
        let title = match found.outputs.first() {
            Some(output) => format!("{name}: poles of all responses, zeros of {}", output.name),
            None => name.to_string(),
        };
        let mut all = vec![
            Figure::first(bode::bode(&shown)),
            Figure::new("nyquist", bode::nyquist(&shown)),
            Figure::new("poles", pole_plots::pole_zero(&title, &poles, &zeros)),
        ];
        all.extend(diagram.map(|plots| Figure::new("stabilisation", plots)));
        all.extend(shape_figures(found, name));
        Ok(all)
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
            let why = hit.fault_text.as_ref()?;
            let file = or_blank(hit.moment.file.as_ref(), |f| format!(" of {f}"));
            Some(format!(
                "hit at {:.4} s{file} left out: {why}\n",
                hit.moment.time_s
            ))
        };
        self.result.hits.iter().filter_map(line).collect()
    }
}

/// Shapes on the points of the test and the MAC matrix, where these are known.
fn shape_figures(found: &IdentificationResult, name: &str) -> Vec<Figure> {
    if found.modes.is_empty() {
        return Vec::new();
    }
    let shapes = found.point_shapes.as_ref().map(|shapes| {
        let drawing = point_shapes::draw(found, shapes, &format!("{name}: mode shapes"));
        Figure::new("shapes", drawing)
    });
    let mac = found.comparison.as_ref().map(|with| {
        let drawing = mac_plot::draw(found, with, &format!("{name}: modal assurance criterion"));
        Figure::new("mac", drawing)
    });
    shapes.into_iter().chain(mac).collect()
}

fn mode(
    found: &IdentificationResult,
    k: usize,
    mode: &IdentifiedMode,
    on_points: Option<&PointShapes>,
) -> Value {
    let f = mode.frequency_hz();
    let over = |terminals: &[ChannelLabel], values: &[Complex]| -> Map<String, Value> {
        let names = terminals.iter().map(|t| t.name.clone());
        names.zip(values.iter().map(|&z| complex(z))).collect()
    };
    let several = !mode.participation.is_empty();
    let decay = found.window_decay();
    let shape = mode.mode.shape.as_slice();
    let shaped = shape.len() > 1;
    let kurtosis = mode.harmonic.as_ref().map(|h| h.envelope_kurtosis);
    json!({
        "mode": k + 1,
        "frequency_hz": f,
        "frequency_std_hz": mode.mode.frequency_std_hz(),
        "damped_frequency_hz": mode.has_damping.then(|| mode.mode.damped_frequency_hz()),
        "damping_ratio": mode.damping_ratio(),
        "damping_std": mode.mode.damping_std(),
        "window_damping": (decay > 0.0).then(|| window_damping_ratio(decay, f)),
        "pole_rad_s": mode.has_damping.then(|| complex(mode.mode.pole)),
        "coherence": found.responses.as_ref().and_then(|r| coherence_at(r, f)),
        "presence": mode.presence,
        "scatter_hz": mode.scatter_hz,
        "weak": mode.weak,
        "model_error": mode.departure.map(|d| d.model_error),
        "frequency_spread_hz": mode.departure.map(|d| d.frequency_spread_hz),
        "damping_spread": mode.departure.map(|d| d.damping_spread),
        "envelope_kurtosis": kurtosis,
        "on_order": mode.on_order,
        "on_mains": mode.on_mains.map(|(mains, multiple)| json!({"mains_hz": mains, "multiple": multiple})),
        "phase_collinearity": shaped.then(|| compare::phase_collinearity(shape)),
        "mean_phase_rad": shaped.then(|| compare::mean_phase(shape)),
        "mean_phase_deviation_rad": shaped.then(|| compare::mean_phase_deviation(shape)),
        "complexity": shaped.then(|| compare::off_axis_share(shape)),
        "shape": over(&found.outputs, &mode.mode.shape),
        "shape_on_points": on_points.map(|shapes| point_shapes::shape_json(shapes, k)),
        "modal_mass": mode.modal_mass.map(complex),
        "participation": several.then(|| over(&found.inputs, &mode.participation)),
    })
}

fn harmonic(found: &IdentificationResult, harmonic: &IdentifiedHarmonic) -> Value {
    let names = found.outputs.iter().map(|t| t.name.clone());
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

/// FRAC of measured and fitted, and their difference over the measured, for each response inside the band.
fn synthesis_errors(found: &IdentificationResult) -> Vec<(f64, Option<f64>)> {
    let Some(shown) = curves(found, "") else {
        return Vec::new();
    };
    let of = |c: &BodeCurve| {
        let fitted = c.fitted.as_ref()?;
        let known: (Vec<Complex>, Vec<Complex>) = (c.measured.iter().zip(fitted)).unzip();
        let error = compare::synthesis_error(&known.0, &known.1);
        Some((compare::frac(&known.0, &known.1), error))
    };
    shown.curves.iter().filter_map(of).collect()
}

/// Evidence for the modes, one entry for each trial.
fn evidence(evidence: &Evidence) -> Value {
    match evidence {
        Evidence::Rational(fit) => fit.evidence.iter().map(|s| json!({ "pole_pairs_before": s.poles_before, "pole_pairs": s.poles_after, "chi2_before": s.chi2_before, "chi2": s.chi2_after, "probability": s.probability, "accepted": s.accepted, "reason": s.reason })).collect(),
        Evidence::Diagram(diagram) => diagram.poles.iter().map(|p| json!({ "order": p.order, "frequency_hz": p.frequency_hz, "damping_ratio": p.damping_ratio, "stability": stability_word(p.stability) })).collect(),
        Evidence::Peaks(peaks) => peaks.peaks.iter().map(|p| json!({ "frequency_hz": p.frequency_hz, "prominence": p.prominence, "half_power": p.half_power.map(|(f, d)| json!({ "frequency_hz": f, "damping_ratio": d })), "bell_hz": bell_hz(p), "reason": p.reason })).collect(),
        Evidence::Orders(orders) => orders.candidates.iter().map(|c| json!({ "model": structure_text(c.family), "error_variance": c.error_variance, "aic": c.aic, "bic": c.bic, "mdl": c.mdl, "accepted": c.family == orders.chosen })).collect(),
        Evidence::Tracking(course) => mode_tracking::trials(course),
    }
}

/// First and last line of a peak's bell.
fn bell_hz(peak: &PickedPeak) -> Option<[f64; 2]> {
    let lines = &peak.bell.as_ref()?.lines;
    Some([lines.first()?.0, lines.last()?.0])
}

fn tests(evidence: &Evidence) -> Value {
    match evidence {
        Evidence::Orders(orders) => orders.tests.iter().map(|(what, t)| json!({ "residuals": what, "statistic": t.statistic, "degrees_of_freedom": t.dof, "probability": t.probability })).collect(),
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

/// One row a mode.
fn modes_table(found: &IdentificationResult) -> Table<'static> {
    let mut table =
        Table::new("mode|frequency_hz|frequency_std_hz|damping_ratio|damping_std|coherence");
    for output in &found.outputs {
        let part = |part| format!("{} {part}", output.name);
        table = table.column(&part("re"), "").column(&part("im"), "");
    }
    let mut table = table.columns_if(found.driving_point.is_some(), "modal_mass_re|modal_mass_im");
    let parts = |z: Option<Complex>| [z.map(|z| z.re), z.map(|z| z.im)].map(|x| or_blank(x, exact));
    for (k, m) in found.modes.iter().enumerate() {
        let responses = found.responses.as_ref();
        let coherence = responses.and_then(|r| coherence_at(r, m.frequency_hz()));
        let mut cells = vec![
            (k + 1).to_string(),
            exact(m.frequency_hz()),
            or_blank(m.mode.frequency_std_hz(), exact),
            or_blank(m.damping_ratio(), exact),
            or_blank(m.mode.damping_std(), exact),
            or_blank(coherence, exact),
        ];
        // A method without shapes leaves their cells blank.
        let shape = |k: usize| m.mode.shape.get(k).copied();
        cells.extend((0..found.outputs.len()).flat_map(|k| parts(shape(k))));
        if found.driving_point.is_some() {
            cells.extend(parts(m.modal_mass));
        }
        table.row(cells);
    }
    table
}

/// The responses, measured and fitted, inside the band; nothing where the method starts from signals.
fn curves(found: &IdentificationResult, title: &str) -> Option<BodePlot> {
    let responses = found.responses.as_ref()?;
    let (low, high) = found.band_hz;
    let lines: Vec<usize> = (0..responses.frequency_hz.len())
        .filter(|&k| (low..=high).contains(&responses.frequency_hz[k]))
        .collect();
    let at = |&k: &usize| responses.frequency_hz[k];
    let synthesised: Vec<Vec<Complex>> = lines.iter().map(|k| found.synthesise(at(k))).collect();
    let fitted = |i: usize| -> Option<Vec<Complex>> {
        synthesised.iter().map(|all| all.get(i).copied()).collect()
    };
    let path: Vec<Vec<Complex>> =
        (plot_frequencies(found, &lines.iter().map(at).collect::<Vec<f64>>()))
            .into_iter()
            .map(|f| found.synthesise(f))
            .collect();
    let traced = |i: usize| path.iter().filter_map(|all| all.get(i).copied()).collect();
    let curve = |(i, f): (usize, &FrequencyResponse)| BodeCurve {
        traced: traced(i),
        label: label(f),
        unit: unit(f),
        measured: lines.iter().map(|&k| f.values[k]).collect(),
        fitted: fitted(i),
        computed: false,
        coherence: f
            .coherence
            .as_ref()
            .map(|c| lines.iter().map(|&k| c[k]).collect()),
    };
    Some(BodePlot {
        title: title.to_string(),
        across: "",
        frequency_hz: lines.iter().map(at).collect(),
        curves: responses.responses.iter().enumerate().map(curve).collect(),
        modes_hz: found
            .modes
            .iter()
            .map(IdentifiedMode::frequency_hz)
            .collect(),
    })
}

/// Lines, and between the first and the last as many places about every mode as its circle needs to look round: with `f − f₀` as the
/// tangent of equal angles.
fn plot_frequencies(found: &IdentificationResult, lines: &[f64]) -> Vec<f64> {
    const ANGLES: i32 = 60;
    let (Some(&low), Some(&high)) = (lines.first(), lines.last()) else {
        return Vec::new();
    };
    let about = |m: &IdentifiedMode| {
        let (f, half) = (m.mode.damped_frequency_hz(), m.mode.pole.re.abs() / TAU);
        let turn = std::f64::consts::PI / f64::from(2 * ANGLES);
        (1 - ANGLES..ANGLES).map(move |k| f + half * (f64::from(k) * turn).tan())
    };
    let mut all: Vec<f64> = (found.modes.iter().filter(|m| m.has_damping))
        .flat_map(about)
        .filter(|f| (low..=high).contains(f))
        .chain(lines.iter().copied())
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Poles over the orders, where the method looked over orders.
fn stabilisation_diagram(found: &IdentificationResult, name: &str) -> Option<StabilisationPlot> {
    let Evidence::Diagram(diagram) = &found.evidence else {
        return None;
    };
    let steadiness = |s: PoleStability| match s {
        PoleStability::Stable => PlottedStability::Stable,
        PoleStability::New => PlottedStability::New,
        _ => PlottedStability::Frequency,
    };
    let inside = |f: &f64| (found.band_hz.0..=found.band_hz.1).contains(f);
    let level = diagram
        .level
        .0
        .iter()
        .zip(&diagram.level.1)
        .filter(|(f, _)| inside(f));
    Some(StabilisationPlot {
        title: format!("{name}: poles by {}", found.method.name()),
        poles: diagram
            .poles
            .iter()
            .map(|p| (p.order, p.frequency_hz, steadiness(p.stability)))
            .collect(),
        selected_hz: found
            .modes
            .iter()
            .map(IdentifiedMode::frequency_hz)
            .collect(),
        level: level.map(|(f, l)| (*f, *l)).unzip(),
        band_hz: found.band_hz,
    })
}

/// Singular values with their peaks, bells and decays, where the method looked for peaks.
fn decomposition(found: &IdentificationResult, name: &str) -> Option<FddPlot> {
    let Evidence::Peaks(peaks) = &found.evidence else {
        return None;
    };
    let (lines, first) = &peaks.level;
    let inside: Vec<usize> = (0..lines.len())
        .filter(|&k| (found.band_hz.0..=found.band_hz.1).contains(&lines[k]))
        .collect();
    let of_band = |values: &Vec<f64>| inside.iter().map(|&k| values[k]).collect();
    let label = |m: &IdentifiedMode| {
        let at = lines.partition_point(|&f| f < m.frequency_hz());
        let at = at.min(lines.len().checked_sub(1)?);
        let text = format!("{} Hz", four_digits(m.frequency_hz()));
        Some((lines[at], first[at], text))
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
            decay: bell.decay.iter().map(|(t, left)| (t * f, *left)).collect(),
            line: bell.pole.map(|(pole, start)| (start, pole.re / f)),
        })
    };
    Some(FddPlot {
        title: format!("{name}: peaks by {}", found.method.name()),
        frequency_hz: of_band(lines),
        singular_values: std::iter::once(first)
            .chain(&peaks.below)
            .map(of_band)
            .collect(),
        labels: found.modes.iter().filter_map(label).collect(),
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
