//! Result of a stability study, and its terminal tables: linear stability, tongues, stress cases.

use std::f64::consts::TAU;
use std::iter::once;

use super::number_format::four_digits;
use super::table::Table;
use crate::base::quantity::format_time;
use crate::motion::floquet::stability_chart::InstabilityTongue;
use crate::motion::progress::rounded;
use crate::plan::linear_stability::UNSTABLE;
use crate::study::parametric::{ParametricResult, StabilityChart};
use crate::study::stability::amplification::AmplificationFactors;
use crate::study::stability::linear::LinearStability;
use crate::study::stability::perturbations::BASELINE_FACTOR;
use crate::study::stability::stress_test::{CaseVerdict, StressCase};

/// Result of a study of stability.
pub struct StabilityResult {
    /// The linear facts.
    pub linear: LinearStability,
    /// A step, s, and what each method makes of the fastest and the slowest mode in it.
    pub amplification: (f64, Vec<AmplificationFactors>),
    /// The largest Floquet multiplier next to free turning, and instabilities over speed, where a stiffness varies; else why
    /// there is none.
    pub floquet: Result<ParametricResult, String>,
    /// The scene at its extremes.
    pub cases: Vec<StressCase>,
    /// The work each case may be, in evaluations.
    pub budget: u64,
    /// Cases that would change nothing, and why.
    pub left_out: Vec<(&'static str, &'static str)>,
    /// Methods that cannot take the machine, and why.
    pub methods_left_out: Vec<(&'static str, String)>,
    /// It ended before all was done.
    pub interrupted: bool,
}

/// Facts, parametric stability, the table of cases, what was refused and why.
pub fn text(found: &StabilityResult) -> String {
    let facts = &found.linear;
    let hertz = |omega: f64| format!("{} Hz", four_digits(omega / TAU));
    let mut text = match facts.eigenvalues.is_empty() {
        true => "no oscillating or decaying mode: any step is stable\n".to_string(),
        false => format!(
            "stiffness ratio {}   fastest {}, slowest {}   spectral abscissa {} 1/s\n",
            four_digits(facts.stiffness_ratio),
            hertz(facts.fastest),
            hertz(facts.slowest),
            four_digits(facts.spectral_abscissa),
        ),
    };
    if let Some(speed) = facts.speed {
        text += &format!(
            "gyroscopic, centripetal and circulatory terms of {} rpm are included\n",
            four_digits(speed * 60.0 / TAU)
        );
    }
    if let Some(growth) = facts.diagnostics.iter().find(|w| w.code == UNSTABLE) {
        text += &format!("{}\n", growth.message);
    }
    let limits = facts.max_steps.iter().filter(|(_, h)| h.is_finite());
    let limits: Vec<String> = limits
        .map(|(name, h)| format!("{name} {}", format_time(*h)))
        .collect();
    if !limits.is_empty() {
        text += &format!("explicit methods need steps below: {}\n", limits.join(", "));
    }
    text += &amplification_table(found);
    text += &match &found.floquet {
        Err(why) => format!("parametric stability not computed: {why}\n"),
        Ok(p) => {
            let state = match p.is_stable() {
                true => "stable".to_string(),
                false => format!("unstable, grows by {} 1/s", four_digits(p.growth_rate())),
            };
            let mut line = format!(
                "mesh stiffness at this speed: {state}, largest multiplier {} a period of {} s\n",
                four_digits(p.max_multiplier),
                four_digits(p.period)
            );
            if let Some(chart) = &p.chart {
                line += &instability_tongues_table(chart, p.speed);
            }
            line
        }
    };
    let (names, methods) = cases_and_methods(&found.cases);
    let mut table = (methods.iter()).fold(Table::named(""), |t, method| t.column(method, ""));
    for name in &names {
        let cell = |method: &&str| {
            find_case(&found.cases, name, method).map_or(String::new(), verdict_text)
        };
        table.row(once(name.to_string()).chain(methods.iter().map(cell)));
    }
    if !names.is_empty() {
        text += &format!(
            "\nthe scene at its extremes, within the work of {} evaluations as it is and of {} in each other case; the number is the energy-balance error relative to the largest term (limit 1e-3, with its uncertainty)\n{}",
            rounded((BASELINE_FACTOR * found.budget) as f64),
            rounded(found.budget as f64),
            table.text()
        );
    }
    // What ended alike is told once.
    let mut ends: Vec<(&str, &str, Vec<&str>)> = Vec::new();
    for case in &found.cases {
        let Some(reason) = case.reason.as_deref() else {
            continue;
        };
        match ends
            .iter_mut()
            .find(|e| (e.0, e.1) == (case.method, reason))
        {
            Some(end) => end.2.push(&case.name),
            None => ends.push((case.method, reason, vec![&case.name])),
        }
    }
    let mut told = Table::texts("||");
    for (method, reason, cases) in ends {
        told.row([method.to_string(), reason.to_string(), cases.join(", ")]);
    }
    let methods = found.methods_left_out.iter().map(|(m, why)| (*m, &why[..]));
    for (at, (what, why)) in found.left_out.iter().copied().chain(methods).enumerate() {
        let apart = if at == 0 { "\n" } else { "" };
        text += &format!("{apart}left out {what}: {why}\n");
    }
    if told.row_count() > 0 {
        text += &format!("\nrefused or failed\n{}", told.text());
    }
    if found.cases.is_empty() {
        return text;
    }
    text + &format!(
        "\n{} pass, {} refused, {} fail\n",
        count_verdicts(found, CaseVerdict::Pass),
        count_verdicts(found, CaseVerdict::Refused),
        count_verdicts(found, CaseVerdict::Fail)
    )
}

/// Cases and methods of a study in the order in which they ran.
pub fn cases_and_methods(cases: &[StressCase]) -> (Vec<&str>, Vec<&'static str>) {
    let (mut names, mut methods) = (Vec::new(), Vec::new());
    for case in cases {
        if !names.contains(&case.name.as_str()) {
            names.push(case.name.as_str());
        }
        if !methods.contains(&case.method) {
            methods.push(case.method);
        }
    }
    (names, methods)
}

/// A case by a method; absent where it did not run.
pub fn find_case<'c>(cases: &'c [StressCase], name: &str, method: &str) -> Option<&'c StressCase> {
    cases.iter().find(|c| c.name == name && c.method == method)
}

