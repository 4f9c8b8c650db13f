//! Motion in time as JSON, CSV and a plot.

use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::axes::{clip_to_panel, draw_frame, linear_range};
use super::json::{header, warnings};
use super::svg::{
    Anchor, BLACK, BLUE, LABEL_SIZE, LineStyle, Panel, TITLE_SIZE, WIDTH, render_svg, ticks,
};
use crate::base::error::Diagnostic;
use crate::base::source_span::SourceFile;
use crate::motion::energy_balance::EnergyBalance;
use crate::motion::outputs::MotionOutput;
use crate::motion::problem::IntegrationStats;
use crate::plan::motion::method_choice::MethodChoice;
use crate::plan::motion::output_statistics::step_response;
use crate::plan::motion::run::MotionHistory;
use crate::plan::motion::simulation_setup::SimulationSetup;

/// Key of an output: its name and its unit in letters.
pub fn key(output: &MotionOutput) -> String {
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
    sources: &[Arc<SourceFile>],
    scene: &SimulationSetup,
    choice: &MethodChoice,
    history: &MotionHistory,
    step_at: Option<f64>,
    doubts: &[Diagnostic],
) -> Value {
    let mut outputs = Map::new();
    let mut readings = Map::new();
    let kept = !history.time.is_empty();
    let lists = scene.outputs.list.iter().zip(&history.values);
    for ((output, values), reading) in lists.zip(&history.statistics) {
        outputs.insert(key(output), json!(values));
        let answer = step_at.and_then(|at| step_response(&history.time, values, at)).map(|a| {
            json!({
                "before": a.initial_value, "after": a.final_value, "overshoot": a.overshoot.0, "overshoot_after_s": a.overshoot.1,
                "rise_s": a.rise_s, "settling_s": a.settling_s, "oscillations": a.oscillations,
            })
        });
        let reading = reading.map(|r| {
            json!({
                "end": r.end, "least": r.min.0, "least_at_s": r.min.1, "greatest": r.max.0, "greatest_at_s": r.max.1,
                "mean": r.mean, "rms_about_mean": r.rms, "step": answer,
            })
        });
        readings.insert(key(output), json!(reading));
    }
    json!({
        "geardyn": header(sources, &["equations", "start", choice.method.name]),
        "method": choice.method.name,
        "reason": choice.reason,
        "interrupted": history.interrupted,
        "time_s": kept.then_some(&history.time),
        "outputs": kept.then_some(outputs),
        "readings": readings,
        "effort": effort(&history.stats, history.seconds),
        "energy_balance": history.balance.as_ref().map(energy_balance_json),
        "warnings": warnings(doubts),
    })
}

/// Cost of a run.
pub fn effort(stats: &IntegrationStats, seconds: f64) -> Value {
    json!({
        "run_time_s": seconds, "steps": stats.steps, "rejected": stats.rejected, "rhs_evaluations": stats.evaluations,
        "jacobians": stats.jacobians, "factorisations": stats.factorisations, "events": stats.events, "grazed": stats.grazings,
        "linear_machines": stats.regimes,
    })
}

fn energy_balance_json(balance: &EnergyBalance) -> Value {
    let told = |x: f64| balance.stopped_at.is_none().then_some(x);
    json!({
        "stored_before_j": balance.before, "stored_after_j": told(balance.after), "put_in_j": told(balance.work_in),
        "lost_j": told(balance.dissipated), "gap": told(balance.relative_error()), "gap_uncertainty": balance.error_bound(), "readings": balance.evaluations,
    })
}

/// One row an instant, one column an output.
pub fn csv(scene: &SimulationSetup, history: &MotionHistory) -> String {
    let names = scene
        .outputs
        .list
        .iter()
        .map(|o| format!("{} [{}]", o.name, o.unit));
    let mut text = ["time [s]".to_string()]
        .into_iter()
        .chain(names)
        .map(|n| super::modes_csv::csv_field(&n))
        .collect::<Vec<_>>()
        .join(",");
    text.push('\n');
    for (k, t) in history.time.iter().enumerate() {
        text += &format!("{t}");
        for values in &history.values {
            text += &format!(",{}", values[k]);
        }
        text.push('\n');
    }
    text
}

const MARGIN_LEFT: f64 = 84.0;
const HEIGHT: f64 = 150.0;
const SPACING: f64 = 26.0;

/// Outputs over time, one panel each.
pub fn draw(title: &str, scene: &SimulationSetup, history: &MotionHistory) -> String {
    let count = scene.outputs.list.len();
    let top = 40.0;
    render_svg(
        WIDTH,
        top + count as f64 * (HEIGHT + SPACING) + 30.0,
        |canvas| {
            canvas.text(title, (MARGIN_LEFT, 16.0), TITLE_SIZE, BLACK, Anchor::Start);
            let end = history.time.last().copied().unwrap_or(0.0);
            for (at, (output, values)) in scene.outputs.list.iter().zip(&history.values).enumerate()
            {
                let down = top + at as f64 * (HEIGHT + SPACING);
                let Some(y) = linear_range(values.iter().copied()) else {
                    continue;
                };
                let x = (0.0, if end > 0.0 { end } else { 1.0 });
                let panel = Panel {
                    across: (MARGIN_LEFT, WIDTH - 24.0),
                    down: (down, down + HEIGHT),
                    x,
                    y,
                };
                panel.draw_y_grid(canvas, &ticks(y, 4));
                let below = (at + 1 == count).then_some("time, s");
                draw_frame(&panel, canvas, output.unit, below);
                canvas.text(
                    &output.name,
                    (MARGIN_LEFT + 6.0, down - 8.0),
                    LABEL_SIZE,
                    BLACK,
                    Anchor::Start,
                );
                for run in clip_to_panel(
                    &panel,
                    history.time.iter().copied().zip(values.iter().copied()),
                ) {
                    canvas.polyline(&run, BLUE, 0.9, LineStyle::Solid);
                }
            }
        },
    )
}
