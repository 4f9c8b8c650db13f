//! Frequency responses: peaks, document, table over frequency, Bode and Nyquist plots.

use serde_json::{Value, json};

use super::bode::{BodeCurve, BodePlot, bode, nyquist};
use super::figure::Figure;
use super::json::complex;
use super::mode_text::element_share;
use super::number_format::{four_digits, percent, significant};
use super::plan::omitted_steps;
use super::presentation::{Presentation, Provenance, StudyReport};
use super::table::{Table, decimal, or_dash};
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::machine::components::Machine;
use crate::numeric::Complex;
use crate::numeric::sorting::{sort_ascending, sort_descending};
use crate::plan::response::run::{ResponseCurve, ResponseResult};
use crate::response::frf::{ResponseMethod, SolverKind};

impl Presentation for StudyReport<'_, ResponseResult> {
    fn provenance(&self) -> Provenance<'_> {
        let (result, stats) = (&self.result, &self.result.stats);
        Provenance {
            effort: json!({ "run_time_s": stats.seconds, "coordinates": stats.coordinates }),
            title: &self.scene.model.title,
            ..Provenance::of_plan(&self.scene.sources, &result.plan, &result.diagnostics)
        }
    }

    fn body(&self) -> Result<Value, Error> {
        let (machine, result) = (&self.machine.machine, &self.result);
        let mut document = json!({
            "frequency_hz": result.frequency_hz,
            "responses": result.pairs.iter().map(|pair| response(machine, pair)).collect::<Vec<_>>(),
            "method": match result.solver {
                SolverKind::Dense | SolverKind::Sparse => "direct",
                SolverKind::RealModes => "real modes",
                SolverKind::ComplexModes => "complex modes",
            },
            "reason": result.choice.reason,
            "error": result.stats.error,
            "lines_checked": result.stats.checked,
        });
        if let [only] = &result.pairs[..] {
            document["value"] = values(only);
            document["peaks"] = peaks(machine, only);
        }
        Ok(document)
    }

    fn text(&self) -> String {
        let (machine, result) = (&self.machine.machine, &self.result);
        let mut text = String::new();
        for (at, pair) in result.pairs.iter().enumerate() {
            let gap = if at > 0 { "\n" } else { "" };
            text += &format!("{gap}{} by {}\n", pair.output, pair.input);
            if let Some(rest) = pair.static_response {
                text += &format!("at rest {} {}\n", four_digits(rest), pair.unit);
            }
            text += &match pair.peaks.is_empty() {
                true => "  no peak in the band\n".to_string(),
                false => peak_table(machine, pair),
            };
        }
        text
    }

    fn table(&self) -> Table<'_> {
        let result = &self.result;
        let hertz = Table::default().numbers("frequency", "Hz", &result.frequency_hz, decimal);
        result.pairs.iter().fold(hertz, |table, pair| {
            let name = |part| format!("{} by {} {part}", pair.output, pair.input);
            let all = |part: fn(&Complex) -> f64| pair.values.iter().map(part).collect::<Vec<_>>();
            table
                .numbers(&name("re"), &pair.unit, all(|z| z.re), decimal)
                .numbers(&name("im"), &pair.unit, all(|z| z.im), decimal)
        })
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let shown = bode_plot(&self.scene.model.title, &self.result);
        Ok(vec![
            Figure::first(bode(&shown)),
            Figure::new("nyquist", nyquist(&shown)),
        ])
    }

    fn figure_notes(&self) -> String {
        let result = &self.result;
        let (all, shown) = (result.pairs.len(), plotted_pairs(result).count());
        match plotted_pairs(result).next() {
            Some(first) if shown < all => format!(
                "drawn: the {} in {}, of {all}; request those in other units separately\n",
                pluralise(shown, "response"),
                first.unit
            ),
            _ => String::new(),
        }
    }

    fn notes(&self) -> String {
        format!(
            "{}\n{}",
            method_text(&self.result),
            omitted_steps(&self.result.plan)
        )
    }
}