/// The verdict on a case with its energy-balance error.
pub fn verdict_text(case: &StressCase) -> String {
    match (case.verdict, case.energy_error) {
        (CaseVerdict::Refused, _) | (_, None) => case.verdict.name().to_string(),
        (verdict, Some(figure)) => format!("{} {figure:.0e}", verdict.name()),
    }
}

/// Amplification factors of each method for the fastest and the slowest mode.
fn amplification_table(found: &StabilityResult) -> String {
    let (step, all) = &found.amplification;
    if all.is_empty() {
        return String::new();
    }
    let mut table = Table::named("|step below|fastest ×|slowest ×|numerical damping");
    for a in all {
        table.row([
            a.method.to_string(),
            found
                .linear
                .max_stable_step(a.method)
                .map_or("none".to_string(), format_time),
            four_digits(a.fastest),
            four_digits(a.slowest),
            four_digits(a.added_damping),
        ]);
    }
    format!(
        "amplification factor per step of {} on the fastest and on the slowest mode\n{}",
        format_time(*step),
        table.text()
    )
}

/// Unstable speeds; with a second parameter every tongue from where it opens.
fn instability_tongues_table(chart: &StabilityChart, speed: f64) -> String {
    let rpm = |factor: f64| four_digits(factor * speed * 60.0 / TAU);
    let hertz = |omega: f64| format!("{} Hz", four_digits(omega / TAU));
    let [low, high] = chart.span.map(rpm);
    let mut found: Vec<(f64, &InstabilityTongue)> = Vec::new();
    for row in &chart.rows {
        for t in &row.tongues {
            match found.iter_mut().find(|(_, other)| other.name == t.name) {
                // The last row a tongue stands in shows how wide it gets.
                Some(seen) if chart.parameter.is_some() => seen.1 = t,
                _ => found.push((row.factor, t)),
            }
        }
    }
    let mut text = format!(
        "from {low} to {high} rpm: {}\n",
        match found.is_empty() {
            true => "stable at all speeds",
            false => "unstable at mesh frequencies",
        }
    );
    for (factor, t) in found {
        text += &format!(
            "  {} to {}   growth {} % a period at {}   {}{}\n",
            hertz(t.from),
            hertz(t.to),
            four_digits(100.0 * (t.growth - 1.0)),
            hertz(t.most_unstable),
            t.name,
            match chart.parameter {
                Some(over) => format!("   seen from {} × {}", over.name(), four_digits(factor)),
                None => String::new(),
            }
        );
    }
    text
}

/// Number of cases with this verdict.
pub fn count_verdicts(found: &StabilityResult, verdict: CaseVerdict) -> usize {
    found.cases.iter().filter(|c| c.verdict == verdict).count()
}
