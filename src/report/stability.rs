//! Stability study as JSON; chart of unstable speeds.

use std::f64::consts::TAU;
use std::sync::Arc;

use serde_json::{Value, json};

use super::axes::draw_frame;
use super::json::{header, warnings};
use super::svg::{
    Anchor, BLACK, Colour, LABEL_SIZE, ORANGE, Panel, TITLE_SIZE, WIDTH, lighten, render_svg, ticks,
};
use crate::base::source_span::SourceFile;
use crate::motion::floquet::stability_chart::InstabilityTongue;
use crate::study::parametric::{ChartRow, ParametricResult, StabilityChart};
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

/// The document.
pub fn json(sources: &[Arc<SourceFile>], found: &StabilityResult) -> Value {
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
            "growth_per_s": p.max_multiplier.ln() / p.period,
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
    json!({
        "geardyn": header(sources, &["facts", "floquet", "extremes"]),
        "interrupted": found.interrupted,
        "facts": {
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
        "warnings": warnings(&facts.diagnostics),
    })
}

fn tongues(row: &ChartRow) -> Vec<Value> {
    row.tongues.iter().map(tongue).collect()
}

fn tongue(t: &InstabilityTongue) -> Value {
    json!({ "from_hz": t.from / TAU, "to_hz": t.to / TAU, "worst_hz": t.most_unstable / TAU, "growth_per_period": t.growth, "name": t.name })
}

/// Number of cases with this verdict.
pub fn count_verdicts(found: &StabilityResult, verdict: CaseVerdict) -> usize {
    found.cases.iter().filter(|c| c.verdict == verdict).count()
}

const MARGIN_LEFT: f64 = 70.0;
const MARGIN_TOP: f64 = 56.0;
const HEIGHT: f64 = 460.0;

/// Unstable speeds over the second parameter; the colour is growth per period.
pub fn draw_stability_chart(title: &str, chart: &StabilityChart, speed: f64) -> String {
    const MARGIN_RIGHT: f64 = 96.0;
    let rpm = |factor: f64| factor * speed * 60.0 / TAU;
    let (Some(first), Some(last)) = (chart.rows.first(), chart.rows.last()) else {
        return render_svg(WIDTH, MARGIN_TOP, |_| {});
    };
    let half = 0.5 * (last.factor - first.factor) / (chart.rows.len().max(2) - 1) as f64;
    let grown = |t: &InstabilityTongue| (t.growth - 1.0).log10();
    let all = || chart.rows.iter().flat_map(|r| &r.tongues);
    let high = all().map(grown).fold(f64::NEG_INFINITY, f64::max);
    let scale = (high - SHADES as f64, high);
    render_svg(WIDTH, MARGIN_TOP + HEIGHT + 52.0, |canvas| {
        canvas.text(title, (MARGIN_LEFT, 16.0), TITLE_SIZE, BLACK, Anchor::Start);
        let panel = Panel {
            across: (MARGIN_LEFT, WIDTH - MARGIN_RIGHT),
            down: (MARGIN_TOP, MARGIN_TOP + HEIGHT),
            x: (rpm(chart.span[0]), rpm(chart.span[1])),
            y: (first.factor - half, last.factor + half),
        };
        for row in &chart.rows {
            for t in &row.tongues {
                let shade = ((high - grown(t)) as usize).min(SHADES - 1);
                let low = (
                    panel.canvas_x(rpm(t.from / chart.base)),
                    panel.canvas_y(row.factor - half),
                );
                let top = (
                    panel.canvas_x(rpm(t.to / chart.base)),
                    panel.canvas_y(row.factor + half),
                );
                canvas.fill_rect(low, top, shaded(shade));
            }
        }
        panel.draw_y_grid(canvas, &ticks(panel.y, 8));
        let over = chart.parameter.map_or("", |p| p.name());
        draw_frame(
            &panel,
            canvas,
            &format!("{over}, times the scene's"),
            Some("speed, rpm"),
        );
        // Every tongue is named once, where it is widest.
        let mut named: Vec<&str> = Vec::new();
        for t in all() {
            if named.contains(&t.name.as_str()) {
                continue;
            }
            named.push(&t.name);
            let widest = all()
                .filter(|other| other.name == t.name)
                .fold(t, |a, b| if b.to - b.from > a.to - a.from { b } else { a });
            let at = panel.canvas_x(rpm(0.5 * (widest.from + widest.to) / chart.base));
            canvas.text(
                &t.name,
                (at, MARGIN_TOP - 8.0),
                LABEL_SIZE,
                BLACK,
                Anchor::Middle,
            );
        }
        canvas.text(
            "growth",
            (WIDTH - MARGIN_RIGHT + 14.0, MARGIN_TOP - 8.0),
            LABEL_SIZE,
            BLACK,
            Anchor::Start,
        );
        for shade in 0..SHADES {
            let down = MARGIN_TOP + 8.0 + 22.0 * shade as f64;
            let left = WIDTH - MARGIN_RIGHT + 14.0;
            canvas.fill_rect((left, down + 14.0), (left + 14.0, down), shaded(shade));
            let per_cent = 100.0 * 10f64.powf(scale.1 - shade as f64);
            let text = format!("{} %", super::svg::significant(per_cent, 2));
            canvas.text(
                &text,
                (left + 20.0, down + 7.0),
                LABEL_SIZE,
                BLACK,
                Anchor::Start,
            );
        }
    })
}

/// Decades of growth distinguished.
const SHADES: usize = 4;

fn shaded(shade: usize) -> Colour {
    (0..shade).fold(ORANGE, |ink, _| lighten(ink))
}
