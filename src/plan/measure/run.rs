//! The run: files read, charts evaluated, values graded; what is left out and why.

use std::sync::Arc;

use super::charts::{Drawn, Evaluation, Gathered};
use super::columns::Files;
use super::grading::{Grader, Row};
use super::rolling;
use crate::base::error::{Errors, Warning};
use crate::base::place::Source;
use crate::plan::stages::Verdict;
use crate::scene::limit_table;
use crate::scene::measured::MeasuredGear;

/// All that was found.
#[derive(Debug, Clone)]
pub struct Answer {
    /// Values, the limiting one marked.
    pub rows: Vec<Row>,
    /// What the table has no row for.
    pub notes: Vec<String>,
    /// What pictures show.
    pub drawn: Vec<Drawn>,
    /// What ran and what was left out.
    pub plan: Vec<(&'static str, Verdict)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
    /// Every file of ours that was read, the one named first at the front.
    pub sources: Vec<Arc<Source>>,
}

impl Answer {
    /// Whether every value that has limits keeps them; `None` where none has.
    pub fn within(&self) -> Option<bool> {
        self.rows
            .iter()
            .filter_map(Row::within)
            .reduce(|all, one| all && one)
    }
}

/// Evaluates everything a gear's file names.
///
/// # Errors
/// All that is wrong with its charts.
pub fn run(gear: &MeasuredGear) -> Result<Answer, Errors> {
    let mut sources = vec![gear.source.clone()];
    let mut table = Vec::new();
    if let Some(path) = gear
        .demand
        .as_ref()
        .and_then(|demand| demand.table.as_ref())
    {
        let (source, limits) = limit_table::read(path)?;
        sources.push(source);
        table = limits;
    }
    let grader = Grader::new(gear, table);
    let mut evaluation = Evaluation {
        gear,
        grader: &grader,
        files: Files::default(),
        out: Gathered::default(),
    };
    let mut errors = Vec::new();
    for chart in &gear.charts {
        if let Err(wrong) = evaluation.chart(chart) {
            errors.extend(wrong.list().iter().cloned());
        }
    }
    Errors::or(errors, || ())?;
    let verdict = |done: Result<(), String>, what: &str| match done {
        Ok(()) => Verdict::Runs(what.to_string()),
        Err(why) => Verdict::LeftOut(why),
    };
    let many = gear.charts.len();
    let mut plan = vec![("charts", Verdict::Runs(format!("{many} evaluated")))];
    let expected = rolling::predict(&mut evaluation);
    plan.push((
        "single-flank record from pitch and profile",
        verdict(expected, "rigid, unloaded, with a master without errors"),
    ));
    let told = rolling::teeth(&mut evaluation, &gear.charts);
    plan.push((
        "pitch from the single-flank record",
        verdict(told, "least squares where one pair alone touches"),
    ));
    let Gathered {
        mut rows,
        notes,
        drawn,
    } = evaluation.out;
    grader.mark_limiting(&mut rows);
    Ok(Answer {
        warnings: warnings(&grader, &rows),
        rows,
        notes,
        drawn,
        plan,
        sources,
    })
}

fn warnings(grader: &Grader, rows: &[Row]) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = Vec::new();
    let mut add = |code, message: String, hint: &str| {
        let warning = Warning {
            code,
            message,
            hint: Some(hint.to_string()),
        };
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    };
    for row in rows.iter().filter(|row| !row.predicted) {
        if let Some(times) = grader.below_all_gears(row) {
            let message = format!(
                "{} {} is {:.3} µm, {times:.0} times less than the finest grade allows",
                row.quantity.symbol(),
                row.side.word(),
                1e6 * row.estimate.value.abs()
            );
            add(
                "readings-small",
                message.replace("  ", " "),
                "check the unit of the readings: mm written as µm are a thousand times too small",
            );
        }
        if let Some(why) = grader.outside(row.quantity) {
            let message = format!("{} has no limit: {why}", row.quantity.symbol());
            add(
                "outside-standard",
                message,
                "the formulas are not extended beyond the range the standard states",
            );
        }
        if row.in_doubt() {
            let message = format!(
                "{} {} is nearer to its limit than its ±",
                row.quantity.symbol(),
                row.side.word()
            );
            add(
                "limit-in-doubt",
                message.replace("  ", " "),
                "measure again, more often or more exactly, before the gear is judged by it",
            );
        }
    }
    warnings
}
