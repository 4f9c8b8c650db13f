//! Periodic motions over speed as JSON, CSV and a picture.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use serde_json::{Value, json};

use super::json::{complex, header, stages, warnings};
use super::jump_curve::{JumpCurve, jump_curve};
use super::style::significant;
use crate::base::place::Source;
use crate::plan::response::harmonic_balance::Answer;
use crate::plan::stages::Verdict;
use crate::response::harmonic::point::{Found, Point};
use crate::response::harmonic::special::{Kind, Special};

/// rpm of rad/s.
pub(super) fn rpm(speed: f64) -> f64 {
    speed * 30.0 / PI
}

/// The name of what happens.
pub(super) fn named(kind: Kind) -> &'static str {
    match kind {
        Kind::Fold => "fold",
        Kind::PeriodDoubling => "period doubling",
        Kind::NeimarkSacker => "Neimark–Sacker",
        Kind::Branching => "branching",
    }
}

/// The document.
pub fn json(sources: &[Arc<Source>], answer: &Answer) -> Value {
    let trace: Vec<&str> = answer
        .plan
        .iter()
        .filter(|r| matches!(r.1, Verdict::Runs(_)))
        .map(|r| r.0)
        .collect();
    let special = |(s, jump): (&Special, &Option<f64>)| {
        let mut value = motion(answer, &s.point);
        value["kind"] = json!(named(s.kind));
        value["rising_speed"] = json!(s.point.sense > 0.0);
        value["after_point"] = json!(s.after);
        value["jumps_to"] = json!(jump);
        value
    };
    let tongues = match &answer.tongues {
        Ok(found) => json!(found.iter().map(|t| json!({
            "from_rpm": rpm(answer.speed(t.from)), "to_rpm": rpm(answer.speed(t.to)), "worst_rpm": rpm(answer.speed(t.worst)),
            "growth_per_period": t.growth, "name": t.name,
        })).collect::<Vec<_>>()),
        Err(why) => json!({ "left_out": why }),
    };
    json!({
        "geardyn": header(sources, &trace),
        "node": answer.node,
        "outputs": answer.outputs.iter().map(|(name, unit)| json!({ "name": name, "unit": unit })).collect::<Vec<_>>(),
        "nonlinear": answer.branches,
        "special": answer.curve.specials.iter().zip(&answer.jumps).map(special).collect::<Vec<_>>(),
        "points": answer.curve.points.iter().map(|p| motion(answer, p)).collect::<Vec<_>>(),
        "doubled": answer.curve.doubled.iter().map(|d| json!({
            "born_at_special": d.born,
            "points": d.points.iter().map(|p| motion(answer, p)).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "tongues": tongues,
        "complete": answer.curve.ended.is_none(),
        "effort": { "run_time_s": answer.seconds },
        "stages": stages(answer.plan.iter().map(|(name, verdict)| (*name, verdict))),
        "warnings": warnings(&answer.warnings),
    })
}

fn motion(answer: &Answer, p: &Point) -> Value {
    json!({
        "speed_rpm": rpm(answer.speed(p.omega)),
        "frequency_hz": p.omega / TAU,
        "stable": p.unstable() == 0,
        "multipliers": p.multipliers.iter().map(|&m| complex(m)).collect::<Vec<_>>(),
        "orders": p.orders,
        "left_out": p.left_out,
        "found_by": found(p),
        "outputs": p.outputs.iter().map(|o| json!({
            "amplitude": o.amplitude(), "mean": o.mean, "max": o.max, "min": o.min, "rms": o.rms,
        })).collect::<Vec<_>>(),
    })
}

fn found(p: &Point) -> &'static str {
    match p.found {
        Found::Events => "events",
        Found::Orders => "orders",
    }
}

/// One row a motion, along the curve.
pub fn csv(answer: &Answer) -> String {
    let mut head: Vec<String> = [
        "speed [rpm]",
        "frequency [Hz]",
        "stable",
        "largest multiplier",
        "orders",
        "left out",
        "found by",
        "periods",
    ]
    .map(str::to_string)
    .to_vec();
    for (name, unit) in &answer.outputs {
        for part in ["amplitude", "mean", "max", "min", "rms"] {
            head.push(super::csv::quoted(&format!("{name} {part} [{unit}]")));
        }
    }
    let mut text = head.join(",") + "\n";
    let single = answer.curve.points.iter().map(|p| (p, 1));
    let doubled = answer.curve.doubled.iter().flat_map(|d| &d.points);
    for (p, periods) in single.chain(doubled.map(|p| (p, 2))) {
        let largest = p.multipliers.first().map_or(0.0, |m| m.norm());
        text += &format!(
            "{},{},{},{largest},{},{},{},{periods}",
            rpm(answer.speed(p.omega)),
            p.omega / TAU,
            p.unstable() == 0,
            p.orders,
            p.left_out,
            found(p)
        );
        for o in &p.outputs {
            text += &format!(
                ",{},{},{},{},{}",
                o.amplitude(),
                o.mean,
                o.max,
                o.min,
                o.rms
            );
        }
        text.push('\n');
    }
    text
}

/// The jump curve of the first output.
pub fn picture(title: &str, answer: &Answer) -> String {
    let (name, unit) = answer
        .outputs
        .first()
        .map_or(("", ""), |(n, u)| (n.as_str(), u));
    let amplitude = |p: &Point| p.outputs.first().map_or(0.0, |o| o.amplitude());
    let (factor, unit) = scaled(
        answer
            .curve
            .points
            .iter()
            .chain(answer.curve.doubled.iter().flat_map(|d| &d.points))
            .map(amplitude)
            .fold(0.0, f64::max),
        unit,
    );
    let at = |p: &Point| (rpm(answer.speed(p.omega)), factor * amplitude(p));
    let shown = |p: &Point| {
        let (x, y) = at(p);
        (x, y, p.unstable() == 0)
    };
    let mark = |s: &Special| {
        let (speed, height) = at(&s.point);
        (
            speed,
            height,
            format!("{} {}", named(s.kind), significant(speed, 5)),
        )
    };
    let jump = |(s, to): (&Special, &Option<f64>)| {
        let (speed, from) = at(&s.point);
        (s.kind == Kind::Fold).then_some((speed, from, factor * (*to)?))
    };
    let tongues = answer.tongues.as_ref().map_or(Vec::new(), |t| {
        t.iter()
            .map(|t| {
                (
                    rpm(answer.speed(t.from)),
                    rpm(answer.speed(t.to)),
                    t.name.clone(),
                )
            })
            .collect()
    });
    jump_curve(&JumpCurve {
        title: title.to_string(),
        across: format!("speed of {}, rpm", answer.node),
        up: format!("{name}, half of peak to peak, {unit}"),
        points: along(answer).into_iter().map(shown).collect(),
        others: (answer.curve.doubled.iter())
            .map(|d| d.points.iter().map(shown).collect())
            .collect(),
        marks: answer.curve.specials.iter().map(mark).collect(),
        jumps: answer
            .curve
            .specials
            .iter()
            .zip(&answer.jumps)
            .filter_map(jump)
            .collect(),
        bands: tongues,
    })
}

/// Points with the folds among them, so that the line goes through these.
fn along(answer: &Answer) -> Vec<&Point> {
    let curve = &answer.curve;
    let mut all = Vec::with_capacity(curve.points.len() + curve.specials.len());
    for (at, p) in curve.points.iter().enumerate() {
        all.push(p);
        all.extend(
            curve
                .specials
                .iter()
                .filter(|s| s.after == at)
                .map(|s| &s.point),
        );
    }
    all
}

/// A unit in which the largest value is easily read.
pub(super) fn scaled(largest: f64, unit: &'static str) -> (f64, String) {
    let (factor, prefix) = match (largest, unit) {
        (x, "m" | "rad") if x < 1e-3 => (1e6, "µ"),
        (x, "m" | "rad") if x < 1.0 => (1e3, "m"),
        (x, "N" | "N·m") if x >= 1e4 => (1e-3, "k"),
        _ => (1.0, ""),
    };
    (factor, format!("{prefix}{unit}"))
}
