//! Motion in time as JSON, CSV and a picture.

use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::axes::{frame, runs, span};
use super::json::{header, warnings};
use super::style::{Anchor, BLACK, BLUE, Panel, SMALL, Stroke, TITLE, WIDTH, picture, ticks};
use crate::base::error::Warning;
use crate::base::place::Source;
use crate::motion::meter::Balance;
use crate::motion::outputs::Output;
use crate::motion::problem::Effort;
use crate::plan::motion::choice::Choice;
use crate::plan::motion::reading::step;
use crate::plan::motion::run::Motion;
use crate::plan::motion::scene::MotionScene;

/// Key of an output: its name and its unit in letters.
pub fn key(output: &Output) -> String {
    let unit = match output.unit {
        "rad/s" => "rad_s",
        "m/s" => "m_s",
        "rad/s²" => "rad_s2",
        "m/s²" => "m_s2",
        "N·m" => "nm",
        "N" => "n",
        other => other,
    };
    format!("{}_{unit}", output.name)
}

/// The document of a motion.
pub fn json(
    sources: &[Arc<Source>],
    scene: &MotionScene,
    choice: &Choice,
    motion: &Motion,
    step_at: Option<f64>,
    doubts: &[Warning],
) -> Value {
    let mut outputs = Map::new();
    let mut readings = Map::new();
    let kept = !motion.time.is_empty();
    let lists = scene.outputs.list.iter().zip(&motion.values);
    for ((output, values), reading) in lists.zip(&motion.readings) {
        outputs.insert(key(output), json!(values));
        let answer = step_at.and_then(|at| step(&motion.time, values, at)).map(|a| {
            json!({
                "before": a.before, "after": a.after, "overshoot": a.overshoot.0, "overshoot_after_s": a.overshoot.1,
                "rise_s": a.rise_s, "settling_s": a.settling_s, "oscillations": a.oscillations,
            })
        });
        let reading = reading.map(|r| {
            json!({
                "end": r.end, "least": r.least.0, "least_at_s": r.least.1, "greatest": r.greatest.0, "greatest_at_s": r.greatest.1,
                "mean": r.mean, "rms_about_mean": r.rms, "step": answer,
            })
        });
        readings.insert(key(output), json!(reading));
    }
    json!({
        "geardyn": header(sources, &["equations", "start", choice.method.name]),
        "method": choice.method.name,
        "reason": choice.reason,
        "interrupted": motion.interrupted,
        "time_s": kept.then_some(&motion.time),
        "outputs": kept.then_some(outputs),
        "readings": readings,
        "effort": effort(&motion.effort, motion.seconds),
        "energy_balance": motion.balance.as_ref().map(balance),
        "warnings": warnings(doubts),
    })
}

/// What a run cost.
pub fn effort(effort: &Effort, seconds: f64) -> Value {
    json!({
        "run_time_s": seconds, "steps": effort.steps, "rejected": effort.rejected, "rhs_evaluations": effort.evaluations,
        "jacobians": effort.jacobians, "factorisations": effort.factorisations, "events": effort.events, "grazed": effort.grazed,
        "linear_machines": effort.machines,
    })
}

fn balance(balance: &Balance) -> Value {
    let told = |x: f64| balance.given_up.is_none().then_some(x);
    json!({
        "stored_before_j": balance.before, "stored_after_j": told(balance.after), "put_in_j": told(balance.put_in),
        "lost_j": told(balance.lost), "gap": told(balance.gap()), "gap_uncertainty": balance.doubt(), "readings": balance.readings,
    })
}

/// One row an instant, one column an output.
pub fn csv(scene: &MotionScene, motion: &Motion) -> String {
    let names = scene
        .outputs
        .list
        .iter()
        .map(|o| format!("{} [{}]", o.name, o.unit));
    let mut text = ["time [s]".to_string()]
        .into_iter()
        .chain(names)
        .map(|n| super::csv::quoted(&n))
        .collect::<Vec<_>>()
        .join(",");
    text.push('\n');
    for (k, t) in motion.time.iter().enumerate() {
        text += &format!("{t}");
        for values in &motion.values {
            text += &format!(",{}", values[k]);
        }
        text.push('\n');
    }
    text
}

const LEFT: f64 = 84.0;
const HIGH: f64 = 150.0;
const GAP: f64 = 26.0;

/// Outputs over time, one panel each.
pub fn draw(title: &str, scene: &MotionScene, motion: &Motion) -> String {
    let count = scene.outputs.list.len();
    let top = 40.0;
    picture(WIDTH, top + count as f64 * (HIGH + GAP) + 30.0, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let end = motion.time.last().copied().unwrap_or(0.0);
        for (at, (output, values)) in scene.outputs.list.iter().zip(&motion.values).enumerate() {
            let down = top + at as f64 * (HIGH + GAP);
            let Some(y) = span(values.iter().copied()) else {
                continue;
            };
            let x = (0.0, if end > 0.0 { end } else { 1.0 });
            let panel = Panel {
                across: (LEFT, WIDTH - 24.0),
                down: (down, down + HIGH),
                x,
                y,
            };
            panel.rule_y(canvas, &ticks(y, 4));
            let below = (at + 1 == count).then_some("time, s");
            frame(&panel, canvas, output.unit, below);
            canvas.text(
                &output.name,
                (LEFT + 6.0, down - 8.0),
                SMALL,
                BLACK,
                Anchor::Start,
            );
            for run in runs(
                &panel,
                motion.time.iter().copied().zip(values.iter().copied()),
            ) {
                canvas.path(&run, BLUE, 0.9, Stroke::Solid);
            }
        }
    })
}
