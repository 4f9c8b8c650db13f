//! Where methods and machine break, as JSON, and the chart of unstable speeds.

use std::f64::consts::TAU;
use std::sync::Arc;

use serde_json::{Value, json};

use super::axes::frame;
use super::json::{header, warnings};
use super::style::{Anchor, BLACK, Ink, ORANGE, Panel, SMALL, TITLE, WIDTH, paler, picture, ticks};
use crate::base::place::Source;
use crate::motion::floquet::chart::Tongue;
use crate::study::parametric::{Chart, Parametric, Row};
use crate::study::stability::amplification::Amplified;
use crate::study::stability::cases::AS_IT_IS;
use crate::study::stability::extremes::{Case, Verdict};
use crate::study::stability::facts::Facts;

/// What a study of stability found.
pub struct Stability {
    /// The linear facts.
    pub facts: Facts,
    /// A step, s, and what each method makes of the fastest and the slowest mode in it.
    pub amplified: (f64, Vec<Amplified>),
    /// The largest Floquet multiplier beside free turning, and instabilities over speed, where a stiffness varies; else why there is none.
    pub floquet: Result<Parametric, String>,
    /// The scene at its extremes.
    pub cases: Vec<Case>,
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
pub fn json(sources: &[Arc<Source>], found: &Stability) -> Value {
    let facts = &found.facts;
    let finite = |x: f64| x.is_finite().then_some(x);
    let limits: serde_json::Map<String, Value> = facts
        .limits
        .iter()
        .map(|(n, h)| (n.to_string(), json!(finite(*h))))
        .collect();
    let floquet = match &found.floquet {
        Err(why) => json!({ "left_out": why }),
        Ok(p) => json!({
            "largest_multiplier": p.largest,
            "growth_per_s": p.largest.ln() / p.period,
            "period_s": p.period,
            "tongues": p.chart.as_ref().filter(|c| c.over.is_none()).map(|c| tongues(&c.rows[0])),
            "chart": p.chart.as_ref().and_then(|c| Some(json!({
                "over": c.over?.name(),
                "rows": c.rows.iter().map(|r| json!({ "factor": r.factor, "tongues": tongues(r) })).collect::<Vec<_>>(),
            }))),
        }),
    };
    let (step, amplified) = &found.amplified;
    let amplified = amplified.iter().map(|a| {
        json!({
            "method": a.method, "step_limit_s": facts.limit(a.method).and_then(finite), "fastest": finite(a.fastest),
            "slowest": finite(a.slowest), "slowest_added_damping_ratio": finite(a.added_damping),
        })
    });
    let amplified: Vec<Value> = amplified.collect();
    let case = |c: &Case| json!({ "case": c.name, "method": c.method, "verdict": c.verdict.name(), "figure": c.figure, "reason": c.reason });
    json!({
        "geardyn": header(sources, &["facts", "floquet", "extremes"]),
        "interrupted": found.interrupted,
        "facts": {
            "stiffness_ratio": finite(facts.stiffness_ratio), "spectral_abscissa_per_s": finite(facts.abscissa),
            "speed_rad_s": facts.speed, "fastest_rad_s": facts.fastest, "slowest_rad_s": finite(facts.slowest), "step_limits_s": limits,
            "eigenvalues_rad_s": facts.eigenvalues.iter().map(|z| json!({ "re": z.re, "im": z.im })).collect::<Vec<_>>(),
        },
        "amplification": { "step_s": finite(*step), "methods": amplified },
        "floquet": floquet,
        "budget_evaluations": found.budget,
        "budget_as_it_is_evaluations": AS_IT_IS * found.budget,
        "left_out": found.left_out.iter().map(|(case, reason)| json!({ "case": case, "reason": reason })).collect::<Vec<_>>(),
        "methods_left_out": found.methods_left_out.iter().map(|(method, reason)| json!({ "method": method, "reason": reason })).collect::<Vec<_>>(),
        "cases": found.cases.iter().map(case).collect::<Vec<_>>(),
        "counts": {
            "pass": count(found, Verdict::Pass), "refused": count(found, Verdict::Refused), "fail": count(found, Verdict::Fail),
        },
        "warnings": warnings(&facts.warnings),
    })
}

fn tongues(row: &Row) -> Vec<Value> {
    row.tongues.iter().map(tongue).collect()
}

fn tongue(t: &Tongue) -> Value {
    json!({ "from_hz": t.from / TAU, "to_hz": t.to / TAU, "worst_hz": t.worst / TAU, "growth_per_period": t.growth, "name": t.name })
}

/// How many cases ended so.
pub fn count(found: &Stability, verdict: Verdict) -> usize {
    found.cases.iter().filter(|c| c.verdict == verdict).count()
}

const LEFT: f64 = 70.0;
const TOP: f64 = 56.0;
const HIGH: f64 = 460.0;

/// Unstable speeds over the second parameter; the colour is growth per period.
pub fn chart(title: &str, chart: &Chart, speed: f64) -> String {
    const RIGHT: f64 = 96.0;
    let rpm = |factor: f64| factor * speed * 60.0 / TAU;
    let (Some(first), Some(last)) = (chart.rows.first(), chart.rows.last()) else {
        return picture(WIDTH, TOP, |_| {});
    };
    let half = 0.5 * (last.factor - first.factor) / (chart.rows.len().max(2) - 1) as f64;
    let grown = |t: &Tongue| (t.growth - 1.0).log10();
    let all = || chart.rows.iter().flat_map(|r| &r.tongues);
    let high = all().map(grown).fold(f64::NEG_INFINITY, f64::max);
    let scale = (high - SHADES as f64, high);
    picture(WIDTH, TOP + HIGH + 52.0, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let panel = Panel {
            across: (LEFT, WIDTH - RIGHT),
            down: (TOP, TOP + HIGH),
            x: (rpm(chart.span[0]), rpm(chart.span[1])),
            y: (first.factor - half, last.factor + half),
        };
        for row in &chart.rows {
            for t in &row.tongues {
                let shade = ((high - grown(t)) as usize).min(SHADES - 1);
                let low = (
                    panel.right_of(rpm(t.from / chart.base)),
                    panel.height_of(row.factor - half),
                );
                let top = (
                    panel.right_of(rpm(t.to / chart.base)),
                    panel.height_of(row.factor + half),
                );
                canvas.block(low, top, shaded(shade));
            }
        }
        panel.rule_y(canvas, &ticks(panel.y, 8));
        let over = chart.over.map_or("", |p| p.name());
        frame(
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
            let at = panel.right_of(rpm(0.5 * (widest.from + widest.to) / chart.base));
            canvas.text(&t.name, (at, TOP - 8.0), SMALL, BLACK, Anchor::Middle);
        }
        canvas.text(
            "growth",
            (WIDTH - RIGHT + 14.0, TOP - 8.0),
            SMALL,
            BLACK,
            Anchor::Start,
        );
        for shade in 0..SHADES {
            let down = TOP + 8.0 + 22.0 * shade as f64;
            let left = WIDTH - RIGHT + 14.0;
            canvas.block((left, down + 14.0), (left + 14.0, down), shaded(shade));
            let per_cent = 100.0 * 10f64.powf(scale.1 - shade as f64);
            let text = format!("{} %", super::style::significant(per_cent, 2));
            canvas.text(
                &text,
                (left + 20.0, down + 7.0),
                SMALL,
                BLACK,
                Anchor::Start,
            );
        }
    })
}

/// Decades of growth told apart.
const SHADES: usize = 4;

fn shaded(shade: usize) -> Ink {
    (0..shade).fold(ORANGE, |ink, _| paler(ink))
}