/// Description of the method, as text.
fn method_text(result: &ResponseResult) -> String {
    let n = result.stats.coordinates;
    let mut text = match result.solver {
        SolverKind::Dense => format!("dynamic stiffness of {n} coordinates, line by line"),
        SolverKind::Sparse => format!("sparse dynamic stiffness of {n} coordinates, line by line"),
        SolverKind::RealModes => "sum over all real modes".to_string(),
        SolverKind::ComplexModes => "sum over all complex modes".to_string(),
    };
    let summed = matches!(
        result.solver,
        SolverKind::RealModes | SolverKind::ComplexModes
    );
    if summed || result.choice.method == ResponseMethod::Direct {
        text += &format!(": {}", result.choice.reason);
    } else if result.stats.rejected_error.is_none() {
        text += ": its modes are coupled (damping without inertia, different loss factors), so they cannot be summed";
    }
    if let Some(error) = result.stats.error {
        text += &format!(
            "; at {} lines solved directly its error is at most {error:.1e}",
            result.stats.checked
        );
    }
    if let Some(off) = result.stats.rejected_error {
        text += &format!("; the sum over modes had an error of {off:.1e} and was discarded");
    }
    text
}

fn response(machine: &Machine, pair: &ResponseCurve) -> Value {
    json!({
        "input": pair.input,
        "output": pair.output,
        "unit": pair.unit,
        "at_rest": pair.static_response,
        "value": values(pair),
        "peaks": peaks(machine, pair),
    })
}

fn values(pair: &ResponseCurve) -> Value {
    pair.values.iter().map(|&z| complex(z)).collect()
}

fn peaks(machine: &Machine, pair: &ResponseCurve) -> Value {
    let peak = |p: &crate::plan::response::run::ResonancePeak| {
        json!({
            "frequency_hz": p.peak.omega / std::f64::consts::TAU,
            "magnitude": p.peak.height,
            "amplification": pair.static_response.map(|rest| p.peak.height / rest),
            "damping_ratio": p.peak.damping(),
            "dominant_element": p.dominant_element.map(|(element, _)| machine.elements[element].name.clone()),
            "share": p.dominant_element.map(|(_, share)| share),
        })
    };
    pair.peaks.iter().map(peak).collect()
}

/// The responses in the unit of the first.
fn plotted_pairs(result: &ResponseResult) -> impl Iterator<Item = &ResponseCurve> {
    let unit = result.pairs.first().map(|pair| &pair.unit);
    (result.pairs.iter()).filter(move |pair| Some(&pair.unit) == unit)
}

/// Magnitude and phase over frequency, and the complex plane; of the responses in the unit of the first.
fn bode_plot(title: &str, result: &ResponseResult) -> BodePlot {
    let curve = |pair: &ResponseCurve| BodeCurve {
        fit_path: Vec::new(),
        label: format!("{} by {}", pair.output, pair.input),
        unit: pair.unit.clone(),
        measured: pair.plotted.clone(),
        is_computed: true,
        ..BodeCurve::default()
    };
    let mut modes: Vec<f64> = plotted_pairs(result)
        .flat_map(|p| &p.peaks)
        .map(|p| p.peak.omega / std::f64::consts::TAU)
        .collect();
    modes.sort_by(f64::total_cmp);
    // Peaks of several responses at one mode are one line.
    modes.dedup_by(|a, b| (*a - *b).abs() < 2e-3 * *a);
    BodePlot {
        title: title.to_string(),
        abscissa_label: "",
        frequency_hz: result.plot_frequency_hz.clone(),
        curves: plotted_pairs(result).map(curve).collect(),
        modes_hz: modes,
    }
}

/// Peaks shown of a response, the highest.
const MAX_ROWS: usize = 20;

fn peak_table(machine: &Machine, pair: &ResponseCurve) -> String {
    let mut shown: Vec<_> = pair.peaks.iter().collect();
    sort_descending(&mut shown, |a| a.peak.height);
    shown.truncate(MAX_ROWS);
    sort_ascending(&mut shown, |a| a.peak.omega);
    let mut table = Table::new("frequency [Hz]")
        .column("magnitude", &pair.unit)
        .columns("amplification [of static]|damping [%]|dominant element");
    for p in shown {
        let over_rest = |rest| four_digits(p.peak.height / rest);
        table.row([
            significant(p.peak.omega / std::f64::consts::TAU),
            four_digits(p.peak.height),
            or_dash(pair.static_response, over_rest),
            or_dash(p.peak.damping(), percent),
            or_dash(p.dominant_element, |(element, share)| {
                element_share(machine, element, share)
            }),
        ]);
    }
    let mut text = table.text();
    if pair.peaks.len() > MAX_ROWS {
        text += &format!("{} lower ones\n", pair.peaks.len() - MAX_ROWS);
    }
    text
}
