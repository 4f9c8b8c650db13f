//! Gear inspection run: files read, charts evaluated, values graded.

use std::sync::Arc;

use super::chart_columns::ChartFiles;
use super::charts::{ChartEvaluation, ChartPlot, ChartResults};
use super::grading::{GradedFlanks, GradedValue, Grader};
use super::single_flank;
use crate::base::error::{Diagnostic, Errors};
use crate::base::source_span::SourceFile;
use crate::gear::measurement::deviation::GearDeviation;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::stages::StageDecision;
use crate::scene::limit_table;
use crate::scene::measured_gear::MeasuredGear;

/// All that was found.
#[derive(Debug, Clone)]
pub struct MeasurementResult {
    /// Values, the limiting one marked.
    pub rows: Vec<GradedValue>,
    /// Notes for results without a row in the table.
    pub notes: Vec<String>,
    /// Plots.
    pub plots: Vec<ChartPlot>,
    /// Stages that ran and stages left out.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Every file of ours that was read, the one named first at the front.
    pub sources: Vec<Arc<SourceFile>>,
}

impl MeasurementResult {
    /// Whether every value that has limits keeps them; `None` where none has.
    pub fn is_within_limits(&self) -> Option<bool> {
        self.rows
            .iter()
            .filter_map(GradedValue::is_within_limits)
            .reduce(|all, one| all && one)
    }
}

/// Evaluates everything a gear's file names.
///
/// # Errors
/// All that is wrong with its charts.
pub fn run(gear: &MeasuredGear) -> Result<MeasurementResult, Errors> {
    let mut sources = vec![gear.source.clone()];
    let mut table = Vec::new();
    if let Some(path) = gear
        .requirement
        .as_ref()
        .and_then(|requirement| requirement.table.as_ref())
    {
        let (source, limits) = limit_table::read(path)?;
        sources.push(source);
        table = limits;
    }
    let grader = Grader::new(gear, table);
    let mut evaluation = ChartEvaluation {
        gear,
        grader: &grader,
        chart_files: ChartFiles::default(),
        results: ChartResults::default(),
    };
    let mut errors = Vec::new();
    for chart in &gear.charts {
        if let Err(wrong) = evaluation.chart(chart) {
            errors.extend(wrong.as_slice().iter().cloned());
        }
    }
    Errors::into_result(errors, || ())?;
    let verdict = |done: Result<(), String>, what: &str| match done {
        Ok(()) => StageDecision::Runs(what.to_string()),
        Err(why) => StageDecision::LeftOut(why),
    };
    let many = gear.charts.len();
    let mut plan = vec![("charts", StageDecision::Runs(format!("{many} evaluated")))];
    let expected = single_flank::predict_single_flank(&mut evaluation);
    plan.push((
        "single-flank record from pitch and profile",
        verdict(expected, "rigid, unloaded, with a master without errors"),
    ));
    let told = single_flank::pitch_from_single_flank(&mut evaluation, &gear.charts);
    plan.push((
        "pitch from the single-flank record",
        verdict(told, "least squares where one pair alone touches"),
    ));
    let ChartResults {
        mut rows,
        notes,
        plots,
    } = evaluation.results;
    grader.mark_limiting(&mut rows);
    Ok(MeasurementResult {
        diagnostics: warnings(&grader, &rows, &plots),
        rows,
        notes,
        plots,
        plan,
        sources,
    })
}

/// Totals that the readings show, m: the values, and the spans of profiles and helices, which a design modification fills.
fn totals(rows: &[GradedValue], plots: &[ChartPlot]) -> Vec<(GearDeviation, GradedFlanks, f64)> {
    let measured = rows.iter().filter(|row| !row.predicted);
    let mut all: Vec<_> = measured
        .map(|row| (row.quantity, row.side, row.estimate.value.abs()))
        .collect();
    for plot in plots {
        let ChartPlot::Traces {
            side,
            is_profile,
            traces,
            ..
        } = plot
        else {
            continue;
        };
        let quantity = match is_profile {
            true => GearDeviation::ProfileTotal,
            false => GearDeviation::HelixTotal,
        };
        let spans = traces.iter().map(|t| peak_to_peak(&t.1));
        let widest = spans.fold(0.0, f64::max);
        all.retain(|total| (total.0, total.1) != (quantity, *side));
        all.push((quantity, *side, widest));
    }
    all
}

fn warnings(grader: &Grader, rows: &[GradedValue], plots: &[ChartPlot]) -> Vec<Diagnostic> {
    let mut diagnostics: Vec<Diagnostic> = Vec::new();
    let mut add = |code, message: String, hint: &str| {
        let diagnostic = Diagnostic {
            code,
            message,
            hint: Some(hint.to_string()),
        };
        if !diagnostics.contains(&diagnostic) {
            diagnostics.push(diagnostic);
        }
    };
    for (quantity, side, total) in totals(rows, plots) {
        let Some(times) = grader.implausible_ratio(quantity, total) else {
            continue;
        };
        let what = match quantity {
            GearDeviation::ProfileTotal => "the profile readings span".to_string(),
            GearDeviation::HelixTotal => "the helix readings span".to_string(),
            _ => format!("{} is", quantity.symbol()),
        };
        let name = side.name();
        let of_side = if name.is_empty() {
            String::new()
        } else {
            format!("{name}: ")
        };
        let (message, hint) = match times.is_finite() {
            true => (
                format!(
                    "{of_side}{what} {:.3} µm, {times:.0} times smaller than the finest grade allows",
                    1e6 * total
                ),
                "check the unit of the readings: mm written as µm are a thousand times too small",
            ),
            false => (
                format!("{of_side}{what} 0 µm: the readings do not differ"),
                "check the column: every real gear has deviations",
            ),
        };
        add("readings-small", message, hint);
    }
    for row in rows.iter().filter(|row| !row.predicted) {
        if let Some(why) = grader.reason_without_limit(row.quantity) {
            let message = format!("{} has no limit: {why}", row.quantity.symbol());
            add(
                "outside-standard",
                message,
                "the formulas are not extrapolated beyond the range of the standard",
            );
        }
        if row.is_inconclusive() {
            let message = format!(
                "{} {} is nearer to its limit than its ±",
                row.quantity.symbol(),
                row.side.name()
            );
            add(
                "limit-uncertain",
                message.replace("  ", " "),
                "measure again, more often or more exactly, before the gear is judged by it",
            );
        }
    }
    diagnostics
}
