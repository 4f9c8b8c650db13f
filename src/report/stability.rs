//! Stability study: document, table of cases, figures.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::figure::Figure;
use super::presentation::{INTERRUPTED_TEXT, Presentation, Provenance};
use super::stability_chart::draw_stability_chart;
use super::stability_regions::stability_regions;
use super::stability_table::{self, StabilityResult, count_verdicts};
use super::table::{Table, or_blank, power};
use super::verdict_matrix;
use crate::base::error::Error;
use crate::motion::floquet::stability_chart::InstabilityTongue;
use crate::scene::Scene;
use crate::study::parametric::ChartRow;
use crate::study::stability::amplification::AmplificationChart;
use crate::study::stability::perturbations::BASELINE_FACTOR;
use crate::study::stability::stress_test::{CaseVerdict, StressCase};

/// A study of stability of the machine of a scene.
pub struct StabilityReport<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The step of the plot of stability regions, s: the largest that is stable for the method that needs the shortest where absent.
    pub step: Option<f64>,
    /// The result.
    pub result: StabilityResult,
}

impl Presentation for StabilityReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        Provenance {
            title: &self.scene.model.title,
            sources: &self.scene.sources,
            trace: vec!["linear", "floquet", "extremes"],
            warnings: &self.result.linear.diagnostics,
            ..Provenance::default()
        }
    }

    fn body(&self) -> Result<Value, Error> {
        let found = &self.result;
        let facts = &found.linear;
        let finite = |x: f64| x.is_finite().then_some(x);
        let limits: serde_json::Map<String, Value> = facts
            .max_steps
            .iter()
            .map(|(n, h)| (n.to_string(), json!(finite(*h))))
            .collect();
        let floquet = match &found.floquet {
            Err(why) => json!({ "left_out": why }),
            Ok(p) => json!({
                "largest_multiplier": p.max_multiplier,
                "growth_per_s": p.growth_rate(),
                "period_s": p.period,
                "tongues": p.chart.as_ref().filter(|c| c.parameter.is_none()).map(|c| tongues(&c.rows[0])),
                "chart": p.chart.as_ref().and_then(|c| Some(json!({
                    "over": c.parameter?.name(),
                    "rows": c.rows.iter().map(|r| json!({ "factor": r.factor, "tongues": tongues(r) })).collect::<Vec<_>>(),
                }))),
            }),
        };
        let (step, amplified) = &found.amplification;
        let amplified = amplified.iter().map(|a| {
        json!({
            "method": a.method, "step_limit_s": facts.max_stable_step(a.method).and_then(finite), "fastest": finite(a.fastest),
            "slowest": finite(a.slowest), "slowest_added_damping_ratio": finite(a.added_damping),
        })
    });
        let amplified: Vec<Value> = amplified.collect();
        let case = |c: &StressCase| json!({ "case": c.name, "method": c.method, "verdict": c.verdict.name(), "figure": c.energy_error, "reason": c.reason });
        Ok(json!({
            "interrupted": found.interrupted,
            "linear": {
                "stiffness_ratio": finite(facts.stiffness_ratio), "spectral_abscissa_per_s": finite(facts.spectral_abscissa),
                "speed_rad_s": facts.speed, "fastest_rad_s": facts.fastest, "slowest_rad_s": finite(facts.slowest), "step_limits_s": limits,
                "eigenvalues_rad_s": facts.eigenvalues.iter().map(|z| json!({ "re": z.re, "im": z.im })).collect::<Vec<_>>(),
            },
            "amplification": { "step_s": finite(*step), "methods": amplified },
            "floquet": floquet,
            "budget_evaluations": found.budget,
            "budget_as_it_is_evaluations": BASELINE_FACTOR * found.budget,
            "left_out": found.left_out.iter().map(|(case, reason)| json!({ "case": case, "reason": reason })).collect::<Vec<_>>(),
            "methods_left_out": found.methods_left_out.iter().map(|(method, reason)| json!({ "method": method, "reason": reason })).collect::<Vec<_>>(),
            "cases": found.cases.iter().map(case).collect::<Vec<_>>(),
            "counts": {
                "pass": count_verdicts(found, CaseVerdict::Pass), "refused": count_verdicts(found, CaseVerdict::Refused), "fail": count_verdicts(found, CaseVerdict::Fail),
            },
        }))
    }

    fn text(&self) -> String {
        stability_table::text(&self.result)
    }

    fn table(&self) -> Table<'_> {
        let mut table = Table::new("case|method|verdict|energy_error|reason");
        for c in &self.result.cases {
            let error = or_blank(c.energy_error, power);
            let [name, method, verdict] = [&c.name, c.method, c.verdict.name()].map(str::to_string);
            table.row([
                name,
                method,
                verdict,
                error,
                c.reason.clone().unwrap_or_default(),
            ]);
        }
        table
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let (title, facts) = (&self.scene.model.title, &self.result.linear);
        let limits = facts.max_steps.iter().map(|limit| limit.1);
        let shortest = limits.fold(f64::INFINITY, f64::min);
        let usual = if shortest.is_finite() { shortest } else { 1.0 };
        let spectrum = AmplificationChart::new(&facts.eigenvalues, self.step.unwrap_or(usual))?;
        let mut all = vec![Figure::first(stability_regions(title, facts, &spectrum))];
        if let Ok(found) = &self.result.floquet
            && let Some(chart) = found.chart.as_ref().filter(|c| c.parameter.is_some())
        {
            let plot = draw_stability_chart(title, chart, found.speed);
            all.push(Figure::new("chart", plot));
        }
        let verdicts = verdict_matrix::draw(title, &self.result.cases);
        all.extend(verdicts.map(|drawing| Figure::new("verdicts", drawing)));
        Ok(all)
    }

    fn interruption(&self) -> Option<String> {
        self.result
            .interrupted
            .then(|| INTERRUPTED_TEXT.to_string())
    }

    fn exit_code(&self) -> u8 {
        u8::from(count_verdicts(&self.result, CaseVerdict::Fail) > 0)
    }
}

fn tongues(row: &ChartRow) -> Vec<Value> {
    row.tongues.iter().map(tongue).collect()
}

fn tongue(t: &InstabilityTongue) -> Value {
    json!({ "from_hz": t.from / TAU, "to_hz": t.to / TAU, "worst_hz": t.most_unstable / TAU, "growth_per_period": t.growth, "name": t.name })
}
